// view.c - finds the faces in front of a point of a surface, in the axes of the point: the faces of the objects that the stab
// trees leave (Oki, section 3; Teller & Sequin 1991), but for faces below the horizon.
//
// Of the faces that the culling lets through, the face and the eye alone decide whether a face is in the view, and the face's
// numbers do not depend on the culling.
#include "radiosity/factors/view.h"

#include <stdlib.h>
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

// Faces of one object that lie together.
typedef struct Cluster {
    Vec3 centre, half;  // of the box about them: its middle, and half its size, metres
    int first, count;   // in Viewer.shapes
} Cluster;

// Their corners, a lane for each face, from the middle of the box in the axes of the building. Of polygons with more corners than four,
// the corners of a rectangle about them.
typedef struct ClusterCorners {
    Lane at[CLUSTER_CORNERS][3];
} ClusterCorners;

// A face's shape, or a cluster, to be sorted by distance.
typedef struct FaceKey {
    uint32_t distance;  // squared, m^2: the bits of a float, which sort like the float
    int shape, first;   // `first` of the face's vertices in View.vertices
} FaceKey;

// A face on its way into a cluster.
typedef struct Placed {
    double at;
    int face;
    FaceShape shape;
} Placed;

// The point and the axes of the view at hand.
typedef struct Look {
    Viewer *viewer;
    Vec3 eye, x, y, z;
    Four turn[3];  // the unit vectors x, y and z of building space in the view's axes
    bool leave;    // clusters are left closed
} Look;

struct Viewer {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    VisQuery *query;
    FaceShape *shapes;                // [face_count] cluster by cluster
    int *face_of;                     // [face_count] the shape's, in Mesh.faces
    ClusterCorners *cluster_corners;  // [cluster_count]
    Cluster *clusters;                // [cluster_count] in the order of objects
    Vec3 *corners;                    // [outline_count] of faces, shape by shape, building space
    double on_plane;                  // metres
    // [object_count + 1] object o has clusters object_cluster[o] .. object_cluster[o + 1] - 1
    int *object_cluster;
    int cluster_count;
    bool *hidden;     // [object_count] by the state of its door
    Placed *placed;   // [of the object with most faces]
    int *door_of;     // [object_count] the opening of a leaf, -1
    int *cell_first;  // [cell_count + 1] in `cell_doors`
    // Doors that are seen wherever a cell beside them is: they have no leaf that is an object, or glass.
    int *cell_doors;
    uint64_t *doors;  // [door_words] of the view
    int door_words;
    unsigned *seen;  // [object_count] the last look with CULL_CELLS that took the object
    unsigned looks;
    FaceKey *keys, *spare;                       // [face_count]
    FaceKey *cluster_keys, *spare_cluster_keys;  // [cluster_count]
    ViewCluster *found;                          // [cluster_count] those of the view, before they are sorted
    int key_count;
    Look look;
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

// Clusters of fewer faces are never closed.
enum { LEAST_IN_CLUSTER = 3 };

static int by_place(const void *a, const void *b) {
    const Placed *p = a, *q = b;
    return p->at != q->at ? (p->at > q->at ? 1 : -1) : p->face - q->face;
}

static Vec3 middle_of_box(const Vec3 *v, int count, Vec3 *half) {
    Vec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < count; i++) {
        low = vec3(fmin(low.x, v[i].x), fmin(low.y, v[i].y), fmin(low.z, v[i].z));
        high = vec3(fmax(high.x, v[i].x), fmax(high.y, v[i].y), fmax(high.z, v[i].z));
    }
    *half = vec3_scale(vec3_sub(high, low), 0.5);
    return vec3_scale(vec3_add(low, high), 0.5);
}

