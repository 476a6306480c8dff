// reconstruct.c - nodal radiosities: at each node a plane is laid through the elements around it, by least squares, and read
// where the node is.
//
// Source: M. F. Cohen & D. P. Greenberg, The Hemi-Cube, 1985, section 7: the mean of the elements around a vertex,
// extrapolated at borders. Departure: there borders are extrapolated along rows of quadrilaterals; here by a fit weighted
// with 1 / distance^2 (moving least squares; Lancaster & Salkauskas 1981), which asks nothing of the elements' shapes and
// sizes and is the mean of four equal squares. An element's radiosity is the mean over it, which a linear field has at its
// centroid: so linear fields come back as they are, also at borders and where elements of several sizes meet.
#include "radiosity/show/reconstruct.h"

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "engine/core/polygon.h"

// A node's value is a sum of its elements' with factors that sum to 1; the sum of their squares says how much noise of elements
// it has. Up to 1 it is no noisier than an element: it lies among those that meet there.
static const double AMONG = 1;
// Extrapolation may cost this much: at a corner of equal squares 2.3; 6.5 where a large square stands in the corner with far
// smaller ones behind it, whose centroids are near its own.
static const double MOST_NOISE = 8;
// Centroids nearer than this, metres squared, count no more: rounding.
static const double NEAREST = 1e-18;
// Elements smaller than this share of the mean of those around them are slivers: elements of neighbouring sizes are not, of 1 to 4.
static const double SLIVER = 0.25;
// Elements so much narrower than the widest at a node say nothing there: a strip of a centimetre behind a frame's edge, whose middle is
// next to the node, would darken a hand's breadth of what lies before the edge.
static const double NARROW = 0.15;
// The rest laid on top of the first fit is at most this share of it: around lamps it would be dark rings.
static const double MOST_REST = 0.2;
// A unit that has less than this share of the mean value is covered: in cracks light may be the rounding of what was given and taken back.
static const double COVERED = 1e-9;
// Values between those of patches may be extrapolated to these shares of the least and the greatest of them.
static const double LEAST_OUTSIDE = 0.3, MOST_OUTSIDE = 1.5;
// Spread of centroids along an axis, as a share of their squared distances, below which they lie on a line.
static const double NO_SPREAD = 1e-6;

// An element or a patch seen from a node, in its tangent plane.
typedef struct Around {
    int unit;
    double x, y, weight;
    double width;  // metres; of a patch 1
    double factor;
} Around;

typedef struct Fit {
    const Mesh *mesh;
    const Nodes *nodes;
    const RadSolution *solution;
    Vec3 *centroid;      // [element_count] NULL: as the mesh has them
    double (*light)[3];  // [element_count] W/m^2, there
    bool *sliver;        // [element_count]
    const bool *wanted;  // [nodes->count] nodes to be found; NULL: all
    bool *
        covered;  // [unit] hardly any light reaches it: it says nothing of the light beside it; NULL: none is
    bool of_patches;  // units are patches, not elements: `centroid` and `stamp` are theirs
    int *stamp, now;  // [element_count] the collection that last took the unit
    Vec3 x, y;        // of the node's plane
    Around *around;
    int count, capacity;
    Arena scratch;
} Fit;

// ---- pictures

static double (*make_even(const Mesh *mesh, double (*light)[3], Arena *arena))[3] {
    if (!light) return NULL;
    double(*out)[3] = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *out);
    for (int e = 0; e < mesh->element_count; e++) {
        double even[3];
        mesh_even(mesh, e, even);
        for (int c = 0; c < 3; c++) out[e][c] = even[c] * light[e][c];
    }
    return out;
}

RadSolution reconstruct_even(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    RadSolution out = *solution;
    if (!mesh->reflectance) return out;
    out.radiosity = make_even(mesh, solution->radiosity, arena);
    out.direct = make_even(mesh, solution->direct, arena);
    out.daylight = make_even(mesh, solution->daylight, arena);
    out.sun = make_even(mesh, solution->sun, arena);
    return out;
}

// ---- slivers

// Sums over an element and all that meet it smoothly, each once: their sums, of place and light by area.
static void gather_around(Fit *fit, int element, Vec3 *moment, double power[3], double *area, int *count) {
    const Mesh *mesh = fit->mesh;
    const Element *own = &mesh->elements[element];
    fit->now++;
    for (int c = own->first_corner; c < own->first_corner + own->corner_count; c++) {
        int node = fit->nodes->of_corner[c];
        for (int i = fit->nodes->first[node]; i < fit->nodes->first[node + 1]; i++) {
            int e = fit->nodes->element[i];
            if (fit->stamp[e] == fit->now) continue;
            fit->stamp[e] = fit->now;
            double a = mesh->elements[e].area;
            *moment = vec3_add(*moment, vec3_scale(element_centroid(mesh, e), a));
            for (int k = 0; k < 3; k++) power[k] += a * fit->solution->radiosity[e][k];
            *area += a;
            ++*count;
        }
    }
}

