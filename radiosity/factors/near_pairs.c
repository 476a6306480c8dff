// near_pairs.c - form factors from an area instead of a point, for elements close by: the closed form from a point (Lambert 1760) is
// integrated over the patch by quadrature (Wallace, Elmquist & Haines 1989 have the two integrals the other way round).
//
// The visible share of an element is taken to be the same from everywhere on the patch: the row's form factor from the centre over
// the unoccluded one.
#include "radiosity/factors/near_pairs.h"

#include <math.h>

#include "engine/core/error.h"
#include "engine/core/lanes.h"
#include "engine/core/polygon.h"

// Elements with more corners than MOST_CORNERS are not corrected. MOST_POINTS is the most points of a patch.
enum { MOST_CORNERS = 128, MOST_POINTS = MESH_MOST_IN_PATCH + LANES };
// An element whose form factor from the centre is less than this is not corrected: it has too few samples to tell how much of it is
// hidden.
static const float LEAST = 1e-5f;
// Elements that are not near share the rest that near elements leave, if the rest was more than LEAST_REST before and changes by a
// factor of less than MOST_SCALE up or down.
static const double LEAST_REST = 1e-3, MOST_SCALE = 2;

// Two successive edges are one straight edge if the sine of the angle between them is below this.
static const double STRAIGHT = 1e-6;

// A ball around an element, metres from NearShapes.origin.
typedef struct Ball {
    float x, y, z, radius;
} Ball;

// Points of a patch in its own axes (z is the normal), metres from its centre; weights sum to 1. The first point is the centre, with
// weight 0.
typedef struct Points {
    int lane_count;
    Lane x[MOST_POINTS / LANES], y[MOST_POINTS / LANES], weight[MOST_POINTS / LANES];
} Points;

// The corrected share of a near element.
typedef struct Mended {
    int at;  // index in the row
    float factor;
} Mended;

struct NearShapes {
    Vec3 origin;
    Ball *balls;    // [element_count]
    int *first;     // [element_count + 1] in `corners`; an element with too many corners has none there
    int *vertex;    // of each, in Mesh.vertices
    Vec3 *corners;  // building space
};

struct NearPairs {
    const Mesh *mesh;
    const NearShapes *shapes;
    double reach;
    float *factor;   // [element_count] the corrected factors of the row
    Mended *mended;  // [element_count]
    Row row;
};

static Ball ball_of(Vec3 origin, const Mesh *mesh, const Element *e) {
    const int *corner = mesh->corners + e->first_corner;
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, vec3_sub(mesh->vertices[corner[i]], origin));
    Vec3 centre = vec3_scale(sum, 1.0 / e->corner_count);
    double radius = 0;
    for (int i = 0; i < e->corner_count; i++)
        radius = fmax(radius, vec3_length(vec3_sub(vec3_sub(mesh->vertices[corner[i]], origin), centre)));
    return (Ball){(float)centre.x, (float)centre.y, (float)centre.z, (float)radius};
}

// Removes the corners on straight edges of a convex polygon about the normal n, and their vertices; returns how many corners are left.
static int true_corners(Vec3 *v, int *vertex, int count, Vec3 n) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        Vec3 before = v[kept > 0 ? kept - 1 : count - 1], after = v[i + 1 < count ? i + 1 : 0];
        Vec3 a = vec3_sub(v[i], before), b = vec3_sub(after, v[i]);
        if (!(vec3_dot(n, vec3_cross(a, b)) > STRAIGHT * vec3_length(a) * vec3_length(b))) continue;
        vertex[kept] = vertex[i];
        v[kept++] = v[i];
    }
    return kept;
}

NearShapes *near_shapes(const Mesh *mesh, Arena *arena) {
    NearShapes *shapes = ARENA_ARRAY(arena, NearShapes, 1);
    shapes->origin = mesh->vertices[0];
    shapes->balls = ARENA_ARRAY(arena, Ball, mesh->element_count);
    shapes->first = ARENA_ARRAY(arena, int, mesh->element_count + 1);
    shapes->vertex = ARENA_ARRAY(arena, int, mesh->corner_count);
    shapes->corners = ARENA_ARRAY(arena, Vec3, mesh->corner_count);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        Vec3 *v = shapes->corners + shapes->first[e];
        int *vertex = shapes->vertex + shapes->first[e];
        for (int i = 0; i < element->corner_count; i++)
            v[i] = mesh->vertices[vertex[i] = mesh->corners[element->first_corner + i]];
        shapes->balls[e] = ball_of(shapes->origin, mesh, element);
        int kept = true_corners(v, vertex, element->corner_count, mesh->faces[element->face].plane.n);
        shapes->first[e + 1] = shapes->first[e] + (kept <= MOST_CORNERS ? kept : 0);
    }
    return shapes;
}

