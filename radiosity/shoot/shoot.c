// shoot.c - radiosity by progressive refinement: the patch with most unshot power shoots to all elements, again and again.
//
// Source: M. F. Cohen, S. E. Chen, J. R. Wallace & D. P. Greenberg, A Progressive Refinement Approach to Fast Radiosity
// Image Generation, 1988: elements receive, patches shoot the mean of their elements, the strongest first.
// Departures: rows are made ahead, for several patches at a time, but shots happen one after the other in the order of
// power, as if each row had been made when it was needed. So neither threads, nor the memory for rows, nor where a run
// was broken off and resumed show in the result. What is unshot is what was emitted less what was absorbed and what
// escaped: no sum over all patches is needed to know when to stop.
#include "radiosity/shoot/shoot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "radiosity/shoot/gather_rows.h"
#include "radiosity/shoot/room_shares.h"
#include "radiosity/shoot/shoot_elements.h"
#include "radiosity/shoot/shoot_queue.h"

// Shots between two reports of progress.
enum { SHOTS_A_LOOK = 64 };
// Rows are made ahead of patches with at least such a share of the strongest one's power: this one while there is much to do. The
// strongest will be about as much weaker in the end as there is less light left to shoot, and the row of a patch that is weaker yet
// would be in vain.
static const double WORTH_MAKING = 1.0 / 16, WORTH_MAKING_LAST = 1.0 / 2;
// A patch whose power is less than this share of what the queue says waits for stronger ones.
static const double STALE = 0.9;
// The least share of the light that counts as indoors.
static const double LEAST_INDOORS = 0.01;

// Memory for rows, bytes; and where the machine has eight times as much.
static const size_t ROWS = (size_t)128 << 20, ROWS_WANTED = (size_t)512 << 20;

RadOptions rad_default_options(void) {
    return (RadOptions){.method = form_factor_method("hemisphere"),
                        .form_factor = form_factor_default_options(),
                        .culling = CULL_STAB,
                        .gather = true,
                        .lamp_detail = 4,
                        .reach = 2,
                        .residual = 0.001,
                        .each_room = true,
                        .row_bytes = ROWS};
}

// Where rows do not fit, most of the time goes into making them again: in a small building each of ten thousand patches may see all
// others. A mesh of more than so many elements gets so many bytes more for each element beyond.
static size_t fitting_row_bytes(const Mesh *mesh) {
    static const double ELEMENTS = 120e3, BYTES = 8e3;
    double wanted = (double)ROWS_WANTED + BYTES * fmax(mesh->element_count - ELEMENTS, 0);
    double machine = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    return (size_t)fmax(fmin(wanted, machine / 8), (double)ROWS);
}

// Rooms that get little of the light still lack a twentieth of theirs at a residual of 1e-3. Rows are kept, and a third more shots along
// them cost little.
static const double FITTING_RESIDUAL = 1e-4;

void rad_fit(const Mesh *mesh, RadOptions *options) {
    static const struct {
        int patches;  // up to so many
        int resolution;
    } FIT[] = {{4000, 200}, {10000, 80}, {INT32_MAX, 48}};
    int i = 0;
    while (mesh->patch_count > FIT[i].patches) i++;
    if (options->residual == 0) options->residual = FITTING_RESIDUAL;
    if (options->form_factor.resolution == 0) options->form_factor.resolution = FIT[i].resolution;
    if (options->row_bytes == RAD_ROWS_FIT) options->row_bytes = fitting_row_bytes(mesh);
}

static bool check_material(const Material *m, int face, Error *error) {
    double rho[3], e[3];
    rgb_doubles(m->reflectance, rho);
    rgb_doubles(m->emission, e);
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

bool rad_start_dark(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error) {
    *out = (RadSolution){.element_count = mesh->element_count, .patch_count = mesh->patch_count};
    out->radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out->radiosity);
    out->direct = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out->direct);
    out->unshot = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out->unshot);
    out->shot = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out->shot);
    out->daylight = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out->daylight);
    out->reflected = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out->reflected);
    out->sun = arena_alloc(arena, (size_t)mesh->element_count, sizeof *out->sun);
    out->sent = arena_alloc(arena, (size_t)mesh->patch_count, sizeof *out->sent);
    out->strong = ARENA_ARRAY(arena, bool, mesh->patch_count);
    out->close = ARENA_ARRAY(arena, float, mesh->patch_count + 1);
    out->noise = ARENA_ARRAY(arena, float, mesh->patch_count + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        if (!check_material(mesh_material(mesh, f), mesh->faces[f].polygon, error)) return false;
    }
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        double e[3];
        if (!mesh_owns(mesh, patch->face)) continue;
        rgb_doubles(mesh_material(mesh, patch->face)->emission, e);
        for (int c = 0; c < 3; c++) {
            out->unshot[p][c] = e[c];
            out->emitted[c] += e[c] * patch->area;
            for (int i = 0; i < patch->element_count; i++) out->radiosity[patch->first_element + i][c] = e[c];
        }
    }
    return true;
}

