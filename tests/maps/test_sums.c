// test_sums.c - what is made of many buildings, in figures: free space, cells, trees, and what is seen, walked and moved there.
#include <criterion/criterion.h>
#include <math.h>
#include <string.h>

#include "engine/draw/view.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/hostile.h"
#include "tests/support/prt_scene.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

static const char *const FILES[] = {
    "build/maps/two-rooms.plan", "build/maps/house.plan", "build/maps/house.sh3d", "build/maps/flat.Home.xml",
    "build/maps/hillside.sh3d",  "build/maps/villa.sh3d", "build/maps/office.plan"};
enum { FILE_COUNT = sizeof FILES / sizeof *FILES };

// ---- free space

static void sum_regions(SumFile *f, const Building *b) {
    Sum regions = {0}, points = {0};
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        int words[] = {(int)r->kind,  r->storey,     r->opening,        r->side,
                       r->ring_count, r->first_ring, r->floor_material, r->ceiling_material};
        sum_ints(&regions, words, sizeof words / sizeof *words);
        sum_add2(&regions, vec2(r->z0, r->z1));
    }
    for (int i = 0; i < b->ring_count; i++) sum_ints(&regions, &b->rings[i].first_point, 2);
    for (int i = 0; i < b->point_count; i++) sum_add2(&points, b->points[i]);
    if (b->edge_material) sum_ints(&points, b->edge_material, b->point_count);
    sums_sum(f, "regions", regions);
    sums_sum(f, "points", points);
}

static void sum_openings(SumFile *f, const Building *b) {
    Sum openings = {0}, leaves = {0};
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        int words[] = {(int)o->kind,  o->storey,    o->glazed,    o->fills,    o->first_leaf,
                       o->leaf_count, o->region[0], o->region[1], o->material, o->reason != NULL};
        sum_ints(&openings, words, sizeof words / sizeof *words);
        sum_add2(&openings, o->line[0]);
        sum_add2(&openings, o->line[1]);
        sum_add3(&openings, vec3(o->sill, o->head, o->open));
    }
    for (int i = 0; i < b->leaf_count; i++) {
        const Leaf *l = &b->leaves[i];
        int words[] = {l->opening, l->first_corner, l->corner_count};
        sum_ints(&leaves, words, 3);
        sum_add2(&leaves, l->pivot);
        sum_add2(&leaves, l->slide);
        sum_add2(&leaves, l->axis[0]);
        sum_add2(&leaves, l->axis[1]);
        sum_add3(&leaves, vec3(l->turn, l->rise, l->thickness));
        sum_add2(&leaves, vec2(l->z0, l->z1));
    }
    sums_sum(f, "openings", openings);
    sums_sum(f, "leaves", leaves);
}

static void sum_polygons(SumFile *f, const Object *objects, int object_count, const Polygon *polygons,
                         int polygon_count, const Vec3 *vertices, int vertex_count) {
    Sum drawn = {0}, places = {0};
    for (int i = 0; i < object_count; i++) {
        const Object *o = &objects[i];
        int words[] = {(int)o->kind, o->first_polygon, o->polygon_count, o->opening, o->leaf, o->plug};
        sum_ints(&drawn, words, sizeof words / sizeof *words);
        for (int k = 0; k < 4; k++) sum_add2(&drawn, o->proxy[k]);
        sum_add2(&drawn, vec2(o->proxy_z0, o->proxy_z1));
    }
    for (int i = 0; i < polygon_count; i++) sum_ints(&drawn, &polygons[i].first_vertex, 3);
    for (int i = 0; i < vertex_count; i++) sum_add3(&places, vertices[i]);
    sums_sum(f, "drawn", drawn);
    sums_sum(f, "vertices", places);
}

