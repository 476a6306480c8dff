// test_soup_obj.c - OBJ models of buildings, and triangles joined back to polygons.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "engine/core/text.h"
#include "maps/polygons/soup_readers.h"
#include "tests/support/files/soups.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_OBJ, MAPS_READER_QUADS;

static void refuse(const char *text, const char *expected) {
    soups_refuse(&MAPS_READER_OBJ, "t.obj", text, expected);
}

static void accept(Arena *arena, const char *text, Building *b) {
    soups_accept(&MAPS_READER_OBJ, "t.obj", text, arena, b);
}

// The room of soups.h, y up, a group a wall; as quads or as two triangles a wall.
static const char *room(Arena *arena, const char *head, bool triangles) {
    Text text = {.arena = arena};
    text_append(&text, "%s", head);
    for (int i = 0; i < 8; i++)
        text_append(&text, "v %g %g %g\n", SOUPS_ROOM[i][0], SOUPS_ROOM[i][2], -SOUPS_ROOM[i][1]);
    for (int i = 0; i < 6; i++) {
        const int *w = SOUPS_WALL[i];
        text_append(&text, "g wall %d\n", i);
        if (triangles)
            text_append(&text, "f %d %d %d\nf %d/1 %d//2 %d/3/4\n", w[0] + 1, w[1] + 1, w[2] + 1, w[0] - 8,
                        w[2] - 8, w[3] - 8);
        else
            text_append(&text, "f %d %d %d %d\n", w[0] + 1, w[1] + 1, w[2] + 1, w[3] + 1);
    }
    return text.data;
}

static const char *quads_room(Arena *arena) {
    Text text = {.arena = arena};
    for (int i = 0; i < 6; i++) {
        text_append(&text, "quad q%d 0.5 0", i);
        for (int k = 0; k < 4; k++) {
            const double *v = SOUPS_ROOM[SOUPS_WALL[i][k]];
            text_append(&text, " %g %g %g", v[0], v[1], v[2]);
        }
        text_append(&text, "\n");
    }
    return text.data;
}

// One room in three spellings gives the same polygons, with the walls' names.
Test(soup_obj, same_room) {
    Arena arena = {0};
    Building quads, faces, triangles;
    soups_accept(&MAPS_READER_QUADS, "t.quads", quads_room(&arena), &arena, &quads);
    accept(&arena, room(&arena, "", false), &faces);
    accept(&arena, room(&arena, "", true), &triangles);
    soups_expect_same(&quads, &faces);
    soups_expect_same(&quads, &triangles);
    cr_assert_eq(triangles.object_count, 6);
    cr_expect_str_eq(triangles.objects[5].name, "wall 5");
    cr_expect_eq(triangles.form, FORM_SOUP);
    cr_expect_eq(triangles.start.z, 1.25);
    arena_free(&arena);
}

// Comments above the first vertex say which way is up and what the unit is; others say nothing.
Test(soup_obj, conventions) {
    static const struct {
        const char *head;
        bool z_up;
        double unit;
    } CASES[] = {{"", false, 1},
                 {"# up z\n", true, 1},
                 {"# Z-up\n", true, 1},
                 {"#up axis: Z\n", true, 1},
                 {"# the z axis is up\n", true, 1},
                 {"# Y up, z forward\n", false, 1},
                 {"# unit 0.01\n", false, 0.01},
                 {"# Model units = inches\n", false, 0.0254},
                 {"# units: 1 unit = 1 cm\n", false, 0.01},
                 {"# unit 2.5e-3\n# up z\n", true, 0.0025},
                 {"# unit 2 ft\n", false, 0.6096},
                 {"# All units in cm\n", false, 0.01},
                 {"# units: in\n", false, 0.0254},
                 {"# units in this file\n", false, 1},
                 {"# unit zero\n# units 0\n# unit -1\n# unit 1e9\n", false, 1},
                 {"# 12 units high, wound up to the roof\n", false, 1},
                 {"v 9 9 9\n# up z\n# unit 0.01\n", false, 1}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        accept(&arena, arena_format(&arena, "%sv 0 0 0\nv 8 0 0\nv 8 2 -4\nf -3 -2 -1\n", CASES[i].head), &b);
        double z = (CASES[i].z_up ? -4 : 2) * CASES[i].unit, y = (CASES[i].z_up ? 2 : 4) * CASES[i].unit;
        // Tolerance: one rounding of the product.
        cr_expect(fabs(b.vertices[2].z - z) < 1e-12 && fabs(b.vertices[2].y - y) < 1e-12, "%s: (%g, %g)",
                  CASES[i].head, b.vertices[2].y, b.vertices[2].z);
        arena_free(&arena);
    }
}

