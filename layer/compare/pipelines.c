/* SPDX-License-Identifier: Apache-2.0 */
/* Creates the pipelines that trace rays, and buffers with dedicated memory. */
#include "layer/compare/tracer.h"

#include <string.h>

#include "compare_any_hit.h"
#include "compare_any_hit_of_box.h"
#include "compare_closest_hit.h"
#include "compare_generation.h"
#include "compare_intersection.h"
#include "compare_miss.h"
#include "compare_no_intersection.h"
#include "compare_query.h"

static inline struct own_device compare_own_device(const struct compare_device *device)
{
    return (struct own_device){device->handle, device->vk, device->memory};
}

/* ---- buffers */

/* Takes the smallest spare buffer that is large enough, and not much too large. */
static bool take_spare(struct compare_buffers *spare, uint64_t size, bool is_mapped,
                       struct own_buffer *buffer)
{
    enum { TIMES_TOO_LARGE = 4 };
    uint32_t best = SPARE_BUFFERS;
    for (uint32_t i = 0; spare && i < spare->count; i++) {
        const struct own_buffer *other = &spare->of[i];
        if ((other->bytes != NULL) == is_mapped && other->size >= size &&
            other->size / TIMES_TOO_LARGE <= size &&
            (best == SPARE_BUFFERS || other->size < spare->of[best].size))
            best = i;
    }
    if (best == SPARE_BUFFERS)
        return false;
    *buffer = spare->of[best];
    spare->count--;
    memmove(&spare->of[best], &spare->of[best + 1], (spare->count - best) * sizeof(*spare->of));
    return true;
}

VkResult compare_buffer_create(const struct compare_device *device, uint64_t size, bool is_mapped,
                               struct own_buffer *buffer)
{
    const struct own_device own = compare_own_device(device);
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    return take_spare(device->spare, size, is_mapped, buffer)
               ? VK_SUCCESS
               : own_buffer_create(&own, usage, size, is_mapped, buffer);
}

static void destroy_oldest(const struct compare_device *device)
{
    const struct own_device own = compare_own_device(device);
    struct compare_buffers *spare = device->spare;
    own_buffer_free(&own, &spare->of[0]);
    memmove(spare->of, spare->of + 1, --spare->count * sizeof(*spare->of));
}

static uint64_t count_bytes(const struct compare_buffers *spare)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < spare->count; i++)
        bytes += spare->of[i].size;
    return bytes;
}

void compare_buffer_free(const struct compare_device *device, struct own_buffer *buffer)
{
    struct compare_buffers *spare = device->spare;
    const bool is_whole = buffer->address; /* it failed otherwise, or was never created */
    if (!spare || !is_whole || buffer->size > SPARE_BYTES) {
        const struct own_device own = compare_own_device(device);
        own_buffer_free(&own, buffer);
        return;
    }
    while (spare->count == SPARE_BUFFERS || count_bytes(spare) > SPARE_BYTES - buffer->size)
        destroy_oldest(device);
    spare->of[spare->count++] = *buffer;
    *buffer = (struct own_buffer){0};
}

void compare_buffers_destroy(const struct compare_device *device)
{
    while (device->spare->count)
        destroy_oldest(device);
}

/* ---- creates the pipelines that trace rays */

enum { GROUP = 64 /* rays per workgroup */ };

static VkResult create_layouts(const struct compare_device *device, struct trace_pipeline *pipeline)
{
    const VkDescriptorSetLayoutBinding binding = {
        .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
        .descriptorCount = 1,
        .stageFlags =
            device->has_queries ? VK_SHADER_STAGE_COMPUTE_BIT : VK_SHADER_STAGE_RAYGEN_BIT_KHR,
    };
    const VkDescriptorSetLayoutCreateInfo set_info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = 1,
        .pBindings = &binding,
    };
    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_ALL,
                                       .size = sizeof(struct trace_constants)};
    const VkPipelineLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &pipeline->set_layout,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    VkResult result = device->vk->CreateDescriptorSetLayout(device->handle, &set_info, NULL,
                                                            &pipeline->set_layout);
    if (result == VK_SUCCESS)
        result = device->vk->CreatePipelineLayout(device->handle, &info, NULL, &pipeline->layout);
    return result;
}

static VkResult create_compute(const struct compare_device *device, struct trace_pipeline *pipeline)
{
    const struct own_device own = compare_own_device(device);
    return own_compute_create(&own, compare_query, sizeof(compare_query), pipeline->layout,
                              &pipeline->pipeline);
}

/* ---- the ray-tracing pipeline */

