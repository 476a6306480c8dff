// each_lamp.c - one source after the other is shot along the rows that are there, and shown on the nodes that are there.
#include "radiosity/follow/each_lamp.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"

// The share of all lamps' light below which a lamp's light is left out in a block. Where all others are off and what is left is a
// thousandth of the brightest state, below which nobody looks, a lamp that is left out is less than half a hundredth of it.
static const double LEAST = 4e-6;
// Light of a lamp that is not shot, as a share of the residual of all light and of the lamp's: rooms that the lamp hardly reaches have
// only what is shot last, and are looked at when all other lamps are off.
static const double OF_RESIDUAL = 1e-3, ENOUGH = 1e-6, AT_MOST = 0.1;
// That of the day: all rooms that it reaches have more than a lamp's.
static const double OF_DAY = 0.1;

DirectSources *each_lamp_sources(const Mesh *mesh, const Lamps *lamps, int threads, Arena *arena) {
    int *source = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    // Stand-ins emit nothing.
    for (int f = 0; f < mesh->face_count; f++)
        source[f] = mesh->faces[f].polygon < 0 ? -1 : lamps->of_polygon[mesh->faces[f].polygon];
    return direct_sources_new(source, lamps->count, threads, arena);
}

typedef struct Finder {
    const EachLamp *each;
    RadSolution *all;  // of all lamps, as they are summed up
    LampLight *out;
    const Progress *progress;
    RadOptions options;
} Finder;

// The mesh with one lamp alone, or with none: -1.
static Mesh mesh_of_source(const Finder *f, int lamp, Arena *arena) {
    Rgb *lit = ARENA_ARRAY(arena, Rgb, f->each->lamps->count + 1);
    if (lamp >= 0) lit[lamp] = (Rgb){1, 1, 1};
    return lamps_mesh(f->each->lamps, f->each->mesh, lit, arena);
}

// Steps within patches are trusted as they were for all light together: so the sum stays a sum.
static void take_noise(const RadSolution *all, RadSolution *s) {
    memcpy(s->noise, all->noise, (size_t)s->patch_count * sizeof *s->noise);
}

// Part `index` of `count` of the whole.
typedef struct PartOfProgress {
    const Progress *whole;
    int index, count;
} PartOfProgress;

static bool report_part(void *context, const char *stage, double done) {
    const PartOfProgress *part = context;
    char line[96];
    snprintf(line, sizeof line, "lamp %d of %d: %.60s", part->index + 1, part->count, stage);
    return progress_report(part->whole, line, (part->index + done) / part->count);
}

// Shoots and shows the light of a source; -1: of the day.
static bool light_source(Finder *f, int lamp, const Progress *progress, Arena *arena, RadSolution *out) {
    const EachLamp *each = f->each;
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    Error error;
    *mesh = mesh_of_source(f, lamp, arena);
    if (!rad_start_dark(mesh, arena, out, &error)) return false;
    // Hardly any of what is left of the day is in a room that has none of it: it is shot as all light is.
    RadOptions options = f->options;
    if (lamp < 0) options.residual = fmax(options.residual, OF_DAY * each->options->residual);
    if (lamp < 0 && !rad_shine(mesh, each->forest, each->door_open, &options, &f->all->day, progress, out))
        return false;
    if (rad_shoot(mesh, each->forest, each->door_open, &options, progress, out).stopped) return false;
    take_noise(f->all, out);
    double(*share)[3] = arena_alloc(arena, (size_t)each->lamps->count + 1, sizeof *share);
    for (int c = 0; c < 3; c++) share[lamp < 0 ? each->lamps->count : lamp][c] = 1;
    return direct_show_source(each->sources, share, mesh, progress, arena, out);
}

static LampLight source_light(const Finder *f, const RadSolution *s, bool day, Arena *arena) {
    const RadSolution *all = f->all;
    Arena scratch = {0};
    double(*straight)[3] = arena_alloc(&scratch, (size_t)s->node_count + 1, sizeof *straight),
    (*elements)[3] = day ? NULL : all->radiosity, (*nodes)[3] = day ? NULL : all->node;
    for (int n = 0; n < s->node_count; n++)
        for (int c = 0; c < 3; c++) straight[n][c] = fmax(s->node[n][c] - s->rest[n][c], 0);
    LampLight out = {.radiosity = sparse_light_new(s->radiosity, elements, s->element_count, LEAST, arena),
                     .direct = sparse_light_new(s->direct, elements, s->element_count, LEAST, arena),
                     .straight = sparse_light_new(straight, nodes, s->node_count, LEAST, arena),
                     .rest = sparse_light_new(s->rest, nodes, s->node_count, LEAST, arena)};
    memcpy(out.emitted, s->emitted, sizeof out.emitted);
    memcpy(out.absorbed, s->absorbed, sizeof out.absorbed);
    memcpy(out.escaped, s->escaped, sizeof out.escaped);
    arena_free(&scratch);
    return out;
}

