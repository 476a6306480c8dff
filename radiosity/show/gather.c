// gather.c - irradiance at a point: lamps by their visible parts in closed form, all else by samples that see light slope in each
// element, about the element's own mean. (Interpolated light itself has not quite the power of the elements, and is farther
// off than constant elements are; slopes about their means halve the error.)
//
// Source: M. C. Reichert, A Two-Pass Radiosity Method Driven by Lights and Viewer Position, 1992 (the last bounce is gathered
// where it is looked at).
#include "radiosity/show/gather.h"

#include <limits.h>
#include <string.h>

#include "engine/core/error.h"
#include "radiosity/factors/lamp_spread.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_walk.h"

// One thread's.
typedef struct NearGatherer NearGatherer;

// ---- one radiosity for all of an element says nothing about light that changes within centimetres: behind a cabinet, or in a
// corner. From surfaces that are close to a point for the size of their elements light is brought by random walks (path_walk.c),
// which end where they meet an element from afar, for then all of it is in sight (Jensen 1996, Global Illumination Using Photon Maps,
// section 4, gathers anew from near elements for the same reason). Nor is an element trusted from afar that lies in a crowd itself.
//
// Shares of light are the caller's, exact ones at best; walks tell the mean light of the near ones. All points take the same
// random numbers, so that the light of a point depends on the point alone, and changes little from a point to the next.

// For a standard error at all: of so few it is right to a quarter.
enum { FEWEST_BLOCKS = 8 };
static const uint64_t SEED = 1;
// Looks that tell whether a place is crowded, and the share of them that must meet close faces: an element beside a wall has a
// quarter of them, one in a slit nine tenths.
enum { LOOKS = 64 };
static const double CROWDED = 0.3;

struct NearGatherer {
    PathWorld world;
    const RadSolution *solution;
    double reach, error;  // GatherOptions.near
    int blocks;
    double *size;  // [element_count] metres: of a square, its edge
    int *known;    // [element_count] 2 * look + is it near
    int look;
    Vec3 eye, normal;
    bool crowded;          // is the eye
    unsigned char *trust;  // [element_count] of UNKNOWN ..
};

enum { UNKNOWN, OPEN, IN_CROWD };

// The side of a square as long across.
static double size_of(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    const int *corner = mesh->corners + e->first_corner;
    double longest = 0;
    for (int i = 0; i < e->corner_count; i++)
        for (int k = 0; k < i; k++) {
            Vec3 across = vec3_sub(mesh->vertices[corner[i]], mesh->vertices[corner[k]]);
            longest = fmax(longest, vec3_dot(across, across));
        }
    return sqrt(longest / 2);
}

// All memory is taken here.
static NearGatherer *near_gatherer_new(const Mesh *mesh, const RadSolution *solution,
                                       const GatherOptions *options, Arena *arena) {
    NearGatherer *self = ARENA_ARRAY(arena, NearGatherer, 1);
    *self = (NearGatherer){.world = path_world(mesh, &solution->day, arena),
                           .solution = solution,
                           .reach = options->near.reach,
                           .error = options->near.error,
                           .blocks = options->near.blocks,
                           .size = ARENA_ARRAY(arena, double, mesh->element_count),
                           .known = ARENA_ARRAY(arena, int, mesh->element_count),
                           .trust = ARENA_ARRAY(arena, unsigned char, mesh->element_count)};
    for (int e = 0; e < mesh->element_count; e++) self->size[e] = size_of(mesh, e);
    return self;
}

// Frees the memory outside the arena.
static void near_gatherer_end(NearGatherer *self) { path_world_end(&self->world); }

// ---- near elements

static double distance_to_edge(Vec3 a, Vec3 b, Vec3 p) {
    Vec3 along = vec3_sub(b, a), off = vec3_sub(p, a);
    double t = vec3_dot(along, off) / vec3_dot(along, along);
    return vec3_length(vec3_sub(off, vec3_scale(along, fmin(fmax(t, 0), 1))));
}

