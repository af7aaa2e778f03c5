/* SPDX-License-Identifier: Apache-2.0 */
/* What the strict layer exports: to the loader and to tests. */
#ifndef LOADER_STRICT_LAYER_H
#define LOADER_STRICT_LAYER_H

#include <stdbool.h>
#include <vulkan/vk_layer.h>

#define STRICT_LAYER_NAME "VK_LAYER_ASSAY_TEST_strict"
#define STRICT_LAYER_EXPORT __attribute__((visibility("default")))

STRICT_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *interface);

/* Calls that the application itself may not have made, since the last vkCreateInstance. */
STRICT_LAYER_EXPORT unsigned strict_layer_violations(void);

#endif
