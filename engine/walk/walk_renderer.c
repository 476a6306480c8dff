// walk_renderer.c - the frame in four steps: depth alone, ambient occlusion from it, the shaded surfaces with four
// samples a pixel, then sky and glass. Positions are floats relative to the building's middle, rounded to metres: a
// building far from the origin is drawn alike.
#include "engine/walk/walk_renderer.h"

#include <glad/gl.h>

#include "engine/core/polygon.h"
#include "engine/walk/walk_lights.h"
#include "engine/walk/walk_shaders.h"
#include "visibility/hidden/gl_context.h"
#include "visibility/hidden/gl_math.h"

// Nearer than this nothing is drawn, metres: less than a head's distance from any wall; depth, a float of 1 - near/z,
// is then good to a fifth of a millimetre at 10 m.
#define WALK_NEAR 0.05
#define WALK_SAMPLES 4
// Ambient occlusion is smooth: it is computed for each second pixel each way.
#define WALK_COARSE 2
// Surfaces of cells lie a trifle farther than drawn, so that what stands on them, or is let into them, shows: by this
// share of their slope a pixel (a rasteriser rounds vertices to a 256th) and these roundings of depth.
#define WALK_OFFSET_SLOPE (1.0f / 64)
#define WALK_OFFSET_UNITS 8.0f

typedef struct WalkVertex {
    float position[3], normal[3];
    uint8_t colour[4], emission[4];
    int16_t lamps[2];
} WalkVertex;

enum { SOLID, GLASS, PASSES };  // two index ranges an object

// A program that draws the building, and the places of its uniforms; -1 where it has none of the name.
typedef struct SceneProgram {
    unsigned program;
    int clip, eye, size, one_sided;
} SceneProgram;

struct WalkRenderer {
    const CellGraph *graph;
    Vec3 origin;
    int *first_index[PASSES];  // [object_count + 1] in the index buffer
    GLsizei *run_count;        // [object_count] of the draw under way, in indices
    const void **run_offset;
    int run_total, run_own;  // run_own: of things, before the surfaces of cells
    int *glass;              // [object_count] to draw, farthest first
    double *glass_far;
    SceneProgram scene, depth_only;
    unsigned sky, occlusion, blur;  // programs
    int sky_forward, sky_right, sky_up, occlusion_tangents;
    unsigned array, vertex_buffer, index_buffer, lamp_buffer, lamp_texture;
    unsigned depth_frame, depth_texture, open_frame, open_texture, blur_frame, blur_texture;
    unsigned frame, colour_target, depth_target, flat_frame, flat_target;
    int width, height;
};

// ---- upload

static uint8_t byte(double x) { return (uint8_t)lround(255 * fmin(fmax(x, 0), 1)); }

static void fill_vertices(const WalkRenderer *w, int polygon, int object, const WalkLights *lights,
                          WalkVertex *out) {
    const CellGraph *graph = w->graph;
    const Polygon *p = &graph->polygons[polygon];
    const Material *m = &graph->building->materials[p->material];
    const Vec3 *v = graph->vertices + p->first_vertex;
    Vec3 n = plane_of_polygon(v, p->vertex_count).n;
    Rgb c = m->reflectance, e = m->emission;
    // Radiant exitance is out of a screen's range: any lamp is bright, of its own colour.
    double most = fmax(fmax(e.r, e.g), e.b), scale = most > 0 ? fmin(1, most) / most : 0;
    WalkVertex vertex = {.normal = {(float)n.x, (float)n.y, (float)n.z},
                         .colour = {byte(sqrt(c.r)), byte(sqrt(c.g)), byte(sqrt(c.b)), byte(m->alpha)},
                         .emission = {byte(e.r * scale), byte(e.g * scale), byte(e.b * scale),
                                      lights->outdoors[object] ? 255 : 0},
                         .lamps = {(int16_t)lights->first[object], (int16_t)lights->count[object]}};
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 at = vec3_sub(v[i], w->origin);
        out[i] = vertex;
        out[i].position[0] = (float)at.x;
        out[i].position[1] = (float)at.y;
        out[i].position[2] = (float)at.z;
    }
}

