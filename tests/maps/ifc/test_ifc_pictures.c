// test_ifc_pictures.c - pictures of surface styles: where they lie on the faces of bodies that are moved, cut and mapped, and what the
// building shows of them.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "maps/building/texture.h"
#include "maps/ifc/shape.h"
#include "tests/maps/ifc/house_fixture.h"
#include "tests/maps/ifc/ifc_fixture.h"
#include "tests/support/support.h"

// Two by two pixels, from the lower left one on: red, green, blue, white.
#define PIXELS                                                                                               \
    "#200=IFCPIXELTEXTURE(.T.,.T.,$,$,$,2,2,3,(\"0FF0000\",\"000FF00\",\"00000FF\",\"0FFFFFF\"));\n"
#define STYLE                                                                                                \
    "#201=IFCSURFACESTYLEWITHTEXTURES((#200));\n#202=IFCSURFACESTYLE('tile',.BOTH.,(#203,#201));\n"          \
    "#203=IFCSURFACESTYLERENDERING(#204,0.,$,$,$,$,$,$,.NOTDEFINED.);\n#204=IFCCOLOURRGB($,0.5,0.5,0.5);\n"  \
    "#205=IFCSTYLEDITEM(#101,(#202),$);\n"
// A square of 2 x 2 m in the plane z = 1 as two triangles. The picture lies on it once, s along x and t along y.
#define SQUARE                                                                                               \
    "#101=IFCTRIANGULATEDFACESET(#102,$,.F.,((1,2,3),(1,3,4)),$);\n"                                         \
    "#102=IFCCARTESIANPOINTLIST3D(((0.,0.,1.),(2.,0.,1.),(2.,2.,1.),(0.,2.,1.)));\n"                         \
    "#103=IFCINDEXEDTRIANGLETEXTUREMAP((#200),#101,#104,((1,2,3),(1,3,4)));\n"                               \
    "#104=IFCTEXTUREVERTEXLIST(((0.,0.),(1.,0.),(1.,1.),(0.,1.)));\n"

// Each corner's place is that of the point of the square that it was: `back` leads to the square from where it lies.
static void expect_places(const IfcMesh *mesh, const Frame *back, int least) {
    cr_assert(mesh->places);
    cr_assert_geq(mesh->corner_count, least);
    for (int i = 0; i < mesh->corner_count; i++) {
        Vec3 p = frame_point(back, mesh->corners[i]);
        cr_expect_float_eq(mesh->places[i].x, p.x / 2, 1e-9, "corner %d at (%g, %g)", i, p.x, p.y);
        cr_expect_float_eq(mesh->places[i].y, 1 - p.y / 2, 1e-9, "corner %d at (%g, %g)", i, p.x, p.y);
    }
}

static const IfcProduct *read_one(Arena *arena, const char *data, IfcModel *model) {
    ifc_accept(arena, ifc_text(arena, data), 1, model);
    for (int i = 0; i < model->note_count; i++) cr_expect(false, "%s", model->notes[i].text);
    return &model->products[0];
}

// The pixels stand from the top, and the look has both its colour and its picture.
Test(ifc_pictures, pixels) {
    static const uint8_t EXPECTED[16] = {0, 0, 255, 255, 255, 255, 255, 255, 255, 0, 0, 255, 0, 255, 0, 255};
    Arena arena = {0};
    IfcModel m;
    const IfcProduct *p =
        read_one(&arena,
                 "#100=IFCMAPPEDITEM(#110,#111);\n#110=IFCREPRESENTATIONMAP(#11,#112);\n"
                 "#111=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#10,1.,$);\n"
                 "#112=IFCSHAPEREPRESENTATION($,'Body','Tessellation',(#101));\n" SQUARE PIXELS STYLE,
                 &m);
    Frame none = frame_identity();
    expect_places(&p->mesh, &none, 6);
    const IfcMaterial *look = &m.materials[p->mesh.polygons[0].material];
    cr_assert_eq(m.texture_count, 2);
    cr_expect(look->texture == 1 && look->colour[0] == 0.5f);
    const IfcTexture *t = &m.textures[1];
    cr_assert(t->width == 2 && t->height == 2 && t->pixels);
    cr_expect_arr_eq(t->pixels, EXPECTED, sizeof EXPECTED);
    arena_free(&arena);
}

