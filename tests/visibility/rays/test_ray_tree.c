// test_ray_tree.c - the hierarchy and the grid meet what all surfaces tried one by one meet, and what Embree meets.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "radiosity/methods/ray_caster.h"
#include "tests/support/fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/oracles/hidden_scenes.h"
#include "tests/support/soup_fixture.h"
#include "visibility/rays/ray_surfaces.h"

static bool soaking(void) { return getenv("ENFILADE_SOAK") != NULL; }

typedef struct Rays {
    RaySurfaces surfaces;
    SurfaceTree tree;
    SurfaceGrid grid;
} Rays;

static Rays *rays_new(const RaySource *source, Arena *arena) {
    Rays *rays = ARENA_ARRAY(arena, Rays, 1);
    rays->surfaces = ray_surfaces_new(source, arena);
    rays->tree = surface_tree_new(&rays->surfaces, arena);
    rays->grid = surface_grid_new(&rays->surfaces, arena);
    return rays;
}

static const int *all_of(int count, Arena *arena) {
    int *list = ARENA_ARRAY(arena, int, count + 1);
    for (int i = 0; i < count; i++) list[i] = i;
    return list;
}

static Rays *rays_of(const Polygon *polygons, const Vec3 *vertices, int count, Arena *arena) {
    RaySource source = {
        .polygons = polygons, .vertices = vertices, .list = all_of(count, arena), .list_count = count};
    return rays_new(&source, arena);
}

// Anything at all between the ends of a ray is anything met first.
static void expect_same(const Rays *rays, Ray ray, const char *scene) {
    SurfaceHit hits[3] = {ray_surfaces_brute(&rays->surfaces, &ray), surface_tree_first(&rays->tree, &ray),
                          surface_grid_first(&rays->grid, &ray)};
    for (int i = 1; i < 3; i++) {
        cr_assert(
            hits[i].item == hits[0].item && hits[i].at.t == hits[0].at.t && hits[i].front == hits[0].front,
            "%s, %s: %d at %.17g, not %d at %.17g, from (%.17g %.17g %.17g) along (%.17g %.17g %.17g)", scene,
            i == 1 ? "tree" : "grid", hits[i].item, hits[i].at.t, hits[0].item, hits[0].at.t, ray.origin.x,
            ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z);
    }
    cr_assert_eq(surface_tree_blocked(&rays->tree, &ray), hits[0].item >= 0, "%s: tree, shadow", scene);
    cr_assert_eq(surface_grid_blocked(&rays->grid, &ray), hits[0].item >= 0, "%s: grid, shadow", scene);
}

// A direction anywhere, one in four along an axis or a plane of axes, where slabs have no thickness and steps no length.
static Vec3 direction(Random *random) {
    Vec3 d = fixture_direction(random);
    int kind = random_index(random, 16);
    if (kind & 1 && kind < 8) d.x = 0;
    if (kind & 2 && kind < 8) d.y = 0;
    if (kind & 4 && kind < 8) d.z = 0;
    return vec3_length(d) > 0 ? vec3_normalize(d) : vec3(0, 0, -1);
}

// Scenes made to break hidden-surface methods: coplanar, edge-on, slivers, sheets nothing apart, huge and tiny ones. Results
// are the same to the last bit: both try the same surfaces with the same arithmetic, and may leave out none that counts.
Test(ray_tree, meets_what_brute_force_meets) {
    int count = soaking() ? 20000 : 1200;
    for (int kind = 0; kind < SCENE_KINDS; kind++) {
        Arena arena = {0};
        Random random = {(uint64_t)(100 + kind)};
        Vec3 eye = vec3(3, -2, 1);
        HiddenSoup soup = hidden_soup_new(&arena, &random, (HiddenKind)kind, eye, 400);
        Rays *rays = rays_of(soup.polygons, soup.vertices, soup.polygon_count, &arena);
        for (int i = 0; i < count; i++) {
            Ray ray = {eye, direction(&random), 0, i % 3 ? INFINITY : random_between(&random, 0, 20)};
            if (i % 2) ray.origin = vec3_add(eye, vec3_scale(fixture_direction(&random), 10));
            expect_same(rays, ray, HIDDEN_KIND_NAMES[kind]);
        }
        arena_free(&arena);
    }
}

