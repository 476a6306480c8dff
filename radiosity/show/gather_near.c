// gather_near.c - one radiosity for all of an element says nothing about light that changes within centimetres: behind a cabinet, or in a
// corner. From surfaces that are close to a point for the size of their elements light is brought by random walks (path_walk.c),
// which end where they meet an element from afar, for then all of it is in sight (Jensen 1996, Global Illumination Using Photon Maps,
// section 4, gathers anew from what is near for the same reason). Nor is an element trusted from afar that lies in a crowd itself.
//
// Shares of light are the caller's, exact ones at best; walks tell the mean of what comes by the near ones. All points take the same
// random numbers, so that what a point gathers depends on it alone, and changes little from a point to the next.
#include "radiosity/show/gather_near.h"

#include <limits.h>
#include <string.h>

#include "radiosity/show/reconstruct.h"
#include "radiosity/truth/path_walk.h"

// For a standard error at all: of so few it is right to a quarter.
enum { FEWEST_BLOCKS = 8 };
static const uint64_t SEED = 1;
// Looks that tell whether a place is crowded, and the share of them that must meet what is close: an element beside a wall has a
// quarter of them, one in a slit nine tenths.
enum { LOOKS = 64 };
static const double CROWDED = 0.3;

// Chosen together, on office-plain, a home and the reference rooms: an error of half a percent, as far as 32 blocks go.
NearOptions near_default_options(void) { return (NearOptions){.reach = 1.5, .error = 0.005, .blocks = 32}; }

struct NearGatherer {
    PathWorld world;
    const RadSolution *solution;
    NearOptions options;
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

NearGatherer *near_gatherer_new(const Mesh *mesh, const RadSolution *solution, const NearOptions *options,
                                Arena *arena) {
    NearGatherer *self = ARENA_ARRAY(arena, NearGatherer, 1);
    *self = (NearGatherer){.world = path_world(mesh, solution->sky, arena),
                           .solution = solution,
                           .options = *options,
                           .size = ARENA_ARRAY(arena, double, mesh->element_count),
                           .known = ARENA_ARRAY(arena, int, mesh->element_count),
                           .trust = ARENA_ARRAY(arena, unsigned char, mesh->element_count)};
    for (int e = 0; e < mesh->element_count; e++) self->size[e] = size_of(mesh, e);
    return self;
}

void near_gatherer_end(NearGatherer *self) { path_world_end(&self->world); }

// ---- what is near

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
    return mesh_element_at(self->world.mesh, hit->face, vec3_add(hit->point, self->world.scene->origin));
}

// ---- what is crowded

// Looks from one place or several: how many have met what is close for its element, and how many a back.
typedef struct Looks {
    int close, backs;
} Looks;

static void look_once(const NearGatherer *self, Vec3 from, Vec3 normal, Random *random, Looks *looks) {
    double u = random_unit(random);
    PathHit hit = path_scene_trace(self->world.scene, from, path_direction(normal, u, random_unit(random)));
    if (hit.face < 0) return;
    double distance = vec3_length(vec3_sub(hit.point, from));
    looks->backs += !hit.front;
    looks->close += hit.front && distance < self->options.reach * self->size[element_of(self, &hit)];
}

static bool is_eye_crowded(const NearGatherer *self) {
    const PathScene *scene = self->world.scene;
    Vec3 from = path_scene_off(scene, vec3_sub(self->eye, scene->origin), self->normal);
    Random random = {SEED};
    Looks looks = {0};
    for (int i = 0; i < LOOKS; i++) look_once(self, from, self->normal, &random, &looks);
    return looks.close + looks.backs > CROWDED * LOOKS;
}

// From points between its middle and each of its corners in turn. Where some look from an element meets a back, part of it may
// lie inside of what is closed, however well the rest is lit.
static bool is_element_crowded(const NearGatherer *self, int element) {
    const Mesh *mesh = self->world.mesh;
    const Element *e = &mesh->elements[element];
    Vec3 middle = element_centroid(mesh, element), n = mesh->faces[e->face].plane.n;
    Random random = {SEED + (uint64_t)element};
    Looks looks = {0};
    for (int i = 0; i < LOOKS; i++) {
        Vec3 corner = mesh->vertices[mesh->corners[e->first_corner + i % e->corner_count]];
        Vec3 p = vec3_sub(vec3_lerp(middle, corner, sqrt(random_unit(&random))), self->world.scene->origin);
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

void near_gatherer_look(NearGatherer *self, Vec3 eye, Vec3 normal) {
    if (++self->look > INT_MAX / 2 - 1) {
        // Come round: forget what was long ago.
        memset(self->known, 0, (size_t)self->world.mesh->element_count * sizeof *self->known);
        self->look = 1;
    }
    self->eye = eye;
    self->normal = normal;
    self->crowded = is_eye_crowded(self);
}

bool near_gatherer_is_near(NearGatherer *self, int element) {
    if (self->known[element] / 2 != self->look) {
        const Mesh *mesh = self->world.mesh;
        double within = self->options.reach * self->size[element];
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
    if (distance < self->options.reach * self->size[element] || is_crowded(self, element)) return false;
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
    if (!path_reflect(mesh_material(world->mesh, hit->face), u[PATH_ROULETTE], weight)) return;
    PathPlace place = {path_scene_before(world->scene, hit->face, hit->point),
                       world->mesh->faces[hit->face].plane.n};
    path_walk(world, place, numbers, 1, &(PathEnd){is_known, self}, weight, light);
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

bool near_gatherer_mean(NearGatherer *self, double reflected[3]) {
    const PathWorld *world = &self->world;
    Vec3 from = path_scene_off(world->scene, vec3_sub(self->eye, world->scene->origin), self->normal);
    Sums sums = {0};
    double squares = 0, light = 0;
    for (int n = 1; n <= self->options.blocks; n++) {
        PathNumbers numbers = path_numbers(SEED, n);
        double before = all_of(&sums);
        for (numbers.path = 0; numbers.path < PATH_BLOCK; numbers.path++)
            add_walk(self, from, &numbers, &sums);
        light = all_of(&sums);
        squares += (light - before) * (light - before);
        double variance = fmax(squares / n - light / n * (light / n), 0);
        if (n >= FEWEST_BLOCKS && sqrt(variance / (n - 1)) <= self->options.error * light / n) break;
    }
    for (int c = 0; c < 3 && sums.near_count > 0; c++) reflected[c] = sums.near[c] / (double)sums.near_count;
    return sums.near_count > 0;
}
