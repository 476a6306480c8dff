// mesh.h - the polygons of a building cut into elements, which receive light, and into patches of elements, which shoot it
// (Cohen, Greenberg, Immel & Brock 1986).
//
// Light is reflected and emitted at the front of a polygon; its back hides and absorbs. Glass is left out, but for the
// panes of windows and glazed doors, which weaken light by its angle (panes.h).
#ifndef RADIOSITY_MESH_H
#define RADIOSITY_MESH_H

#include "maps/building/texture.h"
#include "radiosity/mesh/panes.h"
#include "radiosity/mesh/proxy.h"

// Where a mesh is finer than elsewhere: one tree for each root of each face, in order, depth first. Above patches each square has
// one bit: 1, split into four; 0, the square is a patch. The tree of a patch's elements follows: squares are halved into rectangles
// and rectangles into squares. Each node has one bit, 1: halved; after the 1 of a square a second bit names the axis, 0: x. A node
// at the greatest depth has no bits. Read only once made; `bits` belongs to the caller.
typedef struct MeshSplits {
    int bit_count;
    unsigned char *bits;  // [(bit_count + 7) / 8] the lowest of a byte first; NULL: every root is a patch
    int even;             // without bits: how often each root is split into four elements, 0 .. MESH_IN_PATCH
} MeshSplits;

enum {
    MESH_DEEPEST = 6,  // the greatest depth of a split, from the root
    MESH_IN_PATCH =
        3,  // the greatest depth of a split within a patch: 64 elements at most before contacts cut them
    MESH_MOST_IN_PATCH =
        256,  // elements of a patch, also where 16 x 16 are cut: the index of an element fits in a byte
};

// A part of a building, of which a mesh is made: the objects whose light is found there, those that are seen from them, and those that
// stand near any of these, without which elements would be cut otherwise. Each object belongs to one of several parts.
typedef struct MeshPart {
    int own;                  // this part
    const int *owner;         // [graph->object_count] the part to which each object belongs
    const int *cell_owner;    // [graph->cell_count] and each cell
    const uint64_t *objects;  // a bit for each object: it is in the mesh
    const uint64_t *seen;     // and it is seen from this part
} MeshPart;

// How fine a mesh is.
typedef struct MeshOptions {
    double element;  // edge length aimed at, metres, 0.01 .. 100
    int per_patch;   // elements along the side of a patch, 1 .. 16
    double close;    // elements are cut along objects nearer to a face than this, metres, 0: not cut, .. 1
    // NULL: all elements alike. With splits, roots are twice as long as patches without
    const MeshSplits *splits;
    double proxy;            // the tolerance of stand-ins, metres, 0: no stand-ins, .. 1
    const Proxies *proxies;  // the stand-ins, found with that tolerance; NULL: there are none
    bool replaced;           // the mesh has only the polygons that stand-ins replace, and no stand-ins
    // Vertices of neighbours on an element's edges do not become its corners: drawn, the mesh has cracks
    bool loose;
    int threads;           // 0: all cores; the mesh is the same on any number
    const MeshPart *part;  // a part of a building, NULL: all of it
} MeshOptions;
MeshOptions mesh_default_options(void);  // 0.33 m, 2, 0.05 m, PROXY_TOLERANCE but no proxies yet

// A polygon that takes part in the exchange of light, with a grid of nx x ny squares (rectangles, stretched to fit): the point
// p of its plane lies at x = dot(gx, p - origin), y = dot(gy, p - origin), in square (floor x, floor y).
typedef struct Face {
    int polygon;      // in CellGraph; -1: a stand-in
    int object;       // in CellGraph
    int material;     // in Building
    int texture_map;  // in Building; 0: that of the material
    double open;      // how far the leaf that the object moves with is open, 0 .. 1
    bool hidden;      // it plugs a door that is open: it neither hides nor receives light
    Plane plane;      // pointing to the front
    int first_vertex,
        vertex_count;     // in Mesh.outline: counter-clockwise from the front, with every vertex of another
                          // face that lies on an edge among them, so that neighbours share whole edges
    Vec3 origin, gx, gy;  // 1 / metres
    int nx, ny,
        first_square;  // in Mesh.squares, row by row: the element of each square; -1: outside the polygon; ~k - 1: the
    // square has several, Mesh.shared[k] in number, listed from Mesh.shared[k + 1], the largest first
    int root;  // squares along the side of a root; without splits, of a patch
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
    int cell;     // the graph's cell in front of the patch; -1: none (the patch is inside a wall)
    double area;  // m^2
    Vec3
        centre;  // of its area, or a point of the patch near it; where that is inside a wall, the centre of the part in `cell`
    bool
        covered;  // a thing stands on the middle of the patch: `centre` is a free place beside it, where there is one
} Patch;

