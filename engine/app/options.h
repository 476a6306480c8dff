// options.h - the options of a command as one table: parsing, messages and help come from it; the shell's completion and the manual
// page come from the help.
#ifndef APP_OPTIONS_H
#define APP_OPTIONS_H

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/text.h"
#include "engine/scene/day.h"

// Exit codes.
enum { APP_GOOD = 0, APP_BAD_INPUT = 1, APP_BAD_USE = 2, APP_STOPPED = 3 };  // the last: by Ctrl-C

// One option: a row of the table.
typedef struct Option {
    // Without the dashes; of one letter for -o.
    const char *name;
    // The value as the help calls it; NULL: there is none.
    const char *value;
    // One sentence without a full stop. `@` stands for the values allowed, which the row knows; of a text, which may be any, for itself.
    const char *help;
    // The type of an option's value, and of the field of the command's arguments that takes it.
    enum {
        OPTION_FLAG,       // bool; there is no value
        OPTION_TEXT,       // const char *
        OPTION_TEXTS,      // TextList: the option may be repeated
        OPTION_OUTPUT,     // const char *: a file to write, whose ending, if it has one, is among `names`
        OPTION_INT,        // int, low to high
        OPTION_SEED,       // uint64_t, low to high
        OPTION_NUMBER,     // double, low to high
        OPTION_DEGREES,    // double, radians; low to high degrees
        OPTION_MEGABYTES,  // size_t, bytes; low to high megabytes
        OPTION_SIZE,       // int[2], pixels: WxH, low to high each
        OPTION_POINT,      // Vec3, metres: X,Y,Z
        OPTION_SKY,        // double[3], W/m^2/sr: L or R,G,B, low to high each
        OPTION_DATE,       // int[3]: YYYY-MM-DD, years low to high
        OPTION_TIME,  // double[2]: HH:MM, hours and NAN, or HH:MM+H, hours and how many a clock is ahead of UTC
        OPTION_PLACE,    // double[2]: LAT,LON, degrees north and east
        OPTION_NAME,     // int: the index of one of `names`
        OPTION_OTHER,    // as `take` does
        OPTION_HEADING,  // no option: a line of the help
    } type;
    // Where the value goes: an offset in the command's arguments.
    size_t at;
    double low, high;
    // [name_count] of OPTION_NAME; of OPTION_OUTPUT the endings, without the dot
    const char *const *names;
    int name_count;
    // For OPTION_OTHER: returns the exit code. The values allowed go to `error`, which stays empty where the function itself has told
    // the fault.
    int (*take)(const char *value, void *arguments, Error *error);
} Option;

typedef struct OptionTable {
    const char *command;
    // The words after `enfilade COMMAND`, a line each.
    const char *usage;
    // Paragraphs, with an empty line between them; NULL: none.
    const char *about;
    const Option *rows;
    int count;
} OptionTable;

#define OPTION_TABLE(command, usage, about, rows)                                                            \
    { (command), (usage), (about), (rows), (int)(sizeof(rows) / sizeof *(rows)) }

// Reads the options into `arguments`, [count] `given` says which were there (NULL: nobody asks), and moves all other words of the
// command line to its end, of which *first is the index of the first. Returns the exit code: after APP_BAD_USE and APP_BAD_INPUT a
// sentence was printed. With --help it sets *help and reads no further.
int options_parse(const OptionTable *table, int argc, char **argv, void *arguments, bool *given, int *first,
                  bool *help);
// For commands with one building file: that file into *file, or wrong use.
int options_parse_file(const OptionTable *table, int argc, char **argv, void *arguments, bool *given,
                       const char **file, bool *help);
// Was the option of this name there?
bool options_given(const OptionTable *table, const bool *given, const char *name);
void options_print_help(const OptionTable *table);
// The rows alone, indented by so many columns; and paragraphs, from column `at` on and filled to the width of the help.
void options_print_rows(const Option *rows, int count, int indent);
void options_print_paragraph(const char *text, int at, int indent);

// `enfilade: SENTENCE` on standard error; returns the exit code given.
int app_fail(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));
// Wrong use: the sentence, which begins with the command, and how to get help.
int app_misuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Which of the endings, without the dot and in either case, a file's name has; -1: another one, `count`: none, as `/dev/stdout`.
int options_ending(const char *path, const char *const *endings, int count);

// Rows that many commands have; `field` is a member of the command's arguments.
#define OPTION_MAP(field)                                                                                    \
    {                                                                                                        \
        .name = "map", .value = "NAME", .type = OPTION_TEXT, .at = (field),                                  \
        .help = "one map of a file that holds several (default: the first)"                                  \
    }