// Slivers beside objects on a surface are so small that few samples meet them, and what those say is noise. A sliver tells
// the light of all around it, at the middle of their area, so that linear fields stay as they are.
static void find_light(Fit *fit, const bool *asked) {
    for (int e = 0; e < fit->mesh->element_count; e++) {
        if (asked && !asked[e]) continue;
        double power[3] = {0, 0, 0}, area = 0;
        Vec3 moment = {0, 0, 0};
        int count = 0;
        fit->centroid[e] = element_centroid(fit->mesh, e);
        memcpy(fit->light[e], fit->solution->radiosity[e], sizeof *fit->light);
        gather_around(fit, e, &moment, power, &area, &count);
        if (fit->mesh->elements[e].area * count >= SLIVER * area) continue;
        fit->sliver[e] = true;
        fit->centroid[e] = vec3_scale(moment, 1 / area);
        for (int c = 0; c < 3; c++) fit->light[e][c] = power[c] / area;
    }
}

// ---- which elements, or patches

static Vec3 unit_centre(const Fit *fit, int unit) {
    if (fit->centroid) return fit->centroid[unit];
    return fit->of_patches ? fit->mesh->patches[unit].centre : element_centroid(fit->mesh, unit);
}

// The area of an element over its length.
static double width_of(const Mesh *mesh, int element) {
    const Element *e = &mesh->elements[element];
    Vec3 middle = element_centroid(mesh, element);
    double reach = 0;
    for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
        reach = fmax(reach, vec3_length(vec3_sub(mesh->vertices[mesh->corners[c]], middle)));
    return reach > 0 ? e->area / (2 * reach) : 0;
}

static void take_unit(Fit *fit, int node, int element) {
    const Nodes *nodes = fit->nodes;
    const Element *e = &fit->mesh->elements[element];
    Vec3 n = nodes->normal[node];
    int unit = fit->of_patches ? e->patch : element;
    if (fit->stamp[unit] == fit->now || (fit->covered && fit->covered[unit])) return;
    if (vec3_dot(fit->mesh->faces[e->face].plane.n, n) < NODES_CURVED) return;
    fit->stamp[unit] = fit->now;
    Vec3 p = vec3_sub(unit_centre(fit, unit), fit->mesh->vertices[nodes->vertex[node]]);
    double square = vec3_dot(p, p);
    *ARENA_PUSH(&fit->scratch, fit->around, fit->count, fit->capacity) =
        (Around){.unit = unit,
                 .x = vec3_dot(fit->x, p),
                 .y = vec3_dot(fit->y, p),
                 .weight = 1 / fmax(square, NEAREST),
                 .width = fit->of_patches ? 1 : width_of(fit->mesh, unit)};
}

static void take_around(Fit *fit, int node, int element) {
    const Nodes *nodes = fit->nodes;
    const Element *e = &fit->mesh->elements[element];
    for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++) {
        int other = nodes->of_corner[c];
        for (int i = nodes->first[other]; i < nodes->first[other + 1]; i++)
            take_unit(fit, node, nodes->element[i]);
    }
}

// `own`: the first so many meet at the node.
static void leave_narrow(Fit *fit, int own) {
    double widest = 0;
    int kept = 0;
    for (int i = 0; i < own; i++) widest = fmax(widest, fit->around[i].width);
    for (int i = 0; i < fit->count; i++)
        if (fit->around[i].width >= NARROW * widest) fit->around[kept++] = fit->around[i];
    fit->count = kept;
}

// Those that meet at the node; with `wide`, those that meet at any of their nodes.
static void collect(Fit *fit, int node, bool wide) {
    const Nodes *nodes = fit->nodes;
    const Mesh *mesh = fit->mesh;
    fit->count = 0;
    fit->now++;
    for (int i = nodes->first[node]; i < nodes->first[node + 1]; i++) take_unit(fit, node, nodes->element[i]);
    int own = fit->count;
    for (int k = 0; wide && k < own; k++) {
        int unit = fit->around[k].unit;
        const Patch *patch = fit->of_patches ? &mesh->patches[unit] : NULL;
        for (int i = 0; i < (patch ? patch->element_count : 1); i++)
            take_around(fit, node, patch ? patch->first_element + i : unit);
    }
    leave_narrow(fit, own);
}

// ---- the fit

typedef struct Axis {
    double x, y, spread;
} Axis;

