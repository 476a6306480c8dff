// test_ifc_splines.c - faces on B-spline surfaces against closed forms: parts of a cylinder and of a ball by rational ones, a cylinder
// that closes on itself, a ruled surface, and a face whose edges leave its surface.
#include <criterion/criterion.h>
#include <stdarg.h>
#include <string.h>

#include "tests/maps/ifc/ifc_fixture.h"

// A brep under construction: statements, and the faces of its shell.
typedef struct Brep {
    Arena *arena;
    const char *text, *faces;
    int next;  // the next statement's number
} Brep;

static int add(Brep *b, const char *format, ...) {
    va_list args;
    va_start(args, format);
    b->text =
        arena_format(b->arena, "%s#%d=%s;", b->text, b->next, arena_format_list(b->arena, format, args));
    va_end(args);
    return b->next++;
}

static int point(Brep *b, double x, double y, double z) {
    return add(b, "IFCCARTESIANPOINT((%.17g,%.17g,%.17g))", x, y, z);
}

// An edge from one point to another along a B-spline of degree 2 about a middle point of some weight; of weight 0 it is straight.
static int edge(Brep *b, int from, int middle, int to, double weight) {
    int start = add(b, "IFCVERTEXPOINT(#%d)", from), end = add(b, "IFCVERTEXPOINT(#%d)", to), curve;
    if (weight > 0)
        curve = add(b,
                    "IFCRATIONALBSPLINECURVEWITHKNOTS(2,(#%d,#%d,#%d),.UNSPECIFIED.,.F.,.F.,(3,3),(0.,1.),"
                    ".UNSPECIFIED.,(1.,%.17g,1.))",
                    from, middle, to, weight);
    else
        curve = add(b, "IFCPOLYLINE((#%d,#%d))", from, to);
    return add(b, "IFCEDGECURVE(#%d,#%d,#%d,.T.)", start, end, curve);
}

// A face on a surface within a loop of edges, those below 0 backwards; -1 ends them.
static void face(Brep *b, int surface, const int *edges, int count) {
    const char *list = "";
    for (int i = 0; i < count; i++) {
        bool turn = edges[i] < 0;
        int oriented = add(b, "IFCORIENTEDEDGE(*,*,#%d,.%s.)", abs(edges[i]), turn ? "F" : "T");
        list = arena_format(b->arena, "%s%s#%d", list, i ? "," : "", oriented);
    }
    int loop = add(b, "IFCEDGELOOP((%s))", list), bound = add(b, "IFCFACEOUTERBOUND(#%d,.T.)", loop);
    b->faces = arena_format(b->arena, "%s%s#%d", b->faces, *b->faces ? "," : "",
                            add(b, "IFCADVANCEDFACE((#%d),#%d,.T.)", bound, surface));
}

static int plane(Brep *b, double nx, double ny, double nz, int at) {
    int z = add(b, "IFCDIRECTION((%.17g,%.17g,%.17g))", nx, ny, nz);
    return add(b, "IFCPLANE(#%d)", add(b, "IFCAXIS2PLACEMENT3D(#%d,#%d,$)", at, z));
}

static Brep begin(Arena *arena) { return (Brep){.arena = arena, .text = "", .faces = "", .next = 102}; }

static IfcMesh finish(const Brep *b) {
    return ifc_mesh(
        b->arena,
        arena_format(b->arena, "#100=IFCADVANCEDBREP(#101);#101=IFCCLOSEDSHELL((%s));%s", b->faces, b->text));
}

static void expect(const IfcMesh *mesh, double volume, double area, double most) {
    cr_expect_float_eq(ifc_volume(mesh) / volume, 1, most, "volume %.9g, expected %.9g", ifc_volume(mesh),
                       volume);
    cr_expect_float_eq(ifc_area(mesh) / area, 1, most, "area %.9g, expected %.9g", ifc_area(mesh), area);
    cr_expect_lt(ifc_gap(mesh), 1e-9, "not closed by %g", ifc_gap(mesh));
}

