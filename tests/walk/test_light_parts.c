// test_light_parts.c - light in parts, as walks show it: pictures are those of the whole, and a thread reads part after part.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/clock.h"
#include "engine/core/memory.h"
#include "engine/draw/image.h"
#include "engine/lit/lit_parts.h"
#include "engine/scene/bake_parts.h"
#include "engine/scene/kept_parts.h"
#include "engine/scene/light_parts.h"
#include "engine/walk/light_thread.h"
#include "engine/walk/walk_offscreen.h"
#include "tests/support/support.h"

#include "tests/walk/light_thread_fixture.h"

// The house, its light in parts and as a whole.
typedef struct Apart {
    Arena arena;
    WalkScene parted, whole;
    PartsReport report;
} Apart;

// The last warning.
static char warned[1024];
static void warn(const char *sentence) { snprintf(warned, sizeof warned, "%s", sentence); }

static SceneOptions options_of(const char *light) {
    SceneOptions o = scene_default_options();
    o.warn = warn;
    o.day.night = true;
    o.lamps = SCENE_LAMPS_ALL;
    o.find_light = light != NULL;
    o.light = light;
    return o;
}

static void bake(LoadedScene *scene, const char *apart, const char *joined, Arena *arena,
                 PartsReport *report) {
    Error error = {""};
    BakeOptions o = bake_default_options();
    PartsKeep keep = {apart ? kept_folder(apart, arena) : NULL, 1e9, false, apart, lit_store_part};
    Mesh mesh;
    RadSolution light;
    float *doors;
    o.mesh.element = 0.6;
    o.rad.residual = 1e-3;
    cr_assert(
        bake_parts(&o, scene, 30, apart ? &keep : NULL, NULL, arena, &doors, &mesh, &light, report, &error),
        "%s", error.text);
    if (joined) cr_assert(rad_save(joined, &mesh, doors, &light, &error), "%s", error.text);
}

static Apart *load(void) {
    Apart *a = calloc(1, sizeof *a);
    Error error = {""};
    LoadedScene scene;
    const char *folder = support_folder(&a->arena), *apart = arena_format(&a->arena, "%s/apart.rad", folder),
               *joined = arena_format(&a->arena, "%s/joined.rad", folder);
    SceneOptions dark = options_of(NULL), parted = options_of(apart), whole = options_of(joined);
    cr_assert(scene_load("build/maps/house.plan", &dark, &a->arena, &scene, &error), "%s", error.text);
    bake(&scene, NULL, joined, &a->arena, &a->report);
    bake(&scene, apart, NULL, &a->arena, &a->report);
    cr_assert(walk_scene_load(&parted, "build/maps/house.plan", &a->arena, &a->parted, &error), "%s",
              error.text);
    cr_assert(walk_scene_load(&whole, "build/maps/house.plan", &a->arena, &a->whole, &error), "%s",
              error.text);
    cr_assert(a->parted.baker.parts && !a->parted.light && !a->parted.baker.bake && a->whole.light);
    return a;
}

static void end(Apart *a) {
    arena_free(&a->arena);
    free(a);
}

enum { WIDE = 128, HIGH = 72, PICTURES = 12 };

static WalkTotals draw(const WalkScene *scene, const char *folder, Arena *arena) {
    WalkOptions o = walk_default_options();
    WalkTotals totals;
    Error error = {""};
    Arena rooms[2] = {{0}};
    o.folder = folder;
    o.width = WIDE, o.height = HIGH;
    o.frames_per_second = 1;
    o.every = 3;
    o.doors = WALK_DOORS_DRAWN;
    o.look = WALK_BAKED;
    o.light = (FilmLightSource){scene->light, scene->baker.parts, NULL, scene->scene->lit, rooms};
    cr_assert(walk_offscreen(scene->graph, scene->forest, &o, NULL, arena, &totals, &error), "%s",
              error.text);
    for (int i = 0; i < 2; i++) arena_free(&rooms[i]);
    return totals;
}

