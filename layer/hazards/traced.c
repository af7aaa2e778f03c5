/* SPDX-License-Identifier: Apache-2.0 */
/* Follows descriptor sets with acceleration structures, and records which structures are bound when
 * a command traces rays. */
#include "layer/hazards/traced.h"

#include "layer/hazards/descriptors.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"

/* ---- layouts: some sets cannot be followed */

static bool may_hold_structures(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR ||
           type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_MUTABLE_EXT;
}

/* Whether the set may be written after it is bound. Flags that cannot be read count as such. */
static bool binding_changes(const VkDescriptorSetLayoutCreateInfo *info, uint32_t binding)
{
    const VkDescriptorSetLayoutBindingFlagsCreateInfo *flags =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO);
    if (!flags || !flags->bindingCount)
        return false;
    return binding >= flags->bindingCount ||
           !readable(readable_cache_of_thread(), flags->pBindingFlags,
                     flags->bindingCount * sizeof(*flags->pBindingFlags)) ||
           flags->pBindingFlags[binding] & VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT;
}

void hazards_note_set_layout(struct layer_device *device,
                             const VkDescriptorSetLayoutCreateInfo *info)
{
    const bool is_followed =
        !(info->flags & (VK_DESCRIPTOR_SET_LAYOUT_CREATE_DESCRIPTOR_BUFFER_BIT_EXT |
                         VK_DESCRIPTOR_SET_LAYOUT_CREATE_INDIRECT_BINDABLE_BIT_NV));
    for (uint32_t i = 0; i < info->bindingCount; i++)
        if (may_hold_structures(info->pBindings[i].descriptorType) &&
            (!is_followed || binding_changes(info, i)))
            hazards_lack_descriptors(device);
}

/* ---- writes */

/* An array of descriptors may go on in the next binding: what it overwrites there stays known, too,
 * which can only hide a mistake. */
static void write_structures(struct descriptor_sets *sets, uint64_t set,
                             const VkWriteDescriptorSet *to)
{
    const VkWriteDescriptorSetAccelerationStructureKHR *from =
        chain_find(to->pNext, VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR);
    if (to->descriptorType != VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR || !from ||
        !readable(readable_cache_of_thread(), from->pAccelerationStructures,
                  from->accelerationStructureCount * sizeof(*from->pAccelerationStructures))) {
        descriptor_sets_lose(sets, set);
        return;
    }
    for (uint32_t i = 0; i < from->accelerationStructureCount; i++)
        descriptor_sets_write(sets, set, to->dstBinding, to->dstArrayElement + i,
                              (uint64_t)(uintptr_t)from->pAccelerationStructures[i]);
}

void hazards_update_sets(struct layer_device *device, uint32_t write_count,
                         const VkWriteDescriptorSet *writes, uint32_t copy_count,
                         const VkCopyDescriptorSet *copies)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    for (uint32_t i = 0; sets && i < write_count; i++)
        if (may_hold_structures(writes[i].descriptorType))
            write_structures(sets, (uint64_t)(uintptr_t)writes[i].dstSet, &writes[i]);
    for (uint32_t i = 0; sets && i < copy_count; i++)
        descriptor_sets_copy(sets, (uint64_t)(uintptr_t)copies[i].srcSet,
                             (uint64_t)(uintptr_t)copies[i].dstSet);
}

/* What a template writes is not followed. */
void hazards_update_set_by_template(struct layer_device *device, VkDescriptorSet set)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets)
        descriptor_sets_lose(sets, (uint64_t)(uintptr_t)set);
}

/* Sets end with their pool, too, so only the beginning of a set is followed. */
void hazards_allocate_sets(struct layer_device *device, uint32_t count, VkDescriptorSet *all)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    for (uint32_t i = 0; sets && i < count; i++)
        descriptor_sets_forget(sets, (uint64_t)(uintptr_t)all[i]);
}

void hazards_lack_descriptors(struct layer_device *device)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets)
        descriptor_sets_lack(sets);
}

/* ---- in command buffers */

static void bind_sets(struct journal *journal, enum traced_point point, uint32_t first,
                      uint32_t count, const VkDescriptorSet *sets)
{
    journal->shaders_end = NULL;
    journal->has_sets = true;
    journal->lacks_sets |= first > JOURNAL_SETS || count > JOURNAL_SETS - first;
    for (uint32_t i = 0; !journal->lacks_sets && i < count; i++)
        journal->sets[point][first + i] = (uint64_t)(uintptr_t)sets[i];
}

void hazards_bind_sets(struct hazard_recording *recording, VkPipelineBindPoint point,
                       uint32_t first, uint32_t count, const VkDescriptorSet *sets)
{
    if (point == VK_PIPELINE_BIND_POINT_COMPUTE)
        bind_sets(recording->journal, TRACED_BY_COMPUTE, first, count, sets);
    else if (point == VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR)
        bind_sets(recording->journal, TRACED_BY_RAYS, first, count, sets);
}

/* The stages of all ray tracing shaders: from ray generation to callable. */
static const VkShaderStageFlags ray_stages =
    VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR |
    VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR |
    VK_SHADER_STAGE_INTERSECTION_BIT_KHR | VK_SHADER_STAGE_CALLABLE_BIT_KHR;

