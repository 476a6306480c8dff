// foreign.c - assimp (Open Asset Import Library) behind a wall: see foreign.h. The process that reads is a fork, so that it needs no
// program of its own and shares the file's bytes; the text it writes comes back through a pipe.
#include "maps/polygons/foreign.h"

#include <assimp/cexport.h>
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const double MOST_WAIT = 300;  // seconds, while other programs have the processors

static bool is_3ds(Bytes content) {
    // A chunk 4D4D, in whose length the version or the editor chunk fits.
    return content.size > 16 && content.data[0] == 0x4D && content.data[1] == 0x4D &&
           (content.data[6] == 0x02 || content.data[6] == 0x3D || content.data[6] == 0x3E);
}

bool foreign_recognise(Bytes content) {
    static const char MARK[] = "<COLLADA";
    size_t head = content.size < 4096 ? content.size : 4096;
    return is_3ds(content) || memmem(content.data, head, MARK, sizeof MARK - 1) != NULL;
}

bool foreign_is_library(const char *name) {
    size_t length = strlen(name);
    return length >= 4 && strcmp(name + length - 4, ".mtl") == 0;
}

// ---- in the process that reads

// The one file that there is.
typedef struct Only {
    Bytes content;
    size_t at;
} Only;

static size_t only_read(struct aiFile *file, char *to, size_t size, size_t count) {
    Only *only = (Only *)file->UserData;
    if (size == 0) return 0;
    size_t left = (only->content.size - only->at) / size, taken = count < left ? count : left;
    memcpy(to, only->content.data + only->at, taken * size);
    only->at += taken * size;
    return taken;
}
static size_t only_write(struct aiFile *file, const char *from, size_t size, size_t count) {
    (void)file, (void)from, (void)size, (void)count;
    return 0;
}
static size_t only_tell(struct aiFile *file) { return ((Only *)file->UserData)->at; }
static size_t only_size(struct aiFile *file) { return ((Only *)file->UserData)->content.size; }
static enum aiReturn only_seek(struct aiFile *file, size_t by, enum aiOrigin from) {
    Only *only = (Only *)file->UserData;
    size_t size = only->content.size, base = from == aiOrigin_SET   ? 0
                                             : from == aiOrigin_CUR ? only->at
                                                                    : size;
    if (from == aiOrigin_END ? by > size : by > size - base) return aiReturn_FAILURE;
    only->at = from == aiOrigin_END ? size - by : base + by;
    return aiReturn_SUCCESS;
}
static void only_flush(struct aiFile *file) { (void)file; }

static struct aiFile *only_open(struct aiFileIO *io, const char *name, const char *mode) {
    static struct aiFile file;
    static Only only;
    if (strcmp(name, "model.3ds") != 0 && strcmp(name, "model.dae") != 0) return NULL;
    if (!strchr(mode, 'r')) return NULL;
    only = (Only){.content = *(const Bytes *)(const void *)io->UserData};
    file = (struct aiFile){only_read, only_write, only_tell, only_size, only_seek, only_flush, (char *)&only};
    return &file;
}
static void only_close(struct aiFileIO *io, struct aiFile *file) { (void)io, (void)file; }

static bool write_all(int to, const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        ssize_t written = write(to, at, size);
        if (written <= 0) return false;
        at += written;
        size -= (size_t)written;
    }
    return true;
}

static void limit(int what, size_t most) {
    struct rlimit l = {most, most};
    setrlimit(what, &l);
}

static size_t memory_in_use(void) {
    size_t pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    if (f) {
        if (fscanf(f, "%zu", &pages) != 1) pages = 0;
        fclose(f);
    }
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

// Sizes of both texts, then both. Never returns.
static void convert(Bytes content, size_t in_use, int to) {
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, 0);
    limit(RLIMIT_NOFILE, 0);
    limit(RLIMIT_CPU, FOREIGN_MAX_SECONDS);
    if (in_use > 0) limit(RLIMIT_AS, in_use + FOREIGN_MAX_MEMORY);
    struct aiFileIO io = {only_open, only_close, (char *)&content};
    const struct aiScene *scene =
        aiImportFileEx(is_3ds(content) ? "model.3ds" : "model.dae", aiProcess_ValidateDataStructure, &io);
    const struct aiExportDataBlob *obj = scene ? aiExportSceneToBlob(scene, "obj", 0) : NULL,
                                  *library = obj ? obj->next : NULL;
    size_t sizes[2] = {obj ? obj->size : 0, library ? library->size : 0};
    bool good = obj && sizes[0] <= FOREIGN_MAX_TEXT && sizes[1] <= FOREIGN_MAX_TEXT &&
                write_all(to, sizes, sizeof sizes) && write_all(to, obj->data, sizes[0]) &&
                (!library || write_all(to, library->data, sizes[1]));
    _exit(good ? 0 : 1);
}

// ---- here

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool read_all(int from, void *data, size_t size, double deadline) {
    char *at = data;
    while (size > 0) {
        struct pollfd ready = {from, POLLIN, 0};
        double left = deadline - now();
        if (left <= 0 || poll(&ready, 1, (int)(1000 * left) + 1) <= 0) return false;
        ssize_t got = read(from, at, size);
        if (got <= 0) return false;
        at += got;
        size -= (size_t)got;
    }
    return true;
}

static bool read_text(int from, size_t size, double deadline, Arena *arena, Bytes *out) {
    *out = (Bytes){arena_alloc(arena, size + 1, 1), size};
    return read_all(from, out->data, size, deadline);
}

bool foreign_as_obj(const char *path, Bytes content, Arena *arena, Bytes *obj, Bytes *library, Error *error) {
    if (content.size > FOREIGN_MAX_BYTES)
        return error_set(error, "%s: has %zu bytes (allowed of 3DS and COLLADA: %zu)", path, content.size,
                         FOREIGN_MAX_BYTES);
    int ends[2];
    size_t in_use = memory_in_use();
    if (pipe(ends) != 0) return error_set(error, "%s: no pipe to a process that reads it", path);
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        convert(content, in_use, ends[1]);
    }
    close(ends[1]);
    double deadline = now() + MOST_WAIT;
    size_t sizes[2];
    bool good = child > 0 && read_all(ends[0], sizes, sizeof sizes, deadline) &&
                sizes[0] <= FOREIGN_MAX_TEXT && sizes[1] <= FOREIGN_MAX_TEXT &&
                read_text(ends[0], sizes[0], deadline, arena, obj) &&
                read_text(ends[0], sizes[1], deadline, arena, library);
    close(ends[0]);
    if (child > 0) {
        if (!good) kill(child, SIGKILL);
        waitpid(child, NULL, 0);
    }
    if (good) return true;
    return error_set(
        error,
        "%s: is no %s model that can be read within %d seconds and %zu bytes of memory (or is damaged)", path,
        is_3ds(content) ? "3DS" : "COLLADA", FOREIGN_MAX_SECONDS, FOREIGN_MAX_MEMORY);
}
