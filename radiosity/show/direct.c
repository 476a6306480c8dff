// direct.c - light as it is shown: straight from lamps and the sun at the nodes of a mesh that is finer where this light bends, and all
// other light as elements and rows tell it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/direct_sources.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"

bool direct_irradiance(const Mesh *mesh, const StabForest *forest, const Nodes *nodes, const Daylight *day,
                       int threads, const Progress *progress, double (*out)[3], RadReport *report) {
    Arena arena = {0};
    Direct d;
    RadReport work = {0};
    direct_start(&d, mesh, forest, nodes, day, &arena);
    bool good = direct_light(&d, threads, progress, out, report ? report : &work);
    direct_end(&d);
    arena_free(&arena);
    return good;
}

// ---- light that is shown

// The share of a building's mean light that counts as light in the dark, where errors are not seen.
static const double DARK = 0.01;
// Bends may add so many elements, as a share of those there are.
static const double MOST_ADDED = 1;
// And so many more under a sun, whose shadows have edges that are sharp wherever they pass. Homes take 10,000 to 20,000.
static const double MOST_ADDED_BY_SUN = 30000;
// Where light is to be shown in several states of the doors, bends of all of them may add so many times as many.
static const double DOORS_ADD = 1.2;
// Nodes are lifted by this share of what linear light between them is below the light at the middle of elements: so the mean of the
// two is the same where light is bent like a parabola. Where it is off by more than MOST_LIFT of all light there, at edges of shadows, they
// are left as they are.
static const double LIFT = 2.0 / 3, MOST_LIFT = 0.08;

// All light but that straight from the lamps, if `lamps`, that straight from the sun, and, if `gathered`, reflected light and that of the
// sky.
static RadSolution other_light(const Mesh *mesh, const RadSolution *solution, bool lamps, double (*sun)[3],
                               bool gathered, Arena *arena) {
    RadSolution rest = *solution;
    rest.node = NULL;
    rest.gathered = gathered;
    rest.radiosity = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *rest.radiosity);
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        for (int c = 0; c < 3; c++) {
            double direct = solution->direct[e][c], by_sun = sun ? sun[e][c] : 0,
                   all = gathered ? emitted[c] + direct + by_sun : solution->radiosity[e][c];
            rest.radiosity[e][c] = fmax(all - (lamps ? direct : 0) - by_sun, 0);
        }
    }
    return rest;
}

// The light on each element against which bends of direct light are seen, the sum of the channels, W/m^2.
static double *light_besides(const Mesh *mesh, const RadSolution *rest, const RadSolution *whole,
                             const Borders *borders, Arena *arena) {
    double *out = ARENA_ARRAY(arena, double, mesh->element_count + 1), sums[2] = {0, 0};
    RadSolution even_rest = reconstruct_even(mesh, rest, arena), even = reconstruct_even(mesh, whole, arena);
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        out[e] = fmax(rgb_sum(even_rest.radiosity[e]) - rgb_sum(emitted), 0);
        if (!mesh_owns(mesh, mesh->elements[e].face)) continue;
        sums[0] += mesh->elements[e].area * (out[e] + rgb_sum(even.direct[e]));
        sums[1] += mesh->elements[e].area;
    }
    if (borders) team_sum(borders_member(borders), sums, 2);
    for (int e = 0; e < mesh->element_count; e++) out[e] += DARK * sums[0] / sums[1];
    return out;
}

// On the mesh of a part of a building only patches that share nodes with its own faces are lit.
static void settle_others(Direct *d) {
    const Mesh *mesh = d->mesh;
    Arena scratch = {0};
    bool *lit = ARENA_ARRAY(&scratch, bool, mesh->patch_count + 1);
    for (int n = 0; n < d->nodes->count; n++) {
        bool own = false;
        const int *first = d->nodes->element + d->nodes->first[n],
                  *end = d->nodes->element + d->nodes->first[n + 1];
        for (const int *e = first; e < end; e++) own = own || mesh_owns(mesh, mesh->elements[*e].face);
        for (const int *e = first; e < end && own; e++) lit[mesh->elements[*e].patch] = true;
    }
    if (!d->settled) d->settled = ARENA_ARRAY(&d->arena, bool, mesh->patch_count + 1);
    for (int p = 0; p < mesh->patch_count; p++) d->settled[p] = d->settled[p] || !lit[p];
    arena_free(&scratch);
}

