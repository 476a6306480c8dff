// sh3d_baseboards.c - baseboards: boards along the feet of walls, mitred where walls meet, cut where doors stand. As Sweet Home 3D
// makes them: a board without colour and picture of its own looks as its wall.
#include <stdlib.h>
#include <string.h>

#include "maps/sweethome/sh3d_walls.h"

enum { MOST_CUTS = 64 };               // openings in one wall; the others do not cut its boards
static const double MOST_TRIES = 1e8;  // boards times openings: real homes have below 10,000

// A board along one side of a wall.
typedef struct Board {
    Sh3d *s;
    const Sh3dWall *wall, *wide;
    const Sh3dWall *widened;  // all walls, as `wide`
    const XmlNode *node;
    bool left;
    double top;  // absolute height
} Board;

// A part of a wall without a board, in metres along its axis, above `from`.
typedef struct Cut {
    double low, high, from;
} Cut;

static Vec3 at(Vec2 p, double z) { return vec3(p.x, p.y, z); }

// A quadrilateral given counter-clockwise as seen from the right of the wall.
static void add_quad(const Board *b, Vec3 p, Vec3 q, Vec3 r, Vec3 t, int material) {
    Vec3 right[4] = {p, q, r, t}, left[4] = {t, r, q, p};
    building_add_polygon(b->s->arena, b->s->b, b->left ? left : right, 4, material);
}

// The material of the board's surface that counts pictures as the frame says.
static int board_material(const Board *b, const Sh3dFrame *frame) {
    bool own = sh3d_texture_of(b->s, b->node, "") || xml_get(b->node, "color");
    return sh3d_material(b->s, own ? b->node : b->wall->node,
                         own       ? ""
                         : b->left ? "leftSide"
                                   : "rightSide",
                         b->s->wall_material, frame);
}

// An end of a board, from p to q as seen from the right of the wall; its picture begins anew, at its left as one looks at it.
static void add_end(const Board *b, Vec2 p, Vec2 q, double top) {
    double foot = b->wall->floor;
    if (vec2_length(vec2_sub(q, p)) < MAPS_GRID) return;
    Sh3dFrame frame = sh3d_frame_from(b->left ? q : p, b->left ? p : q);
    add_quad(b, at(p, foot), at(q, foot), at(q, top), at(p, top), board_material(b, &frame));
}

// A piece from the points `from` to `to` of the board's face and the wall's side behind; its ends are shown where asked for.
static void add_piece(const Board *b, const Vec2 from[2], const Vec2 to[2], double top, bool begins,
                      bool ends, int material) {
    double foot = b->wall->floor;
    add_quad(b, at(from[0], foot), at(to[0], foot), at(to[0], top), at(from[0], top), material);
    add_quad(b, at(from[0], top), at(to[0], top), at(to[1], top), at(from[1], top), material);
    if (begins) add_end(b, from[1], from[0], top);
    if (ends) add_end(b, to[0], to[1], top);
}

// Whether the board ends in the open: no board of the wall that is joined there has the same corner, as high or higher.
static bool ends_open(const Board *b, int end) {
    int other = b->wall->joined[end], n = b->wall->side_count;
    if (other < 0) return true;
    Vec2 corner = (b->left ? b->wide->left : b->wide->right)[end ? n - 1 : 0];
    for (int left = 0; left < 2; left++) {
        const Sh3dWall *w = &b->widened[other];
        const XmlNode *node = sh3d_board(w, left);
        const Vec2 *side = left ? w->left : w->right;
        if (!node || w->floor + sh3d_length(b->s, node, "height", NAN) < b->top - MAPS_GRID) continue;
        if (vec2_length(vec2_sub(side[0], corner)) < MAPS_GRID ||
            vec2_length(vec2_sub(side[w->side_count - 1], corner)) < MAPS_GRID)
            return false;
    }
    return true;
}

static int by_low(const void *a, const void *b) {
    const Cut *p = a, *q = b;
    return (p->low > q->low) - (p->low < q->low);
}

// Whether the opening stands in the wall, and where along it.
static bool find_cut(const Board *b, const SketchOpening *o, Cut *out) {
    const Sh3dWall *w = b->wall;
    Vec2 axis = vec2_sub(w->end, w->start), to = vec2_sub(o->centre, w->start);
    double length = vec2_length(axis);
    Vec2 along = vec2_scale(axis, 1 / length);
    double t = vec2_dot(to, along), off = fabs(vec2_cross(along, to));
    double reach = fabs(cos(o->angle) * along.x + sin(o->angle) * along.y) * o->width / 2;
    *out = (Cut){t - reach, t + reach, o->sill};
    return o->storey == w->storey && o->head > w->floor && o->sill < b->top - MAPS_GRID &&
           off < (w->thickness + o->depth) / 2 && out->high > 0 && out->low < length;
}

static int find_cuts(const Board *b, Cut cuts[MOST_CUTS]) {
    int count = 0;
    for (int i = 0; i < b->s->sketch->opening_count && count < MOST_CUTS; i++)
        count += find_cut(b, &b->s->sketch->openings[i], &cuts[count]);
    qsort(cuts, (size_t)count, sizeof *cuts, by_low);
    return count;
}

