// shoot_rows.c - rows made in parallel, each by one thread with a viewer and a form-factor method of its own, so that a
// row depends on its patch alone. The first ones are kept until their memory is spent: a patch that was strong early
// shoots again and again. Those that come later stay until the next are made.
#include "radiosity/shoot_rows.h"

#include <stdlib.h>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"

// Rows made at a time by each thread. Where they are kept none is in vain, and many make up for rows of different cost and
// are often of neighbours, who see the same; else some are, when a patch grows strong that was not foreseen.
enum { AHEAD_KEPT = 256, AHEAD_PASSING = 4 };
// Kept rows lie in blocks of at least so many bytes.
static const size_t BLOCK_BYTES = (size_t)1 << 20;

// One thread's tools.
typedef struct Maker {
    Arena arena;
    Viewer *viewer;
    FormFactor *form_factor;
    long long faces;
    double seconds_visibility;
} Maker;

// A row that was just made.
typedef struct Slot {
    Arena arena;
    ShootRow *row;
    int patch, capacity;  // elements
} Slot;

// What becomes of an element's share.
typedef struct Taker {
    int patch;
    float per_area;  // 1/m^2
} Taker;

struct ShootRows {
    const Mesh *mesh;
    Taker *takers;  // [element_count]
    const RadOptions *options;
    int threads, slot_count, slots_used;
    Maker *makers;  // [threads]
    Slot *slots;    // [slot_count]
    ShootRow **of;  // [patch_count] NULL: not there
    bool *there;    // [patch_count]
    Arena kept;
    char *block;        // where the next kept row goes
    size_t block_left;  // bytes
    size_t kept_bytes;  // of all blocks
    bool full;
    long long made, kept_count;
};

ShootRows *shoot_rows_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                          const RadOptions *options, Arena *arena) {
    ShootRows *rows = ARENA_ARRAY(arena, ShootRows, 1);
    rows->mesh = mesh;
    rows->options = options;
    rows->takers = ARENA_ARRAY(arena, Taker, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++)
        rows->takers[e] = (Taker){mesh->elements[e].patch, (float)(1 / mesh->elements[e].area)};
    rows->threads = parallel_threads(options->threads);
    rows->makers = ARENA_ARRAY(arena, Maker, rows->threads);
    for (int t = 0; t < rows->threads; t++) {
        Maker *maker = &rows->makers[t];
        maker->viewer = viewer_new(mesh, forest, door_open, &maker->arena);
        maker->form_factor = form_factor_new(options->method, mesh, &options->form_factor, &maker->arena);
    }
    rows->slot_count = AHEAD_KEPT * rows->threads;
    rows->slots = ARENA_ARRAY(arena, Slot, rows->slot_count);
    rows->of = ARENA_ARRAY(arena, ShootRow *, mesh->patch_count);
    rows->there = ARENA_ARRAY(arena, bool, mesh->patch_count);
    rows->full = options->row_bytes == 0;
    // So that a byte tells which element of its patch one is (patches have 16 x 16 at most).
    for (int p = 0; p < mesh->patch_count; p++) CORE_ASSERT(mesh->patches[p].element_count <= 256);
    return rows;
}

void shoot_rows_end(ShootRows *rows) {
    for (int t = 0; t < rows->threads; t++) {
        form_factor_end(rows->makers[t].form_factor);
        arena_free(&rows->makers[t].arena);
    }
    for (int i = 0; i < rows->slot_count; i++) arena_free(&rows->slots[i].arena);
    arena_free(&rows->kept);
}

int shoot_rows_wanted(const ShootRows *rows) {
    return (rows->full ? AHEAD_PASSING : AHEAD_KEPT) * rows->threads;
}

const bool *shoot_rows_there(const ShootRows *rows) { return rows->there; }

const ShootRow *shoot_rows_of(const ShootRows *rows, int patch) { return rows->of[patch]; }

// The room a row of so many elements takes at most, each in a patch of its own.
static size_t row_bytes(int runs, int elements) {
    size_t run = sizeof(ShootRun) + sizeof(uint8_t), element = sizeof(float) + sizeof(uint8_t);
    size_t bytes = sizeof(ShootRow) + (size_t)runs * run + (size_t)elements * element;
    return (bytes + sizeof(double) - 1) / sizeof(double) * sizeof(double);
}

// Where the parts of a row lie behind it.
static void place_row(ShootRow *row, int runs, int elements) {
    row->runs = (ShootRun *)(row + 1);
    row->density = (float *)(row->runs + runs);
    row->count = (uint8_t *)(row->density + elements);
    row->offset = row->count + runs;
}

// How many elements ahead their takers are asked for, which lie all over memory.
enum { TAKERS_AHEAD = 24 };

