// still_light.c - radiosity split in two: light straight from lamps is found anew for each point, so that shadows are sharp; light that
// came by way of other surfaces is smooth, and is looked up where it was baked (Shirley 1990, A Ray Tracing Method for Illumination
// Calculation in Diffuse-Specular Scenes).
#include "engine/stills/still_light.h"

#include <pthread.h>
#include <stdatomic.h>

#include "engine/lit/false_colour.h"
#include "engine/scene/light_level.h"
#include "engine/shade/walk_shade.h"
#include "radiosity/factors/lamp_spread.h"
#include "radiosity/show/gather.h"

// A place on a surface, to which the light of lamps is asked for.
typedef struct StillPlace {
    Vec3 point, normal;
    int element;  // the element of the mesh on or near which it lies
    bool front;   // is it on the element's front?
} StillPlace;

// ---- the light that lamps would send to a place if nothing stood between is known in closed form (Heitz, Hill & McGuire 2018,
// Combining Analytic Direct Illumination and Stochastic Shadows). For each element the share of each lamp that is seen is roughly known:
// that share of the light is taken, and shadow rays correct its error, each towards a point of a lamp chosen by the size that the error
// may have (a control variate: Kalos & Whitlock 1986). Noise arises only where something hides a part of a lamp, however many lamps there
// are.
//
// The share of a place's light that would meet a lamp: Lambert 1760 for polygons; Snyder 1996, Area Light Sources for Real-Time Graphics,
// for balls. Points of lamps are drawn by the light that they send (Talbot, Cline & Egbert 2005, Importance Resampling).

// The probability with which an element asks for the light of lamps that its looks did not see.
static const double ONCE_IN_A_WHILE = 0.25;
// An element's few looks may have missed a thing that hides a lamp, or a gap: the doubt about a lamp's light is never less than this.
static const double LEAST_DOUBT = 0.15;
// Looks from an element to a group of lamps: two for each sample of a pixel, within bounds.
enum { LEAST_LOOKS = 16, MOST_LOOKS = 128 };
// Shadow rays end this far before a lamp, metres; before a lamp made of facets, farther by twice the facets' tolerance.
static const double BEFORE = 1e-5;

typedef struct Lamp {
    int first_corner, corner_count;  // 0: a ball
    Vec3 centre, normal;
    Vec3 four[4];         // of a quadrilateral: the points of Gauss's rule
    double area, radius;  // radius of a polygon: of a ball around all of it
    double before;
    double exitance[3], luminous;
    const LampSpread *spread;  // NULL: by Lambert's cosine
    int cell;                  // the cell it shines into, -1: unknown
    int group;                 // the lamps of one object: they are seen together or not at all
} Lamp;

// A lamp that a side of an element may see.
typedef struct Candidate {
    int lamp;
    float seen;  // about this share of it is seen, 0 .. 1
} Candidate;

// The lamps that the looks from the side of the element saw come first.
typedef struct Candidates {
    int seen_count, count;
    Candidate lamp[];
} Candidates;

struct StillLamps {
    const StillScene *scene;
    Lamp *lamps;
    Vec3 *corners;
    const StabForest *forest;
    _Atomic(Candidates *)
        *of_element;  // [2 * element_count] for the front and back of each, once they were asked for
    pthread_mutex_t lock;
    Arena found;       // memory of the candidates, guarded by the lock
    int *group_first;  // [group_count + 1] in `lamps`
    int count, group_count;
    int looks;  // rays from an element to the lamps of an object, to estimate the share it sees
};

// A place to which light is asked for, and its axes.
typedef struct LampFrame {
    Vec3 x, y, n, point;
} LampFrame;

static inline double lamp_fraction(double a) { return a - floor(a); }

// The next point of the sequence.
static void lamp_numbers_next(StillNumbers *numbers, double u[3]) {
    // Powers of 1 / 1.2207440846, the root of x^4 = x + 1.
    static const double STEP[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int i = 0; i < 3; i++) u[i] = lamp_fraction(numbers->shift[i] + STEP[i] * numbers->next);
    numbers->next++;
}

static bool is_ball(const CurvedShape *shape) {
    if (shape->kind != CURVED_SPHERE) return false;
    double r = vec3_length(shape->frame.axis[0]);
    for (int a = 1; a < 3; a++)
        if (fabs(vec3_length(shape->frame.axis[a]) - r) > 1e-9 * r) return false;
    return true;
}

// The exactly drawn shape that the face is a part of; NULL: none.
static const CurvedShape *lamp_shape_of(const StillScene *scene, const Face *face) {
    const CellGraph *graph = scene->mesh->graph;
    const Building *b = graph->building;
    for (int s = 0; s < b->shape_count; s++) {
        const CurvedShape *shape = &b->shapes[s];
        if (shape->object != face->object || graph->objects[face->object].leaf >= 0) continue;
        int first = still_first_polygon(graph, shape);
        if (face->polygon >= first && face->polygon < first + shape->polygon_count) return shape;
    }
    return NULL;
}

// ---- the share of a place's light that would meet a lamp

// From farther than this many times its radius a polygon counts as a point of its area (FAR), and a quadrilateral as four points
// (MIDDLING): within 1 %.
static const double FAR = 8, MIDDLING = 2;
// Light by candela tables is found within about this share; from farther than so many radii by four points.
static const double TABLE_OFF = 0.01, TABLE_FAR = 4;
// Points drawn on a lamp; one of them is chosen by the light that it sends.
enum { POINTS = 4 };
// From farther than this many times its radius, all points of a lamp send much the same light.
static const double EVEN = 4;