// Corners of a quadrilateral that contains the face.
static void four_around(const FaceShape *shape, const Vec3 *v, Vec3 out[CLUSTER_CORNERS]) {
    for (int i = 0; i < CLUSTER_CORNERS; i++) out[i] = v[i < shape->count ? i : shape->count - 1];
    if (shape->count <= CLUSTER_CORNERS) return;
    Vec3 x, y;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    view_axes(shape->n, &x, &y);
    for (int i = 0; i < shape->count; i++) {
        Vec3 off = vec3_sub(v[i], shape->centre);
        const double at[2] = {vec3_dot(x, off), vec3_dot(y, off)};
        for (int k = 0; k < 2; k++) low[k] = fmin(low[k], at[k]), high[k] = fmax(high[k], at[k]);
    }
    for (int i = 0; i < CLUSTER_CORNERS; i++)
        out[i] = vec3_add(shape->centre, vec3_add(vec3_scale(x, i % 2 ? high[0] : low[0]),
                                                  vec3_scale(y, i / 2 ? high[1] : low[1])));
}

// Makes cluster `index` of faces whose shapes are there.
static void put_cluster(Viewer *viewer, int index, int first, int count) {
    Vec3 around[LANES][CLUSTER_CORNERS], half;
    for (int i = 0; i < LANES; i++) {
        const FaceShape *shape = &viewer->shapes[first + (i < count ? i : 0)];
        four_around(shape, viewer->corners + shape->first, around[i]);
    }
    Vec3 centre = middle_of_box(around[0], LANES * CLUSTER_CORNERS, &half);
    ClusterCorners *corners = &viewer->cluster_corners[index];
    for (int i = 0; i < LANES; i++) {
        for (int k = 0; k < CLUSTER_CORNERS; k++) {
            Vec3 off = vec3_sub(around[i][k], centre);
            corners->at[k][0][i] = (float)off.x;
            corners->at[k][1][i] = (float)off.y;
            corners->at[k][2][i] = (float)off.z;
        }
    }
    double more = viewer->on_plane;
    half = vec3_add(half, vec3(more, more, more));
    viewer->clusters[index] = (Cluster){centre, half, first, count};
}

// Clusters of so many faces.
static int clusters_of(int count) { return (count + LANES - 1) / LANES; }

// Cuts faces in halves, across the longest way between their centres, until a half is a cluster: `cluster` and those that follow.
static void cluster_faces(Viewer *viewer, Placed *faces, int first, int count, int cluster) {
    if (count <= LANES) {
        for (int i = 0; i < count; i++) {
            viewer->shapes[first + i] = faces[i].shape;
            viewer->face_of[first + i] = faces[i].face;
        }
        if (count > 0) put_cluster(viewer, cluster, first, count);
        return;
    }
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    int axis = 0;
    for (int i = 0; i < count; i++) {
        const double at[3] = {faces[i].shape.centre.x, faces[i].shape.centre.y, faces[i].shape.centre.z};
        for (int c = 0; c < 3; c++) low[c] = fmin(low[c], at[c]), high[c] = fmax(high[c], at[c]);
    }
    for (int c = 1; c < 3; c++)
        if (high[c] - low[c] > high[axis] - low[axis]) axis = c;
    for (int i = 0; i < count; i++) {
        Vec3 at = faces[i].shape.centre;
        faces[i].at = axis == 0 ? at.x : axis == 1 ? at.y : at.z;
    }
    qsort(faces, (size_t)count, sizeof *faces, by_place);
    // All clusters but the last are full.
    int half = (count / 2 + LANES - 1) / LANES * LANES;
    cluster_faces(viewer, faces, first, half, cluster);
    cluster_faces(viewer, faces + half, first + half, count - half, cluster + half / LANES);
}

