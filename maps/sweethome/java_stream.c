// java_stream.c - see java_stream.h. Objects nest as deep as a home has walls, since each wall refers to the next one: the reader keeps
// a stack of its own. Classes nest a few deep, and are read by recursion.
#include "maps/sweethome/java_stream.h"

#include <string.h>

#include "engine/core/text.h"

static const unsigned char START[4] = {0xAC, 0xED, 0, 5};

// The first byte of each item of the stream.
enum {
    ITEM_NULL = 0x70,
    ITEM_REFERENCE,
    ITEM_CLASS_DESCRIPTION,
    ITEM_OBJECT,
    ITEM_STRING,
    ITEM_ARRAY,
    ITEM_CLASS,
    ITEM_BLOCK,
    ITEM_END_OF_BLOCK,
    ITEM_RESET,
    ITEM_LONG_BLOCK,
    ITEM_EXCEPTION,
    ITEM_LONG_STRING,
    ITEM_PROXY_DESCRIPTION,
    ITEM_ENUM
};
enum { FLAG_WRITES = 1, FLAG_SERIALIZABLE = 2, FLAG_EXTERNALIZABLE = 4, FLAG_BLOCKS = 8 };
enum { FIRST_HANDLE = 0x7E0000, MOST_SUPERCLASSES = 64, MOST_FIELDS = 4096 };

// The stream may refer to these again. Both are NULL for a Class object.
typedef struct Handle {
    const JavaClass *class;
    const JavaObject *object;
} Handle;

// An object or array that is being read.
typedef struct Open {
    JavaObject *object;
    // Whose fields are read, from the topmost superclass down; NULL: the elements of an array
    const JavaClass *class;
    int next;  // value to read, of the object
} Open;

typedef struct Stream {
    Bytes bytes;
    size_t at;
    const char *where;
    Arena *arena;
    Handle *handles;
    Open *open;
    size_t owed;  // values of open objects that are still to come, each of one byte at least
    int handle_count, handle_capacity, open_count, open_capacity, object_count;
    Error *error;
    bool failed;
} Stream;

static bool refuse(Stream *s, const char *what) {
    if (!s->failed) error_set(s->error, "%s: byte %zu: %s", s->where, s->at, what);
    s->failed = true;
    return false;
}

// ---- bytes

static const unsigned char *next_bytes(Stream *s, uint64_t count) {
    if (s->failed || count > s->bytes.size - s->at) {
        refuse(s, "the stream ends within an object");
        return NULL;
    }
    s->at += (size_t)count;
    return s->bytes.data + s->at - count;
}

// A number of `size` bytes, the highest first; 0 where the stream ends.
static uint64_t take_number(Stream *s, int size) {
    const unsigned char *from = next_bytes(s, (uint64_t)size);
    uint64_t value = 0;
    for (int i = 0; from && i < size; i++) value = value << 8 | from[i];
    return value;
}

static int peek(const Stream *s) { return s->at < s->bytes.size ? s->bytes.data[s->at] : -1; }

// One character of Java's modified UTF-8: up to three bytes, a surrogate as a character of its own; -1: no such character.
static int take_unit(const unsigned char **at, const unsigned char *end) {
    const unsigned char *p = *at;
    int length = *p < 0x80 ? 1 : (*p & 0xE0) == 0xC0 ? 2 : (*p & 0xF0) == 0xE0 ? 3 : 0;
    if (length == 0 || end - p < length) return -1;
    int unit = length == 1 ? *p : *p & (length == 2 ? 0x1F : 0x0F);
    for (int i = 1; i < length; i++) {
        if ((p[i] & 0xC0) != 0x80) return -1;
        unit = unit << 6 | (p[i] & 0x3F);
    }
    *at = p + length;
    return unit;
}

// Text as UTF-8. Broken characters and those that XML forbids become question marks.
static const char *take_text(Stream *s, uint64_t length) {
    const unsigned char *from = next_bytes(s, length);
    if (!from) return "";
    const unsigned char *end = from + length;
    char *out = ARENA_ARRAY(s->arena, char, length + 1), *to = out;
    while (from < end) {
        int unit = take_unit(&from, end), low = -1;
        if (unit < 0) from++;
        const unsigned char *after = from;
        if (unit >= 0xD800 && unit < 0xDC00 && from < end) low = take_unit(&after, end);
        if (low >= 0xDC00 && low < 0xE000) {
            unit = 0x10000 + ((unit - 0xD800) << 10) + (low - 0xDC00);
            from = after;
        } else if ((unit < ' ' && unit != '\t' && unit != '\n') || (unit >= 0xD800 && unit < 0xE000) ||
                   unit > 0xFFFD) {
            unit = '?';
        }
        to += text_utf8(to, (unsigned long)unit);
    }
    return out;
}

