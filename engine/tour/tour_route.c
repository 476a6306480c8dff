// tour_route.c - the order of rooms and the way between them. The way follows Dijkstra's shortest paths over the places of the
// floor, on which places near walls and furniture cost more. Of up to MATRIX rooms the order is improved by moving and reversing runs
// (2-opt and or-opt; G. A. Croes 1958, I. Or 1976); of more, the next room is always the nearest.
#include "engine/tour/tour_route.h"

#include <string.h>

#include "engine/core/heap.h"
#include "engine/tour/tour_line.h"
#include "engine/tour/tour_rooms.h"

// People keep this far from walls where they can: body and this much, metres; hugging the wall costs so many times more.
static const double ROOMY = 0.6, HUGGING = 2.5;
// The start is left when another part has so many times more rooms, or it has one only.
static const int FEW = 4;
enum { MATRIX = 40 };
// A room is entered when the way goes so far through it, metres.
static const double ENTERED = 0.5;

typedef struct Search {
    const TourFloor *floor;
    double *cost;  // [place_count]
    int *from;     // [place_count] the place before on the shortest path
    int *heap, *slot;
    int heap_count;
} Search;

typedef struct Router {
    const TourFloor *floor;
    Arena *arena;
    TourRoute *out;
    Search search;
    int *room_of;   // [place_count]
    int *target;    // [room_count] the place of a room to which the way leads, in the part at hand; -1: none
    WayPlace *way;  // of the leg
    int way_count, way_capacity;
} Router;

// ---- shortest paths

static bool cheaper(const void *context, const void *first, const void *second) {
    const Search *s = context;
    int a = *(const int *)first, b = *(const int *)second;
    return s->cost[a] < s->cost[b] || (s->cost[a] == s->cost[b] && a < b);
}

static double step_cost(const TourFloor *f, int from, int to) {
    const FloorPlace *p = &f->places[to];
    Vec3 way = vec3_sub(p->foot, f->places[from].foot);
    double near = fmax(0, 1 - (double)p->clearance / ROOMY), factor = 1 + HUGGING * near * near;
    if (p->unfit & FLOOR_IN_THINGS) factor *= 40;
    if (p->unfit & FLOOR_ON_THINGS) factor *= 15;
    if (p->unfit & FLOOR_LOW) factor *= 6;
    if (p->unfit & FLOOR_OUTSIDE) factor *= 2;
    return factor * vec3_length(way);
}

// Dijkstra's algorithm from a place until a place of an open room with a target is settled that is its target; returns it, or -1
// when all that is linked has been settled. `stop` false: never stops.
static int search_from(Router *r, int start, bool stop) {
    Search *s = &r->search;
    const TourFloor *f = r->floor;
    for (int i = 0; i < f->place_count; i++) s->cost[i] = INFINITY, s->from[i] = s->slot[i] = -1;
    Heap heap = {.items = s->heap, .size = sizeof *s->heap, .before = cheaper, .context = s, .slot = s->slot};
    s->cost[start] = 0;
    s->heap_count = 0;
    heap_rise(&heap, s->heap_count++, &start);
    while (s->heap_count > 0) {
        int at = s->heap[0], room = r->room_of[at];
        heap_drop_first(&heap, s->heap_count--);
        if (stop && room >= 0 && r->target[room] == at && r->out->room_state[room] == ROOM_OPEN) return at;
        for (int k = 0; k < 8; k++) {
            int to = f->places[at].link[k];
            if (to < 0) continue;
            double cost = s->cost[at] + step_cost(f, at, to);
            if (cost >= s->cost[to]) continue;
            bool waits = s->cost[to] < INFINITY;
            s->cost[to] = cost;
            s->from[to] = at;
            heap_rise(&heap, waits ? s->slot[to] : s->heap_count++, &to);
        }
    }
    return -1;
}

// Adds the path to `end` to the way, and marks the rooms that it enters.
static void follow(Router *r, int end) {
    int count = 0, first = r->way_count, run = 0;
    for (int p = end; r->search.from[p] >= 0; p = r->search.from[p]) count++;
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(r->arena, r->way, r->way_count, r->way_capacity) = (WayPlace){-1, false};
    for (int p = end, i = first + count - 1; i >= first; i--, p = r->search.from[p]) r->way[i].place = p;
    for (int i = first; i < r->way_count; i++) {
        int room = r->room_of[r->way[i].place];
        run = i > first && room == r->room_of[r->way[i - 1].place] ? run + 1 : 1;
        if (room < 0 || run * r->floor->apart < ENTERED || r->out->room_state[room] != ROOM_OPEN) continue;
        r->out->room_state[room] = ROOM_ENTERED;
        r->way[i - run / 2].stays = true;
    }
    r->way[r->way_count - 1].stays = true;
    r->out->room_state[r->room_of[end]] = ROOM_ENTERED;
}

// ---- targets

