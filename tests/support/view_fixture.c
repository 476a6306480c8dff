// view_fixture.c - faces made by hand, the view of a point, and a ray caster that shares nothing with any method.
#include "tests/support/view_fixture.h"

#include <criterion/criterion.h>
#include <stdlib.h>

// Metres: as the viewer's, a plane so near holds the eye.
#define FIXTURE_ON_PLANE 1e-9

ViewFixture *view_fixture_new(Arena *arena) {
    ViewFixture *f = ARENA_ARRAY(arena, ViewFixture, 1);
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    Building *building = ARENA_ARRAY(arena, Building, 1);
    building->materials = ARENA_ARRAY(arena, Material, 1);
    building->materials[0] = (Material){.name = "grey", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1};
    building->material_count = 1;
    graph->building = building;
    f->mesh.graph = graph;
    f->mesh.options = (MeshOptions){.element = 0.33, .per_patch = 2};
    return f;
}

static int vertex_of(Arena *arena, ViewFixture *f, Vec3 p) {
    for (int i = 0; i < f->mesh.vertex_count; i++)
        if (vec3_equal(f->mesh.vertices[i], p)) return i;
    *ARENA_PUSH(arena, f->mesh.vertices, f->mesh.vertex_count, f->vertex_capacity) = p;
    return f->mesh.vertex_count - 1;
}

static Vec3 middle_of(const Vec3 *v, int count) {
    Vec3 sum = {0};
    for (int i = 0; i < count; i++) sum = vec3_add(sum, vec3_scale(v[i], 1.0 / count));
    return sum;
}

static void add_element(Arena *arena, ViewFixture *f, const Vec3 *v, int count) {
    Mesh *m = &f->mesh;
    int first = m->corner_count;
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(arena, m->corners, m->corner_count, f->corner_capacity) = vertex_of(arena, f, v[i]);
    *ARENA_PUSH(arena, m->squares, m->square_count, f->square_capacity) = m->element_count;
    *ARENA_PUSH(arena, m->elements, m->element_count, f->element_capacity) =
        (Element){.face = m->face_count - 1,
                  .patch = m->patch_count - 1,
                  .first_corner = first,
                  .corner_count = count,
                  .area = polygon_area(v, count)};
}

// The face, its patch, and a grid from v[0] along `side` and `up`, nx x ny squares; no elements yet.
static Face *add_face(Arena *arena, ViewFixture *f, const Vec3 *v, int count, Vec3 side, Vec3 up, int nx,
                      int ny) {
    Mesh *m = &f->mesh;
    Plane plane = plane_of_polygon(v, count);
    double det = vec3_dot(plane.n, vec3_cross(side, up));
    *ARENA_PUSH(arena, m->faces, m->face_count, f->face_capacity) =
        (Face){.polygon = -1,
               .object = -1,
               .plane = plane,
               .first_vertex = m->outline_count,
               .vertex_count = count,
               .origin = v[0],
               .gx = vec3_scale(vec3_cross(up, plane.n), nx / det),
               .gy = vec3_scale(vec3_cross(plane.n, side), ny / det),
               .nx = nx,
               .ny = ny,
               .first_square = m->square_count,
               .first_element = m->element_count,
               .element_count = nx * ny,
               .first_patch = m->patch_count,
               .patch_count = 1};
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(arena, m->outline, m->outline_count, f->outline_capacity) = vertex_of(arena, f, v[i]);
    *ARENA_PUSH(arena, m->patches, m->patch_count, f->patch_capacity) =
        (Patch){.face = m->face_count - 1,
                .first_element = m->element_count,
                .element_count = nx * ny,
                .cell = -1,
                .area = polygon_area(v, count),
                .centre = middle_of(v, count)};
    return &m->faces[m->face_count - 1];
}

int view_fixture_face(Arena *arena, ViewFixture *f, const Vec3 *v, int count) {
    Plane plane = plane_of_polygon(v, count);
    Vec3 side = vec3_sub(v[1], v[0]), up = vec3_cross(plane.n, side);
    add_face(arena, f, v, count, side, up, 1, 1);
    add_element(arena, f, v, count);
    return f->mesh.face_count - 1;
}

