// tour_floor.c - the floors on which a body walks, found by walking: from a free place the body steps to the four neighbouring
// columns of a grid and stays where it arrives; then the same from there.
#include "engine/tour/tour_floor.h"

#include <string.h>

#include "engine/core/box_tree.h"
#include "engine/core/heap.h"

// Columns are this far apart, metres: half the body's radius. Where the building has more than MOST_COLUMNS of them, they are
// farther apart, up to LARGEST: less than a narrow doorway is wide.
static const double APART = 0.1, LARGEST = 0.3;
enum { MOST_COLUMNS = 90000 };
// The grid reaches this far from anything indoors, metres: a step out of a door, and along a wall to the next door.
static const double OUTDOORS = 2.5;
// A body has arrived this near to a place, metres, and at this difference of height.
static const double ARRIVED = 0.02, LEVEL = 0.02;
// It makes a new place within this share of `apart` around a column, so that narrow doorways have places, too.
static const double OFF_GRID = 0.35;
// The foot stands on furniture when it is this far over the foot of a stand-in box, and the eye keeps this far from one, metres.
static const double ON_THINGS = 0.06, EYE_CLEAR = 0.12;

typedef struct Flood {
    TourFloor *floor;
    BodyWorld world;
    Arena *arena;
    // Pieces of furniture with a stand-in, and the tree of where a body may be at them.
    int *things;
    BoxTree reach;
    BoxHits near;
    Arena *scratch;
} Flood;

static const int STEPS[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

static Vec2 column_place(const TourFloor *f, int i, int j) {
    return vec2(f->origin.x + i * f->apart, f->origin.y + j * f->apart);
}

static int column_of(const TourFloor *f, Vec3 at, int *i, int *j) {
    double x = round((at.x - f->origin.x) / f->apart), y = round((at.y - f->origin.y) / f->apart);
    if (!(x >= 0 && y >= 0 && x < f->nx && y < f->ny)) return -1;
    *i = (int)x;
    *j = (int)y;
    return *j * f->nx + *i;
}

static int place_near(const TourFloor *f, int column, double z, double rise) {
    int best = -1;
    for (int k = f->column[column]; k >= 0; k = f->places[k].next) {
        double off = fabs(f->places[k].foot.z - z);
        if (off <= rise) best = k, rise = off;
    }
    return best;
}

static bool may_enter(const TourFloor *f, int cell) { return !f->chosen || (cell >= 0 && f->chosen[cell]); }

// ---- places

static bool in_prism(const Object *o, Vec2 at, double grow) {
    for (int i = 0; i < 4; i++) {
        Vec2 a = o->proxy->corner[i], edge = vec2_sub(o->proxy->corner[(i + 1) % 4], a);
        double length = vec2_length(edge);
        if (length > 0 && vec2_cross(edge, vec2_sub(at, a)) < -grow * length) return false;
    }
    return true;
}

static bool is_thing(const Object *o) {
    bool thing = o->kind == OBJECT_FURNITURE || o->kind == OBJECT_LAMP || o->kind == OBJECT_LOW_WALL;
    return thing && o->proxy;
}

bool tour_floor_in_things(const Building *b, Vec3 eye, double grow) {
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (is_thing(o) && eye.z > o->proxy->z0 - grow && eye.z < o->proxy->z1 + grow &&
            in_prism(o, vec2(eye.x, eye.y), grow))
            return true;
    }
    return false;
}

