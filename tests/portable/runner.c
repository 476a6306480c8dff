// runner.c - runs the tests that stand-in criterion.h listed, each in a fork: runner [SUITE/NAME pattern ...]. Ends with
// `N passed, N failed, N skipped`.
#include <criterion/criterion.h>
#include <fnmatch.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/wait.h>
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

// The exit status of the test: 0 good, SKIPPED, else bad.
static int run_test(const PortableTest *test) {
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        alarm((unsigned)(SLOWER * (test->timeout > 0 ? test->timeout : USUAL_SECONDS)));
        test->run();
        fflush(stdout);
        exit(failures > 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int main(int argc, char **argv) {
    int passed = 0, failed = 0, skipped = 0;
    for (const PortableTest *t = first; t; t = t->next) {
        if (!is_asked(t, argc - 1, argv + 1)) continue;
        int status = run_test(t);
        passed += status == 0;
        skipped += status == SKIPPED;
        failed += status != 0 && status != SKIPPED;
        if (status != 0 && status != SKIPPED) printf("FAILED %s/%s (status %d)\n", t->suite, t->name, status);
    }
    printf("%d passed, %d failed, %d skipped\n", passed, failed, skipped);
    return failed > 0;
}
