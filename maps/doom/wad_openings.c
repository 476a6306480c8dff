// wad_openings.c - doors and lifts of a Doom map. A leaf is as thick as its sector: a prism for each of its pieces,
// which goes up into the wall above or down into the ground. A door fills its place and hides the space beyond; over a lift
// one looks at all times.
#include "engine/core/polygon.h"
#include "engine/core/sets.h"
#include "maps/doom/wad.h"

// A leaf keeps this clear of the walls beside it, and moves so much farther than it must, metres: its faces never lie in the
// plane of a wall, a floor or a ceiling.
static const double CLEAR = 0.005;

// The pieces of one sector that hang together.
typedef struct Part {
    int first_piece, sector;
    double longest;    // of its contacts with others, map units
    Vec2 along;        // the direction of that one
    Vec2 low, high;    // metres, in a frame with x along it
    double widest[2];  // of its contacts on the left and on the right of the middle, across `along`
    int beyond[2];     // pieces there, -1 without
    int material;
} Part;

typedef struct Doors {
    WadBuilder *w;
    WadContact *contacts;
    int contact_count;
    int *part_of;  // [piece_count] -1: it does not move
    int *next;     // [piece_count] of the same part, -1 ends
    int *last;     // [part_count] its last piece so far
    Part *parts;
    int part_count;
    int *places;  // [sector_count] doors named after the sector so far
} Doors;

static bool has_region(const WadBuilder *w, int piece) {
    return w->first_region[piece] < w->first_region[piece + 1];
}

static void find_parts(Doors *d, Arena *scratch) {
    const WadPieces *p = d->w->pieces;
    int *parent = ARENA_ARRAY(scratch, int, p->piece_count + 1);
    for (int i = 0; i < p->piece_count; i++) {
        parent[i] = i;
        d->part_of[i] = d->next[i] = -1;
    }
    for (int i = 0; i < d->contact_count; i++) {
        const WadContact *c = &d->contacts[i];
        if (p->pieces[c->piece[0]].sector != p->pieces[c->piece[1]].sector) continue;
        set_join(parent, c->piece[0], c->piece[1]);
    }
    for (int i = 0; i < p->piece_count; i++) {
        int sector = p->pieces[i].sector, root = set_find(parent, i);
        if (sector < 0 || d->w->movers[sector].motion == WAD_FIXED || !has_region(d->w, i)) continue;
        if (d->part_of[root] < 0) {
            d->part_of[root] = d->part_count;
            d->parts[d->part_count] = (Part){.first_piece = -1, .sector = sector, .beyond = {-1, -1}};
            d->part_count++;
        }
        int part = d->part_of[i] = d->part_of[root];
        if (d->parts[part].first_piece < 0) {
            d->parts[part].first_piece = i;
        } else {
            d->next[d->last[part]] = i;
        }
        d->last[part] = i;
    }
}

// The unit vector of an axis.
static Vec2 direction(const WadAxis *axis) {
    Vec2 v = vec2((double)axis->b, -(double)axis->a);
    return vec2_scale(v, 1 / vec2_length(v));
}

// The part on side `k` of a contact, if another room lies beyond the contact; else NULL.
static Part *leads_out(const Doors *d, const WadContact *c, int k) {
    int part = d->part_of[c->piece[k]];
    bool out = part >= 0 && d->part_of[c->piece[1 - k]] != part && has_region(d->w, c->piece[1 - k]);
    return out ? &d->parts[part] : NULL;
}

// Along the axis itself: places along it are counted in x or y.
static double length_of(const WadContact *c, Vec2 direction) {
    return (c->high - c->low) / fmax(fabs(direction.x), fabs(direction.y));
}

static Vec2 in_frame(const Part *part, Vec2 p) {
    return vec2(vec2_dot(part->along, p), vec2_cross(part->along, p));
}
static Vec2 from_frame(const Part *part, Vec2 p) {
    return vec2(part->along.x * p.x - part->along.y * p.y, part->along.y * p.x + part->along.x * p.y);
}

// The way a part lies, from its longest contact, and its extent.
static void measure_parts(Doors *d) {
    const WadPieces *p = d->w->pieces;
    for (int i = 0; i < d->part_count; i++)
        d->parts[i].along = direction(&p->axes[p->edges[p->pieces[d->parts[i].first_piece].first_edge].axis]);
    for (int i = 0; i < d->contact_count; i++) {
        const WadContact *c = &d->contacts[i];
        Vec2 along = direction(&p->axes[c->axis]);
        for (int k = 0; k < 2; k++) {
            Part *part = leads_out(d, c, k);
            if (!part || length_of(c, along) <= part->longest) continue;
            part->longest = length_of(c, along);
            part->along = along;
        }
    }
    for (int i = 0; i < d->part_count; i++) {
        Part *part = &d->parts[i];
        part->low = vec2(INFINITY, INFINITY);
        part->high = vec2(-INFINITY, -INFINITY);
        for (int piece = part->first_piece; piece >= 0; piece = d->next[piece]) {
            for (int k = 0; k < p->pieces[piece].edge_count; k++) {
                WadPoint at = p->edges[p->pieces[piece].first_edge + k].from;
                Vec2 q = in_frame(part, vec2(wad_metres_of(wad_x(at)), wad_metres_of(wad_y(at))));
                part->low = vec2(fmin(part->low.x, q.x), fmin(part->low.y, q.y));
                part->high = vec2(fmax(part->high.x, q.x), fmax(part->high.y, q.y));
            }
        }
    }
}

