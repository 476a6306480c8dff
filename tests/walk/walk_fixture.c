// walk_fixture.c - see the header.
#include "tests/walk/walk_fixture.h"

#include <criterion/criterion.h>

#include "maps/maps.h"
#include "tests/support/support.h"

void walk_check_open_building(Walked *w, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    *w = (Walked){0};
    cr_assert(maps_read(path, &w->arena, &w->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&w->building, &options, &w->arena, &w->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&w->graph, &options, NULL, &w->arena, &w->forest));
    w->doors = ARENA_ARRAY(&w->arena, float, w->building.opening_count + 1);
}
