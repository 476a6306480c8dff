// hostile.c - see hostile.h. Numbers are of few digits, so that files are small for what they ask.
#include "tests/support/files/hostile.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TURN = 6.283185307179586;

// ---- plans

static void begin_plan(FILE *f) {
    fputs("plan 1\nmaterial m #808080\nmaterial lamp #FFFFFF emission 10\nstorey s floor 0 height 2.6\n", f);
}

static void room(FILE *f, const char *name, double x0, double y0, double x1, double y1) {
    fprintf(f, "room %s %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f wall 0.1\n", name, x0, y0, x1, y0, x1, y1, x0,
            y1);
}

// Shapes stand in models: everything up to end_model is one, placed where its own coordinates are.
static void begin_model(FILE *f) { fputs("model t\n", f); }
static void end_model(FILE *f) { fputs("end\nplace t 0,0\n", f); }

// Side of a square room for `count` things, `each` metres apart.
static double side_for(int count, double each) { return 1 + each * ceil(sqrt(count)); }

static void inlays(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 10, 10);
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0.1, 5), y = random_between(random, 0.1, 5);
        double w = random_between(random, 1, 4.8), h = random_between(random, 1, 4.8);
        fprintf(f, "inlay m floor %.3f,%.3f %.3f,%.3f %.3f,%.3f %.3f,%.3f\n", x, y, x + w, y, x + w, y + h, x,
                y + h);
    }
}

static void inlays_apart(FILE *f, int count, Random *random) {
    double side = side_for(count, 0.5);
    int row = (int)ceil(sqrt(count));
    (void)random;
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++) {
        double x = 0.5 + 0.5 * (i % row), y = 0.5 + 0.5 * (i / row);
        fprintf(f, "inlay lamp ceiling %.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f\n", x, y, x + 0.3, y, x + 0.3,
                y + 0.3, x, y + 0.3);
    }
}

static void doors_overlapping(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 20, 5);
    room(f, "b", 0, 5.1, 20, 10);
    for (int i = 0; i < count; i++)
        fprintf(f, "door d%d %.3f,5.05 width %.2f height %.2f\n", i, random_between(random, 1, 19),
                random_between(random, 0.3, 1.5), random_between(random, 1, 2.4));
}

// In a wall that is long enough, door by door.
static void doors_apart(FILE *f, int count, Random *random) {
    begin_plan(f);
    (void)random;
    room(f, "a", 0, 0, count * 1.2 + 1, 5);
    room(f, "b", 0, 5.1, count * 1.2 + 1, 10);
    for (int i = 0; i < count; i++) fprintf(f, "door d%d %.1f,5.05 width 0.9 height 2\n", i, 1.2 * i + 1);
}

static void walls_crossing(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 50, 50);
    for (int i = 0; i < count; i++)
        fprintf(f, "wall %.2f,%.2f %.2f,%.2f thickness 0.1\n", random_between(random, 0, 50),
                random_between(random, 0, 50), random_between(random, 0, 50), random_between(random, 0, 50));
}

static void stub_walls(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    int row = (int)ceil(sqrt(count));
    (void)random;
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++)
        fprintf(f, "wall %d,%d %d.4,%d thickness 0.1\n", 1 + i % row, 1 + i / row, 1 + i % row, 1 + i / row);
}

static void stub_walls_turned(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    int row = (int)ceil(sqrt(count));
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++) {
        double x = 1 + i % row, y = 1 + i / row, a = random_between(random, 0, TURN);
        fprintf(f, "wall %.0f,%.0f %.3f,%.3f thickness 0.1\n", x, y, x + 0.4 * cos(a), y + 0.4 * sin(a));
    }
}

// A grid of rooms; each with a door to the right and above.
static void rooms_joined(FILE *f, int count, Random *random) {
    int row = (int)ceil(sqrt(count));
    (void)random;
    begin_plan(f);
    for (int i = 0; i < count; i++) {
        double x = 4 * (i % row), y = 4 * (i / row);
        char name[16];
        snprintf(name, sizeof name, "r%d", i);
        room(f, name, x, y, x + 3.9, y + 3.9);
        if (i % row + 1 < row && i + 1 < count)
            fprintf(f, "door h%d %.2f,%.2f angle 90 width 0.9 height 2\n", i, x + 3.95, y + 2);
        if (i + row < count) fprintf(f, "door v%d %.2f,%.2f width 0.9 height 2\n", i, x + 2, y + 3.95);
    }
}