// The axes of a symmetric matrix (xx, xy; xy, yy), the greater spread first.
static void axes_of(double xx, double xy, double yy, Axis axis[2]) {
    double half = (xx - yy) / 2, root = sqrt(half * half + xy * xy), angle = atan2(xy, half) / 2;
    axis[0] = (Axis){cos(angle), sin(angle), (xx + yy) / 2 + root};
    axis[1] = (Axis){-axis[0].y, axis[0].x, (xx + yy) / 2 - root};
}

// The factors of a fit that slopes along so many axes, at the node; returns the sum of their squares, INFINITY where elements lie
// too much in line to tell.
static double lay(Fit *fit, int axes) {
    double weight = 0, mx = 0, my = 0, xx = 0, xy = 0, yy = 0, far = 0, noise = 0;
    for (int i = 0; i < fit->count; i++) {
        const Around *a = &fit->around[i];
        weight += a->weight;
        mx += a->weight * a->x;
        my += a->weight * a->y;
        far += a->weight * (a->x * a->x + a->y * a->y);
    }
    mx /= weight;
    my /= weight;
    for (int i = 0; i < fit->count; i++) {
        const Around *a = &fit->around[i];
        xx += a->weight * (a->x - mx) * (a->x - mx);
        xy += a->weight * (a->x - mx) * (a->y - my);
        yy += a->weight * (a->y - my) * (a->y - my);
    }
    Axis axis[2];
    double slope[2] = {0, 0};
    axes_of(xx, xy, yy, axis);
    for (int k = 0; k < axes; k++) {
        if (!(axis[k].spread > NO_SPREAD * far)) return INFINITY;
        slope[k] = -(mx * axis[k].x + my * axis[k].y) / axis[k].spread;
    }
    for (int i = 0; i < fit->count; i++) {
        Around *a = &fit->around[i];
        a->factor = 1 / weight;
        for (int k = 0; k < axes; k++)
            a->factor += slope[k] * ((a->x - mx) * axis[k].x + (a->y - my) * axis[k].y);
        a->factor *= a->weight;
        noise += a->factor * a->factor;
    }
    return noise;
}

// Among the elements that meet at the node where they surround it; else, at borders, with those around them; along one axis
// where there is but one row of elements; and where none of these can be laid, their mean.
static void find_factors(Fit *fit, int node) {
    static const struct {
        bool wide;
        int axes;
        double noise;
    } WAYS[] = {{false, 2, AMONG}, {true, 2, MOST_NOISE}, {false, 1, AMONG}, {true, 1, MOST_NOISE}};
    view_axes(fit->nodes->normal[node], &fit->x, &fit->y);
    for (size_t i = 0; i < sizeof WAYS / sizeof *WAYS; i++) {
        collect(fit, node, WAYS[i].wide);
        if (fit->count > 0 && lay(fit, WAYS[i].axes) <= WAYS[i].noise) return;
    }
    collect(fit, node, false);
    if (fit->count > 0) lay(fit, 0);
}

// Adds the fits of nodes to the elements' light.
static void add_fits(Fit *fit, const bool *asked, double (*out)[3]) {
    for (int n = 0; n < fit->nodes->count; n++) {
        if (asked && !asked[n]) continue;
        find_factors(fit, n);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < fit->count; i++)
                out[n][c] += fit->around[i].factor * fit->light[fit->around[i].unit][c];
    }
}

// The mean over an element of the light that its corners show.
static void shown_mean(const Fit *fit, int element, double (*node)[3], Arena *scratch, double out[3]) {
    const Mesh *mesh = fit->mesh;
    const Element *e = &mesh->elements[element];
    Vec3 *v = ARENA_ARRAY(scratch, Vec3, e->corner_count);
    int *triangle = ARENA_ARRAY(scratch, int, 3 * e->corner_count);
    double all = 0;
    for (int i = 0; i < e->corner_count; i++) v[i] = mesh->vertices[mesh->corners[e->first_corner + i]];
    polygon_triangulate(v, e->corner_count, triangle);
    for (int t = 0; t < e->corner_count - 2; t++) {
        const int *k = triangle + 3 * t;
        double area = polygon_area((Vec3[]){v[k[0]], v[k[1]], v[k[2]]}, 3);
        all += area;
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < 3; c++)
                out[c] += area / 3 * node[fit->nodes->of_corner[e->first_corner + k[i]]][c];
    }
    for (int c = 0; c < 3; c++) out[c] = all > 0 ? out[c] / all : 0;
}

