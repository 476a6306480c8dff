// mirrors.c - finds the mirrors of a building once, and for each view those that are seen, the image of the camera in each, and by a
// query from that image, through the mirror's rectangle in the picture, what is seen there.
#include "engine/draw/mirrors.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/polygon.h"
#include "engine/draw/view.h"

// Polygons belong to one mirror if they lie this near its plane, metres: what is seen in it is then off by a tenth of a millimetre.
#define ONE_PLANE 5e-5
// Only planes whose distances from the building's middle differ by less are compared, metres: far more than coplanar polygons' do.
#define NEAR_PLANES 1e-2
// An eye nearer than this to a mirror's plane sees nothing in it, metres.
#define EYE_CLEARANCE 1e-3
// A point nearer to the eye than this, along the eye's direction, counts as behind it, metres.
#define NEAREST 1e-6

typedef struct Mirror {
    int first, count;  // in Mirrors.polygons
    int leaf;          // with which it moves, or -1
    float share;
} Mirror;

struct Mirrors {
    const CellGraph *graph;
    VisQuery *query;
    Mirror *mirrors;
    int *polygons, *object_of;  // [polygon_count] those of each mirror together, and the object of each
    Vec3 *corners;              // room for one polygon's
    int *ahead;                 // [polygon_count] polygons that the camera is before: each view's together
    unsigned *drawn;            // [object_count] the last view in which the object was drawn
    // Cells that an object of a mirror touches: those of object o are cells[cell_first[o]] .. cells[cell_first[o + 1] - 1].
    int *cell_first, *cells;
    unsigned *listed;  // [cell_count] the last list of cells in which the cell is
    unsigned view, lists;
    int count, polygon_count;
    Arena arena;  // of the last view
    MirrorView views[MIRRORS_SHOWN];
};

// ---- all mirrors, once

typedef struct MirrorPolygon {
    int polygon, object, leaf;
    float share;
    double distance;  // of its plane from the building's middle, metres
} MirrorPolygon;

static bool is_mirror(const Material *m) { return m->mirror >= MIRROR_LEAST && m->alpha >= 1; }

bool mirrors_in(const Building *b) {
    for (int i = 0; i < b->material_count; i++) {
        if (is_mirror(&b->materials[i])) return true;
    }
    return false;
}

static Plane plane_of(const CellGraph *graph, int polygon) {
    const Polygon *p = &graph->polygons[polygon];
    return plane_of_polygon(graph->vertices + p->first_vertex, p->vertex_count);
}

// [count]; NULL `out` counts only.
static int list_mirror_polygons(const CellGraph *graph, MirrorPolygon *out) {
    Vec3 middle = vec3_lerp(graph->box.min, graph->box.max, 0.5);
    int count = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            const Material *m = &graph->building->materials[graph->polygons[p].material];
            if (!is_mirror(m)) continue;
            if (out)
                out[count] = (MirrorPolygon){p, o, object->leaf, m->mirror,
                                             plane_distance(plane_of(graph, p), middle)};
            count++;
        }
    }
    return count;
}

static int by_plane(const void *p, const void *q) {
    const MirrorPolygon *a = p, *b = q;
    if (a->leaf != b->leaf) return a->leaf < b->leaf ? -1 : 1;
    if (a->share != b->share) return a->share < b->share ? -1 : 1;
    if (a->distance != b->distance) return a->distance < b->distance ? -1 : 1;
    return (a->polygon > b->polygon) - (a->polygon < b->polygon);
}

static bool lies_in(const CellGraph *graph, int polygon, Plane plane) {
    const Polygon *p = &graph->polygons[polygon];
    if (vec3_dot(plane_of(graph, polygon).n, plane.n) < 0) return false;
    for (int i = 0; i < p->vertex_count; i++) {
        if (fabs(plane_distance(plane, graph->vertices[p->first_vertex + i])) > ONE_PLANE) return false;
    }
    return true;
}