static JavaValue take_primitive(Stream *s, char type) {
    JavaValue out = {.type = type};
    uint32_t word;
    uint64_t wide;
    float single;
    switch (type) {
    case 'B':
        out.number = (int8_t)take_number(s, 1);
        break;
    case 'Z':
        out.number = take_number(s, 1) != 0;
        break;
    case 'C':
        out.number = (double)take_number(s, 2);
        break;
    case 'S':
        out.number = (int16_t)take_number(s, 2);
        break;
    case 'I':
        out.number = (int32_t)take_number(s, 4);
        break;
    case 'J':
        out.number = (double)(int64_t)take_number(s, 8);
        break;
    case 'F':
        word = (uint32_t)take_number(s, 4);
        memcpy(&single, &word, sizeof single);
        out.number = (double)single;
        break;
    default:
        wide = take_number(s, 8);
        memcpy(&out.number, &wide, sizeof out.number);
        break;
    }
    return out;
}

// Bytes of a primitive type; 0: a reference; -1: no type.
static int type_size(int type) {
    switch (type) {
    case 'B':
    case 'Z':
        return 1;
    case 'C':
    case 'S':
        return 2;
    case 'I':
    case 'F':
        return 4;
    case 'J':
    case 'D':
        return 8;
    case 'L':
    case '[':
        return 0;
    default:
        return -1;
    }
}

// ---- handles

static int add_handle(Stream *s, const JavaClass *class, const JavaObject *object) {
    if (s->handle_count >= JAVA_MAX_OBJECTS) {
        refuse(s, "the stream has more than 2,097,152 objects");
        return 0;
    }
    *ARENA_PUSH(s->arena, s->handles, s->handle_count, s->handle_capacity) = (Handle){class, object};
    return s->handle_count - 1;
}

static Handle take_reference(Stream *s) {
    uint64_t number = take_number(s, 4) - FIRST_HANDLE;
    if (!s->failed && number < (uint64_t)s->handle_count) return s->handles[number];
    refuse(s, "a reference names an object that the stream does not have so far");
    return (Handle){NULL, NULL};
}

static JavaObject *new_object(Stream *s, const JavaClass *class) {
    JavaObject *out = ARENA_ARRAY(s->arena, JavaObject, 1);
    out->class = class;
    out->number = ++s->object_count;
    add_handle(s, NULL, out);
    return out;
}

static const JavaObject *take_string(Stream *s, int length_size) {
    JavaObject *out = new_object(s, NULL);
    out->text = take_text(s, take_number(s, length_size));
    return out;
}

// A string, or a reference to one; else NULL.
static const JavaObject *take_string_item(Stream *s) {
    int item = (int)take_number(s, 1);
    const JavaObject *out = item == ITEM_STRING        ? take_string(s, 2)
                            : item == ITEM_LONG_STRING ? take_string(s, 8)
                            : item == ITEM_REFERENCE   ? take_reference(s).object
                                                       : NULL;
    if (out && out->text) return out;
    refuse(s, "another item stands where a string is needed");
    return NULL;
}

// ---- classes

static void take_fields(Stream *s, JavaClass *class) {
    class->field_count = (int)take_number(s, 2);
    if (class->field_count > MOST_FIELDS) {
        refuse(s, "a class has more than 4,096 fields");
        return;
    }
    JavaField *fields = ARENA_ARRAY(s->arena, JavaField, class->field_count);
    class->fields = fields;
    for (int i = 0; i < class->field_count && !s->failed; i++) {
        int type = (int)take_number(s, 1);
        fields[i].type = (char)type;
        fields[i].name = take_text(s, take_number(s, 2));
        if (type_size(type) < 0) refuse(s, "a field has a type that Java does not have");
        if (!s->failed && type_size(type) == 0) take_string_item(s);
    }
}

