// mesh_pose.c - the doors of a mesh in motion: leaves are rigid, so their elements and patches move with them.
#include "radiosity/mesh/mesh_parts.h"

// A face of a leaf or of a plug, and what it is like when the leaf is closed.
typedef struct MovingFace {
    int face;
    int leaf;     // in Building.leaves; -1: a plug
    int opening;  // in Building.openings
    Plane plane;
    Vec3 origin, gx, gy;
} MovingFace;

// A point of a leaf: one of Mesh.vertices, or the centre of one of Mesh.patches.
typedef struct MovingPoint {
    int index, leaf;
    Vec3 closed;
} MovingPoint;

typedef struct MovingPoints {
    MovingPoint *points;
    int count, capacity;
} MovingPoints;

struct MeshMoving {
    MovingFace *faces;
    int face_count, face_capacity;
    MovingPoints vertices, centres;
    Panes panes;  // all that there may be
};

// ---- made once

static void note_point(MovingPoints *to, int index, int leaf, Vec3 closed, Arena *arena) {
    *ARENA_PUSH(arena, to->points, to->count, to->capacity) = (MovingPoint){index, leaf, closed};
}

// Notes the vertices of an outline or of an element, each once.
static void note_vertices(const Mesh *mesh, const int *corner, int count, int leaf, bool *noted,
                          MovingPoints *to, Arena *arena) {
    for (int i = 0; i < count; i++) {
        if (noted[corner[i]]) continue;
        noted[corner[i]] = true;
        note_point(to, corner[i], leaf, mesh->vertices[corner[i]], arena);
    }
}

static void note_leaf(const Mesh *mesh, const Face *face, int leaf, bool *noted, MeshMoving *m,
                      Arena *arena) {
    note_vertices(mesh, mesh->outline + face->first_vertex, face->vertex_count, leaf, noted, &m->vertices,
                  arena);
    for (int e = face->first_element; e < face->first_element + face->element_count; e++)
        note_vertices(mesh, mesh->corners + mesh->elements[e].first_corner, mesh->elements[e].corner_count,
                      leaf, noted, &m->vertices, arena);
    for (int p = face->first_patch; p < face->first_patch + face->patch_count; p++)
        note_point(&m->centres, p, leaf, mesh->patches[p].centre, arena);
}

void mesh_find_moving(Mesh *mesh, Arena *arena) {
    const Building *b = mesh->graph->building;
    Arena scratch = {0};
    MeshMoving *m = ARENA_ARRAY(arena, MeshMoving, 1);
    bool *noted = ARENA_ARRAY(&scratch, bool, mesh->vertex_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        const Object *o = &mesh->graph->objects[face->object];
        if (o->leaf < 0 && !o->plug) continue;
        int opening = o->leaf >= 0 ? b->leaves[o->leaf].opening : o->opening;
        *ARENA_PUSH(arena, m->faces, m->face_count, m->face_capacity) =
            (MovingFace){f, o->leaf, opening, face->plane, face->origin, face->gx, face->gy};
        if (o->leaf >= 0) note_leaf(mesh, face, o->leaf, noted, m, arena);
    }
    m->panes = panes_of(mesh->graph, ARENA_ARRAY(&scratch, float, b->opening_count + 1), arena);
    mesh->panes.panes = ARENA_ARRAY(arena, Pane, m->panes.count + 1);
    mesh->panes.cells = m->panes.cells;
    mesh->moving = m;
    arena_free(&scratch);
}

// ---- in motion

// A direction of the leaf.
static Vec3 turn_with(const Leaf *leaf, double open, Vec3 closed) {
    double angle = open * leaf->turn, c = cos(angle), s = sin(angle);
    if (angle == 0) return closed;
    return vec3(c * closed.x - s * closed.y, s * closed.x + c * closed.y, closed.z);
}

static double open_of(const float *door_open, int opening) {
    return door_open ? (double)door_open[opening] : 0;
}

static void pose_face(Mesh *mesh, const MovingFace *from, const float *door_open) {
    Face *face = &mesh->faces[from->face];
    face->hidden = from->leaf < 0 && !(door_open && door_open[from->opening] == 0);
    if (from->leaf < 0) return;
    const Leaf *leaf = &mesh->graph->building->leaves[from->leaf];
    double open = open_of(door_open, from->opening);
    face->open = open;
    face->origin = leaf_point(leaf, open, from->origin);
    face->plane.n = turn_with(leaf, open, from->plane.n);
    face->gx = turn_with(leaf, open, from->gx);
    face->gy = turn_with(leaf, open, from->gy);
    face->plane.d = open == 0 ? from->plane.d : vec3_dot(face->plane.n, face->origin);
}

