// criterion.h - as much of Criterion as the tests use, for machines on which it does not run: under qemu-user it cannot start copies of
// itself. Each test runs in a fork (runner.c). Found before the real header on the include path (tests/portable.sh).
#ifndef TESTS_PORTABLE_CRITERION_H
#define TESTS_PORTABLE_CRITERION_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

// A test, listed before main begins.
typedef struct PortableTest {
    const char *suite, *name;
    void (*run)(void);
    // Seconds on a quick machine; 0: the usual.
    double timeout;
    struct PortableTest *next;
} PortableTest;

void portable_add(PortableTest *test);
// Notes a failed check with its place; `fatal` ends the test. The message is formatted as by printf.
void portable_fail(bool fatal, const char *file, int line, const char *check, const char *format, ...);
_Noreturn void portable_skip(const char *format, ...);

struct PortableOptions {
    double timeout;
};

#define Test(suite_, name_, ...)                                                                             \
    static void suite_##_##name_##_run(void);                                                                \
    __attribute__((constructor)) static void suite_##_##name_##_add(void) {                                  \
        static PortableTest test = {#suite_, #name_, suite_##_##name_##_run, 0, NULL};                       \
        struct PortableOptions options = {.timeout = 0, ##__VA_ARGS__};                                      \
        test.timeout = options.timeout;                                                                      \
        portable_add(&test);                                                                                 \
    }                                                                                                        \
    static void suite_##_##name_##_run(void)

// The message is a string literal and its values; without one it is empty.
#define PORTABLE_CHECK(fatal, good, check, ...)                                                              \
    ((good) ? (void)0 : portable_fail(fatal, __FILE__, __LINE__, check, "" __VA_ARGS__))

#define cr_assert(a, ...) PORTABLE_CHECK(true, (a), #a, __VA_ARGS__)
#define cr_expect(a, ...) PORTABLE_CHECK(false, (a), #a, __VA_ARGS__)
#define cr_assert_not(a, ...) PORTABLE_CHECK(true, !(a), "not " #a, __VA_ARGS__)
#define cr_expect_not(a, ...) PORTABLE_CHECK(false, !(a), "not " #a, __VA_ARGS__)
#define cr_assert_null(a, ...) PORTABLE_CHECK(true, (a) == NULL, #a " is NULL", __VA_ARGS__)
#define cr_expect_null(a, ...) PORTABLE_CHECK(false, (a) == NULL, #a " is NULL", __VA_ARGS__)
#define cr_assert_not_null(a, ...) PORTABLE_CHECK(true, (a) != NULL, #a " is not NULL", __VA_ARGS__)
#define cr_expect_not_null(a, ...) PORTABLE_CHECK(false, (a) != NULL, #a " is not NULL", __VA_ARGS__)
#define cr_assert_eq(a, b, ...) PORTABLE_CHECK(true, (a) == (b), #a " == " #b, __VA_ARGS__)
#define cr_expect_eq(a, b, ...) PORTABLE_CHECK(false, (a) == (b), #a " == " #b, __VA_ARGS__)
#define cr_assert_neq(a, b, ...) PORTABLE_CHECK(true, (a) != (b), #a " != " #b, __VA_ARGS__)
#define cr_expect_neq(a, b, ...) PORTABLE_CHECK(false, (a) != (b), #a " != " #b, __VA_ARGS__)
#define cr_assert_lt(a, b, ...) PORTABLE_CHECK(true, (a) < (b), #a " < " #b, __VA_ARGS__)
#define cr_expect_lt(a, b, ...) PORTABLE_CHECK(false, (a) < (b), #a " < " #b, __VA_ARGS__)
#define cr_assert_leq(a, b, ...) PORTABLE_CHECK(true, (a) <= (b), #a " <= " #b, __VA_ARGS__)
#define cr_expect_leq(a, b, ...) PORTABLE_CHECK(false, (a) <= (b), #a " <= " #b, __VA_ARGS__)
#define cr_assert_gt(a, b, ...) PORTABLE_CHECK(true, (a) > (b), #a " > " #b, __VA_ARGS__)
#define cr_expect_gt(a, b, ...) PORTABLE_CHECK(false, (a) > (b), #a " > " #b, __VA_ARGS__)
#define cr_assert_geq(a, b, ...) PORTABLE_CHECK(true, (a) >= (b), #a " >= " #b, __VA_ARGS__)
#define cr_expect_geq(a, b, ...) PORTABLE_CHECK(false, (a) >= (b), #a " >= " #b, __VA_ARGS__)
#define cr_assert_float_eq(a, b, e, ...)                                                                     \
    PORTABLE_CHECK(true, fabs((a) - (b)) <= (e), #a " ~ " #b, __VA_ARGS__)
#define cr_expect_float_eq(a, b, e, ...)                                                                     \
    PORTABLE_CHECK(false, fabs((a) - (b)) <= (e), #a " ~ " #b, __VA_ARGS__)
#define cr_assert_str_eq(a, b, ...) PORTABLE_CHECK(true, strcmp((a), (b)) == 0, #a " is " #b, __VA_ARGS__)
#define cr_expect_str_eq(a, b, ...) PORTABLE_CHECK(false, strcmp((a), (b)) == 0, #a " is " #b, __VA_ARGS__)
#define cr_assert_arr_eq(a, b, size, ...)                                                                    \
    PORTABLE_CHECK(true, memcmp((a), (b), (size)) == 0, #a " is " #b, __VA_ARGS__)
#define cr_expect_arr_eq(a, b, size, ...)                                                                    \
    PORTABLE_CHECK(false, memcmp((a), (b), (size)) == 0, #a " is " #b, __VA_ARGS__)
#define cr_assert_fail(...) PORTABLE_CHECK(true, false, "fails", __VA_ARGS__)
#define cr_expect_fail(...) PORTABLE_CHECK(false, false, "fails", __VA_ARGS__)
#define cr_skip_test(...) portable_skip("" __VA_ARGS__)
#define cr_log_info(...) (fprintf(stderr, __VA_ARGS__), fputc('\n', stderr))
#define cr_log_error(...) cr_log_info(__VA_ARGS__)

#endif
