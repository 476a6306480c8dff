// sh3d_walls.c - outlines of walls from their axes: offsets, arcs, mitres where two walls name each other; low
// walls as objects; ceilings under sloped walls. Computed as Sweet Home 3D draws them (see sh3d.h for the mirrored
// plan).
//
// Source of the sloped ceilings: our own. The wall tops around a room give heights along its outline; among all
// triangulations of the outline the one with the most room below it is taken (by the dynamic programme of
// Gilbert 1979 and Klincsek 1980), which over a convex outline is the upper hull: the roof one expects.
#include <stdlib.h>
#include <string.h>

#include "maps/sweethome/sh3d_walls.h"

static const double MIN_WALL = 0.001;  // metres, of thickness and length: the grid of the plan
static const double PARALLEL = 1e-6;   // sine of an angle below which two sides do not meet
static const double MITRE_LIMIT = 2;   // thicknesses a corner may move
static const double HIGH_WALL = 1.8;   // metres: walls from here on show how high a storey is
static const double CM_PER_M = 100;    // the file counts in cm; arcs get sqrt(length in cm) chords
#define ARC_MAX_STEPS 256
#define ARC_MOST_CHORDS 16000              // of all arcs together: beyond, each has its share, and 2 at least
#define ROOF_MAX 96                        // corners of a room under sloped walls, for its ceiling
static const double ROOF_REACH = 0.05;     // metres from a wall's side at which a room's corner belongs to it
static const double ROOF_SLANT = 0.02;     // sine between a wall and the room's edge that it runs along
static const double ROOF_OVERLAP = 0.1;    // metres that they share at least
static const double OWN_REACH = 0.25;      // metres from a room's corner to the wall that carries its ceiling
static const double OWN_MOST_LOOKS = 5e7;  // edges of walls that may be looked at for these walls

// ---- reading

static const char *wall_at(const XmlNode *node, int end) {
    return xml_get(node, end ? "wallAtEnd" : "wallAtStart");
}

static Sh3dWall read_wall(Sh3d *s, const XmlNode *node) {
    const Sh3dLevel *level = sh3d_level(s, node);
    Sh3dWall w = {.node = node, .id = xml_get(node, "id"), .storey = level->storey, .joined = {-1, -1}};
    w.start = vec2(sh3d_coordinate(s, node, "xStart", NAN), -sh3d_coordinate(s, node, "yStart", NAN));
    w.end = vec2(sh3d_coordinate(s, node, "xEnd", NAN), -sh3d_coordinate(s, node, "yEnd", NAN));
    w.thickness = sh3d_length(s, node, "thickness", NAN);
    // A full turn and more is no arc between two points.
    w.arc = -sh3d_number(s, node, "arcExtent", 0, -6.28, 6.28);
    w.floor = level->floor;
    double height = sh3d_length(s, node, "height", s->wall_height * CM_PER_M);
    w.top[0] = w.floor + height;
    w.top[1] = w.floor + sh3d_length(s, node, "heightAtEnd", height * CM_PER_M);
    w.top_material = sh3d_material(s, node, "top", s->wall_material, NULL);
    w.place = sh3d_place(s, node, "wall");
    return w;
}

static bool usable(Sh3d *s, const Sh3dWall *w) {
    double length = vec2_length(vec2_sub(w->end, w->start));
    const char *fault = length < MIN_WALL                                       ? "length"
                        : w->thickness < MIN_WALL                               ? "thickness"
                        : fmax(w->top[0], w->top[1]) - w->floor < MAPS_GRID / 2 ? "height"
                                                                                : NULL;
    if (!fault) return true;
    building_note(s->arena, s->b, NOTE_DROPPED, vec3(w->start.x, w->start.y, w->floor),
                  "%s: %s has a %s below 1 mm: left out", s->where, w->place, fault);
    return false;
}

static int by_id(const void *a, const void *b) {
    const Sh3dWall *const *p = a, *const *q = b;
    int order = strcmp((*p)->id, (*q)->id);
    return order ? order : (*p)->node->line - (*q)->node->line;
}

static int find_wall(Sh3dWall *const *sorted, int count, const char *id) {
    int low = 0, high = count;
    while (low < high) {
        int mid = (low + high) / 2;
        if (strcmp(sorted[mid]->id, id) < 0)
            low = mid + 1;
        else
            high = mid;
    }
    return low < count && strcmp(sorted[low]->id, id) == 0 ? low : -1;
}

