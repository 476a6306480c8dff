// plain_scene.c - meshes of single quads, and views without culling, as viewer_look gives them.
#include "engine/bench/plain_scene.h"

#include "engine/core/error.h"

// Metres: a plane so near holds the eye.
#define PLAIN_ON_PLANE 1e-9

PlainScene *plain_scene_new(Arena *arena) {
    PlainScene *s = ARENA_ARRAY(arena, PlainScene, 1);
    s->mesh = (Mesh){.faces = s->faces,
                     .elements = s->elements,
                     .patches = s->patches,
                     .vertices = s->vertices,
                     .outline = s->outline,
                     .corners = s->outline,
                     .squares = s->squares};
    s->view = (View){.faces = s->view_faces, .vertices = s->seen};
    return s;
}

static int vertex_of(PlainScene *s, Vec3 p) {
    for (int i = 0; i < s->mesh.vertex_count; i++)
        if (vec3_equal(s->vertices[i], p)) return i;
    s->vertices[s->mesh.vertex_count] = p;
    return s->mesh.vertex_count++;
}

void plain_scene_add(PlainScene *s, const Vec3 corner[4]) {
    int i = s->mesh.face_count;
    CORE_ASSERT(i < PLAIN_QUADS);
    for (int k = 0; k < 4; k++) s->outline[4 * i + k] = vertex_of(s, corner[k]);
    double area = polygon_area(corner, 4);
    s->faces[i] = (Face){.polygon = -1,
                         .object = -1,
                         .plane = plane_of_polygon(corner, 4),
                         .first_vertex = 4 * i,
                         .vertex_count = 4,
                         .origin = corner[0],
                         .nx = 1,
                         .ny = 1,
                         .first_square = i,
                         .first_element = i,
                         .element_count = 1,
                         .first_patch = i,
                         .patch_count = 1};
    s->elements[i] = (Element){.face = i, .patch = i, .first_corner = 4 * i, .corner_count = 4, .area = area};
    s->patches[i] = (Patch){.face = i, .first_element = i, .element_count = 1, .cell = -1, .area = area};
    s->squares[i] = i;
    s->mesh.face_count = s->mesh.element_count = s->mesh.patch_count = s->mesh.square_count = i + 1;
    s->mesh.outline_count = s->mesh.corner_count = 4 * i + 4;
}

static Vec3 turned(const View *view, Vec3 v) {
    return vec3(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
}

static double nearest_corner(const View *view, const ViewFace *face) {
    double nearest = INFINITY;
    for (int k = 0; k < 4; k++) nearest = fmin(nearest, vec3_length(view->vertices[face->first_vertex + k]));
    return nearest;
}

static void see(PlainScene *s, int face) {
    View *view = &s->view;
    const Face *from = &s->faces[face];
    Vec3 first = vec3_sub(s->vertices[s->outline[from->first_vertex]], view->eye);
    ViewFace seen = {.face = face,
                     .first_vertex = from->first_vertex,
                     .vertex_count = 4,
                     .n = turned(view, from->plane.n),
                     .d = vec3_dot(from->plane.n, first)};
    double top = 0;
    for (int k = 0; k < 4; k++) {
        Vec3 p = turned(view, vec3_sub(s->vertices[s->outline[seen.first_vertex + k]], view->eye));
        s->seen[seen.first_vertex + k] = p;
        top = fmax(top, p.z);
    }
    if (top <= 0 || fabs(seen.d) < PLAIN_ON_PLANE) return;
    int at = view->face_count++;
    double nearest = nearest_corner(view, &seen);
    for (; at > 0 && nearest_corner(view, &view->faces[at - 1]) > nearest; at--)
        view->faces[at] = view->faces[at - 1];
    view->faces[at] = seen;
}

const View *plain_scene_look(PlainScene *s, Vec3 eye, Vec3 normal) {
    View *view = &s->view;
    view->eye = eye;
    view->z = vec3_normalize(normal);
    view_axes(view->z, &view->x, &view->y);
    view->face_count = 0;
    view->vertex_count = s->mesh.outline_count;
    for (int i = 0; i < s->mesh.face_count; i++) see(s, i);
    return view;
}
