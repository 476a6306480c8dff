// walk_mesh.h - a building in OpenGL's memory: uploaded once, with leaves of doors that move, and with draw lists.
#ifndef WALK_MESH_H
#define WALK_MESH_H

#include "engine/draw/walk_textures.h"
#include "visibility/vis.h"

typedef struct WalkMesh WalkMesh;

// Texture units: lamps for the fine look, two texels each; baked surfaces for the fast look; a unit free for other textures;
// pictures.
enum { WALK_UNIT_LAMPS, WALK_UNIT_ATLAS, WALK_UNIT_FREE, WALK_UNIT_PICTURES };

// `textures` must live as long as the result.
WalkMesh *walk_mesh_new(const CellGraph *graph, const WalkTextures *textures, Arena *arena, Error *error);
void walk_mesh_free(WalkMesh *mesh);  // NULL is allowed

// Positions are relative to this point: floats stay exact enough far from the building's own origin.
Vec3 walk_mesh_origin(const WalkMesh *mesh);

// Puts the leaves of doors where `door_open` has them, as for vis_query; at first all are wide open. The light is baked anew on
// leaves that have moved since the last call; other leaves cost nothing.
void walk_mesh_pose(WalkMesh *mesh, const float *door_open);

enum {
    WALK_THINGS,    // opaque polygons of all other objects, nearest object first
    WALK_SURFACES,  // surfaces of cells, nearest first, without those that face away
    WALK_PANES,     // glass, farthest object first
    WALK_PARTS
};

// Makes the draw list of these objects for an eye. After that, each part can be drawn any number of times. `left_out` [polygon_count] of
// the graph: polygons that are not drawn; NULL: none.
void walk_mesh_list(WalkMesh *mesh, Vec3 eye, const int *objects, int object_count,
                    const unsigned char *left_out);
void walk_mesh_bind(const WalkMesh *mesh);  // binds its vertices and textures
// `run` as in walk_textures.h.
void walk_mesh_draw(const WalkMesh *mesh, int part, int run);
// Draws these polygons of the graph; leaves the draw list alone.
void walk_mesh_draw_polygons(WalkMesh *mesh, const int *polygons, int count);
// Draws the edges of these objects' polygons as lines; leaves the draw list alone.
void walk_mesh_draw_edges(WalkMesh *mesh, const int *objects, int object_count);

#endif
