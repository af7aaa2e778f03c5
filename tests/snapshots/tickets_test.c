/* SPDX-License-Identifier: Apache-2.0 */
/* Tickets, whose fences this test plays: when they count as pending, and that no fence is destroyed
 * or used again that the device may use. */
#include "layer/snapshots/executions.h"

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
