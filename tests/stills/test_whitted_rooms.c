// test_whitted_rooms.c - glass, mirrors and lamps in a closed room.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/stills/still.h"
#include "maps/curved/curved_tessellate.h"
#include "tests/support/lit_fixture.h"

// ---- rooms

typedef struct Room {
    Lit *lit;
    RadSolution solution;
    WalkLight light;
} Room;

enum { GLASS = 3, MIRROR, SHEET, GLOW, WATER };

// A closed room of 4 x 4 x 3 m of one material, and what there may be in it.
static Room *room_new(void) {
    Room *room = calloc(1, sizeof *room);
    cr_assert_not_null(room);
    Lit *lit = room->lit = lit_new();
    Building *b = lit->building;
    Material more[] = {{.name = "glass", .alpha = 0, .index = 1.5f},
                       {.name = "mirror", .alpha = 1, .mirror = 1},
                       {.name = "sheet", .alpha = 0.0f},
                       {.name = "glow", .reflectance = {0.5f, 0.5f, 0.5f}, .emission = {1, 1, 1}, .alpha = 1},
                       {.name = "water", .alpha = 0, .index = 1.33f}};
    for (int i = 0; i < 5; i++) cr_assert_eq(building_add_material(&lit->arena, b, more[i]), GLASS + i);
    return room;
}

static void room_free(Room *room) {
    lit_free(room->lit);
    free(room);
}

static void add_ball(Room *room, Vec3 centre, double radius, int material) {
    Building *b = room->lit->building;
    Arena *arena = &room->lit->arena;
    CurvedMesh mesh;
    CurvedShape *shapes = ARENA_ARRAY(arena, CurvedShape, b->shape_count + 1);
    if (b->shape_count > 0) memcpy(shapes, b->shapes, (size_t)b->shape_count * sizeof *shapes);
    b->shapes = shapes;
    int object = building_add_object(arena, b, OBJECT_FURNITURE, "ball");
    CurvedShape *s = &shapes[b->shape_count++];
    *s = (CurvedShape){.kind = CURVED_SPHERE,
                       .object = object,
                       .material = material,
                       .frame = {centre, {{radius, 0, 0}, {0, radius, 0}, {0, 0, radius}}},
                       .tolerance = 0.002,
                       .first_polygon = b->polygon_count};
    curved_tessellate(b, s, s->tolerance, arena, &mesh);
    for (int p = 0; p < mesh.polygon_count; p++)
        building_add_polygon(arena, b, mesh.vertices + mesh.first[p], mesh.first[p + 1] - mesh.first[p],
                             material);
    s->polygon_count = b->polygon_count - s->first_polygon;
    s->tolerance = mesh.tolerance;
}

// Every element but mirrors has the radiosity of an even furnace: emission 1, reflectance half. Half comes straight from lamps.
static void room_finish(Room *room) {
    Lit *lit = room->lit;
    RadSolution *s = &room->solution;
    Error error;
    lit_finish(lit, 0.5, 2);
    cr_assert(rad_start_dark(&lit->mesh, &lit->arena, s, &error), "%s", error.text);
    for (int e = 0; e < lit->mesh.element_count; e++) {
        bool mirror = mesh_material(&lit->mesh, lit->mesh.elements[e].face)->mirror > 0;
        for (int c = 0; c < 3; c++) {
            s->radiosity[e][c] = mirror ? 0 : 2;
            s->direct[e][c] = mirror ? 0 : 0.5;
        }
    }
    room->light = (WalkLight){.mesh = &lit->mesh, .solution = s};
}

typedef struct Shot {
    uint8_t *rgb;
    StillReport report;
} Shot;

static Shot shoot(Room *room, Camera camera, const StillOptions *options) {
    Shot shot = {.rgb = ARENA_ARRAY(&room->lit->arena, uint8_t, camera.width * camera.height * 3)};
    cr_assert(still_draw(&room->lit->forest, &room->light, &camera, options, NULL, shot.rgb, &shot.report));
    return shot;
}

typedef struct Seen {
    StillScene *scene;
    StillLight light;
    Whitted whitted;
    Media media;
    Camera camera;
} Seen;