static int fill_indices(const CellGraph *graph, int pass, const int *first_vertex, int *first_index,
                        unsigned *index, int count) {
    for (int o = 0; o < graph->object_count; o++) {
        first_index[o] = count;
        for (int i = 0; i < graph->objects[o].polygon_count; i++) {
            int polygon = graph->objects[o].first_polygon + i;
            const Polygon *p = &graph->polygons[polygon];
            if (vis_is_glass(graph, polygon) != (pass == GLASS)) continue;
            int *triangle = (int *)(index + count);
            polygon_triangulate(graph->vertices + p->first_vertex, p->vertex_count, triangle);
            for (int k = 0; k < 3 * (p->vertex_count - 2); k++) triangle[k] += first_vertex[polygon];
            count += 3 * (p->vertex_count - 2);
        }
    }
    first_index[graph->object_count] = count;
    return count;
}

static void describe_vertices(void) {
    GLsizei stride = sizeof(WalkVertex);
    for (unsigned i = 0; i <= 4; i++) glEnableVertexAttribArray(i);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, (const void *)offsetof(WalkVertex, position));
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, (const void *)offsetof(WalkVertex, normal));
    glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          (const void *)offsetof(WalkVertex, colour));
    glVertexAttribPointer(3, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          (const void *)offsetof(WalkVertex, emission));
    glVertexAttribIPointer(4, 2, GL_SHORT, stride, (const void *)offsetof(WalkVertex, lamps));
}

static void upload_lamps(WalkRenderer *w, const WalkLights *lights) {
    glGenBuffers(1, &w->lamp_buffer);
    glBindBuffer(GL_TEXTURE_BUFFER, w->lamp_buffer);
    glBufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)((size_t)(lights->lamp_count + 1) * sizeof(WalkLamp)),
                 lights->lamps, GL_STATIC_DRAW);
    glGenTextures(1, &w->lamp_texture);
    glBindTexture(GL_TEXTURE_BUFFER, w->lamp_texture);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, w->lamp_buffer);
}

static void upload(WalkRenderer *w) {
    const CellGraph *graph = w->graph;
    Arena scratch = {0};
    WalkLights lights = walk_lights(graph, w->origin, &scratch);
    int *first_vertex = ARENA_ARRAY(&scratch, int, graph->polygon_count + 1), vertices = 0, indices = 0;
    for (int i = 0; i < graph->polygon_count; i++) {
        first_vertex[i] = vertices;
        vertices += graph->polygons[i].vertex_count;
        indices += 3 * (graph->polygons[i].vertex_count - 2);
    }
    WalkVertex *vertex = ARENA_ARRAY(&scratch, WalkVertex, vertices + 1);
    unsigned *index = ARENA_ARRAY(&scratch, unsigned, indices + 1);
    for (int o = 0; o < graph->object_count; o++) {
        for (int i = 0; i < graph->objects[o].polygon_count; i++) {
            int polygon = graph->objects[o].first_polygon + i;
            fill_vertices(w, polygon, o, &lights, vertex + first_vertex[polygon]);
        }
    }
    int count = fill_indices(graph, SOLID, first_vertex, w->first_index[SOLID], index, 0);
    count = fill_indices(graph, GLASS, first_vertex, w->first_index[GLASS], index, count);
    glGenVertexArrays(1, &w->array);
    glBindVertexArray(w->array);
    glGenBuffers(1, &w->vertex_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, w->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)vertices * sizeof *vertex), vertex, GL_STATIC_DRAW);
    describe_vertices();
    glGenBuffers(1, &w->index_buffer);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, w->index_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)count * sizeof *index), index, GL_STATIC_DRAW);
    upload_lamps(w, &lights);
    arena_free(&scratch);
}

static bool make_scene_program(SceneProgram *out, const char *fragment, Error *error) {
    unsigned program = gl_program(WALK_SCENE_VERTEX, fragment, error);
    *out =
        (SceneProgram){program, glGetUniformLocation(program, "clip"), glGetUniformLocation(program, "eye"),
                       glGetUniformLocation(program, "size"), glGetUniformLocation(program, "one_sided")};
    return program != 0;
}

