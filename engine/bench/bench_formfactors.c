// bench_formfactors.c - one shot by each form-factor method, at each resolution and with each culling: time, and error
// against a great many independent random rays.
//
// The error is L1 = sum |F - F_ref| over all elements, the mean of the shooters: patches spread evenly over the mesh. Times
// are of one thread, the search for visible faces included (rays need none). For each shooter the least time of several
// passes counts, so that other work of the machine disturbs it little.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/core/text.h"
#include "radiosity/factors/form_factor.h"
#include "radiosity/methods/ray_caster.h"
#include "visibility/hidden/hidden.h"

typedef struct ShotReference {
    uint32_t **arrivals;  // [shooter][element_count] rays that met each element
    long long rays;       // of each shooter
    int element_count;
} ShotReference;

enum { MOST_THREADS = 64 };

typedef struct Casting {
    const ShotReference *reference;
    const ViewPoint *from;
    uint64_t seed;
    RayCaster *casters[MOST_THREADS];  // of each thread
} Casting;

// Eight directions about `z`: points of the disc, lifted.
static RayEight random_rays(Random *random, Vec3 x, Vec3 y, Vec3 z) {
    RayEight rays;
    for (int i = 0; i < LANES; i++) {
        double r2 = random_unit(random), angle = 2 * M_PI * random_unit(random), r = sqrt(r2);
        Vec3 w = vec3_add(vec3_add(vec3_scale(x, r * cos(angle)), vec3_scale(y, r * sin(angle))),
                          vec3_scale(z, sqrt(1 - r2)));
        rays.x[i] = (float)w.x;
        rays.y[i] = (float)w.y;
        rays.z[i] = (float)w.z;
    }
    return rays;
}

static void cast_shooter(void *context, int shooter, int thread) {
    const Casting *casting = context;
    Random random = {casting->seed * 1000003 + (uint64_t)shooter};
    const ViewPoint *from = &casting->from[shooter];
    Vec3 x, y;
    view_axes(from->normal, &x, &y);
    uint32_t *arrivals = casting->reference->arrivals[shooter];
    for (long long i = 0; i < casting->reference->rays / LANES; i++) {
        RayEight rays = random_rays(&random, x, y, from->normal);
        int32_t face[LANES], element[LANES];
        ray_caster_cast(casting->casters[thread], from->eye, from->normal, &rays, ~(LaneInt){0}, false, face,
                        element);
        for (int k = 0; k < LANES; k++)
            if (element[k] >= 0) arrivals[element[k]]++;
    }
}

// The same for the same seed, on any number of threads.
static ShotReference shot_reference(const Mesh *mesh, const ViewPoint *from, int count, long long rays,
                                    uint64_t seed, Arena *arena) {
    ShotReference reference = {.rays = rays / LANES * LANES, .element_count = mesh->element_count};
    reference.arrivals = ARENA_ARRAY(arena, uint32_t *, count + 1);
    for (int s = 0; s < count; s++) reference.arrivals[s] = ARENA_ARRAY(arena, uint32_t, mesh->element_count);
    Casting casting = {.reference = &reference, .from = from, .seed = seed};
    int threads = parallel_threads(0);
    if (threads > MOST_THREADS) threads = MOST_THREADS;
    for (int t = 0; t < threads; t++) casting.casters[t] = ray_caster_new(mesh, arena);
    parallel_for(threads, count, cast_shooter, &casting);
    for (int t = 0; t < threads; t++) ray_caster_end(casting.casters[t]);
    return reference;
}

// L1 = sum |F - F_ref| over all elements.
static double shot_reference_l1(const ShotReference *reference, int shooter, const Row *row) {
    const uint32_t *arrivals = reference->arrivals[shooter];
    double sum = 0;
    int at = 0;
    for (int e = 0; e < reference->element_count; e++) {
        double f = 0;
        if (at < row->count && row->element[at] == e) f = (double)row->factor[at++];
        sum += fabs(f - arrivals[e] / (double)reference->rays);
    }
    return sum;
}

static const char HEAD[] = "building,method,resolution,culling,shooters,ms_a_shot,ms_a_look,l1,faces_drawn,"
                           "elements_drawn,samples,tests,rays_of_reference,front\n";

enum { PASSES = 9, RUN_SECONDS = 2 };

// A row of the table.
typedef struct Run {
    const FormFactorMethod *method;
    const char *hidden;  // that fills the hemicube's sides; NULL: none
    char name[40];
    Culling culling;
    int resolution;
    double ms, look_ms, l1;
    FormFactorWork work;  // of all shooters once
    Arena arena;
    FormFactor *rows;
    double *least, *least_look;  // [shooter_count] seconds
    double spent;                // in all passes
} Run;