// Takes over the light of points that is known within elements of the coarser mesh. `by`: what sources give at its nodes, or NULL. Tells
// `way` [corner_count], or NULL, where these points are (Direct.towards).
static void take_known(Direct *d, const Direct *coarser, double (*at_node)[3], const PointSources **by,
                       float (*way)[2]) {
    const Mesh *mesh = d->mesh, *rough = coarser->mesh;
    d->known = ARENA_ARRAY(&d->arena, bool, mesh->corner_count + 1);
    d->settled = ARENA_ARRAY(&d->arena, bool, mesh->patch_count + 1);
    d->at_corner = arena_alloc(&d->arena, (size_t)mesh->corner_count + 1, sizeof *d->at_corner);
    if (by) d->corner_by = arena_alloc(&d->arena, (size_t)mesh->corner_count + 1, sizeof *d->corner_by);
    for (int p = 0; p < mesh->patch_count; p++) d->settled[p] = true;
    for (int e = 0; e < mesh->element_count; e++) {
        int in = shown_around(rough, mesh, e);
        const Element *element = &mesh->elements[e], *around = &rough->elements[in];
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            Vec3 at = mesh->vertices[mesh->corners[c]], towards;
            // One corner of a node in a plane counts.
            if (way) way[c][0] = way[c][1] = NAN;
            if (!direct_corner_counts(d, e, c, &towards)) continue;
            for (int i = around->first_corner; i < around->first_corner + around->corner_count; i++) {
                if (vec3_length(vec3_sub(at, rough->vertices[rough->corners[i]])) > DIRECT_SAME_PLACE)
                    continue;
                memcpy(d->at_corner[c], at_node[coarser->nodes->of_corner[i]], sizeof *at_node);
                if (by) d->corner_by[c] = by[coarser->nodes->of_corner[i]];
                if (way) direct_way(coarser, in, i, at, way[c]);
                d->known[c] = true;
                break;
            }
            const BendPoint *point =
                d->known[c] ? NULL
                            : direct_find_point(coarser->within[in].points, coarser->within[in].count, at);
            if (point) {
                memcpy(d->at_corner[c], point->irradiance, sizeof point->irradiance);
                if (by) d->corner_by[c] = coarser->within[in].by[point - coarser->within[in].points];
                if (way) direct_way(coarser, in, -1, at, way[c]);
                d->known[c] = true;
            }
            if (!d->known[c]) d->settled[element->patch] = false;
        }
    }
}

// The mean over an element of the light at its corners, linear in triangles about the first.
static void linear_mean(const Mesh *mesh, const Nodes *nodes, double (*at_node)[3], int element,
                        double out[3]) {
    const Element *e = &mesh->elements[element];
    Vec3 n = mesh->faces[e->face].plane.n, base = mesh->vertices[mesh->corners[e->first_corner]];
    const int *node = nodes->of_corner + e->first_corner;
    double all = 0;
    out[0] = out[1] = out[2] = 0;
    for (int i = 1; i + 1 < e->corner_count; i++) {
        Vec3 a = vec3_sub(mesh->vertices[mesh->corners[e->first_corner + i]], base),
             b = vec3_sub(mesh->vertices[mesh->corners[e->first_corner + i + 1]], base);
        double part = vec3_dot(n, vec3_cross(a, b));
        all += part;
        for (int c = 0; c < 3; c++)
            out[c] += part * (at_node[node[0]][c] + at_node[node[i]][c] + at_node[node[i + 1]][c]) / 3;
    }
    for (int c = 0; c < 3; c++) out[c] = all > 0 ? out[c] / all : 0;
}

DirectSources *direct_sources_new(const int *source_of, int day, int threads, Arena *arena) {
    DirectSources *out = ARENA_ARRAY(arena, DirectSources, 1);
    out->threads = parallel_threads(threads);
    out->source_of = source_of;
    out->day = day;
    out->kept = ARENA_ARRAY(arena, Arena, out->threads);
    out->parts.thread_count = out->threads;
    return out;
}

Arena direct_sources_leave(DirectSources *sources) {
    for (int t = 0; t < sources->threads; t++) arena_free(&sources->kept[t]);
    part_rows_end(&sources->parts);
    Arena mesh = sources->arena;
    sources->arena = (Arena){0};
    return mesh;
}

void direct_sources_end(DirectSources *sources) {
    Arena mesh = direct_sources_leave(sources);
    arena_free(&mesh);
}

void direct_sources_doors(DirectSources *sources, Mesh *mesh, const float *const *state, int count) {
    sources->moving = mesh;
    sources->state = state;
    sources->state_count = count;
}

static void tell_sources_apart(Direct *d, const DirectSources *sources) {
    if (!sources) return;
    d->source_of = sources->source_of;
    d->day = sources->day;
    d->kept = sources->kept;
}

// Raises the nodes of elements by their lifts; each node has the mean of its elements.
typedef struct Lift {
    double (*sum)[3];  // [nodes->count]
    int *count;
} Lift;

static Lift lift_new(const Nodes *nodes, Arena *arena) {
    return (Lift){arena_alloc(arena, (size_t)nodes->count + 1, sizeof *(Lift){0}.sum),
                  ARENA_ARRAY(arena, int, nodes->count + 1)};
}

static void lift_element(Lift *lift, const Mesh *shown, const Nodes *nodes, int e, const double off[3]) {
    const Element *element = &shown->elements[e];
    for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
        int node = nodes->of_corner[i];
        lift->count[node]++;
        for (int c = 0; c < 3; c++) lift->sum[node][c] += LIFT * off[c];
    }
}

