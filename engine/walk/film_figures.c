// film_figures.c - see the header.
#include "engine/walk/film_figures.h"

#include <stdlib.h>
#include <string.h>

void film_figures_move(FilmFigures *f, const Building *building, const TourFrame *before, const TourFrame *at,
                       double seconds) {
    f->frames++;
    f->in_furniture += tour_floor_in_things(building, at->eye, 0);
    if (!before) return;
    double speed = vec3_length(vec3_sub(at->eye, before->eye)) / seconds;
    double turn = fabs(remainder(at->yaw - before->yaw, 2 * M_PI)) / seconds;
    f->turning += speed < FILM_SPOT && turn > FILM_TURNS;
    f->fastest = fmax(f->fastest, speed);
    f->quickest = fmax(f->quickest, turn);
}

static int by_value(const void *a, const void *b) {
    int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
    return (p > q) - (p < q);
}

double film_figures_view(FilmFigures *f, const ItemBuffer *seen) {
    int count = seen->width * seen->height, most = 0;
    f->views++;
    f->near += (double)seen->depth[seen->height / 2 * seen->width + seen->width / 2] < FILM_NEAR;
    Arena scratch = {0};
    int32_t *item = ARENA_ARRAY(&scratch, int32_t, count + 1);
    memcpy(item, seen->item, (size_t)count * sizeof *item);
    qsort(item, (size_t)count, sizeof *item, by_value);
    for (int i = 0, first = 0; i < count; i++) {
        if (item[i] != item[first]) first = i;
        if (item[first] >= 0 && i - first + 1 > most) most = i - first + 1;
    }
    f->one_polygon += most > FILM_ONE_POLYGON * count;
    arena_free(&scratch);
    return (double)most / count;
}
