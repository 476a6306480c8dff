// adapt.c - meshes by what light does on them (Cohen, Greenberg, Immel & Brock 1986: adaptive subdivision).
//
// A first, rough solution tells how fast reflected light changes. That of lamps alone changes faster, at the edges of shadows, but
// lamps are few: they shoot again on the finer mesh, until its elements are small where they must be. How fast light changes
// is told by the steps between neighbouring elements of a face.
#include "radiosity/adapt.h"

#include <math.h>
#include <string.h>

#include "engine/core/error.h"
#include "radiosity/sky.h"

// Of the first solution.
static const double FIRST_RESIDUAL = 0.25;
static const int FIRST_RESOLUTION = 40;
// How often lamps shoot on ever finer meshes, and how many splits each time may add.
enum { LAMP_ROUNDS = 1, SPLITS_A_ROUND = 2 };
// Of what is only to tell where shadows are.
enum { LAMP_DETAIL = 2 };
// Where patches are as light asks they may be larger, of those of a mesh without splits.
static const double PATCH_EDGE = 1.5;
// How often roots are split, twice as long as patches usually are, into patches.
enum { MOST_PATCH_SPLITS = 2 };
// Light below this share of the mean counts as so much: nobody looks for shadows in the dark.
static const double DARK = 0.1;
// Where all is even, a change so small across a metre, of the light there, makes no difference.
static const double EVEN = 0.02;

AdaptOptions adapt_default_options(void) {
    return (AdaptOptions){.share = 0.4, .few = 5000, .smallest = 0.06};
}

// What an element asks for.
typedef struct Wish {
    double edge;   // now, metres
    double rate;   // how fast light changes, of all the light there, 1/m
    double light;  // W/m^2
    double finest, coarsest;
} Wish;

