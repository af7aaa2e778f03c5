/* SPDX-License-Identifier: Apache-2.0 */
/* Copying structures by the sizes that the registry knows. */
#include "src/base/chain.h"

#include <stdalign.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_layer.h>

#include "src/base/readable.h"
#include "src/platform/probe.h"
#include "vuid-tables/registry.h"

/* The bytes that are copied of a structure which is newer than the registry, if they are readable:
 * more than any structure has. */
enum { UNKNOWN_SIZE = 1024 };

static size_t size_of(VkStructureType type)
{
    if (type == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO)
        return sizeof(VkLayerDeviceCreateInfo);
    const struct registry_structure *structure = registry_find_structure(type);
    return structure ? structure->size : 0;
}

static size_t room_for(size_t size)
{
    const size_t step = alignof(max_align_t);
    return ((size ? size : UNKNOWN_SIZE) + step - 1) / step * step;
}

static void copy_structure(void *to, const void *from, size_t size)
{
    if (size)
        memcpy(to, from, size);
    else
        probe_copy(memset(to, 0, UNKNOWN_SIZE), from, UNKNOWN_SIZE);
}

size_t chain_copy_size(const void *chain, VkStructureType type)
{
    const VkBaseInStructure *last = chain_find(chain, type);
    if (!last)
        return 0;
    size_t room = room_for(size_of(last->sType));
    for (const VkBaseInStructure *in = chain; in != last; in = in->pNext)
        room += room_for(size_of(in->sType));
    return room;
}

void chain_copy_to(struct chain_copy *copy, const void *chain, VkStructureType type, void *memory)
{
    *copy = (struct chain_copy){.first = (void *)(uintptr_t)chain};
    const VkBaseInStructure *last = chain_find(chain, type);
    VkBaseOutStructure **link = (VkBaseOutStructure **)&copy->first;
    char *to = memory;
    for (const VkBaseInStructure *in = chain; last && in != last->pNext; in = in->pNext) {
        size_t size = size_of(in->sType);
        copy_structure(to, in, size);
        *link = copy->found = (void *)to;
        copy->link = link;
        link = &(*link)->pNext;
        to += room_for(size);
    }
}

VkResult chain_copy_begin(struct chain_copy *copy, const void *chain, VkStructureType type)
{
    const size_t size = chain_copy_size(chain, type);
    void *memory = size ? calloc(1, size) : NULL;
    *copy = (struct chain_copy){.first = (void *)(uintptr_t)chain};
    if (size && !memory)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    chain_copy_to(copy, chain, type, memory);
    copy->memory = memory;
    return VK_SUCCESS;
}

void chain_copy_end(struct chain_copy *copy)
{
    free(copy->memory);
}
