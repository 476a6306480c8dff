// view.c - finds the faces in front of a point of a surface, in the axes of the point: the faces of the objects that the stab
// trees leave (Oki, section 3; Teller & Sequin 1991), but for faces below the horizon.
//
// Of the faces that the culling lets through, the face and the eye alone decide whether a face is in the view, and the face's
// numbers do not depend on the culling.
#include "radiosity/factors/view.h"

#include <string.h>

#include "engine/core/error.h"
#include "engine/core/lanes.h"

// An eye nearer to a plane than this is on the plane, metres: the rounding of coordinates up to some km; a sheet 2e-7 away is kept.
static const double ON_PLANE = 1e-9;
// Added to ON_PLANE for buildings far from the origin, as a share of the largest coordinate: eight roundings.
static const double ON_PLANE_RELATIVE = 8 * 0x1p-53;

// The numbers that the first tests of a face need, in one line of the cache.
typedef struct FaceShape {
    Vec3 centre;   // of its corners, on its plane
    Vec3 n;        // to its front
    float radius;  // of the sphere about the centre that contains the face, rounded up
    float tilt;    // the angle by which rounding may turn its plane, as a sine: Viewer.on_plane over its size
    int first, count;  // in Viewer.corners
} FaceShape;

typedef struct FaceKey {
    uint32_t distance;  // squared, m^2: the bits of a float, which sort like the float
    int face, first;    // `first` of the face's vertices in View.vertices
} FaceKey;

struct Viewer {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    VisQuery *query;
    FaceShape *shapes;  // [face_count]
    Vec3 *corners;      // [outline_count] of faces, building space
    double on_plane;    // metres
    int *object_face;   // [object_count + 1] object o has faces object_face[o] .. object_face[o + 1] - 1
    unsigned *seen;     // [object_count] the last look with CULL_CELLS that took the object
    unsigned looks;
    FaceKey *keys, *spare;  // [face_count]
    int key_count;
    View view;
};

void view_axes(Vec3 n, Vec3 *x, Vec3 *y) {
    // n is crossed with an axis that is far from it: z, or else x or y. Near the limits either choice gives good axes.
    double ax = fabs(n.x), ay = fabs(n.y), az = fabs(n.z);
    Vec3 axis = az < 0.9 ? vec3(0, 0, 1) : ax <= ay ? vec3(1, 0, 0) : vec3(0, 1, 0);
    *x = vec3_normalize(vec3_cross(axis, n));
    *y = vec3_cross(n, *x);
}

// ---- made once

static FaceShape shape_of(const Viewer *viewer, const Face *face) {
    const Vec3 *v = viewer->corners + face->first_vertex;
    Vec3 n = face->plane.n, sum = {0, 0, 0};
    for (int i = 0; i < face->vertex_count; i++) sum = vec3_add(sum, vec3_sub(v[i], v[0]));
    Vec3 centre = vec3_add(v[0], vec3_scale(sum, 1.0 / face->vertex_count));
    // The distance is measured from a point of the plane: far from the origin, dot(n, p) - d has lost its digits.
    centre = vec3_sub(centre, vec3_scale(n, vec3_dot(n, vec3_sub(centre, face->origin))));
    double radius = 0;
    for (int i = 0; i < face->vertex_count; i++) radius = fmax(radius, vec3_length(vec3_sub(v[i], centre)));
    float above = nextafterf((float)(radius * (1 + 1e-6) + viewer->on_plane), INFINITY);
    return (FaceShape){.centre = centre,
                       .n = n,
                       .radius = above,
                       .tilt = (float)(viewer->on_plane / radius),
                       .first = face->first_vertex,
                       .count = face->vertex_count};
}

static void list_faces(Viewer *viewer, Arena *arena) {
    const Mesh *mesh = viewer->mesh;
    viewer->corners = ARENA_ARRAY(arena, Vec3, mesh->outline_count);
    for (int i = 0; i < mesh->outline_count; i++) viewer->corners[i] = mesh->vertices[mesh->outline[i]];
    double largest = 0;
    for (int i = 0; i < mesh->vertex_count; i++) {
        Vec3 v = mesh->vertices[i];
        largest = fmax(largest, fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z))));
    }
    viewer->on_plane = ON_PLANE + ON_PLANE_RELATIVE * largest;
    viewer->shapes = ARENA_ARRAY(arena, FaceShape, mesh->face_count);
    for (int f = 0; f < mesh->face_count; f++) viewer->shapes[f] = shape_of(viewer, &mesh->faces[f]);
    // mesh->faces is in the order of objects.
    int objects = mesh->graph->object_count, f = 0;
    viewer->object_face = ARENA_ARRAY(arena, int, objects + 1);
    for (int o = 0; o < objects; o++) {
        viewer->object_face[o] = f;
        while (f < mesh->face_count && mesh->faces[f].object == o) f++;
    }
    viewer->object_face[objects] = f;
    CORE_ASSERT(f == mesh->face_count);
}

