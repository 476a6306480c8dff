// prt.c - portal files: convex cells and the portals between them, as level compilers hand them to their visibility
// stage (Quake, id Software 1996). Their game units become metres, 32 a metre.
//
// Text: `PRT1`, the number of cells, the number of portals, then a line a portal: `POINTS CELL CELL (x y z ) ...`. The
// right-handed turn of a portal's corners points out of the first cell; ours are counter-clockwise seen from it.
//
// Two formats add the leaves that lie in each cell. `PRT2` has the number of leaves before that of cells, and ends with a line of
// leaves for each cell, closed by -1. `PRT1-AM` has the number of leaves as a third one, and ends with the cell of each leaf.
#include <ctype.h>

#include "engine/core/polygon.h"
#include "maps/building/scan.h"
#include "maps/quake/prt.h"

static const double UNITS_PER_METRE = 32;  // a power of two: no coordinate is rounded
enum { MAX_PORTALS = 1 << 20, MAX_CORNERS = 64, MAX_LEAVES = 1 << 20 };
// Compilers print few decimals: how far corners may lie off their plane, and turn inwards, units. Measured on maps of
// three compilers: up to 0.02.
static const double BEND = 0.1;

static bool read_count(Scan *t, const char *what, int low, int high, int *out, Error *error) {
    char quote[SCAN_QUOTE];
    double value;
    Scan before = *t;
    if (!scan_number(t, low, high, &value) || value != floor(value)) {
        return error_set(error, "%s:%d: %s is `%s` (allowed %d to %d)", t->path, t->line, what,
                         scan_quote(&before, quote), low, high);
    }
    *out = (int)value;
    return true;
}

static bool read_sign(Scan *t, char sign, Error *error) {
    char quote[SCAN_QUOTE];
    scan_blanks(t);
    if (t->at < t->end && *t->at == sign) {
        t->at++;
        return true;
    }
    return error_set(error, "%s:%d: found `%s` (expected `%c`: corners are written (x y z))", t->path,
                     t->line, scan_quote(t, quote), sign);
}

static bool read_corner(Scan *t, Vec3 *out, Error *error) {
    char quote[SCAN_QUOTE];
    double c[3];
    if (!read_sign(t, '(', error)) return false;
    for (int i = 0; i < 3; i++) {
        if (!scan_number(t, -MAPS_LIMIT, MAPS_LIMIT, &c[i])) {
            return error_set(error, "%s:%d: a coordinate is `%s` (allowed -%g to %g)", t->path, t->line,
                             scan_quote(t, quote), MAPS_LIMIT, MAPS_LIMIT);
        }
    }
    *out = vec3(c[0] / UNITS_PER_METRE, c[1] / UNITS_PER_METRE, c[2] / UNITS_PER_METRE);
    return read_sign(t, ')', error);
}

// How far the outline turns inwards: the farthest a corner lies inside the line through its neighbours, metres.
static double dent(const Vec3 *v, int count, Vec3 n) {
    double deepest = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = v[i], edge = vec3_normalize(vec3_sub(v[(i + 1) % count], a)), inward = vec3_cross(n, edge);
        for (int k = 0; k < count; k++) deepest = fmax(deepest, -vec3_dot(inward, vec3_sub(v[k], a)));
    }
    return deepest;
}

static bool check_shape(const Scan *t, const Vec3 *v, int count, Error *error) {
    Plane plane = plane_of_polygon(v, count);
    double limit = BEND / UNITS_PER_METRE;
    double bend = polygon_bend(v, count, plane), hollow = dent(v, count, plane.n);
    if (bend > limit) {
        return error_set(error, "%s:%d: the portal bends by %g units (limit %g)", t->path, t->line,
                         bend * UNITS_PER_METRE, BEND);
    }
    if (hollow > limit) {
        return error_set(error, "%s:%d: the portal is not convex: a corner lies %g units inside (limit %g)",
                         t->path, t->line, hollow * UNITS_PER_METRE, BEND);
    }
    return true;
}

// A portal without area, through which nothing is seen, comes back without corners.
static bool read_portal(Scan *t, Arena *arena, Building *b, GivenPortal *out, Error *error) {
    int count;
    Vec3 corner[MAX_CORNERS];
    if (!read_count(t, "the number of a portal's corners", 3, MAX_CORNERS, &count, error)) return false;
    for (int side = 0; side < 2; side++) {
        if (!read_count(t, "a portal's cell", 0, b->given_cell_count - 1, &out->cell[side], error))
            return false;
    }
    if (out->cell[0] == out->cell[1]) {
        return error_set(error, "%s:%d: the portal leads from cell %d to itself", t->path, t->line,
                         out->cell[0]);
    }
    for (int i = 0; i < count; i++) {
        if (!read_corner(t, &corner[i], error)) return false;
    }
    scan_blanks(t);
    if (t->at < t->end && *t->at != '\n') {
        char quote[SCAN_QUOTE];
        return error_set(error,
                         "%s:%d: found `%s` after the portal's %d corners (expected the end of the line)",
                         t->path, t->line, scan_quote(t, quote), count);
    }
    out->vertex_count = 0;
    if (maps_portal_is_thin(corner, count)) return true;
    if (!check_shape(t, corner, count, error)) return false;
    out->first_vertex = b->vertex_count;
    out->vertex_count = count;
    // The file turns right-handed about the normal that points out of the first cell.
    for (int i = count - 1; i >= 0; i--)
        *ARENA_PUSH(arena, b->vertices, b->vertex_count, b->vertex_capacity) = corner[i];
    return true;
}

static bool recognise_prt(Bytes content) {
    return content.size >= 4 && memcmp(content.data, "PRT", 3) == 0 && isdigit(content.data[3]);
}

