/* SPDX-License-Identifier: Apache-2.0 */
/* What the tracer does when the driver does not say that a submission is complete: it destroys
 * nothing that the device may still use. On the null driver, whose waits this test answers. */
#include "layer/compare/tracer.h"

#include <stdlib.h>
#include <string.h>

#include "subject.h"
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

enum { RAYS = 4, WAITS_MAX = 3 };

static struct platform platform;
static struct instance_fixture instance;
static VkQueue queue;
static VkResult waits[WAITS_MAX]; /* the results of the waits, in their order */
static uint32_t wait_count;
static VkPhysicalDeviceMemoryProperties memory;
static bool may_submit; /* the tracer, to the queue */
static uint32_t submissions;
static VkuDeviceDispatchTable vk;
static struct compare_device device;
static struct tracer *tracer;
static uint64_t allocated_before;

static VKAPI_ATTR VkResult VKAPI_CALL wait_for_fences(VkDevice of_device, uint32_t count,
                                                      const VkFence *fences, VkBool32 all,
                                                      uint64_t timeout)
{
    assert_true(wait_count < WAITS_MAX);
    return waits[wait_count++];
}

static uint64_t count_destroyed(void)
{
    static const char *const commands[] = {
        "vkDestroyAccelerationStructureKHR",
        "vkDestroyBuffer",
        "vkFreeMemory",
        "vkDestroyFence",
        "vkDestroyCommandPool",
        "vkDestroyDescriptorPool",
        "vkDestroyPipeline",
    };
    uint64_t count = 0;
    for (size_t i = 0; i < sizeof(commands) / sizeof(commands[0]); i++)
        count += platform.null_driver.calls(commands[i]);
    return count;
}

static bool begin_submission(void *queues, VkQueue used)
{
    assert_ptr_equal(used, queue);
    return may_submit;
}

static void end_submission(void *queues)
{
    ++*(uint32_t *)queues;
}

static void open_tracer_with(const struct instance_settings *settings)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_KHR_RAY_QUERY_EXTENSION_NAME};
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .rayQuery = VK_TRUE);
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features, .pNext = &query,
                 .accelerationStructure = VK_TRUE);
    device = (struct compare_device){.vk = &vk,
                                     .memory = &memory,
                                     .scratch_alignment = 256,
                                     .begin_submission = begin_submission,
                                     .end_submission = end_submission,
                                     .queues = &submissions,
                                     .has_queries = true};
    instance_fixture_create(&instance, &platform, settings);
    instance.vk.GetPhysicalDeviceMemoryProperties(instance.physical, &memory);
    GET(instance_fixture_create_device(&instance, &features, extensions, ARRAY_COUNT(extensions),
                                       &device.handle, &vk));
    vk.GetDeviceQueue(device.handle, 0, 0, &queue);
    allocated_before = platform.null_driver.allocated();
    GET(tracer_create(&device, &tracer));
    wait_count = submissions = 0;
    may_submit = true;
}

static void open_tracer(void)
{
    open_tracer_with(&(struct instance_settings){.without_layer = true});
    vk.WaitForFences = wait_for_fences;
}

static void close_tracer(void)
{
    vk.DestroyDevice(device.handle, NULL);
    assert_int_equal(platform.null_driver.invalid_queries(), 0);
    instance_fixture_close(&instance);
    platform.null_driver.reset();
}

/* The job and all that it names end with the call. */
static VkResult run(VkResult first, VkResult second)
{
    static struct subject subject;
    struct tracer_job *job = malloc(sizeof(*job));
    static const struct compare_ray rays[RAYS];
    struct compare_answer *answers = calloc(RAYS, sizeof(*answers));
    assert_true(job && answers);
    subject_ring(&subject);
    *job = (struct tracer_job){.queue = queue,
                               .input_count = 1,
                               .inputs = &subject.input,
                               .ray_count = RAYS,
                               .rays = rays,
                               .answers = answers};
    waits[0] = first;
    waits[1] = second;
    const VkResult result = tracer_run(tracer, job);
    memset(job, 0xff, sizeof(*job));
    free(job);
    free(answers);
    return result;
}

/* The layer finds nothing in what the tracer calls for a build and an update. */
TEST(test_calls_are_valid)
{
    static struct subject source, update;
    static struct compare_answer answers[RAYS];
    static const struct compare_ray rays[RAYS];
    subject_ring(&source);
    subject_ring(&update);
    source.parameters.info.flags = update.parameters.info.flags =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    const struct compare_input inputs[] = {source.input, update.input};
    open_tracer_with(&(struct instance_settings){.hazards = "true"});
    GET(tracer_run(tracer, &(struct tracer_job){.queue = queue,
                                                .input_count = 2,
                                                .inputs = inputs,
                                                .ray_count = RAYS,
                                                .rays = rays,
                                                .answers = answers}));
    tracer_destroy(tracer);
    messages_expect_none(&instance.messages);
    close_tracer();
}

TEST_BETWEEN(test_queue_in_use, open_tracer, close_tracer)
{
    may_submit = false;
    assert_int_equal(run(VK_SUCCESS, VK_SUCCESS), VK_NOT_READY);
    assert_int_equal(submissions + wait_count, 0);
    may_submit = true;
    assert_int_equal(run(VK_SUCCESS, VK_SUCCESS), VK_SUCCESS);
    assert_int_equal(submissions, wait_count);
    tracer_destroy(tracer);
}

/* What the device may still use is kept, and destroyed when a wait succeeds; else the device takes
 * the objects with it. */
static const struct ending {
    const char *test;
    VkResult first, second; /* of the waits */
    bool is_kept, is_left;  /* after the first wait; at the end, too */
} endings[] = {
    {"test_timeout", VK_TIMEOUT, VK_SUCCESS, true, false},
    {"test_failed_wait", VK_ERROR_OUT_OF_HOST_MEMORY, VK_SUCCESS, true, false},
    {"test_timeout_at_the_end", VK_TIMEOUT, VK_TIMEOUT, true, true},
    {"test_failed_wait_at_the_end", VK_TIMEOUT, VK_ERROR_OUT_OF_DEVICE_MEMORY, true, true},
    {"test_lost_device", VK_ERROR_DEVICE_LOST, VK_SUCCESS, false, false}, /* which uses nothing */
};

TEST_OF_ROWS_BETWEEN(test_ending, endings, const struct ending *row, open_tracer, close_tracer)
{
    const uint64_t destroyed = count_destroyed();
    assert_int_equal(run(row->first, row->second), row->is_kept ? VK_TIMEOUT : row->first);
    assert_int_equal(count_destroyed() == destroyed, row->is_kept);
    tracer_destroy(tracer);
    assert_int_equal(count_destroyed() == destroyed, row->is_left);
    assert_int_equal(platform.null_driver.allocated() == allocated_before, !row->is_left);
    assert_int_equal(wait_count, row->is_kept ? 2 : 1);
}

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}
