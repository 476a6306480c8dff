// bench_planner.c - how right the light of rooms is that `enfilade light` tells, against path tracing at the same points, and its time.
#include <stdio.h>
#include <string.h>

#include "engine/app/planned_light.h"
#include "engine/bench/bench.h"
#include "radiosity/truth/path_tracer.h"

static const char HEAD[] = "building,source,room,points,mean,mean_truth,mean_error_percent,minimum,minimum_"
                           "truth,minimum_error_percent,"
                           "uniformity,uniformity_truth,uniformity_off,from_rooms_share,from_rooms_truth,"
                           "truth_error_percent,rooms_work_seconds\n";

// Beyond so many paths a point stays as uncertain as it is.
static const long long MOST_PATHS = 4000000;
// A room's darkest points, among which is the least, are asked again with this share of the error.
enum { DARKEST = 4 };
static const double DARKEST_ERROR = 0.25;

typedef struct Truth {
    double *all, *own, *error;  // [points of the room] as RoomValues; relative standard error of `all`
} Truth;

// Asks for those points that are `wanted`.
static void ask(const RoomLight *source, const PathTracer *tracer, const Vec3 *points, const bool *wanted,
                int count, double error, uint64_t seed, double *out, double *uncertain) {
    Arena scratch = {0};
    PathQuery *queries = ARENA_ARRAY(&scratch, PathQuery, count + 1);
    PathResult *results = ARENA_ARRAY(&scratch, PathResult, count + 1);
    int asked = 0, *which = ARENA_ARRAY(&scratch, int, count + 1);
    for (int i = 0; i < count; i++) {
        if (!wanted[i]) continue;
        which[asked] = i;
        queries[asked++] = (PathQuery){.point = points[i],
                                       .normal = vec3(0, 0, 1),
                                       .relative_error = error,
                                       .most_paths = MOST_PATHS,
                                       .seed = seed + (uint64_t)i};
    }
    path_tracer_irradiance(tracer, queries, asked, 0, results);
    for (int k = 0; k < asked; k++) {
        out[which[k]] = room_light_value(source, results[k].irradiance);
        if (uncertain)
            uncertain[which[k]] = room_light_value(source, results[k].standard_error) / out[which[k]];
    }
    arena_free(&scratch);
}

static void mark_darkest(const double *value, int count, bool *marked) {
    for (int k = 0; k < DARKEST; k++) {
        int darkest = -1;
        for (int i = 0; i < count; i++)
            if (!isnan(value[i]) && !marked[i] && (darkest < 0 || value[i] < value[darkest])) darkest = i;
        if (darkest >= 0) marked[darkest] = true;
    }
}

static Truth truth_of(const RoomLight *source, PathTracer *const tracer[2], const RoomPlan *plan, int room,
                      const RoomValues *found, const BenchArguments *a, Arena *arena) {
    int first = plan->rooms[room].first_point, count = plan->rooms[room].grid.point_count;
    const Vec3 *points = plan->points + first;
    bool *wanted = ARENA_ARRAY(arena, bool, count + 1);
    Truth t = {ARENA_ARRAY(arena, double, count + 1), ARENA_ARRAY(arena, double, count + 1),
               ARENA_ARRAY(arena, double, count + 1)};
    for (int i = 0; i < count; i++) {
        wanted[i] = !isnan(found->all[first + i]);
        t.all[i] = t.own[i] = NAN;
    }
    ask(source, tracer[0], points, wanted, count, a->error, a->seed, t.all, t.error);
    ask(source, tracer[1], points, wanted, count, a->error, a->seed + 1000000, t.own, NULL);
    memset(wanted, 0, (size_t)count * sizeof *wanted);
    mark_darkest(t.all, count, wanted);
    mark_darkest(found->all + first, count, wanted);
    ask(source, tracer[0], points, wanted, count, a->error * DARKEST_ERROR, a->seed + 2000000, t.all,
        t.error);
    return t;
}