typedef enum PrtKind { PRT1, PRT2, PRT1_AM, PRT_KINDS } PrtKind;

// One of the numbers that a file begins with, on a line of its own or behind the one before.
static bool read_head_count(Scan *t, const char *what, int low, int high, int *out, Error *error) {
    if (!scan_next_line(t, 0)) return error_set(error, "%s: ends before %s", t->path, what);
    return read_count(t, what, low, high, out, error);
}

static bool read_head(Scan *t, Building *b, PrtKind *kind, PrtLeaves *leaves, Error *error) {
    static const char *const NAMES[PRT_KINDS] = {"PRT1", "PRT2", "PRT1-AM"};
    char quote[SCAN_QUOTE];
    if (!scan_next_line(t, 0)) return error_set(error, "%s: is empty (expected PRT1)", t->path);
    const char *mark = scan_quote(t, quote);
    for (*kind = 0; *kind < PRT_KINDS && strcmp(mark, NAMES[*kind]) != 0;) ++*kind;
    if (*kind == PRT_KINDS)
        return error_set(error, "%s:%d: begins with `%s` (allowed PRT1, PRT2 and PRT1-AM)", t->path, t->line,
                         mark);
    t->at += strlen(NAMES[*kind]);
    static const char LEAVES[] = "the number of leaves";
    if (*kind == PRT2 && !read_head_count(t, LEAVES, 1, MAX_LEAVES, &leaves->count, error)) return false;
    if (!read_head_count(t, "the number of cells", 1, MAPS_MAX_GIVEN_CELLS, &b->given_cell_count, error) ||
        !read_head_count(t, "the number of portals", 0, MAX_PORTALS, &b->given_portal_count, error))
        return false;
    if (*kind == PRT1) leaves->count = b->given_cell_count;
    return *kind != PRT1_AM || read_head_count(t, LEAVES, 1, MAX_LEAVES, &leaves->count, error);
}

static bool read_portals(Scan *t, Arena *arena, Building *out, Error *error) {
    int told = out->given_portal_count, capacity = 0;
    out->given_portal_count = 0;
    for (int i = 0; i < told; i++) {
        if (!scan_next_line(t, 0)) {
            return error_set(error, "%s:%d: ends after %d portals (its head says %d)", t->path, t->line, i,
                             told);
        }
        GivenPortal portal;
        if (!read_portal(t, arena, out, &portal, error)) return false;
        if (portal.vertex_count == 0) continue;
        *ARENA_PUSH(arena, out->given_portals, out->given_portal_count, capacity) = portal;
    }
    int dropped = told - out->given_portal_count;
    if (dropped > 0)
        building_note(arena, out, NOTE_DROPPED, vec3(0, 0, 0),
                      "%s: %d portals have no area and were left out", t->path, dropped);
    return true;
}

// The leaves of each cell, and -1 behind them.
static bool read_leaves_of_cells(Scan *t, const Building *b, PrtLeaves *leaves, Error *error) {
    for (int cell = 0; cell < b->given_cell_count; cell++) {
        for (int leaf = 0; leaf >= 0;) {
            if (!scan_next_line(t, 0))
                return error_set(error, "%s:%d: ends within the leaves of cell %d", t->path, t->line, cell);
            if (!read_count(t, "a leaf", -1, leaves->count - 1, &leaf, error)) return false;
            if (leaf >= 0) leaves->cell[leaf] = cell;
        }
    }
    for (int i = 0; i < leaves->count; i++) {
        if (leaves->cell[i] < 0)
            return error_set(error, "%s: leaf %d is in no cell (expected: each leaf in one)", t->path, i);
    }
    return true;
}

static bool read_cells_of_leaves(Scan *t, const Building *b, PrtLeaves *leaves, Error *error) {
    for (int i = 0; i < leaves->count; i++) {
        if (!scan_next_line(t, 0))
            return error_set(error, "%s:%d: ends after the cells of %d leaves", t->path, t->line, i);
        if (!read_count(t, "the cell of a leaf", 0, b->given_cell_count - 1, &leaves->cell[i], error))
            return false;
    }
    return true;
}

static bool read_leaves(Scan *t, PrtKind kind, const Building *b, Arena *arena, PrtLeaves *leaves,
                        Error *error) {
    leaves->cell = ARENA_ARRAY(arena, int, leaves->count);
    for (int i = 0; i < leaves->count; i++) leaves->cell[i] = kind == PRT1 ? i : -1;
    if (kind == PRT2) return read_leaves_of_cells(t, b, leaves, error);
    return kind == PRT1 || read_cells_of_leaves(t, b, leaves, error);
}

bool prt_read(const char *path, Bytes content, Arena *arena, Building *out, PrtLeaves *leaves, Error *error) {
    Scan t = scan_begin(path, content);
    *out = (Building){.form = FORM_CELLS, .map = out->map, .file_size = out->file_size};
    *leaves = (PrtLeaves){0};
    PrtKind kind = PRT1;
    if (!read_head(&t, out, &kind, leaves, error) || !read_portals(&t, arena, out, error) ||
        !read_leaves(&t, kind, out, arena, leaves, error))
        return false;
    if (!scan_next_line(&t, 0)) return true;
    char quote[SCAN_QUOTE];
    return error_set(error, "%s:%d: found `%s` after the last %s (its head says %d portals)", path, t.line,
                     scan_quote(&t, quote), kind == PRT1 ? "portal" : "leaf", out->given_portal_count);
}

static bool read(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    PrtLeaves leaves;
    return prt_read(path, content, arena, out, &leaves, error);
}

const MapsReader MAPS_READER_PRT = {
    .name = "prt",
    .suffixes = ".prt",
    .summary = "portal files: convex cells and portals, no walls",
    .recognise = recognise_prt,
    .read = read,
};
