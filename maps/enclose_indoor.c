// enclose_indoor.c - what is a wall, a room, a terrace or the open air at every face of the plan, storey by
// storey.
//
// Faces that are neither wall nor opening hang together across room edges; what hangs together with the edge
// of the world is outdoors, the rest is enclosed. Within, drawn rooms give the names, and room edges stay
// open portals. Rooms that hang together with the outdoors are kept as rooms where walls or other rooms run
// along most of their outline (a leak), else they are terraces.
#include <stdlib.h>

#include "engine/core/predicates.h"
#include "maps/enclose.h"

// Mean width (twice the area over the perimeter) below which a face is noise of the grid and goes to its
// neighbour, mm.
static const double SLIVER = 2.5;
// A neighbour counts along this share of a sliver's outline: its two long sides are half each.
static const double GOOD_PART = 0.2;
// Undrawn strips between rooms and walls narrower than this belong to the room; enclosed cavities narrower
// than this are part of the walls, mm.
static const double NARROW = 250;
// Strips of a room beyond the wall, drawn so by mistake, mm.
static const double STRAY = 100;
// A room that lies open stays a room if this share of its outline is closed.
static const double CLOSED_SHARE = 0.5;
// An outline this near to a wall counts as closed, mm; how densely that is asked.
static const double NEAR_WALL = 250, PROBE = 200;
// A room that keeps less than this share of its area is lost.
static const double LEAST_KEPT = 0.1;
// Overlaps of rooms and losses of openings below are not worth a note, mm^2 and share.
static const double SMALL_OVERLAP = 5e4, SMALL_LOSS = 0.2;

static int find(int *parent, int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

static void unite(int *parent, int a, int b) {
    a = find(parent, a);
    b = find(parent, b);
    if (a != b) parent[a > b ? a : b] = a < b ? a : b;
}

static bool is_open(const Spot *s) { return s->wall == NO_WALL && s->hole[0] < 0; }

// ---- which sources cover a face

// The faces whose inner point lies in the shape, in the order of x.
static int faces_in(const Plan *p, const Shape *shape, int *out) {
    int low = 0, high = p->face_count, count = 0;
    while (low < high) {
        int middle = (low + high) / 2;
        if (p->faces[p->by_x[middle]].inner.x < shape->min.x)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < p->face_count && p->faces[p->by_x[low]].inner.x <= shape->max.x; low++) {
        if (shape_contains(shape, p->faces[p->by_x[low]].inner)) out[count++] = p->by_x[low];
    }
    return count;
}

static double distance_to_outline(const Shape *shape, Vec2 p) {
    double best = INFINITY;
    for (int i = 0, n = shape->ring[1]; i < n; i++) {
        Vec2 a = shape->points[i], d = vec2_sub(shape->points[(i + 1) % n], a), ap = vec2_sub(p, a);
        double t = fmin(1, fmax(0, vec2_dot(ap, d) / vec2_dot(d, d)));
        best = fmin(best, vec2_length(vec2_sub(ap, vec2_scale(d, t))));
    }
    return best;
}

static int nearest_owner(const Enclosure *e, int storey, Vec2 p) {
    int owner = -1;
    double best = INFINITY;
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (!e->room_used[i] || e->sketch->rooms[i].storey != storey || e->room_wall[i] <= 0) continue;
        double d = distance_to_outline(&e->rooms[i], p);
        if (d >= best) continue;
        best = d;
        owner = i;
    }
    return owner;
}

static void label_walls(Enclosure *e, Pass *pass, bool with_plugs, int *faces) {
    const Sketch *s = e->sketch;
    const Plan *p = &pass->plan;
    for (int i = 0; i < s->wall_count; i++) {
        if (!e->wall_bounds[i]) continue;
        Spot *spots = pass->spots + (size_t)s->walls[i].storey * (size_t)p->face_count;
        for (int k = faces_in(p, &e->walls[i], faces); k-- > 0;) {
            if (spots[faces[k]].wall == NO_WALL) spots[faces[k]].wall = i;
        }
    }
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        Spot *spots = pass->spots + (size_t)storey * (size_t)p->face_count;
        for (int way = 0; way < 1 + with_plugs; way++) {
            const ShapeList *list = way ? &e->plugs[storey] : &e->implicit[storey];
            for (int i = 0; i < list->count; i++) {
                for (int k = faces_in(p, &list->items[i], faces); k-- > 0;) {
                    Spot *spot = &spots[faces[k]];
                    if (spot->wall != NO_WALL) continue;
                    spot->wall = way ? WALL_PLUG : WALL_IMPLICIT;
                    if (!way) spot->owner = nearest_owner(e, storey, p->faces[faces[k]].inner);
                }
            }
        }
    }
}