typedef struct ShotBench {
    const char *file;
    const BenchArguments *arguments;
    LoadedScene scene;
    Mesh mesh;
    Viewer *viewer;
    int *shooters;  // [shooter_count] patches
    int shooter_count;
    ShotReference reference;
    Run *runs;
    int run_count, run_capacity;
} ShotBench;

static ViewPoint point_of(const ShotBench *b, int shooter) {
    const Patch *patch = &b->mesh.patches[b->shooters[shooter]];
    return (ViewPoint){patch->centre, b->mesh.faces[patch->face].plane.n, patch->cell};
}

static void choose_shooters(ShotBench *b, Arena *arena) {
    int wanted = b->arguments->shooters;
    b->shooters = ARENA_ARRAY(arena, int, wanted);
    for (int i = 0; i < wanted; i++) {
        int patch = (int)((i + 0.5) * b->mesh.patch_count / wanted);
        if (b->mesh.patches[patch].cell >= 0) b->shooters[b->shooter_count++] = patch;
    }
}

static ShotReference make_reference(const ShotBench *b, Arena *arena) {
    ViewPoint *from = ARENA_ARRAY(arena, ViewPoint, b->shooter_count + 1);
    for (int s = 0; s < b->shooter_count; s++) from[s] = point_of(b, s);
    return shot_reference(&b->mesh, from, b->shooter_count, b->arguments->rays, b->arguments->seed, arena);
}

// ---- the methods

static void shoot(ShotBench *b, Run *run, int s, bool first) {
    ViewPoint from = point_of(b, s);
    View axes = {.eye = from.eye, .z = from.normal};
    const View *view = &axes;
    view_axes(axes.z, &axes.x, &axes.y);
    double start = clock_thread_seconds();
    if (!run->method->whole_mesh) view = form_factor_look(run->rows, b->viewer, &from, run->culling);
    double looked = clock_thread_seconds();
    const Row *row = form_factor_row(run->rows, view);
    double end = clock_thread_seconds();
    run->spent += end - start;
    if (first) run->l1 += shot_reference_l1(&b->reference, s, row) / b->shooter_count;
    if (first || end - start < run->least[s]) run->least[s] = end - start;
    if (first || looked - start < run->least_look[s]) run->least_look[s] = looked - start;
}

static void begin_run(ShotBench *b, Run *run) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = run->resolution;
    options.hidden = run->hidden;
    run->rows = form_factor_new(run->method, &b->mesh, &options, &run->arena);
    run->least = ARENA_ARRAY(&run->arena, double, b->shooter_count);
    run->least_look = ARENA_ARRAY(&run->arena, double, b->shooter_count);
}

static void end_run(ShotBench *b, Run *run) {
    for (int s = 0; s < b->shooter_count; s++) {
        run->ms += 1000 * run->least[s] / b->shooter_count;
        run->look_ms += 1000 * run->least_look[s] / b->shooter_count;
    }
    form_factor_end(run->rows);
    arena_free(&run->arena);
}

// All runs in turn, pass after pass: a spell in which the machine is slow falls on all of them.
static void measure_all(ShotBench *b) {
    for (int i = 0; i < b->run_count; i++) begin_run(b, &b->runs[i]);
    for (int pass = 0; pass < PASSES; pass++) {
        for (int i = 0; i < b->run_count; i++) {
            Run *run = &b->runs[i];
            if (run->spent > RUN_SECONDS) continue;
            for (int s = 0; s < b->shooter_count; s++) shoot(b, run, s, pass == 0);
            if (pass == 0) run->work = form_factor_work(run->rows);
        }
    }
    for (int i = 0; i < b->run_count; i++) end_run(b, &b->runs[i]);
}

// Is no other run both as fast and as right: does it lie on the Pareto front?
static bool on_front(const ShotBench *b, const Run *run) {
    for (int i = 0; i < b->run_count; i++) {
        const Run *other = &b->runs[i];
        if (other->ms <= run->ms && other->l1 <= run->l1 && (other->ms < run->ms || other->l1 < run->l1))
            return false;
    }
    return true;
}

static void add_formfactors_row(const ShotBench *b, const Run *run, Text *table) {
    double n = b->shooter_count;
    text_append(table, "%s,%s,%d,%s,%d,%.4f,%.4f,%.5f,%.1f,%.1f,%.0f,%.0f,%lld,%d\n", bench_name(b->file),
                run->name, run->resolution, CULLING_NAMES[run->culling], b->shooter_count, run->ms,
                run->look_ms, run->l1, (double)run->work.faces_drawn / n,
                (double)run->work.elements_drawn / n, (double)run->work.samples / n,
                (double)run->work.tests / n, b->reference.rays, on_front(b, run));
}

