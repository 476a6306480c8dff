// quadric_hit.c - rays against spheres, ellipsoids, cylinders and cones: each is a convex solid, in its own space, so that a
// ray is inside it for one span, from where it enters to where it leaves. Of a cylinder or cone this is the span inside
// the quadric, cut by that between the planes of its ends; a disc that is missing is a way in or out that is no hit. So
// nothing slips between a side and a disc.
//
// The ray begins anew where it is nearest to the shape, and discriminants are sums of squares rather than differences of
// large products (Lagrange's identity): far and grazing rays lose no digits.
#include "visibility/rays/quadric_hit.h"

// By which bounds grow, of the shape's size: hits are rounded, bounds hold them all.
#define BOUNDS_ROUNDING 1e-14

// Where a ray is inside, and which part it enters and leaves by.
typedef struct Span {
    double in, out;
    int in_part, out_part;
} Span;
enum { DISC_BELOW, DISC_ABOVE, SIDE };

static const Span NOWHERE = {INFINITY, -INFINITY, SIDE, SIDE};

static Box quadric_bounds(const CurvedShape *shape) {
    const CurvedFrame *f = &shape->frame;
    const Vec3 *a = f->axis;
    Box box = box_empty();
    double size = vec3_length(a[0]) + vec3_length(a[1]) + vec3_length(a[2]) + vec3_length(f->origin);
    for (int end = 0; end < 2; end++) {
        double radius = shape->kind == CURVED_CONE && end ? shape->top : 1, z = 0;
        Vec3 centre = shape->kind == CURVED_SPHERE ? f->origin : vec3_add(f->origin, vec3_scale(a[2], end));
        if (shape->kind == CURVED_SPHERE) z = 1;
        Vec3 reach = vec3_scale(vec3(sqrt(a[0].x * a[0].x + a[1].x * a[1].x + z * a[2].x * a[2].x),
                                     sqrt(a[0].y * a[0].y + a[1].y * a[1].y + z * a[2].y * a[2].y),
                                     sqrt(a[0].z * a[0].z + a[1].z * a[1].z + z * a[2].z * a[2].z)),
                                radius);
        box = box_add(box_add(box, vec3_sub(centre, reach)), vec3_add(centre, reach));
    }
    return box_grow(box, BOUNDS_ROUNDING * size);
}

Quadric quadric_of(const CurvedShape *shape) {
    Quadric q = {.kind = shape->kind, .disc = {shape->disc[0], shape->disc[1]}, .box = quadric_bounds(shape)};
    q.centre = shape->frame.origin;
    if (shape->kind != CURVED_SPHERE) q.centre = vec3_add(q.centre, vec3_scale(shape->frame.axis[2], 0.5));
    for (int i = 0; i < 3; i++) {
        Vec3 axis = shape->frame.axis[i];
        q.to_unit[i] = vec3_scale(axis, 1 / vec3_dot(axis, axis));
    }
    q.slope = shape->kind == CURVED_CONE ? shape->top - 1 : 0;
    return q;
}

static Vec3 into(const Quadric *q, Vec3 v) {
    return vec3(vec3_dot(q->to_unit[0], v), vec3_dot(q->to_unit[1], v), vec3_dot(q->to_unit[2], v));
}

static Span sphere_span(Vec3 o, Vec3 d) {
    double a = vec3_dot(d, d), middle = -vec3_dot(o, d) / a;
    Vec3 nearest = vec3_add(o, vec3_scale(d, middle));
    double rest = 1 - vec3_dot(nearest, nearest);
    if (!(rest >= 0)) return NOWHERE;
    double half = sqrt(rest / a);
    return (Span){middle - half, middle + half, SIDE, SIDE};
}