// Lists the faces first .. end - 1, those of one object, as they stand.
static void list_object(Viewer *viewer, int object, int first, int end) {
    const Mesh *mesh = viewer->mesh;
    if (first == end) return;
    for (int f = first; f < end; f++) {
        const Face *face = &mesh->faces[f];
        for (int i = face->first_vertex; i < face->first_vertex + face->vertex_count; i++)
            viewer->corners[i] = mesh->vertices[mesh->outline[i]];
        viewer->placed[f - first] = (Placed){0, f, shape_of(viewer, face)};
    }
    // All faces of an object are hidden, or none.
    viewer->hidden[object] = mesh->faces[first].hidden;
    cluster_faces(viewer, viewer->placed, first, end - first, viewer->object_cluster[object]);
}

static int end_of_object(const Mesh *mesh, int first) {
    int end = first;
    while (end < mesh->face_count && mesh->faces[end].object == mesh->faces[first].object) end++;
    return end;
}

// Lists the faces of all objects, or of those alone that doors move.
static void list_objects(Viewer *viewer, bool moving) {
    const Mesh *mesh = viewer->mesh;
    // mesh->faces is in the order of objects.
    for (int f = 0, end; f < mesh->face_count; f = end) {
        const Object *object = &mesh->graph->objects[mesh->faces[f].object];
        end = end_of_object(mesh, f);
        if (!moving || object->leaf >= 0 || object->plug) list_object(viewer, mesh->faces[f].object, f, end);
    }
}

static void list_faces(Viewer *viewer, Arena *arena) {
    const Mesh *mesh = viewer->mesh;
    viewer->corners = ARENA_ARRAY(arena, Vec3, mesh->outline_count);
    double largest = 0;
    for (int i = 0; i < mesh->vertex_count; i++) {
        Vec3 v = mesh->vertices[i];
        largest = fmax(largest, fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z))));
    }
    viewer->on_plane = ON_PLANE + ON_PLANE_RELATIVE * largest;
    int objects = mesh->graph->object_count, most = 0;
    viewer->shapes = ARENA_ARRAY(arena, FaceShape, mesh->face_count);
    viewer->face_of = ARENA_ARRAY(arena, int, mesh->face_count);
    viewer->object_cluster = ARENA_ARRAY(arena, int, objects + 1);
    viewer->hidden = ARENA_ARRAY(arena, bool, objects + 1);
    for (int f = 0, end; f < mesh->face_count; f = end) {
        end = end_of_object(mesh, f);
        viewer->object_cluster[mesh->faces[f].object + 1] = clusters_of(end - f);
        most = end - f > most ? end - f : most;
    }
    for (int o = 0; o < objects; o++) viewer->object_cluster[o + 1] += viewer->object_cluster[o];
    viewer->cluster_count = viewer->object_cluster[objects];
    viewer->clusters = ARENA_ARRAY(arena, Cluster, viewer->cluster_count);
    viewer->cluster_corners = ARENA_ARRAY(arena, ClusterCorners, viewer->cluster_count);
    viewer->placed = ARENA_ARRAY(arena, Placed, most + 1);
    list_objects(viewer, false);
}

void viewer_pose(Viewer *viewer) { list_objects(viewer, true); }

// ---- doors

static bool seen_by_cells(const Building *b, const bool *has_leaf, int opening) {
    return b->openings[opening].kind == OPENING_DOOR && (b->openings[opening].glazed || !has_leaf[opening]);
}

