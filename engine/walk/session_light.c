// session_light.c - light in a walk: it arrives from a bake in the background, the exposure adapts to it, keys correct the exposure, and
// false colours show the light in numbers.
#include <stdio.h>
#include <string.h>

#include "engine/scene/lamp_state.h"
#include "engine/walk/session_state.h"

// A frame copies so many bytes of the arriving light: a tenth of a millisecond. Once all light is there, what follows lamps and doors is
// waited for, and comes in a frame or two.
static const size_t SLICE = 512 << 10, SLICE_AWAITED = 4 << 20;
static const double STOP = 0.5;

// ---- arrival

static void tell_end(Session *s) {
    Shown *shown = s->shown;
    int end = light_thread_end(shown->baking);
    if (end == shown->told) return;
    shown->told = end;
    const char *note = light_thread_note(shown->baking);
    if (*note) {
        session_say(s, true, "%s", note);
        s->failed = s->ended = end == LIGHT_FAILED && shown->scene.baker.asked;
    } else if (end == LIGHT_READY && !shown->scene.baker.stored)
        session_say(s, false,
                    shown->scene.baker.keeps ? "all light has arrived, and is kept for the next walk"
                                             : "all light has arrived; there is no cache to keep it in");
}

void session_ask_light(Shown *shown) {
    const Building *b = shown->scene.graph->building;
    light_thread_ask(shown->baking, shown->lit, shown->scene.scene->lamps.count,
                     shown->doors_moved ? shown->asked_open : NULL, b->opening_count,
                     shown->turning ? &shown->turning_day : NULL);
}

// Where a door stands, or will stand once it has moved: so its light is there the sooner.
static float stands(const Session *s, int opening) {
    const Doors *doors = &s->shown->doors;
    return !s->replay && doors->halt[opening] == DOOR_FREE ? doors->wanted[opening] : doors->open[opening];
}

// Asks for the light of the doors when one of them begins to move, or is stopped on its way.
static void follow_doors(Session *s) {
    Shown *shown = s->shown;
    bool moved = false;
    if (!shown->scene.scene || !session_light_shown(s) || light_thread_end(shown->baking) != LIGHT_READY ||
        !light_thread_switches(shown->baking))
        return;
    for (int i = 0; i < shown->scene.graph->building->opening_count; i++) {
        float now = stands(s, i);
        moved = moved || now != shown->asked_open[i];
        shown->asked_open[i] = now;
    }
    if (!moved) return;
    if (!shown->doors_moved && shown->scene.baker.anew)
        session_say(s, false, "light follows the doors once it is baked anew, which takes a while");
    shown->doors_moved = true;
    session_ask_light(shown);
}

void shown_receive_light(Shown *shown, size_t bytes) {
    WalkRenderer *renderer = shown->renderer;
    const LitLight *light = walk_renderer_fading(renderer) ? NULL : light_thread_light(shown->baking);
    LitMesh *mesh = light_thread_mesh(shown->baking);
    if (mesh && (light || !walk_renderer_mesh(renderer))) walk_renderer_expect(renderer, mesh);
    if (light && walk_renderer_take(renderer, light, bytes)) light_thread_received(shown->baking);
}

// ---- light in parts

// Light of another part is read when its nearest cell in view is not farther away than this, metres: some seconds on foot.
static const double AHEAD = 12;

static double away_from(Box box, Vec3 from) {
    Vec3 off = vec3(fmax(fmax(box.min.x - from.x, from.x - box.max.x), 0),
                    fmax(fmax(box.min.y - from.y, from.y - box.max.y), 0),
                    fmax(fmax(box.min.z - from.z, from.z - box.max.z), 0));
    return vec3_length(off);
}

// The part, other than that of the eye, of the nearest cell that may be seen from the eye's; -1: all are far.
static int part_ahead(const Session *s, const LightOfParts *parts, int cell) {
    const WalkScene *scene = &s->shown->scene;
    const CellRows *seen = &scene->forest->seen;
    Arena scratch = {0};
    int *list = ARENA_ARRAY(&scratch, int, cell_rows_size(seen, cell) + 1), best = -1;
    int count = cell_rows_list(seen, cell, list), own = light_part_of(parts, cell);
    double nearest = AHEAD;
    for (int i = 0; i < count; i++) {
        int part = light_part_of(parts, list[i]);
        double distance = part == own ? INFINITY : away_from(scene->graph->cells[list[i]].box, s->person.eye);
        if (distance >= nearest) continue;
        nearest = distance;
        best = part;
    }
    arena_free(&scratch);
    return best;
}

