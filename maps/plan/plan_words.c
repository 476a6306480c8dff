// plan_words.c - the words of a .plan line. Numbers are plain decimals: the other forms that strtod takes (nan, inf,
// hexadecimal) are refused.
#include "maps/plan/plan_words.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "maps/building/building.h"

enum {
    MAX_WORDS = 300,       // of a line: cutting a concave polygon costs the cube of its corners
    MAX_DECLARED = 10000,  // materials, models, storeys: names are found by linear search
    LIST_LENGTH = 600,     // characters of a list of allowed words in a message
    SHOWN_LENGTH = 60      // characters of a faulty word in a message
};

bool plan_fail(const PlanLine *line, const char *format, ...) {
    char text[900];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return error_set(line->error, "%s:%d: %s", line->path, line->number, text);
}

// Returns the quote that ends a quoted word; NULL, with the error set, when there is none.
static char *quoted_end(PlanLine *line, char *start) {
    char *end = strchr(start, '"');
    if (!end) {
        plan_fail(line, "a quoted name is not closed: \"%.*s (allowed: \"a name\" on one line)", SHOWN_LENGTH,
                  start);
        return NULL;
    }
    if (end[1] && !isblank((unsigned char)end[1])) {
        plan_fail(line, "no blank after \"%.*s\" (allowed: words separated by blanks)",
                  (int)(end - start < SHOWN_LENGTH ? end - start : SHOWN_LENGTH), start);
        return NULL;
    }
    return end;
}

bool plan_split(PlanLine *line, char *text) {
    line->count = line->next = 0;
    for (char *c = text; *c; c++) {
        if (iscntrl((unsigned char)*c) && *c != '\t')
            return plan_fail(line, "byte %d at column %d (allowed: text)", (unsigned char)*c,
                             (int)(c - text) + 1);
    }
    for (char *c = text;;) {
        while (isblank((unsigned char)*c)) c++;
        if (!*c || (*c == '#' && (line->count == 0 || !c[1] || isblank((unsigned char)c[1])))) return true;
        if (line->count == MAX_WORDS)
            return plan_fail(line, "too many words (allowed: %d a line)", MAX_WORDS);
        bool quoted = *c == '"';
        char *end = c + quoted;
        if (quoted) {
            if (!(end = quoted_end(line, c + 1))) return false;
        } else {
            while (*end && !isblank((unsigned char)*end)) end++;
        }
        *ARENA_PUSH(line->arena, line->words, line->count, line->capacity) = c + quoted;
        c = *end ? end + 1 : end;
        *end = 0;
    }
}

bool plan_is(const PlanLine *line, const char *word) {
    return line->next < line->count && strcmp(line->words[line->next], word) == 0;
}

// The next word for messages, in quotes.
static const char *found(const PlanLine *line) {
    if (line->next >= line->count) return "the end of the line";
    return arena_format(line->arena, "'%.*s'", SHOWN_LENGTH, line->words[line->next]);
}

// Reads a decimal number and moves `text` behind it.
static bool scan_number(const char **text, double *out) {
    size_t length = strspn(*text, "+-.0123456789eE");
    char copy[64];
    if (length == 0 || length >= sizeof copy) return false;
    memcpy(copy, *text, length);
    copy[length] = 0;
    char *end;
    *out = strtod(copy, &end);
    if (end == copy || *end || !isfinite(*out)) return false;
    *text += length;
    return true;
}

// How many numbers `word` joins by commas, up to `max`; 0 when it is anything else.
static int scan_tuple(const char *word, double *out, int max) {
    for (int n = 0; n < max; n++) {
        if (!scan_number(&word, &out[n])) return 0;
        if (!*word) return n + 1;
        if (*word++ != ',') return 0;
    }
    return 0;
}

bool plan_is_point(const PlanLine *line, int numbers) {
    if (line->next >= line->count) return false;
    const char *word = line->words[line->next];
    int commas = 0;
    for (const char *c = word; *c; c++) commas += *c == ',';
    return commas >= numbers - 1 && commas > 0 && strchr("+-.0123456789", *word);
}

bool plan_name(PlanLine *line, const char *what, const char **out) {
    if (line->next >= line->count || !*line->words[line->next])
        return plan_fail(line, "%s is missing (allowed: a word, or \"several words\")", what);
    *out = arena_string(line->arena, line->words[line->next++]);
    return true;
}

bool plan_number(PlanLine *line, const char *what, double min, double max, const char *unit, double *out) {
    double value;
    if (line->next >= line->count || scan_tuple(line->words[line->next], &value, 1) != 1 || value < min ||
        value > max)
        return plan_fail(line, "%s is %s (allowed: a number from %g to %g%s%s)", what, found(line), min, max,
                         *unit ? " " : "", unit);
    *out = value;
    line->next++;
    return true;
}

