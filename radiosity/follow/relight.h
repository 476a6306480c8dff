// relight.h - light that follows doors and lamps: what a door cannot have changed is kept, and the rest is found anew. A state of doors and
// lamps has the same light however it came about.
//
// Sources: S. E. Chen, Incremental Radiosity: An Extension of Progressive Radiosity to an Interactive Image Synthesis System, 1990;
// D. W. George, F. X. Sillion & D. P. Greenberg, Radiosity Redistribution for Dynamic Environments, 1990: what was shot along rows that
// change is taken back and shot again, positive or negative. Departures: doors are seen by the stab trees; light that other lamps or rows
// that are gone would need is shot from nothing; and light that comes straight from lamps is found anew by itself, source by source.
#ifndef RADIOSITY_RELIGHT_H
#define RADIOSITY_RELIGHT_H

#include "radiosity/mesh/lamps.h"
#include "radiosity/show/direct.h"

// The light that is to follow was shot with all lamps fully lit along `options->rows`, and shown with its sources apart
// (each_lamp_sources), while the doors stood as `door_open` says.
typedef struct Relight {
    Mesh *mesh;
    const Lamps *lamps;
    const StabForest *forest;
    // [opening_count] the array that mesh, rows and sources were made with; relight_state changes it
    float *door_open;
    const RadOptions *options;  // with `rows`; and with `sky`, or all looks at the sky are anew in each state
    DirectSources *sources;
    const RadSolution *all;            // that light, whose choices stay
    Daylight *day;                     // the rows', which relight_turn changes
    struct RelightLamps *lamps_alone;  // NULL at first: what relight_turn keeps of them
    Arena before;                      // of the mesh that showed the light before the hour turned
    struct RelightLast *last;          // NULL at first: the light that was found last
} Relight;
// Frees what it keeps from light to light.
void relight_end(Relight *relight);

// The work of a change.
typedef struct RelightReport {
    int doors, rows;   // doors that moved; rows that were dropped for it
    long long points;  // at which light straight from the sources was found anew
} RelightReport;

// Before direct_show_apart: the mesh that shows the light is to be fine enough with all doors closed, and with all wide open.
void relight_prepare(DirectSources *sources, Mesh *mesh, Arena *arena);

// The light with the doors `door_open` [opening_count] and lamps `lit` [lamps->count], gathered and shown on the same nodes. Lives in the
// arena. The same, to a millionth of all light, whatever states came before it; the same states in the same order give the same bytes on
// any number of threads. False where progress asked to stop.
bool relight_state(Relight *relight, const float *door_open, const Rgb *lit, const Progress *progress,
                   Arena *arena, RadSolution *out, RelightReport *report);
// The first step of it, soon done: all but the light straight from lamps and the sun is that of `before`, a light of these lamps on the
// same nodes: one that relight_state has found, or `all`. The result shares it.
void relight_straight(Relight *relight, const float *door_open, const Rgb *lit, const RadSolution *before,
                      Arena *arena, RadSolution *out, RelightReport *report);

// Turns the hour: the light of another day that shines, all lamps fully lit, with the doors `door_open`; `day` shone, too, and rows and
// looks at the sky know the parts of the sky (FormFactorOptions.sky_parts, RadOptions.sky). The light is shot along the rows that are
// there, and shown on another mesh, as fine as this day asks for (direct_sources_shown). It takes the place of `all`: `out` must outlive
// what follows, as must the arena, in which the new `sources` live; the ones before are ended, but the mesh that showed their light stays
// until the next turn. False where progress asked to stop: all is as it was then, but for the doors.
bool relight_turn(Relight *relight, const Daylight *day, const float *door_open, const Progress *progress,
                  Arena *arena, RadSolution *out);

#endif