Viewer *viewer_new(const Mesh *mesh, const StabForest *forest, const float *door_open, Arena *arena) {
    Viewer *viewer = ARENA_ARRAY(arena, Viewer, 1);
    viewer->mesh = mesh;
    viewer->forest = forest;
    viewer->door_open = door_open;
    viewer->query = vis_query_new(mesh->graph, forest, arena);
    viewer->seen = ARENA_ARRAY(arena, unsigned, mesh->graph->object_count + 1);
    viewer->keys = ARENA_ARRAY(arena, FaceKey, mesh->face_count);
    viewer->spare = ARENA_ARRAY(arena, FaceKey, mesh->face_count);
    viewer->view.faces = ARENA_ARRAY(arena, ViewFace, mesh->face_count);
    viewer->view.vertices = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);  // one spare
    list_faces(viewer, arena);
    return viewer;
}

// ---- a look

typedef struct Look {
    Viewer *viewer;
    Vec3 eye, x, y, z;
    Four turn[3];  // the unit vectors x, y and z of building space in the view's axes
} Look;

static Vec3 to_view(const Look *look, Vec3 v) {
    return vec3(vec3_dot(look->x, v), vec3_dot(look->y, v), vec3_dot(look->z, v));
}

// May any part of the face be seen? Tests only the face's sphere and plane.
static inline bool may_be_seen(const Look *look, const FaceShape *shape, Vec3 to_centre) {
    double radius = (double)shape->radius;
    if (vec3_dot(look->z, to_centre) + radius <= 0) return false;
    // The plane contains the eye if the distance is within rounding, which grows with the distance of the face.
    double off = fabs(vec3_dot(shape->n, to_centre));
    return off >= 1e-3 || off > look->viewer->on_plane + (double)shape->tilt * vec3_length(to_centre);
}

static void take_face(const Look *look, int face) {
    Viewer *viewer = look->viewer;
    const FaceShape *shape = &viewer->shapes[face];
    if (!may_be_seen(look, shape, vec3_sub(shape->centre, look->eye))) return;
    int first = viewer->view.vertex_count;
    const Vec3 *from = viewer->corners + shape->first;
    Vec3 *to = viewer->view.vertices + first;
    double nearest = INFINITY, highest = -INFINITY;
    const Four x = look->turn[0], y = look->turn[1], z = look->turn[2];
    const Vec3 eye = look->eye;
    const int count = shape->count;
    for (int i = 0; i < count; i++) {
        // Gives the same bits as to_view; the fourth number is written to the next vertex, after the last one to the spare vertex.
        Vec3 off = vec3_sub(from[i], eye);
        Four v = x * off.x + y * off.y + z * off.z;
        memcpy(&to[i], &v, sizeof v);
        double distance = off.x * off.x + off.y * off.y + off.z * off.z;
        nearest = distance < nearest ? distance : nearest;
        highest = v[2] > highest ? v[2] : highest;
    }
    if (highest <= viewer->on_plane) return;
    viewer->view.vertex_count += shape->count;
    float key = (float)nearest;
    FaceKey *out = &viewer->keys[viewer->key_count++];
    memcpy(&out->distance, &key, sizeof key);
    out->face = face;
    out->first = first;
}

static void take_object(const Look *look, int object) {
    const int *first = look->viewer->object_face + object;
    for (int f = first[0]; f < first[1]; f++) take_face(look, f);
}

// Takes the objects of all cells that may be seen from anywhere in the eye's cell.
static void take_cells(const Look *look, int cell) {
    Viewer *viewer = look->viewer;
    const CellGraph *graph = viewer->mesh->graph;
    viewer->looks++;
    for (int c = 0; c < graph->cell_count; c++) {
        if (!vis_sees(viewer->forest, cell, c)) continue;
        const SquareGrid *squares = &graph->grids[c];
        int end = graph->square_first[squares->first_square + squares->nx * squares->ny];
        for (int k = graph->square_first[squares->first_square]; k < end; k++) {
            int object = graph->square_objects[k];
            if (viewer->seen[object] == viewer->looks) continue;
            viewer->seen[object] = viewer->looks;
            take_object(look, object);
        }
    }
}

// How many objects ahead memory is prefetched: FAR_AHEAD for the shapes of their faces, AHEAD for the corners of the faces.
enum { AHEAD = 3, FAR_AHEAD = 6 };

