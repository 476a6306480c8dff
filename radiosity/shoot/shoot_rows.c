// shoot_rows.c - rows made in parallel, each by one thread with a viewer and a form-factor method of its own, so that a
// row depends on its patch alone. The first ones are kept until their memory is spent: a patch that was strong early
// shoots again and again. Those that come later stay until they are shot.
#include "radiosity/shoot/shoot_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/factors/lamp_spread.h"
#include "radiosity/factors/near_pairs.h"
#include "radiosity/mesh/lines.h"

// Rows made at a time by each thread. Where they are kept hardly one is in vain, as most patches shoot in the end; and the more
// there are, the more of them are neighbours, whose faces are in the cache from the last one: a sixth less time.
// But nobody should wait long to be shown how far it is, or to stop it: of rows that see much, there are fewer.
enum { AHEAD_FIRST = 64, AHEAD_MOST = 4096, AHEAD_PASSING = 4 };
// Rows that wait for their shots where there is no room to keep more, of each thread: nearly all are shot before so many came.
enum { WAITING = 64 };
static const double FACES_AHEAD = 1 << 20;  // of all their views: about half a second
// The most that the rows of lamps may cost, in rows of the usual resolution.
static const double MOST_LAMP_WORK = 4000;
// Kept rows lie in blocks of so many bytes, or more.
static const size_t BLOCK_BYTES = (size_t)1 << 20;

// One thread's tools, and the rows it keeps.
typedef struct Maker {
    Arena arena, kept;
    Viewer *viewer;
    FormFactor *form_factor, *of_lamps, *of_small;
    NearPairs *near;      // NULL: patches are points
    SpreadRows *spreads;  // of lamps by candela tables; NULL: there are none
    char *block;          // where its next kept row goes
    size_t block_left;    // bytes
    size_t kept_bytes;    // of all its blocks
    long long kept_count, made_bytes, faces;
    Panes panes;  // before the patch whose row is made
    double seconds_visibility;
    long long elements_drawn;  // by tools that are gone
} Maker;

// A row that is being made, or that waits for its shot because there was no room to keep it.
typedef struct Slot {
    ShootRow *row;
    int patch;
    Arena arena;   // of a row that is not kept
    bool waiting;  // it is not, and was not shot yet
} Slot;

// The fate of an element's share.
typedef struct Taker {
    int patch;
    float per_area;  // 1/m^2
} Taker;

// Data that all makers share: lines and shapes.
enum { SHARED = 2 };

struct ShootRows {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    Arena shared[SHARED];
    FaceLines lines;
    NearShapes *shapes;  // NULL: patches are points
    Taker *takers;       // [element_count]
    Vec3 *middles;       // [element_count]
    const RadOptions *options;
    FormFactorOptions usual, of_lamps, of_small;
    int threads, slot_count, waiting_count;
    Maker *makers;    // [threads]
    Slot *slots;      // [slot_count]
    int *making;      // [slot_count] those of the rows that are made at a time
    ShootRow **of;    // [patch_count] NULL: not there
    bool *there;      // [patch_count]
    bool *strong;     // [patch_count]
    bool *fine;       // [patch_count] the row has as many directions as those of lamps
    uint64_t *doors;  // [patch_count * door_words] those that the row depends on, as in View
    int door_words;   // of a part of a building 0: its light does not follow doors
    bool equipped;    // lines, shapes and the makers' tools are there
    bool full, settled;
    bool any_spread;  // lamps send their light by candela tables
    long long made;
};

// A lamp's light is not one of many as the light of walls is: its samples err alone. Where lamps are very many, they are.
static int lamp_resolution(const Mesh *mesh, const RadOptions *options) {
    double lamps = 0;
    int detail = options->lamp_detail, resolution = options->form_factor.resolution;
    for (int p = 0; p < mesh->patch_count; p++)
        lamps += mesh_is_lamp(mesh, mesh->patches[p].face) && mesh_owns(mesh, mesh->patches[p].face);
    if (options->borders) team_sum(borders_member(options->borders), &lamps, 1);
    while (detail > 1 && lamps * detail * detail > MOST_LAMP_WORK) detail /= 2;
    while (detail > 1 && resolution * detail > FORM_FACTOR_FINEST) detail--;
    return detail > 1 ? resolution * detail : resolution;
}

