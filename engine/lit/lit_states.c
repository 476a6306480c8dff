// lit_states.c - the light as it came, and what lamps that were switched since add to it. What a lamp gives is kept as floats: where the
// strongest lamp goes out, what is left is a difference.
#include "engine/lit/lit_states.h"

#include <string.h>

// Places side by side that are kept together.
enum { BLOCK = 16 };

// Light that is nothing in most places.
typedef struct Blocks {
    int count, block_count;
    int *block;                // [block_count]
    float (*light)[BLOCK][3];  // [block_count] W/m^2
} Blocks;

// The light of a lamp as it is drawn.
typedef struct DrawnLamp {
    bool known;
    Blocks node, element;
} DrawnLamp;

struct LitStates {
    const LitMesh *mesh;
    const WalkLight *light;
    const Lamps *all;
    DrawnLamp *lamps;  // [count]
    int count;         // 0: the light of each is not known
    int *like;         // [mesh->lamp_count] a vertex near the face of a lamp; -1: not looked for yet
    RadSolution sum;
    Arena *arena;
};

LitStates *lit_states_new(const LitMesh *mesh, const WalkLight *light, Arena *arena) {
    LitStates *s = ARENA_ARRAY(arena, LitStates, 1);
    *s = (LitStates){.mesh = mesh, .light = light, .arena = arena};
    s->all = light->states ? light->states->lamps : light_follower_lamps(light);
    s->count = light->states ? s->all->count : 0;
    s->lamps = ARENA_ARRAY(arena, DrawnLamp, s->count + 1);
    s->like = ARENA_ARRAY(arena, int, mesh->lamp_count + 1);
    for (int i = 0; i < mesh->lamp_count; i++) s->like[i] = -1;
    s->sum = *light->solution;
    s->sum.node = arena_alloc(arena, (size_t)s->sum.node_count + 1, sizeof *s->sum.node);
    s->sum.radiosity = arena_alloc(arena, (size_t)s->sum.element_count + 1, sizeof *s->sum.radiosity);
    return s;
}

static bool is_lit(double (*light)[3], int first, int end) {
    for (int i = first; i < end; i++)
        if (rgb_sum(light[i]) != 0) return true;
    return false;
}

static Blocks blocks_new(double (*light)[3], int count, Arena *arena) {
    Blocks out = {.count = count};
    for (int pass = 0; pass < 2; pass++) {
        int kept = 0;
        for (int first = 0; first < count; first += BLOCK) {
            int end = first + BLOCK < count ? first + BLOCK : count;
            if (!is_lit(light, first, end)) continue;
            for (int i = first; i < end && pass == 1; i++)
                for (int c = 0; c < 3; c++) out.light[kept][i - first][c] = (float)light[i][c];
            if (pass == 1) out.block[kept] = first / BLOCK;
            kept++;
        }
        if (pass == 1) break;
        out.block_count = kept;
        out.block = ARENA_ARRAY(arena, int, kept + 1);
        out.light = arena_alloc(arena, (size_t)kept + 1, sizeof *out.light);
    }
    return out;
}

// Light is never less than nothing, whatever differences round to.
static void add_blocks(const Blocks *b, const double share[3], double (*out)[3]) {
    for (int k = 0; k < b->block_count; k++) {
        int first = b->block[k] * BLOCK, count = b->count - first < BLOCK ? b->count - first : BLOCK;
        for (int i = 0; i < count; i++)
            for (int c = 0; c < 3; c++)
                out[first + i][c] = fmax(out[first + i][c] + share[c] * (double)b->light[k][i][c], 0);
    }
}

static void find_lamp(LitStates *s, int lamp) {
    Arena scratch = {0};
    RadSolution one = light_of_source(s->light, lamp, &scratch);
    s->lamps[lamp] = (DrawnLamp){true, blocks_new(one.node, one.node_count, s->arena),
                                 blocks_new(one.radiosity, one.element_count, s->arena)};
    arena_free(&scratch);
}

bool lit_states_prepare(LitStates *s, const Progress *progress) {
    if (s->light->follower && light_follow_begin(s->light, progress)) return true;
    for (int i = 0; i < s->count; i++) {
        if (s->lamps[i].known) continue;
        find_lamp(s, i);
        return true;
    }
    return false;
}

