// hostile_cost.c - what a file of hostile.h costs, in counts that are the same on every machine: `hostile_cost KIND [COUNT [SEED]]`
// opens it as `enfilade info` does, on one thread, with COUNT, twice and four times as many things (COUNT 0: the kind's own for this),
// and prints for each size the bytes of the file, edges of control flow run in our own code, calls of malloc, the peak of
// memory in use and what was said. Exit status 1 where a doubling multiplies edges, calls or memory by more than the kind's
// `growth`, or where a kind that must open is refused. `hostile_cost` alone goes through all kinds whose growth is told.
//
// Edges are counted by the compiler's -fsanitize-coverage=trace-pc (config=counted in the Makefile). Libraries are not compiled so;
// what they do shows in their calls of malloc.
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "maps/maps.h"
#include "tests/support/files/hostile.h"
#include "visibility/pairs/pairs.h"

#define UNCOUNTED __attribute__((no_sanitize_coverage))

typedef struct Cost {
    long long bytes;              // of the file
    long long edges[4];           // of reading, cells, pairs and trees
    long long calls, live, peak;  // of malloc; bytes in use
    bool open;
    char said[200];
} Cost;

static Cost cost;
static long long edges;

void __sanitizer_cov_trace_pc(void);
UNCOUNTED void __sanitizer_cov_trace_pc(void) { edges++; }

// ---- the C library's allocator, counted

void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);
void __libc_free(void *);

UNCOUNTED static void *taken(void *memory) {
    cost.calls++;
    cost.live += memory ? (long long)malloc_usable_size(memory) : 0;
    if (cost.live > cost.peak) cost.peak = cost.live;
    return memory;
}
UNCOUNTED static void given(void *memory) { cost.live -= memory ? (long long)malloc_usable_size(memory) : 0; }

UNCOUNTED void *malloc(size_t size) { return taken(__libc_malloc(size)); }
UNCOUNTED void *calloc(size_t count, size_t size) { return taken(__libc_calloc(count, size)); }
UNCOUNTED void *aligned_alloc(size_t alignment, size_t size) {
    return taken(__libc_memalign(alignment, size));
}
UNCOUNTED void *realloc(void *memory, size_t size) {
    given(memory);
    return taken(__libc_realloc(memory, size));
}
UNCOUNTED void free(void *memory) {
    given(memory);
    __libc_free(memory);
}

// ---- one file

static long long stage(void) {
    static long long before;
    long long since = edges - before;
    before = edges;
    return since;
}

static void open_building(const char *path) {
    Arena arena = {0}, scratch = {0};
    Building building;
    CellGraph graph;
    StabForest forest;
    Error error;
    VisOptions options = vis_default_options();
    options.threads = 1;
    stage();
    cost.open = maps_read(path, &arena, &building, &error);
    cost.edges[0] = stage();
    if (cost.open) cost.open = vis_build_cells(&building, &options, &arena, &graph, &error);
    cost.edges[1] = stage();
    if (!cost.open) {
        const char *name = strrchr(error.text, '/');
        snprintf(cost.said, sizeof cost.said, "%.190s", name ? name + 1 : error.text);
        return;
    }
    PairSet set;
    PairOptions pairs = {.threads = 1};
    pair_method_finest()->find(&graph, &pairs, NULL, &scratch, &set);
    cost.edges[2] = stage();
    CellRows known = cell_rows_of_matrix(set.seen, set.cell_count, &scratch);
    options.known = &known;
    vis_build_forest(&graph, &options, NULL, &arena, &forest);
    cost.edges[3] = stage();
    int bounded = 0;
    for (int i = 0; i < graph.cell_count; i++) bounded += forest.bounded[i];
    snprintf(cost.said, sizeof cost.said, "%d cells, %d portals, %d nodes, %d trees bounded, %d notes",
             graph.cell_count, graph.portal_count, forest.node_count, bounded, building.note_count);
}

// In a process of its own, so that nothing is left of it. False when that process does not end well.
static bool measure(const HostileKind *kind, int count, uint64_t seed, Cost *out) {
    char path[64];
    int ends[2];
    snprintf(path, sizeof path, "/tmp/hostile-%d%s", (int)getpid(), kind->suffix);
    if (!hostile_write(kind, count, seed, path) || pipe(ends) != 0) return false;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        FILE *file = fopen(path, "r");
        fseek(file, 0, SEEK_END);
        cost = (Cost){.bytes = ftell(file)};
        fclose(file);
        open_building(path);
        _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
    }
    close(ends[1]);
    int status = 1;
    bool good = child > 0 && read(ends[0], out, sizeof *out) == sizeof *out;
    if (child > 0) waitpid(child, &status, 0);
    close(ends[0]);
    unlink(path);
    return good && status == 0;
}

// ---- growth

static long long all_edges(const Cost *c) { return c->edges[0] + c->edges[1] + c->edges[2] + c->edges[3]; }

static bool grows(const char *kind, const char *what, const long long *of, double most) {
    // Over both doublings, and from the second size, where what is fixed counts less.
    double last = (double)of[2] / (double)of[1], both = (double)of[2] / (double)of[0];
    if (last <= most && both <= most * most) return false;
    printf("%s: %s grow from %lld to %lld and %lld: by more than %.2f a doubling\n", kind, what, of[0], of[1],
           of[2], most);
    return true;
}

static bool check(const HostileKind *kind, int count, uint64_t seed) {
    double most = kind->growth > 0 ? kind->growth : 2.6;
    if (count <= 0) count = kind->few > 0 ? kind->few : kind->count / 160 > 12 ? kind->count / 160 : 12;
    long long edge[3], calls[3], peak[3];
    bool good = true;
    for (int k = 0; k < 3; k++) {
        Cost c;
        if (!measure(kind, count << k, seed, &c)) {
            printf("%s: %d things end the program\n", kind->name, count << k);
            return false;
        }
        edge[k] = all_edges(&c);
        calls[k] = c.calls;
        peak[k] = c.peak;
        printf("%-20s %6d %8lld bytes, edges %11lld (read %lld cells %lld pairs %lld trees %lld), %lld "
               "calls, %.1f MB: %s\n",
               kind->name, count << k, c.bytes, edge[k], c.edges[0], c.edges[1], c.edges[2], c.edges[3],
               calls[k], (double)peak[k] / 1e6, c.said);
        if (c.open || kind->may_refuse) continue;
        printf("%s: %d things are refused\n", kind->name, count << k);
        good = false;
    }
    if (grows(kind->name, "edges", edge, most)) good = false;
    // Arenas and lists ask for twice as much each time: a step more or less shows.
    enum { STEP = 2 };
    if (grows(kind->name, "calls of malloc", calls, most * STEP)) good = false;
    if (grows(kind->name, "bytes in use", peak, most * STEP)) good = false;
    return good;
}

int main(int argc, char **argv) {
    const HostileKind *only = argc > 1 ? hostile_find(argv[1]) : NULL;
    if (argc > 4 || (argc > 1 && !only)) {
        fputs("usage: hostile_cost [KIND [COUNT [SEED]]]\n", stderr);
        return 2;
    }
    int count = argc > 2 ? atoi(argv[2]) : 0;
    uint64_t seed = argc > 3 ? (uint64_t)atoll(argv[3]) : 1;
    bool good = true;
    if (only) return check(only, count, seed) ? 0 : 1;
    for (const HostileKind *kind = HOSTILE_KINDS; kind->name; kind++)
        if (kind->growth >= 0) good = check(kind, 0, seed) && good;
    return good ? 0 : 1;
}