static void rooms_overlapping(FILE *f, int count, Random *random) {
    begin_plan(f);
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0, 50), y = random_between(random, 0, 50);
        char name[16];
        snprintf(name, sizeof name, "r%d", i);
        room(f, name, x, y, x + random_between(random, 1, 6), y + random_between(random, 1, 6));
    }
}

// One room whose outline is a comb: lines of 140 corners at most, so many rooms of combs.
static void combs(FILE *f, int count, Random *random) {
    enum { TEETH = 60 };
    begin_plan(f);
    for (int i = 0; i < count; i++) {
        double y = 12.0 * i;
        fprintf(f, "room c%d 0,%.1f %d,%.1f", i, y, TEETH, y);
        for (int k = TEETH - 1; k >= 0; k--)
            fprintf(f, " %.1f,%.2f %.1f,%.2f", k + 0.8, y + random_between(random, 3, 10), k + 0.3, y + 2);
        fputs("\n", f);
    }
}

static void windows(FILE *f, int count, Random *random) {
    begin_plan(f);
    (void)random;
    fputs("ground m\n", f);
    room(f, "a", 0, 0, count * 1.2 + 1, 5);
    for (int i = 0; i < count; i++)
        fprintf(f, "window w%d %.1f,-0.05 width 0.9 height 1.2 sill 0.9\n", i, 1.2 * i + 1);
}

static void windows_around(FILE *f, int count, Random *random) {
    int row = (int)ceil(sqrt(count));
    (void)random;
    begin_plan(f);
    fputs("ground m\n", f);
    for (int i = 0; i < count; i++) {
        double x = 8 * (i % row), y = 8 * (i / row);
        char name[16];
        snprintf(name, sizeof name, "r%d", i);
        room(f, name, x, y, x + 4, y + 4);
        fprintf(f, "window w%d %.2f,%.2f width 1 height 1 sill 1\n", i, x + 2, y - 0.05);
    }
}

static void furniture(FILE *f, int count, Random *random) {
    double side = side_for(count, 0.7);
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    fputs("model t\n  box -0.3,-0.3,0.6 0.3,0.3,0.7 m\n  box -0.3,-0.3,0 -0.2,-0.2,0.6 m\nend\n", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "place t %.2f,%.2f angle %.0f\n", random_between(random, 0.5, side - 0.5),
                random_between(random, 0.5, side - 0.5), random_between(random, 0, 360));
}

// All in one place.
static void furniture_heap(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 4, 4);
    fputs("model t\n  box -0.3,-0.3,0.6 0.3,0.3,0.7 m\nend\n", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "place t %.3f,%.3f angle %.0f\n", random_between(random, 1.9, 2.1),
                random_between(random, 1.9, 2.1), random_between(random, 0, 360));
}

static void lamps(FILE *f, int count, Random *random) {
    begin_plan(f);
    double side = side_for(count, 0.2);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++)
        fprintf(f, "light l%d %.2f,%.2f,2.3 flux 10\n", i, random_between(random, 0.2, side - 0.2),
                random_between(random, 0.2, side - 0.2));
}

static void lamps_heap(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 5, 5);
    for (int i = 0; i < count; i++)
        fprintf(f, "light l%d %.3f,%.3f,%.3f flux 10\n", i, random_between(random, 0.2, 4.8),
                random_between(random, 0.2, 4.8), random_between(random, 0.2, 2.4));
}

static void spheres(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    begin_model(f);
    for (int i = 0; i < count; i++)
        fprintf(f, "sphere m %.2f,%.2f,1 radius 0.4 tolerance 0.0005\n",
                random_between(random, 0.5, side - 0.5), random_between(random, 0.5, side - 0.5));
    end_model(f);
}

static void spheres_coarse(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    begin_model(f);
    for (int i = 0; i < count; i++)
        fprintf(f, "sphere lamp %.2f,%.2f,1 radius 0.4 tolerance 0.05\n",
                random_between(random, 0.5, side - 0.5), random_between(random, 0.5, side - 0.5));
    end_model(f);
}

static void metaballs(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 10, 10);
    begin_model(f);
    for (int i = 0; i < count; i++) {
        fputs("metaballs m threshold 0.5 tolerance 0.1\n", f);
        for (int k = 0; k < 50; k++)
            fprintf(f, "ball %.2f,%.2f,%.2f radius 0.5\n", random_between(random, 1, 9),
                    random_between(random, 1, 9), random_between(random, 0.5, 2));
    }
    end_model(f);
}

