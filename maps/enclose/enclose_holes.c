// enclose_holes.c - the plan boxes of doors and windows, fitted to the walls they stand in.
//
// A model's depth says little: doors are drawn ajar, windows thinner than their wall. A box therefore reaches
// through all walls of about its direction that it meets, also through two walls with a void between; where it
// meets no wall, it has the model's depth.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// A wall belongs to an opening when the sine of the angle between them is at most this: 30 degrees.
static const double PARALLEL = 0.5;
// The wall and the box must overlap by this, mm along the depth, and by this share of the width.
static const double LEAST_OVERLAP = 5, LEAST_SHARE = 0.1;
// Boxes without a wall are at least this deep, mm: both halves of a door need a place.
static const double LEAST_DEPTH = 40;
// No wall is thicker than this, mm.
static const double THICKEST_WALL = 2000;
// A box is extended through further walls by up to this to reach free space, mm; voids of up to VOID on the way
// are crossed.
static const double EXTENSION = 300, VOID = 50;
// How far from its box an opening's implicit wall may lie, mm.
static const double IMPLICIT_REACH = 300;
// A sill less than this above the floor is put on the floor, mm.
static const double SILL_SLACK = 20;
// Openings narrower or lower than this are dropped, mm.
static const double LEAST_SIZE = 10;
// Each half of a door is at least this deep, mm.
static const double LEAST_HALF = 5;
// Polygons of a leaf lie along its opening where the cosine between their normals is at least this.
static const double ALONG_LEAF = 0.9;
// Polygons of a leaf within this depth are one sheet, mm; one with less than this share of the largest sheet's area is none.
static const double SHEET_DEPTH = 1, SHEET_SHARE = 0.25;
// The end of a wall that stands this near beside an opening was meant to reach it, mm; nobody passes through a gap of a hand's width.
static const double WIDEST_SLIT = 100;
// Gaps up to this are noise of the grid, which slivers take (enclose_cover.c), mm.
static const double NARROWEST_SLIT = 2.5;
// A slit is seen through at points this far before and behind the opening, mm.
static const double BEFORE_SLIT = 10;
enum { SAMPLES = 5 };  // lines along the depth or the width that are probed

typedef struct Reach {
    double u0, u1, v0, v1;
} Reach;

static Vec2 in_frame(const Hole *h, Vec2 p) {
    Vec2 d = vec2_sub(p, h->centre);
    return vec2(vec2_dot(d, h->u), vec2_dot(d, h->n));
}

static Vec2 from_frame(const Hole *h, double u, double v) {
    return vec2_add(h->centre, vec2_add(vec2_scale(h->u, u), vec2_scale(h->n, v)));
}

// The extent of a polygon within the opening's width, in the opening's frame.
static Reach reach_of(const Hole *h, const Shape *shape) {
    Reach r = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    int n = shape->ring[1];
    for (int i = 0; i < n; i++) {
        Vec2 a = in_frame(h, shape->points[i]), b = in_frame(h, shape->points[(i + 1) % n]);
        double t0 = 0, t1 = 1, d = b.x - a.x;
        if (d == 0 && fabs(a.x) > h->half) continue;
        if (d != 0) {
            double p = (-h->half - a.x) / d, q = (h->half - a.x) / d;
            t0 = fmax(0, fmin(p, q));
            t1 = fmin(1, fmax(p, q));
        }
        if (t0 > t1) continue;
        for (int k = 0; k < 2; k++) {
            double t = k ? t1 : t0, u = a.x + t * d, v = a.y + t * (b.y - a.y);
            r = (Reach){fmin(r.u0, u), fmax(r.u1, u), fmin(r.v0, v), fmax(r.v1, v)};
        }
    }
    return r;
}

// Searches a tree for items within `reach` (mm) of the opening and puts them into e->near. Returns their number.
static int find_near(Enclosure *e, const BoxTree *tree, const SketchOpening *o, const Hole *h, double reach) {
    return box_tree_find(tree, enclose_around(h->centre, h->half + reach, o->storey), e->scratch, &e->near);
}

