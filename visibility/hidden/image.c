// image.c - from the scene's facets to lines in the picture.
#include "visibility/hidden/image.h"

// Bounds are so much wider than rounding could make them, pixels; the lines alone decide which pixels are inside.
#define IMAGE_MARGIN 0.01
// Bounds of 1/depth alike, as a share of it.
#define DEPTH_MARGIN 1e-6

Image image_new(const Camera *camera) {
    Image image = {.eye = camera->eye, .width = camera->width, .height = camera->height};
    double half_x = camera->width / 2.0, half_y = camera->height / 2.0;
    image.right = vec3_scale(camera->right, camera->tan_x / half_x);
    image.down = vec3_scale(camera->up, -camera->tan_y / half_y);
    image.corner = camera_ray(camera, 0.5, 0.5);
    Vec3 f = camera->forward;
    Vec3 x = vec3_add(vec3_scale(f, half_x - 0.5), vec3_scale(camera->right, half_x / camera->tan_x));
    Vec3 y = vec3_add(vec3_scale(f, half_y - 0.5), vec3_scale(camera->up, -half_y / camera->tan_y));
    image.column[0] = (Four){x.x, y.x, f.x, 0};
    image.column[1] = (Four){x.y, y.y, f.y, 0};
    image.column[2] = (Four){x.z, y.z, f.z, 0};
    return image;
}

static inline Four place(const Image *image, Vec3 corner) {
    Vec3 d = vec3_sub(corner, image->eye);
    return image->column[0] * d.x + image->column[1] * d.y + image->column[2] * d.z;
}

// The line through two places; the other way round it is the same line, negated, bit by bit.
static inline Line through(Four p, Four q) {
    Four p1 = __builtin_shufflevector(p, p, 1, 2, 0, 3), q2 = __builtin_shufflevector(q, q, 2, 0, 1, 3);
    Four p2 = __builtin_shufflevector(p, p, 2, 0, 1, 3), q1 = __builtin_shufflevector(q, q, 1, 2, 0, 3);
    return p1 * q2 - p2 * q1;
}

static inline Line along_rays(const Image *image, Vec3 n) {
    return (Line){vec3_dot(n, image->right), vec3_dot(n, image->down), vec3_dot(n, image->corner), 0};
}

Line image_cut(const Image *image, Vec3 n, double d, Line depth) {
    // At eye + ray / (1/z): dot(n, eye) - d + dot(n, ray) / (1/z), times 1/z.
    return along_rays(image, n) + four_of(vec3_dot(n, image->eye) - d) * depth;
}

// Keeps the part up to a pixel beyond one of the picture's four sides. It is the clipper of core/polygon.h in homogeneous coordinates,
// where places behind the eye are cut before anything is divided.
static int clip_side(const Image *image, int side, const Four *in, int count, Four *out) {
    Four f = side == 0   ? (Four){1, 0, 1, 0}
             : side == 1 ? (Four){-1, 0, image->width, 0}
             : side == 2 ? (Four){0, 1, 1, 0}
                         : (Four){0, -1, image->height, 0};
    int kept = 0;
    Four last = count > 0 ? in[count - 1] : (Four){0};
    double before = f[0] * last[0] + f[1] * last[1] + f[2] * last[2];
    for (int i = 0; i < count; i++) {
        double here = f[0] * in[i][0] + f[1] * in[i][1] + f[2] * in[i][2];
        if ((before < 0) != (here < 0)) out[kept++] = last + (in[i] - last) * (before / (before - here));
        if (here >= 0) out[kept++] = in[i];
        last = in[i];
        before = here;
    }
    return kept;
}

static int clip_to_view(const Image *image, Four *places, int count) {
    Four other[FACET_CORNERS + 4];
    for (int side = 0; side < 4; side += 2) {
        count = clip_side(image, side, places, count, other);
        count = clip_side(image, side + 1, other, count, places);
    }
    return count;
}

int image_outline(const Image *image, const Vec3 *corners, int count, Vec2 *out, double *inverse) {
    Four places[FACET_CORNERS + 4];
    for (int i = 0; i < count; i++) places[i] = place(image, corners[i]);
    count = clip_to_view(image, places, count);
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (!(places[i][2] > 0)) continue;  // rounding, of a corner next to the eye
        inverse[kept] = 1 / places[i][2];
        out[kept] = vec2(places[i][0] * inverse[kept], places[i][1] * inverse[kept]);
        kept++;
    }
    return kept < 3 ? 0 : kept;
}

// The least and the most of x, y and 1/z, in lanes 0, 1 and 2.
typedef struct Extent {
    Four least, most;
} Extent;

static inline Extent extent_add(Extent e, Four at) {
    return (Extent){four_least(e.least, at), four_most(e.most, at)};
}

