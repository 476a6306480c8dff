// sky_kept.c - looks at the sky that are kept: those of elements by the parts of the sky that they see, those of openings by what comes
// in for each element from each part.
#include <string.h>

#include "engine/core/parallel.h"
#include "radiosity/shoot/sky_looks.h"

void sky_receive(const Mesh *mesh, int e, double power, const double radiance[3], RadSolution *solution) {
    const Element *element = &mesh->elements[e];
    Rgb m = mesh_reflectance(mesh, e);
    const double rho[3] = {(double)m.r, (double)m.g, (double)m.b};
    for (int c = 0; c < 3; c++) {
        double arrives = power * radiance[c], reflected = rho[c] * arrives;
        solution->emitted[c] += arrives;
        solution->absorbed[c] += arrives - reflected;
        solution->radiosity[e][c] += reflected / element->area;
        solution->unshot[element->patch][c] += reflected / mesh->patches[element->patch].area;
    }
}

static int slot_of(const Gathered *g, int element, int cell) {
    uint64_t key = (uint64_t)(element + 1) * (SKY_PARTS_MOST + 1) + (uint64_t)(cell + 1);
    int at = (int)((key * 0x9E3779B97F4A7C15U) >> 33) & (g->slots - 1);
    while (g->slot[at] >= 0 && (g->rays[g->slot[at]].element != element || g->rays[g->slot[at]].cell != cell))
        at = (at + 1) & (g->slots - 1);
    return at;
}

static void grow_gathered(Gathered *g) {
    enum { FEWEST = 4096 };
    g->slots = g->slots ? 2 * g->slots : FEWEST;
    g->slot = ARENA_ARRAY(&g->arena, int, g->slots);
    for (int i = 0; i < g->slots; i++) g->slot[i] = -1;
    for (int i = 0; i < g->count; i++) g->slot[slot_of(g, g->rays[i].element, g->rays[i].cell)] = i;
}

void sky_add_ray(Gathered *g, const Ray *ray) {
    if (2 * g->count >= g->slots) grow_gathered(g);
    int *at = &g->slot[slot_of(g, ray->element, ray->cell)];
    if (*at < 0) {
        *at = g->count;
        *ARENA_PUSH(&g->arena, g->rays, g->count, g->capacity) = *ray;
        return;
    }
    Ray *to = &g->rays[*at];
    to->share += ray->share;
    to->light += ray->light;
    to->sum = vec3_add(to->sum, ray->sum);
}

void sky_end_opening(SkyOpening *o, double area, const Daylight *day, Gathered *g) {
    arena_free(&o->kept);
    o->incoming = ARENA_ARRAY(&o->kept, Incoming, g->count + 1);
    o->incoming_count = g->count;
    o->known = true;
    for (int i = 0; i < g->count; i++) {
        const Ray *ray = &g->rays[i];
        bool ground = ray->cell < 0;
        SkyPart part = ground ? (SkyPart){.share = (float)ray->share} : sky_part_of(ray->share, ray->sum);
        if (!ground) sky_parts_fit(&part, 1, day, ray->light);
        part.share *= (float)area;
        o->incoming[i] = (Incoming){ray->element, ground, part};
    }
    arena_free(&g->arena);
    *g = (Gathered){0};
}

void sky_receive_incoming(const Shine *s, const Mesh *mesh, const SkyOpening *o, RadSolution *solution) {
    for (int i = 0; i < o->incoming_count; i++) {
        const Incoming *in = &o->incoming[i];
        if ((in->ground && !s->ground) || (in->element >= 0 && s->looks[in->element])) continue;
        double power = M_PI * (double)in->part.share;
        if (!in->ground) power *= sky_part_relative(&in->part, &s->day);
        const double *radiance = in->ground ? s->below : s->day.zenith;
        if (in->element >= 0) {
            sky_receive(mesh, in->element, power, radiance, solution);
            continue;
        }
        for (int c = 0; c < 3; c++) {
            solution->emitted[c] += power * radiance[c];
            solution->absorbed[c] += power * radiance[c];
        }
    }
}

// Light of looks that were made under another day.
static void turn_patch(void *context, int index, int thread) {
    const Shine *s = context;
    const Patch *patch = &s->mesh->patches[index];
    (void)thread;
    for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++) {
        Seen *seen = &s->seen[e];
        const Seen *before = e > patch->first_element ? &s->seen[e - 1] : NULL;
        bool same = before && before->part == seen->part;
        seen->sky = same ? before->sky : sky_parts_light(seen->part, seen->part_count, &s->day);
    }
}

void sky_turn_looks(SkyLooks *s) { parallel_for(s->threads, s->mesh->patch_count, turn_patch, s); }

static bool any_moves(const uint64_t *doors, const MovedDoors *moved) {
    for (int i = 0; i < moved->count; i++)
        if (view_has_door(doors, moved->doors[i].opening)) return true;
    return false;
}

static bool patch_depends(const Shine *s, int index, const MovedDoors *moved) {
    const Mesh *mesh = s->mesh;
    const Patch *patch = &mesh->patches[index];
    const uint64_t *doors = s->doors + (size_t)index * (size_t)s->door_words;
    if (mesh_leaf_moves(moved, mesh->graph->building,
                        mesh->graph->objects[mesh->faces[patch->face].object].leaf))
        return true;
    for (int i = 0; i < moved->count; i++)
        if (view_has_door(doors, moved->doors[i].opening) &&
            mesh_door_rises(&moved->doors[i], patch->centre, mesh->faces[patch->face].plane.n))
            return true;
    return false;
}

// Looks that were dropped are forgotten once they are half of all.
static void tidy(Shine *s) {
    size_t used = 0;
    Arena kept = {0};
    for (int t = 0; t < s->threads; t++) used += s->watchers[t].kept.used;
    if (s->used == 0) s->used = used;
    if (used <= 2 * s->used) return;
    const SkyPart *last = NULL;
    for (int e = 0; e < s->mesh->element_count; e++) {
        Seen *seen = &s->seen[e];
        if (e > 0 && last && seen->part == last) {
            seen->part = s->seen[e - 1].part;
            continue;
        }
        last = seen->part;
        seen->part = ARENA_ARRAY(&kept, SkyPart, seen->part_count + 1);
        if (seen->part_count > 0) memcpy(seen->part, last, (size_t)seen->part_count * sizeof *last);
    }
    for (int t = 0; t < s->threads; t++) arena_free(&s->watchers[t].kept);
    s->watchers[0].kept = kept;
    s->used = kept.used;
}

void sky_looks_move(SkyLooks *s, const MovedDoors *moved) {
    for (int t = 0; t < s->threads; t++) viewer_pose(s->watchers[t].viewer);
    for (int p = 0; p < s->mesh->patch_count; p++) s->known[p] = s->known[p] && !patch_depends(s, p, moved);
    for (int o = 0; o < s->openings.count; o++) {
        SkyOpening *opening = &s->openings.openings[o];
        opening->known = opening->known && !any_moves(opening->doors, moved);
    }
    tidy(s);
}
