// team.c - a thread for each member, of which one runs at a time: whoever waits hands the turn to the next, and the last to come carries
// all letters. Turns go there and back: the last goes on first, since what it has is still in memory.
#include "engine/team/team.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

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
    int count;
    int *order;      // [count] members by processes
    int *first;      // [ranks + 1] those of process r are order[first[r]] .. order[first[r + 1] - 1]
    const int *own;  // [own_count] those of this process
    int own_count;
    int turn;  // the place in `own` of who works, -1: none does yet
    int step;  // how far it is to the next, 1 or -1
    bool off;  // none will work
    long long sent;
    // Bytes that members handed to one each, [count * count] by giver and taker, and to all, [count]. Of this process's members.
    long long *handed, *told;
    const double *weight;
    Seat *seats;          // [count], of which those of this process's members are filled
    TeamMember *members;  // [own_count]
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    void (*work)(void *context, TeamMember *member);
    void *context;
} Team;

struct TeamMember {
    Team *team;
    int index, place;  // in the team, and in team->own
    pthread_t thread;
    PageFile *file;
};

int team_count(const TeamMember *member) { return member->team->count; }
int team_index(const TeamMember *member) { return member->index; }
long long team_sent(const TeamMember *member) { return member->team->sent; }

// ---- letters

// The place of the member that comes as number k between two meetings.
static int place_at(const Team *team, int k) { return team->step > 0 ? k : team->own_count - 1 - k; }

// Nobody works. Once members have much in memory, what they have goes, first of those whose turns are farthest away: of those that came,
// up to the place `last`, in their order, and then of those that are to come, from the end.
static void let_sleep(const Team *team, int last) {
    int own = team->own_count, came = (last - place_at(team, 0)) * team->step + 1;
    Error error;
    if (!team->members[0].file) return;
    for (int i = 0; i < own && memory_much_resident(); i++)
        if (!page_file_drop(team->members[place_at(team, i < came ? i : own - 1 - (i - came))].file, &error))
            memory_end_saying(error.text);
}

// Room for a member that sleeps, where its memory lies.
static void *room_of(const Team *team, int place, size_t count, size_t size) {
    PageFile *own = memory_use_file(team->members[place].file);
    void *room = arena_alloc(team->seats[team->own[place]].arena, count, size);
    memory_use_file(own);
    return room;
}

static void hand_over(const Team *team, int place, int from, TeamBytes letter) {
    void *copy = room_of(team, place, letter.size + 1, 1);
    if (letter.size > 0) memcpy(copy, letter.data, letter.size);
    team->seats[team->own[place]].got[from] = (TeamBytes){copy, letter.size};
}

static TeamBytes letter_of(const Seat *from, int to) {
    return from->to ? from->to[to] : (TeamBytes){from->data, from->size};
}

static void count_letters(Team *team, int from) {
    const Seat *seat = &team->seats[from];
    if (!seat->to) team->told[from] += (long long)seat->size;
    for (int to = 0; seat->to && to < team->count; to++)
        team->handed[(size_t)from * (size_t)team->count + (size_t)to] += (long long)seat->to[to].size;
}

// Letters to another process: each with its size before it, by senders and then by receivers; one letter where all get the same.

static size_t put(char *at, const void *data, size_t size) {
    if (at && size > 0) memcpy(at, data, size);
    return size;
}

static size_t pack_letters(const Team *team, int rank, char *out) {
    size_t size = 0;
    int first = team->first[rank], end = team->first[rank + 1];
    for (int place = 0; place < team->own_count; place++) {
        const Seat *seat = &team->seats[team->own[place]];
        for (int to = first; to < (seat->to ? end : first + 1); to++) {
            TeamBytes letter = letter_of(seat, team->order[to]);
            size += put(out ? out + size : NULL, &letter.size, sizeof letter.size);
            size += put(out ? out + size : NULL, letter.data, letter.size);
        }
    }
    return size;
}

static void unpack(Team *team, int rank, const char *from) {
    bool each = team->seats[team->own[0]].to != NULL;
    for (int sender = team->first[rank]; sender < team->first[rank + 1]; sender++) {
        for (int place = 0; place < team->own_count; place++) {
            TeamBytes letter;
            memcpy(&letter.size, from, sizeof letter.size);
            letter.data = from + sizeof letter.size;
            hand_over(team, place, team->order[sender], letter);
            if (each || place + 1 == team->own_count) from += sizeof letter.size + letter.size;
        }
    }
}

