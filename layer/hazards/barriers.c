/* SPDX-License-Identifier: Apache-2.0 */
/* Barriers as entries of a journal (Vulkan specification, Synchronization and Cache Control:
 * Pipeline Barriers, Events, Queue Family Ownership Transfer). What is not understood counts as a
 * full dependency, which can only hide hazards. */
#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"

#include "observers.h"
#include "src/base/chain.h"

/* A group of barriers that is being recorded: those of one command, or of one wait. */
struct group {
    struct hazard_recording *recording;
    struct chunk_place before;
    struct hazard_entry *first; /* has the count */
};

struct dependency barriers_full_dependency(void)
{
    const kind_set all_kinds = (1u << ACCESS_KINDS) - 1;
    return (struct dependency){ALL_SYNC_STAGES, ALL_SYNC_STAGES, all_kinds, all_kinds};
}

static struct group begin_group(struct hazard_recording *recording)
{
    return (struct group){.recording = recording, .before = journal_end(recording->journal)};
}

static struct group begin_wait(struct hazard_recording *recording, VkEvent event)
{
    struct group group = begin_group(recording);
    group.first = hazard_add(recording->journal, HAZARD_WAIT_EVENT);
    if (group.first)
        group.first->object = handle_number(event);
    return group;
}

/* Without memory the journal lacks hazards, and the entries of the group are worth nothing. */
static void add_to_group(struct group *group, const struct hazard_barrier *barrier)
{
    struct journal *journal = group->recording->journal;
    if (unknown_is_set(&journal->accesses_unknown))
        return;
    struct hazard_entry *entry = hazard_add(journal, HAZARD_BARRIER);
    if (!entry) {
        journal_take_back(journal, group->before);
        return;
    }
    entry->dependency = barrier->dependency;
    entry->is_global = barrier->is_global;
    entry->is_acquisition = barrier->is_acquisition;
    entry->bytes = barrier->bytes;
    entry->site = call_site_of_call(group->recording->device);
    if (!group->first)
        group->first = entry;
    group->first->barrier_count++;
}

static void add_global(struct group *group, const struct dependency *dependency)
{
    add_to_group(group, &(struct hazard_barrier){.dependency = *dependency, .is_global = true});
}

/* An execution dependency, and the memory dependency of no bytes. */
static void add_execution(struct group *group, const struct dependency *dependency)
{
    add_to_group(group, &(struct hazard_barrier){.dependency = *dependency});
}

/* ---- buffer barriers */

/* The part of an ownership transfer that a command of a queue family executes. */
enum transfer { NO_TRANSFER, RELEASE, ACQUISITION, UNKNOWN_TRANSFER };

static enum transfer transfer_of(const struct hazard_recording *recording, uint32_t src,
                                 uint32_t dst)
{
    uint32_t count = recording->device->queue_family_count;
    const struct command_pool *pool = recording->command_buffer->pool;
    if (src == dst)
        return NO_TRANSFER;
    if (src >= count || dst >= count || !pool)
        return UNKNOWN_TRANSFER;
    if (pool->queue_family == src)
        return RELEASE;
    return pool->queue_family == dst ? ACQUISITION : UNKNOWN_TRANSFER;
}

static void add_transferable(struct group *group, struct hazard_barrier *barrier, uint32_t src,
                             uint32_t dst)
{
    switch (transfer_of(group->recording, src, dst)) {
    case NO_TRANSFER:
        break;
    case RELEASE:
        barrier->dependency.dst_kinds = 0;
        break;
    case ACQUISITION:
        if (barrier->is_global)
            barrier->dependency = barriers_full_dependency();
        else
            barrier->is_acquisition = true;
        break;
    case UNKNOWN_TRANSFER:
        barrier->dependency = barriers_full_dependency();
        barrier->is_global = true;
    }
    add_to_group(group, barrier);
}

static void find_bytes(const struct hazard_recording *recording, VkBuffer buffer,
                       VkDeviceSize offset, VkDeviceSize size, struct hazard_barrier *barrier)
{
    struct memory_bytes all;
    if (!resources_find_buffer_bytes(recording->device->resources, buffer, &all)) {
        barrier->is_global = true;
        return;
    }
    VkDeviceSize left = offset < all.size ? all.size - offset : 0;
    barrier->bytes = (struct hazard_bytes){.memory = all.memory_id,
                                           .begin = all.begin + offset,
                                           .end = all.begin + offset + (size < left ? size : left)};
}

static void find_addressed_bytes(const struct hazard_recording *recording,
                                 const VkDeviceAddressRangeKHR *range,
                                 struct hazard_barrier *barrier)
{
    struct address_facts facts;
    struct resources *resources = recording->device->resources;
    resources_look_up_address(resources, range->address, &facts);
    barrier->bytes.memory = facts.status == ADDRESS_IN_BUFFER
                                ? hazard_memory_id(recording->journal, resources, facts.memory)
                                : 0;
    barrier->is_global = !barrier->bytes.memory || range->size > facts.bytes_left;
    barrier->bytes.begin = facts.begin;
    barrier->bytes.end = facts.begin + range->size;
}

/* ---- synchronization */