static void sum_rest(SumFile *f, const Building *b) {
    Sum lights = {0}, rest = {0}, notes = {0};
    for (int i = 0; i < b->light_count; i++) {
        const Light *l = &b->lights[i];
        sum_add3(&lights, l->position);
        sum_add3(&lights, vec3((double)l->flux.r, (double)l->flux.g, (double)l->flux.b));
        sum_add2(&lights, vec2(l->radius, l->object));
    }
    for (int i = 0; i < b->inlay_count; i++) {
        int words[] = {b->inlays[i].first_point, b->inlays[i].point_count, b->inlays[i].material};
        sum_ints(&rest, words, 3);
        sum_add(&rest, b->inlays[i].z);
    }
    for (int i = 0; i < b->viewpoint_count; i++) {
        sum_add3(&rest, b->viewpoints[i].eye);
        sum_add3(&rest, vec3(b->viewpoints[i].yaw, b->viewpoints[i].pitch, b->viewpoints[i].fov));
    }
    for (int i = 0; i < b->material_count; i++) {
        const Material *m = &b->materials[i];
        sum_add3(&rest, vec3((double)m->reflectance.r, (double)m->reflectance.g, (double)m->reflectance.b));
        sum_add3(&rest, vec3((double)m->emission.r, (double)m->alpha, (double)m->index));
    }
    sum_box(&rest, b->world);
    sum_add3(&rest, b->start);
    sum_add3(&rest, vec3(b->start_yaw, b->drawn_area, b->lost_area));
    for (int i = 0; i < b->note_count; i++) {
        int words[] = {(int)b->notes[i].kind, b->notes[i].first_point, b->notes[i].point_count};
        sum_ints(&notes, words, 3);
        sum_add3(&notes, b->notes[i].place);
    }
    sums_sum(f, "lights", lights);
    sums_sum(f, "rest", rest);
    sums_sum(f, "notes", notes);
}

static void sum_building(SumFile *f, const char *name, const Building *b) {
    sums_scene(f, name);
    sum_regions(f, b);
    sum_openings(f, b);
    sum_polygons(f, b->objects, b->object_count, b->polygons, b->polygon_count, b->vertices, b->vertex_count);
    sum_rest(f, b);
}

static void read_building(const char *path, Arena *arena, Building *b) {
    Error error = {""};
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
}

// Reads a small file of a hostile kind; false where even that is refused.
static bool read_hostile(const HostileKind *k, const char *folder, Arena *arena, Building *out) {
    Error error = {""};
    int few = k->count < 4000 ? 6 : k->count / 500;
    const char *path = arena_format(arena, "%s/%s%s", folder, k->name, k->suffix);
    cr_assert(hostile_write(k, few, 1, path));
    return maps_read(path, arena, out, &error);
}

// A low wall along an arc, of many corners.
static void draw_arc(Draft *d, Random *r, int storey) {
    enum { HALF = 70 };
    Vec2 p[2 * HALF], middle = vec2(random_between(r, 0, 10), random_between(r, 0, 8));
    int half = 40 + random_index(r, HALF - 40);
    for (int i = 0; i < half; i++) {
        double angle = 3.0 * i / half;
        p[i] = vec2_add(middle, vec2(2 * cos(angle), 2 * sin(angle)));
        p[2 * half - 1 - i] = vec2_add(middle, vec2(1.8 * cos(angle), 1.8 * sin(angle)));
    }
    draft_wall_shape(d, storey, p, 2 * half, 0.3, random_between(r, 0.3, 1.5));
}

// A row of rooms, closed by walls of their own or by drawn ones that leave gaps of centimetres at their corners, with doors,
// passages and windows between and outwards, some of them oddly high, low or deep.
static void draw_row(Draft *d, Random *r, int storey) {
    double x = random_between(r, 0, 2), y = random_between(r, -6, -4), wall = random_between(r, 0.05, 0.3);
    bool own = random_index(r, 2);
    for (int i = 0; i < 3; i++) {
        double width = random_between(r, 2, 4), z = d->b.storeys[storey].floor;
        draft_room(d, storey, x, y, x + width, y + 3);
        SketchRoom *room = &d->s.rooms[d->s.room_count - 1];
        if (own) room->wall = wall;
        if (random_index(r, 3) == 0) room->z0 = z + random_between(r, -0.4, 0.4);
        if (random_index(r, 4) == 0) room->z1 = z + random_between(r, 1.5, 3);
        double low = y - wall / 2, high = y + 3 + wall / 2, gap = random_between(r, -0.1, 0.1);
        if (!own) {
            draft_wall(d, storey, x - wall, low, x + width + wall - gap, low, wall, DRAFT_HEIGHT);
            draft_wall(d, storey, x + width, high, x - wall, high, wall, DRAFT_HEIGHT);
            draft_wall(d, storey, x + width + wall / 2, y - wall, x + width + wall / 2, y + 3 + wall - gap,
                       wall, DRAFT_HEIGHT);
            if (i == 0)
                draft_wall(d, storey, x - wall / 2, y + gap, x - wall / 2, y + 3 + wall, wall, DRAFT_HEIGHT);
        }
        SketchOpening *o = draft_opening(d, (OpeningKind)random_index(r, OPENING_KINDS), storey,
                                         x + width + wall / 2, y + random_between(r, 0, 3), M_PI / 2,
                                         random_between(r, 0.3, 1.2), random_between(r, 0, 0.3));
        o->sill += random_between(r, -0.3, 0.5);
        for (int side = 0; side < 2; side++)
            draft_opening(d, (OpeningKind)random_index(r, OPENING_KINDS), storey, x + width / 2,
                          side ? high : low, 0, random_between(r, 0.3, 2), wall);
        x += width + wall;
    }
}

