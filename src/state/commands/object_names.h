/* SPDX-License-Identifier: Apache-2.0 */
/* Debug names of objects, set through VK_EXT_debug_utils or VK_EXT_debug_marker. */
#ifndef ASSAY_STATE_COMMANDS_OBJECT_NAMES_H
#define ASSAY_STATE_COMMANDS_OBJECT_NAMES_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/commands/label_stack.h"

struct object_names; /* one per device; has its own lock */

VkResult object_names_create(struct object_names **out);
void object_names_destroy(struct object_names *names);

/* Returns the type's name in the specification, such as VkBuffer. Returns NULL for types that
 * messages never name. */
const char *object_type_name(VkObjectType type);

/* Sets or, if `name` is NULL or "", removes an object's name. Remove the name when the object is
 * destroyed. Ignores types that messages never name. If memory runs out, the object has no name. */
void object_names_set(struct object_names *names, VkObjectType type, uint64_t handle,
                      const char *name);

/* Copies the name into `buffer`, cut to `size` bytes including the terminator; "" if there is no
 * name. Returns the copied length. */
size_t object_names_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size);

/* Copies the name without waiting, for a signal handler: "" if another thread uses the names. */
size_t object_names_try_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                            char *buffer, size_t size);

#endif
