// element_buffer.c - a depth buffer of elements on each side of a hemicube (M. F. Cohen & D. P. Greenberg, The Hemi-Cube,
// 1985), or on the base of a hemisphere (Doi & Itoh: corners go to the unit sphere and straight down; edges that span more
// than a degree are cut).
//
// Departure from Doi & Itoh: depth is computed exactly from the element's plane; their eq. (5) interpolates linearly a depth that is
// not linear.
#include "radiosity/factors/element_buffer.h"

#include <string.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"

// An element whose plane is nearer to the eye than this is edge-on, metres.
static const double EDGE_ON = 1e-9;
// Parts nearer than this along `ahead` are cut off, metres, to avoid a division by zero.
static const double NEAR = 1e-7;
// An edge on the disc is cut into parts that span no more than this, radians: Doi & Itoh's degree.
static const double EDGE_SPAN = 3.14159265358979323846 / 180;
enum { MOST_CORNERS = 1024, MOST_CUTS = 64 };

typedef struct Side {
    Vec3 right, up, ahead;  // building space
    double low;             // least up / ahead: -1 on top, 0 on the sides, which end at the horizon
    int width, height;
    int32_t *item;  // [height * width] elements
    float *near;    // [height * width] 1 / distance along `ahead`, on the disc 1 / distance; 0: nothing
    float *weight;  // [height * width] sums to 1 over all sides
} Side;

struct ElementBuffer {
    const Mesh *mesh;
    int kind;  // ELEMENT_HEMICUBE, ELEMENT_HEMISPHERE
    Vec3 eye;
    int side_count;
    Side side[ELEMENT_MOST_SIDES];
    float *lift;  // [height * width] of the disc: z of the direction
};

static void weigh(ElementBuffer *self) {
    double total = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int s = 0; s < self->side_count; s++) {
            Side *side = &self->side[s];
            for (int k = 0; k < side->width * side->height; k++) {
                double u = 2 * (k % side->width + 0.5) / side->width - 1;
                double v = side->low + (1 - side->low) * (k / side->width + 0.5) / side->height;
                double r2 = u * u + v * v, w = s == 0 ? 1 / ((r2 + 1) * (r2 + 1)) : v / ((r2 + 1) * (r2 + 1));
                if (self->kind == ELEMENT_HEMISPHERE) {
                    w = r2 < 1 ? 1 : 0;
                    self->lift[k] = (float)sqrt(r2 < 1 ? 1 - r2 : 0);
                }
                if (pass == 0)
                    total += w;
                else
                    side->weight[k] = (float)(w / total);
            }
        }
    }
}

ElementBuffer *element_buffer_new(const Mesh *mesh, int kind, int resolution, Arena *arena) {
    ElementBuffer *self = ARENA_ARRAY(arena, ElementBuffer, 1);
    self->mesh = mesh;
    self->kind = kind;
    self->side_count = kind == ELEMENT_HEMICUBE ? 5 : 1;
    for (int s = 0; s < self->side_count; s++) {
        Side *side = &self->side[s];
        side->width = resolution;
        side->height = s == 0 ? resolution : resolution / 2;
        side->low = s == 0 ? -1 : 0;
        int count = side->width * side->height;
        side->item = ARENA_ARRAY(arena, int32_t, count);
        side->near = ARENA_ARRAY(arena, float, count);
        side->weight = ARENA_ARRAY(arena, float, count);
    }
    self->lift = ARENA_ARRAY(arena, float, resolution *resolution);
    weigh(self);
    return self;
}

int element_buffer_sides(const ElementBuffer *self) { return self->side_count; }

void element_buffer_start(ElementBuffer *self, const ViewPoint *from) {
    Vec3 x, y, z = from->normal;
    view_axes(z, &x, &y);
    self->eye = from->eye;
    const Vec3 ahead[ELEMENT_MOST_SIDES] = {z, x, y, vec3_scale(x, -1), vec3_scale(y, -1)};
    for (int s = 0; s < self->side_count; s++) {
        Side *side = &self->side[s];
        side->ahead = ahead[s];
        side->up = s == 0 ? y : z;
        side->right = s == 0 ? x : vec3_cross(ahead[s], z);
        memset(side->near, 0, (size_t)(side->width * side->height) * sizeof *side->near);
        for (int k = 0; k < side->width * side->height; k++) side->item[k] = -1;
    }
}

