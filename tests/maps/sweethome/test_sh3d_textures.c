// test_sh3d_textures.c - pictures of homes lie where Sweet Home 3D lays them.
//
// The figures in FILE.corners come from the program itself, version 7.0.2 of Debian: SweetHomeCorners.java beside them asks it for the
// triangles of walls, rooms, pieces and the ground that it draws with a picture, and for the places of their corners in the picture.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "tests/support/home_fixture.h"

// The bar of the project: texture corners within 2 cm of the program's.
static const double NEAR = 0.02;
// Ends of walls, jambs and ends of baseboards, metres wide at most: there the program starts pictures anew at each half of the wall's
// thickness, while ours go on round the corner.
static const double NARROW = 0.075;

// Backs of baseboards, which the program draws, lie a centimetre or more behind our boards' faces, metres.
static const double SAME_PLANE = 0.002;
// Narrower triangles, of mouldings, lie nearer to their neighbours than figures can tell apart, metres.
static const double SLIVER = 0.005;

typedef struct Triangle {
    char kind[16];
    int width, height;  // of the picture
    Vec3 p[3];
    Vec2 place[3];
} Triangle;

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

static bool read_triangle(FILE *file, Triangle *t) {
    char line[512];
    if (!fgets(line, sizeof line, file)) return false;
    double v[15];
    int used = 0;
    cr_assert_eq(sscanf(line, "%15s %dx%d%n", t->kind, &t->width, &t->height, &used), 3, "%s", line);
    for (int i = 0, at = used, more; i < 15; i++, at += more)
        cr_assert_eq(sscanf(line + at, "%lf%n", &v[i], &more), 1, "%s", line);
    for (int i = 0; i < 3; i++) {
        t->p[i] = vec3(v[5 * i], v[5 * i + 1], v[5 * i + 2]);
        t->place[i] = vec2(v[5 * i + 3], v[5 * i + 4]);
    }
    return true;
}

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
                consider(s, b->edge_material[ring->first_point + e], 0, fabs(vec2_cross(along, to)) / length);
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

// The triangles of a kind that have a surface of ours, and those that have none.
typedef struct Tally {
    const char *kind;
    int found, missing;
} Tally;

static void compare_triangle(const Building *b, const Triangle *t, bool sized, const char *home,
                             Tally *tally) {
    Vec3 n = vec3_cross(vec3_sub(t->p[1], t->p[0]), vec3_sub(t->p[2], t->p[0]));
    double size = vec3_length(n), wide = 0, longest = 0;
    for (int i = 0; i < 3; i++) {
        Vec3 side = vec3_sub(t->p[i], t->p[(i + 1) % 3]);
        wide = fmax(wide, hypot(side.x, side.y));
        longest = fmax(longest, vec3_length(side));
    }
    bool board = strcmp(t->kind, "board") == 0;
    if (size < 1e-9 || size < SLIVER * longest || ((board || strcmp(t->kind, "wall") == 0) && wide < NARROW))
        return;
    Search s = {.b = b,
                .t = t,
                .n = vec3_scale(n, 1 / size),
                .sized = sized,
                .best = {-1, 0, NEAR},
                .worst = INFINITY};
    s.middle = vec3_scale(vec3_add(vec3_add(t->p[0], t->p[1]), t->p[2]), 1.0 / 3);
    if (!board) search_regions(&s);
    search_polygons(&s);
    tally->found += s.best.material >= 0;
    tally->missing += s.best.material < 0;
    cr_expect(s.best.material < 0 || s.worst < NEAR,
              "%s: %s with a picture of %d x %d at (%.2f, %.2f, %.2f) lies %.3f m off", home, t->kind,
              t->width, t->height, s.middle.x, s.middle.y, s.middle.z, s.worst);
}

