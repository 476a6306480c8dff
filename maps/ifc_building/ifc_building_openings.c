// ifc_building_openings.c - openings in walls, and the doors and windows that fill them.
//
// An opening lies in its wall's direction, which the nearest side of the wall's outline tells: axes of placements need not follow the
// wall. A door turns as its operation says, seen along its own axes: `SWING_LEFT` hangs at the lower end of its x axis and opens
// towards its y axis. Its leaf is the part of its body that stands in the way.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/core/sets.h"
#include "maps/ifc_building/ifc_building.h"

// A person passes a step of this height at most, and stoops under this head; metres.
static const double MAX_SILL = 0.3, MIN_HEAD = 1.5, MIN_WIDTH = 0.4;
// A sill of a door this near to the floor lies on it.
static const double SILL_SLACK = 0.1;
// Holes smaller than this, which nothing fills, are for pipes.
static const double LEAST_HOLE = 0.3;
// An opening that goes through less of its wall than this is a recess.
static const double THROUGH = 0.8;
// A wall thicker than this is none, metres.
static const double THICKEST_WALL = 2;
// Sides of a wall shorter than this tell no direction, metres.
static const double LEAST_SIDE = 0.02;
// An opening that reaches farther beyond its wall's end than this is cut off there, metres.
static const double BEYOND_END = 0.01;
// Depth of a door that stands in no wall, metres.
static const double NO_WALL_DEPTH = 0.1;
// A cut-out that fills its rectangle to this share is a rectangle.
static const double RECTANGLE = 0.99;
// Share of its doorway in which a leaf stands, in half widths and heights; see maps/sweethome/sh3d_pieces.c.
static const double WAY_HALF = 0.6, WAY_LOW = 0.2, WAY_HIGH = 0.7;
// A part that stands out of the wall by this share of the width is a leaf drawn open.
static const double OPEN_DEPTH = 0.3;
static const double THICKEST_LEAF = 0.08, THINNEST_LEAF = 0.02;
// A part of a door this near to the side or the head of its opening is at the border, metres.
static const double BORDER = 0.01;
// Polygons are a closed surface where integrals along their outlines add up to less than this share of what they are each by itself.
static const double CLOSED = 1e-6;
// A leaf of which this share is transparent is glazed.
static const double GLAZED_SHARE = 0.05;
// A thin part of a window in its middle is its pane: metres.
static const double PANE = 0.06;

static Vec2 plan_of(Vec3 v) { return vec2(v.x, v.y); }

// The stretch of a line through a place along `n` that lies within the outlines, as far as the nearest sides on either way; INFINITY:
// there is none.
static double chord(const SolidOutlines *wall, Vec2 at, Vec2 n) {
    double back = -INFINITY, front = INFINITY;
    for (int i = 0; i < wall->count; i++) {
        const SolidOutline *o = &wall->items[i];
        for (int r = 0; r < o->ring_count; r++) {
            for (int k = o->ring[r]; k < o->ring[r + 1]; k++) {
                Vec2 a = vec2_sub(o->points[k], at),
                     b = vec2_sub(o->points[k + 1 == o->ring[r + 1] ? o->ring[r] : k + 1], at);
                double p = vec2_cross(n, a), q = vec2_cross(n, b);
                if ((p > 0) == (q > 0)) continue;
                double v = vec2_dot(a, n) + p / (p - q) * (vec2_dot(b, n) - vec2_dot(a, n));
                if (v <= 0 && v > back) back = v;
                if (v > 0 && v < front) front = v;
            }
        }
    }
    return front - back;
}

// The direction of a wall at a place: that of its sides across which it is thinnest there. Returns its thickness; INFINITY where the
// place is not in it.
static double wall_direction(const SolidOutlines *wall, Vec2 at, Vec2 *along) {
    double thinnest = INFINITY;
    for (int i = 0; i < wall->count; i++) {
        const SolidOutline *o = &wall->items[i];
        if (!solid_contains(o, at)) continue;
        for (int r = 0; r < o->ring_count; r++) {
            for (int k = o->ring[r]; k < o->ring[r + 1]; k++) {
                Vec2 d = vec2_sub(o->points[k + 1 == o->ring[r + 1] ? o->ring[r] : k + 1], o->points[k]);
                double length = vec2_length(d);
                if (length < LEAST_SIDE) continue;
                d = vec2_scale(d, 1 / length);
                double thickness = chord(wall, at, vec2(-d.y, d.x));
                if (thickness >= thinnest) continue;
                thinnest = thickness;
                *along = d;
            }
        }
    }
    return thinnest;
}