int element_buffer_frustum(const ElementBuffer *self, int s, Plane out[4]) {
    if (self->kind == ELEMENT_HEMISPHERE) return 0;
    const Side *side = &self->side[s];
    const Vec3 n[4] = {vec3_add(side->ahead, side->right), vec3_sub(side->ahead, side->right),
                       side->low < 0 ? vec3_add(side->ahead, side->up) : side->up,
                       vec3_sub(side->ahead, side->up)};
    for (int i = 0; i < 4; i++) {
        out[i].n = vec3_normalize(n[i]);
        out[i].d = vec3_dot(out[i].n, self->eye);
    }
    return 4;
}

// ---- drawing

typedef struct Shape {
    int element, count;
    double x[MOST_CORNERS], y[MOST_CORNERS];  // pixels
    double near_u, near_v, near_ahead;        // 1 / distance is the dot product of these with the direction
} Shape;

static void put_element(const ElementBuffer *self, Side *side, const Shape *shape, int i, int j) {
    int k = j * side->width + i;
    double u = 2 * (i + 0.5) / side->width - 1, v = side->low + (1 - side->low) * (j + 0.5) / side->height;
    double ahead = 1;
    if (self->kind == ELEMENT_HEMISPHERE) ahead = (double)self->lift[k];
    float near = (float)(u * shape->near_u + v * shape->near_v + ahead * shape->near_ahead);
    if (near <= side->near[k]) return;
    side->near[k] = near;
    side->item[k] = shape->element;
}

// Fills the pixels whose centres are inside the shape, row by row, between pairs of crossings.
static void fill_shape(const ElementBuffer *self, Side *side, const Shape *shape) {
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < shape->count; i++) {
        low = fmin(low, shape->y[i]);
        high = fmax(high, shape->y[i]);
    }
    int from = (int)ceil(fmax(low, 0) - 0.5), to = (int)ceil(fmin(high, side->height) - 0.5);
    if (from < 0) from = 0;
    for (int j = from; j < to && j < side->height; j++) {
        double at[16], y = j + 0.5;
        int count = 0;
        for (int i = 0; i < shape->count && count < 16; i++) {
            int k = i + 1 == shape->count ? 0 : i + 1;
            if ((shape->y[i] <= y) == (shape->y[k] <= y)) continue;
            double t = (y - shape->y[i]) / (shape->y[k] - shape->y[i]);
            double x = shape->x[i] + t * (shape->x[k] - shape->x[i]);
            int place = count++;
            for (; place > 0 && at[place - 1] > x; place--) at[place] = at[place - 1];
            at[place] = x;
        }
        for (int c = 0; c + 1 < count; c += 2) {
            int first = (int)ceil(fmax(at[c], 0) - 0.5);
            int end = (int)ceil(fmin(at[c + 1], side->width) - 0.5);
            for (int i = first < 0 ? 0 : first; i < end; i++) put_element(self, side, shape, i, j);
        }
    }
}

// Clips a polygon to dot(n, v) >= least; returns the count of corners. Cheap where the whole polygon is on one side.
static int keep(Vec3 *v, int count, Vec3 n, double least) {
    int inside = 0;
    for (int i = 0; i < count; i++) inside += vec3_dot(n, v[i]) >= least;
    if (inside == count || inside == 0) return inside;
    Vec3 out[MOST_CORNERS];
    count = polygon_clip(v, count, (Plane){n, least}, 0, out);
    memcpy(v, out, (size_t)count * sizeof *v);
    return count;
}