// Rooms; origins on walls, on the planes of others, on vertices; far from the origin of all coordinates, too.
Test(ray_tree, meets_what_brute_force_meets_in_rooms) {
    for (int far = 0; far < 2; far++) {
        Arena arena = {0};
        Random random = {7};
        Building *b = soup_fixture_house(&arena, &random, 4, 3);
        SoupPose pose = {1, 0.3, vec3(0, 0, 1), vec3(4e6, -5e6, 100)};
        if (far) b = soup_fixture_posed(&arena, b, &pose);
        Rays *rays = rays_of(b->polygons, b->vertices, b->polygon_count, &arena);
        for (int i = 0; i < (soaking() ? 50000 : 5000); i++) {
            Vec3 from = b->vertices[random_index(&random, b->vertex_count)];
            Vec3 to = b->vertices[random_index(&random, b->vertex_count)];
            if (i % 2) from = vec3_lerp(from, to, random_unit(&random));
            expect_same(rays, (Ray){from, direction(&random), i % 4 ? 1e-5 : 0, INFINITY}, "house");
        }
        arena_free(&arena);
    }
}

// Curved shapes among polygons, in both; a shape counts after polygons.
Test(ray_tree, meets_curved_shapes) {
    Arena arena = {0};
    Random random = {5};
    Building *b = soup_fixture_house(&arena, &random, 2, 2);
    CurvedShape ball[3];
    int shapes[3] = {0, 1, 2}, met = 0;
    for (int i = 0; i < 3; i++)
        ball[i] = (CurvedShape){.kind = CURVED_SPHERE,
                                .frame = {vec3(1 + 2 * i, 1.5, 1), {{0.4, 0, 0}, {0, 0.4, 0}, {0, 0, 0.4}}}};
    b->shapes = ball;
    b->shape_count = 3;
    RaySource source = {
        b, b->polygons, b->vertices, all_of(b->polygon_count, &arena), shapes, b->polygon_count, 3};
    Rays *rays = rays_new(&source, &arena);
    for (int i = 0; i < 20000; i++) {
        Ray ray = {vec3(random_between(&random, 0, 8), random_between(&random, 0, 8), 1.2),
                   direction(&random), 0, INFINITY};
        expect_same(rays, ray, "balls");
        met += surface_tree_first(&rays->tree, &ray).item >= b->polygon_count;
    }
    cr_expect_gt(met, 300, "balls are hardly ever met");
    arena_free(&arena);
}

// From inside of closed rooms no ray gets out, aimed at vertices and edges too: in steps of a rounding around them, and with
// vertices of one wall on the edges of others.
Test(ray_tree, nothing_slips_through_edges) {
    Lit *lit = lit_rooms(3);
    Random random = {11};
    const CellGraph *g = &lit->graph;
    Rays *rays = rays_of(g->polygons, g->vertices, g->polygon_count, &lit->arena);
    int lost[2] = {0, 0}, count = soaking() ? 2000000 : 100000;
    for (int i = 0; i < count; i++) {
        int cell = random_index(&random, g->cell_count);
        if (vis_region(g, cell)->kind == REGION_OUTDOORS) continue;
        const Polygon *p = &g->polygons[random_index(&random, g->polygon_count)];
        int k = random_index(&random, p->vertex_count);
        Vec3 a = g->vertices[p->first_vertex + k],
             b = g->vertices[p->first_vertex + (k + 1) % p->vertex_count];
        Vec3 from = fixture_point(g, &random, cell);
        Vec3 to = vec3_lerp(a, b, i % 4 ? random_unit(&random) : 0);
        if (i % 3 == 0) to = vec3_add(to, vec3_scale(fixture_direction(&random), 1e-15 * (1 << i % 20)));
        Ray ray = {from, vec3_normalize(vec3_sub(to, from)), 0, INFINITY};
        lost[0] += surface_tree_first(&rays->tree, &ray).item < 0;
        lost[1] += surface_grid_first(&rays->grid, &ray).item < 0;
    }
    cr_expect_eq(lost[0], 0, "tree: %d of %d rays left a closed building", lost[0], count);
    cr_expect_eq(lost[1], 0, "grid: %d of %d rays left a closed building", lost[1], count);
    lit_free(lit);
}

// How far a point of a polygon's plane lies inside of its edges; below 0 outside.
static double inside_of(const Vec3 *v, int count, Vec3 n, Vec3 p) {
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 way = vec3_sub(v[(i + 1) % count], v[i]);
        double length = vec3_length(way);
        if (length > 0) least = fmin(least, vec3_dot(vec3_cross(n, way), vec3_sub(p, v[i])) / length);
    }
    return least;
}

