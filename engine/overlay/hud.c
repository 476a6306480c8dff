// hud.c - panels are placed one after the other, the most urgent first, each where the window still has room.
#include "engine/overlay/hud.h"

enum { HUD_PANELS = 7, FIGURE_ROWS = 8, MESSAGE_LINES = 6, HUD_FLAGS = 16 };
static const char RECORDING[] = "recording";

// All lengths are in points.
static const double TEXT = 12, SMALL = 10, LINE = 17, PAD = 10, MARGIN = 12, GAP = 8, ROUND = 6;
static const double FIGURES_WIDTH = 232, LABEL_WIDTH = 64, MESSAGE_WIDTH = 560, HELP_GAP = 14, HELP_LINE = 19;
static const double KEY_PAD = 5, KEY_ROUND = 3;
// Help shrinks in steps of this factor, down to letters of so many pixels.
static const double HELP_SHRINK = 0.95, HELP_LEAST_PIXELS = 8;
// How far down the prompt stands, as a share of the window: below the point that is looked at.
static const double PROMPT_DOWN = 0.7;
// The plan's longer side is the first of these that fits into the window and is less than PLAN_SHARE of it.
static const double PLAN_SIDES[] = {250, 200, 150, 110};
static const double PLAN_SHARE = 0.5, PLAN_FRAME = 4;
// A metre of plan takes at least this many points: a door is then 9 points wide.
static const double PLAN_POINTS_PER_METRE = 10;
static const double LEAST_FOR_CROSSHAIR = 80;
// The height of the scale of false colours is the first of these that fits.
static const double LEGEND_HEIGHTS[] = {200, 150, 100, 60};

static const unsigned PANEL = 0x0e1318, DARK = 0x14181c, BRIGHT = 0xf2f5f7, DIM = 0x9fb0c0, ACCENT = 0xffc857,
                      RED = 0xc8322b, ERROR_PANEL = 0x6e1a17, KEY = 0x4a5a6b;
static const double PANEL_OPACITY = 0.82, MESSAGE_OPACITY = 0.96, PLAN_OPACITY = 0.88, FLAG_OPACITY = 0.92;

typedef struct Rectangle {
    double x, y, width, height;
} Rectangle;

typedef struct Hud {
    Overlay *overlay;
    const HudState *state;
    double width, height;  // of the window
    Rectangle taken[HUD_PANELS];
    int taken_count;
} Hud;

// ---- layout

// A rectangle of this size: `across` and `down` 0 put it at the left and top margins, 1 at the right and bottom margins.
static Rectangle anchored(const Hud *hud, double across, double down, double width, double height) {
    return (Rectangle){MARGIN + across * (hud->width - 2 * MARGIN - width),
                       MARGIN + down * (hud->height - 2 * MARGIN - height), width, height};
}

static bool overlaps(Rectangle a, Rectangle b) {
    return a.x < b.x + b.width + GAP && b.x < a.x + a.width + GAP && a.y < b.y + b.height + GAP &&
           b.y < a.y + a.height + GAP;
}

// Takes the place if it is in the window and free.
static bool take_place(Hud *hud, Rectangle r) {
    if (r.x < MARGIN || r.y < MARGIN || r.x + r.width > hud->width - MARGIN ||
        r.y + r.height > hud->height - MARGIN) {
        return false;
    }
    for (int i = 0; i < hud->taken_count; i++) {
        if (overlaps(r, hud->taken[i])) return false;
    }
    CORE_ASSERT(hud->taken_count < HUD_PANELS);
    hud->taken[hud->taken_count++] = r;
    return true;
}

static void panel(const Hud *hud, Rectangle r, unsigned rgb, double opacity) {
    overlay_rectangle(hud->overlay, r.x, r.y, r.width, r.height, ROUND, rgb, opacity);
}

// The baseline of letters in the middle of a line that starts at `top`.
static double baseline(double top, double height, double size) {
    return top + (height + OVERLAY_CAPITALS * size) / 2;
}

static void text(const Hud *hud, double x, double top, double size, unsigned rgb, const char *string) {
    overlay_text(hud->overlay, x, baseline(top, LINE, size), size, rgb, 1, string);
}

// ---- text that fits

static const char *start_of(const Hud *hud, const char *string, size_t length) {
    return arena_format(hud->state->scratch, "%.*s", (int)length, string);
}