static void add_room(const char *file, const char *source, const Building *b, const PlannedLight *light,
                     const RoomValues *values, const Truth *truth, int index, Text *csv, Arena *arena) {
    const PlannedRoom *room = &light->plan.rooms[index];
    // Figures of the truth are made as those of the light found, of the same room by itself.
    PlannedRoom alone = *room;
    alone.first_point = 0;
    RoomPlan of_truth = {.rooms = &alone, .room_count = 1, .point_count = room->grid.point_count};
    RoomFigures found = room_figures(&light->plan, index, values),
                right = room_figures(&of_truth, 0, &(RoomValues){truth->all, truth->own});
    double squares = 0;
    for (int i = 0; i < room->grid.point_count; i++)
        if (!isnan(truth->all[i]))
            squares += truth->error[i] * truth->all[i] * truth->error[i] * truth->all[i];
    size_t before = csv->size;
    text_append(csv, "%s,%s,%s,%d,%.5g,%.5g,%.3f,%.5g,%.5g,%.3f,%.4f,%.4f,%.4f,%.4f,%.4f,%.3f,%.3f\n",
                bench_name(file), source, region_title(b, &b->regions[room->region], arena), found.points,
                found.mean, right.mean, 100 * (found.mean / right.mean - 1), found.minimum, right.minimum,
                100 * (found.minimum / right.minimum - 1), found.uniformity, right.uniformity,
                found.uniformity - right.uniformity, found.from_rooms, right.from_rooms,
                100 * sqrt(squares) / right.points / right.mean, light->work);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

static bool planner_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    static const char *const NAMES[PLANNED_SOURCES] = {"lamps", "sky"};
    Arena arena = {0};
    LoadedScene scene;
    PlannedLight light;
    PlannedOptions planned = planned_default_options();
    SceneOptions load = a->load;
    load.lamps = SCENE_LAMPS_ALL;
    bool good = app_load(file, &load, &arena, &scene, error) && scene_has_walls(&scene, error) &&
                planned_light(&scene, &planned, NULL, &arena, &light, error);
    if (!good) {
        arena_free(&arena);
        return false;
    }
    int rooms = light.plan.room_count, most = a->points > 0 && a->points < rooms ? a->points : rooms;
    for (int s = 0; s < PLANNED_SOURCES; s++) {
        if (!light.sources[s].there || !bench_listed(a->methods, NAMES[s])) continue;
        Arena scratch = {0};
        const RoomLight *source = &light.sources[s].light;
        PathTracer *tracer[2] = {path_tracer_new(source->mesh, &source->day, &scratch),
                                 path_tracer_new(&source->closed_mesh, &source->day, &scratch)};
        for (int i = 0; i < most; i++) {
            int room = (int)((long long)i * rooms / most);
            Truth truth = truth_of(source, tracer, &light.plan, room, &light.sources[s].values, a, &scratch);
            add_room(file, NAMES[s], &scene.building, &light, &light.sources[s].values, &truth, room, csv,
                     &scratch);
        }
        for (int k = 0; k < 2; k++) path_tracer_end(tracer[k]);
        arena_free(&scratch);
    }
    planned_light_end(&light);
    arena_free(&arena);
    return true;
}

static bool measure_planner(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.error == 0) own.error = 0.01;
    return bench_table(&own, HEAD, NULL, planner_of_file, error);
}

static bool is_source(const char *name) { return strcmp(name, "lamps") == 0 || strcmp(name, "sky") == 0; }

static void print_sources(void) { puts("    sources:            lamps, sky"); }

static const Option PLANNER_ROWS[] = {
    BENCH_METHODS("some of the sources below (default: all)"),
    {.name = "points",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(points),
     .low = 1,
     .high = 1000000,
     .help = "how many rooms are compared, @ (default: all)"},
    BENCH_ERROR(
        "standard error of the truth at a point, relative, @ (default 0.01); a quarter of it at the darkest"),
    BENCH_SEED("of paths"),
    BENCH_CSV,
};

const Bench BENCH_PLANNER = {
    .name = "planner",
    .about = "how right the light of rooms is that `enfilade light` tells, against path tracing at the same "
             "points, with "
             "all rooms open and with all closed; lux of lamps, shares of the light outdoors of the sky; "
             "rooms_work_seconds: CPU beyond the bake, of all rooms and sources",
    BENCH_OPTIONS(PLANNER_ROWS),
    .run = measure_planner,
    .is_method = is_source,
    .print_methods = print_sources,
    .files = BENCH_LIT_FILES,
};