static void join_walls(Sh3d *s) {
    Sh3dWall **sorted = ARENA_ARRAY(s->arena, Sh3dWall *, s->wall_count);
    int count = 0;
    for (int i = 0; i < s->wall_count; i++)
        if (s->walls[i].id) sorted[count++] = &s->walls[i];
    qsort(sorted, (size_t)count, sizeof *sorted, by_id);
    for (int i = 1; i < count && !s->failed; i++)
        if (strcmp(sorted[i - 1]->id, sorted[i]->id) == 0)
            sh3d_fail(s, sorted[i]->node, "has the id '%.40s' of the wall in %s %d", sorted[i]->id, s->unit,
                      sorted[i - 1]->node->line);
    for (int i = 0; i < s->wall_count && !s->failed; i++) {
        Sh3dWall *w = &s->walls[i];
        for (int end = 0; end < 2; end++) {
            const char *id = wall_at(w->node, end);
            if (!id) continue;
            int found = find_wall(sorted, count, id);
            if (found >= 0 && sorted[found] != w)
                w->joined[end] = (int)(sorted[found] - s->walls);
            else
                building_tally(&s->unknown_joins, id, vec3(w->start.x, w->start.y, w->floor));
        }
    }
}

// ---- storeys as high as their walls

// A storey that has no high walls, but sloped ones that others join at both ends, is an attic, as high as the highest of
// these: 0 if it is none. Gables that stand alone and parapets close nothing.
static double attic_height(const Sh3d *s, int storey) {
    double highest = 0;
    for (int i = 0; i < s->wall_count; i++) {
        const Sh3dWall *w = &s->walls[i];
        bool sloped = fabs(w->top[0] - w->top[1]) > SH3D_SAME_HEIGHT;
        if (w->storey != storey || !sloped) continue;
        if (w->joined[0] < 0 || w->joined[1] < 0) return 0;
        highest = fmax(highest, fmax(w->top[0], w->top[1]) - w->floor);
    }
    return highest;
}

// The height that most metres of the storey's high walls have, if most of them differ from the height of the level.
// (O(n^2) over distinct heights, of which there are few.)
static void adjust_height(Sh3d *s, int storey) {
    Storey *level = &s->b->storeys[storey];
    double *heights = ARENA_ARRAY(s->arena, double, s->wall_count + 1), total = 0, other = 0;
    double *lengths = ARENA_ARRAY(s->arena, double, s->wall_count + 1);
    int count = 0, best = -1;
    for (int i = 0; i < s->wall_count; i++) {
        const Sh3dWall *w = &s->walls[i];
        double height = fmax(w->top[0], w->top[1]) - w->floor,
               length = vec2_length(vec2_sub(w->end, w->start));
        if (w->storey != storey || height < HIGH_WALL) continue;
        total += length;
        if (fabs(height - level->height) > SH3D_SAME_HEIGHT) other += length;
        int k = 0;
        while (k < count && fabs(heights[k] - height) > SH3D_SAME_HEIGHT) k++;
        if (k == count) heights[count++] = height;
        lengths[k] += length;
        if (best < 0 || lengths[k] > lengths[best]) best = k;
    }
    double attic = best < 0 ? attic_height(s, storey) : 0;
    if (attic <= 0 && (best < 0 || other <= total / 2)) return;
    double height = attic > 0 ? attic : heights[best];
    // Walls of two storeys belong to the lower one: its ceiling stays below the upper floor.
    for (int i = storey + 1; i < s->b->storey_count; i++) {
        const Storey *above = &s->b->storeys[i];
        double most = fmax(above->floor - above->slab, level->floor + level->height) - level->floor;
        height = fmin(height, most);
    }
    level->height = maps_snap(height);
}

// ---- outlines

static double half_thickness(const Sh3dWall *w, bool left) { return w->thickness / 2 + w->beyond[left]; }

static void add_side_points(Sh3dWall *w, int i, Vec2 on_axis, Vec2 to_left) {
    w->left[i] = vec2_add(on_axis, vec2_scale(to_left, half_thickness(w, true)));
    w->right[i] = vec2_sub(on_axis, vec2_scale(to_left, half_thickness(w, false)));
}

// Centre on the chord's perpendicular, so that `arc` of a circle lies between the ends.
static Vec2 arc_centre(const Sh3dWall *w) {
    Vec2 chord = vec2_sub(w->end, w->start), mid = vec2_scale(vec2_add(w->start, w->end), 0.5);
    return vec2_add(mid, vec2_scale(vec2(-chord.y, chord.x), 0.5 / tan(w->arc / 2)));
}

static bool is_straight(const Sh3dWall *w) { return fabs(w->arc) < PARALLEL; }

static int arc_steps(const Sh3dWall *w) {
    if (is_straight(w)) return 1;
    double outer = vec2_length(vec2_sub(w->start, arc_centre(w))) + w->thickness / 2;
    return (int)fmin(ceil(sqrt(outer * CM_PER_M * fabs(w->arc))), ARC_MAX_STEPS);
}

// The share of their chords that arcs may have.
static double arc_share(Sh3d *s) {
    long long chords = 0;
    const Sh3dWall *first = NULL;
    for (int i = 0; i < s->wall_count; i++) {
        if (is_straight(&s->walls[i])) continue;
        chords += arc_steps(&s->walls[i]);
        if (!first) first = &s->walls[i];
    }
    if (chords <= ARC_MOST_CHORDS) return 1;
    building_note(s->arena, s->b, NOTE_CHANGED, vec3(first->start.x, first->start.y, first->floor),
                  "%s: its arc walls would have %lld chords, the first of them %s; they share %d", s->where,
                  chords, first->place, ARC_MOST_CHORDS);
    return (double)ARC_MOST_CHORDS / (double)chords;
}

