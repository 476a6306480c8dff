// soup_tree.c - a binary partition of the world along the major opaque polygons (Teller & Sequin 1991, section 2), on
// the planes of the polygons themselves, whichever way these stand.
//
// First the sides of the building's own box are cut, then, of all cells, always the one whose best plane hides most. A
// plane costs: the better it covers its section of the cell, the less; what it cuts in two and what it leaves on one
// side cost. It is major where it covers MAJOR_COVER of its section, or where the cell is crowded: more is opaque in it
// than its boundary measures, or, of a house in a wide garden, more than the box around all that measures. Of a crowded
// cell only that box counts as the section. Details, and what is less than LEAST_SHARE of the building, cut nothing.
#include <stdlib.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "visibility/soup/soup.h"

// Share of its section of the cell that a major plane covers: a wall with its door does, a cupboard does not.
static const double MAJOR_COVER = 0.25;
// Planes that cover less than this share of all opaque area are not tried: in a building of a hundred rooms that is a door's jamb.
static const double LEAST_SHARE = 1e-5;
// Cutting all polygons that are left in two, or leaving them all on one side, costs this, in units of a section fully covered.
static const double CUT_COST = 0.3, BALANCE_COST = 0.05;
// A cell is crowded where CROWDED times the box around what it holds is less than that, if it is so much of the building:
// a wardrobe is no house.
static const double CROWDED = 1.1, CROWDED_SHARE = 0.05;
// Planes of a cell that are tried, those with most opaque area; cells there may be, however many sheets; and a cell more for so many.
enum { TRIED = 32, MOST_CELLS = 4096, FEW_CELLS = 512, SHEETS_A_CELL = 32 };
// Polygons in general position cut each other without end: what there may be of fragments, and how many may be looked at in all, is
// so much, and so much more for each sheet. A building of rooms has two or three fragments a sheet, and looks at each a few hundred
// times.
static const double FEW_FRAGMENTS = 100000, FRAGMENTS_A_SHEET = 8, FEW_LOOKS = 3e8, LOOKS_A_SHEET = 2000;
// Figures that decide are compared as whole multiples of this: equal ones stay so when the building is turned.
static const double DIGIT = 1e-6;

// The part of a sheet inside a branch.
typedef struct Fragment {
    const Vec3 *v;
    int count, plane;
    double area;
} Fragment;

// Fragments in their order, a run of them at a time. Runs of branches that were cut are used again.
enum { RUN = 120 };
typedef struct FragmentRun {
    struct FragmentRun *next;
    int count;
    Fragment fragments[RUN];
} FragmentRun;

typedef struct Branch {
    SoupCell *cell;
    FragmentRun *first, *last;
    int fragment_count;
    int best;        // the plane to cut by, or -1
    double urgency;  // the area that the plane hides
} Branch;

typedef struct Tree {
    Soup *soup;
    Branch *branches;
    int branch_count, branch_capacity;
    double *plane_area;  // [plane_count] of the branch looked at
    int *touched;        // [plane_count] planes with area there
    FragmentRun *free;
    double fragments, looks;  // that there are; at fragments so far
} Tree;

typedef struct Reach {
    double low, high;
} Reach;

// The sums of a branch's content.
typedef struct Content {
    double area;     // opaque, m^2
    Reach along[3];  // the building's own directions, from its centre
    bool crowded;
} Content;

static Reach reach_of(const Vec3 *v, int count, Plane plane) {
    Reach r = {INFINITY, -INFINITY};
    for (int i = 0; i < count; i++) {
        double d = plane_distance(plane, v[i]);
        r.low = fmin(r.low, d);
        r.high = fmax(r.high, d);
    }
    return r;
}

static void push_fragment(Tree *tree, Branch *branch, Fragment fragment) {
    if (!branch->last || branch->last->count == RUN) {
        FragmentRun *run = tree->free;
        if (run)
            tree->free = run->next;
        else
            run = ARENA_ARRAY(tree->soup->scratch, FragmentRun, 1);
        run->next = NULL;
        run->count = 0;
        *(branch->last ? &branch->last->next : &branch->first) = run;
        branch->last = run;
    }
    branch->last->fragments[branch->last->count++] = fragment;
    branch->fragment_count++;
    tree->fragments++;
}