static Seen view_of(Room *room, Camera camera, int direct) {
    Arena *arena = &room->lit->arena;
    Seen v = {.scene = still_scene_new(&room->lit->mesh, NULL, STILL_TREE_OWN, arena), .camera = camera};
    StillLamps *lamps = direct == STILL_RAYS ? still_lamps_new(v.scene, &room->lit->forest, 16, arena) : NULL;
    v.light = still_light_new(v.scene, &room->solution, lamps, arena);
    v.media = still_scene_media(v.scene, camera.eye);
    v.whitted = (Whitted){.scene = v.scene, .depth = 12, .threshold = 1.0 / 512, .lamp_rays = 2};
    return v;
}

// The darkest and the brightest pixel, W/m^2.
static void look(Seen *v, double *low, double *high, WhittedWork *work) {
    *low = INFINITY, *high = 0;
    v->whitted.light = &v->light;
    for (int y = 0; y < v->camera.height; y++)
        for (int x = 0; x < v->camera.width; x++) {
            Ray ray = {v->camera.eye, vec3_normalize(camera_ray(&v->camera, x + 0.5, y + 0.5)), 0, INFINITY};
            double light[3];
            whitted_trace(&v->whitted, &ray, &v->media, (uint64_t)(y * 1000 + x), 0, work, light);
            for (int c = 0; c < 3; c++) {
                *low = fmin(*low, light[c]);
                *high = fmax(*high, light[c]);
            }
        }
    if (v->light.lamps) still_lamps_end(v->light.lamps);
}

static Camera camera_at(Vec3 eye, Vec3 at, int width, int height) {
    Vec3 d = vec3_sub(at, eye);
    return camera_look(eye, atan2(d.y, d.x), asin(d.z / vec3_length(d)), 1.4, width, height);
}

// A black plate before walls that are even: its glaze shows `gloss` of what Fresnel says for an index of 1.5, at each
// angle, and a gloss of 0 shows nothing. The room is no mirror: the share that is not reflected shows the plate,
// which is dark. Tolerance: rounding.
Test(whitted, gloss_reflects_its_share) {
    static const float GLOSSES[] = {0, 0.25f, 1};
    for (int i = 0; i < 3; i++) {
        Room *room = room_new();
        Lit *lit = room->lit;
        int black = building_add_material(&lit->arena, lit->building,
                                          (Material){.name = "black", .alpha = 1, .gloss = GLOSSES[i]});
        lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 3), true, GLOW, 0);
        lit_quad(lit, vec3(1, 1, 0.5), vec3(3, 1, 0.5), vec3(3, 3, 0.5), vec3(1, 3, 0.5), black);
        room_finish(room);
        for (int e = 0; e < lit->mesh.element_count; e++)
            if (lit->mesh.faces[lit->mesh.elements[e].face].plane.d == 0.5)
                memset(room->solution.radiosity[e], 0, sizeof room->solution.radiosity[e]);
        Vec3 eye = vec3(1.2, 2, 2);
        Seen v = view_of(room, camera_at(eye, vec3(2, 2, 0.5), 8, 8), STILL_BAKED);
        v.whitted.light = &v.light;
        for (int k = 0; k < 8; k++) {
            Vec3 way = vec3_normalize(vec3_sub(vec3(1.15 + 0.22 * k, 2, 0.5), eye));
            Ray ray = {eye, way, 0, INFINITY};
            double light[3];
            WhittedWork work = {0};
            whitted_trace(&v.whitted, &ray, &v.media, 7, 0, &work, light);
            double share = (double)GLOSSES[i] * glass_fresnel(-way.z, GLASS_USUAL);
            cr_expect_float_eq(light[1], 2 * share, 1e-6, "gloss %g, %d: %g", (double)GLOSSES[i], k,
                               light[1]);
        }
        room_free(room);
    }
}