static void make_outline(Sh3d *s, Sh3dWall *w, int steps) {
    Vec2 along = vec2_sub(w->end, w->start);
    double length = vec2_length(along);
    bool straight = is_straight(w);
    Vec2 centre = straight ? w->start : arc_centre(w), from = vec2_sub(w->start, centre);
    double radius = vec2_length(from);
    w->side_count = steps + 1;
    w->left = ARENA_ARRAY(s->arena, Vec2, w->side_count);
    w->right = ARENA_ARRAY(s->arena, Vec2, w->side_count);
    if (straight) {
        Vec2 left = vec2(-along.y / length, along.x / length);
        add_side_points(w, 0, w->start, left);
        add_side_points(w, 1, w->end, left);
        return;
    }
    for (int i = 0; i <= steps; i++) {
        double a = w->arc * i / steps, c = cos(a), sn = sin(a);
        Vec2 out = vec2((c * from.x - sn * from.y) / radius, (sn * from.x + c * from.y) / radius);
        // Turning left, the centre lies to the left. A side that would pass the centre stops there.
        bool inner_left = w->arc > 0;
        double inner = fmin(half_thickness(w, inner_left), radius), outer = half_thickness(w, !inner_left);
        Vec2 near = vec2_add(centre, vec2_scale(out, radius - inner)),
             far = vec2_add(centre, vec2_scale(out, radius + outer));
        w->left[i] = w->arc > 0 ? near : far;
        w->right[i] = w->arc > 0 ? far : near;
    }
}

static void make_sides(Sh3d *s, Sh3dWall *w, double share) {
    bool fewer = !is_straight(w) && share < 1;
    make_outline(s, w, fewer ? (int)fmax(2, floor(share * arc_steps(w))) : arc_steps(w));
}

// Where the lines p q and r t meet; false when they are parallel.
static bool lines_meet(Vec2 p, Vec2 q, Vec2 r, Vec2 t, Vec2 *at) {
    Vec2 u = vec2_sub(q, p), v = vec2_sub(t, r);
    double cross = vec2_cross(u, v);
    if (fabs(cross) <= PARALLEL * vec2_length(u) * vec2_length(v)) return false;
    *at = vec2_add(p, vec2_scale(u, vec2_cross(vec2_sub(r, p), v) / cross));
    return true;
}

// A side as a line at one of its ends: the corner and the next point inwards.
typedef struct SideEnd {
    Vec2 corner, inward;
} SideEnd;

static SideEnd side_end(const Sh3dWall *w, bool left, int end) {
    const Vec2 *side = left ? w->left : w->right;
    int n = w->side_count;
    return end ? (SideEnd){side[n - 1], side[n - 2]} : (SideEnd){side[0], side[1]};
}

// At which end wall `other` names wall `w` back, -1: at none. Where it does at both (a ring of two walls), the
// end that lies where `w` ends.
static int end_joined(const Sh3dWall *other, int w, Vec2 at) {
    if (other->joined[0] == w && other->joined[1] == w) return vec2_equal(other->end, at);
    return other->joined[0] == w ? 0 : other->joined[1] == w ? 1 : -1;
}

// The corner of wall i at `end`, on its left or right side, moved to where it meets its neighbour's side.
static Vec2 mitred(const Sh3d *s, int i, int end, bool left) {
    const Sh3dWall *w = &s->walls[i];
    SideEnd mine = side_end(w, left, end);
    if (w->joined[end] < 0) return mine.corner;
    const Sh3dWall *other = &s->walls[w->joined[end]];
    int there = end_joined(other, i, end ? w->end : w->start);
    if (there < 0 || other->side_count == 0 || other->storey != w->storey) return mine.corner;
    // Head to tail the left side goes on as the left side; head to head it goes on as the right one.
    SideEnd theirs = side_end(other, there == end ? !left : left, there);
    Vec2 at;
    // The same order for both walls, so that both get the same corner to the last bit.
    bool first = i < w->joined[end];
    SideEnd a = first ? mine : theirs, b = first ? theirs : mine;
    double limit = MITRE_LIMIT * fmax(w->thickness, other->thickness);
    if (!lines_meet(a.corner, a.inward, b.corner, b.inward, &at)) return mine.corner;
    return vec2_length(vec2_sub(at, mine.corner)) < limit ? at : mine.corner;
}

