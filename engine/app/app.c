// app.c - loading with a cache, progress on a terminal, JSON and messages for the subcommands.
#include "engine/app/app.h"

#include <getopt.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "visibility/pairs/pairs.h"

AppOptions app_default_options(void) { return (AppOptions){.vis = vis_default_options(), .keep = true}; }

static bool report(void *context, const char *stage, double done) {
    enum { WIDTH = 40 };
    (void)context;
    static double last;
    double now = clock_seconds();
    if (now - last < 0.05 && done < 1) return true;
    last = now;
    int full = (int)(done * WIDTH);
    fprintf(stderr, "\r%-12s [%.*s%*s] %3d %%", stage, full, "########################################",
            WIDTH - full, "", (int)(done * 100));
    return true;
}

Progress app_progress(void) {
    return isatty(STDERR_FILENO) ? (Progress){report, NULL} : (Progress){NULL, NULL};
}

// What asks a stage to stop. The signal comes from outside: there is one flag a process, which any of its threads may set or read.
static atomic_bool interrupted;
static double deadline;  // on the clock; 0: none

static void interrupt(int signal) {
    (void)signal;
    atomic_store(&interrupted, true);
}

static bool report_stoppable(void *context, const char *stage, double done) {
    if (isatty(STDERR_FILENO)) report(context, stage, done);
    return !atomic_load(&interrupted) && (deadline == 0 || clock_seconds() < deadline);
}

Progress app_progress_stoppable(double seconds) {
    struct sigaction action = {.sa_handler = interrupt, .sa_flags = SA_RESETHAND | SA_RESTART};
    sigaction(SIGINT, &action, NULL);
    deadline = seconds > 0 ? clock_seconds() + seconds : 0;
    return (Progress){report_stoppable, NULL};
}

void app_progress_end(void) {
    if (isatty(STDERR_FILENO)) fprintf(stderr, "\r%70s\r", "");
}

// ---- files

char *app_cache_path(Arena *arena, const char *name) {
    char *folder;
    return file_cache_folder(arena, &folder, NULL) ? arena_format(arena, "%s/%s", folder, name) : NULL;
}

