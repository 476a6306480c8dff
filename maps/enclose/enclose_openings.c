// enclose_openings.c - doors and windows in the building: their lines on the grid, their leaves, and, once the regions exist, the
// regions that they join and the spandrels around openings that are not rectangles.
#include <stdlib.h>

#include "maps/enclose/enclose.h"

// An end of a door's line lies within this of its vertex on the grid, mm.
static const double LINE_REACH = 3;

// ---- leaves: those of the model, or one or two boxes that fill the doorway. A glazed leaf is a frame around a pane, unless its
// material is transparent.

// A leaf keeps this clear of jamb, sill and head, metres: more than VIS_TOUCH and than the planes' noise.
static const double INSET = 0.01;
// The thickness of a leaf, metres, but at most this share of the wall's depth.
static const double THICKNESS = 0.04, THICKNESS_IN_WALL = 0.6;
// The frame of a glazed leaf, metres.
static const double STILE = 0.09, RAIL = 0.09, KICK = 0.2;
// Leaves narrower or lower than this get no frame, metres.
static const double LEAST_GLAZED = 0.4;

// Makes a leaf that slides, or turns about its hinged end, far enough from the jamb for its back to clear the jamb.
static Leaf make_leaf(const Opening *o, Vec2 hinge, Vec2 tip, double thickness, double turn, Vec2 slide) {
    Vec2 along = vec2_sub(tip, hinge);
    along = vec2_scale(along, 1 / vec2_length(along));
    Vec2 start = vec2_add(hinge, vec2_scale(along, INSET));
    return (Leaf){.pivot = vec2_add(start, vec2_scale(along, thickness / 2)),
                  .turn = turn,
                  .slide = slide,
                  .axis = {start, vec2_sub(tip, vec2_scale(along, INSET))},
                  .thickness = thickness,
                  .z0 = o->sill + INSET,
                  .z1 = o->head - INSET};
}

static int make_leaves(const SketchOpening *s, const Opening *o, double depth, Leaf *out) {
    double thickness = fmin(THICKNESS, depth * THICKNESS_IN_WALL);
    Vec2 along = vec2_sub(o->line[1], o->line[0]), middle = vec2_scale(vec2_add(o->line[0], o->line[1]), 0.5);
    double width = vec2_length(along);
    Vec2 slide = vec2_scale(along, s->slide / width);
    double turn = s->slide == 0 ? s->swing : 0;
    bool two = s->hinge == 2;
    if (width / (two ? 2 : 1) <= 4 * INSET + thickness || o->head - o->sill <= 4 * INSET) return 0;
    if (turn == 0 && s->slide == 0) return 0;
    if (!two) {
        int hinge = s->hinge == 1;
        out[0] = make_leaf(o, o->line[hinge], o->line[!hinge], thickness, turn, slide);
        return 1;
    }
    out[0] = make_leaf(o, o->line[0], middle, thickness, turn, vec2_scale(slide, -1));
    out[1] = make_leaf(o, o->line[1], middle, thickness, -turn, slide);
    return 2;
}

static void append_leaves(Enclosure *e, int hole) {
    Building *b = e->b;
    const SketchOpening *s = &e->sketch->openings[hole];
    Opening *o = &b->openings[b->opening_count - 1];
    o->first_leaf = b->leaf_count;
    if (o->kind != OPENING_DOOR) return;
    Leaf leaves[SKETCH_MAX_LEAVES];
    memcpy(leaves, s->leaves, sizeof leaves);
    o->leaf_count = s->leaf_count;
    if (s->leaf_count == 0) {
        double depth = (e->holes[hole].v1 - e->holes[hole].v0) / ENCLOSE_MM;
        o->leaf_count = make_leaves(s, o, depth, leaves);
    }
    for (int i = 0; i < o->leaf_count; i++) {
        leaves[i].opening = b->opening_count - 1;
        *ARENA_APPEND(e->arena, b->leaves, b->leaf_count, b->leaf_capacity) = leaves[i];
    }
}

static void assign_leaves(Enclosure *e) {
    for (int i = 0; i < e->b->object_count; i++) {
        Object *object = &e->b->objects[i];
        if (object->opening < 0) continue;
        const Hole *hole = &e->holes[object->opening];
        object->opening = hole->used ? hole->opening : -1;
        if (object->leaf < 0) continue;
        // Without its opening a leaf stands where it was drawn.
        object->leaf = hole->used ? object->leaf + e->b->openings[hole->opening].first_leaf : -1;
    }
}

