// test_mesh_contacts.c - elements cut along what stands on a face, or close before it: none lies on both sides, nothing of a face is
// lost, what is covered shoots by itself, and no light lands under what is closed.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const double CLOSE = 0.05;

typedef struct Rectangle {
    double x0, y0, x1, y1;
} Rectangle;

// 4 x 3 x 2.5 m, the floor its fifth face, with a lamp.
static Lit *room(void) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    return lit;
}

static int the_floor(const Lit *lit) {
    for (int f = 0; f < lit->mesh.face_count; f++)
        if (lit->mesh.faces[f].plane.n.z > 0.9 && lit->mesh.faces[f].origin.z == 0) return f;
    cr_assert_fail("no floor");
    return -1;
}

static void finish(Lit *lit, double element, int per_patch, const MeshSplits *splits) {
    MeshOptions options = {.element = element, .per_patch = per_patch, .close = CLOSE, .splits = splits};
    lit_finish_with(lit, &options);
}

static Vec3 middle_of(const Mesh *mesh, const Element *e) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < e->corner_count; i++)
        sum = vec3_add(sum, mesh->vertices[mesh->corners[e->first_corner + i]]);
    return vec3_scale(sum, 1.0 / e->corner_count);
}

static bool in_rectangle(const Rectangle *r, Vec3 p, double by) {
    return p.x > r->x0 + by && p.x < r->x1 - by && p.y > r->y0 + by && p.y < r->y1 - by;
}

static double area_of(const Mesh *mesh, int face) {
    double area = 0;
    for (int e = 0; e < mesh->element_count; e++)
        if (mesh->elements[e].face == face) area += mesh->elements[e].area;
    return area;
}

// Corners, and the middles of edges, of an element, told apart by an outline: 1 all inside, 0 all outside, -1 both.
static int side_of(const Mesh *mesh, const Element *e, const Rectangle *r) {
    // Thinner than a millimetre nothing is cut off.
    const double by = 1.5e-3;
    bool inside = in_rectangle(r, middle_of(mesh, e), 0);
    for (int i = 0; i < e->corner_count; i++) {
        Vec3 p = mesh->vertices[mesh->corners[e->first_corner + i]],
             q = mesh->vertices[mesh->corners[e->first_corner + (i + 1) % e->corner_count]];
        for (int k = 0; k < 8; k++) {
            Vec3 v = vec3_lerp(p, q, k / 8.0);
            if (inside ? !in_rectangle(r, v, -by) : in_rectangle(r, v, by)) return -1;
        }
    }
    return inside;
}

// Checks a floor on which things with these outlines stand. Returns the area inside them, m^2.
static double check_floor(const Lit *lit, const Rectangle *outlines, int count) {
    const Mesh *mesh = &lit->mesh;
    int face = the_floor(lit);
    double inside = 0;
    cr_assert_float_eq(area_of(mesh, face), 12, 1e-9, "the floor has %.12g m^2", area_of(mesh, face));
    for (int p = 0; p < mesh->patch_count; p++) {
        const Patch *patch = &mesh->patches[p];
        int sides[2] = {0, 0};
        bool looks_inside = false, looks_covered;
        if (patch->face != face) continue;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
            int within = 0;
            for (int r = 0; r < count; r++) {
                int side = side_of(mesh, &mesh->elements[e], &outlines[r]);
                Vec3 m = middle_of(mesh, &mesh->elements[e]);
                cr_assert_geq(side, 0, "element %d about %g %g lies on both sides of outline %d", e, m.x, m.y,
                              r);
                within |= side;
            }
            sides[within]++;
            if (within) inside += mesh->elements[e].area;
            cr_assert_eq(mesh_element_at(mesh, face, middle_of(mesh, &mesh->elements[e])), e);
        }
        cr_assert(sides[0] == 0 || sides[1] == 0, "patch %d has %d elements open and %d covered", p, sides[0],
                  sides[1]);
        // Between two boxes, on their border, both is true.
        looks_covered = sides[1] > 0;
        for (int r = 0; r < count; r++)
            looks_inside |= in_rectangle(&outlines[r], patch->centre, looks_covered ? -1e-6 : 1e-6);
        cr_assert_eq(looks_inside, looks_covered, "patch %d looks from %g %g", p, patch->centre.x,
                     patch->centre.y);
    }
    return inside;
}

