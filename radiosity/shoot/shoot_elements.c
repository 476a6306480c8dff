// shoot_elements.c - shots in lists, several of which may wait to be told: neither thread has to stop for the other.
#include "radiosity/shoot/shoot_elements.h"

#include <pthread.h>

#include "engine/core/memory.h"

// Shots a list: to wake a thread costs as much time as a few. And lists, of which one is written.
enum { SHOTS_A_LIST = 64, LISTS = 16 };

typedef struct Shot {
    const ShootRow *row;
    Four power;
    bool direct;
} Shot;

typedef struct ShotList {
    Shot shots[SHOTS_A_LIST];
    int count;
} ShotList;

// The elements of a patch emit or receive power.
typedef struct Reflector {
    float reflectance[3];
    int first_element;
} Reflector;

struct ShootElements {
    Arena own;               // of this alone
    Four *radiosity;         // [element_count]
    Four *direct;            // [element_count] the part that came straight from lamps
    Reflector *reflectors;   // [patch_count]
    const Rgb *reflectance;  // [element_count] NULL: those of their patches
    int element_count;
    ShotList lists[LISTS];  // list i % LISTS is the i-th; `written` is the one that is being written
    int written, told;      // lists so far
    bool has_thread, end;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;  // `written`, `told` or `end`
};

// Elements lie all over memory, but it is known long before which come: runs ahead to fetch those of a patch, two to a line of the
// cache, and what is known of it.
enum { REFLECTOR_AHEAD = 12, ELEMENTS_AHEAD = 6 };

// Adds what the elements of one run reflect.
static void add_run(const ShootElements *e, Four *sums, const Reflector *to, Four power, int count,
                    const uint8_t *offset, const float *density) {
    Four reflected = power * channels_of_floats(to->reflectance), *elements = sums + to->first_element;
    const Rgb *own = e->reflectance ? e->reflectance + to->first_element : NULL;
    for (int i = 0; i < count && !own; i++) elements[offset[i]] += reflected * four_of((double)density[i]);
    for (int i = 0; i < count && own; i++)
        elements[offset[i]] += power * channels_of_rgb(own[offset[i]]) * four_of((double)density[i]);
}

static void tell_shot(ShootElements *e, const Shot *shot) {
    const ShootRow *row = shot->row;
    const float *density = row->density;
    const uint8_t *offset = row->offset;
    for (int r = 0; r < row->run_count; r++) {
        const ShootRun *run = &row->runs[r];
        const Reflector *to = &e->reflectors[run->patch];
        if (r + REFLECTOR_AHEAD < row->run_count) {
            __builtin_prefetch(&e->reflectors[run[REFLECTOR_AHEAD].patch]);
            const Four *soon = e->radiosity + e->reflectors[run[ELEMENTS_AHEAD].patch].first_element;
            __builtin_prefetch(soon, 1);
            __builtin_prefetch(soon + 2, 1);
        }
        add_run(e, e->radiosity, to, shot->power, row->count[r] + 1, offset, density);
        offset += row->count[r] + 1;
        density += row->count[r] + 1;
    }
}

// Direct light is added to a sum of its own as well.
static void tell_direct(ShootElements *e, const Shot *shot) {
    const ShootRow *row = shot->row;
    const float *density = row->density;
    const uint8_t *offset = row->offset;
    for (int r = 0; r < row->run_count; r++) {
        const Reflector *to = &e->reflectors[row->runs[r].patch];
        add_run(e, e->direct, to, shot->power, row->count[r] + 1, offset, density);
        offset += row->count[r] + 1;
        density += row->count[r] + 1;
    }
}

static void tell(ShootElements *e, ShotList *list) {
    for (int i = 0; i < list->count; i++) {
        tell_shot(e, &list->shots[i]);
        if (list->shots[i].direct) tell_direct(e, &list->shots[i]);
    }
    list->count = 0;
}

