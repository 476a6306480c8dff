// test_overlay.c - text, shapes and plans over a frame: they cover what they should and nothing else, whatever the text,
// the size of the window and its scale.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "visibility/prepare/figure.h"

// A black frame and an overlay to draw on it.
typedef struct Canvas {
    Arena arena;
    GlContext *context;
    Overlay *overlay;
    unsigned frame, target;
    int width, height;
    uint8_t *rgba;  // as read last, rows from the top
} Canvas;

static void canvas_open(Canvas *c, int width, int height) {
    *c = (Canvas){.width = width, .height = height};
    Error error;
    c->context = gl_context_open(&c->arena, &error);
    cr_assert(c->context, "%s", error.text);
    c->overlay = overlay_new(&c->arena, &error);
    cr_assert(c->overlay, "%s", error.text);
    glGenRenderbuffers(1, &c->target);
    glBindRenderbuffer(GL_RENDERBUFFER, c->target);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glGenFramebuffers(1, &c->frame);
    glBindFramebuffer(GL_FRAMEBUFFER, c->frame);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, c->target);
    c->rgba = arena_alloc(&c->arena, (size_t)width * (size_t)height, 4);
}

static void canvas_close(Canvas *c) {
    overlay_free(c->overlay);
    gl_context_close(c->context);
    arena_free(&c->arena);
}

static void canvas_begin(Canvas *c, double scale) {
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    overlay_begin(c->overlay, c->width, c->height, scale);
}

static void canvas_end(Canvas *c) {
    Error error;
    cr_assert(overlay_end(c->overlay, &error), "%s", error.text);
    glReadPixels(0, 0, c->width, c->height, GL_RGBA, GL_UNSIGNED_BYTE, c->rgba);
}

static const uint8_t *pixel(const Canvas *c, double x, double y) {
    cr_assert(x >= 0 && y >= 0 && x < c->width && y < c->height, "no pixel (%g, %g)", x, y);
    return c->rgba + 4 * ((size_t)y * (size_t)c->width + (size_t)x);
}

// How many pixels are covered, parts of pixels counted as such: white on black.
static double covered(const Canvas *c) {
    double sum = 0;
    for (int i = 0; i < c->width * c->height; i++) sum += c->rgba[4 * i] / 255.0;
    return sum;
}

// The pixels in which there is red: first and last column, first and last row.
typedef struct Ink {
    int x0, x1, y0, y1;
} Ink;

static Ink ink_of(const Canvas *c) {
    Ink ink = {c->width, -1, c->height, -1};
    for (int y = 0; y < c->height; y++) {
        for (int x = 0; x < c->width; x++) {
            if (pixel(c, x, y)[0] < 16) continue;  // the faintest edge of a letter, and dark panels
            if (x < ink.x0) ink.x0 = x;
            if (x > ink.x1) ink.x1 = x;
            if (y < ink.y0) ink.y0 = y;
            if (y > ink.y1) ink.y1 = y;
        }
    }
    return ink;
}

// ---- text

// Letters stand on the baseline, start at x, and are as high as capitals are, at each scale.
// Tolerance: a pixel, for side bearings, smoothed edges and the height of small letters being whole pixels.
Test(overlay, text_lands_where_asked) {
    Canvas c;
    canvas_open(&c, 320, 240);
    for (int scale = 1; scale <= 3; scale++) {
        double size = 24, x = 20, baseline = 60;
        canvas_begin(&c, scale);
        overlay_text(c.overlay, x, baseline, size, 0xffffff, 1, "HEH");
        canvas_end(&c);
        Ink ink = ink_of(&c);
        cr_expect_eq(ink.y1, (int)baseline * scale - 1, "scale %d: the last row is %d", scale, ink.y1);
        cr_expect_float_eq(ink.y0, (baseline - OVERLAY_CAPITALS * size) * scale, 1.5 * scale,
                           "scale %d: the first row is %d", scale, ink.y0);
        // An H starts a tenth of the em right of its pen.
        cr_expect_float_eq(ink.x0, (x + 0.1 * size) * scale, 1.0 * scale, "scale %d: the first column is %d",
                           scale, ink.x0);
    }
    canvas_close(&c);
}