bool rad_start(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error) {
    if (!rad_start_dark(mesh, arena, out, error)) return false;
    if (rgb_sum(out->emitted) > 0) return true;
    return error_set(error, "nothing emits light: none of the %d polygons has an emission", mesh->face_count);
}

// ---- faces before a patch: those in the cells that its own may see, whether views are culled or not

typedef struct Looks {
    const Mesh *mesh;
    const StabForest *forest;
    double *own, *seen;  // [cell_count] of a cell; of all that it may see, -1: not summed yet
    double spent;
} Looks;

static void start_looks(Looks *l, const Mesh *mesh, const StabForest *forest, Arena *arena) {
    const CellGraph *graph = mesh->graph;
    *l = (Looks){mesh, forest, ARENA_ARRAY(arena, double, graph->cell_count),
                 ARENA_ARRAY(arena, double, graph->cell_count), 0};
    int *faces = ARENA_ARRAY(arena, int, graph->object_count),
        *last = ARENA_ARRAY(arena, int, graph->object_count);
    for (int f = 0; f < mesh->face_count; f++) faces[mesh->faces[f].object]++;
    for (int c = 0; c < graph->cell_count; c++) {
        const SquareGrid *squares = &graph->grids[c];
        int first = graph->square_first[squares->first_square],
            end = graph->square_first[squares->first_square + squares->nx * squares->ny];
        for (int k = first; k < end; k++) {
            int object = graph->square_objects[k];
            if (last[object] != c + 1) l->own[c] += faces[object];
            last[object] = c + 1;
        }
        l->seen[c] = -1;
    }
}

static double looks_of(Looks *l, int patch) {
    int cell = l->mesh->patches[patch].cell;
    if (cell < 0) return l->mesh->face_count;
    if (l->seen[cell] >= 0) return l->seen[cell];
    double sum = 0;
    for (int c = 0; c < l->mesh->graph->cell_count; c++)
        if (vis_sees(l->forest, cell, c)) sum += l->own[c];
    return l->seen[cell] = sum;
}

// All that a shot asks of a patch, in one line of the cache.
typedef struct Receiver {
    Four unshot;  // W/m^2
    float reflectance[3];
    bool uneven;   // its elements differ in reflectance
    bool foreign;  // another part of the building shoots its light
    double area, per_area;
} Receiver;

// The solution, as shots like it.
typedef struct Shooter {
    const RadOptions *options;
    RadSolution *solution;
    ShootElements *elements;
    Receiver *receivers;  // [patch_count]
    Four absorbed, escaped;
    ShootQueue queue;
    ShootRows *rows;
    Looks looks;
    int *next;  // [shoot_rows_most]
    // Lamps shoot their emitted light before all else, the strongest first: so it is known what part of the light is direct.
    long long lamps_left;
    // [patch_count] of light that goes on: lamps that shoot again; NULL: light from nothing. Then powers in the queue are never less than
    // the absolute unshot power, and `left` is the sum of that, W.
    const bool *again;
    RadFollow *follow;  // of light that goes on, or NULL
    bool repeats;       // what was taken back is shot again
    // Or of a part of a building: then `left` is of this part, and `residual` of all of them, as they knew it last.
    double left, residual;
    RoomShares *rooms;  // once all but the rooms by themselves have their light, else NULL
} Shooter;

// Computed from the solution alone, however it came about: a run that is resumed goes on just so.
static double unshot_power(const Receiver *r) {
    return (fabs(r->unshot[0]) + fabs(r->unshot[1]) + fabs(r->unshot[2])) * r->area;
}

// Patches shoot what they reflect, from now on.
static void queue_unshot(Shooter *s, const Mesh *mesh) {
    s->left = 0;
    for (int p = 0; p < mesh->patch_count; p++) {
        if (s->receivers[p].foreign) continue;
        double power = unshot_power(&s->receivers[p]);
        shoot_queue_raise(&s->queue, p, power);
        s->left += power;
    }
}

static void shoot_taken(Shooter *s, const Mesh *mesh);

