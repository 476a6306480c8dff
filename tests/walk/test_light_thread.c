// test_light_thread.c - light that arrives while one walks: states of it one by one, the whole in the end, the file of
// `enfilade bake`; and however a walk is left, at once.
#include <criterion/criterion.h>
#include <stdatomic.h>

#include "engine/core/memory.h"
#include "engine/scene/light.h"
#include "engine/walk/session_state.h"
#include "tests/support/lamps_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

#include "tests/walk/light_thread_fixture.h"

// ---- a bake under the test's control

typedef struct Puppet {
    Lit *lit;
    int states;    // shown, each with another light; then it ends, or,
    bool endless;  // asks only whether to stop
    bool fails;
    atomic_bool told;  // the test has asked it to stop
    int ignored;       // answers to go on after that
} Puppet;

static bool pull(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    Puppet *p = context;
    const Mesh *mesh = &p->lit->mesh;
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    if (!rad_start(mesh, arena, solution, error)) return false;
    for (int i = 0; i < p->states; i++) {
        for (int e = 0; e < mesh->element_count; e++)
            for (int c = 0; c < 3; c++) solution->radiosity[e][c] = i + 1;
        hooks->show(hooks->context, mesh, solution);
        if (!progress_report(&hooks->progress, "", (i + 1.0) / p->states)) return error_set(error, "stopped");
    }
    while (p->endless) {
        bool told = atomic_load(&p->told);
        if (!progress_report(&hooks->progress, "", 0.5)) break;
        p->ignored += told;
        light_thread_check_nap();
    }
    *out = (WalkLight){.mesh = mesh, .solution = solution};
    *error = (Error){""};
    return !p->fails || error_set(error, "no light today");
}

static LightThread *begin(Puppet *puppet, Arena *arena) {
    LightBaker baker = {.bake = pull, .context = puppet};
    LightThread *thread = light_thread_start(&baker, NULL, NULL, arena);
    cr_assert(thread);
    return thread;
}

// The next state's brightness, 0 where none came before the end.
static double next_state(LightThread *thread) {
    for (;;) {
        bool ended = light_thread_end(thread) != LIGHT_UNDER_WAY;
        const LitLight *light = light_thread_light(thread);
        if (light) {
            double level = light->level;
            light_thread_received(thread);
            return level;
        }
        if (ended) return 0;
        light_thread_check_nap();
    }
}

// Proves that a bake in the background that leaves the walk too little memory is given up, with a sentence, and does not end the program:
// a budget of which less than an eighth is left.
Test(light_thread, gives_up_for_memory, .timeout = 60) {
    Lit *lit = lit_rooms(5);
    Arena arena = {0};
    Puppet puppet = {.lit = lit, .endless = true, .fails = true};
    LightThread *thread = begin(&puppet, &arena);
    for (int i = 0; i < 20; i++) light_thread_check_nap();
    cr_expect_eq(light_thread_end(thread), LIGHT_UNDER_WAY, "it was given up where there was memory");
    // Gentle, as of a walk: what is requested beyond it ends nothing.
    size_t used = memory_used();
    memory_set_budget(&(MemoryBudget){
        .file = "a.plan", .remedy = "none", .base = used + used / 16, .most = SIZE_MAX, .gentle = true});
    while (light_thread_end(thread) == LIGHT_UNDER_WAY) light_thread_check_nap();
    cr_expect_eq(light_thread_end(thread), LIGHT_FAILED);
    cr_expect(strstr(light_thread_note(thread), "takes more memory than there is for it"), "%s",
              light_thread_note(thread));
    memory_set_budget(NULL);
    cr_assert(light_thread_free(thread, 30));
    arena_free(&arena);
    lit_free(lit);
}

// Proves that states arrive in order, that a walk which fetches none holds nothing up but the end, and that the last one is
// the whole solution, without the glow of what is on its way.
Test(light_thread, states_arrive_in_order, .timeout = 120) {
    Arena arena = {0};
    Puppet puppet = {.lit = lit_rooms(3), .states = 200};
    LightThread *thread = begin(&puppet, &arena);
    double last = 0, level;
    while ((level = next_state(thread)) > 0) {
        cr_expect(level > last - 1e-9, "%g after %g", level, last);
        last = level;
    }
    cr_expect_eq(light_thread_end(thread), LIGHT_READY);
    cr_expect_float_eq(last, 200, 1e-3, "the last state is %g", last);
    cr_expect_str_eq(light_thread_note(thread), "");
    cr_expect(light_thread_free(thread, 10));
    lit_free(puppet.lit);
    arena_free(&arena);
}

