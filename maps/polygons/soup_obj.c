// soup_obj.c - Wavefront OBJ models as buildings: polygons alone. What furniture forgives is refused here, since a
// wall left out is a wall seen through.
//
// OBJ says neither which way is up nor what the unit is. By custom y is up and the unit a metre; comments above the
// first vertex may say otherwise, as exporters write them: `# up z`, `# Z-up`, `# unit 0.01`, `# Model units = cm`.
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>

#include "maps/building/reader.h"
#include "maps/building/scan.h"
#include "maps/building/texture.h"
#include "maps/polygons/foreign.h"
#include "maps/polygons/obj.h"
#include "maps/polygons/soup_readers.h"

static const double SMALLEST_UNIT = 1e-6, LARGEST_UNIT = 1e6;  // metres
enum { MAX_WORD = 32 };

static const struct {
    const char *name;
    double metres;
} UNITS[] = {{"m", 1},
             {"metre", 1},
             {"metres", 1},
             {"meter", 1},
             {"meters", 1},
             {"cm", 0.01},
             {"mm", 0.001},
             {"centimetres", 0.01},
             {"centimeters", 0.01},
             {"millimetres", 0.001},
             {"millimeters", 0.001},
             {"in", 0.0254},
             {"inch", 0.0254},
             {"inches", 0.0254},
             {"ft", 0.3048},
             {"foot", 0.3048},
             {"feet", 0.3048}};

typedef struct Conventions {
    bool z_up;
    double unit;  // metres
} Conventions;

typedef struct SoupObj {
    const char *path;
    Conventions how;
    ObjModel model;
    SoupMesh mesh;   // in building space; a face's material tells its group and its material
    int *materials;  // of the building, for each of the model's
    Arena *arena;
    Building *b;
    Error *error;
    NoteTally unknown;
} SoupObj;

// ---- comments

// The next word of a comment, lower case; a number is a word of its own. False at the end of the line.
static bool next_word(Scan *s, char word[MAX_WORD]) {
    while (s->at < s->end && *s->at != '\n' && !isalnum((unsigned char)*s->at)) s->at++;
    int length = 0;
    bool number = s->at < s->end && isdigit((unsigned char)*s->at);
    while (s->at < s->end &&
           (isalnum((unsigned char)*s->at) || (number && *s->at && strchr(".-+", *s->at)))) {
        if (length < MAX_WORD - 1) word[length++] = (char)tolower((unsigned char)*s->at);
        s->at++;
    }
    word[length] = 0;
    return length > 0;
}

static bool named_unit(const char *word, double *metres) {
    for (size_t i = 0; i < sizeof UNITS / sizeof *UNITS; i++) {
        if (strcmp(word, UNITS[i].name) != 0) continue;
        *metres = UNITS[i].metres;
        return true;
    }
    return false;
}

// `unit 0.01`, `units cm`, `units in cm`, `unit 2.54 cm`: the words after `unit`.
static void read_unit(Scan s, double *unit) {
    char word[MAX_WORD], *rest;
    double metres = 1, count = 1;
    if (!next_word(&s, word)) return;
    // Inches at the end of a line only: before other words `in` is no unit.
    Scan after = s;
    char next[MAX_WORD];
    if (strcmp(word, "in") == 0 && next_word(&after, next)) memcpy(word, next, sizeof word);
    if (!named_unit(word, &metres)) {
        count = strtod(word, &rest);
        if (*rest) return;
        if (next_word(&s, word)) named_unit(word, &metres);
    }
    if (count * metres >= SMALLEST_UNIT && count * metres <= LARGEST_UNIT) *unit = count * metres;
}

// `up z`, `z up`, `z axis is up`: an axis beside the word `up`, which then belongs to no other.
static void read_comment(Scan *s, Conventions *how) {
    char word[MAX_WORD], before[MAX_WORD] = "";
    while (next_word(s, word)) {
        bool up = strcmp(word, "up") == 0, axis = strcmp(word, "y") == 0 || strcmp(word, "z") == 0;
        const char *upward = up ? before : axis && strcmp(before, "up") == 0 ? word : "";
        bool said = strcmp(upward, "y") == 0 || strcmp(upward, "z") == 0;
        if (said) how->z_up = *upward == 'z';
        if (strcmp(word, "unit") == 0 || strcmp(word, "units") == 0) read_unit(*s, &how->unit);
        if (strcmp(word, "axis") != 0 && strcmp(word, "is") != 0)
            snprintf(before, sizeof before, "%s", said ? "" : word);
    }
}

static Conventions read_conventions(Bytes content) {
    Conventions how = {false, 1};
    Scan s = scan_begin("", content);
    while (scan_next_line(&s, 0)) {
        if (s.end - s.at > 1 && s.at[0] == 'v' && (s.at[1] == ' ' || s.at[1] == '\t')) break;
        if (*s.at == '#') read_comment(&s, &how);
        while (s.at < s.end && *s.at != '\n') s.at++;
    }
    return how;
}