static const char *shortened(const Hud *hud, double size, const char *string, double width) {
    static const char DOTS[] = "\u2026";
    if (overlay_text_width(hud->overlay, size, string) <= width) return string;
    double room = width - overlay_text_width(hud->overlay, size, DOTS);
    size_t length = overlay_text_fit(hud->overlay, size, string, room);
    return arena_format(hud->state->scratch, "%s%s", start_of(hud, string, length), DOTS);
}

// Breaks the text between words, and within words that are wider than a line; the last of `most` lines ends in dots if text is left.
// Returns the number of lines.
static int wrap(const Hud *hud, double size, const char *string, double width, const char **lines, int most) {
    int count = 0;
    for (string += strspn(string, " \n"); *string && count < most; string += strspn(string, " \n")) {
        size_t line = strcspn(string, "\n"), kept = overlay_text_fit(hud->overlay, size, string, width);
        if (kept > line) kept = line;
        if (count + 1 == most || kept == 0) {
            lines[count++] = shortened(hud, size, string, width);
            break;
        }
        size_t space = kept;
        while (space > 0 && space < line && string[space] != ' ') space--;
        if (space > 0) kept = space;
        lines[count++] = start_of(hud, string, kept);
        string += kept;
    }
    return count;
}

// ---- panels

double hud_message_opacity(double age, bool is_error) {
    return fmin(fmax((is_error ? HUD_ERROR_SECONDS : HUD_MESSAGE_SECONDS) - age, 0), 1);
}

// Draws the message over everything else, since it is gone soon.
static void draw_message(const Hud *hud) {
    const HudState *s = hud->state;
    double opacity = hud_message_opacity(s->message_age, s->message_is_error);
    if (!s->message || opacity <= 0) return;
    const char *lines[MESSAGE_LINES];
    double room = fmin(MESSAGE_WIDTH, hud->width - 2 * MARGIN) - 2 * PAD, width = 0;
    int most = (int)fmin(MESSAGE_LINES, (hud->height - 2 * MARGIN - PAD) / LINE);
    int count = room > TEXT ? wrap(hud, TEXT, s->message, room, lines, most) : 0;
    for (int i = 0; i < count; i++) width = fmax(width, overlay_text_width(hud->overlay, TEXT, lines[i]));
    if (count == 0) return;
    Rectangle r = anchored(hud, 0.5, 1, width + 2 * PAD, count * LINE + PAD);
    panel(hud, r, s->message_is_error ? ERROR_PANEL : PANEL, opacity * MESSAGE_OPACITY);
    for (int i = 0; i < count; i++) {
        overlay_text(hud->overlay, r.x + PAD, baseline(r.y + PAD / 2 + i * LINE, LINE, TEXT), TEXT, BRIGHT,
                     opacity, lines[i]);
    }
}

// The width of a key drawn as on a keyboard, `size` times as large as usual.
static double key_width(const Hud *hud, const char *keys, double size) {
    return overlay_text_width(hud->overlay, size * SMALL, keys) + 2 * size * KEY_PAD;
}

static void draw_key(const Hud *hud, double x, double top, const char *keys, double size, double opacity) {
    overlay_rectangle(hud->overlay, x, top + size, key_width(hud, keys, size), size * (LINE - 2),
                      size * KEY_ROUND, KEY, opacity);
}

static void draw_prompt(Hud *hud) {
    const HudState *s = hud->state;
    if (!s->prompt || !s->prompt_key) return;
    double key = key_width(hud, s->prompt_key, 1);
    const char *prompt = shortened(hud, TEXT, s->prompt, hud->width - 2 * MARGIN - 2 * PAD - key - GAP);
    double width = key + GAP + overlay_text_width(hud->overlay, TEXT, prompt) + 2 * PAD;
    Rectangle r = anchored(hud, 0.5, PROMPT_DOWN, width, LINE + PAD);
    if (!take_place(hud, r)) return;
    panel(hud, r, PANEL, PANEL_OPACITY);
    draw_key(hud, r.x + PAD, r.y + PAD / 2, s->prompt_key, 1, 1);
    text(hud, r.x + PAD + KEY_PAD, r.y + PAD / 2, SMALL, BRIGHT, s->prompt_key);
    text(hud, r.x + PAD + key + GAP, r.y + PAD / 2, TEXT, BRIGHT, prompt);
}

