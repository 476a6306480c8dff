// light_scene.c - a building for the benches of light: read, lit by path tracing at random points, baked, and compared there.
#include "engine/bench/light_scene.h"

#include <stdio.h>

#include "engine/app/bake.h"
#include "engine/core/clock.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/final_gather.h"

const char *const LIGHT_COMPARED_NAMES[LIGHT_COMPARED] = {"gather", "element", "vertex"};

// Edge of the elements that points are chosen on, metres: a mesh of their own, so that they stay where they are whatever the
// default becomes.
static const double CHOSEN_ON = 1;

static bool make_points(LightScene *s, LightTruth kind, Arena *arena, Error *error) {
    Arena scratch = {0};
    MeshOptions options = mesh_default_options();
    options.element = CHOSEN_ON;
    Mesh mesh;
    const BenchArguments *a = s->arguments;
    bool good = mesh_build(&s->scene.graph, s->vertices, s->doors, &options, &scratch, &mesh, error) &&
                light_points_choose(&mesh, a->points, a->seed, arena, &s->points, error);
    if (good) {
        light_points_trace(&mesh, a->sky, kind, a->error, a->seed, &s->points);
        fprintf(stderr, "%s: %lld paths to %d points in %.1f s, mean irradiance %.4g W/m^2\n",
                bench_name(s->file), s->points.paths, s->points.count, s->points.seconds, s->points.mean);
    }
    arena_free(&scratch);
    return good;
}

bool light_scene_open(const char *file, const BenchArguments *a, LightTruth kind, Arena *arena,
                      LightScene *out, Error *error) {
    *out = (LightScene){.file = file, .arguments = a};
    SceneOptions options = a->load;
    options.lamps = SCENE_LAMPS_ALL;
    if (!app_load(file, &options, arena, &out->scene, error) || !scene_has_walls(&out->scene, error))
        return false;
    out->doors = bake_doors(&out->scene.building, BAKE_DOORS_DRAWN, arena);
    out->vertices = bake_vertices(&out->scene.graph, out->doors, arena);
    return make_points(out, kind, arena, error);
}

// ---- a bake

void light_bake_defaults(const LightScene *scene, LightBake *out) {
    *out = (LightBake){
        .options = mesh_default_options(), .adapt = adapt_default_options(), .rad = rad_default_options()};
    out->options.element = mesh_fitting_element(&scene->scene.graph);
    out->rad.residual = 0;
    out->rad.form_factor.resolution = 0;
    memcpy(out->adapt.sky, scene->arguments->sky, sizeof out->adapt.sky);
}

// At all vertices: what is between corners then tells.
static void gather_vertices(const LightScene *s, LightBake *bake, Arena *arena) {
    Arena scratch = {0};
    VertexLight light = reconstruct_light(&bake->mesh, &bake->solution, &scratch);
    GatherScene scene = {&bake->mesh, &s->scene.forest, s->doors, &bake->solution, &light};
    GatherOptions options = gather_default_options();
    options.resolution = bake->gather;
    final_gather(&scene, &options, 0, NULL, arena, &bake->solution);
    arena_free(&scratch);
}

bool light_bake(const LightScene *s, Arena *arena, LightBake *bake, Error *error) {
    const CellGraph *graph = &s->scene.graph;
    AdaptScene lit = {graph, s->vertices, &s->scene.forest, s->doors};
    Mesh *mesh = &bake->mesh;
    const double *sky = s->arguments->sky, begin = clock_seconds(), worked = clock_work_seconds();
    bake->options.proxies = proxies_find(graph, s->vertices, bake->options.proxy, arena);
    bool good = bake->adapt.share > 0
                    ? adapt_mesh(&lit, &bake->options, &bake->adapt, &bake->rad, NULL, arena, mesh, error)
                    : mesh_build(graph, s->vertices, s->doors, &bake->options, arena, mesh, error);
    if (!good || !rad_start_dark(mesh, arena, &bake->solution, error)) return false;
    bake->mesh_seconds = clock_seconds() - begin;
    rad_fit(mesh, &bake->rad);
    if (sky[0] + sky[1] + sky[2] > 0)
        rad_shine(mesh, &s->scene.forest, s->doors, &bake->rad, sky, NULL, &bake->solution);
    bake->report = rad_shoot(mesh, &s->scene.forest, s->doors, &bake->rad, NULL, &bake->solution);
    if (bake->gather > 0) gather_vertices(s, bake, arena);
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, &bake->solution, arena);
    bake->seconds = clock_seconds() - begin;
    bake->work_seconds = clock_work_seconds() - worked;
    return true;
}

