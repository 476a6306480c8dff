// profile.c - profiles as rings of points in their plane (ISO 16739, IfcProfileResource). Shapes of steel are polygons whose corners have
// a radius each: fillets inside, edge radii outside.
#include "engine/core/polygon.h"
#include "maps/ifc/ifc_file.h"

// A corner of a polygon that is rounded by a radius.
typedef struct Corner {
    double x, y, radius;
} Corner;

static void begin_ring(Reader *r, Profile *p, bool outer) {
    int again = p->ring_count;
    *ARENA_PUSH(&r->scratch, p->outer, again, p->outer_room) = outer;
    *ARENA_PUSH(&r->scratch, p->size, p->ring_count, p->size_room) = 0;
}

// Appends a curve as a ring, turned as rings of its kind are. Rings without area are left out.
static void add_ring(Reader *r, Profile *p, const Curve *curve, bool outer) {
    double twice = 0;
    int count = curve->count;
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = vec3_sub(curve->points[i], curve->points[0]),
             b = vec3_sub(curve->points[i + 1], curve->points[0]);
        twice += a.x * b.y - a.y * b.x;
    }
    if (count < 3 || fabs(twice) < SHAPE_SMALLEST_AREA) return;
    begin_ring(r, p, outer);
    bool turn = (twice > 0) != outer;
    for (int i = 0; i < count; i++) {
        Vec3 q = curve->points[turn ? count - 1 - i : i];
        q.z = 0;
        *ARENA_PUSH(&r->scratch, p->rings.points, p->rings.count, p->rings.room) = q;
        p->size[p->ring_count - 1]++;
    }
}

static void push_corner(Reader *r, const Corner *c, int count, int at, Curve *out) {
    Vec3 p = vec3(c[at].x, c[at].y, 0);
    if (!(c[at].radius > 0)) {
        ifc_curve_push(r, out, p);
        return;
    }
    const Corner *before = &c[(at + count - 1) % count], *after = &c[(at + 1) % count];
    Vec3 u = vec3_sub(vec3(before->x, before->y, 0), p), v = vec3_sub(vec3(after->x, after->y, 0), p);
    double lu = vec3_length(u), lv = vec3_length(v);
    u = vec3_scale(u, 1 / lu);
    v = vec3_scale(v, 1 / lv);
    double half = acos(fmax(-1, fmin(1, vec3_dot(u, v)))) / 2, back = c[at].radius / tan(half);
    if (!(back < lu && back < lv)) {
        ifc_curve_push(r, out, p);
        return;
    }
    // The arc touches both edges `back` from the corner.
    Vec3 middle = vec3_normalize(vec3_add(u, v)),
         centre = vec3_add(p, vec3_scale(middle, c[at].radius / sin(half)));
    Vec3 from = vec3_sub(vec3_add(p, vec3_scale(u, back)), centre),
         to = vec3_sub(vec3_add(p, vec3_scale(v, back)), centre);
    double a = atan2(from.y, from.x), angle = remainder(atan2(to.y, to.x) - a, 2 * M_PI);
    int chords = ifc_chords(r, c[at].radius, angle);
    for (int i = 0; i <= chords; i++) {
        double t = a + angle * i / chords;
        ifc_curve_push(r, out, vec3_add(centre, vec3(c[at].radius * cos(t), c[at].radius * sin(t), 0)));
    }
}

static double loop_area(const Curve *c) {
    double twice = 0;
    for (int i = 0; i < c->count; i++) {
        Vec3 a = c->points[i], b = c->points[(i + 1) % c->count];
        twice +=
            (a.x - c->points[0].x) * (b.y - c->points[0].y) - (a.y - c->points[0].y) * (b.x - c->points[0].x);
    }
    return twice / 2;
}

// Does one loop lie within another? The middle of an edge tells: loops have no edge in common.
static bool lies_within(Reader *r, const Curve *inner, const Curve *outer) {
    Vec2 *ring = ARENA_ARRAY(&r->scratch, Vec2, outer->count);
    for (int i = 0; i < outer->count; i++) ring[i] = vec2(outer->points[i].x, outer->points[i].y);
    Vec3 middle = vec3_lerp(inner->points[0], inner->points[1], 0.5);
    return ring_contains(ring, outer->count, vec2(middle.x, middle.y));
}

// The loop of the largest area; -1: none.
static int largest_loop(const Curve *loops, int count) {
    int best = -1;
    for (int i = 0; i < count; i++)
        if (best < 0 || fabs(loop_area(&loops[i])) > fabs(loop_area(&loops[best]))) best = i;
    return best;
}

