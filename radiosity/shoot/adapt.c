// adapt.c - meshes by what light does on them (Cohen, Greenberg, Immel & Brock 1986: adaptive subdivision).
//
// A first, rough solution tells how fast reflected light changes. That of lamps alone changes faster, at the edges of shadows, but
// lamps are few: they shoot again on the finer mesh, until its elements are small where they must be. How fast light changes
// is told by the steps between neighbouring elements of a face.
#include "radiosity/shoot/adapt.h"

#include <math.h>
#include <string.h>

#include "engine/core/error.h"
#include "radiosity/shoot/adapt_trees.h"
#include "radiosity/shoot/sky.h"

// For the first solution.
static const double FIRST_RESIDUAL = 0.25;
static const int FIRST_RESOLUTION = 40;
// Lamps by the thousand in one room, each with all the others before it: a solution that only tells how fine the mesh is to be ends when
// its shooters, the strongest first, had so many faces before them. Of a file of 1 MB or less; of larger ones by the square of their size.
static const double FIRST_LOOKS = 1.6e7, LAMP_LOOKS = 3e6, SMALL_FILE = 1e6;
// How often lamps shoot on ever finer meshes, and how many splits each time may add.
enum { LAMP_ROUNDS = 1, SPLITS_A_ROUND = 2 };
// Elements are not more often split than so below their patch.
enum { MOST_BELOW_PATCH = 2 };
// Lamp detail of the pilot solution, which only tells where shadows are.
enum { LAMP_DETAIL = 2 };
// Where patches are as light asks they may be larger, of those of a mesh without splits.
static const double PATCH_EDGE = 1.5;
// How often roots are split, twice as long as patches usually are, into patches.
enum { MOST_PATCH_SPLITS = 2 };
// Patches with less light than this share of the mean are no larger for it.
static const double DARK = 0.1;
// Reflectance below which surfaces count as if they had so much.
static const double BLACK = 0.05;
// Elements that lamps shine on to tell where shadows end, of those there may be in the end.
static const double PILOT = 1;

AdaptOptions adapt_default_options(void) {
    return (AdaptOptions){.share = 0.4, .few = 5000, .smallest = 0.06};
}

typedef struct Adapt {
    const AdaptScene *scene;
    const AdaptOptions *options;
    const RadOptions *rad;
    const Progress *progress;
    Arena scratch;
    Mesh rough;
    double *indirect;  // [rough.element_count] of the first solution, without what lamps gave, W/m^2
    AdaptField indirect_field;
    double mean;        // reflected radiosity, W/m^2
    double most;        // elements there may be
    double patch_edge;  // of that of a mesh without splits
    double *lamps;      // [element_count] of the light of lamps alone, on the mesh at hand, W/m^2
} Adapt;

static double sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

static double emission_of(const Mesh *mesh, int element) {
    Rgb e = mesh_material(mesh, mesh->elements[element].face)->emission;
    return (double)(e.r + e.g + e.b);
}

static double reflectance_of(const Mesh *mesh, int element) {
    Rgb rho = mesh_material(mesh, mesh->elements[element].face)->reflectance;
    return (double)(rho.r + rho.g + rho.b) / 3;
}

// The light of all channels, from the part that is reflected: surfaces of all colours count alike, but nothing is seen on black ones.
static double irradiance_of(const Mesh *mesh, int element, const double b[3]) {
    const Material *m = mesh_material(mesh, mesh->elements[element].face);
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += fmax(0, b[c] - (double)e[c]) / fmax((double)rho[c], BLACK);
    return sum;
}

// Irradiances of elements, W/m^2: of the whole solution, or of the light of lamps alone.
static bool solve(Adapt *a, const Mesh *mesh, bool lamps_only, double *irradiance, Error *error) {
    Arena arena = {0};
    RadSolution solution;
    RadOptions options = *a->rad;
    // A mesh that depended on where a run was broken off would not be the same when it is resumed.
    options.shots = 0;
    double size = fmax(1, a->scene->graph->building->file_size / SMALL_FILE);
    options.looks = (lamps_only ? LAMP_LOOKS : FIRST_LOOKS) * size * size;
    options.lamps_only = lamps_only;
    if (!lamps_only) options.reach = 0;
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
            irradiance[e] = irradiance_of(mesh, e, solution.radiosity[e]);
    }
    arena_free(&arena);
    return good;
}

// ---- rounds

static bool build_adapted(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    return mesh_build(a->scene->graph, a->scene->vertices, a->scene->door_open, options, arena, out, error);
}