// Materials, turns and swings at random, walls and rooms either way round.
static void dress(Draft *d, Random *r) {
    Sketch *s = &d->s;
    for (int i = 0; i < s->point_count; i++) s->edge_material[i] = random_index(r, 6) - 1;
    for (int i = 0; i < s->wall_count; i++) {
        Vec2 *p = s->points + s->walls[i].first_point;
        for (int k = 0, n = s->walls[i].point_count; i % 3 == 0 && k < n / 2; k++) {
            Vec2 other = p[n - 1 - k];
            p[n - 1 - k] = p[k];
            p[k] = other;
        }
    }
    for (int i = 0; i < s->room_count; i++) {
        s->rooms[i].wall_material = random_index(r, 6) - 1;
        s->rooms[i].floor_material = random_index(r, 4);
        s->rooms[i].ceiling_material = random_index(r, 4);
    }
    for (int i = 0; i < s->opening_count; i++) {
        SketchOpening *o = &s->openings[i];
        o->hinge = random_index(r, 3);
        o->swing = random_between(r, -2, 2);
        o->slide = random_index(r, 3) ? 0 : random_between(r, -1, 1);
        o->open = random_unit(r);
        o->glazed = random_index(r, 4) == 0;
        o->material = random_index(r, 6) - 1;
    }
}

// A plan with all that makes plans hard; false where nothing in it is enclosed.
static bool random_plan(int seed, Draft *d) {
    Random r = {(uint64_t)seed + 5000};
    int storeys = 1 + random_index(&r, 3);
    *d = draft_new(storeys);
    d->s.ground = random_index(&r, 3) ? 0 : random_between(&r, -1, 3);
    if (seed % 3 == 1) {
        d->turn = random_between(&r, 0, 6);
        d->shift = vec2(random_between(&r, -1000, 1000), random_between(&r, -1000, 1000));
    }
    for (int k = 0; k < storeys; k++) {
        if (seed % 2 || seed % 4 == 0) draw_row(d, &r, k);
        if (seed % 10 == 3) draw_arc(d, &r, k);
        if (seed % 4) draft_random_storey(d, &r, k, true);
    }
    if (seed % 2) dress(d, &r);
    Error error = {""};
    return maps_enclose(&d->s, &d->b, &d->arena, &error);
}

// Proves that the free space found in random plans is what it was.
Test(sums, plans, .timeout = 60) {
    SumFile f = sums_begin("plans");
    for (int seed = 1; seed <= 150; seed++) {
        Draft d;
        if (random_plan(seed, &d)) sum_building(&f, arena_format(&f.arena, "plan-%d", seed), &d.b);
        draft_free(&d);
    }
    sums_end(&f);
}

// Proves that readers and enclosing make the same of our own homes and plans, and of a small file of each hostile kind.
Test(sums, files, .timeout = 60) {
    SumFile f = sums_begin("files");
    const char *folder = support_folder(&f.arena);
    for (int i = 0; i < FILE_COUNT; i++) {
        Arena arena = {0};
        Building b;
        read_building(FILES[i], &arena, &b);
        sum_building(&f, strrchr(FILES[i], '/') + 1, &b);
        arena_free(&arena);
    }
    for (int i = 0; HOSTILE_KINDS[i].name; i++) {
        Arena arena = {0};
        Building b;
        if (read_hostile(&HOSTILE_KINDS[i], folder, &arena, &b)) sum_building(&f, HOSTILE_KINDS[i].name, &b);
        arena_free(&arena);
    }
    sums_end(&f);
}

