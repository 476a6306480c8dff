// step.c - the text of STEP files (ISO 10303-21:2002, "clear text encoding of the exchange structure").
//
// One pass finds where statements begin and end; threads take parts of the file that begin behind a `;` and a line end, and a part whose
// beginning proves wrong (inside a comment or a string) is read again with the one before. Arguments are not kept: they are read from
// the text each time they are asked for, which costs less than keeping them.
#include "maps/ifc/step.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "engine/core/parallel.h"

enum {
    TYPE_TABLE = 2048,       // slots, a power of two
    PART = 8 * 1024 * 1024,  // bytes that a thread takes at a time
    LONGEST_NAME = 128,
};

// The kinds of bytes.
static bool is_blank(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\f' || c == '\v';
}
static bool is_digit(char c) { return c >= '0' && c <= '9'; }
static bool is_name(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || is_digit(c) || c == '_' || c == '-';
}

// The first byte from here on that is a quote or, with `all`, a semicolon or a slash too; the size of the file where there is none.
static inline size_t find_stop(const StepFile *file, size_t at, bool all) {
    typedef char Block __attribute__((vector_size(32)));
    const char *text = file->text;
    for (; at + sizeof(Block) <= file->size; at += sizeof(Block)) {
        Block b;
        memcpy(&b, text + at, sizeof b);
        Block hit = (Block)(b == '\'');
        if (all) hit |= (Block)(b == ';') | (Block)(b == '/');
#ifdef __AVX2__
        unsigned mask = (unsigned)_mm256_movemask_epi8((__m256i)hit);
        if (mask) return at + (size_t)__builtin_ctz(mask);
#else
        uint64_t word[4];
        memcpy(word, &hit, sizeof word);
        if (word[0] | word[1] | word[2] | word[3]) break;
#endif
    }
    while (at < file->size && text[at] != '\'' && !(all && (text[at] == ';' || text[at] == '/'))) at++;
    return at;
}

long long step_line(const StepFile *file, size_t at) {
    long long line = 1;
    const char *from = file->text, *end = file->text + (at < file->size ? at : file->size);
    while ((from = memchr(from, '\n', (size_t)(end - from)))) {
        line++;
        from++;
    }
    return line;
}

// Behind blanks and comments; SIZE_MAX where a comment does not end.
static size_t skip_blanks(const StepFile *file, size_t at) {
    const char *text = file->text;
    for (;;) {
        while (at < file->size && is_blank(text[at])) at++;
        if (at + 1 >= file->size || text[at] != '/' || text[at + 1] != '*') return at;
        const char *end = memmem(text + at + 2, file->size - at - 2, "*/", 2);
        if (!end) return SIZE_MAX;
        at = (size_t)(end - text) + 2;
    }
}

// Behind a string whose quote is at `at`; SIZE_MAX where it does not end. A doubled quote is two strings in a row, which does no harm here.
static size_t skip_string(const StepFile *file, size_t at) {
    size_t end = find_stop(file, at + 1, false);
    return end < file->size ? end + 1 : SIZE_MAX;
}

// Behind the `;` of a statement; SIZE_MAX where it does not end.
static size_t skip_statement(const StepFile *file, size_t at) {
    const char *text = file->text;
    for (;;) {
        at = find_stop(file, at, true);
        if (at >= file->size) return SIZE_MAX;
        if (text[at] == ';') return at + 1;
        if (text[at] == '\'') {
            at = skip_string(file, at);
        } else if (at + 1 < file->size && text[at + 1] == '*') {
            at = skip_blanks(file, at);
        } else {
            at++;
        }
        if (at == SIZE_MAX) return at;
    }
}

// ---- names of types

typedef struct TypeTable {
    const StepTypes *types;
    uint16_t slot[TYPE_TABLE];  // type + 1
    unsigned char length[STEP_MOST_TYPES];
} TypeTable;

// Eight bytes of a name without regard to case, as some programs write small letters: no two other characters of names are made alike.
static uint64_t name_word(const char *text) {
    uint64_t word;
    memcpy(&word, text, sizeof word);
    return word & 0xDFDFDFDFDFDFDFDFu;
}

