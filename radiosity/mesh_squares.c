// mesh_squares.c - cuts a face along a grid parallel to its longest edge: a rectangle into nx x ny equal parts, another
// convex polygon into squares clipped at its outline, where slivers are joined to their neighbours (Cohen & Wallace
// 1993, chapter 6: elements of even size and good shape).
#include <string.h>

#include "engine/core/polygon.h"
#include "radiosity/mesh_parts.h"

// A part of a square is a sliver below this share of the square: it would receive too few samples to tell its light.
static const double SLIVER = 0.15;
// Below this share it is rounding.
static const double NOTHING = 1e-9;

// How much longer than asked for an element's edges may be. Small faces make them shorter on the average.
static const double LONGEST = 1.15;

// How many squares a side takes: whole patches, at least one.
static int squares_along(double length, const MeshOptions *options) {
    double patches = ceil(length / (LONGEST * options->element * options->per_patch));
    return options->per_patch * (patches < 1 ? 1 : (int)patches);
}

void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count) {
    const Vec3 *points = builder->places.points;
    Vec3 base = points[corner[0]], x = {0};
    double longest = 0;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(points[corner[(i + 1) % count]], points[corner[i]]);
        double length = vec3_length(edge);
        // Of edges equally long but for rounding the first.
        if (length <= longest * (1 + 1e-9)) continue;
        longest = length;
        x = edge;
    }
    x = vec3_normalize(vec3_sub(x, vec3_scale(face->plane.n, vec3_dot(face->plane.n, x))));
    Vec3 y = vec3_cross(face->plane.n, x);
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 p = vec3_sub(points[corner[i]], base);
        x0 = fmin(x0, vec3_dot(x, p));
        x1 = fmax(x1, vec3_dot(x, p));
        y0 = fmin(y0, vec3_dot(y, p));
        y1 = fmax(y1, vec3_dot(y, p));
    }
    const MeshOptions *options = &builder->mesh->options;
    face->nx = squares_along(x1 - x0, options);
    face->ny = squares_along(y1 - y0, options);
    // On the plane, which corners miss where the polygon bends.
    base = vec3_sub(base, vec3_scale(face->plane.n, vec3_dot(face->plane.n, base) - face->plane.d));
    face->origin = vec3_add(base, vec3_add(vec3_scale(x, x0), vec3_scale(y, y0)));
    face->gx = vec3_scale(x, face->nx / (x1 - x0));
    face->gy = vec3_scale(y, face->ny / (y1 - y0));
}

// ---- parts of a face

// Squares i0 .. i1 by j0 .. j1, both included.
typedef struct Block {
    int i0, j0, i1, j1;
} Block;

typedef struct Cutting {
    MeshBuilder *builder;
    const Face *face;
    const Vec3 *outline;  // [count] from the face's origin
    int count;
    Vec3 *part, *spare;  // [count + 8] of the part looked at
    double square;       // area of a whole one, m^2
    double *area;        // [nx * ny] of the part in a square, 0: none; of one that was joined to another 0
    int *owner;          // [nx * ny] the square that stands for the block it is in
    Block *block;        // [nx * ny] of owners
} Cutting;

// The part of the face in a block, from the face's origin; returns how many corners it has.
static int part_in(Cutting *c, Block b) {
    const Face *face = c->face;
    int count = c->count;
    memcpy(c->part, c->outline, (size_t)count * sizeof *c->part);
    // The planes are in units of squares. No cuts along the grid's border, which only rounding could tell from edges.
    const struct {
        bool cut;
        Plane keep;
    } side[4] = {{b.i0 > 0, {face->gx, b.i0}},
                 {b.i1 + 1 < face->nx, {vec3_scale(face->gx, -1), -(b.i1 + 1)}},
                 {b.j0 > 0, {face->gy, b.j0}},
                 {b.j1 + 1 < face->ny, {vec3_scale(face->gy, -1), -(b.j1 + 1)}}};
    for (int k = 0; k < 4; k++) {
        if (!side[k].cut) continue;
        count = polygon_clip(c->part, count, side[k].keep, 0, c->spare);
        Vec3 *swap = c->part;
        c->part = c->spare;
        c->spare = swap;
    }
    return count;
}

