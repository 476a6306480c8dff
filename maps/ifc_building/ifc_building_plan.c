// ifc_building_plan.c - storeys, rooms, walls and floors of a building model as a sketch.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/core/polygon.h"
#include "engine/core/sets.h"
#include "maps/ifc_building/ifc_building.h"

// Metres. Storeys whose floors lie nearer than this are one.
static const double SAME_FLOOR = 0.3;
// A space belongs to the storey that its file says, if its floor is within this of the storey's; else to that below it.
static const double STOREY_REACH = 1.5;
// A thing whose foot is this far below a floor still stands on it.
static const double STEP = 0.3;
// Heights nearer than this are equal.
static const double SAME_HEIGHT = 0.002;
// An outline is traced from this far above the foot of a space or wall to this far below its top.
static const double TRACE = 0.01;
// Spaces lower or smaller than this are no rooms: metres, metres^2.
static const double LEAST_HEIGHT = 0.5, LEAST_AREA = 0.05;
// A space that other, smaller spaces cover to this share is a zone.
static const double ZONE = 0.8;
// A wall bounds a storey's rooms where it reaches through this share of its height; or is as high as a room for people.
static const double WALL_SHARE = 0.6;
// A wall that ends this near below the ceiling was meant to reach it.
static const double CEILING_GAP = 0.35;
// The storey height of a file that has neither spaces nor walls by which to tell, and the slab where there is none; metres.
static const double DEFAULT_HEIGHT = 2.5, DEFAULT_SLAB = 0.3, LEAST_SLAB = 0.05;

typedef struct Level {
    double elevation;
    const char *name;
    int first;  // in IfcModel.storeys, -1
} Level;

// ---- spaces

static bool is_zone_type(const IfcProduct *s) { return strcasecmp(s->predefined, "GFA") == 0; }

static void trace_mesh(IfcPlan *p, const IfcMesh *mesh) {
    for (int i = 0; i < mesh->polygon_count; i++)
        solid_add(p->tracer, mesh->corners + mesh->polygons[i].first_corner, mesh->polygons[i].corner_count);
}

// Whether the body is made of upright prisms alone, of which nothing was cut off.
static bool is_prisms(const IfcModel *m, const IfcProduct *product) {
    if (product->footprint_count == 0 || product->footprint_count != product->item_count) return false;
    for (int i = 0; i < product->footprint_count; i++)
        if (m->footprints[product->first_footprint + i].clipped) return false;
    return true;
}

static SolidOutline outline_of(const IfcPlan *p, const IfcFootprint *f, Arena *arena) {
    const IfcModel *m = p->model;
    int total = 0;
    for (int r = 0; r < f->ring_count; r++) total += m->rings[f->first_ring + r].point_count;
    SolidOutline o = {ARENA_ARRAY(arena, Vec2, total), ARENA_ARRAY(arena, int, f->ring_count + 1),
                      f->ring_count, 0};
    for (int r = 0; r < f->ring_count; r++) {
        const IfcRing *ring = &m->rings[f->first_ring + r];
        o.ring[r + 1] = o.ring[r] + ring->point_count;
        memcpy(o.points + o.ring[r], m->points + ring->first_point,
               (size_t)ring->point_count * sizeof *o.points);
        SolidOutline one = solid_of_ring(arena, o.points + o.ring[r], ring->point_count);
        o.area += r == 0 ? one.area : -one.area;
    }
    return o;
}

static SolidOutlines cover(IfcPlan *p, int product, double z0, double z1);

// A curtain wall covers what its parts cover.
static SolidOutlines cover_parts(IfcPlan *p, int product, double z0, double z1) {
    SolidOutlines out = {NULL, 0, 0};
    for (int i = p->first_part[product]; i < p->first_part[product + 1]; i++) {
        if (box_is_empty(p->model->products[p->parts[i]].box)) continue;
        SolidOutlines part = cover(p, p->parts[i], z0, z1);
        for (int k = 0; k < part.count; k++)
            *ARENA_PUSH(&p->scratch, out.items, out.count, out.capacity) = part.items[k];
    }
    return out.count > 1 ? solid_union(p->tracer, &out) : out;
}

// The parts of the plan that a product covers between two heights.
static SolidOutlines cover(IfcPlan *p, int product, double z0, double z1) {
    const IfcProduct *it = &p->model->products[product];
    SolidOutlines out = {NULL, 0, 0};
    if (it->kind == IFC_CURTAIN_WALL && it->whole_mesh.polygon_count == 0)
        return cover_parts(p, product, z0, z1);
    if (is_prisms(p->model, it)) {
        for (int i = 0; i < it->footprint_count; i++) {
            const IfcFootprint *f = &p->model->footprints[it->first_footprint + i];
            if (f->top <= z0 || f->base >= z1) continue;
            *ARENA_PUSH(&p->scratch, out.items, out.count, out.capacity) = outline_of(p, f, &p->scratch);
        }
        // Prisms that overlap or stand on one another are one.
        return out.count > 1 ? solid_union(p->tracer, &out) : out;
    }
    trace_mesh(p, &it->whole_mesh);
    return solid_cover(p->tracer, z0, z1);
}

static double area_of(const SolidOutlines *o) {
    double area = 0;
    for (int i = 0; i < o->count; i++) area += o->items[i].area;
    return area;
}

static int by_area(const void *pa, const void *pb) {
    const IfcRoom *a = pa, *b = pb;
    if (a->area != b->area) return a->area < b->area ? -1 : 1;
    return a->product - b->product;
}