// The description of a class, or a reference to one; NULL: none.
static const JavaClass *take_class(Stream *s, int depth) {
    int item = (int)take_number(s, 1);
    if (s->failed || item == ITEM_NULL) return NULL;
    if (item == ITEM_REFERENCE) {
        const JavaClass *known = take_reference(s).class;
        if (!known) refuse(s, "a reference names no class where one is needed");
        return known;
    }
    if (item != ITEM_CLASS_DESCRIPTION || depth >= MOST_SUPERCLASSES) {
        refuse(s, item == ITEM_CLASS_DESCRIPTION ? "a class has more than 64 superclasses"
                                                 : "another item stands where a class is needed");
        return NULL;
    }
    JavaClass *class = ARENA_ARRAY(s->arena, JavaClass, 1);
    class->name = take_text(s, take_number(s, 2));
    take_number(s, 8);  // the serial version of the class
    int handle = add_handle(s, NULL, NULL);
    class->flags = (int)take_number(s, 1);
    take_fields(s, class);
    if (!s->failed && take_number(s, 1) != ITEM_END_OF_BLOCK)
        refuse(s, "a class has annotations, which no home has");
    class->super = s->failed ? NULL : take_class(s, depth + 1);
    if (s->failed) return NULL;
    // The class gets its handle's meaning last, so that it cannot be above itself.
    s->handles[handle].class = class;
    if (class->super) {
        class->first_field = class->super->first_field + class->super->field_count;
        class->depth = class->super->depth + 1;
    }
    if (class->first_field > MOST_FIELDS) refuse(s, "a class has more than 4,096 fields");
    if (class->depth > MOST_SUPERCLASSES) refuse(s, "a class has more than 64 superclasses");
    return class;
}

// ---- objects

// The values that a short stream claims to have are not allocated.
static bool open_object(Stream *s, JavaObject *object, const JavaClass *first, uint64_t count) {
    if (s->failed || count + s->owed > s->bytes.size - s->at)
        return refuse(s, "the stream ends within an object");
    s->owed += (size_t)count;
    object->value_count = (int)count;
    object->values = ARENA_ARRAY(s->arena, JavaValue, count);
    *ARENA_PUSH(s->arena, s->open, s->open_count, s->open_capacity) = (Open){object, first, 0};
    return true;
}

static const JavaObject *begin_object(Stream *s) {
    const JavaClass *class = take_class(s, 0);
    if (!class) {
        refuse(s, "an object has no class");
        return NULL;
    }
    const JavaClass *top = class;
    for (const JavaClass *c = class; c; top = c, c = c->super)
        if (!(c->flags & FLAG_SERIALIZABLE) &&
            (c->flags & (FLAG_EXTERNALIZABLE | FLAG_BLOCKS)) != (FLAG_EXTERNALIZABLE | FLAG_BLOCKS))
            refuse(s, "a class cannot be read without its program");
    JavaObject *object = new_object(s, class);
    open_object(s, object, top, (uint64_t)(class->first_field + class->field_count));
    return object;
}

static const JavaObject *begin_array(Stream *s) {
    const JavaClass *class = take_class(s, 0);
    if (!class || class->name[0] != '[' || type_size(class->name[1]) < 0) {
        refuse(s, "an array has no type of elements");
        return NULL;
    }
    JavaObject *object = new_object(s, class);
    char type = class->name[1];
    int size = type_size(type);
    uint64_t count = take_number(s, 4);
    if (size == 0) {
        open_object(s, object, NULL, count);
        return object;
    }
    if (s->failed || count > (s->bytes.size - s->at) / (uint64_t)size) {
        refuse(s, "the stream ends within an array");
        return NULL;
    }
    if (type == 'B' || type == 'C') {
        next_bytes(s, count * (uint64_t)size);
        return object;
    }
    object->value_count = (int)count;
    object->values = ARENA_ARRAY(s->arena, JavaValue, count);
    for (int i = 0; i < object->value_count; i++) object->values[i] = take_primitive(s, type);
    return object;
}

static const JavaObject *take_enum(Stream *s) {
    const JavaClass *class = take_class(s, 0);
    if (!class) {
        refuse(s, "an object has no class");
        return NULL;
    }
    JavaObject *object = new_object(s, class);
    const JavaObject *name = take_string_item(s);
    object->text = name ? name->text : "";
    return object;
}

// The next reference, of an object that may be open still: its values follow. Sets *is_item to false for data of other kinds, which are
// passed over.
static JavaValue take_item(Stream *s, bool *is_item) {
    JavaValue out = {.type = 'L'};
    *is_item = true;
    switch ((int)take_number(s, 1)) {
    case ITEM_NULL:
        break;
    case ITEM_REFERENCE:
        out.object = take_reference(s).object;
        break;
    case ITEM_OBJECT:
        out.object = begin_object(s);
        break;
    case ITEM_STRING:
        out.object = take_string(s, 2);
        break;
    case ITEM_LONG_STRING:
        out.object = take_string(s, 8);
        break;
    case ITEM_ARRAY:
        out.object = begin_array(s);
        break;
    case ITEM_ENUM:
        out.object = take_enum(s);
        break;
    case ITEM_CLASS:
        if (!take_class(s, 0)) refuse(s, "an object has no class");
        add_handle(s, NULL, NULL);
        break;
    case ITEM_BLOCK:
        next_bytes(s, take_number(s, 1));
        *is_item = false;
        break;
    case ITEM_LONG_BLOCK:
        next_bytes(s, take_number(s, 4));
        *is_item = false;
        break;
    default:
        refuse(s, "an item of a kind that no home has");
        break;
    }
    return out;
}