// Light of elements that their corners do not show: planes cut off the peaks of bent light. Slivers have nothing of their own.
static void leave_the_rest(Fit *fit, const bool *asked, double (*node)[3]) {
    Arena scratch = {0};
    for (int e = 0; e < fit->mesh->element_count; e++) {
        if (asked && !asked[e]) continue;
        double shown[3] = {0, 0, 0};
        arena_reset(&scratch);
        shown_mean(fit, e, node, &scratch, shown);
        for (int c = 0; c < 3; c++)
            fit->light[e][c] = fit->sliver[e] ? 0 : fit->solution->radiosity[e][c] - shown[c];
    }
    arena_free(&scratch);
}

// The elements that the fits at nodes may ask: those that meet at the nodes of those that meet there. NULL where all are asked.
static bool *elements_about(const Fit *fit, const bool *node, Arena *arena) {
    if (!node) return NULL;
    const Mesh *mesh = fit->mesh;
    const Nodes *nodes = fit->nodes;
    bool *out = ARENA_ARRAY(arena, bool, mesh->element_count + 1);
    for (int n = 0; n < nodes->count; n++)
        for (int i = nodes->first[n]; i < nodes->first[n + 1] && node[n]; i++) {
            const Element *e = &mesh->elements[nodes->element[i]];
            for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
                for (int k = nodes->first[nodes->of_corner[c]]; k < nodes->first[nodes->of_corner[c] + 1];
                     k++)
                    out[nodes->element[k]] = true;
        }
    return out;
}

static bool *nodes_about(const Fit *fit, const bool *element, Arena *arena) {
    if (!element) return NULL;
    bool *out = ARENA_ARRAY(arena, bool, fit->nodes->count + 1);
    for (int e = 0; e < fit->mesh->element_count; e++) {
        const Element *of = &fit->mesh->elements[e];
        for (int c = of->first_corner; c < of->first_corner + of->corner_count && element[e]; c++)
            out[fit->nodes->of_corner[c]] = true;
    }
    return out;
}

void reconstruct_nodes(const Mesh *mesh, const Nodes *nodes, const RadSolution *solution, const bool *wanted,
                       double (*out)[3]) {
    Fit fit = {.mesh = mesh, .nodes = nodes};
    RadSolution even = reconstruct_even(mesh, solution, &fit.scratch);
    fit.solution = &even;
    fit.centroid = ARENA_ARRAY(&fit.scratch, Vec3, mesh->element_count);
    fit.stamp = ARENA_ARRAY(&fit.scratch, int, mesh->element_count);
    fit.sliver = ARENA_ARRAY(&fit.scratch, bool, mesh->element_count);
    fit.light = arena_alloc(&fit.scratch, (size_t)mesh->element_count, sizeof *fit.light);
    // Fits at the nodes wanted ask elements for their rests, which ask the fits at their own nodes, which ask elements for their light.
    bool *rests = elements_about(&fit, wanted, &fit.scratch),
         *fitted = nodes_about(&fit, rests, &fit.scratch),
         *light = elements_about(&fit, fitted, &fit.scratch);
    find_light(&fit, light);
    memset(out, 0, (size_t)nodes->count * sizeof *out);
    double(*rest)[3] = arena_alloc(&fit.scratch, (size_t)nodes->count, sizeof *rest);
    add_fits(&fit, fitted, out);
    leave_the_rest(&fit, rests, out);
    add_fits(&fit, wanted, rest);
    for (int n = 0; n < nodes->count; n++) {
        for (int c = 0; c < 3; c++) {
            double first = fmax(out[n][c], 0), most = MOST_REST * first;
            out[n][c] = first + fmin(fmax(rest[n][c], -most), most);
        }
    }
    arena_free(&fit.scratch);
}

void reconstruct_face(const Mesh *mesh, int f, const RadSolution *solution, double out[3]) {
    const Face *face = &mesh->faces[f];
    double area = 0;
    out[0] = out[1] = out[2] = 0;
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        for (int c = 0; c < 3; c++) out[c] += mesh->elements[e].area * solution->radiosity[e][c];
        area += mesh->elements[e].area;
    }
    for (int c = 0; c < 3; c++) out[c] /= area;
}

VertexLight reconstruct_light(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    VertexLight out = {.corner = arena_alloc(arena, (size_t)mesh->corner_count, sizeof *out.corner),
                       .face = arena_alloc(arena, (size_t)mesh->face_count, sizeof *out.face)};
    Arena scratch = {0};
    Nodes nodes = nodes_of(mesh, &scratch);
    double(*value)[3] = solution->node;
    CORE_ASSERT(!value || solution->node_count == nodes.count);
    if (!value) {
        value = arena_alloc(&scratch, (size_t)nodes.count, sizeof *value);
        reconstruct_nodes(mesh, &nodes, solution, NULL, value);
    }
    for (int i = 0; i < mesh->corner_count; i++)
        memcpy(out.corner[i], value[nodes.of_corner[i]], sizeof *value);
    RadSolution even = reconstruct_even(mesh, solution, &scratch);
    for (int f = 0; f < mesh->face_count; f++) reconstruct_face(mesh, f, &even, out.face[f]);
    arena_free(&scratch);
    return out;
}

