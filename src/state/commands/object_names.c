/* SPDX-License-Identifier: Apache-2.0 */
/* A table of names by handle. Objects of different types may have equal handles; their names form a
 * chain. */
#include "src/state/commands/object_names.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/handle_table.h"
#include "src/base/text_buffer.h"
#include "src/platform/threads.h"

struct object_name {
    struct object_name *next; /* same handle, other type */
    VkObjectType type;
    char text[];
};

/* `lock` guards `table`. Each record of the table is a chain of at least one name. */
struct object_names {
    pthread_mutex_t lock;
    struct handle_table table;
};

const char *object_type_name(VkObjectType type)
{
    switch (type) {
    case VK_OBJECT_TYPE_DEVICE:
        return "VkDevice";
    case VK_OBJECT_TYPE_QUEUE:
        return "VkQueue";
    case VK_OBJECT_TYPE_COMMAND_POOL:
        return "VkCommandPool";
    case VK_OBJECT_TYPE_COMMAND_BUFFER:
        return "VkCommandBuffer";
    case VK_OBJECT_TYPE_DEVICE_MEMORY:
        return "VkDeviceMemory";
    case VK_OBJECT_TYPE_BUFFER:
        return "VkBuffer";
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR:
        return "VkAccelerationStructureKHR";
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        return "VkAccelerationStructureNV";
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return "VkMicromapEXT";
    case VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR:
        return "VkDeferredOperationKHR";
    default:
        return NULL;
    }
}

VkResult object_names_create(struct object_names **out)
{
    struct object_names *names = calloc(1, sizeof(*names));
    if (!names)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&names->lock, NULL);
    *out = names;
    return VK_SUCCESS;
}

static void free_chain(void *record)
{
    for (struct object_name *name = record, *next; name; name = next) {
        next = name->next;
        free(name);
    }
}

void object_names_destroy(struct object_names *names)
{
    if (!names)
        return;
    handle_table_drop(&names->table, free_chain);
    pthread_mutex_destroy(&names->lock);
    free(names);
}

static void remove_name(struct handle_table *table, VkObjectType type, uint64_t handle)
{
    struct object_name *first = handle_table_find(table, handle), **link = &first;
    while (*link && (*link)->type != type)
        link = &(*link)->next;
    struct object_name *name = *link;
    if (!name)
        return;
    *link = name->next;
    free(name);
    handle_table_remove(table, handle);
    if (first)
        handle_table_set(table, handle, first); /* reuses the removed slot, so it succeeds */
}

static void add_name(struct handle_table *table, uint64_t handle, struct object_name *name)
{
    name->next = handle_table_find(table, handle);
    if (!handle_table_set(table, handle, name))
        free(name);
}

void object_names_set(struct object_names *names, VkObjectType type, uint64_t handle,
                      const char *name)
{
    if (!handle || !object_type_name(type))
        return;

    struct object_name *added = NULL;
    if (name && name[0]) {
        size_t size = strlen(name) + 1;
        added = malloc(sizeof(*added) + size);
        if (added) {
            added->type = type;
            memcpy(added->text, name, size);
        }
    }
    pthread_mutex_lock(&names->lock);
    remove_name(&names->table, type, handle);
    if (added)
        add_name(&names->table, handle, added);
    pthread_mutex_unlock(&names->lock);
}

/* Called with the lock held. */
static size_t copy_name(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size)
{
    const struct object_name *name = handle_table_find(&names->table, handle);
    while (name && name->type != type)
        name = name->next;
    if (!name || !size)
        return 0;
    size_t length = strlen(name->text);
    if (length >= size)
        length = text_cut_length(name->text, size - 1);
    memcpy(buffer, name->text, length);
    return length;
}

size_t object_names_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)&names->lock;
    pthread_mutex_lock(lock);
    size_t length = copy_name(names, type, handle, buffer, size);
    pthread_mutex_unlock(lock);
    if (size)
        buffer[length] = '\0';
    return length;
}

size_t object_names_try_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                            char *buffer, size_t size)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)&names->lock;
    size_t length = 0;
    if (pthread_mutex_trylock(lock) == 0) {
        length = copy_name(names, type, handle, buffer, size);
        pthread_mutex_unlock(lock);
    }
    if (size)
        buffer[length] = '\0';
    return length;
}
