// test_ifc_model.c - what a model tells beside its meshes: storeys, relations, names, units, looks, footprints; threads; damaged files.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/text.h"
#include "maps/ifc/step.h"
#include "tests/maps/ifc/ifc_fixture.h"
#include "tests/support/support.h"

static void read_file(Arena *arena, const char *path, int threads, IfcModel *out) {
    Bytes content = support_read(arena, path);
    IfcOptions options = {.threads = threads};
    Error error = {""};
    cr_assert(ifc_read(path, content, &options, arena, out, &error), "%s", error.text);
}

static const IfcProduct *product(const IfcModel *model, int entity) {
    for (int i = 0; i < model->product_count; i++)
        if (model->products[i].entity == entity) return &model->products[i];
    cr_assert(false, "no #%d", entity);
    return NULL;
}

// Every field that the seed's file tells.
Test(ifc, relations) {
    Arena arena = {0};
    IfcModel m;
    read_file(&arena, "tests/seeds/small.ifc", 1, &m);
    cr_expect_str_eq(m.schema, "IFC4");
    cr_expect_str_eq(m.name, "Seed");
    cr_expect_eq(m.unit, 0.001);
    cr_expect(m.placed);
    cr_expect_float_eq(m.latitude, (52 + 31.0 / 60 + 12.0 / 3600) * M_PI / 180, 1e-12);
    cr_expect_float_eq(m.north, M_PI / 4, 1e-12);
    cr_assert_eq(m.storey_count, 1);
    cr_expect_str_eq(m.storeys[0].name, "Ground \xC3\xBC\xD0\x96");
    const IfcProduct *wall = product(&m, 19), *opening = product(&m, 24), *door = product(&m, 26),
                     *space = product(&m, 52), *chest = product(&m, 111);
    cr_expect(wall->kind == IFC_WALL && wall->storey == 0 && wall->host == -1);
    cr_expect(opening->kind == IFC_OPENING && &m.products[opening->host] == wall && opening->storey == 0);
    cr_expect(door->kind == IFC_DOOR && &m.products[door->host] == opening && door->width == 1 &&
              door->height == 2);
    cr_expect_str_eq(door->operation, "SINGLE_SWING_LEFT");
    cr_expect(space->kind == IFC_SPACE && space->storey == 0);
    cr_expect_str_eq(space->name, "1.01");
    cr_expect_str_eq(space->long_name, "Room");
    cr_expect_str_eq(space->predefined, "INTERNAL");
    cr_expect(chest->kind == IFC_FURNISHING && &m.products[chest->space] == space && chest->storey == 0);
    cr_assert_eq(m.boundary_count, 1);
    cr_expect(&m.products[m.boundaries[0].space] == space && &m.products[m.boundaries[0].element] == door &&
              m.boundaries[0].physical);
    const IfcMaterial *look = &m.materials[wall->mesh.polygons[0].material];
    cr_expect_str_eq(look->name, "Clay");
    cr_expect(look->alpha == 0.75f && look->colour[0] == 0.5f && look->colour[2] == 0.3f);
    // The wall as a prism, though its mesh has a hole.
    cr_assert_eq(wall->footprint_count, 1);
    const IfcFootprint *f = &m.footprints[wall->first_footprint];
    cr_expect(f->base == 0 && f->top == 2.5 && f->ring_count == 1 && !f->clipped);
    cr_expect_eq(m.rings[f->first_ring].point_count, 4);
    cr_expect_float_eq(ifc_volume(&wall->whole_mesh) - ifc_volume(&wall->mesh), 1 * 0.2 * 2, 1e-9);
    // The note tells the number and name of a part that cannot be used.
    cr_assert_eq(m.note_count, 1);
    cr_expect(strstr(m.notes[0].text, "#78 IFCHALFSPACESOLID"), "%s", m.notes[0].text);
    arena_free(&arena);
}

