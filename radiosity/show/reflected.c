// reflected.c - reflected light has one value for each patch, gathered along the patch's row (RadSolution.reflected). Where these bend, or
// much of a patch's view is close, the values are too few: elements are halved there, and light is gathered at the middle of each part.
// Where shots tell an element from its patch, it gathers as it is. The nodes between all these values are those of reconstruct.h; but
// beside a wall or below a board light does not go on along the planes through values at middles, so edge nodes gather by themselves.
//
// Source: G. J. Ward, F. M. Rubinstein & R. D. Clear, A Ray Tracing Solution for Diffuse Interreflection, 1988: values of indirect light
// are the denser the closer other surfaces are. Departure: steps of the light itself count as well, as shares of all light there.
#include "radiosity/show/reflected.h"

#include <math.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/show/shown.h"

// Bends above these shares of the light ask for one and for two halvings; and the shares of a view that is close.
static const double BEND_ONE = 0.06, BEND_TWO = 0.25, CLOSE_ONE = 0.4, CLOSE_TWO = 0.7;
// Elements whose light shots say to be off their patch's by more than this share gather by themselves: of a patch that is half covered the
// middle tells little of the rest.
static const double APART = 0.25;
// They count by an element's length over this, metres: what is short is seen less.
static const double LONG = 0.3;
// No part is shorter for it, metres.
static const double SHORTEST = 0.05;
// So many parts may come of it, as a share of the patches, and so many elements may gather without being halved.
static const double MOST_PARTS = 0.9, MOST_APART = 0.5;
// The share of the mean light that counts as light in the dark.
static const double DARK = 0.01;
// Directions each way of the rows of parts.
enum { RESOLUTION = 40 };
// Edge nodes of elements of so many m^2 gather, and of parts of so many, where so much of the view of a patch beside them is close; as
// many of both as this share of the patches at most. They look from a point on the way to the middle of their elements, this share of it
// away: light in the corner itself is seen by a hand's breadth at most. Where more of the view than this meets backs, the point lies within
// another thing.
static const double EDGE_AREA[] = {0.02, 0.005}, EDGE_CLOSE = 0.02, MOST_EDGES = 1.25, EDGE_IN = 0.3,
                    EDGE_BACKS = 0.02;
// So much of what light beside an edge is off the middle counts as bent: linear light between the two shows the rest.
static const double EDGE_BEND = 0.6;
// Nodes whose elements make this angle or more have light on all sides, radians.
static const double ALL_AROUND = 2 * M_PI - 0.1;
// Places nearer than this are one, metres.
static const double SAME_PLACE = 1e-7;
// Parts between two looks at progress.
enum { PARTS_A_LOOK = 1024 };

// Within a patch light may change by this share of its value as its elements tell it. Elements smaller than this share of their mean have
// too few samples to tell anything; and where samples may miscount an element's light by this share, steps between elements are theirs.
static const double MOST_CHANGE = 0.5, SLIVER = 0.25, NOISY = 0.07;

// The reflected light of an element as shots tell it, W/m^2.
static void reflected_by_shots(const Mesh *mesh, const RadSolution *s, int e, double out[3]) {
    double emitted[3];
    rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, emitted);
    for (int c = 0; c < 3; c++) out[c] = s->radiosity[e][c] - s->direct[e][c] - s->sun[e][c] - emitted[c];
}

// Irradiances by reflected light of a patch's elements, from an even solution: that of the patch, and the step from it that shots tell.
static void find_patch_values(const Mesh *mesh, const RadSolution *s, int p, double (*out)[3]) {
    const Patch *patch = &mesh->patches[p];
    int first = patch->first_element, end = first + patch->element_count;
    double rho[3];
    rgb_doubles(mesh_material(mesh, patch->face)->reflectance, rho);
    for (int e = first; e < end; e++) reflected_by_shots(mesh, s, e, out[e]);
    // An element has its share of the samples that meet the patch.
    double trust = fmax(0, 1 - (double)s->noise[p] * sqrt(patch->element_count) / NOISY);
    for (int c = 0; c < 3; c++) {
        double value = s->reflected[p][c], power = 0, area = 0;
        for (int e = first; e < end; e++) {
            const double size = mesh->elements[e].area;
            power += size * out[e][c];
            area += size;
        }
        for (int e = first; e < end; e++) {
            bool sliver = mesh->elements[e].area * patch->element_count < SLIVER * area;
            double step = rho[c] > 0 && !sliver ? trust * (out[e][c] - power / area) / rho[c] : 0;
            out[e][c] = value + fmin(fmax(step, -MOST_CHANGE * value), MOST_CHANGE * value);
        }
    }
}

static void find_values(const Mesh *mesh, const RadSolution *s, double (*out)[3]) {
    for (int p = 0; p < mesh->patch_count; p++) find_patch_values(mesh, s, p, out);
}

typedef struct Steps {
    const Mesh *mesh;
    const RadSolution *solution;
    double *light;                   // [element_count] W/m^2, the sum of the channels
    double (*value)[3], (*rest)[3];  // [element_count] of reconstruct_values
    float (*worst)[2];               // [element_count] along each axis
    float (*edge)[2];        // [element_count] light beside an edge less that of the middle, along each axis
    float *apart;            // [element_count] how far shots say that its light is from its patch's
    const Borders *borders;  // or NULL
} Steps;

static void find_shown_light(Steps *s, Arena *arena) {
    const Mesh *mesh = s->mesh;
    double sums[2] = {0, 0};
    s->light = ARENA_ARRAY(arena, double, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count; e++) {
        double rho[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->reflectance, rho);
        for (int c = 0; c < 3; c++)
            s->light[e] += rho[c] * s->value[e][c] + s->solution->direct[e][c] + s->solution->sun[e][c];
        if (!mesh_owns(mesh, mesh->elements[e].face)) continue;
        sums[0] += mesh->elements[e].area * s->light[e];
        sums[1] += mesh->elements[e].area;
    }
    if (s->borders) team_sum(borders_member(s->borders), sums, 2);
    for (int e = 0; e < mesh->element_count; e++) s->light[e] += DARK * sums[0] / sums[1];
}