// `to` is relative to the place; the horizon hides the part of the ball below it.
double still_ball_share(Vec3 normal, Vec3 to, double radius) {
    double d2 = vec3_dot(to, to), far2 = d2 / (radius * radius), cosine = vec3_dot(normal, to) / sqrt(d2);
    if (far2 <= 1) return 1;
    double above = 1 - far2 * cosine * cosine;
    if (above <= 0) return fmax(cosine, 0) / far2;
    double tangent = sqrt(far2 - 1), sine = sqrt(1 - cosine * cosine);
    double part = cosine * acos(fmin(fmax(-cosine * tangent / sine, -1), 1)) - sqrt(above) * tangent;
    return fmax((part / far2 + atan(sqrt(above) / tangent)) / M_PI, 0);
}

static double near_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f) {
    Vec3 local[ANALYTIC_CORNERS];
    for (int i = 0; i < lamp->corner_count; i++) {
        Vec3 v = vec3_sub(lamps->corners[lamp->first_corner + i], f->point);
        local[i] = vec3(vec3_dot(f->x, v), vec3_dot(f->y, v), vec3_dot(f->n, v));
    }
    if (lamp->spread) {
        SpreadSight by_table = spread_sight(lamp->spread, TABLE_OFF, f->x, f->y, f->n);
        spread_sight_add(&by_table, local, lamp->corner_count);
        return by_table.sight.share;
    }
    return analytic_point(local, lamp->corner_count);
}

// The same of a lamp by a candela table, times what the table sends this way over an even lamp.
static double table_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f) {
    Vec3 to = vec3_sub(lamp->centre, f->point);
    bool far = vec3_dot(to, to) > TABLE_FAR * TABLE_FAR * lamp->radius * lamp->radius;
    if (!far || lamp->corner_count != 4 || vec3_dot(f->n, to) <= lamp->radius)
        return near_share(lamps, lamp, f);
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        Vec3 way = vec3_sub(lamp->four[i], f->point);
        double d2 = vec3_dot(way, way), d = sqrt(d2);
        sum += spread_share(lamp->spread, vec3_scale(way, -1 / d)) * vec3_dot(f->n, way) / (d2 * d);
    }
    return lamp->area / 4 * sum;
}

// The share of the light leaving the place that would meet the lamp's front.
static double lamp_share(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f) {
    Vec3 to = vec3_sub(lamp->centre, f->point);
    double ahead = vec3_dot(f->n, to);
    if (ahead <= -lamp->radius) return 0;
    if (lamp->corner_count == 0) return still_ball_share(f->n, to, lamp->radius);
    double before = -vec3_dot(lamp->normal, to);
    if (before <= 0) return 0;
    if (lamp->spread) return table_share(lamps, lamp, f);
    double d2 = vec3_dot(to, to), radius2 = lamp->radius * lamp->radius;
    if (ahead <= lamp->radius || d2 < MIDDLING * MIDDLING * radius2) return near_share(lamps, lamp, f);
    if (d2 > FAR * FAR * radius2) return lamp->area * ahead * before / (M_PI * d2 * d2);
    if (lamp->corner_count != 4) return near_share(lamps, lamp, f);
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        Vec3 way = vec3_sub(lamp->four[i], f->point);
        double way2 = vec3_dot(way, way);
        sum += vec3_dot(f->n, way) / (way2 * way2);
    }
    return lamp->area / 4 * before * sum / M_PI;
}

// ---- points of a lamp

