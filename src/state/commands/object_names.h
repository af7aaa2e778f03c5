/* SPDX-License-Identifier: Apache-2.0 */
/* Debug names of objects, set through VK_EXT_debug_utils or VK_EXT_debug_marker. A name belongs to
 * an object: another object that gets the handle later has a name of its own. The names of the last
 * OBJECT_NAMES_PAST named objects that were destroyed are kept for messages about them. */
#ifndef ASSAY_STATE_COMMANDS_OBJECT_NAMES_H
#define ASSAY_STATE_COMMANDS_OBJECT_NAMES_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/commands/label_stack.h"

enum { OBJECT_NAMES_PAST = 256 };

struct object_names; /* one per device; has its own lock */

VkResult object_names_create(struct object_names **out);
void object_names_destroy(struct object_names *names);

/* Returns the type's name in the specification, such as VkBuffer. Returns NULL for types that
 * messages never name. */
const char *object_type_name(VkObjectType type);

/* Sets or, if `name` is NULL or "", removes the name of a live object. Ignores types that messages
 * never name. If memory runs out, the object has no name. */
void object_names_set(struct object_names *names, VkObjectType type, uint64_t handle,
                      const char *name);
/* Sets the name of an object whose id is known, such as a command buffer. */
void object_names_set_of(struct object_names *names, VkObjectType type, uint64_t handle,
                         uint64_t id, const char *name);

/* The object is destroyed. `id`: as resources_find_id() returned; 0: it has none, or it is known
 * since object_names_set_of(). */
void object_names_end(struct object_names *names, VkObjectType type, uint64_t handle, uint64_t id);

/* Copies the name of the live object into `buffer`, cut to `size` bytes including the terminator;
 * "" if it has no name. Returns the copied length. */
size_t object_names_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size);
/* Copies the name that object_names_set_of() gave to an object, which may be destroyed. */
size_t object_names_get_of(const struct object_names *names, VkObjectType type, uint64_t handle,
                           uint64_t id, char *buffer, size_t size);
/* The same for a destroyed object; `id` 0: the last one that had the handle. */
size_t object_names_get_past(const struct object_names *names, VkObjectType type, uint64_t handle,
                             uint64_t id, char *buffer, size_t size);

/* Copies the name without waiting, for a signal handler: "" if another thread uses the names. */
size_t object_names_try_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                            char *buffer, size_t size);

#endif
