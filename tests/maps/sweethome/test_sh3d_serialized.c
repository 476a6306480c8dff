// test_sh3d_serialized.c - homes as streams of Java objects are read as their Home.xml is. The program itself writes both forms into one
// file, so that each such file is an oracle.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/sweethome/java_stream.h"
#include "tests/support/files/home_fixture.h"
#include "tests/support/files/java_builder.h"
#include "tests/support/support.h"

// ---- both forms of one home

// Elements and attributes that the reader of homes does not use.
static bool is_unused(const char *name) {
    static const char *const NAMES[] = {"property",      "furnitureVisibleProperty",
                                        "print",         "backgroundImage",
                                        "textStyle",     "polyline",
                                        "label",         "lens",
                                        "dimensionLine", "transformation",
                                        "price",         "lightSourceMaterial",
                                        "pattern",       "valueAddedTaxPercentage"};
    for (size_t i = 0; i < sizeof NAMES / sizeof *NAMES; i++)
        if (strcmp(NAMES[i], name) == 0) return true;
    return false;
}

// Numbers may be written with more digits than they need; names of entries may be spelled as in an address.
static bool equal_values(const char *a, const char *b) {
    if (strcmp(a, b) == 0) return true;
    char *end_a, *end_b;
    double x = strtod(a, &end_a), y = strtod(b, &end_b);
    // A float's shortest decimal: seven digits tell it.
    while (fabs(x - y) <= 1e-6 * fabs(x) && *end_a == ' ' && *end_b == ' ') {
        x = strtod(end_a, &end_a);
        y = strtod(end_b, &end_b);
    }
    return end_a != a && *end_a == 0 && *end_b == 0 && fabs(x - y) <= 1e-6 * fabs(x);
}

static const XmlNode *next_used(const XmlNode *node) {
    while (node && is_unused(node->name)) node = node->next;
    return node;
}

static const XmlNode *nth_named(const XmlNode *parent, const char *name, int n) {
    for (const XmlNode *node = parent->first; node; node = node->next)
        if (xml_is(node, name) && n-- == 0) return node;
    return NULL;
}

// Elements of one name and of one role: the textures of the left sides and those of the right sides.
static bool same_kind(const XmlNode *a, const XmlNode *b) {
    const char *x = xml_get(a, "attribute"), *y = xml_get(b, "attribute");
    return xml_is(a, b->name) && strcmp(x ? x : "", y ? y : "") == 0;
}

// The child of `parent` that stands where `child` does among those of its kind.
static const XmlNode *partner(const XmlNode *parent, const XmlNode *child) {
    int before = 0;
    for (const XmlNode *k = child->parent->first; k != child; k = k->next) before += same_kind(k, child);
    for (const XmlNode *node = parent->first; node; node = node->next)
        if (same_kind(node, child) && before-- == 0) return node;
    return NULL;
}

static int count_elements(const XmlNode *node) {
    int count = 1;
    for (const XmlNode *child = next_used(node->first); child; child = next_used(child->next))
        count += count_elements(child);
    return count;
}

// Everything that the XML says is said by the objects too. Returns the number of attributes compared.
static int expect_said(const char *file, const XmlNode *xml, const XmlNode *objects) {
    int compared = 0;
    bool few = xml_is(xml, "home") || xml_is(xml, "environment");
    for (int i = 0; i < xml->attribute_count; i++) {
        const char *name = xml->attributes[2 * i], *value = xml->attributes[2 * i + 1],
                   *other = xml_get(objects, name);
        if (is_unused(name) || (few && strcmp(name, "wallHeight") != 0 && strcmp(name, "groundColor") != 0))
            continue;
        compared++;
        cr_expect(other && equal_values(value, other), "%s: line %d: %s %s='%s', not '%s'", file, xml->line,
                  xml->name, name, value, other ? other : "nothing");
    }
    for (const XmlNode *child = next_used(xml->first); child; child = next_used(child->next)) {
        const XmlNode *other = partner(objects, child);
        cr_expect(other, "%s: line %d: no %s", file, child->line, child->name);
        if (other) compared += expect_said(file, child, other);
    }
    return compared;
}

