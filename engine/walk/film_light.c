// film_light.c - one state of the light is shown while the next one is found; light that nobody keeps the rows of is baked anew once.
#include "engine/walk/film_light.h"

#include <math.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/gl/gl_context.h"
#include "engine/lit/lit_parts.h"
#include "engine/lit/lit_states.h"

// A door that moves has moved by this share of its way before its light is found again.
static const float STEP = 0.1F;

struct FilmLight {
    FilmLightSource source;
    WalkRenderer *renderer;
    const Building *building;
    Arena *arena;
    WalkLight baked;  // anew, by `source`, in `room`
    Arena room;
    const WalkLight *light;  // that is shown; NULL: none is yet, or that of a part is
    int part;                // of light in parts, -1: none is shown yet
    LitParts *parts;         // NULL: it is not in parts
    int rooms;               // of FilmLightSource that were used
    LitStates *states;       // NULL: the light does not follow
    LitLight state[2];
    int at;        // the state that is shown
    float *shown;  // [opening_count] the doors of that state
    float *last;   // [opening_count] of the last frame
    bool stale;    // the lamps are not as they are shown
    bool stayed;
};

// The first state on a mesh takes the place of that on the mesh before.
static bool upload(FilmLight *f, LitMesh *mesh, Error *error) {
    f->at = 0;
    memcpy(f->shown, f->state[0].doors, (size_t)f->building->opening_count * sizeof *f->shown);
    walk_renderer_expect(f->renderer, mesh);
    walk_renderer_take(f->renderer, &f->state[0], SIZE_MAX);
    walk_renderer_fade(f->renderer, INFINITY);
    return gl_check("uploading the light of a building", error);
}

// Lives in the arena.
static bool show_light(FilmLight *f, const WalkLight *light, Arena *arena, Error *error) {
    LitMesh *mesh = lit_mesh_new(light->mesh, arena, arena);
    f->state[0] = lit_light_new(mesh, arena);
    lit_light_fill(mesh, light->solution, light->door_open, &f->state[0]);
    f->light = light;
    if (light->follower) {
        const Lamps *lamps = light_follower_lamps(light);
        f->state[1] = lit_light_new(mesh, arena);
        f->states = lit_states_new(mesh, light, arena);
        for (int i = 0; i < lamps->count; i++) {
            Rgb lit = f->source.lit[i];
            f->stale = f->stale || lit.r != 1 || lit.g != 1 || lit.b != 1;
        }
    }
    return upload(f, mesh, error);
}

FilmLight *film_light_new(const FilmLightSource *source, WalkRenderer *renderer, Arena *arena, Error *error) {
    FilmLight *f = ARENA_ARRAY(arena, FilmLight, 1);
    *f = (FilmLight){.source = *source,
                     .renderer = renderer,
                     .building = source->parts ? &light_parts_scene(source->parts)->building
                                               : source->light->mesh->graph->building,
                     .part = -1,
                     .arena = arena};
    f->shown = ARENA_ARRAY(arena, float, f->building->opening_count + 1);
    f->last = ARENA_ARRAY(arena, float, f->building->opening_count + 1);
    if (source->parts) {
        f->parts = lit_parts_new(source->parts, arena);
        walk_renderer_reserve(renderer, lit_parts_most_vertices(source->parts), 1);
    }
    return source->parts || show_light(f, source->light, arena, error) ? f : NULL;
}

void film_light_end(FilmLight *f) {
    if (!f) return;
    light_end(&f->baked);
    lit_parts_free(f->parts);
    arena_free(&f->room);
}

LitPartsCount film_light_parts(const FilmLight *f) {
    return f && f->parts ? lit_parts_count(f->parts) : (LitPartsCount){0};
}

bool film_light_stayed(const FilmLight *f) { return f && f->stayed; }

// Is the light of these doors to be found?
static bool is_due(FilmLight *f, const float *door_open) {
    bool due = f->stale;
    for (int i = 0; i < f->building->opening_count; i++) {
        if (f->building->openings[i].kind != OPENING_DOOR) continue;
        bool rests = door_open[i] == f->last[i] || door_open[i] == 0 || door_open[i] == 1;
        float way = fabsf(door_open[i] - f->shown[i]);
        due = due || way >= STEP || (way > 0 && rests);
        f->last[i] = door_open[i];
    }
    return due;
}

