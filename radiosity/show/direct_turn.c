// direct_turn.c - the hour turns: what lamps give does not change with it. So lamps have a mesh of their own, which shows their light
// alone, and the mesh of another hour has it from there: at its nodes, or as it is between them.
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/show/direct_sources.h"
#include "radiosity/show/reconstruct.h"

// Corners lie this share of the way to the middle of their element when their element of the mesh of the lamps is looked for.
static const double INWARDS = 1e-4;
// Elements that one thread takes at a time.
enum { AT_A_TIME = 1024 };

// Sums of what points give, by source.
struct SourceSums {
    double (*light)[3];  // [sources]
    bool *touched;       // [sources]
    int *list, count;    // of those that are
};

SourceSums *source_sums_new(const DirectSources *s, Arena *arena) {
    SourceSums *out = ARENA_ARRAY(arena, SourceSums, 1);
    out->light = arena_alloc(arena, (size_t)s->day + 1, sizeof *out->light);
    out->touched = ARENA_ARRAY(arena, bool, s->day + 1);
    out->list = ARENA_ARRAY(arena, int, s->day + 1);
    return out;
}

// `only`: of this source alone; -1: of all.
static void add_share(SourceSums *sums, const PointSources *by, double share, int only) {
    for (int k = 0; by && k < by->count; k++) {
        int source = by->by[k].source;
        if (only >= 0 && source != only) continue;
        if (!sums->touched[source]) sums->list[sums->count++] = source;
        sums->touched[source] = true;
        for (int c = 0; c < 3; c++) sums->light[source][c] += share * (double)by->by[k].light[c];
    }
}

// The sum, which begins anew. NULL: no source gives anything.
static const PointSources *take_sum(SourceSums *sums, Arena *arena) {
    if (sums->count == 0) return NULL;
    PointSources *out = arena_alloc(arena, sizeof *out + (size_t)sums->count * sizeof *out->by, 1);
    out->count = sums->count;
    for (int i = 0; i < sums->count; i++) {
        int source = sums->list[i];
        out->by[i].source = source;
        for (int c = 0; c < 3; c++) out->by[i].light[c] = (float)sums->light[source][c];
        memset(sums->light[source], 0, sizeof *sums->light);
        sums->touched[source] = false;
    }
    sums->count = 0;
    return out;
}

static bool same_place(Vec3 a, Vec3 b) { return vec3_length(vec3_sub(a, b)) < DIRECT_SAME_PLACE; }

// The light at a corner of the mesh of the lamps.
static const PointSources *lamps_at_corner(const DirectSources *lamps, int element, int corner) {
    Direct of = {.mesh = lamps->shown, .nodes = &lamps->nodes};
    Vec3 towards;
    if (direct_corner_counts(&of, element, corner, &towards)) return lamps->corner[corner];
    return lamps->node[lamps->nodes.of_corner[corner]];
}

// Adds the light of lamps at a point of a face, which lies in an element of their mesh.
static void add_at(SourceSums *sums, const DirectSources *lamps, int element, Vec3 point) {
    const Mesh *mesh = lamps->shown;
    const Element *e = &mesh->elements[element];
    int corner[3];
    double share[3];
    for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++) {
        if (!same_place(mesh->vertices[mesh->corners[c]], point)) continue;
        add_share(sums, lamps_at_corner(lamps, element, c), 1, -1);
        return;
    }
    reconstruct_shares(mesh, lamps->triangle, element, point, corner, share);
    for (int i = 0; i < 3; i++) add_share(sums, lamps_at_corner(lamps, element, corner[i]), share[i], -1);
}

typedef struct Corners {
    const DirectSources *s;
    const Mesh *mesh;
    const Nodes *nodes;
    const PointSources **by;
    SourceSums **sums;  // [threads]
} Corners;

static void add_to_corners(void *context, int index, int thread) {
    const Corners *k = context;
    const DirectSources *lamps = k->s->lamps;
    const Mesh *mesh = k->mesh;
    Direct of = {.mesh = mesh, .nodes = k->nodes};
    SourceSums *sums = k->sums[thread];
    for (int e = index * AT_A_TIME; e < (index + 1) * AT_A_TIME && e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        Vec3 middle = element_centroid(mesh, e);
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            Vec3 at = mesh->vertices[mesh->corners[c]], towards;
            if (!direct_corner_counts(&of, e, c, &towards)) continue;
            Vec3 inside = vec3_add(at, vec3_scale(vec3_sub(middle, at), INWARDS));
            add_at(sums, lamps, mesh_element_at(lamps->shown, element->face, inside), at);
            add_share(sums, k->by[c], 1, -1);
            k->by[c] = take_sum(sums, &k->s->kept[thread]);
        }
    }
}

void direct_turn_corners(const DirectSources *s, const Mesh *mesh, const Nodes *nodes,
                         const PointSources **by) {
    Arena scratch = {0};
    Corners k = {s, mesh, nodes, by, ARENA_ARRAY(&scratch, SourceSums *, s->threads)};
    for (int t = 0; t < s->threads; t++) k.sums[t] = source_sums_new(s, &scratch);
    parallel_for(s->threads, (mesh->element_count + AT_A_TIME - 1) / AT_A_TIME, add_to_corners, &k);
    arena_free(&scratch);
}

bool direct_turn_middle(const DirectSources *s, SourceSums *sums, const Mesh *shown, const Nodes *nodes,
                        int element, bool sun_known, const PointSources **by) {
    const DirectSources *lamps = s->lamps;
    const Element *e = &shown->elements[element];
    Vec3 middle = element_centroid(shown, element);
    int there = mesh_element_at(lamps->shown, e->face, middle);
    bool whole = same_place(element_centroid(lamps->shown, there), middle);
    if (!(whole ? lamps->middle_known[there] : sun_known)) return false;
    if (whole)
        add_share(sums, lamps->middle[there], 1, -1);
    else
        add_at(sums, lamps, there, middle);
    if (sun_known) add_share(sums, *by, 1, s->day);
    for (int c = e->first_corner; c < e->first_corner + e->corner_count && !sun_known; c++)
        add_share(sums, s->node[nodes->of_corner[c]], 1.0 / e->corner_count, s->day);
    *by = take_sum(sums, &s->kept[0]);
    return true;
}

void direct_sources_turn(DirectSources *sources, const DirectSources *lamps, const DirectSources *before) {
    sources->parts.sky_parts = true;
    sources->parts.before = before ? &before->parts : NULL;
    sources->lamps = lamps && lamps->shown && lamps->show.lamps ? lamps : NULL;
}
