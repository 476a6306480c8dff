// relight.c - doors move, rows and direct light that pass them go, and what was shot along these rows is shot again.
#include "radiosity/follow/relight.h"

#include <math.h>
#include <string.h>

#include "engine/core/error.h"
#include "radiosity/follow/each_lamp.h"
#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"

// A state leaves no more than this share of its light unshot: rooms that little of it reaches have only what is shot last. Twice as much
// left makes the worst hundredth of the nodes of small rooms by day .6 % off instead of .3 %.
static const double RESIDUAL = 1e-5;

void relight_prepare(DirectSources *sources, Mesh *mesh, Arena *arena) {
    enum { CLOSED, OPEN, STATES };
    const Building *b = mesh->graph->building;
    const float **state = ARENA_ARRAY(arena, const float *, STATES);
    bool any = false;
    for (int i = 0; i < STATES; i++) {
        float *doors = ARENA_ARRAY(arena, float, b->opening_count + 1);
        for (int k = 0; k < b->opening_count; k++) {
            bool door = b->openings[k].kind == OPENING_DOOR;
            doors[k] = door && i == CLOSED ? 0 : 1;
            any = any || door;
        }
        state[i] = doors;
    }
    if (any) direct_sources_doors(sources, mesh, state, STATES);
}

// The light that was found last, less what doors that moved since have changed, and what it began with.
typedef struct RelightLast {
    Arena arena;
    bool there;
    RadSolution light, begun;
    Rgb *lit;  // [lamps->count]
    RadFollow follow;
    bool gathered;             // `follow` and `light` tell what was gathered last,
    const double (*shown)[3];  // and this is RadSolution.rest of what was shown of it
} RelightLast;

static RelightLast *last_of(Relight *r) {
    if (r->last) return r->last;
    Arena arena = {0};
    RelightLast *last = ARENA_ARRAY(&arena, RelightLast, 1);
    Error error;
    bool good = rad_start_dark(r->mesh, &arena, &last->light, &error) &&
                rad_start_dark(r->mesh, &arena, &last->begun, &error);
    CORE_ASSERT(good);
    last->lit = ARENA_ARRAY(&arena, Rgb, r->lamps->count + 1);
    size_t patches = (size_t)r->mesh->patch_count + 1, elements = (size_t)r->mesh->element_count + 1;
    last->follow = (RadFollow){.again = ARENA_ARRAY(&arena, bool, patches),
                               .taken = arena_alloc(&arena, patches, sizeof *last->follow.taken),
                               .dropped = ARENA_ARRAY(&arena, bool, patches),
                               .gathered = arena_alloc(&arena, elements, sizeof *last->follow.gathered),
                               .found = marks_new(r->mesh->patch_count, &arena)};
    last->arena = arena;
    return r->last = last;
}

static void forget_last(Relight *r) {
    if (!r->last) return;
    Arena arena = r->last->arena;
    arena_free(&arena);
    r->last = NULL;
}

// Copies all that a shot changes.
static void copy_light(const RadSolution *from, RadSolution *to) {
    size_t elements = (size_t)from->element_count, patches = (size_t)from->patch_count;
    memcpy(to->radiosity, from->radiosity, elements * sizeof *to->radiosity);
    memcpy(to->direct, from->direct, elements * sizeof *to->direct);
    memcpy(to->daylight, from->daylight, elements * sizeof *to->daylight);
    memcpy(to->unshot, from->unshot, patches * sizeof *to->unshot);
    memcpy(to->shot, from->shot, patches * sizeof *to->shot);
    memcpy(to->emitted, from->emitted, sizeof to->emitted);
    memcpy(to->absorbed, from->absorbed, sizeof to->absorbed);
    memcpy(to->escaped, from->escaped, sizeof to->escaped);
    to->shots = from->shots;
}

static bool same_lamps(const Relight *r, const Rgb *lit) {
    return memcmp(lit, r->last->lit, (size_t)r->lamps->count * sizeof *lit) == 0;
}

// Goes on from the last light: `out`, which has begun, gets what was shot since that one began.
static void take_last(const Relight *r, RadSolution *out) {
    const RadSolution *light = &r->last->light, *begun = &r->last->begun;
    for (int e = 0; e < out->element_count; e++)
        for (int c = 0; c < 3; c++) {
            out->radiosity[e][c] += light->radiosity[e][c] - begun->radiosity[e][c];
            out->direct[e][c] = light->direct[e][c];
        }
    for (int p = 0; p < out->patch_count; p++)
        for (int c = 0; c < 3; c++) {
            out->unshot[p][c] += light->unshot[p][c] - begun->unshot[p][c];
            out->shot[p][c] = light->shot[p][c];
        }
    for (int c = 0; c < 3; c++) {
        out->absorbed[c] += light->absorbed[c] - begun->absorbed[c];
        out->escaped[c] += light->escaped[c] - begun->escaped[c];
    }
    out->shots = light->shots;
}