// Compares a home with its figures, kind by kind. `sized`: its pictures have sides of their own.
static void compare(const char *home, const char *figures, bool sized, Tally *tallies, int count) {
    Arena arena = {0};
    Building b = {0};
    Error error;
    cr_assert(maps_read(home, &arena, &b, &error), "%s", error.text);
    FILE *file = fopen(figures, "r");
    cr_assert(file, "%s", figures);
    Triangle t;
    while (read_triangle(file, &t)) {
        for (int i = 0; i < count; i++)
            if (strcmp(t.kind, tallies[i].kind) == 0) compare_triangle(&b, &t, sized, home, &tallies[i]);
    }
    fclose(file);
    arena_free(&arena);
}

// Proves that every way of laying pictures is the program's: both sides of walls, straight and along arcs, with angle, scale, offset and
// either orientation; baseboards; floors and ceilings, stretched over their room too; pieces as a whole, turned, mirrored and laid
// down; single materials; models' own pictures; the ground. Walls' missing triangles are mitres inside the corners, boards' their backs.
Test(sh3d_textures, lie_as_in_sweet_home_3d) {
    Tally tallies[] = {{"wall", 0, 0}, {"board", 0, 0}, {"room", 0, 0}, {"piece", 0, 0}, {"ground", 0, 0}};
    compare("maps/buildings/textures.sh3d", "tests/maps/sweethome/textures.corners", true, tallies, 5);
    static const int LEAST[][2] = {{178, 32}, {10, 10}, {8, 0}, {108, 0}, {22, 0}};
    for (int i = 0; i < 5; i++) {
        cr_expect_geq(tallies[i].found, LEAST[i][0], "%s: %d", tallies[i].kind, tallies[i].found);
        cr_expect_leq(tallies[i].missing, LEAST[i][1], "%s: %d", tallies[i].kind, tallies[i].missing);
    }
}

// The same of a home by a stranger, of which walls, rooms and a tenth of the pieces' triangles are kept as figures. Pieces lack the faces
// of leaves, which ours have closed.
Test(sh3d_textures, lie_so_in_a_real_home) {
    const char *home = "../shared/data/sh3d/textured-room.sh3d";
    if (access(home, R_OK) != 0) cr_skip("no %s", home);
    Tally tallies[] = {{"wall", 0, 0}, {"room", 0, 0}, {"piece", 0, 0}};
    compare(home, "tests/maps/sweethome/textured-room.corners", false, tallies, 3);
    cr_expect_eq(tallies[0].missing + tallies[1].missing, 0);
    cr_expect_geq(tallies[0].found, 60);
    cr_expect_eq(tallies[1].found, 4);
    cr_expect_geq(tallies[2].found, 20);
}

