// quake_cells.c - a level as cells and portals: those of its leaves, or those of a portal file beside it.
#include "engine/core/polygon.h"
#include "maps/quake/prt.h"
#include "maps/quake/quake.h"

// Each leaf in a cluster is a cell; those of Quake stand in the order of their rows.
static void cells_of_leaves(const QuakeLevel *level, QuakeCells *out) {
    for (int i = 0; i < level->leaf_count; i++)
        out->cell_of_leaf[i] = level->leaves[i].cluster >= 0 ? out->building.given_cell_count++ : -1;
}

// The clusters of Quake II are the cells of its portal file; leaf i of Quake is leaf i - 1 there.
static bool cells_of_file(const QuakeLevel *level, const char *file, const PrtLeaves *leaves, QuakeCells *out,
                          Error *error) {
    bool clusters = level->format == QUAKE_IBSP38;
    int count = clusters ? out->building.given_cell_count : leaves->count;
    if (count != level->cluster_count) {
        return error_set(error, "%s: has %d %s, %s has %d: it is not of this level", file, count,
                         clusters ? "clusters" : "leaves", level->path, level->cluster_count);
    }
    for (int i = 0; i < level->leaf_count; i++) {
        int cluster = level->leaves[i].cluster;
        out->cell_of_leaf[i] = cluster < 0 || clusters ? cluster : leaves->cell[cluster];
    }
    return true;
}

// Do the portals of a file lie between the cells that the tree has there? Compilers round corners, and leave details out, so some may
// differ or lie in a detail.
static bool check_portals(const QuakeLevel *level, const char *file, const QuakeCells *cells, Error *error) {
    // Wider than corners are rounded, less than a step in which levels are drawn.
    static const double BESIDE = 0.25 / QUAKE_METRE;
    static const double MOST_WRONG = 1.0 / 8, MOST_SOLID = 1.0 / 2;
    const Building *b = &cells->building;
    int count = b->given_portal_count, wrong = 0, solid = 0;
    for (int i = 0; i < count; i++) {
        const GivenPortal *portal = &b->given_portals[i];
        const Vec3 *v = b->vertices + portal->first_vertex;
        Vec3 n = plane_of_polygon(v, portal->vertex_count).n, middle = {0, 0, 0};
        for (int k = 0; k < portal->vertex_count; k++)
            middle = vec3_add(middle, vec3_scale(v[k], 1.0 / portal->vertex_count));
        int found[2];
        for (int side = 0; side < 2; side++) {
            Vec3 at = vec3_add(middle, vec3_scale(n, side == 0 ? BESIDE : -BESIDE));
            found[side] = cells->cell_of_leaf[quake_locate(level, at)];
        }
        if (found[0] < 0 || found[1] < 0) {
            solid++;
        } else if (found[0] != portal->cell[0] || found[1] != portal->cell[1]) {
            wrong++;
        }
    }
    if (wrong <= (count - solid) * MOST_WRONG && solid <= count * MOST_SOLID) return true;
    return error_set(error,
                     "%s: of its %d portals %d lie between other leaves than in %s, and %d in what is solid "
                     "there: it is not of this "
                     "level",
                     file, count, wrong, level->path, solid);
}

bool quake_cells(const QuakeLevel *level, const QuakePortals *portals, Arena *arena, QuakeCells *out,
                 Error *error) {
    static const size_t MOST_BYTES = (size_t)1 << 30;
    *out = (QuakeCells){.building = {.form = FORM_CELLS},
                        .cell_of_leaf = ARENA_ARRAY(arena, int, level->leaf_count)};
    if (!portals->file) {
        cells_of_leaves(level, out);
        if (out->building.given_cell_count > MAPS_MAX_GIVEN_CELLS) {
            return error_set(
                error, "%s: has %d leaves that may see (allowed: %d; a portal file with clusters has fewer)",
                level->path, out->building.given_cell_count, MAPS_MAX_GIVEN_CELLS);
        }
        if (!quake_make_portals(level, portals->clear_water, arena, out, error)) return false;
    } else {
        Bytes content;
        PrtLeaves leaves;
        if (!file_read(portals->file, MOST_BYTES, arena, &content, error) ||
            !prt_read(portals->file, content, arena, &out->building, &leaves, error) ||
            !cells_of_file(level, portals->file, &leaves, out, error) ||
            !check_portals(level, portals->file, out, error))
            return false;
    }
    out->building.source = arena_string(arena, level->path);
    // As much as a portal file would have: pictures and faces of the level say nothing about its cells.
    static const double BYTES_A_PORTAL = 100;
    out->building.file_size = BYTES_A_PORTAL * out->building.given_portal_count;
    return true;
}

static bool read_quake(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    QuakeLevel level;
    QuakeCells cells;
    if (!quake_read(path, content, arena, &level, error) ||
        !quake_cells(&level, &(QuakePortals){NULL, false}, arena, &cells, error))
        return false;
    *out = cells.building;
    return true;
}

const MapsReader MAPS_READER_QUAKE = {
    .name = "bsp",
    .suffixes = ".bsp",
    .summary = "Quake and Quake II levels: the cells and portals of their leaves, no walls",
    .recognise = quake_recognise,
    .read = read_quake,
};
