// quads.c - `.quads`, scenes for tests of radiosity: quadrilaterals by name with a reflectance and an exitance, and
// points on them at which light is asked for.
//
//     quad NAME RHO EXITANCE x y z  x y z  x y z  x y z    counter-clockwise seen from the lit side
//     point NAME x y z nx ny nz QUAD
//
// Lengths are metres, z is up, exitances W/m^2. Points are checked and not kept: they belong to who asks.
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/building/reader.h"
#include "maps/building/scan.h"
#include "maps/polygons/soup_readers.h"

enum { MAX_QUADS = 1 << 20, MAX_POINTS = 1 << 20, MAX_NAME = 100 };
static const double MAX_EXITANCE = 1e9;  // W/m^2: the sun's surface is at 6e7
static const char COMMENT = '#';

// A name with where it stands: of a quad, or the quad that a point names.
typedef struct Named {
    const char *name;
    int line;
} Named;

typedef struct Quads {
    Scan scan;
    Arena *arena;
    Building *b;
    Error *error;
    Named *quads, *wanted;
    int quad_count, quad_capacity, wanted_count, wanted_capacity;
    SoupReader reader;
    int bent;
} Quads;

static bool read_name(Quads *q, const char *what, const char **out) {
    Scan *s = &q->scan;
    *out = scan_line_ends(s, COMMENT) ? NULL : scan_word(s, MAX_NAME, q->arena);
    if (*out) return true;
    char quote[SCAN_QUOTE];
    return error_set(q->error, "%s:%d: %s is `%s` (allowed: a word of 1 to %d bytes)", s->path, s->line, what,
                     scan_quote(s, quote), MAX_NAME);
}

static bool read_number(Quads *q, const char *what, double low, double high, double *out) {
    Scan *s = &q->scan;
    if (scan_number(s, low, high, out)) return true;
    char quote[SCAN_QUOTE];
    return error_set(q->error, "%s:%d: %s is `%s` (allowed %g to %g)", s->path, s->line, what,
                     scan_quote(s, quote), low, high);
}

static bool read_vector(Quads *q, const char *what, double limit, Vec3 *out) {
    return read_number(q, what, -limit, limit, &out->x) && read_number(q, what, -limit, limit, &out->y) &&
           read_number(q, what, -limit, limit, &out->z);
}

// Corners that turn against the quadrilateral as a whole: one of a concave one, two where it crosses itself.
static int dents(const Vec3 *v, Vec3 n) {
    int count = 0;
    for (int i = 0; i < 4; i++)
        count += polygon_corner_sine(v[i], v[(i + 1) % 4], v[(i + 2) % 4], n) < -POLYGON_COLLINEAR;
    return count;
}

static bool check_shape(Quads *q, const char *name, const Vec3 *v) {
    Scan *s = &q->scan;
    if (polygon_area(v, 4) <= MAPS_SMALLEST_AREA) {
        return error_set(q->error, "%s:%d: the quad %s has an area of %g m^2 (allowed: above %g)", s->path,
                         s->line, name, polygon_area(v, 4), MAPS_SMALLEST_AREA);
    }
    if (dents(v, plane_of_polygon(v, 4).n) > 1) {
        return error_set(q->error,
                         "%s:%d: the outline of the quad %s crosses itself (allowed: corners in order)",
                         s->path, s->line, name);
    }
    return true;
}

static bool add_material(Quads *q, const char *name, double rho, double exitance, int *out) {
    Scan *s = &q->scan;
    char words[64];
    snprintf(words, sizeof words, exitance > 0 ? "reflectance %g, exitance %g" : "reflectance %g", rho,
             exitance);
    float r = (float)rho, e = (float)exitance;
    Material material = {.name = words,
                         .reflectance = soup_cap(&q->reader, (Rgb){r, r, r}, MAPS_MAX_REFLECTANCE, name),
                         .emission = {e, e, e},
                         .alpha = 1};
    *out = building_add_material(q->arena, q->b, material);
    if (q->b->material_count <= SOUP_MAX_MATERIALS) return true;
    return error_set(q->error, "%s:%d: more than %d different pairs of reflectance and exitance", s->path,
                     s->line, SOUP_MAX_MATERIALS);
}

