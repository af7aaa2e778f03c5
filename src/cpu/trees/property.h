/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of trees, for queries. */
#ifndef ASSAY_CPU_TREES_PROPERTY_H
#define ASSAY_CPU_TREES_PROPERTY_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Sets `value` to the tree's property of a query type. Returns false if the type is unknown. */
bool cpu_property(const void *tree, VkQueryType type, uint64_t *value);

#endif
