// house_fixture.c - small building models, written as STEP files.
#include "tests/maps/ifc/house_fixture.h"

#include "tests/support/fixture.h"
#include <criterion/criterion.h>

extern const MapsReader MAPS_READER_IFC;

enum { ORIGIN = 1, UP, ALONG_X, AXES, CONTEXT, UNIT, UNITS, PROJECT, FIRST };

static int add(House *h, const char *format, ...) __attribute__((format(printf, 2, 3)));
static int add(House *h, const char *format, ...) {
    va_list args;
    va_start(args, format);
    char *text = arena_format_list(h->arena, format, args);
    va_end(args);
    text_append(&h->text, "#%d=%s;\n", h->next, text);
    return h->next++;
}

// Each entity that has a GlobalId takes its own number as one.
static const char *guid(const House *h) { return arena_format(h->arena, "%022d", h->next); }

House house_begin(Arena *arena, bool feet, Vec2 site, double turn) {
    House h = {.arena = arena, .text = {.arena = arena}, .next = FIRST, .metre = feet ? 1 / 0.3048 : 1};
    text_append(
        &h.text,
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('IFC2X3'));\nENDSEC;\nDATA;\n#1=IFCCARTESIANPOINT((0.,0.,0.));\n"
        "#2=IFCDIRECTION((0.,0.,1.));\n#3=IFCDIRECTION((1.,0.,0.));\n#4=IFCAXIS2PLACEMENT3D(#1,#2,#3);\n"
        "#5=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#4,$);\n");
    if (feet)
        text_append(&h.text, "#6=IFCCONVERSIONBASEDUNIT(#9001,.LENGTHUNIT.,'FOOT',#9002);\n"
                             "#9001=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);\n"
                             "#9002=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(0.3048),#9003);\n"
                             "#9003=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n");
    else
        text_append(&h.text, "#6=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n");
    text_append(
        &h.text,
        "#7=IFCUNITASSIGNMENT((#6));\n#8=IFCPROJECT('0000000000000000000008',$,'test',$,$,$,$,(#5),#7);\n");
    int at = add(&h, "IFCCARTESIANPOINT((%.9f,%.9f,0.))", site.x * h.metre, site.y * h.metre);
    int to = add(&h, "IFCDIRECTION((%.15f,%.15f,0.))", cos(turn), sin(turn));
    int axes = add(&h, "IFCAXIS2PLACEMENT3D(#%d,#2,#%d)", at, to);
    int place = add(&h, "IFCLOCALPLACEMENT($,#%d)", axes);
    int land =
        add(&h, "IFCSITE('%s',$,'site',$,$,#%d,$,$,.ELEMENT.,(50,30,0),(10,0,0),0.,$,$)", guid(&h), place);
    h.placed = add(&h, "IFCLOCALPLACEMENT(#%d,#4)", place);
    int house = add(&h, "IFCBUILDING('%s',$,'house',$,$,#%d,$,$,.ELEMENT.,$,$,$)", guid(&h), h.placed);
    add(&h, "IFCRELAGGREGATES('%s',$,$,$,#8,(#%d))", guid(&h), land);
    add(&h, "IFCRELAGGREGATES('%s',$,$,$,#%d,(#%d))", guid(&h), land, house);
    h.storeys[3] = house;
    return h;
}

int house_storey(House *h, const char *name, double elevation) {
    int at = add(h, "IFCCARTESIANPOINT((0.,0.,%.9f))", elevation * h->metre);
    int axes = add(h, "IFCAXIS2PLACEMENT3D(#%d,#2,#3)", at);
    int place = add(h, "IFCLOCALPLACEMENT(#%d,#%d)", h->placed, axes);
    int storey = add(h, "IFCBUILDINGSTOREY('%s',$,'%s',$,$,#%d,$,$,.ELEMENT.,%.9f)", guid(h), name, place,
                     elevation * h->metre);
    add(h, "IFCRELAGGREGATES('%s',$,$,$,#%d,(#%d))", guid(h), h->storeys[3], storey);
    h->storeys[h->storey_count] = storey;
    return h->storey_count++;
}

