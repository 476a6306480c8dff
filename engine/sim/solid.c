// solid.c - convex solids against an upright disc.
//
// A disc that moves in plan touches a solid where its middle touches the solid's outline rounded by the radius (Minkowski sum). The
// outline of the part between two heights consists, in plan, of the solid's edges cut to these heights and of the two cuts. Rounded
// by the radius, these lines are stadiums, and the first stadium that the disc's middle enters is the place of impact. Flat
// polygons, which have no height, and upright polygons, whose plan has no width, need no case of their own.
#include "engine/sim/solid.h"

#include "engine/core/polygon.h"

// A way that leads against a normal by less than this share of its length counts as along the surface: the rounding of a slide.
static const double ALONG = 1e-12;
// A polygon whose normal has an upright component below this counts as having no width in plan.
static const double UPRIGHT = 1e-9;

// Cuts may leave edges far shorter than a grid's step. A triangle over one of these edges has less area than this, m^2, and does
// not tell on which side of the edge a point lies.
static const double NO_AREA = 1e-9;

static Vec2 plan_of(Vec3 v) { return vec2(v.x, v.y); }

// ---- the outline of the part of a solid within a band, an edge at a time

typedef struct Outline {
    const Solid *solid;
    Band band;
    int edge;
    Vec2 cut[2][2];  // where the solid's edges cross the band's lower and upper height
    int cut_count[2];
} Outline;

static Outline outline_begin(const Solid *solid, Band band) {
    bool within = solid->box.max.z > band.z0 && solid->box.min.z < band.z1;
    return (Outline){.solid = solid, .band = band, .edge = within ? 0 : solid->count + 2};
}

// Moves the start or the end of the plan of the edge a -> b to the point at which the edge crosses the height z, if it does.
static void cross_height(Outline *o, int which, Vec3 a, Vec3 b, double z, Vec2 *start, Vec2 *end) {
    bool a_over = a.z > z, b_over = b.z > z;
    if (a_over == b_over) return;
    // The cut is computed from the lower end, so that two polygons that share an edge share the cut.
    Vec3 from = a_over ? b : a, to = a_over ? a : b;
    Vec2 at = plan_of(vec3_lerp(from, to, (z - from.z) / (to.z - from.z)));
    if (o->cut_count[which] < 2) o->cut[which][o->cut_count[which]++] = at;
    *(a_over == (which == 0) ? end : start) = at;
}

// Gives the next edge a -> b in plan; false after the last.
static bool outline_next(Outline *o, Vec2 *a, Vec2 *b) {
    const Solid *s = o->solid;
    while (o->edge < s->count) {
        Vec3 p = s->vertices[o->edge], q = s->vertices[o->edge + 1 < s->count ? o->edge + 1 : 0];
        o->edge++;
        *a = plan_of(p);
        *b = plan_of(q);
        if (s->prism) return true;
        cross_height(o, 0, p, q, o->band.z0, a, b);
        cross_height(o, 1, p, q, o->band.z1, a, b);
        if (fmax(p.z, q.z) > o->band.z0 && fmin(p.z, q.z) < o->band.z1) return true;
    }
    while (o->edge < s->count + 2) {
        int which = o->edge++ - s->count;
        if (o->cut_count[which] < 2) continue;
        *a = o->cut[which][0];
        *b = o->cut[which][1];
        return true;
    }
    return false;
}

static Vec2 nearest_on(Vec2 a, Vec2 b, Vec2 p) {
    Vec2 along = vec2_sub(b, a);
    double length2 = vec2_dot(along, along);
    if (length2 == 0) return a;
    double t = vec2_dot(vec2_sub(p, a), along) / length2;
    return t <= 0 ? a : t >= 1 ? b : vec2_add(a, vec2_scale(along, t));
}

// Is `at` over or under the solid? A plan without width contains no point.
static bool holds(const Solid *s, Vec2 at) {
    int left = 0, right = 0;
    for (int i = 0; i < s->count; i++) {
        Vec2 a = plan_of(s->vertices[i]), b = plan_of(s->vertices[i + 1 < s->count ? i + 1 : 0]);
        double side = vec2_cross(vec2_sub(b, a), vec2_sub(at, a));
        left += side > NO_AREA;
        right += side < -NO_AREA;
    }
    return (left == 0) != (right == 0);
}

