/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

/* The first bytes of a buffer of a usage. */
static VkDeviceAddress address_with(struct scene *scene, VkBufferUsageFlags usage)
{
    return scene_buffer(scene, 1 << 16, usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT).address;
}

#include "cluster_builds.inc"
#include "cluster_inputs.inc"
#include "partition_builds.inc"
#include "partition_descriptors.inc"