static void lathes(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 20, 20);
    begin_model(f);
    for (int i = 0; i < count; i++)
        fprintf(f,
                "lathe m %.2f,%.2f profile 0.06,0 0.1,0.05 0.1,0.12 0.03,0.2 0.03,0.25 0.04,0.28 0.05,0.3 "
                "tolerance 0.0001\n",
                random_between(random, 1, 19), random_between(random, 1, 19));
    end_model(f);
}

static void stairwells(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 50, 50);
    fputs("storey t floor 2.85 height 2.6\n", f);
    room(f, "b", 0, 0, 50, 50);
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 1, 45), y = random_between(random, 1, 45),
               w = random_between(random, 0.5, 3);
        fprintf(f, "stairwell w%d %.2f,%.2f %.2f,%.2f %.2f,%.2f %.2f,%.2f\n", i, x, y, x + w, y, x + w, y + 1,
                x, y + 1);
    }
}

static void stairs(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++)
        fprintf(f, "stair s%d %.2f,%.2f width 1 depth 3 height 2 steps 100\n", i,
                random_between(random, 1, side), random_between(random, 1, side));
}

static void storeys(FILE *f, int count, Random *random) {
    (void)random;
    fputs("plan 1\n", f);
    for (int i = 0; i < count; i++) {
        fprintf(f, "storey s%d floor %.2f height 2.5\n", i, 2.75 * i);
        room(f, "a", 0, 0, 6, 6);
        if (i > 0) fprintf(f, "stairwell w%d 1,1 2,1 2,4 1,4\n", i);
    }
}

static void storeys_overlapping(FILE *f, int count, Random *random) {
    fputs("plan 1\n", f);
    for (int i = 0; i < count; i++) {
        fprintf(f, "storey s%d floor %.2f height 3\n", i, random_between(random, 0, 10));
        double x = random_between(random, 0, 20), y = random_between(random, 0, 20);
        room(f, "a", x, y, x + 6, y + 6);
    }
}

static void pillars(FILE *f, int count, Random *random) {
    double side = side_for(count, 1);
    int row = (int)ceil(sqrt(count));
    begin_plan(f);
    room(f, "a", 0, 0, side, side);
    for (int i = 0; i < count; i++) {
        double x = 1 + i % row + random_between(random, 0, 0.3),
               y = 1 + i / row + random_between(random, 0, 0.3);
        fprintf(f, "wall %.2f,%.2f %.2f,%.2f %.2f,%.2f %.2f,%.2f thickness 0.1\n", x, y, x + 0.3, y + 0.1,
                x + 0.1, y + 0.3, x, y);
    }
}

static void low_walls(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 50, 50);
    for (int i = 0; i < count; i++)
        fprintf(f, "wall %.2f,%.2f %.2f,%.2f thickness 0.1 height 1\n", random_between(random, 1, 49),
                random_between(random, 1, 49), random_between(random, 1, 49), random_between(random, 1, 49));
}

// A round hall of many short walls.
static void round_hall(FILE *f, int count, Random *random) {
    (void)random;
    begin_plan(f);
    double r = fmax(5, count * 0.1 / TURN);
    room(f, "a", -r, -r, r, r);
    for (int i = 0; i < count; i++) {
        double a = TURN * i / count, b = TURN * (i + 1) / count;
        fprintf(f, "wall %.3f,%.3f %.3f,%.3f thickness 0.2\n", r * cos(a), r * sin(a), r * cos(b),
                r * sin(b));
    }
}

static void zigzag(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 60, 60);
    for (int i = 0; i < count; i += 100) {
        fputs("wall", f);
        for (int k = 0; k < 100; k++)
            fprintf(f, " %.1f,%.1f", random_between(random, 1, 59), random_between(random, 1, 59));
        fputs(" thickness 0.05\n", f);
    }
}

static void patches(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 20, 20);
    begin_model(f);
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 1, 16), y = random_between(random, 1, 16),
               z = random_between(random, 0.3, 2);
        fputs("patch m", f);
        for (int k = 0; k < 16; k++)
            fprintf(f, " %.2f,%.2f,%.2f", x + k % 4, y + k / 4, z + random_between(random, -0.2, 0.2));
        fputs(" tolerance 0.1\n", f);
    }
    end_model(f);
}

static void polygons_crossing(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 10, 10);
    begin_model(f);
    for (int i = 0; i < count; i++) {
        fputs("poly m", f);
        for (int k = 0; k < 3; k++)
            fprintf(f, " %.2f,%.2f,%.2f", random_between(random, 0.1, 9.9), random_between(random, 0.1, 9.9),
                    random_between(random, 0.1, 2.5));
        fputs("\n", f);
    }
    end_model(f);
}

