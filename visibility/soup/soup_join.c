// soup_join.c - two cells whose common face hides nothing, and which together are convex, become one: no more cells than
// the building needs.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

// How far a corner may lie outside a plane of the other cell, relative to the size: rounding, and nothing more.
static const double CONVEX = SOUP_WELD;

static bool opaque_in(const Soup *soup, const CellFace *face) {
    const SoupPlane *plane = &soup->planes[face->plane];
    Vec3 part[SOUP_MOST_CORNERS];
    Box box = soup_box(face->v, face->count, 2 * SOUP_SNAP * soup->size);
    for (int i = plane->first_sheet; i < plane->first_sheet + plane->sheet_count; i++) {
        const SoupSheet *sheet = &soup->sheets[i];
        if (!box_overlap(box, soup_box(sheet->v, sheet->count, 0))) continue;
        int count = soup_overlap(face->v, face->count, sheet->v, sheet->count, plane->plane.n, part);
        if (count > 0 && soup_width(part, count) > SOUP_SNAP * soup->size) return true;
    }
    for (int i = 0; i < soup->door_count; i++) {
        if (soup->doors[i].plane != face->plane) continue;
        int count = soup_overlap(face->v, face->count, soup->doors[i].v, 4, plane->plane.n, part);
        if (count > 0 && soup_width(part, count) > SOUP_SNAP * soup->size) return true;
    }
    return false;
}

// Does each have all corners of the other in front of its planes, but for the common one?
static bool convex_together(const Soup *soup, const SoupCell *a, int skip, const SoupCell *b) {
    for (int i = 0; i < a->face_count; i++) {
        if (i == skip) continue;
        Plane inward = soup_inward(soup, &a->faces[i]);
        for (int f = 0; f < b->face_count; f++) {
            for (int k = 0; k < b->faces[f].count; k++) {
                if (plane_distance(inward, b->faces[f].v[k]) < -CONVEX * soup->size) return false;
            }
        }
    }
    return true;
}

// The whole of one is the whole of the other.
static bool same_face(const Soup *soup, const CellFace *a, const CellFace *b) {
    Vec3 part[SOUP_MOST_CORNERS];
    Vec3 n = soup->planes[a->plane].plane.n;
    int count = soup_overlap(a->v, a->count, b->v, b->count, n, part);
    if (count == 0) return false;
    double common = polygon_area(part, count), slack = SOUP_WELD * soup->size * soup->size;
    return polygon_area(a->v, a->count) - common < slack && polygon_area(b->v, b->count) - common < slack;
}

// Adds a face; one in the same plane as another becomes part of that.
static void take_face(Soup *soup, SoupCell *cell, const CellFace *face) {
    for (int i = 0; i < cell->face_count; i++) {
        CellFace *mine = &cell->faces[i];
        if (mine->plane != face->plane || mine->side != face->side) continue;
        Vec3 all[2 * SOUP_MOST_CORNERS], hull[2 * SOUP_MOST_CORNERS + 1];
        memcpy(all, mine->v, (size_t)mine->count * sizeof *all);
        memcpy(all + mine->count, face->v, (size_t)face->count * sizeof *all);
        Vec3 n = vec3_scale(soup->planes[mine->plane].plane.n, mine->side);
        int count = soup_hull(soup->scratch, all, mine->count + face->count, n, SOUP_WELD * soup->size, hull);
        mine->v = memcpy(ARENA_ARRAY(soup->scratch, Vec3, count), hull, (size_t)count * sizeof *hull);
        mine->count = count;
        return;
    }
    soup_cell_add_face(soup, cell, face->plane, face->side, face->v, face->count);
}

static bool merge(Soup *soup, int keep, int lose) {
    SoupCell *a = soup->cells[keep], *b = soup->cells[lose];
    for (int i = 0; i < a->face_count; i++) {
        for (int k = 0; k < b->face_count; k++) {
            const CellFace *f = &a->faces[i], *g = &b->faces[k];
            if (f->plane != g->plane || f->side == g->side || !same_face(soup, f, g)) continue;
            if (a->face_count + b->face_count - 2 > SOUP_MOST_FACES || opaque_in(soup, f)) return false;
            if (!convex_together(soup, a, i, b) || !convex_together(soup, b, k, a)) return false;
            SoupCell whole = {0};
            for (int n = 0; n < a->face_count; n++) {
                if (n != i) take_face(soup, &whole, &a->faces[n]);
            }
            for (int n = 0; n < b->face_count; n++) {
                if (n != k) take_face(soup, &whole, &b->faces[n]);
            }
            *a = whole;
            b->gone = true;
            return true;
        }
    }
    return false;
}

static Box soup_cell_box(const SoupCell *cell, double grow) {
    Box box = box_empty();
    for (int i = 0; i < cell->face_count; i++) {
        for (int k = 0; k < cell->faces[i].count; k++) box = box_add(box, cell->faces[i].v[k]);
    }
    return box_grow(box, grow);
}

void soup_join(Soup *soup) {
    double near = SOUP_WELD * soup->size;
    Box *boxes = ARENA_ARRAY(soup->scratch, Box, soup->cell_count);
    for (int i = 0; i < soup->cell_count; i++) boxes[i] = soup_cell_box(soup->cells[i], near);
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < soup->cell_count; i++) {
            for (int k = i + 1; k < soup->cell_count && !soup->cells[i]->gone; k++) {
                if (soup->cells[k]->gone || !box_overlap(boxes[i], boxes[k]) || !merge(soup, i, k)) continue;
                boxes[i] = soup_cell_box(soup->cells[i], near);
                more = true;
            }
        }
    }
    int kept = 0;
    for (int i = 0; i < soup->cell_count; i++) {
        if (!soup->cells[i]->gone) soup->cells[kept++] = soup->cells[i];
    }
    soup->cell_count = kept;
}
