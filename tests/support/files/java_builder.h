// java_builder.h - streams of Java objects made in memory, as ObjectOutputStream writes them: for the tests of their reader, and as seeds
// to fuzz it with.
#ifndef TESTS_JAVA_BUILDER_H
#define TESTS_JAVA_BUILDER_H

#include "engine/core/file.h"

// Start with {.arena = ...}. Each object, string and class gets the next handle.
typedef struct JavaBuilder {
    Arena *arena;
    unsigned char *data;
    int size, capacity, handles;
} JavaBuilder;

void build_java_begin(JavaBuilder *b);
void build_java_number(JavaBuilder *b, uint64_t value, int bytes);  // the highest byte first
void build_java_string(JavaBuilder *b, const char *text);
void build_java_null(JavaBuilder *b);
void build_java_again(JavaBuilder *b, int handle);  // a reference
void build_java_float(JavaBuilder *b, double value);
void build_java_floats(JavaBuilder *b, const double *value, int count);  // one after the other
// Begins an object of a class with these fields, pairs of type and name: "F xStart L level". The values follow in that order. `flags`: 2,
// or 3 where the class writes more beside its fields, which build_java_end ends. Returns the object's handle.
int build_java_object(JavaBuilder *b, const char *class, int flags, const char *fields);
void build_java_end(JavaBuilder *b);
void build_java_list(JavaBuilder *b);  // java.util.ArrayList; members follow, then build_java_end
int build_java_array(JavaBuilder *b, const char *class, int count);  // elements follow
// An empty array of numbers (item 0x75) or a constant of an enumeration (0x7E) whose class, or superclass, has these fields all the same.
int build_java_lie(JavaBuilder *b, int item, const char *class, const char *fields);

// A home as version 3.4 saved it: four walls that have no names and refer to each other in a ring, the first of them without a height and
// with a picture; a room; in the list of furniture a lamp alone, in that of doors and windows the lamp and a door, and in that of groups
// these and a group with a box. `door_as_piece`: the lists that came later are not there, and the one of furniture has a piece that is
// marked as a door. `loop`: the group is a member of itself.
Bytes java_old_home(Arena *arena, bool door_as_piece, bool loop);

#endif