void near_shapes_pose(NearShapes *shapes, const Mesh *mesh) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        if (mesh->graph->objects[face->object].leaf < 0) continue;
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            int count = shapes->first[e + 1] - shapes->first[e];
            Vec3 *v = shapes->corners + shapes->first[e];
            const int *vertex = shapes->vertex + shapes->first[e];
            for (int i = 0; i < count; i++) v[i] = mesh->vertices[vertex[i]];
            shapes->balls[e] = ball_of(shapes->origin, mesh, &mesh->elements[e]);
        }
    }
}

NearPairs *near_pairs_new(const Mesh *mesh, const NearShapes *shapes, double reach, Arena *arena) {
    NearPairs *self = ARENA_ARRAY(arena, NearPairs, 1);
    *self = (NearPairs){.mesh = mesh, .shapes = shapes, .reach = reach};
    self->factor = ARENA_ARRAY(arena, float, mesh->element_count);
    self->mended = ARENA_ARRAY(arena, Mended, mesh->element_count);
    return self;
}

// ---- points of a patch

typedef struct Axes {
    Vec3 centre, x, y, z;
} Axes;

static Vec3 to_axes(const Axes *a, Vec3 v) {
    v = vec3_sub(v, a->centre);
    return vec3(vec3_dot(a->x, v), vec3_dot(a->y, v), vec3_dot(a->z, v));
}

typedef struct PointList {
    float x[MOST_POINTS], y[MOST_POINTS], weight[MOST_POINTS];
    int count;
} PointList;

static void add_point(PointList *list, double x, double y, double weight) {
    CORE_ASSERT(list->count < MOST_POINTS);
    list->x[list->count] = (float)x;
    list->y[list->count] = (float)y;
    list->weight[list->count++] = (float)weight;
}

// Adds Gauss-Legendre points, two by two, for each of `parts` by `parts` parts of a quadrilateral; a triangle is a quadrilateral
// with two corners in one place.
static void add_quad(PointList *list, const Vec3 q[4], int parts) {
    static const double at[2] = {0.21132486540518713, 0.78867513459481287};
    for (int i = 0; i < 2 * parts; i++) {
        for (int j = 0; j < 2 * parts; j++) {
            double u = (i / 2 + at[i % 2]) / parts, v = (j / 2 + at[j % 2]) / parts;
            Vec3 low = vec3_lerp(q[0], q[1], u), high = vec3_lerp(q[3], q[2], u);
            Vec3 along = vec3_lerp(vec3_sub(q[1], q[0]), vec3_sub(q[2], q[3]), v), up = vec3_sub(high, low);
            Vec3 p = vec3_lerp(low, high, v);
            double area = along.x * up.y - along.y * up.x;
            if (area > 0) add_point(list, p.x, p.y, area);
        }
    }
}

// The corners of an element in a patch's axes; returns their number, 0 where there are too many.
static int corners_of(const NearShapes *shapes, const Axes *axes, int element, Vec3 v[MOST_CORNERS]) {
    const Vec3 *from = shapes->corners + shapes->first[element];
    int count = shapes->first[element + 1] - shapes->first[element];
    for (int i = 0; i < count; i++) v[i] = to_axes(axes, from[i]);
    return count;
}

static void add_element_points(PointList *list, const Vec3 *v, int count, int parts) {
    for (int i = 1; i + 1 < count; i += 2) {
        Vec3 last = v[i + 2 < count ? i + 2 : i + 1];
        Vec3 quad[4] = {v[0], v[i], v[i + 1], last};
        add_quad(list, quad, parts);
    }
}