enum stage {
    STAGE_GENERATION,
    STAGE_MISS,
    STAGE_CLOSEST_HIT,
    STAGE_ANY_HIT,
    STAGE_ANY_HIT_OF_BOX,
    STAGE_INTERSECTION,
    STAGE_NO_INTERSECTION,
    STAGE_COUNT,
};

static const struct {
    VkShaderStageFlagBits stage;
    const uint32_t *words;
    size_t size;
} stages[STAGE_COUNT] = {
    [STAGE_GENERATION] = {VK_SHADER_STAGE_RAYGEN_BIT_KHR, compare_generation,
                          sizeof(compare_generation)},
    [STAGE_MISS] = {VK_SHADER_STAGE_MISS_BIT_KHR, compare_miss, sizeof(compare_miss)},
    [STAGE_CLOSEST_HIT] = {VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, compare_closest_hit,
                           sizeof(compare_closest_hit)},
    [STAGE_ANY_HIT] = {VK_SHADER_STAGE_ANY_HIT_BIT_KHR, compare_any_hit, sizeof(compare_any_hit)},
    [STAGE_ANY_HIT_OF_BOX] = {VK_SHADER_STAGE_ANY_HIT_BIT_KHR, compare_any_hit_of_box,
                              sizeof(compare_any_hit_of_box)},
    [STAGE_INTERSECTION] = {VK_SHADER_STAGE_INTERSECTION_BIT_KHR, compare_intersection,
                            sizeof(compare_intersection)},
    [STAGE_NO_INTERSECTION] = {VK_SHADER_STAGE_INTERSECTION_BIT_KHR, compare_no_intersection,
                               sizeof(compare_no_intersection)},
};

/* Generation, miss, then the hit groups that the generation shader selects. */
enum { GROUPS = 6, HIT_GROUPS = 4 };

static VkRayTracingShaderGroupCreateInfoKHR group(VkRayTracingShaderGroupTypeKHR type,
                                                  uint32_t general, uint32_t closest, uint32_t any,
                                                  uint32_t of_box)
{
    return (VkRayTracingShaderGroupCreateInfoKHR){
        .sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR,
        .type = type,
        .generalShader = general,
        .closestHitShader = closest,
        .anyHitShader = any,
        .intersectionShader = of_box,
    };
}

static VkResult create_from_modules(const struct compare_device *device,
                                    const VkShaderModule modules[STAGE_COUNT],
                                    struct trace_pipeline *pipeline)
{
    const uint32_t none = VK_SHADER_UNUSED_KHR;
    const VkRayTracingShaderGroupTypeKHR
        general = VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR,
        triangles = VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR,
        boxes = VK_RAY_TRACING_SHADER_GROUP_TYPE_PROCEDURAL_HIT_GROUP_KHR;
    const VkRayTracingShaderGroupCreateInfoKHR groups[GROUPS] = {
        group(general, STAGE_GENERATION, none, none, none),
        group(general, STAGE_MISS, none, none, none),
        group(triangles, none, STAGE_CLOSEST_HIT, none, none),
        group(boxes, none, none, none, STAGE_NO_INTERSECTION),
        group(triangles, none, none, STAGE_ANY_HIT, none),
        group(boxes, none, none, STAGE_ANY_HIT_OF_BOX, STAGE_INTERSECTION),
    };
    VkPipelineShaderStageCreateInfo infos[STAGE_COUNT];
    for (int i = 0; i < STAGE_COUNT; i++)
        infos[i] = (VkPipelineShaderStageCreateInfo){
            .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
            .stage = stages[i].stage,
            .module = modules[i],
            .pName = "main",
        };
    const VkRayTracingPipelineCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR,
        .stageCount = STAGE_COUNT,
        .pStages = infos,
        .groupCount = GROUPS,
        .pGroups = groups,
        .maxPipelineRayRecursionDepth = 1,
        .layout = pipeline->layout,
    };
    return device->vk->CreateRayTracingPipelinesKHR(device->handle, VK_NULL_HANDLE, VK_NULL_HANDLE,
                                                    1, &info, NULL, &pipeline->pipeline);
}

static VkResult create_ray_tracing(const struct compare_device *device,
                                   struct trace_pipeline *pipeline)
{
    const struct own_device own = compare_own_device(device);
    VkShaderModule modules[STAGE_COUNT] = {VK_NULL_HANDLE};
    VkResult result = VK_SUCCESS;
    for (int i = 0; i < STAGE_COUNT && result == VK_SUCCESS; i++)
        result = own_module_create(&own, stages[i].words, stages[i].size, &modules[i]);
    if (result == VK_SUCCESS)
        result = create_from_modules(device, modules, pipeline);
    for (int i = 0; i < STAGE_COUNT; i++)
        if (modules[i])
            device->vk->DestroyShaderModule(device->handle, modules[i], NULL);
    return result;
}

