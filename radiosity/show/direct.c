// direct.c - light as it is shown: straight from lamps and the sun at the nodes of a mesh that is finer where this light bends, and all
// other light as elements and rows tell it.
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/direct_points.h"
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
                             Arena *arena) {
    double *out = ARENA_ARRAY(arena, double, mesh->element_count + 1), power = 0, area = 0;
    RadSolution even_rest = reconstruct_even(mesh, rest, arena), even = reconstruct_even(mesh, whole, arena);
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        out[e] = fmax(rgb_sum(even_rest.radiosity[e]) - rgb_sum(emitted), 0);
        power += mesh->elements[e].area * (out[e] + rgb_sum(even.direct[e]));
        area += mesh->elements[e].area;
    }
    for (int e = 0; e < mesh->element_count; e++) out[e] += DARK * power / area;
    return out;
}

// Takes over the light of points that is known within elements of the coarser mesh. `by`: what sources give at its nodes, or NULL.
static void take_known(Direct *d, const Direct *coarser, double (*at_node)[3], const PointSources **by) {
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
            if (!direct_corner_counts(d, e, c, &towards)) continue;
            for (int i = around->first_corner; i < around->first_corner + around->corner_count; i++) {
                if (vec3_length(vec3_sub(at, rough->vertices[rough->corners[i]])) > DIRECT_SAME_PLACE)
                    continue;
                memcpy(d->at_corner[c], at_node[coarser->nodes->of_corner[i]], sizeof *at_node);
                if (by) d->corner_by[c] = by[coarser->nodes->of_corner[i]];
                d->known[c] = true;
                break;
            }
            const BendPoint *point =
                d->known[c] ? NULL
                            : direct_find_point(coarser->within[in].points, coarser->within[in].count, at);
            if (point) {
                memcpy(d->at_corner[c], point->irradiance, sizeof point->irradiance);
                if (by) d->corner_by[c] = coarser->within[in].by[point - coarser->within[in].points];
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

// Light that is shown: the solution on `mesh`, its light but that straight from lamps and sun, and reflected light where that is gathered
// (rest.gathered); the mesh that shows it, and how often that halves elements for reflected light.
typedef struct Showing {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    const RadSolution *solution, *rest;
    const Mesh *shown;
    const MeshDepth *halved;
    bool lamps;  // their light is known at the nodes
    int threads;
    const Progress *progress;
    DirectSources *sources;  // or NULL
} Showing;

// The light that each source gives straight to what is shown, as one pass over the lamps of all has found it; and all that the light of
// one source needs to be shown likewise.
struct DirectSources {
    Arena arena;
    Arena *kept;  // [threads] of PointSources
    const int *source_of;
    int day, threads;
    Showing show;       // of all light
    const Mesh *shown;  // the mesh that shows it
    Nodes nodes;        // of that
    PartRows parts;
    const PointSources **node;    // [nodes.count]
    const PointSources **middle;  // [elements that show the light]
    bool *lifts;                  // [elements that show the light] its nodes are lifted
};

DirectSources *direct_sources_new(const int *source_of, int day, int threads, Arena *arena) {
    DirectSources *out = ARENA_ARRAY(arena, DirectSources, 1);
    out->threads = parallel_threads(threads);
    out->source_of = source_of;
    out->day = day;
    out->kept = ARENA_ARRAY(arena, Arena, out->threads);
    out->parts.thread_count = out->threads;
    return out;
}

void direct_sources_end(DirectSources *sources) {
    for (int t = 0; t < sources->threads; t++) arena_free(&sources->kept[t]);
    part_rows_end(&sources->parts);
    arena_free(&sources->arena);
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

// Lifts nodes so that light between them is right in the mean. `d` knows the light within the elements of its mesh, in which those
// of `shown` lie. Tells `sources`, or NULL, where it does.
static void lift_nodes(const Direct *d, const Mesh *shown, const Nodes *nodes, double (*at_node)[3],
                       DirectSources *sources) {
    Arena scratch = {0};
    Lift lift = lift_new(nodes, &scratch);
    for (int e = 0; e < shown->element_count; e++) {
        int in = shown == d->mesh ? e : shown_around(d->mesh, shown, e);
        const Within *within = &d->within[in];
        const double *middle = within->middle;
        const PointSources *by = within->middle_by;
        double linear[3], rho[3], off[3] = {0, 0, 0}, light = d->besides[in], gap = 0;
        if (within->points) {
            const BendPoint *at =
                direct_find_point(within->points, within->count, element_centroid(shown, e));
            middle = at ? at->irradiance : NULL;
            by = at && within->by ? within->by[at - within->points] : NULL;
        }
        if (middle && within->middle_known) {
            linear_mean(shown, nodes, at_node, e, linear);
            rgb_doubles(mesh_material(shown, shown->elements[e].face)->reflectance, rho);
            for (int c = 0; c < 3; c++) {
                off[c] = middle[c] - linear[c];
                light += rho[c] * middle[c];
                gap += rho[c] * off[c];
            }
            bool lifts = fabs(gap) <= MOST_LIFT * light;
            if (!lifts) off[0] = off[1] = off[2] = 0;
            if (sources) sources->lifts[e] = lifts;
            if (sources) sources->middle[e] = by;
        }
        lift_element(&lift, shown, nodes, e, off);
    }
    lift_all(&lift, nodes, at_node);
    arena_free(&scratch);
}

static void put_source(const PointSources *by, int source, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; by && i < by->count; i++)
        for (int c = 0; c < 3 && by->by[i].source == source; c++) out[c] = (double)by->by[i].light[c];
}

// The irradiance of one source at the nodes.
static void source_at_nodes(const DirectSources *s, const Mesh *shown, int source, double (*out)[3]) {
    Arena scratch = {0};
    Lift lift = lift_new(&s->nodes, &scratch);
    for (int n = 0; n < s->nodes.count; n++) put_source(s->node[n], source, out[n]);
    for (int e = 0; e < shown->element_count; e++) {
        double middle[3], linear[3], off[3] = {0, 0, 0};
        if (s->lifts[e]) {
            put_source(s->middle[e], source, middle);
            linear_mean(shown, &s->nodes, out, e, linear);
            for (int c = 0; c < 3; c++) off[c] = middle[c] - linear[c];
        }
        lift_element(&lift, shown, &s->nodes, e, off);
    }
    lift_all(&lift, &s->nodes, out);
    arena_free(&scratch);
}

// Adds up all light at the nodes of the mesh that shows it, to the light straight from lamps and sun there.
static bool store_nodes(const Showing *s, const Nodes *nodes, double (*at_node)[3], Arena *arena,
                        RadSolution *out) {
    Arena scratch = {0};
    const Mesh *mesh = s->mesh, *shown = s->shown;
    double(*reflected)[3] = arena_alloc(&scratch, (size_t)nodes->count + 1, sizeof *reflected);
    bool good = true;
    if (s->rest->gathered) {
        GatherScene scene = {mesh, s->forest, s->door_open, s->solution, NULL};
        good = reflected_nodes(&scene, s->halved, shown, nodes, s->threads,
                               s->sources ? &s->sources->parts : NULL, s->progress, reflected);
    }
    if (good) {
        out->node_count = nodes->count;
        out->node = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out->node);
        // All other light is emitted, and even.
        bool dark = s->rest->gathered && s->lamps;
        out->rest = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *out->rest);
        if (!dark) shown_nodes(mesh, s->rest, shown, nodes, out->rest);
        for (int n = 0; n < nodes->count; n++) {
            double rho[3];
            const Material *m = mesh_material(mesh, shown->elements[nodes->element[nodes->first[n]]].face);
            rgb_doubles(m->reflectance, rho);
            if (dark) rgb_doubles(m->emission, out->rest[n]);
            for (int c = 0; c < 3; c++) {
                out->rest[n][c] += rho[c] * reflected[n][c];
                out->node[n][c] = out->rest[n][c] + rho[c] * at_node[n][c];
            }
        }
    }
    arena_free(&scratch);
    return good;
}