// The outline of an area. One that runs along itself is several areas where it may be, with the holes that turn the other way.
static void add_outline(Reader *r, Profile *p, const Curve *curve, bool several) {
    Curve *loops;
    int count = ifc_loops(r, curve, &loops), best = largest_loop(loops, count);
    if (best < 0) {
        add_ring(r, p, curve, true);
        return;
    }
    bool turn = loop_area(&loops[best]) < 0;
    for (int i = 0; i < count; i++) {
        if ((loop_area(&loops[i]) < 0) != turn || (!several && i != best)) continue;
        add_ring(r, p, &loops[i], true);
        for (int k = 0; k < count; k++)
            if ((loop_area(&loops[k]) < 0) != turn && lies_within(r, &loops[k], &loops[i]))
                add_ring(r, p, &loops[k], false);
    }
}

static void add_hole(Reader *r, Profile *p, const Curve *curve) {
    Curve *loops;
    int count = ifc_loops(r, curve, &loops), best = largest_loop(loops, count);
    add_ring(r, p, best < 0 ? curve : &loops[best], false);
}

static void place_ring(const Frame *f, Curve *curve) {
    for (int i = 0; i < curve->count; i++) curve->points[i] = frame_point(f, curve->points[i]);
}

static void add_polygon(Reader *r, Profile *p, const Frame *f, const Corner *corners, int count, bool outer) {
    Curve curve = {0};
    for (int i = 0; i < count; i++) push_corner(r, corners, count, i, &curve);
    if (curve.count > 1 &&
        vec3_length(vec3_sub(curve.points[0], curve.points[curve.count - 1])) < IFC_SAME_POINT)
        curve.count--;
    place_ring(f, &curve);
    add_ring(r, p, &curve, outer);
}

static void add_ellipse(Reader *r, Profile *p, const Frame *f, double a, double b, bool outer) {
    Curve curve = {0};
    if (!(a > 0 && b > 0)) return;
    int chords = ifc_chords(r, fmax(a, b), 2 * M_PI);
    for (int i = 0; i < chords; i++) {
        double t = 2 * M_PI * i / chords;
        ifc_curve_push(r, &curve, vec3(a * cos(t), b * sin(t), 0));
    }
    place_ring(f, &curve);
    add_ring(r, p, &curve, outer);
}

static void add_rectangle(Reader *r, Profile *p, const Frame *f, double x, double y, double radius,
                          bool outer) {
    double a = x / 2, b = y / 2;
    Corner c[4] = {{-a, -b, radius}, {a, -b, radius}, {a, b, radius}, {-a, b, radius}};
    add_polygon(r, p, f, c, 4, outer);
}

