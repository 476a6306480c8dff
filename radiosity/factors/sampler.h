// sampler.h - which face is seen along each of many directions: the one rasteriser behind the projective methods.
//
// Directions lie in blocks of 8 x 8 neighbours, 16 blocks to a group; a box about the directions of each block and group tells
// which faces cannot reach it. The result is exact: no projection, no clipping, no depth that is linear in the wrong space.
#ifndef RADIOSITY_SAMPLER_H
#define RADIOSITY_SAMPLER_H

#include "radiosity/factors/form_factor.h"
#include "radiosity/factors/sample_grids.h"
#include "radiosity/mesh/lines.h"

enum { SAMPLER_BLOCK = 8 };  // samples along the side of a block

typedef struct Sampler Sampler;

// The samples of all grids, turned about z by `turn`, radians; weights are scaled to sum 1. `lines` are the lines of the mesh;
// NULL: sampler_new finds them.
Sampler *sampler_new(const Mesh *mesh, const FaceLines *lines, const SampleGrid *grids, int grid_count,
                     double turn, Arena *arena);
// A sampler of other samples, as many at most, that shares its tables of the mesh with `like`: only one of them at a time may be used.
Sampler *sampler_new_like(const Sampler *like, const SampleGrid *grids, int grid_count, Arena *arena);
const FormFactorSamples *sampler_samples(const Sampler *self);

// Draws the faces in view. Where a face's edge is part of a longer line, the ends of the line come from the mesh.
void sampler_draw(Sampler *self, const View *view, FormFactorWork *work);
// The face that each sample saw in the last drawing, as an index of view->faces; -1: none.
void sampler_items(const Sampler *self, int32_t *item);
// The last drawing as shares of elements, added to `sum`.
void sampler_row(Sampler *self, const View *view, RowSum *sum);

#endif
