// enclose_openings.c - doors and windows in the building: their lines on the grid, and once the regions stand, which of them
// they join.
#include "engine/core/predicates.h"
#include "maps/enclose/enclose.h"

// An end of a door's line lies within this of its vertex on the grid, mm.
static const double LINE_REACH = 3;

static const Spot *spot_at(const Enclosure *e, int storey, int face) {
    return &e->pass.spots[(size_t)storey * (size_t)e->pass.plan.face_count + (size_t)face];
}

// ---- appending

// Lists the faces of each opening.
static void list_faces(Enclosure *e) {
    int openings = e->sketch->opening_count, faces = e->pass.plan.face_count, storeys = e->b->storey_count;
    int *first = ARENA_ARRAY(e->scratch, int, openings + 1), *fill = ARENA_ARRAY(e->scratch, int, openings);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < storeys * SPOT_HOLES; i++) {
            for (int f = 0; f < faces; f++) {
                int hole = spot_at(e, i / SPOT_HOLES, f)->hole[i % SPOT_HOLES];
                if (hole < 0) continue;
                if (pass == 0)
                    first[hole + 1]++;
                else
                    e->hole_faces[first[hole] + fill[hole]++] = f;
            }
        }
        if (pass > 0) break;
        for (int i = 0; i < openings; i++) first[i + 1] += first[i];
        e->hole_faces = ARENA_ARRAY(e->scratch, int, first[openings]);
    }
    e->hole_first = first;
}

// The grid's vertex at an end of an opening's line; of two as near, that of the lower edge.
static Vec2 on_grid(const Enclosure *e, int hole, Vec2 end) {
    const Plan *p = &e->pass.plan;
    Vec2 best = vec2(nearbyint(end.x), nearbyint(end.y));
    double nearest = LINE_REACH;
    int edge = -1;
    for (int i = e->hole_first[hole]; i < e->hole_first[hole + 1]; i++) {
        const PlanFace *face = &p->faces[e->hole_faces[i]];
        for (int k = 0; k < face->half_count; k++) {
            int at = p->halves[face->first_half + k] >> 1;
            Vec2 v = p->vertices[p->edges[at].v[0]], w = p->vertices[p->edges[at].v[1]];
            double dv = vec2_length(vec2_sub(v, end)), dw = vec2_length(vec2_sub(w, end)), d = fmin(dv, dw);
            if (d > nearest || (d == nearest && at >= edge)) continue;
            nearest = d;
            edge = at;
            best = dv < dw ? v : w;
        }
    }
    return best;
}

void openings_append(Enclosure *e) {
    Building *b = e->b;
    list_faces(e);
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
                      .line = {enclose_metres(e, line[0]), enclose_metres(e, line[1])},
                      .sill = h->sill / ENCLOSE_MM,
                      .head = h->head / ENCLOSE_MM,
                      .open = fmin(fmax(s->open, 0), 1),
                      .region = {-1, -1},
                      .material = material};
        leaves_append(e, i);
    }
    leaves_assign(e);
}

// ---- the regions that an opening joins

typedef struct Flood {
    int *queue;      // [span_count]
    bool *mark;      // [span_count] met before
    double *length;  // [region_count] contact with the side asked for, mm^2
    int *regions;    // [region_count] those with any
    int region_count;
} Flood;

// Area of the contact of span s with a free span o beyond half-edge h, mm^2.
static double contact(const Enclosure *e, int h, const Span *s, const Span *o) {
    double height = fmin(s->z1, o->z1) - fmax(s->z0, o->z0);
    return o->kind != SPAN_SOLID && height > 0 ? height * half_length(&e->pass.plan, h) : 0;
}

static int span_of_hole(const Enclosure *e, int face, int hole) {
    for (int i = e->first_span[face]; i < e->first_span[face + 1]; i++) {
        if (e->spans[i].kind == SPAN_OPENING && e->spans[i].id / 2 == hole) return i;
    }
    return -1;
}

