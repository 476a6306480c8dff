// first_view.c - candidates for the first view are drawn small by the z-buffer, and judged by how far one sees: the share of the picture
// that one polygon fills, and the distance in the middle. The first picture is drawn by the same z-buffer: it needs no OpenGL, whose
// shaders take longer to compile than the building takes to read.
#include "engine/walk/first_view.h"

#include <stdlib.h>

#include "engine/draw/view.h"
#include "engine/shade/walk_bake.h"
#include "engine/sim/door_states.h"

// The picture by which a view is judged, pixels.
enum { JUDGE_WIDTH = 48, JUDGE_HEIGHT = 27 };
// A view looks at a wall or a door where its middle is nearer than this, metres, which is a step less than the width of a living room,
// or one polygon fills more than this share of it; it is obstructed where more than this share is nearer than an arm's length.
static const double MIDDLE_NEAREST = 3.5, ONE_POLYGON = 0.6, ARM = 0.6, ARM_SHARE = 0.3;
// All around a place: four square views.
enum { SIDES = 4, SIDE_WIDTH = 32, AROUND = SIDES * SIDE_WIDTH };
// At most so many places of a room are tried. They lie this far from a corner of a cell, metres: there one sees most of the room.
enum { PLACES = 12 };
static const double FROM_CORNER = 0.9;
// Farther than this counts as this far, metres.
static const double FAR = 12;
// A place counts as free where a body that is put there moves less than this, metres.
static const double MOVED = 0.3;

// ---- what is seen

// A picture, and copies of the polygons in it as doors stand: item i is polygon i of these, whose vertices are `vertices`.
typedef struct Seen {
    Polygon *polygons;
    Vec3 *vertices;
    int count;
    ItemBuffer items;
} Seen;

static int count_vertices(const CellGraph *graph, const VisResult *seen) {
    int count = 0;
    for (int k = 0; k < seen->object_count; k++) {
        const Object *o = &graph->objects[seen->objects[k]];
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++)
            count += graph->polygons[p].vertex_count;
    }
    return count;
}

// Copies the polygons that a camera at `eye` may see: surfaces by their front alone, and no glass.
static void copy_polygons(const FirstScene *scene, Vec3 eye, const VisResult *seen, Arena *scratch,
                          Seen *out) {
    const CellGraph *graph = scene->graph;
    const Building *b = graph->building;
    out->polygons = ARENA_ARRAY(scratch, Polygon, seen->polygon_count + 1);
    out->vertices = ARENA_ARRAY(scratch, Vec3, count_vertices(graph, seen) + 1);
    int vertices = 0;
    for (int k = 0; k < seen->object_count; k++) {
        const Object *o = &graph->objects[seen->objects[k]];
        const Leaf *leaf = o->leaf < 0 ? NULL : &b->leaves[o->leaf];
        double open = leaf && scene->door_open ? (double)scene->door_open[leaf->opening] : 1;
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[p];
            const Vec3 *v = graph->vertices + polygon->first_vertex;
            if (vis_is_glass(graph, p)) continue;
            if (o->kind == OBJECT_SURFACE &&
                plane_distance(plane_of_polygon(v, polygon->vertex_count), eye) <= 0)
                continue;
            Polygon *copy = &out->polygons[out->count++];
            *copy = *polygon;
            copy->first_vertex = vertices;
            for (int i = 0; i < polygon->vertex_count; i++)
                out->vertices[vertices++] = leaf ? leaf_point(leaf, open, v[i]) : v[i];
        }
    }
}

static bool draw_items(const FirstScene *scene, const Camera *camera, Arena *scratch, Seen *out,
                       Error *error) {
    Eye eye = walk_eye(camera);
    VisResult seen =
        vis_query(scene->query, &eye, vis_locate(scene->graph, camera->eye, -1), scene->door_open, CULL_STAB);
    *out = (Seen){.count = 0};
    copy_polygons(scene, camera->eye, &seen, scratch, out);
    Scene items = {out->polygons, out->vertices, NULL, out->count};
    const HiddenMethod *method = hidden_find("zbuffer");
    void *prepared = method->begin(&items, scratch, error);
    if (!prepared) return false;
    out->items = item_buffer_new(scratch, camera->width, camera->height);
    bool good = hidden_draw(method, prepared, camera, &out->items, NULL, error);
    if (method->end) method->end(prepared);
    return good;
}

// ---- judging views

