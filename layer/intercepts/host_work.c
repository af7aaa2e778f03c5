/* SPDX-License-Identifier: Apache-2.0 */
/* Access to journals: of command buffers, and of host commands. */
#include "layer/intercepts/intercepts.h"

#include "layer/hazards/executed/host_writes.h"
#include "observers.h"

uint64_t layer_accel_id(const struct layer_device *device, VkAccelerationStructureKHR handle)
{
    return resources_find_id(device->resources, RESOURCE_ACCEL, handle_number(handle));
}

VkDeviceSize layer_bytes_at(const struct layer_device *device, VkDeviceAddress address)
{
    struct address_facts facts;
    resources_look_up_address(device->resources, address, &facts);
    return facts.status == ADDRESS_IN_BUFFER ? facts.bytes_left : 0;
}

struct command_buffer *layer_find_recording(const struct layer_device *device,
                                            VkCommandBuffer handle)
{
    if (device->level < LEVEL_EXECUTION)
        return NULL;
    struct command_buffer *command_buffer = command_buffers_find(device->command_buffers, handle);
    return command_buffer && command_buffer->journal ? command_buffer : NULL;
}

bool layer_record(struct layer_device *device, VkCommandBuffer handle,
                  struct journal_entry *entries, uint32_t count)
{
    struct build_call call;
    build_call_start_recorded(&call, device, (enum build_command)entries->command, handle);
    if (!call.journal)
        return false;
    const uint32_t origin = build_call_origin(&call);
    for (uint32_t i = 0; i < count; i++) {
        entries[i].origin = origin;
        if (entries[i].dst_id || (!journal_entry_writes(&entries[i]) && entries[i].src_id))
            journal_add(call.journal, &entries[i]);
    }
    build_call_settle_journal(&call);
    return call.skip;
}

