/* SPDX-License-Identifier: Apache-2.0 */
/* Access to journals: of command buffers, and of host commands. */
#include "layer/intercepts/journal_access.h"

#include "layer/intercepts/build_call.h"

uint64_t layer_accel_id(const struct layer_device *device, VkAccelerationStructureKHR handle)
{
    return resources_find_id(device->resources, RESOURCE_ACCEL, (uint64_t)(uintptr_t)handle);
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
        bool writes = JOURNAL_WRITES & JOURNAL_BIT(entries[i].kind);
        entries[i].origin = origin;
        if (entries[i].dst_id || (!writes && entries[i].src_id))
            journal_add(call.journal, &entries[i]);
    }
    build_call_settle_journal(&call);
    return call.skip;
}

void layer_run_host_command(struct layer_device *device, struct journal *journal)
{
    struct submission *submission =
        submission_begin(device->order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    if (!submission) {
        journal_release(journal);
        return;
    }
    submission_add_batch(submission);
    submission_add_work(submission, journal);
    submission_prepare(submission);
    submission_finish(submission, VK_SUCCESS);
}