static void move_doors(Relight *r, const float *door_open, RelightReport *report) {
    Arena scratch = {0};
    RelightLast *last = last_of(r);
    int openings = r->mesh->graph->building->opening_count;
    MovedDoors moved = mesh_move(r->mesh, r->door_open, door_open, &scratch);
    memcpy(r->door_open, door_open, (size_t)openings * sizeof *door_open);
    report->doors = moved.count;
    if (moved.count > 0) {
        Mesh lit = lamps_mesh(r->lamps, r->mesh, last->lit, &scratch);
        last->there = last->there && rad_take_back(&lit, r->options, &moved, &last->light, &last->follow);
        report->rows = shoot_rows_move(r->options->rows, &moved, last->follow.dropped);
        report->points = direct_sources_move(r->sources, &moved, door_open);
        if (r->options->sky) sky_looks_move(r->options->sky, &moved);
    }
    arena_free(&scratch);
}

static void copy_gathered(const RadSolution *from, RadSolution *to) {
    size_t patches = (size_t)from->patch_count;
    memcpy(to->reflected, from->reflected, patches * sizeof *to->reflected);
    memcpy(to->noise, from->noise, patches * sizeof *to->noise);
}

// All light of a state, shot on from the last one where the lamps are the same. `changed`: the patches whose light then differs from what
// they had; NULL: all.
static bool shoot_state(Relight *r, const Mesh *mesh, const Rgb *lit, const Progress *progress,
                        RadSolution *out, const Marks **changed) {
    RelightLast *last = r->last;
    RadOptions options = *r->options;
    const bool on = last->there && same_lamps(r, lit) && last->gathered;
    options.residual = fmin(options.residual, RESIDUAL);
    last->there = last->gathered = false;
    Arena scratch = {0};
    RadSolution begun = *out;
    begun.radiosity = arena_alloc(&scratch, (size_t)out->element_count + 1, sizeof *begun.radiosity);
    begun.direct = arena_alloc(&scratch, (size_t)out->element_count + 1, sizeof *begun.direct);
    begun.daylight = arena_alloc(&scratch, (size_t)out->element_count + 1, sizeof *begun.daylight);
    begun.unshot = arena_alloc(&scratch, (size_t)out->patch_count + 1, sizeof *begun.unshot);
    begun.shot = arena_alloc(&scratch, (size_t)out->patch_count + 1, sizeof *begun.shot);
    copy_light(out, &begun);
    if (on) {
        take_last(r, out);
        copy_gathered(&last->light, out);
    }
    RadReport report =
        rad_shoot_on(mesh, r->forest, r->door_open, &options, on ? &last->follow : NULL, progress, out);
    if (!report.stopped) {
        copy_light(out, &last->light);
        copy_light(&begun, &last->begun);
        memcpy(last->lit, lit, (size_t)r->lamps->count * sizeof *lit);
        memset(last->follow.again, 0, (size_t)out->patch_count * sizeof *last->follow.again);
        memset(last->follow.taken, 0, (size_t)out->patch_count * sizeof *last->follow.taken);
        if (!on) {
            memcpy(last->follow.gathered, out->radiosity,
                   (size_t)out->element_count * sizeof *last->follow.gathered);
            memset(last->follow.dropped, 0, (size_t)out->patch_count * sizeof *last->follow.dropped);
        }
        memcpy(out->noise, r->all->noise, (size_t)out->patch_count * sizeof *out->noise);
        copy_gathered(out, &last->light);
        last->there = last->gathered = true;
    }
    *changed = on ? &last->follow.found : NULL;
    arena_free(&scratch);
    return !report.stopped;
}

// The share of its full light that each source sends.
static double (*shares_of(const Relight *r, const Rgb *lit, Arena *arena))[3] {
    double(*share)[3] = arena_alloc(arena, (size_t)r->lamps->count + 1, sizeof *share);
    for (int i = 0; i < r->lamps->count; i++) rgb_doubles(lit[i], share[i]);
    for (int c = 0; c < 3; c++) share[r->lamps->count][c] = daylight_shines(r->day);
    return share;
}

void relight_straight(Relight *r, const float *door_open, const Rgb *lit, const RadSolution *before,
                      Arena *arena, RadSolution *out, RelightReport *report) {
    RelightReport work;
    if (!report) report = &work;
    *report = (RelightReport){0};
    move_doors(r, door_open, report);
    bool last = r->last->gathered && r->last->shown == (const double(*)[3])before->rest;
    direct_show_straight(r->sources, shares_of(r, lit, arena), before, last, arena, out);
}

bool relight_state(Relight *r, const float *door_open, const Rgb *lit, const Progress *progress, Arena *arena,
                   RadSolution *out, RelightReport *report) {
    RelightReport work;
    Error error;
    if (!report) report = &work;
    *report = (RelightReport){0};
    move_doors(r, door_open, report);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    *mesh = lamps_mesh(r->lamps, r->mesh, lit, arena);
    if (!rad_start_dark(mesh, arena, out, &error)) return false;
    bool shines = daylight_shines(r->day);
    if (shines && !rad_shine(mesh, r->forest, r->door_open, r->options, r->day, progress, out)) return false;
    const Marks *changed;
    if (!shoot_state(r, mesh, lit, progress, out, &changed)) return false;
    out->lit = lit;
    out->lamp_count = r->lamps->count;
    out->shown = r->all->shown;
    bool good = direct_show_next(r->sources, shares_of(r, lit, arena), mesh, changed, progress, arena, out);
    r->last->gathered = good;
    r->last->shown = good ? (const double(*)[3])out->rest : NULL;
    return good;
}

