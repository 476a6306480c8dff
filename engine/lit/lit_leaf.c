// lit_leaf.c - the irradiance in front of each side of a leaf as an ambient cube (McTaggart 2004): one value for each of six
// directions, the mean of the irradiances of the surfaces of the room that face that way, the nearest counting most. No shadows: of a
// leaf against a wall the side that nobody sees is too bright.
#include "engine/lit/lit_leaf.h"

#include "visibility/vis.h"

// From here on a leaf counts as moved, metres; on the way there its baked light fades.
static const double MOVED = 0.1;
// The cubes are found so far off the leaf, metres: surfaces count the same from there on.
static const double OFF = 0.3;
enum { SIDES = 2, DIRECTIONS = 6 };

typedef struct AmbientCube {
    double sum[DIRECTIONS][3], weight[DIRECTIONS][3];
} AmbientCube;

// Irradiance of an element by the light at its vertices, W/m^2; -1 in channels that are not reflected.
static void element_irradiance(const LitMesh *lit, const LitLight *light, const Element *element, int vertex,
                               double out[3]) {
    const Material *m = mesh_material(lit->mesh, element->face);
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < element->corner_count; i++) sum += (double)light->vertex[vertex + i][c];
        out[c] = rho[c] > 0 ? sum / element->corner_count / (double)rho[c] : -1;
    }
}

static void add_polygon(const LitMesh *lit, const LitLight *light, int polygon, Vec3 place,
                        AmbientCube *cube) {
    const Mesh *mesh = lit->mesh;
    int f = mesh->face_of[polygon];
    if (f < 0 || mesh_is_lamp(mesh, f)) return;
    const Face *face = &mesh->faces[f];
    const double n[3] = {face->plane.n.x, face->plane.n.y, face->plane.n.z};
    int vertex = lit->first_vertex[polygon];
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        const float *spot = lit->spot[e];
        Vec3 way = vec3_sub(vec3((double)spot[0], (double)spot[1], (double)spot[2]), place);
        double near = (double)spot[3] / (vec3_dot(way, way) + OFF * OFF), irradiance[3];
        element_irradiance(lit, light, &mesh->elements[e], vertex, irradiance);
        vertex += mesh->elements[e].corner_count;
        for (int d = 0; d < DIRECTIONS; d++) {
            double along = d % 2 == 0 ? n[d / 2] : -n[d / 2];
            for (int c = 0; c < 3 && along > 0; c++) {
                if (irradiance[c] < 0) continue;
                cube->sum[d][c] += along * along * near * irradiance[c];
                cube->weight[d][c] += along * along * near;
            }
        }
    }
}

static void add_surfaces(const LitMesh *lit, const LitLight *light, int cell, Vec3 place, AmbientCube *cube) {
    const CellGraph *graph = lit->mesh->graph;
    for (int o = graph->surface_first[cell]; o < graph->surface_first[cell + 1]; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            add_polygon(lit, light, p, place, cube);
    }
}

// The surfaces of the place's room; in a doorway, of the rooms that no door parts from it. False inside a wall.
static bool find_cube(const LitMesh *lit, const LitLight *light, Vec3 point, AmbientCube *out) {
    const CellGraph *graph = lit->mesh->graph;
    const Building *b = graph->building;
    int cell = vis_locate(graph, point, -1);
    *out = (AmbientCube){0};
    if (cell < 0) return false;
    Vec3 place = vec3_sub(point, lit->origin);
    int region = graph->cells[cell].region;
    for (int c = 0; c < graph->cell_count; c++)
        if (c == cell || (region >= 0 && graph->cells[c].region == region))
            add_surfaces(lit, light, c, place, out);
    if (region >= 0 && b->regions[region].kind != REGION_OPENING) return true;
    for (int w = graph->cells[cell].first_way;
         w < graph->cells[cell].first_way + graph->cells[cell].way_count; w++)
        if (graph->portals[graph->ways[w].portal].door < 0)
            add_surfaces(lit, light, graph->ways[w].cell, place, out);
    return true;
}

// Irradiance on a surface that looks along n.
static void cube_at(const AmbientCube *cube, Vec3 normal, double out[3]) {
    const double n[3] = {normal.x, normal.y, normal.z};
    for (int c = 0; c < 3; c++) {
        double sum = 0, weights = 0;
        for (int k = 0; k < 3; k++) {
            int d = 2 * k + (n[k] < 0);
            if (!(cube->weight[d][c] > 0)) continue;
            sum += n[k] * n[k] * cube->sum[d][c] / cube->weight[d][c];
            weights += n[k] * n[k];
        }
        out[c] = weights > 0 ? sum / weights : 0;
    }
}

// How far the leaf is from where it was lit, metres: the farthest corner.
static double moved_by(const CellGraph *graph, const Object *o, const Leaf *leaf, double lit, double open) {
    double most = 0;
    if (lit == open) return 0;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        for (int v = polygon->first_vertex; v < polygon->first_vertex + polygon->vertex_count; v++)
            most = fmax(most, vec3_length(vec3_sub(leaf_point(leaf, open, graph->vertices[v]),
                                                   leaf_point(leaf, lit, graph->vertices[v]))));
    }
    return most;
}