static void take_step(Steps *s, int a, int b) {
    const Mesh *mesh = s->mesh;
    const Element *p = &mesh->elements[a], *q = &mesh->elements[b];
    if (p->face != q->face) return;
    double rho[3], step = 0;
    rgb_doubles(mesh_material(mesh, p->face)->reflectance, rho);
    for (int c = 0; c < 3; c++) step += rho[c] * fabs(s->value[a][c] - s->value[b][c]);
    if (!(rgb_sum(s->value[a]) > 0 && rgb_sum(s->value[b]) > 0)) return;
    step /= fmin(s->light[a], s->light[b]);
    const Face *face = &mesh->faces[p->face];
    Vec3 way = vec3_sub(element_centroid(mesh, b), element_centroid(mesh, a));
    int axis = fabs(vec3_dot(vec3_normalize(face->gy), way)) > fabs(vec3_dot(vec3_normalize(face->gx), way));
    s->worst[a][axis] = fmaxf(s->worst[a][axis], (float)step);
    s->worst[b][axis] = fmaxf(s->worst[b][axis], (float)step);
}

static double length_along(const Mesh *mesh, const Element *e, int axis) {
    const Face *face = &mesh->faces[e->face];
    return axis == 0 ? ldexp(face->root / vec3_length(face->gx), -e->depth.x)
                     : ldexp(face->root / vec3_length(face->gy), -e->depth.y);
}

// How far the light that was shot to each element is from its patch's, as a share of all light there. An element that is the whole of its
// patch has the row of the patch, which looks from a free place where something stands on the middle.
static void find_apart(Steps *s, Arena *arena) {
    const Mesh *mesh = s->mesh;
    s->apart = ARENA_ARRAY(arena, float, mesh->element_count + 1);
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const double *value = s->solution->reflected[element->patch];
        double rho[3], shot[3], off = 0;
        if (!(rgb_sum(value) > 0) || mesh->patches[element->patch].element_count == 1) continue;
        rgb_doubles(mesh_material(mesh, element->face)->reflectance, rho);
        reflected_by_shots(mesh, s->solution, e, shot);
        for (int c = 0; c < 3; c++) off += fabs(shot[c] - rho[c] * value[c]);
        s->apart[e] = (float)(off / s->light[e]);
    }
}

static unsigned char depth_for(const Mesh *mesh, const Element *e, int axis, double bend, double close) {
    double weight = length_along(mesh, e, axis) / LONG;
    bend *= weight, close *= weight;
    int depth = bend > BEND_TWO || close > CLOSE_TWO ? 2 : bend > BEND_ONE || close > CLOSE_ONE ? 1 : 0;
    while (depth > 0 && ldexp(length_along(mesh, e, axis), -depth) < SHORTEST) depth--;
    return (unsigned char)depth;
}

// The number of all parts, if bends count by so much.
static double count_parts(const Steps *s, double scale, MeshDepth *out) {
    const Mesh *mesh = s->mesh;
    double parts = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        double rho[3], bend = 0, close = scale * (double)s->solution->close[element->patch];
        rgb_doubles(mesh_material(mesh, element->face)->reflectance, rho);
        for (int c = 0; c < 3; c++) bend += scale * rho[c] * fabs(s->rest[e][c]) / s->light[e];
        const float *step = s->worst[e], *edge = s->edge[e];
        double along[2];
        for (int axis = 0; axis < 2; axis++)
            along[axis] =
                fmax(step[axis] * 2 < step[1 - axis] ? 0 : bend, EDGE_BEND * scale * (double)edge[axis]);
        out[e] = (MeshDepth){depth_for(mesh, element, 0, along[0], close),
                             depth_for(mesh, element, 1, along[1], close)};
        if (out[e].x + out[e].y > 0 && mesh_owns(mesh, element->face)) parts += ldexp(1, out[e].x + out[e].y);
    }
    if (s->borders) team_sum(borders_member(s->borders), &parts, 1);
    return parts;
}

// The number of those that gather without being halved, if what is apart counts by so much.
static double count_whole(const Steps *s, double scale, const ReflectedParts *out) {
    const Mesh *mesh = s->mesh;
    double whole = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        bool halved = out->halved[e].x + out->halved[e].y > 0;
        out->gathers[e] = halved || scale * (double)s->apart[e] > APART;
        whole += out->gathers[e] && !halved && mesh_owns(mesh, mesh->elements[e].face);
    }
    if (s->borders) team_sum(borders_member(s->borders), &whole, 1);
    return whole;
}

// ---- light at nodes

// Nodes at edges of faces that gather light by themselves.
typedef struct Edges {
    int count;
    int *node;             // [count]
    int *vertex;           // [count] as Nodes.vertex
    int *first, *element;  // [count + 1] in `element`: those that meet at each
    int *of;               // [nodes] the index in `node`, -1
} Edges;

// Where light is found that is shown on a finer mesh, the same for all light; and what the last light was there, if it is `kept`.
typedef struct ReflectedPlaces {
    Nodes own;              // of the mesh that light was found on
    int *triangle;          // of its elements
    int *in;                // [shown->element_count] the element around each
    int *part;              // [part_count] elements that gather light by themselves
    Edges edge[2];          // own nodes that do where no parts do, and nodes of parts on the finer mesh
    int part_count, count;  // all that gather are parts first, then edges of both kinds
    bool *anew;             // [nodes of the finer mesh] of parts
    int *which;             // [count] those that gather now
    // Values of the elements, and what strong patches send to the patches: at the elements, at own nodes and at corners.
    double (*coarse)[3], (*node[2])[3], (*corner[2])[3];
    double (*gathered)[3];  // [count] without what strong patches send
    bool *inside;           // [count] they look from within another thing
    double (*value)[3];     // [shown->element_count] at the middles
    // To go on from this light.
    bool kept, whole;  // `whole`: it was found to the end
    ValueFits elements, patches, parts;
    int *first_within, *within;         // the elements of the finer mesh in each element
    int *part_of;                       // [shown->element_count] its index in `part`, -1
    Marks changed[2], around, middles;  // elements, patches; elements; elements of the finer mesh
    Marks again;                        // those that gather now
} ReflectedPlaces;

