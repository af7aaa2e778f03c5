/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as a consumer of batches: when it sends its warnings, and what it does with a copy
 * of results whose end the driver does not show. If the order is unknown, it gets executions while
 * the queues are locked, and a callback that submits would wait for its own thread. The test plays
 * the order, the playback and the driver. */
#include "layer/cpu/overlay.h"

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/executions.h"
#include "layer/snapshots/snapshots.h"
#include "tests/unit/unit_test.h"
#include "vulkan_commands.h"

static struct layer_instance own_instance;
static struct layer_device own_device;
static struct cpu_overlay overlay;
static struct snapshots own_snapshots;
static struct cpu_device cpu;
static uint32_t lost; /* builds without memory, not reported yet */
static uint32_t runs, warnings, submissions;

/* ---- what results.c calls */

uint32_t cpu_playback_take_failed(struct cpu_playback *playback)
{
    uint32_t count = lost;
    lost = 0;
    return count;
}

void cpu_playback_run(struct cpu_playback *playback, struct execution *execution,
                      struct timestamp timestamp)
{
    runs++;
}

static bool has_results;
static unsigned char chunk_bytes[1];

bool cpu_playback_has_results(struct cpu_playback *playback)
{
    return has_results;
}

/* Writes one result of a byte. */
void cpu_playback_deliver(struct cpu_playback *playback, const struct cpu_delivery *delivery)
{
    static const VkBufferCopy region = {.size = 1};
    struct ticket ticket = {.references = 1};
    has_results = !delivery->write(delivery->user, &(struct result_bytes){.ticket = &ticket,
                                                                          .bytes = chunk_bytes,
                                                                          .size = 1,
                                                                          .regions = &region,
                                                                          .region_count = 1});
}

void cpu_playback_forget_buffer(struct cpu_playback *playback, VkBuffer buffer) {}

void reporter_warn(struct reporter *reporter, const char *line)
{
    warnings++;
}

void warn_lack_of_copies(const struct layer_device *of_device)
{
    warnings++;
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    return NULL;
}

void execution_order_host_clock(struct execution_order *order, struct execution_clock *clock) {}

bool snapshots_queue_family(struct snapshots *snapshots, VkQueue queue, uint32_t *family)
{
    *family = 0;
    return true;
}

static bool may_submit, is_submitting; /* the layer, to the queue */

bool snapshots_begin_own_submission(struct snapshots *snapshots, VkQueue queue)
{
    is_submitting = may_submit;
    return may_submit;
}

void snapshots_end_own_submission(struct snapshots *snapshots)
{
    assert_true(is_submitting);
    is_submitting = false;
}

static bool host_can_write;
static enum tristate buffer_alive;

bool cpu_write_by_host(const struct layer_device *of_device, const struct result_bytes *result)
{
    return host_can_write;
}

void resources_look_up_buffer(struct resources *resources, VkBuffer handle,
                              struct buffer_facts *facts)
{
    *facts = (struct buffer_facts){.alive = buffer_alive};
}

static struct staging_chunk own_chunk = {.chunk = {.bytes = chunk_bytes, .size = 1}};
static uint32_t given_back, left;

VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk)
{
    *chunk = &own_chunk;
    return VK_SUCCESS;
}

void staging_give_back(struct staging *staging, struct staging_chunk *chunk)
{
    given_back++;
}

void staging_leave(struct staging *staging, struct staging_chunk *chunk)
{
    left++;
}

/* ---- the driver: what it destroys, and what waits return */

static VkuDeviceDispatchTable driver;
#define PLAYED_COMMANDS driver

static uint32_t destroyed;
static VkResult waits[2];
static uint32_t wait_count;

PLAYED(CreateFence)
{
    *pFence = (VkFence)(uintptr_t)1;
    return VK_SUCCESS;
}

PLAYED(DestroyFence)
{
    destroyed++;
}

PLAYED(CreateCommandPool)
{
    *pCommandPool = (VkCommandPool)(uintptr_t)2;
    return VK_SUCCESS;
}

PLAYED(DestroyCommandPool)
{
    destroyed++;
}

PLAYED(AllocateCommandBuffers)
{
    return VK_SUCCESS;
}

PLAYED(BeginCommandBuffer)
{
    return VK_SUCCESS;
}

PLAYED(EndCommandBuffer)
{
    return VK_SUCCESS;
}

PLAYED(CmdCopyBuffer) {}

