// styles.c - units, and the looks of items and materials (ISO 16739, IfcMeasureResource and IfcPresentationAppearanceResource).
#include <stdio.h>

#include "maps/ifc/ifc_file.h"

enum { MOST_MATERIALS = 10000, LOOK_TABLE = 32768, MOST_LISTED = 64 };

// ---- units

static double si_prefix(const Reader *r, const StepValue *v) {
    static const struct {
        const char *name;
        double factor;
    } PREFIXES[] = {{"EXA", 1e18},   {"PETA", 1e15},  {"TERA", 1e12}, {"GIGA", 1e9},  {"MEGA", 1e6},
                    {"KILO", 1e3},   {"HECTO", 1e2},  {"DECA", 10},   {"DECI", 0.1},  {"CENTI", 0.01},
                    {"MILLI", 1e-3}, {"MICRO", 1e-6}, {"NANO", 1e-9}, {"PICO", 1e-12}};
    for (size_t i = 0; i < sizeof PREFIXES / sizeof *PREFIXES; i++)
        if (ifc_is(r, v, PREFIXES[i].name)) return PREFIXES[i].factor;
    return 1;
}

// The factor of a unit to metres or radians; 0 where it is neither.
static double unit_factor(Reader *r, int record, const char *kind, int depth) {
    StepValue v[4], m[2];
    int type = ifc_type(r, record);
    if (depth > 8 || !ifc_arguments(r, record, v, 4) || !ifc_is(r, &v[1], kind)) return 0;
    if (type == T_SIUNIT) return si_prefix(r, &v[2]);
    if (type != T_CONVERSIONBASEDUNIT && type != T_CONVERSIONBASEDUNITWITHOFFSET) return 0;
    if (!ifc_arguments(r, v[3].record, m, 2)) return 0;
    return ifc_number(r, &m[0], 0) * unit_factor(r, m[1].record, kind, depth + 1);
}

void ifc_read_units(Reader *r, IfcFile *file) {
    file->length = file->angle = 1;
    for (int i = 0; i < file->step.record_count; i++) {
        StepValue list;
        if (file->step.type[i] != T_UNITASSIGNMENT || !ifc_arguments(r, i, &list, 1)) continue;
        StepCursor c = ifc_list(r, &list);
        for (StepValue u = step_next(&c); u.kind != STEP_END; u = step_next(&c)) {
            double length = unit_factor(r, u.record, "LENGTHUNIT", 0),
                   angle = unit_factor(r, u.record, "PLANEANGLEUNIT", 0);
            if (length > 1e-12 && length < 1e6) file->length = length;
            if (angle > 1e-12 && angle < 1e3) file->angle = angle;
        }
        return;
    }
}

// ---- looks

// A surface style whose look was made: a few styles serve all items, as a rule.
enum { KNOWN_STYLES = 256 };
typedef struct KnownStyle {
    int entry;  // record + 1; 0: none
    int look;
} KnownStyle;

typedef struct Looks {
    IfcFile *file;
    Arena *arena;
    int *slot;  // [LOOK_TABLE] material + 1
    KnownStyle known[KNOWN_STYLES];
} Looks;

static int keep_look(Looks *looks, IfcMaterial look) {
    IfcFile *file = looks->file;
    uint64_t h = file_hash(look.colour, sizeof look.colour, (uint64_t)(double)(look.alpha * 1000));
    h = file_hash(look.name, strlen(look.name), h);
    for (;; h++) {
        int at = looks->slot[h % LOOK_TABLE];
        if (!at) break;
        const IfcMaterial *m = &file->materials[at - 1];
        if (memcmp(m->colour, look.colour, sizeof look.colour) == 0 && m->alpha == look.alpha &&
            m->texture == look.texture && strcmp(m->name, look.name) == 0)
            return at - 1;
    }
    if (file->material_count >= MOST_MATERIALS) return 0;
    *ARENA_PUSH(looks->arena, file->materials, file->material_count, file->material_room) = look;
    looks->slot[h % LOOK_TABLE] = file->material_count;
    return file->material_count - 1;
}

static float share(double x) { return (float)(x >= 0 ? x <= 1 ? x : 1 : 0); }

// The first texture of an IfcSurfaceStyleWithTextures; 0: none.
static int style_texture(Reader *r, Looks *looks, int record) {
    StepValue list;
    if (!ifc_arguments(r, record, &list, 1)) return 0;
    StepCursor c = ifc_list(r, &list);
    StepValue first = step_next(&c);
    return first.kind == STEP_REF ? ifc_read_texture(r, looks->file, first.record) : 0;
}