// Proves that a tour through light in parts, with the eye in one part after another, shows what the same light shows as a whole: no
// polygon is missing, and the exposure is that of the whole building. Few pixels differ, at corners that only one of the meshes has, and
// by roundings of the level of light, which is a mean over other elements.
Test(light_parts, pictures_are_those_of_the_whole, .timeout = 240) {
    Apart *a = load();
    Error error = {""};
    const char *folder[2] = {support_folder(&a->arena), support_folder(&a->arena)};
    WalkTotals parted = draw(&a->parted, folder[0], &a->arena), whole = draw(&a->whole, folder[1], &a->arena);
    cr_assert_eq(parted.images, whole.images);
    cr_assert_geq(parted.images, PICTURES);
    long off = 0, pixels = 0;
    double mean = 0;
    for (int i = 0; i < parted.images; i++) {
        uint8_t *rgb[2];
        for (int k = 0; k < 2; k++) {
            int width, height;
            const char *path = arena_format(&a->arena, "%s/frame-%05d.png", folder[k], i);
            cr_assert(image_read_png(path, &a->arena, &rgb[k], &width, &height, &error), "%s", error.text);
        }
        for (int p = 0; p < 3 * WIDE * HIGH; p++) {
            int by = abs(rgb[0][p] - rgb[1][p]);
            off += by > 4;
            mean += by;
            pixels++;
        }
    }
    printf("%d pictures: %.3g %% of the values are more than 4 of 255 off, %.2g in the mean\n", parted.images,
           100.0 * (double)off / (double)pixels, mean / (double)pixels);
    cr_expect_leq((double)off, 0.002 * (double)pixels);
    cr_expect_leq(mean / (double)pixels, 1);
    end(a);
}

static const LitMesh *load_part(const Apart *a, int part, Arena *arena, LitLight *out) {
    Error error = {""};
    warned[0] = 0;
    const LightOfParts *parts = a->parted.baker.parts;
    const LitMesh *lit = lit_read_drawn(parts, part, arena, out);
    if (!lit) lit = lit_make_drawn(parts, part, arena, out, &error);
    cr_assert(lit, "%s", error.text);
    return lit;
}

static bool same_faces(const LitMesh *a, const LitMesh *b) {
    if (a->face_count != b->face_count) return false;
    for (int f = 0; f <= a->face_count; f++) {
        const LitFace *x = &a->faces[f], *y = &b->faces[f];
        if (memcmp(&x->plane, &y->plane, sizeof x->plane) != 0 || x->polygon != y->polygon ||
            x->material != y->material || x->first_vertex != y->first_vertex ||
            x->first_index != y->first_index || x->first_element != y->first_element ||
            x->element_count != y->element_count || x->lamp != y->lamp || x->outdoors != y->outdoors)
            return false;
    }
    return memcmp(a->first_face, b->first_face,
                  ((size_t)a->graph->polygon_count + 1) * sizeof *a->first_face) == 0;
}

#define SAME(a, b, count) (memcmp(a, b, (size_t)(count) * sizeof *(a)) == 0)
static bool same_drawn(const LitMesh *a, const LitLight *x, const LitMesh *b, const LitLight *y) {
    return same_faces(a, b) && a->element_count == b->element_count && a->lamp_count == b->lamp_count &&
           SAME(a->lamp, b->lamp, a->lamp_count) && SAME(a->vertex, b->vertex, lit_vertex_count(a)) &&
           SAME(a->index, b->index, a->faces[a->face_count].first_index) &&
           SAME(a->spot, b->spot, a->element_count) && SAME(&a->origin, &b->origin, 1) &&
           SAME(x->vertex, y->vertex, lit_vertex_count(a)) && SAME(x->on, y->on, a->lamp_count) &&
           SAME(x->luminous, y->luminous, a->element_count) && SAME(&x->day, &y->day, 1) &&
           x->level == y->level && SAME(x->ranges, y->ranges, FALSE_COLOURS) &&
           SAME(x->doors, y->doors, a->graph->building->opening_count);
}

static void copy_file(const char *from, const char *to, int flip, Arena *arena) {
    Error error = {""};
    Bytes file;
    cr_assert(file_read(from, (size_t)1 << 30, arena, &file, &error), "%s", error.text);
    if (flip >= 0) file.data[flip] ^= 1;
    cr_assert(file_write(to, file.data, file.size, &error), "%s", error.text);
}