bool app_cache_check(const char *path, size_t size, Error *error) {
    Arena scratch = {0};
    char *folder;
    struct stat info;
    bool good = file_cache_folder(&scratch, &folder, error) && file_make_folder(folder, error);
    if (good && stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        good = error_set(error, "%s: is in the way: it is no regular file", path);
    good = good && file_check(path, size, error);
    arena_free(&scratch);
    return good;
}

bool app_cache_takes(const char *path, size_t size) {
    // Whatever is kept in a process, it has one cache.
    static bool said;
    Error reason;
    if (app_cache_check(path, size, &reason)) return true;
    if (!said)
        fprintf(stderr,
                "enfilade: %s: visibility and light are not kept (bake -o OUT.rad stores light elsewhere)\n",
                reason.text);
    said = true;
    return false;
}

// What the command writes, as app_check_files was told: what a building refers to is known only when it has been read.
static struct {
    const char *paths[APP_MOST_WRITTEN];
    int count;
} output;

bool app_spares(const char *const *written, int write_count, const char *const *read, int read_count,
                Error *error) {
    for (int i = 0; i < write_count; i++)
        for (int k = 0; k < read_count; k++)
            if (written[i] && read[k] && file_same(written[i], read[k]))
                return error_set(error, "%s: is read, and would be overwritten (allowed: another file)",
                                 written[i]);
    return true;
}

bool app_output_spares(const char *const *read, int read_count, Error *error) {
    return app_spares(output.paths, output.count, read, read_count, error);
}

bool app_check_files(const char *const *written, int write_count, const char *const *read, int read_count,
                     Error *error) {
    CORE_ASSERT(write_count <= APP_MOST_WRITTEN);
    memcpy(output.paths, written, (size_t)write_count * sizeof *written);
    output.count = write_count;
    if (!app_output_spares(read, read_count, error)) return false;
    for (int i = 0; i < write_count; i++) {
        if (!written[i]) continue;
        for (int k = 0; k < i; k++)
            if (written[k] && file_same(written[i], written[k]))
                return error_set(error, "%s: would be written twice (allowed: different files)", written[i]);
        if (!file_check(written[i], 0, error)) return false;
    }
    return true;
}

// ---- loading

// Ends what takes more memory than there is for it; app_load says so.
static bool report_within(void *context, const char *stage, double done) {
    return progress_report(context, stage, done) && memory_within(NULL);
}

// Which cells see each other by the finest method, then the trees within that. Stopped on the way, trees are roots alone
// and visible sets all that was not excluded.
static void make_trees(const AppOptions *options, Arena *arena, AppScene *scene) {
    Arena scratch = {0};
    Progress bar = options->stoppable ? app_progress_stoppable(0) : app_progress(),
             progress = {report_within, &bar};
    memory_set_stage("finding which cells see each other");
    PairOptions pairs = {.threads = options->vis.threads};
    PairSet set = {0};
    VisOptions vis = options->vis;
    if (scene->graph.cell_count <= VIS_MANY_CELLS) {
        pair_method_finest()->find(&scene->graph, &pairs, &progress, &scratch, &set);
        vis.known = set.seen;
    }
    memory_set_stage("making stab trees");
    scene->stopped = set.stopped || !vis_build_forest(&scene->graph, &vis, &progress, arena, &scene->forest);
    if (scene->stopped) {
        vis.max_nodes = 1;
        vis_build_forest(&scene->graph, &vis, NULL, arena, &scene->forest);
    }
    app_progress_end();
    scene->undecided = set.seen ? pair_count(set.seen, set.cell_count, set.words) -
                                      pair_count(set.proven, set.cell_count, set.words)
                                : cell_rows_count(&scene->forest.seen) - scene->graph.cell_count;
    arena_free(&scratch);
}

static void find_or_make_trees(const AppOptions *options, Arena *arena, AppScene *scene) {
    Error reason;
    // Of a soup, every polygon takes part in the making of cells.
    bool other = scene->lamp_faces > 0 && scene->building.form == FORM_SOUP;
    char *path =
        app_cache_path(arena, arena_format(arena, "%016llx%s.vis", (unsigned long long)scene->building.hash,
                                           other ? "-lamps" : ""));
    if (path && !options->fresh && access(path, R_OK) == 0) {
        scene->cached = scene->kept = vis_load(path, &scene->graph, arena, &scene->forest, &reason);
        if (scene->cached) return;
        fprintf(stderr, "enfilade: %s; it is made anew\n", reason.text);
    }
    bool keep = options->keep && app_cache_takes(path, 0);
    make_trees(options, arena, scene);
    if (!keep || scene->stopped) return;
    scene->kept = vis_save(path, &scene->graph, &scene->forest, &reason);
    if (!scene->kept) fprintf(stderr, "enfilade: %s; going on without a cache\n", reason.text);
}

bool app_load_cells(const char *path, const AppOptions *options, Arena *arena, AppScene *out, Error *error) {
    *out = (AppScene){0};
    double start = clock_seconds();
    app_open_budget(path);
    if (!maps_read_map(path, options->map, arena, &out->building, error) ||
        !app_output_spares(out->building.beside, out->building.beside_count, error))
        return false;
    if (options->lamps) out->lamp_faces = lamp_faces_add(arena, &out->building);
    double read = clock_seconds();
    memory_set_stage("making cells");
    if (!vis_build_cells(&out->building, &options->vis, arena, &out->graph, error) || !memory_within(error))
        return false;
    memory_lower_fence();
    out->read_seconds = read - start;
    out->cells_seconds = clock_seconds() - read;
    return true;
}

bool app_load(const char *path, const AppOptions *options, Arena *arena, AppScene *out, Error *error) {
    if (!app_load_cells(path, options, arena, out, error)) return false;
    double cells = clock_seconds();
    find_or_make_trees(options, arena, out);
    if (!memory_within(error)) return false;
    app_work_budget(path, options->work ? options->work : "working on it");
    out->trees_seconds = clock_seconds() - cells;
    return true;
}

bool app_has_walls(const AppScene *scene, Error *error) {
    if (scene->building.form != FORM_CELLS) return true;
    return error_set(
        error,
        "%s: holds cells and portals without walls: nothing to draw or to walk on (info, vis and "
        "bench take it)",
        scene->building.source);
}

bool app_emits(const AppScene *scene) {
    const Building *b = &scene->building;
    for (int i = 0; i < b->material_count; i++) {
        Rgb e = b->materials[i].emission;
        if (e.r + e.g + e.b > 0) return true;
    }
    return false;
}

// Doors are all that a person passes, doorways without a leaf among them.
static int count_joined(const Building *b) {
    int joined = 0;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind == OPENING_WINDOW || o->region[0] < 0 || o->region[1] < 0) continue;
        joined += b->regions[o->region[0]].kind == REGION_ROOM &&
                  b->regions[o->region[1]].kind == REGION_ROOM && o->region[0] != o->region[1];
    }
    return joined;
}

