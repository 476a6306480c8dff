// sweep.c - bodies that a profile sweeps out: extrusions, revolutions, disks along a curve; and the primitives of CSG (ISO 16739,
// IfcGeometricModelResource).
#include "maps/ifc/ifc_file.h"

// One area of a profile: its first ring and how many there are.
static int next_area(const Profile *p, int ring) {
    int end = ring + 1;
    while (end < p->ring_count && !p->outer[end]) end++;
    return end;
}

// A flat face of some rings of points of a frame; turned over where `flip`.
static void add_cap(Reader *r, const Vec3 *points, const int *size, int rings, bool flip, Shape *out) {
    int total = 0;
    for (int i = 0; i < rings; i++) total += size[i];
    Vec3 *turned = ARENA_ARRAY(&r->scratch, Vec3, total + 1);
    for (int i = 0, first = 0; i < rings; first += size[i], i++)
        for (int k = 0; k < size[i]; k++) turned[first + k] = points[first + (flip ? size[i] - 1 - k : k)];
    if (!shape_add_rings(&r->scratch, out, turned, size, rings, -1))
        ifc_note(r, -1, "a face of %d corners cannot be cut into convex ones", total);
}

// Four corners, as two triangles where they are not in a plane.
static void sweep_quad(Reader *r, Vec3 a, Vec3 b, Vec3 c, Vec3 d, Shape *out) {
    Vec3 all[4] = {a, b, c, d}, quad[4];
    int count = 0;
    for (int i = 0; i < 4; i++)
        if (count == 0 || vec3_length(vec3_sub(all[i], quad[count - 1])) > 1e-9) quad[count++] = all[i];
    if (count > 1 && vec3_length(vec3_sub(quad[0], quad[count - 1])) <= 1e-9) count--;
    if (count < 4) {
        shape_add(&r->scratch, out, quad, count, -1);
        return;
    }
    Plane plane = plane_of_polygon(quad, 4);
    if (vec3_length(plane.n) == 0) return;
    if (fabs(plane_distance(plane, a)) < SHAPE_EPSILON / 10 &&
        fabs(plane_distance(plane, b)) < SHAPE_EPSILON / 10) {
        shape_add(&r->scratch, out, quad, 4, -1);
        return;
    }
    shape_add(&r->scratch, out, (Vec3[3]){a, b, c}, 3, -1);
    shape_add(&r->scratch, out, (Vec3[3]){a, c, d}, 3, -1);
}

// The body between rings at its base and at its top.
static void loft(Reader *r, const Profile *p, const Vec3 *base, const Vec3 *top, Shape *out) {
    for (int ring = 0, first = 0; ring < p->ring_count; ring++) {
        int count = p->size[ring];
        for (int k = 0; k + p->open < count; k++) {
            int a = first + k, b = first + (k + 1) % count;
            sweep_quad(r, base[a], base[b], top[b], top[a], out);
        }
        first += count;
    }
    if (p->open) return;
    for (int ring = 0, first = 0; ring < p->ring_count;) {
        int end = next_area(p, ring), total = 0;
        for (int i = ring; i < end; i++) total += p->size[i];
        add_cap(r, base + first, p->size + ring, end - ring, true, out);
        add_cap(r, top + first, p->size + ring, end - ring, false, out);
        first += total;
        ring = end;
    }
}

// The sweep runs to the side of the frame's z, or the body is turned inside out.
void ifc_sweep_profile(Reader *r, const Profile *profile, const Frame *frame, Vec3 sweep, Shape *out) {
    int count = profile->rings.count, before = out->face_count;
    Vec3 *base = ARENA_ARRAY(&r->scratch, Vec3, count + 1), *top = ARENA_ARRAY(&r->scratch, Vec3, count + 1);
    for (int i = 0; i < count; i++) {
        base[i] = frame_point(frame, profile->rings.points[i]);
        top[i] = vec3_add(base[i], sweep);
    }
    loft(r, profile, base, top, out);
    if (profile->open || vec3_dot(frame->z, sweep) >= 0) return;
    Shape added = {
        .corners = out->corners, .faces = out->faces + before, .face_count = out->face_count - before};
    shape_flip(&added);
}

