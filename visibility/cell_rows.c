// cell_rows.c - see cell_rows.h. Equal sets are stored alike, so that they can be compared as bytes.
#include "visibility/cell_rows.h"

#include <stdlib.h>

#include "engine/core/memory.h"

#define ONES UINT64_MAX
// A run takes as much room as two words: gaps that are not wider are filled with zeros. So many full words are worth a run.
enum { WIDEST_GAP = 2, LEAST_FULL = 4 };

CellRows cell_rows_new(int cell_count, Arena *arena) {
    return (CellRows){ARENA_ARRAY(arena, CellRow, cell_count), cell_count, (cell_count + 63) / 64};
}

// A word of a row that is not zero.
typedef struct CellWord {
    int place;
    uint64_t bits;
} CellWord;

// The end of the full words that begin at list[i].
static int full_end(const CellWord *list, int count, int i) {
    int end = i;
    while (end < count && list[end].bits == ONES && list[end].place == list[i].place + (end - i)) end++;
    return end;
}

// The end of the run that begins at list[i]: full words, or others without wide gaps up to the next full ones.
static int run_end(const CellWord *list, int count, int i, bool *full) {
    int end = full_end(list, count, i);
    *full = end - i >= LEAST_FULL;
    if (*full) return end;
    for (end = i + 1; end < count && list[end].place - list[end - 1].place <= WIDEST_GAP + 1; end++) {
        if (list[end].bits == ONES && full_end(list, count, end) - end >= LEAST_FULL) break;
    }
    return end;
}

static void store_row(CellRows *rows, int cell, const CellWord *list, int count, Arena *arena) {
    int runs = 0, words = 0, end;
    bool full;
    for (int i = 0; i < count; i = end, runs++) {
        end = run_end(list, count, i, &full);
        words += full ? 0 : list[end - 1].place - list[i].place + 1;
    }
    size_t size = (size_t)runs * sizeof(CellRun) + (size_t)words * sizeof(uint64_t);
    CellRun *run = arena_alloc(arena, size, 1);
    uint64_t *word = (uint64_t *)(run + runs);
    rows->row[cell] = (CellRow){run, runs};
    for (int i = 0; i < count; i = end, run++) {
        end = run_end(list, count, i, &full);
        *run = (CellRun){list[i].place, list[end - 1].place - list[i].place + 1, full ? NULL : word};
        if (full) continue;
        for (int k = i; k < end; k++) word[list[k].place - list[i].place] = list[k].bits;
        word += run->count;
    }
}

void cell_rows_set(CellRows *rows, int cell, const uint64_t *row, Arena *arena) {
    int count = 0;
    for (int k = 0; k < rows->words; k++) count += row[k] != 0;
    CellWord *list = memory_new((size_t)count * sizeof *list + 1);
    for (int k = 0, i = 0; k < rows->words; k++) {
        if (row[k]) list[i++] = (CellWord){k, row[k]};
    }
    store_row(rows, cell, list, count, arena);
    memory_free(list);
}

CellRows cell_rows_of_matrix(const uint64_t *matrix, int cell_count, Arena *arena) {
    CellRows rows = cell_rows_new(cell_count, arena);
    for (int c = 0; c < cell_count; c++)
        cell_rows_set(&rows, c, matrix + (size_t)c * (size_t)rows.words, arena);
    return rows;
}

void cell_rows_set_list(CellRows *rows, int cell, const int *list, int count, Arena *arena) {
    CellWord *words = memory_new((size_t)count * sizeof *words + 1);
    int word_count = 0;
    for (int i = 0; i < count; i++) {
        if (i == 0 || list[i] / 64 != list[i - 1] / 64) words[word_count++] = (CellWord){list[i] / 64, 0};
        words[word_count - 1].bits |= (uint64_t)1 << (list[i] % 64);
    }
    store_row(rows, cell, words, word_count, arena);
    memory_free(words);
}

