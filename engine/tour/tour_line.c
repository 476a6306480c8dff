// tour_line.c - the line of a tour from the places of its way: a turn back becomes a loop where there is room, detours of the grid are
// cut short where the floor allows, and corners are rounded by moving each point towards the middle of its neighbours (Laplacian
// smoothing), as long as it keeps the room around it that the way had.
#include "engine/tour/tour_line.h"

// A turn back is a turn by more than this over TURN_ARM metres on both sides, radians.
static const double TURN = 2.2, TURN_ARM = 0.7;
// The radius of a loop, metres: at least and at most.
static const double LOOP_LEAST = 0.22, LOOP_MOST = 0.75;
// The line keeps the clearance that the way had, up to this, metres.
static const double KEEP = 0.4;
// Sections up to this long are cut short, metres.
static const double CUT = 8.0;
enum { ROUNDS = 120 };
// Heights are means over this far before and behind, metres: some steps of a stair.
static const double STEADY = 0.5;

typedef struct LinePoint {
    Vec3 foot;
    double clearance;  // to keep
    bool fixed;        // of a loop, or in a room that the line stays in: no cut goes past it
    int room;          // in which it stays, -1: in any
} LinePoint;

typedef struct Line {
    const TourFloor *floor;
    const int *room_of;
    Arena *arena;
    LinePoint *points;
    int count, capacity;
} Line;

static double plan_apart(Vec3 a, Vec3 b) { return hypot(a.x - b.x, a.y - b.y); }

static void add(Line *l, Vec3 foot, double clearance, bool fixed, int room) {
    *ARENA_PUSH(l->arena, l->points, l->count, l->capacity) =
        (LinePoint){foot, fmin(clearance, KEEP), fixed, room};
}

// Where columns are farther apart than a body is wide, their clearance does not tell whether the line comes into a wall between them. There
// an eye keeps this far from walls, metres.
static const double EYE_KEEPS = 0.1;

