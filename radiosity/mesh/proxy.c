// proxy.c - which polygons are too fine for light to tell apart, and the stand-ins for them: collapsed edges, then flat pieces merged.
//
// Chosen among vertex clustering on a grid (Rossignac & Borrel 1993) and shared elements on fine polygons: README.md has the
// figures.
#include "radiosity/mesh/proxy.h"

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh_places.h"
#include "radiosity/mesh/proxy_merge.h"
#include "radiosity/mesh/simplify.h"

// A polygon narrower than this, its area over its longest edge, is fine, metres: half the edge of the smallest elements. Light is
// not told apart across it.
static const double NARROW = 0.03;
// An object with fewer fine polygons is left as it is: the views of a room have hundreds of polygons anyway.
enum { FEWEST = 64 };
// And one whose stand-in has more polygons than this share of those it stands for: it would cost accuracy for little.
static const double WORTH = 0.7;

typedef struct Finder {
    const CellGraph *graph;
    const Vec3 *vertices;
    Proxies *out;
    Arena *arena;
    int polygon_capacity, vertex_capacity;
} Finder;

static bool polygon_emits(const CellGraph *graph, int polygon) {
    Rgb e = graph->building->materials[graph->polygons[polygon].material].emission;
    return e.r + e.g + e.b > 0;
}

static bool is_fine(const Finder *f, int polygon) {
    const Polygon *p = &f->graph->polygons[polygon];
    const Vec3 *v = f->vertices + p->first_vertex;
    double longest = 0;
    if (vis_is_glass(f->graph, polygon) || polygon_emits(f->graph, polygon)) return false;
    for (int i = 0; i < p->vertex_count; i++)
        longest = fmax(longest, vec3_length(vec3_sub(v[(i + 1) % p->vertex_count], v[i])));
    return polygon_area(v, p->vertex_count) < NARROW * longest;
}

static bool may_stand_in(const Object *object) {
    return object->kind != OBJECT_SURFACE && object->leaf < 0 && !object->plug;
}

static int count_fine(const Finder *f, const Object *object) {
    int count = 0;
    for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
        count += is_fine(f, p);
    return count;
}

// ---- one object

// The fine polygons of an object as triangles that share corners, and what they hang on.
typedef struct Model {
    Places places;
    SimplifyTriangle *triangles;
    unsigned char *locked;
    int triangle_count, triangle_capacity, locked_capacity;
} Model;

static int vertex_place(Model *m, Vec3 v, Arena *arena) {
    int before = m->places.count, place = places_add(&m->places, v);
    if (place == before) *ARENA_PUSH(arena, m->locked, before, m->locked_capacity) = 0;
    return place;
}

static void add_triangles(Model *m, const Vec3 *v, int count, int tag, Arena *arena) {
    int *triangle = ARENA_ARRAY(arena, int, 3 * count);
    polygon_triangulate(v, count, triangle);
    for (int i = 0; i < count - 2; i++) {
        SimplifyTriangle t = {.tag = tag};
        for (int k = 0; k < 3; k++) t.corner[k] = vertex_place(m, v[triangle[3 * i + k]], arena);
        if (t.corner[0] == t.corner[1] || t.corner[1] == t.corner[2] || t.corner[2] == t.corner[0]) continue;
        *ARENA_PUSH(arena, m->triangles, m->triangle_count, m->triangle_capacity) = t;
    }
}

// Faces that stay hold the corners that they share with fine ones.
static Model model_of(const Finder *f, const Object *object, Arena *arena) {
    Model m = {0};
    places_start(&m.places, arena);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
            const Polygon *p = &f->graph->polygons[i];
            const Vec3 *v = f->vertices + p->first_vertex;
            bool fine = is_fine(f, i);
            if (pass == 0 && fine) add_triangles(&m, v, p->vertex_count, p->material, arena);
            for (int k = 0; pass == 1 && !fine && k < p->vertex_count; k++)
                m.locked[vertex_place(&m, v[k], arena)] = 1;
        }
    }
    return m;
}

static void add_proxy_polygon(Finder *f, const Model *m, const ProxyPolygon *p) {
    Proxies *out = f->out;
    *ARENA_PUSH(f->arena, out->polygons, out->polygon_count, f->polygon_capacity) =
        (Polygon){out->vertex_count, p->count, p->tag};
    for (int k = 0; k < p->count; k++)
        *ARENA_PUSH(f->arena, out->vertices, out->vertex_count, f->vertex_capacity) =
            m->places.points[p->corner[k]];
}

static void find_of_object(Finder *f, int index) {
    const Object *object = &f->graph->objects[index];
    int fine = may_stand_in(object) ? count_fine(f, object) : 0, merged = 0;
    if (fine < FEWEST) return;
    Arena scratch = {0};
    Model m = model_of(f, object, &scratch);
    SimplifySurface surface = {m.places.points, m.locked, m.places.count, m.triangles, m.triangle_count};
    int triangles = simplify(&surface, f->out->tolerance);
    const ProxyPolygon *polygons = proxy_merge(m.places.points, m.triangles, triangles, &scratch);
    for (int i = 0; i < triangles; i++) merged += polygons[i].count > 0;
    if (merged <= WORTH * fine) {
        for (int i = 0; i < triangles; i++)
            if (polygons[i].count > 0) add_proxy_polygon(f, &m, &polygons[i]);
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            f->out->replaced[p] = is_fine(f, p);
        f->out->object_count++;
        f->out->replaced_count += fine;
    }
    arena_free(&scratch);
}

const Proxies *proxies_find(const CellGraph *graph, const Vec3 *vertices, double tolerance, Arena *arena) {
    if (!(tolerance > 0)) return NULL;
    Proxies *out = ARENA_ARRAY(arena, Proxies, 1);
    Finder f = {graph, vertices ? vertices : graph->vertices, out, arena, 0, 0};
    // As files have it.
    *out = (Proxies){.tolerance = nearbyint(tolerance / PROXY_STEP) * PROXY_STEP,
                     .first = ARENA_ARRAY(arena, int, graph->object_count + 1),
                     .replaced = ARENA_ARRAY(arena, bool, graph->polygon_count + 1)};
    for (int o = 0; o < graph->object_count; o++) {
        find_of_object(&f, o);
        out->first[o + 1] = out->polygon_count;
    }
    if (out->object_count == 0) return NULL;
    vis_register(graph, out->polygons, out->vertices, out->first, arena, &out->graph);
    return out;
}
