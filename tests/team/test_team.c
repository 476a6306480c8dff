// test_team.c - members of a team: sums in their order, letters to each, and what is true of any.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/team/team.h"
#include "tests/support/support.h"

enum { MEMBERS = 5 };

typedef struct Seen {
    double sum[MEMBERS], most[MEMBERS];
    double joined[MEMBERS][3];
    bool any[MEMBERS], none[MEMBERS], letters[MEMBERS];
    int turn[3 * MEMBERS], turns;
    int at_once, most_at_once;
} Seen;

// Member i writes i + 1 letters 'a' + i to member j, and j of them more.
static bool exchange(TeamMember *member) {
    Arena arena = {0};
    int own = team_index(member);
    bool good = team_count(member) == MEMBERS;
    TeamBytes to[MEMBERS];
    for (int i = 0; i < MEMBERS; i++) {
        char *text = arena_alloc(&arena, MEMBERS * 3, 1);
        memset(text, 'a' + own, (size_t)(own + 1 + i));
        to[i] = (TeamBytes){text, (size_t)(own + 1 + i)};
    }
    const TeamBytes *from = team_exchange(member, to, &arena);
    for (int i = 0; i < MEMBERS; i++) {
        good = good && from[i].size == (size_t)(i + 1 + own);
        for (size_t k = 0; good && k < from[i].size; k++) good = ((const char *)from[i].data)[k] == 'a' + i;
    }
    arena_free(&arena);
    return good;
}

static void take_part(void *context, TeamMember *member) {
    static const double TERMS[MEMBERS] = {1e16, 1, -1e16, 1, 3};
    Seen *seen = context;
    int own = team_index(member);
    seen->at_once++;
    if (seen->at_once > seen->most_at_once) seen->most_at_once = seen->at_once;
    seen->at_once--;
    seen->sum[own] = seen->most[own] = TERMS[own];
    team_sum(member, &seen->sum[own], 1);
    seen->turn[seen->turns++] = own;
    team_most(member, &seen->most[own], 1);
    seen->turn[seen->turns++] = own;
    double *joined = seen->joined[own];
    joined[0] = own, joined[1] = -own, joined[2] = own == 2;
    team_join(member, joined, 1, joined + 1, 2);
    seen->turn[seen->turns++] = own;
    seen->any[own] = team_any(member, own == 3);
    seen->none[own] = team_any(member, false);
    seen->letters[own] = exchange(member);
}

// Proves that all members get the same sum, added up in their order to the last bit: 1e16 swallows the 1 after it, and the others stay.
// Letters come whole to whom they were written, and members take turns, there and back: the last before a meeting is the first after it.
Test(team, sums_and_letters) {
    Seen seen = {0};
    Error error;
    cr_assert(team_run(MEMBERS, NULL, take_part, &seen, NULL, &error), "%s", error.text);
    for (int i = 0; i < MEMBERS; i++) {
        cr_expect_eq(seen.sum[i], 4, "member %d has the sum %g", i, seen.sum[i]);
        cr_expect_eq(seen.most[i], 1e16);
        cr_expect(seen.any[i] && !seen.none[i]);
        const double *joined = seen.joined[i];
        cr_expect(joined[0] == 10 && joined[1] == 0 && joined[2] == 1, "%g %g %g", joined[0], joined[1],
                  joined[2]);
        cr_expect(seen.letters[i], "member %d has wrong letters", i);
    }
    static const int TURNS[3 * MEMBERS] = {4, 3, 2, 1, 0, 0, 1, 2, 3, 4, 4, 3, 2, 1, 0};
    for (int i = 0; i < 3 * MEMBERS; i++) cr_expect_eq(seen.turn[i], TURNS[i], "turn %d", i);
    cr_expect_eq(seen.most_at_once, 1);
    cr_expect_eq(team_ranks(), 1);
}

// A member with numbers that nobody else has, which it finds again after each meeting.
static void sleep_and_wake(void *context, TeamMember *member) {
    enum { COUNT = 400000, MEETINGS = 6 };
    bool *good = context;
    Arena arena = {0}, letters = {0};
    int own = team_index(member), *number = ARENA_ARRAY(&arena, int, COUNT);
    good[own] = true;
    for (int i = 0; i < COUNT; i++) number[i] = own * COUNT + i;
    for (int m = 0; m < MEETINGS; m++) {
        TeamBytes to[MEMBERS];
        for (int i = 0; i < MEMBERS; i++) to[i] = (TeamBytes){number + 1000 * i, 1000 * sizeof *number};
        const TeamBytes *from = team_exchange(member, to, &letters);
        for (int i = 0; i < MEMBERS; i++)
            good[own] = good[own] && from[i].size == 1000 * sizeof *number &&
                        ((const int *)from[i].data)[999] == i * COUNT + 1000 * own + 999;
        for (int i = 0; i < COUNT; i++) good[own] = good[own] && number[i] == own * COUNT + i;
    }
    arena_free(&letters);
    arena_free(&arena);
}

// Proves that members that sleep find all as it was, and letters that came meanwhile, also where the budget is so small that the memory of
// all others leaves the process at each meeting; that the budget is that of one of them, of 2 MB each; and that nothing of it stays.
Test(team, members_sleep) {
    bool good[MEMBERS] = {0};
    Arena arena = {0};
    Error error;
    const char *folder = support_folder(&arena);
    size_t before = memory_used();
    MemoryBudget budget = {
        .file = "test", .remedy = "none", .base = before + (4 << 20), .most = before + (4 << 20)};
    memory_set_budget(&budget);
    bool ran = team_run(MEMBERS, NULL, sleep_and_wake, good, folder, &error);
    memory_set_budget(NULL);
    cr_assert(ran, "%s", error.text);
    for (int i = 0; i < MEMBERS; i++) cr_expect(good[i], "member %d", i);
    cr_expect_eq(memory_used(), before);
    cr_expect_not(team_run(MEMBERS, NULL, sleep_and_wake, good, "/nowhere/at/all", &error));
    cr_expect(strstr(error.text, "/nowhere/at/all"), "%s", error.text);
    arena_free(&arena);
}

static void send_some(void *context, TeamMember *member) {
    Arena arena = {0};
    long long *sent = context;
    double sum = 1;
    exchange(member);
    team_sum(member, &sum, 1);
    if (team_index(member) == 0)
        for (int ranks = 1; ranks <= MEMBERS; ranks++) sent[ranks] = team_would_send(member, ranks);
    arena_free(&arena);
}

// Proves what one process tells of several. By weight members 0, 3 and 4 would be with the first of two: i gives j i + 1 + j letters, and
// eight bytes of a sum go once to each other process. One process sends nothing; of five the first has member 0 alone.
Test(team, tells_what_several_processes_would_send) {
    long long sent[MEMBERS + 1] = {0};
    Error error;
    cr_assert(team_run(MEMBERS, (const double[]){3, 1, 5, 2, 1}, send_some, sent, NULL, &error));
    cr_expect_eq(sent[1], 0);
    cr_expect_eq(sent[2], (2 + 3) + (5 + 6) + (6 + 7) + 3 * 8);
    cr_expect_eq(sent[MEMBERS], 2 + 3 + 4 + 5 + (MEMBERS - 1) * 8);
}