static void mitre_walls(const Sh3d *s) {
    Vec2(*corner)[4] = arena_alloc(s->arena, (size_t)s->wall_count, sizeof *corner);
    for (int i = 0; i < s->wall_count; i++)
        for (int k = 0; k < 4; k++) corner[i][k] = mitred(s, i, k >> 1, k & 1);
    for (int i = 0; i < s->wall_count; i++) {
        Sh3dWall *w = &s->walls[i];
        w->right[0] = corner[i][0];
        w->left[0] = corner[i][1];
        w->right[w->side_count - 1] = corner[i][2];
        w->left[w->side_count - 1] = corner[i][3];
    }
}

const XmlNode *sh3d_board(const Sh3dWall *w, bool left) {
    const char *side = left ? "leftSideBaseboard" : "rightSideBaseboard";
    for (const XmlNode *child = w->node->first; child; child = child->next)
        if (xml_is(child, "baseboard") && strcmp(sh3d_text(child, "attribute"), side) == 0) return child;
    return NULL;
}

static double board_thickness(Sh3d *s, const Sh3dWall *w, bool left) {
    const XmlNode *node = sh3d_board(w, left);
    return node ? sh3d_length(s, node, "thickness", NAN) : 0;
}

Sh3dWall *sh3d_widened_walls(Sh3d *s) {
    Sh3d wide = *s;
    wide.walls = ARENA_ARRAY(s->arena, Sh3dWall, s->wall_count);
    memcpy(wide.walls, s->walls, (size_t)s->wall_count * sizeof *s->walls);
    for (int i = 0; i < s->wall_count; i++) {
        Sh3dWall *w = &wide.walls[i];
        w->beyond[false] = board_thickness(s, w, false);
        w->beyond[true] = board_thickness(s, w, true);
        make_outline(s, w, w->side_count - 1);
    }
    mitre_walls(&wide);
    return wide.walls;
}

// ---- pictures on walls

// A side's pictures count from where the side starts, along it, and in absolute heights. From the side into the wall they count on, so
// that jambs have pictures too.
Sh3dFrame sh3d_side_frame(const Sh3dWall *w, bool left) {
    const Vec2 *side = left ? w->left : w->right;
    Vec2 axis = vec2_sub(w->end, w->start), along = vec2_scale(axis, 1 / vec2_length(axis)),
         inward = left ? vec2(along.y, -along.x) : vec2(-along.y, along.x), right = vec2_add(along, inward);
    return (Sh3dFrame){.right = {right.x, right.y, 0},
                       .up = {0, 0, 1},
                       .right0 = -vec2_dot(right, side[0]),
                       .left_side = left};
}

// The angle by which the side's point i lies on from its start, as the arc turns.
static double turned(const Sh3dWall *w, const Vec2 *side, int i) {
    Vec2 centre = arc_centre(w), a = vec2_sub(side[0], centre), b = vec2_sub(side[i], centre);
    double angle = atan2(vec2_cross(a, b), vec2_dot(a, b));
    if (i > 0 && angle * w->arc < 0) angle += w->arc > 0 ? 2 * M_PI : -2 * M_PI;
    return angle;
}

// On arcs lengths are those of the axis, counted against the arc where it turns left: each chord has a map of its own.
Sh3dFrame sh3d_chord_frame(const Sh3dWall *w, bool left, int i) {
    const Vec2 *side = left ? w->left : w->right;
    Vec2 chord = vec2_sub(side[i + 1], side[i]);
    double radius = vec2_length(vec2_sub(w->start, arc_centre(w))), length = vec2_length(chord),
           from = -turned(w, side, i) * radius, to = -turned(w, side, i + 1) * radius;
    Vec2 right = vec2_scale(chord, length > 0 ? (to - from) / (length * length) : 0);
    return (Sh3dFrame){.right = {right.x, right.y, 0},
                       .up = {0, 0, 1},
                       .right0 = from - vec2_dot(right, side[i]),
                       .left_side = left};
}

static void paint_wall(Sh3d *s, Sh3dWall *w) {
    for (int left = 0; left < 2; left++) {
        Sh3dFrame frame = sh3d_side_frame(w, left);
        int material = sh3d_material(s, w->node, left ? "leftSide" : "rightSide", s->wall_material, &frame);
        int *chords = ARENA_ARRAY(s->arena, int, w->side_count);
        const XmlNode *texture = sh3d_texture_of(s, w->node, left ? "leftSide" : "rightSide");
        for (int i = 0; i < w->side_count; i++) {
            Material m = s->b->materials[material];
            chords[i] = material;
            sh3d_keep_lengths(s, material, texture);
            if (is_straight(w) || i + 1 == w->side_count || m.texture_map == 0) continue;
            TextureMap map;
            frame = sh3d_chord_frame(w, left, i);
            if (sh3d_map(s, texture, &frame, &map)) {
                m.texture_map = building_add_texture_map(s->arena, s->b, map);
                chords[i] = sh3d_push_material(s, m);
                sh3d_keep_lengths(s, chords[i], texture);
            }
        }
        if (left)
            w->left_material = chords;
        else
            w->right_material = chords;
    }
}

// ---- which walls bound rooms