typedef struct MeshMoving MeshMoving;

// A whole mesh. Any number of threads may read it once it is made. It lives in the arena of the call that made it; its graph must
// outlive it.
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
    // [element_count] mean reflectances, for mesh_reflectance; NULL: of every element that of its material
    Rgb *reflectance;
    Panes panes;         // no faces: light passes them
    MeshMoving *moving;  // what doors move (mesh_pose)
    // [graph->polygon_count] the face a polygon became, or -1: glass, hidden by its door's state, no area, replaced
    int *face_of;
    int face_count, element_count, patch_count, vertex_count, outline_count, corner_count, square_count,
        shared_count;
    // Counts of faces that were changed or left out, for reports.
    int dropped_faces;    // faces without area, left out
    int merged_elements;  // slivers that became part of their neighbours
    int lost_patches;     // patches of which no part lies in a cell
} Mesh;

// An edge length for a building's elements, 0.15 to 0.33 m, aiming at about 60,000 elements: small homes get more detail, and large
// buildings do not take too long.
double mesh_fitting_element(const CellGraph *graph);
// The mesh with all doors closed, and then its doors stand as `door_open` says (mesh_pose). Elements and patches are the same whatever
// the doors do: elements are cut along leaves that are closed.
// Fails, with a message in `error`, where no polygon is left to receive light or the mesh would be too large.
bool mesh_build(const CellGraph *graph, const float *door_open, const MeshOptions *options, Arena *arena,
                Mesh *out, Error *error);

// Moves the doors, each by the share [opening_count] of its way that it is open: leaves with their elements and patches, the plugs of doors
// that are closed to the last bit, and the panes of glazed doors. NULL: leaves are closed, and there are no plugs. Only the arrays of this
// mesh change, and those that share them (lamps_mesh, after which this is not to be called); the same state gives the same bytes.
void mesh_pose(Mesh *mesh, const float *door_open);

// A mesh that is posed by itself: a copy of all that doors move, in the arena; the rest is shared.
Mesh mesh_copy(const Mesh *mesh, Arena *arena);

// A door that moves, and the boxes about all of it that hides or weakens light, before and after.
typedef struct MovedDoor {
    int opening;
    Box box[2];
} MovedDoor;
typedef struct MovedDoors {
    MovedDoor *doors;
    int count;
} MovedDoors;
// Does a leaf, in Building.leaves (-1: none), belong to one of these doors?
bool mesh_leaf_moves(const MovedDoors *moved, const Building *building, int leaf);
// Reaches the door, before or after, above the horizon of a point on a surface of this normal?
bool mesh_door_rises(const MovedDoor *door, Vec3 point, Vec3 normal);
// Poses a mesh whose doors stand as `from` says. Other meshes of the same building are posed by themselves.
MovedDoors mesh_move(Mesh *mesh, const float *from, const float *to, Arena *arena);

// Splits for a new mesh. `patch` and `element` [element_count] give the depth wanted at each element of `mesh`, 0 (a whole root) ..
// MESH_DEEPEST. `mesh` must have splits. An element is never larger than its patch, and in a square root it is at most twice as
// long as wide.
MeshSplits *mesh_splits(const Mesh *mesh, const unsigned char *patch, const MeshDepth *element, Arena *arena);

