// soup.h - the steps that find the cells of a soup, in their order. All of it is scratch: the graph keeps none of it.
#ifndef VISIBILITY_SOUP_H
#define VISIBILITY_SOUP_H

#include "visibility/cells/build.h"

// How far a polygon's corners may lie off a plane and still lie in it, and how wide a gap between polygons of a plane
// counts as closed, relative to the soup's size: models hold six digits at best, and cracks of that width are noise.
#define SOUP_SNAP 1e-6
// Corners this near each other are one, relative to the size: above the rounding of cuts after a shift by 1,000 km.
#define SOUP_WELD 1e-9
// A cell thinner than this is not split off, relative to the size.
#define SOUP_THINNEST (8 * SOUP_SNAP)
// Cells have at most this many faces, so that the plan of a prism has room in BUILD_MAX_VERTICES.
enum { SOUP_MOST_FACES = 48, SOUP_MOST_CORNERS = 128 };

// A plane of the partition. Polygons that lie in it within SOUP_SNAP count as lying in it exactly.
typedef struct SoupPlane {
    Plane plane;
    double area;                   // opaque, m^2
    int first_sheet, sheet_count;  // in Soup.sheets
} SoupPlane;

// An opaque polygon in a plane.
typedef struct SoupSheet {
    const Vec3 *v;
    int count, plane;
    double area;
} SoupSheet;

// A closed door: a rectangle in a plane.
typedef struct SoupDoor {
    Vec3 v[4];
    int plane, opening;
} SoupDoor;

// A face of a cell, counter-clockwise seen from inside.
typedef struct CellFace {
    int plane, side;  // +1: the cell lies in front of the plane, -1 behind it
    Vec3 *v;
    int count;
} CellFace;

typedef struct SoupCell {
    CellFace faces[SOUP_MOST_FACES + 2];  // one more by a cut, one more while two cells are tried as one
    int face_count;
    bool gone;  // it became part of another
} SoupCell;

typedef struct Soup {
    CellBuilder *builder;
    Arena *scratch;
    Vec3 centre;   // the mean of all corners
    double size;   // twice the distance of the corner farthest from it, metres
    Vec3 axis[3];  // of the building's own box: along its largest planes
    SoupPlane *planes;
    struct SoupShelf *shelves;  // see soup_planes.c
    SoupSheet *sheets;          // by plane, once soup_find_planes is through
    SoupDoor *doors;
    SoupCell **cells;
    int plane_count, sheet_count, door_count, cell_count;
    int dropped;  // common faces and gaps narrower than SOUP_SNAP
    int plane_capacity, sheet_capacity, cell_capacity;
    double opaque_area;  // of all sheets, m^2
    int box[6];          // the planes of the building's own box
    int border;          // planes[border] .. planes[border + 5] bound all cells
} Soup;

// soup_planes.c: the table of planes and the opaque polygons in each; one cell, the world.
void soup_find_planes(Soup *soup);
// soup_tree.c: cells by a binary partition.
void soup_part(Soup *soup);
// soup_join.c: cells whose separation hides nothing become one.
void soup_join(Soup *soup);
// soup_portals.c: cells and portals of the graph.
void soup_write_cells(Soup *soup);
void soup_write_portals(Soup *soup);
// soup_objects.c: the polygons that are drawn, and the plugs of doors.
void soup_write_objects(const Soup *soup);
// soup_seams.c: no corner of one lies on an edge of another without being its corner too.
void soup_close_seams(const Soup *soup);

// soup_cell.c: cells as polyhedra.
SoupCell *soup_cell_new(Soup *soup);
void soup_cell_add_face(Soup *soup, SoupCell *cell, int plane, int side, const Vec3 *v, int count);
// Cuts a cell in two; false, and nothing is made, where a part would be thinner than SOUP_THINNEST.
bool soup_cell_split(Soup *soup, const SoupCell *cell, int plane, SoupCell **front, SoupCell **back);
// Writes the part of the plane in the cell, counter-clockwise seen from its front; returns its corner count. `out` has room for
// SOUP_MOST_CORNERS.
int soup_cell_section(const Soup *soup, const SoupCell *cell, int plane, Vec3 *out);
// The part of a convex polygon inside the cell; `out` has room for count + SOUP_MOST_FACES + 2.
int soup_cell_clip(const Soup *soup, const SoupCell *cell, const Vec3 *v, int count, Vec3 *out);
Plane soup_inward(const Soup *soup, const CellFace *face);

// soup_pieces.c: sets of convex polygons in one plane.
typedef struct SoupPiece {
    Vec3 *v;
    int count;
    Box box;
} SoupPiece;

// Start with {0}.
typedef struct SoupPieces {
    SoupPiece *piece, *spare;  // spare: of those before the last difference
    int count, capacity, spare_capacity;
} SoupPieces;

void soup_pieces_add(Arena *arena, SoupPieces *pieces, const Vec3 *v, int count);
// Less a convex polygon, either way round, in the same plane of normal n, off it by less than `near`.
void soup_pieces_subtract(Arena *arena, SoupPieces *pieces, const Vec3 *hole, int count, Vec3 n, double weld,
                          double near);
// Pieces nearer than `near` that together are convex become one.
void soup_pieces_join(Arena *arena, SoupPieces *pieces, Vec3 n, double weld, double near);
// The part of one convex polygon in another of the same plane, either way round; `out` has room for both and one more.
int soup_overlap(const Vec3 *v, int count, const Vec3 *by, int by_count, Vec3 n, Vec3 *out);
// The box around points, `grow` larger on all sides.
Box soup_box(const Vec3 *v, int count, double grow);
// The convex hull of points in a plane, counter-clockwise about n; points nearer than `weld` to an edge are left out.
// `out` has room for count + 1.
int soup_hull(Arena *arena, const Vec3 *points, int count, Vec3 n, double weld, Vec3 *out);
// Twice the area over the girth: no more than the width, and at least half of it for a long polygon.
double soup_width(const Vec3 *v, int count);

// ---- soup.c
// Convex polyhedra along the major polygons, portals where nothing opaque parts them, objects.
bool build_soup(CellBuilder *builder, Error *error);

#endif