static void polygons_coplanar(FILE *f, int count, Random *random) {
    begin_plan(f);
    room(f, "a", 0, 0, 10, 10);
    begin_model(f);
    for (int i = 0; i < count; i++) {
        fputs("poly m", f);
        for (int k = 0; k < 3; k++)
            fprintf(f, " %.2f,%.2f,1", random_between(random, 0.1, 9.9), random_between(random, 0.1, 9.9));
        fputs("\n", f);
    }
    end_model(f);
}

// ---- polygons alone

static void obj_slivers(FILE *f, int count, Random *random) {
    for (int i = 0; i < count; i++) {
        double a = random_between(random, 0, TURN);
        fprintf(f, "v 0 0 0\nv %.4f %.4f 0\nv %.4f %.4f 0\nf -3 -2 -1\n", 10 * cos(a), 10 * sin(a),
                10 * cos(a + 0.01), 10 * sin(a + 0.01));
    }
}

static void obj_triangles(FILE *f, int count, Random *random) {
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            fprintf(f, "v %.2f %.2f %.2f\n", random_between(random, 0, 20), random_between(random, 0, 20),
                    random_between(random, 0, 20));
        fputs("f -3 -2 -1\n", f);
    }
}

static void obj_boxes(FILE *f, int count, Random *random) {
    static const int FACES[6][4] = {{1, 4, 3, 2}, {5, 6, 7, 8}, {1, 2, 6, 5},
                                    {2, 3, 7, 6}, {3, 4, 8, 7}, {4, 1, 5, 8}};
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0, 50), y = random_between(random, 0, 50),
               w = random_between(random, 0.2, 3);
        for (int k = 0; k < 8; k++)
            fprintf(f, "v %.2f %.2f %.1f\n", x + (k % 4 == 1 || k % 4 == 2) * w, y + (k % 4 > 1) * w,
                    k > 3 ? 2.5 : 0.0);
        for (int k = 0; k < 6; k++)
            fprintf(f, "f %d %d %d %d\n", FACES[k][0] - 9, FACES[k][1] - 9, FACES[k][2] - 9, FACES[k][3] - 9);
    }
}

static void obj_stack(FILE *f, int count, Random *random) {
    (void)random;
    for (int i = 0; i < count; i++) {
        double z = 0.001 * i;
        fprintf(f, "v 0 0 %.3f\nv 9 0 %.3f\nv 9 9 %.3f\nv 0 9 %.3f\nf -4 -3 -2 -1\n", z, z, z, z);
    }
}

static void obj_fan(FILE *f, int count, Random *random) {
    fputs("v 0 0 5\n", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "v %.3f %.3f %.3f\n", 9 * cos(TURN * i / count), 9 * sin(TURN * i / count),
                random_between(random, 0, 0.5));
    for (int i = 0; i < count; i++) fprintf(f, "f 1 %d %d\n", i + 2, (i + 1) % count + 2);
}

// The same few points in every face: n^2 edges meet.
static void obj_pencil(FILE *f, int count, Random *random) {
    fputs("v 0 0 0\nv 0 0 3\n", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "v %.3f %.3f %.3f\nf 1 2 -1\n", random_between(random, -9, 9),
                random_between(random, -9, 9), random_between(random, 0, 3));
}

// Faces among few vertices: a line of a few bytes each.
static void obj_shared(FILE *f, int count, Random *random) {
    enum { VERTICES = 300 };
    for (int i = 0; i < VERTICES; i++)
        fprintf(f, "v %.1f %.1f %.1f\n", random_between(random, 0, 20), random_between(random, 0, 20),
                random_between(random, 0, 20));
    for (int i = 0; i < count; i++) {
        int a = random_index(random, VERTICES), b = random_index(random, VERTICES - 1),
            c = random_index(random, VERTICES - 2);
        b += b >= a;
        while (c == a || c == b) c = (c + 1) % VERTICES;
        fprintf(f, "f %d %d %d\n", a + 1, b + 1, c + 1);
    }
}

// Edges along one line: each holds the ends of all that are shorter.
static void obj_edges(FILE *f, int count, Random *random) {
    fputs("v 0 0 0\n", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "v %.3f 0 0\nv 0 %.2f %.2f\nf 1 -2 -1\n", 0.001 * (i + 1), random_between(random, -9, 9),
                random_between(random, -9, 9));
}

// All are called doors, and all touch each other.
static void obj_doors(FILE *f, int count, Random *random) {
    fputs("o door\n", f);
    obj_triangles(f, count, random);
}