// Proves that what a part's file holds as it is drawn is, to the last bit, what is made from its light; and that such a file which is
// missing, damaged, of other light or of other lamps is passed over, with a sentence if it is there.
Test(light_parts, are_stored_as_they_are_drawn, .timeout = 240) {
    Apart *a = load();
    Arena arena = {0};
    LitLight read, made, again;
    LoadedScene *scene = (LoadedScene *)a->parted.scene;
    const char *rad = light_parts_file(a->parted.baker.parts, 0, &arena),
               *drawn = arena_format(&arena, "%s.lit", rad), *beside = arena_format(&arena, "%s.kept", drawn);
    const LitMesh *of_file = load_part(a, 0, &arena, &read);
    cr_assert_eq(rename(drawn, beside), 0);
    const LitMesh *of_light = load_part(a, 0, &arena, &made);
    cr_expect_str_empty(warned);
    cr_expect(same_drawn(of_file, &read, of_light, &made));
    static const struct {
        int flip;
        const char *why;
    } DAMAGE[] = {{-1, ""}, {60, "header's checksum"}, {1000, "its checksum is wrong"}};
    for (size_t i = 0; i < sizeof DAMAGE / sizeof *DAMAGE; i++) {
        copy_file(beside, drawn, DAMAGE[i].flip, &arena);
        cr_expect(same_drawn(load_part(a, 0, &arena, &again), &again, of_light, &made));
        cr_expect(strstr(warned, DAMAGE[i].why) && !warned[0] == !DAMAGE[i].why[0], "%s", warned);
    }
    Error error = {""};
    uint64_t of_rad;
    cr_assert(rad_checksum(rad, &scene->building, &of_rad, &error), "%s", error.text);
    copy_file(beside, drawn, -1, &arena);
    cr_expect(lit_read_part(scene, drawn, of_rad, &arena, &again, &error), "%s", error.text);
    cr_expect_null(lit_read_part(scene, drawn, of_rad + 1, &arena, &again, &error));
    cr_expect(strstr(error.text, "is not of this light"), "%s", error.text);
    scene->lit[0].g = 0.5f;
    cr_expect_null(lit_read_drawn(a->parted.baker.parts, 0, &arena, &again));
    cr_expect_null(lit_make_drawn(a->parted.baker.parts, 0, &arena, &again, &error));
    cr_expect(strstr(warned, "with other lamps on"), "%s", warned);
    cr_expect(strstr(error.text, "was made with lamp 1"), "%s", error.text);
    arena_free(&arena);
    end(a);
}

// The light of a part on its mesh: all of it is read, as the walk does while it uploads.
static double read_light(const LitMesh *mesh, const LitLight *light) {
    double sum = 0;
    for (int v = 0; v < lit_vertex_count(mesh); v++)
        sum += (double)light->vertex[v][0] * (double)mesh->vertex[v].normal[2];
    return sum;
}

static LitMesh *get(LitParts *parts, int part, int held, LitLight *out) {
    Error error = {""};
    LitMesh *mesh = lit_parts_get(parts, part, held, out, &error);
    cr_assert(mesh, "%s", error.text);
    return mesh;
}

// Proves that a part which was read stays where it is, and is not read again, while there is room; that where another one would fill
// more than three quarters of the budget those wanted longest ago are dropped, never the one that is held; that all memory comes back; and
// that it is told once where files are missing.
Test(light_parts, stay_in_memory_while_there_is_room, .timeout = 240) {
    Apart *a = load();
    Arena arena = {0};
    LitLight light;
    cr_assert_geq(a->report.parts, 3);
    LitParts *parts = lit_parts_new(a->parted.baker.parts, &arena);
    size_t before = memory_used();
    const LitMesh *first = get(parts, 0, -1, &light);
    double sum = read_light(first, &light);
    get(parts, 1, -1, &light);
    cr_expect_eq(get(parts, 0, -1, &light), first);
    cr_expect_eq(lit_parts_count(parts).wanted, 3);
    cr_expect_eq(lit_parts_count(parts).read, 2);
    cr_expect_eq(lit_parts_count(parts).kept, 2);
    // Room for part 2 once part 1, which was wanted longest ago, is gone.
    size_t room = memory_used() + lit_part_size(a->parted.baker.parts, 2) -
                  lit_part_size(a->parted.baker.parts, 1) * 9 / 10;
    MemoryBudget tight = {
        .file = "a test", .remedy = "none", .base = room / 3 * 4, .most = SIZE_MAX, .gentle = true};
    memory_set_budget(&tight);
    get(parts, 2, -1, &light);
    cr_expect_eq(lit_parts_count(parts).kept, 2);
    cr_expect_eq(get(parts, 0, -1, &light), first);
    cr_expect_eq(read_light(first, &light), sum);
    cr_expect_eq(lit_parts_count(parts).read, 3);
    // Room for what is there: each time all go but the one that is held, though it was wanted longest ago.
    tight.base = memory_used() / 3 * 4;
    memory_set_budget(&tight);
    get(parts, 2, -1, &light);
    get(parts, 1, 0, &light);
    cr_expect_eq(lit_parts_count(parts).read, 4);
    cr_expect_eq(get(parts, 0, 1, &light), first);
    cr_expect_eq(lit_parts_count(parts).read, 4);
    get(parts, 2, 1, &light);
    cr_expect_eq(read_light(get(parts, 0, -1, &light), &light), sum);
    cr_expect_eq(lit_parts_count(parts).read, 6);
    memory_set_budget(NULL);
    lit_parts_free(parts);
    cr_expect_eq(memory_used(), before);
    cr_expect_eq(lit_parts_count(parts).kept, 0);
    // Where files as drawn are missing, that is told once.
    for (int part = 0; part < 2; part++) {
        const char *rad = light_parts_file(a->parted.baker.parts, part, &arena);
        cr_assert_eq(remove(arena_format(&arena, "%s.lit", rad)), 0);
        warned[0] = 0;
        get(parts, part, -1, &light);
        cr_expect_eq(strstr(warned, "has no file .lit beside it") != NULL, part == 0, "%s", warned);
    }
    lit_parts_free(parts);
    arena_free(&arena);
    end(a);
}