static void free_fragments(Tree *tree, const Branch *branch) {
    if (!branch->last) return;
    branch->last->next = tree->free;
    tree->free = branch->first;
    tree->fragments -= branch->fragment_count;
}

static void add_fragment(Tree *tree, Branch *branch, const Vec3 *v, int count, int plane) {
    double near = SOUP_SNAP * tree->soup->size;
    if (count < 3 || soup_width(v, count) < near) return;
    Vec3 *copy = memcpy(ARENA_ARRAY(tree->soup->scratch, Vec3, count), v, (size_t)count * sizeof *v);
    push_fragment(tree, branch, (Fragment){copy, count, plane, polygon_area(v, count)});
}

// ---- which plane

typedef struct Choice {
    int plane;
    double area, cover, score;
} Choice;

// The section of the cell, of a crowded one within the box of what it holds; its area.
static double section_area(const Soup *soup, const Branch *branch, int plane, const Content *content) {
    Vec3 section[SOUP_MOST_CORNERS], part[SOUP_MOST_CORNERS];
    int count = soup_cell_section(soup, branch->cell, plane, section);
    for (int side = 0; content->crowded && side < 6 && count > 0; side++) {
        int k = side / 2;
        Vec3 n = vec3_scale(soup->axis[k], side % 2 ? -1 : 1);
        double at = side % 2 ? -content->along[k].high : content->along[k].low;
        count = polygon_clip(section, count, (Plane){n, vec3_dot(n, soup->centre) + at},
                             SOUP_THINNEST * soup->size, part);
        memcpy(section, part, (size_t)count * sizeof *section);
    }
    return count >= 3 ? polygon_area(section, count) : 0;
}

static bool parts_cell(const Soup *soup, const SoupCell *cell, Plane plane) {
    Reach extent = {INFINITY, -INFINITY};
    for (int i = 0; i < cell->face_count; i++) {
        Reach r = reach_of(cell->faces[i].v, cell->faces[i].count, plane);
        extent = (Reach){fmin(extent.low, r.low), fmax(extent.high, r.high)};
    }
    return extent.low < -SOUP_THINNEST * soup->size && extent.high > SOUP_THINNEST * soup->size;
}

// In whole DIGITs.
static double score_of(double cover, double cut, double uneven, double area) {
    return nearbyint((cover - (CUT_COST * cut + BALANCE_COST * uneven) / area) / DIGIT);
}

static bool is_better(const Choice *c, double score, const Choice *best) {
    return score > best->score || (score == best->score && c->plane < best->plane);
}

// Whether a plane is major, and better than the best so far; then it becomes that. What is cut only grows as fragments are looked at:
// a plane is given up as soon as it cuts too much.
static void judge(Tree *tree, const Branch *branch, int plane, const Content *content, Choice *best) {
    const Soup *soup = tree->soup;
    Choice c = {.plane = plane, .area = tree->plane_area[plane]};
    Plane p = soup->planes[plane].plane;
    if (!parts_cell(soup, branch->cell, p)) return;
    double section = section_area(soup, branch, plane, content);
    if (section <= 0) return;
    double cover = fmin(1, c.area / section);
    c.cover = nearbyint(cover / DIGIT);
    if (c.cover < MAJOR_COVER / DIGIT && !content->crowded) return;
    double cut = 0, front = 0, back = 0, near = SOUP_SNAP * soup->size;
    for (const FragmentRun *run = branch->first; run; run = run->next) {
        if (!is_better(&c, score_of(cover, cut, 0, content->area), best)) return;
        tree->looks += run->count;
        for (int i = 0; i < run->count; i++) {
            const Fragment *f = &run->fragments[i];
            if (f->plane == plane) continue;
            Reach r = reach_of(f->v, f->count, p);
            if (r.low < -near && r.high > near) {
                cut += f->area;
            } else if (r.high > near) {
                front += f->area;
            } else {
                back += f->area;
            }
        }
    }
    c.score = score_of(cover, cut, fabs(front - back), content->area);
    if (is_better(&c, c.score, best)) *best = c;
}

