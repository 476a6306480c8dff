// tables.c - intensities by formula, and files of them.
#include "tests/support/files/tables.h"

#include <math.h>

#include "engine/core/text.h"

static const double RADIAN = 180 / M_PI;

double tables_candela(Table table, double gamma, double plane) {
    double g = gamma / RADIAN, c = plane / RADIAN, below = fmax(cos(g), 0);
    switch (table) {
    case TABLE_SPOT:
        return 2000 * pow(below, 8);
    case TABLE_STREET:
        return 900 * (1 + 0.7 * sin(c)) * (0.2 + sin(g) * sin(g)) * sqrt(below) * (0.2 + below);
    case TABLE_WALLS:
        return 500 * (1.5 + cos(2 * c)) * below * (0.3 + sin(g));
    case TABLE_UP:
        return 150 + 500 * pow(sin(g / 2), 4) * (1 + 0.4 * sin(g) * cos((plane - 40) / RADIAN));
    default:
        return 120;
    }
}

Listed tables_fewest(Table table) {
    static const Listed FEWEST[TABLES] = {LISTED_ONE, LISTED_SIDE, LISTED_QUARTER, LISTED_ALL, LISTED_ONE};
    return FEWEST[table];
}

static bool goes_up(Table table) { return table == TABLE_UP || table == TABLE_GLOBE; }

// The first and the last plane listed.
static void planes_of(Listed listed, bool ies, double *from, double *to) {
    static const double TO[] = {360, 180, 90, 90, 0};
    *from = listed == LISTED_SIDE ? (ies ? 90 : -90) : 0;
    *to = listed == LISTED_SIDE && ies ? 270 : TO[listed];
}

static void list(Text *out, double from, double to, double step, const char *end) {
    for (double at = from; at <= to + 1e-9; at += step) text_append(out, "%g%s", at, end);
}

char *tables_ies(Arena *arena, Table table, Listed listed, double step, Vec2 opening) {
    Text out = {.arena = arena};
    double from, to, last = goes_up(table) ? 180 : 90;
    planes_of(listed, true, &from, &to);
    int planes = (int)lround((to - from) / step) + 1, angles = (int)lround(last / step) + 1;
    text_append(&out, "IESNA:LM-63-2002\r\n[TEST] made here\r\nTILT=NONE\r\n");
    // Halved, and doubled by the multiplier.
    text_append(&out, "1 -1 2 %d %d 1 2 %g %g 0\r\n1 1 10\r\n", angles, planes, opening.y, opening.x);
    list(&out, 0, last, step, " ");
    text_append(&out, "\r\n");
    list(&out, from, to, step, " ");
    for (double c = from; c <= to + 1e-9; c += step) {
        text_append(&out, "\r\n");
        for (double g = 0; g <= last + 1e-9; g += step)
            text_append(&out, "%.9g ", tables_candela(table, g, c) / 2);
    }
    text_append(&out, "\r\n");
    return out.data;
}

char *tables_ldt(Arena *arena, Table table, Listed listed, double step, Vec2 opening) {
    static const int SYMMETRY[] = {0, 2, 4, 3, 1};
    Text out = {.arena = arena};
    double from, to, last = goes_up(table) ? 180 : 90;
    planes_of(listed, false, &from, &to);
    if (listed == LISTED_ALL) to = 360 - step;
    int planes = listed == LISTED_ONE ? 1 : (int)lround(360 / step), angles = (int)lround(last / step) + 1;
    text_append(&out, "made here\n1\n%d\n%d\n%g\n%d\n%g\n\n\n\n\n\n0\n0\n0\n", SYMMETRY[listed], planes, step,
                angles, step);
    // cd for 1000 lm, of lamps of 2500 lm.
    text_append(&out, "%g\n%g\n0\n0\n0\n0\n100\n0\n1.0\n0\n1\n1\nlamp\n2500\n3000\n80\n10\n",
                1000 * opening.y, 1000 * opening.x);
    for (int i = 0; i < 10; i++) text_append(&out, "0.5\n");
    list(&out, 0, planes == 1 ? 0 : 360 - step, step, "\n");
    list(&out, 0, last, step, "\n");
    for (double c = from; c <= to + 1e-9; c += step)
        for (double g = 0; g <= last + 1e-9; g += step)
            text_append(&out, "%.9g\n", tables_candela(table, g, c) / 2.5);
    return out.data;
}

double tables_lux(Table table, Vec2 opening, double turn, Vec2 at, const double z[2], Vec3 point,
                  Vec3 normal) {
    enum { PARTS = 48 };
    double lux = 0, c = cos(turn / RADIAN), s = sin(turn / RADIAN);
    for (int i = 0; i < PARTS * PARTS; i++) {
        double u = ((i % PARTS + 0.5) / PARTS - 0.5) * opening.x,
               v = ((i / PARTS + 0.5) / PARTS - 0.5) * opening.y;
        for (int side = 0; side < 2; side++) {
            Vec3 way = vec3_sub(point, vec3(at.x + u * c - v * s, at.y + u * s + v * c, z[side]));
            double d = vec3_length(way), lands = -vec3_dot(way, normal) / d;
            if ((way.z > 0) != side || !(lands > 0)) continue;
            double candela =
                tables_candela(table, acos(-way.z / d) * RADIAN, atan2(way.y, way.x) * RADIAN - turn);
            lux += candela * lands / (d * d) / (PARTS * PARTS);
        }
    }
    return lux;
}
