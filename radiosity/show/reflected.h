// reflected.h - reflected light where it is shown: gathered once more in the parts of those elements within which it may change much.
#ifndef RADIOSITY_REFLECTED_H
#define RADIOSITY_REFLECTED_H

#include "engine/core/sets.h"
#include "radiosity/mesh/nodes.h"
#include "radiosity/show/gather.h"

// The elements of a mesh within which reflected light may change much, [element_count]: those that gather it by themselves, and how often
// these are to be halved along each axis of their faces' grids, so that each part gathers. Light may change much between neighbours that
// differ, in front of close surfaces, and where shots say that an element has other light than its patch.
typedef struct ReflectedParts {
    MeshDepth *halved;
    bool *gathers;
} ReflectedParts;
// The solution must be `gathered`. `borders`: of a part of the building, or NULL.
ReflectedParts reflected_parts(const GatherScene *scene, const Nodes *nodes, int threads,
                               const Borders *borders, Arena *arena);

// Rows of the parts at which light is gathered, kept by a caller who gathers light of several solutions on one mesh. Start with all zeros,
// but `thread_count`; reflected_nodes fills it when it is called first, with the rows of that solution's day. The mesh of that call must
// last as long.
typedef struct PartRows {
    GatherRow *row;  // [count]
    bool *there;     // [count]
    int *leaf;       // [count] the leaf that the part lies on, -1
    int count, thread_count;
    bool sky_parts;     // rows know the parts of the sky: the hour may turn
    const Mesh *shown;  // the mesh that shows the light
    const struct PartRows *
        before;  // of another one, with doors as they are now: its rows serve where parts are the same. Or NULL
    struct ReflectedPlaces *places;  // where light is found, which stays from light to light
    // Those who make rows, [thread_count], NULL: nobody has yet; of the first scene, with a solution that has its day alone
    Gatherer **gatherer;
    GatherScene scene;
    RadSolution solution;
    Arena arena;
    Arena *kept;  // [thread_count]
    size_t used;  // of them, bytes, when gaps were closed last
} PartRows;
void part_rows_end(PartRows *rows);
// Doors have moved: drops the rows that may see one of them, which the next call of reflected_nodes makes again. Returns how many.
// `shown`: the mesh that shows the light, posed.
int part_rows_move(PartRows *rows, const Mesh *shown, const MovedDoors *moved);

// The irradiance by reflected light at nodes of a mesh whose elements are those of the scene's mesh, halved as often as ReflectedParts says
// or oftener, W/m^2 a channel, into `out` [nodes->count]. `gathers` is that of ReflectedParts; NULL: none. The same on any number of
// threads (0: all cores). False where progress asked to stop. `kept` may be NULL. `borders`: those of `shown` if it is of a part of the
// building, then light is found at nodes of its own faces; or NULL.
bool reflected_nodes(const GatherScene *scene, const bool *gathers, const Mesh *shown, const Nodes *nodes,
                     int threads, PartRows *kept, const Borders *borders, const Progress *progress,
                     double (*out)[3]);
// Is there light that reflected_again can go on from?
bool reflected_goes_on(const PartRows *kept);
// The same on the mesh, nodes and rows of the last call, `out` as that one left it, where the light of the patches `changed` alone differs
// from what it was: only nodes about those, and about parts whose rows were dropped, are found anew. `found` gets them.
bool reflected_again(const GatherScene *scene, const Mesh *shown, const Nodes *nodes, const Marks *changed,
                     PartRows *kept, const Progress *progress, double (*out)[3], Marks *found);

#endif