// The extent of corners in an opening's own frame: x along its width, y along its normal, z up, from its centre.
static Box frame_box(const IfcHole *h, const Vec3 *corners, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        Vec2 d = vec2_sub(plan_of(corners[i]), h->centre);
        box = box_add(box, vec3(vec2_dot(d, h->u), vec2_dot(d, h->n), corners[i].z));
    }
    return box;
}

static Box polygon_box(const IfcHole *h, const IfcMesh *mesh, int polygon) {
    const IfcPolygon *at = &mesh->polygons[polygon];
    return frame_box(h, mesh->corners + at->first_corner, at->corner_count);
}

static bool covers(const SolidOutlines *wall, Vec2 at) {
    for (int i = 0; i < wall->count; i++)
        if (solid_contains(&wall->items[i], at)) return true;
    return false;
}

// The wall in which a door that fills no opening stands, -1: none.
static int wall_near(IfcPlan *p, const IfcProduct *it) {
    Vec3 middle = vec3_lerp(it->box.min, it->box.max, 0.5);
    int count = box_tree_find(&p->wall_tree, (Box){middle, middle}, &p->scratch, &p->near);
    for (int i = 0; i < count; i++)
        if (covers(&p->walls[p->near.items[i]], plan_of(middle))) return p->near.items[i];
    return -1;
}

// The middle of what two boxes have in common; that of the first where they have nothing.
static Vec3 common_middle(Box a, Box b) {
    Vec3 min = vec3(fmax(a.min.x, b.min.x), fmax(a.min.y, b.min.y), fmax(a.min.z, b.min.z)),
         max = vec3(fmin(a.max.x, b.max.x), fmin(a.max.y, b.max.y), fmin(a.max.z, b.max.z));
    bool common = min.x <= max.x && min.y <= max.y && min.z <= max.z;
    return common ? vec3_lerp(min, max, 0.5) : vec3_lerp(a.min, a.max, 0.5);
}

// An opening around a corner of the house reaches beyond its wall's end: its box, in its own frame, ends there. One whose middle is beside
// the wall also ends at the wall's sides.
static void clip_to_wall(const SolidOutlines *wall, const IfcHole *h, bool sides, Box *box) {
    double low = INFINITY, high = -INFINITY, back = INFINITY, front = -INFINITY;
    for (int i = 0; i < wall->count; i++) {
        const SolidOutline *o = &wall->items[i];
        if (!solid_contains(o, h->centre)) continue;
        for (int k = 0; k < o->ring[1]; k++) {
            Vec2 d = vec2_sub(o->points[k], h->centre);
            low = fmin(low, vec2_dot(d, h->u));
            high = fmax(high, vec2_dot(d, h->u));
            back = fmin(back, vec2_dot(d, h->n));
            front = fmax(front, vec2_dot(d, h->n));
        }
    }
    if (box->min.x < low - BEYOND_END) box->min.x = low;
    if (box->max.x > high + BEYOND_END) box->max.x = high;
    if (!sides) return;
    box->min.y = fmax(box->min.y, back);
    box->max.y = fmin(box->max.y, front);
}

// Finds the opening's frame from the body that is cut out, or from that of a door that stands free.
static bool find_frame(IfcPlan *p, int product, const IfcProduct *body, int wall, IfcHole *h) {
    const IfcProduct *it = &p->model->products[product];
    Vec3 middle = vec3_lerp(body->box.min, body->box.max, 0.5);
    Vec2 axis = plan_of(it->axis[0]), along;
    bool off_wall = wall >= 0 && !covers(&p->walls[wall], plan_of(middle));
    if (off_wall) middle = common_middle(body->box, p->wall_box[wall]);
    h->product = product;
    h->centre = plan_of(middle);
    h->u = vec2_length(axis) > 0.5 ? vec2_scale(axis, 1 / vec2_length(axis)) : vec2(1, 0);
    double thickness = wall >= 0 ? wall_direction(&p->walls[wall], h->centre, &along) : INFINITY;
    if (thickness < THICKEST_WALL) {
        // As the wall, the way round that is nearer to the door's own axis.
        double same = vec2_dot(along, h->u);
        h->u = vec2_scale(along, same < 0 ? -1 : 1);
    }
    h->n = vec2(-h->u.y, h->u.x);
    Box box = frame_box(h, body->mesh.corners, body->mesh.corner_count);
    if (box_is_empty(box)) return false;
    if (thickness < THICKEST_WALL) clip_to_wall(&p->walls[wall], h, off_wall, &box);
    Vec2 shift = vec2_add(vec2_scale(h->u, (box.min.x + box.max.x) / 2),
                          vec2_scale(h->n, (box.min.y + box.max.y) / 2));
    h->width = box.max.x - box.min.x;
    h->depth = box.max.y - box.min.y;
    h->z0 = box.min.z;
    h->z1 = box.max.z;
    h->centre = vec2_add(h->centre, shift);
    if (body->kind == IFC_OPENING && thickness < THICKEST_WALL && h->depth < THROUGH * thickness)
        return false;
    // The wall's own depth: bodies that are cut out reach beyond it.
    if (thickness < THICKEST_WALL)
        h->depth = thickness;
    else if (body->kind != IFC_OPENING)
        h->depth = NO_WALL_DEPTH;
    return true;
}

