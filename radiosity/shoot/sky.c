// sky.c - daylight in a building. Outdoors each element looks for the sky above it. Indoors no element does: what
// comes through the openings is shot from there (as from a window's panes: Nishita & Nakamae 1986, Continuous Tone Representation
// of Three-Dimensional Objects Illuminated by Sky Light, have it the other way round). A piece of an opening sees, along each
// direction of the hemisphere inside, a face; and behind itself, along the same line, the sky, the ground or something else. The line
// carries the radiance of the sky there, less what panes of glass on it keep (panes.h). The sun lights elements by sunlight.c.
//
// So each line from the sky to an element indoors is counted where it comes in for the last time: one that leaves again through
// another opening ends there. Elements outdoors, or in no cell, look for themselves.
#include "radiosity/shoot/sky_looks.h"

#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "engine/core/polygon.h"
#include "radiosity/shoot/sunlight.h"

// Openings of more corners are not taken.
enum { SKY_CORNERS = 64 };

// ---- portals of which one side alone is outdoors, in pieces of equal area: each is seen from, and sees, as from its middle.

// Side of a piece aimed at, metres: small to the distance of objects near a window; and how many pieces there are before
// they become larger.
static const double PIECE = 0.2;
static const double MOST_PIECES = 50000;
// The fewest pieces of an opening: those of small ones are nearer to the jambs than to anything else.
enum { FEWEST_PIECES = 8 };
static const double GOLDEN = 0.6180339887498949;

static bool sky_is_outdoors(const CellGraph *graph, int cell) {
    return vis_region(graph, cell)->kind == REGION_OUTDOORS;
}

// Middles lie in the rectangle about the opening's longest edge: each at a height of its own, and farther to the side than the one below by
// the golden section of the width, modulo the width. So heights and distances from the jambs are both spread evenly (Kronecker's sequence).
// Light that depends on one of them alone is right then: where the jambs of a slit hide more from its sides than from its middle, or a
// parapet covers an opening to some height.
static void cut_opening(SkyOpenings *out, int opening, double size, Arena *arena, int *capacity) {
    const SkyOpening *o = &out->openings[opening];
    const Vec3 *v = o->vertices;
    Vec3 along = {0, 0, 0}, sum = {0, 0, 0};
    Vec2 ring[SKY_CORNERS];
    Box box = box_empty();
    CORE_ASSERT(o->count <= SKY_CORNERS);
    double area = polygon_area(v, o->count);
    if (area < MAPS_SMALLEST_AREA) return;
    for (int i = 0; i < o->count; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % o->count], v[i]);
        if (vec3_dot(edge, edge) > vec3_dot(along, along)) along = edge;
    }
    Vec3 y = vec3_normalize(along), x = vec3_cross(y, o->plane.n);
    if (fabs(x.z) > fabs(y.z)) y = x, x = vec3_cross(y, o->plane.n);
    // About a corner, so that far from the origin no digits are lost.
    for (int i = 0; i < o->count; i++) {
        Vec3 off = vec3_sub(v[i], v[0]);
        ring[i] = (Vec2){vec3_dot(x, off), vec3_dot(y, off)};
        box = box_add(box, vec3(ring[i].x, ring[i].y, 0));
        sum = vec3_add(sum, off);
    }
    double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
    // One more each way than fit.
    int most = (int)fmax(ceil((width / size + 1) * (height / size + 1)), FEWEST_PIECES);
    int first = out->piece_count;
    for (int i = 0; i < most; i++) {
        double share = 0.5 + (i - (most - 1) / 2.0) * GOLDEN;
        Vec2 at = {box.min.x + width * (share - floor(share)), box.min.y + height * (i + 0.5) / most};
        if (!ring_contains(ring, o->count, at)) continue;
        Vec3 off = vec3_add(vec3_scale(x, at.x), vec3_scale(y, at.y));
        *ARENA_PUSH(arena, out->pieces, out->piece_count, *capacity) =
            (SkyPiece){.opening = opening, .centre = vec3_add(v[0], off)};
    }
    // All may miss a sliver.
    if (out->piece_count == first)
        *ARENA_PUSH(arena, out->pieces, out->piece_count, *capacity) =
            (SkyPiece){.opening = opening, .centre = vec3_add(v[0], vec3_scale(sum, 1.0 / o->count))};
    for (int i = first; i < out->piece_count; i++) out->pieces[i].area = area / (out->piece_count - first);
    out->openings[opening].first_piece = first;
    out->openings[opening].piece_count = out->piece_count - first;
}

