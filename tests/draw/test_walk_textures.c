// test_walk_textures.c - pictures of textures on the screen: where they lie, how bright they are, holes in them, and the sky's.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/draw/image.h"
#include "engine/draw/view.h"
#include "engine/draw/walk_textures.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "radiosity/shoot/shoot.h"
#include "tests/draw/renderer_fixture.h"

enum { TILES = 8, TILE = 8, SIDE = TILES * TILE, WIDE = 320, HIGH = 180 };

// The channel in which a tile is bright: no two rows or columns are alike, so that a shift or a mirrored picture shows.
static int channel_of(int column, int row) {
    return (column * column + 3 * row * row * row + column * row) % 7 % 3;
}

static int channel_at(double u, double v) {
    int column = (int)floor((u - floor(u)) * TILES), row = (int)floor((v - floor(v)) * TILES);
    return channel_of(column % TILES, row % TILES);
}

// Adds a picture of coloured tiles, and a map under which it lies askew on every level or upright plane. `holes`: tiles that are bright
// in red are transparent.
static int add_tiles(Stage *s, bool holes) {
    uint8_t *pixels = ARENA_ARRAY(&s->arena, uint8_t, 4 * SIDE * SIDE);
    for (int i = 0; i < SIDE * SIDE; i++) {
        int bright = channel_of(i % SIDE / TILE, i / SIDE / TILE);
        for (int c = 0; c < 3; c++) pixels[4 * i + c] = c == bright ? 200 : 70;
        pixels[4 * i + 3] = holes && bright == 0 ? 0 : 255;
    }
    return texture_add_pixels(&s->arena, &s->building, "tiles", SIDE, SIDE, pixels);
}

static int add_map(Stage *s, double scale) {
    TextureMap map = {.u = vec3_scale(vec3(0.5, 0.25, 0), scale),
                      .v = vec3_scale(vec3(0.1, -0.3, -0.5), scale),
                      .u0 = 1000.3,
                      .v0 = -77.2};
    return building_add_texture_map(&s->arena, &s->building, map);
}

static void read_building(Stage *s, const char *path) {
    Error error;
    *s = (Stage){0};
    cr_assert(maps_read(path, &s->arena, &s->building, &error), "%s", error.text);
}

static void put_picture(Stage *s, int texture, int map) {
    for (int i = 0; i < s->building.material_count; i++) {
        Material *m = &s->building.materials[i];
        m->texture = texture, m->texture_map = map;
        m->reflectance = s->building.textures[texture].mean;
    }
}

// The same irradiance in all channels everywhere, W/m^2, on all that does not emit.
static void light_evenly(Stage *s, double irradiance, Mesh *mesh, RadSolution *solution) {
    Error error;
    MeshOptions options = mesh_default_options();
    options.element = 1;
    cr_assert(mesh_build(&s->graph, NULL, &options, &s->arena, mesh, &error), "%s", error.text);
    cr_assert(rad_start_dark(mesh, &s->arena, solution, &error), "%s", error.text);
    for (int e = 0; e < mesh->element_count; e++) {
        double rho[3];
        rgb_doubles(mesh_reflectance(mesh, e), rho);
        for (int c = 0; c < 3; c++) solution->radiosity[e][c] = rho[c] * irradiance;
    }
    WalkLight light = {.mesh = mesh, .solution = solution};
    cr_assert(walk_renderer_light(s->renderer, &light, &s->arena, &error), "%s", error.text);
    walk_renderer_tone(s->renderer, 1, FALSE_COLOUR_OFF);
}

typedef struct Hit {
    int polygon, object;  // -1: none
    Vec3 point;           // of leaves as when closed
    double distance;
} Hit;

static Vec3 closed_point(const Stage *s, const Object *o, Vec3 p) {
    if (o->leaf < 0) return p;
    Leaf back = s->building.leaves[o->leaf];
    double open = (double)s->doors[back.opening];
    p = vec3_sub(p, vec3(open * back.slide.x, open * back.slide.y, open * back.rise));
    back.turn *= -1, back.slide = (Vec2){0, 0}, back.rise = 0;
    return leaf_point(&back, open, p);
}

