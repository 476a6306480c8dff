// test_foreign.c - models of COLLADA and 3DS, alone and as furniture.
#include <criterion/criterion.h>
#include <string.h>

#include "tests/support/files/home_fixture.h"
#include "tests/support/files/soups.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_FOREIGN;

// A floor of 2 m x 1 m, 0.5 m up, in centimetres with z up; its place is a node's.
#define COLLADA_FLOOR                                                                                        \
    "<?xml version='1.0' encoding='utf-8'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' "   \
    "version='1.4.1'><asset><unit meter='0.01' "                                                             \
    "name='cm'/><up_axis>Z_UP</up_axis></asset><library_effects><effect "                                    \
    "id='e'><profile_COMMON><technique sid='t'><lambert><diffuse><color>0.5 0.25 0.125 "                     \
    "1</color></diffuse></lambert>"                                                                          \
    "</technique></profile_COMMON></effect></library_effects><library_materials><material id='m' "           \
    "name='paint'>"                                                                                          \
    "<instance_effect url='#e'/></material></library_materials><library_geometries><geometry id='g' "        \
    "name='quad'><mesh>"                                                                                     \
    "<source id='p'><float_array id='pa' count='12'>0 0 0 200 0 0 200 100 0 0 100 "                          \
    "0</float_array><technique_common>"                                                                      \
    "<accessor source='#pa' count='4' stride='3'><param name='X' type='float'/><param name='Y' "             \
    "type='float'/><param "                                                                                  \
    "name='Z' type='float'/></accessor></technique_common></source><vertices id='v'><input "                 \
    "semantic='POSITION' "                                                                                   \
    "source='#p'/></vertices><polylist count='1' material='M'><input semantic='VERTEX' source='#v' "         \
    "offset='0'/>"                                                                                           \
    "<vcount>4</vcount><p>0 1 2 "                                                                            \
    "3</p></polylist></mesh></geometry></library_geometries><library_visual_scenes>"                         \
    "<visual_scene id='vs'><node id='n' name='floor'><translate>100 0 50</translate><instance_geometry "     \
    "url='#g'>"                                                                                              \
    "<bind_material><technique_common><instance_material symbol='M' "                                        \
    "target='#m'/></technique_common></bind_material>"                                                       \
    "</instance_geometry></node></visual_scene></library_visual_scenes><scene><instance_visual_scene "       \
    "url='#vs'/>"                                                                                            \
    "</scene></COLLADA>"

// Proves that units, axes and the places of nodes count, and that colours come along. Tolerance: single precision, printed with nine
// digits.
Test(foreign, collada) {
    Arena arena = {0};
    Building b;
    soups_accept(&MAPS_READER_FOREIGN, "t.dae", COLLADA_FLOOR, &arena, &b);
    cr_assert_eq(b.polygon_count, 1);
    cr_assert_eq(b.polygons[0].vertex_count, 4);
    static const Vec3 CORNERS[4] = {{1, 0, 0.5}, {3, 0, 0.5}, {3, 1, 0.5}, {1, 1, 0.5}};
    for (int k = 0; k < 4; k++)
        cr_expect(vec3_length(vec3_sub(b.vertices[b.polygons[0].first_vertex + k], CORNERS[k])) < 1e-6, "%d",
                  k);
    const Material *m = &b.materials[b.polygons[0].material];
    cr_expect_str_eq(m->name, "paint");
    cr_expect_eq(m->alpha, 1);
    arena_free(&arena);
}

// ---- 3DS

static int put(unsigned char *to, int at, const void *data, int size) {
    memcpy(to + at, data, (size_t)size);
    return at + size;
}
static int put16(unsigned char *to, int at, int value) {
    return put(to, at, (unsigned char[]){(unsigned char)value, (unsigned char)(value >> 8)}, 2);
}

// Begins a chunk; end_chunk writes its length.
static int begin_chunk(unsigned char *to, int at, int kind) { return put16(to, at, kind) + 4; }
static void end_chunk(unsigned char *to, int begin, int at) {
    int size = at - begin + 6;
    memcpy(to + begin - 4, &size, 4);
}

