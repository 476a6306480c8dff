// hud.h - the panels that the walkthrough window shows over its picture: figures, help, messages, the plan.
#ifndef WALK_HUD_H
#define WALK_HUD_H

#include "engine/overlay/hud_legend.h"
#include "engine/overlay/plan_view.h"

typedef struct HudKey {
    const char *keys, *action;  // "W A S D", "walk"
} HudKey;

typedef struct HudFigures {
    const char *method;  // of culling
    int cells_visible, cell_count;
    int polygons_drawn, polygon_count;
    double query_us, frame_ms, frames_per_second;
    Vec3 eye;
    const char *room, *storey;  // where the eye is; room "": outdoors, storey NULL: none
    const char *light;          // the state of the light, in words
} HudFigures;

typedef struct HudState {
    const HudFigures *figures;  // NULL: not shown; likewise for the pointers below
    const HudKey *help;
    int help_count;
    const char *const *flags;  // words like "frozen", each shown as a small sign
    int flag_count;
    bool recording;  // a sign in red
    const char *message;
    double message_age;               // seconds
    bool message_is_error;            // stays longer, in red
    const char *prompt_key, *prompt;  // "E", "open salon"
    const HudKey *hint;               // [hint_count] the first keys that a newcomer needs
    int hint_count;
    double hint_opacity;  // 0 .. 1; 0: not shown
    const PlanView *plan;
    const HudLegend *legend;
    bool crosshair;
    Arena *scratch;  // for this frame; the caller resets it
} HudState;

// How long a message is shown, seconds; it fades during the last second.
#define HUD_MESSAGE_SECONDS 4.0
#define HUD_ERROR_SECONDS 12.0
// The opacity of a message after so many seconds, 0 .. 1.
double hud_message_opacity(double age, bool is_error);

// Draws between overlay_begin and overlay_end. Panels that the window has no room for are left out: first the plan, then the legend,
// signs, figures, the hint, and at last the prompt. Help is drawn smaller where the window has too little room for it, and left out only
// where its letters could not be read. Messages lie over everything else.
void hud_draw(Overlay *overlay, const HudState *state);

#endif
