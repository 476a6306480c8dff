// still_light.c - radiosity split in two: what lamps send straight is found anew for each point, so that shadows are sharp; what
// came by way of other surfaces is smooth, and is looked up where it was baked (Shirley 1990, A Ray Tracing Method for Illumination
// Calculation in Diffuse-Specular Scenes).
#include "engine/stills/still_light.h"

#include "engine/draw/walk_shade.h"

// Facets of curved shapes are so small that shots hit some of them twice and others not at all: their light is a mean over those within
// this of them, metres, and so many of their own sizes, that look the same way.
static const double SMOOTH = 0.04, SMOOTH_SIZES = 3;
// Facets are looked for so many tolerances to either side of their shape.
static const double FACET_REACH = 4;

// ---- made once

static void difference(const Mesh *mesh, const RadSolution *all, const RadSolution *lamps_only,
                       double (*out)[3]) {
    for (int e = 0; e < mesh->element_count; e++)
        for (int c = 0; c < 3; c++) out[e][c] = fmax(all->radiosity[e][c] - lamps_only->radiosity[e][c], 0);
}

static void find_mean(const Mesh *mesh, const RadSolution *solution, double out[3]) {
    double area = 0;
    out[0] = out[1] = out[2] = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        for (int c = 0; c < 3; c++) out[c] += mesh->elements[e].area * solution->radiosity[e][c];
        // Mirrors show the rest.
        area += mesh->elements[e].area * (1 - (double)mesh_material(mesh, mesh->elements[e].face)->mirror);
    }
    for (int c = 0; c < 3 && area > 0; c++) out[c] /= area;
}

// The sum for one element, over those from `first` to `end`.
static void smooth_element(const Mesh *mesh, const Vec3 *centres, int element, int first, int end,
                           double (*from)[3], double out[3]) {
    const Element *e = &mesh->elements[element];
    double reach = fmax(SMOOTH, SMOOTH_SIZES * sqrt(e->area)), weights = 0;
    Vec3 n = mesh->faces[e->face].plane.n;
    out[0] = out[1] = out[2] = 0;
    for (int k = first; k < end; k++) {
        Vec3 way = vec3_sub(centres[k], centres[element]);
        double d2 = vec3_dot(way, way) / (reach * reach);
        double alike = vec3_dot(n, mesh->faces[mesh->elements[k].face].plane.n);
        if (d2 >= 1 || alike <= 0) continue;
        double weight = mesh->elements[k].area * (1 - d2) * (1 - d2) * alike * alike;
        for (int c = 0; c < 3; c++) out[c] += weight * from[k][c];
        weights += weight;
    }
    for (int c = 0; c < 3; c++) out[c] /= weights;
}

// The faces of a shape follow each other.
static void smooth_shapes(const Mesh *mesh, double (*light)[3]) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    Vec3 *centres = ARENA_ARRAY(&scratch, Vec3, mesh->element_count + 1);
    double(*from)[3] = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *from);
    memcpy(from, light, (size_t)mesh->element_count * sizeof *from);
    for (int e = 0; e < mesh->element_count; e++) centres[e] = element_centroid(mesh, e);
    for (int s = 0; s < graph->building->shape_count; s++) {
        const CurvedShape *shape = &graph->building->shapes[s];
        int first = still_first_polygon(graph, shape), low = mesh->element_count, end = 0;
        for (int p = first; p < first + shape->polygon_count; p++) {
            if (mesh->face_of[p] < 0) continue;
            const Face *face = &mesh->faces[mesh->face_of[p]];
            low = face->first_element < low ? face->first_element : low;
            if (face->first_element + face->element_count > end)
                end = face->first_element + face->element_count;
        }
        for (int e = low; e < end; e++) smooth_element(mesh, centres, e, low, end, from, light[e]);
    }
    arena_free(&scratch);
}

StillLight still_light_new(const StillScene *scene, const RadSolution *solution,
                           const RadSolution *lamps_only, StillLamps *lamps, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    StillLight light = {.scene = scene, .lamps = lamps};
    Arena scratch = {0};
    RadSolution shown = *solution;
    if (lamps) {
        shown.radiosity = arena_alloc(&scratch, (size_t)mesh->element_count, sizeof *shown.radiosity);
        difference(mesh, solution, lamps_only, shown.radiosity);
        smooth_shapes(mesh, shown.radiosity);
        // Light gathered at nodes is not split.
        shown.node = NULL;
        shown.node_count = 0;
    }
    light.baked = reconstruct_light(mesh, &shown, arena);
    light.baked.triangle = reconstruct_triangles(mesh, arena);
    find_mean(mesh, solution, light.mean);
    arena_free(&scratch);
    return light;
}