PLAYED(CmdPipelineBarrier) {}

PLAYED(QueueSubmit)
{
    assert_true(is_submitting);
    submissions++;
    return VK_SUCCESS;
}

PLAYED(WaitForFences)
{
    assert_false(is_submitting);
    assert_true(wait_count < 2);
    return waits[wait_count++];
}

/* ---- tests */

/* Everything that the consumer warns of. */
static struct batch_consumer set_up(void)
{
    own_instance = (struct layer_instance){0};
    overlay = (struct cpu_overlay){.device = &cpu};
    own_device.instance = &own_instance;
    own_device.cpu = &overlay;
    lost = 1;
    atomic_store(&cpu.lacks_copies, true);
    atomic_store(&cpu.overwritten, OCCURRED);
    overlay.down = driver;
    own_device.snapshots = &own_snapshots;
    may_submit = true;
    host_can_write = false;
    buffer_alive = YES;
    runs = warnings = submissions = destroyed = wait_count = given_back = left = 0;
    return cpu_overlay_consumer(&own_device);
}

TEST(test_warnings_follow_a_run_in_order)
{
    struct execution execution;
    struct submitted_commands commands = {.execution = &execution};
    struct order_batch batch = {.commands = &commands, .command_count = 1};
    const struct batch_consumer consumer = set_up();
    consumer.run(consumer.user, &batch);
    assert_int_equal(runs, 1);
    assert_int_equal(warnings, 3);
}

TEST(test_warnings_wait_while_queues_are_locked)
{
    struct execution execution;
    const struct batch_consumer consumer = set_up();
    consumer.run_unordered(consumer.user, &execution);
    assert_int_equal(runs, 1);
    assert_int_equal(warnings, 0);
    consumer.deliver(consumer.user);
    assert_int_equal(warnings, 3);
}

/* A result is copied; its wait has a result, and so has the wait when the device is destroyed. */
static void write_result(VkResult first, VkResult last)
{
    const struct batch_consumer consumer = set_up();
    waits[0] = first;
    waits[1] = last;
    has_results = true;
    consumer.deliver(consumer.user);
}

TEST(test_copy_of_results)
{
    static const VkResult ends[] = {VK_SUCCESS, VK_ERROR_DEVICE_LOST};
    for (size_t i = 0; i < sizeof(ends) / sizeof(ends[0]); i++) {
        write_result(ends[i], VK_SUCCESS);
        assert_int_equal(destroyed, 2);
        assert_int_equal(given_back, 1);
        cpu_overlay_end_transfers(&overlay);
        assert_int_equal(wait_count, 1);
    }
}

/* Until the layer may use the queue, the result stays. */
TEST(test_copy_of_results_while_the_queue_is_in_use)
{
    const struct batch_consumer consumer = set_up();
    waits[0] = VK_SUCCESS;
    has_results = true;
    may_submit = false;
    consumer.deliver(consumer.user);
    assert_int_equal(submissions + wait_count, 0);
    assert_true(has_results);
    assert_int_equal(given_back, 1);
    may_submit = true;
    consumer.deliver(consumer.user);
    assert_int_equal(submissions, 1);
    assert_false(has_results);
}

TEST(test_results_without_a_copy)
{
    for (int i = 0; i < 2; i++) {
        const struct batch_consumer consumer = set_up();
        host_can_write = i;
        buffer_alive = i ? YES : NO;
        has_results = true;
        consumer.deliver(consumer.user);
        assert_int_equal(submissions, 0);
        assert_false(has_results);
    }
}

/* The device may still execute the copy: nothing is freed before it has certainly ended. */
TEST(test_copy_of_results_that_may_be_pending)
{
    static const VkResult ends[] = {VK_SUCCESS, VK_ERROR_DEVICE_LOST, VK_TIMEOUT,
                                    VK_ERROR_OUT_OF_HOST_MEMORY};
    for (size_t i = 0; i < sizeof(ends) / sizeof(ends[0]); i++) {
        const bool has_ended = i < 2;
        write_result(VK_ERROR_OUT_OF_DEVICE_MEMORY, ends[i]);
        assert_int_equal(destroyed, 0);
        assert_int_equal(given_back, 0);
        cpu_overlay_end_transfers(&overlay);
        assert_int_equal(destroyed, has_ended ? 2 : 0);
        assert_int_equal(given_back, has_ended);
        assert_int_equal(left, !has_ended);
        assert_null(overlay.unfinished);
    }
}