// ---- cells, pairs and trees

typedef struct Seen {
    Building building;
    CellGraph graph;
    PairSet pairs;
    StabForest forest;
} Seen;

static void sum_cells(SumFile *f, const CellGraph *g) {
    Sum cells = {0}, portals = {0}, squares = {0};
    for (int i = 0; i < g->cell_count; i++) {
        const Cell *c = &g->cells[i];
        int words[] = {c->region,     c->first_edge, c->edge_count, c->first_face,
                       c->face_count, c->first_way,  c->way_count,  c->outdoors};
        sum_ints(&cells, words, sizeof words / sizeof *words);
        sum_add2(&cells, vec2(c->z0, c->z1));
        sum_box(&cells, c->box);
    }
    for (int i = 0; i < g->plan_count; i++) sum_add2(&cells, g->plan[i]);
    for (int i = 0; i < g->face_count; i++) {
        sum_add3(&cells, g->faces[i].n);
        sum_add(&cells, g->faces[i].d);
    }
    for (int i = 0; i < g->portal_count; i++) {
        const Portal *p = &g->portals[i];
        int words[] = {p->cell[0], p->cell[1], p->first_vertex, p->vertex_count, p->horizontal, p->door};
        sum_ints(&portals, words, sizeof words / sizeof *words);
        sum_add3(&portals, p->plane.n);
        sum_add(&portals, p->plane.d);
        sum_add2(&portals, p->left);
        sum_add2(&portals, p->right);
    }
    for (int i = 0; i < g->portal_vertex_count; i++) sum_add3(&portals, g->portal_vertices[i]);
    for (int i = 0; i < g->way_count; i++) sum_ints(&portals, &g->ways[i].portal, 2);
    for (int i = 0; i < g->cell_count; i++) {
        sum_add2(&squares, g->meshes[i].origin);
        sum_add(&squares, g->meshes[i].size);
        sum_ints(&squares, &g->meshes[i].nx, 3);
    }
    sum_ints(&squares, g->square_first, g->square_count + 1);
    sum_ints(&squares, g->square_objects, g->square_object_count);
    int located = g->locator.nx * g->locator.ny;
    sum_ints(&squares, g->locator_first, located + 1);
    sum_ints(&squares, g->locator_cells, g->locator_first[located]);
    sum_add(&squares, g->dropped_slivers);
    sums_sum(f, "cells", cells);
    sums_sum(f, "portals", portals);
    sums_sum(f, "squares", squares);
    sum_polygons(f, g->objects, g->object_count, g->polygons, g->polygon_count, g->vertices, g->vertex_count);
}

static void sum_trees(SumFile *f, const Seen *s) {
    Sum pairs = {0}, trees = {0}, rows = {0};
    for (int i = 0; i < s->graph.cell_count; i++) {
        for (int k = 0; k < s->graph.cell_count; k++) {
            sum_add(&pairs, pair_bit(s->pairs.seen, s->pairs.words, i, k));
            sum_add(&pairs, pair_bit(s->pairs.proven, s->pairs.words, i, k));
            sum_add(&rows, vis_sees(&s->forest, i, k));
        }
        sum_add(&trees, s->forest.bounded[i]);
    }
    sum_ints(&trees, s->forest.root, s->forest.cell_count + 1);
    for (int i = 0; i < s->forest.node_count; i++) sum_ints(&trees, &s->forest.nodes[i].cell, 4);
    // The cost of searching tells of prunings that became weaker, though nothing is decided otherwise.
    Sum work = {0};
    sum_add(&work, (double)s->pairs.work.chains);
    sum_add(&work, (double)s->pairs.work.clips);
    sum_add(&work, (double)s->pairs.work.separators);
    sum_add(&work, (double)s->pairs.work.given_up);
    sums_sum(f, "pairs", pairs);
    sums_sum(f, "work", work);
    sums_sum(f, "trees", trees);
    sums_sum(f, "rows", rows);
}

