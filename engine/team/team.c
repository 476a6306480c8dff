// team.c - a thread for each member, of which one runs at a time: whoever waits hands the turn to the next, and the last to come carries
// all letters. Turns go there and back: the last goes on first, since what it has is still in memory.
#include "engine/team/team.h"

#include <pthread.h>

#include "engine/core/memory.h"
#include "engine/core/page_file.h"
#include "engine/team/team_ranks.h"

// A member at a meeting: it brings bytes, and takes those of others with it.
typedef struct Seat {
    const void *data;     // bytes for all; or
    const TeamBytes *to;  // [count] those for each
    size_t size;
    Arena *arena;    // of the letters
    TeamBytes *got;  // [count] from each
} Seat;

typedef struct Team {
    int count, first, end;  // members first .. end - 1 are of this process
    int turn, step;  // the member that works, -1: none does yet; and how far it is to the next, 1 or -1
    bool off;        // none will
    long long sent;
    Seat *seats;          // [count] of this process's members
    TeamMember *members;  // [count] the same
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    void (*work)(void *context, TeamMember *member);
    void *context;
} Team;

struct TeamMember {
    Team *team;
    int index;
    pthread_t thread;
    PageFile *file;
};

int team_count(const TeamMember *member) { return member->team->count; }
int team_index(const TeamMember *member) { return member->index; }
long long team_sent(const TeamMember *member) { return member->team->sent; }

// ---- letters

static int first_of_rank(int count, int rank) { return (int)((long long)count * rank / team_ranks()); }

// The member that comes as number k between two meetings.
static int member_at(const Team *team, int k) { return team->step > 0 ? team->first + k : team->end - 1 - k; }

// Nobody works. Once members have much in memory, what they have goes, first of those whose turns are farthest away: of those that came,
// up to `last`, in their order, and then of those that are to come, from the end.
static void let_sleep(const Team *team, int last) {
    int own = team->end - team->first, came = (last - member_at(team, 0)) * team->step + 1;
    Error error;
    if (!team->members[team->first].file) return;
    for (int i = 0; i < own && memory_much_resident(); i++)
        if (!page_file_drop(team->members[member_at(team, i < came ? i : own - 1 - (i - came))].file, &error))
            memory_end_saying(error.text);
}

// Room for a member that sleeps, where its memory lies.
static void *room_of(const Team *team, int member, size_t count, size_t size) {
    PageFile *own = memory_use_file(team->members[member].file);
    void *room = arena_alloc(team->seats[member].arena, count, size);
    memory_use_file(own);
    return room;
}

static void hand_over(const Team *team, int to, int from, TeamBytes letter) {
    void *copy = room_of(team, to, letter.size + 1, 1);
    if (letter.size > 0) memcpy(copy, letter.data, letter.size);
    team->seats[to].got[from] = (TeamBytes){copy, letter.size};
}

static TeamBytes letter_of(const Seat *from, int to) {
    return from->to ? from->to[to] : (TeamBytes){from->data, from->size};
}

// Letters to another process: each with its size before it, by senders and then by receivers; one letter where all get the same.

static size_t put(char *at, const void *data, size_t size) {
    if (at && size > 0) memcpy(at, data, size);
    return size;
}

static size_t pack_letters(const Team *team, int rank, char *out) {
    size_t size = 0;
    int first = first_of_rank(team->count, rank), end = first_of_rank(team->count, rank + 1);
    for (int from = team->first; from < team->end; from++) {
        const Seat *seat = &team->seats[from];
        for (int to = first; to < (seat->to ? end : first + 1); to++) {
            TeamBytes letter = letter_of(seat, to);
            size += put(out ? out + size : NULL, &letter.size, sizeof letter.size);
            size += put(out ? out + size : NULL, letter.data, letter.size);
        }
    }
    return size;
}

static void unpack(Team *team, int rank, const char *from) {
    int first = first_of_rank(team->count, rank), end = first_of_rank(team->count, rank + 1);
    bool each = team->seats[team->first].to != NULL;
    for (int sender = first; sender < end; sender++) {
        for (int to = team->first; to < team->end; to++) {
            TeamBytes letter;
            memcpy(&letter.size, from, sizeof letter.size);
            letter.data = from + sizeof letter.size;
            hand_over(team, to, sender, letter);
            if (each || to + 1 == team->end) from += sizeof letter.size + letter.size;
        }
    }
}

// The last of this process's members has come.
static void carry_letters(Team *team) {
    int ranks = team_ranks(), own = team_rank();
    for (int k = 0; k < team->end - team->first; k++) {
        int to = member_at(team, k);
        team->seats[to].got = room_of(team, to, (size_t)team->count, sizeof(TeamBytes));
        for (int from = team->first; from < team->end; from++)
            hand_over(team, to, from, letter_of(&team->seats[from], to));
        let_sleep(team, to);
    }
    for (int step = 1; step < ranks; step++) {
        Arena scratch = {0};
        int to = (own + step) % ranks, from = (own + ranks - step) % ranks;
        size_t size = pack_letters(team, to, NULL), received;
        char *out = arena_alloc(&scratch, size + 1, 1);
        pack_letters(team, to, out);
        char *in = ranks_swap(to, out, size, from, &scratch, &received);
        team->sent += (long long)size;
        unpack(team, from, in);
        arena_free(&scratch);
    }
}