static void measure_spaces(IfcPlan *p) {
    const IfcModel *m = p->model;
    for (int i = 0; i < m->product_count; i++) {
        const IfcProduct *s = &m->products[i];
        if (s->kind != IFC_SPACE || is_zone_type(s)) continue;
        Vec3 at = box_is_empty(s->box) ? vec3(0, 0, 0) : vec3_lerp(s->box.min, s->box.max, 0.5);
        IfcRoom room = {.product = i, .storey = -1, .name = ifc_name(p, i)};
        room.z0 = maps_snap(s->box.min.z);
        room.z1 = maps_snap(s->box.max.z);
        if (!box_is_empty(s->box) && room.z1 - room.z0 >= LEAST_HEIGHT)
            room.outline = cover(p, i, room.z0 + TRACE, fmin(room.z1 - TRACE, room.z0 + SKETCH_LEAST_ROOM));
        room.area = area_of(&room.outline);
        if (room.area < LEAST_AREA) {
            building_tally(&p->no_body, ifc_place(p, i), at);
            continue;
        }
        *ARENA_PUSH(&p->scratch, p->rooms, p->room_count, p->room_capacity) = room;
    }
    if (p->room_count > 1) qsort(p->rooms, (size_t)p->room_count, sizeof *p->rooms, by_area);
}

// A space that consists of others is a zone: a flat, a gross area.
static void drop_zones(IfcPlan *p) {
    int kept = 0;
    for (int i = 0; i < p->room_count; i++) {
        IfcRoom *room = &p->rooms[i];
        SolidOutlines within = {NULL, 0, 0};
        Box box = p->model->products[room->product].box;
        for (int k = 0; k < kept; k++) {
            const IfcRoom *other = &p->rooms[k];
            double height = fmin(room->z1, other->z1) - fmax(room->z0, other->z0);
            if (height < 0.5 * (other->z1 - other->z0) ||
                !box_overlap(box, p->model->products[other->product].box))
                continue;
            for (int n = 0; n < other->outline.count; n++)
                *ARENA_PUSH(&p->scratch, within.items, within.count, within.capacity) =
                    other->outline.items[n];
        }
        double common = within.count ? solid_common_area(p->tracer, &room->outline, &within) : 0;
        if (common >= ZONE * room->area) {
            building_note(p->arena, p->b, NOTE_DROPPED, vec3_lerp(box.min, box.max, 0.5),
                          "%s: %s is a zone, for other spaces cover %.0f %% of it: left out", p->path,
                          ifc_place(p, room->product), 100 * common / room->area);
            continue;
        }
        p->rooms[kept++] = *room;
    }
    p->room_count = kept;
}

// ---- storeys

// The height at which the greatest area lies, of equal ones the lowest.
static double commonest(const double *height, const double *area, int count) {
    double best = NAN, most = 0;
    for (int i = 0; i < count; i++) {
        double sum = 0;
        for (int k = 0; k < count; k++)
            if (fabs(height[k] - height[i]) <= SAME_HEIGHT) sum += area[k];
        if (sum > most * (1 + 1e-9) || (sum >= most && height[i] < best)) best = height[i], most = sum;
    }
    return best;
}

// Which storeys of the file hold a space or a door, or, where there are no spaces, a wall: [model->storey_count].
static bool *find_used(IfcPlan *p) {
    const IfcModel *m = p->model;
    bool *used = ARENA_ARRAY(&p->scratch, bool, m->storey_count);
    for (int i = 0; i < p->room_count; i++) {
        int storey = m->products[p->rooms[i].product].storey;
        if (storey >= 0) used[storey] = true;
    }
    for (int i = 0; i < m->product_count; i++) {
        const IfcProduct *it = &m->products[i];
        if (it->storey < 0 || box_is_empty(it->box)) continue;
        bool wall =
            p->room_count == 0 && it->kind == IFC_WALL && it->box.max.z - it->box.min.z >= SKETCH_LEAST_ROOM;
        used[it->storey] |= it->kind == IFC_DOOR || wall;
    }
    return used;
}

static int by_elevation(const void *pa, const void *pb) {
    const Level *a = pa, *b = pb;
    if (a->elevation != b->elevation) return a->elevation < b->elevation ? -1 : 1;
    return a->first - b->first;
}

// Storeys of the file that hold rooms; where there are none, the floors of spaces, or the feet of walls.
static Level *find_levels(IfcPlan *p, int *count) {
    const IfcModel *m = p->model;
    Level *levels = NULL;
    int capacity = 0;
    *count = 0;
    const bool *used = find_used(p);
    for (int i = 0; i < m->storey_count; i++)
        if (used[i])
            *ARENA_PUSH(&p->scratch, levels, *count, capacity) =
                (Level){m->storeys[i].elevation, m->storeys[i].name, i};
    if (*count > 0) return levels;
    for (int i = 0; i < p->room_count; i++)
        *ARENA_PUSH(&p->scratch, levels, *count, capacity) = (Level){p->rooms[i].z0, "", -1};
    for (int i = 0; p->room_count == 0 && i < m->product_count; i++)
        if (m->products[i].kind == IFC_WALL && !box_is_empty(m->products[i].box))
            *ARENA_PUSH(&p->scratch, levels, *count, capacity) = (Level){m->products[i].box.min.z, "", -1};
    if (*count > 0) qsort(levels, (size_t)*count, sizeof *levels, by_elevation);
    return levels;
}

int ifc_storey_at(const IfcPlan *p, double z) {
    int best = -1;
    for (int i = 0; i < p->b->storey_count; i++)
        if (p->b->storeys[i].floor <= z + STEP) best = i;
    return best < 0 ? 0 : best;
}