typedef struct Adapt {
    const AdaptScene *scene;
    const AdaptOptions *options;
    const RadOptions *rad;
    const Progress *progress;
    Arena scratch;
    Mesh rough;
    double *reflected;  // [rough.element_count] of the first solution, without what lamps gave, W/m^2
    double *rate;       // [rough.element_count] of that light, of all there is, 1/m
    double mean, dark;  // W/m^2
    double most;        // elements there may be
    double patch_edge;  // of that of a mesh without splits
    double
        *lamps;  // [element_count] what the light of lamps makes elements of the mesh at hand reflect, W/m^2
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
    // A mesh that depended on where a run was broken off would not be the same when it is resumed.
    options.shots = 0;
    options.seconds = 0;
    options.lamps_only = lamps_only;
    options.reach = 0;
    if (options.lamp_detail > LAMP_DETAIL) options.lamp_detail = LAMP_DETAIL;
    options.residual = lamps_only ? 0 : fmax(options.residual, FIRST_RESIDUAL);
    int usual = form_factor_default_options().resolution, most = lamps_only ? usual : FIRST_RESOLUTION;
    if (options.form_factor.resolution == 0 || options.form_factor.resolution > most)
        options.form_factor.resolution = most;
    bool good = rad_start_dark(mesh, &arena, &solution, error);
    if (good && sum3(a->options->sky) > 0 &&
        !rad_shine(mesh, a->scene->forest, a->scene->door_open, &options, a->options->sky, a->progress,
                   &solution))
        good = error_set(error, "stopped");
    if (good) {
        RadReport report =
            rad_shoot(mesh, a->scene->forest, a->scene->door_open, &options, a->progress, &solution);
        if (report.stopped) good = error_set(error, "stopped");
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
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return mesh_element_at(&a->rough, e->face, vec3_scale(sum, 1.0 / e->corner_count));
}

// ---- rounds

static bool build(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    return mesh_build(a->scene->graph, a->scene->vertices, a->scene->door_open, options, arena, out, error);
}

// What the reflected light of reflected light looks like, on patches of two by two elements.
static bool first_solution(Adapt *a, const MeshOptions *options, Error *error) {
    static const MeshSplits ONCE = {.even = 1};
    MeshOptions rough = *options;
    rough.splits = &ONCE;
    rough.close = 0;
    if (!build(a, &rough, &a->scratch, &a->rough, error)) return false;
    int count = a->rough.element_count;
    double power = 0, area = 0;
    a->lamps = ARENA_ARRAY(&a->scratch, double, count);
    a->reflected = ARENA_ARRAY(&a->scratch, double, count);
    a->rate = ARENA_ARRAY(&a->scratch, double, count);
    if (!solve(a, &a->rough, false, a->reflected, error) || !solve(a, &a->rough, true, a->lamps, error))
        return false;
    for (int e = 0; e < count; e++) {
        power += a->rough.elements[e].area * a->reflected[e];
        area += a->rough.elements[e].area;
    }
    a->mean = power / area;
    a->dark = DARK * a->mean;
    double *indirect = ARENA_ARRAY(&a->scratch, double, count);
    for (int e = 0; e < count; e++) indirect[e] = fmax(0, a->reflected[e] - a->lamps[e]);
    const double *slope = find_slopes(&a->rough, indirect, &a->scratch);
    for (int e = 0; e < count; e++) {
        a->rate[e] = slope[e] / fmax(a->reflected[e], fmax(a->dark, 1e-30));
        a->reflected[e] = indirect[e];
    }
    return true;
}

// Of the square that an element is, or is cut from, metres.
static double edge_of(const Mesh *mesh, int element) {
    const Face *face = &mesh->faces[mesh->elements[element].face];
    double square = 1 / sqrt(vec3_length(face->gx) * vec3_length(face->gy));
    return ldexp(square * face->root, -mesh->elements[element].depth);
}

static Wish *find_wishes(Adapt *a, const Mesh *mesh, const double *lamps) {
    Wish *wishes = ARENA_ARRAY(&a->scratch, Wish, mesh->element_count);
    const double *slope = find_slopes(mesh, lamps, &a->scratch);
    for (int e = 0; e < mesh->element_count; e++) {
        int rough = rough_element(a, mesh, e);
        double light = lamps[e] + a->reflected[rough], rate = slope[e] / fmax(light, fmax(a->dark, 1e-30));
        double now = edge_of(mesh, e);
        wishes[e] = (Wish){.edge = now,
                           .rate = fmax(EVEN, fmax(rate, a->rate[rough])),
                           .light = light + emission_of(mesh, e),
                           .finest = fmin(now, fmax(a->options->smallest, ldexp(now, -SPLITS_A_ROUND))),
                           .coarsest = ldexp(now, MESH_DEEPEST)};
    }
    return wishes;
}

// Elements of edge h, of light that changes at a rate g, err by g h: the sum of squares over all area is least for a given number
// of elements where h is as 1 / sqrt(g).
static double wished_edge(const Wish *w, double scale) {
    return fmin(fmax(scale / sqrt(w->rate), w->finest), w->coarsest);
}

static int splits_to(double edge, double wanted) { return (int)lround(log2(edge / wanted)); }

static double count_of(const Wish *wishes, const Element *elements, int count, double scale) {
    double sum = 0;
    for (int e = 0; e < count; e++) {
        int splits = splits_to(wishes[e].edge, wished_edge(&wishes[e], scale));
        sum += ldexp(1, 2 * (splits < -elements[e].depth ? -elements[e].depth : splits));
    }
    return sum;
}

static double find_scale(const Adapt *a, const Wish *wishes, const Mesh *mesh) {
    double low = 1e-3, high = 1e3;
    for (int i = 0; i < 30; i++) {
        double middle = sqrt(low * high);
        *(count_of(wishes, mesh->elements, mesh->element_count, middle) > a->most ? &low : &high) = middle;
    }
    return high;
}

static unsigned char limit(int depth) {
    return (unsigned char)(depth < 0 ? 0 : depth > MESH_DEEPEST ? MESH_DEEPEST : depth);
}

// Shooters err by about their power times their size: the sum is least for a number of them where their edges are as the fourth
// root of 1 / light. Lamps count as bright as they are.
static int patch_depth(const Adapt *a, const Mesh *mesh, int element, double light, double root) {
    if (!(a->mean > 0)) return 0;  // in the dark, or all is black
    double usual = a->patch_edge * mesh->options.element * mesh->options.per_patch;
    double edge = usual * pow(fmax(light, a->dark) / a->mean, -0.25);
    // Of lamps, of which each shoots with more detail, a quarter of the root at least.
    if (mesh_emits(mesh, mesh->elements[element].face)) edge = fmax(edge, root / 2);
    int depth = splits_to(root, edge);
    return depth < 0 ? 0 : depth > MOST_PATCH_SPLITS ? MOST_PATCH_SPLITS : depth;
}

static MeshSplits *split(Adapt *a, const Mesh *mesh, const double *lamps, Arena *arena) {
    const Wish *wishes = find_wishes(a, mesh, lamps);
    int count = mesh->element_count;
    unsigned char *patch = ARENA_ARRAY(&a->scratch, unsigned char, count),
                  *element = ARENA_ARRAY(&a->scratch, unsigned char, count);
    double scale = find_scale(a, wishes, mesh);
    for (int e = 0; e < count; e++) {
        int depth = mesh->elements[e].depth;
        element[e] = limit(depth + splits_to(wishes[e].edge, wished_edge(&wishes[e], scale)));
        patch[e] = limit(patch_depth(a, mesh, e, wishes[e].light, ldexp(wishes[e].edge, depth)));
    }
    return mesh_splits(mesh, patch, element, arena);
}

static bool make(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    if (!first_solution(a, options, error)) return false;
    double even = mesh_count_even(&a->rough);
    a->most = fmax(a->options->share * even, a->options->few);
    a->patch_edge = even > a->options->few ? PATCH_EDGE : 1;
    const Mesh *mesh = &a->rough;
    MeshOptions finer = *options;
    for (int round = 0;; round++) {
        bool last = round == LAMP_ROUNDS;
        Mesh *next = last ? out : ARENA_ARRAY(&a->scratch, Mesh, 1);
        finer.splits = split(a, mesh, a->lamps, arena);
        finer.close = last ? options->close : 0;
        if (!build(a, &finer, last ? arena : &a->scratch, next, error)) return false;
        if (last) return true;
        mesh = next;
        a->lamps = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
        if (!solve(a, mesh, true, a->lamps, error)) return false;
    }
}

bool adapt_mesh(const AdaptScene *scene, const MeshOptions *options, const AdaptOptions *adapt,
                const RadOptions *rad, const Progress *progress, Arena *arena, Mesh *out, Error *error) {
    Adapt a = {.scene = scene, .options = adapt, .rad = rad, .progress = progress};
    bool good = make(&a, options, arena, out, error);
    arena_free(&a.scratch);
    return good;
}