// A point uniform over the polygon, in one of the triangles between the first corner and each edge.
static Vec3 point_of_polygon(const StillLamps *lamps, const Lamp *lamp, double u, double v) {
    const Vec3 *c = lamps->corners + lamp->first_corner;
    double left = u * lamp->area, area = 0;
    int last = lamp->corner_count - 2, i = 1;
    for (; i <= last; i++) {
        area = 0.5 * vec3_length(vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
        if (left < area || i == last) break;
        left -= area;
    }
    double along = area > 0 ? fmin(left / area, 1) : 0;
    return vec3_lerp(c[0], vec3_lerp(c[i], c[i + 1], along), sqrt(v));
}

// A point of the ball, uniform over the directions from the place.
static Vec3 point_of_ball(const Lamp *lamp, Vec3 from, double u, double v) {
    Vec3 to = vec3_sub(lamp->centre, from), x, y;
    double d2 = vec3_dot(to, to), r2 = lamp->radius * lamp->radius, d = sqrt(d2);
    if (d2 <= r2) return from;
    double least = sqrt(1 - r2 / d2), cosine = 1 - u * (1 - least), sine2 = 1 - cosine * cosine;
    double far = d * cosine - sqrt(fmax(r2 - d2 * sine2, 0)), turn = 2 * M_PI * v;
    Vec3 axis = vec3_scale(to, 1 / d);
    view_axes(axis, &x, &y);
    Vec3 across = vec3_scale(vec3_add(vec3_scale(x, cos(turn)), vec3_scale(y, sin(turn))), sqrt(sine2));
    return vec3_add(from, vec3_scale(vec3_add(vec3_scale(axis, cosine), across), far));
}

static double sends(const Lamp *lamp, const LampFrame *f, Vec3 point) {
    Vec3 to = vec3_sub(point, f->point);
    double d2 = vec3_dot(to, to), ahead = fmax(vec3_dot(f->n, to), 0);
    if (lamp->corner_count == 0) return d2 > 0 ? ahead / sqrt(d2) : 0;
    double diffuse = d2 > 0 ? ahead * fmax(-vec3_dot(lamp->normal, to), 0) / (d2 * d2) : 0;
    if (!lamp->spread || !(diffuse > 0)) return diffuse;
    return diffuse * spread_ratio(lamp->spread, lamp->normal, vec3_scale(to, -1 / sqrt(d2)));
}

// Chooses one of a few points, by the light that each sends; false: none sends any.
static bool choose_point(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f, const double u[2],
                         double pick, Vec3 *out) {
    Vec3 point[POINTS], to = vec3_sub(lamp->centre, f->point);
    double weight[POINTS], sum = 0;
    bool even = vec3_dot(to, to) > EVEN * EVEN * lamp->radius * lamp->radius;
    int points = even && !lamp->spread && vec3_dot(f->n, to) > lamp->radius ? 1 : POINTS;
    for (int i = 0; i < points; i++) {
        // Four points lie two by two, each half a unit from the others in u or v.
        double a = lamp_fraction(u[0] + 0.5 * (i & 1)), b = lamp_fraction(u[1] + 0.5 * (i >> 1));
        point[i] = lamp->corner_count == 0 ? point_of_ball(lamp, f->point, a, b)
                                           : point_of_polygon(lamps, lamp, a, b);
        sum += weight[i] = sends(lamp, f, point[i]);
    }
    if (!(sum > 0)) return false;
    int i = 0;
    double left = pick * sum;
    while (i + 1 < points && left >= weight[i]) left -= weight[i++];
    *out = point[i];
    return true;
}

// Looks to a point of a lamp: the share of light that comes from there, 0 where something opaque stands before it.
static double lamp_sees(const StillLamps *lamps, const Lamp *lamp, const LampFrame *f, const double u[2],
                        double pick) {
    Vec3 point;
    if (!choose_point(lamps, lamp, f, u, pick, &point)) return 0;
    Vec3 to = vec3_sub(point, f->point);
    double d = vec3_length(to);
    Ray ray = {f->point, vec3_scale(to, 1 / d), STILL_NEAR, d - lamp->before};
    if (still_rays_blocked(lamps->scene->opaque, &ray)) return 0;
    return panes_transmit(&lamps->scene->mesh->panes, f->point, point);
}

// ---- lamps that a side of an element sees, found when first asked for; lamps that its cells cannot see or that turn away are left out

// Facets of curved shapes tell little of the shape's surroundings: of every lamp that may be seen, at least this share counts as seen.
static const float CURVED_SEEN = 0.2f;

// A point of the element, uniform over each of its triangles.
static Vec3 point_of_element(const Mesh *mesh, const Element *e, double u, double v) {
    const int *corner = mesh->corners + e->first_corner;
    int i = 1 + (int)(u * (e->corner_count - 2));
    double along = lamp_fraction(u * (e->corner_count - 2)), out = sqrt(v);
    Vec3 far = vec3_lerp(mesh->vertices[corner[i]], mesh->vertices[corner[i + 1]], along);
    return vec3_lerp(mesh->vertices[corner[0]], far, out);
}

// One of a group's lamps that turns its front to a point: the first from the lamp that u gives; NULL: none does.
static const Lamp *facing_of(const StillLamps *lamps, int group, Vec3 point, double u) {
    int first = lamps->group_first[group], count = lamps->group_first[group + 1] - first,
        start = (int)(u * count);
    for (int i = 0; i < count; i++) {
        const Lamp *lamp = &lamps->lamps[first + (start + i) % count];
        if (lamp->corner_count == 0 || vec3_dot(lamp->normal, vec3_sub(lamp->centre, point)) < 0) return lamp;
    }
    return NULL;
}

// The share of looks from an element to the lamps of a group that meet nothing before the lamps.
static float seen_share(const StillLamps *lamps, const Element *element, Vec3 normal, int group) {
    double seen = 0;
    StillNumbers numbers = {.shift = {0.5, 0.5, 0.5}};
    for (int k = 0; k < lamps->looks; k++) {
        double u[3], w[3];
        lamp_numbers_next(&numbers, u);
        lamp_numbers_next(&numbers, w);
        LampFrame f = {.n = normal, .point = point_of_element(lamps->scene->mesh, element, u[0], u[1])};
        const Lamp *lamp = facing_of(lamps, group, f.point, u[2]);
        if (lamp) seen += lamp_sees(lamps, lamp, &f, w, w[2]);
    }
    return (float)seen / (float)lamps->looks;
}

// Does any corner of an element lie before a lamp? On a curved shape the answer is yes, since its points lie elsewhere than the facet.
static bool may_matter(const StillLamps *lamps, const Element *element, const Lamp *lamp, bool curved) {
    const Mesh *mesh = lamps->scene->mesh;
    if (curved || lamp->corner_count == 0) return true;
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 to = vec3_sub(mesh->vertices[mesh->corners[element->first_corner + i]], lamp->centre);
        if (vec3_dot(lamp->normal, to) > 0) return true;
    }
    return false;
}

