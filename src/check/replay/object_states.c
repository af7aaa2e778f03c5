/* SPDX-License-Identifier: Apache-2.0 */
#include "src/check/replay/object_states.h"

#include "src/state/resources/nv_shape.h"

/* The facts that objects of all types have. */
struct common_facts {
    enum tristate alive, backed;
    bool buffer_is_destroyed;
    uint64_t id;
};

static struct common_facts facts_of_nv(struct resources *resources, uint64_t handle)
{
    struct nv_accel_facts facts;
    resources_look_up_nv_accel(resources, (VkAccelerationStructureNV)(uintptr_t)handle, &facts);
    nv_shape_release(facts.created);
    return (struct common_facts){.alive = facts.alive,
                                 .backed = facts.binding == NV_MEMORY_FREED ? NO : UNKNOWN,
                                 .id = facts.id};
}

static struct common_facts facts_of_micromap(struct resources *resources, uint64_t handle)
{
    struct micromap_facts facts;
    resources_find_micromap(resources, (VkMicromapEXT)(uintptr_t)handle, &facts);
    return (struct common_facts){.alive = facts.alive,
                                 .backed = facts.backed,
                                 .buffer_is_destroyed = facts.buffer_is_destroyed,
                                 .id = facts.id};
}

static struct common_facts facts_of(struct resources *resources, uint64_t handle)
{
    struct accel_facts facts;
    resources_look_up_accel(resources, (VkAccelerationStructureKHR)(uintptr_t)handle, &facts);
    return (struct common_facts){.alive = facts.alive,
                                 .backed = facts.backed,
                                 .buffer_is_destroyed = facts.buffer_is_destroyed,
                                 .id = facts.id};
}

static struct common_facts facts_of_type(struct resources *resources, VkObjectType type,
                                         uint64_t handle)
{
    switch ((int)type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return facts_of_micromap(resources, handle);
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        return facts_of_nv(resources, handle);
    default:
        return facts_of(resources, handle);
    }
}

struct object_state object_state_find(struct resources *resources, VkObjectType type,
                                      uint64_t handle, uint64_t id, bool was_backed)
{
    const struct common_facts facts = facts_of_type(resources, type, handle);
    return (struct object_state){
        .is_destroyed = facts.alive == NO || (facts.alive == YES && facts.id != id),
        .lost_memory = facts.alive == YES && was_backed && facts.backed == NO,
        .buffer_is_destroyed = facts.buffer_is_destroyed,
    };
}