static RadOptions options_of(Culling culling) {
    RadOptions o = rad_default_options();
    o.form_factor.resolution = 60;
    o.residual = 1e-3;
    o.culling = culling;
    return o;
}

// Emitted = absorbed + escaped + unshot, and the same light culled and not; returns it.
static RadSolution check_light(Lit *lit) {
    RadSolution s, all;
    RadOptions options = options_of(CULL_STAB);
    lit_shoot(lit, &options, &s);
    options = options_of(CULL_NONE);
    lit_shoot(lit, &options, &all);
    cr_assert_eq(memcmp(s.radiosity, all.radiosity, (size_t)s.element_count * sizeof *s.radiosity), 0);
    for (int c = 0; c < 3; c++) {
        double power = s.absorbed[c] + s.escaped[c];
        for (int p = 0; p < s.patch_count; p++) power += s.unshot[p][c] * lit->mesh.patches[p].area;
        cr_assert_float_eq(power, s.emitted[c], 1e-9 * s.emitted[c]);
    }
    return s;
}

// The most light of an element of the floor inside an outline, W/m^2.
static double most_light(const Lit *lit, const RadSolution *s, const Rectangle *r) {
    int face = the_floor(lit);
    double most = 0;
    for (int e = 0; e < s->element_count; e++) {
        const Element *element = &lit->mesh.elements[e];
        if (element->face == face && side_of(&lit->mesh, element, r) == 1)
            most = fmax(most, s->radiosity[e][0]);
    }
    return most;
}

// Proves that the floor under a box is told from the floor around it, whether the box has a bottom or not, on the floor, a centimetre
// above it, and nearly as far as counts; and that where the box is closed, on the floor, no light at all is under it.
Test(mesh_contacts, a_box_on_the_floor) {
    static const double GAPS[] = {0, 0.01, 0.049};
    static const Rectangle OUTLINE = {1.13, 0.71, 2.27, 1.94};
    for (int bottom = 0; bottom < 2; bottom++) {
        for (int g = 0; g < 3; g++) {
            Lit *lit = room();
            lit_box(lit, vec3(OUTLINE.x0, OUTLINE.y0, GAPS[g]), vec3(OUTLINE.x1, OUTLINE.y1, 0.8), false,
                    LIT_RED, bottom ? 0 : 1 << 4);
            finish(lit, 0.4, 2, NULL);
            double inside = check_floor(lit, &OUTLINE, 1), whole = 1.14 * 1.23;
            // Tolerance: what is thinner than a millimetre is not cut off.
            cr_assert_float_eq(inside, whole, 5e-3, "gap %g: %g m^2 of %g", GAPS[g], inside, whole);
            RadSolution s = check_light(lit);
            if (GAPS[g] == 0)
                cr_assert_eq(most_light(lit, &s, &OUTLINE), 0, "%g", most_light(lit, &s, &OUTLINE));
            lit_free(lit);
        }
    }
}

// Proves the same in a doll's house, narrower than a metre along x or y.
Test(mesh_contacts, a_box_in_a_small_room) {
    static const Vec3 SIZES[] = {{0.75, 16, 1}, {16, 0.75, 1}};
    for (int i = 0; i < 2; i++) {
        Lit *lit = lit_new();
        const Rectangle outline = {0.31, 0.23, 0.53, 0.47};
        lit_box(lit, vec3(0, 0, 0), SIZES[i], true, LIT_WALL, 0);
        lit_box(lit, vec3(outline.x0, outline.y0, 0.01), vec3(outline.x1, outline.y1, 0.3), false, LIT_RED,
                0);
        finish(lit, 0.2, 2, NULL);
        // Tolerance: what is thinner than a millimetre is not cut off.
        cr_assert_float_eq(check_floor(lit, &outline, 1), 0.22 * 0.24, 1e-3);
        lit_free(lit);
    }
}

