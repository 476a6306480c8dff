// test_wad_maps.c - real Doom maps: those of the shared data, and of Freedoom as Debian packages it (apt-get install freedoom).
#include <criterion/criterion.h>
#include <dirent.h>
#include <stdio.h>
#include <unistd.h>

#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

static const double UNIT = 0.031;  // metres a map unit

typedef struct Opened {
    const char *path;
    Arena arena;
    Building building;
    CellGraph graph;
} Opened;

static void open_map(Opened *m, const char *path, const char *map) {
    Error error;
    VisOptions options = vis_default_options();
    m->path = path;
    cr_assert(maps_read_map(path, map, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
}

static int u16(const unsigned char *p) { return p[0] | p[1] << 8; }
static long i32(const unsigned char *p) { return u16(p) | (long)u16(p + 2) << 16; }

// Where the data of a lump begins, of this map (NULL: of the only one).
static const unsigned char *lump_of(Bytes file, const char *map, const char *name, long *size) {
    const unsigned char *entry = file.data + i32(file.data + 8);
    bool within = !map;
    for (long i = 0; i < i32(file.data + 4); i++, entry += 16) {
        within = within || strncmp((const char *)entry + 8, map, 8) == 0;
        if (!within || strncmp((const char *)entry + 8, name, 8) != 0) continue;
        *size = i32(entry + 4);
        return file.data + i32(entry);
    }
    cr_assert_fail("no lump %s of %s", name, map ? map : "the map");
    return NULL;
}

// The area of each sector by the shoelace of its lines, straight from the lumps, square metres.
static double *shoelace(Arena *arena, Bytes file, const char *map, int *sector_count) {
    long lines, size;
    const unsigned char *line = lump_of(file, map, "LINEDEFS", &lines),
                        *sides = lump_of(file, map, "SIDEDEFS", &size),
                        *vertices = lump_of(file, map, "VERTEXES", &size);
    lump_of(file, map, "SECTORS", &size);
    *sector_count = (int)(size / 26);
    double *area = ARENA_ARRAY(arena, double, *sector_count);
    for (long i = 0; i < lines / 14; i++, line += 14) {
        const unsigned char *a = vertices + 4 * u16(line), *b = vertices + 4 * u16(line + 2);
        double cross =
            (double)(int16_t)u16(a) * (int16_t)u16(b + 2) - (double)(int16_t)u16(a + 2) * (int16_t)u16(b);
        for (int k = 0; k < 2; k++) {
            int side = u16(line + 10 + 2 * k);
            if (side != 0xFFFF) area[u16(sides + 30 * side + 28)] += (k ? 1 : -1) * cross / 2 * UNIT * UNIT;
        }
    }
    return area;
}

// Free space has the area of the sectors (those that are solid apart), and no cell bends inwards.
static void check_space(Opened *m) {
    int sectors;
    const char *map = m->building.map;
    const double *area = shoelace(&m->arena, support_read(&m->arena, m->path), map, &sectors);
    double *found = ARENA_ARRAY(&m->arena, double, sectors);
    for (int i = 0; i < m->building.region_count; i++) {
        int sector;
        cr_assert_eq(sscanf(m->building.regions[i].name, "sector %d", &sector), 1);
        found[sector] += fixture_region_area(&m->building, &m->building.regions[i]);
    }
    for (int s = 0; s < sectors; s++) {
        // Tolerance: edges of 1 km moved by 1e-6 m in the mean; a missing piece has more.
        bool same = fabs(area[s] - found[s]) < 1e-3 || found[s] == 0;
        cr_expect(same, "%s: sector %d has %.6f m2 of %.6f", m->path, s, found[s], area[s]);
    }
    cr_expect_eq(fixture_dents(&m->graph), 0, "%s", m->path);
}

// A portal joins two cells, each of which counts it among its ways out, and lies in the plan's border of both.
static void check_portals(const Opened *m) {
    const CellGraph *g = &m->graph;
    for (int p = 0; p < g->portal_count; p++) {
        const Portal *portal = &g->portals[p];
        cr_assert(portal->cell[0] != portal->cell[1] && portal->vertex_count >= 3, "portal %d", p);
        for (int side = 0; side < 2; side++) {
            const Cell *cell = &g->cells[portal->cell[side]];
            int told = 0;
            for (int i = 0; i < cell->way_count; i++) {
                const Way *way = &g->ways[cell->first_way + i];
                told += way->portal == p && way->cell == portal->cell[!side];
            }
            cr_assert_eq(told, 1, "%s: cell %d has portal %d %d times", m->building.map, portal->cell[side],
                         p, told);
            for (int i = 0; i < portal->vertex_count; i++) {
                Vec3 v = g->portal_vertices[portal->first_vertex + i];
                // Tolerance: rounding of heights and of corners off the grid.
                cr_assert(v.z > cell->z0 - 1e-6 && v.z < cell->z1 + 1e-6, "portal %d, cell %d", p,
                          portal->cell[side]);
            }
        }
    }
}

// Straight lines from anywhere in all directions: each cell that one crosses is seen from where it began, and its way is in the
// tree, where there is one.
static void check_lines(Opened *m) {
    StabForest forest;
    VisOptions options = vis_default_options();
    Random random = {17};
    int far = 0;
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &forest));
    for (int i = 0; i < support_count(20000, 500000); i++) {
        int cell = random_index(&random, m->graph.cell_count);
        Vec3 from = fixture_point(&m->graph, &random, cell), along = fixture_direction(&random);
        along = vec3_normalize(vec3(along.x, along.y, 0.1 * along.z));
        Trace trace;
        if (!fixture_trace(&m->graph, cell, from, along, NULL, &trace)) continue;
        for (int k = 0; k < trace.count; k++)
            cr_assert(vis_sees(&forest, cell, trace.cells[k]), "%s, seed 17, line %d: cell %d sees cell %d",
                      m->building.map, i, cell, trace.cells[k]);
        cr_assert(forest.bounded[cell] || fixture_in_tree(&forest, &trace), "%s, seed 17, line %d",
                  m->building.map, i);
        far += trace.count > 5;
    }
    cr_expect_gt(far, 1000, "%s: %d lines through five portals or more", m->building.map, far);
}