// Proves that what was fetched stays as it is until the next state was received, however many are made meanwhile.
Test(light_thread, what_is_held_stays, .timeout = 120) {
    Arena arena = {0};
    Puppet puppet = {.lit = lit_rooms(3), .states = 60};
    LightThread *thread = begin(&puppet, &arena);
    const LitLight *light, *held = NULL;
    double level = 0;
    float corner = 0;
    for (int i = 0; i < 400 && light_thread_end(thread) == LIGHT_UNDER_WAY; i++) {
        light = light_thread_light(thread);
        if (held) {
            cr_assert_eq(held->level, level);
            cr_assert_eq(held->vertex[0][0], corner);
        }
        if (light && i % 8 == 0) {
            light_thread_received(thread);
            held = light;
            level = held->level;
            corner = held->vertex[0][0];
        }
        light_thread_check_nap();
    }
    light_thread_stop(thread);
    cr_expect(light_thread_free(thread, 10));
    lit_free(puppet.lit);
    arena_free(&arena);
}

// Proves that a bake which is to stop hears so the next time it asks, and that one which waits for its last state to be fetched
// ends without that. Whoever waits for ever is told by the test's time limit.
Test(light_thread, stops_when_it_asks, .timeout = 120) {
    for (int k = 0; k < 2; k++) {
        Arena arena = {0};
        Puppet puppet = {.lit = lit_rooms(3), .states = 1, .endless = k == 0};
        LightThread *thread = begin(&puppet, &arena);
        while (!light_thread_light(thread)) light_thread_check_nap();
        light_thread_stop(thread);
        atomic_store(&puppet.told, true);
        cr_expect(light_thread_free(thread, 100));
        cr_expect_eq(puppet.ignored, 0, "it goes on %d times", puppet.ignored);
        lit_free(puppet.lit);
        arena_free(&arena);
    }
}

// Proves that what went wrong is told.
Test(light_thread, failure_is_told, .timeout = 120) {
    Arena arena = {0};
    Puppet puppet = {.lit = lit_rooms(3), .fails = true};
    LightThread *thread = begin(&puppet, &arena);
    while (light_thread_end(thread) == LIGHT_UNDER_WAY) light_thread_check_nap();
    cr_expect_eq(light_thread_end(thread), LIGHT_FAILED);
    cr_expect_str_eq(light_thread_note(thread), "no light today");
    cr_expect_null(light_thread_light(thread));
    cr_expect(light_thread_free(thread, 10));
    lit_free(puppet.lit);
    arena_free(&arena);
}

// ---- lamps

// Files of light, without and with the light of each lamp.
typedef struct Stored {
    Lamps3 *lamps;
    const char *plain, *each;
} Stored;

static bool read_plain(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    (void)hooks;
    const Stored *s = context;
    return light_load(s->plain, &s->lamps->scene, arena, out, error);
}

static bool read_each(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    const Stored *s = context;
    cr_expect(hooks->each);
    return light_load(s->each, &s->lamps->scene, arena, out, error);
}

static Stored store(Lamps3 *l) {
    Stored s = {l, arena_format(&l->arena, "%s/plain.rad", support_folder(&l->arena)),
                arena_format(&l->arena, "%s/each.rad", support_folder(&l->arena))};
    Error error;
    RadSolution plain = l->solution;
    plain.each = NULL;
    plain.each_count = 0;
    cr_assert(rad_save(s.plain, &l->mesh, l->doors, &plain, &error), "%s", error.text);
    cr_assert(rad_save(s.each, &l->mesh, l->doors, &l->solution, &error), "%s", error.text);
    return s;
}

static const LitLight *wait_for_light(LightThread *thread) {
    const LitLight *light;
    while (!(light = light_thread_light(thread))) light_thread_check_nap();
    return light;
}