static double distance_to(const Mesh *mesh, int element, Vec3 p) {
    const Element *e = &mesh->elements[element];
    const int *corner = mesh->corners + e->first_corner;
    Plane plane = mesh->faces[e->face].plane;
    double nearest = INFINITY;
    bool inside = true;
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 a = mesh->vertices[corner[i]], b = mesh->vertices[corner[(i + 1) % e->corner_count]];
        nearest = fmin(nearest, distance_to_edge(a, b, p));
        inside = inside && vec3_dot(plane.n, vec3_cross(vec3_sub(b, a), vec3_sub(p, a))) >= 0;
    }
    return inside ? fabs(plane_distance(plane, p)) : nearest;
}

static int element_of(const NearGatherer *self, const PathHit *hit) {
    return mesh_element_at(self->world.mesh, hit->face,
                           vec3_add(hit->point, path_scene_origin(self->world.scene)));
}

// ---- crowded places

// Looks from one place or several: how many have met a face that is close for the element, and how many a back.
typedef struct Looks {
    int close, backs;
} Looks;

static void look_once(const NearGatherer *self, Vec3 from, Vec3 normal, Random *random, Looks *looks) {
    double u = random_unit(random);
    PathHit hit = path_scene_trace(self->world.scene, from, path_direction(normal, u, random_unit(random)));
    if (hit.face < 0) return;
    double distance = vec3_length(vec3_sub(hit.point, from));
    looks->backs += !hit.front;
    looks->close += hit.front && distance < self->reach * self->size[element_of(self, &hit)];
}

static bool is_eye_crowded(const NearGatherer *self) {
    const PathScene *scene = self->world.scene;
    Vec3 from = path_scene_off(scene, vec3_sub(self->eye, path_scene_origin(scene)), self->normal);
    Random random = {SEED};
    Looks looks = {0};
    for (int i = 0; i < LOOKS; i++) look_once(self, from, self->normal, &random, &looks);
    return looks.close + looks.backs > CROWDED * LOOKS;
}

// From points between its middle and each of its corners in turn. Where some look from an element meets a back, part of it may
// lie inside closed objects, however well the rest is lit.
static bool is_element_crowded(const NearGatherer *self, int element) {
    const Mesh *mesh = self->world.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 middle = element_centroid(mesh, element), n = mesh->faces[e->face].plane.n;
    Random random = {SEED + (uint64_t)element};
    Looks looks = {0};
    for (int i = 0; i < LOOKS; i++) {
        Vec3 corner = mesh->vertices[mesh->corners[e->first_corner + i % e->corner_count]];
        Vec3 p = vec3_sub(vec3_lerp(middle, corner, sqrt(random_unit(&random))),
                          path_scene_origin(self->world.scene));
        look_once(self, path_scene_before(self->world.scene, e->face, p), n, &random, &looks);
    }
    return looks.backs > 0 || looks.close > CROWDED * LOOKS;
}

// Its one radiosity is no better known than light close by is.
static bool is_crowded(NearGatherer *self, int element) {
    unsigned char *trust = &self->trust[element];
    if (*trust == UNKNOWN) *trust = is_element_crowded(self, element) ? IN_CROWD : OPEN;
    return *trust == IN_CROWD;
}

// Looks from a point, which the next calls are about. It depends on nothing but the point, and allocates nothing.
static void near_gatherer_look(NearGatherer *self, Vec3 eye, Vec3 normal) {
    if (++self->look > INT_MAX / 2 - 1) {
        // Come round: forget old marks.
        memset(self->known, 0, (size_t)self->world.mesh->element_count * sizeof *self->known);
        self->look = 1;
    }
    self->eye = eye;
    self->normal = normal;
    self->crowded = is_eye_crowded(self);
}

// For the point looked from: is this element one that is walked to?
static bool near_gatherer_is_near(NearGatherer *self, int element) {
    if (self->known[element] / 2 != self->look) {
        const Mesh *mesh = self->world.mesh;
        double within = self->reach * self->size[element];
        Vec3 corner = mesh->vertices[mesh->corners[mesh->elements[element].first_corner]];
        // No point of it is farther from a corner than it is long.
        bool may_be = vec3_length(vec3_sub(corner, self->eye)) < within + M_SQRT2 * self->size[element];
        bool near = (may_be && distance_to(mesh, element, self->eye) < within) ||
                    (self->crowded && is_crowded(self, element));
        self->known[element] = 2 * self->look + near;
    }
    return self->known[element] % 2;
}