// Adds one point for a whole element: for patches with so many elements that each is small.
static void add_middle(PointList *list, const Vec3 *v, int count, double area) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < count; i++) sum = vec3_add(sum, v[i]);
    if (count > 0) add_point(list, sum.x / count, sum.y / count, area);
}

// The least number of points on a patch, and on a patch that emits light: lamps are few, and the elements close to a lamp are the
// brightest of all.
enum { LEAST_POINTS = 8, LEAST_LAMP_POINTS = 144 };

static bool lay_points(const NearPairs *self, const Patch *patch, const Axes *axes, Points *out) {
    const Mesh *mesh = self->mesh;
    const NearShapes *shapes = self->shapes;
    PointList list = {.count = 0};
    int points = 1;
    Vec3 v[MOST_CORNERS];
    add_point(&list, 0, 0, 0);
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
        points += 4 * ((shapes->first[e + 1] - shapes->first[e] - 1) / 2);
    int least = mesh_is_lamp(mesh, patch->face) ? LEAST_LAMP_POINTS : LEAST_POINTS, parts = 1;
    while (points > 1 && (points - 1) * parts * parts < least &&
           (points - 1) * (parts + 1) * (parts + 1) < MOST_POINTS)
        parts++;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        int count = corners_of(shapes, axes, e, v);
        if (points > MOST_POINTS)
            add_middle(&list, v, count, mesh->elements[e].area);
        else
            add_element_points(&list, v, count, parts);
    }
    float sum = 0;
    for (int i = 0; i < list.count; i++) sum += list.weight[i];
    if (!(sum > 0)) return false;
    out->lane_count = (list.count + LANES - 1) / LANES;
    for (int i = 0; i < out->lane_count * LANES; i++) {
        bool there = i < list.count;
        out->x[i / LANES][i % LANES] = there ? list.x[i] : 0;
        out->y[i / LANES][i % LANES] = there ? list.y[i] : 0;
        out->weight[i / LANES][i % LANES] = there ? list.weight[i] / sum : 0;
    }
    return true;
}

// ---- an element seen from the points

// The angle, 0 .. pi, of a sine above 0 and a cosine that are scaled by the same factor: within 2e-6 (an odd minimax polynomial of
// atan up to the 11th power).
static inline Lane angle_of(Lane sine, Lane cosine) {
    Lane adjacent = lane_abs(cosine), most = lane_most(sine, adjacent);
    Lane t = lane_least(sine, adjacent) / most, s = t * t;
    Lane a = lane_of(-0.0117212f);
    a = lane_multiply_add(a, s, lane_of(0.05265332f));
    a = lane_multiply_add(a, s, lane_of(-0.11643287f));
    a = lane_multiply_add(a, s, lane_of(0.19354346f));
    a = lane_multiply_add(a, s, lane_of(-0.33262347f));
    a = lane_multiply_add(a, s, lane_of(0.99997726f)) * t;
    a = lane_choose(sine > adjacent, lane_of((float)M_PI_2) - a, a);
    return lane_choose(cosine < 0, lane_of((float)M_PI) - a, a);
}

// The term of Lambert's formula for one edge, seen from eight points.
static inline Lane edge_share(Lane x, Lane y, const float a[3], const float b[3]) {
    Lane ax = lane_of(a[0]) - x, ay = lane_of(a[1]) - y, az = lane_of(a[2]);
    Lane bx = lane_of(b[0]) - x, by = lane_of(b[1]) - y, bz = lane_of(b[2]);
    Lane cx = ay * bz - az * by, cy = az * bx - ax * bz, cz = ax * by - ay * bx;
    Lane sine = lane_root(cx * cx + cy * cy + cz * cz) + 1e-20f;
    return angle_of(sine, ax * bx + ay * by + az * bz) * cz / sine;
}

// An element's unoccluded form factor from the patch's centre, and its mean over the patch.
static void factors(const Points *points, const float (*v)[3], int count, float *centre, float *mean) {
    *centre = *mean = 0;
    Lane sum = {0};
    for (int k = 0; k < points->lane_count; k++) {
        Lane angle = {0};
        for (int i = 0; i < count; i++)
            angle += edge_share(points->x[k], points->y[k], v[i], v[i + 1 < count ? i + 1 : 0]);
        if (k == 0) *centre = fabsf(angle[0]);
        sum += lane_abs(angle) * points->weight[k];
    }
    *mean = 0;
    for (int i = 0; i < LANES; i++) *mean += sum[i];
    *mean *= (float)(0.5 / M_PI);
    *centre *= (float)(0.5 / M_PI);
}