struct dependency barriers_with_flags_3(struct dependency dependency, const void *chain)
{
    const VkMemoryBarrierAccessFlags3KHR *flags =
        chain_find(chain, VK_STRUCTURE_TYPE_MEMORY_BARRIER_ACCESS_FLAGS_3_KHR);
    if (flags && flags->srcAccessMask3)
        dependency.src_kinds = barriers_full_dependency().src_kinds;
    if (flags && flags->dstAccessMask3)
        dependency.dst_kinds = barriers_full_dependency().dst_kinds;
    return dependency;
}

/* All barriers of synchronization2 have these members. */
#define DEPENDENCY_OF(barrier)                                                                     \
    barriers_with_flags_3(dependency_of((barrier)->srcStageMask, (barrier)->srcAccessMask,         \
                                        (barrier)->dstStageMask, (barrier)->dstAccessMask),        \
                          (barrier)->pNext)

static void add_memory_barriers(struct group *group, const VkDependencyInfo *info)
{
    for (uint32_t i = 0; i < info->memoryBarrierCount; i++) {
        const struct dependency dependency = DEPENDENCY_OF(&info->pMemoryBarriers[i]);
        add_global(group, &dependency);
    }
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount; i++) {
        const struct dependency dependency = DEPENDENCY_OF(&info->pImageMemoryBarriers[i]);
        add_execution(group, &dependency);
    }
}

static void add_buffer_barriers(struct group *group, const VkDependencyInfo *info)
{
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount; i++) {
        const VkBufferMemoryBarrier2 *buffer = &info->pBufferMemoryBarriers[i];
        struct hazard_barrier barrier = {.dependency = DEPENDENCY_OF(buffer)};
        find_bytes(group->recording, buffer->buffer, buffer->offset, buffer->size, &barrier);
        add_transferable(group, &barrier, buffer->srcQueueFamilyIndex, buffer->dstQueueFamilyIndex);
    }
}

static void add_range_barriers(struct group *group, const VkMemoryRangeBarriersInfoKHR *info)
{
    for (uint32_t i = 0; i < info->memoryRangeBarrierCount; i++) {
        const VkMemoryRangeBarrierKHR *range = &info->pMemoryRangeBarriers[i];
        struct hazard_barrier barrier = {
            .dependency = barriers_with_flags_3(DEPENDENCY_OF(range), info->pNext)};
        find_addressed_bytes(group->recording, &range->addressRange, &barrier);
        add_transferable(group, &barrier, range->srcQueueFamilyIndex, range->dstQueueFamilyIndex);
    }
}

static void add_extension(struct group *group, const VkBaseInStructure *structure)
{
    const VkTensorMemoryBarrierARM *tensor = (const void *)structure;
    const VkTensorDependencyInfoARM *tensors = (const void *)structure;
    struct dependency dependency = barriers_full_dependency();
    switch ((int)structure->sType) {
    case VK_STRUCTURE_TYPE_MEMORY_RANGE_BARRIERS_INFO_KHR:
        add_range_barriers(group, (const void *)structure);
        break;
    case VK_STRUCTURE_TYPE_MEMORY_BARRIER_ACCESS_FLAGS_3_KHR: /* of the range barriers */
        break;
    case VK_STRUCTURE_TYPE_TENSOR_MEMORY_BARRIER_ARM:
        dependency = DEPENDENCY_OF(tensor);
        add_execution(group, &dependency);
        break;
    case VK_STRUCTURE_TYPE_TENSOR_DEPENDENCY_INFO_ARM:
        for (uint32_t i = 0; i < tensors->tensorMemoryBarrierCount; i++) {
            dependency = DEPENDENCY_OF(&tensors->pTensorMemoryBarriers[i]);
            add_execution(group, &dependency);
        }
        break;
    default:
        add_global(group, &dependency);
    }
}

static void add_info(struct group *group, const VkDependencyInfo *info)
{
    add_memory_barriers(group, info);
    add_buffer_barriers(group, info);
    for (const VkBaseInStructure *s = info->pNext; s; s = s->pNext)
        add_extension(group, s);
}

void barriers_add(struct hazard_recording *recording, const VkDependencyInfo *info)
{
    struct group group = begin_group(recording);
    add_info(&group, info);
}

void barriers_wait_events(struct hazard_recording *recording, uint32_t count, const VkEvent *events,
                          const VkDependencyInfo *infos)
{
    for (uint32_t i = 0; i < count; i++) {
        struct group group = begin_wait(recording, events[i]);
        add_info(&group, &infos[i]);
    }
}

/* ---- events and render passes */

void barriers_set_event(struct hazard_recording *recording, VkEvent event,
                        const VkDependencyInfo *info)
{
    struct hazard_entry *entry = hazard_add(recording->journal, HAZARD_SET_EVENT);
    if (!entry)
        return;
    entry->object = handle_number(event);
    if (info->pNext)
        entry->dependency.src = ALL_SYNC_STAGES;
    for (uint32_t i = 0; i < info->memoryBarrierCount; i++)
        entry->dependency.src |= DEPENDENCY_OF(&info->pMemoryBarriers[i]).src;
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount; i++)
        entry->dependency.src |= DEPENDENCY_OF(&info->pBufferMemoryBarriers[i]).src;
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount; i++)
        entry->dependency.src |= DEPENDENCY_OF(&info->pImageMemoryBarriers[i]).src;
}

void barriers_add_global(struct hazard_recording *recording, const struct dependency *dependency)
{
    struct group group = begin_group(recording);
    add_global(&group, dependency);
}
