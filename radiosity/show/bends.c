// bends.c - adaptive refinement by samples: a part is halved where its light is off the linear light between its corners (Heckbert,
// Simulating Global Illumination Using Adaptive Meshing, 1991, tests samples likewise; the trees are those of the mesh).
#include "radiosity/show/bends.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/polygon.h"

// A part is halved if its light is off by more than this share of the light there, and this share times the part's area is more than
// TOLERANCE of a square whose side is EVEN of an element's: a large part is seen to be off sooner than a small one.
static const double TOLERANCE = 0.06, EVEN = 0.7;
// Corners whose light differs by less than this share are alike.
static const double EVEN_CORNERS = 0.2;
// No half is shorter than this, metres: the width of the penumbra of a small lamp, and less than a walker sees from two metres.
static const double SMALLEST = 0.025;
// The same where an edge of a shadow of the sun passes: the shown edge lies within half a part's length of the exact one.
static const double SMALLEST_AT_EDGE = 0.01;
// But no shorter than would cut a whole face into so many squares: a mesh has squares as small as the smallest element of their face.
static const double MOST_SQUARES = 1e6;
// Patches of the finer mesh are this many splits above their deepest element.
enum { BELOW_PATCH = 2 };
// Corners that parts of elements hardly ever have more of: elements with more are not halved.
enum { MOST_CORNERS = 40 };
// Points whose light is remembered, at most.
enum { KNOWN = 1024, MOST_KNOWN = KNOWN * 3 / 4 };
// Points are equal within this, metres.
static const double SAME_POINT = 1e-7;

struct Bend {
    int axis;  // of the face's grid, along which the part is halved
    // The share that linear light is off times the area, m^2: the largest of this part and its halves
    double error;
    Bend *next;     // of the same part in another state of the light, along another axis; NULL
    Bend *half[2];  // NULL: a half that is not halved again
};

// A rectangle of a face's grid, and how often a root was halved to get there.
typedef struct Span {
    double low[2], high[2];
    int depth[2];
} Span;

struct BendFinder {
    const Face *face;
    const BendLight *light;
    double least;     // least error
    double smallest;  // metres
    Arena *arena;
    BendPoint points[MOST_KNOWN];
    int count;
    short known[KNOWN];  // by place: one more than the index of a point; 0: none
};

BendFinder *bend_finder_new(Arena *arena) { return ARENA_ARRAY(arena, BendFinder, 1); }

const BendPoint *bend_points(const BendFinder *f, int *count) {
    *count = f->count;
    return f->points;
}

// The point at a place, or a new one, which has no light yet.
static BendPoint *point_at(BendFinder *f, Vec3 p, bool *is_new) {
    Vec3 off = vec3_sub(p, f->face->origin);
    long long x = llround(off.x / SAME_POINT), y = llround(off.y / SAME_POINT),
              z = llround(off.z / SAME_POINT);
    size_t at = (size_t)(x * 73856093LL ^ y * 19349663LL ^ z * 83492791LL);
    if (f->count == MOST_KNOWN) {
        memset(f->known, 0, sizeof f->known);
        f->count = 0;
    }
    *is_new = false;
    for (at = (at ^ at >> 17) % KNOWN; f->known[at]; at = (at + 1) % KNOWN) {
        BendPoint *known = &f->points[f->known[at] - 1];
        Vec3 d = vec3_sub(known->point, p);
        if (fabs(d.x) < SAME_POINT && fabs(d.y) < SAME_POINT && fabs(d.z) < SAME_POINT) return known;
    }
    *is_new = true;
    f->known[at] = (short)(f->count + 1);
    f->points[f->count].point = p;
    return &f->points[f->count++];
}

// Radiosity by the light, the sum of the channels.
static double light_at(BendFinder *f, Vec3 p) {
    bool is_new;
    BendPoint *point = point_at(f, p, &is_new);
    if (is_new) {
        double h[3] = {0, 0, 0};
        f->light->at(f->light->context, p, h);
        memcpy(point->irradiance, h, sizeof h);
    }
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += f->light->reflectance[c] * point->irradiance[c];
    return sum;
}