bool layer_run_host_command(struct layer_device *device, struct journal *journal)
{
    struct submission *submission =
        submission_begin(device->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    if (!submission) {
        journal_release(journal);
        return false;
    }
    submission_add_batch(submission);
    submission_add_work(submission, journal);
    submission_prepare(submission);
    submission_finish(submission, VK_SUCCESS);
    return true;
}

/* ---- host commands from begin to end */

/* Checks the level, because backend cpu has an order at each level. */
static bool tracks_work(const struct layer_device *device)
{
    return device->level >= LEVEL_EXECUTION;
}

static _Thread_local struct journal *next_journal;

void host_work_set_journal(struct journal *journal)
{
    journal_release(next_journal);
    next_journal = journal;
}

static struct journal *take_journal(const struct layer_device *device)
{
    struct journal *journal = device->finds_hazards ? next_journal : NULL;
    if (!journal)
        return journal_create(VK_NULL_HANDLE);
    next_journal = NULL;
    return journal;
}

struct host_work host_work_begin(struct layer_device *device)
{
    struct host_work work = {.device = device};
    if (tracks_work(device))
        work.journal = take_journal(device);
    if (device->finds_hazards)
        host_work_set_journal(NULL);
    if (work.journal)
        work.journal->destroy_count = resources_destroy_count(device->resources);
    return work;
}

void host_work_add(struct host_work *work, struct journal_entry *entry)
{
    if (!work->journal)
        return;
    entry->origin = journal_note_origin(work->journal, NULL, call_site_of_call(work->device));
    journal_add(work->journal, entry);
}

/* Without a journal the order assumes that the work may write anything. */
bool host_work_prepare(struct host_work *work, bool skip)
{
    host_writes_look(work->device->host_writes);
    if (tracks_work(work->device))
        work->submission = submission_begin(work->device->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    if (!work->submission) {
        journal_release(work->journal);
        return skip;
    }
    submission_set_origin(work->submission, &(struct submission_origin){0},
                          resources_destroy_count(work->device->resources));
    submission_add_batch(work->submission);
    submission_add_work(work->submission, work->journal);
    if (skip)
        submission_set_skip(work->submission);
    if (!submission_prepare(work->submission))
        return false;
    submission_finish(work->submission, VK_ERROR_VALIDATION_FAILED_EXT);
    work->submission = NULL;
    return true;
}

void host_work_end(void *submission, VkResult result)
{
    submission_finish_silently(submission, result);
}

/* Backend cpu refuses what its builder cannot use. If no rule says why, a warning says that much.
 */
static void report_refusal(const struct layer_device *device, VkResult result, bool has_report)
{
    if (device->cpu && result == VK_ERROR_VALIDATION_FAILED_EXT && !has_report)
        reporter_warn(
            device->instance->reporter,
            "assay_validation.backend = cpu refuses this command of the host, which "
            "returns VK_ERROR_VALIDATION_FAILED_EXT, and leaves the structures unchanged. "
            "A structure is smaller than what is written to it, serialized data is not "
            "whole or of another driver, or an array of a build is not readable, or "
            "names what does not exist.");
}

/* Ends the work of an operation that has completed. */
static void complete_operation(struct layer_device *device, VkDeferredOperationKHR operation,
                               uint64_t ticket, VkResult result)
{
    const bool has_report = deferred_operations_has_report(device->deferred, operation);
    if (result == VK_NOT_READY ||
        !deferred_operations_complete(device->deferred, operation, ticket, result))
        return;
    report_refusal(device, result, has_report);
    execution_order_run(device->order);
}

/* Queries an operation that has work, and ends the work if the operation is complete. */
static void poll_operation(struct layer_device *device, VkDeferredOperationKHR operation)
{
    uint64_t ticket = deferred_operations_ticket(device->deferred, operation);
    if (ticket)
        complete_operation(device, operation, ticket,
                           device->vk.GetDeferredOperationResultKHR(device->handle, operation));
}

/* Other threads may complete an operation before this thread has recorded its work. A command that
 * is not checked begins no call, so the end of each one does. */
VkResult host_work_finish(struct host_work *work, VkDeferredOperationKHR operation, VkResult result)
{
    struct layer_device *device = work->device;
    const bool has_report = reporter_has_sent();
    report_refusal(device, result, has_report);
    reporter_begin_call();
    if (!work->submission)
        return result;
    if (result == VK_OPERATION_DEFERRED_KHR &&
        deferred_operations_defer(device->deferred, operation, work->submission)) {
        if (has_report)
            deferred_operations_note_report(device->deferred, operation);
        poll_operation(device, operation);
    } else {
        submission_finish(work->submission,
                          result == VK_OPERATION_DEFERRED_KHR ? VK_ERROR_UNKNOWN : result);
    }
    return result;
}

/* ---- deferred operations, which execute host commands */

struct deferred_operation_facts host_work_operation_facts(const struct layer_device *device,
                                                          VkDeferredOperationKHR operation)
{
    struct deferred_operation_facts facts = {.handle = operation};
    if (!operation)
        return facts;
    facts.alive = deferred_operations_has(device->deferred, operation);
    if (facts.alive == NO)
        facts.of_another_device = layer_other_device_has_operation(device, operation);
    if (facts.alive == YES)
        facts.complete =
            device->vk.GetDeferredOperationResultKHR(device->handle, operation) == VK_NOT_READY
                ? NO
                : YES;
    return facts;
}

void note_operation(struct layer_device *device, VkDeferredOperationKHR operation)
{
    deferred_operations_add(device->deferred, operation);
}

void forget_operation(struct layer_device *device, VkDeferredOperationKHR operation)
{
    if (!operation)
        return;
    deferred_operations_remove(device->deferred, operation);
    execution_order_run(device->order);
    object_names_end(device->names, VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR, handle_number(operation),
                     0);
}

/* A result that is available belongs to the work that the operation had before the call. */
uint64_t find_operation_ticket(struct layer_device *device, VkDeferredOperationKHR operation)
{
    return deferred_operations_ticket(device->deferred, operation);
}

void note_operation_result(struct layer_device *device, VkDeferredOperationKHR operation,
                           uint64_t ticket, VkResult result)
{
    complete_operation(device, operation, ticket, result);
}

/* A join does not return the operation's result. */
void note_join(struct layer_device *device, VkDeferredOperationKHR operation)
{
    poll_operation(device, operation);
}
