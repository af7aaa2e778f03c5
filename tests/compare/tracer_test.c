/* SPDX-License-Identifier: Apache-2.0 */
/* What the tracer does when the driver does not say that a submission is complete: it destroys
 * nothing that the device may still use. On the null driver, whose waits this test answers. */
#include "layer/compare/tracer.h"

#include <stdlib.h>
#include <string.h>

#include "subject.h"
#include "tests/snapshots/scene.h"

enum { RAYS = 4, WAITS_MAX = 3 };

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

static bool begin_submission(void *queues, VkQueue queue)
{
    assert_ptr_equal(queue, fixture.queue);
    return may_submit;
}

static void end_submission(void *queues)
{
    ++*(uint32_t *)queues;
}

static void open_tracer_with(const struct instance_settings *settings)
{
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .rayQuery = VK_TRUE);
    fixture_open_with(&fixture, &platform, settings, &query, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    fixture.instance.vk.GetPhysicalDeviceMemoryProperties(fixture.instance.physical, &memory);
    vk = fixture.vk;
    device = (struct compare_device){.handle = fixture.device,
                                     .vk = &vk,
                                     .memory = &memory,
                                     .scratch_alignment = 256,
                                     .begin_submission = begin_submission,
                                     .end_submission = end_submission,
                                     .queues = &submissions,
                                     .has_queries = true};
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
    fixture_close(&fixture);
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
    *job = (struct tracer_job){.queue = fixture.queue,
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
    GET(tracer_run(tracer, &(struct tracer_job){.queue = fixture.queue,
                                                .input_count = 2,
                                                .inputs = inputs,
                                                .ray_count = RAYS,
                                                .rays = rays,
                                                .answers = answers}));
    tracer_destroy(tracer);
    messages_expect_none(&fixture.instance.messages);
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

static void expect_kept(VkResult result)
{
    const uint64_t destroyed = count_destroyed();
    assert_int_equal(run(result, VK_SUCCESS), VK_TIMEOUT);
    assert_int_equal(count_destroyed(), destroyed);
    tracer_destroy(tracer);
    assert_int_equal(wait_count, 2);
    assert_int_equal(platform.null_driver.allocated(), allocated_before);
}

TEST_BETWEEN(test_timeout, open_tracer, close_tracer)
{
    expect_kept(VK_TIMEOUT);
}

TEST_BETWEEN(test_failed_wait, open_tracer, close_tracer)
{
    expect_kept(VK_ERROR_OUT_OF_HOST_MEMORY);
}

/* The device takes the objects with it. */
static void expect_left(VkResult result)
{
    assert_int_equal(run(VK_TIMEOUT, result), VK_TIMEOUT);
    const uint64_t destroyed = count_destroyed();
    tracer_destroy(tracer);
    assert_int_equal(count_destroyed(), destroyed);
}

TEST_BETWEEN(test_timeout_at_the_end, open_tracer, close_tracer)
{
    expect_left(VK_TIMEOUT);
}

TEST_BETWEEN(test_failed_wait_at_the_end, open_tracer, close_tracer)
{
    expect_left(VK_ERROR_OUT_OF_DEVICE_MEMORY);
}

/* A lost device uses nothing. */
TEST_BETWEEN(test_lost_device, open_tracer, close_tracer)
{
    assert_int_equal(run(VK_ERROR_DEVICE_LOST, VK_SUCCESS), VK_ERROR_DEVICE_LOST);
    assert_int_equal(platform.null_driver.allocated(), allocated_before);
    tracer_destroy(tracer);
    assert_int_equal(wait_count, 1);
}
