// app.c - loading with a cache, progress on a terminal, JSON and messages for the subcommands.
#include "engine/app/app.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/team/team.h"

// ---- the process

// Opens each standard stream that is closed. Otherwise the first files that are opened would take the place of the stream, and get
// the text that is printed. Printing to a stream opened here fails.
static void open_standard_streams(void) {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0)
            _exit(APP_BAD_INPUT);
}

static int end_output(int code) {
    bool lost = ferror(stdout) != 0;
    errno = 0;
    if (fclose(stdout) == 0 && !lost) return code;
    app_fail(0, "standard output: cannot be written%s%s", errno ? ": " : "", errno ? strerror(errno) : "");
    return code == APP_GOOD ? APP_BAD_INPUT : code;
}

static void fall_silent(void) {
    if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) return;
}

int app_main(int argc, char **argv, int (*run)(int argc, char **argv)) {
    bool good = team_start(&argc, &argv);
    if (team_rank() > 0) fall_silent();
    open_standard_streams();
    // A limit of files' sizes is told of as a full disk is.
    signal(SIGXFSZ, SIG_IGN);
    json_set_alloc_funcs(memory_new, memory_free);
    memory_return_large();
    int code = good ? run(argc, argv)
                    : app_fail(APP_BAD_USE,
                               "mpirun started several processes, and this program was made without MPI: "
                               "make mpi=1 makes build/release-mpi/enfilade");
    code = end_output(code);
    team_end();
    return code;
}

// ---- progress

// How long a stage still takes, if it goes on as so far: "" in its first seconds, when nobody can tell.
static const char *time_left(double since, double done, char text[16]) {
    static const double TELLING = 2, LEAST = 0.02;
    double gone = clock_seconds() - since, left = done > 0 ? gone * (1 - done) / done : 0;
    *text = 0;
    if (gone < TELLING || done < LEAST || done >= 1) return text;
    if (left < 100) snprintf(text, 16, "%.0f s left", left);
    if (left >= 100 && left < 6000) snprintf(text, 16, "%.0f min left", left / 60);
    if (left >= 6000) snprintf(text, 16, "%.0f h left", fmin(left / 3600, 999));
    return text;
}

static bool report(void *context, const char *stage, double done) {
    enum { WIDTH = 40 };
    (void)context;
    static double last, since;
    static char before[16];
    double now = clock_seconds();
    if (strncmp(stage, before, sizeof before - 1) != 0) {
        snprintf(before, sizeof before, "%s", stage);
        since = now;
    }
    if (now - last < 0.05 && done < 1) return true;
    last = now;
    int full = (int)(done * WIDTH);
    char left[16];
    fprintf(stderr, "\r%-12s [%.*s%*s] %3d %% %-13s", stage, full, "########################################",
            WIDTH - full, "", (int)(done * 100), time_left(since, done, left));
    return true;
}

Progress app_progress(void) {
    return isatty(STDERR_FILENO) ? (Progress){report, NULL} : (Progress){NULL, NULL};
}

// A signal or a deadline asks a stage to stop. The signal comes from outside: one flag a process, which any thread may set or read.
static atomic_bool interrupted;
static double deadline;   // on the clock; 0: none
static bool on_terminal;  // is progress seen? Asked once: searches report every few microseconds

static void interrupt(int signal) {
    (void)signal;
    atomic_store(&interrupted, true);
}

static bool report_stoppable(void *context, const char *stage, double done) {
    if (on_terminal) report(context, stage, done);
    return !atomic_load(&interrupted) && (deadline == 0 || clock_seconds() < deadline);
}

Progress app_progress_stoppable(double seconds) {
    struct sigaction action = {.sa_handler = interrupt, .sa_flags = SA_RESETHAND | SA_RESTART};
    sigaction(SIGINT, &action, NULL);
    deadline = seconds > 0 ? clock_seconds() + seconds : 0;
    on_terminal = isatty(STDERR_FILENO);
    return (Progress){report_stoppable, NULL};
}

bool app_interrupted(void) { return atomic_load(&interrupted); }

void app_progress_end(void) {
    if (isatty(STDERR_FILENO)) fprintf(stderr, "\r%78s\r", "");
}

// ---- files

bool app_check_files(const char *const *written, int write_count, const char *const *read, int read_count,
                     SceneOptions *load, Error *error) {
    if (load) load->written = written, load->written_count = write_count;
    if (!scene_spares(written, write_count, read, read_count, error)) return false;
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

void app_warn(const char *sentence) {
    app_progress_end();
    fprintf(stderr, "enfilade: %s\n", sentence);
}

SceneOptions app_scene_options(void) {
    SceneOptions o = scene_default_options();
    o.warn = app_warn;
    o.progress = app_progress();
    return o;
}

int app_check_day(const char *command, const DayOptions *day) {
    if (day->night && day_asks(day))
        return app_misuse(
            command,
            "%s: --night is without daylight (allowed beside it: none of --day, --date, --time, "
            "--place, --north, --weather, --sky)",
            command);
    if (!day_asks_sky(day) || !day_asks_sun(day)) return APP_GOOD;
    return app_misuse(
        command,
        "%s: --sky is an even sky without a sun (allowed beside it: none of --day, --date, --time, "
        "--place, --north, --weather)",
        command);
}

bool app_load(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error) {
    bool good = scene_load(path, options, arena, out, error);
    app_progress_end();
    return good;
}

// Every opening that a person can pass counts as a door, doorways without a leaf included.
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

json_t *app_counts(const LoadedScene *scene) {
    const Building *b = &scene->building;
    int doors = 0, windows = 0, rooms = 0, leaks = 0;
    for (int i = 0; i < b->opening_count; i++) {
        doors += b->openings[i].kind != OPENING_WINDOW;
        windows += b->openings[i].kind == OPENING_WINDOW;
    }
    for (int i = 0; i < b->region_count; i++) rooms += b->regions[i].kind == REGION_ROOM;
    for (int i = 0; i < b->note_count; i++) leaks += b->notes[i].kind == NOTE_LEAK;
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

void app_print_notes(const Building *building, int most) {
    static const char *const kinds[NOTE_KINDS] = {"leak", "left out", "changed"};
    for (int i = 0; i < building->note_count && i < most; i++) {
        fprintf(stderr, "%s: %s\n", kinds[building->notes[i].kind], building->notes[i].text);
    }
    if (building->note_count > most) fprintf(stderr, "and %d more notes\n", building->note_count - most);
}
