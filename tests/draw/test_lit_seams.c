// test_lit_seams.c - a seam finder: along every edge that two elements share the light shown is the same from both, but where
// something stands there; and no vertex lies in the middle of a neighbour's edge. Of the samples, baked with the defaults.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

// Neighbours may differ along their edge by so much of the light there: rounding.
static const double SEAM = 1e-6;
// Light below this share of the mean is dark: no seam is seen in it.
static const double DARK = 1e-4;
// A walk does not depend on the last light: bakes end when so much is left.
static const double ROUGH = 0.01;
// Homes hold things that go through each other askew, of parts thinner than what is looked at here, and slivers of micrometres.
static const double IN_HOMES = 0.003;
// Planes are one as for nodes (nodes.c).
static const double SAME_PLANE = 1e-6;
// A vertex nearer than this to an edge lies on it, metres: the grid on which vertices are one is finer.
static const double ON_EDGE = 1e-7;

typedef struct Side {
    int low, high;  // vertices
    int element;
    bool rising;  // from low to high
} Side;

typedef struct Seams {
    Arena arena;
    BakedBuilding *baked;
    const Mesh *mesh;
    VertexLight light;
    Side *sides;
    int side_count;
    double mean;  // radiosity, W/m^2
} Seams;

static int by_vertices(const void *a, const void *b) {
    const Side *p = a, *q = b;
    return p->low != q->low     ? p->low - q->low
           : p->high != q->high ? p->high - q->high
                                : p->element - q->element;
}

static void find_sides(Seams *s) {
    const Mesh *mesh = s->mesh;
    double area = 0;
    s->sides = ARENA_ARRAY(&s->arena, Side, mesh->corner_count);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        for (int k = 0; k < element->corner_count; k++) {
            int a = mesh->corners[element->first_corner + k],
                b = mesh->corners[element->first_corner + (k + 1) % element->corner_count];
            s->sides[s->side_count++] = (Side){a < b ? a : b, a < b ? b : a, e, a < b};
        }
        s->mean += element->area * s->baked->solution.radiosity[e][1];
        area += element->area;
    }
    s->mean /= area;
    qsort(s->sides, (size_t)s->side_count, sizeof *s->sides, by_vertices);
}

static const Face *face_of(const Seams *s, int element) {
    return &s->mesh->faces[s->mesh->elements[element].face];
}

static bool in_one_plane(const Seams *s, const Side *a, const Side *b) {
    const Face *f = face_of(s, a->element), *g = face_of(s, b->element);
    return a->rising != b->rising && f->material == g->material &&
           vec3_dot(f->plane.n, g->plane.n) > 1 - SAME_PLANE;
}

// The greatest step of light across the side, of the light there.
static double step_across(const Seams *s, const Side *a, const Side *b) {
    Vec3 from = s->mesh->vertices[a->low], to = s->mesh->vertices[a->high];
    double most = 0;
    enum { PLACES = 5 };
    for (int i = 0; i <= PLACES; i++) {
        Vec3 p = vec3_lerp(from, to, (double)i / PLACES);
        double one[3], other[3];
        reconstruct_in(s->mesh, &s->light, a->element, p, one);
        reconstruct_in(s->mesh, &s->light, b->element, p, other);
        for (int c = 0; c < 3; c++) {
            double scale = fmax(fmax(one[c], other[c]), DARK * s->mean);
            most = fmax(most, fabs(one[c] - other[c]) / scale);
        }
    }
    return most;
}

// ---- what stands on a side: a third face that goes through the air right above it

static bool meets(const Seams *s, const Face *f, Vec3 from, Vec3 to) {
    double a = plane_distance(f->plane, from), b = plane_distance(f->plane, to);
    if ((a > 0) == (b > 0)) return false;
    Vec3 p = vec3_lerp(from, to, a / (a - b));
    const int *outline = s->mesh->outline + f->first_vertex;
    for (int i = 0; i < f->vertex_count; i++) {
        Vec3 v = s->mesh->vertices[outline[i]], w = s->mesh->vertices[outline[(i + 1) % f->vertex_count]];
        Vec3 in = vec3_cross(f->plane.n, vec3_sub(w, v));
        if (vec3_dot(in, vec3_sub(p, v)) < -1e-9 * vec3_length(in)) return false;
    }
    return true;
}

