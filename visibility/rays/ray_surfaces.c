// ray_surfaces.c - where a ray meets a polygon: the plane gives the place, and the ray must pass all edges on one side, which
// the sign of the Plucker product of their lines tells (Shoemake 1998; Amanatides & Choi 1997).
//
// Neighbours have their edge in opposite directions: all terms change their sign and nothing else, so rounding cannot make a ray
// pass between them. Where vertices of one lie on the edge of the other, polygons reach EDGE_SLACK beyond their edges.
#include "visibility/rays/ray_surfaces.h"

#include <immintrin.h>

// How far a ray may pass outside of an edge, metres: above rounding in buildings of a kilometre (1e-12), far below all that
// shows.
static const double EDGE_SLACK = 1e-9;
// The least sine of the angle between a ray and a plane it meets: below, the place is rounding.
static const double LEAST_SINE = 1e-12;

// ---- made once

static void put_edge(RayEdges *edges, int lane, Vec3 a, Vec3 b) {
    Vec3 way = vec3_sub(b, a), moment = vec3_cross(a, b);
    double length = vec3_length(way);
    way = vec3_scale(way, 1 / length);
    moment = vec3_scale(moment, 1 / length);
    edges->way[0][lane] = way.x, edges->way[1][lane] = way.y, edges->way[2][lane] = way.z;
    edges->moment[0][lane] = moment.x, edges->moment[1][lane] = moment.y, edges->moment[2][lane] = moment.z;
}

// A vertex that repeats the one before it has no edge.
static int distinct(const RaySource *source, const Polygon *p, Vec3 origin, Vec3 *out) {
    int count = 0;
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 v = vec3_sub(source->vertices[p->first_vertex + i], origin);
        if (count == 0 || !vec3_equal(v, out[count - 1])) out[count++] = v;
    }
    while (count > 1 && vec3_equal(out[count - 1], out[0])) count--;
    return count;
}

static void put_polygon(RaySurfaces *s, int item, const Vec3 *v, int count) {
    RayPolygon *p = &s->polygons[item];
    if (count >= 3) p->plane = plane_of_polygon(v, count);
    s->boxes[item] = box_empty();
    for (int i = 0; i < count; i++) s->boxes[item] = box_add(s->boxes[item], v[i]);
    if (vec3_dot(p->plane.n, p->plane.n) == 0) return;
    p->edge_count = count;
    RayEdges *edges = s->edges + p->first_edges;
    for (int i = 0; i < (count + 3) / 4 * 4; i++) {
        int k = i < count ? i : count - 1;
        put_edge(&edges[i / 4], i % 4, v[k], v[(k + 1) % count]);
    }
}

static void put_polygons(RaySurfaces *s, const RaySource *source, Arena *arena) {
    Arena scratch = {0};
    int fours = 0, most = 0;
    for (int i = 0; i < source->list_count; i++) {
        int count = source->polygons[source->list[i]].vertex_count;
        s->polygons[i].first_edges = fours;
        fours += (count + 3) / 4;
        if (count > most) most = count;
    }
    s->edges = ARENA_ARRAY(arena, RayEdges, fours + 1);
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, most + 1);
    for (int i = 0; i < source->list_count; i++) {
        int count = distinct(source, &source->polygons[source->list[i]], s->origin, v);
        put_polygon(s, i, v, count);
    }
    arena_free(&scratch);
}

// The middle of all, whole metres: what is relative to it is as exact as it was.
static Vec3 find_origin(const RaySource *source) {
    Box box = box_empty();
    for (int i = 0; i < source->list_count; i++) {
        const Polygon *p = &source->polygons[source->list[i]];
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, source->vertices[p->first_vertex + k]);
    }
    if (box_is_empty(box)) return vec3(0, 0, 0);
    Vec3 m = vec3_lerp(box.min, box.max, 0.5);
    return vec3(round(m.x), round(m.y), round(m.z));
}

RaySurfaces ray_surfaces_new(const RaySource *source, Arena *arena) {
    int count = source->list_count + source->shape_count;
    RaySurfaces s = {.origin = find_origin(source),
                     .polygons = ARENA_ARRAY(arena, RayPolygon, source->list_count + 1),
                     .shapes = ARENA_ARRAY(arena, int, source->shape_count + 1),
                     .boxes = ARENA_ARRAY(arena, Box, count + 1),
                     .box = box_empty(),
                     .polygon_count = source->list_count,
                     .count = count};
    put_polygons(&s, source, arena);
    if (source->shape_count > 0) s.curved = curved_rays_new(source->building, arena);
    for (int i = 0; i < source->shape_count; i++) {
        s.shapes[i] = source->shapes[i];
        Box box = curved_rays_box(s.curved, s.shapes[i]);
        s.boxes[source->list_count + i] = (Box){vec3_sub(box.min, s.origin), vec3_sub(box.max, s.origin)};
    }
    for (int i = 0; i < count; i++)
        if (!box_is_empty(s.boxes[i])) s.box = box_union(s.box, s.boxes[i]);
    return s;
}

