// bench_rooms.c - the time of a shot as a building grows, with each culling: the same rooms, 10 to 1,000 of them
// (build/generate rooms-N). With culling, the time should depend on the visible part alone.
// Times are of the thread's own work, on a busy machine too.
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/random.h"
#include "engine/core/text.h"
#include "radiosity/factors/form_factor.h"

static const char HEAD[] = "building,rooms,cells,polygons,elements,method,culling,shots,ms_a_shot,ms_a_look,"
                           "faces_drawn,elements_drawn\n";

// Each row of the table takes so many shots, whose counts are therefore the same on every machine; the quickest of several passes
// counts, of which none begins after so many seconds.
enum { SHOTS = 500, PASSES = 5, TRIES = 1000 * SHOTS };
static const double LONGEST = 2;

typedef struct RoomsBench {
    const char *file;
    LoadedScene scene;
    Mesh mesh;
    Viewer *viewer;
    FormFactor *rows;
} RoomsBench;

static int count_rooms(const Building *b) {
    int count = 0;
    for (int i = 0; i < b->region_count; i++) count += b->regions[i].kind == REGION_ROOM;
    return count;
}

typedef struct Pass {
    double seconds, look_seconds;
    int shots;
    long long faces, elements;
} Pass;

// The same patches for all cullings, anywhere in the building.
static Pass run_pass(const RoomsBench *b, Culling culling, uint64_t seed) {
    Random random = {seed};
    Pass pass = {0};
    FormFactorWork before = form_factor_work(b->rows);
    double begin = clock_thread_seconds();
    for (int tries = 0; pass.shots < SHOTS && tries < TRIES; tries++) {
        const Patch *p = &b->mesh.patches[random_index(&random, b->mesh.patch_count)];
        if (p->cell < 0) continue;
        double at = clock_thread_seconds();
        ViewPoint from = {p->centre, b->mesh.faces[p->face].plane.n, p->cell};
        const View *view = viewer_look(b->viewer, &from, culling);
        pass.look_seconds += clock_thread_seconds() - at;
        form_factor_row(b->rows, view);
        pass.shots++;
    }
    pass.seconds = clock_thread_seconds() - begin;
    FormFactorWork after = form_factor_work(b->rows);
    pass.faces = after.faces_drawn - before.faces_drawn;
    pass.elements = after.elements_drawn - before.elements_drawn;
    return pass;
}

static void add_rooms_row(const RoomsBench *b, const char *method, Culling culling, uint64_t seed,
                          Text *csv) {
    Pass best = {.seconds = INFINITY, .shots = 1};
    double begin = clock_thread_seconds();
    for (int i = 0; i < PASSES && (i == 0 || clock_thread_seconds() - begin < LONGEST); i++) {
        Pass pass = run_pass(b, culling, seed);
        if (pass.seconds * best.shots < best.seconds * pass.shots) best = pass;
    }
    size_t before = csv->size;
    text_append(csv, "%s,%d,%d,%d,%d,%s,%s,%d,%.4f,%.4f,%.1f,%.1f\n", bench_name(b->file),
                count_rooms(&b->scene.building), b->scene.graph.cell_count, b->mesh.face_count,
                b->mesh.element_count, method, CULLING_NAMES[culling], best.shots,
                1e3 * best.seconds / best.shots, 1e3 * best.look_seconds / best.shots,
                (double)best.faces / best.shots, (double)best.elements / best.shots);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

static bool rooms_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    static const char *const METHODS[] = {"hemisphere", "hemicube"};
    Arena arena = {0};
    RoomsBench b = {.file = file};
    SceneOptions options = a->load;
    MeshOptions mesh_options = mesh_default_options();
    mesh_options.close = 0;  // the scene of the figures that are compared
    bool good = app_load(file, &options, &arena, &b.scene, error) && scene_has_walls(&b.scene, error) &&
                mesh_build(&b.scene.graph, NULL, &mesh_options, &arena, &b.mesh, error);
    if (good) b.viewer = viewer_new(&b.mesh, &b.scene.forest, NULL, &arena);
    for (int m = 0; m < 2 && good; m++) {
        FormFactorOptions form_factor = form_factor_default_options();
        b.rows = form_factor_new(form_factor_method(METHODS[m]), &b.mesh, &form_factor, &arena);
        for (int c = 0; c < BENCH_CULLINGS; c++)
            add_rooms_row(&b, METHODS[m], BENCH_CULLING[c], a->seed, csv);
        form_factor_end(b.rows);
    }
    arena_free(&arena);
    return good;
}

static bool measure_rooms(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, rooms_of_file, error);
}

static const Option ROWS[] = {
    BENCH_SEED("of the patches that shoot"),
    BENCH_CSV,
};

const Bench BENCH_ROOMS = {
    .name = "rooms",
    .about = "one shot in each FILE with each culling: how cost grows with a building",
    BENCH_OPTIONS(ROWS),
    .run = measure_rooms,
};
