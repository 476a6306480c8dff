// light_plan.c - isolux lines by marching squares over the points of each room's grid, each square cut in smaller ones between whose
// corners light changes bilinearly, so that lines are round.
#include "engine/app/light_plan.h"

#include <string.h>

#include "engine/core/draw.h"
#include "engine/lit/false_colour.h"
#include "visibility/prepare/figure.h"

// Lines that may be drawn, lux; and percent of the light outdoors.
static const double LUX[] = {1,   2,   5,   10,   20,   50,   100,  150,  200,
                             300, 500, 750, 1000, 1500, 2000, 3000, 5000, 10000};
static const double PERCENT[] = {0.05, 0.1, 0.2, 0.5, 1, 2, 3, 5, 7, 10, 15, 20, 30, 50};
enum { LUX_LINES = sizeof LUX / sizeof *LUX, PERCENT_LINES = sizeof PERCENT / sizeof *PERCENT };
enum { FINER = 4 };                                           // parts of a square's side
static const double LABEL = 0.16, NAME = 0.22, LEGEND = 0.3;  // height of text, metres
static const unsigned INK = 0x222222;
static const float PALE = 0.25f;  // towards white, so that ink is read on all colours

typedef struct LightPlan {
    const LoadedScene *scene;
    const PlannedLight *light;
    const PlannedSource *source;
    const Draw *draw;
    const double *lines;  // [line_count]
    int line_count;
    double factor;  // from values to the unit of lines
    const char *unit;
    LightRange range;
    Arena *arena;
} LightPlan;

// Lines of one height in a room.
typedef struct Contour {
    Vec2 *middles;  // [count] of its pieces
    int count, capacity;
} Contour;

static unsigned colour_at(const LightPlan *p, double value) {
    Rgb c = false_colour_at(light_range_place(p->range, value));
    c = (Rgb){PALE + (1 - PALE) * c.r, PALE + (1 - PALE) * c.g, PALE + (1 - PALE) * c.b};
    return (unsigned)lrintf(255 * c.r) << 16 | (unsigned)lrintf(255 * c.g) << 8 | (unsigned)lrintf(255 * c.b);
}

// A corner of a small square: its place, and the value there.
typedef struct Corner {
    Vec2 at;
    double value;
} Corner;

static Corner corner_at(const Corner whole[4], double s, double t) {
    Vec2 low = vec2_add(vec2_scale(whole[0].at, 1 - s), vec2_scale(whole[1].at, s)),
         high = vec2_add(vec2_scale(whole[3].at, 1 - s), vec2_scale(whole[2].at, s));
    return (Corner){vec2_add(vec2_scale(low, 1 - t), vec2_scale(high, t)),
                    (1 - t) * ((1 - s) * whole[0].value + s * whole[1].value) +
                        t * ((1 - s) * whole[3].value + s * whole[2].value)};
}

static void cross_square(const LightPlan *p, const Corner corner[4], double height, Contour *contour) {
    static const DrawStyle LINE = {.stroke = 0x222222, .width = 0.018};
    Vec2 ends[4];
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const Corner *a = &corner[i], *b = &corner[(i + 1) % 4];
        if ((a->value < height) == (b->value < height)) continue;
        double at = (height - a->value) / (b->value - a->value);
        ends[count++] = vec2_add(vec2_scale(a->at, 1 - at), vec2_scale(b->at, at));
    }
    for (int i = 0; i + 1 < count; i += 2) {
        p->draw->line(p->draw->context, ends[i], ends[i + 1], &LINE);
        *ARENA_PUSH(p->arena, contour->middles, contour->count, contour->capacity) =
            vec2_scale(vec2_add(ends[i], ends[i + 1]), 0.5);
    }
}

// Text on a piece of paper.
static void draw_label(const LightPlan *p, Vec2 at, double size, const char *text) {
    static const DrawStyle PAPER = {.fill = 0xffffff, .fill_opacity = 0.75};
    double wide = 0.3 * size * (double)strlen(text) + 0.1 * size, high = 0.6 * size;
    Vec2 sheet[4] = {{at.x - wide, at.y - high},
                     {at.x + wide, at.y - high},
                     {at.x + wide, at.y + high},
                     {at.x - wide, at.y + high}};
    p->draw->polygon(p->draw->context, sheet, 4, &PAPER);
    p->draw->text(p->draw->context, at, size, INK, text);
}

