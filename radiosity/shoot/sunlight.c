// sunlight.c - elements as the sun sees them. All faces are projected along the sun's beams; from an element's polygon the faces between it
// and the sun are cut away, the largest first, and the area that remains is in the sun (the shadow polygons of P. Atherton, K. Weiler &
// D. Greenberg 1978, Polygon Shadow Generation, for each element alone and for convex polygons).
//
// Beams that come in by portals from outdoors are convex polygons. Clipped at each portal that they pass, they tell the cells that the sun
// reaches; surfaces of other cells are not looked at.
#include "radiosity/shoot/sunlight.h"

#include <stdlib.h>

#include "engine/core/box_tree.h"
#include "engine/core/parallel.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/view.h"

// Points less far before an element's plane than this lie on it, metres: more than rounding, less than any thing's distance.
static const double ON_PLANE = 1e-6;
// Faces and elements whose normals are within this of a right angle to the sun are seen edge on, as a sine.
static const double EDGE_ON = 1e-6;
// Corners within this of a cutting line lie on it, metres: rounding far from the origin.
static const double ON_LINE = 1e-9;
// Remainders of less than this share of their element are slivers that rounding leaves, and count as shadow.
static const double SLIVER = 1e-9;
// Beams smaller than this reach nothing, m^2, and after so many beams all cells count as reached: time is bounded.
static const double THIN = 1e-9;
enum { MOST_BEAMS = 1 << 16 };

// A polygon in the sun's axes: x and y across the beams, z towards the sun.
typedef struct SunPolygon {
    Vec3 *corners;
    int count;
} SunPolygon;

typedef struct SunFace {
    int first, count;  // in SunScene.corners
    double area;       // across the beams, m^2; 0: edge on
    bool front;        // the sun sees the front
} SunFace;

// A pane of glass.
typedef struct SunPane {
    Vec3 corner[4];  // counter-clockwise as the sun sees them
    double share;    // of the sun's light that passes; 1 where the pane is edge on
    Box box;
} SunPane;

typedef struct SunScene {
    const Mesh *mesh;
    Vec3 sun, x, y;
    SunFace *faces;  // [mesh->face_count]
    Vec3 *corners;   // counter-clockwise as the sun sees them
    BoxTree tree;    // of faces
    SunPane *panes;  // [mesh->panes.count]
    bool *reached;   // [cell_count]
    bool cells_alone;
    double *share;
    struct SunTools *tools;  // [threads]
} SunScene;

// One thread's memory.
typedef struct SunTools {
    Arena arena;    // of hits
    Arena scratch;  // of an element's polygons
    BoxHits hits;
    int *order;
    int capacity;
} SunTools;

static Vec3 to_sun(const SunScene *s, Vec3 p) {
    return vec3(vec3_dot(s->x, p), vec3_dot(s->y, p), vec3_dot(s->sun, p));
}

// Twice the area across the beams, positive where the corners run counter-clockwise.
static double twice_area(const Vec3 *v, int count) {
    double sum = 0;
    for (int i = 1; i + 1 < count; i++)
        sum += (v[i].x - v[0].x) * (v[i + 1].y - v[0].y) - (v[i + 1].x - v[0].x) * (v[i].y - v[0].y);
    return sum;
}

static void reverse(Vec3 *v, int count) {
    for (int i = 0, k = count - 1; i < k; i++, k--) {
        Vec3 swapped = v[i];
        v[i] = v[k];
        v[k] = swapped;
    }
}

// The part of a polygon on the left (side 1) or right (-1) of the line from a to b, and up to `wide` metres beyond the line.
static SunPolygon beside(const SunPolygon *p, Vec3 a, Vec3 b, int side, double wide, Arena *arena) {
    double *distance = ARENA_ARRAY(arena, double, p->count), length = hypot(b.x - a.x, b.y - a.y);
    SunPolygon out = {ARENA_ARRAY(arena, Vec3, p->count + 2), 0};
    for (int i = 0; i < p->count; i++)
        distance[i] =
            wide +
            side * ((b.x - a.x) * (p->corners[i].y - a.y) - (b.y - a.y) * (p->corners[i].x - a.x)) / length;
    out.count = polygon_clip_band(p->corners, distance, p->count, ON_LINE, out.corners);
    return out;
}

static bool is_point(Vec3 a, Vec3 b) { return hypot(b.x - a.x, b.y - a.y) < ON_LINE; }

