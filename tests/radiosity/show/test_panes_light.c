// test_panes_light.c - light through panes of glass: of the sun, of a lamp, and reflected, against closed forms and path tracing.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/radiosity/show/gather_fixture.h"

// The same mesh, whose panes are left out.
static Mesh without_panes(const Lit *lit) {
    Mesh mesh = lit->mesh;
    mesh.panes.count = 0;
    return mesh;
}

static bool is_indoors(const Lit *lit, int cell) {
    return cell >= 0 && vis_region(&lit->graph, cell)->kind == REGION_ROOM;
}

// Proves that a patch of sun behind a window has the transmittance at the beam's angle of the light that it would have without the pane,
// element by element and at points as they are gathered, and that light outdoors is what it was. Tolerance: slivers, 1e-9 of an element.
Test(panes_light, sun_through_a_window) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.25);
    Mesh bare = without_panes(lit);
    const Mesh *mesh = &lit->mesh;
    double *glazed = ARENA_ARRAY(&lit->arena, double, mesh->element_count),
           *open = ARENA_ARRAY(&lit->arena, double, mesh->element_count);
    Vec3 sun = vec3_normalize(vec3(1, -0.3, 0.5));
    double passes = glass_transmits(sun.x), h[2][3];
    int indoors = 0, outdoors = 0, brightest = -1;
    sunlight_shares(mesh, sun, true, 1, glazed);
    sunlight_shares(&bare, sun, true, 1, open);
    for (int e = 0; e < mesh->element_count; e++) {
        int cell = mesh->patches[mesh->elements[e].patch].cell;
        if (!(open[e] > 0) || cell < 0 || vis_region(&lit->graph, cell)->kind == REGION_OPENING) continue;
        bool room = is_indoors(lit, cell);
        cr_expect_float_eq(glazed[e], (room ? passes : 1) * open[e], 1e-8, "element %d", e);
        indoors += room;
        outdoors += !room;
        if (room && open[e] > 0.999) brightest = e;
    }
    cr_expect(indoors > 5 && outdoors > 100 && brightest >= 0, "%d indoors, %d outdoors", indoors, outdoors);
    Daylight day = {.sun = sun, .beam = {3, 2, 1}};
    for (int i = 0; i < 2; i++) {
        const Mesh *of = i ? &bare : mesh;
        RadSolution s;
        Error error;
        cr_assert(rad_start_dark(of, &lit->arena, &s, &error));
        s.day = day;
        GatherScene scene = {of, &lit->forest, NULL, &s, NULL};
        GatherOptions options = gather_default_options();
        gather_once(&scene, &options, element_centroid(mesh, brightest),
                    mesh->faces[mesh->elements[brightest].face].plane.n, h[i]);
    }
    cr_expect_gt(h[1][0], 0.5);
    cr_expect_float_eq(h[0][0], passes * h[1][0], 1e-9);
    lit_free(lit);
}

// Proves that panes weaken light that is gathered over the fine model (bake --probe, stills) as they do over the mesh with stand-ins. A
// vase of fine polygons stands in a dark corner of a room, and a point in the patch of sun has the same light over both.
Test(panes_light, fine_model_has_panes) {
    Lit *lit = sky_read_plan_with(
        "room a 0,0 4,0 4,3 0,3 floor oak ceiling white walls white wall 0.2\n"
        "window w 4.1,1.5 angle 90 width 1.2 sill 0.9 height 1.3\n"
        "model vase\n  cylinder white 0 0.2 0,0 radius 0.1 sides 64 without bottom top\n  cylinder "
        "white 0.2 0.3 0,0 radius 0.08 sides 64 without bottom top\nend\nplace vase 0.3,0.3\n",
        0.25, 2);
    Error error;
    Mesh mesh;
    MeshOptions options = {
        .element = 0.25, .per_patch = 2, .proxies = proxies_find(&lit->graph, 0.0125, &lit->arena)};
    cr_assert(mesh_build(&lit->graph, NULL, &options, &lit->arena, &mesh, &error), "%s", error.text);
    const FineMesh *fine = fine_mesh_new(&mesh, &lit->arena);
    cr_assert(!fine->same && fine->mesh.face_count > mesh.face_count);
    Vec3 sun = vec3_normalize(vec3(1, -0.3, 0.5)), window = {4.1, 1.5, 1.55};
    Vec3 at = vec3_sub(window, vec3_scale(sun, window.z / sun.z));
    double h[2][3];
    for (int i = 0; i < 2; i++) {
        RadSolution s;
        const Mesh *of = i ? &fine->mesh : &mesh;
        cr_assert(rad_start_dark(of, &lit->arena, &s, &error), "%s", error.text);
        s.day = (Daylight){.sun = sun, .beam = {3, 2, 1}};
        GatherScene scene = {of, &lit->forest, NULL, &s, NULL};
        GatherOptions gather = gather_default_options();
        gather_once(&scene, &gather, at, vec3(0, 0, 1), h[i]);
    }
    cr_expect_float_eq(h[0][0], 3 * sun.z * glass_transmits(sun.x), 1e-9);
    cr_expect_float_eq(h[1][0], h[0][0], 1e-9);
    lit_free(lit);
}

