// bezier_meet.h - where two trims of a patch meet: loops that cross each other leave what nobody meant.
#ifndef RAYS_BEZIER_MEET_H
#define RAYS_BEZIER_MEET_H

#include "maps/building/curved.h"
#include "visibility/bezier/ray.h"

typedef struct BezierMeeting {
    double s, t;  // on the first curve and on the second, 0 .. 1
} BezierMeeting;

// Writes at most `max`, returns how many were found. Of curves that run in each other some are told, and `undecided` counted.
int bezier_meetings(const CurvedTrim *a, const CurvedTrim *b, BezierMeeting *out, int max, CurvedWork *work);

#endif
