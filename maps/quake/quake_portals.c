// quake_portals.c - the portals between the leaves of a level, from its tree of planes alone.
//
// The part of a node's plane within the node's space is what the planes above leave of it. It is sent down on the side before the plane,
// where the leaves cut it into pieces, and each piece down on the other side. What arrives is where two leaves touch.
#include "engine/core/polygon.h"
#include "maps/quake/quake.h"

// Corners so near a plane count as on it, units: planes in single precision at the border of a level of 8,192 units are off by half as
// much. Where a face lies in a plane, it goes on on both sides.
static const double ON_PLANE = 1e-3;
// A portal narrower than this is closed, units: where three planes should meet in one line and do not, slivers arise, a hundredth of
// the least step in which levels are drawn.
static const double NARROWEST = 1e-2;
// How far the leaves around a level may reach beyond its faces, units.
static const double MARGIN = 32;
enum {
    MOST_CORNERS = 64,       // of a portal, as in portal files
    MOST_PIECES = 1 << 26,   // cut in all; of real levels some hundred a node
    MOST_PORTALS = 1 << 20,  // as in portal files
};

typedef struct Piece {
    int count;
    Vec3 corner[MOST_CORNERS + 1];
} Piece;

typedef struct Maker {
    const QuakeLevel *level;
    bool clear_water;
    Arena *arena;
    QuakeCells *cells;
    Error *error;
    Box box;  // of the level, and its margin
    int portal_capacity, front;
    long long pieces;
    int slivers;
    int leaks;  // leaves that reach the border
    Vec3 leak;  // the first place
} Maker;

// ---- contents

enum {
    EMPTY = -1,
    SOLID = -2,
    WATER = -3,
    SLIME = -4,
    LAVA = -5,
    SKY = -6,
    CURRENTS = -9,
    LAST_CURRENT = -14
};
enum {
    II_SOLID = 1,
    II_LIQUIDS = 8 | 16 | 32,
    II_VISIBLE = 127,
    II_DETAIL = 0x8000000,
    II_TRANSLUCENT = 0x10000000
};

// Does the leaf stop all sight: is it solid, or sky?
static bool is_opaque(const QuakeLevel *level, int leaf) {
    int contents = level->leaves[leaf].contents;
    if (level->format == QUAKE_IBSP38) return contents & II_SOLID;
    return contents == SOLID || contents == SKY;
}

// The contents of a leaf of Quake, as far as sight is concerned.
static int substance(const Maker *m, int contents) {
    bool current = contents <= CURRENTS && contents >= LAST_CURRENT;
    int liquid = current ? WATER : contents;
    if (liquid == WATER || liquid == SLIME || liquid == LAVA) return m->clear_water ? EMPTY : liquid;
    return EMPTY;
}

// The contents of a leaf of Quake II that show from outside. Details and what is translucent show nothing.
static int visible_contents(const Maker *m, int contents) {
    if (contents & (II_DETAIL | II_TRANSLUCENT)) return 0;
    return contents & II_VISIBLE & (m->clear_water ? ~II_LIQUIDS : ~0);
}

static bool sight_passes(const Maker *m, int a, int b) {
    const QuakeLevel *level = m->level;
    if (is_opaque(level, a) || is_opaque(level, b)) return false;
    int one = level->leaves[a].contents, other = level->leaves[b].contents;
    if (level->format == QUAKE_IBSP38)
        return (one & II_VISIBLE) == (other & II_VISIBLE) ||
               visible_contents(m, one) == visible_contents(m, other);
    return substance(m, one) == substance(m, other);
}

// ---- portals

static bool touches_border(const Maker *m, const Piece *piece) {
    double slack = ON_PLANE / QUAKE_METRE;
    Box inside = box_grow(m->box, -slack);
    for (int i = 0; i < piece->count; i++) {
        if (!box_contains(inside, piece->corner[i])) return true;
    }
    return false;
}

// A piece between two leaves, its turn counter-clockwise seen from the first.
static bool add_piece(Maker *m, int front, int back, const Piece *piece) {
    QuakeCells *cells = m->cells;
    Building *b = &cells->building;
    int one = cells->cell_of_leaf[front], other = cells->cell_of_leaf[back];
    if (one < 0 || other < 0 || !sight_passes(m, front, back)) return true;
    double longest = 0, area = polygon_area(piece->corner, piece->count);
    for (int i = 0; i < piece->count; i++) {
        for (int k = 0; k < i; k++)
            longest = fmax(longest, vec3_length(vec3_sub(piece->corner[i], piece->corner[k])));
    }
    if (maps_portal_is_thin(piece->corner, piece->count) || area < longest * NARROWEST / QUAKE_METRE) {
        m->slivers++;
        return true;
    }
    if (touches_border(m, piece) && m->leaks++ == 0) m->leak = piece->corner[0];
    if (b->given_portal_count == MOST_PORTALS)
        return error_set(m->error, "%s: has more than %d portals", m->level->path, MOST_PORTALS);
    *ARENA_PUSH(m->arena, b->given_portals, b->given_portal_count, m->portal_capacity) =
        (GivenPortal){{one, other}, b->vertex_count, piece->count};
    for (int i = 0; i < piece->count; i++)
        *ARENA_PUSH(m->arena, b->vertices, b->vertex_count, b->vertex_capacity) = piece->corner[i];
    return true;
}

