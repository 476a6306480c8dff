// test_adapt.c - meshes as fine as their light asks: small where shadows end, economical, the same however they were made, and the same
// again from a file.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/shoot/adapt.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// A room with a small lamp and a table beneath it.
static Lit *room(void) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_LAMP].emission = (Rgb){120, 120, 120};
    lit_box(lit, vec3(0, 0, 0), vec3(5, 4, 2.5), true, LIT_WALL, 0);
    lit_quad(lit, vec3(2.4, 1.9, 2.3), vec3(2.4, 2.1, 2.3), vec3(2.6, 2.1, 2.3), vec3(2.6, 1.9, 2.3),
             LIT_LAMP);
    lit_box(lit, vec3(1.5, 1.3, 0.7), vec3(2.9, 2.2, 0.74), false, LIT_RED, 0);
    lit_finish(lit, 0.5, 2);
    return lit;
}

typedef struct How {
    double share;
    int threads;
    Culling culling;
    double element;  // metres; 0: 0.25
} How;

static Mesh adapted(Lit *lit, const How *how) {
    Mesh mesh;
    Error error = {""};
    AdaptScene scene = {&lit->graph, &lit->forest, NULL, NULL};
    MeshOptions options = {.element = how->element > 0 ? how->element : 0.25, .per_patch = 2, .close = 0.05};
    AdaptOptions adapt = adapt_default_options();
    RadOptions rad = rad_default_options();
    adapt.share = how->share;
    adapt.few = 0;
    rad.threads = how->threads;
    rad.culling = how->culling;
    cr_assert(adapt_mesh(&scene, &options, &adapt, &rad, NULL, &lit->arena, &mesh, &error), "%s", error.text);
    return mesh;
}

static Mesh even(Lit *lit, double element) {
    Mesh mesh;
    Error error = {""};
    MeshOptions options = {.element = element, .per_patch = 2, .close = 0.05};
    cr_assert(mesh_build(&lit->graph, NULL, &options, &lit->arena, &mesh, &error), "%s", error.text);
    return mesh;
}

// How wide the element at a point of the floor is across a line along y.
static double width_of(const Mesh *mesh, Vec3 p, int face) {
    const Element *e = &mesh->elements[mesh_element_at(mesh, face, p)];
    double low = INFINITY, high = -INFINITY;
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++) {
        low = fmin(low, mesh->vertices[mesh->corners[i]].x);
        high = fmax(high, mesh->vertices[mesh->corners[i]].x);
    }
    return high - low;
}

static double edge_of(const Mesh *mesh, Vec3 p, int face) {
    return sqrt(mesh->elements[mesh_element_at(mesh, face, p)].area);
}

static int face_at(const Mesh *mesh, Vec3 n, double d) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Plane *p = &mesh->faces[f].plane;
        if (vec3_dot(p->n, n) > 0.999 && fabs(p->d - d) < 1e-6) return f;
    }
    cr_assert_fail("no such face");
    return -1;
}

// Proves that elements are small where the table's shadow ends on the floor, and large in a far corner of the ceiling, where light
// hardly changes; that they are no more than allowed, and fewer than everywhere so small by far.
Test(adapt, small_at_shadows_large_where_even) {
    Lit *lit = room();
    Mesh mesh = adapted(lit, &(How){0.4, 0, CULL_STAB, 0});
    int ground = face_at(&mesh, vec3(0, 0, 1), 0), ceiling = face_at(&mesh, vec3(0, 0, -1), -2.5);
    // By similar triangles, from the lamp's middle: the table's left edge, at x = 1.5, throws its shadow to x = 1.057.
    double at_shadow = INFINITY;
    for (double x = 0.95; x < 1.2; x += 0.02)
        at_shadow = fmin(at_shadow, width_of(&mesh, vec3(x, 1.75, 0), ground));
    double in_corner = edge_of(&mesh, vec3(4.8, 3.8, 2.5), ceiling);
    printf("%d elements, %d patches; at the shadow %.3f m, in the corner %.3f m\n", mesh.element_count,
           mesh.patch_count, at_shadow, in_corner);
    // Light straight from lamps counts by half: it is shown on a finer mesh.
    cr_expect_lt(at_shadow, 0.26);
    cr_expect_geq(in_corner, 2 * at_shadow);
    // Elements cut along the table are not counted beforehand.
    printf("%.0f without splits\n", mesh_count_even(&mesh));
    cr_expect_lt(mesh.element_count, 0.4 * 1.1 * mesh_count_even(&mesh));
    lit_free(lit);
}

