// lit_part.h - the light of a part of a large building as it is drawn, in a file beside the part's .rad file, so that a walk reads it
// and makes no mesh: a mesh takes several times the memory and the time.
#ifndef LIT_PART_H
#define LIT_PART_H

#include "engine/lit/lit_mesh.h"

// Stores light as it is drawn beside the .rad file of a part, which is there already (PartsKeep.drawn). `light` is what that file
// holds, on the graph of the scene.
bool lit_store_part(const LoadedScene *scene, const char *rad, const WalkLight *light, Error *error);

// Reads such a file, whose .rad file has the checksum `of_rad` (rad_checksum), into the arena. NULL and an error where it is damaged, or is
// not of this scene, its lamps and its day. LitLight.level is not known.
LitMesh *lit_read_part(const LoadedScene *scene, const char *path, uint64_t of_rad, Arena *arena,
                       LitLight *out, Error *error);

// The light of a part and its mesh, in the arena, as drawing needs them: nothing else of the part is kept, and no other light can be
// filled. From that file: NULL where there is none, and, with a warning, where it cannot be used. Takes about lit_part_size bytes (0:
// there is no such file).
LitMesh *lit_read_drawn(const LightOfParts *parts, int part, Arena *arena, LitLight *out);
size_t lit_part_size(const LightOfParts *parts, int part);
int lit_part_vertices(const LightOfParts *parts,
                      int part);  // as the file's header has it; 0: no such file, or a damaged header
// The same, made from the .rad file, which takes several times that memory meanwhile. NULL and an error where that cannot be read.
LitMesh *lit_make_drawn(const LightOfParts *parts, int part, Arena *arena, LitLight *out, Error *error);

#endif
