// ifc_building_objects.c - the bodies of products as objects: furniture, stairs, columns, roofs, balconies, lamps; and styles as
// materials. Walls, and floors under rooms, are made from the free space; of a slab only what lies beyond rooms and walls is added.
#include <math.h>
#include <string.h>
#include <strings.h>

#include "maps/ifc_building/ifc_building.h"

// Radiant flux of a light fixture, W: some 2,300 lm, as a luminaire of an office has. Files seldom say it.
// A thing that ends no higher above a floor than this lies under the floor, metres.
static const double UNDER_FLOOR = 0.02;
static const double LAMP_WATTS = 10;
static const double LAMP_RADIUS = 0.0325;
// A polygon this near to the floor or the ceiling of a room lies in it, metres.
static const double IN_PLANE = 0.01;
// The part of a slab beyond rooms and walls counts from this area and width on, metres^2 and metres.
static const double BALCONY = 0.5, BALCONY_WIDTH = 0.15;
// Rooms and walls within this above and below a slab stand on it or hang from it, metres.
static const double BESIDE = 0.5;

// ---- meshes

// Whether a level polygon lies in the floor or the ceiling of a room, which is there already.
static bool in_room_plane(IfcPlan *p, const Vec3 *c, int count) {
    Box box;
    Vec3 middle = ifc_middle(c, count, &box);
    if (box.max.z - box.min.z > IN_PLANE) return false;
    for (int side = -1; side <= 1; side += 2) {
        int room = ifc_room_at(p, -1, vec3(middle.x, middle.y, middle.z + side * 2 * IN_PLANE));
        if (room < 0) continue;
        double plane = side > 0 ? p->rooms[room].z0 : p->rooms[room].z1;
        if (fabs(middle.z - plane) <= IN_PLANE) return true;
    }
    return false;
}

// ---- which side of a surface is its front

// Bodies of more polygons keep the sides that the file gives them.
enum { MOST_TURNED = 2000 };
// The area vectors of a closed surface whose sides are right add up to nothing, but for this share of the area, and its volume is not
// negative.
static const double CLOSED = 1e-4;
// How far off a polygon its two sides begin, metres.
static const double OFF_SURFACE = 1e-4;

// Does a ray meet the convex polygon?
static bool meets(Vec3 from, Vec3 ray, const Vec3 *c, int count, Vec3 area) {
    double towards = vec3_dot(area, ray), t = vec3_dot(area, vec3_sub(c[0], from)) / towards;
    if (!(t > 0) || !isfinite(t)) return false;
    Vec3 at = vec3_add(from, vec3_scale(ray, t));
    for (int k = 0; k < count; k++) {
        Vec3 a = c[k], b = c[k + 1 == count ? 0 : k + 1];
        if (vec3_dot(vec3_cross(vec3_sub(b, a), vec3_sub(at, a)), area) < 0) return false;
    }
    return true;
}

// Is the side to which `n` points inside the body? Then a ray from there meets its surface an odd number of times.
static bool is_in_body(const IfcMesh *mesh, const Vec3 *areas, Vec3 middle, Vec3 n) {
    Vec3 aside = vec3_cross(n, fabs(n.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0));
    // Askew, since edges often lie straight before each other.
    Vec3 ray = vec3_add(n, vec3_add(vec3_scale(aside, 0.137), vec3_scale(vec3_cross(n, aside), 0.071)));
    Vec3 from = vec3_add(middle, vec3_scale(n, OFF_SURFACE));
    bool inside = false;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *p = &mesh->polygons[i];
        inside ^= meets(from, ray, mesh->corners + p->first_corner, p->corner_count, areas[i]);
    }
    return inside;
}

// Some programs write surfaces whose sides are anyhow: marks the polygons that show their backs to the outside. Light falls on fronts.
static void find_turned(const IfcMesh *mesh, Arena *arena, bool *turned) {
    Vec3 *areas = ARENA_ARRAY(arena, Vec3, mesh->polygon_count), sum = {0, 0, 0};
    double total = 0, volume = 0;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *p = &mesh->polygons[i];
        const Vec3 *corners = mesh->corners + p->first_corner;
        areas[i] =
            vec3_scale(plane_of_polygon(corners, p->corner_count).n, polygon_area(corners, p->corner_count));
        sum = vec3_add(sum, areas[i]);
        total += vec3_length(areas[i]);
        volume += vec3_dot(vec3_sub(corners[0], mesh->corners[0]), areas[i]);
    }
    bool right = vec3_length(sum) <= CLOSED * total && volume >= 0;
    if (mesh->polygon_count > MOST_TURNED || right) return;
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *p = &mesh->polygons[i];
        if (!(vec3_length(areas[i]) > 0)) continue;
        Box box;
        Vec3 middle = ifc_middle(mesh->corners + p->first_corner, p->corner_count, &box),
             n = vec3_normalize(areas[i]);
        turned[i] = is_in_body(mesh, areas, middle, n) && !is_in_body(mesh, areas, middle, vec3_scale(n, -1));
    }
}