// ---- faces

static bool check_face(SoupObj *o, const ObjFace *f) {
    if (f->corner_count > SOUP_MAX_CORNERS) {
        return error_set(o->error, "%s:%d: a face has %d corners (allowed 3 to %d)", o->path, f->line,
                         f->corner_count, SOUP_MAX_CORNERS);
    }
    for (int i = f->first_corner; i < f->first_corner + f->corner_count; i++) {
        Vec3 v = o->mesh.vertices[o->model.corners[i]];
        if (fabs(v.x) <= MAPS_LIMIT && fabs(v.y) <= MAPS_LIMIT && fabs(v.z) <= MAPS_LIMIT) continue;
        return error_set(o->error, "%s:%d: a corner of a face lies at (%g, %g, %g) m (allowed: within %g m)",
                         o->path, f->line, v.x, v.y, v.z, MAPS_LIMIT);
    }
    return true;
}

static bool make_mesh(SoupObj *o) {
    const ObjModel *m = &o->model;
    o->mesh = (SoupMesh){.vertices = ARENA_ARRAY(o->arena, Vec3, m->vertex_count),
                         .corners = m->corners,
                         .faces = ARENA_ARRAY(o->arena, SoupFace, m->face_count),
                         .vertex_count = m->vertex_count,
                         .corner_count = m->corner_count,
                         .face_count = m->face_count};
    for (int i = 0; i < m->vertex_count; i++) {
        Vec3 v = m->vertices[i];
        o->mesh.vertices[i] = vec3_scale(o->how.z_up ? v : vec3(v.x, 0 - v.z, v.y), o->how.unit);
    }
    if (m->place_count > 0) o->mesh.places = ARENA_ARRAY(o->arena, Vec2, m->corner_count);
    o->mesh.textures = o->b->textures;
    for (int i = 0; i < m->face_count; i++) {
        const ObjFace *f = &m->faces[i];
        const ObjMaterial *material = &m->materials[f->material];
        if (!check_face(o, f)) return false;
        // A face without texture coordinates has the mean of the picture.
        Vec2 *places = o->mesh.places ? &o->mesh.places[f->first_corner] : NULL;
        bool pictured = places && material->texture > 0 && obj_places(m, f, places);
        for (int k = 0; pictured && k < f->corner_count; k++)
            places[k] = vec2(places[k].x * material->scale.x + material->offset.x,
                             1 - (places[k].y * material->scale.y + material->offset.y));
        // Faces of one group only are joined, so that objects keep their polygons, and only with a picture or only without.
        o->mesh.faces[i] = (SoupFace){f->first_corner, f->corner_count,
                                      2 * (f->group * m->material_count + f->material) + pictured,
                                      pictured ? material->texture : 0};
    }
    if (m->corner_count - 2 * m->face_count <= SOUP_MAX_POLYGONS) return true;
    return error_set(o->error, "%s: its faces make %d triangles (allowed: %d)", o->path,
                     m->corner_count - 2 * m->face_count, SOUP_MAX_POLYGONS);
}

static int material_of(SoupObj *o, int index) {
    if (o->materials[index] < 0) {
        const ObjMaterial *m = &o->model.materials[index];
        Material material = {
            .name = m->name, .reflectance = m->colour, .emission = m->emission, .alpha = m->alpha};
        if (m->texture > 0) texture_put(o->b, m->texture, &material);
        if (material.alpha >= 1) material.gloss = m->shininess;
        if (material.alpha >= 1 && m->mirror > 0) material_make_mirror(&material, m->mirror);
        if (!m->known) building_tally(&o->unknown, m->name, vec3(0, 0, 0));
        o->materials[index] = building_add_material(o->arena, o->b, material);
    }
    return o->materials[index];
}

// Faces by group, in the file's order within each: [face_count], and where each group begins, [group_count + 1].
static int *sort_by_group(const SoupObj *o, const SoupMesh *mesh, int **first) {
    int groups = o->model.group_count, kinds = 2 * o->model.material_count;
    int *begin = ARENA_ARRAY(o->arena, int, groups + 2),
        *order = ARENA_ARRAY(o->arena, int, mesh->face_count);
    for (int i = 0; i < mesh->face_count; i++) begin[mesh->faces[i].material / kinds + 2]++;
    for (int g = 0; g < groups; g++) begin[g + 2] += begin[g + 1];
    for (int i = 0; i < mesh->face_count; i++) order[begin[mesh->faces[i].material / kinds + 1]++] = i;
    *first = begin;
    return order;
}

