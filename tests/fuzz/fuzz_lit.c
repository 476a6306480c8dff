// fuzz_lit.c - libFuzzer on the .lit reader: a file is refused with a sentence, or it holds light that can be drawn.
#include <stdlib.h>

#include "engine/lit/lit_part.h"
#include "radiosity/show/direct.h"
#include "tests/fuzz/store_target.h"

enum { HEADER = 288 };  // bytes, of lit_part.c

typedef struct Made {
    StoreTarget target;
    LoadedScene scene;
    uint64_t of_rad;
} Made;

static void make(Made *m) {
    StoreTarget *t = &m->target;
    float doors[4] = {0};
    MeshOptions options = {.element = 1.5, .per_patch = 2, .close = 0.05};
    RadOptions few = rad_default_options();
    Mesh mesh;
    RadSolution solution;
    WalkLight light;
    LitLight read;
    few.form_factor.resolution = 8;
    few.threads = 1;
    few.shots = 5;
    store_target_start(t);
    lamps_find(&t->graph, &t->building, &t->arena, &m->scene.lamps);
    m->scene.building = t->building;
    m->scene.graph = t->graph;
    m->scene.lit = ARENA_ARRAY(&t->arena, Rgb, m->scene.lamps.count + 1);
    for (int i = 0; i < m->scene.lamps.count; i++) m->scene.lit[i] = (Rgb){1, 1, 1};
    if (!mesh_build(&t->graph, doors, &options, &t->arena, &mesh, NULL) ||
        !rad_start(&mesh, &t->arena, &solution, NULL))
        abort();
    rad_shoot(&mesh, &t->forest, doors, &few, NULL, &solution);
    if (!direct_show(&mesh, &t->forest, doors, 1, NULL, &t->arena, &solution, NULL) ||
        !rad_save(t->saved, &mesh, doors, &solution, NULL) ||
        !rad_checksum(t->saved, &t->building, &m->of_rad, NULL) ||
        !light_shown(&mesh, &solution, doors, &m->scene.lamps, &t->arena, &light, NULL) ||
        !lit_store_part(&m->scene, t->saved, &light, NULL))
        abort();
    // The file of the light itself is not tried here.
    const char *stored = arena_format(&t->arena, "%s.lit", t->saved);
    if (rename(stored, t->saved) != 0) abort();
    store_target_keep(t);
    store_target_put_valid(t);
    if (!lit_read_part(&m->scene, t->path, m->of_rad, &t->arena, &read, NULL)) abort();
}

// As drawing reads it: each face through its indices.
static void use(const Made *m, const LitMesh *lit, const LitLight *light) {
    double sum = 0;
    const CellGraph *graph = &m->scene.graph;
    for (int o = 0; o < graph->object_count; o++)
        for (const LitFace *f = lit_object_begin(lit, &graph->objects[o]);
             f < lit_object_end(lit, &graph->objects[o]); f++) {
            for (int i = f->first_index; i < f[1].first_index; i++)
                sum += (double)light->vertex[lit->index[i]][0] +
                       (double)lit->vertex[lit->index[i]].position[0] +
                       graph->building->materials[lit->vertex[lit->index[i]].material].alpha;
            for (int e = f->first_element; e < f->first_element + f->element_count; e++)
                sum += (double)light->luminous[e] * (double)lit->spot[e][3];
        }
    for (int i = 0; i < lit->lamp_count; i++) sum += light->on[i] + (double)lit->faces[lit->lamp[i]].material;
    volatile double keep = sum;
    (void)keep;
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static Made made = {.target = {.header = HEADER, .rest_sum = true}};
    StoreTarget *t = &made.target;
    if (!t->valid.data) make(&made);
    Arena *arena = target_begin();
    store_target_put(t, data, size, arena);
    LitLight light;
    Error error = {""};
    const LitMesh *lit = lit_read_part(&made.scene, t->path, made.of_rad, arena, &light, &error);
    if (lit) {
        use(&made, lit, &light);
        target_count(TARGET_PASSED);
    } else if (error.text[0] == 0) {
        abort();
    }
    return 0;
}