bool ifc_extrusion(Reader *r, int record, Shape *out, Prism *prism) {
    StepValue v[5];
    Profile profile = {0}, end = {0};
    ifc_arguments(r, record, v, 5);
    if (!ifc_profile(r, v[0].record, &profile)) return false;
    Frame f = ifc_axes(r, v[1].record);
    double depth = ifc_length(r, &v[3], 0);
    Vec3 sweep = vec3_scale(frame_turn(&f, ifc_direction(r, v[2].record, vec3(0, 0, 1))), depth);
    if (fabs(vec3_dot(sweep, f.z)) < IFC_SAME_POINT) {
        ifc_note(r, record, "has no height");
        return false;
    }
    out->solid = !profile.open;
    if (ifc_type(r, record) == T_EXTRUDEDAREASOLIDTAPERED) {
        if (!ifc_profile(r, v[4].record, &end)) return false;
        bool fits = end.ring_count == profile.ring_count && !profile.open;
        for (int i = 0; fits && i < end.ring_count; i++) fits = end.size[i] == profile.size[i];
        if (!fits) {
            ifc_note(r, record, "has profiles at its ends with different corners");
            return false;
        }
        for (int i = 0; i < profile.rings.count; i++) {
            profile.rings.points[i] = frame_point(&f, profile.rings.points[i]);
            end.rings.points[i] = vec3_add(frame_point(&f, end.rings.points[i]), sweep);
        }
        loft(r, &profile, profile.rings.points, end.rings.points, out);
        if (shape_volume(out) < 0) shape_flip(out);
        return true;
    }
    ifc_sweep_profile(r, &profile, &f, sweep, out);
    int areas = 0;
    for (int i = 0; i < profile.ring_count; i++) areas += profile.outer[i];
    if (prism && !profile.open && areas == 1) {
        *prism = (Prism){ARENA_ARRAY(&r->scratch, Vec3, profile.rings.count), profile.size,
                         profile.ring_count, sweep, false};
        for (int i = 0; i < profile.rings.count; i++)
            prism->corners[i] = frame_point(&f, profile.rings.points[i]);
    }
    return true;
}

static Vec3 turn_about_axis(Vec3 p, const Frame *axis, double angle) {
    Vec3 d = vec3_sub(p, axis->o), z = axis->z;
    double along = vec3_dot(d, z);
    Vec3 across = vec3_sub(d, vec3_scale(z, along)), side = vec3_cross(z, across);
    d = vec3_add(vec3_scale(z, along),
                 vec3_add(vec3_scale(across, cos(angle)), vec3_scale(side, sin(angle))));
    return vec3_add(axis->o, d);
}

// Rings of points, one behind the other along a way: the sides between them, and caps unless the way is closed.
static void add_rings(Reader *r, const Profile *p, Vec3 *const *ring, int count, bool closed, Shape *out) {
    for (int i = 0; i + !closed < count; i++) {
        const Vec3 *a = ring[i], *b = ring[(i + 1) % count];
        for (int k = 0, first = 0; k < p->ring_count; first += p->size[k], k++) {
            for (int c = 0; c + p->open < p->size[k]; c++) {
                int here = first + c, next = first + (c + 1) % p->size[k];
                sweep_quad(r, a[here], a[next], b[next], b[here], out);
            }
        }
    }
    if (closed || p->open) return;
    for (int k = 0, first = 0; k < p->ring_count;) {
        int end = next_area(p, k), total = 0;
        for (int i = k; i < end; i++) total += p->size[i];
        add_cap(r, ring[0] + first, p->size + k, end - k, true, out);
        add_cap(r, ring[count - 1] + first, p->size + k, end - k, false, out);
        first += total;
        k = end;
    }
}

