// still_lamps_parts.h - what the files of the light straight from lamps share.
#ifndef STILLS_STILL_LAMPS_PARTS_H
#define STILLS_STILL_LAMPS_PARTS_H

#include <pthread.h>
#include <stdatomic.h>

#include "engine/stills/still_lamps.h"

typedef struct Lamp {
    int first_corner, corner_count;  // 0: a ball
    Vec3 centre, normal;
    Vec3 four[4];         // of a quadrilateral: where Gauss's rule looks
    double area, radius;  // of a polygon: that holds all of it
    double before;
    double exitance[3], luminous;
    int cell;   // where it shines, -1: not known
    int group;  // those of one object: they are seen together or not at all
} Lamp;

// A lamp as a side of an element may see it.
typedef struct Candidate {
    int lamp;
    float seen;  // about so much of it, 0 .. 1
} Candidate;

// First those of which it saw something.
typedef struct Candidates {
    int seen_count, count;
    Candidate lamp[];
} Candidates;

struct StillLamps {
    const StillScene *scene;
    Lamp *lamps;
    Vec3 *corners;
    const StabForest *forest;
    _Atomic(Candidates *)
        *of_element;  // [2 * element_count] of the front and back of each, when they were asked for
    pthread_mutex_t lock;
    Arena found;       // behind the lock
    int *group_first;  // [group_count + 1] in `lamps`
    int count, group_count;
    int looks;  // rays from an element to the lamps of an object that say how much it sees of them
};

// Before what is lit: a place and its axes.
typedef struct LampFrame {
    Vec3 x, y, n, point;
} LampFrame;

// The next of a sequence.
void lamp_numbers_next(StillNumbers *numbers, double u[3]);
static inline double lamp_fraction(double a) { return a - floor(a); }

// The shape that is drawn exactly of which a face is a part; NULL: none.
const CurvedShape *lamp_shape_of(const StillScene *scene, const Face *face);

// still_lamps_share.c: the share of the light that leaves a place that would meet the lamp's front.
double lamp_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *frame);
// Is a point of the lamp seen, one that is drawn by what it sends?
bool lamp_sees(const StillLamps *lamps, const Lamp *lamp, const LampFrame *frame, const double u[2],
               double pick);

// still_lamps_seen.c: which lamps a side of an element may see, found when it is first asked for.
const Candidates *lamp_candidates(StillLamps *lamps, int element, bool front);

#endif