// The cells into which a side of an element looks; count 0: unknown.
enum { MOST_CELLS = 4 };
typedef struct Cells {
    int cell[MOST_CELLS], count;
} Cells;

// The cells of a side of an element: a wall lies in one cell; a thing in a room may reach into several.
static Cells cells_of(const StillLamps *lamps, const Element *element, bool front) {
    static const double INWARDS = 1e-3;  // share of the way to the middle: a corner lies on walls
    const Mesh *mesh = lamps->scene->mesh;
    const Face *face = &mesh->faces[element->face];
    const Patch *patch = &mesh->patches[element->patch];
    Cells out = {.cell = {patch->cell}, .count = patch->cell >= 0};
    if (front && mesh->graph->objects[face->object].kind == OBJECT_SURFACE) return out;
    Vec3 normal = vec3_scale(face->plane.n, front ? 1 : -1);
    out.count = 0;
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 at = vec3_lerp(mesh->vertices[mesh->corners[element->first_corner + i]], patch->centre, INWARDS);
        int cell = gather_cell(mesh->graph, at, normal, patch->cell), k = 0;
        while (k < out.count && out.cell[k] != cell) k++;
        if (k < out.count) continue;
        if (cell < 0 || out.count == MOST_CELLS) return (Cells){.count = 0};
        out.cell[out.count++] = cell;
    }
    return out;
}

static bool any_sees(const StillLamps *lamps, const Cells *cells, const Lamp *lamp) {
    if (cells->count == 0 || lamp->cell < 0 || !lamps->forest) return true;
    for (int i = 0; i < cells->count; i++)
        if (vis_sees(lamps->forest, cells->cell[i], lamp->cell)) return true;
    return false;
}

// Does any part of a lamp rise above the plane of a face?
static bool rises(const StillLamps *lamps, const Lamp *lamp, Vec3 n, double d) {
    if (lamp->corner_count == 0) return vec3_dot(n, lamp->centre) + lamp->radius > d;
    for (int i = 0; i < lamp->corner_count; i++)
        if (vec3_dot(n, lamps->corners[lamp->first_corner + i]) > d) return true;
    return false;
}

static Candidates *find_candidates(const StillLamps *lamps, int index, bool front, Arena *arena) {
    const Mesh *mesh = lamps->scene->mesh;
    const Element *element = &mesh->elements[index];
    const Face *face = &mesh->faces[element->face];
    Vec3 normal = vec3_scale(face->plane.n, front ? 1 : -1);
    double d = front ? face->plane.d : -face->plane.d;
    bool curved = lamp_shape_of(lamps->scene, face) != NULL;
    Cells cells = cells_of(lamps, element, front);
    Candidates *out = arena_alloc(arena, 1, sizeof *out + (size_t)lamps->count * sizeof *out->lamp);
    int hidden = lamps->count;  // hidden lamps are kept from here to the end for now
    float seen = -1;            // the share seen of the group, -1: not looked for
    for (int i = 0; i < lamps->count; i++) {
        const Lamp *lamp = &lamps->lamps[i];
        if (i == lamps->group_first[lamp->group]) seen = -1;
        if (!any_sees(lamps, &cells, lamp) || !may_matter(lamps, element, lamp, curved) ||
            (!curved && !rises(lamps, lamp, normal, d)))
            continue;
        if (seen < 0) seen = seen_share(lamps, element, normal, lamp->group);
        if (seen > 0 || curved)
            out->lamp[out->seen_count++] = (Candidate){i, fmaxf(seen, curved ? CURVED_SEEN : 0)};
        else
            out->lamp[--hidden] = (Candidate){i, 0};
    }
    out->count = out->seen_count + lamps->count - hidden;
    memmove(out->lamp + out->seen_count, out->lamp + hidden,
            (size_t)(lamps->count - hidden) * sizeof *out->lamp);
    return out;
}

// The first thread that asks makes the list; threads that make it at the same time make the same list.
static const Candidates *lamp_candidates(StillLamps *lamps, int element, bool front) {
    _Atomic(Candidates *) *place = &lamps->of_element[2 * element + !front];
    Candidates *found = atomic_load(place);
    if (found) return found;
    Arena scratch = {0};
    Candidates *made = find_candidates(lamps, element, front, &scratch);
    size_t size = sizeof *made + (size_t)made->count * sizeof *made->lamp;
    pthread_mutex_lock(&lamps->lock);
    found = atomic_load(place);
    if (!found) {
        found = arena_alloc(&lamps->found, 1, size);
        memcpy(found, made, size);
        atomic_store(place, found);
    }
    pthread_mutex_unlock(&lamps->lock);
    arena_free(&scratch);
    return found;
}

// ---- made once

static bool material_emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

static void put_exitance(Lamp *lamp, const Material *m) {
    lamp->exitance[0] = (double)m->emission.r;
    lamp->exitance[1] = (double)m->emission.g;
    lamp->exitance[2] = (double)m->emission.b;
    lamp->luminous = light_luminous(lamp->exitance);
}

