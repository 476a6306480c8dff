// fixture.c - grids of rooms, and a tracer of straight lines through cells.
#include "tests/support/fixture.h"

#include "engine/core/polygon.h"

static const double ROOM = 4.0, PITCH = 4.2, HEIGHT = 2.7, DOOR_HEIGHT = 2.1, SLAB = 0.3;

static void begin_region(Arena *arena, Building *b, RegionKind kind, double z0, double z1) {
    Region *r = ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity);
    *r = (Region){.kind = kind, .name = "", .opening = -1, .first_ring = b->ring_count, .z0 = z0, .z1 = z1};
}

static void begin_ring(Arena *arena, Building *b) {
    ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity)->first_point = b->point_count;
    b->regions[b->region_count - 1].ring_count++;
}

static void add_point(Arena *arena, Building *b, double x, double y) {
    int edge = b->point_count;
    *ARENA_PUSH(arena, b->edge_material, edge, b->edge_capacity) = 0;
    *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = vec2(maps_snap(x), maps_snap(y));
    b->rings[b->ring_count - 1].point_count++;
}

static void add_box_region(Arena *arena, Building *b, RegionKind kind, double x0, double y0, double x1,
                           double y1, double z0, double z1) {
    begin_region(arena, b, kind, z0, z1);
    begin_ring(arena, b);
    add_point(arena, b, x0, y0);
    add_point(arena, b, x1, y0);
    add_point(arena, b, x1, y1);
    add_point(arena, b, x0, y1);
}

// A hole in the wall on the +x or +y side of each room: where it begins, -1 none.
typedef struct Walls {
    double start[2][64];
    double width[2][64];
    bool door[2][64];
} Walls;

static void add_room(Arena *arena, Building *b, const Walls *w, int nx, int ny, int i, int j, double z,
                     bool pillar) {
    double x0 = i * PITCH, y0 = j * PITCH, x1 = x0 + ROOM, y1 = y0 + ROOM;
    int here = j * nx + i;
    begin_region(arena, b, REGION_ROOM, z, z + HEIGHT);
    begin_ring(arena, b);
    add_point(arena, b, x0, y0);
    if (j > 0 && w->start[1][here - nx] >= 0) {
        add_point(arena, b, x0 + w->start[1][here - nx], y0);
        add_point(arena, b, x0 + w->start[1][here - nx] + w->width[1][here - nx], y0);
    }
    add_point(arena, b, x1, y0);
    if (i + 1 < nx && w->start[0][here] >= 0) {
        add_point(arena, b, x1, y0 + w->start[0][here]);
        add_point(arena, b, x1, y0 + w->start[0][here] + w->width[0][here]);
    }
    add_point(arena, b, x1, y1);
    if (j + 1 < ny && w->start[1][here] >= 0) {
        add_point(arena, b, x0 + w->start[1][here] + w->width[1][here], y1);
        add_point(arena, b, x0 + w->start[1][here], y1);
    }
    add_point(arena, b, x0, y1);
    if (i > 0 && w->start[0][here - 1] >= 0) {
        add_point(arena, b, x0, y0 + w->start[0][here - 1] + w->width[0][here - 1]);
        add_point(arena, b, x0, y0 + w->start[0][here - 1]);
    }
    if (pillar) {
        begin_ring(arena, b);
        add_point(arena, b, x0 + 1.5, y0 + 1.5);
        add_point(arena, b, x0 + 1.5, y0 + 2.1);
        add_point(arena, b, x0 + 2.1, y0 + 2.1);
        add_point(arena, b, x0 + 2.1, y0 + 1.5);
    }
}

static void set_opening(Arena *arena, Building *b, bool door, Vec2 from, Vec2 to, double z) {
    Opening *o = ARENA_PUSH(arena, b->openings, b->opening_count, b->opening_capacity);
    *o = (Opening){.kind = door ? OPENING_DOOR : OPENING_PASSAGE,
                   .name = "",
                   .line = {from, to},
                   .sill = z,
                   .head = z + DOOR_HEIGHT,
                   .region = {-1, -1}};
}

