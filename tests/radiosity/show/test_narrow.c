// test_narrow.c - light in narrow places: behind a sideboard, under a bed, past a door ajar, against path tracing that was kept
// (tests/narrow/*.ref, by `enfilade bench narrow --keep`).
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

enum { MOST_POINTS = 200 };

typedef struct NarrowPoints {
    int count, polygon[MOST_POINTS];
    Vec3 place[MOST_POINTS], normal[MOST_POINTS];
    double truth[MOST_POINTS], mean;  // irradiance, W/m^2, the sum of the channels
} NarrowPoints;

static void read_points(const char *name, NarrowPoints *out) {
    Arena arena = {0};
    FILE *file = fopen(arena_format(&arena, "tests/narrow/%s.ref", name), "r");
    char line[400];
    *out = (NarrowPoints){0};
    cr_assert(file, "%s", name);
    while (fgets(line, sizeof line, file)) {
        int i = out->count;
        Vec3 *p = &out->place[i], *n = &out->normal[i];
        if (*line == '#') continue;
        cr_assert_eq(sscanf(line, "%d %lf %lf %lf %lf %lf %lf %lf", &out->polygon[i], &p->x, &p->y, &p->z,
                            &n->x, &n->y, &n->z, &out->truth[i]),
                     8, "%s", line);
        out->mean += out->truth[i];
        cr_assert_lt(++out->count, MOST_POINTS);
    }
    out->mean /= out->count;
    fclose(file);
    arena_free(&arena);
}

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? -1 : p > q;
}

// Errors are relative to the truth, or to a hundredth of the mean where that is more.
typedef struct NarrowErrors {
    double median, rms, p99;
} NarrowErrors;

static NarrowErrors errors_of(const NarrowPoints *points, const double *light) {
    double off[MOST_POINTS], squares = 0;
    for (int i = 0; i < points->count; i++) {
        off[i] = fabs(light[i] - points->truth[i]) / fmax(points->truth[i], 0.01 * points->mean);
        squares += off[i] * off[i];
    }
    qsort(off, (size_t)points->count, sizeof *off, by_size);
    return (NarrowErrors){off[points->count / 2], sqrt(squares / points->count),
                          off[points->count * 99 / 100 - 1]};
}

// As `bake --probe` gathers it.
static NarrowErrors gathered(BakedBuilding *b, const NarrowPoints *points) {
    Probes probes = {ARENA_ARRAY(&b->arena, Probe, MOST_POINTS), points->count, MOST_POINTS};
    double light[MOST_POINTS];
    for (int i = 0; i < points->count; i++)
        probes.probes[i] = (Probe){.place = points->place[i], .normal = points->normal[i]};
    bake_probes_gather(&(GatherScene){&b->mesh, &b->scene.forest, b->doors, &b->solution, NULL}, 1, &probes);
    for (int i = 0; i < points->count; i++) light[i] = rgb_sum(probes.probes[i].irradiance);
    return errors_of(points, light);
}

// As a walk shows it. All surfaces of these scenes are grey.
static NarrowErrors shown(BakedBuilding *b, const NarrowPoints *points) {
    const Mesh *mesh;
    const RadSolution *solution;
    Error error;
    double light[MOST_POINTS];
    direct_show(&b->mesh, &b->scene.forest, b->doors, 0, NULL, &b->arena, &b->solution, NULL);
    cr_assert(shown_light(&b->mesh, &b->solution, b->doors, &b->arena, &mesh, &solution, &error), "%s",
              error.text);
    FineMesh *fine = fine_mesh_new(mesh, &b->arena);
    RadSolution of_fine = fine_light(fine, solution, &b->arena);
    VertexLight field = reconstruct_light(&fine->mesh, &of_fine, &b->arena);
    for (int i = 0; i < points->count; i++) {
        double radiosity[3];
        int face = fine->mesh.face_of[points->polygon[i]];
        const Material *m = mesh_material(&fine->mesh, face);
        reconstruct_at(&fine->mesh, &field, face, points->place[i], radiosity);
        light[i] = (rgb_sum(radiosity) - 3 * (double)m->emission.g) / (double)m->reflectance.g;
    }
    return errors_of(points, light);
}

// Gathered light is held to the bar for narrow places; the standard error of the truth, 0.3 to 0.7 %, is part of it. Shown light does not
// keep that bar yet, and is held to what it was when this was written, and an eighth more for meshes that change a little.
static const NarrowErrors BAR = {0.007, 0.05, 0.15};
static const struct {
    const char *name;
    struct {
        double median, rms;
    } shown;
} SCENES[] = {
    {"sideboard", {0.0141, 0.159}}, {"shelves", {0.0093, 0.067}},  {"niche", {0.0045, 0.012}},
    {"bed", {0.0099, 0.062}},       {"corridor", {0.0090, 0.027}}, {"stairwell", {0.0052, 0.017}},
    {"table", {0.0082, 0.079}},     {"curtain", {0.0040, 0.206}},  {"ajar", {0.0099, 0.091}},
    {"slit", {0.0037, 0.641}},
};
enum { SCENE_COUNT = sizeof SCENES / sizeof *SCENES };

// Proves that gathered light keeps the bar in narrow places, and that shown light is no farther off than it was. `make soak` looks at
// all scenes.
Test(narrow, no_worse, .timeout = 300) {
    for (int i = 0; i < support_count(3, SCENE_COUNT); i++) {
        Arena arena = {0};
        NarrowPoints points;
        read_points(SCENES[i].name, &points);
        BakedBuilding *b = baked_building(arena_format(&arena, "tests/narrow/%s.plan", SCENES[i].name), 0);
        NarrowErrors by_probe = gathered(b, &points), in_walk = shown(b, &points);
        printf("%s: gathered %.2f %%, RMS %.2f %%; shown %.2f %%, RMS %.2f %%\n", SCENES[i].name,
               100 * by_probe.median, 100 * by_probe.rms, 100 * in_walk.median, 100 * in_walk.rms);
        cr_expect_lt(by_probe.median, BAR.median);
        cr_expect_lt(by_probe.rms, BAR.rms);
        cr_expect_lt(by_probe.p99, BAR.p99);
        cr_expect_lt(in_walk.median, SCENES[i].shown.median);
        cr_expect_lt(in_walk.rms, SCENES[i].shown.rms);
        baked_building_free(b);
        arena_free(&arena);
    }
}
