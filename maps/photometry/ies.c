// ies.c - IES files: ANSI/IES LM-63 of 1986, 1991, 1995, 2002 and 2019, photometry of type C.
//
// Lines of keywords end at the line `TILT=`. All that follows are numbers, wherever lines end:
//
//     lamps, lumens a lamp (-1: absolute), multiplier, vertical and horizontal angles, type (1: C), unit (1: feet, 2: metres),
//     width, length and height of the opening; ballast factor, a second factor, watts; the angles, then the intensities
//
// The width of the opening lies along C90, its length along C0; below 0 they are diameters. The second factor multiplies intensities up
// to 1995; later editions use its place for other things. The last horizontal angle tells the symmetry.
#include <string.h>

#include "maps/photometry/photometry_file.h"

static const double FOOT = 0.3048;
// Editions of which the second factor multiplies; a file that names no edition is of 1986.
static const char *const WITH_FACTOR[] = {"IESNA:LM-63-1986", "IESNA:LM-63-1991", "IESNA91",
                                          "IESNA:LM-63-1995"};

typedef struct Ies {
    Scan scan;
    Error *error;
} Ies;

static bool starts(const Scan *s, const char *word) {
    size_t length = strlen(word);
    return (size_t)(s->end - s->at) >= length && memcmp(s->at, word, length) == 0;
}

static bool next_line(Scan *s) {
    while (s->at < s->end && *s->at != '\n') s->at++;
    if (s->at == s->end) return false;
    s->at++;
    s->line++;
    return true;
}

// The next number, on this line or a later one.
static bool ies_number(Ies *f, const char *what, double low, double high, double *out) {
    scan_next_line(&f->scan, 0);
    return photometry_number(&f->scan, what, low, high, out, f->error);
}

static bool ies_whole(Ies *f, const char *what, int low, int high, int *out) {
    scan_next_line(&f->scan, 0);
    return photometry_whole(&f->scan, what, low, high, out, f->error);
}

// Skips to the numbers. `factor`: does the second factor multiply?
static bool read_head(Ies *f, bool *factor) {
    Scan *s = &f->scan;
    *factor = !starts(s, "IES");
    for (size_t i = 0; i < sizeof WITH_FACTOR / sizeof *WITH_FACTOR; i++)
        *factor = *factor || starts(s, WITH_FACTOR[i]);
    while (scan_blanks(s), !starts(s, "TILT="))
        if (!next_line(s))
            return error_set(f->error, "%s:%d: the file ends before a line `TILT=` (allowed: one)", s->path,
                             s->line);
    return true;
}

// A lamp's flux by the tilt of its luminaire: lamps hang as they were measured, without a tilt.
static bool read_tilt(Ies *f, double *factor) {
    Scan *s = &f->scan;
    *factor = 1;
    s->at += strlen("TILT=");
    if (starts(s, "NONE")) return next_line(s), true;
    char quote[SCAN_QUOTE];
    if (!starts(s, "INCLUDE"))
        return error_set(f->error, "%s:%d: TILT is `%s` (allowed: NONE, INCLUDE)", s->path, s->line,
                         scan_quote(s, quote));
    next_line(s);
    int geometry, count;
    double tilt = 0, share;
    bool upright = false;
    if (!ies_whole(f, "the lamp's geometry", 1, 3, &geometry) ||
        !ies_whole(f, "the number of tilts", 1, PHOTOMETRY_MAX_ANGLES, &count))
        return false;
    for (int i = 0; i < count; i++) {
        if (!ies_number(f, "a tilt", tilt, 180, &tilt)) return false;
        upright = upright || (i == 0 && tilt == 0);
    }
    for (int i = 0; i < count; i++) {
        if (!ies_number(f, "a factor of a tilt", 0, 1000, &share)) return false;
        if (i == 0 && upright) *factor = share;
    }
    return true;
}

static bool read_angles(Ies *f, const char *what, double high, int count, double *out) {
    for (int i = 0; i < count; i++) {
        if (!ies_number(f, what, 0, high, &out[i])) return false;
        if (i > 0 && !(out[i] > out[i - 1]))
            return error_set(f->error, "%s:%d: %s is `%g` after %g (allowed: above that)", f->scan.path,
                             f->scan.line, what, out[i], out[i - 1]);
    }
    return true;
}