static Plane plane_of(const Solid *s) { return plane_of_polygon(s->vertices, s->count); }

// The height, at a place in plan, of a plane that is not upright.
static double height_at(Plane plane, Vec2 at) {
    return (plane.d - plane.n.x * at.x - plane.n.y * at.y) / plane.n.z;
}

double solid_distance(const Solid *solid, Band band, Vec2 at) {
    double nearest = INFINITY;
    Vec2 a, b;
    for (Outline o = outline_begin(solid, band); outline_next(&o, &a, &b);)
        nearest = fmin(nearest, vec2_length(vec2_sub(at, nearest_on(a, b, at))));
    if (nearest == INFINITY || !holds(solid, at)) return nearest;
    if (solid->prism || solid->box.min.z == solid->box.max.z) return 0;
    double z = height_at(plane_of(solid), at);
    return z > band.z0 && z < band.z1 ? 0 : nearest;
}

// ---- moving

// The share of the way at which the point `from` enters the circle around `middle`, or 1.
static double enter_circle(Vec2 from, Vec2 way, Vec2 middle, double radius) {
    Vec2 to = vec2_sub(from, middle);
    double a = vec2_dot(way, way), b = vec2_dot(to, way), c = vec2_dot(to, to) - radius * radius;
    double root = b * b - a * c;
    if (b >= 0 || root < 0) return 1;
    // The smaller root, computed without cancellation.
    double t = c / (-b + sqrt(root));
    return t >= 0 && t < 1 ? t : 1;
}

// The share of the way at which the point `from` enters the stadium around a -> b through a straight side, or 1.
static double enter_side(Vec2 from, Vec2 way, Vec2 a, Vec2 b, double radius, Vec2 *normal) {
    Vec2 along = vec2_sub(b, a);
    double length = vec2_length(along);
    if (length == 0) return 1;
    Vec2 across = vec2_scale(vec2(-along.y, along.x), 1 / length);
    double off = vec2_dot(vec2_sub(from, a), across);
    if (off < 0) {
        across = vec2_scale(across, -1);
        off = -off;
    }
    double speed = vec2_dot(way, across);
    if (speed >= 0 || off < radius) return 1;
    double t = (radius - off) / speed;
    double at = vec2_dot(vec2_sub(vec2_add(from, vec2_scale(way, t)), a), along);
    if (t >= 1 || at < 0 || at > length * length) return 1;
    *normal = across;
    return t;
}

static double enter_stadium(Vec2 from, Vec2 way, Vec2 a, Vec2 b, double radius, Vec2 *normal) {
    Vec2 away = vec2_sub(from, nearest_on(a, b, from));
    double distance = vec2_length(away);
    if (distance <= radius) {
        if (distance == 0) return 1;
        *normal = vec2_scale(away, 1 / distance);
        return vec2_dot(way, *normal) < -ALONG * vec2_length(way) ? 0 : 1;
    }
    double t = enter_side(from, way, a, b, radius, normal);
    for (int end = 0; end < 2; end++) {
        Vec2 middle = end ? b : a;
        double at = enter_circle(from, way, middle, radius);
        if (at >= t) continue;
        t = at;
        Vec2 out = vec2_sub(vec2_add(from, vec2_scale(way, t)), middle);
        *normal = vec2_scale(out, 1 / vec2_length(out));
    }
    return t;
}

// Most solids nearby do not obstruct the way, so the circle around the solid's box is tested first.
static bool is_off(const Box *box, Vec2 from, Vec2 way, double radius) {
    Vec2 middle = vec2((box->min.x + box->max.x) / 2, (box->min.y + box->max.y) / 2);
    Vec2 half = vec2(middle.x - box->min.x, middle.y - box->min.y);
    Vec2 off = vec2_sub(middle, nearest_on(from, vec2_add(from, way), middle));
    return vec2_length(off) > radius + vec2_length(half);
}