// The width promised is where the next letter would stand: a second text put there does not touch the first, and the
// ink of a long text is as wide as promised but for the bearings of its ends (a tenth of the em each, and a pixel).
Test(overlay, width_matches_ink) {
    static const char *const TEXTS[] = {"HHHHHHHH", "Salon d'été", "Wohnküche", "AVAVAVA", "кухня и холл"};
    Canvas c;
    canvas_open(&c, 400, 60);
    for (int i = 0; i < 5; i++) {
        for (double size = 10; size < 34; size += 5.5) {
            canvas_begin(&c, 1);
            double width = overlay_text_width(c.overlay, size, TEXTS[i]);
            overlay_text(c.overlay, 10, 40, size, 0xffffff, 1, TEXTS[i]);
            canvas_end(&c);
            Ink ink = ink_of(&c);
            cr_expect_float_eq(ink.x1 + 1 - ink.x0, width - 0.1 * size, 0.1 * size + 1.5,
                               "`%s` at %g: ink %d to %d, width %g", TEXTS[i], size, ink.x0, ink.x1, width);
            cr_expect_geq(10 + width, ink.x1 - 1, "`%s` at %g", TEXTS[i], size);
        }
    }
    canvas_close(&c);
}

// A text that is cut to fit is as long as it can be: one character more is too wide.
Test(overlay, fits_as_much_as_there_is_room_for) {
    Canvas c;
    canvas_open(&c, 64, 64);
    const char *text = "Größe: дом, zażółć gęślą jaźń";
    canvas_begin(&c, 1);
    for (double width = 0; width < 300; width += 7) {
        size_t fit = overlay_text_fit(c.overlay, 13, text, width);
        const char *more = text + fit;
        font_decode(&more);
        cr_expect_leq(overlay_text_width(c.overlay, 13, arena_format(&c.arena, "%.*s", (int)fit, text)),
                      width + 1e-9);
        if (!text[fit]) continue;
        const char *longer = arena_format(&c.arena, "%.*s", (int)(more - text), text);
        cr_expect_gt(overlay_text_width(c.overlay, 13, longer), width, "`%s` is said to be too wide for %g",
                     longer, width);
    }
    canvas_end(&c);
    canvas_close(&c);
}

// UTF-8 by its table: whole characters, one U+FFFD for each byte of anything else (overlong forms, halves of pairs, what
// is beyond Unicode, what is cut off), and never past the end.
Test(overlay, decodes_utf8, .timeout = 60) {
    static const struct {
        const char *bytes;
        int characters[6];
    } CASES[] = {{"aé€😀", {'a', 0xe9, 0x20ac, 0x1f600}},
                 {"\xd0\x96\x7f", {0x416, 0x7f}},
                 {"\xc0\xaf", {0xfffd, 0xfffd}},
                 {"\xe0\x80\xaf", {0xfffd, 0xfffd, 0xfffd}},
                 {"\xed\xa0\x80", {0xfffd, 0xfffd, 0xfffd}},
                 {"\xf4\x90\x80\x80", {0xfffd, 0xfffd, 0xfffd, 0xfffd}},
                 {"\xe2\x82", {0xfffd, 0xfffd}},
                 {"\xff\x80z", {0xfffd, 0xfffd, 'z'}}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        const char *at = CASES[i].bytes;
        for (int k = 0; k < 6; k++) {
            int character = font_decode(&at);
            cr_expect_eq(character, CASES[i].characters[k], "case %zu, character %d: U+%04X", i, k,
                         (unsigned)character);
            if (!character) break;
        }
        cr_expect_eq(at, CASES[i].bytes + strlen(CASES[i].bytes));
    }
}

// The languages of Europe have letters, others a box; and no bytes whatever do harm, at any size.
Test(overlay, draws_any_text, .timeout = 60) {
    Canvas c;
    canvas_open(&c, 200, 50);
    Font *font = font_new(&c.arena);
    const char *letters = "aÆßđőŞžΩЖѣ€№…";
    for (const char *at = letters; *at;) {
        int character = font_decode(&at);
        cr_expect_neq(font_glyph(font, character, 20, 0).index, 0, "U+%04X has no glyph",
                      (unsigned)character);
    }
    Glyph box = font_glyph(font, 0x6f22, 20, 0);
    cr_expect(box.index == 0 && box.width > 0 && box.advance > 0);
    Random random = {5};
    for (int i = 0; i < 400; i++) {
        char text[64];
        for (int k = 0; k < 63; k++) text[k] = (char)(1 + random_index(&random, 255));
        text[63] = 0;
        canvas_begin(&c, 1 + random_index(&random, 4));
        double size = exp(8 * random_unit(&random) - 3), width = overlay_text_width(c.overlay, size, text);
        cr_expect(isfinite(width) && width >= 0);
        cr_expect_leq(overlay_text_fit(c.overlay, size, text, 100), (size_t)63);
        overlay_text(c.overlay, 400 * random_unit(&random) - 200, 60, size, 0xffffff, 1, text);
        overlay_text(c.overlay, i % 2 ? 1e300 : (double)NAN, 1e9, size, 0xffffff, 1, text);
        canvas_end(&c);
    }
    canvas_close(&c);
}