// Fits the box to the walls that it meets, or to walls that end within `beside` (mm) of its jambs.
static bool fit_to_walls(Enclosure *e, const SketchOpening *o, Hole *h, double depth, double beside) {
    double v0 = INFINITY, v1 = -INFINITY, least = fmax(LEAST_SHARE * 2 * h->half - beside, LEAST_OVERLAP);
    Hole wide = *h;
    wide.half += beside;
    for (int k = find_near(e, &e->wall_tree, o, h, depth + beside); k-- > 0;) {
        int i = e->near.items[k];
        double angle = e->sketch->walls[i].angle;
        if (fabs(cos(angle) * h->u.y - sin(angle) * h->u.x) > PARALLEL) continue;
        Reach r = reach_of(&wide, &e->walls[i]);
        if (r.u1 - r.u0 < least || r.v1 - r.v0 > THICKEST_WALL) continue;
        if (fmin(r.v1, depth / 2) - fmax(r.v0, -depth / 2) < fmin(LEAST_OVERLAP, (r.v1 - r.v0) / 2)) continue;
        v0 = fmin(v0, r.v0);
        v1 = fmax(v1, r.v1);
    }
    if (!(v0 < v1)) return false;
    h->v0 = v0;
    h->v1 = v1;
    return true;
}

// ---- probing along a line u = const

typedef struct Cover {
    double v0, v1;
} Cover;

enum { COVERS = 256 };  // no real plan has more on one line; the rest is ignored
typedef struct Covers {
    Cover items[COVERS];
    int count;
} Covers;

static int by_value(const void *pa, const void *pb) {
    double a = *(const double *)pa, b = *(const double *)pb;
    return (a > b) - (a < b);
}

static void cover_by(const Hole *h, const Shape *shape, double u, Covers *covers) {
    double cuts[64] = {0};
    int count = 0;
    for (int r = 0; r < shape->ring_count; r++) {
        for (int i = shape->ring[r], j = shape->ring[r + 1] - 1; i < shape->ring[r + 1]; j = i++) {
            Vec2 a = in_frame(h, shape->points[i]), b = in_frame(h, shape->points[j]);
            if ((a.x > u) == (b.x > u) || count == 64) continue;
            cuts[count++] = a.y + (b.y - a.y) * (u - a.x) / (b.x - a.x);
        }
    }
    qsort(cuts, (size_t)count, sizeof *cuts, by_value);
    for (int i = 0; i + 1 < count && covers->count < COVERS; i += 2)
        covers->items[covers->count++] = (Cover){cuts[i], cuts[i + 1]};
}

static double sample_at(const Hole *h, int i) { return h->half * 0.8 * (2.0 * i / (SAMPLES - 1) - 1); }

// Follows cover from v in the direction `way` (+1, -1), across voids of up to VOID, and returns where the cover ends.
static double end_of_cover(const Covers *covers, double v, double way) {
    for (bool moved = true; moved;) {
        moved = false;
        for (int i = 0; i < covers->count; i++) {
            double near = way > 0 ? covers->items[i].v0 : -covers->items[i].v1;
            double far = way > 0 ? covers->items[i].v1 : -covers->items[i].v0;
            if (near > v * way + VOID || far <= v * way + MAPS_GRID) continue;
            v = far * way;
            moved = true;
        }
    }
    return v;
}

