// soup_fixture.c - soups for tests. Turning follows O. Rodrigues 1840.
#include "tests/support/soup_fixture.h"

#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/support/support.h"

Building *soup_fixture_new(Arena *arena) {
    Building *b = ARENA_ARRAY(arena, Building, 1);
    b->form = FORM_SOUP;
    b->source = "soup";
    building_add_material(arena, b,
                          (Material){.name = "plaster", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    building_add_material(arena, b,
                          (Material){.name = "glass", .reflectance = {0.1f, 0.1f, 0.1f}, .alpha = 0.3f});
    building_add_object(arena, b, OBJECT_FURNITURE, "walls");
    return b;
}

void soup_fixture_quad(Arena *arena, Building *b, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material) {
    Vec3 v[4] = {p, q, r, s};
    building_add_polygon(arena, b, v, 4, material);
}

void soup_fixture_box(Arena *arena, Building *b, Vec3 l, Vec3 h, int m) {
    soup_fixture_quad(arena, b, vec3(l.x, l.y, l.z), vec3(h.x, l.y, l.z), vec3(h.x, h.y, l.z),
                      vec3(l.x, h.y, l.z), m);
    soup_fixture_quad(arena, b, vec3(l.x, l.y, h.z), vec3(h.x, l.y, h.z), vec3(h.x, h.y, h.z),
                      vec3(l.x, h.y, h.z), m);
    soup_fixture_quad(arena, b, vec3(l.x, l.y, l.z), vec3(h.x, l.y, l.z), vec3(h.x, l.y, h.z),
                      vec3(l.x, l.y, h.z), m);
    soup_fixture_quad(arena, b, vec3(l.x, h.y, l.z), vec3(h.x, h.y, l.z), vec3(h.x, h.y, h.z),
                      vec3(l.x, h.y, h.z), m);
    soup_fixture_quad(arena, b, vec3(l.x, l.y, l.z), vec3(l.x, h.y, l.z), vec3(l.x, h.y, h.z),
                      vec3(l.x, l.y, h.z), m);
    soup_fixture_quad(arena, b, vec3(h.x, l.y, l.z), vec3(h.x, h.y, l.z), vec3(h.x, h.y, h.z),
                      vec3(h.x, l.y, h.z), m);
}

static void upright(Arena *arena, Building *b, int axis, double at, double from, double to, double z0,
                    double z1) {
    Vec3 p = axis ? vec3(from, at, z0) : vec3(at, from, z0), q = axis ? vec3(to, at, z0) : vec3(at, to, z0);
    soup_fixture_quad(arena, b, p, q, vec3(q.x, q.y, z1), vec3(p.x, p.y, z1), 0);
}

void soup_fixture_wall(Arena *arena, Building *b, int axis, double at, double from, double to, double z0,
                       double z1, const double *holes, int hole_count, double head) {
    for (int i = 0; i < hole_count; i++) {
        upright(arena, b, axis, at, from, holes[2 * i], z0, z1);
        if (head < z1) upright(arena, b, axis, at, holes[2 * i], holes[2 * i + 1], head, z1);
        from = holes[2 * i + 1];
    }
    upright(arena, b, axis, at, from, to, z0, z1);
}

static void furnish(Arena *arena, Building *b, Random *random, double x, double y) {
    if (random_unit(random) < 0.5) return;
    Vec3 low = vec3(x + random_between(random, 0.3, 2), y + random_between(random, 0.3, 2), 0);
    building_add_object(arena, b, OBJECT_FURNITURE, "box");
    soup_fixture_box(arena, b, low,
                     vec3(low.x + random_between(random, 0.2, 1.4), low.y + random_between(random, 0.2, 1.4),
                          random_between(random, 0.4, 1.8)),
                     0);
}

Building *soup_fixture_house(Arena *arena, Random *random, int nx, int ny) {
    enum { SIDE = 4 };
    static const double HIGH = 2.5, HEAD = 2.1;
    Building *b = soup_fixture_new(arena);
    double w = nx * SIDE, d = ny * SIDE, rise = random_unit(random) < 0.5 ? 0 : 1.5;
    soup_fixture_quad(arena, b, vec3(0, 0, 0), vec3(w, 0, 0), vec3(w, d, 0), vec3(0, d, 0), 0);
    soup_fixture_quad(arena, b, vec3(0, 0, HIGH), vec3(0, d, HIGH), vec3(w, d, HIGH + rise),
                      vec3(w, 0, HIGH + rise), 0);
    for (int axis = 0; axis < 2; axis++) {
        int across = axis ? ny : nx, along = axis ? nx : ny;
        for (int i = 0; i <= across; i++) {
            for (int k = 0; k < along; k++) {
                double a = k * SIDE + random_between(random, 0.3, 2.5), hole[2] = {a, a + 0.9};
                bool open = i > 0 && i < across && random_unit(random) < 0.8;
                // Walls go on over the slanting roof, outside of the house.
                soup_fixture_wall(arena, b, axis, i * SIDE, k * SIDE, k * SIDE + SIDE, 0, HIGH + rise, hole,
                                  open, HEAD);
            }
        }
    }
    for (int i = 0; i < nx * ny; i++) furnish(arena, b, random, i % nx * SIDE, i / nx * SIDE);
    b->world = (Box){{0, 0, 0}, {w, d, HIGH + rise}};
    return b;
}

Building *soup_fixture_read(Arena *arena, const char *name, const char *own) {
    FILE *file = fopen(
        support_either(arena_format(arena, "radiosity/%s", name), arena_format(arena, "tests/seeds/%s", own)),
        "r");
    cr_assert_not_null(file);
    Building *b = soup_fixture_new(arena);
    char line[1024];
    while (fgets(line, sizeof line, file)) {
        double v[12], rho, exitance;
        if (sscanf(line, "quad %*s %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &rho, &exitance,
                   &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7], &v[8], &v[9], &v[10],
                   &v[11]) == 14)
            soup_fixture_quad(arena, b, vec3(v[0], v[1], v[2]), vec3(v[3], v[4], v[5]),
                              vec3(v[6], v[7], v[8]), vec3(v[9], v[10], v[11]), 0);
    }
    fclose(file);
    return b;
}

Vec3 soup_fixture_pose_point(const SoupPose *pose, Vec3 p) {
    Vec3 k = vec3_normalize(pose->axis);
    double c = cos(pose->angle), s = sin(pose->angle);
    Vec3 turned = vec3_add(vec3_add(vec3_scale(p, c), vec3_scale(vec3_cross(k, p), s)),
                           vec3_scale(k, vec3_dot(k, p) * (1 - c)));
    return vec3_add(vec3_scale(turned, pose->scale), pose->shift);
}

Building *soup_fixture_posed(Arena *arena, const Building *b, const SoupPose *pose) {
    Building *posed = ARENA_ARRAY(arena, Building, 1);
    *posed = *b;
    posed->vertices = ARENA_ARRAY(arena, Vec3, b->vertex_count);
    for (int i = 0; i < b->vertex_count; i++)
        posed->vertices[i] = soup_fixture_pose_point(pose, b->vertices[i]);
    return posed;
}

int soup_fixture_inside(const Vec3 *v, int count, Vec3 p, double doubt) {
    Plane plane = plane_of_polygon(v, count);
    if (fabs(plane_distance(plane, p)) > doubt) return -1;
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_normalize(vec3_sub(v[(i + 1) % count], v[i]));
        least = fmin(least, vec3_dot(vec3_cross(plane.n, edge), vec3_sub(p, v[i])));
    }
    return least > doubt ? 1 : least < -doubt ? 0 : -1;
}