static int compare_forms(const char *path, int *elements) {
    Arena arena = {0};
    Archive *archive;
    Error error;
    Bytes content = support_read(&arena, path), xml, stream;
    const XmlNode *a, *b;
    cr_assert(archive_open(content, path, &arena, &archive, &error), "%s", error.text);
    cr_assert(archive_read(archive, "Home.xml", SH3D_MAX_XML, &arena, &xml, &error), "%s", error.text);
    cr_assert(archive_read(archive, "Home", SH3D_MAX_XML, &arena, &stream, &error), "%s", error.text);
    cr_assert(xml_parse(xml, path, &arena, &a, &error), "%s", error.text);
    cr_assert(sh3d_serialized(stream, path, &arena, &b, &error), "%s", error.text);
    archive_close(archive);
    int compared = expect_said(path, a, b);
    *elements = count_elements(a);
    cr_expect_eq(count_elements(b), *elements, "%s: %d elements, not %d", path, count_elements(b), *elements);
    arena_free(&arena);
    return compared;
}

// Proves that no element and no attribute that the reader uses is lost or changed: two storeys with sloped walls, pictures with angle,
// scale and offset, baseboards, doors with sashes, a stair, cameras; in real homes lamps, groups, materials and turned models.
Test(sh3d_serialized, says_what_home_xml_says, .timeout = 60) {
    static const char *const SHARED[] = {"sh3d/2-BedroomApartment.sh3d", "sh3d/4-BedroomHouse.sh3d",
                                         "sh3d/textured-room.sh3d"};
    int elements, compared = compare_forms("maps/buildings/attic.sh3d", &elements);
    cr_expect_gt(elements, 90);
    cr_expect_gt(compared, 500);
    for (int i = 0; i < 3; i++)
        if (support_has_shared(SHARED[i]))
            cr_expect_gt(compare_forms(support_shared(SHARED[i]), &elements), 200);
}

// ---- homes of old versions

static Home home_of_stream(bool door_as_piece, bool loop) {
    Home h = {0};
    h.good = sh3d_sketch(java_old_home(&h.arena, door_as_piece, loop), NULL, "Home", &h.arena, &h.b,
                         &h.sketch, &h.error);
    return h;
}

// Proves the conversions that the program makes: walls have names, and refer to each other by them; of three lists of furniture the latest
// counts, so that the lamp is there once; the ground is darkened; a picture whose class did not tell its orientation yet is not oriented
// from left to right.
Test(sh3d_serialized, old_versions_are_converted) {
    Arena arena = {0};
    Error error = {""};
    const XmlNode *home;
    cr_assert(sh3d_serialized(java_old_home(&arena, false, false), "Home", &arena, &home, &error), "%s",
              error.text);
    const XmlNode *first = nth_named(home, "wall", 0), *last = nth_named(home, "wall", 3),
                  *texture = first->first;
    cr_assert(last && !nth_named(home, "wall", 4));
    cr_expect_str_eq(xml_get(last, "wallAtEnd"), xml_get(first, "id"));
    cr_expect_not(xml_get(first, "height"));
    cr_expect_str_eq(xml_get(last, "height"), "240");
    cr_expect_str_eq(xml_get(last, "leftSideColor"), "00123456");
    cr_expect_str_eq(xml_get(texture, "attribute"), "leftSideTexture");
    cr_expect_str_eq(xml_get(texture, "image"), "7/wall.png");
    cr_expect_str_eq(xml_get(texture, "leftToRightOriented"), "false");
    cr_expect_str_eq(xml_get(nth_named(home, "environment", 0), "groundColor"), "00607890");
    cr_expect(nth_named(home, "light", 0) && !nth_named(home, "light", 1));
    cr_expect_str_eq(xml_get(nth_named(home, "furnitureGroup", 0)->first, "name"), "Box");
    arena_free(&arena);
}

