// test_plan_samples.c - the plans that come with the project, whole and damaged.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/maps/plan_fixture.h"
#include "tests/support/support.h"
#include "visibility/vis.h"

// Where no door or window leads out there is no outdoors; where one does there is.
Test(plan, outdoors_only_where_it_is_seen) {
    static const struct {
        const char *opening;
        bool outdoors;
    } cases[] = {{"door d 4.1,2 angle 90 width 1 height 2\n", false},
                 {"window w 2,-0.1 width 1 sill 1 height 1\n", true}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        Arena arena = {0};
        Building b;
        bool outdoors = false;
        plan_read_more(&arena, cases[k].opening, &b);
        for (int i = 0; i < b.region_count; i++) outdoors = outdoors || b.regions[i].kind == REGION_OUTDOORS;
        cr_expect_eq(outdoors, cases[k].outdoors, "%s", cases[k].opening);
        const char *fault = "";
        cr_expect_eq(building_check(&b, &arena, &fault, 1), 0, "%s", fault);
        arena_free(&arena);
    }
}

static const char *const SAMPLES[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                      "build/maps/house.sh3d", "build/maps/office.plan",
                                      "build/maps/office-plain.plan"};

enum { SAMPLE_COUNT = sizeof SAMPLES / sizeof SAMPLES[0] };

// Every bundled building reads without a note, passes the check, and each of its openings joins two regions.
Test(plan, samples_are_sound) {
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        Arena arena = {0};
        Building b;
        Error error = {""};
        cr_assert(maps_read(SAMPLES[i], &arena, &b, &error), "%s", error.text);
        cr_expect_eq(b.note_count, 0, "%s: %s", SAMPLES[i], b.note_count ? b.notes[0].text : "");
        for (int k = 0; k < b.opening_count; k++)
            cr_expect(b.openings[k].region[0] >= 0 && b.openings[k].region[1] >= 0, "%s: %s leads nowhere",
                      SAMPLES[i], b.openings[k].name);
        arena_free(&arena);
    }
}

static void build_cells(Arena *arena, const char *path, Building *b, CellGraph *graph) {
    Error error = {""};
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
    cr_assert(vis_build_cells(b, &options, arena, graph, &error), "%s", error.text);
}

// The figures of the reference office: 66 floors, 264 pieces of ceiling, 66 lamps, 34 + 230 * 3 walls, 460 jambs,
// 66 * 89 pieces of furniture.
Test(plan, office_plain_has_7454_polygons) {
    Arena arena = {0};
    Building b;
    CellGraph graph;
    build_cells(&arena, "build/maps/office-plain.plan", &b, &graph);
    cr_expect_eq(b.polygon_count, 66 * 89);
    cr_expect_eq(graph.polygon_count, 7454);
    cr_expect_eq(b.opening_count, 115);
    arena_free(&arena);
}

// The office has the size of the one in the paper (16,719 polygons), whatever the seed, and is another for another.
Test(plan, office_has_its_size) {
    Arena arena = {0};
    char *folder = support_folder(&arena), *first = NULL;
    for (int seed = 1; seed <= support_count(4, 40); seed++) {
        char *path = arena_format(&arena, "%s/office.plan", folder), *output;
        int status = support_run(&arena, &output, "build/generate office %d > %s", seed, path);
        cr_assert_eq(status, 0, "%s", output);
        char *text = (char *)support_read(&arena, path).data;
        if (seed == 1) cr_expect_str_eq(text, (char *)support_read(&arena, "build/maps/office.plan").data);
        cr_expect(!first || strcmp(first, text) != 0, "seed %d is like seed 1", seed);
        first = first ? first : text;
        Building b;
        CellGraph graph;
        build_cells(&arena, path, &b, &graph);
        int rooms = 0;
        for (int i = 0; i < b.region_count; i++) rooms += b.regions[i].kind == REGION_ROOM;
        cr_expect(rooms >= 66, "seed %d: %d rooms", seed, rooms);
        cr_expect(graph.polygon_count >= 16000 && graph.polygon_count <= 17500, "seed %d: %d polygons", seed,
                  graph.polygon_count);
        cr_expect_eq(b.note_count, 0, "seed %d: %s", seed, b.note_count ? b.notes[0].text : "");
    }
    cr_expect_eq(support_run(&arena, NULL, "build/generate office"), 2);
    cr_expect_eq(support_run(&arena, NULL, "build/generate palace 1"), 2);
    cr_expect_eq(support_run(&arena, NULL, "build/generate office 1x"), 2);
    arena_free(&arena);
}