static void queue_reflected(Shooter *s, const Mesh *mesh) {
    if (s->options->lamps_only) return;
    shoot_elements_finish(s->elements);
    if (s->follow) shoot_taken(s, mesh);
    shoot_elements_store(s->elements, s->solution);
    if (!shoot_rows_settled(s->rows)) shoot_rows_find_strong(s->rows, s->solution);
    queue_unshot(s, mesh);
}

// A solution that was broken off while lamps shot goes on with the next lamp.
static void queue_lamps(Shooter *s, const Mesh *mesh) {
    for (int p = 0; p < mesh->patch_count; p++) {
        double e[3];
        rgb_doubles(mesh_material(mesh, mesh->patches[p].face)->emission, e);
        if (rgb_sum(e) <= 0 || (s->again && !s->again[p]) || s->receivers[p].foreign) continue;
        shoot_queue_raise(&s->queue, p, rgb_sum(e) * mesh->patches[p].area);
        s->lamps_left++;
    }
    for (long long i = 0; !s->again && i < s->solution->shots && s->lamps_left > 0; i++, s->lamps_left--)
        shoot_queue_clear(&s->queue, shoot_queue_top(&s->queue));
    if (s->lamps_left == 0 && !s->options->borders) queue_reflected(s, mesh);
}

static void start_shooter(Shooter *s, const Mesh *mesh, const StabForest *forest, const float *door_open,
                          const RadOptions *options, RadFollow *follow, RadSolution *solution, Arena *arena) {
    *s = (Shooter){
        .options = options, .solution = solution, .again = follow ? follow->again : NULL, .follow = follow};
    if (options->looks > 0) start_looks(&s->looks, mesh, forest, arena);
    s->rows = options->rows ? options->rows
                            : shoot_rows_new(mesh, forest, door_open, options, &solution->day, arena);
    s->next = ARENA_ARRAY(arena, int, shoot_rows_most(s->rows));
    s->elements = shoot_elements_new(mesh, solution, parallel_threads(options->threads), arena);
    s->receivers = ARENA_ARRAY(arena, Receiver, mesh->patch_count);
    s->absorbed = channels_of(solution->absorbed);
    s->escaped = channels_of(solution->escaped);
    shoot_queue_start(&s->queue, mesh->patch_count, arena);
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        Rgb rho = mesh_patch_reflectance(mesh, p);
        s->receivers[p] = (Receiver){.unshot = channels_of(solution->unshot[p]),
                                     .reflectance = {rho.r, rho.g, rho.b},
                                     .uneven = mesh_has_picture(mesh, patch->face),
                                     .foreign = !mesh_owns(mesh, patch->face),
                                     .area = patch->area,
                                     .per_area = 1 / patch->area};
    }
    queue_lamps(s, mesh);
}

// Back into the solution.
static void finish(const Shooter *s) {
    RadSolution *out = s->solution;
    shoot_elements_finish(s->elements);
    shoot_elements_store(s->elements, out);
    for (int p = 0; p < out->patch_count; p++) channels_store(s->receivers[p].unshot, out->unshot[p]);
    channels_store(s->absorbed, out->absorbed);
    channels_store(s->escaped, out->escaped);
}

// Receivers lie all over memory, but it is known long before which come: runs ahead to fetch one.
enum { RECEIVER_AHEAD = 12 };

// The mean reflectance of the elements of one run, by their shares. `at`: the run's first element in the row.
static Four run_reflectance(const Mesh *mesh, const ShootRow *row, int run, int at) {
    const Patch *patch = &mesh->patches[row->runs[run].patch];
    Four sum = {0};
    double all = 0;
    for (int i = at; i <= at + row->count[run]; i++) {
        int e = patch->first_element + row->offset[i];
        double share = (double)row->density[i] * mesh->elements[e].area;
        sum += channels_of_rgb(mesh->reflectance[e]) * four_of(share);
        all += share;
    }
    return all > 0 ? sum * four_of(1 / all) : sum;
}

static bool is_taken(const Shooter *s, int patch) {
    const double *taken = s->follow->taken[patch];
    return taken[0] != 0 || taken[1] != 0 || taken[2] != 0;
}

// Light went to a patch of a room, or was shot from it; `reflected`: of what arrived, W.
static void add_to_room(Shooter *s, int patch, double left, double reflected) {
    int room = s->rooms->of[patch];
    if (room < 0) return;
    s->rooms->left[room] += left;
    s->rooms->light[room] += reflected;
}

