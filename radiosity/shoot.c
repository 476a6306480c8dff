// shoot.c - radiosity by progressive refinement: the patch with most unshot power shoots to all elements, again and again.
//
// Source: M. F. Cohen, S. E. Chen, J. R. Wallace & D. P. Greenberg, A Progressive Refinement Approach to Fast Radiosity
// Image Generation, 1988: elements receive, patches shoot the mean of their elements, the strongest first.
// Departures: rows are made ahead, for several patches at a time, but shots happen one after the other in the order of
// power, as if each row had been made when it was needed. So neither threads, nor the memory for rows, nor where a run
// was broken off and resumed show in the result. What is unshot is what was emitted less what was absorbed and what
// escaped: no sum over all patches is needed to know when to stop.
#include "radiosity/shoot.h"

#include <stdio.h>

#include "engine/core/clock.h"
#include "radiosity/shoot_queue.h"
#include "radiosity/shoot_rows.h"

// Shots between two looks at the clock.
enum { SHOTS_A_LOOK = 64 };
// Rows are made ahead of patches with at least this share of the strongest one's power.
static const double WORTH_MAKING = 1.0 / 16;

RadOptions rad_default_options(void) {
    return (RadOptions){.method = form_factor_method("hemisphere"),
                        .form_factor = form_factor_default_options(),
                        .culling = CULL_PORTALS,
                        .residual = 0.001,
                        .row_bytes = (size_t)128 << 20};
}

static double sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

static void rgb3(Rgb c, double out[3]) {
    out[0] = (double)c.r;
    out[1] = (double)c.g;
    out[2] = (double)c.b;
}

static bool check_material(const Material *m, int face, Error *error) {
    double rho[3], e[3];
    rgb3(m->reflectance, rho);
    rgb3(m->emission, e);
    for (int c = 0; c < 3; c++) {
        if (!(rho[c] >= 0 && rho[c] < 1)) {
            return error_set(error,
                             "polygon %d has material %s of reflectance %g (allowed: at least 0, below 1)",
                             face, m->name ? m->name : "", rho[c]);
        }
        if (!(e[c] >= 0 && isfinite(e[c]))) {
            return error_set(error, "polygon %d has material %s of exitance %g W/m^2 (allowed: at least 0)",
                             face, m->name ? m->name : "", e[c]);
        }
    }
    return true;
}

bool rad_start(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error) {
    *out = (RadSolution){.element_count = mesh->element_count, .patch_count = mesh->patch_count};
    out->radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out->radiosity);
    out->unshot = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out->unshot);
    for (int f = 0; f < mesh->face_count; f++) {
        if (!check_material(mesh_material(mesh, f), mesh->faces[f].polygon, error)) return false;
    }
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        double e[3];
        rgb3(mesh_material(mesh, patch->face)->emission, e);
        for (int c = 0; c < 3; c++) {
            out->unshot[p][c] = e[c];
            out->emitted[c] += e[c] * patch->area;
            for (int i = 0; i < patch->element_count; i++) out->radiosity[patch->first_element + i][c] = e[c];
        }
    }
    if (sum3(out->emitted) > 0) return true;
    return error_set(error, "nothing emits light: none of the %d polygons has an emission", mesh->face_count);
}

// What a shot asks of each element, near together.
typedef struct Receiver {
    double per_area;  // 1 / m^2
    int patch;
} Receiver;

typedef struct Reflector {
    double reflectance[3];
    double area, per_area;
} Reflector;

typedef struct Shooter {
    const Mesh *mesh;
    const RadOptions *options;
    RadSolution *solution;
    Receiver *receivers;    // [element_count]
    Reflector *reflectors;  // [patch_count]
    ShootQueue queue;
    ShootRows *rows;
    int *next;  // [shoot_rows_wanted, as it is at first]
    double start;
} Shooter;

// Whatever comes in, the power is computed from the solution alone: a run that is resumed goes on just so.
static double unshot_power(const Shooter *s, int patch) {
    return sum3(s->solution->unshot[patch]) * s->reflectors[patch].area;
}

static void start(Shooter *s, const Mesh *mesh, const StabForest *forest, const float *door_open,
                  const RadOptions *options, RadSolution *solution, Arena *arena) {
    *s = (Shooter){.mesh = mesh, .options = options, .solution = solution, .start = clock_seconds()};
    s->rows = shoot_rows_new(mesh, forest, door_open, options, arena);
    s->next = ARENA_ARRAY(arena, int, shoot_rows_wanted(s->rows));
    s->receivers = ARENA_ARRAY(arena, Receiver, mesh->element_count);
    s->reflectors = ARENA_ARRAY(arena, Reflector, mesh->patch_count);
    for (int e = 0; e < mesh->element_count; e++)
        s->receivers[e] = (Receiver){1 / mesh->elements[e].area, mesh->elements[e].patch};
    shoot_queue_start(&s->queue, mesh->patch_count, arena);
    for (int p = 0; p < mesh->patch_count; p++) {
        s->reflectors[p].area = mesh->patches[p].area;
        s->reflectors[p].per_area = 1 / mesh->patches[p].area;
        rgb3(mesh_material(mesh, mesh->patches[p].face)->reflectance, s->reflectors[p].reflectance);
        shoot_queue_raise(&s->queue, p, unshot_power(s, p));
    }
}

