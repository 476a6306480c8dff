// wad_regions.c - the convex pieces of a Doom map as regions: a prism each, between its sector's floor and ceiling.
//
// Regions that touch share their vertices, those too where the corner of one lies on the edge of another.
#include <stdlib.h>

#include "maps/doom/wad.h"

// A cell has at most 64 corners: a ring of more is cut along a chord.
enum { MOST_CORNERS = 60 };

// ---- corners of pieces as plan points in metres, and which of them lie on which edge
//
// Until here corners are exact; now each is rounded, once, so that all pieces have it as the same doubles. Whole map
// units fall on the grid of the plan. What does not may lie off the straight edge on which it lies in truth, by the last
// bit of a double; were that inwards, the piece would not be convex, and exact tests of sightlines, which rely on it,
// would lose whole ways through it. So such a corner is moved out of the piece in whose edge it lies, by no more than
// could show. It is a true corner to the pieces on its other side, which stay convex.

// How far a corner is moved past the chord of its neighbours, metres: a hundred times the rounding of coordinates of
// some kilometres; and how far at most, where corners are very near to one another.
static const double SAGITTA = 1e-10, FARTHEST = 1e-5;
enum { MOST_TURNS = 10000 };  // of pieces that wind around one another some thousand are needed

// A corner on an axis.
typedef struct Place {
    int axis;
    double along;
    int corner;
} Place;

typedef struct WadVertices {
    WadPoint *corners;  // [corner_count] of the pieces with a sector, each once, in order
    Vec2 *metres;       // [corner_count]
    bool *moved;        // [corner_count] out of the piece in whose edge it lies
    int corner_count;
    Place *places;  // those of axis i are places[first[i]] .. places[first[i + 1] - 1], in order along it
    int *first;     // [axis_count + 1]
} WadVertices;

static int by_axis_and_along(const void *p, const void *q) {
    const Place *a = p, *b = q;
    if (a->axis != b->axis) return a->axis < b->axis ? -1 : 1;
    return (a->along > b->along) - (a->along < b->along);
}

static int by_point(const void *p, const void *q) {
    const WadPoint *a = p, *b = q;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->w > b->w) - (a->w < b->w);
}

static WadPoint start_of(const WadPieces *p, const WadPiece *piece, int k) {
    return p->edges[piece->first_edge + k % piece->edge_count].from;
}

// -1 where no piece with a sector has a corner.
static int find_corner(const WadVertices *v, WadPoint at) {
    const WadPoint *found = bsearch(&at, v->corners, (size_t)v->corner_count, sizeof *v->corners, by_point);
    return found ? (int)(found - v->corners) : -1;
}

static void list_corners(const WadPieces *p, Arena *arena, WadVertices *v) {
    v->corners = ARENA_ARRAY(arena, WadPoint, p->edge_count + 1);
    int count = 0;
    for (int i = 0; i < p->piece_count; i++) {
        const WadPiece *piece = &p->pieces[i];
        for (int k = 0; piece->sector >= 0 && k < piece->edge_count; k++)
            v->corners[count++] = start_of(p, piece, k);
    }
    qsort(v->corners, (size_t)count, sizeof *v->corners, by_point);
    for (int i = 0; i < count; i++) {
        if (i > 0 && by_point(&v->corners[i], &v->corners[v->corner_count - 1]) == 0) continue;
        v->corners[v->corner_count++] = v->corners[i];
    }
    v->metres = ARENA_ARRAY(arena, Vec2, v->corner_count + 1);
    v->moved = ARENA_ARRAY(arena, bool, v->corner_count + 1);
    for (int i = 0; i < v->corner_count; i++) {
        WadPoint at = v->corners[i];
        v->metres[i] = vec2(wad_metres_of(wad_x(at)), wad_metres_of(wad_y(at)));
    }
}