// The program goes on without light that follows rather than end for lack of memory.
typedef struct Watch {
    const Progress *progress;
    bool short_of_memory;
} Watch;

static bool note_progress(void *context, const char *stage, double done) {
    Watch *w = context;
    w->short_of_memory = w->short_of_memory || memory_runs_short();
    return !w->short_of_memory && progress_report(w->progress, stage, done);
}

// Light that follows the doors. Where memory is short of it, `room` is empty again.
static bool bake_following(const LightBaker *baker, Watch *watch, Arena *room, WalkLight *out, Error *error) {
    LightHooks hooks = {.progress = {note_progress, watch}, .follow = true};
    bool good = baker->bake(baker->context, &hooks, room, out, error);
    if (!good && watch->short_of_memory) arena_free(room);
    return good;
}

bool film_light_bake(const LightBaker *baker, const Progress *progress, Arena *room, WalkLight *out,
                     Error *error) {
    Watch watch = {progress, false};
    LightHooks hooks = {.progress = *progress};
    if (bake_following(baker, &watch, room, out, error)) return true;
    return watch.short_of_memory && baker->bake(baker->context, &hooks, room, out, error);
}

// Bakes light that follows; false where the walk is to end. It is the light that is shown from then on.
static bool bake_anew(FilmLight *f, const Progress *progress, Error *error) {
    Watch watch = {progress, false};
    const LightBaker *baker = f->source.anew;
    f->source.anew = NULL;
    if (!bake_following(baker, &watch, &f->room, &f->baked, error)) return watch.short_of_memory;
    return show_light(f, &f->baked, f->arena, error);
}

// Room for other light: what is shown lies in the other one.
static Arena *next_room(FilmLight *f) {
    Arena *room = &f->source.room[f->rooms++ % 2];
    arena_free(room);
    return room;
}

bool film_light_come(FilmLight *f, int cell, Error *error) {
    int part = f->source.parts ? light_part_of(f->source.parts, cell) : -1;
    if (part < 0 || part == f->part) return true;
    // No frame is drawn meanwhile, so the part before it may go.
    walk_renderer_darken(f->renderer);
    LitMesh *mesh = lit_parts_get(f->parts, part, -1, &f->state[0], error);
    if (!mesh) return false;
    f->part = part;
    return upload(f, mesh, error);
}

bool film_light_covers(const FilmLight *f, int cell) {
    return f->source.parts ? f->part >= 0 && light_part_of(f->source.parts, cell) == f->part
                           : f->light != NULL;
}

// The hour turns. The renderer holds the light before, which lies in the other room, or was baked.
static bool turn_hour(FilmLight *f, const Daylight *day, const float *door_open, const Progress *progress,
                      Error *error) {
    if (!f->light || !light_turns(f->light))
        return error_set(
            error, "the hour stays as it is: the light that is stored does not follow it (--day bakes anew)");
    Arena *room = next_room(f);
    WalkLight *next = ARENA_ARRAY(room, WalkLight, 1);
    if (!light_turn(f->light, day, door_open, progress, room, next)) return error_set(error, "stopped");
    return show_light(f, next, room, error);
}

bool film_light_follow(FilmLight *f, const float *door_open, const Daylight *day, const Progress *progress,
                       Error *error) {
    if (!f->light && f->part < 0) return true;
    bool turns = day && memcmp(day, &f->state[f->at].day, sizeof *day) != 0;
    if (!turns && !is_due(f, door_open)) return true;
    if (!f->states && f->source.anew && !bake_anew(f, progress, error)) return false;
    if (turns && !turn_hour(f, day, door_open, progress, error)) return false;
    if (!f->states) {
        f->stayed = true;
        return true;
    }
    if (turns && !is_due(f, door_open)) return true;
    f->at = 1 - f->at;
    if (!lit_states_fill(f->states, f->source.lit, door_open, progress, &f->state[f->at]))
        return error_set(error, "stopped");
    walk_renderer_take(f->renderer, &f->state[f->at], SIZE_MAX);
    walk_renderer_fade(f->renderer, INFINITY);
    memcpy(f->shown, door_open, (size_t)f->building->opening_count * sizeof *f->shown);
    f->stale = false;
    return gl_check("uploading the light of a building", error);
}
