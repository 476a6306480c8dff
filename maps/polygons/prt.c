// prt.c - PRT1 portal files: convex cells and the portals between them, as level compilers hand them to their
// visibility stage (Quake, id Software 1996). Their game units become metres, 32 a metre.
//
// Text: `PRT1`, the number of cells, the number of portals, then a line a portal: `POINTS CELL CELL (x y z ) ...`. The
// right-handed turn of a portal's corners points out of the first cell; ours are counter-clockwise seen from it.
#include <ctype.h>

#include "engine/core/polygon.h"
#include "maps/building/reader.h"
#include "maps/building/scan.h"

static const double UNITS_PER_METRE = 32;  // a power of two: no coordinate is rounded
enum { MAX_PORTALS = 1 << 20, MAX_CORNERS = 64 };
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
    if (polygon_area(corner, count) < MAPS_SMALLEST_AREA) return true;
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

static bool read_head(Scan *t, Building *b, Error *error) {
    char quote[SCAN_QUOTE];
    if (!scan_next_line(t, 0)) return error_set(error, "%s: is empty (expected PRT1)", t->path);
    const char *mark = scan_quote(t, quote);
    if (strcmp(mark, "PRT2") == 0) {
        return error_set(
            error,
            "%s:%d: is a PRT2 file (allowed PRT1: the clusters of PRT2 are not convex, so a straight "
            "line may leave one and come back)",
            t->path, t->line);
    }
    if (strcmp(mark, "PRT1") != 0)
        return error_set(error, "%s:%d: begins with `%s` (allowed PRT1)", t->path, t->line, mark);
    t->at += 4;
    if (!scan_next_line(t, 0) ||
        !read_count(t, "the number of cells", 1, MAPS_MAX_CELLS, &b->given_cell_count, error))
        return t->at < t->end ? false : error_set(error, "%s: ends before the number of cells", t->path);
    if (!scan_next_line(t, 0) ||
        !read_count(t, "the number of portals", 0, MAX_PORTALS, &b->given_portal_count, error))
        return t->at < t->end ? false : error_set(error, "%s: ends before the number of portals", t->path);
    return true;
}

static bool read(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Scan t = scan_begin(path, content);
    *out = (Building){.form = FORM_CELLS, .map = out->map, .file_size = out->file_size};
    if (!read_head(&t, out, error)) return false;
    int told = out->given_portal_count, capacity = 0;
    out->given_portal_count = 0;
    for (int i = 0; i < told; i++) {
        if (!scan_next_line(&t, 0)) {
            return error_set(error, "%s:%d: ends after %d portals (its head says %d)", path, t.line, i, told);
        }
        GivenPortal portal;
        if (!read_portal(&t, arena, out, &portal, error)) return false;
        if (portal.vertex_count == 0) continue;
        *ARENA_PUSH(arena, out->given_portals, out->given_portal_count, capacity) = portal;
    }
    if (scan_next_line(&t, 0)) {
        char quote[SCAN_QUOTE];
        return error_set(error, "%s:%d: found `%s` after the last portal (its head says %d portals)", path,
                         t.line, scan_quote(&t, quote), told);
    }
    int dropped = told - out->given_portal_count;
    if (dropped > 0)
        building_note(arena, out, NOTE_DROPPED, vec3(0, 0, 0),
                      "%s: %d portals have no area and were left out", path, dropped);
    return true;
}

const MapsReader MAPS_READER_PRT = {
    .name = "prt",
    .suffixes = ".prt",
    .summary = "PRT1 portal files: convex cells and portals, no walls",
    .recognise = recognise_prt,
    .read = read,
};
