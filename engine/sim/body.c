// body.c - the walking body.
//
// A way is cut into pieces. For each piece a disc is swept in plan against the parts of solids that are too high to step
// over and too low to duck under, and slides along the solids that it meets; then the foot goes to the highest solid
// under the disc within a step. Whatever the result of the sweep, the place is checked once more before the body takes it,
// so that no piece leads into a wall. The body leaves a cell through portals only (Oki 3.2, see obstacles.c).
#include "engine/sim/body.h"

#include "engine/core/error.h"

// The disc halts this far from a solid that it meets, metres: a hundred times the tolerance, too little to be visible.
static const double SKIN = 1e-4;
// A piece of a way is no longer than this, metres: half the radius, so that no stair's tread is passed over.
static const double PIECE = BODY_RADIUS / 2;
// The height of a step is measured from the ground under the body's middle, a disc of this radius, metres.
static const double MIDDLE = BODY_RADIUS / 2;
// A piece of a way shorter than this leads nowhere, metres.
static const double NOWHERE = 1e-9;
// The body climbs a solid that it cannot stand on at most this far above a solid that it can stand on, metres: thresholds, rounded
// edges. Otherwise the body would climb cushions and leaves a hair's breadth at a time.
static const double ROUGH = 0.05;
// A body whose middle is over no ground may still rise this much, metres; otherwise the rounded back of a chair would hold the body
// by its rim for ever.
static const double RIM = 0.02;
enum { MOST_CONTACTS = 4, MOST_ATTEMPTS = 5 };
static const double GRAVITY = 9.81;    // m/s^2
static const double TERMINAL = 50.0;   // m/s: of a person in air
static const double DEEPEST = 1000.0;  // metres: no storey is higher
// Places that are tried in the search for a free place are this far apart, metres.
static const double PLACES_APART = 0.1;

BodyWorld body_world(const CellGraph *graph, const float *door_open, Arena *arena) {
    return (BodyWorld){.graph = graph, .door_open = door_open, .obstacles = obstacles_new(graph, arena)};
}

static Vec2 plan_of(Vec3 p) { return vec2(p.x, p.y); }

static Gathered gather_ground(BodyWorld *w, int cell, Vec2 at, double radius, double z0, double z1) {
    Gathered g = obstacles_gather(w->obstacles, w->door_open, cell, at, radius + 2 * SKIN, (Band){z0, z1});
    w->wall_tests += g.wall_tests;
    w->object_tests += g.object_tests;
    return g;
}

// The solids over and under the disc of a foot at some height.
typedef struct Ground {
    bool blocked;    // by a solid too high to step over and too low to duck under
    double support;  // the top of the highest solid below, -INFINITY if there is none
    double footing;  // the same among solids that are not too steep to stand on
    double ceiling;  // the underside of the lowest solid above, INFINITY if there is none
    double head;     // the same over the middle of the disc, where the head is
} Ground;

static Ground ground_at(const Gathered *g, Vec2 at, double radius, double foot, double step) {
    Ground ground = {.support = -INFINITY, .footing = -INFINITY, .ceiling = INFINITY, .head = INFINITY};
    for (int i = 0; i < g->solid_count && !ground.blocked; i++) {
        const Solid *s = &g->solids[i];
        Band z;
        if (s->box.min.x - at.x >= radius || at.x - s->box.max.x >= radius) continue;
        if (s->box.min.y - at.y >= radius || at.y - s->box.max.y >= radius) continue;
        if (!solid_levels(s, at, radius, &z)) continue;
        if (z.z1 <= foot + step) {
            ground.support = fmax(ground.support, z.z1);
            if (!s->steep) ground.footing = fmax(ground.footing, z.z1);
        } else if (z.z0 >= foot + BODY_LOWEST) {
            ground.ceiling = fmin(ground.ceiling, z.z0);
            if (solid_levels(s, at, BODY_HEAD, &z)) ground.head = fmin(ground.head, z.z0);
        } else {
            ground.blocked = true;
        }
    }
    return ground;
}