static bool is_sloped(const Sh3dWall *w) { return fabs(w->top[0] - w->top[1]) > SH3D_SAME_HEIGHT; }

static bool reaches_ceiling(const Sh3d *s, const Sh3dWall *w) {
    const Storey *storey = &s->b->storeys[w->storey];
    return fmax(w->top[0], w->top[1]) >= storey->floor + storey->height - SH3D_SAME_HEIGHT;
}

// A knee wall: as high as the sloped wall that it joins is there, so that the roof starts on it.
static bool under_slope(const Sh3d *s, int i) {
    const Sh3dWall *w = &s->walls[i];
    for (int end = 0; end < 2; end++) {
        if (w->joined[end] < 0) continue;
        const Sh3dWall *other = &s->walls[w->joined[end]];
        int there = end_joined(other, i, end ? w->end : w->start);
        if (there >= 0 && other->storey == w->storey && is_sloped(other) && reaches_ceiling(s, other) &&
            fabs(other->top[there] - w->top[end]) <= SH3D_SAME_HEIGHT)
            return true;
    }
    return false;
}

// Whether maps_enclose is to judge the wall (see SketchWall).
static bool may_bound(const Sh3dWall *w) {
    return !is_sloped(w) && w->top[0] - w->floor >= SKETCH_LEAST_ROOM;
}

bool sh3d_read_walls(Sh3d *s) {
    for (const XmlNode *node = s->home->first; node && !s->failed; node = node->next) {
        if (!xml_is(node, "wall")) continue;
        Sh3dWall w = read_wall(s, node);
        if (!s->failed && usable(s, &w)) *ARENA_PUSH(s->arena, s->walls, s->wall_count, s->wall_capacity) = w;
    }
    if (s->failed) return false;
    join_walls(s);
    for (int i = 0; i < s->b->storey_count; i++) adjust_height(s, i);
    double share = arc_share(s);
    for (int i = 0; i < s->wall_count; i++) make_sides(s, &s->walls[i], share);
    mitre_walls(s);
    for (int i = 0; i < s->wall_count; i++) paint_wall(s, &s->walls[i]);
    for (int i = 0; i < s->wall_count; i++)
        s->walls[i].bounding = reaches_ceiling(s, &s->walls[i]) || under_slope(s, i);
    return !s->failed;
}

// ---- into the sketch and the building

// The two halves of an end that joins no wall, each with the picture of its side begun anew, from the right side to the left one at
// the wall's end and back at its start. Returns false where no picture is there.
static bool end_materials(Sh3d *s, const Sh3dWall *w, int end, int out[2]) {
    int last = w->side_count - 1, at = end ? last : 0, chord = end && last > 0 ? last - 1 : 0;
    int right = w->right_material[chord], left = w->left_material[chord];
    if (w->joined[end] >= 0 || (!sh3d_has_lengths(s->sketch, right) && !sh3d_has_lengths(s->sketch, left)))
        return false;
    Vec2 axis = end ? w->end : w->start;
    Sh3dFrame before = sh3d_frame_from(end ? w->right[at] : w->left[at], axis),
              after = sh3d_frame_from(axis, end ? w->left[at] : w->right[at]);
    out[0] = sh3d_begun_anew(s->arena, s->b, s->sketch, end ? right : left, &before);
    out[1] = sh3d_begun_anew(s->arena, s->b, s->sketch, end ? left : right, &after);
    return true;
}

// A wall that bounds rooms, or may bound them.
static void add_to_sketch(Sh3d *s, const Sh3dWall *w) {
    Sketch *k = s->sketch;
    int n = w->side_count;
    Vec2 along = vec2_sub(w->end, w->start);
    // The room is a prism as high as its highest point, so the walls that bound it are as high, a knee wall too.
    const Storey *storey = &s->b->storeys[w->storey];
    double top = fmax(w->bounding ? storey->floor + storey->height : w->floor, fmax(w->top[0], w->top[1]));
    SketchWall wall = {w->storey, k->point_count,          0,        w->floor,
                       top,       atan2(along.y, along.x), w->place, w->top_material};
    int start[2], end[2];
    bool starts = end_materials(s, w, 0, start), ends = end_materials(s, w, 1, end);
    // Ends without pictures take the left side's material; they show only where nothing is joined.
    for (int i = 0; i + 1 < n; i++) sh3d_add_point(s, w->right[i], w->right_material[i]);
    sh3d_add_point(s, w->right[n - 1], ends ? end[0] : w->left_material[n - 1]);
    if (ends) sh3d_add_point(s, w->end, end[1]);
    for (int i = n - 1; i > 0; i--) sh3d_add_point(s, w->left[i], w->left_material[i - 1]);
    sh3d_add_point(s, w->left[0], starts ? start[0] : w->left_material[n - 1]);
    if (starts) sh3d_add_point(s, w->start, start[1]);
    wall.point_count = k->point_count - wall.first_point;
    *ARENA_PUSH(s->arena, k->walls, k->wall_count, k->wall_capacity) = wall;
}

