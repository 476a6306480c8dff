// prt_scene.c - portal files in memory, and a row of rooms whose visibility is known.
#include "tests/support/prt_scene.h"

#include <criterion/criterion.h>

#include "engine/core/text.h"
#include "maps/maps.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_PRT;

CellGraph *prt_scene(Arena *arena, const char *text) {
    Building *building = ARENA_ARRAY(arena, Building, 1);
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    VisOptions options = vis_default_options();
    Error error = {""};
    size_t size = strlen(text);
    Bytes content = {(unsigned char *)arena_string(arena, text), size};
    cr_assert(MAPS_READER_PRT.read("scene.prt", content, arena, building, &error), "%s", error.text);
    building->source = "scene.prt";
    cr_assert(vis_build_cells(building, &options, arena, graph, &error), "%s", error.text);
    return graph;
}

// A shear: under it convex polygons stay convex, and flat ones flat.
static Vec3 tilted(Vec3 v) {
    static const double UNITS = 32;  // a metre
    return vec3_scale(vec3(v.x + 0.11 * v.y + 0.17 * v.z, v.y - 0.13 * v.z, v.z + 0.07 * v.x + 0.05 * v.y),
                      UNITS);
}

const char *prt_file(Arena *arena, const char *name, const char *building) {
    char *shared = arena_format(arena, "prt/%s.prt", name);
    if (support_has_shared(shared)) return arena_string(arena, support_shared(shared));
    Building b;
    CellGraph graph;
    Error error = {""};
    VisOptions options = vis_default_options();
    cr_assert(maps_read(building, arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, arena, &graph, &error), "%s", error.text);
    Text text = {.arena = arena};
    text_append(&text, "PRT1\n%d\n%d\n", graph.cell_count, graph.portal_count);
    for (int p = 0; p < graph.portal_count; p++) {
        const Portal *portal = &graph.portals[p];
        text_append(&text, "%d %d %d", portal->vertex_count, portal->cell[0], portal->cell[1]);
        // Counter-clockwise from the first cell becomes clockwise: the file's normal points out of it.
        for (int i = portal->vertex_count - 1; i >= 0; i--) {
            Vec3 v = tilted(graph.portal_vertices[portal->first_vertex + i]);
            text_append(&text, " (%.12f %.12f %.12f )", v.x, v.y, v.z);
        }
        text_append(&text, "\n");
    }
    char *path = arena_format(arena, "%s/home.prt", support_folder(arena));
    cr_assert(file_write(path, text.data, strlen(text.data), &error), "%s", error.text);
    return path;
}

static void random_interval(Random *random, int interval[2]) {
    interval[0] = random_index(random, 60);
    interval[1] = interval[0] + 4 + random_index(random, 64);
}

Row row_random(Random *random, int room_count) {
    Row row = {.room_count = room_count};
    for (int k = 0; k < room_count; k++) {
        random_interval(random, row.doorway[k].y);
        random_interval(random, row.doorway[k].z);
        row.wall[k + 1] = row.wall[k] + ROW_SHORTEST + random_index(random, 2 * ROW_SHORTEST);
    }
    return row;
}

CellGraph *row_graph(Arena *arena, const Row *row) {
    Text text = {.arena = arena};
    text_append(&text, "PRT1\n%d\n%d\n", row->room_count, row->room_count - 1);
    for (int k = 0; k + 1 < row->room_count; k++) {
        const int *y = row->doorway[k].y, *z = row->doorway[k].z, x = row->wall[k];
        text_append(&text, "4 %d %d (%d %d %d ) (%d %d %d ) (%d %d %d ) (%d %d %d )\n", k, k + 1, x, y[0],
                    z[1], x, y[0], z[0], x, y[1], z[0], x, y[1], z[1]);
    }
    return prt_scene(arena, text.data);
}

// Three parallel intervals are crossed by a line iff the middle one meets what the outer two span at its place. A
// family of them is iff each three are (L. Santalo, 1940: Helly's theorem for parallel segments).
static RowSight three(const int *near, const int *middle, const int *far, long before, long after) {
    long low = near[0] * after + far[0] * before, high = near[1] * after + far[1] * before;
    long bottom = middle[0] * (before + after), top = middle[1] * (before + after);
    if (low > top || high < bottom) return ROW_HIDDEN;
    return low == top || high == bottom ? ROW_TOUCHED : ROW_SEEN;
}

RowSight row_sight(const Row *row, int a, int b, bool heights) {
    RowSight least = ROW_SEEN;
    for (int i = a; i < b; i++) {
        for (int j = i + 1; j < b; j++) {
            for (int k = j + 1; k < b; k++) {
                long before = row->wall[j] - row->wall[i], after = row->wall[k] - row->wall[j];
                const Doorway *near = &row->doorway[i], *middle = &row->doorway[j], *far = &row->doorway[k];
                RowSight y = three(near->y, middle->y, far->y, before, after);
                RowSight z = heights ? three(near->z, middle->z, far->z, before, after) : ROW_SEEN;
                if (y < least) least = y;
                if (z < least) least = z;
            }
        }
    }
    return least;
}