static double grid_at(const Face *face, int axis, Vec3 p) {
    return vec3_dot(axis == 0 ? face->gx : face->gy, vec3_sub(p, face->origin));
}

static double metres(const Face *face, int axis, double squares) {
    return squares / vec3_length(axis == 0 ? face->gx : face->gy);
}

// The block of squares that became the element.
static Span span_of(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    const Face *face = &mesh->faces[e->face];
    Span s = {.depth = {e->depth.x, e->depth.y}};
    Vec3 middle = {0, 0, 0};
    for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
        middle = vec3_add(middle, vec3_scale(mesh->vertices[mesh->corners[c]], 1.0 / e->corner_count));
    for (int axis = 0; axis < 2; axis++) {
        double size = ldexp(face->root, -s.depth[axis]);
        s.low[axis] = floor(grid_at(face, axis, middle) / size) * size;
        s.high[axis] = s.low[axis] + size;
    }
    return s;
}

static Span half_of(const Span *s, int axis, int k) {
    Span out = *s;
    *(k ? &out.low[axis] : &out.high[axis]) = (s->low[axis] + s->high[axis]) / 2;
    out.depth[axis]++;
    return out;
}

// How far linear light is off, as a share of the light at the point: all of it where there should be none.
static double share_off(const BendFinder *f, double linear, double light) {
    double all = f->light->rest + light;
    return all > 0 ? fabs(linear - light) / all : linear > 0;
}

// The largest errors of linear light between the corners of a convex part, along each axis; returns the part's area, m^2.
static double measure(BendFinder *f, const Span *s, const Vec3 *v, int count, double off[2]) {
    Vec3 n = f->face->plane.n, moment = {0, 0, 0};
    double light[MOST_CORNERS], twice = 0, sum = 0, low = INFINITY, high = 0;
    off[0] = off[1] = 0;
    for (int i = 0; i < count; i++) {
        light[i] = light_at(f, v[i]);
        low = fmin(low, light[i]);
        high = fmax(high, light[i]);
    }
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = vec3_sub(v[i], v[0]), b = vec3_sub(v[i + 1], v[0]);
        double part = vec3_dot(n, vec3_cross(a, b));
        moment = vec3_add(moment, vec3_scale(vec3_add(a, b), part / 3));
        sum += part * (light[0] + light[i] + light[i + 1]) / 3;
        twice += part;
    }
    if (!(twice > 0)) return 0;
    int longer = metres(f->face, 0, s->high[0] - s->low[0]) < metres(f->face, 1, s->high[1] - s->low[1]);
    off[longer] = share_off(f, sum / twice, light_at(f, vec3_add(v[0], vec3_scale(moment, 1 / twice))));
    // Sides are not looked at where nothing says that light bends.
    bool even = share_off(f, low, high) < EVEN_CORNERS && off[longer] < TOLERANCE / 2;
    for (int i = 0; i < count && !even; i++) {
        int next = i + 1 < count ? i + 1 : 0;
        Vec3 side = vec3_sub(v[next], v[i]);
        double along[2] = {fabs(vec3_dot(vec3_normalize(f->face->gx), side)),
                           fabs(vec3_dot(vec3_normalize(f->face->gy), side))};
        int axis = along[1] > along[0];
        if (along[axis] < f->smallest) continue;
        double middle = light_at(f, vec3_lerp(v[i], v[next], 0.5));
        off[axis] = fmax(off[axis], share_off(f, (light[i] + light[next]) / 2, middle));
    }
    return twice / 2;
}

static bool may_halve(const BendFinder *f, const Span *s, int axis) {
    return s->depth[axis] < MESH_DEEPEST && s->depth[axis] <= s->depth[1 - axis] &&
           metres(f->face, axis, s->high[axis] - s->low[axis]) / 2 >= f->smallest;
}

