// mesh.h - the polygons of a building cut into elements, which receive light, and into patches of elements, which shoot it
// (Cohen, Greenberg, Immel & Brock 1986).
//
// Light is reflected and emitted at the front of a polygon; its back hides and absorbs. Glass is not there.
#ifndef RADIOSITY_MESH_H
#define RADIOSITY_MESH_H

#include "radiosity/mesh/proxy.h"

// Where a mesh is finer than elsewhere: of each root of each face, in their order, a tree, depth first. Above patches a bit a
// square: split into four, or not; one that is not is a patch, and the tree of its elements follows: squares halved into rectangles,
// these into squares again. A bit a node: halved, or not; and of squares that are another, along which axis: 0, x.
// Read only once they are made; `bits` are the maker's.
typedef struct MeshSplits {
    int bit_count;
    unsigned char *bits;  // [(bit_count + 7) / 8] the lowest of a byte first; NULL: every root is a patch
    int even;             // without bits, each root is split so often into elements, 0 .. MESH_IN_PATCH
} MeshSplits;

enum {
    MESH_DEEPEST = 6,          // splits on top of one another
    MESH_IN_PATCH = 3,         // of a patch: it has 64 elements at most, uncut
    MESH_MOST_IN_PATCH = 256,  // elements, also of 16 x 16 that are cut: a byte tells which one is meant
};

// How fine a mesh is.
typedef struct MeshOptions {
    double element;            // edge length aimed at, metres, 0.01 .. 100
    int per_patch;             // elements along the side of a patch, 1 .. 16
    double close;              // elements are cut along objects so near to a face, metres, 0: not cut, .. 1
    const MeshSplits *splits;  // NULL: all elements alike. Else roots are twice as long as such patches
    double proxy;              // their tolerance, metres, 0: none, .. 1
    const Proxies *proxies;    // polygons that stand in for others, found with that; NULL: there are none
    bool replaced;             // those others alone, and no stand-ins
    bool
        loose;  // vertices of neighbours on an element's edges do not become its corners: drawn, it has cracks
    int threads;  // 0: all cores; the mesh is the same on any number
} MeshOptions;
MeshOptions mesh_default_options(void);  // 0.33 m, 2, 0.05 m, PROXY_TOLERANCE but no proxies yet

// A polygon as light sees it. It has a grid of nx x ny squares (parallelograms where it is clipped to fit): the point
// p of its plane lies at x = dot(gx, p - origin), y = dot(gy, p - origin), in square (floor x, floor y).
typedef struct Face {
    int polygon;   // in CellGraph; -1: a stand-in
    int object;    // in CellGraph
    int material;  // in Building
    Plane plane;   // pointing to the front
    int first_vertex,
        vertex_count;     // in Mesh.outline: counter-clockwise from the front, with every vertex of another
                          // face that lies on an edge among them, so that neighbours share whole edges
    Vec3 origin, gx, gy;  // 1 / metres
    int nx, ny,
        first_square;  // in Mesh.squares, row by row: the element there, -1 where the polygon is not, ~k - 1 where
                       // several are: Mesh.shared[k] of them, k + 1 .., the largest first
    int root;          // squares along the side of a root, or of a patch where there are no splits
    int first_element, element_count;
    int first_patch, patch_count;
} Face;

// How often a root was halved along each axis of the face's grid.
typedef struct MeshDepth {
    unsigned char x, y;
} MeshDepth;

// A convex piece of a face.
typedef struct Element {
    int face, patch;
    int first_corner,
        corner_count;  // in Mesh.corners, counter-clockwise, vertices of neighbours on its edges included
    MeshDepth depth;
    double area;  // m^2
} Element;

// Elements first_element .. + element_count - 1.
typedef struct Patch {
    int face, first_element, element_count;
    int cell;     // of the graph, that its front looks into; -1: none (inside a wall)
    double area;  // m^2
    Vec3 centre;  // of its area, a point of the polygon; where that is inside a wall, of the part in `cell`
} Patch;

// All of it. Read only once it is made: any number of threads. It lives in the arena of the call that made it; its graph outlives it.
typedef struct Mesh {
    const CellGraph *graph;
    MeshOptions options;
    Face *faces;
    Element *elements;
    Patch *patches;
    Vec3 *vertices;  // each place once
    int *outline;    // of faces, indices of vertices
    int *corners;    // of elements, indices of vertices
    int *squares, *shared;
    int *
        face_of;  // [graph->polygon_count] the face a polygon became, or -1: glass, hidden by its door's state, no area, replaced
    int face_count, element_count, patch_count, vertex_count, outline_count, corner_count, square_count,
        shared_count;
    // Counts of faces that were changed or left out, for reports.
    int dropped_faces;    // without area
    int merged_elements;  // slivers that became part of their neighbours
    int lost_patches;     // of which no part lies in a cell
} Mesh;

// An edge for a building's elements: about 60,000 of them, 0.15 to 0.33 m. Small homes are told in detail, large buildings in time.
double mesh_fitting_element(const CellGraph *graph);
// `vertices` are the graph's as the doors stand (vis_pose), NULL: as drawn; `door_open` as for vis_query.
// Fails, with a sentence, where nothing is left to receive light.
bool mesh_build(const CellGraph *graph, const Vec3 *vertices, const float *door_open,
                const MeshOptions *options, Arena *arena, Mesh *out, Error *error);

// Splits for a mesh as deep as `patch` and `element` [element_count] say where these elements are, 0 (all of a root) .. MESH_DEEPEST.
// `mesh` has splits; an element is never larger than its patch, nor more than twice as long as wide but by its root.
MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *patch, const MeshDepth *element, Arena *arena);

// About how many elements the same polygons have without splits.
double mesh_count_even(const Mesh *mesh);

// The element of a face at a point of its plane; the nearest square's where the point is a rounding outside.
int mesh_element_at(const Mesh *mesh, int face, Vec3 point);

// The element of a square; of several the largest; -1: none.
static inline int mesh_square(const Mesh *mesh, int square) {
    int element = mesh->squares[square];
    return element >= -1 ? element : mesh->shared[~(element + 1) + 1];
}

// The material of a face.
static inline const Material *mesh_material(const Mesh *mesh, int face) {
    return &mesh->graph->building->materials[mesh->faces[face].material];
}

// Does a face emit light?
static inline bool mesh_emits(const Mesh *mesh, int face) {
    Rgb e = mesh_material(mesh, face)->emission;
    return e.r + e.g + e.b > 0;
}

#endif