static void add_ball(StillLamps *lamps, int shape, Arena *arena, int *capacity) {
    const CellGraph *graph = lamps->scene->mesh->graph;
    const CurvedShape *s = &graph->building->shapes[shape];
    Lamp *lamp = ARENA_PUSH(arena, lamps->lamps, lamps->count, *capacity);
    *lamp = (Lamp){.centre = s->frame.origin,
                   .radius = vec3_length(s->frame.axis[0]),
                   .before = BEFORE,
                   .cell = -1,
                   .group = -1};
    lamp->area = 4 * M_PI * lamp->radius * lamp->radius;
    put_exitance(lamp, &graph->building->materials[s->material]);
}

// Gauss's two points along each of two directions, exact for cubics on a parallelogram.
static void put_four(Lamp *lamp, const Vec3 *c) {
    static const double PLACE[2] = {0.21132486540518713, 0.7886751345948129};
    if (lamp->corner_count != 4) return;
    for (int i = 0; i < 4; i++) {
        double u = PLACE[i & 1], v = PLACE[i >> 1];
        lamp->four[i] = vec3_lerp(vec3_lerp(c[0], c[1], u), vec3_lerp(c[3], c[2], u), v);
    }
}

static void add_lamp_polygon(StillLamps *lamps, int face, double before, Arena *arena, int *capacity,
                             int *corners, int *corner_capacity) {
    const Mesh *mesh = lamps->scene->mesh;
    const Face *f = &mesh->faces[face];
    Lamp *lamp = ARENA_PUSH(arena, lamps->lamps, lamps->count, *capacity);
    *lamp =
        (Lamp){.first_corner = *corners, .normal = f->plane.n, .before = BEFORE + before, .group = f->object};
    // The polygon as it was in the graph: vertices that neighbours put on the face's edges do not change it.
    const Polygon *p = &mesh->graph->polygons[f->polygon];
    Box box = box_empty();
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 v = lamps->scene->vertices[p->first_vertex + i];
        *ARENA_PUSH(arena, lamps->corners, *corners, *corner_capacity) = v;
        box = box_add(box, v);
        lamp->corner_count++;
    }
    lamp->centre = vec3_lerp(box.min, box.max, 0.5);
    lamp->radius = 0.5 * vec3_length(vec3_sub(box.max, box.min));
    lamp->area = polygon_area(lamps->corners + lamp->first_corner, lamp->corner_count);
    put_four(lamp, lamps->corners + lamp->first_corner);
    lamp->spread = mesh_spread(mesh, face);
    put_exitance(lamp, mesh_material(mesh, face));
}

// The cell that a lamp shines into; -1 for a lamp that reaches into several cells, since it may be seen from where none of them alone is.
static int find_cell(const StillLamps *lamps, const Lamp *lamp) {
    static const double INWARDS = 1e-3;  // share of the way to the middle: a corner lies on walls
    const CellGraph *graph = lamps->scene->mesh->graph;
    int cell = gather_cell(graph, lamp->centre, lamp->normal, -1);
    for (int i = 0; i < lamp->corner_count; i++) {
        Vec3 corner = vec3_lerp(lamps->corners[lamp->first_corner + i], lamp->centre, INWARDS);
        if (gather_cell(graph, corner, lamp->normal, cell) != cell) return -1;
    }
    return cell;
}

static void list_lamps(StillLamps *lamps, Arena *arena) {
    const Mesh *mesh = lamps->scene->mesh;
    const Building *b = mesh->graph->building;
    int capacity = 0, corners = 0, corner_capacity = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        if (!mesh_emits(mesh, f) ||
            mesh->graph->polygons[mesh->faces[f].polygon].vertex_count > ANALYTIC_CORNERS)
            continue;
        const CurvedShape *shape = lamp_shape_of(lamps->scene, &mesh->faces[f]);
        if (shape && is_ball(shape)) continue;
        add_lamp_polygon(lamps, f, shape ? 2 * shape->tolerance : 0, arena, &capacity, &corners,
                         &corner_capacity);
        lamps->lamps[lamps->count - 1].cell = find_cell(lamps, &lamps->lamps[lamps->count - 1]);
    }
    for (int s = 0; s < b->shape_count; s++)
        if (is_ball(&b->shapes[s]) && material_emits(&b->materials[b->shapes[s].material]))
            add_ball(lamps, s, arena, &capacity);
}

// Turns the objects of lamps, which come one after the other, into numbers of groups. Each ball is a group by itself.
static void find_groups(StillLamps *lamps, Arena *arena) {
    int object = -1;
    lamps->group_first = ARENA_ARRAY(arena, int, lamps->count + 1);
    for (int i = 0; i < lamps->count; i++) {
        Lamp *lamp = &lamps->lamps[i];
        if (i == 0 || lamp->group < 0 || lamp->group != object) lamps->group_first[lamps->group_count++] = i;
        object = lamp->group;
        lamp->group = lamps->group_count - 1;
    }
    lamps->group_first[lamps->group_count] = lamps->count;
}

StillLamps *still_lamps_new(const StillScene *scene, const StabForest *forest, int samples, Arena *arena) {
    StillLamps *lamps = ARENA_ARRAY(arena, StillLamps, 1);
    lamps->scene = scene;
    lamps->forest = forest;
    lamps->looks = samples < LEAST_LOOKS / 2  ? LEAST_LOOKS
                   : samples < MOST_LOOKS / 2 ? 2 * samples
                                              : MOST_LOOKS;
    list_lamps(lamps, arena);
    find_groups(lamps, arena);
    lamps->of_element =
        arena_alloc(arena, 2 * (size_t)scene->mesh->element_count + 1, sizeof *lamps->of_element);
    pthread_mutex_init(&lamps->lock, NULL);
    return lamps;
}

