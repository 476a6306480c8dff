// borders.h - the faces that parts of a building share: each belongs to one part and lies in the meshes of all those that see it.
#ifndef RADIOSITY_BORDERS_H
#define RADIOSITY_BORDERS_H

#include "engine/team/team.h"
#include "radiosity/mesh/mesh.h"

// The faces that the mesh of a part shares with those of other parts. Lives in the arena of borders_new, with the mesh.
typedef struct Borders Borders;

// Two meshes of one building that both have a face agree on this of it.
typedef struct FaceTitle {
    int object, polygon;  // `polygon` -1: a stand-in, of which `place` is the number among the object's
    int place;
    int patch_count, element_count;
} FaceTitle;

// The titles of all faces of a mesh, [face_count], in the arena; and the order in which they come in every mesh, as for qsort.
FaceTitle *border_titles(const Mesh *mesh, Arena *arena);
int border_compare(const FaceTitle *a, const FaceTitle *b);

// All members of the team make theirs together, each of its own mesh; part i is that of member i. Fails for all of them where two meshes
// differ on a face that they share.
Borders *borders_new(const Mesh *mesh, TeamMember *member, Arena *arena, Error *error);
TeamMember *borders_member(const Borders *borders);
// The faces of this part that lie in the mesh of another one, in order.
const int *borders_lent(const Borders *borders, int part, int *count);

// An array with a value of `size` bytes for each patch or element of the mesh.
typedef enum BorderUnit { BORDER_PATCH, BORDER_ELEMENT } BorderUnit;
typedef struct BorderValue {
    BorderUnit unit;
    void *array;
    size_t size;
} BorderValue;
#define BORDER_VALUE(unit, array) ((BorderValue){(unit), (array), sizeof *(array)})

// `count` arrays go at one meeting. Faces of others get the values that their owners have.
void borders_fetch(const Borders *borders, const BorderValue *values, int count);
// Vectors, double[3], on faces of others are added to those of their owners, part after part, and become 0.
void borders_bring(const Borders *borders, const BorderValue *values, int count);
// The least of the `most` greatest of values of all parts, each of which gives `count`; INFINITY where there is none. `borders` NULL: of
// one. Sorts the values.
double borders_least(const Borders *borders, double *value, int count, double most);

// Copies bits `first` and on of `from` to bits `at` and on of `to`, which are 0.
void border_copy_bits(const unsigned char *from, int first, unsigned char *to, int at, int count);
// Splits of a finer mesh, in which faces of others have those that their owners give; in the arena.
MeshSplits *borders_splits(const Borders *borders, const MeshSplits *splits, Arena *arena);

#endif
