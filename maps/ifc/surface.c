// surface.c - faces on curved surfaces: cylinders, cones, spheres, tori, profiles that are extruded or turned, and B-splines (ISO 16739,
// IfcGeometryResource).
//
// A face's rings go to the surface's parameters (u, v), where the face is a flat polygon with holes. It is cut there along lines of equal
// u, and of equal v on surfaces that are curved twice, and the pieces go back. Departure: rings that go around the pole of a sphere are
// not read.
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/ifc/ifc_file.h"

enum { MOST_LINES = 2000, MOST_CELL = 1024 };
// Corners of a face lie off its B-spline surface by this at most, metres; otherwise the face is taken for flat.
static const double MOST_OFF = 1e-3;

typedef struct Surface {
    int type;
    Frame f, back;          // and its inverse
    double a, b;            // radii; of a cone the radius at v = 0 and the tangent of its half angle
    Vec3 sweep;             // of an extrusion, in the frame
    Curve profile;          // in the frame; of a revolution its points are (radius, 0, height)
    SplineSurface spline;   // its parameters times 2 pi where it is closed
    bool round_u, round_v;  // the parameter is an angle
} Surface;

static Vec3 at_place(const Curve *profile, double t) {
    int i = t <= 0 ? 0 : t >= profile->count - 2 ? profile->count - 2 : (int)t;
    return vec3_lerp(profile->points[i], profile->points[i + 1], t - i);
}

static bool is_spline(const Surface *s) {
    return s->type == T_BSPLINESURFACEWITHKNOTS || s->type == T_RATIONALBSPLINESURFACEWITHKNOTS;
}

// Parameters of a B-spline surface are multiplied by these.
static Vec2 spline_scale(const Surface *s) {
    return vec2(s->round_u ? 2 * M_PI : 1, s->round_v ? 2 * M_PI : 1);
}

static Vec2 parameters(const Surface *s, Vec3 p) {
    if (is_spline(s)) {
        Vec2 at = ifc_spline_nearest(&s->spline, p), scale = spline_scale(s);
        return vec2(at.x * scale.x, at.y * scale.y);
    }
    Vec3 q = frame_point(&s->back, p);
    double r = hypot(q.x, q.y);
    switch (s->type) {
    case T_SPHERICALSURFACE:
        return vec2(atan2(q.y, q.x), atan2(q.z, r));
    case T_TOROIDALSURFACE:
        return vec2(atan2(q.y, q.x), atan2(q.z, r - s->a));
    case T_SURFACEOFREVOLUTION:
        return vec2(atan2(q.y, q.x), ifc_along(&s->profile, vec3(r, 0, q.z), NULL));
    case T_SURFACEOFLINEAREXTRUSION: {
        double v = q.z / s->sweep.z;
        return vec2(ifc_along(&s->profile, vec3_sub(q, vec3_scale(s->sweep, v)), NULL), v);
    }
    default:
        return vec2(atan2(q.y, q.x), q.z);
    }
}

static Vec3 surface_point(const Surface *s, Vec2 p) {
    if (is_spline(s)) {
        Vec2 scale = spline_scale(s);
        return ifc_spline_point(&s->spline, vec2(p.x / scale.x, p.y / scale.y));
    }
    Vec3 q;
    double c = cos(p.x), n = sin(p.x);
    switch (s->type) {
    case T_SPHERICALSURFACE:
        q = vec3(s->a * cos(p.y) * c, s->a * cos(p.y) * n, s->a * sin(p.y));
        break;
    case T_TOROIDALSURFACE:
        q = vec3((s->a + s->b * cos(p.y)) * c, (s->a + s->b * cos(p.y)) * n, s->b * sin(p.y));
        break;
    case T_SURFACEOFREVOLUTION: {
        Vec3 at = at_place(&s->profile, p.y);
        q = vec3(at.x * c, at.x * n, at.z);
        break;
    }
    case T_SURFACEOFLINEAREXTRUSION:
        q = vec3_add(at_place(&s->profile, p.x), vec3_scale(s->sweep, p.y));
        break;
    default:
        q = vec3((s->a + s->b * p.y) * c, (s->a + s->b * p.y) * n, p.y);
        break;
    }
    return frame_point(&s->f, q);
}

