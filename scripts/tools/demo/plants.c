/* SPDX-License-Identifier: Apache-2.0 */
/* The mistakes, one small function each, and their table. */
#include "plants.h"

#define CALL "VUID-vkCmdBuildAccelerationStructuresKHR-"
#define INFO "VUID-VkAccelerationStructureBuildGeometryInfoKHR-"
#define TRIANGLES "VUID-VkAccelerationStructureGeometryTrianglesDataKHR-"
#define AABBS "VUID-VkAccelerationStructureGeometryAabbsDataKHR-"
#define RANGE "VUID-VkAccelerationStructureBuildRangeInfoKHR-"

static VkAccelerationStructureGeometryTrianglesDataKHR *plant_triangles(struct plant_site *site)
{
    return &site->call.geometries[0][0].geometry.triangles;
}

static void plant_dst(struct plant_site *site, uint32_t i, const struct gpu_structure *dst)
{
    site->call.infos[i].dstAccelerationStructure = dst->handle;
}

/* A mistake of one statement. */
#define PLANT(name, statement)                                                                     \
    static void name(struct plant_site *site)                                                      \
    {                                                                                              \
        statement;                                                                                 \
    }

/* ---- scratch */

static void plant_misaligned_scratch(struct plant_site *site)
{
    const VkDeviceSize alignment = site->gpu->limits.minAccelerationStructureScratchOffsetAlignment;
    site->call.infos[0].scratchData.deviceAddress += alignment / 2;
    site->is_possible = alignment > 1;
}

PLANT(plant_common_scratch, site->call.infos[1].scratchData = site->call.infos[0].scratchData)

static void plant_short_scratch(struct plant_site *site)
{
    const VkDeviceSize alignment = site->gpu->limits.minAccelerationStructureScratchOffsetAlignment;
    const struct gpu_buffer *scratch = &site->scene->mesh.scratch;
    const VkDeviceAddress last = scratch->address + scratch->size - 1;
    const VkDeviceAddress address = last / alignment * alignment;
    site->call.infos[0].scratchData.deviceAddress = address;
    site->is_possible =
        last + 1 - address < build_call_sizes(site->gpu, &site->call, 0).buildScratchSize;
}

PLANT(plant_scratch_usage, site->call.infos[0].scratchData.deviceAddress =
                               gpu_scratch_address(site->gpu, &site->objects->no_storage))

static void plant_scratch_in_dst(struct plant_site *site)
{
    plant_dst(site, 0, &site->objects->shared_low);
    site->call.infos[0].scratchData.deviceAddress =
        gpu_scratch_address(site->gpu, &site->objects->shared);
}

/* ---- dst */

PLANT(plant_same_dst,
      site->call.infos[1].dstAccelerationStructure = site->call.infos[0].dstAccelerationStructure)

static void plant_overlapping_dst(struct plant_site *site)
{
    plant_dst(site, 0, &site->objects->shared_low);
    plant_dst(site, 1, &site->objects->shared_next);
    site->is_possible = site->objects->shared_low.size > 256;
}

PLANT(plant_small_dst, plant_dst(site, 0, &site->objects->small))
PLANT(plant_dst_type, plant_dst(site, 0, &site->objects->of_top_type))
PLANT(plant_unbacked_dst, plant_dst(site, 0, &site->objects->unbacked))

/* ---- the build */

PLANT(plant_generic_type, site->call.infos[0].type = VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)
PLANT(plant_both_preferences,
      site->call.infos[0].flags |= VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)

static void plant_mixed_geometries(struct plant_site *site)
{
    struct build_call *call = &site->call;
    call->count = 1;
    call->infos[0].geometryCount = 2;
    call->geometries[0][1] = call->geometries[1][0];
    call->ranges[0][1] = call->ranges[1][0];
    /* Fewer boxes and triangles than the structure was sized for, not more. */
    call->ranges[0][0].primitiveCount = 1;
    call->ranges[0][1].primitiveCount = 1;
    site->is_possible = site->scene->triangle_count > 1;
}

static void plant_two_in_top(struct plant_site *site)
{
    struct build_call *call = &site->call;
    call->infos[0].geometryCount = 2;
    call->geometries[0][1] = call->geometries[0][0];
    call->ranges[0][0].primitiveCount = 1;
    call->ranges[0][1].primitiveCount = 1;
}

PLANT(plant_update_without_src, site->call.infos[0].srcAccelerationStructure = VK_NULL_HANDLE)

/* ---- inputs */

PLANT(plant_vertex_stride, plant_triangles(site)->vertexStride += 2)

