// enclose_spandrels.c - the rest of the rectangle around an arched opening, or one of any other shape: polygons on both faces of the wall,
// and the inner side of the cut-out between them.
#include "maps/enclose/enclose.h"

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

// Adds one half of the rectangle less the cut-out, as polygons on both faces of the wall.
static void add_spandrel_half(Enclosure *e, const Frame *f, const GEOSGeometry *cutout, double u0, double u1,
                              const double *v, int material) {
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
        // GEOS promises no sense of its rings; counter-clockwise, they face the side of v[0].
        double turn = 0;
        for (int k = 0; k < n; k++) turn += vec2_cross(piece->points[k], piece->points[(k + 1) % n]);
        for (int side = 0; side < 2; side++) {
            for (int k = 0; k < n; k++) {
                Vec2 p = piece->points[side == (turn > 0) ? n - 1 - k : k];
                corner[k] = frame_point(e, f, p.x, p.y, v[side]);
            }
            building_add_polygon(e->arena, e->b, corner, n, material);
        }
    }
    if (half) GEOSGeom_destroy_r(e->geos, half);
    if (rest) GEOSGeom_destroy_r(e->geos, rest);
}

// The inner side of the cut-out, where it is not the rectangle's own side.
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

void spandrels_add(Enclosure *e, int hole, int material) {
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
        add_spandrel_half(e, &f, g, 0, middle, v, material);
        add_spandrel_half(e, &f, g, middle, f.width, v, material);
        add_intrados(e, &f, &cutout, v, material);
        GEOSGeom_destroy_r(e->geos, g);
    } else {
        Vec3 at = enclose_place(e, h->centre, s->storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "%s at (%.2f, %.2f): its cut-out is no polygon and becomes a rectangle",
                      enclose_text(s->place), at.x, at.y);
    }
}

// The two faces of a wall may have two colours; the frame takes the one beside the opening.
int *spandrel_colours(Enclosure *e) {
    const Building *b = e->b;
    int *colours = ARENA_ARRAY(e->scratch, int, b->opening_count);
    for (int i = 0; i < b->opening_count; i++) colours[i] = e->sketch->outer_material;
    for (int r = b->region_count; r-- > 0;) {
        const Region *region = &b->regions[r];
        if (region->kind == REGION_OPENING)
            colours[region->opening] = b->edge_material[b->rings[region->first_ring].first_point];
    }
    return colours;
}
