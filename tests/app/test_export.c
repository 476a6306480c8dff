// test_export.c - an exported model read back by our own reader: bounds, doors' leaves, viewpoints; and in its bytes the
// light of the solution times the exposure it tells.
#include <criterion/criterion.h>
#include <jansson.h>

#include "engine/app/export_glb.h"
#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "radiosity/show/reconstruct.h"
#include "tests/maps/ifc/house_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

typedef struct Written {
    Lit *lit;
    RadSolution solution;
    float *doors;
    Vec3 *posed;  // the graph's vertices, with the doors so
    const char *path;
} Written;

// Cells and mesh with doors half open, so that leaves stand neither as drawn nor along an axis.
static Written write_lit(Lit *lit, float open) {
    Written w = {.lit = lit};
    const Building *b = lit->building;
    Error error = {""};
    MeshOptions mesh = {.element = 1, .per_patch = 2};
    RadOptions options = rad_default_options();
    options.shots = 200;
    w.doors = ARENA_ARRAY(&lit->arena, float, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) w.doors[i] = open;
    Vec3 *posed = w.posed = ARENA_ARRAY(&lit->arena, Vec3, lit->graph.vertex_count + 1);
    memcpy(posed, lit->graph.vertices, (size_t)lit->graph.vertex_count * sizeof *posed);
    vis_pose(&lit->graph, w.doors, posed);
    cr_assert(mesh_build(&lit->graph, w.doors, &mesh, &lit->arena, &lit->mesh, &error), "%s", error.text);
    cr_assert(rad_start(&lit->mesh, &lit->arena, &w.solution, &error), "%s", error.text);
    rad_shoot(&lit->mesh, &lit->forest, w.doors, &options, NULL, &w.solution);
    w.path = arena_format(&lit->arena, "%s/x.glb", support_folder(&lit->arena));
    cr_assert(export_glb(w.path, &lit->mesh, &w.solution, w.doors, &error), "%s", error.text);
    return w;
}

static Lit *read_house(void) {
    Lit *lit = lit_new();
    Error error = {""};
    *lit->building = (Building){0};
    cr_assert(maps_read("maps/buildings/house.plan", &lit->arena, lit->building, &error), "%s", error.text);
    lit_finish(lit, 2, 2);
    cr_assert(lit->building->leaf_count > 5 && lit->building->viewpoint_count > 5);
    return lit;
}

static Box bounds_of_mesh(const Mesh *mesh) {
    Box box = box_empty();
    for (int i = 0; i < mesh->vertex_count; i++) box = box_add(box, mesh->vertices[i]);
    return box;
}

// Area, and area times where it is.
typedef struct Moment {
    double area;
    Vec3 sum;
} Moment;

static void add_moment(Moment *m, double area, Vec3 middle) {
    m->area += area;
    m->sum = vec3_add(m->sum, vec3_scale(middle, area));
}

static void add_polygon(Moment *m, const Vec3 *v, int count) {
    for (int i = 1; i + 1 < count; i++) {
        Vec3 triangle[3] = {v[0], v[i], v[i + 1]};
        add_moment(m, polygon_area(triangle, 3),
                   vec3_scale(vec3_add(v[0], vec3_add(v[i], v[i + 1])), 1.0 / 3));
    }
}

static Moment moment_of_written(const Written *w) {
    const CellGraph *graph = &w->lit->graph;
    const Mesh *mesh = &w->lit->mesh;
    Moment m = {0};
    for (int e = 0; e < mesh->element_count; e++)
        if (!mesh->faces[mesh->elements[e].face].hidden)
            add_moment(&m, mesh->elements[e].area, element_centroid(mesh, e));
    for (int p = 0; p < graph->polygon_count; p++)
        if (vis_is_glass(graph, p))
            add_polygon(&m, w->posed + graph->polygons[p].first_vertex, graph->polygons[p].vertex_count);
    return m;
}

static void expect_near(Vec3 a, Vec3 b) { cr_assert_lt(vec3_length(vec3_sub(a, b)), 1e-4); }

