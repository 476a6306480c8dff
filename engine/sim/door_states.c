// door_states.c - the states that `--doors` names.
#include "engine/sim/door_states.h"

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
