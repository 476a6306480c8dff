// text.c - appending formatted text to a growing buffer.
#include "engine/core/text.h"

#include <stdarg.h>
#include <stdio.h>

#include "engine/core/error.h"

void text_append(Text *text, const char *format, ...) {
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, format, args);
    CORE_ASSERT(length >= 0);
    size_t need = (size_t)length + 1;
    if (text->size + need > text->capacity) {
        text->capacity = 2 * (text->capacity + need);
        char *larger = arena_alloc(text->arena, text->capacity, 1);
        if (text->size) memcpy(larger, text->data, text->size);
        text->data = larger;
    }
    vsnprintf(text->data + text->size, need, format, again);
    text->size += need - 1;
    va_end(again);
    va_end(args);
}

size_t text_utf8(char *out, unsigned long code) {
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
