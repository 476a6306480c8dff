// renderer.c - one vertex buffer for the whole building, one multi-draw of the objects asked for.
//
// Positions are floats relative to the middle of the building, so that it may lie far from the origin. Each object
// has two runs of indices, opaque and glass. The lamps of each region lie in a texture buffer: a fragment adds up
// those of its own region, so that no light comes through a wall.
#include "engine/walk/renderer.h"

#include <glad/gl.h>

#include "engine/core/polygon.h"
#include "visibility/hidden/gl_context.h"
#include "visibility/hidden/gl_math.h"

enum { SAMPLES = 4, MOST_LAMPS = 24 };
// Nearer than this nothing is drawn, metres; a 24 bit depth buffer then tells 2 mm apart at 20 m.
static const double NEAR = 0.02, FAR = 1000;

typedef struct Vertex {
    float position[3], normal[3];
    float colour[4];    // linear reflectance, alpha
    float emission[3];  // display units
    int32_t region;
} Vertex;

typedef struct Run {
    GLsizei count;
    size_t first;
} Run;

struct WalkRenderer {
    const CellGraph *graph;
    Vec3 origin;
    Run *opaque, *glass;  // [object_count]
    GLsizei *run_count;
    const void **run_offset;
    int *glass_order;       // [object_count] scratch: objects with glass
    double *glass_distance;  // [object_count]
    unsigned program, sky_program, array, sky_array, vertex_buffer, index_buffer;
    unsigned lamp_buffer, lamp_texture, region_buffer, region_texture;
    unsigned frame, colour, depth, resolved_frame, resolved_colour;
    int width, height;
    uint8_t *pixels;  // [height * width * 4], grows with the image
    Arena images;
};