// The widest way out on either side of the line through a part's middle.
static void find_beyond(Doors *d) {
    const WadPieces *p = d->w->pieces;
    for (int i = 0; i < d->contact_count; i++) {
        const WadContact *c = &d->contacts[i];
        Vec2 along = direction(&p->axes[c->axis]);
        for (int k = 0; k < 2; k++) {
            Part *part = leads_out(d, c, k);
            if (!part) continue;
            // Out of the piece on the positive side is to the right of the axis.
            double across = (k == 0 ? -1 : 1) * vec2_dot(part->along, along);
            double width = fabs(across) * length_of(c, along);
            int side = across > 0 ? 0 : 1, other = c->piece[1 - k];
            if (width <= part->widest[side]) continue;
            bool rises = d->w->movers[part->sector].motion == WAD_DOOR;
            if (width > part->widest[1 - side])
                part->material = wad_wall_material(d->w, &p->edges[c->edge[1 - k]], p->pieces[other].sector,
                                                   (c->low + c->high) / 2, rises);
            part->widest[side] = width;
            part->beyond[side] = other;
        }
    }
}

// ---- leaves

// The corners of a piece that keep clear of its edges; all of them where it is too thin for that.
static int leaf_corners(const WadPieces *p, const WadPiece *piece, Arena *scratch, Vec3 **out) {
    int count = piece->edge_count, kept = count;
    Vec3 *corner = ARENA_ARRAY(scratch, Vec3, count), *room[2];
    for (int i = 0; i < count; i++) {
        WadPoint at = p->edges[piece->first_edge + i].from;
        corner[i] = vec3(wad_metres_of(wad_x(at)), wad_metres_of(wad_y(at)), 0);
    }
    for (int i = 0; i < 2; i++) room[i] = ARENA_ARRAY(scratch, Vec3, 2 * count + 2);
    memcpy(room[0], corner, (size_t)count * sizeof *corner);
    for (int i = 0; i < count && kept > 0; i++) {
        Vec3 a = corner[i], b = corner[(i + 1) % count];
        Vec3 inward = vec3_normalize(vec3(a.y - b.y, b.x - a.x, 0));
        kept =
            polygon_clip(room[i % 2], kept, (Plane){inward, vec3_dot(inward, a) + CLEAR}, 0, room[1 - i % 2]);
    }
    bool good = kept >= 3 && polygon_area(room[count % 2], kept) > CLEAR * CLEAR;
    *out = good ? room[count % 2] : corner;
    return good ? kept : count;
}

// An upright face of a leaf: its texture begins at its left end, whichever way it looks.
static void add_face(const WadBuilder *w, const Vec3 quad[4], int material) {
    Building *b = w->building;
    if (b->materials[material].texture == 0) {
        building_add_polygon(w->arena, b, quad, 4, material);
        return;
    }
    const TextureMap *lie = &b->texture_maps[b->materials[material].texture_map];
    Vec2 places[4];
    double across = vec3_length(lie->u) * vec3_length(vec3_sub(quad[1], quad[0]));
    for (int i = 0; i < 4; i++)
        places[i] = vec2(i == 1 || i == 2 ? across : 0, vec3_dot(lie->v, quad[i]) + lie->v0);
    building_add_textured(w->arena, b, quad, places, 4, material);
}

static void add_leaf_object(Doors *d, const Leaf *leaf, const Vec2 *corner, int count) {
    Building *b = d->w->building;
    const Opening *o = &b->openings[leaf->opening];
    const Region *r = &b->regions[d->w->first_region[d->parts[leaf->opening].first_piece]];
    int object = building_add_object(d->w->arena, b, OBJECT_LEAF, o->name);
    b->objects[object].opening = leaf->opening;
    b->objects[object].leaf = b->leaf_count - 1;
    Vec3 level[LEAF_CORNERS];
    for (int i = 0; i < count; i++) {
        Vec2 p = corner[i], q = corner[(i + 1) % count];
        Vec3 quad[4] = {
            {p.x, p.y, leaf->z0}, {q.x, q.y, leaf->z0}, {q.x, q.y, leaf->z1}, {p.x, p.y, leaf->z1}};
        add_face(d->w, quad, o->material);
        level[leaf->rise > 0 ? count - 1 - i : i] = vec3(p.x, p.y, leaf->rise > 0 ? leaf->z0 : leaf->z1);
    }
    // The leading face of the leaf: the underside of one that rises, the top of one that sinks. The other one is never seen.
    int material = leaf->rise > 0 ? r->ceiling_material : r->floor_material;
    building_add_polygon(d->w->arena, b, level, count, material);
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    building_set_proxy(d->w->arena, b, atan2(along.y, along.x));
}

