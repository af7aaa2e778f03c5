/* SPDX-License-Identifier: Apache-2.0 */
/* The comments name the lines. */
#include "record_build.h"

__attribute__((noipa)) VkResult record_build(const struct scene *scene)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *infos = scene->infos_argument;
    const VkDeviceAddress *addresses = scene->indirect_addresses_argument;
    const uint32_t *strides = scene->indirect_strides_argument;
    const uint32_t *const *counts = scene->counts_argument;
    const struct scene_nv *nv = &scene->nv;
    VkCommandBuffer to = scene->command_buffer;
    uint32_t count = scene->info_count;
    VkResult result = VK_SUCCESS;
    /* clang-format off */
    switch (scene->command) {
    case COMMAND_DEVICE:
        scene->vk->CmdBuildAccelerationStructuresKHR(to, count, infos, scene->ranges_argument); /* device */
        break;
    case COMMAND_INDIRECT:
        scene->vk->CmdBuildAccelerationStructuresIndirectKHR(to, count, infos, addresses, strides, counts); /* indirect */
        break;
    case COMMAND_HOST:
        result = scene->vk->BuildAccelerationStructuresKHR(scene->device, scene->deferred_operation, count, infos, scene->ranges_argument); /* host */
        break;
    default:
        scene->vk->CmdBuildAccelerationStructureNV(to, nv->info_argument, nv->instance_data, nv->instance_offset, nv->update, nv->dst, nv->src, nv->scratch, nv->scratch_offset); /* nv */
    }
    /* clang-format on */
    __asm__ volatile("" ::: "memory"); /* no tail call */
    return result;
}
