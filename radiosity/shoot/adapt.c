// adapt.c - meshes fitted to the light on them (Cohen, Greenberg, Immel & Brock 1986: adaptive subdivision).
//
// A first, rough solution tells how fast reflected light changes. That of lamps alone changes faster, at the edges of shadows, but
// lamps are few: they shoot again on the finer mesh, until its elements are small where they must be. How fast light changes
// is told by the steps between neighbouring elements of a face.
#include "radiosity/shoot/adapt.h"

#include <math.h>
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "radiosity/mesh/mesh.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/shoot/sunlight.h"

// Light on the elements of a mesh that has splits.
typedef struct AdaptField {
    const Mesh *mesh;
    const double *light;  // [element_count]
    double (*slope)[2];   // [element_count] its change along the face's grid, a metre
    double (*error)
        [2];  // [element_count] integral of the square of what its constant does not tell, by either slope
} AdaptField;

// How deep elements are to be where those of the mesh are, [element_count], so that about `most` tell the light with the
// least sum of squares; none smaller than `smallest` metres, nor more than `deeper` times split beyond those that there are.
// `halves`: squares, which those of the mesh must be, may be cut into rectangles.
typedef struct AdaptLimits {
    double most, smallest;
    int deeper;
    bool halves;
    TeamMember *member;  // `most` is of all parts of the building; NULL: of the whole of it
} AdaptLimits;

// ---- how deep quadtrees over a lit mesh are worth being: of all their prunings that which tells the light best with so
// many elements.
//
// The light within a node that a constant does not tell is known from the elements below it; of an element it is guessed from
// the slope of light there, by which each split takes three quarters. A leaf costs the same wherever it is: where the sum of squares
// and of costs is least, from the leaves upwards, no other tree with as many leaves tells more (Breiman, Friedman, Olshen & Stone
// 1984, chapter 10: minimal cost-complexity pruning). The cost is found that leaves as many elements as there may be.

// ---- slopes

// Facts about an element's slope along one axis.
typedef struct Steps {
    double sum, squares, weight;
} Steps;

static void add_step(Steps *s, double slope, double weight) {
    s->sum += slope * weight;
    s->squares += slope * slope * weight;
    s->weight += weight;
}

// Edges of an element along the grid, metres.
static double edge_along(const Mesh *mesh, const Element *e, int axis) {
    const Face *face = &mesh->faces[e->face];
    return axis == 0 ? ldexp(face->root / vec3_length(face->gx), -e->depth.x)
                     : ldexp(face->root / vec3_length(face->gy), -e->depth.y);
}

// The element that stands for a square: the largest that light reaches, -1: none. The others are covered.
static int seen_in(const AdaptField *f, int square) {
    const Mesh *mesh = f->mesh;
    int code = mesh->squares[square];
    if (code >= -1) return code >= 0 && f->light[code] > 0 ? code : -1;
    const int *several = mesh->shared + ~(code + 1);
    for (int i = 1; i <= several[0]; i++)
        if (f->light[several[i]] > 0) return several[i];
    return -1;
}

static void add_steps(const AdaptField *f, int here, int there, int axis, Steps (*steps)[2]) {
    if (here < 0 || there < 0 || here == there) return;
    const Mesh *mesh = f->mesh;
    const Element *p = &mesh->elements[here], *q = &mesh->elements[there];
    double apart = 0.5 * (edge_along(mesh, p, axis) + edge_along(mesh, q, axis));
    double slope = (f->light[there] - f->light[here]) / apart;
    add_step(&steps[here][axis], slope, 1);
    add_step(&steps[there][axis], slope, 1);
}

static void find_steps(const AdaptField *f, const Face *face, Steps (*steps)[2]) {
    for (int j = 0; j < face->ny; j++) {
        for (int i = 0; i < face->nx; i++) {
            int at = face->first_square + j * face->nx + i, here = seen_in(f, at);
            if (i + 1 < face->nx) add_steps(f, here, seen_in(f, at + 1), 0, steps);
            if (j + 1 < face->ny) add_steps(f, here, seen_in(f, at + face->nx), 1, steps);
        }
    }
}

static void take_steps(const AdaptField *f, int e, const Steps steps[2]) {
    const Mesh *mesh = f->mesh;
    for (int axis = 0; axis < 2; axis++) {
        const Steps *s = &steps[axis];
        if (s->weight == 0) continue;
        double edge = edge_along(mesh, &mesh->elements[e], axis);
        f->slope[e][axis] = s->sum / s->weight;
        f->error[e][axis] = mesh->elements[e].area * s->squares / s->weight * edge * edge / 12;
    }
}

// Faces that a thread takes at a time: light on one says nothing of the next.
enum { FACES_A_GROUP = 64 };

static int group_count(const Mesh *mesh) { return (mesh->face_count + FACES_A_GROUP - 1) / FACES_A_GROUP; }

