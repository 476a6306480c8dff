// bench_scale.c - what each stage costs as a building grows, from reading to the query of a frame and to a bake: buildings of the same kind
// with more and more rooms (build/generate campus-N). Every building has a process of its own and one thread. The slopes of a kind, of the
// line that fits the logarithms best, go to standard error: 1 is cost that grows with rooms.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/bench/apart.h"
#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/random.h"
#include "engine/core/text.h"
#include "engine/draw/view.h"
#include "engine/lit/lit_part.h"
#include "engine/scene/bake_mesh.h"
#include "engine/scene/bake_parts.h"
#include "engine/scene/kept_parts.h"
#include "maps/maps.h"
#include "radiosity/show/direct.h"
#include "visibility/pairs/campus.h"

static const char HEAD[] = "rooms,stage,seconds,peak_mb,count,building\n";

typedef enum Stage {
    READING,
    CELLS,
    PAIRS,
    TREES,
    MEMORY,
    QUERY,
    DRAWN,
    PAIR,
    MESH,
    SHOOTING,
    SHOT,
    SHOWN,
    PARTS,
    SENT_OF_2,
    SENT_OF_4,
    STAGES
} Stage;
static const char *const STAGE_NAMES[STAGES] = {"reading", "cells", "pairs", "trees",     "memory",
                                                "query",   "drawn", "pair",  "mesh",      "shooting",
                                                "shot",    "shown", "parts", "sent-of-2", "sent-of-4"};

// The figures of one building. `peak_mb` is the memory that the process had at most during a stage, less what it began with.
typedef struct Scale {
    const char *file;
    const BenchArguments *arguments;
    int rooms;
    bool baked;
    struct {
        double seconds, peak_mb, count;
    } stage[STAGES];
    bool good;
    Error error;
} Scale;

// The process's memory, MB: `key` is VmRSS, or VmHWM, the most since the last call of forget_peak.
static double status_mb(const char *key) {
    char line[256];
    double kb = 0;
    FILE *file = fopen("/proc/self/status", "r");
    size_t length = strlen(key);
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, key, length) == 0) kb = strtod(line + length + 1, NULL);
    if (file) fclose(file);
    return kb / 1024;
}

static void forget_peak(void) {
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file) return;
    fputs("5", file);
    fclose(file);
}

static void begin_stage(double *start) {
    forget_peak();
    *start = clock_work_seconds();
}

static void end_stage(Scale *s, Stage stage, double start, double base, double count) {
    s->stage[stage].seconds = clock_work_seconds() - start;
    s->stage[stage].peak_mb = status_mb("VmHWM") - base;
    s->stage[stage].count = count;
}

// ---- frames: an eye somewhere in a room turns once around. Rooms lie in the middle of the building, half of it each way, so that
// small buildings have no more rooms at the border than large ones. So many eyes that the mean is known to 2 %: what one sees differs
// by as much as the mean from the next.

enum { EYES = 2000, TURNS = 30, PASSES = 5 };

static bool in_the_middle(const CellGraph *graph, Vec3 p) {
    Vec3 size = vec3_sub(graph->box.max, graph->box.min), at = vec3_sub(p, graph->box.min);
    return fabs(at.x - size.x / 2) <= size.x / 4 && fabs(at.y - size.y / 2) <= size.y / 4;
}

// Cells of rooms of usual size, the same for every pass.
static int choose_eyes(const CellGraph *graph, uint64_t seed, int *cells, Vec3 *eyes) {
    static const double ABOVE = 1.6, LEAST = 2;  // metres: of the eye from the floor; of a cell's sides
    Random random = {seed};
    int count = 0;
    for (int tries = 0; tries < 1000 * EYES && count < EYES; tries++) {
        int c = random_index(&random, graph->cell_count);
        const Cell *cell = &graph->cells[c];
        Vec3 size = vec3_sub(cell->box.max, cell->box.min);
        double u = random_unit(&random), v = random_unit(&random);
        Vec3 eye = vec3(cell->box.min.x + (0.25 + u / 2) * size.x, cell->box.min.y + (0.25 + v / 2) * size.y,
                        cell->z0 + ABOVE);
        if (cell->region < 0 || graph->building->regions[cell->region].kind != REGION_ROOM ||
            fmin(size.x, size.y) < LEAST || !in_the_middle(graph, eye) || vis_locate(graph, eye, c) != c)
            continue;
        cells[count] = c;
        eyes[count++] = eye;
    }
    return count;
}

