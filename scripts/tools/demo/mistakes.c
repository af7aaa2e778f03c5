/* SPDX-License-Identifier: Apache-2.0 */
/* Repeats the scene's builds with planted mistakes. What they record is dropped, never submitted,
 * unless findings.executes is set. */
#include <stdio.h>
#include <string.h>

#include "plants.h"

/* ---- objects that only mistakes use: to make them is valid, to build with them is not */

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

static void plant_objects_create(struct plant_objects *objects, struct gpu *gpu,
                                 const struct scene *scene)
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

static void plant_objects_destroy(struct plant_objects *objects, struct gpu *gpu)
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

/* ---- the mistakes */

/* Record the valid call that `base` names, changed by `plant` unless that is null. */
static bool mistakes_record(struct plant_site *site, enum plant_base base,
                            const struct plant *plant, struct findings *findings)
{
    static void (*const describe[])(const struct scene *, const struct gpu *,
                                    struct build_call *) = {
        [PLANT_BASE_BOTTOM] = scene_describe_bottom,
        [PLANT_BASE_UPDATE] = scene_describe_update,
        [PLANT_BASE_TOP] = scene_describe_top,
    };
    describe[base](site->scene, site->gpu, &site->call);
    site->commands = gpu_begin(site->gpu);
    site->is_possible = true;
    if (plant)
        plant->make(site);
    if (site->is_possible) {
        findings->planted = plant != NULL;
        build_call_record(site->gpu, site->commands, &site->call);
        findings->planted = false;
        if (plant && plant->unmake)
            plant->unmake(site);
    }
    if (findings->executes && plant && site->is_possible)
        gpu_submit(site->gpu, site->commands);
    else
        gpu_drop(site->gpu, site->commands);
    return site->is_possible;
}

static void mistakes_print(const struct plant *plant, const struct findings *findings)
{
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i)
        findings_print(findings->kept[i].text, "    ");
    if (findings_have(findings, plant->vuid))
        printf("  caught: %s\n", plant->vuid);
    else
        printf("  MISSED: %s\n", plant->vuid);
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i)
        if (strcmp(findings->kept[i].id, plant->vuid) != 0)
            printf("  and also: %s\n", findings->kept[i].id);
}

struct mistakes_score mistakes_run(struct gpu *gpu, const struct scene *scene,
                                   struct findings *findings)
{
    struct plant_objects objects;
    plant_objects_create(&objects, gpu, scene);
    struct plant_site site = {.gpu = gpu, .scene = scene, .objects = &objects};

    /* The calls that mistakes start from, unchanged: whatever comes now counts for the scene. */
    for (enum plant_base base = PLANT_BASE_BOTTOM; base <= PLANT_BASE_TOP; ++base)
        mistakes_record(&site, base, NULL, findings);

    struct mistakes_score score = {0};
    for (uint32_t i = 0; i < plant_count; ++i) {
        const struct plant *plant = &plants[i];
        findings_clear(findings);
        printf("\nplanted %u of %u: %s\n", i + 1, plant_count, plant->what);
        if (!mistakes_record(&site, plant->base, plant, findings)) {
            printf("  left out: this device can't express it\n");
            continue;
        }
        mistakes_print(plant, findings);
        ++score.planted;
        score.caught += findings_have(findings, plant->vuid);
    }
    findings_clear(findings);
    plant_objects_destroy(&objects, gpu);
    return score;
}