static Box box_of(const Vec3 *v, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_add(box, v[i]);
    return box;
}

// ---- the scene as the sun sees it

static void project_faces(SunScene *s, Arena *arena) {
    const Mesh *mesh = s->mesh;
    Box *boxes = ARENA_ARRAY(arena, Box, mesh->face_count + 1);
    s->faces = ARENA_ARRAY(arena, SunFace, mesh->face_count + 1);
    s->corners = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        SunFace *out = &s->faces[f];
        Vec3 *corner = s->corners + face->first_vertex;
        double slope = vec3_dot(face->plane.n, s->sun);
        *out = (SunFace){face->first_vertex, face->vertex_count, 0, slope > 0};
        for (int i = 0; i < face->vertex_count; i++)
            corner[i] = to_sun(s, mesh->vertices[mesh->outline[face->first_vertex + i]]);
        if (!out->front) reverse(corner, out->count);
        if (fabs(slope) > EDGE_ON && !face->hidden) out->area = twice_area(corner, out->count) / 2;
        boxes[f] = out->area > 0 ? box_of(corner, out->count) : box_empty();
    }
    s->tree = box_tree_build(boxes, mesh->face_count, arena);
}

static void project_panes(SunScene *s, Arena *arena) {
    const Panes *panes = &s->mesh->panes;
    s->panes = ARENA_ARRAY(arena, SunPane, panes->count + 1);
    for (int i = 0; i < panes->count; i++) {
        SunPane *out = &s->panes[i];
        double slope = vec3_dot(panes->panes[i].plane.n, s->sun);
        pane_corners(&panes->panes[i], out->corner);
        for (int k = 0; k < 4; k++) out->corner[k] = to_sun(s, out->corner[k]);
        if (slope < 0) reverse(out->corner, 4);
        out->share = fabs(slope) > EDGE_ON ? pane_transmits(&panes->panes[i], fabs(slope)) : 1;
        out->box = box_of(out->corner, 4);
    }
}

// ---- cells that beams reach

typedef struct Beams {
    const CellGraph *graph;
    SunScene *scene;
    double sine, wide;  // of the sun's radius; metres that this leads light aside on its way
    Arena scratch;
    int count;
} Beams;

static SunPolygon project_portal(const SunScene *s, const CellGraph *graph, const Portal *portal,
                                 Arena *arena) {
    SunPolygon out = {ARENA_ARRAY(arena, Vec3, portal->vertex_count), portal->vertex_count};
    for (int i = 0; i < out.count; i++)
        out.corners[i] = to_sun(s, graph->portal_vertices[portal->first_vertex + i]);
    if (twice_area(out.corners, out.count) < 0) reverse(out.corners, out.count);
    return out;
}

// The part of a polygon within a convex one, and up to `wide` metres beyond its edges; no corners where less than `least` m^2 are left.
static SunPolygon common_part(SunPolygon p, const Vec3 *v, int count, double wide, double least,
                              Arena *arena) {
    for (int i = 0; i < count && p.count >= 3; i++) {
        Vec3 a = v[i], b = v[i + 1 == count ? 0 : i + 1];
        if (!is_point(a, b)) p = beside(&p, a, b, 1, wide, arena);
    }
    if (p.count < 3 || !(twice_area(p.corners, p.count) > 2 * least)) p.count = 0;
    return p;
}

// Do beams go through the portal into the cell, and does the portal show its area to them? Beams of a wide sun go both ways through a
// portal that its middle sees edge on.
enum { GOES_OUT, GOES_IN, GOES_EDGE_ON };
static int goes_in(const SunScene *s, double sine, const Portal *portal, int cell) {
    Vec3 n = portal->plane.n;  // to cell[0]
    double along = -vec3_dot(n, s->sun);
    if (portal->cell[0] != cell) along = -along;
    if (along > EDGE_ON + sine) return GOES_IN;
    return sine > 0 && along > -EDGE_ON - sine ? GOES_EDGE_ON : GOES_OUT;
}

static bool is_outdoors(const CellGraph *graph, int cell) {
    return vis_region(graph, cell)->kind == REGION_OUTDOORS;
}