// All openings; of pieces those whose light this part of the building sends in.
static SkyOpenings sky_openings(const Mesh *mesh, Arena *arena) {
    const CellGraph *graph = mesh->graph;
    const MeshPart *part = mesh->options.part;
    SkyOpenings out = {.openings = ARENA_ARRAY(arena, SkyOpening, graph->portal_count + 1)};
    double area = 0;
    int capacity = 0;
    for (int p = 0; p < graph->portal_count; p++) {
        const Portal *portal = &graph->portals[p];
        bool first = sky_is_outdoors(graph, portal->cell[0]),
             second = sky_is_outdoors(graph, portal->cell[1]);
        if (first == second) continue;
        Plane plane = portal->plane;  // towards cell[0]
        if (first) plane = (Plane){vec3_scale(plane.n, -1), -plane.d};
        const Vec3 *vertices = graph->portal_vertices + portal->first_vertex;
        area += polygon_area(vertices, portal->vertex_count);
        out.openings[out.count++] = (SkyOpening){.inside = portal->cell[first],
                                                 .outside = portal->cell[!first],
                                                 .plane = plane,
                                                 .vertices = vertices,
                                                 .count = portal->vertex_count};
    }
    double size = fmax(PIECE, sqrt(area / MOST_PIECES));
    for (int o = 0; o < out.count; o++)
        if (!part || part->cell_owner[out.openings[o].inside] == part->own)
            cut_opening(&out, o, size, arena, &capacity);
    return out;
}

// ---- where light that came in by one opening leaves by another: from there on it is that of whatever opening it comes
// in by next.

// Openings nearer than this to a piece's middle are its own plane, metres.
static const double ON_PLANE = 1e-6;

// An opening from a piece's middle, in the view's axes.
typedef struct Exit {
    Plane plane;        // n to the middle's side
    const Plane *edge;  // [count] inside of all
    int count;
} Exit;

static bool make_exit(const View *view, const SkyOpening *o, Plane *edge, Exit *out) {
    double off = vec3_dot(o->plane.n, vec3_sub(view->eye, o->vertices[0]));
    if (off < ON_PLANE) return false;  // it leads in, from here
    Vec3 last = {0, 0, 0}, sum = {0, 0, 0};
    bool above = false;
    for (int i = 0; i <= o->count; i++) {
        Vec3 v = vec3_sub(o->vertices[i % o->count], view->eye);
        Vec3 p = {vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v)};
        if (i > 0) edge[i - 1].n = vec3_cross(last, p);
        if (i < o->count) sum = vec3_add(sum, p);
        above = above || p.z > 0;
        last = p;
    }
    for (int i = 0; i < o->count; i++)
        if (vec3_dot(edge[i].n, sum) < 0) edge[i].n = vec3_scale(edge[i].n, -1);
    Vec3 n = o->plane.n;
    n = vec3(vec3_dot(view->x, n), vec3_dot(view->y, n), vec3_dot(view->z, n));
    *out = (Exit){{n, -off}, edge, o->count};
    return above;
}

static bool leaves_by(const Exit *exit, Vec3 w, double distance) {
    double slope = vec3_dot(exit->plane.n, w);
    // Met at exit->plane.d / slope; both are below 0.
    if (slope >= 0 || exit->plane.d < slope * (distance - ON_PLANE)) return false;
    for (int i = 0; i < exit->count; i++)
        if (vec3_dot(exit->edge[i].n, w) < 0) return false;
    return true;
}

// Forgets (-1) faces behind another opening among those that samples see from the middle of a piece of an opening, inwards.
static void sky_end_at_exits(const SkyOpenings *openings, const StabForest *forest, int opening,
                             const View *view, const FormFactorSamples *samples, int32_t *item) {
    const SkyOpening *own = &openings->openings[opening];
    for (int k = 0; k < openings->count; k++) {
        const SkyOpening *o = &openings->openings[k];
        Plane edge[SKY_CORNERS];
        Exit exit;
        if (k == opening || !vis_sees(forest, own->inside, o->inside) || !make_exit(view, o, edge, &exit))
            continue;
        for (int i = 0; i < samples->count; i++) {
            if (item[i] < 0) continue;
            const ViewFace *f = &view->faces[item[i]];
            Vec3 along = {(double)samples->x[i], (double)samples->y[i], (double)samples->z[i]};
            if (leaves_by(&exit, along, f->d / vec3_dot(f->n, along))) item[i] = -1;
        }
    }
}