json_t *app_counts(const AppScene *scene) {
    const Building *b = &scene->building;
    int doors = 0, windows = 0, rooms = 0, leaks = 0, bounded = 0;
    for (int i = 0; i < b->opening_count; i++) {
        doors += b->openings[i].kind != OPENING_WINDOW;
        windows += b->openings[i].kind == OPENING_WINDOW;
    }
    for (int i = 0; i < b->region_count; i++) rooms += b->regions[i].kind == REGION_ROOM;
    for (int i = 0; i < b->note_count; i++) leaks += b->notes[i].kind == NOTE_LEAK;
    for (int c = 0; c < scene->graph.cell_count; c++) bounded += scene->forest.bounded[c];
    json_t *o = json_object();
    bool drawn = b->form == FORM_REGIONS;  // rooms and storeys are of drawn plans
    if (drawn) json_object_set_new(o, "storeys", json_integer(b->storey_count));
    if (drawn) json_object_set_new(o, "rooms", json_integer(rooms));
    json_object_set_new(o, "cells", json_integer(scene->graph.cell_count));
    json_object_set_new(o, "portals", json_integer(scene->graph.portal_count));
    if (b->form != FORM_CELLS) json_object_set_new(o, "doors", json_integer(doors));
    if (drawn) json_object_set_new(o, "doors_joined", json_integer(count_joined(b)));
    if (drawn) json_object_set_new(o, "windows", json_integer(windows));
    if (b->form != FORM_CELLS) {
        json_object_set_new(o, "objects", json_integer(scene->graph.object_count));
        json_object_set_new(o, "polygons", json_integer(scene->graph.polygon_count));
    }
    json_object_set_new(o, "stab_nodes", json_integer(scene->forest.node_count));
    json_object_set_new(o, "bounded_trees", json_integer(bounded));
    if (drawn) json_object_set_new(o, "leaks", json_integer(leaks));
    json_object_set_new(o, "notes", json_integer(b->note_count));
    if (drawn) json_object_set_new(o, "area_drawn", json_real(b->drawn_area));
    if (drawn) json_object_set_new(o, "area_lost", json_real(b->lost_area));
    return o;
}

void app_print_json(json_t *object) {
    json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(object);
}

static void print_sentence(const char *format, va_list args) {
    fputs("enfilade: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
}

int app_fail(int code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_sentence(format, args);
    va_end(args);
    return code;
}

int app_misuse(const char *command, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_sentence(format, args);
    va_end(args);
    fprintf(stderr, "Try `enfilade %s --help`.\n", command);
    return APP_BAD_USE;
}

int app_misuse_option(const char *command, int answer, char **argv) {
    const char *option = argv[optind - 1];
    if (answer == ':') return app_misuse(command, "%s: option `%s` needs a value", command, option);
    return app_misuse(command, "%s: there is no option `%s`", command, option);
}

bool app_parse_number(const char *text, double low, double high, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end != text && *end == 0 && *out >= low && *out <= high;
}

bool app_parse_int(const char *text, int low, int high, int *out) {
    char *end;
    long value = strtol(text, &end, 10);
    *out = (int)value;
    return end != text && *end == 0 && value >= low && value <= high;
}

bool app_parse_sky(const char *text, double radiance[3]) {
    char number[64];
    int count = 0;
    for (const char *at = text;; at++) {
        int length = (int)strcspn(at, ",");
        snprintf(number, sizeof number, "%.*s", length, at);
        if (count == 3 || !app_parse_number(number, 0, 1e6, &radiance[count++])) return false;
        at += length;
        if (*at == 0) break;
    }
    if (count == 1) radiance[1] = radiance[2] = radiance[0];
    return count != 2;
}

int app_parse_name(const char *command, const char *option, const char *text, const char *const *names,
                   int count, int *out) {
    char allowed[128] = "";
    for (int i = 0; i < count; i++) {
        size_t used = strlen(allowed);
        snprintf(allowed + used, sizeof allowed - used, "%s%s", i ? ", " : "", names[i]);
        if (strcmp(names[i], text) != 0) continue;
        *out = i;
        return APP_GOOD;
    }
    return app_misuse(command, "%s: %s is `%s` (allowed %s)", command, option, text, allowed);
}

bool app_parse_point(const char *text, Vec3 *out) {
    char extra;
    return sscanf(text, "%lf,%lf,%lf%c", &out->x, &out->y, &out->z, &extra) == 3 && isfinite(out->x) &&
           isfinite(out->y) && isfinite(out->z);
}

bool app_parse_size(const char *text, int *width, int *height) {
    char extra;
    return sscanf(text, "%dx%d%c", width, height, &extra) == 2 && *width >= 16 && *width <= 8192 &&
           *height >= 16 && *height <= 8192;
}

void app_print_notes(const Building *building, int most) {
    static const char *const kinds[NOTE_KINDS] = {"leak", "left out", "changed"};
    for (int i = 0; i < building->note_count && i < most; i++) {
        fprintf(stderr, "%s: %s\n", kinds[building->notes[i].kind], building->notes[i].text);
    }
    if (building->note_count > most) fprintf(stderr, "and %d more notes\n", building->note_count - most);
}