static void see(const Building *b, Arena *arena, Seen *out) {
    Error error = {""};
    VisOptions options = vis_default_options();
    options.threads = 1;
    cr_assert(vis_build_cells(b, &options, arena, &out->graph, &error), "%s", error.text);
    pair_method_finest()->find(&out->graph, &(PairOptions){.threads = 1}, NULL, arena, &out->pairs);
    options.known = out->pairs.seen;
    cr_assert(vis_build_forest(&out->graph, &options, NULL, arena, &out->forest));
}

// ---- queries

static Vec3 point_in(const CellGraph *g, Random *random, int cell) {
    return g->cells[cell].face_count ? soup_fixture_point(g, random, cell) : fixture_point(g, random, cell);
}

// Some views of a building by all methods that cull: all doors open, all closed, each as chance will have it.
static void sum_views(SumFile *f, const Seen *s, int views, Arena *arena) {
    const CellGraph *g = &s->graph;
    Random random = {17};
    VisQuery *query = vis_query_new(g, &s->forest, arena);
    float *open = ARENA_ARRAY(arena, float, s->building.opening_count + 1);
    Sum seen[QUERY_CULLINGS] = {{0}}, tested[QUERY_CULLINGS] = {{0}};
    for (int i = 0; i < views; i++) {
        int cell = random_index(&random, g->cell_count);
        Vec3 at = point_in(g, &random, cell);
        Camera camera = camera_look(at, random_between(&random, 0, 2 * M_PI), random_between(&random, -1, 1),
                                    random_between(&random, 0.5, 2), 320, 180);
        Eye eye = i % 4 ? walk_eye(&camera) : (Eye){.position = at};
        for (int k = 0; k < s->building.opening_count; k++)
            open[k] = i % 3 == 1 ? 0 : (float)fmax(0, random_between(&random, -1, 1));
        for (int m = CULL_FRUSTUM; m < QUERY_CULLINGS; m++) {
            VisResult r = vis_query(query, &eye, cell, i % 3 ? open : NULL, (Culling)m);
            for (int k = 0; k < r.cell_count; k++) {
                sum_add(&seen[m], r.cells[k].cell);
                sum_add(&seen[m], r.cells[k].distance);
            }
            sum_ints(&seen[m], r.objects, r.object_count);
            sum_add(&seen[m], r.polygon_count);
            sum_add(&seen[m], r.eye_cell);
            sum_add(&tested[m], r.portals_tested);
            sum_add(&tested[m], r.objects_tested);
        }
    }
    for (int m = CULL_FRUSTUM; m < QUERY_CULLINGS; m++) {
        sums_sum(f, CULLING_NAMES[m], seen[m]);
        sums_sum(f, "tested", tested[m]);
    }
}

static void sum_sight(SumFile *f, const char *name, Building *b, int views, Arena *arena) {
    Seen s = {.building = *b};
    see(&s.building, arena, &s);
    sums_scene(f, name);
    sum_cells(f, &s.graph);
    sum_trees(f, &s);
    if (s.graph.cell_count > 0) sum_views(f, &s, views, arena);
}

// Proves that cells, portals, visible pairs, stab trees, and what is seen by each method are what they were: in our own homes and
// plans, in rooms at random with doors and storeys, in soups aligned and turned, in given cells.
Test(sums, sight, .timeout = 120) {
    SumFile f = sums_begin("sight");
    Random random = {3};
    for (int i = 0; i < FILE_COUNT - 1; i++) {
        Arena arena = {0};
        Building b;
        read_building(FILES[i], &arena, &b);
        sum_sight(&f, strrchr(FILES[i], '/') + 1, &b, 60, &arena);
        arena_free(&arena);
    }
    for (int i = 0; i < 12; i++) {
        Arena arena = {0};
        Building *b = i < 6 ? fixture_rooms(&arena, &random, 2 + i % 3, 3, 1 + i % 2)
                            : soup_fixture_house(&arena, &random, 2 + i % 2, 2);
        SoupPose pose = {random_between(&random, 0.5, 20), random_between(&random, 0, 6),
                         fixture_direction(&random), vec3(100, -30, 7)};
        if (i == 10) pose.shift = vec3(-70, 200, -9);
        if (i > 8) b = soup_fixture_posed(&arena, b, &pose);
        sum_sight(&f,
                  arena_format(&f.arena, "%s-%d",
                               i < 6   ? "rooms"
                               : i > 8 ? "soup-turned"
                                       : "soup",
                               i),
                  b, 40, &arena);
        arena_free(&arena);
    }
    for (int seed = 1; seed <= 24; seed++) {
        Draft d;
        if (random_plan(seed, &d) && d.b.region_count < 30)
            sum_sight(&f, arena_format(&f.arena, "plan-%d", seed), &d.b, 20, &d.arena);
        draft_free(&d);
    }
    for (int i = 0; i < 6; i++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + i);
        Building b = *row_graph(&arena, &row)->building;
        sum_sight(&f, arena_format(&f.arena, "row-%d", i), &b, 0, &arena);
        arena_free(&arena);
    }
    sums_end(&f);
}

