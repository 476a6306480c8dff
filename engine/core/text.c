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