static bool is_free_at(const TourFloor *f, Vec3 foot, int place) {
    static const Vec2 AROUND[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const FloorPlace *p = &f->places[place];
    if (f->apart <= BODY_RADIUS) return true;
    for (int k = 0; k < 4; k++) {
        Vec3 at = vec3(foot.x + EYE_KEEPS * AROUND[k].x, foot.y + EYE_KEEPS * AROUND[k].y,
                       p->foot.z + (double)p->eye);
        if (vis_locate(f->graph, at, p->cell) < 0) return false;
    }
    return true;
}

static bool is_free_between(const TourFloor *f, Vec3 a, Vec3 b) {
    int pieces = f->apart > BODY_RADIUS ? (int)ceil(plan_apart(a, b) / ROUTE_APART) : 0;
    for (int i = 1; i < pieces; i++) {
        Vec3 at = vec3_lerp(a, b, (double)i / pieces);
        int place = tour_floor_at(f, at);
        if (place < 0 || !is_free_at(f, at, place)) return false;
    }
    return true;
}

// ---- loops

static double turn_at(const TourFloor *f, const WayPlace *way, int count, int i) {
    int before = i, after = i;
    Vec3 at = f->places[way[i].place].foot;
    while (before > 0 && plan_apart(at, f->places[way[before].place].foot) < TURN_ARM) before--;
    while (after + 1 < count && plan_apart(at, f->places[way[after].place].foot) < TURN_ARM) after++;
    Vec3 a = f->places[way[before].place].foot, b = f->places[way[after].place].foot;
    if (plan_apart(a, at) < TURN_ARM / 2 || plan_apart(b, at) < TURN_ARM / 2) return 0;
    double in = atan2(at.y - a.y, at.x - a.x), out = atan2(b.y - at.y, b.x - at.x);
    return fabs(remainder(out - in, 2 * M_PI));
}

// A circle around the place at which the way turns back, from the side on which the way comes.
static void add_loop(Line *l, Vec3 middle, Vec3 from, double radius, int room) {
    double start = atan2(from.y - middle.y, from.x - middle.x);
    int steps = (int)ceil(2 * M_PI * radius / l->floor->apart);
    for (int i = 0; i <= steps; i++) {
        double angle = start + 2 * M_PI * i / steps;
        Vec3 at = vec3(middle.x + radius * cos(angle), middle.y + radius * sin(angle), middle.z);
        int place = tour_floor_at(l->floor, at);
        add(l, at, 0, true, place >= 0 && l->room_of[place] == room ? room : -1);
    }
}

// The points of the way, with a loop at each turn back.
static void lay_points(Line *l, const WayPlace *way, int count) {
    const TourFloor *f = l->floor;
    for (int i = 0; i < count; i++) {
        const FloorPlace *p = &f->places[way[i].place];
        bool back = i > 0 && i + 1 < count && way[i - 1].place == way[i + 1].place &&
                    turn_at(f, way, count, i) > TURN;
        double radius = fmin((double)p->clearance - 0.5 * f->apart, LOOP_MOST);
        if (!back || radius < LOOP_LEAST) {
            int room = way[i].stays ? l->room_of[way[i].place] : -1;
            add(l, p->foot, (double)p->clearance, back || room >= 0, room);
            continue;
        }
        int skip = 0;
        while (l->count > 0 && l->points[l->count - 1].room < 0 &&
               plan_apart(l->points[l->count - 1].foot, p->foot) < radius)
            l->count--;
        while (i + 1 + skip < count && !way[i + 1 + skip].stays &&
               plan_apart(f->places[way[i + 1 + skip].place].foot, p->foot) < radius)
            skip++;
        int before = i;
        while (before > 0 && plan_apart(f->places[way[before].place].foot, p->foot) < radius) before--;
        add_loop(l, p->foot, f->places[way[before].place].foot, radius,
                 way[i].stays ? l->room_of[way[i].place] : -1);
        i += skip;
    }
}

// ---- short cuts

static bool can_cut(const Line *l, int from, int to) {
    double keep = KEEP;
    for (int i = from; i <= to; i++) {
        if (l->points[i].fixed && i > from && i < to) return false;
        keep = fmin(keep, l->points[i].clearance);
    }
    return tour_floor_straight(l->floor, l->points[from].foot, l->points[to].foot, keep,
                               FLOOR_LOW | FLOOR_ON_THINGS | FLOOR_IN_THINGS) &&
           is_free_between(l->floor, l->points[from].foot, l->points[to].foot);
}

// The same line with points `ROUTE_APART` apart, and with straight sections where it made detours.
static Line cut_short(const Line *l) {
    Line out = {.floor = l->floor, .room_of = l->room_of, .arena = l->arena};
    int reach = (int)(CUT / l->floor->apart);
    for (int i = 0; i + 1 < l->count;) {
        int end = i + 1, step = 1;
        for (; i + end - i + step < l->count && end + step - i <= reach && can_cut(l, i, end + step);
             step *= 2)
            end += step;
        for (; step > 0; step /= 2)
            if (end + step < l->count && end + step - i <= reach && can_cut(l, i, end + step)) end += step;
        Vec3 a = l->points[i].foot, b = l->points[end].foot;
        double keep = fmin(l->points[i].clearance, l->points[end].clearance);
        int pieces = (int)fmax(1, round(plan_apart(a, b) / ROUTE_APART));
        for (int k = 0; k < pieces; k++)
            add(&out, vec3_lerp(a, b, (double)k / pieces), keep, k == 0 && l->points[i].fixed,
                k == 0 ? l->points[i].room : -1);
        i = end;
    }
    if (l->count > 0) add(&out, l->points[l->count - 1].foot, 0, true, -1);
    return out;
}

// ---- smoothing

// May the line pass here? The height is that of the place.
static bool may_pass(const TourFloor *f, Vec3 *foot, double clearance) {
    int p = tour_floor_at(f, *foot);
    if (p < 0) return false;
    const FloorPlace *place = &f->places[p];
    if (plan_apart(place->foot, *foot) > f->apart || (double)place->clearance < clearance ||
        !is_free_at(f, *foot, p))
        return false;
    foot->z = place->foot.z;
    return true;
}

static void smooth(Line *l) {
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 1; i + 1 < l->count; i++) {
            LinePoint *p = &l->points[i];
            Vec3 a = l->points[i - 1].foot, b = l->points[i + 1].foot;
            Vec3 to = vec3((a.x + b.x + 2 * p->foot.x) / 4, (a.y + b.y + 2 * p->foot.y) / 4, p->foot.z);
            int now = tour_floor_at(l->floor, p->foot);
            double clear = now >= 0 ? (double)l->floor->places[now].clearance : 0;
            if (!may_pass(l->floor, &to, fmin(p->clearance, clear))) continue;
            if (p->room < 0 || l->room_of[tour_floor_at(l->floor, to)] == p->room) p->foot = to;
        }
    }
}

