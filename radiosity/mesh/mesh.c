// mesh.c - makes the mesh of a building: faces whose neighbours share whole edges, cut into elements and patches (Cohen, Greenberg,
// Immel & Brock 1986; T-vertices anchored: Baum, Mann, Smith & Winget 1991).
#include "radiosity/mesh/mesh.h"

#include <string.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "maps/building/building.h"
#include "radiosity/mesh/mesh_parts.h"

// More squares than this are refused: each may be an element, or with splits, which say where elements are small, takes four bytes.
static const double MOST_SQUARES = 2e7, MOST_SQUARES_SPLIT = 2e8;

MeshOptions mesh_default_options(void) {
    return (MeshOptions){.element = 0.33, .per_patch = 2, .close = 0.05, .proxy = PROXY_TOLERANCE};
}

double mesh_fitting_element(const CellGraph *graph) {
    static const double FINEST = 0.15, COARSEST = 0.33, ELEMENTS = 60000;
    double area = 0;
    for (int i = 0; i < graph->polygon_count; i++) {
        const Polygon *p = &graph->polygons[i];
        area += polygon_area(graph->vertices + p->first_vertex, p->vertex_count);
    }
    return fmin(fmax(sqrt(area / ELEMENTS), FINEST), COARSEST);
}

// ---- faces

// Adds the corners of a polygon to the places, without repeated corners; returns how many there are.
static int weld_corners(MeshBuilder *builder, const Vec3 *v, int count, int *corner) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        int place = places_add(&builder->places, v[i]);
        if (kept == 0 || corner[kept - 1] != place) corner[kept++] = place;
    }
    while (kept > 1 && corner[kept - 1] == corner[0]) kept--;
    return kept;
}

// The plane and area of a face. They are computed relative to a corner, so that no digits are lost far from the origin.
static Plane face_plane(const Vec3 *points, const int *corner, int count, Vec3 *local, double *area) {
    for (int i = 0; i < count; i++) local[i] = vec3_sub(points[corner[i]], points[corner[0]]);
    Plane plane = plane_of_polygon(local, count);
    *area = polygon_area(local, count);
    plane.d += vec3_dot(plane.n, points[corner[0]]);
    return plane;
}

typedef struct FaceList {
    int *corner;  // of all faces, indices of places
    int corner_count, corner_capacity, face_capacity;
    double elements;  // an estimate of the number of elements
    int *now;         // corners of the current polygon, indices of places
    Vec3 *local;      // these corners, from the first of them
} FaceList;

// Is a face narrower than the distance at which points are welded? A grid over such a face has no area.
static bool is_hair(const Vec3 *local, int count, double area) {
    double longest = 0;
    for (int i = 0; i < count; i++) longest = fmax(longest, vec3_length(local[i]));
    return area < MESH_WELD * longest;
}

// Adds a face; `polygon` -1: a stand-in.
static void add_face(MeshBuilder *builder, FaceList *list, int object, int polygon, const Polygon *p,
                     const Vec3 *vertices) {
    Mesh *mesh = builder->mesh;
    int *corner = list->now;
    int count = weld_corners(builder, vertices + p->first_vertex, p->vertex_count, corner);
    double area = 0;
    Plane plane = {{0, 0, 0}, 0};
    if (count >= 3) plane = face_plane(builder->places.points, corner, count, list->local, &area);
    if (area < MAPS_SMALLEST_AREA || vec3_dot(plane.n, plane.n) == 0 || is_hair(list->local, count, area)) {
        mesh->dropped_faces++;
        return;
    }
    if (polygon >= 0) mesh->face_of[polygon] = mesh->face_count;
    Face *face = ARENA_APPEND(builder->arena, mesh->faces, mesh->face_count, list->face_capacity);
    *face = (Face){.polygon = polygon,
                   .object = object,
                   .material = p->material,
                   .texture_map = p->texture_map,
                   .plane = plane,
                   .first_vertex = list->corner_count,
                   .vertex_count = count};
    mesh_lay_grid(builder, face, corner, count);
    list->elements += (double)face->nx * face->ny;
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(&builder->scratch, list->corner, list->corner_count, list->corner_capacity) = corner[i];
}