static int by_start(const void *p, const void *q) {
    const Crossing *a = p, *b = q;
    return (a->from > b->from) - (a->from < b->from);
}

int soup_fixture_crossings(const CellGraph *graph, Vec3 from, Vec3 direction, Crossing *out, int max) {
    int count = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        double in = -INFINITY, leave = INFINITY;
        for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++) {
            double off = plane_distance(graph->faces[i], from), rate = vec3_dot(graph->faces[i].n, direction);
            if (rate > 0) in = fmax(in, -off / rate);
            if (rate < 0) leave = fmin(leave, -off / rate);
            if (rate == 0 && off < 0) in = INFINITY;
        }
        if (in >= leave) continue;
        cr_assert_lt(count, max);
        out[count++] = (Crossing){c, in, leave};
    }
    qsort(out, (size_t)count, sizeof *out, by_start);
    return count;
}

Vec3 soup_fixture_point(const CellGraph *graph, Random *random, int c) {
    const Cell *cell = &graph->cells[c];
    for (;;) {
        Vec3 p = vec3(random_between(random, cell->box.min.x, cell->box.max.x),
                      random_between(random, cell->box.min.y, cell->box.max.y),
                      random_between(random, cell->box.min.z, cell->box.max.z));
        bool inside = true;
        for (int i = cell->first_face; i < cell->first_face + cell->face_count && inside; i++)
            inside = plane_distance(graph->faces[i], p) > 0;
        if (inside) return p;
    }
}
