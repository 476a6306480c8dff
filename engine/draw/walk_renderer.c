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
#include "engine/draw/false_colour.h"
#include "engine/draw/smooth.h"
#include "engine/draw/walk_lit.h"
#include "engine/draw/walk_mesh.h"
#include "engine/draw/walk_shade.h"
#include "engine/draw/walk_shaders.h"
#include "engine/gl/gl_context.h"
#include "engine/gl/gl_math.h"

typedef struct LitLook {
    unsigned lit, numbers;  // programs
    unsigned scale;         // the scale of false colours, a texture
} LitLook;

// How the light is shown.
typedef struct LitTone {
    double exposure;       // the factor of radiosities, m^2/W
    FalseColour quantity;  // shown instead, unless it is FALSE_COLOUR_OFF
} LitTone;

// The frames that looks draw to. Each is made when it is first needed in a size.
typedef enum WalkTarget {
    WALK_TARGET_FINAL,      // colour alone: the frame that is shown and read
    WALK_TARGET_FAST,       // colour, a texture, and depth, one sample a pixel
    WALK_TARGET_FINE,       // colour and depth, several samples a pixel
    WALK_TARGET_DEPTH,      // depth alone, a texture
    WALK_TARGET_OCCLUSION,  // open share and distance, a texture, coarser
    WALK_TARGET_BLUR,       // the open share smoothed, a texture, as coarse
    WALK_TARGETS
} WalkTarget;

typedef struct WalkTargets {
    unsigned frame[WALK_TARGETS];    // framebuffer objects, 0: not made
    unsigned texture[WALK_TARGETS];  // of the targets that are textures
    unsigned fast_depth, fine_colour, fine_depth;
    int width, height;
} WalkTargets;

// ---- programs, their uniforms, and the scale of false colours as a texture.