bool ifc_revolution(Reader *r, int record, Shape *out) {
    StepValue v[4];
    Profile profile = {0};
    ifc_arguments(r, record, v, 4);
    if (!ifc_profile(r, v[0].record, &profile)) return false;
    Frame f = ifc_axes(r, v[1].record), axis = ifc_axis(r, v[2].record);
    axis = frame_join(&f, &axis);
    double angle = ifc_number(r, &v[3], 0) * r->file->angle, radius = 0;
    if (!(fabs(angle) > 1e-9)) {
        ifc_note(r, record, "turns by the angle 0");
        return false;
    }
    if (fabs(angle) > 2 * M_PI) angle = copysign(2 * M_PI, angle);
    int count = profile.rings.count;
    for (int i = 0; i < count; i++) {
        Vec3 p = profile.rings.points[i] = frame_point(&f, profile.rings.points[i]);
        Vec3 d = vec3_sub(p, axis.o);
        radius = fmax(radius, vec3_length(vec3_sub(d, vec3_scale(axis.z, vec3_dot(d, axis.z)))));
    }
    bool closed = fabs(fabs(angle) - 2 * M_PI) < 1e-6;
    int chords = ifc_chords(r, radius, angle);
    if (chords < 3 && closed) chords = 3;
    Vec3 **ring = ARENA_ARRAY(&r->scratch, Vec3 *, chords + 1);
    for (int i = 0; i <= chords; i++) {
        ring[i] = ARENA_ARRAY(&r->scratch, Vec3, count + 1);
        for (int k = 0; k < count; k++)
            ring[i][k] = turn_about_axis(profile.rings.points[k], &axis, angle * i / chords);
    }
    add_rings(r, &profile, ring, closed ? chords : chords + 1, closed, out);
    out->solid = !profile.open;
    if (out->solid && shape_volume(out) < 0) shape_flip(out);
    return true;
}

// ---- sweeps along a curve

// The directions of a curve at its points: along it, half way between both edges.
static Vec3 *tangents(Reader *r, const Curve *c) {
    Vec3 *out = ARENA_ARRAY(&r->scratch, Vec3, c->count + 1);
    for (int i = 0; i < c->count; i++) {
        bool first = i == 0 && !c->closed, last = i + 1 == c->count && !c->closed;
        Vec3 before = vec3_sub(c->points[i], c->points[(i + c->count - 1) % c->count]);
        Vec3 after = vec3_sub(c->points[(i + 1) % c->count], c->points[i]);
        Vec3 t = first ? after : last ? before : vec3_add(vec3_normalize(before), vec3_normalize(after));
        if (first && vec3_length(c->first) > 0) t = c->first;
        if (last && vec3_length(c->last) > 0) t = c->last;
        out[i] = vec3_normalize(vec3_length(t) > 1e-9 ? t : before);
    }
    return out;
}

// Moves the points of one ring along the edge into the plane through the next point: a mitred joint.
static void next_ring(const Vec3 *from, int count, Vec3 along, Vec3 point, Vec3 tangent, Vec3 *out) {
    double slope = vec3_dot(along, tangent);
    for (int k = 0; k < count; k++) {
        double way = vec3_dot(vec3_sub(point, from[k]), tangent) / slope;
        out[k] = vec3_add(from[k], vec3_scale(along, way));
    }
}

// The direction in which an open curve begins, or in which a closed one leaves its first point.
static Vec3 start_of(const Curve *c) {
    return !c->closed && vec3_length(c->first) > 0 ? c->first
                                                   : vec3_normalize(vec3_sub(c->points[1], c->points[0]));
}