// First all that is added, then all that is taken away: so nothing is cut off on the way.
static void add_differences(LitStates *s, const Rgb *lit, double sign) {
    for (int i = 0; i < s->count; i++) {
        double now[3], before[3], more[3];
        rgb_doubles(lit[i], now);
        rgb_doubles(s->light->solution->lit[i], before);
        for (int c = 0; c < 3; c++) more[c] = sign * fmax(sign * (now[c] - before[c]), 0);
        if (more[0] == 0 && more[1] == 0 && more[2] == 0) continue;
        if (!s->lamps[i].known) find_lamp(s, i);
        add_blocks(&s->lamps[i].node, more, s->sum.node);
        add_blocks(&s->lamps[i].element, more, s->sum.radiosity);
    }
}

// The vertex nearest to a lamp's face, of any other face that reflects.
static int vertex_near(const LitMesh *mesh, const LitFace *lamp) {
    const Building *b = mesh->graph->building;
    const LitVertex *own = &mesh->vertex[lamp->first_vertex];
    int nearest = lamp->first_vertex;
    float least = INFINITY;
    for (int v = 0; v < lit_vertex_count(mesh); v++) {
        const LitVertex *other = &mesh->vertex[v];
        Rgb rho = b->materials[other->material].reflectance, full = b->materials[other->material].full;
        float off = 0;
        if (full.r + full.g + full.b > 0 || !(rho.r + rho.g + rho.b > 0)) continue;
        for (int c = 0; c < 3; c++)
            off += (other->position[c] - own->position[c]) * (other->position[c] - own->position[c]);
        if (off >= least) continue;
        least = off;
        nearest = v;
    }
    return nearest;
}

// A lamp that is made of light alone would be black without it: it looks like what it hangs from.
static void show_dark_lamp(LitStates *s, int index, LitLight *out) {
    const LitMesh *mesh = s->mesh;
    const LitFace *lamp = &mesh->faces[mesh->lamp[index]];
    Rgb rho = mesh->graph->building->materials[lamp->material].reflectance;
    if (lamp->element_count == 0 || rho.r + rho.g + rho.b > 0) return;
    if (s->like[index] < 0) s->like[index] = vertex_near(mesh, lamp);
    for (int v = lamp->first_vertex; v < lamp[1].first_vertex; v++)
        memcpy(out->vertex[v], out->vertex[s->like[index]], sizeof *out->vertex);
}

bool lit_states_sums(const LitStates *s, const float *doors) {
    const Building *b = s->mesh->graph->building;
    for (int i = 0; i < b->opening_count; i++)
        if (b->openings[i].kind == OPENING_DOOR && doors[i] != s->light->door_open[i]) return false;
    return s->count > 0 || s->all->count == 0;
}

// A state of the lamps is a sum while the doors stand as they were baked.
static void add_up(LitStates *s, const Rgb *lit) {
    const RadSolution *base = s->light->solution;
    memcpy(s->sum.node, base->node, (size_t)base->node_count * sizeof *base->node);
    memcpy(s->sum.radiosity, base->radiosity, (size_t)base->element_count * sizeof *base->radiosity);
    add_differences(s, lit, 1);
    add_differences(s, lit, -1);
    if (s->light->follower) light_follow_sum(s->light, lit);
}

static void fill(LitStates *s, const Rgb *lit, const float *doors, const RadSolution *found, LitLight *out) {
    lit_light_fill(s->mesh, found, doors, out);
    for (int i = 0; i < s->mesh->lamp_count; i++) {
        Rgb share = lit[s->all->of_polygon[s->mesh->faces[s->mesh->lamp[i]].polygon]];
        out->on[i] = share.r + share.g + share.b > 0;
        if (!out->on[i]) show_dark_lamp(s, i, out);
    }
}

bool lit_states_fill_soon(LitStates *s, const Rgb *lit, const float *doors, LitLight *out) {
    Arena scratch = {0};
    RadSolution found;
    bool good = !lit_states_sums(s, doors) && s->light->follower &&
                light_follow_soon(s->light, doors, lit, &scratch, &found);
    if (good) fill(s, lit, doors, &found, out);
    arena_free(&scratch);
    return good;
}

bool lit_states_fill(LitStates *s, const Rgb *lit, const float *doors, const Progress *progress,
                     LitLight *out) {
    Arena scratch = {0};
    RadSolution found;
    bool sums = lit_states_sums(s, doors), good = true;
    if (sums)
        add_up(s, lit);
    else
        good = s->light->follower && light_follow(s->light, doors, lit, progress, &scratch, &found);
    if (good) fill(s, lit, doors, sums ? &s->sum : &found, out);
    arena_free(&scratch);
    return good;
}
