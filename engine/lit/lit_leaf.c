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

// Irradiance of a triangle by the light at its vertices, W/m^2; -1 in channels that are not reflected.
static void triangle_irradiance(const LitLight *light, const Material *m, const unsigned *triangle,
                                double out[3]) {
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < 3; i++) sum += (double)light->vertex[triangle[i]][c];
        out[c] = rho[c] > 0 ? sum / 3 / (double)rho[c] : -1;
    }
}

static Vec3 vertex_at(const LitMesh *lit, unsigned vertex) {
    const float *p = lit->vertex[vertex].position;
    return vec3((double)p[0], (double)p[1], (double)p[2]);
}

static void add_polygon(const LitMesh *lit, const LitLight *light, int polygon, Vec3 place,
                        AmbientCube *cube) {
    const LitFace *face = lit_face_of(lit, polygon);
    if (!face || face->lamp) return;
    const double n[3] = {face->plane.n.x, face->plane.n.y, face->plane.n.z};
    for (int i = face->first_index; i < face[1].first_index; i += 3) {
        const unsigned *triangle = lit->index + i;
        Vec3 a = vertex_at(lit, triangle[0]), b = vertex_at(lit, triangle[1]),
             c = vertex_at(lit, triangle[2]);
        double area = vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a))) / 2;
        Vec3 way = vec3_sub(vec3_scale(vec3_add(vec3_add(a, b), c), 1.0 / 3), place);
        double near = area / (vec3_dot(way, way) + OFF * OFF), irradiance[3];
        triangle_irradiance(light, &lit->graph->building->materials[face->material], triangle, irradiance);
        for (int d = 0; d < DIRECTIONS; d++) {
            double along = d % 2 == 0 ? n[d / 2] : -n[d / 2];
            for (int k = 0; k < 3 && along > 0; k++) {
                if (irradiance[k] < 0) continue;
                cube->sum[d][k] += along * along * near * irradiance[k];
                cube->weight[d][k] += along * along * near;
            }
        }
    }
}

static void add_surfaces(const LitMesh *lit, const LitLight *light, int cell, Vec3 place, AmbientCube *cube) {
    const CellGraph *graph = lit->graph;
    for (int o = graph->surface_first[cell]; o < graph->surface_first[cell + 1]; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            add_polygon(lit, light, p, place, cube);
    }
}

// The surfaces of the place's room; in a doorway, of the rooms that no door parts from it. False inside a wall.
static bool find_cube(const LitMesh *lit, const LitLight *light, Vec3 point, AmbientCube *out) {
    const CellGraph *graph = lit->graph;
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
    const CellGraph *graph = lit->graph;
    const Object *o = &graph->objects[object];
    const LitFace *begin = lit_object_begin(lit, o), *end = lit_object_end(lit, o);
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    int first = begin->first_vertex;
    memcpy(out, light->vertex + first, (size_t)(end->first_vertex - first) * sizeof *out);
    double share = fmin(moved_by(graph, o, leaf, (double)light->doors[leaf->opening], open) / MOVED, 1);
    AmbientCube cube[SIDES];
    Vec3 across;
    if (!(share > 1e-6) || !find_leaf_sides(lit, light, leaf, open, &across, cube)) return share > 1e-6;
    for (const LitFace *face = begin; face < end; face++) {
        const Material *m = &graph->building->materials[face->material];
        const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
        Vec3 n = polygon_normal(graph, face->polygon, leaf, open);
        double irradiance[SIDES][3], front = 0.5 + 0.5 * vec3_dot(n, across), emitted[3];
        for (int s = 0; s < SIDES; s++) cube_at(&cube[s], n, irradiance[s]);
        rgb_doubles(m->emission, emitted);
        for (int c = 0; c < 3; c++) {
            double arrives = front * irradiance[0][c] + (1 - front) * irradiance[1][c];
            double moved = emitted[c] + (double)rho[c] * arrives;
            for (int v = face->first_vertex; v < face[1].first_vertex; v++)
                out[v - first][c] = (float)((1 - share) * (double)out[v - first][c] + share * moved);
        }
    }
    return true;
}

void lit_plug_light(const LitMesh *lit, const LitLight *light, int object, float (*out)[3]) {
    const CellGraph *graph = lit->graph;
    const Object *o = &graph->objects[object];
    const LitFace *begin = lit_object_begin(lit, o), *end = lit_object_end(lit, o);
    int first = begin->first_vertex;
    memcpy(out, light->vertex + first, (size_t)(end->first_vertex - first) * sizeof *out);
    for (const LitFace *face = begin; face < end; face++) {
        const Polygon *polygon = &graph->polygons[face->polygon];
        Box box = box_empty();
        AmbientCube cube[SIDES];
        Vec3 n = face->plane.n;
        for (int v = 0; v < polygon->vertex_count; v++)
            box = box_add(box, graph->vertices[polygon->first_vertex + v]);
        if (!find_sides(lit, light, vec3_lerp(box.min, box.max, 0.5), n, OFF, cube)) continue;
        const Material *m = &graph->building->materials[face->material];
        const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
        double irradiance[SIDES][3], emitted[3];
        for (int s = 0; s < SIDES; s++) cube_at(&cube[s], s == 0 ? n : vec3_scale(n, -1), irradiance[s]);
        rgb_doubles(m->emission, emitted);
        for (int v = face->first_vertex; v < face[1].first_vertex; v++)
            for (int c = 0; c < 3; c++)
                out[v - first][c] =
                    (float)(emitted[c] + (double)rho[c] * (irradiance[0][c] + irradiance[1][c]) / 2);
    }
}