// A beam is the part of its first portal from which light goes on. A straight line passes a convex cell once, so a beam ends after as many
// portals as there are cells; `left` holds it to that.
static void follow_beam(Beams *b, SunPolygon beam, int cell, int left) {
    b->scene->reached[cell] = true;
    if (left == 0 || ++b->count > MOST_BEAMS) return;
    const Cell *c = &b->graph->cells[cell];
    for (int w = c->first_way; w < c->first_way + c->way_count; w++) {
        const Way *way = &b->graph->ways[w];
        const Portal *portal = &b->graph->portals[way->portal];
        int goes = goes_in(b->scene, b->sine, portal, way->cell);
        if (is_outdoors(b->graph, way->cell) || goes == GOES_OUT) continue;
        SunPolygon through = beam;
        if (goes == GOES_IN) {
            through = project_portal(b->scene, b->graph, portal, &b->scratch);
            through = common_part(beam, through.corners, through.count, b->wide, THIN, &b->scratch);
        }
        if (through.count > 0) follow_beam(b, through, way->cell, left - 1);
    }
}

// The box about a polygon that beams see edge on.
static SunPolygon box_around(SunPolygon p, double wide, Arena *arena) {
    Box box = box_grow(box_of(p.corners, p.count), wide);
    SunPolygon out = {ARENA_ARRAY(arena, Vec3, 4), 4};
    out.corners[0] = box.min;
    out.corners[1] = vec3(box.max.x, box.min.y, 0);
    out.corners[2] = box.max;
    out.corners[3] = vec3(box.min.x, box.max.y, 0);
    return out;
}

static void reach_cells(SunScene *s, double radius, Arena *arena) {
    const CellGraph *graph = s->mesh->graph;
    Box world = graph->building->world;
    Beams b = {.graph = graph, .scene = s, .sine = sin(radius)};
    b.wide = radius > 0 ? tan(radius) * vec3_length(vec3_sub(world.max, world.min)) : 0;
    s->reached = ARENA_ARRAY(arena, bool, graph->cell_count + 1);
    for (int c = 0; c < graph->cell_count; c++) s->reached[c] = is_outdoors(graph, c);
    for (int p = 0; p < graph->portal_count; p++) {
        const Portal *portal = &graph->portals[p];
        bool first = is_outdoors(graph, portal->cell[0]);
        int inside = portal->cell[first], goes = goes_in(s, b.sine, portal, inside);
        if (first == is_outdoors(graph, portal->cell[1]) || goes == GOES_OUT) continue;
        arena_reset(&b.scratch);
        SunPolygon beam = project_portal(s, graph, portal, &b.scratch);
        if (goes == GOES_EDGE_ON) beam = box_around(beam, b.wide, &b.scratch);
        follow_beam(&b, beam, inside, graph->cell_count);
    }
    for (int c = 0; c < graph->cell_count && b.count > MOST_BEAMS; c++) s->reached[c] = true;
    arena_free(&b.scratch);
}

bool *sunlight_cells(const Mesh *mesh, Vec3 sun, double radius, Arena *arena) {
    SunScene s = {.mesh = mesh, .sun = sun};
    view_axes(sun, &s.x, &s.y);
    reach_cells(&s, radius, arena);
    return s.reached;
}

// ---- shadows

// The parts of an element that are in the sun so far.
typedef struct Parts {
    SunPolygon *parts;
    int count, capacity;
} Parts;

static void keep_part(Parts *parts, SunPolygon p, double least, Arena *arena) {
    if (p.count >= 3 && twice_area(p.corners, p.count) > 2 * least)
        *ARENA_PUSH(arena, parts->parts, parts->count, parts->capacity) = p;
}

// Cuts a convex polygon away from all parts. A part that the polygon does not meet stays whole.
static void cut_away(Parts *parts, const SunPolygon *shadow, double least, Arena *arena) {
    Parts left = {0};
    for (int k = 0; k < parts->count; k++) {
        SunPolygon rest = parts->parts[k];
        if (common_part(rest, shadow->corners, shadow->count, 0, least, arena).count == 0) {
            keep_part(&left, rest, least, arena);
            continue;
        }
        for (int i = 0; i < shadow->count && rest.count >= 3; i++) {
            Vec3 a = shadow->corners[i], b = shadow->corners[i + 1 == shadow->count ? 0 : i + 1];
            if (is_point(a, b)) continue;
            keep_part(&left, beside(&rest, a, b, -1, 0, arena), least, arena);
            rest = beside(&rest, a, b, 1, 0, arena);
        }
    }
    *parts = left;
}