// Prefetches the next objects, which are scattered over memory.
static inline void fetch_ahead(const Viewer *viewer, const int *objects, int left) {
    const FaceShape *shapes = viewer->shapes;
    if (left > FAR_AHEAD) {
        const int *first = viewer->object_face + objects[FAR_AHEAD];
        __builtin_prefetch(&shapes[first[0]]);
        __builtin_prefetch(&shapes[first[0] + 1]);
    }
    if (left > AHEAD) {
        const int *first = viewer->object_face + objects[AHEAD];
        if (first[0] == first[1]) return;
        const char *corners = (const char *)&viewer->corners[shapes[first[0]].first];
        for (int k = 0; k < 2; k++) __builtin_prefetch(corners + 64 * k);
    }
}

static void take_query(const Look *look, int cell, Culling culling) {
    Viewer *viewer = look->viewer;
    Eye eye = {.position = look->eye, .frustum_count = 1, .on_surface = true};
    eye.frustum[0] = (Plane){look->z, vec3_dot(look->z, look->eye)};
    VisResult result = vis_query(viewer->query, &eye, cell, viewer->door_open, culling);
    for (int i = 0; i < result.object_count; i++) {
        fetch_ahead(look->viewer, result.objects + i, result.object_count - i);
        take_object(look, result.objects[i]);
    }
}

// Sorts the keys by distance, to half a percent, keeping the order of equal keys: a radix sort by the two upper bytes, the lower
// byte first.
static void sort_keys(Viewer *viewer) {
    enum { BYTES = 2, VALUES = 256, SKIPPED = 16 };
    int count[BYTES][VALUES] = {{0}};
    for (int i = 0; i < viewer->key_count; i++)
        for (int k = 0; k < BYTES; k++) count[k][viewer->keys[i].distance >> (8 * k + SKIPPED) & 255]++;
    for (int k = 0; k < BYTES; k++) {
        for (int v = 0, at = 0; v < VALUES; v++) {
            int here = count[k][v];
            count[k][v] = at;
            at += here;
        }
        for (int i = 0; i < viewer->key_count; i++) {
            int value = viewer->keys[i].distance >> (8 * k + SKIPPED) & 255;
            viewer->spare[count[k][value]++] = viewer->keys[i];
        }
        FaceKey *swap = viewer->keys;
        viewer->keys = viewer->spare;
        viewer->spare = swap;
    }
}

static void list_view(const Look *look) {
    Viewer *viewer = look->viewer;
    View *view = &viewer->view;
    sort_keys(viewer);
    view->face_count = viewer->key_count;
    for (int i = 0; i < viewer->key_count; i++) {
        const FaceKey *key = &viewer->keys[i];
        const FaceShape *shape = &viewer->shapes[key->face];
        Vec3 off = vec3_sub(shape->centre, look->eye);
        Four centre = look->turn[0] * off.x + look->turn[1] * off.y + look->turn[2] * off.z;
        view->faces[i] = (ViewFace){.face = key->face,
                                    .first_vertex = key->first,
                                    .vertex_count = shape->count,
                                    .radius = shape->radius,
                                    .centre = {(float)centre[0], (float)centre[1], (float)centre[2]},
                                    .n = to_view(look, shape->n),
                                    .d = vec3_dot(shape->n, off)};
    }
}

const View *viewer_look(Viewer *viewer, const ViewPoint *from, Culling culling) {
    CORE_ASSERT(culling < CULLINGS);
    CORE_ASSERT(from->cell < viewer->mesh->graph->cell_count);
    Look look = {.viewer = viewer, .eye = from->eye, .z = from->normal};
    view_axes(look.z, &look.x, &look.y);
    look.turn[0] = (Four){look.x.x, look.y.x, look.z.x, 0};
    look.turn[1] = (Four){look.x.y, look.y.y, look.z.y, 0};
    look.turn[2] = (Four){look.x.z, look.y.z, look.z.z, 0};
    View *view = &viewer->view;
    view->eye = look.eye;
    view->x = look.x;
    view->y = look.y;
    view->z = look.z;
    view->by_depth = culling != CULL_NONE;
    view->vertex_count = viewer->key_count = 0;
    if (from->cell < 0 || culling == CULL_NONE || culling == CULL_DEPTH) {
        for (int f = 0; f < viewer->mesh->face_count; f++) take_face(&look, f);
    } else if (culling == CULL_CELLS) {
        take_cells(&look, from->cell);
    } else {
        take_query(&look, from->cell, culling);
    }
    list_view(&look);
    return view;
}