// A mapped item that turns, mirrors and stretches takes the picture with it.
Test(ifc_pictures, mapped) {
    Arena arena = {0};
    IfcModel m;
    const IfcProduct *p =
        read_one(&arena,
                 "#100=IFCMAPPEDITEM(#110,#111);\n#110=IFCREPRESENTATIONMAP(#11,#112);\n"
                 "#111=IFCCARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM(#120,#121,#122,1.5,#12,2.,1.);\n"
                 "#120=IFCDIRECTION((0.6,0.8,0.));\n#121=IFCDIRECTION((0.8,-0.6,0.));\n"
                 "#122=IFCCARTESIANPOINT((7.,-3.,0.5));\n"
                 "#112=IFCSHAPEREPRESENTATION($,'Body','Tessellation',(#101));\n" SQUARE PIXELS STYLE,
                 &m);
    Frame there = {{0.9, 1.2, 0}, {1.6, -1.2, 0}, {0, 0, 1}, {7, -3, 0.5}}, back = frame_inverse(&there);
    expect_places(&p->mesh, &back, 6);
    arena_free(&arena);
}

// The part of the square that a half space leaves keeps its part of the picture.
Test(ifc_pictures, cut) {
    Arena arena = {0};
    IfcModel m;
    const IfcProduct *p =
        read_one(&arena,
                 "#100=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#101,#110);\n#110=IFCHALFSPACESOLID(#111,.F.);\n"
                 "#111=IFCPLANE(#112);\n#112=IFCAXIS2PLACEMENT3D(#113,#13,#12);\n#113=IFCCARTESIANPOINT((0.7,"
                 "0.,0.));\n" SQUARE PIXELS STYLE,
                 &m);
    Frame none = frame_identity();
    expect_places(&p->mesh, &none, 6);
    for (int i = 0; i < p->mesh.corner_count; i++) cr_expect_leq(p->mesh.corners[i].x, 0.7 + 1e-9);
    arena_free(&arena);
}

// A face of a brep by IfcTextureMap, its bound turned: places go with the loop's points. A transform of the texture counts.
Test(ifc_pictures, face) {
    Arena arena = {0};
    IfcModel m;
    const IfcProduct *p = read_one(
        &arena,
        "#100=IFCSHELLBASEDSURFACEMODEL((#110));\n#110=IFCOPENSHELL((#111));\n#111=IFCFACE((#112));\n"
        "#112=IFCFACEOUTERBOUND(#113,.F.);\n#113=IFCPOLYLOOP((#114,#115,#116,#117));\n"
        "#114=IFCCARTESIANPOINT((0.,0.,1.));\n#115=IFCCARTESIANPOINT((2.,0.,1.));\n"
        "#116=IFCCARTESIANPOINT((2.,2.,1.));\n#117=IFCCARTESIANPOINT((0.,2.,1.));\n"
        "#120=IFCTEXTUREMAP((#200),(#121,#122,#123,#124),#111);\n#121=IFCTEXTUREVERTEX((0.,0.));\n"
        "#122=IFCTEXTUREVERTEX((0.5,0.));\n#123=IFCTEXTUREVERTEX((0.5,0.5));\n#124=IFCTEXTUREVERTEX((0.,0.5))"
        ";\n"
        "#200=IFCIMAGETEXTURE(.T.,.T.,$,#201,$,'tile.png');\n"
        "#201=IFCCARTESIANTRANSFORMATIONOPERATOR2D($,$,#202,2.);\n#202=IFCCARTESIANPOINT((0.,0.));\n"
        "#203=IFCSURFACESTYLEWITHTEXTURES((#200));\n#204=IFCSURFACESTYLE('tile',.BOTH.,(#203));\n"
        "#205=IFCSTYLEDITEM(#100,(#204),$);\n",
        &m);
    Frame none = frame_identity();
    expect_places(&p->mesh, &none, 4);
    cr_assert_eq(m.texture_count, 2);
    cr_expect_str_eq(m.textures[1].file, "tile.png");
    arena_free(&arena);
}

static const uint8_t RED[16] = {255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255};

