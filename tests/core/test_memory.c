// test_memory.c - memory of our own: what is counted, and how the program ends where there is none.
#include <criterion/criterion.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "engine/scene/scene.h"
#include "tests/support/support.h"

// All that is asked for is counted, grown or not, and all that is given back is taken off: a leak in the count would end long walks.
Test(memory, counts_what_is_in_use) {
    size_t before = memory_used();
    Arena arena = {0};
    for (int i = 0; i < 1000; i++) arena_alloc(&arena, 1000, 1);
    char *grown = memory_new(10);
    memcpy(grown, "nine char", 10);
    grown = memory_grow(grown, 1000000);
    cr_expect_str_eq(grown, "nine char");
    size_t least = before + 1000 * 1000 + 1000000;
    cr_expect_geq(memory_used(), least);
    cr_expect_geq(memory_peak(), memory_used());
    memory_free(grown);
    memory_free(NULL);
    arena_free(&arena);
    cr_expect_eq(memory_used(), before);
    cr_expect_geq(memory_peak(), least);
}

// Proves that large arrays grow where they are, whatever else is allocated between: two that grow by turns leave no
// outgrown copies of theirs, which would be as much again; and that they hold what was put into them.
Test(memory, large_arrays_grow_in_place) {
#ifdef __SANITIZE_ADDRESS__
    cr_skip_test("arenas keep gaps under the sanitizer, and arrays do not grow in place");
#endif
    enum { COUNT = 6000000 };
    Arena arena = {0};
    int *number = NULL, counts[2] = {0}, capacities[2] = {0};
    double *half = NULL;
    // Blocks become large, and the last one has room for much.
    for (int i = 0; i < 300; i++) arena_alloc(&arena, 400000, 1);
    size_t used = arena.used;
    for (int i = 0; i < COUNT; i++) {
        *ARENA_APPEND(&arena, number, counts[0], capacities[0]) = i;
        *ARENA_APPEND(&arena, half, counts[1], capacities[1]) = i / 2.0;
        if (i % 100000 == 0) arena_alloc(&arena, 1000, 1);
    }
    for (int i = 0; i < COUNT; i++) cr_assert(number[i] == i && half[i] == i / 2.0, "element %d", i);
    used += (size_t)COUNT * (sizeof *number + sizeof *half);
    number = arena_fit(&arena, number, sizeof *number, COUNT, capacities[0]);
    half = arena_fit(&arena, half, sizeof *half, COUNT, capacities[1]);
    for (int i = 0; i < COUNT; i++) cr_assert(number[i] == i && half[i] == i / 2.0, "element %d", i);
    // The outgrown ones of up to 2 MB stay, 4 MB of each.
    cr_expect_leq(arena.used, used + (9 << 20), "%zu bytes in use for %zu", arena.used, used);
    arena_free(&arena);
}

// Proves that a large array that nobody reads any more can be given back alone, and that a small one, which has no block of its own, stays.
Test(memory, gives_back_one_array) {
    enum { COUNT = 1000000 };
    Arena arena = {0};
    int *large = NULL, *other = NULL, *small = ARENA_ARRAY(&arena, int, 10), counts[2] = {0},
        capacities[2] = {0};
    for (int i = 0; i < COUNT; i++) {
        *ARENA_APPEND(&arena, large, counts[0], capacities[0]) = i;
        *ARENA_APPEND(&arena, other, counts[1], capacities[1]) = i;
    }
    large = arena_fit(&arena, large, sizeof *large, COUNT, capacities[0]);
    other = arena_fit(&arena, other, sizeof *other, COUNT, capacities[1]);
    small[9] = 7;
    size_t used = arena.used, in_use = memory_used();
    arena_release(&arena, small);
    cr_expect_eq(arena.used, used);
    arena_release(&arena, large);
    cr_expect_leq(arena.used, used - COUNT * sizeof *large);
    cr_expect_leq(memory_used(), in_use - COUNT * sizeof *large);
    for (int i = 0; i < COUNT; i++) cr_assert(other[i] == i);
    cr_expect_eq(small[9], 7);
    arena_free(&arena);
}

