/* SPDX-License-Identifier: Apache-2.0 */
/* Unit tests that register themselves. A file of tests defines each with TEST, or with TEST_WITH if
 * it needs a fixture; unit_test.c has the main function, which runs them in the order of the file.
 */
#ifndef ASSAY_TESTS_STATE_UNIT_TEST_H
#define ASSAY_TESTS_STATE_UNIT_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

struct unit_test {
    struct CMUnitTest test;
    int line; /* of its file: the order of the tests */
};

/* Runs `run` on so many threads at once, each with its element of an array, and waits for them. */
void unit_test_run_threads(size_t thread_count, void *(*run)(void *element), void *elements,
                           size_t element_size);

/* Called before main. The program keeps the pointer. */
void unit_test_register(const struct unit_test *test);

#define UNIT_TEST_REGISTER(name_, set_up_, tear_down_)                                             \
    __attribute__((constructor)) static void register_##name_(void)                                \
    {                                                                                              \
        static const struct unit_test test = {{#name_, run_##name_, set_up_, tear_down_, NULL},    \
                                              __LINE__};                                           \
        unit_test_register(&test);                                                                 \
    }

/* A test without a fixture: TEST(name) { ... }. */
#define TEST(name_)                                                                                \
    static void name_(void);                                                                       \
    static void run_##name_(void **state)                                                          \
    {                                                                                              \
        (void)state;                                                                               \
        name_();                                                                                   \
    }                                                                                              \
    UNIT_TEST_REGISTER(name_, NULL, NULL)                                                          \
    static void name_(void)

/* A test that takes `parameter`, a pointer to a fixture: set_up() makes the fixture, and
 * tear_down(fixture) destroys it, even if the test fails. */
#define TEST_WITH(name_, parameter, set_up, tear_down)                                             \
    static void name_(parameter);                                                                  \
    static int set_up_##name_(void **state)                                                        \
    {                                                                                              \
        *state = set_up();                                                                         \
        return *state == NULL;                                                                     \
    }                                                                                              \
    static int tear_down_##name_(void **state)                                                     \
    {                                                                                              \
        tear_down(*state);                                                                         \
        return 0;                                                                                  \
    }                                                                                              \
    static void run_##name_(void **state)                                                          \
    {                                                                                              \
        name_(*state);                                                                             \
    }                                                                                              \
    UNIT_TEST_REGISTER(name_, set_up_##name_, tear_down_##name_)                                   \
    static void name_(parameter)

#endif