// ---- walks

static void reflected_by(const NearGatherer *self, int element, double out[3]) {
    const Mesh *mesh = self->world.mesh;
    Rgb e = mesh_material(mesh, mesh->elements[element].face)->emission;
    const double *b = self->solution->radiosity[element];
    out[0] = b[0] - (double)e.r;
    out[1] = b[1] - (double)e.g;
    out[2] = b[2] - (double)e.b;
}

static bool is_known(void *context, Vec3 from, const PathHit *hit, double out[3]) {
    NearGatherer *self = context;
    int element = element_of(self, hit);
    double distance = vec3_length(vec3_sub(hit->point, from));
    if (distance < self->reach * self->size[element] || is_crowded(self, element)) return false;
    reflected_by(self, element, out);
    return true;
}

// Sums over walks.
typedef struct Sums {
    double near[3], far;  // light; of the far ones, the sum of channels
    long long near_count, count;
} Sums;

static void walk_near(NearGatherer *self, const PathHit *hit, PathNumbers *numbers,
                      const double u[PATH_NUMBERS], double light[3]) {
    const PathWorld *world = &self->world;
    double weight[3] = {1, 1, 1};
    if (!path_reflect(path_reflectance(world, hit), u[PATH_ROULETTE], weight)) return;
    PathPlace place = {path_scene_before(world->scene, hit->face, hit->point),
                       world->mesh->faces[hit->face].plane.n};
    path_walk(world, place, numbers, 1, is_known, self, weight, light);
}

static void add_walk(NearGatherer *self, Vec3 from, PathNumbers *numbers, Sums *sums) {
    const PathWorld *world = &self->world;
    double u[PATH_NUMBERS], far[3];
    path_numbers_at(numbers, 0, u);
    Vec3 along = path_direction(self->normal, u[PATH_DIRECTION], u[PATH_DIRECTION + 1]);
    PathHit hit = path_scene_trace(world->scene, from, along);
    sums->count++;
    if (hit.face < 0 || !hit.front) return;
    int element = element_of(self, &hit);
    if (!near_gatherer_is_near(self, element)) {
        reflected_by(self, element, far);
        sums->far += far[0] + far[1] + far[2];
        return;
    }
    sums->near_count++;
    walk_near(self, &hit, numbers, u, sums->near);
}

static double all_of(const Sums *s) { return s->near[0] + s->near[1] + s->near[2] + s->far; }

// The mean of the light that near elements reflect to the point, each by its seen share: W/m^2 a channel. False: walks
// do not find any.
static bool near_gatherer_mean(NearGatherer *self, double reflected[3]) {
    const PathWorld *world = &self->world;
    Vec3 from =
        path_scene_off(world->scene, vec3_sub(self->eye, path_scene_origin(world->scene)), self->normal);
    Sums sums = {0};
    double squares = 0, light = 0;
    for (int n = 1; n <= self->blocks; n++) {
        PathNumbers numbers = path_numbers(SEED, n);
        double before = all_of(&sums);
        for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++)
            add_walk(self, from, &numbers, &sums);
        light = all_of(&sums);
        squares += (light - before) * (light - before);
        double variance = fmax(squares / n - light / n * (light / n), 0);
        if (n >= FEWEST_BLOCKS && sqrt(variance / (n - 1)) <= self->error * light / n) break;
    }
    for (int c = 0; c < 3 && sums.near_count > 0; c++) reflected[c] = sums.near[c] / (double)sums.near_count;
    return sums.near_count > 0;
}

// How far in front of its face a point is looked for among the cells, metres: as patches are (mesh.c).
static const double IN_FRONT = 1e-6;

GatherOptions gather_default_options(void) {
    return (GatherOptions){.method = form_factor_method("hemisphere"),
                           .resolution = 100,
                           .culling = CULL_STAB,
                           .exact_lamps = true};
}

GatherOptions gather_exact_options(void) {
    // Those of `near` were chosen together, on office-plain, a home and the reference rooms: an error of half a percent, as far as 32
    // blocks go.
    return (GatherOptions){.method = form_factor_method("analytic"),
                           .resolution = 100,
                           .culling = CULL_STAB,
                           .exact_lamps = false,
                           .near = {.reach = 1.5, .error = 0.005, .blocks = 32}};
}

