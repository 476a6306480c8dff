// fuzz_rad.c - libFuzzer on the .rad reader: a file is refused with a sentence, or it holds light that can be shot on.
#include <stdlib.h>

#include "radiosity/follow/each_lamp.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "tests/fuzz/store_target.h"

enum { HEADER = 352 };  // bytes, of rad_file.c

typedef struct Made {
    StoreTarget target;
    Mesh mesh;
    float doors[4];
} Made;

static RadOptions few_shots(long long shots) {
    RadOptions options = rad_default_options();
    options.form_factor.resolution = 8;
    options.threads = 1;
    options.shots = shots;
    return options;
}

// One lamp, whose light is all light, as far as the file knows.
static void tell_lamp(RadSolution *s, Arena *arena) {
    static const Rgb FULL[] = {{1, 1, 1}};
    LampLight *each = ARENA_ARRAY(arena, LampLight, 1);
    each->radiosity = sparse_light_new(s->radiosity, NULL, s->element_count, 0, arena);
    each->direct = sparse_light_new(s->direct, NULL, s->element_count, 0, arena);
    each->straight = sparse_light_new(s->node, NULL, s->node_count, 0, arena);
    each->rest = sparse_light_new(s->rest, NULL, s->node_count, 0, arena);
    s->lit = FULL;
    s->lamp_count = s->each_count = 1;
    s->each = each;
}

static void make(Made *m) {
    StoreTarget *t = &m->target;
    static unsigned char BITS[] = {0xad, 0x6b, 0x5d, 0x11, 0xff, 0x83};
    static const MeshSplits SPLITS = {.bit_count = 8 * sizeof BITS, .bits = BITS};
    MeshOptions mesh = {.element = 1.5, .per_patch = 2, .close = 0.05, .splits = &SPLITS};
    RadOptions options = few_shots(5);
    RadSolution solution;
    store_target_start(t);
    if (!mesh_build(&t->graph, m->doors, &mesh, &t->arena, &m->mesh, NULL) ||
        !rad_start(&m->mesh, &t->arena, &solution, NULL))
        abort();
    rad_shoot(&m->mesh, &t->forest, m->doors, &options, NULL, &solution);
    if (!direct_show(&m->mesh, &t->forest, m->doors, 1, NULL, &t->arena, &solution, NULL)) abort();
    tell_lamp(&solution, &t->arena);
    if (!rad_save(t->saved, &m->mesh, m->doors, &solution, NULL)) abort();
    store_target_keep(t);
    store_target_put_valid(t);
    if (!rad_load(t->path, &m->mesh, m->doors, &t->arena, &solution, NULL)) abort();
}

// A forged file tells any number of steps, but each is finite, and none is below 0.
static void switch_lamps(RadSolution *solution) {
    Arena arena = {0};
    Rgb *lit = ARENA_ARRAY(&arena, Rgb, solution->lamp_count + 1);
    for (int i = 0; i < solution->lamp_count; i++) lit[i] = (Rgb){1, 0.5f, 0};
    for (int i = 0; i < solution->each_count; i++) each_lamp_one(solution, i, &arena);
    if (solution->each) each_lamp_sum(solution, lit);
    for (int n = 0; n < solution->node_count && solution->each; n++)
        for (int c = 0; c < 3; c++)
            if (!(solution->node[n][c] >= 0 && isfinite(solution->node[n][c]))) abort();
    arena_free(&arena);
}

// As it is shown, then some more shots: sums may overflow, but light is never below 0.
static void use(const Made *m, RadSolution *solution) {
    RadOptions options = few_shots(solution->shots < 1000 ? solution->shots + 3 : 1000);
    Arena arena = {0};
    const Mesh *shown;
    const RadSolution *light;
    Error error = {""};
    if (shown_light(&m->mesh, solution, m->doors, &arena, &shown, &light, &error))
        reconstruct_light(shown, light, &arena);
    else if (error.text[0] == 0)
        abort();
    arena_free(&arena);
    rad_shoot(&m->mesh, &m->target.forest, m->doors, &options, NULL, solution);
    for (int e = 0; e < solution->element_count; e++) {
        for (int c = 0; c < 3; c++)
            if (solution->radiosity[e][c] < 0) abort();
    }
}

// Elements smaller than these, metres, are many, and take their time.
static const double SMALLEST = 1;

// A mesh as the file asks for, lit: no patch may have more elements than a shot can tell apart.
static void make_again(const Made *m, const MeshOptions *options, const float *doors, Arena *arena) {
    Mesh mesh;
    RadSolution solution;
    RadOptions few = few_shots(2);
    Error error = {""};
    if (options->element < SMALLEST) return;
    if (!mesh_build(&m->target.graph, doors, options, arena, &mesh, &error) ||
        !rad_start(&mesh, arena, &solution, &error)) {
        if (error.text[0] == 0) abort();
        return;
    }
    rad_shoot(&mesh, &m->target.forest, doors, &few, NULL, &solution);
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static Made made = {.target = {.header = HEADER, .rest_sum = true}};
    StoreTarget *t = &made.target;
    if (!t->valid.data) make(&made);
    Arena *arena = target_begin();
    store_target_put(t, data, size, arena);
    RadSolution solution;
    MeshOptions options;
    float doors[4];
    Error error = {""};
    if (rad_load(t->path, &made.mesh, made.doors, arena, &solution, &error)) {
        switch_lamps(&solution);
        use(&made, &solution);
        target_count(TARGET_PASSED);
    } else if (error.text[0] == 0) {
        abort();
    }
    error.text[0] = 0;
    if (rad_load_options(t->path, &t->building, arena, &options, doors, &error))
        make_again(&made, &options, doors, arena);
    else if (error.text[0] == 0)
        abort();
    return 0;
}
