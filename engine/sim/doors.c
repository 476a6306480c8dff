// doors.c - doors that move.
//
// A door moves in steps so small that no point of its leaves goes farther than the distance that the leaves keep from bodies and
// from other leaves. A step that would bring a leaf nearer than this distance is not taken, unless it leads away. For this reason
// two leaves never cross, and no leaf ever touches a body. Leaves pass through walls and furniture, since in many drawn homes a
// leaf could not open otherwise: no doorway is lost this way.
#include "engine/sim/doors.h"

#include <string.h>

#include "engine/core/box_tree.h"

#include "engine/core/error.h"
#include "engine/sim/door_part.h"

// From closed to wide open, seconds.
static const double SWING_SECONDS = 0.9;
// The distance that leaves keep from bodies and from other leaves, metres. No point of a leaf goes farther in one step, so that the
// leaf is clear halfway through a step too.
static const double CLEAR = 0.01;
// A door that was moved by less than this is the same door, metres: more than a file's decimals, less than a door's width.
static const double SAME_PLACE = 0.01;
// A ray counts as in the next cell this far beyond the last cell, metres: far above rounding, thinner than any wall.
static const double BEYOND = 1e-6;

// Finds openings by the boxes of them and of their leaves, wherever these stand. `near` has room for all: a search takes no memory.
struct DoorPlaces {
    BoxTree tree;
    BoxHits near;
};

bool doors_usable(const Doors *doors, int opening) {
    const Opening *o = &doors->graph->building->openings[opening];
    if (o->kind != OPENING_DOOR) return false;
    return doors->graph->building->form != FORM_REGIONS || (o->region[0] >= 0 && o->region[1] >= 0);
}

static bool may_meet(const Building *b, const Opening *p, const Opening *q) {
    for (int i = p->first_leaf; i < p->first_leaf + p->leaf_count; i++) {
        Box box = box_grow(door_leaf_reach(&b->leaves[i]), CLEAR);
        for (int k = q->first_leaf; k < q->first_leaf + q->leaf_count; k++) {
            if (box_overlap(box, door_leaf_reach(&b->leaves[k]))) return true;
        }
    }
    return false;
}

// The box of an opening and of its leaves, wherever they stand.
static Box opening_reach(const Building *b, const Opening *o) {
    Box box = box_add(box_add(box_empty(), vec3(o->line[0].x, o->line[0].y, o->sill)),
                      vec3(o->line[1].x, o->line[1].y, o->head));
    for (int i = o->first_leaf; i < o->first_leaf + o->leaf_count; i++)
        box = box_union(box, door_leaf_reach(&b->leaves[i]));
    return box;
}

Doors doors_new(const CellGraph *graph, Arena *arena) {
    const Building *b = graph->building;
    Arena scratch = {0};
    Box *reach = ARENA_ARRAY(arena, Box, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) reach[i] = opening_reach(b, &b->openings[i]);
    Doors d = {.graph = graph,
               .places = arena_alloc(arena, 1, sizeof *d.places),
               .open = ARENA_ARRAY(arena, float, b->opening_count + 1),
               .wanted = ARENA_ARRAY(arena, float, b->opening_count + 1),
               .halt = ARENA_ARRAY(arena, unsigned char, b->opening_count + 1),
               .near_first = ARENA_ARRAY(arena, int, b->opening_count + 1)};
    *d.places = (struct DoorPlaces){
        box_tree_build(reach, b->opening_count, arena),
        {.items = ARENA_ARRAY(arena, int, b->opening_count + 1), .capacity = b->opening_count + 1}};
    BoxHits *near = &d.places->near;
    int capacity = 0, count = 0;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        d.open[i] = d.wanted[i] = o->kind == OPENING_DOOR ? (float)o->open : 1;
        d.near_first[i] = count;
        if (o->leaf_count == 0) continue;
        int found = box_tree_find(&d.places->tree, box_grow(reach[i], CLEAR), arena, near);
        for (int n = 0; n < found; n++) {
            int k = near->items[n];
            if (k != i && may_meet(b, o, &b->openings[k])) *ARENA_PUSH(arena, d.near, count, capacity) = k;
        }
    }
    d.near_first[b->opening_count] = count;
    arena_free(&scratch);
    return d;
}