// Height of a wall's top over a point of side i: linear along its axis, and on beyond its ends over mitres.
static double top_at(const Sh3dWall *w, int i, Vec2 p) {
    Vec2 along = vec2_sub(w->end, w->start);
    bool straight = w->side_count == 2;
    double t = straight ? vec2_dot(vec2_sub(p, w->start), along) / vec2_dot(along, along)
                        : (double)i / (w->side_count - 1);
    return fmax(w->floor, w->top[0] + t * (w->top[1] - w->top[0]));
}

static void add_quad(Sh3d *s, Vec3 a, Vec3 b, Vec3 c, Vec3 d, int material) {
    building_add_polygon(s->arena, s->b, (Vec3[]){a, b, c, d}, 4, material);
}

static Vec3 at_height(Vec2 p, double z) { return vec3(p.x, p.y, z); }

// A side of a low wall from a to b, seen from its right.
static void add_side(Sh3d *s, const Sh3dWall *w, Vec2 a, int ia, Vec2 b, int ib, int material) {
    add_quad(s, at_height(a, w->floor), at_height(b, w->floor), at_height(b, top_at(w, ib, b)),
             at_height(a, top_at(w, ia, a)), material);
}

// Its foot is left out: it stands on a floor.
static void add_low(Sh3d *s, const Sh3dWall *w) {
    int n = w->side_count;
    building_add_object(s->arena, s->b, OBJECT_LOW_WALL, w->place);
    for (int i = 0; i + 1 < n; i++) {
        add_side(s, w, w->right[i], i, w->right[i + 1], i + 1, w->right_material[i]);
        add_side(s, w, w->left[i + 1], i + 1, w->left[i], i, w->left_material[i]);
        add_quad(s, at_height(w->right[i], top_at(w, i, w->right[i])),
                 at_height(w->right[i + 1], top_at(w, i + 1, w->right[i + 1])),
                 at_height(w->left[i + 1], top_at(w, i + 1, w->left[i + 1])),
                 at_height(w->left[i], top_at(w, i, w->left[i])), w->top_material);
    }
    for (int end = 1; end >= 0; end--) {
        int at = end ? n - 1 : 0, halves[2];
        Vec2 axis = end ? w->end : w->start, from = end ? w->right[at] : w->left[at],
             to = end ? w->left[at] : w->right[at];
        if (end_materials(s, w, end, halves)) {
            add_side(s, w, from, at, axis, at, halves[0]);
            add_side(s, w, axis, at, to, at, halves[1]);
        } else {
            add_side(s, w, from, at, to, at, w->left_material[n - 1]);
        }
    }
    Vec2 along = vec2_sub(w->end, w->start);
    building_set_proxy(s->arena, s->b, atan2(along.y, along.x));
}

void sh3d_add_walls(Sh3d *s) {
    for (int i = 0; i < s->wall_count; i++) {
        const Sh3dWall *w = &s->walls[i];
        if (w->bounding || may_bound(w))
            add_to_sketch(s, w);
        else
            add_low(s, w);
    }
}

// ---- ceilings of their own

// Horizontal distance from p to the outline of a wall, metres.
static double distance_to_wall(const Sh3dWall *w, Vec2 p) {
    double best = INFINITY;
    for (int i = 0; i + 1 < 2 * w->side_count; i++) {
        int n = w->side_count;
        Vec2 a = i < n ? w->right[i] : w->left[2 * n - 1 - i],
             b = i + 1 < n ? w->right[i + 1] : w->left[2 * n - 2 - i];
        Vec2 d = vec2_sub(b, a), to = vec2_sub(p, a);
        double t = fmin(1, fmax(0, vec2_dot(to, d) / fmax(vec2_dot(d, d), MAPS_GRID * MAPS_GRID)));
        best = fmin(best, vec2_length(vec2_sub(to, vec2_scale(d, t))));
    }
    return best;
}

// The top of the wall that is nearest to a corner of a room, absolute; the higher one of two that are equally near. NAN: none is near,
// or it has no level top.
static double nearest_top(const Sh3d *s, int storey, Vec2 corner) {
    double nearest = OWN_REACH, top = NAN;
    for (int i = 0; i < s->wall_count; i++) {
        const Sh3dWall *w = &s->walls[i];
        if (w->storey != storey) continue;
        double away = distance_to_wall(w, corner);
        if (away > nearest + MAPS_GRID) continue;
        double here = is_sloped(w) ? NAN : w->top[0];
        bool tie = away >= nearest - MAPS_GRID && !isnan(top);
        top = tie ? fmax(top, here) : here;
        nearest = fmin(nearest, away);
    }
    return top;
}

