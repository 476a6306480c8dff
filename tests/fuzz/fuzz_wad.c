// fuzz_wad.c - libFuzzer on the reader of Doom WADs: whatever the bytes, it reads a building that passes the check and
// can be cut into cells, or refuses with a sentence. Random bytes hardly ever are a map, so those that do not begin as a
// file are numbers that change some of a small map.
#include <stdlib.h>

#include "tests/fuzz/target.h"
#include "tests/support/files/wad_builder.h"
#include "visibility/vis.h"

extern const MapsReader MAPS_READER_WAD;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    Building b = {0};
    const char *fault;
    Bytes content = target_bytes(arena, "", data, size);
    if (!MAPS_READER_WAD.recognise(content)) content = wad_spoilt(arena, data, size);
    // A map whose lines cross where they should meet may be refused by the check, as a file is.
    if (target_read(&MAPS_READER_WAD, "fuzz.wad", content, arena, &b) &&
        building_check(&b, arena, &fault, 1) == 0) {
        CellGraph graph;
        VisOptions options = vis_default_options();
        if (!vis_build_cells(&b, &options, arena, &graph, NULL)) abort();
    }
    return 0;
}