static uint32_t align(uint32_t size, uint32_t alignment)
{
    return (size + alignment - 1) / alignment * alignment;
}

enum { HANDLE_MAX = 256 /* bytes; 32 are usual */ };

/* Each part of the table begins at a multiple of the base alignment. */
static VkResult create_table(const struct compare_device *device, struct trace_pipeline *pipeline)
{
    const struct own_device own = compare_own_device(device);
    const uint32_t size = device->group_handle_size;
    const uint32_t stride = align(size, device->group_handle_alignment);
    const uint32_t part = align(HIT_GROUPS * stride, device->group_base_alignment);
    unsigned char handles[GROUPS * HANDLE_MAX];
    if (size == 0 || size > HANDLE_MAX)
        return VK_ERROR_FEATURE_NOT_PRESENT;
    VkResult result = device->vk->GetRayTracingShaderGroupHandlesKHR(
        device->handle, pipeline->pipeline, 0, GROUPS, (size_t)GROUPS * size, handles);
    if (result == VK_SUCCESS)
        result = own_buffer_create(&own,
                                   VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR |
                                       VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                                   4ull * part, true, &pipeline->table);
    if (result != VK_SUCCESS)
        return result;
    uint64_t first = pipeline->table.address + device->group_base_alignment - 1;
    first -= first % device->group_base_alignment;
    unsigned char *bytes = pipeline->table.bytes + (first - pipeline->table.address);
    memcpy(bytes, handles, size);
    memcpy(bytes + part, handles + size, size);
    for (uint32_t i = 0; i < HIT_GROUPS; i++)
        memcpy(bytes + 2ull * part + i * stride, handles + (2ull + i) * size, size);
    pipeline->generation = (VkStridedDeviceAddressRegionKHR){first, stride, stride};
    pipeline->miss = (VkStridedDeviceAddressRegionKHR){first + part, stride, stride};
    pipeline->hit = (VkStridedDeviceAddressRegionKHR){first + 2ull * part, stride,
                                                      (uint64_t)HIT_GROUPS * stride};
    return VK_SUCCESS;
}

/* ---- both kinds */

VkResult trace_pipeline_create(const struct compare_device *device, struct trace_pipeline *pipeline)
{
    *pipeline = (struct trace_pipeline){0};
    VkResult result = create_layouts(device, pipeline);
    if (result == VK_SUCCESS)
        result = device->has_queries ? create_compute(device, pipeline)
                                     : create_ray_tracing(device, pipeline);
    if (result == VK_SUCCESS && !device->has_queries)
        result = create_table(device, pipeline);
    if (result != VK_SUCCESS)
        trace_pipeline_destroy(device, pipeline);
    return result;
}

void trace_pipeline_destroy(const struct compare_device *device, struct trace_pipeline *pipeline)
{
    const struct own_device own = compare_own_device(device);
    own_buffer_free(&own, &pipeline->table);
    if (pipeline->pipeline)
        device->vk->DestroyPipeline(device->handle, pipeline->pipeline, NULL);
    if (pipeline->layout)
        device->vk->DestroyPipelineLayout(device->handle, pipeline->layout, NULL);
    if (pipeline->set_layout)
        device->vk->DestroyDescriptorSetLayout(device->handle, pipeline->set_layout, NULL);
    *pipeline = (struct trace_pipeline){0};
}

void trace_pipeline_record(const struct compare_device *device,
                           const struct trace_pipeline *pipeline, VkCommandBuffer commands,
                           VkDescriptorSet set, const struct trace_constants *constants)
{
    const VkPipelineBindPoint point = device->has_queries ? VK_PIPELINE_BIND_POINT_COMPUTE
                                                          : VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR;
    device->vk->CmdBindPipeline(commands, point, pipeline->pipeline);
    device->vk->CmdBindDescriptorSets(commands, point, pipeline->layout, 0, 1, &set, 0, NULL);
    device->vk->CmdPushConstants(commands, pipeline->layout, VK_SHADER_STAGE_ALL, 0,
                                 sizeof(*constants), constants);
    if (device->has_queries) {
        device->vk->CmdDispatch(commands, (constants->count + GROUP - 1) / GROUP, 1, 1);
        return;
    }
    const VkStridedDeviceAddressRegionKHR callable = {0};
    device->vk->CmdTraceRaysKHR(commands, &pipeline->generation, &pipeline->miss, &pipeline->hit,
                                &callable, constants->count, 1, 1);
}
