// still_lamps.c - what lamps would send to a place if nothing stood between is known in closed form (Heitz, Hill & McGuire 2018,
// Combining Analytic Direct Illumination and Stochastic Shadows). About how much of it is seen is known of each element: that much is
// taken, and shadow rays say by how much more or less it is, each to a point of a lamp that is chosen by how much that may be (a
// control variate: Kalos & Whitlock 1986). So there is noise only where something hides a part of a lamp, however many there are.
#include "engine/stills/still_lamps.h"

#include "engine/draw/false_colour.h"
#include "engine/stills/still_lamps_parts.h"
#include "radiosity/factors/analytic.h"
#include "radiosity/show/gather.h"

// Lamps of which an element saw nothing are asked for once in a while.
static const double ONCE_IN_A_WHILE = 0.25;
// An element's few looks may have missed what hides a lamp, or a gap: the share of its light in doubt is never less.
static const double LEAST_DOUBT = 0.15;
// Looks from an element: two for each sample of a pixel, within bounds.
enum { LEAST_LOOKS = 16, MOST_LOOKS = 128 };
// Shadow rays end so far before a lamp, metres; and of a lamp with facets, by the tolerance of those.
static const double BEFORE = 1e-5;

// ---- made once

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }

static bool is_ball(const CurvedShape *shape) {
    if (shape->kind != CURVED_SPHERE) return false;
    double r = vec3_length(shape->frame.axis[0]);
    for (int a = 1; a < 3; a++)
        if (fabs(vec3_length(shape->frame.axis[a]) - r) > 1e-9 * r) return false;
    return true;
}

static void put_exitance(Lamp *lamp, const Material *m) {
    lamp->exitance[0] = (double)m->emission.r;
    lamp->exitance[1] = (double)m->emission.g;
    lamp->exitance[2] = (double)m->emission.b;
    lamp->luminous = light_luminous(lamp->exitance);
}

// The shape that is drawn exactly of which the face is a part; NULL: none.
const CurvedShape *lamp_shape_of(const StillScene *scene, const Face *face) {
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

// Gauss's two places along each of two directions, exact for cubics on a parallelogram.
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
    // Vertices of neighbours on its edges say nothing of it: the polygon as it was.
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
    put_exitance(lamp, mesh_material(mesh, face));
}

// What reaches into several cells may be seen from where none of them alone is.
static int find_cell(const StillLamps *lamps, const Lamp *lamp) {
    static const double INWARDS = 1e-3;  // of the way: a corner lies on walls
    const CellGraph *graph = lamps->scene->mesh->graph;
    int cell = gather_cell(graph, lamp->centre, lamp->normal, -1);
    for (int i = 0; i < lamp->corner_count; i++) {
        Vec3 corner = vec3_lerp(lamps->corners[lamp->first_corner + i], lamp->centre, INWARDS);
        if (gather_cell(graph, corner, lamp->normal, cell) != cell) return -1;
    }
    return cell;
}

static void add_lamps(StillLamps *lamps, Arena *arena) {
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
        if (is_ball(&b->shapes[s]) && emits(&b->materials[b->shapes[s].material]))
            add_ball(lamps, s, arena, &capacity);
}

// From objects, which come one after the other, to numbers of groups. A ball is one by itself.
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
    add_lamps(lamps, arena);
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

void lamp_numbers_next(StillNumbers *numbers, double u[3]) {
    // Powers of 1 / 1.2207440846, the root of x^4 = x + 1.
    static const double STEP[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int i = 0; i < 3; i++) u[i] = lamp_fraction(numbers->shift[i] + STEP[i] * numbers->next);
    numbers->next++;
}

// ---- light

// Lamps that are weighed at once, at most: of more the rest is left to a second go.
enum { TOGETHER = 256 };

typedef struct Weighed {
    int lamp[TOGETHER], count;
    double share[TOGETHER],
        seen[TOGETHER];            // of the light that leaves the place; of that, what is taken to be seen
    double weight[TOGETHER], sum;  // how much the light may be off
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

// What shadow rays say it is off.
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

void still_lamps_light(StillLamps *lamps, const StillPlace *place, int rays, StillNumbers *numbers,
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
