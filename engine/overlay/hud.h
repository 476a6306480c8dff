// hud.h - what the walkthrough window shows over its picture: figures, help, messages, the plan.
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
    const char *room, *storey;  // where the eye is; "" and NULL: nowhere
    const char *light;          // what there is of it
} HudFigures;

typedef struct HudState {
    const HudFigures *figures;  // NULL: not shown; so with all below
    const HudKey *help;
    int help_count;
    const char *const *flags;  // words such as "frozen", each a small sign
    int flag_count;
    bool recording;  // a sign in red
    const char *message;
    double message_age;               // seconds
    bool message_is_error;            // stays longer, in red
    const char *prompt_key, *prompt;  // "E", "open salon"
    const PlanView *plan;
    const HudLegend *legend;
    bool crosshair;
    Arena *scratch;  // for this frame; the caller resets it
} HudState;

// For how long a message is seen, seconds, the last of them fading.
#define HUD_MESSAGE_SECONDS 4.0
#define HUD_ERROR_SECONDS 12.0

// In a frame that was begun. What the window has no room for is left out: first the plan, then the legend, signs, figures, help,
// the prompt. Messages lie over all else.
void hud_draw(Overlay *overlay, const HudState *state);

#endif