// `points` is how many will be looked for on it.
static bool read_surface(Reader *r, int record, int points, Surface *s) {
    StepValue v[4], p[3];
    *s = (Surface){.type = ifc_type(r, record), .round_u = true};
    ifc_arguments(r, record, v, 4);
    double first = ifc_length(r, &v[1], 0);
    switch (s->type) {
    case T_BSPLINESURFACEWITHKNOTS:
    case T_RATIONALBSPLINESURFACEWITHKNOTS:
        s->f = frame_identity();
        if (!ifc_spline_surface(r, record, points, &s->spline)) return false;
        s->round_u = s->spline.closed[0];
        s->round_v = s->spline.closed[1];
        break;
    case T_CYLINDRICALSURFACE:
    case T_CONICALSURFACE:
        s->f = ifc_axes(r, v[0].record);
        s->a = first;
        if (s->type == T_CONICALSURFACE) s->b = tan(ifc_number(r, &v[2], 0) * r->file->angle);
        if (!(first >= 0 && fabs(s->b) < 1e6)) return false;
        break;
    case T_SPHERICALSURFACE:
    case T_TOROIDALSURFACE:
        s->f = ifc_axes(r, v[0].record);
        s->a = first;
        s->b = ifc_length(r, &v[2], 0);
        s->round_v = s->type == T_TOROIDALSURFACE;
        if (!(first > 0) || (s->round_v && !(s->b > 0))) return false;
        break;
    case T_SURFACEOFLINEAREXTRUSION:
    case T_SURFACEOFREVOLUTION: {
        // The swept curve is that of a profile, open or closed, in the surface's own frame.
        if (ifc_type(r, v[0].record) < 0 || !ifc_arguments(r, v[0].record, p, 3) ||
            !ifc_curve(r, p[2].record, &s->profile))
            return false;
        if (s->profile.closed) {
            Vec3 begin = s->profile.points[0];
            *ARENA_PUSH(&r->scratch, s->profile.points, s->profile.count, s->profile.room) = begin;
        }
        if (s->profile.count < 2) return false;
        Frame place = ifc_axes(r, v[1].record);
        if (s->type == T_SURFACEOFLINEAREXTRUSION) {
            s->round_u = false;
            s->f = place;
            s->sweep = vec3_scale(ifc_direction(r, v[2].record, vec3(0, 0, 1)), ifc_length(r, &v[3], 1));
            if (!(fabs(s->sweep.z) > 1e-9)) return false;
            break;
        }
        Frame axis = ifc_axis(r, v[2].record);
        s->f = frame_join(&place, &axis);
        Frame back = frame_inverse(&axis);
        // The curve lies in a plane through the axis: its points are radius and height, at the angle of the farthest one.
        Vec3 far = {0, 0, 0};
        for (int i = 0; i < s->profile.count; i++) {
            Vec3 q = s->profile.points[i] = frame_point(&back, s->profile.points[i]);
            if (hypot(q.x, q.y) > hypot(far.x, far.y)) far = q;
        }
        double size = hypot(far.x, far.y);
        if (!(size > 1e-9)) return false;
        for (int i = 0; i < s->profile.count; i++) {
            Vec3 q = s->profile.points[i];
            s->profile.points[i] = vec3((q.x * far.x + q.y * far.y) / size, 0, q.z);
        }
        s->a = size;
        break;
    }
    default:
        return false;
    }
    s->back = frame_inverse(&s->f);
    return true;
}

