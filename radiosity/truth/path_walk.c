// path_walk.c - random walks from a point (Kajiya 1986, The Rendering Equation): at each surface one lamp is asked for its light,
// and one direction followed, distributed as cosines; both may find the same lamp, and are weighed by the balance heuristic
// (Veach & Guibas 1995), so that lamps close by are found by directions and small ones by asking. A walk goes on as often as the
// surface reflects (Russian roulette); backs absorb.
//
// The numbers of the first bounces are a lattice's (Korobov 1959; its multiplier: L'Ecuyer & Lemieux 2000), shifted at random for
// each block of walks: blocks are independent.
#include "radiosity/truth/path_walk.h"

enum { MULTIPLIER = 76 };  // of the lattice

PathWorld path_world(const Mesh *mesh, const double sky[3], Arena *arena) {
    PathWorld world = {.mesh = mesh, .scene = path_scene_new(mesh, arena)};
    world.lights = path_lights_new(world.scene, arena);
    for (int c = 0; c < 3; c++) world.sky[c] = sky ? sky[c] : 0;
    return world;
}

void path_world_end(PathWorld *world) { path_scene_end(world->scene); }

// ---- numbers

PathNumbers path_numbers(uint64_t seed, long long block) {
    Random mix = {seed};
    PathNumbers lattice = {.random = {random_next(&mix) + (uint64_t)block * 0xd1342543de82ef95u}};
    int generator = 1;
    for (int k = 0; k < PATH_LATTICE_BOUNCES * PATH_NUMBERS; k++) {
        lattice.shift[k] = random_unit(&lattice.random);
        lattice.generator[k] = generator;
        generator = generator * MULTIPLIER % PATH_BLOCK;
    }
    return lattice;
}

void path_numbers_at(PathNumbers *lattice, int bounce, double u[PATH_NUMBERS]) {
    for (int k = 0; k < PATH_NUMBERS; k++) {
        if (bounce >= PATH_LATTICE_BOUNCES) {
            u[k] = random_unit(&lattice->random);
            continue;
        }
        int at = bounce * PATH_NUMBERS + k;
        double x =
            (double)(lattice->path * lattice->generator[at] % PATH_BLOCK) / PATH_BLOCK + lattice->shift[at];
        u[k] = x < 1 ? x : x - 1;
    }
}

// ---- one path

static void add_light(double light[3], const double weight[3], Rgb from, double by) {
    light[0] += weight[0] * (double)from.r * by;
    light[1] += weight[1] * (double)from.g * by;
    light[2] += weight[2] * (double)from.b * by;
}

// The density of directions, 1/sr, with which a point at `to` is chosen where points of its face are with `density`.
static double as_directions(double density, Vec3 to, Vec3 normal) {
    double d2 = vec3_dot(to, to), across = -vec3_dot(to, normal);
    return across > 0 ? density * d2 * sqrt(d2) / across : 0;
}

// The share of a lamp's light that arrives, asked for, and weighed.
static void ask_lamp(const PathWorld *world, const PathPlace *place, const double u[PATH_NUMBERS],
                     const double weight[3], double light[3]) {
    PathLightPoint lamp;
    if (!path_lights_choose(world->lights, place, u + PATH_LAMP, &lamp)) return;
    Vec3 to = vec3_sub(lamp.point, place->point);
    double cosine = vec3_dot(place->normal, vec3_normalize(to)) / M_PI;
    double asked = as_directions(lamp.density, to, world->mesh->faces[lamp.face].plane.n);
    if (!(cosine > 0) || !(asked > 0)) return;
    PathHit hit = path_scene_trace(world->scene, place->point, vec3_normalize(to));
    if (hit.face != lamp.face) return;
    add_light(light, weight, mesh_material(world->mesh, lamp.face)->emission, cosine / (asked + cosine));
}

Vec3 path_direction(Vec3 normal, double u, double v) {
    double r = sqrt(u), angle = 2 * M_PI * v;
    Vec3 axis = fabs(normal.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
    Vec3 x = vec3_normalize(vec3_cross(axis, normal)), y = vec3_cross(normal, x);
    return vec3_normalize(vec3_add(vec3_scale(normal, sqrt(1 - u)),
                                   vec3_add(vec3_scale(x, r * cos(angle)), vec3_scale(y, r * sin(angle)))));
}

bool path_reflect(const Material *m, double u, double weight[3]) {
    weight[0] *= (double)m->reflectance.r;
    weight[1] *= (double)m->reflectance.g;
    weight[2] *= (double)m->reflectance.b;
    double goes_on = fmax(weight[0], fmax(weight[1], weight[2]));
    if (!(u < goes_on)) return false;
    for (int c = 0; c < 3; c++) weight[c] /= goes_on;
    return true;
}

// Follows a direction; false: the path ends there.
static bool follow_path(const PathWorld *world, PathPlace *place, const double u[PATH_NUMBERS],
                        const PathEnd *end, double weight[3], double light[3]) {
    Vec3 along = path_direction(place->normal, u[PATH_DIRECTION], u[PATH_DIRECTION + 1]);
    PathHit hit = path_scene_trace(world->scene, place->point, along);
    if (hit.face < 0)
        for (int c = 0; c < 3 && along.z > 0; c++) light[c] += weight[c] * M_PI * world->sky[c];
    if (hit.face < 0 || !hit.front) return false;
    const Material *m = mesh_material(world->mesh, hit.face);
    Vec3 n = world->mesh->faces[hit.face].plane.n;
    double density = path_lights_density(world->lights, place, hit.face);
    double asked = as_directions(density, vec3_sub(hit.point, place->point), n);
    double cosine = vec3_dot(place->normal, along) / M_PI;
    if (cosine > 0) add_light(light, weight, m->emission, cosine / (asked + cosine));
    double reflected[3];
    if (end && end->known(end->context, place->point, &hit, reflected)) {
        for (int c = 0; c < 3; c++) light[c] += weight[c] * reflected[c];
        return false;
    }
    if (!path_reflect(m, u[PATH_ROULETTE], weight)) return false;
    *place = (PathPlace){path_scene_before(world->scene, hit.face, hit.point), n};
    return true;
}

void path_walk(const PathWorld *world, PathPlace place, PathNumbers *numbers, int bounce, const PathEnd *end,
               double weight[3], double light[3]) {
    double u[PATH_NUMBERS];
    bool on = true;
    for (; on; bounce++) {
        path_numbers_at(numbers, bounce, u);
        ask_lamp(world, &place, u, weight, light);
        on = follow_path(world, &place, u, end, weight, light);
    }
}
