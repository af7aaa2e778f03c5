/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of one built acceleration structure, shared by all that read them.
 *
 * A tree is written once, by whoever made it, and never again: a rebuild or an update makes another
 * one. So whoever holds a reference reads it without a lock, whatever happens to the structure
 * meanwhile. A tree may be made late, when its bytes are first asked for: the work that makes it is
 * kept until then. */
#ifndef ASSAY_CPU_TREES_TREE_H
#define ASSAY_CPU_TREES_TREE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct cpu_tree;

/* How a tree is made late. `make` runs once at most, on the thread that asks first, with no lock
 * held but the tree's own, and calls cpu_tree_allocate(); it may read other trees, none of which
 * may be waiting for this one. `release` is called once, after `make` or instead of it. */
struct cpu_tree_work {
    VkResult (*make)(void *context, struct cpu_tree *tree);
    void (*release)(void *context);
    void *context;
    struct cpu_tree *start; /* of an update: the tree whose shape it keeps, held by the work */
    bool is_top_level;      /* false where that shows only when it is made */
};

/* Return one reference; NULL without memory, and then the work stays with the caller. The first is
 * without bytes until the caller has allocated and written them. */
struct cpu_tree *cpu_tree_create(void);
struct cpu_tree *cpu_tree_create_lazy(const struct cpu_tree_work *work);

struct cpu_tree *cpu_tree_keep(struct cpu_tree *tree); /* returns it */
void cpu_tree_release(struct cpu_tree *tree);          /* NULL: nothing */

/* The tree that an update starts from which goes by this tree's shape: for an update that isn't
 * made yet its own start, whose shape it has, else the tree itself. Takes the reference and returns
 * one.
 */
struct cpu_tree *cpu_tree_start(struct cpu_tree *tree);

/* As far as it is known; takes no lock. */
bool cpu_tree_is_top_level(const struct cpu_tree *tree);

/* For the one that makes it: `size` bytes, aligned for the builder; NULL without memory. */
void *cpu_tree_allocate(struct cpu_tree *tree, uint64_t size);

/* The structure's bytes (build.h), made now if they aren't yet; NULL where that failed. */
const void *cpu_tree_read(struct cpu_tree *tree);

#endif
