/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of one built acceleration structure, reference-counted.
 *
 * A tree is written once; a rebuild or an update makes a new tree. So any thread with a reference
 * reads the tree without a lock, even if the structure is rebuilt or destroyed. A lazy tree holds
 * the work that makes it, and is made when its bytes are first read. */
#ifndef ASSAY_CPU_TREES_TREE_H
#define ASSAY_CPU_TREES_TREE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/bvh/micromap.h"

struct cpu_tree;

/* The work of a lazy tree. `make` runs on the first thread that reads the tree, and calls
 * cpu_tree_allocate(). It runs once more, at the next reading, only if it returns VK_TIMEOUT
 * because the input does not exist yet. The tree's lock is held during `make`. It may read other
 * trees, except those whose own work reads this tree. `release` is called once, after `make` or
 * instead of it. */
struct cpu_tree_work {
    VkResult (*make)(void *context, struct cpu_tree *tree);
    void (*release)(void *context);
    void *context;
    struct cpu_tree *start; /* of an update: the tree that it starts from; the work holds it */
    bool is_top_level;      /* false if the level is unknown until the tree is made */
};

/* Both return one reference; NULL if memory runs out, and then the caller keeps the work. The tree
 * of cpu_tree_create() has no bytes until the caller has allocated and written them. */
struct cpu_tree *cpu_tree_create(void);
struct cpu_tree *cpu_tree_create_lazy(const struct cpu_tree_work *work);

struct cpu_tree *cpu_tree_keep(struct cpu_tree *tree); /* adds a reference, returns `tree` */
void cpu_tree_release(struct cpu_tree *tree);          /* accepts NULL */

/* Returns the tree from which to start an update of `tree`: if `tree` is an update that is not made
 * yet, its own start, which has the same shape; otherwise `tree`. Takes over the reference, and
 * returns one. */
struct cpu_tree *cpu_tree_start(struct cpu_tree *tree);

/* Returns false if the level is unknown. Takes no lock. */
bool cpu_tree_is_top_level(const struct cpu_tree *tree);

/* Allocates `size` bytes, aligned for the builder; the tree owns them. Only the thread that makes
 * the tree may call this. Returns NULL if memory runs out. */
void *cpu_tree_allocate(struct cpu_tree *tree, uint64_t size);

/* Returns the tree's bytes; makes a lazy tree first. Returns NULL if making it has failed, or if
 * its input does not exist yet. */
const void *cpu_tree_read(struct cpu_tree *tree);

/* Sets `value` to the tree's property of a query type. Returns false if the type is unknown. */
bool cpu_property(const void *tree, VkQueryType type, uint64_t *value);

/* ---- The builder's functions for the bytes of a tree, which are those of an acceleration
 * structure or of a micromap. */

static inline uint64_t bytes_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_size(bytes) : builder_size(bytes);
}

static inline uint64_t bytes_compacted_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_compacted_size(bytes) : builder_compacted_size(bytes);
}

static inline enum builder_result bytes_clone(const void *bytes, void *target, uint64_t size)
{
    return micromap_is(bytes) ? micromap_clone(bytes, target, size)
                              : builder_clone(bytes, target, size);
}

static inline enum builder_result bytes_compact(const void *bytes, void *target, uint64_t size)
{
    return micromap_is(bytes) ? micromap_compact(bytes, target, size)
                              : builder_compact(bytes, target, size);
}

static inline uint64_t bytes_serialized_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_serialized_size(bytes) : builder_serialized_size(bytes);
}

static inline enum builder_result
bytes_serialize(const void *bytes, const struct builder_uuids *uuids, void *to, uint64_t size)
{
    return micromap_is(bytes) ? micromap_serialize(bytes, uuids, to, size)
                              : builder_serialize(bytes, uuids, to, size);
}

/* Whether the bytes are those of a bottom-level, or top-level, structure (`type`). */
static inline bool bytes_are_of_level(const void *bytes, VkAccelerationStructureTypeKHR type)
{
    return !micromap_is(bytes) && builder_type(bytes) == type;
}

#endif