// ---- turns

static void wait_for_turn(Team *team, int member) {
    while (team->turn != member) pthread_cond_wait(&team->changed, &team->mutex);
}

static const TeamBytes *meet(TeamMember *member, Seat seat) {
    Team *team = member->team;
    pthread_mutex_lock(&team->mutex);
    team->seats[member->index] = seat;
    bool last = member->index == member_at(team, team->end - team->first - 1);
    if (member->file) memory_sleep(member->file);
    if (last) carry_letters(team);
    let_sleep(team, member->index);
    if (last)
        team->step = -team->step;
    else
        team->turn += team->step;
    pthread_cond_broadcast(&team->changed);
    wait_for_turn(team, member->index);
    if (member->file) memory_wake(member->file);
    const TeamBytes *got = team->seats[member->index].got;
    pthread_mutex_unlock(&team->mutex);
    return got;
}

const TeamBytes *team_collect(TeamMember *member, const void *data, size_t size, Arena *arena) {
    return meet(member, (Seat){.data = data, .size = size, .arena = arena});
}

const TeamBytes *team_exchange(TeamMember *member, const TeamBytes *to, Arena *arena) {
    return meet(member, (Seat){.to = to, .arena = arena});
}

static void *take_part(void *context) {
    TeamMember *member = context;
    Team *team = member->team;
    pthread_mutex_lock(&team->mutex);
    while (team->turn != member->index && !team->off) pthread_cond_wait(&team->changed, &team->mutex);
    pthread_mutex_unlock(&team->mutex);
    if (team->off) {
        page_file_free(member->file);
        return NULL;
    }
    memory_use_file(member->file);
    team->work(team->context, member);
    memory_use_file(NULL);
    memory_leave_file(member->file);
    pthread_mutex_lock(&team->mutex);
    team->turn += team->step;
    pthread_cond_broadcast(&team->changed);
    pthread_mutex_unlock(&team->mutex);
    return NULL;
}

// Members are as deep in calls as the whole program is.
static const size_t STACK = (size_t)8 << 20;

bool team_run(int count, void (*work)(void *context, TeamMember *member), void *context, const char *folder,
              Error *error) {
    Arena arena = {0};
    Team team = {.count = count,
                 .first = first_of_rank(count, team_rank()),
                 .end = first_of_rank(count, team_rank() + 1),
                 .turn = -1,
                 .step = 1,
                 .seats = ARENA_ARRAY(&arena, Seat, count),
                 .work = work,
                 .context = context};
    TeamMember *members = team.members = ARENA_ARRAY(&arena, TeamMember, count);
    pthread_attr_t attributes;
    CORE_ASSERT(team.first < team.end);
    pthread_mutex_init(&team.mutex, NULL);
    pthread_cond_init(&team.changed, NULL);
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK);
    int started = team.first;
    for (; started < team.end; started++) {
        TeamMember *member = &members[started];
        *member = (TeamMember){.team = &team, .index = started};
        if (folder && !(member->file = page_file_new(folder, error))) break;
        if (pthread_create(&member->thread, &attributes, take_part, member) == 0) continue;
        error_set(error, "there are too few threads for %d groups of cells", count);
        page_file_free(member->file);
        break;
    }
    bool good = started == team.end;
    pthread_mutex_lock(&team.mutex);
    team.turn = good ? team.first : -1;
    team.off = !good;
    pthread_cond_broadcast(&team.changed);
    pthread_mutex_unlock(&team.mutex);
    for (int m = team.first; m < started; m++) pthread_join(members[m].thread, NULL);
    pthread_attr_destroy(&attributes);
    pthread_cond_destroy(&team.changed);
    pthread_mutex_destroy(&team.mutex);
    arena_free(&arena);
    return good;
}

// ---- sums

void team_join(TeamMember *member, double *sum, int sums, double *most, int mosts) {
    Arena scratch = {0};
    double *own = ARENA_ARRAY(&scratch, double, sums + mosts);
    if (sums > 0) memcpy(own, sum, (size_t)sums * sizeof *own);
    if (mosts > 0) memcpy(own + sums, most, (size_t)mosts * sizeof *own);
    const TeamBytes *all = team_collect(member, own, (size_t)(sums + mosts) * sizeof *own, &scratch);
    for (int i = 0; i < sums; i++) sum[i] = 0;
    for (int m = 0; m < team_count(member); m++) {
        const double *of = all[m].data;
        for (int i = 0; i < sums; i++) sum[i] += of[i];
        for (int i = 0; i < mosts; i++) most[i] = m == 0 || of[sums + i] > most[i] ? of[sums + i] : most[i];
    }
    arena_free(&scratch);
}

void team_sum(TeamMember *member, double *value, int count) { team_join(member, value, count, NULL, 0); }
void team_most(TeamMember *member, double *value, int count) { team_join(member, NULL, 0, value, count); }

bool team_any(TeamMember *member, bool value) {
    double any = value;
    team_most(member, &any, 1);
    return any > 0;
}
