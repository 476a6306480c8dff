// fail_malloc.c - a library to preload (check_no_memory.sh): the FAIL_AT-th request for memory by anyone, counted from main on, finds
// none. FAIL_LOG gets who asked for that, the libraries on the stack from the innermost out, or how many requests there were.
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static atomic_long requests;
static atomic_bool counting;
static long failing;

static void write_log(const char *text) {
    const char *path = getenv("FAIL_LOG");
    int fd = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    if (fd < 0 || write(fd, text, strlen(text)) < 0) return;
    close(fd);
}

static void log_stack(void) {
    void *frame[32];
    char text[1024] = "";
    const char *last = "";
    int count = backtrace(frame, 32);
    for (int i = 2; i < count; i++) {
        Dl_info at;
        if (!dladdr(frame[i], &at) || !at.dli_fname || strcmp(at.dli_fname, last) == 0) continue;
        last = at.dli_fname;
        const char *slash = strrchr(last, '/');
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s ", slash ? slash + 1 : last);
    }
    write_log(text);
}

static int fails(void) {
    if (!atomic_load(&counting) || atomic_fetch_add(&requests, 1) + 1 != failing) return 0;
    log_stack();
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return fails() ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return fails() ? NULL : __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return fails() ? NULL : __libc_realloc(old, size); }
void *aligned_alloc(size_t alignment, size_t size) {
    return fails() ? NULL : __libc_memalign(alignment, size);
}
void *memalign(size_t alignment, size_t size) { return fails() ? NULL : __libc_memalign(alignment, size); }
int posix_memalign(void **out, size_t alignment, size_t size) {
    *out = fails() ? NULL : __libc_memalign(alignment, size);
    return *out ? 0 : ENOMEM;
}

// ---- from main on: what libraries ask for when they are loaded is theirs

static int (*program)(int, char **, char **);

static int begin(int argc, char **argv, char **environment) {
    void *frame[4];
    char text[32];
    backtrace(frame, 4);  // loads what it needs
    const char *at = getenv("FAIL_AT");
    failing = at ? atol(at) : 0;
    atomic_store(&counting, 1);
    int status = program(argc, argv, environment);
    atomic_store(&counting, 0);
    if (failing == 0) {
        snprintf(text, sizeof text, "%ld", atomic_load(&requests));
        write_log(text);
    }
    return status;
}

int __libc_start_main(int (*entry)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loaded)(void), void *stack) {
    int (*real)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void), void (*)(void),
                void *);
    *(void **)&real = dlsym(RTLD_NEXT, "__libc_start_main");
    program = entry;
    return real(begin, argc, argv, init, fini, loaded, stack);
}