// By words of eight bytes, of which the last two overlap.
static uint32_t name_hash(const char *name, size_t size) {
    uint64_t h = size;
    size_t i = 0;
    for (; i + 8 <= size; i += 8) h = (h ^ name_word(name + i)) * 0x9E3779B97F4A7C15u;
    if (size >= 8) return (uint32_t)((h ^ name_word(name + size - 8)) * 0x9E3779B97F4A7C15u >> 32);
    for (; i < size; i++) h = (h ^ ((unsigned char)name[i] & 0xDFu)) * 0x9E3779B97F4A7C15u;
    return (uint32_t)(h >> 32);
}

static bool same_name(const char *text, size_t size, const char *name) {
    for (size_t i = 0; i < size; i++)
        if ((text[i] & 0xDF) != (name[i] & 0xDF) || name[i] == 0) return false;
    return name[size] == 0;
}

// The same for a name of `length` bytes.
static bool same_long_name(const char *text, size_t size, const char *name, size_t length) {
    if (size != length || size < 8) return size == length && same_name(text, size, name);
    for (size_t i = 0; i + 8 <= size; i += 8)
        if (name_word(text + i) != name_word(name + i)) return false;
    return name_word(text + size - 8) == name_word(name + size - 8);
}

static void make_table(TypeTable *table, const StepTypes *types) {
    CORE_ASSERT(types->count <= STEP_MOST_TYPES);
    memset(table, 0, sizeof *table);
    table->types = types;
    for (int i = 0; i < types->count; i++) {
        size_t length = strlen(types->name[i]);
        uint32_t h = name_hash(types->name[i], length);
        CORE_ASSERT(length <= LONGEST_NAME);
        table->length[i] = (unsigned char)length;
        while (table->slot[h % TYPE_TABLE]) h++;
        table->slot[h % TYPE_TABLE] = (uint16_t)(i + 1);
    }
}

static uint16_t find_type(const TypeTable *table, const char *name, size_t size) {
    for (uint32_t h = name_hash(name, size);; h++) {
        int slot = table->slot[h % TYPE_TABLE];
        if (!slot) return STEP_OTHER;
        if (same_long_name(name, size, table->types->name[slot - 1], table->length[slot - 1]))
            return (uint16_t)(slot - 1);
    }
}

static size_t name_end(const StepFile *file, size_t at) {
    while (at < file->size && is_name(file->text[at])) at++;
    return at;
}

// ---- statements

// A fault of a part; only the first of the file is told.
typedef enum Fault { SOUND, CUT_OFF, NO_ENTITY, NO_NUMBER, NO_EQUALS, NO_TYPE } Fault;

typedef struct Part {
    size_t from, to;  // statements that begin here are its own
    size_t end;       // where the first statement behind it begins
    bool done;        // it met ENDSEC, at `end`
    Fault fault;
    size_t fault_at;
    int count;
    int first;  // of its records in the file
    long long largest;
    Arena arena;
    int *entity;
    uint16_t *type;
    size_t *at;
    int entity_room, type_room, at_room;  // equal
} Part;

typedef struct Scan {
    const StepFile *file;
    const TypeTable *table;
    Part *parts;
} Scan;

static void part_fault(Part *part, Fault fault, size_t at) {
    part->fault = fault;
    part->fault_at = at;
}

static void keep_record(Part *part, int entity, uint16_t type, size_t at) {
    enum { USUAL = 48 };  // bytes of a record, fewer than most have
    int n = part->count;
    if (n == part->at_room) {
        int needed = n ? 2 * n : (int)((part->to - part->from) / USUAL) + 64;
        part->entity = arena_room(&part->arena, part->entity, sizeof(int), n, needed, &part->entity_room);
        part->type = arena_room(&part->arena, part->type, sizeof(uint16_t), n, needed, &part->type_room);
        part->at = arena_room(&part->arena, part->at, sizeof(size_t), n, needed, &part->at_room);
    }
    part->entity[n] = entity;
    part->type[n] = type;
    part->at[n] = at;
    part->count = n + 1;
    if (entity > part->largest) part->largest = entity;
}

// Most blanks and comments are none.
static inline size_t pass_blanks(const StepFile *file, size_t at) {
    char c = file->text[at];
    return is_blank(c) || c == '/' ? skip_blanks(file, at) : at;
}

