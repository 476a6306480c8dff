// metaball_hit.c - rays against metaballs (Nishita & Nakamae 1994): along a ray each ball's field is a polynomial of degree 6
// over its chord. Between two neighbouring ends of chords the field is one polynomial, the sum of those of the balls
// about; its roots are found by Bezier clipping.
//
// With w = 1 - (r / radius)^2 a ball's field is (5 w^2 + 4 w^3) / 9, and w is a quadratic along the ray. Departure: where
// they restrict the coefficients 16 a^2 / 27, 8 a^2 (8 a + 5) / 45, 16 a^2 / 27 of the whole chord to each interval, by de
// Casteljau, this takes the quadratic's blossom there and multiplies: fewer operations, and exactly 0 where a chord ends.
#include "visibility/rays/metaball_hit.h"

#include "engine/core/lanes.h"
#include "visibility/bezier/bernstein.h"

enum { FIELD = 6 };  // its degree

// Chords at once. Where a ray meets more it is halved, so often at most.
enum { MOST_CHORDS = 128, MOST_HALVINGS = 24 };

// What counts as 0 of the field, of the threshold and of all weights about: its rounding, and what a ray's own makes of
// one that is tangent.
#define FIELD_ROUNDING 1e-14
// Two roots as near as this are one, where chords end; of the shape's size.
#define SAME_ROOT 1e-12

// Four balls, about the shape's centre. Places without a ball have a radius2 below 0: no ray meets them.
typedef struct FourBalls {
    Four x, y, z, radius2, inverse2, weight;  // inverse2: 1 / radius2
} FourBalls;

struct Metaballs {
    Vec3 centre;
    double size;  // of its box, from corner to corner
    double threshold;
    FourBalls *fours;
    int four_count;
    Box box;
};

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

Metaballs *metaballs_new(const Building *building, const CurvedShape *shape, Arena *arena) {
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

Box metaballs_box(const Metaballs *balls) { return balls->box; }

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

void metaball_hits(const Metaballs *m, const Ray *ray, HitList *list, CurvedWork *work) {
    if (m->four_count == 0) return;
    Vec3 from = vec3_sub(ray->origin, m->centre);
    Walk walk = {.m = m, .d = ray->direction, .list = list, .work = work, .last = -INFINITY};
    walk.start = -vec3_dot(from, ray->direction);
    walk.o = vec3_add(from, vec3_scale(ray->direction, walk.start));
    double low = fmax(list->near - walk.start, -m->size), high = fmin(list->far - walk.start, m->size);
    if (low < high) walk_range(&walk, low, high, 0);
}
