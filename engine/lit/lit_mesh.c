// lit_mesh.c - elements become triangles with every vertex of their neighbours, so that no crack shows between them.
#include "engine/lit/lit_mesh.h"

#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/scene/light_level.h"
#include "radiosity/show/reconstruct.h"

// Where two faces lie in one place, the face that light does not reach is drawn this far behind, metres: more than depths are uncertain
// by at ten metres, less than is seen at the face's border.
static const double SET_BACK = 5e-4;
// The scales of false colours end below the brightest places, right above lamps: this share of the area is brighter than their end.
static const double BRIGHTEST_AREA = 0.002;

Vec3 lit_origin(const CellGraph *graph) {
    Vec3 middle = vec3_lerp(graph->box.min, graph->box.max, 0.5);
    return vec3(round(middle.x), round(middle.y), round(middle.z));
}

// ---- faces in one place

// Planes nearer to each other than this are one plane, metres: about the tolerance of ties in the rows of form factors, which also
// depends on the planes' coefficients.
static const double SAME_PLACE = 1e-6;
// Normals that lean by less than this are one direction, 1 - cosine.
static const double SAME_WAY = 1e-10;
// Faces that overlap by less than this, metres, are neighbours.
static const double OVERLAP = 1e-3;

typedef struct Key {
    double distance;
    int face;
} Key;

static int by_distance(const void *a, const void *b) {
    const Key *p = a, *q = b;
    return p->distance != q->distance ? (p->distance < q->distance ? -1 : 1) : p->face - q->face;
}

static Box face_box(const Mesh *mesh, const Face *face) {
    Box box = box_empty();
    for (int i = 0; i < face->vertex_count; i++)
        box = box_add(box, mesh->vertices[mesh->outline[face->first_vertex + i]]);
    return box;
}

static bool overlap(const Mesh *mesh, const Face *f, const Face *g) {
    Arena scratch = {0};
    int room = f->vertex_count + g->vertex_count + 1, count = g->vertex_count;
    Vec3 *in = ARENA_ARRAY(&scratch, Vec3, room), *out = ARENA_ARRAY(&scratch, Vec3, room);
    for (int i = 0; i < count; i++) in[i] = mesh->vertices[mesh->outline[g->first_vertex + i]];
    for (int i = 0; i < f->vertex_count && count > 0; i++) {
        Vec3 a = mesh->vertices[mesh->outline[f->first_vertex + i]];
        Vec3 b = mesh->vertices[mesh->outline[f->first_vertex + (i + 1) % f->vertex_count]];
        Vec3 inwards = vec3_normalize(vec3_cross(f->plane.n, vec3_sub(b, a)));
        count = polygon_clip(in, count, (Plane){inwards, vec3_dot(inwards, a)}, -OVERLAP, out);
        Vec3 *swap = in;
        in = out;
        out = swap;
    }
    arena_free(&scratch);
    return count > 0;
}

bool *lit_twins(const Mesh *mesh, Arena *arena) {
    Arena scratch = {0};
    bool *twin = ARENA_ARRAY(arena, bool, mesh->face_count + 1);
    Key *keys = ARENA_ARRAY(&scratch, Key, mesh->face_count + 1);
    Box *boxes = ARENA_ARRAY(&scratch, Box, mesh->face_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        keys[f] = (Key){mesh->faces[f].plane.d, f};
        boxes[f] = face_box(mesh, &mesh->faces[f]);
    }
    qsort(keys, (size_t)mesh->face_count, sizeof *keys, by_distance);
    for (int i = 0; i < mesh->face_count; i++) {
        for (int k = i + 1; k < mesh->face_count && keys[k].distance < keys[i].distance + SAME_PLACE; k++) {
            int f = keys[i].face < keys[k].face ? keys[i].face : keys[k].face,
                g = f == keys[i].face ? keys[k].face : keys[i].face;
            const Face *low = &mesh->faces[f], *high = &mesh->faces[g];
            if (twin[g] || vec3_dot(low->plane.n, high->plane.n) < 1 - SAME_WAY) continue;
            twin[g] = box_overlap(boxes[f], boxes[g]) && overlap(mesh, low, high);
        }
    }
    arena_free(&scratch);
    return twin;
}

// ---- triangles

static bool material_emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

// All but their vertices.
static void faces_of_polygons(const Mesh *mesh, LitMesh *lit, Arena *arena) {
    const CellGraph *graph = mesh->graph;
    lit->faces = ARENA_ARRAY(arena, LitFace, mesh->face_count + 1);
    lit->first_face = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    lit->lamp = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    for (int p = 0; p < graph->polygon_count; p++) {
        int f = mesh->face_of[p];
        lit->first_face[p] = lit->face_count;
        if (f < 0) continue;
        const Face *face = &mesh->faces[f];
        if (mesh_is_lamp(mesh, f)) lit->lamp[lit->lamp_count++] = lit->face_count;
        lit->faces[lit->face_count++] =
            (LitFace){.plane = face->plane,
                      .polygon = p,
                      .material = face->material,
                      .first_element = face->first_element,
                      .element_count = face->element_count,
                      .lamp = mesh_is_lamp(mesh, f),
                      .outdoors = face->element_count > 0 && light_outdoors(mesh, face->first_element)};
    }
    lit->first_face[graph->polygon_count] = lit->face_count;
}

