// sh3d_attributes.c - the helpers of all parts of the reader: attributes of elements as numbers, lengths, angles, texts and colours,
// the level that an element names, and points of the sketch.
#include "maps/sweethome/sh3d.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double QUARTER_SLACK = 1e-5;  // radians: 1.7e-7 instead of 0 is common in files

bool sh3d_fail(Sh3d *s, const XmlNode *node, const char *format, ...) {
    if (s->failed) return false;
    char what[400];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    s->failed = true;
    return error_set(s->error, "%s:%d: %s %s", s->where, node->line, node->name, what);
}

double sh3d_number(Sh3d *s, const XmlNode *node, const char *name, double missing, double low, double high) {
    const char *text = xml_get(node, name);
    if (!text) {
        if (isnan(missing)) sh3d_fail(s, node, "has no attribute %s (a number is needed)", name);
        return isnan(missing) ? 0 : missing;
    }
    char *stop;
    double value = strtod(text, &stop);
    while (isspace((unsigned char)*stop)) stop++;
    if (stop == text || *stop || !(value >= low && value <= high)) {
        sh3d_fail(s, node, "has %s='%.40s' (a number from %g to %g is allowed)", name, text, low, high);
        return 0;
    }
    return value;
}

double sh3d_length(Sh3d *s, const XmlNode *node, const char *name, double missing) {
    return SH3D_CM * sh3d_number(s, node, name, missing, 0, SH3D_MAX_LENGTH);
}

double sh3d_coordinate(Sh3d *s, const XmlNode *node, const char *name, double missing) {
    return SH3D_CM * sh3d_number(s, node, name, missing, -SH3D_MAX_COORDINATE, SH3D_MAX_COORDINATE);
}

double sh3d_angle(Sh3d *s, const XmlNode *node, const char *name) {
    double angle = -sh3d_number(s, node, name, 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
    double quarters = angle / (M_PI / 2);
    if (fabs(angle - nearbyint(quarters) * (M_PI / 2)) >= QUARTER_SLACK) return angle;
    return nearbyint(quarters) * (M_PI / 2) + 0.0;  // no negative zero
}

bool sh3d_flag(const XmlNode *node, const char *name, bool missing) {
    const char *text = xml_get(node, name);
    return text ? strcmp(text, "true") == 0 : missing;
}

const char *sh3d_text(const XmlNode *node, const char *name) {
    const char *text = xml_get(node, name);
    return text ? text : "";
}

const char *sh3d_place(Sh3d *s, const XmlNode *node, const char *what) {
    const char *id = sh3d_text(node, "id"), *name = sh3d_text(node, "name");
    const char *label =
        *id && strlen(id) < 24 ? id : name;  // long ids are random and say less than the place
    return arena_format(s->arena, "%s %s%s(%s %d)", what, label, *label ? " " : "", s->unit, node->line);
}

bool sh3d_colour(Sh3d *s, const XmlNode *node, const char *name, unsigned *rgb) {
    const char *text = xml_get(node, name);
    if (!text) return false;
    char *stop;
    unsigned long value = strtoul(text, &stop, 16);
    if (strlen(text) > 8 || stop == text || *stop || !isxdigit((unsigned char)*text)) {
        sh3d_fail(s, node, "has %s='%.40s' (up to eight hexadecimal digits AARRGGBB are allowed)", name,
                  text);
        return false;
    }
    *rgb = (unsigned)(value & 0xFFFFFF);
    return true;
}

int sh3d_add_colour(Sh3d *s, const char *name, Rgb colour) {
    return building_add_material(s->arena, s->b, (Material){.name = name, .reflectance = colour, .alpha = 1});
}

double sh3d_shininess(Sh3d *s, const XmlNode *node, const char *name, double missing) {
    return fmin(fmax(sh3d_number(s, node, name, missing, -1e6, 1e6), 0), 1);
}

const Sh3dLevel *sh3d_level(Sh3d *s, const XmlNode *node) {
    const char *id = xml_get(node, "level");
    if (!id) return &s->levels[0];
    for (int i = 0; i < s->level_count; i++)
        if (s->levels[i].id && strcmp(s->levels[i].id, id) == 0) return &s->levels[i];
    sh3d_fail(s, node, "refers to level '%.40s', which the file does not have", id);
    return &s->levels[0];
}

int sh3d_add_point(Sh3d *s, Vec2 point, int material) {
    Sketch *k = s->sketch;
    k->points = arena_grow(s->arena, k->points, k->point_count, &k->point_capacity, sizeof *k->points);
    k->edge_material =
        arena_grow(s->arena, k->edge_material, k->point_count, &k->edge_capacity, sizeof *k->edge_material);
    k->points[k->point_count] = point;
    k->edge_material[k->point_count] = material;
    return k->point_count++;
}

bool sh3d_has_word(const XmlNode *node, const char *const *words) {
    const char *name = sh3d_text(node, "name"), *id = sh3d_text(node, "catalogId");
    for (int i = 0; words[i]; i++)
        if (strcasestr(name, words[i]) || strcasestr(id, words[i])) return true;
    return false;
}