static const char VERTEX_SHADER[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec4 colour;\n"
    "layout(location = 3) in vec3 emission;\n"
    "layout(location = 4) in int region;\n"
    "uniform mat4 clip;\n"
    "out vec3 vPosition;\n"
    "flat out vec3 vNormal, vEmission;\n"
    "flat out vec4 vColour;\n"
    "flat out int vRegion;\n"
    "void main() {\n"
    "    gl_Position = clip * vec4(position, 1.0);\n"
    "    vPosition = position; vNormal = normal; vColour = colour; vEmission = emission; vRegion = region;\n"
    "}\n";

// Indoors: a soft ambient that tells walls apart by their direction, and the room's lamps. Outdoors: sky and sun.
static const char FRAGMENT_SHADER[] =
    "#version 330 core\n"
    "in vec3 vPosition;\n"
    "flat in vec3 vNormal, vEmission;\n"
    "flat in vec4 vColour;\n"
    "flat in int vRegion;\n"
    "uniform samplerBuffer lamps, regions;\n"
    "uniform vec3 eye;\n"
    "out vec4 colour;\n"
    "vec3 lamp_light(vec4 region, vec3 n) {\n"
    "    vec3 sum = vec3(0.0);\n"
    "    int first = int(region.x), end = first + int(region.y);\n"
    "    for (int i = first; i < end; i++) {\n"
    "        vec3 to = texelFetch(lamps, 2 * i).xyz - vPosition;\n"
    "        float d2 = max(dot(to, to), 0.2);\n"
    // Half of it wraps around: light that other walls would send back.
    "        float facing = 0.55 * max(dot(n, to) * inversesqrt(d2), 0.0) + 0.25;\n"
    "        sum += texelFetch(lamps, 2 * i + 1).rgb * facing / d2;\n"
    "    }\n"
    "    return sum * region.w;\n"
    "}\n"
    "void main() {\n"
    "    vec3 n = dot(vNormal, eye - vPosition) < 0.0 ? -vNormal : vNormal;\n"
    "    vec4 region = texelFetch(regions, vRegion);\n"
    "    vec3 light;\n"
    "    if (region.z > 0.5) {\n"
    "        light = mix(vec3(0.34, 0.33, 0.30), vec3(0.62, 0.70, 0.80), 0.5 + 0.5 * n.z);\n"
    "        light += vec3(0.72, 0.66, 0.55) * max(dot(n, normalize(vec3(0.45, -0.6, 0.7))), 0.0);\n"
    "    } else {\n"
    "        light = mix(vec3(0.30, 0.28, 0.26), vec3(0.40, 0.41, 0.43), 0.5 + 0.5 * n.z);\n"
    "        light += 0.16 * abs(n.x) * vec3(1.0, 0.97, 0.92) + 0.07 * abs(n.y);\n"
    "        light += lamp_light(region, n);\n"
    "    }\n"
    "    vec3 c = vColour.rgb * light + vEmission;\n"
    "    c = c * (1.0 + c / 9.0) / (1.0 + 0.45 * c);\n"
    "    c = mix(12.92 * c, 1.055 * pow(max(c, vec3(1e-5)), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));\n"
    "    colour = vec4(c, vColour.a);\n"
    "}\n";

static const char SKY_VERTEX[] = "#version 330 core\n"
                                 "out vec2 at;\n"
                                 "void main() {\n"
                                 "    at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);\n"
                                 "    gl_Position = vec4(at, 1.0, 1.0);\n"
                                 "}\n";
static const char SKY_FRAGMENT[] =
    "#version 330 core\n"
    "in vec2 at;\n"
    "uniform vec3 forward, right, up;\n"
    "out vec4 colour;\n"
    "void main() {\n"
    "    float h = clamp(normalize(forward + at.x * right + at.y * up).z, -0.2, 1.0);\n"
    "    vec3 sky = mix(vec3(0.83, 0.89, 0.94), vec3(0.40, 0.60, 0.85), pow(max(h, 0.0), 0.55));\n"
    "    colour = vec4(h < 0.0 ? mix(vec3(0.83, 0.89, 0.94), vec3(0.62, 0.66, 0.62), -5.0 * h) : sky, 1.0);\n"
    "}\n";

// ---- upload

// The region whose light falls on an object: that of a cell it is registered in, rooms before others.
static int *object_regions(const CellGraph *graph, Arena *scratch) {
    static const int rank[REGION_KINDS] = {3, 2, 1, 1};
    int *region = ARENA_ARRAY(scratch, int, graph->object_count + 1);
    for (int o = 0; o < graph->object_count; o++) region[o] = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        const CellMesh *mesh = &graph->meshes[c];
        int here = graph->cells[c].region;
        for (int k = graph->square_first[mesh->first_square];
             k < graph->square_first[mesh->first_square + mesh->nx * mesh->ny]; k++) {
            int *best = &region[graph->square_objects[k]];
            const Region *regions = graph->building->regions;
            if (*best < 0 || rank[regions[here].kind] > rank[regions[*best].kind]) *best = here;
        }
    }
    return region;
}

// A jamb is lit like the room on its side.
static int lit_region(const Building *b, int region) {
    if (region < 0 || b->regions[region].opening < 0) return region;
    const Opening *opening = &b->openings[b->regions[region].opening];
    int side = b->regions[region].side, beyond = opening->region[side];
    if (beyond < 0) beyond = opening->region[1 - side];
    return beyond >= 0 ? beyond : region;
}

static Vertex make_vertex(const WalkRenderer *r, Vec3 at, Vec3 normal, const Material *m, int region) {
    Vec3 p = vec3_sub(at, r->origin);
    Vertex v = {{(float)p.x, (float)p.y, (float)p.z},
                {(float)normal.x, (float)normal.y, (float)normal.z},
                {m->reflectance.r, m->reflectance.g, m->reflectance.b, m->alpha},
                {0, 0, 0},
                region};
    float most = fmaxf(m->emission.r, fmaxf(m->emission.g, m->emission.b));
    // A lamp is as bright as a screen goes, whatever its power.
    if (most > 0) {
        v.emission[0] = 3 * m->emission.r / most;
        v.emission[1] = 3 * m->emission.g / most;
        v.emission[2] = 3 * m->emission.b / most;
    }
    return v;
}

typedef struct Upload {
    Vertex *vertices;
    unsigned *indices;
    size_t vertex_count, index_count;
} Upload;