typedef struct Parts {
    const GatherScene *scene;
    const Mesh *shown;
    const ReflectedPlaces *places;
    Gatherer **gatherer;   // [threads] NULL: all rows are there
    double (*leaving)[3];  // of gather_leaving
    int first;             // of this look
    PartRows *kept;        // or NULL
} Parts;

// The first edge of a kind among all that gather.
static int first_edge(const ReflectedPlaces *p, int kind) {
    return p->part_count + (kind == 0 ? 0 : p->edge[0].count);
}

// Where one of those that gather looks from, and the element of the mesh that light was found on around it.
static Vec3 place_of(const ReflectedPlaces *p, const Mesh *mesh, const Mesh *shown, int i, int *around) {
    if (i < p->part_count) {
        *around = p->in[p->part[i]];
        return element_centroid(shown, p->part[i]);
    }
    int kind = i >= first_edge(p, 1), k = i - first_edge(p, kind);
    const Edges *edges = &p->edge[kind];
    const Mesh *of = kind == 0 ? mesh : shown;
    Vec3 middle = {0, 0, 0};
    int first = edges->first[k], end = edges->first[k + 1];
    for (int j = first; j < end; j++) middle = vec3_add(middle, element_centroid(of, edges->element[j]));
    *around = kind == 0 ? edges->element[first] : p->in[edges->element[first]];
    return vec3_lerp(of->vertices[edges->vertex[k]], vec3_scale(middle, 1.0 / (end - first)), EDGE_IN);
}

static void gather_place(void *context, int index, int thread) {
    const Parts *p = context;
    const Mesh *mesh = p->scene->mesh;
    const Daylight *day = &p->scene->solution->day;
    int i = p->places->which[p->first + index], element;
    double *out = p->places->gathered[i], backs;
    GatherRow *row = p->kept ? &p->kept->row[i] : NULL;
    if (!row || !p->kept->there[i]) {
        Vec3 at = place_of(p->places, mesh, p->shown, i, &element);
        const Element *around = &mesh->elements[element];
        const Face *face = &mesh->faces[around->face];
        // Elements at an edge node may lie before several cells.
        bool before = i < p->places->part_count && mesh->graph->objects[face->object].kind == OBJECT_SURFACE;
        int hint = mesh->patches[around->patch].cell;
        int cell = before ? hint : gather_cell(mesh->graph, at, face->plane.n, hint);
        ViewPoint from = {at, face->plane.n, cell};
        if (row) {
            *row = gather_row_new(p->gatherer[thread], &from, &p->kept->kept[thread]);
            p->kept->leaf[i] = mesh->graph->objects[face->object].leaf;
            p->kept->there[i] = true;
        } else {
            gather_apart(p->gatherer[thread], &from, out, NULL, &backs);
        }
    }
    if (row) {
        gather_along(p->leaving, day, row, out);
        backs = row->backs;
    }
    p->places->inside[i] = backs > EDGE_BACKS;
}

void part_rows_end(PartRows *rows) {
    for (int t = 0; rows->gatherer && t < rows->thread_count; t++) gatherer_end(rows->gatherer[t]);
    for (int t = 0; rows->kept && t < rows->thread_count; t++) arena_free(&rows->kept[t]);
    arena_free(&rows->arena);
}

static Gatherer **gatherers_new(const GatherScene *scene, int threads, bool sky_parts, Arena *arena) {
    Gatherer **out = ARENA_ARRAY(arena, Gatherer *, threads + 1);
    GatherOptions options = gather_default_options();
    options.resolution = RESOLUTION;
    options.reflected = true;
    options.sky_parts = sky_parts;
    for (int t = 0; t < threads; t++) out[t] = gatherer_new(scene, &options, arena);
    return out;
}

// A row of the same day, in memory of its own. `words` of doors.
static GatherRow copy_row(const GatherRow *row, int words, Arena *arena) {
    GatherRow out = *row;
    int *element = ARENA_ARRAY(arena, int, row->count + 1);
    float *share = ARENA_ARRAY(arena, float, row->count + 1);
    uint64_t *doors = row->doors ? ARENA_ARRAY(arena, uint64_t, words + 1) : NULL;
    SkyPart *part = ARENA_ARRAY(arena, SkyPart, row->sky_part_count + 1);
    memcpy(element, row->element, (size_t)row->count * sizeof *element);
    memcpy(share, row->share, (size_t)row->count * sizeof *share);
    if (doors) memcpy(doors, row->doors, (size_t)words * sizeof *doors);
    if (row->sky_part_count > 0) memcpy(part, row->sky_part, (size_t)row->sky_part_count * sizeof *part);
    out.element = element;
    out.share = share;
    out.doors = doors;
    out.sky_part = part;
    return out;
}

// Takes over the rows of those that look from the same places as on the mesh that showed light before, under the day at hand.
static void take_rows(PartRows *rows, const PartRows *before) {
    const ReflectedPlaces *to = rows->places, *from = before->places;
    const Mesh *mesh = rows->scene.mesh;
    Arena scratch = {0};
    if (!from) return;
    int *first = ARENA_ARRAY(&scratch, int, mesh->element_count + 1),
        *next = ARENA_ARRAY(&scratch, int, from->count + 1), around;
    Vec3 *place = ARENA_ARRAY(&scratch, Vec3, from->count + 1);
    for (int e = 0; e < mesh->element_count; e++) first[e] = -1;
    for (int i = from->count - 1; i >= 0; i--) {
        place[i] = place_of(from, mesh, before->shown, i, &around);
        next[i] = first[around];
        first[around] = before->there[i] ? i : next[i];
    }
    for (int i = 0; i < to->count; i++) {
        Vec3 at = place_of(to, mesh, rows->shown, i, &around);
        int k = first[around];
        while (k >= 0 && vec3_length(vec3_sub(place[k], at)) > SAME_PLACE) k = next[k];
        if (k < 0) continue;
        GatherRow *row = &rows->row[i];
        *row = copy_row(&before->row[k], viewer_door_words(rows->shown), &rows->kept[0]);
        row->sky = sky_parts_light(row->sky_part, row->sky_part_count, &rows->solution.day);
        rows->leaf[i] = before->leaf[k];
        rows->there[i] = true;
    }
    arena_free(&scratch);
}

