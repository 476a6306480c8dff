// query_gate.c - the portals as cells have them, four to a block, and which of them a cone shows.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

// Of a portal's normal: what its corners lean over a storey is less than any slack.
static const double LEAN = 1e-9;
// What a rectangle's area may lack of its bounding one's, relative.
static const double AREA_ROUNDING = 1e-9;

bool query_is_wall(const CellGraph *graph, const Portal *portal, Plane plane, double *s, double *z) {
    if (fabs(plane.n.z) > LEAN) return false;
    s[0] = z[0] = INFINITY, s[1] = z[1] = -INFINITY;
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    for (int i = 0; i < portal->vertex_count; i++) {
        double at = plane.n.y * v[i].x - plane.n.x * v[i].y;
        s[0] = fmin(s[0], at), s[1] = fmax(s[1], at);
        z[0] = fmin(z[0], v[i].z), z[1] = fmax(z[1], v[i].z);
    }
    double area = (s[1] - s[0]) * (z[1] - z[0]);
    return polygon_area(v, portal->vertex_count) >= area * (1 - AREA_ROUNDING);
}

static Box portal_box(const CellGraph *graph, const Portal *portal) {
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++)
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    return box;
}

bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye) {
    return box_contains(box_grow(portal_box(graph, portal), AT_PORTAL), eye);
}

// Writes a lane; returns whether the portal is an upright rectangle. Of others `sloped` is the index.
static bool set_gate(const VisQuery *q, int cell, Contact contact, int sloped, GateBlock *out, int lane) {
    const CellGraph *graph = q->graph;
    const Portal *p = &graph->portals[contact.portal];
    double side = p->cell[0] == cell ? 1 : -1, s[2], z[2];
    Plane plane = {vec3_scale(p->plane.n, side), side * p->plane.d};
    bool wall = query_is_wall(graph, p, plane, s, z);
    out->nx[lane] = plane.n.x;
    out->ny[lane] = plane.n.y;
    out->d[lane] = plane.d;
    out->s0[lane] = wall ? s[0] : 0;
    out->s1[lane] = wall ? s[1] : -1 - sloped;
    out->z0[lane] = wall ? z[0] : plane.n.z;
    out->z1[lane] = wall ? z[1] : 0;
    out->cell[lane] = contact.cell;
    out->beyond[lane] = q->of_cell[contact.cell].first_block | (p->door >= 0 ? GATE_DOOR : 0);
    return wall;
}

static void list_gates_of(VisQuery *q, int c, Arena *arena, int *sloped_count, int *sloped_capacity) {
    const CellGraph *graph = q->graph;
    const Cell *cell = &graph->cells[c];
    int first = q->of_cell[c].first_block;
    for (int i = 0; i < cell->contact_count; i++) {
        Contact contact = graph->contacts[cell->first_contact + i];
        const Portal *portal = &graph->portals[contact.portal];
        int gate = first * FOUR + i;
        q->gate_of[2 * contact.portal + (portal->cell[0] == c ? 0 : 1)] = gate;
        q->portal_of[gate] = contact.portal;
        if (set_gate(q, c, contact, *sloped_count, &q->gates[gate / FOUR], gate % FOUR)) continue;
        Box box = portal_box(graph, portal);
        Sloped *sloped = ARENA_PUSH(arena, q->sloped, *sloped_count, *sloped_capacity);
        sloped->centre = vec3_lerp(box.min, box.max, 0.5);
        sloped->half = vec3_sub(box.max, sloped->centre);
    }
}

void query_list_gates(VisQuery *q, Arena *arena) {
    const CellGraph *graph = q->graph;
    int blocks = 0, sloped_count = 0, sloped_capacity = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        q->of_cell[c].first_block = blocks;
        q->of_cell[c].block_count = (graph->cells[c].contact_count + FOUR - 1) / FOUR;
        blocks += q->of_cell[c].block_count;
    }
    q->block_count = blocks;
    q->gates = ARENA_ARRAY(arena, GateBlock, blocks);
    q->views = ARENA_ARRAY(arena, ViewBlock, blocks);
    q->view_frame = ARENA_ARRAY(arena, unsigned, blocks);
    q->queue = ARENA_ARRAY(arena, uint64_t, FOUR * blocks + 1);
    q->portal_of = ARENA_ARRAY(arena, int, FOUR *blocks);
    q->gate_of = ARENA_ARRAY(arena, int, 2 * graph->portal_count);
    for (int k = 0; k < blocks; k++) q->gates[k].d = four_of(INFINITY);
    for (int c = 0; c < graph->cell_count; c++) list_gates_of(q, c, arena, &sloped_count, &sloped_capacity);
}

Gate query_gate(const VisQuery *q, int gate) {
    const GateBlock *gates = &q->gates[gate / FOUR];
    int lane = gate % FOUR;
    bool wall = gates->s0[lane] <= gates->s1[lane];
    Plane plane = {{gates->nx[lane], gates->ny[lane], wall ? 0 : gates->z0[lane]}, gates->d[lane]};
    return (Gate){.portal = q->portal_of[gate],
                  .cell = gates->cell[lane],
                  .sloped = wall ? -1 : (int)(-1 - gates->s1[lane]),
                  .plane = plane,
                  .ahead = plane_distance(plane, q->eye->position)};
}

unsigned query_sight(const VisQuery *q, const Cone *cone, int block, unsigned lanes, Sight *out) {
    const GateBlock *gates = &q->gates[block];
    Vec3 eye = q->eye->position;
    FourMask wall = gates->s0 <= gates->s1;
    Four ahead = gates->nx * eye.x + gates->ny * eye.y - gates->d;
    ahead += four_choose(wall, four_of(0), gates->z0 * eye.z);
    lanes &= four_lanes(ahead >= -ON_PLANE);  // from behind one would come back through it
    out->others = lanes & four_lanes(~wall | (ahead < ON_PLANE));
    out->slots = lanes & ~out->others;
    out->ahead = ahead;
    if (out->slots) out->slots &= query_slots_clip(cone, gates, eye, ahead, &out->slot);
    return lanes;
}
