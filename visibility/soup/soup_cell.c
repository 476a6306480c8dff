// soup_cell.c - convex polyhedra as lists of faces: cut by planes, and cutting polygons.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

SoupCell *soup_cell_new(Soup *soup) {
    SoupCell *cell = ARENA_ARRAY(soup->scratch, SoupCell, 1);
    *ARENA_PUSH(soup->scratch, soup->cells, soup->cell_count, soup->cell_capacity) = cell;
    return cell;
}

// Leaves out corners that coincide with the one before.
static int weld(const Vec3 *v, int count, double nearest, Vec3 *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (kept == 0 || vec3_length(vec3_sub(v[i], out[kept - 1])) > nearest) out[kept++] = v[i];
    }
    while (kept > 1 && vec3_length(vec3_sub(out[kept - 1], out[0])) <= nearest) kept--;
    return kept;
}

// Faces without width are left out: their neighbours bound the cell there.
void soup_cell_add_face(Soup *soup, SoupCell *cell, int plane, int side, const Vec3 *v, int count) {
    CORE_ASSERT(cell->face_count < SOUP_MOST_FACES + 2);
    Vec3 *kept = ARENA_ARRAY(soup->scratch, Vec3, count);
    count = weld(v, count, SOUP_WELD * soup->size, kept);
    if (count < 3 || soup_width(kept, count) < SOUP_WELD * soup->size) return;
    cell->faces[cell->face_count++] = (CellFace){plane, side, kept, count};
}

Plane soup_inward(const Soup *soup, const CellFace *face) {
    Plane plane = soup->planes[face->plane].plane;
    return face->side > 0 ? plane : (Plane){vec3_scale(plane.n, -1), -plane.d};
}

// The corners of a polygon farthest in front of and behind a plane.
static void reach(const Vec3 *v, int count, Plane plane, double *low, double *high) {
    for (int i = 0; i < count; i++) {
        double d = plane_distance(plane, v[i]);
        *low = fmin(*low, d);
        *high = fmax(*high, d);
    }
}

int soup_cell_clip(const Soup *soup, const SoupCell *cell, const Vec3 *v, int count, Vec3 *out) {
    Vec3 buffer[SOUP_MOST_CORNERS];
    CORE_ASSERT(count + cell->face_count <= SOUP_MOST_CORNERS);
    memcpy(out, v, (size_t)count * sizeof *out);
    for (int i = 0; i < cell->face_count && count > 0; i++) {
        count = polygon_clip(out, count, soup_inward(soup, &cell->faces[i]), 0, buffer);
        memcpy(out, buffer, (size_t)count * sizeof *out);
    }
    return count >= 3 ? count : 0;
}

int soup_cell_section(const Soup *soup, const SoupCell *cell, int plane, Vec3 *out) {
    Plane p = soup->planes[plane].plane;
    Vec3 u = fabs(p.n.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    u = vec3_normalize(vec3_cross(p.n, u));
    Vec3 w = vec3_cross(p.n, u);
    Vec3 middle = vec3_sub(soup->centre, vec3_scale(p.n, plane_distance(p, soup->centre)));
    double far = 4 * soup->size;  // beyond the borders
    Vec3 quad[4];
    for (int i = 0; i < 4; i++) {
        double x = i == 1 || i == 2 ? far : -far, y = i >= 2 ? far : -far;
        quad[i] = vec3_add(middle, vec3_add(vec3_scale(u, x), vec3_scale(w, y)));
    }
    return soup_cell_clip(soup, cell, quad, 4, out);
}

static void turn_round(Vec3 *v, int count) {
    for (int i = 0; i < count / 2; i++) {
        Vec3 swap = v[i];
        v[i] = v[count - 1 - i];
        v[count - 1 - i] = swap;
    }
}

bool soup_cell_split(Soup *soup, const SoupCell *cell, int plane, SoupCell **front, SoupCell **back) {
    Plane p = soup->planes[plane].plane;
    double low = INFINITY, high = -INFINITY, thinnest = SOUP_THINNEST * soup->size;
    for (int i = 0; i < cell->face_count; i++) reach(cell->faces[i].v, cell->faces[i].count, p, &low, &high);
    if (low > -thinnest || high < thinnest || cell->face_count >= SOUP_MOST_FACES) return false;
    Vec3 section[SOUP_MOST_CORNERS], part[SOUP_MOST_CORNERS];
    int count = soup_cell_section(soup, cell, plane, section);
    if (count == 0) return false;
    *front = soup_cell_new(soup);
    *back = soup_cell_new(soup);
    Plane behind = {vec3_scale(p.n, -1), -p.d};
    for (int i = 0; i < cell->face_count; i++) {
        const CellFace *f = &cell->faces[i];
        CORE_ASSERT(f->count < SOUP_MOST_CORNERS);
        int kept = polygon_clip(f->v, f->count, p, 0, part);
        soup_cell_add_face(soup, *front, f->plane, f->side, part, kept);
        kept = polygon_clip(f->v, f->count, behind, 0, part);
        soup_cell_add_face(soup, *back, f->plane, f->side, part, kept);
    }
    soup_cell_add_face(soup, *front, plane, 1, section, count);
    turn_round(section, count);
    soup_cell_add_face(soup, *back, plane, -1, section, count);
    return true;
}