// ---- light between vertices: linear over the triangles that elements are drawn as.

// Shares of a triangle's corners at a point of its plane; below 0 outside.
static void shares_at(const Vec3 v[3], Vec3 n, Vec3 p, double share[3]) {
    double twice = vec3_dot(n, vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])));
    for (int k = 0; k < 3; k++) {
        Vec3 a = vec3_sub(v[(k + 1) % 3], p), b = vec3_sub(v[(k + 2) % 3], p);
        share[k] = twice > 0 ? vec3_dot(n, vec3_cross(a, b)) / twice : -INFINITY;
    }
}

static double least3(const double v[3]) { return fmin(v[0], fmin(v[1], v[2])); }

// Back into the triangle.
static void clamp_shares(double share[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += share[k] = fmax(share[k], 0);
    for (int k = 0; k < 3; k++) share[k] /= sum;
}

static void triangulate(const Mesh *mesh, const Element *e, Vec3 *v, int *triangle) {
    for (int i = 0; i < e->corner_count; i++) v[i] = mesh->vertices[mesh->corners[e->first_corner + i]];
    polygon_triangulate(v, e->corner_count, triangle);
}

int *reconstruct_triangles(const Mesh *mesh, Arena *arena) {
    int *triangle = ARENA_ARRAY(arena, int, 3 * mesh->corner_count + 1), most = 0;
    Arena scratch = {0};
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh->elements[e].corner_count > most) most = mesh->elements[e].corner_count;
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, most + 1);
    for (int e = 0; e < mesh->element_count; e++)
        triangulate(mesh, &mesh->elements[e], v, triangle + 3 * mesh->elements[e].first_corner);
    arena_free(&scratch);
    return triangle;
}

// Corners that elements hardly ever have more of.
enum { FEW = 64 };

static void add_shares(const VertexLight *light, const Element *e, const int corner[3], const double share[3],
                       double out[3]) {
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < 3; k++) out[c] += share[k] * light->corner[e->first_corner + corner[k]][c];
    }
}

// The corners of the triangle in which the point is, or to which it is nearest.
static void find_shares(const Mesh *mesh, const Element *e, const int *triangle, Vec3 point, int best[3],
                        double share[3]) {
    const int *corners = mesh->corners + e->first_corner;
    Vec3 n = mesh->faces[e->face].plane.n;
    double inside = -INFINITY;
    for (int t = 0; t < e->corner_count - 2; t++) {
        const int *k = triangle + 3 * t;
        const Vec3 corner[3] = {mesh->vertices[corners[k[0]]], mesh->vertices[corners[k[1]]],
                                mesh->vertices[corners[k[2]]]};
        double s[3];
        shares_at(corner, n, point, s);
        if (!(least3(s) > inside)) continue;
        inside = least3(s);
        memcpy(share, s, sizeof s);
        memcpy(best, k, 3 * sizeof *best);
    }
    clamp_shares(share);
}

void reconstruct_shares(const Mesh *mesh, const int *triangle, int element, Vec3 point, int corner[3],
                        double share[3]) {
    const Element *e = &mesh->elements[element];
    int best[3] = {0, 1, 2};
    share[0] = 1;
    share[1] = share[2] = 0;
    find_shares(mesh, e, triangle + 3 * e->first_corner, point, best, share);
    for (int i = 0; i < 3; i++) corner[i] = e->first_corner + best[i];
}

void reconstruct_in(const Mesh *mesh, const VertexLight *light, int element, Vec3 point, double out[3]) {
    const Element *e = &mesh->elements[element];
    Arena scratch = {0};
    Vec3 few[FEW], *v = few;
    int few_triangles[3 * FEW], *triangle = few_triangles, best[3] = {0, 1, 2};
    double share[3] = {1, 0, 0};
    if (light->triangle) {
        triangle = light->triangle + 3 * e->first_corner;
    } else {
        if (e->corner_count > FEW) {
            v = ARENA_ARRAY(&scratch, Vec3, e->corner_count);
            triangle = ARENA_ARRAY(&scratch, int, 3 * e->corner_count);
        }
        triangulate(mesh, e, v, triangle);
    }
    find_shares(mesh, e, triangle, point, best, share);
    arena_free(&scratch);
    add_shares(light, e, best, share, out);
}

void reconstruct_at(const Mesh *mesh, const VertexLight *light, int face, Vec3 point, double out[3]) {
    reconstruct_in(mesh, light, mesh_element_at(mesh, face, point), point, out);
}