static bool scan_record(const Scan *scan, Part *part, size_t *place) {
    const StepFile *file = scan->file;
    const char *text = file->text;
    size_t begin = *place, at = pass_blanks(file, begin + 1);
    long long number = 0;
    size_t digits = at;
    while (at < file->size && is_digit(text[at]) && number <= STEP_MOST_NAMED)
        number = number * 10 + (text[at++] - '0');
    if (at == digits || number > STEP_MOST_NAMED || number < 0)
        return part_fault(part, at >= file->size ? CUT_OFF : NO_NUMBER, begin), false;
    at = pass_blanks(file, at);
    if (at >= file->size || text[at] != '=')
        return part_fault(part, at >= file->size ? CUT_OFF : NO_EQUALS, begin), false;
    at = pass_blanks(file, at + 1);
    if (at >= file->size) return part_fault(part, CUT_OFF, begin), false;
    size_t name = at;
    at = name_end(file, at);
    uint16_t type = STEP_OTHER;
    if (at > name) {
        if (at - name > LONGEST_NAME) return part_fault(part, NO_TYPE, begin), false;
        type = find_type(scan->table, text + name, at - name);
    }
    size_t open = pass_blanks(file, at);
    if (open >= file->size || text[open] != '(')
        return part_fault(part, open >= file->size ? CUT_OFF : NO_TYPE, begin), false;
    size_t end = skip_statement(file, open);
    if (end == SIZE_MAX) return part_fault(part, CUT_OFF, begin), false;
    keep_record(part, (int)number, type, open);
    *place = end;
    return true;
}

static void scan_part(void *context, int index, int thread) {
    (void)thread;
    const Scan *scan = context;
    const StepFile *file = scan->file;
    Part *part = &scan->parts[index];
    size_t at = part->from;
    while (part->fault == SOUND) {
        at = skip_blanks(file, at);
        if (at >= file->size) {
            part_fault(part, CUT_OFF, file->size);
            break;
        }
        part->end = at;
        if (at >= part->to) break;
        if (file->text[at] == '#') {
            scan_record(scan, part, &at);
        } else if (file->size - at >= 6 && memcmp(file->text + at, "ENDSEC", 6) == 0) {
            part->done = true;
            break;
        } else {
            part_fault(part, NO_ENTITY, at);
        }
    }
}

int step_shown(const StepFile *file, size_t at, int most) {
    int shown = 0;
    for (; shown < most && at + (size_t)shown < file->size; shown++) {
        char c = file->text[at + (size_t)shown];
        if (c < ' ' || c > '~') break;
    }
    return shown;
}

static bool tell_fault(const StepFile *file, const Part *part, Error *error) {
    size_t at = part->fault_at;
    long long line = step_line(file, at);
    int shown = step_shown(file, at, 40);
    const char *found = file->text + at;
    switch (part->fault) {
    case CUT_OFF:
        if (shown == 0)
            return error_set(error, "%s:%lld: the file ends before its data does (expected ENDSEC)",
                             file->path, line);
        return error_set(error, "%s:%lld: the file ends within the statement `%.*s`", file->path, line, shown,
                         found);
    case NO_NUMBER:
        return error_set(error, "%s:%lld: a statement begins with `%.*s` (allowed: # and a number up to %d)",
                         file->path, line, shown, found, STEP_MOST_NAMED);
    case NO_EQUALS:
        return error_set(error, "%s:%lld: `%.*s` lacks the = behind its number", file->path, line, shown,
                         found);
    case NO_TYPE:
        return error_set(error, "%s:%lld: `%.*s` lacks the name of a type and ( behind its =", file->path,
                         line, shown, found);
    default:
        return error_set(error, "%s:%lld: found `%.*s` (allowed: # for an entity, or ENDSEC)", file->path,
                         line, shown, found);
    }
}

// Where a part may begin: at a # that is the first in its line, behind a line that ends with `;`.
static size_t likely_begin(const StepFile *file, size_t from) {
    const char *text = file->text;
    for (size_t at = from; at + 2 < file->size;) {
        const char *stop = memchr(text + at, ';', file->size - at);
        if (!stop) break;
        size_t next = (size_t)(stop - text) + 1, line = next;
        while (line < file->size && is_blank(text[line])) line++;
        if (line < file->size && text[line] == '#' && memchr(text + next, '\n', line - next)) return line;
        at = next;
    }
    return file->size;
}

