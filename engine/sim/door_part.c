// door_part.c - the parts of a door that obstruct a body.
#include "engine/sim/door_part.h"

#include "engine/sim/body.h"

// Lanes through a doorway are tried LANE_APART from each other, and begin and end LANE_HALF from the middle of the wall, metres:
// most walls are thinner, and a swung leaf reaches farther than the wall and the lane.
static const double LANE_APART = 0.02, LANE_HALF = 0.4;

int door_part_count(const Building *building, int opening) {
    const Opening *o = &building->openings[opening];
    return o->kind != OPENING_DOOR ? 0 : o->leaf_count > 0 ? o->leaf_count : 1;
}

bool door_part(const Building *building, int opening, int part, double open, DoorPart *out) {
    const Opening *o = &building->openings[opening];
    if (o->leaf_count == 0) {
        *out = (DoorPart){.plan = {o->line[0], o->line[1]}, .count = 2, .heights = {o->sill, o->head}};
        return open == 0;
    }
    const Leaf *leaf = &building->leaves[o->first_leaf + part];
    out->heights = (Band){leaf->z0 + open * leaf->rise, leaf->z1 + open * leaf->rise};
    out->count = leaf_plan(building, leaf, open, out->plan);
    return true;
}

Solid door_part_solid(const DoorPart *part, Vec3 *plan) {
    Solid solid = {.vertices = plan, .count = part->count, .prism = true, .box = box_empty()};
    for (int i = 0; i < part->count; i++) {
        plan[i] = vec3(part->plan[i].x, part->plan[i].y, 0);
        solid.box = box_add(solid.box, plan[i]);
    }
    solid.box.min.z = part->heights.z0;
    solid.box.max.z = part->heights.z1;
    return solid;
}

Box door_leaf_reach(const Leaf *leaf) {
    Vec2 corner[4];
    double reach = 0;
    leaf_box(leaf, 0, corner);
    for (int i = 0; i < 4; i++) reach = fmax(reach, vec2_length(vec2_sub(corner[i], leaf->pivot)));
    Vec3 low = {leaf->pivot.x - reach, leaf->pivot.y - reach, leaf->z0};
    Vec3 high = {leaf->pivot.x + reach, leaf->pivot.y + reach, leaf->z1};
    Vec3 slide = {leaf->slide.x, leaf->slide.y, leaf->rise};
    return box_union((Box){low, high}, (Box){vec3_add(low, slide), vec3_add(high, slide)});
}

// ---- lanes

typedef struct Lane {
    Vec2 from, way;
    Band band;  // the heights that a body may neither step over nor duck under
} Lane;

static bool stops(const Solid *solid, const Lane *lane) {
    Vec2 normal;
    return solid_distance(solid, lane->band, lane->from) < BODY_RADIUS ||
           solid_sweep(solid, lane->band, lane->from, lane->way, BODY_RADIUS, &normal) < 1;
}

static bool leaves_stop(const Building *b, int opening, const Lane *lane) {
    DoorPart part;
    for (int i = 0; i < door_part_count(b, opening); i++) {
        if (!door_part(b, opening, i, 1, &part)) continue;
        Vec3 plan[LEAF_CORNERS];
        Solid solid = door_part_solid(&part, plan);
        if (stops(&solid, lane)) return true;
    }
    return false;
}

static bool frame_stops(const CellGraph *graph, int opening, const Lane *lane) {
    for (int i = 0; i < graph->surface_first[0]; i++) {
        const Object *object = &graph->objects[i];
        if (object->kind != OBJECT_FRAME || object->opening != opening || object->leaf >= 0) continue;
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[p];
            Solid solid = {.vertices = graph->vertices + polygon->first_vertex,
                           .count = polygon->vertex_count,
                           .box = box_empty()};
            for (int k = 0; k < solid.count; k++) solid.box = box_add(solid.box, solid.vertices[k]);
            if (stops(&solid, lane)) return true;
        }
    }
    return false;
}

bool door_lets_pass(const CellGraph *graph, int opening, bool with_frame) {
    const Building *b = graph->building;
    const Opening *o = &b->openings[opening];
    Vec2 along = vec2_sub(o->line[1], o->line[0]);
    double width = vec2_length(along);
    along = vec2_scale(along, 1 / width);
    Vec2 across = vec2(-along.y, along.x);
    for (double at = BODY_RADIUS; at <= width - BODY_RADIUS; at += LANE_APART) {
        Vec2 middle = vec2_add(o->line[0], vec2_scale(along, at));
        Lane lane = {.from = vec2_add(middle, vec2_scale(across, -LANE_HALF)),
                     .way = vec2_scale(across, 2 * LANE_HALF),
                     .band = {o->sill + BODY_STEP, o->sill + BODY_LOWEST}};
        if (!leaves_stop(b, opening, &lane) && !(with_frame && frame_stops(graph, opening, &lane)))
            return true;
    }
    return false;
}