// ---- values at the centres of patches or elements

// The share of a unit's value in that of a node.
typedef struct FitFactor {
    int unit;
    double factor;
} FitFactor;

// The factors at a node.
typedef struct NodeFit {
    int count, capacity;
    FitFactor *of;
    bool there;
} NodeFit;

// Where the value of a unit is held against the light between nodes.
typedef struct UnitPlace {
    int node[3];
    double share[3];
    bool there;
} UnitPlace;

// The elements of a unit: [first, end).
static void unit_elements(const Fit *fit, int unit, int *first, int *end) {
    *first = fit->of_patches ? fit->mesh->patches[unit].first_element : unit;
    *end = *first + (fit->of_patches ? fit->mesh->patches[unit].element_count : 1);
}

static int unit_of(const Fit *fit, int element) {
    return fit->of_patches ? fit->mesh->elements[element].patch : element;
}

static void add_nodes(const Fit *fit, int unit, Marks *to) {
    int first, end;
    unit_elements(fit, unit, &first, &end);
    const Element *last = &fit->mesh->elements[end - 1];
    for (int c = fit->mesh->elements[first].first_corner; c < last->first_corner + last->corner_count; c++)
        marks_add(to, fit->nodes->of_corner[c]);
}

// Adds the nodes that may have a share of a unit: its own, and those of units that meet there.
static void add_nodes_around(const Fit *fit, int unit, Marks *to) {
    const Mesh *mesh = fit->mesh;
    const Nodes *nodes = fit->nodes;
    int first, end;
    unit_elements(fit, unit, &first, &end);
    const Element *last = &mesh->elements[end - 1];
    for (int c = mesh->elements[first].first_corner; c < last->first_corner + last->corner_count; c++) {
        int at = nodes->of_corner[c];
        for (int i = nodes->first[at]; i < nodes->first[at + 1]; i++)
            add_nodes(fit, unit_of(fit, nodes->element[i]), to);
    }
}

// A unit that has come to light, or is covered now, counts otherwise for the nodes of its neighbours: they forget their factors.
static void note_covered(Fit *fit, int unit, const double value[3], ValueFits *kept, Marks *forget) {
    bool covered = !(rgb_sum(value) > kept->least);
    if (covered == kept->covered[unit]) return;
    kept->covered[unit] = covered;
    add_nodes_around(fit, unit, forget);
}

static void forget_factors(ValueFits *kept, const Marks *nodes) {
    for (int i = 0; i < nodes->count; i++) kept->node[nodes->of[i]].there = false;
}

// Forgets what is no longer right of what the call before has kept.
static void use_kept(Fit *fit, int units, double (*value)[3], ValueFits *kept) {
    const int nodes = fit->nodes->count;
    double sum = 0;
    for (int u = 0; u < units; u++) sum += fmax(rgb_sum(value[u]), 0);
    kept->least = COVERED * sum / fmax(units, 1);
    if (kept->node) {
        Marks forget = marks_new(nodes, &fit->scratch);
        for (int u = 0; u < units; u++) note_covered(fit, u, value[u], kept, &forget);
        forget_factors(kept, &forget);
        return;
    }
    kept->node = ARENA_ARRAY(kept->arena, NodeFit, nodes + 1);
    kept->unit = ARENA_ARRAY(kept->arena, UnitPlace, units + 1);
    kept->covered = ARENA_ARRAY(kept->arena, bool, units + 1);
    kept->fitted = arena_alloc(kept->arena, (size_t)nodes + 1, sizeof *kept->fitted);
    kept->rest = arena_alloc(kept->arena, (size_t)units + 1, sizeof *kept->rest);
    kept->nodes = marks_new(nodes, kept->arena);
    kept->units = marks_new(units, kept->arena);
    for (int u = 0; u < units; u++) kept->covered[u] = !(rgb_sum(value[u]) > kept->least);
}

// The factors at a node, into `out`, whose memory is the arena's.
static void take_factors(Fit *fit, int node, Arena *arena, NodeFit *out) {
    if (out->there) return;
    find_factors(fit, node);
    if (fit->count > out->capacity) {
        out->of = ARENA_ARRAY(arena, FitFactor, fit->count);
        out->capacity = fit->count;
    }
    out->count = fit->count;
    out->there = true;
    for (int i = 0; i < fit->count; i++) out->of[i] = (FitFactor){fit->around[i].unit, fit->around[i].factor};
}

