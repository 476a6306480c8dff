// enclose_openings.c - doors and windows once the regions stand: what they join, the spandrels of arched ones, and
// where a walk begins.
#include <stdlib.h>

#include "engine/core/predicates.h"
#include "maps/enclose.h"

// Spandrels stand this far inside the wall's face, metres, so that they do not lie in the wall's plane.
static const double SPANDREL_INSET = 0.005;
// An end of a door's line lies within this of its vertex on the grid, mm.
static const double LINE_REACH = 3;
// Eye height of a walk, metres; clear of the ceiling by EYE_CLEAR.
static const double EYE = 1.6, EYE_CLEAR = 0.1;

static Vec2 to_metres(const Enclosure *e, Vec2 p) {
    return vec2((e->origin.x * ENCLOSE_MM + p.x) / ENCLOSE_MM, (e->origin.y * ENCLOSE_MM + p.y) / ENCLOSE_MM);
}

static const Spot *spot_at(const Enclosure *e, int storey, int face) {
    return &e->pass.spots[(size_t)storey * (size_t)e->pass.plan.face_count + (size_t)face];
}

static bool has_hole(const Spot *s, int hole) {
    for (int k = 0; k < SPOT_HOLES; k++) {
        if (s->hole[k] == hole) return true;
    }
    return false;
}

// ---- appending

// The grid's vertex at an end of an opening's line.
static Vec2 on_grid(const Enclosure *e, int hole, Vec2 end) {
    const Plan *p = &e->pass.plan;
    int storey = e->sketch->openings[hole].storey;
    Vec2 best = vec2(nearbyint(end.x), nearbyint(end.y));
    double nearest = LINE_REACH;
    for (int i = 0; i < p->edge_count; i++) {
        Vec2 v = p->vertices[p->edges[i].v[0]], w = p->vertices[p->edges[i].v[1]];
        double dv = vec2_length(vec2_sub(v, end)), dw = vec2_length(vec2_sub(w, end));
        if (fmin(dv, dw) >= nearest) continue;
        bool mine = false;
        for (int k = 0; k < 2; k++) {
            int f = p->edges[i].face[k];
            mine = mine || (f >= 0 && has_hole(spot_at(e, storey, f), hole));
        }
        if (!mine) continue;
        nearest = fmin(dv, dw);
        best = dv < dw ? v : w;
    }
    return best;
}

void openings_append(Enclosure *e) {
    Building *b = e->b;
    for (int i = 0; i < e->sketch->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used) continue;
        const SketchOpening *s = &e->sketch->openings[i];
        Vec2 line[2] = {on_grid(e, i, h->line[0]), on_grid(e, i, h->line[1])};
        if (vec2_equal(line[0], line[1])) line[1] = vec2(line[1].x + 1, line[1].y);
        h->opening = b->opening_count;
        int material =
            s->material >= 0 && s->material < b->material_count ? s->material : e->sketch->outer_material;
        *ARENA_PUSH(e->arena, b->openings, b->opening_count, b->opening_capacity) =
            (Opening){.kind = s->kind,
                      .name = arena_string(e->arena, s->name ? s->name : ""),
                      .storey = s->storey,
                      .glazed = s->glazed,
                      .line = {to_metres(e, line[0]), to_metres(e, line[1])},
                      .sill = h->sill / ENCLOSE_MM,
                      .head = h->head / ENCLOSE_MM,
                      .open = fmin(fmax(s->open, 0), 1),
                      .region = {-1, -1},
                      .material = material};
        leaves_append(e, i);
    }
    leaves_assign(e);
}

// ---- what an opening joins

typedef struct Flood {
    int *queue, *mark;  // [span_count]
    double *length;     // [region_count] contact with the side asked for, mm^2
} Flood;

// Area of the contact of span s with a free span o beyond half-edge h, mm^2.
static double contact(const Enclosure *e, int h, const Span *s, const Span *o) {
    double height = fmin(s->z1, o->z1) - fmax(s->z0, o->z0);
    return o->kind != SPAN_SOLID && height > 0 ? height * half_length(&e->pass.plan, h) : 0;
}