static void place_rooms(IfcPlan *p) {
    for (int i = 0; i < p->room_count; i++) {
        IfcRoom *room = &p->rooms[i];
        int said = p->model->products[room->product].storey;
        int storey = said >= 0 ? p->storey[said] : -1;
        if (storey < 0 || fabs(p->b->storeys[storey].floor - room->z0) > STOREY_REACH)
            storey = ifc_storey_at(p, room->z0);
        room->storey = storey;
    }
}

// The rooms of each storey in their order: list[first[s]] .. list[first[s + 1] - 1].
typedef struct RoomLists {
    int *first, *list;
} RoomLists;

static RoomLists list_rooms(IfcPlan *p) {
    int storeys = p->b->storey_count;
    RoomLists out = {ARENA_ARRAY(&p->scratch, int, storeys + 1),
                     ARENA_ARRAY(&p->scratch, int, p->room_count + 1)};
    for (int i = 0; i < p->room_count; i++) out.first[p->rooms[i].storey + 1]++;
    for (int s = 0; s < storeys; s++) out.first[s + 1] += out.first[s];
    int *fill = ARENA_ARRAY(&p->scratch, int, storeys + 1);
    memcpy(fill, out.first, (size_t)storeys * sizeof *fill);
    for (int i = 0; i < p->room_count; i++) out.list[fill[p->rooms[i].storey]++] = i;
    return out;
}

// The floor and the ceiling of each storey are those of the greatest part of its spaces.
static void measure_storeys(IfcPlan *p) {
    Building *b = p->b;
    const IfcModel *m = p->model;
    int most = p->room_count + m->product_count;
    double *low = ARENA_ARRAY(&p->scratch, double, most), *high = ARENA_ARRAY(&p->scratch, double, most),
           *area = ARENA_ARRAY(&p->scratch, double, most);
    RoomLists rooms = list_rooms(p);
    for (int s = 0; s < b->storey_count; s++) {
        int count = 0;
        for (int i = rooms.first[s]; i < rooms.first[s + 1]; i++) {
            const IfcRoom *room = &p->rooms[rooms.list[i]];
            low[count] = room->z0;
            high[count] = room->z1;
            area[count++] = room->area;
        }
        bool spaces = count > 0;
        for (int i = 0; !spaces && i < m->product_count; i++) {
            const IfcProduct *w = &m->products[i];
            if (w->kind != IFC_WALL || w->storey < 0 || p->storey[w->storey] != s || box_is_empty(w->box))
                continue;
            Vec3 size = vec3_sub(w->box.max, w->box.min);
            low[count] = w->box.min.z;
            high[count] = w->box.max.z;
            area[count++] = hypot(size.x, size.y);
        }
        Storey *storey = &b->storeys[s];
        if (spaces) storey->floor = maps_snap(commonest(low, area, count));
        double top = count ? maps_snap(commonest(high, area, count)) : NAN;
        if (!(top > storey->floor + LEAST_HEIGHT)) top = storey->floor + DEFAULT_HEIGHT;
        storey->height = maps_snap(top - storey->floor);
    }
    for (int s = 0; s < b->storey_count; s++) {
        Storey *storey = &b->storeys[s], *above = s + 1 < b->storey_count ? storey + 1 : NULL;
        // Walls reach up to the next floor; the ceiling lies below its slab.
        bool spaces = rooms.first[s + 1] > rooms.first[s];
        if (above && !spaces && above->floor > storey->floor + DEFAULT_HEIGHT)
            storey->height = maps_snap(fmin(storey->height, above->floor - storey->floor - DEFAULT_SLAB));
        const Storey *below = s ? storey - 1 : NULL;
        double slab = below ? storey->floor - below->floor - below->height : DEFAULT_SLAB;
        // Above a ceiling that hangs low all is solid, up to the next floor.
        storey->slab = maps_snap(slab > LEAST_SLAB ? slab : DEFAULT_SLAB);
    }
}

static void index_rooms(IfcPlan *p);

bool ifc_plan_storeys(IfcPlan *p, Error *error) {
    const IfcModel *m = p->model;
    Building *b = p->b;
    measure_spaces(p);
    drop_zones(p);
    index_rooms(p);
    int count;
    const Level *levels = find_levels(p, &count);
    for (int i = 0; i < m->storey_count; i++) p->storey[i] = -1;
    for (int i = 0; i < count; i++) {
        double floor = maps_snap(levels[i].elevation);
        if (b->storey_count == 0 || floor - b->storeys[b->storey_count - 1].floor > SAME_FLOOR)
            *ARENA_PUSH(p->arena, b->storeys, b->storey_count, b->storey_capacity) =
                (Storey){arena_string(p->arena, levels[i].name), floor, DEFAULT_HEIGHT, DEFAULT_SLAB};
        if (levels[i].first >= 0) p->storey[levels[i].first] = b->storey_count - 1;
    }
    if (b->storey_count == 0)
        return error_set(error, "%s: has no storey, no space and no wall from which to tell a floor",
                         p->path);
    place_rooms(p);
    measure_storeys(p);
    // The floors of spaces are not the elevations of their storeys.
    place_rooms(p);
    return true;
}

// ---- rooms

Vec3 ifc_middle(const Vec3 *corners, int count, Box *box) {
    Vec3 sum = {0, 0, 0};
    *box = box_empty();
    for (int i = 0; i < count; i++) {
        sum = vec3_add(sum, vec3_scale(corners[i], 1.0 / count));
        *box = box_add(*box, corners[i]);
    }
    return sum;
}

