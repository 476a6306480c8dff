// file_fixture.h - files that tests write, and what is in a folder.
#ifndef TESTS_FILE_FIXTURE_H
#define TESTS_FILE_FIXTURE_H

#include <sys/types.h>

#include "engine/core/file.h"
#include "tests/support/support.h"

enum { LARGE = 8 << 20, NOBODY = 65534 };

int file_files_in(const char *folder);

struct stat file_info_of(const char *path);

void file_expect_text(Arena *arena, const char *path, const char *text);

void file_put(const char *path, const char *text, mode_t mode);

typedef struct Writing {
    const char *path, *text, *root;
} Writing;

#endif
