// soup_planes.c - the planes of a soup: each opaque polygon finds the plane in which its corners lie within SOUP_SNAP, the
// largest polygons first, so that a wall of many polygons, or of two that coincide, is one plane.
//
// Areas that decide are compared as whole numbers of a millionth: what is equal by design then stays equal when the
// building is turned, and ties go to the polygon that comes first in the file.
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

// Polygons smaller than this share of the opaque area are details: they have no plane, and hide no cell.
static const double DETAIL = 1e-6;
// Polygons of one plane have normals that differ by no more than this sine.
static const double SAME_NORMAL = 1e-3;
// The cells reach this far beyond the soup, relative to its size: the outdoors.
static const double MARGIN = 0.25;
// A normal this near an axis is the axis: upright polygons stay so to the last bit.
static const double ON_AXIS = 1e-9;

// Planes at about one distance from the soup's centre: among these a polygon finds its own.
enum { SOUP_SHELVES = 500 };
typedef struct SoupShelf {
    int *planes;  // increasing
    int count, capacity;
} SoupShelf;

static Vec3 straighten(Vec3 n) {
    if (fabs(n.x) < ON_AXIS) n.x = 0;
    if (fabs(n.y) < ON_AXIS) n.y = 0;
    if (fabs(n.z) < ON_AXIS) n.z = 0;
    double length = vec3_length(n);
    n = vec3_scale(n, 1 / length);
    if (fabs(n.x) > 1 - ON_AXIS * ON_AXIS) n.x = n.x < 0 ? -1 : 1;
    if (fabs(n.y) > 1 - ON_AXIS * ON_AXIS) n.y = n.y < 0 ? -1 : 1;
    if (fabs(n.z) > 1 - ON_AXIS * ON_AXIS) n.z = n.z < 0 ? -1 : 1;
    return n;
}

static void measure_soup(Soup *soup) {
    const Building *b = soup->builder->building;
    Vec3 first = b->vertices[0], sum = {0, 0, 0};
    for (int i = 0; i < b->vertex_count; i++) sum = vec3_add(sum, vec3_sub(b->vertices[i], first));
    soup->centre = vec3_add(first, vec3_scale(sum, 1.0 / b->vertex_count));
    for (int i = 0; i < b->vertex_count; i++)
        soup->size = fmax(soup->size, 2 * vec3_length(vec3_sub(b->vertices[i], soup->centre)));
}

static void list_sheets(Soup *soup) {
    const Building *b = soup->builder->building;
    for (int o = 0; o < b->object_count; o++) {
        const Object *object = &b->objects[o];
        if (object->leaf >= 0) continue;  // doors are no walls
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            const Polygon *polygon = &b->polygons[p];
            if (b->materials[polygon->material].alpha < 1) continue;
            if (polygon->vertex_count > SOUP_MOST_CORNERS / 4) continue;  // too round to be cut by
            const Vec3 *v = b->vertices + polygon->first_vertex;
            double area = polygon_area(v, polygon->vertex_count);
            *ARENA_PUSH(soup->scratch, soup->sheets, soup->sheet_count, soup->sheet_capacity) =
                (SoupSheet){v, polygon->vertex_count, -1, area};
            soup->opaque_area += area;
        }
    }
}

// In units of DETAIL of all.
static double rounded(const Soup *soup, double area) {
    return nearbyint(area / (DETAIL * soup->opaque_area));
}

typedef struct Ranked {
    double area;
    int sheet;
} Ranked;

static int by_area(const void *p, const void *q) {
    const Ranked *a = p, *b = q;
    if (a->area != b->area) return a->area > b->area ? -1 : 1;
    return (a->sheet > b->sheet) - (a->sheet < b->sheet);
}

// Planes by their distance from the centre, up to half the size.
static int shelf_of(double distance, double size) {
    double shelf = fabs(distance) / size * 2 * SOUP_SHELVES;
    return shelf < SOUP_SHELVES ? (int)shelf : SOUP_SHELVES - 1;
}

