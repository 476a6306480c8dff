// test_sums_light.c - meshes, shots, daylight and shown light of buildings, in figures.
#include <criterion/criterion.h>
#include <string.h>

#include "maps/maps.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"

static void sum_faces(SumFile *f, const Mesh *m) {
    Sum faces = {0};
    for (int i = 0; i < m->face_count; i++) {
        const Face *face = &m->faces[i];
        int words[] = {face->polygon,     face->object,     face->material,      face->nx,
                       face->ny,          face->root,       face->first_element, face->element_count,
                       face->first_patch, face->patch_count};
        sum_ints(&faces, words, sizeof words / sizeof *words);
        sum_add3(&faces, face->plane.n);
        sum_add(&faces, face->plane.d);
        sum_add3(&faces, face->origin);
        sum_add3(&faces, face->gx);
        sum_add3(&faces, face->gy);
    }
    sum_ints(&faces, m->outline, m->outline_count);
    sum_ints(&faces, m->squares, m->square_count);
    sum_ints(&faces, m->shared, m->shared_count);
    sum_ints(&faces, m->face_of, m->graph->polygon_count);
    sums_sum(f, "faces", faces);
}

static void sum_mesh(SumFile *f, const Mesh *m) {
    Sum elements = {0}, patches = {0};
    sum_faces(f, m);
    for (int i = 0; i < m->element_count; i++) {
        const Element *e = &m->elements[i];
        int words[] = {e->face, e->patch, e->first_corner, e->corner_count, e->depth.x, e->depth.y};
        sum_ints(&elements, words, sizeof words / sizeof *words);
        sum_add(&elements, e->area);
    }
    sum_ints(&elements, m->corners, m->corner_count);
    for (int i = 0; i < m->vertex_count; i++) sum_add3(&elements, m->vertices[i]);
    for (int i = 0; i < m->patch_count; i++) {
        const Patch *p = &m->patches[i];
        int words[] = {p->face, p->first_element, p->element_count, p->cell};
        sum_ints(&patches, words, sizeof words / sizeof *words);
        sum_add(&patches, p->area);
        sum_add3(&patches, p->centre);
    }
    int lost[] = {m->dropped_faces, m->merged_elements, m->lost_patches};
    sum_ints(&patches, lost, 3);
    sums_sum(f, "elements", elements);
    sums_sum(f, "patches", patches);
}

static void sum_channels(Sum *sum, double (*v)[3], int count) {
    for (int i = 0; i < count; i++) sum_add3(sum, vec3(v[i][0], v[i][1], v[i][2]));
}

static void sum_solution(SumFile *f, const char *what, const RadSolution *s) {
    Sum sum = {0};
    sum_channels(&sum, (double(*)[3])s->radiosity, s->element_count);
    sum_channels(&sum, (double(*)[3])s->unshot, s->patch_count);
    double totals[3][3];
    memcpy(totals[0], s->emitted, sizeof totals[0]);
    memcpy(totals[1], s->absorbed, sizeof totals[1]);
    memcpy(totals[2], s->escaped, sizeof totals[2]);
    sum_channels(&sum, totals, 3);
    sums_sum(f, what, sum);
}

// At nodes, at elements' middles, and a third of the way from there to a corner.
static void sum_shown(SumFile *f, const Mesh *m, const RadSolution *s, Arena *arena) {
    VertexLight light = reconstruct_light(m, s, arena);
    Nodes nodes = nodes_of(m, arena);
    Sum shown = {0}, at_nodes = {0};
    sum_channels(&shown, light.corner, m->corner_count);
    sum_channels(&shown, light.face, m->face_count);
    for (int i = 0; i < m->element_count; i++) {
        Vec3 middle = element_centroid(m, i), corner = m->vertices[m->corners[m->elements[i].first_corner]];
        double out[2][3];
        reconstruct_at(m, &light, m->elements[i].face, middle, out[0]);
        reconstruct_in(m, &light, i, vec3_lerp(middle, corner, 1.0 / 3), out[1]);
        sum_channels(&shown, out, 2);
        sum_add(&at_nodes, mesh_element_at(m, m->elements[i].face, middle));
    }
    sum_ints(&at_nodes, nodes.of_corner, m->corner_count);
    sum_ints(&at_nodes, nodes.vertex, nodes.count);
    sum_ints(&at_nodes, nodes.first, nodes.count + 1);
    sum_ints(&at_nodes, nodes.element, nodes.first[nodes.count]);
    for (int i = 0; i < nodes.count; i++) sum_add3(&at_nodes, nodes.normal[i]);
    sums_sum(f, "shown", shown);
    sums_sum(f, "nodes", at_nodes);
}

