// bench_narrow.c - narrow places: the light that a walk shows and the light that --probe gathers, against path tracing, at points half
// of which lie near the views of a building. Points and truth are kept beside each building, in a file that ends in .ref: a line each of
// polygon, place, normal, irradiance and its standard error.
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/bench/light/lit_points.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"

static const char NARROW_HEAD[] =
    "scene,method,elements,seconds,median,rms,p99,most,near_median,near_rms,near_p99,worst_room,points,"
    "truth_error\n";

enum { NARROW_SHOWN, NARROW_PROBE, NARROW_FINAL_GATHER, NARROW_METHODS, NARROW_WORST = 6, GATHERED = 50 };
static const char *const NARROW_NAMES[NARROW_METHODS] = {"shown", "probe", "final-gather"};

static bool is_narrow_method(const char *name) {
    for (int i = 0; i < NARROW_METHODS; i++)
        if (strcmp(NARROW_NAMES[i], name) == 0) return true;
    return false;
}

static void print_narrow_methods(void) {
    printf("    ways:               ");
    for (int i = 0; i < NARROW_METHODS; i++)
        printf("%s%s", NARROW_NAMES[i], i + 1 < NARROW_METHODS ? ", " : "\n");
}

// `building.plan` has `building.ref`.
static const char *truth_path(const char *file, Arena *arena) {
    const char *dot = strrchr(file, '.');
    return arena_format(arena, "%.*s.ref", (int)(dot ? dot - file : (ptrdiff_t)strlen(file)), file);
}

static bool keep_truth(const LightScene *s, Error *error) {
    Arena scratch = {0};
    Text text = {.arena = &scratch};
    text_append(
        &text, "# polygon, place, normal, irradiance and its standard error: enfilade bench narrow --keep\n");
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        text_append(&text, "%d %.17g %.17g %.17g %.17g %.17g %.17g %.6g %.2g\n", p->polygon, p->place.x,
                    p->place.y, p->place.z, p->normal.x, p->normal.y, p->normal.z, light_point_irradiance(p),
                    p->standard_error);
    }
    bool good = file_write(truth_path(s->file, &scratch), text.data, text.size, error);
    arena_free(&scratch);
    return good;
}

// Sums of channels are kept alone, so they count as light of one channel.
static bool read_truth(LightScene *s, Arena *arena, Error *error) {
    enum { LARGEST = 1 << 24 };
    Bytes bytes;
    const char *path = truth_path(s->file, arena);
    if (!file_read(path, LARGEST, arena, &bytes, error)) return false;
    LightPoints *points = &s->points;
    *points = (LightPoints){.points = ARENA_ARRAY(arena, LightPoint, bytes.size / 18 + 1)};
    for (char *line = strtok((char *)bytes.data, "\n"); line; line = strtok(NULL, "\n")) {
        LightPoint p = {0};
        if (*line == '#') continue;
        if (sscanf(line, "%d %lf %lf %lf %lf %lf %lf %lf %lf", &p.polygon, &p.place.x, &p.place.y, &p.place.z,
                   &p.normal.x, &p.normal.y, &p.normal.z, &p.truth[0], &p.standard_error) != 9 ||
            p.polygon < 0 || p.polygon >= s->scene.graph.polygon_count)
            return error_set(error, "%s: holds `%s` (allowed: a polygon of %s and 8 numbers)", path, line,
                             s->file);
        points->points[points->count++] = p;
        points->mean += p.truth[0];
    }
    if (points->count == 0) return error_set(error, "%s: holds no points", path);
    points->mean /= points->count;
    for (int i = 0; i < points->count; i++)
        points->points[i].scale = fmax(points->points[i].truth[0], LIT_DARK * points->mean);
    return true;
}

// The light that a walk shows, less the truth: exact light of lamps at nodes, or all light gathered at nodes, and linear between them.
static bool narrow_shown(const LightScene *s, LightBake *bake, bool final_gather, double *off, Arena *arena,
                         Error *error) {
    const Mesh *mesh;
    const RadSolution *light;
    if (final_gather)
        light_gather_vertices(s, bake, arena);
    else
        direct_show(&bake->mesh, &s->scene.forest, s->doors, 0, NULL, arena, &bake->solution, NULL);
    if (!shown_light(&bake->mesh, &bake->solution, s->doors, arena, &mesh, &light, error)) return false;
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, light, arena);
    VertexLight field = reconstruct_light(&bake->fine->mesh, &bake->shown, arena);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        double b[3];
        int face = bake->fine->mesh.face_of[p->polygon];
        const Material *m = mesh_material(&bake->fine->mesh, face);
        reconstruct_at(&bake->fine->mesh, &field, face, p->place, b);
        off[i] = light_reflects(m) ? light_irradiance_of(p, m, b) - light_point_irradiance(p) : NAN;
    }
    return true;
}