int view_fixture_quad(Arena *arena, ViewFixture *f, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int nx, int ny) {
    Vec3 side = vec3_sub(q, p), up = vec3_sub(s, p);
    add_face(arena, f, (Vec3[]){p, q, r, s}, 4, side, up, nx, ny);
    for (int j = 0; j < ny; j++) {
        for (int i = 0; i < nx; i++) {
            Vec3 v[4];
            for (int k = 0; k < 4; k++)
                v[k] = vec3_add(p, vec3_add(vec3_scale(side, (double)(i + (k == 1 || k == 2)) / nx),
                                            vec3_scale(up, (double)(j + (k >= 2)) / ny)));
            add_element(arena, f, v, 4);
        }
    }
    return f->mesh.face_count - 1;
}

static Vec3 random_axis(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), r = sqrt(1 - z * z);
    return vec3(r * cos(a), r * sin(a), z);
}

ViewPose view_fixture_pose(Random *random, Vec3 shift) {
    ViewPose pose = {.z = random_axis(random), .shift = shift};
    pose.x = vec3_normalize(vec3_cross(random_axis(random), pose.z));
    pose.y = vec3_cross(pose.z, pose.x);
    return pose;
}

Vec3 view_fixture_place(const ViewPose *pose, Vec3 p) {
    if (!pose) return p;
    Vec3 turned =
        vec3_add(vec3_add(vec3_scale(pose->x, p.x), vec3_scale(pose->y, p.y)), vec3_scale(pose->z, p.z));
    return vec3_add(turned, pose->shift);
}