static unsigned unfit_of(Flood *w, const Body *body) {
    const CellGraph *graph = w->floor->graph;
    unsigned unfit = body->height < BODY_HEIGHT - ON_THINGS ? FLOOR_LOW : 0;
    if (body->cell >= 0 && vis_region(graph, body->cell)->kind == REGION_OUTDOORS) unfit |= FLOOR_OUTSIDE;
    Vec2 at = vec2(body->foot.x, body->foot.y);
    double eye = body->foot.z + body_eye(body);
    Box here = {{at.x, at.y, -INFINITY}, {at.x, at.y, INFINITY}};
    int found = box_tree_find(&w->reach, here, w->scratch, &w->near);
    for (int i = 0; i < found; i++) {
        const Object *o = &graph->building->objects[w->things[w->near.items[i]]];
        if (o->proxy->z0 > eye + EYE_CLEAR || o->proxy->z1 < body->foot.z - LEVEL) continue;
        if (eye < o->proxy->z1 + EYE_CLEAR) {
            if (!(unfit & FLOOR_IN_THINGS) && in_prism(o, at, EYE_CLEAR)) unfit |= FLOOR_IN_THINGS;
        } else if (body->foot.z > o->proxy->z0 + ON_THINGS && body->foot.z < o->proxy->z1 + ON_THINGS &&
                   in_prism(o, at, BODY_RADIUS)) {
            unfit |= FLOOR_ON_THINGS;
        }
    }
    return unfit;
}

static int add_place(Flood *w, int column, const Body *body) {
    TourFloor *f = w->floor;
    int index = f->place_count;
    *ARENA_PUSH(w->arena, f->places, f->place_count, f->place_capacity) =
        (FloorPlace){.foot = body->foot,
                     .eye = (float)body_eye(body),
                     .cell = body->cell,
                     .part = -1,
                     .next = f->column[column],
                     .link = {-1, -1, -1, -1, -1, -1, -1, -1},
                     .unfit = (unsigned char)unfit_of(w, body)};
    f->column[column] = index;
    return index;
}

// The body of a place, as it stood when the place was made.
static Body body_at(const FloorPlace *p) {
    return (Body){
        .foot = p->foot, .height = BODY_HEIGHT, .head = BODY_HEIGHT, .standing = true, .cell = p->cell};
}

static bool walks(Flood *w, Body *body, Vec2 to) {
    long lost = w->world.relocations;
    body_step(body, &w->world, vec2(to.x - body->foot.x, to.y - body->foot.y), 0);
    return w->world.relocations == lost && body->standing;
}

static double plan_apart(Vec3 a, Vec3 b) { return hypot(a.x - b.x, a.y - b.y); }

// The place to which a step from place `from` leads, which may be new; -1: none.
static int step_to(Flood *w, int from, int k) {
    TourFloor *f = w->floor;
    int i, j;
    column_of(f, f->places[from].foot, &i, &j);
    i += STEPS[k][0], j += STEPS[k][1];
    if (i < 0 || j < 0 || i >= f->nx || j >= f->ny) return -1;
    Vec2 to = column_place(f, i, j);
    int column = j * f->nx + i;
    Body body = body_at(&f->places[from]);
    if (!walks(w, &body, to) || hypot(body.foot.x - to.x, body.foot.y - to.y) > OFF_GRID * f->apart)
        return -1;
    if (!may_enter(f, body.cell)) return -1;
    int there = place_near(f, column, body.foot.z, BODY_STEP);
    if (there < 0) return add_place(w, column, &body);
    Vec3 foot = f->places[there].foot;
    if (plan_apart(body.foot, foot) > ARRIVED && !walks(w, &body, vec2(foot.x, foot.y))) return -1;
    bool same = plan_apart(body.foot, foot) <= ARRIVED && fabs(body.foot.z - foot.z) <= 2 * LEVEL;
    return same ? there : -1;
}

static void step_around(Flood *w, int from) {
    TourFloor *f = w->floor;
    for (int k = 0; k < 8; k += 2) {
        if (f->places[from].link[k] >= 0) continue;
        int to = step_to(w, from, k);
        if (to < 0 || to == from) continue;
        f->places[from].link[k] = to;
        // On level ground the way back is the same way.
        int back = (k + 4) % 8;
        if (f->places[to].link[back] < 0 && fabs(f->places[to].foot.z - f->places[from].foot.z) <= LEVEL)
            f->places[to].link[back] = from;
    }
}

// ---- links

