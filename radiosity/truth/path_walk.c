// path_walk.c - random walks from a point (Kajiya 1986, The Rendering Equation): at each surface one lamp is asked for its light,
// and one direction followed, distributed as cosines; both may find the same lamp, and are weighed by the balance heuristic
// (Veach & Guibas 1995), so that lamps close by are found by directions and small ones by asking. A walk goes on as often as the
// surface reflects (Russian roulette); backs absorb.
//
// The numbers of the first bounces are a lattice's (Korobov 1959; its multiplier: L'Ecuyer & Lemieux 2000), shifted at random for
// each block of walks: blocks are independent.
#include "radiosity/truth/path_walk.h"

#include <float.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "radiosity/truth/path_guide.h"
#include "visibility/hidden/embree_device.h"

struct PathScene {
    const Mesh *mesh;
    Vec3 origin;        // the middle of the mesh, from which points are
    double off;         // metres: rays start so far before their surface, lest they meet it
    Vec3 *centres;      // [face_count] of their corners
    double *distances;  // [face_count] dot(n, p) on their planes
    bool *contested;    // [face_count] another face lies in the same place, in part
    int *face_of;       // [triangle]
    struct Embree *embree;
};

typedef struct PathLightPoint {
    int face;
    Vec3 point;
    double density;  // of choosing it, 1/m^2
} PathLightPoint;

// ---- the faces of a mesh as triangles that share the mesh's vertices, those of neighbours on their edges included:
// so Embree's robust mode (Woop, Benthin & Wald 2013, Watertight Ray/Triangle Intersection) lets nothing through between them.
//
// Shares its geometry with the solver, and nothing else. Floats cannot tell faces apart that lie within micrometres of each
// other: where faces share a plane, a second ray looks at that plane alone, and takes the face that is to be seen.

// Metres, for buildings of tens of metres: twenty roundings of a float there.
static const double OFF = 2e-5;
// And for larger ones, of half their size.
static const double OFF_RELATIVE = 16 * (double)FLT_EPSILON;
// So far points are drawn from the edge of their face to its middle, of the way: a start that a rounding carries past the next
// wall would be outside the room.
static const double FROM_EDGE = 1e-5;
// Faces nearer than this lie in one place, metres; and the sine of the angle between them.
static const double SAME_PLACE = 1e-5;
static const double SAME_WAY = 1e-5;
// The least cosine for which the width of the look at a contested plane is exact.
static const double GRAZING = 1e-3;

struct Embree {
    RTCDevice device;
    RTCScene scene;
};

// ---- faces in one place

typedef struct PlaneKey {
    double distance;  // metres, of the plane turned so that of its two sides one is chosen
    int face;
} PlaneKey;

static int by_distance(const void *a, const void *b) {
    const PlaneKey *p = a, *q = b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return p->face - q->face;
}

static bool is_turned(Vec3 n) {
    static const double NONE = 1e-3;
    if (fabs(n.x) > NONE) return n.x < 0;
    return fabs(n.y) > NONE ? n.y < 0 : n.z < 0;
}

static bool along_axis(double low, double high, double other_low, double other_high) {
    double both = fmin(high, other_high) - fmax(low, other_low);
    bool flat = high - low < SAME_PLACE && other_high - other_low < SAME_PLACE;
    return both > (flat ? -SAME_PLACE : SAME_PLACE);
}

// Faces of one plane overlap; neighbours that only touch do not.
static bool may_overlap(Box a, Box b) {
    return along_axis(a.min.x, a.max.x, b.min.x, b.max.x) && along_axis(a.min.y, a.max.y, b.min.y, b.max.y) &&
           along_axis(a.min.z, a.max.z, b.min.z, b.max.z);
}

static bool are_parallel(Vec3 a, Vec3 b) { return vec3_length(vec3_cross(a, b)) < SAME_WAY; }