// Proves that a house with its doors at any angle comes back where it was: the same bounds and area, to floats a hundred
// metres from the middle. So leaves' poses, the turn to y up and back, and positions are right.
Test(export, comes_back_in_its_place) {
    for (int k = 0; k <= 2; k++) {
        Lit *lit = read_house();
        Written w = write_lit(lit, 0.5f * (float)k);
        Arena arena = {0};
        Building back;
        Error error = {""};
        cr_assert(maps_read(w.path, &arena, &back, &error), "%s", error.text);
        Box expected = bounds_of_mesh(&w.lit->mesh), got = box_empty();
        for (int i = 0; i < back.vertex_count; i++) got = box_add(got, back.vertices[i]);
        expect_near(got.min, expected.min);
        expect_near(got.max, expected.max);
        Moment went = moment_of_written(&w), came = {0};
        for (int i = 0; i < back.polygon_count; i++)
            add_polygon(&came, back.vertices + back.polygons[i].first_vertex, back.polygons[i].vertex_count);
        cr_assert_float_eq(came.area, went.area, 0.05, "open %g: %g m^2, not %g", k / 2.0, came.area,
                           went.area);
        // A leaf of 2 m^2 that turns the wrong way is off by metres.
        cr_assert_lt(vec3_length(vec3_sub(came.sum, went.sum)), 0.2);
        cr_assert_eq(back.viewpoint_count, w.lit->building->viewpoint_count);
        for (int i = 0; i < back.viewpoint_count; i++) {
            const Viewpoint *v = &w.lit->building->viewpoints[i], *r = &back.viewpoints[i];
            expect_near(r->eye, v->eye);
            cr_assert_float_eq(remainder(r->yaw - v->yaw, 2 * M_PI), 0, 1e-6);
            cr_assert_float_eq(r->pitch, v->pitch, 1e-6);
            cr_assert_float_eq(r->fov, v->fov, 1e-6);
        }
        arena_free(&arena);
        lit_free(w.lit);
    }
}

static json_t *document_of(Bytes file, const unsigned char **binary) {
    uint32_t length;
    cr_assert_eq(memcmp(file.data, "glTF\2\0\0\0", 8), 0);
    memcpy(&length, file.data + 12, sizeof length);
    json_t *json = json_loadb((const char *)file.data + 20, length, 0, NULL);
    cr_assert_not_null(json);
    *binary = file.data + 20 + length + 8;
    return json;
}

static double number(const json_t *json, const char *key) {
    return json_number_value(json_object_get(json, key));
}

