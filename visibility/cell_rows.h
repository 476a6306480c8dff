// cell_rows.h - a set of cells for each cell: of each row only the stretches of words in which there are cells.
//
// A cell of a large building sees few others, and where nothing is known it may see all. The first takes room for what it sees, the
// second next to none: of words whose bits are all set only their number is kept.
#ifndef VISIBILITY_CELL_ROWS_H
#define VISIBILITY_CELL_ROWS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/file.h"

// Words `first` and on of a row.
typedef struct CellRun {
    int first, count;
    const uint64_t *words;  // [count]; NULL: all bits are set
} CellRun;

typedef struct CellRow {
    const CellRun *runs;  // [count] ascending, apart from each other
    int count;
} CellRow;

// Read only once it is made: any number of threads. What the rows hold lies in the arenas of the calls that set them.
typedef struct CellRows {
    CellRow *row;           // [cell_count]
    int cell_count, words;  // words of a row as an array: (cell_count + 63) / 64
} CellRows;

// Is `other` in the row of `cell`?
static inline bool cell_rows_has(const CellRows *rows, int cell, int other) {
    CellRow row = rows->row[cell];
    int low = 0, high = row.count, word = other / 64;  // runs before `low` begin at the word or before it
    while (low < high) {
        int middle = (low + high) / 2;
        if (row.runs[middle].first <= word) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (low == 0) return false;
    const CellRun *run = &row.runs[low - 1];
    if (word >= run->first + run->count) return false;
    return !run->words || (run->words[word - run->first] >> (other % 64) & 1);
}

// All empty.
CellRows cell_rows_new(int cell_count, Arena *arena);
// From a matrix of bits [cell_count * words].
CellRows cell_rows_of_matrix(const uint64_t *matrix, int cell_count, Arena *arena);
// One row, from the array `row` [words] or from a list of cells, ascending.
void cell_rows_set(CellRows *rows, int cell, const uint64_t *row, Arena *arena);
void cell_rows_set_list(CellRows *rows, int cell, const int *list, int count, Arena *arena);
// Adds a row to the array `row` [words], or takes it from there.
void cell_rows_join(const CellRows *rows, int cell, uint64_t *row);
void cell_rows_clear(const CellRows *rows, int cell, uint64_t *row);
// Writes the cells of a row, ascending; returns how many. `out` has room for cell_rows_size.
int cell_rows_list(const CellRows *rows, int cell, int *out);
int cell_rows_size(const CellRows *rows, int cell);
// Removes from a row the cells that the array [words] lacks; returns whether there was any.
bool cell_rows_keep(CellRows *rows, int cell, const uint64_t *row, Arena *arena);
// Takes from each row the cells whose rows lack its cell.
void cell_rows_make_symmetric(CellRows *rows, Arena *arena);
// The same sets in `arena` alone.
CellRows cell_rows_copy(const CellRows *rows, Arena *arena);
bool cell_rows_equal(const CellRows *a, const CellRows *b);
long long cell_rows_count(const CellRows *rows);  // of all bits

// For files (file.h): the rows as bytes, one after the other. False where these are broken; the rows are not looked at beyond that.
void cell_rows_put(const CellRows *rows, DerivedSink *sink);
bool cell_rows_take(DerivedReader *reader, int cell_count, Arena *arena, CellRows *out);

#endif
