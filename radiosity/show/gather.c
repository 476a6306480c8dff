// gather.c - irradiance at a point: lamps by their visible parts in closed form, all else by samples that see light slope in each
// element, about the element's own mean. (Interpolated light itself has not quite the power of the elements, and is farther
// off than constant elements are; slopes about their means halve the error.)
//
// Source: M. C. Reichert, A Two-Pass Radiosity Method Driven by Lights and Viewer Position, 1992 (the last bounce is gathered
// where it is looked at).
#include "radiosity/show/gather.h"

#include "engine/core/error.h"
#include "radiosity/factors/analytic.h"

// How far in front of its face a point is looked for among the cells, metres: as patches are (mesh.c).
static const double IN_FRONT = 1e-6;

GatherOptions gather_default_options(void) {
    return (GatherOptions){.method = form_factor_method("hemisphere"),
                           .resolution = 100,
                           .culling = CULL_PORTALS,
                           .exact_lamps = true};
}

GatherOptions gather_exact_options(void) {
    return (GatherOptions){.method = form_factor_method("analytic"),
                           .resolution = 100,
                           .culling = CULL_PORTALS,
                           .exact_lamps = false,
                           .near = near_default_options()};
}

// The light that leaves an element, less its emission where lamps are exact: mean[c] + dot(slope[c], p) - offset[c].
typedef struct Leaving {
    double mean[3], offset[3];
    Vec3 slope[3];
} Leaving;

struct Gatherer {
    GatherScene scene;
    GatherOptions options;
    Viewer *viewer;
    FormFactor *rows;            // of the method
    FormFactor *samples;         // for slopes: the same, where it has samples; NULL: no slopes
    Leaving *leaving;            // [element_count]
    AnalyticOccluder *occluder;  // [face_count]
    Plane *edge;                 // [outline_count]
    bool any_lamp;
    NearGatherer *near;  // NULL: none
};

// As much of the slope as keeps the element's light at 0 or above: beside bright things elements are too coarse to be straight.
static void limit_slope(const Gatherer *self, int element, Leaving *out) {
    const Mesh *mesh = self->scene.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 centre = element_centroid(mesh, element);
    for (int c = 0; c < 3; c++) {
        double mean = self->scene.solution->radiosity[element][c], lowest = 0;
        for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++) {
            Vec3 p = vec3_sub(mesh->vertices[mesh->corners[i]], centre);
            lowest = fmin(lowest, vec3_dot(out->slope[c], p));
        }
        if (mean + lowest < 0) out->slope[c] = vec3_scale(out->slope[c], -mean / lowest);
        out->offset[c] = vec3_dot(out->slope[c], centre);
    }
}

// How the corners' light slopes, about their mean, in the face's axes.
static void fit_slope(const Gatherer *self, int element, Leaving *out) {
    const Mesh *mesh = self->scene.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 x, y, mean = {0};
    double xx = 0, xy = 0, yy = 0, bx[3] = {0}, by[3] = {0};
    view_axes(mesh->faces[e->face].plane.n, &x, &y);
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++)
        mean = vec3_add(mean, vec3_scale(mesh->vertices[mesh->corners[i]], 1.0 / e->corner_count));
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++) {
        Vec3 p = vec3_sub(mesh->vertices[mesh->corners[i]], mean);
        double u = vec3_dot(x, p), v = vec3_dot(y, p);
        xx += u * u, xy += u * v, yy += v * v;
        for (int c = 0; c < 3; c++) {
            bx[c] += self->scene.light->corner[i][c] * u;
            by[c] += self->scene.light->corner[i][c] * v;
        }
    }
    double det = xx * yy - xy * xy;
    if (!(det > 0)) return;
    for (int c = 0; c < 3; c++)
        out->slope[c] = vec3_add(vec3_scale(x, (bx[c] * yy - by[c] * xy) / det),
                                 vec3_scale(y, (by[c] * xx - bx[c] * xy) / det));
    limit_slope(self, element, out);
}