// Proves that what is farther from the floor cuts nothing.
Test(mesh_contacts, a_box_beyond_close) {
    Lit *lit = room();
    lit_box(lit, vec3(1.13, 0.71, 0.06), vec3(2.27, 1.94, 0.8), false, LIT_RED, 0);
    finish(lit, 0.4, 2, NULL);
    const Face *face = &lit->mesh.faces[the_floor(lit)];
    cr_assert_eq(face->element_count, face->nx * face->ny);
    check_light(lit);
    lit_free(lit);
}

// Proves that what stands in the middle of a patch does not become the place that the floor around it shoots from.
Test(mesh_contacts, a_small_box_in_the_middle_of_a_patch) {
    Lit *lit = room();
    finish(lit, 0.5, 2, NULL);
    Vec3 m = lit->mesh.patches[lit->mesh.faces[the_floor(lit)].first_patch].centre;
    const Rectangle outline = {m.x - 0.13, m.y - 0.11, m.x + 0.13, m.y + 0.11};
    Lit *with = room();
    lit_box(with, vec3(outline.x0, outline.y0, 0), vec3(outline.x1, outline.y1, 0.5), false, LIT_RED, 1 << 4);
    finish(with, 0.5, 2, NULL);
    check_floor(with, &outline, 1);
    RadSolution s = check_light(with);
    cr_assert_eq(most_light(with, &s, &outline), 0, "%g W/m^2 under it", most_light(with, &s, &outline));
    lit_free(with);
    lit_free(lit);
}

// Proves the same of cupboards side by side, whose sides in one place say of each other that all is open there.
Test(mesh_contacts, boxes_side_by_side) {
    static const Rectangle OUTLINES[3] = {{0.6, 0, 1.2, 0.6}, {1.2, 0, 1.83, 0.6}, {1.83, 0, 2.4, 0.55}};
    Lit *lit = room();
    for (int i = 0; i < 3; i++) {
        const Rectangle *r = &OUTLINES[i];
        lit_box(lit, vec3(r->x0, r->y0, 0), vec3(r->x1, r->y1, 0.9), false, LIT_RED, 0);
    }
    finish(lit, 0.4, 2, NULL);
    check_floor(lit, OUTLINES, 3);
    RadSolution s = check_light(lit);
    for (int i = 0; i < 3; i++) cr_assert_eq(most_light(lit, &s, &OUTLINES[i]), 0);
    lit_free(lit);
}

// Proves that no element lies on both sides of a partition across the room, nor any patch: of two sheets in one place, and of a board
// of 5 cm.
Test(mesh_contacts, a_partition) {
    static const double THICK[] = {0, 0.05};
    for (int i = 0; i < 2; i++) {
        Lit *lit = room();
        double x0 = 1.71, x1 = x0 + THICK[i];
        lit_quad(lit, vec3(x1, 0, 0), vec3(x1, 3, 0), vec3(x1, 3, 2), vec3(x1, 0, 2), LIT_RED);
        lit_quad(lit, vec3(x0, 3, 0), vec3(x0, 0, 0), vec3(x0, 0, 2), vec3(x0, 3, 2), LIT_RED);
        finish(lit, 0.4, 2, NULL);
        const Rectangle left = {-1, -1, x0, 4}, right = {x1, -1, 5, 4};
        int face = the_floor(lit);
        cr_assert_float_eq(area_of(&lit->mesh, face), 12, 1e-9);
        for (int e = 0; e < lit->mesh.element_count; e++) {
            const Element *element = &lit->mesh.elements[e];
            if (element->face != face) continue;
            Vec3 m = middle_of(&lit->mesh, element);
            cr_assert(side_of(&lit->mesh, element, &left) >= 0 && side_of(&lit->mesh, element, &right) >= 0,
                      "%g m thick: element %d about %g %g lies on both sides", THICK[i], e, m.x, m.y);
        }
        check_light(lit);
        lit_free(lit);
    }
}

