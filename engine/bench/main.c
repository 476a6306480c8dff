// main.c - the program `enfilade-bench`: tables of measurements, a benchmark a row of the table below.
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "engine/bench/bench.h"
#include "engine/core/parallel.h"

extern const Bench BENCH_WALK, BENCH_COLLISION, BENCH_VISIBILITY, BENCH_FORMFACTORS, BENCH_RADIOSITY,
    BENCH_LIGHT, BENCH_LIT_PICTURES, BENCH_MESHES, BENCH_NARROW, BENCH_ROOMS, BENCH_ROOMS_LIGHT, BENCH_HIDDEN,
    BENCH_BREAKS, BENCH_RAYS, BENCH_RELIGHT, BENCH_PLANNER, BENCH_SCALE, BENCH_MODELS;
static const Bench *const BENCHES[] = {
    &BENCH_WALK,        &BENCH_COLLISION,    &BENCH_VISIBILITY, &BENCH_FORMFACTORS, &BENCH_RADIOSITY,
    &BENCH_LIGHT,       &BENCH_LIT_PICTURES, &BENCH_MESHES,     &BENCH_NARROW,      &BENCH_ROOMS,
    &BENCH_ROOMS_LIGHT, &BENCH_HIDDEN,       &BENCH_BREAKS,     &BENCH_RAYS,        &BENCH_RELIGHT,
    &BENCH_PLANNER,     &BENCH_SCALE,        &BENCH_MODELS};
enum { BENCH_COUNT = sizeof BENCHES / sizeof *BENCHES, MOST_ROWS = 24, MOST_USUAL = 12 };

static const char USUAL_FILES[] = "build/maps/office.plan";

// Options of every benchmark.
static const Option COMMON[] = {
    OPTION_MAP(BENCH_AT(load.map)),
    OPTION_MEMORY(BENCH_AT(load.memory), "what fits a file to open it, then three quarters of the machine's"),
};
enum { COMMON_COUNT = sizeof COMMON / sizeof *COMMON };

static void print_bench_help(void) {
    printf("usage: enfilade bench NAME [FILE ...] [OPTIONS]\n"
           "       enfilade-bench NAME [FILE ...] [OPTIONS]\n\n"
           "Measures, and writes CSV with a header on standard output (default FILE: %s).\n\n",
           USUAL_FILES);
    options_print_rows(COMMON, COMMON_COUNT, 2);
    for (int i = 0; i < BENCH_COUNT; i++) {
        const Bench *b = BENCHES[i];
        printf("\n  %-13s", b->name);
        options_print_paragraph(b->about, 15, 17);
        if (b->files) printf("                 (default FILES: %s)\n", b->files);
        options_print_rows(b->options, b->option_count, 4);
        if (b->print_methods) b->print_methods();
    }
}

static int misuse_name(const char *fault) {
    char names[256] = "";
    for (int i = 0; i < BENCH_COUNT; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", BENCHES[i]->name);
    }
    return app_misuse("bench", "bench: %s (allowed: %s)", fault, names);
}

// Names of methods, separated by commas.
static bool are_methods(const char *names, bool (*is_method)(const char *)) {
    char name[40];
    while (*names) {
        size_t length = strcspn(names, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, names);
        if (!is_method(name)) return false;
        names += length + (names[length] == ',');
    }
    return true;
}

static int measure_files(const Bench *bench, BenchArguments *a, char **files, int file_count) {
    if (a->methods && !are_methods(a->methods, bench->is_method))
        return app_misuse("bench", "bench: --methods is `%s` (`enfilade %s --help` lists those allowed)",
                          a->methods, bench->list ? bench->list : "bench");
    Error error;
    char usual[512], *word[MOST_USUAL];
    snprintf(usual, sizeof usual, "%s", bench->files ? bench->files : USUAL_FILES);
    if (file_count == 0) {
        for (char *at = strtok(usual, " "); at && file_count < MOST_USUAL; at = strtok(NULL, " "))
            word[file_count++] = at;
        files = word;
    }
    a->files = files;
    a->file_count = file_count;
    bool good = app_check_files(&a->csv, 1, (const char *const *)files, file_count, &a->load, &error);
    // One of the processes that share the work writes.
    if (!parallel_is_first()) a->csv = NULL;
    good = good && bench->run(a, &error);
    return good ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
}

// The words after the benchmark's name.
static int run_bench(const Bench *bench, int argc, char **argv) {
    BenchArguments a = {.load = app_scene_options(),
                        .size = {640, 360},
                        .frames = 200,
                        .steps = 100000,
                        .seed = 1,
                        .samples = 12,
                        .baked_rooms = 2000,
                        .cullings = "none,depth,stab",
                        .resolutions = {50, 71, 100, 141, 200},
                        .resolution_count = 5,
                        .shooters = 60,
                        .rays = 4000000};
    a.load.fill_lamps = bench->fill_lamps;
    Option rows[MOST_ROWS];
    int count = COMMON_COUNT + bench->option_count, first = 0;
    bool help = false;
    CORE_ASSERT(count <= MOST_ROWS);
    memcpy(rows, COMMON, sizeof COMMON);
    memcpy(rows + COMMON_COUNT, bench->options, (size_t)bench->option_count * sizeof *rows);
    OptionTable table = {.command = "bench", .rows = rows, .count = count};
    int code = options_parse(&table, argc, argv, &a, NULL, &first, &help);
    if (help) print_bench_help();
    if (code != APP_GOOD || help) return code;
    if ((code = app_check_day("bench", &a.load.day)) != APP_GOOD) return code;
    if (a.quick) a.shooters = 20, a.rays = 300000;
    return measure_files(bench, &a, argv + first, argc - first);
}

static int run_named(int argc, char **argv) {
    if (argc < 2) return misuse_name("which one?");
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_bench_help();
        return APP_GOOD;
    }
    if (argv[1][0] == '-')
        return app_misuse("bench", "bench: the benchmark's name comes before `%s`", argv[1]);
    for (int i = 0; i < BENCH_COUNT; i++)
        if (strcmp(BENCHES[i]->name, argv[1]) == 0) return run_bench(BENCHES[i], argc - 1, argv + 1);
    char fault[80];
    snprintf(fault, sizeof fault, "there is no benchmark `%.40s`", argv[1]);
    return misuse_name(fault);
}

int main(int argc, char **argv) { return app_main(argc, argv, run_named); }
