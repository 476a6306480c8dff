// state_parts.c - parts of a sentence or lines of a file, cut at the last `=`.
#include "engine/scene/state_parts.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/arena.h"
#include "engine/core/file.h"

// A file of states is text of a few lines.
enum { LARGEST_FILE = 1 << 20 };
// The longest part, bytes.
enum { LONGEST_PART = 256 };

// The sentence that is being read, and where.
typedef struct Sentence {
    StatePart *apply;
    void *context;
    char place[128];
} Sentence;

// Words without the spaces around them.
static void trim(const char *from, size_t length, char out[LONGEST_PART]) {
    while (length > 0 && isspace((unsigned char)*from)) from++, length--;
    while (length > 0 && isspace((unsigned char)from[length - 1])) length--;
    memcpy(out, from, length);
    out[length] = 0;
}

static bool apply_part(const Sentence *s, const char *from, size_t length, bool remarks, Error *error) {
    char part[LONGEST_PART], who[LONGEST_PART] = "all", state[LONGEST_PART];
    if (length >= LONGEST_PART)
        return error_set(error, "%s: `%.40s...` is longer than %d bytes", s->place, from, LONGEST_PART - 1);
    trim(from, length, part);
    if (*part == 0 || (remarks && *part == '#')) return true;
    const char *equals = strrchr(part, '=');
    if (equals) trim(part, (size_t)(equals - part), who);
    const char *after = equals ? equals + 1 : part;
    trim(after, strlen(after), state);
    return s->apply(s->context, s->place, who, state, error);
}

static bool apply_file(Sentence *s, const char *path, Error *error) {
    Arena arena = {0};
    Bytes file;
    bool good = file_read(path, LARGEST_FILE, &arena, &file, error);
    const char *line = good ? (const char *)file.data : "";
    for (int number = 1; *line && good; number++) {
        size_t length = strcspn(line, "\n");
        snprintf(s->place, sizeof s->place, "%.100s:%d", path, number);
        good = apply_part(s, line, length, true, error);
        line += length + (line[length] == '\n');
    }
    arena_free(&arena);
    return good;
}

bool state_parts_apply(const char *option, const char *sentence, StatePart *apply, void *context,
                       Error *error) {
    Sentence s = {.apply = apply, .context = context};
    snprintf(s.place, sizeof s.place, "%s", option);
    if (*sentence == '@') return apply_file(&s, sentence + 1, error);
    for (const char *from = sentence; *from;) {
        size_t length = strcspn(from, ",");
        if (!apply_part(&s, from, length, false, error)) return false;
        from += length + (from[length] == ',');
    }
    return true;
}
