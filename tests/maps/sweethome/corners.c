// corners.c - the comparison of corners.h.
#include "tests/maps/sweethome/corners.h"

#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"

// The bar of the project: texture corners within 2 cm of the program's.
static const double NEAR = 0.02;
// How far before a triangle an eye would have to be at least, metres. More than the 1 mm by which the grid of plans moves our surfaces,
// less than anything that one sees through.
static const double BEFORE = 0.002;
// Backs of baseboards, which the program draws, lie a centimetre or more behind our boards' faces, metres.
static const double SAME_PLANE = 0.002;
// Narrower triangles, of mouldings, lie nearer to their neighbours than figures can tell apart, metres.
static const double SLIVER = 0.005;

// Points of a triangle, by shares of its corners in steps of 1 / SHARES, at which it is looked at.
enum { SHARES = 5 };

typedef struct Triangle {
    char kind[16];
    int width, height;  // of the picture
    Vec3 p[3];
    Vec2 place[3];
} Triangle;

// A prism in which nothing is seen, or a gap in such prisms.
typedef struct Solid {
    bool gap;
    double low, high, a, b;  // up to high + a x + b y
    Vec2 *outline;           // [count]
    int count;
} Solid;

// The file of figures.
typedef struct Figures {
    Solid *solids;
    Triangle *triangles;
    int solid_count, triangle_count, solid_capacity, triangle_capacity;
} Figures;

// A surface of the building and how far it is from the triangle.
typedef struct Surface {
    int material, map;
    double off;
} Surface;

typedef struct Search {
    const Building *b;
    const Triangle *t;
    Vec3 middle, n;
    bool sized;  // the picture has the sides that the figures say
    Surface best;
    double worst;  // of the best
} Search;

static void read_solid(const char *line, Arena *arena, Solid *out) {
    int at = 0, more;
    *out = (Solid){.gap = strncmp(line, "gap", 3) == 0};
    cr_assert_eq(sscanf(line, "%*s %lf %lf %lf %lf%n", &out->low, &out->high, &out->a, &out->b, &at), 4, "%s",
                 line);
    out->outline = ARENA_ARRAY(arena, Vec2, strlen(line) / 4);
    for (Vec2 p; sscanf(line + at, "%lf %lf%n", &p.x, &p.y, &more) == 2; at += more)
        out->outline[out->count++] = p;
}

static void read_triangle(const char *line, Triangle *t) {
    double v[15];
    int used = 0;
    cr_assert_eq(sscanf(line, "%15s %dx%d%n", t->kind, &t->width, &t->height, &used), 3, "%s", line);
    for (int i = 0, at = used, more; i < 15; i++, at += more)
        cr_assert_eq(sscanf(line + at, "%lf%n", &v[i], &more), 1, "%s", line);
    for (int i = 0; i < 3; i++) {
        t->p[i] = vec3(v[5 * i], v[5 * i + 1], v[5 * i + 2]);
        t->place[i] = vec2(v[5 * i + 3], v[5 * i + 4]);
    }
}

static Figures read_figures(const char *path, Arena *arena) {
    Figures f = {0};
    Bytes content;
    Error error;
    cr_assert(file_read(path, SIZE_MAX, arena, &content, &error), "%s", error.text);
    char *text = arena_format(arena, "%.*s", (int)content.size, (const char *)content.data), *rest = NULL;
    for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        if (strncmp(line, "gap ", 4) == 0 || strncmp(line, "solid ", 6) == 0)
            read_solid(line, arena, ARENA_PUSH(arena, f.solids, f.solid_count, f.solid_capacity));
        else
            read_triangle(line, ARENA_PUSH(arena, f.triangles, f.triangle_count, f.triangle_capacity));
    }
    return f;
}

// ---- what nobody sees

static bool in_solid(const Figures *f, Vec3 p) {
    bool solid = false;
    for (int i = 0; i < f->solid_count; i++) {
        const Solid *s = &f->solids[i];
        if (p.z <= s->low || p.z >= s->high + s->a * p.x + s->b * p.y ||
            !ring_contains(s->outline, s->count, vec2(p.x, p.y)))
            continue;
        if (s->gap) return false;
        solid = true;
    }
    return solid;
}

