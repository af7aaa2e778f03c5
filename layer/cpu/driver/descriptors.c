/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: descriptors. Descriptors of acceleration structures cannot work:
 * commands that would create one fail, and writes of them are left out. */
#include "layer/cpu/overlay.h"
#include "layer/cpu/unsupported.h"
#include "observers.h"
#include "src/base/chain.h"

static bool type_traces(VkDescriptorType type)
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
            found = type_traces(list->pDescriptorTypes[j]);
    }
    return found;
}

static void report_unsupported(const struct layer_device *device, const char *command)
{
    cpu_report_unsupported(device->instance, command, "a descriptor of an acceleration structure");
}

/* ---- layouts, pools, templates */

static bool layout_traces(const VkDescriptorSetLayoutCreateInfo *info)
{
    bool found = mutable_types_trace(info->pNext);
    for (uint32_t i = 0; i < info->bindingCount && !found; i++)
        found = type_traces(info->pBindings[i].descriptorType);
    return found;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateDescriptorSetLayout(
    VkDevice device, const VkDescriptorSetLayoutCreateInfo *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkDescriptorSetLayout *pSetLayout)
{
    if (!layout_traces(pCreateInfo))
        return cpu_next(device)->CreateDescriptorSetLayout(device, pCreateInfo, pAllocator,
                                                           pSetLayout);
    report_unsupported(layer_find_device(device), "vkCreateDescriptorSetLayout");
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

/* A command and its alias differ only in which command of the next layer they call. */
#define DEFINE_GET_LAYOUT_SUPPORT(name)                                                            \
    VKAPI_ATTR void VKAPI_CALL cpu_##name(VkDevice device,                                         \
                                          const VkDescriptorSetLayoutCreateInfo *pCreateInfo,      \
                                          VkDescriptorSetLayoutSupport *pSupport)                  \
    {                                                                                              \
        if (layout_traces(pCreateInfo))                                                            \
            pSupport->supported = VK_FALSE;                                                        \
        else                                                                                       \
            cpu_next(device)->name(device, pCreateInfo, pSupport);                                 \
    }

DEFINE_GET_LAYOUT_SUPPORT(GetDescriptorSetLayoutSupport)
DEFINE_GET_LAYOUT_SUPPORT(GetDescriptorSetLayoutSupportKHR)

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CreateDescriptorPool(VkDevice device, const VkDescriptorPoolCreateInfo *pCreateInfo,
                         const VkAllocationCallbacks *pAllocator, VkDescriptorPool *pDescriptorPool)
{
    bool traces = mutable_types_trace(pCreateInfo->pNext);
    for (uint32_t i = 0; i < pCreateInfo->poolSizeCount && !traces; i++)
        traces = type_traces(pCreateInfo->pPoolSizes[i].type);
    if (!traces)
        return cpu_next(device)->CreateDescriptorPool(device, pCreateInfo, pAllocator,
                                                      pDescriptorPool);
    report_unsupported(layer_find_device(device), "vkCreateDescriptorPool");
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

static bool template_traces(const VkDescriptorUpdateTemplateCreateInfo *info)
{
    bool found = false;
    for (uint32_t i = 0; i < info->descriptorUpdateEntryCount && !found; i++)
        found = type_traces(info->pDescriptorUpdateEntries[i].descriptorType);
    return found;
}

#define DEFINE_CREATE_TEMPLATE(name)                                                               \
    VKAPI_ATTR VkResult VKAPI_CALL cpu_##name(                                                     \
        VkDevice device, const VkDescriptorUpdateTemplateCreateInfo *pCreateInfo,                  \
        const VkAllocationCallbacks *pAllocator,                                                   \
        VkDescriptorUpdateTemplate *pDescriptorUpdateTemplate)                                     \
    {                                                                                              \
        if (!template_traces(pCreateInfo))                                                         \
            return cpu_next(device)->name(device, pCreateInfo, pAllocator,                         \
                                          pDescriptorUpdateTemplate);                              \
        report_unsupported(layer_find_device(device), "vk" #name);                                 \
        return VK_ERROR_VALIDATION_FAILED_EXT;                                                     \
    }

DEFINE_CREATE_TEMPLATE(CreateDescriptorUpdateTemplate)
DEFINE_CREATE_TEMPLATE(CreateDescriptorUpdateTemplateKHR)

/* ---- writes */

/* Finds the next run of writes without descriptors of acceleration structures, from *begin on.
 * Returns false if there is none. */
static bool next_run(const VkWriteDescriptorSet *writes, uint32_t count, uint32_t *begin,
                     uint32_t *length)
{
    while (*begin < count && type_traces(writes[*begin].descriptorType))
        (*begin)++;
    *length = 0;
    while (*begin + *length < count && !type_traces(writes[*begin + *length].descriptorType))
        (*length)++;
    return *length;
}

/* Whether all writes can be executed. If not, reports that some are left out. */
static bool writes_work(const struct layer_device *device, const char *command, uint32_t count,
                        const VkWriteDescriptorSet *writes)
{
    uint32_t begin = 0, length;
    next_run(writes, count, &begin, &length);
    if (begin == 0 && length == count)
        return true;
    report_unsupported(device, command);
    return false;
}

VKAPI_ATTR void VKAPI_CALL cpu_UpdateDescriptorSets(VkDevice device, uint32_t descriptorWriteCount,
                                                    const VkWriteDescriptorSet *pDescriptorWrites,
                                                    uint32_t descriptorCopyCount,
                                                    const VkCopyDescriptorSet *pDescriptorCopies)
{
    PFN_vkUpdateDescriptorSets next = cpu_next(device)->UpdateDescriptorSets;
    uint32_t begin = 0, length;
    if (writes_work(layer_find_device(device), "vkUpdateDescriptorSets", descriptorWriteCount,
                    pDescriptorWrites)) {
        next(device, descriptorWriteCount, pDescriptorWrites, descriptorCopyCount,
             pDescriptorCopies);
        return;
    }
    for (; next_run(pDescriptorWrites, descriptorWriteCount, &begin, &length); begin += length)
        next(device, length, &pDescriptorWrites[begin], 0, NULL);
    next(device, 0, NULL, descriptorCopyCount, pDescriptorCopies);
}

#define DEFINE_PUSH(name)                                                                          \
    VKAPI_ATTR void VKAPI_CALL cpu_##name(                                                         \
        VkCommandBuffer commandBuffer, VkPipelineBindPoint pipelineBindPoint,                      \
        VkPipelineLayout layout, uint32_t set, uint32_t descriptorWriteCount,                      \
        const VkWriteDescriptorSet *pDescriptorWrites)                                             \
    {                                                                                              \
        const struct layer_device *device = layer_find_recording_device(commandBuffer);            \
        uint32_t begin = 0, length;                                                                \
        if (!device)                                                                               \
            return;                                                                                \
        writes_work(device, "vk" #name, descriptorWriteCount, pDescriptorWrites);                  \
        for (; next_run(pDescriptorWrites, descriptorWriteCount, &begin, &length);                 \
             begin += length)                                                                      \
            device->cpu->next.name(commandBuffer, pipelineBindPoint, layout, set, length,          \
                                   &pDescriptorWrites[begin]);                                     \
    }

DEFINE_PUSH(CmdPushDescriptorSet)
DEFINE_PUSH(CmdPushDescriptorSetKHR)

#define DEFINE_PUSH_2(name)                                                                        \
    VKAPI_ATTR void VKAPI_CALL cpu_##name(VkCommandBuffer commandBuffer,                           \
                                          const VkPushDescriptorSetInfo *pPushDescriptorSetInfo)   \
    {                                                                                              \
        const struct layer_device *device = layer_find_recording_device(commandBuffer);            \
        if (!device)                                                                               \
            return;                                                                                \
        const VkPushDescriptorSetInfo *info = pPushDescriptorSetInfo;                              \
        VkPushDescriptorSetInfo below = *info;                                                     \
        uint32_t begin = 0;                                                                        \
        writes_work(device, "vk" #name, info->descriptorWriteCount, info->pDescriptorWrites);      \
        for (; next_run(info->pDescriptorWrites, info->descriptorWriteCount, &begin,               \
                        &below.descriptorWriteCount);                                              \
             begin += below.descriptorWriteCount) {                                                \
            below.pDescriptorWrites = &info->pDescriptorWrites[begin];                             \
            device->cpu->next.name(commandBuffer, &below);                                         \
        }                                                                                          \
    }

DEFINE_PUSH_2(CmdPushDescriptorSet2)
DEFINE_PUSH_2(CmdPushDescriptorSet2KHR)

/* ---- descriptors in memory */

VKAPI_ATTR void VKAPI_CALL cpu_GetDescriptorEXT(VkDevice device,
                                                const VkDescriptorGetInfoEXT *pDescriptorInfo,
                                                size_t dataSize, void *pDescriptor)
{
    if (type_traces(pDescriptorInfo->type))
        report_unsupported(layer_find_device(device), "vkGetDescriptorEXT");
    else
        cpu_next(device)->GetDescriptorEXT(device, pDescriptorInfo, dataSize, pDescriptor);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT(
    VkDevice device, const VkAccelerationStructureCaptureDescriptorDataInfoEXT *pInfo, void *pData)
{
    (void)pInfo;
    (void)pData;
    report_unsupported(layer_find_device(device),
                       "vkGetAccelerationStructureOpaqueCaptureDescriptorDataEXT");
    return VK_ERROR_VALIDATION_FAILED_EXT;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_WriteResourceDescriptorsEXT(
    VkDevice device, uint32_t resourceCount, const VkResourceDescriptorInfoEXT *pResources,
    const VkHostAddressRangeEXT *pDescriptors)
{
    bool traces = false;
    for (uint32_t i = 0; i < resourceCount && !traces; i++)
        traces = type_traces(pResources[i].type);
    if (!traces)
        return cpu_next(device)->WriteResourceDescriptorsEXT(device, resourceCount, pResources,
                                                             pDescriptors);
    report_unsupported(layer_find_device(device), "vkWriteResourceDescriptorsEXT");
    return VK_ERROR_VALIDATION_FAILED_EXT;
}