// ---- the bar

enum { POINTS = 300 };

typedef struct Truth {
    PathQuery queries[POINTS];
    PathResult results[POINTS];
    int faces;
} Truth;

// Evenly over the room's surfaces, but where the table is.
static Truth *truth_of(Lit *lit) {
    Truth *t = ARENA_ARRAY(&lit->arena, Truth, 1);
    Random random = {11};
    const Mesh *mesh = &lit->mesh;
    double area = 0;
    for (int e = 0; e < mesh->element_count; e++) area += mesh->elements[e].area;
    for (int i = 0; i < POINTS; i++) {
        double left = random_unit(&random) * area;
        int e = 0;
        while (e + 1 < mesh->element_count && left > mesh->elements[e].area) left -= mesh->elements[e++].area;
        const Element *element = &mesh->elements[e];
        const int *corner = mesh->corners + element->first_corner;
        int k = 1 + random_index(&random, element->corner_count - 2);
        Vec3 p = vec3_lerp(mesh->vertices[corner[k]], mesh->vertices[corner[k + 1]], random_unit(&random));
        p = vec3_lerp(mesh->vertices[corner[0]], p, sqrt(random_unit(&random)));
        t->queries[i] = (PathQuery){p, mesh->faces[element->face].plane.n, 0.02, 0, 33000, (uint64_t)i};
    }
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(mesh, NULL, &arena);
    path_tracer_irradiance(tracer, t->queries, POINTS, 0, t->results);
    path_tracer_end(tracer);
    arena_free(&arena);
    return t;
}

static int face_of(const Mesh *mesh, const PathQuery *q) {
    return face_at(mesh, q->normal, vec3_dot(q->normal, q->point));
}

// RMS of what elements hold against the truth at points, over the mean of the truth, less what the truth scatters.
static double error_of(Lit *lit, Mesh *mesh, const Truth *t) {
    RadSolution s;
    Error error = {""};
    RadOptions options = rad_default_options();
    cr_assert(rad_start(mesh, &lit->arena, &s, &error), "%s", error.text);
    rad_shoot(mesh, &lit->forest, NULL, &options, NULL, &s);
    double square = 0, mean = 0;
    for (int i = 0; i < POINTS; i++) {
        int face = face_of(mesh, &t->queries[i]);
        double rho = (double)mesh_material(mesh, face)->reflectance.g;
        if (rho == 0) continue;
        const PathResult *r = &t->results[i];
        double h = s.radiosity[mesh_element_at(mesh, face, t->queries[i].point)][1] / rho;
        square +=
            (h - r->irradiance[1]) * (h - r->irradiance[1]) - r->standard_error[1] * r->standard_error[1];
        mean += r->irradiance[1];
    }
    return sqrt(fmax(square, 0) * POINTS) / mean;
}

// Proves the bar: a mesh as fine as its light asks errs no more, over all surfaces, than even meshes of which it has 40 % of the
// elements, coarse and fine. Where lines of even meshes happen to lie along a shadow's edge they are lucky, and where they
// do not they are unlucky, so it is the mean of several that counts.
Test(adapt, no_more_error_with_40_percent_of_the_elements) {
    Lit *lit = room();
    Truth *truth = truth_of(lit);
    static const double EDGES[2] = {0.24, 0.18}, AROUND[3] = {0.95, 1, 1.05};
    for (int i = 0; i < 2; i++) {
        double square = 0, elements = 0;
        for (int k = 0; k < 3; k++) {
            Mesh other = even(lit, EDGES[i] * AROUND[k]);
            double theirs = error_of(lit, &other, truth);
            printf("even %.3f m: %d elements, %.2f %%\n", EDGES[i] * AROUND[k], other.element_count,
                   100 * theirs);
            square += theirs * theirs / 3;
            elements += other.element_count / 3.0;
        }
        Mesh mesh = adapted(lit, &(How){.share = 0.34, .element = EDGES[i]});
        double ours = error_of(lit, &mesh, truth);
        printf("adaptive: %d elements (%.2f), %.2f %%\n", mesh.element_count, mesh.element_count / elements,
               100 * ours);
        cr_expect_leq(mesh.element_count, 0.4 * elements);
        cr_expect_lt(ours, sqrt(square));
    }
    lit_free(lit);
}