// ---- how far pictures are apart

// The gradient of a quantity known at the corners, in the triangle's plane.
static Vec3 gradient(const Triangle *t, double a, double b, double c) {
    Vec3 x = vec3_sub(t->p[1], t->p[0]), y = vec3_sub(t->p[2], t->p[0]);
    double xx = vec3_dot(x, x), xy = vec3_dot(x, y), yy = vec3_dot(y, y), det = xx * yy - xy * xy;
    return vec3_add(vec3_scale(x, ((b - a) * yy - (c - a) * xy) / det),
                    vec3_scale(y, ((c - a) * xx - (b - a) * xy) / det));
}

// How far apart two places in a picture that repeats are, metres; `gradient` is repetitions a metre. Half a texel of `side` is nothing: so
// much may a single map for a face of four corners be off, and where a picture is drawn out to a streak metres mean nothing.
static double apart(double a, double b, double gradient, int side) {
    double off = fabs(a - b - nearbyint(a - b));
    return off < 0.5 / side ? 0 : off / gradient;
}

// The farthest that our picture lies from the program's at a corner, metres.
static double error_of(const Building *b, const Triangle *t, int map) {
    double along_u = vec3_length(gradient(t, t->place[0].x, t->place[1].x, t->place[2].x)),
           along_v = vec3_length(gradient(t, t->place[0].y, t->place[1].y, t->place[2].y)), worst = 0;
    const TextureMap *m = &b->texture_maps[map];
    for (int i = 0; i < 3; i++) {
        double u = vec3_dot(m->u, t->p[i]) + m->u0, v = vec3_dot(m->v, t->p[i]) + m->v0;
        worst = fmax(worst, hypot(apart(u, t->place[i].x, along_u, t->width),
                                  apart(v, t->place[i].y, along_v, t->height)));
    }
    return worst;
}

static void consider(Search *s, int material, int map, double off) {
    if (material < 0) return;
    const Material *m = &s->b->materials[material];
    if (map == 0) map = m->texture_map;
    if (m->texture == 0 || map == 0) return;
    const Texture *texture = &s->b->textures[m->texture];
    if (s->sized && (texture->width != s->t->width || texture->height != s->t->height)) return;
    double worst = error_of(s->b, s->t, map);
    if (off > (strcmp(s->t->kind, "board") == 0 ? SAME_PLANE : NEAR)) return;
    // The nearest; of those in one place the best.
    if (off > s->best.off + 1e-3 || (off > s->best.off - 1e-3 && worst >= s->worst)) return;
    s->best = (Surface){material, map, off};
    s->worst = worst;
}

// ---- the surface of ours

static int wall_material(const Building *b, int edge, double z) {
    int material = b->edge_material[edge];
    for (int i = building_first_band(b, edge); i < b->band_count && b->bands[i].edge == edge; i++)
        if (b->bands[i].from < z) material = b->bands[i].material;
    return material;
}

static void search_regions(Search *s) {
    const Building *b = s->b;
    Vec3 c = s->middle;
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        bool inside = false;
        for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
            const Ring *ring = &b->rings[k];
            const Vec2 *p = &b->points[ring->first_point];
            inside ^= ring_contains(p, ring->point_count, vec2(c.x, c.y));
            for (int e = 0; e < ring->point_count && fabs(s->n.z) < 0.1 && c.z > r->z0 && c.z < r->z1; e++) {
                Vec2 a = p[e], along = vec2_sub(p[(e + 1) % ring->point_count], a),
                     to = vec2_sub(vec2(c.x, c.y), a);
                double length = vec2_length(along), t = vec2_dot(to, along) / length;
                if (fabs(along.x * s->n.x + along.y * s->n.y) > 0.05 * length || t < 0 || t > length)
                    continue;
                consider(s, wall_material(b, ring->first_point + e, c.z), 0,
                         fabs(vec2_cross(along, to)) / length);
            }
        }
        bool ground = strcmp(s->t->kind, "ground") == 0;
        if (ground ? r->kind != REGION_OUTDOORS : !inside || fabs(s->n.z) < 0.9) continue;
        consider(s, r->floor_material, 0, ground ? 0 : fabs(c.z - r->z0));
        if (!ground) consider(s, r->ceiling_material, 0, fabs(c.z - r->z1));
    }
}