static void list_doors(Viewer *viewer, Arena *arena) {
    const CellGraph *graph = viewer->mesh->graph;
    const Building *b = graph->building;
    Arena scratch = {0};
    bool *has_leaf = ARENA_ARRAY(&scratch, bool, b->opening_count + 1);
    viewer->door_words = viewer_door_words(viewer->mesh);
    viewer->doors = ARENA_ARRAY(arena, uint64_t, viewer->door_words + 1);
    viewer->door_of = ARENA_ARRAY(arena, int, graph->object_count + 1);
    viewer->cell_first = ARENA_ARRAY(arena, int, graph->cell_count + 2);
    for (int o = 0; o < graph->object_count; o++) {
        int leaf = graph->objects[o].leaf;
        viewer->door_of[o] = leaf >= 0 ? b->leaves[leaf].opening : -1;
        if (leaf >= 0) has_leaf[b->leaves[leaf].opening] = true;
    }
    // Counts are stored two places ahead, and fills advance the entry one place ahead.
    int *first = viewer->cell_first, *count = ARENA_ARRAY(&scratch, int, graph->cell_count + 2);
    for (int pass = 0; pass < 2; pass++) {
        for (int p = 0; p < graph->portal_count; p++) {
            int door = graph->portals[p].door;
            if (door < 0 || !seen_by_cells(b, has_leaf, door)) continue;
            for (int side = 0; side < 2; side++) {
                int cell = graph->portals[p].cell[side];
                if (pass > 0) viewer->cell_doors[first[cell] + count[cell]] = door;
                count[cell]++;
            }
        }
        for (int c = 0; pass == 0 && c < graph->cell_count; c++) first[c + 1] = first[c] + count[c];
        if (pass == 0) viewer->cell_doors = ARENA_ARRAY(arena, int, first[graph->cell_count] + 1);
        memset(count, 0, (size_t)graph->cell_count * sizeof *count);
    }
    arena_free(&scratch);
}

int viewer_door_words(const Mesh *mesh) { return (mesh->graph->building->opening_count + 63) / 64; }

static void note_door(Viewer *viewer, int opening) {
    viewer->doors[opening / 64] |= (uint64_t)1 << opening % 64;
}

static void note_doors(Viewer *viewer, const VisResult *seen) {
    memset(viewer->doors, 0, (size_t)viewer->door_words * sizeof *viewer->doors);
    for (int i = 0; i < seen->object_count; i++) {
        int door = viewer->door_of[seen->objects[i]];
        if (door >= 0) note_door(viewer, door);
    }
    for (int i = 0; i < seen->cell_count; i++) {
        const int *first = viewer->cell_first + seen->cells[i].cell;
        for (int k = first[0]; k < first[1]; k++) note_door(viewer, viewer->cell_doors[k]);
    }
    viewer->view.doors = viewer->doors;
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
    list_doors(viewer, arena);
    viewer->found = ARENA_ARRAY(arena, ViewCluster, viewer->cluster_count);
    viewer->cluster_keys = ARENA_ARRAY(arena, FaceKey, viewer->cluster_count);
    viewer->spare_cluster_keys = ARENA_ARRAY(arena, FaceKey, viewer->cluster_count);
    viewer->view.clusters = ARENA_ARRAY(arena, ViewCluster, viewer->cluster_count);
    viewer->view.viewer = viewer;
    viewer->look.viewer = viewer;
    return viewer;
}

// ---- a look

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

// False: no part of the face can be seen.
static bool take_face(const Look *look, int index) {
    Viewer *viewer = look->viewer;
    const FaceShape *shape = &viewer->shapes[index];
    if (!may_be_seen(look, shape, vec3_sub(shape->centre, look->eye))) return false;
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
    if (highest <= viewer->on_plane) return false;
    viewer->view.vertex_count += shape->count;
    float key = (float)nearest;
    FaceKey *out = &viewer->keys[viewer->key_count++];
    memcpy(&out->distance, &key, sizeof key);
    out->shape = index;
    out->first = first;
    return true;
}

// The distance of the eye from a box along an axis.
static double beyond(double off, double half) { return fmax(fabs(off) - half, 0); }

