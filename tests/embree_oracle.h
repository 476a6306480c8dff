// embree_oracle.h - Embree as an independent oracle: the nearest polygon along the rays of a camera.
#ifndef TESTS_EMBREE_ORACLE_H
#define TESTS_EMBREE_ORACLE_H

#include "visibility/hidden/hidden.h"

typedef struct EmbreeOracle EmbreeOracle;

// Positions are kept in float relative to `origin`: keep it near what is looked at.
EmbreeOracle *embree_oracle_new(const Scene *scene, Vec3 origin, Arena *arena);
void embree_oracle_draw(const EmbreeOracle *oracle, const Camera *camera, ItemBuffer *out);
void embree_oracle_free(EmbreeOracle *oracle);

#endif
