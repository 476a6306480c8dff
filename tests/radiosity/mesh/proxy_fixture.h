// proxy_fixture.h - fine models and their stand-ins.
#ifndef TESTS_PROXY_FIXTURE_H
#define TESTS_PROXY_FIXTURE_H

#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const Vec3 BALL = {2, 2, 1};

static const double RADIUS = 0.25, THICK = 0.01;

static const Box PANEL = {{3, 1, 0.7}, {3.8, 1.4, 0.71}};

// A room with these three in it, without a mesh yet.
Lit *proxy_furnished(void);

const Proxies *proxy_proxies_of(Lit *lit, double tolerance);

#endif
