// app.h - parts that the subcommands share: loading with a bar on the terminal, checks of files, JSON.
#ifndef APP_APP_H
#define APP_APP_H

#include <jansson.h>

#include "engine/app/options.h"
#include "engine/scene/scene.h"

#define APP_VERSION "0.1.0"

int cmd_info(int argc, char **argv);
int cmd_vis(int argc, char **argv);
int cmd_plan(int argc, char **argv);
int cmd_walk(int argc, char **argv);
int cmd_bake(int argc, char **argv);
int cmd_light(int argc, char **argv);
int cmd_render(int argc, char **argv);

// A program: standard streams are open, requests of libraries count as ours, and of processes that mpirun started the first one speaks.
// A result that could not be printed makes a good exit code a bad one.
int app_main(int argc, char **argv, int (*run)(int argc, char **argv));

// Sentences on standard error, after the bar.
void app_warn(const char *sentence);
// The usual options with a bar, and warnings on standard error.
SceneOptions app_scene_options(void);
// scene_load, and the end of the bar.
bool app_load(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error);

// Options of daylight that exclude one another are wrong use.
int app_check_day(const char *command, const DayOptions *day);

// Before the work: can each of the files be written, and is it none of those that are read, nor another of these? NULLs are passed
// over. `load` (or NULL) learns the paths, which last: a building that refers to one of the files is refused.
bool app_check_files(const char *const *written, int write_count, const char *const *read, int read_count,
                     SceneOptions *load, Error *error);

// A bar on standard error, on a terminal only.
Progress app_progress(void);
void app_progress_end(void);
// The same bar, which also asks to stop `seconds` from now (0: never), or when the user interrupts (Ctrl-C; the second
// time ends the program as usual).
Progress app_progress_stoppable(double seconds);
// Whether the user interrupted since then.
bool app_interrupted(void);

// The counts every command with --json gives: cells, portals, doors, doors_joined, polygons, leaks, ...
json_t *app_counts(const LoadedScene *scene);
void app_print_json(json_t *object);  // to standard output; frees it

// The building's notes on parts that were not enclosed, left out or changed, a line each on standard error.
void app_print_notes(const Building *building, int most);

#endif