// Patches of things smaller than this, m^2, have half as many directions each way: each has little light to shoot. With four times this,
// light in narrow places is farther off (test_narrow.c).
static const double SMALL = 0.0025;

static bool is_small(const Mesh *mesh, int patch) {
    const Patch *p = &mesh->patches[patch];
    return p->area < SMALL && mesh->graph->objects[mesh->faces[p->face].object].kind != OBJECT_SURFACE;
}

static int small_resolution(const RadOptions *options) {
    int least = 8, half = options->form_factor.resolution / 2;
    return half < least ? least : half;
}

// Data that all makers share, and data that each has for itself.
static void share_or_equip(void *context, int index, int thread) {
    (void)thread;
    ShootRows *rows = context;
    if (index == 0) {
        rows->lines = lines_of_mesh(rows->mesh, &rows->shared[0]);
    } else if (index == 1) {
        if (rows->options->reach > 0) rows->shapes = near_shapes(rows->mesh, &rows->shared[1]);
    } else {
        Maker *maker = &rows->makers[index - SHARED];
        maker->viewer = viewer_new(rows->mesh, rows->forest, rows->door_open, &maker->arena);
    }
}

static void equip_maker(void *context, int index, int thread) {
    (void)thread;
    ShootRows *rows = context;
    const FormFactorMethod *method = rows->options->method;
    Maker *maker = &rows->makers[index];
    if (rows->shapes)
        maker->near = near_pairs_new(rows->mesh, rows->shapes, rows->options->reach, &maker->arena);
    int openings = rows->mesh->graph->building->opening_count, panes = rows->mesh->panes.count;
    maker->panes.panes = ARENA_ARRAY(&maker->arena, Pane, (panes > openings ? panes : openings) + 1);
    FormFactorOptions usual = rows->usual, of_lamps = rows->of_lamps, of_small = rows->of_small;
    if (usual.day) usual.panes = of_lamps.panes = of_small.panes = &maker->panes;
    maker->form_factor = form_factor_new(method, rows->mesh, &usual, &maker->arena);
    maker->of_lamps = maker->form_factor;
    if (of_lamps.resolution != usual.resolution)
        maker->of_lamps = form_factor_new(method, rows->mesh, &of_lamps, &maker->arena);
    maker->of_small = form_factor_new(method, rows->mesh, &of_small, &maker->arena);
    if (rows->any_spread) maker->spreads = spread_rows_new(rows->mesh, &of_lamps, &maker->arena);
}

static void equip(ShootRows *rows) {
    if (rows->equipped) return;
    parallel_for(rows->threads, rows->threads + SHARED, share_or_equip, rows);
    parallel_for(rows->threads, rows->threads, equip_maker, rows);
    rows->equipped = true;
}

static long long elements_drawn(const ShootRows *rows, const Maker *maker) {
    if (!rows->equipped) return maker->elements_drawn;
    long long drawn = maker->elements_drawn + form_factor_work(maker->form_factor).elements_drawn +
                      form_factor_work(maker->of_small).elements_drawn;
    if (maker->of_lamps != maker->form_factor) drawn += form_factor_work(maker->of_lamps).elements_drawn;
    return drawn;
}

void shoot_rows_rest(ShootRows *rows) {
    for (int t = 0; t < rows->threads && rows->equipped; t++) {
        Maker *maker = &rows->makers[t];
        maker->elements_drawn = elements_drawn(rows, maker);
        if (maker->of_lamps != maker->form_factor) form_factor_end(maker->of_lamps);
        form_factor_end(maker->of_small);
        if (maker->spreads) spread_rows_end(maker->spreads);
        form_factor_end(maker->form_factor);
        arena_free(&maker->arena);
    }
    for (int i = 0; i < SHARED; i++) arena_free(&rows->shared[i]);
    rows->equipped = false;
}

