// fuzz_vis.c - libFuzzer on the .vis reader, with a building of two rooms made once: a file is refused with a sentence,
// or it holds trees and sets that a query can walk. The first byte says what the others are: the file itself, the file
// behind a head that is put right, or changes to a valid file whose checksum is put right. So neither hashes nor the
// checksum keep the fuzzer from what lies behind them.
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "maps/maps.h"
#include "visibility/vis.h"

extern const MapsReader MAPS_READER_PLAN;
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

// Where the head of vis_file.c has its checksum, and where the head ends.
enum { CHECKSUM = 32, HEAD = 56 };
static const char PLAN[] = "plan 1\nmaterial red #FF0000\nstorey s floor 0 height 3\n"
                           "room a 0,0 4,0 4,4 0,4 wall 0.2\nroom b 4.2,0 8,0 8,4 4.2,4 wall 0.2\n"
                           "door d 4.1,2 angle 90 width 1 height 2 material red\n";

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    Bytes valid;  // what vis_save wrote
    int file;     // in memory
    char path[64];
} Made;

static void make(Made *m) {
    Error error;
    unsigned char *text = (unsigned char *)arena_string(&m->arena, PLAN);
    VisOptions options = vis_default_options();
    options.threads = 1;
    StabForest forest;
    char place[] = "/tmp/enfilade-fuzz-XXXXXX";
    int saved = mkstemp(place);
    m->file = memfd_create("fuzz.vis", 0);
    bool good =
        saved >= 0 && m->file >= 0 &&
        MAPS_READER_PLAN.read("fuzz.plan", (Bytes){text, sizeof PLAN - 1}, &m->arena, &m->building, &error) &&
        vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error) &&
        vis_build_forest(&m->graph, &options, NULL, &m->arena, &forest) &&
        vis_save(place, &m->graph, &forest, &error) &&
        file_read(place, 1 << 20, &m->arena, &m->valid, &error);
    if (saved >= 0) {
        close(saved);
        unlink(place);
    }
    if (!good) abort();
    snprintf(m->path, sizeof m->path, "/proc/self/fd/%d", m->file);
}

// All cells from the middle of each, through trees, sets and neither.
static void walk(const Made *m, const StabForest *forest, Arena *arena) {
    VisQuery *query = vis_query_new(&m->graph, forest, arena);
    for (int c = 0; c < m->graph.cell_count; c++) {
        Box box = m->graph.cells[c].box;
        Eye eye = {.position = vec3_scale(vec3_add(box.min, box.max), 0.5)};
        for (int method = 0; method < VIS_METHODS; method++)
            vis_query(query, &eye, vis_locate(&m->graph, eye.position, c), NULL, (VisMethod)method);
    }
}

// The file that the fuzzer's bytes stand for.
static Bytes file_of(const Made *m, const unsigned char *data, size_t size, Arena *arena) {
    enum { AS_IT_IS, BEHIND_HEAD, CHANGES, KINDS };
    int kind = size > 0 ? data[0] % KINDS : AS_IT_IS;
    size_t given = size > 0 ? size - 1 : 0, length = given;
    if (kind == CHANGES && length < m->valid.size) length = m->valid.size;
    unsigned char *file = arena_alloc(arena, length + 1, 1);
    if (kind == CHANGES) memcpy(file, m->valid.data, m->valid.size);
    for (size_t i = 0; i < given; i++) file[i] ^= data[i + 1];
    if (kind == BEHIND_HEAD && length >= CHECKSUM) memcpy(file, m->valid.data, CHECKSUM);
    if (kind != AS_IT_IS && length >= HEAD) {
        uint64_t sum = file_hash(file + HEAD, length - HEAD, 0);
        memcpy(file + CHECKSUM, &sum, sizeof sum);
    }
    return (Bytes){file, length};
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static Made made;
    if (!made.valid.data) make(&made);
    Arena arena = {0};
    Bytes file = file_of(&made, data, size, &arena);
    if (ftruncate(made.file, 0) != 0 || pwrite(made.file, file.data, file.size, 0) != (ssize_t)file.size)
        abort();
    StabForest forest;
    Error error = {""};
    if (vis_load(made.path, &made.graph, &arena, &forest, &error))
        walk(&made, &forest, &arena);
    else if (error.text[0] == 0)
        abort();
    arena_free(&arena);
    return 0;
}
