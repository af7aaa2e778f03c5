/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/snapshots/size_queries.h"

#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/array.h"

static const VkQueryType size_type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;

/* By the sizes that they were created with. */
static bool may_overlap(const struct accel_facts *a, const struct accel_facts *b)
{
    return a->memory && a->memory == b->memory && a->begin < b->begin + b->size &&
           b->begin < a->begin + a->size;
}

bool size_query_is_needed(const struct layer_device *device,
                          const VkCopyAccelerationStructureInfoKHR *info)
{
    struct accel_facts dst, src;
    if (info->mode != VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR)
        return false;
    resources_look_up_accel(device->resources, info->dst, &dst);
    resources_look_up_accel(device->resources, info->src, &src);
    return src.backed == YES && src.details_known && dst.details_known &&
           (dst.size < src.size || may_overlap(&dst, &src));
}

/* Whether the command buffer has built the source so that the query would be invalid. */
static bool source_is_wrong(const struct recorder *recorder, const struct journal_entry *copy)
{
    const struct structure *source =
        structures_find(&recorder->command_buffer->known, copy->src_id);
    return source &&
           (source->built.state != BUILT_BEFORE ||
            !(source->built.flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR));
}

/* Executions at once would use the same query. A query that is active may count commands of the
 * layer's own. */
static bool may_query(const struct recorder *recorder, const struct journal_entry *copy)
{
    return copy && !recorder->cannot_inject && !recorder->recording->executes_at_once &&
           !recorder->recording->compute.queries && !source_is_wrong(recorder, copy);
}

/* Takes the next query of the recording, from a new pool if the last one is used up. Returns false
 * without memory. */
static bool take_query(const struct recorder *recorder, struct journal_read *read)
{
    struct size_pools *pools = &recorder->recording->size_pools;
    const VkQueryPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = size_type,
        .queryCount = SIZE_QUERIES,
    };
    const struct layer_device *device = recorder->device;
    const uint32_t query = pools->used % SIZE_QUERIES;
    if (!query) {
        if (!ARRAY_HAS_ROOM(pools->items, pools->count, pools->capacity) ||
            device->vk.CreateQueryPool(device->handle, &info, NULL, &pools->items[pools->count]) !=
                VK_SUCCESS)
            return false;
        pools->count++;
    }
    pools->used++;
    read->size_pool = pools->items[pools->count - 1];
    read->size_query = query;
    return true;
}

/* The application orders the copy's read of src, and the query reads src at the same stage. Backend
 * cpu would keep the tree of src for the query, and so the recording, which owns the query. */
void snapshots_query_size(struct layer_device *device, VkCommandBuffer handle,
                          const VkCopyAccelerationStructureInfoKHR *info)
{
    struct recorder recorder;
    if (!device->input_checks || device->cpu || !size_query_is_needed(device, info) ||
        !recorder_begin_other(&recorder, handle))
        return;
    struct journal_entry *copy = journal_find_copy_of_call(recorder.recording->journal);
    if (!may_query(&recorder, copy) || !take_query(&recorder, &copy->read))
        return;
    recorder.recording->has_commands = true;
    device->vk.CmdResetQueryPool(handle, copy->read.size_pool, copy->read.size_query, 1);
    device->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        handle, 1, &info->src, size_type, copy->read.size_pool, copy->read.size_query);
}

/* Another thread may submit the command buffer again meanwhile, so the result is used only if this
 * execution is still the last one. */
VkDeviceSize size_query_read(const struct layer_device *device, const struct journal *journal,
                             const struct journal_entry *entry, const struct ticket *ticket)
{
    uint64_t found[2] = {0}; /* the size, and whether it is available */
    const VkResult result = device->vk.GetQueryPoolResults(
        device->handle, entry->read.size_pool, entry->read.size_query, 1, sizeof(found), found,
        sizeof(found), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    struct execution *latest = recording_share_latest(journal->work);
    const bool is_own = latest && latest->ticket == ticket;
    execution_release(latest);
    return result == VK_SUCCESS && found[1] && is_own ? found[0] : 0;
}