static void take_value(Stream *s, Open *open, char type) {
    JavaValue *to = &open->object->values[open->next++];
    s->owed--;
    bool is_item = true;
    *to = type_size(type) > 0 ? take_primitive(s, type) : take_item(s, &is_item);
    if (!is_item) refuse(s, "data stand where an object is needed");
}

// Where the stream goes on: at the innermost open object. `open` may move when an object opens within it.
static void go_on(Stream *s) {
    Open *open = &s->open[s->open_count - 1];
    JavaObject *object = open->object;
    const JavaClass *class = open->class;
    bool is_item, has_fields = class && class->flags & FLAG_SERIALIZABLE;
    if (!class && open->next < object->value_count) {
        take_value(s, open, '[');
    } else if (has_fields && open->next < class->first_field + class->field_count) {
        take_value(s, open, class->fields[open->next - class->first_field].type);
    } else if (class && (!has_fields || class->flags & FLAG_WRITES) && peek(s) != ITEM_END_OF_BLOCK) {
        JavaValue item = take_item(s, &is_item);
        if (is_item && !s->failed)
            *ARENA_PUSH(s->arena, object->written, object->written_count, object->written_capacity) = item;
    } else if (!class) {
        s->open_count--;
    } else {
        // The mark that ends what the class wrote beside its fields.
        if (!has_fields || class->flags & FLAG_WRITES) take_number(s, 1);
        if (!has_fields) s->owed -= (size_t) class->field_count;
        if (class == object->class) {
            s->open_count--;
            return;
        }
        const JavaClass *below = object->class;
        while (below->super != class) below = below->super;
        open->class = below;
        open->next = below->first_field;
    }
}

bool java_recognise(Bytes content) {
    return content.size >= sizeof START && memcmp(content.data, START, sizeof START) == 0;
}

bool java_read(Bytes stream, const char *where, Arena *arena, const JavaObject **out, Error *error) {
    Stream s = {.bytes = stream, .where = where, .arena = arena, .error = error};
    if (!java_recognise(stream))
        return refuse(&s, "the data are no stream of Java objects (AC ED 00 05 is needed)");
    s.at = sizeof START;
    bool is_item = false;
    while (!s.failed && !is_item) *out = take_item(&s, &is_item).object;
    while (!s.failed && s.open_count > 0) go_on(&s);
    if (!s.failed && !*out) refuse(&s, "the stream has no object");
    return !s.failed;
}

// ---- fields

bool java_is(const JavaObject *object, const char *class_name) {
    for (const JavaClass *c = object ? object->class : NULL; c; c = c->super)
        if (strcmp(c->name, class_name) == 0) return true;
    return false;
}

const JavaValue *java_field(const JavaObject *object, const char *name) {
    if (!object || object->value_count == 0) return NULL;
    for (const JavaClass *c = object->class; c; c = c->super)
        for (int i = 0; i < c->field_count; i++)
            if (strcmp(c->fields[i].name, name) == 0 && c->first_field + i < object->value_count)
                return &object->values[c->first_field + i];
    return NULL;
}

const JavaObject *java_object(const JavaObject *object, const char *name) {
    const JavaValue *value = java_field(object, name);
    return value ? value->object : NULL;
}

const char *java_text(const JavaObject *object, const char *name) {
    const JavaObject *string = java_object(object, name);
    return string ? string->text : NULL;
}

int java_items(const JavaObject *list, const JavaValue **out) {
    // Lists that hold another one, or an array, or one element, by the names of their fields.
    static const char *const HOLDERS[] = {"a", "list", "c"};
    const JavaValue *value;
    for (int depth = 0; list && depth < MOST_SUPERCLASSES; depth++) {
        if (list->class && list->class->name[0] == '[') {
            *out = list->values;
            return list->value_count;
        }
        const JavaObject *held = NULL;
        for (int i = 0; i < 3 && !held; i++) held = java_object(list, HOLDERS[i]);
        if (!held) break;
        list = held;
    }
    if (!list) return 0;
    value = java_field(list, "element");
    *out = value ? value : list->written;
    return value ? 1 : list->written_count;
}
