/* SPDX-License-Identifier: Apache-2.0 */
/* The layer's own submissions. Tickets, whose fences this test plays: when they count as pending,
 * and that no fence is destroyed or used again that the device may use. Queues: the layer never
 * submits to one while a call of the application uses it. */
#include "layer/snapshots/executions.h"

#include "observers.h"
#include "src/snapshots/ticket.h"
#include "tests/unit/unit_test.h"
#include "vulkan_commands.h"

enum { FENCES = 8 };

/* The state of a fence on the device. */
static struct fence {
    bool exists, is_pending, is_signaled;
} fences[FENCES];
static uint32_t created;
static VkResult status, submit_result, reset_result; /* of the calls; VK_SUCCESS: by the fence */
static uint64_t longest_wait;
static struct snapshots snapshots;
static struct layer_device own_device;

static struct fence *fence_of(VkFence handle)
{
    struct fence *fence = &fences[(uintptr_t)handle - 1];
    assert_true(fence->exists);
    return fence;
}

static VkuDeviceDispatchTable driver;
#define PLAYED_COMMANDS driver

PLAYED(CreateFence)
{
    assert_true(created < FENCES);
    fences[created] = (struct fence){.exists = true};
    *pFence = (VkFence)(uintptr_t)++created;
    return VK_SUCCESS;
}

PLAYED(DestroyFence)
{
    assert_false(fence_of(fence)->is_pending && status != VK_ERROR_DEVICE_LOST);
    fence_of(fence)->exists = false;
}

PLAYED(GetFenceStatus)
{
    if (status != VK_SUCCESS)
        return status;
    return fence_of(fence)->is_signaled ? VK_SUCCESS : VK_NOT_READY;
}

PLAYED(WaitForFences)
{
    const VkResult result = driver.GetFenceStatus(device, pFences[0]);
    longest_wait = timeout > longest_wait ? timeout : longest_wait;
    return result == VK_NOT_READY ? VK_TIMEOUT : result;
}

PLAYED(ResetFences)
{
    assert_false(fence_of(pFences[0])->is_pending);
    if (reset_result == VK_SUCCESS)
        fence_of(pFences[0])->is_signaled = false;
    return reset_result;
}

PLAYED(QueueSubmit)
{
    assert_false(fence_of(fence)->is_signaled || fence_of(fence)->is_pending);
    fence_of(fence)->is_pending = submit_result == VK_SUCCESS;
    return submit_result;
}

static void signal_fence(uint32_t i)
{
    fences[i].is_pending = false;
    fences[i].is_signaled = true;
}

static void set_up(void)
{
    snapshots = (struct snapshots){.device = &own_device};
    snapshots.next = driver;
    pthread_mutex_init(&snapshots.tickets_lock, NULL);
    created = 0;
    longest_wait = 0;
    status = submit_result = reset_result = VK_SUCCESS;
}

static uint32_t count_fences(void)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < created; i++)
        count += fences[i].exists;
    return count;
}

static void tear_down(void)
{
    tickets_destroy(&snapshots);
    pthread_mutex_destroy(&snapshots.tickets_lock);
}

static VkResult result_of(struct ticket *ticket)
{
    return ticket->wait(ticket, 0);
}

static struct ticket *submitted(void)
{
    struct ticket *ticket = ticket_create(&snapshots, VK_NULL_HANDLE);
    assert_int_equal(ticket_submit(ticket), VK_SUCCESS);
    return ticket;
}

/* Other threads may find it before it is submitted: the device may execute its batches by then. */
TEST_BETWEEN(test_pending_from_the_beginning, set_up, tear_down)
{
    struct ticket *ticket = ticket_create(&snapshots, VK_NULL_HANDLE);
    assert_int_equal(result_of(ticket), VK_TIMEOUT);
    assert_int_equal(ticket_submit(ticket), VK_SUCCESS);
    assert_int_equal(result_of(ticket), VK_TIMEOUT);
    signal_fence(0);
    assert_int_equal(result_of(ticket), VK_SUCCESS);
    ticket_release(ticket);
}

