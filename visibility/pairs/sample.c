// sample.c - exact visibility from points, one eye after the other.
//
// From an eye, the pyramid through a portal is narrowed by each portal ahead (W. Jones 1971; as Luebke & Georges 1995 do
// for a camera), without any tolerance: the rest of a portal is the part that the eye sees. A cell's eyes lie on its own
// portals, looking outwards, since every line that leaves it passes one there; and inside it, for good measure. Each row
// of the result belongs to one cell and one task, so threads do not show.
#include "visibility/pairs/sample.h"

#include <omp.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "visibility/pairs/witness.h"

// Portals have at most 64 corners in files; each clip by a pyramid of k sides adds at most k. Portals with more are left out,
// which costs the lower bound a pair at most.
enum { MOST_CORNERS = 128 };
// Windows below this solid angle, steradians, are not looked through: hardly anything behind them stands the second walk.
static const double SMALLEST_WINDOW = 1e-13;
// How far eyes near a corner are drawn towards the middle of their portal: the narrowest sightlines pass by corners.
static const double FROM_CORNER[] = {1e-3, 0.05};

SampleOptions sample_default_options(void) { return (SampleOptions){.points = 12, .seed = 1}; }

// The part of a portal that is seen, from the eye as origin, counter-clockwise as seen.
typedef struct Window {
    int count;
    Vec3 v[MOST_CORNERS];
    Vec3 side[MOST_CORNERS];  // of the pyramid through it, pointing inwards; side k holds corners k and k + 1
} Window;

typedef struct Sampler {
    const CellGraph *graph;
    int source;  // the cell whose row it is
    uint64_t *row;
    Vec3 eye;
    unsigned char *on_path;  // [cell_count]
    Arena *windows;
    Window **window;  // [depth] made when first needed
    int window_count, window_capacity;
    long long seen, refuted;
    int wanted;  // the cell whose sightline is asked for, or -1
    PairWitness *sightline;
    bool found;
} Sampler;

static Window *window_at(Sampler *s, int depth) {
    while (s->window_count <= depth)
        *ARENA_PUSH(s->windows, s->window, s->window_count, s->window_capacity) =
            ARENA_ARRAY(s->windows, Window, 1);
    return s->window[depth];
}

// The corners of a portal from the eye, counter-clockwise for one who looks out of `cell`.
static void view_portal(const Sampler *s, const Portal *portal, int cell, Window *out) {
    const Vec3 *v = s->graph->portal_vertices + portal->first_vertex;
    bool forward = portal->cell[0] == cell;
    out->count = portal->vertex_count;
    for (int i = 0; i < out->count; i++) out->v[i] = vec3_sub(v[forward ? i : out->count - 1 - i], s->eye);
}

// Keeps the part on the positive side of a plane through the eye.
static void clip_window(Window *w, Vec3 n) {
    Vec3 in[MOST_CORNERS];
    double distance[MOST_CORNERS];
    int count = w->count, outside = 0;
    for (int i = 0; i < count; i++) {
        distance[i] = vec3_dot(n, w->v[i]);
        outside += distance[i] < 0;
    }
    if (outside == 0) return;
    memcpy(in, w->v, (size_t)count * sizeof *in);
    w->count = polygon_clip_band(in, distance, count, 0, w->v);
}

// Half the sum of the turned corners, weighed by the distance: about the solid angle of a small window, negative where it
// is seen from behind.
static double solid_angle(const Window *w, Vec3 middle) {
    Vec3 area = {0, 0, 0};
    for (int i = 0; i < w->count; i++) {
        Vec3 a = vec3_sub(w->v[i], w->v[0]), b = vec3_sub(w->v[(i + 1) % w->count], w->v[0]);
        area = vec3_add(area, vec3_cross(b, a));
    }
    double distance = vec3_length(middle);
    return 0.5 * vec3_dot(area, middle) / (distance * distance * distance);
}

static Vec3 window_middle(const Window *w) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < w->count; i++) sum = vec3_add(sum, w->v[i]);
    return vec3_scale(sum, 1.0 / w->count);
}

static bool is_marked(const Sampler *s, int cell) { return s->row[cell / 64] >> (cell % 64) & 1; }