static int end_of_group(const Mesh *mesh, int group) {
    int end = (group + 1) * FACES_A_GROUP;
    return end < mesh->face_count ? end : mesh->face_count;
}

typedef struct Measuring {
    const AdaptField *field;
    Steps (*steps)[2];  // [element_count]
} Measuring;

static void measure_group(void *context, int group, int thread) {
    (void)thread;
    const Measuring *m = context;
    const Mesh *mesh = m->field->mesh;
    for (int k = group * FACES_A_GROUP; k < end_of_group(mesh, group); k++) {
        const Face *face = &mesh->faces[k];
        find_steps(m->field, face, m->steps);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            take_steps(m->field, e, m->steps[e]);
    }
}

static AdaptField adapt_field(const Mesh *mesh, const double *light, Arena *arena) {
    AdaptField f = {mesh, light, arena_alloc(arena, (size_t)mesh->element_count, sizeof *f.slope),
                    arena_alloc(arena, (size_t)mesh->element_count, sizeof *f.error)};
    Arena scratch = {0};
    Measuring m = {&f, arena_alloc(&scratch, (size_t)mesh->element_count, sizeof *m.steps)};
    parallel_for(parallel_threads(mesh->options.threads), group_count(mesh), measure_group, &m);
    arena_free(&scratch);
    return f;
}

// ---- trees

// The light of some squares as a constant would tell it.
typedef struct Moments {
    double area, mean, error;
} Moments;

typedef struct Node {
    int first_child;  // of four, row by row; -1: an element, or nothing
    int element;      // -1: the face is not there, or has children
    Moments all;
    // Errors of its halves, by the axis that is halved, and which; below 0: nothing is there.
    double half[2][2];
    double slope_error[2];  // of an element, by the slope along either axis
    int most;               // how often it may be halved along each
    // Its worth. For an element, how often it is halved along each axis. Else, which axis is halved first, -1: none, and which
    // halves are halved again.
    MeshDepth depth;
    int axis;
    bool again[2];
    double count;  // leaves below it
} Node;

// Trees are pruned for so many costs of a leaf at a time: parts of a building are woken once for all of these.
enum { MOST_COSTS = 16 };

// Those of a group of faces.
typedef struct Trees {
    const AdaptField *field;
    const AdaptLimits *limits;
    Node *nodes;  // children after their parents
    int count, capacity;
    int *roots, root_count, root_capacity;  // below 0: ~ the root of a face of another part of the building
    double *below;              // [count] the least sum of squares and costs of each as it was pruned last
    double leaves[MOST_COSTS];  // of faces of this part, for each cost
    Arena arena;
} Trees;

typedef struct Forest {
    const Mesh *mesh;
    Trees *groups;  // [group_count]
    double cost[MOST_COSTS];
    int costs;
    TeamMember *member;  // of a part of a building, or NULL
} Forest;

static int root_of(const Trees *t, int r) { return t->roots[r] < 0 ? ~t->roots[r] : t->roots[r]; }

static void each_group(Forest *forest, void (*body)(void *context, int group, int thread)) {
    parallel_for(parallel_threads(forest->mesh->options.threads), group_count(forest->mesh), body, forest);
}

static Moments join_moments(Moments a, const Moments *b) {
    if (b->area == 0) return a;
    double area = a.area + b->area, off = b->mean - a.mean;
    return (Moments){area, a.mean + off * b->area / area,
                     a.error + b->error + off * off * a.area * b->area / area};
}

static const Node *child_of(const Trees *t, const Node *n, int axis, int half, int k) {
    return &t->nodes[n->first_child + (axis == 0 ? half + 2 * k : 2 * half + k)];
}

typedef struct Block {
    int i, j, side;
} Block;

// The deepest element that is seen in a block of squares, -1: none.
static int deepest_in(const AdaptField *field, const Face *face, Block b) {
    const Mesh *mesh = field->mesh;
    int best = -1;
    for (int j = b.j; j < b.j + b.side; j++) {
        for (int i = b.i; i < b.i + b.side; i++) {
            int e = seen_in(field, face->first_square + j * face->nx + i);
            if (e >= 0 && (best < 0 || mesh->elements[e].depth.x > mesh->elements[best].depth.x)) best = e;
        }
    }
    return best;
}

static int most_splits(const Trees *t, const Element *e) {
    const Mesh *mesh = t->field->mesh;
    double edge = sqrt(edge_along(mesh, e, 0) * edge_along(mesh, e, 1));
    int splits = 0;
    while (splits < t->limits->deeper && e->depth.x + splits < MESH_DEEPEST &&
           ldexp(edge, -splits - 1) >= t->limits->smallest)
        splits++;
    return splits;
}

