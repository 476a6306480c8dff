// error.c - formatting of error sentences, and the assertion that stays in release builds.
#include "engine/core/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

bool error_set(Error *error, const char *format, ...) {
    if (!error) return false;
    va_list args;
    va_start(args, format);
    vsnprintf(error->text, sizeof error->text, format, args);
    va_end(args);
    return false;
}

void error_assert(const char *condition, const char *file, int line) {
    fprintf(stderr, "enfilade: %s:%d: broken: %s\n", file, line, condition);
    abort();
}
