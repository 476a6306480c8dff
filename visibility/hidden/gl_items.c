// gl_items.c - an item buffer by OpenGL: which polygon covers a pixel is left to the rasteriser, how far away it is
// is computed in the fragment from the polygon's plane, 1/z = dot(n, ray) / height of the plane over the eye. That is
// linear in the pixel and exact to float, where the rasteriser's own depth, interpolated from a vertex next to the
// eye, is off by centimetres at the far end of a room.
//
// Positions are subtracted from the eye in double, so a building far from the origin is drawn alike.
#include "visibility/hidden/gl_items.h"

#include <glad/gl.h>

#include "engine/core/polygon.h"
#include "engine/gl/gl_context.h"
#include "engine/gl/gl_math.h"
#include "visibility/hidden/facets.h"

// A surface whose plane is this near the eye is seen edge-on, metres: it covers no pixel but by rounding.
static const double EDGE_ON = 1e-5;
// So is any polygon that spans less than this angle between the eye and its plane, radians: a hundredth of a pixel.
static const double EDGE_ON_ANGLE = 1e-5;

// A polygon's plane as the fragment shader reads it.
typedef struct PlaneTexels {
    // n / height over the eye, so that 1/z = dot(n / height, ray). Of a polygon seen edge-on: 1 / its reach up and down.
    float plane[4];
    // The least (0: not to be drawn) and the greatest 1/z of its vertices; 1 / its reach in plan if edge-on, else 0.
    float reach[4];
} PlaneTexels;

struct GlItems {
    const Polygon *polygons;
    const Vec3 *vertices;
    Vec3 *normal, *centre;           // [count], of the planes
    int *polygon;                    // [count]
    const unsigned char *one_sided;  // [count] or NULL
    int *first_vertex;               // [count + 1] in the vertex buffer
    int *first_index;                // [count + 1] in the index buffer
    float (*position)[3];            // [vertex count] relative to the eye
    PlaneTexels *planes;             // [count]
    GLsizei *run_count;              // [count] of the next draw, in indices
    const void **run_offset;
    int count, run_total, run_end;
    unsigned program, array, position_buffer, fixed_buffer, index_buffer, plane_buffer, plane_texture;
    unsigned frame, item_target, depth_target, colour_target;
    int clip, corner, along_x, along_y, before, has_before;  // uniforms
    int width, height;
    bool coloured;
};

typedef struct FixedVertex {
    int32_t place, polygon;
    uint32_t colour;
} FixedVertex;

