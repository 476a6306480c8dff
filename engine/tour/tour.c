// tour.c - tours frame by frame: the automatic one from the film of tour_film.h, stored ones from their viewpoints.
#include "engine/tour/tour.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/text.h"

TourOptions tour_default_options(void) {
    return (TourOptions){
        .step = 0.5, .turn = 15 * M_PI / 180, .fov = 75 * M_PI / 180, .frames_per_second = 12};
}

// The same angle within -pi .. pi.
static double wrap(double angle) { return remainder(angle, 2 * M_PI); }

// ---- the automatic tour

// Cells on whose floor a body can stand, and those that the eye is in.
static void mark_cells(const TourFloor *floor, TourPath *out) {
    for (int i = 0; i < floor->place_count; i++)
        if (floor->places[i].cell >= 0) out->reachable[floor->places[i].cell] = 1;
    for (int i = 0, cell = -1; i < out->film.moment_count; i++) {
        cell = vis_locate(floor->graph, out->film.moments[i].eye, cell);
        if (cell >= 0) out->visited[cell] = 1;
    }
    for (int c = 0; c < floor->graph->cell_count; c++) {
        // The eye is where the body is; where a cell ends under the eye, it is in the one above.
        out->reachable[c] |= out->visited[c];
        out->reachable_count += out->reachable[c];
        out->visited_count += out->visited[c];
    }
}

// The rooms of a state, by name or place, the first few.
static const char *list_rooms(const TourRoute *route, int state, int *count, Arena *arena) {
    enum { MOST = 8 };
    Text text = {.arena = arena};
    *count = 0;
    for (int i = 0; i < route->room_count; i++) {
        if ((int)route->room_state[i] != state || ++*count > MOST) continue;
        const char *name = route->room_name[i];
        Vec3 at = route->room_place[i];
        text_append(&text, "%s%s at (%.2f, %.2f)", *count > 1 ? ", " : "", *name ? name : "a room", at.x,
                    at.y);
    }
    if (*count > MOST) text_append(&text, ", ...");
    return text.data ? text.data : "";
}

static void add_note(Arena *arena, TourPath *out, const char *text) {
    *ARENA_PUSH(arena, out->notes, out->note_count, out->note_capacity) = text;
}

static void count_rooms(const TourRoute *route, Arena *arena, TourPath *out) {
    // Rooms count by where the eye is, not by the plan of the route.
    unsigned char *seen = ARENA_ARRAY(arena, unsigned char, route->room_count + 1);
    for (int i = 0; i < out->film.moment_count; i++)
        if (out->film.moments[i].room >= 0) seen[out->film.moments[i].room] = 1;
    for (int i = 0; i < route->room_count; i++) {
        out->rooms_enterable += route->room_state[i] != ROOM_SHUT && route->room_state[i] != ROOM_BEYOND;
        out->rooms_entered += seen[i];
    }
    if (route->moved)
        add_note(arena, out,
                 "the tour begins in the largest part of the building: from the start there is no way there");
    if (route->leg_count > 1)
        add_note(arena, out,
                 arena_format(arena, "%d parts that no way leads to from the first are entered by a cut",
                              route->leg_count - 1));
    int count;
    const char *names = list_rooms(route, ROOM_SHUT, &count, arena);
    if (count > 0)
        add_note(
            arena, out,
            arena_format(arena, "%d rooms are left out, in which nobody can take a step: %s", count, names));
}

static void add_frames(const TourOptions *options, Arena *arena, TourPath *out) {
    const TourFilm *film = &out->film;
    int cuts = 0;
    double tick = 1 / (FILM_TICK * options->frames_per_second);
    for (int leg = 0; leg < film->leg_count; leg++) {
        int last = film->leg_first[leg + 1] - 1;
        // The first frame at or after the leg's first moment.
        for (; out->frame_count * tick <= last;) {
            double at = fmax(out->frame_count * tick, film->leg_first[leg]);
            int i = (int)at < last ? (int)at : last, next = i < last ? i + 1 : i;
            double t = at - i;
            const FilmMoment *a = &film->moments[i], *b = &film->moments[next];
            *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
                (TourFrame){vec3_lerp(a->eye, b->eye, t), wrap(a->yaw + (b->yaw - a->yaw) * t),
                            a->pitch + (b->pitch - a->pitch) * t, options->fov};
        }
        if (leg + 1 < film->leg_count) *ARENA_PUSH(arena, out->cuts, out->cut_count, cuts) = out->frame_count;
    }
}

