// walk_mesh.h - draw lists of a building, whose leaves of doors move, over the objects that are in OpenGL's memory (walk_store.h).
#ifndef WALK_MESH_H
#define WALK_MESH_H

#include "engine/draw/walk_store.h"
#include "visibility/vis.h"

typedef struct WalkMesh WalkMesh;

// `textures` must live as long as the result.
WalkMesh *walk_mesh_new(const CellGraph *graph, const WalkTextures *textures, const WalkStoreLimits *limits,
                        Arena *arena, Error *error);
void walk_mesh_free(WalkMesh *mesh);  // NULL is allowed

// Positions are relative to this point: floats stay exact enough far from the building's own origin.
Vec3 walk_mesh_origin(const WalkMesh *mesh);

// Puts the leaves of doors where `door_open` has them, as for vis_query; at first all are wide open. A leaf that has moved is made anew
// when it is listed next.
void walk_mesh_pose(WalkMesh *mesh, const float *door_open);

// Makes a part of what may be seen from this cell and is not in OpenGL's memory yet, `seen` of its StabForest: a few milliseconds of work
// with each frame, so that later frames find it there. Nothing is left to do in a building of ordinary size.
void walk_mesh_ahead(WalkMesh *mesh, const CellRows *seen, int cell);
WalkStoreFigures walk_mesh_held(const WalkMesh *mesh);

enum {
    WALK_THINGS,    // opaque polygons of all other objects, nearest object first
    WALK_SURFACES,  // surfaces of cells, nearest first, without those that face away
    WALK_PANES,     // glass, farthest object first
    WALK_PARTS
};

// Makes the draw list of these objects for an eye. After that, each part can be drawn any number of times. `left_out` [polygon_count] of
// the graph: polygons that are not drawn; NULL: none. `panes_alone`: the other parts stay empty.
void walk_mesh_list(WalkMesh *mesh, Vec3 eye, const int *objects, int object_count,
                    const unsigned char *left_out, bool panes_alone);
void walk_mesh_bind(const WalkMesh *mesh);  // binds its textures
// `run` as in walk_textures.h.
void walk_mesh_draw(const WalkMesh *mesh, int part, int run);
// Draws these polygons, which move with a leaf unless that is -1: the shader gets nothing but their places. Leaves the draw list alone.
void walk_mesh_draw_polygons(WalkMesh *mesh, int leaf, const int *polygons, int count);
// Draws the edges of these objects' polygons as lines, likewise.
void walk_mesh_draw_edges(WalkMesh *mesh, const int *objects, int object_count);

#endif
