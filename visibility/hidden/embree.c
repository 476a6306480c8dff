// embree.c - the hidden-surface method `embree`: Intel's ray tracer, eight neighbouring rays at a time, as fast as it goes
// without leaks (its robust mode). Its coordinates are floats, about the middle of the scene.

#include "visibility/hidden/embree_device.h"
#include "visibility/hidden/facets.h"
#include "visibility/hidden/hidden.h"

#include "engine/core/polygon.h"

enum { EIGHT = 8, WIDE = 4, HIGH = 2 };  // rays of a block, and how they lie
// Rounding in floats of places in a building, metres. A polygon whose plane passes the eye nearer than this is seen edge-on,
// by no ray; nearer nothing is met.
#define EMBREE_ROUNDING 2e-6f

typedef struct EmbreeScene {
    RTCDevice device;
    RTCScene scene;
    int *facet;     // [triangle]
    bool *edge_on;  // [facet] for the eye of the picture under way
    Facets facets;
    Vec3 origin;
    size_t memory;
} EmbreeScene;

static bool count_memory(void *user, ssize_t bytes, bool after) {
    (void)after;
    ((EmbreeScene *)user)->memory += (size_t)bytes;
    return true;
}

static void fill_triangles(EmbreeScene *e, float *at, unsigned *index) {
    Arena scratch = {0};
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * FACET_CORNERS), *owner = e->facet;
    for (int f = 0; f < e->facets.count; f++) {
        const Facet *facet = &e->facets.facets[f];
        const Vec3 *corners = e->facets.corners + facet->first;
        for (int i = 0; i < facet->count; i++) {
            Vec3 p = vec3_sub(corners[i], e->origin);
            *at++ = (float)p.x;
            *at++ = (float)p.y;
            *at++ = (float)p.z;
        }
        polygon_triangulate(corners, facet->count, triangle);
        for (int i = 0; i < 3 * (facet->count - 2); i++) *index++ = (unsigned)(facet->first + triangle[i]);
        for (int i = 0; i < facet->count - 2; i++) *owner++ = f;
    }
    arena_free(&scratch);
}

static void *embree_begin(const Scene *scene, Arena *arena, Error *error) {
    EmbreeScene *e = ARENA_ARRAY(arena, EmbreeScene, 1);
    if (!facets_new(scene, arena, &e->facets, error)) return NULL;
    Box box = box_empty();
    for (int i = 0; i < e->facets.corner_count; i++) box = box_add(box, e->facets.corners[i]);
    if (e->facets.count > 0) e->origin = vec3_lerp(box.min, box.max, 0.5);
    size_t corners = (size_t)e->facets.corner_count, triangles = corners - 2 * (size_t)e->facets.count;
    e->facet = ARENA_ARRAY(arena, int, triangles + 1);
    e->edge_on = ARENA_ARRAY(arena, bool, e->facets.count + 1);
    e->device = embree_device_new();
    rtcSetDeviceMemoryMonitorFunction(e->device, count_memory, e);
    e->scene = rtcNewScene(e->device);
    rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(e->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry mesh = rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *at =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof *at, corners);
    unsigned *index = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof *index, triangles);
    if (triangles > 0) fill_triangles(e, at, index);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(e->scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(e->scene);
    return e;
}

static void embree_end(void *prepared) {
    EmbreeScene *e = prepared;
    rtcReleaseScene(e->scene);
    rtcReleaseDevice(e->device);
}

typedef struct Met {
    int facet;  // -1: nothing
    float z;
} Met;

// A ray that met a polygon seen edge-on goes on behind it.
static Met go_on(const EmbreeScene *e, const struct RTCRay8 *rays, int i, Met met) {
    while (met.facet >= 0 && e->edge_on[met.facet]) {
        struct RTCRayHit on = {.ray = {.org_x = rays->org_x[i],
                                       .org_y = rays->org_y[i],
                                       .org_z = rays->org_z[i],
                                       .dir_x = rays->dir_x[i],
                                       .dir_y = rays->dir_y[i],
                                       .dir_z = rays->dir_z[i],
                                       .tnear = nextafterf(met.z, INFINITY) + EMBREE_ROUNDING,
                                       .tfar = INFINITY,
                                       .mask = ~0u},
                               .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        struct RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(e->scene, &context, &on);
        bool hit = on.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        met = (Met){hit ? e->facet[on.hit.primID] : -1, on.ray.tfar};
    }
    return met;
}

static void cast_block(const EmbreeScene *e, const Camera *camera, int x, int y, ItemBuffer *out) {
    Vec3 eye = vec3_sub(camera->eye, e->origin);
    struct RTCRayHit8 hit;
    int valid[EIGHT] __attribute__((aligned(32)));
    for (int i = 0; i < EIGHT; i++) {
        int column = x + i % WIDE, row = y + i / WIDE;
        Vec3 ray = camera_ray(camera, column + 0.5, row + 0.5);
        valid[i] = column < camera->width && row < camera->height ? -1 : 0;
        hit.ray.org_x[i] = (float)eye.x, hit.ray.org_y[i] = (float)eye.y, hit.ray.org_z[i] = (float)eye.z;
        hit.ray.dir_x[i] = (float)ray.x, hit.ray.dir_y[i] = (float)ray.y, hit.ray.dir_z[i] = (float)ray.z;
        hit.ray.tnear[i] = EMBREE_ROUNDING, hit.ray.tfar[i] = INFINITY, hit.ray.time[i] = 0;
        hit.ray.mask[i] = ~0u, hit.ray.flags[i] = 0, hit.ray.id[i] = 0;
        hit.hit.geomID[i] = hit.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid, e->scene, &context, &hit);
    for (int i = 0; i < EIGHT; i++) {
        if (!valid[i]) continue;
        size_t pixel = (size_t)(y + i / WIDE) * (size_t)camera->width + (size_t)(x + i % WIDE);
        bool any = hit.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        Met met = {any ? e->facet[hit.hit.primID[i]] : -1, hit.ray.tfar[i]};
        if (any && e->edge_on[met.facet]) met = go_on(e, &hit.ray, i, met);
        out->item[pixel] = met.facet < 0 ? -1 : e->facets.facets[met.facet].polygon;
        out->depth[pixel] = met.facet < 0 ? INFINITY : met.z;
    }
}

static bool embree_draw(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work,
                        Error *error) {
    (void)error;
    EmbreeScene *e = prepared;
    for (int f = 0; f < e->facets.count; f++) {
        const Facet *facet = &e->facets.facets[f];
        double height = vec3_dot(facet->n, vec3_sub(facet->centre, camera->eye));
        e->edge_on[f] = fabs(height) < (double)EMBREE_ROUNDING;
    }
    for (int y = 0; y < out->height; y += HIGH)
        for (int x = 0; x < out->width; x += WIDE) cast_block(e, camera, x, y, out);
    work->rays = work->pixels = (int64_t)out->width * out->height;
    work->memory = e->memory;
    return true;
}

const HiddenMethod HIDDEN_EMBREE = {.name = "embree",
                                    .summary = "Embree's rays, eight at a time, in floats",
                                    .begin = embree_begin,
                                    .draw = embree_draw,
                                    .end = embree_end,
                                    .truth = HIDDEN_FLOAT};
