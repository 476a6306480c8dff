// enclose_cover.c - which walls, implicit walls, fillings, rooms, openings and cut-outs of the sketch cover each face of the plan.
//
// A face is covered by a shape in which its inner point lies. Faces too narrow to be meant, slivers, take a neighbour's labels.
#include "maps/enclose/enclose.h"

// Mean width (twice the area over the perimeter) below which a face is noise of the grid and goes to its
// neighbour, mm.
static const double SLIVER = 2.5;
// Neighbours of one kind count from this share of a sliver's outline on: its two long sides are half each.
static const double GOOD_PART = 0.2;

static double distance_to_outline(const Shape *shape, Vec2 p) {
    double best = INFINITY;
    for (int i = 0, n = shape->ring[1]; i < n; i++) {
        Vec2 a = shape->points[i], d = vec2_sub(shape->points[(i + 1) % n], a), ap = vec2_sub(p, a);
        double t = fmin(1, fmax(0, vec2_dot(ap, d) / vec2_dot(d, d)));
        best = fmin(best, vec2_length(vec2_sub(ap, vec2_scale(d, t))));
    }
    return best;
}

// The room with an implicit wall whose outline is nearest to p, searched within `reach`, mm; -1: none.
static int nearest_owner(Enclosure *e, int storey, Vec2 p, double reach) {
    int owner = -1;
    double best = INFINITY;
    // Searches a little farther, so that rounding hides no outline that is as near as another.
    box_tree_find(&e->room_tree, enclose_around(p, reach + MAPS_GRID, storey), e->scratch, &e->near);
    for (int k = 0; k < e->near.count; k++) {
        int i = e->near.items[k];
        if (e->room_wall[i] <= 0) continue;
        double d = distance_to_outline(&e->rooms[i], p);
        if (d >= best) continue;
        best = d;
        owner = i;
    }
    return owner;
}

static Spot *spots_of(const Pass *pass, int storey) {
    return pass->spots + (size_t)storey * (size_t)pass->plan.face_count;
}

typedef struct Cover {
    int face, wall;
} Cover;

typedef struct Covers {
    Cover *items;
    int count, capacity;
} Covers;

static void list_covers(Enclosure *e, Pass *pass, const Covers *covers) {
    int faces = pass->plan.face_count;
    pass->cover_first = ARENA_ARRAY(e->scratch, int, faces + 2);
    pass->cover_wall = ARENA_ARRAY(e->scratch, int, covers->count);
    for (int i = 0; i < covers->count; i++) pass->cover_first[covers->items[i].face + 2]++;
    for (int f = 0; f < faces; f++) pass->cover_first[f + 2] += pass->cover_first[f + 1];
    for (int i = 0; i < covers->count; i++)
        pass->cover_wall[pass->cover_first[covers->items[i].face + 1]++] = covers->items[i].wall;
}

static void label_walls(Enclosure *e, Pass *pass) {
    const Sketch *s = e->sketch;
    Covers covers = {NULL, 0, 0};
    for (int i = 0; i < s->wall_count; i++) {
        if (!e->wall_bounds[i]) continue;
        Spot *spots = spots_of(pass, s->walls[i].storey);
        for (int k = plan_faces_in(e, &pass->plan, &e->walls[i]); k-- > 0;) {
            Spot *spot = &spots[e->faces.items[k]];
            if (spot->wall == NO_WALL) spot->wall = i;
            *ARENA_PUSH(e->scratch, covers.items, covers.count, covers.capacity) =
                (Cover){e->faces.items[k], i};
        }
    }
    list_covers(e, pass, &covers);
}

// Marks the faces that lie in a room's grown outline and in no room that has a wall.
static void label_implicit_walls(Enclosure *e, Pass *pass) {
    const Plan *p = &pass->plan;
    bool *inside = ARENA_ARRAY(e->scratch, bool, (size_t)e->b->storey_count *(size_t)p->face_count);
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (!e->room_used[i] || e->room_wall[i] <= 0) continue;
        bool *here = inside + (size_t)e->sketch->rooms[i].storey * (size_t)p->face_count;
        for (int k = plan_faces_in(e, p, &e->rooms[i]); k-- > 0;) here[e->faces.items[k]] = true;
    }
    for (int i = 0; i < e->grown_count; i++) {
        int room = e->grown[i].room, storey = e->sketch->rooms[room].storey;
        const bool *here = inside + (size_t)storey * (size_t)p->face_count;
        Spot *spots = spots_of(pass, storey);
        for (int k = plan_faces_in(e, p, &e->grown[i].shape); k-- > 0;) {
            int f = e->faces.items[k];
            if (spots[f].wall != NO_WALL || here[f]) continue;
            Vec2 inner = p->faces[f].inner;
            spots[f].wall = WALL_IMPLICIT;
            spots[f].owner = nearest_owner(e, storey, inner, distance_to_outline(&e->rooms[room], inner));
        }
    }
}