static void label_rooms(Enclosure *e, Pass *pass, int *faces) {
    const Sketch *s = e->sketch;
    const Plan *p = &pass->plan;
    for (int i = 0; i < s->room_count; i++) {
        if (!e->room_used[i]) continue;
        Spot *spots = pass->spots + (size_t)s->rooms[i].storey * (size_t)p->face_count;
        for (int k = faces_in(p, &e->rooms[i], faces); k-- > 0;) {
            if (spots[faces[k]].room < 0) spots[faces[k]].room = i;
        }
    }
    for (int i = 0; i < s->cutout_count; i++) {
        if (!e->cutout_used[i]) continue;
        Spot *spots = pass->spots + (size_t)s->cutouts[i].storey * (size_t)p->face_count;
        for (int k = faces_in(p, &e->cutouts[i], faces); k-- > 0;) {
            if (spots[faces[k]].cutout < 0) spots[faces[k]].cutout = i;
        }
    }
}

// Openings may stand above one another; where they overlap, the first one wins.
static bool place_hole(const Enclosure *e, Spot *spot, int hole) {
    const Hole *h = &e->holes[hole];
    for (int k = 0; k < SPOT_HOLES; k++) {
        if (spot->hole[k] < 0) {
            spot->hole[k] = hole;
            return true;
        }
        const Hole *other = &e->holes[spot->hole[k]];
        if (h->sill < other->head && other->sill < h->head) return false;
    }
    return false;
}

static void label_holes(Enclosure *e, Pass *pass, int *faces) {
    const Sketch *s = e->sketch;
    const Plan *p = &pass->plan;
    for (int i = 0; i < s->opening_count; i++) {
        if (!e->holes[i].used) continue;
        Spot *spots = pass->spots + (size_t)s->openings[i].storey * (size_t)p->face_count;
        for (int k = faces_in(p, &e->holes[i].box, faces); k-- > 0;) place_hole(e, &spots[faces[k]], i);
    }
}

static double mean_width(double area, double perimeter) { return perimeter > 0 ? 2 * area / perimeter : 0; }