static void lift_all(const Lift *lift, const Nodes *nodes, double (*at_node)[3]) {
    for (int n = 0; n < nodes->count; n++)
        for (int c = 0; c < 3; c++)
            at_node[n][c] =
                fmax(at_node[n][c] + (lift->count[n] > 0 ? lift->sum[n][c] / lift->count[n] : 0), 0);
}

// The light of an element by which its nodes are lifted, from that at its middle; false: the middle is off by too much, as at edges of
// shadows.
static bool find_lift(const Mesh *shown, const Nodes *nodes, double (*at_node)[3], int e,
                      const double middle[3], double besides, double off[3]) {
    double linear[3], rho[3], light = besides, gap = 0;
    linear_mean(shown, nodes, at_node, e, linear);
    rgb_doubles(mesh_material(shown, shown->elements[e].face)->reflectance, rho);
    for (int c = 0; c < 3; c++) {
        off[c] = middle[c] - linear[c];
        light += rho[c] * middle[c];
        gap += rho[c] * off[c];
    }
    bool lifts = fabs(gap) <= MOST_LIFT * light;
    if (!lifts) off[0] = off[1] = off[2] = 0;
    return lifts;
}

// The irradiance of a state of the sources.
static void put_sources(const PointSources *by, double (*share)[3], double out[3]) {
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; by && i < by->count; i++) {
        const double *of = share[by->by[i].source];
        for (int c = 0; c < 3; c++) out[c] += of[c] * (double)by->by[i].light[c];
    }
}

// All sources give all of their light.
static double (*full_shares(const DirectSources *s, Arena *arena))[3] {
    double(*share)[3] = arena_alloc(arena, (size_t)s->day + 1, sizeof *share);
    for (int i = 0; i <= s->day; i++) share[i][0] = share[i][1] = share[i][2] = 1;
    return share;
}

// Lifts nodes so that light between them is right in the mean. `d` knows the light within the elements of its mesh, in which those
// of `shown` lie. Tells `sources`, or NULL, where it does.
static void lift_nodes(const Direct *d, const Mesh *shown, const Nodes *nodes, double (*at_node)[3],
                       DirectSources *sources) {
    Arena scratch = {0};
    Lift lift = lift_new(nodes, &scratch);
    double(*ones)[3] = sources ? full_shares(sources, &scratch) : NULL;
    SourceSums *sums = sources && sources->lamps ? source_sums_new(sources, &scratch) : NULL;
    for (int e = 0; e < shown->element_count; e++) {
        int in = shown == d->mesh ? e : shown_around(d->mesh, shown, e);
        const Within *within = &d->within[in];
        const double *middle = within->middle;
        const PointSources *by = within->middle_by;
        double off[3] = {0, 0, 0};
        // Where light does not bend it is known at the middle of the whole element alone.
        if (!within->points && shown != d->mesh &&
            vec3_length(vec3_sub(element_centroid(shown, e), element_centroid(d->mesh, in))) >
                DIRECT_SAME_PLACE)
            middle = NULL;
        if (within->points) {
            const BendPoint *at =
                direct_find_point(within->points, within->count, element_centroid(shown, e));
            middle = at ? at->irradiance : NULL;
            by = at && within->by ? within->by[at - within->points] : NULL;
        }
        bool known = middle && within->middle_known;
        double all[3];
        if (sources && sources->lamps) {
            if (!known) by = NULL;
            known = direct_turn_middle(sources, sums, shown, nodes, e, known, &by);
            put_sources(by, ones, all);
            middle = all;
        }
        bool lifts = known && find_lift(shown, nodes, at_node, e, middle, d->besides[in], off);
        if (sources) {
            sources->besides[e] = (float)d->besides[in];
            sources->middle_known[e] = known;
            sources->lifts[e] = lifts;
            sources->middle[e] = known ? by : NULL;
        }
        lift_element(&lift, shown, nodes, e, off);
    }
    lift_all(&lift, nodes, at_node);
    arena_free(&scratch);
}

// How much an element lifts its nodes.
static void lift_of(const DirectSources *s, double (*share)[3], double (*unlifted)[3], int e, double off[3]) {
    double middle[3], linear[3];
    off[0] = off[1] = off[2] = 0;
    if (!s->lifts[e]) return;
    put_sources(s->middle[e], share, middle);
    linear_mean(s->shown, &s->nodes, unlifted, e, linear);
    for (int c = 0; c < 3; c++) off[c] = middle[c] - linear[c];
}

// The same at the nodes; `unlifted` [nodes.count] may be `out`.
static void sources_at_nodes(const DirectSources *s, double (*share)[3], double (*unlifted)[3],
                             double (*out)[3]) {
    Arena scratch = {0};
    Lift lift = lift_new(&s->nodes, &scratch);
    for (int n = 0; n < s->nodes.count; n++) put_sources(s->node[n], share, unlifted[n]);
    for (int e = 0; e < s->shown->element_count; e++) {
        double off[3];
        lift_of(s, share, unlifted, e, off);
        lift_element(&lift, s->shown, &s->nodes, e, off);
    }
    if (out != unlifted) memcpy(out, unlifted, (size_t)s->nodes.count * sizeof *out);
    lift_all(&lift, &s->nodes, out);
    arena_free(&scratch);
}

