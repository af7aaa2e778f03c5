/* SPDX-License-Identifier: Apache-2.0 */
/* Which acceleration structures and storage buffers the descriptor sets of a device hold, so that
 * the hazard check knows what the shaders of a command may access. Sets without such descriptors
 * have no record, and records end with the set or its pool. Has a lock of its own. */
#ifndef ASSAY_STATE_RESOURCES_DESCRIPTORS_H
#define ASSAY_STATE_RESOURCES_DESCRIPTORS_H

#include <stdatomic.h>
#include <vulkan/vulkan_core.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/base/unknown.h"

/* What sets hold beyond so many descriptors is unknown. */
enum { HELD_MAX = 1024 };

struct held_descriptor {
    uint32_t binding, element;
    bool is_buffer;      /* else a structure */
    bool must_be_valid;  /* if a shader uses it statically: its binding has one descriptor, and is
                          * not partially bound */
    uint64_t handle;     /* 0: a null descriptor */
    VkDeviceSize offset; /* of a buffer */
    VkDeviceSize range;
};

struct set_layout;
struct held_pool;

/* What one set holds. All-zero: nothing. */
struct held_set {
    const struct set_layout *layout; /* NULL: unknown */
    struct held_pool *pool;
    struct held_set *previous, *next; /* in the pool */
    uint64_t handle;
    bool is_unknown; /* it may hold anything */
    struct held_descriptor *items;
    uint32_t count, capacity;
};

/* All-zero: no set exists. */
struct descriptor_sets {
    struct reader_lock lock;
    struct handle_table layouts, sets, pools;
    struct unknown unknown; /* memory ran out: sets without a record may hold anything */
};

void descriptor_sets_end(struct descriptor_sets *sets);

/* Returns false if sets of the layout may hold more than HELD_MAX descriptors. */
bool descriptor_sets_note_layout(struct descriptor_sets *sets, VkDescriptorSetLayout layout,
                                 const VkDescriptorSetLayoutCreateInfo *info);
void descriptor_sets_forget_layout(struct descriptor_sets *sets, VkDescriptorSetLayout layout);

void descriptor_sets_allocate(struct descriptor_sets *sets, const VkDescriptorSetAllocateInfo *info,
                              const VkDescriptorSet *allocated);
void descriptor_sets_free(struct descriptor_sets *sets, uint32_t count,
                          const VkDescriptorSet *freed);
/* All sets of the pool end. */
void descriptor_sets_end_pool(struct descriptor_sets *sets, VkDescriptorPool pool);

void descriptor_sets_write(struct descriptor_sets *sets, const VkWriteDescriptorSet *write);
void descriptor_sets_copy(struct descriptor_sets *sets, const VkCopyDescriptorSet *copy);
/* What the set holds is unknown from now on. */
void descriptor_sets_forget_contents(struct descriptor_sets *sets, VkDescriptorSet set);

/* Finds the descriptors of a binding, `count` at most. Returns how many there are; UINT32_MAX: that
 * is unknown. */
uint32_t descriptor_sets_find(struct descriptor_sets *sets, uint64_t set, uint32_t binding,
                              struct held_descriptor *found, uint32_t count);

/* ---- a set that a command buffer owns: pushed descriptors */

void held_set_write(struct held_set *held, const VkWriteDescriptorSet *write);
uint32_t held_set_find(const struct held_set *held, uint32_t binding, struct held_descriptor *found,
                       uint32_t count);
/* Leaves an empty set. */
void held_set_clear(struct held_set *held);

#endif