void still_lamps_end(StillLamps *lamps) {
    pthread_mutex_destroy(&lamps->lock);
    arena_free(&lamps->found);
}

int still_lamps_count(const StillLamps *lamps) { return lamps->count; }

// ---- light

// The most lamps that are weighed at once; further lamps are weighed in another round.
enum { TOGETHER = 256 };

typedef struct Weighed {
    int lamp[TOGETHER], count;
    double share[TOGETHER],
        seen[TOGETHER];            // share of the place's light; share of the lamp that counts as seen
    double weight[TOGETHER], sum;  // how large the error may be
} Weighed;

static void weigh(const StillLamps *lamps, const LampFrame *f, const Candidate *list, int count,
                  Weighed *out) {
    out->count = 0;
    out->sum = 0;
    for (int i = 0; i < count; i++) {
        const Lamp *lamp = &lamps->lamps[list[i].lamp];
        double share = lamp_share(lamps, lamp, f);
        if (!(share > 0)) continue;
        out->lamp[out->count] = list[i].lamp;
        double seen = (double)list[i].seen, doubt = fmax(sqrt(seen * (1 - seen)), LEAST_DOUBT);
        out->weight[out->count] = share * lamp->luminous * doubt;
        out->sum += out->weight[out->count];
        out->seen[out->count] = seen;
        out->share[out->count++] = share;
    }
}

static void add_taken(const StillLamps *lamps, const Weighed *w, double scale, double out[3]) {
    for (int i = 0; i < w->count; i++)
        for (int c = 0; c < 3; c++)
            out[c] += scale * w->share[i] * w->seen[i] * lamps->lamps[w->lamp[i]].exitance[c];
}

// Adds the error of the light taken, as shadow rays estimate it.
static void add_off(const StillLamps *lamps, const Weighed *w, const LampFrame *f, int rays, double scale,
                    StillNumbers *numbers, double out[3]) {
    for (int k = 0; k < rays; k++) {
        double u[3];
        lamp_numbers_next(numbers, u);
        double left = u[0] * w->sum;
        int i = 0;
        while (left >= w->weight[i] && i + 1 < w->count) left -= w->weight[i++];
        const Lamp *lamp = &lamps->lamps[w->lamp[i]];
        double off = lamp_sees(lamps, lamp, f, u + 1, fmin(left / w->weight[i], 1)) - w->seen[i];
        double share = scale * off * w->share[i] * w->sum / w->weight[i] / rays;
        for (int c = 0; c < 3; c++) out[c] += share * lamp->exitance[c];
    }
}

static void add_all(const StillLamps *lamps, const LampFrame *f, const Candidate *list, int count, int rays,
                    double scale, StillNumbers *numbers, double out[3]) {
    Weighed w;
    for (int i = 0; i < count; i += TOGETHER) {
        weigh(lamps, f, list + i, count - i < TOGETHER ? count - i : TOGETHER, &w);
        if (!(w.sum > 0)) continue;
        add_taken(lamps, &w, scale, out);
        add_off(lamps, &w, f, rays, scale, numbers, out);
    }
}

// The irradiance that lamps send to a place, W/m^2 a channel: the light that would arrive if nothing stood between, in closed form, times
// the share of it that is seen, by `rays` shadow rays.
static void still_lamps_light(StillLamps *lamps, const StillPlace *place, int rays, StillNumbers *numbers,
                              double out[3]) {
    const Candidates *list = lamp_candidates(lamps, place->element, place->front);
    LampFrame f = {.n = place->normal, .point = place->point};
    view_axes(f.n, &f.x, &f.y);
    out[0] = out[1] = out[2] = 0;
    add_all(lamps, &f, list->lamp, list->seen_count, rays, 1, numbers, out);
    if (list->count == list->seen_count) return;
    double u[3];
    lamp_numbers_next(numbers, u);
    if (u[0] < ONCE_IN_A_WHILE)
        add_all(lamps, &f, list->lamp + list->seen_count, list->count - list->seen_count, 1,
                1 / ONCE_IN_A_WHILE, numbers, out);
}

// Facets of curved shapes are so small that shots hit some of them twice and others not at all. A facet's light is a mean over the facets
// that look the same way within this distance, metres, or within this many of its own sizes, whichever is more.
static const double SMOOTH = 0.04, SMOOTH_SIZES = 3;
// Facets are looked for this many tolerances to either side of their shape.
static const double FACET_REACH = 4;

// ---- made once

// The light that was reflected on its way.
static void reflected_light(const Mesh *mesh, const RadSolution *solution, double (*out)[3]) {
    for (int e = 0; e < mesh->element_count; e++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
        for (int c = 0; c < 3; c++)
            out[e][c] = fmax(solution->radiosity[e][c] - emitted[c] - solution->direct[e][c], 0);
    }
}

