// text.h - text that grows as it is written: SVG, CSV.
#ifndef CORE_TEXT_H
#define CORE_TEXT_H

#include "engine/core/arena.h"

// Start with {.arena = ...}; `data` ends with a zero byte once something was appended. Outgrown text stays in the arena: at most as
// many bytes again.
typedef struct Text {
    Arena *arena;
    char *data;
    size_t size, capacity;
} Text;

// Texts that are given one by one, as by an option that may be repeated.
enum { TEXT_LIST = 64 };
typedef struct TextList {
    const char *text[TEXT_LIST];
    int count;
} TextList;

void text_append(Text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Writes a character as UTF-8, four bytes at most, U+FFFD where there is no such character; returns how many bytes it takes.
size_t text_utf8(char *out, unsigned long code);

#endif