static int solid(House *h, Vec3 low, Vec3 high) {
    int middle = add(h, "IFCCARTESIANPOINT((%.9f,%.9f))", (low.x + high.x) / 2 * h->metre,
                     (low.y + high.y) / 2 * h->metre);
    int flat = add(h, "IFCAXIS2PLACEMENT2D(#%d,$)", middle);
    int profile = add(h, "IFCRECTANGLEPROFILEDEF(.AREA.,$,#%d,%.9f,%.9f)", flat, (high.x - low.x) * h->metre,
                      (high.y - low.y) * h->metre);
    int foot = add(h, "IFCCARTESIANPOINT((0.,0.,%.9f))", low.z * h->metre);
    int axes = add(h, "IFCAXIS2PLACEMENT3D(#%d,#2,#3)", foot);
    return add(h, "IFCEXTRUDEDAREASOLID(#%d,#%d,#2,%.9f)", profile, axes, (high.z - low.z) * h->metre);
}

static int shape_of(House *h, const char *items, const char *kind) {
    int body = add(h, "IFCSHAPEREPRESENTATION(#5,'Body','%s',(%s))", kind, items);
    return add(h, "IFCPRODUCTDEFINITIONSHAPE($,$,(#%d))", body);
}

static int shape(House *h, int item) {
    return shape_of(h, arena_format(h->arena, "#%d", item), "SweptSolid");
}

static int own_place(House *h) { return add(h, "IFCLOCALPLACEMENT(#%d,#4)", h->placed); }

int house_box(House *h, const char *type, const char *name, int storey, Vec3 low, Vec3 high) {
    int body = shape(h, solid(h, low, high)), place = own_place(h);
    bool slab = strcmp(type, "IFCSLAB") == 0, proxy = strcmp(type, "IFCBUILDINGELEMENTPROXY") == 0;
    int made = add(h, "%s('%s',$,'%s',$,$,#%d,#%d,$%s)", type, guid(h), name, place, body,
                   slab    ? ",.FLOOR."
                   : proxy ? ",$"
                           : "");
    add(h, "IFCRELCONTAINEDINSPATIALSTRUCTURE('%s',$,$,$,(#%d),#%d)", guid(h), made, h->storeys[storey]);
    return made;
}

static int add_space(House *h, const char *number, const char *name, int storey, int body) {
    int place = own_place(h);
    int made = add(h, "IFCSPACE('%s',$,'%s',$,$,#%d,#%d,'%s',.ELEMENT.,.INTERNAL.,$)", guid(h), number, place,
                   body, name);
    add(h, "IFCRELAGGREGATES('%s',$,$,$,#%d,(#%d))", guid(h), h->storeys[storey], made);
    return made;
}

int house_space(House *h, const char *number, const char *name, int storey, Vec3 low, Vec3 high) {
    return add_space(h, number, name, storey, shape(h, solid(h, low, high)));
}