// A table in a house, whose top has a picture: a PNG beside the model, or within it as digits.
static void read_table(Arena *arena, const char *texture, bool beside, Building *b) {
    House h = house_two_rooms(arena, false, vec2(0, 0), 0, true);
    text_append(&h.text,
                "#9100=IFCSHAPEREPRESENTATION(#5,'Body','Tessellation',(#101010));\n"
                "#9101=IFCPRODUCTDEFINITIONSHAPE($,$,(#9100));\n#9102=IFCLOCALPLACEMENT(#%d,#4);\n"
                "#9103=IFCFURNITURE('9103',$,'table',$,$,#9102,#9101,$);\n"
                "#9104=IFCRELCONTAINEDINSPATIALSTRUCTURE('9104',$,$,$,(#9103),#%d);\n"
                "#101010=IFCTRIANGULATEDFACESET(#9106,$,.F.,((1,2,3),(1,3,4)),$);\n"
                "#9106=IFCCARTESIANPOINTLIST3D(((1.,1.,0.7),(2.,1.,0.7),(2.,2.,0.7),(1.,2.,0.7)));\n"
                "#9107=IFCINDEXEDTRIANGLETEXTUREMAP((#9110),#101010,#9108,((1,2,3),(1,3,4)));\n"
                "#9108=IFCTEXTUREVERTEXLIST(((0.,0.),(1.,0.),(1.,1.),(0.,1.)));\n"
                "#9111=IFCSURFACESTYLEWITHTEXTURES((#9110));\n#9112=IFCSURFACESTYLE('top',.BOTH.,(#9111));\n"
                "#9113=IFCSTYLEDITEM(#101010,(#9112),$);\n#9110=%s;\n",
                h.placed, h.storeys[0], texture);
    Bytes file = house_end(&h), png = support_png(arena, 2, 2, RED);
    char *folder = support_folder(arena);
    const char *path = arena_format(arena, "%s/table.ifc", folder);
    Error error;
    cr_assert(file_write(path, file.data, file.size, &error), "%s", error.text);
    if (beside)
        cr_assert(file_write(arena_format(arena, "%s/top.png", folder), png.data, png.size, &error), "%s",
                  error.text);
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
}

// How many polygons of the table show a picture, each as it should.
static int count_pictured(const Building *b) {
    int count = 0;
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (strcmp(o->name, "table") != 0) continue;
        for (int k = o->first_polygon; k < o->first_polygon + o->polygon_count; k++) {
            const Polygon *p = &b->polygons[k];
            const Material *m = &b->materials[p->material];
            if (!m->texture) continue;
            cr_expect_neq(p->texture_map, 0);
            Rgb red = texture_at(b, p->material, p->texture_map, vec3(1.3, 1.3, 0.7), 0.01).colour;
            cr_expect(red.r > 0.8f && red.g < 0.01f, "(%g, %g, %g)", (double)red.r, (double)red.g,
                      (double)red.b);
            count++;
        }
    }
    return count;
}

Test(ifc_pictures, beside) {
    Arena arena = {0};
    Building b;
    read_table(&arena, "IFCIMAGETEXTURE(.T.,.T.,$,$,$,'top.png')", true, &b);
    cr_expect_geq(count_pictured(&b), 1);
    uint64_t hash = b.hash;
    read_table(&arena, "IFCIMAGETEXTURE(.T.,.T.,$,$,$,'top.png')", false, &b);
    cr_expect_eq(count_pictured(&b), 0);
    cr_expect_eq(house_notes(&b, "its picture `top.png` cannot be read"), 1);
    cr_expect_neq(b.hash, hash, "a light file would be taken for that of another look");
    arena_free(&arena);
}

Test(ifc_pictures, within) {
    Arena arena = {0};
    Building b;
    Bytes png = support_png(&arena, 2, 2, RED);
    Text digits = {.arena = &arena};
    for (size_t i = 0; i < png.size; i++) text_append(&digits, "%02X", png.data[i]);
    read_table(&arena, arena_format(&arena, "IFCBLOBTEXTURE(.T.,.T.,$,$,$,'PNG',\"0%s\")", digits.data),
               false, &b);
    cr_expect_geq(count_pictured(&b), 1);
    read_table(&arena, "IFCBLOBTEXTURE(.T.,.T.,$,$,$,'PNG',\"00102\")", false, &b);
    cr_expect_eq(count_pictured(&b), 0);
    cr_expect_eq(house_notes(&b, "its picture is damaged"), 1);
    read_table(&arena, "IFCPIXELTEXTURE(.T.,.T.,$,$,$,2,2,3,(\"0FF0000\",\"0FF0000\",\"0FF00\"))", false, &b);
    cr_expect_eq(house_notes(&b, "has no picture that is read"), 1);
    arena_free(&arena);
}