// What a sliver takes after: the neighbour with the longest common edge, an open one before an opening
// before a wall if it runs along a good part of the sliver, so that no sliver of wall stands between an
// opening and a room.
static int neighbour_of_sliver(const Plan *p, const Spot *spots, const bool *settled, int face) {
    double along[3] = {0, 0, 0}, longest[3] = {0, 0, 0};
    int best[3] = {-1, -1, -1};
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int h = p->halves[p->faces[face].first_half + k], g = half_right(p, h);
        if (g < 0 || !settled[g]) continue;
        int rank = is_open(&spots[g]) ? 0 : spots[g].hole[0] >= 0 ? 1 : 2;
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

// Slivers lie between lines that nearly coincide. In rounds, since some lie beside others.
static void absorb_slivers(Enclosure *e, Pass *pass) {
    enum { ROUNDS = 4 };
    const Plan *p = &pass->plan;
    bool *settled = ARENA_ARRAY(e->scratch, bool, p->face_count),
         *now = ARENA_ARRAY(e->scratch, bool, p->face_count);
    for (int f = 0; f < p->face_count; f++)
        settled[f] = mean_width(p->faces[f].area, p->faces[f].perimeter) >= SLIVER;
    for (int round = 0; round < ROUNDS; round++) {
        memcpy(now, settled, (size_t)p->face_count * sizeof *now);
        for (int f = 0; f < p->face_count; f++) {
            for (int storey = 0; !settled[f] && storey < e->b->storey_count; storey++) {
                Spot *spots = pass->spots + (size_t)storey * (size_t)p->face_count;
                int best = neighbour_of_sliver(p, spots, settled, f);
                if (best < 0) continue;
                spots[f] = spots[best];
                now[f] = true;
            }
        }
        memcpy(settled, now, (size_t)p->face_count * sizeof *now);
    }
}

// ---- patches: faces that hang together and are covered by the same drawn room or by none

typedef struct Patch {
    int room, face;  // drawn room or -1; its first face
    double area, perimeter;
    bool outside;  // hangs together with the edge of the world
    bool world;    // reaches the edge of the world without crossing a room's edge
    bool candidate, indoor, narrow;
    double closed;  // length of its outline that is closed
    int id;         // as Spot.indoor
} Patch;

typedef struct Patches {
    Patch *items;
    int *of;  // [face_count] patch, -1: not open
    int count;
} Patches;

static Patches find_patches(Enclosure *e, const Plan *p, const Spot *spots) {
    int *part = ARENA_ARRAY(e->scratch, int, p->face_count),
        *patch = ARENA_ARRAY(e->scratch, int, p->face_count + 1);
    Patches out = {ARENA_ARRAY(e->scratch, Patch, p->face_count), ARENA_ARRAY(e->scratch, int, p->face_count),
                   0};
    int world = p->face_count;  // stands for what lies beyond the world
    int *whole = ARENA_ARRAY(e->scratch, int, p->face_count + 1);
    for (int f = 0; f <= p->face_count; f++) patch[f] = whole[f] = f;
    for (int i = 0; i < p->edge_count; i++) {
        int f = p->edges[i].face[0] < 0 ? world : p->edges[i].face[0];
        int g = p->edges[i].face[1] < 0 ? world : p->edges[i].face[1];
        if ((f < world && !is_open(&spots[f])) || (g < world && !is_open(&spots[g]))) continue;
        unite(whole, f, g);
        int rf = f < world ? spots[f].room : -1, rg = g < world ? spots[g].room : -1;
        if (rf == rg) unite(patch, f, g);
    }
    for (int f = 0; f < p->face_count; f++) part[f] = -1;
    for (int f = 0; f < p->face_count; f++) {
        out.of[f] = -1;
        if (!is_open(&spots[f])) continue;
        int root = find(patch, f);
        if (part[root] < 0) {
            part[root] = out.count;
            out.items[out.count++] = (Patch){.room = spots[f].room,
                                             .face = f,
                                             .id = -1,
                                             .outside = find(whole, f) == find(whole, world),
                                             .world = root == find(patch, world)};
        }
        out.of[f] = part[root];
        out.items[out.of[f]].area += p->faces[f].area;
    }
    for (int i = 0; i < p->edge_count; i++) {
        for (int way = 0; way < 2; way++) {
            int f = p->edges[i].face[way], g = p->edges[i].face[!way];
            if (f < 0 || out.of[f] < 0 || (g >= 0 && out.of[g] == out.of[f])) continue;
            out.items[out.of[f]].perimeter += half_length(p, 2 * i);
        }
    }
    return out;
}

static bool wall_at(const Enclosure *e, int storey, Vec2 p) {
    for (int i = 0; i < e->sketch->wall_count; i++) {
        if (e->wall_bounds[i] && e->sketch->walls[i].storey == storey && shape_contains(&e->walls[i], p))
            return true;
    }
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (e->holes[i].used && e->sketch->openings[i].storey == storey &&
            shape_contains(&e->holes[i].box, p))
            return true;
    }
    return false;
}

// The length of half-edge h behind which a wall stands near.
static double length_near_wall(const Enclosure *e, const Plan *p, int storey, int h) {
    Vec2 a = p->vertices[half_from(p, h)], d = vec2_sub(p->vertices[half_to(p, h)], a);
    double length = vec2_length(d);
    Vec2 out = vec2_scale(vec2(d.y, -d.x), 1 / length);
    int probes = 1 + (int)fmin(length / PROBE, 200), near = 0;
    for (int i = 0; i < probes; i++) {
        Vec2 at = vec2_add(a, vec2_scale(d, (i + 0.5) / probes));
        for (int k = 1; k <= 4; k++) {
            if (!wall_at(e, storey, vec2_add(at, vec2_scale(out, NEAR_WALL * k / 4)))) continue;
            near++;
            break;
        }
    }
    return length * near / probes;
}