static void fill_node(Trees *t, int at, const Face *face, Block b, int depth) {
    const Mesh *mesh = t->field->mesh;
    int element = deepest_in(t->field, face, b);
    t->nodes[at] = (Node){.first_child = -1, .element = element};
    if (element < 0) return;
    if (b.side == 1 || mesh->elements[element].depth.x <= depth) {
        const double *error = t->field->error[element];
        t->nodes[at].all =
            (Moments){mesh->elements[element].area, t->field->light[element], error[0] + error[1]};
        t->nodes[at].most = most_splits(t, &mesh->elements[element]);
        memcpy(t->nodes[at].slope_error, error, sizeof t->nodes[at].slope_error);
        return;
    }
    int first = t->count, half = b.side / 2;
    for (int k = 0; k < 4; k++) *ARENA_PUSH(&t->arena, t->nodes, t->count, t->capacity) = (Node){0};
    Node sum = {.first_child = first, .element = -1};
    for (int k = 0; k < 4; k++) {
        fill_node(t, first + k, face, (Block){b.i + k % 2 * half, b.j + k / 2 * half, half}, depth + 1);
        sum.all = join_moments(sum.all, &t->nodes[first + k].all);
    }
    for (int axis = 0; axis < 2; axis++) {
        for (int side = 0; side < 2; side++) {
            Moments whole =
                join_moments(child_of(t, &sum, axis, side, 0)->all, &child_of(t, &sum, axis, side, 1)->all);
            sum.half[axis][side] = whole.area > 0 ? whole.error : -1;
        }
    }
    t->nodes[at] = sum;
}

static void plant(void *context, int group, int thread) {
    (void)thread;
    const Forest *forest = context;
    const Mesh *mesh = forest->mesh;
    Trees *t = &forest->groups[group];
    int first = group * FACES_A_GROUP, end = end_of_group(mesh, group), elements = 0;
    for (int f = first; f < end; f++) elements += mesh->faces[f].element_count;
    // Quarters of quarters: a tree has a third more nodes than leaves. Where elements are halves, or none are seen, it has more.
    t->capacity = elements + elements / 2 + FACES_A_GROUP;
    t->nodes = ARENA_ARRAY(&t->arena, Node, t->capacity);
    for (int f = first; f < end; f++) {
        const Face *face = &mesh->faces[f];
        for (int j = 0; j < face->ny; j += face->root) {
            for (int i = 0; i < face->nx; i += face->root) {
                *ARENA_PUSH(&t->arena, t->roots, t->root_count, t->root_capacity) =
                    mesh_owns(mesh, f) ? t->count : ~t->count;
                *ARENA_PUSH(&t->arena, t->nodes, t->count, t->capacity) = (Node){0};
                fill_node(t, t->count - 1, face, (Block){i, j, face->root}, 0);
            }
        }
    }
    t->below = ARENA_ARRAY(&t->arena, double, t->count);
}

// ---- pruning

// Each time it is halved along an axis, the error of the slope there falls to a quarter.
static double prune_element(const Trees *t, Node *n, double cost) {
    static const double QUARTERS[MESH_DEEPEST + 1] = {1,         1.0 / 4,    1.0 / 16,  1.0 / 64,
                                                      1.0 / 256, 1.0 / 1024, 1.0 / 4096};
    double best = INFINITY;
    for (int x = 0; x <= n->most; x++) {
        for (int y = x > 0 ? x - 1 : 0; y <= x + 1 && y <= n->most; y++) {
            if (!t->limits->halves && x != y) continue;
            double count = (double)(1 << (x + y));
            double sum = n->slope_error[0] * QUARTERS[x] + n->slope_error[1] * QUARTERS[y] + cost * count;
            if (sum >= best) continue;
            best = sum;
            n->depth = (MeshDepth){(unsigned char)x, (unsigned char)y};
            n->count = count;
        }
    }
    return best;
}

// The half of a square: one, or its two squares.
static double prune_half(const Trees *t, const Node *n, int axis, int half, double cost, bool *again,
                         double *count) {
    const Node *child[2] = {child_of(t, n, axis, half, 0), child_of(t, n, axis, half, 1)};
    double split = t->below[child[0] - t->nodes] + t->below[child[1] - t->nodes];
    bool there = n->half[axis][half] >= 0;
    double whole = there ? n->half[axis][half] + cost : 0;
    *again = !t->limits->halves || split < whole;
    *count = *again ? child[0]->count + child[1]->count : there;
    return *again ? split : whole;
}

// Returns the least sum of squares and costs of a node whose children are pruned.
static double prune_node(const Trees *t, Node *n, double cost) {
    n->count = 0;
    if (n->first_child < 0) return n->element < 0 ? 0 : prune_element(t, n, cost);
    double best = n->all.error + cost;
    n->axis = -1;
    n->count = n->all.area > 0;
    for (int axis = 0; axis < (t->limits->halves ? 2 : 1); axis++) {
        bool again[2];
        double sum = 0, count[2];
        for (int half = 0; half < 2; half++)
            sum += prune_half(t, n, axis, half, cost, &again[half], &count[half]);
        if (sum >= best) continue;
        best = sum;
        n->axis = axis;
        n->again[0] = again[0];
        n->again[1] = again[1];
        n->count = count[0] + count[1];
    }
    return best;
}

