// tour_film.c - the pace of a tour. The speed at each point of the line is as high as the turn of the line, the speed before and the
// speed after allow; then places in time are smoothed by a Gaussian, so that the speed has no corners.
#include "engine/tour/tour_film.h"

// The line turns no faster than this, radians a second; the speed changes by at most PUSH, m/s^2.
static const double LINE_TURN = 0.75, PUSH = 0.7;
// The slowest that a turn of the line makes the walk, and a turn back, m/s.
static const double SLOWEST = 0.3, CUSP = 0.15;
// The line's turn is measured between points so many before and behind.
enum { ARM = 3 };
// The film stands still at the beginning and the end of each leg, seconds.
static const double STILL = 0.8;
// The width of the Gaussian over places, seconds.
static const double EASE = 0.15;

static double limit_at(const RoutePoint *p, int count, int i) {
    int a = i > ARM ? i - ARM : 0, b = i + ARM < count ? i + ARM : count - 1;
    Vec3 in = vec3_sub(p[i].eye, p[a].eye), out = vec3_sub(p[b].eye, p[i].eye);
    double length = (hypot(in.x, in.y) + hypot(out.x, out.y)) / 2;
    if (length < 1e-9) return SLOWEST;
    double turn = fabs(remainder(atan2(out.y, out.x) - atan2(in.y, in.x), 2 * M_PI));
    if (turn > 2 * M_PI / 3) return CUSP;
    return fmin(TOUR_SPEED, fmax(SLOWEST, LINE_TURN * length / fmax(turn, 1e-9)));
}

static void add_moment(Arena *arena, TourFilm *out, const RoutePoint *a, const RoutePoint *b, double t) {
    *ARENA_PUSH(arena, out->moments, out->moment_count, out->moment_capacity) =
        (FilmMoment){.eye = vec3_lerp(a->eye, b->eye, t),
                     .foot = a->foot + (b->foot - a->foot) * t,
                     .room = t < 0.5 ? a->room : b->room};
}

// Smooths the places of a leg; its ends stand still, so that they stay.
static void ease(FilmMoment *m, int count) {
    Arena scratch = {0};
    Vec3 *eye = ARENA_ARRAY(&scratch, Vec3, count + 1);
    int reach = (int)(3 * EASE / FILM_TICK);
    for (int i = 0; i < count; i++) eye[i] = m[i].eye;
    for (int i = 0; i < count; i++) {
        Vec3 sum = {0, 0, 0};
        double weights = 0;
        for (int k = -reach; k <= reach; k++) {
            int at = i + k < 0 ? 0 : i + k >= count ? count - 1 : i + k;
            double off = k * FILM_TICK / EASE, weight = exp(-off * off / 2);
            sum = vec3_add(sum, vec3_scale(eye[at], weight));
            weights += weight;
        }
        m[i].eye = vec3_scale(sum, 1 / weights);
    }
    arena_free(&scratch);
}

static void walk_leg(const RoutePoint *p, int count, Arena *arena, TourFilm *out) {
    Arena scratch = {0};
    double *speed = ARENA_ARRAY(&scratch, double, count + 1);
    int first = out->moment_count, still = (int)(STILL / FILM_TICK);
    for (int i = 0; i < count; i++) speed[i] = i == 0 || i == count - 1 ? 0 : limit_at(p, count, i);
    for (int i = 1; i < count; i++) {
        double way = vec3_length(vec3_sub(p[i].eye, p[i - 1].eye));
        speed[i] = fmin(speed[i], sqrt(speed[i - 1] * speed[i - 1] + 2 * PUSH * way));
    }
    for (int i = count - 2; i >= 0; i--) {
        double way = vec3_length(vec3_sub(p[i + 1].eye, p[i].eye));
        speed[i] = fmin(speed[i], sqrt(speed[i + 1] * speed[i + 1] + 2 * PUSH * way));
    }
    for (int i = 0; i < still; i++) add_moment(arena, out, &p[0], &p[0], 0);
    double time = 0, next = 0;
    for (int i = 0; i + 1 < count; i++) {
        double way = vec3_length(vec3_sub(p[i + 1].eye, p[i].eye));
        double takes = 2 * way / fmax(speed[i] + speed[i + 1], 0.05);
        for (; next < time + takes; next += FILM_TICK) {
            // Even acceleration between the two speeds.
            double t = next - time, gone = speed[i] * t + (speed[i + 1] - speed[i]) * t * t / (2 * takes);
            add_moment(arena, out, &p[i], &p[i + 1], way > 0 ? fmin(gone / way, 1) : 0);
        }
        time += takes;
    }
    for (int i = 0; i < still; i++) add_moment(arena, out, &p[count - 1], &p[count - 1], 0);
    ease(out->moments + first, out->moment_count - first);
    arena_free(&scratch);
}

void tour_film_walk(const TourRoute *route, Arena *arena, TourFilm *out) {
    *out =
        (TourFilm){.leg_first = ARENA_ARRAY(arena, int, route->leg_count + 1), .leg_count = route->leg_count};
    for (int i = 0; i < route->leg_count; i++) {
        int first = route->leg_first[i];
        out->leg_first[i] = out->moment_count;
        walk_leg(route->points + first, route->leg_first[i + 1] - first, arena, out);
    }
    out->leg_first[route->leg_count] = out->moment_count;
}