// When the image of glyphs is full, what does not fit is missing in that frame; in the next there is room again, for
// glyphs never seen before and for those seen.
Test(overlay, recovers_from_a_full_image) {
    Canvas c;
    canvas_open(&c, 200, 150);
    static const char *const WORDS[] = {"Hx", NULL, "WM", "Hx"};
    double ink[4];
    for (int frame = 0; frame < 4; frame++) {
        canvas_begin(&c, 1);
        for (int i = 0; i < 800 && frame == 1; i++) {
            char letter[] = {(char)(0xc0 | (0x400 + i) >> 6), (char)(0x80 | ((0x400 + i) & 0x3f)), 0};
            overlay_text(c.overlay, 10, 120, FONT_LARGEST, 0xffffff, 1, letter);
        }
        if (frame != 1) overlay_text(c.overlay, 10, 120, 60, 0xffffff, 1, WORDS[frame]);
        canvas_end(&c);
        ink[frame] = covered(&c);
    }
    cr_expect_gt(ink[2], 500);
    cr_expect_float_eq(ink[3], ink[0], 1e-9, "%g pixels are covered, %g were", ink[3], ink[0]);
    canvas_close(&c);
}

// ---- shapes

// Coverage is area: of lines at any angle and width (those of less than a pixel are paler), and of discs.
// Tolerance: a smoothed edge is sampled once a pixel, which is off by a few per cent where it runs along a diagonal.
Test(overlay, coverage_is_area) {
    Canvas c;
    canvas_open(&c, 120, 120);
    Random random = {3};
    for (int i = 0; i < 200; i++) {
        double width = i % 2 ? 0.1 + random_unit(&random) : 1 + 6 * random_unit(&random),
               angle = 7 * random_unit(&random);
        double length = 5 + 40 * random_unit(&random);
        Vec2 a = {60 + random_unit(&random), 60 + random_unit(&random)};
        Vec2 b = vec2_add(a, vec2_scale(vec2(cos(angle), sin(angle)), length));
        canvas_begin(&c, 1);
        overlay_line(c.overlay, a, b, width, 0xffffff, 1);
        canvas_end(&c);
        double drawn = fmax(width, 1),
               expected = (length * drawn + M_PI * drawn * drawn / 4) * fmin(width, 1);
        cr_expect_float_eq(covered(&c), expected, fmax(0.5, 0.04 * expected), "width %g, angle %g: %g of %g",
                           width, angle, covered(&c), expected);
        double radius = 2 + 40 * random_unit(&random), disc = M_PI * radius * radius;
        canvas_begin(&c, 1);
        overlay_circle(c.overlay, a, radius, 0xffffff, 1);
        canvas_end(&c);
        cr_expect_float_eq(covered(&c), disc, fmax(0.5, 0.02 * disc), "radius %g: %g of %g", radius,
                           covered(&c), disc);
    }
    canvas_close(&c);
}

// Rectangles lie on whole pixels and cover these alone; polygons that meet leave no pixel between them and none twice.
Test(overlay, fills_without_seams) {
    Canvas c;
    canvas_open(&c, 100, 100);
    canvas_begin(&c, 1);
    overlay_rectangle(c.overlay, 9.7, 20.2, 30.6, 10.1, 0, 0xffffff, 1);
    canvas_end(&c);
    cr_expect_float_eq(covered(&c), 30 * 10, 0.5, "%g", covered(&c));
    Random random = {11};
    for (int i = 0; i < 50; i++) {
        Vec2 middle = {30 + 40 * random_unit(&random), 30 + 40 * random_unit(&random)};
        Vec2 corner[4] = {{10, 10}, {90, 10}, {90, 90}, {10, 90}};
        canvas_begin(&c, 1);
        for (int k = 0; k < 4; k++) {
            Vec2 piece[3] = {corner[k], corner[(k + 1) % 4], middle};
            overlay_polygon(c.overlay, piece, 3, 0xffffff, 0.5);
        }
        canvas_end(&c);
        for (int y = 0; y < 100; y++) {
            for (int x = 0; x < 100; x++) {
                bool inside = x >= 10 && x < 90 && y >= 10 && y < 90;
                cr_assert_float_eq(pixel(&c, x, y)[0], inside ? 128 : 0, 1.5, "pixel (%d, %d) is %d", x, y,
                                   pixel(&c, x, y)[0]);
            }
        }
    }
    canvas_close(&c);
}