// Does a polygon of the graph become a face (if it is not hidden)?
static bool is_taken(const Mesh *mesh, int polygon) {
    const Proxies *proxies = mesh->options.proxies;
    return !vis_is_glass(mesh->graph, polygon) &&
           (proxies ? proxies->replaced[polygon] : false) == mesh->options.replaced;
}

static bool takes_part(const MeshOptions *options, int object) {
    return !options->part || (options->part->objects[object / 64] >> object % 64 & 1);
}

static void add_stand_ins(MeshBuilder *builder, FaceList *list, int object) {
    const Proxies *proxies = builder->mesh->options.proxies;
    if (!proxies || builder->mesh->options.replaced) return;
    for (int p = proxies->first[object]; p < proxies->first[object + 1]; p++)
        add_face(builder, list, object, -1, &proxies->polygons[p], proxies->vertices);
}

static void add_faces(MeshBuilder *builder, FaceList *list) {
    Mesh *mesh = builder->mesh;
    const CellGraph *graph = mesh->graph;
    mesh->face_of = ARENA_ARRAY(builder->arena, int, graph->polygon_count);
    int most = PROXY_CORNERS;
    for (int i = 0; i < graph->polygon_count; i++) {
        mesh->face_of[i] = -1;
        if (graph->polygons[i].vertex_count > most) most = graph->polygons[i].vertex_count;
    }
    list->now = ARENA_ARRAY(&builder->scratch, int, most);
    list->local = ARENA_ARRAY(&builder->scratch, Vec3, most);
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        if (!takes_part(&mesh->options, o)) continue;
        // A leaf moves by itself: it shares no place with what stands still.
        builder->places.body = 1 + object->leaf;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            if (is_taken(mesh, p)) add_face(builder, list, o, p, &graph->polygons[p], graph->vertices);
        add_stand_ins(builder, list, o);
    }
}

static void *copy(Arena *arena, const void *from, size_t count, size_t size) {
    return memcpy(arena_alloc(arena, count + 1, size), from, count * size);
}

// Once all elements are made: their corners and vertices are copied out of the builder's memory, and no array has room for more.
static void fit(MeshBuilder *b, const FaceList *list) {
    Mesh *mesh = b->mesh;
    if (mesh->options.loose)
        mesh->corners = copy(b->arena, mesh->corners, (size_t)mesh->corner_count, sizeof *mesh->corners);
    else
        mesh_anchor_elements(b);
    mesh->vertex_count = b->places.count;
    mesh->vertices = copy(b->arena, b->places.points, (size_t)b->places.count, sizeof *mesh->vertices);
    mesh->faces =
        arena_fit(b->arena, mesh->faces, sizeof *mesh->faces, mesh->face_count, list->face_capacity);
    mesh->elements =
        arena_fit(b->arena, mesh->elements, sizeof *mesh->elements, mesh->element_count, b->element_capacity);
    mesh->patches =
        arena_fit(b->arena, mesh->patches, sizeof *mesh->patches, mesh->patch_count, b->patch_capacity);
    mesh->shared =
        arena_fit(b->arena, mesh->shared, sizeof *mesh->shared, mesh->shared_count, b->shared_capacity);
}

bool mesh_build(const CellGraph *graph, const float *door_open, const MeshOptions *options, Arena *arena,
                Mesh *out, Error *error) {
    CORE_ASSERT(options->element >= 0.01 && options->element <= 100);
    CORE_ASSERT(options->per_patch >= 1 && options->per_patch <= 16);
    bool stand_ins = options->proxies && !options->replaced;
    *out = (Mesh){.graph = stand_ins ? &options->proxies->graph : graph, .options = *options};
    const char *source = graph->building->source;
    MeshBuilder builder = {.mesh = out, .arena = arena};
    FaceList list = {0};
    places_start(&builder.places, &builder.scratch);
    add_faces(&builder, &list);
    double most = options->splits ? MOST_SQUARES_SPLIT : MOST_SQUARES;
    bool fits = list.elements <= most, few_cuts = true;
    if (fits && out->face_count > 0) {
        mesh_anchor_outlines(&builder, list.corner);
        few_cuts = mesh_find_cuts(&builder) && mesh_cut_faces(&builder);
    }
    if (fits && few_cuts && out->face_count > 0) {
        fit(&builder, &list);
        mesh_find_reflectances(out, arena);
        mesh_free_centres(out);
        mesh_find_moving(out, arena);
        mesh_find_cells(out);
        mesh_pose(out, door_open);
    }
    arena_free(&builder.scratch);
    arena_free(&builder.cut_arena);
    if (!fits)
        return error_set(error, "%s: elements of %g m would be %.0f (limit %.0f): take larger ones", source,
                         options->element, list.elements, most);
    if (!few_cuts)
        return error_set(
            error, "%s: too many wide polygons to cut elements along what stands on them: --close 0 does not",
            source);
    if (out->patch_count == 0 && !options->part)
        return error_set(error, "%s: no polygon with a front to receive light", source);
    return true;
}

