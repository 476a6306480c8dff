// support.h - what tests share: where things lie, how much to try, and folders that vanish.
#ifndef TESTS_SUPPORT_H
#define TESTS_SUPPORT_H

#include <stdbool.h>

#include "engine/core/file.h"

// `../shared/data/NAME`; skips the running test, saying so, where it is absent.
const char *support_shared(const char *name);

// Whether that is there; and its path, or `own`, a path of the project, where it is absent: the same test on what every clone has.
bool support_has_shared(const char *name);
const char *support_either(const char *name, const char *own);

// `build/release`, or the configuration under test: the program is `%s/enfilade`.
const char *support_build(void);

bool support_soak(void);                    // `make soak`: take your time
int support_count(int quick, int at_soak);  // how many cases to try

// A new folder, removed with all it holds when the test's process ends. In `arena`.
char *support_folder(Arena *arena);

// A PNG image of pixels [height * width * 4], red, green, blue and opacity.
Bytes support_png(Arena *arena, int width, int height, const uint8_t *pixels);

// The whole file; fails the running test when it cannot be read.
Bytes support_read(Arena *arena, const char *path);

// Runs a shell command, standard error with standard output; both in `output` (may be NULL). Returns the exit
// status, 128 + the signal's number when a signal ended it.
int support_run(Arena *arena, char **output, const char *format, ...) __attribute__((format(printf, 3, 4)));

// Runs `work` in a process of its own, and kills it at the given moment: 0, 1 are before and after its first system call that may
// change a file, 2, 3 of its second, ...; only calls of its first thread count. Returns how many moments there were, or -1 when it
// was killed. Skips the running test where processes cannot be traced.
int support_kill(int moment, void (*work)(void *context), void *context);

#endif