// ---- polygons

// Adds a box in the leaf's own frame: u along its axis, v up, w across.
static void add_leaf_box(Enclosure *e, const Leaf *leaf, Vec2 u, Vec2 v, double w, int material) {
    static const int SIDES[6][4] = {{0, 1, 5, 4}, {3, 2, 6, 7}, {0, 4, 6, 2},
                                    {1, 3, 7, 5}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    along = vec2_scale(along, 1 / vec2_length(along));
    Vec3 corner[8];
    for (int i = 0; i < 8; i++) {
        double x = i & 1 ? u.y : u.x, across = i & 2 ? w / 2 : -w / 2;
        corner[i] = vec3(leaf->axis[0].x + along.x * x - along.y * across,
                         leaf->axis[0].y + along.y * x + along.x * across, leaf->z0 + (i & 4 ? v.y : v.x));
    }
    for (int side = 0; side < 6; side++) {
        Vec3 quad[4];
        for (int k = 0; k < 4; k++) quad[k] = corner[SIDES[side][k]];
        building_add_polygon(e->arena, e->b, quad, 4, material);
    }
}

static void add_glazed(Enclosure *e, const Leaf *leaf, double width, double height, int material) {
    int pane = building_add_material(
        e->arena, e->b, (Material){.name = "pane", .reflectance = maps_colour(0xBCD8DE), .alpha = 0.3f});
    add_leaf_box(e, leaf, vec2(0, STILE), vec2(0, height), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(width - STILE, width), vec2(0, height), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(STILE, width - STILE), vec2(0, KICK), leaf->thickness, material);
    add_leaf_box(e, leaf, vec2(STILE, width - STILE), vec2(height - RAIL, height), leaf->thickness, material);
    Vec2 along = vec2_scale(vec2_sub(leaf->axis[1], leaf->axis[0]), 1 / width);
    Vec2 from = vec2_add(leaf->axis[0], vec2_scale(along, STILE)),
         to = vec2_sub(leaf->axis[1], vec2_scale(along, STILE));
    double z0 = leaf->z0 + KICK, z1 = leaf->z1 - RAIL;
    Vec3 quad[4] = {{from.x, from.y, z0}, {to.x, to.y, z0}, {to.x, to.y, z1}, {from.x, from.y, z1}};
    building_add_polygon(e->arena, e->b, quad, 4, pane);
}

static void draw_leaves(Enclosure *e, int hole) {
    Building *b = e->b;
    const Opening *o = &b->openings[e->holes[hole].opening];
    if (e->sketch->openings[hole].leaf_count > 0) return;
    for (int i = o->first_leaf; i < o->first_leaf + o->leaf_count; i++) {
        const Leaf *leaf = &b->leaves[i];
        Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
        double width = vec2_length(along), height = leaf->z1 - leaf->z0;
        int object = building_add_object(e->arena, b, OBJECT_LEAF, o->name);
        b->objects[object].opening = leaf->opening;
        b->objects[object].leaf = i;
        // A leaf of a transparent material needs no frame: it is one sheet.
        bool framed = o->glazed && b->materials[o->material].alpha >= 1;
        if (framed && width >= LEAST_GLAZED && height >= LEAST_GLAZED) {
            add_glazed(e, leaf, width, height, o->material);
        } else {
            add_leaf_box(e, leaf, vec2(0, width), vec2(0, height), leaf->thickness, o->material);
        }
        building_set_proxy(e->arena, b, atan2(along.y, along.x));
    }
}

// ---- spandrels: the rest of the rectangle around an arched opening, or one of any other shape, as polygons on both faces of the wall,
// and the inner side of the cut-out between them

// Spandrels stand this far inside the wall's face, metres, so that they do not lie in the wall's plane.
static const double SPANDREL_INSET = 0.005;

typedef struct Frame {
    const Hole *hole;
    double width, height;  // mm
} Frame;

static Vec3 frame_point(const Enclosure *e, const Frame *f, double u, double w, double v) {
    const Hole *h = f->hole;
    Vec2 at = vec2_add(h->centre, vec2_add(vec2_scale(h->u, u - h->half), vec2_scale(h->n, v)));
    Vec2 m = enclose_metres(e, at);
    return vec3(m.x, m.y, (h->sill + w) / ENCLOSE_MM);
}

// The materials of a wall about an opening: of its faces at Hole.v0 and v1, and within the opening.
typedef struct WallColours {
    int face[2], within;
} WallColours;

// Adds one half of the rectangle less the cut-out, as polygons on both faces of the wall.
static void add_spandrel_half(Enclosure *e, const Frame *f, const GEOSGeometry *cutout, double u0, double u1,
                              const double *v, const WallColours *colours) {
    Vec2 corners[4] = {{u0, 0}, {u1, 0}, {u1, f->height}, {u0, f->height}};
    Shape box = shape_of_points(e->scratch, corners, 4);
    GEOSGeometry *half = shape_to_geos(e, &box),
                 *rest = half ? GEOSDifference_r(e->geos, half, cutout) : NULL;
    ShapeList pieces = {NULL, 0, 0};
    if (rest) shapes_from_geos(e, rest, 1, &pieces);
    for (int i = 0; i < pieces.count; i++) {
        const Shape *piece = &pieces.items[i];
        int n = piece->ring[1];
        Vec3 *corner = ARENA_ARRAY(e->scratch, Vec3, n);
        // GEOS promises no direction of its rings; a counter-clockwise ring faces the side of v[0].
        double turn = 0;
        for (int k = 0; k < n; k++) turn += vec2_cross(piece->points[k], piece->points[(k + 1) % n]);
        for (int side = 0; side < 2; side++) {
            for (int k = 0; k < n; k++) {
                Vec2 p = piece->points[side == (turn > 0) ? n - 1 - k : k];
                corner[k] = frame_point(e, f, p.x, p.y, v[side]);
            }
            building_add_polygon(e->arena, e->b, corner, n, colours->face[side]);
        }
    }
    if (half) GEOSGeom_destroy_r(e->geos, half);
    if (rest) GEOSGeom_destroy_r(e->geos, rest);
}

// Adds the inner side of the cut-out, where it is not the rectangle's own side.
static void add_intrados(Enclosure *e, const Frame *f, const Shape *cutout, const double *v, int material) {
    for (int k = 0, n = cutout->ring[1]; k < n; k++) {
        Vec2 a = cutout->points[k], b = cutout->points[(k + 1) % n];
        bool side =
            (a.x == b.x && (a.x <= 0 || a.x >= f->width)) || (a.y == b.y && (a.y <= 0 || a.y >= f->height));
        if (side) continue;
        Vec3 quad[4] = {frame_point(e, f, a.x, a.y, v[0]), frame_point(e, f, b.x, b.y, v[0]),
                        frame_point(e, f, b.x, b.y, v[1]), frame_point(e, f, a.x, a.y, v[1])};
        building_add_polygon(e->arena, e->b, quad, 4, material);
    }
}

static void add_spandrels(Enclosure *e, int hole, const WallColours *colours) {
    const SketchOpening *s = &e->sketch->openings[hole];
    const Hole *h = &e->holes[hole];
    if (s->cutout_count < 3) return;
    Frame f = {h, 2 * h->half, h->head - h->sill};
    Vec2 *points = ARENA_ARRAY(e->scratch, Vec2, s->cutout_count);
    for (int i = 0; i < s->cutout_count; i++) {
        Vec2 p = e->sketch->points[s->first_cutout + i];
        points[i] = vec2(fmin(1, fmax(0, p.x)) * f.width, fmin(1, fmax(0, p.y)) * f.height);
    }
    Shape cutout = shape_of_points(e->scratch, points, s->cutout_count);
    GEOSGeometry *g = shape_to_geos(e, &cutout);
    double middle = (cutout.min.x + cutout.max.x) / 2,
           inset = fmin(SPANDREL_INSET * ENCLOSE_MM, (h->v1 - h->v0) / 4);
    double v[2] = {h->v0 + inset, h->v1 - inset};
    if (g) {
        building_add_object(e->arena, e->b, OBJECT_FRAME, s->name);
        add_spandrel_half(e, &f, g, 0, middle, v, colours);
        add_spandrel_half(e, &f, g, middle, f.width, v, colours);
        add_intrados(e, &f, &cutout, v, colours->within);
        GEOSGeom_destroy_r(e->geos, g);
    } else {
        Vec3 at = enclose_place(e, h->centre, s->storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "%s at (%.2f, %.2f): its cut-out is no polygon and becomes a rectangle",
                      enclose_text(s->place), at.x, at.y);
    }
}

// An edge of a region's ring.
typedef struct RingEdge {
    Vec2 from, to;
    int region, edge;  // as in Building.edge_material
} RingEdge;

static int by_ends(const void *a, const void *b) {
    const RingEdge *p = a, *q = b;
    const double at[8] = {p->from.x, p->from.y, p->to.x, p->to.y, q->from.x, q->from.y, q->to.x, q->to.y};
    for (int i = 0; i < 4; i++)
        if (at[i] != at[4 + i]) return at[i] < at[4 + i] ? -1 : 1;
    return 0;
}

static int list_ring_edges(const Building *b, int region, RingEdge *out) {
    const Region *r = &b->regions[region];
    int count = 0;
    for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
        const Ring *ring = &b->rings[k];
        for (int i = 0; i < ring->point_count; i++) {
            int from = ring->first_point + i, to = ring->first_point + (i + 1) % ring->point_count;
            out[count++] = (RingEdge){b->points[from], b->points[to], region, from};
        }
    }
    return count;
}

