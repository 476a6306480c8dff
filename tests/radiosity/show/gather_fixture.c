// gather_fixture.c - see the header.
#include "tests/radiosity/show/gather_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/parallel.h"
#include "tests/support/lit_fixture.h"

void gather_once(const GatherScene *scene, const GatherOptions *options, Vec3 p, Vec3 n, double out[3]) {
    Arena arena = {0};
    Gatherer *gatherer = gatherer_new(scene, options, &arena);
    gather(gatherer, &(ViewPoint){p, n, gather_cell(scene->mesh->graph, p, n, -1)}, out);
    gatherer_end(gatherer);
    arena_free(&arena);
}

Lit *gather_room_with_slit(RadSolution *s) {
    Lit *lit = lit_new();
    RadOptions options = rad_default_options();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(1, 0.02, 0), vec3(2.2, 0.5, 1.8), false, LIT_WALL, 0);
    lit_lamp(lit, vec3(2.5, 1.5, 2.3));
    lit_finish(lit, 0.5, 2);
    options.residual = 1e-4;
    lit_shoot(lit, &options, s);
    return lit;
}

void gather_all(const GatherScene *scene, const GatherOptions *options, double out[][3]) {
    Arena arena = {0};
    Gatherer *gatherer = gatherer_new(scene, options, &arena);
    for (int i = 0; i < CLOSE_POINTS; i++) {
        ViewPoint from = CLOSE[i];
        from.cell = gather_cell(scene->mesh->graph, from.eye, from.normal, -1);
        gather(gatherer, &from, out[i]);
    }
    gatherer_end(gatherer);
    arena_free(&arena);
}
