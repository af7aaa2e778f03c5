/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: memory that the host maps. Results are written through mappings, because a copy by
 * the device would wait for whatever the application's queue waits for. Memory can be mapped once
 * only, so each mapping of the application maps the whole of it, and serves both. */
#include "layer/cpu/overlay.h"

#include <string.h>

#include "observers.h"
#include "src/state/resources/resources.h"

/* Stands for a mapping of which the backend knows nothing. */
static unsigned char unknown_mapping;

/* ---- mappings of the application. The lock is held while memory is mapped, unmapped and freed,
 * which waits for nothing. */

static void note_mapped(struct cpu_overlay *overlay, VkDeviceMemory memory, void *mapped)
{
    if (!handle_table_set(&overlay->mappings, (uint64_t)memory, mapped))
        overlay->lacks_mappings = true;
}

/* The memory is mapped as a whole if the driver can do that. Otherwise, and with flags, which
 * demand a certain place, the call goes down unchanged. */
VkResult cpu_map_memory(struct cpu_overlay *overlay, PFN_vkMapMemory down, VkDevice device,
                        VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize size,
                        VkMemoryMapFlags flags, void **data)
{
    void *whole = NULL;
    pthread_mutex_lock(&overlay->mapping_lock);
    VkResult result =
        flags ? VK_ERROR_MEMORY_MAP_FAILED : down(device, memory, 0, VK_WHOLE_SIZE, 0, &whole);
    if (result == VK_SUCCESS)
        *data = (unsigned char *)whole + offset;
    else
        result = down(device, memory, offset, size, flags, data);
    if (result == VK_SUCCESS)
        note_mapped(overlay, memory, whole ? whole : &unknown_mapping);
    pthread_mutex_unlock(&overlay->mapping_lock);
    return result;
}

VkResult cpu_map_memory_2(struct cpu_overlay *overlay, PFN_vkMapMemory2 down, VkDevice device,
                          const VkMemoryMapInfo *info, void **data)
{
    void *whole = NULL;
    VkMemoryMapInfo own = *info;
    own.offset = 0;
    own.size = VK_WHOLE_SIZE;
    pthread_mutex_lock(&overlay->mapping_lock);
    VkResult result = info->flags ? VK_ERROR_MEMORY_MAP_FAILED : down(device, &own, &whole);
    if (result == VK_SUCCESS)
        *data = (unsigned char *)whole + info->offset;
    else
        result = down(device, info, data);
    if (result == VK_SUCCESS)
        note_mapped(overlay, info->memory, whole ? whole : &unknown_mapping);
    pthread_mutex_unlock(&overlay->mapping_lock);
    return result;
}

void cpu_unmap_memory(struct cpu_overlay *overlay, PFN_vkUnmapMemory down, VkDevice device,
                      VkDeviceMemory memory)
{
    pthread_mutex_lock(&overlay->mapping_lock);
    handle_table_remove(&overlay->mappings, (uint64_t)memory);
    down(device, memory);
    pthread_mutex_unlock(&overlay->mapping_lock);
}

VkResult cpu_unmap_memory_2(struct cpu_overlay *overlay, PFN_vkUnmapMemory2 down, VkDevice device,
                            const VkMemoryUnmapInfo *info)
{
    pthread_mutex_lock(&overlay->mapping_lock);
    VkResult result = down(device, info);
    if (result == VK_SUCCESS)
        handle_table_remove(&overlay->mappings, (uint64_t)info->memory);
    pthread_mutex_unlock(&overlay->mapping_lock);
    return result;
}

void cpu_free_memory(struct cpu_overlay *overlay, PFN_vkFreeMemory down, VkDevice device,
                     VkDeviceMemory memory, const VkAllocationCallbacks *allocator)
{
    pthread_mutex_lock(&overlay->mapping_lock);
    if (memory)
        handle_table_remove(&overlay->mappings, (uint64_t)memory);
    down(device, memory, allocator);
    pthread_mutex_unlock(&overlay->mapping_lock);
}

/* ---- writing */

static void write_regions(unsigned char *to, VkDeviceSize size, const struct result_bytes *result)
{
    for (uint32_t i = 0; i < result->region_count; i++) {
        const VkBufferCopy *region = &result->regions[i];
        if (region->dstOffset <= size && region->size <= size - region->dstOffset)
            memcpy(to + region->dstOffset, result->bytes + region->srcOffset, region->size);
    }
}

static void write_mapped(const struct layer_device *device, const struct buffer_memory *memory,
                         void *whole, const struct result_bytes *result)
{
    const VkMappedMemoryRange range = {.sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE,
                                       .memory = memory->handle,
                                       .size = VK_WHOLE_SIZE};
    write_regions((unsigned char *)whole + memory->begin, memory->size, result);
    if (!(memory->properties & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT))
        device->cpu->down.FlushMappedMemoryRanges(device->handle, 1, &range);
}

/* The application frees memory with the lock held, and the resources have forgotten it before. */
bool cpu_write_by_host(const struct layer_device *device, const struct result_bytes *result)
{
    struct cpu_overlay *overlay = device->cpu;
    struct buffer_memory memory;
    bool is_written = false;
    pthread_mutex_lock(&overlay->mapping_lock);
    if (!overlay->lacks_mappings &&
        resources_find_buffer_memory(device->resources, result->buffer, &memory) &&
        (memory.properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) {
        void *mapped = handle_table_find(&overlay->mappings, (uint64_t)memory.handle);
        void *whole = mapped == &unknown_mapping ? NULL : mapped;
        if (!mapped && overlay->down.MapMemory(device->handle, memory.handle, 0, VK_WHOLE_SIZE, 0,
                                               &whole) != VK_SUCCESS)
            whole = NULL;
        is_written = whole;
        if (is_written)
            write_mapped(device, &memory, whole, result);
        if (is_written && !mapped)
            overlay->down.UnmapMemory(device->handle, memory.handle);
    }
    pthread_mutex_unlock(&overlay->mapping_lock);
    return is_written;
}