// ---- hours

// Light straight from lamps, which does not change with the hour.
typedef struct RelightLamps {
    Arena arena;
    DirectSources *sources;
    float *door_open;  // [opening_count] as they stand there
    double level;      // of the day in whose light the lamps are seen, W/m^2
} RelightLamps;

// The mesh of the lamps is as fine as it is seen by day: at dusk, when the day has so many times less light or more, it is made anew.
static const double MOST_BRIGHTER = 4;

static double level_of(const Daylight *day) {
    double light[3];
    daylight_horizontal(day, light);
    return rgb_sum(light);
}

static void forget_lamps(Relight *r) {
    if (!r->lamps_alone) return;
    direct_sources_end(r->lamps_alone->sources);
    Arena arena = r->lamps_alone->arena;
    arena_free(&arena);
    r->lamps_alone = NULL;
}

void relight_end(Relight *r) {
    forget_last(r);
    forget_lamps(r);
    arena_free(&r->before);
}

// They are known already: with the doors where they are now.
static void move_lamps(const Relight *r) {
    Arena scratch = {0};
    RelightLamps *alone = r->lamps_alone;
    mesh_pose(r->mesh, alone->door_open);
    MovedDoors moved = mesh_move(r->mesh, alone->door_open, r->door_open, &scratch);
    memcpy(alone->door_open, r->door_open,
           (size_t)r->mesh->graph->building->opening_count * sizeof *alone->door_open);
    if (moved.count > 0) direct_sources_move(alone->sources, &moved, r->door_open);
    arena_free(&scratch);
}

// In the light of a solution of r->day. False where progress asked to stop.
static bool find_lamps(Relight *r, const RadSolution *solution, const Progress *progress) {
    size_t openings = (size_t)r->mesh->graph->building->opening_count;
    double level = level_of(r->day);
    if (r->lamps_alone &&
        fmax(level, r->lamps_alone->level) <= MOST_BRIGHTER * fmin(level, r->lamps_alone->level)) {
        move_lamps(r);
        return true;
    }
    forget_lamps(r);
    Arena arena = {0};
    RelightLamps *alone = ARENA_ARRAY(&arena, RelightLamps, 1);
    alone->door_open = ARENA_ARRAY(&arena, float, openings + 1);
    memcpy(alone->door_open, r->door_open, openings * sizeof *alone->door_open);
    alone->sources = each_lamp_sources(r->mesh, r->lamps, r->options->threads, &arena);
    alone->level = level;
    relight_prepare(alone->sources, r->mesh, &arena);
    alone->arena = arena;
    r->lamps_alone = alone;
    bool good = direct_show_lamps(r->mesh, r->forest, alone->door_open, r->options->threads, progress,
                                  solution, alone->sources);
    if (!good) forget_lamps(r);
    return good;
}

// The light of r->day, all lamps lit, on a mesh of its own.
static bool find_turned(Relight *r, DirectSources *sources, const Progress *progress, Arena *arena,
                        RadSolution *out) {
    Error error;
    if (!rad_start_dark(r->mesh, arena, out, &error) ||
        !rad_shine(r->mesh, r->forest, r->door_open, r->options, r->day, progress, out) ||
        rad_shoot(r->mesh, r->forest, r->door_open, r->options, progress, out).stopped ||
        !find_lamps(r, out, progress))
        return false;
    direct_sources_turn(sources, r->lamps_alone->sources, r->sources);
    return direct_show_apart(r->mesh, r->forest, r->door_open, r->options->threads, progress, arena, out,
                             sources, NULL, NULL);
}

bool relight_turn(Relight *r, const Daylight *day, const float *door_open, const Progress *progress,
                  Arena *arena, RadSolution *out) {
    RelightReport work = {0};
    const Daylight before = *r->day;
    CORE_ASSERT(daylight_shines(&before) && daylight_shines(day) && r->options->sky);
    move_doors(r, door_open, &work);
    *r->day = *day;
    shoot_rows_turn(r->options->rows);
    DirectSources *sources = each_lamp_sources(r->mesh, r->lamps, r->options->threads, arena);
    relight_prepare(sources, r->mesh, arena);
    bool good = find_turned(r, sources, progress, arena, out);
    if (good) {
        forget_last(r);
        arena_free(&r->before);
        r->before = direct_sources_leave(r->sources);
        r->sources = sources;
        r->all = out;
    } else {
        direct_sources_end(sources);
        *r->day = before;
        shoot_rows_turn(r->options->rows);
    }
    return good;
}