// Numbers the vertices: of each face those of its elements' corners, each node once. Returns their number; `vertex_of` [corner_count]: of
// each corner.
static int number_vertices(LitMesh *lit, int *vertex_of) {
    const Mesh *mesh = lit->mesh;
    Arena scratch = {0};
    int *last = ARENA_ARRAY(&scratch, int, lit->nodes.count + 1), count = 0, indices = 0;
    for (int n = 0; n < lit->nodes.count; n++) last[n] = -1;
    for (int f = 0; f <= lit->face_count; f++) {
        LitFace *face = &lit->faces[f];
        face->first_vertex = count;
        face->first_index = indices;
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            const Element *element = &mesh->elements[e];
            for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
                int *vertex = &last[lit->nodes.of_corner[c]];
                if (*vertex < face->first_vertex) *vertex = count++;
                vertex_of[c] = *vertex;
            }
            indices += 3 * (element->corner_count - 2);
        }
    }
    arena_free(&scratch);
    return count;
}

static void triangulate(const LitMesh *lit, const Element *element, const int *vertex_of, const Vec3 *v,
                        int index) {
    int *triangle = (int *)(lit->index + index);
    polygon_triangulate(v, element->corner_count, triangle);
    for (int k = 0; k < 3 * (element->corner_count - 2); k++)
        triangle[k] = vertex_of[element->first_corner + triangle[k]];
}

static void put_spot(const LitMesh *lit, int element, const Vec3 *v, int count) {
    Vec3 sum = vec3(0, 0, 0);
    for (int i = 0; i < count; i++) sum = vec3_add(sum, v[i]);
    Vec3 middle = vec3_sub(vec3_scale(sum, 1.0 / count), lit->origin);
    float *spot = lit->spot[element];
    spot[0] = (float)middle.x;
    spot[1] = (float)middle.y;
    spot[2] = (float)middle.z;
    spot[3] = (float)lit->mesh->elements[element].area;
}

static Vec3 polygon_normal(const CellGraph *graph, int polygon) {
    const Vec3 *v = graph->vertices + graph->polygons[polygon].first_vertex;
    return vec3_normalize(vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])));
}

// `twin`: see lit_twins.
static void fill_face(const LitMesh *lit, const LitFace *face, bool twin, const int *vertex_of,
                      Arena *scratch) {
    const Mesh *mesh = lit->mesh;
    const Building *b = lit->graph->building;
    const Face *of_mesh = &mesh->faces[mesh->face_of[face->polygon]];
    int moves = lit->graph->objects[of_mesh->object].leaf, index = face->first_index;
    const Leaf *leaf = moves >= 0 ? &b->leaves[moves] : NULL;
    Vec3 n = leaf ? polygon_normal(lit->graph, face->polygon) : face->plane.n,
         back = vec3_scale(n, twin ? -SET_BACK : 0);
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        const Element *element = &mesh->elements[e];
        Vec3 *v = ARENA_ARRAY(scratch, Vec3, element->corner_count);
        for (int i = 0; i < element->corner_count; i++) {
            int corner = element->first_corner + i;
            v[i] = mesh->vertices[mesh->corners[corner]];
            Vec3 at = leaf ? leaf_point_closed(leaf, of_mesh->open, v[i]) : v[i];
            Vec3 p = vec3_sub(vec3_add(at, back), lit->origin);
            lit->vertex[vertex_of[corner]] = (LitVertex){
                .position = {(float)p.x, (float)p.y, (float)p.z},
                .normal = {(float)n.x, (float)n.y, (float)n.z},
                .material = face->material,
                .emits = material_emits(&b->materials[face->material]),
                .outdoors = face->outdoors,
            };
            lit->node[vertex_of[corner]] = lit->nodes.of_corner[corner];
        }
        put_spot(lit, e, v, element->corner_count);
        triangulate(lit, element, vertex_of, v, index);
        index += 3 * (element->corner_count - 2);
    }
}

