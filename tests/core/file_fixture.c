// file_fixture.c - see the header.
#include "tests/core/file_fixture.h"

#include <criterion/criterion.h>
#include <dirent.h>
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/support/support.h"

int file_files_in(const char *folder) {
    DIR *dir = opendir(folder);
    int count = 0;
    cr_assert(dir);
    for (const struct dirent *entry; (entry = readdir(dir));) count += entry->d_name[0] != '.';
    closedir(dir);
    return count;
}

struct stat file_info_of(const char *path) {
    struct stat info;
    cr_assert_eq(lstat(path, &info), 0, "%s is not there", path);
    return info;
}

void file_expect_text(Arena *arena, const char *path, const char *text) {
    cr_expect_str_eq((char *)support_read(arena, path).data, text, "%s", path);
}

void file_put(const char *path, const char *text, mode_t mode) {
    Error error;
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert_eq(chmod(path, mode), 0);
}
