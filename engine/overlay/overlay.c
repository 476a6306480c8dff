// overlay.c - everything is drawn as quadrilaterals of three kinds. Fills are flat. In a shape, the fragment shader measures the
// distance from a box: a shape is the set of points within a radius of a box, so a line is a box without width, a circle a box
// without extent; coverage is the distance to the edge in pixels, plus a half (Green 2007, with an exact distance instead of a
// stored one). Letters lie on whole pixels, one texel each.
#include "engine/overlay/overlay.h"

#include <glad/gl.h>

#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"

// How far beyond a shape's edge it still covers part of a pixel, pixels.
#define OVERLAY_FRINGE 0.5

typedef struct FillCorner {
    float x, y;  // pixels
    uint8_t rgba[4];
} FillCorner;

typedef struct ShapeCorner {
    float x, y;      // pixels
    float local[2];  // from the box's middle along its sides, pixels
    float half[2];   // half the box's sides, pixels
    float radius;    // around the box, pixels
    uint8_t rgba[4];
} ShapeCorner;

typedef struct LetterCorner {
    int16_t x, y, u, v;  // pixels, texels
    uint8_t rgba[4];
} LetterCorner;

typedef struct Fill {
    FillCorner corner[4];
} Fill;

typedef struct Shape {
    ShapeCorner corner[4];
} Shape;

typedef struct Letter {
    LetterCorner corner[4];
} Letter;

// A rectangle of pixels: x0 <= x < x1, y0 <= y < y1.
typedef struct Clip {
    int x0, y0, x1, y1;
} Clip;

typedef enum Kind { FILLS, SHAPES, LETTERS, KINDS } Kind;

// Quadrilaterals drawn in one call: neighbours of a kind that are clipped alike.
typedef struct Run {
    Kind kind;
    int first, count;
    Clip clip;
} Run;

// The OpenGL objects that draw one kind.
typedef struct Pen {
    unsigned program, array, vertex_buffer;
    int size;  // location of the uniform
} Pen;

struct Overlay {
    Arena *arena;
    Font *font;
    Pen pen[KINDS];
    Fill *fills;
    Shape *shapes;
    Letter *letters;
    Run *runs;         // in the order of drawing
    int count[KINDS];  // of fills, shapes, letters
    int capacity[KINDS];
    int run_count, run_capacity;
    unsigned index_buffer, image;
    int indexed;  // quadrilaterals in the index buffer
    int image_height;
    int width, height;
    double scale;
    Clip clip;
};

static const char FILL_VERTEX[] =
    "#version 330 core\n"
    "layout(location = 0) in vec2 position;\n"
    "layout(location = 1) in vec4 colour;\n"
    "uniform vec2 size;\n"
    "flat out vec4 vColour;\n"
    "void main() { gl_Position = vec4(2.0 * position / size - 1.0, 0.0, 1.0); vColour = colour; }\n";

static const char FILL_FRAGMENT[] = "#version 330 core\n"
                                    "flat in vec4 vColour;\n"
                                    "out vec4 result;\n"
                                    "void main() { result = vColour; }\n";

static const char SHAPE_VERTEX[] = "#version 330 core\n"
                                   "layout(location = 0) in vec2 position;\n"
                                   "layout(location = 1) in vec2 local;\n"
                                   "layout(location = 2) in vec3 box;\n"
                                   "layout(location = 3) in vec4 colour;\n"
                                   "uniform vec2 size;\n"
                                   "out vec2 vLocal;\n"
                                   "flat out vec3 vBox;\n"
                                   "flat out vec4 vColour;\n"
                                   "void main() {\n"
                                   "    gl_Position = vec4(2.0 * position / size - 1.0, 0.0, 1.0);\n"
                                   "    vLocal = local; vBox = box; vColour = colour;\n"
                                   "}\n";

static const char SHAPE_FRAGMENT[] =
    "#version 330 core\n"
    "in vec2 vLocal;\n"
    "flat in vec3 vBox;\n"
    "flat in vec4 vColour;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    float away = length(max(abs(vLocal) - vBox.xy, 0.0));\n"
    "    result = vec4(vColour.rgb, vColour.a * clamp(vBox.z + 0.5 - away, 0.0, 1.0));\n"
    "}\n";

