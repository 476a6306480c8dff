// recording.c - paths in memory and in their text file. The file may come from anybody, so every line is checked when it
// is read, and a fault is named with its line.
#include "engine/sim/recording.h"

#include <stdio.h>
#include <stdlib.h>

#include "engine/core/text.h"
#include "maps/plan/plan_words.h"

// Bytes: four hours, with a line of some 60 characters and a line for a door in each frame.
static const size_t LARGEST_FILE = (size_t)256 << 20;
// Greatest yaw, radians: a person's yaw stays within half a turn, but that of a path may wind.
static const double GREATEST_YAW = 1e6;
static const double NARROWEST_FOV = 1e-3, WIDEST_FOV = 3.14;

// The numbers of a frame's line.
static const struct {
    const char *name, *unit;
    double min, max;
} NUMBERS[] = {{"the eye's x", "metres", -MAPS_LIMIT, MAPS_LIMIT},
               {"the eye's y", "metres", -MAPS_LIMIT, MAPS_LIMIT},
               {"the eye's z", "metres", -MAPS_LIMIT, MAPS_LIMIT},
               {"the yaw", "radians", -GREATEST_YAW, GREATEST_YAW},
               {"the pitch", "radians", -M_PI / 2, M_PI / 2},
               {"the field of view", "radians", NARROWEST_FOV, WIDEST_FOV}};
enum { NUMBER_COUNT = sizeof NUMBERS / sizeof *NUMBERS };

static void frame_numbers(const TourFrame *f, double out[NUMBER_COUNT]) {
    const double numbers[NUMBER_COUNT] = {f->eye.x, f->eye.y, f->eye.z, f->yaw, f->pitch, f->fov};
    memcpy(out, numbers, sizeof numbers);
}

static TourFrame frame_of(const double n[NUMBER_COUNT]) {
    return (TourFrame){.eye = {n[0], n[1], n[2]}, .yaw = n[3], .pitch = n[4], .fov = n[5]};
}

// Are two numbers equal bit for bit? -0 is not 0.
static bool same_bits(double a, double b) { return memcmp(&a, &b, sizeof a) == 0; }

// ---- in memory

Recording *recording_new(const Building *building, Arena *arena) {
    Recording *r = ARENA_ARRAY(arena, Recording, 1);
    const char *source = building->source ? building->source : "", *slash = strrchr(source, '/');
    *r = (Recording){.arena = arena,
                     .building = arena_string(arena, slash ? slash + 1 : source),
                     .hash = building->hash,
                     .opening_count = building->opening_count,
                     .door_open = ARENA_ARRAY(arena, float, building->opening_count)};
    return r;
}

static void add_door(Recording *r, int opening, float open) {
    int at = r->door_count;
    (void)ARENA_PUSH(r->arena, r->doors, r->door_count, r->door_capacity);
    r->doors[at].frame = r->frame_count;
    r->doors[at].opening = opening;
    r->doors[at].open = open;
    r->door_open[opening] = open;
}

static void add_frame(Recording *r, const TourFrame *frame) {
    *ARENA_PUSH(r->arena, r->frames, r->frame_count, r->frame_capacity) = *frame;
}

static bool allowed(const Recording *r, const TourFrame *frame, const float *door_open) {
    double n[NUMBER_COUNT];
    frame_numbers(frame, n);
    bool good = r->frame_count < RECORDING_LONGEST;
    for (int i = 0; i < NUMBER_COUNT; i++) good = good && n[i] >= NUMBERS[i].min && n[i] <= NUMBERS[i].max;
    for (int i = 0; i < r->opening_count; i++) good = good && door_open[i] >= 0 && door_open[i] <= 1;
    return good;
}

bool recording_add(Recording *r, const TourFrame *frame, const float *door_open) {
    if (!allowed(r, frame, door_open)) return false;
    for (int i = 0; i < r->opening_count; i++) {
        if (door_open[i] != r->door_open[i]) add_door(r, i, door_open[i]);
    }
    add_frame(r, frame);
    return true;
}

// The index of the first change of a door in this frame or later.
static int first_door(const Recording *r, int frame) {
    int low = 0, high = r->door_count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (r->doors[middle].frame < frame) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

void recording_doors(const Recording *r, int frame, float *door_open) {
    for (int i = 0; frame == 0 && i < r->opening_count; i++) door_open[i] = 0;
    for (int i = first_door(r, frame); i < r->door_count && r->doors[i].frame == frame; i++)
        door_open[r->doors[i].opening] = r->doors[i].open;
}

// ---- writing

// The shortest decimal that reads back to the same bits.
static void append_number(Text *text, double value) {
    char word[40];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(word, sizeof word, "%.*g", digits, value);
        if (same_bits(strtod(word, NULL), value)) break;
    }
    text_append(text, "%s", word);
}

