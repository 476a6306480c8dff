// sky_openings.c - portals of which one side alone is outdoors, cut by a grid in their planes: each piece is seen from, and sees,
// as from its middle.
#include "radiosity/shoot/sky_openings.h"

#include "engine/core/error.h"
#include "engine/core/polygon.h"

// Side of a piece aimed at, metres: small to the distance of what stands near a window; and how many pieces there are before
// they become larger.
static const double PIECE = 0.2;
static const double MOST_PIECES = 50000;

bool sky_is_outdoors(const CellGraph *graph, int cell) {
    return vis_region(graph, cell)->kind == REGION_OUTDOORS;
}

static Vec3 centre_of(const Vec3 *v, int count) {
    Vec3 sum = {0, 0, 0};
    double area = 0;
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = vec3_sub(v[i], v[0]), b = vec3_sub(v[i + 1], v[0]);
        double twice = vec3_length(vec3_cross(a, b));
        sum = vec3_add(sum, vec3_scale(vec3_add(a, b), twice / 3));
        area += twice;
    }
    return area > 0 ? vec3_add(v[0], vec3_scale(sum, 1 / area)) : v[0];
}

// The part of a polygon from `low` to `high` along x. `out` has room for count + 2.
static int strip(const Vec3 *polygon, int count, Vec3 x, double low, double high, Vec3 *out) {
    Vec3 part[SKY_CORNERS];
    int left = polygon_clip(polygon, count, (Plane){x, low}, 0, part);
    return left < 3 ? 0 : polygon_clip(part, left, (Plane){vec3_scale(x, -1), -high}, 0, out);
}

static void extent(const Vec3 *polygon, int count, Vec3 x, double *low, double *high) {
    *low = INFINITY, *high = -INFINITY;
    for (int i = 0; i < count; i++) {
        *low = fmin(*low, vec3_dot(x, polygon[i]));
        *high = fmax(*high, vec3_dot(x, polygon[i]));
    }
}

static void cut_opening(SkyOpenings *out, int opening, double size, Arena *arena, int *capacity) {
    const SkyOpening *o = &out->openings[opening];
    Vec3 x, y, corner = o->vertices[0], polygon[SKY_CORNERS], column[SKY_CORNERS], piece[SKY_CORNERS];
    CORE_ASSERT(o->count + 4 < SKY_CORNERS);
    view_axes(o->plane.n, &x, &y);
    // About a corner, so that far from the origin no digits are lost.
    for (int i = 0; i < o->count; i++) polygon[i] = vec3_sub(o->vertices[i], corner);
    double left, right, low, high;
    extent(polygon, o->count, x, &left, &right);
    int columns = (int)fmax(ceil((right - left) / size), 1);
    for (int i = 0; i < columns; i++) {
        double from = left + (right - left) * i / columns, to = left + (right - left) * (i + 1) / columns;
        int in_column = strip(polygon, o->count, x, from, to, column);
        if (in_column < 3) continue;
        extent(column, in_column, y, &low, &high);
        int rows = (int)fmax(ceil((high - low) / size), 1);
        for (int j = 0; j < rows; j++) {
            int count = strip(column, in_column, y, low + (high - low) * j / rows,
                              low + (high - low) * (j + 1) / rows, piece);
            double area = count < 3 ? 0 : polygon_area(piece, count);
            if (area < MAPS_SMALLEST_AREA) continue;
            *ARENA_PUSH(arena, out->pieces, out->piece_count, *capacity) =
                (SkyPiece){opening, vec3_add(corner, centre_of(piece, count)), area};
        }
    }
}

SkyOpenings sky_openings(const CellGraph *graph, Arena *arena) {
    SkyOpenings out = {.openings = ARENA_ARRAY(arena, SkyOpening, graph->portal_count + 1)};
    double area = 0;
    int capacity = 0;
    for (int p = 0; p < graph->portal_count; p++) {
        const Portal *portal = &graph->portals[p];
        bool first = sky_is_outdoors(graph, portal->cell[0]),
             second = sky_is_outdoors(graph, portal->cell[1]);
        if (first == second) continue;
        Plane plane = portal->plane;  // towards cell[0]
        if (first) plane = (Plane){vec3_scale(plane.n, -1), -plane.d};
        const Vec3 *vertices = graph->portal_vertices + portal->first_vertex;
        area += polygon_area(vertices, portal->vertex_count);
        out.openings[out.count++] =
            (SkyOpening){portal->cell[first], portal->cell[!first], plane, vertices, portal->vertex_count};
    }
    double size = fmax(PIECE, sqrt(area / MOST_PIECES));
    for (int o = 0; o < out.count; o++) cut_opening(&out, o, size, arena, &capacity);
    return out;
}
