// proxy_fixture.c - see the header.
#include "tests/radiosity/mesh/proxy_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

enum { ROUND = 64, PANEL_X = 40, PANEL_Y = 20 };

static void add(Lit *lit, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material) {
    building_add_polygon(&lit->arena, lit->building, (Vec3[4]){p, q, r, s}, 4, material);
}

static Vec3 on_ball(int i, int j) {
    double a = 2 * M_PI * (i % ROUND) / ROUND, b = M_PI * j / (ROUND / 2) - M_PI / 2;
    if (j == 0 || j == ROUND / 2) a = 0;
    return vec3_add(BALL, vec3_scale(vec3(cos(a) * cos(b), sin(a) * cos(b), sin(b)), RADIUS));
}

static void add_ball(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "ball");
    for (int j = 0; j < ROUND / 2; j++) {
        for (int i = 0; i < ROUND; i++) {
            Vec3 v[4] = {on_ball(i, j), on_ball(i + 1, j), on_ball(i + 1, j + 1), on_ball(i, j + 1)};
            int triangle = j == 0 || j + 1 == ROUND / 2;
            if (j == 0) v[1] = v[2], v[2] = v[3];
            building_add_polygon(&lit->arena, lit->building, v, 4 - triangle, LIT_RED);
        }
    }
}

// A point of the panel's grid, up or down.
static Vec3 on_panel(int i, int j, bool up) {
    return vec3(PANEL.min.x + (PANEL.max.x - PANEL.min.x) * i / PANEL_X,
                PANEL.min.y + (PANEL.max.y - PANEL.min.y) * j / PANEL_Y, up ? PANEL.max.z : PANEL.min.z);
}

// Closed, of squares of 2 cm.
static void add_panel(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_FURNITURE, "panel");
    for (int j = 0; j < PANEL_Y; j++) {
        for (int i = 0; i < PANEL_X; i++) {
            add(lit, on_panel(i, j, true), on_panel(i + 1, j, true), on_panel(i + 1, j + 1, true),
                on_panel(i, j + 1, true), LIT_WALL);
            add(lit, on_panel(i, j + 1, false), on_panel(i + 1, j + 1, false), on_panel(i + 1, j, false),
                on_panel(i, j, false), LIT_WALL);
        }
    }
    for (int i = 0; i < PANEL_X; i++) {
        add(lit, on_panel(i, 0, false), on_panel(i + 1, 0, false), on_panel(i + 1, 0, true),
            on_panel(i, 0, true), LIT_WALL);
        add(lit, on_panel(i + 1, PANEL_Y, false), on_panel(i, PANEL_Y, false), on_panel(i, PANEL_Y, true),
            on_panel(i + 1, PANEL_Y, true), LIT_WALL);
    }
    for (int j = 0; j < PANEL_Y; j++) {
        add(lit, on_panel(PANEL_X, j, false), on_panel(PANEL_X, j + 1, false), on_panel(PANEL_X, j + 1, true),
            on_panel(PANEL_X, j, true), LIT_WALL);
        add(lit, on_panel(0, j + 1, false), on_panel(0, j, false), on_panel(0, j, true),
            on_panel(0, j + 1, true), LIT_WALL);
    }
}

// A lampshade: a ring of narrow strips, every fourth of which glows.
static void add_lamp(Lit *lit) {
    building_add_object(&lit->arena, lit->building, OBJECT_LAMP, "lamp");
    for (int i = 0; i < 128; i++) {
        double a = 2 * M_PI * i / 128, b = 2 * M_PI * (i + 1) / 128, r = 0.2;
        Vec3 p = vec3(3 + r * cos(a), 3.5 + r * sin(a), 2.2), q = vec3(3 + r * cos(b), 3.5 + r * sin(b), 2.2);
        Vec3 up = {0, 0, 0.1};
        add(lit, p, q, vec3_add(q, up), vec3_add(p, up), i % 4 == 0 ? LIT_LAMP : LIT_WALL);
    }
}

Lit *proxy_furnished(void) {
    Lit *lit = lit_new();
    Error error = {""};
    VisOptions options = vis_default_options();
    lit_box(lit, vec3(0, 0, 0), vec3(6, 5, 3), true, LIT_WALL, 0);
    add_ball(lit);
    add_panel(lit);
    add_lamp(lit);
    cr_assert(vis_build_cells(lit->building, &options, &lit->arena, &lit->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&lit->graph, &options, NULL, &lit->arena, &lit->forest));
    return lit;
}

const Proxies *proxy_proxies_of(Lit *lit, double tolerance) {
    return proxies_find(&lit->graph, tolerance, &lit->arena);
}