// Pixels across the base of the hemisphere of an element outdoors: most of its view is sky.
enum { RESOLUTION_OUTDOORS = 48 };
// A patch that has lost less than this of the sky is not cut up.
static const double STANDS_FREE = 0.1;
// How far in front of its face an element is looked for among the cells, metres, as a patch is (mesh.c).
static const double IN_FRONT = 1e-6;

// Samples are this much higher than panes where they pass above, as the z of unit vectors: more than the rounding of floats.
static const double ABOVE_PANES = 1e-5;

// ---- tools

static int pixel_of(const FormFactorSamples *s, int i, double turn, int resolution, bool flipped) {
    double x = (double)s->x[i] * cos(turn) + (double)s->y[i] * sin(turn);
    double y = (double)s->y[i] * cos(turn) - (double)s->x[i] * sin(turn);
    int column = (int)((x + 1) * resolution / 2), row = (int)((y + 1) * resolution / 2);
    return (flipped ? resolution - 1 - row : row) * resolution + column;
}

// Along the opposite of (x, y, z) in the axes of n lies (x, -y, z) in those of -n (view_axes).
static int *mirror_of(const Watcher *w, int resolution, Arena *arena) {
    Arena scratch = {0};
    const FormFactorSamples *in = sampler_samples(w->inside), *out = sampler_samples(w->outside);
    int *at = ARENA_ARRAY(&scratch, int, resolution *resolution),
        *mirror = ARENA_ARRAY(arena, int, in->count);
    for (int i = 0; i < resolution * resolution; i++) at[i] = -1;
    for (int i = 0; i < out->count; i++) at[pixel_of(out, i, -GRIDS_TURN, resolution, true)] = i;
    for (int i = 0; i < in->count; i++) mirror[i] = at[pixel_of(in, i, GRIDS_TURN, resolution, false)];
    arena_free(&scratch);
    return mirror;
}

static void make_watcher(const Shine *s, const float *door_open, Watcher *w) {
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_disc(s->options->form_factor.resolution, grids);
    w->viewer = viewer_new(s->mesh, s->forest, door_open, &w->arena);
    w->inside = sampler_new(s->mesh, &s->lines, grids, count, GRIDS_TURN, &w->arena);
    w->outside = sampler_new(s->mesh, &s->lines, grids, count, -GRIDS_TURN, &w->arena);
    count = grids_of_disc(RESOLUTION_OUTDOORS, grids);
    w->around = sampler_new(s->mesh, &s->lines, grids, count, GRIDS_TURN, &w->arena);
    int most = sampler_samples(w->inside)->count + sampler_samples(w->outside)->count +
               sampler_samples(w->around)->count;
    w->item = ARENA_ARRAY(&w->arena, int32_t, most);
    w->origin = ARENA_ARRAY(&w->arena, unsigned char, most);
    w->lit = ARENA_ARRAY(&w->arena, int32_t, most);
    w->weight = ARENA_ARRAY(&w->arena, float, most);
    w->behind.relative = ARENA_ARRAY(&w->arena, double, most);
    w->above.relative = ARENA_ARRAY(&w->arena, double, most);
    row_start(&w->sum, s->mesh, &w->arena);
    if (s->keep) {
        w->collector = sky_collector_new(&w->arena);
        w->part = ARENA_ARRAY(&w->arena, SkyPart, SKY_PARTS_MOST);
        w->met = ARENA_ARRAY(&w->arena, int, most);
        w->rays = ARENA_ARRAY(&w->arena, Ray, most);
        w->doors = ARENA_ARRAY(&w->arena, uint64_t, viewer_door_words(s->mesh) + 1);
    }
    for (int i = 0; i < 2; i++) w->panes[i].panes = ARENA_ARRAY(&w->arena, Pane, s->mesh->panes.count + 1);
}

