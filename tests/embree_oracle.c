// embree_oracle.c - one Embree ray a pixel, in the robust mode that leaks at no shared edge. Its coordinates are
// floats: what it sees is right to a few micrometres in a building, not at the last bit of an edge.
#include "tests/embree_oracle.h"

#include <embree3/rtcore.h>

#include "engine/core/polygon.h"

// Metres: in float, a ray may meet a polygon in whose plane it starts. Nearer than any surface to a tested eye.
#define EMBREE_NEAR 1e-5f

struct EmbreeOracle {
    RTCDevice device;
    RTCScene scene;
    int *polygon;  // [triangle]
    Vec3 origin;
};

EmbreeOracle *embree_oracle_new(const Scene *scene, Vec3 origin, Arena *arena) {
    EmbreeOracle *oracle = ARENA_ARRAY(arena, EmbreeOracle, 1);
    size_t corners = 0, triangles = 0;
    for (int k = 0; k < scene->count; k++) {
        int n = scene->polygons[scene->list ? scene->list[k] : k].vertex_count;
        corners += (size_t)n;
        triangles += (size_t)n - 2;
    }
    oracle->origin = origin;
    oracle->polygon = ARENA_ARRAY(arena, int, triangles + 1);
    oracle->device = rtcNewDevice("threads=1");
    oracle->scene = rtcNewScene(oracle->device);
    rtcSetSceneFlags(oracle->scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry mesh = rtcNewGeometry(oracle->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *at =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof *at, corners);
    unsigned *index = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof *index, triangles);
    int *polygon = oracle->polygon;
    unsigned base = 0;
    for (int k = 0; k < scene->count; k++) {
        int item = scene->list ? scene->list[k] : k, n = scene->polygons[item].vertex_count;
        const Vec3 *v = scene->vertices + scene->polygons[item].first_vertex;
        for (int i = 0; i < n; i++) {
            Vec3 p = vec3_sub(v[i], origin);
            *at++ = (float)p.x;
            *at++ = (float)p.y;
            *at++ = (float)p.z;
        }
        int *triangle = ARENA_ARRAY(arena, int, 3 * n);
        polygon_triangulate(v, n, triangle);
        for (int i = 0; i < 3 * (n - 2); i++) *index++ = base + (unsigned)triangle[i];
        for (int i = 0; i < n - 2; i++) *polygon++ = item;
        base += (unsigned)n;
    }
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(oracle->scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(oracle->scene);
    return oracle;
}

void embree_oracle_draw(const EmbreeOracle *oracle, const Camera *camera, ItemBuffer *out) {
    Vec3 eye = vec3_sub(camera->eye, oracle->origin);
    for (int j = 0; j < camera->height; j++) {
        for (int i = 0; i < camera->width; i++) {
            Vec3 ray = camera_ray(camera, i + 0.5, j + 0.5);
            struct RTCRayHit hit = {.ray = {.org_x = (float)eye.x,
                                            .org_y = (float)eye.y,
                                            .org_z = (float)eye.z,
                                            .dir_x = (float)ray.x,
                                            .dir_y = (float)ray.y,
                                            .dir_z = (float)ray.z,
                                            .tnear = EMBREE_NEAR,
                                            .tfar = INFINITY,
                                            .mask = ~0u},
                                    .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
            struct RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcIntersect1(oracle->scene, &context, &hit);
            size_t pixel = (size_t)j * (size_t)camera->width + (size_t)i;
            bool met = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
            out->item[pixel] = met ? oracle->polygon[hit.hit.primID] : -1;
            out->depth[pixel] = met ? hit.ray.tfar : INFINITY;
        }
    }
}

void embree_oracle_free(EmbreeOracle *oracle) {
    rtcReleaseScene(oracle->scene);
    rtcReleaseDevice(oracle->device);
}