int ifc_room_at(IfcPlan *p, int storey, Vec3 place) {
    int count = box_tree_find(&p->room_tree, (Box){place, place}, &p->scratch, &p->near);
    for (int i = 0; i < count; i++) {
        const IfcRoom *room = &p->rooms[p->near.items[i]];
        if ((storey >= 0 && room->storey != storey) || place.z <= room->z0 || place.z >= room->z1) continue;
        for (int k = 0; k < room->outline.count; k++)
            if (solid_contains(&room->outline.items[k], vec2(place.x, place.y))) return p->near.items[i];
    }
    return -1;
}

static void index_rooms(IfcPlan *p) {
    p->room_box = ARENA_ARRAY(&p->scratch, Box, p->room_count);
    for (int i = 0; i < p->room_count; i++) p->room_box[i] = p->model->products[p->rooms[i].product].box;
    p->room_tree = box_tree_build(p->room_box, p->room_count, &p->scratch);
    for (int i = 0; i < p->model->product_count; i++) {
        const IfcProduct *it = &p->model->products[i];
        if ((it->kind == IFC_SLAB || it->kind == IFC_COVERING) && !box_is_empty(it->box))
            *ARENA_PUSH(&p->scratch, p->floors, p->floor_count, p->floor_capacity) = i;
    }
}

static int add_points(IfcPlan *p, const Vec2 *points, int count, const int *material) {
    Sketch *s = &p->sketch;
    int first = s->point_count;
    for (int i = 0; i < count; i++) {
        // Both arrays have one length.
        int at = s->point_count;
        *ARENA_PUSH(p->arena, s->points, s->point_count, s->point_capacity) = points[i];
        *ARENA_PUSH(p->arena, s->edge_material, at, s->edge_capacity) = material ? material[i] : -1;
    }
    return first;
}

// The material of the largest polygon of a mesh that faces along `n`, no more than a few degrees off; -1: none has a style.
static int facing_material(IfcPlan *p, const IfcMesh *mesh, Vec3 n) {
    double most = 0;
    int best = -1;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *polygon = &mesh->polygons[i];
        const Vec3 *c = mesh->corners + polygon->first_corner;
        double area = polygon_area(c, polygon->corner_count);
        if (area <= most || polygon->material == 0 ||
            vec3_dot(plane_of_polygon(c, polygon->corner_count).n, n) < 0.98)
            continue;
        most = area;
        best = ifc_material(p, polygon->material, -1);
    }
    return best;
}

// The material of the floor on which a room stands: that of the covering or slab whose top is nearest to it.
static int floor_material(IfcPlan *p, const IfcRoom *room) {
    const IfcModel *m = p->model;
    Box box = m->products[room->product].box;
    Vec3 middle = vec3_lerp(box.min, box.max, 0.5);
    double nearest = STEP;
    int best = -1;
    for (int i = 0; i < p->floor_count; i++) {
        const IfcProduct *it = &m->products[p->floors[i]];
        double off = fabs(it->box.max.z - room->z0);
        if (off >= nearest || middle.x < it->box.min.x || middle.x > it->box.max.x ||
            middle.y < it->box.min.y || middle.y > it->box.max.y)
            continue;
        int material = facing_material(p, &it->mesh, vec3(0, 0, 1));
        if (material < 0 || p->b->materials[material].alpha < 1) continue;
        nearest = off;
        best = material;
    }
    return best < 0 ? p->floor_material : best;
}

// Parts of a space's boundary inside the prism of its room: sloped ceilings, lowered ones, steps. They are seen from inside.
static void add_inner_faces(IfcPlan *p, const IfcRoom *room) {
    static const double EDGE = 0.01;  // metres: a face this near to the outline is a wall's
    const IfcMesh *mesh = &p->model->products[room->product].mesh;
    if (is_prisms(p->model, &p->model->products[room->product])) return;
    bool begun = false;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *polygon = &mesh->polygons[i];
        int n = polygon->corner_count;
        const Vec3 *c = mesh->corners + polygon->first_corner;
        Plane plane = plane_of_polygon(c, n);
        Box box;
        Vec3 middle = ifc_middle(c, n, &box);
        double low = box.min.z, high = box.max.z;
        bool ceiling = plane.n.z > 0.01 && low < room->z1 - SAME_HEIGHT,
             floor = plane.n.z < -0.01 && high > room->z0 + SAME_HEIGHT;
        if (!ceiling && !floor) {
            // An upright face: both its sides within the outline?
            if (fabs(plane.n.z) > 0.01) continue;
            int sides = 0;
            for (int side = -1; side <= 1; side += 2) {
                Vec3 at = vec3_add(middle, vec3_scale(plane.n, side * EDGE));
                for (int k = 0; k < room->outline.count; k++)
                    sides += solid_contains(&room->outline.items[k], vec2(at.x, at.y));
            }
            if (sides < 2) continue;
        }
        if (!begun) building_add_object(p->arena, p->b, OBJECT_LOW_WALL, "sloped ceiling");
        begun = true;
        Vec3 *turned = ARENA_ARRAY(&p->scratch, Vec3, n);
        // Before the roof's own underside, which lies in the same plane.
        for (int k = 0; k < n; k++) turned[k] = vec3_sub(c[n - 1 - k], vec3_scale(plane.n, EDGE));
        building_add_polygon(p->arena, p->b, turned, n,
                             floor     ? p->floor_material
                             : ceiling ? p->ceiling_material
                                       : p->wall_material);
    }
    if (begun && p->b->objects[p->b->object_count - 1].polygon_count == 0) p->b->object_count--;
}

