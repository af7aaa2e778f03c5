/* SPDX-License-Identifier: Apache-2.0 */
#include "src/state/resources/descriptors.h"
#include "src/base/handle.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/base/chain.h"
#include "src/base/readable.h"

/* ---- layouts */

/* The bindings of structures and storage buffers. Shared by the sets of the layout. */
struct set_layout {
    atomic_uint references;
    bool is_unknown; /* what sets hold may change after they are bound, or is not followed */
    uint32_t count;
    struct layout_binding {
        uint32_t binding, count;
        bool is_partial;
    } bindings[];
};

struct held_pool {
    struct held_set *first;
};

static void release_layout(const struct set_layout *layout)
{
    struct set_layout *shared = (struct set_layout *)layout;
    if (shared && atomic_fetch_sub(&shared->references, 1) == 1)
        free(shared);
}

static void drop_layout(void *layout)
{
    release_layout(layout);
}

static bool is_followed(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR ||
           type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ||
           type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;
}

/* Descriptors that may be of structures or buffers, and are not followed. */
static bool is_opaque(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_NV ||
           type == VK_DESCRIPTOR_TYPE_MUTABLE_EXT;
}

/* Returns the flags of a binding. Flags that cannot be read count as all flags. */
static VkDescriptorBindingFlags flags_of(const VkDescriptorSetLayoutCreateInfo *info,
                                         uint32_t binding)
{
    const VkDescriptorSetLayoutBindingFlagsCreateInfo *flags =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO);
    if (!flags || !flags->bindingCount)
        return 0;
    if (binding >= flags->bindingCount ||
        !readable(readable_cache_of_thread(), flags->pBindingFlags,
                  flags->bindingCount * sizeof(*flags->pBindingFlags)))
        return VK_DESCRIPTOR_BINDING_FLAG_BITS_MAX_ENUM;
    return flags->pBindingFlags[binding];
}

static void add_binding(struct set_layout *layout, const VkDescriptorSetLayoutCreateInfo *info,
                        uint32_t i)
{
    const VkDescriptorSetLayoutBinding *binding = &info->pBindings[i];
    const VkDescriptorBindingFlags flags = flags_of(info, i);
    layout->is_unknown |= is_opaque(binding->descriptorType);
    if (!is_followed(binding->descriptorType))
        return;
    layout->is_unknown |= (flags & VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT) != 0;
    layout->bindings[layout->count++] =
        (struct layout_binding){binding->binding, binding->descriptorCount,
                                (flags & VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT) != 0};
}

/* Takes over the record of a handle, which may be NULL: then the handle is removed. Returns the
 * earlier record. */
static void *replace(struct descriptor_sets *sets, struct handle_table *table, uint64_t handle,
                     void *record)
{
    void *old = handle_table_remove(table, handle);
    if (record && !handle_table_set(table, handle, record)) {
        unknown_set(&sets->unknown, UNKNOWN_DESCRIPTORS);
        free(record);
    }
    return old;
}

/* A layout without such bindings has a record, too: without it the sets would be unknown. */
bool descriptor_sets_note_layout(struct descriptor_sets *sets, VkDescriptorSetLayout handle,
                                 const VkDescriptorSetLayoutCreateInfo *info)
{
    struct set_layout *layout =
        calloc(1, sizeof(*layout) + info->bindingCount * sizeof(layout->bindings[0]));
    uint64_t total = 0;
    if (!layout)
        unknown_set(&sets->unknown, UNKNOWN_DESCRIPTORS);
    for (uint32_t i = 0; layout && i < info->bindingCount; i++)
        add_binding(layout, info, i);
    for (uint32_t i = 0; layout && i < layout->count; i++)
        total += layout->bindings[i].count;
    if (layout) {
        atomic_init(&layout->references, 1);
        layout->is_unknown |= total > HELD_MAX;
    }
    reader_lock_write(&sets->lock);
    struct set_layout *old = replace(sets, &sets->layouts, handle_number(handle), layout);
    reader_lock_write_done(&sets->lock);
    release_layout(old);
    return total <= HELD_MAX;
}

void descriptor_sets_forget_layout(struct descriptor_sets *sets, VkDescriptorSetLayout handle)
{
    reader_lock_write(&sets->lock);
    struct set_layout *old = handle_table_remove(&sets->layouts, handle_number(handle));
    reader_lock_write_done(&sets->lock);
    release_layout(old);
}

static const struct layout_binding *find_binding(const struct set_layout *layout, uint32_t binding)
{
    for (uint32_t i = 0; layout && i < layout->count; i++)
        if (layout->bindings[i].binding == binding)
            return &layout->bindings[i];
    return NULL;
}

/* An array of descriptors goes on in the next binding. Returns false if that is none that is
 * followed. */
static bool find_place(const struct set_layout *layout, uint32_t *binding, uint32_t *element)
{
    const struct layout_binding *found;
    while ((found = find_binding(layout, *binding)) && *element >= found->count) {
        *element -= found->count;
        ++*binding;
    }
    return found;
}