// A ring in parameters, without jumps. Returns how far u is from where it began, a whole turn or 0; NAN where the ring leaves a B-spline
// surface. A ring that touches a pole of such a surface goes along the edge that the pole is: it has one more corner for each.
static double unroll(const Surface *s, const Vec3 *ring, int *count, Vec2 *out) {
    int total = 0, in = *count, pole_count = 0;
    for (int i = 0; i < in; i++) {
        Vec2 p = parameters(s, ring[i]), *last = total > 0 ? &out[total - 1] : NULL;
        int pole = -1;
        if (is_spline(s)) {
            if (!(vec3_length(vec3_sub(surface_point(s, p), ring[i])) <= MOST_OFF)) return NAN;
            pole = ifc_spline_pole(&s->spline, ring[i]);
        }
        if (last && s->round_u) p.x = last->x + remainder(p.x - last->x, 2 * M_PI);
        if (last && s->round_v) p.y = last->y + remainder(p.y - last->y, 2 * M_PI);
        if (pole >= 0) {
            Vec2 scale = spline_scale(s), before = last ? *last : parameters(s, ring[in - 1]),
                 after = parameters(s, ring[(i + 1) % in]);
            double end = pole % 2;
            bool along_u = pole < 2;
            out[total++] = along_u ? vec2(before.x, end * scale.y) : vec2(end * scale.x, before.y);
            p = along_u ? vec2(after.x, end * scale.y) : vec2(end * scale.x, after.y);
            pole_count++;
        }
        out[total++] = p;
    }
    *count = total;
    return s->round_u && pole_count == 0
               ? out[total - 1].x + remainder(out[0].x - out[total - 1].x, 2 * M_PI) - out[0].x
               : 0;
}

// Two rings that go around the surface, as one ring: along the first, over to the second, along it and back.
static int join_around(Arena *arena, const Vec2 *a, int a_count, const Vec2 *b, int b_count, Vec2 **out) {
    double turn = a[a_count - 1].x > a[0].x ? 2 * M_PI : -2 * M_PI;
    Vec2 *ring = *out = ARENA_ARRAY(arena, Vec2, a_count + b_count + 2);
    int count = 0, start = 0;
    for (int i = 0; i < a_count; i++) ring[count++] = a[i];
    Vec2 end = vec2(a[0].x + turn, a[0].y);
    ring[count++] = end;
    double nearest = INFINITY;
    for (int i = 0; i < b_count; i++) {
        double off = fabs(remainder(b[i].x - end.x, 2 * M_PI));
        if (off < nearest - 1e-9) {
            nearest = off;
            start = i;
        }
    }
    double x = end.x + remainder(b[start].x - end.x, 2 * M_PI);
    for (int i = 0; i <= b_count; i++) {
        Vec2 p = b[(start + i) % b_count];
        if (i > 0) x = ring[count - 1].x + remainder(p.x - ring[count - 1].x, 2 * M_PI);
        ring[count++] = vec2(x, p.y);
    }
    return count;
}

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

// The flat rings of a face.
typedef struct FlatRings {
    const Vec2 *points;
    const int *size;  // [count]
    int count, total;
} FlatRings;

// How a parameter is cut between corners: no farther apart than `step`, or each span into its parts. Spans repeat after `period`.
typedef struct Steps {
    double step, period;     // 0: none
    const SplineSpan *span;  // of 0 .. 1, times `scale`
    int spans;
    double scale;
} Steps;

// Pushes the lines between two corners.
static void fill_gap(const Steps *steps, double a, double b, double *lines, int *count) {
    double gap = b - a;
    if (steps->spans == 0) {
        int parts =
            steps->step > 0 && gap > steps->step * 1.01 ? (int)fmin(MOST_LINES, ceil(gap / steps->step)) : 1;
        for (int k = 1; k < parts && *count < MOST_LINES - 1; k++) lines[(*count)++] = a + gap * k / parts;
        return;
    }
    double least = 1e-6 * steps->scale;
    for (double turn = steps->period > 0 ? floor(a / steps->period) * steps->period : 0; turn < b;
         turn += steps->period) {
        for (int k = 0; k < steps->spans; k++) {
            double low = turn + steps->span[k].low * steps->scale,
                   high = turn + steps->span[k].high * steps->scale,
                   step = (high - low) / steps->span[k].parts;
            low = fmax(low, a);
            high = fmin(high, b);
            if (!(low < high)) continue;
            int parts = gap < 1.25 * step ? 1 : (int)ceil((high - low) / step - 0.01);
            for (int n = 0; n < parts; n++) {
                double t = low + (high - low) * n / parts;
                if (t - lines[*count - 1] > least && b - t > least && *count < MOST_LINES - 1)
                    lines[(*count)++] = t;
            }
        }
        if (steps->period == 0) break;
    }
}