// Metres: how far from its outline a room's wall may begin; between the places that are probed; thickness of a wall that is assumed.
static const double WALL_REACH = 0.35, PROBE = 0.2, THIN_WALL = 0.05;
// Share of a room's outline without walls above which maps_enclose might take it for a terrace; and the share of it under a roof that
// makes it a room all the same.
static const double OPEN_SHARE = 0.4, ROOFED = 0.5;

// Whether a wall that bounds the room, or another room, stands at a place.
static bool is_bounded_at(IfcPlan *p, const IfcRoom *room, Vec2 at) {
    double half = room->z0 + 0.5 * fmin(room->z1 - room->z0, SKETCH_LEAST_ROOM);
    int other = ifc_room_at(p, room->storey, vec3(at.x, at.y, half));
    if (other >= 0 && &p->rooms[other] != room) return true;
    double high = fmin(room->z1 - CEILING_GAP, room->z0 + SKETCH_LEAST_ROOM);
    Vec3 place = vec3(at.x, at.y, half);
    int count = box_tree_find(&p->wall_tree, (Box){place, place}, &p->scratch, &p->near);
    for (int i = 0; i < count; i++) {
        int wall = p->near.items[i];
        if (p->wall_box[wall].min.z > room->z0 + STEP || p->wall_box[wall].max.z < high) continue;
        for (int k = 0; k < p->walls[wall].count; k++)
            if (solid_contains(&p->walls[wall].items[k], at)) return true;
    }
    return false;
}

// The length of the room's outline along which nothing bounds it, and its share of the outline.
static double open_length(IfcPlan *p, const IfcRoom *room, double *share) {
    double open = 0, all = 0;
    for (int i = 0; i < room->outline.count; i++) {
        const SolidOutline *o = &room->outline.items[i];
        for (int k = 0; k < o->ring[1]; k++) {
            Vec2 a = o->points[k], d = vec2_sub(o->points[(k + 1) % o->ring[1]], a);
            double length = vec2_length(d);
            int probes = 1 + (int)fmin(length / PROBE, 1000);
            all += length;
            for (int n = 0; n < probes; n++) {
                Vec2 at = vec2_add(a, vec2_scale(d, (n + 0.5) / probes));
                bool bounded = false;
                for (int far = 1; far <= 4 && !bounded; far++)
                    bounded = is_bounded_at(
                        p, room, vec2_add(at, vec2_scale(vec2(d.y, -d.x), WALL_REACH * far / 4 / length)));
                if (!bounded) open += length / probes;
            }
        }
    }
    *share = all > 0 ? open / all : 0;
    return open;
}

// Whether a roof, a slab or a room of the file lies over most of the room.
static bool is_roofed(IfcPlan *p, const IfcRoom *room) {
    const IfcModel *m = p->model;
    SolidOutlines over = {NULL, 0, 0};
    Box box = m->products[room->product].box;
    for (int i = 0; i < m->product_count; i++) {
        const IfcProduct *it = &m->products[i];
        bool roof = it->kind == IFC_ROOF || it->kind == IFC_SLAB || it->kind == IFC_COVERING;
        if (!roof || it->box.max.z < fmin(room->z0 + SKETCH_LEAST_ROOM, room->z1) ||
            it->box.min.x > box.max.x || it->box.max.x < box.min.x || it->box.min.y > box.max.y ||
            it->box.max.y < box.min.y)
            continue;
        trace_mesh(p, &it->mesh);
        SolidOutlines part = solid_cover(p->tracer, fmax(it->box.min.z, room->z0 + STEP), it->box.max.z);
        for (int k = 0; k < part.count; k++)
            *ARENA_PUSH(&p->scratch, over.items, over.count, over.capacity) = part.items[k];
    }
    return over.count && solid_common_area(p->tracer, &room->outline, &over) >= ROOFED * room->area;
}

// A space without walls on all sides is closed where a roof covers it, as under a slanting one; else it is a terrace.
static bool needs_walls(IfcPlan *p, const IfcRoom *room) {
    double share, open = open_length(p, room, &share);
    if (share < OPEN_SHARE || !is_roofed(p, room)) return false;
    Box box = p->model->products[room->product].box;
    building_note(p->arena, p->b, NOTE_CHANGED, vec3_lerp(box.min, box.max, 0.5),
                  "%s: %s has no wall along %.1f m of its outline: it is closed by one of %g m there",
                  p->path, ifc_place(p, room->product), open, THIN_WALL);
    return true;
}

void ifc_plan_rooms(IfcPlan *p) {
    Sketch *s = &p->sketch;
    for (int i = 0; i < p->room_count; i++) {
        const IfcRoom *room = &p->rooms[i];
        const IfcProduct *space = &p->model->products[room->product];
        const Storey *storey = &p->b->storeys[room->storey];
        bool outdoors = strcasecmp(space->predefined, "EXTERNAL") == 0;
        int floor = floor_material(p, room);
        double wall = p->sketch.wall_count > 0 && !outdoors && needs_walls(p, room) ? THIN_WALL : 0;
        for (int k = 0; k < room->outline.count; k++) {
            Vec2 *points;
            int count = solid_one_ring(&room->outline.items[k], &p->scratch, &points);
            SketchRoom out = {.storey = room->storey,
                              .point_count = count,
                              .name = room->name,
                              .place = ifc_place(p, room->product),
                              .floor_material = floor,
                              .ceiling_material = p->ceiling_material,
                              .z0 = fabs(room->z0 - storey->floor) <= SAME_HEIGHT ? NAN : room->z0,
                              .z1 = fabs(room->z1 - storey->floor - storey->height) <= SAME_HEIGHT ? NAN
                                                                                                   : room->z1,
                              .wall = wall,
                              .wall_material = p->wall_material,
                              .open_above = outdoors};
            out.first_point = add_points(p, points, count, NULL);
            *ARENA_PUSH(p->arena, s->rooms, s->room_count, s->room_capacity) = out;
        }
        add_inner_faces(p, room);
    }
}

