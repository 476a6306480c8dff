// enclose_input.c - the sketch made ready for geometry: local coordinates, heights of storeys, walls that bound, walls too low to
// bound, implicit walls, fillings of small gaps.
#include <stdio.h>
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// A wall bounds when it comes this near to its storey's ceiling, metres.
static const double CEILING_SLACK = 0.01;
// A wall that starts higher than this above its floor leaves the space under it open, metres.
static const double FLOOR_SLACK = 0.02;
// The thickness of a roof over rooms that have no storey above, mm.
static const double ROOF = 150;
// The slab above a ceiling reaches up to the next storey's floor if this floor is at most this far above, mm;
// farther up, there is a storey between.
static const double THICKEST_SLAB = 1500;
// Soil below the lowest slab, mm: only so that columns have a bottom.
static const double SOIL = 1000;
// Gaps up to this between walls, and between a wall and a door, are drawing noise and are filled, mm.
static const double GAP = 30;
// Fillings narrower than this are noise of the buffers, mm.
static const double NARROWEST_PLUG = 0.5;
// Mitres of implicit walls reach this many thicknesses from a corner.
static const double MITRE_LIMIT = 5;
// The thickness of the walls given to rooms of a plan without walls, mm.
static const double ASSUMED_WALL = 100;
// Local coordinates are held in steps of 1/1024 mm: noise of shifted copies vanishes, the grid stays.
static const double STEPS_PER_MM = 1024;
// Rooms and cut-outs of less area than one square of the grid cannot be drawn, mm^2.
static const double SMALLEST_AREA = 1;

const char *enclose_text(const char *place) { return place && *place ? place : "unnamed"; }

Vec2 enclose_local(const Enclosure *e, Vec2 p) {
    Vec2 mm = vec2((p.x - e->origin.x) * ENCLOSE_MM, (p.y - e->origin.y) * ENCLOSE_MM);
    return vec2(nearbyint(mm.x * STEPS_PER_MM) / STEPS_PER_MM, nearbyint(mm.y * STEPS_PER_MM) / STEPS_PER_MM);
}

Vec2 enclose_metres(const Enclosure *e, Vec2 p) {
    return vec2((e->origin.x * ENCLOSE_MM + p.x) / ENCLOSE_MM, (e->origin.y * ENCLOSE_MM + p.y) / ENCLOSE_MM);
}

Vec3 enclose_place(const Enclosure *e, Vec2 p, int storey) {
    double z = storey >= 0 && storey < e->b->storey_count ? e->b->storeys[storey].floor : e->sketch->ground;
    return vec3(e->origin.x + p.x / ENCLOSE_MM, e->origin.y + p.y / ENCLOSE_MM, z);
}

static bool good(double x) { return isfinite(x) && fabs(x) <= MAPS_LIMIT - 2 * MAPS_OUTDOORS; }
static double height_mm(double metres) { return nearbyint(metres * ENCLOSE_MM); }

// ---- refusing numbers that cannot be computed with

// A place, where there is one, already names its thing.
static const char *name_of(const char *what, const char *place) { return place && *place ? place : what; }

static bool check_points(Enclosure *e, const char *what, const char *place, int first, int count) {
    const Sketch *s = e->sketch;
    if (first < 0 || count < 0 || first > s->point_count - count) {
        return error_set(e->error, "%s: points %d to %d of %d", name_of(what, place), first,
                         first + count - 1, s->point_count);
    }
    for (int i = first; i < first + count; i++) {
        Vec2 p = s->points[i];
        if (good(p.x) && good(p.y)) continue;
        return error_set(e->error, "%s: point %d is at (%g, %g) m (finite and within %g m)",
                         name_of(what, place), i - first + 1, p.x, p.y, MAPS_LIMIT);
    }
    return true;
}

static bool check_number(Enclosure *e, const char *what, const char *place, const char *field, double x) {
    if (good(x)) return true;
    return error_set(e->error, "%s: its %s is %g (finite and within %g)", name_of(what, place), field, x,
                     MAPS_LIMIT);
}

