// curved_fixture.c - see the header.
#include "tests/support/curved_fixture.h"

#include <criterion/criterion.h>
#include <stdlib.h>

#include "maps/maps.h"

extern const MapsReader MAPS_READER_PLAN;

bool curved_try_model(Arena *arena, const char *lines, const char *words, Building *b, Error *error) {
    char *text = arena_format(arena,
                              "plan 1\nmaterial red #FF0000\nstorey s floor 0 height 3\n"
                              "room a 0,0 8,0 8,4 0,4 wall 0.2\nmodel x\n%s\nend\nplace x %s\n",
                              lines, words);
    memset(b, 0, sizeof *b);
    Bytes bytes = {(unsigned char *)text, strlen(text)};
    if (!MAPS_READER_PLAN.read("t.plan", bytes, arena, b, error)) return false;
    const char *fault = "";
    cr_assert_eq(building_check(b, arena, &fault, 1), 0, "%s: %s", lines, fault);
    return true;
}

void curved_read_model(Arena *arena, const char *lines, const char *words, Building *b) {
    Error error = {""};
    cr_assert(curved_try_model(arena, lines, words, b, &error), "%s: %s", lines, error.text);
    cr_assert_gt(b->shape_count, 0);
}

CurvedMesh curved_all(const Building *b, double tolerance, Arena *arena) {
    CurvedMesh all = {0};
    for (int i = 0; i < b->shape_count; i++) {
        const CurvedShape *s = &b->shapes[i];
        CurvedMesh one = {0};
        if (tolerance > 0) curved_tessellate(b, s, tolerance, arena, &one);
        int count = tolerance > 0 ? one.polygon_count : s->polygon_count;
        all.tolerance = fmax(all.tolerance, tolerance > 0 ? one.tolerance : s->tolerance);
        for (int k = 0; k < count; k++) {
            const Polygon *p = &b->polygons[s->first_polygon + k];
            if (tolerance > 0) {
                curved_mesh_add(&all, arena, one.vertices + one.first[k], one.first[k + 1] - one.first[k],
                                false);
            } else {
                curved_mesh_add(&all, arena, b->vertices + p->first_vertex, p->vertex_count, false);
            }
        }
    }
    return all;
}

typedef struct Stretch {
    Vec3 a, b;
} Stretch;

static int compare_points(Vec3 a, Vec3 b) {
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    return (a.z > b.z) - (a.z < b.z);
}

static int compare_ways(const void *a, const void *b) {
    const Stretch *p = a, *q = b;
    int first = compare_points(p->a, q->a);
    return first ? first : compare_points(p->b, q->b);
}

int curved_find_open(const CurvedMesh *mesh, Arena *arena, Vec3 **ends) {
    int count = mesh->polygon_count ? mesh->first[mesh->polygon_count] : 0, n = 0, open = 0;
    Stretch *there = ARENA_ARRAY(arena, Stretch, count + 1), *back = ARENA_ARRAY(arena, Stretch, count + 1);
    for (int i = 0; i < mesh->polygon_count; i++) {
        for (int k = mesh->first[i]; k < mesh->first[i + 1]; k++) {
            Vec3 a = mesh->vertices[k],
                 b = mesh->vertices[k + 1 < mesh->first[i + 1] ? k + 1 : mesh->first[i]];
            there[n] = (Stretch){a, b};
            back[n++] = (Stretch){b, a};
        }
    }
    *ends = ARENA_ARRAY(arena, Vec3, 2 * n + 1);
    qsort(there, (size_t)n, sizeof *there, compare_ways);
    qsort(back, (size_t)n, sizeof *back, compare_ways);
    for (int i = 0, j = 0; i < n || j < n;) {
        int order = i == n ? 1 : j == n ? -1 : compare_ways(&there[i], &back[j]);
        if (order < 0) {
            (*ends)[2 * open] = there[i].a;
            (*ends)[2 * open++ + 1] = there[i].b;
        }
        i += order <= 0;
        j += order >= 0;
    }
    return open;
}

int curved_open_edges(const CurvedMesh *mesh, Arena *arena) {
    Vec3 *ends;
    return curved_find_open(mesh, arena, &ends);
}

double curved_area(const CurvedMesh *mesh) {
    double area = 0;
    for (int i = 0; i < mesh->polygon_count; i++)
        area += polygon_area(mesh->vertices + mesh->first[i], mesh->first[i + 1] - mesh->first[i]);
    return area;
}

double curved_volume(const CurvedMesh *mesh) {
    double volume = 0;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const Vec3 *v = mesh->vertices + mesh->first[i];
        int n = mesh->first[i + 1] - mesh->first[i];
        volume += plane_of_polygon(v, n).d * polygon_area(v, n) / 3;
    }
    return volume;
}
