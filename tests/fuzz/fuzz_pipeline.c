// fuzz_pipeline.c - libFuzzer on all that is done with a building, from its files to ten shots of light: read, checked, cut into
// cells, pairs and trees found, asked for what is seen from eyes at random, walked through while its doors move, meshed, lit.
//
// An input is one file, or several: each behind a line `=== NAME`, the building's own first; of a NAME.sh3d without content
// the others are the entries. A .wad that is none changes a small map's. What is held against each result stands at `demand`.
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/sim/collision_check.h"
#include "engine/sim/door_states.h"
#include "engine/sim/doors.h"
#include "maps/building/lamp_faces.h"
#include "radiosity/shoot/adapt.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/reconstruct.h"
#include "tests/fuzz/target.h"
#include "tests/support/files/home_fixture.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/fixture.h"
#include "visibility/pairs/pairs.h"

// Beyond these an input would take longer than many small ones, which find more.
enum { MOST_POLYGONS = 1200, MOST_CELLS = 40, MOST_UNDER_SKY = 5, MOST_ELEMENTS = 1000, MOST_FILES = 16 };
enum { EYES = 3, STEPS = 12, SHOTS = 10 };

// Ends the run with what does not hold.
#define demand(condition, what)                                                                              \
    if (!(condition)) fail(#condition, what)
static void fail(const char *condition, const char *what) {
    fprintf(stderr, "demanded: %s (%s)\n", condition, what);
    abort();
}

// ---- the files of an input

typedef struct Parts {
    TargetFile files[MOST_FILES];
    int count;
} Parts;

// Up to the next line that begins a file.
static size_t part_end(const char *data, size_t from, size_t size) {
    const char *next = memmem(data + from, size - from, "\n=== ", 5);
    return next ? (size_t)(next - data) + 1 : size;
}

static const char *part_path(Arena *arena, const char *name, size_t length) {
    enum { LONGEST = 60 };
    char *path = arena_format(arena, "/fuzz/%.*s", (int)(length < LONGEST ? length : LONGEST), name);
    for (char *c = path; *c; c++)
        if (*c < ' ' || *c > '~') *c = '_';
    return path;
}

static Parts parts_of(Arena *arena, const unsigned char *bytes, size_t size) {
    Parts parts = {.count = 0};
    const char *data = (const char *)bytes;
    if (size < 4 || memcmp(data, "=== ", 4) != 0) {
        parts.files[parts.count++] = (TargetFile){"/fuzz/main", target_bytes(arena, "", bytes, size)};
        return parts;
    }
    for (size_t at = 0; at < size && parts.count < MOST_FILES;) {
        size_t end = part_end(data, at, size), name = at + 4;
        const char *line = memchr(data + name, '\n', end - name);
        size_t name_end = line ? (size_t)(line - data) : end, content = line ? name_end + 1 : end;
        parts.files[parts.count++] = (TargetFile){part_path(arena, data + name, name_end - name),
                                                  target_bytes(arena, "", bytes + content, end - content)};
        at = end;
    }
    return parts;
}

static bool ends_in(const char *path, const char *suffix) {
    size_t length = strlen(path), n = strlen(suffix);
    return length > n && strcmp(path + length - n, suffix) == 0;
}

static Bytes pack(Arena *arena, const Parts *parts) {
    HomeEntry entries[MOST_FILES];
    int count = 0;
    for (int i = 1; i < parts->count; i++) {
        HomeEntry entry = {parts->files[i].path + strlen("/fuzz/"), parts->files[i].content.data,
                           parts->files[i].content.size};
        bool again = entry.name[0] == 0;
        for (int k = 0; k < count; k++) again = again || strcmp(entries[k].name, entry.name) == 0;
        if (!again) entries[count++] = entry;
    }
    return home_zip(arena, entries, count);
}

// The packed and the spoilt parts come in the place of the first file.
static void make_first(Arena *arena, Parts *parts) {
    TargetFile *first = &parts->files[0];
    if (ends_in(first->path, ".sh3d") && first->content.size <= 1) first->content = pack(arena, parts);
    if (ends_in(first->path, ".wad") && (first->content.size < 4 || first->content.data[1] != 'W'))
        first->content = wad_spoilt(arena, first->content.data, first->content.size);
}

// ---- what is seen

typedef struct Scene {
    Arena *arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    float *doors;  // [opening_count + 1]
    Random random;
} Scene;

static void check_cells(const Scene *s) {
    const CellGraph *g = &s->graph;
    demand(g->cell_count > 0, "cells");
    for (int c = 0; s->building.form == FORM_REGIONS && c < g->cell_count; c++) {
        const Region *region = &s->building.regions[g->cells[c].region];
        double z0 = g->cells[c].z0, z1 = g->cells[c].z1;
        // Outdoors the sky and the world's border are open. Tolerance: slivers left out, and rounding far from the origin.
        double tolerance = 1e-6 * (1 + g->dropped_slivers) + 1e-7 * (z1 - z0) * vec3_length(g->box.max);
        if (region->kind == REGION_OUTDOORS || region->floor_material < 0 || region->ceiling_material < 0)
            continue;
        double open = fixture_uncovered(g, c);
        demand(open < tolerance, "a cell is closed by portals and surfaces");
        demand(open > -tolerance || s->building.inlay_count > 1, "but for inlays nothing lies twice");
    }
}

static void find_trees(Scene *s, const VisOptions *options) {
    PairOptions pairs = {.threads = 1};
    PairSet set;
    VisOptions vis = *options;
    pair_method_finest()->find(&s->graph, &pairs, NULL, s->arena, &set);
    for (int c = 0; c < s->graph.cell_count; c++)
        demand(pair_bit(set.seen, set.words, c, c), "a cell sees itself");
    CellRows known = cell_rows_of_matrix(set.seen, set.cell_count, s->arena);
    vis.known = &known;
    demand(vis_build_forest(&s->graph, &vis, NULL, s->arena, &s->forest), "trees");
}

// Well inside the cell: an eye at a portal or a wall sees more than its cell does.
static bool is_clear(const CellGraph *g, int c, Vec3 p) {
    static const double CLEAR = 0.02;
    const Cell *cell = &g->cells[c];
    bool clear = p.z > cell->z0 + CLEAR && p.z < cell->z1 - CLEAR;
    for (int i = 0; i < cell->face_count; i++)
        clear = clear && plane_distance(g->faces[cell->first_face + i], p) > CLEAR;
    for (int i = 0; i < cell->edge_count && cell->face_count == 0; i++) {
        Vec2 a = g->plan[cell->first_edge + i], b = g->plan[cell->first_edge + (i + 1) % cell->edge_count];
        Vec2 along = vec2_sub(b, a);
        clear = clear && vec2_cross(along, vec2_sub(vec2(p.x, p.y), a)) > CLEAR * vec2_length(along);
    }
    return clear;
}

static bool holds(const VisResult *result, int cell) {
    for (int i = 0; i < result->cell_count; i++)
        if (result->cells[i].cell == cell) return true;
    return false;
}

// In a building of prisms every cell that a straight line from the eye comes through is in view.
static void check_line(Scene *s, const VisResult *result, int cell, Vec3 eye) {
    Trace trace;
    if (!fixture_trace(&s->graph, cell, eye, fixture_direction(&s->random), s->doors, &trace)) return;
    for (int i = 0; i < trace.count; i++) {
        demand(vis_sees(&s->forest, cell, trace.cells[i]), "a sightline's cells are pairs");
        demand(holds(result, trace.cells[i]), "a query finds a sightline's cells");
    }
}

static void look(Scene *s, VisQuery *query, Vec3 position) {
    Eye eye = {.position = position};
    int cell = vis_locate(&s->graph, position, -1);
    bool clear = cell >= 0 && is_clear(&s->graph, cell, position);
    for (int method = 0; method < QUERY_CULLINGS; method++) {
        VisResult result = vis_query(query, &eye, cell, s->doors, (Culling)method);
        if (!clear || method < CULL_PORTALS) continue;
        for (int i = 0; i < result.cell_count && method >= CULL_PLAN; i++)
            demand(vis_sees(&s->forest, cell, result.cells[i].cell), "a query stays in the visible set");
        if (s->building.form == FORM_REGIONS) check_line(s, &result, cell, position);
    }
}

static void see(Scene *s) {
    VisQuery *query = vis_query_new(&s->graph, &s->forest, s->arena);
    for (int i = 0; i < EYES; i++) {
        int cell = random_index(&s->random, s->graph.cell_count);
        Box box = s->graph.cells[cell].box;
        for (int o = 0; o < s->building.opening_count; o++)
            s->doors[o] = walk_door_share(&s->building, o, WALK_DOORS_RANDOM, &s->random);
        look(s, query,
             s->graph.cells[cell].face_count == 0 ? fixture_point(&s->graph, &s->random, cell)
                                                  : vec3(random_between(&s->random, box.min.x, box.max.x),
                                                         random_between(&s->random, box.min.y, box.max.y),
                                                         random_between(&s->random, box.min.z, box.max.z)));
    }
}

// ---- who walks

// A soup with holes ends over a head, or at a foot: its cells are no taller than what is built. And a polygon that is bent, by up
// to MAPS_PLANARITY, has no one place.
static bool is_excused(const Scene *s, CollisionFault fault, int what) {
    if (fault == COLLISION_OUTSIDE) return s->building.form == FORM_SOUP;
    if ((fault != COLLISION_IN_SOLID && fault != COLLISION_THROUGH_SOLID) || what < 0) return false;
    const Polygon *p = &s->graph.polygons[what];
    const Vec3 *v = s->graph.vertices + p->first_vertex;
    return polygon_bend(v, p->vertex_count, plane_of_polygon(v, p->vertex_count)) > BODY_TOLERANCE / 10;
}

static void check_body(const Scene *s, CollisionCheck *check, const Body *body, BodyTrace *trace) {
    int what;
    CollisionFault fault = collision_check_place(check, s->doors, body->foot, body->height, &what);
    demand(fault == COLLISION_NONE || is_excused(s, fault, what), COLLISION_FAULT_NAMES[fault]);
    for (int i = 1; i < trace->count; i++) {
        Vec3 from = trace->points[i - 1], to = trace->points[i], corner = vec3(from.x, from.y, to.z);
        if (from.z > to.z) corner = vec3(to.x, to.y, from.z);
        fault = collision_check_way(check, s->doors, from, corner, &what);
        if (fault == COLLISION_NONE) fault = collision_check_way(check, s->doors, corner, to, &what);
        demand(fault == COLLISION_NONE || is_excused(s, fault, what), COLLISION_FAULT_NAMES[fault]);
    }
    trace->count = 0;
}

static void walk(Scene *s) {
    enum { TRACE = 1024 };
    const Building *b = &s->building;
    Doors doors = doors_new(&s->graph, s->arena);
    s->doors = doors.open;
    BodyWorld world = body_world(&s->graph, doors.open, s->arena);
    BodyTrace trace = {.points = ARENA_ARRAY(s->arena, Vec3, TRACE), .capacity = TRACE};
    CollisionCheck *check = collision_check_new(&s->graph, s->arena);
    Body body = {.cell = -1};
    if (!body_place_near(&body, &world, vec3(b->start.x, b->start.y, b->start.z - BODY_EYE))) return;
    target_count(TARGET_WALKED);
    check_body(s, check, &body, &trace);
    double heading = 0;
    for (int i = 0; i < STEPS; i++) {
        double seconds = i % 8 == 7 ? 2 : 0.05, length = random_between(&s->random, 0, 1.5);
        if (b->opening_count > 0 && i % 3 == 0)
            doors_toggle(&doors, random_index(&s->random, b->opening_count));
        if (i % 4 == 0) heading = random_between(&s->random, 0, 2 * M_PI);
        doors_advance(&doors, seconds, &body);
        check_body(s, check, &body, &trace);
        world.trace = &trace;
        body_step(&body, &world, vec2(length * cos(heading), length * sin(heading)), seconds);
        world.trace = NULL;
        check_body(s, check, &body, &trace);
    }
}

// ---- light

// Something always shines: else most inputs would end here.
static void kindle(Building *b) {
    float sum = 0;
    for (int i = 0; i < b->material_count; i++) {
        Rgb e = b->materials[i].emission;
        sum += e.r + e.g + e.b;
    }
    for (int i = 0; i < b->material_count && sum <= 0; i++) b->materials[i].emission = (Rgb){1, 2, 3};
}

static double fitting_element(const CellGraph *g) {
    enum { ABOUT = 80 };
    double area = 0;
    for (int i = 0; i < g->polygon_count; i++)
        area += polygon_area(g->vertices + g->polygons[i].first_vertex, g->polygons[i].vertex_count);
    return fmax(sqrt(area / ABOUT), 0.3);
}

static bool mesh_of(Scene *s, const RadOptions *rad, Mesh *out) {
    MeshOptions options = mesh_default_options();
    options.element = fitting_element(&s->graph);
    if (options.element > 100) return false;  // of a land, not of a building
    options.threads = 1;
    options.proxies = proxies_find(&s->graph, options.proxy, s->arena);
    Error error = {""};
    // Slivers a kilometre long have more elements than their area tells.
    bool made = mesh_build(&s->graph, s->doors, &options, s->arena, out, &error);
    if (made && out->element_count > MOST_ELEMENTS) return false;
    if (random_index(&s->random, 4) == 0) {
        AdaptOptions adapt = adapt_default_options();
        AdaptScene scene = {&s->graph, &s->forest, s->doors, NULL};
        adapt.few = 300;
        adapt.smallest = options.element / 2;
        made = adapt_mesh(&scene, &options, &adapt, rad, NULL, s->arena, out, &error);
    }
    demand(made || error.text[0], "a mesh, or a sentence");
    return made && out->element_count <= MOST_ELEMENTS;
}

// Emitted = absorbed + escaped + unshot. Tolerance: of all that was ever added up, rounding.
static void check_power(const Mesh *mesh, const RadSolution *solution) {
    for (int c = 0; c < 3; c++) {
        double rest = 0;
        for (int p = 0; p < mesh->patch_count; p++) rest += solution->unshot[p][c] * mesh->patches[p].area;
        double kept = solution->absorbed[c] + solution->escaped[c] + rest, emitted = solution->emitted[c];
        demand(fabs(kept - emitted) <= 1e-5 * emitted, "no power is lost");
        for (int e = 0; e < mesh->element_count; e++)
            demand(solution->radiosity[e][c] >= 0 && isfinite(solution->radiosity[e][c]), "light is light");
    }
}

static int method_count(void) {
    int count = 0;
    while (FORM_FACTOR_METHODS[count]) count++;
    return count;
}

// An even sky, or a sun anywhere above the horizon.
static Daylight random_day(Random *random) {
    if (random_index(random, 2)) return daylight_uniform((const double[]){3, 3, 4});
    SunPosition sun = {M_PI / 2 * random_unit(random), 2 * M_PI * random_unit(random), 1};
    return daylight_of(&sun, 0, random_index(random, DAYLIGHT_WEATHERS));
}

static void light(Scene *s) {
    RadOptions options = rad_default_options();
    Mesh mesh;
    RadSolution solution;
    Error error = {""};
    // Half of all by the method that bakes, half by any.
    if (random_index(&s->random, 2))
        options.method = FORM_FACTOR_METHODS[random_index(&s->random, method_count())];
    options.form_factor.resolution = 16;
    options.threads = 1;
    options.shots = SHOTS;
    options.residual = 1e-9;
    options.lamp_detail = 1;
    kindle(&s->building);
    if (!mesh_of(s, &options, &mesh)) return;
    bool day = random_index(&s->random, 16) == 0 && s->graph.cell_count <= MOST_UNDER_SKY;
    if (!(day ? rad_start_dark : rad_start)(&mesh, s->arena, &solution, &error)) {
        demand(error.text[0], "light, or a sentence");
        return;
    }
    if (day) {
        Daylight sky = random_day(&s->random);
        rad_shine(&mesh, &s->forest, s->doors, &options, &sky, NULL, &solution);
    }
    rad_shoot(&mesh, &s->forest, s->doors, &options, NULL, &solution);
    target_count(TARGET_SHOT);
    check_power(&mesh, &solution);
    VertexLight shown = reconstruct_light(&mesh, &solution, s->arena);
    for (int i = 0; i < mesh.corner_count; i++)
        demand(isfinite(shown.corner[i][0] + shown.corner[i][1] + shown.corner[i][2]),
               "what is shown is light");
}

// ---- all of it

static bool open_scene(Scene *s, const char *path) {
    VisOptions options = vis_default_options();
    Error error = {""};
    options.threads = 1;
    if (!maps_read(path, s->arena, &s->building, &error)) {
        demand(error.text[0], "a building, or a sentence");
        return false;
    }
    target_count(TARGET_PASSED);
    if (s->building.polygon_count > MOST_POLYGONS) return false;
    if (s->building.hash % 2) lamp_faces_add(s->arena, &s->building);
    if (!vis_build_cells(&s->building, &options, s->arena, &s->graph, &error)) {
        demand(error.text[0], "cells, or a sentence");
        return false;
    }
    check_cells(s);
    if (s->graph.cell_count > MOST_CELLS || s->graph.polygon_count > MOST_POLYGONS) return false;
    find_trees(s, &options);
    target_count(TARGET_CELLS);
    return true;
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Scene s = {.arena = target_begin()};
    Parts parts = parts_of(s.arena, data, size);
    make_first(s.arena, &parts);
    target_serve(parts.files, parts.count);
    bool opened = open_scene(&s, parts.files[0].path);
    target_serve(NULL, 0);
    if (!opened) {
        target_forget();
        return 0;
    }
    s.random.state = s.building.hash;
    s.doors = ARENA_ARRAY(s.arena, float, s.building.opening_count + 1);
    see(&s);
    if (s.building.form == FORM_CELLS) return 0;
    walk(&s);
    light(&s);
    return 0;
}