static void rgb3(Rgb from, double out[3]) {
    out[0] = (double)from.r;
    out[1] = (double)from.g;
    out[2] = (double)from.b;
}

static void find_leaving(Gatherer *self) {
    const Mesh *mesh = self->scene.mesh;
    for (int e = 0; e < mesh->element_count; e++) {
        Leaving *out = &self->leaving[e];
        double emitted[3];
        rgb3(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        if (self->scene.light) fit_slope(self, e, out);
        for (int c = 0; c < 3; c++)
            out->mean[c] =
                self->scene.solution->radiosity[e][c] - (self->options.exact_lamps ? emitted[c] : 0);
    }
    for (int f = 0; f < mesh->face_count && self->options.exact_lamps; f++)
        self->any_lamp = self->any_lamp || mesh_emits(mesh, f);
}

Gatherer *gatherer_new(const GatherScene *scene, const GatherOptions *options, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    FormFactorOptions rows = form_factor_default_options();
    Gatherer *self = ARENA_ARRAY(arena, Gatherer, 1);
    rows.resolution = options->resolution;
    self->scene = *scene;
    self->options = *options;
    self->viewer = viewer_new(mesh, scene->forest, scene->door_open, arena);
    self->rows = form_factor_new(options->method, mesh, &rows, arena);
    if (scene->light)
        self->samples = options->method->projective
                            ? self->rows
                            : form_factor_new(form_factor_method("hemisphere"), mesh, &rows, arena);
    self->leaving = ARENA_ARRAY(arena, Leaving, mesh->element_count);
    self->occluder = ARENA_ARRAY(arena, AnalyticOccluder, mesh->face_count);
    self->edge = ARENA_ARRAY(arena, Plane, mesh->outline_count);
    find_leaving(self);
    if (options->near.reach > 0) self->near = near_gatherer_new(mesh, scene->solution, &options->near, arena);
    return self;
}

void gatherer_end(Gatherer *self) {
    if (self->near) near_gatherer_end(self->near);
    if (self->samples && self->samples != self->rows) form_factor_end(self->samples);
    form_factor_end(self->rows);
}

static int find_occluders(Gatherer *self, const View *view) {
    int count = 0;
    Plane *edge = self->edge;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        AnalyticOccluder *o = &self->occluder[count];
        if (!analytic_occluder(view->vertices + f->first_vertex, f->vertex_count, form_factor_rank(f), edge,
                               o))
            continue;
        count++;
        edge += o->edge_count;
    }
    return count;
}

static void add_share(void *sum, const Vec3 *polygon, int count) {
    *(double *)sum += analytic_point(polygon, count);
}

static void add_lamps(Gatherer *self, const View *view, double irradiance[3]) {
    int occluders = -1;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        if (!mesh_emits(self->scene.mesh, f->face) || f->d > 0) continue;
        if (occluders < 0) occluders = find_occluders(self, view);
        double share = 0, emitted[3];
        rgb3(mesh_material(self->scene.mesh, f->face)->emission, emitted);
        analytic_visible(view->vertices + f->first_vertex, f->vertex_count, form_factor_rank(f),
                         self->occluder, occluders, add_share, &share);
        for (int c = 0; c < 3; c++) irradiance[c] += share * emitted[c];
    }
}

// The shares of near elements in the light, and what these would be if they shone evenly.
typedef struct Near {
    double share, even[3];
} Near;

// Takes note of an element's share if it is near; what it emits is known all the same.
static bool put_near(Gatherer *self, int element, double share, bool means, Near *near,
                     double irradiance[3]) {
    if (!self->near || !near_gatherer_is_near(self->near, element)) return false;
    if (!means) return true;
    double emitted[3] = {0};
    if (!self->options.exact_lamps)
        rgb3(mesh_material(self->scene.mesh, self->scene.mesh->elements[element].face)->emission, emitted);
    near->share += share;
    for (int c = 0; c < 3; c++) {
        irradiance[c] += share * emitted[c];
        near->even[c] += share * (self->leaving[element].mean[c] - emitted[c]);
    }
    return true;
}