// Sweeps rings, whose points lie in the plane square to the curve's start.
static void sweep_along(Reader *r, const Profile *p, const Vec3 *start, const Curve *c, Shape *out) {
    int count = p->rings.count, rings = c->count + c->closed;
    Vec3 *tangent = tangents(r, c), **ring = ARENA_ARRAY(&r->scratch, Vec3 *, rings + 1);
    ring[0] = ARENA_ARRAY(&r->scratch, Vec3, count + 1);
    Vec3 first = vec3_normalize(vec3_sub(c->points[1], c->points[0]));
    next_ring(start, count, first, c->points[0], tangent[0], ring[0]);
    for (int i = 1; i < rings; i++) {
        ring[i] = ARENA_ARRAY(&r->scratch, Vec3, count + 1);
        Vec3 along = vec3_normalize(vec3_sub(c->points[i % c->count], c->points[i - 1]));
        Vec3 t = tangent[i % c->count];
        if (vec3_dot(along, t) < 0.05) t = along;  // the curve turns back: no mitre
        next_ring(ring[i - 1], count, along, c->points[i % c->count], t, ring[i]);
    }
    // A closed curve whose last ring is the first one has no ends.
    bool closed = c->closed;
    for (int k = 0; k < count && closed; k++)
        closed = vec3_length(vec3_sub(ring[0][k], ring[rings - 1][k])) < SHAPE_EPSILON;
    add_rings(r, p, ring, closed ? rings - 1 : rings, closed, out);
}

static void circle_profile(Reader *r, double radius, double inner, Profile *p) {
    int chords = ifc_chords(r, radius, 2 * M_PI);
    p->size = ARENA_ARRAY(&r->scratch, int, 2);
    p->outer = ARENA_ARRAY(&r->scratch, bool, 2);
    p->ring_count = inner > 0 ? 2 : 1;
    p->outer[0] = true;
    for (int k = 0; k < p->ring_count; k++) {
        p->size[k] = chords;
        for (int i = 0; i < chords; i++) {
            double t = 2 * M_PI * (k ? chords - i : i) / chords, d = k ? inner : radius;
            *ARENA_PUSH(&r->scratch, p->rings.points, p->rings.count, p->rings.room) =
                vec3(d * cos(t), d * sin(t), 0);
        }
    }
}