// The target of each room of a part: where there is room around, near the middle of the room's places.
static int find_targets(Router *r, int part) {
    const TourFloor *f = r->floor;
    Arena scratch = {0};
    int rooms = r->out->room_count, count = 0;
    Vec3 *sum = ARENA_ARRAY(&scratch, Vec3, rooms + 1);
    int *size = ARENA_ARRAY(&scratch, int, rooms + 1);
    double *best = ARENA_ARRAY(&scratch, double, rooms + 1);
    for (int i = 0; i < rooms; i++) r->target[i] = -1;
    for (int p = 0; p < f->place_count; p++) {
        int room = r->room_of[p];
        if (room < 0 || f->places[p].part != part) continue;
        sum[room] = vec3_add(sum[room], f->places[p].foot);
        size[room]++;
    }
    for (int p = 0; p < f->place_count; p++) {
        int room = r->room_of[p];
        const FloorPlace *at = &f->places[p];
        if (room < 0 || at->part != part || r->out->room_state[room] != ROOM_OPEN) continue;
        Vec3 middle = vec3_scale(sum[room], 1.0 / size[room]);
        double good = fmin((double)at->clearance, 0.8) - 0.1 * vec3_length(vec3_sub(at->foot, middle)) -
                      (at->unfit ? 10 : 0);
        if (r->target[room] >= 0 && good <= best[room]) continue;
        count += r->target[room] < 0;
        r->target[room] = p;
        best[room] = good;
    }
    arena_free(&scratch);
    return count;
}

// ---- order

static double length_of(const double *cost, int n, const int *order) {
    double sum = 0;
    for (int i = 1; i < n; i++) sum += cost[order[i - 1] * n + order[i]];
    return sum;
}

static void reverse(int *order, int first, int last) {
    for (; first < last; first++, last--) {
        int swap = order[first];
        order[first] = order[last], order[last] = swap;
    }
}

// Improves an order whose first stop is fixed and whose last is free.
static void improve(const double *cost, int n, int *order, int *other) {
    double best = length_of(cost, n, order);
    for (bool more = true; more;) {
        more = false;
        for (int i = 1; i < n; i++) {
            for (int k = i; k < n; k++) {
                for (int to = 1; to + (k - i) < n; to++) {
                    for (int turned = 0; turned < 2; turned++) {
                        // The run i .. k is taken out and put in before the stop that is then number `to`.
                        int run = k - i + 1, at = 0;
                        for (int s = 0; s < n; s++)
                            if (s < i || s > k) other[at++] = order[s];
                        memmove(other + to + run, other + to, (size_t)(n - run - to) * sizeof *other);
                        memcpy(other + to, order + i, (size_t)run * sizeof *other);
                        if (turned) reverse(other, to, to + run - 1);
                        double length = length_of(cost, n, other);
                        if (length >= best - 1e-6) continue;
                        best = length;
                        memcpy(order, other, (size_t)n * sizeof *order);
                        more = true;
                    }
                }
            }
        }
    }
}

static void visit_in_order(Router *r, int start, int targets) {
    Arena scratch = {0};
    int n = targets + 1, count = 1, *stop = ARENA_ARRAY(&scratch, int, n);
    int *order = ARENA_ARRAY(&scratch, int, n), *other = ARENA_ARRAY(&scratch, int, n);
    double *cost = ARENA_ARRAY(&scratch, double, n *n);
    stop[0] = start;
    for (int i = 0; i < r->out->room_count; i++)
        if (r->target[i] >= 0) stop[count++] = r->target[i];
    for (int i = 0; i < n; i++) {
        search_from(r, stop[i], false);
        for (int k = 0; k < n; k++) cost[i * n + k] = r->search.cost[stop[k]];
    }
    unsigned char *taken = ARENA_ARRAY(&scratch, unsigned char, n);
    taken[0] = 1;
    for (int i = 1; i < n; i++) {
        int next = -1;
        for (int k = 1; k < n; k++) {
            if (!taken[k] && (next < 0 || cost[order[i - 1] * n + k] < cost[order[i - 1] * n + next]))
                next = k;
        }
        taken[order[i] = next] = 1;
    }
    improve(cost, n, order, other);
    int at = start;
    for (int i = 1; i < n; i++) {
        int end = stop[order[i]];
        if (r->out->room_state[r->room_of[end]] != ROOM_OPEN) continue;
        search_from(r, at, false);
        follow(r, end);
        at = end;
    }
    arena_free(&scratch);
}

// ---- legs

// The way through a part from `start`.
static void walk_part(Router *r, int start) {
    r->way_count = 0;
    *ARENA_PUSH(r->arena, r->way, r->way_count, r->way_capacity) = (WayPlace){start, true};
    int targets = find_targets(r, r->floor->places[start].part);
    if (targets <= MATRIX) {
        visit_in_order(r, start, targets);
    } else {
        for (int at = start; (at = search_from(r, at, true)) >= 0;) follow(r, at);
    }
    tour_line_add(r->floor, r->room_of, r->way, r->way_count, r->arena, r->out);
}

