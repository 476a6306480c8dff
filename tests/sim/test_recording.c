// test_recording.c - a recorded path comes back to the bit, stays small, and a damaged file is refused with its line.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "engine/sim/recording.h"
#include "tests/support/support.h"

static const char *path_in(Arena *arena) { return arena_format(arena, "%s/a.path", support_folder(arena)); }

static Building building_of(int openings) {
    return (Building){
        .source = "homes/my \"old\" home.sh3d", .hash = 0x0123456789abcdefu, .opening_count = openings};
}

// Whole and half-known numbers, the least and the greatest, and any bits that are a number within the limit.
static double random_number(Random *random, double limit) {
    const double special[] = {0, -0.0, 1e-320, -1e-308, limit, -limit, 1.0 / 3, 0.1, nextafter(limit, 0)};
    if (random_unit(random) < 0.2) return special[random_index(random, sizeof special / sizeof *special)];
    double value = random_between(random, -limit, limit) * exp2(-random_index(random, 60));
    return random_unit(random) < 0.3 ? trunc(value) : value;
}

static TourFrame random_frame(Random *random, const TourFrame *before) {
    TourFrame f = {.eye = {random_number(random, MAPS_LIMIT), random_number(random, MAPS_LIMIT),
                           random_number(random, MAPS_LIMIT)},
                   .yaw = random_number(random, M_PI),
                   .pitch = random_number(random, M_PI / 2),
                   .fov = random_between(random, 0.01, 3.1)};
    if (!before) return f;
    // Standing, looking around, walking on the level.
    int kept = random_index(random, 16);
    if (kept & 1) f.eye = before->eye;
    if (kept & 2) f.yaw = before->yaw;
    if (kept & 4) f.pitch = before->pitch;
    if (kept & 8) f.fov = before->fov;
    return f;
}

static Recording *random_recording(Random *random, const Building *b, Arena *arena) {
    Recording *r = recording_new(b, arena);
    float *doors = ARENA_ARRAY(arena, float, b->opening_count);
    int frames = 1 + random_index(random, 200);
    for (int i = 0; i < frames; i++) {
        TourFrame *last = i > 0 ? &r->frames[i - 1] : NULL, f = random_frame(random, last);
        if (last && random_unit(random) < 0.3) f = *last;
        for (int k = 0; k < b->opening_count; k++) {
            if (random_unit(random) < 0.1) doors[k] = (float)random_unit(random);
            if (random_unit(random) < 0.05) doors[k] = (float)random_index(random, 2);
        }
        cr_assert(recording_add(r, &f, doors));
    }
    return r;
}

static bool same_bits(const Recording *a, const Recording *b) {
    if (a->frame_count != b->frame_count || a->door_count != b->door_count) return false;
    for (int i = 0; i < a->door_count; i++) {
        if (a->doors[i].frame != b->doors[i].frame || a->doors[i].opening != b->doors[i].opening ||
            a->doors[i].open != b->doors[i].open)
            return false;
    }
    return memcmp(a->frames, b->frames, (size_t)a->frame_count * sizeof *a->frames) == 0;
}

// Whatever was added comes back to the bit, and the doors of every frame with it.
Test(recording, round_trip) {
    Arena arena = {0};
    const char *path = path_in(&arena);
    for (int seed = 0; seed < support_count(200, 5000); seed++) {
        Arena scratch = {0};
        Random random = {(uint64_t)seed};
        Building b = building_of(random_index(&random, 6));
        Recording *made = random_recording(&random, &b, &scratch);
        Error error = {""};
        cr_assert(recording_save(made, path, &error), "seed %d: %s", seed, error.text);
        Recording *read = recording_load(path, &b, &scratch, &error);
        cr_assert(read, "seed %d: %s", seed, error.text);
        cr_assert(same_bits(made, read), "seed %d: what was read is not what was written", seed);
        cr_assert_arr_eq(read->door_open, made->door_open, (size_t)b.opening_count * sizeof(float), "seed %d",
                         seed);
        arena_free(&scratch);
    }
    arena_free(&arena);
}

// Replaying frame by frame puts the doors as they stood when each frame was added; from frame 0 again, too.
Test(recording, doors_as_they_stood) {
    enum { FRAMES = 500, DOORS = 5 };
    Arena arena = {0};
    Random random = {3};
    Building b = building_of(DOORS);
    Recording *r = recording_new(&b, &arena);
    float stood[FRAMES][DOORS] = {{1, 0, 0.5f, 0, 0}}, doors[DOORS];
    for (int i = 0; i < FRAMES; i++) {
        if (i > 0) memcpy(stood[i], stood[i - 1], sizeof doors);
        if (i % 7 == 3) stood[i][random_index(&random, DOORS)] = (float)random_unit(&random);
        cr_assert(recording_add(r, &(TourFrame){.eye = {i, 0, 0}, .fov = 1}, stood[i]));
    }
    for (int again = 0; again < 2; again++) {
        for (int i = 0; i < FRAMES; i++) {
            recording_doors(r, i, doors);
            cr_assert_arr_eq(doors, stood[i], sizeof doors, "frame %d, round %d", i, again);
        }
    }
    arena_free(&arena);
}