// The fit at a node to the values, between LEAST_OUTSIDE and MOST_OUTSIDE of those around.
static void fit_value(const NodeFit *at, double (*value)[3], double out[3]) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {0};
    for (int c = 0; c < 3; c++) out[c] = 0;
    if (at->count == 0) return;
    for (int i = 0; i < at->count; i++) {
        const double *from = value[at->of[i].unit];
        for (int c = 0; c < 3; c++) {
            out[c] += at->of[i].factor * from[c];
            low[c] = fmin(low[c], from[c]);
            high[c] = fmax(high[c], from[c]);
        }
    }
    for (int c = 0; c < 3; c++) out[c] = fmin(fmax(out[c], LEAST_OUTSIDE * low[c]), MOST_OUTSIDE * high[c]);
}

static void place_unit(const Fit *fit, int unit, Arena *scratch, UnitPlace *out) {
    const Mesh *mesh = fit->mesh;
    Vec3 centre = unit_centre(fit, unit);
    int face = fit->of_patches ? mesh->patches[unit].face : mesh->elements[unit].face;
    int in = fit->of_patches ? mesh_element_at(mesh, face, centre) : unit, best[3] = {0, 1, 2};
    const Element *e = &mesh->elements[in];
    Vec3 *v = ARENA_ARRAY(scratch, Vec3, e->corner_count);
    int *triangle = ARENA_ARRAY(scratch, int, 3 * e->corner_count);
    *out = (UnitPlace){.share = {1, 0, 0}, .there = true};
    triangulate(mesh, e, v, triangle);
    find_shares(mesh, e, triangle, centre, best, out->share);
    for (int k = 0; k < 3; k++) out->node[k] = fit->nodes->of_corner[e->first_corner + best[k]];
}

// Are all nodes of an element wanted?
static bool all_wanted(const Fit *fit, int element) {
    const Element *e = &fit->mesh->elements[element];
    int c = e->first_corner, end = c + e->corner_count;
    while (c < end && fit->wanted[fit->nodes->of_corner[c]]) c++;
    return c == end;
}

// How far a value is above the linear light between the nodes, where all of these are wanted.
static void rest_of_value(const Fit *fit, double (*node)[3], int unit, const double value[3], Arena *scratch,
                          UnitPlace *place, double out[3]) {
    if (fit->wanted && !all_wanted(fit, unit)) return;
    if (!place->there) place_unit(fit, unit, scratch, place);
    for (int c = 0; c < 3; c++) {
        double shown = 0;
        for (int k = 0; k < 3; k++) shown += place->share[k] * node[place->node[k]][c];
        out[c] = value[c] - shown;
    }
}

// Adds the mean of the rests of the elements around a node to its fit.
static void add_rests(const Fit *fit, const bool *covered, double (*value)[3], double (*rest)[3], int node,
                      const double fitted[3], double out[3]) {
    double more[3] = {0, 0, 0};
    int count = 0;
    for (int i = fit->nodes->first[node]; i < fit->nodes->first[node + 1]; i++) {
        int u = unit_of(fit, fit->nodes->element[i]);
        if (covered[u]) continue;
        count++;
        for (int c = 0; c < 3; c++)
            more[c] += fmin(fmax(rest[u][c], -MOST_REST * value[u][c]), MOST_REST * value[u][c]);
    }
    for (int c = 0; c < 3; c++) out[c] = fmax(fitted[c] + (count ? more[c] / count : 0), 0);
}

// On several threads, each with a fit of its own. What outlives the call is kept by one thread, in its arena.
enum { FITS_A_GROUP = 1024 };

typedef struct Fitting {
    Fit *fit;        // [threads]
    NodeFit *one;    // [threads] of the node at hand, where nothing outlives the call
    Arena *scratch;  // [threads]
    int units, threads;
    bool keeps;
    ValueFits *kept;
    double (*value)[3], (*out)[3];
} Fitting;

static void fit_nodes(void *context, int group, int thread) {
    const Fitting *f = context;
    Fit *fit = &f->fit[thread];
    int first = group * FITS_A_GROUP, end = first + FITS_A_GROUP;
    for (int n = first; n < end && n < fit->nodes->count; n++) {
        if (fit->wanted && !fit->wanted[n]) continue;
        NodeFit *at = f->keeps ? &f->kept->node[n] : &f->one[thread];
        if (!f->keeps) at->there = false;
        take_factors(fit, n, f->keeps ? f->kept->arena : &fit->scratch, at);
        fit_value(at, f->value, f->kept->fitted[n]);
    }
}

static void find_rests(void *context, int group, int thread) {
    const Fitting *f = context;
    Arena *scratch = &f->scratch[thread];
    int first = group * FITS_A_GROUP, end = first + FITS_A_GROUP;
    for (int u = first; u < end && u < f->units; u++) {
        arena_reset(scratch);
        rest_of_value(&f->fit[thread], f->kept->fitted, u, f->value[u], scratch, &f->kept->unit[u],
                      f->kept->rest[u]);
    }
}

