/* SPDX-License-Identifier: Apache-2.0 */
/* Reference counts of trees, the work of lazy trees, and properties by query type. */
#include "src/cpu/trees/tree.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "src/platform/aligned.h"
#include "src/platform/threads.h"

static inline uint64_t bytes_reference_count(const void *bytes)
{
    return micromap_is(bytes) ? 0 : builder_reference_count(bytes);
}

struct cpu_tree {
    atomic_uint references;
    void *bytes;
    /* Lazy trees. The lock guards `work`, and `bytes` while is_unmade. */
    pthread_mutex_t lock;
    atomic_bool is_unmade;
    bool is_top_level;         /* valid while is_unmade */
    struct cpu_tree_work work; /* `make` is NULL once it has run */
};

struct cpu_tree *cpu_tree_create(void)
{
    struct cpu_tree *tree = calloc(1, sizeof(*tree));
    if (!tree)
        return NULL;
    atomic_init(&tree->references, 1);
    pthread_mutex_init(&tree->lock, NULL);
    return tree;
}

struct cpu_tree *cpu_tree_create_lazy(const struct cpu_tree_work *work)
{
    struct cpu_tree *tree = cpu_tree_create();
    if (tree) {
        atomic_init(&tree->is_unmade, true);
        tree->is_top_level = work->is_top_level;
        tree->work = *work;
    }
    return tree;
}

struct cpu_tree *cpu_tree_keep(struct cpu_tree *tree)
{
    atomic_fetch_add_explicit(&tree->references, 1, memory_order_relaxed);
    return tree;
}

void cpu_tree_release(struct cpu_tree *tree)
{
    if (!tree || atomic_fetch_sub_explicit(&tree->references, 1, memory_order_acq_rel) != 1)
        return;
    if (tree->work.make)
        tree->work.release(tree->work.context);
    pthread_mutex_destroy(&tree->lock);
    aligned_free(tree->bytes);
    free(tree);
}

void *cpu_tree_allocate(struct cpu_tree *tree, uint64_t size)
{
    const uint64_t mask = BUILDER_ALIGNMENT - 1;
    if (size > SIZE_MAX - mask)
        return NULL;
    tree->bytes = aligned_allocate(BUILDER_ALIGNMENT, (size + mask) & ~mask);
    return tree->bytes;
}

static void make_tree(struct cpu_tree *tree)
{
    struct cpu_tree_work work = tree->work;
    tree->work.make = NULL;
    VkResult result = work.make(work.context, tree);
    if (result == VK_TIMEOUT) {
        tree->work = work;
        return;
    }
    if (result != VK_SUCCESS) {
        aligned_free(tree->bytes);
        tree->bytes = NULL;
    }
    work.release(work.context);
    atomic_store_explicit(&tree->is_unmade, false, memory_order_release);
}

const void *cpu_tree_read(struct cpu_tree *tree)
{
    if (!atomic_load_explicit(&tree->is_unmade, memory_order_acquire))
        return tree->bytes;
    pthread_mutex_lock(&tree->lock);
    if (tree->work.make)
        make_tree(tree);
    const void *bytes = tree->bytes;
    pthread_mutex_unlock(&tree->lock);
    return bytes;
}

struct cpu_tree *cpu_tree_start(struct cpu_tree *tree)
{
    struct cpu_tree *start = NULL;
    if (atomic_load_explicit(&tree->is_unmade, memory_order_acquire)) {
        pthread_mutex_lock(&tree->lock);
        if (tree->work.make && tree->work.start)
            start = cpu_tree_keep(tree->work.start);
        pthread_mutex_unlock(&tree->lock);
    }
    if (!start)
        return tree;
    cpu_tree_release(tree);
    return start;
}

bool cpu_tree_is_top_level(const struct cpu_tree *tree)
{
    if (atomic_load_explicit(&tree->is_unmade, memory_order_acquire))
        return tree->is_top_level;
    return tree->bytes &&
           bytes_are_of_level(tree->bytes, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
}

/* ---- properties */

bool cpu_property(const void *tree, VkQueryType type, uint64_t *value)
{
    switch (type) {
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV:
    case VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT:
        *value = bytes_compacted_size(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR:
    case VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT:
        *value = bytes_serialized_size(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR:
        *value = bytes_reference_count(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR:
        *value = bytes_size(tree);
        return true;
    default:
        return false;
    }
}
