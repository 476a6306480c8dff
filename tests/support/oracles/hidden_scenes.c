// hidden_scenes.c - random polygons of the kinds that hidden-surface methods are known to fail on.
#include "tests/support/oracles/hidden_scenes.h"

#define PI 3.14159265358979323846

const char *const HIDDEN_KIND_NAMES[SCENE_KINDS] = {"plain",   "rings",   "crossing", "coplanar",
                                                    "edge-on", "through", "slivers",  "huge",
                                                    "tiny",    "close",   "mixed"};

void hidden_soup_add(Arena *arena, HiddenSoup *soup, const Vec3 *vertices, int count) {
    *ARENA_PUSH(arena, soup->polygons, soup->polygon_count, soup->polygon_capacity) =
        (Polygon){soup->vertex_count, count, 0, 0};
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(arena, soup->vertices, soup->vertex_count, soup->vertex_capacity) = vertices[i];
}

Vec3 hidden_direction(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * PI), s = sqrt(1 - z * z);
    return vec3(s * cos(a), s * sin(a), z);
}

static Vec3 across(Vec3 n) {
    return vec3_normalize(vec3_cross(n, fabs(n.z) > 0.9 ? vec3(1, 0, 0) : vec3(0, 0, 1)));
}

void hidden_soup_ellipse(Arena *arena, HiddenSoup *soup, Random *random, Vec3 centre, Vec3 n, double a,
                         double b) {
    Vec3 u = across(n), v = vec3_cross(n, u);
    double start = random_between(random, 0, 2 * PI);
    int count = 3 + random_index(random, 4);
    Vec3 p[7];
    for (int i = 0; i < count; i++) {
        double t = start + 2 * PI * i / count;
        p[i] = vec3_add(centre, vec3_add(vec3_scale(u, a * cos(t)), vec3_scale(v, b * sin(t))));
    }
    if (random_index(random, 3) == 0) {
        p[count] = vec3_lerp(p[count - 1], p[0], 0.5);
        count++;
    }
    hidden_soup_add(arena, soup, p, count);
}

static double side(Random *random) { return random_between(random, 0.05, 3); }

static Vec3 somewhere(Random *random, Vec3 eye, double least, double most) {
    return vec3_add(eye, vec3_scale(hidden_direction(random), random_between(random, least, most)));
}

static Vec3 axis_of(Random *random) {
    int axis = random_index(random, 3);
    return vec3(axis == 0, axis == 1, axis == 2);
}

static void copy_one(Arena *arena, HiddenSoup *soup, Random *random) {
    Polygon p = soup->polygons[random_index(random, soup->polygon_count)];
    Vec3 copy[8];
    for (int k = 0; k < p.vertex_count; k++) copy[k] = soup->vertices[p.first_vertex + k];
    hidden_soup_add(arena, soup, copy, p.vertex_count);
}

static void add_plain(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    Vec3 centre = somewhere(random, eye, 0.5, 10);
    int kind = random_index(random, 10);
    if (kind == 0 && soup->polygon_count > 0) {
        copy_one(arena, soup, random);
    } else if (kind == 1) {
        Vec3 n = vec3_normalize(vec3_cross(hidden_direction(random), vec3_sub(centre, eye)));
        hidden_soup_ellipse(arena, soup, random, centre, n, side(random), side(random));
    } else {
        Vec3 n = kind < 5 ? axis_of(random) : hidden_direction(random);
        hidden_soup_ellipse(arena, soup, random, centre, n, side(random), side(random));
    }
}

HiddenSoup hidden_soup_plain(Arena *arena, Random *random, Vec3 eye, int count) {
    HiddenSoup soup = {0};
    while (soup.polygon_count < count) add_plain(arena, &soup, random, eye);
    return soup;
}

// Bars about an axis that looks at the eye, each over the next one at one end and under the one before at the other.
static void add_ring(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    Vec3 centre = somewhere(random, eye, 3, 8), n = vec3_normalize(vec3_sub(centre, eye)), u = across(n),
         v = vec3_cross(n, u);
    int bars = 3 + random_index(random, 4);
    double tilt = random_between(random, 0.01, 0.5) * (random_index(random, 2) ? 1 : -1),
           start = random_unit(random);
    for (int i = 0; i < bars; i++) {
        double t = 2 * PI * (i + start) / bars;
        Vec3 out = vec3_add(vec3_scale(u, cos(t)), vec3_scale(v, sin(t)));
        Vec3 along = vec3_add(vec3_scale(u, -sin(t)), vec3_scale(v, cos(t)));
        Vec3 middle = vec3_add(centre, out), half = vec3_scale(vec3_add(along, vec3_scale(n, tilt)), 2.5);
        Vec3 wide = vec3_scale(out, 0.3);
        Vec3 p[4] = {vec3_sub(vec3_sub(middle, half), wide), vec3_sub(vec3_add(middle, half), wide),
                     vec3_add(vec3_add(middle, half), wide), vec3_add(vec3_sub(middle, half), wide)};
        hidden_soup_add(arena, soup, p, 4);
    }
}

