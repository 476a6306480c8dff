// walk_renderer.c - a frame in one of several looks. Fast: things in rooms and surfaces of cells, lit beforehand, then sky and glass.
// Fine: depth alone, ambient occlusion from it, the surfaces lit in the fragment shader with four samples a pixel, then sky and glass.
// Baked: elements in their light, then sky and glass. Row 0 of all frames is the top of the image: frames are drawn upside down, so that
// they are read as they are.
#include "engine/draw/walk_renderer.h"

#include <glad/gl.h>
#include <math.h>
#include <stdbool.h>

#include "engine/core/error.h"
#include "engine/core/vec.h"
#include "engine/draw/smooth.h"
#include "engine/draw/walk_lit.h"
#include "engine/draw/walk_mesh.h"
#include "engine/draw/walk_programs.h"
#include "engine/draw/walk_shaders.h"
#include "engine/draw/walk_targets.h"
#include "engine/gl/gl_context.h"
#include "engine/gl/gl_math.h"
#include "engine/lit/false_colour.h"
#include "engine/shade/walk_shade.h"

// How the light is shown.
typedef struct LitTone {
    double exposure;       // the factor of radiosities, m^2/W
    double outdoors;       // that of what lies outdoors
    FalseColour quantity;  // shown instead, unless it is FALSE_COLOUR_OFF
} LitTone;

static void set_number(unsigned program, const char *name, double x) {
    glUniform1f(glGetUniformLocation(program, name), (float)x);
}

static void set_named_vector(unsigned program, const char *name, double x, double y, double z) {
    glUniform3f(glGetUniformLocation(program, name), (float)x, (float)y, (float)z);
}

// Everything drawn from here on is shaded by this look: returns the program. `clip` [16] by columns; `eye` relative to the mesh's
// origin; `fade` as in walk_lit.h; `range` of the quantity; `pictures`: so is everything drawn that has a picture.
static unsigned lit_look_use(const LitLook *look, const LitTone *tone, LightRange range, const float *clip,
                             Vec3 eye, double fade, bool pictures) {
    bool numbers = tone->quantity != FALSE_COLOUR_OFF;
    unsigned program = numbers ? look->numbers : pictures ? look->pictured : look->lit;
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip"), 1, GL_FALSE, clip);
    set_named_vector(program, "eye", eye.x, eye.y, eye.z);
    set_number(program, "fade", fade);
    if (!numbers) {
        set_number(program, "exposure", tone->exposure);
        set_number(program, "exposure_outdoors", tone->outdoors);
        return program;
    }
    double weights[3];
    false_colour_weights(tone->quantity, weights);
    set_named_vector(program, "weights", weights[0], weights[1], weights[2]);
    glUniform1i(glGetUniformLocation(program, "arriving"), tone->quantity != FALSE_COLOUR_RADIOSITY);
    set_number(program, "low", range.low);
    set_number(program, "octaves", log2(range.high / range.low));
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glBindTexture(GL_TEXTURE_2D, look->scale);
    return program;
}

// Surfaces of cells are drawn a trifle farther than they lie, so that things on them, or let into them, show: by this
// share of their slope a pixel (a rasteriser rounds vertices to a 256th) and this many roundings of depth. Pictures in mirrors are drawn
// nearer than the mirror by as much.
#define WALK_OFFSET_SLOPE (1.0f / 64)
#define WALK_OFFSET_UNITS 8.0f

// The picture fades to a new state of the light in this time.
#define FADE_SECONDS 0.25

// False colours leave out glass, which has no value, and show the sky in this grey (linear in the screen's own curve).
#define NO_VALUE 0.12f

const char *const WALK_LOOK_NAMES[WALK_LOOKS] = {"fast", "fine", "baked"};

