// test_ifc_bodies.c - the volume and area of each kind of body against closed forms.
//
// Circles have 256 chords: their area is less than the circle's by 1e-4 of it, a sphere's volume by 2.5e-4.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/maps/ifc/ifc_fixture.h"

#define ROUND 3e-4
#define EXTRUDE(profile) "#100=IFCEXTRUDEDAREASOLID(#101,#11,#12,2.);#101=" profile

typedef struct Case {
    const char *data;
    double volume, area;
} Case;

static void check(const Case *c) {
    Arena arena = {0};
    IfcMesh mesh = ifc_mesh(&arena, c->data);
    cr_expect_float_eq(ifc_volume(&mesh) / c->volume, 1, ROUND, "volume %.9g, expected %.9g: %s",
                       ifc_volume(&mesh), c->volume, c->data);
    if (c->area > 0)
        cr_expect_float_eq(ifc_area(&mesh) / c->area, 1, ROUND, "area %.9g, expected %.9g: %s",
                           ifc_area(&mesh), c->area, c->data);
    // Booleans take corners within SHAPE_EPSILON of a plane as on it; of small faces that shows in the sum of normals.
    cr_expect_lt(ifc_gap(&mesh), 1e-5, "not closed: %s", c->data);
    for (int i = 0; i < mesh.polygon_count; i++) {
        const Vec3 *corners = mesh.corners + mesh.polygons[i].first_corner;
        int count = mesh.polygons[i].corner_count;
        Plane plane = plane_of_polygon(corners, count);
        cr_expect(polygon_is_convex(corners, count, plane.n), "polygon %d is not convex: %s", i, c->data);
        cr_expect_lt(polygon_bend(corners, count, plane), 1e-5, "polygon %d is bent: %s", i, c->data);
    }
    arena_free(&arena);
}

static void check_all(const Case *cases, int count) {
    for (int i = 0; i < count; i++) check(&cases[i]);
}

// The corner that a fillet of radius 1 fills.
#define FILLET (1 - M_PI / 4)