void hazards_bind_sets_2(struct hazard_recording *recording, const VkBindDescriptorSetsInfo *info)
{
    if (info->stageFlags & VK_SHADER_STAGE_COMPUTE_BIT)
        bind_sets(recording->journal, TRACED_BY_COMPUTE, info->firstSet, info->descriptorSetCount,
                  info->pDescriptorSets);
    if (info->stageFlags & ray_stages)
        bind_sets(recording->journal, TRACED_BY_RAYS, info->firstSet, info->descriptorSetCount,
                  info->pDescriptorSets);
}

/* Descriptors that are pushed are those of a set whose handle is the address of its place in the
 * journal. What a recording before has pushed is not there any more. */
static void push_set(struct hazard_recording *recording, enum traced_point point, uint32_t set,
                     uint32_t count, const VkWriteDescriptorSet *writes)
{
    struct journal *journal = recording->journal;
    struct descriptor_sets *sets = hazard_objects_sets(recording->device->hazard_objects);
    const uint64_t pushed =
        set < JOURNAL_SETS ? (uint64_t)(uintptr_t)&journal->sets[point][set] : 0;
    const VkDescriptorSet handle = (VkDescriptorSet)(uintptr_t)pushed;
    if (sets && pushed && journal->sets[point][set] != pushed)
        descriptor_sets_forget(sets, pushed);
    bind_sets(journal, point, set, 1, &handle);
    for (uint32_t i = 0; sets && pushed && i < count; i++)
        if (may_hold_structures(writes[i].descriptorType))
            write_structures(sets, pushed, &writes[i]);
}

void hazards_push_set(struct hazard_recording *recording, VkPipelineBindPoint point, uint32_t set,
                      uint32_t count, const VkWriteDescriptorSet *writes)
{
    if (point == VK_PIPELINE_BIND_POINT_COMPUTE)
        push_set(recording, TRACED_BY_COMPUTE, set, count, writes);
    else if (point == VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR)
        push_set(recording, TRACED_BY_RAYS, set, count, writes);
}

void hazards_push_set_2(struct hazard_recording *recording, const VkPushDescriptorSetInfo *info)
{
    if (info->stageFlags & VK_SHADER_STAGE_COMPUTE_BIT)
        push_set(recording, TRACED_BY_COMPUTE, info->set, info->descriptorWriteCount,
                 info->pDescriptorWrites);
    if (info->stageFlags & ray_stages)
        push_set(recording, TRACED_BY_RAYS, info->set, info->descriptorWriteCount,
                 info->pDescriptorWrites);
}

/* Which structures a template pushes is not followed. */
void hazards_push_by_template(struct hazard_recording *recording)
{
    recording->journal->has_sets = recording->journal->lacks_sets = true;
}

/* Finds the structures that are bound. Returns 0 if others may be, too. */
static uint32_t find_bound(struct hazard_recording *recording, enum traced_point point,
                           uint64_t found[TRACED_MAX])
{
    const struct journal *journal = recording->journal;
    struct descriptor_sets *sets = hazard_objects_sets(recording->device->hazard_objects);
    uint32_t count = 0;
    if (!sets || !journal->has_sets || journal->lacks_sets || atomic_load(&sets->lacks))
        return 0;
    for (uint32_t i = 0; i < JOURNAL_SETS; i++)
        if (journal->sets[point][i] &&
            !descriptor_sets_find(sets, journal->sets[point][i], found, &count))
            return 0;
    return count;
}

/* Returns false if it is unknown where the structure lies. It may be destroyed. */
static bool locate_structure(struct hazard_recording *recording, uint64_t structure,
                             struct accel_facts *facts)
{
    resources_look_up_accel(recording->device->resources,
                            (VkAccelerationStructureKHR)(uintptr_t)structure, facts);
    return facts->alive != YES ||
           (facts->memory && !facts->is_sparse && facts->size &&
            hazard_memory_id(recording->journal, recording->device->resources, facts->memory));
}

static void add_traced(struct hazard_recording *recording, const struct hazard_use *use,
                       uint64_t structure, const struct accel_facts *facts)
{
    if (facts->alive == YES) {
        hazard_recording_add_accel(recording, use, facts, 1);
        return;
    }
    struct hazard_entry *entry = hazard_recording_add_entry(recording, HAZARD_ACCESS, use);
    if (!entry)
        return;
    entry->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    entry->object = structure;
}

void hazards_add_traced(struct hazard_recording *recording, enum access_kind kind,
                        enum traced_point point)
{
    const struct hazard_use use = {.kind = kind, .role = HAZARD_TRACED};
    uint64_t bound[TRACED_MAX];
    struct accel_facts facts[TRACED_MAX];
    const uint32_t count = find_bound(recording, point, bound);
    uint32_t located = 0;
    while (located < count && locate_structure(recording, bound[located], &facts[located]))
        located++;
    for (uint32_t i = 0; located == count && i < count; i++)
        add_traced(recording, &use, bound[i], &facts[i]);
}
