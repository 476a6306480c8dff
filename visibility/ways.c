// ways.c - directed portals, and the flood through one of them.
//
// The flood is the base pass of Quake's vis (J. Carmack, 1996).
#include "visibility/ways.h"

// A portal of more corners is replaced by a rectangle around it, so that a winding has room to be clipped.
enum { MOST_CORNERS = WINDING_MAX / 2 };

// The rectangle in the plane around `corners`, counter-clockwise about its normal.
static void surround(Plane plane, const Vec3 *corners, int count, Vec3 out[4]) {
    Vec3 x = vec3_normalize(vec3_sub(corners[1], corners[0])), y = vec3_cross(plane.n, x);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < count; i++) {
        double at[2] = {vec3_dot(x, corners[i]), vec3_dot(y, corners[i])};
        for (int k = 0; k < 2; k++) low[k] = fmin(low[k], at[k]), high[k] = fmax(high[k], at[k]);
    }
    Vec3 base = vec3_scale(plane.n, plane.d);
    for (int i = 0; i < 4; i++) {
        double u = i == 0 || i == 3 ? low[0] : high[0], v = i < 2 ? low[1] : high[1];
        out[i] = vec3_add(base, vec3_add(vec3_scale(x, u), vec3_scale(y, v)));
    }
}

static const double *way_rows(const Vec3 *corners, int count, Arena *arena) {
    int row = way_row(count);
    double *rows = ARENA_ARRAY(arena, double, 3 * row);
    for (int i = 0; i < row; i++) {
        Vec3 p = corners[i < count ? i : 0];
        rows[i] = p.x, rows[row + i] = p.y, rows[2 * row + i] = p.z;
    }
    return rows;
}

// `size` is that of the building.
static void set_way(const CellGraph *graph, Vec3 origin, double size, int index, Arena *arena,
                    WayShape *way) {
    // A plane that is sure to so many epsilons throughout the building is as good as exact.
    static const double EXACT = 1e-2;
    const Portal *portal = &graph->portals[index / 2];
    bool back = index % 2;
    const Vec3 *given = graph->portal_vertices + portal->first_vertex;
    int count = portal->vertex_count;
    *way = (WayShape){.from = portal->cell[back], .to = portal->cell[!back], .coarse = count > MOST_CORNERS};
    // The portal is counter-clockwise seen from cell[0]: its normal points against way 2 p.
    Vec3 *corners = ARENA_ARRAY(arena, Vec3, count);
    int distinct = 0;
    for (int i = 0; i < count; i++) {
        Vec3 p = vec3_sub(given[back ? i : count - 1 - i], origin);
        if (distinct == 0 || !vec3_equal(p, corners[distinct - 1])) corners[distinct++] = p;
    }
    while (distinct > 3 && vec3_equal(corners[0], corners[distinct - 1])) distinct--;
    count = distinct;
    way->facet.plane = plane_of_polygon(corners, count);
    for (int i = 0; i < count; i++)
        way->facet.bend = fmax(way->facet.bend, fabs(plane_distance(way->facet.plane, corners[i])));
    if (way->coarse) {
        Vec3 around[4];
        surround(way->facet.plane, corners, count, around);
        memcpy(corners, around, sizeof around);
        count = 4;
    }
    double area = polygon_area(corners, count);
    way->corners = corners;
    way->corner_count = count;
    way->rows = way_rows(corners, count, arena);
    for (int i = 0; i < count; i++)
        way->facet.middle = vec3_add(way->facet.middle, vec3_scale(corners[i], 1.0 / count));
    for (int i = 0; i < count; i++)
        way->radius = fmax(way->radius, vec3_length(vec3_sub(corners[i], way->facet.middle)));
    // Over its width, area / (2 radius), the plane is sure to within the bend; beyond, the error grows with distance.
    way->facet.tilt = 2 * way->facet.bend * way->radius / fmax(area, 1e-300);
    if (way->facet.bend + way->facet.tilt * size <= EXACT * WAY_EPSILON * size)
        way->facet.bend = way->facet.tilt = 0;
}