static void write_file(Arena *arena, const char *folder, const char *name, const char *text) {
    Error error;
    cr_assert(file_write(arena_format(arena, "%s/%s", folder, name), text, strlen(text), &error), "%s",
              error.text);
}

// Colours, transparency and light come from the library beside the file, which counts into the building's hash; files
// outside the folder are not opened.
Test(soup_obj, materials) {
    Arena arena = {0};
    Building a, b;
    Error error = {""};
    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/house.obj", folder);
    file_make_folder(arena_format(&arena, "%s/sub", folder), &error);
    write_file(
        &arena, folder, "sub/house.mtl",
        "newmtl wall\nKd 1 0.5 0\nnewmtl pane\nd 0.25\nKd 0 0 0\nnewmtl lamp\nKe 100 50 1e99\nKd 0 0 0\n");
    write_file(&arena, folder, "house.obj",
               "mtllib sub/house.mtl\nmtllib ../house.mtl\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\no o\nusemtl "
               "wall\nf 1 2 "
               "3\nusemtl pane\nf 1 3 4\nusemtl lamp\nf 4 3 2\n");
    cr_assert(maps_read(path, &arena, &a, &error), "%s", error.text);
    cr_assert_eq(a.object_count, 1);
    cr_assert_eq(a.polygon_count, 3, "materials keep faces apart");
    const Material *m[3];
    for (int i = 0; i < 3; i++) m[i] = &a.materials[a.polygons[i].material];
    cr_expect_eq(m[0]->reflectance.r, MAPS_MAX_COLOUR);
    cr_expect_eq(m[0]->reflectance.g, maps_linear(128));
    cr_expect_str_eq(m[0]->name, "wall");
    cr_expect_eq(m[1]->alpha, 0.25f);
    cr_expect(m[2]->emission.r == 100 && m[2]->emission.g == 50 && m[2]->emission.b == 1e9f);
    cr_expect_eq(soups_notes(&a, "`../house.mtl`"), 1);
    write_file(&arena, folder, "sub/house.mtl", "newmtl wall\nKd 0 0 0\n");
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_expect_neq(a.hash, b.hash, "another library makes another building");
    arena_free(&arena);
}