// The same where parts of elements may be wanted finer than others. `wanted` raises `along` and `patch` to the greatest depths wanted,
// of elements along each axis of the face's grid and of patches, in a rectangle of the grid: box[0] <= x < box[2],
// box[1] <= y < box[3]. A rectangle may be smaller than a square.
MeshSplits *mesh_splits_wanted(const Mesh *mesh,
                               void (*wanted)(const void *context, const Mesh *mesh, int face,
                                              const double box[4], int along[2], int *patch),
                               const void *context, Arena *arena);

// The first bit of each face of the mesh in splits of such a mesh, [face_count + 1], in the arena.
int *mesh_face_bits(const Mesh *mesh, const MeshSplits *splits, Arena *arena);

// About how many elements the polygons of `mesh` would have without splits; of a part those that are its own.
double mesh_count_even(const Mesh *mesh);

// The centroid of an element's area.
Vec3 element_centroid(const Mesh *mesh, int element);

// The element of a face at a point of its plane. Where rounding puts the point outside the face, an element of the nearest square.
int mesh_element_at(const Mesh *mesh, int face, Vec3 point);

// The element of a square, the largest if the square has several; -1: none.
static inline int mesh_square(const Mesh *mesh, int square) {
    int element = mesh->squares[square];
    return element >= -1 ? element : mesh->shared[~(element + 1) + 1];
}

// The material of a face.
static inline const Material *mesh_material(const Mesh *mesh, int face) {
    return &mesh->graph->building->materials[mesh->faces[face].material];
}

// How the light of a face leaves where a photometric file tells it; NULL: by Lambert's cosine. What has a spread reflects nothing.
static inline const LampSpread *mesh_spread(const Mesh *mesh, int face) {
    int spread = mesh_material(mesh, face)->spread;
    return spread > 0 ? &mesh->graph->building->spreads[spread] : NULL;
}

// Sets Mesh.reflectance, once the elements are made; mesh_build does.
void mesh_find_reflectances(Mesh *mesh, Arena *arena);

// Does light on a face depend on a picture?
bool mesh_has_picture(const Mesh *mesh, int face);

// The mean reflectance over an element: of the material's picture there, or else that of its material. What has a picture reflects a
// thousandth of the material's mean at least, so that the light that arrives can be told from the light that leaves; what emits counts
// by the material's mean.
static inline Rgb mesh_reflectance(const Mesh *mesh, int element) {
    return mesh->reflectance ? mesh->reflectance[element]
                             : mesh_material(mesh, mesh->elements[element].face)->reflectance;
}
// The same of a patch, the mean of its elements by area.
Rgb mesh_patch_reflectance(const Mesh *mesh, int patch);

// The ratio of the material's mean reflectance to the element's; exactly 1 without a picture. Light that an element reflects, times
// this ratio, has no steps where the picture is uneven.
static inline void mesh_even(const Mesh *mesh, int element, double out[3]) {
    double mean[3], own[3];
    rgb_doubles(mesh_material(mesh, mesh->elements[element].face)->reflectance, mean);
    rgb_doubles(mesh_reflectance(mesh, element), own);
    for (int c = 0; c < 3; c++) out[c] = own[c] > 0 ? mean[c] / own[c] : 1;
}

// The reflectance at a point of a face, averaged over about `width` metres (texture_at).
Rgb mesh_reflectance_at(const Mesh *mesh, int face, Vec3 point, double width);

// Is the light of a face found on this mesh? False: the face belongs to another part of the building.
static inline bool mesh_owns(const Mesh *mesh, int face) {
    const MeshPart *part = mesh->options.part;
    return !part || part->owner[mesh->faces[face].object] == part->own;
}

// Does a face emit light?
static inline bool mesh_emits(const Mesh *mesh, int face) {
    Rgb e = mesh_material(mesh, face)->emission;
    return e.r + e.g + e.b > 0;
}

// Is a face part of a lamp, lit or not? Meshes and rows ask this: they are the same for all states of the lamps.
static inline bool mesh_is_lamp(const Mesh *mesh, int face) {
    Rgb full = mesh_material(mesh, face)->full;
    return full.r + full.g + full.b > 0 || mesh_emits(mesh, face);
}

#endif
