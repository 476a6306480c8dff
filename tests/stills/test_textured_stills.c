// test_textured_stills.c - stills show pictures where they lie.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/stills/still_sky.h"
#include "engine/stills/whitted.h"
#include "tests/support/lit_fixture.h"

// Irradiance everywhere, W/m^2.
static const double ARRIVES = 4;

// A picture of fields, one copy every two metres of the plane: five by three colours, unlike each other and not alike turned or mirrored.
enum { ACROSS = 5, DOWN = 3, FIELD = 16 };
static uint8_t code_of(int field) { return (uint8_t)(60 + 12 * field); }
static int add_fields(Lit *lit, int alpha_of_odd) {
    static uint8_t texels[ACROSS * FIELD * DOWN * FIELD * 4];
    for (int i = 0; i < ACROSS * FIELD * DOWN * FIELD; i++) {
        int field = i % (ACROSS * FIELD) / FIELD + ACROSS * (i / (ACROSS * FIELD) / FIELD);
        memset(texels + 4 * i, code_of(field), 3);
        texels[4 * i + 3] = (uint8_t)(field % 2 ? alpha_of_odd : 255);
    }
    TextureMap map = {{0.5, 0, 0}, {0, -0.5, 0}, 0.1, 0.3};
    return lit_picture(lit, ACROSS * FIELD, DOWN * FIELD, texels, map);
}

// The field at a point of the plane, and how far the nearest edge of a field is, metres.
static int field_at(Vec3 p, double *edge) {
    double u = 0.5 * p.x + 0.1, v = -0.5 * p.y + 0.3;
    u = (u - floor(u)) * ACROSS, v = (v - floor(v)) * DOWN;
    double du = fabs(u - round(u)) * 2 / ACROSS, dv = fabs(v - round(v)) * 2 / DOWN;
    *edge = fmin(du, dv);
    return (int)u + ACROSS * (int)v;
}

typedef struct Seen {
    StillScene *scene;
    StillLight light;
    Whitted whitted;
    Media media;
} Seen;

// Every element reflects its share of the same irradiance.
static Seen see(Lit *lit, double spread) {
    RadSolution s;
    Error error;
    lit_finish(lit, 0.5, 2);
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, &s, &error), "%s", error.text);
    for (int e = 0; e < lit->mesh.element_count; e++) {
        double rho[3];
        rgb_doubles(mesh_reflectance(&lit->mesh, e), rho);
        for (int c = 0; c < 3; c++) s.radiosity[e][c] = rho[c] * ARRIVES;
    }
    Seen v = {.scene = still_scene_new(&lit->mesh, NULL, STILL_TREE_OWN, &lit->arena)};
    v.light = still_light_new(v.scene, &s, NULL, &lit->arena);
    v.whitted = (Whitted){.scene = v.scene, .depth = 12, .threshold = 1.0 / 512, .spread = spread};
    return v;
}

static double trace(Seen *v, Vec3 eye, Vec3 towards) {
    Ray ray = {eye, vec3_normalize(vec3_sub(towards, eye)), 0, INFINITY};
    WhittedWork work = {0};
    double out[3];
    v->whitted.light = &v->light;
    whitted_trace(&v->whitted, &ray, &v->media, 7, 0, &work, out);
    return out[1];
}

static Lit *floor_room(void) {
    Lit *lit = lit_new();
    int fields = add_fields(lit, 255);
    int mirror = building_add_material(&lit->arena, lit->building,
                                       (Material){.name = "mirror", .alpha = 1, .mirror = 1});
    lit_quad(lit, vec3(0, 0, 0), vec3(6, 0, 0), vec3(6, 6, 0), vec3(0, 6, 0), fields);
    lit_quad(lit, vec3(6, 0, 0), vec3(6, 0, 3), vec3(6, 6, 3), vec3(6, 6, 0), mirror);
    return lit;
}

// Proves that a still shows the texel that the map says: the width of a pixel away from an edge of a field the field's own colour, seen
// straight and in a mirror. Tolerance: single precision; texels are read between four, so a texel of 2.5 cm more counts as edge.
Test(textured_stills, texels_where_the_map_says) {
    Lit *lit = floor_room();
    const double SPREAD = 0.002, TEXEL = 2.0 / (DOWN * FIELD);
    Seen v = see(lit, SPREAD);
    Random random = {9};
    int looked = 0;
    for (int i = 0; i < 4000; i++) {
        Vec3 at = vec3(random_between(&random, 0.1, 5.9), random_between(&random, 0.1, 5.9), 0);
        bool mirrored = i % 2 == 1;
        Vec3 eye = vec3(3, 3, 1.6), seen = mirrored ? vec3(12 - at.x, at.y, 0) : at;
        Vec3 way = vec3_sub(seen, eye);
        double edge, distance = vec3_length(way), cosine = -way.z / distance;
        // The ray must meet the mirror above the floor.
        int field = field_at(at, &edge);
        if (edge < TEXEL + 2 * SPREAD * distance / cosine) continue;
        looked++;
        double want = ARRIVES * (double)maps_linear(code_of(field));
        double got = trace(&v, eye, seen);
        cr_assert_float_eq(got, want, 1e-5 * want, "field %d at (%g, %g), mirrored %d: %g, not %g", field,
                           at.x, at.y, mirrored, got, want);
    }
    cr_expect_gt(looked, 1000, "%d", looked);
    lit_free(lit);
}