static void add_hole(Arena *arena, Building *b, const Walls *w, int axis, int here, double x, double y,
                     double z) {
    double start = w->start[axis][here], end = start + w->width[axis][here], gap = PITCH - ROOM;
    if (start < 0) return;
    bool door = w->door[axis][here];
    for (int half = 0; half < (door ? 2 : 1); half++) {
        double from = door ? half * gap / 2 : 0, to = door ? (half + 1) * gap / 2 : gap;
        if (axis == 0) {
            add_box_region(arena, b, REGION_OPENING, x + ROOM + from, y + start, x + ROOM + to, y + end, z,
                           z + DOOR_HEIGHT);
        } else {
            add_box_region(arena, b, REGION_OPENING, x + start, y + ROOM + from, x + end, y + ROOM + to, z,
                           z + DOOR_HEIGHT);
        }
        b->regions[b->region_count - 1].opening = b->opening_count;
        b->regions[b->region_count - 1].side = half;
    }
    Vec2 a = axis == 0 ? vec2(x + ROOM + gap / 2, y + start) : vec2(x + end, y + ROOM + gap / 2);
    Vec2 c = axis == 0 ? vec2(x + ROOM + gap / 2, y + end) : vec2(x + start, y + ROOM + gap / 2);
    set_opening(arena, b, door, a, c, z);
}