// Shapes of steel: `d` are the arguments behind the position, as lengths (0 where they are not told); slopes are angles in `v`.
static bool steel(Reader *r, int type, const Frame *f, const double *d, Profile *out) {
    switch (type) {
    case T_ISHAPEPROFILEDEF: {
        double x = d[0] / 2, y = d[1] / 2, w = d[2] / 2, t = d[3], fillet = d[4], edge = d[5];
        Corner c[12] = {{-x, -y, 0},        {x, -y, 0},          {x, t - y, edge},    {w, t - y, fillet},
                        {w, y - t, fillet}, {x, y - t, edge},    {x, y, 0},           {-x, y, 0},
                        {-x, y - t, edge},  {-w, y - t, fillet}, {-w, t - y, fillet}, {-x, t - y, edge}};
        add_polygon(r, out, f, c, 12, true);
        return true;
    }
    case T_ASYMMETRICISHAPEPROFILEDEF: {
        double x = d[0] / 2, y = d[1] / 2, w = d[2] / 2, t = d[3], fillet = d[4], x2 = d[5] / 2,
               t2 = d[6] > 0 ? d[6] : t, fillet2 = d[7];
        Corner c[12] = {
            {-x, -y, 0},         {x, -y, 0},    {x, t - y, 0}, {w, t - y, fillet}, {w, y - t2, fillet2},
            {x2, y - t2, 0},     {x2, y, 0},    {-x2, y, 0},   {-x2, y - t2, 0},   {-w, y - t2, fillet2},
            {-w, t - y, fillet}, {-x, t - y, 0}};
        add_polygon(r, out, f, c, 12, true);
        return true;
    }
    case T_LSHAPEPROFILEDEF: {
        double y = d[0] / 2, x = (d[1] > 0 ? d[1] : d[0]) / 2, t = d[2], fillet = d[3], edge = d[4];
        Corner c[6] = {{-x, -y, 0},      {x, -y, 0}, {x, t - y, edge}, {t - x, t - y, fillet},
                       {t - x, y, edge}, {-x, y, 0}};
        add_polygon(r, out, f, c, 6, true);
        return true;
    }
    case T_TSHAPEPROFILEDEF: {
        double y = d[0] / 2, x = d[1] / 2, w = d[2] / 2, t = d[3], fillet = d[4], edge = d[5], foot = d[6];
        Corner c[8] = {{-w, -y, foot}, {w, -y, foot}, {w, y - t, fillet}, {x, y - t, edge},
                       {x, y, 0},      {-x, y, 0},    {-x, y - t, edge},  {-w, y - t, fillet}};
        add_polygon(r, out, f, c, 8, true);
        return true;
    }
    case T_USHAPEPROFILEDEF: {
        double y = d[0] / 2, x = d[1] / 2, w = d[2], t = d[3], fillet = d[4], edge = d[5];
        Corner c[8] = {
            {-x, -y, 0},      {x, -y, 0}, {x, t - y, edge}, {w - x, t - y, fillet}, {w - x, y - t, fillet},
            {x, y - t, edge}, {x, y, 0},  {-x, y, 0}};
        add_polygon(r, out, f, c, 8, true);
        return true;
    }
    case T_CSHAPEPROFILEDEF: {
        double y = d[0] / 2, x = d[1] / 2, t = d[2], g = d[3], in = d[4], o = in > 0 ? in + t : 0;
        Corner c[12] = {{-x, -y, o},        {x, -y, o},         {x, g - y, 0},      {x - t, g - y, 0},
                        {x - t, t - y, in}, {t - x, t - y, in}, {t - x, y - t, in}, {x - t, y - t, in},
                        {x - t, y - g, 0},  {x, y - g, 0},      {x, y, o},          {-x, y, o}};
        add_polygon(r, out, f, c, 12, true);
        return true;
    }
    case T_ZSHAPEPROFILEDEF: {
        double y = d[0] / 2, w = d[2] / 2, x = d[1], t = d[3], fillet = d[4], edge = d[5];
        Corner c[8] = {{-w, -y, 0}, {x - w, -y, 0}, {x - w, t - y, edge}, {w, t - y, fillet},
                       {w, y, 0},   {w - x, y, 0},  {w - x, y - t, edge}, {-w, y - t, fillet}};
        add_polygon(r, out, f, c, 8, true);
        return true;
    }
    case T_TRAPEZIUMPROFILEDEF: {
        double x = d[0] / 2, y = d[2] / 2, left = d[3] - x;
        Corner c[4] = {{-x, -y, 0}, {x, -y, 0}, {left + d[1], y, 0}, {left, y, 0}};
        add_polygon(r, out, f, c, 4, true);
        return true;
    }
    default:
        return false;
    }
}

// Profiles with a position and dimensions.
static bool parametric(Reader *r, int record, Profile *out) {
    StepValue v[13];
    double d[10];
    ifc_arguments(r, record, v, 13);
    Frame f = ifc_axes(r, v[2].record);
    for (int i = 0; i < 10; i++) d[i] = ifc_length(r, &v[3 + i], 0);
    int type = ifc_type(r, record), before = out->ring_count;
    switch (type) {
    case T_RECTANGLEPROFILEDEF:
        add_rectangle(r, out, &f, d[0], d[1], 0, true);
        break;
    case T_ROUNDEDRECTANGLEPROFILEDEF:
        add_rectangle(r, out, &f, d[0], d[1], d[2], true);
        break;
    case T_RECTANGLEHOLLOWPROFILEDEF:
        add_rectangle(r, out, &f, d[0], d[1], d[4], true);
        if (out->ring_count > before)
            add_rectangle(r, out, &f, d[0] - 2 * d[2], d[1] - 2 * d[2], d[3], false);
        break;
    case T_CIRCLEPROFILEDEF:
        add_ellipse(r, out, &f, d[0], d[0], true);
        break;
    case T_ELLIPSEPROFILEDEF:
        add_ellipse(r, out, &f, d[0], d[1], true);
        break;
    case T_CIRCLEHOLLOWPROFILEDEF:
        add_ellipse(r, out, &f, d[0], d[0], true);
        if (out->ring_count > before) add_ellipse(r, out, &f, d[0] - d[1], d[0] - d[1], false);
        break;
    default:
        if (!steel(r, type, &f, d, out)) {
            ifc_note(r, record, "is no profile that is read");
            return false;
        }
    }
    if (out->ring_count > before) return true;
    ifc_note(r, record, "has no area");
    return false;
}