// Every fault is refused with its line; furniture would skip it.
Test(soup_obj, faults) {
    static const char V[] = "v 0 0 0\nv 4 0 0\nv 4 3 0\nf 1 2 3\n";
    static const struct {
        const char *more, *expected;
    } CASES[] = {
        {"f 1 2 4", "t.obj:5: a corner of a face is `4` (allowed: 1 to 3 or -1 to -3"},
        {"f 1 2 0", "t.obj:5: a corner of a face is `0`"},
        {"f 1 2 3.5", "t.obj:5: a corner of a face is `3.5`"},
        {"f 1 2 3x/1", "t.obj:5: a corner of a face is `3x/1`"},
        {"f 1 2 \\\n -4/7", "t.obj:6: a corner of a face is `-4/7`"},
        {"f 1 2 x\x01y", "t.obj:5: a corner of a face is `x?y`"},
        {"f 1 2 2147483649", "a corner of a face is `2147483649`"},
        {"f 1 2 99999999999999999999", "a corner of a face is `99999999999999999999`"},
        {"f 1 2", "t.obj:5: a face has 2 corners (allowed: 3 or more)"},
        {"v 1 2\nf 1 2 3", "t.obj:5: the coordinates of vertex 4 are not three numbers"},
        {"\nv 1 2 inf", "t.obj:6: the coordinates of vertex 4"},
        {"v 1 2 nan", "t.obj:5: the coordinates of vertex 4"},
        {"v 1 2 1e9\nf 1 2 4",
         "t.obj:6: a corner of a face lies at (1, -1e+09, 2) m (allowed: within 1e+08 m)"},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++)
        refuse(arena_format(&arena, "%s%s\n", V, CASES[i].more), CASES[i].expected);
    refuse("", "t.obj: no usable face");
    refuse("v 0 0 0\n", "t.obj: no usable face");
    refuse("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", "t.obj: holds no polygon that has an area");
    Text round = {.arena = &arena};
    for (int i = 0; i < 257; i++)
        text_append(&round, "v %.17g %.17g 0\n", cos(i * 2 * M_PI / 257), sin(i * 2 * M_PI / 257));
    text_append(&round, "f");
    for (int i = 1; i <= 257; i++) text_append(&round, " %d", i);
    refuse(round.data, "t.obj:258: a face has 257 corners (allowed 3 to 256)");
    arena_free(&arena);
}

// Groups beyond the limit keep their faces, which is said; sizes no building has are said with the way out.
Test(soup_obj, notes) {
    Arena arena = {0};
    Building b;
    Text text = {.arena = &arena};
    text_append(&text, "v 0 0 0\nv 4 0 0\nv 4 3 0\n");
    for (int i = 0; i < 4100; i++) text_append(&text, "g %d\nf 1 2 3\n", i);
    accept(&arena, text.data, &b);
    cr_expect_eq(b.polygon_count, 4100);
    cr_expect_eq(soups_notes(&b, "5 names of groups or materials beyond 4096 are not kept"), 1);
    accept(&arena, "# unit mm\nv 0 0 0\nv 4 0 0\nv 4 3 0\nf 1 2 3\n", &b);
    cr_expect_eq(soups_notes(&b, "a comment above the first vertex, such as `# unit 0.01`"), 1);
    accept(&arena, "v 0 0 0\nv 4 0 0\nv 4 3 0\nf 1 2 3\nf 1 2 1\n", &b);
    cr_expect_eq(soups_notes(&b, "1 faces have no area"), 1);
    arena_free(&arena);
}

static double area_of(const SoupMesh *mesh) {
    double sum = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        Vec3 ring[SOUP_MAX_CORNERS];
        for (int i = 0; i < mesh->faces[f].corner_count; i++)
            ring[i] = mesh->vertices[mesh->corners[mesh->faces[f].first_corner + i]];
        sum += polygon_area(ring, mesh->faces[f].corner_count);
    }
    return sum;
}

