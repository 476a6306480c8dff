// sh3d_openings.c - doors and windows: the part that cuts the wall, whether one walks or sees through it, and how it turns.
//
// Facts about the format, checked on models whose leaf stands open: wallDistance counts from the back (the side
// away from whoever stands in front), and a sash's angles are counter-clockwise as seen on the plan, so a sash from
// 0 to -pi/2 hangs on its left end and opens towards the front. Mirroring the model swaps left and right.
#include <string.h>

#include "maps/sweethome/sh3d.h"

// A person passes a step of this height at most, and stoops under this head; metres.
static const double MAX_SILL = 0.3, MIN_HEAD = 1.5, MIN_WIDTH = 0.4;
static const double DEFAULT_SWING = M_PI / 2;  // radians, of a door that draws none
static const double MIN_SWING = 0.1;           // radians: a sash that turns less is drawn shut
static const double RECTANGLE = 0.999;         // share of the unit square from which a cut-out fills it
static const unsigned LEAF_COLOUR = 0xD8CCB8;  // sRGB, of a door without a colour: light wood

// In the languages that the homes at hand and the program's larger communities use.
static const char *const GLASS_WORDS[] = {
    "window", "glass",   "glazed", "slider",  "sliding",  "patio",  "fenetre", "fenêtre", "vitr",
    "baie",   "fenster", "glas",   "schiebe", "finestra", "vetr",   "ventana", "vidr",    "cristal",
    "janela", "raam",    "okno",   "окно",    "fönster",  "vindue", "窓",      "ガラス",  NULL};
static const char *const WINDOW_WORDS[] = {"window",  "fenetre", "fenêtre", "fenster", "finestra",
                                           "ventana", "janela",  "raam",    "okno",    "окно",
                                           "fönster", "vindue",  "窓",      NULL};
// Windows and doors of glass with these words are walked through.
static const char *const WALKED_WORDS[] = {"door",  "french", "patio",  "slid",    "porte",  "coulis",
                                           "baie",  "balcon", "tür",    "schiebe", "balkon", "porta",
                                           "scorr", "puerta", "corred", "deur",    "schuif", "drzwi",
                                           "двер",  "dörr",   "dør",    "ドア",    NULL};
static const char *const PASSAGE_WORDS[] = {"frame",     "opening",   "passage",   "archway", "encadrement",
                                            "embrasure", "ouverture", "rahmen",    "öffnung", "durchgang",
                                            "telaio",    "apertura",  "passaggio", "vano",    "marco",
                                            "hueco",     "abertura",  NULL};

// The cut-out in the unit square, x along the width and y up; nothing for a rectangle.
static void add_cutout(Sh3d *s, const XmlNode *node, SketchOpening *o, bool mirrored) {
    const char *path = xml_get(node, "cutOutShape");
    Vec2 shape[SH3D_MAX_SHAPE];
    if (!path) return;
    int count = sh3d_shape(path, shape, SH3D_MAX_SHAPE);
    for (int i = 0; i < count; i++) {
        double x = fmin(fmax(shape[i].x, 0), 1), y = fmin(fmax(shape[i].y, 0), 1);
        shape[i] = vec2(mirrored ? 1 - x : x, 1 - y);
    }
    double area = count ? fabs(sh3d_shape_area(shape, count)) : 0;
    if (area < 1 - RECTANGLE)
        building_tally(&s->bad_shapes, sh3d_text(node, "name"), vec3(o->centre.x, o->centre.y, o->sill));
    if (area < 1 - RECTANGLE || area >= RECTANGLE) return;
    bool forward = sh3d_shape_area(shape, count) > 0;
    o->first_cutout = s->sketch->point_count;
    o->cutout_count = count;
    for (int i = 0; i < count; i++) sh3d_add_point(s, shape[forward ? i : count - 1 - i], -1);
}

