// walk_occlusion.c - ambient occlusion from distances (A. Evans, Fast approximations for global illumination on dynamic
// scenes, 2006): steps are taken from the point along its normal, and where something is nearer to a step's end than the step is
// long, part of the light is blocked. Distances are to upright boxes: walls are boxes without thickness, furniture has its
// proxies; floors and ceilings are planes.
#include "engine/shade/walk_occlusion.h"

#include "engine/shade/walk_shade.h"

// Furniture larger than this in plan both ways is hollow (a pergola, a roof): its box darkens nothing, metres.
#define OCCLUDER_MOST 2.6
// Furniture thinner than this lies flat and occludes nothing (carpets), metres.
#define OCCLUDER_LEAST 0.05
// Squares of the plan are no smaller than this, metres, and there are at most so many of them each way.
#define SQUARE_LEAST 1.0
#define SQUARES_MOST 512

// Furniture does not fill its box: it blocks this share of the light that a wall would block.
#define FURNITURE_BLOCKS 0.6
// The steps, as shares of the reach, and the share of the light that each can block. In a corner of two walls each step blocks its whole
// share.
static const double STEP[] = {0.15, 0.4, 1.0}, STEP_BLOCKS[] = {0.18, 0.19, 0.18};
enum { STEPS = sizeof STEP / sizeof *STEP };

typedef struct Occluder {
    Vec2 middle, along;  // in plan; `along` is the unit direction of its first side
    double half_x, half_y, half_z, z;
    double blocks;  // the share of each step's light that it can block
    int object;
} Occluder;

struct WalkOcclusion {
    const CellGraph *graph;
    Occluder *occluders;
    int *square_first;  // [nx * ny + 1] in square_occluders: the occluders within reach of each square
    int *square_occluders;
    Vec2 corner;
    double side;  // of a square
    int nx, ny, count, capacity;
};

// ---- occluders

static void add_box(WalkOcclusion *occlusion, Arena *arena, int object) {
    const Object *o = &occlusion->graph->objects[object];
    if (!o->proxy) return;
    const Vec2 *corner = o->proxy->corner;
    Vec2 x = vec2_sub(corner[1], corner[0]), y = vec2_sub(corner[3], corner[0]);
    double width = vec2_length(x), depth = vec2_length(y), height = o->proxy->z1 - o->proxy->z0;
    if (height < OCCLUDER_LEAST || width <= 0 || fmin(width, depth) > OCCLUDER_MOST) return;
    *ARENA_APPEND(arena, occlusion->occluders, occlusion->count, occlusion->capacity) =
        (Occluder){vec2_scale(vec2_add(corner[0], corner[2]), 0.5),
                   vec2_scale(x, 1 / width),
                   width / 2,
                   depth / 2,
                   height / 2,
                   (o->proxy->z0 + o->proxy->z1) / 2,
                   o->kind == OBJECT_FURNITURE ? FURNITURE_BLOCKS : 1,
                   object};
}

static void add_wall(WalkOcclusion *occlusion, Arena *arena, int object) {
    const CellGraph *graph = occlusion->graph;
    const Polygon *p = &graph->polygons[graph->objects[object].first_polygon];
    const Vec3 *v = graph->vertices + p->first_vertex;
    Plane plane = plane_of_polygon(v, p->vertex_count);
    if (fabs(plane.n.z) > 0.5) return;  // floors and ceilings are taken from the region
    Vec2 along = vec2(-plane.n.y, plane.n.x);
    double low = INFINITY, high = -INFINITY, z0 = INFINITY, z1 = -INFINITY;
    for (int i = 0; i < p->vertex_count; i++) {
        double at = vec2_dot(along, vec2(v[i].x, v[i].y));
        low = fmin(low, at);
        high = fmax(high, at);
        z0 = fmin(z0, v[i].z);
        z1 = fmax(z1, v[i].z);
    }
    Vec2 on_plane = vec2(plane.n.x * plane.d, plane.n.y * plane.d);
    *ARENA_APPEND(arena, occlusion->occluders, occlusion->count, occlusion->capacity) =
        (Occluder){vec2_add(on_plane, vec2_scale(along, (low + high) / 2)),
                   along,
                   (high - low) / 2,
                   0,
                   (z1 - z0) / 2,
                   (z0 + z1) / 2,
                   1,
                   object};
}

static void add_occluders(WalkOcclusion *occlusion, Arena *arena) {
    for (int o = 0; o < occlusion->graph->object_count; o++) {
        ObjectKind kind = occlusion->graph->objects[o].kind;
        if (kind == OBJECT_SURFACE) add_wall(occlusion, arena, o);
        // Stairs are left out: their box is mostly air.
        if (kind == OBJECT_FURNITURE || kind == OBJECT_LOW_WALL) add_box(occlusion, arena, o);
    }
    occlusion->occluders = arena_fit(arena, occlusion->occluders, sizeof *occlusion->occluders,
                                     occlusion->count, occlusion->capacity);
}

// ---- squares of the plan

static int square_of(double x, double corner, double side, int count) {
    double i = floor((x - corner) / side);
    return i < 0 ? 0 : i >= count ? count - 1 : (int)i;
}