// The elements of one patch in a row, from entry i on; returns where the next patch begins.
static int receive(Shooter *s, const ShootRow *row, int i, const double power[3]) {
    RadSolution *out = s->solution;
    int patch = s->receivers[row->element[i]].patch;
    const Reflector *to = &s->reflectors[patch];
    double reflected[3], share = 0;
    for (int c = 0; c < 3; c++) reflected[c] = power[c] * to->reflectance[c];
    for (; i < row->count; i++) {
        int e = row->element[i];
        if (s->receivers[e].patch != patch) break;
        double factor = (double)row->factor[i], per_area = factor * s->receivers[e].per_area;
        share += factor;
        for (int c = 0; c < 3; c++) out->radiosity[e][c] += reflected[c] * per_area;
    }
    for (int c = 0; c < 3; c++) {
        out->unshot[patch][c] += reflected[c] * share * to->per_area;
        out->absorbed[c] += (power[c] - reflected[c]) * share;
    }
    shoot_queue_raise(&s->queue, patch, unshot_power(s, patch));
    return i;
}

static void shoot(Shooter *s, int patch, const ShootRow *row) {
    RadSolution *out = s->solution;
    double power[3];
    for (int c = 0; c < 3; c++) {
        power[c] = out->unshot[patch][c] * s->reflectors[patch].area * row->scale;
        out->unshot[patch][c] = 0;
        out->absorbed[c] += power[c] * row->back;
        out->escaped[c] += power[c] * row->escaped;
    }
    shoot_queue_clear(&s->queue, patch);
    for (int i = 0; i < row->count;) i = receive(s, row, i, power);
    out->shots++;
}

static const ShootRow *row_of(Shooter *s, int patch) {
    const ShootRow *row = shoot_rows_of(s->rows, patch);
    if (row) return row;
    double least = s->queue.power[patch] * WORTH_MAKING;
    int count =
        shoot_queue_next(&s->queue, shoot_rows_there(s->rows), least, shoot_rows_wanted(s->rows), s->next);
    shoot_rows_make(s->rows, s->next, count);
    return shoot_rows_of(s->rows, patch);
}

static double residual_of(const RadSolution *solution) {
    double emitted = sum3(solution->emitted);
    return (emitted - sum3(solution->absorbed) - sum3(solution->escaped)) / emitted;
}

// Residuals fall about exponentially, once the lamps have shot.
static bool go_on(const Shooter *s, const Progress *progress, bool *stopped) {
    const RadOptions *o = s->options;
    double residual = residual_of(s->solution), done = 0;
    if (o->residual > 0 && o->residual < 1) done = log(fmax(residual, o->residual)) / log(o->residual);
    if (o->shots > 0) done = fmax(done, (double)s->solution->shots / (double)o->shots);
    double seconds = clock_seconds() - s->start;
    if (o->seconds > 0) done = fmax(done, seconds / o->seconds);
    char stage[64];
    snprintf(stage, sizeof stage, "residual %.2g %%", 100 * residual);
    *stopped = !progress_report(progress, stage, fmin(fmax(done, 0), 1));
    return !*stopped && (o->seconds <= 0 || seconds < o->seconds);
}

RadReport rad_shoot(const Mesh *mesh, const StabForest *forest, const float *door_open,
                    const RadOptions *options, const Progress *progress, RadSolution *solution) {
    Arena arena = {0};
    Shooter s;
    RadReport report = {0};
    start(&s, mesh, forest, door_open, options, solution, &arena);
    long long first = solution->shots;
    while (residual_of(solution) > options->residual) {
        if (options->shots > 0 && solution->shots >= options->shots) break;
        if ((solution->shots - first) % SHOTS_A_LOOK == 0 && !go_on(&s, progress, &report.stopped)) break;
        int patch = shoot_queue_top(&s.queue);
        if (patch < 0) break;
        shoot(&s, patch, row_of(&s, patch));
    }
    report.residual = residual_of(solution);
    report.shots = solution->shots - first;
    shoot_rows_report(s.rows, &report);
    report.seconds = clock_seconds() - s.start;
    shoot_rows_end(s.rows);
    arena_free(&arena);
    return report;
}

void rad_gather(const RadSolution *solution, const Row *row, double irradiance[3]) {
    irradiance[0] = irradiance[1] = irradiance[2] = 0;
    for (int i = 0; i < row->count; i++) {
        for (int c = 0; c < 3; c++)
            irradiance[c] += (double)row->factor[i] * solution->radiosity[row->element[i]][c];
    }
}