static const char VERTEX_SHADER[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"  // world axes, relative to the eye
    "layout(location = 1) in ivec2 ids;\n"
    "layout(location = 2) in vec4 colour;\n"
    "uniform mat4 clip;\n"
    "flat out ivec2 vIds;\n"
    "flat out vec4 vColour;\n"
    "void main() { gl_Position = clip * vec4(position, 1.0); vIds = ids; vColour = colour; }\n";

static const char FRAGMENT_SHADER[] =
    "#version 330 core\n"
    "flat in ivec2 vIds;\n"
    "flat in vec4 vColour;\n"
    "uniform samplerBuffer planes;\n"
    "uniform vec3 corner, along_x, along_y;\n"
    "uniform float near;\n"
    "uniform vec3 before;\n"
    "uniform bool has_before;\n"
    "layout(location = 0) out int item;\n"
    "layout(location = 1) out vec4 colour;\n"
    "void main() {\n"
    "    vec4 plane = texelFetch(planes, 2 * vIds.x), reach = texelFetch(planes, 2 * vIds.x + 1);\n"
    "    if (reach.x <= 0.0) discard;\n"
    "    vec3 ray = corner + gl_FragCoord.x * along_x + gl_FragCoord.y * along_y;\n"
    // Vertices are rounded to a 256th of a pixel: a fragment just off the polygon stays within its reach.
    "    float inverse = dot(plane.xyz, ray);\n"
    "    if (reach.z > 0.0) inverse = max(reach.z * length(ray.xy), max(ray.z * plane.x, ray.z * plane.y));\n"
    "    if (has_before && inverse >= dot(before, ray)) discard;\n"
    "    gl_FragDepth = min(near * clamp(inverse, reach.x, reach.y), 1.0);\n"
    "    item = vIds.y;\n"
    "    colour = vColour;\n"
    "}\n";

static void fill_fixed(GlItems *items, const uint32_t *colours, FixedVertex *vertex, unsigned *index) {
    for (int k = 0; k < items->count; k++) {
        const Polygon *polygon = &items->polygons[items->polygon[k]];
        const Vec3 *v = items->vertices + polygon->first_vertex;
        for (int i = 0; i < polygon->vertex_count; i++) {
            vertex[items->first_vertex[k] + i] =
                (FixedVertex){k, items->polygon[k], colours ? colours[k] : 0};
        }
        int *triangle = (int *)(index + items->first_index[k]);
        polygon_triangulate(v, polygon->vertex_count, triangle);
        int corners = items->first_index[k + 1] - items->first_index[k];
        for (int i = 0; i < corners; i++) triangle[i] += items->first_vertex[k];
    }
}

void gl_items_moved(GlItems *items, int first, int count) {
    for (int k = first; k < first + count; k++) {
        const Polygon *polygon = &items->polygons[items->polygon[k]];
        const Vec3 *v = items->vertices + polygon->first_vertex;
        int n = polygon->vertex_count;
        items->normal[k] = plane_of_polygon(v, n).n;
        Vec3 offset = {0, 0, 0};
        for (int i = 0; i < n; i++) offset = vec3_add(offset, vec3_sub(v[i], v[0]));
        items->centre[k] = vec3_add(v[0], vec3_scale(offset, 1.0 / n));
    }
}

static void measure_gl_scene(GlItems *items, const Scene *scene) {
    for (int k = 0; k < items->count; k++) {
        items->polygon[k] = scene->list ? scene->list[k] : k;
        int n = scene->polygons[items->polygon[k]].vertex_count;
        items->first_vertex[k + 1] = items->first_vertex[k] + n;
        items->first_index[k + 1] = items->first_index[k] + 3 * (n - 2);
    }
    gl_items_moved(items, 0, items->count);
}

static void make_buffers(GlItems *items, const FixedVertex *vertex, const unsigned *index) {
    size_t vertices = (size_t)items->first_vertex[items->count];
    glGenVertexArrays(1, &items->array);
    glBindVertexArray(items->array);
    glGenBuffers(1, &items->position_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, items->position_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices * sizeof *items->position), NULL, GL_STREAM_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glGenBuffers(1, &items->fixed_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, items->fixed_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices * sizeof *vertex), vertex, GL_STATIC_DRAW);
    glEnableVertexAttribArray(1);
    glVertexAttribIPointer(1, 2, GL_INT, sizeof *vertex, NULL);
    glEnableVertexAttribArray(2);
    glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof *vertex,
                          (const void *)offsetof(FixedVertex, colour));
    glGenBuffers(1, &items->index_buffer);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, items->index_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 (GLsizeiptr)((size_t)items->first_index[items->count] * sizeof *index), index,
                 GL_STATIC_DRAW);
    glGenBuffers(1, &items->plane_buffer);
    glBindBuffer(GL_TEXTURE_BUFFER, items->plane_buffer);
    glBufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)((size_t)items->count * sizeof *items->planes), NULL,
                 GL_STREAM_DRAW);
    glGenTextures(1, &items->plane_texture);
    glBindTexture(GL_TEXTURE_BUFFER, items->plane_texture);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, items->plane_buffer);
}

static bool make_program(GlItems *items, Error *error) {
    items->program = gl_program(VERTEX_SHADER, FRAGMENT_SHADER, error);
    if (!items->program) return false;
    items->clip = glGetUniformLocation(items->program, "clip");
    items->corner = glGetUniformLocation(items->program, "corner");
    items->along_x = glGetUniformLocation(items->program, "along_x");
    items->along_y = glGetUniformLocation(items->program, "along_y");
    items->before = glGetUniformLocation(items->program, "before");
    items->has_before = glGetUniformLocation(items->program, "has_before");
    glUseProgram(items->program);
    glUniform1i(glGetUniformLocation(items->program, "planes"), 0);
    glUniform1f(glGetUniformLocation(items->program, "near"), (float)GL_ITEMS_NEAR);
    return true;
}

