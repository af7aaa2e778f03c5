/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of accesses and barriers: filled while a command buffer is recorded, then only read. */
#include "src/state/commands/hazard_list.h"

#include <stdlib.h>
#include <string.h>

enum { ITEM_SIZE = sizeof(struct hazard_item) };

struct hazard_list *hazard_list_create(void (*release_secondary)(struct journal *secondary))
{
    struct hazard_list *list = calloc(1, sizeof(*list));
    if (list)
        list->release_secondary = release_secondary;
    return list;
}

void hazard_list_destroy(struct hazard_list *list)
{
    if (!list)
        return;
    hazard_list_clear(list);
    chunk_list_free(&list->items);
    free(list);
}

static void release_secondaries(const struct hazard_list *list, struct chunk_place place)
{
    for (const struct hazard_item *item; (item = hazard_list_next(list, &place));)
        if (item->kind == HAZARD_EXECUTE)
            list->release_secondary(item->secondary);
}

void hazard_list_clear(struct hazard_list *list)
{
    if (list->executes)
        release_secondaries(list, (struct chunk_place){NULL, NULL});
    chunk_list_clear(&list->items, ITEM_SIZE);
    list->incomplete = list->has_references = list->executes = false;
    list->command = NULL;
}

struct hazard_item *hazard_list_add(struct hazard_list *list)
{
    struct hazard_item *item = hazard_list_add_unset(list);
    if (item)
        memset(item, 0, sizeof(*item));
    return item;
}

struct hazard_item *hazard_list_add_command(struct hazard_list *list, const char *command)
{
    struct chunk_place before = hazard_list_end(list);
    struct hazard_item *item = hazard_list_add(list);
    list->command = item;
    list->before_command = before;
    if (!item)
        return NULL;
    item->kind = HAZARD_COMMAND;
    item->command = command;
    return item;
}

void hazard_list_add_secondary(struct hazard_list *list, struct journal *secondary,
                               bool has_references)
{
    struct hazard_item *item = hazard_list_add(list);
    if (!item) {
        list->release_secondary(secondary);
        return;
    }
    item->kind = HAZARD_EXECUTE;
    item->secondary = secondary;
    list->executes = true;
    list->has_references |= has_references;
}

const struct hazard_item *hazard_list_next(const struct hazard_list *list,
                                           struct chunk_place *place)
{
    return chunk_list_next(&list->items, ITEM_SIZE, place);
}

struct chunk_place hazard_list_end(const struct hazard_list *list)
{
    return chunk_list_end(&list->items);
}

void hazard_list_take_back(struct hazard_list *list, struct chunk_place place)
{
    if (list->executes)
        release_secondaries(list, place);
    chunk_list_cut(&list->items, ITEM_SIZE, place);
    list->command = NULL;
}

uint64_t hazard_list_look_up_memory(struct hazard_list *list, struct resources *resources,
                                    VkDeviceMemory memory)
{
    uint64_t destroy_count = resources_destroy_count(resources);
    uint64_t id = resources_find_memory_id(resources, memory);
    uint32_t slot = hazard_list_recent_slot(memory);
    if (list->destroy_count != destroy_count)
        memset(list->recent, 0, sizeof(list->recent));
    list->destroy_count = destroy_count;
    if (id) {
        list->recent[slot].memory = memory;
        list->recent[slot].id = id;
    }
    return id;
}