// ---- walls

// The direction of the longest side, radians.
static double direction_of(const SolidOutline *o) {
    double longest = 0, angle = 0;
    for (int i = 0; i < o->ring[1]; i++) {
        Vec2 d = vec2_sub(o->points[(i + 1) % o->ring[1]], o->points[i]);
        if (vec2_length(d) <= longest) continue;
        longest = vec2_length(d);
        angle = atan2(d.y, d.x);
    }
    return angle;
}

static void add_wall(IfcPlan *p, int product, const SolidOutline *outline, int storey, double z0, double z1) {
    Sketch *s = &p->sketch;
    const IfcProduct *it = &p->model->products[product];
    Vec2 *points;
    int count = solid_one_ring(outline, &p->scratch, &points);
    int *material = ARENA_ARRAY(&p->scratch, int, count);
    for (int i = 0; i < count; i++) {
        Vec2 d = vec2_sub(points[(i + 1) % count], points[i]);
        double length = vec2_length(d);
        material[i] =
            length > 0 ? facing_material(p, &it->whole_mesh, vec3(d.y / length, -d.x / length, 0)) : -1;
        if (material[i] < 0) material[i] = p->wall_material;
    }
    SketchWall wall = {.storey = storey,
                       .point_count = count,
                       .z0 = z0,
                       .z1 = z1,
                       .angle = direction_of(outline),
                       .place = ifc_place(p, product)};
    wall.top_material = facing_material(p, &it->whole_mesh, vec3(0, 0, 1));
    if (wall.top_material < 0) wall.top_material = p->wall_material;
    wall.first_point = add_points(p, points, count, material);
    *ARENA_PUSH(p->arena, s->walls, s->wall_count, s->wall_capacity) = wall;
}

// The part of a wall that stands beyond what the plan has of it: gables, parapets. `from`: the top of the plan's part.
static void add_above(IfcPlan *p, int product, double from) {
    const IfcProduct *it = &p->model->products[product];
    const Plane keep = {{0, 0, 1}, from};
    bool begun = false;
    for (int i = 0; i < it->mesh.polygon_count; i++) {
        const IfcPolygon *polygon = &it->mesh.polygons[i];
        Vec3 *out = ARENA_ARRAY(&p->scratch, Vec3, polygon->corner_count + 1);
        int count =
            polygon_clip(it->mesh.corners + polygon->first_corner, polygon->corner_count, keep, 0, out);
        if (count < 3) continue;
        if (!begun) building_add_object(p->arena, p->b, OBJECT_LOW_WALL, ifc_name(p, product));
        begun = true;
        building_add_polygon(p->arena, p->b, out, count,
                             ifc_material(p, polygon->material, p->wall_material));
    }
    if (begun && p->b->objects[p->b->object_count - 1].polygon_count == 0) p->b->object_count--;
}

// A wall that bounds no storey's rooms stays the body that it is: a parapet, a screen, a foundation.
static void plan_wall(IfcPlan *p, int product) {
    const Building *b = p->b;
    const IfcProduct *it = &p->model->products[product];
    Box box = it->box;
    for (int i = p->first_part[product]; it->kind == IFC_CURTAIN_WALL && i < p->first_part[product + 1];
         i++) {
        Box part = p->model->products[p->parts[i]].box;
        if (!box_is_empty(part)) box = box_union(box, part);
    }
    if (box_is_empty(box)) return;
    double low = box.min.z, high = box.max.z, reached = -INFINITY;
    SolidOutlines *all = &p->walls[product];
    for (int s = 0; s < b->storey_count; s++) {
        const Storey *storey = &b->storeys[s];
        double floor = storey->floor, ceiling = floor + storey->height;
        if (low > floor + STEP || high <= floor) continue;
        double share = (fmin(high, ceiling) - fmax(low, floor)) / storey->height;
        if (share < WALL_SHARE) continue;
        double top = high > ceiling - CEILING_GAP ? ceiling : high;
        SolidOutlines parts = cover(p, product, fmax(low, floor) + TRACE, fmin(high, top) - TRACE);
        for (int i = 0; i < parts.count; i++) {
            add_wall(p, product, &parts.items[i], s, floor, top);
            *ARENA_PUSH(&p->scratch, all->items, all->count, all->capacity) = parts.items[i];
        }
        reached = fmax(reached, top);
    }
    if (all->count > 0) p->wall_box[product] = box;
    static const double ROOF = 0.15;  // of maps_enclose, above ceilings that nothing stands on
    if (reached > low && high > reached + ROOF + 0.05 &&
        ifc_storey_at(p, high) == ifc_storey_at(p, reached - STEP))
        add_above(p, product, reached + ROOF);
}

void ifc_plan_walls(IfcPlan *p) {
    const IfcModel *m = p->model;
    p->wall_box = ARENA_ARRAY(&p->scratch, Box, m->product_count);
    for (int i = 0; i < m->product_count; i++) {
        p->wall_box[i] = box_empty();
        if (m->products[i].kind == IFC_WALL || m->products[i].kind == IFC_CURTAIN_WALL) plan_wall(p, i);
    }
    p->wall_tree = box_tree_build(p->wall_box, m->product_count, &p->scratch);
}

