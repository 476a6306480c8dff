// test_sun_nodes.c - the sun's disc at nodes: penumbrae in closed form, edges of sun patches where light is shown, nodes against rays.
#include <criterion/criterion.h>
#include <stdio.h>

#include "radiosity/shoot/sunlight.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/reconstruct.h"
#include "radiosity/show/shown.h"
#include "radiosity/show/sun_nodes.h"
#include "radiosity/truth/path_walk.h"
#include "tests/radiosity/shoot/sky_fixture.h"

static const double DEGREE = M_PI / 180;

// A day with nothing but a sun of 300 W/m^2.
static Daylight sun_alone(Vec3 sun) {
    return (Daylight){.sun = vec3_normalize(sun), .beam = {100, 100, 100}};
}

// The share of a disc on one side of a line that passes its middle at a distance of u radii.
static double beside_line(double u) {
    if (fabs(u) >= 1) return u > 0;
    return 0.5 + (asin(u) + u * sqrt(1 - u * u)) / M_PI;
}

static double sun_at(SunPatch *at, const Mesh *mesh, int face, Vec3 point) {
    double light[3] = {0};
    sun_patch_look(at, mesh->elements[mesh_element_at(mesh, face, point)].patch, 0);
    sun_patch_add(at, point, light);
    return light[1];
}

static void lay(Lit *lit, double x0, double y0, double x1, double y1, double z) {
    lit_quad(lit, vec3(x0, y0, z), vec3(x1, y0, z), vec3(x1, y1, z), vec3(x0, y1, z), LIT_WALL);
}

// Proves the width of penumbrae in closed form: a level plate 5 m above level ground has a straight edge, and the share of the disc that
// the ground sees beyond it is a segment of a circle. With the sun overhead the penumbra is 2 * 5 m * tan(radius) = 4.7 cm wide; under a
// sun 30 degrees high it is twice as wide where the sun stands along the edge, and four times where across it. Tolerance: 24 corners stand
// for the disc, from whose limb they lie up to 0.6 % of the radius away, which moves shares by 0.3 % at most; the cosine changes over the
// disc of the low sun by 0.8 %, which the closed form leaves out.
Test(sun_nodes, penumbra_in_closed_form) {
    Lit *lit = lit_new();
    lay(lit, -20, -20, 20, 20, 0);
    lay(lit, -30, -30, 0.3, 30, 5);
    lit_finish(lit, 0.37, 2);
    for (int low = 0; low < 3; low++) {
        // The edge runs along y: the low sun stands across it or along it.
        Vec3 sun = low == 0   ? vec3(0, 0, 1)
                   : low == 1 ? vec3(cos(30 * DEGREE), 0, sin(30 * DEGREE))
                              : vec3(0, cos(30 * DEGREE), sin(30 * DEGREE));
        double along = 5 / sun.z, radius = along * tan(DAYLIGHT_SUN_RADIUS) / (low == 1 ? sun.z : 1),
               edge = 0.3 - along * sun.x, worst = 0;
        Daylight day = sun_alone(sun);
        SunNodes *nodes = sun_nodes_new(&lit->mesh, &day, &lit->arena);
        SunPatch *at = sun_patch_new(nodes, &lit->arena);
        for (int i = -60; i <= 60; i++) {
            double u = i / 50.0, h = sun_at(at, &lit->mesh, 0, vec3(edge + u * radius, 0.11, 0));
            worst = fmax(worst, fabs(h / (100 * sun.z) - beside_line(u)));
        }
        printf("sun %d: penumbra %.2f cm wide, off by %.2g of the sun's light\n", low, 200 * radius, worst);
        cr_expect_lt(worst, low == 0 ? 0.004 : 0.012);
    }
    lit_free(lit);
}

// ---- rooms with windows: light as it is shown, against polygons projected along the sun's beams

// The first faces are the receivers: floor and back wall; all others may hide the sun.
enum { FLOOR, BACK, RECEIVERS };