void cell_rows_join(const CellRows *rows, int cell, uint64_t *row) {
    CellRow from = rows->row[cell];
    for (const CellRun *run = from.runs; run < from.runs + from.count; run++)
        for (int k = 0; k < run->count; k++) row[run->first + k] |= run->words ? run->words[k] : ONES;
}

void cell_rows_clear(const CellRows *rows, int cell, uint64_t *row) {
    CellRow from = rows->row[cell];
    for (const CellRun *run = from.runs; run < from.runs + from.count; run++)
        for (int k = 0; k < run->count; k++) row[run->first + k] &= run->words ? ~run->words[k] : 0;
}

int cell_rows_size(const CellRows *rows, int cell) {
    CellRow row = rows->row[cell];
    int count = 0;
    for (const CellRun *run = row.runs; run < row.runs + row.count; run++) {
        if (!run->words) count += 64 * run->count;
        for (int k = 0; k < run->count && run->words; k++) count += __builtin_popcountll(run->words[k]);
    }
    return count;
}

int cell_rows_list(const CellRows *rows, int cell, int *out) {
    CellRow row = rows->row[cell];
    int count = 0;
    for (const CellRun *run = row.runs; run < row.runs + row.count; run++) {
        for (int k = 0; k < run->count; k++)
            for (uint64_t left = run->words ? run->words[k] : ONES; left; left &= left - 1)
                out[count++] = 64 * (run->first + k) + __builtin_ctzll(left);
    }
    return count;
}

// The words of a row that are not zero; of memory_new.
static CellWord *list_words(CellRow row, int *count) {
    int most = 0;
    for (int r = 0; r < row.count; r++) most += row.runs[r].count;
    CellWord *list = memory_new((size_t)most * sizeof *list + 1);
    *count = 0;
    for (const CellRun *run = row.runs; run < row.runs + row.count; run++) {
        for (int k = 0; k < run->count; k++) {
            uint64_t bits = run->words ? run->words[k] : ONES;
            if (bits) list[(*count)++] = (CellWord){run->first + k, bits};
        }
    }
    return list;
}

// Stores what is left of a row's words after some of their bits were dropped.
static void store_rest(CellRows *rows, int cell, CellWord *list, int count, Arena *arena) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        if (list[i].bits) list[kept++] = list[i];
    }
    store_row(rows, cell, list, kept, arena);
}

bool cell_rows_keep(CellRows *rows, int cell, const uint64_t *row, Arena *arena) {
    int count;
    CellWord *list = list_words(rows->row[cell], &count);
    uint64_t gone = 0;
    for (int i = 0; i < count; i++) {
        gone |= list[i].bits & ~row[list[i].place];
        list[i].bits &= row[list[i].place];
    }
    if (gone) store_rest(rows, cell, list, count, arena);
    memory_free(list);
    return gone != 0;
}

void cell_rows_make_symmetric(CellRows *rows, Arena *arena) {
    Arena scratch = {0};
    // Rows that hold all cells, as in the open: these are in no need of being asked.
    uint64_t *whole = ARENA_ARRAY(&scratch, uint64_t, rows->words + 1);
    for (int c = 0; c < rows->cell_count; c++)
        whole[c / 64] |= (uint64_t)(cell_rows_size(rows, c) == rows->cell_count) << (c % 64);
    for (int c = 0; c < rows->cell_count; c++) {
        int count;
        CellWord *list = list_words(rows->row[c], &count);
        bool any = false;
        for (int i = 0; i < count; i++) {
            for (uint64_t bits = list[i].bits & ~whole[list[i].place]; bits; bits &= bits - 1) {
                if (cell_rows_has(rows, 64 * list[i].place + __builtin_ctzll(bits), c)) continue;
                list[i].bits &= ~(bits & -bits);
                any = true;
            }
        }
        // A cell taken from a row before its pair's turn was missing in the other one.
        if (any) store_rest(rows, c, list, count, arena);
        memory_free(list);
    }
    arena_free(&scratch);
}

