// facets.c - polygons become facets: those of no area are left out, bent ones cut into triangles, concave ones into ears.
#include "visibility/hidden/facets.h"

#include <float.h>
#include <string.h>

#include "engine/core/polygon.h"

// A polygon bent by less is flat, metres: no method can tell at 1e-9 of a depth of a metre.
#define FACET_FLAT 1e-9

typedef struct Maker {
    Facets *out;
    Arena *arena;
    int capacity, corner_capacity;
    int polygon, order;
} Maker;

static bool check(const Vec3 *v, int count, int polygon, double *reach, Error *error) {
    for (int i = 0; i < count; i++) {
        double far = fmax(fabs(v[i].x), fmax(fabs(v[i].y), fabs(v[i].z)));
        // fmax passes over NAN.
        if (!isfinite(v[i].x + v[i].y + v[i].z) || far > MAPS_LIMIT)
            return error_set(error, "polygon %d: corner %d is at (%g, %g, %g) (limit %g)", polygon, i, v[i].x,
                             v[i].y, v[i].z, MAPS_LIMIT);
        *reach = fmax(*reach, far);
    }
    return true;
}

static double rounding_of(double reach) { return 4 * DBL_EPSILON * fmax(reach, 1e-3); }

static void add_facet(Maker *m, const Vec3 *v, int count, Vec3 n) {
    Facets *out = m->out;
    Facet *facet = ARENA_PUSH(m->arena, out->facets, out->count, m->capacity);
    Vec3 offset = {0, 0, 0};
    double reach = 0;
    *facet =
        (Facet){.polygon = m->polygon, .order = m->order, .first = out->corner_count, .count = count, .n = n};
    for (int i = 0; i < count; i++) {
        offset = vec3_add(offset, vec3_sub(v[i], v[0]));
        reach = fmax(reach, fmax(fabs(v[i].x), fmax(fabs(v[i].y), fabs(v[i].z))));
        *ARENA_PUSH(m->arena, out->corners, out->corner_count, m->corner_capacity) = v[i];
    }
    facet->centre = vec3_add(v[0], vec3_scale(offset, 1.0 / count));
    facet->rounding = rounding_of(reach);
}

// A planar convex polygon: all at once, or run by run of its corners with the first one.
static void add_planar(Maker *m, const Vec3 *v, int count) {
    Vec3 n = plane_of_polygon(v, count).n;
    if (vec3_length(n) == 0) return;
    if (count <= FACET_CORNERS) {
        add_facet(m, v, count, n);
        return;
    }
    Vec3 run[FACET_CORNERS] = {v[0]};
    for (int at = 1; at + 1 < count; at += FACET_CORNERS - 2) {
        int taken = count - at < FACET_CORNERS - 1 ? count - at : FACET_CORNERS - 1;
        memcpy(run + 1, v + at, sizeof(Vec3) * (size_t)taken);
        if (polygon_area(run, taken + 1) > 0) add_facet(m, run, taken + 1, n);
    }
}

static void add_triangle_facets(Maker *m, const Vec3 *v, int count) {
    Arena scratch = {0};
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * (count - 2));
    polygon_triangulate(v, count, triangle);
    for (int i = 0; i < count - 2; i++) {
        Vec3 t[3] = {v[triangle[3 * i]], v[triangle[3 * i + 1]], v[triangle[3 * i + 2]]};
        add_planar(m, t, 3);
    }
    arena_free(&scratch);
}

// As a reader of buildings would take it.
static void add_ears(Maker *m, const Vec3 *v, int count, double flat) {
    Arena scratch = {0};
    Building b = {0};
    building_add_object(&scratch, &b, OBJECT_FURNITURE, NULL);
    building_add_polygon(&scratch, &b, v, count, 0);
    for (int i = 0; i < b.polygon_count; i++) {
        const Vec3 *piece = b.vertices + b.polygons[i].first_vertex;
        int corners = b.polygons[i].vertex_count;
        bool bent = polygon_bend(piece, corners, plane_of_polygon(piece, corners)) > flat;
        if (bent) {
            add_triangle_facets(m, piece, corners);
        } else {
            add_planar(m, piece, corners);
        }
    }
    arena_free(&scratch);
}

static void add_facets_of(Maker *m, const Vec3 *v, int count, double flat) {
    if (count < 3) return;
    Plane plane = plane_of_polygon(v, count);
    if (vec3_length(plane.n) == 0) return;
    if (count > 3 && !polygon_is_convex(v, count, plane.n)) {
        add_ears(m, v, count, flat);
    } else if (count > 3 && polygon_bend(v, count, plane) > flat) {
        add_triangle_facets(m, v, count);
    } else {
        add_planar(m, v, count);
    }
}

bool facets_new(const Scene *scene, Arena *arena, Facets *out, Error *error) {
    *out = (Facets){0};
    Maker maker = {.out = out, .arena = arena};
    double reach = 0;
    int corners = 0;
    for (int i = 0; i < scene->count; i++) {
        int index = scene->list ? scene->list[i] : i;
        const Polygon *polygon = &scene->polygons[index];
        const Vec3 *v = scene->vertices + polygon->first_vertex;
        if (!check(v, polygon->vertex_count, index, &reach, error)) return false;
        corners += polygon->vertex_count;
    }
    // Room for all, if none is cut.
    maker.capacity = scene->count + 1;
    maker.corner_capacity = corners + 1;
    out->facets = ARENA_ARRAY(arena, Facet, maker.capacity);
    out->corners = ARENA_ARRAY(arena, Vec3, maker.corner_capacity);
    out->rounding = rounding_of(reach);
    for (maker.order = 0; maker.order < scene->count; maker.order++) {
        maker.polygon = scene->list ? scene->list[maker.order] : maker.order;
        const Polygon *polygon = &scene->polygons[maker.polygon];
        add_facets_of(&maker, scene->vertices + polygon->first_vertex, polygon->vertex_count,
                      fmax(FACET_FLAT, out->rounding));
    }
    return true;
}

Scene facets_scene(const Facets *facets, Arena *arena) {
    Polygon *polygons = ARENA_ARRAY(arena, Polygon, facets->count + 1);
    for (int i = 0; i < facets->count; i++)
        polygons[i] = (Polygon){facets->facets[i].first, facets->facets[i].count, 0, 0};
    return (Scene){polygons, facets->corners, NULL, facets->count};
}
