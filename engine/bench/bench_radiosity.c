// bench_radiosity.c - the tables of the papers again, on scenes of their sizes and by methods as they describe them: Shudo,
// Murata & Matsuyama (Oki), table 1, the time that culling saves; Doi & Itoh, tables 1 and 2, the hemisphere base against the
// hemicube. Beside them, the same shots by the methods of today. Machines differ by a factor of thousands: only ratios can be
// compared.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/app/app.h"
#include "engine/bench/bench.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/text.h"
#include "engine/draw/image.h"
#include "maps/maps.h"
#include "radiosity/factors/element_buffer.h"
#include "radiosity/factors/form_factor.h"
#include "radiosity/factors/view.h"

typedef struct BenchRoom {
    Building building;
    CellGraph graph;
    StabForest forest;
    Mesh mesh;
} BenchRoom;

// Progressive refinement as it was published, one channel (Cohen, Chen, Wallace & Greenberg 1988).
typedef struct RoomLight {
    const BenchRoom *room;
    double *light;   // [element_count] W/m^2
    double *unshot;  // [patch_count] W
} RoomLight;

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

// With about so many elements.
static bool bench_room_make(int elements, int per_patch, Arena *arena, BenchRoom *out, Error *error) {
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
        if (mesh_build(&out->graph, NULL, &options, &scratch, &out->mesh, error) &&
            abs(out->mesh.element_count - elements) < least) {
            least = abs(out->mesh.element_count - elements);
            best = options;
        }
        arena_free(&scratch);
    }
    return mesh_build(&out->graph, NULL, &best, arena, &out->mesh, error);
}

// ---- light

static double emission(const Mesh *mesh, int face) { return (double)mesh_material(mesh, face)->emission.r; }
static double reflectance(const Mesh *mesh, int face) {
    return (double)mesh_material(mesh, face)->reflectance.r;
}

static RoomLight bench_room_start(const BenchRoom *room, double *light, Arena *arena) {
    const Mesh *mesh = &room->mesh;
    RoomLight state = {room, light, ARENA_ARRAY(arena, double, mesh->patch_count)};
    for (int e = 0; e < mesh->element_count; e++) light[e] = emission(mesh, mesh->elements[e].face);
    for (int p = 0; p < mesh->patch_count; p++)
        state.unshot[p] = emission(mesh, mesh->patches[p].face) * mesh->patches[p].area;
    return state;
}

// the patch with most unshot power
static int bench_room_brightest(const RoomLight *state) {
    int best = 0;
    for (int p = 1; p < state->room->mesh.patch_count; p++)
        if (state->unshot[p] > state->unshot[best]) best = p;
    return best;
}