static bool looks_into_room(const FirstScene *scene, const Viewpoint *v, double fov) {
    const CellGraph *graph = scene->graph;
    Arena scratch = {0};
    Seen seen;
    int cell = vis_locate(graph, v->eye, -1);
    Camera camera = camera_look(v->eye, v->yaw, v->pitch, fov, JUDGE_WIDTH, JUDGE_HEIGHT);
    bool rooms = graph->building->form == FORM_REGIONS;
    bool good = cell >= 0 && (!rooms || vis_region(graph, cell)->kind == REGION_ROOM) &&
                draw_items(scene, &camera, &scratch, &seen, NULL);
    if (good) {
        int *pixels = ARENA_ARRAY(&scratch, int, seen.count + 1), most = 0, near = 0;
        double middle = 0;
        int middles = 0;
        for (int y = 0; y < JUDGE_HEIGHT; y++) {
            for (int x = 0; x < JUDGE_WIDTH; x++) {
                int i = y * JUDGE_WIDTH + x, item = seen.items.item[i];
                double depth = fmin((double)seen.items.depth[i], FAR);
                near += depth < ARM;
                if (item >= 0 && ++pixels[item] > most) most = pixels[item];
                if (abs(2 * x - JUDGE_WIDTH) > JUDGE_WIDTH / 4 ||
                    abs(2 * y - JUDGE_HEIGHT) > JUDGE_HEIGHT / 4)
                    continue;
                middle += depth;
                middles++;
            }
        }
        const double all = JUDGE_WIDTH * JUDGE_HEIGHT;
        good = middle / middles >= MIDDLE_NEAREST && most <= ONE_POLYGON * all && near <= ARM_SHARE * all;
    }
    arena_free(&scratch);
    return good;
}

// ---- the largest room

static double plan_area(const CellGraph *graph, const Cell *cell) {
    double area = 0;
    for (int i = 0; i < cell->edge_count; i++)
        area += vec2_cross(graph->plan[cell->first_edge + i],
                           graph->plan[cell->first_edge + (i + 1) % cell->edge_count]) /
                2;
    return area;
}

static int largest_room(const CellGraph *graph, Arena *scratch) {
    const Building *b = graph->building;
    double *area = ARENA_ARRAY(scratch, double, b->region_count + 1);
    int best = -1;
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        int r = cell->region;
        if (r < 0 || b->regions[r].kind != REGION_ROOM || cell->z1 - cell->z0 < BODY_EYE + BODY_RADIUS)
            continue;
        area[r] += plan_area(graph, cell);
        if (best < 0 || area[r] > area[best]) best = r;
    }
    return best;
}

// How far it is from a place to the border of a box in plan, metres.
static double way_out(Box box, Vec3 from, Vec3 way) {
    double x = way.x > 0 ? box.max.x - from.x : from.x - box.min.x,
           y = way.y > 0 ? box.max.y - from.y : from.y - box.min.y;
    return fmin(way.x != 0 ? x / fabs(way.x) : INFINITY, way.y != 0 ? y / fabs(way.y) : INFINITY);
}

// The distances seen all around, column by column from yaw 0 on, each the mean over a quarter of the height. What lies outside the room,
// behind windows and doors, is no farther than its border.
static bool see_all_around(const FirstScene *scene, Vec3 eye, Box room, Arena *scratch, double *out) {
    enum { HEIGHT = SIDE_WIDTH / 2 };
    for (int side = 0; side < SIDES; side++) {
        Seen seen;
        Camera camera = camera_look(eye, (side + 0.5) * M_PI / 2, 0, M_PI / 2, SIDE_WIDTH, HEIGHT);
        if (!draw_items(scene, &camera, scratch, &seen, NULL)) return false;
        for (int x = 0; x < SIDE_WIDTH; x++) {
            Vec3 ray = camera_ray(&camera, x + 0.5, HEIGHT / 2);
            double sum = 0, most = way_out(room, eye, ray);
            for (int y = HEIGHT / 4; y < HEIGHT - HEIGHT / 4; y++)
                sum += fmin((double)seen.items.depth[y * SIDE_WIDTH + x], most) * hypot(ray.x, ray.y);
            // Columns go clockwise, yaws counter-clockwise.
            out[side * SIDE_WIDTH + SIDE_WIDTH - 1 - x] = sum / (HEIGHT / 2);
        }
    }
    return true;
}

// The direction in which a view of this width sees farthest; the middle counts twice, and what is within an arm's reach against it.
static double best_yaw(const double *around, double fov, double *score) {
    int half = (int)(fov / 2 / (2 * M_PI) * AROUND), best = 0;
    *score = -INFINITY;
    for (int c = 0; c < AROUND; c++) {
        double sum = 0;
        for (int k = -half; k <= half; k++) {
            double far = around[(c + k + AROUND) % AROUND];
            sum += (far < ARM ? -FAR : far) * (2 * abs(k) < half ? 2 : 1);
        }
        if (sum > *score) *score = sum, best = c;
    }
    // Columns are equally wide on the screen of a side, not in angle.
    double across = 2 * (best % SIDE_WIDTH + 0.5) / SIDE_WIDTH - 1;
    return (best / SIDE_WIDTH + 0.5) * M_PI / 2 + atan(across);
}