static const char LETTER_VERTEX[] = "#version 330 core\n"
                                    "layout(location = 0) in vec2 position;\n"
                                    "layout(location = 1) in vec2 texel;\n"
                                    "layout(location = 2) in vec4 colour;\n"
                                    "uniform vec2 size;\n"
                                    "out vec2 vTexel;\n"
                                    "flat out vec4 vColour;\n"
                                    "void main() {\n"
                                    "    gl_Position = vec4(2.0 * position / size - 1.0, 0.0, 1.0);\n"
                                    "    vTexel = texel; vColour = colour;\n"
                                    "}\n";

static const char LETTER_FRAGMENT[] =
    "#version 330 core\n"
    "in vec2 vTexel;\n"
    "flat in vec4 vColour;\n"
    "uniform sampler2D image;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    result = vec4(vColour.rgb, vColour.a * texelFetch(image, ivec2(vTexel), 0).r);\n"
    "}\n";

// ---- set-up

static bool make_pen(Pen *pen, const char *vertex, const char *fragment, Error *error) {
    pen->program = gl_program(vertex, fragment, error);
    if (!pen->program) return false;
    pen->size = glGetUniformLocation(pen->program, "size");
    glGenVertexArrays(1, &pen->array);
    glBindVertexArray(pen->array);
    glGenBuffers(1, &pen->vertex_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, pen->vertex_buffer);
    return true;
}

static void describe(unsigned place, int count, unsigned type, bool share, size_t stride, size_t offset) {
    glEnableVertexAttribArray(place);
    glVertexAttribPointer(place, count, type, share, (GLsizei)stride, (const void *)offset);
}

static bool make_pens(Overlay *o, Error *error) {
    if (!make_pen(&o->pen[FILLS], FILL_VERTEX, FILL_FRAGMENT, error)) return false;
    size_t stride = sizeof(FillCorner);
    describe(0, 2, GL_FLOAT, false, stride, offsetof(FillCorner, x));
    describe(1, 4, GL_UNSIGNED_BYTE, true, stride, offsetof(FillCorner, rgba));
    if (!make_pen(&o->pen[SHAPES], SHAPE_VERTEX, SHAPE_FRAGMENT, error)) return false;
    stride = sizeof(ShapeCorner);
    describe(0, 2, GL_FLOAT, false, stride, offsetof(ShapeCorner, x));
    describe(1, 2, GL_FLOAT, false, stride, offsetof(ShapeCorner, local));
    describe(2, 3, GL_FLOAT, false, stride, offsetof(ShapeCorner, half));
    describe(3, 4, GL_UNSIGNED_BYTE, true, stride, offsetof(ShapeCorner, rgba));
    if (!make_pen(&o->pen[LETTERS], LETTER_VERTEX, LETTER_FRAGMENT, error)) return false;
    stride = sizeof(LetterCorner);
    describe(0, 2, GL_SHORT, false, stride, offsetof(LetterCorner, x));
    describe(1, 2, GL_SHORT, false, stride, offsetof(LetterCorner, u));
    describe(2, 4, GL_UNSIGNED_BYTE, true, stride, offsetof(LetterCorner, rgba));
    glUseProgram(o->pen[LETTERS].program);
    glUniform1i(glGetUniformLocation(o->pen[LETTERS].program, "image"), 0);
    glGenBuffers(1, &o->index_buffer);
    glGenTextures(1, &o->image);
    return gl_check("making the overlay", error);
}

Overlay *overlay_new(Arena *arena, Error *error) {
    Overlay *o = ARENA_ARRAY(arena, Overlay, 1);
    o->arena = arena;
    o->font = font_new(arena);
    if (make_pens(o, error)) return o;
    overlay_free(o);
    return NULL;
}

void overlay_free(Overlay *o) {
    if (!o) return;
    for (int kind = 0; kind < KINDS; kind++) {
        glDeleteVertexArrays(1, &o->pen[kind].array);
        glDeleteBuffers(1, &o->pen[kind].vertex_buffer);
        glDeleteProgram(o->pen[kind].program);
    }
    glDeleteBuffers(1, &o->index_buffer);
    glDeleteTextures(1, &o->image);
}

// ---- a frame

