// test_quake_faults.c - damaged levels of the Quake family are refused with a sentence, or read; and portal files of other levels.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "maps/quake/quake.h"
#include "tests/support/files/quake_builder.h"
#include "tests/support/support.h"

// Reads, finds cells, reads rows, writes rows, as far as that goes; returns whether all went well. Without a sentence nothing may fail.
static bool try_level(Bytes content, Arena *arena, Error *error) {
    QuakeLevel level, again;
    QuakeCells cells;
    *error = (Error){""};
    bool good = quake_read("t.bsp", content, arena, &level, error) &&
                quake_cells(&level, &(QuakePortals){NULL, false}, arena, &cells, error);
    if (good) {
        int words = (level.cluster_count + 63) / 64;
        uint64_t *rows = ARENA_ARRAY(arena, uint64_t, level.cluster_count * words);
        good = quake_rows(&level, words, rows, error);
        Bytes out;
        Error writing = {""};
        bool written = quake_with_rows(&level, rows, words, arena, &out, &writing);
        cr_assert(written || writing.text[0]);
        if (written) cr_assert(quake_read("t.bsp", out, arena, &again, &writing), "%s", writing.text);
        if (good) *error = writing;
        good = good && written;
    }
    cr_assert(good || error->text[0]);
    return good;
}

static Bytes copy(Arena *arena, Bytes content, size_t size) {
    Bytes out = {ARENA_ARRAY(arena, unsigned char, size + 1), size};
    memcpy(out.data, content.data, size);
    return out;
}

static QuakeBuilt sound_level(Arena *arena, QuakeFormat format) {
    QuakeBuilt built = quake_build(arena, QUAKE_ROOMS, QUAKE_ROOM_COUNT, &(QuakeStyle){.format = format});
    QuakeLevel level;
    Error error = {""};
    cr_assert(quake_read("t.bsp", built.file, arena, &level, &error), "%s", error.text);
    int words = (level.cluster_count + 63) / 64;
    uint64_t *rows = ARENA_ARRAY(arena, uint64_t, level.cluster_count * words);
    for (int i = 0; i < level.cluster_count; i++) rows[i * words] = (uint64_t)1 << i % 64;
    Bytes out;
    cr_assert(quake_with_rows(&level, rows, words, arena, &out, &error), "%s", error.text);
    built.file = out;
    return built;
}

// A level that ends at any byte before its last lump's end is refused. Each of its bytes, set to one of four values, gives a sentence or a
// level. Of both, one in seven is tried, but in the soak each is.
Test(quake_faults, every_byte) {
    size_t step = support_soak() ? 1 : 7;
    for (int f = 0; f < QUAKE_FORMATS; f++) {
        Arena arena = {0};
        QuakeBuilt built = sound_level(&arena, f);
        Error error;
        cr_assert(try_level(built.file, &arena, &error), "%s", error.text);
        Arena own = {0};
        for (size_t size = 0; size < built.file.size; size += step) {
            if (try_level(copy(&own, built.file, size), &own, &error))
                cr_expect(built.file.size - size < 4, "%zu of %zu bytes", size, built.file.size);
            arena_reset(&own);
        }
        static const unsigned char VALUES[] = {0, 1, 0x7F, 0xFF};
        for (size_t i = 0; i < built.file.size; i += step) {
            Bytes content = copy(&own, built.file, built.file.size);
            content.data[i] = VALUES[(i + i / 4) % 4];
            try_level(content, &own, &error);
            arena_reset(&own);
        }
        arena_free(&own);
        arena_free(&arena);
    }
}

static void put_i32(unsigned char *p, int value) {
    for (int i = 0; i < 4; i++) p[i] = (unsigned char)((unsigned)value >> (8 * i) & 255);
}

// Where record i of a lump stands in the file.
static unsigned char *record(Bytes file, QuakeFormat f, QuakeLump lump, int i) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[f];
    return file.data + quake_i32(file.data + layout->header + 8 * layout->lump[lump]) +
           i * layout->record[lump];
}