static double work_scale(const Building *building) {
    // Real Doom maps of half a megabyte take twenty times what all else does that is so small, portal files of Quake maps three to five
    // times, and are worth it.
    static const double SMALL = 1e6, OF_MAPS = 24, OF_CELLS = 4;
    double times = building ? building->file_size / SMALL : 1;
    if (times < 1) times = 1;
    if (!building) return times;
    return times * times * (building->map ? OF_MAPS : building->form == FORM_CELLS ? OF_CELLS : 1);
}

// Where cells are, and the ways out of each; all but `ways` and the numbers.
static void sort_ways(WayGraph *graph, Arena *arena) {
    int cells = graph->cell_count;
    graph->first = ARENA_ARRAY(arena, int, cells + 1);
    graph->list = ARENA_ARRAY(arena, int, graph->way_count);
    graph->boxes = ARENA_ARRAY(arena, Box, cells);
    int *fill = ARENA_ARRAY(arena, int, cells);
    for (int c = 0; c < cells; c++) graph->boxes[c] = box_empty();
    for (int i = 0; i < graph->way_count; i++) {
        const WayShape *way = &graph->ways[i];
        graph->first[way->from + 1]++;
        for (int k = 0; k < way->corner_count; k++)
            graph->boxes[way->from] = box_add(graph->boxes[way->from], way->corners[k]);
    }
    for (int c = 0; c < cells; c++) graph->first[c + 1] += graph->first[c];
    for (int i = 0; i < graph->way_count; i++) {
        int cell = graph->ways[i].from;
        graph->list[graph->first[cell] + fill[cell]++] = i;
    }
}

static void set_rows(WayGraph *graph, Arena *arena) {
    WayRows *rows = &graph->rows;
    double **all[] = {&rows->x,  &rows->y,  &rows->z, &rows->radius, &rows->nx,
                      &rows->ny, &rows->nz, &rows->d, &rows->doubt};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        *all[i] = ARENA_ARRAY(arena, double, graph->way_count + FOUR);
    graph->to = ARENA_ARRAY(arena, int, graph->way_count + FOUR);
    for (int i = 0; i < graph->way_count; i++) {
        const WayShape *way = &graph->ways[graph->list[i]];
        const Facet *f = &way->facet;
        rows->x[i] = f->middle.x, rows->y[i] = f->middle.y, rows->z[i] = f->middle.z;
        rows->nx[i] = f->plane.n.x, rows->ny[i] = f->plane.n.y, rows->nz[i] = f->plane.n.z;
        rows->d[i] = f->plane.d;
        rows->radius[i] = way->radius;
        rows->doubt[i] = f->bend > 0 ? INFINITY : 0;
        graph->to[i] = way->to;
    }
}

void ways_build(const CellGraph *graph, Arena *arena, WayGraph *out) {
    int ways = 2 * graph->portal_count, cells = graph->cell_count;
    double size = vec3_length(vec3_sub(graph->box.max, graph->box.min));
    Vec3 origin = vec3_scale(vec3_add(graph->box.min, graph->box.max), 0.5);
    *out = (WayGraph){.origin = origin,
                      .epsilon = WAY_EPSILON * size,
                      .cell_count = cells,
                      .way_count = ways,
                      .words = (cells + 63) / 64,
                      .scale = work_scale(graph->building),
                      .ways = ARENA_ARRAY(arena, WayShape, ways)};
    for (int i = 0; i < ways; i++) set_way(graph, origin, size, i, arena, &out->ways[i]);
    sort_ways(out, arena);
    set_rows(out, arena);
}

void ways_take(const WayGraph *whole, const int *portal, int portal_count, const int *place, int cell_count,
               Arena *arena, WayGraph *out) {
    *out = (WayGraph){.origin = whole->origin,
                      .epsilon = whole->epsilon,
                      .cell_count = cell_count,
                      .way_count = 2 * portal_count,
                      .words = (cell_count + 63) / 64,
                      .scale = whole->scale,
                      .ways = ARENA_ARRAY(arena, WayShape, 2 * portal_count)};
    for (int i = 0; i < out->way_count; i++) {
        WayShape *way = &out->ways[i];
        *way = whole->ways[2 * portal[i / 2] + i % 2];
        way->from = place[way->from];
        way->to = place[way->to];
    }
    sort_ways(out, arena);
    set_rows(out, arena);
}