// A sample's direction in building space.
static Vec3 along_sample(const View *view, const FormFactorSamples *samples, int i) {
    double x = (double)samples->x[i], y = (double)samples->y[i], z = (double)samples->z[i];
    return vec3_add(vec3_scale(view->x, x), vec3_add(vec3_scale(view->y, y), vec3_scale(view->z, z)));
}

static const View *look_at_sky(const Shine *s, Watcher *w, Sampler *sampler, Vec3 eye, Vec3 normal,
                               int cell) {
    ViewPoint from = {eye, normal, cell};
    const View *view = viewer_look(w->viewer, &from, s->options->culling);
    sampler_draw(sampler, view, &w->work);
    sampler_items(sampler, w->item);
    for (int i = 0; s->keep && i < s->door_words; i++)
        w->doors[i] |= view->doors ? view->doors[i] : UINT64_MAX;
    return view;
}

static double height_of(const View *view, const FormFactorSamples *samples, int i) {
    return (double)samples->x[i] * view->x.z + (double)samples->y[i] * view->y.z +
           (double)samples->z[i] * view->z.z;
}

static const double *relative_of(const Shine *s, SkyTable *table, const View *view,
                                 const FormFactorSamples *samples) {
    if (vec3_equal(table->normal, view->z)) return table->relative;
    table->normal = view->z;
    for (int i = 0; i < samples->count; i++) {
        Vec3 along = along_sample(view, samples, i);
        along.z = height_of(view, samples, i);
        table->relative[i] = along.z > 0 ? daylight_relative(&s->day, along) : 0;
    }
    return table->relative;
}

// ---- elements outdoors

static Seen look_up(const Shine *s, Watcher *w, Vec3 eye, Vec3 normal, int cell) {
    const View *view = look_at_sky(s, w, w->around, eye, normal, cell);
    const FormFactorSamples *samples = sampler_samples(w->around);
    const double *relative = relative_of(s, &w->above, view, samples);
    Seen seen = {0};
    panes_seen(&s->mesh->panes, s->forest, cell, (Plane){normal, vec3_dot(normal, eye)}, &w->panes[0]);
    double highest = panes_highest(&w->panes[0], eye) + ABOVE_PANES;
    for (int i = 0; i < samples->count; i++) {
        if (w->item[i] >= 0) continue;
        double weight = (double)samples->weight[i];
        if (height_of(view, samples, i) <= highest)
            weight *= panes_transmit_from_afar(&w->panes[0], eye, along_sample(view, samples, i));
        if (height_of(view, samples, i) > 0) {
            seen.open += weight;
            seen.sky += weight * relative[i];
            if (s->keep && weight > 0)
                sky_collector_add(w->collector, weight, along_sample(view, samples, i));
        } else {
            seen.ground += weight;
        }
    }
    if (!s->keep) return seen;
    seen.part_count = sky_collector_take(w->collector, w->part);
    seen.part = ARENA_ARRAY(&w->kept, SkyPart, seen.part_count + 1);
    memcpy(seen.part, w->part, (size_t)seen.part_count * sizeof *w->part);
    sky_parts_fit(seen.part, seen.part_count, &s->day, seen.sky);
    return seen;
}

// A place that nothing stands before.
static double open_share(Vec3 normal) { return 0.5 + 0.5 * normal.z; }

static int cell_before(const Shine *s, Vec3 eye, Vec3 normal, int hint) {
    return vis_locate(s->mesh->graph, vec3_add(eye, vec3_scale(normal, IN_FRONT)), hint);
}

static void look_from_element(Shine *s, Watcher *w, int e, Vec3 normal, int patch_cell) {
    Vec3 eye = element_centroid(s->mesh, e);
    int cell = cell_before(s, eye, normal, patch_cell);
    s->looks[e] = cell < 0 || sky_is_outdoors(s->mesh->graph, cell);
    s->seen[e] = (Seen){0};
    if (s->looks[e]) s->seen[e] = look_up(s, w, eye, normal, cell);
}