// ---- errors

// Irradiance from what is reflected; channels that are not count as right.
static double irradiance_of(const LightPoint *p, const Material *m, const double b[3]) {
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += rho[c] > 0 ? (b[c] - (double)e[c]) / (double)rho[c] : p->truth[c];
    return sum;
}

static bool reflects(const Material *m) {
    return m->reflectance.r > 0 || m->reflectance.g > 0 || m->reflectance.b > 0;
}

static void gather_points(const LightScene *s, const LightBake *bake, int gathering, LightErrors *out) {
    Arena scratch = {0};
    Probes probes = {ARENA_ARRAY(&scratch, Probe, gathering + 1), gathering, gathering};
    for (int i = 0; i < gathering; i++)
        probes.probes[i] = (Probe){.place = s->points.points[i].place, .normal = s->points.points[i].normal};
    double begin = clock_seconds();
    GatherScene scene = {&bake->fine->mesh, &s->scene.forest, s->doors, &bake->shown, NULL};
    if (gathering > 0) bake_probes_gather(&scene, &probes);
    out->gather_seconds = clock_seconds() - begin;
    for (int i = 0; i < gathering; i++) {
        const double *h = probes.probes[i].irradiance;
        out->off[LIGHT_GATHERED][i] = h[0] + h[1] + h[2] - light_point_irradiance(&s->points.points[i]);
    }
    arena_free(&scratch);
}

LightErrors light_errors(const LightScene *s, const LightBake *bake, int gathering, Arena *arena) {
    LightErrors out = {0};
    Arena scratch = {0};
    const Mesh *mesh = &bake->fine->mesh;
    VertexLight field = reconstruct_light(mesh, &bake->shown, &scratch);
    for (int what = 0; what < LIGHT_COMPARED; what++)
        out.off[what] = ARENA_ARRAY(arena, double, s->points.count);
    for (int i = 0; i < s->points.count; i++) {
        const LightPoint *p = &s->points.points[i];
        int face = mesh->face_of[p->polygon];
        const Material *m = mesh_material(mesh, face);
        const double *own = bake->shown.radiosity[mesh_element_at(mesh, face, p->place)];
        double light[3], truth = light_point_irradiance(p);
        reconstruct_at(mesh, &field, face, p->place, light);
        out.off[LIGHT_GATHERED][i] = NAN;
        out.off[LIGHT_OF_ELEMENT][i] = reflects(m) ? irradiance_of(p, m, own) - truth : NAN;
        out.off[LIGHT_BETWEEN_CORNERS][i] = reflects(m) ? irradiance_of(p, m, light) - truth : NAN;
    }
    arena_free(&scratch);
    gather_points(s, bake, gathering < s->points.count ? gathering : s->points.count, &out);
    return out;
}

// The scatter of the truth itself is no error of ours.
double light_errors_rms(const LightScene *s, const double *off) {
    double squares = 0, scatter = 0;
    int count = 0;
    for (int i = 0; i < s->points.count; i++) {
        double uncertain = s->points.points[i].standard_error;
        if (isnan(off[i])) continue;
        squares += off[i] * off[i];
        scatter += uncertain * uncertain;
        count++;
    }
    return count > 0 && s->points.mean > 0 ? 100 * sqrt(fmax(squares - scatter, 0) / count) / s->points.mean
                                           : 0;
}
