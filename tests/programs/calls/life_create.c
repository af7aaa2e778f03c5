/* SPDX-License-Identifier: Apache-2.0 */
/* Creation of structures and micromaps. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

/* Creates the object of the call in another buffer. */
static void create_in(struct scene *scene, const struct device_buffer *buffer)
{
    scene->life.create.buffer = scene->life.create_micromap.buffer = buffer->handle;
    scene->life.create_at.addressRange.address = buffer->address;
}

static void chain_captured_data(struct scene *scene)
{
    static const uint64_t data[8];
    static const VkOpaqueCaptureDescriptorDataCreateInfoEXT captured = {
        .sType = VK_STRUCTURE_TYPE_OPAQUE_CAPTURE_DESCRIPTOR_DATA_CREATE_INFO_EXT,
        .opaqueCaptureDescriptorData = data};
    scene->life.create.pNext = scene->life.create_at.pNext = &captured;
}

#include "life_create.inc"
