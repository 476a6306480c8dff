// team.h - members of a team do the same work, each on data of its own, and exchange bytes between its steps.
//
// Members take turns: of those of one process one works at a time, with as many threads as it likes, until it waits for the others. So the
// memory for work at hand is that of one member, and what each of them computes depends neither on how many processes share the team nor
// on which member is where. All members call the same functions of this header in the same order.
#ifndef TEAM_TEAM_H
#define TEAM_TEAM_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"

typedef struct TeamMember TeamMember;

typedef struct TeamBytes {
    const void *data;
    size_t size;
} TeamBytes;

// Runs work(context, member) for members 0 .. count - 1, those of this process here (team_ranks), and returns when all are done. A member
// that fails goes on until all know it (team_any). False, and nothing was run: there are too few threads, or a file cannot be made.
//
// `weight` [count], above 0: how much each has to do, by which processes share them; NULL: all the same.
// `folder`: members that wait sleep; their large arrays lie in files there meanwhile (page_file.h), so the process needs memory for one of
// them, and all of that is gone at the end. NULL: they keep their memory.
bool team_run(int count, const double *weight, void (*work)(void *context, TeamMember *member), void *context,
              const char *folder, Error *error);

// The number of members, and which of them this is.
int team_count(const TeamMember *member);
int team_index(const TeamMember *member);

// Each member gives bytes, and all get those of all, in the order of members: an array [team_count] in the arena.
const TeamBytes *team_collect(TeamMember *member, const void *data, size_t size, Arena *arena);
// `to` [team_count]: bytes for each member. Returns the bytes from each, in the arena.
const TeamBytes *team_exchange(TeamMember *member, const TeamBytes *to, Arena *arena);

// Sums in the order of members, and maxima, of each of `count` values.
void team_sum(TeamMember *member, double *value, int count);
void team_most(TeamMember *member, double *value, int count);
// Both at one meeting: members that sleep are woken once.
void team_join(TeamMember *member, double *sum, int sums, double *most, int mosts);
// Is it true of any member?
bool team_any(TeamMember *member, bool value);

// Bytes that members sent to members of other processes so far.
long long team_sent(const TeamMember *member);
// Where there is one process: the bytes that the first of so many would have sent so far.
long long team_would_send(const TeamMember *member, int ranks);

// Processes that share a team, and which of them this is: 1 and 0 where mpirun did not start this process, and before team_start. A process
// that ends without team_end ends all.
// False in a build without `mpi=1` where mpirun started several.
bool team_start(int *argc, char ***argv);
void team_end(void);
int team_ranks(void);
int team_rank(void);
// Did mpirun start this process, be it alone?
bool team_is_started(void);
// Process 0 says this on standard error when mpirun ends it, since another process ended or the user stops them all; NULL: nothing.
void team_last_words(const char *sentence);

#endif
