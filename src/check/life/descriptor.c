/* SPDX-License-Identifier: Apache-2.0 */
/* Validates writes of descriptors of structures. */
#include "arguments.h"
#include "src/base/chain.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"

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
           type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV;
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
        check_structures(walk, call, location, &all[i]);
    }
}