static void add_furniture(Arena *arena, Building *b, Random *random, double x, double y, double z) {
    double x0 = x + random_between(random, 0.1, 3.0), y0 = y + random_between(random, 0.1, 3.0);
    double x1 = x0 + random_between(random, 0.2, 1.2), y1 = y0 + random_between(random, 0.2, 1.2);
    double z0 = z + 0.01, z1 = z + random_between(random, 0.3, 1.9);
    building_add_object(arena, b, OBJECT_FURNITURE, "box");
    Vec3 v[8] = {{x0, y0, z0}, {x1, y0, z0}, {x1, y1, z0}, {x0, y1, z0},
                 {x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1}};
    static const int faces[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                    {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (int f = 0; f < 6; f++) {
        Vec3 face[4];
        for (int k = 0; k < 4; k++) face[k] = v[faces[f][k]];
        building_add_polygon(arena, b, face, 4, 0);
    }
}

Building *fixture_rooms(Arena *arena, Random *random, int nx, int ny, int storeys) {
    Building *b = arena_alloc(arena, 1, sizeof *b);
    b->source = "fixture";
    b->hash = random_next(random);
    Material grey = {.name = "grey", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1};
    building_add_material(arena, b, grey);
    for (int s = 0; s < storeys; s++) {
        double z = s * (HEIGHT + SLAB);
        Walls w;
        for (int axis = 0; axis < 2; axis++) {
            for (int k = 0; k < nx * ny; k++) {
                w.start[axis][k] =
                    random_unit(random) < 0.8 ? maps_snap(random_between(random, 0.3, 2.7)) : -1;
                w.width[axis][k] = maps_snap(random_between(random, 0.5, 1.0));
                w.door[axis][k] = random_unit(random) < 0.5;
            }
        }
        for (int j = 0; j < ny; j++) {
            for (int i = 0; i < nx; i++) {
                bool pillar = random_unit(random) < 0.3 && !(storeys > 1 && i == 0 && j == 0);
                add_room(arena, b, &w, nx, ny, i, j, z, pillar);
                if (i + 1 < nx) add_hole(arena, b, &w, 0, j * nx + i, i * PITCH, j * PITCH, z);
                if (j + 1 < ny) add_hole(arena, b, &w, 1, j * nx + i, i * PITCH, j * PITCH, z);
                add_furniture(arena, b, random, i * PITCH, j * PITCH, z);
            }
        }
        if (s > 0) add_box_region(arena, b, REGION_SHAFT, 1, 1, 3, 2, z - SLAB, z);
    }
    b->world = (Box){{0, 0, 0}, {nx * PITCH, ny * PITCH, storeys * (HEIGHT + SLAB)}};
    return b;
}

static Vec3 placed(Vec3 p, double turn, Vec3 by) {
    return vec3(by.x + p.x * cos(turn) - p.y * sin(turn), by.y + p.x * sin(turn) + p.y * cos(turn),
                by.z + p.z);
}

static Vec2 placed_in_plan(Vec2 p, double turn, Vec3 by) {
    Vec3 at = placed(vec3(p.x, p.y, 0), turn, by);
    return vec2(maps_snap(at.x), maps_snap(at.y));
}

void fixture_place(Building *b, double turn, Vec3 by) {
    Box world = b->world;
    for (int i = 0; i < b->point_count; i++) b->points[i] = placed_in_plan(b->points[i], turn, by);
    for (int i = 0; i < b->region_count; i++) b->regions[i].z0 += by.z, b->regions[i].z1 += by.z;
    for (int i = 0; i < b->opening_count; i++) {
        Opening *o = &b->openings[i];
        for (int k = 0; k < 2; k++) o->line[k] = placed_in_plan(o->line[k], turn, by);
        o->sill += by.z, o->head += by.z;
    }
    for (int i = 0; i < b->vertex_count; i++) b->vertices[i] = placed(b->vertices[i], turn, by);
    b->world = box_empty();
    for (int i = 0; i < 8; i++) {
        Vec3 corner = {i & 1 ? world.max.x : world.min.x, i & 2 ? world.max.y : world.min.y,
                       i & 4 ? world.max.z : world.min.z};
        b->world = box_add(b->world, placed(corner, turn, by));
    }
}

// The distance from p to the border of a convex polygon in its plane; negative outside.
static double inside_by(const Vec3 *v, int count, Vec3 n, Vec3 p) {
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_normalize(vec3_sub(v[(i + 1) % count], v[i]));
        least = fmin(least, vec3_dot(vec3_cross(n, edge), vec3_sub(p, v[i])));
    }
    return least;
}

// How far along the line the cell ends: its prism, or the planes that bound it.
static double exit_distance(const CellGraph *graph, const Cell *cell, Vec3 from, Vec3 direction) {
    double t = INFINITY;
    for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++) {
        double rate = vec3_dot(graph->faces[i].n, direction);
        if (rate < 0) t = fmin(t, fmax(0, plane_distance(graph->faces[i], from) / -rate));
    }
    if (t < INFINITY) return t;
    if (direction.z > 0) t = (cell->z1 - from.z) / direction.z;
    if (direction.z < 0) t = (cell->z0 - from.z) / direction.z;
    const Vec2 *plan = graph->plan + cell->first_edge;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], edge = vec2_sub(plan[(i + 1) % cell->edge_count], a);
        double here = vec2_cross(edge, vec2_sub(vec2(from.x, from.y), a));
        double rate = vec2_cross(edge, vec2(direction.x, direction.y));
        if (rate < 0) t = fmin(t, fmax(0, here / -rate));
    }
    return t;
}

bool fixture_trace(const CellGraph *graph, int cell, Vec3 from, Vec3 direction, const float *door_open,
                   Trace *out) {
    static const double DOUBTFUL = 1e-6;
    out->count = 1;
    out->cells[0] = cell;
    for (;;) {
        const Cell *here = &graph->cells[cell];
        Vec3 hit = vec3_add(from, vec3_scale(direction, exit_distance(graph, here, from, direction)));
        int through = -1;
        for (int i = here->first_way; i < here->first_way + here->way_count && through < 0; i++) {
            const Portal *portal = &graph->portals[graph->ways[i].portal];
            if (fabs(plane_distance(portal->plane, hit)) > 1e-7) continue;
            double inside = inside_by(graph->portal_vertices + portal->first_vertex, portal->vertex_count,
                                      portal->plane.n, hit);
            // Along an edge, or in the plane of the portal.
            if (fabs(inside) < DOUBTFUL || fabs(vec3_dot(portal->plane.n, direction)) < DOUBTFUL)
                return false;
            if (inside > 0) through = i;
        }
        int portal = through >= 0 ? graph->ways[through].portal : -1;
        bool shut = portal >= 0 && graph->portals[portal].door >= 0 && door_open &&
                    !door_open[graph->portals[portal].door];
        out->hit = hit;
        if (through < 0 || shut) return true;
        if (out->count == 256) return false;
        out->portals[out->count - 1] = portal;
        cell = graph->ways[through].cell;
        out->cells[out->count++] = cell;
    }
}

