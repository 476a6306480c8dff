// peer.h - programs of others that a benchmark runs beside its own methods.
#ifndef BENCH_PEER_H
#define BENCH_PEER_H

#include "engine/core/file.h"

// Time and memory of a program that was run.
typedef struct PeerUsage {
    double cpu_seconds, wall_seconds;
    double peak_mb;  // at least the memory that this process holds when it starts the program
} PeerUsage;

// Makes a new folder below TMPDIR, so that no program finds files of an earlier run, and lets `use` work in it; then removes it with all
// that it holds, also where `use` fails or memory ends.
bool peer_in_folder(bool (*use)(const char *folder, void *context, Arena *arena, Error *error), void *context,
                    Arena *arena, Error *error);

// Runs a program, found as a shell finds it, and waits for its end. `words`, the last one NULL, are its name and arguments. What it writes
// goes to `folder`/log. An exit status other than 0 is a fault, with the last line that it wrote.
bool peer_run(const char *const *words, const char *folder, Arena *arena, PeerUsage *out, Error *error);

#endif
