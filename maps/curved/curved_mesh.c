// curved_mesh.c - polygons added to the mesh of a curved shape.
#include "engine/core/polygon.h"
#include "maps/curved/curved_tessellate.h"

// A quad bent by less is one polygon, metres: flat ones are bent so much by rounding in a building.
static const double FLAT = 1e-9;

void curved_mesh_add(CurvedMesh *mesh, Arena *arena, const Vec3 *vertices, int count, bool flip) {
    Vec3 kept[CURVED_MOST_CORNERS];
    int n = 0, used = mesh->first ? mesh->first[mesh->polygon_count] : 0;
    CORE_ASSERT(count <= CURVED_MOST_CORNERS);
    for (int i = 0; i < count; i++) {
        Vec3 v = vertices[flip ? count - 1 - i : i];
        if (n == 0 || !vec3_equal(kept[n - 1], v)) kept[n++] = v;
    }
    while (n > 1 && vec3_equal(kept[n - 1], kept[0])) n--;
    if (n < 3) return;
    int ends = mesh->polygon_count + 1;
    if (!mesh->first) {
        int none = 0;
        *ARENA_PUSH(arena, mesh->first, none, mesh->first_capacity) = 0;
    }
    for (int i = 0; i < n; i++) *ARENA_PUSH(arena, mesh->vertices, used, mesh->vertex_capacity) = kept[i];
    *ARENA_PUSH(arena, mesh->first, ends, mesh->first_capacity) = used;
    mesh->polygon_count++;
}

void curved_mesh_add_quad(CurvedMesh *mesh, Arena *arena, const Vec3 q[4]) {
    Plane plane = plane_of_polygon(q, 4);
    if (polygon_bend(q, 4, plane) <= FLAT && polygon_is_convex(q, 4, plane.n)) {
        curved_mesh_add(mesh, arena, q, 4, false);
        return;
    }
    int k = vec3_length(vec3_sub(q[2], q[0])) <= vec3_length(vec3_sub(q[3], q[1])) ? 0 : 1;
    curved_mesh_add(mesh, arena, (Vec3[]){q[k], q[k + 1], q[k + 2]}, 3, false);
    curved_mesh_add(mesh, arena, (Vec3[]){q[k], q[k + 2], q[(k + 3) % 4]}, 3, false);
}