bool plan_whole(PlanLine *line, const char *what, int min, int max, int *out) {
    double value;
    if (line->next >= line->count || scan_tuple(line->words[line->next], &value, 1) != 1 || value < min ||
        value > max || value != floor(value))
        return plan_fail(line, "%s is %s (allowed: a whole number from %d to %d)", what, found(line), min,
                         max);
    *out = (int)value;
    line->next++;
    return true;
}

bool plan_spectrum(PlanLine *line, const char *what, double min, double max, double out[3]) {
    if (!plan_number(line, what, min, max, "", &out[0])) return false;
    out[1] = out[2] = out[0];
    double value;
    if (line->next >= line->count || scan_tuple(line->words[line->next], &value, 1) != 1) return true;
    return plan_number(line, what, min, max, "", &out[1]) && plan_number(line, what, min, max, "", &out[2]);
}

// Reads x,y or x,y,z. Returns how many numbers there were, 0 on failure.
static int read_tuple(PlanLine *line, const char *what, int least, int most, double *v) {
    int n = line->next < line->count ? scan_tuple(line->words[line->next], v, most) : 0;
    bool inside = n >= least;
    for (int i = 0; i < n; i++) inside = inside && fabs(v[i]) <= MAPS_LIMIT;
    if (!inside) {
        plan_fail(line, "%s is %s (allowed: %s in metres, no blanks inside, at most %g)", what, found(line),
                  least == 3  ? "x,y,z"
                  : most == 3 ? "x,y or x,y,z"
                              : "x,y",
                  MAPS_LIMIT);
        return 0;
    }
    line->next++;
    return n;
}

bool plan_point(PlanLine *line, const char *what, Vec2 *out) {
    double v[2];
    if (!read_tuple(line, what, 2, 2, v)) return false;
    *out = vec2(v[0], v[1]);
    return true;
}

bool plan_place(PlanLine *line, const char *what, bool z_needed, Vec3 *out) {
    double v[3] = {0};
    int n = read_tuple(line, what, z_needed ? 3 : 2, 3, v);
    if (n == 0) return false;
    *out = vec3(v[0], v[1], n == 3 ? v[2] : 0);
    return true;
}

bool plan_points(PlanLine *line, const char *what, int least, PlanList *out) {
    *out = (PlanList){0};
    int capacity = 0;
    while (plan_is_point(line, 2)) {
        Vec2 point;
        if (!plan_point(line, what, &point)) return false;
        *ARENA_PUSH(line->arena, out->points, out->count, capacity) = point;
    }
    if (out->count >= least) return true;
    return plan_fail(line, "%d of %s, then %s (allowed: at least %d, as x,y)", out->count, what, found(line),
                     least);
}

bool plan_end(PlanLine *line) {
    if (line->next >= line->count) return true;
    return plan_fail(line,
                     "%s is left over (allowed: the end of the line, or # and a blank before a comment)",
                     found(line));
}

// Names joined by ", ", cut short where there are too many to read.
static const char *join_names(Arena *arena, const char *list, const char *word) {
    if (strlen(list) >= LIST_LENGTH) return list;
    if (strlen(list) + strlen(word) >= LIST_LENGTH) return arena_format(arena, "%s, ... ", list);
    return arena_format(arena, "%s%s%s", list, *list ? ", " : "", word);
}

int plan_find(const PlanNames *names, const char *name) {
    for (int i = 0; i < names->count; i++)
        if (strcmp(names->name[i], name) == 0) return names->index[i];
    return -1;
}

bool plan_declare(PlanLine *line, PlanNames *names, const char *what, const char *name, int index) {
    if (plan_find(names, name) >= 0)
        return plan_fail(line, "there is a %s '%.*s' already (allowed: each name once)", what, SHOWN_LENGTH,
                         name);
    if (names->count == MAX_DECLARED)
        return plan_fail(line, "too many: %s (allowed: %d)", what, MAX_DECLARED);
    int count = names->count;
    *ARENA_PUSH(line->arena, names->index, count, names->index_capacity) = index;
    *ARENA_PUSH(line->arena, names->name, names->count, names->name_capacity) = name;
    return true;
}

bool plan_material(PlanLine *line, int *out) {
    int index = line->next < line->count ? plan_find(line->materials, line->words[line->next]) : -1;
    if (index < 0) {
        const char *list = "";
        for (int i = 0; i < line->materials->count; i++)
            list = join_names(line->arena, list, line->materials->name[i]);
        return plan_fail(line, "no material %s (allowed so far: %s)", found(line), list);
    }
    *out = index;
    line->next++;
    return true;
}