// Asks for the part of the eye's cell, or where that is shown for the next one.
static void ask_part(Session *s, int here) {
    Shown *shown = s->shown;
    int cell = s->person.cell, wanted = here, waits = light_thread_part(shown->baking);
    if (here < 0) return;
    if (here == shown->part) {
        if (cell != shown->ahead_cell) shown->ahead = part_ahead(s, shown->scene.baker.parts, cell);
        shown->ahead_cell = cell;
        if (shown->ahead >= 0) wanted = shown->ahead;
    }
    if (waits >= 0 && waits != wanted) {
        walk_renderer_drop(shown->renderer);
        shown->prepared = -1;
    }
    light_thread_ask_part(shown->baking, wanted);
}

// The part of the eye's cell is shown once it is there. While it is, the next one is read and uploaded ahead.
static void receive_part(Session *s) {
    Shown *shown = s->shown;
    LightThread *thread = shown->baking;
    int here = light_part_of(shown->scene.baker.parts, s->person.cell);
    ask_part(s, here);
    int part = light_thread_part(thread);
    const LitLight *light = walk_renderer_fading(shown->renderer) ? NULL : light_thread_light(thread);
    if (part < 0 || !light) return;
    walk_renderer_expect(shown->renderer, light_thread_mesh(thread));
    if (!walk_renderer_prepare(shown->renderer, light, SLICE_AWAITED)) return;
    shown->prepared = part;
    if (part != here) return;
    walk_renderer_take(shown->renderer, light, 0);
    light_thread_received(thread);
    shown->part = part;
    shown->prepared = -1;
    ask_part(s, here);
}

// Is there light on all that is seen from the eye?
static bool covered(const Session *s) {
    const LightOfParts *parts = s->shown->scene.baker.parts;
    return !parts || light_part_of(parts, s->person.cell) == s->shown->part;
}

bool session_light_waits(const Session *s) {
    const Shown *shown = s->shown;
    const LightOfParts *parts = shown->scene.baker.parts;
    return light_thread_light(shown->baking) &&
           (!parts || light_thread_part(shown->baking) != shown->prepared ||
            light_thread_part(shown->baking) == light_part_of(parts, s->person.cell));
}

WalkLook session_drawn_look(const Session *s) {
    return s->look == WALK_BAKED && !covered(s) ? s->sketched : s->look;
}

void session_receive_light(Session *s) {
    Shown *shown = s->shown;
    if (!shown->baking) return;
    bool dark = !walk_renderer_lit(shown->renderer);
    if (shown->scene.baker.parts)
        receive_part(s);
    else
        shown_receive_light(shown, light_thread_end(shown->baking) == LIGHT_READY ? SLICE_AWAITED : SLICE);
    if (dark && walk_renderer_lit(shown->renderer) && !s->look_chosen) s->look = WALK_BAKED;
    tell_end(s);
    follow_doors(s);
}

bool session_light_shown(const Session *s) {
    return s->look == WALK_BAKED && walk_renderer_lit(s->shown->renderer) && covered(s);
}

// ---- exposure

void session_expose(Session *s, const Camera *camera) {
    WalkRenderer *renderer = s->shown->renderer;
    const LitLight *light = walk_renderer_lit(renderer);
    double passed = s->drawn_at > 0 ? fmax(s->now - s->drawn_at, 0) : 0;
    s->drawn_at = s->now;
    walk_renderer_fade(renderer, passed);
    s->adapting = false;
    if (session_light_shown(s)) {
        double seen = exposure_meter(walk_renderer_mesh(renderer), light, camera, s->visible.objects,
                                     s->visible.object_count);
        s->adapting = exposure_adapt(&s->exposure, seen, light->level, passed);
    }
    walk_renderer_plain(renderer, s->sketched == WALK_FAST);
    walk_renderer_tone(renderer, exposure_scale(&s->exposure), s->false_colour);
}

static bool needs_light(Session *s) {
    if (session_light_shown(s)) return true;
    session_say(s, false,
                walk_renderer_lit(s->shown->renderer) ? "only the look `baked` has light by radiosity: G"
                                                      : "there is no light by radiosity yet");
    return false;
}

void session_brighten(Session *s, int by) {
    if (!needs_light(s)) return;
    s->exposure.stops = fmin(fmax(s->exposure.stops + by * STOP, -EXPOSURE_STOPS_MOST), EXPOSURE_STOPS_MOST);
    session_say(s, false, "exposure: %+.1f stops", s->exposure.stops);
}

void session_fix_exposure(Session *s) {
    if (!needs_light(s)) return;
    s->exposure.fixed = !s->exposure.fixed;
    session_say(s, false, s->exposure.fixed ? "exposure stays as it is" : "exposure adapts to what is seen");
}

