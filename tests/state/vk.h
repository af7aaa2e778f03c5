/* SPDX-License-Identifier: Apache-2.0 */
/* Vulkan structures with their sType: vkCreateFence(device, &VK(FenceCreateInfo), NULL, &fence). */
#ifndef ASSAY_TESTS_STATE_VK_H
#define ASSAY_TESTS_STATE_VK_H

#include <vulkan/vulkan.h>

#include "structure_types.h"

/* A structure, whose type is named without Vk; then its other members. */
#define VK(type, ...) ((Vk##type){.sType = STYPE_Vk##type, __VA_ARGS__})

#endif