// ---- rays

SurfaceRay surface_ray(const RaySurfaces *s, const Ray *ray) {
    Vec3 origin = vec3_sub(ray->origin, s->origin);
    return (SurfaceRay){*ray, origin, vec3_cross(origin, ray->direction)};
}

// Bit i: the number is below that of the limit.
static inline int below(Four a, double limit) {
#ifdef __AVX__
    return _mm256_movemask_pd(_mm256_cmp_pd((__m256d)a, (__m256d)four_of(limit), _CMP_LT_OQ));
#else
    return (a[0] < limit) | (a[1] < limit) << 1 | (a[2] < limit) << 2 | (a[3] < limit) << 3;
#endif
}

// `t` where it meets the plane, before `far`; by the front where `along`, the cosine, is below 0.
static inline bool meets(const RaySurfaces *s, const RayPolygon *p, const SurfaceRay *r, double far,
                         double *t, double *along) {
    *along = vec3_dot(p->plane.n, r->ray.direction);
    *t = (p->plane.d - vec3_dot(p->plane.n, r->origin)) / *along;
    if (!(*t > r->ray.near && *t < far) || fabs(*along) < LEAST_SINE) return false;
    double side = *along < 0 ? -1 : 1;  // inside of all edges the product is above 0
    Four d[3] = {four_of(side * r->ray.direction.x), four_of(side * r->ray.direction.y),
                 four_of(side * r->ray.direction.z)};
    Four m[3] = {four_of(side * r->moment.x), four_of(side * r->moment.y), four_of(side * r->moment.z)};
    const RayEdges *e = s->edges + p->first_edges;
    for (int i = 0; i < p->edge_count; i += 4, e++) {
        Four inside = (d[0] * e->moment[0] + d[1] * e->moment[1] + d[2] * e->moment[2]) +
                      (m[0] * e->way[0] + m[1] * e->way[1] + m[2] * e->way[2]);
        if (below(inside, -EDGE_SLACK)) return false;
    }
    return p->edge_count > 0;
}

// An order of its own, so that it does not matter in which one items are tried: places along a ray are counted in whole steps.
static bool is_seen_before(const SurfaceHit *a, const SurfaceHit *b) {
    double place = floor(a->at.t / RAY_SAME_PLACE), other = floor(b->at.t / RAY_SAME_PLACE);
    if (b->item < 0 || place != other) return place < other || (b->item < 0 && place == other);
    return a->front != b->front ? a->front : a->item < b->item;
}

void ray_surface_try(const RaySurfaces *s, int item, const SurfaceRay *r, SurfaceHit *best) {
    double far = fmin(best->at.t + RAY_SAME_PLACE, r->ray.far);
    SurfaceHit hit = {.item = item};
    if (item < s->polygon_count) {
        const RayPolygon *p = &s->polygons[item];
        double t, along;
        if (!meets(s, p, r, far, &t, &along)) return;
        hit.front = along < 0;
        hit.at = (RayHit){.t = t, .normal = p->plane.n};
    } else {
        Ray ray = r->ray;
        ray.far = far;
        if (!curved_rays_hit(s->curved, s->shapes[item - s->polygon_count], &ray, &hit.at, NULL)) return;
        hit.front = vec3_dot(hit.at.normal, ray.direction) < 0;
    }
    if (is_seen_before(&hit, best)) *best = hit;
}

bool ray_surface_blocks(const RaySurfaces *s, int item, const SurfaceRay *r) {
    double t, along;
    RayHit hit;
    if (item < s->polygon_count) return meets(s, &s->polygons[item], r, r->ray.far, &t, &along);
    return curved_rays_hit(s->curved, s->shapes[item - s->polygon_count], &r->ray, &hit, NULL);
}

SurfaceHit ray_surfaces_brute(const RaySurfaces *s, const Ray *ray) {
    SurfaceRay r = surface_ray(s, ray);
    SurfaceHit best = surface_miss(ray);
    for (int i = 0; i < s->count; i++) ray_surface_try(s, i, &r, &best);
    return best;
}
