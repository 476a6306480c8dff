// osmesa.h - the item buffer drawn by OpenGL in memory.
#ifndef VISIBILITY_OSMESA_H
#define VISIBILITY_OSMESA_H

#include "visibility/hidden/hidden.h"

extern const HiddenMethod HIDDEN_OSMESA;

#endif
