// curved_rays.c - the kinds of curved shapes, made ready for rays: one table.
//
// Quadrics (spheres, ellipsoids, cylinders and cones): each is a convex solid, in its own space, so that a ray is inside it for one
// span, from where it enters to where it leaves. Of a cylinder or cone this is the span inside the quadric, cut by that between the
// planes of its ends; a disc that is missing is a way in or out that is no hit. So nothing slips between a side and a disc.
// The ray begins anew where it is nearest to the shape, and discriminants are sums of squares rather than differences of
// large products (Lagrange's identity): far and grazing rays lose no digits.
//
// Metaballs (Nishita & Nakamae 1994): along a ray each ball's field is a polynomial of degree 6 over its chord. Between two
// neighbouring ends of chords the field is one polynomial, the sum of those of the balls about; its roots are found by Bezier
// clipping. With w = 1 - (r / radius)^2 a ball's field is (5 w^2 + 4 w^3) / 9, and w is a quadratic along the ray. Departure: where
// they restrict the coefficients 16 a^2 / 27, 8 a^2 (8 a + 5) / 45, 16 a^2 / 27 of the whole chord to each interval, by de
// Casteljau, this takes the quadratic's blossom there and multiplies: fewer operations, and exactly 0 where a chord ends.
#include "visibility/rays/curved_rays.h"

#include <assert.h>

#include "engine/core/lanes.h"
#include "visibility/bezier/bernstein.h"
#include "visibility/bezier/bezier_clip.h"

// ---- quadrics

typedef struct Quadric {
    CurvedKind kind;
    Vec3 centre;  // of the shape, in the building
    // Dot products of p - centre with these are p in the shape's own space, its centre the origin.
    Vec3 to_unit[3];
    double slope;  // by how much the radius grows with z, -1 .. 0
    bool disc[2];
    Box box;
} Quadric;

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