// Embree's face, where it is more than 1e-4 m inside of its edges and seen at more than a grazing angle: its rays are floats, and
// begin 2e-5 m before the surface. Faces in one place are told apart by what each says of ties, so the plane counts. Of the rest a few
// in 100,000 may differ, and not the same in each run: Embree makes its tree on several threads, and its faces are triangles, between
// which a ray may slip.
Test(ray_tree, meets_what_embree_meets) {
    long long compared = 0, differing = 0, count = soaking() ? 1000000 : 100000;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        Lit *lit = lit_rooms(seed);
        const CellGraph *g = &lit->graph;
        Random random = {seed};
        int *list = ARENA_ARRAY(&lit->arena, int, lit->mesh.face_count + 1), listed = 0,
            *item_of = ARENA_ARRAY(&lit->arena, int, lit->mesh.face_count + 1);
        for (int f = 0; f < lit->mesh.face_count; f++) {
            if (lit->mesh.faces[f].hidden) continue;
            item_of[f] = listed;
            list[listed++] = lit->mesh.faces[f].polygon;
        }
        RaySource source = {
            .polygons = g->polygons, .vertices = g->vertices, .list = list, .list_count = listed};
        Rays *rays = rays_new(&source, &lit->arena);
        RayCaster *embree = ray_caster_new(&lit->mesh, &lit->arena);
        for (int i = 0; i < count / 4 / LANES; i++) {
            Vec3 eye = fixture_point(g, &random, random_index(&random, g->cell_count));
            Vec3 way[LANES];
            RayEight eight;
            int32_t face[LANES], element[LANES];
            for (int k = 0; k < LANES; k++) {
                way[k] = fixture_direction(&random);
                eight.x[k] = (float)way[k].x, eight.y[k] = (float)way[k].y, eight.z[k] = (float)way[k].z;
            }
            ray_caster_cast(embree, eye, vec3(0, 0, 1), &eight, lane_int_of(-1), false, face, element);
            for (int k = 0; k < LANES; k++) {
                if (face[k] >= 0) face[k] = item_of[face[k]];
                Ray ray = {eye, way[k], 0, INFINITY};
                SurfaceHit hit = surface_tree_first(&rays->tree, &ray);
                if (hit.item == face[k]) {
                    compared++;
                    continue;
                }
                int mine = hit.item < 0 ? face[k] : hit.item;
                const Polygon *p = &g->polygons[list[mine]];
                const Vec3 *v = g->vertices + p->first_vertex;
                Plane plane = plane_of_polygon(v, p->vertex_count), other = plane;
                const Polygon *q = &g->polygons[list[face[k] < 0 ? mine : face[k]]];
                if (q != p) other = plane_of_polygon(g->vertices + q->first_vertex, q->vertex_count);
                bool tie = hit.item >= 0 && fabs(vec3_dot(plane.n, other.n)) > 1 - 1e-9 &&
                           fabs(fabs(plane.d) - fabs(other.d)) < 1e-4;
                double slant = vec3_dot(plane.n, way[k]);
                double t = -plane_distance(plane, eye) / slant;
                Vec3 at = vec3_add(eye, vec3_scale(way[k], t));
                bool edge = fabs(inside_of(v, p->vertex_count, plane.n, at)) < 1e-4 || fabs(slant) < 1e-3;
                bool close = hit.item >= 0 && hit.at.t < 1e-4;
                if (tie || edge || close) continue;
                differing++;
                printf("seed %d: item %d at %g, Embree %d\n", (int)seed, hit.item, hit.at.t, face[k]);
            }
        }
        ray_caster_end(embree);
        lit_free(lit);
    }
    cr_expect_gt(compared, count * 99 / 100, "only %lld of %lld rays agree", compared, count);
    cr_expect_lt(differing, count / 5000, "%lld of %lld rays differ", differing, count);
}

// Without surfaces, with one, with polygons that have no area: a defined answer.
Test(ray_tree, takes_what_is_hardly_there) {
    Arena arena = {0};
    Vec3 v[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    Polygon polygons[] = {{0, 3, 0, 0}, {0, 2, 0, 0}, {4, 2, 0, 0}};
    Ray down = {vec3(0.7, 0.3, 1), vec3(0, 0, -1), 0, INFINITY},
        up = {vec3(0.7, 0.3, 1), vec3(0, 0, 1), 0, INFINITY};
    for (int count = 0; count < 4; count++) {
        Rays *rays = rays_of(polygons, v, count, &arena);
        expect_same(rays, down, "hardly any");
        expect_same(rays, up, "hardly any");
        cr_expect_eq(surface_tree_first(&rays->tree, &down).item, count ? 0 : -1);
    }
    arena_free(&arena);
}