/* ---- sets */

/* Call with the lock for writing. */
static void remove_set(struct descriptor_sets *sets, struct held_set *held)
{
    if (held->next)
        held->next->previous = held->previous;
    if (held->previous)
        held->previous->next = held->next;
    else
        held->pool->first = held->next;
    handle_table_remove(&sets->sets, held->handle);
    release_layout(held->layout);
    free(held->items);
    free(held);
}

static void drop_set(void *record)
{
    struct held_set *held = record;
    release_layout(held->layout);
    free(held->items);
    free(held);
}

void descriptor_sets_end(struct descriptor_sets *sets)
{
    handle_table_drop(&sets->sets, drop_set);
    handle_table_drop(&sets->pools, free);
    handle_table_drop(&sets->layouts, drop_layout);
}

static struct held_pool *find_pool(struct descriptor_sets *sets, VkDescriptorPool handle)
{
    struct held_pool *pool = handle_table_find(&sets->pools, handle_number(handle));
    if (pool)
        return pool;
    pool = calloc(1, sizeof(*pool));
    if (pool && handle_table_set(&sets->pools, handle_number(handle), pool))
        return pool;
    free(pool);
    return NULL;
}

/* A set of an unknown layout may hold anything. */
static bool add_set(struct descriptor_sets *sets, VkDescriptorPool pool_handle,
                    struct set_layout *layout, uint64_t handle)
{
    struct held_pool *pool = find_pool(sets, pool_handle);
    struct held_set *held = pool ? calloc(1, sizeof(*held)) : NULL;
    if (!held || !handle_table_set(&sets->sets, handle, held)) {
        free(held);
        return false;
    }
    if (layout)
        atomic_fetch_add(&layout->references, 1);
    *held = (struct held_set){.layout = layout,
                              .pool = pool,
                              .next = pool->first,
                              .handle = handle,
                              .is_unknown = !layout || layout->is_unknown};
    if (pool->first)
        pool->first->previous = held;
    pool->first = held;
    return true;
}

void descriptor_sets_allocate(struct descriptor_sets *sets, const VkDescriptorSetAllocateInfo *info,
                              const VkDescriptorSet *allocated)
{
    reader_lock_write(&sets->lock);
    for (uint32_t i = 0; i < info->descriptorSetCount; i++) {
        const uint64_t handle = handle_number(allocated[i]);
        struct set_layout *layout =
            handle_table_find(&sets->layouts, handle_number(info->pSetLayouts[i]));
        struct held_set *old = handle_table_find(&sets->sets, handle);
        const bool needs_record = !layout || layout->count || layout->is_unknown;
        if (old)
            remove_set(sets, old);
        if (needs_record && !add_set(sets, info->descriptorPool, layout, handle))
            unknown_set(&sets->unknown, UNKNOWN_DESCRIPTORS);
    }
    reader_lock_write_done(&sets->lock);
}

void descriptor_sets_free(struct descriptor_sets *sets, uint32_t count,
                          const VkDescriptorSet *freed)
{
    reader_lock_write(&sets->lock);
    for (uint32_t i = 0; i < count; i++) {
        struct held_set *held = handle_table_find(&sets->sets, handle_number(freed[i]));
        if (held)
            remove_set(sets, held);
    }
    reader_lock_write_done(&sets->lock);
}

void descriptor_sets_end_pool(struct descriptor_sets *sets, VkDescriptorPool handle)
{
    reader_lock_write(&sets->lock);
    struct held_pool *pool = handle_table_remove(&sets->pools, handle_number(handle));
    while (pool && pool->first)
        remove_set(sets, pool->first);
    reader_lock_write_done(&sets->lock);
    free(pool);
}

/* ---- what a set holds */

/* Returns the descriptor there, a new one if there is none. Returns NULL if memory runs out. */
static struct held_descriptor *hold(struct held_set *held, uint32_t binding, uint32_t element)
{
    for (uint32_t i = 0; i < held->count; i++)
        if (held->items[i].binding == binding && held->items[i].element == element)
            return &held->items[i];
    if (held->count == HELD_MAX || !ARRAY_HAS_ROOM(held->items, held->count, held->capacity))
        return NULL;
    return &held->items[held->count++];
}

static void set_item(struct held_set *held, uint32_t binding, uint32_t element,
                     const struct held_descriptor *value)
{
    const bool has_layout = held->layout;
    if (has_layout && !find_place(held->layout, &binding, &element)) {
        held->is_unknown = true;
        return;
    }
    struct held_descriptor *item = hold(held, binding, element);
    const struct layout_binding *of = find_binding(held->layout, binding);
    held->is_unknown |= !item;
    if (!item)
        return;
    *item = *value;
    item->binding = binding;
    item->element = element;
    item->must_be_valid = of && of->count == 1 && !of->is_partial;
}