// Proves that images that are missing, cut short or too large in their header cost one sentence and leave the colour that the home states,
// and that seventy textures stay within the texels of a building. The sample's own pictures are taken; a quarter of what is left
// each is above their sides, so none is halved.
Test(sh3d_textures, broken_and_many) {
    static const unsigned char CUT[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x20\0\0\0\x20\x08\x06\0\0\0",
                               HUGE[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\0\0\0\x40\0\x08\x06\0\0\0";
    Arena arena = {0};
    Error error;
    Bytes sample, image;
    Archive *archive;
    cr_assert(file_read("maps/buildings/textures.sh3d", SIZE_MAX, &arena, &sample, &error), "%s", error.text);
    cr_assert(archive_open(sample, "sample", &arena, &archive, &error));
    cr_assert(archive_read(archive, "crate", ARCHIVE_MAX_ENTRY, &arena, &image, &error));
    archive_close(archive);
    enum { MANY = 70 };
    HomeEntry entries[MANY + 3];
    char *xml = arena_format(&arena, "<home>" HOME_ROOM);
    static const char *const BAD[] = {"missing", "cut", "huge"};
    for (int i = 0; i < MANY + 3; i++)
        xml = arena_format(
            &arena,
            "%s<room floorColor='FF0000FF'><texture attribute='floorTexture' name='t%d' width='%d' "
            "height='20' "
            "image='%s'/><point x='%d' y='0'/><point x='%d' y='0'/><point x='%d' y='300'/></room>",
            xml, i, 10 + i, i < MANY ? arena_format(&arena, "i%d", i) : BAD[i - MANY], 500 * (i + 1),
            500 * (i + 1) + 400, 500 * (i + 1) + 400);
    xml = arena_format(&arena, "%s</home>", xml);
    entries[0] = (HomeEntry){"Home.xml", xml, strlen(xml)};
    for (int i = 0; i < MANY; i++)
        entries[i + 1] = (HomeEntry){arena_format(&arena, "i%d", i), image.data, image.size};
    entries[MANY + 1] = (HomeEntry){"cut", CUT, sizeof CUT - 1};
    entries[MANY + 2] = (HomeEntry){"huge", HUGE, sizeof HUGE - 1};
    Home h = home_of_zip(entries, MANY + 3);
    cr_assert(h.good, "%s", h.error.text);
    cr_expect_eq(h.b.texture_count, MANY + 1);
    cr_expect_eq(h.b.texture_map_count, MANY + 1);
    cr_expect_geq(home_note(&h, "3 textures are missing or could not be decoded"), 0);
    double texels = 0;
    for (int i = 1; i < h.b.texture_count; i++) texels += h.b.textures[i].width * h.b.textures[i].height;
    cr_expect_eq(texels, MANY * 64.0 * 64, "of %d allowed", TEXTURE_MOST_TEXELS);
    const SketchRoom *last = &h.sketch.rooms[h.sketch.room_count - 1];
    const Material *floor = &h.b.materials[last->floor_material];
    cr_expect(floor->texture == 0 && floor->reflectance.r == 0 && floor->reflectance.b > 0.8f);
    home_free(&h);
    arena_free(&arena);
}

// Proves that what is seen through a picture's holes is never an occluder, that a wall stays one, and that a colour of a piece
// replaces its picture.
Test(sh3d_textures, holes) {
    Arena arena = {0};
    Building b = {0};
    Error error;
    cr_assert(maps_read("maps/buildings/textures.sh3d", &arena, &b, &error), "%s", error.text);
    int leaves = 0, coloured = 0;
    for (int i = 0; i < b.object_count; i++) {
        const Material *m = &b.materials[b.polygons[b.objects[i].first_polygon].material];
        if (strcmp(b.objects[i].name, "leaves") == 0) {
            // Half the squares are holes, without two of the three marked ones among them.
            cr_expect_float_eq((double)m->alpha, 1 - 30.0 / 64, 1e-6, "%g", (double)m->alpha);
            leaves++;
        }
        if (strcmp(b.objects[i].name, "coloured") != 0) continue;
        cr_expect_eq(m->texture, 0);
        coloured++;
    }
    cr_expect(leaves == 1 && coloured == 1);
    cr_expect_gt(b.sky_texture, 0);
    cr_expect_float_eq(b.sky_start, -2 * M_PI * 0.1, 1e-12);
    for (int i = 0; i < b.point_count; i++)
        if (b.edge_material[i] >= 0) cr_expect_eq(b.materials[b.edge_material[i]].alpha, 1.0f);
    arena_free(&arena);
}

// Any home: HOME_FILE with figures HOME_CORNERS.
Test(sh3d_textures, lie_so_in_a_given_home) {
    const char *home = getenv("HOME_FILE"), *figures = getenv("HOME_CORNERS");
    if (!home || !figures) cr_skip("no home is given");
    Tally tallies[] = {{"wall", 0, 0}, {"board", 0, 0}, {"room", 0, 0}, {"piece", 0, 0}, {"ground", 0, 0}};
    compare(home, figures, false, tallies, 5);
    for (int i = 0; i < 5; i++)
        fprintf(stderr, "%s: %d found, %d missing\n", tallies[i].kind, tallies[i].found, tallies[i].missing);
}
