// step.h - STEP files (ISO 10303-21): where each entity stands, and its arguments, which are read from the text when they are asked for.
#ifndef MAPS_STEP_H
#define MAPS_STEP_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/file.h"

// Names of entity types that the caller wants told apart; type i of a record is the i-th name.
typedef struct StepTypes {
    const char *const *name;
    int count;  // at most STEP_MOST_TYPES
} StepTypes;

enum {
    STEP_MOST_TYPES = 512,
    STEP_OTHER = 0xFFFF,  // the type of records whose name is none of those
    STEP_MOST_ENTITIES = 1 << 28,
    STEP_MOST_NAMED = INT32_MAX,  // the largest number after #
};
#define STEP_LARGEST UINT32_MAX  // bytes of a file

// A file and the places of its entities. Records are numbered in the order of the file.
typedef struct StepFile {
    const char *path;
    const char *text;  // followed by a zero byte
    const StepTypes *types;
    size_t size;
    char schema[64];  // the first name in FILE_SCHEMA
    int record_count;
    int *entity;     // [record_count] the number after #
    uint16_t *type;  // [record_count]
    uint32_t *at;    // [record_count] byte of the ( before its arguments
    int *by_entity;  // [by_count] record + 1, 0: none; by number, or a hash table where numbers are far apart
    int by_count;
    bool hashed;
} StepFile;

typedef enum StepKind {
    STEP_END,      // no argument is left
    STEP_NONE,     // $, or a value that is damaged
    STEP_DERIVED,  // *
    STEP_NUMBER,
    STEP_STRING,
    STEP_BINARY,
    STEP_ENUM,
    STEP_REF,
    STEP_LIST,
    STEP_TYPED  // NAME(value)
} StepKind;

// One argument.
typedef struct StepValue {
    StepKind kind;
    int record;  // of references: the record, -1 where the file has none of that number
    uint32_t at,
        size;  // bytes: of strings, binary data and enumerators without their quotes or dots; of lists and typed values from (
    union {
        double number;  // of numbers
        uint32_t name;  // of typed values: where the name begins
        int entity;     // of references: the number after #
    };
} StepValue;

// A place among arguments. Only one thread uses a cursor.
typedef struct StepCursor {
    const StepFile *file;
    size_t at;
    size_t *
        bad;  // the first byte in the file that is no argument, of all that were read with it; SIZE_MAX: none
} StepCursor;

// Finds the entities. Fails with a sentence that names the line.
bool step_read(const char *path, Bytes content, const StepTypes *types, int threads, Arena *arena,
               StepFile *out, Error *error);

// The record of #entity, or -1.
int step_find(const StepFile *file, long long entity);
// The line of a byte, from 1.
long long step_line(const StepFile *file, size_t at);
// How many bytes from here on messages may show: plain characters of one line, `most` at most.
int step_shown(const StepFile *file, size_t at, int most);
// The name of the type of a record, as in the file; in the arena unless the name is one of the types'.
const char *step_type_name(const StepFile *file, int record, Arena *arena);

// The arguments of a record, and the elements of a list or the value of a typed value.
StepCursor step_arguments(const StepFile *file, int record, size_t *bad);
StepCursor step_elements(const StepCursor *from, const StepValue *list);
// The next argument. Lists are passed over as a whole, however deep they are.
StepValue step_next(StepCursor *cursor);
// Reads up to `most` arguments; returns how many there were.
int step_values(StepCursor *cursor, StepValue *out, int most);
// The elements of the list that is the next argument, which is not passed over for that; none where it is no list.
StepCursor step_enter(const StepCursor *from);
// Reads up to `most` elements as numbers; typed values count by their value. Returns how many there were.
int step_next_numbers(StepCursor *cursor, double *out, int most);
// Reads up to `most` numbers of a list, in which typed values count by their value; returns how many there were.
int step_numbers(const StepCursor *from, const StepValue *list, double *out, int most);

// Memory for strings, side by side: an arena aligns each piece.
typedef struct StepStrings {
    Arena *arena;
    char *next;
    size_t left;
} StepStrings;
// Room for `size` bytes.
char *step_room(StepStrings *strings, size_t size);

// A string decoded into UTF-8: '' \\ \S\ \P.\ \X\ \X2\ \X4\.
const char *step_string(const StepFile *file, const StepValue *value, StepStrings *strings);
bool step_is(const StepFile *file, const StepValue *value, const char *enumerator);

#endif