// A polygon of five corners is filled whole: the fan's last piece is there, and no more.
Test(overlay, fills_any_number_of_corners) {
    Canvas c;
    canvas_open(&c, 100, 100);
    for (int count = 3; count < 90; count++) {
        Vec2 p[90];
        for (int i = 0; i < count; i++) {
            double angle = 2 * M_PI * i / count;
            p[i] = vec2(50 + 40 * cos(angle), 50 + 40 * sin(angle));
        }
        OverlayMap map = overlay_map(c.overlay, (Box){{0, 0, 0}, {100, 100, 0}}, 0, 0, 100, 100);
        Draw draw = overlay_map_draw(&map);
        DrawStyle style = {.fill = 0xffffff, .fill_opacity = 1};
        canvas_begin(&c, 1);
        draw.polygon(draw.context, p, count, &style);
        canvas_end(&c);
        double area = count / 2.0 * 1600 * sin(2 * M_PI / count);
        // Whole pixels are counted: those on the outline, 250 pixels long, are in or out.
        cr_expect_float_eq(covered(&c), area, 40, "%d corners: %g of %g", count, covered(&c), area);
    }
    canvas_close(&c);
}

// The later lies over the earlier, whatever either is.
Test(overlay, draws_in_order) {
    Canvas c;
    canvas_open(&c, 60, 40);
    canvas_begin(&c, 1);
    overlay_text(c.overlay, 5, 30, 24, 0xff0000, 1, "HHH");
    overlay_rectangle(c.overlay, 0, 0, 60, 40, 0, 0x00ff00, 1);
    overlay_line(c.overlay, vec2(0, 20), vec2(60, 20), 10, 0x0000ff, 1);
    overlay_polygon(c.overlay, (Vec2[3]){{0, 0}, {20, 0}, {0, 20}}, 3, 0x00ffff, 1);
    canvas_end(&c);
    for (int i = 0; i < 60 * 40; i++) cr_assert_eq(c.rgba[4 * i], 0, "pixel %d shows red", i);
    cr_expect(pixel(&c, 30, 20)[2] == 255 && pixel(&c, 30, 20)[1] == 0);
    cr_expect(pixel(&c, 3, 3)[1] == 255 && pixel(&c, 3, 3)[2] == 255);
    canvas_close(&c);
}

// Nothing shows outside the clip, of anything, through a map or not, at any scale; and something shows inside.
Test(overlay, clips) {
    Canvas c;
    canvas_open(&c, 200, 150);
    Random random = {17};
    for (int i = 0; i < 60; i++) {
        double scale = 1 + random_unit(&random) * 3, x = 10 + random_index(&random, 10),
               y = 5 + random_index(&random, 9);
        double width = 25, height = 20;
        Box area = {{0, 0, 0}, {10, 10, 0}};
        OverlayMap map = overlay_map(c.overlay, area, x, y, width, height);
        Draw draw = overlay_map_draw(&map);
        DrawStyle style = {
            .fill = 0xffffff, .fill_opacity = 1, .stroke = 0xffffff, .width = 1, .dash = i % 2 * 0.5};
        canvas_begin(&c, scale);
        // A shape that is not clipped does not open the clip for those after it.
        overlay_polygon(c.overlay, (Vec2[3]){{0, 0}, {9, 0}, {0, 9}}, 3, 0x0000ff, 1);
        for (int k = 0; k < 20; k++) {
            Vec2 p[3];
            for (int j = 0; j < 3; j++)
                p[j] = vec2(60 * random_unit(&random) - 25, 60 * random_unit(&random) - 25);
            if (k % 4 == 0) draw.line(draw.context, p[0], p[1], &style);
            if (k % 4 == 1) draw.polygon(draw.context, p, 3, &style);
            if (k % 4 == 2) draw.circle(draw.context, p[0], 4, &style);
            if (k % 4 == 3) draw.text(draw.context, p[0], 4, 0xffffff, "clipped text");
        }
        draw.line(draw.context, vec2(-50, 5), vec2(50, 5), &style);
        overlay_line(c.overlay, vec2(0, 0), vec2(200, 150), 1, 0x0000ff, 1);
        canvas_end(&c);
        cr_expect_gt(pixel(&c, 1, 1)[2], 100);
        Ink ink = ink_of(&c);
        cr_expect(ink.x0 >= lround(x * scale) && ink.x1 < lround((x + width) * scale) &&
                      ink.y0 >= lround(y * scale) && ink.y1 < lround((y + height) * scale),
                  "scale %g: ink %d..%d, %d..%d", scale, ink.x0, ink.x1, ink.y0, ink.y1);
        cr_expect_gt(covered(&c), 20);
    }
    canvas_close(&c);
}