// An opening of a wall is cut out of the layers that are parts of the wall, and out of their parts. Proxies are products, and so are
// members of the model for structural analysis, whose face stands for a body: a building has no place for them.
Test(ifc, parts_are_cut) {
    Arena arena = {0};
    IfcModel m;
    const char *text = ifc_text(
        &arena, "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,3.);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,4.,0.2);"
                "#110=IFCBUILDINGELEMENTPART('a',$,'layer',$,$,#20,#91,$,$);"
                "#111=IFCPROXY('b',$,'layer of the layer',$,$,#20,#91,.NOTDEFINED.,$);"
                "#112=IFCRELAGGREGATES('c',$,$,$,#90,(#110));#113=IFCRELAGGREGATES('d',$,$,$,#110,(#111));"
                "#120=IFCOPENINGELEMENT('e',$,'hole',$,$,#20,#121,$,$);"
                "#121=IFCPRODUCTDEFINITIONSHAPE($,$,(#122));"
                "#122=IFCSHAPEREPRESENTATION($,'Body','SweptSolid',(#123));"
                "#123=IFCEXTRUDEDAREASOLID(#124,#11,#12,2.);#124=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,1.,0.4);"
                "#125=IFCRELVOIDSELEMENT('f',$,$,$,#90,#120);"
                "#130=IFCSTRUCTURALSURFACEMEMBER('g',$,'m',$,$,#20,#132,.SHELL.,0.2);"
                "#131=IFCSTRUCTURALCURVEMEMBER('h',$,'n',$,$,#20,#135,.RIGID_JOINED_MEMBER.,#12);"
                "#132=IFCPRODUCTREPRESENTATION($,$,(#133));#133=IFCTOPOLOGYREPRESENTATION($,'Reference','"
                "Face',(#134));"
                "#134=IFCFACESURFACE((#136),#140,.T.);#135=IFCPRODUCTDEFINITIONSHAPE($,$,(#141));"
                "#136=IFCFACEOUTERBOUND(#137,.T.);#137=IFCPOLYLOOP((#10,#138,#139));"
                "#138=IFCCARTESIANPOINT((2.,0.,0.));#139=IFCCARTESIANPOINT((0.,3.,0.));#140=IFCPLANE(#11);"
                "#141=IFCTOPOLOGYREPRESENTATION($,'Reference','Edge',(#142));#142=IFCEDGE(#143,#144);"
                "#143=IFCVERTEXPOINT(#10);#144=IFCVERTEXPOINT(#138);");
    ifc_accept(&arena, text, 1, &m);
    cr_assert_eq(m.product_count, 6);
    cr_expect_eq(product(&m, 130)->kind, IFC_UNBUILT);
    cr_expect_float_eq(ifc_area(&product(&m, 130)->mesh), 3, 1e-9);
    cr_expect_eq(product(&m, 131)->mesh.polygon_count, 0);
    for (int i = 0; i < 3; i++) {
        static const int CUT[] = {90, 110, 111};
        const IfcProduct *p = product(&m, CUT[i]);
        cr_expect_float_eq(ifc_volume(&p->whole_mesh), 4 * 0.2 * 3, 1e-9, "#%d", CUT[i]);
        cr_expect_float_eq(ifc_volume(&p->mesh), 4 * 0.2 * 3 - 0.2 * 2, 1e-9, "#%d", CUT[i]);
    }
    cr_expect_eq(m.note_count, 0);
    arena_free(&arena);
}

// A circle has the chords that are asked for; a large one has more, so that none lies farther off than 2 cm.
Test(ifc, chords) {
    static const double RADIUS[] = {0.1, 2, 20};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        IfcModel m;
        Error error = {""};
        IfcOptions options = ifc_default_options();
        double r = RADIUS[i];
        const char *text = ifc_text(&arena, arena_format(&arena,
                                                         "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,1.);"
                                                         "#101=IFCCIRCLEPROFILEDEF(.AREA.,$,#14,%.1f);",
                                                         r));
        Bytes content = {(unsigned char *)arena_string(&arena, text), strlen(text)};
        cr_assert(ifc_read("t.ifc", content, &options, &arena, &m, &error), "%s", error.text);
        int chords = m.points ? m.rings[0].point_count : 0;
        if (r <= 2) cr_expect_eq(chords, options.circle_chords, "radius %g: %d chords", r, chords);
        cr_expect_leq(r * (1 - cos(M_PI / chords)), 0.0201, "radius %g: %d chords", r, chords);
        arena_free(&arena);
    }
}

