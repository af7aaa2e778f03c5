/* SPDX-License-Identifier: Apache-2.0 */
/* Validates writes of descriptors of structures. */
#include "arguments.h"
#include "src/base/chain.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"
#include "src/state/resources/update_templates.h"

#include <string.h>

struct writes {
    uint32_t count;
    const VkWriteDescriptorSet *all; /* of the application */
    const char *parameter;
};

static struct writes find_writes(struct check_context *context, const struct call_view *call)
{
    const struct arguments_of_UpdateDescriptorSets *update = call->arguments;
    const struct arguments_of_CmdPushDescriptorSet *push = call->arguments;
    const struct arguments_of_CmdPushDescriptorSet2 *push2 = call->arguments;
    switch ((int)call->command) {
    case COMMAND_UpdateDescriptorSets:
        return (struct writes){update->descriptorWriteCount, update->pDescriptorWrites,
                               "pDescriptorWrites"};
    case COMMAND_CmdPushDescriptorSet:
        return (struct writes){push->descriptorWriteCount, push->pDescriptorWrites,
                               "pDescriptorWrites"};
    default: {
        const VkPushDescriptorSetInfo *info =
            check_read(context, push2->pPushDescriptorSetInfo, sizeof(*info));
        return info ? (struct writes){info->descriptorWriteCount, info->pDescriptorWrites,
                                      "pPushDescriptorSetInfo->pDescriptorWrites"}
                    : (struct writes){0};
    }
    }
}

static bool is_of_structures(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR ||
           type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV;
}

/* Both extensions' structures have the same members, up to the type of the handles. */
_Static_assert(sizeof(VkWriteDescriptorSetAccelerationStructureKHR) ==
                   sizeof(VkWriteDescriptorSetAccelerationStructureNV),
               "read alike");

/* A chain may also have the structure of the other type of descriptors, which is ignored. */
static void check_structures(struct walk *walk, const struct call_view *call,
                             struct location location, const VkWriteDescriptorSet *write)
{
    struct check_context *context = walk->context;
    const bool is_nv = write->descriptorType == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV;
    if (!chain_is_readable(context, write->pNext))
        return;
    const VkWriteDescriptorSetAccelerationStructureKHR *info = check_read(
        context,
        chain_find(write->pNext,
                   is_nv ? VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_NV
                         : VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR),
        sizeof(*info));
    const uint64_t *handles = info ? check_read(context, info->pAccelerationStructures,
                                                info->accelerationStructureCount * sizeof(*handles))
                                   : NULL;
    for (uint32_t i = 0; handles && i < info->accelerationStructureCount; i++) {
        const struct descriptor_view descriptor = {
            .call = call,
            .structure = check_find_object(context,
                                           is_nv ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                                 : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                           handles[i])};
        location.geometry = i;
        walk_descriptor(walk, &descriptor, &location);
    }
}

void check_descriptors(struct walk *walk, const struct call_view *call)
{
    const struct writes writes = find_writes(walk->context, call);
    const VkWriteDescriptorSet *all =
        check_read(walk->context, writes.all, writes.count * sizeof(*all));
    for (uint32_t i = 0; all && i < writes.count; i++) {
        if (!is_of_structures(all[i].descriptorType))
            continue;
        const struct location location = check_element(call, writes.parameter, i);
        check_implicit_descriptor(walk, call, &location, all[i].pNext);
        if (all[i].descriptorType == VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV)
            check_partition_descriptors(walk, call, location, &all[i]);
        else
            check_structures(walk, call, location, &all[i]);
    }
}

/* ---- updates with templates */

/* Returns whether the data at the offset can be read. */
static bool check_element_of_data(struct walk *walk, const struct call_view *call,
                                  const VkDescriptorUpdateTemplateEntry *entry, const void *data,
                                  uint64_t offset)
{
    const struct location location = check_argument(call, "pData");
    const uintptr_t address = (uintptr_t)data + (uintptr_t)offset;
    const void *at = check_read(walk->context,
                                (const void *)address, // NOLINT(performance-no-int-to-ptr)
                                sizeof(uint64_t));
    uint64_t handle = 0;
    if (at)
        memcpy(&handle, at, sizeof(handle));
    const VkObjectType type = entry->descriptorType == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV
                                  ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                  : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    const struct templated_view templated = {.call = call,
                                             .structure =
                                                 check_find_object(walk->context, type, handle),
                                             .offset = offset,
                                             .unreadable = !at};
    walk_templated(walk, &templated, &location);
    return at;
}

void check_templated(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_UpdateDescriptorSetWithTemplate *arguments = call->arguments;
    const struct update_template *found =
        update_templates_find(walk->context->templates, arguments->descriptorUpdateTemplate);
    for (uint32_t i = 0; found && i < found->count; i++) {
        const VkDescriptorUpdateTemplateEntry *entry = &found->entries[i];
        bool is_readable = true;
        for (uint32_t j = 0; is_readable && j < entry->descriptorCount; j++)
            is_readable = check_element_of_data(walk, call, entry, arguments->pData,
                                                entry->offset + (uint64_t)j * entry->stride);
    }
}
