// session_files.c - the files that a walk writes: pictures, recorded paths, a trace.
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/draw/image.h"
#include "engine/walk/session_state.h"

// The time between two lines of a trace, seconds.
static const double TRACE_PERIOD = 0.1;

// The next name of this kind that no file has yet.
static const char *free_name(Session *s, const char *format, int *written) {
    char *path;
    do {
        arena_reset(&s->frame_arena);
        char *name = arena_format(&s->frame_arena, format, ++*written);
        path = arena_format(&s->frame_arena, "%s/%s", s->options.pictures, name);
    } while (access(path, F_OK) == 0);
    return path;
}

// ---- pictures

void session_take_picture(Session *s) { s->picture_wanted = true; }

void session_write_picture(Session *s, int width, int height) {
    Error error;
    s->picture_wanted = false;
    const char *path = free_name(s, "enfilade-%04d.png", &s->pictures);
    uint8_t *rgb = arena_alloc(&s->frame_arena, (size_t)width * (size_t)height, 3);
    bool good = file_make_folder(s->options.pictures, &error) && session_read(s, rgb, &error) &&
                image_write_png(path, rgb, width, height, &error);
    session_say(s, !good, "%s", good ? path : error.text);
}

// ---- recorded paths

#define PATH_NAME "enfilade-%04d.path"

void session_record(Session *s) {
    const CellGraph *graph = s->shown->scene.graph;
    if (!s->recording) {
        // The folder and the name are checked before a walk that would be lost, not after it.
        Error error;
        int next = s->paths;
        if (!file_make_folder(s->options.pictures, &error) ||
            !file_check(free_name(s, PATH_NAME, &next), 0, &error)) {
            session_say(s, true, "%s", error.text);
            return;
        }
        arena_reset(&s->recording_arena);
        s->recording = recording_new(graph->building, &s->recording_arena);
        session_say(s, false, "recording; R ends it");
        return;
    }
    Error error;
    const char *path = free_name(s, PATH_NAME, &s->paths);
    bool good = file_make_folder(s->options.pictures, &error) && recording_save(s->recording, path, &error);
    s->recording = NULL;
    session_say(s, !good, "%s", good ? path : error.text);
    if (!good) return;
    snprintf(s->last_path, sizeof s->last_path, "%s", path);
}

bool session_keep_recording(Session *s, Error *error) {
    if (!s->recording) return true;
    session_record(s);
    return !s->message_is_error || error_set(error, "%s", s->message);
}

void session_record_tick(Session *s) {
    if (!s->recording || s->tick % SESSION_TICKS_KEPT != 0) return;
    const Person *p = &s->person;
    TourFrame now = {p->eye, p->yaw, p->pitch, s->fov};
    if (recording_add(s->recording, &now, s->shown->doors.open)) return;
    session_record(s);
    session_say(s, true, "a path can be no longer: it ends here, as %s", s->last_path);
}

bool session_follow(Session *s, const char *path, Error *error) {
    arena_reset(&s->replay_arena);
    s->replay = recording_load(path, s->shown->scene.graph->building, &s->replay_arena, error);
    s->replay_next = 0;
    return s->replay != NULL;
}

void session_replay(Session *s) {
    Error error;
    if (s->replay) {
        session_stop_replay(s);
        session_say(s, false, "replay ended");
    } else if (!*s->last_path) {
        session_say(s, false, "nothing was recorded yet: R records");
    } else if (session_follow(s, s->last_path, &error)) {
        session_say(s, false, "replaying %s", s->last_path);
    } else {
        session_say(s, true, "%s", error.text);
    }
}

// The person walks on from where the path led. Doors stay as they stand: where they were moving to is forgotten.
void session_stop_replay(Session *s) {
    if (!s->replay) return;
    Doors *doors = &s->shown->doors;
    for (int i = 0; i < doors->graph->building->opening_count; i++) doors_set(doors, i, doors->open[i]);
    session_stand(s, s->person.eye, s->person.yaw, s->person.pitch);
}

bool session_replay_tick(Session *s) {
    if (!s->replay) return false;
    if (s->tick % SESSION_TICKS_KEPT != 0) return true;
    if (s->replay_next == s->replay->frame_count) {
        session_stop_replay(s);
        session_say(s, false, "the path ends here");
        return false;
    }
    const TourFrame *at = &s->replay->frames[s->replay_next];
    recording_doors(s->replay, s->replay_next++, s->shown->doors.open);
    s->person.eye = at->eye;
    s->person.yaw = at->yaw;
    s->person.pitch = at->pitch;
    s->fov = at->fov;
    s->person.cell = vis_locate(s->shown->scene.graph, at->eye, s->person.cell);
    return true;
}