// ---- runs

static void add_runs(ShotBench *b, const FormFactorMethod *method, const char *hidden, Culling culling,
                     Arena *arena) {
    const BenchArguments *a = b->arguments;
    for (int r = 0; r < a->resolution_count; r++) {
        Run *run = ARENA_PUSH(arena, b->runs, b->run_count, b->run_capacity);
        *run = (Run){.method = method, .hidden = hidden, .resolution = a->resolutions[r], .culling = culling};
        snprintf(run->name, sizeof run->name, "%s%s%s", method->name, hidden ? "-" : "",
                 hidden ? hidden : "");
    }
}

// A hemicube filled by one of HIDDEN_METHODS goes by both names; NULL: it is none.
static const char *hidden_of(const char *name) {
    static const char PREFIX[] = "hemicube-";
    if (strncmp(name, PREFIX, sizeof PREFIX - 1) != 0) return NULL;
    const HiddenMethod *hidden = hidden_find(name + sizeof PREFIX - 1);
    return hidden ? hidden->name : NULL;
}

static bool is_formfactors_method(const char *name) { return form_factor_method(name) || hidden_of(name); }

static void choose_runs(ShotBench *b, Arena *arena) {
    const BenchArguments *a = b->arguments;
    for (int m = 0; FORM_FACTOR_METHODS[m]; m++) {
        const FormFactorMethod *method = FORM_FACTOR_METHODS[m];
        if (!bench_listed(a->methods, method->name)) continue;
        for (int i = 0; i < BENCH_CULLINGS; i++) {
            Culling c = BENCH_CULLING[i];
            // Rays are culled by their own tree.
            if (method->whole_mesh ? c == CULL_NONE : bench_listed(a->cullings, CULLING_NAMES[c]))
                add_runs(b, method, NULL, c, arena);
        }
    }
    // Hidden-surface methods draw all there is.
    for (int h = 0; HIDDEN_METHODS[h]; h++) {
        char name[40];
        snprintf(name, sizeof name, "hemicube-%s", HIDDEN_METHODS[h]->name);
        if (bench_listed(a->methods, name))
            add_runs(b, form_factor_method("hemicube"), HIDDEN_METHODS[h]->name, CULL_NONE, arena);
    }
}

static void print_runs(const ShotBench *b, Text *table) {
    size_t start = table->size;
    for (int i = 0; i < b->run_count; i++) add_formfactors_row(b, &b->runs[i], table);
    if (b->run_count > 0) fputs(table->data + start, stdout);
    fflush(stdout);
}

// ---- equal error

// The time a method takes to an error, on the straight line between its points in logarithms; beyond them, along the
// nearest two. Negative: it has less than two points.
static double ms_at(const ShotBench *b, const FormFactorMethod *method, Culling culling, double l1) {
    const Run *low = NULL, *high = NULL;
    for (int i = 0; i + 1 < b->run_count; i++) {
        const Run *p = &b->runs[i], *q = &b->runs[i + 1];
        if (p->method != method || q->method != method || p->hidden || q->hidden || p->culling != culling ||
            q->culling != culling || p->l1 == q->l1)
            continue;
        if (!low || q->l1 >= l1 || p->l1 >= l1) low = p, high = q;
    }
    if (!low) return -1;
    double t = (log(l1) - log(low->l1)) / (log(high->l1) - log(low->l1));
    return exp(log(low->ms) + t * (log(high->ms) - log(low->ms)));
}

static const Run *find_run(const ShotBench *b, const char *method, int resolution, Culling culling) {
    for (int i = 0; i < b->run_count; i++)
        if (strcmp(b->runs[i].name, method) == 0 && b->runs[i].resolution == resolution &&
            b->runs[i].culling == culling)
            return &b->runs[i];
    return NULL;
}

// How much faster each method is at the error of Embree's hemicube of 100 rays a side.
static void print_ratios(const ShotBench *b) {
    const Run *goal = find_run(b, "ray-hemicube", 100, CULL_NONE);
    if (!goal) return;
    double best = goal->ms;
    for (int m = 0; FORM_FACTOR_METHODS[m]; m++) {
        double ms =
            FORM_FACTOR_METHODS[m]->whole_mesh ? ms_at(b, FORM_FACTOR_METHODS[m], CULL_NONE, goal->l1) : -1;
        if (ms > 0 && ms < best) best = ms;
    }
    fprintf(stderr,
            "%s: at the error of ray-hemicube 100, L1 %.4f (%.3f ms a shot, the best rays %.3f ms):\n",
            bench_name(b->file), goal->l1, goal->ms, best);
    for (int m = 0; FORM_FACTOR_METHODS[m]; m++) {
        for (int i = 0; i < BENCH_CULLINGS; i++) {
            Culling c = BENCH_CULLING[i];
            double ms = ms_at(b, FORM_FACTOR_METHODS[m], c, goal->l1);
            if (ms <= 0) continue;
            fprintf(stderr,
                    "  %-22s %-8s %8.3f ms a shot: %5.2f times as fast as that, %5.2f as the best rays\n",
                    FORM_FACTOR_METHODS[m]->name, CULLING_NAMES[c], ms, goal->ms / ms, best / ms);
        }
    }
}

