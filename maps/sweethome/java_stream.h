// java_stream.h - the objects of a stream that a Java program wrote by ObjectOutputStream, with their fields by name. No class is
// loaded and nothing of the stream is run: unknown classes are objects as all others.
//
// Source: Java Object Serialization Specification, version 6 of Java SE, chapter 6 (Object Serialization Stream Protocol).
#ifndef MAPS_JAVA_STREAM_H
#define MAPS_JAVA_STREAM_H

#include "engine/core/file.h"

// The most objects, strings and arrays in one stream; real homes have below 100,000.
#define JAVA_MAX_OBJECTS (2 << 20)

typedef struct JavaObject JavaObject;

// The value of a field or an element of an array. `type` is the stream's letter: B C D F I J S Z for primitive types, whose value is
// `number` (0 or 1 for Z), L and [ for references.
typedef struct JavaValue {
    char type;
    double number;
    const JavaObject *object;  // NULL: Java's null
} JavaValue;

typedef struct JavaField {
    const char *name;
    char type;
} JavaField;

typedef struct JavaClass JavaClass;
struct JavaClass {
    const char *name;  // "com.eteks.sweethome3d.model.Wall"
    const JavaClass *super;
    const JavaField *fields;
    int field_count;   // of its own
    int first_field;   // among the values of its objects: those of the superclass come first
    int flags, depth;  // of the stream; of its superclasses, how many there are
};

struct JavaObject {
    const JavaClass *class;  // NULL for a string
    const char *text;        // UTF-8, of a string or of an enumeration's constant; else NULL
    JavaValue *
        values;  // [value_count] the fields, or the elements of an array; of bytes and characters none are kept
    JavaValue
        *written;  // [written_count] objects that a class wrote beside its fields: the elements of a list
    int value_count, written_count, written_capacity;
    int number;  // its place in the stream, from 1
};

bool java_recognise(Bytes content);  // does it begin as a stream does?

// Reads the first object of a stream. `where` names the stream in messages.
bool java_read(Bytes stream, const char *where, Arena *arena, const JavaObject **out, Error *error);

bool java_is(const JavaObject *object, const char *class_name);  // the class or one above it; false for NULL
// The field of this name; the class itself comes before those above it. NULL: no such field.
const JavaValue *java_field(const JavaObject *object, const char *name);
const JavaObject *java_object(const JavaObject *object, const char *name);  // NULL: no such field, or null
const char *java_text(const JavaObject *object, const char *name);  // NULL: no such field, or no string
// The elements of an array, or of a list or set of java.util. Returns how many there are; NULL has none.
int java_items(const JavaObject *list, const JavaValue **out);

#endif
