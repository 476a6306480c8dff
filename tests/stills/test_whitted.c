// test_whitted.c - stills: Fresnel and Snell, what a ray is inside of, lamps in closed form against sums, and rooms in which glass
// and mirrors cannot be seen.
#include <criterion/criterion.h>

#include "engine/stills/still.h"
#include "tests/support/fixture.h"

// Fresnel at right angles is ((n - 1) / (n + 1))^2: air to glass, water and diamond; nothing is reflected at Brewster's angle of
// the light that swings within the plane, so half of the rest; beyond the critical angle all is.
Test(whitted, fresnel) {
    cr_expect_float_eq(glass_fresnel(1, 1.5), 0.04, 1e-15);
    cr_expect_float_eq(glass_fresnel(1, 1 / 1.5), 0.04, 1e-15);
    cr_expect_float_eq(glass_fresnel(1, 1.33), 0.0200593122, 1e-9);
    cr_expect_float_eq(glass_fresnel(1, 2.42), 0.1723949249, 1e-9);
    double brewster = cos(atan(1.5)), across = (1 - 2.25) / (1 + 2.25);
    cr_expect_float_eq(glass_fresnel(brewster, 1.5), 0.5 * across * across, 1e-12);
    cr_expect_eq(glass_fresnel(0.5, 1 / 1.5), 1, "total reflection");
    cr_expect_float_eq(glass_fresnel(1e-9, 1.5), 1, 1e-7, "grazing");
    cr_expect_float_eq(glass_fresnel(0.3, 1), 0, 1e-15, "nothing to see");
    cr_expect_float_eq(glass_sheet(1, 1.5), 0.08 / 1.04, 1e-12);
}

// Snell's law, and the way back is the way there.
Test(whitted, refraction) {
    Random random = {3};
    Vec3 n = vec3(0, 0, 1);
    int total = 0;
    for (int i = 0; i < 10000; i++) {
        Vec3 d = fixture_direction(&random), out, back;
        double ratio = random_between(&random, 0.4, 2.5);
        if (d.z >= -1e-3) continue;
        bool through = glass_refract(d, n, ratio, &out);
        double sine = sqrt(d.x * d.x + d.y * d.y) / ratio;
        cr_assert_eq(through, sine < 1);
        total += !through;
        if (!through || sine > 1 - 1e-6) continue;
        cr_assert_float_eq(sqrt(out.x * out.x + out.y * out.y), sine, 1e-12);
        cr_assert(glass_refract(vec3_scale(out, -1), vec3(0, 0, -1), 1 / ratio, &back));
        cr_assert_float_eq(vec3_length(vec3_add(back, d)), 0, 1e-7);
    }
    cr_expect_gt(total, 500);
}

// Bodies are left in any order; a stack that is full stays as it is.
Test(whitted, media) {
    Media media = {0};
    cr_expect_eq(media_index(&media), 1);
    media = media_enter(&media, 1, 1.5);
    media = media_enter(&media, 2, 1.33);
    cr_expect_eq(media_index(&media), 1.33);
    Media left = media_leave(&media, 1);
    cr_expect_eq(media_index(&left), 1.33);
    left = media_leave(&left, 2);
    cr_expect_eq(media_index(&left), 1);
    left = media_leave(&left, 7);
    cr_expect_eq(left.count, 0);
    for (int i = 0; i < 3 * MEDIA_MOST; i++) media = media_enter(&media, i, 2);
    cr_expect_eq(media.count, MEDIA_MOST);
}

// The share of a ball by its closed form, against a sum over the directions of its cone. Tolerance: of the sum, a thousand by a
// thousand directions.
Test(whitted, ball_in_closed_form) {
    for (int k = 0; k <= 40; k++) {
        double far = k % 2 ? 1.05 : 3, angle = M_PI * k / 40, sum = 0, edge = sqrt(1 - 1 / (far * far));
        Vec3 n = vec3(sin(angle), 0, cos(angle)), to = vec3(0, 0, 2 * far);
        enum { STEPS = 1000 };
        for (int i = 0; i < STEPS; i++)
            for (int j = 0; j < STEPS; j++) {
                double cosine = 1 - (i + 0.5) / STEPS * (1 - edge), turn = 2 * M_PI * (j + 0.5) / STEPS;
                double ahead = n.z * cosine + n.x * sqrt(1 - cosine * cosine) * cos(turn);
                sum += fmax(ahead, 0) * 2 * (1 - edge) / ((double)STEPS * STEPS);
            }
        cr_expect_float_eq(still_ball_share(n, to, 2), sum, 2e-6, "at %g, %g: %g", far, angle,
                           still_ball_share(n, to, 2));
    }
}
