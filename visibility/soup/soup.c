// soup.c - cells of a building that is polygons alone.
//
// Source: S. J. Teller & C. H. Sequin, Visibility Preprocessing for Interactive Walkthroughs, 1991, section 2: a spatial
// partition along the major opaque polygons, and portals on what is transparent of its boundaries. Departures: the planes
// are those of the polygons, so that a building need not stand along the axes, and cells that hide nothing from each
// other are joined again.
#include "visibility/soup/soup.h"

#include "engine/core/error.h"
#include "engine/core/memory.h"

bool build_soup(CellBuilder *builder, Error *error) {
    const Building *b = builder->building;
    if (b->polygon_count == 0) return error_set(error, "%s: has no polygons", b->source);
    Soup soup = {.builder = builder, .scratch = builder->scratch};
    soup_find_planes(&soup);
    soup_part(&soup);
    if (!memory_within(error)) return false;
    soup_join(&soup);
    soup_write_cells(&soup);
    soup_write_portals(&soup);
    if (!memory_within(error)) return false;
    soup_write_objects(&soup);
    soup_close_seams(&soup);
    builder->graph->touch = 4 * SOUP_SNAP * soup.size;
    return true;
}
