// final_gather.c - a gather at each node (Reichert 1992; Cohen & Wallace 1993, chapter 11): B = E + rho H.
//
// A node lies on edges, where walls hold the eye in their planes and a corner's other wall is not in sight: it is moved a
// hair towards the middle of the elements that meet there. Where they lie in one plane one look does for all; of round things
// each is looked from with its own normal, since a point between facets is inside.
#include "radiosity/show/final_gather.h"

#include "engine/core/parallel.h"

// The hair: a share of the way, and metres at most. Above the rounding of coordinates, below a visible distance.
static const double HAIR = 0.01, LONGEST_HAIR = 1e-3;
static const double SAME_PLANE = 1e-6;  // 1 - cosine, as nodes have it
// Nodes between two looks at progress: a tenth of a second or so.
enum { NODES_A_LOOK = 512 };

typedef struct Final {
    const GatherScene *scene;
    Nodes nodes;
    Gatherer **gatherer;  // [threads]
    double (*out)[3];     // [nodes.count]
    int first;            // of this look
} Final;

// Irradiance on the plane of an element, at a place between the node and `towards`.
static void look_from(Gatherer *gatherer, const Mesh *mesh, Vec3 node, Vec3 towards, int element,
                      double h[3]) {
    const Element *e = &mesh->elements[element];
    const Face *face = &mesh->faces[e->face];
    Vec3 way = vec3_sub(towards, node);
    double length = vec3_length(way), hair = fmin(HAIR * length, LONGEST_HAIR);
    Vec3 at = length > 0 ? vec3_add(node, vec3_scale(way, hair / length)) : node;
    at = vec3_sub(at, vec3_scale(face->plane.n, plane_distance(face->plane, at)));
    // A wall lies in one cell; a thing in a room may reach into several.
    bool surface = mesh->graph->objects[face->object].kind == OBJECT_SURFACE;
    int hint = mesh->patches[e->patch].cell;
    int cell = surface ? hint : gather_cell(mesh->graph, at, face->plane.n, hint);
    gather(gatherer, &(ViewPoint){at, face->plane.n, cell}, h);
}

static bool in_one_plane(const Mesh *mesh, const Nodes *nodes, int node) {
    for (int i = nodes->first[node]; i < nodes->first[node + 1]; i++) {
        Vec3 n = mesh->faces[mesh->elements[nodes->element[i]].face].plane.n;
        if (vec3_dot(n, nodes->normal[node]) <= 1 - SAME_PLANE) return false;
    }
    return true;
}

static void gather_node(void *context, int index, int thread) {
    Final *self = context;
    const Mesh *mesh = self->scene->mesh;
    const Nodes *nodes = &self->nodes;
    int node = self->first + index, first = nodes->first[node], count = nodes->first[node + 1] - first;
    Vec3 place = mesh->vertices[nodes->vertex[node]], middle = {0};
    double h[3] = {0};
    bool plane = in_one_plane(mesh, nodes, node);
    for (int i = 0; i < count; i++) {
        Vec3 centre = element_centroid(mesh, nodes->element[first + i]);
        middle = vec3_add(middle, vec3_scale(centre, 1.0 / count));
        if (plane) continue;
        double one[3];
        look_from(self->gatherer[thread], mesh, place, centre, nodes->element[first + i], one);
        for (int c = 0; c < 3; c++) h[c] += one[c] / count;
    }
    if (plane) look_from(self->gatherer[thread], mesh, place, middle, nodes->element[first], h);
    const Material *m = mesh_material(mesh, mesh->elements[nodes->element[first]].face);
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    for (int c = 0; c < 3; c++) self->out[node][c] = (double)e[c] + (double)rho[c] * h[c];
}

bool final_gather(const GatherScene *scene, const GatherOptions *options, int threads,
                  const Progress *progress, Arena *arena, RadSolution *solution) {
    Arena scratch = {0};
    threads = parallel_threads(threads);
    Final self = {.scene = scene,
                  .nodes = nodes_of(scene->mesh, &scratch),
                  .gatherer = ARENA_ARRAY(&scratch, Gatherer *, threads)};
    self.out = arena_alloc(arena, (size_t)self.nodes.count, sizeof *self.out);
    for (int t = 0; t < threads; t++) self.gatherer[t] = gatherer_new(scene, options, &scratch);
    bool go_on = true;
    for (int count = self.nodes.count; self.first < count && go_on; self.first += NODES_A_LOOK) {
        go_on = progress_report(progress, "final gather", (double)self.first / count);
        int left = count - self.first < NODES_A_LOOK ? count - self.first : NODES_A_LOOK;
        if (go_on) parallel_for(threads, left, gather_node, &self);
    }
    for (int t = 0; t < threads; t++) gatherer_end(self.gatherer[t]);
    if (go_on) {
        solution->node = self.out;
        solution->node_count = self.nodes.count;
    }
    arena_free(&scratch);
    return go_on;
}
