// team_ranks.h - the processes that share a team (MPI), for team.c alone.
#ifndef TEAM_TEAM_RANKS_H
#define TEAM_TEAM_RANKS_H

#include "engine/core/arena.h"

// Sends bytes to process `to` while those of process `from` are received, into the arena; returns them and their number.
void *ranks_swap(int to, const void *data, size_t size, int from, Arena *arena, size_t *received);

#endif
