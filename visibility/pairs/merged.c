// merged.c - see merged.h. Portals are taken by their distance from the source, so that most chains that lead through one have come
// there when it is looked through; one whose beam grows later is looked through again.
#include "visibility/pairs/merged.h"

#include "visibility/pairs/cast.h"

// The work of steps, see ways_work.
enum { WORK_VISIT = 600, WORK_CLIP = 500, WORK_GROW = 300, WORK_BOX = 10, WORK_LINE = 1000 };
// A beam that has grown so often is given the whole portal and the whole source: then it cannot grow again.
enum { MOST_GROWTHS = 6 };
// With more cells in doubt beyond a portal, it is not asked which of them its beam may reach.
enum { MOST_BOXES = 1024 };

// One portal that was reached.
typedef struct Reach {
    Winding source, pass;
    int way, growths;
    double distance;  // of the middle of the portal from that of the source, metres
    bool queued;
} Reach;

// The memory of one thread.
struct Merged {
    Reach **reach;    // [reach_count, of reach_made]
    int *place;       // [way_count] in `reach`, where stamp[way] is that of this search
    unsigned *stamp;  // [way_count]
    int *queue;       // a heap of places in `reach` by their distance
    Beam first, here, next;
    int *word;  // cells in doubt in the beam, as FlowStep keeps them
    uint64_t *bits;
    CastPath path;
    int *cells;            // of merged_cells, which looks for all cells; NULL: cells in doubt are looked for
    unsigned *cell_stamp;  // [cell_count] as `stamp`, of cells in `cells`
    int cell_count, most_cells;
    int reach_count, reach_made, queue_count, word_count;
    unsigned search;
};

static Merged *merged_new(Flow *flow) {
    const WayGraph *ways = flow->ways;
    Merged *m = ARENA_ARRAY(&flow->arena, Merged, 1);
    m->reach = ARENA_ARRAY(&flow->arena, Reach *, ways->way_count);
    m->place = ARENA_ARRAY(&flow->arena, int, ways->way_count);
    m->stamp = ARENA_ARRAY(&flow->arena, unsigned, ways->way_count);
    m->queue = ARENA_ARRAY(&flow->arena, int, ways->way_count);
    m->word = ARENA_ARRAY(&flow->arena, int, ways->words);
    m->bits = ARENA_ARRAY(&flow->arena, uint64_t, ways->words);
    m->path = cast_path(ways, &flow->arena);
    m->cell_stamp = ARENA_ARRAY(&flow->arena, unsigned, ways->cell_count);
    return m;
}

static void queue_add(Merged *m, int place) {
    Reach *reach = m->reach[place];
    if (reach->queued) return;
    reach->queued = true;
    int at = m->queue_count++;
    for (; at > 0 && m->reach[m->queue[(at - 1) / 2]]->distance > reach->distance; at = (at - 1) / 2)
        m->queue[at] = m->queue[(at - 1) / 2];
    m->queue[at] = place;
}

static Reach *queue_take(Merged *m) {
    int nearest = m->queue[0], last = m->queue[--m->queue_count], at = 0;
    double distance = m->reach[last]->distance;
    for (int child = 1; child < m->queue_count; child = 2 * at + 1) {
        bool right = child + 1 < m->queue_count &&
                     m->reach[m->queue[child + 1]]->distance < m->reach[m->queue[child]]->distance;
        child += right;
        if (m->reach[m->queue[child]]->distance >= distance) break;
        m->queue[at] = m->queue[child];
        at = child;
    }
    m->queue[at] = last;
    m->reach[nearest]->queued = false;
    return m->reach[nearest];
}

// Do all corners of `a` lie in `b`, in whose plane they are? `slack` in metres.
static bool holds(const Winding *b, const Winding *a, double slack) {
    for (int i = 0; i < b->count; i++) {
        Vec3 corner = winding_corner(b, i), edge = vec3_sub(winding_corner(b, i + 1), corner);
        Vec3 inwards = vec3_cross(b->facet->plane.n, edge);
        double least = vec3_dot(inwards, corner) - slack * vec3_length(edge);
        for (int k = 0; k < a->count; k += FOUR) {
            Four at = four_load(a->x + k) * inwards.x + four_load(a->y + k) * inwards.y +
                      four_load(a->z + k) * inwards.z;
            if (four_lanes(at < least)) return false;
        }
    }
    return true;
}

// A corner as seen along the axis that is nearest to the normal of its plane, so that counter-clockwise stays so.
typedef struct HullPoint {
    double u, v;
    Vec3 p;
} HullPoint;

static bool turns_left(const HullPoint *o, const HullPoint *a, const HullPoint *b) {
    return (a->u - o->u) * (b->v - o->v) - (a->v - o->v) * (b->u - o->u) > 0;
}

