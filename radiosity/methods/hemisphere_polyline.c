// hemisphere_polyline.c - the hemisphere base as in its paper: elements as triangles, edges as polylines on the disc, a z-buffer
// (Doi & Itoh, eqs. 1-7).
//
// A vertex is projected to (x / length, y / length), where `length` is its distance and its depth. An edge that spans more than the
// threshold (1 degree) is cut at its middle in space. The depth at a pixel is the depth of the plane through the three projected
// vertices. Two misprints are corrected: the angle of eq. 4 is the angle between the two unit directions, and eq. 5 needs a minus.
// The method's other errors are kept, to be measured: edges are chords, also along the rim, and depth in this projection is not
// planar, so that large elements come out too near or too far.
//
// Departures: elements are clipped at the horizon, and the item buffer stores faces; the element of a pixel is the one at the point
// where the pixel's direction meets the face.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/form_factor.h"

enum {
    LINE_CROSSINGS = 32,  // of a triangle with a line of pixels: 6, and some for rounding
    POLYLINE_LEAST = 1,   // the smallest threshold, thousandths of a degree
};

typedef struct Polyline {
    const Mesh *mesh;
    int resolution, corners;  // `corners`: the most corners of an element
    double threshold_cosine;
    FormFactorSamples samples;
    int *first_sample, *first_pixel;  // [resolution + 1], [resolution] the first of each line of pixels
    double *depth;                    // [samples.count]
    Vec3 *turned, *clipped;           // [corners], [corners + 1]
    Vec2 *point;                      // [point_capacity] the polyline of the current triangle
    int point_count, point_capacity;
    double (*crossing)[LINE_CROSSINGS];  // [resolution]
    int *crossing_count;                 // [resolution] 0 between triangles
} Polyline;

static double pixel_at(int i, int resolution) { return -1 + (2 * i + 1.0) / resolution; }

static void find_samples(Polyline *self, Arena *arena) {
    int n = self->resolution, count = 0;
    self->first_sample = ARENA_ARRAY(arena, int, n + 1);
    self->first_pixel = ARENA_ARRAY(arena, int, n);
    for (int pass = 0; pass < 2; pass++) {
        count = 0;
        for (int j = 0; j < n; j++) {
            double y = pixel_at(j, n);
            self->first_sample[j] = count;
            self->first_pixel[j] = n;
            for (int i = 0; i < n; i++) {
                double x = pixel_at(i, n), z2 = 1 - x * x - y * y;
                if (z2 <= 0) continue;
                if (i < self->first_pixel[j]) self->first_pixel[j] = i;
                if (pass == 1) {
                    self->samples.x[count] = (float)x, self->samples.y[count] = (float)y;
                    self->samples.z[count] = (float)sqrt(z2);
                }
                count++;
            }
        }
        self->first_sample[n] = count;
        if (pass == 1) break;
        self->samples.x = ARENA_ARRAY(arena, float, count);
        self->samples.y = ARENA_ARRAY(arena, float, count);
        self->samples.z = ARENA_ARRAY(arena, float, count);
        self->samples.weight = ARENA_ARRAY(arena, float, count);
    }
    self->samples.count = count;
    // Eq. 7 has 4 / (pi n^2), which differs only for the pixels that the rim cuts.
    for (int s = 0; s < count; s++) self->samples.weight[s] = (float)(1.0 / count);
}

static void *polyline_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    Polyline *self = ARENA_ARRAY(arena, Polyline, 1);
    double threshold = fmax(options->edge_threshold, POLYLINE_LEAST * M_PI / 180000);
    self->mesh = mesh;
    self->resolution = options->resolution;
    self->threshold_cosine = cos(fmin(threshold, M_PI));
    for (int i = 0; i < mesh->element_count; i++)
        if (mesh->elements[i].corner_count > self->corners) self->corners = mesh->elements[i].corner_count;
    find_samples(self, arena);
    self->depth = ARENA_ARRAY(arena, double, self->samples.count);
    self->turned = ARENA_ARRAY(arena, Vec3, self->corners);
    self->clipped = ARENA_ARRAY(arena, Vec3, self->corners + 1);
    // Halving in space leaves parts of unequal angles: room for parts down to an eighth of the threshold.
    self->point_capacity = 3 * (int)(8 * M_PI / threshold + 64);
    self->point = ARENA_ARRAY(arena, Vec2, self->point_capacity);
    self->crossing = arena_alloc(arena, (size_t)self->resolution, sizeof *self->crossing);
    self->crossing_count = ARENA_ARRAY(arena, int, self->resolution);
    return self;
}

static const FormFactorSamples *polyline_samples(void *context) { return &((Polyline *)context)->samples; }

// Adds the points of the edge from a to b in space, all but the first.
static void add_edge(Polyline *self, Vec3 a, Vec3 b) {
    double a_length = vec3_length(a), b_length = vec3_length(b);
    bool wide = vec3_dot(a, b) < self->threshold_cosine * a_length * b_length;
    if (wide && self->point_count < self->point_capacity - 64) {
        Vec3 middle = vec3_scale(vec3_add(a, b), 0.5);
        add_edge(self, a, middle);
        add_edge(self, middle, b);
        return;
    }
    CORE_ASSERT(self->point_count < self->point_capacity);
    self->point[self->point_count++] = vec2(b.x / b_length, b.y / b_length);
}

