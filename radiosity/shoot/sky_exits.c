// sky_exits.c - where light that came in by one opening leaves by another: from there on it is that of whatever opening it comes
// in by next.
#include "radiosity/shoot/sky_openings.h"

// Openings nearer than this to a piece's middle are its own plane, metres.
static const double ON_PLANE = 1e-6;

// An opening from a piece's middle, in the view's axes.
typedef struct Exit {
    Plane plane;        // n to the middle's side
    const Plane *edge;  // [count] inside of all
    int count;
} Exit;

static bool make_exit(const View *view, const SkyOpening *o, Plane *edge, Exit *out) {
    double off = vec3_dot(o->plane.n, vec3_sub(view->eye, o->vertices[0]));
    if (off < ON_PLANE) return false;  // it leads in, from here
    Vec3 last = {0, 0, 0}, sum = {0, 0, 0};
    bool above = false;
    for (int i = 0; i <= o->count; i++) {
        Vec3 v = vec3_sub(o->vertices[i % o->count], view->eye);
        Vec3 p = {vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v)};
        if (i > 0) edge[i - 1].n = vec3_cross(last, p);
        if (i < o->count) sum = vec3_add(sum, p);
        above = above || p.z > 0;
        last = p;
    }
    for (int i = 0; i < o->count; i++)
        if (vec3_dot(edge[i].n, sum) < 0) edge[i].n = vec3_scale(edge[i].n, -1);
    Vec3 n = o->plane.n;
    n = vec3(vec3_dot(view->x, n), vec3_dot(view->y, n), vec3_dot(view->z, n));
    *out = (Exit){{n, -off}, edge, o->count};
    return above;
}

static bool leaves_by(const Exit *exit, Vec3 w, double distance) {
    double slope = vec3_dot(exit->plane.n, w);
    // Met at exit->plane.d / slope; both are below 0.
    if (slope >= 0 || exit->plane.d < slope * (distance - ON_PLANE)) return false;
    for (int i = 0; i < exit->count; i++)
        if (vec3_dot(exit->edge[i].n, w) < 0) return false;
    return true;
}

void sky_end_at_exits(const SkyOpenings *openings, const StabForest *forest, int opening, const View *view,
                      const FormFactorSamples *samples, int32_t *item) {
    const SkyOpening *own = &openings->openings[opening];
    for (int k = 0; k < openings->count; k++) {
        const SkyOpening *o = &openings->openings[k];
        Plane edge[SKY_CORNERS];
        Exit exit;
        if (k == opening || !vis_sees(forest, own->inside, o->inside) || !make_exit(view, o, edge, &exit))
            continue;
        for (int i = 0; i < samples->count; i++) {
            if (item[i] < 0) continue;
            const ViewFace *f = &view->faces[item[i]];
            Vec3 along = {(double)samples->x[i], (double)samples->y[i], (double)samples->z[i]};
            if (leaves_by(&exit, along, f->d / vec3_dot(f->n, along))) item[i] = -1;
        }
    }
}