// The mirror of all[first] and of those after it that lie in its plane and belong to no mirror yet. `all` is in the order of by_plane.
static void gather_mirror(Mirrors *m, const MirrorPolygon *all, int total, int first, unsigned char *taken) {
    const MirrorPolygon *like = &all[first];
    Plane plane = plane_of(m->graph, like->polygon);
    Mirror mirror = {.first = m->polygon_count, .leaf = like->leaf, .share = like->share};
    double area = 0;
    Box box = box_empty();
    for (int i = first; i < total; i++) {
        const MirrorPolygon *p = &all[i];
        if (p->leaf != like->leaf || p->share != like->share || p->distance > like->distance + NEAR_PLANES)
            break;
        if (taken[i] || !lies_in(m->graph, p->polygon, plane)) continue;
        taken[i] = 1;
        m->polygons[mirror.first + mirror.count] = p->polygon;
        m->object_of[mirror.first + mirror.count++] = p->object;
        const Polygon *polygon = &m->graph->polygons[p->polygon];
        const Vec3 *corners = m->graph->vertices + polygon->first_vertex;
        area += polygon_area(corners, polygon->vertex_count);
        for (int k = 0; k < polygon->vertex_count; k++) box = box_add(box, corners[k]);
    }
    if (area < MIRROR_SMALLEST || area < MIRROR_NARROWEST * vec3_length(vec3_sub(box.max, box.min))) return;
    m->mirrors[m->count++] = mirror;
    m->polygon_count += mirror.count;
}

// Counts the cell for the object, or, in the second pass, writes it. `last` [object_count] tells the last cell of each object of a mirror,
// -2 for others.
static void touch_cell(Mirrors *m, int *last, int object, int cell, bool write) {
    if (last[object] == -2 || last[object] == cell) return;
    last[object] = cell;
    if (write) m->cells[m->cell_first[object]] = cell;
    m->cell_first[object]++;
}

static void touch_cells(Mirrors *m, int *last, bool write) {
    const CellGraph *graph = m->graph;
    for (int o = 0; o < graph->object_count; o++) last[o] = -2;
    for (int i = 0; i < m->polygon_count; i++) last[m->object_of[i]] = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        const SquareGrid *grid = &graph->grids[c];
        int end = graph->square_first[grid->first_square + grid->nx * grid->ny];
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1]; o++)
            touch_cell(m, last, o, c, write);
        for (int k = graph->square_first[grid->first_square]; k < end; k++)
            touch_cell(m, last, graph->square_objects[k], c, write);
    }
}

// The cells among whose surfaces or in whose squares each object is.
static void list_cells(Mirrors *m, Arena *arena) {
    int objects = m->graph->object_count, total = 0;
    Arena scratch = {0};
    int *last = ARENA_ARRAY(&scratch, int, objects + 1);
    m->cell_first = ARENA_ARRAY(arena, int, objects + 1);
    touch_cells(m, last, false);
    for (int o = 0; o <= objects; o++) {
        int count = m->cell_first[o];
        m->cell_first[o] = total;
        total += count;
    }
    m->cells = ARENA_ARRAY(arena, int, total + 1);
    touch_cells(m, last, true);
    // Writing has moved each beginning to the next one's.
    for (int o = objects; o > 0; o--) m->cell_first[o] = m->cell_first[o - 1];
    m->cell_first[0] = 0;
    m->listed = ARENA_ARRAY(arena, unsigned, m->graph->cell_count + 1);
    arena_free(&scratch);
}

Mirrors *mirrors_new(const CellGraph *graph, const StabForest *forest, Arena *arena) {
    int total = list_mirror_polygons(graph, NULL);
    if (total == 0) return NULL;
    Arena scratch = {0};
    MirrorPolygon *all = ARENA_ARRAY(&scratch, MirrorPolygon, total);
    unsigned char *taken = ARENA_ARRAY(&scratch, unsigned char, total);
    list_mirror_polygons(graph, all);
    qsort(all, (size_t)total, sizeof *all, by_plane);
    Mirrors *m = ARENA_ARRAY(arena, Mirrors, 1);
    *m = (Mirrors){.graph = graph};
    m->mirrors = ARENA_ARRAY(arena, Mirror, total);
    m->polygons = ARENA_ARRAY(arena, int, total);
    m->object_of = ARENA_ARRAY(arena, int, total);
    for (int i = 0; i < total; i++) {
        if (!taken[i]) gather_mirror(m, all, total, i, taken);
    }
    arena_free(&scratch);
    if (m->count == 0) return NULL;
    list_cells(m, arena);
    int most = 0;
    for (int i = 0; i < m->polygon_count; i++) {
        int corners = graph->polygons[m->polygons[i]].vertex_count;
        if (corners > most) most = corners;
    }
    m->corners = ARENA_ARRAY(arena, Vec3, most);
    m->ahead = ARENA_ARRAY(arena, int, m->polygon_count);
    m->drawn = ARENA_ARRAY(arena, unsigned, graph->object_count + 1);
    m->query = vis_query_new(graph, forest, arena);
    return m;
}

