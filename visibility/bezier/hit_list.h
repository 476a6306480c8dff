// hit_list.h - hits of one ray as they are found: the first alone, or all of them.
#ifndef RAYS_HIT_LIST_H
#define RAYS_HIT_LIST_H

#include "visibility/bezier/ray.h"

// Hits with near < t < far are taken. Of the first alone (`max` 1), `far` comes nearer with it.
typedef struct HitList {
    RayHit *hits;    // [max], the nearest first
    int count, max;  // of all: those beyond max are counted, not kept
    double near, far;
} HitList;

static inline bool hit_list_wants(const HitList *list, double t) { return list->near < t && t < list->far; }

static inline void hit_list_add(HitList *list, RayHit hit) {
    if (!hit_list_wants(list, hit.t)) return;
    int at = list->count < list->max ? list->count : list->max;
    for (; at > 0 && list->hits[at - 1].t > hit.t; at--)
        if (at < list->max) list->hits[at] = list->hits[at - 1];
    if (at < list->max) list->hits[at] = hit;
    if (list->max > 1) {
        list->count++;
    } else {
        list->count = 1;
        list->hits[0] = hit;
        list->far = hit.t;
    }
}

#endif