// Proves that the whole reader takes such a home: the walls bound a room with one door, whether the door is an object of its own or, as
// before version 1.7, a piece of furniture with a mark.
Test(sh3d_serialized, old_homes_are_read) {
    for (int as_piece = 0; as_piece < 2; as_piece++) {
        Home h = home_of_stream(as_piece, false);
        cr_assert(h.good, "%s", h.error.text);
        cr_expect_eq(h.sketch.wall_count, 4);
        cr_expect_eq(h.sketch.room_count, 1);
        cr_expect_eq(h.sketch.opening_count, 1);
        cr_expect_float_eq(h.b.storeys[0].height, 2.4, 1e-6, "most walls are 240 cm high");
        home_free(&h);
    }
}

// ---- bad streams

static void expect_refused(Bytes stream, const char *words) {
    Arena arena = {0};
    Error error = {""};
    const XmlNode *home;
    cr_expect(!sh3d_serialized(stream, "Home", &arena, &home, &error), "taken, but: %s", words);
    cr_expect(strstr(error.text, words), "'%s' does not say '%s'", error.text, words);
    // Memory follows the stream, not its claims.
    cr_expect_lt(arena.used, (size_t)64 << 20, "%zu bytes for: %s", arena.used, words);
    arena_free(&arena);
}

static Bytes bytes_of(const JavaBuilder *b) { return (Bytes){b->data, (size_t)b->size}; }

// Proves that each of these gets a sentence with its place.
Test(sh3d_serialized, bad_streams_get_a_sentence) {
    Arena arena = {0};
    expect_refused(java_old_home(&arena, false, true), "nested too deep (at most 2097152 and 64 allowed)");
    JavaBuilder other = {.arena = &arena}, claim = {.arena = &arena}, unknown = {.arena = &arena},
                late = {.arena = &arena}, empty = {.arena = &arena};
    build_java_begin(&other);
    build_java_string(&other, "text");
    expect_refused(bytes_of(&other), "Home: the first object is of the class java.lang.String");
    // Arrays within arrays, each with two thousand million elements.
    build_java_begin(&claim);
    for (int i = 0; i < 1000; i++) build_java_array(&claim, "[[F", 2000000000);
    expect_refused(bytes_of(&claim), "the stream ends within an object");
    build_java_begin(&unknown);
    build_java_object(&unknown, "other.Class", 0, "");
    expect_refused(bytes_of(&unknown), "cannot be read without its program");
    build_java_begin(&late);
    build_java_object(&late, "other.Class", 2, "L a");
    build_java_again(&late, 3);
    expect_refused(bytes_of(&late),
                   "byte 62: a reference names an object that the stream does not have so far");
    build_java_begin(&empty);
    build_java_null(&empty);
    expect_refused(bytes_of(&empty), "the stream has no object");
    expect_refused((Bytes){(unsigned char *)"\xAC\xED\0\4", 4}, "no stream of Java objects");
    arena_free(&arena);
}

// Proves that a constant of an enumeration and an array that call themselves walls are walls without fields, and end no program.
Test(sh3d_serialized, classes_may_lie) {
    for (int item = 0x75; item <= 0x7E; item += 9) {
        Arena arena = {0};
        JavaBuilder b = {.arena = &arena};
        Error error = {""};
        const XmlNode *home;
        build_java_begin(&b);
        build_java_object(&b, "com.eteks.sweethome3d.model.Home", 2, "L walls");
        build_java_list(&b);
        int wall = build_java_lie(&b, item, "com.eteks.sweethome3d.model.Wall", "F xStart L level");
        build_java_again(&b, wall);
        build_java_end(&b);
        cr_assert(sh3d_serialized(bytes_of(&b), "Home", &arena, &home, &error), "%s", error.text);
        cr_expect(nth_named(home, "wall", 1) && !xml_get(nth_named(home, "wall", 0), "xStart"));
        arena_free(&arena);
    }
}