// The nearest polygon along a ray, by trying all; surfaces from inside their cells.
static Hit cast(const Stage *s, Vec3 from, Vec3 way) {
    const CellGraph *g = &s->graph;
    Hit best = {-1, -1, from, INFINITY};
    for (int o = 0; o < g->object_count; o++) {
        const Object *object = &g->objects[o];
        if (!vis_shown(object, s->doors)) continue;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            Vec3 v[16];
            int count = g->polygons[p].vertex_count;
            cr_assert_leq(count, 16);
            for (int i = 0; i < count; i++) {
                v[i] = g->vertices[g->polygons[p].first_vertex + i];
                if (object->leaf < 0) continue;
                const Leaf *leaf = &s->building.leaves[object->leaf];
                v[i] = leaf_point(leaf, (double)s->doors[leaf->opening], v[i]);
            }
            Plane plane = plane_of_polygon(v, count);
            double height = plane_distance(plane, from), falls = -vec3_dot(plane.n, way);
            if (object->kind == OBJECT_SURFACE && height <= 0) continue;
            double t = height / falls;
            if (!(t > 0) || t >= best.distance) continue;
            Vec3 at = vec3_add(from, vec3_scale(way, t));
            bool inside = true;
            for (int i = 0; i < count && inside; i++)
                inside = vec3_dot(plane.n,
                                  vec3_cross(vec3_sub(v[(i + 1) % count], v[i]), vec3_sub(at, v[i]))) >= 0;
            if (inside) best = (Hit){p, o, closed_point(s, object, at), t};
        }
    }
    return best;
}

static Vec2 place_of(const Stage *s, const Hit *hit) {
    const Building *b = &s->building;
    const TextureMap *map =
        &b->texture_maps[b->materials[s->graph.polygons[hit->polygon].material].texture_map];
    return vec2(vec3_dot(map->u, hit->point) + map->u0, vec3_dot(map->v, hit->point) + map->v0);
}

// Finds the hit of a pixel. False unless it and the pixels one away each way show one tile of one polygon.
static bool one_tile(const Stage *s, const Camera *camera, int x, int y, Hit *out) {
    static const int AWAY[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int k = 0; k < 5; k++) {
        Hit hit = cast(s, camera->eye, camera_ray(camera, x + AWAY[k][0] + 0.5, y + AWAY[k][1] + 0.5));
        if (hit.polygon < 0 || (k > 0 && hit.polygon != out->polygon)) return false;
        if (k == 0) *out = hit;
        Vec2 a = place_of(s, out), b = place_of(s, &hit);
        if (floor(a.x * TILES) != floor(b.x * TILES) || floor(a.y * TILES) != floor(b.y * TILES))
            return false;
    }
    return true;
}

static bool emits(const Stage *s, int polygon) {
    Rgb e = s->building.materials[s->graph.polygons[polygon].material].emission;
    return e.r + e.g + e.b > 0;
}

static int brightest(const uint8_t *p) { return p[0] > p[1] && p[0] > p[2] ? 0 : p[1] > p[2] ? 1 : 2; }

static void keep(const char *name, const uint8_t *rgb, const Camera *camera) {
    Error error;
    char path[128];
    const char *folder = getenv("ENFILADE_PICTURES");
    if (!folder) return;
    snprintf(path, sizeof path, "%s/%s.png", folder, name);
    cr_assert(image_write_png(path, rgb, camera->width, camera->height, &error), "%s", error.text);
}