// How far inside an element a point of its plane is, metres; below 0: outside.
static double depth_in(const Mesh *mesh, int index, Vec3 point) {
    const Element *element = &mesh->elements[index];
    Arena scratch = {0};
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, element->corner_count);
    for (int i = 0; i < element->corner_count; i++)
        v[i] = mesh->vertices[mesh->corners[element->first_corner + i]];
    double depth = mesh_inside(v, element->corner_count, mesh->faces[element->face].plane.n, point);
    arena_free(&scratch);
    return depth;
}

static bool is_in(const Mesh *mesh, int index, Vec3 point) {
    const Element *element = &mesh->elements[index];
    const int *corner = mesh->corners + element->first_corner;
    Vec3 n = mesh->faces[element->face].plane.n,
         a = vec3_sub(mesh->vertices[corner[element->corner_count - 1]], point);
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 b = vec3_sub(mesh->vertices[corner[i]], point);
        if (vec3_dot(n, vec3_cross(a, b)) < 0) return false;
        a = b;
    }
    return true;
}

static int element_of(const Mesh *mesh, int square, Vec3 point) {
    int code = mesh->squares[square];
    if (code >= -1) return code;
    const int *several = mesh->shared + ~(code + 1);
    for (int i = 1; i <= several[0]; i++)
        if (is_in(mesh, several[i], point)) return several[i];
    // The point is outside all of them by rounding.
    int best = several[1];
    double deepest = -INFINITY;
    for (int i = 1; i <= several[0]; i++) {
        double depth = depth_in(mesh, several[i], point);
        if (depth <= deepest) continue;
        deepest = depth;
        best = several[i];
    }
    return best;
}

int mesh_element_at(const Mesh *mesh, int index, Vec3 point) {
    const Face *face = &mesh->faces[index];
    Vec3 p = vec3_sub(point, face->origin);
    double x = vec3_dot(face->gx, p), y = vec3_dot(face->gy, p);
    int i = x < 0 ? 0 : x >= face->nx ? face->nx - 1 : (int)x;
    int j = y < 0 ? 0 : y >= face->ny ? face->ny - 1 : (int)y;
    int element = element_of(mesh, face->first_square + j * face->nx + i, point);
    if (element >= 0) return element;
    // The point is outside the outline by rounding: take the nearest square that has an element.
    double nearest = INFINITY;
    int best = -1;
    for (int k = 0; k < face->nx * face->ny; k++) {
        double dx = k % face->nx + 0.5 - x, dy = k / face->nx + 0.5 - y;
        if (mesh->squares[face->first_square + k] == -1 || dx * dx + dy * dy >= nearest) continue;
        nearest = dx * dx + dy * dy;
        best = k;
    }
    CORE_ASSERT(best >= 0);
    return element_of(mesh, face->first_square + best, point);
}

Vec3 element_centroid(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    const int *corner = mesh->corners + e->first_corner;
    Vec3 n = mesh->faces[e->face].plane.n, base = mesh->vertices[corner[0]], moment = {0};
    double twice = 0;
    for (int i = 1; i + 1 < e->corner_count; i++) {
        Vec3 a = vec3_sub(mesh->vertices[corner[i]], base), b = vec3_sub(mesh->vertices[corner[i + 1]], base);
        double part = vec3_dot(n, vec3_cross(a, b));
        moment = vec3_add(moment, vec3_scale(vec3_add(a, b), part / 3));
        twice += part;
    }
    return twice > 0 ? vec3_add(base, vec3_scale(moment, 1 / twice)) : base;
}