// A wall across x that hides all but an opening, and looks along +x.
static void wall_with_window(Lit *lit, double x, double y0, double y1, double z0, double z1) {
    const double at[4][4] = {{-8, -4, 12, z0}, {-8, z1, 12, 6}, {-8, z0, y0, z1}, {y1, z0, 12, z1}};
    for (int i = 0; i < 4; i++) {
        double a = at[i][0], low = at[i][1], b = at[i][2], high = at[i][3];
        lit_quad(lit, vec3(x, a, low), vec3(x, b, low), vec3(x, b, high), vec3(x, a, high), LIT_WALL);
    }
}

enum { ONE_WINDOW, TWO_WINDOWS, HALF_OPEN_LEAF, BLINDS, ROOMS };
static const char *const ROOM_NAMES[ROOMS] = {"window", "two windows", "half open leaf", "blinds"};

static Lit *room_of(int kind) {
    static const MeshSplits EVEN = {.even = 1};
    Lit *lit = lit_new();
    lit_quad(lit, vec3(0, -3, 0), vec3(6, -3, 0), vec3(6, 7, 0), vec3(0, 7, 0), LIT_WALL);
    lit_quad(lit, vec3(6, -3, 0), vec3(6, -3, 3), vec3(6, 7, 3), vec3(6, 7, 0), LIT_WALL);
    wall_with_window(lit, 0, 1.03, 2.26, kind == HALF_OPEN_LEAF ? 0 : 0.87, 2.12);
    if (kind == TWO_WINDOWS) wall_with_window(lit, -1.4, 0.71, 2.47, 1.17, 2.55);
    // Hinged at a jamb, as high as the doorway, and open by 40 degrees.
    Vec3 tip = vec3(0.8 * sin(40 * DEGREE), 1.03 + 0.8 * cos(40 * DEGREE), 0);
    if (kind == HALF_OPEN_LEAF)
        lit_quad(lit, vec3(0, 1.03, 0), tip, vec3(tip.x, tip.y, 2.12), vec3(0, 1.03, 2.12), LIT_WALL);
    for (int i = 0; kind == BLINDS && i < 11; i++) {
        double z = 0.93 + 0.11 * i;
        lit_quad(lit, vec3(-0.06, 1, z), vec3(-0.02, 1, z + 0.03), vec3(-0.02, 2.3, z + 0.03),
                 vec3(-0.06, 2.3, z), LIT_WALL);
    }
    MeshOptions mesh = mesh_default_options();
    mesh.element = 0.25;
    mesh.splits = &EVEN;
    lit_finish_with(lit, &mesh);
    return lit;
}

// Does a beam from the point meet no polygon but the receivers?
static bool beam_is_free(const Lit *lit, Vec3 point, Vec3 sun) {
    const Building *b = lit->building;
    for (int p = RECEIVERS; p < b->polygon_count; p++) {
        const Vec3 *v = b->vertices + b->polygons[p].first_vertex;
        Vec3 n = vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0]));
        double t = vec3_dot(n, vec3_sub(v[0], point)) / vec3_dot(n, sun);
        if (!(t > 1e-9)) continue;
        Vec3 at = vec3_add(point, vec3_scale(sun, t));
        int left = 0, right = 0;
        for (int i = 0; i < 4; i++) {
            double side = vec3_dot(n, vec3_cross(vec3_sub(v[(i + 1) % 4], v[i]), vec3_sub(at, v[i])));
            left += side > 0, right += side < 0;
        }
        if (left == 0 || right == 0) return false;
    }
    return true;
}

// The share of the disc, by directions on rings of equal area.
static double share_by_beams(const Lit *lit, Vec3 point, Vec3 sun, int rings) {
    Vec3 x = vec3_normalize(vec3_cross(sun, vec3(0.3, 0.5, 0.1))), y = vec3_cross(sun, x);
    int seen = 0, all = 0;
    for (int i = 0; i < rings; i++) {
        int count = 6 * (2 * i + 1);
        for (int k = 0; k < count; k++, all++) {
            double r = tan(DAYLIGHT_SUN_RADIUS) * (i + 0.5) / rings, turn = 2 * M_PI * (k + 0.37) / count;
            Vec3 off = vec3_add(vec3_scale(x, r * cos(turn)), vec3_scale(y, r * sin(turn)));
            seen += beam_is_free(lit, point, vec3_add(sun, off));
        }
    }
    return (double)seen / all;
}