// A room's wall goes on above and below an opening: where the opening's region borders on the room's, the room knows the colour of the
// wall's face on that side.
static void find_face_colours(const Building *b, const Hole *h, const Enclosure *e, const RingEdge *own,
                              int own_count, const RingEdge *edges, int count, WallColours *out) {
    for (int i = 0; i < own_count; i++) {
        RingEdge back = {own[i].to, own[i].from, 0, 0};
        const RingEdge *beyond = bsearch(&back, edges, (size_t)count, sizeof *edges, by_ends);
        if (!beyond || b->regions[beyond->region].kind == REGION_OPENING) continue;
        Vec2 middle = vec2_scale(vec2_add(own[i].from, own[i].to), 0.5),
             centre = enclose_metres(e, h->centre);
        double v = ENCLOSE_MM * vec2_dot(vec2_sub(middle, centre), h->n);
        out->face[fabs(v - h->v1) < fabs(v - h->v0)] = b->edge_material[beyond->edge];
    }
}

// The colours of the wall about each opening: [opening_count]. Those of faces are looked for where an opening has spandrels.
static WallColours *wall_colours(Enclosure *e) {
    const Building *b = e->b;
    WallColours *colours = ARENA_ARRAY(e->scratch, WallColours, b->opening_count + 1);
    RingEdge *edges = ARENA_ARRAY(e->scratch, RingEdge, b->point_count + 1),
             *own = ARENA_ARRAY(e->scratch, RingEdge, b->point_count + 1);
    int count = 0, wanted = 0;
    const Hole **hole = ARENA_ARRAY(e->scratch, const Hole *, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) {
        int outer = e->sketch->outer_material;
        colours[i] = (WallColours){{outer, outer}, outer};
    }
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (!e->holes[i].used || e->sketch->openings[i].cutout_count < 3) continue;
        hole[e->holes[i].opening] = &e->holes[i];
        wanted++;
    }
    for (int r = 0; r < b->region_count && wanted > 0; r++) count += list_ring_edges(b, r, edges + count);
    qsort(edges, (size_t)count, sizeof *edges, by_ends);
    for (int r = b->region_count; r-- > 0;) {
        const Region *region = &b->regions[r];
        if (region->kind != REGION_OPENING) continue;
        WallColours *c = &colours[region->opening];
        int within = b->edge_material[b->rings[region->first_ring].first_point];
        *c = (WallColours){{within, within}, within};
        if (!hole[region->opening]) continue;
        int own_count = list_ring_edges(b, r, own);
        find_face_colours(b, hole[region->opening], e, own, own_count, edges, count, c);
    }
    return colours;
}