// How far the light that leaves an element at p is above its mean: dot(slope[c], p) - offset[c].
typedef struct Slope {
    double offset[3];
    Vec3 slope[3];
} Slope;

struct Gatherer {
    GatherScene scene;
    GatherOptions options;
    Viewer *viewer;
    FormFactor *rows;  // of the method
    FormFactor
        *samples;  // for slopes and skies that are not even: the same, where it has samples; NULL: none
    // [element_count] the mean light that leaves an element, less its emission where lamps are exact
    double (*leaving)[3];
    Slope *slope;                // [element_count] NULL: elements are constant
    AnalyticOccluder *occluder;  // [face_count]
    Plane *edge;                 // [outline_count]
    bool any_lamp, sky_in_rows;
    NearGatherer *near;  // NULL: none
    Panes panes;         // before the point
    double (*own)
        [3];  // [element_count] that leaves an element with all rooms closed, as in `leaving`; NULL: nobody asks
    const RadSolution *closed_light;
    const Panes *closed;
    Panes black;  // before the point, of `closed`
    int cell;     // of the point
};

// Light that arrives, and the part of it that passes no black pane.
typedef struct Arriving {
    double all[3], own[3];
} Arriving;

// As much of the slope as keeps the element's light at 0 or above: beside bright things elements are too coarse to be straight.
static void limit_slope(const Gatherer *self, int element, Slope *out) {
    const Mesh *mesh = self->scene.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 centre = element_centroid(mesh, element);
    for (int c = 0; c < 3; c++) {
        double mean = self->scene.solution->radiosity[element][c], lowest = 0;
        for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++) {
            Vec3 p = vec3_sub(mesh->vertices[mesh->corners[i]], centre);
            lowest = fmin(lowest, vec3_dot(out->slope[c], p));
        }
        if (mean + lowest < 0) out->slope[c] = vec3_scale(out->slope[c], -mean / lowest);
        out->offset[c] = vec3_dot(out->slope[c], centre);
    }
}

// How the corners' light slopes, about their mean, in the face's axes.
static void fit_slope(const Gatherer *self, int element, Slope *out) {
    const Mesh *mesh = self->scene.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 x, y, mean = {0};
    double xx = 0, xy = 0, yy = 0, bx[3] = {0}, by[3] = {0};
    view_axes(mesh->faces[e->face].plane.n, &x, &y);
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++)
        mean = vec3_add(mean, vec3_scale(mesh->vertices[mesh->corners[i]], 1.0 / e->corner_count));
    for (int i = e->first_corner; i < e->first_corner + e->corner_count; i++) {
        Vec3 p = vec3_sub(mesh->vertices[mesh->corners[i]], mean);
        double u = vec3_dot(x, p), v = vec3_dot(y, p);
        xx += u * u, xy += u * v, yy += v * v;
        for (int c = 0; c < 3; c++) {
            bx[c] += self->scene.light->corner[i][c] * u;
            by[c] += self->scene.light->corner[i][c] * v;
        }
    }
    double det = xx * yy - xy * xy, even[3];
    if (!(det > 0)) return;
    mesh_even(mesh, element, even);
    for (int c = 0; c < 3; c++) {
        double own = det * even[c];
        out->slope[c] = vec3_add(vec3_scale(x, (bx[c] * yy - by[c] * xy) / own),
                                 vec3_scale(y, (by[c] * xx - bx[c] * xy) / own));
    }
    limit_slope(self, element, out);
}

// Is a face's emitted light found apart from that of rows? Rows know nothing of candela tables.
static bool is_exact(const GatherOptions *options, const Mesh *mesh, int face) {
    return options->exact_lamps || mesh_spread(mesh, face);
}

double (*gather_leaving(const GatherScene *scene, const GatherOptions *options, Arena *arena))[3] {
    const Mesh *mesh = scene->mesh;
    double(*out)[3] = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *out);
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        bool exact = is_exact(options, mesh, mesh->elements[e].face);
        for (int c = 0; c < 3; c++) out[e][c] = scene->solution->radiosity[e][c] - (exact ? emitted[c] : 0);
    }
    return out;
}