// Light as it is shown.
typedef struct Shown {
    const Mesh *mesh;
    const RadSolution *light;
    VertexLight nodes;
    RadSolution solution;
} Shown;

static Shown show_sun(Lit *lit, const Daylight *day, int threads) {
    Shown out = {0};
    Error error;
    const Mesh *mesh = &lit->mesh;
    cr_assert(rad_start_dark(mesh, &lit->arena, &out.solution, &error), "%s", error.text);
    out.solution.day = *day;
    sunlight_elements(mesh, day, threads, out.solution.radiosity);
    cr_assert(direct_show(mesh, &lit->forest, NULL, threads, NULL, &lit->arena, &out.solution, NULL));
    cr_assert(shown_light(mesh, &out.solution, NULL, &lit->arena, &out.mesh, &out.light, &error), "%s",
              error.text);
    out.nodes = reconstruct_light(out.mesh, out.light, &lit->arena);
    return out;
}

static double shown_at(const Shown *s, int face, Vec3 point) {
    double light[3];
    reconstruct_at(s->mesh, &s->nodes, face, point, light);
    return light[1];
}

// Where the light changes along the way from a to b, of which one end alone has it.
static Vec3 edge_between(const Lit *lit, Vec3 a, Vec3 b, Vec3 sun) {
    bool lit_a = beam_is_free(lit, a, sun);
    for (int i = 0; i < 40; i++) {
        Vec3 middle = vec3_lerp(a, b, 0.5);
        if (beam_is_free(lit, middle, sun) == lit_a)
            a = middle;
        else
            b = middle;
    }
    return a;
}

// How far the place at which shown light crosses half of `full` lies from an exact edge, along the normal of that; metres.
static double off_edge(const Shown *s, int face, Vec3 edge, Vec3 across, double full) {
    double best = INFINITY, step = 0.0005;
    for (int i = -120; i < 120; i++) {
        double a = shown_at(s, face, vec3_add(edge, vec3_scale(across, i * step))) - full / 2,
               b = shown_at(s, face, vec3_add(edge, vec3_scale(across, (i + 1) * step))) - full / 2;
        if ((a > 0) == (b > 0)) continue;
        double at = step * (i + a / (a - b));
        if (fabs(at) < fabs(best)) best = at;
    }
    return fabs(best);
}

typedef struct Edges {
    int count;
    double worst, mean;
} Edges;

// Looks at edges of light at random places of a receiver.
static void try_edges(const Lit *lit, const Shown *s, const Daylight *day, int face, int tries, Edges *out) {
    static const double REACH = 0.06;
    Random random = {11};
    Vec3 across[2] = {{face == FLOOR, 0, face == BACK}, {0, 1, 0}};
    double full = 0.5 * day->beam[1] * (face == FLOOR ? day->sun.z : -day->sun.x);
    for (int i = 0; i < tries; i++) {
        double u = random_unit(&random), v = random_unit(&random);
        Vec3 a = face == FLOOR ? vec3(0.2 + 5.6 * u, -2.5 + 9 * v, 0) : vec3(6, -2.5 + 9 * v, 0.1 + 2.8 * u);
        Vec3 way = across[i % 2], b = vec3_add(a, vec3_scale(way, 0.02)), turned = across[1 - i % 2];
        if (beam_is_free(lit, a, day->sun) == beam_is_free(lit, b, day->sun)) continue;
        // The edge's direction, from a place beside; and no edge but this one may be near.
        Vec3 aside = vec3_scale(turned, 0.004), edge = edge_between(lit, a, b, day->sun),
             far_a = vec3_add(vec3_sub(edge, vec3_scale(way, 0.03)), aside),
             far_b = vec3_add(vec3_add(edge, vec3_scale(way, 0.03)), aside);
        if (beam_is_free(lit, far_a, day->sun) == beam_is_free(lit, far_b, day->sun)) continue;
        Vec3 along = vec3_normalize(vec3_sub(edge_between(lit, far_a, far_b, day->sun), edge)),
             normal = vec3_sub(way, vec3_scale(along, vec3_dot(way, along)));
        if (vec3_length(normal) < 0.3) continue;
        normal = vec3_normalize(normal);
        if (fabs(share_by_beams(lit, edge, day->sun, 10) - 0.5) > 0.03) continue;
        double before = share_by_beams(lit, vec3_sub(edge, vec3_scale(normal, REACH / 2)), day->sun, 6),
               after = share_by_beams(lit, vec3_add(edge, vec3_scale(normal, REACH / 2)), day->sun, 6);
        if (fabs(before - after) < 0.8) continue;
        double off = off_edge(s, face, edge, normal, full);
        out->count++;
        out->mean += off;
        out->worst = fmax(out->worst, off);
    }
}

