// room_light.c - light is linear and openings are black or not: a room's light from other rooms is the difference of two solutions. With
// all openings between rooms black, no room sees another one. So one solution has every room's own light, and it is shot along the rows
// that are there, less what they have behind black panes (J. M. Airey et al. 1990 for sums; the split by portals is our own).
#include "radiosity/planner/room_light.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/gather.h"

// ---- light

void room_lux(double weight[3]) {
    const double share[3] = {LIGHT_LUMINOUS};
    for (int c = 0; c < 3; c++) weight[c] = LIGHT_LUMENS_PER_WATT * share[c];
}

void room_daylight_factor(const Daylight *day, double weight[3]) {
    const double share[3] = {LIGHT_LUMINOUS};
    double level[3];
    daylight_horizontal(day, level);
    for (int c = 0; c < 3; c++) weight[c] = share[c] / light_luminous(level);
}

static bool shoot_light(RoomLight *light, const Mesh *mesh, const Progress *progress, Arena *arena,
                        RadSolution *out, Error *error) {
    if (!rad_start_dark(mesh, arena, out, error)) return false;
    bool good = !daylight_shines(&light->day) ||
                rad_shine(mesh, light->forest, light->door_open, &light->options, &light->day, progress, out);
    if (good && rgb_sum(out->emitted) > 0)
        good = !rad_shoot(mesh, light->forest, light->door_open, &light->options, progress, out).stopped;
    // Patches that are strong when rooms are open are so when they are closed.
    shoot_rows_settle(light->rows);
    return good || error_set(error, "stopped before all light was found");
}

bool room_light_open(RoomLight *light, const Progress *progress, Arena *arena, Error *error) {
    // Nothing is gathered along rows, which need no sky then.
    static const Daylight NIGHT;
    light->options.gather = false;
    light->rows =
        shoot_rows_new(light->mesh, light->forest, light->door_open, &light->options, &NIGHT, arena);
    light->options.rows = light->rows;
    return shoot_light(light, light->mesh, progress, arena, &light->open, error);
}

bool room_light_close(RoomLight *light, const Progress *progress, Arena *arena, Error *error) {
    light->closed_mesh = *light->mesh;
    light->closed_mesh.panes = panes_between_rooms(light->mesh->graph, &light->mesh->panes, arena);
    shoot_rows_close(light->rows, &light->closed_mesh);
    return shoot_light(light, &light->closed_mesh, progress, arena, &light->closed, error);
}

void room_light_end(RoomLight *light) {
    if (light->rows) shoot_rows_end(light->rows);
    light->rows = NULL;
}

// ---- points

RoomPlan room_plan(const CellGraph *graph, double height, Arena *arena) {
    const Building *b = graph->building;
    RoomPlan plan = {.rooms = ARENA_ARRAY(arena, PlannedRoom, b->region_count + 1)};
    for (int r = 0; r < b->region_count; r++) {
        const Region *region = &b->regions[r];
        if (region->kind != REGION_ROOM) continue;
        plan.low_count += region->z0 + height >= region->z1;
        if (region->z0 + height >= region->z1) continue;
        PlannedRoom *room = &plan.rooms[plan.room_count++];
        *room = (PlannedRoom){r, region->z0 + height, room_grid(b, region, arena), plan.point_count};
        plan.point_count += room->grid.point_count;
    }
    plan.points = ARENA_ARRAY(arena, Vec3, plan.point_count + 1);
    for (int r = 0; r < plan.room_count; r++) {
        const PlannedRoom *room = &plan.rooms[r];
        for (int i = 0; i < room->grid.point_count; i++) {
            Vec2 p = room->grid.points[i];
            plan.points[room->first_point + i] = vec3(p.x, p.y, room->plane);
        }
    }
    return plan;
}

// A point with a greater share of backs in view is inside a thing.
static const double INSIDE = 0.99;
// And so is one with less light than this share of the brightest point's: in the open, what walls reflect is more.
static const double DARK = 1e-4;

typedef struct Gathering {
    const RoomPlan *plan;
    const RoomLight *light;
    Gatherer **gatherer;  // [threads]
    RoomValues out;
} Gathering;

static void gather_point(void *context, int index, int thread) {
    const Gathering *g = context;
    static const Vec3 UP = {0, 0, 1};
    Vec3 at = g->plan->points[index];
    ViewPoint from = {at, UP, vis_locate(g->light->mesh->graph, at, -1)};
    double all[3], own[3], inside;
    gather_apart(g->gatherer[thread], &from, all, own, &inside);
    g->out.all[index] = inside > INSIDE ? NAN : room_light_value(g->light, all);
    g->out.own[index] = inside > INSIDE ? NAN : room_light_value(g->light, own);
}

