/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that a warning about a setting comes once in a process, however many instances there are.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "hearing.h"

enum { THREADS = 8, VALUES = 300 };

/* How many warnings an instance brings that is created with this level. */
static unsigned count_warnings(const char *level)
{
    struct hearing hearing = {0};
    const VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&hearing);
    setenv("VK_ASSAY_VALIDATION_LEVEL", level, 1);
    reporter_destroy(reporter_of(&info));
    return hearing.count;
}

static void test_instances(void **state)
{
    assert_int_equal(count_warnings("instances-1"), 1);
    assert_int_equal(count_warnings("instances-1"), 0);
    assert_int_equal(count_warnings("instances-2"), 1);
    assert_int_equal(count_warnings("instances-1"), 0);
    assert_int_equal(count_warnings("instances-2"), 0);
    assert_int_equal(count_warnings("state"), 0);
}

static void test_unknown_key(void **state)
{
    setenv("VK_ASSAY_VALIDATION_LEVLE", "state", 1);
    assert_int_equal(count_warnings("state"), 1);
    assert_int_equal(count_warnings("state"), 0);
    assert_int_equal(count_warnings("unknown-key"), 1);
}

/* If no messenger and no log got a warning, the next instance repeats it. */
static void test_unheard(void **state)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "unheard", 1);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error", 1);
    assert_int_equal(count_warnings("unheard"), 0);
    unsetenv("VK_ASSAY_VALIDATION_REPORT_FLAGS");
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "callback", 1);
    reporter_destroy(reporter_of(NULL));
    unsetenv("VK_ASSAY_VALIDATION_DEBUG_ACTION");
    assert_int_equal(count_warnings("unheard"), 1);
    assert_int_equal(count_warnings("unheard"), 0);
}

/* More than the layer remembers. */
static void test_many_values(void **state)
{
    for (int i = 0; i < VALUES; i++) {
        char level[32];
        snprintf(level, sizeof(level), "many-%d", i);
        assert_int_equal(count_warnings(level), 1);
    }
}

static atomic_uint heard;

static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(
    VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT types,
    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    atomic_fetch_add(&heard, 1);
    return VK_FALSE;
}

static void *create_reporter(void *context)
{
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(NULL);
    info.pfnUserCallback = count_message;
    reporter_destroy(reporter_of(&info));
    return NULL;
}

static void test_threads(void **state)
{
    pthread_t threads[THREADS];
    setenv("VK_ASSAY_VALIDATION_LEVEL", "threads", 1);
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, create_reporter, NULL), 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(atomic_load(&heard), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_instances, surrounding_set_up),
        cmocka_unit_test_setup(test_unknown_key, surrounding_set_up),
        cmocka_unit_test_setup(test_unheard, surrounding_set_up),
        cmocka_unit_test_setup(test_threads, surrounding_set_up),
        cmocka_unit_test_setup(test_many_values, surrounding_set_up), /* fills what is remembered */
    };
    return cmocka_run_group_tests_name("settings_once", tests, NULL, surrounding_remove);
}