// Rooms of the highest storey have the ceiling that their walls have: the program draws it through the tops of the walls nearest to
// their corners. Where these differ its ceiling slants between walls, and the room here is as high as its storey.
void sh3d_find_ceilings(Sh3d *s) {
    bool any = false;
    double looks = 0;
    for (int i = 0; i < s->wall_count; i++) {
        any = any || (may_bound(&s->walls[i]) && !reaches_ceiling(s, &s->walls[i]));
        looks += s->walls[i].side_count;
    }
    for (int i = 0; any && i < s->sketch->room_count; i++) {
        SketchRoom *room = &s->sketch->rooms[i];
        if (room->storey != s->b->storey_count - 1) continue;
        const Storey *storey = &s->b->storeys[room->storey];
        const Vec2 *p = s->sketch->points + room->first_point;
        double low = INFINITY, high = -INFINITY;
        if (looks * room->point_count * s->sketch->room_count > OWN_MOST_LOOKS) continue;
        for (int k = 0; k < room->point_count && !isnan(high); k++) {
            double top = nearest_top(s, room->storey, p[k]);
            low = fmin(low, top);
            high = isnan(top) ? NAN : fmax(high, top);
        }
        if (high - low <= SH3D_SAME_HEIGHT && low >= storey->floor + SKETCH_LEAST_ROOM &&
            high < storey->floor + storey->height - SH3D_SAME_HEIGHT)
            room->z1 = maps_snap(high);
    }
}

// ---- ceilings under sloped walls

// Whether a wall stands along an edge of the room, so that the roof lies on it; partitions only meet edges.
static bool stands_along(const Sh3d *s, const Sh3dWall *w, const SketchRoom *room) {
    if (w->storey != room->storey || !w->bounding || w->side_count != 2) return false;
    const Vec2 *p = s->sketch->points + room->first_point;
    Vec2 along = vec2_sub(w->end, w->start);
    double length = vec2_length(along), reach = w->thickness / 2 + ROOF_REACH;
    for (int i = 0; i < room->point_count; i++) {
        Vec2 a = vec2_sub(p[i], w->start), b = vec2_sub(p[(i + 1) % room->point_count], w->start);
        double ta = vec2_dot(a, along) / length, tb = vec2_dot(b, along) / length;
        double oa = vec2_cross(along, a) / length, ob = vec2_cross(along, b) / length;
        double shared = fmin(fmax(ta, tb), length) - fmax(fmin(ta, tb), 0);
        if (fabs(ob - oa) <= ROOF_SLANT * fabs(tb - ta) && fabs(oa) <= reach && fabs(ob) <= reach &&
            shared >= ROOF_OVERLAP)
            return true;
    }
    return false;
}

// The lowest top of these walls over a point of a room's outline, no higher than `ceiling`.
static double roof_over(const Sh3d *s, const unsigned char *along_room, Vec2 p, double ceiling) {
    double z = ceiling;
    for (int i = 0; i < s->wall_count; i++) {
        const Sh3dWall *w = &s->walls[i];
        if (!along_room[i]) continue;
        Vec2 along = vec2_sub(w->end, w->start), to = vec2_sub(p, w->start);
        double length = vec2_length(along), reach = w->thickness / 2 + ROOF_REACH;
        double t = vec2_dot(to, along) / length, off = fabs(vec2_cross(along, to)) / length;
        if (off > reach || t < -reach || t > length + reach) continue;
        t = fmin(fmax(t / length, 0), 1);
        z = fmin(z, w->top[0] + t * (w->top[1] - w->top[0]));
    }
    return z;
}