// The edges of pieces outside count too: a piece may touch the edge of another with a corner alone.
static void list_places(const WadPieces *p, Arena *arena, WadVertices *v) {
    int count = 0, kept = 0;
    v->places = ARENA_ARRAY(arena, Place, 2 * (size_t)p->edge_count + 1);
    v->first = ARENA_ARRAY(arena, int, p->axis_count + 1);
    for (int i = 0; i < p->piece_count; i++) {
        const WadPiece *piece = &p->pieces[i];
        for (int k = 0; k < 2 * piece->edge_count; k++) {
            int axis = p->edges[piece->first_edge + k / 2].axis;
            WadPoint at = start_of(p, piece, k / 2 + k % 2);
            int corner = find_corner(v, at);
            if (corner >= 0) v->places[count++] = (Place){axis, wad_along(&p->axes[axis], at), corner};
        }
    }
    qsort(v->places, (size_t)count, sizeof *v->places, by_axis_and_along);
    for (int i = 0; i < count; i++) {
        if (kept > 0 && by_axis_and_along(&v->places[kept - 1], &v->places[i]) == 0) continue;
        v->places[kept++] = v->places[i];
    }
    for (int i = 0; i < kept; i++) v->first[v->places[i].axis + 1] = i + 1;
    for (int i = 0; i < p->axis_count; i++) {
        if (v->first[i + 1] < v->first[i]) v->first[i + 1] = v->first[i];
    }
}

// The places of an edge, its ends included: a run, first to last along the axis.
static const Place *run_of(const WadPieces *p, const WadVertices *v, const WadPiece *piece, int k,
                           int *count) {
    int axis = p->edges[piece->first_edge + k].axis;
    double from = wad_along(&p->axes[axis], start_of(p, piece, k)),
           to = wad_along(&p->axes[axis], start_of(p, piece, k + 1));
    Place key[2] = {{axis, fmin(from, to), 0}, {axis, fmax(from, to), 0}};
    int all = v->first[axis + 1] - v->first[axis];
    const Place *first = v->places + v->first[axis];
    const Place *low = bsearch(&key[0], first, (size_t)all, sizeof *first, by_axis_and_along);
    const Place *high = bsearch(&key[1], first, (size_t)all, sizeof *first, by_axis_and_along);
    *count = (int)(high - low) + 1;
    return low;
}

// An edge within which corners of other pieces lie.
typedef struct Chain {
    const Place *run;
    int count;
    int side;     // of the axis, on which its piece lies
    bool slants;  // the axis is along neither x nor y
} Chain;

static Chain *list_chains(const WadPieces *p, const WadVertices *v, Arena *scratch, int *count) {
    Chain *chains = NULL;
    int capacity = 0;
    *count = 0;
    for (int i = 0; i < p->piece_count; i++) {
        const WadPiece *piece = &p->pieces[i];
        for (int k = 0; piece->sector >= 0 && k < piece->edge_count; k++) {
            const WadEdge *edge = &p->edges[piece->first_edge + k];
            const WadAxis *axis = &p->axes[edge->axis];
            Chain chain = {.side = edge->side, .slants = axis->a != 0 && axis->b != 0};
            chain.run = run_of(p, v, piece, k, &chain.count);
            if (chain.count > 2) *ARENA_PUSH(scratch, chains, *count, capacity) = chain;
        }
    }
    return chains;
}

// On the grid, and along x or y, straight is exactly straight, until one of them is moved.
static bool is_straight(const WadVertices *v, const Chain *chain) {
    bool whole = true, moved = false;
    for (int i = 0; i < chain->count; i++) {
        whole = whole && v->corners[chain->run[i].corner].w == 1;
        moved = moved || v->moved[chain->run[i].corner];
    }
    return !moved && (whole || !chain->slants);
}