static unsigned make_scale(void) {
    enum { COLOURS = 256 };
    uint8_t texels[COLOURS][4];
    unsigned texture;
    for (int i = 0; i < COLOURS; i++) {
        Rgb c = false_colour_at((i + 0.5) / COLOURS);
        texels[i][0] = (uint8_t)lrintf(255 * c.r);
        texels[i][1] = (uint8_t)lrintf(255 * c.g);
        texels[i][2] = (uint8_t)lrintf(255 * c.b);
        texels[i][3] = 255;
    }
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, COLOURS, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

static bool lit_look_new(LitLook *out, Error *error) {
    *out = (LitLook){.lit = gl_program(WALK_LIT_VERTEX, WALK_LIT_FRAGMENT, error)};
    if (out->lit) out->numbers = gl_program(WALK_FALSE_VERTEX, WALK_FALSE_FRAGMENT, error);
    if (!out->numbers) return false;
    glUseProgram(out->numbers);
    glUniform1i(glGetUniformLocation(out->numbers, "materials"), WALK_UNIT_LAMPS);
    glUniform1i(glGetUniformLocation(out->numbers, "scale"), WALK_UNIT_FREE);
    out->scale = make_scale();
    return true;
}

static void lit_look_free(LitLook *look) {
    glDeleteProgram(look->lit);
    glDeleteProgram(look->numbers);
    glDeleteTextures(1, &look->scale);
}

static void set_number(unsigned program, const char *name, double x) {
    glUniform1f(glGetUniformLocation(program, name), (float)x);
}

static void set_named_vector(unsigned program, const char *name, double x, double y, double z) {
    glUniform3f(glGetUniformLocation(program, name), (float)x, (float)y, (float)z);
}

// Everything drawn from here on is shaded by this look. `clip` [16] by columns; `eye` relative to the mesh's origin; `fade` as in
// walk_lit.h; `range` of the quantity.
static void lit_look_use(const LitLook *look, const LitTone *tone, LightRange range, const float *clip,
                         Vec3 eye, double fade) {
    bool numbers = tone->quantity != FALSE_COLOUR_OFF;
    unsigned program = numbers ? look->numbers : look->lit;
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip"), 1, GL_FALSE, clip);
    set_named_vector(program, "eye", eye.x, eye.y, eye.z);
    set_number(program, "fade", fade);
    if (!numbers) {
        set_number(program, "exposure", tone->exposure);
        return;
    }
    double weights[3];
    false_colour_weights(tone->quantity, weights);
    set_named_vector(program, "weights", weights[0], weights[1], weights[2]);
    glUniform1i(glGetUniformLocation(program, "arriving"), tone->quantity != FALSE_COLOUR_RADIOSITY);
    set_number(program, "low", range.low);
    set_number(program, "octaves", log2(range.high / range.low));
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glBindTexture(GL_TEXTURE_2D, look->scale);
}

// ---- framebuffer objects, made when needed: a window in the fast look never pays for the fine look's samples.

#define FINE_SAMPLES 4
// Ambient occlusion is smooth: it is computed for every second pixel each way.
#define COARSE 2

static int coarse(int pixels) { return (pixels + COARSE - 1) / COARSE; }

static void walk_targets_free(WalkTargets *t) {
    unsigned buffers[] = {t->fast_depth, t->fine_colour, t->fine_depth};
    glDeleteFramebuffers(WALK_TARGETS, t->frame);
    glDeleteTextures(WALK_TARGETS, t->texture);
    glDeleteRenderbuffers(3, buffers);
    *t = (WalkTargets){0};
}

// Drops the frames when the size has changed; they are made again when needed.
static bool walk_targets_resize(WalkTargets *t, int width, int height, Error *error) {
    if (t->width == width && t->height == height) return true;
    walk_targets_free(t);
    int most = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    if (width < 1 || height < 1 || width > most || height > most)
        return error_set(error, "OpenGL: an image of %d x %d pixels (1 to %d each)", width, height, most);
    t->width = width;
    t->height = height;
    return true;
}

typedef struct TextureKind {
    int internal;
    unsigned format, type, attachment;
    int filter;
    bool coarse;
} TextureKind;

static const TextureKind TEXTURES[WALK_TARGETS] = {
    // This format is a software window's own order of bytes: showing the frame is then a plain copy there, in a sixth of the time.
    // A sized format would be laid out in the order of its name.
    [WALK_TARGET_FINAL] = {GL_RGBA, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, GL_COLOR_ATTACHMENT0, GL_NEAREST,
                           false},
    [WALK_TARGET_FAST] = {GL_RGBA, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, GL_COLOR_ATTACHMENT0, GL_NEAREST,
                          false},
    [WALK_TARGET_DEPTH] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, GL_DEPTH_ATTACHMENT,
                           GL_NEAREST, false},
    [WALK_TARGET_OCCLUSION] = {GL_RG32F, GL_RG, GL_FLOAT, GL_COLOR_ATTACHMENT0, GL_NEAREST, true},
    [WALK_TARGET_BLUR] = {GL_R32F, GL_RED, GL_FLOAT, GL_COLOR_ATTACHMENT0, GL_LINEAR, true},
};