// Quarter of a cylinder of radius 2 and height 3: its side is a rational surface of degrees 2 and 1. The parameters of such an arc are
// no angles, and its 64 chords are those of its edges. Tolerance: 64 chords lie within 2e-4 of the arc's area.
Test(ifc, spline_cylinder) {
    Arena arena = {0};
    Brep b = begin(&arena);
    double w = sqrt(0.5);
    int o = point(&b, 0, 0, 0), x = point(&b, 2, 0, 0), m = point(&b, 2, 2, 0), y = point(&b, 0, 2, 0);
    int o3 = point(&b, 0, 0, 3), x3 = point(&b, 2, 0, 3), m3 = point(&b, 2, 2, 3), y3 = point(&b, 0, 2, 3);
    int low = edge(&b, x, m, y, w), high = edge(&b, x3, m3, y3, w);
    int ox = edge(&b, o, 0, x, 0), yo = edge(&b, y, 0, o, 0), ox3 = edge(&b, o3, 0, x3, 0),
        yo3 = edge(&b, y3, 0, o3, 0);
    int oo = edge(&b, o, 0, o3, 0), xx = edge(&b, x, 0, x3, 0), yy = edge(&b, y, 0, y3, 0);
    int side = add(&b,
                   "IFCRATIONALBSPLINESURFACEWITHKNOTS(2,1,((#%d,#%d),(#%d,#%d),(#%d,#%d)),.UNSPECIFIED.,.F.,"
                   ".F.,.F.,(3,3),(2,2),"
                   "(0.,5.),(-1.,1.),.UNSPECIFIED.,((1.,1.),(%.17g,%.17g),(1.,1.)))",
                   x, x3, m, m3, y, y3, w, w);
    face(&b, side, (int[]){low, yy, -high, -xx}, 4);
    face(&b, plane(&b, 0, 0, -1, o), (int[]){-yo, -low, -ox}, 3);
    face(&b, plane(&b, 0, 0, 1, o3), (int[]){ox3, high, yo3}, 3);
    face(&b, plane(&b, 0, -1, 0, o), (int[]){ox, xx, -ox3, -oo}, 4);
    face(&b, plane(&b, -1, 0, 0, o), (int[]){yo, oo, -yo3, -yy}, 4);
    IfcMesh mesh = finish(&b);
    expect(&mesh, 3 * M_PI, 2 * M_PI + 12 + 3 * M_PI, 2e-4);
    arena_free(&arena);
}

// Eighth of a ball of radius 1: the surface's upper edge is one point, the pole. Tolerance: that of 64 chords both ways, 4e-4.
Test(ifc, spline_pole) {
    Arena arena = {0};
    Brep b = begin(&arena);
    double w = sqrt(0.5);
    int o = point(&b, 0, 0, 0), x = point(&b, 1, 0, 0), xy = point(&b, 1, 1, 0), y = point(&b, 0, 1, 0),
        z = point(&b, 0, 0, 1);
    int xz = point(&b, 1, 0, 1), xyz = point(&b, 1, 1, 1), yz = point(&b, 0, 1, 1);
    int low = edge(&b, x, xy, y, w), left = edge(&b, x, xz, z, w), right = edge(&b, y, yz, z, w);
    int ox = edge(&b, o, 0, x, 0), oy = edge(&b, o, 0, y, 0), oz = edge(&b, o, 0, z, 0);
    int ball =
        add(&b,
            "IFCRATIONALBSPLINESURFACEWITHKNOTS(2,2,((#%d,#%d,#%d),(#%d,#%d,#%d),(#%d,#%d,#%d)),.UNSPECIFIED."
            ",.F.,.F.,.F.,"
            "(3,3),(3,3),(0.,1.),(0.,1.),.UNSPECIFIED.,((1.,%.17g,1.),(%.17g,0.5,%.17g),(1.,%.17g,1.)))",
            x, xz, z, xy, xyz, z, y, yz, z, w, w, w, w);
    face(&b, ball, (int[]){low, right, -left}, 3);
    face(&b, plane(&b, 0, 0, -1, o), (int[]){oy, -low, -ox}, 3);
    face(&b, plane(&b, 0, -1, 0, o), (int[]){ox, left, -oz}, 3);
    face(&b, plane(&b, -1, 0, 0, o), (int[]){oz, -right, -oy}, 3);
    IfcMesh mesh = finish(&b);
    expect(&mesh, M_PI / 6, M_PI / 2 + 3 * M_PI / 4, 4e-4);
    arena_free(&arena);
}

// A cylinder of radius 1 and height 2 whose side closes on itself: nine points around. The circles' edges begin a quarter turn from where
// the surface does, so they are parts of closed curves that go around their ends. Tolerance: that of 256 chords, 1e-4, and as much for
// arcs whose parameters are no angles.
Test(ifc, spline_closed) {
    Arena arena = {0};
    Brep b = begin(&arena);
    static const double X[] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, Y[] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    const char *net = "", *weights = "", *ring[2] = {"", ""}, *curve_weights = "";
    double w = sqrt(0.5);
    for (int i = 0; i < 9; i++) {
        const char *comma = i ? "," : "";
        int low = point(&b, X[i], Y[i], 0), high = point(&b, X[i], Y[i], 2);
        double weight = i % 2 ? w : 1;
        net = arena_format(&arena, "%s%s(#%d,#%d)", net, comma, low, high);
        weights = arena_format(&arena, "%s%s(%.17g,%.17g)", weights, comma, weight, weight);
        ring[0] = arena_format(&arena, "%s%s#%d", ring[0], comma, low);
        ring[1] = arena_format(&arena, "%s%s#%d", ring[1], comma, high);
        curve_weights = arena_format(&arena, "%s%s%.17g", curve_weights, comma, weight);
    }
    int side = add(&b,
                   "IFCRATIONALBSPLINESURFACEWITHKNOTS(2,1,(%s),.UNSPECIFIED.,.T.,.F.,.F.,(3,2,2,2,3),(2,2),("
                   "0.,1.,2.,3.,4.),(0.,1.),"
                   ".UNSPECIFIED.,(%s))",
                   net, weights);
    int at[2] = {point(&b, 0, 1, 0), point(&b, 0, 1, 2)}, circle[2];
    for (int i = 0; i < 2; i++) {
        int vertex = add(&b, "IFCVERTEXPOINT(#%d)", at[i]);
        int curve = add(&b,
                        "IFCRATIONALBSPLINECURVEWITHKNOTS(2,(%s),.UNSPECIFIED.,.T.,.F.,(3,2,2,2,3),(0.,1.,2.,"
                        "3.,4.),.UNSPECIFIED.,(%s))",
                        ring[i], curve_weights);
        circle[i] = add(&b, "IFCEDGECURVE(#%d,#%d,#%d,.T.)", vertex, vertex, curve);
    }
    int seam = edge(&b, at[0], 0, at[1], 0);
    face(&b, side, (int[]){circle[0], seam, -circle[1], -seam}, 4);
    face(&b, plane(&b, 0, 0, -1, at[0]), (int[]){-circle[0]}, 1);
    face(&b, plane(&b, 0, 0, 1, at[1]), (int[]){circle[1]}, 1);
    IfcMesh mesh = finish(&b);
    expect(&mesh, 2 * M_PI, 6 * M_PI, 2e-4);
    arena_free(&arena);
}