GlItems *gl_items_new(const Scene *scene, const uint32_t *colours, const unsigned char *one_sided,
                      Arena *arena, Error *error) {
    int most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    if (scene->count > most / 2) {
        error_set(error, "OpenGL: %d polygons to draw (this machine allows %d)", scene->count, most / 2);
        return NULL;
    }
    GlItems *items = ARENA_ARRAY(arena, GlItems, 1);
    size_t count = (size_t)scene->count + 1;  // never empty
    *items = (GlItems){.polygons = scene->polygons, .vertices = scene->vertices, .count = scene->count};
    items->coloured = colours != NULL;
    items->one_sided = one_sided;
    items->normal = ARENA_ARRAY(arena, Vec3, count);
    items->centre = ARENA_ARRAY(arena, Vec3, count);
    items->polygon = ARENA_ARRAY(arena, int, count);
    items->first_vertex = ARENA_ARRAY(arena, int, count);
    items->first_index = ARENA_ARRAY(arena, int, count);
    items->planes = ARENA_ARRAY(arena, PlaneTexels, count);
    items->run_count = ARENA_ARRAY(arena, GLsizei, count);
    items->run_offset = ARENA_ARRAY(arena, const void *, count);
    measure_gl_scene(items, scene);
    items->position =
        arena_alloc(arena, (size_t)items->first_vertex[items->count] + 1, sizeof *items->position);
    if (!make_program(items, error)) return NULL;
    Arena scratch = {0};
    FixedVertex *vertex = ARENA_ARRAY(&scratch, FixedVertex, items->first_vertex[items->count] + 1);
    unsigned *index = ARENA_ARRAY(&scratch, unsigned, items->first_index[items->count] + 1);
    fill_fixed(items, colours, vertex, index);
    make_buffers(items, vertex, index);
    arena_free(&scratch);
    if (gl_check("uploading polygons", error)) return items;
    gl_items_free(items);
    return NULL;
}

static void free_targets(GlItems *items) {
    unsigned targets[] = {items->item_target, items->depth_target, items->colour_target};
    glDeleteRenderbuffers(3, targets);
    glDeleteFramebuffers(1, &items->frame);
    items->frame = items->item_target = items->depth_target = items->colour_target = 0;
    items->width = items->height = 0;
}

void gl_items_free(GlItems *items) {
    if (!items) return;
    free_targets(items);
    unsigned buffers[] = {items->position_buffer, items->fixed_buffer, items->index_buffer,
                          items->plane_buffer};
    glDeleteBuffers(4, buffers);
    glDeleteTextures(1, &items->plane_texture);
    glDeleteVertexArrays(1, &items->array);
    glDeleteProgram(items->program);
}

static unsigned target(unsigned attachment, unsigned format, int width, int height) {
    unsigned name;
    glGenRenderbuffers(1, &name);
    glBindRenderbuffer(GL_RENDERBUFFER, name);
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, name);
    return name;
}

static bool make_targets(GlItems *items, int width, int height, Error *error) {
    free_targets(items);
    int most = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    if (width < 1 || height < 1 || width > most || height > most) {
        return error_set(error, "OpenGL: an image of %d x %d pixels (1 to %d each)", width, height, most);
    }
    glGenFramebuffers(1, &items->frame);
    glBindFramebuffer(GL_FRAMEBUFFER, items->frame);
    items->item_target = target(GL_COLOR_ATTACHMENT0, GL_R32I, width, height);
    items->depth_target = target(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, width, height);
    if (items->coloured) items->colour_target = target(GL_COLOR_ATTACHMENT1, GL_RGBA8, width, height);
    static const unsigned outputs[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(items->coloured ? 2 : 1, outputs);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        return error_set(error, "OpenGL: no item buffer of %d x %d pixels", width, height);
    }
    items->width = width;
    items->height = height;
    return gl_check("making an item buffer", error);
}

