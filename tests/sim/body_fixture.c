// body_fixture.c - see the header.
#include "tests/sim/body_fixture.h"

#include <criterion/criterion.h>

#include "engine/sim/collision_check.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/support.h"

void body_check_open_cells(Walker *w) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(vis_build_cells(&w->building, &options, &w->arena, &w->graph, &error), "%s", error.text);
    w->doors = doors_new(&w->graph, &w->arena);
    w->world = body_world(&w->graph, w->doors.open, &w->arena);
    w->check = collision_check_new(&w->graph, &w->arena);
    w->body = (Body){.cell = -1};
}

static void open_building(Walker *w, const char *path) {
    Error error;
    cr_assert(maps_read(path, &w->arena, &w->building, &error), "%s", error.text);
    body_check_open_cells(w);
}

void body_check_open_file(Walker *w, const char *path) {
    *w = (Walker){.arena = {0}};
    open_building(w, path);
}

void body_check_open_plan(Walker *w, const char *plan) {
    Error error;
    *w = (Walker){.arena = {0}};
    char *path = arena_format(&w->arena, "%s/test.plan", support_folder(&w->arena));
    cr_assert(file_write(path, plan, strlen(plan), &error), "%s", error.text);
    open_building(w, path);
}

void body_check_stand(Walker *w, double x, double y, double z) {
    cr_assert(body_place_near(&w->body, &w->world, vec3(x, y, z)), "no place at %g, %g, %g", x, y, z);
    cr_assert(fabs(w->body.foot.x - x) < 1e-9 && fabs(w->body.foot.y - y) < 1e-9,
              "%g, %g, %g is taken: it stands at %g, %g", x, y, z, w->body.foot.x, w->body.foot.y);
}

void body_check_expect_free(Walker *w, const char *where) {
    int what;
    CollisionFault f = collision_check_place(w->check, w->doors.open, w->body.foot, w->body.height, &what);
    cr_assert_eq(f, COLLISION_NONE, "%s: %s (%d) at %.9g, %.9g, %.9g", where, COLLISION_FAULT_NAMES[f], what,
                 w->body.foot.x, w->body.foot.y, w->body.foot.z);
    cr_assert_eq(w->body.cell,
                 vis_locate(&w->graph, vec3(w->body.foot.x, w->body.foot.y, w->body.foot.z + BODY_MIDDLE),
                            w->body.cell),
                 "%s: cell %d does not hold it", where, w->body.cell);
    cr_assert_eq(w->world.relocations, 0, "%s: put elsewhere", where);
}

void body_check_expect_stop(Walker *w, double x, double y, double after, const char *where) {
    Vec3 start = w->body.foot;
    body_step(&w->body, &w->world, vec2(x, y), 0.05);
    body_check_expect_free(w, where);
    double gone = ((w->body.foot.x - start.x) * x + (w->body.foot.y - start.y) * y) / hypot(x, y);
    // Tolerance: the skin, 0.1 mm, and what is left of the last piece.
    cr_assert(fabs(gone - after) < 1e-3, "%s: stopped after %g m, not %g", where, gone, after);
}