// The colour and the picture of an IfcSurfaceStyle; -1 where it has neither. A picture without a colour lies on white.
static int new_style(Reader *r, Looks *looks, int record) {
    StepValue v[3], s[2], rgb[4];
    ifc_arguments(r, record, v, 3);
    IfcMaterial look = {.colour = {1, 1, 1}, .alpha = 1};
    bool coloured = false;
    StepCursor c = ifc_list(r, &v[2]);
    for (StepValue part = step_next(&c); part.kind != STEP_END; part = step_next(&c)) {
        int type = ifc_type(r, part.record);
        if (type == T_SURFACESTYLEWITHTEXTURES && !look.texture)
            look.texture = style_texture(r, looks, part.record);
        if ((type != T_SURFACESTYLERENDERING && type != T_SURFACESTYLESHADING) || coloured ||
            !ifc_arguments(r, part.record, s, 2))
            continue;
        if (ifc_type(r, s[0].record) != T_COLOURRGB || !ifc_arguments(r, s[0].record, rgb, 4)) continue;
        coloured = true;
        look.alpha = share(1 - ifc_number(r, &s[1], 0));
        for (int i = 0; i < 3; i++) look.colour[i] = share(ifc_number(r, &rgb[1 + i], 0));
    }
    if (!coloured && !look.texture) return -1;
    look.name = step_string(&r->file->step, &v[0], &r->strings);
    return keep_look(looks, look);
}

static int surface_style(Reader *r, Looks *looks, int record) {
    if (ifc_type(r, record) != T_SURFACESTYLE) return -1;
    KnownStyle *known = &looks->known[record % KNOWN_STYLES];
    if (known->entry != record + 1) *known = (KnownStyle){record + 1, new_style(r, looks, record)};
    return known->look;
}

// The look of a list of styles: surface styles, or assignments of them.
static int listed_style(Reader *r, Looks *looks, const StepValue *list, int depth) {
    StepCursor c = ifc_list(r, list);
    int count = 0;
    for (StepValue s = step_next(&c); s.kind != STEP_END && count < MOST_LISTED; s = step_next(&c), count++) {
        StepValue inner;
        int look = -1, type = ifc_type(r, s.record);
        if (type == T_SURFACESTYLE) {
            look = surface_style(r, looks, s.record);
        } else if (type == T_PRESENTATIONSTYLEASSIGNMENT && depth < 2 &&
                   ifc_arguments(r, s.record, &inner, 1)) {
            look = listed_style(r, looks, &inner, depth + 1);
        }
        if (look >= 0) return look;
    }
    return -1;
}

static int styled_item(Reader *r, Looks *looks, int record, int *item) {
    StepValue v[2];
    *item = -1;
    if (ifc_type(r, record) != T_STYLEDITEM || !ifc_arguments(r, record, v, 2)) return -1;
    *item = v[0].record;
    if (v[1].kind == STEP_REF) {
        StepValue list;
        if (ifc_type(r, v[1].record) == T_SURFACESTYLE) return surface_style(r, looks, v[1].record);
        return ifc_type(r, v[1].record) == T_PRESENTATIONSTYLEASSIGNMENT &&
                       ifc_arguments(r, v[1].record, &list, 1)
                   ? listed_style(r, looks, &list, 1)
                   : -1;
    }
    return listed_style(r, looks, &v[1], 0);
}

// A material's styled representations.
static void material_style(Reader *r, Looks *looks, int record, Pairs *out, int *room) {
    StepValue v[4], s[4];
    ifc_arguments(r, record, v, 4);
    StepCursor c = ifc_list(r, &v[2]);
    for (StepValue rep = step_next(&c); rep.kind != STEP_END; rep = step_next(&c)) {
        if (ifc_type(r, rep.record) != T_STYLEDREPRESENTATION || !ifc_arguments(r, rep.record, s, 4))
            continue;
        StepCursor items = ifc_list(r, &s[3]);
        for (StepValue i = step_next(&items); i.kind != STEP_END; i = step_next(&items)) {
            int item, look = styled_item(r, looks, i.record, &item);
            if (look < 0 || v[3].record < 0) continue;
            *ARENA_PUSH(looks->arena, out->pair, out->count, *room) = (Pair){v[3].record, look};
            return;
        }
    }
}

