// test_clusters.c - views whose clusters are left closed where nothing of them is seen: against views that list every face.
#include <criterion/criterion.h>

#include "maps/maps.h"
#include "radiosity/factors/form_factor.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// ---- things of many small polygons in a closed room

// A convex polygon of 3 to 9 corners, of any slant.
static void add_polygon(Lit *lit, Random *random, Vec3 middle, double size) {
    Vec3 x, y, v[9],
        n = vec3_normalize(vec3(random_between(random, -1, 1), random_between(random, -1, 1),
                                random_between(random, -1, 1) + 1e-3));
    int count = 3 + random_index(random, 7);
    double longer = random_between(random, 1, 4);
    view_axes(n, &x, &y);
    for (int i = 0; i < count; i++) {
        double angle = 2 * M_PI * i / count;
        v[i] = vec3_add(
            middle, vec3_add(vec3_scale(x, longer * size * cos(angle)), vec3_scale(y, size * sin(angle))));
    }
    building_add_polygon(&lit->arena, lit->building, v, count, LIT_WALL);
}

// A panel of many strips, each a little off the plane of the sheet behind them, on which some lie: which is seen must not depend on the
// order in which they are drawn.
static void add_panel(Lit *lit, Random *random, Vec3 at) {
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "sheet");
    lit_quad(lit, at, vec3_add(at, vec3(1, 0, 0)), vec3_add(at, vec3(1, 0, 1)), vec3_add(at, vec3(0, 0, 1)),
             LIT_WALL);
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "strips");
    for (int i = 0; i < 20; i++) {
        double tilt = random_between(random, -3e-8, 3e-8), x = 0.05 * i;
        lit_quad(lit, vec3_add(at, vec3(x, tilt, 0)), vec3_add(at, vec3(x + 0.05, 0, 0)),
                 vec3_add(at, vec3(x + 0.05, -tilt, 1)), vec3_add(at, vec3(x, 0, 1)), LIT_WALL);
    }
}

// The polygons of a thing lie about its middle, as close together as they are large or farther apart.
static Lit *room_of_things(uint64_t seed, Vec3 shift) {
    Random random = {seed};
    Lit *lit = lit_new();
    lit_box(lit, shift, vec3_add(shift, vec3(4, 3, 2.5)), true, LIT_WALL, 0);
    for (int thing = 0; thing < 12; thing++) {
        building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "thing");
        double wide = random_between(&random, 0.1, 0.4);
        Vec3 middle =
            vec3_add(shift, vec3(random_between(&random, 0.9, 3.1), random_between(&random, 0.9, 2.1),
                                 random_between(&random, 0.8, 1.7)));
        int polygons = 1 + random_index(&random, 120);
        for (int i = 0; i < polygons; i++) {
            Vec3 off = vec3(random_between(&random, -wide, wide), random_between(&random, -wide, wide),
                            random_between(&random, -wide, wide));
            add_polygon(lit, &random, vec3_add(middle, off), wide * random_between(&random, 0.02, 0.25));
        }
    }
    add_panel(lit, &random, vec3_add(shift, vec3(1.5, 1.2, 0.3)));
    lit_finish(lit, 0.5, 2);
    return lit;
}

// ---- the oracle: views that list every face

typedef struct Pair {
    const Mesh *mesh;
    Viewer *viewer, *other;
    FormFactor *maker, *all;
    int *face;  // [samples]
    long long listed, left_out;
} Pair;

static Pair pair_of(const Mesh *mesh, const StabForest *forest, int resolution, Arena *arena) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    Pair p = {.mesh = mesh,
              .viewer = viewer_new(mesh, forest, NULL, arena),
              .other = viewer_new(mesh, forest, NULL, arena)};
    p.maker = form_factor_new(form_factor_method("hemisphere"), mesh, &options, arena);
    p.all = form_factor_new(form_factor_method("hemisphere"), mesh, &options, arena);
    p.face = ARENA_ARRAY(arena, int, form_factor_samples(p.all)->count);
    return p;
}

static void check_view(Pair *p, int patch, Culling culling, uint64_t seed) {
    const Patch *at = &p->mesh->patches[patch];
    ViewPoint from = {at->centre, p->mesh->faces[at->face].plane.n, at->cell};
    const View *all = viewer_look(p->other, &from, culling),
               *some = form_factor_look(p->maker, p->viewer, &from, culling);
    const int32_t *item = form_factor_items(p->all, all);
    int count = form_factor_samples(p->all)->count;
    for (int i = 0; i < count; i++) p->face[i] = item[i] < 0 ? -1 : all->faces[item[i]].face;
    item = form_factor_items(p->maker, some);
    p->listed += some->face_count;
    p->left_out += all->face_count - some->face_count;
    for (int i = 0; i < count; i++) {
        int face = item[i] < 0 ? -1 : some->faces[item[i]].face;
        cr_assert_eq(face, p->face[i], "seed %llu, patch %d, culling %s: sample %d sees face %d, not %d",
                     (unsigned long long)seed, patch, CULLING_NAMES[culling], i, face, p->face[i]);
    }
    const Row *row = form_factor_row(p->all, all), *own = form_factor_row(p->maker, some);
    cr_assert_eq(row->count, own->count);
    for (int i = 0; i < row->count; i++)
        cr_assert(row->element[i] == own->element[i] && row->factor[i] == own->factor[i],
                  "seed %llu, patch %d: element %d gets %.9g, not %.9g", (unsigned long long)seed, patch,
                  own->element[i], (double)own->factor[i], (double)row->factor[i]);
    cr_assert(row->back == own->back && row->escaped == own->escaped);
}

// Proves that each sample sees the face that it sees where every face is listed, whatever is culled, near the origin and 1,000 km
// from it, and that rows are the same to the last bit; and that a third of the faces is left out at least, or nothing would be proved.
Test(clusters, see_what_is_seen_where_all_is_listed, .timeout = 300) {
    static const Culling CULLING[] = {CULL_NONE, CULL_DEPTH, CULL_STAB};
    long long listed = 0, left_out = 0;
    for (int round = 0; round < support_count(24, 600); round++) {
        uint64_t seed = 100 + (uint64_t)round;
        Lit *lit = room_of_things(seed, round % 3 ? vec3(0, 0, 0) : vec3(1e6, -4e5, 30));
        Random random = {seed};
        Pair p = pair_of(&lit->mesh, &lit->forest, 20 + random_index(&random, 60), &lit->arena);
        for (int shot = 0; shot < 12; shot++)
            check_view(&p, random_index(&random, lit->mesh.patch_count), CULLING[shot % 3], seed);
        listed += p.listed, left_out += p.left_out;
        form_factor_end(p.maker);
        form_factor_end(p.all);
        lit_free(lit);
    }
    cr_expect(2 * left_out > listed, "%lld faces listed, %lld left out", listed, left_out);
}
