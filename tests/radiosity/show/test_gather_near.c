// test_gather_near.c - what is close is walked to, and a final gather is as right as its gather.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/parallel.h"
#include "radiosity/show/final_gather.h"
#include "tests/radiosity/show/gather_fixture.h"
#include "tests/support/lit_fixture.h"

// Proves that emission and reflection are counted once, whatever is near: in a room where all emits E and reflects a half, H is
// E / (1 - 1/2) in a slit, with lamps exact and not. 1 %: what walks scatter.
Test(gather, near_furnace) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 2, 3};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(1, 0.02, 0), vec3(2.2, 0.5, 1.8), false, LIT_WALL, 0);
    lit_finish(lit, 0.5, 2);
    RadSolution s = {.element_count = lit->mesh.element_count};
    s.radiosity = arena_alloc(&lit->arena, (size_t)s.element_count, sizeof *s.radiosity);
    for (int e = 0; e < s.element_count; e++)
        for (int c = 0; c < 3; c++) s.radiosity[e][c] = 2 * (c + 1);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
    GatherOptions exact = gather_exact_options(), lamps = exact;
    lamps.exact_lamps = true;
    double h[2][CLOSE_POINTS][3];
    gather_all(&scene, &exact, h[0]);
    gather_all(&scene, &lamps, h[1]);
    for (int i = 0; i < 2 * CLOSE_POINTS; i++)
        for (int c = 0; c < 3; c++)
            cr_expect_float_eq(h[i / CLOSE_POINTS][i % CLOSE_POINTS][c], 2 * (c + 1), 0.02 * (c + 1),
                               "%d: %g", i, h[i / CLOSE_POINTS][i % CLOSE_POINTS][c]);
    lit_free(lit);
}

// Proves that a point in the open has to the last bit what it had; and that inside what is closed there is no light.
Test(gather, open_and_closed) {
    RadSolution s;
    Lit *lit = gather_room_with_slit(&s);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
    GatherOptions near = gather_exact_options(), even = near;
    even.near.reach = 0;
    double h[3], looked_up[3];
    gather_once(&scene, &near, vec3(4, 1.5, 1.2), vec3(-1, 0, 0), h);
    gather_once(&scene, &even, vec3(4, 1.5, 1.2), vec3(-1, 0, 0), looked_up);
    cr_assert_arr_eq(h, looked_up, sizeof h);
    cr_assert_gt(h[1], 0.1);
    gather_once(&scene, &near, vec3(1.6, 0.03, 0.9), vec3(0, 1, 0), h);
    cr_assert_eq(h[0] + h[1] + h[2], 0);
    lit_free(lit);
}

typedef struct CloseAsked {
    Gatherer **gatherer;  // [threads]
    const CellGraph *graph;
    double out[CLOSE_POINTS][3];
} CloseAsked;

static void ask_close(void *context, int index, int thread) {
    CloseAsked *self = context;
    ViewPoint from = CLOSE[index];
    from.cell = gather_cell(self->graph, from.eye, from.normal, -1);
    gather(self->gatherer[thread], &from, self->out[index]);
}

// Proves that light that is walked to depends on the point alone: the same bytes on one thread and on three, which take the points
// in other orders; and the same within rounding if nothing is culled.
Test(gather, near_is_the_same_every_time) {
    enum { THREADS = 3 };
    RadSolution s;
    Lit *lit = gather_room_with_slit(&s);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &s, NULL};
    GatherOptions options = gather_exact_options(), all = options;
    all.culling = CULL_NONE;
    double one[CLOSE_POINTS][3], unculled[CLOSE_POINTS][3];
    gather_all(&scene, &options, one);
    gather_all(&scene, &all, unculled);
    Gatherer *gatherer[THREADS];
    for (int t = 0; t < THREADS; t++) gatherer[t] = gatherer_new(&scene, &options, &lit->arena);
    CloseAsked asked = {.gatherer = gatherer, .graph = &lit->graph};
    parallel_for(THREADS, CLOSE_POINTS, ask_close, &asked);
    cr_assert_eq(memcmp(asked.out, one, sizeof one), 0);
    for (int i = 0; i < CLOSE_POINTS; i++) cr_assert_float_eq(one[i][1], unculled[i][1], 1e-9 * one[i][1]);
    for (int t = 0; t < THREADS; t++) gatherer_end(gatherer[t]);
    lit_free(lit);
}

static bool never(void *context, const char *stage, double done) {
    (void)context;
    (void)stage;
    return done < 0;
}

static Lit *lamp_room(double element, RadSolution *s) {
    Lit *lit = lit_new();
    RadOptions options = rad_default_options();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.3));
    lit_finish(lit, element, 2);
    lit_shoot(lit, &options, s);
    return lit;
}

// Proves of the final gather: that one thread and three give the same bytes; that every node of the floor and the walls,
// corners and edges included, has what an exact gather of elements of a sixth the size finds there, within 1 % in the mean
// (0.3 % today, 8 % as interpolated); and that one that is stopped leaves the solution as it was.
Test(gather, final_gather) {
    RadSolution s, fine;
    Lit *lit = lamp_room(0.5, &s), *truth = lamp_room(0.08, &fine);
    const Mesh *mesh = &lit->mesh;
    VertexLight light = reconstruct_light(mesh, &s, &lit->arena);
    GatherScene scene = {mesh, &lit->forest, NULL, &s, &light};
    GatherScene fine_scene = {&truth->mesh, &truth->forest, NULL, &fine, NULL};
    GatherOptions options = gather_default_options(), exact = gather_exact_options();
    Progress stop = {never, NULL};
    cr_assert_not(final_gather(&scene, &options, 1, &stop, &lit->arena, &s));
    cr_assert(s.node == NULL && s.node_count == 0);
    cr_assert(final_gather(&scene, &options, 1, NULL, &lit->arena, &s));
    double(*one)[3] = s.node;
    cr_assert(final_gather(&scene, &options, 3, NULL, &lit->arena, &s));
    cr_assert_eq(memcmp(one, s.node, (size_t)s.node_count * sizeof *one), 0);
    VertexLight gathered = reconstruct_light(mesh, &s, &lit->arena);
    Gatherer *g = gatherer_new(&fine_scene, &exact, &truth->arena);
    double off = 0, interpolated = 0;
    int count = 0;
    for (int e = 0; e < mesh->element_count; e += 5) {
        const Element *element = &mesh->elements[e];
        Vec3 n = mesh->faces[element->face].plane.n, p = mesh->vertices[mesh->corners[element->first_corner]];
        if (mesh_material(mesh, element->face)->emission.r > 0) continue;
        p = vec3_lerp(p, element_centroid(mesh, e), 1e-3);
        double h[3];
        gather(g, &(ViewPoint){p, n, gather_cell(&truth->graph, p, n, -1)}, h);
        off += fabs(gathered.corner[element->first_corner][1] / (0.5 * h[1]) - 1);
        interpolated += fabs(light.corner[element->first_corner][1] / (0.5 * h[1]) - 1);
        count++;
    }
    printf("gathered %.2f %%, interpolated %.2f %%\n", 100 * off / count, 100 * interpolated / count);
    cr_assert(off / count < 0.01 && off < interpolated);
    gatherer_end(g);
    lit_free(lit);
    lit_free(truth);
}