// Where one part of the building is stopped, all are.
static bool all_good(const Borders *borders, bool good) {
    return borders ? !team_any(borders_member(borders), !good) : good;
}

// Is all light but that straight from lamps and sun, and but reflected light, emitted, and even?
static bool rest_is_emitted(const Showing *s) { return s->rest->gathered && s->lamps; }

// Adds up the light at a node. `dark`: `rest` is what the face emits; else it is there already, but for reflected light.
static void add_up(const Showing *s, const Nodes *nodes, int n, bool dark, const double reflected[3],
                   const double straight[3], double rest[3], double all[3]) {
    double rho[3];
    const Material *m = mesh_material(s->mesh, s->shown->elements[nodes->element[nodes->first[n]]].face);
    rgb_doubles(m->reflectance, rho);
    if (dark) rgb_doubles(m->emission, rest);
    for (int c = 0; c < 3; c++) {
        rest[c] += rho[c] * reflected[c];
        all[c] = rest[c] + rho[c] * straight[c];
    }
}

// Adds up all light at the nodes of the mesh that shows it, to the light straight from lamps and sun there.
static bool store_nodes(const Showing *s, const Nodes *nodes, double (*at_node)[3], Arena *arena,
                        RadSolution *out) {
    Arena scratch = {0};
    const Mesh *mesh = s->mesh, *shown = s->shown;
    double(*reflected)[3] =
        s->reflected ? s->reflected : arena_alloc(&scratch, (size_t)nodes->count + 1, sizeof *reflected);
    bool good = true;
    if (s->rest->gathered) {
        GatherScene scene = {mesh, s->forest, s->door_open, s->solution, NULL};
        Error error;
        const Borders *borders = s->borders;
        if (borders && shown != mesh) borders = borders_new(shown, borders_member(borders), &scratch, &error);
        good = (borders || !s->borders) &&
               reflected_nodes(&scene, s->parts.gathers, shown, nodes, s->threads,
                               s->sources ? &s->sources->parts : NULL, borders, s->progress, reflected);
    }
    if (good) {
        out->node_count = nodes->count;
        out->node = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out->node);
        out->rest = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out->rest);
        const bool dark = rest_is_emitted(s);
        if (!dark) shown_nodes(mesh, s->rest, shown, nodes, out->rest);
        for (int n = 0; n < nodes->count; n++)
            add_up(s, nodes, n, dark, reflected[n], at_node[n], out->rest[n], out->node[n]);
    }
    arena_free(&scratch);
    return good;
}

static void keep_corners(DirectSources *sources, const Direct *d) {
    size_t bytes = (size_t)d->mesh->corner_count * sizeof *d->corner_by;
    sources->corner = arena_alloc(&sources->arena, (size_t)d->mesh->corner_count + 1, sizeof *d->corner_by);
    memcpy(sources->corner, d->corner_by, bytes);
}

// Stores the light at the nodes of the mesh that shows it. Direct light is known at the nodes of d->mesh; d's workers end. `good`: nothing
// has failed so far in this part of the building. Parts meet when what they hold is least, since it waits in files.
static bool light_nodes(Direct *d, const Showing *s, bool good, double (*at_node)[3], Arena *arena,
                        RadSolution *out, RadReport *report) {
    Arena scratch = {0};
    DirectSources *sources = s->sources;
    const Mesh *mesh = d->mesh, *shown = s->shown;
    Nodes finer_nodes;
    const Nodes *nodes = d->nodes;
    const PointSources **by = NULL;
    const bool take_lamps = sources && sources->lamps;
    if (!good) return all_good(s->borders, false);
    if (take_lamps && shown == mesh) direct_turn_corners(sources, mesh, nodes, d->corner_by);
    if (sources) {
        by = arena_alloc(&sources->arena, (size_t)nodes->count + 1, sizeof *by);
        direct_node_sources(d, false, by);
        keep_corners(sources, d);
    }
    if (shown != mesh) {
        Arena own = {0};
        Direct finer;
        finer_nodes = nodes_of(shown, &scratch);
        double(*irradiance)[3] = arena_alloc(&scratch, (size_t)finer_nodes.count + 1, sizeof *irradiance);
        direct_start(&finer, shown, s->forest, &finer_nodes, &s->rest->day, &own);
        finer.lamps = d->lamps;
        tell_sources_apart(&finer, sources);
        if (sources && sources->state_count > 0)
            sources->way =
                arena_alloc(&sources->arena, (size_t)shown->corner_count + 1, sizeof *sources->way);
        take_known(&finer, d, at_node, by, sources ? sources->way : NULL);
        if (s->borders) settle_others(&finer);
        good = direct_light(&finer, s->threads, s->progress, irradiance, report);
        if (good && take_lamps) direct_turn_corners(sources, shown, &finer_nodes, finer.corner_by);
        if (good && sources) {
            by = arena_alloc(&sources->arena, (size_t)finer_nodes.count + 1, sizeof *by);
            direct_node_sources(&finer, false, by);
            keep_corners(sources, &finer);
        }
        direct_end(&finer);
        arena_free(&own);
        at_node = irradiance;
        nodes = &finer_nodes;
    }
    if (sources) {
        sources->node = by;
        sources->lifts = ARENA_ARRAY(&sources->arena, bool, shown->element_count + 1);
        sources->middle_known = ARENA_ARRAY(&sources->arena, bool, shown->element_count + 1);
        sources->besides = ARENA_ARRAY(&sources->arena, float, shown->element_count + 1);
        sources->middle = arena_alloc(&sources->arena, (size_t)shown->element_count + 1, sizeof *by);
    }
    if (good && take_lamps) {
        double(*share)[3] = full_shares(sources, &scratch);
        for (int n = 0; n < nodes->count; n++) put_sources(by[n], share, at_node[n]);
    }
    if (good) lift_nodes(d, shown, nodes, at_node, sources);
    direct_end(d);
    if (shown != mesh) arena_free(s->of_mesh);
    good = all_good(s->borders, good) && store_nodes(s, nodes, at_node, arena, out);
    arena_free(&scratch);
    return good;
}

