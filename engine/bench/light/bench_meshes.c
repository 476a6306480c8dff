// bench_meshes.c - the elements that adaptive meshes save: elements against error, from coarse to fine, for three kinds of meshes:
// even meshes, even meshes that are cut where objects stand on their faces, and cut meshes that are as fine as their light requires;
// and how many elements an even mesh would need for the same error.
//
// The error is that of the field: the root of the mean square, over all surfaces, of the error of the irradiance, relative to the
// mean irradiance (against path tracing at random points, evenly by area). It is measured for the light of the elements, for the
// light between their corners, which is shown, and for the light that the first points gather.
#include <stddef.h>

#include "engine/bench/light/lit_points.h"

static const char MESHES_HEAD[] =
    "building,mesh,element_m,elements,patches,mesh_seconds,bake_seconds,element_rms,vertex_rms,gather_rms,"
    "of_even_element,of_even_vertex,of_even_gather,points,points_gathering,truth_error\n";

// Edges of elements, relative to the edge that fits the building. Even meshes go on to finer elements, so that their errors come
// down to those of the other kinds.
static const double SCALES[] = {4, 2.8, 2, 1.4, 1, 0.7};
enum { SCALE_COUNT = sizeof SCALES / sizeof *SCALES, MOST_GATHERING = 100 };

enum { EVEN, CUT, ADAPTIVE, KINDS };
static const struct {
    const char *name;
    int scales;
} KIND[KINDS] = {{"even", SCALE_COUNT}, {"cut", SCALE_COUNT - 1}, {"adaptive", SCALE_COUNT - 1}};

typedef struct Size {
    double elements, rms[LIGHT_COMPARED];
} Size;

typedef struct Curve {
    Size sizes[SCALE_COUNT];  // ever more elements
    int count;
} Curve;

// How many elements the curve takes for that error, between its sizes as powers of each other; 0: outside of them.
static double elements_at(const Curve *curve, int what, double rms) {
    for (int i = curve->count - 1; i > 0; i--) {
        const Size *coarse = &curve->sizes[i - 1], *fine = &curve->sizes[i];
        double high = coarse->rms[what], low = fine->rms[what];
        if (!(rms >= low && rms <= high && high > low)) continue;
        double along = log(rms / high) / log(low / high);
        return coarse->elements * pow(fine->elements / coarse->elements, along);
    }
    return 0;
}

static void add_meshes_row(const LightScene *s, const LightBake *bake, int kind, const Size *size,
                           const Curve *even, Text *csv) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%g,%d,%d,%.4f,%.4f", bench_name(s->file), KIND[kind].name, bake->options.element,
                bake->mesh.element_count, bake->mesh.patch_count, bake->mesh_seconds, bake->seconds);
    static const int ORDER[] = {LIGHT_OF_ELEMENT, LIGHT_BETWEEN_CORNERS, LIGHT_GATHERED};
    for (int k = 0; k < LIGHT_COMPARED; k++) text_append(csv, ",%.4f", size->rms[ORDER[k]]);
    for (int k = 0; k < LIGHT_COMPARED; k++) {
        double like = kind != EVEN ? elements_at(even, ORDER[k], size->rms[ORDER[k]]) : 0;
        if (like > 0)
            text_append(csv, ",%.3f", size->elements / like);
        else
            text_append(csv, ",");
    }
    const LightPoints *points = &s->points;
    double squares = 0;
    for (int i = 0; i < points->count; i++)
        squares += points->points[i].standard_error * points->points[i].standard_error;
    text_append(csv, ",%d,%d,%.4f\n", points->count,
                points->count < MOST_GATHERING ? points->count : MOST_GATHERING,
                100 * sqrt(squares / points->count) / points->mean);
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

static bool bench_size(const LightScene *s, int kind, double scale, Curve *curves, Text *csv, Error *error) {
    Arena arena = {0};
    LightBake bake;
    light_bake_defaults(s, &bake);
    bake.options.element *= scale;
    bake.adapt.few = 0;
    if (kind == EVEN) bake.options.close = 0;
    if (kind != ADAPTIVE) bake.adapt.share = 0;
    bool good = light_bake(s, &arena, &bake, error);
    if (good) {
        LightErrors errors = light_errors(s, &bake, MOST_GATHERING, &arena);
        Curve *curve = &curves[kind];
        Size *size = &curve->sizes[curve->count++];
        size->elements = bake.mesh.element_count;
        for (int what = 0; what < LIGHT_COMPARED; what++)
            size->rms[what] = light_errors_rms(s, errors.off[what]);
        add_meshes_row(s, &bake, kind, size, &curves[EVEN], csv);
    }
    arena_free(&arena);
    return good;
}

static bool meshes_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightScene s;
    Curve curves[KINDS] = {0};
    bool good = light_scene_open(file, a, LIGHT_TRUTH_MEAN, &arena, &s, error);
    for (int kind = 0; kind < KINDS; kind++)
        for (int i = 0; i < KIND[kind].scales && good; i++)
            good = bench_size(&s, kind, SCALES[i], curves, csv, error);
    arena_free(&arena);
    return good;
}

static bool measure_meshes(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 500;
    if (own.error == 0) own.error = 0.03;
    return bench_table(&own, MESHES_HEAD, NULL, meshes_of_file, error);
}

static const Option MESHES_ROWS[] = {
    BENCH_POINTS("500"),
    BENCH_ERROR("standard error of the truth, of the mean irradiance, @ (default 0.03)"),
    BENCH_SEED("of points and paths"),
    BENCH_SKY,
    BENCH_CSV,
};

const Bench BENCH_MESHES = {
    .name = "meshes",
    .about =
        "what adaptive meshes save: elements against error, from coarse to fine, of even meshes, of even "
        "ones "
        "cut where things stand (cut) and of those that `enfilade bake` makes (adaptive); the root of the "
        "mean square, over all surfaces, of the error of the irradiance, percent of its mean: element_: as "
        "elements hold it, vertex_: between corners, gather_: of the first 100 points; of_even_: elements, "
        "of "
        "those that an even mesh needs for the same error",
    BENCH_OPTIONS(MESHES_ROWS),
    .run = measure_meshes,
    .files = BENCH_LIT_FILES,
};