static void add_polygon(WalkRenderer *r, Upload *u, int polygon, int region) {
    const Polygon *p = &r->graph->polygons[polygon];
    const Vec3 *v = r->graph->vertices + p->first_vertex;
    const Material *m = &r->graph->building->materials[p->material];
    Vec3 normal = plane_of_polygon(v, p->vertex_count).n;
    int *triangles = (int *)(u->indices + u->index_count), corners = 3 * (p->vertex_count - 2);
    polygon_triangulate(v, p->vertex_count, triangles);
    for (int i = 0; i < corners; i++) triangles[i] += (int)u->vertex_count;
    u->index_count += (size_t)corners;
    for (int i = 0; i < p->vertex_count; i++) {
        u->vertices[u->vertex_count++] = make_vertex(r, v[i], normal, m, region);
    }
}

static void fill(WalkRenderer *r, Upload *u, Arena *scratch) {
    const CellGraph *graph = r->graph;
    const int *region = object_regions(graph, scratch);
    size_t indices = 0;
    for (int p = 0; p < graph->polygon_count; p++) indices += 3 * (size_t)(graph->polygons[p].vertex_count - 2);
    u->vertices = ARENA_ARRAY(scratch, Vertex, graph->vertex_count + 1);
    u->indices = ARENA_ARRAY(scratch, unsigned, indices + 1);
    for (int glass = 0; glass < 2; glass++) {
        for (int o = 0; o < graph->object_count; o++) {
            const Object *object = &graph->objects[o];
            int lit = lit_region(graph->building, region[o]);
            size_t first = u->index_count;
            for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
                bool is_glass = graph->building->materials[graph->polygons[p].material].alpha < 1;
                if (is_glass == (glass == 1)) add_polygon(r, u, p, lit < 0 ? graph->building->region_count : lit);
            }
            Run run = {(GLsizei)(u->index_count - first), first};
            *(glass ? &r->glass[o] : &r->opaque[o]) = run;
        }
    }
}

static void attribute(int at, int size, size_t offset) {
    glEnableVertexAttribArray((unsigned)at);
    glVertexAttribPointer((unsigned)at, size, GL_FLOAT, GL_FALSE, sizeof(Vertex), (const void *)offset);
}

static void make_buffers(WalkRenderer *r, const Upload *u) {
    glGenVertexArrays(1, &r->sky_array);
    glGenVertexArrays(1, &r->array);
    glBindVertexArray(r->array);
    glGenBuffers(1, &r->vertex_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, r->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(u->vertex_count * sizeof *u->vertices), u->vertices, GL_STATIC_DRAW);
    attribute(0, 3, offsetof(Vertex, position));
    attribute(1, 3, offsetof(Vertex, normal));
    attribute(2, 4, offsetof(Vertex, colour));
    attribute(3, 3, offsetof(Vertex, emission));
    glEnableVertexAttribArray(4);
    glVertexAttribIPointer(4, 1, GL_INT, sizeof(Vertex), (const void *)offsetof(Vertex, region));
    glGenBuffers(1, &r->index_buffer);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, r->index_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(u->index_count * sizeof *u->indices), u->indices,
                 GL_STATIC_DRAW);
}

static void make_texture(unsigned *buffer, unsigned *texture, const float (*texel)[4], size_t count) {
    glGenBuffers(1, buffer);
    glBindBuffer(GL_TEXTURE_BUFFER, *buffer);
    glBufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)(count * sizeof *texel), texel, GL_STATIC_DRAW);
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_BUFFER, *texture);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, *buffer);
}

typedef struct Lamp {
    Vec3 position;
    Rgb flux;
    int region;
} Lamp;

