// bench_breaks.c - where form-factor methods break: their error against how small an element is, how near a wall, how
// coarsely edges are cut, how far from the origin the building stands. Exact answers are the analytic method's.
//
// Each figure is the root mean square over scenes turned every way about the eye's normal, so that none is aligned with a
// method's pixels or lines.
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/core/error.h"
#include "engine/core/random.h"
#include "radiosity/factors/analytic.h"
#include "radiosity/factors/view.h"

enum { PLAIN_QUADS = 64 };

// Each quad is a face of one element. The pointers of `mesh` and `view` lead into the scene itself: it stays where it is.
typedef struct PlainScene {
    Mesh mesh;
    View view;
    Face faces[PLAIN_QUADS];
    Element elements[PLAIN_QUADS];
    Patch patches[PLAIN_QUADS];
    Vec3 vertices[4 * PLAIN_QUADS], seen[4 * PLAIN_QUADS];
    int outline[4 * PLAIN_QUADS], squares[PLAIN_QUADS];
    ViewFace view_faces[PLAIN_QUADS];
} PlainScene;

// Metres: a plane so near holds the eye.
#define PLAIN_ON_PLANE 1e-9

static PlainScene *plain_scene_new(Arena *arena) {
    PlainScene *s = ARENA_ARRAY(arena, PlainScene, 1);
    s->mesh = (Mesh){.faces = s->faces,
                     .elements = s->elements,
                     .patches = s->patches,
                     .vertices = s->vertices,
                     .outline = s->outline,
                     .corners = s->outline,
                     .squares = s->squares};
    s->view = (View){.faces = s->view_faces, .vertices = s->seen};
    return s;
}

static int vertex_of(PlainScene *s, Vec3 p) {
    for (int i = 0; i < s->mesh.vertex_count; i++)
        if (vec3_equal(s->vertices[i], p)) return i;
    s->vertices[s->mesh.vertex_count] = p;
    return s->mesh.vertex_count++;
}

// Counter-clockwise from its front.
static void plain_scene_add(PlainScene *s, const Vec3 corner[4]) {
    int i = s->mesh.face_count;
    CORE_ASSERT(i < PLAIN_QUADS);
    for (int k = 0; k < 4; k++) s->outline[4 * i + k] = vertex_of(s, corner[k]);
    double area = polygon_area(corner, 4);
    s->faces[i] = (Face){.polygon = -1,
                         .object = -1,
                         .plane = plane_of_polygon(corner, 4),
                         .first_vertex = 4 * i,
                         .vertex_count = 4,
                         .origin = corner[0],
                         .nx = 1,
                         .ny = 1,
                         .first_square = i,
                         .first_element = i,
                         .element_count = 1,
                         .first_patch = i,
                         .patch_count = 1};
    s->elements[i] = (Element){.face = i, .patch = i, .first_corner = 4 * i, .corner_count = 4, .area = area};
    s->patches[i] = (Patch){.face = i, .first_element = i, .element_count = 1, .cell = -1, .area = area};
    s->squares[i] = i;
    s->mesh.face_count = s->mesh.element_count = s->mesh.patch_count = s->mesh.square_count = i + 1;
    s->mesh.outline_count = s->mesh.corner_count = 4 * i + 4;
}