// Which of the blank-separated `words` the next word is, or -1.
static int word_index(const PlanLine *line, const char *words) {
    if (line->next >= line->count) return -1;
    const char *word = line->words[line->next];
    size_t length = strlen(word);
    int index = 0;
    for (const char *w = words; *w; index++) {
        size_t n = strcspn(w, " ");
        if (n == length && strncmp(w, word, n) == 0) return index;
        w += n;
        while (*w == ' ') w++;
    }
    return -1;
}

static bool read_choice(PlanLine *line, const PlanOption *option) {
    int index = word_index(line, option->words);
    if (index < 0) return plan_fail(line, "%s is %s (allowed: %s)", option->word, found(line), option->words);
    line->next++;
    if (option->kind == PLAN_CHOICE) {
        *(int *)option->out = index;
        return true;
    }
    unsigned bits = 1u << index;
    for (; (index = word_index(line, option->words)) >= 0; line->next++) bits |= 1u << index;
    *(unsigned *)option->out = bits;
    return true;
}

static bool read_triple(PlanLine *line, const PlanOption *o) {
    double v[3] = {0};
    int n = line->next < line->count ? scan_tuple(line->words[line->next], v, 3) : 0;
    bool inside = n == 3;
    for (int i = 0; i < n; i++) inside = inside && v[i] >= o->min && v[i] <= o->max;
    if (!inside)
        return plan_fail(line, "%s is %s (allowed: x,y,z, each from %g to %g metres)", o->word, found(line),
                         o->min, o->max);
    *(Vec3 *)o->out = vec3(v[0], v[1], v[2]);
    line->next++;
    return true;
}

static bool read_list(PlanLine *line, const PlanOption *o) {
    PlanList *list = o->out;
    int capacity = 0;
    double value;
    *list = (PlanList){0};
    do {
        if (!plan_number(line, o->word, o->min, o->max, "", &value)) return false;
        *ARENA_PUSH(line->arena, list->numbers, list->count, capacity) = value;
    } while (line->next < line->count && scan_tuple(line->words[line->next], &value, 1) == 1);
    return true;
}

static bool read_value(PlanLine *line, const PlanOption *o) {
    double degrees;
    switch (o->kind) {
    case PLAN_LENGTH:
        return plan_number(line, o->word, o->min, o->max, "metres", o->out);
    case PLAN_PURE:
        return plan_number(line, o->word, o->min, o->max, "", o->out);
    case PLAN_ANGLE:
        if (!plan_number(line, o->word, o->min, o->max, "degrees", &degrees)) return false;
        *(double *)o->out = degrees * (M_PI / 180);
        return true;
    case PLAN_WHOLE:
        return plan_whole(line, o->word, (int)o->min, (int)o->max, o->out);
    case PLAN_SPECTRUM:
        return plan_spectrum(line, o->word, o->min, o->max, o->out);
    case PLAN_MATERIAL:
        return plan_material(line, o->out);
    case PLAN_NAME:
        return plan_name(line, o->word, o->out);
    case PLAN_FLAG:
        *(bool *)o->out = true;
        return true;
    case PLAN_CHOICE:
    case PLAN_SET:
        return read_choice(line, o);
    case PLAN_SHAPE:
        return plan_points(line, "corners", 3, o->out);
    case PLAN_TRIPLE:
        return read_triple(line, o);
    case PLAN_LIST:
        return read_list(line, o);
    }
    return false;
}

static PlanOption *find_option(const PlanLine *line, PlanOption *options, int count) {
    for (int i = 0; i < count; i++)
        if (strcmp(options[i].word, line->words[line->next]) == 0) return &options[i];
    return NULL;
}

bool plan_options(PlanLine *line, PlanOption *options, int count) {
    while (line->next < line->count) {
        PlanOption *option = find_option(line, options, count);
        if (!option) {
            const char *list = "";
            for (int i = 0; i < count; i++) list = join_names(line->arena, list, options[i].word);
            return plan_fail(line, "unknown word %s (allowed: %s)", found(line), list);
        }
        if (option->given) return plan_fail(line, "%s stands twice (allowed: once)", option->word);
        option->given = true;
        line->next++;
        if (!read_value(line, option)) return false;
    }
    for (int i = 0; i < count; i++)
        if (options[i].required && !options[i].given)
            return plan_fail(line, "%s is missing (allowed: %s and its value)", options[i].word,
                             options[i].word);
    return true;
}