// A minute's walk with turns comes to at most 100 bytes a frame, standing still for an hour to one line.
Test(recording, small) {
    Arena arena = {0};
    Building b = building_of(3);
    float doors[3] = {0};
    const char *path = path_in(&arena);
    Recording *r = recording_new(&b, &arena);
    // None of its numbers is short in decimals.
    TourFrame f = {.eye = {1.0 / 3, 2.0 / 3, 5.0 / 3}, .pitch = -1.0 / 7, .fov = 75 * M_PI / 180};
    for (int i = 0; i < 60 * RECORDING_TICKS; i++) {
        f.yaw = sin(i * 0.01);
        f.eye.x += cos(f.yaw) / 60;
        f.eye.y += sin(f.yaw) / 60;
        doors[1] = (float)fabs(sin(i * 0.02));
        cr_assert(recording_add(r, &f, doors));
    }
    Error error;
    cr_assert(recording_save(r, path, &error), "%s", error.text);
    double each = (double)support_read(&arena, path).size / r->frame_count;
    cr_expect_leq(each, 100, "%.1f bytes a frame", each);
    for (int i = 0; i < 3600 * RECORDING_TICKS; i++) cr_assert(recording_add(r, &f, doors));
    size_t walked = support_read(&arena, path).size;
    cr_assert(recording_save(r, path, &error), "%s", error.text);
    cr_expect_leq(support_read(&arena, path).size, walked + 20);
    arena_free(&arena);
}

// A frame that could not be loaded is not added, so that no walk is lost when it is to be replayed.
Test(recording, refuses_what_it_could_not_load) {
    Arena arena = {0};
    Building b = building_of(1);
    Recording *r = recording_new(&b, &arena);
    const TourFrame good = {.fov = 1}, bad[] = {{.eye = {NAN, 0, 0}, .fov = 1},
                                                {.eye = {0, 2 * MAPS_LIMIT, 0}, .fov = 1},
                                                {.yaw = INFINITY, .fov = 1},
                                                {.pitch = 1.6, .fov = 1},
                                                {.fov = 0},
                                                {.fov = 3.2}};
    const float shut = 0, wrong[] = {-0.1f, 1.1f, NAN};
    Error error = {""};
    cr_expect(!recording_save(r, "nowhere", &error) && strstr(error.text, "nothing was recorded"), "%s",
              error.text);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        cr_expect(!recording_add(r, &bad[i], &shut), "frame %zu was taken", i);
    for (int i = 0; i < 3; i++) cr_expect(!recording_add(r, &good, &wrong[i]), "share %d was taken", i);
    cr_expect_eq(r->frame_count, 0);
    for (int i = 0; i < RECORDING_LONGEST; i++) recording_add(r, &good, &shut);
    cr_expect_eq(r->frame_count, RECORDING_LONGEST);
    cr_expect(!recording_add(r, &good, &shut), "a frame beyond the longest path was taken");
    arena_free(&arena);
}

static Recording *read_text(Arena *arena, const char *text, size_t size, const Building *b, Error *error) {
    unsigned char *copy = arena_alloc(arena, size + 1, 1);
    memcpy(copy, text, size);
    return recording_read("a.path", (Bytes){copy, size}, b, arena, error);
}

static const char HEAD[] = "enfilade path 1\nbuilding \"home\" 0123456789abcdef\nticks 60\n";

