// test_predicates.c - the sign of three points in the plane, against whole numbers: coordinates are chosen so that the
// determinant fits into 128 bits.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/random.h"
#include "engine/core/vec.h"

enum { TRIANGLES = 200000 };

typedef struct Whole {
    int64_t x, y;  // below 2^60: differences below 2^61, their products below 2^122
} Whole;

__extension__ typedef __int128 Product;

static int sign_of(Whole a, Whole b, Whole c) {
    Product left = (Product)(a.x - c.x) * (b.y - c.y), right = (Product)(a.y - c.y) * (b.x - c.x);
    return (left > right) - (left < right);
}

// A whole number of at most `bits` bits that a double holds.
static int64_t whole(Random *random, int bits) {
    int64_t n = (int64_t)(random_unit(random) * 0x1p53) - ((int64_t)1 << 52);  // 53 bits with the sign
    return bits > 53 ? n * ((int64_t)1 << (bits - 53)) : n >> (53 - bits);
}

// A double within a few steps of where the line a -> b is at t: on it, or all but.
static Whole near_line(Random *random, Whole a, Whole b) {
    double t = 3 * random_unit(random) - 1;
    Whole c = {(int64_t)((double)a.x + t * (double)(b.x - a.x)),
               (int64_t)((double)a.y + t * (double)(b.y - a.y))};
    return (Whole){(int64_t)(double)c.x, (int64_t)(double)c.y};
}

static void try(uint64_t seed, const char *what, int bits, Whole (*third)(Random *, Whole, Whole)) {
    Random random = {seed};
    int flat = 0;
    for (int i = 0; i < TRIANGLES; i++) {
        Whole a = {whole(&random, bits), whole(&random, bits)},
              b = {whole(&random, bits), whole(&random, bits)};
        Whole c = third(&random, a, b);
        // 2^-40: a scale changes nothing, and coordinates are no longer whole.
        Vec2 p = vec2(ldexp((double)a.x, -40), ldexp((double)a.y, -40));
        Vec2 q = vec2(ldexp((double)b.x, -40), ldexp((double)b.y, -40));
        Vec2 r = vec2(ldexp((double)c.x, -40), ldexp((double)c.y, -40));
        int sign = sign_of(a, b, c);
        flat += sign == 0;
        cr_assert_eq(orient2d(p, q, r), sign, "%s, seed %llu, triangle %d", what, (unsigned long long)seed,
                     i);
        cr_assert_eq(orient2d(q, p, r), -sign, "%s, seed %llu, triangle %d turned", what,
                     (unsigned long long)seed, i);
    }
    cr_log_info("%s: %d of %d collinear", what, flat, TRIANGLES);
}

static Whole anywhere(Random *random, Whole a, Whole b) {
    (void)a, (void)b;
    return (Whole){whole(random, 60), whole(random, 60)};
}

// The corner of a parallelogram's diagonal: a, b and c are collinear to the last bit.
static Whole beyond(Random *random, Whole a, Whole b) {
    int64_t k = 1 + (int64_t)(3 * random_unit(random));
    return (Whole){b.x + k * (b.x - a.x), b.y + k * (b.y - a.y)};
}

// As far from the line as a grid allows: one unit.
static Whole beside(Random *random, Whole a, Whole b) {
    Whole c = beyond(random, a, b);
    return (Whole){c.x + (int64_t)(3 * random_unit(random)) - 1, c.y};
}

// Proves that the sign is right wherever the points lie; on grids all but the first stage are asked, too.
Test(predicates, of_three_points_are_exact) {
    try(1, "anywhere", 60, anywhere);
    try(2, "near a line", 60, near_line);
    try(3, "near a line of few bits", 30, near_line);
    try(4, "on a line, on a grid", 24, beyond);
    try(5, "beside a line, on a grid", 24, beside);
    try(6, "on a line, products beyond 53 bits", 45, beyond);
    try(7, "beside a line, products beyond 53 bits", 45, beside);
}

// Where differences round but their products do not: a far away in the direction of b - c, whose parts are powers of two. The
// sign is that of what the differences lose.
Test(predicates, see_what_differences_lose) {
    Random random = {8};
    for (int i = 0; i < TRIANGLES; i++) {
        Whole c = {whole(&random, 9), whole(&random, 9)};
        int64_t dx = (int64_t)1 << random_index(&random, 6), dy = (int64_t)1 << random_index(&random, 6);
        Whole b = {c.x + dx, c.y - dy};
        Whole a = {dx * ((int64_t)1 << 54), -dy * ((int64_t)1 << 54)};
        Vec2 p = vec2((double)a.x, (double)a.y), q = vec2((double)b.x, (double)b.y),
             r = vec2((double)c.x, (double)c.y);
        cr_assert_eq(orient2d(p, q, r), sign_of(a, b, c), "triangle %d of seed 8", i);
        cr_assert_eq(orient2d(q, r, p), sign_of(b, c, a), "triangle %d of seed 8, turned", i);
    }
}

// Where of the two products only one is rounded, to what the other is: the difference of the rounded ones is 0, the sign is not. Either
// product may be the rounded one, and c lie anywhere.
Test(predicates, see_what_one_product_loses) {
    Random random = {9};
    int rounded = 0;
    for (int i = 0; i < TRIANGLES; i++) {
        int64_t u = whole(&random, 30) | 1, v = whole(&random, 28) | 1;
        Product exact = (Product)u * v;
        int64_t near = (int64_t)(double)(int64_t)exact, factor = 1;
        for (; near % 2 == 0 && factor < (1 << 10); factor *= 2) near /= 2;
        if (llabs(near) > (int64_t)1 << 53) continue;
        rounded += (Product)near * factor != exact;
        // (a.x - c.x) (b.y - c.y) is the one, (a.y - c.y) (b.x - c.x) the other.
        Whole c = {0, 0};
        if (i % 4 > 1) c = (Whole){whole(&random, 8), whole(&random, 8)};
        Whole a = {c.x + near, c.y + u}, b = {c.x + v, c.y + factor};
        if (i % 2) a = (Whole){c.x + u, c.y + near}, b = (Whole){c.x + factor, c.y + v};
        if (llabs(a.x) > (int64_t)1 << 53 || llabs(a.y) > (int64_t)1 << 53) continue;
        Vec2 p = vec2((double)a.x, (double)a.y), q = vec2((double)b.x, (double)b.y),
             r = vec2((double)c.x, (double)c.y);
        cr_assert_eq(orient2d(p, q, r), sign_of(a, b, c), "triangle %d of seed 9", i);
        cr_assert_eq(orient2d(q, p, r), sign_of(b, a, c), "triangle %d of seed 9, turned", i);
    }
    cr_assert_gt(rounded, TRIANGLES / 4);
}
