// bench_radiosity.c - the tables of the papers again, on scenes of their sizes and by methods as they describe them: Shudo,
// Murata & Matsuyama (Oki), table 1, what culling saves; Doi & Itoh, tables 1 and 2, the hemisphere base against the
// hemicube. Beside them, the same shots by the methods of today. Machines differ by a factor of thousands: only ratios can be
// compared.
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "engine/bench/bench.h"
#include "engine/bench/bench_room.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/text.h"
#include "radiosity/factors/element_buffer.h"
#include "radiosity/factors/view.h"

static const char HEAD[] =
    "table,building,method,culling,cells,polygons,patches,elements,shots,elements_drawn,"
    "seconds,drawing_seconds,visibility_seconds,error_percent\n";

// Oki's sizes.
enum { OKI_ELEMENTS = 76612, OKI_SHOTS = 100, RESOLUTION = 100, MOST_ROOM_FACES = 64 };

// ---- what all tables measure

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
    VisResult result = vis_query(b->query, &eye, from->cell, NULL, VIS_PLAN);
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
        bool good = mesh_build(graph, NULL, NULL, &options, &scratch, out, error);
        arena_free(&scratch);
        if (!good) return false;
        *(out->element_count > OKI_ELEMENTS ? &low : &high) = options.element;
    }
    MeshOptions options = {.element = high, .per_patch = 2};
    return mesh_build(graph, NULL, NULL, &options, arena, out, error);
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

static void doi_elements(RoomBench *b, const char *table, ElementBufferKind kind, int shots,
                         const double *reference, double *light, Text *csv, Arena *arena) {
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
        const View *view = viewer_look(viewer, &from, CULL_NOTHING);
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
            doi_elements(&b, table, (ElementBufferKind)kind, shots, reference, light, csv, &arena);
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