// The outline of what is cut out as seen along the normal, unless it is a rectangle.
static void find_cutout(IfcPlan *p, const IfcProduct *body, const IfcHole *h, SketchOpening *o) {
    double width = h->width, height = h->z1 - h->z0;
    // One face that fills the rectangle is enough; that saves most openings the union of all.
    for (int i = 0; i < body->mesh.polygon_count; i++) {
        const IfcPolygon *polygon = &body->mesh.polygons[i];
        const Vec3 *c = body->mesh.corners + polygon->first_corner;
        double along = vec3_dot(plane_of_polygon(c, polygon->corner_count).n, vec3(h->n.x, h->n.y, 0));
        if (along * polygon_area(c, polygon->corner_count) >= RECTANGLE * width * height) return;
    }
    for (int i = 0; i < body->mesh.polygon_count; i++) {
        const IfcPolygon *polygon = &body->mesh.polygons[i];
        Vec3 *turned = ARENA_ARRAY(&p->scratch, Vec3, polygon->corner_count);
        for (int k = 0; k < polygon->corner_count; k++) {
            Vec3 c = body->mesh.corners[polygon->first_corner + k];
            Vec2 d = vec2_sub(plan_of(c), h->centre);
            turned[k] = vec3(vec2_dot(d, h->u), c.z - h->z0, -vec2_dot(d, h->n));
        }
        solid_add(p->tracer, turned, polygon->corner_count);
    }
    SolidOutlines seen = solid_cover(p->tracer, -1e6, 1e6);
    if (seen.count != 1 || seen.items->ring_count != 1 || seen.items->area >= RECTANGLE * width * height)
        return;
    Sketch *s = &p->sketch;
    o->first_cutout = s->point_count;
    o->cutout_count = seen.items->ring[1];
    for (int i = 0; i < o->cutout_count; i++) {
        int at = s->point_count;
        Vec2 c = seen.items->points[i];
        *ARENA_PUSH(p->arena, s->points, s->point_count, s->point_capacity) =
            vec2(fmin(fmax(c.x / width + 0.5, 0), 1), fmin(fmax(c.y / height, 0), 1));
        *ARENA_PUSH(p->arena, s->edge_material, at, s->edge_capacity) = -1;
    }
}

// ---- parts of doors and windows

typedef struct Corner {
    Vec3 at;
    int apart, index;
} Corner;

static int by_number_and_place(const void *pa, const void *pb) {
    const Corner *one = pa, *other = pb;
    const Vec3 *a = &one->at, *b = &other->at;
    if (one->apart != other->apart) return one->apart < other->apart ? -1 : 1;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return (a->z > b->z) - (a->z < b->z);
}

// The integral of a cubic vector field along a polygon's outline. Over a closed surface the integrals add up to 0, however its polygons'
// sides are divided, since each stretch is passed once in either direction (Stokes); over a part of it they do not.
static double outline_integral(const Vec3 *v, int count, Vec3 from) {
    const double gauss = 0.5 / sqrt(3);
    double sum = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = vec3_sub(v[i], from), along = vec3_sub(v[(i + 1) % count], v[i]);
        for (int k = 0; k < 2; k++) {  // two places are exact for a cubic (Gauss)
            Vec3 p = vec3_add(a, vec3_scale(along, k == 0 ? 0.5 - gauss : 0.5 + gauss));
            Vec3 field = vec3(p.z * (p.y * p.y + p.z * p.z / 3), p.x * (p.z * p.z + p.x * p.x / 3),
                              p.y * (p.x * p.x + p.y * p.y / 3));
            sum += vec3_dot(field, along) / 2;
        }
    }
    return sum;
}