// Makes `b` the convex hull of both (A. Andrew 1979); false when it has too many corners. Its corners are given ones.
static bool unite(Winding *b, const Winding *a) {
    enum { MOST = WINDING_MAX - 8 };  // room to be clipped
    HullPoint points[2 * WINDING_MAX];
    const HullPoint *hull[4 * WINDING_MAX];
    Vec3 n = b->facet->plane.n;
    int axis = fabs(n.x) > fabs(n.y) ? (fabs(n.x) > fabs(n.z) ? 0 : 2) : (fabs(n.y) > fabs(n.z) ? 1 : 2),
        count = 0;
    bool turn = vec3_component(n, axis) < 0;
    for (int i = 0; i < a->count + b->count; i++) {
        Vec3 p = i < a->count ? winding_corner(a, i) : winding_corner(b, i - a->count);
        double u = vec3_component(p, (axis + 1) % 3), v = vec3_component(p, (axis + 2) % 3);
        HullPoint point = turn ? (HullPoint){v, u, p} : (HullPoint){u, v, p};
        int at = count++;
        for (; at > 0 &&
               (points[at - 1].u > point.u || (points[at - 1].u == point.u && points[at - 1].v > point.v));
             at--)
            points[at] = points[at - 1];
        points[at] = point;
    }
    int top = 0;
    for (int i = 0; i < count; i++) {
        while (top >= 2 && !turns_left(hull[top - 2], hull[top - 1], &points[i])) top--;
        hull[top++] = &points[i];
    }
    for (int i = count - 2, lower = top + 1; i >= 0; i--) {
        while (top >= lower && !turns_left(hull[top - 2], hull[top - 1], &points[i])) top--;
        hull[top++] = &points[i];
    }
    top--;
    if (top < 3 || top > MOST) return false;
    b->count = top;
    for (int i = 0; i < top; i++) winding_set(b, i, hull[i]->p);
    winding_close(b);
    return true;
}

static Reach *reach_of(Flow *flow, int way) {
    Merged *m = flow->merged;
    if (m->stamp[way] == m->search) return m->reach[m->place[way]];
    m->stamp[way] = m->search;
    m->place[way] = m->reach_count;
    if (m->reach_count == m->reach_made) m->reach[m->reach_made++] = ARENA_ARRAY(&flow->arena, Reach, 1);
    Reach *reach = m->reach[m->reach_count++];
    Vec3 away = vec3_sub(flow->ways->ways[way].facet.middle, m->first.source.facet->middle);
    reach->way = way;
    reach->growths = -1;
    reach->queued = false;
    reach->distance = vec3_length(away);
    return reach;
}

static bool is_whole(const Merged *m, int way) {
    return m->stamp[way] == m->search && m->reach[m->place[way]]->growths > MOST_GROWTHS;
}

// A beam comes to the portal of a way; false when it is part of the one that is there.
static bool grow(Flow *flow, const Beam *beam) {
    Merged *m = flow->merged;
    // Corners are known to an epsilon's thousandth.
    double slack = 1e-3 * flow->ways->epsilon;
    Reach *reach = reach_of(flow, beam->way);
    if (reach->growths < 0) {
        winding_copy(&reach->source, &beam->source);
        winding_copy(&reach->pass, &beam->pass);
    } else {
        bool source = holds(&reach->source, &beam->source, slack),
             pass = holds(&reach->pass, &beam->pass, slack);
        if (source && pass) return false;
        flow->spent += WORK_GROW;
        bool small = reach->growths < MOST_GROWTHS && (source || unite(&reach->source, &beam->source)) &&
                     (pass || unite(&reach->pass, &beam->pass));
        if (!small) {
            reach->growths = MOST_GROWTHS;
            winding_copy(&reach->source, &m->first.source);
            way_winding(&flow->ways->ways[beam->way], &reach->pass);
        }
    }
    reach->growths++;
    queue_add(m, m->place[beam->way]);
    return true;
}

// The cells in doubt that may be seen through the way, as far as they may lie in the beam; false where there are none.
static bool look_ahead(Flow *flow, const Beam *beam) {
    Merged *m = flow->merged;
    if (m->cells) return true;
    const uint64_t *might = flow->might + (size_t)beam->way * (size_t)flow->ways->words;
    int count = 0, kept = 0;
    m->word_count = 0;
    flow->spent += flow->ways->words / 2;
    for (int k = 0; k < flow->ways->words; k++) {
        uint64_t left = might[k] & flow->unknown[k];
        if (!left) continue;
        m->word[m->word_count] = k;
        m->bits[m->word_count++] = left;
        count += __builtin_popcountll(left);
    }
    if (count > MOST_BOXES) return true;
    flow->spent += WORK_BOX * count;
    for (int i = 0; i < m->word_count; i++) {
        uint64_t left = m->bits[i];
        for (uint64_t bits = left; bits; bits &= bits - 1) {
            int cell = m->word[i] * 64 + __builtin_ctzll(bits);
            if (!flow_box_in_beam(flow->ways->boxes[cell], &beam->planes, flow->ways->epsilon))
                left &= ~(bits & -bits);
        }
        m->word[kept] = m->word[i];
        m->bits[kept] = left;
        kept += left != 0;
    }
    m->word_count = kept;
    return kept > 0;
}

