// door_states.c - the states that `--doors` names.
#include "engine/sim/door_states.h"

#include "engine/sim/door_part.h"

const char *const WALK_DOORS_NAMES[WALK_DOORS] = {"open", "closed", "drawn", "random"};

float walk_random_share(Random *random) {
    int state = random_index(random, 4);
    float share = (float)random_unit(random), hardly = share * share * share * share;
    return state == 0 ? 0 : state == 1 ? 1 : state == 2 ? share : fmaxf(hardly, 1e-6f);
}

float walk_door_share(const Building *building, int opening, WalkDoors doors, Random *random) {
    float any = walk_random_share(random);
    switch (doors) {
    case WALK_DOORS_CLOSED:
        return 0;
    case WALK_DOORS_DRAWN:
        return (float)building->openings[opening].open;
    case WALK_DOORS_RANDOM:
        return any;
    default:
        return 1;
    }
}

// A view is behind a leaf when the leaf covers this share of its middle, nearer than this, metres; the eye keeps this far from leaves.
static const double COVERED = 0.4, NEAR = 1.2, EYE_CLEAR = 0.05;
// The middle of a view is this share of it, and is tried in so many directions.
static const double MIDDLE = 0.6;
enum { TRIES = 9 };

static bool is_behind(const Building *b, int opening, double share, const Viewpoint *v) {
    int covered = 0;
    bool within = false;
    for (int i = -TRIES / 2; i <= TRIES / 2 && !within; i++) {
        double yaw = v->yaw + MIDDLE * v->fov * i / (TRIES - 1);
        Vec2 from = vec2(v->eye.x, v->eye.y), way = vec2(NEAR * cos(yaw), NEAR * sin(yaw)), normal;
        bool met = false;
        for (int k = 0; k < door_part_count(b, opening) && !within; k++) {
            DoorPart part;
            Vec3 plan[LEAF_CORNERS];
            if (!door_part(b, opening, k, share, &part)) continue;
            Solid solid = door_part_solid(&part, plan);
            Band band = {v->eye.z - EYE_CLEAR, v->eye.z + EYE_CLEAR};
            within = solid_distance(&solid, band, from) < EYE_CLEAR;
            met = met || (!within && solid_sweep(&solid, band, from, way, EYE_CLEAR / 2, &normal) < 1);
        }
        covered += met;
    }
    return within || covered >= COVERED * TRIES;
}

void walk_clear_views(const Building *b, float *door_open) {
    for (int o = 0; o < b->opening_count; o++) {
        if (b->openings[o].kind != OPENING_DOOR) continue;
        const float shares[] = {door_open[o], 1, 0, (float)b->openings[o].open};
        int fewest = b->viewpoint_count + 1;
        for (size_t i = 0; i < sizeof shares / sizeof *shares && fewest > 0; i++) {
            int behind = 0;
            for (int v = 0; v < b->viewpoint_count; v++)
                behind += is_behind(b, o, (double)shares[i], &b->viewpoints[v]);
            if (behind < fewest) fewest = behind, door_open[o] = shares[i];
        }
    }
}