// The sum over all vertices but those of lamps and leaves.
static double brightness(const LightThread *thread, const LitLight *light) {
    const LitMesh *lit = light_thread_mesh(thread);
    double sum = 0;
    for (int o = 0; o < lit->graph->object_count; o++) {
        const Object *object = &lit->graph->objects[o];
        if (object->leaf >= 0) continue;
        int first = lit_object_begin(lit, object)->first_vertex,
            end = lit_object_end(lit, object)->first_vertex;
        for (int v = first; v < end; v++)
            if (!lit->vertex[v].emits) sum += (double)light->vertex[v][0];
    }
    return sum;
}

// Proves that a lamp of light that was stored without that of each is switched all the same: the light is made anew, and what the walk
// holds meanwhile stays as it is; that the newest of several states asked for comes last; and that all lamps on are the light as it was.
Test(light_thread, lamps_of_stored_light, .timeout = 120) {
    Arena arena = {0};
    Lamps3 *l = lamps3_load(false);
    lamps3_bake(l, 1e-3, 2);
    Stored stored = store(l);
    LightBaker anew = {.bake = read_each, .context = &stored},
               baker = {.bake = read_plain, .context = &stored, .anew = &anew, .stored = true};
    LightThread *thread = light_thread_start(&baker, NULL, NULL, &arena);
    cr_assert(thread);
    const LitLight *first = wait_for_light(thread);
    const float *vertices = first->vertex[0];
    double level = first->level;
    light_thread_received(thread);
    cr_expect(light_thread_switches(thread));
    Rgb lit[4];
    for (int i = 0; i < 4; i++) lit[i] = (Rgb){0.5f, 0.5f, 0.5f};
    light_thread_ask(thread, lit, 4, NULL, l->scene.building.opening_count, NULL);
    // All light of the bake anew comes first, then the state.
    const LitLight *all = wait_for_light(thread);
    cr_expect(all != first && first->vertex[0] == vertices && first->level == level,
              "what is held has changed");
    cr_expect_float_eq(all->level, level, 1e-9 * level);
    double bright = brightness(thread, all);
    light_thread_received(thread);
    const LitLight *half = wait_for_light(thread);
    cr_expect(half != all);
    // Differences of floats.
    cr_expect_float_eq(brightness(thread, half), bright / 2, 1e-5 * bright);
    cr_expect_eq(light_thread_lamps(thread), LAMPS_KNOWN);
    light_thread_received(thread);
    for (int k = 0; k < 3; k++) {
        float share = k == 0 ? 0 : k == 1 ? 0.2f : 1;
        for (int i = 0; i < 4; i++) lit[i] = (Rgb){share, share, share};
        light_thread_ask(thread, lit, 4, NULL, l->scene.building.opening_count, NULL);
    }
    for (double now = 0; fabs(now - bright) > 1e-9 * bright;) {
        now = brightness(thread, wait_for_light(thread));
        light_thread_received(thread);
    }
    light_thread_stop(thread);
    cr_expect(light_thread_free(thread, 10));
    lamps3_free(l);
    arena_free(&arena);
}

// Proves that nothing is promised where the light of each lamp is not stored, and nobody can bake anew.
Test(light_thread, lamps_that_are_never_known, .timeout = 60) {
    Arena arena = {0};
    Puppet puppet = {.lit = lit_rooms(3), .states = 1};
    LightThread *thread = begin(&puppet, &arena);
    while (light_thread_lamps(thread) != LAMPS_NEVER) {
        if (light_thread_light(thread)) light_thread_received(thread);
        light_thread_check_nap();
    }
    cr_expect_not(light_thread_switches(thread));
    cr_expect(light_thread_free(thread, 10));
    lit_free(puppet.lit);
    arena_free(&arena);
}

// ---- doors

// Takes all states on the way; the last one is held. `last`: what was taken before since it was asked, or NULL; on a busy machine it may be
// the last one already. There a light that waits may not be told, for the other thread holds the lock: so NULL waits for one.
static LitLight wait_until_followed(LightThread *thread, const LitLight *last) {
    for (;;) {
        // Asked in this order: what is not behind any more has been handed over.
        bool behind = light_thread_behind(thread);
        const LitLight *light = light_thread_light(thread);
        if (light) {
            last = light;
            light_thread_received(thread);
        } else if (!behind && last) {
            break;
        }
        light_thread_check_nap();
    }
    return *last;
}

