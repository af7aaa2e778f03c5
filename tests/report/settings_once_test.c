/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that a warning about a setting comes once in a process, however many instances there are.
 */
#include <stdatomic.h>

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

TEST_OPENED(test_instances, surrounding_set_up)
{
    assert_int_equal(count_warnings("instances-1"), 1);
    assert_int_equal(count_warnings("instances-1"), 0);
    assert_int_equal(count_warnings("instances-2"), 1);
    assert_int_equal(count_warnings("instances-1"), 0);
    assert_int_equal(count_warnings("instances-2"), 0);
    assert_int_equal(count_warnings("state"), 0);
}

TEST_OPENED(test_unknown_key, surrounding_set_up)
{
    environment_set("LEVLE=state");
    assert_int_equal(count_warnings("state"), 1);
    assert_int_equal(count_warnings("state"), 0);
    assert_int_equal(count_warnings("unknown-key"), 1);
}

/* Each value is valid, but not with the others. */
TEST_OPENED(test_values_that_do_not_go_together, surrounding_set_up)
{
    environment_set("HAZARDS=true");
    assert_int_equal(count_warnings("parameters"), 1);
    assert_int_equal(count_warnings("parameters"), 0);
    assert_int_equal(count_warnings("execution"), 0);
}

/* If no messenger and no log got a warning, the next instance repeats it. */
TEST_OPENED(test_unheard, surrounding_set_up)
{
    environment_set("LEVEL=unheard REPORT_FLAGS=error");
    assert_int_equal(count_warnings("unheard"), 0);
    unsetenv("VK_ASSAY_VALIDATION_REPORT_FLAGS");
    environment_set("DEBUG_ACTION=callback");
    reporter_destroy(reporter_of(NULL));
    unsetenv("VK_ASSAY_VALIDATION_DEBUG_ACTION");
    assert_int_equal(count_warnings("unheard"), 1);
    assert_int_equal(count_warnings("unheard"), 0);
}

static atomic_uint heard;

MESSENGER_CALLBACK(count_message)
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

TEST_OPENED(test_threads, surrounding_set_up)
{
    environment_set("LEVEL=threads");
    unit_test_run_threads(THREADS, create_reporter, NULL, 0);
    assert_int_equal(atomic_load(&heard), 1);
}

/* More than the layer remembers; so it comes last. */
TEST_OPENED(test_many_values, surrounding_set_up)
{
    for (int i = 0; i < VALUES; i++) {
        char level[32];
        snprintf(level, sizeof(level), "many-%d", i);
        assert_int_equal(count_warnings(level), 1);
    }
}