// The part of a convex polygon below (0) or above (1) a line of the grid; returns how many corners it has.
static int cut(const Face *face, const Vec3 *v, int count, int axis, double line, int k, Vec3 *out) {
    Vec3 g = axis == 0 ? face->gx : face->gy, n = vec3_normalize(g);
    double d = vec3_dot(n, face->origin) + line / vec3_length(g);
    Plane plane = k ? (Plane){n, d} : (Plane){vec3_scale(n, -1), -d};
    return polygon_clip(v, count, plane, 0, out);
}

// `expected`: the share that light is thought to be off, at most.
static Bend *find_in(BendFinder *f, const Span *s, const Vec3 *v, int count, double expected) {
    double off[2];
    if (count < 3 || count > MOST_CORNERS) return NULL;
    if (expected * metres(f->face, 0, s->high[0] - s->low[0]) * metres(f->face, 1, s->high[1] - s->low[1]) <
        f->least)
        return NULL;
    double area = measure(f, s, v, count, off), error = fmax(off[0], off[1]),
           size[2] = {metres(f->face, 0, s->high[0] - s->low[0]), metres(f->face, 1, s->high[1] - s->low[1])};
    bool bends = error > TOLERANCE && error * area > f->least;
    int axis = bends ? off[1] > off[0] : size[1] > size[0];
    if (!bends && !(f->light->edge && f->light->edge(f->light->context, v, count))) return NULL;
    if (!may_halve(f, s, axis)) axis = 1 - axis;
    if (!may_halve(f, s, axis)) return NULL;
    Bend *bend = ARENA_ARRAY(f->arena, Bend, 1);
    *bend = (Bend){.axis = axis, .error = bends ? error * area : 0};
    for (int k = 0; k < 2; k++) {
        Vec3 part[MOST_CORNERS + 1];
        Span half = half_of(s, axis, k);
        int corners = cut(f->face, v, count, axis, k ? half.low[axis] : half.high[axis], k, part);
        bend->half[k] = find_in(f, &half, part, corners, bends ? error : expected);
        if (bend->half[k]) bend->error = fmax(bend->error, bend->half[k]->error);
    }
    return bends || bend->half[0] || bend->half[1] ? bend : NULL;
}

Bend *bend_find(BendFinder *f, const Mesh *mesh, int element, double (*corner)[3], const BendLight *light,
                Arena *arena) {
    const Element *e = &mesh->elements[element];
    double side = EVEN * mesh->options.element;
    f->face = &mesh->faces[e->face];
    f->light = light;
    f->least = light->edge ? 0 : TOLERANCE * side * side;
    f->smallest = SMALLEST;
    f->arena = arena;
    f->count = 0;
    memset(f->known, 0, sizeof f->known);
    if (!mesh->options.splits || e->corner_count > MOST_CORNERS) return NULL;
    if (light->edge) {
        double area = metres(f->face, 0, f->face->nx) * metres(f->face, 1, f->face->ny);
        f->smallest = fmin(SMALLEST, fmax(SMALLEST_AT_EDGE, sqrt(area / MOST_SQUARES)));
    }
    Vec3 v[MOST_CORNERS];
    for (int i = 0; i < e->corner_count; i++) {
        bool is_new;
        v[i] = mesh->vertices[mesh->corners[e->first_corner + i]];
        memcpy(point_at(f, v[i], &is_new)->irradiance, corner[i], sizeof *corner);
    }
    Span span = span_of(mesh, element);
    return find_in(f, &span, v, e->corner_count, 1);
}

static Bend *bend_copy(const Bend *bend, Arena *arena) {
    if (!bend) return NULL;
    Bend *out = ARENA_ARRAY(arena, Bend, 1);
    *out = *bend;
    out->next = bend_copy(bend->next, arena);
    for (int k = 0; k < 2; k++) out->half[k] = bend_copy(bend->half[k], arena);
    return out;
}