// The light after two reflections, on patches of two by two elements.
static bool first_solution(Adapt *a, const MeshOptions *options, Error *error) {
    static const MeshSplits ONCE = {.even = 1};
    MeshOptions rough = *options;
    rough.splits = &ONCE;
    rough.close = 0;
    rough.loose = true;
    if (!build_adapted(a, &rough, &a->scratch, &a->rough, error)) return false;
    int count = a->rough.element_count;
    double power = 0, area = 0;
    a->lamps = ARENA_ARRAY(&a->scratch, double, count);
    a->indirect = ARENA_ARRAY(&a->scratch, double, count);
    if (!solve(a, &a->rough, false, a->indirect, error) || !solve(a, &a->rough, true, a->lamps, error))
        return false;
    for (int e = 0; e < count; e++) {
        power += a->rough.elements[e].area * a->indirect[e] * reflectance_of(&a->rough, e);
        area += a->rough.elements[e].area;
        a->indirect[e] = fmax(0, a->indirect[e] - a->lamps[e]);
    }
    a->mean = power / area;
    a->indirect_field = adapt_field(&a->rough, a->indirect, &a->scratch);
    return true;
}

// The side of the square that an element is, or is cut from, metres.
static double root_edge(const Mesh *mesh, int element) {
    const Face *face = &mesh->faces[mesh->elements[element].face];
    return face->root / sqrt(vec3_length(face->gx) * vec3_length(face->gy));
}

static Vec3 element_middle(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return vec3_scale(sum, 1.0 / e->corner_count);
}

// All light on the elements of a mesh: of lamps as they shone on it, the rest from the rough mesh, as it slopes there.
static AdaptField find_light(Adapt *a, const Mesh *mesh) {
    double *light = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) {
        Vec3 here = element_middle(mesh, e);
        int face = mesh->elements[e].face, rough = mesh_element_at(&a->rough, face, here);
        Vec3 off = vec3_sub(here, element_middle(&a->rough, rough));
        const Face *grid = &a->rough.faces[face];
        const double *slope = a->indirect_field.slope[rough];
        light[e] =
            a->lamps[e] + fmax(0, a->indirect[rough] + slope[0] * vec3_dot(vec3_normalize(grid->gx), off) +
                                      slope[1] * vec3_dot(vec3_normalize(grid->gy), off));
    }
    return adapt_field(mesh, light, &a->scratch);
}

static unsigned char limit(int depth) {
    return (unsigned char)(depth < 0 ? 0 : depth > MESH_DEEPEST ? MESH_DEEPEST : depth);
}

// Shooters err by about their power times their size: the sum is least for a number of them where their edges are as the fourth
// root of 1 / light. Lamps count as bright as they are.
static int patch_depth(const Adapt *a, const Mesh *mesh, int element, double light) {
    if (!(a->mean > 0)) return 0;  // in the dark, or all is black
    double usual = a->patch_edge * mesh->options.element * mesh->options.per_patch,
           root = root_edge(mesh, element);
    double edge = usual * pow(fmax(light / a->mean, DARK), -0.25);
    // For lamps, each of which shoots with more detail, a quarter of the root at least.
    if (mesh_emits(mesh, mesh->elements[element].face)) edge = fmax(edge, root / 2);
    int depth = (int)lround(log2(root / edge));
    return depth < 0 ? 0 : depth > MOST_PATCH_SPLITS ? MOST_PATCH_SPLITS : depth;
}

static MeshSplits *split(Adapt *a, const Mesh *mesh, bool last, Arena *arena) {
    AdaptField field = find_light(a, mesh);
    AdaptLimits limits = {.most = last ? a->most : PILOT * a->most,
                          .smallest = a->options->smallest,
                          .deeper = SPLITS_A_ROUND,
                          .halves = last};
    MeshDepth *element = adapt_depths(&field, &limits, &a->scratch);
    unsigned char *patch = ARENA_ARRAY(&a->scratch, unsigned char, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) {
        double light = field.light[e] * reflectance_of(mesh, e) + emission_of(mesh, e);
        int deepest = element[e].x > element[e].y ? element[e].x : element[e].y;
        patch[e] = limit((int)fmax(patch_depth(a, mesh, e, light), deepest - MOST_BELOW_PATCH));
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
        finer.close = last ? options->close : 0;
        finer.loose = !last;
        finer.splits = split(a, mesh, last, arena);
        if (!build_adapted(a, &finer, last ? arena : &a->scratch, next, error)) return false;
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