static bool check_opening(Enclosure *e, const SketchOpening *o) {
    const char *p = o->place;
    return check_number(e, "opening", p, "x", o->centre.x) &&
           check_number(e, "opening", p, "y", o->centre.y) &&
           check_number(e, "opening", p, "angle", o->angle) &&
           check_number(e, "opening", p, "width", o->width) &&
           check_number(e, "opening", p, "depth", o->depth) &&
           check_number(e, "opening", p, "sill", o->sill) && check_number(e, "opening", p, "head", o->head) &&
           check_number(e, "opening", p, "swing", o->swing) &&
           check_number(e, "opening", p, "slide", o->slide) &&
           check_points(e, "opening", p, o->first_cutout, o->cutout_count);
}

static bool check_heights(Enclosure *e) {
    const Building *b = e->b;
    if (b->storey_count == 0) return error_set(e->error, "the plan has no storeys (at least one)");
    for (int i = 0; i < b->storey_count; i++) {
        const Storey *s = &b->storeys[i];
        if (good(s->floor) && good(s->height) && good(s->slab) && s->height >= MAPS_GRID && s->slab >= 0)
            continue;
        return error_set(
            e->error,
            "storey %d (%s): floor %g m, height %g m, slab %g m (finite, height above 0, slab at least 0)", i,
            enclose_text(s->name), s->floor, s->height, s->slab);
    }
    return check_number(e, "the ground", NULL, "height", e->sketch->ground);
}

static bool check_sketch(Enclosure *e) {
    const Sketch *s = e->sketch;
    if (!check_heights(e)) return false;
    for (int i = 0; i < s->wall_count; i++) {
        const SketchWall *w = &s->walls[i];
        if (!check_points(e, "wall", w->place, w->first_point, w->point_count)) return false;
        if (!check_number(e, "wall", w->place, "foot", w->z0) ||
            !check_number(e, "wall", w->place, "top", w->z1) ||
            !check_number(e, "wall", w->place, "angle", w->angle)) {
            return false;
        }
    }
    for (int i = 0; i < s->room_count; i++) {
        const SketchRoom *r = &s->rooms[i];
        if (!check_points(e, "room", r->place, r->first_point, r->point_count)) return false;
        if ((!isnan(r->z0) && !check_number(e, "room", r->place, "floor", r->z0)) ||
            (!isnan(r->z1) && !check_number(e, "room", r->place, "ceiling", r->z1)) ||
            !check_number(e, "room", r->place, "wall thickness", r->wall)) {
            return false;
        }
    }
    for (int i = 0; i < s->cutout_count; i++) {
        const SketchCutout *c = &s->cutouts[i];
        if (!check_points(e, "cut-out", c->place, c->first_point, c->point_count)) return false;
    }
    for (int i = 0; i < s->opening_count; i++) {
        if (!check_opening(e, &s->openings[i])) return false;
    }
    return true;
}

// ---- shapes in local millimetres

static Shape local_shape(Enclosure *e, int first, int count) {
    Vec2 *points = ARENA_ARRAY(e->scratch, Vec2, count);
    int kept = 0;
    for (int i = 0; i < count; i++) {
        Vec2 p = enclose_local(e, e->sketch->points[first + i]);
        if (kept == 0 || !vec2_equal(points[kept - 1], p)) points[kept++] = p;
    }
    while (kept > 1 && vec2_equal(points[kept - 1], points[0])) kept--;
    return shape_of_points(e->scratch, points, kept);
}

static double shape_area(const Shape *shape) {
    double sum = 0;
    int count = shape->ring[1];
    for (int i = 1; i + 1 < count; i++) {
        sum += vec2_cross(vec2_sub(shape->points[i], shape->points[0]),
                          vec2_sub(shape->points[i + 1], shape->points[0]));
    }
    return fabs(sum) / 2;
}

static bool segments_cross(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    double p = vec2_cross(vec2_sub(b, a), vec2_sub(c, a)), q = vec2_cross(vec2_sub(b, a), vec2_sub(d, a));
    double r = vec2_cross(vec2_sub(d, c), vec2_sub(a, c)), s = vec2_cross(vec2_sub(d, c), vec2_sub(b, c));
    return ((p > 0 && q < 0) || (p < 0 && q > 0)) && ((r > 0 && s < 0) || (r < 0 && s > 0));
}

