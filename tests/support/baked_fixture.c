// baked_fixture.c - bakes with the defaults, and their errors.
#include "tests/support/baked_fixture.h"

#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/bake_probes.h"
#include "engine/scene/bake_mesh.h"
#include "radiosity/truth/path_tracer.h"

// A share of the mean of all points: darker points are measured against it.
static const double DARK = 0.1;
// A face so near to a point, metres, hides it.
static const double TOUCHING = 1e-4;

static double sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

RadReport baked_solve(Lit *lit, RadSolution *out) {
    Error error = {""};
    BakeOptions a = bake_default_options();
    VisOptions vis = vis_default_options();
    vis.threads = 1;
    cr_assert(vis_build_cells(lit->building, &vis, &lit->arena, &lit->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&lit->graph, &vis, NULL, &lit->arena, &lit->forest));
    AdaptScene scene = {&lit->graph, &lit->forest, NULL, NULL};
    a.mesh.element = mesh_fitting_element(&lit->graph);
    cr_assert(adapt_mesh(&scene, &a.mesh, &a.adapt, &a.rad, NULL, &lit->arena, &lit->mesh, &error), "%s",
              error.text);
    rad_fit(&lit->mesh, &a.rad);
    return lit_shoot(lit, &a.rad, out);
}

double baked_lost(const Lit *lit, const RadSolution *s) {
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double kept = s->absorbed[c] + s->escaped[c];
        for (int p = 0; p < s->patch_count; p++) kept += s->unshot[p][c] * lit->mesh.patches[p].area;
        if (s->emitted[c] > 0) worst = fmax(worst, fabs(1 - kept / s->emitted[c]));
    }
    return worst;
}

static bool among(const Mesh *mesh, int element, int first, int end) {
    int polygon = mesh->faces[mesh->elements[element].face].polygon;
    return polygon >= first && polygon < end;
}

// Evenly over elements: in triangles about the first corner, each as likely as it is large.
static Vec3 point_in(const Mesh *mesh, const Element *e, Random *random) {
    const int *corner = mesh->corners + e->first_corner;
    double left = random_unit(random) * e->area;
    for (int i = 1;; i++) {
        Vec3 v[3] = {mesh->vertices[corner[0]], mesh->vertices[corner[i]], mesh->vertices[corner[i + 1]]};
        double area = polygon_area(v, 3), far = sqrt(random_unit(random));
        if (left > area && i + 2 < e->corner_count) {
            left -= area;
            continue;
        }
        return vec3_lerp(v[0], vec3_lerp(v[1], v[2], random_unit(random)), far);
    }
}

static int element_at(const Mesh *mesh, int first, int end, double share) {
    double area = 0;
    for (int e = 0; e < mesh->element_count; e++)
        if (among(mesh, e, first, end)) area += mesh->elements[e].area;
    double left = share * area;
    int last = -1;
    for (int e = 0; e < mesh->element_count && left >= 0; e++)
        if (among(mesh, e, first, end)) left -= mesh->elements[last = e].area;
    cr_assert(last >= 0, "no element of polygons %d to %d", first, end);
    return last;
}

BakedPoint *baked_points(Lit *lit, int first, int end, int count) {
    const Mesh *mesh = &lit->mesh;
    Arena scratch = {0};
    Random random = {5};
    PathTracer *tracer = path_tracer_new(mesh, NULL, &scratch);
    BakedPoint *points = ARENA_ARRAY(&lit->arena, BakedPoint, count);
    for (int i = 0; i < count;) {
        const Element *e = &mesh->elements[element_at(mesh, first, end, random_unit(&random))];
        BakedPoint p = {.place = point_in(mesh, e, &random), .normal = mesh->faces[e->face].plane.n};
        if (path_tracer_open(tracer, p.place, p.normal, TOUCHING) > 0) points[i++] = p;
    }
    path_tracer_end(tracer);
    arena_free(&scratch);
    return points;
}

void baked_trace(const Lit *lit, double error, long long most_paths, BakedPoint *points, int count) {
    Arena scratch = {0};
    PathTracer *tracer = path_tracer_new(&lit->mesh, NULL, &scratch);
    PathQuery *query = ARENA_ARRAY(&scratch, PathQuery, count);
    PathResult *result = ARENA_ARRAY(&scratch, PathResult, count);
    for (int i = 0; i < count; i++)
        query[i] = (PathQuery){points[i].place, points[i].normal, error, 0, most_paths, (uint64_t)i + 1};
    path_tracer_irradiance(tracer, query, count, 0, result);
    for (int i = 0; i < count; i++) {
        points[i].truth = sum3(result[i].irradiance);
        points[i].standard_error = sum3(result[i].standard_error);
    }
    path_tracer_end(tracer);
    arena_free(&scratch);
}