// The keys for a newcomer, in one row above the place of messages, or in as many rows as it takes.
static void draw_hint(Hud *hud) {
    const HudState *s = hud->state;
    double opacity = s->hint_opacity, inner = hud->width - 2 * MARGIN - 2 * PAD, x = 0, width = 0, rows = 1;
    if (opacity <= 0 || s->hint_count == 0) return;
    double *at = ARENA_ARRAY(s->scratch, double, 2 * s->hint_count);  // x and row of each
    for (int i = 0; i < s->hint_count; i++) {
        double wide = key_width(hud, s->hint[i].keys, 1) + GAP +
                      overlay_text_width(hud->overlay, TEXT, s->hint[i].action);
        if (x > 0 && x + wide > inner) x = 0, rows++;
        at[2 * i] = x;
        at[2 * i + 1] = rows - 1;
        width = fmax(width, x + wide);
        x += wide + 2 * HELP_GAP;
    }
    Rectangle r = anchored(hud, 0.5, 1, width + 2 * PAD, rows * HELP_LINE + PAD);
    r.y -= LINE + PAD + GAP;
    if (!take_place(hud, r)) return;
    panel(hud, r, PANEL, opacity * PANEL_OPACITY);
    for (int i = 0; i < s->hint_count; i++)
        draw_key(hud, r.x + PAD + at[2 * i], r.y + PAD / 2 + at[2 * i + 1] * HELP_LINE, s->hint[i].keys, 1,
                 opacity);
    for (int i = 0; i < s->hint_count; i++) {
        double left = r.x + PAD + at[2 * i], top = r.y + PAD / 2 + at[2 * i + 1] * HELP_LINE;
        overlay_text(hud->overlay, left + KEY_PAD, baseline(top, LINE, SMALL), SMALL, BRIGHT, opacity,
                     s->hint[i].keys);
        overlay_text(hud->overlay, left + key_width(hud, s->hint[i].keys, 1) + GAP, baseline(top, LINE, TEXT),
                     TEXT, BRIGHT, opacity, s->hint[i].action);
    }
}

// ---- help

typedef struct HelpTable {
    double size;           // of the letters, as a share of the usual
    double keys, actions;  // widths
    int rows, columns;
    Rectangle place;
} HelpTable;

// Places the table at this size of letters with as few columns as the room allows.
static bool place_help_of(Hud *hud, HelpTable *t, double size) {
    const HudState *s = hud->state;
    *t = (HelpTable){.size = size};
    for (int i = 0; i < s->help_count; i++) {
        t->keys = fmax(t->keys, key_width(hud, s->help[i].keys, size));
        t->actions = fmax(t->actions, overlay_text_width(hud->overlay, size * TEXT, s->help[i].action));
    }
    while (++t->columns <= s->help_count) {
        t->rows = (s->help_count + t->columns - 1) / t->columns;
        double width =
            t->columns * (t->keys + t->actions + size * (GAP + HELP_GAP)) + size * (2 * PAD - HELP_GAP);
        double height = size * (t->rows * HELP_LINE + 2 * PAD);
        for (int place = 0; place < 2; place++) {
            t->place = anchored(hud, place * 0.5, 1 - place * 0.5, width, height);
            if (take_place(hud, t->place)) return true;
        }
    }
    return false;
}

// The largest letters with which the whole table has room. False where not even the smallest have.
static bool place_help(Hud *hud, HelpTable *t) {
    if (!hud->state->help) return false;
    double least = HELP_LEAST_PIXELS / (overlay_scale(hud->overlay) * TEXT);
    for (double size = 1; size >= least; size *= HELP_SHRINK)
        if (place_help_of(hud, t, size)) return true;
    return false;
}

static void draw_help(const Hud *hud, const HelpTable *t) {
    const HudState *s = hud->state;
    double size = t->size;
    panel(hud, t->place, PANEL, PANEL_OPACITY);
    // First all the keys, then all the text: two draw calls.
    for (int i = 0; i < 2 * s->help_count; i++) {
        int row = i % s->help_count;
        double x = t->place.x + size * PAD + row / t->rows * (t->keys + t->actions + size * (GAP + HELP_GAP));
        double top = t->place.y + size * (PAD + row % t->rows * HELP_LINE);
        if (i < s->help_count) {
            draw_key(hud, x, top, s->help[row].keys, size, 1);
        } else {
            overlay_text(hud->overlay, x + size * KEY_PAD, baseline(top, size * LINE, size * SMALL),
                         size * SMALL, BRIGHT, 1, s->help[row].keys);
            overlay_text(hud->overlay, x + t->keys + size * GAP, baseline(top, size * LINE, size * TEXT),
                         size * TEXT, BRIGHT, 1, s->help[row].action);
        }
    }
}