static bool find_sources(Finder *f, int count, Arena *arena) {
    Arena scratch = {0};
    bool good = true, day = count > f->each->lamps->count;
    for (int i = 0; i < count && good; i++) {
        // The day comes first: rows of parts are made under it.
        int lamp = day ? i - 1 : i, at = lamp < 0 ? count - 1 : lamp;
        PartOfProgress part = {f->progress, i, count};
        Progress progress = {report_part, &part};
        RadSolution s;
        good = light_source(f, lamp, &progress, &scratch, &s);
        if (good) f->out[at] = source_light(f, &s, lamp < 0, arena);
        arena_free(&scratch);
    }
    return good;
}

bool each_lamp_find(const EachLamp *each, const Progress *progress, Arena *arena, RadSolution *solution) {
    bool day = daylight_shines(&solution->day);
    int count = each->lamps->count + day;
    Finder f = {.each = each,
                .all = solution,
                .out = ARENA_ARRAY(arena, LampLight, count + 1),
                .progress = progress,
                .options = *each->options};
    double residual = each->options->residual;
    f.options.residual = fmax(OF_RESIDUAL * residual, fmin(AT_MOST * residual, ENOUGH));
    // Most rooms have next to nothing of one lamp.
    f.options.each_room = false;
    f.options.show = NULL;
    bool good = find_sources(&f, count, arena);
    if (!good) return false;
    Rgb *lit = ARENA_ARRAY(arena, Rgb, each->lamps->count + 1);
    for (int i = 0; i < each->lamps->count; i++) lit[i] = (Rgb){1, 1, 1};
    solution->each = f.out;
    solution->each_count = count;
    solution->lamp_count = each->lamps->count;
    each_lamp_sum(solution, lit);
    solution->lit = lit;
    return true;
}

static void add_source(const LampLight *light, const double share[3], RadSolution *s) {
    sparse_light_add(&light->radiosity, share, s->radiosity);
    sparse_light_add(&light->direct, share, s->direct);
    sparse_light_add(&light->straight, share, s->node);
    sparse_light_add(&light->rest, share, s->rest);
    for (int c = 0; c < 3; c++) {
        s->emitted[c] += share[c] * light->emitted[c];
        s->absorbed[c] += share[c] * light->absorbed[c];
        s->escaped[c] += share[c] * light->escaped[c];
    }
}

static void begin_sum(RadSolution *s) {
    memset(s->radiosity, 0, (size_t)s->element_count * sizeof *s->radiosity);
    memset(s->direct, 0, (size_t)s->element_count * sizeof *s->direct);
    memset(s->unshot, 0, (size_t)s->patch_count * sizeof *s->unshot);
    memset(s->node, 0, (size_t)s->node_count * sizeof *s->node);
    memset(s->rest, 0, (size_t)s->node_count * sizeof *s->rest);
    for (int c = 0; c < 3; c++) s->emitted[c] = s->absorbed[c] = s->escaped[c] = 0;
}

static void end_sum(RadSolution *s) {
    for (int n = 0; n < s->node_count; n++)
        for (int c = 0; c < 3; c++) s->node[n][c] += s->rest[n][c];
}

void each_lamp_sum(RadSolution *s, const Rgb *lit) {
    begin_sum(s);
    for (int i = 0; i < s->each_count; i++) {
        double share[3] = {1, 1, 1};
        if (i < s->lamp_count) rgb_doubles(lit[i], share);
        if (rgb_sum(share) > 0) add_source(&s->each[i], share, s);
    }
    end_sum(s);
}

RadSolution each_lamp_one(const RadSolution *solution, int source, Arena *arena) {
    static const double WHOLE[3] = {1, 1, 1};
    RadSolution out = *solution;
    out.radiosity = arena_alloc(arena, (size_t)out.element_count + 1, sizeof *out.radiosity);
    out.direct = arena_alloc(arena, (size_t)out.element_count + 1, sizeof *out.direct);
    out.unshot = arena_alloc(arena, (size_t)out.patch_count + 1, sizeof *out.unshot);
    out.node = arena_alloc(arena, (size_t)out.node_count + 1, sizeof *out.node);
    out.rest = arena_alloc(arena, (size_t)out.node_count + 1, sizeof *out.rest);
    begin_sum(&out);
    add_source(&out.each[source], WHOLE, &out);
    end_sum(&out);
    return out;
}

size_t each_lamp_bytes(const RadSolution *s) {
    size_t bytes = 0;
    for (int i = 0; i < s->each_count; i++)
        bytes += sizeof *s->each + sparse_light_bytes(&s->each[i].radiosity) +
                 sparse_light_bytes(&s->each[i].direct) + sparse_light_bytes(&s->each[i].straight) +
                 sparse_light_bytes(&s->each[i].rest);
    return bytes;
}
