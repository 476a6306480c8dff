// curved_field.h - the field of metaballs.
#ifndef MAPS_CURVED_FIELD_H
#define MAPS_CURVED_FIELD_H

#include "maps/building/curved.h"

double curved_field(const CurvedBall *balls, int count, Vec3 p);
// Returns the field at p and writes its gradient there; outside the surface the gradient points inwards.
double curved_field_gradient(const CurvedBall *balls, int count, Vec3 p, Vec3 *gradient);
// Moves p along the gradient until the field at p equals the threshold, to the last bits; false where p does not get there
// within `reach` metres.
bool curved_field_settle(const CurvedBall *balls, int count, double threshold, double reach, Vec3 *p);
// The maximum of the field, found by ascent from every ball's centre and from the middle between every two centres.
double curved_field_peak(const CurvedBall *balls, int count);
// Beyond this box the field is at most 0.
Box curved_field_box(const CurvedBall *balls, int count);

#endif