// Faults are named with what was found and what is allowed.
Test(quake_faults, sentences) {
    enum {
        SHARED,
        MAGIC,
        VERSION,
        LUMP,
        ODD,
        PLANE,
        NORMAL,
        NODE,
        CYCLE,
        LEAF,
        SIZE,
        CLUSTERS,
        ROW,
        FACES,
        CASES
    };
    static const char *const EXPECTED[CASES] = {
        [SHARED] = "t.bsp: its lump of leaves shares bytes with lump 3 (allowed: each has its own)",
        [MAGIC] = "t.bsp: is no level of a known format (allowed: Quake's of version 29, 2PSB and BSP2",
        [VERSION] = "t.bsp: is an IBSP of version 46 (allowed: 38",
        [LUMP] = "t.bsp: its lump of nodes, 1000000 bytes at byte",
        [ODD] = "bytes (allowed: a multiple of",
        [PLANE] = "t.bsp: node 0: its plane is -1 (allowed 0 to",
        [NORMAL] = "t.bsp: plane 0 has a normal of length",
        [NODE] = "t.bsp: node 1: a child is leaf 35535 (allowed: nodes 0 to",
        [CYCLE] = "t.bsp: node 0 hangs in the tree twice",
        [LEAF] = "t.bsp: node 0: a child is leaf 25534 (allowed: nodes 0 to",
        [SIZE] = "t.bsp: the level reaches from nan to",
        [CLUSTERS] = "t.bsp: the level says that 0 of its leaves may see (allowed 1 to",
        [ROW] = "t.bsp: row 2 of the visibility lump, from byte 99999 on, leaves the lump of",
        [FACES] = "t.bsp: leaf 1: has 65535 faces from",
    };
    for (int i = 0; i < CASES; i++) {
        Arena arena = {0};
        QuakeFormat f = i == VERSION ? QUAKE_IBSP38 : QUAKE_29;
        const QuakeLayout *layout = &QUAKE_LAYOUTS[f];
        Bytes file = sound_level(&arena, f).file;
        unsigned char *nodes = record(file, f, QUAKE_NODES, 0);
        unsigned char *size = file.data + layout->header + 8 * layout->lump[QUAKE_NODES] + 4;
        float nan = NAN;
        if (i == SHARED) memcpy(file.data + 4 + 8 * 3, file.data + 4 + 8 * 10, 8);
        if (i == MAGIC) file.data[0] = 28;
        if (i == VERSION) put_i32(file.data + 4, 46);
        if (i == LUMP) put_i32(size, 1000000);
        if (i == ODD) put_i32(size, quake_i32(size) - 1);
        if (i == PLANE) put_i32(nodes, -1);
        if (i == NORMAL) put_i32(record(file, f, QUAKE_PLANES, 0), 0x40000000);
        if (i == NODE) nodes[24 + 4] = 30000 & 255, nodes[24 + 5] = 30000 >> 8;
        if (i == CYCLE) nodes[24 + 4] = nodes[24 + 5] = 0;
        if (i == LEAF) nodes[4] = 40001 & 255, nodes[5] = 40001 >> 8;
        if (i == SIZE) memcpy(record(file, f, QUAKE_MODELS, 0), &nan, 4);
        if (i == CLUSTERS) put_i32(record(file, f, QUAKE_MODELS, 0) + 52, 0);
        if (i == ROW) put_i32(record(file, f, QUAKE_LEAVES, 3) + 4, 99999);
        if (i == FACES) memset(record(file, f, QUAKE_LEAVES, 1) + 22, 0xFF, 2);
        Error error;
        cr_expect(!try_level(file, &arena, &error), "case %d", i);
        cr_expect(strstr(error.text, EXPECTED[i]), "case %d: `%s`", i, error.text);
        arena_free(&arena);
    }
}