static void bench_room_shoot(RoomLight *state, int patch, const Row *row) {
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

// The area-weighted mean of |difference| of the light that arrives at elements, the lamp left out, over the mean light, percent.
static double bench_room_error(const BenchRoom *room, const double *light, const double *reference) {
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
static int first_element(const Mesh *mesh, Vec3 eye, Vec3 along) {
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

// A look into the room, an element one shade.
static bool bench_room_picture(const BenchRoom *room, const double *light, const char *path, Error *error) {
    enum { WIDTH = 480, HEIGHT = 360 };
    static const Vec3 EYE = {3.8, 0.25, 1.9}, AT = {1.5, 1.9, 0.75};
    Arena arena = {0};
    uint8_t *rgb = ARENA_ARRAY(&arena, uint8_t, WIDTH * HEIGHT * 3);
    Vec3 ahead = vec3_normalize(vec3_sub(AT, EYE)), right = vec3_normalize(vec3_cross(ahead, vec3(0, 0, 1)));
    Vec3 up = vec3_cross(right, ahead);
    for (int k = 0; k < WIDTH * HEIGHT; k++) {
        double x = (2 * (k % WIDTH + 0.5) / WIDTH - 1) * 1.1,
               y = (1 - 2 * (k / WIDTH + 0.5) / HEIGHT) * 0.825;
        int element = first_element(&room->mesh, EYE,
                                    vec3_add(ahead, vec3_add(vec3_scale(right, x), vec3_scale(up, y))));
        double b = element < 0 ? 0 : light[element], shade = 1 - exp(-b / 1.2);
        for (int c = 0; c < 3; c++) rgb[3 * k + c] = (uint8_t)(255 * pow(shade, 1 / 2.2) + 0.5);
    }
    bool good = image_write_png(path, rgb, WIDTH, HEIGHT, error);
    arena_free(&arena);
    return good;
}

static const char HEAD[] =
    "table,building,method,culling,cells,polygons,patches,elements,shots,elements_drawn,"
    "seconds,drawing_seconds,visibility_seconds,error_percent\n";

// Oki's sizes.
enum { OKI_ELEMENTS = 76612, OKI_SHOTS = 100, RESOLUTION = 100, MOST_ROOM_FACES = 64 };

// ---- the measurements of all tables

typedef struct Shots {
    const char *table, *building, *method, *culling;
    int cells, shots;
    double elements_drawn;                // mean of the shots; of a hemicube, of its sides
    double seconds, drawing, visibility;  // of all shots; the rest is summing and receiving
    double error;                         // percent, or -1
} Shots;

static void add_shots(Text *csv, const Mesh *mesh, const Shots *s) {
    size_t before = csv->size;
    text_append(csv, "%s,%s,%s,%s,%d,%d,%d,%d,%d,%.0f,%.4f,%.4f,%.4f,", s->table, s->building, s->method,
                s->culling, s->cells, mesh->face_count, mesh->patch_count, mesh->element_count, s->shots,
                s->elements_drawn, s->seconds, s->drawing, s->visibility);
    if (s->error >= 0) text_append(csv, "%.3f", s->error);
    text_append(csv, "\n");
    fputs(csv->data + before, stdout);
    fflush(stdout);
}

static ViewPoint point_of(const Mesh *mesh, int patch) {
    const Patch *p = &mesh->patches[patch];
    return (ViewPoint){p->centre, mesh->faces[p->face].plane.n, p->cell};
}

// ---- Oki

typedef struct OkiBench {
    const LoadedScene *scene;
    const Mesh *mesh;
    ElementBuffer *buffer;
    VisQuery *query;
    RowSum sum;
    double *received;  // [element_count]
    int *all, *faces;  // [face_count]
} OkiBench;

// By section 3.1: the stab tree in plan, within the horizontal angle of the side's view volume where it is less than a half
// turn, and all around where not.
static int list_visible(const OkiBench *b, const ViewPoint *from, int side) {
    Eye eye = {.position = from->eye, .on_surface = true};
    eye.frustum_count = element_buffer_frustum(b->buffer, side, eye.frustum);
    VisResult result = vis_query(b->query, &eye, from->cell, NULL, CULL_PLAN);
    int count = 0;
    for (int i = 0; i < result.object_count; i++) {
        const Object *object = &b->scene->graph.objects[result.objects[i]];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            if (b->mesh->face_of[p] >= 0) b->faces[count++] = b->mesh->face_of[p];
    }
    return count;
}

static void shoot_once(OkiBench *b, int patch, bool culled, Shots *out) {
    ViewPoint from = point_of(b->mesh, patch);
    double begin = clock_thread_seconds();
    element_buffer_start(b->buffer, &from);
    for (int side = 0; side < element_buffer_sides(b->buffer); side++) {
        double at = clock_thread_seconds();
        int count = culled ? list_visible(b, &from, side) : b->mesh->face_count;
        double listed = clock_thread_seconds();
        long long drawn = element_buffer_draw(b->buffer, side, culled ? b->faces : b->all, count);
        out->elements_drawn += (double)drawn / element_buffer_sides(b->buffer);
        if (culled) out->visibility += listed - at;
        out->drawing += clock_thread_seconds() - listed;
    }
    element_buffer_sum(b->buffer, &b->sum);
    const Row *row = row_finish(&b->sum);
    for (int i = 0; i < row->count; i++) b->received[row->element[i]] += (double)row->factor[i];
    out->seconds += clock_thread_seconds() - begin;
}

// The mesh of the office whose elements are about as many as theirs: larger edges make fewer.
static bool mesh_of_size(const CellGraph *graph, Arena *arena, Mesh *out, Error *error) {
    double low = 0.2, high = 4;
    for (int step = 0; step < 7; step++) {
        Arena scratch = {0};
        MeshOptions options = {.element = 0.5 * (low + high), .per_patch = 2};
        bool good = mesh_build(graph, NULL, &options, &scratch, out, error);
        arena_free(&scratch);
        if (!good) return false;
        *(out->element_count > OKI_ELEMENTS ? &low : &high) = options.element;
    }
    MeshOptions options = {.element = high, .per_patch = 2};
    return mesh_build(graph, NULL, &options, arena, out, error);
}

static void oki_rows(OkiBench *b, const char *file, Text *csv) {
    for (int culled = 0; culled < 2; culled++) {
        Shots shots = {.table = "oki",
                       .building = bench_name(file),
                       .method = "hemicube-elements",
                       .culling = culled ? "plan" : "none",
                       .cells = b->scene->graph.cell_count,
                       .error = -1};
        // Patches evenly over the building.
        for (int i = 0; i < OKI_SHOTS; i++) {
            int patch = (int)((i + 0.5) * b->mesh->patch_count / OKI_SHOTS);
            if (b->mesh->patches[patch].cell < 0) continue;
            shoot_once(b, patch, culled, &shots);
            shots.shots++;
        }
        shots.elements_drawn /= shots.shots;
        add_shots(csv, b->mesh, &shots);
    }
}

static bool bench_oki(const char *file, const BenchArguments *arguments, Text *csv, Error *error) {
    Arena arena = {0};
    LoadedScene scene;
    SceneOptions options = arguments->load;
    Mesh mesh;
    bool good = app_load(file, &options, &arena, &scene, error) && scene_has_walls(&scene, error) &&
                mesh_of_size(&scene.graph, &arena, &mesh, error);
    if (good) {
        OkiBench b = {.scene = &scene, .mesh = &mesh};
        b.buffer = element_buffer_new(&mesh, ELEMENT_HEMICUBE, RESOLUTION, &arena);
        b.query = vis_query_new(&scene.graph, &scene.forest, &arena);
        b.received = ARENA_ARRAY(&arena, double, mesh.element_count);
        b.faces = ARENA_ARRAY(&arena, int, mesh.face_count);
        b.all = ARENA_ARRAY(&arena, int, mesh.face_count);
        for (int f = 0; f < mesh.face_count; f++) b.all[f] = f;
        row_start(&b.sum, &mesh, &arena);
        oki_rows(&b, file, csv);
    }
    arena_free(&arena);
    return good;
}

// ---- Doi & Itoh

typedef struct RoomBench {
    const BenchRoom *room;
    RowSum sum;
    int *faces;
} RoomBench;

static void doi_elements(RoomBench *b, const char *table, int kind, int shots, const double *reference,
                         double *light, Text *csv, Arena *arena) {
    const Mesh *mesh = &b->room->mesh;
    Shots out = {.table = table,
                 .building = "room",
                 .method = kind == ELEMENT_HEMICUBE ? "hemicube-elements" : "hemisphere-elements",
                 .culling = "none",
                 .cells = b->room->graph.cell_count,
                 .shots = shots};
    ElementBuffer *buffer = element_buffer_new(mesh, kind, RESOLUTION, arena);
    RoomLight state = bench_room_start(b->room, light, arena);
    double begin = clock_thread_seconds();
    for (int i = 0; i < shots; i++) {
        int patch = bench_room_brightest(&state);
        ViewPoint from = point_of(mesh, patch);
        element_buffer_start(buffer, &from);
        double at = clock_thread_seconds();
        for (int side = 0; side < element_buffer_sides(buffer); side++)
            out.elements_drawn += (double)element_buffer_draw(buffer, side, b->faces, mesh->face_count) /
                                  element_buffer_sides(buffer) / shots;
        out.drawing += clock_thread_seconds() - at;
        element_buffer_sum(buffer, &b->sum);
        bench_room_shoot(&state, patch, row_finish(&b->sum));
    }
    out.seconds = clock_thread_seconds() - begin;
    out.error = bench_room_error(b->room, light, reference);
    add_shots(csv, mesh, &out);
}

// The same by a method of today; `csv` NULL: not measured.
static void doi_faces(RoomBench *b, const char *table, const char *method, int resolution, int shots,
                      const double *reference, double *light, Text *csv, Arena *arena) {
    const Mesh *mesh = &b->room->mesh;
    Shots out = {.table = table,
                 .building = "room",
                 .method = method,
                 .culling = "none",
                 .cells = b->room->graph.cell_count,
                 .shots = shots};
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    FormFactor *rows = form_factor_new(form_factor_method(method), mesh, &options, arena);
    Viewer *viewer = viewer_new(mesh, &b->room->forest, NULL, arena);
    RoomLight state = bench_room_start(b->room, light, arena);
    double begin = clock_thread_seconds();
    for (int i = 0; i < shots; i++) {
        int patch = bench_room_brightest(&state);
        ViewPoint from = point_of(mesh, patch);
        double at = clock_thread_seconds();
        const View *view = viewer_look(viewer, &from, CULL_NONE);
        double looked = clock_thread_seconds();
        const Row *row = form_factor_row(rows, view);
        out.visibility += looked - at;
        out.drawing += clock_thread_seconds() - looked;
        bench_room_shoot(&state, patch, row);
    }
    out.seconds = clock_thread_seconds() - begin;
    out.elements_drawn = (double)form_factor_work(rows).elements_drawn / shots;
    form_factor_end(rows);
    if (!csv) return;
    out.error = bench_room_error(b->room, light, reference);
    add_shots(csv, mesh, &out);
}

// Their image quality as an error: against rows of 1,000 pixels across, after as many shots; and as pictures.
static bool bench_doi(const char *table, int elements, int per_patch, int shots, const char *pictures,
                      Text *csv, Error *error) {
    Arena arena = {0};
    BenchRoom room;
    bool good = bench_room_make(elements, per_patch, &arena, &room, error);
    if (good) {
        int count = room.mesh.element_count, faces[MOST_ROOM_FACES];
        RoomBench b = {.room = &room, .faces = faces};
        for (int f = 0; f < room.mesh.face_count && f < MOST_ROOM_FACES; f++) faces[f] = f;
        row_start(&b.sum, &room.mesh, &arena);
        double *reference = ARENA_ARRAY(&arena, double, count), *light = ARENA_ARRAY(&arena, double, count);
        doi_faces(&b, table, "hemisphere", 1000, shots, NULL, reference, NULL, &arena);
        for (int kind = 0; kind < 2 && good; kind++) {
            doi_elements(&b, table, kind, shots, reference, light, csv, &arena);
            if (pictures)
                good = bench_room_picture(
                    &room, light,
                    arena_format(&arena, "%s/%s-%s.png", pictures, table, kind ? "hemisphere" : "hemicube"),
                    error);
        }
        doi_faces(&b, table, "hemicube", RESOLUTION, shots, reference, light, csv, &arena);
        doi_faces(&b, table, "hemisphere", RESOLUTION, shots, reference, light, csv, &arena);
    }
    arena_free(&arena);
    return good;
}

static bool bench_both_doi(const BenchArguments *a, Text *csv, Error *error) {
    return bench_doi("doi-itoh-1", 548, 2, 50, a->pictures, csv, error) &&
           bench_doi("doi-itoh-2", 3294, 3, 100, a->pictures, csv, error);
}

static bool measure_radiosity(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, bench_both_doi, bench_oki, error);
}

static const Option ROWS[] = {
    BENCH_PICTURES("of the room by each method, DIR/doi-itoh-2-hemicube.png and so on"),
    BENCH_CSV,
};

const Bench BENCH_RADIOSITY = {
    .name = "radiosity",
    .about =
        "the tables of the papers again, on scenes of their sizes: what culling saves of FILE (Oki), the "
        "hemisphere base against the hemicube in a furnished room (Doi & Itoh)",
    BENCH_OPTIONS(ROWS),
    .run = measure_radiosity,
};
