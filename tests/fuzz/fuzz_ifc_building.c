// fuzz_ifc_building.c - libFuzzer on building models as buildings: rooms, doors and bodies of whatever the model has.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_IFC;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_IFC, "fuzz.ifc", data, size);
}
