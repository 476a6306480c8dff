// ray.c - form factors by rays (Embree): the baseline that the other methods are measured against. The directions are those of the
// hemisphere's base or of the hemicube, cast eight at a time, 4 x 2 neighbours together.
#include <math.h>

#include "radiosity/factors/row.h"
#include "radiosity/factors/sample_grids.h"
#include "radiosity/methods/ray_caster.h"

enum { TILE_WIDTH = 4, TILE_HEIGHT = 2 };

typedef struct RayMethod {
    const Mesh *mesh;
    RayCaster *scene;
    FormFactorSamples samples;  // in packets of eight, the last one filled up with zeros
    int *item_of;  // [face_count] a face's index in the view, valid where its stamp equals `look`
    int *stamp, look;
} RayMethod;

static void add_tile(const SampleGrid *grid, double turn, int i0, int j0, FormFactorSamples *s, double *sum) {
    for (int k = 0; k < TILE_WIDTH * TILE_HEIGHT; k++) {
        int i = i0 + k % TILE_WIDTH, j = j0 + k / TILE_WIDTH;
        double w[3], weight;
        if (i >= grid->width || j >= grid->height || !grid->at(grid, i, j, w, &weight)) continue;
        double length = vec3_length(vec3(w[0], w[1], w[2]));
        s->x[s->count] = (float)((w[0] * cos(turn) - w[1] * sin(turn)) / length);
        s->y[s->count] = (float)((w[0] * sin(turn) + w[1] * cos(turn)) / length);
        s->z[s->count] = (float)(w[2] / length);
        s->weight[s->count++] = (float)weight;
        *sum += weight;
    }
}

static FormFactorSamples samples_of(const SampleGrid *grids, int grid_count, double turn, Arena *arena) {
    int most = LANES;
    for (int g = 0; g < grid_count; g++) most += grids[g].width * grids[g].height;
    FormFactorSamples s = {.x = ARENA_ARRAY(arena, float, most),
                           .y = ARENA_ARRAY(arena, float, most),
                           .z = ARENA_ARRAY(arena, float, most),
                           .weight = ARENA_ARRAY(arena, float, most)};
    double sum = 0;
    for (int g = 0; g < grid_count; g++)
        for (int j = 0; j < grids[g].height; j += TILE_HEIGHT)
            for (int i = 0; i < grids[g].width; i += TILE_WIDTH) add_tile(&grids[g], turn, i, j, &s, &sum);
    for (int i = 0; i < s.count; i++) s.weight[i] = (float)((double)s.weight[i] / sum);
    return s;
}

static RayMethod *ray_start(const Mesh *mesh, const SampleGrid *grids, int grid_count, double turn,
                            Arena *arena) {
    RayMethod *self = ARENA_ARRAY(arena, RayMethod, 1);
    self->mesh = mesh;
    self->scene = ray_caster_new(mesh, arena);
    self->samples = samples_of(grids, grid_count, turn, arena);
    self->item_of = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    self->stamp = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    return self;
}

static void *start_disc(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_disc(options->resolution, grids);
    return ray_start(mesh, grids, count, GRIDS_TURN, arena);
}

static void *start_hemicube(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_hemicube(options->resolution, grids);
    return ray_start(mesh, grids, count, 0, arena);
}

static void stop(void *self) { ray_caster_end(((RayMethod *)self)->scene); }

static const FormFactorSamples *ray_samples(void *self) { return &((RayMethod *)self)->samples; }

static Lane load(const float *from) {
    Lane a;
    memcpy(&a, from, sizeof a);
    return a;
}

// Casts rays along samples first .. first + 7; returns how many of these samples there are.
static int cast(const RayMethod *self, const View *view, int first, int32_t face[LANES],
                int32_t element[LANES]) {
    static const LaneInt INDEX = {0, 1, 2, 3, 4, 5, 6, 7};
    const FormFactorSamples *s = &self->samples;
    int count = s->count - first < LANES ? s->count - first : LANES;
    Lane x = load(s->x + first), y = load(s->y + first), z = load(s->z + first);
    RayEight rays = {
        (float)view->x.x * x + (float)view->y.x * y + (float)view->z.x * z,
        (float)view->x.y * x + (float)view->y.y * y + (float)view->z.y * z,
        (float)view->x.z * x + (float)view->y.z * y + (float)view->z.z * z,
    };
    ray_caster_cast(self->scene, view->eye, view->z, &rays, INDEX < lane_int_of(count), true, face, element);
    return count;
}

static void ray_items(void *data, const View *view, int32_t *item, FormFactorWork *work) {
    RayMethod *self = data;
    self->look++;
    for (int i = 0; i < view->face_count; i++) {
        self->item_of[view->faces[i].face] = i;
        self->stamp[view->faces[i].face] = self->look;
    }
    for (int i = 0; i < self->samples.count; i += LANES) {
        int32_t face[LANES], element[LANES];
        int count = cast(self, view, i, face, element);
        for (int k = 0; k < count; k++) {
            bool seen = face[k] >= 0 && self->stamp[face[k]] == self->look;
            item[i + k] = seen ? self->item_of[face[k]] : -1;
        }
    }
    work->samples += self->samples.count;
    work->tests += self->samples.count;
}

static void add_nothing(const RayMethod *self, const View *view, int i, RowSum *sum) {
    const FormFactorSamples *s = &self->samples;
    row_escape(sum, view, (double)s->weight[i], row_direction(view, s, i));
}

// Uses only the eye and the axes of the view: the rays find the faces themselves.
static void ray_row(void *data, const View *view, RowSum *sum, FormFactorWork *work) {
    RayMethod *self = data;
    for (int i = 0; i < self->samples.count; i += LANES) {
        int32_t face[LANES], element[LANES];
        int count = cast(self, view, i, face, element);
        for (int k = 0; k < count; k++) {
            double share = (double)self->samples.weight[i + k];
            if (element[k] >= 0)
                row_add(sum, element[k], share);
            else if (face[k] >= 0)
                sum->back += share;
            else
                add_nothing(self, view, i + k, sum);
        }
    }
    work->samples += self->samples.count;
    work->tests += self->samples.count;
}

static void *start_plain_disc(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_disc(options->resolution, grids);
    return ray_start(mesh, grids, count, 0, arena);
}

// The usual way to cast rays: the grid is aligned with the view's axes.
const FormFactorMethod FORM_FACTOR_RAY_DISC = {
    .name = "ray-disc",
    .summary = "the same, the pixels not turned",
    .truth = FORM_FACTOR_FLOAT,
    .whole_mesh = true,
    .projective = true,
    .start = start_plain_disc,
    .stop = stop,
    .samples = ray_samples,
    .items = ray_items,
    .row = ray_row,
};

const FormFactorMethod FORM_FACTOR_RAY = {
    .name = "ray",
    .summary = "rays through the pixels of a hemisphere's base (Embree)",
    .truth = FORM_FACTOR_FLOAT,
    .whole_mesh = true,
    .projective = true,
    .start = start_disc,
    .stop = stop,
    .samples = ray_samples,
    .items = ray_items,
    .row = ray_row,
};

const FormFactorMethod FORM_FACTOR_RAY_HEMICUBE = {
    .name = "ray-hemicube",
    .summary = "rays through the pixels of a hemicube (Embree)",
    .truth = FORM_FACTOR_FLOAT,
    .whole_mesh = true,
    .projective = true,
    .start = start_hemicube,
    .stop = stop,
    .samples = ray_samples,
    .items = ray_items,
    .row = ray_row,
};