// A chain of nodes that is deeper than any level's is refused, not followed.
Test(quake_faults, deep_tree) {
    Arena arena = {0};
    enum { BOXES = 1100 };
    QuakeBox *boxes = ARENA_ARRAY(&arena, QuakeBox, BOXES);
    for (int i = 0; i < BOXES; i++) boxes[i] = (QuakeBox){{16 * i, 0, 0}, {16 * i + 8, 8, 8}, 0, NULL};
    QuakeBuilt built = quake_build(&arena, boxes, BOXES, &(QuakeStyle){.format = QUAKE_BSP2});
    Error error;
    cr_expect(!try_level(built.file, &arena, &error));
    cr_expect(strstr(error.text, "t.bsp: the tree is more than 1024 nodes deep at node"), "%s", error.text);
    arena_free(&arena);
}

// The text of a portal file of all portals of a level, as its compiler would write it; `shift` moves every leaf's number on by one.
static void write_prt(const char *path, const QuakeCells *cells, int count, int shift) {
    FILE *file = fopen(path, "w");
    const Building *b = &cells->building;
    fprintf(file, "PRT1\n%d\n%d\n", count, b->given_portal_count);
    for (int i = 0; i < b->given_portal_count; i++) {
        const GivenPortal *p = &b->given_portals[i];
        fprintf(file, "%d %d %d", p->vertex_count, (p->cell[0] + shift) % count,
                (p->cell[1] + shift) % count);
        for (int k = p->vertex_count - 1; k >= 0; k--) {
            Vec3 v = vec3_scale(b->vertices[p->first_vertex + k], QUAKE_METRE);
            fprintf(file, " (%.17g %.17g %.17g)", v.x, v.y, v.z);
        }
        fprintf(file, "\n");
    }
    fclose(file);
}

// A portal file gives the same cells and portals as the leaves do. That of a level with other counts, or with portals elsewhere, is
// refused.
Test(quake_faults, portal_files) {
    for (int f = 0; f < QUAKE_FORMATS; f++) {
        Arena arena = {0};
        QuakeBuilt built = sound_level(&arena, f);
        QuakeLevel level;
        QuakeCells own, given;
        Error error = {""};
        char path[64];
        snprintf(path, sizeof path, "/tmp/quake-%d-%d.prt", (int)getpid(), f);
        cr_assert(quake_read("t.bsp", built.file, &arena, &level, &error));
        cr_assert(quake_cells(&level, &(QuakePortals){NULL, false}, &arena, &own, &error));
        write_prt(path, &own, level.cluster_count, 0);
        cr_assert(quake_cells(&level, &(QuakePortals){path, false}, &arena, &given, &error), "%s",
                  error.text);
        cr_assert_eq(given.building.given_portal_count, own.building.given_portal_count);
        for (int i = 0; i < own.building.given_portal_count; i++) {
            const GivenPortal *a = &own.building.given_portals[i], *b = &given.building.given_portals[i];
            cr_expect(a->cell[0] == b->cell[0] && a->cell[1] == b->cell[1]);
            for (int k = 0; k < a->vertex_count; k++)
                cr_expect(vec3_equal(own.building.vertices[a->first_vertex + k],
                                     given.building.vertices[b->first_vertex + k]));
        }
        cr_expect(memcmp(own.cell_of_leaf, given.cell_of_leaf, (size_t)level.leaf_count * sizeof(int)) == 0);
        write_prt(path, &own, level.cluster_count + 1, 0);
        cr_expect(!quake_cells(&level, &(QuakePortals){path, false}, &arena, &given, &error));
        cr_expect(strstr(error.text, "it is not of this level"), "%s", error.text);
        write_prt(path, &own, level.cluster_count, 1);
        cr_expect(!quake_cells(&level, &(QuakePortals){path, false}, &arena, &given, &error));
        cr_expect(strstr(error.text, "lie between other leaves than in t.bsp, and 0 in what is solid there"),
                  "%s", error.text);
        remove(path);
        arena_free(&arena);
    }
}