void mirrors_free(Mirrors *m) {
    if (m) arena_free(&m->arena);
}

// ---- those in view

// The corners of a mirror's polygon as its leaf stands: in m->corners.
static int pose_polygon(Mirrors *m, const Mirror *mirror, int polygon, const float *door_open) {
    const Polygon *p = &m->graph->polygons[polygon];
    const Leaf *leaf = mirror->leaf < 0 ? NULL : &m->graph->building->leaves[mirror->leaf];
    double open = leaf && door_open ? (double)door_open[leaf->opening] : 1;
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 closed = m->graph->vertices[p->first_vertex + i];
        m->corners[i] = leaf ? leaf_point(leaf, open, closed) : closed;
    }
    return p->vertex_count;
}

static void cover_pixel(MirrorView *view, double x, double y) {
    // Rasterisers round corners to a 256th of a pixel: one pixel more on each side holds them.
    const Camera *c = &view->camera;
    view->left = (int)fmax(0, fmin(view->left, floor(x) - 1));
    view->top = (int)fmax(0, fmin(view->top, floor(y) - 1));
    view->right = (int)fmin(c->width, fmax(view->right, ceil(x) + 1));
    view->bottom = (int)fmin(c->height, fmax(view->bottom, ceil(y) + 1));
}

// Grows the view's rectangle by the pixels that the polygon in m->corners covers, whose edges are cut off behind the eye.
static void cover_polygon(const Mirrors *m, int count, MirrorView *view) {
    const Camera *c = &view->camera;
    for (int i = 0; i < count; i++) {
        Vec3 end[2] = {vec3_sub(m->corners[i], c->eye), vec3_sub(m->corners[(i + 1) % count], c->eye)};
        double z[2] = {vec3_dot(end[0], c->forward), vec3_dot(end[1], c->forward)};
        if (z[0] < NEAREST && z[1] < NEAREST) continue;
        for (int k = 0; k < 2; k++) {
            Vec3 at = end[k];
            if (z[k] < NEAREST) at = vec3_lerp(at, end[1 - k], (NEAREST - z[k]) / (z[1 - k] - z[k]));
            double depth = fmax(z[k], NEAREST);
            cover_pixel(view, (vec3_dot(at, c->right) / (depth * c->tan_x) + 1) / 2 * c->width,
                        (1 - vec3_dot(at, c->up) / (depth * c->tan_y)) / 2 * c->height);
        }
    }
}

static Vec3 reflect_direction(Plane plane, Vec3 v) {
    return vec3_sub(v, vec3_scale(plane.n, 2 * vec3_dot(plane.n, v)));
}

static Camera reflect_camera(Plane plane, const Camera *c) {
    Camera image = *c;
    image.eye = vec3_sub(c->eye, vec3_scale(plane.n, 2 * plane_distance(plane, c->eye)));
    image.forward = reflect_direction(plane, c->forward);
    image.right = reflect_direction(plane, c->right);
    image.up = reflect_direction(plane, c->up);
    return image;
}

// The cells that those objects of the mirror touch which the camera sees, each once.
static void list_start(Mirrors *m, const Mirror *mirror, MirrorView *out) {
    int *cells = NULL, capacity = 0;
    m->lists++;
    for (int i = mirror->first; i < mirror->first + mirror->count; i++) {
        int object = m->object_of[i];
        if (m->drawn[object] != m->view) continue;
        for (int k = m->cell_first[object]; k < m->cell_first[object + 1]; k++) {
            if (m->listed[m->cells[k]] == m->lists) continue;
            m->listed[m->cells[k]] = m->lists;
            *ARENA_PUSH(&m->arena, cells, out->cell_count, capacity) = m->cells[k];
        }
    }
    out->cells = cells;
}

