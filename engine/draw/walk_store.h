// walk_store.h - the objects of a building that are in OpenGL's memory: their vertices, and the texels of their quick light.
//
// A building of ordinary size is held whole, from the start. Of a larger one objects come when they are first drawn, or a little ahead,
// and go when others need the room: the store has two halves, and newcomers fill one until it is full; then the other half is emptied
// and filled. So the memory follows what is seen, not the building. A half grows where one frame alone needs more.
#ifndef WALK_STORE_H
#define WALK_STORE_H

#include "engine/draw/walk_textures.h"
#include "engine/shade/walk_lights.h"

// Texture units: lamps for the fine look, two texels each; baked surfaces for the fast look; a unit free for other textures;
// pictures.
enum { WALK_UNIT_LAMPS, WALK_UNIT_ATLAS, WALK_UNIT_FREE, WALK_UNIT_PICTURES };

typedef struct WalkStore WalkStore;

// How much is held. Vertices take some 50 bytes each, twice that where there are pictures.
typedef struct WalkStoreLimits {
    int whole_most;     // a building of at most so many vertices is held whole
    int half_vertices;  // of a larger one: the vertices of a half, at first
    int half_rows;      // and its rows of WALK_STORE_WIDTH texels
} WalkStoreLimits;
enum { WALK_STORE_WIDTH = 2048 };
WalkStoreLimits walk_store_usual_limits(void);

// `textures` and `lights` must live as long as the result, which lives in the arena; `lights` relative to `origin`.
WalkStore *walk_store_new(const CellGraph *graph, const WalkTextures *textures, const WalkLights *lights,
                          Vec3 origin, const WalkStoreLimits *limits, Arena *arena, Error *error);
void walk_store_free(WalkStore *store);  // NULL is allowed

// Puts the leaves of doors where `door_open` has them, as for vis_query; at first all are wide open.
void walk_store_pose(WalkStore *store, const float *door_open);
// A corner of a polygon that moves with a leaf unless that is -1, as it is posed.
Vec3 walk_store_corner(const WalkStore *store, int leaf, int vertex);

bool walk_store_whole(const WalkStore *store);

// Sees to it that these objects are held, with their leaves as they are posed. What was held before stays where it fits.
void walk_store_hold(WalkStore *store, const int *objects, int count);
// The same for those objects that would be the next to go, in the order given, as far as they fit beside what one frame needs, until the
// light of `most` points was computed, corners and texels.
void walk_store_hold_ahead(WalkStore *store, const int *objects, int count, int most);

// The triangles of a held object's polygons, one polygon after another, three indices to a triangle.
const unsigned *walk_store_triangles(const WalkStore *store, int object);
void walk_store_bind(const WalkStore *store);         // its vertices
void walk_store_bind_texels(const WalkStore *store);  // to WALK_UNIT_ATLAS

// For tests: the vertices in OpenGL's memory, how often a half was emptied, and how often the halves grew.
typedef struct WalkStoreFigures {
    long vertices, emptied, grown;
} WalkStoreFigures;
WalkStoreFigures walk_store_figures(const WalkStore *store);

#endif
