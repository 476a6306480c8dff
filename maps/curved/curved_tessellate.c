// curved_tessellate.c - spheres, cylinders and cones as polygons, by the sagitta of their angles; the kinds of shapes.
//
// Quads between circles of latitude are flat, and stay flat under an affine map: their four corners are two chords of one
// direction.
#include "maps/curved/curved_tessellate.h"

enum { LEAST_SIDES = 6 };  // around: with fewer nobody would know the shape

static Vec3 in_building(const CurvedFrame *f, double x, double y, double z) {
    Vec3 across = vec3_add(vec3_scale(f->axis[0], x), vec3_scale(f->axis[1], y));
    return vec3_add(f->origin, vec3_add(across, vec3_scale(f->axis[2], z)));
}

static double longest_axis(const CurvedFrame *f, int axes) {
    double most = 0;
    for (int i = 0; i < axes; i++) most = fmax(most, vec3_length(f->axis[i]));
    return most;
}

static bool left_handed(const CurvedFrame *f) {
    return vec3_dot(vec3_cross(f->axis[0], f->axis[1]), f->axis[2]) < 0;
}

// Directions around, the first along x.
static Vec2 *circle(int sides, Arena *arena) {
    Vec2 *around = ARENA_ARRAY(arena, Vec2, sides);
    for (int i = 0; i < sides; i++) {
        double angle = 2 * M_PI * i / sides;
        around[i] = vec2(cos(angle), sin(angle));
    }
    return around;
}

static int sides_at_angle(double angle) {
    double sides = ceil(2 * M_PI / angle);
    return sides < LEAST_SIDES ? LEAST_SIDES : sides > CURVED_MOST_SIDES ? CURVED_MOST_SIDES : (int)sides;
}

// Twice as many sides around as from pole to pole, so that all angles are alike. The middle of a quad of angles a and b lies at
// cos(a / 2) cos(b / 2) of the radius.
static void sphere_mesh(const CurvedShape *shape, double tolerance, Arena *arena, CurvedMesh *out) {
    const CurvedFrame *f = &shape->frame;
    bool flip = left_handed(f);
    double radius = longest_axis(f, 3), share = fmin(tolerance / radius, 0.5);
    int sides = sides_at_angle(2 * asin(sqrt(share))), rows = (sides + 1) / 2;
    out->tolerance = radius * (1 - cos(M_PI / sides) * cos(M_PI / (2 * rows)));
    const Vec2 *around = circle(sides, arena);
    for (int j = 0; j < rows; j++) {
        double z[2], r[2];
        for (int k = 0; k < 2; k++) {
            int row = j + k;
            double angle = M_PI * row / rows;
            z[k] = row == 0 ? -1 : row == rows ? 1 : -cos(angle);
            r[k] = row == 0 || row == rows ? 0 : sin(angle);
        }
        for (int i = 0; i < sides; i++) {
            Vec2 a = around[i], b = around[(i + 1) % sides];
            Vec3 quad[4] = {
                in_building(f, r[0] * a.x, r[0] * a.y, z[0]), in_building(f, r[0] * b.x, r[0] * b.y, z[0]),
                in_building(f, r[1] * b.x, r[1] * b.y, z[1]), in_building(f, r[1] * a.x, r[1] * a.y, z[1])};
            curved_mesh_add(out, arena, quad, 4, flip);
        }
    }
}

// A convex ring of any number of corners: runs of them are cut off by chords until few are left.
static void add_disc(CurvedMesh *out, Arena *arena, const Vec3 *rim, int count, bool flip) {
    Vec3 *ring = ARENA_ARRAY(arena, Vec3, count + 1), piece[CURVED_MOST_CORNERS];
    memcpy(ring, rim, sizeof(Vec3) * (size_t)count);
    while (count > CURVED_MOST_CORNERS) {
        int left = 0;
        ring[count] = ring[0];
        for (int at = 0; at < count; at += CURVED_MOST_CORNERS - 1) {
            int n = count - at < CURVED_MOST_CORNERS - 1 ? count - at + 1 : CURVED_MOST_CORNERS;
            memcpy(piece, ring + at, sizeof(Vec3) * (size_t)n);
            if (n > 2) curved_mesh_add(out, arena, piece, n, flip);
            ring[left++] = piece[0];
        }
        count = left;
    }
    if (count > 2) curved_mesh_add(out, arena, ring, count, flip);
}

static void cone_mesh(const CurvedShape *shape, double tolerance, Arena *arena, CurvedMesh *out) {
    const CurvedFrame *f = &shape->frame;
    bool flip = left_handed(f);
    double radius = longest_axis(f, 2), top = shape->kind == CURVED_CONE ? shape->top : 1;
    int sides = sides_at_angle(2 * acos(1 - fmin(tolerance / radius, 1)));
    out->tolerance = radius * (1 - cos(M_PI / sides));
    const Vec2 *around = circle(sides, arena);
    Vec3 *low = ARENA_ARRAY(arena, Vec3, sides), *high = ARENA_ARRAY(arena, Vec3, sides);
    for (int i = 0; i < sides; i++) {
        low[i] = in_building(f, around[i].x, around[i].y, 0);
        high[i] = in_building(f, top * around[i].x, top * around[i].y, 1);
    }
    for (int i = 0; i < sides; i++) {
        int k = (i + 1) % sides;
        curved_mesh_add(out, arena, (Vec3[]){low[i], low[k], high[k], high[i]}, 4, flip);
    }
    if (shape->disc[0]) add_disc(out, arena, low, sides, !flip);
    if (shape->disc[1] && top > 0) add_disc(out, arena, high, sides, flip);
}

void curved_tessellate(const Building *b, const CurvedShape *shape, double tolerance, Arena *arena,
                       CurvedMesh *out) {
    CORE_ASSERT(tolerance > 0);
    *out = (CurvedMesh){.tolerance = tolerance};
    switch (shape->kind) {
    case CURVED_SPHERE:
        sphere_mesh(shape, tolerance, arena, out);
        return;
    case CURVED_CYLINDER:
    case CURVED_CONE:
        cone_mesh(shape, tolerance, arena, out);
        return;
    case CURVED_PATCH:
        if (shape->trim_count > 0) {
            curved_trimmed_mesh(b->controls + shape->first_control, b->trims + shape->first_trim,
                                shape->trim_count, tolerance, arena, out);
        } else {
            curved_patch_mesh(b->controls + shape->first_control, tolerance, arena, out);
        }
        return;
    case CURVED_METABALLS:
        curved_balls_mesh(b->balls + shape->first_ball, shape->ball_count, shape->threshold, tolerance, arena,
                          out);
        return;
    case CURVED_KINDS:
        break;
    }
    CORE_ASSERT(shape->kind < CURVED_KINDS);
}
