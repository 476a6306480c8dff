// person.h - a person who walks or flies: wishes become steps, and the eye follows the body.
#ifndef WALK_PERSON_H
#define WALK_PERSON_H

#include "engine/sim/body.h"

// Speeds in m/s: a brisk walk indoors, a run, flight through anything.
#define PERSON_WALK 1.7
#define PERSON_RUN 4.2
#define PERSON_FLY 4.0
#define PERSON_FLY_FAST 14.0

// The person's wish for this tick; each direction is -1 .. 1.
typedef struct PersonWish {
    double forward, right, up;  // up only in flight
    bool hurry;
} PersonWish;

typedef struct Person {
    Body body;
    Vec3 eye;
    double yaw, pitch;  // radians, see Viewpoint
    Vec2 velocity;      // m/s in plan
    bool flying;
    int cell;  // of the eye, or -1
} Person;

// Puts the person where the eye is at `eye`, or as near as a body fits. In flight the eye is exactly at `eye`.
void person_put(Person *person, BodyWorld *world, Vec3 eye, double yaw, double pitch);
void person_fly(Person *person, BodyWorld *world, bool flying);
// Turns the head by these angles, radians; the pitch only as far as a neck allows.
void person_look(Person *person, double yaw, double pitch);
// Advances by a tick of some hundredths of a second. Allocates nothing.
void person_tick(Person *person, BodyWorld *world, const PersonWish *wish, double seconds);

#endif
