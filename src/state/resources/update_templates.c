/* SPDX-License-Identifier: Apache-2.0 */
#include "src/state/resources/update_templates.h"
#include "src/base/handle.h"

#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/platform/threads.h"

struct update_templates {
    pthread_mutex_t lock;
    struct handle_table by_handle;
};

struct update_templates *update_templates_create(void)
{
    struct update_templates *templates = calloc(1, sizeof(*templates));
    if (templates)
        pthread_mutex_init(&templates->lock, NULL);
    return templates;
}

void update_templates_destroy(struct update_templates *templates)
{
    if (!templates)
        return;
    handle_table_drop(&templates->by_handle, free);
    pthread_mutex_destroy(&templates->lock);
    free(templates);
}

static uint64_t key_of(VkDescriptorUpdateTemplate handle)
{
    return handle_number(handle);
}

static bool is_of_structures(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR ||
           type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV;
}

void update_templates_add(struct update_templates *templates, VkDescriptorUpdateTemplate handle,
                          const VkDescriptorUpdateTemplateCreateInfo *info)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < info->descriptorUpdateEntryCount; i++)
        count += is_of_structures(info->pDescriptorUpdateEntries[i].descriptorType);
    if (!templates || !count ||
        info->templateType != VK_DESCRIPTOR_UPDATE_TEMPLATE_TYPE_DESCRIPTOR_SET)
        return;
    struct update_template *kept = malloc(sizeof(*kept) + count * sizeof(kept->entries[0]));
    if (!kept)
        return;
    kept->count = 0;
    for (uint32_t i = 0; i < info->descriptorUpdateEntryCount; i++)
        if (is_of_structures(info->pDescriptorUpdateEntries[i].descriptorType))
            kept->entries[kept->count++] = info->pDescriptorUpdateEntries[i];
    pthread_mutex_lock(&templates->lock);
    if (!handle_table_set(&templates->by_handle, key_of(handle), kept))
        free(kept);
    pthread_mutex_unlock(&templates->lock);
}

void update_templates_remove(struct update_templates *templates, VkDescriptorUpdateTemplate handle)
{
    if (!templates)
        return;
    pthread_mutex_lock(&templates->lock);
    free(handle_table_remove(&templates->by_handle, key_of(handle)));
    pthread_mutex_unlock(&templates->lock);
}

const struct update_template *update_templates_find(struct update_templates *templates,
                                                    VkDescriptorUpdateTemplate handle)
{
    if (!templates)
        return NULL;
    pthread_mutex_lock(&templates->lock);
    const struct update_template *found = handle_table_find(&templates->by_handle, key_of(handle));
    pthread_mutex_unlock(&templates->lock);
    return found;
}
