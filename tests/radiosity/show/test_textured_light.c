// test_textured_light.c - light among surfaces with pictures: what elements reflect, and what is shown.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/show/direct.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/radiosity/shoot/shoot_fixture.h"
#include "tests/support/support.h"

// ---- energy

// A picture of 32 x 32 random texels, one copy every two metres along x + y and along z.
static int add_noise(Lit *lit, uint64_t seed) {
    enum { SIDE = 32 };
    static uint8_t texels[SIDE * SIDE * 4];
    Random random = {seed};
    for (int i = 0; i < SIDE * SIDE * 4; i++)
        texels[i] = i % 4 == 3 ? 255 : (uint8_t)(40 + random_index(&random, 216));
    return lit_picture(lit, SIDE, SIDE, texels, (TextureMap){{0.5, 0.5, 0}, {0, 0, 0.5}, 0, 0});
}

// A closed room of papered walls with a box, under a ceiling that emits and reflects.
static Lit *papered_room(uint64_t seed) {
    Lit *lit = lit_new();
    int glow = building_add_material(
        &lit->arena, lit->building,
        (Material){.name = "glow", .reflectance = {0.5f, 0.5f, 0.5f}, .emission = {3, 2, 1}, .alpha = 1});
    int paper = add_noise(lit, seed);
    lit_box(lit, vec3(0, 0, 0), vec3(4, 2, 2), true, paper, 1 << 5);
    lit_box(lit, vec3(0, 0, 0), vec3(4, 2, 2), true, glow, 31);
    lit_box(lit, vec3(1, 0.7, 0), vec3(1.6, 1.2, 0.8), false, paper, 1 << 4);
    lit_finish(lit, 0.25, 4);
    return lit;
}

// Proves that no light is lost where elements of a patch reflect unlike shares: emitted = absorbed + unshot to the rounding of doubles;
// and that elements and patches agree on it: of the light that arrived by the elements' radiosities, each absorbs what it does not reflect.
// The second to 1e-5: rows hold densities as floats, thousands of shots add up; a patch's own mean instead would be off by 1e-3.
Test(textured_light, no_light_is_lost) {
    Lit *lit = papered_room(3);
    const Mesh *mesh = &lit->mesh;
    RadSolution s;
    RadOptions options = shoot_options_to(1e-4);
    options.reach = 0;
    lit_shoot(lit, &options, &s);
    cr_expect_lt(shoot_lost_power(lit, &s), 1e-12);
    double backs = 0, absorbed = 0, unlike = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        double rho[3], emitted[3], mean[3];
        rgb_doubles(mesh_reflectance(mesh, e), rho);
        rgb_doubles(mesh_patch_reflectance(mesh, mesh->elements[e].patch), mean);
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        absorbed += mesh->elements[e].area * (s.radiosity[e][1] - emitted[1]) * (1 / rho[1] - 1);
        unlike = fmax(unlike, fabs(rho[1] / mean[1] - 1));
    }
    backs = s.absorbed[1] - absorbed;
    printf("absorbed %g W, by elements %g W; elements differ by %g of their patch\n", s.absorbed[1], absorbed,
           unlike);
    cr_expect_gt(unlike, 0.1, "the picture is even: nothing is tried");
    cr_expect_lt(fabs(backs), 1e-5 * s.absorbed[1]);
    lit_free(lit);
}

// Proves that elements together reflect the mean of a picture that a face shows as a whole, as walls do here. Tolerance: four points a
// side, of levels that straddle the sides of elements, miscount each element by some of its neighbours' light, at random.
Test(textured_light, elements_have_the_mean_of_the_picture) {
    Lit *lit = papered_room(4);
    const Mesh *mesh = &lit->mesh;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        double sum = 0, area = 0;
        if (face->plane.n.z != 0) continue;
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            sum += mesh->elements[e].area * (double)mesh_reflectance(mesh, e).g;
            area += mesh->elements[e].area;
        }
        double mean = (double)mesh_material(mesh, f)->reflectance.g;
        if (area > 3.9)
            cr_expect_float_eq(sum / area, mean, 0.02 * mean, "face %d: %g, not %g", f, sum / area, mean);
    }
    lit_free(lit);
}