static void find_leaving(Gatherer *self, Arena *arena) {
    const Mesh *mesh = self->scene.mesh;
    self->leaving = gather_leaving(&self->scene, &self->options, arena);
    if (self->scene.light) self->slope = ARENA_ARRAY(arena, Slope, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count && self->slope; e++) fit_slope(self, e, &self->slope[e]);
    for (int e = 0; e < mesh->element_count && self->own; e++)
        for (int c = 0; c < 3; c++)
            self->own[e][c] = self->leaving[e][c] + self->closed_light->radiosity[e][c] -
                              self->scene.solution->radiosity[e][c];
    for (int f = 0; f < mesh->face_count && !self->options.reflected; f++)
        self->any_lamp = self->any_lamp || (mesh_emits(mesh, f) && is_exact(&self->options, mesh, f));
}

Gatherer *gatherer_new(const GatherScene *scene, const GatherOptions *options, Arena *arena) {
    return gatherer_new_apart(scene, options, NULL, NULL, arena);
}

Gatherer *gatherer_new_apart(const GatherScene *scene, const GatherOptions *options, const RadSolution *own,
                             const Panes *closed, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    FormFactorOptions rows = form_factor_default_options();
    Gatherer *self = ARENA_ARRAY(arena, Gatherer, 1);
    rows.resolution = options->resolution;
    if (daylight_shines(&scene->solution->day)) {
        rows.day = &scene->solution->day;
        rows.panes = &self->panes;
        rows.sky_parts = options->sky_parts;
    }
    // Doors that move later may close panes that are open now.
    self->panes.panes = ARENA_ARRAY(arena, Pane, mesh->graph->building->opening_count + 1);
    self->scene = *scene;
    self->options = *options;
    if (own) {
        CORE_ASSERT(!scene->light && options->near.reach == 0);
        self->closed_light = own;
        self->closed = closed;
        self->own = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *self->own);
        self->black.panes = ARENA_ARRAY(arena, Pane, closed->count + 1);
    }
    self->viewer = viewer_new(mesh, scene->forest, scene->door_open, arena);
    self->rows = form_factor_new(options->method, mesh, &rows, arena);
    // Behind glass no sky is even.
    self->sky_in_rows =
        options->method->projective || (daylight_is_uniform(&scene->solution->day) &&
                                        (mesh->panes.count == 0 || !daylight_shines(&scene->solution->day)));
    // Nor is the part of it that comes from other rooms.
    if (own && daylight_shines(&scene->solution->day)) self->sky_in_rows = false;
    if (scene->light || !self->sky_in_rows)
        self->samples = options->method->projective
                            ? self->rows
                            : form_factor_new(form_factor_method("hemisphere"), mesh, &rows, arena);
    self->occluder = ARENA_ARRAY(arena, AnalyticOccluder, mesh->face_count);
    self->edge = ARENA_ARRAY(arena, Plane, mesh->outline_count);
    find_leaving(self, arena);
    if (options->near.reach > 0) self->near = near_gatherer_new(mesh, scene->solution, options, arena);
    return self;
}

void gatherer_end(Gatherer *self) {
    if (self->near) near_gatherer_end(self->near);
    if (self->samples && self->samples != self->rows) form_factor_end(self->samples);
    form_factor_end(self->rows);
}

void gatherer_pose(Gatherer *self) { viewer_pose(self->viewer); }

static int find_occluders(Gatherer *self, const View *view) {
    int count = 0;
    Plane *edge = self->edge;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        AnalyticOccluder *o = &self->occluder[count];
        if (!analytic_occluder(view->vertices + f->first_vertex, f->vertex_count, form_factor_rank(f), edge,
                               o))
            continue;
        count++;
        edge += o->edge_count;
    }
    return count;
}

// A direction of the view's axes.
static Vec3 in_building(const View *view, Vec3 w) {
    return vec3_add(vec3_scale(view->x, w.x), vec3_add(vec3_scale(view->y, w.y), vec3_scale(view->z, w.z)));
}

// Adds light; `own` is the part of it that a closed room has, if it comes to the view's eye past no black pane.
static void arrive(const double all[3], const double own[3], bool passes, Arriving *to) {
    for (int c = 0; c < 3; c++) {
        to->all[c] += all[c];
        if (passes) to->own[c] += own[c];
    }
}