// Stores the light at the nodes of the mesh that shows it. Direct light is known at the nodes of d->mesh; d's workers end.
static bool light_nodes(Direct *d, const Showing *s, double (*at_node)[3], Arena *arena, RadSolution *out,
                        RadReport *report) {
    Arena scratch = {0};
    DirectSources *sources = s->sources;
    const Mesh *mesh = d->mesh, *shown = s->shown;
    Nodes finer_nodes;
    const Nodes *nodes = d->nodes;
    const PointSources **by = NULL;
    bool good = true;
    if (sources) {
        by = arena_alloc(&sources->arena, (size_t)nodes->count + 1, sizeof *by);
        direct_node_sources(d, by);
    }
    if (shown != mesh) {
        Arena own = {0};
        Direct finer;
        finer_nodes = nodes_of(shown, &scratch);
        double(*irradiance)[3] = arena_alloc(&scratch, (size_t)finer_nodes.count + 1, sizeof *irradiance);
        direct_start(&finer, shown, s->forest, &finer_nodes, &s->rest->day, &own);
        finer.lamps = d->lamps;
        tell_sources_apart(&finer, sources);
        take_known(&finer, d, at_node, by);
        good = direct_light(&finer, s->threads, s->progress, irradiance, report);
        if (good && sources) {
            by = arena_alloc(&sources->arena, (size_t)finer_nodes.count + 1, sizeof *by);
            direct_node_sources(&finer, by);
        }
        direct_end(&finer);
        arena_free(&own);
        at_node = irradiance;
        nodes = &finer_nodes;
    }
    if (sources) {
        sources->node = by;
        sources->lifts = ARENA_ARRAY(&sources->arena, bool, shown->element_count + 1);
        sources->middle = arena_alloc(&sources->arena, (size_t)shown->element_count + 1, sizeof *by);
    }
    if (good) lift_nodes(d, shown, nodes, at_node, sources);
    direct_end(d);
    good = good && store_nodes(s, nodes, at_node, arena, out);
    arena_free(&scratch);
    return good;
}

