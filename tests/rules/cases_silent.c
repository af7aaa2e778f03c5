/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include <string.h>

#include "case.h"
#include "placing.h"

static void update_deserialized(struct scene *scene)
{
    const VkAccelerationStructureKHR accel = scene_accel_for(scene, REFIT);
    const bool is_host = scene->command == COMMAND_HOST;
    static const uint8_t bytes[4096];
    STRUCT(VkCopyMemoryToAccelerationStructureInfoKHR, info, .src.hostAddress = bytes, .dst = accel,
           .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR);
    if (!is_host)
        info.src.deviceAddress = scene_buffer(scene, sizeof(bytes), INPUT_USAGE).address;
    if (is_host)
        scene->vk->CopyMemoryToAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE,
                                                        &info);
    else
        scene->vk->CmdCopyMemoryToAccelerationStructureKHR(scene->command_buffer, &info);
    scene->infos[REFIT].srcAccelerationStructure = accel;
    scene->infos[REFIT].dstAccelerationStructure = accel;
}

/* A compacted structure is smaller than a build of its shape needs, and may be updated. */
static void update_compacted(struct scene *scene)
{
    const VkDeviceSize size = place_size(scene, REFIT);
    const struct test_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR copy = scene_accel_in(
        scene, &buffer, 0, size / 2, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    scene_copy(scene, scene->infos[REFIT].dstAccelerationStructure, copy,
               VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    scene->infos[REFIT].srcAccelerationStructure = copy;
    scene->infos[REFIT].dstAccelerationStructure = copy;
}

/* All input in one buffer, and all scratch in another. */
static void share_one_buffer(struct scene *scene)
{
    const struct test_buffer input = scene_buffer(scene, 65536, INPUT_USAGE);
    const struct test_buffer scratch = scene_buffer(scene, PLACE_SIZE, SCRATCH_USAGE);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &scene->geometries[INDEXED][0].geometry.triangles;
    VkDeviceSize offset = 0;

    triangles->vertexData.deviceAddress = scene_address(scene, &input, 0);
    triangles->indexData.deviceAddress = scene_address(scene, &input, 256);
    triangles->transformData.deviceAddress = scene_address(scene, &input, 512);
    for (uint32_t build = 0; build < SCENE_BASE_BUILDS; build++) {
        place_scratch(scene, build, &scratch, offset);
        offset += place_scratch_offset(scene, scene_scratch_size(scene, build), BEHIND);
    }
}

/* An address that a buffer was created to have again need not be retrieved again. The buffer goes
 * with the device. */
static void read_from_replayed_address(struct scene *scene)
{
    const STRUCT(VkBufferOpaqueCaptureAddressCreateInfo, replayed,
                 .opaqueCaptureAddress = 0x123450000);
    const STRUCT(VkBufferCreateInfo, info, .pNext = &replayed,
                 .flags = VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT, .size = 65536,
                 .usage = INPUT_USAGE);
    VkBuffer buffer;
    if (scene->vk->CreateBuffer(scene->fixture->device, &info, NULL, &buffer) == VK_SUCCESS)
        scene->TRIANGLES(INDEXED, 0).vertexData.deviceAddress = replayed.opaqueCaptureAddress;
}
#include "silent.inc"
