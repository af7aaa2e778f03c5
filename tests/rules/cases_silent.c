/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include "case.h"
#include "placing.h"

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