static bool make_programs(WalkRenderer *w, Error *error) {
    if (!make_scene_program(&w->scene, WALK_SCENE_FRAGMENT, error) ||
        !make_scene_program(&w->depth_only, WALK_DEPTH_FRAGMENT, error)) {
        return false;
    }
    w->sky = gl_program(WALK_SCREEN_VERTEX, WALK_SKY_FRAGMENT, error);
    w->occlusion = w->sky ? gl_program(WALK_SCREEN_VERTEX, WALK_OCCLUSION_FRAGMENT, error) : 0;
    w->blur = w->occlusion ? gl_program(WALK_SCREEN_VERTEX, WALK_BLUR_FRAGMENT, error) : 0;
    if (!w->blur) return false;
    w->sky_forward = glGetUniformLocation(w->sky, "forward");
    w->sky_right = glGetUniformLocation(w->sky, "right");
    w->sky_up = glGetUniformLocation(w->sky, "up");
    w->occlusion_tangents = glGetUniformLocation(w->occlusion, "tangents");
    glUseProgram(w->scene.program);
    glUniform1i(glGetUniformLocation(w->scene.program, "lamps"), 0);
    glUniform1i(glGetUniformLocation(w->scene.program, "occlusion"), 1);
    glUseProgram(w->occlusion);
    glUniform1i(glGetUniformLocation(w->occlusion, "depth"), 1);
    glUniform1f(glGetUniformLocation(w->occlusion, "near"), (float)WALK_NEAR);
    glUseProgram(w->blur);
    glUniform1i(glGetUniformLocation(w->blur, "source"), 1);
    return true;
}

WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error) {
    WalkRenderer *w = ARENA_ARRAY(arena, WalkRenderer, 1);
    w->graph = graph;
    Vec3 middle = vec3_lerp(graph->box.min, graph->box.max, 0.5);
    w->origin = vec3(round(middle.x), round(middle.y), round(middle.z));
    size_t objects = (size_t)graph->object_count + 1;
    for (int pass = 0; pass < PASSES; pass++) w->first_index[pass] = ARENA_ARRAY(arena, int, objects);
    w->run_count = ARENA_ARRAY(arena, GLsizei, objects);
    w->run_offset = ARENA_ARRAY(arena, const void *, objects);
    w->glass = ARENA_ARRAY(arena, int, objects);
    w->glass_far = ARENA_ARRAY(arena, double, objects);
    if (make_programs(w, error)) {
        upload(w);
        if (gl_check("uploading a building", error)) return w;
    }
    walk_renderer_free(w);
    return NULL;
}

// ---- frames to draw to

static void free_targets(WalkRenderer *w) {
    unsigned frames[] = {w->depth_frame, w->open_frame, w->blur_frame, w->frame, w->flat_frame};
    unsigned textures[] = {w->depth_texture, w->open_texture, w->blur_texture};
    unsigned targets[] = {w->colour_target, w->depth_target, w->flat_target};
    glDeleteFramebuffers(5, frames);
    glDeleteTextures(3, textures);
    glDeleteRenderbuffers(3, targets);
    w->depth_frame = w->open_frame = w->blur_frame = w->frame = w->flat_frame = 0;
    w->depth_texture = w->open_texture = w->blur_texture = 0;
    w->colour_target = w->depth_target = w->flat_target = 0;
    w->width = w->height = 0;
}

void walk_renderer_free(WalkRenderer *w) {
    if (!w) return;
    free_targets(w);
    unsigned buffers[] = {w->vertex_buffer, w->index_buffer, w->lamp_buffer};
    unsigned programs[] = {w->scene.program, w->depth_only.program, w->sky, w->occlusion, w->blur};
    glDeleteBuffers(3, buffers);
    glDeleteTextures(1, &w->lamp_texture);
    glDeleteVertexArrays(1, &w->array);
    for (int i = 0; i < 5; i++) glDeleteProgram(programs[i]);
}

static void texture_frame(unsigned *frame, unsigned *texture, unsigned attachment, int internal,
                          unsigned format, int width, int height) {
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_2D, *texture);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, GL_FLOAT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glGenFramebuffers(1, frame);
    glBindFramebuffer(GL_FRAMEBUFFER, *frame);
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, *texture, 0);
    if (attachment == GL_DEPTH_ATTACHMENT) {
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
    }
}

static void buffer(unsigned *target, unsigned attachment, unsigned format, int samples, int width,
                   int height) {
    glGenRenderbuffers(1, target);
    glBindRenderbuffer(GL_RENDERBUFFER, *target);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, *target);
}