// The face and the wall behind it at `t` metres along a straight wall.
static void points_at(const Board *b, double t, Vec2 out[2]) {
    const Sh3dWall *w = b->wall;
    Vec2 axis = vec2_sub(w->end, w->start), along = vec2_scale(axis, 1 / vec2_length(axis));
    Vec2 outward = b->left ? vec2(-along.y, along.x) : vec2(along.y, -along.x);
    Vec2 on_axis = vec2_add(w->start, vec2_scale(along, t));
    out[0] = vec2_add(on_axis, vec2_scale(outward, w->thickness / 2 + b->wide->beyond[b->left]));
    out[1] = vec2_add(on_axis, vec2_scale(outward, w->thickness / 2));
}

static void add_straight(const Board *b, int material) {
    const Sh3dWall *w = b->wall;
    const Vec2 *face = b->left ? b->wide->left : b->wide->right, *side = b->left ? w->left : w->right;
    Vec2 from[2] = {face[0], side[0]}, end[2] = {face[1], side[1]}, to[2];
    double length = vec2_length(vec2_sub(w->end, w->start)), reached = -INFINITY;
    bool begins = ends_open(b, 0);
    Cut cuts[MOST_CUTS];
    int count = find_cuts(b, cuts);
    for (int i = 0; i < count; i++) {
        if (cuts[i].high <= reached) continue;
        if (cuts[i].low > fmax(reached, 0)) {
            points_at(b, cuts[i].low, to);
            add_piece(b, from, to, b->top, begins, true, material);
        }
        Vec2 low[2], high[2];
        points_at(b, fmax(fmax(cuts[i].low, reached), 0), low);
        points_at(b, fmin(cuts[i].high, length), high);
        if (cuts[i].from > w->floor + MAPS_GRID)
            add_piece(b, low, high, cuts[i].from, false, false, material);
        reached = cuts[i].high;
        points_at(b, reached, from);
        begins = true;
    }
    if (reached < length) add_piece(b, from, end, b->top, begins, ends_open(b, 1), material);
}

static bool in_opening(const Board *b, Vec2 p) {
    for (int i = 0; i < b->s->sketch->opening_count; i++) {
        const SketchOpening *o = &b->s->sketch->openings[i];
        Vec2 to = vec2_sub(p, o->centre);
        double along = to.x * cos(o->angle) + to.y * sin(o->angle),
               across = to.y * cos(o->angle) - to.x * sin(o->angle);
        if (o->storey == b->wall->storey && o->head > b->wall->floor && o->sill < b->top - MAPS_GRID &&
            fabs(along) < o->width / 2 && fabs(across) < (o->depth + b->wall->thickness) / 2)
            return true;
    }
    return false;
}

// Chords of arcs whose middle lies in an opening have no board.
static void add_arc(const Board *b, const int *materials) {
    int n = b->wall->side_count;
    const Vec2 *face = b->left ? b->wide->left : b->wide->right,
               *side = b->left ? b->wall->left : b->wall->right;
    for (int i = 0; i + 1 < n; i++) {
        if (in_opening(b, vec2_scale(vec2_add(side[i], side[i + 1]), 0.5))) continue;
        Vec2 from[2] = {face[i], side[i]}, to[2] = {face[i + 1], side[i + 1]};
        add_piece(b, from, to, b->top, i == 0 && ends_open(b, 0), i + 2 == n && ends_open(b, 1),
                  materials[i]);
    }
}

// The material of a board along each chord: [side_count - 1].
static int *board_materials(const Board *b) {
    const Sh3dWall *w = b->wall;
    int *out = ARENA_ARRAY(b->s->arena, int, w->side_count);
    for (int i = 0; i + 1 < w->side_count; i++) {
        Sh3dFrame f =
            w->side_count == 2 ? sh3d_side_frame(b->wide, b->left) : sh3d_chord_frame(b->wide, b->left, i);
        out[i] = board_material(b, &f);
    }
    return out;
}

void sh3d_add_baseboards(Sh3d *s) {
    bool any = false;
    for (int i = 0; i < s->wall_count; i++)
        any = any || sh3d_board(&s->walls[i], true) || sh3d_board(&s->walls[i], false);
    if (!any) return;
    const Sh3dWall *wide = sh3d_widened_walls(s);
    double tries = 0;
    for (int i = 0; i < s->wall_count && !s->failed; i++) {
        for (int left = 0; left < 2; left++) {
            const Sh3dWall *w = &s->walls[i];
            Board b = {s, w, &wide[i], wide, sh3d_board(w, left), left, w->floor};
            if (!b.node || wide[i].beyond[left] < MAPS_GRID) continue;
            b.top += fmin(sh3d_length(s, b.node, "height", NAN), fmin(w->top[0], w->top[1]) - w->floor);
            if (s->failed || b.top < w->floor + MAPS_GRID) continue;
            tries += (w->side_count - 1.0) * (s->sketch->opening_count + 1);
            if (tries > MOST_TRIES || s->b->polygon_count > building_polygons_allowed(s->b->file_size)) {
                building_tally(&s->plain_walls, w->place, vec3(w->start.x, w->start.y, w->floor));
                continue;
            }
            // No proxy: a box around it would stop whoever walks along the wall.
            building_add_object(s->arena, s->b, OBJECT_LOW_WALL, "baseboard");
            int *materials = board_materials(&b);
            if (w->side_count == 2)
                add_straight(&b, materials[0]);
            else
                add_arc(&b, materials);
            if (s->b->objects[s->b->object_count - 1].polygon_count == 0) s->b->object_count--;
        }
    }
}