// The first plane that the polygon lies in, or -1.
static int find_plane(const Soup *soup, const Vec3 *v, int count, Vec3 n) {
    // Planes whose normals differ by so much turn away from each other by half of that, from the centre to the soup's rim.
    double near = SOUP_SNAP * soup->size, slack = 0.6 * SAME_NORMAL * soup->size,
           away = fabs(vec3_dot(n, vec3_sub(v[0], soup->centre)));
    int first = -1;
    for (int s = shelf_of(fmax(away - slack, 0), soup->size); s <= shelf_of(away + slack, soup->size); s++) {
        const SoupShelf *shelf = &soup->shelves[s];
        for (int k = 0; k < shelf->count && (first < 0 || shelf->planes[k] < first); k++) {
            Plane plane = soup->planes[shelf->planes[k]].plane;
            if (fabs(plane_distance(plane, v[0])) > near) continue;
            if (vec3_length(vec3_cross(plane.n, n)) > SAME_NORMAL) continue;
            if (polygon_bend(v, count, plane) <= near) first = shelf->planes[k];
        }
    }
    return first;
}

static int add_plane(Soup *soup, Vec3 n, Vec3 through) {
    n = straighten(n);
    int index = soup->plane_count;
    *ARENA_PUSH(soup->scratch, soup->planes, soup->plane_count, soup->plane_capacity) =
        (SoupPlane){.plane = {n, vec3_dot(n, through)}};
    SoupShelf *shelf = &soup->shelves[shelf_of(vec3_dot(n, vec3_sub(through, soup->centre)), soup->size)];
    *ARENA_PUSH(soup->scratch, shelf->planes, shelf->count, shelf->capacity) = index;
    return index;
}

static int find_or_add(Soup *soup, const Vec3 *v, int count) {
    Plane plane = plane_of_polygon(v, count);
    int found = find_plane(soup, v, count, plane.n);
    return found >= 0 ? found : add_plane(soup, plane.n, v[0]);
}

static void assign_planes(Soup *soup) {
    Ranked *ranked = ARENA_ARRAY(soup->scratch, Ranked, soup->sheet_count);
    int count = 0;
    for (int i = 0; i < soup->sheet_count; i++) {
        double area = rounded(soup, soup->sheets[i].area);
        if (area >= 1) ranked[count++] = (Ranked){area, i};
    }
    qsort(ranked, (size_t)count, sizeof *ranked, by_area);
    for (int i = 0; i < count; i++) {
        SoupSheet *sheet = &soup->sheets[ranked[i].sheet];
        sheet->plane = find_or_add(soup, sheet->v, sheet->count);
        soup->planes[sheet->plane].area += sheet->area;
    }
}

// The largest plane whose normal is off the given ones (by more than 45 degrees off the first).
static int largest_plane(const Soup *soup, const Vec3 *off) {
    int best = -1;
    for (int i = 0; i < soup->plane_count; i++) {
        if (off && fabs(vec3_dot(soup->planes[i].plane.n, *off)) > M_SQRT1_2) continue;
        if (best < 0 || rounded(soup, soup->planes[i].area) > rounded(soup, soup->planes[best].area))
            best = i;
    }
    return best;
}