TEST_BETWEEN(test_not_submitted, set_up, tear_down)
{
    struct ticket *ticket = ticket_create(&snapshots, VK_NULL_HANDLE);
    submit_result = VK_ERROR_OUT_OF_HOST_MEMORY;
    assert_int_equal(ticket_submit(ticket), VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(result_of(ticket), VK_TIMEOUT);
    ticket_release(ticket);

    ticket = ticket_create(&snapshots, VK_NULL_HANDLE);
    assert_int_equal(result_of(ticket), VK_TIMEOUT);
    ticket_refuse(ticket);
    assert_int_equal(result_of(ticket), VK_ERROR_DEVICE_LOST);
    ticket_release(ticket);
    assert_int_equal(created, 1);
}

TEST_BETWEEN(test_fence_is_used_again, set_up, tear_down)
{
    ticket_release(ticket_create(&snapshots, VK_NULL_HANDLE));
    struct ticket *ticket = submitted();
    signal_fence(0);
    assert_int_equal(result_of(ticket), VK_SUCCESS);
    assert_true(atomic_load(&ticket->is_complete));
    ticket_release(ticket);
    ticket = submitted();
    assert_int_equal(created, 1);
    assert_int_equal(result_of(ticket), VK_TIMEOUT);
    assert_false(atomic_load(&ticket->is_complete));
    signal_fence(0);
    reset_result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    ticket_release(ticket);
    assert_int_equal(count_fences(), 1);
    ticket_release(ticket_create(&snapshots, VK_NULL_HANDLE));
    assert_false(fences[0].exists);
}

/* A query that fails says nothing about the device. */
TEST_BETWEEN(test_failed_status, set_up, tear_down)
{
    struct ticket *ticket = submitted();
    status = VK_ERROR_OUT_OF_HOST_MEMORY;
    assert_false(ticket_result_is_final(result_of(ticket)));
    ticket_release(ticket);
    assert_int_equal(count_fences(), 1);
    ticket_release(ticket_create(&snapshots, VK_NULL_HANDLE));
    assert_int_equal(count_fences(), 2);

    status = VK_SUCCESS;
    signal_fence(0);
    ticket_release(ticket_create(&snapshots, VK_NULL_HANDLE));
    assert_int_equal(created, 2);
    assert_int_equal(count_fences(), 2);
}

TEST_BETWEEN(test_lost_device, set_up, tear_down)
{
    struct ticket *ticket = submitted();
    status = VK_ERROR_DEVICE_LOST;
    assert_true(ticket_result_is_final(result_of(ticket)));
    ticket_release(ticket);
    ticket_release(ticket_create(&snapshots, VK_NULL_HANDLE));
    assert_false(fences[0].exists);
}

/* What the device still uses is left to it, after one wait. */
TEST(test_pending_at_the_end)
{
    static const VkResult ends[] = {VK_SUCCESS, VK_ERROR_OUT_OF_HOST_MEMORY};
    for (size_t i = 0; i < sizeof(ends) / sizeof(ends[0]); i++) {
        set_up();
        struct ticket *first = submitted(), *second = submitted();
        ticket_release(first);
        ticket_release(second);
        status = ends[i];
        tear_down();
        assert_int_equal(count_fences(), 2);
        assert_int_equal(longest_wait, TICKET_GRACE_NANOSECONDS);
    }
}

TEST(test_complete_at_the_end)
{
    set_up();
    struct ticket *first = submitted(), *second = submitted();
    ticket_release(first);
    signal_fence(1);
    ticket_release(second);
    signal_fence(0);
    tear_down();
    assert_int_equal(count_fences(), 0);
}

/* ---- queues */

static const VkQueue first = (VkQueue)(uintptr_t)1, second = (VkQueue)(uintptr_t)2;

static void open_queues(void)
{
    snapshots = (struct snapshots){.device = &own_device, .submits_itself = true};
    own_device.snapshots = &snapshots;
    pthread_mutex_init(&snapshots.queue_lock, NULL);
    snapshots_note_queue(&own_device, first, 3);
    snapshots_note_queue(&own_device, second, 4);
    snapshots_note_queue(&own_device, second, 4);
}

static void close_queues(void)
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

TEST_BETWEEN(test_families, open_queues, close_queues)
{
    uint32_t family = 0;
    assert_true(snapshots_queue_family(&snapshots, first, &family));
    assert_int_equal(family, 3);
    assert_true(snapshots_queue_family(&snapshots, second, &family));
    assert_int_equal(family, 4);
    assert_false(snapshots_queue_family(&snapshots, (VkQueue)(uintptr_t)5, &family));
}

TEST_BETWEEN(test_queue_in_use, open_queues, close_queues)
{
    assert_true(may_submit(first));
    snapshots_enter_queue(&own_device, first);
    snapshots_enter_queue(&own_device, first);
    snapshots_leave_queue(&own_device, first);
    assert_false(may_submit(first));
    assert_true(may_submit(second));
    snapshots_leave_queue(&own_device, first);
    assert_true(may_submit(first));
}

TEST_BETWEEN(test_all_queues_in_use, open_queues, close_queues)
{
    snapshots_enter_all_queues(&own_device);
    assert_false(may_submit(first));
    assert_false(may_submit(second));
    snapshots_leave_all_queues(&own_device);
    assert_true(may_submit(first));
}

/* Nothing is known of its family. */
TEST_BETWEEN(test_unknown_queue, open_queues, close_queues)
{
    const VkQueue unknown = (VkQueue)(uintptr_t)5;
    snapshots_enter_queue(&own_device, unknown);
    snapshots_leave_queue(&own_device, unknown);
    assert_false(may_submit(unknown));
}