static void shoot(Shooter *s, const Mesh *mesh, int patch, const ShootRow *row) {
    Receiver *from = &s->receivers[patch];
    const bool direct = s->lamps_left > 0;
    Four shot = s->repeats ? channels_of(s->follow->taken[patch]) : from->unshot;
    if (direct) {
        Rgb e = mesh_material(mesh, mesh->patches[patch].face)->emission;
        shot = (Four){(double)e.r, (double)e.g, (double)e.b, 0};
    }
    Four power = shot * four_of(from->area * row->scale), absorbed = power * four_of(row->back);
    for (int c = 0; c < 3 && !direct && s->solution->shot; c++) s->solution->shot[patch][c] += shot[c];
    if (s->repeats) {
        memset(s->follow->taken[patch], 0, sizeof *s->follow->taken);
    } else {
        if (!direct) s->left -= unshot_power(from);
        if (s->rooms) add_to_room(s, patch, -unshot_power(from), 0);
        from->unshot -= shot;
        shoot_queue_clear(&s->queue, patch);
    }
    shoot_elements_tell(s->elements, row, power, direct);
    int at = 0;  // elements so far, where that matters
    for (int r = 0; r < row->run_count; r++) {
        const ShootRun *run = &row->runs[r];
        Receiver *to = &s->receivers[run->patch];
        if (r + RECEIVER_AHEAD < row->run_count)
            __builtin_prefetch(&s->receivers[run[RECEIVER_AHEAD].patch], 1);
        Four reflected =
            power * (to->uneven ? run_reflectance(mesh, row, r, at) : channels_of_floats(to->reflectance));
        if (mesh->reflectance) at += row->count[r] + 1;
        double share = (double)run->share;
        const bool counts = (s->again || s->options->borders) && !to->foreign;
        double before = unshot_power(to);
        if (counts) s->left -= before;
        to->unshot += reflected * four_of(share * to->per_area);
        absorbed += (power - reflected) * four_of(share);
        if (direct || to->foreign || s->repeats) continue;
        double now = unshot_power(to);
        if (counts) s->left += now;
        if (s->rooms) add_to_room(s, run->patch, now - before, now - before);
        if (!s->again || now > s->queue.power[run->patch]) shoot_queue_raise(&s->queue, run->patch, now);
    }
    s->absorbed += absorbed;
    s->escaped += power * four_of(row->escaped);
    s->solution->shots++;
    if (direct && --s->lamps_left == 0 && !s->options->borders) queue_reflected(s, mesh);
}

// All that was taken back, in the order of the patches: the rows of neighbours are made together.
static void shoot_taken(Shooter *s, const Mesh *mesh) {
    s->repeats = true;
    for (int p = 0; p < mesh->patch_count;) {
        int wanted = shoot_rows_wanted(s->rows), count = 0, first = p;
        for (; p < mesh->patch_count && count < wanted; p++)
            if (is_taken(s, p) && !shoot_rows_of(s->rows, p)) s->next[count++] = p;
        shoot_elements_finish(s->elements);  // rows that were shot may go
        if (count > 0) shoot_rows_make(s->rows, s->next, count);
        for (int q = first; q < p; q++) {
            if (!is_taken(s, q)) continue;
            shoot(s, mesh, q, shoot_rows_of(s->rows, q));
            shoot_rows_shot(s->rows, q);
        }
    }
    shoot_elements_finish(s->elements);
    s->repeats = false;
}

// Under a sky most light is outdoors, and a thousandth of it may be all that is in a room: what is left is measured against
// what is indoors.
static double residual_of(const Shooter *s) {
    if (s->options->borders) return s->residual;
    double emitted = rgb_sum(s->solution->emitted), outdoors = rgb_sum(s->solution->outdoors), gone[3];
    if (s->again && s->lamps_left > 0) return INFINITY;
    if (s->again) return fmax(s->left, 0) / fmax(emitted - outdoors, LEAST_INDOORS * emitted);
    channels_store(s->absorbed + s->escaped, gone);
    return (emitted - rgb_sum(gone)) / fmax(emitted - outdoors, LEAST_INDOORS * emitted);
}

static double worth_making(const Shooter *s) {
    double in_the_end = s->options->residual / residual_of(s) / 2;
    return fmin(fmax(in_the_end, WORTH_MAKING), WORTH_MAKING_LAST);
}

// The strongest patches without rows in the room of a patch, this one among them.
static int next_in_room(Shooter *s, int patch, double least, int wanted) {
    const RoomShares *rooms = s->rooms;
    int room = rooms->of[patch], count = 0;
    s->next[count++] = patch;
    for (int i = rooms->first[room]; i < rooms->first[room + 1] && count < wanted; i++) {
        int p = rooms->patches[i];
        if (p != patch && !shoot_rows_of(s->rows, p) && !s->receivers[p].foreign &&
            unshot_power(&s->receivers[p]) >= least)
            s->next[count++] = p;
    }
    return count;
}