static void copy_row(const ShootRows *rows, const Row *from, ShootRow *to) {
    place_row(to, from->count, from->count);
    double sum = from->back + from->escaped;
    to->run_count = 0;
    to->element_count = from->count;
    for (int i = 0; i < from->count;) {
        int patch = rows->takers[from->element[i]].patch, first = i;
        int first_element = rows->mesh->patches[patch].first_element;
        double share = 0;
        for (; i < from->count; i++) {
            if (i + TAKERS_AHEAD < from->count)
                __builtin_prefetch(&rows->takers[from->element[i + TAKERS_AHEAD]]);
            const Taker *taker = &rows->takers[from->element[i]];
            if (taker->patch != patch) break;
            share += (double)from->factor[i];
            to->density[i] = from->factor[i] * taker->per_area;
            to->offset[i] = (uint8_t)(from->element[i] - first_element);
        }
        to->count[to->run_count] = (uint8_t)(i - first - 1);
        to->runs[to->run_count++] = (ShootRun){patch, (float)share};
        sum += (double)(float)share;
    }
    CORE_ASSERT(sum > 0.5 && sum < 2);  // a method's row sums to 1
    to->back = from->back;
    to->escaped = from->escaped;
    to->scale = 1 / sum;
}

static void make_row(void *context, int index, int thread) {
    ShootRows *rows = context;
    Maker *maker = &rows->makers[thread];
    Slot *slot = &rows->slots[index];
    const Patch *patch = &rows->mesh->patches[slot->patch];
    ViewPoint from = {patch->centre, rows->mesh->faces[patch->face].plane.n, patch->cell};
    double start = clock_seconds();
    const View *view = viewer_look(maker->viewer, &from, rows->options->culling);
    maker->seconds_visibility += clock_seconds() - start;
    maker->faces += view->face_count;
    const Row *row = form_factor_row(maker->form_factor, view);
    if (!slot->row || row->count > slot->capacity) {
        arena_free(&slot->arena);
        slot->capacity = row->count + row->count / 8;
        slot->row = arena_alloc(&slot->arena, row_bytes(slot->capacity, slot->capacity), 1);
    }
    copy_row(rows, row, slot->row);
}

// Moves a row out of its slot, if there is room.
static bool keep(ShootRows *rows, const ShootRow *row, ShootRow **out) {
    size_t bytes = row_bytes(row->run_count, row->element_count), count = (size_t)row->element_count;
    if (bytes > rows->block_left) {
        size_t block = bytes > BLOCK_BYTES ? bytes : BLOCK_BYTES;
        if (rows->kept_bytes + block > rows->options->row_bytes) return false;
        rows->block = arena_alloc(&rows->kept, block, 1);
        rows->block_left = block;
        rows->kept_bytes += block;
    }
    ShootRow *kept = (ShootRow *)rows->block;
    *kept = *row;
    place_row(kept, row->run_count, row->element_count);
    memcpy(kept->runs, row->runs, (size_t)row->run_count * sizeof *row->runs);
    memcpy(kept->density, row->density, count * sizeof *row->density);
    memcpy(kept->count, row->count, (size_t)row->run_count * sizeof *row->count);
    memcpy(kept->offset, row->offset, count * sizeof *row->offset);
    rows->block += bytes;
    rows->block_left -= bytes;
    rows->kept_count++;
    *out = kept;
    return true;
}

static int by_index(const void *p, const void *q) {
    const int *a = p, *b = q;
    return (*a > *b) - (*a < *b);
}

void shoot_rows_make(ShootRows *rows, int *patches, int count) {
    CORE_ASSERT(count <= rows->slot_count);
    for (int i = 0; i < rows->slots_used; i++) {
        int patch = rows->slots[i].patch;
        if (rows->of[patch] != rows->slots[i].row) continue;
        rows->of[patch] = NULL;
        rows->there[patch] = false;
    }
    // One after the other, patches of a room find what they see where the last one left it.
    qsort(patches, (size_t)count, sizeof *patches, by_index);
    for (int i = 0; i < count; i++) rows->slots[i].patch = patches[i];
    rows->slots_used = count;
    parallel_for(rows->threads, count, make_row, rows);
    rows->made += count;
    for (int i = 0; i < count; i++) {
        Slot *slot = &rows->slots[i];
        rows->full = rows->full || !keep(rows, slot->row, &rows->of[slot->patch]);
        if (rows->full) rows->of[slot->patch] = slot->row;
        rows->there[slot->patch] = true;
    }
}

void shoot_rows_report(const ShootRows *rows, RadReport *report) {
    long long faces = 0, elements = 0;
    report->seconds_visibility = 0;
    for (int t = 0; t < rows->threads; t++) {
        faces += rows->makers[t].faces;
        elements += form_factor_work(rows->makers[t].form_factor).elements_drawn;
        report->seconds_visibility += rows->makers[t].seconds_visibility;
    }
    report->rows_made = rows->made;
    report->rows_kept = rows->kept_count;
    report->row_bytes = rows->kept_bytes;
    report->faces_drawn_mean = rows->made ? (double)faces / (double)rows->made : 0;
    report->elements_drawn_mean = rows->made ? (double)elements / (double)rows->made : 0;
}