// Each fault is named with its line, what was found and what is allowed.
Test(recording, faults) {
    static const struct {
        const char *lines, *says;
    } CASES[] = {
        {"0 0 0 0 0\n", "a.path:4: the field of view is the end of the line"},
        {"0 0 0 0 0 1 2\n", "a.path:4: '2' is left over"},
        {"nan 0 0 0 0 1\n", "a.path:4: the eye's x is 'nan'"},
        {"0 inf 0 0 0 1\n", "a.path:4: the eye's y is 'inf'"},
        {"0 0 1e9 0 0 1\n", "a.path:4: the eye's z is '1e9' (allowed: a number from -1e+08 to 1e+08 metres)"},
        {"0 0 0 1e9 0 1\n", "the yaw is '1e9'"},
        {"0 0 0 0 1.6 1\n", "the pitch is '1.6'"},
        {"0 0 0 0 0 0\n", "the field of view is '0'"},
        {"- 0 0 0 0 1\n", "a.path:4: the eye's x is '-'"},
        {"= 3\n", "nothing to repeat"},
        {"0 0 0 0 0 1\n= 0\n", "a.path:5: the count is '0'"},
        {"0 0 0 0 0 1\n= 864000\n", "a.path:5: the path is too long (allowed: 864000 frames)"},
        {"0 0 0 0 0 1\n= 863999\n- - - - - -\n", "a.path:6: the path is too long"},
        {"door 2 1\n0 0 0 0 0 1\n", "a.path:4: the door is '2' (allowed: a whole number from 0 to 1)"},
        {"door 0 1.5\n0 0 0 0 0 1\n", "its share is '1.5'"},
        {"door 1 1\ndoor 0 1\n0 0 0 0 0 1\n", "a.path:5: too many doors"},
        {"door 0 1\ndoor 0 1\n0 0 0 0 0 1\n",
         "a.path:5: the door is '0' (allowed: a whole number from 1 to 1)"},
        {"0 0 0 0 0 1\ndoor 0 1\n= 2\n", "a.path:6: a door before ="},
        {"0 0 0 0 0 1\ndoor 0 1\n", "ends after a door"},
        {"", "ends without a frame"}};
    Building b = building_of(2);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Error error = {""};
        char *text = arena_format(&arena, "%s%s", HEAD, CASES[i].lines);
        cr_expect_null(read_text(&arena, text, strlen(text), &b, &error), "%s was read", CASES[i].lines);
        cr_expect(strstr(error.text, CASES[i].says), "%s: %s", CASES[i].lines, error.text);
        arena_free(&arena);
    }
}

// The header: what is no path, another version, another building (with both hashes), other ticks.
Test(recording, header_faults) {
    static const struct {
        const char *text, *says;
    } CASES[] = {
        {"", "ends in its header"},
        {"plan 1\n", "a.path:1: is not a recorded path"},
        {"enfilade path 2\n", "a.path:1: the version is '2'"},
        {"enfilade path 1\n0 0 0 0 0 1\n", "a.path:2: no building"},
        {"enfilade path 1\nbuilding \"x\" 12\n",
         "a.path:2: the hash is '12' (allowed: 16 hexadecimal digits)"},
        {"enfilade path 1\nbuilding \"x\" 0123456789abcdee\n",
         "a.path:2: was recorded in \"x\" with hash 0123456789abcdee; this is my \"old\" home.sh3d with hash "
         "0123456789abcdef"},
        {"enfilade path 1\nbuilding \"x\" 0123456789abcdef\nticks 30\n",
         "a.path:3: ticks in a second is '30'"}};
    Building b = building_of(2);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Error error = {""};
        cr_expect_null(read_text(&arena, CASES[i].text, strlen(CASES[i].text), &b, &error));
        cr_expect(strstr(error.text, CASES[i].says), "%s: %s", CASES[i].text, error.text);
        arena_free(&arena);
    }
}

// Cut short, with bytes changed, lines swapped: it is read into a path that could have been added, or refused with a
// sentence.
Test(recording, damaged_files) {
    Arena arena = {0};
    Random random = {11};
    Building b = building_of(4);
    const char *path = path_in(&arena);
    Error error;
    cr_assert(recording_save(random_recording(&random, &b, &arena), path, &error), "%s", error.text);
    Bytes whole = support_read(&arena, path);
    int refused = 0, cases = support_count(2000, 50000);
    for (int i = 0; i < cases; i++) {
        Arena scratch = {0};
        unsigned char *copy = arena_alloc(&scratch, whole.size + 1, 1);
        memcpy(copy, whole.data, whole.size);
        size_t size = i % 2 ? whole.size : (size_t)random_index(&random, (int)whole.size);
        for (int k = 0; size > 0 && k < 1 + i % 5; k++)
            copy[random_index(&random, (int)size)] =
                (unsigned char)(random_next(&random) >> (i % 3 ? 58 : 56));
        error.text[0] = 0;
        Recording *r = recording_read("a.path", (Bytes){copy, size}, &b, &scratch, &error);
        refused += r == NULL;
        if (!r) cr_assert_neq(error.text[0], 0, "case %d is refused without a reason", i);
        for (int k = 0; r && k < r->frame_count; k++)
            cr_assert(fabs(r->frames[k].eye.x) <= MAPS_LIMIT && r->frames[k].fov > 0, "case %d, frame %d", i,
                      k);
        arena_free(&scratch);
    }
    cr_expect_gt(refused, cases / 2, "only %d of %d damaged files were refused", refused, cases);
    arena_free(&arena);
}