static void measure_parts(Cutting *c) {
    for (int j = 0; j < c->face->ny; j++) {
        for (int i = 0; i < c->face->nx; i++) {
            int at = j * c->face->nx + i;
            c->block[at] = (Block){i, j, i, j};
            c->owner[at] = at;
            int count = part_in(c, c->block[at]);
            double area = count < 3 ? 0 : polygon_area(c->part, count);
            c->area[at] = area < NOTHING * c->square ? 0 : area;
        }
    }
}

// The owner beyond one side of a block if the two make a larger block, else -1.
static int beyond(const Cutting *c, Block b, int side) {
    int i = side == 0 ? b.i0 - 1 : side == 1 ? b.i1 + 1 : b.i0;
    int j = side == 2 ? b.j0 - 1 : side == 3 ? b.j1 + 1 : b.j0;
    if (i < 0 || j < 0 || i >= c->face->nx || j >= c->face->ny) return -1;
    int owner = c->owner[j * c->face->nx + i];
    Block other = c->block[owner];
    bool fits = side < 2 ? other.j0 == b.j0 && other.j1 == b.j1 : other.i0 == b.i0 && other.i1 == b.i1;
    return fits && c->area[owner] > 0 ? owner : -1;
}

static bool one_patch(const Cutting *c, int a, int b) {
    int per = c->builder->mesh->options.per_patch, nx = c->face->nx;
    return a % nx / per == b % nx / per && a / nx / per == b / nx / per;
}

// Joins a sliver to the largest neighbour with which it makes a block, one of its own patch first: what a block cuts
// out of a convex polygon is convex.
static bool join(Cutting *c, int at) {
    int best = -1;
    for (int side = 0; side < 4; side++) {
        int other = beyond(c, c->block[at], side);
        if (other < 0) continue;
        bool better = best < 0 || (one_patch(c, at, other) && !one_patch(c, at, best)) ||
                      (one_patch(c, at, other) == one_patch(c, at, best) && c->area[other] > c->area[best]);
        if (better) best = other;
    }
    if (best < 0) return false;
    Block a = c->block[at], b = c->block[best];
    Block both = {a.i0 < b.i0 ? a.i0 : b.i0, a.j0 < b.j0 ? a.j0 : b.j0, a.i1 > b.i1 ? a.i1 : b.i1,
                  a.j1 > b.j1 ? a.j1 : b.j1};
    int keep = c->area[at] > c->area[best] ? at : best, drop = keep == at ? best : at;
    c->area[keep] += c->area[drop];
    c->area[drop] = 0;
    c->block[keep] = both;
    for (int j = both.j0; j <= both.j1; j++)
        for (int i = both.i0; i <= both.i1; i++) c->owner[j * c->face->nx + i] = keep;
    c->builder->mesh->merged_elements++;
    return true;
}

static void join_slivers(Cutting *c) {
    int squares = c->face->nx * c->face->ny;
    for (bool joined = true; joined;) {
        joined = false;
        for (int i = 0; i < squares; i++)
            if (c->area[i] > 0 && c->area[i] < SLIVER * c->square && join(c, i)) joined = true;
    }
}

// ---- elements and patches

// Twice the area times the centroid, and twice the area, of a fan about its first corner.
static void add_centroid(const Vec3 *v, int count, Vec3 n, Vec3 *moment, double *area) {
    for (int i = 1; i + 1 < count; i++) {
        double twice = vec3_dot(n, vec3_cross(vec3_sub(v[i], v[0]), vec3_sub(v[i + 1], v[0])));
        Vec3 sum = vec3_add(v[0], vec3_add(v[i], v[i + 1]));
        *moment = vec3_add(*moment, vec3_scale(sum, twice / 3));
        *area += twice;
    }
}