// The part of an element in front of the patch, in the patch's axes; returns how many corners it has.
static int corners_before(const NearPairs *self, const Axes *axes, int element, float out[][3]) {
    Vec3 v[MOST_CORNERS], part[MOST_CORNERS + 1];
    int count = corners_of(self->shapes, axes, element, v);
    count = polygon_clip(v, count, (Plane){vec3(0, 0, 1), 0}, 0, part);
    for (int i = 0; i < count; i++) {
        out[i][0] = (float)part[i].x;
        out[i][1] = (float)part[i].y;
        out[i][2] = (float)part[i].z;
    }
    return count;
}

static inline bool is_near(const Ball *b, Vec3 centre, float reach) {
    float x = b->x - (float)centre.x, y = b->y - (float)centre.y, z = b->z - (float)centre.z;
    float within = reach + b->radius;
    return x * x + y * y + z * z < within * within;
}

static double radius_of(const NearPairs *self, const Patch *patch, Vec3 centre) {
    double radius = 0;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        const Ball *b = &self->shapes->balls[e];
        Vec3 off = vec3_sub(vec3((double)b->x, (double)b->y, (double)b->z), centre);
        radius = fmax(radius, vec3_length(off) + (double)b->radius);
    }
    return radius;
}

// An element's share of the light from the whole patch, given `share`, its share of the light from the centre.
static float mend(const NearPairs *self, const Axes *axes, const Points *points, int element, float share) {
    float v[MOST_CORNERS + 1][3], centre, mean;
    int count = corners_before(self, axes, element, v);
    if (count < 3) return share;
    factors(points, (const float(*)[3])v, count, &centre, &mean);
    if (centre < LEAST) return share;
    return fmaxf(share + fminf(share / centre, 1) * (mean - centre), 0);
}

const Row *near_pairs_row(NearPairs *self, int index, const Row *row) {
    const Mesh *mesh = self->mesh;
    const Ball *balls = self->shapes->balls;
    const Patch *patch = &mesh->patches[index];
    Axes axes = {.centre = patch->centre, .z = mesh->faces[patch->face].plane.n};
    view_axes(axes.z, &axes.x, &axes.y);
    Points points;
    bool laid = false;
    Vec3 centre = vec3_sub(patch->centre, self->shapes->origin);
    float reach = (float)(self->reach * radius_of(self, patch, centre));
    double before_all = 0, after_all = 0;
    int count = 0;
    for (int i = 0; i < row->count; i++) {
        if (!is_near(&balls[row->element[i]], centre, reach)) continue;
        if (!laid && !lay_points(self, patch, &axes, &points)) return row;
        laid = true;
        float factor = mend(self, &axes, &points, row->element[i], row->factor[i]);
        self->mended[count++] = (Mended){i, factor};
        before_all += (double)row->factor[i];
        after_all += (double)factor;
    }
    if (count == 0) return row;
    double rest = 1 - before_all, scale = (1 - after_all) / rest, all = 1;
    // Where near elements fill nearly the whole view and are partly hidden from the patch, too little is known of the rest to scale it
    // alone: all shares are scaled alike.
    if (!(rest > LEAST_REST && scale > 1 / MOST_SCALE && scale < MOST_SCALE)) {
        scale = all = 1 / (after_all + fmax(rest, 0));
    }
    for (int i = 0; i < row->count; i++) self->factor[i] = row->factor[i] * (float)scale;
    for (int i = 0; i < count; i++) self->factor[self->mended[i].at] = self->mended[i].factor * (float)all;
    self->row = (Row){.count = row->count,
                      .element = row->element,
                      .factor = self->factor,
                      .back = row->back * scale,
                      .escaped = row->escaped * scale,
                      .sky = row->sky * scale,
                      .sky_light = row->sky_light * scale,
                      .ground_light = row->ground_light * scale,
                      .sky_part = row->sky_part,
                      .sky_part_count = row->sky_part_count};
    return &self->row;
}