ShootRows *shoot_rows_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                          const RadOptions *options, const Daylight *day, Arena *arena) {
    ShootRows *rows = ARENA_ARRAY(arena, ShootRows, 1);
    rows->mesh = mesh;
    rows->forest = forest;
    rows->door_open = door_open;
    rows->options = options;
    rows->takers = ARENA_ARRAY(arena, Taker, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++)
        rows->takers[e] = (Taker){mesh->elements[e].patch, (float)(1 / mesh->elements[e].area)};
    rows->middles = ARENA_ARRAY(arena, Vec3, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) rows->middles[e] = element_centroid(mesh, e);
    rows->usual = options->form_factor;
    rows->usual.lines = &rows->lines;
    if (daylight_shines(day)) rows->usual.day = day;
    rows->of_lamps = rows->usual;
    rows->of_lamps.resolution = lamp_resolution(mesh, options);
    rows->of_small = rows->usual;
    rows->of_small.resolution = small_resolution(options);
    for (int f = 0; f < mesh->face_count; f++) rows->any_spread = rows->any_spread || mesh_spread(mesh, f);
    rows->threads = parallel_threads(options->threads);
    rows->makers = ARENA_ARRAY(arena, Maker, rows->threads);
    rows->slot_count = AHEAD_MOST * rows->threads;
    rows->slots = ARENA_ARRAY(arena, Slot, rows->slot_count);
    rows->making = ARENA_ARRAY(arena, int, rows->slot_count);
    rows->of = ARENA_ARRAY(arena, ShootRow *, mesh->patch_count);
    rows->there = ARENA_ARRAY(arena, bool, mesh->patch_count);
    rows->strong = ARENA_ARRAY(arena, bool, mesh->patch_count);
    rows->fine = ARENA_ARRAY(arena, bool, mesh->patch_count);
    rows->door_words = options->borders ? 0 : viewer_door_words(mesh);
    rows->doors = ARENA_ARRAY(arena, uint64_t, (size_t)mesh->patch_count * (size_t)rows->door_words + 1);
    rows->full = options->row_bytes == 0;
    // So that a byte tells which element of its patch one is.
    for (int p = 0; p < mesh->patch_count; p++)
        CORE_ASSERT(mesh->patches[p].element_count <= MESH_MOST_IN_PATCH);
    return rows;
}

void shoot_rows_end(ShootRows *rows) {
    shoot_rows_rest(rows);
    for (int t = 0; t < rows->threads; t++) arena_free(&rows->makers[t].kept);
    for (int i = 0; i < rows->slot_count; i++) arena_free(&rows->slots[i].arena);
}

int shoot_rows_most(const ShootRows *rows) { return rows->slot_count; }

// Each thread's part of the memory for rows.
static size_t share_of(const ShootRows *rows) { return rows->options->row_bytes / (size_t)rows->threads; }

int shoot_rows_wanted(const ShootRows *rows) {
    if (rows->full) return AHEAD_PASSING * rows->threads;
    if (rows->made == 0) return AHEAD_FIRST * rows->threads;
    double faces = 0, bytes = 0, left = 0;
    for (int t = 0; t < rows->threads; t++) {
        const Maker *maker = &rows->makers[t];
        faces += (double)maker->faces;
        bytes += (double)maker->made_bytes;
        left += (double)(share_of(rows) - maker->kept_bytes + maker->block_left);
    }
    double made = (double)rows->made;
    double wanted = fmin(FACES_AHEAD * rows->threads * made / (faces + 1), left * made / (bytes + 1));
    return (int)fmax(fmin(wanted, rows->slot_count), AHEAD_PASSING * rows->threads);
}

const bool *shoot_rows_there(const ShootRows *rows) { return rows->there; }

const ShootRow *shoot_rows_of(const ShootRows *rows, int patch) { return rows->of[patch]; }

static size_t row_bytes(int runs, int elements, int sky_parts) {
    size_t run = sizeof(ShootRun) + sizeof(uint8_t), element = sizeof(float) + sizeof(uint8_t);
    size_t bytes = sizeof(ShootRow) + (size_t)runs * run + (size_t)elements * element +
                   (size_t)sky_parts * sizeof(SkyPart);
    return (bytes + sizeof(double) - 1) / sizeof(double) * sizeof(double);
}

// Where the parts of a row lie behind it.
static void place_row(ShootRow *row, int runs, int elements, int sky_parts) {
    row->runs = (ShootRun *)(row + 1);
    row->density = (float *)(row->runs + runs);
    row->sky_part = (SkyPart *)(row->density + elements);
    row->count = (uint8_t *)(row->sky_part + sky_parts);
    row->offset = row->count + runs;
}