// The greatest distance between the ends or the sills of two openings, metres.
static double openings_apart(const Opening *a, const Opening *b) {
    double ends =
        fmax(vec2_length(vec2_sub(a->line[0], b->line[0])), vec2_length(vec2_sub(a->line[1], b->line[1])));
    return fmax(ends, fabs(a->sill - b->sill));
}

// Where its line begins.
static Box opening_begins(const Opening *o) {
    Vec3 at = vec3(o->line[0].x, o->line[0].y, o->sill);
    return (Box){at, at};
}

// The opening of the building `of` that is nearest to `to`, not `taken` and of the same name; -1: none.
static int nearest_of_name(const Opening *to, const Building *of, const unsigned char *taken) {
    int best = -1;
    double least = INFINITY;
    for (int k = 0; k < of->opening_count; k++) {
        const Opening *o = &of->openings[k];
        if (taken[k] || strcmp(o->name, to->name) != 0) continue;
        double apart = openings_apart(o, to);
        if (apart < least) best = k, least = apart;
    }
    return best;
}

void doors_keep(Doors *doors, const Doors *earlier) {
    const Building *now = doors->graph->building, *before = earlier->graph->building;
    Arena scratch = {0};
    unsigned char *taken = ARENA_ARRAY(&scratch, unsigned char, before->opening_count + 1);
    int *at = ARENA_ARRAY(&scratch, int, now->opening_count + 1);
    Box *begins = ARENA_ARRAY(&scratch, Box, before->opening_count + 1);
    for (int k = 0; k < before->opening_count; k++) begins[k] = opening_begins(&before->openings[k]);
    BoxTree tree = box_tree_build(begins, before->opening_count, &scratch);
    BoxHits near = {0};
    for (int i = 0; i < now->opening_count; i++) {
        const Opening *o = &now->openings[i];
        box_tree_find(&tree, box_grow(opening_begins(o), SAME_PLACE), &scratch, &near);
        at[i] = -1;
        double reach = SAME_PLACE;
        for (int n = 0; n < near.count; n++) {
            double apart = openings_apart(&before->openings[near.items[n]], o);
            if (apart < reach) at[i] = near.items[n], reach = apart;
        }
        if (at[i] >= 0) taken[at[i]] = 1;
    }
    for (int i = 0; i < now->opening_count; i++) {
        if (at[i] < 0) at[i] = nearest_of_name(&now->openings[i], before, taken);
        if (at[i] >= 0) doors_set(doors, i, earlier->open[at[i]]);
    }
    arena_free(&scratch);
}

bool doors_toggle(Doors *doors, int opening) {
    if (opening < 0 || !doors_usable(doors, opening)) return false;
    doors->wanted[opening] = doors->wanted[opening] < 0.5f ? 1 : 0;
    return true;
}

void doors_set(Doors *doors, int opening, float share) {
    CORE_ASSERT(share >= 0 && share <= 1);
    doors->open[opening] = doors->wanted[opening] = share;
    doors->halt[opening] = DOOR_FREE;
}

// ---- obstacles that stop a step

// A part of a door before and after a step. A door without leaves has no part while it is open: then `was_there` is false.
typedef struct PartStep {
    DoorPart from, to;
    bool was_there;
} PartStep;

static double part_distance(const DoorPart *part, Vec2 at) {
    Vec3 plan[LEAF_CORNERS];
    Solid solid = door_part_solid(part, plan);
    return solid_distance(&solid, part->heights, at);
}

static bool bands_overlap(Band a, Band b) { return a.z0 < b.z1 && b.z0 < a.z1; }

static double overlap(Band a, Band b) { return fmin(a.z1, b.z1) - fmax(a.z0, b.z0); }

// Does the part rise from below the body's foot?
static bool comes_under(const PartStep *s, const Body *body) {
    return s->was_there && s->from.heights.z1 <= body->foot.z + BODY_TOLERANCE &&
           s->to.heights.z1 > s->from.heights.z1 && s->to.heights.z1 > body->foot.z &&
           part_distance(&s->to, vec2(body->foot.x, body->foot.y)) < BODY_RADIUS;
}

static bool meets_body(const Doors *d, const PartStep *s, const Body *body) {
    Band upright = {body->foot.z, body->foot.z + body->height};
    Vec2 at = vec2(body->foot.x, body->foot.y);
    if (!bands_overlap(s->to.heights, upright)) return false;
    // A rising part carries the body, unless it would press the body against the ceiling.
    if (comes_under(s, body) && body->cell >= 0)
        return d->graph->cells[body->cell].z1 < s->to.heights.z1 + BODY_LOWEST;
    double distance = part_distance(&s->to, at);
    if (distance >= BODY_RADIUS + CLEAR) return false;
    return !s->was_there || distance < part_distance(&s->from, at) ||
           overlap(s->to.heights, upright) > overlap(s->from.heights, upright);
}