static void append_frame(Text *text, const TourFrame *frame, const TourFrame *before) {
    double now[NUMBER_COUNT], old[NUMBER_COUNT];
    frame_numbers(frame, now);
    if (before) frame_numbers(before, old);
    for (int i = 0; i < NUMBER_COUNT; i++) {
        if (i > 0) text_append(text, " ");
        if (before && same_bits(now[i], old[i])) {
            text_append(text, "-");
        } else {
            append_number(text, now[i]);
        }
    }
    text_append(text, "\n");
}

static bool frames_equal(const TourFrame *a, const TourFrame *b) {
    double x[NUMBER_COUNT], y[NUMBER_COUNT];
    frame_numbers(a, x);
    frame_numbers(b, y);
    return memcmp(x, y, sizeof x) == 0;
}

// How many frames from this one on change nothing.
static int still_frames(const Recording *r, int frame, int next_door) {
    int end = next_door < r->door_count ? r->doors[next_door].frame : r->frame_count, i = frame;
    while (i < end && frames_equal(&r->frames[i], &r->frames[frame - 1])) i++;
    return i - frame;
}

static void append_header(Text *text, const Recording *r) {
    text_append(text, "enfilade path 1\nbuilding \"");
    // The name is only informative: `_` replaces each character that would end its quotes or its line.
    for (const unsigned char *c = (const unsigned char *)r->building; *c; c++)
        text_append(text, "%c", *c < ' ' || *c == 127 || *c == '"' ? '_' : *c);
    text_append(text, "\" %016llx\nticks %d\n", (unsigned long long)r->hash, RECORDING_TICKS);
}

bool recording_save(const Recording *r, const char *path, Error *error) {
    if (r->frame_count == 0) return error_set(error, "%s: is not written: nothing was recorded", path);
    Arena scratch = {0};
    Text text = {.arena = &scratch};
    append_header(&text, r);
    int door = 0;
    for (int i = 0; i < r->frame_count; i++) {
        int still = i > 0 ? still_frames(r, i, door) : 0;
        if (still > 0) {
            text_append(&text, "= %d\n", still);
            i += still - 1;
            continue;
        }
        // Nine digits are enough for a float.
        for (; door < r->door_count && r->doors[door].frame == i; door++)
            text_append(&text, "door %d %.9g\n", r->doors[door].opening, (double)r->doors[door].open);
        append_frame(&text, &r->frames[i], i > 0 ? &r->frames[i - 1] : NULL);
    }
    bool good = file_write(path, text.data, text.size, error);
    arena_free(&scratch);
    return good;
}

// ---- reading

typedef struct Reading {
    PlanLine line;
    const Building *building;
    Recording *recording;
    int header;     // lines of the header read so far
    int last_door;  // the last door read since the last frame, or -1
} Reading;

static bool take_word(PlanLine *line, const char *word) {
    if (!plan_is(line, word)) return false;
    line->next++;
    return true;
}

static bool read_first_line(PlanLine *line) {
    if (!take_word(line, "enfilade") || !take_word(line, "path"))
        return plan_fail(line, "is not a recorded path (allowed: `enfilade path 1`)");
    int version;
    return plan_whole(line, "the version", 1, 1, &version) && plan_end(line);
}

static bool read_building(Reading *reading) {
    PlanLine *line = &reading->line;
    if (!take_word(line, "building"))
        return plan_fail(line, "no building (allowed: `building \"NAME\" HASH`)");
    const char *name, *word;
    if (!plan_name(line, "the building's name", &name) || !plan_name(line, "its hash", &word)) return false;
    char *end;
    unsigned long long hash = strtoull(word, &end, 16);
    if (strlen(word) != 16 || strspn(word, "0123456789abcdef") != 16)
        return plan_fail(line, "the hash is '%.60s' (allowed: 16 hexadecimal digits)", word);
    if (hash != reading->building->hash)
        return plan_fail(
            line, "was recorded in \"%.200s\" with hash %016llx; this is %.200s with hash %016llx", name,
            hash, reading->recording->building, (unsigned long long)reading->building->hash);
    return plan_end(line);
}

static bool read_ticks(PlanLine *line) {
    int ticks;
    if (!take_word(line, "ticks")) return plan_fail(line, "no ticks (allowed: `ticks %d`)", RECORDING_TICKS);
    return plan_whole(line, "ticks in a second", RECORDING_TICKS, RECORDING_TICKS, &ticks) && plan_end(line);
}