// How many elements ahead their takers are asked for, which lie all over memory.
enum { TAKERS_AHEAD = 24 };
// Runs of one length lie together, all longer ones too: loops over them take no guesses where they end.
enum { RUN_LENGTHS = 8 };

// For each length, runs and their elements: how many, or where the next one goes.
typedef struct Runs {
    int count;
    int run[RUN_LENGTHS], element[RUN_LENGTHS];
} Runs;

static int kind_of(int length) { return (length < RUN_LENGTHS ? length : RUN_LENGTHS) - 1; }

// Where the run ends that begins at `first`.
static int end_of_run(const ShootRows *rows, const Row *row, int first) {
    int patch = rows->takers[row->element[first]].patch, end = first + 1;
    while (end < row->count && rows->takers[row->element[end]].patch == patch) end++;
    return end;
}

static Runs count_runs(const ShootRows *rows, const Row *row) {
    Runs runs = {0};
    for (int i = 0; i < row->count && i < TAKERS_AHEAD; i++)
        __builtin_prefetch(&rows->takers[row->element[i]]);
    for (int first = 0, end; first < row->count; first = end) {
        end = end_of_run(rows, row, first);
        for (int i = first; i < end && i + TAKERS_AHEAD < row->count; i++)
            __builtin_prefetch(&rows->takers[row->element[i + TAKERS_AHEAD]]);
        int kind = kind_of(end - first);
        runs.count++;
        runs.run[kind]++;
        runs.element[kind] += end - first;
    }
    return runs;
}

static void lay_out(Runs *runs) {
    for (int kind = 0, run = 0, element = 0; kind < RUN_LENGTHS; kind++) {
        int run_count = runs->run[kind], element_count = runs->element[kind];
        runs->run[kind] = run;
        runs->element[kind] = element;
        run += run_count;
        element += element_count;
    }
}

// `panes` are those before the patch: they let through a share of each element's light, by the line between both middles. The rest counts
// as met by backs: it is absorbed.
static void copy_row(const ShootRows *rows, const Row *from, Runs runs, const Patch *of, const Panes *panes,
                     ShootRow *to) {
    place_row(to, runs.count, from->count, from->sky_part_count);
    lay_out(&runs);
    double sum = from->back + from->escaped, kept = 0;
    to->run_count = runs.count;
    to->element_count = from->count;
    for (int first = 0, end; first < from->count; first = end) {
        end = end_of_run(rows, from, first);
        int patch = rows->takers[from->element[first]].patch, kind = kind_of(end - first);
        int first_element = rows->mesh->patches[patch].first_element;
        double share = 0;
        for (int i = first; i < end; i++) {
            int at = runs.element[kind]++;
            float factor = from->factor[i];
            if (panes->count > 0 || panes->rooms) {
                factor *= (float)panes_transmit_between(panes, of->centre, of->cell,
                                                        rows->middles[from->element[i]],
                                                        rows->mesh->patches[patch].cell);
                kept += (double)from->factor[i] - (double)factor;
            }
            share += (double)factor;
            to->density[at] = factor * rows->takers[from->element[i]].per_area;
            to->offset[at] = (uint8_t)(from->element[i] - first_element);
        }
        int run = runs.run[kind]++;
        to->count[run] = (uint8_t)(end - first - 1);
        to->runs[run] = (ShootRun){patch, (float)share};
        sum += (double)(float)share;
    }
    sum += kept;
    CORE_ASSERT(sum > 0.5 && sum < 2);  // a method's row sums to 1
    to->back = from->back + kept;
    to->escaped = from->escaped;
    to->sky_light = from->sky_light;
    to->ground_light = from->ground_light;
    to->sky_part_count = from->sky_part_count;
    if (to->sky_part_count > 0) {
        memcpy(to->sky_part, from->sky_part, (size_t)to->sky_part_count * sizeof *to->sky_part);
        sky_parts_fit(to->sky_part, to->sky_part_count, rows->usual.day, to->sky_light);
    }
    to->scale = 1 / sum;
}

