// flow_search.c - see flow.h.
//
// Source: the search along chains is that of Quake's vis (J. Carmack, 1996). It departs from that program in that cells
// already decided are not looked for, and a chain is given up as soon as no cell in doubt touches its beam.
#include "visibility/pairs/flow.h"

// The work of steps, see ways_work.
enum { WORK_BOX = 6, WORK_WAY = 5, WORK_NARROW = 60, WORK_PLANES = 200, WORK_MEET = 60 };

static bool has_work(const Flow *flow) { return flow->spent < flow->allowed; }

void flow_start(Flow *flow, const WayGraph *ways, const uint64_t *might) {
    *flow = (Flow){.ways = ways, .might = might, .allowed = INT64_MAX};
    flow->unknown = ARENA_ARRAY(&flow->arena, uint64_t, ways->words);
    flow->steps = ARENA_ARRAY(&flow->arena, FlowStep *, ways->cell_count + 1);
    flow->on_path = ARENA_ARRAY(&flow->arena, unsigned char, ways->cell_count);
    flow->stack = ARENA_ARRAY(&flow->arena, int, ways->cell_count);
    flow->within = ARENA_ARRAY(&flow->arena, uint64_t, ways->words);
    flow->goals = ARENA_ARRAY(&flow->arena, uint64_t, ways->words);
}

void flow_end(Flow *flow) { arena_free(&flow->arena); }

static FlowStep *step_at(Flow *flow, int depth) {
    if (!flow->steps[depth]) {
        flow->steps[depth] = ARENA_ARRAY(&flow->arena, FlowStep, 1);
        flow->steps[depth]->word = ARENA_ARRAY(&flow->arena, int, flow->ways->words);
        flow->steps[depth]->bits = ARENA_ARRAY(&flow->arena, uint64_t, flow->ways->words);
    }
    return flow->steps[depth];
}

bool flow_box_in_beam(Box box, const Separators *planes, double epsilon) {
    Vec3 half = vec3_scale(vec3_sub(box.max, box.min), 0.5), middle = vec3_add(box.min, half);
    for (int i = 0; i < planes->count; i += FOUR) {
        Four x = four_load(planes->x + i), y = four_load(planes->y + i), z = four_load(planes->z + i);
        Four at = x * middle.x + y * middle.y + z * middle.z - four_load(planes->d + i);
        Four reach = four_abs(x) * half.x + four_abs(y) * half.y + four_abs(z) * half.z;
        if (four_lanes(at + reach <= epsilon)) return false;
    }
    return true;
}

// Drops the cells that are decided by now or outside the beam; false when none is left.
static bool keep_in_beam(Flow *flow, FlowStep *step) {
    int kept = 0;
    flow->spent += 2 * step->word_count;
    for (int i = 0; i < step->word_count; i++) {
        uint64_t left = step->bits[i] & flow->unknown[step->word[i]];
        for (uint64_t bits = left; bits; bits &= bits - 1) {
            int cell = step->word[i] * 64 + __builtin_ctzll(bits);
            flow->spent += WORK_BOX;
            if (!flow_box_in_beam(flow->ways->boxes[cell], &step->beam.planes, flow->ways->epsilon))
                left &= ~(bits & -bits);
        }
        step->word[kept] = step->word[i];
        step->bits[kept] = left;
        kept += left != 0;
    }
    step->word_count = kept;
    return kept > 0;
}

// The wanted cells beyond `from` that may be seen through `way`; false where there are none.
static bool want(Flow *flow, const FlowStep *from, int way, FlowStep *to) {
    const uint64_t *might = flow->might + (size_t)way * (size_t)flow->ways->words;
    to->word_count = 0;
    flow->spent += WORK_WAY + 2 * from->word_count;
    for (int i = 0; i < from->word_count; i++) {
        int word = from->word[i];
        uint64_t left = from->bits[i] & flow->unknown[word] & might[word];
        to->word[to->word_count] = word;
        to->bits[to->word_count] = left;
        to->word_count += left != 0;
    }
    return to->word_count > 0;
}

// A line that comes through the first way and this one leads back, seen the other way round, into the cell that it came from.
static bool leads_back(const Flow *flow, int way) {
    const WayGraph *ways = flow->ways;
    const uint64_t *back = flow->might + (size_t)(way ^ 1) * (size_t)ways->words;
    return row_has(back, ways->ways[flow->steps[0]->beam.way].from);
}