// Adds the crossings of the side a - b with lines of pixels; b - a gives the same crossings.
static void cross_lines(Polyline *self, Vec2 a, Vec2 b) {
    int n = self->resolution;
    if (a.y > b.y) {
        Vec2 c = a;
        a = b;
        b = c;
    }
    int first = (int)fmax(0, ceil((a.y + 1) * (0.5 * n) - 0.5));
    int end = (int)fmin(n, ceil((b.y + 1) * (0.5 * n) - 0.5));
    for (int j = first; j < end; j++) {
        double x = a.x + (pixel_at(j, n) - a.y) / (b.y - a.y) * (b.x - a.x);
        int k = self->crossing_count[j]++;
        CORE_ASSERT(k < LINE_CROSSINGS);
        for (; k > 0 && self->crossing[j][k - 1] > x; k--) self->crossing[j][k] = self->crossing[j][k - 1];
        self->crossing[j][k] = x;
    }
}

typedef struct Fill {
    double a, b, c;  // depth = ax + by + c
    int face, rank;
    const View *view;
    int32_t *item;
} Fill;

// Fills the pixels x0 <= x < x1 of line j where the triangle is nearer.
static void fill_pixels(Polyline *self, const Fill *fill, int j, double x0, double x1) {
    int n = self->resolution, first = self->first_pixel[j];
    int last = first + self->first_sample[j + 1] - self->first_sample[j];
    int i0 = (int)fmax(first, ceil((x0 + 1) * (0.5 * n) - 0.5));
    int i1 = (int)fmin(last, ceil((x1 + 1) * (0.5 * n) - 0.5));
    double y = pixel_at(j, n);
    for (int i = i0; i < i1; i++) {
        int s = self->first_sample[j] + i - first;
        double depth = fill->a * pixel_at(i, n) + fill->b * y + fill->c;
        int held = fill->item[s];
        bool nearer = depth < self->depth[s] || (depth == self->depth[s] && held >= 0 &&
                                                 fill->rank < form_factor_rank(&fill->view->faces[held]));
        if (!nearer) continue;
        self->depth[s] = depth;
        fill->item[s] = fill->face;
    }
}

// Eq. 5: the plane through three projected points, as depth over the disc. False where they lie on a line.
static bool depth_plane(const Vec3 v[3], Fill *fill) {
    Vec3 p[3];
    for (int i = 0; i < 3; i++) {
        double length = vec3_length(v[i]);
        p[i] = vec3(v[i].x / length, v[i].y / length, length);
    }
    Vec3 n = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
    if (n.z == 0) return false;
    fill->a = -n.x / n.z, fill->b = -n.y / n.z;
    fill->c = p[0].z - fill->a * p[0].x - fill->b * p[0].y;
    return true;
}

static void draw_triangle(Polyline *self, const Vec3 v[3], Fill *fill) {
    if (!depth_plane(v, fill)) return;
    self->point_count = 0;
    for (int i = 0; i < 3; i++) add_edge(self, v[i], v[i < 2 ? i + 1 : 0]);
    double low = 1, high = -1;
    for (int i = 0, last = self->point_count - 1; i < self->point_count; last = i++) {
        cross_lines(self, self->point[last], self->point[i]);
        low = fmin(low, self->point[i].y), high = fmax(high, self->point[i].y);
    }
    int n = self->resolution, first = (int)fmax(0, (low + 1) * (0.5 * n) - 1.5);
    for (int j = first; j < n && pixel_at(j, n) <= high; j++) {
        for (int k = 0; k + 1 < self->crossing_count[j]; k += 2)
            fill_pixels(self, fill, j, self->crossing[j][k], self->crossing[j][k + 1]);
        self->crossing_count[j] = 0;
    }
}

static void draw_element(Polyline *self, const Element *e, Fill *fill) {
    const View *view = fill->view;
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 p = vec3_sub(self->mesh->vertices[self->mesh->corners[e->first_corner + i]], view->eye);
        self->turned[i] = vec3(vec3_dot(view->x, p), vec3_dot(view->y, p), vec3_dot(view->z, p));
    }
    Plane horizon = {vec3(0, 0, 1), 0};
    int count = polygon_clip(self->turned, e->corner_count, horizon, 0, self->clipped);
    for (int i = 1; i + 1 < count; i++)
        draw_triangle(self, (Vec3[]){self->clipped[0], self->clipped[i], self->clipped[i + 1]}, fill);
}

static void polyline_items(void *context, const View *view, int32_t *item, FormFactorWork *work) {
    Polyline *self = context;
    for (int s = 0; s < self->samples.count; s++) {
        item[s] = -1;
        self->depth[s] = INFINITY;
    }
    for (int i = 0; i < view->face_count; i++) {
        const Face *face = &self->mesh->faces[view->faces[i].face];
        Fill fill = {.face = i, .rank = form_factor_rank(&view->faces[i]), .view = view, .item = item};
        for (int e = 0; e < face->element_count; e++)
            draw_element(self, &self->mesh->elements[face->first_element + e], &fill);
    }
    work->samples += self->samples.count;
}

const FormFactorMethod FORM_FACTOR_HEMISPHERE_POLYLINE = {
    .name = "hemisphere-polyline",
    .summary = "z-buffer on the hemisphere's base as printed (Doi & Itoh): chords, and a depth so wrong that "
               "culling shows",
    .truth = FORM_FACTOR_GUESS,
    .projective = true,
    .start = polyline_start,
    .samples = polyline_samples,
    .items = polyline_items,
};
