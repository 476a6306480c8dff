// cmd_light.c - `enfilade light FILE`: the light of each room as planners ask for it, as a table and as a plan with isolux lines.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/app.h"
#include "engine/app/light_plan.h"
#include "engine/core/file.h"

typedef struct Arguments {
    SceneOptions load;
    PlannedOptions planned;
    const char *file, *svg;
    double outside;  // lux
    int storey, width;
    bool json;
} Arguments;

#define AT(field) offsetof(Arguments, field)
static const Option ROWS[] = {
    OPTION_MAP(AT(load.map)),
    OPTION_PHOTOMETRY(AT(load.photometry)),
    {.name = "plane",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(planned.plane),
     .high = 100,
     .help = "height of the working plane above each room's floor, metres, @ (default 0.85)"},
    OPTION_LAMPS(AT(load.lamp_state), ""),
    OPTION_FILL_LAMPS(AT(load.fill_lamps)),
    {.name = "sky",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(planned.sky),
     .names = PLANNED_SKY_NAMES,
     .name_count = PLANNED_SKIES,
     .help = "the sky of the daylight factor, all lamps off: @ (default overcast, CIE type 1)"},
    {.name = "outside",
     .value = "LX",
     .type = OPTION_NUMBER,
     .at = AT(outside),
     .low = 1,
     .high = 200000,
     .help =
         "median illuminance by the sky on level ground at the site, lux, @ (default 14000, as in London or "
         "Berlin): daylight factors times this are held against the targets of EN 17037"},
    {.name = "doors",
     .value = "SPEC",
     .type = OPTION_TEXT,
     .at = AT(planned.bake.doors),
     .help = "where doors stand, as `bake` has it (default drawn)"},
    {.name = "svg",
     .value = "OUT.svg",
     .type = OPTION_OUTPUT,
     .names = (const char *const[]){"svg"},
     .name_count = 1,
     .at = AT(svg),
     .help = "writes a plan with isolux lines, or, where no lamp is on, lines of equal daylight factor"},
    {.name = "storey",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(storey),
     .high = 1000,
     .help = "which storey the plan shows, @ (default 0)"},
    {.name = "width",
     .value = "PIXELS",
     .type = OPTION_INT,
     .at = AT(width),
     .low = 100,
     .high = 10000,
     .help = "of the plan, @ (default 1200)"},
    OPTION_THREADS(AT(planned.bake.rad.threads)),
    OPTION_MEMORY(AT(load.memory), "what fits the file to open it, then three quarters of the machine's"),
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS = OPTION_TABLE(
    "light", "FILE [OPTIONS]",
    "Tells the light of every room on a horizontal plane, at the points of the grid of EN 12464-1: its mean, "
    "least "
    "and greatest illuminance by lamps in lux, the uniformity (least over mean), and the share of the mean "
    "that "
    "came through doors, windows and other openings from other rooms. Under a sky without lamps it tells the "
    "daylight factor, in percent of the light on open level ground, the illuminances that half and 95 % of "
    "the "
    "room reach, and the level of EN 17037 that they meet. The table is CSV. Light is baked as `bake` does "
    "by "
    "itself, on smaller elements, and not stored. Points inside furniture do not count.",
    ROWS);

// ---- the table

// All that is told of one room.
typedef struct RoomRow {
    const char *storey, *room;
    double area;
    const PlannedRoom *planned;
    RoomFigures figures[PLANNED_SOURCES];
    bool known[PLANNED_SOURCES];
    double half, most;  // daylight, lux
    int level;
} RoomRow;

static double area_of(const Building *b, const Region *region) {
    double twice = 0;
    for (int r = region->first_ring; r < region->first_ring + region->ring_count; r++) {
        const Vec2 *p = b->points + b->rings[r].first_point;
        for (int i = 0, n = b->rings[r].point_count; i < n; i++) twice += vec2_cross(p[i], p[(i + 1) % n]);
    }
    return twice / 2;
}

static RoomRow row_of(const Arguments *a, const LoadedScene *scene, const PlannedLight *light, int index,
                      Arena *arena) {
    const Building *b = &scene->building;
    const PlannedRoom *room = &light->plan.rooms[index];
    const Region *region = &b->regions[room->region];
    RoomRow row = {.storey = region->storey >= 0 && b->storeys[region->storey].name
                                 ? b->storeys[region->storey].name
                                 : "",
                   .room = region_title(b, region, arena),
                   .area = area_of(b, region),
                   .planned = room};
    for (int s = 0; s < PLANNED_SOURCES; s++) {
        row.known[s] = light->sources[s].there;
        if (row.known[s]) row.figures[s] = room_figures(&light->plan, index, &light->sources[s].values);
    }
    if (row.known[PLANNED_DAY]) {
        row.half = a->outside * row.figures[PLANNED_DAY].half;
        row.most = a->outside * row.figures[PLANNED_DAY].most;
        row.level = daylight_level(row.half, row.most);
    }
    return row;
}

// A field of CSV (RFC 4180).
static void print_text(const char *text) {
    if (!text[strcspn(text, ",\"\r\n")]) {
        fputs(text, stdout);
        return;
    }
    putchar('"');
    for (const char *c = text; *c; c++) {
        if (*c == '"') putchar('"');
        putchar(*c);
    }
    putchar('"');
}

// Empty where there is no such number.
static void print_number(bool known, const char *format, double value) {
    putchar(',');
    if (known && isfinite(value)) printf(format, value);
}

static void print_row(const RoomRow *row) {
    const RoomFigures *lamps = &row->figures[PLANNED_LAMPS], *day = &row->figures[PLANNED_DAY];
    bool lit = row->known[PLANNED_LAMPS], sky = row->known[PLANNED_DAY];
    const RoomFigures *any = lit ? lamps : day;
    print_text(row->storey);
    putchar(',');
    print_text(row->room);
    printf(",%.2f,%.3f,%d,%d", row->area, row->planned->plane, any->points, any->inside);
    print_number(lit, "%.2f", lamps->mean);
    print_number(lit, "%.2f", lamps->minimum);
    print_number(lit, "%.2f", lamps->maximum);
    print_number(lit, "%.4f", lamps->uniformity);
    print_number(lit, "%.4f", lamps->from_rooms);
    print_number(sky, "%.4f", 100 * day->mean);
    print_number(sky, "%.4f", 100 * day->minimum);
    print_number(sky, "%.2f", row->half);
    print_number(sky, "%.2f", row->most);
    printf(",%s", sky && day->points > 0 ? DAYLIGHT_LEVEL_NAMES[row->level] : "");
    print_number(sky, "%.4f", day->from_rooms);
    putchar('\n');
}

static void print_table(const RoomRow *rows, int count) {
    puts("storey,room,area_m2,plane_m,points,points_inside_things,mean_lx,minimum_lx,maximum_lx,uniformity,"
         "from_rooms_share,daylight_factor_percent,daylight_factor_minimum_percent,daylight_half_lx,"
         "daylight_most_lx,daylight_level,daylight_from_rooms_share");
    for (int i = 0; i < count; i++) print_row(&rows[i]);
}

// null where there is no such number.
static void set_number(json_t *object, const char *name, double value) {
    json_object_set_new(object, name, isfinite(value) ? json_real(value) : json_null());
}

static json_t *json_of(const RoomRow *row) {
    const RoomFigures *lamps = &row->figures[PLANNED_LAMPS], *day = &row->figures[PLANNED_DAY];
    const RoomFigures *any = row->known[PLANNED_LAMPS] ? lamps : day;
    json_t *o = json_object();
    json_object_set_new(o, "storey", json_string(row->storey));
    json_object_set_new(o, "room", json_string(row->room));
    set_number(o, "area_m2", row->area);
    set_number(o, "plane_m", row->planned->plane);
    json_object_set_new(o, "points", json_integer(any->points));
    json_object_set_new(o, "points_inside_things", json_integer(any->inside));
    if (row->known[PLANNED_LAMPS]) {
        set_number(o, "mean_lx", lamps->mean);
        set_number(o, "minimum_lx", lamps->minimum);
        set_number(o, "maximum_lx", lamps->maximum);
        set_number(o, "uniformity", lamps->uniformity);
        set_number(o, "from_rooms_share", lamps->from_rooms);
    }
    if (row->known[PLANNED_DAY]) {
        set_number(o, "daylight_factor_percent", 100 * day->mean);
        set_number(o, "daylight_factor_minimum_percent", 100 * day->minimum);
        set_number(o, "daylight_half_lx", row->half);
        set_number(o, "daylight_most_lx", row->most);
        json_object_set_new(o, "daylight_level",
                            day->points > 0 ? json_string(DAYLIGHT_LEVEL_NAMES[row->level]) : json_null());
        set_number(o, "daylight_from_rooms_share", day->from_rooms);
    }
    return o;
}

static void print_json(const Arguments *a, const PlannedLight *light, const RoomRow *rows, int count) {
    json_t *list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, json_of(&rows[i]));
    json_t *facts =
        json_pack("{s:o s:i s:i s:f s:s s:f s:f s:f s:f s:f}", "rooms", list, "points",
                  light->plan.point_count, "low_rooms", light->plan.low_count, "outside_lx", a->outside,
                  "sky", light->sources[PLANNED_DAY].there ? PLANNED_SKY_NAMES[a->planned.sky] : "none",
                  "seconds_bake", light->bake_seconds, "seconds_rooms", light->seconds, "work_bake",
                  light->bake_work, "work_rooms", light->work, "plane_m", a->planned.plane);
    CORE_ASSERT(facts);
    app_print_json(facts);
}