// ---- figures

static void draw_figure(const Hud *hud, Rectangle r, int row, const char *label, const char *value) {
    double top = r.y + PAD / 2 + row * LINE;
    text(hud, r.x + PAD, top, TEXT, DIM, label);
    text(hud, r.x + PAD + LABEL_WIDTH, top, TEXT, BRIGHT,
         shortened(hud, TEXT, value, r.width - 2 * PAD - LABEL_WIDTH));
}

static void draw_figures(const Hud *hud, Rectangle r) {
    const HudFigures *f = hud->state->figures;
    Arena *scratch = hud->state->scratch;
    double share = f->polygon_count ? 100.0 * f->polygons_drawn / f->polygon_count : 0;
    const char *room = f->room && *f->room ? f->room : "outdoors";
    panel(hud, r, PANEL, PANEL_OPACITY);
    draw_figure(hud, r, 0, "culling", f->method);
    draw_figure(hud, r, 1, "cells", arena_format(scratch, "%d of %d", f->cells_visible, f->cell_count));
    draw_figure(hud, r, 2, "polygons",
                arena_format(scratch, "%d of %d, %.1f %%", f->polygons_drawn, f->polygon_count, share));
    draw_figure(hud, r, 3, "query", arena_format(scratch, "%.0f \u00b5s", f->query_us));
    draw_figure(hud, r, 4, "frame",
                arena_format(scratch, "%.1f ms, %.0f a second", f->frame_ms, f->frames_per_second));
    draw_figure(hud, r, 5, "eye", arena_format(scratch, "%.2f  %.2f  %.2f m", f->eye.x, f->eye.y, f->eye.z));
    draw_figure(hud, r, 6, "room", f->storey ? arena_format(scratch, "%s, %s", room, f->storey) : room);
    draw_figure(hud, r, 7, "light", f->light ? f->light : "");
}

// Draws small signs in a row, that of recording first; signs that no longer fit are left out.
static void draw_flags(Hud *hud, double top) {
    const HudState *s = hud->state;
    int first = s->recording ? -1 : 0, end = first;
    Rectangle row = {MARGIN, top, 0, LINE}, signs[HUD_FLAGS];
    for (; end < s->flag_count && end - first < HUD_FLAGS; end++) {
        double width =
            overlay_text_width(hud->overlay, SMALL, end < 0 ? RECORDING : s->flags[end]) + 2 * KEY_PAD;
        double x = end == first ? MARGIN : row.x + row.width + GAP;
        if (x + width > hud->width - MARGIN) break;
        signs[end - first] = (Rectangle){x, top, width, LINE};
        row.width = x + width - row.x;
    }
    if (end == first || !take_place(hud, row)) return;
    for (int i = first; i < end; i++) {
        Rectangle r = signs[i - first];
        overlay_rectangle(hud->overlay, r.x, r.y, r.width, r.height, KEY_ROUND, i < 0 ? RED : ACCENT,
                          FLAG_OPACITY);
    }
    for (int i = first; i < end; i++) {
        text(hud, signs[i - first].x + KEY_PAD, top, SMALL, i < 0 ? BRIGHT : DARK,
             i < 0 ? RECORDING : s->flags[i]);
    }
}

// ---- the plan