// ---- where on the mesh

typedef struct Spot {
    int element;  // -1: none
    Vec3 point;   // of its plane
} Spot;

static int facet_near(const StillScene *scene, const CurvedShape *shape, const SurfaceHit *hit, Vec3 at,
                      Spot *out) {
    double reach = FACET_REACH * shape->tolerance;
    for (int side = 1; side >= -1; side -= 2) {
        Vec3 way = vec3_scale(hit->at.normal, -side);
        Ray ray = {vec3_sub(at, vec3_scale(way, reach)), way, 0, 2 * reach};
        SurfaceHit facet = still_rays_first(&scene->facets, &ray);
        if (facet.item < 0 || scene->facet_face[facet.item] < 0) continue;
        out->point = still_ray_at(&ray, facet.at.t);
        return scene->facet_face[facet.item];
    }
    return -1;
}

// Among a shape's faces the one whose middle is nearest: where no facet lies before the point.
static int face_near(const Mesh *mesh, int object, Vec3 at) {
    const Object *o = &mesh->graph->objects[object];
    int best = -1;
    double nearest = INFINITY;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        int f = mesh->face_of[p];
        if (f < 0) continue;
        const Face *face = &mesh->faces[f];
        Vec3 sum = {0, 0, 0};
        for (int i = 0; i < face->vertex_count; i++)
            sum = vec3_add(sum, mesh->vertices[mesh->outline[face->first_vertex + i]]);
        Vec3 to = vec3_sub(vec3_scale(sum, 1.0 / face->vertex_count), at);
        double d2 = vec3_dot(to, to);
        if (d2 >= nearest) continue;
        nearest = d2;
        best = f;
    }
    return best;
}

static Spot find_spot(const StillScene *scene, const StillSurface *s, const SurfaceHit *hit, Vec3 at) {
    const Mesh *mesh = scene->mesh;
    Spot spot = {-1, at};
    int face = s->face;
    if (s->shape >= 0) {
        face = facet_near(scene, &mesh->graph->building->shapes[s->shape], hit, at, &spot);
        if (face < 0) face = face_near(mesh, s->object, at);
    }
    if (face >= 0) spot.element = mesh_element_at(mesh, face, spot.point);
    return spot;
}

// ---- light

static void add_lamps(const StillLight *light, const StillSurface *s, const Spot *spot, Vec3 at, Vec3 normal,
                      bool front, int rays, StillNumbers *numbers, double out[3]) {
    double arrives[3];
    still_lamps_light(light->lamps, &(StillPlace){at, normal, spot->element, front}, rays, numbers, arrives);
    out[0] += (double)s->material->reflectance.r * arrives[0];
    out[1] += (double)s->material->reflectance.g * arrives[1];
    out[2] += (double)s->material->reflectance.b * arrives[2];
}

void still_light_at(const StillLight *light, const Ray *ray, const SurfaceHit *hit, int rays,
                    StillNumbers *numbers, double out[3]) {
    const StillSurface *s = &light->scene->surfaces[hit->item];
    Vec3 at = still_ray_at(ray, hit->at.t), normal = vec3_scale(hit->at.normal, hit->front ? 1 : -1);
    Spot spot = find_spot(light->scene, s, hit, at);
    out[0] = out[1] = out[2] = 0;
    // The back of a polygon reflects nothing, as light is computed; curtains are one all the same, and show some of their front's.
    double share = hit->front ? 1 : WALK_BACK_SHARE;
    if (spot.element >= 0) {
        reconstruct_in(light->scene->mesh, &light->baked, spot.element, spot.point, out);
        for (int c = 0; c < 3; c++) out[c] *= share;
        if (light->lamps) add_lamps(light, s, &spot, at, normal, hit->front, rays, numbers, out);
    }
    // Elsewhere it is in what was baked.
    if (hit->front && (light->lamps || spot.element < 0)) {
        out[0] += (double)s->material->emission.r;
        out[1] += (double)s->material->emission.g;
        out[2] += (double)s->material->emission.b;
    }
}
