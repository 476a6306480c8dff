// bench_models.c - from the file of a building model to the meshes of its products, beside a program of others that does the same.
// Every measurement has a process of its own.
#include <stdio.h>

#include "engine/bench/apart.h"
#include "engine/bench/bench.h"
#include "engine/bench/peer.h"
#include "engine/core/clock.h"
#include "maps/ifc/ifc.h"
#include "maps/maps.h"

static const char HEAD[] =
    "file,method,threads,mb,products,polygons,notes,seconds,cpu_seconds,peak_mb,note\n";

enum { METHODS = 2 };
// Threads of a method; 0: as many as there are processors.
static const int THREADS[METHODS] = {1, 0};
static const char *const NAMES[METHODS] = {"one-thread", "all-threads"};

// One reading of a file, in shared memory.
typedef struct Reading {
    const char *file;
    int threads;
    double mb, seconds;
    ApartUsage usage;
    int products, notes;
    long long polygons;
    bool good;
    Error error;
} Reading;

static void read_apart(void *context) {
    Reading *r = context;
    // As the program reads models (maps/ifc_building/ifc_building.c).
    Arena arena = {.dense = true};
    Bytes content;
    IfcModel model;
    IfcOptions options = ifc_default_options();
    options.threads = r->threads;
    double start = clock_seconds();
    r->good = file_read_by(r->file, MAPS_LARGEST_FILE, r->threads, &arena, &content, &r->error) &&
              ifc_read(r->file, content, &options, &arena, &model, &r->error);
    r->seconds = clock_seconds() - start;
    r->usage = apart_usage();
    if (r->good) {
        r->mb = (double)content.size / 1e6;
        r->products = model.product_count;
        r->polygons = model.polygon_count;
        r->notes = model.note_count;
    }
    arena_free(&arena);
}

typedef struct PeerJob {
    const char *program, *file;
    PeerUsage *out;
} PeerJob;

static bool run_program(const char *folder, void *context, Arena *arena, Error *error) {
    const PeerJob *job = context;
    const char *words[] = {job->program, job->file, NULL};
    return peer_run(words, folder, arena, job->out, error);
}

static void add_peer(const char *file, double mb, const BenchArguments *a, Arena *arena, Text *csv) {
    PeerUsage usage;
    Error why;
    PeerJob job = {a->peer, file, &usage};
    text_append(csv, "%s,peer,,%.2f,,,,", bench_name(file), mb);
    if (peer_in_folder(run_program, &job, arena, &why))
        text_append(csv, "%.4f,%.4f,%.1f,%s\n", usage.wall_seconds, usage.cpu_seconds, usage.peak_mb,
                    bench_name(a->peer));
    else
        text_append(csv, ",,,\"%s\"\n", why.text);
}

static bool add_rows(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    size_t before = csv->size;
    Reading *r = apart_memory(sizeof *r);
    bool good = true;
    for (int i = 0; i < METHODS && good; i++) {
        if (!bench_listed(a->methods, NAMES[i])) continue;
        *r = (Reading){.file = file, .threads = THREADS[i]};
        good = apart_run(read_apart, r, bench_name(file), error) &&
               (r->good || error_set(error, "%.1000s", r->error.text));
        if (good)
            text_append(csv, "%s,%s,%d,%.2f,%d,%lld,%d,%.4f,%.4f,%.1f,\n", bench_name(file), NAMES[i],
                        THREADS[i], r->mb, r->products, r->polygons, r->notes, r->seconds,
                        r->usage.cpu_seconds, r->usage.peak_mb);
    }
    Arena arena = {0};
    if (good && a->peer) add_peer(file, r->mb, a, &arena, csv);
    arena_free(&arena);
    apart_memory_free(r, sizeof *r);
    if (csv->size > before) fputs(csv->data + before, stdout);
    fflush(stdout);
    return good;
}

static bool measure_models(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, add_rows, error);
}

static bool is_reading(const char *name) { return bench_listed("one-thread,all-threads", name); }

static void print_methods(void) { printf("    methods: one-thread, all-threads\n"); }

static const Option ROWS[] = {
    BENCH_METHODS("some of the methods (default: all)"),
    {.name = "peer",
     .value = "PROGRAM",
     .type = OPTION_TEXT,
     .at = BENCH_AT(peer),
     .help = "a row for a program of others, which is given FILE and makes the meshes of all its products"},
    BENCH_CSV,
};

const Bench BENCH_MODELS = {
    .name = "models",
    .about = "building models (.ifc): time and memory from the file to the meshes of all products, on one "
             "thread and on all",
    BENCH_OPTIONS(ROWS),
    .run = measure_models,
    .is_method = is_reading,
    .print_methods = print_methods,
    .files = "build/maps/storeys-100.ifc",
};
