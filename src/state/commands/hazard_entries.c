/* SPDX-License-Identifier: Apache-2.0 */
/* The memory that accesses lie in. */
#include "src/state/commands/hazard_entries.h"

#include <stdlib.h>
#include <string.h>

enum { RECENT_BITS = 4, RECENT_MEMORIES = 1 << RECENT_BITS };

/* The memory of recent accesses. */
struct recent_memory {
    uint64_t destroy_count; /* resources_destroy_count() when it was looked up */
    struct {
        VkDeviceMemory memory;
        uint64_t id;
    } items[RECENT_MEMORIES];
};

static uint32_t slot_of(VkDeviceMemory memory)
{
    return (uint64_t)(uintptr_t)memory * 0x9e3779b97f4a7c15u >> (64 - RECENT_BITS);
}

static uint64_t look_up(struct journal *journal, struct resources *resources, VkDeviceMemory memory)
{
    uint64_t destroy_count = resources_destroy_count(resources);
    uint64_t id = resources_find_memory_id(resources, memory);
    struct recent_memory *recent = journal->recent_memory;
    if (!recent)
        journal->recent_memory = recent = calloc(1, sizeof(*recent));
    if (!recent)
        return id;
    if (recent->destroy_count != destroy_count)
        memset(recent->items, 0, sizeof(recent->items));
    recent->destroy_count = destroy_count;
    if (id) {
        recent->items[slot_of(memory)].memory = memory;
        recent->items[slot_of(memory)].id = id;
    }
    return id;
}

uint64_t hazard_memory_id(struct journal *journal, struct resources *resources,
                          VkDeviceMemory memory)
{
    const struct recent_memory *recent = journal->recent_memory;
    if (!memory)
        return 0;
    return recent && recent->items[slot_of(memory)].memory == memory &&
                   recent->destroy_count == resources_destroy_count(resources)
               ? recent->items[slot_of(memory)].id
               : look_up(journal, resources, memory);
}