// ---- the trace

static json_t *trace_doors(const Session *s) {
    const Building *b = s->shown->scene.graph->building;
    json_t *doors = json_object();
    for (int i = 0; i < b->opening_count; i++) {
        if (b->openings[i].leaf_count == 0) continue;
        json_object_set_new(doors, b->openings[i].name, json_real((double)s->shown->doors.open[i]));
    }
    return doors;
}

static json_t *trace_light(const Session *s) {
    int count, dark = session_dark_lamps(s, &count);
    return json_pack("{s:b, s:f, s:f, s:f, s:b, s:s, s:i, s:i, s:b, s:b, s:s, s:b}", "shown",
                     (int)session_light_shown(s), "done", session_light_done(s), "exposure",
                     exposure_scale(&s->exposure), "stops", s->exposure.stops, "fixed",
                     (int)s->exposure.fixed, "false_colour", FALSE_COLOUR_NAMES[s->false_colour], "lamps",
                     count, "lamps_off", dark, "lamps_known",
                     s->shown->baking && light_thread_lamps(s->shown->baking) == LAMPS_KNOWN, "behind",
                     s->shown->baking && light_thread_behind(s->shown->baking), "hour", s->hour, "coming",
                     (int)(session_coming_done(s) >= 0));
}

// The times from the end of one frame to the end of the next, ms, of all frames since the last line.
static json_t *trace_periods(Session *s) {
    json_t *periods = json_array();
    for (int i = 0; i < s->period_count; i++) json_array_append_new(periods, json_real(s->periods[i]));
    s->period_count = 0;
    return periods;
}

bool session_open_trace(Session *s, Error *error) {
    const char *path = s->options.trace;
    if (!path) return true;
    s->trace = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, 0666);
    return s->trace >= 0 || error_set(error, "%s: cannot be written: %s", path, strerror(errno));
}

// Writes a line in one piece: readers find whole lines, even while it is written and after this program was killed.
static void write_line(Session *s, const json_t *line) {
    Arena scratch = {0};
    size_t size = json_dumpb(line, NULL, 0, JSON_COMPACT);
    char *text = arena_alloc(&scratch, size + 1, 1);
    json_dumpb(line, text, size, JSON_COMPACT);
    text[size++] = '\n';
    if (write(s->trace, text, size) != (ssize_t)size) {
        session_say(s, true, "%s: cannot be written: %s; the trace ends", s->options.trace, strerror(errno));
        close(s->trace);
        s->trace = -1;
    }
    arena_free(&scratch);
}

void session_trace(Session *s) {
    if (s->trace < 0 || s->now < s->trace_due) return;
    s->trace_due = s->now + TRACE_PERIOD;
    const Building *b = s->shown->scene.graph->building;
    const Person *p = &s->person;
    int storey = session_storey(s), door = session_door(s);
    json_t *flags = json_array();
    const char *names[SESSION_FLAGS];
    int count = session_flags(s, names);
    for (int i = 0; i < count; i++) json_array_append_new(flags, json_string(names[i]));
    Arena scratch = {0};
    const char *prompt = door < 0 ? "" : session_door_prompt(s, door, &scratch);
    json_t *line =
        json_pack("{s:f, s:[f,f,f], s:f, s:f, s:i, s:s, s:s, s:f, s:f, s:o, s:i, s:i, s:s, s:o, s:o, s:s, "
                  "s:s, s:o, s:i, s:s, s:b}",
                  "t", s->now, "eye", p->eye.x, p->eye.y, p->eye.z, "yaw", p->yaw, "pitch", p->pitch, "cell",
                  p->cell, "room", session_room(s), "storey", storey < 0 ? "" : b->storeys[storey].name,
                  "fps", s->frames_per_second, "frame_ms", s->frame_ms, "periods_ms", trace_periods(s),
                  "cells_visible", s->visible.cell_count, "polygons_drawn", s->visible.polygon_count, "door",
                  door < 0 ? "" : b->openings[door].name, "doors", trace_doors(s), "flags", flags, "message",
                  s->message, "look", WALK_LOOK_NAMES[s->look], "light", trace_light(s), "frames",
                  (int)s->frames, "prompt", prompt, "hint", (int)(session_hint_opacity(s) > 0));
    write_line(s, line);
    json_decref(line);
    arena_free(&scratch);
}