// The number of the solid of each polygon: a solid ends where the polygons since its first one are a closed surface. [polygon_count]
static int *solid_of_polygons(IfcPlan *p, const IfcMesh *mesh) {
    int *solid = ARENA_ARRAY(&p->scratch, int, mesh->polygon_count + 1), solids = 0;
    double sum = 0, all = 0;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *polygon = &mesh->polygons[i];
        double integral =
            outline_integral(mesh->corners + polygon->first_corner, polygon->corner_count, mesh->corners[0]);
        sum += integral;
        all += fabs(integral);
        solid[i] = solids;
        if (fabs(sum) > CLOSED * all) continue;
        sum = all = 0;
        solids++;
    }
    return solid;
}

// The part of a mesh to which each polygon belongs, by places that polygons share. Polygons whose numbers in `apart` differ share none;
// NULL: all are one number. [polygon_count]
static int *part_of_polygons(IfcPlan *p, const IfcMesh *mesh, const int *apart) {
    int *parent = ARENA_ARRAY(&p->scratch, int, mesh->corner_count + 1),
        *part = ARENA_ARRAY(&p->scratch, int, mesh->polygon_count + 1);
    Corner *corners = ARENA_ARRAY(&p->scratch, Corner, mesh->corner_count + 1);
    int count = 0;
    for (int i = 0; i < mesh->corner_count; i++) parent[i] = i;
    for (int i = 0; i < mesh->polygon_count; i++) {
        for (int k = 0; k < mesh->polygons[i].corner_count; k++) {
            // Copies of a corner differ by rounding.
            int at = mesh->polygons[i].first_corner + k;
            Vec3 c = vec3_scale(mesh->corners[at], 1e5);
            corners[count++] = (Corner){vec3(rint(c.x), rint(c.y), rint(c.z)), apart ? apart[i] : 0, at};
            set_unite(parent, mesh->polygons[i].first_corner, at);
        }
    }
    qsort(corners, (size_t)count, sizeof *corners, by_number_and_place);
    for (int i = 1; i < count; i++)
        if (corners[i].apart == corners[i - 1].apart && vec3_equal(corners[i].at, corners[i - 1].at))
            set_unite(parent, corners[i - 1].index, corners[i].index);
    for (int i = 0; i < mesh->polygon_count; i++) part[i] = set_find(parent, mesh->polygons[i].first_corner);
    return part;
}

// Whether a polygon stands in the middle of a door, where a person passes.
static bool in_the_way(const IfcHole *h, Box polygon) {
    Vec3 middle = vec3_lerp(polygon.min, polygon.max, 0.5);
    double height = h->z1 - h->z0, above = middle.z - h->z0;
    return fabs(middle.x) < WAY_HALF * h->width / 2 && above > WAY_LOW * height && above < WAY_HIGH * height;
}

// A number for each polygon: 0, or that of the solid of a door's lining, which a leaf may touch: a solid at the border of the opening,
// where no solid that stands in the way comes so near to the border. [polygon_count]
static int *linings(IfcPlan *p, const IfcMesh *mesh, const IfcHole *h) {
    int *solid = solid_of_polygons(p, mesh), *out = ARENA_ARRAY(&p->scratch, int, mesh->polygon_count + 1);
    Box *extent = ARENA_ARRAY(&p->scratch, Box, mesh->polygon_count + 1), leaves = box_empty();
    bool *moves = ARENA_ARRAY(&p->scratch, bool, mesh->polygon_count + 1);
    double side = h->width / 2 - BORDER;
    for (int i = 0; i < mesh->polygon_count; i++) extent[i] = box_empty();
    for (int i = 0; i < mesh->polygon_count; i++) {
        Box box = polygon_box(h, mesh, i);
        extent[solid[i]] = box_union(extent[solid[i]], box);
        moves[solid[i]] = moves[solid[i]] || in_the_way(h, box);
    }
    for (int i = 0; i < mesh->polygon_count; i++)
        if (moves[solid[i]]) leaves = box_union(leaves, extent[solid[i]]);
    if (box_is_empty(leaves) || leaves.min.x < -side || leaves.max.x > side) return out;
    for (int i = 0; i < mesh->polygon_count; i++) {
        Box box = extent[solid[i]];
        bool border = box.min.x < -side || box.max.x > side || box.max.z > h->z1 - BORDER;
        out[i] = border && !moves[solid[i]] ? solid[i] + 1 : 0;
    }
    return out;
}