// Proves on each map of the shared data that it opens and compiles, and that its free space is that of the sectors.
Test(wad_maps, shared, .timeout = 300) {
    const char *folder = support_shared("doom");
    DIR *dir = opendir(folder);
    cr_assert(dir);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(dir));) {
        size_t length = strlen(entry->d_name);
        if (length < 4 || strcmp(entry->d_name + length - 4, ".wad") != 0) continue;
        Opened m = {.arena = {0}};
        open_map(&m, arena_format(&m.arena, "%s/%s", folder, entry->d_name), NULL);
        check_space(&m);
        arena_free(&m.arena);
        count++;
    }
    closedir(dir);
    cr_expect_eq(count, 17);
}

static void check_freedoom(const char *name, const char *const *maps, int count) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "/usr/share/games/doom/%s", name);
    if (access(path, R_OK) != 0) cr_skip_test("%s is not here (apt-get install freedoom)", path);
    for (int i = 0; i < count; i++) {
        Opened m = {.arena = {0}};
        open_map(&m, path, maps[i]);
        cr_expect_str_eq(m.building.map, maps[i]);
        check_space(&m);
        check_portals(&m);
        check_lines(&m);
        arena_free(&m.arena);
    }
    arena_free(&arena);
}

// Prove the same of maps that every machine may have, and of their portals and sightlines.
Test(wad_maps, freedoom_phase_1, .timeout = 600) {
    static const char *const MAPS[] = {"E1M1", "E1M2", "E2M1", "E3M1", "E4M1"};
    check_freedoom("freedoom1.wad", MAPS, support_count(1, 5));
}

Test(wad_maps, freedoom_phase_2, .timeout = 600) {
    static const char *const MAPS[] = {"MAP01", "MAP02", "MAP07", "MAP31"};
    check_freedoom("freedoom2.wad", MAPS, support_count(1, 4));
}