static Vec3 posed(const Mesh *mesh, const MovingPoint *point, const float *door_open) {
    const Leaf *leaf = &mesh->graph->building->leaves[point->leaf];
    return leaf_point(leaf, open_of(door_open, leaf->opening), point->closed);
}

void mesh_pose(Mesh *mesh, const float *door_open) {
    const MeshMoving *m = mesh->moving;
    for (int i = 0; i < m->face_count; i++) pose_face(mesh, &m->faces[i], door_open);
    for (int i = 0; i < m->vertices.count; i++)
        mesh->vertices[m->vertices.points[i].index] = posed(mesh, &m->vertices.points[i], door_open);
    for (int i = 0; i < m->centres.count; i++) {
        int p = m->centres.points[i].index;
        mesh->patches[p].centre = posed(mesh, &m->centres.points[i], door_open);
        mesh_find_cell(mesh, p, mesh->patches[p].cell);
    }
    panes_pose(&m->panes, mesh->graph->building, door_open, &mesh->panes);
}

Mesh mesh_copy(const Mesh *mesh, Arena *arena) {
    Mesh out = *mesh;
    out.vertices = ARENA_ARRAY(arena, Vec3, mesh->vertex_count + 1);
    out.faces = ARENA_ARRAY(arena, Face, mesh->face_count + 1);
    out.patches = ARENA_ARRAY(arena, Patch, mesh->patch_count + 1);
    out.panes.panes = ARENA_ARRAY(arena, Pane, mesh->moving->panes.count + 1);
    memcpy(out.vertices, mesh->vertices, (size_t)mesh->vertex_count * sizeof *out.vertices);
    memcpy(out.faces, mesh->faces, (size_t)mesh->face_count * sizeof *out.faces);
    memcpy(out.patches, mesh->patches, (size_t)mesh->patch_count * sizeof *out.patches);
    memcpy(out.panes.panes, mesh->panes.panes, (size_t)mesh->panes.count * sizeof *out.panes.panes);
    return out;
}

// ---- from one state to another

// All of a door that stands in the way of light now.
static Box door_box(const Mesh *mesh, int opening) {
    const MeshMoving *m = mesh->moving;
    Box box = box_empty();
    for (int i = 0; i < m->face_count; i++) {
        const Face *face = &mesh->faces[m->faces[i].face];
        if (m->faces[i].opening != opening || face->hidden) continue;
        for (int k = face->first_vertex; k < face->first_vertex + face->vertex_count; k++)
            box = box_add(box, mesh->vertices[mesh->outline[k]]);
    }
    for (int i = 0; i < mesh->panes.count; i++) {
        Vec3 corner[4];
        if (mesh->panes.panes[i].opening != opening) continue;
        pane_corners(&mesh->panes.panes[i], corner);
        for (int k = 0; k < 4; k++) box = box_add(box, corner[k]);
    }
    return box;
}

MovedDoors mesh_move(Mesh *mesh, const float *from, const float *to, Arena *arena) {
    int count = mesh->graph->building->opening_count;
    MovedDoors out = {ARENA_ARRAY(arena, MovedDoor, count + 1), 0};
    for (int i = 0; i < count; i++)
        if (from[i] != to[i]) out.doors[out.count++] = (MovedDoor){i, {door_box(mesh, i)}};
    mesh_pose(mesh, to);
    for (int i = 0; i < out.count; i++) out.doors[i].box[1] = door_box(mesh, out.doors[i].opening);
    return out;
}

static bool box_rises(Box box, Vec3 point, Vec3 n) {
    if (box_is_empty(box)) return false;
    Vec3 highest = {n.x > 0 ? box.max.x : box.min.x, n.y > 0 ? box.max.y : box.min.y,
                    n.z > 0 ? box.max.z : box.min.z};
    return vec3_dot(n, vec3_sub(highest, point)) > 0;
}

bool mesh_door_rises(const MovedDoor *door, Vec3 point, Vec3 normal) {
    return box_rises(door->box[0], point, normal) || box_rises(door->box[1], point, normal);
}

bool mesh_leaf_moves(const MovedDoors *moved, const Building *building, int leaf) {
    for (int i = 0; i < moved->count && leaf >= 0; i++)
        if (moved->doors[i].opening == building->leaves[leaf].opening) return true;
    return false;
}
