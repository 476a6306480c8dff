// enclose_columns.c - the column of solid and free spans over every face of the plan, from the soil to the sky.
//
// A column starts as soil and sky; roofs, terraces, slabs, rooms, holes in floors, walls and openings are
// painted over one another in that order, so that each wins over the ones before.
#include "maps/enclose/enclose.h"

// The thickness of roofs over rooms without a storey above, mm.
static const double ROOF = 150;
// Air lower than this under something solid becomes solid, mm: nobody sees under a floor.
static const double LOWEST_AIR = 600;
// Air lower than this between the rooms of two storeys is a badly measured slab, mm.
static const double THICKEST_SLAB = 1500;
// Rooms with less height than this left become solid, mm.
static const double LOWEST_ROOM = 50;
// A wall this much taller than the floor above pokes out of it, mm; less is drawing noise.
static const double TALL = 300;

typedef struct Painter {
    Span *spans;
    int count;
} Painter;

static void put_span(Span *out, int *count, Span s) {
    if (s.z0 >= s.z1) return;
    if (*count > 0 && out[*count - 1].kind == s.kind && out[*count - 1].id == s.id) {
        out[*count - 1].z1 = s.z1;
        return;
    }
    out[(*count)++] = s;
}

static Span span(int kind, int id, int storey, double z0, double z1) {
    return (Span){kind, id, storey, z0, z1, -1};
}

// Paints a span over the column. No two neighbouring spans are alike, before and after.
static void paint(Painter *p, Span s) {
    double bottom = p->spans[0].z0, top = p->spans[p->count - 1].z1;
    s.z0 = fmax(s.z0, bottom);
    s.z1 = fmin(s.z1, top);
    if (s.z0 >= s.z1) return;
    int first = span_above(p->spans, p->count, s.z0), last = first, count = 0;
    while (last + 1 < p->count && p->spans[last + 1].z0 < s.z1) last++;
    Span below = p->spans[first], above = p->spans[last], made[5];
    below.z1 = fmin(below.z1, s.z0);
    above.z0 = fmax(above.z0, s.z1);
    if (first > 0) put_span(made, &count, p->spans[--first]);
    put_span(made, &count, below);
    put_span(made, &count, s);
    put_span(made, &count, above);
    if (last + 1 < p->count) put_span(made, &count, p->spans[++last]);
    int rest = p->count - last - 1;
    if (first + count != last + 1)
        memmove(p->spans + first + count, p->spans + last + 1, (size_t)rest * sizeof *p->spans);
    memcpy(p->spans + first, made, (size_t)count * sizeof *made);
    p->count = first + count + rest;
}

// ---- heights of rooms, roofs and walls

static void room_heights(const Enclosure *e, int storey, int indoor, double *z0, double *z1) {
    *z0 = e->floor[storey];
    *z1 = e->ceiling[storey];
    if (indoor < 0 || indoor >= e->sketch->room_count) return;
    const SketchRoom *r = &e->sketch->rooms[indoor];
    if (!isnan(r->z0)) *z0 = nearbyint(r->z0 * ENCLOSE_MM);
    if (!isnan(r->z1)) *z1 = nearbyint(r->z1 * ENCLOSE_MM);
}

static double slab_of(const Enclosure *e, int storey) { return e->floor[storey] - e->base[storey]; }

// The top of a room's roof: it reaches up to the next storey's floor where the room's ceiling is the storey's ceiling.
static double roof_top(const Enclosure *e, int storey, double ceiling) {
    return ceiling == e->ceiling[storey] ? fmax(e->cover[storey], ceiling + 1) : ceiling + ROOF;
}

// A wall closes the slabs under and over the rooms on either side of it.
static void wall_heights(const Enclosure *e, int storey, int face, double *z0, double *z1) {
    const Plan *p = &e->pass.plan;
    const Spot *spot = spot_at(e, storey, face);
    *z0 = e->base[storey];
    *z1 = e->cover[storey];
    double roof = *z1;
    if (spot->wall >= 0) {
        double top = nearbyint(e->sketch->walls[spot->wall].z1 * ENCLOSE_MM);
        if (top > *z1 + TALL) *z1 = top;
    }
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int g = half_right(p, p->halves[p->faces[face].first_half + k]);
        int indoor = g < 0 ? -1 : spot_at(e, storey, g)->indoor;
        if (indoor < 0 || indoor >= e->sketch->room_count) continue;
        double low, high;
        room_heights(e, storey, indoor, &low, &high);
        *z0 = fmin(*z0, low - slab_of(e, storey));
        if (high > e->ceiling[storey]) roof = fmax(roof, high + ROOF);
    }
    // Beside a room that is higher than its storey it ends under the rooms of the storeys above it.
    for (int k = 0; roof > *z1 && k < e->b->storey_count; k++) {
        const Spot *above = spot_at(e, k, face);
        if (e->floor[k] < e->cover[storey] || above->indoor < 0 || !spot_is_open(above)) continue;
        double low, high;
        room_heights(e, k, above->indoor, &low, &high);
        roof = fmin(roof, low);
    }
    *z1 = fmax(*z1, roof);
}

