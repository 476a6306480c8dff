// surface.c - faces on curved surfaces: cylinders, cones, spheres, tori, and profiles that are extruded or turned (ISO 16739,
// IfcGeometryResource).
//
// A face's rings go to the surface's parameters (u, v), where the face is a flat polygon with holes. It is cut there along lines of equal
// u, and of equal v on surfaces that are curved twice, and the pieces go back. Departure: rings that go around the pole of a sphere are
// not read.
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/ifc/ifc_file.h"

enum { MOST_LINES = 2000, MOST_CELL = 64 };

typedef struct Surface {
    int type;
    Frame f, back;          // and its inverse
    double a, b;            // radii; of a cone the radius at v = 0 and the tangent of its half angle
    Vec3 sweep;             // of an extrusion, in the frame
    Curve profile;          // in the frame; of a revolution its points are (radius, 0, height)
    bool round_u, round_v;  // the parameter is an angle
} Surface;

// The place of a point along a profile, in points from 0: at the nearest point of its polygon.
static double along(const Curve *profile, Vec3 p) {
    double best = INFINITY, out = 0;
    for (int i = 0; i + 1 < profile->count; i++) {
        Vec3 a = profile->points[i], d = vec3_sub(profile->points[i + 1], a);
        double t = vec3_dot(vec3_sub(p, a), d) / vec3_dot(d, d);
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        double far = vec3_length(vec3_sub(p, vec3_add(a, vec3_scale(d, t))));
        if (far < best) {
            best = far;
            out = i + t;
        }
    }
    return out;
}

static Vec3 at_place(const Curve *profile, double t) {
    int i = t <= 0 ? 0 : t >= profile->count - 2 ? profile->count - 2 : (int)t;
    return vec3_lerp(profile->points[i], profile->points[i + 1], t - i);
}

static Vec2 parameters(const Surface *s, Vec3 p) {
    Vec3 q = frame_point(&s->back, p);
    double r = hypot(q.x, q.y);
    switch (s->type) {
    case T_SPHERICALSURFACE:
        return vec2(atan2(q.y, q.x), atan2(q.z, r));
    case T_TOROIDALSURFACE:
        return vec2(atan2(q.y, q.x), atan2(q.z, r - s->a));
    case T_SURFACEOFREVOLUTION:
        return vec2(atan2(q.y, q.x), along(&s->profile, vec3(r, 0, q.z)));
    case T_SURFACEOFLINEAREXTRUSION: {
        double v = q.z / s->sweep.z;
        return vec2(along(&s->profile, vec3_sub(q, vec3_scale(s->sweep, v))), v);
    }
    default:
        return vec2(atan2(q.y, q.x), q.z);
    }
}

