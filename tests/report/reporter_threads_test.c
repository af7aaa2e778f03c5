/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of messages sent on many threads while messengers come and go, also from inside callbacks;
 * and of warnings about settings, which come once in a process, however many instances there are.
 */
#include <pthread.h>
#include <stdatomic.h>

#include "hearing.h"

enum { SENDERS = 4, SENT_EACH = 500, THREADS = 8, VALUES = 300 };

static atomic_uint heard, last_notices;

MESSENGER_CALLBACK(count_message)
{
    atomic_fetch_add(&heard, 1);
    if (strstr(data->pMessage, "will not be reported for it again"))
        atomic_fetch_add(&last_notices, 1);
    return VK_FALSE;
}

static VkDebugUtilsMessengerCreateInfoEXT messenger(PFN_vkDebugUtilsMessengerCallbackEXT call,
                                                    void *user)
{
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(NULL);
    info.pfnUserCallback = call;
    info.pUserData = user;
    return info;
}

static void *send_many(void *context)
{
    for (unsigned i = 0; i < SENT_EACH; i++)
        send_one(context);
    return NULL;
}

static void send_on_threads(struct reporter *reporter, void (*meanwhile)(struct reporter *))
{
    pthread_t senders[SENDERS];
    atomic_store(&heard, 0);
    atomic_store(&last_notices, 0);
    for (unsigned i = 0; i < SENDERS; i++)
        assert_int_equal(pthread_create(&senders[i], NULL, send_many, reporter), 0);
    meanwhile(reporter);
    for (unsigned i = 0; i < SENDERS; i++)
        pthread_join(senders[i], NULL);
}

static struct reporter *counted(const char *limit)
{
    surrounding_clear(NULL);
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", limit, 1);
    struct reporter *reporter = reporter_of(NULL);
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(count_message, NULL);
    reporter_add(reporter, (VkDebugUtilsMessengerEXT)(uintptr_t)1, &info);
    return reporter;
}

/* ---- */

static void add_and_remove(struct reporter *reporter)
{
    struct hearing report = {0};
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(count_message, NULL);
    VkDebugReportCallbackCreateInfoEXT report_info = hearing_report_callback(&report);
    report_info.flags = VK_DEBUG_REPORT_PERFORMANCE_WARNING_BIT_EXT;
    for (uintptr_t i = 0; i < 300; i++) {
        VkDebugUtilsMessengerEXT handle = (VkDebugUtilsMessengerEXT)(2 + i % 3);
        VkDebugReportCallbackEXT callback = (VkDebugReportCallbackEXT)(1 + i % 3);
        reporter_add_messenger(reporter, handle, &info);
        reporter_add_report_callback(reporter, callback, &report_info);
        reporter_remove_messenger(reporter, handle);
        reporter_remove_report_callback(reporter, callback);
        reporter_set_instance_alive(reporter, i % 2);
    }
}

TEST(test_messengers_come_and_go)
{
    struct reporter *reporter = counted("0");
    send_on_threads(reporter, add_and_remove);
    assert_true(atomic_load(&heard) >= SENDERS * SENT_EACH);
    reporter_destroy(reporter);
}

static void ask_meanwhile(struct reporter *reporter)
{
    for (unsigned i = 0; i < SENT_EACH; i++)
        reporter_wants(reporter, SENT_VUID);
}

TEST(test_the_limit_is_exact)
{
    struct reporter *reporter = counted("100");
    send_on_threads(reporter, ask_meanwhile);
    assert_int_equal(atomic_load(&heard), 100);
    assert_int_equal(atomic_load(&last_notices), 1);
    reporter_destroy(reporter);
}

/* ---- callbacks that call back */

struct meddler {
    struct reporter *reporter;
    VkDebugUtilsMessengerEXT handle;
    unsigned calls;
};

MESSENGER_CALLBACK(meddle)
{
    struct meddler *meddler = user;
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(count_message, NULL);
    meddler->calls++;
    reporter_remove_messenger(meddler->reporter, meddler->handle);
    reporter_add_messenger(meddler->reporter, meddler->handle, &info);
    reporter_warn(meddler->reporter, "A message from inside a callback.");
    return VK_TRUE;
}

TEST(test_a_callback_may_replace_its_messenger)
{
    struct reporter *reporter = counted("0");
    struct meddler meddler = {reporter, (VkDebugUtilsMessengerEXT)(uintptr_t)7, 0};
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(meddle, &meddler);
    reporter_add(reporter, meddler.handle, &info);
    atomic_store(&heard, 0);
    assert_true(send_one(reporter));
    assert_int_equal(meddler.calls, 1);
    assert_int_equal(atomic_load(&heard), 1 + 2); /* the finding once, the warning twice */
    assert_false(send_one(reporter));
    assert_int_equal(meddler.calls, 1);
    assert_int_equal(atomic_load(&heard), 1 + 2 + 2);
    reporter_destroy(reporter);
}

/* ---- warnings that come once */

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

static void *create_reporter(void *context)
{
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(count_message, NULL);
    reporter_destroy(reporter_of(&info));
    return NULL;
}

TEST_OPENED(test_threads, surrounding_set_up)
{
    environment_set("LEVEL=threads");
    atomic_store(&heard, 0);
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