static const ShootRow *row_of(Shooter *s, int patch) {
    const ShootRow *row = shoot_rows_of(s->rows, patch);
    if (row) return row;
    double least = s->rooms ? unshot_power(&s->receivers[patch]) * WORTH_MAKING_LAST
                            : s->queue.power[patch] * worth_making(s);
    long long wanted = shoot_rows_wanted(s->rows), left = s->options->shots - s->solution->shots;
    if (s->options->shots > 0 && left < wanted) wanted = left;
    int count = s->rooms
                    ? next_in_room(s, patch, least, (int)wanted)
                    : shoot_queue_next(&s->queue, shoot_rows_there(s->rows), least, (int)wanted, s->next);
    shoot_elements_finish(s->elements);  // rows that were shot may go
    shoot_rows_make(s->rows, s->next, count);
    return shoot_rows_of(s->rows, patch);
}

// Residuals fall about exponentially, once the lamps have shot.
static bool report_residual(const Shooter *s, const Progress *progress) {
    const RadOptions *o = s->options;
    double residual = residual_of(s), done = 0;
    if (o->residual > 0 && o->residual < 1) done = log(fmax(residual, o->residual)) / log(o->residual);
    if (o->shots > 0) done = fmax(done, (double)s->solution->shots / (double)o->shots);
    char stage[64];
    snprintf(stage, sizeof stage, "residual %.2g %%", 100 * residual);
    return progress_report(progress, stage, fmin(fmax(done, 0), 1));
}

static void show_solution(Shooter *s) {
    const RadOptions *o = s->options;
    if (!o->show || !o->show_due(o->show_context)) return;
    finish(s);
    o->show(o->show_context, s->solution);
}

// The strongest patch; -1: there is none. Where light goes on powers in the queue may be too great.
static int strongest(Shooter *s) {
    for (;;) {
        int patch = shoot_queue_top(&s->queue);
        if (patch < 0 || !s->again || s->lamps_left > 0) return patch;
        double power = unshot_power(&s->receivers[patch]);
        if (power >= STALE * s->queue.power[patch]) return patch;
        shoot_queue_clear(&s->queue, patch);
        shoot_queue_raise(&s->queue, patch, power);
    }
}

// ---- light of parts of a building

// In a round each part shoots its patches that have at least this share of the strongest one's power, of all parts: so they shoot about in
// the order in which they would if they were one.
static const double ROUND = 0.0625;

// Light that went to faces of others goes to those who shoot it.
static void bring(Shooter *s) {
    const Borders *borders = s->options->borders;
    RadSolution *out = s->solution;
    finish(s);
    if (memory_in_file()) shoot_rows_rest(s->rows);
    const BorderValue light[] = {BORDER_VALUE(BORDER_ELEMENT, out->radiosity),
                                 BORDER_VALUE(BORDER_ELEMENT, out->direct),
                                 BORDER_VALUE(BORDER_PATCH, out->unshot)};
    borders_bring(borders, light, 3);
    shoot_elements_load(s->elements, out);
    for (int p = 0; p < out->patch_count; p++) s->receivers[p].unshot = channels_of(out->unshot[p]);
}

// Parts find this out together between two rounds, when the solution is whole.
typedef struct Round {
    bool stopped;  // progress of any of them asked to stop, or
    bool over;     // no more may be looked at
} Round;
enum { ROUND_FLAGS = 3 };

// They meet once, so that parts that sleep are woken once: a part that is asked to stop shoots in the round that has begun, as the others
// do. `sum`, and `most` [mosts + ROUND_FLAGS], become those of all.
static void end_round(const Shooter *s, double *sum, int sums, double *most, int mosts, Round *round) {
    const RadOptions *o = s->options;
    double *flag = most + mosts;
    flag[0] = round->stopped;
    flag[1] = round->over;
    flag[2] = o->show && o->show_due(o->show_context);
    team_join(borders_member(o->borders), sum, sums, most, mosts + ROUND_FLAGS);
    *round = (Round){flag[0] > 0, flag[1] > 0};
    if (o->show && (round->stopped || flag[2] > 0)) o->show(o->show_context, s->solution);
}

static void shoot_next(Shooter *s, const Mesh *mesh, int patch) {
    shoot(s, mesh, patch, row_of(s, patch));
    shoot_rows_shot(s->rows, patch);
}

