// test_reflected.c - steps of reflected light within a patch: shown as far as its samples can tell them, and gathered where they are large.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/show/direct.h"
#include "radiosity/show/reflected.h"
#include "radiosity/show/shown.h"
#include "tests/support/lit_fixture.h"

// The solution where samples of all patches may miscount light by the share `noise`, and where shots told one element the share `step` more
// than its patch, and all others what their patches gathered.
static RadSolution with_step(Lit *lit, const RadSolution *s, int element, double noise, double step) {
    Arena *arena = &lit->arena;
    const Mesh *mesh = &lit->mesh;
    RadSolution changed = *s;
    size_t bytes = (size_t)mesh->element_count * sizeof *changed.radiosity;
    double rho = (double)mesh_material(mesh, mesh->elements[element].face)->reflectance.g;
    changed.radiosity = memcpy(arena_alloc(arena, bytes, 1), s->radiosity, bytes);
    changed.noise = ARENA_ARRAY(arena, float, s->patch_count);
    for (int p = 0; p < s->patch_count; p++) changed.noise[p] = (float)noise;
    // Else all elements of a patch tell the same.
    for (int e = 0; e < mesh->element_count; e++)
        for (int c = 0; c < 3; c++)
            changed.radiosity[e][c] = s->direct[e][c] + rho * s->reflected[mesh->elements[e].patch][c];
    for (int c = 0; c < 3; c++)
        changed.radiosity[element][c] += step * rho * s->reflected[mesh->elements[element].patch][c];
    return changed;
}

// The mean reflected light at the corners of the element, as it is shown.
static double shown_at(Lit *lit, const RadSolution *s, int element, double noise, double step) {
    Arena *arena = &lit->arena;
    const Mesh *mesh = &lit->mesh;
    RadSolution changed = with_step(lit, s, element, noise, step);
    double sum = 0;
    cr_assert(direct_show(mesh, &lit->forest, NULL, 1, NULL, arena, &changed, NULL));
    Nodes nodes = nodes_of(mesh, arena);
    cr_assert_eq(changed.node_count, nodes.count);
    const Element *e = &mesh->elements[element];
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++)
        sum += changed.rest[nodes.of_corner[i]][1] / e->corner_count;
    return sum;
}

// Patches are so many elements wide.
static Lit *lit_room(int wide, RadSolution *s) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit_finish(lit, 0.5, wide);
    RadOptions options = rad_default_options();
    options.form_factor.resolution = 48;
    options.residual = 0.01;
    lit_shoot(lit, &options, s);
    cr_assert(s->gathered);
    return lit;
}

// One of so many elements of a patch.
static int element_of_floor(const Lit *lit, int count) {
    for (int p = 0; p < lit->mesh.patch_count; p++) {
        const Patch *patch = &lit->mesh.patches[p];
        if (patch->element_count == count && lit->mesh.faces[patch->face].plane.n.z > 0.99)
            return patch->first_element;
    }
    cr_assert_fail("no patch of the floor has %d elements", count);
    return -1;
}

// Proves which steps within a patch are seen: those of many samples are, those of few samples, which would be blotches, are not. A step of
// an element is seen in the mean of its corners by a fourth of it at least, since each is shared by four elements; and steps of more than
// half of the light are shown as a half.
Test(reflected, steps_within_patches_as_far_as_samples_tell) {
    RadSolution s;
    Lit *lit = lit_room(2, &s);
    int element = element_of_floor(lit, 4);
    static const struct {
        double noise, step;
        bool seen;
    } CASES[] = {{0, -0.2, true}, {0, 0.2, true}, {0.1, -0.2, false}, {0.1, 0.2, false}, {0.1, -0.9, false}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        double even = shown_at(lit, &s, element, CASES[i].noise, 0),
               with = shown_at(lit, &s, element, CASES[i].noise, CASES[i].step), change = with / even - 1;
        printf("noise %.2f, step %+.1f: shown %+.3f\n", CASES[i].noise, CASES[i].step, change);
        if (CASES[i].seen)
            cr_expect_gt(change / CASES[i].step, 0.12);
        else
            cr_expect_float_eq(change, 0, 1e-6);
    }
    lit_free(lit);
}

// Proves that a step counts less where a patch has more elements, since each of them has its share of the samples: one of four shows what
// one of sixteen of an equally noisy patch, whose steps would be blotches, does not.
Test(reflected, steps_of_small_elements_are_of_few_samples) {
    for (int wide = 2; wide <= 4; wide += 2) {
        RadSolution s;
        Lit *lit = lit_room(wide, &s);
        int element = element_of_floor(lit, wide * wide);
        double even = shown_at(lit, &s, element, 0.02, 0), with = shown_at(lit, &s, element, 0.02, 0.2);
        printf("one of %d elements: shown %+.3f of a step of 0.2\n", wide * wide, with / even - 1);
        if (wide == 2)
            cr_expect_gt(with / even - 1, 0.02);
        else
            cr_expect_float_eq(with / even - 1, 0, 1e-6);
        lit_free(lit);
    }
}

