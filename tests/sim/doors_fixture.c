// doors_fixture.c - see the header.
#include "tests/sim/doors_fixture.h"

#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/support.h"

static const char ROOMS[] = "plan 1\nstorey s floor 0 height 2.6\n"
                            "room west 0,0 4,0 4,4 0,4 wall 0.15\n"
                            "room east 4.15,0 8.15,0 8.15,4 4.15,4 wall 0.15\n";

void doors_check_make(Made *m, const char *doors) {
    Error error;
    VisOptions options = vis_default_options();
    *m = (Made){.body = {.cell = -1}};
    char *path = arena_format(&m->arena, "%s/doors.plan", support_folder(&m->arena));
    char *text = arena_format(&m->arena, "%s%s", ROOMS, doors);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    m->doors = doors_new(&m->graph, &m->arena);
    m->world = body_world(&m->graph, m->doors.open, &m->arena);
    cr_assert(body_place_near(&m->body, &m->world, vec3(2, 3, 0)));
}
