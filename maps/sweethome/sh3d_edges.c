// sh3d_edges.c - the narrow surfaces where walls and floors end, as Sweet Home 3D draws them: ends and jambs of walls begin their side's
// picture anew, doorways have the floor of the room drawn over them, and the sides of a hole in a floor look as that floor.
#include <string.h>

#include "engine/core/box_tree.h"
#include "engine/core/polygon.h"
#include "maps/sweethome/sh3d.h"

static const double BEHIND = 0.005;       // metres, from the edge of a hole into the floor around it
static const double ON_SIDE = 0.002;      // metres: the grid of plans moves corners by less
static const double SAME_FLOOR = 0.0005;  // metres: half the grid of heights
enum { MOST_MATERIALS = 16384 };          // from here on jambs go on as their side

void sh3d_keep_lengths(Sh3d *s, int material, const XmlNode *texture) {
    static const Sh3dFrame LENGTHS = {.right = {1, 0, 0}, .up = {0, 1, 0}};
    Sketch *k = s->sketch;
    TextureMap map;
    if (!texture || s->b->materials[material].texture_map == 0 || !sh3d_map(s, texture, &LENGTHS, &map))
        return;
    while (k->lengths_count <= material)
        *ARENA_PUSH(s->arena, k->lengths, k->lengths_count, k->lengths_capacity) = (TextureMap){0};
    k->lengths[material] = map;
}

bool sh3d_has_lengths(const Sketch *k, int material) {
    return material >= 0 && material < k->lengths_count &&
           (vec3_length(k->lengths[material].u) > 0 || vec3_length(k->lengths[material].v) > 0);
}

Sh3dFrame sh3d_frame_from(Vec2 from, Vec2 to) {
    Vec2 along = vec2_sub(to, from);
    double length = vec2_length(along);
    Vec2 right = vec2_scale(along, length > 0 ? 1 / length : 0);
    return (Sh3dFrame){.right = {right.x, right.y, 0}, .up = {0, 0, 1}, .right0 = -vec2_dot(right, from)};
}

int sh3d_begun_anew(Arena *arena, Building *b, const Sketch *k, int material, const Sh3dFrame *f) {
    if (!sh3d_has_lengths(k, material) || b->material_count >= MOST_MATERIALS) return material;
    const TextureMap *l = &k->lengths[material];
    TextureMap map = {vec3_add(vec3_scale(f->right, l->u.x), vec3_scale(f->up, l->u.y)),
                      vec3_add(vec3_scale(f->right, l->v.x), vec3_scale(f->up, l->v.y)),
                      l->u0 + l->u.x * f->right0 + l->u.y * f->up0,
                      l->v0 + l->v.x * f->right0 + l->v.y * f->up0};
    Material m = b->materials[material];
    m.texture_map = building_add_texture_map(arena, b, map);
    return building_add_material(arena, b, m);
}

// ---- after the free space is found

// Rooms and sides of walls as drawn, to be found by place; z of the boxes is the storey.
typedef struct Drawn {
    const Sketch *sketch;
    BoxTree rooms, sides;
    int *side_point, *side_next;  // the ends of each side of a wall, in Sketch.points
    Ring *rings;                  // [region_count] the first ring of each region, before jambs get corners
    int *opening_region,
        *next;  // [opening_count], [region_count] the regions of an opening as chains, -1: the end
    BoxHits hits;
    Arena *scratch;
} Drawn;

static void index_rooms(Drawn *d) {
    const Sketch *k = d->sketch;
    Box *boxes = ARENA_ARRAY(d->scratch, Box, k->room_count);
    for (int i = 0; i < k->room_count; i++) {
        const SketchRoom *room = &k->rooms[i];
        boxes[i] = box_empty();
        for (int p = 0; p < room->point_count; p++) {
            Vec2 at = k->points[room->first_point + p];
            boxes[i] = box_add(boxes[i], vec3(at.x, at.y, room->storey));
        }
    }
    d->rooms = box_tree_build(boxes, k->room_count, d->scratch);
}