static void make_texture(WalkTargets *t, WalkTarget which) {
    const TextureKind *kind = &TEXTURES[which];
    glGenTextures(1, &t->texture[which]);
    glBindTexture(GL_TEXTURE_2D, t->texture[which]);
    glTexImage2D(GL_TEXTURE_2D, 0, kind->internal, kind->coarse ? coarse(t->width) : t->width,
                 kind->coarse ? coarse(t->height) : t->height, 0, kind->format, kind->type, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, kind->filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, kind->filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static void attach_buffer(unsigned *buffer, unsigned attachment, unsigned format, int samples,
                          const WalkTargets *t) {
    glGenRenderbuffers(1, buffer);
    glBindRenderbuffer(GL_RENDERBUFFER, *buffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, t->width, t->height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, *buffer);
}

static void attach_texture(const WalkTargets *t, WalkTarget which) {
    glFramebufferTexture2D(GL_FRAMEBUFFER, TEXTURES[which].attachment, GL_TEXTURE_2D, t->texture[which], 0);
}

static void attach(WalkTargets *t, WalkTarget which) {
    int samples = 0;
    switch (which) {
    case WALK_TARGET_FAST:
        attach_texture(t, WALK_TARGET_FAST);
        attach_buffer(&t->fast_depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, 0, t);
        break;
    case WALK_TARGET_FINE:
        glGetIntegerv(GL_MAX_SAMPLES, &samples);
        if (samples > FINE_SAMPLES) samples = FINE_SAMPLES;
        attach_buffer(&t->fine_colour, GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, t);
        attach_buffer(&t->fine_depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, samples, t);
        break;
    default:
        attach_texture(t, which);
    }
    if (which == WALK_TARGET_DEPTH) {
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
    }
}

static bool make(WalkTargets *t, WalkTarget which, Error *error) {
    if (which != WALK_TARGET_FINE) make_texture(t, which);
    glGenFramebuffers(1, &t->frame[which]);
    glBindFramebuffer(GL_FRAMEBUFFER, t->frame[which]);
    attach(t, which);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
        return gl_check("making a frame", error);
    error_set(error, "OpenGL: no frame of %d x %d pixels", t->width, t->height);
    // The frame must not pass for a complete one the next time.
    walk_targets_free(t);
    return false;
}

// Binds a frame for drawing, with its viewport; makes the frame first if there is none.
static bool walk_targets_bind(WalkTargets *t, WalkTarget which, Error *error) {
    if (!t->frame[which] && !make(t, which, error)) return false;
    bool is_coarse = TEXTURES[which].coarse;
    glBindFramebuffer(GL_FRAMEBUFFER, t->frame[which]);
    glViewport(0, 0, is_coarse ? coarse(t->width) : t->width, is_coarse ? coarse(t->height) : t->height);
    return true;
}

// Nothing nearer than this is drawn, metres: it is less than a head's distance from any wall; depth, a float of 1 - near/z,
// is then good to a fifth of a millimetre at 10 m.
#define WALK_NEAR 0.05
// Surfaces of cells are drawn a trifle farther than they lie, so that things on them, or let into them, show: by this
// share of their slope a pixel (a rasteriser rounds vertices to a 256th) and this many roundings of depth.
#define WALK_OFFSET_SLOPE (1.0f / 64)
#define WALK_OFFSET_UNITS 8.0f

// The picture fades to a new state of the light in this time.
#define FADE_SECONDS 0.25

// False colours leave out glass, which has no value, and show the sky in this grey (linear in the screen's own curve).
#define NO_VALUE 0.12f

const char *const WALK_LOOK_NAMES[WALK_LOOKS] = {"fast", "fine", "baked"};

typedef enum SceneShader {
    SCENE_THINGS,    // fast
    SCENE_SURFACES,  // fast
    SCENE_PANES,     // fast
    SCENE_DEPTH,     // fine
    SCENE_FINE,
    SCENE_LINES,
    SCENE_SHADERS
} SceneShader;

// A program that draws the building, and the locations of its uniforms; -1 for uniforms that it lacks.
typedef struct SceneProgram {
    unsigned program;
    int clip, eye, size, colour, day;
} SceneProgram;

// Places of what tells the sky of baked light.
enum {
    SKY_LIT,
    SKY_SUN,
    SKY_GROUND,
    SKY_OVERHEAD,
    SKY_GRADATION,
    SKY_INDICATRIX,
    SKY_SUN_SHINES,
    SKY_PLACES
};

struct WalkRenderer {
    WalkMesh *mesh;
    WalkLit *lit;           // NULL: no light was baked
    WalkLit *next;          // light on another mesh, which is being uploaded; NULL: there is none
    const LitLight *light;  // the newest state that is uploaded whole, or NULL
    bool plain;             // one sample a pixel
    LitLook lit_look;
    LitTone tone;
    WalkTargets targets;
    WalkTarget drawn;  // the frame that the scene is in
    SceneProgram scene[SCENE_SHADERS];
    unsigned sky, occlusion, blur;  // programs
    int sky_forward, sky_right, sky_up, sky_day, occlusion_tangents;
    int sky_lit[SKY_PLACES];
    bool software;  // OpenGL draws with the processor
    Smoother smoother;
    Arena frame_arena;
    uint32_t *frame;       // as large as the smoother's
    unsigned no_vertices;  // the vertex array for programs that make their own vertices
};

// ---- set-up

static bool make_scene_program(SceneProgram *out, const char *vertex, const char *fragment, Error *error) {
    unsigned program = gl_program(vertex, fragment, error);
    if (program == 0) return false;
    *out = (SceneProgram){program,
                          glGetUniformLocation(program, "clip"),
                          glGetUniformLocation(program, "eye"),
                          glGetUniformLocation(program, "size"),
                          glGetUniformLocation(program, "colour"),
                          glGetUniformLocation(program, "day")};
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "lamps"), WALK_UNIT_LAMPS);
    glUniform1i(glGetUniformLocation(program, "atlas"), WALK_UNIT_ATLAS);
    glUniform1i(glGetUniformLocation(program, "occlusion"), WALK_UNIT_FREE);
    return true;
}

