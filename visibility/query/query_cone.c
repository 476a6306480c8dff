// query_cone.c - the view volume as it narrows from portal to portal: planes through the eye, and its wedge in plan.
//
// It is kept a little too large, so that nothing a rasteriser could show is lost: see ANGLE_SLACK and POSITION_SLACK.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

// Widens the wedge by the slack that the three-dimensional planes have too; of unit length then.
static void tilt_wedge(Cone *cone, double nearest) {
    cone->from = cone_turned(vec2_scale(cone->from, 1 / vec2_length(cone->from)), -1, nearest);
    cone->to = cone_turned(vec2_scale(cone->to, 1 / vec2_length(cone->to)), 1, nearest);
    if (vec2_cross(cone->from, cone->to) <= 0) cone->all_around = true;
}

// The wedge of plan directions from the eye to the polygon's corners; all around when they span a half turn.
static void set_wedge(Cone *cone, Vec2 eye, const Vec3 *polygon, int count) {
    cone->all_around = false;
    double nearest = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec2 d = {polygon[i].x - eye.x, polygon[i].y - eye.y};
        double length2 = vec2_dot(d, d);
        if (length2 < nearest) nearest = length2;
        if (i == 0) {
            cone->from = cone->to = d;
            continue;
        }
        if (vec2_cross(cone->from, d) < 0) cone->from = d;
        if (vec2_cross(cone->to, d) > 0) cone->to = d;
    }
    nearest = sqrt(nearest);
    // The corners' directions lie between the extremes found only if none is behind them.
    bool good = nearest > AT_PORTAL &&
                (vec2_cross(cone->from, cone->to) > 0 ||
                 (vec2_cross(cone->from, cone->to) == 0 && vec2_dot(cone->from, cone->to) > 0));
    Vec2 ahead = vec2_add(vec2_scale(cone->from, 1 / vec2_length(cone->from)),
                          vec2_scale(cone->to, 1 / vec2_length(cone->to)));
    for (int i = 0; i < count && good; i++) {
        Vec2 d = {polygon[i].x - eye.x, polygon[i].y - eye.y};
        good = vec2_cross(cone->from, d) >= 0 && vec2_cross(d, cone->to) >= 0 && vec2_dot(d, ahead) > 0;
    }
    cone->all_around = !good;
    if (good) tilt_wedge(cone, nearest);
}

// Planes through the eye and the polygon's edges, tilted outwards by the slack; `inside` is a direction into the
// polygon.
static void set_planes(Cone *cone, Vec3 eye, const Vec3 *polygon, int count, Vec3 inside) {
    cone->count = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = vec3_sub(polygon[i], eye), b = vec3_sub(polygon[i + 1 == count ? 0 : i + 1], eye);
        Vec3 n = vec3_cross(a, b), edge = vec3_sub(b, a);
        double area = vec3_length(n), length = vec3_length(edge);
        // The eye is in line with this edge, or the edge is a point: its plane is noise, the others do without it.
        if (area <= 1e-9 * length || length < 1e-12) continue;
        n = vec3_scale(n, 1 / area);
        if (vec3_dot(n, inside) < 0) n = vec3_scale(n, -1);
        double distance = area / length;  // from the eye to the edge's line
        // As good as unit length: the tilt is small, but where the eye is at the edge, and there it is slack.
        n = vec3_add(n, vec3_scale(inside, ANGLE_SLACK + POSITION_SLACK / distance));
        cone_add(cone, n, vec3_dot(n, eye));
    }
}

// Far-off portals of whose plane the eye is part: what goes through lies in a thin wedge along the plane. Each corner of the
// polygon lies in it, however far it is off the direction ahead; so does all between them.
static void set_edge_on(Cone *cone, const Cone *parent, Vec3 eye, Plane plane, const Vec3 *polygon,
                        int count) {
    *cone = *parent;
    cone->is_slot = false;
    Vec3 middle = {0, 0, 0};
    for (int i = 0; i < count; i++)
        middle = vec3_add(middle, vec3_scale(vec3_sub(polygon[i], eye), 1.0 / count));
    Vec3 ahead = vec3_normalize(middle);
    double least = INFINITY;
    for (int i = 0; i < count; i++) least = fmin(least, vec3_dot(ahead, vec3_sub(polygon[i], eye)));
    if (!(least >= AT_PORTAL)) return;
    double tilt = 2 * ON_PLANE / least + ANGLE_SLACK;
    for (int side = -1; side <= 1; side += 2) {
        Vec3 n = vec3_normalize(vec3_add(vec3_scale(plane.n, side), vec3_scale(ahead, tilt)));
        cone_add(cone, n, vec3_dot(n, eye));
    }
}

// The mean of the corners as seen from the eye, and the distance of the nearest.
static Vec3 mean_offset(const Vec3 *polygon, int count, Vec3 eye, double *distance) {
    Vec3 sum = {0, 0, 0};
    double nearest = INFINITY;
    for (int i = 0; i < count; i++) {
        Vec3 d = vec3_sub(polygon[i], eye);
        double length2 = vec3_dot(d, d);
        if (length2 < nearest) nearest = length2;
        sum = vec3_add(sum, d);
    }
    *distance = sqrt(nearest);
    return vec3_scale(sum, 1.0 / count);
}