// The label is at the piece of the line that is farthest from the labels that are there.
static void label_contour(const LightPlan *p, const Contour *contour, double height, Vec2 *labels,
                          int *label_count) {
    int best = -1;
    double farthest = 2 * LABEL;
    for (int i = 0; i < contour->count; i++) {
        double nearest = INFINITY;
        for (int k = 0; k < *label_count; k++)
            nearest = fmin(nearest, vec2_length(vec2_sub(contour->middles[i], labels[k])));
        if (nearest <= farthest) continue;
        farthest = nearest;
        best = i;
    }
    if (best < 0) return;
    labels[(*label_count)++] = contour->middles[best];
    draw_label(p, contour->middles[best], LABEL, arena_format(p->arena, "%g", height));
}

// The corners of the square between four points of a grid; false: one of them has no light.
static bool square_of(const LightPlan *p, const PlannedRoom *room, int i, int k, Corner out[4]) {
    static const int STEP[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int c = 0; c < 4; c++) {
        int point = room->grid.point[(k + STEP[c][1]) * room->grid.count[0] + i + STEP[c][0]];
        if (point < 0) return false;
        out[c] =
            (Corner){room->grid.points[point], p->factor * p->source->values.all[room->first_point + point]};
        if (isnan(out[c].value)) return false;
    }
    return true;
}

static void draw_room(const LightPlan *p, const PlannedRoom *room, bool lines) {
    Contour *contours = ARENA_ARRAY(p->arena, Contour, p->line_count);
    for (int i = 0; i + 1 < room->grid.count[0]; i++)
        for (int k = 0; k + 1 < room->grid.count[1]; k++) {
            Corner whole[4], part[4];
            if (!square_of(p, room, i, k, whole)) continue;
            for (int n = 0; n < FINER * FINER; n++) {
                double s = (double)(n % FINER) / FINER, t = (double)(n / FINER) / FINER, step = 1.0 / FINER;
                part[0] = corner_at(whole, s, t);
                part[1] = corner_at(whole, s + step, t);
                part[2] = corner_at(whole, s + step, t + step);
                part[3] = corner_at(whole, s, t + step);
                for (int h = 0; h < p->line_count && lines; h++)
                    cross_square(p, part, p->lines[h], &contours[h]);
                if (lines) continue;
                double mean = (part[0].value + part[1].value + part[2].value + part[3].value) / 4;
                Vec2 v[4] = {part[0].at, part[1].at, part[2].at, part[3].at};
                // The stroke closes the seams that renderers leave between squares.
                unsigned colour = colour_at(p, mean);
                DrawStyle fill = {.stroke = colour, .fill = colour, .width = 0.01, .fill_opacity = 1};
                p->draw->polygon(p->draw->context, v, 4, &fill);
            }
        }
    Vec2 *labels = ARENA_ARRAY(p->arena, Vec2, p->line_count + 1);
    int label_count = 0;
    for (int h = 0; h < p->line_count && lines; h++)
        label_contour(p, &contours[h], p->lines[h], labels, &label_count);
}

static Box room_box(const Building *b, const Region *region) {
    Box box = box_empty();
    const Ring *ring = &b->rings[region->first_ring];
    for (int i = 0; i < ring->point_count; i++) {
        Vec2 v = b->points[ring->first_point + i];
        box = box_add(box, vec3(v.x, v.y, 0));
    }
    return box;
}

static void draw_name(const LightPlan *p, int index) {
    const Building *b = &p->scene->building;
    const PlannedRoom *room = &p->light->plan.rooms[index];
    const Region *region = &b->regions[room->region];
    RoomFigures f = room_figures(&p->light->plan, index, &p->source->values);
    double mean = p->factor * f.mean;
    const char *text = arena_format(p->arena, mean >= 100 ? "%s%s%.0f %s" : "%s%s%.3g %s", region->name,
                                    *region->name ? ": " : "", mean, p->unit);
    if (!(f.mean >= 0)) text = region->name;
    Vec2 middle;
    double size = NAME;
    Box box = room_box(b, region);
    // Smaller, where the room is.
    while (size > NAME / 3 &&
           !figure_name_place(b, room->region, box, 0.6 * size * (double)strlen(text), 1.2 * size, &middle))
        size *= 0.8;
    if (!figure_name_place(b, room->region, box, 0.6 * size * (double)strlen(text), 1.2 * size, &middle))
        return;
    draw_label(p, middle, size, text);
}

