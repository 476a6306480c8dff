// store_target.h - what the fuzz targets on derived files (engine/core/file.h) share: a building of two rooms, a valid file of
// it, and the files that the fuzzer's bytes stand for.
#ifndef TESTS_STORE_TARGET_H
#define TESTS_STORE_TARGET_H

#include "engine/core/file.h"
#include "tests/fuzz/target.h"
#include "visibility/vis.h"

typedef struct StoreTarget {
    size_t header;  // bytes of the whole header
    bool rest_sum;  // behind its head stands a checksum of the rest of it, hashed with the version
    Arena arena;
    Building building;  // two rooms with a door between, a lamp's light on its leaf
    CellGraph graph;
    StabForest forest;
    char saved[64];  // where store_target_keep expects a valid file
    Bytes valid;
    int served;     // a file without a name
    char path[64];  // where readers find it
} StoreTarget;

// Makes all but the valid file, which the caller saves before store_target_keep.
void store_target_start(StoreTarget *target);
void store_target_keep(StoreTarget *target);

// Serves the valid file as it is, of which a reader must make something: else all that is tried would end at its beginning.
void store_target_put_valid(StoreTarget *target);
// Serves the file that the fuzzer's bytes stand for. The first byte says what the others are: the file itself, the file behind a head
// whose hashes are right, or changes to the valid file; of the last two the checksums are put right. So neither hashes nor checksums
// keep the fuzzer from what lies behind them.
void store_target_put(StoreTarget *target, const unsigned char *data, size_t size, Arena *arena);

#endif
