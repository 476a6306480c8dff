// still_scene.c - chooses the polygons and shapes that rays meet, tells glass from opaque surfaces, and finds closed bodies of glass.
#include "engine/stills/still_scene.h"

#include "visibility/vis.h"

const char *const STILL_TREE_NAMES[STILL_TREES] = {"own", "grid"};

// A body is closed where the sum of its area vectors is less than this share of its area; it has a volume where that is more than
// this share of the area to the power of 3/2: two sheets back to back have none.
static const double CLOSED = 1e-4, FLAT = 1e-9;

struct StillRays {
    RaySurfaces surfaces;
    SurfaceTree tree;
    SurfaceGrid grid;
    int kind;  // STILL_TREE_OWN ..
};

static bool is_glass(const Material *m) { return m->alpha < 1; }

SurfaceHit still_rays_first(const StillRays *rays, const Ray *ray) {
    return rays->kind == STILL_TREE_GRID ? surface_grid_first(&rays->grid, ray)
                                         : surface_tree_first(&rays->tree, ray);
}

bool still_rays_blocked(const StillRays *rays, const Ray *ray) {
    return rays->kind == STILL_TREE_GRID ? surface_grid_blocked(&rays->grid, ray)
                                         : surface_tree_blocked(&rays->tree, ray);
}

static StillRays *make_rays(const RaySource *source, int kind, Arena *arena) {
    StillRays *rays = ARENA_ARRAY(arena, StillRays, 1);
    rays->kind = kind;
    rays->surfaces = ray_surfaces_new(source, arena);
    if (kind == STILL_TREE_GRID)
        rays->grid = surface_grid_new(&rays->surfaces, arena);
    else
        rays->tree = surface_tree_new(&rays->surfaces, arena);
    return rays;
}

// ---- which polygons

typedef struct Parts {
    const CellGraph *graph;
    int *object_of;      // [polygon_count]
    int *shape_of;       // [polygon_count] the shape that it is part of, -1: none
    int *body_of;        // [polygon_count] -1: none
    int *body_of_shape;  // [shape_count]
    int body_count;
} Parts;

// Is the shape itself drawn? Not on a door leaf, because the shape does not move with the leaf: its polygons do.
static bool is_drawn(const CellGraph *graph, const CurvedShape *shape) {
    return graph->objects[shape->object].leaf < 0;
}

int still_first_polygon(const CellGraph *graph, const CurvedShape *shape) {
    int into = shape->first_polygon - graph->building->objects[shape->object].first_polygon;
    return graph->objects[shape->object].first_polygon + into;
}

static void find_shapes(Parts *parts) {
    const CellGraph *graph = parts->graph;
    for (int p = 0; p < graph->polygon_count; p++) parts->shape_of[p] = -1;
    for (int s = 0; s < graph->building->shape_count; s++) {
        const CurvedShape *shape = &graph->building->shapes[s];
        int first = still_first_polygon(graph, shape);
        for (int p = first; p < first + shape->polygon_count && is_drawn(graph, shape); p++)
            parts->shape_of[p] = s;
    }
}

// Do the polygons of one material of an object enclose a space?
static bool is_closed(const CellGraph *graph, const Vec3 *vertices, const Object *object, int material) {
    Vec3 sum = {0, 0, 0}, origin = vertices[graph->polygons[object->first_polygon].first_vertex];
    double area = 0, volume = 0;
    for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        if (polygon->material != material) continue;
        const Vec3 *v = vertices + polygon->first_vertex;
        double here = polygon_area(v, polygon->vertex_count);
        Plane plane = plane_of_polygon(v, polygon->vertex_count);
        area += here;
        sum = vec3_add(sum, vec3_scale(plane.n, here));
        volume += here * (plane.d - vec3_dot(plane.n, origin)) / 3;
    }
    return vec3_length(sum) < CLOSED * area && volume > FLAT * area * sqrt(area);
}

