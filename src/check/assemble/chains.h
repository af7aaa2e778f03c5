/* SPDX-License-Identifier: Apache-2.0 */
/* The pNext chains of geometries: what may stand in them, and whether it can be read. */
#ifndef ASSAY_CHECK_ASSEMBLE_CHAINS_H
#define ASSAY_CHECK_ASSEMBLE_CHAINS_H

#include "src/check/walk/context.h"
#include "src/view/micromap_view.h"

/* Chains longer than this are cyclic, or nobody's. */
enum { CHAIN_MAX = 64 };

/* How much of a structure can be read at least, where it is what its type says. */
size_t chain_size_of(VkStructureType type);

enum chain_owner { CHAIN_OF_GEOMETRY, CHAIN_OF_TRIANGLES };

/* Walks a chain; `facts` is zero before. */
void chain_view(struct check_context *context, const struct device_facts *device,
                enum chain_owner owner, const void *chain, struct chain_facts *facts);

/* Whether each structure of a chain can be read, as far as its type tells how long it is. */
bool chain_links_are_readable(struct check_context *context, const void *chain);
static inline bool chain_is_readable(struct check_context *context, const void *chain)
{
    return !chain || chain_links_are_readable(context, chain);
}

/* The structure of that type in a chain that was viewed; NULL where there is none, or where the
 * chain leaves open which is meant. */
const void *chain_member(const void *chain, const struct chain_facts *facts, VkStructureType type);

/* The usages of a micromap: an array, or an array of pointers. */
void chain_view_usages(struct readable_cache *cache, uint32_t count, const void *array,
                       const void *const *pointers, struct micromap_usages *usages);

#endif
