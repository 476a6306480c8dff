// test_renderer_state.c - the renderer's state, its final frame, edges, and baked light.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/shade/walk_bake.h"
#include "engine/shade/walk_occlusion.h"
#include "engine/tour/tour.h"
#include "maps/maps.h"
#include "tests/draw/renderer_fixture.h"
#include "tests/support/support.h"

// Leaves OpenGL's state as another, an overlay say, could leave it.
static void spoil_state(void) {
    for (unsigned unit = 0; unit < 4; unit++) {
        glActiveTexture(GL_TEXTURE0 + unit);
        glBindTexture(GL_TEXTURE_BUFFER, 0);
        glBindTexture(GL_TEXTURE_2D, 0);
    }
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glUseProgram(0);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glEnable(GL_CULL_FACE);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, 1, 1);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NEVER);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glClearColor(1, 0, 1, 1);
    glClearDepth(0);
    glPixelStorei(GL_PACK_ALIGNMENT, 8);
}

// Proves that drawing relies on no state that others set.
Test(renderer, sets_its_state, .timeout = 120) {
    Stage s;
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *before = renderer_check_picture(&s, &s.camera, CULL_STAB, (WalkLook)look);
        // Pixels that are not written must not be there from the last time.
        Camera away = s.camera;
        away.forward = vec3_scale(away.forward, -1);
        away.right = vec3_scale(away.right, -1);
        renderer_check_picture(&s, &away, CULL_STAB, (WalkLook)look);
        spoil_state();
        const uint8_t *after = renderer_check_picture(&s, &s.camera, CULL_STAB, (WalkLook)look);
        cr_assert_eq(renderer_check_differing(before, after, WIDTH * HEIGHT), 0,
                     "%s: state changes the picture", WALK_LOOK_NAMES[look]);
    }
    renderer_check_close_stage(&s);
}

static bool is_mark(const uint8_t *p) { return p[0] == 255 && p[1] == 0 && p[2] == 255; }

// Shows the final frame, in which pixels (3 .. 9, 5 .. 6) are marked, in a frame `scale` times as large.
static void expect_upright(Stage *s, const uint8_t *rgb, int scale) {
    static uint8_t shown[4 * WIDTH * HEIGHT * 3];
    unsigned frame, target;
    int width = scale * WIDTH, height = scale * HEIGHT;
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glGenRenderbuffers(1, &target);
    glBindRenderbuffer(GL_RENDERBUFFER, target);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target);
    walk_renderer_show(s->renderer, frame, width, height);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, shown);
    // The middle of the mark, which scaling leaves alone.
    int row = height - 1 - 6 * scale + scale / 2;
    cr_assert(is_mark(shown + 3 * (row * width + 6 * scale)), "%d times as large it is not upright", scale);
    for (int y = 0; y < HEIGHT && scale == 1; y++)
        cr_assert_eq(memcmp(shown + 3 * (HEIGHT - 1 - y) * WIDTH, rgb + 3 * y * WIDTH, 3 * WIDTH), 0,
                     "row %d", y);
    glDeleteFramebuffers(1, &frame);
    glDeleteRenderbuffers(1, &target);
}

// Proves that pixel (x, y) of an overlay, y down, is pixel (x, y) of the picture; and that it is shown upright: the
// first row of the picture is the last of a framebuffer, the same size or twice as large.
Test(renderer, final_frame, .timeout = 120) {
    Stage s;
    Error error;
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *plain = renderer_check_picture(&s, &s.camera, CULL_STAB, (WalkLook)look);
        uint8_t rgb[WIDTH * HEIGHT * 3];
        cr_assert(walk_renderer_finish_scene(s.renderer, &error), "%s", error.text);
        glEnable(GL_SCISSOR_TEST);
        glScissor(3, 5, 7, 2);
        glClearColor(1, 0, 1, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        cr_assert(walk_renderer_read(s.renderer, rgb, &error), "%s", error.text);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int x = i % WIDTH, y = i / WIDTH;
            bool marked = x >= 3 && x < 10 && y >= 5 && y < 7;
            bool good = marked ? is_mark(rgb + 3 * i) : memcmp(rgb + 3 * i, plain + 3 * i, 3) == 0;
            cr_assert(good, "pixel (%d, %d) is not as it should be", x, y);
        }
        for (int scale = 1; scale <= 2; scale++) expect_upright(&s, rgb, scale);
    }
    cr_assert_eq(glGetError(), GL_NO_ERROR);
    renderer_check_close_stage(&s);
}

static bool is_red(const uint8_t *p) { return p[0] > 150 && p[1] < 100; }