static void prune_group(void *context, int group, int thread) {
    (void)thread;
    const Forest *forest = context;
    Trees *t = &forest->groups[group];
    for (int c = 0; c < forest->costs; c++) {
        for (int i = t->count - 1; i >= 0; i--) t->below[i] = prune_node(t, &t->nodes[i], forest->cost[c]);
        t->leaves[c] = 0;
        for (int r = 0; r < t->root_count; r++)
            t->leaves[c] += t->roots[r] < 0 ? 0 : t->nodes[t->roots[r]].count;
    }
}

// Sets how many leaves are left at each of the costs; the trees stay as the last of these leaves them.
static void prune(Forest *forest, double *count) {
    each_group(forest, prune_group);
    for (int c = 0; c < forest->costs; c++) {
        count[c] = 0;
        for (int g = 0; g < group_count(forest->mesh); g++) count[c] += forest->groups[g].leaves[c];
    }
    if (forest->member) team_sum(forest->member, count, forest->costs);
}

// Costs between which the one is that leaves as many elements as there may be, of the largest error of a root; what share of them is
// near enough; and after how many tries it is, anyway.
static const double LEAST_COST = 1e-12, NEAR_ENOUGH = 0.998;
enum { MOST_TRIES = 4 };

// So that there are at most so many. Each try has costs at even steps, as logarithms, between what is known.
static void prune_to(Forest *forest, double limit) {
    double high = 0, most = fmax(limit, 1), count[MOST_COSTS] = {0};
    for (int g = 0; g < group_count(forest->mesh); g++) {
        const Trees *t = &forest->groups[g];
        for (int i = 0; i < t->count; i++) high = fmax(high, t->nodes[i].all.error);
    }
    if (forest->member) team_most(forest->member, &high, 1);
    double low = LEAST_COST * high;
    forest->costs = MOST_COSTS;
    for (int try = 0; try < MOST_TRIES && count[MOST_COSTS - 1] < NEAR_ENOUGH * most; try++) {
        int enough = 0;
        for (int c = 0; c < MOST_COSTS; c++)
            forest->cost[c] = low > 0 ? low * pow(high / low, (double)c / (MOST_COSTS - 1)) : 0;
        forest->cost[MOST_COSTS - 1] = high;
        prune(forest, count);
        while (enough < MOST_COSTS - 1 && count[enough] > most) enough++;
        high = forest->cost[enough];
        count[MOST_COSTS - 1] = count[enough];
        if (enough == 0) break;
        low = forest->cost[enough - 1];
    }
    forest->costs = 1;
    forest->cost[0] = high;
    prune(forest, count);
}

static void give_depth(const Trees *t, const Node *n, MeshDepth depth, MeshDepth *out) {
    for (int k = 0; n->first_child >= 0 && k < 4; k++)
        give_depth(t, &t->nodes[n->first_child + k], depth, out);
    if (n->element < 0) return;
    MeshDepth *wanted = &out[n->element];
    if (depth.x > wanted->x) wanted->x = depth.x;
    if (depth.y > wanted->y) wanted->y = depth.y;
}

static void take_depths(const Trees *t, const Node *n, int depth, MeshDepth *out) {
    unsigned char own = (unsigned char)depth, deeper = (unsigned char)(depth + 1);
    if (n->first_child < 0) {
        give_depth(t, n, (MeshDepth){(unsigned char)(own + n->depth.x), (unsigned char)(own + n->depth.y)},
                   out);
    } else if (n->axis < 0) {
        give_depth(t, n, (MeshDepth){own, own}, out);
    } else {
        MeshDepth half = n->axis == 0 ? (MeshDepth){deeper, own} : (MeshDepth){own, deeper};
        for (int h = 0; h < 2; h++) {
            for (int k = 0; k < 2; k++) {
                const Node *child = child_of(t, n, n->axis, h, k);
                if (n->again[h])
                    take_depths(t, child, depth + 1, out);
                else
                    give_depth(t, child, half, out);
            }
        }
    }
}

static MeshDepth *adapt_depths(const AdaptField *field, const AdaptLimits *limits, Arena *arena) {
    Arena scratch = {0};
    int groups = group_count(field->mesh);
    Forest forest = {
        .mesh = field->mesh, .groups = ARENA_ARRAY(&scratch, Trees, groups), .member = limits->member};
    for (int g = 0; g < groups; g++) forest.groups[g] = (Trees){.field = field, .limits = limits};
    each_group(&forest, plant);
    prune_to(&forest, limits->most);
    MeshDepth *depth = ARENA_ARRAY(arena, MeshDepth, field->mesh->element_count);
    for (int g = 0; g < groups; g++) {
        Trees *t = &forest.groups[g];
        for (int r = 0; r < t->root_count; r++) take_depths(t, &t->nodes[root_of(t, r)], 0, depth);
        arena_free(&t->arena);
    }
    arena_free(&scratch);
    return depth;
}

