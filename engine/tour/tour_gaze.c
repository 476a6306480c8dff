// tour_gaze.c - where the eye of a tour looks. At moments LOOK_TICKS apart rays all around tell how far the view goes in each direction
// and how much of it one polygon would fill. Among all ways of turning that are slow enough, the one is taken whose sum of costs over
// the leg is least (dynamic programming over time and direction; R. Bellman 1957): away from the way ahead, before near walls and
// before views that one polygon fills a direction is dear; a long view is cheap.
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "engine/sim/door_part.h"
#include "engine/tour/tour_film.h"
#include "visibility/rays/ray_surfaces.h"

// Looks are LOOK_TICKS moments apart, and the eye turns by up to QUICKEST directions in between: 50 degrees a second.
enum { DIRECTIONS = 72, ROWS = 5, MIDDLE = 2, LOOK_TICKS = 4, QUICKEST = 2, VIEW = 7, MOST_PASSED = 8 };
// Directions of a ray in a view of 75 by 47 degrees, up and down, radians.
static const double ROW_APART = 0.16;
// The pitch, radians, is a little down, as people look when they walk.
static const double PITCH = -0.04;
// On stairs it follows this share of the slope.
static const double SLOPE = 0.6;
// Views are no longer than this, metres.
static const double LONGEST = 15;
// The way ahead is where the eye is after it went so far, metres.
static const double AHEAD = 1.0;
// The width of the Gaussian over directions, seconds.
static const double EASE = 0.35;

typedef struct Look {
    float cost[DIRECTIONS];
    double speed;  // m/s
} Look;

typedef struct Gaze {
    const CellGraph *graph;
    TourFilm *film;
    SurfaceTree *tree;
    const int *list,
        *opening_of;  // of the tree's items: polygons of the graph; the door whose leaf a polygon is, or -1
    int first, last;  // moments of the leg
    Look *looks;
    int look_count;
} Gaze;

static int moment_of(const Gaze *g, int look) {
    int at = g->first + look * LOOK_TICKS;
    return at < g->last ? at : g->last - 1;
}

// The direction of the way ahead, or else of the way behind; false where the leg does not move.
static bool heading_at(const Gaze *g, int at, double *yaw) {
    const FilmMoment *m = g->film->moments;
    for (int step = 1; step >= -1; step -= 2) {
        for (int i = at; i >= g->first && i < g->last; i += step) {
            double x = step * (m[i].eye.x - m[at].eye.x), y = step * (m[i].eye.y - m[at].eye.y);
            if (hypot(x, y) < (step > 0 ? AHEAD : 0.3) && (step < 0 || i + 1 < g->last)) continue;
            if (hypot(x, y) < 0.25) continue;
            *yaw = atan2(y, x);
            return true;
        }
    }
    return false;
}

// The slope of the way, radians, over a second before and after.
static double slope_at(const Gaze *g, int at) {
    int reach = (int)(0.8 / FILM_TICK), a = at - reach > g->first ? at - reach : g->first,
        b = at + reach < g->last ? at + reach : g->last - 1;
    Vec3 way = vec3_sub(g->film->moments[b].eye, g->film->moments[a].eye);
    double level = hypot(way.x, way.y);
    return level > 0.3 ? atan2(way.z, level) : 0;
}

// ---- rays

// How far it is to a doorway whose door is shut, or nearly, along a ray; INFINITY if there is none. `door` is that door.
static double to_shut_door(const Gaze *g, const float *door_open, const Ray *ray, int *door) {
    const Building *b = g->graph->building;
    double nearest = INFINITY;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind != OPENING_DOOR || o->glazed || door_open[i] > 0.5f) continue;
        Vec2 along = vec2_sub(o->line[1], o->line[0]),
             to = vec2_sub(o->line[0], vec2(ray->origin.x, ray->origin.y));
        Vec2 way = vec2(ray->direction.x, ray->direction.y);
        double across = vec2_cross(way, along);
        if (across == 0) continue;
        double t = vec2_cross(to, along) / across, u = vec2_cross(to, way) / across,
               z = ray->origin.z + t * ray->direction.z;
        if (t <= 0 || t >= nearest || u < 0 || u > 1 || z < o->sill || z > o->head) continue;
        nearest = t;
        *door = i;
    }
    return nearest;
}

