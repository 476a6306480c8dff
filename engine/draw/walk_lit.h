// walk_lit.h - a baked building in OpenGL's memory: its elements, the newest light at each corner, and the light before it, from which
// the picture fades to the newest.
#ifndef WALK_LIT_H
#define WALK_LIT_H

#include "engine/draw/walk_textures.h"
#include "engine/lit/lit_mesh.h"

typedef struct WalkLit WalkLit;

// Buffers for so many vertices and two states of their light. OpenGL clears new ones, which takes many frames' time where they are large
// and OpenGL is software.
typedef struct WalkLitRoom {
    int vertices;  // 0: there are none
    unsigned vertex_buffer, light_buffer[2];
} WalkLitRoom;
WalkLitRoom walk_lit_room(int vertices);
void walk_lit_room_free(WalkLitRoom *room);

// Takes the room, which has enough, or makes buffers where that has none; vertices and light are uploaded later. `mesh` must live as long
// as the result, and `textures`, too.
WalkLit *walk_lit_new(LitMesh *mesh, const WalkTextures *textures, WalkLitRoom room);
// Returns the room, which is the caller's.
WalkLitRoom walk_lit_end(WalkLit *lit);
const LitMesh *walk_lit_mesh(const WalkLit *lit);

// Uploads the vertices, then the rest of the new light, up to about `bytes` bytes in all. True when everything is uploaded: from then on
// the picture fades to this light, and `light` may be freed but for walk_lit_pose. May be called only when the fade before has ended.
bool walk_lit_upload(WalkLit *lit, const LitLight *light, size_t bytes);
// Sets the share of the newest light in the picture, 0 .. 1; the rest is the light before it.
void walk_lit_fade(WalkLit *lit, double share);
double walk_lit_faded(const WalkLit *lit);

// The leaves of doors are drawn from now on where `door_open` has them, as for vis_query, in the light of lit_leaf.h: `light` is the one
// uploaded last, unchanged until the next pose, or NULL before there is any. `door_open` is copied; NULL: all are open.
void walk_lit_pose(WalkLit *lit, const LitLight *light, const float *door_open);
// Makes the draw list of these objects for an eye: things first, then the surfaces that face the eye. `left_out` as for walk_mesh_list.
void walk_lit_list(WalkLit *lit, Vec3 eye, const int *objects, int object_count,
                   const unsigned char *left_out);
void walk_lit_bind(const WalkLit *lit);                          // binds the table of materials
void walk_lit_draw(const WalkLit *lit, bool surfaces, int run);  // `run` as in walk_textures.h

#endif