// The planes with most area among those touched, the lower index first of equals; how many are worth trying.
static int rank_planes(const Tree *tree, int count, int out[TRIED]) {
    double unit = DIGIT * tree->soup->opaque_area, area[TRIED];
    int tried = 0;
    for (int i = 0; i < count; i++) {
        int plane = tree->touched[i], at = tried;
        double here = nearbyint(tree->plane_area[plane] / unit);
        while (at > 0 && (here > area[at - 1] || (here == area[at - 1] && plane < out[at - 1]))) at--;
        if (at == TRIED) continue;
        if (tried < TRIED) tried++;
        for (int k = tried - 1; k > at; k--) {
            area[k] = area[k - 1];
            out[k] = out[k - 1];
        }
        area[at] = here;
        out[at] = plane;
    }
    for (int i = 0; i < tried; i++)
        if (tree->plane_area[out[i]] < LEAST_SHARE * tree->soup->opaque_area) return i;
    return tried;
}

static Content measure_branch(const Soup *soup, const Branch *branch) {
    Content c = {.along = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}, {INFINITY, -INFINITY}}};
    for (const FragmentRun *run = branch->first; run; run = run->next) {
        for (const Fragment *f = run->fragments; f < run->fragments + run->count; f++) {
            c.area += f->area;
            for (int k = 0; k < 3; k++) {
                Plane across = {soup->axis[k], vec3_dot(soup->axis[k], soup->centre)};
                Reach r = reach_of(f->v, f->count, across);
                c.along[k] = (Reach){fmin(c.along[k].low, r.low), fmax(c.along[k].high, r.high)};
            }
        }
    }
    double boundary = 0, size[3];
    for (int i = 0; i < branch->cell->face_count; i++)
        boundary += polygon_area(branch->cell->faces[i].v, branch->cell->faces[i].count);
    for (int k = 0; k < 3; k++) size[k] = c.along[k].high - c.along[k].low;
    double box = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    c.crowded = c.area > boundary || (c.area > CROWDED * box && c.area > CROWDED_SHARE * soup->opaque_area);
    return c;
}

static void choose(Tree *tree, Branch *branch) {
    int count = 0;
    tree->looks += branch->fragment_count;
    for (const FragmentRun *run = branch->first; run; run = run->next) {
        for (const Fragment *f = run->fragments; f < run->fragments + run->count; f++) {
            if (tree->plane_area[f->plane] == 0) tree->touched[count++] = f->plane;
            tree->plane_area[f->plane] += f->area;
        }
    }
    Content content = measure_branch(tree->soup, branch);
    int ranked[TRIED], tried = rank_planes(tree, count, ranked);
    Choice best = {-1, 0, 0, -INFINITY};
    for (int i = 0; i < tried; i++) judge(tree, branch, ranked[i], &content, &best);
    branch->best = best.plane;
    branch->urgency = best.area * best.cover;
    for (int i = 0; i < count; i++) tree->plane_area[tree->touched[i]] = 0;
}

// ---- cutting

static void part_fragment(Tree *tree, const Fragment *f, Plane p, Branch *front, Branch *back) {
    Plane behind = {vec3_scale(p.n, -1), -p.d};
    Vec3 part[SOUP_MOST_CORNERS];
    Reach r = reach_of(f->v, f->count, p);
    double near = SOUP_SNAP * tree->soup->size;
    if (r.low >= -near || r.high <= near || f->count >= SOUP_MOST_CORNERS) {
        push_fragment(tree, r.high > near ? front : back, *f);
        return;
    }
    add_fragment(tree, front, part, polygon_clip(f->v, f->count, p, 0, part), f->plane);
    add_fragment(tree, back, part, polygon_clip(f->v, f->count, behind, 0, part), f->plane);
}