// From a point of an element.
static bool passes_black(const Gatherer *self, const View *view, Vec3 from, int element) {
    const Mesh *mesh = self->scene.mesh;
    return self->own && panes_transmit_between(&self->black, view->eye, self->cell, from,
                                               mesh->patches[mesh->elements[element].patch].cell) > 0;
}

static bool passes_black_from_afar(const Gatherer *self, const View *view, Vec3 source) {
    return self->own && panes_transmit_from_afar(&self->black, view->eye, source) > 0;
}

static void add_lamps(Gatherer *self, const View *view, Arriving *to) {
    int occluders = -1;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        if (!mesh_emits(self->scene.mesh, f->face) || f->d > 0 ||
            !is_exact(&self->options, self->scene.mesh, f->face))
            continue;
        if (occluders < 0) occluders = find_occluders(self, view);
        AnalyticSight sight = {0};
        SpreadSight by_table =
            spread_sight(mesh_spread(self->scene.mesh, f->face), LAMP_SPREAD_OFF, view->x, view->y, view->z);
        double emitted[3];
        rgb_doubles(mesh_material(self->scene.mesh, f->face)->emission, emitted);
        analytic_visible(view->vertices + f->first_vertex, f->vertex_count, form_factor_rank(f),
                         self->occluder, occluders, by_table.spread ? spread_sight_add : analytic_sight_add,
                         by_table.spread ? (void *)&by_table : &sight);
        if (by_table.spread) sight = by_table.sight;
        if (!(sight.area > 0)) continue;
        // Panes of glass weaken all that is in sight as they do on the line to its middle.
        Vec3 middle = vec3_add(view->eye, in_building(view, vec3_scale(sight.moment, 1 / sight.area)));
        if (self->panes.count > 0) sight.share *= panes_transmit(&self->panes, view->eye, middle);
        for (int c = 0; c < 3; c++) emitted[c] *= sight.share;
        int element = self->scene.mesh->faces[f->face].first_element;
        arrive(emitted, emitted, passes_black(self, view, middle, element), to);
    }
}

// The shares of near elements in the light, and their light if they shone evenly.
typedef struct Near {
    double share, even[3];
} Near;

// Takes note of an element's share if it is near; its own emission is known all the same.
static bool put_near(Gatherer *self, int element, double share, bool means, Near *near, Arriving *to) {
    if (!self->near || !near_gatherer_is_near(self->near, element)) return false;
    if (!means) return true;
    double emitted[3] = {0};
    int face = self->scene.mesh->elements[element].face;
    if (!is_exact(&self->options, self->scene.mesh, face))
        rgb_doubles(mesh_material(self->scene.mesh, face)->emission, emitted);
    near->share += share;
    for (int c = 0; c < 3; c++) {
        to->all[c] += share * emitted[c];
        near->even[c] += share * (self->leaving[element][c] - emitted[c]);
    }
    return true;
}

static void add_near(Gatherer *self, const Near *near, Arriving *to) {
    double reflected[3];
    if (!(near->share > 0)) return;
    bool found = near_gatherer_mean(self->near, reflected);
    for (int c = 0; c < 3; c++) to->all[c] += found ? near->share * reflected[c] : near->even[c];
}

// Does a ray from the eye along w, in the view's axes, meet a face of the view?
static bool meets_face(const View *view, const ViewFace *f, Vec3 w) {
    const Vec3 *v = view->vertices + f->first_vertex;
    int left = 0, right = 0;
    if (!(f->d * vec3_dot(f->n, w) > 0)) return false;
    for (int i = 0; i < f->vertex_count; i++) {
        double side = vec3_dot(vec3_cross(v[i], v[i + 1 == f->vertex_count ? 0 : i + 1]), w);
        left += side >= 0;
        right += side <= 0;
    }
    return left == f->vertex_count || right == f->vertex_count;
}

