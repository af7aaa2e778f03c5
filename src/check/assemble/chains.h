/* SPDX-License-Identifier: Apache-2.0 */
/* The pNext chains of geometries: which structures they may contain, and whether these are
 * readable. */
#ifndef ASSAY_CHECK_ASSEMBLE_CHAINS_H
#define ASSAY_CHECK_ASSEMBLE_CHAINS_H

#include "src/check/walk/context.h"
#include "src/view/micromap_view.h"

/* Longer chains are cyclic or invalid. */
enum { CHAIN_MAX = 64 };

/* Returns the size of a structure of a known type, or that of VkBaseInStructure. */
size_t chain_size_of(VkStructureType type);

enum chain_owner { CHAIN_OF_GEOMETRY, CHAIN_OF_TRIANGLES };

/* Walks a chain and fills `facts`, which the caller has zeroed. */
void chain_view(struct check_context *context, const struct device_facts *device,
                enum chain_owner owner, const void *chain, struct chain_facts *facts);

/* Returns whether each structure of a chain is readable, up to the size that its type has. */
bool chain_links_are_readable(struct check_context *context, const void *chain);
static inline bool chain_is_readable(struct check_context *context, const void *chain)
{
    return !chain || chain_links_are_readable(context, chain);
}

/* Returns the structure of a type in a chain for which chain_view() filled `facts`. Returns NULL if
 * there is none, or if the chain is unreadable or has duplicates. */
const void *chain_member(const void *chain, const struct chain_facts *facts, VkStructureType type);

/* Fills the usage counts of a micromap, which are an array or an array of pointers. */
void chain_view_usages(struct readable_cache *cache, uint32_t count, const void *array,
                       const void *const *pointers, struct micromap_usages *usages);

#endif