static Vec3 polygon_normal(const CellGraph *graph, int polygon, const Leaf *leaf, double open) {
    const Vec3 *v = graph->vertices + graph->polygons[polygon].first_vertex;
    Vec3 a = leaf_point(leaf, open, v[0]), b = leaf_point(leaf, open, v[1]), c = leaf_point(leaf, open, v[2]);
    return vec3_normalize(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
}

// The cubes so far off a place on both sides. Where one side is in a wall the other stands in; false where both are.
static bool find_sides(const LitMesh *lit, const LitLight *light, Vec3 place, Vec3 across, double off,
                       AmbientCube cube[SIDES]) {
    bool there[SIDES];
    for (int s = 0; s < SIDES; s++)
        there[s] = find_cube(lit, light, vec3_add(place, vec3_scale(across, s == 0 ? off : -off)), &cube[s]);
    for (int s = 0; s < SIDES; s++)
        if (!there[s] && there[1 - s]) cube[s] = cube[1 - s];
    return there[0] || there[1];
}

// Those in front of the middle of a leaf's box.
static bool find_leaf_sides(const LitMesh *lit, const LitLight *light, const Leaf *leaf, double open,
                            Vec3 *across, AmbientCube cube[SIDES]) {
    double z = (leaf->z0 + leaf->z1) / 2;
    Vec3 from = leaf_point(leaf, open, vec3(leaf->axis[0].x, leaf->axis[0].y, z));
    Vec3 to = leaf_point(leaf, open, vec3(leaf->axis[1].x, leaf->axis[1].y, z));
    Vec3 along = vec3_normalize(vec3_sub(to, from));
    *across = vec3(-along.y, along.x, 0);
    return find_sides(lit, light, vec3_lerp(from, to, 0.5), *across, leaf->thickness / 2 + OFF, cube);
}

bool lit_leaf_light(const LitMesh *lit, const LitLight *light, int object, double open, float (*out)[3]) {
    const Mesh *mesh = lit->mesh;
    const CellGraph *graph = mesh->graph;
    const Object *o = &graph->objects[object];
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    int first = lit->first_vertex[o->first_polygon],
        end = lit->first_vertex[o->first_polygon + o->polygon_count];
    memcpy(out, light->vertex + first, (size_t)(end - first) * sizeof *out);
    double share = fmin(moved_by(graph, o, leaf, (double)light->doors[leaf->opening], open) / MOVED, 1);
    AmbientCube cube[SIDES];
    Vec3 across;
    if (!(share > 1e-6) || !find_leaf_sides(lit, light, leaf, open, &across, cube)) return share > 1e-6;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        if (mesh->face_of[p] < 0) continue;
        const Material *m = mesh_material(mesh, mesh->face_of[p]);
        const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
        Vec3 n = polygon_normal(graph, p, leaf, open);
        double irradiance[SIDES][3], front = 0.5 + 0.5 * vec3_dot(n, across), emitted[3];
        for (int s = 0; s < SIDES; s++) cube_at(&cube[s], n, irradiance[s]);
        rgb_doubles(m->emission, emitted);
        for (int c = 0; c < 3; c++) {
            double arrives = front * irradiance[0][c] + (1 - front) * irradiance[1][c];
            double moved = emitted[c] + (double)rho[c] * arrives;
            for (int v = lit->first_vertex[p]; v < lit->first_vertex[p + 1]; v++)
                out[v - first][c] = (float)((1 - share) * (double)out[v - first][c] + share * moved);
        }
    }
    return true;
}

void lit_plug_light(const LitMesh *lit, const LitLight *light, int object, float (*out)[3]) {
    const Mesh *mesh = lit->mesh;
    const CellGraph *graph = mesh->graph;
    const Object *o = &graph->objects[object];
    int first = lit->first_vertex[o->first_polygon],
        end = lit->first_vertex[o->first_polygon + o->polygon_count];
    memcpy(out, light->vertex + first, (size_t)(end - first) * sizeof *out);
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        Box box = box_empty();
        AmbientCube cube[SIDES];
        if (mesh->face_of[p] < 0) continue;
        Vec3 n = mesh->faces[mesh->face_of[p]].plane.n;
        for (int v = 0; v < polygon->vertex_count; v++)
            box = box_add(box, graph->vertices[polygon->first_vertex + v]);
        if (!find_sides(lit, light, vec3_lerp(box.min, box.max, 0.5), n, OFF, cube)) continue;
        const Material *m = mesh_material(mesh, mesh->face_of[p]);
        const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
        double irradiance[SIDES][3], emitted[3];
        for (int s = 0; s < SIDES; s++) cube_at(&cube[s], s == 0 ? n : vec3_scale(n, -1), irradiance[s]);
        rgb_doubles(m->emission, emitted);
        for (int v = lit->first_vertex[p]; v < lit->first_vertex[p + 1]; v++)
            for (int c = 0; c < 3; c++)
                out[v - first][c] =
                    (float)(emitted[c] + (double)rho[c] * (irradiance[0][c] + irradiance[1][c]) / 2);
    }
}
