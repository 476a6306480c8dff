// cast.c - see cast.h. A line passes inside a portal when it passes all edges on the same side, by the products of their Pluecker
// coordinates: six multiplications an edge, and no point of intersection.
#include "visibility/pairs/cast.h"

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "visibility/pairs/sight.h"

void cast_build(const WayGraph *ways, Arena *arena, Cast *out) {
    int count = 0;
    *out = (Cast){.ways = ways, .first = ARENA_ARRAY(arena, int, ways->way_count + 1)};
    for (int w = 0; w < ways->way_count; w++) out->first[w] = count, count += ways->ways[w].corner_count;
    out->first[ways->way_count] = count;
    out->edges = ARENA_ARRAY(arena, CastEdge, count + 1);
    for (int w = 0; w < ways->way_count; w++) {
        const WayShape *way = &ways->ways[w];
        for (int k = 0; k < way->corner_count; k++) {
            Vec3 a = way->corners[k], b = way->corners[k + 1 == way->corner_count ? 0 : k + 1];
            Vec3 along = vec3_normalize(vec3_sub(b, a));
            // The sine of line and edge is at most 1: the margin of sight_passes is at least what passes here.
            double least = way->coarse ? INFINITY : SIGHT_MARGIN * ways->epsilon + way->facet.bend;
            out->edges[out->first[w] + k] = (CastEdge){along, vec3_cross(a, along), least};
        }
    }
}

typedef struct CastRay {
    Vec3 from, along, moment;
} CastRay;

static bool passes(const Cast *cast, int w, const CastRay *ray) {
    // Twice what is demanded: the direction has unit length but for rounding.
    if (!(vec3_dot(cast->ways->ways[w].facet.plane.n, ray->along) >= 2 * SIGHT_FLATTEST)) return false;
    for (int i = cast->first[w]; i < cast->first[w + 1]; i++) {
        const CastEdge *edge = &cast->edges[i];
        if (!(vec3_dot(ray->along, edge->moment) + vec3_dot(edge->along, ray->moment) >= edge->least))
            return false;
    }
    return true;
}

static double crossing(const WayShape *way, const CastRay *ray) {
    return -plane_distance(way->facet.plane, ray->from) / vec3_dot(way->facet.plane.n, ray->along);
}

// From `cell`, which the ray enters at `at`, to the end: appends the cells and the places where the ray leaves each.
static void cast_on(const Cast *cast, const CastRay *ray, int cell, double at, CastPath *path) {
    const WayGraph *ways = cast->ways;
    for (bool on = true; on;) {
        on = false;
        path->cells[path->count] = cell;
        path->places[path->count++] = at;
        for (int i = ways->first[cell]; i < ways->first[cell + 1] && path->count < ways->cell_count; i++) {
            int w = ways->list[i];
            if (!passes(cast, w, ray)) continue;
            double out = crossing(&ways->ways[w], ray);
            if (out < at - ways->epsilon) continue;
            // Half-way through the cell; in the last one the place stays where the ray came in.
            path->places[path->count - 1] = 0.5 * (at + out);
            at = out;
            cell = ways->ways[w].to;
            on = true;
            break;
        }
    }
}

bool cast_line(const Cast *cast, int way, Vec3 point, Vec3 direction, CastPath *path) {
    const WayShape *start = &cast->ways->ways[way];
    CastRay ahead = {point, direction, vec3_cross(point, direction)};
    if (!passes(cast, way, &ahead)) return false;
    CastRay back = {point, vec3_scale(direction, -1), vec3_scale(ahead.moment, -1)};
    path->count = 0;
    cast_on(cast, &back, start->from, 0, path);
    for (int i = 0, k = path->count - 1; i <= k; i++, k--) {
        int cell = path->cells[i];
        double place = path->places[i];
        path->cells[i] = path->cells[k];
        path->places[i] = -path->places[k];
        path->cells[k] = cell;
        path->places[k] = -place;
    }
    path->source = path->count - 1;
    cast_on(cast, &ahead, start->to, 0, path);
    return true;
}

