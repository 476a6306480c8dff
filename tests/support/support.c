// support.c - paths, temporary folders and commands for tests.
#include "tests/support/support.h"

#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <criterion/criterion.h>
#include <png.h>

enum { READ_LIMIT = 1 << 30, MAX_FOLDERS = 64, OPEN_FOLDERS = 16 };

static char folders[MAX_FOLDERS][64];
static int folder_count;

static char shared_path[512];

bool support_has_shared(const char *name) {
    snprintf(shared_path, sizeof shared_path, "../shared/data/%s", name);
    return access(shared_path, R_OK) == 0;
}

const char *support_shared(const char *name) {
    if (!support_has_shared(name)) cr_skip_test("%s is not here", shared_path);
    return shared_path;
}

const char *support_either(const char *name, const char *own) {
    return support_has_shared(name) ? shared_path : own;
}

const char *support_build(void) {
    const char *build = getenv("ENFILADE_BUILD");
    return build && *build ? build : "build/release";
}

bool support_soak(void) {
    const char *soak = getenv("ENFILADE_SOAK");
    return soak && *soak;
}

int support_count(int quick, int at_soak) { return support_soak() ? at_soak : quick; }

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *at) {
    (void)status, (void)type, (void)at;
    return remove(path);
}

static void remove_folders(void) {
    for (int i = 0; i < folder_count; i++) nftw(folders[i], remove_entry, OPEN_FOLDERS, FTW_DEPTH | FTW_PHYS);
}

char *support_folder(Arena *arena) {
    cr_assert_lt(folder_count, MAX_FOLDERS, "a test makes more than %d folders", MAX_FOLDERS);
    if (folder_count == 0) atexit(remove_folders);
    char *path = folders[folder_count];
    snprintf(path, sizeof folders[0], "/tmp/enfilade-test-XXXXXX");
    cr_assert_not_null(mkdtemp(path), "no temporary folder");
    folder_count++;
    return arena_string(arena, path);
}

Bytes support_png(Arena *arena, int width, int height, const uint8_t *pixels) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = 0;
    cr_assert(png_image_write_to_memory(&image, NULL, &size, 0, pixels, 0, NULL));
    Bytes out = {arena_alloc(arena, size, 1), size};
    cr_assert(png_image_write_to_memory(&image, out.data, &size, 0, pixels, 0, NULL));
    return out;
}

Bytes support_read(Arena *arena, const char *path) {
    Bytes bytes = {0};
    Error error = {""};
    cr_assert(file_read(path, READ_LIMIT, arena, &bytes, &error), "%s", error.text);
    return bytes;
}

int support_run(Arena *arena, char **output, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    char *command = NULL;
    int length = vasprintf(&command, format, arguments);
    va_end(arguments);
    cr_assert_geq(length, 0);
    char *joined = arena_format(arena, "{ %s\n} 2>&1", command);
    free(command);
    FILE *pipe = popen(joined, "r");
    cr_assert_not_null(pipe, "cannot run %s", joined);
    char *text = NULL;
    size_t size = 0, used;
    char part[4096];
    FILE *memory = open_memstream(&text, &size);
    while ((used = fread(part, 1, sizeof part, pipe)) > 0) fwrite(part, 1, used, memory);
    fclose(memory);
    int status = pclose(pipe);
    if (output) *output = arena_string(arena, text);
    free(text);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// ---- kills

static bool changes_files(const struct __ptrace_syscall_info *info) {
    switch (info->entry.nr) {
    case SYS_openat:
        return info->entry.args[2] & (O_WRONLY | O_RDWR);
    case SYS_write:
    case SYS_pwrite64:
    case SYS_writev:
    case SYS_sendto:  // to ffmpeg, which writes
    case SYS_ftruncate:
    case SYS_fallocate:
    case SYS_fchmod:
    case SYS_fchown:
    case SYS_fsetxattr:
    case SYS_fsync:
    case SYS_linkat:
#ifdef SYS_rename  // newer processors' Linux has the calls with a folder alone
    case SYS_rename:
    case SYS_unlink:
    case SYS_mkdir:
#endif
    case SYS_exit_group:
        return true;
    default:
        return false;
    }
}

_Noreturn static void be_traced(void (*work)(void *context), void *context) {
    enum { NOT_ALLOWED = 125 };
    if (ptrace(PTRACE_TRACEME, 0, NULL, NULL) != 0) _exit(NOT_ALLOWED);
    raise(SIGSTOP);
    work(context);
    _exit(0);
}

int support_kill(int moment, void (*work)(void *context), void *context) {
    pid_t child = fork();
    cr_assert(child >= 0);
    if (child == 0) be_traced(work, context);
    int status, passed = 0, signal = 0;
    cr_assert_eq(waitpid(child, &status, 0), child);
    if (!WIFSTOPPED(status)) cr_skip_test("processes cannot be traced");
    ptrace(PTRACE_SETOPTIONS, child, NULL, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
    for (bool counts = false;;) {
        struct __ptrace_syscall_info info;
        ptrace(PTRACE_SYSCALL, child, NULL, signal);
        cr_assert_eq(waitpid(child, &status, 0), child);
        if (!WIFSTOPPED(status)) return passed;
        bool call = WSTOPSIG(status) == (SIGTRAP | 0x80);
        signal = call || WSTOPSIG(status) == SIGTRAP ? 0 : WSTOPSIG(status);
        if (!call || ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof info, &info) <= 0) continue;
        if (info.op == PTRACE_SYSCALL_INFO_ENTRY) counts = changes_files(&info);
        if (!counts || passed++ != moment) continue;
        kill(child, SIGKILL);
        waitpid(child, &status, 0);
        return -1;
    }
}