// The first thing that a ray meets, a pane of glass included: its distance, metres, and a number that tells polygons and shut
// doors apart; and how far the view goes, through glass.
static double look_along(const Gaze *g, const float *door_open, Ray ray, int *item, double *view) {
    int door = -1;
    double shut = to_shut_door(g, door_open, &ray, &door), first = fmin(ray.far, shut);
    bool met = false;
    *item = shut < ray.far ? -2 - door : -1;
    *view = first;
    for (int tries = 0; tries < MOST_PASSED; tries++) {
        SurfaceHit hit = surface_tree_first(g->tree, &ray);
        if (hit.item < 0 || hit.at.t >= shut) break;
        int polygon = g->list[hit.item], opening = g->opening_of[polygon];
        ray.near = hit.at.t + 1e-4;
        // The tree's doors are wide open: a leaf that is shut stands elsewhere.
        if (opening >= 0 && door_open[opening] <= 0.5f) continue;
        if (!met) first = hit.at.t, *item = polygon;
        met = true;
        if (vis_is_glass(g->graph, polygon)) continue;
        *view = hit.at.t;
        break;
    }
    return first;
}

// ---- costs

// The share of the view around a direction that the polygon fills that fills most.
static double share_of_one(int item[DIRECTIONS][ROWS], int direction) {
    int seen[(2 * VIEW + 1) * ROWS], times[(2 * VIEW + 1) * ROWS], count = 0, most = 0;
    for (int k = -VIEW; k <= VIEW; k++) {
        for (int row = 0; row < ROWS; row++) {
            int what = item[(direction + k + DIRECTIONS) % DIRECTIONS][row], i = 0;
            while (i < count && seen[i] != what) i++;
            if (i == count) seen[count] = what, times[count++] = 0;
            // The sky is no polygon.
            if (what != -1 && ++times[i] > most) most = times[i];
        }
    }
    return most / (double)((2 * VIEW + 1) * ROWS);
}

static void weigh(void *context, int index, int thread) {
    (void)thread;
    Gaze *g = context;
    Look *look = &g->looks[index];
    int at = moment_of(g, index), before = at > g->first ? at - 1 : at,
        after = at + 1 < g->last ? at + 1 : at, item[DIRECTIONS][ROWS];
    const FilmMoment *m = &g->film->moments[at];
    Arena scratch = {0};
    float *door_open = ARENA_ARRAY(&scratch, float, g->film->opening_count + 1);
    tour_film_shares(g->film, at * FILM_TICK, door_open);
    double far[DIRECTIONS][ROWS], view[DIRECTIONS][ROWS], ahead = 0;
    bool goes = heading_at(g, at, &ahead);
    double slope = goes ? SLOPE * slope_at(g, at) : 0;
    for (int d = 0; d < DIRECTIONS; d++) {
        for (int row = 0; row < ROWS; row++) {
            double yaw = 2 * M_PI * d / DIRECTIONS;
            double pitch = PITCH + slope * fmax(0, cos(yaw - ahead)) + ROW_APART * (row - MIDDLE);
            Ray ray = {m->eye, vec3(cos(pitch) * cos(yaw), cos(pitch) * sin(yaw), sin(pitch)), 0, LONGEST};
            far[d][row] = look_along(g, door_open, ray, &item[d][row], &view[d][row]);
        }
    }
    Vec3 way = vec3_sub(g->film->moments[after].eye, g->film->moments[before].eye);
    look->speed = after > before ? hypot(way.x, way.y) / ((after - before) * FILM_TICK) : 0;
    for (int d = 0; d < DIRECTIONS; d++) {
        double centre = LONGEST, open = 0,
               off = remainder(2 * M_PI * d / DIRECTIONS - ahead, 2 * M_PI) / (M_PI / 4);
        for (int k = -1; k <= 1; k++)
            for (int row = MIDDLE - 1; row <= MIDDLE + 1; row++)
                centre = fmin(centre, far[(d + k + DIRECTIONS) % DIRECTIONS][row]);
        for (int k = -VIEW; k <= VIEW; k++)
            open += fmin(view[(d + k + DIRECTIONS) % DIRECTIONS][MIDDLE], 8) / 8 / (2 * VIEW + 1);
        double cost = -1.2 * open - 1.0 * fmin(view[d][MIDDLE], 6) / 6;
        double one = share_of_one(item, d);
        cost += 2 * fmax(0, one - 0.35) + 40 * fmax(0, one - 0.47);
        if (centre < 1) cost += 2 * (1 - centre) + (centre < 0.6 ? 4 : 0) + (centre < 0.45 ? 8 : 0);
        if (goes)
            cost += fmin(1.0 * off * off, 2.5 + 0.5 * fabs(off)) *
                    (0.3 + 0.7 * fmin(look->speed / TOUR_SPEED, 1));
        look->cost[d] = (float)cost;
    }
    arena_free(&scratch);
}

// ---- the cheapest way of turning

static double turning_cost(const Look *look, int by) {
    double still = fmax(0, 1 - look->speed / 0.3);
    return 0.05 * by * by + 1.5 * still * abs(by);
}