static void check_same(const Mesh *a, const Mesh *b) {
    const MeshSplits *p = a->options.splits, *q = b->options.splits;
    cr_assert_eq(p->bit_count, q->bit_count);
    cr_assert_arr_eq(p->bits, q->bits, (size_t)(p->bit_count + 7) / 8);
    cr_assert_eq(a->element_count, b->element_count);
    cr_assert_eq(a->corner_count, b->corner_count);
    cr_assert_arr_eq(a->corners, b->corners, (size_t)a->corner_count * sizeof *a->corners);
    cr_assert_arr_eq(a->vertices, b->vertices, (size_t)a->vertex_count * sizeof *a->vertices);
}

// Proves that neither threads nor culling show in the mesh.
Test(adapt, same_on_any_threads_and_culled) {
    static const How HOW[] = {
        {0.3, 1, CULL_STAB, 0}, {0.3, 2, CULL_STAB, 0}, {0.3, 3, CULL_NONE, 0}, {0.3, 2, CULL_CELLS, 0}};
    Lit *lit = lit_rooms(3);
    Mesh first = adapted(lit, &HOW[0]);
    for (int i = 1; i < 4; i++) {
        Mesh other = adapted(lit, &HOW[i]);
        check_same(&first, &other);
    }
    lit_free(lit);
}

// Proves that a .rad file holds all that makes its mesh: from its options alone the same mesh comes out, the light is taken for it, and
// is refused for another.
Test(adapt, comes_back_from_a_file) {
    Lit *lit = room();
    Mesh mesh = adapted(lit, &(How){0.4, 0, CULL_STAB, 0}), again;
    RadSolution s, back;
    Error error = {""};
    RadOptions options = rad_default_options();
    options.shots = 50;
    cr_assert(rad_start(&mesh, &lit->arena, &s, &error), "%s", error.text);
    rad_shoot(&mesh, &lit->forest, NULL, &options, NULL, &s);
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    cr_assert(rad_save(path, &mesh, NULL, &s, &error), "%s", error.text);
    MeshOptions stored;
    float doors[1];
    cr_assert_eq(lit->building->opening_count, 0);
    cr_assert(rad_load_options(path, lit->building, &lit->arena, &stored, doors, &error), "%s", error.text);
    cr_assert(mesh_build(&lit->graph, NULL, &stored, &lit->arena, &again, &error), "%s", error.text);
    check_same(&mesh, &again);
    cr_assert(rad_load(path, &again, NULL, &lit->arena, &back, &error), "%s", error.text);
    cr_assert_arr_eq(back.radiosity, s.radiosity, (size_t)s.element_count * sizeof *s.radiosity);
    again.options.splits = NULL;
    cr_assert_not(rad_load(path, &again, NULL, &lit->arena, &back, &error));
    cr_assert(strstr(error.text, "not split as those asked for"), "%s", error.text);
    again.options = mesh.options;
    again.options.close = 0;
    cr_assert_not(rad_load(path, &again, NULL, &lit->arena, &back, &error));
    cr_assert(strstr(error.text, "elements cut along what is 0.05 m"), "%s", error.text);
    lit_free(lit);
}

// Proves that where nothing shines, and where nothing reflects, there is a mesh, whose patches are the roots but for lamps.
Test(adapt, in_the_dark) {
    for (int black = 0; black < 2; black++) {
        Lit *lit = room();
        if (!black) lit->building->materials[LIT_LAMP].emission = (Rgb){0, 0, 0};
        for (int m = 0; m < 3 && black; m++) lit->building->materials[m].reflectance = (Rgb){0, 0, 0};
        Mesh mesh = adapted(lit, &(How){0.4, 0, CULL_STAB, 0});
        for (int f = 0; f < mesh.face_count; f++) {
            const Face *face = &mesh.faces[f];
            cr_assert_eq(face->patch_count, face->nx / face->root * (face->ny / face->root), "face %d", f);
        }
        cr_assert_leq(mesh.element_count, mesh_count_even(&mesh));
        lit_free(lit);
    }
}