// Two rooms with a door of glass between them, and a small lamp in one.
static Lit *rooms_with_glass_door(float open) {
    Lit *lit =
        sky_read_plan_with("material lamp #FFFFFF emission 900\nmaterial glass #E8F4F2 alpha 0.12\n"
                           "room a 0,0 3,0 3,3 0,3 floor oak ceiling white walls white wall 0.2\n"
                           "room b 3.2,0 6,0 6,3 3.2,3 floor oak ceiling white walls white wall 0.2\n"
                           "door d 3.1,1.5 angle 90 width 1.4 height 2.2 glazed material glass\n"
                           "model l\n  box -0.05,-0.05,0 0.05,0.05,0.1 lamp\nend\nplace l 1.2,1.4,1.3\n",
                           0.25, 2);
    Error error;
    MeshOptions options = {.element = 0.25, .per_patch = 2};
    cr_assert(mesh_build(&lit->graph, &open, &options, &lit->arena, &lit->mesh, &error), "%s", error.text);
    cr_expect_eq(lit->mesh.panes.count, open > 0 ? 0 : 1);
    return lit;
}

// Proves that light straight from a lamp behind a closed glazed door has the transmittance at its angle of the light without a pane, at
// points as they are gathered, at nodes, and as paths find it; and that behind an open door it is whole. Tolerances: the lamp's parts in
// sight are 0.1 m wide 3 m away, across which the transmittance changes by less than 0.1 %; paths err by 0.3 %.
Test(panes_light, lamp_behind_a_glass_door, .timeout = 60) {
    Lit *lit = rooms_with_glass_door(0), *ajar = rooms_with_glass_door(0.5f);
    cr_expect_eq(ajar->mesh.panes.count, 0);
    Mesh bare = without_panes(lit);
    Vec3 at[] = {{5, 1.6, 0}, {6, 1.2, 1}, {4, 1.9, 0}}, normal[] = {{0, 0, 1}, {-1, 0, 0}, {0, 0, 1}},
         lamp = {1.2, 1.4, 1.35};
    for (int k = 0; k < 3; k++) {
        double h[2][3], passes = glass_transmits(vec3_normalize(vec3_sub(at[k], lamp)).x);
        for (int i = 0; i < 2; i++) {
            RadSolution s;
            Error error;
            cr_assert(rad_start(i ? &bare : &lit->mesh, &lit->arena, &s, &error));
            GatherScene scene = {i ? &bare : &lit->mesh, &lit->forest, NULL, &s, NULL};
            GatherOptions options = gather_default_options();
            gather_once(&scene, &options, at[k], normal[k], h[i]);
        }
        cr_expect_gt(h[1][1], 0.01);
        cr_expect_float_eq(h[0][1] / h[1][1], passes, 1e-3, "%g, not %g", h[0][1] / h[1][1], passes);
    }
    Nodes nodes = nodes_of(&lit->mesh, &lit->arena);
    double(*glazed)[3] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *glazed),
    (*open)[3] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *open);
    cr_assert(direct_irradiance(&lit->mesh, &lit->forest, &nodes, NULL, 2, NULL, glazed, NULL));
    cr_assert(direct_irradiance(&bare, &lit->forest, &nodes, NULL, 2, NULL, open, NULL));
    int behind = 0, before = 0;
    for (int n = 0; n < nodes.count; n++) {
        Vec3 p = lit->mesh.vertices[nodes.vertex[n]];
        if (!(open[n][1] > 1e-3)) continue;
        if (p.x > 3.3) {
            double passes = glass_transmits(vec3_normalize(vec3_sub(p, lamp)).x);
            cr_expect_float_eq(glazed[n][1] / open[n][1], passes, 2e-3);
            behind++;
        } else if (p.x < 2.9) {
            cr_expect_eq(glazed[n][1], open[n][1]);
            before++;
        }
    }
    cr_expect(behind > 20 && before > 200, "%d behind, %d before", behind, before);
    lit_free(ajar);
    lit_free(lit);
}

// Proves that the light of a room whose only light is another room's, through a door of glass, is as path tracing has it, and none is lost.
// Tolerances: as for a sky behind a window, a median of 2 % and 10 % at most.
Test(panes_light, room_behind_a_glass_door, .timeout = 120) {
    Lit *lit = rooms_with_glass_door(0);
    RadOptions options = sky_options_of(CULL_STAB, 0);
    RadSolution s;
    double errors[SKY_POINTS];
    lit_shoot(lit, &options, &s);
    sky_check_conserved(lit, &s);
    int count = sky_errors_of(lit, &s, errors);
    cr_assert_leq(errors[count / 2], 0.02, "median %.2f %%", 100 * errors[count / 2]);
    cr_assert_leq(errors[count - 1], 0.1, "at most %.2f %%", 100 * errors[count - 1]);
    lit_free(lit);
}