// Which open patches stay rooms: drops candidates that are mostly open until none is.
static void judge_candidates(Enclosure *e, const Plan *p, int storey, Patches *patches) {
    for (int i = 0; i < patches->count; i++) {
        Patch *patch = &patches->items[i];
        patch->candidate = patch->outside && !patch->world;
    }
    double *near = ARENA_ARRAY(e->scratch, double, p->edge_count);
    for (int i = 0; i < p->edge_count; i++) near[i] = -1;
    for (bool changed = true; changed;) {
        changed = false;
        for (int i = 0; i < patches->count; i++) patches->items[i].closed = 0;
        for (int i = 0; i < p->edge_count; i++) {
            for (int way = 0; way < 2; way++) {
                int f = p->edges[i].face[way], g = p->edges[i].face[!way];
                if (f < 0 || patches->of[f] < 0 || !patches->items[patches->of[f]].candidate) continue;
                if (g >= 0 && patches->of[g] == patches->of[f]) continue;
                bool open = g < 0 || (patches->of[g] >= 0 && !patches->items[patches->of[g]].candidate);
                if (open && near[i] < 0) near[i] = length_near_wall(e, p, storey, 2 * i + way);
                patches->items[patches->of[f]].closed += open ? near[i] : half_length(p, 2 * i);
            }
        }
        for (int i = 0; i < patches->count; i++) {
            Patch *patch = &patches->items[i];
            if (!patch->candidate || patch->closed >= CLOSED_SHARE * patch->perimeter) continue;
            patch->candidate = false;
            changed = true;
        }
    }
}

// Narrow strips take the name of the indoor neighbour with the longest common edge.
static void settle_narrow(const Plan *p, Patches *patches, double *longest, int *target) {
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < patches->count; i++) {
            longest[i] = 0;
            target[i] = -1;
        }
        for (int i = 0; i < p->edge_count; i++) {
            for (int way = 0; way < 2; way++) {
                int f = p->edges[i].face[way], g = p->edges[i].face[!way];
                int a = f < 0 ? -1 : patches->of[f], c = g < 0 ? -1 : patches->of[g];
                if (a < 0 || c < 0 || a == c || !patches->items[a].narrow || patches->items[a].id >= 0)
                    continue;
                if (patches->items[c].id < 0 || half_length(p, 2 * i) <= longest[a]) continue;
                longest[a] = half_length(p, 2 * i);
                target[a] = patches->items[c].id;
            }
        }
        for (int i = 0; i < patches->count; i++) {
            if (target[i] >= 0) patches->items[i].id = target[i];
        }
    }
}

static int new_space(Enclosure *e, Pass *pass, int storey) {
    *ARENA_PUSH(e->scratch, pass->space_storey, pass->space_count, pass->space_capacity) = storey;
    return e->sketch->room_count + pass->space_count - 1;
}

// Names the indoor patches. Narrow ones wait for a neighbour, unless they are all that there is of a room.
static void name_patches(Enclosure *e, Pass *pass, int storey, Patches *patches) {
    int rooms = e->sketch->room_count;
    int *largest = ARENA_ARRAY(e->scratch, int, rooms),
        *target = ARENA_ARRAY(e->scratch, int, patches->count);
    double *longest = ARENA_ARRAY(e->scratch, double, patches->count);
    for (int i = 0; i < rooms; i++) largest[i] = -1;
    for (int i = 0; i < patches->count; i++) {
        Patch *patch = &patches->items[i];
        patch->indoor = !patch->outside || patch->candidate;
        int r = patch->room;
        if (patch->indoor && r >= 0 && (largest[r] < 0 || patch->area > patches->items[largest[r]].area))
            largest[r] = i;
    }
    for (int i = 0; i < patches->count; i++) {
        Patch *patch = &patches->items[i];
        double width = mean_width(patch->area, patch->perimeter);
        patch->narrow = patch->room >= 0 ? largest[patch->room] != i && width < STRAY : width < NARROW;
        if (patch->indoor && !patch->narrow)
            patch->id = patch->room >= 0 ? patch->room : new_space(e, pass, storey);
    }
    settle_narrow(&pass->plan, patches, longest, target);
    for (int i = 0; i < patches->count; i++) {
        Patch *patch = &patches->items[i];
        if (patch->indoor && patch->id < 0 && patch->room >= 0) patch->id = patch->room;
    }
}