// ---- the index by number

static uint32_t entity_hash(int entity) { return (uint32_t)entity * 2654435769u; }

static void begin_index(StepFile *file, long long largest, Arena *arena) {
    long long count = file->record_count;
    file->hashed = largest > 8 * count + 1000000;
    long long size = largest + 1;
    if (file->hashed)
        for (size = 16; size < 2 * count;) size *= 2;
    file->by_count = (int)size;
    file->by_entity = ARENA_ARRAY(arena, int, size);
    memset(file->by_entity, -1, (size_t)size * sizeof(int));
}

int step_find(const StepFile *file, long long entity) {
    if (entity < 0 || entity > STEP_MOST_NAMED) return -1;
    if (!file->hashed) return entity < file->by_count ? file->by_entity[entity] : -1;
    uint32_t mask = (uint32_t)file->by_count - 1, at = entity_hash((int)entity) & mask;
    while (file->by_entity[at] >= 0 && file->entity[file->by_entity[at]] != entity) at = (at + 1) & mask;
    return file->by_entity[at];
}

// ---- the file

static bool step_header(StepFile *file, size_t *data, Error *error) {
    size_t at = skip_blanks(file, 0);
    if (at != SIZE_MAX && file->size - at >= 3 && memcmp(file->text + at, "\xEF\xBB\xBF", 3) == 0)
        at = skip_blanks(file, at + 3);
    if (at == SIZE_MAX || file->size - at < 13 || memcmp(file->text + at, "ISO-10303-21;", 13) != 0)
        return error_set(error, "%s: is no STEP file (expected ISO-10303-21; at its beginning)", file->path);
    snprintf(file->schema, sizeof file->schema, "none");
    for (at += 13;;) {
        at = skip_blanks(file, at);
        size_t end = at >= file->size ? SIZE_MAX : skip_statement(file, at);
        if (end == SIZE_MAX)
            return error_set(error, "%s:%lld: the file ends within its header (expected DATA;)", file->path,
                             step_line(file, file->size));
        size_t name = name_end(file, at) - at;
        if (name == 4 && memcmp(file->text + at, "DATA", 4) == 0) {
            *data = end;
            return true;
        }
        if (file->text[at] == '#')
            return error_set(error, "%s:%lld: an entity stands before DATA;", file->path,
                             step_line(file, at));
        if (name == 11 && memcmp(file->text + at, "FILE_SCHEMA", 11) == 0) {
            const char *quote = memchr(file->text + at, '\'', end - at);
            size_t length = quote ? strcspn(quote + 1, "' ;") : 0;
            if (length >= sizeof file->schema) length = sizeof file->schema - 1;
            if (quote) snprintf(file->schema, sizeof file->schema, "%.*s", (int)length, quote + 1);
        }
        at = end;
    }
}

typedef struct Joining {
    StepFile *file;
    Part *parts;
} Joining;

// Enters a record in the index, while other threads enter theirs.
static void index_record(StepFile *file, int record) {
    int entity = file->entity[record];
    uint32_t mask = (uint32_t)file->by_count - 1,
             at = file->hashed ? entity_hash(entity) & mask : (uint32_t)entity;
    for (;; at = (at + 1) & mask) {
        int there = -1;
        if (__atomic_compare_exchange_n(&file->by_entity[at], &there, record, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_ACQUIRE))
            return;
        if (file->entity[there] != entity) continue;
        // The first of several records of one number counts.
        while (record < there && !__atomic_compare_exchange_n(&file->by_entity[at], &there, record, false,
                                                              __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE))
            continue;
        return;
    }
}

static void join_part(void *context, int index, int thread) {
    (void)thread;
    const Joining *joining = context;
    StepFile *file = joining->file;
    Part *part = &joining->parts[index];
    if (part->count == 0) return;
    memcpy(file->entity + part->first, part->entity, (size_t)part->count * sizeof(int));
    memcpy(file->type + part->first, part->type, (size_t)part->count * sizeof(uint16_t));
    memcpy(file->at + part->first, part->at, (size_t)part->count * sizeof(size_t));
    arena_free(&part->arena);
    for (int i = part->first; i < part->first + part->count; i++) index_record(file, i);
}