// Proves that an element gathers by itself where shots tell it from its patch, as where a thing covers half of the patch. An element with
// five times the patch's reflected light is off by more than a quarter of all light, the lamp's included; one a twentieth off is not.
Test(reflected, elements_gather_where_shots_tell_them_from_their_patch) {
    RadSolution s;
    Lit *lit = lit_room(2, &s);
    int element = element_of_floor(lit, 4), patch = lit->mesh.elements[element].patch;
    Nodes nodes = nodes_of(&lit->mesh, &lit->arena);
    static const struct {
        double step;
        bool gathers;
    } CASES[] = {{0, false}, {0.05, false}, {-0.05, false}, {4, true}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        RadSolution changed = with_step(lit, &s, element, 0, CASES[i].step);
        ReflectedParts parts = reflected_parts(&(GatherScene){&lit->mesh, &lit->forest, NULL, &changed, NULL},
                                               &nodes, 1, NULL, &lit->arena);
        cr_expect_eq(parts.gathers[element], CASES[i].gathers, "step %g", CASES[i].step);
        // Others of the patch are what they were.
        for (int e = element + 1; e < element + lit->mesh.patches[patch].element_count; e++)
            cr_expect(parts.gathers[e] == (parts.halved[e].x + parts.halved[e].y > 0));
    }
    lit_free(lit);
}

// Light at nodes of a mesh with twice as fine elements, in which the elements of all patches of the floor but `covered` gather.
static double (*nodes_about(Lit *lit, const RadSolution *s, int covered, const Mesh *shown,
                            const Nodes *nodes))[3] {
    Arena *arena = &lit->arena;
    const Mesh *mesh = &lit->mesh;
    bool *gathers = ARENA_ARRAY(arena, bool, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++)
        gathers[e] =
            mesh->faces[mesh->elements[e].face].plane.n.z > 0.99 && mesh->elements[e].patch != covered;
    VertexLight light = reconstruct_light(mesh, s, arena);
    GatherScene scene = {mesh, &lit->forest, NULL, s, &light};
    double(*out)[3] = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out);
    cr_assert(reflected_nodes(&scene, gathers, shown, nodes, 1, NULL, NULL, NULL, out));
    return out;
}

// Proves that a patch that no light reaches, as one behind the frame of a door, leaves the light beside it alone where finer parts gather:
// at the border it is the light that is there when the patch is lit. Tolerance: the lamp hangs above, so that planes through the light
// around the patch pass its place by some percent.
Test(reflected, covered_patches_say_nothing_of_parts_beside_them) {
    static const MeshSplits ONCE = {.even = 1};
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    MeshOptions options = mesh_default_options();
    options.element = 0.25;
    options.splits = &ONCE;
    lit_finish_with(lit, &options);
    const Mesh *mesh = &lit->mesh;
    Arena *arena = &lit->arena;
    RadSolution s;
    RadOptions rad = rad_default_options();
    rad.form_factor.resolution = 48;
    lit_shoot(lit, &rad, &s);
    cr_assert(s.gathered);
    unsigned char *root = ARENA_ARRAY(arena, unsigned char, mesh->element_count);
    MeshDepth *depth = ARENA_ARRAY(arena, MeshDepth, mesh->element_count);
    int covered = -1;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        depth[e] = (MeshDepth){(unsigned char)(element->depth.x + 1), (unsigned char)(element->depth.y + 1)};
        Vec3 at = element_centroid(mesh, e);
        bool below = mesh->faces[element->face].plane.n.z > 0.99;
        if (below && fabs(at.x - 1.1) < 0.3 && fabs(at.y - 1.6) < 0.3) covered = element->patch;
    }
    cr_assert_geq(covered, 0);
    Mesh shown;
    Error error;
    cr_assert(shown_build(mesh, mesh_splits(mesh, root, depth, arena), NULL, arena, &shown, &error), "%s",
              error.text);
    Nodes nodes = nodes_of(&shown, arena);
    double(*lit_there)[3] = nodes_about(lit, &s, covered, &shown, &nodes);
    memset(s.reflected[covered], 0, sizeof *s.reflected);
    memset(s.sent[covered], 0, sizeof *s.sent);
    double(*dark_there)[3] = nodes_about(lit, &s, covered, &shown, &nodes);
    int border = 0;
    double worst = 0;
    for (int n = 0; n < nodes.count; n++) {
        int in = 0, all = nodes.first[n + 1] - nodes.first[n];
        for (int i = nodes.first[n]; i < nodes.first[n + 1]; i++)
            in += mesh->elements[shown_around(mesh, &shown, nodes.element[i])].patch == covered;
        if (in == 0 || in == all) continue;
        border++;
        worst = fmax(worst, fabs(dark_there[n][1] / lit_there[n][1] - 1));
    }
    printf("at %d nodes around a covered patch light is off by %.1f %% at most\n", border, 100 * worst);
    cr_expect_gt(border, 7);
    cr_expect_lt(worst, 0.05);
    lit_free(lit);
}