// Proves that textured light, too, is the same bytes on any number of threads and culled or not, and that a .rad file is refused where the
// picture is another.
Test(textured_light, same_on_threads_and_culled_or_not, .timeout = 200) {
    Bytes first = {0};
    Lit *lit = lit_rooms(5);
    int noise = add_noise(lit, 1), other = add_noise(lit, 2);
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    for (int m = 0; m < lit->building->material_count - 2; m++) {
        lit->building->materials[m].texture = lit->building->materials[noise].texture;
        lit->building->materials[m].texture_map = lit->building->materials[noise].texture_map;
    }
    mesh_find_reflectances(&lit->mesh, &lit->arena);
    cr_assert_not_null(lit->mesh.reflectance);
    RadSolution s;
    for (int i = 0; i < 3; i++) {
        Error error = {""};
        RadOptions options = shoot_options_to(0.02);
        options.threads = i == 1 ? 2 : 1;
        options.culling = i == 2 ? CULL_NONE : CULL_STAB;
        lit_shoot(lit, &options, &s);
        cr_assert(rad_save(path, &lit->mesh, NULL, &s, &error), "%s", error.text);
        Bytes bytes = support_read(&lit->arena, path);
        if (i == 0) first = bytes;
        cr_assert_eq(bytes.size, first.size);
        cr_assert(memcmp(bytes.data, first.data, first.size) == 0, "run %d", i);
    }
    Error error = {""};
    cr_assert(rad_load(path, &lit->mesh, NULL, &lit->arena, &s, &error), "%s", error.text);
    for (int m = 0; m < lit->building->material_count - 2; m++)
        lit->building->materials[m].texture = lit->building->materials[other].texture;
    mesh_find_reflectances(&lit->mesh, &lit->arena);
    cr_expect_not(rad_load(path, &lit->mesh, NULL, &lit->arena, &s, &error), "light of another picture");
    lit_free(lit);
}

// ---- a floor half dark, half light

enum { DARK = 70, LIGHT = 230 };

// A room of 4 x 4 x 2.5 m with a lamp off its middle. The floor is one polygon with a picture, or two polygons of plain colours.
static Lit *half_room(bool picture) {
    enum { SIDE = 256 };
    static uint8_t texels[SIDE * SIDE * 4];
    Lit *lit = lit_new();
    for (int i = 0; i < SIDE * SIDE * 4; i++)
        texels[i] = i % 4 == 3 ? 255 : i / 4 % SIDE < SIDE / 2 ? DARK : LIGHT;
    lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 2.5), true, LIT_WALL, 1 << 4);
    lit_lamp(lit, vec3(1.5, 2.25, 2.4));
    if (picture) {
        int floor = lit_picture(lit, SIDE, SIDE, texels, (TextureMap){{0.25, 0, 0}, {0, 0.25, 0}, 0, 0});
        lit_quad(lit, vec3(0, 0, 0), vec3(4, 0, 0), vec3(4, 4, 0), vec3(0, 4, 0), floor);
    } else {
        for (int i = 0; i < 2; i++) {
            float rho = maps_linear(i ? LIGHT : DARK);
            Material m = {.name = i ? "light" : "dark", .reflectance = {rho, rho, rho}, .alpha = 1};
            int half = building_add_material(&lit->arena, lit->building, m);
            lit_quad(lit, vec3(2 * i, 0, 0), vec3(2 * i + 2, 0, 0), vec3(2 * i + 2, 4, 0), vec3(2 * i, 4, 0),
                     half);
        }
    }
    static const MeshSplits EVEN = {.even = 1};
    MeshOptions options = mesh_default_options();
    options.element = 0.25;
    options.close = 0;
    options.splits = &EVEN;
    lit_finish_with(lit, &options);
    return lit;
}

static int face_below(const Mesh *mesh, Vec3 p) {
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        Vec3 low = vec3(INFINITY, 0, 0), high = vec3(-INFINITY, 0, 0);
        if (face->plane.n.z < 0.9) continue;
        for (int i = 0; i < face->vertex_count; i++) {
            double x = mesh->vertices[mesh->outline[face->first_vertex + i]].x;
            low.x = fmin(low.x, x), high.x = fmax(high.x, x);
        }
        if (p.x > low.x && p.x < high.x) return f;
    }
    cr_assert(false, "no floor");
    return -1;
}

// Radiosity of the elements at points of the floor and the ceiling, and the irradiance that is shown on the floor.
enum { POINTS = 12 };
typedef struct Half {
    double floor[POINTS], shown[POINTS], ceiling[POINTS];
} Half;

static Vec3 half_point(int i) { return vec3(0.3 + i * 3.4 / (POINTS - 1), 1.1, 0); }

