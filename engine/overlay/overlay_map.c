// overlay_map.c - the overlay's back end of the drawing table: converts metres of plan to points, with y turned over.
#include "engine/overlay/overlay.h"

// Dashes are at least this long, points: shorter ones could not be told apart.
#define MAP_LEAST_DASH 2.0

OverlayMap overlay_map(Overlay *overlay, Box area, double x, double y, double width, double height) {
    double scale = fmin(width / (area.max.x - area.min.x), height / (area.max.y - area.min.y));
    return (OverlayMap){.overlay = overlay,
                        .x = x,
                        .y = y,
                        .width = width,
                        .height = height,
                        .middle = {(area.min.x + area.max.x) / 2, (area.min.y + area.max.y) / 2},
                        .scale = scale};
}

static Vec2 place(const OverlayMap *map, Vec2 p) {
    return vec2(map->x + map->width / 2 + (p.x - map->middle.x) * map->scale,
                map->y + map->height / 2 - (p.y - map->middle.y) * map->scale);
}

static void begin_map(const OverlayMap *map) {
    overlay_clip(map->overlay, map->x, map->y, map->width, map->height);
}

// The part of a -> b, as shares of its length, that can show: dashes far outside need not be made.
static bool part_shown(const OverlayMap *map, Vec2 a, Vec2 b, double margin, double *from, double *to) {
    double start[2] = {a.x, a.y}, way[2] = {b.x - a.x, b.y - a.y};
    double least[2] = {map->x - margin, map->y - margin};
    double most[2] = {map->x + map->width + margin, map->y + map->height + margin};
    *from = 0;
    *to = 1;
    for (int k = 0; k < 2; k++) {
        double s = (least[k] - start[k]) / way[k], t = (most[k] - start[k]) / way[k];
        if (way[k] == 0 && (start[k] < least[k] || start[k] > most[k])) return false;
        if (way[k] == 0) continue;
        *from = fmax(*from, fmin(s, t));
        *to = fmin(*to, fmax(s, t));
    }
    return *from < *to;
}

static void draw_line(void *context, Vec2 a, Vec2 b, const DrawStyle *style) {
    const OverlayMap *map = context;
    Vec2 from = place(map, a), way = vec2_sub(place(map, b), from);
    double width = style->width * map->scale, length = vec2_length(way);
    double dash = fmax(style->dash * map->scale, MAP_LEAST_DASH), first, last;
    begin_map(map);
    if (style->dash <= 0) {
        overlay_line(map->overlay, from, vec2_add(from, way), width, style->stroke, 1);
    } else if (part_shown(map, from, vec2_add(from, way), width, &first, &last)) {
        // Dashes are counted from a, so that they stay where they are on the plan when the map moves.
        for (double at = 2 * dash * floor(first * length / (2 * dash)); at < last * length; at += 2 * dash) {
            double end = fmin(at + dash, length);
            overlay_line(map->overlay, vec2_add(from, vec2_scale(way, at / length)),
                         vec2_add(from, vec2_scale(way, end / length)), width, style->stroke, 1);
        }
    }
    overlay_unclip(map->overlay);
}

static void draw_polygon(void *context, const Vec2 *points, int count, const DrawStyle *style) {
    enum { FEW = 64 };
    const OverlayMap *map = context;
    // A fan from points[0] is drawn in parts: each part begins with the last corner of the part before.
    for (int first = 1; style->fill_opacity > 0 && first + 1 < count; first += FEW - 2) {
        Vec2 part[FEW] = {place(map, points[0])};
        int held = 1;
        for (int i = first; i < count && held < FEW; i++) part[held++] = place(map, points[i]);
        begin_map(map);
        overlay_polygon(map->overlay, part, held, style->fill, style->fill_opacity);
        overlay_unclip(map->overlay);
    }
    for (int i = 0; style->width > 0 && i < count; i++) {
        draw_line(context, points[i], points[(i + 1) % count], style);
    }
}

static void draw_circle(void *context, Vec2 centre, double radius, const DrawStyle *style) {
    const OverlayMap *map = context;
    double line = style->width * map->scale;
    begin_map(map);
    // The outline is a larger disc below the filling: right for fillings that are opaque.
    if (line > 0)
        overlay_circle(map->overlay, place(map, centre), radius * map->scale + line / 2, style->stroke, 1);
    overlay_circle(map->overlay, place(map, centre), radius * map->scale - line / 2, style->fill,
                   style->fill_opacity);
    overlay_unclip(map->overlay);
}

static double text_width(void *context, double size, const char *text) {
    const OverlayMap *map = context;
    return overlay_text_width(map->overlay, size * map->scale, text) / map->scale;
}

static void draw_text(void *context, Vec2 at, double size, unsigned colour, const char *text) {
    const OverlayMap *map = context;
    Vec2 middle = place(map, at);
    double points = size * map->scale, width = overlay_text_width(map->overlay, points, text);
    begin_map(map);
    overlay_text(map->overlay, middle.x - width / 2, middle.y + OVERLAY_CAPITALS * points / 2, points, colour,
                 1, text);
    overlay_unclip(map->overlay);
}

Draw overlay_map_draw(OverlayMap *map) {
    return (Draw){draw_polygon, draw_line, draw_circle, draw_text, map, text_width};
}