// Bends of light where doors stand otherwise.
static bool find_bends_of_doors(Direct *d, const Showing *show, Arena *arena) {
    const DirectSources *sources = show->sources;
    bool go_on = true;
    for (int i = 0; sources && i < sources->state_count && go_on; i++) {
        Arena scratch = {0};
        Direct other;
        RadReport work = {0};
        Mesh *mesh = sources->moving;
        Nodes nodes = *d->nodes;
        MovedDoors moved = mesh_move(mesh, show->door_open, sources->state[i], &scratch);
        if (moved.count > 0) {
            nodes.normal = ARENA_ARRAY(&scratch, Vec3, nodes.count + 1);
            memcpy(nodes.normal, d->nodes->normal, (size_t)nodes.count * sizeof *nodes.normal);
            nodes_pose(&nodes, mesh);
            direct_start(&other, mesh, show->forest, &nodes, &show->solution->day, &scratch);
            other.lamps = d->lamps;
            other.besides = d->besides;
            other.usual = d;
            other.bends = ARENA_ARRAY(&scratch, Bend *, mesh->element_count + 1);
            other.within = ARENA_ARRAY(&scratch, Within, mesh->element_count + 1);
            direct_settle(&other, &moved, &show->solution->day, show->threads);
            go_on = direct_light(&other, show->threads, show->progress, NULL, &work);
            for (int e = 0; e < mesh->element_count; e++)
                d->bends[e] = bend_join(d->bends[e], other.bends[e], arena);
            direct_end(&other);
        }
        mesh_pose(mesh, show->door_open);
        arena_free(&scratch);
    }
    return go_on;
}

// Splits of the mesh that shows the light of a part of a building, NULL: it is as fine as the mesh of the elements in all parts.
static MeshSplits *splits_of_parts(const Borders *borders, const Mesh *mesh, MeshSplits *own, Arena *arena) {
    if (!team_any(borders_member(borders), own != NULL)) return NULL;
    return borders_splits(borders, own ? own : mesh->options.splits, arena);
}

bool direct_show(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                 const Progress *progress, Arena *arena, RadSolution *solution, RadReport *report) {
    return direct_show_apart(mesh, forest, door_open, threads, progress, arena, solution, NULL, NULL, report);
}