static void add_leaf(Doors *d, int part_index, int piece, Arena *scratch) {
    Building *b = d->w->building;
    const Part *part = &d->parts[part_index];
    const WadMover *mover = &d->w->movers[part->sector];
    Vec3 *given;
    Vec2 corner[LEAF_CORNERS], low = {INFINITY, INFINITY}, high = {-INFINITY, -INFINITY};
    int all = leaf_corners(d->w->pieces, &d->w->pieces->pieces[piece], scratch, &given), count = 0;
    // A leaf with more corners than allowed keeps only every so many of them.
    int every = (all + LEAF_CORNERS - 1) / LEAF_CORNERS;
    Leaf leaf = {.opening = part_index, .first_corner = b->point_count};
    for (int i = 0; i < all; i += every) {
        corner[count] = vec2(given[i].x, given[i].y);
        Vec2 q = in_frame(part, corner[count]);
        low = vec2(fmin(low.x, q.x), fmin(low.y, q.y));
        high = vec2(fmax(high.x, q.x), fmax(high.y, q.y));
        *ARENA_PUSH(d->w->arena, b->points, b->point_count, b->point_capacity) = corner[count++];
    }
    leaf.corner_count = count;
    leaf.axis[0] = leaf.pivot = from_frame(part, vec2(low.x, (low.y + high.y) / 2));
    leaf.axis[1] = from_frame(part, vec2(high.x, (low.y + high.y) / 2));
    leaf.thickness = high.y - low.y;
    leaf.z0 = wad_metres_of(mover->low);
    leaf.z1 = wad_metres_of(mover->high);
    leaf.rise = (mover->motion == WAD_DOOR ? 1 : -1) * (leaf.z1 - leaf.z0 + CLEAR);
    *ARENA_PUSH(d->w->arena, b->leaves, b->leaf_count, b->leaf_capacity) = leaf;
    add_leaf_object(d, &leaf, corner, count);
}

// ---- openings

// By its sector; one that lies in several places has several doors.
static const char *name_of(Doors *d, int part) {
    int sector = d->parts[part].sector, place = ++d->places[sector];
    const char *kind = d->w->movers[sector].motion == WAD_LIFT ? "lift" : "door";
    return place == 1 ? arena_format(d->w->arena, "%s %d", kind, sector)
                      : arena_format(d->w->arena, "%s %d-%d", kind, sector, place);
}

static void add_opening(Doors *d, int index) {
    Building *b = d->w->building;
    Part *part = &d->parts[index];
    const WadMover *mover = &d->w->movers[part->sector];
    bool lift = mover->motion == WAD_LIFT;
    double middle = (part->low.y + part->high.y) / 2;
    Opening o = {
        .kind = OPENING_DOOR,
        .name = name_of(d, index),
        .glazed = lift,
        .fills = true,
        .line = {from_frame(part, vec2(part->low.x, middle)), from_frame(part, vec2(part->high.x, middle))},
        .sill = wad_metres_of(mover->low),
        .head = wad_metres_of(mover->high),
        .first_leaf = b->leaf_count,
        .open = mover->open,
        .material = part->material};
    // A lift may be entered from one side only; a door to nowhere is a cupboard.
    for (int k = 0; k < 2; k++) {
        int beyond = lift && part->beyond[k] < 0 ? part->beyond[1 - k] : part->beyond[k];
        o.region[k] = beyond < 0 ? -1 : d->w->first_region[beyond];
        if (beyond < 0) o.reason = "nothing lies behind it";
    }
    *ARENA_PUSH(d->w->arena, b->openings, b->opening_count, b->opening_capacity) = o;
    Arena scratch = {0};
    for (int piece = part->first_piece; piece >= 0; piece = d->next[piece]) {
        for (int r = d->w->first_region[piece]; r < d->w->first_region[piece + 1]; r++) {
            b->regions[r].kind = REGION_OPENING;
            b->regions[r].opening = index;
        }
        add_leaf(d, index, piece, &scratch);
    }
    b->openings[index].leaf_count = b->leaf_count - o.first_leaf;
    arena_free(&scratch);
}

void wad_add_openings(WadBuilder *w) {
    Arena scratch = {0};
    int pieces = w->pieces->piece_count;
    Doors d = {.w = w,
               .part_of = ARENA_ARRAY(&scratch, int, pieces + 1),
               .next = ARENA_ARRAY(&scratch, int, pieces + 1),
               .last = ARENA_ARRAY(&scratch, int, pieces + 1),
               .parts = ARENA_ARRAY(&scratch, Part, pieces + 1),
               .places = ARENA_ARRAY(&scratch, int, w->map->sector_count + 1)};
    d.contact_count = wad_find_contacts(w->pieces, &scratch, &d.contacts);
    find_parts(&d, &scratch);
    measure_parts(&d);
    find_beyond(&d);
    for (int i = 0; i < d.part_count; i++) add_opening(&d, i);
    arena_free(&scratch);
}