static void tour_auto(const CellGraph *graph, const TourOptions *options, Arena *arena, TourPath *out) {
    Arena scratch = {0};
    TourFloor floor;
    TourRoute route;
    tour_floor_make(graph, options->rooms, &scratch, &floor);
    tour_route_make(&floor, &scratch, &route);
    tour_film_walk(&route, arena, &out->film);
    tour_film_doors(graph, arena, &out->film);
    tour_film_gaze(graph, &out->film);
    mark_cells(&floor, out);
    count_rooms(&route, arena, out);
    out->is_film = true;
    if (route.leg_count == 0) add_note(arena, out, "the tour is one view: nobody can stand in the building");
    add_frames(options, arena, out);
    if (out->frame_count == 0) {
        *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
            (TourFrame){graph->building->start, wrap(graph->building->start_yaw), 0, options->fov};
    }
    arena_free(&scratch);
}

void tour_doors(const TourPath *path, int frame, double frames_per_second, float *door_open) {
    tour_film_shares(&path->film, frame / frames_per_second, door_open);
}

bool tour_is_cut(const TourPath *path, int frame) {
    for (int i = 0; i < path->cut_count; i++)
        if (path->cuts[i] == frame) return true;
    return false;
}

// ---- stored tours

// Adds the frames between two stored viewpoints, the second included.
static void interpolate(const TourOptions *options, Arena *arena, const Viewpoint *a, const Viewpoint *b,
                        TourPath *out) {
    double turn = wrap(b->yaw - a->yaw);
    double steps = fmax(vec3_length(vec3_sub(b->eye, a->eye)) / options->step, fabs(turn) / options->turn);
    steps = ceil(fmax(steps, fabs(b->pitch - a->pitch) / options->turn) - 1e-9);
    // Coordinates are checked, so this many frames are a very long path, not a fault.
    int count = steps < 1e6 ? (int)steps : 1000000;
    for (int i = 1; i <= count; i++) {
        double t = (double)i / count;
        *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
            (TourFrame){vec3_lerp(a->eye, b->eye, t), wrap(a->yaw + turn * t),
                        a->pitch + (b->pitch - a->pitch) * t, a->fov + (b->fov - a->fov) * t};
    }
}

static void add_viewpoint(const TourOptions *options, Arena *arena, const Viewpoint *v, TourPath *out) {
    *ARENA_PUSH(arena, out->frames, out->frame_count, out->frame_capacity) =
        (TourFrame){v->eye, v->yaw, v->pitch, v->fov > 0 ? v->fov : options->fov};
}

static bool no_such_tour(const Building *b, const char *name, Error *error) {
    char names[512] = "auto";
    size_t used = strlen(names);
    for (int i = 0; i < b->tour_count + b->viewpoint_count; i++) {
        const char *next = i < b->tour_count ? b->tours[i].name : b->viewpoints[i - b->tour_count].name;
        if (used + strlen(next) + 8 > sizeof names) {
            memcpy(names + used, ", ...", 6);
            break;
        }
        used += (size_t)snprintf(names + used, sizeof names - used, ", %s", next);
    }
    return error_set(error, "%s: there is no tour or viewpoint `%s` (allowed: %s)",
                     b->source ? b->source : "building", name, names);
}

bool tour_make(const CellGraph *graph, const char *name, const TourOptions *options, Arena *arena,
               TourPath *out, Error *error) {
    const Building *b = graph->building;
    *out = (TourPath){0};
    out->reachable = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    out->visited = ARENA_ARRAY(arena, unsigned char, graph->cell_count);
    if (options->rooms > 0 && b->region_count == 0)
        return error_set(error,
                         "%s: it has no rooms by which a tour could be cut (--rooms is for plans and homes)",
                         b->source ? b->source : "building");
    if (strcmp(name, "auto") == 0) {
        tour_auto(graph, options, arena, out);
        return true;
    }
    for (int i = 0; i < b->tour_count; i++) {
        if (strcmp(b->tours[i].name, name) != 0 || b->tours[i].viewpoint_count == 0) continue;
        const Viewpoint *v = b->tour_points + b->tours[i].first_viewpoint;
        add_viewpoint(options, arena, v, out);
        for (int k = 1; k < b->tours[i].viewpoint_count; k++)
            interpolate(options, arena, &v[k - 1], &v[k], out);
        return true;
    }
    for (int i = 0; i < b->viewpoint_count; i++) {
        if (strcmp(b->viewpoints[i].name, name) != 0) continue;
        add_viewpoint(options, arena, &b->viewpoints[i], out);
        return true;
    }
    return no_such_tour(b, name, error);
}
