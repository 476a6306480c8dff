// sh3d_fixture.h - homes of a few walls and pieces.
#ifndef TESTS_SH3D_FIXTURE_H
#define TESTS_SH3D_FIXTURE_H

// 1e-9 m: what double arithmetic leaves of numbers with few digits.
#define CLOSE 1e-9

#define assert_vec2(p, X, Y)                                                                                 \
    cr_assert(fabs((p).x - (X)) < CLOSE && fabs((p).y - (Y)) < CLOSE, "(%.9g, %.9g) is not (%g, %g)", (p).x, \
              (p).y, (double)(X), (double)(Y))

#endif