static int span_of_hole(const Enclosure *e, int face, int hole) {
    for (int i = e->columns[face].first_span; i < e->columns[face].first_span + e->columns[face].span_count;
         i++) {
        if (e->spans[i].kind == SPAN_OPENING && e->spans[i].id / 2 == hole) return i;
    }
    return -1;
}

static bool is_space(const Span *s) { return s->kind == SPAN_ROOM || s->kind == SPAN_OUTDOORS; }

static int best_region(const Enclosure *e, const Flood *flood) {
    int best = -1;
    for (int r = 0; r < e->b->region_count; r++) {
        if (flood->length[r] > 0 && (best < 0 || flood->length[r] > flood->length[best])) best = r;
    }
    return best;
}

// Whether the middle of half-edge h lies on the given side of the opening's line.
static bool on_side(const Enclosure *e, int hole, int side, int h) {
    const Plan *p = &e->pass.plan;
    Vec2 m = vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
    const Hole *at = &e->holes[hole];
    return (orient2d(at->line[0], at->line[1], m) > 0) == (side == 0);
}

// Adds up the contacts of a span; other openings' spans not met before go into the queue.
static int spread(const Enclosure *e, Flood *flood, int span, int face, int hole, int side, int tail) {
    const Plan *p = &e->pass.plan;
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int h = p->halves[p->faces[face].first_half + k], g = half_right(p, h);
        if (g < 0 || (hole >= 0 && !on_side(e, hole, side, h))) continue;
        for (int i = e->columns[g].first_span; i < e->columns[g].first_span + e->columns[g].span_count; i++) {
            const Span *o = &e->spans[i];
            double area = contact(e, h, &e->spans[span], o);
            if (area <= 0) continue;
            if (is_space(o) && o->region >= 0) flood->length[o->region] += area;
            if (o->kind != SPAN_OPENING || flood->mark[i]) continue;
            flood->mark[i] = 1;
            flood->queue[tail++] = i;
        }
    }
    return tail;
}