// The last of this process's members has come.
static void carry_letters(Team *team) {
    int ranks = team_ranks(), own = team_rank();
    for (int i = 0; i < team->own_count; i++) count_letters(team, team->own[i]);
    for (int k = 0; k < team->own_count; k++) {
        int place = place_at(team, k), to = team->own[place];
        team->seats[to].got = room_of(team, place, (size_t)team->count, sizeof(TeamBytes));
        for (int i = 0; i < team->own_count; i++)
            hand_over(team, place, team->own[i], letter_of(&team->seats[team->own[i]], to));
        let_sleep(team, place);
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

static void wait_for_turn(const TeamMember *member) {
    Team *team = member->team;
    while (team->turn != member->place) pthread_cond_wait(&team->changed, &team->mutex);
}

static const TeamBytes *meet(TeamMember *member, Seat seat) {
    Team *team = member->team;
    pthread_mutex_lock(&team->mutex);
    team->seats[member->index] = seat;
    bool last = member->place == place_at(team, team->own_count - 1);
    if (member->file) memory_sleep(member->file);
    if (last) carry_letters(team);
    let_sleep(team, member->place);
    if (last)
        team->step = -team->step;
    else
        team->turn += team->step;
    pthread_cond_broadcast(&team->changed);
    wait_for_turn(member);
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
    while (team->turn != member->place && !team->off) pthread_cond_wait(&team->changed, &team->mutex);
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

// ---- processes

// A member, the heaviest first; of equal ones the first.
typedef struct Weighed {
    double weight;
    int member;
} Weighed;

static int by_weight(const void *a, const void *b) {
    const Weighed *one = a, *other = b;
    if (one->weight != other->weight) return one->weight > other->weight ? -1 : 1;
    return one->member - other->member;
}

// Each member, the heaviest first, goes to the process that has least to do so far (Graham 1969: longest processing time first). So each
// process gets one. The first member is with the first process. Returns the process of each member, in the arena.
static int *share_members(int count, const double *weight, int ranks, Arena *arena) {
    Arena scratch = {0};
    Weighed *members = ARENA_ARRAY(&scratch, Weighed, count);
    int *rank_of = ARENA_ARRAY(arena, int, count);
    double *load = ARENA_ARRAY(&scratch, double, ranks);
    for (int m = 0; m < count; m++) members[m] = (Weighed){weight ? weight[m] : 1, m};
    qsort(members, (size_t)count, sizeof *members, by_weight);
    for (int m = 0; m < count; m++) {
        int least = 0;
        for (int r = 1; r < ranks; r++)
            if (load[r] < load[least]) least = r;
        CORE_ASSERT(members[m].weight > 0);
        load[least] += members[m].weight;
        rank_of[members[m].member] = least;
    }
    int with_first = rank_of[0];
    for (int m = 0; m < count; m++)
        rank_of[m] = rank_of[m] == with_first ? 0 : rank_of[m] == 0 ? with_first : rank_of[m];
    arena_free(&scratch);
    return rank_of;
}

static void seat_members(Team *team, Arena *arena) {
    Arena scratch = {0};
    int ranks = team_ranks(), at = 0;
    const int *rank_of = share_members(team->count, team->weight, ranks, &scratch);
    team->order = ARENA_ARRAY(arena, int, team->count);
    team->first = ARENA_ARRAY(arena, int, ranks + 1);
    for (int r = 0; r < ranks; r++) {
        for (int m = 0; m < team->count; m++)
            if (rank_of[m] == r) team->order[at++] = m;
        team->first[r + 1] = at;
    }
    team->own = team->order + team->first[team_rank()];
    team->own_count = team->first[team_rank() + 1] - team->first[team_rank()];
    arena_free(&scratch);
}

long long team_would_send(const TeamMember *member, int ranks) {
    const Team *team = member->team;
    Arena scratch = {0};
    const int *rank_of = share_members(team->count, team->weight, ranks, &scratch);
    long long bytes = 0;
    CORE_ASSERT(team_ranks() == 1);
    for (int from = 0; from < team->count; from++) {
        if (rank_of[from] != 0) continue;
        bytes += (ranks - 1) * team->told[from];
        for (int to = 0; to < team->count; to++)
            if (rank_of[to] != 0) bytes += team->handed[(size_t)from * (size_t)team->count + (size_t)to];
    }
    arena_free(&scratch);
    return bytes;
}

// Members are as deep in calls as the whole program is.
static const size_t STACK = (size_t)8 << 20;

bool team_run(int count, const double *weight, void (*work)(void *context, TeamMember *member), void *context,
              const char *folder, Error *error) {
    Arena arena = {0};
    Team team = {.count = count,
                 .turn = -1,
                 .step = 1,
                 .handed = ARENA_ARRAY(&arena, long long, (size_t)count *(size_t)count),
                 .told = ARENA_ARRAY(&arena, long long, count),
                 .weight = weight,
                 .seats = ARENA_ARRAY(&arena, Seat, count),
                 .work = work,
                 .context = context};
    seat_members(&team, &arena);
    CORE_ASSERT(team.own_count > 0);
    TeamMember *members = team.members = ARENA_ARRAY(&arena, TeamMember, team.own_count);
    pthread_attr_t attributes;
    pthread_mutex_init(&team.mutex, NULL);
    pthread_cond_init(&team.changed, NULL);
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK);
    int started = 0;
    for (; started < team.own_count; started++) {
        TeamMember *member = &members[started];
        *member = (TeamMember){.team = &team, .index = team.own[started], .place = started};
        if (folder && !(member->file = page_file_new(folder, error))) break;
        if (pthread_create(&member->thread, &attributes, take_part, member) == 0) continue;
        error_set(error, "there are too few threads for %d groups of cells", count);
        page_file_free(member->file);
        break;
    }
    bool good = started == team.own_count;
    pthread_mutex_lock(&team.mutex);
    team.turn = good ? 0 : -1;
    team.off = !good;
    pthread_cond_broadcast(&team.changed);
    pthread_mutex_unlock(&team.mutex);
    for (int m = 0; m < started; m++) pthread_join(members[m].thread, NULL);
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
