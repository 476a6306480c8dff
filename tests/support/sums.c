// sums.c - sums, their file, and how a file differs from what was found.
#include "tests/support/sums.h"

#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/support.h"

void sum_add(Sum *sum, double x) {
    // Multiples of the golden ratio fill 0 .. 1 evenly.
    double weight = 1 + fmod(0.6180339887498949 * sum->count++, 1);
    if (isnan(x)) x = 1e3;
    if (isinf(x)) x = x > 0 ? 2e3 : -2e3;
    sum->sum += weight * x;
    sum->size += fabs(x);
}

void sum_add2(Sum *sum, Vec2 p) {
    sum_add(sum, p.x);
    sum_add(sum, p.y);
}

void sum_add3(Sum *sum, Vec3 p) {
    sum_add2(sum, vec2(p.x, p.y));
    sum_add(sum, p.z);
}

void sum_box(Sum *sum, Box box) {
    sum_add3(sum, box.min);
    sum_add3(sum, box.max);
}

void sum_ints(Sum *sum, const int *values, int count) {
    for (int i = 0; i < count; i++) sum_add(sum, values[i]);
}

// ---- the file

SumFile sums_begin(const char *name) {
    SumFile f = {.different = 0};
    f.path = arena_format(&f.arena, "tests/references/sums/%s.txt", name);
    if (getenv("ENFILADE_KEEP"))
        cr_assert(f.out = fopen(f.path, "w"), "%s", f.path);
    else
        f.expected = (char *)support_read(&f.arena, f.path).data;
    return f;
}

void sums_scene(SumFile *f, const char *name) {
    f->scene = arena_format(&f->arena, "%s", name);
    if (f->out) {
        fprintf(f->out, "%s%s", f->scenes++ ? "\n" : "", name);
        return;
    }
    f->line = strsep(&f->expected, "\n");
    const char *expected = f->line ? strsep(&f->line, " ") : "no scene";
    cr_assert_str_eq(name, expected, "%s holds %s where %s is", f->path, expected, name);
}

void sums_sum(SumFile *f, const char *what, Sum sum) {
    if (f->out) {
        fprintf(f->out, " %s=%d:%.14g", what, sum.count, sum.sum);
        return;
    }
    char *word = f->line ? strsep(&f->line, " ") : NULL, name[32] = "";
    int count = 0;
    double expected = 0;
    bool good =
        word && sscanf(word, "%31[^=]=%d:%lf", name, &count, &expected) == 3 && strcmp(name, what) == 0;
    if (good && count == sum.count && fabs(sum.sum - expected) <= 1e-11 * (1 + sum.size)) return;
    f->different++;
    cr_log_error("%s: %s: %s: %d numbers, sum %.14g (expected %s)", f->path, f->scene, what, sum.count,
                 sum.sum, word ? word : "no more");
}

void sums_end(SumFile *f) {
    if (f->out) fclose(f->out);
    cr_assert_eq(f->different, 0, "%s: %d sums differ from what is expected there", f->path, f->different);
    arena_free(&f->arena);
}