static void extend(Enclosure *e, const SketchOpening *o, Hole *h) {
    double more[2][SAMPLES];
    int count = find_near(e, &e->wall_tree, o, h, THICKEST_WALL);
    for (int s = 0; s < SAMPLES; s++) {
        Covers covers = {.count = 0};
        for (int i = 0; i < count; i++) cover_by(h, &e->walls[e->near.items[i]], sample_at(h, s), &covers);
        more[0][s] = h->v0 - end_of_cover(&covers, h->v0, -1);
        more[1][s] = end_of_cover(&covers, h->v1, 1) - h->v1;
    }
    for (int way = 0; way < 2; way++) {
        qsort(more[way], SAMPLES, sizeof(double), by_value);
        // It is enough that half of the width is free: a wall may really stand across the other half.
        double by = more[way][SAMPLES / 2];
        if (by > EXTENSION) by = more[way][0];
        if (by > EXTENSION) by = 0;
        if (way)
            h->v1 += by;
        else
            h->v0 -= by;
    }
}

// Sorts covers and joins those that overlap or touch.
static void join_covers(Covers *covers) {
    int kept = 0;
    qsort(covers->items, (size_t)covers->count, sizeof(Cover), by_value);  // by v0, the first member
    for (int i = 0; i < covers->count; i++) {
        Cover c = covers->items[i];
        if (kept > 0 && c.v0 <= covers->items[kept - 1].v1 + MAPS_GRID) {
            covers->items[kept - 1].v1 = fmax(covers->items[kept - 1].v1, c.v1);
        } else {
            covers->items[kept++] = c;
        }
    }
    covers->count = kept;
}

// Collects the stretches of the line u that implicit walls cover: the grown outlines in e->near less their rooms.
static void cover_by_implicit(const Enclosure *e, const Hole *h, double u, Covers *out) {
    Covers grown = {.count = 0}, rooms = {.count = 0};
    for (int i = 0; i < e->near.count; i++) {
        const Grown *g = &e->grown[e->near.items[i]];
        cover_by(h, &g->shape, u, &grown);
        cover_by(h, &e->rooms[g->room], u, &rooms);
    }
    join_covers(&grown);
    join_covers(&rooms);
    for (int i = 0; i < grown.count; i++) {
        Cover left = grown.items[i];
        for (int k = 0; k < rooms.count; k++) {
            Cover room = rooms.items[k];
            if (room.v1 <= left.v0 || room.v0 >= left.v1) continue;
            if (room.v0 > left.v0 && out->count < COVERS)
                out->items[out->count++] = (Cover){left.v0, room.v0};
            left.v0 = room.v1;
        }
        if (left.v0 < left.v1 && out->count < COVERS) out->items[out->count++] = left;
    }
}

// Fits the box through the implicit walls nearest to the centre on all sample lines.
static bool fit_to_implicit(Enclosure *e, const SketchOpening *o, Hole *h, double depth) {
    double v0 = INFINITY, v1 = -INFINITY, reach = depth / 2 + IMPLICIT_REACH;
    find_near(e, &e->grown_tree, o, h, reach + THICKEST_WALL);
    for (int s = 0; s < SAMPLES; s++) {
        Covers covers = {.count = 0};
        cover_by_implicit(e, h, sample_at(h, s), &covers);
        int best = -1;
        double nearest = reach;
        for (int i = 0; i < covers.count; i++) {
            Cover c = covers.items[i];
            double away = fmax(0, fmax(c.v0, -c.v1));
            if (away >= nearest || c.v1 - c.v0 > THICKEST_WALL) continue;
            nearest = away;
            best = i;
        }
        if (best < 0) continue;
        v0 = fmin(v0, covers.items[best].v0);
        v1 = fmax(v1, covers.items[best].v1);
    }
    if (!(v0 < v1) || v1 - v0 > THICKEST_WALL) return false;
    h->v0 = v0;
    h->v1 = v1;
    return true;
}