static void find_contested(PathScene *scene, const Box *boxes) {
    const Mesh *mesh = scene->mesh;
    Arena scratch = {0};
    PlaneKey *keys = ARENA_ARRAY(&scratch, PlaneKey, mesh->face_count);
    for (int f = 0; f < mesh->face_count; f++) {
        double d = scene->distances[f];
        keys[f] = (PlaneKey){is_turned(mesh->faces[f].plane.n) ? -d : d, f};
    }
    qsort(keys, (size_t)mesh->face_count, sizeof *keys, by_distance);
    for (int i = 0; i < mesh->face_count; i++) {
        int f = keys[i].face;
        for (int k = i + 1; k < mesh->face_count && keys[k].distance < keys[i].distance + SAME_PLACE; k++) {
            int g = keys[k].face;
            if (!may_overlap(boxes[f], boxes[g]) ||
                !are_parallel(mesh->faces[f].plane.n, mesh->faces[g].plane.n))
                continue;
            scene->contested[f] = scene->contested[g] = true;
        }
    }
    arena_free(&scratch);
}

// ---- made once

static Box look_at_faces(PathScene *scene, Arena *scratch) {
    const Mesh *mesh = scene->mesh;
    Box all = box_empty(), *boxes = ARENA_ARRAY(scratch, Box, mesh->face_count);
    for (int i = 0; i < mesh->vertex_count; i++) all = box_add(all, mesh->vertices[i]);
    scene->origin = vec3_lerp(all.min, all.max, 0.5);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        Vec3 sum = {0, 0, 0};
        boxes[f] = box_empty();
        for (int i = 0; i < face->vertex_count; i++) {
            Vec3 v = vec3_sub(mesh->vertices[mesh->outline[face->first_vertex + i]], scene->origin);
            sum = vec3_add(sum, v);
            boxes[f] = box_add(boxes[f], v);
        }
        scene->centres[f] = vec3_scale(sum, 1.0 / face->vertex_count);
        scene->distances[f] = vec3_dot(face->plane.n, vec3_sub(face->origin, scene->origin));
    }
    find_contested(scene, boxes);
    return all;
}

static void put_vertices(const PathScene *scene, RTCGeometry geometry) {
    const Mesh *mesh = scene->mesh;
    float *at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                        3 * sizeof *at, (size_t)mesh->vertex_count);
    for (int i = 0; i < mesh->vertex_count; i++) {
        Vec3 v = vec3_sub(mesh->vertices[i], scene->origin);
        *at++ = (float)v.x;
        *at++ = (float)v.y;
        *at++ = (float)v.z;
    }
}

static void put_triangles(PathScene *scene, RTCGeometry geometry, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    Arena scratch = {0};
    int count = 0;
    for (int f = 0; f < mesh->face_count; f++)
        if (!mesh->faces[f].hidden) count += mesh->faces[f].vertex_count - 2;
    scene->face_of = ARENA_ARRAY(arena, int, count + 1);
    unsigned *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof *index, (size_t)count);
    Vec3 *corners = ARENA_ARRAY(&scratch, Vec3, mesh->outline_count);
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * mesh->outline_count), *face_of = scene->face_of;
    for (int f = 0; f < mesh->face_count; f++) {
        const int *outline = mesh->outline + mesh->faces[f].first_vertex;
        int n = mesh->faces[f].vertex_count;
        if (mesh->faces[f].hidden) continue;
        for (int i = 0; i < n; i++) corners[i] = vec3_sub(mesh->vertices[outline[i]], scene->origin);
        polygon_triangulate(corners, n, triangle);
        for (int i = 0; i < 3 * (n - 2); i++) *index++ = (unsigned)outline[triangle[i]];
        for (int i = 0; i < n - 2; i++) *face_of++ = f;
    }
    arena_free(&scratch);
}