static int face_of_span(const Enclosure *e, int span) {
    int low = 0, high = e->pass.plan.face_count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (e->columns[middle].first_span <= span)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

// The region that one side of an opening reaches, directly or through other openings.
static int region_beyond(const Enclosure *e, Flood *flood, const int *faces, int count, int hole, int side) {
    memset(flood->mark, 0, sizeof(int) * (size_t)e->span_count);
    memset(flood->length, 0, sizeof(double) * (size_t)e->b->region_count);
    int tail = 0, head = 0;
    for (int i = 0; i < count; i++) flood->mark[span_of_hole(e, faces[i], hole)] = 1;
    for (int i = 0; i < count; i++)
        tail = spread(e, flood, span_of_hole(e, faces[i], hole), faces[i], hole, side, tail);
    int best = best_region(e, flood);
    while (best < 0 && head < tail) {
        int span = flood->queue[head++];
        tail = spread(e, flood, span, face_of_span(e, span), -1, 0, tail);
        best = best_region(e, flood);
    }
    return best;
}

static const char *reason_for(Enclosure *e, const Opening *o) {
    if (o->region[0] < 0 && o->region[1] < 0) return "both sides are blocked by walls";
    const Region *r = &e->b->regions[o->region[0] < 0 ? o->region[1] : o->region[0]];
    return arena_format(e->arena, "the side away from %s is blocked by a wall",
                        r->kind == REGION_OUTDOORS ? "the outdoors"
                        : *r->name                 ? r->name
                                                   : "the unnamed room");
}

static void join_opening(Enclosure *e, Flood *flood, int hole, int *faces) {
    const Plan *p = &e->pass.plan;
    int storey = e->sketch->openings[hole].storey, count = 0;
    for (int f = 0; f < p->face_count; f++) {
        if (has_hole(spot_at(e, storey, f), hole) && span_of_hole(e, f, hole) >= 0) faces[count++] = f;
    }
    Opening *o = &e->b->openings[e->holes[hole].opening];
    for (int side = 0; side < 2; side++) o->region[side] = region_beyond(e, flood, faces, count, hole, side);
    if (o->region[0] >= 0 && o->region[1] >= 0) return;
    o->reason = reason_for(e, o);
    Vec3 at = enclose_place(e, e->holes[hole].centre, storey);
    building_note(e->arena, e->b, NOTE_CHANGED, at, "%s at (%.2f, %.2f) leads nowhere: %s",
                  enclose_text(e->sketch->openings[hole].place), at.x, at.y, o->reason);
}

// ---- spandrels

typedef struct Frame {
    const Hole *hole;
    double width, height;  // mm
} Frame;

static Vec3 frame_point(const Enclosure *e, const Frame *f, double u, double w, double v) {
    const Hole *h = f->hole;
    Vec2 at = vec2_add(h->centre, vec2_add(vec2_scale(h->u, u - h->half), vec2_scale(h->n, v)));
    Vec2 m = to_metres(e, at);
    return vec3(m.x, m.y, (h->sill + w) / ENCLOSE_MM);
}

// What the cut-out leaves of one half of its rectangle, as polygons on both faces of the wall.
static void add_spandrel_half(Enclosure *e, const Frame *f, const GEOSGeometry *cutout, double u0, double u1,
                              const double *v, int material) {
    Vec2 corners[4] = {{u0, 0}, {u1, 0}, {u1, f->height}, {u0, f->height}};
    Shape box = shape_of_points(e->scratch, corners, 4);
    GEOSGeometry *half = shape_to_geos(e, &box),
                 *rest = half ? GEOSDifference_r(e->geos, half, cutout) : NULL;
    ShapeList pieces = {NULL, 0, 0};
    if (rest) shapes_from_geos(e, rest, 1, &pieces);
    for (int i = 0; i < pieces.count; i++) {
        const Shape *piece = &pieces.items[i];
        int n = piece->ring[1];
        Vec3 *corner = ARENA_ARRAY(e->scratch, Vec3, n);
        for (int side = 0; side < 2; side++) {
            for (int k = 0; k < n; k++) {
                Vec2 p = piece->points[side ? n - 1 - k : k];
                corner[k] = frame_point(e, f, p.x, p.y, v[side]);
            }
            building_add_polygon(e->arena, e->b, corner, n, material);
        }
    }
    if (half) GEOSGeom_destroy_r(e->geos, half);
    if (rest) GEOSGeom_destroy_r(e->geos, rest);
}

// The inner side of the cut-out, where it is not the rectangle's own side.
static void add_intrados(Enclosure *e, const Frame *f, const Shape *cutout, const double *v, int material) {
    for (int k = 0, n = cutout->ring[1]; k < n; k++) {
        Vec2 a = cutout->points[k], b = cutout->points[(k + 1) % n];
        bool side =
            (a.x == b.x && (a.x <= 0 || a.x >= f->width)) || (a.y == b.y && (a.y <= 0 || a.y >= f->height));
        if (side) continue;
        Vec3 quad[4] = {frame_point(e, f, a.x, a.y, v[0]), frame_point(e, f, b.x, b.y, v[0]),
                        frame_point(e, f, b.x, b.y, v[1]), frame_point(e, f, a.x, a.y, v[1])};
        building_add_polygon(e->arena, e->b, quad, 4, material);
    }
}

static void add_spandrels(Enclosure *e, int hole) {
    const SketchOpening *s = &e->sketch->openings[hole];
    const Hole *h = &e->holes[hole];
    if (s->cutout_count < 3) return;
    Frame f = {h, 2 * h->half, h->head - h->sill};
    Vec2 *points = ARENA_ARRAY(e->scratch, Vec2, s->cutout_count);
    for (int i = 0; i < s->cutout_count; i++) {
        Vec2 p = e->sketch->points[s->first_cutout + i];
        points[i] = vec2(fmin(1, fmax(0, p.x)) * f.width, fmin(1, fmax(0, p.y)) * f.height);
    }
    Shape cutout = shape_of_points(e->scratch, points, s->cutout_count);
    GEOSGeometry *g = shape_to_geos(e, &cutout);
    double middle = (cutout.min.x + cutout.max.x) / 2,
           inset = fmin(SPANDREL_INSET * ENCLOSE_MM, (h->v1 - h->v0) / 4);
    double v[2] = {h->v0 + inset, h->v1 - inset};
    // The two faces of the wall may have two colours; the frame takes the one beside the opening.
    int material = e->sketch->outer_material;
    for (int r = 0; r < e->b->region_count; r++) {
        const Region *region = &e->b->regions[r];
        if (region->kind != REGION_OPENING || region->opening != h->opening) continue;
        material = e->b->edge_material[e->b->rings[region->first_ring].first_point];
        break;
    }
    if (g) {
        building_add_object(e->arena, e->b, OBJECT_FRAME, s->name);
        add_spandrel_half(e, &f, g, 0, middle, v, material);
        add_spandrel_half(e, &f, g, middle, f.width, v, material);
        add_intrados(e, &f, &cutout, v, material);
        GEOSGeom_destroy_r(e->geos, g);
    } else {
        Vec3 at = enclose_place(e, h->centre, s->storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "%s at (%.2f, %.2f): its cut-out is no polygon and becomes a rectangle",
                      enclose_text(s->place), at.x, at.y);
    }
}

void openings_join(Enclosure *e) {
    Flood flood = {ARENA_ARRAY(e->scratch, int, e->span_count), ARENA_ARRAY(e->scratch, int, e->span_count),
                   ARENA_ARRAY(e->scratch, double, e->b->region_count)};
    int *faces = ARENA_ARRAY(e->scratch, int, e->pass.plan.face_count);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (!e->holes[i].used) continue;
        join_opening(e, &flood, i, faces);
        leaves_draw(e, i);
        add_spandrels(e, i);
    }
}