// The same of a small file of each hostile kind: what is too crowded, too long or too thin for others.
Test(sums, hostile_sight, .timeout = 120) {
    SumFile f = sums_begin("hostile-sight");
    const char *folder = support_folder(&f.arena);
    for (int i = 0; HOSTILE_KINDS[i].name; i++) {
        Arena arena = {0};
        Building b;
        if (read_hostile(&HOSTILE_KINDS[i], folder, &arena, &b))
            sum_sight(&f, HOSTILE_KINDS[i].name, &b, 6, &arena);
        arena_free(&arena);
    }
    sums_end(&f);
}

// ---- bodies and doors

// Somebody who walks about at random, turns off where nothing gives way, and opens and closes the doors on the way.
static void sum_walk(SumFile *f, const char *path) {
    enum { STEPS = 6000 };
    Arena arena = {0};
    Building b;
    CellGraph g;
    Error error = {""};
    VisOptions options = vis_default_options();
    read_building(path, &arena, &b);
    cr_assert(vis_build_cells(&b, &options, &arena, &g, &error), "%s", error.text);
    Doors doors = doors_new(&g, &arena);
    BodyWorld world = body_world(&g, doors.open, &arena);
    Body body = {.cell = -1};
    Random random = {23};
    Sum ways = {0}, moved = {0}, work = {0};
    double yaw = b.start_yaw;
    bool placed = body_place_near(&body, &world, b.start);
    for (int i = 0; i < STEPS && placed; i++) {
        if (i % 600 == 599) {  // somewhere else
            int cell = random_index(&random, g.cell_count);
            sum_add(&ways, body_place_near(&body, &world, point_in(&g, &random, cell)));
        }
        Vec3 before = body.foot;
        body_step(&body, &world, vec2(0.04 * cos(yaw), 0.04 * sin(yaw)), 1.0 / 40);
        if (hypot(body.foot.x - before.x, body.foot.y - before.y) < 0.02)
            yaw += random_between(&random, 0.5, 2.5);
        if (i % 10 == 0) {
            Vec3 eye = vec3(body.foot.x, body.foot.y, body.foot.z + body_eye(&body));
            int door = doors_looked_at(&doors, eye, body.cell, vec3(cos(yaw), sin(yaw), 0), DOORS_REACH);
            if (door >= 0 && random_index(&random, 3) == 0) sum_add(&moved, doors_toggle(&doors, door));
            sum_add(&moved, door);
        }
        doors_advance(&doors, 1.0 / 40, &body);
        sum_add3(&ways, body.foot);
        sum_add3(&ways, vec3(body.height, body.head, body.cell));
        for (int k = 0; k < b.opening_count && i % 20 == 0; k++) {
            sum_add(&moved, (double)doors.open[k]);
            sum_add(&moved, doors.halt[k]);
        }
    }
    sum_add3(&work, vec3((double)world.wall_tests, (double)world.object_tests, (double)world.pieces));
    sum_add2(&work, vec2((double)world.relocations, (double)world.refused));
    sums_scene(f, strrchr(path, '/') + 1);
    sums_sum(f, "ways", ways);
    sums_sum(f, "doors", moved);
    sums_sum(f, "work", work);
    arena_free(&arena);
}

// Proves that bodies go, climb, duck and slide as they did, and doors move, halt and go on.
Test(sums, walks, .timeout = 60) {
    SumFile f = sums_begin("walks");
    for (int i = 0; i < FILE_COUNT; i++) sum_walk(&f, FILES[i]);
    sums_end(&f);
}