static void search_polygons(Search *s) {
    const Building *b = s->b;
    for (int i = 0; i < b->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        const Vec3 *v = &b->vertices[p->first_vertex];
        Plane plane = plane_of_polygon(v, p->vertex_count);
        double off = fabs(vec3_dot(plane.n, s->middle) - plane.d);
        bool inside = off < NEAR && fabs(vec3_dot(plane.n, s->n)) > 0.99;
        for (int k = 0; inside && k < p->vertex_count; k++) {
            Vec3 edge = vec3_sub(v[(k + 1) % p->vertex_count], v[k]);
            inside = vec3_dot(vec3_cross(plane.n, edge), vec3_sub(s->middle, v[k])) > -1e-6;
        }
        if (inside) consider(s, p->material, p->texture_map, off);
    }
}

// ---- the comparison

// A point of the triangle by its shares of the corners.
static Vec3 point_of(const Triangle *t, double a, double b) {
    return vec3_add(vec3_add(vec3_scale(t->p[0], a), vec3_scale(t->p[1], b)), vec3_scale(t->p[2], 1 - a - b));
}

// Whether one of ours lies at the point and shows what the triangle shows there; `worst` of the nearest one.
static bool find_surface(Search s, double *worst) {
    if (strcmp(s.t->kind, "board") != 0) search_regions(&s);
    search_polygons(&s);
    *worst = s.worst;
    return s.best.material >= 0;
}

static void compare_triangle(const Building *b, const Figures *f, const Triangle *t, bool sized,
                             CornersTally *tally) {
    Vec3 n = vec3_cross(vec3_sub(t->p[1], t->p[0]), vec3_sub(t->p[2], t->p[0]));
    double size = vec3_length(n), longest = 0;
    for (int i = 0; i < 3; i++) longest = fmax(longest, vec3_length(vec3_sub(t->p[i], t->p[(i + 1) % 3])));
    if (size < 1e-9 || size < SLIVER * longest) return;
    n = vec3_scale(n, 1 / size);
    bool seen = false, missing = false, off = false;
    for (int i = 1; i < SHARES; i++) {
        for (int k = 1; i + k < SHARES; k++) {
            Vec3 at = point_of(t, (double)i / SHARES, (double)k / SHARES);
            double worst;
            if (in_solid(f, vec3_add(at, vec3_scale(n, BEFORE)))) continue;
            bool first = !missing && !off;
            seen = true;
            Search s = {.b = b,
                        .t = t,
                        .n = n,
                        .middle = at,
                        .sized = sized,
                        .best = {-1, 0, NEAR},
                        .worst = INFINITY};
            if (!find_surface(s, &worst))
                missing = true;
            else if (worst >= NEAR)
                off = true;
            else
                continue;
            if (getenv("CORNERS_LIST") && first)
                fprintf(stderr,
                        "%s of %dx%d at (%.3f, %.3f, %.3f), seen from (%.2f, %.2f, %.2f), area %.4f: %.3f m "
                        "off\n",
                        t->kind, t->width, t->height, at.x, at.y, at.z, n.x, n.y, n.z, size / 2, worst);
        }
    }
    tally->unseen += !seen;
    tally->same += seen && !missing && !off;
    tally->missing += missing;
    tally->off += off;
}

void corners_compare(const char *home, const char *figures, bool sized, CornersTally *out, int count) {
    Arena arena = {0};
    Building b = {0};
    Error error;
    cr_assert(maps_read(home, &arena, &b, &error), "%s", error.text);
    Figures f = read_figures(figures, &arena);
    for (int i = 0; i < f.triangle_count; i++) {
        for (int k = 0; k < count; k++)
            if (strcmp(f.triangles[i].kind, out[k].kind) == 0)
                compare_triangle(&b, &f, &f.triangles[i], sized, &out[k]);
    }
    arena_free(&arena);
}
