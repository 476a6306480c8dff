// simplify_queue.c - a binary heap of moves (Williams 1964).
#include "radiosity/mesh/simplify_queue.h"

void simplify_queue_push(SimplifyQueue *queue, Arena *arena, SimplifyMove move) {
    (void)ARENA_PUSH(arena, queue->moves, queue->count, queue->capacity);
    int at = queue->count - 1;
    for (; at > 0 && simplify_before(&move, &queue->moves[(at - 1) / 2]); at = (at - 1) / 2)
        queue->moves[at] = queue->moves[(at - 1) / 2];
    queue->moves[at] = move;
}

SimplifyMove simplify_queue_pop(SimplifyQueue *queue) {
    SimplifyMove top = queue->moves[0], last = queue->moves[--queue->count];
    int at = 0;
    for (int child; (child = 2 * at + 1) < queue->count; at = child) {
        if (child + 1 < queue->count && simplify_before(&queue->moves[child + 1], &queue->moves[child]))
            child++;
        if (!simplify_before(&queue->moves[child], &last)) break;
        queue->moves[at] = queue->moves[child];
    }
    queue->moves[at] = last;
    return top;
}