// Room for the rows of so many parts.
static void part_rows_start(PartRows *rows, const GatherScene *scene, const Mesh *shown, int count) {
    if (rows->row) return;
    rows->count = count;
    rows->shown = shown;
    rows->row = ARENA_ARRAY(&rows->arena, GatherRow, count + 1);
    rows->there = ARENA_ARRAY(&rows->arena, bool, count + 1);
    rows->leaf = ARENA_ARRAY(&rows->arena, int, count + 1);
    rows->kept = ARENA_ARRAY(&rows->arena, Arena, rows->thread_count);
    rows->solution = (RadSolution){.element_count = scene->solution->element_count,
                                   .radiosity = scene->solution->radiosity,
                                   .day = scene->solution->day};
    rows->scene = *scene;
    rows->scene.solution = &rows->solution;
    if (rows->before) take_rows(rows, rows->before);
    rows->before = NULL;
}

// Copies the rows that are there to memory of their own once as much again was used as at the last time.
static void close_gaps(PartRows *rows, int words) {
    size_t used = 0;
    for (int t = 0; t < rows->thread_count; t++) used += rows->kept[t].used;
    if (rows->used == 0) rows->used = used;
    if (used <= 2 * rows->used) return;
    Arena kept = {0};
    for (int i = 0; i < rows->count; i++) {
        GatherRow *row = &rows->row[i];
        if (!rows->there[i]) continue;
        *row = copy_row(row, words, &kept);
    }
    for (int t = 0; t < rows->thread_count; t++) arena_free(&rows->kept[t]);
    rows->kept[0] = kept;
    rows->used = kept.used;
}

// Light of `count` parts and edges of places->which.
static bool gather_parts(const GatherScene *scene, const Mesh *shown, const ReflectedPlaces *places,
                         int count, int threads, PartRows *kept, const Progress *progress) {
    Arena scratch = {0};
    threads = kept ? kept->thread_count : parallel_threads(threads);
    Parts p = {scene, shown, places, .kept = kept};
    bool makes = !kept;
    for (int i = 0; i < count && !makes; i++) makes = !kept->there[places->which[i]];
    if (kept) {
        GatherOptions options = gather_default_options();
        p.leaving = gather_leaving(scene, &options, &scratch);
    }
    if (makes && kept && !kept->gatherer) {
        kept->solution.radiosity = scene->solution->radiosity;
        kept->gatherer = gatherers_new(&kept->scene, threads, kept->sky_parts, &kept->arena);
    }
    if (makes) p.gatherer = kept ? kept->gatherer : gatherers_new(scene, threads, false, &scratch);
    bool go_on = true;
    for (; p.first < count && go_on; p.first += PARTS_A_LOOK) {
        go_on = progress_report(progress, "reflected light", (double)p.first / count);
        int left = count - p.first;
        if (go_on) parallel_for(threads, left < PARTS_A_LOOK ? left : PARTS_A_LOOK, gather_place, &p);
    }
    for (int t = 0; t < threads && makes && !kept; t++) gatherer_end(p.gatherer[t]);
    arena_free(&scratch);
    return go_on;
}

static bool part_moves(const PartRows *rows, const Mesh *shown, int i, const MovedDoors *moved) {
    const Mesh *mesh = rows->scene.mesh;
    int around;
    Vec3 at = place_of(rows->places, mesh, shown, i, &around),
         n = mesh->faces[mesh->elements[around].face].plane.n;
    for (int k = 0; k < moved->count; k++)
        if (view_has_door(rows->row[i].doors, moved->doors[k].opening) &&
            mesh_door_rises(&moved->doors[k], at, n))
            return true;
    return mesh_leaf_moves(moved, shown->graph->building, rows->leaf[i]);
}

int part_rows_move(PartRows *rows, const Mesh *shown, const MovedDoors *moved) {
    int dropped = 0;
    for (int i = 0; i < rows->count; i++) {
        if (!rows->there[i] || !part_moves(rows, shown, i, moved)) continue;
        rows->there[i] = false;
        dropped++;
    }
    for (int t = 0; rows->gatherer && t < rows->thread_count; t++) gatherer_pose(rows->gatherer[t]);
    if (rows->count > 0) close_gaps(rows, viewer_door_words(shown));
    return dropped;
}

// The elements of the finer mesh in each element, in their order.
static void find_within(ReflectedPlaces *p, const Mesh *mesh, const Mesh *shown, Arena *arena) {
    p->first_within = ARENA_ARRAY(arena, int, mesh->element_count + 2);
    p->within = ARENA_ARRAY(arena, int, shown->element_count + 1);
    int *next = p->first_within + 1;
    for (int e = 0; e < shown->element_count; e++) next[p->in[e] + 1]++;
    for (int e = 0; e < mesh->element_count; e++) next[e + 1] += next[e];
    for (int e = 0; e < shown->element_count; e++) p->within[next[p->in[e]]++] = e;
}

// Does the light end at a node, on the side of its elements?
static bool at_edge(const Mesh *mesh, const Nodes *nodes, int n) {
    double angle = 0;
    Vec3 at = mesh->vertices[nodes->vertex[n]];
    for (int i = nodes->first[n]; i < nodes->first[n + 1]; i++) {
        const Element *e = &mesh->elements[nodes->element[i]];
        const int *corner = mesh->corners + e->first_corner;
        for (int k = 0; k < e->corner_count; k++) {
            if (nodes->of_corner[e->first_corner + k] != n) continue;
            int next = corner[(k + 1) % e->corner_count],
                last = corner[(k + e->corner_count - 1) % e->corner_count];
            Vec3 a = vec3_sub(mesh->vertices[next], at), b = vec3_sub(mesh->vertices[last], at);
            angle += atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
        }
    }
    return angle < ALL_AROUND;
}

// Where nodes are looked for that are to gather.
typedef struct EdgeSearch {
    const GatherScene *scene;
    const Mesh *mesh;  // whose nodes they are
    const Nodes *nodes;
    const int *
        in;  // [element_count] the element around each of the mesh that light was found on; NULL: that mesh itself
    const bool *but_of;  // [element_count] nodes of these alone are left out; NULL: none
    const bool *wanted;  // [nodes->count]; NULL: all
    double least;        // area of an element, m^2
    const Borders *borders;
} EdgeSearch;

