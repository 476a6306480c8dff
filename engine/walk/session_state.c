// session_state.c - reports of a session's state: a sentence, a place, flags, the frame just drawn.
#include "engine/walk/session_state.h"

#include <stdarg.h>
#include <stdio.h>

void session_say(Session *s, bool error, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(s->message, sizeof s->message, format, args);
    va_end(args);
    s->message_is_error = error;
    s->message_since = s->now;
}

// ---- place

const char *session_room(const Session *s) {
    const CellGraph *graph = s->shown->scene.graph;
    const Building *b = graph->building;
    if (s->person.cell < 0) return "in no room";
    const Region *r = vis_region(graph, s->person.cell);
    if (*r->name) return r->name;
    switch (r->kind) {
    case REGION_OUTDOORS:
        return "outdoors";
    case REGION_SHAFT:
        return "stairwell";
    case REGION_OPENING:
        return *b->openings[r->opening].name ? b->openings[r->opening].name : "doorway";
    default:
        return "room";
    }
}

int session_storey(const Session *s) {
    return plan_view_storey(s->shown->scene.graph, s->person.cell, s->person.eye);
}

int session_door(const Session *s) {
    const Person *p = &s->person;
    Vec3 ahead = vec3(cos(p->pitch) * cos(p->yaw), cos(p->pitch) * sin(p->yaw), sin(p->pitch));
    return doors_looked_at(&s->shown->doors, p->eye, p->cell, ahead, DOORS_REACH);
}

// A door that has halted goes on by itself once its way is free.
const char *session_door_prompt(const Session *s, int door, Arena *arena) {
    const Doors *doors = &s->shown->doors;
    const Opening *opening = &s->shown->scene.graph->building->openings[door];
    const char *name = *opening->name ? opening->name : "the door";
    bool opens = doors->wanted[door] >= 0.5f, under_way = doors->open[door] != doors->wanted[door];
    if (under_way && doors->halt[door] == DOOR_MEETS_BODY)
        return arena_format(arena, "step back: %s %s towards you", name, opens ? "opens" : "closes");
    if (under_way && doors->halt[door] == DOOR_MEETS_DOOR)
        return arena_format(arena, "%s waits for the door in its way", name);
    return arena_format(arena, "%s %s", opens ? "close" : "open", name);
}

double session_hint_opacity(const Session *s) {
    if (s->began < 0 || s->help || s->replay) return 0;
    return fmin(fmax(SESSION_HINT_SECONDS - (s->now - s->began), 0), 1);
}

// ---- the frame

bool session_light_arriving(const Session *s) {
    return s->shown->baking && light_thread_end(s->shown->baking) == LIGHT_UNDER_WAY;
}

double session_coming_done(const Session *s) {
    if (s->coming_load) return 0;
    if (!s->coming) return s->shown->turning ? light_thread_turned(s->shown->baking) : -1;
    return s->coming->baking ? light_thread_done(s->coming->baking) : 1;
}

int session_flags(const Session *s, const char **out) {
    int count = 0;
    if (s->frozen) out[count++] = "frozen";
    if (s->culling != CULL_STAB) out[count++] = CULLING_NAMES[s->culling];
    if (s->person.flying) out[count++] = "flight";
    if (s->wireframe) out[count++] = "wireframe";
    if (s->stab_tree) out[count++] = "stab tree";
    if (s->replay) out[count++] = "replay";
    if (session_light_arriving(s)) out[count++] = "light arriving";
    if (s->exposure.fixed) out[count++] = "exposure fixed";
    if (s->false_colour != FALSE_COLOUR_OFF) out[count++] = FALSE_COLOUR_NAMES[s->false_colour];
    return count;
}

bool session_read(Session *s, uint8_t *rgb, Error *error) {
    return walk_renderer_read(s->shown->renderer, rgb, error);
}
