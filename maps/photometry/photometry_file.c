// photometry_file.c - the parts that both readers share: numbers and symmetry.
#include "maps/photometry/photometry_file.h"

#include <stdlib.h>
#include <string.h>

bool photometry_number(Scan *s, const char *what, double low, double high, double *out, Error *error) {
    if (scan_number(s, low, high, out)) return true;
    char quote[SCAN_QUOTE];
    return error_set(error, "%s:%d: %s is `%s` (allowed %g to %g)", s->path, s->line, what,
                     scan_quote(s, quote), low, high);
}

bool photometry_whole(Scan *s, const char *what, int low, int high, int *out, Error *error) {
    Scan before = *s;
    char quote[SCAN_QUOTE];
    double value;
    if (!photometry_number(s, what, low, high, &value, error)) return false;
    *out = (int)value;
    if (value == *out) return true;
    return error_set(error, "%s:%d: %s is `%s` (allowed: a whole number)", s->path, s->line, what,
                     scan_quote(&before, quote));
}

// ---- symmetry

// A plane of the whole turn, and which of those listed has its intensities.
typedef struct Turned {
    double angle;
    int listed;
} Turned;

static int by_angle(const void *a, const void *b) {
    const Turned *p = a, *q = b;
    if (p->angle != q->angle) return p->angle < q->angle ? -1 : 1;
    return p->listed - q->listed;
}

// Lists the plane and its mirror images, 0 to 360.
static int turn_plane(PhotometryAround around, double angle, int listed, Turned *out) {
    double images[4] = {angle};
    int count = 1;
    if (around == PHOTOMETRY_HALF || around == PHOTOMETRY_QUARTER) images[count++] = -angle;
    if (around == PHOTOMETRY_SIDE || around == PHOTOMETRY_QUARTER) images[count++] = 180 - angle;
    if (around == PHOTOMETRY_QUARTER) images[count++] = 180 + angle;
    for (int i = 0; i < count; i++) out[i] = (Turned){images[i] - 360 * floor(images[i] / 360), listed};
    return count;
}

// The planes of a whole turn, the first once more at the end.
static void complete(PhotometryAround around, Arena *arena, Photometry *t) {
    Arena scratch = {0};
    Turned *turned = ARENA_ARRAY(&scratch, Turned, 4 * t->plane_count + 1);
    int count = 0, kept = 0, rows = t->gamma_count;
    for (int i = 0; i < t->plane_count; i++) count += turn_plane(around, t->plane[i], i, turned + count);
    qsort(turned, (size_t)count, sizeof *turned, by_angle);
    for (int i = 0; i < count; i++)
        if (kept == 0 || turned[i].angle > turned[kept - 1].angle) turned[kept++] = turned[i];
    turned[kept++] = (Turned){turned[0].angle + 360, turned[0].listed};
    double *plane = ARENA_ARRAY(arena, double, kept), *candela = ARENA_ARRAY(arena, double, (long)kept *rows);
    for (int i = 0; i < kept; i++) {
        plane[i] = turned[i].angle;
        memcpy(candela + (long)i * rows, t->candela + (long)turned[i].listed * rows,
               (size_t)rows * sizeof *candela);
    }
    t->plane = plane;
    t->candela = candela;
    t->plane_count = kept;
    arena_free(&scratch);
}

bool photometry_finish(const char *path, PhotometryAround around, Arena *arena, Photometry *t, Error *error) {
    // A file that lists C0 and C360 may have measured both.
    bool whole = around == PHOTOMETRY_WHOLE && t->plane[t->plane_count - 1] - t->plane[0] == 360;
    if (around == PHOTOMETRY_ROUND)
        t->plane_count = 1;
    else if (!whole)
        complete(around, arena, t);
    t->name = arena_string(arena, path);
    photometry_integrate(t);
    double lumens = photometry_lumens(t);
    if (lumens > 0 && isfinite(lumens)) return true;
    return error_set(error, "%s: its table sends %g lumens (allowed: above 0)", path, lumens);
}