double solid_sweep(const Solid *solid, Band band, Vec2 from, Vec2 way, double radius, Vec2 *normal) {
    double first = 1;
    if (solid->box.max.z <= band.z0 || solid->box.min.z >= band.z1) return 1;
    if (is_off(&solid->box, from, way, radius)) return 1;
    Vec2 a, b;
    for (Outline o = outline_begin(solid, band); outline_next(&o, &a, &b);) {
        Vec2 n;
        double t = enter_stadium(from, way, a, b, radius, &n);
        if (t >= first) continue;
        first = t;
        *normal = n;
    }
    return first;
}

// ---- heights

static Band band_add(Band band, double z) { return (Band){fmin(band.z0, z), fmax(band.z1, z)}; }

// Adds the heights of the part of the edge p -> q that is over or under the disc.
static Band add_edge(Band band, Vec3 p, Vec3 q, Vec2 at, double radius) {
    Vec2 to = vec2(p.x - at.x, p.y - at.y), along = vec2(q.x - p.x, q.y - p.y);
    double a = vec2_dot(along, along), b = vec2_dot(to, along), c = vec2_dot(to, to) - radius * radius;
    if (a == 0) return c < 0 ? band_add(band_add(band, p.z), q.z) : band;
    double root = b * b - a * c;
    if (root <= 0) return band;
    double t0 = fmax(0, (-b - sqrt(root)) / a), t1 = fmin(1, (-b + sqrt(root)) / a);
    if (t0 >= t1) return band;
    return band_add(band_add(band, p.z + t0 * (q.z - p.z)), p.z + t1 * (q.z - p.z));
}

// Where the disc lies within a sloping polygon, the polygon's highest and lowest points over the disc are on the rim, up and down
// the slope; a bent polygon may be somewhat higher or lower there than its plane.
static Band add_rim(Band band, const Solid *s, Vec2 at, double radius) {
    Plane plane = plane_of(s);
    double slope = hypot(plane.n.x, plane.n.y);
    if (fabs(plane.n.z) < UPRIGHT || slope == 0) return band;
    double bend = 2 * polygon_bend(s->vertices, s->count, plane) / fabs(plane.n.z);
    for (int side = -1; side <= 1; side += 2) {
        double out = side * radius / slope;
        Vec2 rim = vec2(at.x + out * plane.n.x, at.y + out * plane.n.y);
        if (!holds(s, rim)) continue;
        double z = height_at(plane, rim);
        band = band_add(band, fmin(z + bend, s->box.max.z));
        band = band_add(band, fmax(z - bend, s->box.min.z));
    }
    return band;
}

bool solid_levels(const Solid *solid, Vec2 at, double radius, Band *out) {
    if (solid->prism || solid->box.min.z == solid->box.max.z) {
        *out = (Band){solid->box.min.z, solid->box.max.z};
        bool over = holds(solid, at);
        for (int i = 0; i < solid->count && !over; i++) {
            Vec2 a = plan_of(solid->vertices[i]),
                 b = plan_of(solid->vertices[i + 1 < solid->count ? i + 1 : 0]);
            over = vec2_length(vec2_sub(at, nearest_on(a, b, at))) < radius;
        }
        return over;
    }
    *out = (Band){INFINITY, -INFINITY};
    for (int i = 0; i < solid->count; i++) {
        *out =
            add_edge(*out, solid->vertices[i], solid->vertices[i + 1 < solid->count ? i + 1 : 0], at, radius);
    }
    *out = add_rim(*out, solid, at, radius);
    return out->z0 <= out->z1;
}

// ---- plans against each other

static double gap_along_edges(const Vec2 *a, int a_count, const Vec2 *b, int b_count) {
    double widest = -INFINITY;
    for (int i = 0; i < a_count; i++) {
        Vec2 edge = vec2_sub(a[(i + 1) % a_count], a[i]);
        double length = vec2_length(edge), gap = INFINITY;
        if (length == 0) continue;
        for (int k = 0; k < b_count; k++) gap = fmin(gap, -vec2_cross(edge, vec2_sub(b[k], a[i])) / length);
        widest = fmax(widest, gap);
    }
    return widest;
}

double solid_gap(const Vec2 *a, int a_count, const Vec2 *b, int b_count) {
    return fmax(gap_along_edges(a, a_count, b, b_count), gap_along_edges(b, b_count, a, a_count));
}
