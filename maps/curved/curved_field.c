// curved_field.c - the field of metaballs (G. Wyvill, C. McPheeters & B. Wyvill, Data structure for soft objects, 1986), and
// Newton's method along its gradient.
#include "maps/curved/curved_field.h"

// Steps of Newton: each doubles the digits, the first few may be halved.
enum { SETTLE_STEPS = 40, CLIMB_STEPS = 200 };

double curved_field(const CurvedBall *balls, int count, Vec3 p) {
    double sum = 0;
    for (int i = 0; i < count; i++) {
        Vec3 from = vec3_sub(p, balls[i].centre);
        double u = vec3_dot(from, from) / (balls[i].radius * balls[i].radius);
        if (u < 1) sum += balls[i].weight * (1 - u * (22 - u * (17 - 4 * u)) / 9);
    }
    return sum;
}

double curved_field_gradient(const CurvedBall *balls, int count, Vec3 p, Vec3 *gradient) {
    double sum = 0;
    *gradient = vec3(0, 0, 0);
    for (int i = 0; i < count; i++) {
        Vec3 from = vec3_sub(p, balls[i].centre);
        double square = balls[i].radius * balls[i].radius, u = vec3_dot(from, from) / square;
        if (u >= 1) continue;
        sum += balls[i].weight * (1 - u * (22 - u * (17 - 4 * u)) / 9);
        double slope = balls[i].weight * (-22 + u * (34 - 12 * u)) / 9;
        *gradient = vec3_add(*gradient, vec3_scale(from, 2 * slope / square));
    }
    return sum;
}

bool curved_field_settle(const CurvedBall *balls, int count, double threshold, double reach, Vec3 *p) {
    Vec3 start = *p, at = *p;
    double best = INFINITY;
    for (int i = 0; i < SETTLE_STEPS; i++) {
        Vec3 gradient;
        double off = curved_field_gradient(balls, count, at, &gradient) - threshold;
        double square = vec3_dot(gradient, gradient);
        // No nearer than before: the rest is rounding.
        if (!(fabs(off) < best)) break;
        best = fabs(off);
        *p = at;
        if (off == 0 || !(square > 0)) break;
        at = vec3_sub(at, vec3_scale(gradient, off / square));
        if (vec3_length(vec3_sub(at, start)) > reach) break;
    }
    Vec3 gradient;
    double off = fabs(curved_field_gradient(balls, count, *p, &gradient) - threshold);
    return off <= 1e-11 * (vec3_length(gradient) + threshold);
}

// Steepest ascent whose step grows while it gains and shrinks where it does not.
static double climb(const CurvedBall *balls, int count, Vec3 from, double step) {
    double height = curved_field(balls, count, from);
    for (int i = 0; i < CLIMB_STEPS; i++) {
        Vec3 gradient;
        curved_field_gradient(balls, count, from, &gradient);
        Vec3 next = vec3_add(from, vec3_scale(vec3_normalize(gradient), step));
        double there = curved_field(balls, count, next);
        step *= there > height ? 1.3 : 0.5;
        if (there > height) from = next, height = there;
    }
    return height;
}

double curved_field_peak(const CurvedBall *balls, int count) {
    double peak = 0;
    for (int i = 0; i < count; i++) {
        double step = 0.1 * balls[i].radius;
        peak = fmax(peak, climb(balls, count, balls[i].centre, step));
        for (int j = 0; j < i; j++)
            peak = fmax(peak, climb(balls, count, vec3_lerp(balls[i].centre, balls[j].centre, 0.5), step));
    }
    return peak;
}

Box curved_field_box(const CurvedBall *balls, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        if (balls[i].weight <= 0) continue;
        Box ball = box_grow((Box){balls[i].centre, balls[i].centre}, balls[i].radius);
        box = box_union(box, ball);
    }
    return box;
}