static Quadric quadric_of(const CurvedShape *shape) {
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

static void quadric_hits(const Quadric *q, const Ray *ray, HitList *list) {
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

// ---- metaballs

enum { FIELD = 6 };  // its degree

// Chords at once. Where a ray meets more it is halved, so often at most.
enum { MOST_CHORDS = 128, MOST_HALVINGS = 24 };

// Fields below this share of the threshold and of all weights about count as 0: that covers their rounding, and the effect of a
// tangent ray's own.
#define FIELD_ROUNDING 1e-14
// Two roots as near as this are one, where chords end; of the shape's size.
#define SAME_ROOT 1e-12

// Four balls, about the shape's centre. Places without a ball have a radius2 below 0: no ray meets them.
typedef struct FourBalls {
    Four x, y, z, radius2, inverse2, weight;  // inverse2: 1 / radius2
} FourBalls;

typedef struct Metaballs {
    Vec3 centre;
    double size;  // of its box, from corner to corner
    double threshold;
    FourBalls *fours;
    int four_count;
    Box box;
} Metaballs;

void metaball_add_field(const double w[3], double weight, double field[7]) {
    double w0 = w[0], w1 = w[1], w2 = w[2], q = weight * (5.0 / 9), k = weight * (4.0 / 9);
    double s0 = w0 * w0, s1 = w0 * w1, s2 = (2 * w1 * w1 + w0 * w2) / 3, s3 = w1 * w2, s4 = w2 * w2;
    // s raised from degree 4 to 6, and s times w.
    field[0] += s0 * (q + k * w0);
    field[1] += q * (s0 + 2 * s1) / 3 + k * (s0 * w1 + 2 * s1 * w0) / 3;
    field[2] += q * (s0 + 8 * s1 + 6 * s2) / 15 + k * (s0 * w2 + 8 * s1 * w1 + 6 * s2 * w0) / 15;
    field[3] += q * (s1 + 3 * s2 + s3) / 5 + k * (s1 * w2 + 3 * s2 * w1 + s3 * w0) / 5;
    field[4] += q * (s4 + 8 * s3 + 6 * s2) / 15 + k * (s4 * w0 + 8 * s3 * w1 + 6 * s2 * w2) / 15;
    field[5] += q * (s4 + 2 * s3) / 3 + k * (s4 * w1 + 2 * s3 * w2) / 3;
    field[6] += s4 * (q + k * w2);
}

// ---- made ready

static Box balls_box(const CurvedBall *balls, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        if (!(balls[i].weight > 0)) continue;  // alone it makes no surface
        Vec3 r = vec3(balls[i].radius, balls[i].radius, balls[i].radius);
        box = box_add(box_add(box, vec3_sub(balls[i].centre, r)), vec3_add(balls[i].centre, r));
    }
    return box;
}

static Metaballs *metaballs_new(const Building *building, const CurvedShape *shape, Arena *arena) {
    const CurvedBall *balls = building->balls + shape->first_ball;
    Metaballs *m = ARENA_ARRAY(arena, Metaballs, 1);
    m->box = balls_box(balls, shape->ball_count);
    m->threshold = shape->threshold;
    if (box_is_empty(m->box)) {
        m->box = (Box){0};
        return m;
    }
    m->centre = vec3_lerp(m->box.min, m->box.max, 0.5);
    m->size = vec3_length(vec3_sub(m->box.max, m->box.min));
    m->four_count = (shape->ball_count + 3) / 4;
    m->fours = ARENA_ARRAY(arena, FourBalls, m->four_count);
    for (int i = 0; i < 4 * m->four_count; i++) {
        FourBalls *f = &m->fours[i / 4];
        int k = i % 4;
        f->radius2[k] = -1;
        if (i >= shape->ball_count) continue;
        Vec3 c = vec3_sub(balls[i].centre, m->centre);
        f->x[k] = c.x, f->y[k] = c.y, f->z[k] = c.z;
        f->radius2[k] = balls[i].radius * balls[i].radius;
        f->inverse2[k] = 1 / f->radius2[k];
        f->weight[k] = balls[i].weight;
    }
    return m;
}

static Box metaballs_box(const Metaballs *balls) { return balls->box; }

// ---- along a ray

// The part of a ray inside a ball. w at s is (half2 - (s - middle)^2) / radius^2.
typedef struct Chord {
    double in, out, middle, half2, inverse2, weight;
} Chord;

typedef struct Walk {
    const Metaballs *m;
    Vec3 o, d;     // about `centre`, o nearest to it
    double start;  // t of o
    HitList *list;
    CurvedWork *work;
    double last;  // s of the last root
} Walk;

// The chords that overlap low .. high; -1: more than MOST_CHORDS.
static int find_chords(const Walk *walk, double low, double high, Chord *chords) {
    const Metaballs *m = walk->m;
    Four ox = four_of(walk->o.x), oy = four_of(walk->o.y), oz = four_of(walk->o.z);
    Four dx = four_of(walk->d.x), dy = four_of(walk->d.y), dz = four_of(walk->d.z);
    int count = 0;
    for (int i = 0; i < m->four_count; i++) {
        const FourBalls *f = &m->fours[i];
        Four x = f->x - ox, y = f->y - oy, z = f->z - oz, middle = x * dx + y * dy + z * dz;
        x -= middle * dx, y -= middle * dy, z -= middle * dz;
        Four half2 = f->radius2 - (x * x + y * y + z * z);
        unsigned met = four_lanes(half2 > four_of(0));
        for (; met; met &= met - 1) {
            int k = __builtin_ctz(met);
            double half = sqrt(half2[k]);
            Chord chord = {middle[k] - half, middle[k] + half, middle[k],
                           half2[k],         f->inverse2[k],   f->weight[k]};
            if (!(chord.in < high && chord.out > low)) continue;
            if (count == MOST_CHORDS) return -1;
            chords[count++] = chord;
        }
    }
    return count;
}

static void sort(double *a, int count) {
    for (int i = 1; i < count; i++) {
        double key = a[i];
        int k = i;
        for (; k > 0 && a[k - 1] > key; k--) a[k] = a[k - 1];
        a[k] = key;
    }
}

// Out of the balls: where the field falls.
static Vec3 normal_at(const Metaballs *m, Vec3 p) {
    Four x = {0}, y = {0}, z = {0};
    for (int i = 0; i < m->four_count; i++) {
        const FourBalls *f = &m->fours[i];
        Four ax = four_of(p.x) - f->x, ay = four_of(p.y) - f->y, az = four_of(p.z) - f->z;
        Four w = four_of(1) - (ax * ax + ay * ay + az * az) * f->inverse2;
        w = four_choose(w > four_of(0), w, four_of(0));
        Four slope = f->weight * w * (5 + 6 * w) * f->inverse2;
        x += ax * slope, y += ay * slope, z += az * slope;
    }
    return vec3_normalize(vec3(four_sum(x), four_sum(y), four_sum(z)));
}

static void add_root(Walk *walk, double s) {
    if (s - walk->last <= SAME_ROOT * walk->m->size) return;
    walk->last = s;
    if (!hit_list_wants(walk->list, walk->start + s)) return;
    Vec3 p = vec3_add(walk->o, vec3_scale(walk->d, s));
    hit_list_add(walk->list, (RayHit){.t = walk->start + s, .normal = normal_at(walk->m, p)});
}

// Where only the first hit is asked for, the first root is, most times.
static void add_roots(Walk *walk, double low, double high, const double *field, double slack) {
    double root[FIELD];
    bool all = walk->list->max > 1;
    int count = bernstein_roots(field, FIELD, slack, root, all ? FIELD : 1, walk->work);
    if (!all && count == 1) {
        add_root(walk, low + (high - low) * root[0]);
        if (walk->list->count > 0) return;
        count = bernstein_roots(field, FIELD, slack, root, FIELD, walk->work);
    }
    for (int i = 0; i < count; i++) add_root(walk, low + (high - low) * root[i]);
}

// Between two ends of chords that are neighbours.
static void walk_interval(Walk *walk, const Chord *chords, int count, double low, double high) {
    double field[FIELD + 1] = {0}, weights = walk->m->threshold, most = -INFINITY;
    for (int i = 0; i < count; i++) {
        const Chord *c = &chords[i];
        if (!(c->in <= low && c->out >= high)) continue;
        double a = low - c->middle, b = high - c->middle;
        double w[3] = {(c->half2 - a * a) * c->inverse2, (c->half2 - a * b) * c->inverse2,
                       (c->half2 - b * b) * c->inverse2};
        metaball_add_field(w, c->weight, field);
        weights += fabs(c->weight);
    }
    for (int i = 0; i <= FIELD; i++) {
        field[i] -= walk->m->threshold;
        most = field[i] > most ? field[i] : most;
    }
    if (most < -FIELD_ROUNDING * weights) return;
    add_roots(walk, low, high, field, FIELD_ROUNDING * weights);
}

static void walk_range(Walk *walk, double low, double high, int halvings) {
    Chord chords[MOST_CHORDS];
    double end[2 * MOST_CHORDS + 2];
    int count = find_chords(walk, low, high, chords), ends = 0;
    if (count < 0 && halvings == MOST_HALVINGS) {
        walk->work->undecided++;
        return;
    }
    if (count < 0) {
        double middle = (low + high) / 2;
        walk->work->splits++;
        walk_range(walk, low, middle, halvings + 1);
        if (walk->start + middle < walk->list->far) walk_range(walk, middle, high, halvings + 1);
        return;
    }
    for (int i = 0; i < count; i++) {
        end[ends++] = fmin(fmax(chords[i].in, low), high);
        end[ends++] = fmin(fmax(chords[i].out, low), high);
    }
    sort(end, ends);
    for (int i = 0; i + 1 < ends && walk->start + end[i] < walk->list->far; i++)
        if (end[i] < end[i + 1]) walk_interval(walk, chords, count, end[i], end[i + 1]);
}

static void metaball_hits(const Metaballs *m, const Ray *ray, HitList *list, CurvedWork *work) {
    if (m->four_count == 0) return;
    Vec3 from = vec3_sub(ray->origin, m->centre);
    Walk walk = {.m = m, .d = ray->direction, .list = list, .work = work, .last = -INFINITY};
    walk.start = -vec3_dot(from, ray->direction);
    walk.o = vec3_add(from, vec3_scale(ray->direction, walk.start));
    double low = fmax(list->near - walk.start, -m->size), high = fmin(list->far - walk.start, m->size);
    if (low < high) walk_range(&walk, low, high, 0);
}

// ---- the table of kinds

typedef struct Kind {
    const void *(*prepare)(const Building *building, const CurvedShape *shape, Arena *arena);
    Box (*box)(const void *self);
    void (*hits)(const void *self, const Ray *ray, HitList *list, CurvedWork *work);
} Kind;

static const void *prepare_quadric(const Building *building, const CurvedShape *shape, Arena *arena) {
    (void)building;
    Quadric *quadric = ARENA_ARRAY(arena, Quadric, 1);
    *quadric = quadric_of(shape);
    return quadric;
}
static Box box_of_quadric(const void *self) { return ((const Quadric *)self)->box; }
static void hit_quadric(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    (void)work;
    quadric_hits(self, ray, list);
}

static const void *prepare_patch(const Building *building, const CurvedShape *shape, Arena *arena) {
    return bezier_patch_new(building, shape, false, arena);
}
static Box box_of_patch(const void *self) { return bezier_patch_box(self); }
static void hit_patch(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    bezier_hits(self, ray, list, work);
}

static const void *prepare_balls(const Building *building, const CurvedShape *shape, Arena *arena) {
    return metaballs_new(building, shape, arena);
}
static Box box_of_balls(const void *self) { return metaballs_box(self); }
static void hit_balls(const void *self, const Ray *ray, HitList *list, CurvedWork *work) {
    metaball_hits(self, ray, list, work);
}

#define QUADRIC                                                                                              \
    { prepare_quadric, box_of_quadric, hit_quadric }
static const Kind KINDS[CURVED_KINDS] = {
    [CURVED_SPHERE] = QUADRIC,
    [CURVED_CYLINDER] = QUADRIC,
    [CURVED_CONE] = QUADRIC,
    [CURVED_PATCH] = {prepare_patch, box_of_patch, hit_patch},
    [CURVED_METABALLS] = {prepare_balls, box_of_balls, hit_balls},
};

typedef struct Shape {
    const Kind *kind;
    const void *self;
} Shape;

struct CurvedRays {
    Shape *shapes;
    int count;
};

CurvedRays *curved_rays_new(const Building *building, Arena *arena) {
    CurvedRays *rays = ARENA_ARRAY(arena, CurvedRays, 1);
    rays->count = building->shape_count;
    rays->shapes = ARENA_ARRAY(arena, Shape, rays->count + 1);
    for (int i = 0; i < rays->count; i++) {
        const CurvedShape *shape = &building->shapes[i];
        const Kind *kind = &KINDS[shape->kind];
        rays->shapes[i] = (Shape){kind, kind->prepare(building, shape, arena)};
    }
    return rays;
}

Box curved_rays_box(const CurvedRays *rays, int shape) {
    assert(shape >= 0 && shape < rays->count);
    return rays->shapes[shape].kind->box(rays->shapes[shape].self);
}

static int find_shape_hits(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hits, int max,
                           CurvedWork *work) {
    CurvedWork unwanted = {0};
    if (!work) work = &unwanted;
    work->rays++;
    HitList list = {.hits = hits, .max = max, .near = ray->near, .far = ray->far};
    rays->shapes[shape].kind->hits(rays->shapes[shape].self, ray, &list, work);
    return list.count;
}

bool curved_rays_hit(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hit, CurvedWork *work) {
    return find_shape_hits(rays, shape, ray, hit, 1, work) > 0;
}

int curved_rays_all(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hits, int max,
                    CurvedWork *work) {
    assert(max >= 2);
    return find_shape_hits(rays, shape, ray, hits, max, work);
}
