// curved_shapes.c - see the header.
#include "tests/maps/curved_shapes.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/curved/curved_patch.h"
#include "tests/support/support.h"

double curved_between(Random *random, double low, double high) { return random_between(random, low, high); }

void curved_random_patch(Random *random, CurvedControl control[PATCH_CONTROLS]) {
    for (int i = 0; i < PATCH_CONTROLS; i++) {
        Vec3 p = vec3(i % 4 + curved_between(random, -0.3, 0.3), i / 4 + curved_between(random, -0.3, 0.3),
                      curved_between(random, -0.5, 0.5));
        control[i] = (CurvedControl){p, curved_between(random, 0.3, 3)};
    }
}