static int coarse(int pixels) { return (pixels + WALK_COARSE - 1) / WALK_COARSE; }

static bool make_targets(WalkRenderer *w, int width, int height, Error *error) {
    free_targets(w);
    int most = 0, samples = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    glGetIntegerv(GL_MAX_SAMPLES, &samples);
    if (width < 1 || height < 1 || width > most || height > most) {
        return error_set(error, "OpenGL: an image of %d x %d pixels (1 to %d each)", width, height, most);
    }
    if (samples > WALK_SAMPLES) samples = WALK_SAMPLES;
    texture_frame(&w->depth_frame, &w->depth_texture, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F,
                  GL_DEPTH_COMPONENT, width, height);
    int cw = coarse(width), ch = coarse(height);
    texture_frame(&w->open_frame, &w->open_texture, GL_COLOR_ATTACHMENT0, GL_RG32F, GL_RG, cw, ch);
    texture_frame(&w->blur_frame, &w->blur_texture, GL_COLOR_ATTACHMENT0, GL_R32F, GL_RED, cw, ch);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glGenFramebuffers(1, &w->flat_frame);
    glBindFramebuffer(GL_FRAMEBUFFER, w->flat_frame);
    buffer(&w->flat_target, GL_COLOR_ATTACHMENT0, GL_RGBA8, 0, width, height);
    glGenFramebuffers(1, &w->frame);
    glBindFramebuffer(GL_FRAMEBUFFER, w->frame);
    buffer(&w->colour_target, GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, width, height);
    buffer(&w->depth_target, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, samples, width, height);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        return error_set(error, "OpenGL: no frame of %d x %d pixels", width, height);
    }
    w->width = width;
    w->height = height;
    return gl_check("making a frame", error);
}

// ---- drawing

static void add_run(WalkRenderer *w, int pass, int object) {
    int first = w->first_index[pass][object], count = w->first_index[pass][object + 1] - first;
    if (count == 0) return;
    int last = w->run_total - 1;
    const void *offset = (const void *)((size_t)first * sizeof(unsigned));
    // Things and surfaces are drawn apart.
    if (last >= w->run_own &&
        (const char *)w->run_offset[last] + (size_t)w->run_count[last] * sizeof(unsigned) ==
            (const char *)offset) {
        w->run_count[last] += count;
        return;
    }
    w->run_count[w->run_total] = count;
    w->run_offset[w->run_total++] = offset;
}

// The surfaces of cells are seen from inside their cells only: where two lie back to back, each hides nothing.
static void draw_runs(const WalkRenderer *w, const SceneProgram *program) {
    glUniform1i(program->one_sided, 0);
    glMultiDrawElements(GL_TRIANGLES, w->run_count, GL_UNSIGNED_INT, w->run_offset, w->run_own);
    glUniform1i(program->one_sided, 1);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(WALK_OFFSET_SLOPE, WALK_OFFSET_UNITS);
    glMultiDrawElements(GL_TRIANGLES, w->run_count + w->run_own, GL_UNSIGNED_INT, w->run_offset + w->run_own,
                        w->run_total - w->run_own);
    glDisable(GL_POLYGON_OFFSET_FILL);
}

static void add_solids(WalkRenderer *w, const int *objects, int count) {
    w->run_total = w->run_own = 0;
    for (int surfaces = 0; surfaces < 2; surfaces++) {
        w->run_own = w->run_total;
        for (int i = 0; i < count; i++) {
            bool surface = w->graph->objects[objects[i]].kind == OBJECT_SURFACE;
            if (surface == (surfaces == 1)) add_run(w, SOLID, objects[i]);
        }
    }
}

static void use_scene(const WalkRenderer *w, const SceneProgram *program, const Camera *camera) {
    glUseProgram(program->program);
    mat4 clip = GLM_MAT4_ZERO_INIT;
    // Row 0 of the image is its top: drawn upside down, read as it is.
    gl_clip_matrix(camera, WALK_NEAR, true, clip);
    glUniformMatrix4fv(program->clip, 1, GL_FALSE, &clip[0][0]);
    Vec3 eye = vec3_sub(camera->eye, w->origin);
    glUniform3f(program->eye, (float)eye.x, (float)eye.y, (float)eye.z);
    glUniform2f(program->size, (float)w->width, (float)w->height);
}