// Places in the cells of a room near their corners, at the height of an eye.
static int places_in(const CellGraph *graph, int region, Vec3 *out, int most) {
    int count = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        if (cell->region != region) continue;
        Vec2 middle = {0, 0};
        for (int i = 0; i < cell->edge_count; i++)
            middle = vec2_add(middle, vec2_scale(graph->plan[cell->first_edge + i], 1.0 / cell->edge_count));
        for (int i = 0; i <= cell->edge_count && count < most; i++) {
            Vec2 at = middle;
            if (i < cell->edge_count) {
                Vec2 corner = graph->plan[cell->first_edge + i], way = vec2_sub(middle, corner);
                double length = vec2_length(way);
                if (length < FROM_CORNER) continue;
                at = vec2_add(corner, vec2_scale(way, FROM_CORNER / length));
            }
            out[count++] = vec3(at.x, at.y, cell->z0 + BODY_EYE);
        }
    }
    return count;
}

static bool view_of_largest_room(const FirstScene *scene, double fov, Arena *scratch, Viewpoint *out) {
    const CellGraph *graph = scene->graph;
    int region = graph->building->form == FORM_REGIONS ? largest_room(graph, scratch) : -1;
    if (region < 0) return false;
    int most = 0;
    Box room = box_empty();
    for (int c = 0; c < graph->cell_count; c++) {
        if (graph->cells[c].region != region) continue;
        most += graph->cells[c].edge_count + 1;
        room = box_union(room, graph->cells[c].box);
    }
    Vec3 *places = ARENA_ARRAY(scratch, Vec3, most + 1);
    int count = places_in(graph, region, places, most), step = (count + PLACES - 1) / PLACES;
    double best = -INFINITY;
    for (int i = 0; i < count; i += step) {
        Arena around = {0};
        Body body = {.cell = -1};
        double far[AROUND], score;
        Vec3 foot = vec3_sub(places[i], vec3(0, 0, BODY_EYE));
        if (body_place_near(&body, scene->world, foot) && vec3_length(vec3_sub(body.foot, foot)) <= MOVED &&
            see_all_around(scene, vec3_add(body.foot, vec3(0, 0, body_eye(&body))), room, &around, far)) {
            double yaw = best_yaw(far, fov, &score);
            if (score > best) {
                best = score;
                out->eye = vec3_add(body.foot, vec3(0, 0, body_eye(&body)));
                out->yaw = remainder(yaw, 2 * M_PI);
            }
        }
        arena_free(&around);
    }
    return best > -INFINITY;
}

Viewpoint first_view(const FirstScene *scene, double fov, Arena *scratch) {
    const Building *b = scene->graph->building;
    Viewpoint start = {.name = "", .eye = b->start, .yaw = b->start_yaw, .fov = fov}, room = start;
    if (looks_into_room(scene, &start, fov)) return start;
    for (int i = 0; i < b->viewpoint_count; i++)
        if (looks_into_room(scene, &b->viewpoints[i], fov)) return b->viewpoints[i];
    return view_of_largest_room(scene, fov, scratch, &room) ? room : start;
}

Viewpoint first_view_of_walk(const CellGraph *graph, const StabForest *forest) {
    Arena scratch = {0};
    const Building *b = graph->building;
    float *door_open = ARENA_ARRAY(&scratch, float, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) door_open[i] = (float)b->openings[i].open;
    walk_clear_views(b, door_open);
    BodyWorld world = body_world(graph, door_open, &scratch);
    FirstScene scene = {graph, vis_query_new(graph, forest, &scratch), door_open, &world};
    Viewpoint first = first_view(&scene, FIRST_VIEW_FOV, &scratch);
    arena_free(&scratch);
    return first;
}

// ---- the first picture

static uint32_t pack(Rgba8 c) { return 0xff000000u | (uint32_t)c.r << 16 | (uint32_t)c.g << 8 | c.b; }

bool first_picture(const FirstScene *scene, const Camera *camera, Arena *scratch, uint32_t *out,
                   Error *error) {
    const CellGraph *graph = scene->graph;
    Seen seen;
    if (!draw_items(scene, camera, scratch, &seen, error)) return false;
    uint32_t *colour = ARENA_ARRAY(scratch, uint32_t, seen.count + 1);
    const uint32_t sky = pack(walk_bake_sky());
    for (int y = 0; y < camera->height; y++) {
        uint32_t *row = out + (size_t)y * (size_t)camera->width;
        for (int x = 0; x < camera->width; x++) {
            int p = seen.items.item[(size_t)y * (size_t)camera->width + (size_t)x];
            if (p >= 0 && colour[p] == 0) {
                const Polygon *polygon = &seen.polygons[p];
                Plane plane = plane_of_polygon(seen.vertices + polygon->first_vertex, polygon->vertex_count);
                if (plane_distance(plane, camera->eye) < 0) plane.n = vec3_scale(plane.n, -1);
                colour[p] = pack(walk_bake_plain(&graph->building->materials[polygon->material], plane.n));
            }
            row[x] = p < 0 ? sky : colour[p];
        }
    }
    return true;
}