static bool crosses_itself(const Shape *shape) {
    int n = shape->ring[1];
    for (int i = 0; i < n; i++) {
        for (int j = i + 2; j < n; j++) {
            if (i == 0 && j == n - 1) continue;
            if (segments_cross(shape->points[i], shape->points[(i + 1) % n], shape->points[j],
                               shape->points[(j + 1) % n])) {
                return true;
            }
        }
    }
    return false;
}

// Whether a shape can be used; if not, adds a note that says why.
static bool usable(Enclosure *e, const Shape *shape, int storey, const char *what, const char *place) {
    Vec2 at = shape->ring[1] ? shape->points[0] : vec2(0, 0);
    if (storey < 0 || storey >= e->b->storey_count) {
        building_note(e->arena, e->b, NOTE_DROPPED, enclose_place(e, at, -1),
                      "%s %s left out: storey %d (there are %d)", what, enclose_text(place), storey,
                      e->b->storey_count);
        return false;
    }
    // The signed areas of a figure of eight may cancel.
    if (shape->ring[1] >= 3 && (shape_area(shape) >= SMALLEST_AREA || crosses_itself(shape))) return true;
    Vec3 p = enclose_place(e, at, storey);
    building_note(e->arena, e->b, NOTE_DROPPED, p, "%s %s left out: it has no area at (%.2f, %.2f)", what,
                  enclose_text(place), p.x, p.y);
    return false;
}

static void note_crossing(Enclosure *e, const Shape *shape, int storey, const char *what, const char *place) {
    if (!crosses_itself(shape)) return;
    Vec3 p = enclose_place(e, shape->points[0], storey);
    building_note(e->arena, e->b, NOTE_CHANGED, p,
                  "%s %s crosses itself at (%.2f, %.2f): what it winds around once counts", what,
                  enclose_text(place), p.x, p.y);
}

// ---- walls that do not bound

void enclose_add_low_wall(Enclosure *e, int wall) {
    const Sketch *s = e->sketch;
    enum { MOST_CORNERS = 128 };
    const SketchWall *w = &s->walls[wall];
    Building *b = e->b;
    int n = w->point_count;
    const Vec2 *p = &s->points[w->first_point];
    double area = 0;
    for (int i = 1; i + 1 < n; i++) area += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0]));
    Vec3 *top = ARENA_ARRAY(e->scratch, Vec3, n), *bottom = ARENA_ARRAY(e->scratch, Vec3, n);
    int top_material = w->top_material;
    if (top_material < 0 || top_material >= b->material_count) top_material = s->outer_material;
    building_add_object(e->arena, b, OBJECT_LOW_WALL, w->place);
    for (int i = 0; i < n; i++) {
        // Counter-clockwise, whichever way round it was drawn.
        int from = area < 0 ? n - 1 - i : i, to = area < 0 ? (2 * n - 2 - i) % n : (i + 1) % n;
        Vec2 a = p[from], c = p[to];
        int material = s->edge_material ? s->edge_material[w->first_point + (area < 0 ? to : from)] : -1;
        if (material < 0 || material >= b->material_count) material = s->outer_material;
        Vec3 side[4] = {{a.x, a.y, w->z0}, {c.x, c.y, w->z0}, {c.x, c.y, w->z1}, {a.x, a.y, w->z1}};
        building_add_polygon(e->arena, b, side, 4, material);
        top[i] = vec3(a.x, a.y, w->z1);
        bottom[n - 1 - i] = vec3(a.x, a.y, w->z0);
    }
    // A wall along an arc has two chains of corners, so its top is added quad by quad: cutting one polygon into triangles would
    // take time cubic in its corners.
    for (int i = 0; n > MOST_CORNERS && n % 2 == 0 && i + 1 < n / 2; i++) {
        Vec3 quad[4] = {top[i], top[i + 1], top[n - 2 - i], top[n - 1 - i]};
        building_add_polygon(e->arena, b, quad, 4, top_material);
    }
    if (n <= MOST_CORNERS || n % 2) building_add_polygon(e->arena, b, top, n, top_material);
    if (w->z0 > b->storeys[w->storey].floor + MAPS_GRID)
        building_add_polygon(e->arena, b, bottom, n, s->outer_material);
    building_set_proxy(e->arena, b, w->angle);
}