// The largest element at a node, m^2; 0: the node is not to gather.
static double edge_area(const EdgeSearch *s, int n) {
    const Mesh *mesh = s->mesh;
    double area = 0, close = 0;
    bool owned = false, all_left = s->but_of != NULL;
    if (s->wanted && !s->wanted[n]) return 0;
    for (int i = s->nodes->first[n]; i < s->nodes->first[n + 1]; i++) {
        int e = s->nodes->element[i], around = s->in ? s->in[e] : e;
        area = fmax(area, mesh->elements[e].area);
        close = fmax(close, (double)s->scene->solution->close[s->scene->mesh->elements[around].patch]);
        owned = owned || mesh_owns(mesh, mesh->elements[e].face);
        all_left = all_left && s->but_of[e];
    }
    bool gathers = owned && !all_left && area >= s->least && close >= EDGE_CLOSE;
    return gathers && at_edge(mesh, s->nodes, n) ? area : 0;
}

// Those of large elements first, as many as may gather.
static Edges find_edges(const EdgeSearch *s, Arena *arena) {
    const Nodes *nodes = s->nodes;
    const Mesh *mesh = s->scene->mesh;
    Arena scratch = {0};
    double *area = ARENA_ARRAY(&scratch, double, nodes->count + 1), least = s->least, counts[2];
    Edges out = {.of = ARENA_ARRAY(arena, int, nodes->count + 1)};
    for (int n = 0; n < nodes->count; n++) area[n] = edge_area(s, n);
    for (;; least *= 1.25) {
        counts[0] = counts[1] = 0;
        for (int n = 0; n < nodes->count; n++) counts[0] += area[n] >= least;
        for (int i = 0; i < mesh->patch_count; i++) counts[1] += mesh_owns(mesh, mesh->patches[i].face);
        if (s->borders) team_sum(borders_member(s->borders), counts, 2);
        if (counts[0] <= MOST_EDGES * counts[1]) break;
    }
    int elements = 0;
    for (int n = 0; n < nodes->count; n++) {
        bool gathers = area[n] >= least;
        out.of[n] = gathers ? out.count : -1;
        out.count += gathers;
        elements += gathers ? nodes->first[n + 1] - nodes->first[n] : 0;
    }
    out.node = ARENA_ARRAY(arena, int, out.count + 1);
    out.vertex = ARENA_ARRAY(arena, int, out.count + 1);
    out.first = ARENA_ARRAY(arena, int, out.count + 1);
    out.element = ARENA_ARRAY(arena, int, elements + 1);
    for (int n = 0; n < nodes->count; n++) {
        int k = out.of[n], count = nodes->first[n + 1] - nodes->first[n];
        if (k < 0) continue;
        out.node[k] = n;
        out.vertex[k] = nodes->vertex[n];
        out.first[k + 1] = out.first[k] + count;
        memcpy(out.element + out.first[k], nodes->element + nodes->first[n], (size_t)count * sizeof(int));
    }
    arena_free(&scratch);
    return out;
}

static Edges no_edges(const Nodes *nodes, Arena *arena) {
    Edges out = {.of = ARENA_ARRAY(arena, int, nodes->count + 1)};
    for (int n = 0; n < nodes->count; n++) out.of[n] = -1;
    return out;
}

static ReflectedPlaces *places_of(const GatherScene *scene, const bool *gathers, const Mesh *shown,
                                  const Nodes *nodes, const Borders *borders, bool kept, Arena *arena) {
    const Mesh *mesh = scene->mesh;
    ReflectedPlaces *p = ARENA_ARRAY(arena, ReflectedPlaces, 1);
    p->own = nodes_of(mesh, arena);
    p->triangle = reconstruct_triangles(mesh, arena);
    p->in = ARENA_ARRAY(arena, int, shown->element_count + 1);
    p->part = ARENA_ARRAY(arena, int, shown->element_count + 1);
    p->part_of = ARENA_ARRAY(arena, int, shown->element_count + 1);
    p->anew = ARENA_ARRAY(arena, bool, nodes->count + 1);
    for (int e = 0; e < shown->element_count; e++) {
        const Element *element = &shown->elements[e];
        p->in[e] = shown_around(mesh, shown, e);
        p->part_of[e] = -1;
        if (!gathers || !gathers[p->in[e]]) continue;
        if (mesh_owns(shown, element->face)) {
            p->part_of[e] = p->part_count;
            p->part[p->part_count++] = e;
        }
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++)
            p->anew[nodes->of_corner[c]] = true;
    }
    EdgeSearch of_own = {.scene = scene,
                         .mesh = mesh,
                         .nodes = &p->own,
                         .but_of = gathers,
                         .least = EDGE_AREA[0],
                         .borders = borders},
               of_parts = {.scene = scene,
                           .mesh = shown,
                           .nodes = nodes,
                           .in = p->in,
                           .wanted = p->anew,
                           .least = EDGE_AREA[1],
                           .borders = borders};
    p->edge[0] = gathers ? find_edges(&of_own, arena) : no_edges(&p->own, arena);
    p->edge[1] = gathers ? find_edges(&of_parts, arena) : no_edges(nodes, arena);
    p->count = p->part_count + p->edge[0].count + p->edge[1].count;
    p->which = ARENA_ARRAY(arena, int, p->count + 1);
    p->inside = ARENA_ARRAY(arena, bool, p->count + 1);
    p->coarse = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *p->coarse);
    p->gathered = arena_alloc(arena, (size_t)p->count + 1, sizeof *p->gathered);
    p->value = arena_alloc(arena, (size_t)shown->element_count + 1, sizeof *p->value);
    for (int i = 0; i < 2; i++) {
        p->node[i] = arena_alloc(arena, (size_t)p->own.count + 1, sizeof *p->node[i]);
        p->corner[i] = arena_alloc(arena, (size_t)mesh->corner_count + 1, sizeof *p->corner[i]);
    }
    if (!kept) return p;
    p->kept = true;
    p->elements.arena = p->patches.arena = p->parts.arena = arena;
    find_within(p, mesh, shown, arena);
    p->changed[0] = marks_new(mesh->element_count, arena);
    p->changed[1] = marks_new(mesh->patch_count, arena);
    p->around = marks_new(mesh->element_count, arena);
    p->middles = marks_new(shown->element_count, arena);
    p->again = marks_new(p->count, arena);
    return p;
}