static void want_unknown(const Flow *flow, FlowStep *out) {
    out->word_count = 0;
    for (int i = 0; i < flow->ways->words; i++) {
        if (!flow->unknown[i]) continue;
        out->word[out->word_count] = i;
        out->bits[out->word_count++] = flow->unknown[i];
    }
}

// Clips the portal of the way and the source through which it is seen. False when nothing is left.
static bool narrow(Flow *flow, const FlowStep *from, int way, FlowStep *step) {
    uint64_t cutting;
    if (beam_meets(&flow->ways->ways[way], &from->beam.planes, flow->ways->epsilon, &cutting) < 0)
        return false;
    flow->spent += WORK_NARROW;
    step->recorded = false;
    return beam_narrow(flow->ways, &flow->steps[0]->beam, &from->beam, way, cutting, &step->beam,
                       &flow->work);
}

// Follows a chain less from now on; none when asked to stop.
static void lose_patience(Flow *flow) {
    enum { CHAINS = 4096 };  // some milliseconds
    flow->left--;
    if (flow->go_on && flow->left % CHAINS == 0 && !flow->go_on(flow)) flow->left = 0;
}

static void follow_chain(Flow *flow, int depth) {
    const WayGraph *ways = flow->ways;
    FlowStep *step = flow->steps[depth];
    int cell = flow_cell(flow, depth);
    if (row_has(flow->unknown, cell)) flow->arrive(flow, depth);
    Beam *beam = &step->beam;
    if (depth > 0) beam_planes(&beam->source, &beam->pass, ways->epsilon, &beam->planes);
    flow->work.separators += beam->planes.count;
    flow->spent += WORK_PLANES;
    if (!keep_in_beam(flow, step)) return;
    FlowStep *next = step_at(flow, depth + 1);
    flow->on_path[cell] = 1;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && flow->left > 0 && has_work(flow); i++) {
        int way = ways->list[i];
        if (flow->on_path[ways->to[i]]) continue;
        if (!want(flow, step, way, next) || !leads_back(flow, way)) continue;
        lose_patience(flow);
        flow->work.chains++;
        if (narrow(flow, step, way, next)) follow_chain(flow, depth + 1);
    }
    flow->on_path[cell] = 0;
}

static FlowStep *first_step(Flow *flow, int way) {
    FlowStep *step = step_at(flow, 0);
    beam_begin(flow->ways, way, &step->beam);
    step->recorded = false;
    want_unknown(flow, step);
    return step;
}

bool flow_search(Flow *flow, int way) {
    int from = flow->ways->ways[way].from;
    if (!has_work(flow)) return false;
    first_step(flow, way);
    flow->left = flow->patience;
    flow->on_path[from] = 1;
    follow_chain(flow, 0);
    flow->on_path[from] = 0;
    return flow->left > 0 && has_work(flow);
}

// The cells of `within` that were not reached yet and touch the beam. Returns how many.
static int wanted_in_beam(Flow *flow, const Beam *beam, const uint64_t *reached) {
    int count = 0;
    for (int k = 0; k < flow->ways->words; k++) {
        uint64_t left = flow->within[k] & ~reached[k];
        for (uint64_t bits = left; bits; bits &= bits - 1) {
            int cell = k * 64 + __builtin_ctzll(bits);
            flow->spent += WORK_BOX;
            if (!flow_box_in_beam(flow->ways->boxes[cell], &beam->planes, flow->ways->epsilon))
                left &= ~(bits & -bits);
        }
        flow->goals[k] = left;
        count += __builtin_popcountll(left);
    }
    return count;
}

// Floods on from a cell through portals that the beam meets, within the cells of `within`, until no goal is left.
static void reach_on(Flow *flow, const Beam *beam, int cell, int goals, uint64_t *reached) {
    const WayGraph *ways = flow->ways;
    int depth = 0;
    flow->stack[depth++] = cell;
    row_drop(flow->within, cell);
    goals -= row_has(flow->goals, cell);
    row_add(reached, cell);
    while (depth > 0 && goals > 0) {
        cell = flow->stack[--depth];
        for (int i = ways->first[cell]; i < ways->first[cell + 1]; i++) {
            int to = ways->to[i], way = ways->list[i];
            uint64_t cutting;
            if (!row_has(flow->within, to) || !leads_back(flow, way)) continue;
            flow->spent += WORK_MEET;
            if (beam_meets(&ways->ways[way], &beam->planes, ways->epsilon, &cutting) < 0) continue;
            row_drop(flow->within, to);
            goals -= row_has(flow->goals, to);
            row_add(reached, to);
            flow->stack[depth++] = to;
        }
    }
}