// How far outside the polygon the eye stands, in its plane: 0 over it, never too much.
static double distance_outside(const Vec3 *v, int count, Vec3 n, Vec3 eye) {
    double out = 0;
    for (int i = 0; i < count; i++) {
        Vec3 outward = vec3_normalize(vec3_cross(vec3_sub(v[i + 1 == count ? 0 : i + 1], v[i]), n));
        out = fmax(out, vec3_dot(outward, vec3_sub(eye, v[i])));
    }
    return out;
}

static bool is_edge_on(const GlItems *items, int k, double height, Vec3 eye) {
    if (fabs(height) >= EDGE_ON) return false;
    if ((items->one_sided && items->one_sided[k]) || fabs(height) < HIDDEN_EDGE_ON) return true;
    // An eye that all but touches it sees nothing else.
    const Polygon *polygon = &items->polygons[items->polygon[k]];
    const Vec3 *v = items->vertices + polygon->first_vertex;
    return fabs(height) < EDGE_ON_ANGLE * distance_outside(v, polygon->vertex_count, items->normal[k], eye);
}

// The planes and the vertices as this eye sees them.
static void place_gl_view(GlItems *items, const Camera *camera, const Plane *before) {
    for (int k = 0; k < items->count; k++) {
        const Polygon *polygon = &items->polygons[items->polygon[k]];
        const Vec3 *v = items->vertices + polygon->first_vertex;
        float(*position)[3] = items->position + items->first_vertex[k];
        double farthest = 0, nearest = INFINITY, far_in_plan = 0, top = -INFINITY, bottom = INFINITY;
        double reach_before = before ? -INFINITY : INFINITY;
        for (int i = 0; i < polygon->vertex_count; i++) {
            Vec3 at = vec3_sub(v[i], camera->eye);
            position[i][0] = (float)at.x;
            position[i][1] = (float)at.y;
            position[i][2] = (float)at.z;
            farthest = fmax(farthest, vec3_dot(at, camera->forward));
            nearest = fmin(nearest, vec3_dot(at, camera->forward));
            top = fmax(top, at.z);
            bottom = fmin(bottom, at.z);
            far_in_plan = fmax(far_in_plan, at.x * at.x + at.y * at.y);
            if (before) reach_before = fmax(reach_before, plane_distance(*before, v[i]));
        }
        Vec3 n = items->normal[k];
        double height = vec3_dot(n, vec3_sub(items->centre[k], camera->eye));
        // The back of a surface lies in the wall. Seen edge-on it has no depth by its plane, yet it fills the seam
        // between its neighbours: there it is taken to lie where a ray along it leaves the box around it.
        bool surface = items->one_sided && items->one_sided[k];
        bool edge_on = is_edge_on(items, k, height, camera->eye);
        bool seen =
            farthest > 0 && reach_before > GL_ITEMS_REACH && (surface ? edge_on || height < 0 : !edge_on);
        float *plane = items->planes[k].plane, *reach = items->planes[k].reach;
        plane[0] = edge_on ? (top > EDGE_ON ? (float)(1 / top) : 0) : (float)(n.x / height);
        plane[1] = edge_on ? (bottom < -EDGE_ON ? (float)(1 / bottom) : 0) : (float)(n.y / height);
        plane[2] = edge_on ? 0 : (float)(n.z / height);
        reach[0] = seen ? (float)(1 / farthest) : 0;
        reach[1] = (float)(1 / fmax(nearest, GL_ITEMS_NEAR));
        reach[2] = edge_on ? (float)(1 / fmax(sqrt(far_in_plan), GL_ITEMS_NEAR)) : 0;
    }
}

static void upload(const GlItems *items) {
    size_t vertices = (size_t)items->first_vertex[items->count];
    glBindBuffer(GL_ARRAY_BUFFER, items->position_buffer);
    glBufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)(vertices * sizeof *items->position), items->position);
    glBindBuffer(GL_TEXTURE_BUFFER, items->plane_buffer);
    glBufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)((size_t)items->count * sizeof *items->planes),
                    items->planes);
}

