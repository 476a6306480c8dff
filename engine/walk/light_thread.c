// light_thread.c - the baking thread fills one state of the light while the walk holds another; while a state waits to be fetched, no
// new one is made, so that a walk that stands still costs nothing.
#include "engine/walk/light_thread.h"

#include <pthread.h>
#include <stdatomic.h>
#include <sys/resource.h>
#include <time.h>

#include "engine/core/parallel.h"
#include "radiosity/shoot/ambient.h"

// Seconds between states of the light: a few a second show the light arriving, and each costs a pass over the building.
static const double SHOW_EVERY = 0.3;
// The thread gets a third of the time of a thread of the walk where both want the same core. The lowest priority (SCHED_IDLE) would give
// it a hundredth of that: where software OpenGL takes all cores, the light would never come.
enum { NICE = 5 };

// The last state is on a mesh of its own, the finest.
enum { STATES = 2, LAST = STATES };

struct LightThread {
    LightBaker baker;
    LightHooks hooks;
    void (*wake)(void *context);
    void *wake_context;
    pthread_t handle;
    Arena arena;  // of the bake
    Error error;
    atomic_bool stop;
    atomic_int done, end;  // thousandths done; LIGHT_UNDER_WAY ..
    // The parts that are handed over. The lock is held for moments only.
    pthread_mutex_t lock;
    pthread_cond_t received;
    _Atomic(LitMesh *) mesh;
    LitLight state[STATES + 1];
    int fresh, held;  // the state that the walk is to fetch; the state it has; -1: none
};

// ---- in the bake's own thread

static bool note_progress(void *context, const char *stage, double done) {
    LightThread *t = context;
    (void)stage;
    atomic_store(&t->done, (int)(1000 * done));
    return !atomic_load(&t->stop);
}

// Nobody is woken once the thread was told to stop: the walk may have ended.
static void wake_walk(LightThread *t) {
    pthread_mutex_lock(&t->lock);
    if (t->wake && !atomic_load(&t->stop)) t->wake(t->wake_context);
    pthread_mutex_unlock(&t->lock);
}

static void fill_light(LightThread *t, const RadSolution *solution) {
    int free_one = t->held == 0 ? 1 : 0;
    lit_light_fill(atomic_load(&t->mesh), solution, &t->state[free_one]);
    pthread_mutex_lock(&t->lock);
    t->fresh = free_one;
    pthread_mutex_unlock(&t->lock);
    wake_walk(t);
}

static void begin_mesh(LightThread *t, const Mesh *mesh) {
    LitMesh *lit = lit_mesh_new(mesh, &t->arena);
    for (int i = 0; i < STATES; i++) t->state[i] = lit_light_new(lit, &t->arena);
    atomic_store(&t->mesh, lit);
}

// Shows a solution so far, with an estimate of the light that is still on its way.
static void show(void *context, const Mesh *mesh, const RadSolution *so_far) {
    LightThread *t = context;
    if (atomic_load(&t->stop)) return;
    if (!atomic_load(&t->mesh)) begin_mesh(t, mesh);
    pthread_mutex_lock(&t->lock);
    bool wanted = t->fresh < 0;
    pthread_mutex_unlock(&t->lock);
    if (!wanted) return;
    Arena scratch = {0};
    RadSolution glowing = *so_far;
    glowing.radiosity = arena_alloc(&scratch, (size_t)mesh->element_count, sizeof *glowing.radiosity);
    ambient_radiosities(mesh, so_far, glowing.radiosity);
    fill_light(t, &glowing);
    arena_free(&scratch);
}

// Shows the whole solution: waits until the walk has fetched the state before it.
static void show_last(LightThread *t, const WalkLight *light) {
    LitMesh *mesh = lit_mesh_new(light->mesh, &t->arena);
    t->state[LAST] = lit_light_new(mesh, &t->arena);
    lit_light_fill(mesh, light->solution, &t->state[LAST]);
    pthread_mutex_lock(&t->lock);
    while (t->fresh >= 0 && !atomic_load(&t->stop)) pthread_cond_wait(&t->received, &t->lock);
    atomic_store(&t->mesh, mesh);
    t->fresh = LAST;
    pthread_mutex_unlock(&t->lock);
    wake_walk(t);
}

static void *work(void *context) {
    LightThread *t = context;
    WalkLight light;
    // In Linux this is the priority of this thread alone, and of threads that it starts.
    setpriority(PRIO_PROCESS, 0, NICE);
    bool good = t->baker.bake(t->baker.context, &t->hooks, &t->arena, &light, &t->error);
    good = good && !atomic_load(&t->stop);
    if (good) show_last(t, &light);
    atomic_store(&t->end, good ? LIGHT_READY : LIGHT_FAILED);
    wake_walk(t);
    return NULL;
}

// ---- in the walk's thread

LightThread *light_thread_start(const LightBaker *baker, void (*wake)(void *context), void *wake_context,
                                Arena *arena) {
    LightThread *t = ARENA_ARRAY(arena, LightThread, 1);
    int cores = parallel_threads(0);
    *t = (LightThread){.baker = *baker, .wake = wake, .wake_context = wake_context, .fresh = -1, .held = -1};
    t->hooks = (LightHooks){{note_progress, t}, show, t, SHOW_EVERY, cores > 1 ? cores - 1 : 1};
    pthread_mutex_init(&t->lock, NULL);
    pthread_cond_init(&t->received, NULL);
    return pthread_create(&t->handle, NULL, work, t) == 0 ? t : NULL;
}

LitMesh *light_thread_mesh(const LightThread *t) { return atomic_load(&t->mesh); }

const LitLight *light_thread_light(LightThread *t) {
    // The baking thread may be suspended while it holds the lock: then the next frame asks again.
    if (pthread_mutex_trylock(&t->lock) != 0) return NULL;
    const LitLight *light = t->fresh >= 0 ? &t->state[t->fresh] : NULL;
    pthread_mutex_unlock(&t->lock);
    return light;
}

void light_thread_received(LightThread *t) {
    pthread_mutex_lock(&t->lock);
    t->held = t->fresh;
    t->fresh = -1;
    pthread_cond_signal(&t->received);
    pthread_mutex_unlock(&t->lock);
}

double light_thread_done(const LightThread *t) { return atomic_load(&t->done) / 1000.0; }
int light_thread_end(const LightThread *t) { return atomic_load(&t->end); }

const char *light_thread_note(const LightThread *t) {
    return light_thread_end(t) == LIGHT_UNDER_WAY ? "" : t->error.text;
}

void light_thread_stop(LightThread *t) {
    atomic_store(&t->stop, true);
    pthread_mutex_lock(&t->lock);
    pthread_cond_signal(&t->received);
    pthread_mutex_unlock(&t->lock);
}

bool light_thread_free(LightThread *t, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += (time_t)seconds;
    until.tv_nsec += (long)(1e9 * (seconds - floor(seconds)));
    if (until.tv_nsec >= 1000000000) {
        until.tv_sec++;
        until.tv_nsec -= 1000000000;
    }
    if (pthread_timedjoin_np(t->handle, NULL, &until) != 0) return false;
    pthread_cond_destroy(&t->received);
    pthread_mutex_destroy(&t->lock);
    arena_free(&t->arena);
    return true;
}

void light_thread_abandon(LightThread *t) { pthread_detach(t->handle); }
