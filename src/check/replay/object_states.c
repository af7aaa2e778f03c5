/* SPDX-License-Identifier: Apache-2.0 */
#include "src/check/replay/object_states.h"

#include "src/state/resources/nv_shape.h"

static struct object_facts facts_of_nv(struct resources *resources, uint64_t handle)
{
    struct nv_accel_facts facts;
    resources_look_up_nv_accel(resources, (VkAccelerationStructureNV)(uintptr_t)handle, &facts);
    nv_shape_release(facts.created);
    return (struct object_facts){.alive = facts.alive,
                                 .backed = facts.binding == NV_MEMORY_FREED ? NO
                                           : facts.binding == NV_BOUND      ? YES
                                                                            : UNKNOWN,
                                 .id = facts.id,
                                 .size = facts.sizes.known ? facts.sizes.object : 0,
                                 .span = facts.span};
}

static struct object_facts facts_of_micromap(struct resources *resources, uint64_t handle)
{
    struct micromap_facts facts;
    resources_find_micromap(resources, (VkMicromapEXT)(uintptr_t)handle, &facts);
    return (struct object_facts){.alive = facts.alive,
                                 .backed = facts.backed,
                                 .buffer_is_destroyed = facts.buffer_is_destroyed,
                                 .id = facts.id,
                                 .size = facts.size,
                                 .span = facts.span};
}

static struct object_facts facts_of_accel(struct resources *resources, uint64_t handle)
{
    struct accel_facts facts;
    resources_look_up_accel(resources, (VkAccelerationStructureKHR)(uintptr_t)handle, &facts);
    const VkDeviceMemory memory = facts.details_known ? facts.memory : VK_NULL_HANDLE;
    return (struct object_facts){.alive = facts.alive,
                                 .backed = facts.backed,
                                 .buffer_is_destroyed = facts.buffer_is_destroyed,
                                 .id = facts.id,
                                 .size = facts.details_known ? facts.size : 0,
                                 .span = memory_span_of(memory, facts.begin, facts.size)};
}

struct object_facts object_facts_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle)
{
    switch ((int)type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return facts_of_micromap(resources, handle);
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        return facts_of_nv(resources, handle);
    default:
        return facts_of_accel(resources, handle);
    }
}

struct object_state object_state_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle, uint64_t id, bool was_backed)
{
    const struct object_facts facts = object_facts_find(resources, type, handle);
    return (struct object_state){
        .is_destroyed = facts.alive == NO || (facts.alive == YES && facts.id != id),
        .has_no_memory = facts.alive == YES && was_backed && facts.backed == NO,
        .buffer_is_destroyed = facts.buffer_is_destroyed,
    };
}
