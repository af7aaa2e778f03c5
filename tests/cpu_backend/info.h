/* SPDX-License-Identifier: Apache-2.0 */
/* Vulkan structures by the name of their type: VkFenceCreateInfo info = INFO(FENCE_CREATE_INFO). */
#ifndef ASSAY_TESTS_CPU_BACKEND_INFO_H
#define ASSAY_TESTS_CPU_BACKEND_INFO_H

/* An initializer. The members follow the name: INFO(BUFFER_CREATE_INFO, .size = 4). */
#define INFO(type, ...)                                                                            \
    {                                                                                              \
        .sType = VK_STRUCTURE_TYPE_##type, __VA_ARGS__                                             \
    }

#endif
