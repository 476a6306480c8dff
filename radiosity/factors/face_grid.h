// face_grid.h - the grid of a face in the axes of a view: it tells on which element a point of the face lies.
#ifndef RADIOSITY_FACE_GRID_H
#define RADIOSITY_FACE_GRID_H

#include "radiosity/factors/view.h"

// The point p of the face's plane, in the view's axes, lies in square (floor x, floor y), where x = dot(gx, p) + x0 and
// y = dot(gy, p) + y0.
typedef struct FaceGrid {
    Vec3 gx, gy;  // 1 / metres
    double x0, y0;
    int nx, ny;
    const Mesh *mesh;
    int first_square;
} FaceGrid;

static inline Vec3 face_grid_turn(const View *view, Vec3 v) {
    return vec3(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
}

static inline FaceGrid face_grid(const Mesh *mesh, const View *view, int face) {
    const Face *f = &mesh->faces[face];
    Vec3 eye = vec3_sub(view->eye, f->origin);
    return (FaceGrid){.gx = face_grid_turn(view, f->gx),
                      .gy = face_grid_turn(view, f->gy),
                      .x0 = vec3_dot(f->gx, eye),
                      .y0 = vec3_dot(f->gy, eye),
                      .nx = f->nx,
                      .ny = f->ny,
                      .mesh = mesh,
                      .first_square = f->first_square};
}

static inline int face_grid_clamp(double x, int n) { return x >= n ? n - 1 : x > 0 ? (int)x : 0; }

// The element of square (i, j), the largest if the square has several. Where the square has none (the point is a rounding past the
// polygon's edge), the element of the nearest square that has one.
static inline int face_grid_element(const FaceGrid *grid, int i, int j) {
    int element = mesh_square(grid->mesh, grid->first_square + j * grid->nx + i);
    for (int reach = 1; element < 0 && reach < grid->nx + grid->ny; reach++) {
        int i0 = i > reach ? i - reach : 0, i1 = i + reach < grid->nx ? i + reach : grid->nx - 1;
        int j0 = j > reach ? j - reach : 0, j1 = j + reach < grid->ny ? j + reach : grid->ny - 1;
        for (int v = j0; v <= j1 && element < 0; v++)
            for (int u = i0; u <= i1 && element < 0; u++)
                element = mesh_square(grid->mesh, grid->first_square + v * grid->nx + u);
    }
    return element;
}

#endif