// The building's own directions, so that a building that is turned has its box turned with it.
static void find_axes(Soup *soup) {
    int first = largest_plane(soup, NULL);
    soup->axis[0] = first >= 0 ? soup->planes[first].plane.n : vec3(0, 0, 1);
    int second = largest_plane(soup, &soup->axis[0]);
    Vec3 n = soup->axis[0], along = fabs(n.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    if (second >= 0) along = soup->planes[second].plane.n;
    // One plane alone: along the first edge of its polygons.
    for (int i = 0; second < 0 && i < soup->sheet_count; i++) {
        along = vec3_sub(soup->sheets[i].v[1], soup->sheets[i].v[0]);
        if (vec3_length(vec3_cross(along, n)) > SOUP_SNAP * soup->size) break;
    }
    along = vec3_sub(along, vec3_scale(n, vec3_dot(n, along)));
    soup->axis[1] = straighten(vec3_normalize(along));
    soup->axis[2] = straighten(vec3_cross(soup->axis[0], soup->axis[1]));
}

// The corners of a side of a box in the building's own directions, counter-clockwise seen from within.
static void side_of_box(const Soup *soup, const double low[3], const double high[3], int side, Vec3 out[4]) {
    int k = side / 2, i = (k + 1) % 3, j = (k + 2) % 3;
    double at = side % 2 ? high[k] : low[k];
    for (int c = 0; c < 4; c++) {
        bool far_i = c == 1 || c == 2, far_j = c >= 2;
        if (side % 2) {
            bool swap = far_i;
            far_i = far_j;
            far_j = swap;
        }
        Vec3 p = vec3_add(soup->centre, vec3_scale(soup->axis[k], at));
        p = vec3_add(p, vec3_scale(soup->axis[i], far_i ? high[i] : low[i]));
        out[c] = vec3_add(p, vec3_scale(soup->axis[j], far_j ? high[j] : low[j]));
    }
}

// The sides of the building's own box, beyond which are the outdoors, and the borders of those.
static void add_borders(Soup *soup) {
    const Building *b = soup->builder->building;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < b->vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            double at = vec3_dot(soup->axis[k], vec3_sub(b->vertices[i], soup->centre));
            low[k] = fmin(low[k], at);
            high[k] = fmax(high[k], at);
        }
    }
    Vec3 corner[4];
    for (int side = 0; side < 6; side++) {
        side_of_box(soup, low, high, side, corner);
        Vec3 n = vec3_scale(soup->axis[side / 2], side % 2 ? -1 : 1);
        soup->box[side] = find_plane(soup, corner, 4, n);
        if (soup->box[side] < 0) soup->box[side] = add_plane(soup, n, corner[0]);
    }
    for (int k = 0; k < 3; k++) {
        low[k] -= MARGIN * soup->size;
        high[k] += MARGIN * soup->size;
    }
    SoupCell *world = soup_cell_new(soup);
    soup->border = soup->plane_count;
    for (int side = 0; side < 6; side++) {
        side_of_box(soup, low, high, side, corner);
        int plane = add_plane(soup, vec3_scale(soup->axis[side / 2], side % 2 ? -1 : 1), corner[0]);
        soup_cell_add_face(soup, world, plane, 1, corner, 4);
    }
}

static int by_plane(const void *p, const void *q) {
    const SoupSheet *a = p, *b = q;
    if (a->plane != b->plane) return a->plane < b->plane ? -1 : 1;
    return (a->v > b->v) - (a->v < b->v);
}

// Sheets sorted by plane; details fall out.
static void sort_sheets(Soup *soup) {
    int kept = 0;
    for (int i = 0; i < soup->sheet_count; i++) {
        if (soup->sheets[i].plane >= 0) soup->sheets[kept++] = soup->sheets[i];
    }
    soup->sheet_count = kept;
    if (kept > 0) qsort(soup->sheets, (size_t)kept, sizeof *soup->sheets, by_plane);
    for (int i = kept - 1; i >= 0; i--) {
        SoupPlane *plane = &soup->planes[soup->sheets[i].plane];
        plane->first_sheet = i;
        plane->sheet_count++;
    }
}

// The rectangle of a door: through the middle of its leaves, from sill to head.
static void find_doors(Soup *soup) {
    const Building *b = soup->builder->building;
    soup->doors = ARENA_ARRAY(soup->scratch, SoupDoor, b->opening_count);
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind != OPENING_DOOR || o->glazed) continue;
        Vec2 p = o->line[0], q = o->line[1];
        SoupDoor *door = &soup->doors[soup->door_count++];
        *door = (SoupDoor){.v = {vec3(p.x, p.y, o->sill), vec3(q.x, q.y, o->sill), vec3(q.x, q.y, o->head),
                                 vec3(p.x, p.y, o->head)},
                           .opening = i};
        door->plane = find_or_add(soup, door->v, 4);
    }
}

void soup_find_planes(Soup *soup) {
    soup->shelves = ARENA_ARRAY(soup->scratch, SoupShelf, SOUP_SHELVES);
    measure_soup(soup);
    list_sheets(soup);
    assign_planes(soup);
    find_axes(soup);
    find_doors(soup);
    add_borders(soup);
    sort_sheets(soup);
}