// Are so many faces before the patches that shot, this one included, as options->looks allows?
static bool may_look(Shooter *s, int patch) {
    const double most = s->options->looks;
    return most <= 0 || (s->looks.spent += looks_of(&s->looks, patch)) <= most;
}

// Shoots patches of at least such a power, W, until no more than `goal` W are left. False: no more may be looked at.
static bool shoot_round(Shooter *s, const Mesh *mesh, double least, double goal) {
    int patch;
    while ((patch = shoot_queue_top(&s->queue)) >= 0 && s->queue.power[patch] >= least && s->left > goal) {
        if (!may_look(s, patch)) return false;
        shoot_next(s, mesh, patch);
    }
    return true;
}

static bool each_room(const Shooter *s) {
    return s->options->each_room && !s->options->lamps_only && !s->again;
}

// The patch of a room with most unshot power that is not another part's; -1: all powers are 0.
static int strongest_in_room(const Shooter *s, int room) {
    const RoomShares *rooms = s->rooms;
    int strongest = -1;
    double most = 0;
    for (int i = rooms->first[room]; i < rooms->first[room + 1]; i++) {
        int p = rooms->patches[i];
        double power = s->receivers[p].foreign ? 0 : unshot_power(&s->receivers[p]);
        if (power > most) {
            most = power;
            strongest = p;
        }
    }
    return strongest;
}

// Sums are of all parts. `most` [room_count + ROUND_FLAGS]: the power of the strongest patch of each room, W.
static void measure_rooms_together(Shooter *s, const Mesh *mesh, double emitted, double *most, Round *round) {
    Arena scratch = {0};
    RoomShares *rooms = s->rooms;
    int count = rooms->room_count;
    double *sum = ARENA_ARRAY(&scratch, double, 2 * count);
    room_shares_measure(rooms, mesh, s->solution, emitted);
    for (int r = 0; r < count; r++) {
        int patch = strongest_in_room(s, r);
        most[r] = patch < 0 ? 0 : unshot_power(&s->receivers[patch]);
        sum[r] = rooms->left[r];
        sum[count + r] = rooms->light[r];
    }
    end_round(s, sum, 2 * count, most, count, round);
    for (int r = 0; r < count; r++) {
        rooms->left[r] = sum[r];
        rooms->light[r] = sum[count + r];
    }
    arena_free(&scratch);
}

// Shoots patches of at least `share` of `most` of their room, W, in rooms that lack light. A part that is the whole shoots in the first of
// these at any time, as shoot_rooms does. False: no more may be looked at.
static bool shoot_rooms_round(Shooter *s, const Mesh *mesh, const double *most, double share) {
    const RoomShares *rooms = s->rooms;
    const double residual = s->options->residual;
    for (int r = 0; r < rooms->room_count;) {
        int patch = room_shares_lacks(rooms, r, residual) ? strongest_in_room(s, r) : -1;
        if (patch < 0 || unshot_power(&s->receivers[patch]) < share * most[r]) {
            r++;
            continue;
        }
        if (!may_look(s, patch)) return false;
        shoot_next(s, mesh, patch);
        if (share == 0) r = 0;
    }
    return true;
}

// Goes on in rooms that lack light, in rounds. Returns whether progress asked to stop.
static bool shoot_rooms_in_parts(Shooter *s, const Mesh *mesh, double emitted, Round round,
                                 const Progress *progress) {
    const double share = team_count(borders_member(s->options->borders)) == 1 ? 0 : ROUND;
    Arena arena = {0};
    RoomShares rooms = room_shares_new(mesh, &arena);
    double *most = ARENA_ARRAY(&arena, double, rooms.room_count + ROUND_FLAGS);
    s->rooms = &rooms;
    for (;;) {
        measure_rooms_together(s, mesh, emitted, most, &round);
        if (round.stopped || round.over || room_shares_first(&rooms, s->options->residual) < 0) break;
        round.stopped = !report_residual(s, progress);
        round.over = !shoot_rooms_round(s, mesh, most, share);
        bring(s);
    }
    s->rooms = NULL;
    arena_free(&arena);
    return round.stopped;
}