static void add_near(Gatherer *self, const Near *near, double irradiance[3]) {
    double reflected[3];
    if (!(near->share > 0)) return;
    bool found = near_gatherer_mean(self->near, reflected);
    for (int c = 0; c < 3; c++) irradiance[c] += found ? near->share * reflected[c] : near->even[c];
}

static void gather_row(Gatherer *self, const View *view, Near *near, double irradiance[3]) {
    const Row *row = form_factor_row(self->rows, view);
    for (int i = 0; i < row->count; i++) {
        double share = (double)row->factor[i];
        if (put_near(self, row->element[i], share, true, near, irradiance)) continue;
        const double *mean = self->leaving[row->element[i]].mean;
        for (int c = 0; c < 3; c++) irradiance[c] += share * mean[c];
    }
    for (int c = 0; c < 3; c++) irradiance[c] += row->sky * M_PI * self->scene.solution->sky[c];
}

// Samples where they meet elements: slopes, and with `means` all of it.
static void add_samples(Gatherer *self, const View *view, bool means, Near *near, double irradiance[3]) {
    const FormFactorSamples *samples = form_factor_samples(self->samples);
    const int32_t *item = form_factor_items(self->samples, view);
    const double *sky = self->scene.solution->sky;
    for (int i = 0; i < samples->count; i++) {
        Vec3 w = vec3((double)samples->x[i], (double)samples->y[i], (double)samples->z[i]);
        double upwards = view->x.z * w.x + view->y.z * w.y + view->z.z * w.z;
        if (item[i] < 0) {
            for (int c = 0; c < 3 && means && upwards > 0; c++)
                irradiance[c] += (double)samples->weight[i] * M_PI * sky[c];
            continue;
        }
        const ViewFace *face = &view->faces[item[i]];
        double along = vec3_dot(face->n, w);
        if (face->d > 0 || !(along < 0)) continue;
        w = vec3_scale(w, face->d / along);
        Vec3 p = vec3_add(view->eye, vec3_add(vec3_scale(view->x, w.x),
                                              vec3_add(vec3_scale(view->y, w.y), vec3_scale(view->z, w.z))));
        int element = mesh_element_at(self->scene.mesh, face->face, p);
        if (put_near(self, element, (double)samples->weight[i], means, near, irradiance)) continue;
        const Leaving *from = &self->leaving[element];
        for (int c = 0; c < 3; c++) {
            double b = vec3_dot(from->slope[c], p) - from->offset[c] + (means ? from->mean[c] : 0);
            irradiance[c] += (double)samples->weight[i] * b;
        }
    }
}

void gather(Gatherer *self, const ViewPoint *from, double irradiance[3]) {
    const View *view = viewer_look(self->viewer, from, self->options.culling);
    bool one = self->samples == self->rows;
    Near near = {0};
    irradiance[0] = irradiance[1] = irradiance[2] = 0;
    if (self->near) near_gatherer_look(self->near, from->eye, from->normal);
    if (self->any_lamp) add_lamps(self, view, irradiance);
    if (!one) gather_row(self, view, &near, irradiance);
    if (self->samples) add_samples(self, view, one, &near, irradiance);
    add_near(self, &near, irradiance);
    // Samples may sum slopes to less than nothing beside exact means and exact lamps.
    for (int c = 0; c < 3; c++) irradiance[c] = fmax(irradiance[c], 0);
}

int gather_cell(const CellGraph *graph, Vec3 point, Vec3 normal, int hint) {
    return vis_locate(graph, vec3_add(point, vec3_scale(normal, IN_FRONT)), hint);
}
