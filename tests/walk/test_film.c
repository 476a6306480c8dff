// test_film.c - the automatic tour as a film: its pace, its doors, its rooms, and the length of its video.
#include <criterion/criterion.h>
#include <string.h>

#include "maps/maps.h"
#include "tests/walk/walk_fixture.h"

enum { RATE = 24 };

typedef struct Filmed {
    Walked w;
    TourPath path;
    FilmFigures figures;
} Filmed;

static void film(Filmed *f, const char *path) {
    Error error;
    TourOptions options = tour_default_options();
    options.frames_per_second = RATE;
    f->figures = (FilmFigures){0};
    walk_check_open_building(&f->w, path);
    cr_assert(tour_make(&f->w.graph, "auto", &options, &f->w.arena, &f->path, &error), "%s", error.text);
    for (int i = 0; i < f->path.frame_count; i++) {
        const TourFrame *at = &f->path.frames[i];
        film_figures_move(&f->figures, &f->w.building, i > 0 && !tour_is_cut(&f->path, i) ? at - 1 : NULL, at,
                          1.0 / RATE);
    }
}

// A plan of text, as a film.
static void film_text(Filmed *f, const char *text) {
    Arena arena = {0};
    Error error;
    char *path = arena_format(&arena, "%s/home.plan", support_folder(&arena));
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    film(f, path);
    arena_free(&arena);
}

// The frames in the room of a name.
static int frames_in(const Filmed *f, const char *name) {
    int count = 0;
    for (int i = 0, cell = -1; i < f->path.frame_count; i++) {
        cell = vis_locate(&f->w.graph, f->path.frames[i].eye, cell);
        count += cell >= 0 && strcmp(vis_region(&f->w.graph, cell)->name, name) == 0;
    }
    return count;
}

// Proves that the film of each sample is no faster than a person, turns no quicker, eases both, hardly turns on the spot, and never
// looks out of furniture. Tolerances: rounding of the differences of places, 1e-6; 0.1 m/s from frame to frame is 2.4 m/s^2, twice
// what a person's step does.
Test(film, pace, .timeout = 120) {
    static const char *const paths[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                        "build/maps/villa.sh3d", "build/maps/hillside.sh3d"};
    for (int k = 0; k < 4; k++) {
        Filmed f;
        film(&f, paths[k]);
        const FilmFigures *g = &f.figures;
        cr_expect(g->fastest <= TOUR_SPEED + 1e-6 && g->fastest > 0.8, "%s: %g m/s", paths[k], g->fastest);
        cr_expect_leq(g->quickest, TOUR_TURN + 1e-6, "%s", paths[k]);
        cr_expect_leq(g->turning, 0.15 * g->frames, "%s: %d of %d frames turn on the spot", paths[k],
                      g->turning, g->frames);
        cr_expect_eq(g->in_furniture, 0, "%s: %d frames are in furniture", paths[k], g->in_furniture);
        double speed = 0, push = 0;
        for (int i = 1; i < f.path.frame_count; i++) {
            const TourFrame *at = &f.path.frames[i];
            double now = vec3_length(vec3_sub(at->eye, at[-1].eye)) * RATE;
            if (tour_is_cut(&f.path, i)) speed = now = 0;
            push = fmax(push, fabs(now - speed));
            speed = now;
        }
        cr_expect_lt(push, 0.1, "%s: the speed jumps by %g m/s", paths[k], push);
        arena_free(&f.w.arena);
    }
}

// Proves that an eye in a doorway finds its door wide open, that doors are shut before and after, and that doors on no way stay shut.
Test(film, doors) {
    Filmed f;
    film(&f, "build/maps/house.plan");
    const Building *b = &f.w.building;
    int openings = b->opening_count, passed = 0, shut = 0;
    float *open = f.w.doors, *least = ARENA_ARRAY(&f.w.arena, float, openings + 1);
    unsigned char *used = ARENA_ARRAY(&f.w.arena, unsigned char, openings + 1);
    for (int i = 0; i < openings; i++) least[i] = 1;
    for (int i = 0, cell = -1; i < f.path.frame_count; i++) {
        tour_doors(&f.path, i, RATE, open);
        for (int o = 0; o < openings; o++) least[o] = fminf(least[o], open[o]);
        cell = vis_locate(&f.w.graph, f.path.frames[i].eye, cell);
        int at = vis_region(&f.w.graph, cell)->opening;
        if (at < 0 || b->openings[at].kind != OPENING_DOOR) continue;
        cr_expect_eq(open[at], 1.0f, "frame %d is in door %s, open by %g", i, b->openings[at].name,
                     (double)open[at]);
        used[at] = 1;
    }
    for (int o = 0; o < openings; o++) {
        if (b->openings[o].kind != OPENING_DOOR) continue;
        passed += used[o];
        shut += used[o] && least[o] == 0;
        cr_expect(used[o] || open[o] == 0, "door %s is open for nobody", b->openings[o].name);
    }
    cr_expect(passed >= 6 && shut >= passed - 1, "%d doors are passed, %d of them are shut at times", passed,
              shut);
    arena_free(&f.w.arena);
}

