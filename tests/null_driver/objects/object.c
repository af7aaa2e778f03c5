/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Objects: where they live, their handles, and the tree of what was made from what; private data.
 *
 * A handle that is not dispatchable is a number, index and generation of a slot, so that any
 * value can be looked up safely; a dispatchable one is the slot's address, as the loader wants.
 */
#include "tests/null_driver/internal.h"

#include <stdlib.h>
#include <sys/mman.h>

enum { CHUNK_SIZE = 1024, MAX_CHUNKS = 8192 };

/* Grows only; a chunk never goes away, not even with this library. Plain mmap keeps leak checkers
 * from counting what was left behind on purpose. */
static struct object *_Atomic chunks[MAX_CHUNKS];

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of all below, and the tree */
static uint32_t slot_count;
static struct object
    *free_lists[VK_OBJECT_TYPE_COMMAND_BUFFER + 1]; /* linked by next; 0: all others */

void *driver_allocate(void *old, size_t size)
{
    return realloc(old, size);
}

static bool is_dispatchable(VkObjectType type)
{
    return type == VK_OBJECT_TYPE_COMMAND_BUFFER ||
           (type != VK_OBJECT_TYPE_UNKNOWN && type <= VK_OBJECT_TYPE_QUEUE);
}

static uint64_t handle_of(const struct object *object)
{
    return ((uint64_t)object->generation << 40) | ((uint64_t)(object->index + 1) << 4);
}

static struct object *slot_new(void)
{
    const uint32_t chunk = slot_count / CHUNK_SIZE;
    if (chunk == MAX_CHUNKS)
        return NULL;
    if (slot_count % CHUNK_SIZE == 0) {
        void *memory = mmap(NULL, CHUNK_SIZE * sizeof(struct object), PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED)
            return NULL;
        atomic_store_explicit(&chunks[chunk], memory, memory_order_release);
    }
    struct object *object =
        atomic_load_explicit(&chunks[chunk], memory_order_relaxed) + slot_count % CHUNK_SIZE;
    object->index = slot_count++;
    object->generation = 1;
    return object;
}

static struct object *slot_take(VkObjectType type)
{
    struct object **list = &free_lists[is_dispatchable(type) ? type : VK_OBJECT_TYPE_UNKNOWN];
    struct object *object = *list;
    if (object == NULL)
        return slot_new();
    *list = object->next;
    return object;
}

static void slot_give(struct object *object, VkObjectType type, bool recycle)
{
    struct object **list = &free_lists[VK_OBJECT_TYPE_UNKNOWN];
    if (is_dispatchable(type)) {
        if (!recycle)
            return; /* its address is its handle */
        list = &free_lists[type];
    } else if (!recycle) {
        object->generation = object->generation % 0xffffff + 1;
    }
    object->next = *list;
    *list = object;
}

static void link_child(struct object *parent, struct object *object)
{
    object->parent = parent;
    object->children = NULL;
    object->previous = NULL;
    object->next = parent != NULL ? parent->children : NULL;
    if (object->next != NULL)
        object->next->previous = object;
    if (parent != NULL)
        parent->children = object;
}

static void unlink_child(struct object *object)
{
    if (object->next != NULL)
        object->next->previous = object->previous;
    if (object->previous != NULL)
        object->previous->next = object->next;
    else if (object->parent != NULL)
        object->parent->children = object->next;
}

/* Everything below root goes, deepest first: not recursive, as a device may have a long list. */
static void destroy_tree(struct object *root)
{
    struct object *object = root;
    for (;;) {
        while (object->children != NULL)
            object = object->children;
        struct object *parent = object->parent;
        const bool last = object == root;
        const bool recycle = object->config->recycle_handles;
        const VkObjectType type = object->type;
        unlink_child(object);
        atomic_store_explicit(&object->handle, 0, memory_order_release);
        if (object->release != NULL)
            object->release(object);
        object->type = VK_OBJECT_TYPE_UNKNOWN;
        object->config = NULL;
        slot_give(object, type, recycle);
        if (last)
            return;
        object = parent;
    }
}

struct object *object_create(struct object *parent, VkObjectType type,
                             void (*release)(struct object *))
{
    pthread_mutex_lock(&lock);
    struct object *object = slot_take(type);
    if (object != NULL) {
        const uint32_t index = object->index, generation = object->generation;
        const VK_LOADER_DATA loader = object->loader;
        memset(object, 0, sizeof(*object));
        object->index = index;
        object->generation = generation;
        object->loader = loader; /* a freed command buffer's stays readable in its slot */
        if (is_dispatchable(type))
            set_loader_magic_value(object);
        object->type = type;
        object->release = release;
        object->config = parent != NULL ? parent->config : NULL;
        link_child(parent, object);
        atomic_store_explicit(&object->handle, handle_of(object), memory_order_release);
    }
    pthread_mutex_unlock(&lock);
    return object;
}