// The lines at which pieces are cut: at all corners of the rings, or at those alone whose edges run along the other parameter, so that
// faces on both sides of such an edge have the same corners; and between these by steps.
static int cut_lines(Arena *arena, const FlatRings *rings, bool v, bool all_corners, const Steps *steps,
                     double **out) {
    double *own = ARENA_ARRAY(arena, double, 2 * rings->total + 2),
           *lines = *out = ARENA_ARRAY(arena, double, MOST_LINES), least = INFINITY, most = -INFINITY;
    int own_count = 0, kept = 0, count = 0;
    for (int i = 0, first = 0; i < rings->count; first += rings->size[i], i++) {
        for (int k = 0; k < rings->size[i]; k++) {
            Vec2 a = rings->points[first + k], b = rings->points[first + (k + 1) % rings->size[i]];
            double from = v ? a.y : a.x, to = v ? b.y : b.x;
            least = fmin(least, from);
            most = fmax(most, from);
            if (!all_corners && fabs(v ? a.x - b.x : a.y - b.y) > SHAPE_EPSILON) continue;
            own[own_count++] = from;
            own[own_count++] = to;
        }
    }
    own[own_count++] = least;
    own[own_count++] = most;
    qsort(own, (size_t)own_count, sizeof *own, compare_numbers);
    for (int i = 0; i < own_count; i++)
        if (kept == 0 || own[i] - own[kept - 1] > 1e-7) own[kept++] = own[i];
    for (int i = 0; i < kept && count < MOST_LINES; i++) {
        if (i > 0) fill_gap(steps, own[i - 1], own[i], lines, &count);
        lines[count++] = own[i];
    }
    return count;
}

// How both parameters of a surface are cut.
static void find_steps(Reader *r, const Surface *s, Steps steps[2]) {
    steps[0] = steps[1] = (Steps){0};
    double radius = s->type == T_TOROIDALSURFACE ? s->a + s->b : s->a;
    if (is_spline(s)) {
        Vec2 scale = spline_scale(s);
        for (int d = 0; d < 2; d++)
            steps[d] = (Steps){.span = s->spline.span[d],
                               .spans = s->spline.spans[d],
                               .scale = d == 0 ? scale.x : scale.y,
                               .period = s->spline.closed[d] ? 2 * M_PI : 0};
        return;
    }
    if (s->round_u) steps[0].step = 2 * M_PI / ifc_chords(r, radius, 2 * M_PI);
    steps[1].step = s->type == T_TOROIDALSURFACE ? 2 * M_PI / ifc_chords(r, s->b, 2 * M_PI) : steps[0].step;
    if (s->profile.count < 2) return;
    // A profile is cut at its points.
    int spans = s->profile.count - 1;
    SplineSpan *span = ARENA_ARRAY(&r->scratch, SplineSpan, spans);
    for (int i = 0; i < spans; i++) span[i] = (SplineSpan){i, i + 1, 1};
    steps[s->type == T_SURFACEOFREVOLUTION] = (Steps){.span = span, .spans = spans, .scale = 1};
}

// The part of a flat piece between two values of one parameter.
static int clip_between(const Vec3 *in, int count, bool v, double low, double high, Vec3 *out) {
    Vec3 half[MOST_CELL + 2], n = v ? vec3(0, 1, 0) : vec3(1, 0, 0);
    count = polygon_clip(in, count, (Plane){n, low}, 0, half);
    return polygon_clip(half, count, (Plane){vec3_scale(n, -1), -high}, 0, out);
}

