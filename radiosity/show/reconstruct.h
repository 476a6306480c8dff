// reconstruct.h - the light that is shown: radiosities at vertices from the radiosities of elements, interpolated between vertices.
#ifndef RADIOSITY_RECONSTRUCT_H
#define RADIOSITY_RECONSTRUCT_H

#include "engine/core/sets.h"
#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

// Light at the corners of elements, W/m^2 a channel. Any number of threads may read it once it is made. It lives in the arena of
// the call that made it.
typedef struct VertexLight {
    // [mesh->corner_count] in the order of Mesh.corners; equal for all corners of a node
    double (*corner)[3];
    double (*face)[3];  // [mesh->face_count] mean over the face's area
    // [3 * mesh->corner_count] an element's triangles start at 3 * first_corner; NULL: made at each call
    int *triangle;
} VertexLight;

// The solution if each element reflected what its material reflects in the mean: light to show, which a shader or a still multiplies by
// the picture over its mean. Where no face has a picture it is the solution itself; else `radiosity`, `direct`, `daylight` and `sun` are
// new, in the arena.
RadSolution reconstruct_even(const Mesh *mesh, const RadSolution *solution, Arena *arena);

// The light of a solution at the corners, even as of reconstruct_even. Where the solution was gathered at nodes, the gathered radiosities
// are used.
VertexLight reconstruct_light(const Mesh *mesh, const RadSolution *solution, Arena *arena);

// The mean of a solution's light over a face.
void reconstruct_face(const Mesh *mesh, int face, const RadSolution *solution, double out[3]);

// The even radiosity at each node from those of the elements, into `out` [nodes->count], W/m^2 a channel. `wanted` [nodes->count]: the
// nodes whose light is asked for, that of others may be anything; NULL: all.
void reconstruct_nodes(const Mesh *mesh, const Nodes *nodes, const RadSolution *solution, const bool *wanted,
                       double (*out)[3]);

// The same from values at the centres of patches, or at the centroids of elements. Linear light between the nodes passes through the values
// where they bend by less than a fifth. Units that hardly any light reaches say nothing of the light beside them. How far a plane through
// the values around each was below it goes into `rest`, if not NULL.
// `wanted` [nodes->count]: the nodes to be found; NULL: all. `kept`, or NULL: so that the next call, of the same mesh, nodes and wanted
// ones, takes less time and has the same result. Leaves of doors may have moved meanwhile.
typedef struct ValueFits {
    Arena *arena;  // the caller's, where all that is kept lives; the rest starts with zeros
    struct NodeFit *node;
    struct UnitPlace *unit;
    bool *covered;
    double least;                     // units of no more are covered
    double (*fitted)[3], (*rest)[3];  // [nodes], [units] of the last call
    Marks nodes, units;               // those found by the last reconstruct_values_again
} ValueFits;
void reconstruct_values(const Mesh *mesh, const Nodes *nodes, bool of_patches, double (*value)[3],
                        const bool *wanted, double (*out)[3], double (*rest)[3], ValueFits *kept);
// The same where `out` is as the last call with these fits left it, and only the values of the units `changed` differ from those it had.
// Touches only the nodes whose values may differ: `kept->nodes`.
void reconstruct_values_again(const Mesh *mesh, const Nodes *nodes, bool of_patches, double (*value)[3],
                              const bool *wanted, const Marks *changed, double (*out)[3], ValueFits *kept);

// The triangles that elements are drawn as, for VertexLight.triangle: worth making where reconstruct_at is called often.
int *reconstruct_triangles(const Mesh *mesh, Arena *arena);

// The corners of the triangle of an element in which a point lies, or to which it is nearest, as indices of mesh->corners, and their
// shares of its light. `triangle`: of reconstruct_triangles.
void reconstruct_shares(const Mesh *mesh, const int *triangle, int element, Vec3 point, int corner[3],
                        double share[3]);

// The light at a point of a face: linear over the triangles that elements are drawn as (polygon_triangulate). A point that rounding
// puts outside its element gets the light of the element's nearest point.
void reconstruct_at(const Mesh *mesh, const VertexLight *light, int face, Vec3 point, double out[3]);
// The same where the element is known.
void reconstruct_in(const Mesh *mesh, const VertexLight *light, int element, Vec3 point, double out[3]);

#endif