// Proves that the first step shows reflected light as it was shown before, also where that was a sum and the doors had been elsewhere
// meanwhile: most vertices, which see no lamp past the door, stay as they were to a thousandth, to which light of lamps is stored, and as
// much again for what is found anew.
static void check_first_step(LightThread *thread, float *doors, int door, int openings) {
    Arena arena = {0};
    Rgb full[4];
    float baked = doors[door];
    int same = 0, count = lit_vertex_count(light_thread_mesh(thread));
    for (int i = 0; i < 4; i++) full[i] = (Rgb){1, 1, 1};
    doors[door] = 1;
    light_thread_ask(thread, full, 4, doors, openings, NULL);
    wait_until_followed(thread, NULL);
    doors[door] = baked;
    light_thread_ask(thread, full, 4, doors, openings, NULL);
    LitLight before = wait_until_followed(thread, NULL);
    float(*was)[3] = arena_alloc(&arena, (size_t)count + 1, sizeof *was);
    memcpy(was, before.vertex, (size_t)count * sizeof *was);
    doors[door] = 0;
    light_thread_ask(thread, full, 4, doors, openings, NULL);
    const LitLight *soon = wait_for_light(thread);
    for (int v = 0; v < count; v++) same += fabsf(was[v][0] - soon->vertex[v][0]) <= 2e-3F * was[v][0];
    light_thread_received(thread);
    cr_expect_gt(same, count * 3 / 4, "%d of %d vertices are as before", same, count);
    wait_until_followed(thread, soon);
    doors[door] = baked;
    arena_free(&arena);
}

// Proves that light follows a door in two steps, of which the first one is soon there, that each of them says where its doors stand, and
// that the light as it was comes back, to the last bit, when the door is back.
Test(light_thread, light_follows_a_door, .timeout = 240) {
    Arena arena = {0};
    Lamps3 *l = lamps3_load(false);
    LightBaker baker = light_baker(&l->scene, true, &l->arena);
    LightThread *thread = light_thread_start(&baker, NULL, NULL, &arena);
    int openings = l->scene.building.opening_count, door = 0;
    const Opening *opening = l->scene.building.openings;
    while (opening[door].kind != OPENING_DOOR) door++;
    cr_assert(thread);
    while (light_thread_lamps(thread) != LAMPS_KNOWN) {
        if (light_thread_light(thread)) light_thread_received(thread);
        light_thread_check_nap();
    }
    float doors[8];
    Rgb lit[4];
    cr_assert_leq(openings, 8);
    for (int i = 0; i < openings; i++) doors[i] = i == door ? (float)opening[i].open : 1;
    // The second room has the light of the first one alone.
    for (int i = 0; i < 4; i++) lit[i] = i < 2 ? (Rgb){1, 1, 1} : (Rgb){0, 0, 0};
    light_thread_ask(thread, lit, 4, doors, openings, NULL);
    LitLight half = wait_until_followed(thread, NULL);
    cr_expect_eq(half.doors[door], (float)opening[door].open);
    const LitMesh *mesh = light_thread_mesh(thread);
    size_t bytes = (size_t)lit_vertex_count(mesh) * sizeof *half.vertex;
    float(*as_baked)[3] = arena_alloc(&arena, bytes, 1);
    memcpy(as_baked, half.vertex, bytes);
    double sum[3] = {brightness(thread, &half), 0, 0};
    for (int k = 1; k < 3; k++) {
        doors[door] = k == 1 ? 1 : 0;
        light_thread_ask(thread, lit, 4, doors, openings, NULL);
        // The first time lamps have changed as well: then there is no first step.
        const LitLight *first = NULL;
        if (k == 2) {
            first = wait_for_light(thread);
            cr_expect_eq(first->doors[door], doors[door]);
            light_thread_received(thread);
        }
        LitLight whole = wait_until_followed(thread, first);
        cr_expect_eq(whole.doors[door], doors[door]);
        sum[k] = brightness(thread, &whole);
    }
    cr_expect(sum[1] > sum[0] && sum[0] > sum[2], "wide open %g, half %g, closed %g", sum[1], sum[0], sum[2]);
    doors[door] = (float)opening[door].open;
    light_thread_ask(thread, lit, 4, doors, openings, NULL);
    LitLight back = wait_until_followed(thread, NULL);
    cr_expect_arr_eq(back.vertex, as_baked, bytes);
    check_first_step(thread, doors, door, openings);
    light_thread_stop(thread);
    cr_expect(light_thread_free(thread, 10));
    lamps3_free(l);
    arena_free(&arena);
}
