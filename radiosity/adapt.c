// adapt.c - meshes by what light does on them (Cohen, Greenberg, Immel & Brock 1986: adaptive subdivision).
//
// A first, rough solution tells how fast reflected light changes. That of lamps alone changes faster, at the edges of shadows, but
// lamps are few: they shoot again on the finer mesh, until its elements are small where they must be. How fast light changes
// is told by the steps between neighbouring elements of a face.
#include "radiosity/adapt.h"

#include <math.h>
#include <string.h>

#include "engine/core/error.h"

// Of the first solution.
static const double FIRST_RESIDUAL = 0.02;
static const int FIRST_RESOLUTION = 64;
// How often lamps shoot on ever finer meshes, and how many splits each time may add.
enum { LAMP_ROUNDS = 2, SPLITS_A_ROUND = 2 };
// Light below this share of the mean counts as so much: nobody looks for shadows in the dark.
static const double DARK = 0.1;

AdaptOptions adapt_default_options(void) { return (AdaptOptions){.contrast = 0.3, .smallest = 0.08}; }

typedef struct Adapt {
    const AdaptScene *scene;
    const AdaptOptions *options;
    const RadOptions *rad;
    const Progress *progress;
    Arena scratch;
    Mesh rough;
    double *reflected;  // [rough.element_count] of the first solution, without what lamps gave, W/m^2
    double *edge;       // [rough.element_count] that reflected light asks for, metres
    double dark;        // W/m^2
} Adapt;

static double sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

static double emission_of(const Mesh *mesh, int element) {
    Rgb e = mesh_material(mesh, mesh->elements[element].face)->emission;
    return (double)(e.r + e.g + e.b);
}

// What elements reflect, W/m^2, all channels: of the whole solution, or of the light of lamps alone.
static bool solve(Adapt *a, const Mesh *mesh, bool lamps_only, double *reflected, Error *error) {
    Arena arena = {0};
    RadSolution solution;
    RadOptions options = *a->rad;
    options.shots = 0;
    options.lamps_only = lamps_only;
    options.residual = lamps_only ? 0 : fmax(options.residual, FIRST_RESIDUAL);
    if (!lamps_only && options.form_factor.resolution > FIRST_RESOLUTION)
        options.form_factor.resolution = FIRST_RESOLUTION;
    bool good = rad_start(mesh, &arena, &solution, error);
    if (good) {
        rad_shoot(mesh, a->scene->forest, a->scene->door_open, &options, a->progress, &solution);
        for (int e = 0; e < mesh->element_count; e++)
            reflected[e] = fmax(0, sum3(solution.radiosity[e]) - emission_of(mesh, e));
    }
    arena_free(&arena);
    return good;
}

// ---- steps

// For each element the fastest change of `light` to a neighbour on its face, W/m^2 a metre.
static double *find_slopes(const Mesh *mesh, const double *light, Arena *arena) {
    double *slope = ARENA_ARRAY(arena, double, mesh->element_count);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        const int *squares = mesh->squares + face->first_square;
        double side[2] = {1 / vec3_length(face->gx), 1 / vec3_length(face->gy)};
        for (int j = 0; j < face->ny; j++) {
            for (int i = 0; i < face->nx; i++) {
                int here = squares[j * face->nx + i];
                for (int k = 0; k < 2 && here >= 0; k++) {
                    bool last = k == 0 ? i + 1 == face->nx : j + 1 == face->ny;
                    int there = last ? -1 : squares[(j + k) * face->nx + i + 1 - k];
                    if (there < 0 || there == here) continue;
                    const Element *p = &mesh->elements[here], *q = &mesh->elements[there];
                    double across = side[k] / sqrt(side[0] * side[1]);
                    double apart = 0.5 * across * (sqrt(p->area) + sqrt(q->area));
                    double change = fabs(light[here] - light[there]) / apart;
                    slope[here] = fmax(slope[here], change);
                    slope[there] = fmax(slope[there], change);
                }
            }
        }
    }
    return slope;
}