static bool make_scene_programs(WalkRenderer *w, Error *error) {
    static const struct {
        const char *vertex, *fragment;
    } SHADERS[SCENE_SHADERS] = {
        [SCENE_THINGS] = {WALK_THING_VERTEX, WALK_THING_FRAGMENT},
        [SCENE_SURFACES] = {WALK_BAKED_VERTEX, WALK_BAKED_FRAGMENT},
        [SCENE_PANES] = {WALK_THING_VERTEX, WALK_PANE_FRAGMENT},
        [SCENE_DEPTH] = {WALK_LINE_VERTEX, WALK_DEPTH_FRAGMENT},
        [SCENE_FINE] = {WALK_FINE_VERTEX, WALK_FINE_FRAGMENT},
        [SCENE_LINES] = {WALK_LINE_VERTEX, WALK_LINE_FRAGMENT},
    };
    for (int i = 0; i < SCENE_SHADERS; i++) {
        if (!make_scene_program(&w->scene[i], SHADERS[i].vertex, SHADERS[i].fragment, error)) return false;
    }
    return true;
}

static bool make_programs(WalkRenderer *w, Error *error) {
    if (!make_scene_programs(w, error)) return false;
    w->sky = gl_program(WALK_SCREEN_VERTEX, WALK_SKY_FRAGMENT, error);
    w->occlusion = w->sky ? gl_program(WALK_SCREEN_VERTEX, WALK_OCCLUSION_FRAGMENT, error) : 0;
    w->blur = w->occlusion ? gl_program(WALK_SCREEN_VERTEX, WALK_BLUR_FRAGMENT, error) : 0;
    if (!w->blur) return false;
    w->sky_forward = glGetUniformLocation(w->sky, "forward");
    w->sky_right = glGetUniformLocation(w->sky, "right");
    w->sky_up = glGetUniformLocation(w->sky, "up");
    w->sky_day = glGetUniformLocation(w->sky, "day");
    static const char *const LIT[SKY_PLACES] = {"lit",       "sun",        "lit_ground", "overhead",
                                                "gradation", "indicatrix", "sun_shines"};
    for (int i = 0; i < SKY_PLACES; i++) w->sky_lit[i] = glGetUniformLocation(w->sky, LIT[i]);
    w->occlusion_tangents = glGetUniformLocation(w->occlusion, "tangents");
    glUseProgram(w->occlusion);
    glUniform1i(glGetUniformLocation(w->occlusion, "depth"), WALK_UNIT_FREE);
    glUniform1f(glGetUniformLocation(w->occlusion, "near"), (float)WALK_NEAR);
    glUseProgram(w->blur);
    glUniform1i(glGetUniformLocation(w->blur, "source"), WALK_UNIT_FREE);
    glGenVertexArrays(1, &w->no_vertices);
    return lit_look_new(&w->lit_look, error);
}

WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error) {
    WalkRenderer *w = ARENA_ARRAY(arena, WalkRenderer, 1);
    w->software = gl_is_software();
    if (make_programs(w, error)) w->mesh = walk_mesh_new(graph, arena, error);
    if (w->mesh && gl_check("uploading a building", error)) return w;
    walk_renderer_free(w);
    return NULL;
}

bool walk_renderer_light(WalkRenderer *w, const WalkLight *light, Arena *arena, Error *error) {
    LitMesh *mesh = lit_mesh_new(light->mesh, arena);
    LitLight *state = ARENA_ARRAY(arena, LitLight, 1);
    *state = lit_light_new(mesh, arena);
    lit_light_fill(mesh, light->solution, state);
    walk_renderer_expect(w, mesh, arena);
    walk_renderer_take(w, state, SIZE_MAX);
    return gl_check("uploading the light of a building", error);
}

void walk_renderer_expect(WalkRenderer *w, LitMesh *mesh, Arena *arena) {
    if (w->lit && walk_lit_mesh(w->lit) == mesh) return;
    if (w->next && walk_lit_mesh(w->next) == mesh) return;
    CORE_ASSERT(!w->next);
    WalkLit *lit = walk_lit_new(mesh, arena);
    walk_lit_pose(lit, NULL, NULL);
    *(w->lit ? &w->next : &w->lit) = lit;
}

