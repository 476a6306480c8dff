// image.h - facets as they lie in a picture. Through an eye everything is a line: an edge of a facet, where a plane cuts it,
// and 1/depth are each a x + b y + c at pixel (x, y), exact to the rounding of doubles, also for facets that pass through
// the eye's plane (J. Blinn & M. Newell, Clipping using homogeneous coordinates, 1978).
//
// Pixel (x, y) has its sample at whole x and y: half a pixel off the coordinates of camera_ray.
#ifndef VISIBILITY_IMAGE_H
#define VISIBILITY_IMAGE_H

#include "engine/core/lanes.h"
#include "visibility/hidden/facets.h"

// a x + b y + c in lanes 0, 1, 2; lane 3 is 0. Of an edge: not below 0 inside.
typedef Four Line;

static inline double line_at(const Line *line, double x, double y) {
    return (*line)[0] * x + ((*line)[1] * y + (*line)[2]);
}

// Where a picture is taken from. A point at d from the eye is seen at (x, y) = (X / Z, Y / Z), with (X, Y, Z) = the sum of
// columns times d; along the pixel's ray, corner + x right + y down, it is Z away.
typedef struct Image {
    Vec3 eye, corner, right, down;
    Four column[3];
    int width, height;
} Image;

typedef struct Shape {
    int facet;
    int x0, x1, y0, y1;          // of the pixels it may cover, within the picture; never empty
    int first_line, line_count;  // its edges
    double nearest, farthest;    // bounds of 1/depth over the polygons in the picture, padded for rounding
} Shape;

// A picture under way.
typedef struct Picture {
    const Facets *facets;
    Image image;
    Line *depth;    // [facets->count] 1/z, of facets that are seen
    Shape *shapes;  // [shape_count <= facets->count], in order of the list
    Line *lines;    // [facets->corner_count]
    int shape_count;
} Picture;

Image image_new(const Camera *camera);

// The facet in the picture, its edges in lines[0 .. count) and 1/depth; false if it cannot be seen.
bool image_shape(const Image *image, const Facets *facets, int facet, Line *lines, Line *depth, Shape *out);

// A convex polygon's part in the picture and up to a pixel around it, in pixels; `inverse`: 1/z at its corners. Room
// for count + 4 corners. Returns how many there are, 0: none.
int image_outline(const Image *image, const Vec3 *corners, int count, Vec2 *out, double *inverse);

// Pixels that such corners span; false: none.
bool image_bounds(const Image *image, const Vec2 *corners, int count, Shape *out);

// The line in which the plane dot(n, p) = d cuts a facet whose 1/depth is given: above 0 where the facet lies on n's side.
Line image_cut(const Image *image, Vec3 n, double d, Line depth);

// Holds what pictures of these facets need; image_shapes fills in all shapes of one.
Picture picture_new(const Facets *facets, Arena *arena);
void picture_take(Picture *picture, const Camera *camera);

// An item buffer of facets (-1: nothing) becomes one of polygons, and its depths are found.
void picture_resolve(const Picture *picture, ItemBuffer *out);

#endif