// Proves that walls in a ring of a hundred thousand, each within the one before, take no stack.
Test(sh3d_serialized, objects_nest_deep, .timeout = 60) {
    enum { DEEP = 100000 };
    Arena arena = {0};
    JavaBuilder b = {.arena = &arena};
    Error error;
    const JavaObject *out;
    build_java_begin(&b);
    for (int i = 0; i < DEEP; i++) build_java_object(&b, "a.B", 2, "L a");
    build_java_null(&b);
    cr_assert(java_read(bytes_of(&b), "stream", &arena, &out, &error), "%s", error.text);
    int deep = 0;
    for (; out; out = java_object(out, "a")) deep++;
    cr_expect_eq(deep, DEEP);
    arena_free(&arena);
}

// Proves that characters beyond the alphabets, which Java writes as two surrogates, become UTF-8, and broken ones question marks.
Test(sh3d_serialized, text_becomes_utf8) {
    static const struct {
        const char *java, *utf8;
    } TEXTS[] = {{"K\xC3\xBC"
                  "che",
                  "K\xC3\xBC"
                  "che"},
                 {"\xED\xA0\xBD\xED\xB8\x80!", "\xF0\x9F\x98\x80!"},
                 {"a\xC0\x80"
                  "b",
                  "a?b"},
                 {"\xED\xA0\xBD!", "?!"},
                 {"\xFF"
                  "c\xE2\x82",
                  "?c??"}};
    for (size_t i = 0; i < sizeof TEXTS / sizeof *TEXTS; i++) {
        Arena arena = {0};
        JavaBuilder b = {.arena = &arena};
        Error error;
        const JavaObject *out;
        build_java_begin(&b);
        build_java_string(&b, TEXTS[i].java);
        cr_assert(java_read(bytes_of(&b), "stream", &arena, &out, &error), "%s", error.text);
        cr_expect_str_eq(out->text, TEXTS[i].utf8, "text %zu: %s", i, out->text);
        arena_free(&arena);
    }
}

static void try_stream(Bytes stream, const char *what, long which) {
    Arena arena = {0};
    Building b = {0};
    Sketch sketch = {0};
    Error error = {""};
    bool good = sh3d_sketch(stream, NULL, "Home", &arena, &b, &sketch, &error);
    cr_assert(good || strlen(error.text) > 0, "%s %ld: refused without a word", what, which);
    arena_free(&arena);
}

// Cuts at every byte and flips of bits: a sentence or a usable plan, never a crash. A cut stream is always refused.
Test(sh3d_serialized, survives_spoiled_streams, .timeout = 240) {
    Arena arena = {0};
    Bytes small = java_old_home(&arena, false, false), home;
    Archive *archive;
    Error error;
    Bytes content = support_read(&arena, "maps/buildings/attic.sh3d");
    cr_assert(archive_open(content, "attic", &arena, &archive, &error));
    cr_assert(archive_read(archive, "Home", SH3D_MAX_XML, &arena, &home, &error));
    archive_close(archive);
    Random random = {5};
    for (int which = 0; which < 2; which++) {
        Bytes stream = which ? home : small;
        for (size_t cut = 0; cut < stream.size; cut++) {
            Arena scratch = {0};
            const JavaObject *out;
            cr_assert(!java_read((Bytes){stream.data, cut}, "cut", &scratch, &out, &error),
                      "cut at %zu is taken", cut);
            arena_free(&scratch);
        }
        for (int i = 0; i < support_count(1000, 50000); i++) {
            int at = random_index(&random, (int)stream.size), bit = random_index(&random, 8);
            stream.data[at] ^= (unsigned char)(1 << bit);
            try_stream(stream, "seed 5, bit flip", i);
            stream.data[at] ^= (unsigned char)(1 << bit);
        }
    }
    arena_free(&arena);
}