// The square under z = 1 + x y, a ruled surface of degrees 1 and 1: volume 1 + 1/4. The file contradicts itself: the face is told as the
// other side of the surface than its outline has, and the bottom's outline runs the wrong way. Neighbours tell the sides.
Test(ifc, spline_ruled) {
    Arena arena = {0};
    Brep b = begin(&arena);
    int low[4], high[4], up[4], bottom[4], top[4];
    for (int i = 0; i < 4; i++) {
        double x = i == 1 || i == 2, y = i >= 2;
        low[i] = point(&b, x, y, 0);
        high[i] = point(&b, x, y, 1 + x * y);
    }
    for (int i = 0; i < 4; i++) {
        int k = (i + 1) % 4;
        up[i] = edge(&b, low[i], 0, high[i], 0);
        bottom[i] = edge(&b, low[i], 0, low[k], 0);
        top[i] = edge(&b, high[i], 0, high[k], 0);
    }
    // u runs along y here, so the surface's normal points down.
    int ruled = add(&b,
                    "IFCBSPLINESURFACEWITHKNOTS(1,1,((#%d,#%d),(#%d,#%d)),.UNSPECIFIED.,.F.,.F.,.F.,(2,2),(2,"
                    "2),(0.,1.),(0.,1.),"
                    ".UNSPECIFIED.)",
                    high[0], high[1], high[3], high[2]);
    face(&b, ruled, (int[]){top[0], top[1], top[2], top[3]}, 4);
    face(&b, plane(&b, 0, 0, -1, low[0]), (int[]){bottom[0], bottom[1], bottom[2], bottom[3]}, 4);
    for (int i = 0; i < 4; i++) {
        int k = (i + 1) % 4;
        face(&b,
             plane(&b,
                   i == 1   ? 1
                   : i == 3 ? -1
                            : 0,
                   i == 0   ? -1
                   : i == 2 ? 1
                            : 0,
                   0, low[i]),
             (int[]){bottom[i], up[k], -top[i], -up[i]}, 4);
    }
    IfcMesh mesh = finish(&b);
    // Chords of 256 a circle: the surface's normal turns by half a right angle.
    cr_expect_float_eq(ifc_volume(&mesh), 1.25, 1e-4, "%.9g", ifc_volume(&mesh));
    cr_expect_lt(ifc_gap(&mesh), 1e-9);
    arena_free(&arena);
}

// A face whose edges leave its surface by 2 mm is flat between them, with a note.
Test(ifc, spline_left) {
    Arena arena = {0};
    Brep b = begin(&arena);
    int p[4], e[4];
    for (int i = 0; i < 4; i++) p[i] = point(&b, i == 1 || i == 2, i >= 2, 0);
    for (int i = 0; i < 4; i++) e[i] = edge(&b, p[i], 0, p[(i + 1) % 4], 0);
    int off = point(&b, 0, 0, 0.002);
    face(&b,
         add(&b,
             "IFCBSPLINESURFACEWITHKNOTS(1,1,((#%d,#%d),(#%d,#%d)),.UNSPECIFIED.,.F.,.F.,.F.,(2,2),(2,2),(0.,"
             "1.),(0.,1.),.UNSPECIFIED.)",
             off, p[3], p[1], p[2]),
         e, 4);
    IfcModel m;
    ifc_accept(
        &arena,
        ifc_text(&arena,
                 arena_format(&arena, "#100=IFCSHELLBASEDSURFACEMODEL((#101));#101=IFCOPENSHELL((%s));%s",
                              b.faces, b.text)),
        1, &m);
    cr_assert_eq(m.note_count, 1);
    cr_expect(strstr(m.notes[0].text, "its faces are flat between their edges"), "%s", m.notes[0].text);
    cr_expect_float_eq(ifc_area(&m.products[0].mesh), 1, 1e-9);
    arena_free(&arena);
}