struct WalkRenderer {
    WalkTextures *textures;
    WalkMesh *mesh;
    WalkLit *lit;           // NULL: no light was baked
    WalkLit *next;          // light on another mesh, which is being uploaded; NULL: there is none
    int reserved;           // vertices of a room, 0: rooms are made as they are needed
    WalkLitRoom spare[2];   // rooms that `lit` and `next` do not have
    bool ready;             // it is uploaded, or the next state on the same mesh
    const LitLight *light;  // the newest state that is uploaded whole, or NULL
    bool plain;             // one sample a pixel
    LitTone tone;
    WalkTargets targets;
    WalkTarget drawn;  // the frame that the scene is in
    WalkPrograms programs;
    bool software;  // OpenGL draws with the processor
    Smoother smoother;
    Arena frame_arena;
    uint32_t *frame;  // [frame_pixels] room for the frame while its edges are smoothed
    size_t frame_pixels;
    unsigned no_vertices;       // the vertex array for programs that make their own vertices
    const MirrorView *mirrors;  // [mirror_count] of the frame
    int mirror_count;
    const Camera *camera;      // of the frame
    unsigned char *left_out;   // [polygon_count] the polygons of `inside`
    const MirrorView *inside;  // the mirror whose picture is being drawn; NULL: the frame itself is
};

// ---- set-up

static bool make_programs(WalkRenderer *w, const Building *b, Error *error) {
    int flags =
        (mirrors_in(b) ? SHADER_MIRRORS : 0) | (walk_textures_runs(w->textures) > 1 ? SHADER_PICTURES : 0);
    glGenVertexArrays(1, &w->no_vertices);
    return walk_programs_new(flags, walk_textures_has_sky(w->textures), &w->programs, error);
}

WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error) {
    WalkStoreLimits usual = walk_store_usual_limits();
    return walk_renderer_new_limited(graph, &usual, arena, error);
}

WalkRenderer *walk_renderer_new_limited(const CellGraph *graph, const WalkStoreLimits *limits, Arena *arena,
                                        Error *error) {
    WalkRenderer *w = ARENA_ARRAY(arena, WalkRenderer, 1);
    w->software = gl_is_software();
    w->left_out = ARENA_ARRAY(arena, unsigned char, graph->polygon_count + 1);
    w->textures = walk_textures_new(graph->building, arena, error);
    if (w->textures && make_programs(w, graph->building, error))
        w->mesh = walk_mesh_new(graph, w->textures, limits, arena, error);
    if (w->mesh && gl_check("uploading a building", error)) return w;
    walk_renderer_free(w);
    return NULL;
}

bool walk_renderer_light(WalkRenderer *w, const WalkLight *light, Arena *arena, Error *error) {
    LitMesh *mesh = lit_mesh_new(light->mesh, arena, arena);
    LitLight *state = ARENA_ARRAY(arena, LitLight, 1);
    *state = lit_light_new(mesh, arena);
    lit_light_fill(mesh, light->solution, light->door_open, state);
    walk_renderer_expect(w, mesh);
    walk_renderer_take(w, state, SIZE_MAX);
    return gl_check("uploading the light of a building", error);
}

void walk_renderer_reserve(WalkRenderer *w, int vertices, int rooms) {
    CORE_ASSERT(!w->reserved && rooms <= (int)(sizeof w->spare / sizeof *w->spare));
    w->reserved = vertices;
    for (int i = 0; i < rooms && vertices > 0; i++) w->spare[i] = walk_lit_room(vertices);
}

static WalkLitRoom take_room(WalkRenderer *w, int vertices) {
    WalkLitRoom none = {0};
    for (size_t i = 0; i < sizeof w->spare / sizeof *w->spare; i++) {
        WalkLitRoom room = w->spare[i];
        if (room.vertices == 0 || room.vertices < vertices) continue;
        w->spare[i] = none;
        return room;
    }
    return none;
}

// NULL is allowed.
static void end_lit(WalkRenderer *w, WalkLit *lit) {
    if (!lit) return;
    WalkLitRoom room = walk_lit_end(lit);
    for (size_t i = 0; i < sizeof w->spare / sizeof *w->spare && room.vertices == w->reserved; i++) {
        if (w->spare[i].vertices > 0) continue;
        w->spare[i] = room;
        return;
    }
    walk_lit_room_free(&room);
}

void walk_renderer_expect(WalkRenderer *w, LitMesh *mesh) {
    if (w->lit && walk_lit_mesh(w->lit) == mesh) return;
    if (w->next && walk_lit_mesh(w->next) == mesh) return;
    CORE_ASSERT(!w->next);
    WalkLit *lit = walk_lit_new(mesh, w->textures, take_room(w, lit_vertex_count(mesh)));
    walk_lit_pose(lit, NULL, NULL);
    *(w->lit ? &w->next : &w->lit) = lit;
}