// Concave faces of the same vertices, wound up so that few corners can be cut off.
static void obj_spirals(FILE *f, int count, Random *random) {
    enum { CORNERS = 250, HALF = CORNERS / 2 };
    for (int i = 0; i < CORNERS; i++) {
        int k = i < HALF ? i : CORNERS - 1 - i;
        double r = 1 + 0.05 * k + (i < HALF ? 0 : 0.02 * (1 + k)), a = TURN * 6 * k / HALF;
        fprintf(f, "v %.4f %.4f %.2f\n", r * cos(a), r * sin(a), i ? 0.0 : random_between(random, 0, 0));
    }
    for (int i = 0; i < count; i++) {
        fputs("f", f);
        for (int k = 0; k < CORNERS; k++) fprintf(f, " %d", (k + i) % CORNERS + 1);
        fputs("\n", f);
    }
}

static void obj_polygons(FILE *f, int count, Random *random) {
    enum { CORNERS = 250 };
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0, 20), y = random_between(random, 0, 20),
               z = random_between(random, 0, 3);
        for (int k = 0; k < CORNERS; k++) {
            double r = k % 2 ? 3 : 1;
            fprintf(f, "v %.2f %.2f %.2f\n", x + r * cos(TURN * k / CORNERS), y + r * sin(TURN * k / CORNERS),
                    z);
        }
        fputs("f", f);
        for (int k = 0; k < CORNERS; k++) fprintf(f, " %d", k - CORNERS);
        fputs("\n", f);
    }
}

static void quads_overlapping(FILE *f, int count, Random *random) {
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0, 9), y = random_between(random, 0, 9),
               w = random_between(random, 0.5, 5);
        fprintf(f, "quad q%d 0.5 1 %.2f %.2f 0 %.2f %.2f 0 %.2f %.2f 0 %.2f %.2f 0\n", i, x, y, x + w, y,
                x + w, y + w, x, y + w);
    }
}

static void gltf_instances(FILE *f, int count, Random *random) {
    enum { TRIANGLES = 1333 };
    // All triangles of one buffer of zero bytes but for three corners: indices 0 1 2 again and again would need bytes, so the
    // mesh has many primitives of the same accessors.
    (void)random;
    fputs("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
          "octet-stream;base64,"
          "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/\"}],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
          "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
          "\"meshes\":[{\"primitives\":[",
          f);
    for (int i = 0; i < TRIANGLES; i++) fprintf(f, "%s{\"attributes\":{\"POSITION\":0}}", i ? "," : "");
    fputs("]}],\"scenes\":[{\"nodes\":[", f);
    for (int i = 0; i < count; i++) fprintf(f, "%s%d", i ? "," : "", i);
    fputs("]}],\"nodes\":[", f);
    for (int i = 0; i < count; i++)
        fprintf(f, "%s{\"mesh\":0,\"translation\":[%d,%d,0]}", i ? "," : "", i % 50, i / 50);
    fputs("]}", f);
}

// Zeros that no buffer holds, decoded for every primitive.
static void gltf_sparse(FILE *f, int count, Random *random) {
    (void)random;
    fputs("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":44,\"uri\":\"data:application/"
          "octet-stream;base64,"
          "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA=\"}],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":"
          "4}],"
          "\"accessors\":[{\"componentType\":5126,\"count\":300000,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
          "\"indices\":{\"bufferView\":1,\"componentType\":5125},\"values\":{\"bufferView\":0}}}],"
          "\"meshes\":[{\"primitives\":[",
          f);
    for (int i = 0; i < count; i++) fprintf(f, "%s{\"attributes\":{\"POSITION\":0}}", i ? "," : "");
    fputs("]}],\"nodes\":[{\"mesh\":0}]}", f);
}

static void gltf_chain(FILE *f, int count, Random *random) {
    (void)random;
    fputs("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
          "octet-stream;base64,"
          "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/\"}],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
          "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
          "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scenes\":[{\"nodes\":[0]}],"
          "\"nodes\":[",
          f);
    for (int i = 0; i + 1 < count; i++)
        fprintf(f, "{\"mesh\":0,\"translation\":[0,0,1],\"children\":[%d]},", i + 1);
    fputs("{\"mesh\":0}]}", f);
}

// ---- cells and portals

static void prt_head(FILE *f, int cells, int portals) { fprintf(f, "PRT1\n%d\n%d\n", cells, portals); }