static void print_warnings(const PlannedLight *light) {
    if (light->plan.low_count > 0)
        fprintf(stderr, "enfilade: %d rooms are lower than the working plane and left out\n",
                light->plan.low_count);
}

static bool light(const Arguments *a, Arena *arena, Error *error) {
    LoadedScene scene;
    PlannedLight found;
    SceneOptions load = a->load;
    if (!app_check_files(&a->svg, 1, &a->file, 1, &load, error) ||
        !app_load(a->file, &load, arena, &scene, error) ||
        (a->svg && !light_plan_check(&scene, a->storey, error)))
        return false;
    Progress progress = app_progress_stoppable(0);
    bool good = planned_light(&scene, &a->planned, &progress, arena, &found, error);
    app_progress_end();
    const char *svg = NULL;
    if (good && a->svg)
        good = light_plan(&scene, &found, a->storey, a->width, arena, &svg, error) &&
               file_write(a->svg, svg, strlen(svg), error);
    if (good) {
        RoomRow *rows = ARENA_ARRAY(arena, RoomRow, found.plan.room_count + 1);
        for (int i = 0; i < found.plan.room_count; i++) rows[i] = row_of(a, &scene, &found, i, arena);
        if (a->json)
            print_json(a, &found, rows, found.plan.room_count);
        else
            print_table(rows, found.plan.room_count);
        print_warnings(&found);
    }
    planned_light_end(&found);
    return good;
}

int cmd_light(int argc, char **argv) {
    Arguments a = {
        .load = app_scene_options(), .planned = planned_default_options(), .outside = 14000, .width = 1200};
    a.load.lamps = SCENE_LAMPS_ALL;
    a.load.fill_lamps = FILL_LAMPS_OFF;
    a.load.work = "baking";
    bool help = false;
    int code = options_parse_file(&OPTIONS, argc, argv, &a, NULL, &a.file, &help);
    if (help) options_print_help(&OPTIONS);
    if (code != APP_GOOD || help) return code;
    a.load.vis.threads = a.planned.bake.rad.threads;
    Arena arena = {0};
    Error error;
    bool good = light(&a, &arena, &error), stopped = !good && app_interrupted();
    arena_free(&arena);
    if (good) return APP_GOOD;
    return app_fail(stopped ? APP_STOPPED : APP_BAD_INPUT, "%s", error.text);
}
