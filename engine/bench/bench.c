// bench.c - tables of benchmarks, and words in lists.
#include "engine/bench/bench.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/file.h"

const Culling BENCH_CULLING[BENCH_CULLINGS] = {CULL_NONE, CULL_DEPTH, CULL_CELLS, CULL_PLAN, CULL_STAB};

bool bench_table(const BenchArguments *a, const char *head,
                 bool (*first)(const BenchArguments *arguments, Text *csv, Error *error),
                 bool (*each)(const char *file, const BenchArguments *arguments, Text *csv, Error *error),
                 Error *error) {
    Arena arena = {0};
    Text csv = {.arena = &arena};
    text_append(&csv, "%s", head);
    fputs(head, stdout);
    bool good = !first || first(a, &csv, error);
    for (int i = 0; i < a->file_count && good; i++) good = each(a->files[i], a, &csv, error);
    if (good && a->csv) good = file_write(a->csv, csv.data, csv.size, error);
    arena_free(&arena);
    return good;
}

const char *bench_name(const char *file) {
    const char *slash = strrchr(file, '/');
    return slash ? slash + 1 : file;
}

bool bench_listed(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && *at; at += strcspn(at, ","), at += *at == ',')
        if (strcspn(at, ",") == length && strncmp(at, word, length) == 0) return true;
    return !list;
}