static void index_sides(Drawn *d) {
    const Sketch *k = d->sketch;
    int count = 0;
    for (int i = 0; i < k->wall_count; i++) count += k->walls[i].point_count;
    Box *boxes = ARENA_ARRAY(d->scratch, Box, count);
    d->side_point = ARENA_ARRAY(d->scratch, int, count);
    d->side_next = ARENA_ARRAY(d->scratch, int, count);
    count = 0;
    for (int i = 0; i < k->wall_count; i++) {
        const SketchWall *w = &k->walls[i];
        for (int p = 0; p < w->point_count; p++, count++) {
            d->side_point[count] = w->first_point + p;
            d->side_next[count] = w->first_point + (p + 1) % w->point_count;
            Vec2 a = k->points[d->side_point[count]], b = k->points[d->side_next[count]];
            boxes[count] =
                box_add(box_add(box_empty(), vec3(a.x, a.y, w->storey)), vec3(b.x, b.y, w->storey));
        }
    }
    d->sides = box_tree_build(boxes, count, d->scratch);
}

// The material of the side of a wall along `axis` on which a point lies, -1: none.
static int side_at(Drawn *d, int storey, Vec2 p, Vec2 axis) {
    const Sketch *k = d->sketch;
    double nearest = ON_SIDE;
    int found = -1;
    Box around = {vec3(p.x - ON_SIDE, p.y - ON_SIDE, storey), vec3(p.x + ON_SIDE, p.y + ON_SIDE, storey)};
    box_tree_find(&d->sides, around, d->scratch, &d->hits);
    for (int i = 0; i < d->hits.count; i++) {
        int from = d->side_point[d->hits.items[i]];
        Vec2 a = k->points[from], along = vec2_sub(k->points[d->side_next[d->hits.items[i]]], a);
        double length = vec2_length(along), off = fabs(vec2_cross(along, vec2_sub(p, a)));
        if (fabs(vec2_cross(axis, along)) > fabs(vec2_dot(axis, along)) || off > nearest * length) continue;
        nearest = off / length;
        found = k->edge_material[from];
    }
    return found;
}

// The floor drawn at a point of a storey; of several the program shows one or the other, here the last; -1: none.
static int floor_at(Drawn *d, int storey, Vec2 p) {
    const Sketch *k = d->sketch;
    Vec3 at = vec3(p.x, p.y, storey);
    int found = -1;
    box_tree_find(&d->rooms, (Box){at, at}, d->scratch, &d->hits);
    for (int i = 0; i < d->hits.count; i++) {
        const SketchRoom *room = &k->rooms[d->hits.items[i]];
        if (ring_contains(&k->points[room->first_point], room->point_count, p) && d->hits.items[i] > found)
            found = d->hits.items[i];
    }
    return found < 0 ? -1 : k->rooms[found].floor_material;
}

static Vec2 middle_of(const Building *b, const Ring *ring) {
    Vec2 sum = vec2(0, 0);
    for (int i = 0; i < ring->point_count; i++) sum = vec2_add(sum, b->points[ring->first_point + i]);
    return vec2_scale(sum, 1.0 / ring->point_count);
}

static void push_corner(Arena *arena, Building *b, Vec2 p, int material) {
    if (b->point_count == b->edge_capacity) {
        b->edge_capacity = 2 * b->edge_capacity + 64;
        int *larger = ARENA_ARRAY(arena, int, b->edge_capacity);
        memcpy(larger, b->edge_material, sizeof(int) * (size_t)b->point_count);
        b->edge_material = larger;
    }
    b->edge_material[b->point_count] = material;
    *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = p;
}

