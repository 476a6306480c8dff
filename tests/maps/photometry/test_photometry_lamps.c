// test_photometry_lamps.c - which lamps have a photometric file, with which flux, and the openings from which their light leaves.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "maps/photometry/photometry_file.h"
#include "tests/support/files/tables.h"
#include "tests/support/support.h"

// Exitances and fluxes are floats.
static const double FLOAT = 2e-7;

static const char ROOM[] =
    "plan 1\nmaterial grey reflectance 0.5\nmaterial glow reflectance 0.1 emission 7\nstorey s floor 0 "
    "height 3\n"
    "room hall 0,0 6,0 6,5 0,5 wall 0.15\n"
    "model pendant kind lamp\n box -.2,-.2,1.9 .2,.2,2.2 grey\n light 0,0,1.95 %s\nend\n"
    "model bulb kind lamp\n box -.1,-.1,1 .1,.1,1.2 glow\nend\n";

static void write_text(const char *path, const char *text) {
    Error error;
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
}

// A room with lamps in a folder of its own: its path. `light` are the words of the pendant's light, `more` further lines.
static const char *write_room(Arena *arena, const char *light, const char *more) {
    const char *path = arena_format(arena, "%s/room.plan", support_folder(arena));
    write_text(path, arena_format(arena, "%s%s", arena_format(arena, ROOM, light), more));
    return path;
}

static const char *beside(Arena *arena, const char *path, const char *name) {
    return arena_format(arena, "%.*s%s", (int)(strrchr(path, '/') - path) + 1, path, name);
}

static void read_good(Arena *arena, const char *path, Building *b) {
    Error error = {""};
    cr_assert(maps_read(path, arena, b, &error), "%s", error.text);
}

static double lumens_of(Rgb flux) {
    double w[3];
    rgb_doubles(flux, w);
    return LIGHT_LUMENS_PER_WATT * light_luminous(w);
}

// Proves that a light's own statement names a file, a file of a lamp's name beside the building is found, and an option takes the place of
// both; that a stated flux or lumens counts with a stated file alone, and else the file's flux in the light's colour; and that each file
// changes the building's hash.
Test(photometry_lamps, are_found) {
    Arena arena = {0};
    Building b, plain, named;
    Error error = {""};
    const char *path =
        write_room(&arena, "flux 8 4 2 photometry spot.ies angle 30",
                   "place pendant 1,1 name one angle 20\nplace pendant 3,3\nlight bare 5,4,2 lumens 1366\n"
                   "light street 5,1,2 flux 2 1 1\nplace bulb 2,4 name glowing\n");
    write_text(beside(&arena, path, "spot.ies"), tables_ies(&arena, TABLE_SPOT, LISTED_ONE, 5, vec2(0, 0)));
    read_good(&arena, path, &plain);
    cr_assert_eq(plain.light_count, 4);
    cr_assert_eq(plain.photometry_count, 2);
    cr_expect(plain.lights[0].photometry == 1 && plain.lights[1].photometry == 1 &&
              plain.lights[2].photometry == 0);
    cr_expect(plain.lights[0].flux.r == 8 && plain.lights[0].flux.b == 2);
    cr_expect(fabs(plain.lights[0].turn - 50 * M_PI / 180) < 1e-12, "turned by %g", plain.lights[0].turn);
    cr_expect(plain.lights[2].flux.r == 2 && plain.lights[2].flux.b == 2, "1366 lm are %g W",
              (double)plain.lights[2].flux.r);

    write_text(beside(&arena, path, "street.ldt"),
               tables_ldt(&arena, TABLE_STREET, LISTED_SIDE, 5, vec2(0, 0)));
    read_good(&arena, path, &named);
    cr_assert_eq(named.photometry_count, 3);
    const Light *street = &named.lights[3];
    cr_expect(street->photometry == 2 &&
              fabs(lumens_of(street->flux) / photometry_lumens(&named.photometries[2]) - 1) < FLOAT);
    cr_expect(fabsf(street->flux.r - 2 * street->flux.g) < 1e-6f * street->flux.r, "its colour stays");
    cr_expect_neq(named.hash, plain.hash);

    read_good(&arena, path, &b);
    const char *option = arena_format(&arena, "pendant=%s", beside(&arena, path, "street.ldt"));
    cr_assert(photometry_for_name(option, &arena, &b, &error), "%s", error.text);
    cr_expect(b.lights[0].photometry == 1 && b.lights[1].photometry == 2 && b.photometry_count == 3);
    cr_expect(fabs(lumens_of(b.lights[1].flux) / photometry_lumens(&b.photometries[2]) - 1) < FLOAT);
    cr_expect_neq(b.hash, named.hash);
    // An object that glows is a lamp, too.
    option = arena_format(&arena, "glowing=%s", beside(&arena, path, "spot.ies"));
    cr_assert(photometry_for_name(option, &arena, &b, &error), "%s", error.text);
    cr_assert_eq(b.light_count, 5);
    lamp_faces_add(&arena, &b);
    const Polygon *p = &b.polygons[b.objects[b.lights[4].object].first_polygon];
    cr_expect(b.materials[p->material].emission.r == 0 && b.materials[p->material].reflectance.r > 0,
              "it still glows by itself");
    arena_free(&arena);
}

