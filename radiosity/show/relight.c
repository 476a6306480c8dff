// relight.c - doors move, rows and direct light that pass them go, and all is shot again.
#include "radiosity/show/relight.h"

#include <math.h>
#include <string.h>

#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"

// A state leaves no more than this share of its light unshot: rooms that little of it reaches have only what is shot last.
static const double RESIDUAL = 1e-6;

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

static void move_doors(Relight *r, const float *door_open, RelightReport *report) {
    Arena scratch = {0};
    int openings = r->mesh->graph->building->opening_count;
    MovedDoors moved = mesh_move(r->mesh, r->door_open, door_open, &scratch);
    memcpy(r->door_open, door_open, (size_t)openings * sizeof *door_open);
    report->doors = moved.count;
    if (moved.count > 0) {
        report->rows = shoot_rows_move(r->options->rows, &moved);
        report->points = direct_sources_move(r->sources, &moved, door_open);
    }
    arena_free(&scratch);
}

// The share of its full light that each source sends.
static double (*shares_of(const Relight *r, const Rgb *lit, Arena *arena))[3] {
    double(*share)[3] = arena_alloc(arena, (size_t)r->lamps->count + 1, sizeof *share);
    for (int i = 0; i < r->lamps->count; i++) rgb_doubles(lit[i], share[i]);
    for (int c = 0; c < 3; c++) share[r->lamps->count][c] = daylight_shines(&r->all->day);
    return share;
}

void relight_straight(Relight *r, const float *door_open, const Rgb *lit, const RadSolution *before,
                      Arena *arena, RadSolution *out, RelightReport *report) {
    RelightReport work;
    if (!report) report = &work;
    *report = (RelightReport){0};
    move_doors(r, door_open, report);
    direct_show_straight(r->sources, shares_of(r, lit, arena), before, arena, out);
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
    const Daylight *day = &r->all->day;
    bool shines = daylight_shines(day);
    if (shines && !rad_shine(mesh, r->forest, r->door_open, r->options, day, progress, out)) return false;
    RadOptions options = *r->options;
    options.residual = fmin(options.residual, RESIDUAL);
    if (rad_shoot(mesh, r->forest, r->door_open, &options, progress, out).stopped) return false;
    memcpy(out->noise, r->all->noise, (size_t)out->patch_count * sizeof *out->noise);
    out->lit = lit;
    out->lamp_count = r->lamps->count;
    out->shown = r->all->shown;
    return direct_show_source(r->sources, shares_of(r, lit, arena), mesh, progress, arena, out);
}