// Two rooms, and a closet that no door leads to; a row of cupboards with a gap stands across the first room.
static const char CLOSET[] =
    "plan 1\nmaterial red #FF0000\nstorey s floor 0 height 2.6\n"
    "room hall 0,0 6,0 6,4 0,4 wall 0.2\nroom parlour 6.2,0 10,0 10,4 6.2,4 wall 0.2\n"
    "room closet 0,4.2 2,4.2 2,6.2 0,6.2 wall 0.2\nroom shaft 3,4.2 3.6,4.2 3.6,4.8 3,4.8 wall 0.2\n"
    "door between 6.1,1 angle 90 width 0.9 height 2.05\n"
    "model cupboard\n  box -0.25,-1.5,0 0.25,1.5,2 red\nend\nplace cupboard 3,2.5\n"
    "start 1,5.2\n";

// Proves that a start in a closet without a door gives a film of the house and a cut to the closet, that the way goes around the
// cupboards, and that a shaft too narrow for a person is named as left out.
Test(film, parts) {
    Filmed f;
    film_text(&f, CLOSET);
    cr_expect(frames_in(&f, "hall") > RATE && frames_in(&f, "parlour") > RATE);
    cr_expect_gt(frames_in(&f, "closet"), RATE, "the closet is not entered");
    cr_expect_eq(f.path.cut_count, 1);
    cr_expect(f.path.rooms_enterable == 3 && f.path.rooms_entered == 3, "%d of %d", f.path.rooms_entered,
              f.path.rooms_enterable);
    const TourFrame *first = &f.path.frames[0];
    cr_expect_lt(first->eye.y, 4, "the film begins in the closet");
    cr_expect(f.figures.in_furniture == 0 && f.figures.fastest <= TOUR_SPEED + 1e-6);
    bool moved = false, left = false;
    for (int i = 0; i < f.path.note_count; i++) {
        moved = moved || strstr(f.path.notes[i], "begins in the largest part");
        left = left || strstr(f.path.notes[i], "shaft at (3");
    }
    cr_expect(moved, "the film does not say that it begins elsewhere");
    cr_expect(left, "the film does not say that it leaves out the shaft");
    // The closet counts, though nobody walks there from the start.
    int closet = vis_locate(&f.w.graph, vec3(1, 5.2, 1), -1),
        hall = vis_locate(&f.w.graph, vec3(1, 1, 1), -1);
    cr_expect(f.path.reachable[closet] && f.path.reachable[hall]);
    arena_free(&f.w.arena);
}

// Proves that an eye 0.6 m before a leaf that stands open or shut, looking at it, and an eye in the leaf find the door the other way,
// and that an eye that looks away from the leaf changes nothing.
Test(film, doors_clear_views) {
    Filmed f;
    Arena arena = {0};
    film_text(&f, arena_format(&arena, "%sview v 5,2,1.6 yaw 0\n", CLOSET));
    arena_free(&arena);
    Viewpoint *v = &f.w.building.viewpoints[0];
    for (int base = 0; base < 2; base++) {
        Vec2 at[4];
        leaf_box(&f.w.building.leaves[0], base, at);
        Vec2 middle = vec2_scale(vec2_add(vec2_add(at[0], at[1]), vec2_add(at[2], at[3])), 0.25);
        Vec2 along = vec2_sub(at[1], at[0]),
             across = vec2_scale(vec2(-along.y, along.x), 0.6 / vec2_length(along));
        for (int k = 0; k < 3; k++) {
            // Corners 0 and 1 may be those of a short side.
            bool is_short = vec2_length(along) < 0.3;
            Vec2 off = is_short ? vec2_scale(along, 0.6 / vec2_length(along)) : across;
            v->eye = k == 1 ? vec3(middle.x, middle.y, 1.6) : vec3(middle.x + off.x, middle.y + off.y, 1.6);
            v->yaw = atan2(off.y, off.x) + (k == 2 ? 0 : M_PI);
            float open = (float)base;
            walk_clear_views(&f.w.building, &open);
            cr_expect_eq(open, (float)(k == 2 ? base : 1 - base), "case %d: the door of %d stands open by %g",
                         k, base, (double)open);
        }
    }
    arena_free(&f.w.arena);
}

// Proves that the video of each fourth frame is as long as that of all frames. Tolerance: the last frame lasts four times as long.
Test(film, every, .timeout = 120) {
    Walked w;
    Error error = {""};
    double seconds[2];
    walk_check_open_building(&w, "build/maps/two-rooms.plan");
    if (support_run(&w.arena, NULL, "command -v ffprobe >/dev/null") != 0)
        cr_skip_test("ffprobe is not here");
    for (int k = 0; k < 2; k++) {
        WalkOptions options = walk_default_options();
        WalkTotals totals;
        char *said;
        options.video = arena_format(&w.arena, "%s/film.mp4", support_folder(&w.arena));
        options.width = 64, options.height = 36;
        options.look = WALK_FAST;
        options.every = k ? 4 : 1;
        cr_assert(walk_offscreen(&w.graph, &w.forest, &options, NULL, &w.arena, &totals, &error), "%s",
                  error.text);
        cr_assert_eq(support_run(&w.arena, &said,
                                 "ffprobe -v error -show_entries format=duration -of csv=p=0 '%s'",
                                 options.video),
                     0);
        seconds[k] = atof(said);
        cr_expect_float_eq(seconds[k], totals.seconds, 4.0 / 24 + 0.01);
    }
    cr_expect_float_eq(seconds[0], seconds[1], 4.0 / 24 + 0.01, "%g s and %g s", seconds[0], seconds[1]);
    arena_free(&w.arena);
}
