// joined.h - the light of the parts of a building, joined to the light of the whole.
#ifndef RADIOSITY_JOINED_H
#define RADIOSITY_JOINED_H

#include "radiosity/mesh/borders.h"
#include "radiosity/shoot/shoot.h"

// The light of a part on its own faces, as bytes in the arena for joined_light. `solution` was shot on `mesh`, and shown, with doors as
// `door_open` says.
bool joined_pack(const Mesh *mesh, const RadSolution *solution, const float *door_open, Arena *arena,
                 TeamBytes *out, Error *error);
// The same for each part, `out` [parts]: the light on those of its faces that belong to this part, so that each part can have the light of
// all that it sees. What nobody sees from this part is dark in it.
bool joined_pack_each(const Mesh *mesh, const RadSolution *solution, const float *door_open,
                      const Borders *borders, Arena *arena, TeamBytes *out, Error *error);

// The mesh of the whole building and the light on it, from the bytes of all its parts, `part` [count]. `options` are those of the mesh;
// with a part, the mesh and the light are those of this part, from bytes of joined_pack_each.
// Sums of power are those that every part knows. The light was not gathered. Where the mesh that would show it is too large, it has no
// nodes. Fails where the parts do not fit together.
bool joined_light(const CellGraph *graph, const MeshOptions *options, const float *door_open,
                  const TeamBytes *part, int count, Arena *arena, Mesh *mesh, RadSolution *out, Error *error);

#endif