// Counts the edges of surfaces whose middles are in the picture, and those that have red there.
static void count_edges(const Stage *s, const uint8_t *rgb, int *edges, int *red) {
    const Camera *c = &s->camera;
    for (int o = s->graph.surface_first[0]; o < s->graph.surface_first[s->graph.cell_count]; o++) {
        const Polygon *p = &s->graph.polygons[s->graph.objects[o].first_polygon];
        for (int e = 0; e < p->vertex_count; e++) {
            const Vec3 *v = s->graph.vertices + p->first_vertex;
            Vec3 to = vec3_sub(vec3_lerp(v[e], v[(e + 1) % p->vertex_count], 0.5), c->eye);
            double depth = vec3_dot(to, c->forward);
            int x = (int)((vec3_dot(to, c->right) / depth / c->tan_x + 1) / 2 * WIDTH);
            int y = (int)((1 - vec3_dot(to, c->up) / depth / c->tan_y) / 2 * HEIGHT);
            if (depth < 0.1 || x < 1 || y < 1 || x >= WIDTH - 1 || y >= HEIGHT - 1) continue;
            bool here = false;
            for (int j = y - 1; j <= y + 1; j++) {
                for (int i = x - 1; i <= x + 1; i++) here |= is_red(rgb + 3 * (j * WIDTH + i));
            }
            ++*edges;
            *red += here;
        }
    }
}

// Proves that edges are drawn as lines where they are, through what hides them, and that none change nothing.
Test(renderer, wireframe, .timeout = 120) {
    static const float red[] = {1, 0, 0, 1};
    Stage s;
    Error error;
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *plain = renderer_check_picture(&s, &s.camera, CULL_NONE, (WalkLook)look);
        Eye eye = walk_eye(&s.camera);
        VisResult v = vis_query(s.query, &eye, -1, s.doors, CULL_NONE);
        int first = s.graph.surface_first[0], count = s.graph.surface_first[s.graph.cell_count] - first;
        int *surfaces = ARENA_ARRAY(&s.arena, int, count);
        for (int i = 0; i < count; i++) surfaces[i] = first + i;
        for (int all = 0; all < 2; all++) {
            uint8_t rgb[WIDTH * HEIGHT * 3];
            cr_assert(
                walk_renderer_draw(s.renderer, &s.camera, v.objects, v.object_count, (WalkLook)look, &error));
            cr_assert(
                walk_renderer_wireframe(s.renderer, &s.camera, v.objects, all * v.object_count, red, &error));
            cr_assert(walk_renderer_finish_scene(s.renderer, &error) &&
                      walk_renderer_read(s.renderer, rgb, &error));
            int lines = 0, edges = 0, lined = 0;
            for (int i = 0; i < WIDTH * HEIGHT; i++) lines += is_red(rgb + 3 * i);
            count_edges(&s, rgb, &edges, &lined);
            if (all) {
                cr_assert(lines > WIDTH && lines < WIDTH * HEIGHT / 2, "%d pixels of lines", lines);
                cr_assert(edges > 50 && lined == edges, "%d of %d edges", lined, edges);
            } else {
                cr_assert_eq(renderer_check_differing(plain, rgb, WIDTH * HEIGHT), 0,
                             "lines without objects");
            }
        }
    }
    renderer_check_close_stage(&s);
}

// ---- baked light

// Interpolated at a corner of a surface as OpenGL does it.
static double texel_light(const WalkBake *bake, const WalkTexels *texels, const float *light, Vec3 corner) {
    Vec2 at = walk_bake_place(bake, texels, corner);
    double x = at.x - 0.5, y = at.y - 0.5, fx = x - floor(x), fy = y - floor(y);
    cr_assert(x >= 0 && y >= 0 && x < texels->width - 1 && y < texels->height - 1, "texel (%g, %g)", x, y);
    const float *t = light + (int)y * texels->width + (int)x;
    double top = (double)t[0] * (1 - fx) + (double)t[1] * fx,
           bottom = (double)t[texels->width] * (1 - fx) + (double)t[texels->width + 1] * fx;
    return top * (1 - fy) + bottom * fy;
}

typedef struct Corner {
    Vec3 point;
    Plane plane;
    int polygon, region, material;
    double light;
} Corner;

static bool same_surface(const Corner *a, const Corner *b) {
    return vec3_equal(a->point, b->point) && vec3_dot(a->plane.n, b->plane.n) > 1 - 1e-12 &&
           a->region == b->region && a->material == b->material;
}