static bool stood_upon(const Seams *s, const Side *a, const Side *b) {
    const double NEAR = 1e-3,
                 HEIGHT =
                     1e-4;  // metres: half the line from one side to the other; what leans is met as well
    Vec3 v = s->mesh->vertices[a->low], w = s->mesh->vertices[a->high];
    Vec3 n = face_of(s, a->element)->plane.n, up = vec3_scale(n, HEIGHT);
    Vec3 across = vec3_scale(vec3_normalize(vec3_cross(n, vec3_sub(w, v))), NEAR);
    Vec3 middle = vec3_add(vec3_lerp(v, w, 0.5), up);
    for (int f = 0; f < s->mesh->face_count; f++) {
        if (f == s->mesh->elements[a->element].face || f == s->mesh->elements[b->element].face) continue;
        if (meets(s, &s->mesh->faces[f], vec3_sub(middle, across), vec3_add(middle, across))) return true;
    }
    return false;
}

static void check_seams(const Seams *s, const char *path, double share) {
    int smooth = 0, broken = 0, seams = 0;
    double worst = 0;
    Vec3 place = {0, 0, 0};
    for (int i = 0; i < s->side_count; i++) {
        for (int j = i + 1;
             j < s->side_count && s->sides[j].low == s->sides[i].low && s->sides[j].high == s->sides[i].high;
             j++) {
            const Side *a = &s->sides[i], *b = &s->sides[j];
            if (!in_one_plane(s, a, b)) continue;
            double step = step_across(s, a, b);
            smooth += step <= SEAM;
            if (step <= SEAM) continue;
            if (stood_upon(s, a, b)) {
                broken++;
                continue;
            }
            seams++;
            if (step > worst) place = s->mesh->vertices[a->low];
            worst = fmax(worst, step);
        }
    }
    printf("%s: %d edges smooth, %d broken by what stands there, %d seams\n", path, smooth, broken, seams);
    cr_expect_leq(seams, share * smooth,
                  "%s: %d seams, the worst a step of %.2g of the light at %.3f,%.3f,%.3f", path, seams, worst,
                  place.x, place.y, place.z);
    cr_expect_gt(smooth, 1000);
    cr_expect_gt(broken, 0);
}

// ---- vertices on edges

static int by_x(const void *a, const void *b) {
    const Vec3 *const *p = a, *const *q = b;
    return (*p)->x < (*q)->x ? -1 : (*p)->x > (*q)->x;
}

// Corners of elements of a face, once each, by x.
static int corners_of(const Seams *s, const Face *face, const Vec3 **out) {
    int count = 0;
    const Element *first = &s->mesh->elements[face->first_element], *end = first + face->element_count;
    for (const Element *e = first; e < end; e++)
        for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
            out[count++] = &s->mesh->vertices[s->mesh->corners[c]];
    qsort(out, (size_t)count, sizeof *out, by_x);
    return count;
}

static bool lies_within(Vec3 p, Vec3 v, Vec3 w) {
    Vec3 along = vec3_sub(w, v), to = vec3_sub(p, v);
    double square = vec3_dot(along, along), t = vec3_dot(along, to) / square;
    if (!(t * sqrt(square) > 10 * ON_EDGE && (1 - t) * sqrt(square) > 10 * ON_EDGE)) return false;
    return vec3_length(vec3_sub(to, vec3_scale(along, t))) < ON_EDGE;
}

static int hanging_on(const Vec3 *const *at, int count, Vec3 v, Vec3 w) {
    double x = fmin(v.x, w.x) - ON_EDGE, end = fmax(v.x, w.x) + ON_EDGE;
    int low = 0, high = count, hanging = 0;
    while (low < high) {
        int middle = (low + high) / 2;
        if (at[middle]->x < x)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < count && at[low]->x <= end; low++) hanging += lies_within(*at[low], v, w);
    return hanging;
}

