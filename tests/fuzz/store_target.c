// store_target.c - files for the fuzz targets on what the program stores.
#include "tests/fuzz/store_target.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

extern const MapsReader MAPS_READER_PLAN;

static const char PLAN[] = "plan 1\nmaterial lamp #FFFFFF emission 12\nstorey s floor 0 height 3\n"
                           "room a 0,0 4,0 4,4 0,4 wall 0.2\nroom b 4.2,0 8,0 8,4 4.2,4 wall 0.2\n"
                           "door d 4.1,2 angle 90 width 1 height 2 material lamp\n";

void store_target_start(StoreTarget *t) {
    Bytes text = target_bytes(&t->arena, PLAN, NULL, 0);
    VisOptions options = vis_default_options();
    options.threads = 1;
    snprintf(t->saved, sizeof t->saved, "/tmp/enfilade-fuzz-XXXXXX");
    int saved = mkstemp(t->saved);
    if (saved < 0 || !target_read(&MAPS_READER_PLAN, "fuzz.plan", text, &t->arena, &t->building) ||
        !vis_build_cells(&t->building, &options, &t->arena, &t->graph, NULL) ||
        !vis_build_forest(&t->graph, &options, NULL, &t->arena, &t->forest))
        abort();
    close(saved);
    t->served = memfd_create("stored", 0);
    if (t->served < 0) abort();
    snprintf(t->path, sizeof t->path, "/proc/self/fd/%d", t->served);
}

// The first byte of an input tells how the others are taken.
enum { AS_IT_IS, BEHIND_HEAD, CHANGES, KINDS };

static void sum_rest(const StoreTarget *t, unsigned char *file) {
    DerivedHead head;
    memcpy(&head, file, sizeof head);
    size_t rest = sizeof head + sizeof(uint64_t);
    uint64_t sum = file_hash(file + rest, t->header - rest, head.version);
    memcpy(file + sizeof head, &sum, sizeof sum);
}

static Bytes file_of(const StoreTarget *t, const unsigned char *data, size_t size, Arena *arena) {
    int kind = size > 0 ? data[0] % KINDS : AS_IT_IS;
    size_t given = size > 0 ? size - 1 : 0, length = given, sum_at = offsetof(DerivedHead, body);
    if (kind == CHANGES && length < t->valid.size) length = t->valid.size;
    unsigned char *file = arena_alloc(arena, length + 1, 1);
    if (kind == CHANGES) memcpy(file, t->valid.data, t->valid.size);
    for (size_t i = 0; i < given; i++) file[i] ^= data[i + 1];
    if (kind == BEHIND_HEAD && length >= sum_at) memcpy(file, t->valid.data, sum_at);
    if (kind != AS_IT_IS && length >= t->header) {
        uint64_t sum = file_hash(file + t->header, length - t->header, 0);
        memcpy(file + sum_at, &sum, sizeof sum);
        if (t->rest_sum) sum_rest(t, file);
    }
    return (Bytes){file, length};
}

void store_target_keep(StoreTarget *t) {
    bool good = file_read(t->saved, 1 << 20, &t->arena, &t->valid, NULL);
    unlink(t->saved);
    if (!good || t->valid.size < t->header) abort();
    // Else the checksums that are put right would be wrong, and nothing behind them would be tried.
    static const unsigned char NO_CHANGES = CHANGES;
    if (memcmp(file_of(t, &NO_CHANGES, 1, &t->arena).data, t->valid.data, t->valid.size) != 0) abort();
}

static void serve(const StoreTarget *t, Bytes file) {
    if (ftruncate(t->served, 0) != 0 || pwrite(t->served, file.data, file.size, 0) != (ssize_t)file.size)
        abort();
}

void store_target_put_valid(StoreTarget *t) { serve(t, t->valid); }

void store_target_put(StoreTarget *t, const unsigned char *data, size_t size, Arena *arena) {
    serve(t, file_of(t, data, size, arena));
}