// An even furnace: all is as bright as all else, so a ball of glass, one of water in one of glass, a mirror and a sheet of glass are not
// there. The bar is 0.1 %; the light of a pixel is the sum of its tree, so it comes out to rounding. Then the glass alone with light
// that comes straight from the walls: their closed form sums to 1 in a closed room, but for quadrilaterals by Gauss's rule.
Test(whitted, glass_and_mirrors_vanish_in_a_furnace) {
    for (int direct = 0; direct < 2; direct++) {
        Room *room = room_new();
        lit_box(room->lit, vec3(0, 0, 0), vec3(4, 4, 3), true, GLOW, 0);
        add_ball(room, vec3(2, 2.5, 1.4), 0.5, GLASS);
        add_ball(room, vec3(2, 2.5, 1.4), 0.3, WATER);
        lit_quad(room->lit, vec3(0.5, 2, 0.5), vec3(1, 2.2, 0.5), vec3(1, 2.2, 2), vec3(0.5, 2, 2), SHEET);
        if (direct == STILL_BAKED) {
            lit_quad(room->lit, vec3(2, 3.99, 0.5), vec3(3, 3.99, 0.5), vec3(3, 3.99, 2), vec3(2, 3.99, 2),
                     MIRROR);
            add_ball(room, vec3(3, 2.5, 1), 0.3, MIRROR);
        }
        room_finish(room);
        Seen v = view_of(room, camera_at(vec3(2, 0.5, 1.5), vec3(2, 3, 1.3), 96, 72), direct);
        double low, high;
        WhittedWork work = {0};
        look(&v, &low, &high, &work);
        double bar = direct == STILL_RAYS ? 2e-2 : 2e-3;
        cr_expect(low > 2 - bar && high < 2 + bar, "direct %s: %g to %g", STILL_DIRECT_NAMES[direct], low,
                  high);
        cr_expect(work.rays > 2 * 96 * 72, "hardly a ray parted: %lld", work.rays);
        room_free(room);
    }
}

// The same furnace with a glass that absorbs is not even: the test above can fail.
Test(whitted, tinted_glass_is_seen) {
    Room *room = room_new();
    room->lit->building->materials[GLASS].alpha = 0.5f;
    lit_box(room->lit, vec3(0, 0, 0), vec3(4, 4, 3), true, GLOW, 0);
    add_ball(room, vec3(2, 2.5, 1.4), 0.5, GLASS);
    room_finish(room);
    Seen v = view_of(room, camera_at(vec3(2, 0.5, 1.5), vec3(2, 3, 1.3), 96, 72), STILL_BAKED);
    double low, high;
    WhittedWork work = {0};
    look(&v, &low, &high, &work);
    // Half of what passes, and what is reflected at once: at most 1, and not much less.
    cr_expect(low < 1.2 && low > 0.9, "darkest %g", low);
    room_free(room);
}

// Light straight from a lamp, by shadow rays, against the furnace's own closed form: half of the room's floor is hidden from the lamp
// by a screen that touches the ceiling, so it is dark there, and the other half as bright as Lambert says.
Test(whitted, shadows_are_sharp) {
    Room *room = room_new();
    lit_box(room->lit, vec3(0, 0, 0), vec3(4, 4, 3), true, LIT_WALL, 0);
    lit_box(room->lit, vec3(1.99, 0, 0), vec3(2.01, 4, 3), false, LIT_WALL, 0);
    lit_lamp(room->lit, vec3(1, 2, 2.5));
    room_finish(room);
    for (int e = 0; e < room->lit->mesh.element_count; e++)
        for (int c = 0; c < 3; c++) room->solution.radiosity[e][c] = room->solution.direct[e][c] = 0;
    Arena *arena = &room->lit->arena;
    StillScene *scene = still_scene_new(&room->lit->mesh, NULL, STILL_TREE_OWN, arena);
    StillLamps *lamps = still_lamps_new(scene, &room->lit->forest, 16, arena);
    StillLight light = still_light_new(scene, &room->solution, lamps, arena);
    for (int i = 0; i < 2; i++) {
        Ray ray = {vec3(1 + 2 * i, 2, 2.4), vec3(0, 0, -1), 0, INFINITY};
        SurfaceHit hit = still_rays_first(scene->all, &ray);
        StillNumbers numbers = {{0.1, 0.2, 0.3}, 0};
        double out[3];
        still_light_at(&light, &ray, &hit, 0, 16, &numbers, out);
        // A unit square 2.5 m above: 4 times that of one of half the side from below a corner.
        double x = 0.5 / 2.5, r = sqrt(1 + x * x),
               want = 4 * (2 * x / r * atan(x / r)) / (2 * M_PI) * 12 * 0.5;
        cr_expect_float_eq(out[0], i ? 0 : want, 0.01 * want, "side %d: %g, not %g", i, out[0], want);
    }
    still_lamps_end(lamps);
    room_free(room);
}