static int by_share(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

// The outline with a corner wherever a wall along it changes its slope. Returns the count, 0 for too many.
static int roof_outline(const Sh3d *s, const SketchRoom *room, const unsigned char *along_room, Vec2 *out) {
    const Vec2 *p = s->sketch->points + room->first_point;
    bool forward = sh3d_shape_area(p, room->point_count) > 0;
    int count = 0;
    for (int i = 0; i < room->point_count; i++) {
        int n = room->point_count;
        Vec2 a = forward ? p[i] : p[n - 1 - i], b = forward ? p[(i + 1) % n] : p[(2 * n - 2 - i) % n];
        Vec2 along = vec2_sub(b, a);
        double length = vec2_length(along), share[ROOF_MAX];
        int shares = 0;
        if (length < MAPS_GRID) continue;
        for (int k = 0; k < 2 * s->wall_count && shares < ROOF_MAX; k++) {
            const Sh3dWall *w = &s->walls[k / 2];
            if (!along_room[k / 2] || !is_sloped(w)) continue;
            Vec2 to = vec2_sub(k % 2 ? w->end : w->start, a);
            double off = fabs(vec2_cross(along, to)) / length, t = vec2_dot(to, along) / length;
            double reach = w->thickness / 2 + ROOF_REACH;
            if (off <= reach && t > reach && t < length - reach) share[shares++] = t / length;
        }
        qsort(share, (size_t)shares, sizeof *share, by_share);
        if (count == ROOF_MAX) return 0;
        out[count++] = a;
        for (int k = 0; k < shares; k++) {
            if (k > 0 && (share[k] - share[k - 1]) * length < MAPS_GRID) continue;
            if (count == ROOF_MAX) return 0;
            out[count++] = vec2_add(a, vec2_scale(along, share[k]));
        }
    }
    return count;
}

static double twice_area(Vec2 a, Vec2 b, Vec2 c) { return vec2_cross(vec2_sub(b, a), vec2_sub(c, a)); }

// Whether the line between corners i and j stays inside the outline (it may run along it).
static bool sees(const Vec2 *p, int count, int i, int j) {
    if (j == i + 1 || (i == 0 && j == count - 1)) return true;
    for (int k = 0; k < count; k++) {
        int l = (k + 1) % count;
        if (k == i || k == j || l == i || l == j) continue;
        if (twice_area(p[i], p[j], p[k]) * twice_area(p[i], p[j], p[l]) < 0 &&
            twice_area(p[k], p[l], p[i]) * twice_area(p[k], p[l], p[j]) < 0)
            return false;
    }
    Vec2 before = p[(i + count - 1) % count], at = p[i], after = p[i + 1];
    bool left_of_next = twice_area(at, after, p[j]) >= 0, left_of_last = twice_area(before, at, p[j]) >= 0;
    return twice_area(before, at, after) >= 0 ? left_of_next && left_of_last : left_of_next || left_of_last;
}

typedef struct Roof {
    Vec2 p[ROOF_MAX];
    double z[ROOF_MAX];
    double most[ROOF_MAX]
               [ROOF_MAX];  // volume below the best triangulation of corners i .. j, -1: there is none
    int apex[ROOF_MAX][ROOF_MAX];
    double floor, ceiling;
    int count;
} Roof;

static void fill_roof(Roof *r) {
    for (int span = 1; span < r->count; span++) {
        for (int i = 0; i + span < r->count; i++) {
            int j = i + span;
            r->most[i][j] = span == 1 ? 0 : -1;
            if (span == 1 || !sees(r->p, r->count, i, j)) continue;
            for (int k = i + 1; k < j; k++) {
                double area = twice_area(r->p[i], r->p[k], r->p[j]) / 2;
                if (area < 0 || r->most[i][k] < 0 || r->most[k][j] < 0) continue;
                double mean = (r->z[i] + r->z[k] + r->z[j]) / 3 - r->floor;
                double volume = r->most[i][k] + r->most[k][j] + area * mean;
                if (volume <= r->most[i][j]) continue;
                r->most[i][j] = volume;
                r->apex[i][j] = k;
            }
        }
    }
}

// Triangles that lie in the flat ceiling are left to it. Seen from below, so wound clockwise from above.
static void add_roof(Sh3d *s, const Roof *r, int i, int j, int material) {
    if (j - i < 2) return;
    int k = r->apex[i][j];
    add_roof(s, r, i, k, material);
    add_roof(s, r, k, j, material);
    if (fmin(r->z[i], fmin(r->z[j], r->z[k])) >= r->ceiling - SH3D_SAME_HEIGHT) return;
    Vec3 t[3] = {at_height(r->p[j], r->z[j]), at_height(r->p[k], r->z[k]), at_height(r->p[i], r->z[i])};
    building_add_polygon(s->arena, s->b, t, 3, material);
}

void sh3d_add_sloped_ceilings(Sh3d *s) {
    bool any = false;
    for (int i = 0; i < s->wall_count; i++) any = any || (s->walls[i].bounding && is_sloped(&s->walls[i]));
    if (!any) return;
    Roof *r = ARENA_ARRAY(s->arena, Roof, 1);
    unsigned char *along = ARENA_ARRAY(s->arena, unsigned char, s->wall_count);
    for (int i = 0; i < s->sketch->room_count; i++) {
        const SketchRoom *room = &s->sketch->rooms[i];
        const Storey *storey = &s->b->storeys[room->storey];
        double ceiling = storey->floor + storey->height, lowest = ceiling;
        r->floor = storey->floor;
        r->ceiling = ceiling;
        for (int k = 0; k < s->wall_count; k++) along[k] = stands_along(s, &s->walls[k], room);
        r->count = roof_outline(s, room, along, r->p);
        for (int k = 0; k < r->count; k++) {
            r->z[k] = roof_over(s, along, r->p[k], ceiling);
            lowest = fmin(lowest, r->z[k]);
        }
        if (r->count < 3 || lowest >= ceiling - SH3D_SAME_HEIGHT) continue;
        fill_roof(r);
        if (r->most[0][r->count - 1] < 0) {
            building_note(
                s->arena, s->b, NOTE_CHANGED, vec3(r->p[0].x, r->p[0].y, ceiling),
                "%s: %s stands under sloped walls, but its outline crosses itself: its ceiling is flat",
                s->where, room->place);
            continue;
        }
        // No proxy: a box of the whole would stop whoever walks below.
        building_add_object(s->arena, s->b, OBJECT_LOW_WALL, "sloped ceiling");
        add_roof(s, r, 0, r->count - 1, room->ceiling_material);
    }
}