// Room for a row among those its maker keeps; NULL: its part of the memory for rows is spent.
static ShootRow *keep(const ShootRows *rows, Maker *maker, size_t bytes) {
    if (bytes > maker->block_left) {
        size_t share = share_of(rows);
        size_t block = share < BLOCK_BYTES ? share : BLOCK_BYTES;
        if (block < bytes) block = bytes;
        if (maker->kept_bytes + block > share) return NULL;
        maker->block = arena_alloc(&maker->kept, block, 1);
        maker->block_left = block;
        maker->kept_bytes += block;
    }
    ShootRow *row = (ShootRow *)maker->block;
    maker->block += bytes;
    maker->block_left -= bytes;
    maker->kept_count++;
    return row;
}

// ---- strong patches

// So many patches may be strong, as a share of all: the rows of all others cost about as much as theirs.
static const double MOST_STRONG = 0.02;
// A patch is strong if it reflects so many times the light that a patch of its cell reflects in the mean.
static const double STRONG = 6;
// A cell in which less light falls than this share of the mean counts as one with so much.
static const double DIM = 0.05;

// Light and area of the patches in front of each cell, the last of those in none; and of all.
typedef struct CellLight {
    double *light, *area, all[2];
} CellLight;

static CellLight light_of_cells(const ShootRows *rows, const double *power, Arena *arena) {
    const Mesh *mesh = rows->mesh;
    int cells = mesh->graph->cell_count;
    CellLight out = {ARENA_ARRAY(arena, double, cells + 1), ARENA_ARRAY(arena, double, cells + 1), {0, 0}};
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        bool own = mesh_owns(mesh, patch->face);
        // Those in a cell of this part are all in its mesh.
        if (!own && patch->cell < 0) continue;
        int cell = patch->cell < 0 ? cells : patch->cell;
        out.light[cell] += power[p];
        out.area[cell] += patch->area;
        if (own) out.all[0] += power[p], out.all[1] += patch->area;
    }
    if (rows->options->borders) {
        double sums[4] = {out.all[0], out.all[1], out.light[cells], out.area[cells]};
        team_sum(borders_member(rows->options->borders), sums, 4);
        out.all[0] = sums[0], out.all[1] = sums[1];
        out.light[cells] = sums[2], out.area[cells] = sums[3];
    }
    return out;
}

void shoot_rows_find_strong(ShootRows *rows, const RadSolution *solution) {
    const Mesh *mesh = rows->mesh;
    const Borders *borders = rows->options->borders;
    Arena scratch = {0};
    int cells = mesh->graph->cell_count, count = mesh->patch_count, strong = 0;
    double *power = ARENA_ARRAY(&scratch, double, count + 1),
           *times = ARENA_ARRAY(&scratch, double, count + 1),
           *list = ARENA_ARRAY(&scratch, double, count + 1), patches = 0;
    for (int p = 0; p < count; p++) {
        const Patch *patch = &mesh->patches[p];
        if (!mesh_owns(mesh, patch->face)) continue;
        patches++;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            power[p] +=
                (rgb_sum(solution->direct[e]) + rgb_sum(solution->daylight[e])) * mesh->elements[e].area;
    }
    if (borders) {
        borders_fetch(borders, &BORDER_VALUE(BORDER_PATCH, power), 1);
        team_sum(borders_member(borders), &patches, 1);
    }
    CellLight cell_light = light_of_cells(rows, power, &scratch);
    for (int p = 0; p < count; p++) {
        const Patch *patch = &mesh->patches[p];
        int cell = patch->cell < 0 ? cells : patch->cell;
        if (!mesh_owns(mesh, patch->face) || mesh_is_lamp(mesh, patch->face)) continue;
        double mean =
            fmax(cell_light.light[cell] / cell_light.area[cell], DIM * cell_light.all[0] / cell_light.all[1]);
        times[p] = mean > 0 ? power[p] / patch->area / mean : 0;
        if (times[p] > STRONG) list[strong++] = times[p];
    }
    double least = borders_least(borders, list, strong, MOST_STRONG * patches);
    for (int p = 0; p < count; p++) {
        if (!(times[p] > STRONG && times[p] >= least)) continue;
        shoot_rows_refine(rows, p);
        rows->strong[p] = true;
    }
    arena_free(&scratch);
}

const bool *shoot_rows_strong(const ShootRows *rows) { return rows->strong; }

void shoot_rows_settle(ShootRows *rows) { rows->settled = true; }
bool shoot_rows_settled(const ShootRows *rows) { return rows->settled; }