void session_change_colours(Session *s) {
    if (!needs_light(s)) return;
    s->false_colour = (FalseColour)((s->false_colour + 1) % FALSE_COLOURS);
    session_say(s, false, "false colours: %s", FALSE_COLOUR_NAMES[s->false_colour]);
}

// ---- reports of the light

double session_light_done(const Session *s) {
    if (s->shown->baking && light_thread_end(s->shown->baking) == LIGHT_UNDER_WAY)
        return light_thread_done(s->shown->baking);
    return walk_renderer_lit(s->shown->renderer) ? 1 : 0;
}

// Is the light that is shown that of the doors and lamps as they are now?
static const char *text_behind(const Session *s, Arena *arena) {
    const LightThread *baking = s->shown->baking;
    if (!baking || light_thread_end(baking) != LIGHT_READY || !light_thread_behind(baking)) return "";
    if (light_thread_lamps(baking) == LAMPS_KNOWN) return ", behind the doors and lamps";
    return arena_format(arena, ", behind the doors and lamps until it is baked anew: %.0f %%",
                        100 * light_thread_lamps_done(baking));
}

const char *session_light_text(const Session *s, Arena *arena) {
    const char *arriving = "";
    double coming = session_coming_done(s);
    if (coming >= 0) return arena_format(arena, "%.0f %% of %s", 100 * coming, s->hour);
    if (session_light_arriving(s)) arriving = arena_format(arena, "%.0f %%, ", 100 * session_light_done(s));
    if (!session_light_shown(s))
        return *arriving ? arena_format(arena, "%sto come", arriving) : "as sketched";
    return arena_format(arena, "%s%+.1f stops%s%s", arriving, s->exposure.stops,
                        s->exposure.fixed ? ", fixed" : "", text_behind(s, arena));
}

bool session_legend(const Session *s, HudLegend *out) {
    if (!session_light_shown(s) || s->false_colour == FALSE_COLOUR_OFF) return false;
    *out = (HudLegend){s->false_colour, walk_renderer_lit(s->shown->renderer)->ranges[s->false_colour]};
    return true;
}

// ---- lamps

// A lamp is looked at where the line of sight passes it within this distance, metres, no farther away than that.
static const double LAMP_NEAR = 0.35, LAMP_FAR = 12;
static const float TENTH = 0.1f;
// Lines of the list.
enum { LIST_LINES = 16 };

static const Lamps *lamps_of(const Session *s) {
    static const Lamps NONE = {0};
    return s->shown->scene.scene ? &s->shown->scene.scene->lamps : &NONE;
}

static bool can_switch(const Session *s) {
    const Shown *shown = s->shown;
    return shown->baking && shown->lit && lamps_of(s)->count > 0 && light_thread_switches(shown->baking);
}

static bool is_visible(const Session *s, int object) {
    for (int i = 0; i < s->visible.object_count; i++)
        if (s->visible.objects[i] == object) return true;
    return false;
}

int session_lamp(const Session *s) {
    const Person *p = &s->person;
    const Lamps *lamps = lamps_of(s);
    Vec3 ahead = vec3(cos(p->pitch) * cos(p->yaw), cos(p->pitch) * sin(p->yaw), sin(p->pitch));
    int nearest = -1;
    double least = LAMP_NEAR;
    if (!session_light_shown(s) || !can_switch(s)) return -1;
    for (int i = 0; i < lamps->count; i++) {
        Vec3 way = vec3_sub(lamps->lamps[i].place, p->eye);
        double along = vec3_dot(way, ahead);
        if (along <= 0 || along > LAMP_FAR) continue;
        double off = vec3_length(vec3_sub(way, vec3_scale(ahead, along)));
        if (off >= least || !is_visible(s, lamps->lamps[i].object)) continue;
        least = off;
        nearest = i;
    }
    return nearest;
}

static float brightest(Rgb lit) { return fmaxf(fmaxf(lit.r, lit.g), lit.b); }

int session_dark_lamps(const Session *s, int *count) {
    int dark = 0;
    *count = s->shown->lit ? lamps_of(s)->count : 0;
    for (int i = 0; i < *count; i++) dark += !(brightest(s->shown->lit[i]) > 0);
    return dark;
}

const char *session_lamp_prompt(const Session *s, int lamp, Arena *arena) {
    return arena_format(arena, "switch %s %s", brightest(s->shown->lit[lamp]) > 0 ? "off" : "on",
                        lamps_of(s)->lamps[lamp].name);
}