// Returns whether progress asked to stop.
static bool shoot_parts(Shooter *s, const Mesh *mesh, const Progress *progress) {
    const double residual = s->options->residual;
    double sums[2] = {rgb_sum(s->solution->emitted), rgb_sum(s->solution->outdoors)};
    team_sum(borders_member(s->options->borders), sums, 2);
    const double indoors = fmax(sums[0] - sums[1], LEAST_INDOORS * sums[0]);
    Round round = {0};
    s->residual = 1;
    for (int patch; s->lamps_left > 0 && may_look(s, patch = shoot_queue_top(&s->queue));)
        shoot_next(s, mesh, patch);
    s->lamps_left = 0;
    bring(s);
    queue_reflected(s, mesh);
    if (s->options->lamps_only) return false;
    for (;;) {
        int patch = shoot_queue_top(&s->queue);
        double left = s->left, most[1 + ROUND_FLAGS] = {patch < 0 ? 0 : s->queue.power[patch]};
        end_round(s, &left, 1, most, 1, &round);
        s->residual = left / indoors;
        if (round.stopped || round.over || !(most[0] > 0)) return round.stopped;
        round.stopped = !report_residual(s, progress);
        if (s->residual <= residual)
            return each_room(s) && shoot_rooms_in_parts(s, mesh, sums[0], round, progress);
        round.over = !shoot_round(s, mesh, ROUND * most[0], s->left * residual / s->residual);
        bring(s);
        queue_unshot(s, mesh);
    }
}

// Sums are of all parts, and faces of others have the light that their owners found.
static void share_light(const Borders *borders, RadSolution *s) {
    double sums[13], *of[4] = {s->emitted, s->absorbed, s->escaped, s->outdoors};
    for (int i = 0; i < 12; i++) sums[i] = of[i / 3][i % 3];
    sums[12] = (double)s->shots;
    team_sum(borders_member(borders), sums, 13);
    for (int i = 0; i < 12; i++) of[i / 3][i % 3] = sums[i];
    s->shots = (long long)sums[12];
    const BorderValue found[] = {
        BORDER_VALUE(BORDER_ELEMENT, s->radiosity), BORDER_VALUE(BORDER_ELEMENT, s->direct),
        BORDER_VALUE(BORDER_ELEMENT, s->daylight), BORDER_VALUE(BORDER_PATCH, s->unshot)};
    borders_fetch(borders, found, 4);
}

RadReport rad_shoot(const Mesh *mesh, const StabForest *forest, const float *door_open,
                    const RadOptions *options, const Progress *progress, RadSolution *solution) {
    return rad_shoot_on(mesh, forest, door_open, options, NULL, progress, solution);
}

// Between two shots. Returns whether progress asked to stop.
static bool look_up(Shooter *s, long long first, const Progress *progress) {
    if ((s->solution->shots - first) % SHOTS_A_LOOK != 0) return false;
    if (!report_residual(s, progress)) return true;
    show_solution(s);
    return false;
}

static bool has_all_shots(const Shooter *s) {
    return s->options->shots > 0 && s->solution->shots >= s->options->shots;
}

// Goes on in rooms that lack light, in the first one at any time: so a run that is resumed goes on just so. Returns whether progress asked
// to stop.
static bool shoot_rooms(Shooter *s, const Mesh *mesh, long long first, const Progress *progress) {
    Arena arena = {0};
    RoomShares rooms = room_shares_new(mesh, &arena);
    bool stopped = false;
    finish(s);
    room_shares_measure(&rooms, mesh, s->solution, rgb_sum(s->solution->emitted));
    s->rooms = &rooms;
    for (int room; (room = room_shares_first(&rooms, s->options->residual)) >= 0;) {
        stopped = look_up(s, first, progress);
        int patch = strongest_in_room(s, room);
        if (stopped || has_all_shots(s) || patch < 0 || !may_look(s, patch)) break;
        shoot_next(s, mesh, patch);
    }
    s->rooms = NULL;
    arena_free(&arena);
    return stopped;
}

// Returns whether progress asked to stop.
static bool shoot_whole(Shooter *s, const Mesh *mesh, long long first, const Progress *progress) {
    while (residual_of(s) > s->options->residual) {
        if (has_all_shots(s)) return false;
        if (look_up(s, first, progress)) return true;
        int patch = strongest(s);
        if (patch < 0 || !may_look(s, patch)) return false;
        shoot_next(s, mesh, patch);
    }
    return each_room(s) && shoot_rooms(s, mesh, first, progress);
}

RadReport rad_shoot_on(const Mesh *mesh, const StabForest *forest, const float *door_open,
                       const RadOptions *options, RadFollow *follow, const Progress *progress,
                       RadSolution *solution) {
    Arena arena = {0};
    Shooter s;
    RadReport report = {0};
    start_shooter(&s, mesh, forest, door_open, options, follow, solution, &arena);
    long long first = solution->shots;
    report.stopped =
        options->borders ? shoot_parts(&s, mesh, progress) : shoot_whole(&s, mesh, first, progress);
    finish(&s);
    if (options->borders) share_light(options->borders, solution);
    report.residual = fmax(0, residual_of(&s));  // rounding takes it below 0 where all light is absorbed
    if (options->gather && !options->lamps_only && report.residual <= options->residual) {
        solution->gathered = gather_rows(mesh, s.rows, options, follow, progress, solution);
        report.stopped = !solution->gathered;
    }
    report.shots = solution->shots - first;
    shoot_rows_report(s.rows, &report);
    shoot_elements_end(s.elements);
    if (!options->rows) shoot_rows_end(s.rows);
    arena_free(&arena);
    return report;
}