// For the first solution.
static const double FIRST_RESIDUAL = 0.02, FIRST_RESIDUAL_BY_DAY = 0.1;
static const int FIRST_RESOLUTION = 40;
// Lamps by the thousand in one room, each with all the others before it: a solution that only tells how fine the mesh is to be ends when
// its shooters, the strongest first, had so many faces before them. Of a file of 1 MB or less; of larger ones by the square of their size.
static const double FIRST_LOOKS = 1.6e7, LAMP_LOOKS = 3e6, SMALL_FILE = 1e6;
// How often lamps shoot on ever finer meshes, and how many splits each time may add.
enum { LAMP_ROUNDS = 1, SPLITS_A_ROUND = 2 };
// Elements are not more often split than so below their patch.
enum { MOST_BELOW_PATCH = 2 };
// A patch is as large as its largest element, since each has one value of reflected light: so large are its steps. Where that would be more
// patches than this, those of things in rooms are larger, and then those of walls, floors and ceilings.
static const double MOST_PATCHES = 45e3;
// Lamp detail of the pilot solution, which only tells where shadows are.
enum { LAMP_DETAIL = 2 };
// Where patches are as light asks they may be larger, of those of a mesh without splits.
static const double PATCH_EDGE = 1.5;
// How often roots are split, twice as long as patches usually are, into patches.
enum { MOST_PATCH_SPLITS = 2 };
// Irradiance of this share of the mean indoors counts as dark where the mesh is fitted to what an eye sees; outdoors, of the mean there if
// that is more.
static const double SEEN = 0.1;
// Light straight from lamps and the sun counts by so much: it is shown on a finer mesh (direct.h), and here only must be sent on from the
// right place.
static const double LAMPS = 0.5;
// Patches with less light than this share of the mean are no larger for it.
static const double DARK = 0.1;
// Reflectance below which surfaces count as if they had so much.
static const double BLACK = 0.05;
// Elements that lamps shine on to tell where shadows end, of those there may be in the end.
static const double PILOT = 1;

AdaptOptions adapt_default_options(void) {
    return (AdaptOptions){.share = 0.4, .few = 5000, .smallest = 0.06};
}

typedef struct Adapt {
    const AdaptScene *scene;
    const AdaptOptions *options;
    const RadOptions *rad;
    const Progress *progress;
    Arena scratch;
    Mesh rough;
    double *indirect;  // [rough.element_count] of the first solution, without what lamps gave, W/m^2
    AdaptField indirect_field;
    double mean;        // reflected radiosity, W/m^2
    double dark[2];     // irradiance that counts as dark indoors, and outdoors, W/m^2
    double most;        // elements there may be
    double patch_edge;  // of that of a mesh without splits
    int above;          // in ABOVE
    double *lamps;  // [element_count] of the light of lamps, sun and sky alone, on the mesh at hand, W/m^2
    double *exact;  // [element_count] the part of `lamps` that comes from lamps and the sun
    const Borders *borders;  // of the mesh at hand, if it is of a part of the building
} Adapt;

// Sums of a part of the building become those of the whole.
static void add_parts(const Adapt *a, double *sum, int count) {
    if (a->scene->member) team_sum(a->scene->member, sum, count);
}

// Where one part fails or is stopped, all are.
static bool all_good(const Adapt *a, bool good, Error *error) {
    if (!a->scene->member) return good;
    bool any = team_any(a->scene->member, !good);
    return good ? !any || error_set(error, "stopped") : false;
}

static double emission_of(const Mesh *mesh, int element) {
    Rgb e = mesh_material(mesh, mesh->elements[element].face)->emission;
    return (double)(e.r + e.g + e.b);
}

static double reflectance_of(const Mesh *mesh, int element) {
    Rgb rho = mesh_reflectance(mesh, element);
    return (double)(rho.r + rho.g + rho.b) / 3;
}