// ---- appending

// Lists the faces of each opening.
static void list_faces(Enclosure *e) {
    int openings = e->sketch->opening_count, faces = e->pass.plan.face_count, storeys = e->b->storey_count;
    int *first = ARENA_ARRAY(e->scratch, int, openings + 1), *fill = ARENA_ARRAY(e->scratch, int, openings);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < storeys * SPOT_HOLES; i++) {
            for (int f = 0; f < faces; f++) {
                int hole = spot_at(e, i / SPOT_HOLES, f)->hole[i % SPOT_HOLES];
                if (hole < 0) continue;
                if (pass == 0)
                    first[hole + 1]++;
                else
                    e->hole_faces[first[hole] + fill[hole]++] = f;
            }
        }
        if (pass > 0) break;
        for (int i = 0; i < openings; i++) first[i + 1] += first[i];
        e->hole_faces = ARENA_ARRAY(e->scratch, int, first[openings]);
    }
    e->hole_first = first;
}

// The plan's vertex at an end of an opening's line; of two equally near, that of the edge with the lower index.
static Vec2 on_grid(const Enclosure *e, int hole, Vec2 end) {
    const Plan *p = &e->pass.plan;
    Vec2 best = vec2(nearbyint(end.x), nearbyint(end.y));
    double nearest = LINE_REACH;
    int edge = -1;
    for (int i = e->hole_first[hole]; i < e->hole_first[hole + 1]; i++) {
        const PlanFace *face = &p->faces[e->hole_faces[i]];
        for (int k = 0; k < face->half_count; k++) {
            int at = p->halves[face->first_half + k] >> 1;
            Vec2 v = p->vertices[p->edges[at].v[0]], w = p->vertices[p->edges[at].v[1]];
            double dv = vec2_length(vec2_sub(v, end)), dw = vec2_length(vec2_sub(w, end)), d = fmin(dv, dw);
            if (d > nearest || (d == nearest && at >= edge)) continue;
            nearest = d;
            edge = at;
            best = dv < dw ? v : w;
        }
    }
    return best;
}

