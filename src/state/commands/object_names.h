/* SPDX-License-Identifier: Apache-2.0 */
/* Debug names of objects, as VK_EXT_debug_utils and VK_EXT_debug_marker give them. */
#ifndef ASSAY_STATE_COMMANDS_OBJECT_NAMES_H
#define ASSAY_STATE_COMMANDS_OBJECT_NAMES_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/commands/label_stack.h"

struct object_names; /* one per device; has its own lock */

VkResult object_names_create(struct object_names **out);
void object_names_destroy(struct object_names *names);

/* The type as the specification spells it, such as VkBuffer; NULL for types that messages never
 * name. */
const char *object_type_name(VkObjectType type);

/* A name of NULL or "" removes it, as has to be done when the object is destroyed. Names of types
 * that messages never name are not kept. Out of memory: the object stays without a name. */
void object_names_set(struct object_names *names, VkObjectType type, uint64_t handle,
                      const char *name);

/* Copies the name into `buffer`, cut to `size` bytes with its terminator; "" where there is none.
 * Returns the length of what was copied. */
size_t object_names_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size);

#endif