static bool fit_heights(Enclosure *e, const SketchOpening *o, Hole *h) {
    double floor = e->floor[o->storey], ceiling = e->ceiling[o->storey];
    for (int k = find_near(e, &e->room_tree, o, h, EXTENSION); k-- > 0;) {
        const SketchRoom *r = &e->sketch->rooms[e->near.items[k]];
        if (!isnan(r->z1)) ceiling = fmax(ceiling, nearbyint(r->z1 * ENCLOSE_MM));
        if (!isnan(r->z0) && nearbyint(o->sill * ENCLOSE_MM) <= nearbyint(r->z0 * ENCLOSE_MM) + SILL_SLACK) {
            floor = fmin(floor, nearbyint(r->z0 * ENCLOSE_MM));
        }
    }
    h->sill = nearbyint(o->sill * ENCLOSE_MM);
    h->head = fmin(nearbyint(o->head * ENCLOSE_MM), ceiling);
    if (h->sill < floor + SILL_SLACK) h->sill = floor;
    return h->head - h->sill >= LEAST_SIZE && 2 * h->half >= LEAST_SIZE;
}

// A polygon of a leaf that lies along its opening: where across it, and how large.
typedef struct LeafSheet {
    double place, area;
} LeafSheet;

static int by_sheet_place(const void *pa, const void *pb) {
    double a = ((const LeafSheet *)pa)->place, b = ((const LeafSheet *)pb)->place;
    return (a > b) - (a < b);
}

// The middle between the two outer sheets of a leaf; handles are no sheets. `sheets` are sorted.
static double middle_of_sheets(const LeafSheet *sheets, int count) {
    double greatest = 0, first = INFINITY, last = -INFINITY;
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0, end; i < count; i = end) {
            double area = 0;
            for (end = i; end < count && sheets[end].place - sheets[i].place <= SHEET_DEPTH; end++)
                area += sheets[end].area;
            greatest = fmax(greatest, area);
            if (pass == 0 || area < SHEET_SHARE * greatest) continue;
            first = fmin(first, sheets[i].place);
            last = fmax(last, sheets[end - 1].place);
        }
    }
    return (first + last) / 2;
}

// Where the leaf's middle lies across its opening, mm along the normal from the centre; NAN where none of its polygons lies along the
// opening.
static double leaf_place(Enclosure *e, const SketchOpening *o, const Object *leaf) {
    LeafSheet *sheets = ARENA_ARRAY(e->scratch, LeafSheet, leaf->polygon_count + 1);
    int count = 0;
    Vec3 n = vec3(-sin(o->angle), cos(o->angle), 0);
    for (int p = leaf->first_polygon; p < leaf->first_polygon + leaf->polygon_count; p++) {
        const Vec3 *v = e->b->vertices + e->b->polygons[p].first_vertex;
        int corners = e->b->polygons[p].vertex_count;
        if (fabs(vec3_dot(plane_of_polygon(v, corners).n, n)) < ALONG_LEAF) continue;
        Vec2 at = vec2_sub(vec2(v[0].x, v[0].y), o->centre);
        sheets[count++] = (LeafSheet){vec2_dot(at, vec2(n.x, n.y)) * ENCLOSE_MM, polygon_area(v, corners)};
    }
    qsort(sheets, (size_t)count, sizeof *sheets, by_sheet_place);
    return count > 0 ? middle_of_sheets(sheets, count) : NAN;
}

// Where along its normal each opening closes: in the middle of its leaves, so that no dark gap is left between a leaf and what closes the
// opening; NAN without leaves. [opening_count]
static double *find_closing(Enclosure *e) {
    int openings = e->sketch->opening_count;
    double *closing = ARENA_ARRAY(e->scratch, double, openings + 1);
    int *leaves = ARENA_ARRAY(e->scratch, int, openings + 1);
    for (int i = 0; i < e->b->object_count; i++) {
        const Object *object = &e->b->objects[i];
        if (object->leaf < 0 || object->opening < 0) continue;
        double place = leaf_place(e, &e->sketch->openings[object->opening], object);
        if (isnan(place)) continue;
        closing[object->opening] += place;
        leaves[object->opening]++;
    }
    for (int i = 0; i < openings; i++) closing[i] = leaves[i] > 0 ? closing[i] / leaves[i] : NAN;
    return closing;
}