static Half solve_half(Lit *lit, bool gather) {
    Half out;
    RadSolution s;
    Error error = {""};
    RadOptions options = shoot_options_to(1e-3);
    options.gather = gather;
    lit_shoot(lit, &options, &s);
    Mesh *mesh = &lit->mesh;
    if (gather) cr_assert(direct_show(mesh, &lit->forest, NULL, 2, NULL, &lit->arena, &s, NULL));
    const Mesh *shown;
    const RadSolution *light;
    cr_assert(shown_light(mesh, &s, NULL, &lit->arena, &shown, &light, &error), "%s", error.text);
    VertexLight vertices = reconstruct_light(shown, light, &lit->arena);
    for (int i = 0; i < POINTS; i++) {
        Vec3 p = half_point(i);
        double b[3];
        int f = face_below(mesh, p);
        out.floor[i] = s.radiosity[mesh_element_at(mesh, f, p)][1];
        f = face_below(shown, p);
        reconstruct_at(shown, &vertices, f, p, b);
        out.shown[i] = b[1] / (double)mesh_material(shown, f)->reflectance.g;
        for (f = 0; mesh->faces[f].plane.n.z > -0.9 || mesh_emits(mesh, f); f++) continue;
        out.ceiling[i] = s.radiosity[mesh_element_at(mesh, f, vec3(p.x, p.y, 2.5))][1];
    }
    return out;
}

// Proves that a floor of one polygon with a picture equals one of two polygons of plain colours: in what elements of the floor and the
// ceiling reflect, and in the light that is shown, irradiances without a step where the picture has one. Tolerances: patches on two faces
// lie like those on one, so elements differ by the order of sums and by samples on the seam alone, 0.5 %; shown light is
// reconstructed over the seam of one face and up to it on two, 3 %.
static void check_halves(bool gather) {
    Lit *one = half_room(true), *two = half_room(false);
    Half a = solve_half(one, gather), b = solve_half(two, gather);
    double worst[3] = {0, 0, 0};
    for (int i = 0; i < POINTS; i++) {
        worst[0] = fmax(worst[0], fabs(a.floor[i] / b.floor[i] - 1));
        worst[1] = fmax(worst[1], fabs(a.ceiling[i] / b.ceiling[i] - 1));
        worst[2] = fmax(worst[2], fabs(a.shown[i] / b.shown[i] - 1));
    }
    printf("floor %.2g, ceiling %.2g, shown %.2g\n", worst[0], worst[1], worst[2]);
    cr_expect_lt(worst[0], 5e-3);
    cr_expect_lt(worst[1], 5e-3);
    cr_expect_lt(worst[2], 0.03);
    lit_free(one);
    lit_free(two);
}
Test(textured_light, picture_equals_two_polygons) { check_halves(false); }
Test(textured_light, picture_equals_two_polygons_gathered) { check_halves(true); }

// Proves that walks reflect texels: irradiances on the ceiling by random walks are those of the two polygons, within four standard errors
// of half a percent, and those of radiosity within 4 %, since elements of a quarter of a metre that light is shot to err by 3 % here.
Test(textured_light, walks_reflect_texels, .timeout = 200) {
    Lit *lit[2] = {half_room(true), half_room(false)};
    Half solved = solve_half(lit[0], false);
    double h[2][3];
    for (int k = 0; k < 2; k++) {
        PathTracer *tracer = path_tracer_new(&lit[k]->mesh, NULL, &lit[k]->arena);
        for (int i = 0; i < 3; i++) {
            Vec3 p = half_point(1 + i * (POINTS - 3) / 2);
            PathQuery query = {vec3(p.x, p.y, 2.5),   vec3(0, 0, -1), 0.005, 0, 1 << 22,
                               (uint64_t)(10 * k + i)};
            PathResult result;
            path_tracer_irradiance(tracer, &query, 1, 2, &result);
            h[k][i] = result.irradiance[1];
        }
        path_tracer_end(tracer);
    }
    for (int i = 0; i < 3; i++) {
        double found = solved.ceiling[1 + i * (POINTS - 3) / 2] / 0.5;
        printf("picture %g, two polygons %g, radiosity %g\n", h[0][i], h[1][i], found);
        cr_expect_float_eq(h[0][i], h[1][i], 4 * hypot(0.005, 0.005) * h[1][i]);
        cr_expect_float_eq(found, h[0][i], 0.04 * h[0][i]);
    }
    lit_free(lit[0]);
    lit_free(lit[1]);
}