static void put_floats(Vec3 v, float out[3]) {
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

// Leaves a cluster closed unless it has few faces, or the eye is in its box. Where nothing of it is above the horizon it is left out.
static void take_cluster(const Look *look, int index) {
    Viewer *viewer = look->viewer;
    const Cluster *cluster = &viewer->clusters[index];
    const Vec3 half = cluster->half, off = vec3_sub(cluster->centre, look->eye), z = look->z;
    if (vec3_dot(z, off) + fabs(z.x) * half.x + fabs(z.y) * half.y + fabs(z.z) * half.z <= 0) return;
    double away = vec3_length(vec3(beyond(off.x, half.x), beyond(off.y, half.y), beyond(off.z, half.z)));
    if (!look->leave || cluster->count < LEAST_IN_CLUSTER || !(away > 0)) {
        for (int i = 0; i < cluster->count; i++) take_face(look, cluster->first + i);
        return;
    }
    float key = (float)away;
    FaceKey *sorted = &viewer->cluster_keys[viewer->view.cluster_count];
    memcpy(&sorted->distance, &key, sizeof key);
    sorted->shape = viewer->view.cluster_count;
    ViewCluster *out = &viewer->found[viewer->view.cluster_count++];
    *out = (ViewCluster){
        .nearest = (float)(1 / away), .cluster = index, .listed = VIEW_ALL << cluster->count & VIEW_ALL};
    put_floats(to_view(look, off), out->centre);
    put_floats(half, out->half);
}

static void take_object(const Look *look, int object) {
    const int *first = look->viewer->object_cluster + object;
    if (look->viewer->hidden[object]) return;
    for (int c = first[0]; c < first[1]; c++) take_cluster(look, c);
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
    const Cluster *clusters = viewer->clusters;
    const int *cluster = viewer->object_cluster;
    if (left > FAR_AHEAD) __builtin_prefetch(&clusters[cluster[objects[FAR_AHEAD]]]);
    if (left > AHEAD) {
        const int *first = cluster + objects[AHEAD];
        if (first[0] == first[1]) return;
        const char *shape = (const char *)&viewer->shapes[clusters[first[0]].first];
        for (int k = 0; k < 2; k++) __builtin_prefetch(shape + 64 * k);
    }
}

static void take_query(const Look *look, int cell, Culling culling) {
    Viewer *viewer = look->viewer;
    Eye eye = {.position = look->eye, .frustum_count = 1, .on_surface = true};
    eye.frustum[0] = (Plane){look->z, vec3_dot(look->z, look->eye)};
    VisResult result = vis_query(viewer->query, &eye, cell, viewer->door_open, culling);
    if (viewer->door_words > 0 && result.cell_count > 0) note_doors(viewer, &result);
    for (int i = 0; i < result.object_count; i++) {
        fetch_ahead(look->viewer, result.objects + i, result.object_count - i);
        take_object(look, result.objects[i]);
    }
}

// Sorts keys by distance, to half a percent, keeping the order of equal keys: a radix sort by the two upper bytes, the lower byte first.
static void sort_keys(FaceKey *keys, FaceKey *spare, int count) {
    enum { BYTES = 2, VALUES = 256, SKIPPED = 16 };
    int place[BYTES][VALUES] = {{0}};
    for (int i = 0; i < count; i++)
        for (int k = 0; k < BYTES; k++) place[k][keys[i].distance >> (8 * k + SKIPPED) & 255]++;
    for (int k = 0; k < BYTES; k++) {
        for (int v = 0, at = 0; v < VALUES; v++) {
            int here = place[k][v];
            place[k][v] = at;
            at += here;
        }
        const FaceKey *from = k == 0 ? keys : spare;
        FaceKey *to = k == 0 ? spare : keys;
        for (int i = 0; i < count; i++) to[place[k][from[i].distance >> (8 * k + SKIPPED) & 255]++] = from[i];
    }
}

// Adds the faces whose keys are there to the view.
static void list_view(const Look *look) {
    Viewer *viewer = look->viewer;
    View *view = &viewer->view;
    for (int i = 0; i < viewer->key_count; i++) {
        const FaceKey *key = &viewer->keys[i];
        const FaceShape *shape = &viewer->shapes[key->shape];
        Vec3 off = vec3_sub(shape->centre, look->eye);
        Four centre = look->turn[0] * off.x + look->turn[1] * off.y + look->turn[2] * off.z;
        view->faces[view->face_count++] =
            (ViewFace){.face = viewer->face_of[key->shape],
                       .first_vertex = key->first,
                       .vertex_count = shape->count,
                       .radius = shape->radius,
                       .centre = {(float)centre[0], (float)centre[1], (float)centre[2]},
                       .n = to_view(look, shape->n),
                       .d = vec3_dot(shape->n, off)};
    }
    viewer->key_count = 0;
}

void view_corners(const View *view, int index, float out[CLUSTER_CORNERS][3][CLUSTER_FACES]) {
    _Static_assert((int)CLUSTER_FACES == (int)LANES, "a lane for each face");
    const ViewCluster *cluster = &view->clusters[index];
    const ClusterCorners *corners = &view->viewer->cluster_corners[cluster->cluster];
    for (int c = 0; c < 3; c++) {
        Vec3 axis = c == 0 ? view->x : c == 1 ? view->y : view->z;
        Lane x = lane_of((float)axis.x), y = lane_of((float)axis.y), z = lane_of((float)axis.z);
        for (int k = 0; k < CLUSTER_CORNERS; k++) {
            const Lane *at = corners->at[k];
            Lane turned = lane_multiply_add(
                x, at[0],
                lane_multiply_add(y, at[1], lane_multiply_add(z, at[2], lane_of(cluster->centre[c]))));
            memcpy(out[k][c], &turned, sizeof turned);
        }
    }
}

unsigned view_list(const View *view, int index, unsigned faces) {
    Viewer *viewer = view->viewer;
    ViewCluster *listed = &viewer->view.clusters[index];
    const Cluster *cluster = &viewer->clusters[listed->cluster];
    faces &= ~listed->listed & ((1u << cluster->count) - 1);
    listed->listed |= faces;
    unsigned seen = 0;
    for (; faces; faces &= faces - 1) {
        int i = __builtin_ctz(faces);
        seen |= (unsigned)take_face(&viewer->look, cluster->first + i) << i;
    }
    list_view(&viewer->look);
    return seen;
}

static const View *look_from(Viewer *viewer, const ViewPoint *from, Culling culling, bool leave) {
    CORE_ASSERT(culling < CULLINGS);
    CORE_ASSERT(from->cell < viewer->mesh->graph->cell_count);
    Look *look = &viewer->look;
    look->eye = from->eye;
    look->z = from->normal;
    look->leave = leave;
    view_axes(look->z, &look->x, &look->y);
    look->turn[0] = (Four){look->x.x, look->y.x, look->z.x, 0};
    look->turn[1] = (Four){look->x.y, look->y.y, look->z.y, 0};
    look->turn[2] = (Four){look->x.z, look->y.z, look->z.z, 0};
    View *view = &viewer->view;
    view->eye = look->eye;
    view->x = look->x;
    view->y = look->y;
    view->z = look->z;
    view->by_depth = culling != CULL_NONE;
    view->doors = NULL;
    view->face_count = view->vertex_count = view->cluster_count = viewer->key_count = 0;
    if (from->cell < 0 || culling == CULL_NONE || culling == CULL_DEPTH) {
        for (int o = 0; o < viewer->mesh->graph->object_count; o++) take_object(look, o);
    } else if (culling == CULL_CELLS) {
        take_cells(look, from->cell);
    } else {
        take_query(look, from->cell, culling);
    }
    sort_keys(viewer->keys, viewer->spare, viewer->key_count);
    list_view(look);
    sort_keys(viewer->cluster_keys, viewer->spare_cluster_keys, view->cluster_count);
    for (int i = 0; i < view->cluster_count; i++)
        view->clusters[i] = viewer->found[viewer->cluster_keys[i].shape];
    return view;
}

const View *viewer_look(Viewer *viewer, const ViewPoint *from, Culling culling) {
    return look_from(viewer, from, culling, false);
}

const View *viewer_look_at_clusters(Viewer *viewer, const ViewPoint *from, Culling culling) {
    return look_from(viewer, from, culling, true);
}
