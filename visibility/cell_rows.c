// cell_rows.c - see cell_rows.h.
#include "visibility/cell_rows.h"

static const uint64_t EMPTY[CELL_BLOCK_WORDS];
#define ONES UINT64_MAX
static const uint64_t FULL[CELL_BLOCK_WORDS] = {ONES, ONES, ONES, ONES, ONES, ONES, ONES, ONES};

bool cell_block_is_empty(const uint64_t *block) { return block == EMPTY; }
bool cell_block_is_full(const uint64_t *block) { return block == FULL; }

CellRows cell_rows_new(int cell_count, Arena *arena) {
    CellRows rows = {.cell_count = cell_count, .blocks = (cell_count + CELL_BLOCK - 1) / CELL_BLOCK};
    size_t count = (size_t)cell_count * (size_t)rows.blocks;
    rows.block = ARENA_ARRAY(arena, const uint64_t *, count);
    for (size_t i = 0; i < count; i++) rows.block[i] = EMPTY;
    return rows;
}

// Words of the array that lie in block k.
static int words_in(const CellRows *rows, int k) {
    int left = (rows->cell_count + 63) / 64 - k * CELL_BLOCK_WORDS;
    return left < CELL_BLOCK_WORDS ? left : CELL_BLOCK_WORDS;
}

static const uint64_t **slot(CellRows *rows, int cell, int k) {
    return &rows->block[(size_t)cell * (size_t)rows->blocks + (size_t)k];
}

// The shared block of these words, or one of its own in `arena`.
static const uint64_t *stored(const uint64_t *words, Arena *arena) {
    if (memcmp(words, EMPTY, sizeof EMPTY) == 0) return EMPTY;
    if (memcmp(words, FULL, sizeof FULL) == 0) return FULL;
    return memcpy(ARENA_ARRAY(arena, uint64_t, CELL_BLOCK_WORDS), words, sizeof FULL);
}

void cell_rows_set(CellRows *rows, int cell, const uint64_t *row, Arena *arena) {
    for (int k = 0; k < rows->blocks; k++) {
        uint64_t words[CELL_BLOCK_WORDS] = {0};
        memcpy(words, row + k * CELL_BLOCK_WORDS, (size_t)words_in(rows, k) * sizeof *words);
        *slot(rows, cell, k) = stored(words, arena);
    }
}

void cell_rows_join(const CellRows *rows, int cell, uint64_t *row) {
    for (int k = 0; k < rows->blocks; k++) {
        const uint64_t *block = cell_rows_block(rows, cell, k);
        if (block == EMPTY) continue;
        for (int i = 0; i < words_in(rows, k); i++) row[k * CELL_BLOCK_WORDS + i] |= block[i];
    }
}

// Takes `gone` from block k of a row.
static void take_from_row(CellRows *rows, int cell, int k, const uint64_t *gone, Arena *arena) {
    const uint64_t **at = slot(rows, cell, k);
    uint64_t words[CELL_BLOCK_WORDS];
    for (int i = 0; i < CELL_BLOCK_WORDS; i++) words[i] = (*at)[i] & ~gone[i];
    if (*at == FULL || memcmp(words, EMPTY, sizeof words) == 0) {
        *at = stored(words, arena);
    } else {
        memcpy((uint64_t *)*at, words, sizeof words);  // its own
    }
}

bool cell_rows_keep(CellRows *rows, int cell, const uint64_t *row, Arena *arena) {
    bool changed = false;
    for (int k = 0; k < rows->blocks; k++) {
        const uint64_t *block = cell_rows_block(rows, cell, k);
        uint64_t gone[CELL_BLOCK_WORDS] = {0}, any = 0;
        for (int i = 0; i < words_in(rows, k); i++)
            any |= gone[i] = block[i] & ~row[k * CELL_BLOCK_WORDS + i];
        if (any) take_from_row(rows, cell, k, gone, arena);
        changed = changed || any;
    }
    return changed;
}

// Finds, in block k of a row, the cells whose rows lack the row's cell.
static bool one_sided(const CellRows *rows, int cell, int k, uint64_t *gone) {
    const uint64_t *block = cell_rows_block(rows, cell, k);
    bool any = false;
    memset(gone, 0, CELL_BLOCK_WORDS * sizeof *gone);
    for (int i = 0; i < CELL_BLOCK_WORDS; i++) {
        for (uint64_t bits = block[i]; bits; bits &= bits - 1) {
            int other = k * CELL_BLOCK + i * 64 + __builtin_ctzll(bits);
            if (cell_rows_has(rows, other, cell)) continue;
            gone[i] |= bits & -bits;
            any = true;
        }
    }
    return any;
}

// In `full` [blocks * blocks]: of how many rows of block a is block b full.
static void count_full(const CellRows *rows, int *full) {
    for (int i = 0; i < rows->cell_count; i++)
        for (int k = 0; k < rows->blocks; k++)
            full[i / CELL_BLOCK * rows->blocks + k] += cell_rows_block(rows, i, k) == FULL;
}

void cell_rows_make_symmetric(CellRows *rows, Arena *arena) {
    Arena scratch = {0};
    int *full = ARENA_ARRAY(&scratch, int, rows->blocks * rows->blocks);
    count_full(rows, full);
    for (int i = 0; i < rows->cell_count; i++) {
        for (int k = 0; k < rows->blocks; k++) {
            uint64_t gone[CELL_BLOCK_WORDS];
            const uint64_t *block = cell_rows_block(rows, i, k);
            // A cell taken from a row before its pair's turn was missing in the other one.
            if (block == EMPTY || full[k * rows->blocks + i / CELL_BLOCK] == CELL_BLOCK) continue;
            if (one_sided(rows, i, k, gone)) take_from_row(rows, i, k, gone, arena);
        }
    }
    arena_free(&scratch);
}

CellRows cell_rows_copy(const CellRows *rows, Arena *arena) {
    CellRows copy = cell_rows_new(rows->cell_count, arena);
    size_t count = (size_t)rows->cell_count * (size_t)rows->blocks;
    for (size_t i = 0; i < count; i++) copy.block[i] = stored(rows->block[i], arena);
    return copy;
}

bool cell_rows_equal(const CellRows *a, const CellRows *b) {
    if (a->cell_count != b->cell_count) return false;
    size_t count = (size_t)a->cell_count * (size_t)a->blocks;
    for (size_t i = 0; i < count; i++)
        if (memcmp(a->block[i], b->block[i], sizeof EMPTY) != 0) return false;
    return true;
}

long long cell_rows_count(const CellRows *rows) {
    long long count = 0;
    for (size_t i = 0; i < (size_t)rows->cell_count * (size_t)rows->blocks; i++)
        for (int k = 0; k < CELL_BLOCK_WORDS; k++) count += __builtin_popcountll(rows->block[i][k]);
    return count;
}