// Draws below the map the storey's name at the left and a bar with its length in metres at the right.
static void draw_scale(const Hud *hud, const OverlayMap *map, Rectangle r) {
    static const double LENGTHS[] = {1, 2, 5, 10, 20, 50};
    double metres = LENGTHS[0];
    for (int i = 0; i < 6; i++) {
        if (LENGTHS[i] * map->scale < r.width / 3) metres = LENGTHS[i];
    }
    double y = r.y + r.height - LINE / 2, x1 = r.x + r.width - PAD, x0 = x1 - metres * map->scale;
    const char *label = arena_format(hud->state->scratch, "%g m", metres);
    overlay_line(hud->overlay, vec2(x0, y), vec2(x1, y), 1, DIM, 1);
    overlay_line(hud->overlay, vec2(x0, y - 2), vec2(x0, y + 2), 1, DIM, 1);
    overlay_line(hud->overlay, vec2(x1, y - 2), vec2(x1, y + 2), 1, DIM, 1);
    double width = overlay_text_width(hud->overlay, SMALL, label);
    overlay_text(hud->overlay, x0 - width - KEY_PAD, baseline(y - LINE / 2, LINE, SMALL), SMALL, DIM, 1,
                 label);
    const PlanView *plan = hud->state->plan;
    const char *storey = plan->storey < 0 ? NULL : plan->graph->building->storeys[plan->storey].name;
    overlay_text(hud->overlay, r.x + PAD, baseline(y - LINE / 2, LINE, SMALL), SMALL, BRIGHT, 1,
                 shortened(hud, SMALL, storey ? storey : "", x0 - width - 2 * KEY_PAD - r.x - PAD));
}

static void draw_plan(Hud *hud) {
    const PlanView *plan = hud->state->plan;
    if (!plan) return;
    for (size_t i = 0; i < sizeof PLAN_SIDES / sizeof *PLAN_SIDES; i++) {
        double side = PLAN_SIDES[i];
        if (side > PLAN_SHARE * hud->width || side > PLAN_SHARE * hud->height + LINE) continue;
        Box area = plan_view_area(plan, side / PLAN_POINTS_PER_METRE);
        double x = area.max.x - area.min.x, y = area.max.y - area.min.y, scale = side / fmax(x, y);
        double width = fmax(x * scale, side / 2), height = y * scale;
        Rectangle r = anchored(hud, 1, 0, width + 2 * PLAN_FRAME, height + PLAN_FRAME + LINE);
        if (!take_place(hud, r)) continue;
        panel(hud, r, PANEL, PLAN_OPACITY);
        OverlayMap map = overlay_map(hud->overlay, area, r.x + PLAN_FRAME, r.y + PLAN_FRAME, width, height);
        Draw draw = overlay_map_draw(&map);
        plan_view_draw(plan, area, 1 / map.scale, hud->state->scratch, &draw);
        draw_scale(hud, &map, r);
        return;
    }
}

static void draw_legend(Hud *hud) {
    const HudLegend *legend = hud->state->legend;
    if (!legend) return;
    for (size_t i = 0; i < sizeof LEGEND_HEIGHTS / sizeof *LEGEND_HEIGHTS; i++) {
        Rectangle r = anchored(hud, 1, 1, hud_legend_width(), hud_legend_height(LEGEND_HEIGHTS[i]));
        if (!take_place(hud, r)) continue;
        hud_legend_draw(hud->overlay, legend, r.x, r.y, LEGEND_HEIGHTS[i], hud->state->scratch);
        return;
    }
}

// A light spot within a dark one, so that it shows on any background.
static void draw_crosshair(const Hud *hud) {
    if (!hud->state->crosshair || fmin(hud->width, hud->height) < LEAST_FOR_CROSSHAIR) return;
    Vec2 middle = {hud->width / 2, hud->height / 2};
    overlay_circle(hud->overlay, middle, 3.2, DARK, 0.55);
    overlay_circle(hud->overlay, middle, 1.8, BRIGHT, 0.95);
}

void hud_draw(Overlay *overlay, const HudState *state) {
    Hud hud = {.overlay = overlay,
               .state = state,
               .width = overlay_width(overlay),
               .height = overlay_height(overlay)};
    HelpTable help;
    draw_crosshair(&hud);
    draw_prompt(&hud);
    // Help was asked for just now: the figures give way to it.
    draw_hint(&hud);
    Rectangle figures = anchored(&hud, 0, 0, FIGURES_WIDTH, FIGURE_ROWS * LINE + PAD);
    bool shown = state->figures && take_place(&hud, figures);
    bool helped = state->help && place_help_of(&hud, &help, 1);
    if (shown && !helped && state->help) {
        hud.taken_count--;
        helped = place_help(&hud, &help);
        if (helped || !take_place(&hud, figures)) shown = false;
    }
    if (!helped && !shown) helped = place_help(&hud, &help);
    if (shown) draw_figures(&hud, figures);
    if (helped) draw_help(&hud, &help);
    draw_flags(&hud, shown ? figures.y + figures.height + GAP : MARGIN);
    draw_legend(&hud);
    draw_plan(&hud);
    draw_message(&hud);
}