static void find_bodies(Parts *parts, const Vec3 *vertices) {
    const CellGraph *graph = parts->graph;
    for (int p = 0; p < graph->polygon_count; p++) parts->body_of[p] = -1;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        int end = object->first_polygon + object->polygon_count;
        for (int p = object->first_polygon; p < end; p++) {
            int material = graph->polygons[p].material;
            parts->object_of[p] = o;
            bool told = false;
            for (int q = object->first_polygon; q < p && !told; q++)
                told = graph->polygons[q].material == material;
            if (told || !is_glass(&graph->building->materials[material]) ||
                !is_closed(graph, vertices, object, material))
                continue;
            for (int q = p; q < end; q++)
                if (graph->polygons[q].material == material) parts->body_of[q] = parts->body_count;
            parts->body_count++;
        }
    }
    for (int s = 0; s < graph->building->shape_count; s++) {
        const CurvedShape *shape = &graph->building->shapes[s];
        parts->body_of_shape[s] =
            shape->polygon_count > 0 ? parts->body_of[still_first_polygon(graph, shape)] : -1;
    }
}

static Parts find_parts(const CellGraph *graph, const Vec3 *vertices, Arena *scratch) {
    Parts parts = {.graph = graph,
                   .object_of = ARENA_ARRAY(scratch, int, graph->polygon_count + 1),
                   .shape_of = ARENA_ARRAY(scratch, int, graph->polygon_count + 1),
                   .body_of = ARENA_ARRAY(scratch, int, graph->polygon_count + 1),
                   .body_of_shape = ARENA_ARRAY(scratch, int, graph->building->shape_count + 1)};
    find_shapes(&parts);
    find_bodies(&parts, vertices);
    return parts;
}

// ---- the scene

// The surfaces that are wanted: all, or the opaque ones, each as polygons and shapes; or the polygons of shapes.
typedef enum Wanted { WANT_ALL, WANT_OPAQUE, WANT_FACETS } Wanted;

static RaySource source_of(const StillScene *scene, const Parts *parts, const float *door_open, Wanted wanted,
                           Arena *scratch) {
    const CellGraph *graph = scene->mesh->graph;
    const Building *b = graph->building;
    int *list = ARENA_ARRAY(scratch, int, graph->polygon_count + 1), count = 0;
    int *shapes = ARENA_ARRAY(scratch, int, b->shape_count + 1), shape_count = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        if (!vis_shown(object, door_open)) continue;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            if ((parts->shape_of[p] >= 0) != (wanted == WANT_FACETS)) continue;
            if (wanted == WANT_OPAQUE && is_glass(&b->materials[graph->polygons[p].material])) continue;
            list[count++] = p;
        }
    }
    for (int s = 0; s < b->shape_count && wanted != WANT_FACETS; s++) {
        if (!is_drawn(graph, &b->shapes[s])) continue;
        if (wanted == WANT_OPAQUE && is_glass(&b->materials[b->shapes[s].material])) continue;
        shapes[shape_count++] = s;
    }
    return (RaySource){b, graph->polygons, scene->vertices, list, shapes, count, shape_count};
}

static void put_surfaces(StillScene *scene, const Parts *parts, const RaySource *source,
                         const float *door_open, Arena *arena) {
    const CellGraph *graph = scene->mesh->graph;
    const Building *b = graph->building;
    scene->surfaces = ARENA_ARRAY(arena, StillSurface, source->list_count + source->shape_count + 1);
    for (int i = 0; i < source->list_count; i++) {
        int p = source->list[i], leaf = graph->objects[parts->object_of[p]].leaf;
        bool moves = leaf >= 0 && door_open;
        scene->surfaces[i] = (StillSurface){&b->materials[graph->polygons[p].material],
                                            scene->mesh->face_of[p],
                                            -1,
                                            parts->body_of[p],
                                            parts->object_of[p],
                                            graph->polygons[p].texture_map,
                                            moves ? (double)door_open[b->leaves[leaf].opening] : 0};
    }
    for (int i = 0; i < source->shape_count; i++) {
        int s = source->shapes[i];
        scene->surfaces[source->list_count + i] = (StillSurface){
            &b->materials[b->shapes[s].material], -1, s, parts->body_of_shape[s], b->shapes[s].object, 0, 0};
    }
}