static Vec3 surface_point(const Surface *s, Vec2 p) {
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

static bool read_surface(Reader *r, int record, Surface *s) {
    StepValue v[4], p[3];
    *s = (Surface){.type = ifc_type(r, record), .round_u = true};
    ifc_arguments(r, record, v, 4);
    double first = ifc_length(r, &v[1], 0);
    switch (s->type) {
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

// A ring in parameters, without jumps; `advance` is how far u is from where it began, a whole turn or 0.
static double unroll(const Surface *s, const Vec3 *ring, int count, Vec2 *out) {
    for (int i = 0; i < count; i++) {
        Vec2 p = parameters(s, ring[i]);
        if (i > 0 && s->round_u) p.x = out[i - 1].x + remainder(p.x - out[i - 1].x, 2 * M_PI);
        if (i > 0 && s->round_v) p.y = out[i - 1].y + remainder(p.y - out[i - 1].y, 2 * M_PI);
        out[i] = p;
    }
    return s->round_u ? out[count - 1].x + remainder(out[0].x - out[count - 1].x, 2 * M_PI) - out[0].x : 0;
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

// The lines at which pieces are cut: at the rings' own corners where `corners`, and no farther apart than `step`.
static int cut_lines(Arena *arena, const Vec2 *points, int count, bool v, bool corners, double step,
                     double **out) {
    double *own = ARENA_ARRAY(arena, double, count + 1),
           *lines = *out = ARENA_ARRAY(arena, double, MOST_LINES);
    int own_count = 0, line_count = 0;
    for (int i = 0; i < count; i++) own[i] = v ? points[i].y : points[i].x;
    qsort(own, (size_t)count, sizeof *own, compare_numbers);
    for (int i = 0; i < count; i++) {
        bool end = i == 0 || i + 1 == count;
        if ((end || corners) && (own_count == 0 || own[i] - own[own_count - 1] > 1e-7))
            own[own_count++] = own[i];
    }
    for (int i = 0; i < own_count && line_count < MOST_LINES; i++) {
        double gap = i > 0 ? own[i] - own[i - 1] : 0;
        int parts = step > 0 && gap > step * 1.01 ? (int)fmin(MOST_LINES, ceil(gap / step)) : 1;
        for (int k = 1; k < parts && line_count < MOST_LINES - 1; k++)
            lines[line_count++] = own[i - 1] + gap * k / parts;
        lines[line_count++] = own[i];
    }
    return line_count;
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

// The rings of a face as flat rings, the first counter-clockwise; their number, 0 where they cannot be laid flat.
static int flat_rings(Reader *r, const Surface *s, const FaceRings *rings, Vec2 **points, int **size) {
    Vec2 *all = ARENA_ARRAY(&r->scratch, Vec2, rings->count + 1);
    int around[2] = {-1, -1}, first_around[2] = {0, 0}, around_count = 0, kept = 0, used = 0;
    *points = ARENA_ARRAY(&r->scratch, Vec2, rings->count + 4);
    *size = ARENA_ARRAY(&r->scratch, int, rings->ring_count + 1);
    for (int i = 0, first = 0; i < rings->ring_count; first += rings->size[i], i++) {
        double advance = unroll(s, rings->corners + first, rings->size[i], all + first);
        if (fabs(advance) < 1) continue;
        if (around_count == 2) return 0;
        around[around_count] = i;
        first_around[around_count++] = first;
    }
    if (around_count == 1) return 0;
    if (around_count == 2) {
        Vec2 *joined;
        kept = 1;
        used = (*size)[0] = join_around(&r->scratch, all + first_around[0], rings->size[around[0]],
                                        all + first_around[1], rings->size[around[1]], &joined);
        memcpy(*points, joined, (size_t)used * sizeof(Vec2));
    }
    for (int i = 0, first = 0; i < rings->ring_count; first += rings->size[i], i++) {
        if (i == around[0] || i == around[1]) continue;
        // A hole lies within the outline, whichever turn it was told on.
        double shift =
            kept && s->round_u ? 2 * M_PI * round(((*points)[0].x - all[first].x) / (2 * M_PI)) : 0;
        for (int k = 0; k < rings->size[i]; k++)
            (*points)[used++] = vec2(all[first + k].x + shift, all[first + k].y);
        (*size)[kept++] = rings->size[i];
    }
    for (int i = 0, first = 0; i < kept; first += (*size)[i], i++) {
        double twice = 0;
        Vec2 *p = *points + first;
        int count = (*size)[i];
        for (int k = 0; k < count; k++)
            twice += vec2_cross(vec2_sub(p[k], p[0]), vec2_sub(p[(k + 1) % count], p[0]));
        for (int k = 0; (twice > 0) == (i > 0) && k < count / 2; k++) {
            Vec2 keep = p[k];
            p[k] = p[count - 1 - k];
            p[count - 1 - k] = keep;
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
    int *size, *index, *piece, total = 0;
    if (rings->ring_count == 0 || !read_surface(r, record, &s)) return false;
    int count = flat_rings(r, &s, rings, &points, &size);
    if (count == 0) return false;
    for (int i = 0; i < count; i++) total += size[i];
    Vec2 *all = memcpy(ARENA_ARRAY(&r->scratch, Vec2, total + 1), points, (size_t)total * sizeof(Vec2));
    simplify(points, size, count);
    int pieces = convex_pieces(&r->scratch, points, size, count, &index, &piece);
    if (pieces < 0) return false;
    bool twice =
        s.type == T_SPHERICALSURFACE || s.type == T_TOROIDALSURFACE || s.type == T_SURFACEOFREVOLUTION;
    double *lines[2],
        step = 2 * M_PI / ifc_chords(r, s.type == T_TOROIDALSURFACE ? s.a + s.b : s.a, 2 * M_PI);
    int line_count[2] = {0, 0};
    line_count[0] = cut_lines(&r->scratch, all, total, false, true, s.round_u ? step : 1, &lines[0]);
    double other = s.type == T_TOROIDALSURFACE       ? 2 * M_PI / ifc_chords(r, s.b, 2 * M_PI)
                   : s.type == T_SURFACEOFREVOLUTION ? 1
                                                     : step;
    line_count[1] =
        twice ? cut_lines(&r->scratch, all, total, true, s.type == T_SURFACEOFREVOLUTION, other, &lines[1])
              : 0;
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
    ifc_count_polygons(r, out);
    return true;
}