// Under the open sky a patch looks for all its elements.
static void look_from_patch(void *context, int index, int thread) {
    Shine *s = context;
    int number = s->first + index;
    const Patch *patch = &s->mesh->patches[number];
    Vec3 n = s->mesh->faces[patch->face].plane.n;
    Watcher *w = &s->watchers[thread];
    Seen seen = {0};
    if (!mesh_owns(s->mesh, patch->face) || (s->keep && s->known[number])) return;
    if (s->keep) memset(w->doors, 0, (size_t)s->door_words * sizeof *w->doors);
    bool open = patch->cell >= 0 && sky_is_outdoors(s->mesh->graph, patch->cell);
    if (open) {
        seen = look_up(s, w, patch->centre, n, patch->cell);
        open = seen.open > (1 - STANDS_FREE) * open_share(n);
    }
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        if (!open)
            look_from_element(s, w, e, n, patch->cell);
        else
            s->looks[e] = true, s->seen[e] = seen;
    }
    if (!s->keep) return;
    memcpy(s->doors + (size_t)number * (size_t)s->door_words, w->doors,
           (size_t)s->door_words * sizeof *w->doors);
    s->known[number] = true;
}

// ---- openings

// Finds the origins of the lines that come in by a piece, and their weights. False: there is no light behind.
static bool look_back(const Shine *s, Watcher *w, const SkyOpening *o, const SkyPiece *piece) {
    const View *view = look_at_sky(s, w, w->outside, piece->centre, vec3_scale(o->plane.n, -1), o->outside);
    const FormFactorSamples *out = sampler_samples(w->outside), *in = sampler_samples(w->inside);
    const double *relative = relative_of(s, &w->behind, view, out);
    bool any = false;
    for (int i = 0; i < in->count; i++) {
        int behind = s->mirror[i];
        w->origin[i] = FROM_NOWHERE;
        w->weight[i] = in->weight[i];
        if (behind < 0 || w->item[behind] >= 0) continue;
        if (height_of(view, out, behind) > 0) {
            w->origin[i] = FROM_SKY;
            w->weight[i] *= (float)relative[behind];
        } else if (s->ground || s->keep) {
            w->origin[i] = FROM_GROUND;
        }
        any = any || w->origin[i] != FROM_NOWHERE;
    }
    return any;
}

static void keep_part(const Shine *s, const Row *row, Arena *arena, BeamPart *part) {
    part->element = ARENA_ARRAY(arena, int, row->count + 1);
    part->factor = ARENA_ARRAY(arena, float, row->count + 1);
    for (int i = 0; i < row->count; i++) {
        if (s->looks[row->element[i]]) continue;
        part->element[part->count] = row->element[i];
        part->factor[part->count++] = row->factor[i];
    }
    part->back = row->back;
}

// Panes of glass weaken the light that comes in by a piece, on its way from afar and on its way to the faces that it meets.
static void pass_panes(const Shine *s, Watcher *w, const View *view, const SkyOpening *o) {
    const FormFactorSamples *in = sampler_samples(w->inside);
    Plane inwards = {o->plane.n, vec3_dot(o->plane.n, view->eye)};
    Plane outwards = {vec3_scale(inwards.n, -1), -inwards.d};
    panes_seen(&s->mesh->panes, s->forest, o->inside, inwards, &w->panes[0]);
    panes_seen(&s->mesh->panes, s->forest, o->outside, outwards, &w->panes[1]);
    for (int i = 0; i < in->count; i++) {
        if (w->item[i] < 0) continue;
        const ViewFace *f = &view->faces[w->item[i]];
        Vec3 sample = {(double)in->x[i], (double)in->y[i], (double)in->z[i]},
             along = along_sample(view, in, i);
        Vec3 met = vec3_add(view->eye, vec3_scale(along, f->d / vec3_dot(f->n, sample)));
        w->weight[i] *= (float)(panes_transmit(&w->panes[0], view->eye, met) *
                                panes_transmit_from_afar(&w->panes[1], view->eye, vec3_scale(along, -1)));
    }
}

// A row sums to 1; the sum of the weights before that is the mean radiance over that overhead, exactly 1 for an even sky and no glass.
static double mean_weight(const FormFactorSamples *in, const float *weight) {
    double plain = 0, weighted = 0;
    for (int i = 0; i < in->count; i++) {
        plain += (double)in->weight[i];
        weighted += (double)weight[i];
    }
    return weighted / plain;
}

