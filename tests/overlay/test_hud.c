// test_hud.c - the figures, keys and messages over a walk.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "tests/overlay/overlay_fixture.h"
#include "visibility/prepare/figure.h"

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
        overlay_check_canvas_open(&c, SIZES[i].width, SIZES[i].height);
        Home h;
        overlay_check_open_home(&h, &c.arena, "build/maps/house.plan");
        Arena scratch = {0};
        PlanView plan = overlay_check_view_from(&h, vec3(3, 3, 1.6), 1);
        plan.forest = &h.forest;
        HudFigures figures = {"stab trees", 5,  65,       223,      3187,     24,
                              21,           47, plan.eye, "living", "ground", "43 %, +0.5 stops"};
        HudState state = full_state(&plan, &figures, &scratch);
        size_t used = 0;
        for (int frame = 0; frame < 4; frame++) {
            arena_reset(&scratch);
            state.help = frame == 2 ? NULL : HELP;
            overlay_check_canvas_begin(&c, SIZES[i].scale);
            hud_draw(c.overlay, &state);
            overlay_check_canvas_end(&c);
            if (frame == 1) used = c.arena.used;
        }
        cr_expect_eq(c.arena.used, used, "%zu bytes more in two frames", c.arena.used - used);
        if (SIZES[i].height >= 100 && SIZES[i].width >= 200)
            cr_expect_gt(overlay_check_covered(&c), 20, "%d x %d", SIZES[i].width, SIZES[i].height);
        arena_free(&scratch);
        overlay_check_canvas_close(&c);
    }
}

// A message is there, fades, and is gone; an error stays longer.
Test(hud, messages_fade) {
    Canvas c;
    overlay_check_canvas_open(&c, 400, 100);
    double seen[2][3];
    for (int i = 0; i < 6; i++) {
        Arena scratch = {0};
        double end = i < 3 ? HUD_MESSAGE_SECONDS : HUD_ERROR_SECONDS, ages[] = {0, end - 0.5, end};
        HudState state = {.message = "Picture saved",
                          .message_is_error = i >= 3,
                          .message_age = ages[i % 3],
                          .scratch = &scratch};
        overlay_check_canvas_begin(&c, 1);
        hud_draw(c.overlay, &state);
        overlay_check_canvas_end(&c);
        seen[i / 3][i % 3] = overlay_check_covered(&c);
        arena_free(&scratch);
    }
    for (int i = 0; i < 2; i++) {
        cr_expect(seen[i][0] > 1.5 * seen[i][1] && seen[i][1] > 20 && seen[i][2] == 0, "%g, %g, %g",
                  seen[i][0], seen[i][1], seen[i][2]);
    }
    overlay_check_canvas_close(&c);
}

// A long message is broken into lines that stay within the window.
Test(hud, messages_are_wrapped, .timeout = 60) {
    Canvas c;
    overlay_check_canvas_open(&c, 240, 200);
    Arena scratch = {0};
    HudState state = {
        .message = "averyveryveryverylongwordwithoutanyspaceatallinit and then a number of shorter words, "
                   "so many that some lines are needed for all of them",
        .scratch = &scratch};
    overlay_check_canvas_begin(&c, 1);
    hud_draw(c.overlay, &state);
    overlay_check_canvas_end(&c);
    Ink ink = overlay_check_ink_of(&c);
    cr_expect(ink.x0 >= 12 && ink.x1 < 240 - 12 && ink.y1 < 200 - 12, "%d..%d, ..%d", ink.x0, ink.x1, ink.y1);
    cr_expect_gt(ink.y1 - ink.y0, 60, "%d rows of text", ink.y1 - ink.y0);
    arena_free(&scratch);
    overlay_check_canvas_close(&c);
}

static const HudKey HINT[] = {{"click", "to look around"}, {"E", "open a door"}, {"H", "all keys"}};

// The hint is there, fades, and stays within the window, in which it is broken into rows.
Test(hud, hint_fades_and_fits) {
    static const int WIDTHS[] = {640, 220};
    for (int k = 0; k < 2; k++) {
        Canvas c;
        overlay_check_canvas_open(&c, WIDTHS[k], 300);
        double seen[3];
        for (int i = 0; i < 3; i++) {
            Arena scratch = {0};
            HudState state = {
                .hint = HINT, .hint_count = 3, .hint_opacity = 1 - i / 2.0, .scratch = &scratch};
            overlay_check_canvas_begin(&c, 1);
            hud_draw(c.overlay, &state);
            overlay_check_canvas_end(&c);
            seen[i] = overlay_check_covered(&c);
            Ink ink = overlay_check_ink_of(&c);
            if (i == 0)
                cr_expect(ink.x0 >= 12 && ink.x1 < WIDTHS[k] - 12 && ink.y1 < 300 - 12, "%d..%d, ..%d",
                          ink.x0, ink.x1, ink.y1);
            arena_free(&scratch);
        }
        cr_expect(seen[0] > 1.5 * seen[1] && seen[1] > 20 && seen[2] == 0, "%d: %g, %g, %g", WIDTHS[k],
                  seen[0], seen[1], seen[2]);
        overlay_check_canvas_close(&c);
    }
}

// Proves that the whole help shows at every scale of text: twenty long rows in a window of 1280 x 720 cover at least what they cover
// where letters are at least eight pixels high, and stay within the window.
Test(hud, help_fits_every_scale) {
    static const double SCALES[] = {0.5, 1, 1.5, 2, 3, 4, 6};
    HudKey rows[20];
    for (int i = 0; i < 20; i++)
        rows[i] = (HudKey){"Page up, down", "light in false colours: radiosity, irradiance, illuminance"};
    for (size_t i = 0; i < sizeof SCALES / sizeof *SCALES; i++) {
        Canvas c;
        Arena scratch = {0};
        overlay_check_canvas_open(&c, 1280, 720);
        HudState state = {.help = rows, .help_count = 20, .scratch = &scratch};
        overlay_check_canvas_begin(&c, SCALES[i]);
        hud_draw(c.overlay, &state);
        overlay_check_canvas_end(&c);
        Ink ink = overlay_check_ink_of(&c);
        cr_expect_gt(overlay_check_covered(&c), 1000, "scale %g: %g", SCALES[i], overlay_check_covered(&c));
        cr_expect(ink.x0 > 0 && ink.y0 > 0 && ink.x1 < 1280 && ink.y1 < 720, "scale %g", SCALES[i]);
        arena_free(&scratch);
        overlay_check_canvas_close(&c);
    }
}