// Clips a polygon, in axes right, up, ahead, at the side's view volume, projects and fills it.
static void draw_on_side(const ElementBuffer *self, Side *side, Vec3 *v, int count, Shape *shape) {
    count = keep(v, count, vec3(0, 0, 1), NEAR);
    if (count) count = keep(v, count, vec3(1, 0, 1), 0);
    if (count) count = keep(v, count, vec3(-1, 0, 1), 0);
    if (count) count = keep(v, count, vec3(0, 1, side->low < 0 ? 1 : 0), 0);
    if (count) count = keep(v, count, vec3(0, -1, 1), 0);
    if (count < 3) return;
    shape->count = count;
    for (int i = 0; i < count; i++) {
        double scale = 1 / v[i].z;
        shape->x[i] = (v[i].x * scale + 1) * 0.5 * side->width;
        shape->y[i] = (v[i].y * scale - side->low) / (1 - side->low) * side->height;
    }
    fill_shape(self, side, shape);
}

static void draw_on_disc(const ElementBuffer *self, Side *side, Vec3 *v, int count, Shape *shape) {
    count = keep(v, count, vec3(0, 0, 1), NEAR);
    if (count < 3) return;
    for (int i = 0; i < count; i++) v[i] = vec3_normalize(v[i]);
    shape->count = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = v[i], b = v[i + 1 == count ? 0 : i + 1];
        // The chord stands for the arc: for arcs as short as EDGE_SPAN their lengths are nearly equal.
        Vec3 chord = vec3_sub(b, a);
        double span2 = vec3_dot(chord, chord);
        int cuts = span2 <= EDGE_SPAN * EDGE_SPAN ? 1 : (int)fmin(MOST_CUTS, ceil(sqrt(span2) / EDGE_SPAN));
        for (int k = 0; k < cuts && shape->count < MOST_CORNERS; k++) {
            Vec3 p = k == 0 ? a : vec3_normalize(vec3_lerp(a, b, (double)k / cuts));
            shape->x[shape->count] = (p.x + 1) * 0.5 * side->width;
            shape->y[shape->count++] = (p.y + 1) * 0.5 * side->height;
        }
    }
    fill_shape(self, side, shape);
}

static void draw_element(ElementBuffer *self, Side *side, int element, Vec3 near) {
    const Mesh *mesh = self->mesh;
    const Element *e = &mesh->elements[element];
    Vec3 v[MOST_CORNERS];
    CORE_ASSERT(e->corner_count + 8 < MOST_CORNERS);
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 p = vec3_sub(mesh->vertices[mesh->corners[e->first_corner + i]], self->eye);
        v[i] = vec3(vec3_dot(side->right, p), vec3_dot(side->up, p), vec3_dot(side->ahead, p));
    }
    Shape shape;
    shape.element = element;
    shape.near_u = near.x, shape.near_v = near.y, shape.near_ahead = near.z;
    if (self->kind == ELEMENT_HEMICUBE)
        draw_on_side(self, side, v, e->corner_count, &shape);
    else
        draw_on_disc(self, side, v, e->corner_count, &shape);
}

long long element_buffer_draw(ElementBuffer *self, int s, const int *faces, int face_count) {
    Side *side = &self->side[s];
    long long drawn = 0;
    for (int k = 0; k < face_count; k++) {
        const Face *face = &self->mesh->faces[faces[k]];
        drawn += face->element_count;
        double d = vec3_dot(face->plane.n, vec3_sub(face->origin, self->eye));
        if (fabs(d) < EDGE_ON) continue;
        Vec3 n = vec3_scale(face->plane.n, 1 / d);
        Vec3 near = {vec3_dot(n, side->right), vec3_dot(n, side->up), vec3_dot(n, side->ahead)};
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            draw_element(self, side, e, near);
    }
    return drawn;
}

void element_buffer_sum(const ElementBuffer *self, RowSum *sum) {
    for (int s = 0; s < self->side_count; s++) {
        const Side *side = &self->side[s];
        for (int k = 0; k < side->width * side->height; k++) {
            double weight = (double)side->weight[k];
            int element = side->item[k];
            if (element < 0) {
                sum->escaped += weight;
                continue;
            }
            const Face *face = &self->mesh->faces[self->mesh->elements[element].face];
            if (vec3_dot(face->plane.n, vec3_sub(self->eye, face->origin)) > 0)
                row_add(sum, element, weight);
            else
                sum->back += weight;
        }
    }
}