static void label_storey(Enclosure *e, Pass *pass, int storey) {
    const Plan *p = &pass->plan;
    Spot *spots = pass->spots + (size_t)storey * (size_t)p->face_count;
    Patches patches = find_patches(e, p, spots);
    judge_candidates(e, p, storey, &patches);
    name_patches(e, pass, storey, &patches);
    double enclosed = 0;
    for (int f = 0; f < p->face_count; f++) {
        if (patches.of[f] < 0) continue;
        const Patch *patch = &patches.items[patches.of[f]];
        if (patch->indoor && patch->id >= 0) {
            spots[f].indoor = patch->id;
            if (!patch->outside)
                enclosed += p->faces[f].area;
            else
                pass->leaking = true;
        } else if (patch->indoor) {
            spots[f].wall = WALL_CAVITY;
        } else if (patch->room >= 0 && mean_width(patch->area, patch->perimeter) >= STRAY) {
            spots[f].terrace = patch->room;
            pass->leaking = true;
        }
    }
    pass->enclosed += enclosed;
    if (enclosed == 0) pass->leaking = true;
}

void indoor_label(Enclosure *e, Pass *pass, bool with_plugs) {
    const Plan *p = &pass->plan;
    size_t count = (size_t)e->b->storey_count * (size_t)p->face_count;
    pass->spots = ARENA_ARRAY(e->scratch, Spot, count);
    for (size_t i = 0; i < count; i++) pass->spots[i] = (Spot){NO_WALL, {-1, -1}, -1, -1, -1, -1, -1};
    int *faces = ARENA_ARRAY(e->scratch, int, p->face_count);
    label_walls(e, pass, with_plugs, faces);
    label_rooms(e, pass, faces);
    label_holes(e, pass, faces);
    absorb_slivers(e, pass);
    for (int storey = 0; storey < e->b->storey_count; storey++) label_storey(e, pass, storey);
}

// ---- reports

typedef struct RoomAreas {
    double drawn, overlapped, open, kept, terrace;
} RoomAreas;

static void measure_rooms(Enclosure *e, RoomAreas *areas) {
    const Plan *p = &e->pass.plan;
    int *faces = ARENA_ARRAY(e->scratch, int, p->face_count);
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (!e->room_used[i]) continue;
        const Spot *spots = e->pass.spots + (size_t)e->sketch->rooms[i].storey * (size_t)p->face_count;
        for (int k = faces_in(p, &e->rooms[i], faces); k-- > 0;) {
            const Spot *spot = &spots[faces[k]];
            double area = p->faces[faces[k]].area;
            if (spot->room != i) {
                if (is_open(spot)) areas[i].overlapped += area;
                continue;
            }
            areas[i].drawn += area;
            if (is_open(spot)) areas[i].open += area;
            if (spot->indoor >= 0) areas[i].kept += area;
            if (spot->terrace >= 0) areas[i].terrace += area;
        }
    }
}

static void report_room(Enclosure *e, int i, const RoomAreas *a) {
    const SketchRoom *r = &e->sketch->rooms[i];
    Vec3 p = enclose_place(e, e->rooms[i].points[0], r->storey);
    const char *name = enclose_text(r->place);
    double m2 = ENCLOSE_MM * ENCLOSE_MM, usable = a->kept + a->terrace;
    double lost = usable < LEAST_KEPT * a->drawn ? a->drawn : fmax(0, a->open - usable);
    e->b->drawn_area += a->drawn / m2;
    e->b->lost_area += lost / m2;
    if (a->overlapped > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) overlaps earlier ones by %.2f m^2: they keep it", name, p.x, p.y,
                      a->overlapped / m2);
    }
    if (a->drawn <= 0 || lost == a->drawn) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f) left out: walls or other rooms cover its %.2f m^2", name, p.x, p.y,
                      (a->drawn + a->overlapped) / m2);
    } else if (lost > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f): %.2f of its %.2f m^2 lie outside the walls and are left out", name,
                      p.x, p.y, lost / m2, a->drawn / m2);
    }
    if (a->terrace > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) is not enclosed: %.2f m^2 of it are a terrace", name, p.x, p.y,
                      a->terrace / m2);
    }
}