bool direct_show_apart(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                       const Progress *progress, Arena *arena, RadSolution *solution, DirectSources *sources,
                       const Borders *borders, RadReport *report) {
    Arena scratch = {0}, of_mesh = {0}, *lasting = sources ? &sources->arena : &scratch;
    Direct d;
    Error error;
    RadReport work = {0};
    Nodes nodes = nodes_of(mesh, &of_mesh);
    bool good = true;
    if (!report) report = &work;
    direct_start(&d, mesh, forest, &nodes, &solution->day, &of_mesh);
    tell_sources_apart(&d, sources);
    double counts[4] = {d.lamp_count, direct_pairs(&d), 0, mesh->patch_count};
    for (int e = 0; e < mesh->element_count; e++) counts[2] += mesh_owns(mesh, mesh->elements[e].face);
    if (borders) {
        team_sum(borders_member(borders), counts, 4);
        settle_others(&d);
    }
    const DirectSources *lamps = sources ? sources->lamps : NULL;
    const bool exact_lamps =
        counts[0] > 0 && counts[1] <= fmax(DIRECT_MOST_PAIRS, DIRECT_PAIRS_A_PATCH * counts[3]);
    d.lamps = exact_lamps && !lamps;
    if (exact_lamps || d.sun || solution->gathered) {
        double(*sun)[3] = NULL;
        if (d.sun) {
            sun = solution->sun;
            if (!solution->gathered) sunlight_elements(mesh, &solution->day, parallel_threads(threads), sun);
        }
        RadSolution rest = other_light(mesh, solution, d.lamps, sun, false, &scratch), out = *solution;
        double(*at_node)[3] = arena_alloc(&of_mesh, (size_t)nodes.count + 1, sizeof *at_node);
        MeshSplits *splits = NULL;
        Mesh *finer = ARENA_ARRAY(lasting, Mesh, 1);
        Showing show = {.mesh = mesh,
                        .forest = forest,
                        .door_open = door_open,
                        .solution = solution,
                        .rest = &rest,
                        .lamps = exact_lamps,
                        .threads = threads,
                        .progress = progress,
                        .sources = sources,
                        .borders = borders,
                        .of_mesh = &of_mesh};
        d.besides = light_besides(mesh, &rest, solution, borders, &of_mesh);
        d.bends = ARENA_ARRAY(&of_mesh, Bend *, mesh->element_count + 1);
        d.within = ARENA_ARRAY(&of_mesh, Within, mesh->element_count + 1);
        good = all_good(borders, direct_light(&d, threads, progress, at_node, report));
        if (good) {
            double most = MOST_ADDED * counts[2] + (d.sun ? MOST_ADDED_BY_SUN : 0);
            if (sources && sources->state_count > 0) most *= DOORS_ADD;
            if (solution->gathered && mesh->options.splits)
                show.parts = reflected_parts(&(GatherScene){mesh, forest, door_open, solution, NULL}, &nodes,
                                             threads, borders, lasting);
            good = find_bends_of_doors(&d, &show, &of_mesh);
            for (int e = 0; good && lamps && e < mesh->element_count; e++)
                d.bends[e] = bend_join(d.bends[e], lamps->bends[e], &of_mesh);
            for (int e = 0; good && sources && sources->bends && e < mesh->element_count; e++)
                sources->bends[e] = bend_join(NULL, d.bends[e], &sources->arena);
            splits = good ? bend_splits(mesh, d.bends, show.parts.halved, most, borders, arena) : NULL;
            if (borders) splits = splits_of_parts(borders, mesh, splits, arena);
        }
        if (solution->gathered) rest = other_light(mesh, solution, exact_lamps, sun, true, &scratch);
        bool is_finer = good && splits && shown_build(mesh, splits, door_open, lasting, finer, &error);
        good = good && (!borders || is_finer == (splits != NULL));
        out.shown = is_finer ? splits : NULL;
        show.shown = is_finer ? finer : mesh;
        good = light_nodes(&d, &show, good, at_node, arena, &out, report);
        if (good) *solution = out;
        if (good && sources) {
            sources->shown = show.shown;
            sources->weather = solution->day;
            sources->finer = is_finer ? finer : NULL;
            sources->show = show;
            sources->nodes = nodes_of(show.shown, lasting);
        }
        direct_end(&d);  // if they have not ended
    }
    arena_free(&of_mesh);
    arena_free(&scratch);
    return good;
}

bool direct_show_lamps(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                       const Progress *progress, const RadSolution *solution, DirectSources *sources) {
    RadSolution dark = *solution;
    dark.day = (Daylight){0};
    dark.gathered = false;
    sources->bends = arena_alloc(&sources->arena, (size_t)mesh->element_count + 1, sizeof *sources->bends);
    if (!direct_show_apart(mesh, forest, door_open, threads, progress, &sources->arena, &dark, sources, NULL,
                           NULL))
        return false;
    if (sources->shown) sources->triangle = reconstruct_triangles(sources->shown, &sources->arena);
    return true;
}

// All light of a state of the sources. `last` gets it, if not NULL.
static bool show_state(DirectSources *s, double (*share)[3], const Mesh *lit, const Progress *progress,
                       ShownLast *last, Arena *arena, RadSolution *solution) {
    Arena scratch = {0};
    RadSolution rest = other_light(lit, solution, s->show.lamps, solution->sun, true, &scratch),
                out = *solution;
    double(*at_node)[3] =
        last ? last->straight : arena_alloc(&scratch, (size_t)s->nodes.count + 1, sizeof *at_node);
    Showing show = s->show;
    show.mesh = lit;
    if (s->shown == s->show.mesh) show.shown = lit;
    show.solution = solution;
    show.rest = &rest;
    show.progress = progress;
    show.reflected = last ? last->reflected : NULL;
    sources_at_nodes(s, share, last ? last->unlifted : at_node, at_node);
    bool good = store_nodes(&show, &s->nodes, at_node, arena, &out);
    if (good) *solution = out;
    arena_free(&scratch);
    return good;
}

bool direct_show_source(DirectSources *s, double (*share)[3], const Mesh *lit, const Progress *progress,
                        Arena *arena, RadSolution *solution) {
    if (s->last) s->last->there = false;
    return show_state(s, share, lit, progress, NULL, arena, solution);
}

// ---- one light after another

