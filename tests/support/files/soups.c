// soups.c - see soups.h.
#include "tests/support/files/soups.h"

#include <criterion/criterion.h>

#include "engine/core/random.h"

const double SOUPS_ROOM[8][3] = {{0, 0, 0},   {4, 0, 0},   {4, 3, 0},   {0, 3, 0},
                                 {0, 0, 2.5}, {4, 0, 2.5}, {4, 3, 2.5}, {0, 3, 2.5}};
const int SOUPS_WALL[6][4] = {{0, 1, 2, 3}, {7, 6, 5, 4}, {0, 4, 5, 1},
                              {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};

bool soups_read(const MapsReader *reader, const char *path, const void *data, size_t size, Arena *arena,
                Building *out, Error *error) {
    unsigned char *copy = arena_alloc(arena, size + 1, 1);
    if (size > 0) memcpy(copy, data, size);
    *out = (Building){0};
    reader->recognise((Bytes){copy, size});
    return reader->read(path, (Bytes){copy, size}, arena, out, error);
}

void soups_accept(const MapsReader *reader, const char *path, const char *text, Arena *arena, Building *out) {
    Error error = {""};
    const char *fault = "";
    cr_assert(soups_read(reader, path, text, strlen(text), arena, out, &error), "%s: %s", text, error.text);
    cr_assert_eq(building_check(out, arena, &fault, 1), 0, "%s: %s", text, fault);
}

void soups_refuse(const MapsReader *reader, const char *path, const char *text, const char *expected) {
    Arena arena = {0};
    Building b;
    Error error = {""};
    bool read = soups_read(reader, path, text, strlen(text), &arena, &b, &error);
    cr_expect(!read, "read although it should fail: %s (expected: %s)", text, expected);
    cr_expect(strstr(error.text, expected), "%s\nfound:    %s\nexpected: %s", text, error.text, expected);
    arena_free(&arena);
}

int soups_notes(const Building *b, const char *text) {
    int count = 0;
    for (int i = 0; i < b->note_count; i++) count += strstr(b->notes[i].text, text) != NULL;
    return count;
}

static bool same_polygon(const Building *a, const Polygon *p, const Building *b, const Polygon *q) {
    if (p->vertex_count != q->vertex_count) return false;
    int count = p->vertex_count, same = 0;
    for (int shift = 0; shift < count && same < count; shift++) {
        same = 0;
        while (same < count && vec3_equal(a->vertices[p->first_vertex + same],
                                          b->vertices[q->first_vertex + (same + shift) % count]))
            same++;
    }
    return same == count;
}

void soups_expect_same(const Building *a, const Building *b) {
    cr_assert_eq(a->polygon_count, b->polygon_count, "%d polygons, %d polygons", a->polygon_count,
                 b->polygon_count);
    for (int i = 0; i < a->polygon_count; i++) {
        int like = 0;
        for (int k = 0; k < b->polygon_count; k++)
            like += same_polygon(a, &a->polygons[i], b, &b->polygons[k]);
        cr_expect_eq(like, 1, "polygon %d has %d like it", i, like);
    }
}

// One change; returns the new size. `room` bytes may be used.
static size_t change(unsigned char *data, size_t size, size_t room, Random *random) {
    static const char *const NUMBERS[] = {
        "-1",   "99999", "2147483648", "4294967296", "1e309", "nan", "0", "0x7fffffff", "1e-320", "-0",
        "1e15", "",      "{}",         "[]",         "null",  "\"",  "-", "3",          "1e7",    "\n"};
    if (size == 0) return 0;
    size_t at = (size_t)(random_unit(random) * (double)size), left = size - at, length;
    switch (random_index(random, 5)) {
    case 0:
        data[at] = (unsigned char)random_index(random, 256);
        return size;
    case 1:
        data[at] ^= (unsigned char)(1 << random_index(random, 8));
        return size;
    case 2:
        return at;
    case 3:
        length = (size_t)(random_unit(random) * (double)(left < 40 ? left : 40));
        memmove(data + at, data + at + length, left - length);
        return size - length;
    default:
        break;
    }
    const char *number = NUMBERS[random_index(random, sizeof NUMBERS / sizeof *NUMBERS)];
    length = strlen(number);
    if (size + length > room) return size;
    size_t gone = 0;
    while (gone < left && data[at + gone] > ' ' && data[at + gone] != ',') gone++;
    memmove(data + at + length, data + at + gone, left - gone);
    memcpy(data + at, number, length);
    return size + length - gone;
}

void soups_damage(const MapsReader *reader, const char *path, const void *data, size_t size, uint64_t seed,
                  int rounds) {
    Random random = {seed};
    size_t room = size + 64;
    for (int round = 0; round < rounds; round++) {
        Arena arena = {0};
        unsigned char *copy = arena_alloc(&arena, room, 1);
        memcpy(copy, data, size);
        size_t length = size;
        for (int n = random_index(&random, 3); n >= 0; n--) length = change(copy, length, room, &random);
        Building b;
        Error error = {""};
        const char *fault = "";
        if (soups_read(reader, path, copy, length, &arena, &b, &error))
            cr_assert_eq(building_check(&b, &arena, &fault, 1), 0, "seed %llu round %d: %s",
                         (unsigned long long)seed, round, fault);
        else
            cr_assert(strstr(error.text, path), "seed %llu round %d: `%s` names no file",
                      (unsigned long long)seed, round, error.text);
        arena_free(&arena);
    }
}
