// bench_collision.c - a body that walks at random through each building while its doors move: the time of a step, the
// number of walls that a step looks at against all walls (Oki 3.2), and whether the body is ever where it may not be.
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/sim/collision_walk.h"

static long count_walls(const CellGraph *graph) {
    long walls = 0;
    for (int i = graph->surface_first[0]; i < graph->surface_first[graph->cell_count]; i++)
        walls += graph->objects[i].polygon_count;
    return walls;
}

static bool bench_building(const char *file, const BenchArguments *a, Arena *arena, Error *error) {
    SceneOptions load = a->load;
    LoadedScene scene;
    if (!app_load(file, &load, arena, &scene, error) || !scene_has_walls(&scene, error)) return false;
    CollisionWalkOptions options = {.steps = a->steps, .seed = a->seed, .flood_every = 1};
    CollisionReport r;
    if (!collision_walk(&scene.graph, &options, &r, error)) return false;
    double n = (double)r.steps;
    printf("%s,%ld,%.1f,%ld,%.1f,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%.2f\n", bench_name(file), r.steps,
           (double)r.wall_tests / n, count_walls(&scene.graph), (double)r.object_tests / n,
           collision_violations(&r), r.relocations, r.stuck, r.shut_in, r.flood_places, r.flood_ways,
           r.flood_lost, 1e6 * r.seconds / n);
    fflush(stdout);
    if (r.first_fault[0]) fprintf(stderr, "%s: %s\n", file, r.first_fault);
    if (r.first_lost[0]) fprintf(stderr, "%s: %s\n", file, r.first_lost);
    return true;
}

static bool measure_collision(const BenchArguments *a, Error *error) {
    bool good = true;
    puts("building,steps,wall_tests_per_step,walls_total,object_tests_per_step,violations,relocations,stuck,"
         "shut_in,"
         "flood_places,flood_ways,flood_lost,us_per_step");
    for (int i = 0; i < a->file_count && good; i++) {
        Arena building = {0};
        good = bench_building(a->files[i], a, &building, error);
        arena_free(&building);
    }
    return good;
}

static const Option ROWS[] = {
    {.name = "steps",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(steps),
     .low = 1,
     .high = 100000000,
     .help = "@ (default 100000)"},
    BENCH_SEED("of the walk"),
};

const Bench BENCH_COLLISION = {
    .name = "collision",
    .about =
        "a body walks at random while doors move: walls and pieces of furniture looked at a step, places "
        "where it may not be, ways of a flood of the floor that it cannot walk, time",
    BENCH_OPTIONS(ROWS),
    .run = measure_collision,
};