bool fixture_in_tree(const StabForest *forest, const Trace *trace) {
    int node = forest->root[trace->cells[0]];
    for (int i = 1; i < trace->count; i++) {
        int child = node + 1;
        if (child >= forest->node_count || forest->nodes[child].parent != node) return false;
        while (child >= 0 && forest->nodes[child].portal != trace->portals[i - 1])
            child = forest->nodes[child].next;
        if (child < 0) return false;
        node = child;
    }
    return true;
}

Vec3 fixture_point(const CellGraph *graph, Random *random, int c) {
    const Cell *cell = &graph->cells[c];
    const Vec2 *plan = graph->plan + cell->first_edge;
    // A random convex combination, which keeps off the border.
    Vec2 sum = {0, 0};
    double total = 0;
    for (int i = 0; i < cell->edge_count; i++) {
        double weight = 1e-3 + random_unit(random) * random_unit(random) * random_unit(random);
        sum = vec2_add(sum, vec2_scale(plan[i], weight));
        total += weight;
    }
    return vec3(sum.x / total, sum.y / total, random_between(random, cell->z0 + 2e-3, cell->z1 - 2e-3));
}

Vec3 fixture_direction(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

double fixture_region_area(const Building *b, const Region *region) {
    const Ring *ring = &b->rings[region->first_ring];
    const Vec2 *p = b->points + ring->first_point;
    double area = 0;
    for (int i = 1; i + 1 < ring->point_count; i++)
        area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
    return area;
}

double fixture_uncovered(const CellGraph *g, int c) {
    const Cell *cell = &g->cells[c];
    double open = 0;
    for (int i = 0; i < cell->edge_count; i++) {
        const Vec2 *p = g->plan + cell->first_edge;
        Vec2 a = p[i], b = p[(i + 1) % cell->edge_count];
        open += vec2_length(vec2_sub(b, a)) * (cell->z1 - cell->z0);
        open += vec2_cross(vec2_sub(a, p[0]), vec2_sub(b, p[0]));  // half of it, below and above
    }
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &g->portals[g->ways[i].portal];
        open -= polygon_area(g->portal_vertices + portal->first_vertex, portal->vertex_count);
    }
    for (int i = g->surface_first[c]; i < g->surface_first[c + 1]; i++) {
        const Polygon *p = &g->polygons[g->objects[i].first_polygon];
        open -= polygon_area(g->vertices + p->first_vertex, p->vertex_count);
    }
    return open;
}

// The point as the exact tests of sightlines take it.
static Vec2 exact(Vec2 p) {
    return vec2(p.x == maps_snap(p.x) ? nearbyint(p.x * 1000) : p.x * 1000,
                p.y == maps_snap(p.y) ? nearbyint(p.y * 1000) : p.y * 1000);
}

int fixture_dents(const CellGraph *g) {
    int dents = 0;
    for (int c = 0; c < g->cell_count; c++) {
        const Vec2 *p = g->plan + g->cells[c].first_edge;
        for (int i = 0, n = g->cells[c].edge_count; i < n; i++)
            dents += orient2d(exact(p[i]), exact(p[(i + 1) % n]), exact(p[(i + 2) % n])) < 0;
    }
    return dents;
}