// The portal between cells a and b in the plane x, y or z = d.
static void prt_portal(FILE *f, int a, int b, int axis, double d, double u, double v, double size) {
    fprintf(f, "4 %d %d", a, b);
    for (int k = 0; k < 4; k++) {
        double p[3] = {0};
        p[axis] = d;
        p[(axis + 1) % 3] = u + (k == 1 || k == 2) * size;
        p[(axis + 2) % 3] = v + (k > 1) * size;
        fprintf(f, " (%g %g %g )", p[0], p[1], p[2]);
    }
    fputs("\n", f);
}

// Cells one behind the other; portals so far aside that few see each other.
static void prt_row(FILE *f, int count, Random *random) {
    prt_head(f, count, count - 1);
    for (int i = 0; i + 1 < count; i++)
        prt_portal(f, i, i + 1, 0, 64 * (i + 1), random_index(random, 400), random_index(random, 400), 16);
}

// Every cell sees every other.
static void prt_enfilade(FILE *f, int count, Random *random) {
    (void)random;
    prt_head(f, count, count - 1);
    for (int i = 0; i + 1 < count; i++) prt_portal(f, i, i + 1, 0, 8 * (i + 1), 0, 0, 16);
}

static void prt_grid(FILE *f, int count, Random *random) {
    int row = (int)sqrt(count);
    prt_head(f, row * row, 2 * row * (row - 1));
    for (int i = 0; i < row * row; i++) {
        int x = i % row, y = i / row, at = random_index(random, 48);
        if (x + 1 < row) prt_portal(f, i, i + 1, 0, 64 * (x + 1), 64 * y + at, 0, 16);
        if (y + 1 < row) prt_portal(f, i, i + row, 1, 64 * (y + 1), 0, 64 * x + at, 16);
    }
}

static void prt_alone(FILE *f, int count, Random *random) {
    (void)random;
    prt_head(f, count, 1);
    prt_portal(f, 0, 1, 0, 64, 0, 0, 16);
}

// ---- homes

static void begin_home(FILE *f) {
    fputs("<?xml version='1.0'?>\n<home version='7000' wallHeight='250'>\n", f);
}

static void end_home(FILE *f) { fputs("</home>\n", f); }

static void home_room(FILE *f, double x0, double y0, double x1, double y1) {
    fprintf(f,
            "<room><point x='%.1f' y='%.1f'/><point x='%.1f' y='%.1f'/><point x='%.1f' y='%.1f'/><point "
            "x='%.1f' y='%.1f'/></room>\n",
            x0, y0, x1, y0, x1, y1, x0, y1);
}

static void home_arcs(FILE *f, int count, Random *random) {
    begin_home(f);
    for (int i = 0; i < count; i++)
        fprintf(f,
                "<wall id='w%d' xStart='%.0f' yStart='%.0f' xEnd='%.0f' yEnd='%.0f' height='250' "
                "thickness='10' arcExtent='%.1f'/>\n",
                i, random_between(random, 0, 9000), random_between(random, 0, 9000),
                random_between(random, 0, 9000), random_between(random, 0, 9000),
                random_between(random, -6, 6));
    end_home(f);
}

static void home_arcs_apart(FILE *f, int count, Random *random) {
    int row = (int)ceil(sqrt(count));
    begin_home(f);
    for (int i = 0; i < count; i++) {
        double x = 300 * (i % row), y = 300 * (i / row);
        fprintf(f,
                "<wall id='w%d' xStart='%.0f' yStart='%.0f' xEnd='%.0f' yEnd='%.0f' height='250' "
                "thickness='10' arcExtent='%.1f'/>\n",
                i, x, y, x + 120, y, random_between(random, -4, 4));
    }
    end_home(f);
}

static void home_walls(FILE *f, int count, Random *random) {
    begin_home(f);
    for (int i = 0; i < count; i++)
        fprintf(f,
                "<wall id='w%d' xStart='%.0f' yStart='%.0f' xEnd='%.0f' yEnd='%.0f' height='250' "
                "thickness='%.0f'/>\n",
                i, random_between(random, 0, 9000), random_between(random, 0, 9000),
                random_between(random, 0, 9000), random_between(random, 0, 9000),
                random_between(random, 1, 40));
    end_home(f);
}

static void home_furniture(FILE *f, int count, Random *random) {
    double side = 100 * side_for(count, 0.7);
    begin_home(f);
    home_room(f, 0, 0, side, side);
    for (int i = 0; i < count; i++)
        fprintf(
            f,
            "<pieceOfFurniture name='p' x='%.0f' y='%.0f' width='50' depth='40' height='70' angle='%.2f'/>\n",
            random_between(random, 50, side - 50), random_between(random, 50, side - 50),
            random_between(random, 0, 6));
    end_home(f);
}