// The same at nodes, where it is known apart.
static double (*reflected_at_nodes(const Mesh *mesh, const RadSolution *solution, Arena *arena))[3] {
    Arena scratch = {0};
    Nodes nodes = nodes_of(mesh, &scratch);
    double(*out)[3] = arena_alloc(arena, (size_t)solution->node_count + 1, sizeof *out);
    for (int n = 0; n < nodes.count; n++) {
        double emitted[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[nodes.element[nodes.first[n]]].face)->emission,
                    emitted);
        for (int c = 0; c < 3; c++) out[n][c] = fmax(solution->rest[n][c] - emitted[c], 0);
    }
    arena_free(&scratch);
    return out;
}

static void find_mean(const Mesh *mesh, const RadSolution *solution, double out[3]) {
    double area = 0;
    out[0] = out[1] = out[2] = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        for (int c = 0; c < 3; c++) out[c] += mesh->elements[e].area * solution->radiosity[e][c];
        // Only the share that is no mirror counts as area: mirrors show the light of other surfaces.
        area += mesh->elements[e].area * (1 - (double)mesh_material(mesh, mesh->elements[e].face)->mirror);
    }
    for (int c = 0; c < 3 && area > 0; c++) out[c] /= area;
}

// The mean for one element over the elements from `first` to before `end`.
static void smooth_element(const Mesh *mesh, const Vec3 *centres, int element, int first, int end,
                           double (*from)[3], double out[3]) {
    const Element *e = &mesh->elements[element];
    double reach = fmax(SMOOTH, SMOOTH_SIZES * sqrt(e->area)), weights = 0;
    Vec3 n = mesh->faces[e->face].plane.n;
    out[0] = out[1] = out[2] = 0;
    for (int k = first; k < end; k++) {
        Vec3 way = vec3_sub(centres[k], centres[element]);
        double d2 = vec3_dot(way, way) / (reach * reach);
        double alike = vec3_dot(n, mesh->faces[mesh->elements[k].face].plane.n);
        if (d2 >= 1 || alike <= 0) continue;
        double weight = mesh->elements[k].area * (1 - d2) * (1 - d2) * alike * alike;
        for (int c = 0; c < 3; c++) out[c] += weight * from[k][c];
        weights += weight;
    }
    for (int c = 0; c < 3; c++) out[c] /= weights;
}

// Smooths the light of each shape. The faces of a shape follow each other.
static void smooth_shapes(const Mesh *mesh, double (*light)[3]) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    Vec3 *centres = ARENA_ARRAY(&scratch, Vec3, mesh->element_count + 1);
    double(*from)[3] = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *from);
    memcpy(from, light, (size_t)mesh->element_count * sizeof *from);
    for (int e = 0; e < mesh->element_count; e++) centres[e] = element_centroid(mesh, e);
    for (int s = 0; s < graph->building->shape_count; s++) {
        const CurvedShape *shape = &graph->building->shapes[s];
        int first = still_first_polygon(graph, shape), low = mesh->element_count, end = 0;
        for (int p = first; p < first + shape->polygon_count; p++) {
            if (mesh->face_of[p] < 0) continue;
            const Face *face = &mesh->faces[mesh->face_of[p]];
            low = face->first_element < low ? face->first_element : low;
            if (face->first_element + face->element_count > end)
                end = face->first_element + face->element_count;
        }
        for (int e = low; e < end; e++) smooth_element(mesh, centres, e, low, end, from, light[e]);
    }
    arena_free(&scratch);
}

StillLight still_light_new(const StillScene *scene, const RadSolution *solution, StillLamps *lamps,
                           Arena *arena) {
    const Mesh *mesh = scene->mesh;
    StillLight light = {.scene = scene, .lamps = lamps, .outdoors = 1};
    Arena scratch = {0};
    RadSolution shown = *solution;
    if (lamps && solution->rest) {
        shown.node = reflected_at_nodes(mesh, solution, &scratch);
        light.sun = solution->day;
        if (rgb_sum(light.sun.beam) > 0) view_axes(light.sun.sun, &light.sun_x, &light.sun_y);
    } else if (lamps) {
        shown.radiosity = arena_alloc(&scratch, (size_t)mesh->element_count, sizeof *shown.radiosity);
        reflected_light(mesh, solution, shown.radiosity);
        smooth_shapes(mesh, shown.radiosity);
        shown.node = NULL;
        shown.node_count = 0;
    }
    light.baked = reconstruct_light(mesh, &shown, arena);
    light.baked.triangle = reconstruct_triangles(mesh, arena);
    find_mean(mesh, solution, light.mean);
    arena_free(&scratch);
    return light;
}

// ---- where on the mesh

typedef struct Spot {
    int element;  // -1: none
    Vec3 point;   // in its plane
} Spot;

static int facet_near(const StillScene *scene, const CurvedShape *shape, const SurfaceHit *hit, Vec3 at,
                      Spot *out) {
    double reach = FACET_REACH * shape->tolerance;
    for (int side = 1; side >= -1; side -= 2) {
        Vec3 way = vec3_scale(hit->at.normal, -side);
        Ray ray = {vec3_sub(at, vec3_scale(way, reach)), way, 0, 2 * reach};
        SurfaceHit facet = still_rays_first(scene->facets, &ray);
        if (facet.item < 0 || scene->facet_face[facet.item] < 0) continue;
        out->point = still_ray_at(&ray, facet.at.t);
        return scene->facet_face[facet.item];
    }
    return -1;
}