// The mirror as the camera sees it, without what is seen in it; false where none of it can be seen. `ahead` gets its polygons.
static bool see_mirror(Mirrors *m, const Mirror *mirror, const Camera *camera, const float *door_open,
                       int *ahead, MirrorView *out) {
    int count = pose_polygon(m, mirror, m->polygons[mirror->first], door_open);
    Plane plane = plane_of_polygon(m->corners, count);
    if (plane_distance(plane, camera->eye) < EYE_CLEARANCE) return false;
    *out = (MirrorView){.camera = *camera,
                        .before = {plane.n, plane.d - MIRROR_SLACK},
                        .left = camera->width,
                        .top = camera->height,
                        .polygons = ahead,
                        .leaf = mirror->leaf,
                        .share = mirror->share};
    for (int i = mirror->first; i < mirror->first + mirror->count; i++) {
        int object = m->object_of[i];
        if (m->drawn[object] != m->view || !vis_shown(&m->graph->objects[object], door_open)) continue;
        cover_polygon(m, pose_polygon(m, mirror, m->polygons[i], door_open), out);
        ahead[out->polygon_count++] = m->polygons[i];
    }
    list_start(m, mirror, out);
    out->camera = reflect_camera(plane, camera);
    return out->cell_count > 0 && out->left < out->right && out->top < out->bottom;
}

static long pixels_of(const MirrorView *v) { return (long)(v->right - v->left) * (v->bottom - v->top); }

// Keeps the largest views, the largest first; returns how many there are.
static int keep_view(MirrorView *views, int count, const MirrorView *view) {
    int at = count;
    while (at > 0 && pixels_of(&views[at - 1]) < pixels_of(view)) at--;
    if (at == MIRRORS_SHOWN) return count;
    if (count == MIRRORS_SHOWN) count--;
    memmove(&views[at + 1], &views[at], (size_t)(count - at) * sizeof *views);
    views[at] = *view;
    return count + 1;
}

// The plane through the eye and pixel column `place` of `size`, which keeps the side to which `across` points.
static Plane edge_plane(const Camera *c, Vec3 across, double tangent, double place, double size, int side) {
    double at = (2 * place / size - 1) * tangent;
    Vec3 n = vec3_normalize(vec3_scale(vec3_sub(across, vec3_scale(c->forward, at)), side));
    return (Plane){n, vec3_dot(n, c->eye)};
}

static Eye mirror_eye(const MirrorView *v) {
    const Camera *c = &v->camera;
    Vec3 down = vec3_scale(c->up, -1);
    return (Eye){.position = c->eye,
                 .frustum = {edge_plane(c, c->right, c->tan_x, v->left, c->width, 1),
                             edge_plane(c, c->right, c->tan_x, v->right, c->width, -1),
                             edge_plane(c, down, c->tan_y, v->top, c->height, 1),
                             edge_plane(c, down, c->tan_y, v->bottom, c->height, -1), v->before},
                 .frustum_count = 5,
                 .start = v->cells,
                 .start_count = v->cell_count};
}

// Marks what the camera sees. Other ways of culling than by stab trees leave more, hidden mirrors among it, and these must not take the
// place of mirrors that are seen: then the same is asked once more.
static void mark_visible(Mirrors *m, const Camera *camera, VisResult visible, const float *door_open,
                         Culling culling) {
    if (culling != CULL_STAB) {
        Eye eye = walk_eye(camera);
        visible = vis_query(m->query, &eye, visible.eye_cell, door_open, CULL_STAB);
    }
    m->view++;
    for (int i = 0; i < visible.object_count; i++) m->drawn[visible.objects[i]] = m->view;
}

int mirrors_look(Mirrors *m, const Camera *camera, const VisResult *visible, const float *door_open,
                 Culling culling, const MirrorView **views) {
    *views = NULL;
    if (!m) return 0;
    mark_visible(m, camera, *visible, door_open, culling);
    arena_reset(&m->arena);
    int count = 0;
    for (int i = 0; i < m->count; i++) {
        MirrorView view;
        const Mirror *mirror = &m->mirrors[i];
        if (see_mirror(m, mirror, camera, door_open, m->ahead + mirror->first, &view))
            count = keep_view(m->views, count, &view);
    }
    for (int i = 0; i < count; i++) {
        MirrorView *view = &m->views[i];
        Eye eye = mirror_eye(view);
        VisResult seen = vis_query(m->query, &eye, -1, door_open, culling);
        int *list = ARENA_ARRAY(&m->arena, int, seen.object_count + 1);
        memcpy(list, seen.objects, (size_t)seen.object_count * sizeof *list);
        view->objects = list;
        view->object_count = seen.object_count;
    }
    *views = m->views;
    return count;
}