// ---- where a walk begins

static double region_area(const Building *b, const Region *r) {
    double sum = 0;
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &b->rings[r->first_ring + k];
        const Vec2 *p = &b->points[ring->first_point];
        for (int i = 1; i + 1 < ring->point_count; i++)
            sum += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
    }
    return sum;
}

// Distance to the outline, negative outside.
static double depth_in(const Building *b, const Region *r, Vec2 q) {
    double nearest = INFINITY;
    bool inside = false;
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &b->rings[r->first_ring + k];
        const Vec2 *p = &b->points[ring->first_point];
        for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++) {
            Vec2 d = vec2_sub(p[i], p[j]), aq = vec2_sub(q, p[j]);
            double t = fmin(1, fmax(0, vec2_dot(aq, d) / vec2_dot(d, d)));
            nearest = fmin(nearest, vec2_length(vec2_sub(aq, vec2_scale(d, t))));
            if ((p[i].y > q.y) != (p[j].y > q.y) &&
                q.x < p[i].x + (p[j].x - p[i].x) * (q.y - p[i].y) / (p[j].y - p[i].y))
                inside = !inside;
        }
    }
    return inside ? nearest : -nearest;
}

// How clear of furniture a person stands there, at most `limit`.
static double clear_of_objects(const Building *b, Vec2 q, double z0, double z1, double limit) {
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (o->proxy_z1 <= o->proxy_z0 || o->proxy_z0 >= z1 || o->proxy_z1 <= z0 || o->leaf >= 0) continue;
        double out =
            -INFINITY;  // distance to the farthest side plane: exact beside a side, small at a corner
        for (int k = 0; k < 4; k++) {
            Vec2 a = o->proxy[k], d = vec2_sub(o->proxy[(k + 1) % 4], a);
            double length = vec2_length(d);
            if (length > 0) out = fmax(out, vec2_cross(vec2_sub(q, a), d) / length);
        }
        limit = fmin(limit, out);
    }
    return limit;
}

