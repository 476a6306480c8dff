// light_thread.c - the baking thread fills one state of the light while the walk holds another; while a state waits to be fetched, no
// new one is made, so that a walk that stands still costs nothing.
#include "engine/walk/light_thread.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "engine/lit/lit_parts.h"
#include "engine/lit/lit_states.h"
#include "radiosity/shoot/ambient.h"

// Seconds between states of the light: a few a second show the light arriving, and each costs a pass over the building.
static const double SHOW_EVERY = 0.3;
// The thread gets a third of the time of a thread of the walk where both want the same core. The lowest priority (SCHED_IDLE) would give
// it a hundredth of that: where software OpenGL takes all cores, the light would never come.
enum { NICE = 5 };

// The last states are on a mesh of their own, the finest: of all lamps, and of those that were asked for since. Light that is baked anew
// has states of its own, since the walk holds one of the others meanwhile.
enum { STATES = 3, LAST = STATES, LAST_ANEW = 2 * STATES, ALL_STATES = 3 * STATES };

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
    LitLight state[ALL_STATES];
    int last;         // LAST, or LAST_ANEW: the first of the states on the mesh that is shown now
    int fresh, held;  // the state that the walk is to fetch; the state it has; -1: none
    // The state of lamps and doors that was asked for last, [lamp_count] and [opening_count]; is it made yet, is it being made?
    Rgb *lit;
    float *doors;
    bool doors_move;  // else they stand as they were baked
    int lamp_count, opening_count;
    bool day_wanted;  // under `day`
    Daylight day;
    atomic_bool wanted, making, turns, turning;
    atomic_int turned;             // thousandths of a state of another day
    atomic_int lamps, lamps_done;  // LAMPS_KNOWN ..; thousandths
    LitStates *states;
    WalkLight *base;            // of `states`
    WalkLight *followed;        // the same if it follows the doors, to be ended; NULL
    bool short_of_memory;       // of the thread's own
    Arena asked;                // of the state asked for
    int part_asked, part_held;  // of light in parts: as wanted, and as held; -1: none
    atomic_int part_fresh;      // as `fresh`
    LitParts *parts;            // NULL: light is not in parts
    Arena room[2];              // light of other days: each in the one that the light before does not lie in
    int at;
};

// ---- in the bake's own thread

static bool note_progress(void *context, const char *stage, double done) {
    LightThread *t = context;
    (void)stage;
    bool whole = atomic_load(&t->end) != LIGHT_UNDER_WAY;
    // The walk goes on without the light rather than end for lack of memory.
    if (memory_runs_short()) t->short_of_memory = true;
    atomic_store(whole ? &t->lamps_done : &t->done, (int)(1000 * done));
    // The light of each lamp is not looked for where another day is asked for.
    return !atomic_load(&t->stop) && !t->short_of_memory && !(whole && atomic_load(&t->turning));
}

// Nobody is woken once the thread was told to stop: the walk may have ended.
static void wake_walk(LightThread *t) {
    pthread_mutex_lock(&t->lock);
    if (t->wake && !atomic_load(&t->stop)) t->wake(t->wake_context);
    pthread_mutex_unlock(&t->lock);
}

static void fill_light(LightThread *t, const RadSolution *solution) {
    int free_one = t->held == 0 ? 1 : 0;
    lit_light_fill(atomic_load(&t->mesh), solution, NULL, &t->state[free_one]);
    pthread_mutex_lock(&t->lock);
    t->fresh = free_one;
    pthread_mutex_unlock(&t->lock);
    wake_walk(t);
}