// Proves that colours are the light of vertices times the exposure told: of a room's walls, brightest and darkest vertex and the
// number of those, to half a step of 16 bits, and that lamps are cut off at 1; and that the radiant exitance beside them is the light
// itself to the last bit of a float, lamps included.
Test(export, colours_are_light) {
    Lit *lit = lit_new();
    Arena arena = {0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit_finish(lit, 0.5, 2);
    Written w = write_lit(lit, 1);
    VertexLight light = reconstruct_light(&lit->mesh, &w.solution, &arena);
    const unsigned char *binary;
    json_t *json = document_of(support_read(&arena, w.path), &binary);
    const json_t *extras = json_object_get(json_array_get(json_object_get(json, "scenes"), 0), "extras");
    double exposure = number(extras, "exposure_m2_per_W"), low_light = INFINITY, high_light = 0;
    cr_assert_float_eq(exposure * number(extras, "W_per_m2_per_unit"), 1, 1e-12);
    for (int i = 0; i < lit->mesh.corner_count; i++) {
        low_light = fmin(low_light, light.corner[i][1]);
        high_light = fmax(high_light, light.corner[i][1]);
    }
    double low = low_light * exposure, high = high_light * exposure;
    cr_assert(low > 0 && low < 1 && high > 1);
    const json_t *view = json_array_get(json_object_get(json, "bufferViews"), 1);
    const uint16_t *colour = (const void *)(binary + (size_t)number(view, "byteOffset"));
    int count = (int)number(view, "byteLength") / 8, least = 65535, most = 0;
    cr_assert_eq(count, nodes_of(&lit->mesh, &arena).count);
    for (int i = 0; i < count; i++) {
        if (colour[4 * i + 1] < least) least = colour[4 * i + 1];
        if (colour[4 * i + 1] > most) most = colour[4 * i + 1];
    }
    cr_assert_float_eq(least / 65535.0, low, 1.0 / 65535, "%g, not %g", least / 65535.0, low);
    cr_assert_eq(most, 65535);
    view = json_array_get(json_object_get(json, "bufferViews"), 2);
    const float *radiant = (const void *)(binary + (size_t)number(view, "byteOffset"));
    float darkest = INFINITY, brightest = 0;
    cr_assert_eq((int)number(view, "byteLength"), 12 * count);
    for (int i = 0; i < count; i++) {
        darkest = fminf(darkest, radiant[3 * i + 1]);
        brightest = fmaxf(brightest, radiant[3 * i + 1]);
    }
    cr_assert_eq(darkest, (float)low_light, "%g, not %g", (double)darkest, low_light);
    cr_assert_eq(brightest, (float)high_light, "%g, not %g", (double)brightest, high_light);
    json_decref(json);
    arena_free(&arena);
    lit_free(lit);
}

// ---- pictures

// The bytes of an accessor.
static const void *values(const json_t *json, const unsigned char *binary, const json_t *accessor) {
    const json_t *view =
        json_array_get(json_object_get(json, "bufferViews"), (size_t)number(accessor, "bufferView"));
    return binary + (size_t)number(view, "byteOffset") + (size_t)number(accessor, "byteOffset");
}

static const json_t *item(const json_t *json, const char *list, double index) {
    return json_array_get(json_object_get(json, list), (size_t)index);
}

// A triangle as exported, in the building's space.
typedef struct Pictured {
    Vec3 p[3];
    Vec2 place[3];
    const char *image;
} Pictured;

static Vec3 translation(const json_t *node) {
    const json_t *t = json_object_get(node, "translation");
    return vec3(json_number_value(json_array_get(t, 0)), json_number_value(json_array_get(t, 1)),
                json_number_value(json_array_get(t, 2)));
}

// How far a triangle's places lie from where the picture of a polygon has its corners, in repetitions, whole ones apart; INFINITY: the
// triangle is not of that polygon, or lies otherwise than `texture_at` reads the picture.
static double places_off(const CellGraph *graph, int polygon, const Pictured *t) {
    const Building *b = graph->building;
    const Polygon *p = &graph->polygons[polygon];
    const Material *m = &b->materials[p->material];
    const Texture *texture = &b->textures[m->texture];
    int at = p->texture_map ? p->texture_map : m->texture_map;
    if (m->texture == 0 || at == 0 || strcmp(texture->name, t->image) != 0) return INFINITY;
    const Vec3 *v = graph->vertices + p->first_vertex;
    Plane plane = plane_of_polygon(v, p->vertex_count);
    Vec3 middle = vec3_scale(vec3_add(t->p[0], vec3_add(t->p[1], t->p[2])), 1.0 / 3);
    if (fabs(vec3_dot(plane.n, middle) - plane.d) > 1e-4) return INFINITY;
    for (int k = 0; k < p->vertex_count; k++) {
        Vec3 edge = vec3_sub(v[(k + 1) % p->vertex_count], v[k]);
        if (vec3_dot(vec3_cross(plane.n, edge), vec3_sub(middle, v[k])) < 0) return INFINITY;
    }
    double worst = 0;
    for (int i = 0; i < 3; i++) {
        const TextureMap *map = &b->texture_maps[at];
        double u = t->place[i].x - vec3_dot(map->u, t->p[i]) - map->u0,
               w = t->place[i].y - vec3_dot(map->v, t->p[i]) - map->v0;
        worst = fmax(worst, hypot(u - nearbyint(u), w - nearbyint(w)));
        Texel here = texture_at(b, p->material, p->texture_map, t->p[i], 1e-6),
              there = texture_read(texture, t->place[i].x, t->place[i].y, 0);
        double share = (double)there.colour.g * (double)m->reflectance.g / (double)texture->mean.g;
        // Between texels colours change by 64 a repetition at most, of 1e-4 of one.
        if (fabs((double)here.colour.g - share) > 0.01) worst = INFINITY;
    }
    return worst;
}

static double best_of(const CellGraph *graph, const Pictured *t) {
    double best = INFINITY;
    for (int i = 0; i < graph->polygon_count; i++) best = fmin(best, places_off(graph, i, t));
    return best;
}

// Checks the triangles of a primitive; returns their number.
static int check_pictured(const Lit *lit, const json_t *json, const unsigned char *binary, Vec3 from,
                          const json_t *primitive) {
    const json_t *attributes = json_object_get(primitive, "attributes"),
                 *places = json_object_get(attributes, "TEXCOORD_0");
    if (!places) return 0;
    const json_t *indices = item(json, "accessors", number(primitive, "indices"));
    const json_t *base = json_object_get(
        json_object_get(item(json, "materials", number(primitive, "material")), "pbrMetallicRoughness"),
        "baseColorTexture");
    const json_t *texture = item(json, "textures", number(base, "index"));
    Pictured t = {
        .image = json_string_value(json_object_get(item(json, "images", number(texture, "source")), "name"))};
    const float *position = values(json, binary, item(json, "accessors", number(attributes, "POSITION")));
    const float *place = values(json, binary, item(json, "accessors", json_number_value(places)));
    const uint32_t *index = values(json, binary, indices);
    int count = (int)number(indices, "count") / 3;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            uint32_t at = index[3 * i + k];
            const float *p = position + 3 * at;
            t.p[k] = vec3_add(from, vec3((double)p[0], (double)p[1], (double)p[2]));
            t.place[k] = vec2((double)place[2 * at], (double)place[2 * at + 1]);
        }
        double off = best_of(&lit->graph, &t);
        cr_assert_lt(off, 1e-4, "%s at (%.2f, %.2f, %.2f) lies %g repetitions off", t.image, t.p[0].x,
                     t.p[0].y, t.p[0].z, off);
    }
    return count;
}