Bend *bend_join(Bend *bend, const Bend *other, Arena *arena) {
    if (!bend || !other) return bend ? bend : bend_copy(other, arena);
    Bend *along = bend, *last = bend;
    for (; along && along->axis != other->axis; along = along->next) last = along;
    if (!along) {
        last->next = bend_copy(other, arena);
        return bend;
    }
    along->error = fmax(along->error, other->error);
    for (int k = 0; k < 2; k++) along->half[k] = bend_join(along->half[k], other->half[k], arena);
    return bend;
}

// ---- splits

typedef struct Wants {
    Bend *const *bends;
    const MeshDepth *halved;
    double least;  // bends that are off by no more than this are left out
} Wants;

static void want_part(const Wants *w, const Bend *bend, const Span *s, const double box[4], int along[2]) {
    if (s->low[0] >= box[2] || s->high[0] <= box[0] || s->low[1] >= box[3] || s->high[1] <= box[1]) return;
    bool whole = true;
    for (; bend; bend = bend->next) {
        if (bend->error <= w->least) continue;
        for (int k = 0; k < 2; k++) {
            Span half = half_of(s, bend->axis, k);
            want_part(w, bend->half[k], &half, box, along);
        }
        whole = false;
    }
    if (!whole) return;
    for (int axis = 0; axis < 2; axis++)
        along[axis] = s->depth[axis] > along[axis] ? s->depth[axis] : along[axis];
}

static void want_element(const Wants *w, const Mesh *mesh, int element, const double box[4], int along[2]) {
    MeshDepth depth = mesh->elements[element].depth;
    if (w->halved) {
        depth.x = (unsigned char)(depth.x + w->halved[element].x);
        depth.y = (unsigned char)(depth.y + w->halved[element].y);
    }
    along[0] = depth.x > along[0] ? depth.x : along[0];
    along[1] = depth.y > along[1] ? depth.y : along[1];
    if (!w->bends[element]) return;
    Span span = span_of(mesh, element);
    want_part(w, w->bends[element], &span, box, along);
}

static void want(const void *context, const Mesh *mesh, int face, const double box[4], int along[2],
                 int *patch) {
    const Face *f = &mesh->faces[face];
    int last = -1;
    for (int j = (int)box[1]; j < box[3]; j++) {
        for (int i = (int)box[0]; i < box[2]; i++) {
            int code = mesh->squares[f->first_square + j * f->nx + i];
            if (code == last || code == -1) continue;
            last = code;
            const int *several = code < 0 ? mesh->shared + ~(code + 1) : NULL;
            for (int k = 0; k < (several ? several[0] : 1); k++)
                want_element(context, mesh, several ? several[k + 1] : code, box, along);
        }
    }
    int deepest = (along[0] > along[1] ? along[0] : along[1]) - BELOW_PATCH;
    *patch = deepest > *patch ? deepest : *patch;
}

static void list_errors(const Bend *bend, double *errors, int *count) {
    if (!bend) return;
    if (errors) errors[*count] = bend->error;
    ++*count;
    for (int k = 0; k < 2; k++) list_errors(bend->half[k], errors, count);
    list_errors(bend->next, errors, count);
}

MeshSplits *bend_splits(const Mesh *mesh, Bend *const *bends, const MeshDepth *halved, double most,
                        const Borders *borders, Arena *arena) {
    Arena scratch = {0};
    Wants wants = {.bends = bends, .halved = halved};
    int own = 0, listed = 0;
    bool any = false;
    for (int e = 0; e < mesh->element_count && !any; e++)
        any = bends[e] || (halved && halved[e].x + halved[e].y > 0);
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh_owns(mesh, mesh->elements[e].face)) list_errors(bends[e], NULL, &own);
    double *errors = ARENA_ARRAY(&scratch, double, own + 1), count = own;
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh_owns(mesh, mesh->elements[e].face)) list_errors(bends[e], errors, &listed);
    if (borders) team_sum(borders_member(borders), &count, 1);
    if (count > most) wants.least = borders_least(borders, errors, own, floor(most) + 1);
    arena_free(&scratch);
    return any ? mesh_splits_wanted(mesh, want, &wants, arena) : NULL;
}
