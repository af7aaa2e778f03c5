/* SPDX-License-Identifier: Apache-2.0 */
/* Looking through pNext chains. */
#ifndef ASSAY_BASE_CHAIN_H
#define ASSAY_BASE_CHAIN_H

#include <vulkan/vulkan_core.h>

/* The first structure of that type in a chain, or NULL. */
static inline const void *chain_find(const void *chain, VkStructureType type)
{
    for (const VkBaseInStructure *s = chain; s; s = s->pNext)
        if (s->sType == type)
            return s;
    return NULL;
}

#endif
