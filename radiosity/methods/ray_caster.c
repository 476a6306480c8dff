// ray_caster.c - faces as Embree's quads, or as triangles where they do not have four corners. As for the other methods, the element
// is found from the point where a ray meets its face.
//
// Embree's coordinates are floats: only points that are at least a few micrometres apart can be told apart.
#include "radiosity/methods/ray_caster.h"

#include <math.h>

#include "radiosity/mesh/lines.h"
#include "visibility/hidden/embree_device.h"

// Rays start this far in front of their surface, metres, so that they do not meet it.
#define RAY_OFF 2e-5

// A face's grid: a point p, from the scene's origin, lies in column dot(x, p) + x0, and row likewise with y.
typedef struct RayFace {
    float x[3], y[3], x0, y0;
    float n[3];
    int nx, ny, first_square;
} RayFace;

struct RayCaster {
    const Mesh *mesh;
    RTCDevice device;
    RTCScene scene;
    Vec3 origin;
    RayFace *faces;
    int *face_of[2];  // [quad], [triangle]
};

enum { QUADS, TRIANGLES };

// The vertices where an outline turns.
static int corners_of(const Mesh *mesh, const Face *face, Vec3 *out) {
    int count = 0, n = face->vertex_count;
    for (int i = 0; i < n; i++) {
        Vec3 p = mesh->vertices[mesh->outline[face->first_vertex + (i + n - 1) % n]];
        Vec3 q = mesh->vertices[mesh->outline[face->first_vertex + i]];
        Vec3 r = mesh->vertices[mesh->outline[face->first_vertex + (i + 1) % n]];
        Vec3 along = vec3_normalize(vec3_sub(r, p));
        if (vec3_length(vec3_cross(along, vec3_sub(q, p))) >= RAD_STRAIGHT) out[count++] = q;
    }
    return count;
}

typedef struct Pieces {
    int count[2], corners[2];
    float *vertex[2];
    unsigned *index[2];
} Pieces;

static void put_corners(const RayCaster *scene, const Vec3 *corner, int count, int kind, Pieces *p) {
    for (int i = 0; i < count; i++) {
        Vec3 v = vec3_sub(corner[i], scene->origin);
        float *at = p->vertex[kind] + 3 * (p->corners[kind] + i);
        at[0] = (float)v.x, at[1] = (float)v.y, at[2] = (float)v.z;
    }
}

// Counts the quads or triangles of a face; where `p` has buffers, also writes them there.
static void add_face(RayCaster *scene, int face, const Vec3 *corner, int count, Pieces *p) {
    int kind = count == 4 ? QUADS : TRIANGLES, pieces = count == 4 ? 1 : count - 2;
    unsigned base = (unsigned)p->corners[kind];
    if (p->vertex[kind]) put_corners(scene, corner, count, kind, p);
    for (int k = 0; k < pieces; k++, p->count[kind]++) {
        if (!p->index[kind]) continue;
        scene->face_of[kind][p->count[kind]] = face;
        for (unsigned i = 0; kind == QUADS && i < 4; i++)
            p->index[kind][4 * p->count[kind] + (int)i] = base + i;
        for (unsigned i = 0; kind == TRIANGLES && i < 3; i++)
            p->index[kind][3 * p->count[kind] + (int)i] = base + (i == 0 ? 0 : (unsigned)k + i);
    }
    p->corners[kind] += count;
}

static void add_faces(RayCaster *scene, Pieces *p) {
    Arena scratch = {0};
    const Mesh *mesh = scene->mesh;
    int most = 0;
    for (int f = 0; f < mesh->face_count; f++)
        if (mesh->faces[f].vertex_count > most) most = mesh->faces[f].vertex_count;
    Vec3 *corner = ARENA_ARRAY(&scratch, Vec3, most + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        int count = mesh->faces[f].hidden ? 0 : corners_of(mesh, &mesh->faces[f], corner);
        if (count >= 3) add_face(scene, f, corner, count, p);
    }
    arena_free(&scratch);
}