// A box 2 x 1 x 1 at the origin, z up, of twelve triangles; returns its size.
static int box_3ds(unsigned char *to) {
    static const int FACES[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                    {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    int main_at = begin_chunk(to, 0, 0x4D4D), at = begin_chunk(to, main_at, 0x0002);
    at = put(to, at, (int[]){3}, 4);
    end_chunk(to, at - 4, at);
    int editor = begin_chunk(to, at, 0x3D3D), object = begin_chunk(to, editor, 0x4000);
    int mesh = begin_chunk(to, put(to, object, "box", 4), 0x4100), vertices = begin_chunk(to, mesh, 0x4110);
    at = put16(to, vertices, 8);
    for (int i = 0; i < 8; i++) {
        const float v[3] = {i % 4 == 1 || i % 4 == 2 ? 2 : 0, i % 4 >= 2, i >= 4};
        at = put(to, at, v, 12);
    }
    end_chunk(to, vertices, at);
    int faces = begin_chunk(to, at, 0x4120);
    at = put16(to, faces, 12);
    for (int i = 0; i < 12; i++) {
        const int *f = FACES[i / 2], corner[4] = {f[0], f[1 + i % 2], f[2 + i % 2], 7};
        for (int k = 0; k < 4; k++) at = put16(to, at, corner[k]);
    }
    end_chunk(to, faces, at);
    end_chunk(to, mesh, at);
    end_chunk(to, object, at);
    end_chunk(to, editor, at);
    end_chunk(to, main_at, at);
    return at;
}

// Proves that a box of triangles becomes six faces that look outwards, z up: they enclose 2 m^3.
Test(foreign, box_of_3ds) {
    Arena arena = {0};
    unsigned char file[1024] = {0};
    int size = box_3ds(file);
    Building b = {0};
    Error error = {""};
    cr_assert(soups_read(&MAPS_READER_FOREIGN, "t.3ds", file, (size_t)size, &arena, &b, &error), "%s",
              error.text);
    cr_assert_eq(b.polygon_count, 6);
    double volume = 0;
    for (int i = 0; i < b.polygon_count; i++) {
        const Vec3 *v = b.vertices + b.polygons[i].first_vertex;
        for (int k = 1; k + 1 < b.polygons[i].vertex_count; k++)
            volume += vec3_dot(v[0], vec3_cross(v[k], v[k + 1])) / 6;
    }
    cr_expect_float_eq(volume, 2, 1e-6);
    Vec3 size_of = vec3_sub(b.world.max, b.world.min);
    cr_expect_float_eq(size_of.x, 2, 1e-6);
    cr_expect_float_eq(size_of.z, 1, 1e-6);
    arena_free(&arena);
}

// Proves that files cut short, and text that only seems to be of the format, cost one sentence.
Test(foreign, damage_costs_a_sentence) {
    unsigned char file[1024] = {0};
    int size = box_3ds(file);
    Arena arena = {0};
    Building b = {0};
    Error error = {""};
    cr_expect_not(soups_read(&MAPS_READER_FOREIGN, "t.3ds", file, (size_t)size / 3, &arena, &b, &error));
    cr_expect(strstr(error.text, "t.3ds: is no 3DS model that can be read"), "%s", error.text);
    soups_refuse(&MAPS_READER_FOREIGN, "t.dae", "<COLLADA version='1.4.1'><scene>",
                 "t.dae: is no COLLADA model");
    char *long_text = arena_alloc(&arena, sizeof COLLADA_FLOOR, 1);
    memcpy(long_text, COLLADA_FLOOR, sizeof COLLADA_FLOOR - 300);
    soups_refuse(&MAPS_READER_FOREIGN, "t.dae", long_text, "t.dae: ");
    soups_damage(&MAPS_READER_FOREIGN, "t.3ds", file, (size_t)size, 1, support_count(60, 1000));
    soups_damage(&MAPS_READER_FOREIGN, "t.dae", COLLADA_FLOOR, sizeof COLLADA_FLOOR - 1, 2,
                 support_count(60, 1000));
    arena_free(&arena);
}

// Proves that a home's furniture may be of COLLADA: it fills the piece's box, and is no box of six faces.
Test(foreign, furniture) {
    static const char XML[] =
        "<home wallHeight='250'>" HOME_ROOM
        "<pieceOfFurniture name='w' model='1/floor.dae' x='100' y='200' width='10' depth='40' "
        "height='20'/></home>";
    HomeEntry entries[] = {{"Home.xml", XML, strlen(XML)},
                           {"1/floor.dae", COLLADA_FLOOR, sizeof COLLADA_FLOOR - 1}};
    Home h = home_of_zip(entries, 2);
    cr_assert_eq(h.b.polygon_count, 1);
    Box box = box_empty();
    for (int k = 0; k < 4; k++) box = box_add(box, h.b.vertices[h.b.polygons[0].first_vertex + k]);
    cr_expect_float_eq(box.max.x - box.min.x, 0.1, 1e-9);
    cr_expect_float_eq(box.max.y - box.min.y, 0.4, 1e-9);
    home_free(&h);
}
