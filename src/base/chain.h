/* SPDX-License-Identifier: Apache-2.0 */
/* Searches pNext chains, copies of them, and lists of extensions. */
#ifndef ASSAY_BASE_CHAIN_H
#define ASSAY_BASE_CHAIN_H

#include <stdbool.h>
#include <string.h>
#include <vulkan/vulkan_core.h>

/* Returns the first structure with this sType in the chain, or NULL. */
static inline const void *chain_find(const void *chain, VkStructureType type)
{
    for (const VkBaseInStructure *s = chain; s; s = s->pNext)
        if (s->sType == type)
            return s;
    return NULL;
}

static inline bool names_have(const char *const *names, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(names[i], name) == 0)
            return true;
    return false;
}

/* Whether a VkInstanceCreateInfo or VkDeviceCreateInfo enables an extension. */
#define enables_extension(create_info, name)                                                       \
    names_have((create_info)->ppEnabledExtensionNames, (create_info)->enabledExtensionCount, name)

/* ---- A pNext chain of which one structure is changed or left out on the way down. The
 * application's structures are never edited, so those before it are copied; those behind it are its
 * own. */

struct chain_copy {
    void *first; /* the chain to pass on */
    void *found; /* the copy of the structure, for the caller to change; NULL: the chain has none */
    VkBaseOutStructure **link; /* what points to `found` */
    void *memory;
};

/* The size of copies up to the first structure of that type; 0: the chain has none. */
size_t chain_copy_size(const void *chain, VkStructureType type);
/* Copies to memory of that size, which the caller owns. */
void chain_copy_to(struct chain_copy *copy, const void *chain, VkStructureType type, void *memory);

/* Copies to memory of its own, until chain_copy_end(). */
VkResult chain_copy_begin(struct chain_copy *copy, const void *chain, VkStructureType type);
void chain_copy_end(struct chain_copy *copy);

/* Takes `found` out. */
static inline void chain_copy_leave_out(struct chain_copy *copy)
{
    *copy->link = (*copy->link)->pNext;
    copy->found = NULL;
}

#endif
