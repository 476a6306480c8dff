// mesh_centres.c - the places from which patches look and shoot, moved out of things that stand on them or pierce them.
//
// A lamp's glass hangs on a cord, a floor bears a table's leg: from inside such a thing a patch would see its inside alone, and all
// light of the patch would go there.
#include "engine/core/parallel.h"
#include "radiosity/mesh/mesh_parts.h"
#include "visibility/rays/ray_surfaces.h"

// A place is covered where each of so many rays, half way up from the face, meets a back first.
enum { RAYS = 6 };
// Turns the rays away from the edges of faces, which mostly lie along the face's grid, radians.
static const double TURN = 0.37;
// Rays begin so far from the face, metres: farther than faces in one place lie apart.
static const double BEGIN = 1e-6;
// Places that are tried in an element beside its middle, as shares of the way to its corners.
static const double WAYS[] = {0.25, 0.5, 0.75};
enum { PATCHES_A_GROUP = 256 };

typedef struct Centres {
    Mesh *mesh;
    const SurfaceTree *tree;
} Centres;

// Faces that move with a door are left out, so that the mesh is the same wherever doors stand.
static bool stands_still(const Mesh *mesh, const Face *face) {
    const Object *object = &mesh->graph->objects[face->object];
    return object->leaf < 0 && !object->plug;
}

// Meshes that are not cut along things only tell how fine others are to be: there lamps alone are asked.
static bool is_asked(const Mesh *mesh, const Face *face) {
    return stands_still(mesh, face) &&
           (mesh->options.close > 0 || mesh_is_lamp(mesh, (int)(face - mesh->faces)));
}

static bool is_covered(const Centres *c, const Face *face, Vec3 place) {
    Vec3 x = vec3_normalize(face->gx), y = vec3_cross(face->plane.n, x);
    for (int i = 0; i < RAYS; i++) {
        double turn = TURN + 2 * M_PI * i / RAYS;
        Vec3 along = vec3_add(vec3_scale(x, cos(turn)), vec3_scale(y, sin(turn)));
        Ray ray = {place, vec3_scale(vec3_add(along, face->plane.n), M_SQRT1_2), BEGIN, INFINITY};
        SurfaceHit hit = surface_tree_first(c->tree, &ray);
        if (hit.item < 0 || hit.front) return false;
    }
    return true;
}

typedef struct Search {
    const Face *face;
    Vec3 from, best;
    double nearest;
} Search;

static void try_place(const Centres *c, Search *s, Vec3 place) {
    double away = vec3_length(vec3_sub(place, s->from));
    if (away >= s->nearest || is_covered(c, s->face, place)) return;
    s->nearest = away;
    s->best = place;
}

// The free place of a patch that is nearest to its centre; where there is none, the centre.
static Vec3 free_place(const Centres *c, const Patch *patch) {
    const Mesh *mesh = c->mesh;
    Search s = {&mesh->faces[patch->face], patch->centre, patch->centre, INFINITY};
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const int *corner = mesh->corners + element->first_corner;
        Vec3 middle = {0, 0, 0};
        for (int k = 0; k < element->corner_count; k++)
            middle = vec3_add(middle, vec3_scale(mesh->vertices[corner[k]], 1.0 / element->corner_count));
        try_place(c, &s, middle);
        for (int k = 0; k < element->corner_count; k++)
            for (int w = 0; w < (int)(sizeof WAYS / sizeof *WAYS); w++)
                try_place(c, &s, vec3_lerp(middle, mesh->vertices[corner[k]], WAYS[w]));
    }
    return s.best;
}

static void free_group(void *context, int group, int thread) {
    (void)thread;
    const Centres *c = context;
    int first = group * PATCHES_A_GROUP, end = first + PATCHES_A_GROUP;
    for (int p = first; p < end && p < c->mesh->patch_count; p++) {
        Patch *patch = &c->mesh->patches[p];
        const Face *face = &c->mesh->faces[patch->face];
        if (!is_asked(c->mesh, face)) continue;
        patch->covered = is_covered(c, face, patch->centre);
        if (patch->covered) patch->centre = free_place(c, patch);
    }
}

static bool any_asked(const Mesh *mesh) {
    for (int f = 0; f < mesh->face_count; f++)
        if (is_asked(mesh, &mesh->faces[f])) return true;
    return false;
}

void mesh_free_centres(Mesh *mesh) {
    if (!any_asked(mesh)) return;
    Arena scratch = {0};
    Polygon *polygons = ARENA_ARRAY(&scratch, Polygon, mesh->face_count + 1);
    int *list = ARENA_ARRAY(&scratch, int, mesh->face_count + 1), count = 0;
    Vec3 *outline = ARENA_ARRAY(&scratch, Vec3, mesh->outline_count + 1);
    for (int i = 0; i < mesh->outline_count; i++) outline[i] = mesh->vertices[mesh->outline[i]];
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        polygons[f] = (Polygon){.first_vertex = face->first_vertex, .vertex_count = face->vertex_count};
        if (stands_still(mesh, face)) list[count++] = f;
    }
    RaySurfaces surfaces = ray_surfaces_new(&(RaySource){.building = mesh->graph->building,
                                                         .polygons = polygons,
                                                         .vertices = outline,
                                                         .list = list,
                                                         .list_count = count},
                                            &scratch);
    SurfaceTree tree = surface_tree_new(&surfaces, &scratch);
    int groups = (mesh->patch_count + PATCHES_A_GROUP - 1) / PATCHES_A_GROUP;
    parallel_for(parallel_threads(mesh->options.threads), groups, free_group, &(Centres){mesh, &tree});
    arena_free(&scratch);
}