// A grid of triangles of random materials: faces join within one material only, every corner stays a corner of the
// mesh, the area is the same and all are convex. 40 grids.
Test(soup_merge, joins_what_is_convex) {
    Random random = {11};
    for (int round = 0; round < 40; round++) {
        Arena arena = {0};
        int n = 2 + random_index(&random, 6), materials = 1 + random_index(&random, 3);
        double lean = random_between(&random, -1, 1);
        SoupMesh mesh = {.vertices = ARENA_ARRAY(&arena, Vec3, (n + 1) * (n + 1)),
                         .corners = ARENA_ARRAY(&arena, int, 6 * n * n),
                         .faces = ARENA_ARRAY(&arena, SoupFace, 2 * n * n),
                         .vertex_count = (n + 1) * (n + 1)};
        for (int i = 0; i < mesh.vertex_count; i++)
            mesh.vertices[i] = vec3(i % (n + 1), i / (n + 1), lean * (i % (n + 1)));
        for (int i = 0; i < n * n; i++) {
            int a = i / n * (n + 1) + i % n, corner[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
            for (int k = 0; k < 2; k++)
                mesh.faces[mesh.face_count++] =
                    (SoupFace){6 * i + 3 * k, 3,
                               k == 0 ? random_index(&random, materials) : mesh.faces[2 * i].material, 0};
            memcpy(mesh.corners + 6 * i, corner, sizeof corner);
        }
        mesh.corner_count = 6 * n * n;
        SoupMesh merged;
        soup_merge(&mesh, &arena, &merged);
        cr_expect_leq(merged.face_count, n * n, "at least the two triangles of each square join");
        // Tolerance: rounding of sums of a few dozen areas.
        cr_expect_float_eq(area_of(&merged), area_of(&mesh), 1e-9);
        for (int f = 0; f < merged.face_count; f++) {
            Vec3 ring[SOUP_MAX_CORNERS];
            int count = merged.faces[f].corner_count;
            for (int i = 0; i < count; i++)
                ring[i] = merged.vertices[merged.corners[merged.faces[f].first_corner + i]];
            cr_expect(polygon_is_convex(ring, count, plane_of_polygon(ring, count).n), "round %d", round);
        }
        arena_free(&arena);
    }
}

static int merged_count(const Vec3 *v, int vertices, const int *corners, int triangles,
                        const int *materials) {
    Arena arena = {0};
    SoupFace faces[8];
    int copy[24];
    memcpy(copy, corners, sizeof(int) * 3 * (size_t)triangles);
    Vec3 points[12];
    memcpy(points, v, sizeof(Vec3) * (size_t)vertices);
    for (int i = 0; i < triangles; i++) faces[i] = (SoupFace){3 * i, 3, materials ? materials[i] : 0, 0};
    SoupMesh mesh = {.vertices = points,
                     .corners = copy,
                     .faces = faces,
                     .vertex_count = vertices,
                     .corner_count = 3 * triangles,
                     .face_count = triangles};
    SoupMesh merged;
    soup_merge(&mesh, &arena, &merged);
    int count = merged.face_count;
    arena_free(&arena);
    return count;
}

// Polygons that must stay apart stay apart: another material, a bend, opposite sides, a concave whole, an edge of three, front
// and back.
Test(soup_merge, leaves_the_rest) {
    const Vec3 v[] = {{0, 0, 0},    {1, 0, 0},   {1, 1, 0}, {0, 1, 0},
                      {0, 1, 0.01}, {1.5, 3, 0}, {1, 1, 0}, {0, 0, 0}};
    const int square[] = {0, 1, 2, 0, 2, 3}, split[] = {0, 1, 2, 7, 6, 3}, bent[] = {0, 1, 2, 0, 2, 4},
              back[] = {0, 1, 2, 0, 3, 2}, dart[] = {0, 1, 2, 1, 5, 2}, three[] = {0, 1, 2, 0, 2, 3, 0, 2, 4},
              apart[] = {0, 1};
    cr_expect_eq(merged_count(v, 8, square, 2, NULL), 1);
    cr_expect_eq(merged_count(v, 8, split, 2, NULL), 1, "vertices at one place are one");
    cr_expect_eq(merged_count(v, 8, square, 2, apart), 2);
    cr_expect_eq(merged_count(v, 8, bent, 2, NULL), 2);
    cr_expect_eq(merged_count(v, 8, back, 2, NULL), 2);
    cr_expect_eq(merged_count(v, 8, dart, 2, NULL), 2);
    cr_expect_eq(merged_count(v, 8, three, 3, NULL), 3);
    // Front and back of one triangle share all edges; where its angle is blunt, what they make turns once.
    const Vec3 blunt[] = {{0, 0, 0}, {4, 0, 0}, {2, 1, 0}};
    const int both[] = {0, 1, 2, 1, 0, 2};
    cr_expect_eq(merged_count(blunt, 3, both, 2, NULL), 2);
}

// Two triangles of a square with a texture of 100 x 10 texels become one where one map fits both to half a texel, 0.005 across and
// 0.05 down, and keep the places of their corners; a seam, another scale beyond the edge or a texture beside none keeps them apart.
Test(soup_merge, joins_textures_that_go_on) {
    static const struct {
        const char *what;
        double du, dv, seam;  // added to the place of corner 5, alone; to those of the second triangle
        int textures[2], faces;
    } CASES[] = {{"one map", 0, 0, 0, {1, 1}, 1},
                 {"within half a texel", 0.004, 0.04, 0, {1, 1}, 1},
                 {"stretched across", 0.04, 0, 0, {1, 1}, 2},
                 {"stretched down", 0, 0.4, 0, {1, 1}, 2},
                 {"a seam", 0, 0, 0.25, {1, 1}, 2},
                 {"no texture", 3, 3, 3, {0, 0}, 1}};
    const Texture textures[] = {{0}, {.width = 100, .height = 10}};
    for (size_t c = 0; c < sizeof CASES / sizeof *CASES; c++) {
        Arena arena = {0};
        Vec3 v[] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
        int corners[] = {0, 1, 2, 0, 2, 3};
        Vec2 places[6];
        for (int i = 0; i < 6; i++)
            places[i] = vec2(v[corners[i]].x + (i < 3 ? 0 : CASES[c].seam), 3 * v[corners[i]].y);
        places[5] = vec2_add(places[5], vec2(CASES[c].du, CASES[c].dv));
        SoupFace faces[] = {{0, 3, 7, CASES[c].textures[0]}, {3, 3, 7, CASES[c].textures[1]}};
        SoupMesh mesh = {v, corners, faces, places, textures, 4, 6, 2}, merged;
        soup_merge(&mesh, &arena, &merged);
        cr_expect_eq(merged.face_count, CASES[c].faces, "%s", CASES[c].what);
        for (int i = 0; i < merged.corner_count && CASES[c].seam == 0; i++) {
            Vec3 p = merged.vertices[merged.corners[i]];
            Vec2 off = vec2_sub(merged.places[i], vec2(p.x, 3 * p.y));
            // Tolerance: rounding of places up to 4.
            cr_expect(fabs(off.x) <= CASES[c].du + 1e-12 && fabs(off.y) <= CASES[c].dv + 1e-12, "%s",
                      CASES[c].what);
        }
        arena_free(&arena);
    }
}

// Names that nobody knows are told once, with their count and the names; a name of Sweet Home 3D's table is known.
Test(soup_obj, notes_unknown_materials) {
    Arena arena = {0};
    Building b;
    Error error = {""};
    const char *folder = support_folder(&arena);
    write_file(&arena, folder, "house.obj",
               "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 2 2 2\nusemtl oak\nf 1 2 3\nusemtl amber\nf 1 3 4\n"
               "usemtl steel\nf 1 2 5\nusemtl oak\nf 2 3 5\n");
    cr_assert(maps_read(arena_format(&arena, "%s/house.obj", folder), &arena, &b, &error), "%s", error.text);
    cr_expect_eq(
        soups_notes(&b, "house.obj: 2 materials have a name that neither a library nor Sweet Home 3D knows, "
                        "and the colour of its default material: oak, steel"),
        1);
    cr_expect_eq(b.materials[b.polygons[0].material].gloss, 0,
                 "oak is matt, since nobody says how shiny it is");
    cr_expect_eq(b.materials[b.polygons[1].material].gloss, 60 / 128.0f);
    arena_free(&arena);
}

Test(soup_obj, survives_damage, .timeout = 120) {
    Arena arena = {0};
    const char *text = room(&arena, "# up y\n# unit 1\nmtllib none.mtl\nusemtl glass\n", true);
    soups_damage(&MAPS_READER_OBJ, "t.obj", text, strlen(text), 3, support_count(3000, 300000));
    arena_free(&arena);
}
