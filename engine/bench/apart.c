// apart.c - see apart.h.
#include "engine/bench/apart.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"

void *apart_memory(size_t size) {
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory != MAP_FAILED) return memory;
    memory_end(size);
}

void apart_memory_free(void *memory, size_t size) { munmap(memory, size); }

bool apart_run(void (*work)(void *context), void *context, const char *what, Error *error) {
    fflush(NULL);  // or the copy would write it again
    pid_t child = fork();
    if (child < 0) return error_set(error, "%s: no process can be started: %s", what, strerror(errno));
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for it then
        parallel_set_ranks(NULL);          // it is none of those that mpirun started
        work(context);
        _exit(0);
    }
    int status;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return error_set(error, "%s: its process is lost: %s", what, strerror(errno));
    }
    if (WIFSIGNALED(status)) return error_set(error, "%s: ended by signal %d", what, WTERMSIG(status));
    return WEXITSTATUS(status) == 0 || error_set(error, "%s: exit status %d", what, WEXITSTATUS(status));
}

double apart_seconds(struct timeval t) { return (double)t.tv_sec + 1e-6 * (double)t.tv_usec; }

ApartUsage apart_usage(void) {
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    return (ApartUsage){apart_seconds(used.ru_utime) + apart_seconds(used.ru_stime),
                        (double)used.ru_maxrss / 1024};
}
