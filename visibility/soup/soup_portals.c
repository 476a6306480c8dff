// soup_portals.c - the cells of a soup in the graph, and the portals between them: what the opaque polygons in its plane
// leave of the common face of two cells, in few convex pieces.
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

// A door whose rectangle covers this share of a piece closes all of it: leaves have play in their frames.
static const double DOOR_SHARE = 0.75;
// A face of which polygons leave more pieces than this, and after joining more than that, counts as open all over.
enum { MOST_PIECES = 8192, MOST_PORTALS = 1024, FEW_PIECES = 128 };

// ---- cells

static bool at_border(const Soup *soup, const SoupCell *cell) {
    for (int i = 0; i < cell->face_count; i++) {
        if (cell->faces[i].plane >= soup->border) return true;
    }
    return false;
}

// The cell's shadow, or, where that has too many corners, the rectangle around it.
static int shadow(const Soup *soup, const SoupCell *cell, const Cell *out, Vec3 **plan) {
    int count = 0;
    for (int i = 0; i < cell->face_count; i++) count += cell->faces[i].count;
    Vec3 *all = ARENA_ARRAY(soup->scratch, Vec3, count);
    *plan = ARENA_ARRAY(soup->scratch, Vec3, count + 4);
    count = 0;
    for (int i = 0; i < cell->face_count; i++) {
        for (int k = 0; k < cell->faces[i].count; k++) {
            all[count] = cell->faces[i].v[k];
            all[count++].z = 0;
        }
    }
    count = soup_hull(soup->scratch, all, count, vec3(0, 0, 1), 0, *plan);
    if (count <= BUILD_MAX_VERTICES / 2) return count;
    Vec3 low = out->box.min, high = out->box.max;
    (*plan)[0] = low;
    (*plan)[1] = vec3(high.x, low.y, 0);
    (*plan)[2] = high;
    (*plan)[3] = vec3(low.x, high.y, 0);
    return 4;
}

static void write_cell(const Soup *soup, const SoupCell *cell, Cell *out, int *face_capacity) {
    CellBuilder *builder = soup->builder;
    CellGraph *graph = builder->graph;
    *out = (Cell){.region = -1, .first_face = graph->face_count, .box = box_empty()};
    out->outdoors = at_border(soup, cell);
    for (int i = 0; i < cell->face_count; i++) {
        *ARENA_PUSH(builder->arena, graph->faces, graph->face_count, *face_capacity) =
            soup_inward(soup, &cell->faces[i]);
        for (int k = 0; k < cell->faces[i].count; k++) out->box = box_add(out->box, cell->faces[i].v[k]);
    }
    out->face_count = graph->face_count - out->first_face;
    out->z0 = out->box.min.z;
    out->z1 = out->box.max.z;
    Vec3 *plan;
    out->first_edge = graph->plan_count;
    out->edge_count = shadow(soup, cell, out, &plan);
    for (int i = 0; i < out->edge_count; i++)
        *ARENA_PUSH(builder->arena, graph->plan, graph->plan_count, builder->plan_capacity) =
            vec2(plan[i].x, plan[i].y);
    graph->box = box_union(graph->box, out->box);
}

void soup_write_cells(Soup *soup) {
    CellGraph *graph = soup->builder->graph;
    int face_capacity = 0;
    graph->box = box_empty();
    graph->cells = ARENA_ARRAY(soup->builder->arena, Cell, soup->cell_count);
    graph->cell_count = soup->cell_count;
    for (int c = 0; c < soup->cell_count; c++)
        write_cell(soup, soup->cells[c], &graph->cells[c], &face_capacity);
}

// ---- portals

// A face of a cell in a plane, and its box.
typedef struct PlaneFace {
    const CellFace *face;
    int cell;
    Box box;
} PlaneFace;

static void add_portal(Soup *soup, const SoupPiece *piece, int plane, int front, int back, int door) {
    CellBuilder *builder = soup->builder;
    CellGraph *graph = builder->graph;
    Plane p = soup->planes[plane].plane;
    bool swap = p.n.z < 0;  // as everywhere, the upper of two cells comes first
    if (swap) p = (Plane){vec3_scale(p.n, -1), -p.d};
    Vec3 *v = ARENA_ARRAY(soup->scratch, Vec3, piece->count + 1);
    int count = soup_hull(soup->scratch, piece->v, piece->count, p.n, SOUP_WELD * soup->size, v);
    if (count < 3 || soup_width(v, count) < SOUP_SNAP * soup->size) {
        soup->dropped++;
        return;
    }
    Portal *portal =
        ARENA_PUSH(builder->arena, graph->portals, graph->portal_count, builder->portal_capacity);
    *portal = (Portal){.cell = {swap ? back : front, swap ? front : back},
                       .first_vertex = graph->portal_vertex_count,
                       .vertex_count = count,
                       .plane = p,
                       .door = door};
    portal_set_ends(portal, v);
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(builder->arena, graph->portal_vertices, graph->portal_vertex_count,
                    builder->portal_vertex_capacity) = v[i];
}

