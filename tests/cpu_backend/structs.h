/* SPDX-License-Identifier: Apache-2.0 */
/* Vulkan structures, with the sType that the registry names for their type. */
#ifndef ASSAY_TESTS_CPU_BACKEND_STRUCTS_H
#define ASSAY_TESTS_CPU_BACKEND_STRUCTS_H

#include "vulkan_names.h"

/* An initializer, a value and a variable: STRUCT(VkBufferCreateInfo, info, .size = 4). */
#define INIT(type, ...)                                                                            \
    {                                                                                              \
        .sType = TYPE_OF_##type, __VA_ARGS__                                                       \
    }
#define MAKE(type, ...) (type) INIT(type, __VA_ARGS__)
#define STRUCT(type, name, ...) type name = INIT(type, __VA_ARGS__)

#endif
