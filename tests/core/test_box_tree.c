// test_box_tree.c - the tree of boxes: it finds what trying all boxes finds, and looks at few.
#include <criterion/criterion.h>

#include "engine/core/box_tree.h"
#include "engine/core/random.h"
#include "tests/support/support.h"

// A box of any kind that a plan may bring: extended, flat, points, empty, one upon another, and some a long way off.
static Box random_box(Random *random) {
    double far = random_index(random, 50) == 0 ? 1e11 : 10;
    // On a grid, so that boxes touch and middles tie.
    Vec3 p = {round(random_between(random, -far, far)), round(random_between(random, -far, far)),
              random_index(random, 3)};
    int kind = random_index(random, 10);
    if (kind == 0) return box_empty();
    Vec3 size = {kind < 3 ? 0 : random_index(random, 4), kind < 5 ? 0 : random_index(random, 4),
                 kind < 8 ? 0 : random_index(random, 2)};
    return (Box){p, vec3_add(p, size)};
}

// Proves that a search finds the boxes that trying all of them finds, in ascending order, and that the tree visits every box
// that is not empty.
Test(box_tree, finds_what_all_pairs_find) {
    Random random = {11};
    BoxHits hits = {0};
    Arena arena = {0};
    for (int turn = 0; turn < support_count(400, 8000); turn++) {
        Arena here = {0};
        int count = random_index(&random, turn % 10 == 0 ? 300 : 20);
        Box *boxes = ARENA_ARRAY(&here, Box, count);
        for (int i = 0; i < count; i++) boxes[i] = random_box(&random);
        BoxTree tree = box_tree_build(boxes, count, &here);
        for (int k = 0; k < 20; k++) {
            Box box = random_box(&random);
            if (k == 0) box = (Box){{-1e12, -1e12, -1e12}, {1e12, 1e12, 1e12}};
            int found = box_tree_find(&tree, box, &arena, &hits), next = 0;
            for (int i = 0; i < count; i++) {
                if (!box_overlap(boxes[i], box)) continue;
                cr_assert(next < found && hits.items[next] == i, "turn %d: box %d of %d", turn, i, count);
                next++;
            }
            cr_assert_eq(next, found, "turn %d: %d found, %d meet it", turn, found, next);
        }
        arena_free(&here);
    }
    arena_free(&arena);
}

// How many nodes and boxes a search for a square's neighbours looks at, in the mean over all squares of side^2, which lie in
// a square, or in one row.
static double looked_per_search(int side, bool row, bool outlier) {
    Arena arena = {0};
    int count = side * side;
    Box *boxes = ARENA_ARRAY(&arena, Box, count + 1);
    for (int i = 0; i < count; i++) {
        Vec3 p = row ? vec3(i, 0, 0) : vec3(i % side, i / side, 0);
        boxes[i] = (Box){p, vec3_add(p, vec3(0.9, 0.9, 0))};
    }
    if (outlier) boxes[count] = (Box){{1e11, 1e11, 0}, {1e11, 1e11, 0}};
    BoxTree tree = box_tree_build(boxes, count + outlier, &arena);
    BoxHits hits = {0};
    long long found = 0;
    for (int i = 0; i < count; i++) found += box_tree_find(&tree, box_grow(boxes[i], 0.2), &arena, &hits);
    cr_expect_eq(found, row ? 3LL * count - 2 : (3LL * side - 2) * (3LL * side - 2));
    arena_free(&arena);
    return (double)hits.looked / count;
}

// Proves that a search costs as the logarithm of what there is, and that one box far away does not change that. 100 boxes in a
// square take 33 nodes and boxes for nine neighbours, and 3 more for each doubling; half as much again is allowed. Trying all
// would take 100, and twice as many for each doubling.
Test(box_tree, looks_at_few) {
    for (int side = 10; side <= 320; side *= 2) {
        double bound = 50 + 4.5 * log2(side * side / 100.0);
        for (int kind = 0; kind < 4; kind++) {
            double looked = looked_per_search(side, kind & 1, kind & 2);
            cr_expect_leq(looked, bound, "%d boxes, kind %d: %.1f looked at", side * side, kind, looked);
        }
    }
}