// A way that leads there and not back is dropped: the body fell, or climbed where it cannot come down.
static void keep_mutual(TourFloor *f) {
    for (int i = 0; i < f->place_count; i++) {
        for (int k = 0; k < 8; k += 2) {
            int to = f->places[i].link[k];
            if (to >= 0 && f->places[to].link[(k + 4) % 8] != i) f->places[i].link[k] = -1;
        }
    }
}

// A step across a square of four linked places is free of solids as the sides of the square are.
static void link_diagonals(TourFloor *f) {
    for (int i = 0; i < f->place_count; i++) {
        FloorPlace *p = &f->places[i];
        for (int k = 1; k < 8; k += 2) {
            int a = p->link[k - 1], b = p->link[(k + 1) % 8];
            if (a < 0 || b < 0) continue;
            int to = f->places[a].link[(k + 1) % 8];
            if (to >= 0 && to == f->places[b].link[k - 1]) p->link[k] = to;
        }
    }
}

static void find_parts(TourFloor *f, Arena *arena) {
    Arena scratch = {0};
    int *stack = ARENA_ARRAY(&scratch, int, f->place_count + 1), capacity = 0;
    f->part_size = NULL;
    for (int i = 0; i < f->place_count; i++) {
        if (f->places[i].part >= 0) continue;
        int count = 0, size = 0, part = f->part_count;
        stack[count++] = i;
        f->places[i].part = part;
        while (count > 0) {
            const FloorPlace *p = &f->places[stack[--count]];
            size++;
            for (int k = 0; k < 8; k += 2) {
                if (p->link[k] < 0 || f->places[p->link[k]].part >= 0) continue;
                f->places[p->link[k]].part = part;
                stack[count++] = p->link[k];
            }
        }
        *ARENA_PUSH(arena, f->part_size, f->part_count, capacity) = size;
    }
    arena_free(&scratch);
}

// Distances over links to the nearest place that lacks one, by relaxation in passes: exact enough after a few of them, since each
// pass carries distances along the whole order of the places.
static void find_clearance(TourFloor *f) {
    for (int i = 0; i < f->place_count; i++) {
        bool edge = false;
        for (int k = 0; k < 8; k++) edge = edge || f->places[i].link[k] < 0;
        f->places[i].clearance = edge ? 0 : (float)FLOOR_CLEAR;
    }
    for (bool more = true; more;) {
        more = false;
        for (int n = 0; n < 2 * f->place_count; n++) {
            FloorPlace *p = &f->places[n < f->place_count ? n : 2 * f->place_count - 1 - n];
            for (int k = 0; k < 8; k++) {
                if (p->link[k] < 0) continue;
                float way = f->places[p->link[k]].clearance + (float)(f->apart * (k % 2 ? M_SQRT2 : 1));
                if (way < p->clearance - 1e-4f) p->clearance = way, more = true;
            }
        }
    }
}

// ---- which rooms

// May a person go through this region? Windows lead nowhere.
static bool is_way(const Building *b, const Region *region) {
    return region->opening < 0 || b->openings[region->opening].kind != OPENING_WINDOW;
}

// A cell that was reached from the start: by how long a way, metres, and where the way enters it.
typedef struct Reached {
    double way;
    int number, cell;  // they are numbered as they are found
    Vec3 at;
} Reached;

static bool is_nearer(const void *context, const void *a, const void *b) {
    (void)context;
    const Reached *p = a, *q = b;
    return p->way != q->way ? p->way < q->way : p->number < q->number;
}

static Vec3 portal_middle(const CellGraph *graph, int portal) {
    const Portal *p = &graph->portals[portal];
    Vec3 sum = vec3(0, 0, 0);
    for (int i = 0; i < p->vertex_count; i++)
        sum = vec3_add(sum, graph->portal_vertices[p->first_vertex + i]);
    return vec3_scale(sum, 1.0 / p->vertex_count);
}