static void begin_mesh(LightThread *t, const Mesh *mesh) {
    LitMesh *lit = lit_mesh_new(mesh, &t->arena, &t->arena);
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

// Hands over a state of the last mesh: waits until the walk has fetched the state before it.
static void hand_over(LightThread *t, int state, LitMesh *mesh) {
    pthread_mutex_lock(&t->lock);
    while (t->fresh >= 0 && !atomic_load(&t->stop)) pthread_cond_wait(&t->received, &t->lock);
    atomic_store(&t->mesh, mesh);
    t->fresh = state;
    pthread_mutex_unlock(&t->lock);
    wake_walk(t);
}

// Shows all light.
static void show_whole(void *context, const WalkLight *light) {
    LightThread *t = context;
    if (atomic_load(&t->stop)) return;
    LitMesh *mesh = lit_mesh_new(light->mesh, &t->arena, &t->arena);
    t->last = t->last == 0 ? LAST : LAST_ANEW;
    for (int i = 0; i < STATES; i++) t->state[t->last + i] = lit_light_new(mesh, &t->arena);
    lit_light_fill(mesh, light->solution, light->door_open, &t->state[t->last]);
    hand_over(t, t->last, mesh);
    atomic_store(&t->lamps, LAMPS_SOUGHT);
    atomic_store(&t->turns, light_turns(light));
    atomic_store(&t->end, LIGHT_READY);
}

// A state on the mesh that is shown now that the walk neither holds nor is about to fetch.
static int free_state(LightThread *t) {
    pthread_mutex_lock(&t->lock);
    int state = t->last;
    while (state == t->held || state == t->fresh) state++;
    pthread_mutex_unlock(&t->lock);
    return state;
}

static void show_again(LightThread *t, const WalkLight *light) {
    int state = free_state(t);
    if (atomic_load(&t->stop)) return;
    lit_light_fill(atomic_load(&t->mesh), light->solution, light->door_open, &t->state[state]);
    hand_over(t, state, atomic_load(&t->mesh));
}

static void learn_lamps(LightThread *t, const WalkLight *light) {
    if (light->states || light->follower) {
        WalkLight *kept = ARENA_ARRAY(&t->arena, WalkLight, 1);
        *kept = *light;
        if (t->followed) light_end(t->followed);
        t->followed = kept->follower ? kept : NULL;
        t->states = lit_states_new(atomic_load(&t->mesh), kept, &t->arena);
        t->base = kept;
    }
    atomic_store(&t->lamps, t->states ? LAMPS_KNOWN : LAMPS_UNKNOWN);
    atomic_store(&t->turns, t->followed && light_turns(t->followed));
    wake_walk(t);
}

// Bakes light anew, with that of each lamp, and shows it.
static void bake_anew(LightThread *t) {
    WalkLight light;
    Error error;
    LightHooks hooks = t->hooks;
    hooks.show = NULL;
    hooks.whole = NULL;
    if (!t->baker.anew) return;
    atomic_store(&t->lamps, LAMPS_SOUGHT);
    if (!t->baker.anew->bake(t->baker.anew->context, &hooks, &t->arena, &light, &error)) return;
    show_whole(t, &light);
    learn_lamps(t, &light);
}

static bool goes_on(void *context, const char *stage, double done) {
    const LightThread *t = context;
    (void)stage;
    (void)done;
    return !atomic_load(&t->stop);
}

// While nothing is asked for.
static bool goes_on_idly(void *context, const char *stage, double done) {
    const LightThread *t = context;
    return goes_on(context, stage, done) && !atomic_load(&t->wanted);
}

// Where a turn is, about.
static double done_of_turn(const char *stage, double done) {
    if (strcmp(stage, "sky") == 0 || strcmp(stage, "sun") == 0) return 0.05;
    if (strcmp(stage, "direct light") == 0) return 0.5 + 0.3 * done;
    if (strcmp(stage, "reflected light") == 0) return 0.8;
    return 0.1 + 0.4 * done;
}

static bool turn_goes_on(void *context, const char *stage, double done) {
    LightThread *t = context;
    t->short_of_memory = t->short_of_memory || memory_runs_short();
    atomic_store(&t->turned, (int)(1000 * done_of_turn(stage, done)));
    return goes_on(context, stage, done) && !t->short_of_memory;
}

static bool all_lit(const LightThread *t, const Rgb *lit) {
    for (int i = 0; i < t->lamp_count; i++)
        if (lit[i].r != 1 || lit[i].g != 1 || lit[i].b != 1) return false;
    return true;
}

// Light of another day, on a mesh of its own. What the walk holds lies elsewhere.
static void turn_day(LightThread *t, const Daylight *day, const Rgb *lit, const float *doors) {
    Progress progress = {turn_goes_on, t}, whole = {goes_on, t};
    Arena *room = &t->room[1 - t->at];
    arena_free(room);
    WalkLight *light = ARENA_ARRAY(room, WalkLight, 1);
    if (!light_turn(t->base, day, doors, &progress, room, light)) {
        // Without enough memory the building is read and baked at that hour, as it was before.
        atomic_store(&t->turns, false);
        return;
    }
    t->at = 1 - t->at;
    t->base = t->followed = light;
    LitMesh *mesh = lit_mesh_new(light->mesh, room, room);
    int last = t->last == LAST ? LAST_ANEW : LAST;
    for (int i = 0; i < STATES; i++) t->state[last + i] = lit_light_new(mesh, room);
    t->states = lit_states_new(mesh, light, room);
    if (all_lit(t, lit))
        lit_light_fill(mesh, light->solution, doors, &t->state[last]);
    else if (!lit_states_fill(t->states, lit, doors, &whole, &t->state[last]))
        return;
    t->last = last;
    hand_over(t, last, mesh);
}

// Makes the state that is asked for; the newest one alone.
static void make_state(LightThread *t) {
    Arena scratch = {0};
    pthread_mutex_lock(&t->lock);
    while (t->fresh >= 0 && !atomic_load(&t->stop)) pthread_cond_wait(&t->received, &t->lock);
    Rgb *lit = ARENA_ARRAY(&scratch, Rgb, t->lamp_count + 1);
    float *doors = ARENA_ARRAY(&scratch, float, t->opening_count + 1);
    memcpy(lit, t->lit, (size_t)t->lamp_count * sizeof *lit);
    memcpy(doors, t->doors_move ? t->doors : t->base->door_open, (size_t)t->opening_count * sizeof *doors);
    Daylight day = t->day;
    bool turns = t->day_wanted && memcmp(&day, &t->base->solution->day, sizeof day) != 0;
    atomic_store(&t->making, true);
    t->wanted = t->day_wanted = false;
    atomic_store(&t->turning, false);
    pthread_mutex_unlock(&t->lock);
    if (turns && atomic_load(&t->turns)) {
        turn_day(t, &day, lit, doors);
        atomic_store(&t->making, false);
        arena_free(&scratch);
        wake_walk(t);
        return;
    }
    Progress progress = {goes_on, t};
    int state = free_state(t);
    if (!atomic_load(&t->stop) && lit_states_fill_soon(t->states, lit, doors, &t->state[state])) {
        hand_over(t, state, atomic_load(&t->mesh));
        state = free_state(t);
    }
    if (!atomic_load(&t->stop) && lit_states_fill(t->states, lit, doors, &progress, &t->state[state]))
        hand_over(t, state, atomic_load(&t->mesh));
    atomic_store(&t->making, false);
    arena_free(&scratch);
}

// Can the state that is asked for be made of what is there? Of doors elsewhere only a light that follows them knows anything.
static bool can_make(LightThread *t) {
    if (!t->states) return false;
    pthread_mutex_lock(&t->lock);
    bool known = t->base->follower || !t->doors_move || lit_states_sums(t->states, t->doors);
    pthread_mutex_unlock(&t->lock);
    return known;
}

// Goes on with lamps and doors until it is told to stop.
static void serve_states(LightThread *t) {
    bool tried = !t->baker.anew;
    Progress progress = {goes_on_idly, t};
    for (;;) {
        bool idle = !t->states;  // nothing to prepare
        pthread_mutex_lock(&t->lock);
        bool asked = t->wanted;
        pthread_mutex_unlock(&t->lock);
        if (!asked && t->states) idle = !lit_states_prepare(t->states, &progress);
        pthread_mutex_lock(&t->lock);
        while (idle && !t->wanted && !atomic_load(&t->stop)) pthread_cond_wait(&t->received, &t->lock);
        asked = t->wanted;
        pthread_mutex_unlock(&t->lock);
        if (atomic_load(&t->stop)) return;
        if (!asked) continue;
        if (!can_make(t) && !tried) {
            bake_anew(t);
            tried = true;
        }
        if (!t->states) {
            atomic_store(&t->lamps, LAMPS_NEVER);
            return;
        }
        make_state(t);
    }
}

// ---- light in parts

// Waits until a part is asked for that is not there; -1: the thread is to end.
static int next_part(LightThread *t) {
    pthread_mutex_lock(&t->lock);
    while (!atomic_load(&t->stop) && (t->part_asked < 0 || t->part_asked == t->part_held || t->fresh >= 0))
        pthread_cond_wait(&t->received, &t->lock);
    int part = atomic_load(&t->stop) ? -1 : t->part_asked;
    pthread_mutex_unlock(&t->lock);
    return part;
}

// The walk holds state[LAST] or, in turn, state[LAST_ANEW].
static bool read_part(LightThread *t, int part) {
    LitLight *state = &t->state[t->at == 0 ? LAST : LAST_ANEW];
    LitMesh *mesh = lit_parts_get(t->parts, part, t->part_held, state, &t->error);
    if (!mesh) return false;
    pthread_mutex_lock(&t->lock);
    atomic_store(&t->mesh, mesh);
    t->fresh = (int)(state - t->state);
    t->part_fresh = part;
    pthread_mutex_unlock(&t->lock);
    return true;
}

static void *read_parts(LightThread *t) {
    bool good = true;
    t->parts = lit_parts_new(t->baker.parts, &t->arena);
    atomic_store(&t->lamps, LAMPS_NEVER);
    for (int part; good && (part = next_part(t)) >= 0;) {
        good = read_part(t, part);
        atomic_store(&t->end, good ? LIGHT_READY : LIGHT_FAILED);
        wake_walk(t);
    }
    return NULL;
}

static void *work(void *context) {
    LightThread *t = context;
    WalkLight light;
    // In Linux this is the priority of this thread alone, and of threads that it starts.
    setpriority(PRIO_PROCESS, 0, NICE);
    if (t->baker.parts) return read_parts(t);
    bool good = t->baker.bake(t->baker.context, &t->hooks, &t->arena, &light, &t->error);
    good = good && !atomic_load(&t->stop);
    if (!good && t->short_of_memory)
        error_set(&t->error,
                  "no more light: it takes more memory than there is for it (--memory MB allows more)");
    bool shown = atomic_load(&t->end) != LIGHT_UNDER_WAY;
    if (good && !shown) show_whole(t, &light);
    // The light of all lamps is the sum of theirs from now on.
    if (good && shown && light.states) show_again(t, &light);
    if (good) learn_lamps(t, &light);
    atomic_store(&t->end, good || atomic_load(&t->end) == LIGHT_READY ? LIGHT_READY : LIGHT_FAILED);
    wake_walk(t);
    if (good && (t->states || t->baker.anew))
        serve_states(t);
    else
        atomic_store(&t->lamps, LAMPS_NEVER);
    return NULL;
}

// ---- in the walk's thread

LightThread *light_thread_start(const LightBaker *baker, void (*wake)(void *context), void *wake_context,
                                Arena *arena) {
    LightThread *t = ARENA_ARRAY(arena, LightThread, 1);
    int cores = parallel_threads(0);
    *t = (LightThread){.baker = *baker,
                       .wake = wake,
                       .wake_context = wake_context,
                       .fresh = -1,
                       .held = -1,
                       .part_asked = -1,
                       .part_fresh = -1,
                       .part_held = -1,
                       .lamps = LAMPS_UNKNOWN};
    t->hooks = (LightHooks){.progress = {note_progress, t},
                            .show = show,
                            .context = t,
                            .show_every = SHOW_EVERY,
                            .threads = cores > 1 ? cores - 1 : 1,
                            .each = true,
                            .whole = show_whole};
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
    if (t->part_fresh >= 0) {
        t->part_held = t->part_fresh;
        t->part_fresh = -1;
        t->at = 1 - t->at;
    }
    pthread_cond_signal(&t->received);
    pthread_mutex_unlock(&t->lock);
}

double light_thread_done(const LightThread *t) { return atomic_load(&t->done) / 1000.0; }
int light_thread_end(const LightThread *t) { return atomic_load(&t->end); }

const char *light_thread_note(const LightThread *t) {
    return light_thread_end(t) == LIGHT_UNDER_WAY ? "" : t->error.text;
}

void light_thread_ask(LightThread *t, const Rgb *lit, int count, const float *doors, int openings,
                      const Daylight *day) {
    pthread_mutex_lock(&t->lock);
    if (!t->lit || t->lamp_count != count || t->opening_count != openings) {
        arena_reset(&t->asked);
        t->lit = ARENA_ARRAY(&t->asked, Rgb, count + 1);
        t->doors = ARENA_ARRAY(&t->asked, float, openings + 1);
        t->lamp_count = count;
        t->opening_count = openings;
    }
    memcpy(t->lit, lit, (size_t)count * sizeof *lit);
    t->doors_move = doors != NULL;
    if (doors) memcpy(t->doors, doors, (size_t)openings * sizeof *doors);
    if (day) t->day = *day;
    t->day_wanted = t->day_wanted || day;
    if (day) atomic_store(&t->turned, 0);
    atomic_store(&t->turning, t->day_wanted);
    t->wanted = true;
    pthread_cond_signal(&t->received);
    pthread_mutex_unlock(&t->lock);
}

bool light_thread_turns(const LightThread *t) { return atomic_load(&t->turns); }
double light_thread_turned(const LightThread *t) { return atomic_load(&t->turned) / 1000.0; }

bool light_thread_behind(const LightThread *t) { return t->wanted || atomic_load(&t->making); }

int light_thread_lamps(const LightThread *t) { return atomic_load(&t->lamps); }
double light_thread_lamps_done(const LightThread *t) { return atomic_load(&t->lamps_done) / 1000.0; }

bool light_thread_switches(const LightThread *t) { return atomic_load(&t->lamps) != LAMPS_NEVER; }

void light_thread_ask_part(LightThread *t, int part) {
    // Asked for in each frame: no frame waits for the lock where nothing changes.
    if (t->part_asked == part && (t->part_fresh < 0 || t->part_fresh == part)) return;
    pthread_mutex_lock(&t->lock);
    if (t->part_fresh >= 0 && t->part_fresh != part) {
        t->part_fresh = -1;
        t->fresh = -1;
        atomic_store(&t->mesh, NULL);
    }
    t->part_asked = part;
    pthread_cond_signal(&t->received);
    pthread_mutex_unlock(&t->lock);
}

int light_thread_part(const LightThread *t) { return t->part_fresh; }

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
    if (t->followed) light_end(t->followed);
    lit_parts_free(t->parts);
    for (int i = 0; i < 2; i++) arena_free(&t->room[i]);
    arena_free(&t->arena);
    arena_free(&t->asked);
    return true;
}

void light_thread_abandon(LightThread *t) { pthread_detach(t->handle); }