// The heights of a polygon's corners above a plane of building space, whose height at a place of the sun's axes is linear: [p.count].
static double *heights_above(const SunScene *s, SunPolygon p, Plane plane, Arena *arena) {
    double *above = ARENA_ARRAY(arena, double, p.count);
    Vec3 n = {vec3_dot(plane.n, s->x), vec3_dot(plane.n, s->y), vec3_dot(plane.n, s->sun)};
    for (int i = 0; i < p.count; i++) above[i] = vec3_dot(n, p.corners[i]) - plane.d;
    return above;
}

static SunPolygon above_plane(SunPolygon p, const double *above, Arena *arena) {
    SunPolygon out = {ARENA_ARRAY(arena, Vec3, p.count + 2), 0};
    out.count = polygon_clip_band(p.corners, above, p.count, ON_PLANE, out.corners);
    return out;
}

// The part of a face before the plane of another face that the sun sees; of two faces in one place the one that faces the sun hides the
// other, then the lower index.
static SunPolygon part_before(const SunScene *s, int f, int receiver, Arena *arena) {
    const SunFace *face = &s->faces[f];
    const Face *on = &s->mesh->faces[receiver];
    SunPolygon whole = {s->corners + face->first, face->count};
    double *above = heights_above(s, whole, on->plane, arena), highest = 0, lowest = 0;
    for (int i = 0; i < whole.count; i++) {
        highest = fmax(highest, above[i]);
        lowest = fmin(lowest, above[i]);
    }
    if (highest <= ON_PLANE) {
        bool hides = lowest >= -ON_PLANE && face->front && f < receiver;
        return hides ? whole : (SunPolygon){0};
    }
    return lowest >= -ON_PLANE ? whole : above_plane(whole, above, arena);
}

static SunPolygon before_plane(const SunScene *s, SunPolygon p, Plane plane, Arena *arena) {
    return above_plane(p, heights_above(s, p, plane, arena), arena);
}

// The area of a part, its places behind panes of glass weighted by the share of light that passes these. Panes from `first` on are
// looked at.
static double area_through(const SunScene *s, SunPolygon part, int first, Plane receiver, Arena *arena) {
    double whole = twice_area(part.corners, part.count) / 2;
    for (int i = first; i < s->mesh->panes.count; i++) {
        const SunPane *pane = &s->panes[i];
        Box box = box_of(part.corners, part.count);
        if (pane->share == 1 || pane->box.max.z <= box.min.z || pane->box.min.x >= box.max.x ||
            pane->box.max.x <= box.min.x || pane->box.min.y >= box.max.y || pane->box.max.y <= box.min.y)
            continue;
        SunPolygon glass = before_plane(s, (SunPolygon){s->panes[i].corner, 4}, receiver, arena);
        if (glass.count < 3) continue;
        SunPolygon behind = common_part(part, glass.corners, glass.count, 0, 0, arena);
        if (behind.count < 3) continue;
        // The part beside the pane is what the other panes leave of the whole, less what they leave of the part behind.
        double other = area_through(s, behind, i + 1, receiver, arena);
        return area_through(s, part, i + 1, receiver, arena) - (1 - pane->share) * other;
    }
    return whole;
}

static bool boxes_meet(Box a, Box b) {
    return a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y &&
           a.min.z < b.max.z;
}

static SunPolygon project_element(const SunScene *s, const Element *e, Arena *arena) {
    SunPolygon out = {ARENA_ARRAY(arena, Vec3, e->corner_count), e->corner_count};
    for (int i = 0; i < out.count; i++)
        out.corners[i] = to_sun(s, s->mesh->vertices[s->mesh->corners[e->first_corner + i]]);
    return out;
}

static double share_in_sun(const SunScene *s, SunTools *tools, int element, int count) {
    const Element *e = &s->mesh->elements[element];
    arena_reset(&tools->scratch);
    Parts parts = {0};
    SunPolygon whole = project_element(s, e, &tools->scratch);
    double area = twice_area(whole.corners, whole.count) / 2, lit = 0;
    if (!(area > 0)) return 0;
    Box box = box_of(whole.corners, whole.count);
    keep_part(&parts, whole, 0, &tools->scratch);
    for (int i = 0; i < count && parts.count > 0; i++) {
        int f = tools->order[i];
        if (!boxes_meet(box, s->tree.boxes[f])) continue;
        SunPolygon shadow = part_before(s, f, e->face, &tools->scratch);
        if (shadow.count >= 3) cut_away(&parts, &shadow, SLIVER * area, &tools->scratch);
    }
    for (int k = 0; k < parts.count; k++)
        lit += area_through(s, parts.parts[k], 0, s->mesh->faces[e->face].plane, &tools->scratch);
    return fmin(lit / area, 1);
}