static uint64_t model_hash(const IfcModel *m) {
    uint64_t h = file_hash(m->points, (size_t)m->point_count * sizeof(Vec2), 1);
    for (int i = 0; i < m->product_count; i++) {
        const IfcProduct *p = &m->products[i];
        h = file_hash(p->name, strlen(p->name), h);
        h = file_hash(p->mesh.corners, (size_t)p->mesh.corner_count * sizeof(Vec3), h);
        h = file_hash(p->mesh.polygons, (size_t)p->mesh.polygon_count * sizeof(IfcPolygon), h);
    }
    for (int i = 0; i < m->note_count; i++) h = file_hash(m->notes[i].text, strlen(m->notes[i].text), h);
    return h;
}

// The same bytes on one thread and on three, of a building of two storeys.
Test(ifc, threads) {
    const char *path = support_either("ifc/Duplex_A_20110907.ifc", "tests/seeds/small.ifc");
    Arena one = {0}, three = {0};
    IfcModel a, b;
    read_file(&one, path, 1, &a);
    read_file(&three, path, 3, &b);
    cr_expect_eq(model_hash(&a), model_hash(&b));
    cr_expect_gt(a.polygon_count, 10);
    arena_free(&one);
    arena_free(&three);
}

// Far from the origin, sums of coordinates would lose digits: the model is moved near, and says by how much.
Test(ifc, far_away) {
    Arena arena = {0};
    IfcModel m;
    ifc_accept(&arena,
               ifc_text(&arena, "#100=IFCBLOCK(#101,1.,1.,1.);#101=IFCAXIS2PLACEMENT3D(#102,$,$);"
                                "#102=IFCCARTESIANPOINT((3500000.25,5800000.,40.));"),
               1, &m);
    cr_expect(m.origin.x == 3500001 && m.origin.y == 5800001 && m.origin.z == 0);
    cr_expect(m.products[0].box.min.x == -0.75 && m.products[0].box.max.x == 0.25 &&
              m.products[0].box.min.z == 40);
    arena_free(&arena);
}