// The building's lights, and its shining inlays as one light each.
static Lamp *collect_lamps(const CellGraph *graph, Arena *scratch, int *count) {
    const Building *b = graph->building;
    Lamp *lamps = ARENA_ARRAY(scratch, Lamp, b->light_count + b->inlay_count + 1);
    *count = 0;
    for (int i = 0; i < b->light_count + b->inlay_count; i++) {
        Lamp lamp;
        if (i < b->light_count) {
            lamp = (Lamp){b->lights[i].position, b->lights[i].flux, -1};
        } else {
            const Inlay *inlay = &b->inlays[i - b->light_count];
            Vec2 sum = {0, 0};
            for (int k = 0; k < inlay->point_count; k++) sum = vec2_add(sum, b->points[inlay->first_point + k]);
            lamp.position = vec3(sum.x / inlay->point_count, sum.y / inlay->point_count, inlay->z - 0.05);
            lamp.flux = b->materials[inlay->material].emission;
            if (lamp.flux.r + lamp.flux.g + lamp.flux.b <= 0) continue;
        }
        int cell = vis_locate(graph, lamp.position, -1);
        if (cell < 0) continue;  // a lamp inside a wall lights nothing
        lamp.region = graph->cells[cell].region;
        lamps[(*count)++] = lamp;
    }
    return lamps;
}

static double floor_area(const Building *b, const Region *region) {
    double area = 0;
    for (int k = region->first_ring; k < region->first_ring + region->ring_count; k++) {
        const Vec2 *p = b->points + b->rings[k].first_point;
        for (int i = 1; i + 1 < b->rings[k].point_count; i++) {
            area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
        }
    }
    return area;
}

// Regions: first lamp, lamps, outdoors, scale. The scale makes a room as bright as another, however strong its lamps:
// exposure, until there is a solution to look at.
static void make_lamps(WalkRenderer *r, Arena *scratch) {
    const Building *b = r->graph->building;
    int count, used = 0;
    Lamp *lamps = collect_lamps(r->graph, scratch, &count);
    float(*lamp)[4] = arena_alloc(scratch, 2 * (size_t)count + 1, sizeof *lamp);
    float(*region)[4] = arena_alloc(scratch, (size_t)b->region_count + 1, sizeof *region);
    for (int i = 0; i < b->region_count; i++) {
        double power = 0;
        int first = used;
        for (int k = 0; k < count && used - first < MOST_LAMPS; k++) {
            if (lamps[k].region != i) continue;
            Vec3 p = vec3_sub(lamps[k].position, r->origin);
            float place[4] = {(float)p.x, (float)p.y, (float)p.z, 0};
            float flux[4] = {lamps[k].flux.r, lamps[k].flux.g, lamps[k].flux.b, 0};
            memcpy(lamp[2 * used], place, sizeof place);
            memcpy(lamp[2 * used + 1], flux, sizeof flux);
            power += (lamps[k].flux.r + lamps[k].flux.g + lamps[k].flux.b) / 3;
            used++;
        }
        region[i][0] = (float)first;
        region[i][1] = (float)(used - first);
        region[i][2] = b->regions[i].kind == REGION_OUTDOORS;
        region[i][3] = power > 0 ? (float)(0.28 * floor_area(b, &b->regions[i]) / power) : 0;
    }
    make_texture(&r->lamp_buffer, &r->lamp_texture, (const float(*)[4])lamp, 2 * (size_t)count + 1);
    make_texture(&r->region_buffer, &r->region_texture, (const float(*)[4])region, (size_t)b->region_count + 1);
}

WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error) {
    WalkRenderer *r = ARENA_ARRAY(arena, WalkRenderer, 1);
    size_t objects = (size_t)graph->object_count + 1;
    r->graph = graph;
    r->origin = vec3_scale(vec3_add(graph->box.min, graph->box.max), 0.5);
    r->opaque = ARENA_ARRAY(arena, Run, objects);
    r->glass = ARENA_ARRAY(arena, Run, objects);
    r->run_count = ARENA_ARRAY(arena, GLsizei, objects);
    r->run_offset = ARENA_ARRAY(arena, const void *, objects);
    r->glass_order = ARENA_ARRAY(arena, int, objects);
    r->glass_distance = ARENA_ARRAY(arena, double, objects);
    r->program = gl_program(VERTEX_SHADER, FRAGMENT_SHADER, error);
    r->sky_program = r->program ? gl_program(SKY_VERTEX, SKY_FRAGMENT, error) : 0;
    if (!r->sky_program) return NULL;
    Arena scratch = {0};
    Upload upload = {0};
    fill(r, &upload, &scratch);
    make_buffers(r, &upload);
    make_lamps(r, &scratch);
    arena_free(&scratch);
    if (gl_check("uploading the building", error)) return r;
    walk_renderer_free(r);
    return NULL;
}

