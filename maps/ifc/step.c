// step.c - the text of STEP files (ISO 10303-21:2002, "clear text encoding of the exchange structure").
//
// One pass finds where statements begin and end; threads take parts of the file that begin behind a `;` and a line end, and a part whose
// beginning proves wrong (inside a comment or a string) is read again from where the one before ended.
#include <math.h>
#include <pthread.h>
#include <stdio.h>

#include "engine/core/parallel.h"
#include "maps/ifc/step_text.h"

enum {
    TYPE_TABLE = 2048,       // slots, a power of two
    PART = 8 * 1024 * 1024,  // bytes that a thread takes at a time
    LONGEST_NAME = 128,
};

long long step_line(const StepFile *file, size_t at) {
    long long line = 1;
    const char *from = file->text, *end = file->text + (at < file->size ? at : file->size);
    while ((from = memchr(from, '\n', (size_t)(end - from)))) {
        line++;
        from++;
    }
    return line;
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

// ---- statements

// A fault of a part; only the first of the file is told.
typedef enum Fault { SOUND, CUT_OFF, NO_ENTITY, NO_NUMBER, NO_EQUALS, NO_TYPE } Fault;

typedef struct Record {
    int entity;
    uint32_t at;
    uint16_t type;
} Record;

// The records of one part until they are joined to those of the file; then the memory serves another part.
typedef struct Records {
    Arena arena;
    Record *record;
    int count, room;
} Records;

typedef struct Part {
    size_t from, to;  // statements that begin here are its own
    size_t end;       // where the first statement behind it begins
    bool read;        // and not joined yet
    bool done;        // it met ENDSEC, at `end`
    Fault fault;
    size_t fault_at;
    Records records;
} Part;

typedef struct Scan {
    StepFile *file;
    const TypeTable *table;
    Part *parts;
    int part_count;
    pthread_mutex_t lock;                 // of all below
    Arena *arena;                         // for the records of the file
    int entity_room, type_room, at_room;  // equal
    int joined;                           // parts
    bool over;                            // the last part that was joined is done, or has a fault
    long long count, largest;             // of records that were joined; the largest number behind a #
    Records *spare;                       // [spare_count] memory for parts
    int spare_count;
} Scan;

static void part_fault(Part *part, Fault fault, size_t at) {
    part->fault = fault;
    part->fault_at = at;
}

static void keep_record(Part *part, Record record) {
    enum { USUAL = 48 };  // bytes of a record, fewer than most have
    Records *to = &part->records;
    if (to->count == to->room) {
        int needed = to->count ? 2 * to->count : (int)((part->to - part->from) / USUAL) + 64;
        to->record = arena_room(&to->arena, to->record, sizeof(Record), to->count, needed, &to->room);
    }
    to->record[to->count++] = record;
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
    keep_record(part, (Record){(int)number, (uint32_t)open, type});
    *place = end;
    return true;
}

static void find_statements(const Scan *scan, Part *part) {
    const StepFile *file = scan->file;
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

// Appends the records of a part to those of the file, for which there is room as far as the parts so far let expect.
static void join_records(Scan *scan, const Part *part) {
    StepFile *file = scan->file;
    const Records *from = &part->records;
    scan->count += from->count;
    if (scan->count > STEP_MOST_ENTITIES) return;
    int first = file->record_count, needed = (int)scan->count;
    if (needed > scan->at_room) {
        double share = (double)(part->end - scan->parts[0].from) / (double)(file->size - scan->parts[0].from);
        needed = (int)fmin(needed / fmax(share, 1e-6) + 1000, STEP_MOST_ENTITIES);
        file->entity =
            arena_regrow(scan->arena, file->entity, sizeof(int), first, needed, &scan->entity_room);
        file->type = arena_regrow(scan->arena, file->type, sizeof(uint16_t), first, needed, &scan->type_room);
        file->at = arena_regrow(scan->arena, file->at, sizeof(uint32_t), first, needed, &scan->at_room);
    }
    for (int i = 0; i < from->count; i++) {
        const Record *r = &from->record[i];
        file->entity[first + i] = r->entity;
        file->type[first + i] = r->type;
        file->at[first + i] = r->at;
        if (r->entity > scan->largest) scan->largest = r->entity;
    }
    file->record_count = (int)scan->count;
}

// Joins the parts that were read, in order. A part whose beginning is not where the one before ended is read again from there.
static void join_parts(Scan *scan) {
    while (!scan->over && scan->joined < scan->part_count && scan->parts[scan->joined].read) {
        Part *part = &scan->parts[scan->joined];
        if (scan->joined > 0 && part->from != part[-1].end) {
            part->records.count = 0;
            *part = (Part){.from = part[-1].end, .to = part->to, .records = part->records};
            find_statements(scan, part);
        }
        if (part->fault == SOUND) join_records(scan, part);
        part->records.count = 0;
        scan->spare[scan->spare_count++] = part->records;
        part->records = (Records){0};
        scan->over = part->done || part->fault != SOUND;
        scan->joined++;
    }
}

static void scan_part(void *context, int index, int thread) {
    (void)thread;
    Scan *scan = context;
    Part *part = &scan->parts[index];
    pthread_mutex_lock(&scan->lock);
    bool over = scan->over;
    if (!over && scan->spare_count > 0) part->records = scan->spare[--scan->spare_count];
    pthread_mutex_unlock(&scan->lock);
    if (over) return;
    find_statements(scan, part);
    pthread_mutex_lock(&scan->lock);
    part->read = true;
    join_parts(scan);
    pthread_mutex_unlock(&scan->lock);
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

int step_find(const StepFile *file, long long entity) {
    if (entity < 0 || entity > STEP_MOST_NAMED) return -1;
    if (!file->hashed) return entity < file->by_count ? file->by_entity[entity] - 1 : -1;
    uint32_t mask = (uint32_t)file->by_count - 1, at = entity_hash((int)entity) & mask;
    while (file->by_entity[at] > 0 && file->entity[file->by_entity[at] - 1] != entity) at = (at + 1) & mask;
    return file->by_entity[at] - 1;
}

// Enters a record in the index, while other threads enter theirs.
static void index_record(StepFile *file, int record) {
    int entity = file->entity[record];
    uint32_t mask = (uint32_t)file->by_count - 1,
             at = file->hashed ? entity_hash(entity) & mask : (uint32_t)entity;
    for (;; at = (at + 1) & mask) {
        int there = 0;
        if (__atomic_compare_exchange_n(&file->by_entity[at], &there, record + 1, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_ACQUIRE))
            return;
        if (file->entity[there - 1] != entity) continue;
        // The first of several records of one number counts.
        while (record + 1 < there && !__atomic_compare_exchange_n(&file->by_entity[at], &there, record + 1,
                                                                  false, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE))
            continue;
        return;
    }
}

enum { INDEXED_AT_ONCE = 65536 };  // records

static void index_some(void *context, int index, int thread) {
    (void)thread;
    StepFile *file = context;
    int first = index * INDEXED_AT_ONCE, left = file->record_count - first;
    for (int i = 0; i < INDEXED_AT_ONCE && i < left; i++) index_record(file, first + i);
}

static void make_index(StepFile *file, long long largest, int threads, Arena *arena) {
    long long count = file->record_count;
    file->hashed = largest > 8 * count + 1000000;
    long long size = largest + 1;
    if (file->hashed)
        for (size = 16; size < 2 * count;) size *= 2;
    file->by_count = (int)size;
    file->by_entity = ARENA_ARRAY(arena, int, size);
    parallel_for(threads, (int)((count + INDEXED_AT_ONCE - 1) / INDEXED_AT_ONCE), index_some, file);
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

// Tells the first fault of the file, or makes its index.
static bool finish_parts(Scan *scan, int threads, Error *error) {
    StepFile *file = scan->file;
    Part cut = {.fault = CUT_OFF, .fault_at = file->size};
    const Part *last = scan->over ? &scan->parts[scan->joined - 1] : &cut;
    if (last->fault != SOUND) return tell_fault(file, last, error);
    if (scan->count > STEP_MOST_ENTITIES)
        return error_set(error, "%s: has %lld entities (allowed: %d)", file->path, scan->count,
                         STEP_MOST_ENTITIES);
    int count = file->record_count;
    file->entity = arena_fit(scan->arena, file->entity, sizeof(int), count, scan->entity_room);
    file->type = arena_fit(scan->arena, file->type, sizeof(uint16_t), count, scan->type_room);
    file->at = arena_fit(scan->arena, file->at, sizeof(uint32_t), count, scan->at_room);
    make_index(file, scan->largest, threads, scan->arena);
    return true;
}

bool step_read(const char *path, Bytes content, const StepTypes *types, int threads, Arena *arena,
               StepFile *out, Error *error) {
    *out = (StepFile){.path = path, .types = types, .text = (const char *)content.data, .size = content.size};
    size_t data = 0;
    if (content.size > STEP_LARGEST)
        return error_set(error, "%s: has %zu bytes (allowed: %u)", path, content.size, STEP_LARGEST);
    if (!step_header(out, &data, error)) return false;
    TypeTable table;
    make_table(&table, types);
    Arena scratch = {0};
    int most = (int)((content.size - data) / PART) + 1;
    Scan scan = {.file = out,
                 .table = &table,
                 .parts = ARENA_ARRAY(&scratch, Part, most),
                 .lock = PTHREAD_MUTEX_INITIALIZER,
                 .arena = arena,
                 .spare = ARENA_ARRAY(&scratch, Records, most)};
    for (size_t from = data; scan.part_count < most;) {
        size_t to = scan.part_count == most - 1 ? out->size : data + (size_t)(scan.part_count + 1) * PART;
        if (to < from) to = from;
        if (to < out->size) to = likely_begin(out, to);
        scan.parts[scan.part_count++] = (Part){.from = from, .to = to};
        if (to >= out->size) break;
        from = to;
    }
    parallel_for(parallel_threads(threads), scan.part_count, scan_part, &scan);
    bool good = finish_parts(&scan, parallel_threads(threads), error);
    for (int i = 0; i < scan.part_count; i++) arena_free(&scan.parts[i].records.arena);
    for (int i = 0; i < scan.spare_count; i++) arena_free(&scan.spare[i].arena);
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