// Light between the nodes of the mesh that it was found on.
typedef struct Between {
    const Mesh *mesh, *shown;
    const Nodes *nodes;
    const ReflectedPlaces *places;
    VertexLight light, by_strong;
    double (*out)[3];  // [nodes->count]
} Between;

static Between between_of(const Mesh *mesh, const Mesh *shown, const Nodes *nodes, const ReflectedPlaces *p,
                          double (*out)[3]) {
    return (Between){mesh,
                     shown,
                     nodes,
                     p,
                     {.corner = p->corner[0], .triangle = p->triangle},
                     {.corner = p->corner[1], .triangle = p->triangle},
                     out};
}

// Elements or nodes that one thread takes at a time.
enum { AT_A_TIME = 2048 };

static int times(int count) { return (count + AT_A_TIME - 1) / AT_A_TIME; }

// Light at the middle of an element of the finer mesh.
static void light_middle(const Between *b, int e) {
    const ReflectedPlaces *p = b->places;
    Vec3 middle = element_centroid(b->shown, e);
    int part = p->part_of[e];
    // A covered element stays so in its parts: light between its nodes would say that they are half lit.
    memset(p->value[e], 0, sizeof *p->value);
    if (!(rgb_sum(p->coarse[p->in[e]]) > 0)) return;
    reconstruct_in(b->mesh, part < 0 ? &b->light : &b->by_strong, p->in[e], middle, p->value[e]);
    for (int c = 0; c < 3 && part >= 0; c++) p->value[e][c] += p->gathered[part][c];
}

static void light_middles(void *context, int index, int thread) {
    const Between *b = context;
    int first = index * AT_A_TIME, end = first + AT_A_TIME;
    (void)thread;
    for (int e = first; e < end && e < b->shown->element_count; e++) light_middle(b, e);
}

static void light_node(const Between *b, int n) {
    const Nodes *nodes = b->nodes;
    if (b->places->anew[n]) return;
    reconstruct_in(b->mesh, &b->light, b->places->in[nodes->element[nodes->first[n]]],
                   b->shown->vertices[nodes->vertex[n]], b->out[n]);
}

static void light_nodes(void *context, int index, int thread) {
    const Between *b = context;
    int first = index * AT_A_TIME, end = first + AT_A_TIME;
    (void)thread;
    for (int n = first; n < end && n < b->nodes->count; n++) light_node(b, n);
}

// The solution without what strong patches reflect, which parts have as it is around them.
static RadSolution weak_light(const Mesh *mesh, const RadSolution *solution, Arena *arena) {
    RadSolution weak = *solution;
    weak.radiosity = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *weak.radiosity);
    for (int e = 0; e < mesh->element_count; e++) {
        if (!weak.strong[mesh->elements[e].patch])
            memcpy(weak.radiosity[e], solution->radiosity[e], sizeof *weak.radiosity);
        else
            rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, weak.radiosity[e]);
    }
    return weak;
}

// Values at the nodes of the mesh that light was found on, at its corners. `which`: 0, those of elements; 1, those of patches.
static void light_corners(const Mesh *mesh, ReflectedPlaces *p, int which, double (*value)[3]) {
    ValueFits *fits = which == 0 ? &p->elements : &p->patches;
    reconstruct_values(mesh, &p->own, which == 1, value, NULL, p->node[which], NULL, p->kept ? fits : NULL);
    for (int i = 0; i < mesh->corner_count; i++)
        memcpy(p->corner[which][i], p->node[which][p->own.of_corner[i]], sizeof *p->corner[which]);
}

// The light of an edge node: as it has gathered it, and of strong patches as it is between the node and the middle of its elements. Where
// no light reaches the elements, and within another thing, the node keeps what the planes say.
static void light_edge(const GatherScene *scene, ReflectedPlaces *p, int i) {
    const Mesh *mesh = scene->mesh;
    const Nodes *own = &p->own;
    int n = p->edge[0].node[i - p->part_count], first = own->first[n], end = own->first[n + 1];
    double light = 0, sent[3] = {0, 0, 0};
    for (int k = first; k < end; k++) {
        const double *by_strong = scene->solution->sent[mesh->elements[own->element[k]].patch];
        light += rgb_sum(p->coarse[own->element[k]]);
        for (int c = 0; c < 3; c++) sent[c] += by_strong[c] / (end - first);
    }
    if (p->inside[i] || !(light > 0)) return;
    for (int c = 0; c < 3; c++)
        p->node[0][n][c] = p->gathered[i][c] + fmax((1 - EDGE_IN) * p->node[1][n][c] + EDGE_IN * sent[c], 0);
    for (int k = first; k < end; k++) {
        const Element *e = &mesh->elements[own->element[k]];
        for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
            if (own->of_corner[c] == n) memcpy(p->corner[0][c], p->node[0][n], sizeof *p->corner[0]);
    }
}

// The same of an edge node of parts, into `out` [nodes of the finer mesh].
static void light_part_edge(const GatherScene *scene, const Mesh *shown, const ReflectedPlaces *p, int i,
                            double (*out)[3]) {
    const Edges *edges = &p->edge[1];
    const VertexLight by_strong = {.corner = p->corner[1], .triangle = p->triangle};
    int k = i - first_edge(p, 1), around;
    double light = 0, strong[3];
    for (int j = edges->first[k]; j < edges->first[k + 1]; j++)
        light += rgb_sum(p->coarse[p->in[edges->element[j]]]);
    if (p->inside[i] || !(light > 0)) return;
    Vec3 at = place_of(p, scene->mesh, shown, i, &around);
    reconstruct_in(scene->mesh, &by_strong, around, at, strong);
    for (int c = 0; c < 3; c++) out[edges->node[k]][c] = p->gathered[i][c] + fmax(strong[c], 0);
}

