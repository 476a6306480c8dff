// shoot_queue.c - a maximum in two levels: patches in blocks of about the square root of their number, so that to find
// the strongest, or to make one weak, looks at one block and at the blocks' own maxima.
#include "radiosity/shoot/shoot_queue.h"

#include "engine/core/heap.h"

void shoot_queue_start(ShootQueue *queue, int count, Arena *arena) {
    int block = 64;
    while (block < count / block) block *= 2;
    *queue = (ShootQueue){.count = count, .block = block, .block_count = (count + block - 1) / block};
    queue->power = ARENA_ARRAY(arena, double, count);
    queue->most = ARENA_ARRAY(arena, double, queue->block_count);
    queue->strongest = ARENA_ARRAY(arena, int, queue->block_count);
    for (int b = 0; b < queue->block_count; b++) queue->strongest[b] = b * block;
}

void shoot_queue_clear(ShootQueue *queue, int patch) {
    int b = patch / queue->block, first = b * queue->block, end = first + queue->block;
    if (end > queue->count) end = queue->count;
    queue->power[patch] = 0;
    if (queue->strongest[b] != patch) return;
    queue->most[b] = 0;
    queue->strongest[b] = first;
    for (int i = first; i < end; i++) {
        if (queue->power[i] <= queue->most[b]) continue;
        queue->most[b] = queue->power[i];
        queue->strongest[b] = i;
    }
}

int shoot_queue_top(const ShootQueue *queue) {
    int best = -1;
    double most = 0;
    for (int b = 0; b < queue->block_count; b++) {
        if (queue->most[b] <= most) continue;
        most = queue->most[b];
        best = queue->strongest[b];
    }
    return best;
}

static bool is_stronger(const ShootQueue *queue, int a, int b) {
    return queue->power[a] > queue->power[b] || (a < b && queue->power[a] == queue->power[b]);
}

static bool is_weaker_patch(const void *queue, const void *a, const void *b) {
    return is_stronger(queue, *(const int *)b, *(const int *)a);
}

// Most blocks are passed over at a glance: the weakest of those found, at the root of a heap, is the bar.
int shoot_queue_next(const ShootQueue *queue, const bool *taken, double least, int wanted, int *patches) {
    const Heap heap = {
        .items = patches, .size = sizeof *patches, .before = is_weaker_patch, .context = queue};
    int found = 0;
    for (int b = 0; b < queue->block_count; b++) {
        double bar = found < wanted ? least : queue->power[patches[0]];
        if (queue->most[b] < bar) continue;
        int first = b * queue->block, end = first + queue->block;
        for (int i = first; i < end && i < queue->count; i++) {
            if (taken[i] || queue->power[i] < least || queue->power[i] <= 0) continue;
            if (found < wanted) {
                heap_rise(&heap, found++, &i);
            } else if (is_stronger(queue, i, patches[0])) {
                heap_replace_first(&heap, found, &i);
            }
        }
    }
    return found;
}
