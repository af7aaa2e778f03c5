/* SPDX-License-Identifier: Apache-2.0 */
/* Searches pNext chains. */
#ifndef ASSAY_BASE_CHAIN_H
#define ASSAY_BASE_CHAIN_H

#include <vulkan/vulkan_core.h>

/* Returns the first structure with this sType in the chain, or NULL. */
static inline const void *chain_find(const void *chain, VkStructureType type)
{
    for (const VkBaseInStructure *s = chain; s; s = s->pNext)
        if (s->sType == type)
            return s;
    return NULL;
}

#endif
