// hemicube_hidden.h - a hemicube whose sides are filled by a method of visibility/hidden.
#ifndef RADIOSITY_HEMICUBE_HIDDEN_H
#define RADIOSITY_HEMICUBE_HIDDEN_H

#include "radiosity/factors/form_factor.h"

typedef struct HemicubeHidden HemicubeHidden;

// `method` is the name of one of HIDDEN_METHODS. Draws all faces of the mesh, whatever the view holds.
HemicubeHidden *hemicube_hidden_new(const Mesh *mesh, const char *method, int resolution, Arena *arena);
void hemicube_hidden_end(HemicubeHidden *self);
const FormFactorSamples *hemicube_hidden_samples(const HemicubeHidden *self);
void hemicube_hidden_items(HemicubeHidden *self, const View *view, int32_t *item, FormFactorWork *work);

#endif