// `places` may be NULL.
static void add_corners(IfcPlan *p, const Vec3 *corners, const Vec2 *places, int count, bool turned,
                        int material) {
    if (turned) {
        Vec3 *other = ARENA_ARRAY(&p->scratch, Vec3, count);
        Vec2 *there = ARENA_ARRAY(&p->scratch, Vec2, count);
        for (int k = 0; k < count; k++) other[k] = corners[count - 1 - k];
        for (int k = 0; k < count && places; k++) there[k] = places[count - 1 - k];
        corners = other;
        places = places ? there : NULL;
    }
    building_add_textured(p->arena, p->b, corners, places, count, material);
}

int ifc_add_mesh(IfcPlan *p, const IfcMesh *mesh, ObjectKind kind, const char *name, int otherwise) {
    Building *b = p->b;
    if (mesh->polygon_count == 0) return -1;
    if (b->polygon_count > BUILDING_MOST_POLYGONS - mesh->polygon_count) {
        building_tally(&p->too_many, name, mesh->corners[0]);
        return -1;
    }
    bool *turned = ARENA_ARRAY(&p->scratch, bool, mesh->polygon_count);
    find_turned(mesh, &p->scratch, turned);
    int object = building_add_object(p->arena, b, kind, name);
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *polygon = &mesh->polygons[i];
        const Vec3 *corners = mesh->corners + polygon->first_corner;
        if (in_room_plane(p, corners, polygon->corner_count)) continue;
        const Vec2 *places = mesh->places ? mesh->places + polygon->first_corner : NULL;
        if (places && isnan(places[0].x)) places = NULL;
        add_corners(p, corners, places, polygon->corner_count, turned[i],
                    places ? ifc_pictured(p, polygon->material, otherwise)
                           : ifc_material(p, polygon->material, otherwise));
    }
    if (b->objects[object].polygon_count > 0) return object;
    b->object_count--;
    return -1;
}

static void add_fixture(IfcPlan *p, int product, int object) {
    const IfcProduct *it = &p->model->products[product];
    Box box = it->box;
    Vec3 at = vec3_lerp(box.min, box.max, 0.5);
    at.z = fmax(box.min.z + LAMP_RADIUS, at.z - 0.2);
    const float share = (float)(LAMP_WATTS / 3);
    Light light = {.name = arena_string(p->arena, ifc_name(p, product)),
                   .position = at,
                   .radius = LAMP_RADIUS,
                   .flux = {share, share, share},
                   .object = object,
                   .turn = atan2(it->axis[0].y, it->axis[0].x)};
    *ARENA_PUSH(p->arena, p->b->lights, p->b->light_count, p->b->light_capacity) = light;
}

// ---- slabs

// A level plate: its top, underside and edges.
static void add_plate(IfcPlan *p, const SolidOutline *o, double z0, double z1, int material) {
    Vec2 *ring;
    int n = solid_one_ring(o, &p->scratch, &ring);
    Vec3 *top = ARENA_ARRAY(&p->scratch, Vec3, n), *under = ARENA_ARRAY(&p->scratch, Vec3, n);
    for (int i = 0; i < n; i++) {
        top[i] = vec3(ring[i].x, ring[i].y, z1);
        under[n - 1 - i] = vec3(ring[i].x, ring[i].y, z0);
    }
    building_add_polygon(p->arena, p->b, top, n, material);
    building_add_polygon(p->arena, p->b, under, n, material);
    for (int r = 0; r < o->ring_count; r++) {
        for (int i = o->ring[r]; i < o->ring[r + 1]; i++) {
            Vec2 a = o->points[i], b = o->points[i + 1 == o->ring[r + 1] ? o->ring[r] : i + 1];
            Vec3 side[4] = {{a.x, a.y, z0}, {b.x, b.y, z0}, {b.x, b.y, z1}, {a.x, a.y, z1}};
            building_add_polygon(p->arena, p->b, side, 4, material);
        }
    }
}

