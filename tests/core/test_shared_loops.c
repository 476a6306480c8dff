// test_shared_loops.c - loops that processes share (parallel.h): two processes of this test, with a counter and letters in memory that
// both have.
#include <criterion/criterion.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/parallel.h"
#include "maps/maps.h"
#include "tests/support/support.h"
#include "visibility/prepare/prepare.h"

enum { RANKS = 2, ROOM = 4 << 20, PIECES = 1000 };

// The memory of both processes.
typedef struct Common {
    pthread_barrier_t barrier;
    atomic_int next;
    size_t size[RANKS];
    unsigned char letter[RANKS][ROOM];
    int made[RANKS][PIECES];  // how often each piece was made by each process
    bool good[RANKS];
} Common;
static Common *common;
static int own_rank;

static int take(int pieces) { return atomic_fetch_add(&common->next, pieces); }

static const Bytes *collect(Bytes own, Arena *arena) {
    Bytes *all = ARENA_ARRAY(arena, Bytes, RANKS);
    if (own.size > ROOM) abort();
    common->size[own_rank] = own.size;
    if (own.size > 0) memcpy(common->letter[own_rank], own.data, own.size);
    pthread_barrier_wait(&common->barrier);
    for (int r = 0; r < RANKS; r++) {
        all[r] = (Bytes){arena_alloc(arena, common->size[r] + 1, 1), common->size[r]};
        memcpy(all[r].data, common->letter[r], common->size[r]);
    }
    atomic_store(&common->next, 0);
    pthread_barrier_wait(&common->barrier);
    return all;
}

// Runs a test in both processes; did it do well in both?
static bool in_both(bool (*test)(void)) {
    pthread_barrierattr_t shared;
    common = mmap(NULL, sizeof *common, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    cr_assert_neq((void *)common, MAP_FAILED);
    pthread_barrierattr_init(&shared);
    pthread_barrierattr_setpshared(&shared, PTHREAD_PROCESS_SHARED);
    pthread_barrier_init(&common->barrier, &shared, RANKS);
    pid_t child = fork();
    cr_assert_geq(child, 0);
    own_rank = child == 0;
    ParallelRanks ranks = {RANKS, own_rank, take, collect};
    parallel_set_ranks(&ranks);
    common->good[own_rank] = test();
    if (child == 0) _exit(0);
    parallel_set_ranks(NULL);
    int status;
    cr_assert_eq(waitpid(child, &status, 0), child);
    cr_expect_eq(status, 0);
    bool good = common->good[0] && common->good[1];
    munmap(common, sizeof *common);
    return good;
}

typedef struct Squares {
    int square[PIECES];
    int inner[PIECES];
} Squares;

static void make_inner(void *context, int index, int thread) {
    (void)thread;
    ((int *)context)[index]++;
}

// A loop inside a piece is not shared: it is whole here.
static void make_square(void *context, int index, int thread) {
    (void)thread;
    Squares *s = context;
    int inner[3] = {0, 0, 0};
    SharedLoop loop = {3, make_inner, NULL, NULL, inner};
    parallel_share(1, &loop);
    s->square[index] = index * index;
    s->inner[index] = inner[0] + inner[1] + inner[2];
    if (!parallel_agree(true) || parallel_agree(false)) s->inner[index] = -1;
    common->made[own_rank][index]++;
}

// Some pieces have nothing to tell.
static Bytes pack_square(void *context, int index, Arena *arena) {
    Squares *s = context;
    (void)arena;
    return (Bytes){(unsigned char *)&s->square[index], index % 3 == 0 ? 0 : sizeof *s->square};
}

static void unpack_square(void *context, int index, Bytes result) {
    Squares *s = context;
    s->square[index] = index * index;
    if (result.size > 0) memcpy(&s->square[index], result.data, result.size);
    s->inner[index] = 3;
}

static bool share_squares(void) {
    bool good = true;
    for (int round = 0; round < 3; round++) {
        Squares *s = calloc(1, sizeof *s);
        SharedLoop loop = {PIECES, make_square, pack_square, unpack_square, s};
        parallel_share(2, &loop);
        for (int i = 0; i < PIECES; i++) good = good && s->square[i] == i * i && s->inner[i] == 3;
        free(s);
    }
    // The other one is at the end of its last loop, too.
    for (int i = 0; i < PIECES; i++) good = good && common->made[0][i] + common->made[1][i] == 3;
    bool all = parallel_agree(true), one = parallel_agree(own_rank == 0), none = parallel_agree(false);
    return good && all && !one && !none && parallel_is_first() == (own_rank == 0);
}

// Proves that each piece is made in one process and known in both, again and again; that a loop inside a piece is whole where it runs; and
// that the two agree.
Test(shared_loops, each_piece_is_made_once, .timeout = 60) { cr_expect(in_both(share_squares)); }

enum { HOUSE, OFFICE, CAMPUS, PLAN_COUNT };
static const char *plans[PLAN_COUNT] = {"build/maps/house.plan", "build/maps/office.plan"};
static char places[RANKS + 1][PLAN_COUNT][256];

static bool prepare_all(int place) {
    for (int i = 0; i < PLAN_COUNT; i++) {
        Arena arena = {0};
        Building building;
        VisPrepared made;
        Error error;
        VisPrepareOptions options = vis_prepare_default_options();
        options.vis.threads = 1;
        bool good = maps_read(plans[i], &arena, &building, &error) &&
                    vis_prepare(&building, &options, NULL, &arena, &made, &error) &&
                    vis_save(places[place][i], &made.graph, &made.forest, &error);
        arena_free(&arena);
        if (!good) return false;
    }
    return true;
}

static bool prepare_here(void) { return prepare_all(own_rank); }

// Proves that two processes make the same stab trees and visible sets as one, to the last byte: of a building whose pairs are found in one
// matrix, of one of several houses, and of one that is searched group by group.
Test(shared_loops, visibility_is_that_of_one_process, .timeout = 120) {
    Arena arena = {0};
    plans[CAMPUS] = arena_format(&arena, "%s/campus.plan", support_folder(&arena));
    cr_assert_eq(system(arena_format(&arena, "build/generate campus-100 1 >%s", plans[CAMPUS])), 0);
    for (int r = 0; r <= RANKS; r++)
        for (int i = 0; i < PLAN_COUNT; i++)
            snprintf(places[r][i], sizeof places[r][i], "%s/%d-%d.vis", support_folder(&arena), r, i);
    cr_assert(prepare_all(RANKS));
    cr_expect(in_both(prepare_here));
    for (int i = 0; i < PLAN_COUNT; i++) {
        Bytes file[RANKS + 1];
        Error error;
        for (int r = 0; r <= RANKS; r++)
            cr_assert(file_read(places[r][i], (size_t)1 << 30, &arena, &file[r], &error), "%s", error.text);
        for (int r = 0; r < RANKS; r++)
            cr_expect(file[r].size == file[RANKS].size &&
                          memcmp(file[r].data, file[RANKS].data, file[r].size) == 0,
                      "%s of process %d", plans[i], r);
    }
    arena_free(&arena);
}