// Proves that an element which is the whole of its patch does not gather again from its own middle, in which a thing may stand, as the pole
// on the foot of a stool: it has the light of the patch's row. Elements of patches of four do gather where shots tell them apart from their
// patch. Light of some patches is made three times as bright as shots have it.
Test(reflected, whole_patches_gather_once) {
    for (int side = 1; side <= 2; side++) {
        Lit *lit = lit_new();
        lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
        lit_lamp(lit, vec3(2, 1.5, 2.4));
        MeshOptions options = mesh_default_options();
        options.element = 0.5;
        options.per_patch = side;
        lit_finish_with(lit, &options);
        const Mesh *mesh = &lit->mesh;
        RadSolution s;
        RadOptions rad = rad_default_options();
        rad.form_factor.resolution = 48;
        lit_shoot(lit, &rad, &s);
        for (int p = 0; p < mesh->patch_count; p += 7)
            for (int c = 0; c < 3; c++) s.reflected[p][c] *= 3;
        Nodes nodes = nodes_of(mesh, &lit->arena);
        ReflectedParts parts =
            reflected_parts(&(GatherScene){mesh, &lit->forest, NULL, &s, NULL}, &nodes, 1, NULL, &lit->arena);
        int gather = 0, single = 0;
        for (int e = 0; e < mesh->element_count; e++) {
            bool halved = parts.halved[e].x + parts.halved[e].y > 0,
                 alone = mesh->patches[mesh->elements[e].patch].element_count == 1;
            cr_expect(!(alone && !halved && parts.gathers[e]), "element %d gathers from its own middle", e);
            gather += parts.gathers[e] && !halved;
            single += alone;
        }
        cr_expect_gt(side == 1 ? single : gather, 0, "none of %d elements", mesh->element_count);
        lit_free(lit);
    }
}

// A box stands in a room below a lamp.
static const Box THING = {{1.4, 0.8, 0}, {2.6, 1.4, 0.9}};

// How far the reflected light that is shown on the thing's sides 4 cm from their lower and upper edges is off what a gather in many
// directions finds there, in the mean, as a share.
static double off_near_edges(Lit *lit, const RadSolution *s) {
    Arena scratch = {0};
    RadSolution found = *s;
    const Mesh *mesh;
    const RadSolution *light;
    Error error;
    cr_assert(direct_show(&lit->mesh, &lit->forest, NULL, 1, NULL, &scratch, &found, NULL));
    found.node = found.rest;
    cr_assert(shown_light(&lit->mesh, &found, NULL, &scratch, &mesh, &light, &error), "%s", error.text);
    VertexLight shown = reconstruct_light(mesh, light, &scratch);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, s, NULL};
    GatherOptions fine = gather_default_options();
    fine.resolution = 400;
    fine.reflected = true;
    Gatherer *gatherer = gatherer_new(&scene, &fine, &scratch);
    double sum = 0;
    int count = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Plane plane = mesh->faces[f].plane;
        for (int i = 0; i < 40; i++) {
            double along = 0.05 + i / 4 * 0.05, up = i % 8 < 4 ? 0.04 : 0.86;
            Vec3 at = i % 4 == 0   ? vec3(THING.min.x + along, THING.min.y, up)
                      : i % 4 == 1 ? vec3(THING.min.x + along, THING.max.y, up)
                      : i % 4 == 2 ? vec3(THING.min.x, THING.min.y + along, up)
                                   : vec3(THING.max.x, THING.min.y + along, up);
            if (fabs(plane_distance(plane, at)) > 1e-9 || fabs(plane.n.z) > 0.5) continue;
            double truth[3], off[3], rho[3];
            if (mesh_element_at(mesh, f, at) < 0) continue;
            gather(gatherer, &(ViewPoint){at, plane.n, gather_cell(&lit->graph, at, plane.n, -1)}, truth);
            reconstruct_at(mesh, &shown, f, at, off);
            rgb_doubles(mesh_material(mesh, f)->reflectance, rho);
            sum += fabs(off[1] / (rho[1] * truth[1]) - 1);
            count++;
        }
    }
    gatherer_end(gatherer);
    arena_free(&scratch);
    cr_assert_gt(count, 30);
    return sum / count;
}

// Proves that light is gathered at the edges of faces: on the sides of a thing that stands on the floor, shown light is nearer to what is
// gathered there than the planes through the values at the middles of elements say. Those are shown where no patch has seen anything close.
Test(reflected, light_is_gathered_at_edges, .timeout = 120) {
    static const MeshSplits EVEN = {.even = 0};
    RadSolution s;
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, THING.min, THING.max, false, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    MeshOptions options = mesh_default_options();
    options.element = 0.25;
    options.splits = &EVEN;
    lit_finish_with(lit, &options);
    RadOptions rad = rad_default_options();
    rad.residual = 0.001;
    lit_shoot(lit, &rad, &s);
    double edges = off_near_edges(lit, &s);
    s.close = ARENA_ARRAY(&lit->arena, float, s.patch_count + 1);
    double planes = off_near_edges(lit, &s);
    printf("near edges light is off by %.2f %%, along planes by %.2f %%\n", 100 * edges, 100 * planes);
    cr_expect_lt(edges, 0.7 * planes);
    lit_free(lit);
}