// Dates and places; `north` turns the plan so that the sun comes in by the windows, `aside` degrees off their middle line.
static const struct {
    const char *name;
    int year, month, day;
    double hour, latitude, longitude, aside;
} DATES[] = {
    {"summer morning, 50 N", 2026, 6, 21, 10, 50, 0, 12},
    {"low winter sun, 52 N", 2026, 12, 21, 14.9, 52, 0, -9},
    {"polar day, 70 N", 2026, 6, 21, 21.5, 70, 20, 17},
    {"southern hemisphere, Sydney", 2026, 6, 21, 1.5, -33.87, 151.21, -21},
    {"equinox, Tokyo", 2026, 3, 20, 5.2, 35.68, 139.69, 3},
};
enum { DATES_COUNT = sizeof DATES / sizeof *DATES };

static Daylight day_of(int i) {
    SunPosition sun = sun_position(DATES[i].year, DATES[i].month, DATES[i].day, DATES[i].hour,
                                   DATES[i].latitude * DEGREE, DATES[i].longitude * DEGREE);
    // A sun in the direction of -x, 270 degrees clockwise from +y, and a little aside.
    double north = (270 + DATES[i].aside) * DEGREE - sun.azimuth;
    printf("%s: %.2f degrees high\n", DATES[i].name, sun.altitude / DEGREE);
    return sun_alone(sun_direction(&sun, north));
}

// Proves where the edges of sun patches are shown: on floor and back wall, behind a window, behind two, past a half open leaf and through
// blinds, at five dates and places, light crosses half its value within 1 cm of the exact edge, which beams tell that share no code with
// the shown light. Elements of 25 cm are halved down to 1.6 cm there, so that an edge without a penumbra could be off by 0.8 cm.
static void check_room(int kind) {
    Lit *lit = room_of(kind);
    int checked = 0;
    for (int i = 0; i < DATES_COUNT; i++) {
        Daylight day = day_of(i);
        Shown s = show_sun(lit, &day, 2);
        Edges edges = {0};
        for (int face = 0; face < RECEIVERS; face++) try_edges(lit, &s, &day, face, 40000, &edges);
        printf("%s: %d edges, off by %.2f cm in the mean, %.2f cm at most; %d of %d elements\n",
               ROOM_NAMES[kind], edges.count, 100 * edges.mean / fmax(edges.count, 1), 100 * edges.worst,
               s.mesh->element_count, lit->mesh.element_count);
        cr_expect_leq(edges.worst, 0.01);
        checked += edges.count > 10;
    }
    cr_expect_eq(checked, DATES_COUNT);
    lit_free(lit);
}
Test(sun_nodes, edges_behind_a_window, .timeout = 60) { check_room(ONE_WINDOW); }
Test(sun_nodes, edges_behind_two_windows, .timeout = 60) { check_room(TWO_WINDOWS); }
Test(sun_nodes, edges_past_a_half_open_leaf, .timeout = 60) { check_room(HALF_OPEN_LEAF); }
Test(sun_nodes, edges_through_blinds, .timeout = 60) { check_room(BLINDS); }

