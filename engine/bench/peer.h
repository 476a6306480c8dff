// peer.h - an external visibility compiler on the same portal file, to compare with: any program that reads NAME.prt
// beside NAME.bsp (Quake, version 29) and writes visibility into the latter, called `PROGRAM -threads N NAME.bsp`.
#ifndef BENCH_PEER_H
#define BENCH_PEER_H

#include "engine/core/file.h"

typedef struct PeerRun {
    double cpu_seconds, wall_seconds;
    double peak_mb;  // at least what this process holds when it starts the program
    uint64_t
        *seen;  // as PairSet.seen, but as the program left it: neither symmetric nor with its diagonal set
    int cell_count;
} PeerRun;

// In a new folder, so that nothing of an earlier run is found there. Fails with a sentence on what the program said.
bool peer_run(const char *program, const char *file, int threads, Arena *arena, PeerRun *out, Error *error);

#endif