void overlay_begin(Overlay *o, int width, int height, double scale) {
    CORE_ASSERT(width >= 1 && height >= 1 && scale > 0);
    font_trim(o->font);
    o->width = width;
    o->height = height;
    o->scale = scale;
    memset(o->count, 0, sizeof o->count);
    o->run_count = 0;
    overlay_unclip(o);
}

double overlay_width(const Overlay *o) { return o->width / o->scale; }
double overlay_height(const Overlay *o) { return o->height / o->scale; }
double overlay_scale(const Overlay *o) { return o->scale; }

static int within(double pixel, int most) { return (int)lround(fmin(fmax(pixel, 0), most)); }

void overlay_clip(Overlay *o, double x, double y, double width, double height) {
    o->clip = (Clip){within(x * o->scale, o->width), within(y * o->scale, o->height),
                     within((x + width) * o->scale, o->width), within((y + height) * o->scale, o->height)};
}

void overlay_unclip(Overlay *o) { o->clip = (Clip){0, 0, o->width, o->height}; }

// Does anything between these pixels show? For coordinates that are not numbers the answer is no.
static bool shows(const Overlay *o, double x0, double y0, double x1, double y1) {
    const Clip *c = &o->clip;
    return x0 < c->x1 && x1 > c->x0 && y0 < c->y1 && y1 > c->y0;
}

// Counts one more quadrilateral in the last run; begins a run where the last has another kind or clip.
static void add_to_run(Overlay *o, Kind kind) {
    Run *last = o->run_count ? &o->runs[o->run_count - 1] : NULL;
    if (!last || last->kind != kind || memcmp(&last->clip, &o->clip, sizeof o->clip) != 0) {
        last = ARENA_PUSH(o->arena, o->runs, o->run_count, o->run_capacity);
        *last = (Run){kind, o->count[kind], 0, o->clip};
    }
    last->count++;
}

static uint8_t byte(double x) { return (uint8_t)lround(255 * fmin(fmax(x, 0), 1)); }

static void set_colour(uint8_t rgba[4], unsigned rgb, double opacity) {
    rgba[0] = (uint8_t)(rgb >> 16);
    rgba[1] = (uint8_t)(rgb >> 8);
    rgba[2] = (uint8_t)rgb;
    rgba[3] = byte(opacity);
}

// ---- shapes

// Adds all points within `radius` of a box, in pixels; `along` is the unit direction of the box's first side.
static void add_shape(Overlay *o, Vec2 middle, Vec2 along, Vec2 half, double radius, unsigned rgb,
                      double opacity) {
    double x = half.x + radius + OVERLAY_FRINGE, y = half.y + radius + OVERLAY_FRINGE;
    double reach_x = fabs(along.x) * x + fabs(along.y) * y, reach_y = fabs(along.y) * x + fabs(along.x) * y;
    if (opacity <= 0 ||
        !shows(o, middle.x - reach_x, middle.y - reach_y, middle.x + reach_x, middle.y + reach_y)) {
        return;
    }
    ShapeCorner corner = {.half = {(float)half.x, (float)half.y}, .radius = (float)radius};
    set_colour(corner.rgba, rgb, opacity);
    add_to_run(o, SHAPES);
    Shape *shape = ARENA_PUSH(o->arena, o->shapes, o->count[SHAPES], o->capacity[SHAPES]);
    for (int i = 0; i < 4; i++) {
        double u = i == 0 || i == 3 ? -x : x, v = i < 2 ? -y : y;
        corner.x = (float)(middle.x + u * along.x - v * along.y);
        corner.y = (float)(middle.y + u * along.y + v * along.x);
        corner.local[0] = (float)u;
        corner.local[1] = (float)v;
        shape->corner[i] = corner;
    }
}

