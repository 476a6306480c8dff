// fuzz_photometry.c - libFuzzer on the readers of photometric files. Input: the bytes of a file. What is read has ascending angles, and
// sends light in every direction that can be asked for, never less than none, of the flux that was found.
#include <math.h>
#include <stdlib.h>

#include "maps/photometry/photometry_file.h"
#include "tests/fuzz/target.h"

static void check_angles(const double *angle, int count) {
    for (int i = 0; i < count; i++)
        if (!isfinite(angle[i]) || (i > 0 && !(angle[i] > angle[i - 1]))) abort();
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    Photometry table;
    Error error = {""};
    if (!photometry_read("fuzz", target_bytes(arena, "", data, size), arena, &table, &error)) {
        if (error.text[0] == 0) abort();
        return 0;
    }
    target_count(TARGET_PASSED);
    check_angles(table.gamma, table.gamma_count);
    if (table.plane_count > 1) check_angles(table.plane, table.plane_count);
    double lumens = photometry_lumens(&table);
    if (!(lumens > 0) || !isfinite(lumens) || !(table.size[0] >= 0) || !(table.size[1] >= 0)) abort();
    for (int i = 0; i < 100; i++) {
        double candela = photometry_candela(&table, i * 1.8, i * 37.0 - 800);
        if (!(candela >= 0) || !isfinite(candela)) abort();
    }
    return 0;
}
