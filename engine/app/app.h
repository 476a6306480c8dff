// app.h - what the subcommands share: loading a building with its cells and stab trees, progress, JSON.
#ifndef APP_APP_H
#define APP_APP_H

#include <jansson.h>

#include "visibility/vis.h"

#define APP_VERSION "0.1.0"

// Exit codes.
enum { APP_GOOD = 0, APP_BAD_INPUT = 1, APP_BAD_USE = 2 };

typedef struct AppCommand {
    const char *name, *summary;
    int (*run)(int argc, char **argv);  // argv[0] is the command's name
} AppCommand;

int cmd_info(int argc, char **argv);
int cmd_vis(int argc, char **argv);
int cmd_plan(int argc, char **argv);
int cmd_walk(int argc, char **argv);
int cmd_bake(int argc, char **argv);
int cmd_render(int argc, char **argv);
int cmd_bench(int argc, char **argv);

typedef struct AppOptions {
    VisOptions vis;
    bool fresh;       // make the stab trees anew even if the cache has them
    bool keep;        // store them in the cache
    bool lamps;       // give lights faces that emit (lamp_faces.h)
    bool stoppable;   // Ctrl-C ends the search early with sets that are too large, never with ones too small
    const char *map;  // of a file that holds several; NULL: the first
    const char
        *work;  // what is done with the building, where it may take too much memory: "baking"; NULL: working
} AppOptions;
AppOptions app_default_options(void);

typedef struct AppScene {
    Building building;
    CellGraph graph;
    StabForest forest;
    double read_seconds, cells_seconds, trees_seconds;
    int lamp_faces;  // objects added for lights
    bool cached;     // the trees came from the cache
    bool kept;       // the cache has them
    bool stopped;    // early, as AppOptions allows
    long long
        undecided;  // pairs of cells, both ways round, that are neither proven to see each other nor excluded
} AppScene;

// Reads the building, makes cells, and stab trees or finds them in the cache. A cache that cannot be used is passed
// over with a warning.
bool app_load(const char *path, const AppOptions *options, Arena *arena, AppScene *out, Error *error);

// False, and a sentence, for a file of cells and portals alone, in which there is nothing to draw or to walk on.
bool app_has_walls(const AppScene *scene, Error *error);

// Has it any material that emits light?
bool app_emits(const AppScene *scene);

// As much of it: reads the building and makes its cells.
bool app_load_cells(const char *path, const AppOptions *options, Arena *arena, AppScene *out, Error *error);

// A file in the user's cache, or NULL: there is no cache.
char *app_cache_path(Arena *arena, const char *name);
// Can it be written there, `size` bytes and more? Makes the cache's folder.
bool app_cache_check(const char *path, size_t size, Error *error);
// The same for those who do without: where it cannot, one sentence says so on standard error, once in a process.
bool app_cache_takes(const char *path, size_t size);

// Are the files that are written none of those that are read? NULLs are passed over, here and below.
bool app_spares(const char *const *written, int write_count, const char *const *read, int read_count,
                Error *error);
// Before the work: can each of the files be written, and is it none of those that are read, nor another of these? The paths
// last: app_load and app_load_cells refuse a building that refers to one of the files.
enum { APP_MOST_WRITTEN = 4 };
bool app_check_files(const char *const *written, int write_count, const char *const *read, int read_count,
                     Error *error);
// The same of files that the command comes to read later.
bool app_output_spares(const char *const *read, int read_count, Error *error);

// ---- memory (app_memory.c)

void app_count_libraries(void);  // from now on what libraries ask of us counts, too: before anything else
// The value of --memory; returns the exit code.
int app_take_memory(const char *command, const char *text);
// What may be used while a building is opened, from here on, and what while something is done with it (`work`: "baking"). All who
// load begin with the first; app_load ends with the second. `file` lasts.
void app_open_budget(const char *file);
void app_work_budget(const char *file, const char *work);
// From now on, a building that takes too much is given up with a sentence as long as that is possible, for there is another to
// go on with.
void app_memory_gently(void);

// A bar on standard error, on a terminal only.
Progress app_progress(void);
void app_progress_end(void);
// The same bar, which also asks to stop `seconds` from now (0: never), or when the user interrupts (Ctrl-C; the second
// time ends the program as usual).
Progress app_progress_stoppable(double seconds);

// The counts every command with --json gives: cells, portals, doors, doors_joined, polygons, stab_nodes, leaks, ...
json_t *app_counts(const AppScene *scene);
void app_print_json(json_t *object);  // to standard output; frees it

// `enfilade: SENTENCE` on standard error; returns the exit code given.
int app_fail(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));
// Wrong use: the sentence and how to get help.
int app_misuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

// What getopt_long, whose options begin with a colon, answers to an option without its value (`:`) or without a meaning.
int app_misuse_option(const char *command, int answer, char **argv);

// Numbers on the command line: the whole text must be one. `low` and `high` included.
bool app_parse_number(const char *text, double low, double high, double *out);
bool app_parse_int(const char *text, int low, int high, int *out);
bool app_parse_sky(const char *text, double radiance[3]);        // L or R,G,B, 0 to 1e6 each, W/m^2/sr
bool app_parse_point(const char *text, Vec3 *out);               // X,Y,Z
bool app_parse_size(const char *text, int *width, int *height);  // WxH, 16 to 8192 each
// One of so many names; else wrong use, which tells them all. Returns the exit code.
int app_parse_name(const char *command, const char *option, const char *text, const char *const *names,
                   int count, int *out);

// What was not enclosed, left out or changed, a line each on standard error.
void app_print_notes(const Building *building, int most);

#endif
