// shot_reference.h - rows by a great many random rays: what the errors of form-factor methods are measured against.
#ifndef APP_SHOT_REFERENCE_H
#define APP_SHOT_REFERENCE_H

#include "radiosity/factors/form_factor.h"

typedef struct ShotReference {
    uint32_t **arrivals;  // [shooter][element_count] rays that met each element
    long long rays;       // of each shooter
    int element_count;
} ShotReference;

// The same for the same seed, on any number of threads.
ShotReference shot_reference(const Mesh *mesh, const ViewPoint *from, int count, long long rays,
                             uint64_t seed, Arena *arena);
// L1 = sum |F - F_ref| over all elements.
double shot_reference_l1(const ShotReference *reference, int shooter, const Row *row);

#endif