void openings_append(Enclosure *e) {
    Building *b = e->b;
    list_faces(e);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used) continue;
        const SketchOpening *s = &e->sketch->openings[i];
        Vec2 line[2] = {on_grid(e, i, h->line[0]), on_grid(e, i, h->line[1])};
        if (vec2_equal(line[0], line[1])) line[1] = vec2(line[1].x + 1, line[1].y);
        h->opening = b->opening_count;
        int material =
            s->material >= 0 && s->material < b->material_count ? s->material : e->sketch->outer_material;
        *ARENA_APPEND(e->arena, b->openings, b->opening_count, b->opening_capacity) =
            (Opening){.kind = s->kind,
                      .name = arena_string(e->arena, s->name ? s->name : ""),
                      .storey = s->storey,
                      .glazed = s->glazed,
                      .line = {enclose_metres(e, line[0]), enclose_metres(e, line[1])},
                      .sill = h->sill / ENCLOSE_MM,
                      .head = h->head / ENCLOSE_MM,
                      .open = fmin(fmax(s->open, 0), 1),
                      .region = {-1, -1},
                      .material = material};
        append_leaves(e, i);
    }
    assign_leaves(e);
}

// ---- the regions that an opening joins

typedef struct Flood {
    int *queue;      // [span_count]
    bool *mark;      // [span_count] met before
    double *length;  // [region_count] contact with the side asked for, mm^2
    int *regions;    // [region_count] the regions with contact
    int region_count;
} Flood;

// Area of the contact of span s with a free span o beyond half-edge h, mm^2.
static double contact(const Enclosure *e, int h, const Span *s, const Span *o) {
    double height = fmin(s->z1, o->z1) - fmax(s->z0, o->z0);
    return o->kind != SPAN_SOLID && height > 0 ? height * half_length(&e->pass.plan, h) : 0;
}

static int span_of_hole(const Enclosure *e, int face, int hole) {
    const Hole *h = &e->holes[hole];
    for (int i = face_span_above(e, face, h->sill); i < e->first_span[face + 1] && e->spans[i].z0 < h->head;
         i++) {
        if (e->spans[i].kind == SPAN_OPENING && e->spans[i].id / 2 == hole) return i;
    }
    return -1;
}

static bool is_space(const Span *s) { return s->kind == SPAN_ROOM || s->kind == SPAN_OUTDOORS; }

// The region with the largest contact; of two equal ones, the region with the lower index.
static int best_region(const Flood *flood) {
    int best = -1;
    for (int i = 0; i < flood->region_count; i++) {
        int r = flood->regions[i];
        double more = best < 0 ? 1 : flood->length[r] - flood->length[best];
        if (more > 0 || (more == 0 && r < best)) best = r;
    }
    return best;
}

static void add_contact(Flood *flood, int region, double area) {
    if (flood->length[region] == 0) flood->regions[flood->region_count++] = region;
    flood->length[region] += area;
}

// Whether the middle of half-edge h lies on the given side of the opening's line.
static bool on_side(const Enclosure *e, int hole, int side, int h) {
    const Plan *p = &e->pass.plan;
    Vec2 m = vec2_scale(vec2_add(p->vertices[half_from(p, h)], p->vertices[half_to(p, h)]), 0.5);
    const Hole *at = &e->holes[hole];
    return (orient2d(at->line[0], at->line[1], m) > 0) == (side == 0);
}

