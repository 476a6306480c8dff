// path_lights.c - a binary tree over the faces that emit. At each node one goes on with a probability in proportion to the power
// of either side over the square of its distance (Conty Estevez & Kulla 2018, Importance Sampling of Many Lights, without
// their bounds of orientation); what lies below the horizon of the place, or turns its back, has none.
#include "radiosity/truth/path_lights.h"

#include <stdlib.h>

// Lights of one leaf, which are weighed one by one: most homes have no more.
enum { LEAF_LIGHTS = 16 };
// The least cosine of a light's direction that counts: a large light's corner may be turned more than its middle.
static const double LEAST_COSINE = 0.05;

typedef struct PathLight {
    int face, node;           // its leaf
    int first, corner_count;  // in PathLights.corners
    Vec3 centre, n;
    Box box;
    double power, area, radius2;  // W, m^2, m^2
} PathLight;

typedef struct LightNode {
    Box box;
    Vec3 centre;
    double power, radius2;
    int parent, child[2];  // -1: a leaf
    int first, count;      // of a leaf, lights
} LightNode;

struct PathLights {
    const Mesh *mesh;
    PathLight *lights;
    LightNode *nodes;
    Vec3 *corners;
    int *of_face;  // [face_count] -1: emits nothing
    int count, node_count;
};

// ---- made once

static double exitance_of(const Mesh *mesh, int face) {
    Rgb e = mesh_material(mesh, face)->emission;
    return (double)e.r + (double)e.g + (double)e.b;
}

static PathLight light_of(const PathScene *scene, int face, int first, Vec3 *corners) {
    const Mesh *mesh = scene->mesh;
    const Face *f = &mesh->faces[face];
    PathLight light = {.face = face,
                       .first = first,
                       .corner_count = f->vertex_count,
                       .centre = scene->centres[face],
                       .n = f->plane.n,
                       .box = box_empty()};
    for (int i = 0; i < f->vertex_count; i++) {
        Vec3 v = vec3_sub(mesh->vertices[mesh->outline[f->first_vertex + i]], scene->origin);
        corners[first + i] = v;
        light.box = box_add(light.box, v);
    }
    light.area = polygon_area(corners + first, f->vertex_count);
    light.power = light.area * exitance_of(mesh, face);
    Vec3 half = vec3_scale(vec3_sub(light.box.max, light.box.min), 0.5);
    light.radius2 = vec3_dot(half, half);
    return light;
}

static int by_centre(const void *a, const void *b, void *axis) {
    const PathLight *p = a, *q = b;
    double x = vec3_component(p->centre, *(int *)axis), y = vec3_component(q->centre, *(int *)axis);
    return x != y ? (x < y ? -1 : 1) : p->face - q->face;
}

static int make_node(PathLights *lights, int first, int count, int parent) {
    int index = lights->node_count++;
    LightNode *node = &lights->nodes[index];
    *node =
        (LightNode){.box = box_empty(), .parent = parent, .child = {-1, -1}, .first = first, .count = count};
    for (int i = first; i < first + count; i++) {
        node->box = box_union(node->box, lights->lights[i].box);
        node->power += lights->lights[i].power;
    }
    Vec3 size = vec3_sub(node->box.max, node->box.min);
    node->centre = vec3_lerp(node->box.min, node->box.max, 0.5);
    node->radius2 = 0.25 * vec3_dot(size, size);
    if (count <= LEAF_LIGHTS) {
        for (int i = first; i < first + count; i++) lights->lights[i].node = index;
        return index;
    }
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    qsort_r(lights->lights + first, (size_t)count, sizeof *lights->lights, by_centre, &axis);
    int low = make_node(lights, first, count / 2, index);
    int high = make_node(lights, first + count / 2, count - count / 2, index);
    lights->nodes[index].child[0] = low;
    lights->nodes[index].child[1] = high;
    return index;
}

PathLights *path_lights_new(const PathScene *scene, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    PathLights *lights = ARENA_ARRAY(arena, PathLights, 1);
    lights->mesh = mesh;
    lights->of_face = ARENA_ARRAY(arena, int, mesh->face_count);
    int corners = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        lights->of_face[f] = -1;
        if (!(exitance_of(mesh, f) > 0)) continue;
        lights->count++;
        corners += mesh->faces[f].vertex_count;
    }
    lights->lights = ARENA_ARRAY(arena, PathLight, lights->count + 1);
    lights->nodes = ARENA_ARRAY(arena, LightNode, 2 * lights->count + 1);
    lights->corners = ARENA_ARRAY(arena, Vec3, corners + 1);
    for (int f = 0, i = 0, first = 0; f < mesh->face_count; f++) {
        if (!(exitance_of(mesh, f) > 0)) continue;
        lights->lights[i] = light_of(scene, f, first, lights->corners);
        first += lights->lights[i++].corner_count;
    }
    make_node(lights, 0, lights->count, -1);
    for (int i = 0; i < lights->count; i++) lights->of_face[lights->lights[i].face] = i;
    return lights;
}