// Proves that a box through the wall cuts it where it goes through, both ways: what of the box's sides is outside the room is elements of
// its own, in the dark.
Test(mesh_contacts, a_box_through_a_wall) {
    Lit *lit = room();
    lit_box(lit, vec3(3.5, 1.11, 0.93), vec3(4.61, 2.07, 1.71), false, LIT_RED, 0);
    finish(lit, 0.4, 2, NULL);
    const Mesh *mesh = &lit->mesh;
    RadSolution s = check_light(lit);
    double area = 0, dark = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Polygon *p = &lit->graph.polygons[mesh->faces[f].polygon];
        double whole = polygon_area(lit->graph.vertices + p->first_vertex, p->vertex_count);
        cr_assert_float_eq(area_of(mesh, f), whole, 1e-9 * whole);
    }
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const Face *face = &mesh->faces[element->face];
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < element->corner_count; i++) {
            double x = mesh->vertices[mesh->corners[element->first_corner + i]].x;
            low = fmin(low, x);
            high = fmax(high, x);
        }
        if (face->material == LIT_RED) {
            cr_assert(low > 4 - 2e-3 || high < 4 + 2e-3, "element %d is from x = %g to %g", e, low, high);
            if (low > 4 - 2e-3) cr_assert_eq(s.radiosity[e][0], 0);
        }
        Vec3 m = middle_of(mesh, element);
        if (fabs(m.x - 4) > 1e-6 || m.y < 1.11 || m.y > 2.07 || m.z < 0.93 || m.z > 1.71) continue;
        area += element->area;
        dark = fmax(dark, s.radiosity[e][0]);
    }
    cr_assert_float_eq(area, 0.96 * 0.78, 5e-3, "%g m^2 of the wall are inside the box", area);
    cr_assert_eq(dark, 0);
    lit_free(lit);
}

// Proves that faces with a sheet of their size in the same place, or all but in it, keep their elements: no NaN, nothing lost.
Test(mesh_contacts, coplanar_and_all_but_parallel_sheets) {
    static const double TILTS[] = {0, 1e-9, 1e-4, 2e-3};
    for (int i = 0; i < 4; i++) {
        double t = TILTS[i];
        Lit *lit = room();
        lit_quad(lit, vec3(0.5, 0.5, t), vec3(0.5, 2.5, 0), vec3(3.5, 2.5, -t), vec3(3.5, 0.5, 0), LIT_RED);
        lit_quad(lit, vec3(0.5, 0.5, -0.001 - t), vec3(3.5, 0.5, -0.001), vec3(3.5, 2.5, t - 0.001),
                 vec3(0.5, 2.5, -0.001), LIT_RED);
        finish(lit, 0.4, 2, NULL);
        double area = area_of(&lit->mesh, the_floor(lit));
        cr_assert_float_eq(area, 12, 1e-9, "tilt %g: %.12g", t, area);
        check_light(lit);
        lit_free(lit);
    }
}