// ---- the plan

typedef struct Home {
    Building building;
    CellGraph graph;
    StabForest forest;
} Home;

static void open_home(Home *h, Arena *arena, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, arena, &h->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&h->building, &options, arena, &h->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&h->graph, &options, NULL, arena, &h->forest));
}

static PlanView view_from(const Home *h, Vec3 eye, double yaw) {
    int cell = vis_locate(&h->graph, eye, -1);
    return (PlanView){.graph = &h->graph,
                      .eye = eye,
                      .yaw = yaw,
                      .fov = 1.2,
                      .cell = cell,
                      .storey = plan_view_storey(&h->graph, cell, eye)};
}

// Draws the plan over the whole canvas, ten points to the metre, with the eye in the middle.
static void draw_plan(Canvas *c, const PlanView *view) {
    double x = c->width / 20.0, y = c->height / 20.0;
    Vec3 reach = {x, y, 0};
    Box area = {vec3_sub(view->eye, reach), vec3_add(view->eye, reach)};
    Arena scratch = {0};
    canvas_begin(c, 1);
    OverlayMap map = overlay_map(c->overlay, area, 0, 0, c->width, c->height);
    Draw draw = overlay_map_draw(&map);
    plan_view_draw(view, area, 1 / map.scale, &scratch, &draw);
    canvas_end(c);
    arena_free(&scratch);
}

// The wedge points along yaw, north up: 22 points ahead of the eye it is drawn, to the side and behind it is not.
Test(plan_view, wedge_points_along_yaw) {
    Canvas c;
    canvas_open(&c, 160, 160);
    Home h;
    open_home(&h, &c.arena, "build/maps/house.plan");
    for (int i = 0; i < 12; i++) {
        double yaw = i * M_PI / 6;
        PlanView view = view_from(&h, vec3(3, 3, 1.6), yaw), blind = view;
        blind.fov = 0;  // nothing but rays along yaw
        blind.yaw = yaw + M_PI;
        uint8_t *ahead = ARENA_ARRAY(&c.arena, uint8_t, 160 * 160 * 4);
        draw_plan(&c, &view);
        memcpy(ahead, c.rgba, 160 * 160 * 4);
        draw_plan(&c, &blind);
        for (int turn = 0; turn < 4; turn++) {
            double angle = yaw + turn * M_PI / 2, x = 80 + 22 * cos(angle), y = 80 - 22 * sin(angle);
            const uint8_t *plain = pixel(&c, x, y), *p = ahead + (plain - c.rgba);
            if (turn == 2) continue;  // there lie the rays of the other
            bool changed = abs(p[0] - plain[0]) + abs(p[1] - plain[1]) + abs(p[2] - plain[2]) > 20;
            cr_expect_eq(changed, turn == 0, "yaw %g, %d quarters from ahead: %d,%d,%d for %d,%d,%d", yaw,
                         turn, p[0], p[1], p[2], plain[0], plain[1], plain[2]);
        }
    }
    canvas_close(&c);
}