// Inside the quadric x^2 + y^2 <= r^2 on the side where r, its radius there, is above 0; r = radius + growth s on the ray.
static Span side_span(Vec3 o, Vec3 d, double radius, double growth) {
    double a = d.x * d.x + d.y * d.y - growth * growth;
    double b = o.x * d.x + o.y * d.y - radius * growth;
    double c = o.x * o.x + o.y * o.y - radius * radius;
    if (a == 0) {  // one root, of 2 b s + c
        if (b == 0) return c <= 0 ? (Span){-INFINITY, INFINITY, SIDE, SIDE} : NOWHERE;
        double root = -c / (2 * b);
        return b > 0 ? (Span){-INFINITY, root, SIDE, SIDE} : (Span){root, INFINITY, SIDE, SIDE};
    }
    double p = o.x * growth - radius * d.x, q = o.y * growth - radius * d.y, r = o.x * d.y - o.y * d.x;
    double discriminant = p * p + q * q - r * r;
    if (!(discriminant >= 0)) {
        if (a > 0) return NOWHERE;
        discriminant = 0;  // a steep ray meets its cone: this is rounding
    }
    double sum = -(b + copysign(sqrt(discriminant), b));
    double first = sum / a, second = sum == 0 ? 0 : c / sum;
    double low = fmin(first, second), high = fmax(first, second);
    if (a > 0) return (Span){low, high, SIDE, SIDE};
    // Both ends of the ray are inside, one of them the cone's mirror image beyond its apex.
    return growth > 0 ? (Span){high, INFINITY, SIDE, SIDE} : (Span){-INFINITY, low, SIDE, SIDE};
}

static Span between_ends(Span span, double z, double slope) {
    if (slope == 0) return fabs(z) <= 0.5 ? span : NOWHERE;
    double below = (-0.5 - z) / slope, above = (0.5 - z) / slope;
    bool rises = slope > 0;
    double in = rises ? below : above, out = rises ? above : below;
    if (in > span.in) span.in = in, span.in_part = rises ? DISC_BELOW : DISC_ABOVE;
    if (out < span.out) span.out = out, span.out_part = rises ? DISC_ABOVE : DISC_BELOW;
    return span;
}

// From a normal in the shape's own space; at the apex, where there is none, along the axis.
static Vec3 normal_of(const Quadric *q, Vec3 n) {
    if (n.x == 0 && n.y == 0 && n.z == 0) n.z = 1;
    Vec3 sum = vec3_add(vec3_scale(q->to_unit[0], n.x), vec3_scale(q->to_unit[1], n.y));
    return vec3_normalize(vec3_add(sum, vec3_scale(q->to_unit[2], n.z)));
}

static void add_quadric_hit(const Quadric *q, Vec3 o, Vec3 d, double s, double start, int part,
                            HitList *list) {
    double t = start + s;
    if ((part != SIDE && !q->disc[part]) || !hit_list_wants(list, t)) return;
    Vec3 p = vec3_add(o, vec3_scale(d, s)), n = p;
    if (part != SIDE)
        n = vec3(0, 0, part == DISC_ABOVE ? 1 : -1);
    else if (q->kind != CURVED_SPHERE)
        n.z = -q->slope * (1 + q->slope * (p.z + 0.5));
    hit_list_add(list, (RayHit){.t = t, .normal = normal_of(q, n)});
}

void quadric_hits(const Quadric *q, const Ray *ray, HitList *list) {
    Vec3 from = vec3_sub(ray->origin, q->centre);
    double start = -vec3_dot(from, ray->direction);
    Vec3 o = into(q, vec3_add(from, vec3_scale(ray->direction, start))), d = into(q, ray->direction);
    Span span;
    if (q->kind == CURVED_SPHERE) {
        span = sphere_span(o, d);
    } else {
        span = side_span(o, d, 1 + q->slope * (o.z + 0.5), q->slope * d.z);
        span = between_ends(span, o.z, d.z);
    }
    if (!(span.in <= span.out)) return;
    add_quadric_hit(q, o, d, span.in, start, span.in_part, list);
    add_quadric_hit(q, o, d, span.out, start, span.out_part, list);
}