// The irradiance of which so much is reflected.
static double arriving(const Material *m, const double b[3]) {
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += rho[c] > 0 ? (b[c] - (double)e[c]) / (double)rho[c] : 0;
    return sum;
}

// The face on which a point of the mesh lies, and which looks its way.
static int face_at(const Mesh *mesh, const BakedPoint *p) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        if (vec3_dot(face->plane.n, p->normal) < 0.9999 || fabs(plane_distance(face->plane, p->place)) > 1e-7)
            continue;
        bool inside = true;
        for (int i = 0; i < face->vertex_count; i++) {
            Vec3 a = mesh->vertices[mesh->outline[face->first_vertex + i]];
            Vec3 b = mesh->vertices[mesh->outline[face->first_vertex + (i + 1) % face->vertex_count]];
            inside &= vec3_dot(face->plane.n, vec3_cross(vec3_sub(b, a), vec3_sub(p->place, a))) > -1e-9;
        }
        if (inside) return f;
    }
    cr_assert_fail("no face at %g,%g,%g", p->place.x, p->place.y, p->place.z);
    return -1;
}

BakedErrors baked_errors(const Lit *lit, const RadSolution *s, const BakedPoint *points, int count) {
    Arena scratch = {0};
    const Mesh *mesh = &lit->mesh;
    VertexLight field = reconstruct_light(mesh, s, &scratch);
    Probes probes = {ARENA_ARRAY(&scratch, Probe, count), count, count};
    BakedErrors out = {0};
    double mean = 0;
    for (int i = 0; i < count; i++) {
        probes.probes[i] = (Probe){.place = points[i].place, .normal = points[i].normal};
        mean += points[i].truth / count;
    }
    bake_probes_gather(&(GatherScene){mesh, &lit->forest, NULL, s, NULL}, 1, &probes);
    for (int i = 0; i < count; i++) {
        double truth = points[i].truth, scale = fmax(truth, DARK * mean), light[3];
        int face = face_at(mesh, &points[i]);
        reconstruct_at(mesh, &field, face, points[i].place, light);
        double here = sum3(probes.probes[i].irradiance), gathered = fabs(here - truth) / scale;
        double shown = fabs(arriving(mesh_material(mesh, face), light) - truth) / scale;
        out.gathered_rms += gathered * gathered / count;
        out.shown_rms += shown * shown / count;
        out.gathered_most = fmax(out.gathered_most, gathered);
        out.shown_most = fmax(out.shown_most, shown);
        out.truth += points[i].standard_error / scale / count;
        out.sum += here / mean / count;
        out.sum_error += points[i].standard_error * points[i].standard_error;
    }
    out.sum_error = sqrt(out.sum_error) / (mean * count);
    out.gathered_rms = sqrt(out.gathered_rms);
    out.shown_rms = sqrt(out.shown_rms);
    arena_free(&scratch);
    return out;
}

void baked_print(const char *name, const BakedErrors *e) {
    printf("%s: all %.2f %% off (truth to %.2f %%); gathered %.2f %% (most %.2f %%), shown %.2f %% (most "
           "%.2f %%), "
           "truth to %.2f %%\n",
           name, 100 * (e->sum - 1), 100 * e->sum_error, 100 * e->gathered_rms, 100 * e->gathered_most,
           100 * e->shown_rms, 100 * e->shown_most, 100 * e->truth);
}

BakedBuilding *baked_building(const char *path, double residual) {
    Error error;
    BakedBuilding *b = calloc(1, sizeof *b);
    BakeOptions a = bake_default_options();
    SceneOptions load = scene_default_options();
    load.lamps = SCENE_LAMPS_ALL;
    cr_assert(b && scene_load(path, &load, &b->arena, &b->scene, &error), "%s", error.text);
    cr_assert(bake_mesh(&a, &b->scene, NULL, NULL, &b->arena, &b->doors, &b->mesh, &error), "%s", error.text);
    cr_assert(rad_start(&b->mesh, &b->arena, &b->solution, &error), "%s", error.text);
    a.rad.residual = residual;
    rad_fit(&b->mesh, &a.rad);
    rad_shoot(&b->mesh, &b->scene.forest, b->doors, &a.rad, NULL, &b->solution);
    return b;
}

void baked_building_free(BakedBuilding *b) {
    arena_free(&b->arena);
    free(b);
}