// Hinge and swing from the sashes drawn.
static bool read_sashes(Sh3d *s, const XmlNode *node, SketchOpening *o, bool mirrored) {
    int count = 0;
    bool hung[2] = {false, false};
    for (const XmlNode *sash = node->first; sash; sash = sash->next) {
        if (!xml_is(sash, "sash")) continue;
        double x = sh3d_number(s, sash, "xAxis", NAN, -SH3D_MAX_LENGTH, SH3D_MAX_LENGTH);
        double from = sh3d_number(s, sash, "startAngle", NAN, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
        double to = sh3d_number(s, sash, "endAngle", NAN, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
        int end = (x >= 0.5) != mirrored;
        double swing = fmax(fmin(mirrored ? from - to : to - from, M_PI), -M_PI);
        if (fabs(swing) < MIN_SWING) swing = DEFAULT_SWING * (end ? 1 : -1);
        // The swing at end 0 counts for a double leaf; the other leaf turns the other way.
        if (count == 0 || (end == 0 && !hung[0])) o->swing = swing;
        if (count == 0) o->hinge = end;
        hung[end] = true;
        count++;
    }
    if (hung[0] && hung[1]) o->hinge = 2;
    return count > 0;
}

// Is it a window that does not open, as a fixed pane down to the floor? It has no sash. Models name panes, and parts
// that move on hinges or rails; where the model tells nothing, or is missing, the name says that it is a window.
static bool is_fixed(Sh3d *s, const XmlNode *node) {
    const ObjModel *m = sh3d_model(s, node);
    bool pane = false, moves = false;
    for (int i = 0; m && i < m->group_count; i++) {
        pane = pane || strcasestr(m->groups[i], "window_pane");
        moves = moves || strcasestr(m->groups[i], "on_hinge_") || strcasestr(m->groups[i], "on_rail_");
    }
    return !moves && (pane || sh3d_has_word(node, WINDOW_WORDS)) && !sh3d_has_word(node, WALKED_WORDS);
}

static void classify(Sh3d *s, const XmlNode *node, SketchOpening *o, bool mirrored) {
    double floor = sh3d_level(s, node)->floor;
    bool sash = read_sashes(s, node, o, mirrored);
    if (o->sill - floor > MAX_SILL || o->head - floor < MIN_HEAD || o->width < MIN_WIDTH ||
        (!sash && is_fixed(s, node))) {
        o->kind = OPENING_WINDOW;
        o->glazed = true;
        return;
    }
    o->kind = !sash && sh3d_has_word(node, PASSAGE_WORDS) ? OPENING_PASSAGE : OPENING_DOOR;
    o->glazed = o->kind == OPENING_DOOR && sh3d_has_word(node, GLASS_WORDS);
    // Towards the front, hung on the left, like the program's own doors.
    if (!sash) o->hinge = mirrored ? 1 : 0, o->swing = mirrored ? DEFAULT_SWING : -DEFAULT_SWING;
}

static int leaf_material(Sh3d *s, const XmlNode *node, bool glazed) {
    unsigned rgb = LEAF_COLOUR;
    sh3d_colour(s, node, "color", &rgb);
    return building_add_material(s->arena, s->b,
                                 (Material){.name = glazed ? "glass door" : "door",
                                            .reflectance = maps_colour(rgb),
                                            .alpha = glazed ? 0.3f : 1});
}

bool sh3d_read_opening(Sh3d *s, const XmlNode *node) {
    const Sh3dLevel *level = sh3d_level(s, node);
    bool mirrored = sh3d_flag(node, "modelMirrored", false);
    double x = sh3d_coordinate(s, node, "x", NAN), y = -sh3d_coordinate(s, node, "y", NAN);
    double width = sh3d_length(s, node, "width", NAN), depth = sh3d_length(s, node, "depth", NAN);
    double height = sh3d_length(s, node, "height", NAN), up = sh3d_coordinate(s, node, "elevation", 0);
    // Shares of the piece's box; beyond it a little, since frames are wider than their models.
    double thickness = sh3d_number(s, node, "wallThickness", 1, 0, 10),
           behind = sh3d_number(s, node, "wallDistance", 0, -10, 10);
    double share = sh3d_number(s, node, "wallWidth", 1, 0, 10),
           left = sh3d_number(s, node, "wallLeft", 0, -10, 10);
    double tall = sh3d_number(s, node, "wallHeight", 1, 0, 10),
           top = sh3d_number(s, node, "wallTop", 0, -10, 10);
    if (mirrored) left = 1 - left - share;
    SketchOpening o = {
        .storey = level->storey, .angle = sh3d_angle(s, node, "angle"), .name = sh3d_text(node, "name")};
    // In the piece's own frame, x to its right and y to its back.
    Vec2 local = vec2((left + share / 2 - 0.5) * width, (0.5 - behind - thickness / 2) * depth);
    double c = cos(o.angle), sn = sin(o.angle);
    o.centre = vec2(x + c * local.x - sn * local.y, y + sn * local.x + c * local.y);
    o.width = share * width;
    o.depth = thickness * depth;
    o.head = level->floor + up + height * (1 - top);
    o.sill = o.head - height * tall;
    o.place = sh3d_place(s, node, "door or window");
    classify(s, node, &o, mirrored);
    if (s->failed) return false;
    if (o.width < MAPS_GRID || o.head - o.sill < MAPS_GRID) {
        building_note(s->arena, s->b, NOTE_DROPPED, vec3(x, y, o.sill),
                      "%s: %s is smaller than 1 mm: left out", s->where, o.place);
        return false;
    }
    o.material = leaf_material(s, node, o.glazed);
    add_cutout(s, node, &o, mirrored);
    *ARENA_PUSH(s->arena, s->sketch->openings, s->sketch->opening_count, s->sketch->opening_capacity) = o;
    return true;
}