// Would the body climb onto a solid that it cannot stand on?
static bool is_rough(const Ground *ground, double foot) {
    return ground->support > foot && ground->support > ground->footing + ROUGH;
}

// How much higher the body may step: at most BODY_STEP above the solid under its middle, so that nobody climbs a bed by its rim.
// Treads are deeper than the middle is wide.
static double step_left(const Body *b, const Gathered *g) {
    if (!b->standing) return 0;
    Ground under = ground_at(g, plan_of(b->foot), MIDDLE, b->foot.z, 0);
    return fmax(RIM, fmax(under.support, b->foot.z - BODY_STEP) + BODY_STEP - b->foot.z);
}

static void note_place(BodyWorld *w, Vec3 foot) {
    BodyTrace *t = w->trace;
    if (!t) return;
    if (t->count < t->capacity) {
        t->points[t->count++] = foot;
    } else {
        t->overflow = true;
    }
}

// ---- a piece of a way

// The points at which a slide turns, in plan.
typedef struct Slide {
    Vec2 at[MOST_CONTACTS + 2];
    int count;
} Slide;

// The share of the way after which the disc meets the first solid, and the normal there; 1, and no normal, if it meets none.
static double first_contact(const Gathered *g, Band band, Vec2 from, Vec2 way, Vec2 *normal) {
    double first = 1;
    for (int i = 0; i < g->solid_count; i++) {
        Vec2 n;
        double t = solid_sweep(&g->solids[i], band, from, way, BODY_RADIUS + SKIN, &n);
        if (t >= first) continue;
        first = t;
        *normal = n;
    }
    return first;
}

static Slide slide(const Gathered *g, Band band, Vec2 from, Vec2 way) {
    Slide s = {.at = {from}, .count = 1};
    Vec2 normals[MOST_CONTACTS];
    for (int contacts = 0; contacts < MOST_CONTACTS; contacts++) {
        double length = vec2_length(way);
        if (length < NOWHERE) break;
        double t = first_contact(g, band, from, way, &normals[contacts]);
        from = vec2_add(from, vec2_scale(way, t));
        if (t > 0) s.at[s.count++] = from;
        if (t >= 1) break;
        Vec2 n = normals[contacts];
        way = vec2_scale(way, 1 - t);
        way = vec2_sub(way, vec2_scale(n, vec2_dot(n, way)));
        // A crease: the direction that leads past one wall leads into another.
        bool crease = false;
        for (int i = 0; i < contacts; i++) crease = crease || vec2_dot(way, normals[i]) < -NOWHERE * length;
        if (crease) break;
    }
    return s;
}

// Follows the slide from cell to cell, rising first and sinking last. Returns the last cell, -1 where the slide would leave the
// cells.
static int follow_slide(BodyWorld *w, const Body *b, const Slide *s, double foot) {
    double start = b->foot.z + BODY_MIDDLE, end = foot + BODY_MIDDLE, level = fmax(start, end);
    int cell = b->cell;
    Vec3 from = vec3(s->at[0].x, s->at[0].y, start);
    for (int i = 0; i <= s->count && cell >= 0; i++) {
        Vec2 at = s->at[i < s->count ? i : s->count - 1];
        Vec3 to = vec3(at.x, at.y, i < s->count ? level : end);
        cell = obstacles_cross(w->obstacles, cell, from, to);
        from = to;
    }
    return cell;
}

static void take_place(Body *b, BodyWorld *w, const Slide *s, double foot, int cell, const Ground *ground) {
    double level = fmax(b->foot.z, foot);
    for (int i = 0; i < s->count; i++) note_place(w, vec3(s->at[i].x, s->at[i].y, level));
    b->foot = vec3(s->at[s->count - 1].x, s->at[s->count - 1].y, foot);
    b->cell = cell;
    b->height = fmin(BODY_HEIGHT, ground->ceiling - foot);
    b->head = fmin(BODY_HEIGHT, ground->head - foot);
    note_place(w, b->foot);
}

