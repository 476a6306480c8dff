// path_guide.c - histograms of the light that walks find, as Vorba, Karlik, Sik, Ritschel & Krivanek (2014, On-line Learning of
// Parametric Mixture Models for Light Transport Simulation) guide walks by mixtures. Here a histogram divides the numbers from which
// path_direction makes directions, so that it multiplies the density of cosines. Directions are learned of the sky, and of sunlight that
// a surface reflects; both are asked for as lamps are, because walks whose own directions were guided scattered more: their weights grow
// from bounce to bounce. Groups of lamps are chosen in proportion to the root of the mean square of their light, which leaves the least
// scatter.
#include "radiosity/truth/path_guide.h"

#include <string.h>

// The share of directions asked for that nothing learned changes.
static const double UNLEARNED = 0.2;
// A bin has this share of the light of each of its neighbours, too, since few walks find it.
static const double SPREAD = 0.1;
// A place is guided after so many walks.
enum { FEWEST_WALKS = 64 };
// The edge of the grid's cubes, metres, and about how many there are at most.
static const double EDGE = 0.5, MOST_CUBES = 8000;
enum { SLOTS = 1 << 16, MOST_PLACES = SLOTS / 4 };

struct PathGuide {
    double edge;
    uint64_t *key;  // [SLOTS] 0: empty
    int *place;     // [SLOTS] in `tally` and `shares`
    PathTally *tally;
    PathShares *shares;
    int count, shared;  // places below `shared` have shares
};

// ---- shares

static int find(const float *cumulated, int count, double u) {
    int low = 0;
    while (count > 1) {
        int half = count / 2;
        if (u >= (double)cumulated[low + half]) {
            low += half;
            count -= half;
        } else {
            count = half;
        }
    }
    return low;
}

// Stretches a share to [0, 1), and returns its width.
static double stretch(const float *cumulated, int index, double *u) {
    double from = (double)cumulated[index], width = (double)cumulated[index + 1] - from;
    *u = fmin(fmax((*u - from) / width, 0), 1 - 1e-12);
    return width;
}

double path_shares_warp(const PathShares *shares, double *u, double *v) {
    int row = find(shares->row, GUIDE_ROWS, *u);
    double high = stretch(shares->row, row, u);
    int column = find(shares->column[row], GUIDE_COLUMNS, *v);
    double wide = stretch(shares->column[row], column, v);
    *u = (row + *u) / GUIDE_ROWS;
    *v = (column + *v) / GUIDE_COLUMNS;
    return high * wide * GUIDE_BINS;
}

static int row_of(double u) { return (int)fmin(fmax(u * GUIDE_ROWS, 0), GUIDE_ROWS - 1); }
static int column_of(double v) { return (int)fmin(fmax(v * GUIDE_COLUMNS, 0), GUIDE_COLUMNS - 1); }

double path_shares_density(const PathShares *shares, double u, double v) {
    int row = row_of(u), column = column_of(v);
    double high = (double)shares->row[row + 1] - (double)shares->row[row];
    return high * GUIDE_BINS *
           ((double)shares->column[row][column + 1] - (double)shares->column[row][column]);
}

int path_shares_lamp(const PathShares *shares, double *u) {
    int group = find(shares->lamp, PATH_LAMP_GROUPS, *u);
    stretch(shares->lamp, group, u);
    return group;
}

int path_guide_bin(double u, double v) { return row_of(u) * GUIDE_COLUMNS + column_of(v); }

void path_tally_add(PathTally *tally, const PathStep *step) {
    tally->walks++;
    for (int k = 0; k < 2; k++) tally->day[step->bin[k]] += step->day[k];
    if (step->group >= 0) tally->lamp[step->group] += step->lamp;
}

// `share` sums to anything above 0.
static void cumulate(const double *share, int count, float *out) {
    double sum = 0, before = 0;
    for (int i = 0; i < count; i++) sum += share[i];
    for (int i = 0; i < count; i++) {
        out[i] = (float)(before / sum);
        before += share[i];
    }
    out[count] = 1;
}

static double spread_day(const PathTally *tally, int bin) {
    int row = bin / GUIDE_COLUMNS, column = bin % GUIDE_COLUMNS;
    double sum = tally->day[bin];
    for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < GUIDE_ROWS; r++)
        for (int c = column + GUIDE_COLUMNS - 1; c <= column + GUIDE_COLUMNS + 1; c++)
            sum += SPREAD * tally->day[r * GUIDE_COLUMNS + c % GUIDE_COLUMNS];
    return sum;
}