// Waits until the light of a part waits to be taken.
static bool comes(const LightThread *thread, int part) {
    double start = clock_seconds();
    while (light_thread_part(thread) != part && clock_seconds() < start + 60) light_thread_check_nap();
    return light_thread_part(thread) == part;
}

// The light of a part, read by itself.
static double sum_of_part(const Apart *a, int part) {
    Arena arena = {0};
    WalkLight light;
    Error error;
    cr_assert(light_load_part(a->parted.baker.parts, part, &arena, &light, &error), "%s", error.text);
    LitMesh *mesh = lit_mesh_new(light.mesh, &arena, &arena);
    LitLight state = lit_light_new(mesh, &arena);
    lit_light_fill(mesh, light.solution, light.door_open, &state);
    double sum = read_light(mesh, &state);
    arena_free(&arena);
    return sum;
}

// Proves that a part is there when it is asked for, on a mesh of its own with the level of the whole; that of the part only what is drawn
// is kept; that the part which the walk holds
// stays as it is while others come, and are dropped untaken; and that the thread ends whatever it is at.
Test(light_parts, a_thread_reads_one_after_another, .timeout = 240) {
    Apart *a = load();
    Arena arena = {0};
    LightThread *thread = light_thread_start(&a->parted.baker, NULL, NULL, &arena);
    cr_assert(thread);
    cr_assert_geq(a->report.parts, 3);
    cr_expect_eq(light_thread_part(thread), -1);
    light_thread_ask_part(thread, 0);
    cr_assert(comes(thread, 0));
    cr_expect_eq(light_thread_end(thread), LIGHT_READY);
    const LitLight *held = light_thread_light(thread);
    LitMesh *mesh = light_thread_mesh(thread);
    cr_assert(held && mesh);
    cr_expect_null(mesh->mesh);
    cr_expect_float_eq(held->level, a->whole.light ? light_parts_level(a->parted.baker.parts) : 0, 0);
    double sum = read_light(mesh, held),
           of_part[3] = {sum_of_part(a, 0), sum_of_part(a, 1), sum_of_part(a, 2)};
    cr_expect_eq(sum, of_part[0]);
    light_thread_received(thread);
    for (int i = 0; i < 4; i++) {
        int part = 1 + i % 2;
        light_thread_ask_part(thread, part);
        cr_assert(comes(thread, part), "part %d", part);
        cr_expect_eq(read_light(light_thread_mesh(thread), light_thread_light(thread)), of_part[part]);
        cr_expect_eq(read_light(mesh, held), sum);
    }
    // The one that is held is asked for again: what waits is dropped, and nothing comes.
    light_thread_ask_part(thread, 0);
    cr_expect_null(light_thread_light(thread));
    light_thread_ask_part(thread, 1);
    cr_assert(comes(thread, 1));
    held = light_thread_light(thread);
    mesh = light_thread_mesh(thread);
    sum = read_light(mesh, held);
    light_thread_received(thread);
    light_thread_ask_part(thread, 0);
    cr_assert(comes(thread, 0));
    cr_expect_eq(read_light(mesh, held), sum);
    light_thread_ask_part(thread, 2);
    light_thread_stop(thread);
    cr_expect(light_thread_free(thread, 60));
    // A part that cannot be read ends it, with a sentence.
    const char *path = a->parted.scene->lights[0];
    LightParts stored;
    Error error;
    cr_assert(light_parts_load(path, &a->parted.scene->building, &stored, &error));
    cr_assert(file_write(kept_file(kept_folder(path, &arena), stored.set, 1, stored.parts, &arena), "x", 1,
                         &error));
    thread = light_thread_start(&a->parted.baker, NULL, NULL, &arena);
    light_thread_ask_part(thread, 1);
    double start = clock_seconds();
    while (light_thread_end(thread) == LIGHT_UNDER_WAY && clock_seconds() < start + 60)
        light_thread_check_nap();
    cr_expect_eq(light_thread_end(thread), LIGHT_FAILED);
    cr_expect(strstr(light_thread_note(thread), "-1-of-"), "%s", light_thread_note(thread));
    light_thread_stop(thread);
    cr_expect(light_thread_free(thread, 60));
    arena_free(&arena);
    end(a);
}