// Profiles of steel are polygons whose corners are rounded: fillets add (1 - pi/4) r^2 each, edges take as much.
Test(ifc, profiles) {
    const double p = M_PI;
    const Case cases[] = {
        {EXTRUDE("IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,3.,4.);"), 24, 52},
        {EXTRUDE("IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,#14,3.,4.,0.5);"), 2 * (12 - 4 * FILLET * 0.25), 0},
        {EXTRUDE("IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,#14,3.,4.,0.25,0.1,0.2);"),
         2 * (12 - 4 * FILLET * 0.04 - (2.5 * 3.5 - 4 * FILLET * 0.01)), 0},
        {EXTRUDE("IFCCIRCLEPROFILEDEF(.AREA.,$,#14,0.5);"), p / 2, 2 * p * 0.25 + 2 * p},
        {EXTRUDE("IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,#14,0.5,0.1);"), 2 * p * (0.25 - 0.16),
         2 * p * 0.09 + 2 * 2 * p * 0.9},
        {EXTRUDE("IFCELLIPSEPROFILEDEF(.AREA.,$,#14,2.,0.5);"), 2 * p, 0},
        {EXTRUDE("IFCISHAPEPROFILEDEF(.AREA.,$,#14,2.,3.,0.2,0.3,0.1,$,$);"),
         2 * (2 * 2 * 0.3 + 2.4 * 0.2 + 4 * FILLET * 0.01), 0},
        {EXTRUDE("IFCASYMMETRICISHAPEPROFILEDEF(.AREA.,$,#14,2.,3.,0.2,0.3,$,1.,0.4,$,$,$,$,$);"),
         2 * (2 * 0.3 + 0.4 + 2.3 * 0.2), 0},
        {EXTRUDE("IFCLSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.2,0.1,0.05,$);"),
         2 * (0.2 * 3 + 0.2 * 1.8 + FILLET * (0.01 - 2 * 0.0025)), 0},
        {EXTRUDE("IFCTSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.2,0.3,0.1,$,$,$,$);"),
         2 * (2 * 0.3 + 2.7 * 0.2 + 2 * FILLET * 0.01), 0},
        {EXTRUDE("IFCUSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.2,0.3,0.1,$,$);"),
         2 * (2 * 2 * 0.3 + 2.4 * 0.2 + 2 * FILLET * 0.01), 0},
        {EXTRUDE("IFCCSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.1,0.5,$);"),
         2 * (0.1 * 3 + 2 * 0.1 * 1.9 + 2 * 0.1 * 0.4), 0},
        {EXTRUDE("IFCZSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.2,0.3,$,$);"), 2 * (0.2 * 3 + 2 * 1.8 * 0.3), 0},
        {EXTRUDE("IFCTRAPEZIUMPROFILEDEF(.AREA.,$,#14,3.,2.,1.5,0.25);"), 2 * 1.5 * 2.5, 0},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

// Sections of rolled steel, 2 m of each, with the areas of the tables (EN 10365 and EN 10056-1, cm^2, from which the unrounded sums of
// rectangles and fillets differ by less than their last digit): other readers make chamfers of fillets, or leave out an angle's.
Test(ifc, steel_sections) {
    const Case cases[] = {
        {EXTRUDE("IFCISHAPEPROFILEDEF(.AREA.,'IPE 240',#14,.12,.24,.0062,.0098,.015,$,$);"), 2 * 39.116e-4,
         0},
        {EXTRUDE("IFCISHAPEPROFILEDEF(.AREA.,'IPE 300',#14,.15,.3,.0071,.0107,.015,$,$);"), 2 * 53.812e-4, 0},
        {EXTRUDE("IFCISHAPEPROFILEDEF(.AREA.,'HEA 180',#14,.18,.171,.006,.0095,.015,$,$);"), 2 * 45.251e-4,
         0},
        {EXTRUDE("IFCLSHAPEPROFILEDEF(.AREA.,'L 100x10',#14,.1,.1,.01,.012,.006,$);"), 2 * 19.155e-4, 0},
        {EXTRUDE("IFCLSHAPEPROFILEDEF(.AREA.,'L 120x12',#14,.12,.12,.012,.013,.0065,$);"), 2 * 27.541e-4, 0},
        {EXTRUDE("IFCLSHAPEPROFILEDEF(.AREA.,'L 200x100x10',#14,.2,.1,.01,.015,.0075,$);"), 2 * 29.241e-4, 0},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

#define SQUARE                                                                                               \
    "#110=IFCCARTESIANPOINT((0.,0.));#111=IFCCARTESIANPOINT((4.,0.));#112=IFCCARTESIANPOINT((4.,4.));#113="  \
    "IFCCARTESIANPOINT((0.,4.));"                                                                            \
    "#114=IFCPOLYLINE((#110,#111,#112,#113,#110));"
#define CURVE(curve) EXTRUDE("IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#102);#102=") curve

// Outlines of lines and arcs, in either direction, with holes, mirrored.
Test(ifc, outlines) {
    const double p = M_PI;
    const Case cases[] = {
        {EXTRUDE("IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#114);" SQUARE), 32, 64},
        {EXTRUDE("IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,$,#114,(#115,#117));" SQUARE
                 "#115=IFCCIRCLE(#116,0.5);#116=IFCAXIS2PLACEMENT2D(#118,$);#117=IFCCIRCLE(#119,0.5);#119="
                 "IFCAXIS2PLACEMENT2D(#120,$);"
                 "#118=IFCCARTESIANPOINT((1.,1.));#120=IFCCARTESIANPOINT((3.,1.));"),
         32 - p, 64 - p + 4 * p},
        // A half circle of radius 1 by degrees of the sense that is told, and the chord back.
        {CURVE("IFCCOMPOSITECURVE((#103,#104),.F.);#103=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#105);"
               "#104=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.F.,#106);#105=IFCTRIMMEDCURVE(#107,("
               "IFCPARAMETERVALUE(0.)),"
               "(IFCPARAMETERVALUE(3.14159265358979)),.T.,.PARAMETER.);#107=IFCCIRCLE(#14,1.);#106="
               "IFCPOLYLINE((#108,#109));"
               "#108=IFCCARTESIANPOINT((1.,0.));#109=IFCCARTESIANPOINT((-1.,0.));"),
         p, p + 2 * p + 4},
        // Two half circles by degrees, though the unit is the radian: points that contradict the parameters hold.
        {CURVE("IFCCOMPOSITECURVE((#103,#104),.U.);#103=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#105);"
               "#104=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#106);#105=IFCTRIMMEDCURVE(#107,("
               "IFCPARAMETERVALUE(0.),#108),(IFCPARAMETERVALUE(180.),#109),.T.,.PARAMETER.);"
               "#106=IFCTRIMMEDCURVE(#107,(IFCPARAMETERVALUE(180.),#109),(IFCPARAMETERVALUE(360.),#108),.T.,"
               ".PARAMETER.);#107=IFCCIRCLE(#14,1.);"
               "#108=IFCCARTESIANPOINT((1.,0.));#109=IFCCARTESIANPOINT((-1.,0.));"),
         2 * p, 2 * p + 4 * p},
        // The same the long way round: three quarters, trimmed by points against the sense.
        {CURVE("IFCCOMPOSITECURVE((#103,#104),.F.);#103=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#105);"
               "#104=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#106);#105=IFCTRIMMEDCURVE(#107,(#109),(#108),"
               ".F.,.CARTESIAN.);"
               "#107=IFCCIRCLE(#14,1.);#106=IFCPOLYLINE((#108,#110,#109));#108=IFCCARTESIANPOINT((0.,1.));"
               "#109=IFCCARTESIANPOINT((1.,0.));#110=IFCCARTESIANPOINT((0.,0.));"),
         2 * 0.75 * p, 1.5 * p + 2 * (1.5 * p + 2)},
        {CURVE("IFCINDEXEDPOLYCURVE(#103,(IFCLINEINDEX((1,2)),IFCARCINDEX((2,3,4)),IFCLINEINDEX((4,1))),.F.);"
               "#103=IFCCARTESIANPOINTLIST2D(((0.,0.),(1.,0.),(0.707106781186548,0.707106781186548),(0.,1.)))"
               ";"),
         p / 2, p / 2 + p + 4},
        {EXTRUDE("IFCDERIVEDPROFILEDEF(.AREA.,$,#102,#103,$);#102=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,1.,1.);"
                 "#103=IFCCARTESIANTRANSFORMATIONOPERATOR2DNONUNIFORM($,$,#10,2.,3.);"),
         12, 12 + 20},
        {EXTRUDE("IFCMIRROREDPROFILEDEF(.AREA.,$,#102,*,$);#102=IFCLSHAPEPROFILEDEF(.AREA.,$,#14,3.,2.,0.2,$,"
                 "$,$);"),
         2 * (0.6 + 0.36), 0},
        {EXTRUDE("IFCCENTERLINEPROFILEDEF(.AREA.,$,#102,0.2);#102=IFCPOLYLINE((#103,#104,#105));#103="
                 "IFCCARTESIANPOINT((0.,0.));"
                 "#104=IFCCARTESIANPOINT((2.,0.));#105=IFCCARTESIANPOINT((2.,2.));"),
         1.6, 0},
        // A spline of degree 1 is its polygon; the rational one of degree 2 with these weights is a quarter circle.
        {CURVE("IFCCOMPOSITECURVE((#103,#104),.F.);#103=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#105);"
               "#104=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#106);#105=IFCBSPLINECURVEWITHKNOTS(1,(#108,#"
               "110,#109),.UNSPECIFIED.,.F.,.F.,"
               "(2,1,2),(0.,1.,2.),.UNSPECIFIED.);#106=IFCPOLYLINE((#109,#108));#108=IFCCARTESIANPOINT((0.,2."
               "));"
               "#109=IFCCARTESIANPOINT((2.,0.));#110=IFCCARTESIANPOINT((0.,0.));"),
         4, 0},
        // Outlines that run along themselves: two areas, an area with a hole, and a last edge that is told twice.
        {CURVE(
             "IFCINDEXEDPOLYCURVE(#103,$,.F.);#103=IFCCARTESIANPOINTLIST2D(((0.,1.),(2.,1.),(2.,0.),(0.,0.),"
             "(0.,3.),(2.,3.),(2.,2.),(0.,2.),(0.,3.)));"),
         8, 32},
        {CURVE(
             "IFCINDEXEDPOLYCURVE(#103,$,.F.);#103=IFCCARTESIANPOINTLIST2D(((0.,0.),(4.,0.),(4.,4.),(0.,4.),"
             "(0.,0.),(1.,1.),(1.,3.),(3.,3.),(3.,1.),(1.,1.)));"),
         24, 72},
        {CURVE(
             "IFCINDEXEDPOLYCURVE(#103,$,.F.);#103=IFCCARTESIANPOINTLIST2D(((0.,4.),(0.,0.),(4.,0.),(4.,4.),"
             "(0.,4.),(0.,0.)));"),
         32, 64},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

// Sweeps: sheared, along a curve, about an axis; primitives.
Test(ifc, sweeps) {
    const double p = M_PI;
    const Case cases[] = {
        {"#100=IFCEXTRUDEDAREASOLID(#101,#11,#102,2.);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,3.,4.);#102="
         "IFCDIRECTION((0.,0.6,-0.8));",
         12 * 1.6, 24 + 2 * 2 * 4 + 2 * 3 * 2 - 16 + 2 * 1.6 * 4},
        {"#100=IFCEXTRUDEDAREASOLIDTAPERED(#101,#11,#12,3.,#102);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,2.,"
         "2.);"
         "#102=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,1.,1.);",
         7, 0},
        // A square of side 1 whose middle is 2 from the axis: 2 pi 2 by Pappus, a quarter of it, and all.
        {"#100=IFCREVOLVEDAREASOLID(#101,#11,#102,1.5707963267949);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,"
         "1.,1.);"
         "#102=IFCAXIS1PLACEMENT(#103,#104);#103=IFCCARTESIANPOINT((-2.,0.,0.));#104=IFCDIRECTION((0.,1.,0.))"
         ";",
         p, 2 + 4 * p},
        {"#100=IFCREVOLVEDAREASOLID(#101,#11,#102,6.28318530717959);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#14,"
         "1.,1.);"
         "#102=IFCAXIS1PLACEMENT(#103,#104);#103=IFCCARTESIANPOINT((2.,0.,0.));#104=IFCDIRECTION((0.,1.,0.))"
         ";",
         4 * p, 16 * p},
        // An elbow with a mitre: both legs to the middle of the corner.
        {"#100=IFCSWEPTDISKSOLID(#101,0.1,0.05,$,$);#101=IFCPOLYLINE((#10,#102,#103));#102=IFCCARTESIANPOINT("
         "(1.,0.,0.));"
         "#103=IFCCARTESIANPOINT((1.,0.,1.));",
         2 * p * (0.01 - 0.0025), 0},
        // Parts of curves: a quarter of a circle, and the second of two edges; from 0 to 1 is the whole.
        {"#100=IFCSWEPTDISKSOLID(#101,0.1,$,0.,1.5707963267949);#101=IFCCIRCLE(#11,2.);", p * 0.01 * p, 0},
        // An elbow, whose profile lies outside its arc: its ends lie square to the arc, not to the first and last chords.
        {"#100=IFCFIXEDREFERENCESWEPTAREASOLID(#101,#11,#102,$,$,#12);#101=IFCCIRCLEPROFILEDEF(.AREA.,$,#108,"
         "0.4);"
         "#102=IFCTRIMMEDCURVE(#103,(IFCPARAMETERVALUE(0.)),(IFCPARAMETERVALUE(1.5707963267949)),.T.,."
         "PARAMETER.);"
         "#103=IFCCIRCLE(#11,1.);#108=IFCAXIS2PLACEMENT2D(#109,$);#109=IFCCARTESIANPOINT((0.,0.5));",
         p * 0.16 * p / 2 * 1.5, 0},
        {"#100=IFCFIXEDREFERENCESWEPTAREASOLID(#101,#11,#102,1.,2.,#12);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,"
         "#14,0.2,0.4);#102=IFCPOLYLINE((#10,#103,#104));#103=IFCCARTESIANPOINT((3.,0.,0.));#104="
         "IFCCARTESIANPOINT((3.,3.,0.));",
         3 * 0.08, 3 * 1.2 + 2 * 0.08},
        {"#100=IFCFIXEDREFERENCESWEPTAREASOLID(#101,#11,#102,0.,1.,#12);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,"
         "#14,0.2,0.4);#102=IFCPOLYLINE((#10,#103,#104));#103=IFCCARTESIANPOINT((3.,0.,0.));#104="
         "IFCCARTESIANPOINT((3.,3.,0.));",
         6 * 0.08, 6 * 1.2 + 2 * 0.08},
        {"#100=IFCFIXEDREFERENCESWEPTAREASOLID(#101,#11,#102,$,$,#12);#101=IFCRECTANGLEPROFILEDEF(.AREA.,$,#"
         "14,0.2,0.4);"
         "#102=IFCPOLYLINE((#10,#103,#104,#105,#10));#103=IFCCARTESIANPOINT((3.,0.,0.));#104="
         "IFCCARTESIANPOINT((3.,3.,0.));"
         "#105=IFCCARTESIANPOINT((0.,3.,0.));",
         12 * 0.08, 12 * 1.2},
        {"#100=IFCBLOCK(#11,1.,2.,3.);", 6, 22},
        {"#100=IFCRECTANGULARPYRAMID(#11,3.,2.,4.);", 8, 0},
        {"#100=IFCRIGHTCIRCULARCONE(#11,3.,2.);", 4 * p, 4 * p + 2 * p * sqrt(13)},
        {"#100=IFCCSGSOLID(#101);#101=IFCRIGHTCIRCULARCYLINDER(#11,3.,2.);", 12 * p, 8 * p + 12 * p},
        {"#100=IFCSPHERE(#11,2.);", 32 * p / 3, 16 * p},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

#define CUBE "#110=IFCBLOCK(#11,2.,2.,2.);"
#define PLACED(n, kind, x, y, z, size)                                                                       \
    "#" n "0=" kind "(#" n "1," size ");#" n "1=IFCAXIS2PLACEMENT3D(#" n "2,$,$);#" n                        \
    "2=IFCCARTESIANPOINT((" x "," y "," z "));"
#define BOOLEAN(operation) "#100=IFCBOOLEANRESULT(." operation ".,#110,#120);" CUBE

// Booleans: bodies that overlap, touch, share faces, lie within each other; half spaces, bounded and not; chains of them.
Test(ifc, booleans) {
    const double p = M_PI;
    const Case cases[] = {
        {BOOLEAN("UNION") PLACED("12", "IFCBLOCK", "1.", "1.", "1.", "2.,2.,2."), 15, 42},
        {BOOLEAN("DIFFERENCE") PLACED("12", "IFCBLOCK", "1.", "1.", "1.", "2.,2.,2."), 7, 24},
        {BOOLEAN("INTERSECTION") PLACED("12", "IFCBLOCK", "1.", "1.", "1.", "2.,2.,2."), 1, 6},
        {BOOLEAN("UNION") PLACED("12", "IFCBLOCK", "2.", "0.", "0.", "2.,2.,2."), 16, 40},
        {BOOLEAN("DIFFERENCE") PLACED("12", "IFCBLOCK", "2.", "0.", "0.", "2.,2.,2."), 8, 24},
        {BOOLEAN("DIFFERENCE") PLACED("12", "IFCBLOCK", "0.5", "0.", "0.", "1.,2.,1."), 6, 26},
        {BOOLEAN("UNION") PLACED("12", "IFCBLOCK", "0.5", "0.5", "0.5", "1.,1.,1."), 8, 24},
        {BOOLEAN("DIFFERENCE") PLACED("12", "IFCBLOCK", "0.5", "0.5", "0.5", "1.,1.,1."), 7, 30},
        {BOOLEAN("INTERSECTION") PLACED("12", "IFCBLOCK", "0.", "0.", "0.", "2.,2.,2."), 8, 24},
        {BOOLEAN("DIFFERENCE") PLACED("12", "IFCRIGHTCIRCULARCYLINDER", "1.", "1.", "-1.", "4.,0.5"),
         8 - p / 2, 24 - p / 2 + 2 * p},
        {BOOLEAN("INTERSECTION") PLACED("12", "IFCSPHERE", "0.", "0.", "0.", "1."), p / 6, 0},
        // A sloped half space takes a wedge; the bounded one only within its square.
        {"#100=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#110,#120);" CUBE
         "#120=IFCHALFSPACESOLID(#121,.F.);#121=IFCPLANE(#122);#122=IFCAXIS2PLACEMENT3D(#123,#124,$);"
         "#123=IFCCARTESIANPOINT((0.,0.,1.));#124=IFCDIRECTION((-1.,0.,2.));",
         6, 4 + 2 * 2 + 2 * 1 + 2 * 3 + 2 * sqrt(5)},
        {"#100=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#110,#120);" CUBE
         "#120=IFCPOLYGONALBOUNDEDHALFSPACE(#121,.F.,#122,#125);#121=IFCPLANE(#122);#122=IFCAXIS2PLACEMENT3D("
         "#123,$,$);"
         "#123=IFCCARTESIANPOINT((0.,0.,1.));#125=IFCPOLYLINE((#126,#127,#128,#129,#126));#126="
         "IFCCARTESIANPOINT((-1.,-1.));"
         "#127=IFCCARTESIANPOINT((-1.,1.));#128=IFCCARTESIANPOINT((1.,1.));#129=IFCCARTESIANPOINT((1.,-1.));",
         7, 24},
        // A chain: two half spaces, then a union.
        {"#100=IFCBOOLEANRESULT(.UNION.,#101,#130);#101=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#102,#120);"
         "#102=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#110,#125);" CUBE
         "#120=IFCHALFSPACESOLID(#121,.F.);#121=IFCPLANE(#122);#122=IFCAXIS2PLACEMENT3D(#123,$,$);#123="
         "IFCCARTESIANPOINT((0.,0.,1.));"
         "#125=IFCHALFSPACESOLID(#126,.T.);#126=IFCPLANE(#127);#127=IFCAXIS2PLACEMENT3D(#128,#13,$);#128="
         "IFCCARTESIANPOINT((1.,0.,0.));" PLACED("13", "IFCBLOCK", "0.", "0.", "0.", "1.,2.,2."),
         6, 4 + 2 * (2 + 1) + 2 * (4 - 1) + 4 + 2},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

// Faces: breps with a hole through, with a void, turned inside out; sets of triangles and of polygons; mapped and mirrored.
Test(ifc, faces) {
    static const char *const TETRAHEDRON =
        "#103=IFCCARTESIANPOINT((1.,0.,0.));#104=IFCCARTESIANPOINT((0.,1.,0.));#105=IFCCARTESIANPOINT((0.,0.,"
        "1.));"
        "#106=IFCFACE((#116));#107=IFCFACE((#117));#108=IFCFACE((#118));#109=IFCFACE((#119));"
        "#116=IFCFACEOUTERBOUND(#126,.T.);#117=IFCFACEOUTERBOUND(#127,.T.);#118=IFCFACEOUTERBOUND(#128,.T.);"
        "#126=IFCPOLYLOOP((#10,#104,#103));#127=IFCPOLYLOOP((#10,#103,#105));#128=IFCPOLYLOOP((#103,#104,#"
        "105));"
        "#129=IFCPOLYLOOP((#104,#10,#105));#102=IFCCLOSEDSHELL((#106,#107,#108,#109));";
    Arena arena = {0};
    double third = (3 + sqrt(3)) / 2;
    const Case cases[] = {
        {arena_format(&arena, "#100=IFCFACETEDBREP(#102);#119=IFCFACEOUTERBOUND(#129,.T.);%s", TETRAHEDRON),
         1.0 / 6, third},
        {arena_format(&arena,
                      "#100=IFCFACEBASEDSURFACEMODEL((#102));#119=IFCFACEOUTERBOUND(#130,.F.);#130="
                      "IFCPOLYLOOP((#10,#104,#105));%s",
                      TETRAHEDRON),
         1.0 / 6, third},
        {"#100=IFCTRIANGULATEDFACESET(#101,$,.T.,((1,2,3),(1,4,2),(2,4,3),(3,4,1)),$);"  // inside out
         "#101=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.),(0.,1.,0.),(0.,0.,1.)));",
         1.0 / 6, third},
        {"#100=IFCTRIANGULATEDFACESET(#101,$,$,((1,2,3),(1,2,4),(2,4,3),(3,4,1)),$);"  // one side contradicts
         "#101=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.),(0.,1.,0.),(0.,0.,1.)));",
         1.0 / 6, third},
        {"#100=IFCTRIANGULATEDFACESET(#101,$,.T.,((2,4,3),(2,3,5),(3,4,5),(4,2,5)),(1,1,2,3,4));"
         "#101=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.),(0.,1.,0.),(0.,0.,1.)));",
         1.0 / 6, third},
        // A slab of 3 x 3 x 1 with a hole of 1 x 1.
        {"#100=IFCPOLYGONALFACESET(#101,.T.,(#102,#103,#104,#105,#106,#107,#108,#109,#110,#111),$);"
         "#101=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(3.,0.,0.),(3.,3.,0.),(0.,3.,0.),(0.,0.,1.),(3.,0.,1.),(3."
         ",3.,1.),(0.,3.,1.),"
         "(1.,1.,0.),(2.,1.,0.),(2.,2.,0.),(1.,2.,0.),(1.,1.,1.),(2.,1.,1.),(2.,2.,1.),(1.,2.,1.)));"
         "#102=IFCINDEXEDPOLYGONALFACEWITHVOIDS((1,4,3,2),((9,10,11,12)));#103="
         "IFCINDEXEDPOLYGONALFACEWITHVOIDS((5,6,7,8),((13,14,15,16)));"
         "#104=IFCINDEXEDPOLYGONALFACE((1,2,6,5));#105=IFCINDEXEDPOLYGONALFACE((2,3,7,6));#106="
         "IFCINDEXEDPOLYGONALFACE((3,4,8,7));"
         "#107=IFCINDEXEDPOLYGONALFACE((4,1,5,8));#108=IFCINDEXEDPOLYGONALFACE((9,13,14,10));#109="
         "IFCINDEXEDPOLYGONALFACE((10,14,15,11));"
         "#110=IFCINDEXEDPOLYGONALFACE((11,15,16,12));#111=IFCINDEXEDPOLYGONALFACE((12,16,13,9));",
         8, 16 + 12 + 4},
        {"#100=IFCMAPPEDITEM(#101,#103);#101=IFCREPRESENTATIONMAP(#11,#102);#102=IFCSHAPEREPRESENTATION($,'"
         "Body','CSG',(#110));" CUBE "#103=IFCCARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM(#104,$,#10,2.,$,3.,"
         "0.5);#104=IFCDIRECTION((-1.,0.,0.));",
         24, 0},
        {"#100=IFCMAPPEDITEM(#101,#103);#101=IFCREPRESENTATIONMAP(#11,#102);#102=IFCSHAPEREPRESENTATION($,'"
         "Body','CSG',(#110));" CUBE
         "#103=IFCCARTESIANTRANSFORMATIONOPERATOR3D(#13,#105,#10,1.,#12);#105=IFCDIRECTION((0.,-1.,0.));",
         8, 24},
    };
    check_all(cases, sizeof cases / sizeof *cases);
    arena_free(&arena);
}

// The larger bound of a face is its outline, though the file tells the hole as such. A set of faces that is not told to be closed keeps
// its sides where it is open; a bent quad is two triangles that meet at its first corner.
Test(ifc, outlines_and_sides) {
    Arena arena = {0};
    IfcMesh mesh = ifc_mesh(
        &arena,
        "#100=IFCFACEBASEDSURFACEMODEL((#101));#101=IFCCONNECTEDFACESET((#102));#102=IFCFACE((#103,#104));"
        "#103=IFCFACEOUTERBOUND(#105,.T.);#104=IFCFACEBOUND(#106,.T.);"
        "#105=IFCPOLYLOOP((#111,#112,#113,#114));#106=IFCPOLYLOOP((#115,#116,#117,#118));"
        "#111=IFCCARTESIANPOINT((1.,1.,0.));#112=IFCCARTESIANPOINT((1.,2.,0.));"
        "#113=IFCCARTESIANPOINT((2.,2.,0.));#114=IFCCARTESIANPOINT((2.,1.,0.));"
        "#115=IFCCARTESIANPOINT((0.,0.,0.));#116=IFCCARTESIANPOINT((3.,0.,0.));"
        "#117=IFCCARTESIANPOINT((3.,3.,0.));#118=IFCCARTESIANPOINT((0.,3.,0.));");
    cr_expect_float_eq(ifc_area(&mesh), 8, 1e-9);
    for (int i = 0; i < mesh.polygon_count; i++)
        cr_expect_gt(
            plane_of_polygon(mesh.corners + mesh.polygons[i].first_corner, mesh.polygons[i].corner_count).n.z,
            0);
    // Seen from the first corner the volume is negative.
    mesh = ifc_mesh(&arena, "#100=IFCPOLYGONALFACESET(#101,$,(#102,#103),$);"
                            "#102=IFCINDEXEDPOLYGONALFACE((1,2,3,4));#103=IFCINDEXEDPOLYGONALFACE((5,6,7));"
                            "#101=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.),(1.,1.,-0.5),(0.,1.,0.),"
                            "(0.,0.,-2.),(1.,0.,-2.),(0.,1.,-2.)));");
    cr_assert_eq(mesh.polygon_count, 3);
    for (int i = 0; i < 3; i++) {
        const Vec3 *c = mesh.corners + mesh.polygons[i].first_corner;
        cr_expect_eq(mesh.polygons[i].corner_count, 3);
        cr_expect_gt(plane_of_polygon(c, 3).n.z, 0);
        cr_expect(vec3_equal(c[0], vec3(0, 0, i < 2 ? 0 : -2)));
    }
    arena_free(&arena);
}

#define CIRCLES                                                                                              \
    "#110=IFCVERTEXPOINT(#111);#111=IFCCARTESIANPOINT((1.,0.,0.));#112=IFCVERTEXPOINT(#113);#113="           \
    "IFCCARTESIANPOINT((1.,0.,3.));"                                                                         \
    "#114=IFCEDGECURVE(#110,#110,#115,.T.);#115=IFCCIRCLE(#11,1.);#116=IFCEDGECURVE(#112,#112,#117,.T.);#"   \
    "117=IFCCIRCLE(#118,1.);"                                                                                \
    "#118=IFCAXIS2PLACEMENT3D(#119,$,$);#119=IFCCARTESIANPOINT((0.,0.,3.));#120=IFCEDGECURVE(#110,#112,#"    \
    "121,.T.);"                                                                                              \
    "#121=IFCLINE(#111,#122);#122=IFCVECTOR(#12,1.);#123=IFCCYLINDRICALSURFACE(#11,1.);#124=IFCPLANE(#11);#" \
    "125=IFCPLANE(#118);"                                                                                    \
    "#130=IFCORIENTEDEDGE(*,*,#114,.T.);#131=IFCORIENTEDEDGE(*,*,#114,.F.);#132=IFCORIENTEDEDGE(*,*,#116,."  \
    "T.);"                                                                                                   \
    "#133=IFCORIENTEDEDGE(*,*,#116,.F.);#134=IFCORIENTEDEDGE(*,*,#120,.T.);#135=IFCORIENTEDEDGE(*,*,#120,."  \
    "F.);"                                                                                                   \
    "#140=IFCADVANCEDFACE((#143),#124,.F.);#143=IFCFACEOUTERBOUND(#144,.T.);#144=IFCEDGELOOP((#131));"       \
    "#150=IFCADVANCEDFACE((#153),#125,.T.);#153=IFCFACEOUTERBOUND(#154,.T.);#154=IFCEDGELOOP((#132));"       \
    "#100=IFCADVANCEDBREP(#101);#101=IFCCLOSEDSHELL((#140,#150,#160));"

// A cylinder as an advanced brep: its side with a seam, and as two loops without one.
Test(ifc, curved_faces) {
    const double p = M_PI;
    const Case cases[] = {
        {CIRCLES "#160=IFCADVANCEDFACE((#163),#123,.T.);#163=IFCFACEOUTERBOUND(#164,.T.);#164=IFCEDGELOOP((#"
                 "130,#134,#133,#135));",
         3 * p, 8 * p},
        {CIRCLES
         "#160=IFCADVANCEDFACE((#163,#165),#123,.T.);#163=IFCFACEBOUND(#164,.T.);#164=IFCEDGELOOP((#130));"
         "#165=IFCFACEBOUND(#166,.T.);#166=IFCEDGELOOP((#133));",
         3 * p, 8 * p},
    };
    check_all(cases, sizeof cases / sizeof *cases);
}

// The same wall with two openings that touch each other, one flush with its face, one that reaches beyond it.
Test(ifc, openings) {
    Arena arena = {0};
    IfcModel model;
    ifc_accept(
        &arena,
        ifc_text(&arena,
                 "#100=IFCBLOCK(#11,4.,0.2,3.);#30=IFCOPENINGELEMENT('a',$,$,$,$,#31,#32,$,$);"
                 "#31=IFCLOCALPLACEMENT(#20,#33);#33=IFCAXIS2PLACEMENT3D(#34,$,$);#34=IFCCARTESIANPOINT((1.,"
                 "0.,0.));"
                 "#32=IFCPRODUCTDEFINITIONSHAPE($,$,(#35));#35=IFCSHAPEREPRESENTATION($,'Body','CSG',(#36));"
                 "#36=IFCBLOCK(#11,1.,0.2,2.);#40=IFCRELVOIDSELEMENT('b',$,$,$,#90,#30);"
                 "#50=IFCOPENINGELEMENT('c',$,$,$,$,#51,#52,$,$);#51=IFCLOCALPLACEMENT(#20,#53);"
                 "#53=IFCAXIS2PLACEMENT3D(#54,$,$);#54=IFCCARTESIANPOINT((2.,-1.,1.));"
                 "#52=IFCPRODUCTDEFINITIONSHAPE($,$,(#55));#55=IFCSHAPEREPRESENTATION($,'Body','CSG',(#56));"
                 "#56=IFCBLOCK(#11,1.,3.,1.);#60=IFCRELVOIDSELEMENT('d',$,$,$,#90,#50);"),
        1, &model);
    cr_assert_eq(model.product_count, 3);
    const IfcProduct *wall = NULL;
    for (int i = 0; i < 3; i++)
        if (model.products[i].entity == 90) wall = &model.products[i];
    cr_assert(wall);
    cr_expect_float_eq(ifc_volume(&wall->whole_mesh), 2.4, 1e-9);
    cr_expect_float_eq(ifc_volume(&wall->mesh), 2.4 - 0.4 - 0.2, 1e-9);
    // Both sides lose 3 m^2; the threshold 0.2; the reveals are 2 + 1 + 1 high or long at the first, 1 + 1 + 1 at the second.
    cr_expect_float_eq(ifc_area(&wall->mesh),
                       2 * (12 - 3) + 0.2 * (4 - 1 + 4 + 6) + 0.2 * (2 + 1 + 1 + 1 + 1 + 1), 1e-9);
    cr_expect_lt(ifc_gap(&wall->mesh), 1e-12);
    for (int i = 0; i < 3; i++)
        if (model.products[i].kind == IFC_OPENING)
            cr_expect_eq(&model.products[model.products[i].host], wall);
    arena_free(&arena);
}
