// test_overlay.c - text, shapes and plans over a frame: they cover what they should and nothing else, whatever the text,
// the size of the window and its scale.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "tests/overlay/overlay_fixture.h"
#include "visibility/prepare/figure.h"

// ---- text

// Letters stand on the baseline, start at x, and are as high as capitals are, at each scale.
// Tolerance: a pixel, for side bearings, smoothed edges and the height of small letters being whole pixels.
Test(overlay, text_lands_where_asked) {
    Canvas c;
    overlay_check_canvas_open(&c, 320, 240);
    for (int scale = 1; scale <= 3; scale++) {
        double size = 24, x = 20, baseline = 60;
        overlay_check_canvas_begin(&c, scale);
        overlay_text(c.overlay, x, baseline, size, 0xffffff, 1, "HEH");
        overlay_check_canvas_end(&c);
        Ink ink = overlay_check_ink_of(&c);
        cr_expect_eq(ink.y1, (int)baseline * scale - 1, "scale %d: the last row is %d", scale, ink.y1);
        cr_expect_float_eq(ink.y0, (baseline - OVERLAY_CAPITALS * size) * scale, 1.5 * scale,
                           "scale %d: the first row is %d", scale, ink.y0);
        // An H starts a tenth of the em right of its pen.
        cr_expect_float_eq(ink.x0, (x + 0.1 * size) * scale, 1.0 * scale, "scale %d: the first column is %d",
                           scale, ink.x0);
    }
    overlay_check_canvas_close(&c);
}

// The width promised is where the next letter would stand: a second text put there does not touch the first, and the
// ink of a long text is as wide as promised but for the bearings of its ends (a tenth of the em each, and a pixel).
Test(overlay, width_matches_ink) {
    static const char *const TEXTS[] = {"HHHHHHHH", "Salon d'été", "Wohnküche", "AVAVAVA", "кухня и холл"};
    Canvas c;
    overlay_check_canvas_open(&c, 400, 60);
    for (int i = 0; i < 5; i++) {
        for (double size = 10; size < 34; size += 5.5) {
            overlay_check_canvas_begin(&c, 1);
            double width = overlay_text_width(c.overlay, size, TEXTS[i]);
            overlay_text(c.overlay, 10, 40, size, 0xffffff, 1, TEXTS[i]);
            overlay_check_canvas_end(&c);
            Ink ink = overlay_check_ink_of(&c);
            cr_expect_float_eq(ink.x1 + 1 - ink.x0, width - 0.1 * size, 0.1 * size + 1.5,
                               "`%s` at %g: ink %d to %d, width %g", TEXTS[i], size, ink.x0, ink.x1, width);
            cr_expect_geq(10 + width, ink.x1 - 1, "`%s` at %g", TEXTS[i], size);
        }
    }
    overlay_check_canvas_close(&c);
}

// A text that is cut to fit is as long as it can be: one character more is too wide.
Test(overlay, fits_as_much_as_there_is_room_for) {
    Canvas c;
    overlay_check_canvas_open(&c, 64, 64);
    const char *text = "Größe: дом, zażółć gęślą jaźń";
    overlay_check_canvas_begin(&c, 1);
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
    overlay_check_canvas_end(&c);
    overlay_check_canvas_close(&c);
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
    overlay_check_canvas_open(&c, 200, 50);
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
        overlay_check_canvas_begin(&c, 1 + random_index(&random, 4));
        double size = exp(8 * random_unit(&random) - 3), width = overlay_text_width(c.overlay, size, text);
        cr_expect(isfinite(width) && width >= 0);
        cr_expect_leq(overlay_text_fit(c.overlay, size, text, 100), (size_t)63);
        overlay_text(c.overlay, 400 * random_unit(&random) - 200, 60, size, 0xffffff, 1, text);
        overlay_text(c.overlay, i % 2 ? 1e300 : (double)NAN, 1e9, size, 0xffffff, 1, text);
        overlay_check_canvas_end(&c);
    }
    overlay_check_canvas_close(&c);
}

// When the image of glyphs is full, what does not fit is missing in that frame; in the next there is room again, for
// glyphs never seen before and for those seen.
Test(overlay, recovers_from_a_full_image) {
    Canvas c;
    overlay_check_canvas_open(&c, 200, 150);
    static const char *const WORDS[] = {"Hx", NULL, "WM", "Hx"};
    double ink[4];
    for (int frame = 0; frame < 4; frame++) {
        overlay_check_canvas_begin(&c, 1);
        for (int i = 0; i < 800 && frame == 1; i++) {
            char letter[] = {(char)(0xc0 | (0x400 + i) >> 6), (char)(0x80 | ((0x400 + i) & 0x3f)), 0};
            overlay_text(c.overlay, 10, 120, FONT_LARGEST, 0xffffff, 1, letter);
        }
        if (frame != 1) overlay_text(c.overlay, 10, 120, 60, 0xffffff, 1, WORDS[frame]);
        overlay_check_canvas_end(&c);
        ink[frame] = overlay_check_covered(&c);
    }
    cr_expect_gt(ink[2], 500);
    cr_expect_float_eq(ink[3], ink[0], 1e-9, "%g pixels are covered, %g were", ink[3], ink[0]);
    overlay_check_canvas_close(&c);
}