bool walk_renderer_prepare(WalkRenderer *w, const LitLight *light, size_t bytes) {
    if (!w->ready) w->ready = walk_lit_upload(w->next ? w->next : w->lit, light, bytes);
    return w->ready;
}

void walk_renderer_drop(WalkRenderer *w) {
    w->ready = false;
    end_lit(w, w->next);
    w->next = NULL;
    if (w->light) return;
    end_lit(w, w->lit);
    w->lit = NULL;
}

void walk_renderer_darken(WalkRenderer *w) {
    w->light = NULL;
    walk_renderer_drop(w);
}

bool walk_renderer_take(WalkRenderer *w, const LitLight *light, size_t bytes) {
    CORE_ASSERT(!walk_renderer_fading(w));
    if (!walk_renderer_prepare(w, light, bytes)) return false;
    w->ready = false;
    if (w->next) {
        end_lit(w, w->lit);
        w->lit = w->next;
        w->next = NULL;
    }
    w->light = light;
    return true;
}

void walk_renderer_fade(WalkRenderer *w, double seconds) {
    if (w->lit) walk_lit_fade(w->lit, walk_lit_faded(w->lit) + seconds / FADE_SECONDS);
}

bool walk_renderer_fading(const WalkRenderer *w) { return w->light && walk_lit_faded(w->lit) < 1; }
const LitMesh *walk_renderer_mesh(const WalkRenderer *w) { return w->lit ? walk_lit_mesh(w->lit) : NULL; }
const LitLight *walk_renderer_lit(const WalkRenderer *w) { return w->light; }

void walk_renderer_plain(WalkRenderer *w, bool plain) { w->plain = plain; }

void walk_renderer_tone(WalkRenderer *w, double exposure, FalseColour quantity) {
    w->tone =
        (LitTone){exposure, w->light ? exposure_outdoors(exposure, &w->light->day) : exposure, quantity};
}

void walk_renderer_free(WalkRenderer *w) {
    if (!w) return;
    end_lit(w, w->lit);
    end_lit(w, w->next);
    for (size_t i = 0; i < sizeof w->spare / sizeof *w->spare; i++) walk_lit_room_free(&w->spare[i]);
    walk_targets_free(&w->targets);
    walk_mesh_free(w->mesh);
    walk_textures_free(w->textures);
    smooth_free(&w->smoother);
    arena_free(&w->frame_arena);
    walk_programs_free(&w->programs);
    glDeleteVertexArrays(1, &w->no_vertices);
}

void walk_renderer_pose(WalkRenderer *w, const float *door_open) {
    walk_mesh_pose(w->mesh, door_open);
    if (w->lit) walk_lit_pose(w->lit, w->light, door_open);
}

void walk_renderer_ahead(WalkRenderer *w, const StabForest *forest, int cell) {
    walk_mesh_ahead(w->mesh, &forest->seen, cell);
}

WalkStoreFigures walk_renderer_held(const WalkRenderer *w) { return walk_mesh_held(w->mesh); }

// ---- the scene

static void set_vector(int place, Vec3 v) { glUniform3f(place, (float)v.x, (float)v.y, (float)v.z); }

// Draws from here on what lies before the plane of the mirror whose picture is being drawn, everything where there is none: some OpenGL
// (Mesa 22) clips by a program's distance even while that is off. `place` of the uniform `mirror` of the program in use.
static void keep_before(const WalkRenderer *w, int place) {
    if (!(w->programs.flags & SHADER_MIRRORS)) return;
    Plane plane = w->inside ? w->inside->before : (Plane){{0, 0, 0}, -1};
    double offset = vec3_dot(plane.n, walk_mesh_origin(w->mesh)) - plane.d;
    glUniform4f(place, (float)plane.n.x, (float)plane.n.y, (float)plane.n.z, (float)offset);
    if (w->inside) glEnable(GL_CLIP_DISTANCE0);
}

// `run` as in walk_textures.h.
static const SceneProgram *use_scene(const WalkRenderer *w, SceneShader shader, int run,
                                     const Camera *camera) {
    const SceneProgram *program = run > 0 ? &w->programs.pictured[shader] : &w->programs.scene[shader];
    glUseProgram(program->program);
    mat4 clip = GLM_MAT4_ZERO_INIT;
    gl_clip_matrix(camera, WALK_NEAR, true, clip);
    glUniformMatrix4fv(program->clip, 1, GL_FALSE, &clip[0][0]);
    set_vector(program->eye, vec3_sub(camera->eye, walk_mesh_origin(w->mesh)));
    glUniform2f(program->size, (float)camera->width, (float)camera->height);
    keep_before(w, program->before);
    return program;
}