Texel still_texel(const StillScene *scene, const StillSurface *s, Vec3 point, double width) {
    const Material *m = s->material;
    const CellGraph *graph = scene->mesh->graph;
    const Building *b = graph->building;
    int leaf = graph->objects[s->object].leaf;
    if (m->texture == 0) return (Texel){m->reflectance, m->alpha};
    if (leaf >= 0) point = leaf_point_closed(&b->leaves[leaf], s->open, point);
    Texel texel = texture_at(b, (int)(m - b->materials), s->texture_map, point, width);
    float opacity = b->textures[m->texture].opacity;
    bool mapped = s->texture_map > 0 || m->texture_map > 0;
    texel.opacity = mapped && m->alpha < 1 ? fminf(m->alpha * texel.opacity / opacity, 1) : m->alpha;
    return texel;
}

StillScene *still_scene_new(const Mesh *mesh, const float *door_open, int tree, Arena *arena) {
    StillScene *scene = ARENA_ARRAY(arena, StillScene, 1);
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    scene->mesh = mesh;
    scene->vertices = ARENA_ARRAY(arena, Vec3, graph->vertex_count + 1);
    if (graph->vertex_count > 0)
        memcpy(scene->vertices, graph->vertices, (size_t)graph->vertex_count * sizeof *scene->vertices);
    if (door_open) vis_pose(graph, door_open, scene->vertices);
    Parts parts = find_parts(graph, scene->vertices, &scratch);
    scene->body_count = parts.body_count;
    RaySource all = source_of(scene, &parts, door_open, WANT_ALL, &scratch);
    RaySource opaque = source_of(scene, &parts, door_open, WANT_OPAQUE, &scratch);
    RaySource facets = source_of(scene, &parts, door_open, WANT_FACETS, &scratch);
    scene->all = make_rays(&all, tree, arena);
    scene->opaque = make_rays(&opaque, tree, arena);
    scene->facets = make_rays(&facets, tree, arena);
    put_surfaces(scene, &parts, &all, door_open, arena);
    scene->facet_face = ARENA_ARRAY(arena, int, facets.list_count + 1);
    for (int i = 0; i < facets.list_count; i++) scene->facet_face[i] = mesh->face_of[facets.list[i]];
    arena_free(&scratch);
    return scene;
}

// ---- the bodies around a point

// Upwards, a little aslant, so that the ray lies in no wall.
static const Vec3 LOOK_OUT = {0.0312, 0.0517, 0.9982};
// The most surfaces that the ray looks through.
enum { LOOKS = 1024 };

// A ray from inside a body leaves the body before it enters it. The body left first is the innermost.
Media still_scene_media(const StillScene *scene, Vec3 point) {
    Arena scratch = {0};
    bool *seen = ARENA_ARRAY(&scratch, bool, scene->body_count + 1);
    Media outwards = {0}, media = {0};
    Ray ray = {point, vec3_normalize(LOOK_OUT), 0, INFINITY};
    for (int i = 0; i < LOOKS && scene->body_count > 0; i++) {
        SurfaceHit hit = still_rays_first(scene->all, &ray);
        if (hit.item < 0) break;
        const StillSurface *s = &scene->surfaces[hit.item];
        ray.near = hit.at.t + STILL_NEAR;
        if (s->body < 0 || seen[s->body]) continue;
        seen[s->body] = true;
        if (!hit.front && s->material->index > 0)
            outwards = media_enter(&outwards, s->body, (double)s->material->index);
    }
    for (int i = outwards.count - 1; i >= 0; i--)
        media = media_enter(&media, outwards.in[i].body, outwards.in[i].index);
    arena_free(&scratch);
    return media;
}
