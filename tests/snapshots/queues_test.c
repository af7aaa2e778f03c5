/* SPDX-License-Identifier: Apache-2.0 */
/* When the layer may submit to a queue: never while a call of the application uses the queue. */
#include "layer/snapshots/snapshots.h"

#include "observers.h"
#include "tests/unit/unit_test.h"

static struct layer_device device;
static struct snapshots snapshots;
static const VkQueue first = (VkQueue)(uintptr_t)1, second = (VkQueue)(uintptr_t)2;

static void set_up(void)
{
    snapshots = (struct snapshots){.device = &device, .submits_itself = true};
    device.snapshots = &snapshots;
    pthread_mutex_init(&snapshots.queue_lock, NULL);
    snapshots_note_queue(&device, first, 3);
    snapshots_note_queue(&device, second, 4);
    snapshots_note_queue(&device, second, 4);
}

static void tear_down(void)
{
    snapshots_release_queues(&snapshots);
    pthread_mutex_destroy(&snapshots.queue_lock);
}

static bool may_submit(VkQueue queue)
{
    bool may = snapshots_begin_own_submission(&snapshots, queue);
    if (may)
        snapshots_end_own_submission(&snapshots);
    return may;
}

TEST_BETWEEN(test_families, set_up, tear_down)
{
    uint32_t family = 0;
    assert_true(snapshots_queue_family(&snapshots, first, &family));
    assert_int_equal(family, 3);
    assert_true(snapshots_queue_family(&snapshots, second, &family));
    assert_int_equal(family, 4);
    assert_false(snapshots_queue_family(&snapshots, (VkQueue)(uintptr_t)5, &family));
}

TEST_BETWEEN(test_queue_in_use, set_up, tear_down)
{
    assert_true(may_submit(first));
    snapshots_enter_queue(&device, first);
    snapshots_enter_queue(&device, first);
    snapshots_leave_queue(&device, first);
    assert_false(may_submit(first));
    assert_true(may_submit(second));
    snapshots_leave_queue(&device, first);
    assert_true(may_submit(first));
}

TEST_BETWEEN(test_all_queues_in_use, set_up, tear_down)
{
    snapshots_enter_all_queues(&device);
    assert_false(may_submit(first));
    assert_false(may_submit(second));
    snapshots_leave_all_queues(&device);
    assert_true(may_submit(first));
}

/* Nothing is known of its family. */
TEST_BETWEEN(test_unknown_queue, set_up, tear_down)
{
    const VkQueue unknown = (VkQueue)(uintptr_t)5;
    snapshots_enter_queue(&device, unknown);
    snapshots_leave_queue(&device, unknown);
    assert_false(may_submit(unknown));
}