// Does the portal lie across the plane (0), all before it (1) or all behind (-1)?
static int side_of(const Sloped *sloped, Plane plane) {
    Vec3 half = sloped->half;
    double middle = plane_distance(plane, sloped->centre) + POSITION_SLACK;
    double reach = fabs(plane.n.x) * half.x + fabs(plane.n.y) * half.y + fabs(plane.n.z) * half.z;
    return middle >= reach ? 1 : middle < -reach ? -1 : 0;
}

// Clips the polygon by the planes of the cone. False: nothing is left.
static bool clip_by_cone(const VisQuery *q, const Cone *cone, const ViewWay *way, ViewPart *part) {
    for (int i = 0, turn = 0; i < cone->count; i++) {
        int side = way->sloped < 0 ? 0 : side_of(&q->sloped[way->sloped], cone->plane[i]);
        if (side > 0) continue;
        if (side < 0) return false;
        part->count =
            polygon_clip(part->polygon, part->count, cone->plane[i], POSITION_SLACK, part->buffer[turn]);
        part->polygon = part->buffer[turn];
        turn = 1 - turn;
        if (part->count == 0) return false;
    }
    return true;
}

Passage query_clip(const VisQuery *q, Cone *cone, const ViewWay *way, ViewPart *out) {
    const CellGraph *graph = q->graph;
    const Portal *portal = &graph->portals[way->portal];
    Vec3 eye = q->eye->position;
    bool edge_on = way->ahead < ON_PLANE;
    out->distance = 0;
    if (edge_on && query_eye_at_portal(graph, portal, eye)) return PASSAGE_ALL;
    out->polygon = graph->portal_vertices + portal->first_vertex;
    out->count = portal->vertex_count;
    if (out->count > MAX_CORNERS / 2) return PASSAGE_ALL;
    bool level = q->culling == CULL_PLAN && portal->horizontal;
    query_cone_planes(cone, eye);
    if (!level && !clip_by_cone(q, cone, way, out)) return PASSAGE_NONE;
    out->middle = mean_offset(out->polygon, out->count, eye, &out->distance);
    return level ? PASSAGE_ALL : edge_on ? PASSAGE_EDGE : PASSAGE_PART;
}

void query_beyond(const VisQuery *q, Cone *parent, Passage passage, const ViewWay *way, const ViewPart *part,
                  Cone *out) {
    Vec3 eye = q->eye->position;
    bool plan = q->culling == CULL_PLAN;
    if (passage == PASSAGE_ALL) {
        *out = *parent;
    } else if (passage == PASSAGE_EDGE) {
        query_cone_planes(parent, eye);
        set_edge_on(out, parent, eye, way->plane, part->polygon, part->count);
    } else {
        // The wedge is for finding squares: where all objects are tried it may be any.
        out->is_slot = false;
        out->all_around = true;
        if (plan || !query_lists_objects(q, way->cell))
            set_wedge(out, vec2(eye.x, eye.y), part->polygon, part->count);
        out->count = 0;
        if (plan && !out->all_around) cone_add_wedge(out, eye);
        if (!plan) set_planes(out, eye, part->polygon, part->count, vec3_normalize(part->middle));
    }
}

// The rays of the view volume's edges: where two planes meet, if no other plane is in front of it.
static int corner_rays(const Eye *eye, Vec3 *out, int max) {
    int count = 0;
    for (int i = 0; i < eye->frustum_count; i++) {
        for (int j = i + 1; j < eye->frustum_count; j++) {
            Vec3 d = vec3_cross(eye->frustum[i].n, eye->frustum[j].n);
            if (vec3_length(d) < 1e-9) continue;
            d = vec3_normalize(d);
            for (int sign = -1; sign <= 1; sign += 2) {
                Vec3 ray = vec3_scale(d, sign);
                bool inside = true;
                for (int k = 0; k < eye->frustum_count && inside; k++) {
                    inside = k == i || k == j || vec3_dot(eye->frustum[k].n, ray) >= -1e-9;
                }
                if (inside && count < max) out[count++] = ray;
            }
        }
    }
    return count;
}

// Oki 3.1: the view volume's horizontal angle, and all around when it is a half turn or more.
static void frustum_wedge(Cone *cone, const Eye *eye) {
    Vec3 rays[16];
    int count = corner_rays(eye, rays, 16);
    cone->all_around = true;
    bool up = true, down = true;
    for (int k = 0; k < eye->frustum_count; k++) {
        up = up && eye->frustum[k].n.z >= 0;
        down = down && eye->frustum[k].n.z <= 0;
    }
    if (count < 3 || up || down) return;
    for (int i = 0; i < count; i++) rays[i] = vec3_add(eye->position, rays[i]);
    set_wedge(cone, vec2(eye->position.x, eye->position.y), rays, count);
}

void query_first_cone(VisQuery *q, Cone *cone) {
    const Eye *eye = q->eye;
    cone->count = 0;
    cone->all_around = true;
    cone->is_slot = false;
    if (q->culling != CULL_PLAN) {
        for (int i = 0; i < eye->frustum_count; i++) cone_add(cone, eye->frustum[i].n, eye->frustum[i].d);
    }
    if (eye->frustum_count < 3) return;
    frustum_wedge(cone, eye);
    if (q->culling == CULL_PLAN && !cone->all_around) cone_add_wedge(cone, eye->position);
}