static void home_doors(FILE *f, int count, Random *random) {
    begin_home(f);
    fputs("<wall id='a' xStart='0' yStart='0' xEnd='2000' yEnd='0' height='250' thickness='10'/>\n", f);
    home_room(f, 0, 5, 2000, 500);
    for (int i = 0; i < count; i++)
        fprintf(f,
                "<doorOrWindow name='d' x='%.1f' y='0' width='%.0f' depth='10' height='%.0f' "
                "wallThickness='1' wallDistance='0'/>\n",
                random_between(random, 50, 1950), random_between(random, 30, 150),
                random_between(random, 50, 240));
    end_home(f);
}

static void home_rooms(FILE *f, int count, Random *random) {
    begin_home(f);
    for (int i = 0; i < count; i++) {
        double x = random_between(random, 0, 5000), y = random_between(random, 0, 5000);
        home_room(f, x, y, x + random_between(random, 100, 600), y + random_between(random, 100, 600));
    }
    end_home(f);
}

static void home_levels(FILE *f, int count, Random *random) {
    begin_home(f);
    for (int i = 0; i < count; i++)
        fprintf(f,
                "<level id='l%d' name='l' elevation='%.0f' floorThickness='12' height='250' "
                "elevationIndex='0'/>\n",
                i, random_between(random, 0, 3000));
    for (int i = 0; i < count; i++)
        fprintf(f,
                "<room level='l%d'><point x='0' y='0'/><point x='400' y='0'/><point x='400' y='400'/><point "
                "x='0' y='400'/></room>\n",
                i);
    end_home(f);
}

static void home_corners(FILE *f, int count, Random *random) {
    begin_home(f);
    fputs("<room>", f);
    for (int i = 0; i < count; i++) {
        double r = random_between(random, 1000, 3000);
        fprintf(f, "<point x='%.1f' y='%.1f'/>", r * cos(TURN * i / count), r * sin(TURN * i / count));
    }
    fputs("</room>\n", f);
    end_home(f);
}

// The outline of a wall, whose corners lie along a line in any order: nearly each edge runs along many others.
static void ifc_outline(FILE *file, int count, Random *random) {
    int *x = calloc((size_t)count, sizeof *x);
    for (int i = 0; i < count; i++) {
        int k = random_index(random, i + 1);
        x[i] = x[k];
        x[k] = i;
    }
    fputs(
        "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"
        "#1=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n#2=IFCUNITASSIGNMENT((#1));\n"
        "#3=IFCPROJECT('p',$,'P',$,$,$,$,$,#2);\n#4=IFCCARTESIANPOINT((0.,0.,0.));\n"
        "#5=IFCAXIS2PLACEMENT3D(#4,$,$);\n#6=IFCDIRECTION((0.,0.,1.));\n#7=IFCLOCALPLACEMENT($,#5);\n"
        "#8=IFCWALL('w',$,'W',$,$,#7,#9,$,$);\n#9=IFCPRODUCTDEFINITIONSHAPE($,$,(#10));\n"
        "#10=IFCSHAPEREPRESENTATION($,'Body','SweptSolid',(#11));\n#11=IFCEXTRUDEDAREASOLID(#12,#5,#6,2.);\n"
        "#12=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#13);\n#13=IFCINDEXEDPOLYCURVE(#14,$,.F.);\n"
        "#14=IFCCARTESIANPOINTLIST2D((",
        file);
    for (int i = 0; i < count; i++) fprintf(file, "(%d.%02d,0.),", x[i] / 100, x[i] % 100);
    fputs("(5.,7.),(2.,6.)));\nENDSEC;\nEND-ISO-10303-21;\n", file);
    free(x);
}

