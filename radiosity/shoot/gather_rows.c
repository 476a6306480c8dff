// gather_rows.c - one sum over all samples of a row, where an element has few samples of each shot.
#include "radiosity/shoot/gather_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "radiosity/shoot/shoot_elements.h"
#include "radiosity/shoot/sunlight.h"

typedef struct Gathering {
    const Mesh *mesh;
    ShootRows *rows;
    const Four *reflected;       // [element_count] radiosity times area, W, without what is emitted
    Vec3 *middle;                // [element_count] NULL: what is close is not asked
    double (*sent)[3];           // [patch_count]
    double (*out)[3];            // [patch_count]
    double zenith[3], below[3];  // irradiance by a whole view of the sky overhead, and of the ground
    double samples;              // of a row
    float *noise;                // [patch_count]
    float *close;                // [patch_count]
    int *patches;                // of this round
} Gathering;

static void gather_patch(void *context, int index, int thread) {
    (void)thread;
    const Gathering *g = context;
    int patch = g->patches[index];
    const Mesh *mesh = g->mesh;
    const ShootRow *row = shoot_rows_of(g->rows, patch);
    const float *density = row->density;
    const uint8_t *offset = row->offset;
    Vec3 eye = mesh->patches[patch].centre;
    Four sum = {0};
    double squares = 0, close = 0, width2 = mesh->patches[patch].area;
    for (int r = 0; r < row->run_count; r++) {
        int first = mesh->patches[row->runs[r].patch].first_element;
        if (g->middle) {
            Vec3 to = vec3_sub(g->middle[first], eye);
            close += vec3_dot(to, to) < width2 ? (double)row->runs[r].share : 0;
        }
        for (int i = 0; i <= row->count[r]; i++) {
            const Four power = g->reflected[first + *offset];
            double area = mesh->elements[first + *offset++].area, all = power[0] + power[1] + power[2];
            squares += all * all * (double)*density / area;
            sum += power * four_of((double)*density++);
        }
    }
    double sky[3];
    for (int c = 0; c < 3; c++) sky[c] = row->sky_light * g->zenith[c] + row->ground_light * g->below[c];
    squares += row->escaped > 0 ? rgb_sum(sky) * rgb_sum(sky) / row->escaped : 0;
    sum = (sum + channels_of(sky)) * four_of(row->scale);
    channels_store(sum, g->out[patch]);
    double light = sum[0] + sum[1] + sum[2] + rgb_sum(g->sent[patch]);
    g->noise[patch] = light > 0 ? (float)(sqrt(squares * row->scale / g->samples) / light) : 0;
    for (int c = 0; c < 3; c++) g->out[patch][c] += g->sent[patch][c];
    g->close[patch] = (float)close;
}

// Strong patches have none: they send it themselves.
static const Four *reflected_power(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    Four *out = ARENA_ARRAY(arena, Four, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3], area = mesh->elements[e].area;
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        bool strong = solution->strong[mesh->elements[e].patch];
        for (int c = 0; c < 3 && !strong; c++)
            out[e][c] = area * fmax(solution->radiosity[e][c] - emitted[c], 0);
    }
    return out;
}

// Adds what a strong patch sends to others.
static void send(const Mesh *mesh, RadSolution *s, int patch, const ShootRow *row) {
    const Patch *p = &mesh->patches[patch];
    double power[3] = {0, 0, 0}, emitted[3];
    rgb_doubles(mesh_material(mesh, p->face)->emission, emitted);
    for (int e = p->first_element; e < p->first_element + p->element_count; e++)
        for (int c = 0; c < 3; c++)
            power[c] += mesh->elements[e].area * fmax(s->radiosity[e][c] - emitted[c], 0) * row->scale;
    for (int r = 0; r < row->run_count; r++) {
        int to = row->runs[r].patch;
        for (int c = 0; c < 3; c++)
            s->sent[to][c] += power[c] * (double)row->runs[r].share / mesh->patches[to].area;
    }
}