enum { FRAME = -1, OPEN_LEAF = -2 };

// Which leaf each polygon of a door moves with: [polygon_count], FRAME, or OPEN_LEAF where a leaf is drawn open.
static int *find_leaves(IfcPlan *p, const IfcMesh *mesh, const IfcHole *h, bool two) {
    int *part = part_of_polygons(p, mesh, linings(p, mesh, h)),
        *leaf = ARENA_ARRAY(&p->scratch, int, mesh->polygon_count + 1);
    Box *extent = ARENA_ARRAY(&p->scratch, Box, mesh->corner_count + 1);
    bool *moves = ARENA_ARRAY(&p->scratch, bool, mesh->corner_count + 1);
    double height = h->z1 - h->z0;
    for (int i = 0; i < mesh->corner_count; i++) extent[i] = box_empty();
    for (int i = 0; i < mesh->polygon_count; i++) {
        Box box = polygon_box(h, mesh, i);
        extent[part[i]] = box_union(extent[part[i]], box);
        moves[part[i]] = moves[part[i]] || in_the_way(h, box);
    }
    for (int i = 0; i < mesh->polygon_count; i++) {
        Box box = extent[part[i]];
        // Leaves that touch in the middle are one part, but no polygon is of both.
        Box own = polygon_box(h, mesh, i);
        bool open = box.max.y - box.min.y > OPEN_DEPTH * h->width && box.max.z - box.min.z > 0.6 * height;
        leaf[i] = open ? OPEN_LEAF : !moves[part[i]] ? FRAME : two && own.min.x + own.max.x > 0 ? 1 : 0;
    }
    return leaf;
}

// A mesh of the polygons that are marked with a number.
static IfcMesh mesh_of(IfcPlan *p, const IfcMesh *mesh, const int *mark, int which) {
    IfcMesh out = *mesh;
    out.polygons = ARENA_ARRAY(&p->scratch, IfcPolygon, mesh->polygon_count);
    out.polygon_count = 0;
    for (int i = 0; i < mesh->polygon_count; i++)
        if (mark[i] == which) out.polygons[out.polygon_count++] = mesh->polygons[i];
    return out;
}

static Vec2 to_plan(const IfcHole *h, double x, double y) {
    return vec2_add(h->centre, vec2_add(vec2_scale(h->u, x), vec2_scale(h->n, y)));
}

// Adds the body of a door: its frame, and its leaves, which then move.
static void add_door(IfcPlan *p, int opening, const IfcProduct *door) {
    SketchOpening *o = &p->sketch.openings[opening];
    const IfcHole *h = &p->holes[opening];
    const char *name = o->name;
    bool two = o->hinge == 2;
    int *leaf = find_leaves(p, &door->mesh, h, two);
    double clear = 0, all = 0, most = 0;
    bool drawn_open = false;
    for (int i = 0; i < door->mesh.polygon_count; i++) {
        if (leaf[i] == FRAME) continue;
        drawn_open = drawn_open || leaf[i] == OPEN_LEAF;
        int material = ifc_material(p, door->mesh.polygons[i].material, p->door_material);
        double area = polygon_area(door->mesh.corners + door->mesh.polygons[i].first_corner,
                                   door->mesh.polygons[i].corner_count);
        all += area;
        if (p->b->materials[material].alpha < 1) clear += area;
        if (area > most) most = area, o->material = material;
    }
    o->glazed = all > 0 && clear > GLAZED_SHARE * all;
    IfcMesh frame = mesh_of(p, &door->mesh, leaf, FRAME);
    int object = ifc_add_mesh(p, &frame, OBJECT_FRAME, name, p->door_material);
    if (object >= 0) p->b->objects[object].opening = opening;
    // A leaf that is drawn open would have to be closed first: maps_enclose makes one.
    if (drawn_open) return;
    for (int k = 0; k < (two ? 2 : 1); k++) {
        IfcMesh mesh = mesh_of(p, &door->mesh, leaf, k);
        Box box = box_empty();
        for (int i = 0; i < mesh.polygon_count; i++) box = box_union(box, polygon_box(h, &mesh, i));
        if (box_is_empty(box) || box.max.x - box.min.x < 0.1 || box.max.z - box.min.z < 0.5) continue;
        int made = ifc_add_mesh(p, &mesh, OBJECT_LEAF, name, p->door_material);
        if (made < 0) continue;
        // Handles stick out of the leaf; its own plane is where most of its polygons are.
        double y = (box.min.y + box.max.y) / 2;
        bool right = two ? k == 1 : o->hinge == 1;
        double x = right ? box.max.x : box.min.x, tip = right ? box.min.x : box.max.x;
        Leaf *l = &o->leaves[o->leaf_count];
        *l = (Leaf){.pivot = to_plan(h, x, y),
                    .axis = {to_plan(h, x, y), to_plan(h, tip, y)},
                    .thickness = fmin(fmax(box.max.y - box.min.y, THINNEST_LEAF), THICKEST_LEAF),
                    .z0 = box.min.z,
                    .z1 = box.max.z};
        if (o->slide != 0)
            l->slide = vec2_scale(h->u, two && k == 0 ? -o->slide : o->slide);
        else
            l->turn = two && k == 1 ? -o->swing : o->swing;
        p->b->objects[made].opening = opening;
        p->b->objects[made].leaf = o->leaf_count++;
    }
    // Without a part that moves the leaf is made, too.
}