// Inside closed things that are several, as a cupboard on a worktop, fronts are in view, and all is dark.
static void leave_out_dark(const PlannedRoom *room, const RoomValues *values) {
    double brightest = 0;
    for (int i = room->first_point; i < room->first_point + room->grid.point_count; i++)
        if (values->all[i] > brightest) brightest = values->all[i];
    for (int i = room->first_point; i < room->first_point + room->grid.point_count; i++)
        if (brightest > 0 && values->all[i] < DARK * brightest) values->all[i] = values->own[i] = NAN;
}

RoomValues room_values(const RoomPlan *plan, const RoomLight *light, int threads, Arena *arena) {
    Arena scratch = {0};
    GatherScene scene = {light->mesh, light->forest, light->door_open, &light->open, NULL};
    GatherOptions options = gather_default_options();
    options.resolution = daylight_shines(&light->day) ? ROOM_SKY_RESOLUTION : ROOM_RESOLUTION;
    threads = parallel_threads(threads);
    Gathering g = {.plan = plan,
                   .light = light,
                   .gatherer = ARENA_ARRAY(&scratch, Gatherer *, threads),
                   .out = {ARENA_ARRAY(arena, double, plan->point_count + 1),
                           ARENA_ARRAY(arena, double, plan->point_count + 1)}};
    for (int t = 0; t < threads; t++)
        g.gatherer[t] =
            gatherer_new_apart(&scene, &options, &light->closed, &light->closed_mesh.panes, &scratch);
    parallel_for(threads, plan->point_count, gather_point, &g);
    for (int r = 0; r < plan->room_count; r++) leave_out_dark(&plan->rooms[r], &g.out);
    for (int t = 0; t < threads; t++) gatherer_end(g.gatherer[t]);
    arena_free(&scratch);
    return g.out;
}

// ---- figures

static int brightest_first(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p > q ? -1 : p < q;
}

// The least value of the brightest points that make up such a share of all.
static double reached_by(const double *sorted, int count, double share) {
    int last = (int)ceil(share * count - 1e-9) - 1;
    return sorted[last < 0 ? 0 : last];
}

RoomFigures room_figures(const RoomPlan *plan, int index, const RoomValues *values) {
    const PlannedRoom *room = &plan->rooms[index];
    Arena scratch = {0};
    double *sorted = ARENA_ARRAY(&scratch, double, room->grid.point_count + 1), all = 0, own = 0;
    RoomFigures out = {.mean = NAN,
                       .minimum = NAN,
                       .maximum = NAN,
                       .uniformity = NAN,
                       .from_rooms = NAN,
                       .half = NAN,
                       .most = NAN};
    for (int i = room->first_point; i < room->first_point + room->grid.point_count; i++) {
        out.inside += isnan(values->all[i]);
        if (isnan(values->all[i])) continue;
        sorted[out.points++] = values->all[i];
        all += values->all[i];
        own += values->own[i];
    }
    if (out.points > 0) {
        qsort(sorted, (size_t)out.points, sizeof *sorted, brightest_first);
        out.mean = all / out.points;
        out.maximum = sorted[0];
        out.minimum = sorted[out.points - 1];
        out.half = reached_by(sorted, out.points, 0.5);
        out.most = reached_by(sorted, out.points, 0.95);
    }
    if (all > 0) {
        out.uniformity = out.minimum / out.mean;
        // Both lights are shot to the same residual, so what is shut out may be less than nothing by that.
        out.from_rooms = fmax(1 - own / all, 0);
    }
    arena_free(&scratch);
    return out;
}

const char *const DAYLIGHT_LEVEL_NAMES[DAYLIGHT_LEVELS] = {"none", "minimum", "medium", "high"};
const double DAYLIGHT_LEVEL_TARGETS[DAYLIGHT_LEVELS][2] = {{0, 0}, {300, 100}, {500, 300}, {750, 500}};

int daylight_level(double half_lux, double most_lux) {
    int level = DAYLIGHT_LEVEL_HIGH;
    while (level > DAYLIGHT_LEVEL_NONE &&
           !(half_lux >= DAYLIGHT_LEVEL_TARGETS[level][0] && most_lux >= DAYLIGHT_LEVEL_TARGETS[level][1]))
        level--;
    return level;
}
