// hemicube.c - form factors by the hemicube (Cohen & Greenberg 1985): the pixels of a half cube about the point, R x R on its
// top and R x R/2 on each side. Each pixel has a delta form factor, its area times 1 / (pi (x^2 + y^2 + 1)^2) on the top or
// z / (pi (y^2 + z^2 + 1)^2) on the sides; all are scaled to sum 1.
//
// Departure: the side of each edge's plane on which a pixel's direction lies decides the pixel, so nothing is projected or clipped
// (sampler.h). Instead, a hidden-surface method may fill the sides (HemicubeHidden).
#include <math.h>

#include "radiosity/factors/form_factor.h"
#include "radiosity/factors/row.h"
#include "radiosity/factors/sample_grids.h"
#include "radiosity/factors/sampler.h"
#include "visibility/hidden/hidden.h"

typedef struct HemicubeHidden HemicubeHidden;

// ---- Cohen & Greenberg's hemicube as they drew it: five pictures of 90 degrees, by any hidden-surface method; in the
// pictures of the sides only the half above the horizon counts.

struct HemicubeHidden {
    const Mesh *mesh;
    const HiddenMethod *method;
    void *prepared;
    Arena scratch;  // memory of the method
    SampleGrid grids[MOST_GRIDS];
    int grid_count;
    ItemBuffer buffer;
    FormFactorSamples samples;  // grid by grid, row by row
    int *item_of, *stamp,
        look;  // [face_count] a face's index in the view, valid where its stamp equals `look`
};

static Scene scene_of(const Mesh *mesh, Arena *arena) {
    Polygon *polygons = ARENA_ARRAY(arena, Polygon, mesh->face_count + 1);
    Vec3 *vertices = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);
    for (int i = 0; i < mesh->outline_count; i++) vertices[i] = mesh->vertices[mesh->outline[i]];
    for (int f = 0; f < mesh->face_count; f++)
        polygons[f] = (Polygon){.first_vertex = mesh->faces[f].first_vertex,
                                .vertex_count = mesh->faces[f].hidden ? 0 : mesh->faces[f].vertex_count};
    return (Scene){.polygons = polygons, .vertices = vertices, .count = mesh->face_count};
}

static void make_samples(HemicubeHidden *self, Arena *arena) {
    int most = 0;
    for (int g = 0; g < self->grid_count; g++) most += self->grids[g].width * self->grids[g].height;
    FormFactorSamples s = {.x = ARENA_ARRAY(arena, float, most),
                           .y = ARENA_ARRAY(arena, float, most),
                           .z = ARENA_ARRAY(arena, float, most),
                           .weight = ARENA_ARRAY(arena, float, most)};
    double sum = 0;
    for (int at = 0, g = 0; g < self->grid_count; g++) {
        const SampleGrid *grid = &self->grids[g];
        for (int k = 0; k < grid->width * grid->height; k++, at++) {
            double w[3], weight = 0;
            grid->at(grid, k % grid->width, k / grid->width, w, &weight);
            double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
            s.x[at] = (float)(w[0] / length);
            s.y[at] = (float)(w[1] / length);
            s.z[at] = (float)(w[2] / length);
            s.weight[at] = (float)weight;
            sum += weight;
        }
    }
    s.count = most;
    for (int i = 0; i < most; i++) s.weight[i] = (float)((double)s.weight[i] / sum);
    self->samples = s;
}

// `method` is the name of one of HIDDEN_METHODS. All faces of the mesh are drawn, also those that a view leaves out.
static HemicubeHidden *hemicube_hidden_new(const Mesh *mesh, const char *method, int resolution,
                                           Arena *arena) {
    HemicubeHidden *self = ARENA_ARRAY(arena, HemicubeHidden, 1);
    Scene scene = scene_of(mesh, arena);
    Error error;
    self->mesh = mesh;
    self->method = hidden_find(method);
    CORE_ASSERT(self->method != NULL);
    self->prepared = self->method->begin(&scene, &self->scratch, &error);
    CORE_ASSERT(self->prepared != NULL);
    self->grid_count = grids_of_hemicube(resolution, self->grids);
    // With an odd resolution, pictures of sides have one more row.
    self->buffer = item_buffer_new(arena, resolution, resolution + 1);
    self->item_of = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    self->stamp = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    make_samples(self, arena);
    return self;
}

static void hemicube_hidden_end(HemicubeHidden *self) {
    if (self->method->end) self->method->end(self->prepared);
    arena_free(&self->scratch);
}

static const FormFactorSamples *hemicube_hidden_samples(const HemicubeHidden *self) { return &self->samples; }

