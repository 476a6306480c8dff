// peer.c - programs of others, each in a process and a folder of its own.
#include "engine/bench/peer.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/memory.h"

enum { MOST_LOG = 1 << 28, OPEN_FOLDERS = 8 };  // bytes; see nftw

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *at) {
    (void)status, (void)type, (void)at;
    return remove(path);
}

static void remove_folder(void *folder) { nftw(folder, remove_entry, OPEN_FOLDERS, FTW_DEPTH | FTW_PHYS); }

bool peer_in_folder(bool (*use)(const char *folder, void *context, Arena *arena, Error *error), void *context,
                    Arena *arena, Error *error) {
    const char *base = getenv("TMPDIR");
    char *folder = arena_format(arena, "%s/enfilade-peer-XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(folder)) return error_set(error, "%s: cannot be made: %s", folder, strerror(errno));
    MemoryEnd end = {.undo = remove_folder, .context = folder};
    memory_add_end(&end);
    bool good = use(folder, context, arena, error);
    memory_remove_end(&end);
    remove_folder(folder);
    return good;
}

// Its output goes to `log`.
_Noreturn static void become(const char *const *words, const char *log) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for it then
    int in = open("/dev/null", O_RDONLY), out = open(log, O_WRONLY | O_CREAT, 0600);
    if (in >= 0 && out >= 0 && dup2(in, 0) >= 0 && dup2(out, 1) >= 0 && dup2(out, 2) >= 0)
        execvp(words[0], (char *const *)words);
    fprintf(stderr, "%s\n", strerror(errno));
    _exit(127);
}

// The last line that a failed program wrote, for the sentence about it.
static const char *last_line(const char *log, Arena *arena) {
    Bytes text;
    if (!file_read(log, MOST_LOG, arena, &text, NULL)) return "";
    char *start = (char *)text.data, *end = start + text.size;
    while (end > start && (end[-1] == '\n' || end[-1] == '\r')) *--end = 0;
    char *line = strrchr(start, '\n');
    return line ? line + 1 : start;
}

bool peer_run(const char *const *words, const char *folder, Arena *arena, PeerUsage *out, Error *error) {
    const char *log = arena_format(arena, "%s/log", folder), *program = words[0];
    double start = clock_seconds();
    pid_t child = fork();
    if (child < 0) return error_set(error, "%s: cannot be started: %s", program, strerror(errno));
    if (child == 0) become(words, log);
    int status;
    struct rusage used;
    while (wait4(child, &status, 0, &used) < 0) {
        if (errno != EINTR) return error_set(error, "%s: is lost: %s", program, strerror(errno));
    }
    out->wall_seconds = clock_seconds() - start;
    out->cpu_seconds = (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                       1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    out->peak_mb = (double)used.ru_maxrss / 1024;
    if (WIFSIGNALED(status)) return error_set(error, "%s: ended by signal %d", program, WTERMSIG(status));
    if (WEXITSTATUS(status) == 0) return true;
    const char *line = last_line(log, arena);
    return error_set(error, "%s: exit status %d%s%s", program, WEXITSTATUS(status), *line ? ": " : "", line);
}