static void see(Lit *lit) {
    Error error = {""};
    VisOptions vis = vis_default_options();
    vis.threads = 1;
    cr_assert(vis_build_cells(lit->building, &vis, &lit->arena, &lit->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&lit->graph, &vis, NULL, &lit->arena, &lit->forest));
}

static Lit *read_lit(const char *path) {
    Lit *lit = lit_new();
    Error error = {""};
    lit->building = ARENA_ARRAY(&lit->arena, Building, 1);
    cr_assert(maps_read(path, &lit->arena, lit->building, &error), "%s", error.text);
    see(lit);
    return lit;
}

// A mesh, some shots, daylight where there is an outdoors, and what is shown of it.
static void sum_light(SumFile *f, const char *name, Lit *lit, const MeshOptions *options, bool adaptive) {
    Error error = {""};
    RadOptions rad = rad_default_options();
    RadSolution solution, dark;
    AdaptOptions adapt = adapt_default_options();
    AdaptScene scene = {&lit->graph, &lit->forest, NULL, NULL};
    rad.shots = 60;
    rad.threads = 2;
    rad.form_factor.resolution = 40;
    adapt.few = 4000;
    bool made = adaptive ? adapt_mesh(&scene, options, &adapt, &rad, NULL, &lit->arena, &lit->mesh, &error)
                         : mesh_build(&lit->graph, NULL, options, &lit->arena, &lit->mesh, &error);
    cr_assert(made, "%s", error.text);
    sums_scene(f, name);
    sum_mesh(f, &lit->mesh);
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &dark, &error), "%s", error.text);
    const Daylight day = daylight_uniform((const double[]){1, 2, 3});
    rad_shine(&lit->mesh, &lit->forest, NULL, &rad, &day, NULL, &dark);
    sum_solution(f, "sky", &dark);
    if (rad_start(&lit->mesh, &lit->arena, &solution, &error)) {
        RadReport report = rad_shoot(&lit->mesh, &lit->forest, NULL, &rad, NULL, &solution);
        Sum work = {0};
        sum_add3(&work, vec3((double)report.rows_made, (double)report.rows_kept, report.faces_drawn_mean));
        sum_add2(&work, vec2(report.elements_drawn_mean, report.residual));
        sums_sum(f, "shots", work);
        sum_solution(f, "light", &solution);
        sum_shown(f, &lit->mesh, &solution, &lit->arena);
    } else {
        sum_shown(f, &lit->mesh, &dark, &lit->arena);
    }
}

// Proves that meshes of several kinds, shots, daylight and what is shown of them are what they were.
Test(sums, light, .timeout = 120) {
    static const char *const FILES[] = {"build/maps/two-rooms.plan", "build/maps/flat.Home.xml",
                                        "build/maps/two-rooms.plan"};
    SumFile f = sums_begin("light");
    for (int i = 0; i < 6; i++) {
        Lit *lit = i < 3 ? read_lit(FILES[i]) : lit_rooms((uint64_t)i);
        MeshOptions options = mesh_default_options();
        options.element = i == 2 ? 0.8 : 0.5;
        options.threads = 2;
        if (i % 2) options.per_patch = 1 + i, options.close = 0;
        const char *name =
            arena_format(&f.arena, "%s-%d", i < 3 ? strrchr(FILES[i], '/') + 1 : "lit-rooms", i);
        sum_light(&f, name, lit, &options, i % 3 == 0);
        lit_free(lit);
    }
    sums_end(&f);
}