static bool meets_part(const PartStep *s, const DoorPart *other) {
    if (!bands_overlap(s->to.heights, other->heights)) return false;
    double gap = solid_gap(s->to.plan, s->to.count, other->plan, other->count);
    if (gap >= CLEAR) return false;
    if (!s->was_there) return true;
    double before = solid_gap(s->from.plan, s->from.count, other->plan, other->count);
    // Leaves that are drawn through one another may move apart in any way.
    return before >= 0 && gap < before;
}

static bool meets_doors(const Doors *d, int opening, const PartStep *s) {
    const Building *b = d->graph->building;
    for (int i = d->near_first[opening]; i < d->near_first[opening + 1]; i++) {
        int near = d->near[i];
        for (int k = 0; k < door_part_count(b, near); k++) {
            DoorPart other;
            if (door_part(b, near, k, (double)d->open[near], &other) && meets_part(s, &other)) return true;
        }
    }
    return false;
}

// A part of a door as it is now and as it is at another share; false where there is no part at that share.
static bool part_step(const Doors *d, int opening, int part, float share, PartStep *out) {
    const Building *b = d->graph->building;
    out->was_there = door_part(b, opening, part, (double)d->open[opening], &out->from);
    return door_part(b, opening, part, (double)share, &out->to);
}

static int halted(const Doors *d, int opening, float share, const Body *body) {
    for (int i = 0; i < door_part_count(d->graph->building, opening); i++) {
        PartStep s;
        if (!part_step(d, opening, i, share, &s)) continue;
        if (body && meets_body(d, &s, body)) return DOOR_MEETS_BODY;
        if (meets_doors(d, opening, &s)) return DOOR_MEETS_DOOR;
    }
    return DOOR_FREE;
}

// A part that rises under the body carries it up.
static void carry(const Doors *d, int opening, float share, Body *body) {
    for (int i = 0; i < door_part_count(d->graph->building, opening); i++) {
        PartStep s;
        if (!part_step(d, opening, i, share, &s) || !comes_under(&s, body) || body->cell < 0) continue;
        double top = s.to.heights.z1, ceiling = d->graph->cells[body->cell].z1;
        body->foot.z = top;
        body->height = fmin(body->height, ceiling - top);
        body->head = fmin(body->head, ceiling - top);
        body->standing = true;
        body->fall = 0;
    }
}

// The share of a door's way in which no point of its leaves goes farther than CLEAR.
static double small_step(const Building *b, const Opening *o) {
    double longest = CLEAR;
    for (int i = o->first_leaf; i < o->first_leaf + o->leaf_count; i++) {
        const Leaf *leaf = &b->leaves[i];
        Box reach = door_leaf_reach(leaf);
        double radius = fmax(reach.max.x - leaf->pivot.x, leaf->pivot.x - reach.min.x);
        longest = fmax(longest, radius * fabs(leaf->turn) + vec2_length(leaf->slide) + fabs(leaf->rise));
    }
    return CLEAR / longest;
}

void doors_advance(Doors *d, double seconds, Body *body) {
    const Building *b = d->graph->building;
    for (int i = 0; i < b->opening_count; i++) {
        if (d->open[i] == d->wanted[i]) continue;
        double left = seconds / SWING_SECONDS, step = small_step(b, &b->openings[i]);
        d->halt[i] = DOOR_FREE;
        while (left > 0 && d->open[i] != d->wanted[i]) {
            double way = fmin(step, left), to_go = (double)d->wanted[i] - (double)d->open[i];
            float next =
                fabs(to_go) <= way ? d->wanted[i] : (float)((double)d->open[i] + copysign(way, to_go));
            // The step is smaller than a float can represent.
            if (next == d->open[i]) break;
            d->halt[i] = (unsigned char)halted(d, i, next, body);
            if (d->halt[i] != DOOR_FREE) break;
            if (body) carry(d, i, next, body);
            d->open[i] = next;
            left -= way;
        }
    }
}