// ---- the layers

static void paint_roofs_and_terraces(const Enclosure *e, int face, Painter *p) {
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        double z0, z1;
        room_heights(e, s, spot->indoor, &z0, &z1);
        if (spot->indoor >= 0) paint(p, span(SPAN_SOLID, 0, s, z1, roof_top(e, s, z1)));
    }
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        if (spot->terrace < 0) continue;
        double z0, z1;
        room_heights(e, s, spot->terrace, &z0, &z1);
        paint(p, span(SPAN_SOLID, 0, s, z0 - slab_of(e, s), z0));
        paint(p, span(SPAN_OUTDOORS, e->b->material_count + spot->terrace, s, z0, e->top));
    }
}

static void paint_rooms(const Enclosure *e, int face, Painter *p) {
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        double z0, z1;
        room_heights(e, s, spot->indoor, &z0, &z1);
        if (spot->indoor >= 0) paint(p, span(SPAN_SOLID, 0, s, z0 - slab_of(e, s), z0));
    }
    // Where storeys overlap the first wins, so it is painted last.
    for (int s = e->b->storey_count - 1; s >= 0; s--) {
        const Spot *spot = spot_at(e, s, face);
        double z0, z1;
        room_heights(e, s, spot->indoor, &z0, &z1);
        if (spot->indoor >= 0) paint(p, span(SPAN_ROOM, spot->indoor, s, z0, z1));
    }
}

// Paints holes in floors: each reaches down from its floor to the free space below.
static void paint_cutouts(const Enclosure *e, int face, Painter *p) {
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        if (spot->cutout < 0) continue;
        double z0, floor;
        room_heights(e, s, spot->indoor >= 0 ? spot->indoor : spot->terrace, &floor, &z0);
        for (int i = 1; i < p->count; i++) {
            if (p->spans[i].z0 != floor || p->spans[i].kind == SPAN_SOLID ||
                p->spans[i - 1].kind != SPAN_SOLID)
                continue;
            double below = p->spans[i - 1].z0;
            // A slab as thick as its storey says is not measured badly: it lies above a ceiling that hangs low.
            if (i >= 2 && floor - below <= fmax(THICKEST_SLAB, slab_of(e, s)))
                paint(p, span(SPAN_SHAFT, spot->cutout, s, below, floor));
            break;
        }
    }
}

static void paint_walls(const Enclosure *e, int face, Painter *p) {
    const Plan *plan = &e->pass.plan;
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        if (spot->wall == NO_WALL && spot->hole[0] < 0) continue;
        double z0, z1;
        wall_heights(e, s, face, &z0, &z1);
        paint(p, span(SPAN_SOLID, 0, s, z0, z1));
    }
    for (int s = 0; s < e->b->storey_count; s++) {
        const Spot *spot = spot_at(e, s, face);
        for (int k = 0; k < SPOT_HOLES && spot->hole[k] >= 0; k++) {
            const Hole *h = &e->holes[spot->hole[k]];
            bool door = e->sketch->openings[spot->hole[k]].kind == OPENING_DOOR;
            int side = door && orient2d(h->line[0], h->line[1], plan->faces[face].inner) < 0;
            paint(p, span(SPAN_OPENING, 2 * spot->hole[k] + side, s, h->sill, h->head));
        }
    }
}

// Makes thin air under floors solid, and rooms with too little height left.
static void close_thin(const Enclosure *e, Painter *p) {
    for (int i = 1; i + 1 < p->count; i++) {
        const Span s = p->spans[i];
        double height = s.z1 - s.z0;
        bool between = i >= 2 && p->spans[i - 1].kind == SPAN_SOLID && p->spans[i - 2].kind == SPAN_ROOM;
        bool air = s.kind == SPAN_OUTDOORS && s.z1 < e->top && p->spans[i + 1].kind == SPAN_SOLID &&
                   height < (between ? THICKEST_SLAB : LOWEST_AIR);
        bool low = s.kind == SPAN_ROOM && height < LOWEST_ROOM;
        if (!air && !low) continue;
        paint(p, span(SPAN_SOLID, 0, s.storey, s.z0, s.z1));
        i = 0;
    }
}