static void fit(Enclosure *e, int i, double closing) {
    const SketchOpening *o = &e->sketch->openings[i];
    Hole *h = &e->holes[i];
    *h = (Hole){.opening = -1};
    h->centre = enclose_local(e, o->centre);
    Vec3 p = enclose_place(e, h->centre, o->storey);
    if (o->storey < 0 || o->storey >= e->b->storey_count) {
        building_note(e->arena, e->b, NOTE_DROPPED, p, "%s left out: storey %d (there are %d)",
                      enclose_text(o->place), o->storey, e->b->storey_count);
        return;
    }
    h->u = vec2(cos(o->angle), sin(o->angle));
    h->n = vec2(-h->u.y, h->u.x);
    h->half = fabs(o->width) / 2 * ENCLOSE_MM;
    double depth = fmax(fabs(o->depth) * ENCLOSE_MM, LEAST_DEPTH);
    h->v0 = -depth / 2;
    h->v1 = depth / 2;
    if (!fit_heights(e, o, h)) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f) left out: %g m wide, from %g m up to %g m under a ceiling at %g m",
                      enclose_text(o->place), p.x, p.y, o->width, o->sill, o->head,
                      e->ceiling[o->storey] / ENCLOSE_MM);
        return;
    }
    h->walled = fit_to_walls(e, o, h, depth, 0) || fit_to_walls(e, o, h, depth, WIDEST_SLIT);
    if (h->walled)
        extend(e, o, h);
    else
        h->walled = fit_to_implicit(e, o, h, depth);
    if (h->v1 - h->v0 < 2 * LEAST_HALF) {
        // The wall is thinner than a door's halves can be, so the box stands out of it.
        double middle = (h->v0 + h->v1) / 2;
        h->v0 = middle - LEAST_HALF;
        h->v1 = middle + LEAST_HALF;
    }
    double line =
        isnan(closing) ? (h->v0 + h->v1) / 2 : fmin(fmax(closing, h->v0 + LEAST_HALF), h->v1 - LEAST_HALF);
    Vec2 corners[4] = {from_frame(h, -h->half, h->v0), from_frame(h, h->half, h->v0),
                       from_frame(h, h->half, h->v1), from_frame(h, -h->half, h->v1)};
    h->line[0] = from_frame(h, -h->half, line);
    h->line[1] = from_frame(h, h->half, line);
    h->box = shape_of_points(e->scratch, corners, 4);
    h->used = true;
}

static void index_holes(Enclosure *e) {
    int count = e->sketch->opening_count;
    Box *boxes = ARENA_ARRAY(e->scratch, Box, count);
    for (int i = 0; i < count; i++) {
        const Hole *h = &e->holes[i];
        boxes[i] = h->used ? enclose_box(h->box.min, h->box.max, e->sketch->openings[i].storey) : box_empty();
    }
    e->hole_tree = box_tree_build(boxes, count, e->scratch);
}

void holes_fit(Enclosure *e) {
    const double *closing = find_closing(e);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        fit(e, i, closing[i]);
        for (int k = 0; e->holes[i].used && k < 4; k++) {
            Vec2 p = e->holes[i].box.points[k];
            double out = MAPS_OUTDOORS * ENCLOSE_MM / 2;  // wide doors still keep clear of the world's edge
            e->world_min =
                vec2(fmin(e->world_min.x, floor(p.x - out)), fmin(e->world_min.y, floor(p.y - out)));
            e->world_max = vec2(fmax(e->world_max.x, ceil(p.x + out)), fmax(e->world_max.y, ceil(p.y + out)));
        }
    }
    crossings_limit_holes(e);
    index_holes(e);
}

bool holes_wall_at(Enclosure *e, int storey, Vec2 p) {
    Box point = enclose_box(p, p, storey);
    for (int k = box_tree_find(&e->wall_tree, point, e->scratch, &e->near); k-- > 0;) {
        if (shape_contains(&e->walls[e->near.items[k]], p)) return true;
    }
    for (int k = box_tree_find(&e->hole_tree, point, e->scratch, &e->near); k-- > 0;) {
        if (shape_contains(&e->holes[e->near.items[k]].box, p)) return true;
    }
    return false;
}

