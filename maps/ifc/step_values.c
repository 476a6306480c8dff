// step_values.c - arguments of records, read from the text of a STEP file each time they are asked for: that costs less than keeping them.
#include <math.h>
#include <stdlib.h>

#include "engine/core/text.h"
#include "maps/ifc/step_text.h"

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

static inline void read_value(StepCursor *c, StepValue *out);

// Behind a value: a comma, or the ) at which the cursor stays.
static inline bool pass_comma(StepCursor *c) {
    const StepFile *file = c->file;
    c->at = pass_blanks(file, c->at);
    if (c->at >= file->size) return false;
    if (file->text[c->at] == ',') {
        c->at++;
        return true;
    }
    return file->text[c->at] == ')';
}

// Writes into its place what other functions would return: values are asked for by the million.
static inline void next_value(StepCursor *c, StepValue *out) {
    const StepFile *file = c->file;
    *out = (StepValue){.kind = STEP_END};
    if (c->at >= file->size) return;
    size_t begin = pass_blanks(file, c->at);
    c->at = begin < file->size ? begin : file->size;
    if (begin >= file->size || file->text[begin] == ')') return;
    read_value(c, out);
    if (out->kind == STEP_END || !pass_comma(c)) {
        cursor_bad(c, begin);
        c->at = file->size;
        if (out->kind == STEP_END) out->kind = STEP_NONE;
    }
}

StepValue step_next(StepCursor *c) {
    StepValue value;
    next_value(c, &value);
    return value;
}

int step_values(StepCursor *from, StepValue *out, int most) {
    StepCursor c = *from;  // which then lies in registers
    int count = 0;
    for (; count < most; count++) {
        next_value(&c, &out[count]);
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

// Reads a value; the kind stays STEP_END where it is damaged.
static inline void read_value(StepCursor *c, StepValue *v) {
    const StepFile *file = c->file;
    const char *text = file->text;
    size_t begin = c->at;
    char first = text[begin];
    v->record = -1;
    v->at = (uint32_t)begin;
    if (is_digit(first) || first == '-' || first == '+' || first == '.') {
        if (first != '.' || is_digit(text[begin + 1])) {
            if (step_number(file, &c->at, &v->number)) v->kind = STEP_NUMBER;
            return;
        }
        size_t end = name_end(file, begin + 1);
        if (text[end] != '.') return;
        v->kind = STEP_ENUM;
        v->at = (uint32_t)begin + 1;
        v->size = (uint32_t)(end - begin - 1);
        c->at = end + 1;
        return;
    }
    switch (first) {
    case '$':
    case '*':
        v->kind = first == '$' ? STEP_NONE : STEP_DERIVED;
        c->at++;
        return;
    case '#': {
        size_t at = begin + 1;
        long long number = 0;
        while (is_digit(text[at]) && number <= STEP_MOST_NAMED) number = number * 10 + (text[at++] - '0');
        if (at == begin + 1 || number > STEP_MOST_NAMED) return;
        v->kind = STEP_REF;
        v->entity = (int)number;
        v->record = step_find(file, number);
        c->at = at;
        return;
    }
    case '\'': {
        size_t at = begin;
        do at = skip_string(file, at);
        while (at != SIZE_MAX && text[at] == '\'');
        if (at == SIZE_MAX) return;
        v->kind = STEP_STRING;
        v->at = (uint32_t)begin + 1;
        v->size = (uint32_t)(at - begin - 2);
        c->at = at;
        return;
    }
    case '"': {
        const char *end = memchr(text + begin + 1, '"', file->size - begin - 1);
        if (!end) return;
        v->kind = STEP_BINARY;
        v->at = (uint32_t)begin + 1;
        v->size = (uint32_t)(end - text) - v->at;
        c->at = (size_t)(end - text) + 1;
        return;
    }
    case '(': {
        size_t end = skip_list(file, begin);
        if (end == SIZE_MAX) return;
        v->kind = STEP_LIST;
        v->size = (uint32_t)(end - begin);
        c->at = end;
        return;
    }
    default:
        break;
    }
    size_t end = name_end(file, begin), open = end > begin ? skip_blanks(file, end) : end;
    if (end == begin || open >= file->size || text[open] != '(') return;
    size_t close = skip_list(file, open);
    if (close == SIZE_MAX) return;
    v->kind = STEP_TYPED;
    v->name = (uint32_t)begin;
    v->at = (uint32_t)open;
    v->size = (uint32_t)(close - open);
    c->at = close;
}

int step_next_numbers(StepCursor *c, double *out, int most) {
    int count = 0;
    while (count < most) {
        StepValue v;
        next_value(c, &v);
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
        *length += text_utf8(out + *length, (unsigned long)code);
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
            length += text_utf8(out + length, ((unsigned char)p[3] & 0x7Fu) + 0x80u);
            i += 4;
        } else if (*p == '\\' && left >= 4 && p[1] == 'P' && p[3] == '\\') {
            i += 4;
        } else if (*p == '\\' && left >= 5 && p[1] == 'X' && p[2] == '\\' && hex_number(p + 3, 2, 2) >= 0) {
            length += text_utf8(out + length, (unsigned long)hex_number(p + 3, 2, 2));
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
                length += text_utf8(out + length, (unsigned char)*p);
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