// With shifts, patches of four rows and four columns of a face have samples shifted each by other parts of a pixel, any two side by side by
// half a pixel. Faces of one patch differ by their numbers in the building, which are the same in every part of it.
static int shift_of(const Mesh *mesh, const Patch *patch) {
    static const int FAR[4] = {0, 2, 1, 3};
    const Face *face = &mesh->faces[patch->face];
    Vec3 at = vec3_sub(patch->centre, face->origin);
    double squares = patch->area * vec3_length(face->gx) * vec3_length(face->gy), root = face->root;
    // A patch that is cut, down to a third of its square, counts as the whole square.
    double side = root * exp2(-floor(log2(root * root / squares) / 2 + 0.25));
    int number = face->polygon >= 0 ? face->polygon : face->object;
    int x = (int)floor(vec3_dot(face->gx, at) / side) + number,
        y = (int)floor(vec3_dot(face->gy, at) / side) + number / 4;
    return FAR[y & 3] * 4 + FAR[x & 3];
}

static void make_row(void *context, int index, int thread) {
    ShootRows *rows = context;
    Maker *maker = &rows->makers[thread];
    Slot *slot = &rows->slots[rows->making[index]];
    const Patch *patch = &rows->mesh->patches[slot->patch];
    ViewPoint from = {patch->centre, rows->mesh->faces[patch->face].plane.n, patch->cell};
    bool lamp = rows->fine[slot->patch] || mesh_is_lamp(rows->mesh, patch->face);
    panes_seen(&rows->mesh->panes, rows->forest, patch->cell, rows->mesh->faces[patch->face].plane,
               &maker->panes);
    FormFactor *form_factor = lamp                                ? maker->of_lamps
                              : is_small(rows->mesh, slot->patch) ? maker->of_small
                                                                  : maker->form_factor;
    double (*now)(void) = rows->options->clock, start = now ? now() : 0;
    const View *view = form_factor_look(form_factor, maker->viewer, &from, rows->options->culling);
    if (now) maker->seconds_visibility += now() - start;
    bool spread = mesh_spread(rows->mesh, patch->face) != NULL;
    const Row *row = spread ? spread_row(maker->spreads, maker->viewer, rows->options->culling, slot->patch)
                            : form_factor_row_shifted(form_factor, view, shift_of(rows->mesh, patch));
    uint64_t *doors = rows->doors + (size_t)slot->patch * (size_t)rows->door_words;
    for (int i = 0; i < rows->door_words; i++) doors[i] = view->doors ? view->doors[i] : UINT64_MAX;
    // A row may list more faces.
    maker->faces += view->face_count;
    if (maker->near && !spread) row = near_pairs_row(maker->near, slot->patch, row);
    Runs runs = count_runs(rows, row);
    size_t bytes = row_bytes(runs.count, row->count, row->sky_part_count);
    maker->made_bytes += (long long)bytes;
    slot->row = keep(rows, maker, bytes);
    slot->waiting = !slot->row;
    if (slot->waiting) {
        arena_reset(&slot->arena);
        slot->row = arena_alloc(&slot->arena, bytes, 1);
    }
    copy_row(rows, row, runs, patch, &maker->panes, slot->row);
}

// ---- closed rooms

// Takes the elements behind black panes out of a row, in its place. Runs lie by length, which does not matter to who reads them.
static void close_row(const ShootRows *rows, ShootRow *row, const Patch *of, const Panes *black) {
    ShootRow to = {0};
    double kept = 0;
    for (int r = 0, at = 0; r < row->run_count; r++) {
        ShootRun run = row->runs[r];
        const Patch *patch = &rows->mesh->patches[run.patch];
        int count = row->count[r] + 1, first = to.element_count;
        double share = 0;
        for (int i = at; i < at + count; i++) {
            int e = patch->first_element + row->offset[i];
            float density = row->density[i];
            if (panes_transmit_between(black, of->centre, of->cell, rows->middles[e], patch->cell) == 0)
                continue;
            row->density[to.element_count] = density;
            row->offset[to.element_count++] = row->offset[i];
            share += (double)density * rows->mesh->elements[e].area;
        }
        at += count;
        int left = to.element_count - first;
        kept += (double)run.share;
        if (left == 0) continue;
        // A whole run has the share that it had, to the last bit.
        if (left < count) run.share = (float)share;
        kept -= (double)run.share;
        row->count[to.run_count] = (uint8_t)(left - 1);
        row->runs[to.run_count++] = run;
    }
    row->run_count = to.run_count;
    row->element_count = to.element_count;
    row->back += kept;
}