// A slide to another end may be possible when more solids count as walls: one that hangs low over a step up, or one that cannot be
// stood on. Returns false when all of them count as walls already.
static bool widen_band(Band *band, const Ground *ground, double old_foot, double foot) {
    Band was = *band;
    if (ground->blocked) return false;
    if (ground->ceiling - foot < BODY_LOWEST) band->z1 = fmax(band->z1, foot + BODY_LOWEST);
    if (is_rough(ground, old_foot)) band->z0 = old_foot;
    return band->z0 < was.z0 || band->z1 > was.z1;
}

// If the body cannot stand at the end of a slide, the piece is tried again with more solids as walls, then shorter. Returns false
// if the body did not move.
static bool walk_piece(Body *b, BodyWorld *w, Vec2 way) {
    double start = b->foot.z;
    Vec2 from = plan_of(b->foot);
    Gathered g = gather_ground(w, b->cell, from, BODY_RADIUS + vec2_length(way), start - BODY_STEP,
                               start + BODY_STEP + BODY_HEIGHT);
    double step = step_left(b, &g);
    Band band = {start + step, start + BODY_LOWEST};
    w->pieces++;
    for (int attempt = 0; attempt < MOST_ATTEMPTS; attempt++) {
        Slide s = slide(&g, band, from, way);
        if (s.count == 1) return false;
        Ground ground = ground_at(&g, s.at[s.count - 1], BODY_RADIUS, start, step);
        bool carried = b->standing && ground.support >= start - BODY_STEP;
        double foot = carried ? ground.support : start;
        if (!ground.blocked && ground.ceiling - foot >= BODY_LOWEST && !is_rough(&ground, start)) {
            int cell = follow_slide(w, b, &s, foot);
            if (cell >= 0) {
                take_place(b, w, &s, foot, cell, &ground);
                b->standing = carried;
                return true;
            }
        }
        if (!widen_band(&band, &ground, start, foot)) way = vec2_scale(way, 0.5);
    }
    w->refused++;
    return false;
}

// ---- up and down

// Lowers the body by `drop`, or onto the first solid below it.
static void sink(Body *b, BodyWorld *w, double drop) {
    Vec2 at = plan_of(b->foot);
    Gathered g = gather_ground(w, b->cell, at, BODY_RADIUS, b->foot.z - drop, b->foot.z + BODY_HEIGHT);
    Ground ground = ground_at(&g, at, BODY_RADIUS, b->foot.z, 0);
    double foot = fmax(ground.support, b->foot.z - drop);
    Slide still = {.at = {at}, .count = 1};
    int cell = ground.blocked ? -1 : follow_slide(w, b, &still, foot);
    // Where a floor is missing, there is no cell into which the body could fall.
    if (cell < 0) foot = b->foot.z;
    b->standing = cell < 0 || foot == ground.support;
    if (b->standing) b->fall = 0;
    if (cell >= 0) take_place(b, w, &still, foot, cell, &ground);
}

static void fall(Body *b, BodyWorld *w, double seconds) {
    if (seconds <= 0) return;
    double drop = fmin(b->fall * seconds + GRAVITY * seconds * seconds / 2, TERMINAL * seconds);
    b->fall = fmin(b->fall + GRAVITY * seconds, TERMINAL);
    sink(b, w, fmin(drop, DEEPEST));
}

// ---- free places

// Puts the body at this place, on the ground under it, if there is room; false if not. `region` -1: in any region.
static bool try_place(Body *b, BodyWorld *w, Vec3 foot, int region) {
    int cell = vis_locate(w->graph, vec3(foot.x, foot.y, foot.z + BODY_MIDDLE), -1);
    if (cell < 0 || (region >= 0 && w->graph->cells[cell].region != region)) return false;
    if (obstacles_is_shut(w->obstacles, cell)) return false;
    Gathered g = gather_ground(w, cell, plan_of(foot), BODY_RADIUS, foot.z - DEEPEST,
                               foot.z + BODY_STEP + BODY_HEIGHT);
    Ground ground = ground_at(&g, plan_of(foot), BODY_RADIUS, foot.z, BODY_STEP);
    if (ground.blocked || !isfinite(ground.support) || ground.ceiling - ground.support < BODY_LOWEST)
        return false;
    Body placed = {.foot = foot, .cell = cell, .standing = true};
    Slide still = {.at = {plan_of(foot)}, .count = 1};
    cell = follow_slide(w, &placed, &still, ground.support);
    if (cell < 0) return false;
    take_place(&placed, w, &still, ground.support, cell, &ground);
    *b = placed;
    return true;
}