static void sort_walls(Enclosure *e) {
    const Sketch *s = e->sketch;
    for (int i = 0; i < s->wall_count; i++) {
        const SketchWall *w = &s->walls[i];
        e->walls[i] = local_shape(e, w->first_point, w->point_count);
        if (!usable(e, &e->walls[i], w->storey, "wall", w->place)) continue;
        const Storey *storey = &e->b->storeys[w->storey];
        bool high = w->z1 >= storey->floor + storey->height - CEILING_SLACK || enclose_may_bound(e, i);
        if (high && w->z0 <= storey->floor + FLOOR_SLACK) {
            e->wall_bounds[i] = true;
        } else if (w->z1 - w->z0 >= MAPS_GRID) {
            enclose_add_low_wall(e, i);
        } else {
            Vec3 p = enclose_place(e, e->walls[i].points[0], w->storey);
            building_note(e->arena, e->b, NOTE_DROPPED, p, "%s left out: it has no height at (%.2f, %.2f)",
                          enclose_text(w->place), p.x, p.y);
        }
    }
}

// ---- the rest

void enclose_lose_room(Enclosure *e, int room) {
    double area = shape_area(&e->rooms[room]) / (ENCLOSE_MM * ENCLOSE_MM);
    e->b->drawn_area += area;
    e->b->lost_area += area;
}

static void sort_rooms(Enclosure *e) {
    const Sketch *s = e->sketch;
    for (int i = 0; i < s->room_count; i++) {
        const SketchRoom *r = &s->rooms[i];
        e->rooms[i] = local_shape(e, r->first_point, r->point_count);
        e->room_used[i] = usable(e, &e->rooms[i], r->storey, "room", r->place);
        if (!e->room_used[i]) continue;
        double z0 = isnan(r->z0) ? e->b->storeys[r->storey].floor : r->z0;
        double z1 = isnan(r->z1) ? e->b->storeys[r->storey].floor + e->b->storeys[r->storey].height : r->z1;
        if (height_mm(z0) >= height_mm(z1)) {
            Vec3 p = enclose_place(e, e->rooms[i].points[0], r->storey);
            building_note(e->arena, e->b, NOTE_DROPPED, p, "%s left out: it reaches from %g m up to %g m",
                          enclose_text(r->place), z0, z1);
            e->room_used[i] = false;
            enclose_lose_room(e, i);
            continue;
        }
        note_crossing(e, &e->rooms[i], r->storey, "room", r->place);
        e->room_wall[i] = r->wall > 0 ? r->wall * ENCLOSE_MM : 0;
    }
    for (int i = 0; i < s->cutout_count; i++) {
        const SketchCutout *c = &s->cutouts[i];
        e->cutouts[i] = local_shape(e, c->first_point, c->point_count);
        e->cutout_used[i] = usable(e, &e->cutouts[i], c->storey, "cut-out", c->place);
    }
}

static void find_origin(Enclosure *e) {
    const Sketch *s = e->sketch;
    Vec2 low = vec2(INFINITY, INFINITY);
    for (int i = 0; i < s->point_count; i++) {
        // Points of openings' cut-outs lie in the unit square: with them the origin is only another, which is harmless.
        if (good(s->points[i].x) && good(s->points[i].y))
            low = vec2(fmin(low.x, s->points[i].x), fmin(low.y, s->points[i].y));
    }
    if (s->wall_count) low = s->points[s->walls[0].first_point];
    if (s->room_count) low = s->points[s->rooms[0].first_point];
    if (!s->wall_count && !s->room_count && s->opening_count) low = s->openings[0].centre;
    e->origin = isfinite(low.x) ? vec2(floor(low.x), floor(low.y)) : vec2(0, 0);
}

static void grow_outline(Enclosure *e, Vec2 p) {
    e->world_min = vec2(fmin(e->world_min.x, p.x), fmin(e->world_min.y, p.y));
    e->world_max = vec2(fmax(e->world_max.x, p.x), fmax(e->world_max.y, p.y));
}

