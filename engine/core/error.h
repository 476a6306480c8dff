// error.h - one sentence that names the place of an error, the value that was found and the values that are allowed.
#ifndef CORE_ERROR_H
#define CORE_ERROR_H

#include <stdbool.h>

// `office.plan:41: polygon 7 bends by 0.02 m (limit 0.001)`
typedef struct Error {
    char text[1024];
} Error;

// Always returns false, so that a reader can `return error_set(error, ...)`. `error` may be NULL.
bool error_set(Error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

// For mistakes of the program itself, never for bad input: if the condition is false, prints the place and aborts, in release
// builds too.
#define CORE_ASSERT(condition) ((condition) ? (void)0 : error_assert(#condition, __FILE__, __LINE__))
// Called by CORE_ASSERT.
void error_assert(const char *condition, const char *file, int line) __attribute__((noreturn));

#endif