typedef struct SquareRange {
    int i0, i1, j0, j1;
} SquareRange;

static SquareRange squares_within_reach(const WalkOcclusion *occlusion, const Occluder *o) {
    // The end of a step is up to the reach away from the point, and occluders count up to the reach from there.
    double far = 2 * WALK_OCCLUSION_REACH;
    double x = fabs(o->along.x) * o->half_x + fabs(o->along.y) * o->half_y + far;
    double y = fabs(o->along.y) * o->half_x + fabs(o->along.x) * o->half_y + far;
    return (SquareRange){square_of(o->middle.x - x, occlusion->corner.x, occlusion->side, occlusion->nx),
                         square_of(o->middle.x + x, occlusion->corner.x, occlusion->side, occlusion->nx),
                         square_of(o->middle.y - y, occlusion->corner.y, occlusion->side, occlusion->ny),
                         square_of(o->middle.y + y, occlusion->corner.y, occlusion->side, occlusion->ny)};
}

static void fill_squares(WalkOcclusion *occlusion, Arena *arena) {
    Box box = occlusion->graph->box;
    double width = box.max.x - box.min.x, depth = box.max.y - box.min.y;
    occlusion->side = fmax(SQUARE_LEAST, fmax(width, depth) / SQUARES_MOST);
    occlusion->corner = vec2(box.min.x, box.min.y);
    occlusion->nx = (int)(width / occlusion->side) + 1;
    occlusion->ny = (int)(depth / occlusion->side) + 1;
    int squares = occlusion->nx * occlusion->ny;
    int *first = occlusion->square_first = ARENA_ARRAY(arena, int, squares + 1);
    // Occluders are counted, then each square's run is filled from its end: afterwards `first` holds where each run begins.
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < occlusion->count; k++) {
            SquareRange r = squares_within_reach(occlusion, &occlusion->occluders[k]);
            for (int j = r.j0; j <= r.j1; j++) {
                for (int i = r.i0; i <= r.i1; i++) {
                    int square = j * occlusion->nx + i;
                    if (pass == 0) {
                        first[square]++;
                    } else {
                        occlusion->square_occluders[--first[square]] = k;
                    }
                }
            }
        }
        if (pass == 1) break;
        for (int s = 1; s < squares; s++) first[s] += first[s - 1];
        first[squares] = squares > 0 ? first[squares - 1] : 0;
        occlusion->square_occluders = ARENA_ARRAY(arena, int, first[squares] + 1);
    }
}

WalkOcclusion *walk_occlusion_new(const CellGraph *graph, Arena *arena) {
    WalkOcclusion *occlusion = ARENA_ARRAY(arena, WalkOcclusion, 1);
    occlusion->graph = graph;
    add_occluders(occlusion, arena);
    fill_squares(occlusion, arena);
    return occlusion;
}

// ---- how open

// A comparison replaces fmax, which is a call because it minds NAN: calls would take a third of the time.
static inline double larger(double a, double b) { return a > b ? a : b; }

// The distance from a point to the occluder's box; negative inside.
static double distance_to(const Occluder *o, Vec3 p) {
    Vec2 from = vec2(p.x - o->middle.x, p.y - o->middle.y);
    double x = fabs(vec2_dot(o->along, from)) - o->half_x, y = fabs(vec2_cross(o->along, from)) - o->half_y,
           z = fabs(p.z - o->z) - o->half_z;
    double inside = larger(x, larger(y, z));
    if (inside <= 0) return inside;
    double ox = larger(x, 0), oy = larger(y, 0), oz = larger(z, 0);
    return sqrt(ox * ox + oy * oy + oz * oz);
}

// The distance from the end of a step to the region's floor or ceiling. For a point on that floor or ceiling it is the step's length.
static double distance_to_levels(const WalkOcclusion *occlusion, Vec3 p, int region) {
    if (region < 0) return INFINITY;
    const Region *r = &occlusion->graph->building->regions[region];
    double below = r->floor_material >= 0 ? p.z - r->z0 : INFINITY,
           above = r->ceiling_material >= 0 ? r->z1 - p.z : INFINITY;
    return fmin(below, above);
}

double walk_occlusion_open(const WalkOcclusion *occlusion, Vec3 point, Vec3 n, int region, int self) {
    int i = square_of(point.x, occlusion->corner.x, occlusion->side, occlusion->nx),
        j = square_of(point.y, occlusion->corner.y, occlusion->side, occlusion->ny);
    int square = j * occlusion->nx + i, from = occlusion->square_first[square],
        to = occlusion->square_first[square + 1];
    double open = 1;
    for (int s = 0; s < STEPS; s++) {
        double length = STEP[s] * WALK_OCCLUSION_REACH;
        Vec3 p = vec3_add(point, vec3_scale(n, length));
        double most = 1 - distance_to_levels(occlusion, p, region) / length;
        for (int k = from; k < to; k++) {
            const Occluder *o = &occlusion->occluders[occlusion->square_occluders[k]];
            if (o->object != self) most = larger(most, o->blocks * (1 - distance_to(o, p) / length));
        }
        open -= STEP_BLOCKS[s] * larger(most, 0);
    }
    return fmax(open, 0);
}