bool way_is_segment(const CellGraph *graph, int way, double epsilon) {
    const Portal *portal = &graph->portals[way / 2];
    if (portal->horizontal) return false;
    Vec2 along = vec2_sub(portal->right, portal->left);
    for (int i = portal->first_vertex; i < portal->first_vertex + portal->vertex_count; i++) {
        Vec3 v = graph->portal_vertices[i];
        double aside = vec2_cross(along, vec2_sub(vec2(v.x, v.y), portal->left));
        if (fabs(aside) > epsilon * vec2_length(along)) return false;
    }
    return true;
}

// Does any corner of `way` lie on the given side of `plane` (+1 in front, -1 behind), by more than `slack`? One does if
// their middle does.
static bool reaches(const WayShape *way, Plane plane, int side, double slack) {
    if (side * plane_distance(plane, way->facet.middle) > slack) return true;
    for (int i = 0; i < way->corner_count; i++) {
        if (side * plane_distance(plane, way->corners[i]) > slack) return true;
    }
    return false;
}

// May a line come through the first way and then through the other, as far as their planes tell?
static bool faces(const WayGraph *graph, const WayShape *first, const WayShape *next) {
    double doubt = way_doubt(first, next);
    return plane_distance(first->facet.plane, next->facet.middle) >= -next->radius - doubt &&
           reaches(next, first->facet.plane, 1, graph->epsilon - doubt) &&
           reaches(first, next->facet.plane, -1, graph->epsilon - way_doubt(next, first));
}

// The same for four ways of the list at once by the balls around them: which surely do (`sure`), and which may. A plane's doubt only
// ever lets more through.
static unsigned four_face(const WayGraph *graph, const WayShape *first, int at, unsigned *sure) {
    const WayRows *r = &graph->rows;
    Vec3 n = first->facet.plane.n, m = first->facet.middle;
    Four before = four_load(r->x + at) * n.x + four_load(r->y + at) * n.y + four_load(r->z + at) * n.z -
                  first->facet.plane.d;
    Four behind = four_load(r->d + at) - four_load(r->nx + at) * m.x - four_load(r->ny + at) * m.y -
                  four_load(r->nz + at) * m.z;
    *sure = four_lanes((before > graph->epsilon) & (behind > graph->epsilon));
    double doubt = first->facet.bend > 0 ? INFINITY : 0;
    return four_lanes((before >= -four_load(r->radius + at) - doubt) &
                      (behind >= -four_load(r->doubt + at) - first->radius));
}

long long ways_flood(const WayGraph *graph, int way, uint64_t *row, int *stack) {
    // For all floods together; a try takes 10 ns.
    static const double TRIES = 5e7;
    const WayShape *first = &graph->ways[way];
    long long tried = 0, most = ways_work(graph, TRIES) / graph->way_count;
    int depth = 0;
    stack[depth++] = first->to;
    row_add(row, first->to);
    bool all = false;
    while (depth > 0 && !all) {
        int cell = stack[--depth];
        all = tried > most;
        // With cells left on the stack the flood is known to take too long before a cell of thousands of ways is done.
        for (int i = graph->first[cell], end = graph->first[cell + 1]; i < end && !all; i += FOUR) {
            unsigned fresh = 0, sure;
            for (int k = 0; k < FOUR && i + k < end; k++)
                fresh |= (unsigned)(!row_has(row, graph->to[i + k]) && graph->list[i + k] != (way ^ 1)) << k;
            if (!fresh) continue;
            tried += __builtin_popcount(fresh);
            all = tried > most && depth > 0;
            unsigned may = fresh & four_face(graph, first, i, &sure);
            for (; may; may &= may - 1) {
                int k = __builtin_ctz(may), to = graph->to[i + k];
                if (row_has(row, to)) continue;
                if (!(sure >> k & 1) && !faces(graph, first, &graph->ways[graph->list[i + k]])) continue;
                row_add(row, to);
                stack[depth++] = to;
            }
        }
    }
    if (all) row_add_all(row, graph->cell_count);
    return tried;
}