// Names are ours, with each room's light.
static void draw_no_text(void *context, Vec2 at, double size, unsigned colour, const char *text) {
    (void)context, (void)at, (void)size, (void)colour, (void)text;
}

// Boxes of colour with the numbers of the lines, from the least to the greatest that there is.
static void draw_legend(const LightPlan *p, Box area) {
    int first = 0, last = p->line_count - 1;
    while (first < last && p->lines[first + 1] <= p->range.low) first++;
    while (last > first && p->lines[last - 1] >= p->range.high) last--;
    double step = (area.max.x - area.min.x) / (last - first + 2), size = fmin(LEGEND, step / 3);
    for (int i = first; i <= last; i++) {
        double x = area.min.x + (i - first) * step;
        Vec2 v[4] = {{x, area.min.y}, {x + step, area.min.y}, {x + step, area.max.y}, {x, area.max.y}};
        DrawStyle fill = {.fill = colour_at(p, p->lines[i]), .fill_opacity = 1};
        p->draw->polygon(p->draw->context, v, 4, &fill);
        draw_label(p, vec2(x + step / 2, (area.min.y + area.max.y) / 2), size,
                   arena_format(p->arena, "%g", p->lines[i]));
    }
    p->draw->text(p->draw->context, vec2(area.max.x - step / 2, (area.min.y + area.max.y) / 2), size, INK,
                  p->unit);
}

bool light_plan_check(const LoadedScene *scene, int storey, Error *error) {
    const Building *b = &scene->building;
    if (storey < b->storey_count || b->storey_count == 0) return true;
    return error_set(error, "%s: has no storey %d (allowed 0 to %d)", b->source, storey, b->storey_count - 1);
}

bool light_plan(const LoadedScene *scene, const PlannedLight *light, int storey, int pixels, Arena *arena,
                const char **svg, Error *error) {
    const Building *b = &scene->building;
    static const double CUT = 1.2;  // metres above the floor
    bool lamps = light->sources[PLANNED_LAMPS].there;
    LightPlan p = {.scene = scene,
                   .light = light,
                   .source = &light->sources[lamps ? PLANNED_LAMPS : PLANNED_DAY],
                   .lines = lamps ? LUX : PERCENT,
                   .line_count = lamps ? LUX_LINES : PERCENT_LINES,
                   .factor = lamps ? 1 : 100,
                   .unit = lamps ? "lx" : "%",
                   .arena = arena};
    Box box = box_empty();
    double least = INFINITY, most = 0;
    for (int r = 0; r < light->plan.room_count; r++) {
        const PlannedRoom *room = &light->plan.rooms[r];
        if (b->regions[room->region].storey != storey) continue;
        box = box_union(box, room_box(b, &b->regions[room->region]));
        for (int i = 0; i < room->grid.point_count; i++) {
            double value = p.factor * p.source->values.all[room->first_point + i];
            if (value > 0) least = fmin(least, value), most = fmax(most, value);
        }
    }
    if (box_is_empty(box))
        return error_set(error, "%s: storey %d has no rooms on the working plane", b->source, storey);
    p.range = (LightRange){least < most ? least : 0.5, least < most ? most : 1};
    box = box_grow(box, 0.6);
    Box legend = box, whole = box;
    whole.min.y -= 1;
    legend.max.y = box.min.y - 0.2;
    legend.min.y = legend.max.y - 0.6;
    legend.min.x += 0.6;
    legend.max.x -= 0.6;
    SvgDrawing *drawing = svg_begin(arena, whole, pixels);
    Draw draw = svg_draw(drawing), nameless = draw;
    p.draw = &draw;
    nameless.text = draw_no_text;
    double z = b->storeys[storey].floor + fmin(CUT, b->storeys[storey].height / 2);
    figure_ground(&scene->graph, z, &draw);
    for (int lines = 0; lines < 2; lines++)
        for (int r = 0; r < light->plan.room_count; r++)
            if (b->regions[light->plan.rooms[r].region].storey == storey)
                draw_room(&p, &light->plan.rooms[r], lines);
    figure_lines(&scene->graph, z, &nameless);
    for (int r = 0; r < light->plan.room_count; r++)
        if (b->regions[light->plan.rooms[r].region].storey == storey) draw_name(&p, r);
    draw_legend(&p, legend);
    *svg = svg_end(drawing);
    return true;
}
