// team_ranks.c - without MPI there is one process; with it (make mpi=1), as many as mpirun started.
#include "engine/team/team_ranks.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/parallel.h"
#include "engine/team/team.h"

// Open MPI's mpirun tells it to those whom it starts.
static const char *started_processes(void) { return getenv("OMPI_COMM_WORLD_SIZE"); }

bool team_is_started(void) { return started_processes() != NULL; }

// Written before the signal is let through, read by its handler alone.
static char words[1024];
static size_t word_count;

static void say_last_words(int signal_number) {
    if (write(STDERR_FILENO, words, word_count) < 0) _exit(1);
    raise(signal_number);
}

void team_last_words(const char *sentence) {
    struct sigaction action = {.sa_handler = SIG_DFL};
    if (team_ranks() == 1 || team_rank() > 0) return;
    sigaction(SIGTERM, &action, NULL);
    if (!sentence) return;
    word_count = strnlen(sentence, sizeof words);
    memcpy(words, sentence, word_count);
    action = (struct sigaction){.sa_handler = say_last_words, .sa_flags = (int)SA_RESETHAND};
    sigaction(SIGTERM, &action, NULL);
}

#ifdef ENFILADE_MPI
#include <mpi.h>

// MPI counts bytes as int.
static const size_t PIECE = (size_t)1 << 30;

static int rank_count = 1, own_rank;

// Indices of the loop at hand that were taken: in the memory of the first process, which all of them read and write.
static MPI_Win counter_window;
static int *counter;

static int take_pieces(int pieces) {
    int first;
    MPI_Fetch_and_op(&pieces, &first, MPI_INT, 0, 0, MPI_SUM, counter_window);
    MPI_Win_flush(0, counter_window);
    return first;
}

static const Bytes *collect_bytes(Bytes own, Arena *arena) {
    Bytes *all = ARENA_ARRAY(arena, Bytes, rank_count);
    all[own_rank] = own;
    for (int step = 1; step < rank_count; step++) {
        int to = (own_rank + step) % rank_count, from = (own_rank + rank_count - step) % rank_count;
        all[from].data = ranks_swap(to, own.data, own.size, from, arena, &all[from].size);
    }
    // All have what they take of this loop, and nobody has begun the next.
    static const int NONE = 0;
    MPI_Barrier(MPI_COMM_WORLD);
    if (own_rank == 0) {
        MPI_Accumulate(&NONE, 1, MPI_INT, 0, 0, 1, MPI_INT, MPI_REPLACE, counter_window);
        MPI_Win_flush(0, counter_window);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    return all;
}

static void share_loops(void) {
    static ParallelRanks ranks;
    MPI_Aint size = own_rank == 0 ? (MPI_Aint)sizeof *counter : 0;
    MPI_Win_allocate(size, (int)sizeof *counter, MPI_INFO_NULL, MPI_COMM_WORLD, &counter, &counter_window);
    if (own_rank == 0) *counter = 0;
    MPI_Win_lock_all(0, counter_window);
    MPI_Barrier(MPI_COMM_WORLD);
    ranks = (ParallelRanks){rank_count, own_rank, take_pieces, collect_bytes};
    parallel_set_ranks(&ranks);
}

bool team_start(int *argc, char ***argv) {
    if (!team_is_started()) return true;
    MPI_Init(argc, argv);
    MPI_Comm_size(MPI_COMM_WORLD, &rank_count);
    MPI_Comm_rank(MPI_COMM_WORLD, &own_rank);
    if (rank_count > 1) share_loops();
    return true;
}

void team_end(void) {
    if (!team_is_started()) return;
    if (rank_count > 1) {
        parallel_set_ranks(NULL);
        MPI_Win_unlock_all(counter_window);
        MPI_Win_free(&counter_window);
    }
    MPI_Finalize();
}

int team_ranks(void) { return rank_count; }
int team_rank(void) { return own_rank; }

void *ranks_swap(int to, const void *data, size_t size, int from, Arena *arena, size_t *received) {
    unsigned long long out = size, in = 0;
    MPI_Sendrecv(&out, 1, MPI_UNSIGNED_LONG_LONG, to, 0, &in, 1, MPI_UNSIGNED_LONG_LONG, from, 0,
                 MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    char *got = arena_alloc(arena, (size_t)in + 1, 1);
    const char *sent = data;
    for (size_t at = 0; at < out || at < in; at += PIECE) {
        size_t send = at < out ? (out - at < PIECE ? out - at : PIECE) : 0,
               receive = at < in ? (in - at < PIECE ? in - at : PIECE) : 0;
        // Who has nothing more to send or to receive leaves that out: the others do not know of it.
        MPI_Sendrecv(sent + (send > 0 ? at : 0), (int)send, MPI_BYTE, send > 0 ? to : MPI_PROC_NULL, 1,
                     got + (receive > 0 ? at : 0), (int)receive, MPI_BYTE, receive > 0 ? from : MPI_PROC_NULL,
                     1, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    *received = (size_t)in;
    return got;
}

#else

bool team_start(int *argc, char ***argv) {
    (void)argc, (void)argv;
    return !team_is_started() || strcmp(started_processes(), "1") == 0;
}

void team_end(void) {}
int team_ranks(void) { return 1; }
int team_rank(void) { return 0; }

void *ranks_swap(int to, const void *data, size_t size, int from, Arena *arena, size_t *received) {
    (void)to, (void)data, (void)size, (void)from, (void)arena;
    *received = 0;
    return NULL;
}

#endif
