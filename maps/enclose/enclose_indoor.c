// enclose_indoor.c - which faces of the plan are rooms, which terraces, which the open air, storey by storey.
//
// Faces that are neither wall nor opening are connected across room edges. Faces connected with the edge of the
// world are outdoors, the rest are enclosed. Drawn rooms name the enclosed faces, and room edges stay open portals.
// A room connected with the outdoors stays a room where walls or other rooms run along most of its outline (a
// leak), else it is a terrace.
#include "maps/enclose/enclose.h"

// Undrawn strips between rooms and walls narrower than this belong to the room; enclosed cavities narrower
// than this are part of the walls, mm.
static const double NARROW = 250;
// The greatest width of strips of a room that were drawn beyond the wall by mistake, mm.
static const double STRAY = 100;
// A room that lies open stays a room if this share of its outline is closed.
static const double CLOSED_SHARE = 0.5;
// An outline this near to a wall counts as closed, mm; the distance between the probes along it, mm.
static const double NEAR_WALL = 250, PROBE = 200;

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
    int world = p->face_count;  // stands for the space beyond the world
    int *whole = ARENA_ARRAY(e->scratch, int, p->face_count + 1);
    for (int f = 0; f <= p->face_count; f++) patch[f] = whole[f] = f;
    for (int i = 0; i < p->edge_count; i++) {
        int f = p->edges[i].face[0] < 0 ? world : p->edges[i].face[0];
        int g = p->edges[i].face[1] < 0 ? world : p->edges[i].face[1];
        if ((f < world && !spot_is_open(&spots[f])) || (g < world && !spot_is_open(&spots[g]))) continue;
        set_unite(whole, f, g);
        int rf = f < world ? spots[f].room : -1, rg = g < world ? spots[g].room : -1;
        if (rf == rg) set_unite(patch, f, g);
    }
    for (int f = 0; f < p->face_count; f++) part[f] = -1;
    for (int f = 0; f < p->face_count; f++) {
        out.of[f] = -1;
        if (!spot_is_open(&spots[f])) continue;
        int root = set_find(patch, f);
        if (part[root] < 0) {
            part[root] = out.count;
            out.items[out.count++] = (Patch){.room = spots[f].room,
                                             .face = f,
                                             .id = -1,
                                             .outside = set_find(whole, f) == set_find(whole, world),
                                             .world = root == set_find(patch, world)};
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

// The length of the part of half-edge h with a wall near on its right, mm.
static double length_near_wall(Enclosure *e, const Plan *p, int storey, int h) {
    Vec2 a = p->vertices[half_from(p, h)], d = vec2_sub(p->vertices[half_to(p, h)], a);
    double length = vec2_length(d);
    Vec2 out = vec2_scale(vec2(d.y, -d.x), 1 / length);
    int probes = 1 + (int)fmin(length / PROBE, 200), near = 0;
    for (int i = 0; i < probes; i++) {
        Vec2 at = vec2_add(a, vec2_scale(d, (i + 0.5) / probes));
        for (int k = 1; k <= 4; k++) {
            if (!holes_wall_at(e, storey, vec2_add(at, vec2_scale(out, NEAR_WALL * k / 4)))) continue;
            near++;
            break;
        }
    }
    return length * near / probes;
}

// Finds the open patches that stay rooms: drops mostly open candidates until no candidate is mostly open.
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

// Names the indoor patches. Narrow ones wait for a neighbour, unless the room has no other patch.
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
        double width = face_width(patch->area, patch->perimeter);
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
        } else if (patch->room >= 0 && face_width(patch->area, patch->perimeter) >= STRAY) {
            spots[f].terrace = patch->room;
            pass->leaking = true;
        }
    }
    pass->enclosed += enclosed;
    if (enclosed == 0) pass->leaking = true;
}

void indoor_label(Enclosure *e, Pass *pass) {
    for (int storey = 0; storey < e->b->storey_count; storey++) label_storey(e, pass, storey);
}
