// tour_doors.c - when the doors on the way of a tour open and close.
#include <stdlib.h>

#include "engine/sim/door_part.h"
#include "engine/tour/tour_film.h"

// A door stands open so long before the eye comes, and begins to close so long after it has gone, seconds: at TOUR_SPEED, two metres
// and one.
static const double BEFORE = 1.5, AFTER = 0.8;
// How much earlier or later it may be, for want of room, seconds.
static const double PATIENCE = 8;
// A door that is passed again so soon is left open, seconds.
static const double KEPT_OPEN = 4;
// Leaves that swing keep so far from the eye in plan, metres: the body and a little.
static const double CLEAR = BODY_RADIUS + 0.08;
static const double TRY_APART = 0.2;

typedef struct DoorTimes {
    const CellGraph *graph;
    const TourFilm *film;
    int opening;
} DoorTimes;

static double eased(double t) {
    t = fmin(fmax(t, 0), 1);
    return t * t * (3 - 2 * t);
}

// Do the leaves keep clear of the eye while the door opens or closes from `start` on?
static bool has_room(const DoorTimes *d, double start, bool opens) {
    const TourFilm *film = d->film;
    for (double t = 0; t <= FILM_SWING; t += FILM_TICK) {
        int at = (int)((start + t) / FILM_TICK);
        if (at < 0 || at >= film->moment_count) continue;
        const FilmMoment *m = &film->moments[at];
        double share = eased(t / FILM_SWING);
        for (int i = 0; i < door_part_count(d->graph->building, d->opening); i++) {
            DoorPart part;
            Vec3 plan[LEAF_CORNERS];
            if (!door_part(d->graph->building, d->opening, i, opens ? share : 1 - share, &part)) continue;
            Solid solid = door_part_solid(&part, plan);
            if (solid_distance(&solid, (Band){m->foot, m->eye.z}, vec2(m->eye.x, m->eye.y)) < CLEAR)
                return false;
        }
    }
    return true;
}

// Does the way from one moment to the next go through the doorway?
static bool crosses(const Opening *o, const FilmMoment *a, const FilmMoment *b) {
    double middle = a->foot + BODY_MIDDLE;
    if (middle < o->sill || middle > o->head) return false;
    Vec2 along = vec2_sub(o->line[1], o->line[0]);
    Vec2 from = vec2_sub(vec2(a->eye.x, a->eye.y), o->line[0]),
         to = vec2_sub(vec2(b->eye.x, b->eye.y), o->line[0]);
    double p = vec2_cross(along, from), q = vec2_cross(along, to);
    if ((p < 0) == (q < 0)) return false;
    double u =
        vec2_dot(along, vec2_add(from, vec2_scale(vec2_sub(to, from), p / (p - q)))) / vec2_dot(along, along);
    return u >= 0 && u <= 1;
}

static void add_swing(Arena *arena, TourFilm *film, double start, int opening, bool opens) {
    *ARENA_PUSH(arena, film->swings, film->swing_count, film->swing_capacity) =
        (FilmSwing){start, opening, opens};
}

// The latest start of an opening swing after `earliest`; below 0: there is none.
static double find_opening(const DoorTimes *d, double crossing, double earliest) {
    for (double early = 0; early <= PATIENCE; early += TRY_APART) {
        double start = crossing - BEFORE - FILM_SWING - early;
        if (start < earliest) break;
        if (has_room(d, start, true)) return start;
    }
    return -1;
}

static double find_closing(const DoorTimes *d, double crossing, double latest) {
    for (double late = 0; late <= PATIENCE; late += TRY_APART) {
        double start = crossing + AFTER + late;
        if (start + FILM_SWING > latest) break;
        if (has_room(d, start, false)) return start;
    }
    return -1;
}

static void plan_door(const DoorTimes *d, const double *times, int count, Arena *arena, TourFilm *film) {
    double end = film->moment_count * FILM_TICK, start = find_opening(d, times[0], 0);
    film->open_first[d->opening] = start < 0;
    if (start >= 0) add_swing(arena, film, start, d->opening, true);
    for (int i = 0; i < count; i++) {
        double next = i + 1 < count ? times[i + 1] : end + KEPT_OPEN;
        double closing = find_closing(d, times[i], next - KEPT_OPEN);
        if (closing < 0) continue;
        double opening = i + 1 < count ? find_opening(d, next, closing + FILM_SWING) : end;
        if (opening < 0) continue;
        add_swing(arena, film, closing, d->opening, false);
        if (i + 1 < count) add_swing(arena, film, opening, d->opening, true);
    }
}

static int by_start(const void *first, const void *second) {
    const FilmSwing *a = first, *b = second;
    if (a->start != b->start) return a->start < b->start ? -1 : 1;
    return a->opening != b->opening ? a->opening - b->opening : a->opens - b->opens;
}

void tour_film_doors(const CellGraph *graph, Arena *arena, TourFilm *film) {
    const Building *b = graph->building;
    film->opening_count = b->opening_count;
    film->open_first = ARENA_ARRAY(arena, unsigned char, b->opening_count + 1);
    Arena scratch = {0};
    unsigned char *cut = ARENA_ARRAY(&scratch, unsigned char, film->moment_count + 1);
    for (int i = 0; i <= film->leg_count; i++) cut[film->leg_first[i]] = 1;
    for (int o = 0; o < b->opening_count; o++) {
        double *times = NULL;
        int count = 0, capacity = 0;
        if (b->openings[o].kind != OPENING_DOOR) {
            film->open_first[o] = 1;
            continue;
        }
        for (int i = 1; i < film->moment_count; i++) {
            if (!cut[i] && crosses(&b->openings[o], &film->moments[i - 1], &film->moments[i]))
                *ARENA_PUSH(&scratch, times, count, capacity) = i * FILM_TICK;
        }
        DoorTimes door = {graph, film, o};
        if (count > 0) plan_door(&door, times, count, arena, film);
    }
    if (film->swing_count > 0) qsort(film->swings, (size_t)film->swing_count, sizeof *film->swings, by_start);
    arena_free(&scratch);
}

void tour_film_shares(const TourFilm *film, double seconds, float *door_open) {
    for (int i = 0; i < film->opening_count; i++) door_open[i] = film->open_first[i];
    for (int i = 0; i < film->swing_count && film->swings[i].start <= seconds; i++) {
        double share = eased((seconds - film->swings[i].start) / FILM_SWING);
        door_open[film->swings[i].opening] = (float)(film->swings[i].opens ? share : 1 - share);
    }
}
