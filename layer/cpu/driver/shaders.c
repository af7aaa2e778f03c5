/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: descriptors and shaders. Descriptors of acceleration structures cannot work:
 * commands that would create one fail, and writes of them are left out. Nor can shaders that trace
 * rays. */
#include <string.h>

#include "layer/cpu/overlay.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/view/shader_code.h"

bool cpu_is_of_structure(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR ||
           type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV;
}

/* Whether descriptors of VK_DESCRIPTOR_TYPE_MUTABLE_EXT may have a type of ray tracing. */
static bool mutable_types_trace(const void *chain)
{
    const VkMutableDescriptorTypeCreateInfoEXT *info =
        chain_find(chain, VK_STRUCTURE_TYPE_MUTABLE_DESCRIPTOR_TYPE_CREATE_INFO_EXT);
    bool found = false;
    for (uint32_t i = 0; info && i < info->mutableDescriptorTypeListCount; i++) {
        const VkMutableDescriptorTypeListEXT *list = &info->pMutableDescriptorTypeLists[i];
        for (uint32_t j = 0; j < list->descriptorTypeCount && !found; j++)
            found = cpu_is_of_structure(list->pDescriptorTypes[j]);
    }
    return found;
}

void cpu_report_descriptor(struct layer_device *device, const char *command)
{
    cpu_report_unsupported(device->instance, command, "a descriptor of an acceleration structure");
}

VkResult cpu_refuse_descriptor(struct layer_device *device, const char *command)
{
    cpu_report_descriptor(device, command);
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

/* ---- layouts, pools, templates */

bool cpu_layout_has_structures(const VkDescriptorSetLayoutCreateInfo *info)
{
    bool found = mutable_types_trace(info->pNext);
    for (uint32_t i = 0; i < info->bindingCount && !found; i++)
        found = cpu_is_of_structure(info->pBindings[i].descriptorType);
    return found;
}

void cpu_deny_layout(VkDescriptorSetLayoutSupport *support)
{
    support->supported = VK_FALSE;
}

bool cpu_pool_has_structures(const VkDescriptorPoolCreateInfo *info)
{
    bool found = mutable_types_trace(info->pNext);
    for (uint32_t i = 0; i < info->poolSizeCount && !found; i++)
        found = cpu_is_of_structure(info->pPoolSizes[i].type);
    return found;
}

bool cpu_template_has_structures(const VkDescriptorUpdateTemplateCreateInfo *info)
{
    bool found = false;
    for (uint32_t i = 0; i < info->descriptorUpdateEntryCount && !found; i++)
        found = cpu_is_of_structure(info->pDescriptorUpdateEntries[i].descriptorType);
    return found;
}

bool cpu_resources_have_structures(uint32_t count, const VkResourceDescriptorInfoEXT *resources)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = cpu_is_of_structure(resources[i].type);
    return found;
}

/* ---- writes */

/* Finds the next run of writes without descriptors of acceleration structures, from *begin on.
 * Returns false if there is none. */
static bool next_run(const VkWriteDescriptorSet *writes, uint32_t count, uint32_t *begin,
                     uint32_t *length)
{
    while (*begin < count && cpu_is_of_structure(writes[*begin].descriptorType))
        (*begin)++;
    *length = 0;
    while (*begin + *length < count &&
           !cpu_is_of_structure(writes[*begin + *length].descriptorType))
        (*length)++;
    return *length;
}

bool cpu_writes_have_structures(uint32_t count, const VkWriteDescriptorSet *writes)
{
    uint32_t begin = 0, length;
    next_run(writes, count, &begin, &length);
    return length < count;
}

void cpu_update_other_descriptors(PFN_vkUpdateDescriptorSets down, VkDevice device, uint32_t count,
                                  const VkWriteDescriptorSet *writes, uint32_t copy_count,
                                  const VkCopyDescriptorSet *copies)
{
    uint32_t begin = 0, length;
    for (; next_run(writes, count, &begin, &length); begin += length)
        down(device, length, &writes[begin], 0, NULL);
    down(device, 0, NULL, copy_count, copies);
}

void cpu_push_other_descriptors(PFN_vkCmdPushDescriptorSet down, VkCommandBuffer commands,
                                VkPipelineBindPoint bind_point, VkPipelineLayout layout,
                                uint32_t set, uint32_t count, const VkWriteDescriptorSet *writes)
{
    uint32_t begin = 0, length;
    for (; next_run(writes, count, &begin, &length); begin += length)
        down(commands, bind_point, layout, set, length, &writes[begin]);
}

void cpu_push_other_descriptors_2(PFN_vkCmdPushDescriptorSet2 down, VkCommandBuffer commands,
                                  const VkPushDescriptorSetInfo *info)
{
    VkPushDescriptorSetInfo below = *info;
    uint32_t begin = 0;
    for (; next_run(info->pDescriptorWrites, info->descriptorWriteCount, &begin,
                    &below.descriptorWriteCount);
         begin += below.descriptorWriteCount) {
        below.pDescriptorWrites = &info->pDescriptorWrites[begin];
        down(commands, &below);
    }
}

/* ---- shaders */

void cpu_report_shader(struct layer_device *device, const char *command)
{
    cpu_report_unsupported(device->instance, command, "a shader that traces rays");
}

VkResult cpu_refuse_shader(struct layer_device *device, const char *command)
{
    cpu_report_shader(device, command);
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

/* `handles`: of the shaders or pipelines that are not created. */
VkResult cpu_refuse_shaders(struct layer_device *device, const char *command, uint32_t count,
                            void *handles)
{
    if (count)
        memset(handles, 0, count * sizeof(VkPipeline));
    return cpu_refuse_shader(device, command);
}

bool cpu_shaders_trace(uint32_t count, const VkShaderCreateInfoEXT *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = infos[i].codeType == VK_SHADER_CODE_TYPE_SPIRV_EXT &&
                shader_code_traces(infos[i].pCode, infos[i].codeSize);
    return found;
}

/* ---- pipeline stages with inline shader code */

/* A pipeline library may ignore its stages, which then need not be readable. */
static bool a_stage_traces(const VkGraphicsPipelineCreateInfo *info)
{
    struct readable_cache *cache = readable_cache_of_thread();
    for (uint32_t i = 0; i < info->stageCount; i++) {
        if (!readable(cache, &info->pStages[i], sizeof(info->pStages[i])))
            return false;
        if (shader_stage_traces(&info->pStages[i]))
            return true;
    }
    return false;
}

bool cpu_compute_pipelines_trace(uint32_t count, const VkComputePipelineCreateInfo *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = shader_stage_traces(&infos[i].stage);
    return found;
}

bool cpu_graphics_pipelines_trace(uint32_t count, const VkGraphicsPipelineCreateInfo *infos)
{
    bool found = false;
    for (uint32_t i = 0; i < count && !found; i++)
        found = a_stage_traces(&infos[i]);
    return found;
}
