// bench.h - benchmarks: each measures buildings and writes CSV with a header on standard output. One file and one row in
// the table of cmd_bench.c each.
#ifndef APP_BENCH_H
#define APP_BENCH_H

#include "engine/app/app.h"
#include "engine/walk/walk_renderer.h"

typedef struct BenchArguments {
    char **files;
    int file_count;
    int width, height, frames;  // of pictures
    WalkLook look;
    int steps;  // of a walk
    uint64_t seed;
} BenchArguments;

bool bench_walk(const BenchArguments *arguments, Error *error);
bool bench_collision(const BenchArguments *arguments, Error *error);

const char *bench_name(const char *file);  // of a building in the CSV: without its folder

#endif