// Chooses the nearest cells, by ways from portal to portal, until they hold so many rooms (E. W. Dijkstra 1959).
static void choose_rooms(TourFloor *f, int rooms, Arena *arena) {
    const CellGraph *graph = f->graph;
    Arena scratch = {0};
    unsigned char *taken = ARENA_ARRAY(&scratch, unsigned char, graph->building->region_count);
    Heap heap = {.items = ARENA_ARRAY(&scratch, Reached, graph->way_count + 1),
                 .size = sizeof(Reached),
                 .before = is_nearer};
    int start = vis_locate(graph, graph->building->start, -1), count = 1, number = 1;
    f->chosen = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    heap_put(&heap, 0, &(Reached){0, 0, start < 0 ? 0 : start, graph->building->start});
    while (count > 0) {
        Reached next = *(const Reached *)heap_at(&heap, 0);
        const Cell *cell = &graph->cells[next.cell];
        heap_drop_first(&heap, count--);
        if (f->chosen[next.cell]) continue;
        if (vis_region(graph, next.cell)->kind == REGION_ROOM && !taken[cell->region]) {
            if (rooms-- == 0) break;
            taken[cell->region] = 1;
        }
        f->chosen[next.cell] = 1;
        for (int k = cell->first_way; k < cell->first_way + cell->way_count; k++) {
            Way way = graph->ways[k];
            if (f->chosen[way.cell] || !is_way(graph->building, vis_region(graph, way.cell))) continue;
            Vec3 at = portal_middle(graph, way.portal);
            Reached beyond = {next.way + vec3_length(vec3_sub(at, next.at)), number++, way.cell, at};
            heap_rise(&heap, count++, &beyond);
        }
    }
    arena_free(&scratch);
}

// ---- the whole floor

static void lay(TourFloor *f, Arena *arena) {
    const CellGraph *graph = f->graph;
    Box box = box_empty();
    double area = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        if (vis_region(graph, c)->kind == REGION_OUTDOORS || !may_enter(f, c)) continue;
        box = box_union(box, cell->box);
        for (int i = 1; i + 1 < cell->edge_count; i++) {
            Vec2 o = graph->plan[cell->first_edge];
            area += vec2_cross(vec2_sub(graph->plan[cell->first_edge + i], o),
                               vec2_sub(graph->plan[cell->first_edge + i + 1], o)) /
                    2;
        }
    }
    box = box_is_empty(box) ? graph->box : box_grow(box, OUTDOORS);
    double wide = box.max.x - box.min.x, deep = box.max.y - box.min.y;
    f->apart = fmin(fmax(APART, sqrt(fmin(area, wide * deep) / MOST_COLUMNS)), LARGEST);
    // A grid has no more than a hundred times as many columns, however far apart its buildings are.
    f->apart = fmax(f->apart, sqrt(wide * deep / (100.0 * MOST_COLUMNS)));
    // Coordinates of files are round numbers: the grid begins off them, so that columns lie on no wall.
    f->origin = vec2(box.min.x + 0.0137, box.min.y + 0.0171);
    f->nx = (int)ceil(wide / f->apart) + 1;
    f->ny = (int)ceil(deep / f->apart) + 1;
    f->column = ARENA_ARRAY(arena, int, f->nx * f->ny);
    for (int i = 0; i < f->nx * f->ny; i++) f->column[i] = -1;
}

static bool in_cell(const CellGraph *graph, const Cell *cell, Vec2 at) {
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = graph->plan[cell->first_edge + i],
             b = graph->plan[cell->first_edge + (i + 1) % cell->edge_count];
        if (vec2_cross(vec2_sub(b, a), vec2_sub(at, a)) < 0) return false;
    }
    return true;
}