static Vec2 best_stand(const Building *b, const Region *r) {
    enum { STEPS = 40 };
    const Ring *ring = &b->rings[r->first_ring];
    Vec2 low = b->points[ring->first_point], high = low;
    for (int i = 0; i < ring->point_count; i++) {
        Vec2 p = b->points[ring->first_point + i];
        low = vec2(fmin(low.x, p.x), fmin(low.y, p.y));
        high = vec2(fmax(high.x, p.x), fmax(high.y, p.y));
    }
    Vec2 best = low;
    double most = -INFINITY;
    for (int j = 0; j < STEPS; j++) {
        for (int i = 0; i < STEPS; i++) {
            Vec2 q = vec2(low.x + (high.x - low.x) * (i + 0.5) / STEPS,
                          low.y + (high.y - low.y) * (j + 0.5) / STEPS);
            double depth = depth_in(b, r, q);
            if (depth <= 0 || depth <= most) continue;
            depth = clear_of_objects(b, q, r->z0 + 0.3, r->z0 + 1.8, depth);  // what a person's body meets
            // Inside furniture is worse than beside it, outside the room worse than both.
            if (depth > most) {
                most = depth;
                best = q;
            }
        }
    }
    return best;
}

// The direction of the longest view.
static double longest_view(const Building *b, const Region *r, Vec2 from) {
    enum { WAYS = 32 };
    double best = 0, yaw = 0;
    for (int w = 0; w < WAYS; w++) {
        double angle = 2 * M_PI * w / WAYS, nearest = INFINITY;
        Vec2 d = vec2(cos(angle), sin(angle));
        for (int k = 0; k < r->ring_count; k++) {
            const Ring *ring = &b->rings[r->first_ring + k];
            const Vec2 *p = &b->points[ring->first_point];
            for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++) {
                Vec2 a = vec2_sub(p[j], from), c = vec2_sub(p[i], p[j]);
                double det = vec2_cross(d, c);
                if (det == 0) continue;
                double t = vec2_cross(a, c) / det, s = vec2_cross(a, d) / det;
                if (t > 0 && s >= 0 && s <= 1) nearest = fmin(nearest, t);
            }
        }
        if (!isfinite(nearest) || nearest <= best) continue;
        best = nearest;
        yaw = angle;
    }
    return yaw;
}

static bool at_entrance(const Building *b, int region) {
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind == OPENING_WINDOW || o->region[0] < 0 || o->region[1] < 0) continue;
        for (int s = 0; s < 2; s++) {
            if (o->region[s] == region && b->regions[o->region[!s]].kind == REGION_OUTDOORS) return true;
        }
    }
    return false;
}

// The largest room with a door to the outdoors, else the largest room, else the open air.
void enclose_choose_start(Enclosure *e) {
    Building *b = e->b;
    int best = -1;
    double most = -1;
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->kind != REGION_ROOM && r->kind != REGION_OUTDOORS) continue;
        double area = region_area(b, r);
        // Lexicographic: a room before the open air, high enough to stand in, at an entrance, large.
        double rank = (r->kind == REGION_ROOM ? 8 : 0) + (r->z1 - r->z0 > EYE + EYE_CLEAR ? 4 : 0) +
                      (at_entrance(b, i) ? 2 : 0);
        double score = rank + area / (1 + area);
        if (score <= most) continue;
        most = score;
        best = i;
    }
    if (best < 0) return;
    const Region *r = &b->regions[best];
    Vec2 at = best_stand(b, r);
    double z = r->z0 + EYE > r->z1 - EYE_CLEAR ? (r->z0 + r->z1) / 2 : r->z0 + EYE;
    b->start = vec3(at.x, at.y, z);
    b->start_yaw = longest_view(b, r, at);
}