// How far light beside edges is off that of the elements there.
static void find_edge_steps(Steps *s, const GatherScene *scene, const Nodes *nodes, int threads,
                            Arena *arena) {
    const Mesh *mesh = s->mesh;
    ReflectedPlaces p = {.own = *nodes, .coarse = s->value};
    s->edge = arena_alloc(arena, (size_t)mesh->element_count + 1, sizeof *s->edge);
    EdgeSearch all = {
        .scene = scene, .mesh = mesh, .nodes = nodes, .least = EDGE_AREA[0], .borders = s->borders};
    p.edge[0] = find_edges(&all, arena);
    p.count = p.edge[0].count;
    p.which = ARENA_ARRAY(arena, int, p.count + 1);
    p.inside = ARENA_ARRAY(arena, bool, p.count + 1);
    p.gathered = arena_alloc(arena, (size_t)p.count + 1, sizeof *p.gathered);
    for (int i = 0; i < 2; i++) {
        p.node[i] = arena_alloc(arena, (size_t)nodes->count + 1, sizeof *p.node[i]);
        p.corner[i] = arena_alloc(arena, (size_t)mesh->corner_count + 1, sizeof *p.corner[i]);
    }
    for (int i = 0; i < p.count; i++) p.which[i] = i;
    RadSolution weak = weak_light(mesh, scene->solution, arena);
    GatherScene weak_scene = *scene;
    weak_scene.solution = &weak;
    reconstruct_values(mesh, nodes, true, scene->solution->sent, NULL, p.node[1], NULL, NULL);
    gather_parts(&weak_scene, mesh, &p, p.count, threads, NULL, NULL);
    for (int i = 0; i < p.count; i++) {
        int n = p.edge[0].node[i], around;
        Vec3 in = vec3_sub(place_of(&p, mesh, mesh, i, &around), mesh->vertices[nodes->vertex[n]]);
        light_edge(scene, &p, i);
        if (!(rgb_sum(p.node[0][n]) > 0)) continue;
        for (int k = nodes->first[n]; k < nodes->first[n + 1]; k++) {
            int e = nodes->element[k];
            const Face *face = &mesh->faces[mesh->elements[e].face];
            double rho[3], step = 0;
            rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->reflectance, rho);
            for (int c = 0; c < 3; c++) step += rho[c] * fabs(p.node[0][n][c] - s->value[e][c]);
            // The way in from the edge, which is the mean of those to the middles, is across it.
            int axis =
                fabs(vec3_dot(vec3_normalize(face->gy), in)) > fabs(vec3_dot(vec3_normalize(face->gx), in));
            s->edge[e][axis] = fmaxf(s->edge[e][axis], (float)(step / s->light[e]));
        }
    }
}

ReflectedParts reflected_parts(const GatherScene *scene, const Nodes *nodes, int threads,
                               const Borders *borders, Arena *arena) {
    Arena scratch = {0};
    const Mesh *mesh = scene->mesh;
    const RadSolution *solution = scene->solution;
    RadSolution even = reconstruct_even(mesh, solution, &scratch);
    Steps s = {.mesh = mesh, .solution = &even, .borders = borders};
    ReflectedParts out = {ARENA_ARRAY(arena, MeshDepth, mesh->element_count + 1),
                          ARENA_ARRAY(arena, bool, mesh->element_count + 1)};
    s.worst = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *s.worst);
    s.value = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *s.value);
    find_values(mesh, &even, s.value);
    find_shown_light(&s, &scratch);
    find_apart(&s, &scratch);
    find_edge_steps(&s, scene, nodes, threads, &scratch);
    double(*node)[3] = arena_alloc(&scratch, (size_t)nodes->count + 1, sizeof *node);
    s.rest = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *s.rest);
    reconstruct_values(mesh, nodes, false, s.value, NULL, node, s.rest, NULL);
    for (int n = 0; n < nodes->count; n++)
        for (int i = nodes->first[n]; i < nodes->first[n + 1]; i++)
            for (int k = i + 1; k < nodes->first[n + 1]; k++)
                take_step(&s, nodes->element[i], nodes->element[k]);
    double scale = 1, patches = 0;
    for (int p = 0; p < mesh->patch_count; p++) patches += mesh_owns(mesh, mesh->patches[p].face);
    if (borders) team_sum(borders_member(borders), &patches, 1);
    while (count_parts(&s, scale, out.halved) > MOST_PARTS * patches) scale *= 0.8;
    scale = 1;
    while (count_whole(&s, scale, &out) > MOST_APART * patches) scale *= 0.8;
    arena_free(&scratch);
    return out;
}

bool reflected_nodes(const GatherScene *scene, const bool *gathers, const Mesh *shown, const Nodes *nodes,
                     int threads, PartRows *kept, const Borders *borders, const Progress *progress,
                     double (*out)[3]) {
    const Mesh *mesh = scene->mesh;
    Arena scratch = {0};
    RadSolution even = reconstruct_even(mesh, scene->solution, &scratch);
    if (shown == mesh) {
        double(*value)[3] = arena_alloc(&scratch, (size_t)mesh->element_count + 1, sizeof *value);
        find_values(mesh, &even, value);
        reconstruct_values(mesh, nodes, false, value, NULL, out, NULL, NULL);
        arena_free(&scratch);
        return true;
    }
    ReflectedPlaces *places = kept && kept->places ? kept->places
                                                   : places_of(scene, gathers, shown, nodes, borders,
                                                               kept != NULL, kept ? &kept->arena : &scratch);
    if (kept) {
        kept->places = places;
        part_rows_start(kept, scene, shown, places->count);
    }
    places->whole = false;
    nodes_pose(&places->own, mesh);
    find_values(mesh, &even, places->coarse);
    light_corners(mesh, places, 0, places->coarse);
    light_corners(mesh, places, 1, scene->solution->sent);
    int workers = parallel_threads(threads);
    RadSolution weak = weak_light(mesh, scene->solution, &scratch);
    GatherScene weak_scene = *scene;
    weak_scene.solution = &weak;
    for (int i = 0; i < places->count; i++) places->which[i] = i;
    bool go_on = gather_parts(&weak_scene, shown, places, places->count, threads, kept, progress);
    for (int i = first_edge(places, 0); i < first_edge(places, 1) && go_on; i++) light_edge(scene, places, i);
    Between between = between_of(mesh, shown, nodes, places, out);
    parallel_for(workers, times(shown->element_count), light_middles, &between);
    if (borders) {
        go_on = !team_any(borders_member(borders), !go_on);
        borders_fetch(borders, &BORDER_VALUE(BORDER_ELEMENT, places->value), 1);
    }
    if (go_on)
        reconstruct_values(shown, nodes, false, places->value, places->anew, out, NULL,
                           places->kept ? &places->parts : NULL);
    parallel_for(workers, times(nodes->count), light_nodes, &between);
    for (int i = first_edge(places, 1); i < places->count && go_on; i++)
        light_part_edge(scene, shown, places, i, out);
    places->whole = go_on;
    arena_free(&scratch);
    return go_on;
}