VkResult objects_create(struct object *parent, VkObjectType type, uint32_t count, void *handles)
{
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count; i++) {
        const struct object *object = object_create(parent, type, NULL);
        const uint64_t handle = object != NULL ? object->handle : 0;
        memcpy((char *)handles + i * sizeof(handle), &handle, sizeof(handle));
        if (object == NULL)
            result = VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    return result;
}

struct object *object_find(uint64_t handle, VkObjectType type)
{
    const uint64_t index = ((handle >> 4) & 0xfffffffff) - 1; /* of 0: too big */
    if (index >= (uint64_t)MAX_CHUNKS * CHUNK_SIZE)
        return NULL;
    struct object *chunk = atomic_load_explicit(&chunks[index / CHUNK_SIZE], memory_order_acquire);
    if (chunk == NULL)
        return NULL;
    struct object *object = &chunk[index % CHUNK_SIZE];
    if (atomic_load_explicit(&object->handle, memory_order_acquire) != handle)
        return NULL;
    return object->type == type ? object : NULL;
}

void object_destroy(uint64_t handle, VkObjectType type)
{
    pthread_mutex_lock(&lock);
    struct object *object = object_find(handle, type);
    if (object != NULL)
        destroy_tree(object);
    pthread_mutex_unlock(&lock);
}

void object_destroy_dispatchable(void *handle, VkObjectType type)
{
    struct object *object = handle;
    pthread_mutex_lock(&lock);
    if (object != NULL && object->type == type)
        destroy_tree(object);
    pthread_mutex_unlock(&lock);
}

struct object *object_child(struct object *parent, VkObjectType type, uint32_t number)
{
    struct object *found = NULL;
    pthread_mutex_lock(&lock);
    struct object *child = parent->children;
    while (child != NULL && child->next != NULL)
        child = child->next; /* the first one made */
    for (; child != NULL && found == NULL; child = child->previous) {
        if (child->type == type && number-- == 0)
            found = child;
    }
    pthread_mutex_unlock(&lock);
    return found;
}

bool object_any(VkObjectType type, bool (*is_wanted)(const struct object *, const void *),
                const void *wanted)
{
    bool found = false;
    pthread_mutex_lock(&lock);
    for (uint32_t i = 0; i < slot_count && !found; i++) {
        const struct object *object = &chunks[i / CHUNK_SIZE][i % CHUNK_SIZE];
        found = object->handle != 0 && object->type == type && is_wanted(object, wanted);
    }
    pthread_mutex_unlock(&lock);
    return found;
}

/* ---- private data: each slot keeps the values that were set, in no order */

static pthread_mutex_t values_lock = PTHREAD_MUTEX_INITIALIZER; /* of all slots' values */

static void release_slot(struct object *slot)
{
    free(slot->private_data.values);
}

ON_CREATION(CreatePrivateDataSlot)
{
    object->release = release_slot;
}

static struct private_value *find_value(const struct object *slot, VkObjectType type,
                                        uint64_t handle)
{
    for (size_t i = 0; i < slot->private_data.count; i++) {
        struct private_value *value = &slot->private_data.values[i];
        if (value->type == type && value->handle == handle)
            return value;
    }
    return NULL;
}

static VkResult set_value(struct object *slot, const struct private_value *new)
{
    struct private_value *value = find_value(slot, new->type, new->handle);
    if (value == NULL) {
        struct private_value *values = driver_allocate(
            slot->private_data.values, (slot->private_data.count + 1) * sizeof(*values));
        if (values == NULL)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        slot->private_data.values = values;
        value = &values[slot->private_data.count++];
    }
    *value = *new;
    return VK_SUCCESS;
}

COMMAND(SetPrivateData)
{
    struct object *slot = FIND(PRIVATE_DATA_SLOT, privateDataSlot);
    if (slot == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const struct private_value value = {objectType, objectHandle, data};
    pthread_mutex_lock(&values_lock);
    const VkResult result = set_value(slot, &value);
    pthread_mutex_unlock(&values_lock);
    return result;
}

COMMAND(GetPrivateData)
{
    const struct object *slot = FIND(PRIVATE_DATA_SLOT, privateDataSlot);
    pthread_mutex_lock(&values_lock);
    const struct private_value *value =
        slot != NULL ? find_value(slot, objectType, objectHandle) : NULL;
    *pData = value != NULL ? value->value : 0;
    pthread_mutex_unlock(&values_lock);
}