// A dense arena hands out what any arena does: zeroed memory, aligned, also behind its first large pages; and it stays dense.
Test(memory, dense_arenas_are_arenas) {
    enum { PIECES = 40, PIECE = 3000000 };
    size_t before = memory_used();
    Arena arena = {.dense = true}, other = {0};
    unsigned char *piece[PIECES];
    for (int i = 0; i < PIECES; i++) {
        piece[i] = arena_alloc(&arena, PIECE / (i % 2 ? 1 : 100), 1);
        cr_assert_eq((uintptr_t)piece[i] % 64, 0);
        for (int k = 0; k < PIECE / (i % 2 ? 1 : 100); k += 997) cr_assert_eq(piece[i][k], 0);
        memset(piece[i], i + 1, PIECE / (i % 2 ? 1 : 100));
    }
    for (int i = 0; i < PIECES; i++)
        cr_expect(piece[i][0] == i + 1 && piece[i][PIECE / (i % 2 ? 1 : 100) - 1] == i + 1, "piece %d", i);
    arena_join(&other, &arena);
    cr_expect(arena.dense && !other.dense && !arena.head);
    arena_free(&other);
    cr_expect_eq(memory_used(), before);
}

// ---- the end

static void touch(void *path) {
    int fd = creat(path, 0600);
    close(fd);
}

static void ask(void *context, int index, int thread) {
    (void)context, (void)index, (void)thread;
    for (;;) memory_free(memory_new(123));
}

// Sleeps within a hold, in which a file would get its name, and then leaves a sign that it was let end.
_Noreturn static void *hold(void *path) {
    memory_hold_end();
    memory_fail_at(1);
    usleep(100000);
    touch(path);
    memory_release_end();
    for (;;) pause();
}

// The work of the child of `run`, with a file that it may make.
typedef void Child(char *path);

static void fail_in_a_loop(char *path) {
    MemoryEnd told = {.undo = touch, .context = path};
    memory_add_end(&told);
    printf("said before");  // no line: still in the buffer
    memory_fail_at(1000);
    parallel_for(8, 8, ask, NULL);
}

static void fail_while_held(char *path) {
    pthread_t thread;
    printf("said before");
    memory_fail_at(1000000000);
    pthread_create(&thread, NULL, hold, path);
    ask(NULL, 0, 0);
}

static void fail_by_size(char *path) {
    Arena arena = {0};
    touch(path);
    printf("said before");
    arena_alloc(&arena, (size_t)1 << 46, 1);
}

// Ends as the header says: one sentence, whatever was printed, status 1, and the file is there.
static void run(Child *child, const char *sentence) {
    Arena arena = {0};
    char *path = arena_format(&arena, "%s/file", support_folder(&arena));
    int pipes[2], status;
    cr_assert_eq(pipe(pipes), 0);
    fflush(NULL);
    pid_t process = fork();
    if (process == 0) {
        dup2(pipes[1], STDOUT_FILENO);
        dup2(pipes[1], STDERR_FILENO);
        alarm(20);
        child(path);
        _exit(0);
    }
    close(pipes[1]);
    char said[512] = "";
    size_t length = 0;
    for (ssize_t got; (got = read(pipes[0], said + length, sizeof said - 1 - length)) > 0;)
        length += (size_t)got;
    close(pipes[0]);
    waitpid(process, &status, 0);
    cr_expect(WIFEXITED(status) && WEXITSTATUS(status) == 1, "status %d, `%s`", status, said);
    cr_expect_str_eq(said, sentence);
    cr_expect_eq(access(path, F_OK), 0, "no file");
    arena_free(&arena);
}

// One of eight threads finds no memory, the others go on: one sentence all the same.
Test(memory, ends_in_any_thread) {
    for (int i = 0; i < 20; i++) run(fail_in_a_loop, "said beforeenfilade: no memory for 123 bytes\n");
}

// Who gives a file its name is let end first.
Test(memory, waits_for_names) { run(fail_while_held, "said beforeenfilade: no memory for 123 bytes\n"); }

static const MemoryBudget SMALL = {
    "a.plan", "--memory MB allows more", 10 << 20, 1 << 20, 10, 12 << 20, 0, false, false};

static void fail_by_budget(char *path) {
    touch(path);
    memory_set_budget(&SMALL);
    memory_set_stage("making cells");
    memory_note_read(1 << 20);
    cr_assert(memory_fits(9 << 20) && memory_within(NULL));
    memory_free(memory_new(9 << 20));
    memory_free(memory_new(11 << 20));
}

// A budget ends the program with its own sentence.
Test(memory, ends_beyond_a_budget) {
    run(fail_by_budget,
        "enfilade: a.plan: making cells takes more than 10 MB of memory (--memory MB allows more)\n");
}

