// fine_sources.h - from where on a stand-in each fine element has its light.
#ifndef RADIOSITY_FINE_SOURCES_H
#define RADIOSITY_FINE_SOURCES_H

#include "radiosity/show/fine_mesh.h"

// [fine->source_count], of a mesh that is joined and whose light has nodes.
FineSource *fine_sources(const FineMesh *fine, Arena *arena);

#endif