static void set_uniforms(const GlItems *items, const Camera *camera, const Plane *before) {
    glUniform1i(items->has_before, before != NULL);
    if (before) {
        // 1/z of the plane along a ray, as for polygons.
        Vec3 n = vec3_scale(before->n, -1 / plane_distance(*before, camera->eye));
        glUniform3f(items->before, (float)n.x, (float)n.y, (float)n.z);
    }
    mat4 clip = GLM_MAT4_ZERO_INIT;
    gl_clip_matrix(camera, GL_ITEMS_NEAR, true, clip);
    glUniformMatrix4fv(items->clip, 1, GL_FALSE, &clip[0][0]);
    Vec3 corner = camera_ray(camera, 0, 0);
    Vec3 x = vec3_scale(camera->right, 2 * camera->tan_x / camera->width);
    Vec3 y = vec3_scale(camera->up, -2 * camera->tan_y / camera->height);
    glUniform3f(items->corner, (float)corner.x, (float)corner.y, (float)corner.z);
    glUniform3f(items->along_x, (float)x.x, (float)x.y, (float)x.z);
    glUniform3f(items->along_y, (float)y.x, (float)y.y, (float)y.z);
}

static void bind(const GlItems *items) {
    glBindFramebuffer(GL_FRAMEBUFFER, items->frame);
    glViewport(0, 0, items->width, items->height);
    glUseProgram(items->program);
    glBindVertexArray(items->array);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_BUFFER, items->plane_texture);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glDisable(GL_DITHER);
    glDisable(GL_MULTISAMPLE);
}

bool gl_items_look(GlItems *items, const Camera *camera, const Plane *before, Error *error) {
    if ((items->width != camera->width || items->height != camera->height) &&
        !make_targets(items, camera->width, camera->height, error)) {
        return false;
    }
    bind(items);
    place_gl_view(items, camera, before);
    upload(items);
    set_uniforms(items, camera, before);
    static const int nothing[4] = {-1, -1, -1, -1};
    static const float black[4] = {0, 0, 0, 1}, farthest = 0;
    glClearBufferiv(GL_COLOR, 0, nothing);
    if (items->coloured) glClearBufferfv(GL_COLOR, 1, black);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
    items->run_total = items->run_end = 0;
    return gl_check("preparing a frame", error);
}

void gl_items_add(GlItems *items, int first, int count) {
    CORE_ASSERT(first >= items->run_end && first + count <= items->count);
    if (count == 0) return;
    int indices = items->first_index[first + count] - items->first_index[first];
    if (items->run_total > 0 && first == items->run_end) {
        items->run_count[items->run_total - 1] += indices;
    } else {
        items->run_count[items->run_total] = indices;
        items->run_offset[items->run_total++] =
            (const void *)((size_t)items->first_index[first] * sizeof(unsigned));
    }
    items->run_end = first + count;
}

bool gl_items_draw(GlItems *items, Error *error) {
    bind(items);
    glMultiDrawElements(GL_TRIANGLES, items->run_count, GL_UNSIGNED_INT, items->run_offset, items->run_total);
    items->run_total = items->run_end = 0;
    return gl_check("drawing", error);
}

bool gl_items_read(GlItems *items, ItemBuffer *out, uint32_t *colour, Error *error) {
    CORE_ASSERT(out->width == items->width && out->height == items->height);
    bind(items);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, items->width, items->height, GL_RED_INTEGER, GL_INT, out->item);
    glReadPixels(0, 0, items->width, items->height, GL_DEPTH_COMPONENT, GL_FLOAT, out->depth);
    size_t pixels = (size_t)items->width * (size_t)items->height;
    for (size_t i = 0; i < pixels; i++) {
        out->depth[i] = out->item[i] < 0 ? INFINITY : (float)GL_ITEMS_NEAR / out->depth[i];
    }
    if (colour) {
        CORE_ASSERT(items->coloured);
        glReadBuffer(GL_COLOR_ATTACHMENT1);
        glReadPixels(0, 0, items->width, items->height, GL_RGBA, GL_UNSIGNED_BYTE, colour);
    }
    return gl_check("reading an image back", error);
}
