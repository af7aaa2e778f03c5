/* SPDX-License-Identifier: Apache-2.0 */
/* Unit tests that register themselves. A file of tests defines each with TEST, or with TEST_WITH or
 * TEST_BETWEEN if it needs a fixture; unit_test.c has the main function, which runs them in the
 * order of the file. */
#ifndef ASSAY_TESTS_UNIT_TEST_H
#define ASSAY_TESTS_UNIT_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#ifdef __SANITIZE_THREAD__
enum { HAS_THREAD_SANITIZER = 1 };
#else
enum { HAS_THREAD_SANITIZER = 0 };
#endif

struct unit_test {
    struct CMUnitTest test;
    int line;                /* of its file: the order of the tests */
    bool (*is_wanted)(void); /* asked after unit_test_open(); NULL: the test always runs */
};

/* A program may define these. The first is called before the tests with the program's argument, or
 * NULL; it returns NULL, or the reason why all tests are skipped. The second is called at the end.
 * Arguments behind the first one follow it in unit_test_arguments, which ends with NULL. */
extern char **unit_test_arguments;
__attribute__((weak)) const char *unit_test_open(const char *argument);
__attribute__((weak)) void unit_test_close(void);

/* Defined by a program whose tests may leave memory, to return true. */
__attribute__((weak)) bool unit_test_keeps_memory(void);

/* That a text has a part, or has it not. */
void assert_has(const char *text, const char *part);
void assert_lacks(const char *text, const char *part);
/* The text has the parts, which have "..." between them, one behind the other. */
void assert_parts(const char *text, const char *parts);

/* Runs `run` on so many threads at once, each with its element of an array, and waits for them. */
void unit_test_run_threads(size_t thread_count, void *(*run)(void *element), void *elements,
                           size_t element_size);

/* Called before main. The program keeps the pointer. */
void unit_test_register(const struct unit_test *test);

#define UNIT_TEST_REGISTER(name_, set_up_, tear_down_, is_wanted_)                                 \
    __attribute__((constructor)) static void register_##name_(void)                                \
    {                                                                                              \
        static const struct unit_test test = {                                                     \
            {#name_, run_##name_, set_up_, tear_down_, NULL}, __LINE__, is_wanted_};               \
        unit_test_register(&test);                                                                 \
    }

#define UNIT_TEST_FUNCTION(name_, statement)                                                       \
    static void name_(void **state)                                                                \
    {                                                                                              \
        (void)state;                                                                               \
        statement;                                                                                 \
    }

#define UNIT_TEST_FIXTURE(name_, statement, result)                                                \
    static int name_(void **state)                                                                 \
    {                                                                                              \
        (void)state;                                                                               \
        statement;                                                                                 \
        return result;                                                                             \
    }

/* A test without a fixture: TEST(name) { ... }. */
#define TEST(name_)                                                                                \
    static void name_(void);                                                                       \
    UNIT_TEST_FUNCTION(run_##name_, name_())                                                       \
    UNIT_TEST_REGISTER(name_, NULL, NULL, NULL)                                                    \
    static void name_(void)

/* A test between the calls set_up() and tear_down(), which is made even if the test fails. It runs
 * only if the condition is true, which is evaluated after unit_test_open(). */
#define TEST_BETWEEN_IF(name_, set_up, tear_down, condition)                                       \
    static void name_(void);                                                                       \
    static bool is_wanted_##name_(void)                                                            \
    {                                                                                              \
        return condition;                                                                          \
    }                                                                                              \
    UNIT_TEST_FUNCTION(run_##name_, name_())                                                       \
    UNIT_TEST_FIXTURE(set_up_##name_, set_up(), 0)                                                 \
    UNIT_TEST_FIXTURE(tear_down_##name_, tear_down(), 0)                                           \
    UNIT_TEST_REGISTER(name_, set_up_##name_, tear_down_##name_, is_wanted_##name_)                \
    static void name_(void)

static inline void unit_test_nothing(void) {}

/* A test without a fixture that runs only if the condition is true. */
#define TEST_IF(name_, condition)                                                                  \
    TEST_BETWEEN_IF(name_, unit_test_nothing, unit_test_nothing, condition)

#define TEST_BETWEEN(name, set_up, tear_down) TEST_BETWEEN_IF(name, set_up, tear_down, true)
#define TEST_OPENED(name, set_up) TEST_BETWEEN(name, set_up, unit_test_nothing)
#define TEST_CLOSED(name, tear_down) TEST_BETWEEN(name, unit_test_nothing, tear_down)

/* A test for each row of an array, with the name that is the row's member `test`: TEST_OF_ROWS(run,
 * rows, const struct row *row, set_up) { ... }. */
#define TEST_OF_ROWS(name, rows, parameter, set_up)                                                \
    TEST_OF_ROWS_BETWEEN(name, rows, parameter, set_up, unit_test_nothing)
#define TEST_OF_ROWS_BETWEEN(name_, rows, parameter, set_up, tear_down)                            \
    static void name_(parameter);                                                                  \
    UNIT_TEST_FUNCTION(run_##name_, name_(*state))                                                 \
    UNIT_TEST_FIXTURE(set_up_##name_, set_up(), 0)                                                 \
    UNIT_TEST_FIXTURE(tear_down_##name_, tear_down(), 0)                                           \
    __attribute__((constructor)) static void register_##name_(void)                                \
    {                                                                                              \
        static struct unit_test tests[sizeof(rows) / sizeof((rows)[0])];                           \
        for (size_t i = 0; i < sizeof(rows) / sizeof((rows)[0]); i++) {                            \
            tests[i] = (struct unit_test){{(rows)[i].test, run_##name_, set_up_##name_,            \
                                           tear_down_##name_, (void *)&(rows)[i]},                 \
                                          __LINE__,                                                \
                                          NULL};                                                   \
            unit_test_register(&tests[i]);                                                         \
        }                                                                                          \
    }                                                                                              \
    static void name_(parameter)

/* A test that takes `parameter`, a pointer to a fixture: set_up() makes the fixture, and
 * tear_down(fixture) destroys it, even if the test fails. */
#define TEST_WITH(name_, parameter, set_up, tear_down)                                             \
    static void name_(parameter);                                                                  \
    UNIT_TEST_FUNCTION(run_##name_, name_(*state))                                                 \
    UNIT_TEST_FIXTURE(set_up_##name_, *state = set_up(), *state == NULL)                           \
    UNIT_TEST_FIXTURE(tear_down_##name_, tear_down(*state), 0)                                     \
    UNIT_TEST_REGISTER(name_, set_up_##name_, tear_down_##name_, NULL)                             \
    static void name_(parameter)

#endif