// Adds up the contacts of a span; other openings' spans not met before go into the queue. Returns the queue's new end.
static int spread(const Enclosure *e, Flood *flood, int span, int face, int hole, int side, int tail) {
    const Plan *p = &e->pass.plan;
    const Span *s = &e->spans[span];
    for (int k = 0; k < p->faces[face].half_count; k++) {
        int h = p->halves[p->faces[face].first_half + k], g = half_right(p, h);
        if (g < 0 || (hole >= 0 && !on_side(e, hole, side, h))) continue;
        for (int i = face_span_above(e, g, s->z0); i < e->first_span[g + 1] && e->spans[i].z0 < s->z1; i++) {
            const Span *o = &e->spans[i];
            double area = contact(e, h, s, o);
            if (area <= 0) continue;
            if (is_space(o) && o->region >= 0) add_contact(flood, o->region, area);
            if (o->kind != SPAN_OPENING || flood->mark[i]) continue;
            flood->mark[i] = true;
            flood->queue[tail++] = i;
        }
    }
    return tail;
}

static int face_of_span(const Enclosure *e, int span) {
    int low = 0, high = e->pass.plan.face_count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (e->first_span[middle] <= span)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

// The region that one side of an opening reaches, directly or through other openings. Leaves `flood` as it was.
static int region_beyond(const Enclosure *e, Flood *flood, const int *faces, int count, int hole, int side) {
    int tail = 0, head = 0;
    for (int i = 0; i < count; i++) flood->mark[span_of_hole(e, faces[i], hole)] = true;
    for (int i = 0; i < count; i++)
        tail = spread(e, flood, span_of_hole(e, faces[i], hole), faces[i], hole, side, tail);
    int best = best_region(flood);
    while (best < 0 && head < tail) {
        int span = flood->queue[head++];
        tail = spread(e, flood, span, face_of_span(e, span), -1, 0, tail);
        best = best_region(flood);
    }
    for (int i = 0; i < count; i++) flood->mark[span_of_hole(e, faces[i], hole)] = false;
    for (int i = 0; i < tail; i++) flood->mark[flood->queue[i]] = false;
    while (flood->region_count > 0) flood->length[flood->regions[--flood->region_count]] = 0;
    return best;
}

static const char *reason_for(Enclosure *e, const Opening *o) {
    if (o->region[0] < 0 && o->region[1] < 0) return "both sides are blocked by walls";
    const Region *r = &e->b->regions[o->region[0] < 0 ? o->region[1] : o->region[0]];
    return arena_format(e->arena, "the side away from %s is blocked by a wall",
                        region_title(e->b, r, e->scratch));
}

static void join_opening(Enclosure *e, Flood *flood, int hole, int *faces) {
    int storey = e->sketch->openings[hole].storey, count = 0;
    for (int i = e->hole_first[hole]; i < e->hole_first[hole + 1]; i++) {
        if (span_of_hole(e, e->hole_faces[i], hole) >= 0) faces[count++] = e->hole_faces[i];
    }
    Opening *o = &e->b->openings[e->holes[hole].opening];
    for (int side = 0; side < 2; side++) o->region[side] = region_beyond(e, flood, faces, count, hole, side);
    if (o->region[0] >= 0 && o->region[1] >= 0) return;
    o->reason = reason_for(e, o);
    Vec3 at = enclose_place(e, e->holes[hole].centre, storey);
    building_note(e->arena, e->b, NOTE_CHANGED, at, "%s at (%.2f, %.2f) leads nowhere: %s",
                  enclose_text(e->sketch->openings[hole].place), at.x, at.y, o->reason);
}

void openings_join(Enclosure *e) {
    Flood flood = {.queue = ARENA_ARRAY(e->scratch, int, e->span_count),
                   .mark = ARENA_ARRAY(e->scratch, bool, e->span_count),
                   .length = ARENA_ARRAY(e->scratch, double, e->b->region_count),
                   .regions = ARENA_ARRAY(e->scratch, int, e->b->region_count)};
    int *faces = ARENA_ARRAY(e->scratch, int, e->pass.plan.face_count);
    const WallColours *colours = wall_colours(e);
    for (int i = 0; i < e->sketch->opening_count; i++) {
        if (!e->holes[i].used) continue;
        join_opening(e, &flood, i, faces);
        draw_leaves(e, i);
        add_spandrels(e, i, &colours[e->holes[i].opening]);
    }
}