// Strings in every encoding that the standard and its breakers use.
Test(ifc, strings) {
    static const struct {
        const char *text, *utf8;
    } CASES[] = {{"It''s", "It's"},
                 {"a\\\\b", "a\\b"},
                 {"\\X\\E4", "\xC3\xA4"},
                 {"\\S\\d", "\xC3\xA4"},
                 {"\\PA\\x", "x"},
                 {"\\X2\\00E400DF\\X0\\!", "\xC3\xA4\xC3\x9F!"},
                 {"\\X2\\D83DDE00\\X0\\", "\xF0\x9F\x98\x80"},
                 {"\\X4\\0001F600\\X0\\", "\xF0\x9F\x98\x80"},
                 {"\\X2\\D83D\\X0\\", "\xEF\xBF\xBD"},
                 {"\\X2\\00", "00"},
                 {"\xC3\xA4", "\xC3\xA4"},
                 {"\xE4", "\xC3\xA4"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        StepFile file = {.text = CASES[i].text, .size = strlen(CASES[i].text)};
        StepValue value = {.kind = STEP_STRING, .size = file.size};
        StepStrings strings = {.arena = &arena};
        cr_expect_str_eq(step_string(&file, &value, &strings), CASES[i].utf8, "%s", CASES[i].text);
        arena_free(&arena);
    }
}

#define HEAD "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"

// Each fault of the text has a sentence with its line.
Test(ifc, faults_of_text) {
    ifc_refuse("", "t.ifc: is no STEP file");
    ifc_refuse("ISO-10303-21;\nHEADER;\n", "t.ifc:3: the file ends within its header");
    ifc_refuse(HEAD "#1=IFCWALL($);\n", "t.ifc:7: the file ends before its data does (expected ENDSEC)");
    ifc_refuse(HEAD "#1=IFCWALL($)\n", "t.ifc:6: the file ends within the statement `#1=IFCWALL($)`");
    ifc_refuse(HEAD "\n#1=IFCWALL('a);\nENDSEC;\n", "t.ifc:7: the file ends within the statement");
    ifc_refuse(HEAD "#1 IFCWALL($);ENDSEC;",
               "t.ifc:6: `#1 IFCWALL($);ENDSEC;` lacks the = behind its number");
    ifc_refuse(HEAD "#99999999999=IFCWALL($);ENDSEC;", "allowed: # and a number up to 2147483647");
    ifc_refuse(HEAD "#1=IFCWALL;ENDSEC;", "lacks the name of a type and ( behind its =");
    ifc_refuse(HEAD "WALL\nENDSEC;", "t.ifc:6: found `WALL` (allowed: # for an entity, or ENDSEC)");
    ifc_refuse(HEAD "#1=IFCWALL('a',%,'b');\nENDSEC;\n", "t.ifc:6: an argument is `%,'b');`");
    ifc_refuse(HEAD "/* never\nENDSEC;\n", "the file ends before its data does");
}

// A list in a list, a million times: in an argument that is read, in one that is passed over, and without an end.
// A list of points that many items read anew costs as much as one as long, and is no way to make a small file take minutes.
Test(ifc, shared_points) {
    enum { POINTS = 100000, ITEMS = 400 };
    Arena arena = {0};
    Text text = {.arena = &arena};
    text_append(&text, "#100=IFCSHELLBASEDSURFACEMODEL(());#101=IFCCARTESIANPOINTLIST3D((");
    for (int i = 0; i < POINTS; i++) text_append(&text, "%s(%d.,%d.,1.)", i ? "," : "", i % 7, i % 5);
    text_append(&text, "));\n");
    for (int i = 0, e = 1000; i < ITEMS; i++, e += 4)
        text_append(&text,
                    "#%d=IFCWALL('w',$,'W',$,$,#20,#%d,$,$);#%d=IFCPRODUCTDEFINITIONSHAPE($,$,(#%d));"
                    "#%d=IFCSHAPEREPRESENTATION($,'Body','Tessellation',(#%d));"
                    "#%d=IFCTRIANGULATEDFACESET(#101,$,.F.,((1,2,9)),$);\n",
                    e, e + 1, e + 1, e + 2, e + 2, e + 3, e + 3);
    ifc_refuse(ifc_text(&arena, text.data), "polygons (the limit for");
    arena_free(&arena);
}

// The first of several entities of one number counts, also where threads read them at once: a comment keeps them in parts of their own.
Test(ifc, one_number_twice) {
    enum { APART = 9 << 20 };
    Arena arena = {0};
    char *comment = arena_alloc(&arena, APART + 1, 1);
    memset(comment, ' ', APART);
    const char *text = ifc_text(
        &arena, arena_format(&arena,
                             "#100=IFCBLOCK(#11,1.,1.,1.);\n/*%s*/\n#300=IFCWALL('a',$,'a',$,$,#20,$,$,$);\n"
                             "#100=IFCBLOCK(#11,2.,2.,2.);\n#301=IFCWALL('b',$,'b',$,$,#20,$,$,$);\n",
                             comment));
    for (int threads = 1; threads <= 2; threads++) {
        IfcModel m;
        ifc_accept(&arena, text, threads, &m);
        cr_assert_eq(m.product_count, 3);
        cr_expect_float_eq(ifc_volume(&m.products[0].mesh), 1, 1e-12, "%d threads", threads);
    }
    arena_free(&arena);
}

Test(ifc, nested_lists) {
    enum { DEEP = 1000000 };
    Arena arena = {0};
    char *open = arena_alloc(&arena, DEEP + 1, 1), *close = arena_alloc(&arena, DEEP + 1, 1);
    memset(open, '(', DEEP);
    memset(close, ')', DEEP);
    IfcModel m;
    ifc_accept(&arena, ifc_text(&arena, arena_format(&arena, "#100=IFCPOLYLINE(%s%s);", open, close)), 1, &m);
    ifc_accept(&arena,
               ifc_text(&arena, arena_format(&arena, "#100=IFCEXTRUDEDAREASOLID(%s%s,$,$,1.);", open, close)),
               1, &m);
    ifc_refuse(ifc_text(&arena, arena_format(&arena, "#100=IFCEXTRUDEDAREASOLID(%s;", open)),
               "an argument is `((((");
    arena_free(&arena);
}

// References in a circle end with a note: placements, items, maps, curves, booleans, parts.
Test(ifc, circles) {
    static const char *const CASES[] = {
        "#100=IFCBOOLEANRESULT(.UNION.,#100,#100);",
        "#100=IFCBOOLEANRESULT(.UNION.,#101,#100);#101=IFCBLOCK(#11,1.,1.,1.);",
        "#100=IFCCSGSOLID(#100);",
        "#100=IFCMAPPEDITEM(#101,$);#101=IFCREPRESENTATIONMAP(#11,#102);#102=IFCSHAPEREPRESENTATION($,'Body',"
        "'CSG',(#100,#100));",
        "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,1.);#101=IFCDERIVEDPROFILEDEF(.AREA.,$,#101,$,$);",
        "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,1.);#101=IFCCOMPOSITEPROFILEDEF(.AREA.,$,(#101,#101),$);",
        "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,1.);#101=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#102);"
        "#102=IFCCOMPOSITECURVE((#103,#103),.F.);#103=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#102);",
        "#100=IFCBLOCK(#11,1.,1.,1.);#30=IFCSLAB('s',$,$,$,$,#31,$,$,$);#31=IFCLOCALPLACEMENT(#32,#11);#32="
        "IFCLOCALPLACEMENT(#31,#11);"
        "#33=IFCRELAGGREGATES('r',$,$,$,#30,(#90));#34=IFCRELAGGREGATES('r',$,$,$,#90,(#30));",
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        IfcModel m;
        ifc_accept(&arena, ifc_text(&arena, CASES[i]), 1, &m);
        cr_expect(m.note_count > 0, "%s", CASES[i]);
        arena_free(&arena);
    }
}

// A body so far away that its digits hold no tolerance is cut by nothing: found by a fuzzer, it took 16 GB.
Test(ifc, booleans_far_away) {
    Arena arena = {0};
    IfcModel m;
    ifc_accept(
        &arena,
        ifc_text(&arena,
                 "#100=IFCBOOLEANRESULT(.INTERSECTION.,#101,#102);#101=IFCBOOLEANRESULT(.UNION.,#103,#104);"
                 "#102=IFCSPHERE(#11,250.);#103=IFCBOOLEANRESULT(.DIFFERENCE.,#105,#104);"
                 "#104=IFCRIGHTCIRCULARCONE(#11,400.,100.);#105=IFCBLOCK(#11,1.,400.,1.E20);"),
        1, &m);
    bool told = false;
    for (int n = 0; n < m.note_count; n++)
        told |= strstr(m.notes[n].text, "takes too long, or lies too far away") != NULL;
    cr_expect(told);
    arena_free(&arena);
}

// Placements that were read for another product are remembered, but how many stand within each other is counted from the world.
Test(ifc, placements_within_placements) {
    enum { DEEP = 30, DEEPER = 45 };  // the limit of 40 lies between
    Arena arena = {0};
    char *text = arena_alloc(&arena, 16384, 1);
    int used = snprintf(text, 16384,
                        "#100=IFCBLOCK(#11,1.,1.,1.);#200=IFCLOCALPLACEMENT($,#101);"
                        "#101=IFCAXIS2PLACEMENT3D(#102,$,$);#102=IFCCARTESIANPOINT((0.,0.,1.));");
    for (int i = 1; i < DEEPER; i++)
        used +=
            snprintf(text + used, 16384 - (size_t)used, "#%d=IFCLOCALPLACEMENT(#%d,#101);", 200 + i, 199 + i);
    snprintf(text + used, 16384 - (size_t)used,
             "#301=IFCSLAB('a',$,'deep',$,$,#%d,$,$,$);#302=IFCSLAB('b',$,'deeper',$,$,#%d,$,$,$);",
             199 + DEEP, 199 + DEEPER);
    IfcModel m;
    ifc_accept(&arena, ifc_text(&arena, text), 1, &m);
    cr_assert_eq(m.product_count, 3);
    for (int i = 0; i < m.product_count; i++)
        if (strcmp(m.products[i].name, "deep") == 0) cr_expect_eq(m.products[i].place.z, DEEP);
    cr_assert_eq(m.note_count, 1);
    cr_expect_neq(
        strstr(m.notes[0].text, "\"deeper\": #244 IFCLOCALPLACEMENT is placed relative to more than 40"),
        NULL, "%s", m.notes[0].text);
    arena_free(&arena);
}

// Maps of maps of maps: 30 levels of two would be a thousand million boxes; the bound says no before.
Test(ifc, maps_of_maps) {
    Arena arena = {0};
    char *text = arena_alloc(&arena, 16384, 1);
    int used = snprintf(text, 16384, "#100=IFCMAPPEDITEM(#200,$);#199=IFCBLOCK(#11,1.,1.,1.);");
    for (int i = 0; i < 30; i++) {
        int to = 203 + 3 * i;
        used += snprintf(text + used, 16384 - (size_t)used,
                         "#%d=IFCREPRESENTATIONMAP(#11,#%d);#%d=IFCSHAPEREPRESENTATION($,'Body','CSG',(#%d,#%"
                         "d));#%d=IFCMAPPEDITEM(#%d,$);",
                         to - 3, to - 2, to - 2, i == 29 ? 199 : to - 1, i == 29 ? 199 : to - 1, to - 1, to);
    }
    ifc_refuse(ifc_text(&arena, text), "polygons (the limit for");
    arena_free(&arena);
}

// Whatever is cut off or changed in a file that holds one of each kind of body, it is read or refused with a sentence.
Test(ifc, damaged_files) {
    static const unsigned char PUT[] = {0, ' ', '\'', '(', ')', ',', '#', '$', '9', '-', ';', 0xFF};
    Arena arena = {0}, scratch = {0};
    Bytes whole = support_read(&arena, "tests/seeds/small.ifc");
    unsigned char *bytes = arena_alloc(&arena, whole.size + 1, 1);
    IfcOptions options = {.threads = 1};
    int refused = 0, step = support_count(5, 1);
    for (size_t at = 0; at < whole.size; at++) {
        for (int k = -1; k < (int)sizeof PUT; k += k < 0 ? 1 + (int)at % step : step) {
            Error error = {""};
            IfcModel m;
            Bytes content = {bytes, k < 0 ? at : whole.size};
            memcpy(bytes, whole.data, content.size);
            bytes[content.size] = 0;
            if (k >= 0) bytes[at] = PUT[k];
            if (!ifc_read("t.ifc", content, &options, &scratch, &m, &error)) {
                refused++;
                cr_assert(error.text[0], "no sentence at byte %zu", at);
            }
            arena_reset(&scratch);
        }
    }
    cr_expect_gt(refused, (int)whole.size);
    arena_free(&scratch);
    arena_free(&arena);
}