static bool find_world(Enclosure *e) {
    const Sketch *s = e->sketch;
    e->world_min = vec2(INFINITY, INFINITY);
    e->world_max = vec2(-INFINITY, -INFINITY);
    double low = height_mm(s->ground), high = low, out = MAPS_OUTDOORS * ENCLOSE_MM;
    for (int i = 0; i < s->wall_count; i++) {
        for (int k = 0; k < e->walls[i].ring[1]; k++) grow_outline(e, e->walls[i].points[k]);
        high = fmax(high, height_mm(s->walls[i].z1));
    }
    for (int i = 0; i < s->room_count; i++) {
        for (int k = 0; k < e->rooms[i].ring[1]; k++) grow_outline(e, e->rooms[i].points[k]);
        if (!isnan(s->rooms[i].z0)) low = fmin(low, height_mm(s->rooms[i].z0));
        if (!isnan(s->rooms[i].z1)) high = fmax(high, height_mm(s->rooms[i].z1));
    }
    for (int i = 0; i < s->cutout_count; i++) {
        for (int k = 0; k < e->cutouts[i].ring[1]; k++) grow_outline(e, e->cutouts[i].points[k]);
    }
    for (int i = 0; i < s->opening_count; i++) grow_outline(e, enclose_local(e, s->openings[i].centre));
    for (int i = 0; i < e->b->vertex_count; i++) {
        Vec3 v = e->b->vertices[i];
        if (!good(v.x) || !good(v.y) || !good(v.z)) {
            return error_set(e->error, "furniture reaches to (%g, %g, %g) m (finite and within %g m)", v.x,
                             v.y, v.z, MAPS_LIMIT);
        }
        grow_outline(e, enclose_local(e, vec2(v.x, v.y)));
        high = fmax(high, height_mm(v.z));
    }
    for (int i = 0; i < e->b->storey_count; i++) {
        low = fmin(low, e->base[i]);
        high = fmax(high, e->cover[i]);
    }
    if (!(e->world_min.x <= e->world_max.x))
        return error_set(e->error, "the plan is empty: no walls, rooms or openings");
    e->world_min = vec2(floor(e->world_min.x - out), floor(e->world_min.y - out));
    e->world_max = vec2(ceil(e->world_max.x + out), ceil(e->world_max.y + out));
    e->bottom = low - SOIL;
    e->top = high + out;
    return true;
}

static void find_heights(Enclosure *e) {
    const Building *b = e->b;
    for (int i = 0; i < b->storey_count; i++) {
        e->floor[i] = height_mm(b->storeys[i].floor);
        e->ceiling[i] = fmax(height_mm(b->storeys[i].floor + b->storeys[i].height), e->floor[i] + 1);
        e->base[i] = e->floor[i] - height_mm(b->storeys[i].slab);
    }
    for (int i = 0; i < b->storey_count; i++) {
        double next = INFINITY;
        for (int k = 0; k < b->storey_count; k++) {
            if (e->floor[k] >= e->ceiling[i] - CEILING_SLACK * ENCLOSE_MM) next = fmin(next, e->floor[k]);
        }
        bool slab = next <= e->ceiling[i] + THICKEST_SLAB;
        e->cover[i] = slab ? fmax(next, e->ceiling[i]) : e->ceiling[i] + ROOF;
    }
}

static void index_input(Enclosure *e) {
    const Sketch *s = e->sketch;
    Box *walls = ARENA_ARRAY(e->scratch, Box, s->wall_count),
        *rooms = ARENA_ARRAY(e->scratch, Box, s->room_count);
    for (int i = 0; i < s->wall_count; i++) {
        const Shape *w = &e->walls[i];
        walls[i] = e->wall_bounds[i] ? enclose_box(w->min, w->max, s->walls[i].storey) : box_empty();
    }
    for (int i = 0; i < s->room_count; i++) {
        const Shape *r = &e->rooms[i];
        rooms[i] = e->room_used[i] ? enclose_box(r->min, r->max, s->rooms[i].storey) : box_empty();
    }
    e->wall_tree = box_tree_build(walls, s->wall_count, e->scratch);
    e->room_tree = box_tree_build(rooms, s->room_count, e->scratch);
}

