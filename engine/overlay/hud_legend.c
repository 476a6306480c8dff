// hud_legend.c - draws a bar of the colours with round numbers beside it: all steps of 1, 2, 5 where there is room, otherwise powers
// of ten alone.
#include "engine/overlay/hud_legend.h"

#include <math.h>

// Points.
static const double TEXT = 12, SMALL = 10, LINE = 17, PAD = 10, BAR = 16, TICK = 4, ROUND = 6, WIDTH = 104;
static const unsigned PANEL = 0x0e1318, BRIGHT = 0xf2f5f7, DIM = 0x9fb0c0;
static const double OPACITY = 0.82;
// The bar consists of this many slabs, each of one colour.
enum { SLABS = 96 };

double hud_legend_width(void) { return WIDTH; }
double hud_legend_height(double height) { return height + 2 * LINE + SMALL + 2 * PAD; }

static unsigned hex(Rgb c) {
    return (unsigned)lrintf(255 * c.r) << 16 | (unsigned)lrintf(255 * c.g) << 8 | (unsigned)lrintf(255 * c.b);
}

// The number as text: 0.05, 2, 1 000.
static const char *number(double value, Arena *scratch) {
    if (value >= 1e6) return arena_format(scratch, "%g", value);
    if (value >= 1000) return arena_format(scratch, "%d %03d", (int)value / 1000, (int)lrint(value) % 1000);
    return arena_format(scratch, "%g", value);
}

static bool is_power_of_ten(double value) {
    double exponent = log10(value);
    return fabs(exponent - round(exponent)) < 1e-6;
}

void hud_legend_draw(Overlay *overlay, const HudLegend *legend, double x, double y, double height,
                     Arena *scratch) {
    double ticks[LIGHT_RANGE_TICKS], left = x + PAD, top = y + PAD + 2 * LINE + SMALL / 2;
    int count = light_range_ticks(legend->range, ticks);
    bool all = height >= count * SMALL * 1.4;
    overlay_rectangle(overlay, x, y, WIDTH, hud_legend_height(height), ROUND, PANEL, OPACITY);
    for (int i = 0; i < SLABS; i++) {
        double from = round(i * height / SLABS), to = round((i + 1) * height / SLABS);
        overlay_rectangle(overlay, left, top + from, BAR, to - from, 0,
                          hex(false_colour_at(1 - (i + 0.5) / SLABS)), 1);
    }
    for (int i = 0; i < count; i++) {
        double at = top + height * (1 - light_range_place(legend->range, ticks[i]));
        overlay_line(overlay, vec2(left + BAR, at), vec2(left + BAR + TICK, at), 1, DIM, 1);
    }
    overlay_text(overlay, left, y + PAD + OVERLAY_CAPITALS * TEXT, TEXT, BRIGHT, 1,
                 FALSE_COLOUR_NAMES[legend->quantity]);
    overlay_text(overlay, left, y + PAD + LINE + OVERLAY_CAPITALS * TEXT, SMALL, DIM, 1,
                 FALSE_COLOUR_UNITS[legend->quantity]);
    for (int i = 0; i < count; i++) {
        if (!all && !is_power_of_ten(ticks[i])) continue;
        double at = top + height * (1 - light_range_place(legend->range, ticks[i]));
        overlay_text(overlay, left + BAR + 2 * TICK, at + OVERLAY_CAPITALS * SMALL / 2, SMALL, BRIGHT, 1,
                     number(ticks[i], scratch));
    }
}