// Adds the parts of a piece that the doors in its plane close, and the rest, as portals.
static void add_portal_piece(Soup *soup, SoupPiece piece, int plane, int front, int back) {
    Vec3 n = soup->planes[plane].plane.n, part[SOUP_MOST_CORNERS];
    double snap = SOUP_SNAP * soup->size;
    SoupPieces rest = {0};
    soup_pieces_add(soup->scratch, &rest, piece.v, piece.count);
    for (int i = 0; i < soup->door_count; i++) {
        const SoupDoor *door = &soup->doors[i];
        if (door->plane != plane || piece.count > SOUP_MOST_CORNERS / 2) continue;
        int count = soup_overlap(piece.v, piece.count, door->v, 4, n, part);
        if (count == 0 || soup_width(part, count) <= snap) continue;
        if (polygon_area(part, count) >= DOOR_SHARE * polygon_area(piece.v, piece.count)) {
            add_portal(soup, &piece, plane, front, back, door->opening);
            return;
        }
        SoupPiece closed = {.v = part, .count = count};
        add_portal(soup, &closed, plane, front, back, door->opening);
        soup_pieces_subtract(soup->scratch, &rest, part, count, n, snap, 2 * snap);
    }
    for (int i = 0; i < rest.count; i++) add_portal(soup, &rest.piece[i], plane, front, back, -1);
}

static void part_faces(Soup *soup, int plane, const PlaneFace *front, const PlaneFace *back) {
    Vec3 common[SOUP_MOST_CORNERS];
    const SoupPlane *p = &soup->planes[plane];
    double snap = SOUP_SNAP * soup->size;
    int count = soup_overlap(front->face->v, front->face->count, back->face->v, back->face->count, p->plane.n,
                             common);
    if (count == 0) return;
    if (soup_width(common, count) < snap) {
        soup->dropped += soup_width(common, count) > SOUP_WELD * soup->size;
        return;
    }
    SoupPieces pieces = {0};
    soup_pieces_add(soup->scratch, &pieces, common, count);
    Box box = soup_box(common, count, snap);
    for (int i = p->first_sheet; i < p->first_sheet + p->sheet_count; i++) {
        if (pieces.count == 0 || pieces.count > MOST_PIECES) break;
        const SoupSheet *sheet = &soup->sheets[i];
        if (!box_overlap(box, soup_box(sheet->v, sheet->count, snap))) continue;
        soup_pieces_subtract(soup->scratch, &pieces, sheet->v, sheet->count, p->plane.n,
                             SOUP_WELD * soup->size, 2 * snap);
    }
    // Slivers would join with what is far away; of many pieces only neighbours are tried.
    double near = pieces.count <= FEW_PIECES ? soup->size : snap;
    if (pieces.count <= MOST_PIECES)
        soup_pieces_join(soup->scratch, &pieces, p->plane.n, SOUP_WELD * soup->size, near);
    if (pieces.count > MOST_PORTALS) {
        pieces = (SoupPieces){0};
        soup_pieces_add(soup->scratch, &pieces, common, count);
    }
    for (int i = 0; i < pieces.count; i++)
        add_portal_piece(soup, pieces.piece[i], plane, front->cell, back->cell);
}

// All faces by plane: run p is faces[first[p]] .. faces[first[p + 1] - 1].
static PlaneFace *faces_by_plane(const Soup *soup, int *first) {
    int total = 0;
    for (int c = 0; c < soup->cell_count; c++) {
        const SoupCell *cell = soup->cells[c];
        for (int i = 0; i < cell->face_count; i++) first[cell->faces[i].plane + 1]++;
        total += cell->face_count;
    }
    for (int p = 0; p < soup->plane_count; p++) first[p + 1] += first[p];
    int *fill = ARENA_ARRAY(soup->scratch, int, soup->plane_count);
    memcpy(fill, first, (size_t)soup->plane_count * sizeof *fill);
    PlaneFace *faces = ARENA_ARRAY(soup->scratch, PlaneFace, total);
    for (int c = 0; c < soup->cell_count; c++) {
        const SoupCell *cell = soup->cells[c];
        for (int i = 0; i < cell->face_count; i++) {
            const CellFace *f = &cell->faces[i];
            faces[fill[f->plane]++] = (PlaneFace){f, c, soup_box(f->v, f->count, SOUP_SNAP * soup->size)};
        }
    }
    return faces;
}

void soup_write_portals(Soup *soup) {
    int *first = ARENA_ARRAY(soup->scratch, int, soup->plane_count + 1);
    const PlaneFace *faces = faces_by_plane(soup, first);
    for (int p = 0; p < soup->plane_count; p++) {
        for (int i = first[p]; i < first[p + 1]; i++) {
            if (faces[i].face->side < 0) continue;
            for (int k = first[p]; k < first[p + 1]; k++) {
                if (faces[k].face->side < 0 && box_overlap(faces[i].box, faces[k].box))
                    part_faces(soup, p, &faces[i], &faces[k]);
            }
        }
    }
    list_ways(soup->builder);
    soup->builder->graph->dropped_slivers += soup->dropped;
}
