// session_light.c - light in a walk: it arrives from a bake in the background, the exposure adapts to it, keys correct the exposure, and
// false colours show the light in numbers.
#include "engine/walk/session_state.h"

// A frame copies so many bytes of the arriving light: a tenth of a millisecond.
static const size_t SLICE = 512 << 10;
static const double STOP = 0.5;

// ---- arrival

static void tell_end(Session *s) {
    Shown *shown = s->shown;
    int end = light_thread_end(shown->baking);
    if (end == LIGHT_UNDER_WAY || shown->told) return;
    shown->told = true;
    const char *note = light_thread_note(shown->baking);
    if (*note) {
        session_say(s, true, "%s", note);
        s->failed = s->ended = end == LIGHT_FAILED && shown->scene.baker.asked;
    } else if (end == LIGHT_READY && !shown->scene.baker.stored)
        session_say(s, false,
                    shown->scene.baker.keeps ? "all light has arrived, and is kept for the next walk"
                                             : "all light has arrived; there is no cache to keep it in");
}

void session_receive_light(Session *s) {
    Shown *shown = s->shown;
    WalkRenderer *renderer = shown->renderer;
    if (!shown->baking) return;
    const LitLight *light = walk_renderer_fading(renderer) ? NULL : light_thread_light(shown->baking);
    LitMesh *mesh = light_thread_mesh(shown->baking);
    if (mesh && (light || !walk_renderer_mesh(renderer))) walk_renderer_expect(renderer, mesh, &shown->arena);
    bool first = !walk_renderer_lit(renderer);
    if (light && walk_renderer_take(renderer, light, SLICE)) {
        light_thread_received(shown->baking);
        if (first && !s->look_chosen) s->look = WALK_BAKED;
    }
    tell_end(s);
}

bool session_light_shown(const Session *s) {
    return s->look == WALK_BAKED && walk_renderer_lit(s->shown->renderer);
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

const char *session_light_text(const Session *s, Arena *arena) {
    const char *arriving = "";
    if (session_light_arriving(s)) arriving = arena_format(arena, "%.0f %%, ", 100 * session_light_done(s));
    if (!session_light_shown(s))
        return *arriving ? arena_format(arena, "%sto come", arriving) : "as sketched";
    return arena_format(arena, "%s%+.1f stops%s", arriving, s->exposure.stops,
                        s->exposure.fixed ? ", fixed" : "");
}

bool session_legend(const Session *s, HudLegend *out) {
    if (!session_light_shown(s) || s->false_colour == FALSE_COLOUR_OFF) return false;
    *out = (HudLegend){s->false_colour, walk_renderer_lit(s->shown->renderer)->ranges[s->false_colour]};
    return true;
}
