// element_buffer.h - item buffers as the first papers drew them: every element is projected, clipped and drawn by itself, at
// the cost that the tables of these papers report. The methods of form_factor.h draw faces instead, and are exact.
#ifndef RADIOSITY_ELEMENT_BUFFER_H
#define RADIOSITY_ELEMENT_BUFFER_H

#include "radiosity/factors/row.h"

enum {
    ELEMENT_HEMICUBE,   // Cohen & Greenberg 1985: five sides
    ELEMENT_HEMISPHERE  // Doi & Itoh: one base disc
};

enum { ELEMENT_MOST_SIDES = 5 };

typedef struct ElementBuffer ElementBuffer;

ElementBuffer *element_buffer_new(const Mesh *mesh, int kind, int resolution, Arena *arena);
int element_buffer_sides(const ElementBuffer *self);
// Empties the buffers for a point.
void element_buffer_start(ElementBuffer *self, const ViewPoint *from);
// The four planes of a side's view volume, as for Eye; returns the number of planes, 0 where the side takes all directions.
int element_buffer_frustum(const ElementBuffer *self, int side, Plane out[4]);
// Draws the elements of `faces` [face_count] on a side; returns how many elements these faces have.
long long element_buffer_draw(ElementBuffer *self, int side, const int *faces, int face_count);
// Adds the weights of the pixels to the elements drawn there.
void element_buffer_sum(const ElementBuffer *self, RowSum *sum);

#endif