// ---- slits beside openings

// The walls and other openings near an opening; of more than COVERS the rest is ignored. Returns their number.
static int find_beside(Enclosure *e, const SketchOpening *o, int hole, const Shape *out[COVERS]) {
    const Hole *h = &e->holes[hole];
    double reach = WIDEST_SLIT + fmax(fabs(h->v0), fabs(h->v1));
    int count = 0;
    for (int k = find_near(e, &e->wall_tree, o, h, reach); k-- > 0 && count < COVERS;)
        out[count++] = &e->walls[e->near.items[k]];
    for (int k = find_near(e, &e->hole_tree, o, h, reach); k-- > 0 && count < COVERS;)
        if (e->near.items[k] != hole) out[count++] = &e->holes[e->near.items[k]].box;
    return count;
}

// The distance from a jamb outwards to the shape next to it, on the line at v; INFINITY: there is none.
static double gap_beside(const Hole *h, const Shape *const *shapes, int count, int way, double v) {
    Hole across = *h;  // the opening turned, so that its width lies where its depth lay
    across.u = h->n;
    across.n = vec2_scale(h->u, way);
    Covers covers = {.count = 0};
    double nearest = INFINITY;
    for (int i = 0; i < count; i++) cover_by(&across, shapes[i], v, &covers);
    for (int i = 0; i < covers.count; i++)
        if (covers.items[i].v1 > h->half + MAPS_GRID * ENCLOSE_MM)
            nearest = fmin(nearest, fmax(0, covers.items[i].v0 - h->half));
    return nearest;
}

// Closes the slit on one side of an opening, if it is one: most lines along the width meet a wall soon, and not at once, and one sees
// through between. Returns its width, mm; 0: there is none.
static double close_slit(Enclosure *e, const SketchOpening *o, int hole, const Shape *const *beside,
                         int count, int way) {
    const Hole *h = &e->holes[hole];
    double gaps[SAMPLES], widest = 0;
    for (int s = 0; s < SAMPLES; s++)
        gaps[s] = gap_beside(h, beside, count, way, h->v0 + (h->v1 - h->v0) * (s + 0.5) / SAMPLES);
    qsort(gaps, SAMPLES, sizeof *gaps, by_value);
    if (gaps[SAMPLES / 2] > WIDEST_SLIT || gaps[SAMPLES / 2] <= NARROWEST_SLIT) return 0;
    for (int s = 0; s < SAMPLES; s++)
        if (gaps[s] <= WIDEST_SLIT) widest = gaps[s];
    double middle = way * (h->half + gaps[0] / 2);
    if (holes_wall_at(e, o->storey, from_frame(h, middle, h->v0 - BEFORE_SLIT)) ||
        holes_wall_at(e, o->storey, from_frame(h, middle, h->v1 + BEFORE_SLIT)))
        return 0;
    double jamb = way * h->half, end = way * (h->half + widest);
    Vec2 corners[4] = {from_frame(h, jamb, h->v0), from_frame(h, end, h->v0), from_frame(h, end, h->v1),
                       from_frame(h, jamb, h->v1)};
    ShapeList *list = &e->slits[o->storey];
    *ARENA_PUSH(e->scratch, list->items, list->count, list->capacity) =
        shape_of_points(e->scratch, corners, 4);
    return widest;
}

void holes_close_slits(Enclosure *e) {
    const Shape *beside[COVERS];
    for (int i = 0; i < e->sketch->opening_count; i++) {
        const SketchOpening *o = &e->sketch->openings[i];
        int count = e->holes[i].used ? find_beside(e, o, i, beside) : 0;
        for (int way = -1; count > 0 && way <= 1; way += 2) {
            double width = close_slit(e, o, i, beside, count, way);
            if (width <= e->widest_slit) continue;
            e->widest_slit = width;
            e->slit_opening = i;
        }
    }
}