bool direct_show(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                 const Progress *progress, Arena *arena, RadSolution *solution, RadReport *report) {
    return direct_show_apart(mesh, forest, door_open, threads, progress, arena, solution, NULL, report);
}

bool direct_show_apart(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                       const Progress *progress, Arena *arena, RadSolution *solution, DirectSources *sources,
                       RadReport *report) {
    Arena scratch = {0}, *lasting = sources ? &sources->arena : &scratch;
    Direct d;
    Error error;
    RadReport work = {0};
    Nodes nodes = nodes_of(mesh, &scratch);
    bool good = true;
    if (!report) report = &work;
    direct_start(&d, mesh, forest, &nodes, &solution->day, &scratch);
    tell_sources_apart(&d, sources);
    d.lamps = d.lamp_count > 0 && direct_pairs(&d) <= DIRECT_MOST_PAIRS;
    if (d.lamps || d.sun || solution->gathered) {
        double(*sun)[3] = NULL;
        if (d.sun) {
            sun = solution->sun;
            if (!solution->gathered) sunlight_elements(mesh, &solution->day, parallel_threads(threads), sun);
        }
        RadSolution rest = other_light(mesh, solution, d.lamps, sun, false, &scratch), out = *solution;
        double(*at_node)[3] = arena_alloc(&scratch, (size_t)nodes.count + 1, sizeof *at_node);
        MeshSplits *splits = NULL;
        Mesh *finer = ARENA_ARRAY(lasting, Mesh, 1);
        Showing show = {.mesh = mesh,
                        .forest = forest,
                        .door_open = door_open,
                        .solution = solution,
                        .rest = &rest,
                        .lamps = d.lamps,
                        .threads = threads,
                        .progress = progress,
                        .sources = sources};
        d.besides = light_besides(mesh, &rest, solution, &scratch);
        d.bends = ARENA_ARRAY(&scratch, Bend *, mesh->element_count + 1);
        d.within = ARENA_ARRAY(&scratch, Within, mesh->element_count + 1);
        good = direct_light(&d, threads, progress, at_node, report);
        if (good) {
            double most = MOST_ADDED * mesh->element_count + (d.sun ? MOST_ADDED_BY_SUN : 0);
            if (solution->gathered && mesh->options.splits)
                show.halved = reflected_depths(mesh, &nodes, solution, lasting);
            splits = bend_splits(mesh, d.bends, show.halved, most, arena);
        }
        if (solution->gathered) rest = other_light(mesh, solution, d.lamps, sun, true, &scratch);
        bool is_finer = good && splits && shown_build(mesh, splits, door_open, lasting, finer, &error);
        out.shown = is_finer ? splits : NULL;
        show.shown = is_finer ? finer : mesh;
        good = good && light_nodes(&d, &show, at_node, arena, &out, report);
        if (good) *solution = out;
        if (good && sources) {
            sources->shown = show.shown;
            sources->show = show;
            sources->nodes = nodes_of(show.shown, lasting);
        }
        direct_end(&d);  // if they have not ended
    }
    arena_free(&scratch);
    return good;
}

bool direct_show_source(DirectSources *s, int source, const Mesh *lit, const Progress *progress, Arena *arena,
                        RadSolution *solution) {
    Arena scratch = {0};
    RadSolution rest = other_light(lit, solution, s->show.lamps, solution->sun, true, &scratch),
                out = *solution;
    double(*at_node)[3] = arena_alloc(&scratch, (size_t)s->nodes.count + 1, sizeof *at_node);
    Showing show = s->show;
    show.mesh = lit;
    if (s->shown == s->show.mesh) show.shown = lit;
    show.solution = solution;
    show.rest = &rest;
    show.progress = progress;
    source_at_nodes(s, s->shown, source, at_node);
    bool good = store_nodes(&show, &s->nodes, at_node, arena, &out);
    if (good) *solution = out;
    arena_free(&scratch);
    return good;
}