static void send_in(const Shine *s, Watcher *w, const View *view, int origin, Beam *beam) {
    FormFactorSamples in = *sampler_samples(w->inside);
    BeamPart *part = &beam->parts[origin];
    part->mean = 1;
    if (origin == FROM_SKY || s->mesh->panes.count > 0) {
        part->mean = mean_weight(&in, w->weight);
        in.weight = w->weight;
    }
    for (int i = 0; i < in.count; i++) w->lit[i] = w->origin[i] == origin ? w->item[i] : -1;
    row_of_items(&w->sum, view, &in, w->lit);
    keep_part(s, row_finish(&w->sum), &beam->arena, part);
}

// The samples of a piece, those side by side of one element and one cell of the sky together.
static void keep_rays(const Shine *s, Watcher *w, const View *view, Beam *beam) {
    const FormFactorSamples *in = sampler_samples(w->inside);
    double all = 0;
    int count = 0;
    row_elements(&w->sum, view, in, w->item, w->met);
    for (int i = 0; i < in->count; i++) {
        all += (double)in->weight[i];
        if (w->item[i] < 0) continue;
        Vec3 back = vec3_scale(along_sample(view, in, i), -1);
        bool sky = w->origin[i] == FROM_SKY;
        int cell = sky ? sky_part_cell(back) : -1;
        Ray *ray = &w->rays[count > 0 ? count - 1 : 0];
        if (count == 0 || ray->element != w->met[i] || ray->cell != cell) {
            ray = &w->rays[count++];
            *ray = (Ray){.element = w->met[i], .cell = cell};
        }
        // `weight` knows the radiance of the sky already.
        double light = (double)w->weight[i], share = sky ? light / w->behind.relative[s->mirror[i]] : light;
        ray->share += share;
        ray->light += light;
        if (sky) ray->sum = vec3_add(ray->sum, vec3_scale(back, share));
    }
    for (int i = 0; i < count; i++) {
        w->rays[i].share /= all;
        w->rays[i].light /= all;
    }
    beam->ray_count = count;
    beam->rays = ARENA_ARRAY(&beam->arena, Ray, count + 1);
    memcpy(beam->rays, w->rays, (size_t)count * sizeof *w->rays);
}

// The doors that a beam depends on.
static void keep_doors(const Shine *s, const Watcher *w, Beam *beam) {
    beam->doors = ARENA_ARRAY(&beam->arena, uint64_t, s->door_words + 1);
    memcpy(beam->doors, w->doors, (size_t)s->door_words * sizeof *w->doors);
}

static void look_in(void *context, int index, int thread) {
    Shine *s = context;
    Watcher *w = &s->watchers[thread];
    Beam *beam = &s->beams[index];
    const SkyPiece *piece = &s->openings.pieces[s->list[s->first + index]];
    const SkyOpening *o = &s->openings.openings[piece->opening];
    arena_reset(&beam->arena);
    memset(beam->parts, 0, sizeof beam->parts);
    beam->ray_count = 0;
    if (s->keep) memset(w->doors, 0, (size_t)s->door_words * sizeof *w->doors);
    bool any = look_back(s, w, o, piece);
    if (!any && s->keep) keep_doors(s, w, beam);
    if (!any) return;
    const View *view = look_at_sky(s, w, w->inside, piece->centre, o->plane.n, o->inside);
    const FormFactorSamples *in = sampler_samples(w->inside);
    for (int i = 0; i < in->count; i++)
        if (w->origin[i] == FROM_NOWHERE) w->item[i] = -1;
    sky_end_at_exits(&s->openings, s->forest, piece->opening, view, in, w->item);
    if (s->mesh->panes.count > 0) pass_panes(s, w, view, o);
    if (s->keep) {
        keep_rays(s, w, view, beam);
        keep_doors(s, w, beam);
        return;
    }
    send_in(s, w, view, FROM_SKY, beam);
    if (s->ground) send_in(s, w, view, FROM_GROUND, beam);
}

// ---- light

static void receive_part(const Mesh *mesh, const SkyPiece *piece, const BeamPart *part,
                         const double radiance[3], RadSolution *solution) {
    double power = M_PI * piece->area * part->mean;
    for (int i = 0; i < part->count; i++)
        sky_receive(mesh, part->element[i], power * (double)part->factor[i], radiance, solution);
    for (int c = 0; c < 3; c++) {
        solution->emitted[c] += power * part->back * radiance[c];
        solution->absorbed[c] += power * part->back * radiance[c];
    }
}

static int batch_of(const Shine *s, int all, int most) {
    return all - s->first < most ? all - s->first : most;
}