// The face of an object whose middle is nearest to a point: used where no facet lies near the point of a shape.
static int face_near(const Mesh *mesh, int object, Vec3 at) {
    const Object *o = &mesh->graph->objects[object];
    int best = -1;
    double nearest = INFINITY;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        int f = mesh->face_of[p];
        if (f < 0) continue;
        const Face *face = &mesh->faces[f];
        Vec3 sum = {0, 0, 0};
        for (int i = 0; i < face->vertex_count; i++)
            sum = vec3_add(sum, mesh->vertices[mesh->outline[face->first_vertex + i]]);
        Vec3 to = vec3_sub(vec3_scale(sum, 1.0 / face->vertex_count), at);
        double d2 = vec3_dot(to, to);
        if (d2 >= nearest) continue;
        nearest = d2;
        best = f;
    }
    return best;
}

static Spot find_spot(const StillScene *scene, const StillSurface *s, const SurfaceHit *hit, Vec3 at) {
    const Mesh *mesh = scene->mesh;
    Spot spot = {-1, at};
    int face = s->face;
    if (s->shape >= 0) {
        face = facet_near(scene, &mesh->graph->building->shapes[s->shape], hit, at, &spot);
        if (face < 0) face = face_near(mesh, s->object, at);
    }
    if (face >= 0) spot.element = mesh_element_at(mesh, face, spot.point);
    return spot;
}

// ---- light

static void add_lamps(const StillLight *light, Rgb rho, const Spot *spot, Vec3 at, Vec3 normal, bool front,
                      int rays, StillNumbers *numbers, double out[3]) {
    double arrives[3];
    still_lamps_light(light->lamps, &(StillPlace){at, normal, spot->element, front}, rays, numbers, arrives);
    out[0] += (double)rho.r * arrives[0];
    out[1] += (double)rho.g * arrives[1];
    out[2] += (double)rho.b * arrives[2];
}

// Adds the sun's light, by rays to points of its disc.
static void add_sun(const StillLight *light, Rgb rho, Vec3 at, Vec3 normal, int rays, StillNumbers *numbers,
                    double out[3]) {
    double u[3], seen = 0, wide = tan(DAYLIGHT_SUN_RADIUS);
    if (vec3_dot(normal, light->sun.sun) <= -wide) return;
    for (int k = 0; k < rays; k++) {
        lamp_numbers_next(numbers, u);
        double r = wide * sqrt(u[0]), turn = 2 * M_PI * u[1];
        Vec3 aside =
            vec3_add(vec3_scale(light->sun_x, r * cos(turn)), vec3_scale(light->sun_y, r * sin(turn)));
        Vec3 way = vec3_normalize(vec3_add(light->sun.sun, aside));
        double cosine = vec3_dot(normal, way);
        Ray ray = still_ray(at, way);
        if (cosine > 0 && !still_rays_blocked(light->scene->opaque, &ray))
            seen += cosine * panes_transmit_from_afar(&light->scene->mesh->panes, at, way) / rays;
    }
    out[0] += (double)rho.r * seen * light->sun.beam[0];
    out[1] += (double)rho.g * seen * light->sun.beam[1];
    out[2] += (double)rho.b * seen * light->sun.beam[2];
}

// Baked light is that of a surface of the material's mean reflectance; emission stays as it is.
static void show_picture(const Material *m, Rgb rho, bool emits, double light[3]) {
    double mean[3], own[3], emitted[3];
    rgb_doubles(m->reflectance, mean);
    rgb_doubles(rho, own);
    rgb_doubles(emits ? m->emission : (Rgb){0, 0, 0}, emitted);
    for (int c = 0; c < 3; c++)
        if (mean[c] > 0) light[c] = emitted[c] + fmax(light[c] - emitted[c], 0) * own[c] / mean[c];
}

void still_light_at(const StillLight *light, const Ray *ray, const SurfaceHit *hit, double width, int rays,
                    StillNumbers *numbers, double out[3]) {
    const StillSurface *s = &light->scene->surfaces[hit->item];
    Vec3 at = still_ray_at(ray, hit->at.t), normal = vec3_scale(hit->at.normal, hit->front ? 1 : -1);
    Spot spot = find_spot(light->scene, s, hit, at);
    out[0] = out[1] = out[2] = 0;
    // Light is computed as if the back of a polygon reflected nothing. Curtains are one polygon, and show some of their front's light.
    double share = hit->front ? 1 : WALK_BACK_SHARE;
    if (spot.element >= 0) {
        Rgb rho = still_texel(light->scene, s, at, width).colour;
        reconstruct_in(light->scene->mesh, &light->baked, spot.element, spot.point, out);
        if (s->material->texture > 0) show_picture(s->material, rho, light->lamps == NULL, out);
        for (int c = 0; c < 3; c++) out[c] *= share;
        if (light->lamps) add_lamps(light, rho, &spot, at, normal, hit->front, rays, numbers, out);
        if (rgb_sum(light->sun.beam) > 0) add_sun(light, rho, at, normal, rays, numbers, out);
        if (light_outdoors(light->scene->mesh, spot.element))
            for (int c = 0; c < 3; c++) out[c] *= light->outdoors;
    }
    // In the other cases the baked light contains the emission.
    if (hit->front && (light->lamps || spot.element < 0)) {
        out[0] += (double)s->material->emission.r;
        out[1] += (double)s->material->emission.g;
        out[2] += (double)s->material->emission.b;
    }
}