static void ask(Scale *s, const CellGraph *graph, const StabForest *forest, Arena *arena) {
    VisQuery *query = vis_query_new(graph, forest, arena);
    int *cells = ARENA_ARRAY(arena, int, EYES);
    Vec3 *eyes = ARENA_ARRAY(arena, Vec3, EYES);
    int count = choose_eyes(graph, s->arguments->seed, cells, eyes), frames = count * TURNS;
    double all = 0, seen = 0, polygons = 0;
    for (int i = 0; i < count; i++) {
        // The best of several turns: what other programs take of the caches is not the query's.
        double best = INFINITY;
        for (int pass = 0; pass < PASSES; pass++) {
            double start = clock_thread_seconds();
            for (int k = 0; k < TURNS; k++) {
                Camera camera = camera_look(eyes[i], 2 * M_PI * k / TURNS, 0, 1.2, 1280, 720);
                Eye eye = walk_eye(&camera);
                VisResult result = vis_query(query, &eye, cells[i], NULL, CULL_STAB);
                if (pass > 0) continue;
                seen += result.cell_count;
                polygons += result.polygon_count;
            }
            best = fmin(best, clock_thread_seconds() - start);
        }
        all += best;
    }
    if (frames == 0) return;
    s->stage[QUERY].seconds = all / frames;
    s->stage[QUERY].count = seen / frames;
    s->stage[DRAWN].count = polygons / frames;
}

// ---- the stages

static int rooms_in(const Building *b) {
    int count = 0;
    for (int i = 0; i < b->region_count; i++) count += b->regions[i].kind == REGION_ROOM;
    return count;
}

static bool run_stages(Scale *s) {
    Arena arena = {0}, scratch = {0};
    Building building;
    CellGraph graph;
    StabForest forest;
    CampusPairs pairs;
    VisOptions options = vis_default_options();
    options.threads = 1;
    double base = status_mb("VmRSS"), start;
    begin_stage(&start);
    if (!maps_read_map(s->file, s->arguments->load.map, &arena, &building, &s->error)) return false;
    s->rooms = rooms_in(&building);
    end_stage(s, READING, start, base, building.polygon_count);
    begin_stage(&start);
    if (!vis_build_cells(&building, &options, &arena, &graph, &s->error)) return false;
    end_stage(s, CELLS, start, base, graph.cell_count);
    begin_stage(&start);
    bool known = campus_pairs(&graph, &(PairOptions){.threads = 1}, NULL, &scratch, &pairs);
    end_stage(s, PAIRS, start, base, known ? (double)cell_rows_count(&pairs.seen) : 0);
    // One pair of cells that see each other, and how many there are for each room.
    if (known) {
        options.known = &pairs.seen;
        s->stage[PAIR].seconds = s->stage[PAIRS].seconds / s->stage[PAIRS].count;
        s->stage[PAIR].count = s->stage[PAIRS].count / s->rooms;
    }
    begin_stage(&start);
    vis_build_forest(&graph, &options, NULL, &arena, &forest);
    end_stage(s, TREES, start, base, forest.node_count);
    arena_free(&scratch);
    begin_stage(&start);
    ask(s, &graph, &forest, &arena);
    for (int i = READING; i < MEMORY; i++)
        s->stage[MEMORY].peak_mb = fmax(s->stage[MEMORY].peak_mb, s->stage[i].peak_mb);
    s->stage[QUERY].peak_mb = status_mb("VmHWM") - base;
    // Bytes that a walk keeps.
    s->stage[MEMORY].count = (double)arena.used;
    arena_free(&arena);
    return true;
}

// The building once more, with its lamps, by night; for one thread.
static bool open_scene(Scale *s, Arena *arena, LoadedScene *scene, BakeOptions *options) {
    SceneOptions load = s->arguments->load;
    *options = bake_default_options();
    load.lamps = SCENE_LAMPS_ALL;
    load.day.night = true;
    load.vis.threads = options->rad.threads = options->mesh.threads = 1;
    return scene_load(s->file, &load, arena, scene, &s->error);
}