// The light of all channels, from the part that is reflected: surfaces of all colours count alike, but nothing is seen on black ones.
static double irradiance_of(const Mesh *mesh, int element, const double b[3]) {
    const Material *m = mesh_material(mesh, mesh->elements[element].face);
    const float rho[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    double sum = 0, even[3];
    mesh_even(mesh, element, even);
    for (int c = 0; c < 3; c++) sum += even[c] * fmax(0, b[c] - (double)e[c]) / fmax((double)rho[c], BLACK);
    return sum;
}

static void find_exact(const Adapt *a, const Mesh *mesh, RadSolution *solution, double *out) {
    if (rgb_sum(solution->day.beam) > 0)
        sunlight_elements(mesh, &solution->day, parallel_threads(a->rad->threads), solution->sun);
    for (int e = 0; e < mesh->element_count; e++) {
        double b[3];
        rgb_doubles(mesh_material(mesh, mesh->elements[e].face)->emission, b);
        for (int c = 0; c < 3; c++) b[c] += solution->direct[e][c] + solution->sun[e][c];
        out[e] = irradiance_of(mesh, e, b);
    }
}

// How light is found that only tells how fine the mesh is to be: of lamps, sun and sky alone, or with what they reflect.
static RadOptions pilot_options(const Adapt *a, bool lamps_only) {
    RadOptions options = *a->rad;
    // A mesh that depended on where a run was broken off would not be the same when it is resumed.
    options.shots = 0;
    double size = fmax(1, a->scene->graph->building->file_size / SMALL_FILE);
    options.borders = a->borders;
    options.looks = (lamps_only ? LAMP_LOOKS : FIRST_LOOKS) * size * size;
    options.lamps_only = lamps_only;
    options.gather = options.each_room = false;
    if (!lamps_only) options.reach = 0;
    if (options.lamp_detail > LAMP_DETAIL) options.lamp_detail = LAMP_DETAIL;
    double first = daylight_shines(&a->options->day) ? FIRST_RESIDUAL_BY_DAY : FIRST_RESIDUAL;
    options.residual = lamps_only ? 0 : fmax(options.residual, first);
    int usual = form_factor_default_options().resolution, most = lamps_only ? usual : FIRST_RESOLUTION;
    if (options.form_factor.resolution == 0 || options.form_factor.resolution > most)
        options.form_factor.resolution = most;
    return options;
}

// Light that sun and sky send in, and lamps are about to send.
static bool begin(Adapt *a, const Mesh *mesh, Arena *arena, RadSolution *out, Error *error) {
    const RadOptions options = pilot_options(a, true);
    if (!all_good(a, rad_start_dark(mesh, arena, out, error), error)) return false;
    return !daylight_shines(&a->options->day) ||
           rad_shine(mesh, a->scene->forest, a->scene->door_open, &options, &a->options->day, a->progress,
                     out) ||
           error_set(error, "stopped");
}

// Shoots on, and tells the irradiances of elements, W/m^2.
static bool solve(Adapt *a, const Mesh *mesh, bool lamps_only, RadSolution *solution, double *irradiance,
                  Error *error) {
    const RadOptions options = pilot_options(a, lamps_only);
    RadReport report =
        rad_shoot(mesh, a->scene->forest, a->scene->door_open, &options, a->progress, solution);
    if (report.stopped) return error_set(error, "stopped");
    for (int e = 0; e < mesh->element_count; e++)
        irradiance[e] = irradiance_of(mesh, e, solution->radiosity[e]);
    return true;
}

// The light of lamps, sun and sky alone, and the part of it that comes from lamps and the sun. From `solution` light can be shot on.
static bool solve_lamps(Adapt *a, const Mesh *mesh, Arena *arena, RadSolution *solution, Error *error) {
    a->lamps = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
    a->exact = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
    if (!begin(a, mesh, arena, solution, error) || !solve(a, mesh, true, solution, a->lamps, error))
        return false;
    find_exact(a, mesh, solution, a->exact);
    return true;
}

// Has all that emits light shot?
static bool lamps_have_shot(const Adapt *a, const Mesh *mesh, const RadSolution *solution) {
    double lamps = 0;
    for (int p = 0; p < mesh->patch_count; p++)
        lamps += mesh_owns(mesh, mesh->patches[p].face) && mesh_emits(mesh, mesh->patches[p].face);
    add_parts(a, &lamps, 1);
    return (double)solution->shots >= lamps;
}

// ---- rounds

// The mesh that light is found on next.
static bool take_mesh(Adapt *a, const Mesh *mesh, Error *error) {
    if (!a->scene->member) return true;
    a->borders = borders_new(mesh, a->scene->member, &a->scratch, error);
    return a->borders != NULL;
}

static bool build_adapted(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    return all_good(a, mesh_build(a->scene->graph, a->scene->door_open, options, arena, out, error), error);
}

static bool is_outdoors(const Mesh *mesh, int element) {
    int cell = mesh->patches[mesh->elements[element].patch].cell;
    return cell >= 0 && vis_region(mesh->graph, cell)->kind == REGION_OUTDOORS;
}

// By the light of the rough mesh.
static void find_dark(Adapt *a) {
    const Mesh *mesh = &a->rough;
    double power[2] = {0, 0}, area[2] = {0, 0};
    for (int e = 0; e < mesh->element_count; e++) {
        bool outdoors = is_outdoors(mesh, e);
        if (!mesh_owns(mesh, mesh->elements[e].face)) continue;
        power[outdoors] += mesh->elements[e].area * a->indirect[e];
        area[outdoors] += mesh->elements[e].area;
    }
    add_parts(a, power, 2);
    add_parts(a, area, 2);
    for (int o = 0; o < 2; o++) a->dark[o] = area[o] > 0 ? SEEN * power[o] / area[o] : 0;
    a->dark[true] = fmax(a->dark[true], a->dark[false]);
}

// The light after two reflections, on patches of two by two elements.
static bool first_solution(Adapt *a, const MeshOptions *options, Error *error) {
    static const MeshSplits ONCE = {.even = 1};
    MeshOptions rough = *options;
    rough.splits = &ONCE;
    rough.close = 0;
    rough.loose = true;
    if (!build_adapted(a, &rough, &a->scratch, &a->rough, error) || !take_mesh(a, &a->rough, error))
        return false;
    int count = a->rough.element_count;
    double sums[2] = {0, 0};
    Arena arena = {0};
    RadSolution solution;
    a->indirect = ARENA_ARRAY(&a->scratch, double, count);
    bool good = solve_lamps(a, &a->rough, &arena, &solution, error);
    // Lamps by the thousand have not all shot. rad_shoot would pass over as many as there were shots, those of other parts counted.
    if (good && !lamps_have_shot(a, &a->rough, &solution))
        good = begin(a, &a->rough, &arena, &solution, error);
    good = good && solve(a, &a->rough, false, &solution, a->indirect, error);
    arena_free(&arena);
    if (!good) return false;
    find_dark(a);
    for (int e = 0; e < count; e++) {
        bool own = mesh_owns(&a->rough, a->rough.elements[e].face);
        if (own) sums[0] += a->rough.elements[e].area * a->indirect[e] * reflectance_of(&a->rough, e);
        if (own) sums[1] += a->rough.elements[e].area;
        a->indirect[e] = fmax(0, a->indirect[e] - a->lamps[e]);
    }
    add_parts(a, sums, 2);
    a->mean = sums[1] > 0 ? sums[0] / sums[1] : 0;
    a->indirect_field = adapt_field(&a->rough, a->indirect, &a->scratch);
    return true;
}

// The side of the square that an element is, or is cut from, metres.
static double root_edge(const Mesh *mesh, int element) {
    const Face *face = &mesh->faces[mesh->elements[element].face];
    return face->root / sqrt(vec3_length(face->gx) * vec3_length(face->gy));
}

// Light as an eye sees it: of equal ratios the steps are equal, but in the dark, where errors are not seen.
static double seen_light(double dark, double irradiance) {
    return dark > 0 ? log1p(irradiance / dark) : irradiance;
}

static double dark_of(const Adapt *a, const Mesh *mesh, int element) {
    return a->dark[is_outdoors(mesh, element)];
}

// All light on the elements of a mesh: of lamps as they shone on it, the rest from the rough mesh, as it slopes there.
static AdaptField find_light(Adapt *a, const Mesh *mesh) {
    double *light = ARENA_ARRAY(&a->scratch, double, mesh->element_count);
    for (int e = 0; e < mesh->element_count; e++) {
        Vec3 here = element_centroid(mesh, e);
        int face = mesh->elements[e].face, rough = mesh_element_at(&a->rough, face, here);
        Vec3 off = vec3_sub(here, element_centroid(&a->rough, rough));
        const Face *grid = &a->rough.faces[face];
        const double *slope = a->indirect_field.slope[rough];
        light[e] = a->lamps[e] - (1 - LAMPS) * a->exact[e] +
                   fmax(0, a->indirect[rough] + slope[0] * vec3_dot(vec3_normalize(grid->gx), off) +
                               slope[1] * vec3_dot(vec3_normalize(grid->gy), off));
        light[e] = seen_light(dark_of(a, mesh, e), light[e]);
    }
    return adapt_field(mesh, light, &a->scratch);
}

static unsigned char limit(int depth) {
    return (unsigned char)(depth < 0 ? 0 : depth > MESH_DEEPEST ? MESH_DEEPEST : depth);
}

// Does something stand on the middle of the root that an element is cut from? Roots are the patches of the rough mesh.
static bool has_covered_root(const Adapt *a, const Mesh *mesh, int element) {
    int rough = mesh_element_at(&a->rough, mesh->elements[element].face, element_centroid(mesh, element));
    return a->rough.patches[a->rough.elements[rough].patch].covered;
}

// Shooters err by about their power times their size: the sum is least for a number of them where their edges are as the fourth
// root of 1 / light. Lamps count as bright as they are.
static int patch_depth(const Adapt *a, const Mesh *mesh, int element, double light) {
    if (!(a->mean > 0)) return 0;  // in the dark, or all is black
    double usual = a->patch_edge * mesh->options.element * mesh->options.per_patch,
           root = root_edge(mesh, element);
    double edge = usual * pow(fmax(light / a->mean, DARK), -0.25);
    // For lamps, each of which shoots with more detail, a quarter of the root at least; and at most where a cord or rod stands on its
    // middle, since from one place beside that it would send its light to one side.
    if (mesh_is_lamp(mesh, mesh->elements[element].face))
        edge = has_covered_root(a, mesh, element) ? root / 2 : fmax(edge, root / 2);
    int depth = (int)lround(log2(root / edge));
    return depth < 0 ? 0 : depth > MOST_PATCH_SPLITS ? MOST_PATCH_SPLITS : depth;
}

static bool is_surface(const Mesh *mesh, int element) {
    int object = mesh->faces[mesh->elements[element].face].object;
    return mesh->graph->objects[object].kind == OBJECT_SURFACE;
}

// By how many splits patches are larger than their elements, for [surfaces, things]: ever larger ones.
static const int ABOVE[][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 3}};
enum { ABOVE_COUNT = sizeof ABOVE / sizeof *ABOVE };
// So many times too many patches become few enough two steps on.
static const double FAR_TOO_MANY = 1.5;