// Cells in view are blue and others are not; the eye's cell is orange; leaves are where doors stand, in their colours.
Test(plan_view, shows_cells_and_doors) {
    Canvas c;
    canvas_open(&c, 260, 260);
    Home h;
    open_home(&h, &c.arena, "build/maps/two-rooms.plan");
    const Building *b = &h.building;
    int door = 0;
    while (door < b->opening_count && b->openings[door].kind != OPENING_DOOR) door++;
    cr_assert_lt(door, b->opening_count);
    float *open = ARENA_ARRAY(&c.arena, float, b->opening_count);
    int other = -1;
    Vec3 eye = vec3(1, 1, 1.5);
    PlanView view = view_from(&h, eye, 4);
    for (int i = 0; i < h.graph.cell_count; i++) {
        if (i != view.cell && b->regions[h.graph.cells[i].region].kind == REGION_ROOM) other = i;
    }
    cr_assert(other >= 0);
    VisibleCell seen = {.cell = other, .distance = 1};
    VisResult visible = {.cells = &seen, .cell_count = 1};
    Box box = h.graph.cells[other].box;
    // A corner of the other room, away from names; and one beside the eye, outside its wedge.
    Vec2 there = {box.min.x + 0.25 - eye.x, box.min.y + 0.25 - eye.y};
    for (int i = 0; i < 2; i++) {
        view.visible = i ? &visible : NULL;
        draw_plan(&c, &view);
        const uint8_t *p = pixel(&c, 130 + 10 * there.x, 130 - 10 * there.y), *mine = pixel(&c, 136, 124);
        cr_expect_eq(p[2] > p[0] + 80, i == 1, "the other room is %d,%d,%d", p[0], p[1], p[2]);
        cr_expect(mine[0] > mine[2] + 80, "the eye's cell is %d,%d,%d", mine[0], mine[1], mine[2]);
    }
    view.door_open = open;
    const Leaf *leaf = &b->leaves[b->openings[door].first_leaf];
    for (int i = 0; i < 3; i++) {
        open[door] = (float)(i * 0.5);
        draw_plan(&c, &view);
        Vec2 corner[4];
        leaf_box(leaf, open[door], corner);
        Vec2 at = vec2_sub(vec2_scale(vec2_add(corner[1], corner[3]), 0.5), vec2(eye.x, eye.y));
        const uint8_t *p = pixel(&c, 130 + 10 * at.x, 130 - 10 * at.y);
        bool red = p[0] > 180 && p[1]<130, amber = p[0]> 180 && p[1] >= 130, green = p[1] > 150 && p[0] < 160;
        cr_expect(i == 0   ? red
                  : i == 1 ? amber
                           : green,
                  "open by %g: %d,%d,%d", (double)open[door], p[0], p[1], p[2]);
    }
    canvas_close(&c);
}

// The tree is drawn from the eye on, through the middles of the portals of its first level.
Test(plan_view, shows_the_tree) {
    Canvas c;
    canvas_open(&c, 300, 300);
    Home h;
    open_home(&h, &c.arena, "build/maps/house.plan");
    PlanView view = view_from(&h, vec3(3, 3, 1.6), 0);
    int checked = 0, root = h.forest.root[view.cell];
    view.forest = &h.forest;
    draw_plan(&c, &view);
    for (int child = root + 1; child >= 0 && child < h.forest.root[view.cell + 1];
         child = h.forest.nodes[child].next) {
        const Portal *portal = &h.graph.portals[h.forest.nodes[child].portal];
        const Vec3 *v = h.graph.portal_vertices + portal->first_vertex;
        if (portal->horizontal || v[0].z > 1.2 || v[1].z < 1.2) continue;
        Vec2 middle = vec2_scale(vec2_add(portal->left, portal->right), 0.5);
        Vec2 at =
            vec2_scale(vec2_sub(middle, vec2(view.eye.x, view.eye.y)), 0.8 * 10);  // past the wedge's tip
        const uint8_t *p = pixel(&c, 150 + at.x, 150 - at.y);
        cr_expect(p[0] > 180 && p[1] > 150 && p[2] < 140, "on the way to portal %d: %d,%d,%d",
                  h.forest.nodes[child].portal, p[0], p[1], p[2]);
        checked++;
    }
    cr_expect_gt(checked, 2);
    canvas_close(&c);
}