static ShownLast *last_of(DirectSources *s) {
    if (s->last) return s->last;
    ShownLast *last = ARENA_ARRAY(&s->arena, ShownLast, 1);
    double(**all[])[3] = {&last->unlifted, &last->straight, &last->reflected, &last->rest, &last->all};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        *all[i] = arena_alloc(&s->arena, (size_t)s->nodes.count + 1, sizeof **all[i]);
    last->share = arena_alloc(&s->arena, (size_t)s->day + 1, sizeof *last->share);
    last->moved = marks_new(s->nodes.count, &s->arena);
    last->lifted = marks_new(s->nodes.count, &s->arena);
    last->found = marks_new(s->nodes.count, &s->arena);
    last->lifts = marks_new(s->shown->element_count, &s->arena);
    return s->last = last;
}

// Straight light at the nodes whose sources were found anew, and at those that elements about them lift.
static void straight_again(const DirectSources *s, double (*share)[3]) {
    ShownLast *last = s->last;
    const Nodes *nodes = &s->nodes;
    marks_clear(&last->lifts);
    for (int i = 0; i < last->moved.count; i++) {
        int n = last->moved.of[i];
        put_sources(s->node[n], share, last->unlifted[n]);
        for (int k = nodes->first[n]; k < nodes->first[n + 1]; k++)
            marks_add(&last->lifts, nodes->element[k]);
    }
    for (int i = 0; i < last->lifts.count; i++) {
        const Element *e = &s->shown->elements[last->lifts.of[i]];
        for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
            marks_add(&last->lifted, nodes->of_corner[c]);
    }
    for (int i = 0; i < last->lifted.count && last->moved.count > 0; i++) {
        int n = last->lifted.of[i], count = nodes->first[n + 1] - nodes->first[n];
        double sum[3] = {0, 0, 0}, off[3];
        for (int k = nodes->first[n]; k < nodes->first[n + 1]; k++) {
            lift_of(s, share, last->unlifted, nodes->element[k], off);
            for (int c = 0; c < 3; c++) sum[c] += LIFT * off[c];
        }
        for (int c = 0; c < 3; c++) last->straight[n][c] = fmax(last->unlifted[n][c] + sum[c] / count, 0);
    }
    marks_clear(&last->moved);
}

static bool same_shares(const DirectSources *s, double (*share)[3]) {
    return memcmp(share, s->last->share, ((size_t)s->day + 1) * sizeof *share) == 0;
}

// May what is shown go on from the light before?
static bool goes_on(const DirectSources *s, double (*share)[3]) {
    return s->last && s->last->there && same_shares(s, share) && s->show.lamps && s->finer &&
           reflected_goes_on(&s->parts);
}

static bool show_again(DirectSources *s, double (*share)[3], const Mesh *lit, const Marks *changed,
                       const Progress *progress, RadSolution *solution) {
    ShownLast *last = s->last;
    Showing show = s->show;
    GatherScene scene = {lit, show.forest, show.door_open, solution, NULL};
    marks_clear(&last->found);
    straight_again(s, share);
    if (!reflected_again(&scene, s->shown, &s->nodes, changed, &s->parts, progress, last->reflected,
                         &last->found))
        return false;
    for (int i = 0; i < last->lifted.count; i++) marks_add(&last->found, last->lifted.of[i]);
    show.mesh = lit;
    for (int i = 0; i < last->found.count; i++) {
        int n = last->found.of[i];
        add_up(&show, &s->nodes, n, true, last->reflected[n], last->straight[n], last->rest[n], last->all[n]);
    }
    return true;
}

// Copies the light at nodes.
static double (*copy_nodes(const DirectSources *s, double (*from)[3], Arena *arena))[3] {
    double(*out)[3] = arena_alloc(arena, (size_t)s->nodes.count + 1, sizeof *out);
    memcpy(out, from, (size_t)s->nodes.count * sizeof *out);
    return out;
}

bool direct_show_next(DirectSources *s, double (*share)[3], const Mesh *lit, const Marks *changed,
                      const Progress *progress, Arena *arena, RadSolution *solution) {
    bool again = changed && goes_on(s, share);
    ShownLast *last = last_of(s);
    last->there = false;
    if (again) {
        if (!show_again(s, share, lit, changed, progress, solution)) return false;
        solution->node_count = s->nodes.count;
        solution->node = copy_nodes(s, last->all, arena);
        solution->rest = copy_nodes(s, last->rest, arena);
    } else {
        if (!show_state(s, share, lit, progress, last, arena, solution)) return false;
        memcpy(last->all, solution->node, (size_t)s->nodes.count * sizeof *last->all);
        memcpy(last->rest, solution->rest, (size_t)s->nodes.count * sizeof *last->rest);
        memcpy(last->share, share, ((size_t)s->day + 1) * sizeof *share);
    }
    marks_clear(&last->moved);
    marks_clear(&last->lifted);
    last->there = true;
    return true;
}