// Labels the faces in fillings, one list a storey, that are no wall yet.
static void label_fillings(Enclosure *e, Pass *pass, const ShapeList *fillings, int wall) {
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        Spot *spots = spots_of(pass, storey);
        for (int i = 0; i < fillings[storey].count; i++) {
            for (int k = plan_faces_in(e, &pass->plan, &fillings[storey].items[i]); k-- > 0;) {
                Spot *spot = &spots[e->faces.items[k]];
                if (spot->wall == NO_WALL) spot->wall = wall;
            }
        }
    }
}

static void label_rooms(Enclosure *e, Pass *pass) {
    const Sketch *s = e->sketch;
    for (int i = 0; i < s->room_count; i++) {
        if (!e->room_used[i]) continue;
        Spot *spots = spots_of(pass, s->rooms[i].storey);
        for (int k = plan_faces_in(e, &pass->plan, &e->rooms[i]); k-- > 0;) {
            Spot *spot = &spots[e->faces.items[k]];
            if (spot->room < 0) spot->room = i;
        }
    }
    for (int i = 0; i < s->cutout_count; i++) {
        if (!e->cutout_used[i]) continue;
        Spot *spots = spots_of(pass, s->cutouts[i].storey);
        for (int k = plan_faces_in(e, &pass->plan, &e->cutouts[i]); k-- > 0;) {
            Spot *spot = &spots[e->faces.items[k]];
            if (spot->cutout < 0) spot->cutout = i;
        }
    }
}

// Openings may stand above one another; where they overlap, the first one wins.
static void place_hole(const Enclosure *e, Spot *spot, int hole) {
    const Hole *h = &e->holes[hole];
    for (int k = 0; k < SPOT_HOLES; k++) {
        if (spot->hole[k] < 0) {
            spot->hole[k] = hole;
            return;
        }
        const Hole *other = &e->holes[spot->hole[k]];
        if (h->sill < other->head && other->sill < h->head) return;
    }
}

static void label_holes(Enclosure *e, Pass *pass) {
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (!e->holes[i].used) continue;
        Spot *spots = spots_of(pass, e->sketch->openings[i].storey);
        for (int k = plan_faces_in(e, &pass->plan, &e->holes[i].box); k-- > 0;)
            place_hole(e, &spots[e->faces.items[k]], i);
    }
}

// The neighbour whose labels a sliver takes: the one with the longest common edge. Open neighbours go before
// openings, and openings before walls, if they run along a good part of the sliver, so that no sliver of wall stands
// between an opening and a room. -1: no neighbour is settled.
static int neighbour_of_sliver(const Plan *p, const Spot *spots, const bool *settled, int face) {
    double along[3] = {0, 0, 0}, longest[3] = {0, 0, 0};
    int best[3] = {-1, -1, -1};
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int h = p->halves[p->faces[face].first_half + k], g = half_right(p, h);
        if (g < 0 || !settled[g]) continue;
        int rank = spot_is_open(&spots[g]) ? 0 : spots[g].hole[0] >= 0 ? 1 : 2;
        along[rank] += half_length(p, h);
        if (half_length(p, h) <= longest[rank]) continue;
        longest[rank] = half_length(p, h);
        best[rank] = g;
    }
    for (int rank = 0; rank < 3; rank++) {
        if (best[rank] >= 0 && along[rank] >= GOOD_PART * p->faces[face].perimeter) return best[rank];
    }
    for (int rank = 2; rank >= 0; rank--) {
        if (best[rank] >= 0) return best[rank];
    }
    return -1;
}

// Gives slivers, which lie between lines that nearly coincide, a neighbour's labels. This takes rounds, since some slivers lie
// beside others.
static void absorb_slivers(Enclosure *e, Pass *pass) {
    enum { ROUNDS = 4 };
    const Plan *p = &pass->plan;
    bool *settled = ARENA_ARRAY(e->scratch, bool, p->face_count),
         *now = ARENA_ARRAY(e->scratch, bool, p->face_count);
    for (int f = 0; f < p->face_count; f++)
        settled[f] = face_width(p->faces[f].area, p->faces[f].perimeter) >= SLIVER;
    for (int round = 0; round < ROUNDS; round++) {
        memcpy(now, settled, (size_t)p->face_count * sizeof *now);
        for (int f = 0; f < p->face_count; f++) {
            for (int storey = 0; !settled[f] && storey < e->b->storey_count; storey++) {
                Spot *spots = spots_of(pass, storey);
                int best = neighbour_of_sliver(p, spots, settled, f);
                if (best < 0) continue;
                spots[f] = spots[best];
                now[f] = true;
            }
        }
        memcpy(settled, now, (size_t)p->face_count * sizeof *now);
    }
}

void cover_label(Enclosure *e, Pass *pass, bool with_plugs) {
    size_t count = (size_t)e->b->storey_count * (size_t)pass->plan.face_count;
    pass->spots = ARENA_ARRAY(e->scratch, Spot, count);
    for (size_t i = 0; i < count; i++) pass->spots[i] = (Spot){NO_WALL, {-1, -1, -1, -1}, -1, -1, -1, -1, -1};
    label_walls(e, pass);
    label_implicit_walls(e, pass);
    label_fillings(e, pass, e->slits, WALL_SLIT);
    if (with_plugs) label_fillings(e, pass, e->plugs, WALL_PLUG);
    label_rooms(e, pass);
    label_holes(e, pass);
    absorb_slivers(e, pass);
}