// On success the points used are sound; the sketch may still be wrong in any other way.
bool enclose_prepare(Enclosure *e) {
    const Sketch *s = e->sketch;
    if (!check_sketch(e)) return false;
    if (s->wall_count + s->room_count + s->opening_count == 0) {
        return error_set(e->error, "the plan is empty: no walls, rooms or openings");
    }
    e->walls = ARENA_ARRAY(e->scratch, Shape, s->wall_count);
    e->rooms = ARENA_ARRAY(e->scratch, Shape, s->room_count);
    e->cutouts = ARENA_ARRAY(e->scratch, Shape, s->cutout_count);
    e->wall_bounds = ARENA_ARRAY(e->scratch, bool, s->wall_count);
    e->room_used = ARENA_ARRAY(e->scratch, bool, s->room_count);
    e->cutout_used = ARENA_ARRAY(e->scratch, bool, s->cutout_count);
    e->room_wall = ARENA_ARRAY(e->scratch, double, s->room_count);
    e->holes = ARENA_ARRAY(e->scratch, Hole, s->opening_count);
    int storeys = e->b->storey_count;
    e->floor = ARENA_ARRAY(e->scratch, double, storeys);
    e->ceiling = ARENA_ARRAY(e->scratch, double, storeys);
    e->base = ARENA_ARRAY(e->scratch, double, storeys);
    e->cover = ARENA_ARRAY(e->scratch, double, storeys);
    e->implicit = ARENA_ARRAY(e->scratch, ShapeList, storeys);
    e->plugs = ARENA_ARRAY(e->scratch, ShapeList, storeys);
    e->slits = ARENA_ARRAY(e->scratch, ShapeList, storeys);
    find_origin(e);
    find_heights(e);
    sort_walls(e);
    sort_rooms(e);
    return true;
}

bool enclose_find_world(Enclosure *e) {
    index_input(e);
    return find_world(e);
}

// ---- implicit walls

// Closes rooms by walls of a usual thickness in a plan without any walls, and on a storey without walls but with
// doors (a storey without walls and doors is a roof terrace).
static void assume_walls(Enclosure *e) {
    const Sketch *s = e->sketch;
    int walls = 0;
    for (int i = 0; i < s->wall_count; i++) walls += e->wall_bounds[i];
    for (int k = 0; k < e->b->storey_count; k++) {
        int here = 0, doors = 0, first = -1;
        for (int i = 0; i < s->wall_count; i++) here += e->wall_bounds[i] && s->walls[i].storey == k;
        for (int i = 0; i < s->opening_count; i++) doors += s->openings[i].storey == k;
        if (here || (walls && !doors)) continue;
        for (int i = s->room_count - 1; i >= 0; i--) {
            if (!e->room_used[i] || s->rooms[i].storey != k || e->room_wall[i] > 0) continue;
            e->room_wall[i] = ASSUMED_WALL;
            first = i;
        }
        if (first < 0) continue;
        Vec3 p = enclose_place(e, e->rooms[first].points[0], k);
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "storey %d (%s) has rooms but no walls, the first at (%.2f, %.2f): they are closed by "
                      "walls of %g m",
                      k, enclose_text(e->b->storeys[k].name), p.x, p.y, ASSUMED_WALL / ENCLOSE_MM);
    }
}

// Takes ownership of the parts. Makes one union of all, since joining them one by one would go over all earlier parts each time.
static GEOSGeometry *unite(Enclosure *e, GEOSGeometry **parts, int count) {
    GEOSGeometry *all = GEOSGeom_createCollection_r(e->geos, GEOS_GEOMETRYCOLLECTION, parts, (unsigned)count);
    GEOSGeometry *joined = all ? GEOSUnaryUnion_r(e->geos, all) : NULL;
    if (all) GEOSGeom_destroy_r(e->geos, all);
    return joined;
}

static GEOSGeometry *buffer(Enclosure *e, const GEOSGeometry *g, double by) {
    return g ? GEOSBufferWithStyle_r(e->geos, g, by, 8, GEOSBUF_CAP_FLAT, GEOSBUF_JOIN_MITRE, MITRE_LIMIT)
             : NULL;
}

// Grows the outline of a room by its wall and appends the shapes to e->grown. NULL on failure.
static GEOSGeometry *grow_room(Enclosure *e, int room, const GEOSGeometry *outline) {
    GEOSGeometry *grown = buffer(e, outline, e->room_wall[room]);
    ShapeList shapes = {NULL, 0, 0};
    if (grown) shapes_from_geos(e, grown, 0, &shapes);
    for (int i = 0; i < shapes.count; i++)
        *ARENA_PUSH(e->scratch, e->grown, e->grown_count, e->grown_capacity) = (Grown){shapes.items[i], room};
    return grown;
}