// Proves that pictures leave with the building as they lie on it: each corner of every exported triangle that shows one has, as
// TEXCOORD_0, the place of `texture_at` in it, whole repetitions apart. 1e-4 repetitions: places are floats, a hundred repetitions
// from the picture's beginning at most.
Test(export, pictures_lie_as_here) {
    Lit *lit = lit_new();
    Arena arena = {0};
    Error error = {""};
    *lit->building = (Building){0};
    cr_assert(maps_read("maps/buildings/attic.sh3d", &lit->arena, lit->building, &error), "%s", error.text);
    lit->building->source = "house.ifc";
    lit->building->materials[0].emission = (Rgb){1, 1, 1};
    lit_finish(lit, 2, 2);
    Written w = write_lit(lit, 0);
    const unsigned char *binary;
    json_t *json = document_of(support_read(&arena, w.path), &binary), *node;
    Vec3 root = translation(item(json, "nodes", 0));
    size_t i;
    int count = 0;
    json_array_foreach(json_object_get(json, "nodes"), i, node) {
        const json_t *mesh = json_object_get(node, "mesh");
        Vec3 from = vec3_add(vec3(root.x, -root.z, root.y), i > 0 ? translation(node) : vec3(0, 0, 0));
        size_t k;
        json_t *primitive;
        if (mesh)
            json_array_foreach(json_object_get(item(json, "meshes", json_number_value(mesh)), "primitives"),
                               k, primitive) count += check_pictured(lit, json, binary, from, primitive);
    }
    cr_assert_gt(count, 500, "%d triangles", count);
    json_decref(json);
    arena_free(&arena);
    lit_free(lit);
}

// Proves that names which are no UTF-8, and a full disk or a missing folder, do no harm.
Test(export, odd_names_and_places) {
    Lit *lit = lit_new();
    Error error = {""};
    Arena arena = {0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit->building->objects[0].name = "K\xfc"
                                     "che";
    lit->building->materials[0].name = "\xff";
    lit_finish(lit, 1, 2);
    Written w = write_lit(lit, 1);
    const unsigned char *binary;
    json_t *json = document_of(support_read(&arena, w.path), &binary);
    json_decref(json);
    cr_assert_not(export_glb("/dev/full", &lit->mesh, &w.solution, w.doors, &error));
    cr_assert_not_null(strstr(error.text, "No space left"), "says `%s`", error.text);
    cr_assert_not(export_glb("/no/such/folder/x.glb", &lit->mesh, &w.solution, w.doors, &error));
    cr_assert_not_null(strstr(error.text, "cannot be written"), "says `%s`", error.text);
    arena_free(&arena);
    lit_free(lit);
}

// Storeys, rooms, doors and windows of a building model keep their names.
Test(export, names_of_building_models) {
    static const char *const NAMES[] = {"ground floor", "1 west",     "2 east",
                                        "inner door",   "front door", "north window"};
    enum { NAME_COUNT = sizeof NAMES / sizeof *NAMES };
    Lit *lit = lit_new();
    House house = house_two_rooms(&lit->arena, false, vec2(0, 0), 0, true);
    *lit->building = (Building){0};
    house_read(&lit->arena, house_end(&house), lit->building);
    lit->building->source = "house.ifc";
    lit->building->materials[0].emission = (Rgb){1, 1, 1};
    lit_finish(lit, 2, 2);
    Written w = write_lit(lit, 0);
    const unsigned char *binary;
    json_t *json = document_of(support_read(&lit->arena, w.path), &binary),
           *nodes = json_object_get(json, "nodes");
    for (int i = 0; i < NAME_COUNT; i++) {
        bool found = false;
        for (size_t k = 0; k < json_array_size(nodes); k++) {
            const char *name = json_string_value(json_object_get(json_array_get(nodes, k), "name"));
            found |= name && strcmp(name, NAMES[i]) == 0;
        }
        cr_expect(found, "no node is called `%s`", NAMES[i]);
    }
    json_decref(json);
    lit_free(lit);
}