static void *work(void *context) {
    ShootElements *e = context;
    pthread_mutex_lock(&e->mutex);
    for (;;) {
        while (e->told == e->written && !e->end) pthread_cond_wait(&e->changed, &e->mutex);
        if (e->told == e->written) break;
        ShotList *list = &e->lists[e->told % LISTS];
        pthread_mutex_unlock(&e->mutex);
        tell(e, list);
        pthread_mutex_lock(&e->mutex);
        e->told++;
        pthread_cond_signal(&e->changed);
    }
    pthread_mutex_unlock(&e->mutex);
    return NULL;
}

// Returns when at most so many lists wait.
static void wait_for(ShootElements *e, int most) {
    while (e->written - e->told > most) pthread_cond_wait(&e->changed, &e->mutex);
}

static void hand_over(ShootElements *e) {
    pthread_mutex_lock(&e->mutex);
    e->written++;
    pthread_cond_signal(&e->changed);
    wait_for(e, LISTS - 1);
    pthread_mutex_unlock(&e->mutex);
}

void shoot_elements_load(ShootElements *e, const RadSolution *solution) {
    for (int i = 0; i < e->element_count; i++) {
        e->radiosity[i] = channels_of(solution->radiosity[i]);
        e->direct[i] = channels_of(solution->direct[i]);
    }
}

ShootElements *shoot_elements_new(const Mesh *mesh, const RadSolution *solution, int threads, Arena *arena) {
    // A member of a team may sleep (team.h) while its thread here is still on the way to wait: what the thread writes then must not lie
    // in the file, or it is lost.
    PageFile *file = memory_use_file(NULL);
    Arena own = {0};
    ShootElements *e = ARENA_ARRAY(&own, ShootElements, 1);
    memory_use_file(file);
    e->own = own;
    e->element_count = mesh->element_count;
    e->radiosity = ARENA_ARRAY(arena, Four, mesh->element_count);
    e->direct = ARENA_ARRAY(arena, Four, mesh->element_count);
    shoot_elements_load(e, solution);
    e->reflectors = ARENA_ARRAY(arena, Reflector, mesh->patch_count);
    for (int p = 0; p < mesh->patch_count; p++) {
        Rgb rho = mesh_patch_reflectance(mesh, p);
        e->reflectors[p] = (Reflector){{rho.r, rho.g, rho.b}, mesh->patches[p].first_element};
    }
    e->reflectance = mesh->reflectance;
    pthread_mutex_init(&e->mutex, NULL);
    pthread_cond_init(&e->changed, NULL);
    // A thread that cannot be started is done without.
    e->has_thread = threads > 1 && pthread_create(&e->thread, NULL, work, e) == 0;
    return e;
}

void shoot_elements_tell(ShootElements *e, const ShootRow *row, Four power, bool direct) {
    ShotList *list = &e->lists[e->written % LISTS];
    list->shots[list->count++] = (Shot){row, power, direct};
    if (list->count < SHOTS_A_LIST) return;
    if (e->has_thread)
        hand_over(e);
    else
        tell(e, list);
}

void shoot_elements_finish(ShootElements *e) {
    pthread_mutex_lock(&e->mutex);
    wait_for(e, 0);
    pthread_mutex_unlock(&e->mutex);
    tell(e, &e->lists[e->written % LISTS]);
}

void shoot_elements_store(const ShootElements *e, RadSolution *solution) {
    for (int i = 0; i < e->element_count; i++) {
        channels_store(e->radiosity[i], solution->radiosity[i]);
        channels_store(e->direct[i], solution->direct[i]);
    }
}

void shoot_elements_end(ShootElements *e) {
    if (e->has_thread) {
        pthread_mutex_lock(&e->mutex);
        e->end = true;
        pthread_cond_signal(&e->changed);
        pthread_mutex_unlock(&e->mutex);
        pthread_join(e->thread, NULL);
    }
    pthread_mutex_destroy(&e->mutex);
    pthread_cond_destroy(&e->changed);
    Arena own = e->own;
    arena_free(&own);
}
