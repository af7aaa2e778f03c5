/* SPDX-License-Identifier: Apache-2.0 */
/* A ring of destroyed objects. */
#include "src/state/resources/destroyed.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "src/platform/threads.h"

struct destroyed_objects {
    _Atomic uint64_t submissions;
    pthread_mutex_t lock; /* guards the members below */
    uint64_t count;       /* of all that were added */
    struct destroyed_object items[DESTROYED_MAX];
};

VkResult destroyed_objects_create(struct destroyed_objects **destroyed)
{
    *destroyed = calloc(1, sizeof(**destroyed));
    if (!*destroyed)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*destroyed)->lock, NULL);
    return VK_SUCCESS;
}

void destroyed_objects_destroy(struct destroyed_objects *destroyed)
{
    if (destroyed)
        pthread_mutex_destroy(&destroyed->lock);
    free(destroyed);
}

uint64_t destroyed_objects_add(struct destroyed_objects *destroyed,
                               const struct destroyed_object *object)
{
    pthread_mutex_lock(&destroyed->lock);
    if (object->address) {
        struct destroyed_object *item = &destroyed->items[destroyed->count++ % DESTROYED_MAX];
        *item = *object;
        item->submissions = destroyed_objects_submissions(destroyed);
        item->number = destroyed->count;
    }
    const uint64_t last = destroyed->count;
    pthread_mutex_unlock(&destroyed->lock);
    return last;
}

static bool had_address(const struct destroyed_object *object, VkObjectType type, uint64_t address)
{
    if (object->type != type)
        return false;
    return type == VK_OBJECT_TYPE_BUFFER
               ? address >= object->address && address - object->address < object->size
               : address == object->address;
}

/* Called with the lock held. */
static struct destroyed_object *find_last_destroyed(struct destroyed_objects *destroyed,
                                                    VkObjectType type, uint64_t address)
{
    for (uint64_t i = destroyed->count; i > 0 && i + DESTROYED_MAX > destroyed->count; i--) {
        struct destroyed_object *object = &destroyed->items[(i - 1) % DESTROYED_MAX];
        if (had_address(object, type, address))
            return object;
    }
    return NULL;
}

bool destroyed_objects_find(struct destroyed_objects *destroyed, VkObjectType type,
                            uint64_t address, struct destroyed_object *object)
{
    pthread_mutex_lock(&destroyed->lock);
    const struct destroyed_object *found = find_last_destroyed(destroyed, type, address);
    if (!found)
        found = find_last_destroyed(destroyed, VK_OBJECT_TYPE_BUFFER, address);
    if (found)
        *object = *found;
    pthread_mutex_unlock(&destroyed->lock);
    return found;
}

bool destroyed_objects_report(struct destroyed_objects *destroyed, uint64_t address,
                              uint64_t submissions, uint64_t last, struct destroyed_object *object)
{
    pthread_mutex_lock(&destroyed->lock);
    struct destroyed_object *found =
        find_last_destroyed(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, address);
    const bool is_about_batch =
        found && !found->is_reported && found->submissions >= submissions && found->number <= last;
    if (is_about_batch) {
        found->is_reported = true;
        *object = *found;
    }
    pthread_mutex_unlock(&destroyed->lock);
    return is_about_batch;
}

bool destroyed_objects_find_range(struct destroyed_objects *destroyed, uint64_t address,
                                  struct destroyed_object *object)
{
    bool is_found = false;
    pthread_mutex_lock(&destroyed->lock);
    for (uint64_t i = destroyed->count; !is_found && i > 0 && i + DESTROYED_MAX > destroyed->count;
         i--) {
        *object = destroyed->items[(i - 1) % DESTROYED_MAX];
        is_found = address >= object->address && address - object->address < object->size;
    }
    pthread_mutex_unlock(&destroyed->lock);
    return is_found;
}

void destroyed_objects_count_submission(struct destroyed_objects *destroyed)
{
    if (destroyed)
        atomic_fetch_add_explicit(&destroyed->submissions, 1, memory_order_relaxed);
}

uint64_t destroyed_objects_submissions(const struct destroyed_objects *destroyed)
{
    return atomic_load_explicit(&destroyed->submissions, memory_order_relaxed);
}