static bool is_space(const Span *s) { return s->kind == SPAN_ROOM || s->kind == SPAN_OUTDOORS; }

// The region with the longest contact; of two with the same, the lower.
static int best_region(const Flood *flood) {
    int best = -1;
    for (int i = 0; i < flood->region_count; i++) {
        int r = flood->regions[i];
        double more = best < 0 ? 1 : flood->length[r] - flood->length[best];
        if (more > 0 || (more == 0 && r < best)) best = r;
    }
    return best;
}

static void add_contact(Flood *flood, int region, double area) {
    if (flood->length[region] == 0) flood->regions[flood->region_count++] = region;
    flood->length[region] += area;
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
        for (int i = e->first_span[g]; i < e->first_span[g + 1]; i++) {
            const Span *o = &e->spans[i];
            double area = contact(e, h, &e->spans[span], o);
            if (area <= 0) continue;
            if (is_space(o) && o->region >= 0) add_contact(flood, o->region, area);
            if (o->kind != SPAN_OPENING || flood->mark[i]) continue;
            flood->mark[i] = true;
            flood->queue[tail++] = i;
        }
    }
    return tail;
}

static int face_of_span(const Enclosure *e, int span) {
    int low = 0, high = e->pass.plan.face_count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (e->first_span[middle] <= span)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

// The region that one side of an opening reaches, directly or through other openings. Leaves `flood` as it was.
static int region_beyond(const Enclosure *e, Flood *flood, const int *faces, int count, int hole, int side) {
    int tail = 0, head = 0;
    for (int i = 0; i < count; i++) flood->mark[span_of_hole(e, faces[i], hole)] = true;
    for (int i = 0; i < count; i++)
        tail = spread(e, flood, span_of_hole(e, faces[i], hole), faces[i], hole, side, tail);
    int best = best_region(flood);
    while (best < 0 && head < tail) {
        int span = flood->queue[head++];
        tail = spread(e, flood, span, face_of_span(e, span), -1, 0, tail);
        best = best_region(flood);
    }
    for (int i = 0; i < count; i++) flood->mark[span_of_hole(e, faces[i], hole)] = false;
    for (int i = 0; i < tail; i++) flood->mark[flood->queue[i]] = false;
    while (flood->region_count > 0) flood->length[flood->regions[--flood->region_count]] = 0;
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
    int storey = e->sketch->openings[hole].storey, count = 0;
    for (int i = e->hole_first[hole]; i < e->hole_first[hole + 1]; i++) {
        if (span_of_hole(e, e->hole_faces[i], hole) >= 0) faces[count++] = e->hole_faces[i];
    }
    Opening *o = &e->b->openings[e->holes[hole].opening];
    for (int side = 0; side < 2; side++) o->region[side] = region_beyond(e, flood, faces, count, hole, side);
    if (o->region[0] >= 0 && o->region[1] >= 0) return;
    o->reason = reason_for(e, o);
    Vec3 at = enclose_place(e, e->holes[hole].centre, storey);
    building_note(e->arena, e->b, NOTE_CHANGED, at, "%s at (%.2f, %.2f) leads nowhere: %s",
                  enclose_text(e->sketch->openings[hole].place), at.x, at.y, o->reason);
}

void openings_join(Enclosure *e) {
    Flood flood = {.queue = ARENA_ARRAY(e->scratch, int, e->span_count),
                   .mark = ARENA_ARRAY(e->scratch, bool, e->span_count),
                   .length = ARENA_ARRAY(e->scratch, double, e->b->region_count),
                   .regions = ARENA_ARRAY(e->scratch, int, e->b->region_count)};
    int *faces = ARENA_ARRAY(e->scratch, int, e->pass.plan.face_count), *colours = spandrel_colours(e);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (!e->holes[i].used) continue;
        join_opening(e, &flood, i, faces);
        leaves_draw(e, i);
        spandrels_add(e, i, colours[e->holes[i].opening]);
    }
}