// ---- taking back

typedef struct TakenBack {
    const Mesh *mesh;
    const ShootRows *rows;
    RadSolution *solution;
    Rgb *reflectance;  // [patch_count]
} TakenBack;

// Takes back a shot along a row, W a channel: `shoot` and ShootElements the other way round.
static void take_back(const TakenBack *t, const ShootRow *row, const double power[3], bool direct) {
    const Mesh *mesh = t->mesh;
    RadSolution *s = t->solution;
    Four shot = channels_of(power) * four_of(row->scale), absorbed = shot * four_of(row->back);
    double lost[3];
    for (int r = 0, at = 0; r < row->run_count; at += row->count[r++] + 1) {
        int patch = row->runs[r].patch;
        const Patch *to = &mesh->patches[patch];
        Four rho = channels_of_rgb(t->reflectance[patch]);
        Four reflected = shot * (mesh_has_picture(mesh, to->face) ? run_reflectance(mesh, row, r, at) : rho);
        for (int i = at; i <= at + row->count[r]; i++) {
            int e = to->first_element + row->offset[i];
            Four own = mesh->reflectance ? channels_of_rgb(mesh->reflectance[e]) : rho;
            channels_store(shot * own * four_of((double)row->density[i]), lost);
            for (int c = 0; c < 3; c++) s->radiosity[e][c] -= lost[c];
            for (int c = 0; c < 3 && direct; c++) s->direct[e][c] -= lost[c];
        }
        double share = (double)row->runs[r].share;
        channels_store(reflected * four_of(share / to->area), lost);
        for (int c = 0; c < 3; c++) s->unshot[patch][c] -= lost[c];
        absorbed += (shot - reflected) * four_of(share);
    }
    channels_store(absorbed, lost);
    for (int c = 0; c < 3; c++) s->absorbed[c] -= lost[c];
    channels_store(shot * four_of(row->escaped), lost);
    for (int c = 0; c < 3; c++) s->escaped[c] -= lost[c];
}

static bool has_shot(const Mesh *mesh, const RadSolution *s, int patch) {
    const double *shot = s->shot[patch];
    return shot[0] != 0 || shot[1] != 0 || shot[2] != 0 || mesh_emits(mesh, mesh->patches[patch].face);
}

bool rad_take_back(const Mesh *mesh, const RadOptions *options, const MovedDoors *moved,
                   RadSolution *solution, RadFollow *follow) {
    bool *again = follow->again;
    Arena scratch = {0};
    const ShootRows *rows = options->rows;
    TakenBack t = {mesh, rows, solution, ARENA_ARRAY(&scratch, Rgb, mesh->patch_count + 1)};
    bool *taken = ARENA_ARRAY(&scratch, bool, mesh->patch_count + 1), good = true;
    for (int p = 0; p < mesh->patch_count && good; p++) {
        t.reflectance[p] = mesh_patch_reflectance(mesh, p);
        bool there = shoot_rows_of(rows, p) != NULL;
        taken[p] = !again[p] && has_shot(mesh, solution, p) && (!there || shoot_rows_depend(rows, p, moved));
        good = !taken[p] || there;
    }
    for (int p = 0; p < mesh->patch_count && good; p++) {
        const Patch *patch = &mesh->patches[p];
        double power[3], emitted[3], *shot = solution->shot[p];
        if (!taken[p]) continue;
        for (int c = 0; c < 3; c++) power[c] = shot[c] * patch->area;
        take_back(&t, shoot_rows_of(rows, p), power, false);
        rgb_doubles(mesh_material(mesh, patch->face)->emission, emitted);
        again[p] = rgb_sum(emitted) > 0;
        for (int c = 0; c < 3; c++) {
            power[c] = emitted[c] * patch->area;
            follow->taken[p][c] += shot[c];
            if (again[p]) solution->unshot[p][c] += emitted[c];
            shot[c] = 0;
        }
        if (again[p]) take_back(&t, shoot_rows_of(rows, p), power, true);
    }
    arena_free(&scratch);
    return good;
}