// ---- floors

// Metres: how far below or above a floor the top of its slab may lie.
static const double SLAB_BELOW = 0.4, SLAB_ABOVE = 0.15;
// Holes in floors: smallest area (metres^2) and mean width (metres); the height in which a person walks on a stair.
static const double HOLE_AREA = 0.3, HOLE_WIDTH = 0.3, HEADROOM = 2.0;
// Share of a storey's rooms above which its slabs are complete enough to tell holes.
static const double SLAB_SHARE = 0.3;

static SolidOutlines slabs_of(IfcPlan *p, double floor) {
    const IfcModel *m = p->model;
    SolidOutlines out = {NULL, 0, 0};
    for (int i = 0; i < p->floor_count; i++) {
        const IfcProduct *it = &m->products[p->floors[i]];
        if (it->kind != IFC_SLAB || it->box.max.z < floor - SLAB_BELOW ||
            it->box.max.z > floor + SLAB_ABOVE || ifc_is_stair(m, it))
            continue;
        double middle = it->box.max.z - fmin(0.05, (it->box.max.z - it->box.min.z) / 2);
        trace_mesh(p, &it->mesh);
        SolidOutlines part = solid_cover(p->tracer, middle, middle + MAPS_GRID);
        for (int k = 0; k < part.count; k++)
            *ARENA_PUSH(&p->scratch, out.items, out.count, out.capacity) = part.items[k];
    }
    return out.count ? solid_union(p->tracer, &out) : out;
}

static void add_cutouts(IfcPlan *p, int storey, const SolidOutlines *holes, const SolidOutlines *below,
                        const char *place) {
    Sketch *s = &p->sketch;
    for (int i = 0; i < holes->count; i++) {
        SolidOutlines one = {&holes->items[i], 1, 1};
        if (one.items->area < HOLE_AREA ||
            (below && solid_common_area(p->tracer, &one, below) < 0.5 * one.items->area))
            continue;
        Vec2 *points;
        int count = solid_one_ring(one.items, &p->scratch, &points);
        SketchCutout cutout = {storey, add_points(p, points, count, NULL), count, place};
        *ARENA_PUSH(p->arena, s->cutouts, s->cutout_count, s->cutout_capacity) = cutout;
    }
}

static void append_all(IfcPlan *p, SolidOutlines *to, const SolidOutlines *from) {
    for (int i = 0; i < from->count; i++)
        *ARENA_PUSH(&p->scratch, to->items, to->count, to->capacity) = from->items[i];
}

bool ifc_is_stair(const IfcModel *m, const IfcProduct *it) {
    if (it->kind == IFC_STAIR || it->kind == IFC_RAMP) return true;
    bool of_stair = it->whole >= 0 &&
                    (m->products[it->whole].kind == IFC_STAIR || m->products[it->whole].kind == IFC_RAMP);
    return it->kind == IFC_SLAB && (of_stair || strcasecmp(it->predefined, "LANDING") == 0);
}

// A flight or landing, and the box of all flights and landings of its stair.
typedef struct StairPart {
    int product;
    Box box;
} StairPart;

typedef struct StairParts {
    StairPart *items;
    int count, capacity;
} StairParts;

static StairParts find_stairs(IfcPlan *p) {
    const IfcModel *m = p->model;
    StairParts out = {NULL, 0, 0};
    Box *whole = ARENA_ARRAY(&p->scratch, Box, m->product_count);
    for (int i = 0; i < m->product_count; i++) whole[i] = box_empty();
    for (int i = 0; i < m->product_count; i++) {
        const IfcProduct *it = &m->products[i];
        if (box_is_empty(it->box) || !ifc_is_stair(m, it)) continue;
        *ARENA_PUSH(&p->scratch, out.items, out.count, out.capacity) = (StairPart){i, it->box};
        if (it->whole >= 0) whole[it->whole] = box_union(whole[it->whole], it->box);
    }
    for (int i = 0; i < out.count; i++) {
        int of = m->products[out.items[i].product].whole;
        if (of >= 0) out.items[i].box = whole[of];
    }
    return out;
}

// The lowest ceiling of the rooms through which a stair leads, at most `z`.
static double ceiling_over(IfcPlan *p, Box stair, double z) {
    int count = box_tree_find(&p->room_tree, stair, &p->scratch, &p->near);
    for (int i = 0; i < count; i++) {
        const IfcRoom *room = &p->rooms[p->near.items[i]];
        if (room->z0 <= stair.min.z + STEP && room->z1 > stair.min.z + STEP &&
            box_overlap(p->model->products[room->product].box, stair))
            z = fmin(z, room->z1);
    }
    return z;
}

// Where there are more flights at one storey, each counts alone: no building has so many.
enum { MOST_FLIGHTS = 1000 };