// Adds the body of a window. Where nothing of it is transparent, thin parts in its middle are panes.
static void add_window(IfcPlan *p, int opening, const IfcProduct *window) {
    const IfcHole *h = &p->holes[opening];
    bool clear = false;
    for (int i = 0; i < window->mesh.polygon_count; i++)
        clear = clear || (double)p->model->materials[window->mesh.polygons[i].material].alpha < 0.999;
    const char *name = p->sketch.openings[opening].name;
    int *mark = ARENA_ARRAY(&p->scratch, int, window->mesh.polygon_count + 1);
    if (!clear) {
        int *part = part_of_polygons(p, &window->mesh, NULL);
        Box *extent = ARENA_ARRAY(&p->scratch, Box, window->mesh.corner_count + 1);
        for (int i = 0; i < window->mesh.corner_count; i++) extent[i] = box_empty();
        for (int i = 0; i < window->mesh.polygon_count; i++)
            extent[part[i]] = box_union(extent[part[i]], polygon_box(h, &window->mesh, i));
        double height = h->z1 - h->z0;
        for (int i = 0; i < window->mesh.polygon_count; i++) {
            Vec3 size = vec3_sub(extent[part[i]].max, extent[part[i]].min);
            mark[i] = size.y < PANE && size.x > 0.15 * h->width && size.z > 0.4 * height;
        }
    }
    IfcMesh frame = mesh_of(p, &window->mesh, mark, 0), panes = mesh_of(p, &window->mesh, mark, 1);
    int object = ifc_add_mesh(p, &frame, OBJECT_FRAME, name, p->wall_material);
    if (object >= 0) p->b->objects[object].opening = opening;
    for (int i = 0; i < panes.polygon_count; i++) panes.polygons[i].material = 0;
    object = ifc_add_mesh(p, &panes, OBJECT_FRAME, name, p->glass_material);
    if (object >= 0) p->b->objects[object].opening = opening;
}

// ---- openings

// Fills in how a door turns or slides.
static void set_operation(const IfcProduct *door, const IfcHole *h, SketchOpening *o) {
    const char *word = door->operation;
    bool right = strcasestr(word, "RIGHT") != NULL, two = strcasestr(word, "DOUBLE_") == word;
    // The frame may run against the door's own axes: both ends and sides are the other ones then.
    bool turned = vec2_dot(h->u, plan_of(door->axis[0])) < 0;
    bool mirrored = (vec2_dot(h->n, plan_of(door->axis[1])) < 0) != turned;
    o->hinge = two ? 2 : right != turned;
    double side = (turned != mirrored) ? -1 : 1;
    o->swing = M_PI / 2 * side * (o->hinge == 1 ? -1 : 1);
    if (strcasestr(word, "SLIDING") || strcasestr(word, "FOLDING"))
        o->slide = two ? h->width / 2 : o->hinge == 1 ? h->width : -h->width;
}

