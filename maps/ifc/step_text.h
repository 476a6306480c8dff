// step_text.h - what the readers of a STEP file's text share: kinds of bytes, blanks and comments, strings, names.
#ifndef MAPS_STEP_TEXT_H
#define MAPS_STEP_TEXT_H

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "maps/ifc/step.h"

// The kinds of bytes.
static inline bool is_blank(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\f' || c == '\v';
}
static inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
static inline bool is_name(char c) {
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

// Behind blanks and comments; SIZE_MAX where a comment does not end.
static inline size_t skip_blanks(const StepFile *file, size_t at) {
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
static inline size_t skip_string(const StepFile *file, size_t at) {
    size_t end = find_stop(file, at + 1, false);
    return end < file->size ? end + 1 : SIZE_MAX;
}

// Most blanks and comments are none.
static inline size_t pass_blanks(const StepFile *file, size_t at) {
    char c = file->text[at];
    return is_blank(c) || c == '/' ? skip_blanks(file, at) : at;
}

// Behind a name.
static inline size_t name_end(const StepFile *file, size_t at) {
    while (at < file->size && is_name(file->text[at])) at++;
    return at;
}

// Is the text this name, without regard to case?
static inline bool same_name(const char *text, size_t size, const char *name) {
    for (size_t i = 0; i < size; i++)
        if ((text[i] & 0xDF) != (name[i] & 0xDF) || name[i] == 0) return false;
    return name[size] == 0;
}

#endif