static bool find_symmetry(const Ies *f, const Photometry *t, PhotometryAround *out) {
    double first = t->plane[0], last = t->plane[t->plane_count - 1];
    if (t->plane_count == 1 && last == 0)
        *out = PHOTOMETRY_ROUND;
    else if (first == 0 && last == 90)
        *out = PHOTOMETRY_QUARTER;
    else if (first == 0 && last == 180)
        *out = PHOTOMETRY_HALF;
    else if (first == 90 && last == 270)
        *out = PHOTOMETRY_SIDE;
    else if (first == 0 && last == 360)
        *out = PHOTOMETRY_WHOLE;
    else
        return error_set(
            f->error,
            "%s:%d: the horizontal angles go from %g to %g (allowed: 0 alone, 0 to 90, 0 to 180, 0 "
            "to 360, 90 to 270)",
            f->scan.path, f->scan.line, first, last);
    return true;
}

// Width and length of the opening; round ones as the rectangle of the same area.
static void set_size(Photometry *t, double width, double length, double unit) {
    bool round = width < 0 || length < 0;
    double w = fabs(width) * unit, l = length == 0 && round ? w : fabs(length) * unit;
    double share = round ? sqrt(M_PI) / 2 : 1;
    t->size[0] = share * l;
    t->size[1] = share * w;
}

static bool type_is_c(const Ies *f, int type) {
    static const char *const NAMES[] = {"", "C", "B", "A"};
    if (type == 1) return true;
    return error_set(f->error, "%s:%d: the photometry is of type %s, %d (allowed: type C, 1)", f->scan.path,
                     f->scan.line, NAMES[type], type);
}

static bool read_table(Ies *f, double factor, bool second_counts, Arena *arena, Photometry *t) {
    double lamps, lumens, multiplier, width, length, height, ballast, second, watts;
    int type, unit;
    const double most = 1000;
    if (!ies_number(f, "the number of lamps", -1e6, 1e6, &lamps) ||
        !ies_number(f, "the lumens of a lamp", -1e9, 1e9, &lumens) ||
        !ies_number(f, "the multiplier of intensities", 0, 1e9, &multiplier) ||
        !ies_whole(f, "the number of vertical angles", 2, PHOTOMETRY_MAX_ANGLES, &t->gamma_count) ||
        !ies_whole(f, "the number of horizontal angles", 1, PHOTOMETRY_MAX_ANGLES, &t->plane_count) ||
        !ies_whole(f, "the type of photometry", 1, 3, &type) || !type_is_c(f, type) ||
        !ies_whole(f, "the unit of lengths", 1, 2, &unit) ||
        !ies_number(f, "the width", -most, most, &width) ||
        !ies_number(f, "the length", -most, most, &length) ||
        !ies_number(f, "the height", -most, most, &height) ||
        !ies_number(f, "the ballast factor", 0, 1000, &ballast) ||
        !ies_number(f, "the second factor", 0, 1000, &second) ||
        !ies_number(f, "the watts", -1e9, 1e9, &watts))
        return false;
    set_size(t, width, length, unit == 1 ? FOOT : 1);
    factor *= multiplier * ballast * (second_counts ? second : 1);
    long values = (long)t->gamma_count * t->plane_count;
    // Each number has a digit and a blank, so a short file asks for little memory.
    if (values > (f->scan.end - f->scan.at) / 2 + 1)
        return error_set(f->error, "%s:%d: %d by %d intensities are more than the file has room for",
                         f->scan.path, f->scan.line, t->gamma_count, t->plane_count);
    t->gamma = ARENA_ARRAY(arena, double, t->gamma_count);
    t->plane = ARENA_ARRAY(arena, double, t->plane_count);
    t->candela = ARENA_ARRAY(arena, double, values);
    if (!read_angles(f, "a vertical angle", 180, t->gamma_count, t->gamma) ||
        !read_angles(f, "a horizontal angle", 360, t->plane_count, t->plane))
        return false;
    for (long i = 0; i < values; i++) {
        if (!ies_number(f, "an intensity", 0, PHOTOMETRY_MAX_CANDELA, &t->candela[i])) return false;
        t->candela[i] *= factor;
    }
    return true;
}

bool photometry_read_ies(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error) {
    // Commas part numbers as blanks do.
    for (size_t i = 0; i < content.size; i++)
        if (content.data[i] == ',') content.data[i] = ' ';
    Ies f = {scan_begin(path, content), error};
    bool second;
    double factor;
    PhotometryAround around = PHOTOMETRY_WHOLE;
    *out = (Photometry){0};
    return read_head(&f, &second) && read_tilt(&f, &factor) && read_table(&f, factor, second, arena, out) &&
           find_symmetry(&f, out, &around) && photometry_finish(path, around, arena, out, error);
}
