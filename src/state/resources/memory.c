/* SPDX-License-Identifier: Apache-2.0 */
/* Creates and destroys struct resources; the records of memory. */
#include "src/state/resources/resources.h"

#include <stdlib.h>

#include "src/state/resources/records.h"

VkResult resources_create(struct resources **resources)
{
    *resources = calloc(1, sizeof(**resources));
    if (!*resources)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return VK_SUCCESS;
}

static void free_accel(void *record)
{
    accel_record_free(record);
}

static void free_buffer(void *record)
{
    buffer_record_release(record);
}

static void free_memory(void *record)
{
    memory_record_release(record);
}

void resources_destroy(struct resources *resources)
{
    if (!resources)
        return;
    resources_release_nv(resources);
    resources_release_references(resources);
    handle_table_drop(&resources->accels, free_accel);
    handle_table_drop(&resources->micromaps, free);
    handle_table_drop(&resources->buffers, free_buffer);
    handle_table_drop(&resources->memories, free_memory);
    address_map_release(&resources->addresses);
    free(resources->watched.changes);
    free(resources);
}

/* ---- memory */

static void remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    struct memory_record *memory =
        handle_table_remove(&resources->memories, (uint64_t)(uintptr_t)handle);
    if (!memory)
        return;
    resources_count_destroyed(resources);
    memory_record_unmap(resources, memory);
    memory->alive = false;
    nv_accel_records_lose_memory(resources, memory);
    for (struct buffer_record *buffer = memory->buffers; buffer; buffer = buffer->next)
        resources_refresh(resources, buffer);
    memory_record_release(memory);
}

void resources_add_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize size,
                          VkMemoryPropertyFlags properties, bool multi_instance)
{
    struct memory_record *memory = malloc(sizeof(*memory));
    if (memory)
        *memory = (struct memory_record){.references = 1,
                                         .alive = true,
                                         .handle = handle,
                                         .size = size,
                                         .properties = properties,
                                         .multi_instance = multi_instance};
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    if (memory)
        memory->id = ++resources->last_id;
    if (!resources_publish(resources, &resources->memories, (uint64_t)(uintptr_t)handle, memory))
        free(memory);
    reader_lock_write_done(&resources->lock);
}

void resources_remove_memory(struct resources *resources, VkDeviceMemory handle)
{
    reader_lock_write(&resources->lock);
    remove_memory(resources, handle);
    reader_lock_write_done(&resources->lock);
}
