/* SPDX-License-Identifier: Apache-2.0 */
/* Images and render passes by handle. */
#include "layer/hazards/objects.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"

struct render_pass {
    uint32_t count;
    struct subpass_dependency dependencies[];
};

struct image {
    VkFormat format;
};

struct hazard_objects {
    struct reader_lock lock;
    struct handle_table images, render_passes;
};

struct hazard_objects *hazard_objects_create(void)
{
    return calloc(1, sizeof(struct hazard_objects));
}

void hazard_objects_destroy(struct hazard_objects *objects)
{
    if (!objects)
        return;
    handle_table_drop(&objects->images, free);
    handle_table_drop(&objects->render_passes, free);
    free(objects);
}

/* Takes over the record, which may be NULL: then the handle is removed. */
static void set(struct hazard_objects *objects, struct handle_table *table, uint64_t handle,
                void *record)
{
    reader_lock_write(&objects->lock);
    void *old = handle_table_remove(table, handle);
    bool is_kept = record && handle_table_set(table, handle, record);
    reader_lock_write_done(&objects->lock);
    free(old);
    if (!is_kept)
        free(record);
}

void hazard_objects_add_image(struct hazard_objects *objects, VkImage image, VkFormat format)
{
    if (!objects)
        return;
    struct image *record = malloc(sizeof(*record));
    if (record)
        record->format = format;
    set(objects, &objects->images, (uint64_t)(uintptr_t)image, record);
}

void hazard_objects_remove_image(struct hazard_objects *objects, VkImage image)
{
    if (objects && image)
        set(objects, &objects->images, (uint64_t)(uintptr_t)image, NULL);
}

VkFormat hazard_objects_format(struct hazard_objects *objects, VkImage image)
{
    if (!objects)
        return VK_FORMAT_UNDEFINED;
    unsigned stripe = reader_lock_enter(&objects->lock);
    const struct image *record = handle_table_find(&objects->images, (uint64_t)(uintptr_t)image);
    VkFormat format = record ? record->format : VK_FORMAT_UNDEFINED;
    reader_lock_leave(&objects->lock, stripe);
    return format;
}

void hazard_objects_add_render_pass(struct hazard_objects *objects, VkRenderPass render_pass,
                                    const struct subpass_dependency *dependencies, uint32_t count)
{
    if (!objects)
        return;
    struct render_pass *record = malloc(sizeof(*record) + count * sizeof(*dependencies));
    if (record)
        record->count = count;
    if (record && count)
        memcpy(record->dependencies, dependencies, count * sizeof(*dependencies));
    set(objects, &objects->render_passes, (uint64_t)(uintptr_t)render_pass, record);
}

void hazard_objects_remove_render_pass(struct hazard_objects *objects, VkRenderPass render_pass)
{
    if (objects && render_pass)
        set(objects, &objects->render_passes, (uint64_t)(uintptr_t)render_pass, NULL);
}

const struct subpass_dependency *hazard_objects_dependencies(struct hazard_objects *objects,
                                                             VkRenderPass render_pass,
                                                             uint32_t *count)
{
    if (!objects)
        return NULL;
    unsigned stripe = reader_lock_enter(&objects->lock);
    const struct render_pass *record =
        handle_table_find(&objects->render_passes, (uint64_t)(uintptr_t)render_pass);
    reader_lock_leave(&objects->lock, stripe);
    if (!record)
        return NULL;
    *count = record->count;
    return record->dependencies;
}