static void index_openings(Drawn *d, const Building *b) {
    d->rings = ARENA_ARRAY(d->scratch, Ring, b->region_count + 1);
    d->opening_region = ARENA_ARRAY(d->scratch, int, b->opening_count + 1);
    d->next = ARENA_ARRAY(d->scratch, int, b->region_count + 1);
    for (int i = 0; i < b->opening_count; i++) d->opening_region[i] = -1;
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->kind != REGION_OPENING) continue;
        d->rings[i] = b->rings[r->first_ring];
        d->next[i] = d->opening_region[r->opening];
        d->opening_region[r->opening] = i;
    }
}

// An edge of an opening's outline. `start` and `end` are those of the whole jamb, of which a door's halves have a part each, with the
// materials of the sides of the wall there, -1: none.
typedef struct Jamb {
    Vec2 from, to, start, end;
    int material, side[2];
    bool across;  // the line of the opening: not on to the room
} Jamb;

// Where the edge of an opening's outline that begins (`ahead`) or ends at `at` leads along `along`; false where there is none.
static bool edge_beyond(const Drawn *d, const Building *b, int opening, Vec2 along, bool ahead, Vec2 *at) {
    for (int k = d->opening_region[opening]; k >= 0; k = d->next[k]) {
        const Ring *ring = &d->rings[k];
        for (int i = 0; i < ring->point_count; i++) {
            Vec2 from = b->points[ring->first_point + i],
                 to = b->points[ring->first_point + (i + 1) % ring->point_count], way = vec2_sub(to, from);
            if (!vec2_equal(ahead ? from : to, *at) || !(vec2_dot(way, along) > 0)) continue;
            if (fabs(vec2_cross(way, along)) > ON_SIDE * vec2_length(along)) continue;
            *at = ahead ? to : from;
            return true;
        }
    }
    return false;
}

// The end of a jamb: outlines have corners where its material changes, and doors have a half for either side.
static Vec2 jamb_end(const Drawn *d, const Building *b, int opening, Vec2 from, Vec2 to) {
    Vec2 along = vec2_sub(to, from);
    while (edge_beyond(d, b, opening, along, true, &to)) continue;
    return to;
}

static Vec2 jamb_start(const Drawn *d, const Building *b, int opening, Vec2 from, Vec2 to) {
    Vec2 along = vec2_sub(to, from);
    while (edge_beyond(d, b, opening, along, false, &from)) continue;
    return from;
}

static Jamb jamb_of(Drawn *d, const Building *b, const Region *r, int i) {
    const Ring *ring = &b->rings[r->first_ring];
    const Vec2 *line = b->openings[r->opening].line;
    int first = ring->first_point, next = first + (i + 1) % ring->point_count;
    Vec2 axis = vec2_sub(line[1], line[0]);
    Jamb j = {.from = b->points[first + i],
              .to = b->points[next],
              .material = b->edge_material[first + i],
              .side = {-1, -1}};
    Vec2 along = vec2_sub(j.to, j.from);
    j.across = fabs(vec2_cross(axis, along)) > fabs(vec2_dot(axis, along));
    if (!j.across) return j;
    j.start = jamb_start(d, b, r->opening, j.from, j.to);
    j.end = jamb_end(d, b, r->opening, j.from, j.to);
    j.side[0] = side_at(d, r->storey, j.start, axis);
    j.side[1] = side_at(d, r->storey, j.end, axis);
    return j;
}