static bool read_header(Reading *reading) {
    switch (reading->header++) {
    case 0:
        return read_first_line(&reading->line);
    case 1:
        return read_building(reading);
    default:
        return read_ticks(&reading->line);
    }
}

static bool read_door(Reading *reading) {
    PlanLine *line = &reading->line;
    Recording *r = reading->recording;
    int opening;
    double open;
    // Doors come in order, so that each comes at most once before a frame, and a file has at most as many door lines as its frames
    // have doors.
    if (reading->last_door + 1 >= r->opening_count)
        return plan_fail(line, "too many doors (allowed: each of %d once before a frame, in order)",
                         r->opening_count);
    if (!plan_whole(line, "the door", reading->last_door + 1, r->opening_count - 1, &opening) ||
        !plan_number(line, "its share", 0, 1, "", &open) || !plan_end(line))
        return false;
    reading->last_door = opening;
    if ((float)open != r->door_open[opening]) add_door(r, opening, (float)open);
    return true;
}

static bool has_room(const Reading *reading, int frames) {
    if (frames <= RECORDING_LONGEST - reading->recording->frame_count) return true;
    return plan_fail(&reading->line, "the path is too long (allowed: %d frames)", RECORDING_LONGEST);
}

static bool read_still(Reading *reading) {
    PlanLine *line = &reading->line;
    Recording *r = reading->recording;
    int frames;
    if (r->frame_count == 0) return plan_fail(line, "nothing to repeat (allowed: = after a frame)");
    if (reading->last_door >= 0) return plan_fail(line, "a door before = (allowed: a frame after the doors)");
    if (!plan_whole(line, "the count", 1, RECORDING_LONGEST, &frames) || !plan_end(line)) return false;
    if (!has_room(reading, frames)) return false;
    TourFrame last = r->frames[r->frame_count - 1];
    for (int i = 0; i < frames; i++) add_frame(r, &last);
    return true;
}

static bool read_frame(Reading *reading) {
    PlanLine *line = &reading->line;
    Recording *r = reading->recording;
    double n[NUMBER_COUNT];
    if (r->frame_count > 0) frame_numbers(&r->frames[r->frame_count - 1], n);
    for (int i = 0; i < NUMBER_COUNT; i++) {
        if (r->frame_count > 0 && take_word(line, "-")) continue;
        if (!plan_number(line, NUMBERS[i].name, NUMBERS[i].min, NUMBERS[i].max, NUMBERS[i].unit, &n[i]))
            return false;
    }
    if (!plan_end(line) || !has_room(reading, 1)) return false;
    TourFrame frame = frame_of(n);
    add_frame(r, &frame);
    reading->last_door = -1;
    return true;
}

static bool read_line(Reading *reading, char *text) {
    PlanLine *line = &reading->line;
    if (!plan_split(line, text)) return false;
    if (line->count == 0) return true;
    if (reading->header < 3) return read_header(reading);
    if (take_word(line, "door")) return read_door(reading);
    if (take_word(line, "=")) return read_still(reading);
    return read_frame(reading);
}

// Memory for the words of the lines comes from the arena of reading->line.
static bool read_lines(Reading *reading, Bytes bytes) {
    char *text = (char *)bytes.data, *end = text + bytes.size;
    while (text < end) {
        char *stop = memchr(text, '\n', (size_t)(end - text));
        if (!stop) stop = end;
        reading->line.number++;
        if (memchr(text, 0, (size_t)(stop - text)))
            return plan_fail(&reading->line, "a zero byte (allowed: text)");
        *stop = 0;
        if (!read_line(reading, text)) return false;
        text = stop + 1;
    }
    PlanLine *line = &reading->line;
    if (reading->header < 3) return plan_fail(line, "ends in its header (allowed: three lines of header)");
    if (reading->recording->frame_count == 0)
        return plan_fail(line, "ends without a frame (allowed: at least one)");
    return reading->last_door < 0 || plan_fail(line, "ends after a door (allowed: a frame after the doors)");
}

Recording *recording_read(const char *path, Bytes bytes, const Building *building, Arena *arena,
                          Error *error) {
    Arena scratch = {0};
    Reading reading = {.line = {.path = path, .arena = &scratch, .error = error},
                       .building = building,
                       .recording = recording_new(building, arena),
                       .last_door = -1};
    bool good = read_lines(&reading, bytes);
    arena_free(&scratch);
    return good ? reading.recording : NULL;
}

Recording *recording_load(const char *path, const Building *building, Arena *arena, Error *error) {
    Arena scratch = {0};
    Bytes bytes;
    bool good = file_read(path, LARGEST_FILE, &scratch, &bytes, error);
    Recording *r = good ? recording_read(path, bytes, building, arena, error) : NULL;
    arena_free(&scratch);
    return r;
}