void flow_reach(Flow *flow, int way, const uint64_t *may, uint64_t *reached) {
    const WayGraph *ways = flow->ways;
    Beam *first = &step_at(flow, 0)->beam, *next = &step_at(flow, 1)->beam;
    int from = ways->ways[way].from, cell = ways->ways[way].to;
    beam_begin(ways, way, first);
    if (row_has(may, cell)) row_add(reached, cell);
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && has_work(flow); i++) {
        int to = ways->to[i], after = ways->list[i];
        if (to == from || !row_has(may, to) || !leads_back(flow, after)) continue;
        const uint64_t *might = flow->might + (size_t)after * (size_t)ways->words;
        uint64_t fresh = 0;
        for (int k = 0; k < ways->words; k++) {
            flow->within[k] = may[k] & might[k];
            fresh |= flow->within[k] & ~reached[k];
        }
        if (!fresh) continue;
        flow->work.chains++;
        flow->spent += WORK_NARROW + WORK_PLANES;
        if (!beam_narrow(ways, first, first, after, 0, next, &flow->work)) continue;
        beam_planes(&next->source, &next->pass, ways->epsilon, &next->planes);
        flow->work.separators += next->planes.count;
        // Where that portal lies in a plane of the beam, so does the box of a cell without another portal.
        row_add(reached, to);
        int goals = wanted_in_beam(flow, next, reached);
        if (goals > 0) reach_on(flow, next, to, goals, reached);
    }
    if (!has_work(flow)) {
        for (int k = 0; k < ways->words; k++) reached[k] |= may[k];
    }
}

void flow_cone(Vec3 eye, const Winding *through, Separators *out) {
    out->count = 0;
    for (int i = 0; i < through->count; i++) {
        Vec3 a = vec3_sub(winding_corner(through, i), eye), b = vec3_sub(winding_corner(through, i + 1), eye);
        // The winding is counter-clockwise about the direction of sight: its inside is to the left of each edge.
        separators_add(out, vec3_cross(a, b), eye);
    }
}

// The part of the way's portal that is seen from the point; false where there is none.
static bool narrow_cone(Flow *flow, const FlowStep *from, int way, FlowStep *step) {
    const WayShape *here = &flow->ways->ways[way];
    double epsilon = flow->ways->epsilon;
    Vec3 point = flow->point;
    Beam *beam = &step->beam;
    beam->way = way;
    step->recorded = false;
    flow->spent += WORK_NARROW;
    if (plane_distance(here->facet.plane, point) > -epsilon - facet_doubt(&here->facet, point)) return false;
    uint64_t cutting;
    if (beam_meets(here, &from->beam.planes, epsilon, &cutting) < 0) return false;
    way_winding(here, &beam->pass);
    if (!beam_cut(&beam->pass, &from->beam.planes, cutting, epsilon)) return false;
    flow_cone(point, &beam->pass, &beam->planes);
    return true;
}

static void look_on(Flow *flow, int depth, void (*arrive)(Flow *flow, int depth)) {
    const WayGraph *ways = flow->ways;
    FlowStep *step = flow->steps[depth];
    int cell = flow_cell(flow, depth);
    if (row_has(flow->unknown, cell)) arrive(flow, depth);
    if (!keep_in_beam(flow, step)) return;
    FlowStep *next = step_at(flow, depth + 1);
    flow->on_path[cell] = 1;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && has_work(flow); i++) {
        int way = ways->list[i];
        if (flow->on_path[ways->to[i]]) continue;
        if (!want(flow, step, way, next) || !leads_back(flow, way)) continue;
        flow->work.chains++;
        if (narrow_cone(flow, step, way, next)) look_on(flow, depth + 1, arrive);
    }
    flow->on_path[cell] = 0;
}

void flow_look(Flow *flow, int way, void (*arrive)(Flow *flow, int depth)) {
    int from = flow->ways->ways[way].from;
    if (!has_work(flow)) return;
    first_step(flow, way);
    flow->on_path[from] = 1;
    look_on(flow, 0, arrive);
    flow->on_path[from] = 0;
}