// The camera of a grid. On top, row 0 of the picture is row 0 of the grid. In the picture of a side, which is upright and seen from
// within, rows and columns run the other way.
static Camera camera_of(const SampleGrid *grid, bool top, const View *view) {
    double w[3], weight;
    Camera camera = {.eye = view->eye, .tan_x = 1, .tan_y = 1, .width = grid->width};
    camera.height = top ? grid->height : 2 * grid->height;
    if (top) {
        camera.forward = view->z;
        camera.right = view->x;
        camera.up = vec3_scale(view->y, -1);
        return camera;
    }
    // The camera looks along the axis through the middle of the side's lowest row.
    grid->at(grid, 0, 0, w, &weight);
    double u = 1 / (double)grid->width - 1, size = 1 + u * u;
    // (w[0], w[1]) is ahead + u * left, where `left` is a quarter turn from `ahead`.
    double ahead[2] = {(w[0] + u * w[1]) / size, (w[1] - u * w[0]) / size};
    camera.forward = vec3_add(vec3_scale(view->x, ahead[0]), vec3_scale(view->y, ahead[1]));
    camera.up = view->z;
    camera.right = vec3_cross(camera.forward, camera.up);
    return camera;
}

static int item_at(const HemicubeHidden *self, int face) {
    return face >= 0 && self->stamp[face] == self->look ? self->item_of[face] : -1;
}

static void hemicube_hidden_items(HemicubeHidden *self, const View *view, int32_t *item,
                                  FormFactorWork *work) {
    self->look++;
    for (int i = 0; i < view->face_count; i++) {
        self->item_of[view->faces[i].face] = i;
        self->stamp[view->faces[i].face] = self->look;
    }
    for (int g = 0; g < self->grid_count; g++) {
        const SampleGrid *grid = &self->grids[g];
        bool top = g == 0;
        Camera camera = camera_of(grid, top, view);
        self->buffer.width = camera.width;
        self->buffer.height = camera.height;
        Error error;
        bool drawn = hidden_draw(self->method, self->prepared, &camera, &self->buffer, NULL, &error);
        CORE_ASSERT(drawn);
        for (int k = 0; k < grid->width * grid->height; k++) {
            int i = k % grid->width, j = k / grid->width;
            int column = top ? i : grid->width - 1 - i, row = top ? j : grid->height - 1 - j;
            *item++ = item_at(self, self->buffer.item[row * camera.width + column]);
        }
    }
    work->samples += self->samples.count;
}

typedef struct Hemicube {
    Sampler *sampler;
    HemicubeHidden *hidden;  // used instead of the sampler where the options name a method; else NULL
    int32_t *item;           // [samples] scratch for `hidden`
} Hemicube;

static void *hemicube_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    Hemicube *self = ARENA_ARRAY(arena, Hemicube, 1);
    if (options->hidden) {
        self->hidden = hemicube_hidden_new(mesh, options->hidden, options->resolution, arena);
        self->item = ARENA_ARRAY(arena, int32_t, hemicube_hidden_samples(self->hidden)->count);
    } else {
        int count = grids_of_hemicube(options->resolution, grids);
        self->sampler = sampler_new(mesh, options->lines, grids, count, 0, arena);
    }
    return self;
}

static void stop(void *data) {
    Hemicube *self = data;
    if (self->hidden) hemicube_hidden_end(self->hidden);
}

static const FormFactorSamples *hemicube_samples(void *data) {
    Hemicube *self = data;
    return self->hidden ? hemicube_hidden_samples(self->hidden) : sampler_samples(self->sampler);
}

static void hemicube_items(void *data, const View *view, int32_t *item, FormFactorWork *work) {
    Hemicube *self = data;
    if (self->hidden) {
        hemicube_hidden_items(self->hidden, view, item, work);
        return;
    }
    sampler_draw(self->sampler, view, work);
    sampler_items(self->sampler, item);
}

static void hemicube_row(void *data, const View *view, RowSum *sum, FormFactorWork *work) {
    Hemicube *self = data;
    if (self->hidden) {
        hemicube_hidden_items(self->hidden, view, self->item, work);
        row_of_items(sum, view, hemicube_hidden_samples(self->hidden), self->item);
        return;
    }
    sampler_draw(self->sampler, view, work);
    sampler_row(self->sampler, view, sum);
}

const FormFactorMethod FORM_FACTOR_HEMICUBE = {
    .name = "hemicube",
    .summary = "pixels of a half cube with their delta form factors",
    .projective = true,
    .mended = true,
    .start = hemicube_start,
    .stop = stop,
    .samples = hemicube_samples,
    .items = hemicube_items,
    .row = hemicube_row,
};