// The storey is that of the room, and outdoors that at the height of the eye. The area holds the eye, the rooms of the
// storey and no more than asked for.
Test(plan_view, shows_the_storey_around_the_eye) {
    Arena arena = {0};
    Home h;
    open_home(&h, &arena, "build/maps/house.plan");
    cr_expect_eq(view_from(&h, vec3(3, 3, 1.6), 0).storey, 0);
    cr_expect_eq(view_from(&h, vec3(3, 3, 4.5), 0).storey, 1);
    cr_expect_eq(view_from(&h, vec3(3, -5, 1.6), 0).storey, 0);
    cr_expect_eq(view_from(&h, vec3(3, -5, 4.5), 0).storey, 1);
    cr_expect_eq(view_from(&h, vec3(3, -5, -0.1), 0).storey, 0);
    PlanView view = view_from(&h, vec3(3, 3, 1.6), 0);
    Box whole = plan_view_area(&view, 1000);
    cr_expect(whole.min.x < 0 && whole.max.x > 13 && whole.min.y < 0 && whole.max.y > 10.6);
    cr_expect(whole.max.x - whole.min.x < 17 && whole.max.y - whole.min.y < 15, "the garden is not wanted");
    Random random = {8};
    for (int i = 0; i < 200; i++) {
        view.eye = vec3(40 * random_unit(&random) - 12, 40 * random_unit(&random) - 12, 1.6);
        double most = 4 + 12 * random_unit(&random);
        Box area = plan_view_area(&view, most);
        cr_expect(area.max.x - area.min.x <= most + 1e-9 && area.max.y - area.min.y <= most + 1e-9);
        cr_expect(area.min.x <= view.eye.x && view.eye.x <= area.max.x && area.min.y <= view.eye.y &&
                  view.eye.y <= area.max.y);
    }
    arena_free(&arena);
}

// A place for a name is inside the region and the area with all its outline; and one is found where there is room.
Test(figure, names_stay_in_their_rooms) {
    Arena arena = {0};
    Home h;
    open_home(&h, &arena, "build/maps/house.plan");
    Random random = {2};
    int found = 0;
    for (int i = 0; i < 4000; i++) {
        int r = random_index(&random, h.building.region_count);
        if (h.building.regions[r].kind != REGION_ROOM) continue;
        double width = 0.2 + 3 * random_unit(&random), height = 0.1 + 2 * random_unit(&random);
        double left = -5 + 17 * random_unit(&random), low = -5 + 14 * random_unit(&random);
        Box area = {{left, low, 0}, {left + 9, low + 9, 0}};
        Vec2 at;
        if (!figure_name_place(&h.building, r, area, width, height, &at)) continue;
        found++;
        double z = (h.building.regions[r].z0 + h.building.regions[r].z1) / 2;
        for (int k = 0; k < 9; k++) {
            // A millimetre within, where all is decided.
            Vec3 p = {at.x + (k % 3 - 1) * (width / 2 - 0.001), at.y + (k / 3 - 1) * (height / 2 - 0.001), z};
            int cell = vis_locate(&h.graph, p, -1);
            cr_assert(cell >= 0 && h.graph.cells[cell].region == r, "region %d: (%g, %g) is outside", r, p.x,
                      p.y);
            cr_assert(p.x >= area.min.x && p.x <= area.max.x && p.y >= area.min.y && p.y <= area.max.y);
        }
    }
    cr_expect_gt(found, 100, "%d places found", found);
    arena_free(&arena);
}

// The same of a room with a corner cut out, where a rectangle can lie across the cut with its middle inside.
Test(figure, names_stay_in_crooked_rooms) {
    Vec2 points[] = {{0, 0}, {4, 0}, {4, 1.5}, {1.5, 1.5}, {1.5, 4}, {0, 4}};
    Ring ring = {.first_point = 0, .point_count = 6};
    Region region = {.kind = REGION_ROOM, .ring_count = 1};
    Building building = {.regions = &region, .rings = &ring, .points = points};
    Random random = {4};
    int found = 0;
    for (int i = 0; i < 5000; i++) {
        double width = 0.1 + 2 * random_unit(&random), height = 0.1 + 2 * random_unit(&random);
        Vec2 low = {3 * random_unit(&random) - 1, 3 * random_unit(&random) - 1};
        Box area = {{low.x, low.y, 0}, {low.x + 3.5, low.y + 3.5, 0}};
        Vec2 at;
        if (!figure_name_place(&building, 0, area, width, height, &at)) continue;
        found++;
        Vec2 far = {at.x + width / 2 - 1e-9, at.y + height / 2 - 1e-9};
        bool inside = at.x - width / 2 > -1e-9 && at.y - height / 2 > -1e-9 && far.x < 4 && far.y < 4;
        cr_assert(inside && (far.x < 1.5 || far.y < 1.5), "%g x %g m at (%g, %g)", width, height, at.x, at.y);
    }
    cr_expect_gt(found, 1000, "%d places found", found);
}

// ---- all together

static const HudKey HELP[] = {{"W A S D", "walk"}, {"E", "open or close the door"}, {"H", "help"}};
static const char *const FLAGS[] = {"frozen",    "flight", "culling off", "wireframe",
                                    "stab tree", "replay", "slow"};