// Balconies, terraces and landings: what of a level slab lies beyond the rooms and walls beside it.
static void add_slab(IfcPlan *p, int product) {
    const IfcProduct *it = &p->model->products[product];
    double z0 = it->box.min.z, z1 = it->box.max.z, middle = (z0 + z1) / 2;
    SolidOutlines within = {NULL, 0, 0};
    Box around = it->box;
    around.min.z -= BESIDE;
    around.max.z += BESIDE;
    for (int n = box_tree_find(&p->room_tree, around, &p->scratch, &p->near); n-- > 0;) {
        const IfcRoom *room = &p->rooms[p->near.items[n]];
        // A room through whose middle the slab reaches does not hide it.
        if (z0 > room->z0 + BESIDE && z1 < room->z1 - BESIDE) continue;
        for (int k = 0; k < room->outline.count; k++)
            *ARENA_PUSH(&p->scratch, within.items, within.count, within.capacity) = room->outline.items[k];
    }
    for (int n = box_tree_find(&p->wall_tree, around, &p->scratch, &p->near); n-- > 0;) {
        const SolidOutlines *wall = &p->walls[p->near.items[n]];
        for (int k = 0; k < wall->count; k++)
            *ARENA_PUSH(&p->scratch, within.items, within.count, within.capacity) = wall->items[k];
    }
    for (int i = 0; i < it->mesh.polygon_count; i++)
        solid_add(p->tracer, it->mesh.corners + it->mesh.polygons[i].first_corner,
                  it->mesh.polygons[i].corner_count);
    SolidOutlines whole = solid_cover(p->tracer, middle, middle + MAPS_GRID);
    SolidOutlines rest = solid_difference(p->tracer, &whole, &within, BALCONY_WIDTH);
    int material = p->thing_material;
    for (int i = 0; i < it->mesh.polygon_count && material == p->thing_material; i++)
        material = ifc_material(p, it->mesh.polygons[i].material, p->thing_material);
    int object = -1;
    for (int i = 0; i < rest.count; i++) {
        if (rest.items[i].area < BALCONY) continue;
        if (object < 0) object = building_add_object(p->arena, p->b, OBJECT_LOW_WALL, ifc_name(p, product));
        add_plate(p, &rest.items[i], z0, z1, material);
    }
}

// A slab between level planes, whose parts can be taken away in plan.
static bool is_level(const IfcProduct *it) {
    for (int i = 0; i < it->mesh.polygon_count; i++) {
        const IfcPolygon *polygon = &it->mesh.polygons[i];
        Plane plane = plane_of_polygon(it->mesh.corners + polygon->first_corner, polygon->corner_count);
        if (fabs(plane.n.z) < 0.9999 && fabs(plane.n.z) > 1e-4) return false;
    }
    return it->mesh.polygon_count > 0;
}

// ---- all

// Whether the middle of a thing is in a wall.
static bool in_wall(IfcPlan *p, const IfcProduct *it) {
    Vec3 middle = vec3_lerp(it->box.min, it->box.max, 0.5);
    int count = box_tree_find(&p->wall_tree, (Box){middle, middle}, &p->scratch, &p->near);
    for (int i = 0; i < count; i++)
        for (int k = 0, wall = p->near.items[i]; k < p->walls[wall].count; k++)
            if (solid_contains(&p->walls[wall].items[k], vec2(middle.x, middle.y))) return true;
    return false;
}

static bool in_curtain(const IfcModel *m, const IfcProduct *it) {
    return it->whole >= 0 && m->products[it->whole].kind == IFC_CURTAIN_WALL;
}

static void add_product(IfcPlan *p, int product) {
    const IfcModel *m = p->model;
    const IfcProduct *it = &m->products[product];
    const char *name = ifc_name(p, product);
    ObjectKind kind = OBJECT_FURNITURE;
    bool box = false;  // has a stand-in for collision and light
    int otherwise = p->thing_material, object;
    switch (it->kind) {
    case IFC_SPACE:
    case IFC_OPENING:
    case IFC_DOOR:
    case IFC_WINDOW:
    case IFC_SITE:
    case IFC_CURTAIN_WALL:
    case IFC_UNBUILT:
    case IFC_KINDS:
        return;
    case IFC_WALL:
        if (p->walls[product].count > 0) return;
        kind = OBJECT_LOW_WALL;
        otherwise = p->wall_material;
        break;
    case IFC_SLAB:
        if (ifc_is_stair(m, it)) {
            kind = OBJECT_STAIR;
            box = true;
            break;
        }
        if (is_level(it) && strcasecmp(it->predefined, "ROOF") != 0) {
            add_slab(p, product);
            return;
        }
        kind = OBJECT_LOW_WALL;
        break;
    case IFC_ROOF:
    case IFC_COVERING:
    case IFC_BEAM:
        kind = OBJECT_LOW_WALL;
        break;
    case IFC_STAIR:
    case IFC_RAMP:
        kind = OBJECT_STAIR;
        box = true;
        break;
    case IFC_COLUMN:
        if (in_wall(p, it)) return;
        box = true;
        break;
    case IFC_MEMBER:
    case IFC_PLATE:
        if (in_curtain(m, it)) return;
        break;
    case IFC_RAILING:
        break;
    case IFC_LIGHT:
        kind = OBJECT_LAMP;
        box = true;
        break;
    case IFC_FURNISHING:
    case IFC_OTHER:
        box = true;
        break;
    }
    // A foundation that ends at the floor is in nobody's way.
    box = box && it->box.max.z > p->b->storeys[ifc_storey_at(p, it->box.max.z)].floor + UNDER_FLOOR;
    object = ifc_add_mesh(p, &it->mesh, kind, name, otherwise);
    if (object >= 0 && box) building_set_proxy(p->arena, p->b, atan2(it->axis[0].y, it->axis[0].x));
    if (it->kind == IFC_LIGHT && object >= 0) add_fixture(p, product, object);
}

void ifc_add_objects(IfcPlan *p) {
    for (int i = 0; i < p->model->product_count; i++) add_product(p, i);
}