PathScene *path_scene_new(const Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    PathScene *scene = ARENA_ARRAY(arena, PathScene, 1);
    scene->mesh = mesh;
    scene->centres = ARENA_ARRAY(arena, Vec3, mesh->face_count);
    scene->distances = ARENA_ARRAY(arena, double, mesh->face_count);
    scene->contested = ARENA_ARRAY(arena, bool, mesh->face_count);
    Box all = look_at_faces(scene, &scratch);
    arena_free(&scratch);
    scene->off = fmax(OFF, OFF_RELATIVE * vec3_length(vec3_sub(all.max, scene->origin)));
    struct Embree *embree = scene->embree = ARENA_ARRAY(arena, struct Embree, 1);
    embree->device = embree_device_new();
    embree->scene = rtcNewScene(embree->device);
    rtcSetSceneFlags(embree->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcSetSceneBuildQuality(embree->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    put_vertices(scene, geometry);
    put_triangles(scene, geometry, arena);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(embree->scene);
    return scene;
}

void path_scene_end(PathScene *scene) {
    rtcReleaseScene(scene->embree->scene);
    rtcReleaseDevice(scene->embree->device);
}

// ---- rays

static struct RTCRayHit ray_of(Vec3 from, Vec3 along, double near, double far) {
    return (struct RTCRayHit){.ray = {.org_x = (float)from.x,
                                      .org_y = (float)from.y,
                                      .org_z = (float)from.z,
                                      .dir_x = (float)along.x,
                                      .dir_y = (float)along.y,
                                      .dir_z = (float)along.z,
                                      .tnear = (float)near,
                                      .tfar = (float)far,
                                      .mask = ~0u},
                              .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
}

// A look at one plane.
typedef struct Look {
    struct RTCIntersectContext context;  // first: Embree knows it
    const PathScene *scene;
    Vec3 along;
    int plane;  // the face met first
    int face;   // the one to be seen, so far
} Look;

static bool is_front(const PathScene *scene, int face, Vec3 along) {
    return vec3_dot(scene->mesh->faces[face].plane.n, along) < 0;
}

static void choose(const struct RTCFilterFunctionNArguments *args) {
    Look *look = (Look *)args->context;
    const PathScene *scene = look->scene;
    int face = scene->face_of[((const struct RTCHit *)args->hit)->primID];  // rays come one at a time
    args->valid[0] = 0;                                                     // goes on to the next
    Vec3 n = scene->mesh->faces[look->plane].plane.n;
    double beside = vec3_dot(n, scene->centres[face]) - scene->distances[look->plane];
    if (fabs(beside) > SAME_PLACE || !are_parallel(n, scene->mesh->faces[face].plane.n)) return;
    bool front = is_front(scene, face, look->along), best = is_front(scene, look->face, look->along);
    if (front != best ? front : face < look->face) look->face = face;
}

// Among the faces where a ray meets the plane of one.
static int seen_of(const PathScene *scene, Vec3 from, Vec3 along, int face, double at) {
    double cosine = fabs(vec3_dot(scene->mesh->faces[face].plane.n, along));
    double wide = 2 * SAME_PLACE / fmax(cosine, GRAZING);
    struct RTCRayHit ray = ray_of(from, along, fmax(at - wide, 0), at + wide);
    Look look = {.scene = scene, .along = along, .plane = face, .face = face};
    rtcInitIntersectContext(&look.context);
    look.context.filter = choose;
    rtcIntersect1(scene->embree->scene, &look.context, &ray);
    return look.face;
}

PathHit path_scene_trace(const PathScene *scene, Vec3 from, Vec3 along) {
    struct RTCRayHit ray = ray_of(from, along, 0, INFINITY);
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->embree->scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return (PathHit){.face = -1};
    double at = (double)ray.ray.tfar;
    PathHit hit = {.face = scene->face_of[ray.hit.primID]};
    if (scene->contested[hit.face]) hit.face = seen_of(scene, from, along, hit.face, at);
    hit.front = is_front(scene, hit.face, along);
    Vec3 n = scene->mesh->faces[hit.face].plane.n, p = vec3_add(from, vec3_scale(along, at));
    hit.point = vec3_sub(p, vec3_scale(n, vec3_dot(n, p) - scene->distances[hit.face]));
    return hit;
}

// The share of light that the panes of glass let through on a ray to what it hits, or from infinitely far away.
static double glass_along(const PathScene *scene, Vec3 from, Vec3 along, const PathHit *hit) {
    const Panes *panes = &scene->mesh->panes;
    if (panes->count == 0) return 1;
    Vec3 at = vec3_add(from, scene->origin);
    return hit->face < 0 ? panes_transmit_from_afar(panes, at, along)
                         : panes_transmit(panes, at, vec3_add(hit->point, scene->origin));
}

Vec3 path_scene_off(const PathScene *scene, Vec3 point, Vec3 normal) {
    return vec3_add(point, vec3_scale(normal, scene->off));
}

Vec3 path_scene_origin(const PathScene *scene) { return scene->origin; }

Vec3 path_scene_before(const PathScene *scene, int face, Vec3 point) {
    Vec3 inwards = vec3_lerp(point, scene->centres[face], FROM_EDGE);
    return path_scene_off(scene, inwards, scene->mesh->faces[face].plane.n);
}

// ---- a binary tree over the faces that emit. At each node one goes on with a probability in proportion to the power
// of either side over the square of its distance (Conty Estevez & Kulla 2018, Importance Sampling of Many Lights, without
// their bounds of orientation); lamps below the horizon of the place, or with their backs to it, have none.

// Lights of one leaf, which are weighed one by one: most homes have no more.
enum { LEAF_LIGHTS = 16 };
// The least cosine of a light's direction that counts: a large light's corner may be turned more than its middle.
static const double LEAST_COSINE = 0.05;

typedef struct PathLight {
    int face, node, group;    // its leaf; in PathLights.groups
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
    int first, count;      // lights
} LightNode;

// Lights that are learned of together: those of a node, or a part of those of a leaf.
typedef struct LightGroup {
    int node, first, count;
} LightGroup;

struct PathLights {
    const Mesh *mesh;
    PathLight *lights;
    LightNode *nodes;
    Vec3 *corners;
    int *of_face;  // [face_count] -1: emits nothing
    LightGroup groups[PATH_LAMP_GROUPS];
    int count, node_count, group_count;
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

static double group_power(const PathLights *lights, const LightGroup *group) {
    double power = 0;
    for (int i = group->first; i < group->first + group->count; i++) power += lights->lights[i].power;
    return power;
}

// Halves the strongest group until there are as many as there may be.
static void make_groups(PathLights *lights) {
    double power[PATH_LAMP_GROUPS];
    lights->groups[0] = (LightGroup){0, 0, lights->count};
    power[0] = group_power(lights, &lights->groups[0]);
    lights->group_count = 1;
    while (lights->group_count < PATH_LAMP_GROUPS) {
        int most = -1;
        for (int g = 0; g < lights->group_count; g++)
            if (lights->groups[g].count > 1 && (most < 0 || power[g] > power[most])) most = g;
        if (most < 0) break;
        LightGroup whole = lights->groups[most], half[2] = {whole, whole};
        const LightNode *node = &lights->nodes[whole.node];
        for (int k = 0; k < 2; k++) {
            half[k].node = node->child[0] >= 0 ? node->child[k] : whole.node;
            half[k].count = node->child[0] >= 0 ? lights->nodes[half[k].node].count
                                                : (k ? whole.count - whole.count / 2 : whole.count / 2);
        }
        half[1].first = half[0].first + half[0].count;
        for (int k = 0; k < 2; k++) {
            int g = k ? lights->group_count++ : most;
            lights->groups[g] = half[k];
            power[g] = group_power(lights, &half[k]);
        }
    }
    for (int g = 0; g < lights->group_count; g++)
        for (int i = lights->groups[g].first; i < lights->groups[g].first + lights->groups[g].count; i++)
            lights->lights[i].group = g;
}

// Points in the scene's coordinates.
static PathLights *path_lights_new(const PathScene *scene, Arena *arena) {
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
    if (lights->count > 0) make_groups(lights);
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

static double weigh_leaf(const PathLights *lights, const LightGroup *leaf, const PathPlace *place,
                         double weight[LEAF_LIGHTS]) {
    double sum = 0;
    for (int i = 0; i < leaf->count; i++)
        sum += weight[i] = light_weight(&lights->lights[leaf->first + i], place);
    return sum;
}

// The leaf of a light in a group: the group itself where it is a part of a leaf.
static LightGroup leaf_of(const PathLights *lights, const LightGroup *group, int node) {
    const LightNode *leaf = &lights->nodes[node];
    return group->node == node ? *group : (LightGroup){node, leaf->first, leaf->count};
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

// Chooses among the lights of a group; `u` are in [0, 1). False: no light could reach the place by this choice.
static bool choose_in_group(const PathLights *lights, const LightGroup *group, const PathPlace *place,
                            const double u[3], PathLightPoint *out) {
    const LightNode *node = &lights->nodes[group->node];
    double at = u[0], probability = 1, weight[LEAF_LIGHTS];
    while (node->child[0] >= 0) {
        double share = first_share(lights, node, place);
        bool first = at < share;
        at = first ? at / share : (at - share) / (1 - share);
        probability *= first ? share : 1 - share;
        node = &lights->nodes[node->child[!first]];
    }
    LightGroup leaf = leaf_of(lights, group, (int)(node - lights->nodes));
    double sum = weigh_leaf(lights, &leaf, place, weight), left = at * sum;
    if (!(sum > 0)) return false;
    int i = 0;
    while (i + 1 < leaf.count && left >= weight[i]) left -= weight[i++];
    if (!(weight[i] > 0)) return false;
    const PathLight *light = &lights->lights[leaf.first + i];
    *out = (PathLightPoint){light->face, point_of(lights, light, u[1], u[2]),
                            probability * weight[i] / sum / light->area};
    return true;
}

// The density with which points of a light of the group are chosen there, 1/m^2.
static double density_in_group(const PathLights *lights, const LightGroup *group, const PathPlace *place,
                               int index) {
    const PathLight *light = &lights->lights[index];
    LightGroup leaf = leaf_of(lights, group, light->node);
    double weight[LEAF_LIGHTS], sum = weigh_leaf(lights, &leaf, place, weight);
    double own = weight[index - leaf.first];
    if (!(own > 0)) return 0;
    double probability = own / sum;
    for (int at = light->node; at != group->node; at = lights->nodes[at].parent) {
        const LightNode *parent = &lights->nodes[lights->nodes[at].parent];
        double share = first_share(lights, parent, place);
        probability *= parent->child[0] == at ? share : 1 - share;
    }
    return probability / light->area;
}

// The share of choices of a lamp that are by what was learned; all others are by power and distance.
static const double LEARNED = 0.8;

static LightGroup all_lights(const PathLights *lights) { return (LightGroup){0, 0, lights->count}; }

// The density with which points of an emitting face are chosen, 1/m^2.
static double path_lights_density(const PathLights *lights, const PathPlace *place, const PathShares *shares,
                                  int face) {
    int index = lights->of_face[face];
    if (index < 0) return 0;
    LightGroup all = all_lights(lights);
    double density = density_in_group(lights, &all, place, index);
    if (!shares || !shares->lamps) return density;
    int group = lights->lights[index].group;
    double share = (double)shares->lamp[group + 1] - (double)shares->lamp[group];
    if (!(share > 0)) return (1 - LEARNED) * density;
    return (1 - LEARNED) * density +
           LEARNED * share * density_in_group(lights, &lights->groups[group], place, index);
}

static bool path_lights_choose(const PathLights *lights, const PathPlace *place, const PathShares *shares,
                               const double u[3], PathLightPoint *out) {
    if (lights->count == 0) return false;
    LightGroup group = all_lights(lights);
    double v[3] = {u[0], u[1], u[2]};
    if (!shares || !shares->lamps) return choose_in_group(lights, &group, place, v, out);
    bool learned = v[0] < LEARNED;
    v[0] = learned ? v[0] / LEARNED : (v[0] - LEARNED) / (1 - LEARNED);
    if (learned) group = lights->groups[path_shares_lamp(shares, &v[0])];
    if (!choose_in_group(lights, &group, place, v, out)) return false;
    out->density = path_lights_density(lights, place, shares, out->face);
    return true;
}

enum { MULTIPLIER = 76 };  // of the lattice

PathWorld path_world(const Mesh *mesh, const Daylight *day, Arena *arena) {
    PathWorld world = {.mesh = mesh, .scene = path_scene_new(mesh, arena)};
    world.lights = path_lights_new(world.scene, arena);
    if (day) world.day = *day;
    return world;
}

void path_world_end(PathWorld *world) { path_scene_end(world->scene); }

// ---- numbers

PathNumbers path_numbers(uint64_t seed, long long block) {
    Random mix = {seed};
    PathNumbers lattice = {.random = {random_next(&mix) + (uint64_t)block * 0xd1342543de82ef95u}};
    int generator = 1;
    for (int k = 0; k < PATH_LATTICE_BOUNCES * PATH_NUMBERS; k++) {
        lattice.shift[k] = random_unit(&lattice.random);
        lattice.generator[k] = generator;
        generator = generator * MULTIPLIER % PATH_BLOCK;
    }
    return lattice;
}

void path_numbers_at(PathNumbers *lattice, int bounce, double u[PATH_NUMBERS]) {
    for (int k = 0; k < PATH_NUMBERS; k++) {
        if (bounce >= PATH_LATTICE_BOUNCES) {
            u[k] = random_unit(&lattice->random);
            continue;
        }
        int at = bounce * PATH_NUMBERS + k;
        double x =
            (double)(lattice->path * lattice->generator[at] % PATH_BLOCK) / PATH_BLOCK + lattice->shift[at];
        u[k] = x < 1 ? x : x - 1;
    }
}

// ---- one path

static void add_light(double light[3], const double weight[3], Rgb from, double by) {
    light[0] += weight[0] * (double)from.r * by;
    light[1] += weight[1] * (double)from.g * by;
    light[2] += weight[2] * (double)from.b * by;
}

// The density of directions, 1/sr, with which a point at `to` is chosen where points of its face are with `density`.
static double as_directions(double density, Vec3 to, Vec3 normal) {
    double d2 = vec3_dot(to, to), across = -vec3_dot(to, normal);
    return across > 0 ? density * d2 * sqrt(d2) / across : 0;
}

static void axes_about(Vec3 normal, Vec3 axes[2]) {
    Vec3 axis = fabs(normal.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    axes[0] = vec3_normalize(vec3_cross(axis, normal));
    axes[1] = vec3_cross(normal, axes[0]);
}

Vec3 path_direction(Vec3 normal, double u, double v) {
    double r = sqrt(u), angle = 2 * M_PI * v;
    Vec3 axes[2];
    axes_about(normal, axes);
    return vec3_normalize(
        vec3_add(vec3_scale(normal, sqrt(1 - u)),
                 vec3_add(vec3_scale(axes[0], r * cos(angle)), vec3_scale(axes[1], r * sin(angle)))));
}

// One surface of a walk: where it is, and what is known of it.
typedef struct Stop {
    PathPlace place;
    const PathShares *shares;  // NULL: nothing is known
    double u[PATH_NUMBERS], *weight;
    double sun_share;  // of the sun's light there; the rest was asked for at the surface before
} Stop;

// The share of the day's light along a direction that is not asked for.
static double day_share(const Stop *stop, double u, double v) {
    bool asked = stop->shares && stop->shares->day;
    return asked ? 1 / (1 + path_shares_density(stop->shares, u, v)) : 1;
}

// The ratio of a face's radiance along a direction that arrives to that of a face which sends light evenly.
static double spread_of(const PathWorld *world, int face, Vec3 along) {
    return spread_ratio(mesh_spread(world->mesh, face), world->mesh->faces[face].plane.n,
                        vec3_scale(along, -1));
}

// The share of a lamp's light that arrives, asked for, and weighed.
static void ask_lamp(const PathWorld *world, const Stop *stop, double light[3], PathStep *step) {
    PathLightPoint lamp;
    const PathPlace *place = &stop->place;
    const PathLights *lights = world->lights;
    if (!path_lights_choose(lights, place, stop->shares, stop->u + PATH_LAMP, &lamp)) return;
    Vec3 to = vec3_sub(lamp.point, place->point), along = vec3_normalize(to);
    double cosine = vec3_dot(place->normal, along) / M_PI;
    double asked = as_directions(lamp.density, to, world->mesh->faces[lamp.face].plane.n);
    if (!(cosine > 0) || !(asked > 0)) return;
    PathHit hit = path_scene_trace(world->scene, place->point, along);
    if (hit.face != lamp.face) return;
    Rgb emission = mesh_material(world->mesh, lamp.face)->emission;
    double share = cosine / (asked + cosine) * glass_along(world->scene, place->point, along, &hit);
    share *= spread_of(world, lamp.face, along);
    add_light(light, stop->weight, emission, share);
    if (!step) return;
    int index = lights->of_face[lamp.face];
    step->group = lights->lights[index].group;
    double inside = density_in_group(lights, &lights->groups[step->group], place, index);
    double found = share * ((double)emission.r + (double)emission.g + (double)emission.b);
    if (inside > 0) step->lamp = found * found * lamp.density / inside;
}

// The irradiance by a point of the sun's disc, chosen by u.
static bool sun_at(const PathWorld *world, const PathPlace *place, const double u[2], double irradiance[3]) {
    const Daylight *day = &world->day;
    if (day->beam[0] + day->beam[1] + day->beam[2] == 0) return false;
    double r = DAYLIGHT_SUN_RADIUS * sqrt(u[0]), angle = 2 * M_PI * u[1];
    Vec3 axes[2];
    axes_about(day->sun, axes);
    Vec3 off = vec3_add(vec3_scale(axes[0], r * cos(angle)), vec3_scale(axes[1], r * sin(angle)));
    Vec3 sun = vec3_normalize(vec3_add(day->sun, off));
    double cosine = vec3_dot(place->normal, sun);
    if (!(cosine > 0)) return false;
    PathHit hit = path_scene_trace(world->scene, place->point, sun);
    if (hit.face >= 0) return false;
    cosine *= glass_along(world->scene, place->point, sun, &hit);
    for (int c = 0; c < 3; c++) irradiance[c] = day->beam[c] * cosine;
    return true;
}

// `before` is the step that led here, NULL: none, or nobody asks.
static void ask_sun(const PathWorld *world, const Stop *stop, double light[3], PathStep *before) {
    double irradiance[3];
    if (!sun_at(world, &stop->place, stop->u + PATH_LAMP + 1, irradiance)) return;
    for (int c = 0; c < 3; c++) light[c] += stop->sun_share * stop->weight[c] * irradiance[c];
    for (int c = 0; c < 3 && before; c++)
        before->day[0] += stop->sun_share * stop->weight[c] * irradiance[c] / M_PI;
}

// Asks for the light of the day where it was met before: for the sky, and for sunlight that a surface reflects. Directions by cosines
// find the same light.
static void ask_day(const PathWorld *world, const Stop *stop, double light[3], PathStep *step) {
    if (!stop->shares || !stop->shares->day) return;
    double u = stop->u[PATH_LAMP + 1], v = stop->u[PATH_LAMP + 2], found[3];
    double density = path_shares_warp(stop->shares, &u, &v);
    Vec3 along = path_direction(stop->place.normal, u, v);
    PathHit hit = path_scene_trace(world->scene, stop->place.point, along);
    double through = glass_along(world->scene, stop->place.point, along, &hit);
    if (hit.face < 0) {
        daylight_radiance(&world->day, along, found);
        for (int c = 0; c < 3; c++) found[c] *= M_PI;
    } else {
        PathPlace there = {path_scene_before(world->scene, hit.face, hit.point),
                           world->mesh->faces[hit.face].plane.n};
        if (!hit.front || !sun_at(world, &there, stop->u + PATH_DIRECTION, found)) return;
        Rgb rho = path_reflectance(world, &hit);
        found[0] *= (double)rho.r;
        found[1] *= (double)rho.g;
        found[2] *= (double)rho.b;
    }
    for (int c = 0; c < 3; c++) {
        found[c] *= through;
        light[c] += stop->weight[c] * found[c] / (1 + density);
    }
    if (!step) return;
    step->bin[1] = path_guide_bin(u, v);
    step->day[1] = (found[0] + found[1] + found[2]) / M_PI / (1 + density);
}

Rgb path_reflectance(const PathWorld *world, const PathHit *hit) {
    return mesh_reflectance_at(world->mesh, hit->face, vec3_add(hit->point, world->scene->origin), 0);
}

bool path_reflect(Rgb reflectance, double u, double weight[3]) {
    weight[0] *= (double)reflectance.r;
    weight[1] *= (double)reflectance.g;
    weight[2] *= (double)reflectance.b;
    double goes_on = fmax(weight[0], fmax(weight[1], weight[2]));
    if (!(u < goes_on)) return false;
    for (int c = 0; c < 3; c++) weight[c] /= goes_on;
    return true;
}

// Follows a direction, through panes of glass; false: the walk ends there.
static bool follow_path(const PathWorld *world, Stop *stop,
                        bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]),
                        void *context, double light[3], PathStep *step) {
    PathPlace *place = &stop->place;
    double u = stop->u[PATH_DIRECTION], v = stop->u[PATH_DIRECTION + 1], *weight = stop->weight;
    Vec3 along = path_direction(place->normal, u, v);
    double unasked = day_share(stop, u, v);
    if (step) step->bin[0] = path_guide_bin(u, v);
    PathHit hit = path_scene_trace(world->scene, place->point, along);
    double through = glass_along(world->scene, place->point, along, &hit);
    for (int c = 0; c < 3; c++) weight[c] *= through;
    if (hit.face < 0) {
        double radiance[3];
        daylight_radiance(&world->day, along, radiance);
        for (int c = 0; c < 3; c++) light[c] += unasked * weight[c] * M_PI * radiance[c];
        if (step) step->day[0] = through * unasked * (radiance[0] + radiance[1] + radiance[2]);
    }
    if (hit.face < 0 || !hit.front) return false;
    const Material *m = mesh_material(world->mesh, hit.face);
    Vec3 n = world->mesh->faces[hit.face].plane.n;
    double cosine = vec3_dot(place->normal, along) / M_PI;
    if (world->lights->of_face[hit.face] >= 0 && cosine > 0) {
        double lamp = path_lights_density(world->lights, place, stop->shares, hit.face);
        double asked = as_directions(lamp, vec3_sub(hit.point, place->point), n);
        add_light(light, weight, m->emission, cosine / (asked + cosine) * spread_of(world, hit.face, along));
    }
    double reflected[3];
    if (known && known(context, place->point, &hit, reflected)) {
        for (int c = 0; c < 3; c++) light[c] += weight[c] * reflected[c];
        return false;
    }
    if (!path_reflect(path_reflectance(world, &hit), stop->u[PATH_ROULETTE], weight)) return false;
    *place = (PathPlace){path_scene_before(world->scene, hit.face, hit.point), n};
    stop->sun_share = unasked;
    return true;
}

static void follow_walk(const PathWorld *world, Stop *stop, PathNumbers *numbers, int bounce,
                        bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]),
                        void *context, const PathShares *own, PathTrail *trail, double light[3]) {
    bool on = true;
    PathStep *before = NULL;
    for (; on; bounce++) {
        PathStep *step = trail && trail->count < PATH_TRAIL_STEPS ? &trail->steps[trail->count++] : NULL;
        stop->shares = own ? own : world->guide ? path_guide_at(world->guide, &stop->place) : NULL;
        own = NULL;
        if (step) *step = (PathStep){.place = stop->place, .group = -1};
        path_numbers_at(numbers, bounce, stop->u);
        ask_lamp(world, stop, light, step);
        ask_sun(world, stop, light, before);
        ask_day(world, stop, light, step);
        before = step;
        on = follow_path(world, stop, known, context, light, step);
    }
}

void path_walk(const PathWorld *world, PathPlace place, PathNumbers *numbers, int bounce,
               bool (*known)(void *context, Vec3 from, const PathHit *hit, double reflected[3]),
               void *context, double weight[3], double light[3]) {
    Stop stop = {.place = place, .weight = weight, .sun_share = 1};
    follow_walk(world, &stop, numbers, bounce, known, context, NULL, NULL, light);
}

void path_walk_guided(const PathWorld *world, PathPlace place, PathNumbers *numbers, const PathShares *own,
                      PathTrail *trail, double light[3]) {
    double weight[3] = {1, 1, 1};
    Stop stop = {.place = place, .weight = weight, .sun_share = 1};
    if (trail) trail->count = 0;
    follow_walk(world, &stop, numbers, 0, NULL, NULL, own, trail, light);
}