static void sketch_opening(IfcPlan *p, const IfcHole *hole, const IfcProduct *body,
                           const IfcProduct *filling) {
    Sketch *s = &p->sketch;
    SketchOpening o = {.storey = ifc_storey_at(p, hole->z0 + 0.01),
                       .centre = hole->centre,
                       .angle = atan2(hole->u.y, hole->u.x),
                       .width = hole->width,
                       .depth = hole->depth,
                       .sill = hole->z0,
                       .head = hole->z1,
                       .material = p->door_material,
                       .name = ifc_name(p, hole->product),
                       .place = ifc_place(p, hole->product)};
    const Storey *storey = &p->b->storeys[o.storey];
    // The floor of the room on either side may be another than the storey's.
    double floor = storey->floor;
    for (int side = -1; side <= 1; side += 2) {
        Vec2 at = vec2_add(hole->centre, vec2_scale(hole->n, side * (hole->depth / 2 + 0.2)));
        int room = ifc_room_at(p, -1, vec3(at.x, at.y, fmin(hole->z0 + 0.5, (hole->z0 + hole->z1) / 2)));
        if (room >= 0 && side < 0) floor = p->rooms[room].z0, o.storey = p->rooms[room].storey;
        if (room >= 0 && side > 0 && (p->rooms[room].z0 < floor || o.storey != p->rooms[room].storey))
            floor = p->rooms[room].z0;
    }
    bool passable = hole->z0 - floor <= MAX_SILL && hole->z1 - floor >= MIN_HEAD && hole->width >= MIN_WIDTH;
    if (filling && filling->kind == IFC_DOOR)
        o.kind = passable ? OPENING_DOOR : OPENING_WINDOW;
    else if (filling)
        o.kind = OPENING_WINDOW;
    else
        o.kind = passable ? OPENING_PASSAGE : OPENING_WINDOW;
    o.glazed = o.kind == OPENING_WINDOW;
    if (o.kind != OPENING_WINDOW && fabs(hole->z0 - floor) <= SILL_SLACK) o.sill = floor;
    if (o.kind == OPENING_DOOR) set_operation(filling, hole, &o);
    if (body->kind == IFC_OPENING) find_cutout(p, body, hole, &o);
    int index = s->opening_count, holes = index;  // both arrays have one length
    *ARENA_PUSH(&p->scratch, p->holes, holes, p->hole_capacity) = *hole;
    *ARENA_PUSH(p->arena, s->openings, s->opening_count, s->opening_capacity) = o;
    if (filling && o.kind == OPENING_DOOR) add_door(p, index, filling);
    if (filling && o.kind == OPENING_WINDOW) add_window(p, index, filling);
}

// Doors and windows, and the panes of curtain walls.
static bool is_filling(const IfcModel *m, const IfcProduct *it) {
    if (it->kind != IFC_PLATE) return it->kind == IFC_DOOR || it->kind == IFC_WINDOW;
    if (it->whole < 0 || m->products[it->whole].kind != IFC_CURTAIN_WALL) return false;
    for (int i = 0; i < it->mesh.polygon_count; i++)
        if (m->materials[it->mesh.polygons[i].material].alpha < 1) return true;
    return false;
}

// Openings in floors and roofs are no openings in walls.
static bool in_wall(const IfcModel *m, int host) {
    if (host < 0) return true;
    IfcKind kind = m->products[host].kind;
    return kind == IFC_WALL || kind == IFC_CURTAIN_WALL || kind == IFC_OTHER || kind == IFC_PLATE ||
           kind == IFC_MEMBER;
}

static void plan_opening(IfcPlan *p, int product) {
    const IfcModel *m = p->model;
    const IfcProduct *filling = is_filling(m, &m->products[product]) ? &m->products[product] : NULL;
    const IfcProduct *opening =
        filling ? filling->host >= 0 ? &m->products[filling->host] : NULL : &m->products[product];
    int wall = opening ? opening->host : filling->kind == IFC_PLATE ? filling->whole : -1;
    const IfcProduct *body = opening && !box_is_empty(opening->box) ? opening : filling;
    if (!body || box_is_empty(body->box)) {
        building_tally(&p->no_body, ifc_place(p, product), filling ? filling->place : vec3(0, 0, 0));
        return;
    }
    Vec3 middle = vec3_lerp(body->box.min, body->box.max, 0.5);
    if (!in_wall(m, wall)) {
        if (!filling) return;
        building_tally(&p->roof_windows, ifc_place(p, product), middle);
        ifc_add_mesh(p, &filling->mesh, OBJECT_FURNITURE, ifc_name(p, product), p->glass_material);
        return;
    }
    if (wall < 0 || p->walls[wall].count == 0) {
        int near = wall_near(p, body);
        if (near < 0 && wall >= 0) {
            // The wall is a thing in the room, its opening is cut out of its body, and a door in it stays shut.
            if (!filling) return;
            building_tally(&p->low_doors, ifc_place(p, product), middle);
            ifc_add_mesh(p, &filling->mesh, OBJECT_FURNITURE, ifc_name(p, product), p->door_material);
            return;
        }
        wall = near;
    }
    IfcHole hole;
    if (!find_frame(p, product, body, wall, &hole)) {
        building_tally(&p->recesses, ifc_place(p, product), middle);
        return;
    }
    if (!filling && (hole.width < LEAST_HOLE || hole.z1 - hole.z0 < LEAST_HOLE)) {
        building_tally(&p->small_holes, ifc_place(p, product), middle);
        return;
    }
    sketch_opening(p, &hole, body, filling);
}