LitMesh *lit_mesh_new(const Mesh *mesh, Arena *arena, Arena *of_fill) {
    LitMesh *lit = ARENA_ARRAY(arena, LitMesh, 1);
    Arena scratch = {0}, kept = {0};
    *lit = (LitMesh){.mesh = mesh,
                     .graph = mesh->graph,
                     .origin = lit_origin(mesh->graph),
                     .element_count = mesh->element_count,
                     .nodes = nodes_of(mesh, of_fill)};
    faces_of_polygons(mesh, lit, arena);
    int *vertex_of = ARENA_ARRAY(&kept, int, mesh->corner_count + 1), count = number_vertices(lit, vertex_of);
    lit->vertex = ARENA_ARRAY(arena, LitVertex, count + 1);
    lit->node = ARENA_ARRAY(of_fill, int, count + 1);
    lit->index = ARENA_ARRAY(arena, unsigned, lit->faces[lit->face_count].first_index + 1);
    lit->spot = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *lit->spot);
    const bool *twins = lit_twins(mesh, &kept);
    for (int f = 0; f < lit->face_count; f++) {
        arena_reset(&scratch);
        fill_face(lit, &lit->faces[f], twins[mesh->face_of[lit->faces[f].polygon]], vertex_of, &scratch);
    }
    arena_free(&kept);
    arena_free(&scratch);
    return lit;
}

// ---- light

LitLight lit_light_new(const LitMesh *lit, Arena *arena) {
    return (LitLight){.vertex =
                          arena_alloc(arena, (size_t)lit_vertex_count(lit) + 1, sizeof *(LitLight){0}.vertex),
                      .on = ARENA_ARRAY(arena, bool, lit->lamp_count + 1),
                      .luminous = ARENA_ARRAY(arena, float, lit->element_count + 1),
                      .doors = ARENA_ARRAY(arena, float, lit->graph->building->opening_count + 1)};
}

// As the mesh has them; a door without faces that move stands anywhere.
static void find_doors(const Mesh *mesh, float *doors) {
    const Building *b = mesh->graph->building;
    for (int f = 0; f < mesh->face_count; f++) {
        int leaf = mesh->graph->objects[mesh->faces[f].object].leaf;
        if (leaf >= 0) doors[b->leaves[leaf].opening] = (float)mesh->faces[f].open;
    }
}

static void fill_luminous(const LitMesh *lit, const RadSolution *solution, LitLight *out) {
    const Mesh *mesh = lit->mesh;
    LightLevel level = {0};
    for (int e = 0; e < mesh->element_count; e++)
        out->luminous[e] = material_emits(mesh_material(mesh, mesh->elements[e].face))
                               ? 0
                               : (float)light_luminous(solution->radiosity[e]);
    light_level_add(&level, mesh, solution);
    out->level = light_level(&level);
}

// A histogram of areas by the value on them, in bins of a tenth of an octave, with the value 1 in the middle.
enum { BINS = 800, BINS_AN_OCTAVE = 10 };

static LightRange range_of(const LitMesh *lit, const RadSolution *solution, FalseColour quantity) {
    const Mesh *mesh = lit->mesh;
    double areas[BINS] = {0}, all = 0, above = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        const Material *m = mesh_material(mesh, mesh->elements[e].face);
        double value = material_emits(m) ? 0 : false_colour_value(quantity, solution->radiosity[e], m);
        if (!(value > 0)) continue;
        areas[(int)fmin(fmax(BINS / 2 + BINS_AN_OCTAVE * (double)log2f((float)value), 0), BINS - 1)] +=
            mesh->elements[e].area;
        all += mesh->elements[e].area;
    }
    int bin = BINS - 1;
    while (bin > 0 && (above += areas[bin]) <= BRIGHTEST_AREA * all) bin--;
    return light_range(all > 0 ? exp2((bin - BINS / 2) / (double)BINS_AN_OCTAVE) : 1);
}

static void fill_vertices(const LitMesh *lit, const RadSolution *solution, LitLight *out) {
    double(*node)[3] = solution->node;
    Arena scratch = {0};
    if (node) {
        CORE_ASSERT(solution->node_count == lit->nodes.count);
    } else {
        node = arena_alloc(&scratch, (size_t)lit->nodes.count + 1, sizeof *node);
        reconstruct_nodes(lit->mesh, &lit->nodes, solution, NULL, node);
    }
    for (int v = 0; v < lit_vertex_count(lit); v++)
        for (int c = 0; c < 3; c++) out->vertex[v][c] = (float)node[lit->node[v]][c];
    arena_free(&scratch);
}

void lit_light_fill(const LitMesh *lit, const RadSolution *solution, const float *doors, LitLight *out) {
    Arena scratch = {0};
    if (doors)
        memcpy(out->doors, doors, (size_t)lit->graph->building->opening_count * sizeof *doors);
    else
        find_doors(lit->mesh, out->doors);
    for (int i = 0; i < lit->lamp_count; i++)
        out->on[i] = mesh_emits(lit->mesh, lit->mesh->face_of[lit->faces[lit->lamp[i]].polygon]);
    // False colours are of the light at vertices.
    RadSolution even = reconstruct_even(lit->mesh, solution, &scratch);
    fill_vertices(lit, solution, out);
    out->day = solution->day;
    fill_luminous(lit, solution, out);
    for (int q = FALSE_COLOUR_RADIOSITY; q < FALSE_COLOURS; q++)
        out->ranges[q] = range_of(lit, &even, (FalseColour)q);

    arena_free(&scratch);
}