// Percent, over the points near views or over all.
static Spread narrow_spread(const LightScene *s, const double *off, bool near, double *p99) {
    Arena scratch = {0};
    LightPoints some = {.points = ARENA_ARRAY(&scratch, LightPoint, s->points.count + 1)};
    double *size = ARENA_ARRAY(&scratch, double, s->points.count + 1);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        if (isnan(off[i]) || (near && !lit_near_view(&s->scene.building, p->place, s->arguments->near)))
            continue;
        some.points[some.count] = *p;
        size[some.count++] = off[i];
    }
    Spread spread = lit_spread(&some, size, false);
    for (int i = 0; i < some.count; i++) size[i] = fabs(size[i] / some.points[i].scale);
    qsort(size, (size_t)some.count, sizeof *size, lit_by_size);
    *p99 = some.count > 0 ? 100 * size[(int)(0.99 * (some.count - 1) + 0.5)] : 0;
    arena_free(&scratch);
    return spread;
}

// The mean light of the points of a room, relative to its truth, of the room in which it is worst, percent. Rooms whose truth is less
// certain than KNOWN are left out.
static double worst_room(const LightScene *s, const double *off) {
    static const double KNOWN = 0.01;
    double worst = 0;
    const CellGraph *graph = &s->scene.graph;
    for (int r = 0; r < graph->building->region_count; r++) {
        double sum = 0, truth = 0, variance = 0;
        for (int i = 0; i < s->points.count; i++) {
            const LightPoint *p = &s->points.points[i];
            int cell = gather_cell(graph, p->place, p->normal, -1);
            if (isnan(off[i]) || cell < 0 || graph->cells[cell].region != r) continue;
            sum += off[i];
            truth += light_point_irradiance(p);
            variance += p->standard_error * p->standard_error;
        }
        if (graph->building->regions[r].kind != REGION_ROOM || !(truth > 0)) continue;
        if (s->arguments->verbose)
            fprintf(stderr, "%s: room %s is %+.2f %% off its truth, which is known to %.2f %%\n",
                    bench_name(s->file), graph->building->regions[r].name, 100 * sum / truth,
                    100 * sqrt(variance) / truth);
        if (sqrt(variance) <= KNOWN * truth && fabs(sum / truth) > fabs(worst)) worst = sum / truth;
    }
    return 100 * worst;
}

static void print_narrow_worst(const LightScene *s, const LightBake *bake, const char *method,
                               const double *off) {
    Arena scratch = {0};
    const Mesh *mesh = &bake->fine->mesh;
    bool *told = ARENA_ARRAY(&scratch, bool, s->points.count);
    for (int k = 0; k < NARROW_WORST; k++) {
        int worst = -1;
        for (int i = 0; i < s->points.count; i++) {
            const LightPoint *p = &s->points.points[i];
            if (told[i] || isnan(off[i])) continue;
            if (worst < 0 || fabs(off[i] / p->scale) > fabs(off[worst] / s->points.points[worst].scale))
                worst = i;
        }
        if (worst < 0) break;
        told[worst] = true;
        const LightPoint *p = &s->points.points[worst];
        const Element *e = &mesh->elements[mesh_element_at(mesh, mesh->face_of[p->polygon], p->place)];
        fprintf(stderr,
                "%s, %s: point %d, polygon %d, %.3f,%.3f,%.3f facing %.2f,%.2f,%.2f: %+.2f %% of %.4g W/m^2 "
                "(%.4g of the mean), element of %.3f m, %d corners\n",
                bench_name(s->file), method, worst, p->polygon, p->place.x, p->place.y, p->place.z,
                p->normal.x, p->normal.y, p->normal.z, 100 * off[worst] / p->scale, light_point_irradiance(p),
                light_point_irradiance(p) / s->points.mean, sqrt(e->area), e->corner_count);
    }
    arena_free(&scratch);
}

