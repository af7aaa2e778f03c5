/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of trees, which queries read. */
#ifndef ASSAY_CPU_TREES_PROPERTY_H
#define ASSAY_CPU_TREES_PROPERTY_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* What a query of the type reads from a tree; false for another type. */
bool cpu_property(const void *tree, VkQueryType type, uint64_t *value);

#endif