// Floods from each column of a cell on whose floor no place is yet.
static void seed_cell(Flood *w, int c) {
    TourFloor *f = w->floor;
    const Cell *cell = &f->graph->cells[c];
    int i0 = (int)fmax(0, ceil((cell->box.min.x - f->origin.x) / f->apart));
    int j0 = (int)fmax(0, ceil((cell->box.min.y - f->origin.y) / f->apart));
    for (int j = j0; j < f->ny; j++) {
        for (int i = i0; i < f->nx; i++) {
            Vec2 at = column_place(f, i, j);
            if (at.y > cell->box.max.y) return;
            if (at.x > cell->box.max.x) break;
            int column = j * f->nx + i;
            if (place_near(f, column, cell->z0, BODY_STEP) >= 0 || !in_cell(f->graph, cell, at)) continue;
            Body body = {.cell = -1};
            if (!body_place_at(&body, &w->world, vec3(at.x, at.y, cell->z0)) ||
                fabs(body.foot.z - cell->z0) > BODY_STEP)
                continue;
            int first = f->place_count;
            add_place(w, column, &body);
            for (int p = first; p < f->place_count; p++) step_around(w, p);
        }
    }
}

void tour_floor_make(const CellGraph *graph, int rooms, Arena *arena, TourFloor *out) {
    const Building *b = graph->building;
    Arena scratch = {0};
    *out = (TourFloor){.graph = graph};
    Flood w = {.floor = out, .world = body_world(graph, NULL, &scratch), .arena = arena, .scratch = &scratch};
    w.things = ARENA_ARRAY(&scratch, int, b->object_count + 1);
    Box *reach = ARENA_ARRAY(&scratch, Box, b->object_count + 1);
    int count = 0;
    for (int i = 0; i < b->object_count; i++) {
        if (!is_thing(&b->objects[i])) continue;
        w.things[count] = i;
        reach[count++] = box_grow(graph->object_boxes[i], BODY_RADIUS);
    }
    w.reach = box_tree_build(reach, count, &scratch);
    if (rooms > 0) choose_rooms(out, rooms, arena);
    lay(out, arena);
    for (int c = 0; c < graph->cell_count; c++) {
        const Region *region = vis_region(graph, c);
        bool room = region->kind == REGION_ROOM && may_enter(out, c);
        if (room && graph->cells[c].z1 - graph->cells[c].z0 >= BODY_LOWEST) seed_cell(&w, c);
    }
    keep_mutual(out);
    link_diagonals(out);
    find_parts(out, arena);
    find_clearance(out);
    arena_free(&scratch);
}

int tour_floor_at(const TourFloor *f, Vec3 foot) {
    int i, j, best = -1;
    if (column_of(f, foot, &i, &j) < 0) return -1;
    double nearest = INFINITY;
    for (int y = j - 2; y <= j + 2; y++) {
        for (int x = i - 2; x <= i + 2; x++) {
            if (x < 0 || y < 0 || x >= f->nx || y >= f->ny) continue;
            int k = place_near(f, y * f->nx + x, foot.z, BODY_STEP);
            double apart = k >= 0 ? plan_apart(f->places[k].foot, foot) : INFINITY;
            if (apart < nearest) nearest = apart, best = k;
        }
    }
    return best;
}

bool tour_floor_straight(const TourFloor *f, Vec3 from, Vec3 to, double clearance, unsigned unfit) {
    int steps = (int)ceil(plan_apart(from, to) / (f->apart / 2));
    int last = tour_floor_at(f, from);
    for (int i = 0; i <= steps && last >= 0; i++) {
        Vec3 at = vec3_lerp(from, to, steps > 0 ? (double)i / steps : 0);
        int x, y, column = column_of(f, vec3(at.x, at.y, 0), &x, &y);
        int place = column >= 0 ? place_near(f, column, f->places[last].foot.z, BODY_STEP) : -1;
        if (place < 0 || (double)f->places[place].clearance < clearance || (f->places[place].unfit & unfit))
            return false;
        bool linked = place == last;
        for (int k = 0; k < 8; k++) linked = linked || f->places[last].link[k] == place;
        if (!linked) return false;
        last = place;
    }
    return last >= 0 && fabs(f->places[last].foot.z - to.z) <= BODY_STEP;
}
