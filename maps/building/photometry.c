// photometry.c - candela tables: intensity by direction, and its integral over either side of the horizon. The integral is exact for
// intensity that is linear in both angles, so the light of a lamp is the flux of its table whatever the table's steps.
#include "maps/building/photometry.h"

#include <math.h>

static const double DEGREE = M_PI / 180, HORIZON = 90;

// The interval of ascending angles in which an angle lies, between the first and the last: in most tables steps are even, and the first
// guess is right.
static int interval_of(const double *angle, int count, double at) {
    double share = (at - angle[0]) / (angle[count - 1] - angle[0]);
    int i = (int)(fmin(fmax(share, 0), 1) * (count - 1)), last = count - 2;
    if (i > last) i = last;
    while (i > 0 && angle[i] > at) i--;
    while (i < last && angle[i + 1] <= at) i++;
    return i;
}

static double in_plane(const Photometry *t, int plane, int interval, double share) {
    const double *row = t->candela + (long)plane * t->gamma_count + interval;
    return row[0] + share * (row[1] - row[0]);
}

double photometry_candela(const Photometry *t, double gamma, double plane) {
    if (!(gamma >= t->gamma[0] && gamma <= t->gamma[t->gamma_count - 1])) return 0;
    int i = interval_of(t->gamma, t->gamma_count, gamma);
    double share = (gamma - t->gamma[i]) / (t->gamma[i + 1] - t->gamma[i]);
    if (t->plane_count == 1) return in_plane(t, 0, i, share);
    plane -= 360 * floor((plane - t->plane[0]) / 360);
    int k = interval_of(t->plane, t->plane_count, plane);
    double turned = fmin(fmax((plane - t->plane[k]) / (t->plane[k + 1] - t->plane[k]), 0), 1);
    double a = in_plane(t, k, i, share), b = in_plane(t, k + 1, i, share);
    return a + turned * (b - a);
}

// The integral of intensity times the sine of gamma, from `from` to `to` degrees within an interval of one plane.
static double integrate_part(const Photometry *t, int plane, int interval, double from, double to) {
    double width = t->gamma[interval + 1] - t->gamma[interval], a = from * DEGREE, b = to * DEGREE;
    double at_a = in_plane(t, plane, interval, (from - t->gamma[interval]) / width);
    double at_b = in_plane(t, plane, interval, (to - t->gamma[interval]) / width);
    double slope = (at_b - at_a) / (b - a);
    return at_a * (cos(a) - cos(b)) + slope * (sin(b) - sin(a) - (b - a) * cos(b));
}

// The same over one side of the horizon.
static double integrate_plane(const Photometry *t, int plane, int side) {
    double sum = 0;
    for (int i = 0; i + 1 < t->gamma_count; i++) {
        double from = t->gamma[i], to = t->gamma[i + 1];
        if (side == PHOTOMETRY_BELOW)
            to = fmin(to, HORIZON);
        else
            from = fmax(from, HORIZON);
        if (from < to) sum += integrate_part(t, plane, i, from, to);
    }
    return sum;
}

void photometry_integrate(Photometry *t) {
    for (int side = 0; side < PHOTOMETRY_SIDES; side++) {
        double sum = 0, before = integrate_plane(t, 0, side);
        if (t->plane_count == 1) sum = 2 * M_PI * before;
        for (int k = 1; k < t->plane_count; k++) {
            double here = integrate_plane(t, k, side);
            sum += (before + here) / 2 * (t->plane[k] - t->plane[k - 1]) * DEGREE;
            before = here;
        }
        t->lumens[side] = sum;
    }
}

double spread_share(const LampSpread *s, Vec3 along) {
    if ((along.z > 0) != (s->side == PHOTOMETRY_ABOVE)) return 0;
    double gamma = acos(fmin(fmax(-along.z, -1), 1)) / DEGREE;
    double plane = s->table->plane_count > 1 ? (atan2(along.y, along.x) - s->turn) / DEGREE : 0;
    return photometry_candela(s->table, gamma, plane) / s->table->lumens[s->side];
}

double spread_ratio(const LampSpread *spread, Vec3 normal, Vec3 along) {
    if (!spread) return 1;
    double cosine = vec3_dot(normal, along);
    return cosine > 0 ? M_PI * spread_share(spread, along) / cosine : 0;
}