// Points at even distances in plan.
static Line even(const Line *l) {
    Line out = {.floor = l->floor, .room_of = l->room_of, .arena = l->arena};
    double left = 0;
    for (int i = 0; i + 1 < l->count; i++) {
        Vec3 a = l->points[i].foot, b = l->points[i + 1].foot;
        double length = plan_apart(a, b);
        if (l->points[i].room >= 0) {
            // A small room may lie between two points.
            add(&out, a, l->points[i].clearance, false, l->points[i].room);
            left = ROUTE_APART;
        }
        for (; left < length; left += ROUTE_APART)
            add(&out, vec3_lerp(a, b, left / length), l->points[i].clearance, false, -1);
        left -= length;
    }
    if (l->count > 0) add(&out, l->points[l->count - 1].foot, 0, true, -1);
    return out;
}

// ---- eyes

// Heights of eyes: means of what the floor says, so that stairs are slopes; never above where a low beam lets the eye pass.
static void add_eyes(const Line *l, const int *room_of, Arena *arena, TourRoute *out) {
    const TourFloor *f = l->floor;
    int reach = (int)(STEADY / ROUTE_APART);
    Arena scratch = {0};
    double *eye = ARENA_ARRAY(&scratch, double, l->count + 1),
           *foot = ARENA_ARRAY(&scratch, double, l->count + 1);
    int *place = ARENA_ARRAY(&scratch, int, l->count + 1);
    for (int i = 0; i < l->count; i++) {
        place[i] = tour_floor_at(f, l->points[i].foot);
        foot[i] = place[i] >= 0 ? f->places[place[i]].foot.z : l->points[i].foot.z;
        eye[i] = foot[i] + (place[i] >= 0 ? (double)f->places[place[i]].eye : BODY_EYE);
    }
    for (int i = 0; i < l->count; i++) {
        double sum = 0, weights = 0;
        for (int k = -reach; k <= reach; k++) {
            int at = i + k < 0 ? 0 : i + k >= l->count ? l->count - 1 : i + k;
            double weight = reach + 1 - fabs((double)k);
            sum += weight * eye[at];
            weights += weight;
        }
        bool low = place[i] >= 0 && (f->places[place[i]].unfit & FLOOR_LOW);
        double height = low ? fmin(sum / weights, eye[i]) : sum / weights;
        *ARENA_PUSH(arena, out->points, out->point_count, out->point_capacity) =
            (RoutePoint){vec3(l->points[i].foot.x, l->points[i].foot.y, height), foot[i],
                         place[i] >= 0 ? room_of[place[i]] : -1};
    }
    arena_free(&scratch);
}

void tour_line_add(const TourFloor *floor, const int *room_of, const WayPlace *way, int count, Arena *arena,
                   TourRoute *out) {
    Arena scratch = {0};
    Line line = {.floor = floor, .room_of = room_of, .arena = &scratch};
    lay_points(&line, way, count);
    if (line.count > 1) {
        line = cut_short(&line);
        smooth(&line);
        line = even(&line);
    }
    add_eyes(&line, room_of, arena, out);
    arena_free(&scratch);
}