static int rough_element(const Adapt *a, const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++) sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return mesh_element_at(&a->rough, e->face, vec3_scale(sum, 1.0 / e->corner_count));
}

// ---- rounds

static bool first_solution(Adapt *a, const MeshOptions *options, Error *error) {
    static const MeshSplits ONCE = {.even = 1};
    MeshOptions rough = *options;
    rough.splits = &ONCE;
    if (!mesh_build(a->scene->graph, a->scene->vertices, a->scene->door_open, &rough, &a->scratch, &a->rough, error))
        return false;
    int count = a->rough.element_count;
    double *lamps = ARENA_ARRAY(&a->scratch, double, count), power = 0, area = 0;
    a->reflected = ARENA_ARRAY(&a->scratch, double, count);
    a->edge = ARENA_ARRAY(&a->scratch, double, count);
    if (!solve(a, &a->rough, false, a->reflected, error) || !solve(a, &a->rough, true, lamps, error)) return false;
    for (int e = 0; e < count; e++) {
        power += a->rough.elements[e].area * a->reflected[e];
        area += a->rough.elements[e].area * (a->reflected[e] > 0);
    }
    a->dark = DARK * power / fmax(area, 1e-12);
    double *indirect = ARENA_ARRAY(&a->scratch, double, count);
    for (int e = 0; e < count; e++) indirect[e] = fmax(0, a->reflected[e] - lamps[e]);
    const double *slope = find_slopes(&a->rough, indirect, &a->scratch);
    for (int e = 0; e < count; e++) {
        a->edge[e] = a->options->contrast * fmax(a->reflected[e], a->dark) / fmax(slope[e], 1e-30);
        a->reflected[e] = indirect[e];
    }
    return true;
}

// How deep elements of `mesh` should be, for the light of lamps on it and what the first solution asks.
static unsigned char *wanted(Adapt *a, const Mesh *mesh, const double *lamps) {
    unsigned char *depth = mesh_depths(mesh, &a->scratch);
    const double *slope = find_slopes(mesh, lamps, &a->scratch);
    for (int e = 0; e < mesh->element_count; e++) {
        int rough = rough_element(a, mesh, e);
        double light = fmax(lamps[e] + a->reflected[rough], a->dark);
        double edge = fmin(a->edge[rough], a->options->contrast * light / fmax(slope[e], 1e-30));
        double now = sqrt(mesh->elements[e].area);
        int splits = (int)ceil(log2(now / fmax(edge, a->options->smallest)));
        if (splits > SPLITS_A_ROUND) splits = SPLITS_A_ROUND;
        int deep = depth[e] + splits;
        depth[e] = (unsigned char)(deep < 0 ? 0 : deep > MESH_DEEPEST ? MESH_DEEPEST : deep);
    }
    return depth;
}

static bool make(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    if (!first_solution(a, options, error)) return false;
    const Mesh *mesh = &a->rough;
    MeshOptions finer = *options;
    for (int round = 0; round <= LAMP_ROUNDS; round++) {
        Mesh *next = ARENA_ARRAY(&a->scratch, Mesh, 1);
        double *lamps = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
        if (!solve(a, mesh, true, lamps, error)) return false;
        bool last = round == LAMP_ROUNDS;
        finer.splits = mesh_splits(mesh, wanted(a, mesh, lamps), arena);
        if (!mesh_build(a->scene->graph, a->scene->vertices, a->scene->door_open, &finer, last ? arena : &a->scratch,
                        last ? out : next, error))
            return false;
        mesh = next;
    }
    return true;
}

bool adapt_mesh(const AdaptScene *scene, const MeshOptions *options, const AdaptOptions *adapt,
                const RadOptions *rad, const Progress *progress, Arena *arena, Mesh *out, Error *error) {
    Adapt a = {.scene = scene, .options = adapt, .rad = rad, .progress = progress};
    bool good = make(&a, options, arena, out, error);
    arena_free(&a.scratch);
    return good;
}
