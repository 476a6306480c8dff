// path_scene.c - the faces of a mesh as triangles that share the mesh's vertices, those of neighbours on their edges included:
// so Embree's robust mode (Woop, Benthin & Wald 2013, Watertight Ray/Triangle Intersection) lets nothing through between them.
//
// Shares its geometry with the solver, and nothing else. Floats cannot tell faces apart that lie within micrometres of each
// other: where faces share a plane, a second ray looks at that plane alone, and takes the face that is to be seen.
#include "radiosity/truth/path_scene.h"

#include <float.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "visibility/hidden/embree_device.h"

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
    int count = mesh->outline_count - 2 * mesh->face_count;
    scene->face_of = ARENA_ARRAY(arena, int, count + 1);
    unsigned *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof *index, (size_t)count);
    Vec3 *corners = ARENA_ARRAY(&scratch, Vec3, mesh->outline_count);
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * mesh->outline_count), *face_of = scene->face_of;
    for (int f = 0; f < mesh->face_count; f++) {
        const int *outline = mesh->outline + mesh->faces[f].first_vertex;
        int n = mesh->faces[f].vertex_count;
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

Vec3 path_scene_before(const PathScene *scene, int face, Vec3 point) {
    Vec3 inwards = vec3_lerp(point, scene->centres[face], FROM_EDGE);
    return path_scene_off(scene, inwards, scene->mesh->faces[face].plane.n);
}