static void build_scene(RayCaster *scene, Arena *arena) {
    Pieces p = {0};
    add_faces(scene, &p);
    RTCGeometry geometry[2];
    for (int kind = 0; kind < 2; kind++) {
        bool quads = kind == QUADS;
        size_t corners = (size_t)p.corners[kind], pieces = (size_t)p.count[kind], of = quads ? 4 : 3;
        scene->face_of[kind] = ARENA_ARRAY(arena, int, pieces + 1);
        geometry[kind] =
            rtcNewGeometry(scene->device, quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
        p.vertex[kind] = rtcSetNewGeometryBuffer(geometry[kind], RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                 3 * sizeof(float), corners);
        p.index[kind] = rtcSetNewGeometryBuffer(geometry[kind], RTC_BUFFER_TYPE_INDEX, 0,
                                                quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
                                                of * sizeof(unsigned), pieces);
        p.count[kind] = p.corners[kind] = 0;
    }
    add_faces(scene, &p);
    for (int kind = 0; kind < 2; kind++) {
        rtcCommitGeometry(geometry[kind]);
        rtcAttachGeometryByID(scene->scene, geometry[kind], (unsigned)kind);
        rtcReleaseGeometry(geometry[kind]);
    }
    rtcCommitScene(scene->scene);
}

static RayFace ray_face(const RayCaster *scene, const Face *face) {
    Vec3 from = vec3_sub(scene->origin, face->origin), n = face->plane.n;
    return (RayFace){.x = {(float)face->gx.x, (float)face->gx.y, (float)face->gx.z},
                     .y = {(float)face->gy.x, (float)face->gy.y, (float)face->gy.z},
                     .x0 = (float)vec3_dot(face->gx, from),
                     .y0 = (float)vec3_dot(face->gy, from),
                     .n = {(float)n.x, (float)n.y, (float)n.z},
                     .nx = face->nx,
                     .ny = face->ny,
                     .first_square = face->first_square};
}

RayCaster *ray_caster_new(const Mesh *mesh, Arena *arena) {
    RayCaster *scene = ARENA_ARRAY(arena, RayCaster, 1);
    scene->mesh = mesh;
    Box box = box_empty();
    for (int i = 0; i < mesh->vertex_count; i++) box = box_add(box, mesh->vertices[i]);
    if (!box_is_empty(box)) scene->origin = vec3_lerp(box.min, box.max, 0.5);
    scene->faces = ARENA_ARRAY(arena, RayFace, mesh->face_count + 1);
    for (int f = 0; f < mesh->face_count; f++) scene->faces[f] = ray_face(scene, &mesh->faces[f]);
    scene->device = embree_device_new();
    scene->scene = rtcNewScene(scene->device);
    rtcSetSceneBuildQuality(scene->scene, RTC_BUILD_QUALITY_HIGH);
    build_scene(scene, arena);
    return scene;
}

void ray_caster_end(RayCaster *scene) {
    rtcReleaseScene(scene->scene);
    rtcReleaseDevice(scene->device);
}

static inline int square_along(float at, int count) {
    return at > 0 ? at < (float)count ? (int)at : count - 1 : 0;
}

static int element_at(const RayCaster *scene, int face, const float p[3]) {
    const RayFace *f = &scene->faces[face];
    int column = square_along(f->x[0] * p[0] + f->x[1] * p[1] + f->x[2] * p[2] + f->x0, f->nx);
    int row = square_along(f->y[0] * p[0] + f->y[1] * p[1] + f->y[2] * p[2] + f->y0, f->ny);
    int element = scene->mesh->squares[f->first_square + row * f->nx + column];
    if (element >= 0) return element;
    Vec3 at = vec3_add(scene->origin, vec3((double)p[0], (double)p[1], (double)p[2]));
    return mesh_element_at(scene->mesh, face, at);
}

void ray_caster_cast(RayCaster *scene, Vec3 eye, Vec3 normal, const RayEight *rays, LaneInt mask,
                     bool coherent, int32_t face[LANES], int32_t element[LANES]) {
    Vec3 from = vec3_add(vec3_sub(eye, scene->origin), vec3_scale(normal, RAY_OFF));
    float start[3] = {(float)from.x, (float)from.y, (float)from.z};
    struct RTCRayHit8 hit;
    for (int i = 0; i < LANES; i++) {
        hit.ray.org_x[i] = start[0], hit.ray.org_y[i] = start[1], hit.ray.org_z[i] = start[2];
        hit.ray.tnear[i] = 0, hit.ray.tfar[i] = INFINITY, hit.ray.time[i] = 0;
        hit.ray.mask[i] = ~0u, hit.ray.flags[i] = 0, hit.ray.id[i] = 0;
        hit.hit.geomID[i] = hit.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    memcpy(hit.ray.dir_x, &rays->x, sizeof rays->x);
    memcpy(hit.ray.dir_y, &rays->y, sizeof rays->y);
    memcpy(hit.ray.dir_z, &rays->z, sizeof rays->z);
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8((const int *)&mask, scene->scene, &context, &hit);
    for (int i = 0; i < LANES; i++) {
        face[i] = element[i] = -1;
        unsigned kind = hit.hit.geomID[i];
        if (!mask[i] || kind == RTC_INVALID_GEOMETRY_ID) continue;
        face[i] = scene->face_of[kind][hit.hit.primID[i]];
        const float *n = scene->faces[face[i]].n;
        float t = hit.ray.tfar[i], w[3] = {rays->x[i], rays->y[i], rays->z[i]};
        if (n[0] * w[0] + n[1] * w[1] + n[2] * w[2] >= 0) continue;
        float p[3] = {start[0] + t * w[0], start[1] + t * w[1], start[2] + t * w[2]};
        element[i] = element_at(scene, face[i], p);
    }
}