// Proves that pictures are averaged over a pixel: from so far that a pixel holds several copies every ray shows the mean. Tolerance: the
// rounding of the smallest levels to codes.
Test(textured_stills, the_mean_from_afar) {
    Lit *lit = floor_room();
    Seen v = see(lit, 0.05);
    Vec3 eye = vec3(3, 3, 100);
    double mean = ARRIVES * (double)lit->building->textures[1].mean.g;
    for (int i = 0; i < 50; i++) {
        double got = trace(&v, eye, vec3(0.3 + 0.1 * i, 5 - 0.07 * i, 0));
        cr_expect_float_eq(got, mean, 0.01 * mean, "%g, not %g", got, mean);
    }
    lit_free(lit);
}

// Proves that a sheet with holes is seen through where its picture is clear: there the floor below shows, else the sheet's own colour in
// the mean light. Texels are 2.5 cm; half a texel about the holes' edges is both.
Test(textured_stills, holes_are_seen_through) {
    Lit *lit = lit_new();
    int leaf = add_fields(lit, 0);
    lit->building->materials[leaf].alpha = lit->building->textures[1].opacity;
    lit_quad(lit, vec3(0, 0, 1), vec3(6, 0, 1), vec3(6, 6, 1), vec3(0, 6, 1), leaf);
    lit_quad(lit, vec3(0, 0, 0), vec3(6, 0, 0), vec3(6, 6, 0), vec3(0, 6, 0), LIT_WALL);
    Seen v = see(lit, 0);
    int clear = 0, shut = 0;
    for (int i = 0; i < 900; i++) {
        Vec3 at = vec3(0.3 + 0.18 * (i % 30), 0.3 + 0.18 * (double)(i / 30), 1);
        double edge, want;
        int field = field_at(at, &edge);
        if (edge < 2.0 / (DOWN * FIELD)) continue;
        want = field % 2 ? ARRIVES / 2 : v.light.mean[1] * (double)maps_linear(code_of(field));
        *(field % 2 ? &clear : &shut) += 1;
        cr_expect_float_eq(trace(&v, vec3_add(at, vec3(0, 0, 1)), at), want, 1e-5 * want, "field %d", field);
    }
    cr_expect(clear > 50 && shut > 50);
    lit_free(lit);
}

// Proves that a picture of the sky begins where the building says and goes to the right, has its top at the zenith, lights level ground
// as much as the sky of the day, and leaves the ground below the horizon as it was. Tolerance: rings and texels are finite, 2 %.
Test(textured_stills, picture_of_the_sky) {
    enum { WIDTH = 64, HEIGHT = 32 };
    static uint8_t texels[WIDTH * HEIGHT * 4];
    Lit *lit = lit_new();
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        // The first quarter to the right is green alone; the upper half is blue besides.
        texels[4 * i + 1] = i % WIDTH < WIDTH / 4 ? 200 : 0;
        texels[4 * i + 2] = i / WIDTH < HEIGHT / 2 ? 150 : 20;
        texels[4 * i + 3] = 255;
    }
    lit->building->sky_texture = texture_add_pixels(&lit->arena, lit->building, "sky", WIDTH, HEIGHT, texels);
    lit->building->sky_start = 0;  // +x
    Daylight day = daylight_uniform((double[]){5, 6, 8});
    StillSky sky = still_sky(lit->building, &day, 1, 0), plain = sky;
    plain.scale = 0;
    double out[3], with[3] = {0}, without[3] = {0}, low[3];
    still_sky_at(&sky, vec3_normalize(vec3(1, -0.5, 0.5)), out);
    cr_expect(out[1] > 3 * out[2], "a quarter from +x to -y is green: %g %g", out[1], out[2]);
    still_sky_at(&sky, vec3_normalize(vec3(1, 0.5, 0.5)), out);
    cr_expect(out[1] < 1e-6 && out[2] > 0);
    still_sky_at(&sky, vec3_normalize(vec3(-0.2, -0.2, 1)), low);
    cr_expect(low[2] > 10 * out[2], "blue above");
    Random random = {3};
    for (int i = 0; i < 40000; i++) {
        double rise = sqrt(random_unit(&random)), a = random_between(&random, 0, 2 * M_PI);
        double level = sqrt(1 - rise * rise);
        Vec3 w = vec3(level * cos(a), level * sin(a), rise);
        double one[3], two[3];
        still_sky_at(&sky, w, one);
        still_sky_at(&plain, w, two);
        for (int c = 0; c < 3; c++) with[c] += one[c], without[c] += two[c];
    }
    double is = 0.2126 * with[0] + 0.7152 * with[1] + 0.0722 * with[2],
           was = 0.2126 * without[0] + 0.7152 * without[1] + 0.0722 * without[2];
    cr_expect_float_eq(is / was, 1, 0.02, "%g", is / was);
    still_sky_at(&sky, vec3_normalize(vec3(1, 1, -0.5)), out);
    still_sky_at(&plain, vec3_normalize(vec3(1, 1, -0.5)), low);
    for (int c = 0; c < 3; c++) cr_expect_float_eq(out[c], low[c], 1e-12);
    lit_free(lit);
}