void overlay_polygon(Overlay *o, const Vec2 *points, int count, unsigned rgb, double opacity) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        box = box_add(box, vec3(points[i].x * o->scale, points[i].y * o->scale, 0));
    }
    if (count < 3 || opacity <= 0 || !shows(o, box.min.x, box.min.y, box.max.x, box.max.y)) return;
    FillCorner corner = {0};
    set_colour(corner.rgba, rgb, opacity);
    // A fan of quadrilaterals; where the fan has an odd number of triangles, the last quadrilateral has two corners in one place.
    for (int i = 1; i + 1 < count; i += 2) {
        int at[4] = {0, i, i + 1, i + 2 < count ? i + 2 : i + 1};
        add_to_run(o, FILLS);
        Fill *fill = ARENA_PUSH(o->arena, o->fills, o->count[FILLS], o->capacity[FILLS]);
        for (int k = 0; k < 4; k++) {
            corner.x = (float)(points[at[k]].x * o->scale);
            corner.y = (float)(points[at[k]].y * o->scale);
            fill->corner[k] = corner;
        }
    }
}

void overlay_rectangle(Overlay *o, double x, double y, double width, double height, double radius,
                       unsigned rgb, double opacity) {
    double x0 = round(x * o->scale), x1 = round((x + width) * o->scale);
    double y0 = round(y * o->scale), y1 = round((y + height) * o->scale);
    if (!(x1 > x0 && y1 > y0)) return;
    Vec2 half = {(x1 - x0) / 2, (y1 - y0) / 2};
    // The half pixel of a smoothed edge must lie within the radius; no rectangle has a smaller radius.
    double r = fmax(0.5, fmin(radius * o->scale, fmin(half.x, half.y)));
    add_shape(o, vec2((x0 + x1) / 2, (y0 + y1) / 2), vec2(1, 0), vec2(half.x - r, half.y - r), r, rgb,
              opacity);
}

void overlay_line(Overlay *o, Vec2 a, Vec2 b, double width, unsigned rgb, double opacity) {
    Vec2 from = vec2_scale(a, o->scale), way = vec2_scale(vec2_sub(b, a), o->scale);
    double length = vec2_length(way), pixels = width * o->scale;
    Vec2 along = length > 0 ? vec2_scale(way, 1 / length) : vec2(1, 0);
    add_shape(o, vec2_add(from, vec2_scale(way, 0.5)), along, vec2(length / 2, 0), fmax(pixels, 1) / 2, rgb,
              opacity * fmin(pixels, 1));
}

void overlay_circle(Overlay *o, Vec2 centre, double radius, unsigned rgb, double opacity) {
    double r = radius * o->scale;
    if (r > 0) add_shape(o, vec2_scale(centre, o->scale), vec2(1, 0), vec2(0, 0), r, rgb, opacity);
}

// ---- text

static void add_letter(Overlay *o, int x, int y, const Glyph *glyph, const uint8_t rgba[4]) {
    if (glyph->width == 0 || !shows(o, x, y, x + glyph->width, y + glyph->height)) return;
    add_to_run(o, LETTERS);
    Letter *letter = ARENA_PUSH(o->arena, o->letters, o->count[LETTERS], o->capacity[LETTERS]);
    for (int i = 0; i < 4; i++) {
        int u = i == 0 || i == 3 ? 0 : glyph->width, v = i < 2 ? 0 : glyph->height;
        letter->corner[i] = (LetterCorner){(int16_t)(x + u),
                                           (int16_t)(y + v),
                                           (int16_t)(glyph->x + u),
                                           (int16_t)(glyph->y + v),
                                           {rgba[0], rgba[1], rgba[2], rgba[3]}};
    }
}

static int pixel_size(const Overlay *o, double size) {
    return (int)lround(fmin(fmax(size * o->scale, FONT_SMALLEST), FONT_LARGEST));
}

// Moves the pen over the next character, and draws the character unless `rgba` is NULL. Positions are in pixels.
static void set_character(Overlay *o, double *pen, int row, int size, int character, Glyph *before,
                          const uint8_t *rgba) {
    Glyph glyph = font_glyph(o->font, character, size, 0);
    if (before->advance > 0) *pen += font_kerning(o->font, before, &glyph, size);
    *before = glyph;
    if (rgba && fabs(*pen) < INT16_MAX / 2) {
        int place = (int)lround(*pen * FONT_STEPS), step = (place % FONT_STEPS + FONT_STEPS) % FONT_STEPS;
        if (step) glyph = font_glyph(o->font, character, size, step);
        add_letter(o, (place - step) / FONT_STEPS + glyph.left, row + glyph.top, &glyph, rgba);
    }
    *pen += (double)before->advance;
}