static const HudLegend LEGEND = {FALSE_COLOUR_ILLUMINANCE, {5, 5000}};

static HudState full_state(const PlanView *plan, const HudFigures *figures, Arena *scratch) {
    return (HudState){.figures = figures,
                      .help = HELP,
                      .help_count = 3,
                      .flags = FLAGS,
                      .flag_count = 7,
                      .recording = true,
                      .message =
                          "Tür zum Garten: leads nowhere, since the room behind it is not enclosed\nby walls",
                      .message_is_error = true,
                      .prompt_key = "E",
                      .prompt = "open salon",
                      .plan = plan,
                      .legend = &LEGEND,
                      .crosshair = true,
                      .scratch = scratch};
}

// Windows of any size and scale: nothing fails; where there is room something is drawn; and from the second frame on the
// overlay takes no more memory.
Test(hud, fits_any_window) {
    static const struct {
        int width, height;
        double scale;
    } SIZES[] = {{1, 1, 1},     {1, 1, 4},       {3, 200, 1},    {200, 100, 1},
                 {640, 360, 1}, {640, 360, 3.3}, {1280, 720, 2}, {900, 31, 1}};
    for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
        Canvas c;
        canvas_open(&c, SIZES[i].width, SIZES[i].height);
        Home h;
        open_home(&h, &c.arena, "build/maps/house.plan");
        Arena scratch = {0};
        PlanView plan = view_from(&h, vec3(3, 3, 1.6), 1);
        plan.forest = &h.forest;
        HudFigures figures = {"stab trees", 5,  65,       223,      3187,     24,
                              21,           47, plan.eye, "living", "ground", "43 %, +0.5 stops"};
        HudState state = full_state(&plan, &figures, &scratch);
        size_t used = 0;
        for (int frame = 0; frame < 4; frame++) {
            arena_reset(&scratch);
            state.help = frame == 2 ? NULL : HELP;
            canvas_begin(&c, SIZES[i].scale);
            hud_draw(c.overlay, &state);
            canvas_end(&c);
            if (frame == 1) used = c.arena.used;
        }
        cr_expect_eq(c.arena.used, used, "%zu bytes more in two frames", c.arena.used - used);
        if (SIZES[i].height >= 100 && SIZES[i].width >= 200)
            cr_expect_gt(covered(&c), 20, "%d x %d", SIZES[i].width, SIZES[i].height);
        arena_free(&scratch);
        canvas_close(&c);
    }
}

// A message is there, fades, and is gone; an error stays longer.
Test(hud, messages_fade) {
    Canvas c;
    canvas_open(&c, 400, 100);
    double seen[2][3];
    for (int i = 0; i < 6; i++) {
        Arena scratch = {0};
        double end = i < 3 ? HUD_MESSAGE_SECONDS : HUD_ERROR_SECONDS, ages[] = {0, end - 0.5, end};
        HudState state = {.message = "Picture saved",
                          .message_is_error = i >= 3,
                          .message_age = ages[i % 3],
                          .scratch = &scratch};
        canvas_begin(&c, 1);
        hud_draw(c.overlay, &state);
        canvas_end(&c);
        seen[i / 3][i % 3] = covered(&c);
        arena_free(&scratch);
    }
    for (int i = 0; i < 2; i++) {
        cr_expect(seen[i][0] > 1.5 * seen[i][1] && seen[i][1] > 20 && seen[i][2] == 0, "%g, %g, %g",
                  seen[i][0], seen[i][1], seen[i][2]);
    }
    canvas_close(&c);
}

// A long message is broken into lines that stay within the window.
Test(hud, messages_are_wrapped, .timeout = 60) {
    Canvas c;
    canvas_open(&c, 240, 200);
    Arena scratch = {0};
    HudState state = {
        .message = "averyveryveryverylongwordwithoutanyspaceatallinit and then a number of shorter words, "
                   "so many that some lines are needed for all of them",
        .scratch = &scratch};
    canvas_begin(&c, 1);
    hud_draw(c.overlay, &state);
    canvas_end(&c);
    Ink ink = ink_of(&c);
    cr_expect(ink.x0 >= 12 && ink.x1 < 240 - 12 && ink.y1 < 200 - 12, "%d..%d, ..%d", ink.x0, ink.x1, ink.y1);
    cr_expect_gt(ink.y1 - ink.y0, 60, "%d rows of text", ink.y1 - ink.y0);
    arena_free(&scratch);
    canvas_close(&c);
}