static void fail_at_the_fence(char *path) {
    MemoryBudget budget = SMALL;
    budget.fence = true;
    touch(path);
    memory_set_budget(&budget);
    memory_set_stage("reading");
    // Libraries take memory too: less than the slack goes, and much more does not.
    char *volatile some = malloc(20 << 20), *volatile more = malloc(100 << 20);
    if (!some || more) _exit(2);
    memory_lower_fence();
    more = malloc(100 << 20);
    if (!more) _exit(3);
    free(more);
    memory_set_budget(&budget);
    memset(some, 1, 20 << 20);
    memory_end_library("GEOS");
}

// Libraries find no more than is left of a budget, with a fence; when they say so, the sentence is that of the budget.
Test(memory, fences_libraries_in) {
#ifdef __SANITIZE_ADDRESS__
    cr_skip_test("no fence stands under the sanitizer, whose own memory is data too");
#endif
    run(fail_at_the_fence,
        "enfilade: a.plan: reading takes more than 10 MB of memory (--memory MB allows more)\n");
}

// More bytes read allow more, up to the most there may be; a gentle budget that was exceeded, if only for a moment, says so when
// asked, but for what was tried in vain, and a new one begins anew.
Test(memory, allows_more_for_larger_files) {
    Error error = {""};
    MemoryBudget budget = SMALL;
    budget.gentle = true;
    size_t before = memory_used();
    cr_assert_leq(before, 1 << 20);
    memory_set_budget(&budget);
    memory_set_stage("reading");
    cr_expect(memory_fits(9 << 20) && !memory_fits((10 << 20) + 1));
    memory_note_read(1 << 20);
    cr_expect(!memory_fits((10 << 20) + 1), "the first megabyte is covered");
    memory_note_read(1 << 17);
    cr_expect(memory_fits(10 << 20) && !memory_fits((12 << 20) + 1), "an eighth of a megabyte allows 1.25");
    memory_note_read(1 << 30);
    cr_expect(memory_fits(11 << 20) && !memory_fits((12 << 20) + 1), "more than the most");
    memory_set_budget(&budget);
    cr_expect(memory_within(&error));
    memory_free(memory_new(11 << 20));
    cr_expect_not(memory_within(&error));
    cr_expect_str_eq(error.text, "a.plan: reading takes more than 10 MB of memory (--memory MB allows more)");
    memory_set_budget(NULL);
    cr_expect(memory_within(&error) && memory_fits((size_t)1 << 40));
}

// As `enfilade walk` treats a file that has changed: a building that fits no more is given up with a sentence, and the one before goes
// on. Of all that may be used, three quarters are for it, so that the rest is left to find out.
Test(memory, gives_up_a_larger_building) {
#ifdef __SANITIZE_ADDRESS__
    cr_skip_test("arenas keep gaps under the sanitizer: the budget is as wide as they");
#endif
    SceneOptions options = scene_default_options();
    Arena arena = {0}, other = {0};
    LoadedScene scene, changed;
    Error error = {""};
    options.fresh = true;
    options.keep = false;
    cr_assert(scene_load("build/maps/office.plan", &options, &arena, &scene, &error), "%s", error.text);
    // Where memory is short arrays are no larger than they need be: three quarters of what the building took before are enough for it,
    // and three quarters of these are not.
    options.memory = memory_peak() / 4 * 3;
    arena_free(&arena);
    cr_assert(scene_load("build/maps/two-rooms.plan", &options, &arena, &scene, &error), "%s", error.text);
    options.gentle = true;
    cr_expect_not(scene_load("build/maps/office.plan", &options, &other, &changed, &error));
    // Reading it or making cells, whichever comes first to so much; the file is named once.
    cr_expect(strncmp(error.text, "build/maps/office.plan: ", 24) == 0 &&
                  strstr(error.text, " takes more than ") &&
                  !strstr(error.text + 1, "build/maps/office.plan"),
              "%s", error.text);
    arena_free(&other);
    cr_expect(scene_load("build/maps/house.plan", &options, &other, &changed, &error), "%s", error.text);
    cr_expect_eq(scene.graph.cell_count, scene.forest.cell_count);
    arena_free(&other);
    arena_free(&arena);
    memory_set_budget(NULL);
}

// More than any machine has, asked of the C library itself. 64: the head of an arena's block.
Test(memory, ends_where_the_machine_has_none) {
#ifdef __SANITIZE_ADDRESS__
    cr_skip_test("the sanitizer ends the program at such a request, with a report of its own");
#endif
    run(fail_by_size, "said beforeenfilade: no memory for 70368744177792 bytes\n");
}