// Returns false where nothing is left once its corners are places.
static bool add_element(Cutting *c, int at, Patch *patch, Vec3 *moment, double *weight) {
    MeshBuilder *builder = c->builder;
    Mesh *mesh = builder->mesh;
    int count = part_in(c, c->block[at]), first = mesh->corner_count;
    for (int i = 0; i < count; i++) {
        int place = places_add(&builder->places, vec3_add(c->face->origin, c->part[i]));
        if (mesh->corner_count > first && mesh->corners[mesh->corner_count - 1] == place) continue;
        *ARENA_PUSH(builder->arena, mesh->corners, mesh->corner_count, builder->corner_capacity) = place;
    }
    while (mesh->corner_count > first + 1 && mesh->corners[mesh->corner_count - 1] == mesh->corners[first])
        mesh->corner_count--;
    if (mesh->corner_count < first + 3) {
        mesh->corner_count = first;
        return false;
    }
    double area = polygon_area(c->part, count);
    *ARENA_PUSH(builder->arena, mesh->elements, mesh->element_count, builder->element_capacity) =
        (Element){patch->face, mesh->patch_count, first, mesh->corner_count - first, area};
    add_centroid(c->part, count, c->face->plane.n, moment, weight);
    patch->area += area;
    patch->element_count++;
    return true;
}

// The patch whose first square is (i0, j0).
static void add_patch(Cutting *c, int face, int i0, int j0) {
    MeshBuilder *builder = c->builder;
    Mesh *mesh = builder->mesh;
    int per = mesh->options.per_patch, nx = c->face->nx;
    Patch patch = {.face = face, .first_element = mesh->element_count, .cell = -1};
    Vec3 moment = {0};
    double weight = 0;
    for (int j = j0; j < j0 + per; j++) {
        for (int i = i0; i < i0 + per; i++) {
            int at = j * nx + i;
            bool own = c->owner[at] == at && c->area[at] > 0;
            int element = own && add_element(c, at, &patch, &moment, &weight) ? mesh->element_count - 1 : -1;
            mesh->squares[c->face->first_square + at] = element;
        }
    }
    if (patch.element_count == 0) return;
    patch.centre = vec3_scale(moment, 1 / weight);
    // On the plane even where the polygon bends: an eye there must not see its own face.
    Vec3 n = c->face->plane.n;
    patch.centre = vec3_sub(patch.centre, vec3_scale(n, vec3_dot(n, patch.centre)));
    patch.centre = vec3_add(c->face->origin, patch.centre);
    *ARENA_PUSH(builder->arena, mesh->patches, mesh->patch_count, builder->patch_capacity) = patch;
}

void mesh_cut_face(MeshBuilder *builder, int index) {
    Mesh *mesh = builder->mesh;
    Face *face = &mesh->faces[index];
    int squares = face->nx * face->ny;
    arena_reset(&builder->scratch);
    Vec3 *outline = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count);
    for (int i = 0; i < face->vertex_count; i++)
        outline[i] = vec3_sub(builder->places.points[mesh->outline[face->first_vertex + i]], face->origin);
    Cutting c = {.builder = builder,
                 .face = face,
                 .outline = outline,
                 .count = face->vertex_count,
                 .part = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count + 8),
                 .spare = ARENA_ARRAY(&builder->scratch, Vec3, face->vertex_count + 8),
                 .square = 1 / (vec3_length(face->gx) * vec3_length(face->gy)),
                 .area = ARENA_ARRAY(&builder->scratch, double, squares),
                 .owner = ARENA_ARRAY(&builder->scratch, int, squares),
                 .block = ARENA_ARRAY(&builder->scratch, Block, squares)};
    measure_parts(&c);
    join_slivers(&c);
    face->first_square = mesh->square_count;
    face->first_element = mesh->element_count;
    face->first_patch = mesh->patch_count;
    for (int i = 0; i < squares; i++)
        *ARENA_PUSH(builder->arena, mesh->squares, mesh->square_count, builder->square_capacity) = -1;
    int per = mesh->options.per_patch;
    for (int j = 0; j < face->ny; j += per)
        for (int i = 0; i < face->nx; i += per) add_patch(&c, index, i, j);
    int *square = mesh->squares + face->first_square;
    for (int i = 0; i < squares; i++) square[i] = square[c.owner[i]];
    face->element_count = mesh->element_count - face->first_element;
    face->patch_count = mesh->patch_count - face->first_patch;
}