// A bake to the usual residual, as `enfilade bake` makes it: the mesh that follows the light; shots and what is gathered along their rows;
// light at the nodes.
static bool run_bake(Scale *s, double base) {
    Arena arena = {0};
    LoadedScene scene;
    BakeOptions options;
    RadSolution light;
    RadReport report = {0};
    Mesh mesh;
    float *doors;
    double start;
    if (!open_scene(s, &arena, &scene, &options)) return false;
    begin_stage(&start);
    if (!bake_mesh(&options, &scene, NULL, NULL, &arena, &doors, &mesh, &s->error)) return false;
    end_stage(s, MESH, start, base, mesh.element_count);
    rad_fit(&mesh, &options.rad);
    begin_stage(&start);
    if (!rad_start(&mesh, &arena, &light, &s->error)) return false;
    report = rad_shoot(&mesh, &scene.forest, doors, &options.rad, NULL, &light);
    end_stage(s, SHOOTING, start, base, (double)report.shots);
    s->stage[SHOT].seconds = s->stage[SHOOTING].seconds / (double)report.shots;
    s->stage[SHOT].count = report.elements_drawn_mean;
    begin_stage(&start);
    direct_show(&mesh, &scene.forest, doors, 1, NULL, &arena, &light, &report);
    end_stage(s, SHOWN, start, base, light.node_count);
    arena_free(&arena);
    return true;
}

// The same as `enfilade bake --apart` makes it, part by part, the others in files of a folder that goes afterwards. Counted are elements of
// all parts, those that several have; and the bytes that the first of two and of four processes would send to others.
static bool run_parts(Scale *s, double base) {
    enum { CELLS_A_PART = 256 };
    Arena arena = {0};
    LoadedScene scene;
    BakeOptions options;
    PartsReport report = {0};
    char folder[] = "/tmp/enfilade-scale-XXXXXX";
    double start;
    if (!open_scene(s, &arena, &scene, &options)) return false;
    if (!mkdtemp(folder)) return error_set(&s->error, "%s: cannot be made", folder);
    const char *light = arena_format(&arena, "%s/light.rad", folder), *kept = kept_folder(light, &arena);
    PartsKeep keep = {.folder = kept, .seconds = INFINITY, .apart = light, .drawn = lit_store_part};
    begin_stage(&start);
    bool good =
        bake_parts(&options, &scene, CELLS_A_PART, &keep, NULL, &arena, NULL, NULL, NULL, &report, &s->error);
    end_stage(s, PARTS, start, base, report.elements_share * report.elements);
    s->stage[SENT_OF_2].count = 1e6 * report.sent_mb_of_2;
    s->stage[SENT_OF_4].count = 1e6 * report.sent_mb_of_4;
    kept_remove(kept, kept_last(kept) + 1, 0);
    remove(light);
    rmdir(folder);
    arena_free(&arena);
    return good;
}

static void run_apart(void *context) {
    Scale *s = context;
    double base = status_mb("VmRSS");
    s->good = run_stages(s);
    s->baked = s->good && s->rooms <= s->arguments->baked_rooms;
    if (s->baked) s->good = run_bake(s, base) && run_parts(s, base);
}

static bool measure_file(const char *file, const BenchArguments *a, Scale *out, Error *error) {
    Scale *s = apart_memory(sizeof *s);
    s->file = file;
    s->arguments = a;
    bool good = apart_run(run_apart, s, bench_name(file), error) &&
                (s->good || error_set(error, "%.1000s", s->error.text));
    *out = *s;
    apart_memory_free(s, sizeof *s);
    return good;
}