// The house is the same home in both formats: as many rooms and doors, the same floor area.
Test(plan, house_in_both_formats) {
    Arena arena = {0};
    Building plan, home;
    Error error = {""};
    cr_assert(maps_read("build/maps/house.plan", &arena, &plan, &error), "%s", error.text);
    cr_assert(maps_read("build/maps/house.sh3d", &arena, &home, &error), "%s", error.text);
    int rooms[2] = {0}, doors[2] = {0};
    for (int way = 0; way < 2; way++) {
        const Building *b = way ? &home : &plan;
        for (int i = 0; i < b->region_count; i++) rooms[way] += b->regions[i].kind == REGION_ROOM;
        for (int i = 0; i < b->opening_count; i++) doors[way] += b->openings[i].kind == OPENING_DOOR;
    }
    cr_expect_eq(rooms[0], rooms[1]);
    cr_expect(doors[0] == doors[1] && doors[0] >= 6, "%d and %d doors", doors[0], doors[1]);
    cr_expect_float_eq(plan.drawn_area, home.drawn_area, 0.01);
    arena_free(&arena);
}

// Every truncation of a sample (every line end and many places between) is read or refused with a sentence.
Test(plan, truncated) {
    Arena arena = {0};
    Bytes sample = support_read(&arena, "maps/buildings/two-rooms.plan");
    Arena scratch = {0};
    for (size_t size = 0; size < sample.size; size += sample.data[size] == '\n' ? 1 : 7) {
        Building b;
        Error error = {""};
        if (!plan_read_bytes(&scratch, sample.data, size, &b, &error))
            cr_expect(strncmp(error.text, "t.plan:", 7) == 0, "%zu bytes: '%s'", size, error.text);
        arena_reset(&scratch);
    }
    arena_free(&scratch);
    arena_free(&arena);
}

// Flipped bits and swapped words: read or refused with a sentence, and what is read passes the check.
Test(plan, damaged, .timeout = 300) {
    Arena arena = {0}, scratch = {0};
    Bytes sample = support_read(&arena, "maps/buildings/two-rooms.plan");
    static const char *const WORDS[] = {"1e8",         "-1e8",   "nan", "1e-30", "-0",
                                        "99999999999", "0.0005", "\"",  ",",     "#"};
    unsigned char *copy = arena_alloc(&arena, sample.size + 32, 1);
    for (int seed = 1; seed <= support_count(1500, 60000); seed++) {
        Random random = {(uint64_t)seed};
        size_t size = sample.size;
        memcpy(copy, sample.data, size);
        for (int k = random_index(&random, 4); k >= 0; k--) {
            int at = random_index(&random, (int)size);
            if (seed % 2) {
                copy[at] ^= (unsigned char)(1 << random_index(&random, 8));
                continue;
            }
            const char *word = WORDS[random_index(&random, (int)(sizeof WORDS / sizeof WORDS[0]))];
            size_t length = strlen(word);
            if ((size_t)at + length < size) memcpy(copy + at, word, length);
        }
        Building b;
        Error error = {""};
        const char *fault = "";
        if (plan_read_bytes(&scratch, copy, size, &b, &error))
            cr_expect_eq(building_check(&b, &scratch, &fault, 1), 0, "seed %d: %s", seed, fault);
        else
            cr_expect(strncmp(error.text, "t.plan", 6) == 0, "seed %d: '%s'", seed, error.text);
        arena_reset(&scratch);
    }
    arena_free(&scratch);
    arena_free(&arena);
}
