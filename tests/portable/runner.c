// runner.c - runs the tests that stand-in criterion.h listed, each in a fork, as many at a time as there are cores: runner
// [SUITE/NAME pattern ...]. A line a test; the last one is `N passed, N failed, N skipped`.
#include <criterion/criterion.h>
#include <fnmatch.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { USUAL_SECONDS = 60, SLOWER = 40, SKIPPED = 77 };

static PortableTest *first;
static int failures;

void portable_add(PortableTest *test) {
    test->next = first;
    first = test;
}

void portable_fail(bool fatal, const char *file, int line, const char *check, const char *format, ...) {
    va_list args;
    printf("  %s:%d: %s: ", file, line, check);
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    putchar('\n');
    failures++;
    if (!fatal) return;
    fflush(stdout);
    _exit(1);
}

void portable_skip(const char *format, ...) {
    va_list args;
    printf("  skipped: ");
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    putchar('\n');
    fflush(stdout);
    _exit(SKIPPED);
}

static bool is_asked(const PortableTest *test, int count, char **patterns) {
    char name[256];
    snprintf(name, sizeof name, "%s/%s", test->suite, test->name);
    for (int i = 0; i < count; i++)
        if (fnmatch(patterns[i], name, 0) == 0) return true;
    return count == 0;
}

typedef struct Run {
    const PortableTest *test;
    pid_t child;
    time_t began;
} Run;

static Run begin(const PortableTest *test) {
    fflush(stdout);
    Run run = {test, fork(), time(NULL)};
    if (run.child == 0) {
        alarm((unsigned)(SLOWER * (test->timeout > 0 ? test->timeout : USUAL_SECONDS)));
        test->run();
        fflush(stdout);
        exit(failures > 0);
    }
    return run;
}

// Waits for one of the runs, and takes it from the list. Returns the exit status of its test: 0 good, SKIPPED, else bad.
static int await_one(Run *runs, int *count) {
    int status = 0, at = 0;
    pid_t child = wait(&status);
    while (runs[at].child != child) at++;
    Run run = runs[at];
    runs[at] = runs[--*count];
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    printf("%s %s/%s %ld s\n",
           code == 0         ? "passed"
           : code == SKIPPED ? "skipped"
                             : "FAILED",
           run.test->suite, run.test->name, (long)(time(NULL) - run.began));
    return code;
}

int main(int argc, char **argv) {
    enum { MOST = 64 };
    Run runs[MOST];
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int passed = 0, failed = 0, skipped = 0, running = 0;
    for (const PortableTest *t = first; t || running > 0;) {
        if (t && running < cores && running < MOST) {
            if (is_asked(t, argc - 1, argv + 1)) runs[running++] = begin(t);
            t = t->next;
            continue;
        }
        int status = await_one(runs, &running);
        passed += status == 0;
        skipped += status == SKIPPED;
        failed += status != 0 && status != SKIPPED;
    }
    printf("%d passed, %d failed, %d skipped\n", passed, failed, skipped);
    return failed > 0;
}
