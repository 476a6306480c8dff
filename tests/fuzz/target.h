// target.h - what fuzz targets share. Each is a file fuzz_NAME.c with the one function below, called by libFuzzer or by
// try_fuzz.c; it aborts where the code under test does not keep its word.
#ifndef TESTS_TARGET_H
#define TESTS_TARGET_H

#include "maps/maps.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

// How far inputs came, counted in the file that ENFILADE_TALLY names, which adds up over all runs: tests/fuzz/fuzz.sh.
typedef enum TargetStage {
    TARGET_TRIED,   // by target_begin
    TARGET_PASSED,  // a reader made something of it
    TARGET_CELLS,   // cells and trees
    TARGET_WALKED,  // a body stood somewhere and went
    TARGET_SHOT,    // ten shots
    TARGET_STAGES
} TargetStage;
void target_count(TargetStage stage);

// The code that this try ran so far counts as not run: libFuzzer does not build on the input.
void target_forget(void);

// Counts a try, and returns an empty arena for it, which the next try empties again.
Arena *target_begin(void);

// The fuzzer's bytes behind `head` ("" for none), as file_read would give them.
Bytes target_bytes(Arena *arena, const char *head, const unsigned char *data, size_t size);

// The files that file_read finds from now on, by their names; it looks for others where files are. `count` 0: none.
typedef struct TargetFile {
    const char *path;
    Bytes content;
} TargetFile;
void target_serve(const TargetFile *files, int count);

// Whatever the bytes, the reader reads a building, or refuses with a sentence.
bool target_read(const MapsReader *reader, const char *path, Bytes content, Arena *arena, Building *out);

// A whole target: what is read passes the check, too. Returns 0.
int target_reader(const MapsReader *reader, const char *path, const unsigned char *data, size_t size);

#endif