// Proves that every look draws each texel where the map has it, to a pixel: each pixel that shows one tile, as do the pixels beside it, is
// brightest in the tile's channel; leaves of doors take their pictures along. And that the baked look is as bright as texture_at
// says in an even light. Tolerance of that: a texel's root is rounded to 8 bits, and the curve of the screen to a 256th.
Test(walk_textures, lie_where_maps_have_them, .timeout = 300) {
    static const float OPEN[] = {0, 0.35f, 1};
    Stage s;
    Mesh mesh;
    RadSolution solution;
    read_building(&s, "build/maps/two-rooms.plan");
    put_picture(&s, add_tiles(&s, false), add_map(&s, 1));
    renderer_check_open_building(&s);
    light_evenly(&s, 1.5, &mesh, &solution);
    for (int d = 0; d < 6; d++) {
        int share = d / 2, leaves = 0;
        Camera camera = d % 2 ? camera_look(s.building.start, s.building.start_yaw, -0.3, 1.2, WIDE, HIGH)
                              : renderer_check_door(&s, WIDE, HIGH);
        for (int i = 0; i < s.building.opening_count; i++) s.doors[i] = OPEN[share];
        const uint8_t *rgb[WALK_LOOKS];
        for (int look = 0; look < WALK_LOOKS; look++) {
            rgb[look] = renderer_check_picture(&s, &camera, CULL_STAB, (WalkLook)look);
            keep(WALK_LOOK_NAMES[look], rgb[look], &camera);
        }
        int checked = 0;
        for (int y = 1; y < HIGH - 1; y += 2) {
            for (int x = 1; x < WIDE - 1; x += 2) {
                Hit hit;
                if (!one_tile(&s, &camera, x, y, &hit) || emits(&s, hit.polygon)) continue;
                Vec2 at = place_of(&s, &hit);
                const Polygon *polygon = &s.graph.polygons[hit.polygon];
                Rgb rho = texture_at(&s.building, polygon->material, 0, hit.point, 0).colour;
                const float reflectance[3] = {rho.r, rho.g, rho.b};
                bool leaf = s.graph.objects[hit.object].leaf >= 0;
                for (int look = 0; look < WALK_LOOKS; look++) {
                    const uint8_t *p = rgb[look] + 3 * (y * WIDE + x);
                    cr_assert_eq(brightest(p), channel_at(at.x, at.y),
                                 "%s, doors %g, pixel (%d, %d): %d %d %d, object %d (leaf: %d)",
                                 WALK_LOOK_NAMES[look], (double)OPEN[share], x, y, p[0], p[1], p[2],
                                 hit.object, leaf);
                    bool front = plane_distance(plane_of_polygon(s.graph.vertices + polygon->first_vertex,
                                                                 polygon->vertex_count),
                                                camera.eye) > 0;
                    if (look != WALK_BAKED || leaf || !front) continue;
                    double u = at.x * TILES - floor(at.x * TILES), v = at.y * TILES - floor(at.y * TILES);
                    if (fabs(u - 0.5) > 0.2 || fabs(v - 0.5) > 0.2) continue;
                    for (int c = 0; c < 3; c++)
                        cr_assert_float_eq(p[c], 255 * exposure_on_screen(1.5 * (double)reflectance[c]), 4,
                                           "pixel (%d, %d), channel %d: %d for %g", x, y, c, p[c],
                                           255 * exposure_on_screen(1.5 * (double)reflectance[c]));
                }
                checked++;
                leaves += leaf;
            }
        }
        cr_assert_gt(checked, WIDE * HIGH / 4 / 4, "%d pixels show one tile", checked);
        if (d == 0 || d == 2) cr_assert_gt(leaves, 20, "%d pixels of the leaf", leaves);
    }
    renderer_check_close_stage(&s);
}

// Proves that a picture far away is its mean: a house whose materials all have a picture of squares of a millimetre looks, in every
// look, as the same house whose materials have its mean as their colour. Tolerance: the root of a mean is rounded to 8 bits, and the
// screen's code of it again.
Test(walk_textures, far_away_is_the_mean, .timeout = 300) {
    uint8_t *rgb[2][WALK_LOOKS];
    Stage s[2];
    Camera camera;
    for (int k = 0; k < 2; k++) {
        Mesh mesh;
        RadSolution solution;
        read_building(&s[k], "build/maps/two-rooms.plan");
        put_picture(&s[k], add_tiles(&s[k], false), add_map(&s[k], 2.0 * 1000 / SIDE * 10));
        for (int i = 0; i < s[k].building.material_count && k == 1; i++)
            s[k].building.materials[i].texture = 0;
        renderer_check_open_building(&s[k]);
        light_evenly(&s[k], 1.5, &mesh, &solution);
        camera = camera_look(s[k].building.start, s[k].building.start_yaw, 0, 1.2, WIDTH, HEIGHT);
        for (int look = 0; look < WALK_LOOKS; look++)
            rgb[k][look] = renderer_check_picture(&s[k], &camera, CULL_STAB, (WalkLook)look);
        walk_renderer_free(s[k].renderer);
        gl_context_close(s[k].context);
    }
    for (int look = 0; look < WALK_LOOKS; look++) {
        int most = 0;
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
            most = (int)fmax(most, abs(rgb[0][look][i] - rgb[1][look][i]));
        cr_expect_leq(most, 3, "%s: %d levels off", WALK_LOOK_NAMES[look], most);
    }
    for (int k = 0; k < 2; k++) arena_free(&s[k].arena);
}