// The part of a piece on one side of a plane; false: the level is too much.
static bool cut(Maker *m, const Piece *in, Plane plane, int side, Piece *out) {
    double distance[MOST_CORNERS + 1], sign = side == 0 ? 1 : -1, slack = ON_PLANE / QUAKE_METRE;
    out->count = 0;
    if (++m->pieces > MOST_PIECES) {
        return error_set(m->error, "%s: the tree cuts its portals into more than %d pieces", m->level->path,
                         MOST_PIECES);
    }
    for (int i = 0; i < in->count; i++) distance[i] = sign * plane_distance(plane, in->corner[i]);
    int count = in->count > 0 ? polygon_clip_band(in->corner, distance, in->count, slack, out->corner) : 0;
    if (count > MOST_CORNERS) {
        return error_set(m->error, "%s: the tree cuts a portal of more than %d corners", m->level->path,
                         MOST_CORNERS);
    }
    bool lies_in = true, beyond = true;
    for (int i = 0; i < in->count; i++) {
        lies_in &= fabs(distance[i]) <= slack;
        beyond &= distance[i] <= slack;
    }
    out->count = count < 3 || (beyond && !lies_in) ? 0 : count;
    return true;
}

// Sends a piece down one side of a plane; `front`: the leaf on its other side, -1 while it is looked for. `behind`: where the piece goes
// on from that leaf.
static bool send(Maker *m, int child, const Piece *piece, int front, int behind) {
    if (piece->count == 0) return true;
    if (child < 0) return front < 0 ? send(m, behind, piece, ~child, 0) : add_piece(m, front, ~child, piece);
    const QuakeNode *node = &m->level->nodes[child];
    for (int side = 0; side < 2; side++) {
        Piece part;
        if (!cut(m, piece, m->level->planes[node->plane], side, &part) ||
            !send(m, node->child[side], &part, front, behind))
            return false;
    }
    return true;
}

// The square of a plane that holds all of it within the level's box, counter-clockwise about its normal.
static Piece square_of_plane(const Maker *m, Plane plane) {
    Vec3 middle = vec3_scale(vec3_add(m->box.min, m->box.max), 0.5), n = plane.n;
    double reach = vec3_length(vec3_sub(m->box.max, m->box.min));
    Vec3 at = vec3_sub(middle, vec3_scale(n, plane_distance(plane, middle)));
    Vec3 axis = fabs(n.z) < 0.7 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    Vec3 u = vec3_normalize(vec3_cross(axis, n)), v = vec3_cross(n, u);
    Piece out = {.count = 4};
    for (int i = 0; i < 4; i++) {
        double a = i == 0 || i == 3 ? -reach : reach, b = i < 2 ? -reach : reach;
        out.corner[i] = vec3_add(at, vec3_add(vec3_scale(u, a), vec3_scale(v, b)));
    }
    return out;
}

static bool within_box(Maker *m, Piece *piece) {
    for (int i = 0; i < 6; i++) {
        Vec3 n = {i % 3 == 0, i % 3 == 1, i % 3 == 2};
        Vec3 corner = i < 3 ? m->box.min : m->box.max;
        Piece part;
        if (!cut(m, piece, (Plane){n, vec3_dot(n, corner)}, i >= 3, &part)) return false;
        *piece = part;
    }
    return true;
}

// The way from the root to a node.
typedef struct Step {
    const struct Step *above;
    int node, side;
} Step;

static bool portals_of_node(Maker *m, const QuakeNode *node, const Step *above) {
    Plane plane = m->level->planes[node->plane];
    Piece piece = square_of_plane(m, plane), part;
    if (!within_box(m, &piece)) return false;
    for (const Step *s = above; s && piece.count > 0; s = s->above) {
        if (!cut(m, &piece, m->level->planes[m->level->nodes[s->node].plane], s->side, &part)) return false;
        piece = part;
    }
    return send(m, node->child[0], &piece, -1, node->child[1]);
}

static bool make_portals(Maker *m, int child, const Step *above) {
    if (child < 0) return true;
    const QuakeNode *node = &m->level->nodes[child];
    if (!portals_of_node(m, node, above)) return false;
    for (int side = 0; side < 2; side++) {
        if (!make_portals(m, node->child[side], &(Step){above, child, side})) return false;
    }
    return true;
}

bool quake_make_portals(const QuakeLevel *level, bool clear_water, Arena *arena, QuakeCells *cells,
                        Error *error) {
    Maker m = {.level = level,
               .clear_water = clear_water,
               .arena = arena,
               .cells = cells,
               .error = error,
               .box = box_grow(level->box, MARGIN / QUAKE_METRE)};
    if (!make_portals(&m, level->root, NULL)) return false;
    Building *b = &cells->building;
    if (m.slivers > 0) {
        building_note(arena, b, NOTE_DROPPED, vec3(0, 0, 0),
                      "%s: %d portals narrower than %g units count as closed", level->path, m.slivers,
                      NARROWEST);
    }
    if (m.leaks > 0) {
        building_note(
            arena, b, NOTE_LEAK, m.leak,
            "leak: %s is open to the void: %d portals reach %g units beyond its faces, the first at "
            "(%.0f, %.0f, %.0f) units",
            level->path, m.leaks, MARGIN, m.leak.x * QUAKE_METRE, m.leak.y * QUAKE_METRE,
            m.leak.z * QUAKE_METRE);
    }
    return true;
}
