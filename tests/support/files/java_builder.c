// java_builder.c - see java_builder.h.
#include "tests/support/files/java_builder.h"

#include <stdio.h>
#include <string.h>

#define MODEL "com.eteks.sweethome3d.model."

void build_java_number(JavaBuilder *b, uint64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; i--)
        *ARENA_PUSH(b->arena, b->data, b->size, b->capacity) = (unsigned char)(value >> 8 * i);
}

static void put_text(JavaBuilder *b, const char *text, size_t length) {
    build_java_number(b, length, 2);
    for (size_t i = 0; i < length; i++) build_java_number(b, (unsigned char)text[i], 1);
}

void build_java_begin(JavaBuilder *b) { build_java_number(b, 0xACED0005, 4); }

void build_java_string(JavaBuilder *b, const char *text) {
    build_java_number(b, 0x74, 1);
    b->handles++;
    put_text(b, text, strlen(text));
}

void build_java_null(JavaBuilder *b) { build_java_number(b, 0x70, 1); }

void build_java_again(JavaBuilder *b, int handle) {
    build_java_number(b, 0x71, 1);
    build_java_number(b, (uint64_t)(0x7E0000 + handle), 4);
}

void build_java_float(JavaBuilder *b, double value) {
    float single = (float)value;
    uint32_t word;
    memcpy(&word, &single, sizeof word);
    build_java_number(b, word, 4);
}

void build_java_floats(JavaBuilder *b, const double *value, int count) {
    for (int i = 0; i < count; i++) build_java_float(b, value[i]);
}

// All of a description but its superclass.
static void put_class_alone(JavaBuilder *b, const char *class, int flags, const char *fields) {
    build_java_number(b, 0x72, 1);
    put_text(b, class, strlen(class));
    build_java_number(b, 1, 8);
    b->handles++;
    build_java_number(b, (uint64_t)flags, 1);
    int count = 0, used;
    char type, name[64];
    for (const char *f = fields; sscanf(f, " %c %63s%n", &type, name, &used) == 2; f += used) count++;
    build_java_number(b, (uint64_t)count, 2);
    for (const char *f = fields; sscanf(f, " %c %63s%n", &type, name, &used) == 2; f += used) {
        build_java_number(b, (unsigned char)type, 1);
        put_text(b, name, strlen(name));
        if (type == 'L' || type == '[') build_java_string(b, "Ljava/lang/Object;");
    }
    build_java_end(b);
}

static void put_class(JavaBuilder *b, const char *class, int flags, const char *fields) {
    put_class_alone(b, class, flags, fields);
    build_java_null(b);
}

int build_java_object(JavaBuilder *b, const char *class, int flags, const char *fields) {
    build_java_number(b, 0x73, 1);
    put_class(b, class, flags, fields);
    return b->handles++;
}

void build_java_end(JavaBuilder *b) { build_java_number(b, 0x78, 1); }

void build_java_list(JavaBuilder *b) {
    build_java_object(b, "java.util.ArrayList", 3, "I size");
    build_java_number(b, 1, 4);
    build_java_number(b, 0x77, 1);  // four bytes beside: its capacity
    build_java_number(b, 4, 1);
    build_java_number(b, 1, 4);
}

int build_java_array(JavaBuilder *b, const char *class, int count) {
    build_java_number(b, 0x75, 1);
    put_class(b, class, 2, "");
    build_java_number(b, (uint64_t)count, 4);
    return b->handles++;
}

int build_java_lie(JavaBuilder *b, int item, const char *class, const char *fields) {
    bool is_array = item == 0x75;
    build_java_number(b, (uint64_t)item, 1);
    if (is_array) put_class_alone(b, "[F", 2, "");
    put_class(b, class, 2, fields);
    int handle = b->handles++;
    if (is_array)
        build_java_number(b, 0, 4);
    else
        build_java_string(b, "CONSTANT");
    return handle;
}

// ---- a home

static void put_picture(JavaBuilder *b) {
    build_java_object(b, MODEL "HomeTexture", 2, "F width F height L image");
    build_java_floats(b, (double[]){50, 40}, 2);
    build_java_object(b, "com.eteks.sweethome3d.tools.URLContent", 2, "L url");
    build_java_object(b, "java.net.URL", 2, "L file");
    build_java_string(b, "file:temp!/7/wall.png");
}