void cast_record(const CastPath *path, Vec3 point, Vec3 direction, Finding *finding) {
    if (path->count < 3) return;  // neighbours, between whose places no line need be
    for (int i = 0; i + 1 < path->count; i++) {
        Vec3 from = vec3_add(point, vec3_scale(direction, path->places[i]));
        for (int k = i + 1; k < path->count; k++) {
            Vec3 to = vec3_add(point, vec3_scale(direction, path->places[k]));
            finding_add(finding, path->cells[i], path->cells[k], from, to);
        }
    }
}

static Vec3 random_direction(Random *random) {
    double z = random_between(random, -1, 1), turn = random_between(random, 0, 2 * M_PI),
           flat = sqrt(1 - z * z);
    return vec3(flat * cos(turn), flat * sin(turn), z);
}

// Anywhere within the portal: exponential weights of the corners lie evenly over the simplex.
static Vec3 random_point(const WayShape *way, Random *random) {
    Vec3 sum = {0, 0, 0};
    double total = 0;
    for (int k = 0; k < way->corner_count; k++) {
        double weight = -log(1 - random_unit(random));
        sum = vec3_add(sum, vec3_scale(way->corners[k], weight));
        total += weight;
    }
    return vec3_scale(sum, 1 / total);
}

// A run of portals whose lines are cast together.
typedef struct CastRun {
    Rounds *rounds;
    Finding *findings;  // [count]
    CastPath *paths;    // [threads]
    int before;
} CastRun;

enum { LINES = 10, PORTALS = 32, RUNS = 64 };  // lines of a portal; portals of a task, tasks at once

static void cast_some(void *context, int index, int thread) {
    static const uint64_t SPREAD = 0xd1b54a32d192ed03u;  // portals get streams of their own
    CastRun *run = context;
    Rounds *r = run->rounds;
    Finding *finding = &run->findings[index];
    *finding = (Finding){.rounds = r};
    int first = run->before + index * PORTALS;
    for (int p = first; p < first + PORTALS && 2 * p < r->ways.way_count; p++) {
        Random random = {SPREAD * (uint64_t)(p + 1)};
        const WayShape *way = &r->ways.ways[2 * p];
        if (!rounds_asks(r, way->from) && !rounds_asks(r, way->to)) continue;
        for (int k = 0; k < LINES; k++) {
            Vec3 point = random_point(way, &random), direction = random_direction(&random);
            if (vec3_dot(direction, way->facet.plane.n) < 0) direction = vec3_scale(direction, -1);
            if (cast_line(r->cast, 2 * p, point, direction, &run->paths[thread]))
                cast_record(&run->paths[thread], point, direction, finding);
        }
    }
}

static Bytes pack_some(void *context, int index, Arena *arena) {
    return finding_pack(&((const CastRun *)context)->findings[index], NULL, 0, arena);
}

static void unpack_some(void *context, int index, Bytes packed) {
    Finding *finding = &((CastRun *)context)->findings[index];
    *finding = (Finding){0};
    finding_unpack(finding, NULL, 0, packed);
}

CastPath cast_path(const WayGraph *ways, Arena *arena) {
    return (CastPath){.cells = ARENA_ARRAY(arena, int, ways->cell_count + 1),
                      .places = ARENA_ARRAY(arena, double, ways->cell_count + 1)};
}

void cast_from_portals(Rounds *r) {
    Arena scratch = {0};
    int portals = r->ways.way_count / 2;
    CastRun run = {.rounds = r,
                   .findings = ARENA_ARRAY(&scratch, Finding, RUNS),
                   .paths = ARENA_ARRAY(&scratch, CastPath, r->threads)};
    for (int i = 0; i < r->threads; i++) run.paths[i] = cast_path(&r->ways, &scratch);
    SharedLoop loop = {RUNS, cast_some, pack_some, unpack_some, &run};
    for (; run.before < portals; run.before += RUNS * PORTALS) {
        rounds_report(r, "lines", run.before, portals);
        rounds_agree_stop(r);
        if (r->stopped) break;
        parallel_share(r->threads, &loop);
        for (int i = 0; i < RUNS; i++) rounds_take_proofs(r, &run.findings[i]);
    }
    arena_free(&scratch);
}