static void check_vertices(const Seams *s, const char *path) {
    int hanging = 0;
    Arena scratch = {0};
    const Vec3 **at = arena_alloc(&scratch, (size_t)s->mesh->corner_count, sizeof *at);
    for (int f = 0; f < s->mesh->face_count; f++) {
        const Face *face = &s->mesh->faces[f];
        int count = corners_of(s, face, at);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            const Element *element = &s->mesh->elements[e];
            const int *corner = s->mesh->corners + element->first_corner;
            for (int k = 0; k < element->corner_count; k++)
                hanging += hanging_on(at, count, s->mesh->vertices[corner[k]],
                                      s->mesh->vertices[corner[(k + 1) % element->corner_count]]);
        }
    }
    cr_expect_eq(hanging, 0, "%s: %d corners lie in edges that do not list them", path, hanging);
    arena_free(&scratch);
}

// `share` of the edges that may show a seam.
static void check(const char *path, double share) {
    Seams s = {.baked = baked_building(path, ROUGH)};
    s.mesh = &s.baked->mesh;
    s.light = reconstruct_light(s.mesh, &s.baked->solution, &s.arena);
    find_sides(&s);
    check_seams(&s, path, share);
    check_vertices(&s, path);
    baked_building_free(s.baked);
    arena_free(&s.arena);
}

Test(lit_seams, two_rooms, .timeout = 120) { check("build/maps/two-rooms.plan", 0); }
Test(lit_seams, house, .timeout = 300) { check("build/maps/house.plan", 0); }
Test(lit_seams, flat, .timeout = 300) { check("build/maps/flat.Home.xml", IN_HOMES); }

// The large ones, and homes, take a minute: make soak.
Test(lit_seams, others, .timeout = 900) {
    static const char *const HOMES[] = {"sh3d/2BedroomHouseWithBasement.Home.xml",
                                        "sh3d/3BedroomApartment.Home.xml", "sh3d/4-BedroomHouse.sh3d"};
    static const char *const OURS[] = {"build/maps/hillside.sh3d", "build/maps/flat.Home.xml",
                                       "build/maps/villa.sh3d"};
    if (support_count(0, 1) == 0) cr_skip_test("a minute of bakes: make soak");
    check("build/maps/office-plain.plan", 0);
    check("build/maps/office.plan", 0);
    for (int i = 0; i < 3; i++) check(support_either(HOMES[i], OURS[i]), IN_HOMES);
}

// ---- triangles

// Proves that every vertex of a convex polygon is a corner of a triangle that has an area, however many lie on its edges: light
// told at a vertex is shown there. And that the triangles are the polygon.
Test(lit_seams, triangles_reach_every_vertex) {
    Random random = {9};
    for (int n = 0; n < 20000; n++) {
        enum { MOST = 24 };
        Vec3 corner[5], v[MOST];
        int corners = 3 + random_index(&random, 3), count = 0, triangle[3 * MOST];
        double scale = pow(10, random_between(&random, -3, 2)), flat = random_between(&random, 0.05, 1);
        for (int i = 0; i < corners; i++) {
            double angle = 2 * M_PI * (i + random_between(&random, 0, 0.6)) / corners;
            corner[i] = vec3(7 + scale * cos(angle), -3 + scale * flat * sin(angle), 1.5);
        }
        for (int i = 0; i < corners; i++) {
            int more = random_index(&random, 4);
            for (int k = 0; k <= more; k++)
                v[count++] = vec3_lerp(corner[i], corner[(i + 1) % corners], (double)k / (more + 1));
        }
        polygon_triangulate(v, count, triangle);
        double area = 0, whole = polygon_area(v, count);
        bool reached[MOST] = {false};
        for (int t = 0; t < count - 2; t++) {
            const int *k = triangle + 3 * t;
            double part = polygon_area((Vec3[]){v[k[0]], v[k[1]], v[k[2]]}, 3);
            area += part;
            for (int i = 0; i < 3; i++) reached[k[i]] |= part > 1e-6 * whole;
        }
        cr_assert_float_eq(area, whole, 1e-9 * whole);
        for (int i = 0; i < count; i++)
            cr_assert(reached[i], "polygon %d of %d corners: %d is not reached", n, count, i);
    }
}