// In the order of patches, so that sums are the same however rows are kept.
static void send_strong(const Mesh *mesh, ShootRows *rows, const Borders *borders, int *next,
                        RadSolution *out) {
    memcpy(out->strong, shoot_rows_strong(rows), (size_t)mesh->patch_count * sizeof *out->strong);
    memset(out->sent, 0, (size_t)mesh->patch_count * sizeof *out->sent);
    if (borders) borders_fetch(borders, &BORDER_VALUE(BORDER_PATCH, out->strong), 1);
    for (int p = 0; p < mesh->patch_count; p++) {
        if (!out->strong[p] || !mesh_owns(mesh, mesh->patches[p].face)) continue;
        if (!shoot_rows_of(rows, p)) {
            // Its neighbours' rows are made with it.
            int count = 0, most = (int)shoot_rows_wanted(rows);
            for (int q = p; q < mesh->patch_count && count < most; q++)
                if (out->strong[q] && mesh_owns(mesh, mesh->patches[q].face) && !shoot_rows_of(rows, q))
                    next[count++] = q;
            shoot_rows_make(rows, next, count);
        }
        send(mesh, out, p, shoot_rows_of(rows, p));
        shoot_rows_shot(rows, p);
    }
    if (memory_in_file()) shoot_rows_rest(rows);
    if (borders) borders_bring(borders, &BORDER_VALUE(BORDER_PATCH, out->sent), 1);
}

static void take_shot(const Mesh *mesh, const RadSolution *s, int patch, double out[3]) {
    const Patch *p = &mesh->patches[patch];
    double rho[3], emitted[3], power[3] = {0, 0, 0};
    rgb_doubles(mesh_material(mesh, p->face)->reflectance, rho);
    rgb_doubles(mesh_material(mesh, p->face)->emission, emitted);
    for (int e = p->first_element; e < p->first_element + p->element_count; e++) {
        double even[3];
        mesh_even(mesh, e, even);
        for (int c = 0; c < 3; c++)
            power[c] += even[c] * mesh->elements[e].area *
                        (s->radiosity[e][c] - s->direct[e][c] - s->sun[e][c] - emitted[c]);
    }
    for (int c = 0; c < 3; c++) out[c] = rho[c] > 0 ? fmax(power[c], 0) / (rho[c] * p->area) : 0;
}

// Gathers at `count` patches of g->patches, in rounds, whose rows are made where they are not there. False where progress asked to stop.
static bool gather_patches(Gathering *g, const int *patch, int count, int threads, const Progress *progress) {
    int done = 0, in_round = 0;
    bool go_on = true;
    for (int there = 1; there >= 0; there--) {
        for (int i = 0; i < count && go_on; i++) {
            bool last = i + 1 == count;
            if ((shoot_rows_of(g->rows, patch[i]) != NULL) == there) g->patches[in_round++] = patch[i];
            if (in_round == 0 || (!last && (there || in_round < shoot_rows_wanted(g->rows)))) continue;
            if (!there) shoot_rows_make(g->rows, g->patches, in_round);
            parallel_for(threads, in_round, gather_patch, g);
            for (int k = 0; k < in_round && !there; k++) shoot_rows_shot(g->rows, g->patches[k]);
            done += in_round;
            in_round = 0;
            go_on = progress_report(progress, "reflected light", (double)done / count);
        }
    }
    return go_on;
}

// Patches whose samples may miscount their light by more than this share look again in more directions: the light comes from few of them,
// as through a window. So many at most, as a share of all.
static const double MOST_NOISE = 0.04, MOST_NOISY = 0.25;

static int noisiest_first(const void *a, const void *b, void *context) {
    const int *p = a, *q = b;
    const float *noise = context;
    return noise[*p] != noise[*q] ? (noise[*p] > noise[*q] ? -1 : 1) : *p - *q;
}

static int by_index(const void *a, const void *b) {
    const int *p = a, *q = b;
    return *p - *q;
}

// Where light was taken back that shone on a patch, a rounding of it is left: less than this share of all power.
static const double ROUNDING = 1e-12;

static bool is_rounding(const RadSolution *s, double area, const double irradiance[3]) {
    return rgb_sum(irradiance) * area < ROUNDING * rgb_sum(s->emitted);
}

static void fetch_gathered(const Borders *borders, RadSolution *s) {
    const BorderValue gathered[] = {BORDER_VALUE(BORDER_PATCH, s->reflected),
                                    BORDER_VALUE(BORDER_PATCH, s->sent), BORDER_VALUE(BORDER_PATCH, s->close),
                                    BORDER_VALUE(BORDER_PATCH, s->noise)};
    borders_fetch(borders, gathered, 4);
}

// Light that goes on is gathered again where it has changed by more than this share, or by this share of the mean light.
static const double CHANGED = 5e-4, CHANGED_IN_THE_DARK = 1e-7;