// A place before the eye.
static inline Four seen_at(Four p) {
    Four inverse = four_of(1 / p[2]);
    return __builtin_shufflevector(p * inverse, inverse, 0, 1, 4, 5);
}

static inline bool extent_bounds(const Image *image, const Extent *e, Shape *out) {
    double right = image->width - 1, bottom = image->height - 1;
    double x0 = e->least[0] - IMAGE_MARGIN, x1 = e->most[0] + IMAGE_MARGIN;
    double y0 = e->least[1] - IMAGE_MARGIN, y1 = e->most[1] + IMAGE_MARGIN;
    if (!(x1 >= 0 && x0 <= right && y1 >= 0 && y0 <= bottom)) return false;
    out->x0 = x0 > 0 ? (int)ceil(x0) : 0;
    out->y0 = y0 > 0 ? (int)ceil(y0) : 0;
    out->x1 = (int)(x1 < right ? x1 : right);
    out->y1 = (int)(y1 < bottom ? y1 : bottom);
    return out->x0 <= out->x1 && out->y0 <= out->y1;
}

static const Extent NO_EXTENT = {{INFINITY, INFINITY, INFINITY, INFINITY},
                                 {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};

bool image_bounds(const Image *image, const Vec2 *corners, int count, Shape *out) {
    Extent e = NO_EXTENT;
    for (int i = 0; i < count; i++) e = extent_add(e, (Four){corners[i].x, corners[i].y, 1, 0});
    return extent_bounds(image, &e, out);
}

static bool extent_of_clipped(const Image *image, const Vec3 *corners, int count, Extent *e) {
    Vec2 outline[FACET_CORNERS + 4];
    double inverse[FACET_CORNERS + 4];
    count = image_outline(image, corners, count, outline, inverse);
    for (int i = 0; i < count; i++) *e = extent_add(*e, (Four){outline[i].x, outline[i].y, inverse[i], 0});
    return count > 0;
}

bool image_shape(const Image *image, const Facets *facets, int facet, Line *lines, Line *depth, Shape *out) {
    const Facet *f = &facets->facets[facet];
    double height = vec3_dot(f->n, vec3_sub(f->centre, image->eye));
    if (fabs(height) < HIDDEN_EDGE_ON) return false;
    const Vec3 *corners = facets->corners + f->first;
    Four places[FACET_CORNERS + 1], least = four_of(INFINITY), most = -least;
    int count = f->count;
    for (int i = 0; i < count; i++) {
        places[i] = place(image, corners[i]);
        least = four_least(least, places[i]);
        most = four_most(most, places[i]);
    }
    if (!(most[2] > 0)) return false;
    Extent e = NO_EXTENT;
    if (least[2] > 0) {
        for (int i = 0; i < count; i++) e = extent_add(e, seen_at(places[i]));
    } else if (!extent_of_clipped(image, corners, count, &e)) {
        return false;
    }
    if (!extent_bounds(image, &e, out)) return false;
    out->facet = facet;
    out->line_count = count;
    out->nearest = e.most[2] * (1 + DEPTH_MARGIN);
    out->farthest = e.least[2] * (1 - DEPTH_MARGIN);
    // Counter-clockwise about n, which points away from the eye where height is above 0: then the inside is to the left.
    Four sign = four_of(height > 0 ? 1 : -1);
    places[count] = places[0];
    for (int i = 0; i < count; i++) lines[i] = sign * through(places[i], places[i + 1]);
    *depth = along_rays(image, f->n) / four_of(height);
    return true;
}

Picture picture_new(const Facets *facets, Arena *arena) {
    return (Picture){.facets = facets,
                     .depth = ARENA_ARRAY(arena, Line, facets->count + 1),
                     .shapes = ARENA_ARRAY(arena, Shape, facets->count + 1),
                     .lines = ARENA_ARRAY(arena, Line, facets->corner_count + 1)};
}

void picture_take(Picture *picture, const Camera *camera) {
    picture->image = image_new(camera);
    picture->shape_count = 0;
    int lines = 0;
    for (int i = 0; i < picture->facets->count; i++) {
        Shape *shape = &picture->shapes[picture->shape_count];
        if (!image_shape(&picture->image, picture->facets, i, picture->lines + lines, &picture->depth[i],
                         shape))
            continue;
        shape->first_line = lines;
        lines += shape->line_count;
        picture->shape_count++;
    }
}

void picture_resolve(const Picture *picture, ItemBuffer *out) {
    for (int y = 0; y < out->height; y++) {
        int32_t *item = out->item + (size_t)y * (size_t)out->width;
        float *depth = out->depth + (size_t)y * (size_t)out->width;
        for (int x = 0; x < out->width; x++) {
            int facet = item[x];
            depth[x] = facet < 0 ? INFINITY : (float)(1 / line_at(&picture->depth[facet], x, y));
            item[x] = facet < 0 ? -1 : picture->facets->facets[facet].polygon;
        }
    }
}