// A part of the draw list, each run by its own shader.
static void draw_part(const WalkRenderer *w, int part, SceneShader shader, const Camera *camera) {
    for (int run = 0; run < walk_textures_runs(w->textures); run++) {
        use_scene(w, shader, run, camera);
        if (run > 0) walk_textures_bind(w->textures, run);
        walk_mesh_draw(w->mesh, part, run);
    }
}

static void set_offset(bool surfaces) {
    if (!surfaces) {
        glDisable(GL_POLYGON_OFFSET_FILL);
        return;
    }
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(WALK_OFFSET_SLOPE, WALK_OFFSET_UNITS);
}

static void draw_solid(const WalkRenderer *w, SceneShader things, SceneShader surfaces,
                       const Camera *camera) {
    draw_part(w, WALK_THINGS, things, camera);
    set_offset(true);
    draw_part(w, WALK_SURFACES, surfaces, camera);
    set_offset(false);
}

static void draw_screen(const WalkRenderer *w, unsigned program) {
    glDisable(GL_CLIP_DISTANCE0);
    glUseProgram(program);
    glBindVertexArray(w->no_vertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void use_texture(unsigned texture) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glBindTexture(GL_TEXTURE_2D, texture);
}

// Inside a mirror only its pixels are drawn. `share`: pixels of the frame for one of the target.
static void set_scissor(const WalkRenderer *w, int share) {
    const MirrorView *m = w->inside;
    if (!m) return;
    glEnable(GL_SCISSOR_TEST);
    glScissor(m->left / share, m->top / share, (m->right - m->left) / share + 2,
              (m->bottom - m->top) / share + 2);
}

// Clears so that drawing reaches only the samples that the mirror covers: there the depth is the farthest, elsewhere the nearest.
static void clear_mirror(WalkRenderer *w) {
    const MirrorView *m = w->inside;
    set_scissor(w, 1);
    glClearColor(0, 0, 0, 0);
    glClearDepth(0);
    glClear(GL_DEPTH_BUFFER_BIT | GL_COLOR_BUFFER_BIT);
    w->inside = NULL;  // the mirror lies in the very plane before which its picture is drawn
    use_scene(w, SCENE_LINES, 0, w->camera);
    w->inside = m;
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthFunc(GL_ALWAYS);
    glDepthRange(1, 1);
    walk_mesh_draw_polygons(w->mesh, m->leaf, m->polygons, m->polygon_count);
    glDepthRange(0, 1);
    glDepthFunc(GL_LESS);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// Draws the depth of the solid surfaces, then the open share of each pixel.
static bool draw_occlusion(WalkRenderer *w, const Camera *camera, Error *error) {
    WalkTargets *t = &w->targets;
    if (!walk_targets_bind(t, WALK_TARGET_DEPTH, error)) return false;
    walk_mesh_bind(w->mesh);
    // All of it, since a pixel asks for those around it. Beside a mirror nothing is far or near enough to count.
    glClearDepth(w->inside ? 0 : 1);
    glClear(GL_DEPTH_BUFFER_BIT);
    if (w->inside) clear_mirror(w);
    use_scene(w, SCENE_DEPTH, 0, camera);
    walk_mesh_draw(w->mesh, WALK_THINGS, WALK_ALL_RUNS);
    set_offset(true);
    walk_mesh_draw(w->mesh, WALK_SURFACES, WALK_ALL_RUNS);
    set_offset(false);
    glDisable(GL_DEPTH_TEST);
    set_scissor(w, WALK_COARSE);
    if (!walk_targets_bind(t, WALK_TARGET_OCCLUSION, error)) return false;
    use_texture(t->texture[WALK_TARGET_DEPTH]);
    glUseProgram(w->programs.occlusion);
    glUniform2f(w->programs.occlusion_tangents, (float)camera->tan_x, (float)camera->tan_y);
    draw_screen(w, w->programs.occlusion);
    if (!walk_targets_bind(t, WALK_TARGET_BLUR, error)) return false;
    use_texture(t->texture[WALK_TARGET_OCCLUSION]);
    draw_screen(w, w->programs.blur);
    glEnable(GL_DEPTH_TEST);
    return true;
}

static void set_three(int place, const double v[3], double scale) {
    glUniform3f(place, (float)(v[0] * scale), (float)(v[1] * scale), (float)(v[2] * scale));
}

// The day of baked light, as bright on the screen as the light that it sends.
static void set_day(const WalkRenderer *w, const SkyProgram *sky, const Daylight *day) {
    double ground[3];
    const double *cie = day->cie;
    daylight_seen_ground(day, ground);
    set_vector(sky->lit[SKY_SUN], day->sun);
    set_three(sky->lit[SKY_GROUND], ground, w->tone.outdoors);
    set_three(sky->lit[SKY_OVERHEAD], day->zenith, M_PI * w->tone.outdoors / daylight_overhead(day));
    glUniform2f(sky->lit[SKY_GRADATION], (float)cie[0], (float)cie[1]);
    glUniform3f(sky->lit[SKY_INDICATRIX], (float)cie[2], (float)cie[3], (float)cie[4]);
    glUniform1f(sky->lit[SKY_SUN_SHINES], rgb_sum(day->beam) > 0);
}

// How much the texels of the sky's picture are multiplied by to be as bright as the sky shown otherwise, on average.
static double sky_luminance(const WalkRenderer *w, const Daylight *lit) {
    double mean[3];
    if (!lit) return (double)WALK_SKY_LUMINANCE;
    daylight_mean(lit, mean);
    return M_PI * w->tone.outdoors * (0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2]);
}

// `lit`: the day of baked light, or NULL. The picture of a sky is shown by day.
static void draw_sky(const WalkRenderer *w, const Camera *camera, bool day, const Daylight *lit) {
    bool shines = lit && daylight_shines(lit);
    bool picture = (day || shines) && walk_textures_has_sky(w->textures);
    const SkyProgram *sky = picture ? &w->programs.pictured_sky : &w->programs.sky;
    glUseProgram(sky->program);
    glUniform1f(sky->day, day);
    glUniform1i(sky->lit[SKY_LIT], shines);
    if (shines) set_day(w, sky, lit);
    if (picture) {
        double strength[3];
        glUniform1f(sky->start, walk_textures_bind_sky(w->textures, strength));
        set_three(sky->strength, strength, sky_luminance(w, shines ? lit : NULL));
    }
    set_vector(sky->forward, camera->forward);
    set_vector(sky->right, vec3_scale(camera->right, camera->tan_x));
    set_vector(sky->up, vec3_scale(camera->up, -camera->tan_y));
    glDepthFunc(GL_LEQUAL);
    draw_screen(w, sky->program);
    glDepthFunc(GL_LESS);
}

// Pictures with holes come first, since they hide what is behind them, unlike glass.
static void draw_panes(const WalkRenderer *w, SceneShader shader, const Camera *camera, bool day) {
    glEnable(GL_BLEND);
    // Alpha stays 1.
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    walk_mesh_bind(w->mesh);
    for (int run = walk_textures_runs(w->textures) - 1; run >= 0; run--) {
        glDepthMask(run > 0);
        glUniform1f(use_scene(w, shader, run, camera)->day, day);
        if (run > 0) walk_textures_bind(w->textures, run);
        walk_mesh_draw(w->mesh, WALK_PANES, run);
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

// Draws over the mirrors what is seen in them. A mirror seen in a mirror shows its own colour.
static void draw_mirrors(const WalkRenderer *w, const Camera *camera) {
    if (w->inside || w->mirror_count == 0) return;
    const SceneProgram *program = use_scene(w, SCENE_MIRROR, 0, camera);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(-WALK_OFFSET_SLOPE, -WALK_OFFSET_UNITS);
    for (int i = 0; i < w->mirror_count; i++) {
        use_texture(w->targets.texture[WALK_TARGET_MIRROR + i]);
        glUniform1f(program->share, w->mirrors[i].share);
        const MirrorView *m = &w->mirrors[i];
        walk_mesh_draw_polygons(w->mesh, m->leaf, m->polygons, m->polygon_count);
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_BLEND);
}

static bool begin_frame(WalkRenderer *w, WalkTarget target, Error *error) {
    w->drawn = target;
    if (!walk_targets_bind(&w->targets, target, error)) return false;
    walk_mesh_bind(w->mesh);
    if (w->inside)
        clear_mirror(w);
    else
        glClear(GL_DEPTH_BUFFER_BIT | GL_COLOR_BUFFER_BIT);
    return true;
}

static bool draw_fast(WalkRenderer *w, const Camera *camera, Error *error) {
    if (!begin_frame(w, WALK_TARGET_FAST, error)) return false;
    draw_solid(w, SCENE_THINGS, SCENE_SURFACES, camera);
    draw_sky(w, camera, true, NULL);
    draw_mirrors(w, camera);
    draw_panes(w, SCENE_PANES, camera, true);
    return true;
}

static bool draw_fine(WalkRenderer *w, const Camera *camera, Error *error) {
    if (!draw_occlusion(w, camera, error) || !begin_frame(w, WALK_TARGET_FINE, error)) return false;
    use_texture(w->targets.texture[WALK_TARGET_BLUR]);
    draw_solid(w, SCENE_FINE, SCENE_FINE, camera);
    draw_sky(w, camera, true, NULL);
    draw_mirrors(w, camera);
    draw_panes(w, SCENE_FINE_PANES, camera, true);
    return true;
}

static void draw_lit(const WalkRenderer *w, const Camera *camera, bool surfaces) {
    mat4 clip = GLM_MAT4_ZERO_INIT;
    gl_clip_matrix(camera, WALK_NEAR, true, clip);
    walk_lit_bind(w->lit);
    for (int run = 0; run < walk_textures_runs(w->textures); run++) {
        unsigned program =
            lit_look_use(&w->programs.lit, &w->tone, w->light->ranges[w->tone.quantity], &clip[0][0],
                         vec3_sub(camera->eye, walk_mesh_origin(w->mesh)), walk_lit_faded(w->lit), run > 0);
        keep_before(w, glGetUniformLocation(program, "mirror"));
        if (run > 0) walk_textures_bind(w->textures, run);
        walk_lit_draw(w->lit, surfaces, run);
    }
}

static bool draw_baked(WalkRenderer *w, const Camera *camera, Error *error) {
    bool numbers = w->tone.quantity != FALSE_COLOUR_OFF;
    if (numbers) glClearColor(NO_VALUE, NO_VALUE, NO_VALUE, 1);
    if (!begin_frame(w, w->plain ? WALK_TARGET_FAST : WALK_TARGET_FINE, error)) return false;
    draw_lit(w, camera, false);
    set_offset(true);
    draw_lit(w, camera, true);
    set_offset(false);
    if (numbers) return true;
    draw_sky(w, camera, false, &w->light->day);
    draw_mirrors(w, camera);
    draw_panes(w, SCENE_PANES, camera, daylight_shines(&w->light->day));
    return true;
}

// Sets all the state that drawing here relies on, since others draw in the same context.
static void set_state(void) {
    static const unsigned OFF[] = {GL_BLEND,        GL_CULL_FACE,           GL_SCISSOR_TEST,
                                   GL_STENCIL_TEST, GL_POLYGON_OFFSET_FILL, GL_CLIP_DISTANCE0};
    for (size_t i = 0; i < sizeof OFF / sizeof *OFF; i++) glDisable(OFF[i]);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_MULTISAMPLE);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearDepth(1);
    glClearColor(0, 0, 0, 1);
}

static bool draw_objects(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                         WalkLook look, Error *error) {
    set_state();
    const unsigned char *left_out = w->inside ? w->left_out : NULL;
    bool baked = look == WALK_BAKED && w->light, good;
    walk_mesh_list(w->mesh, camera->eye, objects, object_count, left_out, baked);
    if (baked) {
        walk_lit_list(w->lit, camera->eye, objects, object_count, left_out);
        good = draw_baked(w, camera, error);
    } else {
        good = look == WALK_FINE ? draw_fine(w, camera, error) : draw_fast(w, camera, error);
    }
    return good && gl_check("drawing", error);
}

// Draws what is seen in the mirror as a frame of its own, of which the mirror's pixels are kept as the mirror's picture.
static bool draw_inside(WalkRenderer *w, int mirror, WalkLook look, Error *error) {
    const MirrorView *m = w->inside = &w->mirrors[mirror];
    for (int i = 0; i < m->polygon_count; i++) w->left_out[m->polygons[i]] = 1;
    bool good = draw_objects(w, &m->camera, m->objects, m->object_count, look, error);
    for (int i = 0; i < m->polygon_count; i++) w->left_out[m->polygons[i]] = 0;
    w->inside = NULL;
    if (!good || !walk_targets_bind(&w->targets, WALK_TARGET_MIRROR + (WalkTarget)mirror, error))
        return false;
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_CLIP_DISTANCE0);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, w->targets.frame[w->drawn]);
    glBlitFramebuffer(m->left, m->top, m->right, m->bottom, m->left, m->top, m->right, m->bottom,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    return gl_check("drawing a mirror", error);
}

void walk_renderer_mirrors(WalkRenderer *w, const MirrorView *views, int count) {
    w->mirrors = views;
    w->mirror_count = count;
}

bool walk_renderer_draw(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                        WalkLook look, Error *error) {
    CORE_ASSERT(look < WALK_LOOKS);
    if (!walk_targets_resize(&w->targets, camera->width, camera->height, error)) return false;
    if (look == WALK_BAKED && w->light && w->tone.quantity != FALSE_COLOUR_OFF) w->mirror_count = 0;
    w->camera = camera;
    for (int i = 0; i < w->mirror_count; i++) {
        if (!draw_inside(w, i, look, error)) return false;
    }
    return draw_objects(w, camera, objects, object_count, look, error);
}

bool walk_renderer_wireframe(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                             const float colour[4], Error *error) {
    if (!walk_targets_bind(&w->targets, w->drawn, error)) return false;
    set_state();
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    const SceneProgram *lines = use_scene(w, SCENE_LINES, 0, camera);
    glUniform4fv(lines->colour, 1, colour);
    walk_mesh_draw_edges(w->mesh, objects, object_count);
    glDisable(GL_BLEND);
    return gl_check("drawing lines", error);
}

// ---- the final frame

// Copies the frame that is bound for reading to the final one, with its edges smoothed. In software both lie in this process's memory.
static void smooth_frame(WalkRenderer *w) {
    const WalkTargets *t = &w->targets;
    size_t pixels = (size_t)t->width * (size_t)t->height;
    if (w->frame_pixels != pixels) {
        arena_free(&w->frame_arena);
        w->frame = ARENA_ARRAY(&w->frame_arena, uint32_t, pixels);
        w->frame_pixels = pixels;
    }
    // Rows follow one another without gaps.
    glPixelStorei(GL_PACK_ALIGNMENT, sizeof *w->frame);
    glPixelStorei(GL_UNPACK_ALIGNMENT, sizeof *w->frame);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, t->width, t->height, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, w->frame);
    smooth_edges(&w->smoother, w->frame, t->width, t->height);
    use_texture(t->texture[WALK_TARGET_FINAL]);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, t->width, t->height, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV,
                    w->frame);
}