// A strip of a thickness along a curve.
static bool centre_line(Reader *r, int record, Profile *out) {
    StepValue v[4];
    Curve line = {0}, ring = {0};
    ifc_arguments(r, record, v, 4);
    double half = ifc_length(r, &v[3], 0) / 2;
    if (!ifc_curve(r, v[2].record, &line) || line.count < 2 || !(half > 0)) return false;
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < line.count; k++) {
            int i = side ? line.count - 1 - k : k;
            Vec3 a = line.points[i > 0 ? i - 1 : 0], b = line.points[i],
                 c = line.points[i + 1 < line.count ? i + 1 : i];
            Vec3 u = vec3_normalize(vec3_sub(b, a)), w = vec3_normalize(vec3_sub(c, b));
            if (vec3_length(u) == 0) u = w;
            if (vec3_length(w) == 0) w = u;
            Vec3 n = vec3_normalize(vec3_add(vec3(-u.y, u.x, 0), vec3(-w.y, w.x, 0)));
            double slant = fmax(0.2, vec3_dot(n, vec3(-u.y, u.x, 0)));
            ifc_curve_push(r, &ring, vec3_add(b, vec3_scale(n, (side ? half : -half) / slant)));
        }
    }
    add_ring(r, out, &ring, true);
    return out->ring_count > 0;
}

static bool any_profile(Reader *r, int record, Profile *out) {
    StepValue v[5];
    int type = ifc_type(r, record), before = out->ring_count;
    if (type < 0) {
        ifc_note(r, -1, "a profile is missing");
        return false;
    }
    switch (type) {
    case T_ARBITRARYCLOSEDPROFILEDEF:
    case T_ARBITRARYPROFILEDEFWITHVOIDS: {
        Curve curve = {0};
        ifc_arguments(r, record, v, 4);
        if (!ifc_curve(r, v[2].record, &curve)) return false;
        add_outline(r, out, &curve, type == T_ARBITRARYCLOSEDPROFILEDEF);
        if (out->ring_count == before) {
            ifc_note(r, record, "has no area");
            return false;
        }
        if (type == T_ARBITRARYCLOSEDPROFILEDEF) return true;
        StepCursor c = ifc_list(r, &v[3]);
        for (StepValue h = step_next(&c); h.kind != STEP_END; h = step_next(&c)) {
            Curve hole = {0};
            if (ifc_curve(r, h.record, &hole)) add_hole(r, out, &hole);
        }
        return true;
    }
    case T_ARBITRARYOPENPROFILEDEF: {
        Curve curve = {0};
        ifc_arguments(r, record, v, 3);
        if (!ifc_curve(r, v[2].record, &curve)) return false;
        begin_ring(r, out, true);
        for (int i = 0; i < curve.count + curve.closed; i++)
            *ARENA_PUSH(&r->scratch, out->rings.points, out->rings.count, out->rings.room) =
                curve.points[i % curve.count];
        out->size[out->ring_count - 1] = curve.count + curve.closed;
        out->open = true;
        return true;
    }
    case T_CENTERLINEPROFILEDEF:
        return centre_line(r, record, out);
    case T_DERIVEDPROFILEDEF:
    case T_MIRROREDPROFILEDEF: {
        ifc_arguments(r, record, v, 4);
        Frame f = ifc_operator(r, v[3].record);
        if (type == T_MIRROREDPROFILEDEF) f.x = vec3(-1, 0, 0);
        Profile parent = {0};
        if (!ifc_profile(r, v[2].record, &parent)) return false;
        for (int i = 0, first = 0; i < parent.ring_count; first += parent.size[i], i++) {
            Curve ring = {.points = parent.rings.points + first, .count = parent.size[i]};
            place_ring(&f, &ring);
            add_ring(r, out, &ring, parent.outer[i]);
        }
        return out->ring_count > before;
    }
    case T_COMPOSITEPROFILEDEF: {
        ifc_arguments(r, record, v, 3);
        StepCursor c = ifc_list(r, &v[2]);
        bool good = false;
        for (StepValue p = step_next(&c); p.kind != STEP_END; p = step_next(&c))
            good |= ifc_profile(r, p.record, out);
        return good;
    }
    default:
        return parametric(r, record, out);
    }
}

bool ifc_profile(Reader *r, int record, Profile *out) {
    if (!ifc_enter(r, record)) return false;
    bool good = any_profile(r, record, out);
    ifc_leave(r);
    return good;
}
