// bench_room.c - a room, a table and a hanging lamp: 18 faces, an area light, penumbrae on the floor.
#include "engine/bench/bench_room.h"

#include <stdlib.h>

#include "engine/draw/image.h"
#include "maps/maps.h"

static const char PLAN[] = "plan 1\n"
                           "material floor reflectance 0.35\nmaterial wall reflectance 0.65\n"
                           "material ceiling reflectance 0.8\nmaterial wood reflectance 0.45\n"
                           "material lamp reflectance 0.1 emission 40\n"
                           "model table\n  box -0.8,-0.5,0.45 0.8,0.5,0.75 wood\nend\n"
                           "model lamp\n  box -0.3,-0.3,0 0.3,0.3,0.1 wood without bottom\n"
                           "  box -0.3,-0.3,0 0.3,0.3,0.1 lamp without top left right front back\nend\n"
                           "storey room floor 0 height 2.6\n"
                           "room room 0,0 4,0 4,3.4 0,3.4 floor floor ceiling ceiling walls wall wall 0.1\n"
                           "place table 1.6,1.3 angle 17\nplace lamp 2.1,1.9,2.2 angle 9\n"
                           "start 0.5,0.5 yaw 45\n";

static const MapsReader *plan_reader(void) {
    for (int i = 0; MAPS_READERS[i]; i++)
        if (strcmp(MAPS_READERS[i]->name, "plan") == 0) return MAPS_READERS[i];
    abort();
}

bool bench_room_make(int elements, int per_patch, Arena *arena, BenchRoom *out, Error *error) {
    *out = (BenchRoom){.building = {.source = "room"}};
    VisOptions vis = vis_default_options();
    Bytes text = {(unsigned char *)arena_string(arena, PLAN), sizeof PLAN - 1};
    if (!plan_reader()->read("room", text, arena, &out->building, error)) return false;
    if (!vis_build_cells(&out->building, &vis, arena, &out->graph, error)) return false;
    vis_build_forest(&out->graph, &vis, NULL, arena, &out->forest);
    MeshOptions best = {.per_patch = per_patch};
    int least = INT32_MAX;
    for (int step = 10; step < 200; step++) {
        Arena scratch = {0};
        MeshOptions options = {.element = 0.005 * step, .per_patch = per_patch};
        if (mesh_build(&out->graph, NULL, NULL, &options, &scratch, &out->mesh, error) &&
            abs(out->mesh.element_count - elements) < least) {
            least = abs(out->mesh.element_count - elements);
            best = options;
        }
        arena_free(&scratch);
    }
    return mesh_build(&out->graph, NULL, NULL, &best, arena, &out->mesh, error);
}

// ---- light

static double emission(const Mesh *mesh, int face) { return (double)mesh_material(mesh, face)->emission.r; }
static double reflectance(const Mesh *mesh, int face) {
    return (double)mesh_material(mesh, face)->reflectance.r;
}

RoomLight bench_room_start(const BenchRoom *room, double *light, Arena *arena) {
    const Mesh *mesh = &room->mesh;
    RoomLight state = {room, light, ARENA_ARRAY(arena, double, mesh->patch_count)};
    for (int e = 0; e < mesh->element_count; e++) light[e] = emission(mesh, mesh->elements[e].face);
    for (int p = 0; p < mesh->patch_count; p++)
        state.unshot[p] = emission(mesh, mesh->patches[p].face) * mesh->patches[p].area;
    return state;
}

int bench_room_brightest(const RoomLight *state) {
    int best = 0;
    for (int p = 1; p < state->room->mesh.patch_count; p++)
        if (state->unshot[p] > state->unshot[best]) best = p;
    return best;
}

void bench_room_shoot(RoomLight *state, int patch, const Row *row) {
    const Mesh *mesh = &state->room->mesh;
    double power = state->unshot[patch];
    state->unshot[patch] = 0;
    for (int i = 0; i < row->count; i++) {
        const Element *e = &mesh->elements[row->element[i]];
        double reflected = power * (double)row->factor[i] * reflectance(mesh, e->face);
        state->light[row->element[i]] += reflected / e->area;
        state->unshot[e->patch] += reflected;
    }
}

double bench_room_error(const BenchRoom *room, const double *light, const double *reference) {
    double off = 0, all = 0;
    for (int e = 0; e < room->mesh.element_count; e++) {
        const Element *element = &room->mesh.elements[e];
        if (emission(&room->mesh, element->face) > 0) continue;
        off += element->area * fabs(light[e] - reference[e]);
        all += element->area * reference[e];
    }
    return 100 * off / all;
}

// ---- pictures

// The element that a ray meets first, or -1.
static int meet(const Mesh *mesh, Vec3 eye, Vec3 along) {
    double nearest = INFINITY;
    int best = -1;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        double off = plane_distance(face->plane, eye), slope = vec3_dot(face->plane.n, along);
        if (off <= 0 || slope >= 0 || -off / slope >= nearest) continue;
        Vec3 at = vec3_add(eye, vec3_scale(along, -off / slope));
        bool inside = true;
        for (int i = 0; i < face->vertex_count && inside; i++) {
            const int *corner = mesh->outline + face->first_vertex;
            Vec3 a = mesh->vertices[corner[i]], b = mesh->vertices[corner[(i + 1) % face->vertex_count]];
            inside = vec3_dot(vec3_cross(vec3_sub(b, a), vec3_sub(at, a)), face->plane.n) >= 0;
        }
        if (!inside) continue;
        nearest = -off / slope;
        best = mesh_element_at(mesh, f, at);
    }
    return best;
}

bool bench_room_picture(const BenchRoom *room, const double *light, const char *path, Error *error) {
    enum { WIDTH = 480, HEIGHT = 360 };
    static const Vec3 EYE = {3.8, 0.25, 1.9}, AT = {1.5, 1.9, 0.75};
    Arena arena = {0};
    uint8_t *rgb = ARENA_ARRAY(&arena, uint8_t, WIDTH * HEIGHT * 3);
    Vec3 ahead = vec3_normalize(vec3_sub(AT, EYE)), right = vec3_normalize(vec3_cross(ahead, vec3(0, 0, 1)));
    Vec3 up = vec3_cross(right, ahead);
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        double x = (2 * (k % WIDTH + 0.5) / WIDTH - 1) * 1.1,
               y = (1 - 2 * (k / WIDTH + 0.5) / HEIGHT) * 0.825;
        int element =
            meet(&room->mesh, EYE, vec3_add(ahead, vec3_add(vec3_scale(right, x), vec3_scale(up, y))));
        double b = element < 0 ? 0 : light[element], shade = 1 - exp(-b / 1.2);
        for (int c = 0; c < 3; c++) rgb[3 * k + c] = (uint8_t)(255 * pow(shade, 1 / 2.2) + 0.5);
    }
    bool good = image_write_png(path, rgb, WIDTH, HEIGHT, error);
    arena_free(&arena);
    return good;
}