static bool leads_on(const Flow *flow, int way) {
    const Merged *m = flow->merged;
    if (m->cells) return true;
    const uint64_t *might = flow->might + (size_t)way * (size_t)flow->ways->words;
    for (int i = 0; i < m->word_count; i++) {
        if (m->bits[i] & might[m->word[i]] & flow->unknown[m->word[i]]) return true;
    }
    return false;
}

// A line through the middle of both parts, which may prove more than the cell that it is aimed at.
static void try_line(Flow *flow, const Beam *beam) {
    Merged *m = flow->merged;
    Finding *finding = flow->context;
    Vec3 from = winding_middle(&beam->source), to = winding_middle(&beam->pass);
    Vec3 direction = vec3_normalize(vec3_sub(to, from));
    flow->spent += WORK_LINE;
    if (!cast_line(finding->rounds->cast, m->first.way, from, direction, &m->path)) return;
    cast_record(&m->path, from, direction, finding);
    for (int i = m->path.source + 1; i < m->path.count; i++) {
        row_add(finding->kept, m->path.cells[i]);
        row_drop(flow->unknown, m->path.cells[i]);
    }
}

static void list_cell(Merged *m, int cell) {
    if (m->cell_stamp[cell] == m->search) return;
    m->cell_stamp[cell] = m->search;
    if (m->cell_count < m->most_cells) m->cells[m->cell_count] = cell;
    m->cell_count++;
}

static void come_to(Flow *flow, const Beam *beam) {
    int cell = flow->ways->ways[beam->way].to;
    if (flow->merged->cells) {
        list_cell(flow->merged, cell);
        return;
    }
    if (!row_has(flow->unknown, cell)) return;
    try_line(flow, beam);
    row_add(((Finding *)flow->context)->kept, cell);
    row_drop(flow->unknown, cell);
}

// May a line that came out of cell `source` through the first way go on through `next`, as far as it is known by now? Then the cell
// beyond may be seen through the first way, and that cell through the way back.
static bool may_pass(const Flow *flow, int source, int next) {
    size_t words = (size_t)flow->ways->words;
    int to = flow->ways->ways[next].to;
    if (flow->merged->cells) return to != source;
    return to != source && row_has(flow->might + (size_t)flow->merged->first.way * words, to) &&
           row_has(flow->might + (size_t)(next ^ 1) * words, source);
}

static void look_through(Flow *flow, const Reach *reach) {
    Merged *m = flow->merged;
    const WayGraph *ways = flow->ways;
    int way = reach->way, source = ways->ways[m->first.way].from, cell = ways->ways[way].to;
    const Beam *here = way == m->first.way ? &m->first : &m->here;
    if (here == &m->here) {
        m->here.way = way;
        winding_copy(&m->here.source, &reach->source);
        winding_copy(&m->here.pass, &reach->pass);
        beam_planes(&m->here.source, &m->here.pass, ways->epsilon, &m->here.planes);
        flow->work.separators += m->here.planes.count;
    }
    flow->spent += WORK_VISIT;
    if (!look_ahead(flow, here)) return;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && flow->spent < flow->allowed; i++) {
        int next = ways->list[i];
        uint64_t cutting;
        if (next == (way ^ 1) || !may_pass(flow, source, next) || is_whole(m, next)) continue;
        if (beam_meets(&ways->ways[next], &here->planes, ways->epsilon, &cutting) < 0) continue;
        if (!leads_on(flow, next)) continue;
        flow->spent += WORK_CLIP;
        flow->work.chains++;
        if (!beam_narrow(ways, &m->first, here, next, cutting, &m->next, &flow->work)) continue;
        come_to(flow, &m->next);
        grow(flow, &m->next);
    }
}

bool merged_search(Flow *flow, int way) {
    if (!flow->merged) flow->merged = merged_new(flow);
    Merged *m = flow->merged;
    m->search++;
    m->reach_count = m->queue_count = 0;
    beam_begin(flow->ways, way, &m->first);
    come_to(flow, &m->first);
    grow(flow, &m->first);
    while (m->queue_count > 0 && flow->spent < flow->allowed && m->cell_count <= m->most_cells)
        look_through(flow, queue_take(m));
    return m->queue_count == 0 && flow->spent < flow->allowed;
}

int merged_cells(Flow *flow, int way, int *cells, int most) {
    if (!flow->merged) flow->merged = merged_new(flow);
    Merged *m = flow->merged;
    m->cells = cells;
    m->cell_count = 0;
    m->most_cells = most;
    int count = merged_search(flow, way) && m->cell_count <= most ? m->cell_count : -1;
    m->cells = NULL;
    m->most_cells = m->cell_count = 0;
    return count;
}