// ---- weights

// Is all of a box below the horizon?
static bool is_below(Box box, const PathPlace *place) {
    Vec3 n = place->normal, p = place->point;
    Vec3 top = {n.x > 0 ? box.max.x : box.min.x, n.y > 0 ? box.max.y : box.min.y,
                n.z > 0 ? box.max.z : box.min.z};
    return vec3_dot(n, vec3_sub(top, p)) <= 0;
}

static double node_weight(const LightNode *node, const PathPlace *place) {
    if (is_below(node->box, place)) return 0;
    Vec3 to = vec3_sub(node->centre, place->point);
    return node->power / (vec3_dot(to, to) + node->radius2);
}

static double light_weight(const PathLight *light, const PathPlace *place) {
    Vec3 to = vec3_sub(light->centre, place->point);
    double behind = vec3_dot(light->n, to);
    if (behind >= 0 || is_below(light->box, place)) return 0;
    double d2 = vec3_dot(to, to) + light->radius2, d = sqrt(d2);
    double from = fmax(vec3_dot(place->normal, to) / d, LEAST_COSINE);
    return light->power * from * fmax(-behind / d, LEAST_COSINE) / d2;
}

// The probability of the first child.
static double first_share(const PathLights *lights, const LightNode *node, const PathPlace *place) {
    double low = node_weight(&lights->nodes[node->child[0]], place);
    double high = node_weight(&lights->nodes[node->child[1]], place);
    return low + high > 0 ? low / (low + high) : 0.5;
}

static double weigh_leaf(const PathLights *lights, const LightNode *node, const PathPlace *place,
                         double weight[LEAF_LIGHTS]) {
    double sum = 0;
    for (int i = 0; i < node->count; i++)
        sum += weight[i] = light_weight(&lights->lights[node->first + i], place);
    return sum;
}

// ---- choosing

// Uniform over the triangles between the first corner and each edge.
static Vec3 point_of(const PathLights *lights, const PathLight *light, double u, double v) {
    const Vec3 *c = lights->corners + light->first;
    double left = u * light->area, area = 0;
    int last = light->corner_count - 2, i = 1;
    for (; i <= last; i++) {
        area = 0.5 * vec3_length(vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
        if (left < area || i == last) break;
        left -= area;
    }
    double along = area > 0 ? fmin(left / area, 1) : 0, far = sqrt(v);
    return vec3_lerp(c[0], vec3_lerp(c[i], c[i + 1], along), far);
}

bool path_lights_choose(const PathLights *lights, const PathPlace *place, const double u[3],
                        PathLightPoint *out) {
    if (lights->count == 0) return false;
    const LightNode *node = lights->nodes;
    double at = u[0], probability = 1, weight[LEAF_LIGHTS];
    while (node->child[0] >= 0) {
        double share = first_share(lights, node, place);
        bool first = at < share;
        at = first ? at / share : (at - share) / (1 - share);
        probability *= first ? share : 1 - share;
        node = &lights->nodes[node->child[!first]];
    }
    double sum = weigh_leaf(lights, node, place, weight), left = at * sum;
    if (!(sum > 0)) return false;
    int i = 0;
    while (i + 1 < node->count && left >= weight[i]) left -= weight[i++];
    if (!(weight[i] > 0)) return false;
    const PathLight *light = &lights->lights[node->first + i];
    *out = (PathLightPoint){light->face, point_of(lights, light, u[1], u[2]),
                            probability * weight[i] / sum / light->area};
    return true;
}

double path_lights_density(const PathLights *lights, const PathPlace *place, int face) {
    int index = lights->of_face[face];
    if (index < 0) return 0;
    const PathLight *light = &lights->lights[index];
    double weight[LEAF_LIGHTS], sum = weigh_leaf(lights, &lights->nodes[light->node], place, weight);
    double own = weight[index - lights->nodes[light->node].first];
    if (!(own > 0)) return 0;
    double probability = own / sum;
    for (int at = light->node; lights->nodes[at].parent >= 0; at = lights->nodes[at].parent) {
        const LightNode *parent = &lights->nodes[lights->nodes[at].parent];
        double share = first_share(lights, parent, place);
        probability *= parent->child[0] == at ? share : 1 - share;
    }
    return probability / light->area;
}