static void add_narrow_row(const LightScene *s, const LightBake *bake, int method, const double *off,
                           double seconds, Text *csv) {
    size_t before = csv->size;
    double p99, near99;
    int dark;
    Spread all = narrow_spread(s, off, false, &p99), near = narrow_spread(s, off, true, &near99);
    text_append(csv, "%s,%s,%d,%.2f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%.3f\n", bench_name(s->file),
                NARROW_NAMES[method], bake->fine->mesh.element_count, seconds, all.median, all.rms, p99,
                all.most, near.median, near.rms, near99, worst_room(s, off), all.count,
                lit_truth_error(&s->points, &dark));
    fputs(csv->data + before, stdout);
    fflush(stdout);
    if (s->arguments->verbose) print_narrow_worst(s, bake, NARROW_NAMES[method], off);
}

static bool narrow_of_file(const char *file, const BenchArguments *a, Text *csv, Error *error) {
    Arena arena = {0};
    LightScene s;
    LightBake bake;
    bool good = a->keep
                    ? light_scene_open(file, a, LIGHT_TRUTH_EACH, &arena, &s, error) && keep_truth(&s, error)
                    : light_scene_load(file, a, &arena, &s, error);
    good = good && read_truth(&s, &arena, error);
    if (good) {
        light_bake_defaults(&s, &bake);
        good = light_bake(&s, &arena, &bake, error);
    }
    if (good && bench_listed(a->methods, "probe")) {
        LightErrors errors = light_errors(&s, &bake, s.points.count, &arena);
        add_narrow_row(&s, &bake, NARROW_PROBE, errors.off[LIGHT_GATHERED], errors.gather_seconds, csv);
    }
    for (int method = 0; method < NARROW_METHODS && good; method++) {
        double begin = clock_seconds(), *off = ARENA_ARRAY(&arena, double, s.points.count);
        if (method == NARROW_PROBE || !bench_listed(a->methods, NARROW_NAMES[method])) continue;
        LightBake shown = bake;
        shown.gather = GATHERED;
        good = narrow_shown(&s, &shown, method == NARROW_FINAL_GATHER, off, &arena, error);
        if (good) add_narrow_row(&s, &shown, method, off, bake.seconds + clock_seconds() - begin, csv);
    }
    arena_free(&arena);
    return good;
}

static bool measure_narrow(const BenchArguments *a, Error *error) {
    BenchArguments own = *a;
    if (own.points == 0) own.points = 100;
    if (own.error == 0) own.error = 0.003;
    if (own.near == 0) own.near = 0.3;
    return bench_table(&own, NARROW_HEAD, NULL, narrow_of_file, error);
}

static const Option NARROW_ROWS[] = {
    BENCH_METHODS("some of the ways below (default: all)"),
    {.name = "keep",
     .type = OPTION_FLAG,
     .at = BENCH_AT(keep),
     .help = "chooses the points and traces their paths anew, and keeps both in the FILE that ends in .ref"},
    {.name = "near",
     .value = "R",
     .type = OPTION_NUMBER,
     .at = BENCH_AT(near),
     .low = 0.01,
     .high = 100,
     .help = "half of the points lie so near to a view of the building, metres, @ (default 0.3)"},
    BENCH_POINTS("100"),
    BENCH_ERROR("standard error of the truth, relative, @ (default 0.003)"),
    BENCH_SEED("of points and paths"),
    {.name = "verbose",
     .type = OPTION_FLAG,
     .at = BENCH_AT(verbose),
     .help = "the five worst points of each row on standard error"},
    BENCH_CSV,
};

const Bench BENCH_NARROW = {
    .name = "narrow",
    .about = "how right light is in narrow places, against path tracing at points half of which lie near the "
             "views "
             "of each building; percent of the irradiance there, or of a hundredth of the mean where that is "
             "more; "
             "near_: of the points near views; worst_room: the mean light of a room, where it is worst",
    BENCH_OPTIONS(NARROW_ROWS),
    .run = measure_narrow,
    .is_method = is_narrow_method,
    .print_methods = print_narrow_methods,
    .files =
        "tests/narrow/ajar.plan tests/narrow/bed.plan tests/narrow/corridor.plan tests/narrow/curtain.plan "
        "tests/narrow/niche.plan tests/narrow/shelves.plan tests/narrow/sideboard.plan "
        "tests/narrow/slit.plan tests/narrow/stairwell.plan tests/narrow/table.plan",
};