void path_tally_shares(const PathTally *tally, PathShares *out) {
    double bin[GUIDE_BINS], row[GUIDE_ROWS] = {0}, lamp[PATH_LAMP_GROUPS], day = 0, lamps = 0;
    for (int i = 0; i < GUIDE_BINS; i++) day += bin[i] = spread_day(tally, i);
    out->day = day > 0;
    for (int i = 0; i < GUIDE_BINS && out->day; i++) {
        bin[i] = UNLEARNED / GUIDE_BINS + (1 - UNLEARNED) * bin[i] / day;
        row[i / GUIDE_COLUMNS] += bin[i];
    }
    if (out->day) cumulate(row, GUIDE_ROWS, out->row);
    for (int r = 0; r < GUIDE_ROWS && out->day; r++)
        cumulate(bin + r * GUIDE_COLUMNS, GUIDE_COLUMNS, out->column[r]);
    for (int g = 0; g < PATH_LAMP_GROUPS; g++) lamps += lamp[g] = sqrt(tally->lamp[g]);
    out->lamps = lamps > 0;
    if (out->lamps) cumulate(lamp, PATH_LAMP_GROUPS, out->lamp);
}

// ---- places

PathGuide *path_guide_new(const Mesh *mesh, Arena *arena) {
    PathGuide *guide = ARENA_ARRAY(arena, PathGuide, 1);
    double area = 0;
    for (int e = 0; e < mesh->element_count; e++) area += mesh->elements[e].area;
    guide->edge = fmax(EDGE, sqrt(area / MOST_CUBES));
    guide->key = ARENA_ARRAY(arena, uint64_t, SLOTS);
    guide->place = ARENA_ARRAY(arena, int, SLOTS);
    guide->tally = ARENA_ARRAY(arena, PathTally, MOST_PLACES);
    guide->shares = ARENA_ARRAY(arena, PathShares, MOST_PLACES);
    return guide;
}

// The way that a surface faces, of those for which path_direction takes the same axes.
static uint64_t facing(Vec3 n) {
    if (fabs(n.z) >= 0.9) return n.z > 0;
    if (fabs(n.x) >= fabs(n.y) && fabs(n.x) >= fabs(n.z)) return 2 + (n.x > 0);
    return fabs(n.y) >= fabs(n.z) ? 4 + (n.y > 0) : 6 + (n.z > 0);
}

static uint64_t along(const PathGuide *guide, double x) {
    return (uint64_t)fmin(fmax(floor(x / guide->edge) + 0x8000, 0), 0xffff);
}

static uint64_t key_of(const PathGuide *guide, const PathPlace *place) {
    Vec3 p = place->point;
    uint64_t cube = (along(guide, p.x) << 16 | along(guide, p.y)) << 16 | along(guide, p.z);
    return 1 + (cube << 3 | facing(place->normal));
}

// The slot of a key, or the empty one where it would be.
static int slot_of(const PathGuide *guide, uint64_t key) {
    int slot = (int)(key * 0x9e3779b97f4a7c15u >> 48);
    while (guide->key[slot] != 0 && guide->key[slot] != key) slot = (slot + 1) % SLOTS;
    return slot;
}

const PathShares *path_guide_at(const PathGuide *guide, const PathPlace *place) {
    int slot = slot_of(guide, key_of(guide, place));
    if (guide->key[slot] == 0) return NULL;
    int at = guide->place[slot];
    return at < guide->shared && guide->tally[at].walks >= FEWEST_WALKS ? &guide->shares[at] : NULL;
}

void path_guide_add(PathGuide *guide, const PathStep *steps, int count) {
    for (int i = 0; i < count; i++) {
        uint64_t key = key_of(guide, &steps[i].place);
        int slot = slot_of(guide, key);
        if (guide->key[slot] == 0) {
            if (guide->count == MOST_PLACES) continue;
            guide->key[slot] = key;
            guide->place[slot] = guide->count++;
        }
        path_tally_add(&guide->tally[guide->place[slot]], &steps[i]);
    }
}

void path_guide_share(PathGuide *guide) {
    for (int i = 0; i < guide->count; i++) path_tally_shares(&guide->tally[i], &guide->shares[i]);
    guide->shared = guide->count;
}
