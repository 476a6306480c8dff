// shape.h - bodies while they are made: convex polygons with their planes, their union, difference and intersection.
#ifndef MAPS_IFC_SHAPE_H
#define MAPS_IFC_SHAPE_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"
#include "maps/building/building.h"

// Points closer to a plane than this lie on it, metres: files round lengths to a hundredth of a millimetre at best.
#define SHAPE_EPSILON 1e-5
// Polygons of less area are left out, m^2.
#define SHAPE_SMALLEST_AREA 1e-12

// A planar convex polygon; `plane` is that of the face it was cut from, so that small pieces keep an exact normal.
typedef struct ShapeFace {
    int first, count;  // in Shape.corners
    int material;      // -1: that of the item or product
    int map;           // how a picture lies on it: Shape.maps[map - 1]; 0: none does
    Plane plane;       // its normal points out of the body
} ShapeFace;

// A body or a surface.
typedef struct Shape {
    Vec3 *corners;
    ShapeFace *faces;
    TextureMap *maps;
    int corner_count, face_count, map_count, corner_room, face_room, map_room;
    bool solid;  // the faces enclose a body
    Box box;
} Shape;

static inline Shape shape_empty(bool solid) { return (Shape){.solid = solid, .box = box_empty()}; }

// Adds a convex polygon; one without area is dropped. With a plane, its normal is that of the plane.
void shape_add(Arena *arena, Shape *shape, const Vec3 *corners, int count, int material);
void shape_add_in_plane(Arena *arena, Shape *shape, const Vec3 *corners, int count, int material,
                        Plane plane);
// Adds a polygon that may be concave, with `ring_count` rings, the first the outer one; ring i has size[i] corners. The rings may turn
// either way; the polygon's normal is that of the first ring. Returns false where it could not be cut into convex ones.
bool shape_add_rings(Arena *arena, Shape *shape, const Vec3 *corners, const int *size, int ring_count,
                     int material);
void shape_append(Arena *arena, Shape *to, const Shape *from);
// The same, turned inside out; each face, and each of some faces, keeps its first corner.
void shape_flip(Shape *shape);
void shape_flip_faces(Shape *shape, int first, int end);
double shape_volume(const Shape *shape);
// An edge of the outline of a group of faces, along which the group's normals have it.
typedef struct ShapeEdge {
    Vec3 from, to;
    int group;
} ShapeEdge;
// Turns groups of faces so that neighbours agree about their sides (orient.c). Group g begins with face first[g] and ends before the next
// one; whether the body as a whole is inside out is left.
void shape_orient(Arena *arena, Shape *shape, const int *first, int group_count, const ShapeEdge *outline,
                  int outline_count);

// The map p -> x * p.x + y * p.y + z * p.z + o.
typedef struct Frame {
    Vec3 x, y, z, o;
} Frame;
static inline Frame frame_identity(void) { return (Frame){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}; }
static inline Vec3 frame_turn(const Frame *f, Vec3 v) {
    return vec3(f->x.x * v.x + f->y.x * v.y + f->z.x * v.z, f->x.y * v.x + f->y.y * v.y + f->z.y * v.z,
                f->x.z * v.x + f->y.z * v.y + f->z.z * v.z);
}
static inline Vec3 frame_point(const Frame *f, Vec3 p) { return vec3_add(frame_turn(f, p), f->o); }
// First `inner`, then `outer`.
static inline Frame frame_join(const Frame *outer, const Frame *inner) {
    return (Frame){frame_turn(outer, inner->x), frame_turn(outer, inner->y), frame_turn(outer, inner->z),
                   frame_point(outer, inner->o)};
}
static inline double frame_volume(const Frame *f) { return vec3_dot(f->x, vec3_cross(f->y, f->z)); }
// The inverse of a frame whose volume is not 0.
Frame frame_inverse(const Frame *f);
// Appends the shape as the frame maps it; mirrored ones keep their normals outwards.
void shape_append_mapped(Arena *arena, Shape *to, const Shape *from, const Frame *frame);

// Cuts a polygon with holes into convex ones. Ring i has size[i] points; the first is the outer one, counter-clockwise, the others
// are clockwise. Writes convex polygon j as out_size[j] indices of points; both arrays come from the arena. Returns their number, or
// -1 where there are too many points.
int convex_pieces(Arena *arena, const Vec2 *points, const int *size, int ring_count, int **out,
                  int **out_size);

// Booleans. `work` grows by the corners looked at. False means that it was too much of all calls together, or that a body lies too far
// away; `out` then is `a` as it was.
typedef enum ShapeBoolean { SHAPE_UNION, SHAPE_DIFFERENCE, SHAPE_INTERSECTION } ShapeBoolean;
// A difference may have many tools, which count as one body; the others have one. All is allocated in `arena`.
bool shape_boolean(Arena *arena, ShapeBoolean operation, const Shape *a, const Shape *const *tools,
                   int tool_count, long long *work, Shape *out);
// The part of a box behind a plane, as a body.
Shape shape_half_space(Arena *arena, Box box, Plane plane);

#endif