static MeshSplits *split(Adapt *a, const Mesh *mesh, bool last, Arena *arena) {
    AdaptField field = find_light(a, mesh);
    AdaptLimits limits = {.most = last ? a->most : PILOT * a->most,
                          .smallest = a->options->smallest,
                          .deeper = SPLITS_A_ROUND,
                          .halves = last,
                          .member = a->scene->member};
    MeshDepth *element = adapt_depths(&field, &limits, &a->scratch);
    unsigned char *patch = ARENA_ARRAY(&a->scratch, unsigned char, mesh->element_count);
    const int *above = ABOVE[a->above];
    for (int e = 0; e < mesh->element_count; e++) {
        double light =
            dark_of(a, mesh, e) * expm1(field.light[e]) * reflectance_of(mesh, e) + emission_of(mesh, e);
        int square = element[e].x < element[e].y ? element[e].x : element[e].y;
        bool lamp = mesh_is_lamp(mesh, mesh->elements[e].face);
        patch[e] =
            limit(last && !lamp ? square - above[!is_surface(mesh, e)]
                                : (int)fmax(patch_depth(a, mesh, e, light), square - MOST_BELOW_PATCH));
    }
    // Other parts know best what covers the patches of their faces.
    if (a->borders) {
        const BorderValue depths[] = {BORDER_VALUE(BORDER_ELEMENT, patch),
                                      BORDER_VALUE(BORDER_ELEMENT, element)};
        borders_fetch(a->borders, depths, 2);
    }
    return mesh_splits(mesh, patch, element, arena);
}