static void close_patch(void *context, int index, int thread) {
    ShootRows *rows = context;
    ShootRow *row = rows->of[index];
    if (!row) return;
    Panes *panes = &rows->makers[thread].panes;
    const Patch *patch = &rows->mesh->patches[index];
    panes_seen(&rows->mesh->panes, rows->forest, patch->cell, rows->mesh->faces[patch->face].plane, panes);
    int black = 0;
    for (int i = 0; i < panes->count; i++)
        if (panes->panes[i].room >= 0) panes->panes[black++] = panes->panes[i];
    panes->count = black;
    close_row(rows, row, patch, panes);
}

void shoot_rows_close(ShootRows *rows, const Mesh *closed) {
    equip(rows);
    rows->mesh = closed;
    for (int t = 0; t < rows->threads; t++)
        rows->makers[t].panes.panes = ARENA_ARRAY(&rows->makers[t].arena, Pane, closed->panes.count + 1);
    parallel_for(rows->threads, rows->mesh->patch_count, close_patch, rows);
}

static int by_index(const void *p, const void *q) {
    const int *a = p, *b = q;
    return (*a > *b) - (*a < *b);
}

static void let_go(ShootRows *rows, Slot *slot) {
    rows->of[slot->patch] = NULL;
    rows->there[slot->patch] = false;
    slot->waiting = false;
    rows->waiting_count--;
}

// Few wait, and they are the first ones of their memory.
void shoot_rows_shot(ShootRows *rows, int patch) {
    for (int i = 0, left = rows->waiting_count; left > 0; i++) {
        if (!rows->slots[i].waiting) continue;
        left--;
        if (rows->slots[i].patch != patch) continue;
        let_go(rows, &rows->slots[i]);
        return;
    }
}

void shoot_rows_refine(ShootRows *rows, int patch) {
    if (rows->fine[patch]) return;
    shoot_rows_shot(rows, patch);
    rows->of[patch] = NULL;
    rows->there[patch] = false;
    rows->fine[patch] = true;
}

// ---- doors

// That of a patch on the door's leaf does.
bool shoot_rows_depend(const ShootRows *rows, int index, const MovedDoors *moved) {
    const Mesh *mesh = rows->mesh;
    const Patch *patch = &mesh->patches[index];
    const uint64_t *doors = rows->doors + (size_t)index * (size_t)rows->door_words;
    int leaf = mesh->graph->objects[mesh->faces[patch->face].object].leaf;
    if (mesh_leaf_moves(moved, mesh->graph->building, leaf)) return true;
    for (int i = 0; i < moved->count; i++) {
        const MovedDoor *door = &moved->doors[i];
        if (view_has_door(doors, door->opening) &&
            mesh_door_rises(door, patch->centre, mesh->faces[patch->face].plane.n))
            return true;
    }
    return false;
}

// Memory of rows that were dropped is given back once it is this share of all.
static const double MOST_GAPS = 0.25;

static size_t bytes_of(const ShootRow *row) {
    return row_bytes(row->run_count, row->element_count, row->sky_part_count);
}

static size_t bytes_there(const ShootRows *rows) {
    size_t bytes = 0;
    for (int p = 0; p < rows->mesh->patch_count; p++)
        if (rows->of[p]) bytes += bytes_of(rows->of[p]);
    return bytes;
}

// Copies the rows that are there to memory without gaps.
static void close_gaps(ShootRows *rows) {
    Arena scratch = {0};
    Arena *before = ARENA_ARRAY(&scratch, Arena, rows->threads);
    for (int t = 0; t < rows->threads; t++) {
        Maker *maker = &rows->makers[t];
        before[t] = maker->kept;
        maker->kept = (Arena){0};
        maker->block_left = maker->kept_bytes = 0;
        maker->kept_count = 0;
    }
    for (int p = 0; p < rows->mesh->patch_count; p++) {
        const ShootRow *row = rows->of[p];
        if (!row) continue;
        size_t bytes = bytes_of(row);
        ShootRow *to =
            keep(rows, &rows->makers[(long long)p * rows->threads / rows->mesh->patch_count], bytes);
        rows->of[p] = to;
        rows->there[p] = to != NULL;
        if (!to) continue;
        memcpy(to, row, bytes);
        place_row(to, row->run_count, row->element_count, row->sky_part_count);
    }
    for (int t = 0; t < rows->threads; t++) arena_free(&before[t]);
    rows->full = rows->options->row_bytes == 0;
    arena_free(&scratch);
}

