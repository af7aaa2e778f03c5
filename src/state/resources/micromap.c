/* SPDX-License-Identifier: Apache-2.0 */
/* The records of micromaps of VK_EXT_opacity_micromap. */
#include <stdlib.h>

#include "src/state/resources/records.h"

/* Returns the id of the removed record, or 0. */
static uint64_t remove_micromap(struct resources *resources, VkMicromapEXT handle)
{
    struct micromap_record *micromap =
        handle_table_remove(&resources->micromaps, (uint64_t)(uintptr_t)handle);
    if (!micromap)
        return 0;
    uint64_t id = micromap->id;
    resources_count_destroyed(resources);
    free(micromap);
    return id;
}

void resources_add_micromap(struct resources *resources, VkMicromapEXT handle,
                            const VkMicromapCreateInfoEXT *create_info)
{
    struct micromap_record *micromap = malloc(sizeof(*micromap));
    reader_lock_write(&resources->lock);
    remove_micromap(resources, handle);
    const struct buffer_record *buffer = resources_buffer(resources, create_info->buffer);
    if (micromap)
        *micromap = (struct micromap_record){.id = ++resources->last_id,
                                             .type = create_info->type,
                                             .buffer = create_info->buffer,
                                             .buffer_id = buffer ? buffer->where.buffer_id : 0,
                                             .offset = create_info->offset,
                                             .size = create_info->size};
    if (!resources_publish(resources, &resources->micromaps, (uint64_t)(uintptr_t)handle, micromap))
        free(micromap);
    reader_lock_write_done(&resources->lock);
}

uint64_t resources_remove_micromap(struct resources *resources, VkMicromapEXT handle)
{
    reader_lock_write(&resources->lock);
    uint64_t id = remove_micromap(resources, handle);
    reader_lock_write_done(&resources->lock);
    return id;
}

void resources_find_micromap(struct resources *resources, VkMicromapEXT handle,
                             struct micromap_facts *facts)
{
    *facts = (struct micromap_facts){.handle = handle};
    if (!handle)
        return;
    unsigned token = resources_begin_reading(resources);
    const struct micromap_record *micromap =
        handle_table_find(&resources->micromaps, (uint64_t)(uintptr_t)handle);
    if (micromap) {
        facts->alive = YES;
        facts->id = micromap->id;
        facts->type = micromap->type;
    } else {
        facts->alive = resources->incomplete ? UNKNOWN : NO;
    }
    resources_end_reading(resources, token);
}
