// path_guide.h - what walks learn of a scene: from which directions the day, and which lamps, light a place. Later walks choose by
// these shares, which leaves their mean alone and makes their scatter smaller.
#ifndef RADIOSITY_PATH_GUIDE_H
#define RADIOSITY_PATH_GUIDE_H

#include "radiosity/truth/path_walk.h"

// Directions by the two numbers that path_direction takes: rows by u, columns by v.
enum { GUIDE_ROWS = 8, GUIDE_COLUMNS = 16, GUIDE_BINS = GUIDE_ROWS * GUIDE_COLUMNS };

// The shares with which walks choose at one place. Each rises from 0 to 1.
typedef struct PathShares {
    float row[GUIDE_ROWS + 1], column[GUIDE_ROWS][GUIDE_COLUMNS + 1];
    float lamp[PATH_LAMP_GROUPS + 1];
    bool day, lamps;  // any light came from the day, straight from lamps; else their shares are not set
} PathShares;

// The light that walks met at one place: sums of the light of the day (of the sky, or of the sun, reflected once), and of squares of the
// light of lamps, over the density of the choices that led to it.
typedef struct PathTally {
    double day[GUIDE_BINS], lamp[PATH_LAMP_GROUPS];
    int walks;
} PathTally;

// Stores the numbers of a direction by the shares in *u and *v, which are uniform in [0, 1), and returns the density of the choice
// over that of path_direction.
double path_shares_warp(const PathShares *shares, double *u, double *v);
double path_shares_density(const PathShares *shares, double u, double v);
// The group of lamps that `*u` chooses; *u becomes uniform in [0, 1) again.
int path_shares_lamp(const PathShares *shares, double *u);

// The light that one walk met at a surface.
typedef struct PathStep {
    PathPlace place;
    int bin[2],
        group;  // of the direction, and of the one that was asked for; of the lamp that was asked for, -1: none
    double day[2], lamp;  // what PathTally adds up
} PathStep;

// A walk that is learned from.
enum { PATH_TRAIL_STEPS = 24 };
typedef struct PathTrail {
    PathStep steps[PATH_TRAIL_STEPS];
    int count;
} PathTrail;

// The bin of a direction's numbers.
int path_guide_bin(double u, double v);
void path_tally_add(PathTally *tally, const PathStep *step);
void path_tally_shares(const PathTally *tally, PathShares *out);

// Shares for all places, by cubes of a grid and the way that surfaces face. NULL where too few walks came by.
PathGuide *path_guide_new(const Mesh *mesh, Arena *arena);
const PathShares *path_guide_at(const PathGuide *guide, const PathPlace *place);
// Adds the steps of walks, [count], and makes shares of all that were added so far.
void path_guide_add(PathGuide *guide, const PathStep *steps, int count);
void path_guide_share(PathGuide *guide);

#endif