// ---- all light

static bool shine_outdoors(Shine *s, const Mesh *mesh, const Progress *progress, RadSolution *solution) {
    double lamps[3];
    memcpy(lamps, solution->emitted, sizeof lamps);
    for (s->first = 0; s->first < mesh->patch_count; s->first += PATCH_BATCH) {
        if (!progress_report(progress, "sky", 0.5 * s->first / mesh->patch_count)) return false;
        parallel_for(s->threads, batch_of(s, mesh->patch_count, PATCH_BATCH), look_from_patch, s);
    }
    for (int e = 0; e < mesh->element_count; e++) {
        double area = M_PI * mesh->elements[e].area;
        if (s->seen[e].sky > 0) sky_receive(mesh, e, area * s->seen[e].sky, s->day.zenith, solution);
        if (s->ground && s->seen[e].ground > 0)
            sky_receive(mesh, e, area * s->seen[e].ground, s->below, solution);
    }
    for (int c = 0; c < 3; c++) solution->outdoors[c] = solution->emitted[c] - lamps[c];
    return true;
}

// Keeps, or adds to the light, what came in by the pieces of a batch.
static void take_beams(Shine *s, const Mesh *mesh, int count, Gathered *gathered, RadSolution *solution) {
    for (int i = 0; i < count; i++) {
        int number = s->list[s->first + i];
        const SkyPiece *piece = &s->openings.pieces[number];
        const Beam *beam = &s->beams[i];
        if (!s->keep) {
            receive_part(mesh, piece, &beam->parts[FROM_SKY], s->day.zenith, solution);
            if (s->ground) receive_part(mesh, piece, &beam->parts[FROM_GROUND], s->below, solution);
            continue;
        }
        SkyOpening *o = &s->openings.openings[piece->opening];
        if (number == o->first_piece) memset(o->doors, 0, (size_t)s->door_words * sizeof *o->doors);
        for (int k = 0; k < beam->ray_count; k++) sky_add_ray(gathered, &beam->rays[k]);
        for (int k = 0; k < s->door_words; k++) o->doors[k] |= beam->doors[k];
        if (number + 1 == o->first_piece + o->piece_count) sky_end_opening(o, piece->area, &s->day, gathered);
    }
}

static bool shine_in(Shine *s, const Mesh *mesh, const Progress *progress, RadSolution *solution) {
    Gathered gathered = {0};
    bool go_on = true;
    int all = 0;
    for (int p = 0; p < s->openings.piece_count; p++)
        if (!s->openings.openings[s->openings.pieces[p].opening].known) s->list[all++] = p;
    for (s->first = 0; s->first < all && go_on; s->first += BATCH) {
        go_on = progress_report(progress, "sky", 0.5 + 0.5 * s->first / all);
        int count = go_on ? batch_of(s, all, BATCH) : 0;
        parallel_for(s->threads, count, look_in, s);
        take_beams(s, mesh, count, &gathered, solution);
    }
    arena_free(&gathered.arena);
    for (int o = 0; o < s->openings.count && go_on; o++)
        sky_receive_incoming(s, mesh, &s->openings.openings[o], solution);
    return go_on;
}

// Call after shine_outdoors, which says which elements are outdoors.
static bool shine_sun(Shine *s, const Mesh *mesh, const Progress *progress, RadSolution *solution) {
    const Daylight *day = &s->day;
    Arena arena = {0};
    if (rgb_sum(day->beam) == 0) return true;
    if (!progress_report(progress, "sun", 0.5)) return false;
    double *share = ARENA_ARRAY(&arena, double, mesh->element_count);
    sunlight_shares(mesh, day->sun, s->options->culling != CULL_NONE, s->threads, share);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        if (!(share[e] > 0) || !mesh_owns(mesh, element->face)) continue;
        double power = share[e] * element->area * vec3_dot(mesh->faces[element->face].plane.n, day->sun);
        sky_receive(mesh, e, power, day->beam, solution);
        for (int c = 0; c < 3 && s->looks[e]; c++) solution->outdoors[c] += power * day->beam[c];
    }
    arena_free(&arena);
    return true;
}

// Where one part of a building is stopped, all are.
static bool all_go_on(const RadOptions *options, bool good) {
    return options->borders ? !team_any(borders_member(options->borders), !good) : good;
}