typedef struct Ranked {
    double area;
    int face;
} Ranked;

static int by_area(const void *a, const void *b) {
    const Ranked *p = a, *q = b;
    if (p->area != q->area) return p->area > q->area ? -1 : 1;
    return p->face - q->face;
}

// The faces between a patch and the sun, the largest first, into tools->order; returns their number.
static int find_shadows(const SunScene *s, SunTools *tools, const Patch *patch) {
    Box box = box_empty();
    arena_reset(&tools->scratch);
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        SunPolygon p = project_element(s, &s->mesh->elements[e], &tools->scratch);
        for (int i = 0; i < p.count; i++) box = box_add(box, p.corners[i]);
    }
    box.max.z = INFINITY;
    int found = box_tree_find(&s->tree, box, &tools->arena, &tools->hits), count = 0;
    Ranked *ranked = ARENA_ARRAY(&tools->scratch, Ranked, found + 1);
    for (int i = 0; i < found; i++) {
        int f = tools->hits.items[i];
        if (f != patch->face) ranked[count++] = (Ranked){s->faces[f].area, f};
    }
    qsort(ranked, (size_t)count, sizeof *ranked, by_area);
    if (count > tools->capacity) {
        tools->capacity = 2 * count;
        tools->order = ARENA_ARRAY(&tools->arena, int, tools->capacity);
    }
    for (int i = 0; i < count; i++) tools->order[i] = ranked[i].face;
    return count;
}

static bool is_dark(const SunScene *s, const Patch *patch) {
    const Face *face = &s->mesh->faces[patch->face];
    if (s->faces[patch->face].area == 0 || !s->faces[patch->face].front) return true;
    // A surface lies before one cell; things may stand in several.
    bool surface = face->object >= 0 && s->mesh->graph->objects[face->object].kind == OBJECT_SURFACE;
    return s->cells_alone && surface && patch->cell >= 0 && !s->reached[patch->cell];
}

static void light_patch(void *context, int index, int thread) {
    const SunScene *s = context;
    const Patch *patch = &s->mesh->patches[index];
    if (is_dark(s, patch)) return;
    SunTools *tools = &s->tools[thread];
    int count = find_shadows(s, tools, patch);
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
        s->share[e] = share_in_sun(s, tools, e, count);
}

void sunlight_shares(const Mesh *mesh, Vec3 sun, bool cells_alone, int threads, double *share) {
    Arena arena = {0};
    SunScene s = {.mesh = mesh, .sun = sun, .cells_alone = cells_alone, .share = share};
    view_axes(sun, &s.x, &s.y);
    s.tools = ARENA_ARRAY(&arena, SunTools, threads);
    memset(share, 0, (size_t)mesh->element_count * sizeof *share);
    project_faces(&s, &arena);
    project_panes(&s, &arena);
    if (cells_alone) reach_cells(&s, 0, &arena);
    parallel_for(threads, mesh->patch_count, light_patch, &s);
    for (int t = 0; t < threads; t++) {
        arena_free(&s.tools[t].arena);
        arena_free(&s.tools[t].scratch);
    }
    arena_free(&arena);
}

void sunlight_elements(const Mesh *mesh, const Daylight *day, int threads, double (*out)[3]) {
    Arena scratch = {0};
    double *share = ARENA_ARRAY(&scratch, double, mesh->element_count + 1);
    sunlight_shares(mesh, day->sun, true, threads, share);
    for (int e = 0; e < mesh->element_count; e++) {
        double rho[3], cosine = vec3_dot(mesh->faces[mesh->elements[e].face].plane.n, day->sun);
        rgb_doubles(mesh_reflectance(mesh, e), rho);
        for (int c = 0; c < 3; c++) out[e][c] = share[e] > 0 ? rho[c] * share[e] * cosine * day->beam[c] : 0;
    }
    arena_free(&scratch);
}