// The flights and landings between a floor and the one below it that lead up to the floor, over others that they meet: some files have each
// flight as a stair of its own. A few steps that begin less than a metre under the floor, with none before them, are no way up.
static StairParts stairs_to(IfcPlan *p, const StairParts *stairs, int storey) {
    double floor = p->b->storeys[storey].floor, below = p->b->storeys[storey - 1].floor;
    StairParts between = {NULL, 0, 0}, out = {NULL, 0, 0};
    for (int i = 0; i < stairs->count; i++) {
        Box box = stairs->items[i].box;
        if (box.min.z <= floor - LEAST_SLAB && (box.max.z >= floor - STEP || box.min.z >= below - STEP))
            *ARENA_PUSH(&p->scratch, between.items, between.count, between.capacity) = stairs->items[i];
    }
    int *parent = ARENA_ARRAY(&p->scratch, int, between.count);
    double *low = ARENA_ARRAY(&p->scratch, double, between.count),
           *high = ARENA_ARRAY(&p->scratch, double, between.count);
    Box *reach = ARENA_ARRAY(&p->scratch, Box, between.count);
    for (int i = 0; i < between.count; i++) {
        Box box = between.items[i].box;
        const Vec3 step = {STEP / 2, STEP / 2, STEP / 2};
        reach[i] = (Box){vec3_sub(box.min, step), vec3_add(box.max, step)};
        parent[i] = i;
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    BoxTree tree = box_tree_build(reach, between.count, &p->scratch);
    for (int i = 0; i < between.count && between.count <= MOST_FLIGHTS; i++)
        for (int n = box_tree_find(&tree, reach[i], &p->scratch, &p->near); n-- > 0;)
            set_unite(parent, i, p->near.items[n]);
    for (int i = 0; i < between.count; i++) {
        int root = set_find(parent, i);
        low[root] = fmin(low[root], between.items[i].box.min.z);
        high[root] = fmax(high[root], between.items[i].box.max.z);
    }
    for (int i = 0; i < between.count; i++) {
        int root = set_find(parent, i);
        if (high[root] >= floor - STEP && low[root] <= floor - 1)
            *ARENA_PUSH(&p->scratch, out.items, out.count, out.capacity) = between.items[i];
    }
    return out;
}

// Stairs that lead up to a floor need a hole in it, whether the slab has one or not: over all steps on which a person meets the ceiling.
static void cut_for_stairs(IfcPlan *p, const StairParts *all_stairs, int storey) {
    SolidOutlines all = {NULL, 0, 0};
    double floor = p->b->storeys[storey].floor;
    StairParts stairs = stairs_to(p, all_stairs, storey);
    for (int i = 0; i < stairs.count; i++) {
        const IfcProduct *it = &p->model->products[stairs.items[i].product];
        double from =
            fmax(ceiling_over(p, stairs.items[i].box, floor - DEFAULT_SLAB) - HEADROOM, it->box.min.z);
        // The last step may be level with the floor, or the floor itself.
        if (from >= fmin(it->box.max.z, floor - LEAST_SLAB)) continue;
        trace_mesh(p, &it->mesh);
        SolidOutlines steps = solid_cover(p->tracer, from, fmin(it->box.max.z, floor - LEAST_SLAB));
        append_all(p, &all, &steps);
    }
    SolidOutlines holes = solid_union(p->tracer, &all);
    add_cutouts(p, storey, &holes, NULL, "hole for a stair");
}

static void cut_floors(IfcPlan *p) {
    StairParts stairs = find_stairs(p);
    RoomLists lists = list_rooms(p);
    for (int s = 1; s < p->b->storey_count; s++) {
        SolidOutlines rooms = {NULL, 0, 0}, below = {NULL, 0, 0};
        const Storey *storey = &p->b->storeys[s];
        for (int i = lists.first[s]; i < lists.first[s + 1]; i++)
            append_all(p, &rooms, &p->rooms[lists.list[i]].outline);
        double low = storey->floor - STOREY_REACH - storey->slab;
        Box under = {vec3(-INFINITY, -INFINITY, low), vec3(INFINITY, INFINITY, storey->floor + STOREY_REACH)};
        box_tree_find(&p->room_tree, under, &p->scratch, &p->near);
        for (int i = 0; i < p->near.count; i++) {
            const IfcRoom *room = &p->rooms[p->near.items[i]];
            if (room->storey < s && room->z1 > low) append_all(p, &below, &room->outline);
        }
        SolidOutlines slabs = slabs_of(p, storey->floor);
        if (rooms.count && below.count && slabs.count &&
            solid_common_area(p->tracer, &rooms, &slabs) >= SLAB_SHARE * area_of(&rooms)) {
            SolidOutlines holes = solid_difference(p->tracer, &rooms, &slabs, HOLE_WIDTH);
            add_cutouts(p, s, &holes, &below, "hole in the floor");
        }
        cut_for_stairs(p, &stairs, s);
    }
}

// The ground lies at the floor of the storey that has most doors between a space and none; without such doors, at the lowest floor.
static void find_ground(IfcPlan *p) {
    int most = 0, best = -1, *doors = ARENA_ARRAY(&p->scratch, int, p->b->storey_count);
    for (int i = 0; i < p->sketch.opening_count; i++) {
        const IfcHole *h = &p->holes[i];
        if (p->sketch.openings[i].kind != OPENING_DOOR) continue;
        int sides = 0;
        for (int side = -1; side <= 1; side += 2) {
            Vec2 at = vec2_add(h->centre, vec2_scale(h->n, side * (h->depth / 2 + 0.3)));
            sides += ifc_room_at(p, -1, vec3(at.x, at.y, h->z0 + 1)) >= 0;
        }
        doors[p->sketch.openings[i].storey] += sides == 1;
    }
    for (int s = 0; s < p->b->storey_count; s++)
        if (doors[s] > most) most = doors[s], best = s;
    p->sketch.ground = p->b->storeys[best < 0 ? 0 : best].floor;
}

void ifc_plan_floors(IfcPlan *p) {
    cut_floors(p);
    find_ground(p);
}