static double own_patches(const Adapt *a, const Mesh *mesh) {
    double count = 0;
    for (int p = 0; p < mesh->patch_count; p++) count += mesh_owns(mesh, mesh->patches[p].face);
    add_parts(a, &count, 1);
    return count;
}

static bool make(Adapt *a, const MeshOptions *options, Arena *arena, Mesh *out, Error *error) {
    if (!first_solution(a, options, error)) return false;
    double even = mesh_count_even(&a->rough);
    add_parts(a, &even, 1);
    a->most = fmax(a->options->share * even, a->options->few);
    a->patch_edge = even > a->options->few ? PATCH_EDGE : 1;
    const Mesh *mesh = &a->rough;
    MeshOptions finer = *options;
    for (int round = 0; round < LAMP_ROUNDS; round++) {
        Mesh *next = ARENA_ARRAY(&a->scratch, Mesh, 1);
        finer.close = 0;
        finer.loose = true;
        finer.splits = split(a, mesh, false, &a->scratch);
        if (!build_adapted(a, &finer, &a->scratch, next, error) || !take_mesh(a, next, error)) return false;
        mesh = next;
        Arena own = {0};
        RadSolution solution;
        bool good = solve_lamps(a, mesh, &own, &solution, error);
        arena_free(&own);
        if (!good) return false;
    }
    finer.close = options->close;
    finer.loose = false;
    // Cuts along things add patches, so that these are counted when they are there.
    for (Arena own = {0};; a->above++) {
        finer.splits = split(a, mesh, true, &own);
        bool good = build_adapted(a, &finer, &own, out, error);
        double patches = good ? own_patches(a, out) : 0;
        if (patches > MOST_PATCHES && a->above + 1 < ABOVE_COUNT) {
            a->above += patches > FAR_TOO_MANY * MOST_PATCHES && a->above + 2 < ABOVE_COUNT;
            arena_free(&own);
            continue;
        }
        arena_join(arena, &own);
        return good;
    }
}

bool adapt_mesh(const AdaptScene *scene, const MeshOptions *options, const AdaptOptions *adapt,
                const RadOptions *rad, const Progress *progress, Arena *arena, Mesh *out, Error *error) {
    Adapt a = {.scene = scene, .options = adapt, .rad = rad, .progress = progress};
    bool good = make(&a, options, arena, out, error);
    arena_free(&a.scratch);
    return good;
}
