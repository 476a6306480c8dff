// planned_light.c - lamps and sky, one after the other.
#include "engine/app/planned_light.h"

#include "engine/core/clock.h"

const char *const PLANNED_SKY_NAMES[PLANNED_SKIES] = {"overcast", "uniform", "none"};

// Edge of the smallest elements, metres. An uplight's bright spot on the wall is partly hidden from the room by the lamp itself, which
// larger elements do not tell.
static const double PLANNED_SMALLEST = 0.015;
// Elements are smaller than those of a walk by this, which halves the errors of rooms behind windows.
static const double PLANNED_FINER = 0.8;
// Light that is left unshot is missing most in rooms without windows: of a hall between lit rooms, a thousandth is up to 1.5 %.
static const double PLANNED_RESIDUAL = 5e-4;

PlannedOptions planned_default_options(void) {
    PlannedOptions o = {.bake = bake_default_options(), .plane = 0.85};
    o.bake.rad.form_factor.shifts = true;
    o.bake.adapt.smallest = PLANNED_SMALLEST;
    o.bake.rad.residual = PLANNED_RESIDUAL;
    return o;
}

// The height of the sun does not matter under an overcast sky: only ratios to the light outdoors are asked for.
static Daylight day_of(int sky) {
    static const double EVEN[3] = {1, 1, 1};
    static const SunPosition SUN = {.altitude = 1, .distance = 1};
    return sky == PLANNED_UNIFORM ? daylight_uniform(EVEN) : daylight_of(&SUN, 0, DAYLIGHT_OVERCAST);
}

static bool sees_sky(const CellGraph *graph) {
    for (int c = 0; c < graph->cell_count; c++)
        if (vis_region(graph, c)->kind == REGION_OUTDOORS) return true;
    return false;
}

static bool emits(const Mesh *mesh) {
    for (int f = 0; f < mesh->face_count; f++)
        if (mesh_emits(mesh, f)) return true;
    return false;
}

static bool make_plan(const LoadedScene *scene, const PlannedOptions *options, Arena *arena, RoomPlan *out,
                      Error *error) {
    const Building *b = &scene->building;
    if (b->form != FORM_REGIONS)
        return error_set(error,
                         "%s: is polygons or cells alone, in which no rooms are told apart (allowed: plans, "
                         "homes and maps)",
                         b->source);
    *out = room_plan(&scene->graph, options->plane, arena);
    if (out->room_count > 0) return true;
    if (out->low_count == 0) return error_set(error, "%s: has no rooms", b->source);
    return error_set(error, "%s: no room is higher than the working plane, %g m (--plane M lowers it)",
                     b->source, options->plane);
}

static bool find_source(const LoadedScene *scene, const PlannedOptions *options, const Daylight *day,
                        const Progress *progress, Arena *arena, PlannedLight *out, PlannedSource *source,
                        Error *error) {
    double start = clock_seconds(), work = clock_work_seconds();
    BakeOptions bake = options->bake;
    Mesh *mesh = &source->mesh;
    RoomLight *light = &source->light;
    bake.day = *day;
    if (bake.mesh.element == 0) bake.mesh.element = PLANNED_FINER * mesh_fitting_element(&scene->graph);
    if (!bake_mesh(&bake, scene, NULL, progress, arena, &out->doors, mesh, error)) return false;
    *light = (RoomLight){
        .mesh = mesh, .forest = &scene->forest, .door_open = out->doors, .day = *day, .options = bake.rad};
    rad_fit(mesh, &light->options);
    if (daylight_shines(day)) {
        *mesh = lamps_mesh(&scene->lamps, mesh, ARENA_ARRAY(arena, Rgb, scene->lamps.count + 1), arena);
        room_daylight_factor(day, light->weight);
    } else {
        *mesh = scene_lit_mesh(scene, mesh, arena);
        room_lux(light->weight);
    }
    source->there = daylight_shines(day) || emits(mesh);
    if (!source->there) return true;
    if (!room_light_open(light, progress, arena, error)) return false;
    double baked = clock_seconds(), baked_work = clock_work_seconds();
    if (!room_light_close(light, progress, arena, error)) return false;
    source->values = room_values(&out->plan, light, bake.rad.threads, arena);
    out->bake_seconds += baked - start;
    out->bake_work += baked_work - work;
    out->seconds += clock_seconds() - baked;
    out->work += clock_work_seconds() - baked_work;
    return true;
}

bool planned_light(const LoadedScene *scene, const PlannedOptions *options, const Progress *progress,
                   Arena *arena, PlannedLight *out, Error *error) {
    static const Daylight NIGHT;
    bool sky = options->sky != PLANNED_NO_SKY && sees_sky(&scene->graph);
    *out = (PlannedLight){.doors = NULL};
    if (!make_plan(scene, options, arena, &out->plan, error)) return false;
    if (!sky && !scene_emits(scene))
        return error_set(
            error, "%s: nothing emits light: it has no lamps, and %s (--fill-lamps on lights its rooms)",
            scene->building.source,
            options->sky == PLANNED_NO_SKY ? "no sky is asked for" : "no opening to the sky");
    if (scene_emits(scene) &&
        !find_source(scene, options, &NIGHT, progress, arena, out, &out->sources[PLANNED_LAMPS], error))
        return false;
    Daylight day = sky ? day_of(options->sky) : NIGHT;
    if (sky && !find_source(scene, options, &day, progress, arena, out, &out->sources[PLANNED_DAY], error))
        return false;
    if (out->sources[PLANNED_LAMPS].there || sky) return true;
    return error_set(error, "%s: all lamps are off, and there is no sky", scene->building.source);
}

void planned_light_end(PlannedLight *light) {
    for (int s = 0; s < PLANNED_SOURCES; s++) room_light_end(&light->sources[s].light);
}