void view_fixture_box(Arena *arena, ViewFixture *f, Vec3 low, Vec3 high, int cuts, bool inwards,
                      const ViewPose *pose) {
    const double at[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
    for (int side = 0; side < 6 * cuts * cuts; side++) {
        int axis = side % 3, end = side / 3 % 2, i = side / 6 % cuts, j = side / 6 / cuts;
        Vec3 v[4];
        for (int k = 0; k < 4; k++) {
            int a = (axis + 1) % 3, b = (axis + 2) % 3, u = i + (k == 1 || k == 2), w = j + (k >= 2);
            double p[3];
            p[axis] = at[end][axis];
            p[a] = u == cuts ? at[1][a] : at[0][a] + (at[1][a] - at[0][a]) * u / cuts;
            p[b] = w == cuts ? at[1][b] : at[0][b] + (at[1][b] - at[0][b]) * w / cuts;
            v[k] = view_fixture_place(pose, vec3(p[0], p[1], p[2]));
        }
        bool turn = (end == 1) == inwards;  // (0, 1, 2, 3) looks along +axis
        view_fixture_quad(arena, f, v[0], v[turn ? 3 : 1], v[2], v[turn ? 1 : 3], 1, 1);
    }
}

ViewFixture *view_fixture_room(Arena *arena, Random *random, int cuts, int boxes, Vec3 shift) {
    ViewFixture *f = view_fixture_new(arena);
    ViewPose pose = view_fixture_pose(random, shift);
    view_fixture_box(arena, f, vec3(0, 0, 0), vec3(4, 3, 2.5), cuts, true, &pose);
    for (int i = 0; i < boxes; i++) {
        Vec3 low = vec3(random_between(random, 0.1, 3), random_between(random, 0.1, 2),
                        random_between(random, 0.1, 1.5));
        Vec3 high = vec3_add(low, vec3(random_between(random, 0.05, 0.9), random_between(random, 0.05, 0.9),
                                       random_between(random, 0.05, 0.9)));
        view_fixture_box(arena, f, low, high, 1, false, &pose);
    }
    return f;
}

static int by_distance(const void *a, const void *b) {
    const double *x = a, *y = b;
    return x[0] != y[0] ? (x[0] < y[0] ? -1 : 1) : x[1] < y[1] ? -1 : x[1] > y[1];
}

static Vec3 in_axes(const View *view, Vec3 p) {
    Vec3 q = vec3_sub(p, view->eye);
    return vec3(vec3_dot(view->x, q), vec3_dot(view->y, q), vec3_dot(view->z, q));
}

static void add_view_face(const Mesh *mesh, int face, View *view) {
    const Face *from = &mesh->faces[face];
    Vec3 n = from->plane.n;
    view->faces[view->face_count++] =
        (ViewFace){.face = face,
                   .first_vertex = view->vertex_count,
                   .vertex_count = from->vertex_count,
                   .n = vec3(vec3_dot(view->x, n), vec3_dot(view->y, n), vec3_dot(view->z, n)),
                   .d = vec3_dot(n, vec3_sub(mesh->vertices[mesh->outline[from->first_vertex]], view->eye))};
    for (int i = 0; i < from->vertex_count; i++)
        view->vertices[view->vertex_count++] =
            in_axes(view, mesh->vertices[mesh->outline[from->first_vertex + i]]);
}

View *view_fixture_look(Arena *arena, const ViewFixture *f, Vec3 eye, Vec3 normal) {
    const Mesh *mesh = &f->mesh;
    View *view = ARENA_ARRAY(arena, View, 1);
    view->eye = eye;
    view->z = vec3_normalize(normal);
    Vec3 other = fabs(view->z.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    view->x = vec3_normalize(vec3_cross(other, view->z));
    view->y = vec3_cross(view->z, view->x);
    view->faces = ARENA_ARRAY(arena, ViewFace, mesh->face_count + 1);
    view->vertices = ARENA_ARRAY(arena, Vec3, mesh->outline_count + 1);
    double(*key)[2] = arena_alloc(arena, (size_t)mesh->face_count + 1, sizeof *key);
    int count = 0;
    for (int i = 0; i < mesh->face_count; i++) {
        const Face *face = &mesh->faces[i];
        double nearest = INFINITY, top = -INFINITY;
        for (int k = 0; k < face->vertex_count; k++) {
            Vec3 p = in_axes(view, mesh->vertices[mesh->outline[face->first_vertex + k]]);
            nearest = fmin(nearest, vec3_length(p));
            top = fmax(top, p.z);
        }
        double away =
            vec3_dot(face->plane.n, vec3_sub(mesh->vertices[mesh->outline[face->first_vertex]], view->eye));
        if (top <= 0 || fabs(away) < FIXTURE_ON_PLANE) continue;
        key[count][0] = nearest;
        key[count++][1] = i;
    }
    qsort(key, (size_t)count, sizeof *key, by_distance);
    for (int i = 0; i < count; i++) add_view_face(mesh, (int)key[i][1], view);
    return view;
}

View *view_fixture_look_about(Arena *arena, const ViewFixture *f, Random *random) {
    const Face *face = &f->mesh.faces[random_index(random, f->mesh.face_count)];
    Vec3 sum = {0};
    double total = 0;
    for (int i = 0; i < face->vertex_count; i++) {
        double weight = random_between(random, 0.05, 1);
        sum = vec3_add(sum, vec3_scale(f->mesh.vertices[f->mesh.outline[face->first_vertex + i]], weight));
        total += weight;
    }
    return view_fixture_look(arena, f, vec3_scale(sum, 1 / total), face->plane.n);
}

// Does the ray meet the face: 1 yes, 0 no, -1: too near an edge to tell.
static int meets(const View *view, const ViewFace *face, Vec3 w, double doubt, double *distance) {
    double slope = vec3_dot(face->n, w);
    *distance = slope != 0 ? face->d / slope : INFINITY;
    if (!(*distance > 0) || isinf(*distance)) return 0;
    double least = INFINITY;
    const Vec3 *v = view->vertices + face->first_vertex;
    double turn = face->d < 0 ? -1 : 1;  // seen from behind, the vertices go counter-clockwise
    for (int i = 0; i < face->vertex_count; i++) {
        Vec3 edge = vec3_normalize(vec3_cross(v[i], v[(i + 1) % face->vertex_count]));
        least = fmin(least, turn * vec3_dot(edge, w));
    }
    return least > doubt ? 1 : least < -doubt ? 0 : -1;
}

int view_fixture_cast(const View *view, Vec3 w, double doubt) {
    int best = -1;
    double nearest = INFINITY, unsure = INFINITY, second = INFINITY;
    for (int i = 0; i < view->face_count; i++) {
        double distance;
        int met = meets(view, &view->faces[i], w, doubt, &distance);
        if (met < 0) unsure = fmin(unsure, distance);
        if (met <= 0) continue;
        bool wins =
            distance < nearest || (distance == nearest && view->faces[i].face < view->faces[best].face);
        second = wins ? nearest : fmin(second, distance);
        if (wins) nearest = distance, best = i;
    }
    bool tie = second != nearest && second - nearest < doubt * nearest;
    return (unsure < INFINITY && unsure <= nearest * (1 + doubt)) || tie ? -2 : best;
}