static void plant_vertex_format(struct plant_site *site)
{
    const VkFormat format = VK_FORMAT_R32G32B32_UINT;
    VkFormatProperties properties;
    site->gpu->instance_calls.GetPhysicalDeviceFormatProperties(site->gpu->physical, format,
                                                                &properties);
    plant_triangles(site)->vertexFormat = format;
    site->is_possible = !(properties.bufferFeatures &
                          VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR);
}

/* The device is made without VK_KHR_index_type_uint8, which would allow it. */
PLANT(plant_index_type, plant_triangles(site)->indexType = VK_INDEX_TYPE_UINT8_KHR)
PLANT(plant_input_usage,
      plant_triangles(site)->vertexData.deviceAddress = site->objects->no_input.address)

static void plant_beyond_max_vertex(struct plant_site *site)
{
    plant_triangles(site)->indexType = VK_INDEX_TYPE_NONE_KHR;
    plant_triangles(site)->indexData.deviceAddress = 0;
    site->call.ranges[0][0].primitiveCount = 1;
    plant_triangles(site)->maxVertex = 1;
}

PLANT(plant_aabb_stride, site->call.geometries[1][0].geometry.aabbs.stride -= 4)

/* One instance fewer, so that the eight bytes are there to be read. */
static void plant_misaligned_instances(struct plant_site *site)
{
    site->call.geometries[0][0].geometry.instances.data.deviceAddress += 8;
    site->call.ranges[0][0].primitiveCount -= 1;
}

/* ---- the command buffer */

static void plant_render_pass(struct plant_site *site)
{
    site->is_possible = site->objects->pass != VK_NULL_HANDLE;
    if (!site->is_possible)
        return;
    site->gpu->calls.CmdBeginRenderPass(
        site->commands,
        &MAKE(VkRenderPassBeginInfo, .renderPass = site->objects->pass,
              .framebuffer = site->objects->framebuffer, .renderArea.extent = {8, 8}),
        VK_SUBPASS_CONTENTS_INLINE);
}

PLANT(plant_end_render_pass, site->gpu->calls.CmdEndRenderPass(site->commands))
PLANT(plant_ended, TOOL_CALL(site->gpu->calls, EndCommandBuffer, site->commands))

const struct plant plants[] = {
    {"a scratch address off the device's alignment", CALL "pInfos-03710", plant_misaligned_scratch},
    {"two builds of one call share their scratch", CALL "scratchData-03704", plant_common_scratch},
    {"scratch that ends with its buffer before the build is served", CALL "pInfos-12258",
     plant_short_scratch},
    {"scratch in a buffer without storage usage", CALL "pInfos-12261", plant_scratch_usage},
    {"scratch in the memory of the structure being built", CALL "dstAccelerationStructure-03703",
     plant_scratch_in_dst},
    {"one structure built twice in a call", CALL "dstAccelerationStructure-03698", plant_same_dst},
    {"two structures that overlap in one buffer", CALL "dstAccelerationStructure-03702",
     plant_overlapping_dst},
    {"a structure of half the size that the build needs", CALL "pInfos-10126", plant_small_dst},
    {"a BLAS built into a structure created as TLAS", CALL "pInfos-03700", plant_dst_type},
    {"a structure whose memory has been freed", CALL "pInfos-03707", plant_unbacked_dst},
    {"a build of generic type", INFO "type-03654", plant_generic_type},
    {"fast trace and fast build preferred at once", INFO "flags-03796", plant_both_preferences},
    {"triangles and boxes mixed in one BLAS", INFO "type-03792", plant_mixed_geometries},
    {"a TLAS of two geometries", INFO "type-03790", plant_two_in_top, PLANT_BASE_TOP},
    {"an update without a source", CALL "pInfos-04630", plant_update_without_src,
     PLANT_BASE_UPDATE},
    {"a vertex stride of 14 bytes for three floats", TRIANGLES "vertexStride-03735",
     plant_vertex_stride},
    {"vertices in a format for integers", TRIANGLES "vertexFormat-03797", plant_vertex_format},
    {"8-bit indices without the feature for them", TRIANGLES "indexType-03798", plant_index_type},
    {"vertices in a buffer without build-input usage", CALL "geometry-03673", plant_input_usage},
    {"a triangle without indices beyond maxVertex", RANGE "None-10775", plant_beyond_max_vertex},
    {"a box stride of 20 bytes", AABBS "stride-03545", plant_aabb_stride},
    {"instances 8 bytes off their alignment of 16", CALL "pInfos-03715", plant_misaligned_instances,
     PLANT_BASE_TOP},
    {"a build inside a render pass", CALL "renderpass", plant_render_pass, PLANT_BASE_BOTTOM,
     plant_end_render_pass},
    {"a build after vkEndCommandBuffer", CALL "commandBuffer-recording", plant_ended},
};
const uint32_t plant_count = sizeof(plants) / sizeof(*plants);
