// ldt.c - EULUMDAT files (A. W. Stockmar, EULUMDAT - ein Leuchtendatenformat fuer den europaeischen Beleuchtungsplaner, 1990).
//
// A value a line, in a fixed order; decimals have a point or a comma. Intensities are cd for 1000 lm of the lamps, of which the first
// set counts; the file's conversion factor multiplies them (0 counts as 1). The light output ratio is not needed: the table has it in
// itself; it is kept to be compared. The length of the opening lies along C90, its width along C0; a width of 0 is that of a disc.
#include "maps/photometry/photometry_file.h"

enum { MOST_SETS = 20, RATIOS = 10, NO_SYMMETRY = 0, ROUND, TO_C0, TO_C90, TO_BOTH };

typedef struct Ldt {
    Scan scan;
    Error *error;
} Ldt;

// Begins the next line; false at the end of the file.
static void end_line(Ldt *f) {
    Scan *s = &f->scan;
    while (s->at < s->end && *s->at != '\n') s->at++;
    if (s->at == s->end) return;
    s->at++;
    s->line++;
}

static void skip(Ldt *f, int lines) {
    while (lines-- > 0) end_line(f);
}

static bool number_line(Ldt *f, const char *what, double low, double high, double *out) {
    if (!photometry_number(&f->scan, what, low, high, out, f->error)) return false;
    end_line(f);
    return true;
}

static bool whole_line(Ldt *f, const char *what, int low, int high, int *out) {
    if (!photometry_whole(&f->scan, what, low, high, out, f->error)) return false;
    end_line(f);
    return true;
}

// Lumens of the lamps of the first set.
static bool read_sets(Ldt *f, double *lumens) {
    int sets;
    if (!whole_line(f, "the number of sets of lamps", 1, MOST_SETS, &sets)) return false;
    skip(f, 2);  // number and type of lamps
    if (!number_line(f, "the flux of the lamps in lumens", -1e9, 1e9, lumens)) return false;
    skip(f, 3 + 6 * (sets - 1));
    skip(f, RATIOS);
    *lumens = fabs(*lumens);
    return true;
}

// How many planes are listed, and which is the first.
static int planes_listed(int symmetry, int planes, int *first) {
    *first = 0;
    switch (symmetry) {
    case ROUND:
        return 1;
    case TO_C0:
        return planes / 2 + 1;
    case TO_C90:
        *first = 3 * (planes / 4);
        return planes / 2 + 1;
    case TO_BOTH:
        return planes / 4 + 1;
    default:
        return planes;
    }
}

static bool check_planes(const Ldt *f, int symmetry, int planes) {
    int parts = symmetry == TO_C0 ? 2 : symmetry == TO_C90 || symmetry == TO_BOTH ? 4 : 1;
    if (planes % parts == 0) return true;
    return error_set(f->error, "%s:%d: %d planes with the symmetry %d (allowed: a multiple of %d)",
                     f->scan.path, f->scan.line, planes, symmetry, parts);
}

static bool read_angles(Ldt *f, const char *what, double high, int count, double *out) {
    for (int i = 0; i < count; i++) {
        int line = f->scan.line;
        if (!number_line(f, what, 0, high, &out[i])) return false;
        if (i > 0 && !(out[i] > out[i - 1]))
            return error_set(f->error, "%s:%d: %s is `%g` after %g (allowed: above that)", f->scan.path, line,
                             what, out[i], out[i - 1]);
    }
    return true;
}

static bool read_table(Ldt *f, int symmetry, int planes, double factor, Arena *arena, Photometry *t) {
    int first;
    t->plane_count = planes_listed(symmetry, planes, &first);
    long values = (long)t->gamma_count * t->plane_count;
    // Each value has a digit and a line's end, so a short file asks for little memory.
    if (values > (f->scan.end - f->scan.at) / 2 + 1)
        return error_set(f->error, "%s:%d: %d by %d intensities are more than the file has room for",
                         f->scan.path, f->scan.line, t->gamma_count, t->plane_count);
    double *angle = ARENA_ARRAY(arena, double, planes);
    t->gamma = ARENA_ARRAY(arena, double, t->gamma_count);
    t->plane = ARENA_ARRAY(arena, double, t->plane_count);
    t->candela = ARENA_ARRAY(arena, double, values);
    if (!read_angles(f, "the angle of a plane", 360, planes, angle) ||
        !read_angles(f, "an angle in the planes", 180, t->gamma_count, t->gamma))
        return false;
    for (int i = 0; i < t->plane_count; i++) {
        int k = (first + i) % planes;
        t->plane[i] = angle[k] - (first > 0 && k >= first ? 360 : 0);
    }
    for (long i = 0; i < values; i++) {
        if (!number_line(f, "an intensity", 0, PHOTOMETRY_MAX_CANDELA, &t->candela[i])) return false;
        t->candela[i] *= factor;
    }
    return true;
}

bool photometry_read_ldt(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error) {
    for (size_t i = 0; i < content.size; i++)
        if (content.data[i] == ',') content.data[i] = '.';
    Ldt f = {scan_begin(path, content), error};
    int type, symmetry, planes;
    double step, length, width, ratio, factor, lumens;
    const double millimetre = 0.001, most = 1e6;
    static const PhotometryAround AROUND[] = {PHOTOMETRY_WHOLE, PHOTOMETRY_ROUND, PHOTOMETRY_HALF,
                                              PHOTOMETRY_SIDE, PHOTOMETRY_QUARTER};
    *out = (Photometry){0};
    skip(&f, 1);
    if (!whole_line(&f, "the type of luminaire", 0, 3, &type) ||
        !whole_line(&f, "the symmetry", 0, 4, &symmetry) ||
        !whole_line(&f, "the number of planes", 1, PHOTOMETRY_MAX_ANGLES, &planes) ||
        !check_planes(&f, symmetry, planes) || !number_line(&f, "the step of planes", 0, 360, &step) ||
        !whole_line(&f, "the number of angles in a plane", 2, PHOTOMETRY_MAX_ANGLES, &out->gamma_count) ||
        !number_line(&f, "the step of angles", 0, 180, &step))
        return false;
    skip(&f, 8);  // report, name, number, file, date; length, width and height of the luminaire
    if (!number_line(&f, "the length of the opening", 0, most, &length) ||
        !number_line(&f, "the width of the opening", 0, most, &width))
        return false;
    skip(&f, 5);  // heights of the opening, downward fraction
    if (!number_line(&f, "the light output ratio", 0, 1000, &ratio) ||
        !number_line(&f, "the conversion factor", 0, 1e6, &factor))
        return false;
    skip(&f, 1);  // tilt
    if (!read_sets(&f, &lumens)) return false;
    double disc = width == 0 ? sqrt(M_PI) / 2 : 1;
    out->size[1] = disc * millimetre * length;
    out->size[0] = width == 0 ? out->size[1] : millimetre * width;
    out->stated = ratio / 100 * lumens;
    factor = (factor == 0 ? 1 : factor) * lumens / 1000;
    return read_table(&f, symmetry, planes, factor, arena, out) &&
           photometry_finish(path, AROUND[symmetry], arena, out, error);
}