static void add_sun(const Gatherer *self, const View *view, Arriving *to) {
    const Daylight *day = &self->scene.solution->day;
    Vec3 w = {vec3_dot(view->x, day->sun), vec3_dot(view->y, day->sun), vec3_dot(view->z, day->sun)};
    if (rgb_sum(day->beam) == 0 || !(w.z > 0)) return;
    for (int i = 0; i < view->face_count; i++)
        if (meets_face(view, &view->faces[i], w)) return;
    double share = w.z * panes_transmit_from_afar(&self->panes, view->eye, day->sun), light[3];
    for (int c = 0; c < 3; c++) light[c] = day->beam[c] * share;
    arrive(light, light, passes_black_from_afar(self, view, day->sun), to);
}

static void gather_row(Gatherer *self, const View *view, Near *near, Arriving *to, double *inside) {
    const Row *row = form_factor_row(self->rows, view);
    if (inside) *inside = row->back;
    for (int i = 0; i < row->count; i++) {
        int element = row->element[i];
        double share = (double)row->factor[i];
        Vec3 from =
            self->panes.count > 0 || self->own ? element_centroid(self->scene.mesh, element) : view->eye;
        if (self->panes.count > 0) share *= panes_transmit(&self->panes, view->eye, from);
        if (put_near(self, element, share, true, near, to)) continue;
        const double *mean = self->leaving[element];
        for (int c = 0; c < 3; c++) to->all[c] += share * mean[c];
        if (!passes_black(self, view, from, element)) continue;
        for (int c = 0; c < 3; c++) to->own[c] += share * self->own[element][c];
    }
    if (!self->sky_in_rows) return;
    bool projective = self->options.method->projective;
    double below[3], sky = projective ? row->sky_light : row->sky;
    daylight_below(&self->scene.solution->day, below);
    for (int c = 0; c < 3; c++)
        to->all[c] += M_PI * (sky * self->scene.solution->day.zenith[c] + row->ground_light * below[c]);
}

// A sample that meets nothing: of the sky, or of the ground.
static void add_sky_sample(Gatherer *self, const View *view, Vec3 along, double weight, Arriving *to) {
    double radiance[3];
    if (self->panes.count > 0) weight *= panes_transmit_from_afar(&self->panes, view->eye, along);
    daylight_radiance(&self->scene.solution->day, along, radiance);
    for (int c = 0; c < 3; c++) radiance[c] *= weight * M_PI;
    arrive(radiance, radiance, passes_black_from_afar(self, view, along), to);
}

// Samples where they meet elements: slopes, and with `means` all of it. A sky that is not even is left to samples in any case.
static void add_samples(Gatherer *self, const View *view, bool means, Near *near, Arriving *to,
                        double *inside) {
    const FormFactorSamples *samples = form_factor_samples(self->samples);
    const int32_t *item = form_factor_items(self->samples, view);
    bool sky = means || !self->sky_in_rows;
    double backs = 0;
    for (int i = 0; i < samples->count; i++) {
        Vec3 w = vec3((double)samples->x[i], (double)samples->y[i], (double)samples->z[i]);
        double weight = (double)samples->weight[i], light[3], own[3] = {0, 0, 0};
        if (item[i] < 0) {
            if (sky) add_sky_sample(self, view, in_building(view, w), weight, to);
            continue;
        }
        const ViewFace *face = &view->faces[item[i]];
        double along = vec3_dot(face->n, w);
        if (face->d > 0 || !(along < 0)) backs += weight;
        if (face->d > 0 || !(along < 0) || (!means && !self->scene.light)) continue;
        w = vec3_scale(w, face->d / along);
        Vec3 p = vec3_add(view->eye, in_building(view, w));
        int element = mesh_element_at(self->scene.mesh, face->face, p);
        if (self->panes.count > 0) weight *= panes_transmit(&self->panes, view->eye, p);
        if (put_near(self, element, weight, means, near, to)) continue;
        const Slope *slope = self->slope ? &self->slope[element] : NULL;
        for (int c = 0; c < 3; c++) {
            light[c] = weight * ((slope ? vec3_dot(slope->slope[c], p) - slope->offset[c] : 0) +
                                 (means ? self->leaving[element][c] : 0));
            if (self->own) own[c] = weight * self->own[element][c];
        }
        arrive(light, own, passes_black(self, view, p, element), to);
    }
    if (inside) *inside = backs;
}