static void part_fragments(Tree *tree, const Branch *from, int plane, Branch *front, Branch *back) {
    for (const FragmentRun *run = from->first; run; run = run->next) {
        for (const Fragment *f = run->fragments; f < run->fragments + run->count; f++)
            if (f->plane != plane) part_fragment(tree, f, tree->soup->planes[plane].plane, front, back);
    }
}

// The branch becomes its front part, and its back part a new branch. False where it cannot be cut.
static bool cut_branch(Tree *tree, int index, int plane) {
    SoupCell *front_cell, *back_cell;
    if (!soup_cell_split(tree->soup, tree->branches[index].cell, plane, &front_cell, &back_cell))
        return false;
    tree->branches[index].cell->gone = true;
    Branch front = {.cell = front_cell}, back = {.cell = back_cell};
    part_fragments(tree, &tree->branches[index], plane, &front, &back);
    free_fragments(tree, &tree->branches[index]);
    choose(tree, &front);
    choose(tree, &back);
    tree->branches[index] = front;
    *ARENA_PUSH(tree->soup->scratch, tree->branches, tree->branch_count, tree->branch_capacity) = back;
    return true;
}

static void cut_box(Tree *tree) {
    for (int side = 0; side < 6; side++) {
        // The branch inside of the sides cut so far holds the building.
        int last = tree->branch_count, inner = 0;
        for (int i = 1; i < last; i++) {
            if (tree->branches[i].fragment_count > tree->branches[inner].fragment_count) inner = i;
        }
        cut_branch(tree, inner, tree->soup->box[side]);
    }
}

static void cut_all(Tree *tree) {
    double sheets = tree->soup->sheet_count, most = fmin(MOST_CELLS, FEW_CELLS + sheets / SHEETS_A_CELL);
    while (tree->branch_count < most && tree->fragments < FEW_FRAGMENTS + FRAGMENTS_A_SHEET * sheets &&
           tree->looks < FEW_LOOKS + LOOKS_A_SHEET * sheets) {
        int next = -1;
        for (int i = 0; i < tree->branch_count; i++) {
            const Branch *branch = &tree->branches[i];
            if (branch->best >= 0 && (next < 0 || branch->urgency > tree->branches[next].urgency)) next = i;
        }
        if (next < 0) return;
        if (!cut_branch(tree, next, tree->branches[next].best)) tree->branches[next].best = -1;
    }
}

// The planes of doors cut the cells that the doors stand in, however little of them they cover.
static void cut_doors(Tree *tree) {
    const Soup *soup = tree->soup;
    double least = SOUP_SNAP * soup->size;
    for (int d = 0; d < soup->door_count; d++) {
        const SoupDoor *door = &soup->doors[d];
        for (int i = 0; i < tree->branch_count; i++) {
            Vec3 part[SOUP_MOST_CORNERS];
            int count = soup_cell_clip(soup, tree->branches[i].cell, door->v, 4, part);
            if (count > 0 && soup_width(part, count) > least) cut_branch(tree, i, door->plane);
        }
    }
}

void soup_part(Soup *soup) {
    Tree tree = {.soup = soup,
                 .plane_area = ARENA_ARRAY(soup->scratch, double, soup->plane_count),
                 .touched = ARENA_ARRAY(soup->scratch, int, soup->plane_count)};
    Branch *world = ARENA_PUSH(soup->scratch, tree.branches, tree.branch_count, tree.branch_capacity);
    *world = (Branch){.cell = soup->cells[0]};
    for (int i = 0; i < soup->sheet_count; i++)
        add_fragment(&tree, world, soup->sheets[i].v, soup->sheets[i].count, soup->sheets[i].plane);
    choose(&tree, world);
    cut_box(&tree);
    cut_all(&tree);
    cut_doors(&tree);
    soup->cell_count = 0;
    for (int i = 0; i < tree.branch_count; i++) soup->cells[soup->cell_count++] = tree.branches[i].cell;
}