// Proves that a name without a lamp, a missing or broken file that is named, and lights with two fluxes or none are refused with a
// sentence; and that a broken file which only lies beside the building is passed over with a note.
Test(photometry_lamps, faults) {
    static const struct {
        const char *light, *option, *expected;
    } CASES[] = {
        {"flux 1 photometry none.ies", NULL, "light pendant: "},
        {"flux 1 photometry ../spot.ies", NULL, "(allowed: files in its own folder or below)"},
        {"flux 1 photometry broken.ies", NULL, "broken.ies:2: the number of lamps is `x`"},
        {"flux 1 lumens 3", NULL, "room.plan:8: a light with both flux and lumens (allowed: flux, or lumens"},
        {"radius 0.1", NULL, "room.plan:8: a light without a flux (allowed: flux, or lumens"},
        {"flux 1", "nobody=FILE", "no lamp of"},
        {"flux 1", "pendant", "--photometry is `pendant` (allowed NAME=FILE)"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        Error error = {""};
        const char *path = write_room(&arena, CASES[i].light, "place pendant 1,1\n"),
                   *option = CASES[i].option;
        write_text(beside(&arena, path, "broken.ies"), "TILT=NONE\nx");
        write_text(beside(&arena, path, "FILE"), tables_ies(&arena, TABLE_SPOT, LISTED_ONE, 5, vec2(0, 0)));
        bool good = maps_read(path, &arena, &b, &error);
        if (option && strchr(option, '='))
            option = arena_format(&arena, "nobody=%s", beside(&arena, path, "FILE"));
        if (good && option) good = photometry_for_name(option, &arena, &b, &error);
        cr_expect(!good && strstr(error.text, CASES[i].expected), "case %zu says `%s`, not `%s`", i,
                  error.text, CASES[i].expected);
        arena_free(&arena);
    }
    Arena arena = {0};
    Building b;
    const char *path = write_room(&arena, "flux 1", "place pendant 1,1\n");
    write_text(beside(&arena, path, "pendant.ies"), "TILT=NONE\nx");
    read_good(&arena, path, &b);
    cr_assert(b.note_count == 1 && strstr(b.notes[0].text, "passed over: ") &&
              strstr(b.notes[0].text, "pendant.ies:2:"));
    cr_expect_eq(b.lights[0].photometry, 0);
    arena_free(&arena);
}

// A face that a lamp with a table is given.
typedef struct Side {
    double watts, z, up, width, height;
    const LampSpread *spread;
} Side;

static Side opening_of(const Building *b, int polygon) {
    const Polygon *p = &b->polygons[polygon];
    const Vec3 *v = b->vertices + p->first_vertex;
    const Material *m = &b->materials[p->material];
    Side o = {.z = v[0].z, .up = plane_of_polygon(v, p->vertex_count).n.z, .spread = &b->spreads[m->spread]};
    o.watts = polygon_area(v, p->vertex_count) * (double)m->emission.g;
    // Along C0 of the lamp, which is turned.
    Vec3 along = vec3(cos(o.spread->turn), sin(o.spread->turn), 0);
    for (int i = 0; i < 4; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % 4], v[i]);
        if (fabs(vec3_dot(edge, along)) > 0.5 * vec3_length(edge))
            o.width = vec3_length(edge);
        else
            o.height = vec3_length(edge);
    }
    return o;
}

// Proves that light down leaves from below a lamp that hangs and light up from above it, each with its share of the flux, from an opening
// of the file's size, turned; that both leave above a lamp that stands; and that this, and light for which there is no room, is noted.
Test(photometry_lamps, openings) {
    static const struct {
        double low, high, light, below, above;
        int faces;
    } CASES[] = {
        {1.9, 2.2, 1.95, 1.895, 2.205, 2}, {0, 1.5, 1.4, 1.505, 1.51, 2}, {2.8, 3, 2.85, 2.795, 0, 1}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        const char *path = write_room(
            &arena, "flux 1",
            arena_format(
                &arena,
                "model m kind lamp\n box -.2,-.2,%g .2,.2,%g grey\n"
                " light -.1,0,%g photometry up.ldt angle 90\n light .1,0,%g photometry up.ldt angle 90\n"
                "end\nplace m 2,2 angle 10\n",
                CASES[i].low, CASES[i].high, CASES[i].light, CASES[i].light));
        write_text(beside(&arena, path, "up.ldt"),
                   tables_ldt(&arena, TABLE_UP, LISTED_ALL, 15, vec2(0.2, 0.5)));
        read_good(&arena, path, &b);
        int first = b.polygon_count, notes = b.note_count;
        cr_assert_eq(lamp_faces_add(&arena, &b), 1);
        cr_assert_eq(b.polygon_count - first, CASES[i].faces);
        const Photometry *t = &b.photometries[1];
        for (int k = 0; k < CASES[i].faces; k++) {
            Side o = opening_of(&b, first + k);
            cr_expect(o.spread->table == t && o.spread->side == k && (o.up > 0.99) == (k == 1));
            cr_expect(fabs(o.z - (k ? CASES[i].above : CASES[i].below)) < 1e-9, "case %zu, side %d at %g", i,
                      k, o.z);
            cr_expect(fabs(o.watts * 683 / t->lumens[k] - 1) < FLOAT, "case %zu, side %d: %g lm, not %g", i,
                      k, o.watts * 683, t->lumens[k]);
            cr_expect(fabs(o.width - 0.2) < 1e-9 && fabs(o.height - 0.5) < 1e-9, "%g x %g", o.width,
                      o.height);
            cr_expect(fabs(o.spread->turn - 100 * M_PI / 180) < 1e-9);
        }
        cr_expect_eq(b.note_count - notes, i > 0);
        if (i == 1)
            cr_expect(strstr(b.notes[notes].text, "% of its light that go down leave above the lamp"));
        if (CASES[i].faces == 1)
            cr_expect(strstr(b.notes[notes].text, "% of its light that go up are left out"), "%s",
                      b.notes[notes].text);
        arena_free(&arena);
    }
}
