// test_overlay_shapes.c - shapes of the overlay cover their area, in order, within their clip.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "tests/overlay/overlay_fixture.h"
#include "visibility/prepare/figure.h"

// ---- shapes

// Coverage is area: of lines at any angle and width (those of less than a pixel are paler), and of discs.
// Tolerance: a smoothed edge is sampled once a pixel, which is off by a few per cent where it runs along a diagonal.
Test(overlay, coverage_is_area) {
    Canvas c;
    overlay_check_canvas_open(&c, 120, 120);
    Random random = {3};
    for (int i = 0; i < 200; i++) {
        double width = i % 2 ? 0.1 + random_unit(&random) : 1 + 6 * random_unit(&random),
               angle = 7 * random_unit(&random);
        double length = 5 + 40 * random_unit(&random);
        Vec2 a = {60 + random_unit(&random), 60 + random_unit(&random)};
        Vec2 b = vec2_add(a, vec2_scale(vec2(cos(angle), sin(angle)), length));
        overlay_check_canvas_begin(&c, 1);
        overlay_line(c.overlay, a, b, width, 0xffffff, 1);
        overlay_check_canvas_end(&c);
        double drawn = fmax(width, 1),
               expected = (length * drawn + M_PI * drawn * drawn / 4) * fmin(width, 1);
        cr_expect_float_eq(overlay_check_covered(&c), expected, fmax(0.5, 0.04 * expected),
                           "width %g, angle %g: %g of %g", width, angle, overlay_check_covered(&c), expected);
        double radius = 2 + 40 * random_unit(&random), disc = M_PI * radius * radius;
        overlay_check_canvas_begin(&c, 1);
        overlay_circle(c.overlay, a, radius, 0xffffff, 1);
        overlay_check_canvas_end(&c);
        cr_expect_float_eq(overlay_check_covered(&c), disc, fmax(0.5, 0.02 * disc), "radius %g: %g of %g",
                           radius, overlay_check_covered(&c), disc);
    }
    overlay_check_canvas_close(&c);
}

// Rectangles lie on whole pixels and cover these alone; polygons that meet leave no pixel between them and none twice.
Test(overlay, fills_without_seams) {
    Canvas c;
    overlay_check_canvas_open(&c, 100, 100);
    overlay_check_canvas_begin(&c, 1);
    overlay_rectangle(c.overlay, 9.7, 20.2, 30.6, 10.1, 0, 0xffffff, 1);
    overlay_check_canvas_end(&c);
    cr_expect_float_eq(overlay_check_covered(&c), 30 * 10, 0.5, "%g", overlay_check_covered(&c));
    Random random = {11};
    for (int i = 0; i < 50; i++) {
        Vec2 middle = {30 + 40 * random_unit(&random), 30 + 40 * random_unit(&random)};
        Vec2 corner[4] = {{10, 10}, {90, 10}, {90, 90}, {10, 90}};
        overlay_check_canvas_begin(&c, 1);
        for (int k = 0; k < 4; k++) {
            Vec2 piece[3] = {corner[k], corner[(k + 1) % 4], middle};
            overlay_polygon(c.overlay, piece, 3, 0xffffff, 0.5);
        }
        overlay_check_canvas_end(&c);
        for (int y = 0; y < 100; y++) {
            for (int x = 0; x < 100; x++) {
                bool inside = x >= 10 && x < 90 && y >= 10 && y < 90;
                cr_assert_float_eq(overlay_check_pixel(&c, x, y)[0], inside ? 128 : 0, 1.5,
                                   "pixel (%d, %d) is %d", x, y, overlay_check_pixel(&c, x, y)[0]);
            }
        }
    }
    overlay_check_canvas_close(&c);
}

// A polygon of five corners is filled whole: the fan's last piece is there, and no more.
Test(overlay, fills_any_number_of_corners) {
    Canvas c;
    overlay_check_canvas_open(&c, 100, 100);
    for (int count = 3; count < 90; count++) {
        Vec2 p[90];
        for (int i = 0; i < count; i++) {
            double angle = 2 * M_PI * i / count;
            p[i] = vec2(50 + 40 * cos(angle), 50 + 40 * sin(angle));
        }
        OverlayMap map = overlay_map(c.overlay, (Box){{0, 0, 0}, {100, 100, 0}}, 0, 0, 100, 100);
        Draw draw = overlay_map_draw(&map);
        DrawStyle style = {.fill = 0xffffff, .fill_opacity = 1};
        overlay_check_canvas_begin(&c, 1);
        draw.polygon(draw.context, p, count, &style);
        overlay_check_canvas_end(&c);
        double area = count / 2.0 * 1600 * sin(2 * M_PI / count);
        // Whole pixels are counted: those on the outline, 250 pixels long, are in or out.
        cr_expect_float_eq(overlay_check_covered(&c), area, 40, "%d corners: %g of %g", count,
                           overlay_check_covered(&c), area);
    }
    overlay_check_canvas_close(&c);
}

// The later lies over the earlier, whatever either is.
Test(overlay, draws_in_order) {
    Canvas c;
    overlay_check_canvas_open(&c, 60, 40);
    overlay_check_canvas_begin(&c, 1);
    overlay_text(c.overlay, 5, 30, 24, 0xff0000, 1, "HHH");
    overlay_rectangle(c.overlay, 0, 0, 60, 40, 0, 0x00ff00, 1);
    overlay_line(c.overlay, vec2(0, 20), vec2(60, 20), 10, 0x0000ff, 1);
    overlay_polygon(c.overlay, (Vec2[3]){{0, 0}, {20, 0}, {0, 20}}, 3, 0x00ffff, 1);
    overlay_check_canvas_end(&c);
    for (int i = 0; i < 60 * 40; i++) cr_assert_eq(c.rgba[4 * i], 0, "pixel %d shows red", i);
    cr_expect(overlay_check_pixel(&c, 30, 20)[2] == 255 && overlay_check_pixel(&c, 30, 20)[1] == 0);
    cr_expect(overlay_check_pixel(&c, 3, 3)[1] == 255 && overlay_check_pixel(&c, 3, 3)[2] == 255);
    overlay_check_canvas_close(&c);
}

// Nothing shows outside the clip, of anything, through a map or not, at any scale; and something shows inside.
Test(overlay, clips) {
    Canvas c;
    overlay_check_canvas_open(&c, 200, 150);
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
        overlay_check_canvas_begin(&c, scale);
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
        overlay_check_canvas_end(&c);
        cr_expect_gt(overlay_check_pixel(&c, 1, 1)[2], 100);
        Ink ink = overlay_check_ink_of(&c);
        cr_expect(ink.x0 >= lround(x * scale) && ink.x1 < lround((x + width) * scale) &&
                      ink.y0 >= lround(y * scale) && ink.y1 < lround((y + height) * scale),
                  "scale %g: ink %d..%d, %d..%d", scale, ink.x0, ink.x1, ink.y0, ink.y1);
        cr_expect_gt(overlay_check_covered(&c), 20);
    }
    overlay_check_canvas_close(&c);
}