void overlay_text(Overlay *o, double x, double baseline, double size, unsigned rgb, double opacity,
                  const char *utf8) {
    uint8_t rgba[4];
    set_colour(rgba, rgb, opacity);
    double pen = x * o->scale, row = round(baseline * o->scale);
    if (rgba[3] == 0 || !(fabs(row) < INT16_MAX / 2)) return;
    Glyph before = {0};
    for (int character; (character = font_decode(&utf8));) {
        set_character(o, &pen, (int)row, pixel_size(o, size), character, &before, rgba);
    }
}

double overlay_text_width(Overlay *o, double size, const char *utf8) {
    double pen = 0;
    Glyph before = {0};
    for (int character; (character = font_decode(&utf8));) {
        set_character(o, &pen, 0, pixel_size(o, size), character, &before, NULL);
    }
    return pen / o->scale;
}

size_t overlay_text_fit(Overlay *o, double size, const char *utf8, double width) {
    double pen = 0;
    Glyph before = {0};
    const char *at = utf8, *end = utf8;
    for (int character; (character = font_decode(&at)); end = at) {
        set_character(o, &pen, 0, pixel_size(o, size), character, &before, NULL);
        if (pen > width * o->scale) break;
    }
    return (size_t)(end - utf8);
}

// ---- to OpenGL

// Writes two triangles for each quadrilateral; all kinds share these indices.
static void grow_indices(Overlay *o, int count) {
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, o->index_buffer);
    if (count <= o->indexed) return;
    static const unsigned CORNERS[6] = {0, 1, 2, 0, 2, 3};
    o->indexed = 2 * count;
    Arena scratch = {0};
    unsigned *index = ARENA_ARRAY(&scratch, unsigned, 6 * o->indexed);
    for (int i = 0; i < 6 * o->indexed; i++) index[i] = 4 * (unsigned)(i / 6) + CORNERS[i % 6];
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)(6 * o->indexed) * sizeof *index), index,
                 GL_STATIC_DRAW);
    arena_free(&scratch);
}

static void upload_image(Overlay *o) {
    FontImage image = font_image(o->font);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, o->image);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (image.height != o->image_height) {
        glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, image.width, image.height, 0, GL_RED, GL_UNSIGNED_BYTE,
                     image.coverage);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        o->image_height = image.height;
    } else if (image.row_count > 0) {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, image.first_row, image.width, image.row_count, GL_RED,
                        GL_UNSIGNED_BYTE, image.coverage + (size_t)image.first_row * (size_t)image.width);
    }
}

static void upload(Overlay *o, Kind kind, const void *vertices, size_t size) {
    int count = o->count[kind];
    if (count == 0) return;
    const Pen *pen = &o->pen[kind];
    glBindVertexArray(pen->array);
    grow_indices(o, count);
    glBindBuffer(GL_ARRAY_BUFFER, pen->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)count * size), vertices, GL_STREAM_DRAW);
    glUseProgram(pen->program);
    glUniform2f(pen->size, (float)o->width, (float)o->height);
}

static void draw_runs(const Overlay *o) {
    for (int i = 0; i < o->run_count; i++) {
        const Run *run = &o->runs[i];
        if (i == 0 || run->kind != run[-1].kind) {
            glUseProgram(o->pen[run->kind].program);
            glBindVertexArray(o->pen[run->kind].array);
        }
        glScissor(run->clip.x0, run->clip.y0, run->clip.x1 - run->clip.x0, run->clip.y1 - run->clip.y0);
        glDrawElements(GL_TRIANGLES, 6 * run->count, GL_UNSIGNED_INT,
                       (const void *)((size_t)(6 * run->first) * sizeof(unsigned)));
    }
}

bool overlay_end(Overlay *o, Error *error) {
    glViewport(0, 0, o->width, o->height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    // An opaque pixel stays opaque, for systems that take alpha into account when they show a window.
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    upload_image(o);
    upload(o, FILLS, o->fills, sizeof *o->fills);
    upload(o, SHAPES, o->shapes, sizeof *o->shapes);
    upload(o, LETTERS, o->letters, sizeof *o->letters);
    draw_runs(o);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    return gl_check("drawing the overlay", error);
}