int house_attic(House *h, const char *number, const char *name, int storey, Vec3 low, Vec3 high,
                double ridge) {
    static const int FACES[7][5] = {{0, 2, 3, 1, -1}, {0, 1, 5, 4, -1}, {2, 6, 7, 3, -1}, {4, 5, 9, 8, -1},
                                    {8, 9, 7, 6, -1}, {0, 4, 8, 6, 2},  {1, 3, 7, 9, 5}};
    Vec3 corner[10];
    int point[10];
    for (int i = 0; i < 8; i++)
        corner[i] = vec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    for (int i = 8; i < 10; i++) corner[i] = vec3(i & 1 ? high.x : low.x, (low.y + high.y) / 2, ridge);
    for (int i = 0; i < 10; i++)
        point[i] = add(h, "IFCCARTESIANPOINT((%.9f,%.9f,%.9f))", corner[i].x * h->metre,
                       corner[i].y * h->metre, corner[i].z * h->metre);
    const char *faces = "";
    for (int f = 0; f < 7; f++) {
        const char *loop = "";
        for (int k = 0; k < 5 && FACES[f][k] >= 0; k++)
            loop = arena_format(h->arena, "%s%s#%d", loop, k ? "," : "", point[FACES[f][k]]);
        int ring = add(h, "IFCPOLYLOOP((%s))", loop), bound = add(h, "IFCFACEOUTERBOUND(#%d,.T.)", ring);
        faces = arena_format(h->arena, "%s%s#%d", faces, f ? "," : "", add(h, "IFCFACE((#%d))", bound));
    }
    int shell = add(h, "IFCCLOSEDSHELL((%s))", faces), brep = add(h, "IFCFACETEDBREP(#%d)", shell);
    return add_space(h, number, name, storey, shape_of(h, arena_format(h->arena, "#%d", brep), "Brep"));
}