// Each group becomes an object; returns how many faces had no area.
static int add_objects(SoupObj *o) {
    SoupMesh merged;
    soup_merge(&o->mesh, o->arena, &merged);
    int *first, *order = sort_by_group(o, &merged, &first), lost = 0;
    for (int g = 0; g < o->model.group_count; g++) {
        building_add_object(o->arena, o->b, OBJECT_FURNITURE, o->model.groups[g]);
        for (int i = first[g]; i < first[g + 1]; i++) {
            const SoupFace *f = &merged.faces[order[i]];
            Vec3 ring[SOUP_MAX_CORNERS];
            for (int k = 0; k < f->corner_count; k++)
                ring[k] = merged.vertices[merged.corners[f->first_corner + k]];
            int material = material_of(o, f->material / 2 % o->model.material_count);
            const Vec2 *places = f->texture > 0 ? &merged.places[f->first_corner] : NULL;
            lost += building_add_textured(o->arena, o->b, ring, places, f->corner_count, material) == 0;
        }
        if (o->b->objects[o->b->object_count - 1].polygon_count == 0) o->b->object_count--;
    }
    return lost;
}

static void note_losses(SoupObj *o, int lost) {
    Vec3 place = vec3(0, 0, 0);
    const ObjModel *m = &o->model;
    if (m->absent)
        building_note(o->arena, o->b, NOTE_DROPPED, place,
                      "%s: `%.100s` and perhaps other material libraries or images could not be read (looked "
                      "for in the file's own folder and below)",
                      o->path, m->absent);
    if (m->nameless > 0)
        building_note(o->arena, o->b, NOTE_DROPPED, place,
                      "%s: %d names of groups or materials beyond %d are not kept", o->path, m->nameless,
                      OBJ_MAX_NAMES);
    building_note_tally(o->arena, o->b, o->path, &o->unknown, OBJ_UNKNOWN_NOTE);
    if (lost > 0)
        building_note(o->arena, o->b, NOTE_DROPPED, place, "%s: %d faces have no area and were left out",
                      o->path, lost);
}

static bool read_file(void *context, const char *name, Arena *arena, Bytes *out) {
    Error ignored;
    return soup_read_beside(context, name, arena, out, &ignored);
}

// `library` and `resize`: see SoupReader and soup_finish.
static bool read_text(const char *path, Bytes content, Bytes library, const char *resize, Arena *arena,
                      Building *out, Error *error) {
    SoupObj o = {.path = path, .how = read_conventions(content), .arena = arena, .b = out, .error = error};
    SoupReader reader = {.path = path, .arena = arena, .b = out, .library = library};
    double pixels = TEXTURE_FREE_PIXELS;
    ObjFiles files = {read_file, &reader, &pixels, out};
    bool whole = obj_read(content, path, &files, arena, &o.model, error);
    // The line at fault says more than that nothing was left.
    if (o.model.fault) return error_set(error, "%s:%s", path, o.model.fault);
    if (!whole) return false;
    o.materials = ARENA_ARRAY(arena, int, o.model.material_count);
    for (int i = 0; i < o.model.material_count; i++) o.materials[i] = -1;
    if (!make_mesh(&o)) return false;
    note_losses(&o, add_objects(&o));
    return soup_finish(&reader, resize, error);
}

static bool read_obj(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    return read_text(path, content, (Bytes){0},
                     "a comment above the first vertex, such as `# unit 0.01`, says how many metres one is",
                     arena, out, error);
}

static bool read_foreign(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Bytes text, library;
    return foreign_as_obj(path, content, arena, &text, &library, error) &&
           read_text(path, text, library,
                     "3DS has no unit and counts as metres: scale the model before export", arena, out,
                     error);
}

// The first statement is one of OBJ.
static bool recognise_obj(Bytes content) {
    static const char *const WORDS[] = {"mtllib", "o", "g", "v", "vt", "vn", "s", "usemtl"};
    Scan s = scan_begin("", content);
    if (!scan_next_line(&s, '#')) return false;
    char quote[SCAN_QUOTE];
    const char *word = scan_quote(&s, quote);
    for (size_t i = 0; i < sizeof WORDS / sizeof *WORDS; i++) {
        if (strcmp(word, WORDS[i]) == 0) return true;
    }
    return false;
}

const MapsReader MAPS_READER_OBJ = {
    .name = "obj",
    .suffixes = ".obj",
    .summary = "Wavefront OBJ models of buildings: polygons alone",
    .recognise = recognise_obj,
    .read = read_obj,
};

const MapsReader MAPS_READER_FOREIGN = {
    .name = "foreign",
    .suffixes = ".dae .3ds",
    .summary = "COLLADA and 3DS models of buildings: polygons alone",
    .recognise = foreign_recognise,
    .read = read_foreign,
};