// Places that one must not stand in, and mirrors without end: a picture all the same, and the depth is kept.
Test(whitted, defined_wherever_one_is) {
    Room *room = room_new();
    lit_box(room->lit, vec3(0, 0, 0), vec3(4, 4, 3), true, GLOW, 0);
    add_ball(room, vec3(1.5, 2, 1.4), 0.6, GLASS);
    add_ball(room, vec3(1.5, 2, 1.4), 0.3, WATER);
    for (int i = 0; i < 2; i++) {
        double x = i ? 2.6 : 3.6, y0 = i ? 0.5 : 3.5, y1 = i ? 3.5 : 0.5;
        lit_quad(room->lit, vec3(x, y0, 0.2), vec3(x, y1, 0.2), vec3(x, y1, 2.8), vec3(x, y0, 2.8), MIRROR);
    }
    // Backs of mirrors are dark.
    lit_box(room->lit, vec3(2.5, 0.5, 0.2), vec3(2.59, 3.5, 2.8), false, GLOW, 0);
    lit_box(room->lit, vec3(3.61, 0.5, 0.2), vec3(3.7, 3.5, 2.8), false, GLOW, 0);
    room_finish(room);
    static const struct {
        Vec3 eye, at;
        int media;
    } PLACES[] = {{{1.5, 2, 1.4}, {1.5, 4, 1}, 2},    // in water in glass
                  {{1.5, 2, 1.85}, {1.5, 4, 1}, 1},   // in glass
                  {{3.1, 2, 1.5}, {4, 2.1, 1.5}, 0},  // between the mirrors
                  {{5, 5, 5}, {2, 2, 1}, 0},          // outside of all
                  {{1.5, 2, 2.0}, {1.5, 2, 0.1}, 0}};
    for (int i = 0; i < (int)(sizeof PLACES / sizeof *PLACES); i++) {
        Seen v = view_of(room, camera_at(PLACES[i].eye, PLACES[i].at, 48, 36), STILL_BAKED);
        double low, high;
        WhittedWork work = {0};
        cr_expect_eq(v.media.count, PLACES[i].media, "place %d: in %d bodies", i, v.media.count);
        look(&v, &low, &high, &work);
        cr_expect(isfinite(high) && low >= 0 && high < 2.01, "place %d: %g to %g", i, low, high);
        cr_expect(work.rays < 48 * 36 * 200, "place %d: %lld rays", i, work.rays);
        if (i == 2) cr_expect_gt(work.deep, 0, "the mirrors end");
        if (i < 3) cr_expect(low > 1.99, "place %d: %g, the furnace is not even", i, low);
    }
    room_free(room);
}

// The same bytes on any number of threads; other samples, other bytes.
Test(whitted, threads_make_no_difference) {
    Room *room = room_new();
    lit_box(room->lit, vec3(0, 0, 0), vec3(4, 4, 3), true, LIT_RED, 0);
    add_ball(room, vec3(2, 2.5, 1.0), 0.5, GLASS);
    add_ball(room, vec3(3, 3, 0.5), 0.4, MIRROR);
    lit_lamp(room->lit, vec3(2, 2, 2.9));
    room_finish(room);
    Camera camera = camera_at(vec3(2, 0.5, 1.5), vec3(2, 3, 1), 64, 48);
    StillOptions options = still_default_options();
    options.samples = 3;
    options.threads = 1;
    Shot one = shoot(room, camera, &options);
    for (int threads = 2; threads <= 7; threads += 5) {
        options.threads = threads;
        Shot more = shoot(room, camera, &options);
        cr_expect_arr_eq(one.rgb, more.rgb, 64 * 48 * 3, "%d threads", threads);
    }
    options.tree = STILL_TREE_GRID;
    Shot grid = shoot(room, camera, &options);
    cr_expect_arr_eq(one.rgb, grid.rgb, 64 * 48 * 3, "grid");
    room_free(room);
}