bool body_place_at(Body *b, BodyWorld *w, Vec3 foot) { return try_place(b, w, foot, -1); }

// The height nearest to foot.z at which a body may stand over a place in some cell; NAN if there is none.
static double nearest_height(const CellGraph *graph, Vec3 foot) {
    const SquareGrid *grid = &graph->locator;
    double i = floor((foot.x - grid->origin.x) / grid->size),
           j = floor((foot.y - grid->origin.y) / grid->size);
    double best = NAN;
    if (!(i >= 0 && j >= 0 && i < grid->nx && j < grid->ny)) return best;
    int square = (int)j * grid->nx + (int)i;
    for (int k = graph->locator_first[square]; k < graph->locator_first[square + 1]; k++) {
        int c = graph->locator_cells[k];
        const Cell *cell = &graph->cells[c];
        if (cell->z1 - cell->z0 < BODY_LOWEST) continue;
        if (vis_locate(graph, vec3(foot.x, foot.y, (cell->z0 + cell->z1) / 2), c) != c) continue;
        double z = fmax(cell->z0, fmin(foot.z, cell->z1 - BODY_LOWEST));
        if (!(fabs(z - foot.z) >= fabs(best - foot.z))) best = z;
    }
    return best;
}

// Tries the places on ever wider rings around `foot`.
static bool search_rings(Body *b, BodyWorld *w, Vec3 foot, int region) {
    for (double ring = 0; ring <= BODY_SEARCH; ring += PLACES_APART) {
        int places = (int)fmax(1, ceil(2 * M_PI * ring / PLACES_APART));
        for (int i = 0; i < places; i++) {
            double angle = 2 * M_PI * i / places;
            Vec3 at = vec3(foot.x + ring * cos(angle), foot.y + ring * sin(angle), foot.z);
            at.z = nearest_height(w->graph, at);
            if (isfinite(at.z) && try_place(b, w, at, region)) return true;
        }
    }
    return false;
}

bool body_place_near(Body *b, BodyWorld *w, Vec3 foot) {
    int cell = vis_locate(w->graph, vec3(foot.x, foot.y, foot.z + BODY_MIDDLE), -1);
    if (cell >= 0 && search_rings(b, w, foot, w->graph->cells[cell].region)) return true;
    return search_rings(b, w, foot, -1);
}

// ---- steps

static bool is_free(const Body *b, BodyWorld *w) {
    if (b->cell < 0) return false;
    Gathered g = gather_ground(w, b->cell, plan_of(b->foot), BODY_RADIUS, b->foot.z, b->foot.z + BODY_LOWEST);
    return !ground_at(&g, plan_of(b->foot), BODY_RADIUS, b->foot.z, 0).blocked;
}

void body_step(Body *b, BodyWorld *w, Vec2 way, double seconds) {
    if (!is_free(b, w)) {
        w->relocations++;
        if (!body_place_near(b, w, b->foot)) return;
    }
    note_place(w, b->foot);
    double length = vec2_length(way);
    CORE_ASSERT(isfinite(length));
    int pieces = (int)ceil(length / PIECE);
    double share = seconds / fmax(1, pieces);
    for (int i = 0; i < pieces; i++) {
        // A solid that stopped the body once stops it again.
        if (!walk_piece(b, w, vec2_scale(way, 1.0 / pieces))) break;
        seconds -= share;
        if (!b->standing) fall(b, w, share);
    }
    fall(b, w, fmax(seconds, 0));
}
