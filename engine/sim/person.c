// person.c - walking with a little inertia, flying with none. The eye rises and sinks softly over steps, but never
// through a solid that hangs over the head.
#include "engine/sim/person.h"

// How fast wishes become speed, 1/s: from a stand to a walk in about a sixth of a second.
static const double QUICKNESS = 14;
// How fast the eye follows the body up and down, 1/s: a step of a stair takes about a tenth of a second.
static const double EYE_QUICKNESS = 14;
// The steepest pitch, as far as a neck bends, radians.
static const double STEEPEST = 1.5;

static Vec3 eye_over(const Person *p) {
    return vec3(p->body.foot.x, p->body.foot.y, p->body.foot.z + body_eye(&p->body));
}

static void find_cell(Person *p, BodyWorld *world) {
    int hint = p->cell >= 0 ? p->cell : p->body.cell;
    p->cell = vis_locate(world->graph, p->eye, hint);
}

void person_look(Person *p, double yaw, double pitch) {
    p->yaw = remainder(p->yaw + yaw, 2 * M_PI);
    p->pitch = fmin(fmax(p->pitch + pitch, -STEEPEST), STEEPEST);
}

void person_put(Person *p, BodyWorld *world, Vec3 eye, double yaw, double pitch) {
    p->yaw = remainder(yaw, 2 * M_PI);
    p->pitch = fmin(fmax(pitch, -STEEPEST), STEEPEST);
    p->velocity = vec2(0, 0);
    p->cell = vis_locate(world->graph, eye, p->cell);
    p->eye = eye;
    if (p->flying) return;
    // If no body fits anywhere near, the person flies, so that the building can be looked at nevertheless.
    p->flying = !body_place_near(&p->body, world, vec3(eye.x, eye.y, eye.z - BODY_EYE));
    if (!p->flying) p->eye = eye_over(p);
    find_cell(p, world);
}

void person_fly(Person *p, BodyWorld *world, bool flying) {
    if (flying == p->flying) return;
    p->flying = flying;
    if (!flying) person_put(p, world, p->eye, p->yaw, p->pitch);
}

static void fly(Person *p, const PersonWish *wish, double seconds) {
    double speed = wish->hurry ? PERSON_FLY_FAST : PERSON_FLY;
    Vec3 forward = vec3(cos(p->pitch) * cos(p->yaw), cos(p->pitch) * sin(p->yaw), sin(p->pitch));
    Vec3 right = vec3(sin(p->yaw), -cos(p->yaw), 0);
    Vec3 way = vec3_add(vec3_scale(forward, wish->forward), vec3_scale(right, wish->right));
    way = vec3_add(way, vec3(0, 0, wish->up));
    p->eye = vec3_add(p->eye, vec3_scale(vec3_normalize(way), speed * seconds));
}

// The eye lags behind after the body moved, and catches up over the next ticks, within the body.
static void follow_body(Person *p, double before, double seconds) {
    Vec3 over = eye_over(p);
    double lag = (before - over.z) * exp(-EYE_QUICKNESS * seconds);
    double lowest = p->body.foot.z + body_eye(&p->body) / 2,
           highest = p->body.foot.z + p->body.head - BODY_CROWN;
    p->eye = vec3(over.x, over.y, fmin(fmax(over.z + lag, lowest), highest));
}

static void walk(Person *p, BodyWorld *world, const PersonWish *wish, double seconds) {
    double speed = wish->hurry ? PERSON_RUN : PERSON_WALK;
    Vec2 forward = vec2(cos(p->yaw), sin(p->yaw)), right = vec2(sin(p->yaw), -cos(p->yaw));
    Vec2 want = vec2_add(vec2_scale(forward, wish->forward), vec2_scale(right, wish->right));
    double length = vec2_length(want);
    want = vec2_scale(want, length > 1 ? speed / length : speed);
    double share = 1 - exp(-QUICKNESS * seconds);
    p->velocity = vec2_add(p->velocity, vec2_scale(vec2_sub(want, p->velocity), share));
    double before = p->eye.z;
    Vec2 start = vec2(p->body.foot.x, p->body.foot.y);
    body_step(&p->body, world, vec2_scale(p->velocity, seconds), seconds);
    // The velocity is that of the real movement, so that a wall takes speed away; being put elsewhere gives no speed.
    Vec2 moved = vec2_scale(vec2_sub(vec2(p->body.foot.x, p->body.foot.y), start), 1 / seconds);
    p->velocity = vec2_length(moved) > 2 * PERSON_RUN ? vec2(0, 0) : moved;
    follow_body(p, before, seconds);
}

void person_tick(Person *p, BodyWorld *world, const PersonWish *wish, double seconds) {
    if (p->flying) {
        fly(p, wish, seconds);
    } else {
        walk(p, world, wish, seconds);
    }
    find_cell(p, world);
}