bool ifc_swept_disk(Reader *r, int record, Shape *out) {
    StepValue v[6];
    Curve line = {0};
    ifc_arguments(r, record, v, 6);
    double radius = ifc_length(r, &v[1], 0), inner = ifc_length(r, &v[2], 0);
    if (!ifc_curve_between(r, v[0].record, ifc_number(r, &v[3], NAN), ifc_number(r, &v[4], NAN), &line) ||
        line.count < 2)
        return false;
    if (!(radius > 0) || inner >= radius) {
        ifc_note(r, record, "has the radius %g and inside %g (allowed: above 0, and less inside)", radius,
                 inner);
        return false;
    }
    Profile disk = {0};
    circle_profile(r, radius, inner, &disk);
    Vec3 z = start_of(&line), x = fabs(z.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    x = vec3_normalize(vec3_sub(x, vec3_scale(z, vec3_dot(x, z))));
    Frame f = {x, vec3_cross(z, x), z, line.points[0]};
    for (int i = 0; i < disk.rings.count; i++) disk.rings.points[i] = frame_point(&f, disk.rings.points[i]);
    sweep_along(r, &disk, disk.rings.points, &line, out);
    out->solid = true;
    return true;
}

// IfcFixedReferenceSweptAreaSolid and IfcSurfaceCurveSweptAreaSolid: the profile's x is the curve's side, which is told by the fixed
// direction or the surface's normal. Departure: the profile keeps its turn about the curve from the first point on.
bool ifc_directed_sweep(Reader *r, int record, Shape *out) {
    StepValue v[6], w[3];
    Profile profile = {0};
    Curve line = {0};
    ifc_arguments(r, record, v, 6);
    if (!ifc_profile(r, v[0].record, &profile) ||
        !ifc_curve_between(r, v[2].record, ifc_number(r, &v[3], NAN), ifc_number(r, &v[4], NAN), &line) ||
        line.count < 2)
        return false;
    Frame place = ifc_axes(r, v[1].record);
    Vec3 z = start_of(&line), reference = vec3(0, 0, 1);
    if (ifc_type(r, record) == T_FIXEDREFERENCESWEPTAREASOLID) {
        reference = ifc_direction(r, v[5].record, reference);
    } else if (ifc_type(r, v[5].record) == T_PLANE && ifc_arguments(r, v[5].record, w, 1)) {
        reference = ifc_axes(r, w[0].record).z;
    }
    Vec3 x = vec3_sub(reference, vec3_scale(z, vec3_dot(reference, z)));
    if (vec3_length(x) < 1e-9) x = vec3_cross(z, fabs(z.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0));
    x = vec3_normalize(x);
    Frame f = {x, vec3_cross(z, x), z, line.points[0]};
    for (int i = 0; i < profile.rings.count; i++)
        profile.rings.points[i] = frame_point(&f, profile.rings.points[i]);
    Shape swept = shape_empty(!profile.open);
    sweep_along(r, &profile, profile.rings.points, &line, &swept);
    shape_append_mapped(&r->scratch, out, &swept, &place);
    out->solid = swept.solid;
    if (out->solid && shape_volume(out) < 0) shape_flip(out);
    return true;
}

// ---- primitives

bool ifc_primitive(Reader *r, int record, Shape *out) {
    StepValue v[4];
    ifc_arguments(r, record, v, 4);
    Frame f = ifc_axes(r, v[0].record);
    double a = ifc_length(r, &v[1], 0), b = ifc_length(r, &v[2], 0), c = ifc_length(r, &v[3], 0);
    int type = ifc_type(r, record), size[1] = {4};
    bool outer[1] = {true};
    Profile p = {.size = size, .outer = outer, .ring_count = 1};
    out->solid = true;
    if (type == T_BLOCK || type == T_RECTANGULARPYRAMID) {
        Vec3 base[4] = {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0}}, top[4];
        for (int i = 0; i < 4; i++) {
            top[i] = type == T_BLOCK ? vec3_add(base[i], vec3(0, 0, c)) : vec3(a / 2, b / 2, c);
            top[i] = frame_point(&f, top[i]);
            base[i] = frame_point(&f, base[i]);
        }
        if (!(a > 0 && b > 0 && c > 0)) return false;
        p.rings.count = 4;
        loft(r, &p, base, top, out);
        return true;
    }
    if (type == T_RIGHTCIRCULARCONE || type == T_RIGHTCIRCULARCYLINDER) {
        Profile disk = {0};
        if (!(a > 0 && b > 0)) return false;
        circle_profile(r, b, 0, &disk);
        Vec3 *top = ARENA_ARRAY(&r->scratch, Vec3, disk.rings.count);
        for (int i = 0; i < disk.rings.count; i++) {
            Vec3 q = disk.rings.points[i];
            top[i] = frame_point(&f, type == T_RIGHTCIRCULARCONE ? vec3(0, 0, a) : vec3(q.x, q.y, a));
            disk.rings.points[i] = frame_point(&f, q);
        }
        loft(r, &disk, disk.rings.points, top, out);
        return true;
    }
    if (type == T_SPHERE && a > 0) {
        int chords = ifc_chords(r, a, 2 * M_PI), rows = (chords + 1) / 2;
        for (int i = 0; i < rows; i++) {
            for (int k = 0; k < chords; k++) {
                Vec3 q[4];
                for (int n = 0; n < 4; n++) {
                    double tall = M_PI * (i + (n > 1)) / rows,
                           round = 2 * M_PI * (k + (n == 1 || n == 2)) / chords;
                    q[n] = frame_point(
                        &f, vec3(a * sin(tall) * cos(round), a * sin(tall) * sin(round), -a * cos(tall)));
                }
                sweep_quad(r, q[0], q[1], q[2], q[3], out);
            }
        }
        return true;
    }
    return false;
}

void ifc_swept_surface(Reader *r, int record, Shape *out) {
    StepValue v[4];
    Profile profile = {0};
    ifc_arguments(r, record, v, 4);
    if (ifc_type(r, record) != T_SURFACEOFLINEAREXTRUSION || !ifc_profile(r, v[0].record, &profile)) return;
    Frame f = ifc_axes(r, v[1].record);
    Vec3 sweep =
        vec3_scale(frame_turn(&f, ifc_direction(r, v[2].record, vec3(0, 0, 1))), ifc_length(r, &v[3], 0));
    ifc_sweep_profile(r, &profile, &f, sweep, out);
}
