// target.h - what fuzz targets share. Each is a file fuzz_NAME.c with the one function below, called by libFuzzer or by
// try_fuzz.c; it aborts where the code under test does not keep its word.
#ifndef TESTS_TARGET_H
#define TESTS_TARGET_H

#include "maps/maps.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

// The fuzzer's bytes behind `head` ("" for none), as file_read would give them.
Bytes target_bytes(Arena *arena, const char *head, const unsigned char *data, size_t size);

// Whatever the bytes, the reader reads a building, or refuses with a sentence.
bool target_read(const MapsReader *reader, const char *path, Bytes content, Arena *arena, Building *out);

// A whole target: what is read passes the check, too. Returns 0.
int target_reader(const MapsReader *reader, const char *path, const unsigned char *data, size_t size);

#endif
