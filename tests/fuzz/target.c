// target.c - bytes for fuzz targets, the files they find, how far they come, and the target that all readers share.
#include "tests/fuzz/target.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

// The file of ENFILADE_TALLY: 64-bit numbers, little-endian.
typedef struct Tally {
    uint64_t stage[TARGET_STAGES];
    uint64_t cpu;  // microseconds
} Tally;

// Shared with the file, so that nothing is lost however the process ends.
static Tally *open_tally(void) {
    const char *path = getenv("ENFILADE_TALLY");
    int fd = path ? open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666) : -1;
    if (fd < 0) return calloc(1, sizeof(Tally));
    if (ftruncate(fd, sizeof(Tally)) != 0) abort();
    Tally *tally = mmap(NULL, sizeof *tally, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (tally == MAP_FAILED) abort();
    return tally;
}

static uint64_t cpu_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000 + (uint64_t)t.tv_nsec / 1000;
}

void target_count(TargetStage stage) {
    enum { SOMETIMES = 64 };  // the clock is read
    static Tally *tally;
    static uint64_t tries, before;
    if (!tally) tally = open_tally();
    tally->stage[stage]++;
    if (stage != TARGET_TRIED || tries++ % SOMETIMES != 0) return;
    uint64_t now = cpu_now();
    tally->cpu += now - before;
    before = now;
}

Arena *target_begin(void) {
    static Arena arena;
    arena_reset(&arena);
    target_count(TARGET_TRIED);
    return &arena;
}

// The counters of builds for libFuzzer (-fsanitize-coverage=inline-8bit-counters): from here to there.
extern unsigned char __start___sancov_cntrs[] __attribute__((weak));
extern unsigned char __stop___sancov_cntrs[] __attribute__((weak));

void target_forget(void) {
    if (__start___sancov_cntrs)
        memset(__start___sancov_cntrs, 0, (size_t)(__stop___sancov_cntrs - __start___sancov_cntrs));
}

Bytes target_bytes(Arena *arena, const char *head, const unsigned char *data, size_t size) {
    size_t before = strlen(head);
    unsigned char *copy = arena_alloc(arena, before + size + 1, 1);
    memcpy(copy, head, before);
    if (size > 0) memcpy(copy + before, data, size);
    return (Bytes){copy, before + size};
}

static const TargetFile *served;
static int served_count;

void target_serve(const TargetFile *files, int count) {
    served = files;
    served_count = count;
}

// The linker puts this in the place of file_read (--wrap), and file_read in that of the other.
bool __real_file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error);
bool __wrap_file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error);
bool __wrap_file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error) {
    for (int i = 0; i < served_count; i++) {
        if (strcmp(served[i].path, path) != 0) continue;
        const Bytes *content = &served[i].content;
        if (content->size > limit)
            return error_set(error, "%s: has %zu bytes (at most %zu are read)", path, content->size, limit);
        *out = target_bytes(arena, "", content->data, content->size);
        return true;
    }
    if (served_count > 0) return error_set(error, "%s: cannot be opened: it is not served", path);
    return __real_file_read(path, limit, arena, out, error);
}

bool target_read(const MapsReader *reader, const char *path, Bytes content, Arena *arena, Building *out) {
    Error error = {""};
    bool read = reader->read(path, content, arena, out, &error);
    if (!read && error.text[0] == 0) abort();
    if (read) target_count(TARGET_PASSED);
    return read;
}

int target_reader(const MapsReader *reader, const char *path, const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    Building b = {0};
    const char *fault;
    Bytes content = target_bytes(arena, "", data, size);
    reader->recognise(content);
    if (target_read(reader, path, content, arena, &b) && building_check(&b, arena, &fault, 1) != 0) {
        fprintf(stderr, "read, but faulty: %s\n", fault);
        abort();
    }
    return 0;
}