// Each half of a jamb has the picture of its side: outlines get a corner in the middle. A door closes where its leaf is, which need not be
// there. Seen from the free space an edge's end is to the left.
static void begin_jambs(Drawn *d, Arena *arena, Building *b, const Region *r) {
    const Sketch *k = d->sketch;
    Ring *ring = &b->rings[r->first_ring];
    int first = b->point_count;
    bool changed = false;
    Jamb *jambs = ARENA_ARRAY(d->scratch, Jamb, ring->point_count);
    for (int i = 0; i < ring->point_count; i++) {
        Jamb *j = &jambs[i];
        *j = jamb_of(d, b, r, i);
        changed =
            changed || (j->across && (sh3d_has_lengths(k, j->material) || sh3d_has_lengths(k, j->side[0]) ||
                                      sh3d_has_lengths(k, j->side[1])));
    }
    if (!changed) return;
    for (int i = 0; i < ring->point_count; i++) {
        const Jamb *j = &jambs[i];
        bool whole = !j->across || j->side[0] < 0 || j->side[1] < 0;
        Vec2 middle = vec2_scale(vec2_add(j->start, j->end), 0.5), along = vec2_sub(j->to, j->from);
        middle = vec2(maps_snap(middle.x), maps_snap(middle.y));
        bool begins = whole || vec2_dot(vec2_sub(middle, j->from), along) > 0,
             goes_on = !whole && vec2_dot(vec2_sub(j->to, middle), along) > 0;
        Sh3dFrame near = sh3d_frame_from(whole ? j->to : middle, j->from),
                  far = sh3d_frame_from(j->end, middle);
        int material = whole ? j->material : j->side[0];
        if (j->across) material = sh3d_begun_anew(arena, b, k, material, &near);
        if (begins) push_corner(arena, b, j->from, material);
        if (goes_on)
            push_corner(arena, b, begins ? middle : j->from, sh3d_begun_anew(arena, b, k, j->side[1], &far));
    }
    *ring = (Ring){first, b->point_count - first};
}

static void lay_threshold(Drawn *d, const Building *b, Region *r) {
    if (fabs(r->z0 - b->storeys[r->storey].floor) > SAME_FLOOR) return;
    int floor = floor_at(d, r->storey, middle_of(b, &b->rings[r->first_ring]));
    if (floor >= 0) r->floor_material = floor;
}

// Where the straight line begins that edge i of a ring belongs to.
static Vec2 line_start(const Building *b, const Ring *ring, int i) {
    const Vec2 *p = &b->points[ring->first_point];
    int n = ring->point_count, start = i;
    Vec2 along = vec2_sub(p[(i + 1) % n], p[i]);
    for (int back = (i + n - 1) % n; back != i; back = (back + n - 1) % n) {
        Vec2 before = vec2_sub(p[start], p[back]);
        if (fabs(vec2_cross(before, along)) > ON_SIDE * vec2_length(along) || vec2_dot(before, along) <= 0)
            break;
        start = back;
    }
    return p[start];
}

// The sides of the slab around a hole look as the floor above them. Their pictures hang upside down: they begin at the right upper corner,
// as one looks at them.
static void paint_stairwell(Drawn *d, Arena *arena, Building *b, const Region *r) {
    for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
        const Ring *ring = &b->rings[k];
        for (int i = 0; i < ring->point_count; i++) {
            Vec2 from = b->points[ring->first_point + i],
                 to = b->points[ring->first_point + (i + 1) % ring->point_count], along = vec2_sub(to, from),
                 middle = vec2_scale(vec2_add(from, to), 0.5);
            double length = vec2_length(along);
            Vec2 outward = vec2_scale(vec2(along.y, -along.x), length > 0 ? BEHIND / length : 0);
            int floor = floor_at(d, r->storey, vec2_add(middle, outward));
            Sh3dFrame frame = sh3d_frame_from(line_start(b, ring, i), to);
            frame.up = vec3(0, 0, -1);
            frame.up0 = r->z1;
            if (floor >= 0)
                b->edge_material[ring->first_point + i] = sh3d_begun_anew(arena, b, d->sketch, floor, &frame);
        }
    }
}

void sh3d_finish_edges(const Sketch *k, Arena *arena, Building *b) {
    Arena scratch = {0};
    Drawn d = {.sketch = k, .scratch = &scratch};
    index_rooms(&d);
    index_sides(&d);
    index_openings(&d, b);
    for (int i = 0; i < b->region_count; i++) {
        Region *r = &b->regions[i];
        if (r->kind == REGION_SHAFT) paint_stairwell(&d, arena, b, r);
        if (r->kind != REGION_OPENING) continue;
        lay_threshold(&d, b, r);
        if (k->lengths_count > 0) begin_jambs(&d, arena, b, r);
    }
    arena_free(&scratch);
}