void ifc_plan_openings(IfcPlan *p) {
    const IfcModel *m = p->model;
    bool *filled = ARENA_ARRAY(&p->scratch, bool, m->product_count);
    for (int i = 0; i < m->product_count; i++)
        if (is_filling(m, &m->products[i]) && m->products[i].host >= 0) filled[m->products[i].host] = true;
    // Doors first: where openings lie over one another, the first counts.
    for (int turn = 0; turn < 3; turn++)
        for (int i = 0; i < m->product_count; i++) {
            IfcKind kind = m->products[i].kind;
            if ((turn == 0 && kind == IFC_DOOR) ||
                (turn == 1 && kind != IFC_DOOR && is_filling(m, &m->products[i])) ||
                (turn == 2 && kind == IFC_OPENING && !filled[i]))
                plan_opening(p, i);
        }
}

// ---- doors and the spaces they join

// The space at one side of a door, as far from it as a person stands.
static int space_beside(IfcPlan *p, const IfcHole *h, int side) {
    for (double away = 0.1; away < 0.6; away += 0.1) {
        Vec2 at = vec2_add(h->centre, vec2_scale(h->n, side * (h->depth / 2 + away)));
        int room = ifc_room_at(p, -1, vec3(at.x, at.y, h->z0 + 0.5 * (h->z1 - h->z0)));
        if (room >= 0) return room;
    }
    return -1;
}

static const char *beside_name(const IfcPlan *p, int room) {
    return room < 0 ? "the outside" : p->rooms[room].name;
}

void ifc_check_doors(IfcPlan *p) {
    const Building *b = p->b;
    const IfcModel *m = p->model;
    // Openings that were left out are not in the building: these are found by their names, places and order.
    int at = 0;
    for (int i = 0; i < p->sketch.opening_count; i++) {
        const SketchOpening *o = &p->sketch.openings[i];
        const IfcHole *h = &p->holes[i];
        bool there =
            at < b->opening_count && strcmp(b->openings[at].name, o->name ? o->name : "") == 0 &&
            vec2_length(vec2_sub(vec2_scale(vec2_add(b->openings[at].line[0], b->openings[at].line[1]), 0.5),
                                 h->centre)) < THICKEST_WALL;
        const Opening *made = there ? &b->openings[at++] : NULL;
        if (m->products[h->product].kind != IFC_DOOR || !made) continue;
        if (made->region[0] < 0 || made->region[1] < 0) continue;  // maps_enclose said why
        int found[2], joined = 0;
        for (int side = 0; side < 2; side++) found[side] = space_beside(p, h, side ? -1 : 1);
        for (int way = 0; way < 2; way++) {
            int same = 0;
            for (int side = 0; side < 2; side++) {
                const Region *r = &b->regions[made->region[side]];
                int room = found[side ^ way];
                same += room < 0 ? r->kind != REGION_ROOM || r->name[0] == 0
                                 : strcmp(r->name, p->rooms[room].name) == 0;
            }
            joined = same > joined ? same : joined;
        }
        if (joined == 2) continue;
        building_note(p->arena, p->b, NOTE_CHANGED, vec3(h->centre.x, h->centre.y, h->z0),
                      "%s: %s stands between %s and %s, but joins %s and %s", p->path, o->place,
                      beside_name(p, found[0]), beside_name(p, found[1]),
                      region_title(b, &b->regions[made->region[0]], p->arena),
                      region_title(b, &b->regions[made->region[1]], p->arena));
    }
}