void direct_show_straight(DirectSources *s, double (*share)[3], const RadSolution *before, bool is_last,
                          Arena *arena, RadSolution *out) {
    Arena scratch = {0};
    ShownLast *last = s->last;
    bool again = is_last && goes_on(s, share);
    double(*straight)[3];
    *out = *before;
    if (again) {
        straight_again(s, share);
        straight = last->straight;
        out->node = copy_nodes(s, last->all, arena);
    } else {
        straight = arena_alloc(&scratch, (size_t)s->nodes.count + 1, sizeof *straight);
        out->node = arena_alloc(arena, (size_t)s->nodes.count + 1, sizeof *out->node);
        sources_at_nodes(s, share, straight, straight);
    }
    for (int i = 0; i < (again ? last->lifted.count : s->nodes.count); i++) {
        int n = again ? last->lifted.of[i] : i;
        double rho[3];
        int face = s->shown->elements[s->nodes.element[s->nodes.first[n]]].face;
        rgb_doubles(mesh_material(s->shown, face)->reflectance, rho);
        for (int c = 0; c < 3; c++) out->node[n][c] = before->rest[n][c] + rho[c] * straight[n][c];
    }
    arena_free(&scratch);
}

// ---- doors

// Sources of points whose light was found anew are forgotten; their memory is given back once it is most of all.
static void tidy(DirectSources *s) {
    size_t used = 0;
    for (int t = 0; t < s->threads; t++) used += s->kept[t].used;
    if (s->used == 0) s->used = used;
    if (used <= 2 * s->used) return;
    Arena kept = {0};
    const PointSources **all[] = {s->corner, s->node, s->middle};
    const int count[] = {s->shown->corner_count, s->nodes.count, s->shown->element_count};
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < count[k]; i++) {
            PointSources *from = (PointSources *)all[k][i], *to;
            if (!from) continue;
            // Sources that were moved tell where to.
            if (from->count < 0) {
                memcpy(&to, from->by, sizeof to);
            } else {
                size_t bytes = sizeof *from + (size_t)from->count * sizeof *from->by;
                to = arena_alloc(&kept, bytes, 1);
                memcpy(to, from, bytes);
                from->count = -1;
                memcpy(from->by, &to, sizeof to);
            }
            all[k][i] = to;
        }
    }
    for (int t = 0; t < s->threads; t++) arena_free(&s->kept[t]);
    s->kept[0] = kept;
    s->used = kept.used;
}

// Elements of patches that are not settled are lifted by their new middles, where they may be lifted at all.
static void lift_anew(DirectSources *s, const Direct *d) {
    Arena scratch = {0};
    double(*share)[3] = full_shares(s, &scratch),
    (*at_node)[3] = arena_alloc(&scratch, (size_t)s->nodes.count + 1, sizeof *at_node);
    for (int e = 0; e < s->shown->element_count; e++) {
        const Element *element = &s->shown->elements[e];
        double middle[3], off[3];
        if (d->settled[element->patch]) continue;
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            int n = s->nodes.of_corner[c];
            put_sources(s->node[n], share, at_node[n]);
        }
        put_sources(s->middle[e], share, middle);
        s->lifts[e] = s->middle_known[e] &&
                      find_lift(s->shown, &s->nodes, at_node, e, middle, (double)s->besides[e], off);
    }
    arena_free(&scratch);
}

const Mesh *direct_sources_shown(const DirectSources *s) { return s->shown; }

const Nodes *direct_sources_nodes(const DirectSources *s) { return &s->nodes; }

// Where no lamp is before a patch any more, nothing is found anew: what was there goes.
static void forget_touched(Direct *d) {
    for (int e = 0; e < d->mesh->element_count; e++) {
        const Element *element = &d->mesh->elements[e];
        if (d->settled[element->patch]) continue;
        direct_forget(d, element->patch, &d->middle_by[e]);
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++)
            direct_forget(d, element->patch, &d->corner_by[c]);
    }
}

// Straight light at the nodes of patches that are not settled has changed.
static void note_moved(const DirectSources *s, const Direct *d) {
    for (int e = 0; e < s->shown->element_count; e++) {
        const Element *element = &s->shown->elements[e];
        if (d->settled[element->patch]) continue;
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++)
            marks_add(&s->last->moved, s->nodes.of_corner[c]);
    }
}

long long direct_sources_move(DirectSources *s, const MovedDoors *moved, const float *to) {
    Arena scratch = {0};
    Direct d;
    RadReport report = {0};
    if (s->finer) mesh_pose(s->finer, to);
    part_rows_move(&s->parts, s->shown, moved);
    nodes_pose(&s->nodes, s->shown);
    direct_start(&d, s->shown, s->show.forest, &s->nodes, &s->weather, &scratch);
    d.lamps = s->show.lamps;
    tell_sources_apart(&d, s);
    direct_settle(&d, moved, &s->weather, s->threads);
    d.corner_by = s->corner;
    d.towards = s->way;
    d.rough = s->finer ? s->show.mesh : NULL;
    d.middle_by = s->middle;
    forget_touched(&d);
    d.middle_wanted = s->middle_known;
    direct_light(&d, s->threads, NULL, NULL, &report);
    direct_node_sources(&d, true, s->node);
    if (s->last) note_moved(s, &d);
    lift_anew(s, &d);
    direct_end(&d);
    arena_free(&scratch);
    tidy(s);
    return report.direct_points;
}
