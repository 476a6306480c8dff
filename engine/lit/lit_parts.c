// lit_parts.c - parts in memory, each in an arena of its own; the one wanted longest ago goes first.
#include "engine/lit/lit_parts.h"

#include "engine/core/memory.h"

typedef struct Kept {
    Arena arena;
    LitMesh *mesh;  // NULL: the part is not in memory
    LitLight light;
    long wanted;  // LitPartsCount.wanted when it was wanted last
} Kept;

struct LitParts {
    const LightOfParts *of;
    Kept *part;  // [count]
    int count;
    bool told;  // that files are missing
    LitPartsCount counted;
};

LitParts *lit_parts_new(const LightOfParts *of, Arena *arena) {
    LitParts *p = ARENA_ARRAY(arena, LitParts, 1);
    *p = (LitParts){.of = of, .count = light_parts_number(of)};
    p->part = ARENA_ARRAY(arena, Kept, p->count);
    return p;
}

int lit_parts_most_vertices(const LightOfParts *of) {
    int most = 0;
    for (int i = 0; i < light_parts_number(of); i++) {
        int vertices = lit_part_vertices(of, i);
        if (vertices == 0) return 0;
        most = vertices > most ? vertices : most;
    }
    return most;
}

static void drop(LitParts *p, int part) {
    arena_free(&p->part[part].arena);
    p->counted.kept -= p->part[part].mesh != NULL;
    p->part[part].mesh = NULL;
}

void lit_parts_free(LitParts *p) {
    for (int i = 0; p && i < p->count; i++) drop(p, i);
}

// The part wanted longest ago, other than `held`; -1: there is none.
static int oldest(const LitParts *p, int held) {
    int found = -1;
    for (int i = 0; i < p->count; i++)
        if (p->part[i].mesh && i != held && (found < 0 || p->part[i].wanted < p->part[found].wanted))
            found = i;
    return found;
}

// Would so many bytes more fill three quarters of what may be used? The rest is for what else a walk needs.
static bool is_too_much(size_t bytes) {
    size_t used = memory_used(), most = used + memory_left(), bound = most - most / 4;
    return used > bound || bytes > bound - used;
}

static void drop_until(LitParts *p, size_t bytes, int held) {
    for (int part; is_too_much(bytes) && (part = oldest(p, held)) >= 0;) drop(p, part);
}

// Once: the same holds for all parts of a folder that was copied without these files.
static void tell_missing(LitParts *p, int part) {
    const LoadedScene *scene = light_parts_scene(p->of);
    Arena scratch = {0};
    if (!p->told && scene->warn)
        scene->warn(arena_format(
            &scratch, "%s has no file .lit beside it: what is drawn is made anew, which takes longer",
            light_parts_file(p->of, part, &scratch)));
    p->told = true;
    arena_free(&scratch);
}

// Making a part takes much more than reading it, so that all others go.
static bool load_part(LitParts *p, int part, int held, Error *error) {
    Kept *k = &p->part[part];
    size_t size = lit_part_size(p->of, part);
    if (size == 0) tell_missing(p, part);
    drop_until(p, size, held);
    k->mesh = lit_read_drawn(p->of, part, &k->arena, &k->light);
    if (!k->mesh) {
        arena_free(&k->arena);
        drop_until(p, SIZE_MAX, held);
        k->mesh = lit_make_drawn(p->of, part, &k->arena, &k->light, error);
    }
    if (!k->mesh) arena_free(&k->arena);
    p->counted.read++;
    p->counted.kept += k->mesh != NULL;
    return k->mesh != NULL;
}

LitMesh *lit_parts_get(LitParts *p, int part, int held, LitLight *out, Error *error) {
    Kept *k = &p->part[part];
    k->wanted = ++p->counted.wanted;
    if (!k->mesh && !load_part(p, part, held, error)) return NULL;
    *out = k->light;
    return k->mesh;
}

LitPartsCount lit_parts_count(const LitParts *p) { return p->counted; }