// Proves that a building a thousand kilometres from the origin is cut as well as at it: as many elements, of the same areas.
Test(mesh_contacts, far_from_the_origin) {
    Lit *lit[2];
    static const MeshSplits ONCE = {.even = 1};
    for (int k = 0; k < 2; k++) {
        Vec3 o = {k * 1e6, k * 1e6, 0};
        lit[k] = lit_new();
        lit_box(lit[k], o, vec3_add(o, vec3(4, 3, 2.5)), true, LIT_WALL, 0);
        lit_lamp(lit[k], vec3_add(o, vec3(2, 1.5, 2.4)));
        lit_box(lit[k], vec3_add(o, vec3(1.13, 0.71, 0)), vec3_add(o, vec3(2.27, 1.94, 0.8)), false, LIT_RED,
                0);
        finish(lit[k], 0.4, 2, &ONCE);
    }
    cr_assert_eq(lit[0]->mesh.element_count, lit[1]->mesh.element_count);
    cr_assert_eq(lit[0]->mesh.patch_count, lit[1]->mesh.patch_count);
    for (int e = 0; e < lit[0]->mesh.element_count; e++)
        cr_assert_float_eq(lit[0]->mesh.elements[e].area, lit[1]->mesh.elements[e].area, 1e-8);
    check_light(lit[1]);
    for (int k = 0; k < 2; k++) lit_free(lit[k]);
}

// A box turned by an angle, standing on the floor, without a bottom.
static void add_turned(Lit *lit, Vec3 middle, double angle, double half_x, double half_y) {
    Vec3 v[4], up = {0, 0, 0.6};
    for (int i = 0; i < 4; i++) {
        double x = i == 1 || i == 2 ? half_x : -half_x, y = i >= 2 ? half_y : -half_y;
        v[i] = vec3_add(middle, vec3(x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle), 0));
    }
    for (int i = 0; i < 4; i++) {
        Vec3 p = v[i], q = v[(i + 1) % 4];
        lit_quad(lit, p, q, vec3_add(q, up), vec3_add(p, up), LIT_RED);
    }
    lit_quad(lit, vec3_add(v[0], up), vec3_add(v[1], up), vec3_add(v[2], up), vec3_add(v[3], up), LIT_RED);
}

// Proves that whatever stands on a floor, askew and through each other, on splits of any kind, nothing of it is lost, elements stay convex,
// and every point is in the element that is said to be there.
Test(mesh_contacts, random_boxes) {
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(20, 500); seed++) {
        Random random = {seed};
        Lit *lit = room();
        unsigned char bits[64];
        MeshSplits splits = {.bit_count = 8 * sizeof bits, .bits = bits};
        for (size_t i = 0; i < sizeof bits; i++)
            bits[i] = (unsigned char)(random_next(&random) & random_next(&random));
        for (int i = 1 + random_index(&random, 8); i > 0; i--) {
            Vec3 at = {random_between(&random, 0.5, 3.5), random_between(&random, 0.5, 2.5), 0};
            add_turned(lit, at, random_between(&random, 0, 6.28), random_between(&random, 0.02, 0.5),
                       random_between(&random, 0.02, 0.5));
        }
        finish(lit, 0.4, 1 + random_index(&random, 4), seed % 2 ? &splits : NULL);
        const Mesh *mesh = &lit->mesh;
        int face = the_floor(lit);
        double area = area_of(mesh, face);
        cr_assert_float_eq(area, 12, 1e-8, "seed %llu: %.12g m^2", (unsigned long long)seed, area);
        for (int k = 0; k < 500; k++) {
            Vec3 p = {random_between(&random, 0, 4), random_between(&random, 0, 3), 0};
            const Element *e = &mesh->elements[mesh_element_at(mesh, face, p)];
            for (int i = 0; i < e->corner_count; i++) {
                Vec3 a = mesh->vertices[mesh->corners[e->first_corner + i]],
                     b = mesh->vertices[mesh->corners[e->first_corner + (i + 1) % e->corner_count]];
                Vec3 inwards = vec3_normalize(vec3_cross(vec3(0, 0, 1), vec3_sub(b, a)));
                double off = vec3_dot(inwards, vec3_sub(p, a));
                // Tolerance: corners are welded.
                cr_assert_geq(off, -1e-6, "seed %llu: %g %g is %g m outside", (unsigned long long)seed, p.x,
                              p.y, off);
            }
        }
        for (int i = 0; i < mesh->patch_count; i++)
            cr_assert_leq(mesh->patches[i].element_count, MESH_MOST_IN_PATCH);
        lit_free(lit);
    }
}
