// bench.h - benchmarks: each measures buildings and writes CSV with a header on standard output. One file, and one row in
// the table of cmd_bench.c, each.
#ifndef APP_BENCH_H
#define APP_BENCH_H

#include "engine/app/app.h"
#include "engine/core/text.h"
#include "engine/draw/walk_renderer.h"

typedef struct BenchArguments {
    char **files;
    int file_count;
    const char *map;            // of files that hold several; NULL: the first
    int width, height, frames;  // of pictures
    WalkLook look;
    int steps;  // of a walk
    uint64_t seed;
    const char *methods;   // of those there are, separated by commas; NULL: all
    int samples;           // points on each portal for the lower bound; 0: none
    const char *peer;      // an external compiler, or NULL
    double seconds;        // after which a method is stopped; 0: when done
    const char *csv;       // where the table goes besides, or NULL
    const char *cullings;  // of views, separated by commas; NULL: all
    int resolutions[16], resolution_count;
    int shooters;
    int rays;              // of the reference, a shooter
    int points;            // at which light is compared; 0: what the benchmark likes
    double error;          // standard error of the truth there, relative; 0: what the benchmark likes
    double sky[3];         // radiance, W/m^2/sr a channel
    bool verbose;          // the worst points on standard error
    const char *pictures;  // a folder for those that go with a table, or NULL
} BenchArguments;

// Usual for what measures light.
#define BENCH_LIT_FILES "build/maps/office-plain.plan build/maps/house.plan"

// A benchmark: a row of the table.
typedef struct Bench {
    const char *name, *help;  // help: what it measures, and its options, lines that end
    bool (*run)(const BenchArguments *arguments, Error *error);
    bool (*knows)(const char *method);  // of --methods; NULL: it has none
    const char *list;                   // the command whose help lists them
    void (*print_methods)(void);        // the end of the help, where no command lists them; NULL: nothing
    const char *files;  // measured unless others are given, separated by blanks; NULL: the office
} Bench;

// Adds the rows of one building to the table, and prints them.
typedef bool BenchFile(const char *file, const BenchArguments *arguments, Text *csv, Error *error);
// A table: its head, the rows of `first` (NULL: none), and those of each file; on standard output, and whole to
// arguments->csv, if that is given.
bool bench_table(const BenchArguments *arguments, const char *head,
                 bool (*first)(const BenchArguments *arguments, Text *csv, Error *error), BenchFile *each,
                 Error *error);

const char *bench_name(const char *file);  // of a building in the CSV: without its folder
// Is the word among those of `list`, separated by commas? NULL: any is.
bool bench_listed(const char *list, const char *word);

#endif