void columns_build(Enclosure *e) {
    const Plan *plan = &e->pass.plan;
    // Each layer adds at most two spans; a storey has at most eight layers.
    int most = 20 * e->b->storey_count + 16;
    Painter p = {ARENA_ARRAY(e->scratch, Span, most), 0};
    e->first_span = ARENA_ARRAY(e->scratch, int, plan->face_count + 1);
    double ground = nearbyint(e->sketch->ground * ENCLOSE_MM);
    for (int f = 0; f < plan->face_count; f++) {
        p.count = 0;
        put_span(p.spans, &p.count, span(SPAN_SOLID, 0, -1, e->bottom, ground));
        put_span(p.spans, &p.count, span(SPAN_OUTDOORS, e->sketch->ground_material, -1, ground, e->top));
        paint_roofs_and_terraces(e, f, &p);
        paint_rooms(e, f, &p);
        paint_cutouts(e, f, &p);
        paint_walls(e, f, &p);
        close_thin(e, &p);
        for (int i = 0; i < p.count; i++) {
            // The free space on a roof or a wall top does not stand on the ground.
            if (p.spans[i].kind == SPAN_OUTDOORS && i > 0 && p.spans[i].z0 != ground &&
                p.spans[i].id == e->sketch->ground_material) {
                p.spans[i].id = e->sketch->outer_material;
            }
            *ARENA_PUSH(e->scratch, e->spans, e->span_count, e->span_capacity) = p.spans[i];
        }
        e->first_span[f + 1] = e->span_count;
    }
}

static bool is_free(const Span *s) { return s->kind != SPAN_SOLID; }

// Whether a free indoor span of `face` touches an outdoor span of the neighbouring face `other`.
static bool columns_open(const Enclosure *e, int face, int other) {
    for (int i = e->first_span[face]; i < e->first_span[face + 1]; i++) {
        const Span *s = &e->spans[i];
        if (!is_free(s) || s->kind == SPAN_OUTDOORS) continue;
        for (int k = e->first_span[other]; k < e->first_span[other + 1]; k++) {
            const Span *t = &e->spans[k];
            if (t->kind == SPAN_OUTDOORS && s->z0 < t->z1 && t->z0 < s->z1) return true;
        }
    }
    return false;
}

static bool outdoors_is_seen(const Enclosure *e) {
    const Plan *plan = &e->pass.plan;
    bool indoors = false;
    for (int f = 0; f < plan->face_count; f++) {
        const Span *s = e->spans + e->first_span[f];
        for (int i = 0; i < e->first_span[f + 1] - e->first_span[f]; i++) {
            bool terrace = s[i].kind == SPAN_OUTDOORS && s[i].id >= e->b->material_count;
            indoors = indoors || (is_free(&s[i]) && s[i].kind != SPAN_OUTDOORS);
            if (terrace) return true;  // drawn to be seen
            if (i == 0 || !is_free(&s[i - 1]) || !is_free(&s[i])) continue;
            if ((s[i - 1].kind == SPAN_OUTDOORS) != (s[i].kind == SPAN_OUTDOORS)) return true;
        }
    }
    for (int i = 0; i < plan->edge_count; i++) {
        int f = plan->edges[i].face[0], g = plan->edges[i].face[1];
        if (f >= 0 && g >= 0 && (columns_open(e, f, g) || columns_open(e, g, f))) return true;
    }
    return !indoors;
}

// Makes the outdoors solid where nothing opens to it: then it is never seen.
void columns_drop_unseen_outdoors(Enclosure *e) {
    if (outdoors_is_seen(e)) return;
    int kept = 0, first = 0;
    for (int f = 0; f < e->pass.plan.face_count; f++) {
        int end = e->first_span[f + 1], count = 0;
        for (int i = first; i < end; i++) {
            const Span s = e->spans[i];
            const Span next = s.kind == SPAN_OUTDOORS ? span(SPAN_SOLID, 0, -1, s.z0, s.z1) : s;
            put_span(e->spans + kept, &count, next);
        }
        kept += count;
        first = end;
        e->first_span[f + 1] = kept;
    }
    e->span_count = kept;
}