// Puts the corners within an edge out of its piece, on a parabola over the line through its ends. Returns how far the
// farthest of them went, metres.
static double bulge(WadVertices *v, const Chain *chain) {
    const Place *run = chain->run, *last = run + chain->count - 1;
    if (is_straight(v, chain)) return 0;
    Vec2 from = v->metres[run->corner], whole = vec2_sub(v->metres[last->corner], from);
    double length = vec2_length(whole), all = last->along - run->along, nearest = INFINITY, farthest = 0;
    for (int i = 1; i + 1 < chain->count; i++)
        nearest = fmin(nearest, (run[i].along - run[i - 1].along) * (run[i + 1].along - run[i].along));
    // `nearest` is a product of two lengths along the axis.
    double bend = fmin(SAGITTA * all * all / nearest, 4 * FARTHEST);
    Vec2 out = vec2_scale(vec2(-whole.y, whole.x), -chain->side / length);
    for (int i = 1; i + 1 < chain->count; i++) {
        double t = (run[i].along - run->along) / all;
        Vec2 *at = &v->metres[run[i].corner], old = *at;
        *at = vec2_add(vec2_add(from, vec2_scale(whole, t)), vec2_scale(out, bend * t * (1 - t)));
        farthest = fmax(farthest, vec2_length(vec2_sub(*at, old)));
        v->moved[run[i].corner] = true;
    }
    return farthest;
}

static WadVertices *list_vertices(const WadPieces *pieces, Arena *arena) {
    WadVertices *v = ARENA_ARRAY(arena, WadVertices, 1);
    Arena scratch = {0};
    int count;
    list_corners(pieces, arena, v);
    list_places(pieces, arena, v);
    Chain *chains = list_chains(pieces, v, &scratch, &count);
    // The ends of an edge may lie within other edges, and move in their turn: again until all rest.
    double farthest = INFINITY;
    for (int turn = 0; turn < MOST_TURNS && farthest > SAGITTA / 100; turn++) {
        farthest = 0;
        for (int i = 0; i < count; i++) farthest = fmax(farthest, bulge(v, &chains[i]));
    }
    arena_free(&scratch);
    return v;
}

typedef struct WadPlace {
    Vec2 at;       // metres
    double along;  // its edge's axis, map units
} WadPlace;

// Lists the corners on edge `k` of a piece with a sector, in the edge's direction, both ends included; returns how many there are.
static int edge_vertices(const WadPieces *p, const WadVertices *v, const WadPiece *piece, int k, Arena *arena,
                         WadPlace **out) {
    int count;
    const Place *run = run_of(p, v, piece, k, &count);
    bool forward = p->edges[piece->first_edge + k].side > 0;
    *out = ARENA_ARRAY(arena, WadPlace, count);
    for (int i = 0; i < count; i++) {
        const Place *place = &run[forward ? i : count - 1 - i];
        (*out)[i] = (WadPlace){v->metres[place->corner], place->along};
    }
    return count;
}

// ---- rings

typedef struct Outline {
    Vec2 *points;
    int *materials, *upper;  // of the wall on the edge from a point to the next one; above an opening there
    int count, point_capacity, material_capacity, upper_capacity;
} Outline;

static void add_point(Arena *scratch, Outline *o, Vec2 at, int material, int upper) {
    int count = o->count;
    *ARENA_PUSH(scratch, o->points, count, o->point_capacity) = at;
    count = o->count;
    *ARENA_PUSH(scratch, o->upper, count, o->upper_capacity) = upper;
    *ARENA_PUSH(scratch, o->materials, o->count, o->material_capacity) = material;
}

static Outline trace(WadBuilder *w, const WadVertices *vertices, const WadPiece *piece, Arena *scratch) {
    Outline out = {0};
    for (int k = 0; k < piece->edge_count; k++) {
        WadPlace *places;
        int count = edge_vertices(w->pieces, vertices, piece, k, scratch, &places);
        const WadEdge *edge = &w->pieces->edges[piece->first_edge + k];
        for (int i = 0; i + 1 < count; i++) {
            double middle = (places[i].along + places[i + 1].along) / 2;
            int upper = wad_wall_material(w, edge, piece->sector, middle, true), lower = upper;
            // A wall without an opening has one material.
            if (!wad_wall_is_upper(w, edge, piece->sector, middle))
                lower = wad_wall_material(w, edge, piece->sector, middle, false);
            add_point(scratch, &out, places[i].at, lower, upper);
        }
    }
    return out;
}

