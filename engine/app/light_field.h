// light_field.h - the light of a solution as it lies on the surfaces, without a gather: what a walk shows.
#ifndef APP_LIGHT_FIELD_H
#define APP_LIGHT_FIELD_H

#include "radiosity/shoot.h"

typedef struct LightField {
    const Mesh *mesh;
    const RadSolution *solution;
    double (*corners)
        [3];  // [corner_count] as Mesh.corners: the mean of elements around a place in one plane and of one
              // material, W/m^2
} LightField;
LightField light_field(const Mesh *mesh, const RadSolution *solution, Arena *arena);

// B at a point of a polygon of the graph, W/m^2 a channel: of the element there; and between its corners.
void light_field_element(const LightField *field, int polygon, Vec3 point, double radiosity[3]);
void light_field_vertex(const LightField *field, int polygon, Vec3 point, double radiosity[3]);

#endif