// ---- targets

static void free_targets(WalkRenderer *r) {
    glDeleteRenderbuffers(3, (unsigned[]){r->colour, r->depth, r->resolved_colour});
    glDeleteFramebuffers(2, (unsigned[]){r->frame, r->resolved_frame});
    r->colour = r->depth = r->resolved_colour = r->frame = r->resolved_frame = 0;
    r->width = r->height = 0;
}

void walk_renderer_free(WalkRenderer *r) {
    if (!r) return;
    free_targets(r);
    glDeleteBuffers(4, (unsigned[]){r->vertex_buffer, r->index_buffer, r->lamp_buffer, r->region_buffer});
    glDeleteTextures(2, (unsigned[]){r->lamp_texture, r->region_texture});
    glDeleteVertexArrays(2, (unsigned[]){r->array, r->sky_array});
    glDeleteProgram(r->program);
    glDeleteProgram(r->sky_program);
    arena_free(&r->images);
}

static unsigned target(unsigned attachment, unsigned format, int samples, int width, int height) {
    unsigned name;
    glGenRenderbuffers(1, &name);
    glBindRenderbuffer(GL_RENDERBUFFER, name);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, name);
    return name;
}

static bool make_targets(WalkRenderer *r, int width, int height, Error *error) {
    free_targets(r);
    int most = 0, samples = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    glGetIntegerv(GL_MAX_SAMPLES, &samples);
    if (width > most || height > most) {
        return error_set(error, "OpenGL: an image of %d x %d pixels (at most %d each)", width, height, most);
    }
    if (samples > SAMPLES) samples = SAMPLES;
    glGenFramebuffers(1, &r->frame);
    glBindFramebuffer(GL_FRAMEBUFFER, r->frame);
    r->colour = target(GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, width, height);
    r->depth = target(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, samples, width, height);
    bool good = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    glGenFramebuffers(1, &r->resolved_frame);
    glBindFramebuffer(GL_FRAMEBUFFER, r->resolved_frame);
    r->resolved_colour = target(GL_COLOR_ATTACHMENT0, GL_RGBA8, 0, width, height);
    good = good && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (!good) return error_set(error, "OpenGL: no image of %d x %d pixels with %d samples", width, height, samples);
    arena_reset(&r->images);
    r->pixels = ARENA_ARRAY(&r->images, uint8_t, 4 * (size_t)width * (size_t)height);
    r->width = width;
    r->height = height;
    return gl_check("making an image", error);
}

// ---- drawing

static void set_vector(unsigned program, const char *name, Vec3 v) {
    glUniform3f(glGetUniformLocation(program, name), (float)v.x, (float)v.y, (float)v.z);
}

static void draw_sky(const WalkRenderer *r, const Camera *camera) {
    glUseProgram(r->sky_program);
    set_vector(r->sky_program, "forward", camera->forward);
    set_vector(r->sky_program, "right", vec3_scale(camera->right, camera->tan_x));
    set_vector(r->sky_program, "up", vec3_scale(camera->up, camera->tan_y));
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glBindVertexArray(r->sky_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void set_camera(const WalkRenderer *r, const Camera *camera) {
    Vec3 eye = vec3_sub(camera->eye, r->origin), f = camera->forward, right = camera->right, up = camera->up;
    mat4 view = {{(float)right.x, (float)up.x, (float)-f.x, 0},
                 {(float)right.y, (float)up.y, (float)-f.y, 0},
                 {(float)right.z, (float)up.z, (float)-f.z, 0},
                 {(float)-vec3_dot(right, eye), (float)-vec3_dot(up, eye), (float)vec3_dot(f, eye), 1}};
    mat4 project, clip;
    float x = (float)(camera->tan_x * NEAR), y = (float)(camera->tan_y * NEAR);
    glm_frustum(-x, x, -y, y, (float)NEAR, (float)FAR, project);
    glm_mat4_mul(project, view, clip);
    glUseProgram(r->program);
    glUniformMatrix4fv(glGetUniformLocation(r->program, "clip"), 1, GL_FALSE, &clip[0][0]);
    glUniform1i(glGetUniformLocation(r->program, "lamps"), 0);
    glUniform1i(glGetUniformLocation(r->program, "regions"), 1);
    set_vector(r->program, "eye", eye);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_BUFFER, r->lamp_texture);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_BUFFER, r->region_texture);
    glBindVertexArray(r->array);
}

