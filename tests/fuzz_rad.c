// fuzz_rad.c - libFuzzer on the .rad reader, with a building of one lit room made once: a file is refused with a sentence, or
// it holds light that can be gathered and shot on. The first byte says what the others are: the file itself, the file behind
// a head whose hashes are right, or changes to a valid file; of the last two the checksums are put right. So neither hashes
// nor checksums keep the fuzzer from what lies behind them.
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "maps/maps.h"
#include "radiosity/shoot.h"

extern const MapsReader MAPS_READER_PLAN;
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

// The head of rad_file.c: where its hashes end, where its checksums are, what the second one is of, and where it ends.
enum { HASHES = 32, BODY_SUM = 32, HEAD_SUM = 40, SUMMED = 48, HEAD = 152, VERSION = 1 };
static const char PLAN[] = "plan 1\nmaterial lamp #FFFFFF emission 12\nstorey s floor 0 height 3\n"
                           "room a 0,0 4,0 4,4 0,4 wall 0.2\n"
                           "room b 4.2,0 8,0 8,4 4.2,4 wall 0.2\n"
                           "door d 4.1,2 angle 90 width 1 height 2 material lamp\n";

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    Mesh mesh;
    float doors[4];
    Bytes valid;  // what rad_save wrote
    int file;     // in memory
    char path[64];
} Made;

static bool make_mesh(Made *m, Error *error) {
    unsigned char *text = (unsigned char *)arena_string(&m->arena, PLAN);
    VisOptions options = vis_default_options();
    MeshOptions mesh = {1.5, 2};
    options.threads = 1;
    return MAPS_READER_PLAN.read("fuzz.plan", (Bytes){text, sizeof PLAN - 1}, &m->arena, &m->building,
                                 error) &&
           vis_build_cells(&m->building, &options, &m->arena, &m->graph, error) &&
           vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest) &&
           mesh_build(&m->graph, NULL, m->doors, &mesh, &m->arena, &m->mesh, error);
}

static RadOptions few_shots(long long shots) {
    RadOptions options = rad_default_options();
    options.form_factor.resolution = 8;
    options.threads = 1;
    options.shots = shots;
    return options;
}

static void make(Made *m) {
    Error error;
    char place[] = "/tmp/enfilade-fuzz-XXXXXX";
    int saved = mkstemp(place);
    m->file = memfd_create("fuzz.rad", 0);
    RadSolution solution;
    bool good = saved >= 0 && m->file >= 0 && make_mesh(m, &error) &&
                rad_start(&m->mesh, &m->arena, &solution, &error);
    RadOptions options = few_shots(5);
    if (good) rad_shoot(&m->mesh, &m->forest, m->doors, &options, NULL, &solution);
    good = good && rad_save(place, &m->mesh, m->doors, &solution, &error) &&
           file_read(place, 1 << 20, &m->arena, &m->valid, &error);
    if (saved >= 0) {
        close(saved);
        unlink(place);
    }
    if (!good) abort();
    snprintf(m->path, sizeof m->path, "/proc/self/fd/%d", m->file);
}

static void put_sum(unsigned char *at, const unsigned char *from, size_t size, uint64_t seed) {
    uint64_t sum = file_hash(from, size, seed);
    memcpy(at, &sum, sizeof sum);
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
    if (kind == BEHIND_HEAD && length >= HASHES) memcpy(file, m->valid.data, HASHES);
    if (kind != AS_IT_IS && length >= HEAD) {
        put_sum(file + BODY_SUM, file + HEAD, length - HEAD, 0);
        put_sum(file + HEAD_SUM, file + SUMMED, HEAD - SUMMED, VERSION);
    }
    return (Bytes){file, length};
}

// Some more shots, and all that is there gathered into one sum: sums may overflow, but light is never below 0.
static void use(const Made *m, RadSolution *solution) {
    RadOptions options = few_shots(solution->shots < 1000 ? solution->shots + 3 : 1000);
    rad_shoot(&m->mesh, &m->forest, m->doors, &options, NULL, solution);
    for (int e = 0; e < solution->element_count; e++) {
        for (int c = 0; c < 3; c++)
            if (solution->radiosity[e][c] < 0) abort();
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static Made made;
    if (!made.valid.data) make(&made);
    Arena arena = {0};
    Bytes file = file_of(&made, data, size, &arena);
    if (ftruncate(made.file, 0) != 0 || pwrite(made.file, file.data, file.size, 0) != (ssize_t)file.size)
        abort();
    RadSolution solution;
    MeshOptions options;
    float doors[4];
    Error error = {""};
    if (rad_load(made.path, &made.mesh, made.doors, &arena, &solution, &error))
        use(&made, &solution);
    else if (error.text[0] == 0)
        abort();
    error.text[0] = 0;
    if (!rad_load_options(made.path, &made.building, &options, doors, &error) && error.text[0] == 0) abort();
    arena_free(&arena);
    return 0;
}