bool walk_renderer_finish_scene(WalkRenderer *w, Error *error) {
    WalkTargets *t = &w->targets;
    if (!walk_targets_bind(t, WALK_TARGET_FINAL, error)) return false;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, t->frame[w->drawn]);
    // False colours are numbers: between two of them lies none.
    if (w->drawn == WALK_TARGET_FAST && w->software && w->tone.quantity == FALSE_COLOUR_OFF)
        smooth_frame(w);
    else
        glBlitFramebuffer(0, 0, t->width, t->height, 0, 0, t->width, t->height, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, t->frame[WALK_TARGET_FINAL]);
    glDisable(GL_DEPTH_TEST);
    return gl_check("finishing a frame", error);
}

void walk_renderer_show(WalkRenderer *w, unsigned framebuffer, int width, int height) {
    const WalkTargets *t = &w->targets;
    bool same = width == t->width && height == t->height;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, t->frame[WALK_TARGET_FINAL]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glBlitFramebuffer(0, 0, t->width, t->height, 0, height, width, 0, GL_COLOR_BUFFER_BIT,
                      same ? GL_NEAREST : GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

void walk_renderer_finish(void) { glFinish(); }

bool walk_renderer_read(WalkRenderer *w, uint8_t *rgb, Error *error) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, w->targets.frame[WALK_TARGET_FINAL]);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, w->targets.width, w->targets.height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
    return gl_check("reading an image back", error);
}