// Writes the yaw of each look, continuous.
static void choose_directions(const Gaze *g, double *yaw) {
    Arena scratch = {0};
    int n = g->look_count;
    double now[DIRECTIONS], next[DIRECTIONS];
    signed char *by = ARENA_ARRAY(&scratch, signed char, n *DIRECTIONS);
    for (int d = 0; d < DIRECTIONS; d++) now[d] = (double)g->looks[0].cost[d];
    for (int i = 1; i < n; i++) {
        for (int d = 0; d < DIRECTIONS; d++) {
            double best = INFINITY;
            for (int k = -QUICKEST; k <= QUICKEST; k++) {
                double cost = now[(d - k + DIRECTIONS) % DIRECTIONS] + turning_cost(&g->looks[i], k);
                if (cost < best) best = cost, by[i * DIRECTIONS + d] = (signed char)k;
            }
            next[d] = best + (double)g->looks[i].cost[d];
        }
        for (int d = 0; d < DIRECTIONS; d++) now[d] = next[d];
    }
    int at = 0;
    for (int d = 1; d < DIRECTIONS; d++)
        if (now[d] < now[at]) at = d;
    double angle = 2 * M_PI * at / DIRECTIONS;
    for (int i = n - 1; i >= 0; i--) {
        yaw[i] = angle;
        int step = by[i * DIRECTIONS + at];
        angle -= 2 * M_PI * step / DIRECTIONS;
        at = (at - step + DIRECTIONS) % DIRECTIONS;
    }
    arena_free(&scratch);
}

// Directions at all moments, from those of the looks; smoothed.
static void turn(const Gaze *g, const double *yaw) {
    Arena scratch = {0};
    int count = g->last - g->first, reach = (int)(3 * EASE / FILM_TICK);
    double *rough = ARENA_ARRAY(&scratch, double, count + 1),
           *slope = ARENA_ARRAY(&scratch, double, count + 1);
    for (int i = 0; i < count; i++) {
        int look = i / LOOK_TICKS, next = look + 1 < g->look_count ? look + 1 : look;
        rough[i] = yaw[look] + (yaw[next] - yaw[look]) * (i % LOOK_TICKS) / LOOK_TICKS;
        double ahead = rough[i];
        bool goes = heading_at(g, g->first + i, &ahead);
        slope[i] = goes ? SLOPE * slope_at(g, g->first + i) * fmax(0, cos(rough[i] - ahead)) : 0;
    }
    for (int i = 0; i < count; i++) {
        double sum = 0, rise = 0, weights = 0;
        for (int k = -reach; k <= reach; k++) {
            int at = i + k < 0 ? 0 : i + k >= count ? count - 1 : i + k;
            double off = k * FILM_TICK / EASE, weight = exp(-off * off / 2);
            sum += weight * rough[at];
            rise += weight * slope[at];
            weights += weight;
        }
        g->film->moments[g->first + i].yaw = sum / weights;
        g->film->moments[g->first + i].pitch = PITCH + rise / weights;
    }
    arena_free(&scratch);
}

void tour_film_gaze(const CellGraph *graph, TourFilm *film) {
    Arena scratch = {0};
    int *list = ARENA_ARRAY(&scratch, int, graph->polygon_count + 1), count = 0;
    int *opening_of = ARENA_ARRAY(&scratch, int, graph->polygon_count + 1);
    for (int i = 0; i < graph->object_count; i++) {
        const Object *o = &graph->objects[i];
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            opening_of[p] = o->leaf >= 0 ? o->opening : -1;
            if (!o->plug) list[count++] = p;
        }
    }
    RaySource source = {.building = graph->building,
                        .polygons = graph->polygons,
                        .vertices = vis_posed(graph, NULL, &scratch),
                        .list = list,
                        .list_count = count};
    RaySurfaces surfaces = ray_surfaces_new(&source, &scratch);
    SurfaceTree tree = surface_tree_new(&surfaces, &scratch);
    for (int i = 0; i < film->leg_count; i++) {
        Gaze g = {.graph = graph,
                  .film = film,
                  .tree = &tree,
                  .list = list,
                  .opening_of = opening_of,
                  .first = film->leg_first[i],
                  .last = film->leg_first[i + 1]};
        g.look_count = (g.last - g.first + LOOK_TICKS - 1) / LOOK_TICKS;
        g.looks = ARENA_ARRAY(&scratch, Look, g.look_count + 1);
        double *yaw = ARENA_ARRAY(&scratch, double, g.look_count + 1);
        parallel_for(parallel_threads(0), g.look_count, weigh, &g);
        choose_directions(&g, yaw);
        turn(&g, yaw);
    }
    arena_free(&scratch);
}