// ---- light that goes on

bool reflected_goes_on(const PartRows *kept) { return kept->places && kept->places->whole; }

static void corners_again(const Mesh *mesh, ReflectedPlaces *p, int which, double (*value)[3]) {
    ValueFits *fits = which == 0 ? &p->elements : &p->patches;
    const Nodes *own = &p->own;
    reconstruct_values_again(mesh, own, which == 1, value, NULL, &p->changed[which], p->node[which], fits);
    for (int i = 0; i < fits->nodes.count; i++) {
        int n = fits->nodes.of[i];
        if (p->edge[0].of[n] >= 0) marks_add(&p->again, first_edge(p, 0) + p->edge[0].of[n]);
        for (int k = own->first[n]; k < own->first[n + 1]; k++) {
            const Element *e = &mesh->elements[own->element[k]];
            marks_add(&p->around, own->element[k]);
            for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++)
                if (own->of_corner[c] == n)
                    memcpy(p->corner[which][c], p->node[which][n], sizeof *p->corner[which]);
        }
    }
}

// The elements whose light depends on one that gathers.
static void mark_around(ReflectedPlaces *p, int i) {
    if (i < p->part_count) {
        marks_add(&p->around, p->in[p->part[i]]);
        return;
    }
    int n = p->edge[0].node[i - first_edge(p, 0)];
    for (int k = p->own.first[n]; k < p->own.first[n + 1]; k++) marks_add(&p->around, p->own.element[k]);
}

// Edge nodes of parts, whose light was found anew from the values of parts, or whose rows were dropped, gather again.
static bool part_edges_again(const GatherScene *scene, const GatherScene *weak, const Mesh *shown,
                             PartRows *kept, const Progress *progress, double (*out)[3], Marks *found) {
    ReflectedPlaces *p = kept->places;
    const Edges *edges = &p->edge[1];
    const int first = first_edge(p, 1);
    marks_clear(&p->again);
    for (int i = 0; i < p->parts.nodes.count; i++)
        if (edges->of[p->parts.nodes.of[i]] >= 0)
            marks_add(&p->again, first + edges->of[p->parts.nodes.of[i]]);
    for (int i = first; i < p->count; i++)
        if (!kept->there[i]) marks_add(&p->again, i);
    for (int i = 0; i < p->again.count; i++) p->which[i] = p->again.of[i];
    if (!gather_parts(weak, shown, p, p->again.count, 0, kept, progress)) return false;
    for (int i = 0; i < p->again.count; i++) {
        light_part_edge(scene, shown, p, p->again.of[i], out);
        marks_add(found, edges->node[p->again.of[i] - first]);
    }
    return true;
}

bool reflected_again(const GatherScene *scene, const Mesh *shown, const Nodes *nodes, const Marks *changed,
                     PartRows *kept, const Progress *progress, double (*out)[3], Marks *found) {
    const Mesh *mesh = scene->mesh;
    ReflectedPlaces *p = kept->places;
    Arena scratch = {0};
    RadSolution even = reconstruct_even(mesh, scene->solution, &scratch),
                weak = weak_light(mesh, scene->solution, &scratch);
    GatherScene weak_scene = *scene;
    weak_scene.solution = &weak;
    p->whole = false;
    nodes_pose(&p->own, mesh);
    for (int i = 0; i < 2; i++) marks_clear(&p->changed[i]);
    marks_clear(&p->around);
    marks_clear(&p->middles);
    marks_clear(&p->again);
    for (int i = 0; i < changed->count; i++) {
        const Patch *patch = &mesh->patches[changed->of[i]];
        find_patch_values(mesh, &even, changed->of[i], p->coarse);
        marks_add(&p->changed[1], changed->of[i]);
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            marks_add(&p->changed[0], e);
    }
    corners_again(mesh, p, 0, p->coarse);
    corners_again(mesh, p, 1, scene->solution->sent);
    for (int i = 0; i < first_edge(p, 1); i++) {
        bool part = i < p->part_count && changed->has[mesh->elements[p->in[p->part[i]]].patch];
        if (part || !kept->there[i]) marks_add(&p->again, i);
    }
    for (int i = 0; i < p->again.count; i++) {
        p->which[i] = p->again.of[i];
        mark_around(p, p->which[i]);
    }
    bool go_on = gather_parts(&weak_scene, shown, p, p->again.count, 0, kept, progress);
    for (int i = 0; i < p->again.count && go_on; i++)
        if (p->again.of[i] >= p->part_count) light_edge(scene, p, p->again.of[i]);
    Between between = between_of(mesh, shown, nodes, p, out);
    for (int i = 0; i < p->around.count && go_on; i++) {
        int e = p->around.of[i];
        for (int k = p->first_within[e]; k < p->first_within[e + 1]; k++)
            marks_add(&p->middles, p->within[k]);
    }
    for (int i = 0; i < p->middles.count; i++) light_middle(&between, p->middles.of[i]);
    if (go_on) reconstruct_values_again(shown, nodes, false, p->value, p->anew, &p->middles, out, &p->parts);
    for (int i = 0; i < p->parts.nodes.count && go_on; i++)
        if (p->anew[p->parts.nodes.of[i]]) marks_add(found, p->parts.nodes.of[i]);
    for (int i = 0; i < p->middles.count; i++) {
        const Element *e = &shown->elements[p->middles.of[i]];
        for (int c = e->first_corner; c < e->first_corner + e->corner_count; c++) {
            int n = nodes->of_corner[c];
            if (found->has[n]) continue;
            light_node(&between, n);
            marks_add(found, n);
        }
    }
    go_on = go_on && part_edges_again(scene, &weak_scene, shown, kept, progress, out, found);
    p->whole = go_on;
    arena_free(&scratch);
    return go_on;
}
