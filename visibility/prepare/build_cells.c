// build_cells.c - the cell graph of a building of any form.
#include "visibility/cells/build.h"
#include "visibility/soup/soup.h"

VisOptions vis_default_options(void) { return (VisOptions){.square = 1.0, .threads = 0, .max_nodes = 5000}; }

bool vis_build_cells(const Building *building, const VisOptions *options, Arena *arena, CellGraph *out,
                     Error *error) {
    if (!(options->square >= 0.25 && options->square <= 100)) {
        return error_set(error, "the squares are %g m wide (allowed 0.25 to 100)", options->square);
    }
    Arena scratch = {0};
    *out = (CellGraph){.building = building, .touch = VIS_TOUCH};
    CellBuilder builder = {
        .building = building, .options = options, .arena = arena, .scratch = &scratch, .graph = out};
    bool good = false;
    switch (building->form) {
    case FORM_REGIONS:
        good = build_regions(&builder, error);
        break;
    case FORM_SOUP:
        good = build_soup(&builder, error);
        break;
    case FORM_CELLS:
        good = build_given(&builder, error);
        break;
    default:
        CORE_ASSERT(!"a building's form");
    }
    if (good) {
        build_locator(&builder);
        build_squares(&builder);
    }
    arena_free(&scratch);
    return good;
}