static bool read_quad(Quads *q) {
    Scan *s = &q->scan;
    const char *name;
    double rho, exitance;
    Vec3 v[4];
    int material;
    if (q->quad_count == MAX_QUADS)
        return error_set(q->error, "%s:%d: more than %d quads", s->path, s->line, MAX_QUADS);
    if (!read_name(q, "the name of a quad", &name) || !read_number(q, "the reflectance", 0, 1, &rho) ||
        !read_number(q, "the exitance", 0, MAX_EXITANCE, &exitance))
        return false;
    for (int i = 0; i < 4; i++) {
        if (!read_vector(q, "a coordinate", MAPS_LIMIT, &v[i])) return false;
    }
    if (!check_shape(q, name, v) || !add_material(q, name, rho, exitance, &material)) return false;
    *ARENA_PUSH(q->arena, q->quads, q->quad_count, q->quad_capacity) = (Named){name, s->line};
    building_add_object(q->arena, q->b, OBJECT_FURNITURE, name);
    q->bent += building_add_polygon(q->arena, q->b, v, 4, material) > 1;
    return true;
}

static bool read_point(Quads *q) {
    Scan *s = &q->scan;
    const char *name, *quad;
    Vec3 place, normal;
    if (q->wanted_count == MAX_POINTS)
        return error_set(q->error, "%s:%d: more than %d points", s->path, s->line, MAX_POINTS);
    if (!read_name(q, "the name of a point", &name) || !read_vector(q, "a coordinate", MAPS_LIMIT, &place) ||
        !read_vector(q, "a component of the normal", 1, &normal) ||
        !read_name(q, "the quad of a point", &quad))
        return false;
    *ARENA_PUSH(q->arena, q->wanted, q->wanted_count, q->wanted_capacity) = (Named){quad, s->line};
    return true;
}

static bool read_line(Quads *q) {
    Scan *s = &q->scan;
    char quote[SCAN_QUOTE];
    Scan before = *s;
    const char *word = scan_word(s, MAX_NAME, q->arena);
    bool quad = word && strcmp(word, "quad") == 0, point = word && strcmp(word, "point") == 0;
    if (!quad && !point) {
        return error_set(q->error, "%s:%d: begins with `%s` (allowed: quad, point)", s->path, s->line,
                         scan_quote(&before, quote));
    }
    if (!(quad ? read_quad(q) : read_point(q))) return false;
    if (scan_line_ends(s, COMMENT)) return true;
    return error_set(q->error, "%s:%d: found `%s` after the %s (expected the end of the line)", s->path,
                     s->line, scan_quote(s, quote), word);
}

static int by_name(const void *pa, const void *pb) {
    const Named *a = pa, *b = pb;
    int order = strcmp(a->name, b->name);
    return order != 0 ? order : a->line - b->line;
}

static int name_only(const void *pa, const void *pb) {
    return strcmp(((const Named *)pa)->name, ((const Named *)pb)->name);
}

// Quads are referred to by name, so there is one of each, and every point has one.
static bool check_names(Quads *q) {
    if (q->quad_count == 0) return true;
    qsort(q->quads, (size_t)q->quad_count, sizeof *q->quads, by_name);
    for (int i = 1; i < q->quad_count; i++) {
        if (name_only(&q->quads[i - 1], &q->quads[i]) != 0) continue;
        return error_set(q->error, "%s:%d: the quad %s was declared on line %d (allowed: one of each name)",
                         q->scan.path, q->quads[i].line, q->quads[i].name, q->quads[i - 1].line);
    }
    for (int i = 0; i < q->wanted_count; i++) {
        if (bsearch(&q->wanted[i], q->quads, (size_t)q->quad_count, sizeof *q->quads, name_only)) continue;
        return error_set(q->error, "%s:%d: a point lies on the quad %s (allowed: one of the file's %d quads)",
                         q->scan.path, q->wanted[i].line, q->wanted[i].name, q->quad_count);
    }
    return true;
}

static bool read_quads(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Quads q = {.scan = scan_begin(path, content),
               .reader = {.path = path, .arena = arena, .b = out},
               .arena = arena,
               .b = out,
               .error = error};
    while (scan_next_line(&q.scan, COMMENT)) {
        if (!read_line(&q)) return false;
    }
    if (!check_names(&q)) return false;
    if (q.bent > 0)
        building_note(arena, out, NOTE_CHANGED, out->vertices[0],
                      "%s: %d quads are bent or concave and were cut into triangles", path, q.bent);
    return soup_finish(&q.reader, "lengths in a .quads file are metres", error);
}

static bool recognise_quads(Bytes content) {
    Scan s = scan_begin("", content);
    if (!scan_next_line(&s, COMMENT)) return false;
    char quote[SCAN_QUOTE];
    const char *word = scan_quote(&s, quote);
    return strcmp(word, "quad") == 0 || strcmp(word, "point") == 0;
}

const MapsReader MAPS_READER_QUADS = {
    .name = "quads",
    .suffixes = ".quads",
    .summary = "quadrilaterals with reflectance and exitance, for tests of radiosity",
    .recognise = recognise_quads,
    .read = read_quads,
};