const HostileKind HOSTILE_KINDS[] = {
    {"inlays", ".plan", 2000, true, inlays, 0, -1},
    {"inlays-apart", ".plan", 10000, false, inlays_apart, 0, 0},
    {"doors-overlapping", ".plan", 5000, true, doors_overlapping, 0, -1},
    {"doors-apart", ".plan", 8000, false, doors_apart, 0, -1},
    {"walls-crossing", ".plan", 1500, false, walls_crossing, 0, -1},
    {"stub-walls", ".plan", 10000, false, stub_walls, 0, -1},
    {"stub-walls-turned", ".plan", 2500, false, stub_walls_turned, 0, -1},
    {"rooms-joined", ".plan", 3000, false, rooms_joined, 0, -1},
    {"rooms-overlapping", ".plan", 8000, false, rooms_overlapping, 0, -1},
    {"combs", ".plan", 250, false, combs, 0, -1},
    {"windows", ".plan", 8000, false, windows, 0, -1},
    {"windows-around", ".plan", 4000, false, windows_around, 0, -1},
    {"furniture", ".plan", 20000, false, furniture, 0, 0},
    {"furniture-heap", ".plan", 20000, false, furniture_heap, 0, 0},
    {"lamps", ".plan", 10000, false, lamps, 0, 0},
    {"lamps-heap", ".plan", 10000, false, lamps_heap, 0, 0},
    {"spheres", ".plan", 10000, true, spheres, 0, 0},
    {"spheres-coarse", ".plan", 4000, false, spheres_coarse, 0, 0},
    {"metaballs", ".plan", 200, true, metaballs, 0, -1},
    {"lathes", ".plan", 5000, true, lathes, 0, 0},
    {"stairwells", ".plan", 8000, false, stairwells, 0, -1},
    {"stairs", ".plan", 10000, false, stairs, 0, 0},
    {"storeys", ".plan", 5000, false, storeys, 0, -1},
    {"storeys-overlapping", ".plan", 5000, false, storeys_overlapping, 0, -1},
    {"pillars", ".plan", 8000, false, pillars, 0, -1},
    {"low-walls", ".plan", 10000, false, low_walls, 0, 0},
    {"round-hall", ".plan", 10000, false, round_hall, 0, -1},
    {"zigzag", ".plan", 10000, false, zigzag, 0, -1},
    {"patches", ".plan", 2000, false, patches, 0, 0},
    {"polygons-crossing", ".plan", 10000, false, polygons_crossing, 0, 0},
    {"polygons-coplanar", ".plan", 10000, false, polygons_coplanar, 0, 0},
    {"obj-slivers", ".obj", 6000, true, obj_slivers, 0, -1},
    {"obj-triangles", ".obj", 10000, false, obj_triangles, 0, 0},
    {"obj-boxes", ".obj", 2000, false, obj_boxes, 0, -1},
    {"obj-stack", ".obj", 10000, false, obj_stack, 0, -1},
    {"obj-fan", ".obj", 20000, false, obj_fan, 0, 0},
    {"obj-pencil", ".obj", 15000, false, obj_pencil, 0, -1},
    {"obj-shared", ".obj", 60000, false, obj_shared, 0, -1},
    {"obj-edges", ".obj", 20000, false, obj_edges, 0, -1},
    {"obj-doors", ".obj", 10000, false, obj_doors, 0, 0},
    {"obj-spirals", ".obj", 800, false, obj_spirals, 0, 0},
    {"obj-polygons", ".obj", 150, false, obj_polygons, 0, 0},
    {"quads-overlapping", ".quads", 15000, true, quads_overlapping, 0, 0},
    {"gltf-instances", ".gltf", 3000, true, gltf_instances, 0, -1},
    {"gltf-sparse", ".gltf", 3000, true, gltf_sparse, 0, 0},
    {"gltf-chain", ".gltf", 10000, false, gltf_chain, 0, -1},
    {"prt-row", ".prt", 8000, false, prt_row, 0, -1},
    {"prt-enfilade", ".prt", 8000, false, prt_enfilade, 0, -1},
    {"prt-grid", ".prt", 6000, false, prt_grid, 0, -1},
    {"prt-alone", ".prt", 65536, false, prt_alone, 0, -1},
    {"ifc-outline", ".ifc", 980, false, ifc_outline, 245, 5},
    {"home-arcs", ".xml", 3000, false, home_arcs, 0, -1},
    {"home-arcs-apart", ".xml", 5000, false, home_arcs_apart, 0, -1},
    {"home-walls", ".xml", 2000, false, home_walls, 0, -1},
    {"home-furniture", ".xml", 9000, false, home_furniture, 0, 0},
    {"home-doors", ".xml", 4000, true, home_doors, 0, -1},
    {"home-rooms", ".xml", 5000, false, home_rooms, 0, -1},
    {"home-levels", ".xml", 4000, false, home_levels, 0, -1},
    {"home-corners", ".xml", 20000, false, home_corners, 0, -1},
    {0},
};

const HostileKind *hostile_find(const char *name) {
    for (const HostileKind *kind = HOSTILE_KINDS; kind->name; kind++)
        if (strcmp(kind->name, name) == 0) return kind;
    return NULL;
}

bool hostile_write(const HostileKind *kind, int count, uint64_t seed, const char *path) {
    FILE *file = fopen(path, "w");
    if (!file) return false;
    Random random = {seed};
    kind->write(file, count, &random);
    bool good = !ferror(file);
    return fclose(file) == 0 && good;
}