bool walk_renderer_take(WalkRenderer *w, const LitLight *light, size_t bytes) {
    CORE_ASSERT(!walk_renderer_fading(w));
    if (!walk_lit_upload(w->next ? w->next : w->lit, light, bytes)) return false;
    if (w->next) {
        walk_lit_free(w->lit);
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
    w->tone = (LitTone){exposure, quantity};
}

void walk_renderer_free(WalkRenderer *w) {
    if (!w) return;
    walk_lit_free(w->lit);
    walk_lit_free(w->next);
    walk_targets_free(&w->targets);
    walk_mesh_free(w->mesh);
    smooth_free(&w->smoother);
    arena_free(&w->frame_arena);
    unsigned programs[] = {w->sky, w->occlusion, w->blur};
    for (int i = 0; i < 3; i++) glDeleteProgram(programs[i]);
    for (int i = 0; i < SCENE_SHADERS; i++) glDeleteProgram(w->scene[i].program);
    glDeleteVertexArrays(1, &w->no_vertices);
    lit_look_free(&w->lit_look);
}

void walk_renderer_pose(WalkRenderer *w, const float *door_open) {
    walk_mesh_pose(w->mesh, door_open);
    if (w->lit) walk_lit_pose(w->lit, w->light, door_open);
}

// ---- the scene

static void set_vector(int place, Vec3 v) { glUniform3f(place, (float)v.x, (float)v.y, (float)v.z); }

static const SceneProgram *use_scene(const WalkRenderer *w, SceneShader shader, const Camera *camera) {
    const SceneProgram *program = &w->scene[shader];
    glUseProgram(program->program);
    mat4 clip = GLM_MAT4_ZERO_INIT;
    gl_clip_matrix(camera, WALK_NEAR, true, clip);
    glUniformMatrix4fv(program->clip, 1, GL_FALSE, &clip[0][0]);
    set_vector(program->eye, vec3_sub(camera->eye, walk_mesh_origin(w->mesh)));
    glUniform2f(program->size, (float)camera->width, (float)camera->height);
    return program;
}

static void draw_surfaces(const WalkRenderer *w) {
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(WALK_OFFSET_SLOPE, WALK_OFFSET_UNITS);
    walk_mesh_draw(w->mesh, WALK_SURFACES);
    glDisable(GL_POLYGON_OFFSET_FILL);
}

static void draw_screen(const WalkRenderer *w, unsigned program) {
    glUseProgram(program);
    glBindVertexArray(w->no_vertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void use_texture(unsigned texture) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glBindTexture(GL_TEXTURE_2D, texture);
}

// Draws the depth of the solid surfaces, then the open share of each pixel.
static bool draw_occlusion(WalkRenderer *w, const Camera *camera, Error *error) {
    WalkTargets *t = &w->targets;
    if (!walk_targets_bind(t, WALK_TARGET_DEPTH, error)) return false;
    glClear(GL_DEPTH_BUFFER_BIT);
    walk_mesh_bind(w->mesh);
    use_scene(w, SCENE_DEPTH, camera);
    walk_mesh_draw(w->mesh, WALK_THINGS);
    draw_surfaces(w);
    glDisable(GL_DEPTH_TEST);
    if (!walk_targets_bind(t, WALK_TARGET_OCCLUSION, error)) return false;
    use_texture(t->texture[WALK_TARGET_DEPTH]);
    glUseProgram(w->occlusion);
    glUniform2f(w->occlusion_tangents, (float)camera->tan_x, (float)camera->tan_y);
    draw_screen(w, w->occlusion);
    if (!walk_targets_bind(t, WALK_TARGET_BLUR, error)) return false;
    use_texture(t->texture[WALK_TARGET_OCCLUSION]);
    draw_screen(w, w->blur);
    glEnable(GL_DEPTH_TEST);
    return true;
}

static void set_three(int place, const double v[3], double scale) {
    glUniform3f(place, (float)(v[0] * scale), (float)(v[1] * scale), (float)(v[2] * scale));
}

// The day of baked light, as bright on the screen as the light that it sends.
static void set_day(const WalkRenderer *w, const Daylight *day) {
    double ground[3];
    const double *cie = day->cie;
    daylight_seen_ground(day, ground);
    set_vector(w->sky_lit[SKY_SUN], day->sun);
    set_three(w->sky_lit[SKY_GROUND], ground, w->tone.exposure);
    set_three(w->sky_lit[SKY_OVERHEAD], day->zenith, M_PI * w->tone.exposure / daylight_overhead(day));
    glUniform2f(w->sky_lit[SKY_GRADATION], (float)cie[0], (float)cie[1]);
    glUniform3f(w->sky_lit[SKY_INDICATRIX], (float)cie[2], (float)cie[3], (float)cie[4]);
    glUniform1f(w->sky_lit[SKY_SUN_SHINES], rgb_sum(day->beam) > 0);
}

// `lit`: the day of baked light, or NULL.
static void draw_sky(const WalkRenderer *w, const Camera *camera, bool day, const Daylight *lit) {
    bool shines = lit && daylight_shines(lit);
    glUseProgram(w->sky);
    glUniform1f(w->sky_day, day);
    glUniform1i(w->sky_lit[SKY_LIT], shines);
    if (shines) set_day(w, lit);
    set_vector(w->sky_forward, camera->forward);
    set_vector(w->sky_right, vec3_scale(camera->right, camera->tan_x));
    set_vector(w->sky_up, vec3_scale(camera->up, -camera->tan_y));
    glDepthFunc(GL_LEQUAL);
    draw_screen(w, w->sky);
    glDepthFunc(GL_LESS);
}

static void draw_panes(const WalkRenderer *w, SceneShader shader, const Camera *camera, bool day) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    walk_mesh_bind(w->mesh);
    glUniform1f(use_scene(w, shader, camera)->day, day);
    walk_mesh_draw(w->mesh, WALK_PANES);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

static bool begin_frame(WalkRenderer *w, WalkTarget target, Error *error) {
    w->drawn = target;
    if (!walk_targets_bind(&w->targets, target, error)) return false;
    glClear(GL_DEPTH_BUFFER_BIT | GL_COLOR_BUFFER_BIT);
    walk_mesh_bind(w->mesh);
    return true;
}

static bool draw_fast(WalkRenderer *w, const Camera *camera, Error *error) {
    if (!begin_frame(w, WALK_TARGET_FAST, error)) return false;
    use_scene(w, SCENE_THINGS, camera);
    walk_mesh_draw(w->mesh, WALK_THINGS);
    use_scene(w, SCENE_SURFACES, camera);
    draw_surfaces(w);
    draw_sky(w, camera, true, NULL);
    draw_panes(w, SCENE_PANES, camera, true);
    return true;
}

static bool draw_fine(WalkRenderer *w, const Camera *camera, Error *error) {
    if (!draw_occlusion(w, camera, error) || !begin_frame(w, WALK_TARGET_FINE, error)) return false;
    use_texture(w->targets.texture[WALK_TARGET_BLUR]);
    use_scene(w, SCENE_FINE, camera);
    walk_mesh_draw(w->mesh, WALK_THINGS);
    draw_surfaces(w);
    draw_sky(w, camera, true, NULL);
    draw_panes(w, SCENE_FINE, camera, true);
    return true;
}

static void use_lit(const WalkRenderer *w, const Camera *camera) {
    mat4 clip = GLM_MAT4_ZERO_INIT;
    gl_clip_matrix(camera, WALK_NEAR, true, clip);
    walk_lit_bind(w->lit);
    lit_look_use(&w->lit_look, &w->tone, w->light->ranges[w->tone.quantity], &clip[0][0],
                 vec3_sub(camera->eye, walk_mesh_origin(w->mesh)), walk_lit_faded(w->lit));
}

static bool draw_baked(WalkRenderer *w, const Camera *camera, Error *error) {
    bool numbers = w->tone.quantity != FALSE_COLOUR_OFF;
    if (numbers) glClearColor(NO_VALUE, NO_VALUE, NO_VALUE, 1);
    if (!begin_frame(w, w->plain ? WALK_TARGET_FAST : WALK_TARGET_FINE, error)) return false;
    use_lit(w, camera);
    walk_lit_draw(w->lit, false);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(WALK_OFFSET_SLOPE, WALK_OFFSET_UNITS);
    walk_lit_draw(w->lit, true);
    glDisable(GL_POLYGON_OFFSET_FILL);
    if (numbers) return true;
    draw_sky(w, camera, false, &w->light->day);
    draw_panes(w, SCENE_PANES, camera, daylight_shines(&w->light->day));
    return true;
}

// Sets all the state that drawing here relies on, since others draw in the same context.
static void set_state(void) {
    static const unsigned OFF[] = {GL_BLEND, GL_CULL_FACE, GL_SCISSOR_TEST, GL_STENCIL_TEST,
                                   GL_POLYGON_OFFSET_FILL};
    for (size_t i = 0; i < sizeof OFF / sizeof *OFF; i++) glDisable(OFF[i]);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_MULTISAMPLE);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearDepth(1);
    glClearColor(0, 0, 0, 1);
}

bool walk_renderer_draw(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                        WalkLook look, Error *error) {
    CORE_ASSERT(look < WALK_LOOKS);
    if (!walk_targets_resize(&w->targets, camera->width, camera->height, error)) return false;
    set_state();
    walk_mesh_list(w->mesh, camera->eye, objects, object_count);
    bool baked = look == WALK_BAKED && w->light, good;
    if (baked) {
        walk_lit_list(w->lit, camera->eye, objects, object_count);
        good = draw_baked(w, camera, error);
    } else {
        good = look == WALK_FINE ? draw_fine(w, camera, error) : draw_fast(w, camera, error);
    }
    return good && gl_check("drawing", error);
}

bool walk_renderer_wireframe(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                             const float colour[4], Error *error) {
    if (!walk_targets_bind(&w->targets, w->drawn, error)) return false;
    set_state();
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    const SceneProgram *lines = use_scene(w, SCENE_LINES, camera);
    glUniform4fv(lines->colour, 1, colour);
    walk_mesh_draw_edges(w->mesh, objects, object_count);
    glDisable(GL_BLEND);
    return gl_check("drawing lines", error);
}

// ---- the final frame

// Copies the frame that is bound for reading to the final one, with its edges smoothed. In software both lie in this process's memory.
static void smooth_frame(WalkRenderer *w) {
    const WalkTargets *t = &w->targets;
    if (w->smoother.width != t->width || w->smoother.height != t->height) {
        arena_free(&w->frame_arena);
        w->frame = ARENA_ARRAY(&w->frame_arena, uint32_t, (size_t)t->width * (size_t)t->height);
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