static void add_coplanar(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    if (soup->polygon_count > 0 && random_index(random, 3) == 0) {
        copy_one(arena, soup, random);
        return;
    }
    // Six planes, a box around the eye.
    int axis = random_index(random, 3);
    double off = random_index(random, 2) ? 2 : -3;
    double at[3] = {random_between(random, -3, 3), random_between(random, -3, 3),
                    random_between(random, -3, 3)};
    at[axis] = off;
    Vec3 n = vec3(axis == 0, axis == 1, axis == 2);
    hidden_soup_ellipse(arena, soup, random, vec3_add(eye, vec3(at[0], at[1], at[2])), n, side(random),
                        side(random));
}

static void add_edge_on(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    Vec3 centre = somewhere(random, eye, 0.5, 10);
    Vec3 n = vec3_normalize(vec3_cross(hidden_direction(random), vec3_sub(centre, eye)));
    double off = random_index(random, 2) ? 0 : pow(10, random_between(random, -8, -2));
    hidden_soup_ellipse(arena, soup, random, vec3_add(centre, vec3_scale(n, off)), n, side(random),
                        side(random));
}

static void add_through(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    Vec3 n = random_index(random, 2) ? axis_of(random) : hidden_direction(random);
    double off = random_between(random, 0.01, 3) * (random_index(random, 2) ? 1 : -1),
           size = random_between(random, 1, 30);
    hidden_soup_ellipse(arena, soup, random, vec3_add(eye, vec3_scale(n, off)), n, size,
                        random_between(random, 1, 30));
}

// An earlier one, or a new one, and a copy of it a little nearer or farther.
static void add_close(Arena *arena, HiddenSoup *soup, Random *random, Vec3 eye) {
    add_plain(arena, soup, random, eye);
    Polygon p = soup->polygons[random_index(random, soup->polygon_count)];
    double scale = 1 + pow(10, random_between(random, -8, -6)) * (random_index(random, 2) ? 1 : -1);
    Vec3 copy[8];
    for (int k = 0; k < p.vertex_count; k++) {
        Vec3 v = soup->vertices[p.first_vertex + k];
        copy[k] = vec3_add(eye, vec3_scale(vec3_sub(v, eye), scale));
    }
    hidden_soup_add(arena, soup, copy, p.vertex_count);
}

static void add_one(Arena *arena, HiddenSoup *soup, Random *random, HiddenKind kind, Vec3 eye) {
    Vec3 n = hidden_direction(random);
    switch (kind) {
    case SCENE_RINGS:
        add_ring(arena, soup, random, eye);
        return;
    case SCENE_CROSSING:
        hidden_soup_ellipse(arena, soup, random, somewhere(random, eye, 1, 5), n,
                            random_between(random, 1, 6), random_between(random, 1, 6));
        return;
    case SCENE_CLOSE:
        add_close(arena, soup, random, eye);
        return;
    case SCENE_COPLANAR:
        add_coplanar(arena, soup, random, eye);
        return;
    case SCENE_EDGE_ON:
        add_edge_on(arena, soup, random, eye);
        return;
    case SCENE_THROUGH:
        add_through(arena, soup, random, eye);
        return;
    case SCENE_SLIVERS:
        hidden_soup_ellipse(arena, soup, random, somewhere(random, eye, 0.5, 10), n, side(random),
                            pow(10, random_between(random, -7, -2)));
        return;
    case SCENE_HUGE: {
        double size = pow(10, random_between(random, 3, 7));
        hidden_soup_ellipse(arena, soup, random, somewhere(random, eye, 1, 3 * size), n, size,
                            size * random_unit(random));
        return;
    }
    case SCENE_TINY:
        hidden_soup_ellipse(arena, soup, random, somewhere(random, eye, 2, 5), n, 0.1 * random_unit(random),
                            0.1 * random_unit(random));
        return;
    default:
        add_plain(arena, soup, random, eye);
    }
}

HiddenSoup hidden_soup_new(Arena *arena, Random *random, HiddenKind kind, Vec3 eye, int count) {
    HiddenSoup soup = {0};
    while (soup.polygon_count < count)
        add_one(arena, &soup, random,
                kind == SCENE_MIXED ? (HiddenKind)random_index(random, SCENE_MIXED) : kind, eye);
    return soup;
}

Camera hidden_camera(Random *random, Vec3 eye, int width, int height) {
    return camera_look(eye, random_between(random, -PI, PI), random_between(random, -1.5, 1.5),
                       random_between(random, 0.3, 2.2), width, height);
}
