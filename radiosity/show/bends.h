// bends.h - where light bends within elements, so that light between their corners is not linear: trees of halves, from which a finer
// mesh is made.
#ifndef RADIOSITY_BENDS_H
#define RADIOSITY_BENDS_H

#include "radiosity/mesh/borders.h"

// An element that is halved, or a part of it.
typedef struct Bend Bend;

// The light in which bends are looked for.
typedef struct BendLight {
    // The irradiance at a point of the element, W/m^2 a channel.
    void (*at)(void *context, Vec3 point, double irradiance[3]);
    // Whether a shadow's edge may pass a part; NULL: that is not asked.
    bool (*edge)(void *context, const Vec3 *corner, int count);
    void *context;
    double reflectance[3];
    double
        rest;  // radiosity by all other light on the element, the sum of the channels, which counts as even
} BendLight;

// A point, and the irradiance there.
typedef struct BendPoint {
    Vec3 point;
    double irradiance[3];
} BendPoint;

// The memory of one thread for the search.
typedef struct BendFinder BendFinder;
BendFinder *bend_finder_new(Arena *arena);

// Halves an element of a mesh with splits until, in each part, linear light between the corners is near enough to the light at the middle
// and at the middles of the sides, or the part is 2.5 cm long. `corner` [corner_count of the element] is the irradiance at its corners.
// Parts that a shadow's edge may pass are looked into also where none of these points is off, and halved until they are 1 cm long. NULL:
// light does not bend in the element. The result lives in the arena.
Bend *bend_find(BendFinder *finder, const Mesh *mesh, int element, double (*corner)[3],
                const BendLight *light, Arena *arena);

// The points at which the last search looked, those at the middles and corners of all parts among them; valid until the next one.
const BendPoint *bend_points(const BendFinder *finder, int *count);

// The bends of an element in one more state of the light, copied into the arena: a finer mesh is then as fine as each of the states asks
// for. Either may be NULL; `bend` changes.
Bend *bend_join(Bend *bend, const Bend *other, Arena *arena);

// Splits of a finer mesh: as deep as the elements of the mesh, as their bends [element_count] ask for, and halved so often as `halved`
// [element_count] says (NULL: not at all). Where bends would take more than `most` further elements, those that are least off are left
// out. NULL: nothing bends or is halved.
// `borders`: of a part of a building, and `most` are those of all parts; or NULL.
MeshSplits *bend_splits(const Mesh *mesh, Bend *const *bends, const MeshDepth *halved, double most,
                        const Borders *borders, Arena *arena);

#endif