/* Reads an element of a write. Returns false if it is not readable. */
static bool read_item(const VkWriteDescriptorSet *write, uint32_t i, struct held_descriptor *item)
{
    const VkWriteDescriptorSetAccelerationStructureKHR *structures =
        chain_find(write->pNext, VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR);
    struct readable_cache *cache = readable_cache_of_thread();
    *item = (struct held_descriptor){.is_buffer = true, .range = VK_WHOLE_SIZE};
    if (write->descriptorType == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR) {
        if (!structures || i >= structures->accelerationStructureCount ||
            !readable(cache, &structures->pAccelerationStructures[i],
                      sizeof(*structures->pAccelerationStructures)))
            return false;
        item->is_buffer = false;
        item->handle = handle_number(structures->pAccelerationStructures[i]);
        return true;
    }
    if (!readable(cache, &write->pBufferInfo[i], sizeof(*write->pBufferInfo)))
        return false;
    item->handle = handle_number(write->pBufferInfo[i].buffer);
    if (write->descriptorType == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) {
        item->offset = write->pBufferInfo[i].offset;
        item->range = write->pBufferInfo[i].range;
    }
    return true;
}

/* How far an array of descriptors goes on in the next binding is unknown without a layout. */
void held_set_write(struct held_set *held, const VkWriteDescriptorSet *write)
{
    struct held_descriptor item;
    held->is_unknown |= is_opaque(write->descriptorType);
    if (!is_followed(write->descriptorType))
        return;
    held->is_unknown |= !held->layout && write->descriptorCount > 1;
    for (uint32_t i = 0; i < write->descriptorCount && !held->is_unknown; i++) {
        held->is_unknown |= !read_item(write, i, &item);
        if (!held->is_unknown)
            set_item(held, write->dstBinding, write->dstArrayElement + i, &item);
    }
}

uint32_t held_set_find(const struct held_set *held, uint32_t binding, struct held_descriptor *found,
                       uint32_t count)
{
    uint32_t all = 0;
    for (uint32_t i = 0; i < held->count && !held->is_unknown; i++) {
        if (held->items[i].binding != binding)
            continue;
        if (all < count)
            found[all] = held->items[i];
        all++;
    }
    return held->is_unknown || !all ? UINT32_MAX : all;
}

void held_set_clear(struct held_set *held)
{
    free(held->items);
    *held = (struct held_set){.handle = 0};
}

/* ---- updates */

void descriptor_sets_write(struct descriptor_sets *sets, const VkWriteDescriptorSet *write)
{
    if (!is_followed(write->descriptorType) && !is_opaque(write->descriptorType))
        return;
    reader_lock_write(&sets->lock);
    struct held_set *held = handle_table_find(&sets->sets, handle_number(write->dstSet));
    if (held)
        held_set_write(held, write);
    reader_lock_write_done(&sets->lock);
}

static const struct held_descriptor *find_item(const struct held_set *held, uint32_t binding,
                                               uint32_t element)
{
    if (!find_place(held->layout, &binding, &element))
        return NULL;
    for (uint32_t i = 0; i < held->count; i++)
        if (held->items[i].binding == binding && held->items[i].element == element)
            return &held->items[i];
    return NULL;
}

/* What is copied from a set without a record is of another type. A descriptor that was never
 * written may not be copied. */
void descriptor_sets_copy(struct descriptor_sets *sets, const VkCopyDescriptorSet *copy)
{
    reader_lock_write(&sets->lock);
    struct held_set *from = handle_table_find(&sets->sets, handle_number(copy->srcSet));
    struct held_set *to = handle_table_find(&sets->sets, handle_number(copy->dstSet));
    for (uint32_t i = 0; from && to && !to->is_unknown && i < copy->descriptorCount; i++) {
        const struct held_descriptor *item =
            find_item(from, copy->srcBinding, copy->srcArrayElement + i);
        const struct held_descriptor copied = item ? *item : (struct held_descriptor){.handle = 0};
        to->is_unknown |= from->is_unknown;
        if (item && !to->is_unknown)
            set_item(to, copy->dstBinding, copy->dstArrayElement + i, &copied);
        else if (find_binding(to->layout, copy->dstBinding))
            to->is_unknown = true;
    }
    reader_lock_write_done(&sets->lock);
}

void descriptor_sets_forget_contents(struct descriptor_sets *sets, VkDescriptorSet set)
{
    reader_lock_write(&sets->lock);
    struct held_set *held = handle_table_find(&sets->sets, handle_number(set));
    if (held)
        held->is_unknown = true;
    reader_lock_write_done(&sets->lock);
}

uint32_t descriptor_sets_find(struct descriptor_sets *sets, uint64_t set, uint32_t binding,
                              struct held_descriptor *found, uint32_t count)
{
    const unsigned stripe = reader_lock_enter(&sets->lock);
    const struct held_set *held = handle_table_find(&sets->sets, set);
    const uint32_t all = held && !unknown_is_set(&sets->unknown)
                             ? held_set_find(held, binding, found, count)
                             : UINT32_MAX;
    reader_lock_leave(&sets->lock, stripe);
    return all;
}
