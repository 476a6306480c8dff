// test_sums.c - what is made of many buildings, in figures: free space, cells, trees, and what is seen, walked and moved there.
#include <criterion/criterion.h>
#include <math.h>
#include <string.h>

#include "tests/maps/sums_fixture.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/files/hostile.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

// ---- free space

static void sum_regions(SumFile *f, const Building *b) {
    Sum regions = {0}, points = {0};
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        int words[] = {(int)r->kind,  r->storey,     r->opening,        r->side,
                       r->ring_count, r->first_ring, r->floor_material, r->ceiling_material};
        sum_ints(&regions, words, sizeof words / sizeof *words);
        sum_add2(&regions, vec2(r->z0, r->z1));
    }
    for (int i = 0; i < b->ring_count; i++) sum_ints(&regions, &b->rings[i].first_point, 2);
    for (int i = 0; i < b->point_count; i++) sum_add2(&points, b->points[i]);
    if (b->edge_material) sum_ints(&points, b->edge_material, b->point_count);
    sums_sum(f, "regions", regions);
    sums_sum(f, "points", points);
}

static void sum_openings(SumFile *f, const Building *b) {
    Sum openings = {0}, leaves = {0};
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        int words[] = {(int)o->kind,  o->storey,    o->glazed,    o->fills,    o->first_leaf,
                       o->leaf_count, o->region[0], o->region[1], o->material, o->reason != NULL};
        sum_ints(&openings, words, sizeof words / sizeof *words);
        sum_add2(&openings, o->line[0]);
        sum_add2(&openings, o->line[1]);
        sum_add3(&openings, vec3(o->sill, o->head, o->open));
    }
    for (int i = 0; i < b->leaf_count; i++) {
        const Leaf *l = &b->leaves[i];
        int words[] = {l->opening, l->first_corner, l->corner_count};
        sum_ints(&leaves, words, 3);
        sum_add2(&leaves, l->pivot);
        sum_add2(&leaves, l->slide);
        sum_add2(&leaves, l->axis[0]);
        sum_add2(&leaves, l->axis[1]);
        sum_add3(&leaves, vec3(l->turn, l->rise, l->thickness));
        sum_add2(&leaves, vec2(l->z0, l->z1));
    }
    sums_sum(f, "openings", openings);
    sums_sum(f, "leaves", leaves);
}

static void sum_rest(SumFile *f, const Building *b) {
    Sum lights = {0}, rest = {0}, notes = {0};
    for (int i = 0; i < b->light_count; i++) {
        const Light *l = &b->lights[i];
        sum_add3(&lights, l->position);
        sum_add3(&lights, vec3((double)l->flux.r, (double)l->flux.g, (double)l->flux.b));
        sum_add2(&lights, vec2(l->radius, l->object));
    }
    for (int i = 0; i < b->inlay_count; i++) {
        int words[] = {b->inlays[i].first_point, b->inlays[i].point_count, b->inlays[i].material};
        sum_ints(&rest, words, 3);
        sum_add(&rest, b->inlays[i].z);
    }
    for (int i = 0; i < b->viewpoint_count; i++) {
        sum_add3(&rest, b->viewpoints[i].eye);
        sum_add3(&rest, vec3(b->viewpoints[i].yaw, b->viewpoints[i].pitch, b->viewpoints[i].fov));
    }
    for (int i = 0; i < b->material_count; i++) {
        const Material *m = &b->materials[i];
        sum_add3(&rest, vec3((double)m->reflectance.r, (double)m->reflectance.g, (double)m->reflectance.b));
        sum_add3(&rest, vec3((double)m->emission.r, (double)m->alpha, (double)m->index));
    }
    sum_box(&rest, b->world);
    sum_add3(&rest, b->start);
    sum_add3(&rest, vec3(b->start_yaw, b->drawn_area, b->lost_area));
    for (int i = 0; i < b->note_count; i++) {
        int words[] = {(int)b->notes[i].kind, b->notes[i].first_point, b->notes[i].point_count};
        sum_ints(&notes, words, 3);
        sum_add3(&notes, b->notes[i].place);
    }
    sums_sum(f, "lights", lights);
    sums_sum(f, "rest", rest);
    sums_sum(f, "notes", notes);
}

static void sum_building(SumFile *f, const char *name, const Building *b) {
    sums_scene(f, name);
    sum_regions(f, b);
    sum_openings(f, b);
    sums_of_sum_polygons(f, b->objects, b->object_count, b->polygons, b->polygon_count, b->vertices,
                         b->vertex_count);
    sum_rest(f, b);
}

// Proves that the free space found in random plans is what it was.
Test(sums, plans, .timeout = 60) {
    SumFile f = sums_begin("plans");
    for (int seed = 1; seed <= 150; seed++) {
        Draft d;
        if (sums_of_random_plan(seed, &d)) sum_building(&f, arena_format(&f.arena, "plan-%d", seed), &d.b);
        draft_free(&d);
    }
    sums_end(&f);
}

// Proves that readers and enclosing make the same of our own homes and plans, and of a small file of each hostile kind.
Test(sums, files, .timeout = 60) {
    SumFile f = sums_begin("files");
    const char *folder = support_folder(&f.arena);
    for (int i = 0; i < FILE_COUNT; i++) {
        Arena arena = {0};
        Building b;
        sums_of_read_building(FILES[i], &arena, &b);
        sum_building(&f, strrchr(FILES[i], '/') + 1, &b);
        arena_free(&arena);
    }
    for (int i = 0; HOSTILE_KINDS[i].name; i++) {
        Arena arena = {0};
        Building b;
        if (sums_of_read_hostile(&HOSTILE_KINDS[i], folder, &arena, &b))
            sum_building(&f, HOSTILE_KINDS[i].name, &b);
        arena_free(&arena);
    }
    sums_end(&f);
}
