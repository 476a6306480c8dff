// still_lamps_share.c - what of a lamp there is to be seen from a place: in closed form, and a point of it at a time.
//
// Source: Lambert 1760 for polygons; Snyder 1996, Area Light Sources for Real-Time Graphics, for balls. Points are drawn by what they
// send (Talbot, Cline & Egbert 2005, Importance Resampling).
#include "engine/stills/still_lamps_parts.h"
#include "radiosity/factors/analytic.h"

// Seen from farther than so many times its radius, a polygon is as good as a point of its area, and a quadrilateral as four: within
// 1 %.
static const double FAR = 8, MIDDLING = 2;
// Points of a lamp, of which one is chosen by what it sends.
enum { POINTS = 4 };
// From farther than so many times its radius all points of a lamp send much the same.
static const double EVEN = 4;

double still_ball_share(Vec3 normal, Vec3 to, double radius) {
    double d2 = vec3_dot(to, to), far2 = d2 / (radius * radius), cosine = vec3_dot(normal, to) / sqrt(d2);
    if (far2 <= 1) return 1;
    double above = 1 - far2 * cosine * cosine;
    if (above <= 0) return fmax(cosine, 0) / far2;
    double tangent = sqrt(far2 - 1), sine = sqrt(1 - cosine * cosine);
    double part = cosine * acos(fmin(fmax(-cosine * tangent / sine, -1), 1)) - sqrt(above) * tangent;
    return fmax((part / far2 + atan(sqrt(above) / tangent)) / M_PI, 0);
}

static double near_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f) {
    Vec3 local[ANALYTIC_CORNERS];
    for (int i = 0; i < lamp->corner_count; i++) {
        Vec3 v = vec3_sub(lamps->corners[lamp->first_corner + i], f->point);
        local[i] = vec3(vec3_dot(f->x, v), vec3_dot(f->y, v), vec3_dot(f->n, v));
    }
    return analytic_point(local, lamp->corner_count);
}

// The share of the light that leaves the place that would meet the lamp's front.
double lamp_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f) {
    Vec3 to = vec3_sub(lamp->centre, f->point);
    double ahead = vec3_dot(f->n, to);
    if (ahead <= -lamp->radius) return 0;
    if (lamp->corner_count == 0) return still_ball_share(f->n, to, lamp->radius);
    double before = -vec3_dot(lamp->normal, to);
    if (before <= 0) return 0;
    double d2 = vec3_dot(to, to), radius2 = lamp->radius * lamp->radius;
    if (ahead <= lamp->radius || d2 < MIDDLING * MIDDLING * radius2) return near_share(lamps, lamp, f);
    if (d2 > FAR * FAR * radius2) return lamp->area * ahead * before / (M_PI * d2 * d2);
    if (lamp->corner_count != 4) return near_share(lamps, lamp, f);
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        Vec3 way = vec3_sub(lamp->four[i], f->point);
        double way2 = vec3_dot(way, way);
        sum += vec3_dot(f->n, way) / (way2 * way2);
    }
    return lamp->area / 4 * before * sum / M_PI;
}

// ---- points of a lamp

// Uniform over the triangles between the first corner and each edge.
static Vec3 point_of_polygon(const StillLamps *lamps, const Lamp *lamp, double u, double v) {
    const Vec3 *c = lamps->corners + lamp->first_corner;
    double left = u * lamp->area, area = 0;
    int last = lamp->corner_count - 2, i = 1;
    for (; i <= last; i++) {
        area = 0.5 * vec3_length(vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
        if (left < area || i == last) break;
        left -= area;
    }
    double along = area > 0 ? fmin(left / area, 1) : 0;
    return vec3_lerp(c[0], vec3_lerp(c[i], c[i + 1], along), sqrt(v));
}

// Uniform over the directions from the place.
static Vec3 point_of_ball(const Lamp *lamp, Vec3 from, double u, double v) {
    Vec3 to = vec3_sub(lamp->centre, from), x, y;
    double d2 = vec3_dot(to, to), r2 = lamp->radius * lamp->radius, d = sqrt(d2);
    if (d2 <= r2) return from;
    double least = sqrt(1 - r2 / d2), cosine = 1 - u * (1 - least), sine2 = 1 - cosine * cosine;
    double far = d * cosine - sqrt(fmax(r2 - d2 * sine2, 0)), turn = 2 * M_PI * v;
    Vec3 axis = vec3_scale(to, 1 / d);
    view_axes(axis, &x, &y);
    Vec3 across = vec3_scale(vec3_add(vec3_scale(x, cos(turn)), vec3_scale(y, sin(turn))), sqrt(sine2));
    return vec3_add(from, vec3_scale(vec3_add(vec3_scale(axis, cosine), across), far));
}

static double sends(const Lamp *lamp, const LampFrame *f, Vec3 point) {
    Vec3 to = vec3_sub(point, f->point);
    double d2 = vec3_dot(to, to), ahead = fmax(vec3_dot(f->n, to), 0);
    if (lamp->corner_count == 0) return d2 > 0 ? ahead / sqrt(d2) : 0;
    return d2 > 0 ? ahead * fmax(-vec3_dot(lamp->normal, to), 0) / (d2 * d2) : 0;
}

// One of a few points, by what each sends; false: none sends anything.
static bool choose_point(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f, const double u[2],
                         double pick, Vec3 *out) {
    Vec3 point[POINTS], to = vec3_sub(lamp->centre, f->point);
    double weight[POINTS], sum = 0;
    bool even = vec3_dot(to, to) > EVEN * EVEN * lamp->radius * lamp->radius;
    int points = even && vec3_dot(f->n, to) > lamp->radius ? 1 : POINTS;
    for (int i = 0; i < points; i++) {
        // Two by two, each in a quarter of its own.
        double a = lamp_fraction(u[0] + 0.5 * (i & 1)), b = lamp_fraction(u[1] + 0.5 * (i >> 1));
        point[i] = lamp->corner_count == 0 ? point_of_ball(lamp, f->point, a, b)
                                           : point_of_polygon(lamps, lamp, a, b);
        sum += weight[i] = sends(lamp, f, point[i]);
    }
    if (!(sum > 0)) return false;
    int i = 0;
    double left = pick * sum;
    while (i + 1 < points && left >= weight[i]) left -= weight[i++];
    *out = point[i];
    return true;
}

bool lamp_sees(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f, const double u[2],
               double pick) {
    Vec3 point;
    if (!choose_point(lamps, lamp, f, u, pick, &point)) return false;
    Vec3 to = vec3_sub(point, f->point);
    double d = vec3_length(to);
    Ray ray = {f->point, vec3_scale(to, 1 / d), STILL_NEAR, d - lamp->before};
    return !still_rays_blocked(&lamps->scene->opaque, &ray);
}