static void draw_opaque(WalkRenderer *r, const int *objects, int count) {
    int runs = 0;
    size_t end = 0;
    for (int i = 0; i < count; i++) {
        Run run = r->opaque[objects[i]];
        if (run.count == 0) continue;
        if (runs > 0 && run.first == end) {
            r->run_count[runs - 1] += run.count;
        } else {
            r->run_count[runs] = run.count;
            r->run_offset[runs++] = (const void *)(run.first * sizeof(unsigned));
        }
        end = run.first + (size_t)run.count;
    }
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glMultiDrawElements(GL_TRIANGLES, r->run_count, GL_UNSIGNED_INT, r->run_offset, runs);
}

// Farthest first, by the middle of each object's box.
static void draw_glass(WalkRenderer *r, Vec3 eye, const int *objects, int count) {
    int found = 0;
    for (int i = 0; i < count; i++) {
        if (r->glass[objects[i]].count == 0) continue;
        Box box = r->graph->object_boxes[objects[i]];
        double distance = vec3_length(vec3_sub(vec3_scale(vec3_add(box.min, box.max), 0.5), eye));
        int at = found++;
        for (; at > 0 && r->glass_distance[at - 1] < distance; at--) {
            r->glass_order[at] = r->glass_order[at - 1];
            r->glass_distance[at] = r->glass_distance[at - 1];
        }
        r->glass_order[at] = objects[i];
        r->glass_distance[at] = distance;
    }
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    for (int i = 0; i < found; i++) {
        Run run = r->glass[r->glass_order[i]];
        glDrawElements(GL_TRIANGLES, run.count, GL_UNSIGNED_INT, (const void *)(run.first * sizeof(unsigned)));
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

static void read_back(WalkRenderer *r, uint8_t *rgb) {
    glBindFramebuffer(GL_FRAMEBUFFER, r->resolved_frame);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, r->width, r->height, GL_RGBA, GL_UNSIGNED_BYTE, r->pixels);
    for (int y = 0; y < r->height; y++) {
        const uint8_t *from = r->pixels + 4 * (size_t)(r->height - 1 - y) * (size_t)r->width;
        uint8_t *to = rgb + 3 * (size_t)y * (size_t)r->width;
        for (int x = 0; x < r->width; x++) memcpy(to + 3 * x, from + 4 * x, 3);
    }
}

bool walk_renderer_draw(WalkRenderer *r, const Camera *camera, const int *objects, int count, uint8_t *rgb,
                        Error *error) {
    if ((r->width != camera->width || r->height != camera->height) &&
        !make_targets(r, camera->width, camera->height, error)) {
        return false;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, r->frame);
    glViewport(0, 0, r->width, r->height);
    glEnable(GL_MULTISAMPLE);
    glDisable(GL_CULL_FACE);
    glClearBufferfv(GL_DEPTH, 0, &(float){1});
    draw_sky(r, camera);
    set_camera(r, camera);
    draw_opaque(r, objects, count);
    draw_glass(r, camera->eye, objects, count);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, r->frame);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, r->resolved_frame);
    glBlitFramebuffer(0, 0, r->width, r->height, 0, 0, r->width, r->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    if (rgb) {
        read_back(r, rgb);
    } else {
        glFinish();
    }
    return gl_check("drawing a picture", error);
}