// Proves that holes of a picture show what is behind them, in every look, and that the rest hides it: a pixel of one tile is brightest in
// the tile's channel, or is the pixel of the building without the object.
Test(walk_textures, holes_are_seen_through, .timeout = 300) {
    Stage s;
    Mesh mesh;
    RadSolution solution;
    read_building(&s, "build/maps/two-rooms.plan");
    int texture = add_tiles(&s, true), object = 0;
    while (s.building.objects[object].kind != OBJECT_FURNITURE) object++;
    Material cut = {.name = "cut", .reflectance = s.building.textures[texture].mean, .texture = texture};
    cut.alpha = s.building.textures[texture].opacity;
    cut.texture_map = add_map(&s, 2);
    int material = building_add_material(&s.arena, &s.building, cut);
    const Object *o = &s.building.objects[object];
    Box box = box_empty();
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        s.building.polygons[p].material = material;
        for (int i = 0; i < s.building.polygons[p].vertex_count; i++)
            box = box_add(box, s.building.vertices[s.building.polygons[p].first_vertex + i]);
    }
    renderer_check_open_building(&s);
    light_evenly(&s, 1.5, &mesh, &solution);
    Vec3 middle = vec3_lerp(box.min, box.max, 0.5), eye = s.building.start;
    Camera camera =
        camera_look(eye, atan2(middle.y - eye.y, middle.x - eye.x),
                    atan2(middle.z - eye.z, hypot(middle.x - eye.x, middle.y - eye.y)), 0.9, WIDE, HIGH);
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *with = renderer_check_picture(&s, &camera, CULL_NONE, (WalkLook)look);
        keep(look == 0 ? "holes-fast" : look == 1 ? "holes-fine" : "holes-baked", with, &camera);
        int *others = ARENA_ARRAY(&s.arena, int, s.graph.object_count), count = 0;
        for (int i = 0; i < s.graph.object_count; i++)
            if (i != object && vis_shown(&s.graph.objects[i], s.doors)) others[count++] = i;
        uint8_t *without = ARENA_ARRAY(&s.arena, uint8_t, 3 * WIDE * HIGH);
        Error error;
        cr_assert(walk_renderer_draw(s.renderer, &camera, others, count, (WalkLook)look, &error));
        cr_assert(walk_renderer_finish_scene(s.renderer, &error) &&
                  walk_renderer_read(s.renderer, without, &error));
        int holes = 0, solid = 0;
        for (int y = 1; y < HIGH - 1; y++) {
            for (int x = 1; x < WIDE - 1; x++) {
                Hit hit, through;
                const uint8_t *p = with + 3 * (y * WIDE + x), *q = without + 3 * (y * WIDE + x);
                Vec3 way = camera_ray(&camera, x + 0.5, y + 0.5);
                hit = cast(&s, camera.eye, way);
                if (hit.object != object || !one_tile(&s, &camera, x, y, &hit)) continue;
                Vec2 at = place_of(&s, &hit);
                if (channel_at(at.x, at.y) != 0) {
                    cr_assert_eq(brightest(p), channel_at(at.x, at.y), "%s (%d, %d)", WALK_LOOK_NAMES[look],
                                 x, y);
                    solid++;
                    continue;
                }
                through = cast(&s, vec3_add(camera.eye, vec3_scale(way, hit.distance + 1e-4)), way);
                if (through.object == object) continue;
                // Light of the fine look is dimmed where depths rise near by, not only at this pixel.
                int differs = 0;
                for (int c = 0; c < 3; c++) differs = (int)fmax(differs, abs(p[c] - q[c]));
                cr_assert_leq(differs, look == WALK_FINE ? 40 : 1, "%s (%d, %d): %d", WALK_LOOK_NAMES[look],
                              x, y, differs);
                holes++;
            }
        }
        cr_assert(holes > 20 && solid > 50, "%s: %d pixels of holes, %d of others", WALK_LOOK_NAMES[look],
                  holes, solid);
    }
    renderer_check_close_stage(&s);
}