// The wall from corner `i` on; it holds the next one, and the last one refers to the first. Sets the handles of all.
static void put_wall(JavaBuilder *b, int i, int handles[4]) {
    static const double CORNERS[5][2] = {{0, 0}, {400, 0}, {400, 300}, {0, 300}, {0, 0}};
    handles[i] = build_java_object(
        b, MODEL "Wall", 2,
        "F xStart F yStart F xEnd F yEnd F thickness L height L leftSideTexture L leftSideColor L wallAtEnd");
    build_java_floats(b, CORNERS[i], 4);
    build_java_float(b, 10);
    if (i == 0) {
        build_java_null(b);
        put_picture(b);
        build_java_null(b);
    } else {
        build_java_object(b, "java.lang.Float", 2, "F value");
        build_java_float(b, 240);
        build_java_null(b);
        build_java_object(b, "java.lang.Integer", 2, "I value");
        build_java_number(b, 0x123456, 4);
    }
    if (i < 3)
        put_wall(b, i + 1, handles);
    else
        build_java_again(b, handles[0]);
}

static int put_piece(JavaBuilder *b, const char *class, const char *name, double x, double y, bool door) {
    char full[80];
    snprintf(full, sizeof full, MODEL "%s", class);
    int handle =
        build_java_object(b, full, 2, "L name F x F y F width F depth F height Z visible Z doorOrWindow");
    build_java_string(b, name);
    build_java_floats(b, (double[]){x, y, 90, 10, 200}, 5);
    build_java_number(b, 1, 1);
    build_java_number(b, door, 1);
    return handle;
}

static void put_group(JavaBuilder *b, bool loop) {
    int handle = build_java_object(b, MODEL "HomeFurnitureGroup", 2, "L name Z visible L furniture");
    build_java_string(b, "Group");
    build_java_number(b, 1, 1);
    build_java_list(b);
    if (loop)
        build_java_again(b, handle);
    else
        put_piece(b, "HomePieceOfFurniture", "Box", 100, 200, false);
    build_java_end(b);
}

Bytes java_old_home(Arena *arena, bool door_as_piece, bool loop) {
    JavaBuilder b = {.arena = arena};
    build_java_begin(&b);
    build_java_object(&b, MODEL "Home", 3,
                      "J version I groundColor F wallHeight L walls L rooms L furniture L "
                      "furnitureWithDoorsAndWindows L furnitureWithGroups");
    build_java_number(&b, 3400, 8);
    build_java_number(&b, 0x80A0C0, 4);
    build_java_float(&b, 250);
    build_java_list(&b);
    int walls[4];
    put_wall(&b, 0, walls);
    for (int i = 1; i < 4; i++) build_java_again(&b, walls[i]);
    build_java_end(&b);
    build_java_list(&b);
    build_java_object(&b, MODEL "Room", 2, "[ points L name");
    build_java_array(&b, "[[F", 4);
    for (int i = 0; i < 4; i++) {
        static const double CORNERS[4][2] = {{0, 0}, {400, 0}, {400, 300}, {0, 300}};
        build_java_array(&b, "[F", 2);
        build_java_floats(&b, CORNERS[i], 2);
    }
    build_java_string(&b, "Room");
    build_java_end(&b);
    build_java_list(&b);
    int lamp = put_piece(&b, "HomeLight", "Lamp", 200, 150, false);
    if (door_as_piece) put_piece(&b, "HomePieceOfFurniture", "Door", 200, 0, true);
    build_java_end(&b);
    if (door_as_piece) {
        build_java_null(&b);
        build_java_null(&b);
    } else {
        build_java_list(&b);
        build_java_again(&b, lamp);
        int door = put_piece(&b, "HomeDoorOrWindow", "Door", 200, 0, true);
        build_java_end(&b);
        build_java_list(&b);
        build_java_again(&b, lamp);
        build_java_again(&b, door);
        put_group(&b, loop);
        build_java_end(&b);
    }
    build_java_end(&b);
    return (Bytes){b.data, (size_t)b.size};
}