// Proves that light of sun patches is shown alike on one thread and on two: the low sun lights floor and back wall, which are batches.
Test(sun_nodes, same_on_any_number_of_threads) {
    Lit *lit = room_of(BLINDS);
    Daylight day = day_of(1);
    Shown one = show_sun(lit, &day, 1), two = show_sun(lit, &day, 2);
    cr_assert_eq(one.solution.node_count, two.solution.node_count);
    cr_expect_arr_eq(one.solution.node, two.solution.node,
                     (size_t)one.solution.node_count * sizeof *one.solution.node);
    lit_free(lit);
}

// ---- nodes against rays

// Proves the light at nodes of a furnished room with a window, whose cells, portals and things are left out by quick tests, against rays to
// the disc through the pane. Rays begin 0.1 mm before their face. Tolerance: 768 rays on rings are off by no more than 1 % of the disc
// for an edge, some edges meet at a node, and an edge moves by the 1 mm that nodes are moved off it: 2 % of a penumbra 5 cm wide.
Test(sun_nodes, nodes_against_rays, .timeout = 60) {
    Lit *lit = sky_room_with_window(1.2, 1.3, 0.2);
    const Mesh *mesh = &lit->mesh;
    Daylight day = sun_alone(vec3(1, -0.15, 0.45));
    Nodes nodes = nodes_of(mesh, &lit->arena);
    double(*h)[3] = arena_alloc(&lit->arena, (size_t)nodes.count, sizeof *h);
    PathScene *scene = path_scene_new(mesh, &lit->arena);
    cr_assert(direct_irradiance(mesh, &lit->forest, &nodes, &day, 2, NULL, h, NULL));
    Vec3 x = vec3_normalize(vec3_cross(day.sun, vec3(0.3, 0.5, 0.1))), y = vec3_cross(day.sun, x);
    int whole = 0, dark = 0, parts = 0, off = 0, indoors = 0, glazed = 0;
    for (int n = 0; n < nodes.count; n++) {
        Vec3 normal = nodes.normal[n], middle = {0, 0, 0}, at = mesh->vertices[nodes.vertex[n]];
        double cosine = vec3_dot(normal, day.sun), seen = 0, through = 0;
        int count = nodes.first[n + 1] - nodes.first[n];
        if (cosine < 0.05) continue;
        for (int i = nodes.first[n]; i < nodes.first[n + 1]; i++)
            middle = vec3_add(middle, vec3_scale(element_centroid(mesh, nodes.element[i]), 1.0 / count));
        Vec3 way = vec3_sub(middle, at);
        at = vec3_add(at, vec3_scale(way, fmin(0.01, 1e-3 / vec3_length(way))));
        Vec3 from = vec3_add(at, vec3_scale(normal, 1e-4));
        at = vec3_sub(from, path_scene_origin(scene));
        for (int i = 0, all = 6 * 16 * 8; i < all; i++) {
            double r = tan(DAYLIGHT_SUN_RADIUS) * sqrt((i + 0.5) / all), turn = 2.399963 * i;
            Vec3 aside = vec3_add(vec3_scale(x, r * cos(turn)), vec3_scale(y, r * sin(turn)));
            Vec3 ray = vec3_normalize(vec3_add(day.sun, aside));
            bool open = path_scene_trace(scene, at, ray).face < 0;
            seen += open ? 1.0 / all : 0;
            if (open) through += panes_transmit_from_afar(&mesh->panes, from, ray) / all;
        }
        double share = h[n][1] / (day.beam[1] * cosine);
        glazed += seen > 0.9999 && through < 0.95;
        int cell = mesh->patches[mesh->elements[nodes.element[nodes.first[n]]].patch].cell;
        indoors += cell >= 0 && vis_region(&lit->graph, cell)->kind == REGION_ROOM && seen > 0;
        whole += seen > 0.9999, dark += seen == 0, parts += seen > 0 && seen < 0.9999;
        if (fabs(share - through) > 0.04) off++;
    }
    printf("%d nodes have the whole disc, %d none, %d a part; %d are off\n", whole, dark, parts, off);
    cr_expect(whole > 200 && dark > 200 && parts > 20 && indoors > 20 && glazed > 20,
              "%d indoors, %d of them behind the pane", indoors, glazed);
    cr_expect_leq(off, 2);
    path_scene_end(scene);
    lit_free(lit);
}