static void add_piece(Reader *r, const Surface *s, const Vec3 *flat, int count, bool same_sense, Shape *out) {
    Vec3 corner[MOST_CELL + 4];
    int kept = 0;
    for (int i = 0; i < count; i++) {
        int at = same_sense ? i : count - 1 - i;
        Vec3 p = surface_point(s, vec2(flat[at].x, flat[at].y));
        if (kept == 0 || vec3_length(vec3_sub(p, corner[kept - 1])) > IFC_SAME_POINT) corner[kept++] = p;
    }
    if (kept > 1 && vec3_length(vec3_sub(corner[0], corner[kept - 1])) <= IFC_SAME_POINT) kept--;
    count = kept;
    if (count < 3) return;
    if (polygon_bend(corner, count, plane_of_polygon(corner, count)) < SHAPE_EPSILON / 10) {
        shape_add(&r->scratch, out, corner, count, -1);
        return;
    }
    for (int k = 1; k + 1 < count; k++)
        shape_add(&r->scratch, out, (Vec3[3]){corner[0], corner[k], corner[k + 1]}, 3, -1);
}

// Cuts a flat convex piece at the lines and adds what comes of it.
static void add_cells(Reader *r, const Surface *s, const Vec3 *piece, int count, double *const lines[2],
                      const int line_count[2], bool same_sense, Shape *out) {
    Vec3 strip[MOST_CELL + 4], cell[MOST_CELL + 4];
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, piece[i]);
    for (int i = 0; i + 1 < line_count[0]; i++) {
        if (lines[0][i + 1] <= box.min.x || lines[0][i] >= box.max.x) continue;
        int wide = clip_between(piece, count, false, lines[0][i], lines[0][i + 1], strip);
        if (line_count[1] < 2) {
            add_piece(r, s, strip, wide, same_sense, out);
            continue;
        }
        for (int k = 0; k + 1 < line_count[1] && wide >= 3; k++) {
            if (lines[1][k + 1] <= box.min.y || lines[1][k] >= box.max.y) continue;
            add_piece(r, s, cell, clip_between(strip, wide, true, lines[1][k], lines[1][k + 1], cell),
                      same_sense, out);
        }
    }
}

// The rings of a face as flat rings, the first counter-clockwise; their number, 0 where they cannot be laid flat. `sense` becomes that of
// the outline, which neighbours share, where it has one: files often tell a surface's side the other way.
static int flat_rings(Reader *r, const Surface *s, const FaceRings *rings, Vec2 **points, int **size,
                      bool *sense) {
    // Twice as many corners, for those at poles.
    Vec2 *all = ARENA_ARRAY(&r->scratch, Vec2, 2 * rings->count + 1);
    int *count = ARENA_ARRAY(&r->scratch, int, rings->ring_count + 1), around[2] = {-1, -1},
        first_around[2] = {0, 0}, around_count = 0, kept = 0, used = 0;
    *points = ARENA_ARRAY(&r->scratch, Vec2, 2 * rings->count + 4);
    *size = ARENA_ARRAY(&r->scratch, int, rings->ring_count + 1);
    for (int i = 0, first = 0, at = 0; i < rings->ring_count; first += rings->size[i], at += count[i], i++) {
        count[i] = rings->size[i];
        double advance = unroll(s, rings->corners + first, &count[i], all + at);
        if (fabs(advance) < 1) continue;
        if (around_count == 2 || isnan(advance)) return 0;
        around[around_count] = i;
        first_around[around_count++] = at;
    }
    if (around_count == 1) return 0;
    if (around_count == 2) {
        Vec2 *joined;
        kept = 1;
        used = (*size)[0] = join_around(&r->scratch, all + first_around[0], count[around[0]],
                                        all + first_around[1], count[around[1]], &joined);
        memcpy(*points, joined, (size_t)used * sizeof(Vec2));
    }
    for (int i = 0, first = 0; i < rings->ring_count; first += count[i], i++) {
        if (i == around[0] || i == around[1]) continue;
        // A hole lies within the outline, whichever turn it was told on.
        double shift =
            kept && s->round_u ? 2 * M_PI * round(((*points)[0].x - all[first].x) / (2 * M_PI)) : 0;
        for (int k = 0; k < count[i]; k++)
            (*points)[used++] = vec2(all[first + k].x + shift, all[first + k].y);
        (*size)[kept++] = count[i];
    }
    for (int i = 0, first = 0; i < kept; first += (*size)[i], i++) {
        double twice = 0;
        Vec2 *p = *points + first;
        int corners = (*size)[i];
        for (int k = 0; k < corners; k++)
            twice += vec2_cross(vec2_sub(p[k], p[0]), vec2_sub(p[(k + 1) % corners], p[0]));
        if (i == 0) *sense = twice > 0;
        for (int k = 0; (twice > 0) == (i > 0) && k < corners / 2; k++) {
            Vec2 keep = p[k];
            p[k] = p[corners - 1 - k];
            p[corners - 1 - k] = keep;
        }
    }
    return kept;
}