static void report_holes(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    int *faces = ARENA_ARRAY(e->scratch, int, p->face_count);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used) continue;
        int storey = e->sketch->openings[i].storey;
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        double kept = 0, lost = 0;
        int other = -1;
        for (int k = faces_in(p, &h->box, faces); k-- > 0;) {
            const Spot *spot = &spots[faces[k]];
            if (spot->hole[0] == i || spot->hole[1] == i) {
                kept += p->faces[faces[k]].area;
            } else {
                lost += p->faces[faces[k]].area;
                if (spot->hole[0] >= 0) other = spot->hole[0];
            }
        }
        Vec3 at = enclose_place(e, h->centre, storey);
        const char *name = enclose_text(e->sketch->openings[i].place);
        const char *by = other >= 0 ? enclose_text(e->sketch->openings[other].place) : "its own thinness";
        if (kept <= 0) {
            h->used = false;
            building_note(e->arena, e->b, NOTE_DROPPED, at, "%s at (%.2f, %.2f) left out: covered by %s",
                          name, at.x, at.y, by);
        } else if (lost > SMALL_LOSS * (kept + lost)) {
            building_note(e->arena, e->b, NOTE_CHANGED, at,
                          "%s at (%.2f, %.2f) loses %.0f %% of its place to %s", name, at.x, at.y,
                          100 * lost / (kept + lost), by);
        }
    }
}

// ---- leaks

typedef struct Way {
    int *from;  // [face_count] half-edge that led into a face, -1: start, -2: not reached
    int *queue;
} Way;

typedef enum Ground { GROUND_ROOM, GROUND_AIR } Ground;

static bool belongs(const Spot *spot, Ground ground, int id) {
    return ground == GROUND_ROOM ? spot->indoor == id : is_open(spot) && spot->indoor < 0;
}

// Breadth-first from face to face over one ground, until `goal` (a face, or -1: the edge of the world).
// Returns the face reached there, or -1.
static int search(const Plan *p, const Spot *spots, Way *way, int start, int goal, Ground ground, int id) {
    for (int f = 0; f < p->face_count; f++) way->from[f] = -2;
    int head = 0, tail = 0;
    way->from[start] = -1;
    way->queue[tail++] = start;
    while (head < tail) {
        int f = way->queue[head++];
        if (f == goal) return f;
        for (int k = 0; k < p->faces[f].half_count; k++) {
            int h = p->halves[p->faces[f].first_half + k], g = half_right(p, h);
            if (g < 0 && goal < 0) return f;
            if (g < 0 || way->from[g] != -2 || !belongs(&spots[g], ground, id)) continue;
            way->from[g] = h;
            way->queue[tail++] = g;
        }
    }
    return -1;
}

static Vec2 middle_of(const Plan *p, int h) {
    return vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
}

// Appends the middles of the edges crossed on the way to `face`, the first crossed first.
static void push_way(Enclosure *e, const Way *way, int face) {
    const Plan *p = &e->pass.plan;
    int count = 0;
    for (int f = face; way->from[f] >= 0; f = half_left(p, way->from[f])) way->queue[count++] = way->from[f];
    while (count-- > 0) {
        Vec3 m = enclose_place(e, middle_of(p, way->queue[count]), -1);
        enclose_push_point(e, vec2(m.x, m.y), 0);
    }
}

typedef struct Gap {
    double length;
    Vec2 middle;
    int half;  // the edge at its middle, from inside
} Gap;

// A half-edge through which the space `id` lies open to the air.
static bool is_gap(const Plan *p, const Spot *spots, int h, int id) {
    int f = half_left(p, h), g = half_right(p, h);
    return f >= 0 && g >= 0 && spots[f].indoor == id && is_open(&spots[g]) && spots[g].indoor < 0;
}