// The patches that gather now.
static void find_changed(const Mesh *mesh, const RadSolution *now, RadFollow *f) {
    double light = 0, area = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        light += mesh->elements[e].area * rgb_sum(now->radiosity[e]);
        area += mesh->elements[e].area;
    }
    const double floor = CHANGED_IN_THE_DARK * light / area;
    marks_clear(&f->found);
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        double had = 0, change = 0;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            const double *a = now->radiosity[e], *b = f->gathered[e];
            had += mesh->elements[e].area * rgb_sum(b);
            change += mesh->elements[e].area * (fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]));
        }
        if (!f->dropped[p] && change <= CHANGED * had + floor * patch->area) continue;
        marks_add(&f->found, p);
        f->dropped[p] = false;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            memcpy(f->gathered[e], now->radiosity[e], sizeof *f->gathered);
    }
}

// Does the patch gather light? Leaves of doors and frames of windows have small patches, but are seen as surfaces; so the face decides.
// Slivers of walls and ceilings gather, too: few samples would be seen as spots there.
static bool gathers(const Mesh *mesh, int patch) {
    const Face *face = &mesh->faces[mesh->patches[patch].face];
    double extent = face->nx * face->ny / (vec3_length(face->gx) * vec3_length(face->gy));
    return extent >= RAD_SMALL || mesh->graph->objects[face->object].kind == OBJECT_SURFACE;
}

bool gather_rows(const Mesh *mesh, ShootRows *rows, const RadOptions *options, RadFollow *follow,
                 const Progress *progress, RadSolution *solution) {
    Arena arena = {0};
    int threads = parallel_threads(options->threads), resolution = options->form_factor.resolution, count = 0,
        noisy = 0;
    int *patch = ARENA_ARRAY(&arena, int, mesh->patch_count + 1),
        *next = ARENA_ARRAY(&arena, int, shoot_rows_most(rows));
    send_strong(mesh, rows, options->borders, next, solution);
    Gathering g = {.mesh = mesh,
                   .rows = rows,
                   .reflected = reflected_power(mesh, solution, &arena),
                   .middle = follow ? NULL : ARENA_ARRAY(&arena, Vec3, mesh->element_count + 1),
                   .sent = solution->sent,
                   .out = solution->reflected,
                   .samples = M_PI / 4 * resolution * resolution,
                   .noise = solution->noise,
                   .close = solution->close,
                   .patches = ARENA_ARRAY(&arena, int, mesh->patch_count + 1)};
    for (int e = 0; e < mesh->element_count && g.middle; e++) g.middle[e] = element_centroid(mesh, e);
    const Daylight *day = &solution->day;
    daylight_below(day, g.below);
    for (int c = 0; c < 3; c++) {
        g.zenith[c] = M_PI * day->zenith[c];
        g.below[c] *= M_PI;
    }
    if (rgb_sum(day->beam) > 0) sunlight_elements(mesh, day, threads, solution->sun);
    if (options->borders) borders_fetch(options->borders, &BORDER_VALUE(BORDER_ELEMENT, solution->sun), 1);
    if (follow) find_changed(mesh, solution, follow);
    for (int p = 0; p < mesh->patch_count; p++) {
        if (!mesh_owns(mesh, mesh->patches[p].face) || (follow && !follow->found.has[p])) continue;
        // Those to which no light was shot are covered, or in rooms without light.
        take_shot(mesh, solution, p, solution->reflected[p]);
        if (follow && is_rounding(solution, mesh->patches[p].area, solution->reflected[p]))
            memset(solution->reflected[p], 0, sizeof *solution->reflected);
        if (gathers(mesh, p) && rgb_sum(solution->reflected[p]) > 0) patch[count++] = p;
    }
    bool go_on = gather_patches(&g, patch, count, threads, progress);
    if (shoot_rows_settled(rows)) {
        arena_free(&arena);
        return go_on;
    }
    qsort_r(patch, (size_t)count, sizeof *patch, noisiest_first, g.noise);
    while (noisy < MOST_NOISY * count && (double)g.noise[patch[noisy]] > MOST_NOISE) noisy++;
    qsort(patch, (size_t)noisy, sizeof *patch, by_index);
    // Rows of strong patches are as fine already.
    int left = 0;
    for (int i = 0; i < noisy; i++)
        if (!solution->strong[patch[i]]) patch[left++] = patch[i];
    noisy = left;
    for (int i = 0; i < noisy; i++) shoot_rows_refine(rows, patch[i]);
    go_on = go_on && gather_patches(&g, patch, noisy, threads, progress);
    if (memory_in_file()) shoot_rows_rest(rows);
    if (options->borders) {
        go_on = !team_any(borders_member(options->borders), !go_on);
        fetch_gathered(options->borders, solution);
    }
    if (go_on) shoot_rows_settle(rows);
    arena_free(&arena);
    return go_on;
}
