/* SPDX-License-Identifier: Apache-2.0 */
/* A table of names by handle. Objects of different types may have equal handles, and objects that
 * were destroyed may have had them; their names form a chain. */
#include "src/state/commands/object_names.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/handle_table.h"
#include "src/base/text_buffer.h"
#include "src/platform/threads.h"

struct object_name {
    struct object_name *next; /* same handle */
    VkObjectType type;
    uint64_t handle;
    bool is_past; /* the object is destroyed */
    bool is_old;  /* and so is a later object that had the handle */
    uint64_t id;  /* of the object; 0: none, or not known yet */
    char text[];
};

/* `lock` guards the rest. Each record of the table is a chain of at least one name. */
struct object_names {
    pthread_mutex_t lock;
    struct handle_table table;
    struct object_name *past[OBJECT_NAMES_PAST]; /* a ring; they are in the table, too */
    uint64_t past_count;                         /* of all that were added */
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
    case VK_OBJECT_TYPE_QUERY_POOL:
        return "VkQueryPool";
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

/* Removes a name that is in the table, and frees it. */
static void remove_name(struct handle_table *table, struct object_name *name)
{
    struct object_name *first = handle_table_find(table, name->handle), **link = &first;
    while (*link != name)
        link = &(*link)->next;
    *link = name->next;
    handle_table_remove(table, name->handle);
    if (first)
        handle_table_set(table, name->handle, first); /* reuses the removed slot, so it succeeds */
    free(name);
}

/* Returns NULL if the live object has no name. */
static struct object_name *find_live_name(const struct object_names *names, VkObjectType type,
                                          uint64_t handle)
{
    struct object_name *name = handle_table_find(&names->table, handle);
    while (name && (name->type != type || name->is_past))
        name = name->next;
    return name;
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
    object_names_set_of(names, type, handle, 0, name);
}

void object_names_set_of(struct object_names *names, VkObjectType type, uint64_t handle,
                         uint64_t id, const char *name)
{
    if (!handle || !object_type_name(type))
        return;

    struct object_name *added = NULL;
    if (name && name[0]) {
        size_t size = strlen(name) + 1;
        added = malloc(sizeof(*added) + size);
        if (added) {
            *added = (struct object_name){.type = type, .handle = handle, .id = id};
            memcpy(added->text, name, size);
        }
    }
    pthread_mutex_lock(&names->lock);
    struct object_name *before = find_live_name(names, type, handle);
    if (before)
        remove_name(&names->table, before);
    if (added)
        add_name(&names->table, handle, added);
    pthread_mutex_unlock(&names->lock);
}

/* ---- destroyed objects */

/* Keeps the name in place of the oldest one. */
static void keep_past_name(struct object_names *names, struct object_name *name)
{
    struct object_name **slot = &names->past[names->past_count++ % OBJECT_NAMES_PAST];
    if (*slot)
        remove_name(&names->table, *slot);
    *slot = name;
}

void object_names_end(struct object_names *names, VkObjectType type, uint64_t handle, uint64_t id)
{
    pthread_mutex_lock(&names->lock);
    struct object_name *live = find_live_name(names, type, handle);
    struct object_name *name = handle_table_find(&names->table, handle);
    for (; name; name = name->next)
        name->is_old |= name->is_past && name->type == type;
    if (live) {
        live->is_past = true;
        live->id = id ? id : live->id;
        keep_past_name(names, live);
    }
    pthread_mutex_unlock(&names->lock);
}

static const struct object_name *find_past_name(const struct object_names *names, VkObjectType type,
                                                uint64_t handle, uint64_t id)
{
    const struct object_name *name = handle_table_find(&names->table, handle);
    while (name && (name->type != type || !name->is_past || (id ? name->id != id : name->is_old)))
        name = name->next;
    return name;
}

/* ---- look-ups */

/* Accepts NULL. */
static size_t copy_name(const struct object_name *name, char *buffer, size_t size)
{
    if (!name || !size)
        return 0;
    size_t length = strlen(name->text);
    if (length >= size)
        length = text_cut_length(name->text, size - 1);
    memcpy(buffer, name->text, length);
    return length;
}

/* `is_past`, `is_live`: which objects count. */
static size_t get_name(const struct object_names *names, VkObjectType type, uint64_t handle,
                       uint64_t id, bool is_live, bool is_past, char *buffer, size_t size)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)&names->lock;
    pthread_mutex_lock(lock);
    const struct object_name *name = is_live ? find_live_name(names, type, handle) : NULL;
    if (name && is_past && name->id != id)
        name = NULL;
    if (!name && is_past)
        name = find_past_name(names, type, handle, id);
    size_t length = copy_name(name, buffer, size);
    pthread_mutex_unlock(lock);
    if (size)
        buffer[length] = '\0';
    return length;
}

size_t object_names_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                        char *buffer, size_t size)
{
    return get_name(names, type, handle, 0, true, false, buffer, size);
}

size_t object_names_get_of(const struct object_names *names, VkObjectType type, uint64_t handle,
                           uint64_t id, char *buffer, size_t size)
{
    return get_name(names, type, handle, id, true, true, buffer, size);
}

size_t object_names_get_past(const struct object_names *names, VkObjectType type, uint64_t handle,
                             uint64_t id, char *buffer, size_t size)
{
    return get_name(names, type, handle, id, false, true, buffer, size);
}

size_t object_names_try_get(const struct object_names *names, VkObjectType type, uint64_t handle,
                            char *buffer, size_t size)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)&names->lock;
    size_t length = 0;
    if (pthread_mutex_trylock(lock) == 0) {
        length = copy_name(find_live_name(names, type, handle), buffer, size);
        pthread_mutex_unlock(lock);
    }
    if (size)
        buffer[length] = '\0';
    return length;
}
