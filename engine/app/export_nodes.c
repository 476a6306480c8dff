// export_nodes.c - the tree of a building as glTF nodes, leaves of doors where they stand, and viewpoints as cameras. All is
// z up, as buildings are; the root turns it to y up.
#include "engine/app/export_parts.h"

static const double ASPECT = 16.0 / 9;  // of cameras: Viewpoint.fov is across
static const double NEAREST = 0.05;     // metres from a camera to what is drawn
static const double TURN = 0.70710678118654752;

static json_t *vector(double x, double y, double z) { return json_pack("[f f f]", x, y, z); }

// At share t of its way: turned about its pivot, slid, raised.
static void pose_leaf(const Export *e, const Leaf *leaf, json_t *node) {
    double open = e->door_open ? (double)e->door_open[leaf->opening] : 1, half = open * leaf->turn / 2;
    json_object_set_new(node, "translation",
                        vector(leaf->pivot.x + open * leaf->slide.x - e->origin.x,
                               leaf->pivot.y + open * leaf->slide.y - e->origin.y, open * leaf->rise));
    if (half != 0)
        json_object_set_new(node, "rotation", json_pack("[f f f f]", 0.0, 0.0, sin(half), cos(half)));
    json_object_set_new(node, "extras",
                        json_pack("{s:f s:f s:[f f] s:f}", "open", open, "turn", leaf->turn, "slide",
                                  leaf->slide.x, leaf->slide.y, "rise", leaf->rise));
}

// The turn that takes a camera's axes (looks along -z, y up) to yaw and pitch: about x by a right angle and the pitch, then
// about z.
static json_t *camera_turn(double yaw, double pitch) {
    double a = (M_PI / 2 + pitch) / 2, b = (yaw - M_PI / 2) / 2;
    return json_pack("[f f f f]", sin(a) * cos(b), sin(a) * sin(b), cos(a) * sin(b), cos(a) * cos(b));
}

static void append_child(json_t *parent, int child) {
    json_t *children = json_object_get(parent, "children");
    if (!children) json_object_set_new(parent, "children", children = json_array());
    json_array_append_new(children, json_integer(child));
}

static void add_camera(const Export *e, const Viewpoint *v, json_t *nodes, json_t *cameras) {
    double far = vec3_length(vec3_sub(e->graph->box.max, e->graph->box.min));
    double up = 2 * atan(tan(v->fov / 2) / ASPECT);
    json_array_append_new(cameras, json_pack("{s:o s:s s:{s:f s:f s:f s:f}}", "name", export_text(v->name),
                                             "type", "perspective", "perspective", "aspectRatio", ASPECT,
                                             "yfov", up, "znear", NEAREST, "zfar", far));
    Vec3 at = vec3_sub(v->eye, e->origin);
    append_child(json_array_get(nodes, 0), (int)json_array_size(nodes));
    json_array_append_new(nodes,
                          json_pack("{s:o s:i s:o s:o}", "name", export_text(v->name), "camera",
                                    (int)json_array_size(cameras) - 1, "translation",
                                    vector(at.x, at.y, at.z), "rotation", camera_turn(v->yaw, v->pitch)));
}

int export_nodes(Export *e, const ExportTree *tree, json_t *nodes, json_t *cameras) {
    const Building *b = e->graph->building;
    for (int i = 0; i < tree->count; i++) {
        const ExportNode *n = &tree->nodes[i];
        json_t *node = json_pack("{s:o}", "name", export_text(n->name));
        if (n->first_object >= 0) json_object_set_new(node, "mesh", json_integer(export_mesh(e, tree, n)));
        if (n->leaf >= 0) pose_leaf(e, &b->leaves[n->leaf], node);
        if (n->parent >= 0) append_child(json_array_get(nodes, (size_t)n->parent), i);
        json_array_append_new(nodes, node);
    }
    // (x, y, z) with z up becomes (x, z, -y).
    json_t *root = json_array_get(nodes, 0);
    json_object_set_new(root, "rotation", json_pack("[f f f f]", -TURN, 0.0, 0.0, TURN));
    json_object_set_new(root, "translation", vector(e->origin.x, e->origin.z, -e->origin.y));
    for (int i = 0; i < b->viewpoint_count; i++) add_camera(e, &b->viewpoints[i], nodes, cameras);
    return 0;
}
