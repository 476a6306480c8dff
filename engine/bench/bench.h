// bench.h - benchmarks: each measures buildings and writes CSV with a header on standard output. One file, and one row in the table of
// main.c, each.
#ifndef BENCH_BENCH_H
#define BENCH_BENCH_H

#include "engine/app/app.h"
#include "engine/core/text.h"
#include "engine/draw/walk_renderer.h"

enum { BENCH_RESOLUTIONS = 16 };

// The options of all benchmarks; each reads those that its rows name.
typedef struct BenchArguments {
    SceneOptions load;
    char **files;
    int file_count;
    // Width and height of pictures, pixels.
    int size[2];
    int frames;
    WalkLook look;
    // Steps of a walk.
    int steps;
    uint64_t seed;
    // Names with commas between them; NULL: all.
    const char *methods, *cullings;
    // Points on each portal for the lower bound; 0: none.
    int samples;
    // An external compiler, or NULL.
    const char *peer;
    // After which a method is stopped; 0: when done.
    double seconds;
    // Where the table goes besides, or NULL.
    const char *csv;
    int resolutions[BENCH_RESOLUTIONS], resolution_count;
    int shooters;
    // Rays of the reference for each shooter.
    int rays;
    // 20 shooters, 300,000 rays.
    bool quick;
    // Buildings of up to so many rooms are baked.
    int baked_rooms;
    // Points at which light is compared; 0: as the benchmark likes.
    int points;
    // Standard error of the truth there, relative; 0: as the benchmark likes.
    double error;
    // Radiance, W/m^2/sr a channel.
    double sky[3];
    // Half of the points lie within this of a view that the building stores, metres; 0: all lie anywhere.
    double near;
    // The truth is found anew and kept in a file.
    bool keep;
    // The worst points on standard error.
    bool verbose;
    // A folder for pictures that go with a table, or NULL.
    const char *pictures;
} BenchArguments;

// Usual for benchmarks of light.
#define BENCH_LIT_FILES "build/maps/office-plain.plan build/maps/house.plan"

// A benchmark: a row of the table.
typedef struct Bench {
    // `about`: a paragraph about the measurement.
    const char *name, *about;
    // Its own rows of options; --map and --memory are everybody's.
    const Option *options;
    int option_count;
    bool (*run)(const BenchArguments *arguments, Error *error);
    // Is this one of --methods? NULL: the benchmark has none.
    bool (*is_method)(const char *name);
    // The command whose help lists them; NULL: this benchmark's, by print_methods.
    const char *list;
    void (*print_methods)(void);
    // Measured unless others are given, separated by blanks; NULL: the office.
    const char *files;
    // The default of --fill-lamps.
    int fill_lamps;
} Bench;

#define BENCH_AT(field) offsetof(BenchArguments, field)
#define BENCH_OPTIONS(rows) .options = (rows), .option_count = (int)(sizeof(rows) / sizeof *(rows))
// Rows that many benchmarks have.
#define BENCH_SEED(text)                                                                                     \
    {                                                                                                        \
        .name = "seed", .value = "N", .type = OPTION_SEED, .at = BENCH_AT(seed), .high = 2147483647,         \
        .help = text ", @ (default 1)"                                                                       \
    }
#define BENCH_SIZE(text)                                                                                     \
    {                                                                                                        \
        .name = "size", .value = "WxH", .type = OPTION_SIZE, .at = BENCH_AT(size), .low = 16, .high = 8192,  \
        .help = text ", pixels, @ (default 640x360)"                                                         \
    }
#define BENCH_METHODS(text)                                                                                  \
    { .name = "methods", .value = "A,B", .type = OPTION_TEXT, .at = BENCH_AT(methods), .help = text }
#define BENCH_CSV                                                                                            \
    {                                                                                                        \
        .name = "csv", .value = "OUT", .type = OPTION_TEXT, .at = BENCH_AT(csv),                             \
        .help = "writes the table there besides, whole or not at all"                                        \
    }
#define BENCH_POINTS(usual)                                                                                  \
    {                                                                                                        \
        .name = "points", .value = "N", .type = OPTION_INT, .at = BENCH_AT(points), .low = 1,                \
        .high = 1000000, .help = "@ (default " usual ")"                                                     \
    }
#define BENCH_ERROR(text)                                                                                    \
    {                                                                                                        \
        .name = "error", .value = "E", .type = OPTION_NUMBER, .at = BENCH_AT(error), .low = 1e-6, .high = 1, \
        .help = text                                                                                         \
    }
#define BENCH_SKY                                                                                            \
    {                                                                                                        \
        .name = "sky", .value = "L", .type = OPTION_SKY, .at = BENCH_AT(sky), .high = 1e6,                   \
        .help = "daylight, as `enfilade bake` has it: @ (default 0)"                                         \
    }
#define BENCH_PICTURES(text)                                                                                 \
    { .name = "pictures", .value = "DIR", .type = OPTION_TEXT, .at = BENCH_AT(pictures), .help = text }

// A table: its head, the rows of `first` (NULL: none), and those of each file, which `each` adds and prints; on standard output, and
// whole to arguments->csv, if that is given.
bool bench_table(const BenchArguments *arguments, const char *head,
                 bool (*first)(const BenchArguments *arguments, Text *csv, Error *error),
                 bool (*each)(const char *file, const BenchArguments *arguments, Text *csv, Error *error),
                 Error *error);

// Ways to cull views of form factors that tables compare.
enum { BENCH_CULLINGS = 5 };
extern const Culling BENCH_CULLING[BENCH_CULLINGS];

// The building's name in the CSV: without its folder.
const char *bench_name(const char *file);
// Is the word among those of `list`, separated by commas? NULL: any is.
bool bench_listed(const char *list, const char *word);

#endif