static Vec3 turned(const View *view, Vec3 v) {
    return vec3(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
}

static double nearest_corner(const View *view, const ViewFace *face) {
    double nearest = INFINITY;
    for (int k = 0; k < 4; k++) nearest = fmin(nearest, vec3_length(view->vertices[face->first_vertex + k]));
    return nearest;
}

static void see(PlainScene *s, int face) {
    View *view = &s->view;
    const Face *from = &s->faces[face];
    Vec3 first = vec3_sub(s->vertices[s->outline[from->first_vertex]], view->eye);
    ViewFace seen = {.face = face,
                     .first_vertex = from->first_vertex,
                     .vertex_count = 4,
                     .n = turned(view, from->plane.n),
                     .d = vec3_dot(from->plane.n, first)};
    double top = 0;
    for (int k = 0; k < 4; k++) {
        Vec3 p = turned(view, vec3_sub(s->vertices[s->outline[seen.first_vertex + k]], view->eye));
        s->seen[seen.first_vertex + k] = p;
        top = fmax(top, p.z);
    }
    if (top <= 0 || fabs(seen.d) < PLAIN_ON_PLANE) return;
    int at = view->face_count++;
    double nearest = nearest_corner(view, &seen);
    for (; at > 0 && nearest_corner(view, &view->faces[at - 1]) > nearest; at--)
        view->faces[at] = view->faces[at - 1];
    view->faces[at] = seen;
}

// The quads that a point with a normal sees, near to far.
static const View *plain_scene_look(PlainScene *s, Vec3 eye, Vec3 normal) {
    View *view = &s->view;
    view->eye = eye;
    view->z = vec3_normalize(normal);
    view_axes(view->z, &view->x, &view->y);
    view->face_count = 0;
    view->vertex_count = s->mesh.outline_count;
    for (int i = 0; i < s->mesh.face_count; i++) see(s, i);
    return view;
}

enum { TURNS = 40 };

static Vec3 spun(Vec3 p, double angle) {
    return vec3(cos(angle) * p.x - sin(angle) * p.y, sin(angle) * p.x + cos(angle) * p.y, p.z);
}

static void add_turned(PlainScene *scene, const Vec3 quad[4], double angle, Vec3 shift) {
    Vec3 v[4];
    for (int k = 0; k < 4; k++) v[k] = vec3_add(spun(quad[k], angle), shift);
    plain_scene_add(scene, v);
}

// A horizontal square that looks down at the origin.
static void add_level_square(PlainScene *scene, double half, double height, double angle, Vec3 shift) {
    const Vec3 v[4] = {
        {-half, -half, height}, {-half, half, height}, {half, half, height}, {half, -half, height}};
    add_turned(scene, v, angle, shift);
}

// Error of the share of face 0, from the origin about z, as a share of it where `relative`.
static double share_error(const FormFactorMethod *method, const FormFactorOptions *options, PlainScene *scene,
                          bool relative) {
    Arena arena = {0};
    const View *view = plain_scene_look(scene, vec3(0, 0, 0), vec3(0, 0, 1));
    double exact = analytic_point(scene->seen, 4);
    FormFactor *maker = form_factor_new(method, &scene->mesh, options, &arena);
    const Row *row = form_factor_row(maker, view);
    double share = 0;
    for (int i = 0; i < row->count; i++) share += row->element[i] == 0 ? (double)row->factor[i] : 0;
    form_factor_end(maker);
    arena_free(&arena);
    return (share - exact) / (relative ? exact : 1);
}

typedef double BreakScene(const FormFactorMethod *method, const FormFactorOptions *options, double x,
                          Random *random);

// A square of x by x pixels, anywhere near the zenith: relative error.
static double small_square(const FormFactorMethod *method, const FormFactorOptions *options, double x,
                           Random *random) {
    Arena arena = {0};
    PlainScene *scene = plain_scene_new(&arena);
    Vec3 shift = vec3(random_between(random, -.1, .1), random_between(random, -.1, .1), 0);
    add_level_square(scene, x / options->resolution, 1, random_between(random, 0, 2 * M_PI), shift);
    double error = share_error(method, options, scene, true);
    arena_free(&arena);
    return error;
}

// A 1 x 1 m wall x metres from the eye at its foot.
static double near_wall(const FormFactorMethod *method, const FormFactorOptions *options, double x,
                        Random *random) {
    Arena arena = {0};
    PlainScene *scene = plain_scene_new(&arena);
    const Vec3 wall[4] = {{x, -.5, 0}, {x, -.5, 1}, {x, .5, 1}, {x, .5, 0}};
    add_turned(scene, wall, random_between(random, 0, 2 * M_PI), vec3(0, 0, 0));
    double error = share_error(method, options, scene, false);
    arena_free(&arena);
    return error;
}

// A unit square at 1 m, edges cut until they span less than x degrees: relative error.
static double coarse_edges(const FormFactorMethod *method, const FormFactorOptions *options, double x,
                           Random *random) {
    Arena arena = {0};
    FormFactorOptions coarse = *options;
    coarse.edge_threshold = x * M_PI / 180;
    PlainScene *scene = plain_scene_new(&arena);
    add_level_square(scene, 0.5, 1, random_between(random, 0, 2 * M_PI), vec3(0, 0, 0));
    double error = share_error(method, &coarse, scene, true);
    arena_free(&arena);
    return error;
}

static void add_room_box(PlainScene *scene, Vec3 low, Vec3 high, bool inwards, double angle, Vec3 shift) {
    const double at[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
    for (int side = 0; side < 6; side++) {
        int axis = side % 3, end = side / 3;
        Vec3 v[4];
        for (int k = 0; k < 4; k++) {
            double p[3];
            p[axis] = at[end][axis];
            p[(axis + 1) % 3] = at[k == 1 || k == 2][(axis + 1) % 3];
            p[(axis + 2) % 3] = at[k >= 2][(axis + 2) % 3];
            // Corners 0, 1, 2, 3 go round the axis's own direction; the other way round where they must face against it.
            v[(end == 1) == inwards ? 3 - k : k] = vec3(p[0], p[1], p[2]);
        }
        add_turned(scene, v, angle, shift);
    }
}

// The rows of a room at the origin and x metres away from it: L1.
static double far_away(const FormFactorMethod *method, const FormFactorOptions *options, double x,
                       Random *random) {
    double angle = random_between(random, 0, 2 * M_PI), factor[2][PLAIN_QUADS] = {{0}}, l1 = 0;
    for (int i = 0; i < 2; i++) {
        Arena arena = {0};
        PlainScene *scene = plain_scene_new(&arena);
        Vec3 shift = vec3_scale(vec3(0.64, -0.48, 0.6), i * x);
        add_room_box(scene, vec3(-1, -1.3, 0), vec3(2.5, 1.7, 2.5), true, angle, shift);
        add_room_box(scene, vec3(0.5, 0.3, 0.7), vec3(1.2, 0.9, 1.1), false, angle, shift);
        add_room_box(scene, vec3(-0.8, -0.9, 0.1), vec3(-0.3, -0.2, 1.9), false, angle, shift);
        FormFactor *maker = form_factor_new(method, &scene->mesh, options, &arena);
        const Row *row = form_factor_row(maker, plain_scene_look(scene, shift, vec3(0, 0, 1)));
        for (int k = 0; k < row->count; k++) factor[i][row->element[k]] = (double)row->factor[k];
        form_factor_end(maker);
        arena_free(&arena);
    }
    for (int k = 0; k < PLAIN_QUADS; k++) l1 += fabs(factor[1][k] - factor[0][k]);
    return l1;
}

static const struct {
    const char *name;  // in the CSV
    BreakScene *scene;
    double from, to;  // of x
    int steps;        // even in its logarithm
    int resolution;
} BREAKS[] = {
    {"pixels", small_square, 0.25, 16, 13, 100},
    {"wall", near_wall, 1e-3, 1, 13, 200},
    {"threshold", coarse_edges, 0.5, 180, 12, 200},
    {"origin", far_away, 1, 1e12, 13, 100},
};

static double error_at(BreakScene *scene, const FormFactorMethod *method, const FormFactorOptions *options,
                       double x, uint64_t seed) {
    Random random = {seed};
    double square = 0;
    for (int i = 0; i < TURNS; i++) {
        double error = scene(method, options, x, &random);
        square += error * error;
    }
    return sqrt(square / TURNS);
}

static bool measure_breaks(const BenchArguments *arguments, Error *error) {
    (void)error;
    FormFactorOptions options = form_factor_default_options();
    printf("break,method,resolution,x,error\n");
    for (size_t b = 0; b < sizeof BREAKS / sizeof *BREAKS; b++) {
        options.resolution = BREAKS[b].resolution;
        for (int m = 0; FORM_FACTOR_METHODS[m]; m++)
            for (int i = 0; i < BREAKS[b].steps; i++) {
                double x = BREAKS[b].from * pow(BREAKS[b].to / BREAKS[b].from, i / (BREAKS[b].steps - 1.0));
                double rms = error_at(BREAKS[b].scene, FORM_FACTOR_METHODS[m], &options, x, arguments->seed);
                printf("%s,%s,%d,%.6g,%.6g\n", BREAKS[b].name, FORM_FACTOR_METHODS[m]->name,
                       options.resolution, x, rms);
                fflush(stdout);
            }
    }
    return true;
}

static const Option ROWS[] = {
    BENCH_SEED("of their turns"),
};

const Bench BENCH_BREAKS = {
    .name = "breaks",
    .about =
        "where each form-factor method breaks: error against the size of an element in pixels, the distance "
        "of a wall, the threshold of polylines, the distance from the origin; in scenes of its own",
    BENCH_OPTIONS(ROWS),
    .run = measure_breaks,
};