static void try_sightline(Sampler *s, int cell, Vec3 middle) {
    Vec3 to = vec3_add(s->eye, middle);
    if (!witness_walk(s->graph, s->source, cell, s->eye, to).proves) {
        s->refuted++;
        return;
    }
    s->row[cell / 64] |= (uint64_t)1 << (cell % 64);
    if (cell != s->wanted) return;
    *s->sightline = (PairWitness){s->source, cell, s->eye, to};
    s->found = true;
}

static void raise_sides(Window *w) {
    for (int k = 0; k < w->count; k++) w->side[k] = vec3_cross(w->v[k + 1 == w->count ? 0 : k + 1], w->v[k]);
}

// The part of a portal of `cell` that is seen within the pyramid through `frame` (NULL: everywhere); false where there is none.
static bool see(const Sampler *s, int cell, const Portal *portal, const Window *frame, Window *out,
                Vec3 *middle) {
    double before = plane_distance(portal->plane, s->eye);
    bool from_behind = (portal->cell[0] == cell ? before : -before) <= 0;
    if (from_behind || portal->vertex_count + (frame ? frame->count : 0) > MOST_CORNERS) return false;
    view_portal(s, portal, cell, out);
    for (int k = 0; frame && k < frame->count && out->count >= 3; k++) clip_window(out, frame->side[k]);
    if (out->count < 3) return false;
    *middle = window_middle(out);
    return solid_angle(out, *middle) > SMALLEST_WINDOW;
}

// Through each portal of `cell` but the one it was entered by, as far as the window at `depth` - 1 shows it.
static void look_through(Sampler *s, int cell, int entered_by, int depth) {
    const Cell *from = &s->graph->cells[cell];
    Window *next = window_at(s, depth);
    const Window *frame = depth > 0 ? s->window[depth - 1] : NULL;
    for (int i = from->first_way; i < from->first_way + from->way_count && !s->found; i++) {
        const Way *way = &s->graph->ways[i];
        Vec3 middle;
        if (way->portal == entered_by || s->on_path[way->cell]) continue;
        if (!see(s, cell, &s->graph->portals[way->portal], frame, next, &middle)) continue;
        s->seen++;
        if (!is_marked(s, way->cell)) try_sightline(s, way->cell, middle);
        raise_sides(next);
        s->on_path[way->cell] = 1;
        look_through(s, way->cell, way->portal, depth + 1);
        s->on_path[way->cell] = 0;
    }
}

// The k-th point of a portal: first near its corners, then anywhere within.
static Vec3 point_on(const CellGraph *graph, const Portal *portal, int k, Random *random) {
    enum { NEAR = sizeof FROM_CORNER / sizeof *FROM_CORNER };
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    int count = portal->vertex_count;
    Vec3 sum = {0, 0, 0}, middle = {0, 0, 0};
    double total = 0;
    for (int i = 0; i < count; i++) {
        double weight = -log(1 - random_unit(random));  // exponential weights: evenly over the simplex
        sum = vec3_add(sum, vec3_scale(v[i], weight));
        middle = vec3_add(middle, vec3_scale(v[i], 1.0 / count));
        total += weight;
    }
    if (k < NEAR * count) return vec3_lerp(v[k % count], middle, FROM_CORNER[k / count]);
    return total > 0 ? vec3_scale(sum, 1 / total) : middle;
}

// Somewhere between points of the cell's portals: inside, as it is convex.
static Vec3 point_in(const CellGraph *graph, const Cell *cell, Random *random) {
    Vec3 sum = {0, 0, 0};
    double total = 0;
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[i].portal];
        double weight = -log(1 - random_unit(random));
        Vec3 p = point_on(graph, portal, INT32_MAX, random);
        sum = vec3_add(sum, vec3_scale(p, weight));
        total += weight;
    }
    return vec3_scale(sum, 1 / total);
}