void gather_apart(Gatherer *self, const ViewPoint *from, double irradiance[3], double own[3],
                  double *inside) {
    // Lamps and the sun ask for all faces, samples for those that they may see.
    bool one = self->samples == self->rows, few = (one || !self->samples) && self->options.reflected;
    const View *view = few ? form_factor_look(self->rows, self->viewer, from, self->options.culling)
                           : viewer_look(self->viewer, from, self->options.culling);
    Near near = {0};
    Arriving light = {{0}, {0}};
    Plane before = {from->normal, vec3_dot(from->normal, from->eye)};
    panes_seen(&self->scene.mesh->panes, self->scene.forest, from->cell, before, &self->panes);
    self->cell = from->cell;
    if (self->own) panes_seen(self->closed, self->scene.forest, from->cell, before, &self->black);
    if (self->near) near_gatherer_look(self->near, from->eye, from->normal);
    if (self->any_lamp) add_lamps(self, view, &light);
    if (!self->options.reflected) add_sun(self, view, &light);
    if (!one) gather_row(self, view, &near, &light, inside);
    if (self->samples) add_samples(self, view, one, &near, &light, one ? inside : NULL);
    add_near(self, &near, &light);
    // Samples may sum slopes to less than nothing beside exact means and exact lamps.
    for (int c = 0; c < 3; c++) irradiance[c] = fmax(light.all[c], 0);
    for (int c = 0; c < 3 && own; c++) own[c] = fmax(light.own[c], 0);
}

void gather(Gatherer *self, const ViewPoint *from, double irradiance[3]) {
    gather_apart(self, from, irradiance, NULL, NULL);
}

GatherRow gather_row_new(Gatherer *self, const ViewPoint *from, Arena *arena) {
    CORE_ASSERT(self->options.reflected && !self->near && !self->samples);
    const View *view = form_factor_look(self->rows, self->viewer, from, self->options.culling);
    Plane before = {from->normal, vec3_dot(from->normal, from->eye)};
    panes_seen(&self->scene.mesh->panes, self->scene.forest, from->cell, before, &self->panes);
    const Row *row = form_factor_row(self->rows, view);
    int *element = ARENA_ARRAY(arena, int, row->count + 1);
    float *share = ARENA_ARRAY(arena, float, row->count + 1);
    for (int i = 0; i < row->count; i++) {
        element[i] = row->element[i];
        share[i] = row->factor[i];
        if (self->panes.count > 0)
            share[i] *= (float)panes_transmit(&self->panes, view->eye,
                                              element_centroid(self->scene.mesh, row->element[i]));
    }
    int words = viewer_door_words(self->scene.mesh);
    uint64_t *doors = view->doors ? ARENA_ARRAY(arena, uint64_t, words + 1) : NULL;
    if (doors) memcpy(doors, view->doors, (size_t)words * sizeof *doors);
    SkyPart *part = ARENA_ARRAY(arena, SkyPart, row->sky_part_count + 1);
    if (row->sky_part_count > 0) {
        memcpy(part, row->sky_part, (size_t)row->sky_part_count * sizeof *part);
        sky_parts_fit(part, row->sky_part_count, &self->scene.solution->day, row->sky_light);
    }
    return (GatherRow){.count = row->count,
                       .element = element,
                       .share = share,
                       .backs = row->back,
                       .sky = row->sky_light,
                       .ground = row->ground_light,
                       .doors = doors,
                       .sky_part = part,
                       .sky_part_count = row->sky_part_count};
}

void gather_along(double (*leaving)[3], const Daylight *day, const GatherRow *row, double irradiance[3]) {
    double below[3];
    irradiance[0] = irradiance[1] = irradiance[2] = 0;
    for (int i = 0; i < row->count; i++) {
        const double *mean = leaving[row->element[i]];
        for (int c = 0; c < 3; c++) irradiance[c] += (double)row->share[i] * mean[c];
    }
    daylight_below(day, below);
    for (int c = 0; c < 3; c++) {
        irradiance[c] += M_PI * (row->sky * day->zenith[c] + row->ground * below[c]);
        irradiance[c] = fmax(irradiance[c], 0);
    }
}

int gather_cell(const CellGraph *graph, Vec3 point, Vec3 normal, int hint) {
    return vis_locate(graph, vec3_add(point, vec3_scale(normal, IN_FRONT)), hint);
}