// Joins the parts in order. A part whose beginning is not where the one before ended is read again from there.
static bool join_parts(StepFile *file, const Scan *scan, int part_count, int threads, Arena *arena,
                       Error *error) {
    long long count = 0, largest = 0;
    int used = 0;
    for (; used < part_count; used++) {
        Part *part = &scan->parts[used];
        if (used > 0 && part->from != scan->parts[used - 1].end) {
            arena_free(&part->arena);
            *part = (Part){.from = scan->parts[used - 1].end, .to = part->to};
            scan_part((void *)(uintptr_t)scan, used, 0);
        }
        if (part->fault != SOUND) return tell_fault(file, part, error);
        count += part->count;
        if (part->largest > largest) largest = part->largest;
        if (part->done) break;
    }
    if (used == part_count) {
        Part end = {.fault = CUT_OFF, .fault_at = file->size};
        return tell_fault(file, &end, error);
    }
    if (count > STEP_MOST_ENTITIES)
        return error_set(error, "%s: has %lld entities (allowed: %d)", file->path, count, STEP_MOST_ENTITIES);
    file->entity = ARENA_ARRAY(arena, int, count + 1);
    file->type = ARENA_ARRAY(arena, uint16_t, count + 1);
    file->at = ARENA_ARRAY(arena, size_t, count + 1);
    for (int i = 0; i <= used; i++) {
        scan->parts[i].first = file->record_count;
        file->record_count += scan->parts[i].count;
    }
    begin_index(file, largest, arena);
    Joining joining = {file, scan->parts};
    parallel_for(threads, used + 1, join_part, &joining);
    return true;
}

bool step_read(const char *path, Bytes content, const StepTypes *types, int threads, Arena *arena,
               StepFile *out, Error *error) {
    *out = (StepFile){.path = path, .types = types, .text = (const char *)content.data, .size = content.size};
    size_t data = 0;
    if (!step_header(out, &data, error)) return false;
    TypeTable table;
    make_table(&table, types);
    Arena scratch = {0};
    int most = (int)((content.size - data) / PART) + 1, count = 0;
    Scan scan = {out, &table, ARENA_ARRAY(&scratch, Part, most)};
    for (size_t from = data; count < most;) {
        size_t to = count == most - 1 ? out->size : data + (size_t)(count + 1) * PART;
        if (to < from) to = from;
        if (to < out->size) to = likely_begin(out, to);
        scan.parts[count++] = (Part){.from = from, .to = to};
        if (to >= out->size) break;
        from = to;
    }
    parallel_for(parallel_threads(threads), count, scan_part, &scan);
    bool good = join_parts(out, &scan, count, parallel_threads(threads), arena, error);
    for (int i = 0; i < count; i++) arena_free(&scan.parts[i].arena);
    arena_free(&scratch);
    return good;
}

const char *step_type_name(const StepFile *file, int record, Arena *arena) {
    if (file->type[record] < file->types->count) return file->types->name[file->type[record]];
    size_t end = file->at[record];
    while (end > 0 && is_blank(file->text[end - 1])) end--;
    size_t at = end;
    while (at > 0 && is_name(file->text[at - 1])) at--;
    return end > at ? arena_format(arena, "%.*s", (int)(end - at), file->text + at) : "a complex entity";
}

// ---- arguments

static void cursor_bad(StepCursor *c, size_t at) {
    if (c->bad && at < *c->bad) *c->bad = at;
}

StepCursor step_arguments(const StepFile *file, int record, size_t *bad) {
    return (StepCursor){file, file->at[record] + 1, bad};
}

StepCursor step_elements(const StepCursor *from, const StepValue *list) {
    return (StepCursor){from->file, list->at + 1, from->bad};
}

// Behind the ) that closes the ( at `at`; SIZE_MAX where the statement ends before.
static size_t skip_list(const StepFile *file, size_t at) {
    const char *text = file->text;
    size_t depth = 0;
    while (at < file->size) {
        char c = text[at];
        if (c == '(') {
            depth++;
        } else if (c == ')') {
            if (--depth == 0) return at + 1;
        } else if (c == ';') {
            return SIZE_MAX;
        } else if (c == '\'') {
            at = skip_string(file, at);
            if (at == SIZE_MAX) return at;
            continue;
        } else if (c == '/') {
            size_t next = skip_blanks(file, at);
            if (next == SIZE_MAX) return next;
            if (next > at) {
                at = next;
                continue;
            }
        }
        at++;
    }
    return SIZE_MAX;
}