#define OPTION_PHOTOMETRY(field)                                                                             \
    {                                                                                                        \
        .name = "photometry", .value = "NAME=FILE", .type = OPTION_TEXTS, .at = (field),                     \
        .help = "lamps of this name send their light as the photometric file says, IES or EULUMDAT (.ldt); " \
                "may be given for several names"                                                             \
    }
#define OPTION_MEMORY(field, text)                                                                           \
    {                                                                                                        \
        .name = "memory", .value = "MB", .type = OPTION_MEGABYTES, .at = (field), .low = 16,                 \
        .high = 1000000, .help = "memory that may be used, @ (default: " text ")"                            \
    }
// Eight rows, of a DayOptions. `by_default` tells the default.
#define OPTION_DAYLIGHT(field, by_default)                                                                   \
    {.name = "night",                                                                                        \
     .type = OPTION_FLAG,                                                                                    \
     .at = (field) + offsetof(DayOptions, night),                                                            \
     .help = "the light of lamps alone (" by_default ")"},                                                   \
        {.name = "day",                                                                                      \
         .type = OPTION_FLAG,                                                                                \
         .at = (field) + offsetof(DayOptions, day),                                                          \
         .help =                                                                                             \
             "daylight of sun and sky, at the home's own place and hour where its file has them; each of "   \
             "the next five options asks for it, too"},                                                      \
        {.name = "date",                                                                                     \
         .value = "DATE",                                                                                    \
         .type = OPTION_DATE,                                                                                \
         .at = (field) + offsetof(DayOptions, date),                                                         \
         .low = 1900,                                                                                        \
         .high = 2100,                                                                                       \
         .help = "@ (default: the home's own, else 21 June)"},                                               \
        {.name = "time",                                                                                     \
         .value = "TIME",                                                                                    \
         .type = OPTION_TIME,                                                                                \
         .at = (field) + offsetof(DayOptions, time),                                                         \
         .low = -14,                                                                                         \
         .high = 14,                                                                                         \
         .help = "@; without +H the sun's mean time at the place (default: the home's own, else 10:00)"},    \
        {.name = "place",                                                                                    \
         .value = "LAT,LON",                                                                                 \
         .type = OPTION_PLACE,                                                                               \
         .at = (field) + offsetof(DayOptions, place),                                                        \
         .help = "@ (default: the home's own, else 50,0)"},                                                  \
        {.name = "north",                                                                                    \
         .value = "DEG",                                                                                     \
         .type = OPTION_DEGREES,                                                                             \
         .at = (field) + offsetof(DayOptions, north),                                                        \
         .low = -360,                                                                                        \
         .high = 360,                                                                                        \
         .help = "direction of north in the plan, degrees clockwise from +y, @ (default: the home's own, "   \
                 "else 0)"},                                                                                 \
        {.name = "weather",                                                                                  \
         .value = "NAME",                                                                                    \
         .type = OPTION_NAME,                                                                                \
         .at = (field) + offsetof(DayOptions, weather),                                                      \
         .names = DAYLIGHT_WEATHER_NAMES,                                                                    \
         .name_count = DAYLIGHT_WEATHERS,                                                                    \
         .help = "@ (default clear)"},                                                                       \
    {                                                                                                        \
        .name = "sky", .value = "L", .type = OPTION_SKY, .at = (field) + offsetof(DayOptions, sky),          \
        .high = 1e6,                                                                                         \
        .help = "instead of these an even sky of that radiance, W/m^2/sr, without a sun; @ (default 0)"      \
    }
#define OPTION_FILL_LAMPS(field)                                                                             \
    {                                                                                                        \
        .name = "fill-lamps", .value = "STATE", .type = OPTION_NAME, .at = (field),                          \
        .names = FILL_LAMPS_NAMES, .name_count = FILL_LAMPS_STATES,                                          \
        .help = "plain ceiling lamps in rooms that no lamp lights, by day in rooms without windows: @ "      \
                "(default on)"                                                                               \
    }
#define OPTION_LAMPS(field, more)                                                                            \
    {                                                                                                        \
        .name = "lamps", .value = "SPEC", .type = OPTION_TEXT, .at = (field),                                \
        .help = "which lamps are on: parts WHO=STATE with commas between them, or @FILE, a part a line; "    \
                "WHO is a number of `info --lamps`, a lamp, a room or `all`, STATE is `on`, `off`, a share " \
                "as 0.4 or 40%, a colour as #ffd8a8, or both as 40%#ffd8a8; without `=` all are meant" more  \
                " (default on)"                                                                              \
    }
#define OPTION_JSON(field)                                                                                   \
    { .name = "json", .type = OPTION_FLAG, .at = (field), .help = "one JSON object on standard output" }
#define OPTION_THREADS(field)                                                                                \
    {                                                                                                        \
        .name = "threads", .value = "N", .type = OPTION_INT, .at = (field), .low = 1, .high = 256,           \
        .help = "@ (default: all cores)"                                                                     \
    }

#endif