int house_sheets(House *h, const char *name, int storey, Vec3 low, Vec3 high, unsigned turned) {
    static const int FACES[6][4] = {{0, 2, 3, 1}, {0, 1, 5, 4}, {2, 6, 7, 3},
                                    {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    int point[8];
    for (int i = 0; i < 8; i++)
        point[i] = add(h, "IFCCARTESIANPOINT((%.9f,%.9f,%.9f))", (i & 1 ? high.x : low.x) * h->metre,
                       (i & 2 ? high.y : low.y) * h->metre, (i & 4 ? high.z : low.z) * h->metre);
    const char *faces = "";
    for (int f = 0; f < 6; f++) {
        const int *k = FACES[f];
        bool other = turned >> f & 1;
        int ring = add(h, "IFCPOLYLOOP((#%d,#%d,#%d,#%d))", point[k[0]], point[k[other ? 3 : 1]], point[k[2]],
                       point[k[other ? 1 : 3]]);
        int bound = add(h, "IFCFACEOUTERBOUND(#%d,.T.)", ring);
        faces = arena_format(h->arena, "%s%s#%d", faces, f ? "," : "", add(h, "IFCFACE((#%d))", bound));
    }
    int set = add(h, "IFCCONNECTEDFACESET((%s))", faces),
        model = add(h, "IFCFACEBASEDSURFACEMODEL((#%d))", set);
    int body = shape_of(h, arena_format(h->arena, "#%d", model), "SurfaceModel"), place = own_place(h);
    int made = add(h, "IFCFURNISHINGELEMENT('%s',$,'%s',$,$,#%d,#%d,$)", guid(h), name, place, body);
    add(h, "IFCRELCONTAINEDINSPATIALSTRUCTURE('%s',$,$,$,(#%d),#%d)", guid(h), made, h->storeys[storey]);
    return made;
}

void house_part(House *h, int whole, int part) {
    add(h, "IFCRELAGGREGATES('%s',$,$,$,#%d,(#%d))", guid(h), whole, part);
}

int house_hole(House *h, int host, Vec3 low, Vec3 high) {
    int body = shape(h, solid(h, low, high)), place = own_place(h);
    int hole = add(h, "IFCOPENINGELEMENT('%s',$,'hole',$,$,#%d,#%d,$)", guid(h), place, body);
    add(h, "IFCRELVOIDSELEMENT('%s',$,$,$,#%d,#%d)", guid(h), host, hole);
    return hole;
}

// The placement of a thing whose x axis runs along a wall.
static int turned_place(House *h, Vec3 at, Vec2 along) {
    int point =
        add(h, "IFCCARTESIANPOINT((%.9f,%.9f,%.9f))", at.x * h->metre, at.y * h->metre, at.z * h->metre);
    int to = add(h, "IFCDIRECTION((%.9f,%.9f,0.))", along.x, along.y);
    int axes = add(h, "IFCAXIS2PLACEMENT3D(#%d,#2,#%d)", point, to);
    return add(h, "IFCLOCALPLACEMENT(#%d,#%d)", h->placed, axes);
}

static void fill(House *h, int hole, int made) {
    add(h, "IFCRELFILLSELEMENT('%s',$,$,$,#%d,#%d)", guid(h), hole, made);
    add(h, "IFCRELCONTAINEDINSPATIALSTRUCTURE('%s',$,$,$,(#%d),#%d)", guid(h), made, h->storeys[0]);
}

static int add_door(House *h, int hole, const char *name, int body, int place, double width, double height,
                    const char *operation) {
    int made = add(h, "IFCDOOR('%s',$,'%s',$,$,#%d,#%d,$,%.9f,%.9f)", guid(h), name, place, body,
                   height * h->metre, width * h->metre);
    int style =
        add(h, "IFCDOORSTYLE('%s',$,'style',$,$,$,$,$,.%s.,.NOTDEFINED.,.F.,.F.)", guid(h), operation);
    add(h, "IFCRELDEFINESBYTYPE('%s',$,$,$,(#%d),#%d)", guid(h), made, style);
    fill(h, hole, made);
    return made;
}

int house_door(House *h, int hole, const char *name, Vec3 hinge, Vec2 along, double width, double height,
               const char *operation) {
    // A lining of two posts, and a leaf or two between them.
    bool two = strncmp(operation, "DOUBLE", 6) == 0;
    int post = solid(h, vec3(0, -0.05, 0), vec3(0.05, 0.05, height)),
        other = solid(h, vec3(width - 0.05, -0.05, 0), vec3(width, 0.05, height)),
        leaf = solid(h, vec3(0.06, -0.02, 0.01), vec3(two ? width / 2 : width - 0.06, 0.02, height - 0.02)),
        second = two ? solid(h, vec3(width / 2, -0.02, 0.01), vec3(width - 0.06, 0.02, height - 0.02)) : leaf;
    const char *items = arena_format(h->arena, "#%d,#%d,#%d", post, other, leaf);
    int body = shape_of(h, two ? arena_format(h->arena, "%s,#%d", items, second) : items, "SweptSolid");
    return add_door(h, hole, name, body, turned_place(h, hinge, along), width, height, operation);
}

int house_tight_door(House *h, int hole, const char *name, Vec3 hinge, Vec2 along, double width,
                     double height) {
    int post = solid(h, vec3(0, -0.05, 0), vec3(0.05, 0.05, height)),
        other = solid(h, vec3(width - 0.05, -0.05, 0), vec3(width, 0.05, height)),
        leaf = solid(h, vec3(0.05, 0.01, 0), vec3(width - 0.05, 0.05, height)),
        handle = solid(h, vec3(width - 0.2, -0.04, 1), vec3(width - 0.1, 0.01, 1.02));
    int body =
        shape_of(h, arena_format(h->arena, "#%d,#%d,#%d,#%d", post, other, leaf, handle), "SweptSolid");
    return add_door(h, hole, name, body, turned_place(h, hinge, along), width, height, "SINGLE_SWING_LEFT");
}

int house_window(House *h, int hole, const char *name, Vec3 low, Vec2 along, double width, double height) {
    int left = solid(h, vec3(0, -0.03, 0), vec3(0.05, 0.03, height)),
        right = solid(h, vec3(width - 0.05, -0.03, 0), vec3(width, 0.03, height)),
        pane = solid(h, vec3(0.06, -0.005, 0.01), vec3(width - 0.06, 0.005, height - 0.01));
    int body = shape_of(h, arena_format(h->arena, "#%d,#%d,#%d", left, right, pane), "SweptSolid");
    int place = turned_place(h, low, along);
    int made = add(h, "IFCWINDOW('%s',$,'%s',$,$,#%d,#%d,$,%.9f,%.9f)", guid(h), name, place, body,
                   height * h->metre, width * h->metre);
    fill(h, hole, made);
    return made;
}

Bytes house_end(House *h) {
    text_append(&h->text, "ENDSEC;\nEND-ISO-10303-21;\n");
    return (Bytes){(unsigned char *)h->text.data, strlen(h->text.data)};
}

void house_walls(House *h, int storey, Vec3 low, Vec3 high, int walls[4]) {
    const double t = 0.2;
    walls[0] = house_box(h, "IFCWALLSTANDARDCASE", "south", storey, vec3(low.x - t, low.y - t, low.z),
                         vec3(high.x + t, low.y, high.z));
    walls[1] = house_box(h, "IFCWALLSTANDARDCASE", "east", storey, vec3(high.x, low.y, low.z),
                         vec3(high.x + t, high.y, high.z));
    walls[2] = house_box(h, "IFCWALLSTANDARDCASE", "north", storey, vec3(low.x - t, high.y, low.z),
                         vec3(high.x + t, high.y + t, high.z));
    walls[3] = house_box(h, "IFCWALLSTANDARDCASE", "west", storey, vec3(low.x - t, low.y, low.z),
                         vec3(low.x, high.y, high.z));
}

House house_two_rooms(Arena *arena, bool feet, Vec2 site, double turn, bool spaces) {
    House h = house_begin(arena, feet, site, turn);
    int walls[4], ground = house_storey(&h, "ground floor", 0);
    house_walls(&h, ground, vec3(0, 0, 0), vec3(8.2, 3, 2.5), walls);
    int between = house_box(&h, "IFCWALLSTANDARDCASE", "between", ground, vec3(4, 0, 0), vec3(4.2, 3, 2.5));
    if (spaces) house_space(&h, "1", "west", ground, vec3(0, 0, 0), vec3(4, 3, 2.5));
    if (spaces) house_space(&h, "2", "east", ground, vec3(4.2, 0, 0), vec3(8.2, 3, 2.5));
    int hole = house_hole(&h, between, vec3(3.9, 1, 0), vec3(4.3, 1.9, 2.1));
    // Its x axis runs north, so its y axis points west.
    house_door(&h, hole, "inner door", vec3(4.1, 1, 0), vec2(0, 1), 0.9, 2.1, "SINGLE_SWING_LEFT");
    hole = house_hole(&h, walls[0], vec3(1, -0.3, 0), vec3(2, 0.1, 2.1));
    house_door(&h, hole, "front door", vec3(1, -0.1, 0), vec2(1, 0), 1, 2.1, "SINGLE_SWING_RIGHT");
    hole = house_hole(&h, walls[2], vec3(5, 2.9, 0.9), vec3(6.5, 3.3, 2.1));
    house_window(&h, hole, "north window", vec3(5, 3.1, 0.9), vec2(1, 0), 1.5, 1.2);
    return h;
}

void house_read(Arena *arena, Bytes file, Building *b) {
    Error error;
    *b = (Building){.file_size = (double)file.size};
    cr_assert(MAPS_READER_IFC.read("t.ifc", file, arena, b, &error), "%s", error.text);
    const char *fault;
    cr_assert_eq(building_check(b, arena, &fault, 1), 0, "%s", fault);
}

const Opening *house_opening(const Building *b, const char *name) {
    for (int i = 0; i < b->opening_count; i++)
        if (strcmp(b->openings[i].name, name) == 0) return &b->openings[i];
    cr_assert_fail("no opening is called %s", name);
    return NULL;
}

int house_notes(const Building *b, const char *text) {
    int count = 0;
    for (int i = 0; i < b->note_count; i++) count += strstr(b->notes[i].text, text) != NULL;
    return count;
}

const Region *house_room(const Building *b, const char *name) {
    const Region *best = NULL;
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->kind != REGION_ROOM || strcmp(r->name, name) != 0) continue;
        if (!best || fixture_region_area(b, r) > fixture_region_area(b, best)) best = r;
    }
    cr_assert(best, "no room is called %s", name);
    return best;
}