// Powers of ten that doubles hold exactly.
static const double TENS[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                              1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// A number, rounded as strtod rounds: where the digits fit into a double and the power of ten is exact, one operation rounds once.
static bool step_number(const StepFile *file, size_t *place, double *out) {
    const char *text = file->text + *place, *p = text;
    bool negative = *p == '-';
    if (*p == '-' || *p == '+') p++;
    uint64_t digits = 0;
    int kept = 0, scale = 0;
    const char *begin = p;
    for (; is_digit(*p); p++) {
        digits = digits * 10 + (uint64_t)(*p - '0');
        kept += digits != 0;
        if (kept > 18) break;
    }
    if (kept <= 18 && *p == '.') {
        for (p++; is_digit(*p); p++) {
            digits = digits * 10 + (uint64_t)(*p - '0');
            scale--;
            kept += digits != 0;
            if (kept > 18) break;
        }
    }
    if (p == begin) return false;
    if (kept <= 18 && (*p == 'e' || *p == 'E')) {
        const char *q = p + 1;
        bool minus = *q == '-';
        if (*q == '-' || *q == '+') q++;
        int exponent = 0;
        if (is_digit(*q)) {
            for (; is_digit(*q) && exponent < 10000; q++) exponent = exponent * 10 + (*q - '0');
            while (is_digit(*q)) q++;
            scale += minus ? -exponent : exponent;
            p = q;
        }
    }
    if (kept <= 18 && digits < (uint64_t)1 << 53 && scale >= -22 && scale <= 22) {
        double value = (double)digits;
        value = scale < 0 ? value / TENS[-scale] : value * TENS[scale];
        *out = negative ? -value : value;
    } else {
        char *end = NULL;
        *out = strtod(text, &end);
        if (end == text) return false;
        p = end;
    }
    *place = (size_t)(p - file->text);
    return isfinite(*out);
}

static inline StepValue read_value(StepCursor *c);

// Behind a value: a comma, or the ) at which the cursor stays.
static bool pass_comma(StepCursor *c) {
    const StepFile *file = c->file;
    c->at = is_blank(file->text[c->at]) || file->text[c->at] == '/' ? skip_blanks(file, c->at) : c->at;
    if (c->at >= file->size) return false;
    if (file->text[c->at] == ',') {
        c->at++;
        return true;
    }
    return file->text[c->at] == ')';
}

static inline StepValue next_value(StepCursor *c) {
    const StepFile *file = c->file;
    if (c->at >= file->size) return (StepValue){.kind = STEP_END};
    char first = file->text[c->at];
    if (is_blank(first) || first == '/') {
        size_t at = skip_blanks(file, c->at);
        c->at = at == SIZE_MAX ? file->size : at;
        if (c->at >= file->size) return (StepValue){.kind = STEP_END};
        first = file->text[c->at];
    }
    if (first == ')') return (StepValue){.kind = STEP_END};
    size_t begin = c->at;
    StepValue value = read_value(c);
    if (value.kind == STEP_END || !pass_comma(c)) {
        cursor_bad(c, begin);
        c->at = file->size;
        if (value.kind == STEP_END) value.kind = STEP_NONE;
    }
    return value;
}

StepValue step_next(StepCursor *c) { return next_value(c); }

int step_values(StepCursor *from, StepValue *out, int most) {
    StepCursor c = *from;  // which then lies in registers
    int count = 0;
    for (; count < most; count++) {
        out[count] = next_value(&c);
        if (out[count].kind == STEP_END) break;
    }
    *from = c;
    return count;
}

StepCursor step_enter(const StepCursor *from) {
    StepCursor c = *from;
    c.at = pass_blanks(c.file, c.at);
    c.at = c.at < c.file->size && c.file->text[c.at] == '(' ? c.at + 1 : c.file->size;
    return c;
}

// STEP_END stands for a damaged value here.
static inline StepValue read_value(StepCursor *c) {
    const StepFile *file = c->file;
    const char *text = file->text;
    StepValue v = {.kind = STEP_END, .record = -1, .at = c->at};
    char first = text[c->at];
    if (is_digit(first) || first == '-' || first == '+' || first == '.') {
        if (first != '.' || is_digit(text[c->at + 1])) {
            if (step_number(file, &c->at, &v.number)) v.kind = STEP_NUMBER;
            return v;
        }
        size_t end = name_end(file, c->at + 1);
        if (text[end] != '.') return v;
        v.kind = STEP_ENUM;
        v.at = c->at + 1;
        v.size = end - v.at;
        c->at = end + 1;
        return v;
    }
    switch (first) {
    case '$':
    case '*':
        v.kind = first == '$' ? STEP_NONE : STEP_DERIVED;
        c->at++;
        return v;
    case '#': {
        size_t at = c->at + 1;
        long long number = 0;
        while (is_digit(text[at]) && number <= STEP_MOST_NAMED) number = number * 10 + (text[at++] - '0');
        if (at == c->at + 1 || number > STEP_MOST_NAMED) return v;
        v.kind = STEP_REF;
        v.entity = (int)number;
        v.record = step_find(file, number);
        c->at = at;
        return v;
    }
    case '\'': {
        size_t at = c->at;
        do at = skip_string(file, at);
        while (at != SIZE_MAX && text[at] == '\'');
        if (at == SIZE_MAX) return v;
        v.kind = STEP_STRING;
        v.at = c->at + 1;
        v.size = at - 1 - v.at;
        c->at = at;
        return v;
    }
    case '"': {
        const char *end = memchr(text + c->at + 1, '"', file->size - c->at - 1);
        if (!end) return v;
        v.kind = STEP_BINARY;
        v.at = c->at + 1;
        v.size = (size_t)(end - text) - v.at;
        c->at = (size_t)(end - text) + 1;
        return v;
    }
    case '(': {
        size_t end = skip_list(file, c->at);
        if (end == SIZE_MAX) return v;
        v.kind = STEP_LIST;
        v.size = end - c->at;
        c->at = end;
        return v;
    }
    default:
        break;
    }
    size_t end = name_end(file, c->at), open = end > c->at ? skip_blanks(file, end) : end;
    if (end == c->at || open >= file->size || text[open] != '(') return v;
    size_t close = skip_list(file, open);
    if (close == SIZE_MAX) return v;
    v.kind = STEP_TYPED;
    v.name = c->at;
    v.at = open;
    v.size = close - open;
    c->at = close;
    return v;
}

int step_next_numbers(StepCursor *c, double *out, int most) {
    int count = 0;
    while (count < most) {
        StepValue v = next_value(c);
        if (v.kind == STEP_END) break;
        if (v.kind == STEP_TYPED) {
            StepCursor inner = step_elements(c, &v);
            v = step_next(&inner);
        }
        out[count++] = v.kind == STEP_NUMBER ? v.number : 0;
    }
    return count;
}

int step_numbers(const StepCursor *from, const StepValue *list, double *out, int most) {
    if (list->kind != STEP_LIST) return 0;
    StepCursor c = step_elements(from, list);
    return step_next_numbers(&c, out, most);
}

// ---- strings

static int hex_of(char c) {
    if (is_digit(c)) return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

// `digits` hexadecimal digits; -1 where there are fewer.
static long hex_number(const char *text, size_t size, int digits) {
    long value = 0;
    if (size < (size_t)digits) return -1;
    for (int i = 0; i < digits; i++) {
        int digit = hex_of(text[i]);
        if (digit < 0) return -1;
        value = value * 16 + digit;
    }
    return value;
}

static size_t put_utf8(char *out, unsigned long code) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    if (code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) code = 0xFFFD;
    int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    for (int i = more; i > 0; i--) {
        out[i] = (char)(0x80 | (code & 0x3F));
        code >>= 6;
    }
    out[0] = (char)((more == 1 ? 0xC0 : more == 2 ? 0xE0 : 0xF0) | code);
    return (size_t)more + 1;
}

// The characters of \X2\ (four digits each, surrogate pairs joined) or \X4\ (eight digits), up to \X0\; returns the bytes read.
static size_t wide_string(const char *s, size_t size, int digits, char *out, size_t *length) {
    size_t at = 0;
    for (;;) {
        if (size - at >= 4 && memcmp(s + at, "\\X0\\", 4) == 0) return at + 4;
        long code = hex_number(s + at, size - at, digits);
        if (code < 0) return at;
        at += (size_t)digits;
        if (digits == 4 && code >= 0xD800 && code < 0xDC00) {
            long low = hex_number(s + at, size - at, 4);
            if (low >= 0xDC00 && low < 0xE000) {
                code = 0x10000 + (code - 0xD800) * 0x400 + (low - 0xDC00);
                at += 4;
            }
        }
        *length += put_utf8(out + *length, (unsigned long)code);
    }
}

// Is the text from here on a whole character of UTF-8? Programs write it though the standard forbids it.
static size_t utf8_size(const char *s, size_t size) {
    unsigned char first = (unsigned char)*s;
    size_t more = first >= 0xF0 && first < 0xF5 ? 3 : first >= 0xE0 ? 2 : first >= 0xC2 ? 1 : 0;
    if (first >= 0xF5 || more == 0 || size <= more) return 0;
    for (size_t i = 1; i <= more; i++)
        if (((unsigned char)s[i] & 0xC0) != 0x80) return 0;
    return more + 1;
}

char *step_room(StepStrings *strings, size_t size) {
    enum { BLOCK = 16384 };
    if (size > strings->left) {
        strings->left = size > BLOCK / 4 ? size : BLOCK;
        strings->next = arena_alloc(strings->arena, strings->left, 1);
    }
    char *out = strings->next;
    strings->next += size;
    strings->left -= size;
    return out;
}

const char *step_string(const StepFile *file, const StepValue *value, StepStrings *strings) {
    if (value->kind != STEP_STRING || value->size == 0) return "";
    const char *s = file->text + value->at;
    size_t size = value->size, length = 0;
    // Most strings are plain.
    while (length < size && (unsigned char)s[length] < 0x80 && s[length] >= ' ' && s[length] != '\\' &&
           s[length] != '\'')
        length++;
    if (length == size) {
        char *plain = memcpy(step_room(strings, size + 1), s, size);
        plain[size] = 0;
        return plain;
    }
    length = 0;
    // A byte becomes two at most (\S\ and bytes of Latin 1), four digits three, eight digits four.
    char *out = step_room(strings, 2 * size + 4);
    for (size_t i = 0; i < size;) {
        size_t left = size - i;
        const char *p = s + i;
        if (*p == '\'') {
            out[length++] = '\'';
            i += left > 1 && p[1] == '\'' ? 2 : 1;
        } else if (*p == '\\' && left >= 2 && p[1] == '\\') {
            out[length++] = '\\';
            i += 2;
        } else if (*p == '\\' && left >= 4 && p[1] == 'S' && p[2] == '\\') {
            length += put_utf8(out + length, ((unsigned char)p[3] & 0x7Fu) + 0x80u);
            i += 4;
        } else if (*p == '\\' && left >= 4 && p[1] == 'P' && p[3] == '\\') {
            i += 4;
        } else if (*p == '\\' && left >= 5 && p[1] == 'X' && p[2] == '\\' && hex_number(p + 3, 2, 2) >= 0) {
            length += put_utf8(out + length, (unsigned long)hex_number(p + 3, 2, 2));
            i += 5;
        } else if (*p == '\\' && left >= 4 && p[1] == 'X' && (p[2] == '2' || p[2] == '4') && p[3] == '\\') {
            i += 4;
            i += wide_string(s + i, size - i, p[2] == '2' ? 4 : 8, out, &length);
        } else if ((unsigned char)*p < 0x80) {
            if ((unsigned char)*p >= ' ') out[length++] = *p;
            i++;
        } else {
            size_t whole = utf8_size(p, left);
            if (whole) {
                memcpy(out + length, p, whole);
                length += whole;
                i += whole;
            } else {
                length += put_utf8(out + length, (unsigned char)*p);
                i++;
            }
        }
    }
    out[length] = 0;
    return out;
}

bool step_is(const StepFile *file, const StepValue *value, const char *enumerator) {
    return value->kind == STEP_ENUM && same_name(file->text + value->at, value->size, enumerator);
}
