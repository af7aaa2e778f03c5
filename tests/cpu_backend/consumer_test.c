/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu as a consumer of snapshots: when it sends its warnings. If the order is unknown, it
 * gets executions while the queues are locked, and a callback that submits would wait for its own
 * thread. The test plays the snapshots and the playback. */
#include "layer/cpu/results.h"

#include "layer/snapshots/copies/staging.h"
#include "layer/snapshots/coverage_warnings.h"
#include "layer/snapshots/snapshots.h"
#include "layer/snapshots/tickets.h"
#include "tests/state/unit_test.h"

static struct layer_instance instance;
static struct layer_device device;
static struct cpu_overlay overlay;
static struct cpu_device cpu;
static uint32_t lost; /* builds without memory, not reported yet */
static uint32_t runs, warnings;

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

void cpu_playback_deliver(struct cpu_playback *playback, const struct cpu_delivery *delivery) {}

bool cpu_playback_has_results(struct cpu_playback *playback)
{
    return false;
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

/* No result is written here. */

struct layer_device *layer_find_device(const void *dispatchable)
{
    return NULL;
}

void execution_order_host_clock(struct execution_order *order, struct execution_clock *clock) {}

bool snapshots_queue_family(struct snapshots *snapshots, VkQueue queue, uint32_t *family)
{
    return false;
}

void snapshots_lock_queues(struct snapshots *snapshots) {}

void snapshots_unlock_queues(struct snapshots *snapshots) {}

VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk)
{
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

void staging_give_back(struct staging *staging, struct staging_chunk *chunk) {}

void staging_leave(struct staging *staging, struct staging_chunk *chunk) {}

/* ---- tests */

/* Everything that the consumer warns of. */
static const struct snapshots_consumer *set_up(void)
{
    instance = (struct layer_instance){0};
    overlay = (struct cpu_overlay){.device = &cpu};
    device.instance = &instance;
    device.cpu = &overlay;
    lost = 1;
    atomic_store(&cpu.lacks_copies, true);
    atomic_store(&cpu.overwritten, OVERWRITTEN_ONCE);
    runs = warnings = 0;
    return cpu_overlay_consumer(&device);
}

TEST(test_warnings_follow_a_run_in_order)
{
    static const struct batch_run batch;
    const struct snapshots_consumer *consumer = set_up();
    consumer->run(consumer->user, &(struct submitted_execution){.batch = &batch});
    assert_int_equal(runs, 1);
    assert_int_equal(warnings, 3);
}

TEST(test_warnings_wait_while_queues_are_locked)
{
    const struct snapshots_consumer *consumer = set_up();
    consumer->run(consumer->user, &(struct submitted_execution){.timestamp = timestamp_never()});
    assert_int_equal(runs, 1);
    assert_int_equal(warnings, 0);
    consumer->deliver(consumer->user);
    assert_int_equal(warnings, 3);
}