// Proves that the picture of the sky lies where the building says: its columns to the right from its start, its rows from the zenith
// down to the horizon; that by day it is as bright as the even sky in its place, and that at night there is none. Tolerance: the
// root of a texel and the screen's code are rounded to 8 bits.
Test(walk_textures, sky_stands_where_the_building_says, .timeout = 300) {
    static const double RADIANCE[3] = {0.3, 0.3, 0.3}, START = 0.7;
    Stage s;
    Mesh mesh;
    RadSolution solution;
    Error error;
    read_building(&s, "build/maps/two-rooms.plan");
    int tiles = add_tiles(&s, false);
    uint8_t grey[4 * 4 * 4];
    memset(grey, 180, sizeof grey);
    int even = texture_add_pixels(&s.arena, &s.building, "grey", 4, 4, grey);
    s.building.sky_start = START;
    for (int k = 0; k < 2; k++) {
        Stage t = s;
        t.building.sky_texture = k ? even : tiles;
        renderer_check_open_building(&t);
        light_evenly(&t, 1, &mesh, &solution);
        for (int view = 0; view < 6; view++) {
            Camera camera = camera_look(t.building.start, view * 1.1, 0.5, 1.3, WIDE, HIGH);
            uint8_t *rgb = ARENA_ARRAY(&t.arena, uint8_t, 3 * WIDE * HIGH);
            for (int day = 0; day < 3; day++) {
                WalkLook look = day ? WALK_BAKED : WALK_FAST;
                if (day == 1) {
                    // Until now it was night.
                    solution.day = (Daylight){0};
                } else if (day == 2) {
                    solution.day = daylight_uniform(RADIANCE);
                }
                WalkLight light = {.mesh = &mesh, .solution = &solution};
                cr_assert(walk_renderer_light(t.renderer, &light, &t.arena, &error), "%s", error.text);
                walk_renderer_fade(t.renderer, 1000);
                cr_assert(walk_renderer_draw(t.renderer, &camera, NULL, 0, look, &error), "%s", error.text);
                cr_assert(walk_renderer_finish_scene(t.renderer, &error) &&
                          walk_renderer_read(t.renderer, rgb, &error));
                if (k == 0) keep(day == 0 ? "sky-fast" : day == 1 ? "sky-night" : "sky-day", rgb, &camera);
                int checked = 0;
                for (int i = 0; i < WIDE * HIGH; i++) {
                    const uint8_t *p = rgb + 3 * i;
                    Vec3 w = vec3_normalize(camera_ray(&camera, i % WIDE + 0.5, i / WIDE + 0.5));
                    double u = (START - atan2(w.y, w.x)) / (2 * M_PI), v = acos(w.z) / (M_PI / 2);
                    double a = u * TILES - floor(u * TILES), b = v * TILES - floor(v * TILES);
                    if (w.z < 0.05 || fabs(a - 0.5) > 0.4 || fabs(b - 0.5) > 0.4) continue;
                    if (day == 1)
                        cr_assert(p[0] < 60 && p[2] < 60);
                    else if (k == 0)
                        cr_assert_eq(brightest(p), channel_at(u, v), "day %d, view %d, pixel %d", day, view,
                                     i);
                    else if (day == 2)
                        cr_assert_float_eq(p[1], 255 * exposure_on_screen(M_PI * RADIANCE[1]), 2,
                                           "pixel %d: %d", i, p[1]);
                    checked++;
                }
                cr_assert_gt(checked, WIDE * HIGH / 8);
            }
        }
        walk_renderer_free(t.renderer);
        gl_context_close(t.context);
    }
}