// Proves that no seam shows: where surfaces of one plane, room and material meet, the light interpolated from the texels
// of either is the same. Tolerance: half a step of the screen. Out of doors very large surfaces have texels of other
// sides than their neighbours'.
Test(renderer, surfaces_have_no_seams, .timeout = 120) {
    Stage s;
    renderer_check_open_stage(&s, "build/maps/house.plan");
    const CellGraph *g = &s.graph;
    WalkLights lights = walk_lights(g, vec3(0, 0, 0), &s.arena);
    WalkBake *bake = walk_bake_new(g, &lights, vec3(0, 0, 0), &s.arena);
    Corner *corners = NULL;
    int count = 0, capacity = 0, compared = 0;
    for (int o = g->surface_first[0]; o < g->surface_first[g->cell_count]; o++) {
        int region = lights.region[o], polygon = g->objects[o].first_polygon;
        const Polygon *p = &g->polygons[polygon];
        const Vec3 *v = g->vertices + p->first_vertex;
        if (s.building.regions[region].kind == REGION_OUTDOORS) continue;
        WalkTexels texels = walk_bake_texels(bake, o, polygon, 1);
        float *texel = ARENA_ARRAY(&s.arena, float, texels.width *texels.height);
        walk_bake_fill(bake, o, polygon, &texels, texel, (size_t)texels.width);
        for (int i = 0; i < p->vertex_count; i++) {
            double light = texel_light(bake, &texels, texel, v[i]);
            cr_assert(light > 0.1 && light < 3, "light of %g", light);
            *ARENA_PUSH(&s.arena, corners, count, capacity) =
                (Corner){v[i], plane_of_polygon(v, p->vertex_count), polygon, region, p->material, light};
        }
    }
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < i; k++) {
            if (!same_surface(&corners[i], &corners[k])) continue;
            compared++;
            cr_assert_float_eq(corners[i].light, corners[k].light, 0.5 / 255,
                               "polygons %d and %d meet in %.4f and %.4f", corners[i].polygon,
                               corners[k].polygon, corners[i].light, corners[k].light);
        }
    }
    cr_assert_gt(compared, 100);
    renderer_check_close_stage(&s);
}

// Proves that panels let into ceilings are lamps: each room of a plan that has no lights but such panels has one, and it
// hangs in that room.
Test(renderer, panels_are_lamps) {
    Stage s;
    renderer_check_open_stage(&s, "build/maps/office-plain.plan");
    cr_assert_eq(s.building.light_count, 0, "the plan has lights now: take another");
    WalkLights lights = walk_lights(&s.graph, vec3(0, 0, 0), &s.arena);
    int rooms = 0;
    for (int c = 0; c < s.graph.cell_count; c++) {
        int region = s.graph.cells[c].region, o = s.graph.surface_first[c];
        if (s.building.regions[region].kind != REGION_ROOM || o == s.graph.surface_first[c + 1]) continue;
        rooms++;
        int count, first = walk_lamps_of(&lights, o, &count);
        cr_assert_gt(count, 0, "cell %d of %s has no lamp", c, s.building.regions[region].name);
        for (int i = first; i < first + count; i++) {
            const float *p = lights.lamps[i].position;
            int cell = vis_locate(&s.graph, vec3(p[0], p[1], p[2]), -1);
            cr_assert(cell >= 0 && s.graph.cells[cell].region == region, "a lamp hangs in another room");
            cr_assert(lights.lamps[i].strength > 0 && lights.lamps[i].strength < 3);
        }
    }
    cr_assert_gt(rooms, 50);
    renderer_check_close_stage(&s);
}

// Proves that ambient occlusion is what it says: the middle of a bare room is open, the foot of a wall and a corner are
// not, it opens with the way from the wall and never jumps; and furniture darkens the floor beside it.
Test(renderer, corners_are_dark) {
    Stage s;
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    WalkOcclusion *occlusion = walk_occlusion_new(&s.graph, &s.arena);
    // In the study, 0,0 to 4,3.5; a table stands around 2,1.75.
    int region = s.graph.cells[vis_locate(&s.graph, vec3(0.5, 3, 1), -1)].region;
    Vec3 up = vec3(0, 0, 1);
    cr_assert_float_eq(walk_occlusion_open(occlusion, vec3(0.65, 2.8, 0), up, region, -1), 1, 1e-12);
    double foot = walk_occlusion_open(occlusion, vec3(0, 2.4, 0), up, region, -1),
           corner = walk_occlusion_open(occlusion, vec3(0, 3.5, 0), up, region, -1);
    cr_assert(foot < 0.6 && foot > 0.2 && corner <= foot, "foot of the wall %g, corner %g", foot, corner);
    double before = foot;
    for (double x = 0; x < 0.6; x += 0.01) {
        double open = walk_occlusion_open(occlusion, vec3(x, 2.4, 0), up, region, -1);
        cr_assert(open >= before - 1e-12 && open - before < 0.05, "%g m from the wall %g after %g", x, open,
                  before);
        before = open;
    }
    double beside = walk_occlusion_open(occlusion, vec3(1.25, 1.75, 0), up, region, -1),
           under = walk_occlusion_open(occlusion, vec3(2, 1.75, 0), up, region, -1);
    cr_assert(under < beside && beside < 0.95, "beside the table %g, under it %g", beside, under);
    renderer_check_close_stage(&s);
}