static void index_grown(Enclosure *e) {
    Box *boxes = ARENA_ARRAY(e->scratch, Box, e->grown_count);
    for (int i = 0; i < e->grown_count; i++) {
        const Shape *shape = &e->grown[i].shape;
        boxes[i] = enclose_box(shape->min, shape->max, e->sketch->rooms[e->grown[i].room].storey);
    }
    e->grown_tree = box_tree_build(boxes, e->grown_count, e->scratch);
}

// A room with an implicit wall. Rooms whose implicit walls are connected form a group, named by the lowest room index in it.
typedef struct Member {
    int group, room;
    int first_grown, place;  // in e->grown; in the order of e->grown_tree, which keeps neighbours together
    GEOSGeometry *outline, *grown;
} Member;

static int by_group(const void *pa, const void *pb) {
    const Member *a = pa, *b = pb;
    return a->group != b->group ? a->group - b->group : a->room - b->room;
}

static int by_place(const void *pa, const void *pb) {
    const Member *a = pa, *b = pb;
    return (a->place > b->place) - (a->place < b->place);
}

static void find_groups(Enclosure *e, Member *members, int count) {
    int *parent = ARENA_ARRAY(e->scratch, int, e->sketch->room_count);
    for (int i = 0; i < e->sketch->room_count; i++) parent[i] = i;
    for (int i = 0; i < e->grown_count; i++) {
        box_tree_find(&e->grown_tree, e->grown_tree.boxes[i], e->scratch, &e->near);
        for (int k = 0; k < e->near.count; k++)
            set_unite(parent, e->grown[i].room, e->grown[e->near.items[k]].room);
    }
    int *place = ARENA_ARRAY(e->scratch, int, e->grown_count);
    for (int i = 0; i < e->grown_tree.count; i++) place[e->grown_tree.order[i]] = i;
    for (int i = 0; i < count; i++) {
        members[i].group = set_find(parent, members[i].room);
        if (members[i].first_grown < e->grown_count) members[i].place = place[members[i].first_grown];
    }
    qsort(members, (size_t)count, sizeof *members, by_group);
}

// The grown outlines less the outlines, of which both are taken.
static bool add_walls(Enclosure *e, int storey, GEOSGeometry **grown, int grown_count,
                      GEOSGeometry **outlines, int outline_count) {
    GEOSGeometry *outer = unite(e, grown, grown_count), *inner = unite(e, outlines, outline_count),
                 *solid = outer && inner ? GEOSDifference_r(e->geos, outer, inner) : NULL;
    if (solid) shapes_from_geos(e, solid, NARROWEST_PLUG, &e->implicit[storey]);
    bool made = solid != NULL;
    if (solid) GEOSGeom_destroy_r(e->geos, solid);
    if (outer) GEOSGeom_destroy_r(e->geos, outer);
    if (inner) GEOSGeom_destroy_r(e->geos, inner);
    return made || error_set(e->error, "the walls around the rooms of storey %d cannot be made: %s", storey,
                             e->geos_message);
}

// The rooms that the grown outlines of these reach, themselves among them, as places in `all`. `stamp` has been below `mark` so far.
static int rooms_reached(Enclosure *e, const Member *members, int count, const int *place_of_room, int mark,
                         int *stamp, int *out) {
    int reached = 0;
    for (int i = 0; i < count; i++) {
        for (int g = members[i].first_grown; g < e->grown_count && e->grown[g].room == members[i].room; g++) {
            box_tree_find(&e->grown_tree, e->grown_tree.boxes[g], e->scratch, &e->near);
            for (int k = 0; k < e->near.count; k++) {
                int place = place_of_room[e->grown[e->near.items[k]].room];
                if (stamp[place] == mark) continue;
                stamp[place] = mark;
                out[reached++] = place;
            }
        }
    }
    return reached;
}

