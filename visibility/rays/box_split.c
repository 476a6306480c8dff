// box_split.c - boxes counted into bins by their centres along each axis; between two bins a split costs the surface of either
// side times what lies there.
#include "visibility/rays/box_split.h"

enum { BINS = 16 };

double box_half_area(Box b) {
    if (box_is_empty(b)) return 0;
    Vec3 s = vec3_sub(b.max, b.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

typedef struct Bins {
    double low, scale;
    int axis;
} Bins;

static int bin_of(Bins bins, const BoxItem *item) {
    int bin = (int)((vec3_component(item->centre, bins.axis) - bins.low) * bins.scale);
    return bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin;
}

// The cheapest split after a bin: its cost, INFINITY where all lie in one.
static double cheapest(Bins bins, const BoxItem *items, int count, int *after) {
    Box box[BINS], sum = box_empty();
    int held[BINS] = {0}, n = 0;
    double right[BINS], best = INFINITY;
    for (int b = 0; b < BINS; b++) box[b] = box_empty();
    for (int i = 0; i < count; i++) {
        int b = bin_of(bins, &items[i]);
        held[b]++;
        box[b] = box_union(box[b], items[i].box);
    }
    for (int b = BINS - 1; b > 0; b--) {
        if (held[b]) sum = box_union(sum, box[b]);
        right[b] = box_half_area(sum) * (n += held[b]);
    }
    sum = box_empty();
    n = 0;
    for (int b = 0; b + 1 < BINS; b++) {
        if (held[b]) sum = box_union(sum, box[b]);
        n += held[b];
        if (n == 0 || n == count) continue;
        double cost = box_half_area(sum) * n + right[b + 1];
        if (cost < best) {
            best = cost;
            *after = b;
        }
    }
    return best;
}

static void swap(BoxItem *a, BoxItem *b) {
    BoxItem t = *a;
    *a = *b;
    *b = t;
}

int box_split(BoxItem *items, int count, BoxSplit way) {
    Box centres = box_empty();
    for (int i = 0; i < count; i++) centres = box_add(centres, items[i].centre);
    Bins best_bins = {0};
    double best = INFINITY;
    int best_after = 0;
    Vec3 size = vec3_sub(centres.max, centres.min);
    int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    for (int axis = 0; axis < 3 && way != BOX_SPLIT_HALVES; axis++) {
        double low = vec3_component(centres.min, axis), extent = vec3_component(centres.max, axis) - low;
        Bins bins = {low, BINS / extent, axis};
        int after = 0;
        if (way == BOX_SPLIT_LONGEST && axis != longest) continue;
        if (!(extent > 0) || !isfinite(bins.scale)) continue;
        double cost = cheapest(bins, items, count, &after);
        if (!(cost < best)) continue;
        best = cost;
        best_bins = bins;
        best_after = after;
    }
    if (!isfinite(best)) return count / 2;
    int first = 0;
    for (int i = 0; i < count; i++)
        if (bin_of(best_bins, &items[i]) <= best_after) swap(&items[first++], &items[i]);
    return first;
}

Box box_of_items(const BoxItem *items, int count) {
    Box box = box_empty();
    for (int i = 0; i < count; i++) box = box_union(box, items[i].box);
    return box;
}
