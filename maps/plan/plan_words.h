// plan_words.h - one line of a .plan file: its words, and how they become names, numbers, points and options.
// Every function that returns false has set the error: file, line, the words found, the words allowed.
#ifndef MAPS_PLAN_WORDS_H
#define MAPS_PLAN_WORDS_H

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/vec.h"

// Declared names and the index each stands for.
typedef struct PlanNames {
    const char **name;
    int *index;
    int count, name_capacity, index_capacity;
} PlanNames;

typedef struct PlanLine {
    const char *path;
    int number;  // from 1
    char **words;
    int count, capacity, next;  // words[next] is read next
    const PlanNames *materials;
    int open_line;  // line of the last shape while it is a patch or metaballs that may get more lines; 0: none
    Arena *arena;
    Error *error;
} PlanLine;

// The points of a PLAN_SHAPE, or the numbers of a PLAN_LIST.
typedef struct PlanList {
    Vec2 *points;
    double *numbers;
    int count;
} PlanList;

// `word value`: options stand in any order after the fixed words of a statement.
typedef struct PlanOption {
    const char *word;
    enum {
        PLAN_LENGTH,    // double, metres
        PLAN_PURE,      // double, no unit
        PLAN_ANGLE,     // double, degrees in the file, radians in `out`
        PLAN_WHOLE,     // int
        PLAN_SPECTRUM,  // double[3]; one number stands for all three
        PLAN_MATERIAL,  // int
        PLAN_NAME,      // const char *
        PLAN_FLAG,      // bool
        PLAN_CHOICE,    // int: which of `words`
        PLAN_SET,       // unsigned: a bit for each of `words` named
        PLAN_SHAPE,     // PlanList: points x,y
        PLAN_TRIPLE,    // Vec3: x,y,z
        PLAN_LIST       // PlanList: numbers to the next word
    } kind;
    void *out;
    double min, max;    // of every number
    const char *words;  // of choices and sets, separated by blanks
    bool required, given;
} PlanOption;

bool plan_fail(const PlanLine *line, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Cuts `text` (changed) into words: separated by blanks, "quoted" where they hold some. A `#` that begins the
// line or stands before a blank begins a comment.
bool plan_split(PlanLine *line, char *text);

// Each reads the next word or words; `what` names them in messages.
bool plan_name(PlanLine *line, const char *what, const char **out);
bool plan_number(PlanLine *line, const char *what, double min, double max, const char *unit, double *out);
bool plan_whole(PlanLine *line, const char *what, int min, int max, int *out);
bool plan_material(PlanLine *line, int *out);
bool plan_spectrum(PlanLine *line, const char *what, double min, double max, double out[3]);
bool plan_point(PlanLine *line, const char *what, Vec2 *out);
bool plan_place(PlanLine *line, const char *what, bool z_needed, Vec3 *out);  // z 0 when left out
bool plan_points(PlanLine *line, const char *what, int least, PlanList *out);
bool plan_options(PlanLine *line, PlanOption *options, int count);  // to the end of the line
bool plan_end(PlanLine *line);
bool plan_is(const PlanLine *line, const char *word);   // the next word is `word`
bool plan_is_point(const PlanLine *line, int numbers);  // the next word looks like x,y (2) or x,y,z (3)

int plan_find(const PlanNames *names, const char *name);  // the name's index, or -1
bool plan_declare(PlanLine *line, PlanNames *names, const char *what, const char *name, int index);

#endif
