// ifc_fixture.c - small building models as text around one body.
#include "tests/maps/ifc/ifc_fixture.h"

#include <criterion/criterion.h>
#include <string.h>

#include "engine/core/polygon.h"

const char *ifc_text(Arena *arena, const char *data) {
    return arena_format(
        arena,
        "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"
        "#1=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n#2=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);\n"
        "#3=IFCUNITASSIGNMENT((#1,#2));\n#4=IFCPROJECT('p',$,'P',$,$,$,$,$,#3);\n"
        "#10=IFCCARTESIANPOINT((0.,0.,0.));\n#11=IFCAXIS2PLACEMENT3D(#10,$,$);\n"
        "#12=IFCDIRECTION((0.,0.,1.));\n#13=IFCDIRECTION((1.,0.,0.));\n#14=IFCAXIS2PLACEMENT2D(#10,$);\n"
        "#20=IFCLOCALPLACEMENT($,#11);\n"
        "#90=IFCWALL('w',$,'W',$,$,#20,#91,$,$);\n#91=IFCPRODUCTDEFINITIONSHAPE($,$,(#92));\n"
        "#92=IFCSHAPEREPRESENTATION($,'Body','SweptSolid',(#100));\n%s\nENDSEC;\nEND-ISO-10303-21;\n",
        data);
}

static bool read_text(Arena *arena, const char *text, const IfcOptions *options, IfcModel *out,
                      Error *error) {
    Bytes content = {(unsigned char *)arena_string(arena, text), strlen(text)};
    *error = (Error){""};
    return ifc_read("t.ifc", content, options, arena, out, error);
}

void ifc_accept(Arena *arena, const char *text, int threads, IfcModel *out) {
    Error error;
    IfcOptions options = {.threads = threads, .circle_chords = 256};
    bool good = read_text(arena, text, &options, out, &error);
    cr_assert(good, "%s", error.text);
}

void ifc_refuse(const char *text, const char *expected) {
    Arena arena = {0};
    Error error;
    IfcModel model;
    IfcOptions options = {.threads = 1};
    cr_assert_not(read_text(&arena, text, &options, &model, &error), "expected: %s", expected);
    cr_expect(strstr(error.text, expected), "%s\nexpected: %s", error.text, expected);
    arena_free(&arena);
}

IfcMesh ifc_mesh(Arena *arena, const char *data) {
    IfcModel model;
    ifc_accept(arena, ifc_text(arena, data), 1, &model);
    for (int i = 0; i < model.note_count; i++) cr_expect(false, "%s", model.notes[i].text);
    cr_assert_geq(model.product_count, 1);
    return model.products[0].mesh;
}

double ifc_volume(const IfcMesh *mesh) {
    double six = 0;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const Vec3 *c = mesh->corners + mesh->polygons[i].first_corner;
        for (int k = 1; k + 1 < mesh->polygons[i].corner_count; k++)
            six += vec3_dot(c[0], vec3_cross(c[k], c[k + 1]));
    }
    return six / 6;
}

double ifc_area(const IfcMesh *mesh) {
    double sum = 0;
    for (int i = 0; i < mesh->polygon_count; i++)
        sum += polygon_area(mesh->corners + mesh->polygons[i].first_corner, mesh->polygons[i].corner_count);
    return sum;
}

double ifc_gap(const IfcMesh *mesh) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < mesh->polygon_count; i++) {
        const Vec3 *c = mesh->corners + mesh->polygons[i].first_corner;
        for (int k = 1; k + 1 < mesh->polygons[i].corner_count; k++)
            sum = vec3_add(sum, vec3_scale(vec3_cross(vec3_sub(c[k], c[0]), vec3_sub(c[k + 1], c[0])), 0.5));
    }
    return vec3_length(sum) / ifc_area(mesh);
}