static void move_middles(ShootRows *rows) {
    const Mesh *mesh = rows->mesh;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        int end = face->first_element + face->element_count;
        if (mesh->graph->objects[face->object].leaf < 0) continue;
        for (int e = face->first_element; e < end; e++) rows->middles[e] = element_centroid(mesh, e);
    }
}

int shoot_rows_move(ShootRows *rows, const MovedDoors *moved, bool *dropped) {
    int count = 0;
    size_t kept = 0;
    for (int i = 0; rows->waiting_count > 0; i++)
        if (rows->slots[i].waiting) let_go(rows, &rows->slots[i]);
    for (int p = 0; p < rows->mesh->patch_count; p++) {
        if (!rows->of[p] || !shoot_rows_depend(rows, p, moved)) continue;
        rows->of[p] = NULL;
        rows->there[p] = false;
        if (dropped) dropped[p] = true;
        count++;
    }
    for (int t = 0; t < rows->threads; t++) {
        if (rows->equipped) viewer_pose(rows->makers[t].viewer);
        kept += rows->makers[t].kept_bytes;
    }
    if ((double)bytes_there(rows) < (1 - MOST_GAPS) * (double)kept) close_gaps(rows);
    move_middles(rows);
    if (rows->equipped && rows->shapes) near_shapes_pose(rows->shapes, rows->mesh);
    return count;
}

// ---- another hour

static void turn_row(void *context, int index, int thread) {
    (void)thread;
    const ShootRows *rows = context;
    ShootRow *row = rows->of[index];
    if (row) row->sky_light = sky_parts_light(row->sky_part, row->sky_part_count, rows->usual.day);
}

void shoot_rows_turn(ShootRows *rows) {
    CORE_ASSERT(rows->usual.day && rows->usual.sky_parts);
    parallel_for(rows->threads, rows->mesh->patch_count, turn_row, rows);
    memset(rows->strong, 0, (size_t)rows->mesh->patch_count * sizeof *rows->strong);
    rows->settled = false;
}

void shoot_rows_make(ShootRows *rows, int *patches, int count) {
    if (rows->waiting_count + count > rows->slot_count || rows->waiting_count > WAITING * rows->threads)
        for (int i = 0; rows->waiting_count > 0; i++)
            if (rows->slots[i].waiting) let_go(rows, &rows->slots[i]);
    CORE_ASSERT(count <= rows->slot_count);
    equip(rows);
    // One after the other, patches of a room find their faces in the cache, where the last one left them.
    qsort(patches, (size_t)count, sizeof *patches, by_index);
    for (int i = 0, at = 0; i < count; i++, at++) {
        while (rows->slots[at].waiting) at++;
        rows->making[i] = at;
        rows->slots[at].patch = patches[i];
    }
    parallel_for(rows->threads, count, make_row, rows);
    rows->made += count;
    for (int i = 0; i < count; i++) {
        Slot *slot = &rows->slots[rows->making[i]];
        rows->waiting_count += slot->waiting;
        rows->full = rows->full || slot->waiting;
        rows->of[slot->patch] = slot->row;
        rows->there[slot->patch] = true;
    }
}

void shoot_rows_report(const ShootRows *rows, RadReport *report) {
    long long faces = 0, elements = 0;
    report->seconds_visibility = 0;
    report->row_bytes = 0;
    report->rows_kept = 0;
    for (int t = 0; t < rows->threads; t++) {
        faces += rows->makers[t].faces;
        elements += elements_drawn(rows, &rows->makers[t]);
        report->seconds_visibility += rows->makers[t].seconds_visibility;
        report->row_bytes += rows->makers[t].kept_bytes;
        report->rows_kept += rows->makers[t].kept_count;
    }
    report->rows_made = rows->made;
    report->faces_drawn_mean = rows->made ? (double)faces / (double)rows->made : 0;
    report->elements_drawn_mean = rows->made ? (double)elements / (double)rows->made : 0;
}
