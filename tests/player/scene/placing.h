/* SPDX-License-Identifier: Apache-2.0 */
/* Places structures and scratch of several builds in shared memory, and pointers at unreadable
 * pages. */
#ifndef ASSAY_TESTS_PLAYER_SCENE_PLACING_H
#define ASSAY_TESTS_PLAYER_SCENE_PLACING_H

#include "tests/player/scene/scene.h"

enum { PLACE_SIZE = 1 << 20, PLACE_FAR = 1 << 16 };

/* Usage of a buffer that can hold structures and scratch. */
#define PLACE_USAGE (ACCEL_USAGE | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)

VkBufferUsageFlags place_usage(const struct scene *scene); /* with micromaps, too */

/* PLACE_SIZE bytes for anything. */
struct device_buffer place_buffer(struct scene *scene);

/* The size of a structure for the build: what the build uses of a larger one, too. */
VkDeviceSize place_size(const struct scene *scene, uint32_t build);

/* Where something is put that may overlap `size` bytes or a structure: at their beginning, at the
 * last aligned offset within them, or at the first one behind them. Scratch has the device's
 * alignment. */
enum place { AT_BEGINNING, WITHIN, BEHIND };
VkDeviceSize place_offset(VkDeviceSize size, enum place place);
VkDeviceSize place_scratch_offset(const struct scene *scene, VkDeviceSize size, enum place place);

/* Gives a build a new dst, src or scratch at an offset of a buffer. */
void place_dst(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
               VkDeviceSize offset);
void place_src(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
               VkDeviceSize offset);
void place_scratch(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
                   VkDeviceSize offset);

/* Gives a build primitives until its structure is larger than that, and scratch to match. */
void place_grow(struct scene *scene, uint32_t build, VkDeviceSize size);

/* A buffer in memory that the host can't see; or in memory that it can, of so many instances. */
struct device_buffer place_device_local_buffer(struct scene *scene);
struct device_buffer place_buffer_of_instances(struct scene *scene, uint32_t device_mask);

/* A structure for the build by vkCreateAccelerationStructure2KHR. */
VkAccelerationStructureKHR place_accel_by_address(struct scene *scene, uint32_t build);

/* ---- bad pointers ---- */

/* A page that cannot be read. */
void *unreadable_page(void);
/* `size` bytes that end where an unreadable page begins, zeroed; kept to the end of the program. */
void *bytes_before_unreadable_page(size_t size);
/* Makes the pointer lead to a copy of so many of its bytes that ends there. */
void put_at_edge(struct scene *scene, void *pointer, size_t size);

#endif