static void colour_map(Reader *r, Looks *looks, int record, Pairs *maps) {
    StepValue v[4], list;
    ifc_arguments(r, record, v, 4);
    if (v[0].record < 0 || ifc_type(r, v[2].record) != T_COLOURRGBLIST ||
        !ifc_arguments(r, v[2].record, &list, 1))
        return;
    float alpha = (float)ifc_number(r, &v[1], 1);
    StepCursor c = ifc_list(r, &list);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        double rgb[3] = {0};
        step_numbers(&c, &s, rgb, 3);
        keep_look(looks, (IfcMaterial){"", {(float)rgb[0], (float)rgb[1], (float)rgb[2]}, alpha, 0});
    }
    *ARENA_PUSH(looks->arena, maps->pair, maps->count, maps->room) = (Pair){v[0].record, record};
}

// The face set (IfcIndexedTriangleTextureMap) or the face (IfcTextureMap) that places in a picture belong to.
static void picture_places(Reader *r, int record, Arena *arena, Pairs *out) {
    StepValue v[3];
    if (!ifc_arguments(r, record, v, 3)) return;
    int to = ifc_type(r, record) == T_TEXTUREMAP ? v[2].record : v[1].record;
    if (to >= 0) *ARENA_PUSH(arena, out->pair, out->count, out->room) = (Pair){to, record};
}

void ifc_read_styles(Reader *r, IfcFile *file, Arena *arena) {
    Looks looks = {.file = file, .arena = arena, .slot = ARENA_ARRAY(arena, int, LOOK_TABLE)};
    keep_look(&looks, (IfcMaterial){"", {0.8f, 0.8f, 0.8f}, 1, 0});
    enum { AHEAD = 512 };  // records
    for (int i = 0; i < file->step.record_count; i++) {
        int item;
        // Styled items stand far apart: their text is asked for before its turn.
        if (i + AHEAD < file->step.record_count && file->step.type[i + AHEAD] == T_STYLEDITEM)
            __builtin_prefetch(file->step.text + file->step.at[i + AHEAD]);
        switch (file->step.type[i]) {
        case T_STYLEDITEM: {
            int look = styled_item(r, &looks, i, &item);
            if (look >= 0 && item >= 0)
                *ARENA_PUSH(arena, file->styles.pair, file->styles.count, file->styles.room) =
                    (Pair){item, look};
            break;
        }
        case T_MATERIALDEFINITIONREPRESENTATION:
            material_style(r, &looks, i, &file->looks, &file->looks.room);
            break;
        case T_INDEXEDCOLOURMAP:
            colour_map(r, &looks, i, &file->colour_maps);
            break;
        case T_INDEXEDTRIANGLETEXTUREMAP:
        case T_TEXTUREMAP:
            picture_places(r, i, arena, &file->places);
            break;
        case T_TEXTURECOORDINATEGENERATOR:
            ifc_note(r, i, "tells no places in a picture that are read: its faces show the picture's mean");
            break;
        default:
            break;
        }
    }
    ifc_sort(&file->styles);
    ifc_sort(&file->looks);
    ifc_sort(&file->colour_maps);
    ifc_sort(&file->places);
}

// ---- materials of products

static int first_look(Reader *r, const StepValue *list, int depth) {
    StepCursor c = ifc_list(r, list);
    int count = 0;
    for (StepValue m = step_next(&c); m.kind != STEP_END && count < MOST_LISTED; m = step_next(&c), count++) {
        int look = ifc_material_look(r, m.record, depth + 1);
        if (look >= 0) return look;
    }
    return -1;
}

// The first of several layers that has a look shows.
int ifc_material_look(Reader *r, int record, int depth) {
    StepValue v[4];
    if (depth > 8 || !ifc_arguments(r, record, v, 4)) return -1;
    switch (ifc_type(r, record)) {
    case T_MATERIAL: {
        int at = ifc_pair(&r->file->looks, record);
        return at < 0 ? -1 : r->file->looks.pair[at].value;
    }
    case T_MATERIALLAYERSETUSAGE:
    case T_MATERIALPROFILESETUSAGE:
    case T_MATERIALLAYER:
        return ifc_material_look(r, v[0].record, depth + 1);
    case T_MATERIALLAYERSET:
    case T_MATERIALLIST:
        return first_look(r, &v[0], depth);
    case T_MATERIALCONSTITUENTSET:
    case T_MATERIALPROFILESET:
        return first_look(r, &v[2], depth);
    case T_MATERIALCONSTITUENT:
    case T_MATERIALPROFILE:
        return ifc_material_look(r, v[2].record, depth + 1);
    default:
        return -1;
    }
}
