// hud_legend.h - the scale of false colours as a panel: the quantity shown, its unit, and the number that each colour stands for.
#ifndef WALK_HUD_LEGEND_H
#define WALK_HUD_LEGEND_H

#include "engine/lit/false_colour.h"
#include "engine/overlay/overlay.h"

typedef struct HudLegend {
    FalseColour quantity;
    LightRange range;
} HudLegend;

// The size of the whole panel, points; `height` is the height of the scale alone.
double hud_legend_width(void);
double hud_legend_height(double height);
void hud_legend_draw(Overlay *overlay, const HudLegend *legend, double x, double y, double height,
                     Arena *scratch);

#endif