// Leaves out corners that lie in a line with their neighbours: the lines cut there anyway.
static void simplify(Vec2 *points, int *size, int ring_count) {
    int used = 0;
    for (int i = 0, first = 0; i < ring_count; i++) {
        int count = size[i], begin = used;
        Vec2 last = points[first + count - 1];
        for (int k = 0; k < count; k++) {
            Vec2 p = points[first + k], next = k + 1 < count  ? points[first + k + 1]
                                               : begin < used ? points[begin]
                                                              : p;
            Vec2 in = vec2_sub(p, last), out = vec2_sub(next, p);
            bool straight = fabs(vec2_cross(in, out)) <= 1e-9 * (vec2_length(in) + vec2_length(out)) &&
                            vec2_dot(in, out) >= 0;
            if (straight) continue;
            points[used++] = last = p;
        }
        first += count;
        size[i] = used - begin;
    }
}

bool ifc_curved_face(Reader *r, int record, const FaceRings *rings, bool same_sense, Shape *out) {
    Surface s;
    Vec2 *points;
    int *size, *index, *piece, total = 0, before = out->face_count;
    if (rings->ring_count == 0 || !read_surface(r, record, rings->count, &s)) return false;
    int count = flat_rings(r, &s, rings, &points, &size, &same_sense);
    if (count <= 0) return false;
    for (int i = 0; i < count; i++) total += size[i];
    Vec2 *all = memcpy(ARENA_ARRAY(&r->scratch, Vec2, total + 1), points, (size_t)total * sizeof(Vec2));
    int *all_size = memcpy(ARENA_ARRAY(&r->scratch, int, count), size, (size_t)count * sizeof(int));
    simplify(points, size, count);
    int pieces = convex_pieces(&r->scratch, points, size, count, &index, &piece);
    if (pieces < 0) return false;
    FlatRings flat_face = {all, all_size, count, total};
    bool twice = is_spline(&s) || s.type == T_SPHERICALSURFACE || s.type == T_TOROIDALSURFACE ||
                 s.type == T_SURFACEOFREVOLUTION;
    Steps steps[2];
    double *lines[2];
    int line_count[2] = {0, 0};
    find_steps(r, &s, steps);
    for (int d = 0; d < (twice ? 2 : 1); d++)
        line_count[d] = cut_lines(&r->scratch, &flat_face, d == 1, !twice, &steps[d], &lines[d]);
    for (int i = 0; i < pieces; index += piece[i], i++) {
        // In triangles, where a piece has too many corners for the cells.
        Vec3 flat[MOST_CELL];
        int whole = piece[i] <= MOST_CELL - 4;
        for (int k = 1; k + 1 < piece[i]; k += whole ? piece[i] : 1) {
            int corners = whole ? piece[i] : 3;
            for (int n = 0; n < corners; n++) {
                Vec2 p = points[index[whole ? n : n == 0 ? 0 : k + n - 1]];
                flat[n] = vec3(p.x, p.y, 0);
            }
            add_cells(r, &s, flat, corners, lines, line_count, same_sense, out);
        }
    }
    ifc_count_polygons(r, out->face_count - before);
    return true;
}