static SkyLooks *looks_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                           const RadOptions *options, bool keep) {
    Arena arena = {0};
    SkyLooks *s = ARENA_ARRAY(&arena, SkyLooks, 1);
    s->mesh = mesh;
    s->forest = forest;
    s->options = options;
    s->keep = keep;
    s->threads = parallel_threads(options->threads);
    s->openings = sky_openings(mesh, &arena);
    s->lines = lines_of_mesh(mesh, &arena);
    s->looks = ARENA_ARRAY(&arena, bool, mesh->element_count);
    s->seen = ARENA_ARRAY(&arena, Seen, mesh->element_count);
    s->list = ARENA_ARRAY(&arena, int, s->openings.piece_count + 1);
    s->watchers = ARENA_ARRAY(&arena, Watcher, s->threads);
    for (int t = 0; t < s->threads; t++) make_watcher(s, door_open, &s->watchers[t]);
    s->mirror = mirror_of(&s->watchers[0], options->form_factor.resolution, &arena);
    if (keep) {
        s->door_words = viewer_door_words(mesh);
        size_t words = (size_t)s->door_words;
        s->known = ARENA_ARRAY(&arena, bool, mesh->patch_count + 1);
        s->doors = ARENA_ARRAY(&arena, uint64_t, (size_t)mesh->patch_count * words + 1);
        for (int o = 0; o < s->openings.count; o++)
            s->openings.openings[o].doors = ARENA_ARRAY(&arena, uint64_t, words + 1);
    }
    s->arena = arena;
    return s;
}

SkyLooks *sky_looks_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                        const RadOptions *options) {
    CORE_ASSERT(!options->borders);
    return looks_new(mesh, forest, door_open, options, true);
}

void sky_looks_end(SkyLooks *s) {
    for (int t = 0; t < s->threads; t++) {
        arena_free(&s->watchers[t].arena);
        arena_free(&s->watchers[t].kept);
    }
    for (int i = 0; i < BATCH; i++) arena_free(&s->beams[i].arena);
    for (int o = 0; o < s->openings.count; o++) arena_free(&s->openings.openings[o].kept);
    Arena arena = s->arena;
    arena_free(&arena);
}

// From now on light is found under this day; looks that are there tell it, too.
static void turn_to(Shine *s, const Daylight *day) {
    bool turned = memcmp(&s->day, day, sizeof *day) != 0;
    s->day = *day;
    daylight_below(day, s->below);
    s->ground = rgb_sum(s->below) > 0;
    for (int t = 0; t < s->threads && turned; t++)
        s->watchers[t].behind.normal = s->watchers[t].above.normal = (Vec3){0, 0, 0};
    if (turned && s->keep) sky_turn_looks(s);
}

bool rad_shine(const Mesh *mesh, const StabForest *forest, const float *door_open, const RadOptions *options,
               const Daylight *day, const Progress *progress, RadSolution *solution) {
    CORE_ASSERT(solution->shots == 0);
    const Borders *borders = options->borders;
    SkyLooks *s = options->sky ? options->sky : looks_new(mesh, forest, door_open, options, false);
    turn_to(s, day);
    bool good = all_go_on(options, shine_outdoors(s, mesh, progress, solution));
    if (good && borders) borders_fetch(borders, &BORDER_VALUE(BORDER_ELEMENT, s->looks), 1);
    good = good && all_go_on(options, shine_sun(s, mesh, progress, solution)) &&
           all_go_on(options, shine_in(s, mesh, progress, solution));
    const BorderValue light[] = {BORDER_VALUE(BORDER_ELEMENT, solution->radiosity),
                                 BORDER_VALUE(BORDER_PATCH, solution->unshot)};
    if (good && borders) borders_bring(borders, light, 2);
    solution->day = *day;
    for (int p = 0; p < mesh->patch_count; p++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->patches[p].face)->emission, emitted);
        for (int e = mesh->patches[p].first_element, i = 0; i < mesh->patches[p].element_count; e++, i++)
            for (int c = 0; c < 3; c++)
                solution->daylight[e][c] = fmax(solution->radiosity[e][c] - emitted[c], 0);
    }
    if (good && borders) borders_fetch(borders, &BORDER_VALUE(BORDER_ELEMENT, solution->daylight), 1);
    if (!options->sky) sky_looks_end(s);
    return good;
}