// Is the lamp meant by a key: chosen, looked at, or where there is none of both, in the room?
static bool is_meant(const Session *s, int lamp, int looked_at) {
    if (s->lamps) return lamp == s->lamp_chosen;
    if (looked_at >= 0) return lamp == looked_at;
    const CellGraph *graph = s->shown->scene.graph;
    int region = lamps_of(s)->lamps[lamp].region;
    return region >= 0 && s->person.cell >= 0 && graph->cells[s->person.cell].region == region;
}

// A lamp that was coloured keeps its hue.
static void set_lamp(Session *s, int lamp, float share) {
    const Rgb *asked = &s->shown->scene.scene->lit[lamp];
    float most = brightest(*asked);
    Rgb hue = most > 0 ? (Rgb){asked->r / most, asked->g / most, asked->b / most} : (Rgb){1, 1, 1};
    s->shown->lit[lamp] = (Rgb){hue.r * share, hue.g * share, hue.b * share};
}

static void say_lamps(Session *s, int count, int last, float share) {
    const Lamps *lamps = lamps_of(s);
    char wait[96] = "", state[16];
    if (light_thread_lamps(s->shown->baking) != LAMPS_KNOWN)
        snprintf(wait, sizeof wait, ", once the light of each lamp is known (%.0f %%)",
                 100 * light_thread_lamps_done(s->shown->baking));
    snprintf(state, sizeof state,
             share > 0 && share < 1 ? "%.0f %%"
             : share > 0            ? "on"
                                    : "off",
             100 * (double)share);
    if (count == 1)
        session_say(s, false, "%s: %s%s", lamps->lamps[last].name, state, wait);
    else
        session_say(s, false, "%d lamps of %s: %s%s", count, session_room(s), state, wait);
}

// Lamps that are meant get the share of full light that `next` makes of the brightest one's.
static void change_lamps(Session *s, float (*next)(float share, int by), int by) {
    int looked_at = session_lamp(s), count = 0, last = -1;
    float most = 0;
    if (!needs_light(s)) return;
    if (!can_switch(s)) {
        session_say(s, false,
                    lamps_of(s)->count == 0
                        ? "there are no lamps that could be switched"
                        : "lamps cannot be switched: the light of each is not known (`bake --lamps each`)");
        return;
    }
    for (int i = 0; i < lamps_of(s)->count; i++) {
        if (!is_meant(s, i, looked_at)) continue;
        most = fmaxf(most, brightest(s->shown->lit[i]));
        last = i;
        count++;
    }
    if (count == 0) {
        session_say(s, false, "no lamp is looked at, and there is none in %s (J lists all)", session_room(s));
        return;
    }
    float share = next(most, by);
    for (int i = 0; i < lamps_of(s)->count; i++)
        if (is_meant(s, i, looked_at)) set_lamp(s, i, share);
    session_ask_light(s->shown);
    say_lamps(s, count, last, share);
}

static float switched(float share, int by) {
    (void)by;
    return share > 0 ? 0 : 1;
}

static float dimmed(float share, int by) {
    return fminf(fmaxf(roundf(share / TENTH + (float)by) * TENTH, 0), 1);
}

void session_switch_lamps(Session *s) { change_lamps(s, switched, 0); }
void session_dim_lamps(Session *s, int by) { change_lamps(s, dimmed, by); }

void session_list_lamps(Session *s) {
    s->lamps = !s->lamps && lamps_of(s)->count > 0;
    s->lamp_chosen = s->lamp_chosen < lamps_of(s)->count ? s->lamp_chosen : 0;
    if (lamps_of(s)->count == 0) session_say(s, false, "there are no lamps that could be switched");
}

void session_choose_lamp(Session *s, int by) {
    int count = lamps_of(s)->count;
    if (count > 0) s->lamp_chosen = (s->lamp_chosen + by + count) % count;
}

const HudKey *session_lamp_list(const Session *s, int *count, Arena *arena) {
    const Lamps *lamps = lamps_of(s);
    if (!s->lamps || lamps->count == 0) return NULL;
    int first = s->lamp_chosen - LIST_LINES / 2;
    first = first + LIST_LINES > lamps->count ? lamps->count - LIST_LINES : first;
    first = first < 0 ? 0 : first;
    HudKey *lines = ARENA_ARRAY(arena, HudKey, LIST_LINES);
    *count = 0;
    for (int i = first; i < lamps->count && *count < LIST_LINES; i++) {
        const Lamp *l = &lamps->lamps[i];
        char state[48];
        lamp_state_describe(lamps, i, s->shown->lit[i], state, sizeof state);
        lines[(*count)++] =
            (HudKey){arena_format(arena, "%s%d", i == s->lamp_chosen ? "> " : "", i + 1),
                     arena_format(arena, "%s%s%s: %s", l->name, *l->room ? ", " : "", l->room, state)};
    }
    return lines;
}