// All sightlines out of the portal that `way` leads through, from the points on it.
static void look_out(Sampler *s, const Way *way, const SampleOptions *options) {
    static const uint64_t SPREAD = 0xd1b54a32d192ed03u;  // portals get streams of their own
    const Portal *portal = &s->graph->portals[way->portal];
    bool forward = portal->cell[0] == s->source;
    Random random = {options->seed ^ (SPREAD * (uint64_t)(way->portal + 1))};
    s->on_path[way->cell] = 1;
    for (int k = 0; k < options->points && !s->found; k++) {
        s->eye = point_on(s->graph, portal, k, &random);
        double ahead = vec3_length(vec3_sub(s->eye, s->graph->portal_vertices[portal->first_vertex]));
        if (!is_marked(s, way->cell))
            try_sightline(s, way->cell, vec3_scale(portal->plane.n, forward ? -ahead : ahead));
        look_through(s, way->cell, way->portal, 0);
    }
    s->on_path[way->cell] = 0;
}

static void sample_cell(Sampler *s, const SampleOptions *options) {
    const Cell *cell = &s->graph->cells[s->source];
    s->row[s->source / 64] |= (uint64_t)1 << (s->source % 64);
    if (cell->way_count == 0) return;
    s->on_path[s->source] = 1;
    for (int i = cell->first_way; i < cell->first_way + cell->way_count && !s->found; i++)
        look_out(s, &s->graph->ways[i], options);
    Random random = {options->seed + (uint64_t)s->source};
    for (int k = 0; k < options->points && !s->found; k++) {
        s->eye = point_in(s->graph, cell, &random);
        look_through(s, s->source, -1, 0);
    }
    s->on_path[s->source] = 0;
}

static Sampler sampler_new(const CellGraph *graph, Arena *arena) {
    return (Sampler){.graph = graph,
                     .on_path = ARENA_ARRAY(arena, unsigned char, graph->cell_count),
                     .windows = arena,
                     .wanted = -1};
}

static void make_symmetric(SampleSet *set) {
    for (int i = 0; i < set->cell_count; i++) {
        for (int j = 0; j < i; j++) {
            if (!pair_bit(set->proven, set->words, i, j) && !pair_bit(set->proven, set->words, j, i))
                continue;
            set->proven[(size_t)i * (size_t)set->words + (size_t)j / 64] |= (uint64_t)1 << (j % 64);
            set->proven[(size_t)j * (size_t)set->words + (size_t)i / 64] |= (uint64_t)1 << (i % 64);
        }
    }
}

void sample_pairs(const CellGraph *graph, const SampleOptions *options, const Progress *progress,
                  Arena *arena, SampleSet *out) {
    int cells = graph->cell_count, words = (cells + 63) / 64, done = 0;
    int threads = options->threads > 0 ? options->threads : omp_get_num_procs();
    *out = (SampleSet){.cell_count = cells, .words = words};
    uint64_t *rows = out->proven = ARENA_ARRAY(arena, uint64_t, (size_t)cells * (size_t)words);
    long long windows = 0, refuted = 0;
    bool stopped = false;
#pragma omp parallel num_threads(threads) reduction(+ : windows, refuted)
    {
        Arena own = {0};
        Sampler sampler = sampler_new(graph, &own);
#pragma omp for schedule(dynamic, 1)
        for (int c = 0; c < cells; c++) {
            bool stop;
#pragma omp atomic read
            stop = stopped;
            if (stop) continue;
            sampler.source = c;
            sampler.row = rows + (size_t)c * (size_t)words;
            sample_cell(&sampler, options);
#pragma omp critical
            if (!progress_report(progress, "sampling", (double)++done / cells)) {
#pragma omp atomic write
                stopped = true;
            }
        }
        windows += sampler.seen;
        refuted += sampler.refuted;
        arena_free(&own);
    }
    out->windows = windows;
    out->refuted = refuted;
    out->stopped = stopped;
    make_symmetric(out);
}

bool sample_sightline(const CellGraph *graph, const SampleOptions *options, int a, int b, PairWitness *out) {
    Arena scratch = {0};
    Sampler sampler = sampler_new(graph, &scratch);
    sampler.source = a;
    sampler.row = ARENA_ARRAY(&scratch, uint64_t, (graph->cell_count + 63) / 64);
    sampler.wanted = b;
    sampler.sightline = out;
    sample_cell(&sampler, options);
    arena_free(&scratch);
    return sampler.found;
}