static bool formfactors_of_file(const char *file, const BenchArguments *a, Text *table, Error *error) {
    Arena arena = {0};
    ShotBench *b = ARENA_ARRAY(&arena, ShotBench, 1);
    b->file = file;
    b->arguments = a;
    SceneOptions options = a->load;
    MeshOptions mesh = mesh_default_options();
    mesh.close = 0;  // the scene of the figures that are compared
    bool good = app_load(file, &options, &arena, &b->scene, error) && scene_has_walls(&b->scene, error) &&
                mesh_build(&b->scene.graph, NULL, &mesh, &arena, &b->mesh, error);
    if (good) {
        b->viewer = viewer_new(&b->mesh, &b->scene.forest, NULL, &arena);
        choose_shooters(b, &arena);
        b->reference = make_reference(b, &arena);
        choose_runs(b, &arena);
        measure_all(b);
        print_runs(b, table);
        print_ratios(b);
    }
    arena_free(&arena);
    return good;
}

static bool measure_formfactors(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, formfactors_of_file, error);
}

// Whole numbers, separated by commas.
static int take_resolutions(const char *text, void *arguments, Error *error) {
    BenchArguments *a = arguments;
    for (a->resolution_count = 0; *text && a->resolution_count < BENCH_RESOLUTIONS; text += *text == ',') {
        char *end;
        long number = strtol(text, &end, 10);
        bool good = end != text && (*end == ',' || !*end) && number >= 8 && number <= 2000;
        if (!good) break;
        a->resolutions[a->resolution_count++] = (int)number;
        text = end;
    }
    if (*text == 0 && a->resolution_count > 0) return APP_GOOD;
    error_set(error, "8 to 2000, %d of them at most", BENCH_RESOLUTIONS);
    return APP_BAD_USE;
}

static int take_cullings(const char *text, void *arguments, Error *error) {
    ((BenchArguments *)arguments)->cullings = text;
    while (*text) {
        int length = (int)strcspn(text, ","), i = 0;
        while (i < BENCH_CULLINGS && ((int)strlen(CULLING_NAMES[BENCH_CULLING[i]]) != length ||
                                      strncmp(text, CULLING_NAMES[BENCH_CULLING[i]], (size_t)length) != 0))
            i++;
        if (i == BENCH_CULLINGS) {
            error_set(error, "none, depth, cells, plan, stab, with commas between them");
            return APP_BAD_USE;
        }
        text += length + (text[length] == ',');
    }
    return APP_GOOD;
}

static const Option ROWS[] = {
    BENCH_METHODS("some of the methods (default: all; `enfilade bake --help` lists them); hemicube-NAME is "
                  "the hemicube whose sides "
                  "a hidden-surface method fills"),
    {.name = "resolutions",
     .value = "N,..",
     .type = OPTION_OTHER,
     .take = take_resolutions,
     .help = "8 to 2000 each, 16 at most (default 50,71,100,141,200)"},
    {.name = "cullings",
     .value = "A,..",
     .type = OPTION_OTHER,
     .take = take_cullings,
     .help = "of none, depth, cells, plan, stab (default none,depth,stab)"},
    {.name = "shooters",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(shooters),
     .low = 1,
     .high = 10000,
     .help = "patches that shoot, @ (default 60)"},
    {.name = "rays",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(rays),
     .low = 1000,
     .high = 2000000000,
     .help = "of the reference, a shooter, @ (default 4000000)"},
    BENCH_SEED("of the reference"),
    {.name = "quick", .type = OPTION_FLAG, .at = BENCH_AT(quick), .help = "20 shooters, 300000 rays"},
    BENCH_CSV,
};

const Bench BENCH_FORMFACTORS = {
    .name = "formfactors",
    .about =
        "one shot by each form-factor method: time and error against random rays, work done; and how much "
        "faster than rays it is at equal error",
    BENCH_OPTIONS(ROWS),
    .run = measure_formfactors,
    .is_method = is_formfactors_method,
    .list = "bake",
};