CellRows cell_rows_copy(const CellRows *rows, Arena *arena) {
    CellRows copy = cell_rows_new(rows->cell_count, arena);
    for (int c = 0; c < rows->cell_count; c++) {
        int count;
        CellWord *list = list_words(rows->row[c], &count);
        store_row(&copy, c, list, count, arena);
        memory_free(list);
    }
    return copy;
}

bool cell_rows_equal(const CellRows *a, const CellRows *b) {
    if (a->cell_count != b->cell_count) return false;
    for (int c = 0; c < a->cell_count; c++) {
        if (a->row[c].count != b->row[c].count) return false;
        for (int r = 0; r < a->row[c].count; r++) {
            const CellRun *p = &a->row[c].runs[r], *q = &b->row[c].runs[r];
            if (p->first != q->first || p->count != q->count || !p->words != !q->words) return false;
            if (p->words && memcmp(p->words, q->words, (size_t)p->count * sizeof *p->words) != 0)
                return false;
        }
    }
    return true;
}

long long cell_rows_count(const CellRows *rows) {
    long long count = 0;
    for (int c = 0; c < rows->cell_count; c++) count += cell_rows_size(rows, c);
    return count;
}

// ---- rows as bytes: of each the number of its runs; of each run its first word, their number, which is negative where all bits are
// set, and else the words

static const size_t RUN_HEAD = 2 * sizeof(int32_t);

void cell_rows_put(const CellRows *rows, DerivedSink *sink) {
    for (int c = 0; c < rows->cell_count; c++) {
        int32_t count = rows->row[c].count;
        derived_put(sink, &count, sizeof count);
        for (int r = 0; r < count; r++) {
            const CellRun *run = &rows->row[c].runs[r];
            int32_t head[2] = {run->first, run->words ? run->count : -run->count};
            derived_put(sink, head, RUN_HEAD);
            if (run->words) derived_put(sink, run->words, (size_t)run->count * sizeof *run->words);
        }
    }
}

// Takes a row into `list` [row_words], without words of no bits. `last`: the bits that the last word of a row may have; `run` [row_words]:
// room for the words of a run.
static bool take_row(DerivedReader *reader, int row_words, uint64_t last, uint64_t *run, CellWord *list,
                     int *words) {
    int32_t count, head[2];
    *words = 0;
    if (!derived_take(reader, &count, sizeof count) || count < 0) return false;
    for (int32_t r = 0, least = 0; r < count; r++) {
        if (!derived_take(reader, head, RUN_HEAD)) return false;
        int32_t length = head[1] < 0 ? -(head[1] + 1) + 1 : head[1];
        if (head[0] < least || length < 1 || length > row_words - head[0]) return false;
        least = head[0] + length;
        if (head[1] > 0 && !derived_take(reader, run, (size_t)length * sizeof *run)) return false;
        for (int32_t k = 0; k < length; k++) {
            uint64_t bits = head[1] > 0 ? run[k] : ONES;
            if (head[0] + k == row_words - 1) bits &= last;
            if (bits) list[(*words)++] = (CellWord){head[0] + k, bits};
        }
    }
    return true;
}

bool cell_rows_take(DerivedReader *reader, int cell_count, Arena *arena, CellRows *out) {
    *out = cell_rows_new(cell_count, arena);
    // Bits beyond the last cell, which no row has, are dropped.
    uint64_t last = cell_count % 64 ? ((uint64_t)1 << (cell_count % 64)) - 1 : ONES;
    CellWord *list = memory_new((size_t)out->words * sizeof *list + 1);
    uint64_t *run = memory_new((size_t)out->words * sizeof *run + 1);
    bool good = true;
    for (int c = 0, words; c < cell_count && good; c++) {
        good = take_row(reader, out->words, last, run, list, &words);
        if (good) store_row(out, c, list, words, arena);
    }
    memory_free(run);
    memory_free(list);
    return good;
}
