/* SPDX-License-Identifier: Apache-2.0 */
/* Objects that only mistakes use. To make them is valid; to build with them is not. */
#include "plants.h"
#include "tests/tools/fail.h"

#define STRUCTURE_USAGE                                                                            \
    (VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |                                      \
     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)

/* An empty render pass: no attachments, one subpass. */
static void plant_objects_create_pass(struct plant_objects *objects, struct gpu *gpu)
{
    if (!(gpu->queue_flags & VK_QUEUE_GRAPHICS_BIT))
        return;
    TOOL_CALL(gpu->calls, CreateRenderPass, gpu->device,
              &MAKE(VkRenderPassCreateInfo, .subpassCount = 1,
                    .pSubpasses = &(VkSubpassDescription){.pipelineBindPoint =
                                                              VK_PIPELINE_BIND_POINT_GRAPHICS}),
              NULL, &objects->pass);
    TOOL_CALL(gpu->calls, CreateFramebuffer, gpu->device,
              &MAKE(VkFramebufferCreateInfo, .renderPass = objects->pass, .width = 8, .height = 8,
                    .layers = 1),
              NULL, &objects->framebuffer);
}

void plant_objects_create(struct plant_objects *objects, struct gpu *gpu, const struct scene *scene)
{
    const VkAccelerationStructureTypeKHR bottom = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    const VkDeviceSize mesh_size = scene->mesh.structure.size;
    const VkDeviceSize field_size = scene->box_field.structure.size;
    const VkDeviceSize scratch_size = scene->mesh.scratch.size;
    *objects = (struct plant_objects){0};

    objects->shared = gpu_create_buffer(gpu, "shared buffer", GPU_PLACE_DEVICE,
                                        STRUCTURE_USAGE | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                        mesh_size + field_size + scratch_size + 256);
    objects->shared_low = gpu_create_structure_in(gpu, "mesh BLAS in the shared buffer", bottom,
                                                  objects->shared.handle, 0, mesh_size);
    objects->shared_next = gpu_create_structure_in(gpu, "box BLAS in the shared buffer", bottom,
                                                   objects->shared.handle, 256, field_size);
    objects->small = gpu_create_structure(gpu, "small BLAS", bottom, mesh_size / 2);
    objects->of_top_type = gpu_create_structure(
        gpu, "TLAS of the mesh's size", VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, mesh_size);
    objects->unbacked = gpu_create_structure(gpu, "BLAS without memory", bottom, mesh_size);
    gpu->calls.FreeMemory(gpu->device, objects->unbacked.buffer.memory, NULL);
    objects->unbacked.buffer.memory = VK_NULL_HANDLE;

    objects->no_input = gpu_create_buffer(gpu, "vertices, not for builds", GPU_PLACE_DEVICE,
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                              VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                                          scene->vertices.size);
    objects->no_storage = gpu_create_buffer(
        gpu, "scratch, not for storage", GPU_PLACE_DEVICE,
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, scratch_size);
    plant_objects_create_pass(objects, gpu);
}

void plant_objects_destroy(struct plant_objects *objects, struct gpu *gpu)
{
    gpu->calls.DestroyFramebuffer(gpu->device, objects->framebuffer, NULL);
    gpu->calls.DestroyRenderPass(gpu->device, objects->pass, NULL);
    gpu_destroy_buffer(gpu, &objects->no_storage);
    gpu_destroy_buffer(gpu, &objects->no_input);
    gpu_destroy_structure(gpu, &objects->unbacked);
    gpu_destroy_structure(gpu, &objects->of_top_type);
    gpu_destroy_structure(gpu, &objects->small);
    gpu_destroy_structure(gpu, &objects->shared_next);
    gpu_destroy_structure(gpu, &objects->shared_low);
    gpu_destroy_buffer(gpu, &objects->shared);
}