// The longest run of such edges that hang together.
static Gap widest_gap(const Plan *p, const Spot *spots, int id, int *parent, double *length) {
    Gap best = {0, {0, 0}, -1};
    for (int v = 0; v < p->vertex_count; v++) {
        parent[v] = v;
        length[v] = 0;
    }
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (is_gap(p, spots, h, id)) unite(parent, half_from(p, h), half_to(p, h));
    }
    int root = -1;
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (!is_gap(p, spots, h, id)) continue;
        int r = find(parent, half_from(p, h));
        length[r] += half_length(p, h);
        if (root < 0 || length[r] > length[root]) root = r;
    }
    if (root < 0) return best;
    best.length = length[root];
    double longest = 0;
    for (int h = 0; h < 2 * p->edge_count; h++) {
        if (!is_gap(p, spots, h, id) || find(parent, half_from(p, h)) != root || half_length(p, h) <= longest)
            continue;
        longest = half_length(p, h);
        best.half = h;
        best.middle = middle_of(p, h);
    }
    return best;
}

static int largest_face(const Plan *p, const Spot *spots, int id) {
    int best = -1;
    for (int f = 0; f < p->face_count; f++) {
        if (spots[f].indoor == id && (best < 0 || p->faces[f].area > p->faces[best].area)) best = f;
    }
    return best;
}

static void note_leak(Enclosure *e, const Spot *spots, int storey, int id, Gap gap, Way *way) {
    const Plan *p = &e->pass.plan;
    bool room = id < e->sketch->room_count;
    int start = largest_face(p, spots, id), in = half_left(p, gap.half), out = half_right(p, gap.half);
    Vec3 inner = enclose_place(e, p->faces[start].inner, storey), hole = enclose_place(e, gap.middle, storey);
    building_note(e->arena, e->b, NOTE_LEAK, hole, "%s is open to the outdoors over %.2f m at (%.2f, %.2f)",
                  room ? enclose_text(e->sketch->rooms[id].place) : "a space without a name",
                  gap.length / ENCLOSE_MM, hole.x, hole.y);
    int first = e->b->point_count;
    enclose_push_point(e, vec2(inner.x, inner.y), 0);
    if (search(p, spots, way, start, in, GROUND_ROOM, id) == in) push_way(e, way, in);
    enclose_push_point(e, vec2(hole.x, hole.y), 0);
    int end = search(p, spots, way, out, -1, GROUND_AIR, 0);
    if (end >= 0) {
        push_way(e, way, end);
        Vec3 air = enclose_place(e, p->faces[end].inner, storey);
        enclose_push_point(e, vec2(air.x, air.y), 0);
    }
    Note *note = &e->b->notes[e->b->note_count - 1];
    note->first_point = first;
    note->point_count = e->b->point_count - first;
}

static void report_leaks(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    int ids = e->sketch->room_count + e->pass.space_count;
    bool *leaks = ARENA_ARRAY(e->scratch, bool, ids);
    int *parent = ARENA_ARRAY(e->scratch, int, p->vertex_count);
    double *length = ARENA_ARRAY(e->scratch, double, p->vertex_count);
    Way way = {ARENA_ARRAY(e->scratch, int, p->face_count), ARENA_ARRAY(e->scratch, int, p->face_count)};
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        memset(leaks, 0, (size_t)ids * sizeof *leaks);
        for (int h = 0; h < 2 * p->edge_count; h++) {
            int f = half_left(p, h);
            if (f >= 0 && spots[f].indoor >= 0 && is_gap(p, spots, h, spots[f].indoor))
                leaks[spots[f].indoor] = true;
        }
        for (int id = 0; id < ids; id++) {
            if (leaks[id]) note_leak(e, spots, storey, id, widest_gap(p, spots, id, parent, length), &way);
        }
    }
}

static void report_plugs(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        int count = 0, widest = -1;
        for (int f = 0; f < p->face_count; f++) {
            if (spots[f].wall != WALL_PLUG) continue;
            count++;
            if (widest < 0 || p->faces[f].area > p->faces[widest].area) widest = f;
        }
        if (count == 0) continue;
        Vec3 at = enclose_place(e, p->faces[widest].inner, storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "storey %d: %d small gaps between walls were closed, the largest at (%.2f, %.2f)",
                      storey, count, at.x, at.y);
    }
}

void indoor_report(Enclosure *e) {
    RoomAreas *areas = ARENA_ARRAY(e->scratch, RoomAreas, e->sketch->room_count);
    measure_rooms(e, areas);
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (e->room_used[i]) report_room(e, i, &areas[i]);
    }
    report_holes(e);
    report_plugs(e);
    report_leaks(e);
}
