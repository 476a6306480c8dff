// test_derived.c - what is wrong with a derived file is found and told apart, whatever the format behind its head.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/file.h"
#include "tests/support/support.h"

enum { BODY = 11, BUILDING = 77, GEOMETRY = 78 };

static const DerivedKind KIND = {
    .magic = "ENFTRY", .name = ".try", .version = 3, .header = sizeof(DerivedHead) + 8, .largest = 1000};

static void put_text(DerivedSink *sink, const void *context) {
    const char *text = context;
    derived_put(sink, text, 4);
    derived_put(sink, text + 4, BODY - 4);
}

static Bytes saved(const char *path, Arena *arena) {
    Error error = {""};
    unsigned char header[sizeof(DerivedHead) + 8] = {0};
    cr_assert(derived_write(path, &KIND, BUILDING, GEOMETRY, header, put_text, "eleven byte", &error), "%s",
              error.text);
    return support_read(arena, path);
}

// As the caller of both steps does.
static bool taken(const char *path, uint64_t building, Arena *arena, Bytes *file, Error *error) {
    return derived_read(path, &KIND, building, arena, file, error) &&
           derived_check_body(path, &KIND, *file, BODY, error);
}

// Proves that a file comes back with its hash of the geometry, and is refused for another building.
Test(derived, comes_back_for_its_building_only) {
    Arena arena = {0};
    Error error = {""};
    Bytes back;
    const char *path = arena_format(&arena, "%s/x.try", support_folder(&arena));
    saved(path, &arena);
    cr_assert(taken(path, BUILDING, &arena, &back, &error), "%s", error.text);
    DerivedHead head;
    memcpy(&head, back.data, sizeof head);
    cr_assert_eq(head.geometry, GEOMETRY);
    cr_assert_eq(memcmp(back.data + KIND.header, "eleven byte", BODY), 0);
    cr_assert_not(taken(path, BUILDING + 1, &arena, &back, &error));
    cr_assert_not_null(strstr(error.text, "belongs to another building"), "%s", error.text);
    arena_free(&arena);
}

// Proves that each part of the head is looked at, and that the sentence names what was found and what is allowed.
Test(derived, says_what_is_wrong) {
    static const struct {
        int at;  // of the byte that is changed, and -1 for none
        int size;
        const char *says;
    } CASES[] = {
        {0, 59, ": is not a .try file"},
        {7, 59, ": is not a .try file"},
        {8, 59, ": has version 2 (this program reads version 3)"},
        {12, 59, ": was written on a machine of another byte order"},
        {16, 59, ": belongs to another building, or to an earlier state of this one"},
        {32, 59, ": is damaged: its checksum is wrong"},
        {58, 59, ": is damaged: its checksum is wrong"},
        {-1, 58, ": has 58 bytes (its header says 59)"},
        {-1, 60, ": has 60 bytes (its header says 59)"},
        {-1, 47, ": has 47 bytes, less than a .try header"},
        {-1, 1001, ": has 1001 bytes (at most 1000 are read)"},
    };
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/x.try", support_folder(&arena));
    Bytes good = saved(path, &arena), back;
    cr_assert_eq(good.size, 59);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        unsigned char bad[1001] = {0};
        memcpy(bad, good.data, good.size);
        if (CASES[i].at >= 0) bad[CASES[i].at] ^= 1;
        Error error = {""};
        cr_assert(file_write(path, bad, (size_t)CASES[i].size, &error));
        cr_assert_not(taken(path, BUILDING, &arena, &back, &error), "case %zu", i);
        cr_assert_str_eq(error.text, arena_format(&arena, "%s%s", path, CASES[i].says));
    }
    arena_free(&arena);
}