static void set_vector(int place, Vec3 v) { glUniform3f(place, (float)v.x, (float)v.y, (float)v.z); }

static void use_texture(unsigned texture) {
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, texture);
    glActiveTexture(GL_TEXTURE0);
}

// Depth of the solid surfaces, then the open share of each pixel.
static void draw_occlusion(WalkRenderer *w, const Camera *camera) {
    glBindFramebuffer(GL_FRAMEBUFFER, w->depth_frame);
    glClear(GL_DEPTH_BUFFER_BIT);
    use_scene(w, &w->depth_only, camera);
    draw_runs(w, &w->depth_only);
    glDisable(GL_DEPTH_TEST);
    glViewport(0, 0, coarse(w->width), coarse(w->height));
    glBindFramebuffer(GL_FRAMEBUFFER, w->open_frame);
    glUseProgram(w->occlusion);
    use_texture(w->depth_texture);
    glUniform2f(w->occlusion_tangents, (float)camera->tan_x, (float)camera->tan_y);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindFramebuffer(GL_FRAMEBUFFER, w->blur_frame);
    glUseProgram(w->blur);
    use_texture(w->open_texture);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
    glViewport(0, 0, w->width, w->height);
}

static void draw_sky(const WalkRenderer *w, const Camera *camera) {
    glUseProgram(w->sky);
    set_vector(w->sky_forward, camera->forward);
    set_vector(w->sky_right, vec3_scale(camera->right, camera->tan_x));
    set_vector(w->sky_up, vec3_scale(camera->up, -camera->tan_y));
    glDepthFunc(GL_LEQUAL);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDepthFunc(GL_LESS);
}

// Glass over what is behind it, the farthest first by the middles of the objects.
static void draw_glass(WalkRenderer *w, const Camera *camera, const int *objects, int count) {
    int held = 0;
    for (int i = 0; i < count; i++) {
        int o = objects[i];
        if (w->first_index[GLASS][o] == w->first_index[GLASS][o + 1]) continue;
        Box box = w->graph->object_boxes[o];
        double distance = vec3_length(vec3_sub(vec3_lerp(box.min, box.max, 0.5), camera->eye));
        int at = held++;
        for (; at > 0 && w->glass_far[at - 1] < distance; at--) {
            w->glass_far[at] = w->glass_far[at - 1];
            w->glass[at] = w->glass[at - 1];
        }
        w->glass_far[at] = distance;
        w->glass[at] = o;
    }
    w->run_total = w->run_own = 0;
    for (int i = 0; i < held; i++) add_run(w, GLASS, w->glass[i]);
    w->run_own = w->run_total;
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    use_scene(w, &w->scene, camera);
    draw_runs(w, &w->scene);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

bool walk_renderer_draw(WalkRenderer *w, const Camera *camera, const int *objects, int object_count,
                        Error *error) {
    if ((w->width != camera->width || w->height != camera->height) &&
        !make_targets(w, camera->width, camera->height, error)) {
        return false;
    }
    glViewport(0, 0, w->width, w->height);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glEnable(GL_MULTISAMPLE);
    glClearDepth(1);
    glBindTexture(GL_TEXTURE_BUFFER, w->lamp_texture);
    glBindVertexArray(w->array);
    add_solids(w, objects, object_count);
    draw_occlusion(w, camera);
    glBindFramebuffer(GL_FRAMEBUFFER, w->frame);
    glClear(GL_DEPTH_BUFFER_BIT | GL_COLOR_BUFFER_BIT);
    use_scene(w, &w->scene, camera);
    use_texture(w->blur_texture);
    draw_runs(w, &w->scene);
    draw_sky(w, camera);
    draw_glass(w, camera, objects, object_count);
    return gl_check("drawing", error);
}

void walk_renderer_finish(void) { glFinish(); }

bool walk_renderer_read(WalkRenderer *w, uint8_t *rgb, Error *error) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, w->frame);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, w->flat_frame);
    glBlitFramebuffer(0, 0, w->width, w->height, 0, 0, w->width, w->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, w->flat_frame);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, w->width, w->height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
    return gl_check("reading an image back", error);
}
