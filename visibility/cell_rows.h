// cell_rows.h - a set of cells for each cell: bits in blocks, of which empty and full ones take no room.
//
// A cell of a large building sees few others, and where nothing is known it may see all: neither costs more than a pointer
// a block.
#ifndef VISIBILITY_CELL_ROWS_H
#define VISIBILITY_CELL_ROWS_H

#include <stdbool.h>
#include <stdint.h>

#include "engine/core/arena.h"

enum { CELL_BLOCK_WORDS = 8, CELL_BLOCK = 64 * CELL_BLOCK_WORDS };

// Read only once it is made: any number of threads. The blocks live in the arena of the call that made them.
typedef struct CellRows {
    // [cell_count * blocks] cells CELL_BLOCK * k and on of row i: CELL_BLOCK_WORDS words, shared or of this row alone
    const uint64_t **block;
    int cell_count, blocks;  // blocks of a row
} CellRows;

// Block k of the row of a cell: CELL_BLOCK_WORDS words.
static inline const uint64_t *cell_rows_block(const CellRows *rows, int cell, int k) {
    return rows->block[(size_t)cell * (size_t)rows->blocks + (size_t)k];
}

// Is `other` in the row of `cell`?
static inline bool cell_rows_has(const CellRows *rows, int cell, int other) {
    const uint64_t *block = cell_rows_block(rows, cell, other / CELL_BLOCK);
    return block[other / 64 % CELL_BLOCK_WORDS] >> (other % 64) & 1;
}

// All empty.
CellRows cell_rows_new(int cell_count, Arena *arena);
// One row from the array `row` [(cell_count + 63) / 64]; blocks of its own lie in `arena`.
void cell_rows_set(CellRows *rows, int cell, const uint64_t *row, Arena *arena);
// Adds a row to the array `row` [(cell_count + 63) / 64].
void cell_rows_join(const CellRows *rows, int cell, uint64_t *row);
// Removes from a row the cells that the array lacks; returns whether there was any.
bool cell_rows_keep(CellRows *rows, int cell, const uint64_t *row, Arena *arena);
// Takes from each row the cells whose rows lack its cell.
void cell_rows_make_symmetric(CellRows *rows, Arena *arena);
// The same sets in `arena` alone.
CellRows cell_rows_copy(const CellRows *rows, Arena *arena);
bool cell_rows_equal(const CellRows *a, const CellRows *b);
long long cell_rows_count(const CellRows *rows);  // of all bits

// Is it one of the two blocks that rows share?
bool cell_block_is_empty(const uint64_t *block);
bool cell_block_is_full(const uint64_t *block);

#endif