static void add_rows(const Scale *s, Text *csv) {
    size_t before = csv->size;
    for (int i = 0; i < (s->baked ? STAGES : MESH); i++)
        text_append(csv, "%d,%s,%.9g,%.2f,%.6g,%s\n", s->rooms, STAGE_NAMES[i], s->stage[i].seconds,
                    s->stage[i].peak_mb, s->stage[i].count, bench_name(s->file));
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

// ---- slopes

// As campus-10.plan and campus-100.plan are.
static bool same_kind(const char *a, const char *b) {
    size_t length = strcspn(bench_name(a), "-");
    return strcspn(bench_name(b), "-") == length && strncmp(bench_name(a), bench_name(b), length) == 0;
}

static bool is_sent(Stage stage) { return stage == SENT_OF_2 || stage == SENT_OF_4; }

// The slope of the line through (log rooms, log figure) by least squares; NAN where there are not two.
static double slope(const Scale *all, int count, const char *kind, Stage stage, bool memory) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < count; i++) {
        double figure = memory           ? all[i].stage[stage].peak_mb
                        : is_sent(stage) ? all[i].stage[stage].count
                                         : all[i].stage[stage].seconds;
        if (!same_kind(all[i].file, kind) || figure <= 0 || all[i].rooms <= 0) continue;
        double u = log(all[i].rooms), v = log(figure);
        n++, x += u, y += v, xx += u * u, xy += u * v;
    }
    double spread = n * xx - x * x;
    return n < 2 || spread <= 1e-9 ? NAN : (n * xy - x * y) / spread;
}

static void tell_slopes(const Scale *all, int count) {
    for (int i = 0; i < count; i++) {
        bool told = false;
        for (int k = 0; k < i; k++) told = told || same_kind(all[k].file, all[i].file);
        if (told || isnan(slope(all, count, all[i].file, READING, false))) continue;
        const char *name = bench_name(all[i].file);
        for (Stage stage = READING; stage < STAGES; stage++) {
            if (stage == DRAWN || stage == PAIR ||
                isnan(slope(all, count, all[i].file, stage, stage == MEMORY)))
                continue;
            double time = slope(all, count, all[i].file, stage, false),
                   memory = slope(all, count, all[i].file, stage, true);
            fprintf(stderr, "%.*s: %s grows with rooms to the power of", (int)strcspn(name, "-"), name,
                    STAGE_NAMES[stage]);
            if (is_sent(stage))
                fprintf(stderr, " %.2f in bytes", time);
            else if (stage != MEMORY)
                fprintf(stderr, " %.2f in time", time);
            if (!isnan(memory)) fprintf(stderr, "%s %.2f in memory", stage != MEMORY ? "," : "", memory);
            fputc('\n', stderr);
        }
    }
}

static bool measure_scale(const BenchArguments *a, Error *error) {
    Arena arena = {0};
    Text csv = {.arena = &arena};
    Scale *all = ARENA_ARRAY(&arena, Scale, a->file_count);
    text_append(&csv, "%s", HEAD);
    fputs(HEAD, stdout);
    bool good = true;
    for (int i = 0; i < a->file_count && good; i++) {
        good = measure_file(a->files[i], a, &all[i], error);
        if (good) add_rows(&all[i], &csv);
    }
    if (good) tell_slopes(all, a->file_count);
    if (good && a->csv) good = file_write(a->csv, csv.data, csv.size, error);
    arena_free(&arena);
    return good;
}

static const Option ROWS[] = {
    BENCH_SEED("of the places from which frames are asked for"),
    {.name = "baked-rooms",
     .value = "N",
     .type = OPTION_INT,
     .at = offsetof(BenchArguments, baked_rooms),
     .high = 1000000,
     .help = "buildings of up to so many rooms are baked, too, @ (default 2000; 0: none)"},
    BENCH_CSV,
};

const Bench BENCH_SCALE = {
    .name = "scale",
    .about = "what each stage costs as buildings of one kind grow: reading, cells, pairs of cells that see "
             "each other, stab trees, all memory, the query of a frame, polygons drawn, one pair, a bake: "
             "its mesh, shooting, one shot, light as it is shown; the same bake part by part, and the bytes "
             "that the first of two and of four processes would send to "
             "the others (sent-of-2, sent-of-4); seconds of one thread, MB at most above those of the "
             "empty program; the slopes go to standard error",
    BENCH_OPTIONS(ROWS),
    .run = measure_scale,
    .files = "build/maps/campus-10.plan build/maps/campus-100.plan build/maps/campus-1000.plan "
             "build/maps/campus-10000.plan",
};