// A place of the part's largest room, far from the place to which the way leads there: the first view goes over the room.
static int entry_of(Router *r, int part) {
    const TourFloor *f = r->floor;
    Arena scratch = {0};
    int *size = ARENA_ARRAY(&scratch, int, r->out->room_count + 1), largest = -1, entry = -1;
    for (int p = 0; p < f->place_count; p++) {
        int room = r->room_of[p];
        if (room < 0 || f->places[p].part != part || r->out->room_state[room] != ROOM_OPEN) continue;
        if (++size[room] > (largest >= 0 ? size[largest] : 0)) largest = room;
    }
    find_targets(r, part);
    double best = -INFINITY;
    for (int p = 0; p < f->place_count && largest >= 0; p++) {
        const FloorPlace *at = &f->places[p];
        if (at->part != part || r->room_of[p] != largest) continue;
        double apart = vec3_length(vec3_sub(at->foot, f->places[r->target[largest]].foot));
        double good = fmin(apart, 4) + 4 * fmin((double)at->clearance, 0.4) - (at->unfit ? 20 : 0);
        if (good > best) best = good, entry = p;
    }
    arena_free(&scratch);
    return entry;
}

// [part_count] how many open rooms have places in each part.
static void count_rooms(const Router *r, int *rooms) {
    const TourFloor *f = r->floor;
    Arena scratch = {0};
    int *first = ARENA_ARRAY(&scratch, int, f->part_count + 2),
        *by_part = ARENA_ARRAY(&scratch, int, f->place_count + 1);
    int *last = ARENA_ARRAY(&scratch, int, r->out->room_count + 1);
    for (int i = 0; i < f->part_count; i++) first[i + 2] = first[i + 1] + f->part_size[i], rooms[i] = 0;
    for (int p = 0; p < f->place_count; p++) by_part[first[f->places[p].part + 1]++] = p;
    for (int i = 0; i < r->out->room_count; i++) last[i] = -1;
    for (int i = 0; i < f->place_count; i++) {
        int room = r->room_of[by_part[i]], part = f->places[by_part[i]].part;
        if (room < 0 || r->out->room_state[room] != ROOM_OPEN || last[room] == part) continue;
        last[room] = part;
        rooms[part]++;
    }
    arena_free(&scratch);
}

// The place nearest to the start of the building; -1: none within BODY_SEARCH.
static int place_of_start(const TourFloor *f) {
    Vec3 start = f->graph->building->start;
    double nearest = BODY_SEARCH;
    int best = -1;
    for (int p = 0; p < f->place_count; p++) {
        Vec3 eye = vec3(f->places[p].foot.x, f->places[p].foot.y, f->places[p].foot.z + BODY_EYE);
        double apart = vec3_length(vec3_sub(eye, start));
        if (apart < nearest) nearest = apart, best = p;
    }
    return best;
}

void tour_route_make(const TourFloor *f, Arena *arena, TourRoute *out) {
    Arena scratch = {0};
    *out = (TourRoute){0};
    Router r = {.floor = f, .arena = &scratch, .out = out, .search = {.floor = f}};
    r.search.cost = ARENA_ARRAY(&scratch, double, f->place_count + 1);
    r.search.from = ARENA_ARRAY(&scratch, int, f->place_count + 1);
    r.search.heap = ARENA_ARRAY(&scratch, int, f->place_count + 1);
    r.search.slot = ARENA_ARRAY(&scratch, int, f->place_count + 1);
    r.room_of = tour_rooms_find(f, arena, out);
    r.target = ARENA_ARRAY(&scratch, int, out->room_count + 1);
    int *rooms = ARENA_ARRAY(&scratch, int, f->part_count + 1), capacity = 0;
    r.arena = arena;
    int start = place_of_start(f);
    for (bool first = true;; first = false) {
        count_rooms(&r, rooms);
        int part = -1;
        for (int i = 0; i < f->part_count; i++) {
            if (rooms[i] == 0) continue;
            bool larger = part < 0 || f->part_size[i] > f->part_size[part];
            if (first && part >= 0 && rooms[i] != rooms[part]) larger = rooms[i] > rooms[part];
            if (larger) part = i;
        }
        if (part < 0) break;
        int entry = -1;
        if (first && start >= 0) {
            int around = rooms[f->places[start].part];
            bool stays = f->places[start].part == part || (around > 1 && around * FEW >= rooms[part]);
            if (stays) entry = start;
            out->moved = !stays;
        }
        if (entry < 0) entry = entry_of(&r, part);
        *ARENA_PUSH(arena, out->leg_first, out->leg_count, capacity) = out->point_count;
        walk_part(&r, entry);
    }
    *ARENA_PUSH(arena, out->leg_first, out->leg_count, capacity) = out->point_count;
    out->leg_count--;
    arena_free(&scratch);
}