static double ring_area(const Vec2 *p, int count) {
    double area = 0;
    for (int i = 1; i + 1 < count; i++) area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
    return area / 2;
}

static void add_ring(WadBuilder *w, const Outline *o) {
    Building *b = w->building;
    *ARENA_PUSH(w->arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, o->count};
    for (int i = 0; i < o->count; i++) {
        int count = b->point_count;
        *ARENA_PUSH(w->arena, b->edge_material, count, b->edge_capacity) = o->materials[i];
        count = b->point_count;
        *ARENA_PUSH(w->arena, b->edge_upper, count, b->edge_upper_capacity) = o->upper[i];
        *ARENA_PUSH(w->arena, b->points, b->point_count, b->point_capacity) = o->points[i];
    }
}

static void add_region(WadBuilder *w, int sector, const Outline *o) {
    Building *b = w->building;
    const WadMover *mover = &w->movers[sector];
    const WadSector *s = &w->map->sectors[sector];
    *ARENA_PUSH(w->arena, b->regions, b->region_count, b->region_capacity) =
        (Region){.kind = REGION_ROOM,
                 .name = arena_format(w->arena, "sector %d", sector),
                 .opening = -1,
                 .first_ring = b->ring_count,
                 .ring_count = 1,
                 .z0 = wad_metres_of(mover->floor),
                 .z1 = wad_metres_of(mover->ceiling),
                 .floor_material = wad_level_material(w, s->floor_flat, sector),
                 .ceiling_material = wad_level_material(w, s->ceiling_flat, sector)};
    add_ring(w, o);
}

static Outline part_of(const Outline *o, int from, int count, Arena *scratch) {
    Outline part = {.points = ARENA_ARRAY(scratch, Vec2, count),
                    .materials = ARENA_ARRAY(scratch, int, count),
                    .upper = ARENA_ARRAY(scratch, int, count),
                    .count = count};
    for (int i = 0; i < count; i++) {
        part.points[i] = o->points[(from + i) % o->count];
        part.materials[i] = o->materials[(from + i) % o->count];
        part.upper[i] = o->upper[(from + i) % o->count];
    }
    return part;
}

// Rings with very many corners are halved along the chord that leaves the larger smaller half.
static void add_regions(WadBuilder *w, int sector, const Outline *o, Arena *scratch) {
    if (o->count <= MOST_CORNERS) {
        add_region(w, sector, o);
        return;
    }
    int half = o->count / 2, best = 0;
    double most = -INFINITY;
    Outline part[2];
    for (int i = 0; i < half; i++) {
        part[0] = part_of(o, i, half + 1, scratch);
        part[1] = part_of(o, i + half, o->count - half + 1, scratch);
        double least =
            fmin(ring_area(part[0].points, part[0].count), ring_area(part[1].points, part[1].count));
        if (least > most) most = least, best = i;
    }
    part[0] = part_of(o, best, half + 1, scratch);
    part[1] = part_of(o, best + half, o->count - half + 1, scratch);
    for (int k = 0; k < 2; k++) add_regions(w, sector, &part[k], scratch);
}

void wad_add_regions(WadBuilder *w) {
    const WadPieces *p = w->pieces;
    Arena scratch = {0}, ring = {0};
    const WadVertices *vertices = list_vertices(p, &scratch);
    w->first_region = ARENA_ARRAY(w->scratch, int, p->piece_count + 1);
    wad_begin_materials(w);
    for (int i = 0; i < p->piece_count; i++) {
        const WadPiece *piece = &p->pieces[i];
        w->first_region[i] = w->building->region_count;
        if (piece->sector < 0 || w->movers[piece->sector].floor >= w->movers[piece->sector].ceiling) continue;
        arena_reset(&ring);
        Outline outline = trace(w, vertices, piece, &ring);
        add_regions(w, piece->sector, &outline, &ring);
    }
    w->first_region[p->piece_count] = w->building->region_count;
    arena_free(&scratch);
    arena_free(&ring);
}