// Makes the implicit walls around the rooms of one group; of many rooms part by part, since the walls are large polygons with a hole for
// each room. A part's walls leave out the rooms of other parts; where they overlap the walls of others, they are as these.
static bool add_group(Enclosure *e, Member *members, int count, int *place_of_room, int *stamp) {
    enum { PART = 256 };
    int parts = (count + PART - 1) / PART, storey = e->sketch->rooms[members->room].storey;
    GEOSGeometry **outlines = ARENA_ARRAY(e->scratch, GEOSGeometry *, count),
                 **grown = ARENA_ARRAY(e->scratch, GEOSGeometry *, count);
    int *reached = parts > 1 ? ARENA_ARRAY(e->scratch, int, count) : NULL;
    bool made = true;
    if (parts > 1) qsort(members, (size_t)count, sizeof *members, by_place);
    for (int i = 0; i < count; i++) {
        place_of_room[members[i].room] = i;
        stamp[i] = -1;
    }
    for (int part = 0; part < parts; part++) {
        int first = part * PART, own = count - first < PART ? count - first : PART, others = own;
        if (parts > 1) others = rooms_reached(e, members + first, own, place_of_room, part, stamp, reached);
        for (int i = 0; i < own; i++) grown[i] = members[first + i].grown;
        for (int i = 0; i < others; i++)
            outlines[i] =
                parts > 1 ? GEOSGeom_clone_r(e->geos, members[reached[i]].outline) : members[i].outline;
        made = add_walls(e, storey, grown, own, outlines, others) && made;
    }
    for (int i = 0; i < count && parts > 1; i++) GEOSGeom_destroy_r(e->geos, members[i].outline);
    return made;
}

bool enclose_implicit_walls(Enclosure *e) {
    const Sketch *s = e->sketch;
    assume_walls(e);
    Member *members = ARENA_ARRAY(e->scratch, Member, s->room_count);
    int count = 0, *place_of_room = ARENA_ARRAY(e->scratch, int, s->room_count),
        *stamp = ARENA_ARRAY(e->scratch, int, s->room_count);
    for (int i = 0; i < s->room_count; i++) {
        if (!e->room_used[i] || e->room_wall[i] <= 0) continue;
        int first = e->grown_count;
        GEOSGeometry *outline = shape_to_geos(e, &e->rooms[i]), *grown = grow_room(e, i, outline);
        if (grown)
            members[count++] =
                (Member){.room = i, .first_grown = first, .place = i, .outline = outline, .grown = grown};
        else if (outline)
            GEOSGeom_destroy_r(e->geos, outline);
    }
    index_grown(e);
    find_groups(e, members, count);
    bool made = true;
    for (int i = 0, next; i < count; i = next) {
        for (next = i + 1; next < count && members[next].group == members[i].group;) next++;
        made = add_group(e, members + i, next - i, place_of_room, stamp) && made;
    }
    return made;
}

// ---- small gaps

// Fills gaps of up to GAP between walls, or walls and openings: the fillings are these grown and shrunk again, less the originals.
bool enclose_plugs(Enclosure *e, bool *any) {
    const Sketch *s = e->sketch;
    *any = false;
    for (int k = 0; k < e->b->storey_count; k++) {
        GEOSGeometry **solid =
            ARENA_ARRAY(e->scratch, GEOSGeometry *, s->wall_count + s->opening_count + e->slits[k].count);
        int count = 0;
        for (int i = 0; i < s->wall_count; i++) {
            if (!e->wall_bounds[i] || s->walls[i].storey != k) continue;
            GEOSGeometry *wall = shape_to_geos(e, &e->walls[i]);
            if (wall) solid[count++] = wall;
        }
        if (count == 0) continue;
        for (int i = 0; i < s->opening_count; i++) {
            if (!e->holes[i].used || s->openings[i].storey != k) continue;
            GEOSGeometry *box = shape_to_geos(e, &e->holes[i].box);
            if (box) solid[count++] = box;
        }
        for (int i = 0; i < e->slits[k].count; i++) {
            GEOSGeometry *slit = shape_to_geos(e, &e->slits[k].items[i]);
            if (slit) solid[count++] = slit;
        }
        GEOSGeometry *joined = unite(e, solid, count);
        GEOSGeometry *grown = buffer(e, joined, GAP / 2), *closed = buffer(e, grown, -GAP / 2);
        GEOSGeometry *plugs = closed ? GEOSDifference_r(e->geos, closed, joined) : NULL;
        if (plugs) shapes_from_geos(e, plugs, NARROWEST_PLUG, &e->plugs[k]);
        GEOSGeometry *made[4] = {joined, grown, closed, plugs};
        for (int i = 0; i < 4; i++) {
            if (made[i]) GEOSGeom_destroy_r(e->geos, made[i]);
        }
        *any = *any || e->plugs[k].count > 0;
    }
    return true;
}