bool doors_move(const Doors *d) {
    for (int i = 0; i < d->graph->building->opening_count; i++)
        if (d->open[i] != d->wanted[i] && d->halt[i] == DOOR_FREE) return true;
    return false;
}

// ---- looking at doors

// How far a ray goes before it leaves a cell, metres.
static double way_out(const CellGraph *graph, const Cell *cell, Vec3 eye, Vec3 direction) {
    double out = INFINITY;
    if (direction.z != 0) out = ((direction.z > 0 ? cell->z1 : cell->z0) - eye.z) / direction.z;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = graph->plan[cell->first_edge + i],
             b = graph->plan[cell->first_edge + (i + 1) % cell->edge_count];
        Vec2 edge = vec2_sub(b, a);
        double speed = vec2_cross(edge, vec2(direction.x, direction.y));
        double off = vec2_cross(edge, vec2_sub(vec2(eye.x, eye.y), a));
        if (speed < 0) out = fmin(out, off / -speed);
    }
    return out;
}

// How far a ray goes before it meets a wall or a window, metres; at most `reach`.
static double clear_length(const CellGraph *graph, Vec3 eye, int cell, Vec3 direction, double reach) {
    const Building *b = graph->building;
    double gone = 0;
    while (cell >= 0 && gone < reach) {
        const Region *region = vis_region(graph, cell);
        if (region->opening >= 0 && b->openings[region->opening].kind == OPENING_WINDOW) break;
        // Each step goes a little farther, so that the loop ends even where rounding finds a cell that the ray has left.
        gone = fmax(gone, way_out(graph, &graph->cells[cell], eye, direction)) + BEYOND;
        cell = vis_locate(graph, vec3_add(eye, vec3_scale(direction, gone)), cell);
    }
    return fmin(gone, reach);
}

// How far a ray goes before it enters an upright prism, metres, or INFINITY.
static double prism_hit(const DoorPart *part, Vec3 eye, Vec3 direction) {
    double in = 0, out = INFINITY;
    for (int i = 0; i < part->count + 2; i++) {
        // The ray is outside this side of the prism where `off` + t * `speed` < 0.
        double off, speed;
        if (i < part->count) {
            Vec2 a = part->plan[i], edge = vec2_sub(part->plan[(i + 1) % part->count], a);
            off = vec2_cross(edge, vec2_sub(vec2(eye.x, eye.y), a));
            speed = vec2_cross(edge, vec2(direction.x, direction.y));
        } else {
            off = i == part->count ? eye.z - part->heights.z0 : part->heights.z1 - eye.z;
            speed = i == part->count ? direction.z : -direction.z;
        }
        if (speed == 0 && off < 0) return INFINITY;
        if (speed > 0) in = fmax(in, -off / speed);
        if (speed < 0) out = fmin(out, off / -speed);
    }
    return in <= out ? in : INFINITY;
}

static double doorway_hit(const Opening *o, Vec3 eye, Vec3 direction) {
    Vec2 along = vec2_sub(o->line[1], o->line[0]), to = vec2_sub(o->line[0], vec2(eye.x, eye.y));
    Vec2 way = vec2(direction.x, direction.y);
    double across = vec2_cross(way, along);
    if (across == 0) return INFINITY;
    double t = vec2_cross(to, along) / across, u = vec2_cross(to, way) / across, z = eye.z + t * direction.z;
    return t >= 0 && u >= 0 && u <= 1 && z >= o->sill && z <= o->head ? t : INFINITY;
}

int doors_looked_at(const Doors *d, Vec3 eye, int cell, Vec3 direction, double reach) {
    const Building *b = d->graph->building;
    double nearest = clear_length(d->graph, eye, cell, direction, reach);
    int found = -1;
    BoxHits *near = &d->places->near;
    Box around =
        box_grow(box_add(box_add(box_empty(), eye), vec3_add(eye, vec3_scale(direction, nearest))), CLEAR);
    int count = box_tree_find(&d->places->tree, around, NULL, near);
    for (int n = 0; n < count; n++) {
        int i = near->items[n];
        if (!doors_usable(d, i)) continue;
        double hit = doorway_hit(&b->openings[i], eye, direction);
        for (int k = 0; k < b->openings[i].leaf_count; k++) {
            DoorPart part;
            if (door_part(b, i, k, (double)d->open[i], &part))
                hit = fmin(hit, prism_hit(&part, eye, direction));
        }
        if (hit >= nearest) continue;
        nearest = hit;
        found = i;
    }
    return found;
}