static void finish_nodes(void *context, int group, int thread) {
    const Fitting *f = context;
    const Fit *fit = &f->fit[thread];
    int first = group * FITS_A_GROUP, end = first + FITS_A_GROUP;
    for (int n = first; n < end && n < fit->nodes->count; n++)
        if (!fit->wanted || fit->wanted[n])
            add_rests(fit, f->kept->covered, f->value, f->kept->rest, n, f->kept->fitted[n], f->out[n]);
}

static void each_group_of(Fitting *f, int count, void (*body)(void *context, int group, int thread)) {
    parallel_for(f->threads, (count + FITS_A_GROUP - 1) / FITS_A_GROUP, body, f);
}

void reconstruct_values(const Mesh *mesh, const Nodes *nodes, bool of_patches, double (*value)[3],
                        const bool *wanted, double (*out)[3], double (*rest)[3], ValueFits *kept) {
    Arena arena = {0};
    ValueFits own = {.arena = &arena};
    int units = of_patches ? mesh->patch_count : mesh->element_count,
        threads = kept ? 1 : parallel_threads(mesh->options.threads);
    Fitting f = {.fit = ARENA_ARRAY(&arena, Fit, threads),
                 .one = ARENA_ARRAY(&arena, NodeFit, threads),
                 .scratch = ARENA_ARRAY(&arena, Arena, threads),
                 .units = units,
                 .threads = threads,
                 .keeps = kept != NULL,
                 .kept = kept ? kept : &own,
                 .value = value,
                 .out = out};
    Vec3 *centroid = ARENA_ARRAY(&arena, Vec3, units + 1);
    for (int u = 0; u < units; u++)
        centroid[u] = of_patches ? mesh->patches[u].centre : element_centroid(mesh, u);
    for (int t = 0; t < threads; t++) {
        Fit *fit = &f.fit[t];
        *fit = (Fit){.mesh = mesh, .nodes = nodes, .of_patches = of_patches, .wanted = wanted};
        fit->centroid = centroid;
        fit->stamp = ARENA_ARRAY(&fit->scratch, int, units + 1);
        if (t == 0) use_kept(fit, units, value, f.kept);
        fit->covered = f.kept->covered;
    }
    each_group_of(&f, nodes->count, fit_nodes);
    each_group_of(&f, units, find_rests);
    each_group_of(&f, nodes->count, finish_nodes);
    if (rest) memcpy(rest, f.kept->rest, (size_t)units * sizeof *rest);
    for (int t = 0; t < threads; t++) {
        arena_free(&f.fit[t].scratch);
        arena_free(&f.scratch[t]);
    }
    arena_free(&arena);
}

void reconstruct_values_again(const Mesh *mesh, const Nodes *nodes, bool of_patches, double (*value)[3],
                              const bool *wanted, const Marks *changed, double (*out)[3], ValueFits *kept) {
    Fit fit = {
        .mesh = mesh, .nodes = nodes, .of_patches = of_patches, .wanted = wanted, .covered = kept->covered};
    Arena scratch = {0};
    int units = of_patches ? mesh->patch_count : mesh->element_count;
    Marks *found = &kept->nodes, *rests = &kept->units;
    fit.stamp = ARENA_ARRAY(&fit.scratch, int, units + 1);
    marks_clear(found);
    marks_clear(rests);
    for (int i = 0; i < changed->count; i++)
        note_covered(&fit, changed->of[i], value[changed->of[i]], kept, found);
    forget_factors(kept, found);
    for (int i = 0; i < changed->count; i++) {
        add_nodes_around(&fit, changed->of[i], found);
        marks_add(rests, changed->of[i]);
    }
    int fitted = found->count;
    for (int i = 0; i < fitted; i++) {
        int n = found->of[i];
        if (wanted && !wanted[n]) continue;
        take_factors(&fit, n, kept->arena, &kept->node[n]);
        fit_value(&kept->node[n], value, kept->fitted[n]);
        for (int k = nodes->first[n]; k < nodes->first[n + 1]; k++)
            marks_add(rests, unit_of(&fit, nodes->element[k]));
    }
    for (int i = 0; i < rests->count; i++) {
        int u = rests->of[i];
        arena_reset(&scratch);
        rest_of_value(&fit, kept->fitted, u, value[u], &scratch, &kept->unit[u], kept->rest[u]);
        add_nodes(&fit, u, found);
    }
    for (int i = 0; i < found->count; i++) {
        int n = found->of[i];
        if (!wanted || wanted[n])
            add_rests(&fit, kept->covered, value, kept->rest, n, kept->fitted[n], out[n]);
    }
    arena_free(&scratch);
    arena_free(&fit.scratch);
}
