/* SPDX-License-Identifier: Apache-2.0 */
/* A list of ranges, each of which is added once. */
#include "src/state/builds/places.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/platform/threads.h"

struct place {
    VkDeviceAddress address;
    VkDeviceSize size;
    enum place_kind kind;
};

struct places {
    pthread_mutex_t lock; /* guards the rest */
    struct place *items;
    uint32_t count, capacity;
    bool are_used[PLACE_KINDS], are_unknown[PLACE_KINDS], are_moved, lack_memory;
};

struct places *places_create(void)
{
    struct places *places = calloc(1, sizeof(*places));
    if (places)
        pthread_mutex_init(&places->lock, NULL);
    return places;
}

void places_destroy(struct places *places)
{
    if (!places)
        return;
    pthread_mutex_destroy(&places->lock);
    free(places->items);
    free(places);
}

static struct place *find_place(struct places *places, enum place_kind kind,
                                VkDeviceAddress address)
{
    for (uint32_t i = 0; i < places->count; i++) {
        struct place *place = &places->items[i];
        if (place->kind == kind && address - place->address < place->size)
            return place;
    }
    return NULL;
}

void places_add(struct places *places, enum place_kind kind, VkDeviceAddress address,
                VkDeviceSize size)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    const struct place *known = find_place(places, kind, address);
    const bool is_known = known && address - known->address + size <= known->size;
    places->are_used[kind] = true;
    if (!is_known && ARRAY_HAS_ROOM(places->items, places->count, places->capacity))
        places->items[places->count++] = (struct place){address, size, kind};
    else if (!is_known)
        places->lack_memory = true;
    pthread_mutex_unlock(&places->lock);
}

void places_add_unknown(struct places *places, enum place_kind kind)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    places->are_used[kind] = places->are_unknown[kind] = true;
    pthread_mutex_unlock(&places->lock);
}

void places_add_moves(struct places *places)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    places->are_moved = true;
    pthread_mutex_unlock(&places->lock);
}

bool places_are_used(struct places *places, enum place_kind kind)
{
    if (!places)
        return false;
    pthread_mutex_lock(&places->lock);
    const bool are_used = places->are_used[kind];
    pthread_mutex_unlock(&places->lock);
    return are_used;
}

bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address)
{
    if (!places)
        return false;
    pthread_mutex_lock(&places->lock);
    const bool may = places->lack_memory || places->are_unknown[kind] ||
                     (places->are_moved && kind != PLACE_PARTITIONED && places->are_used[kind]) ||
                     find_place(places, kind, address);
    pthread_mutex_unlock(&places->lock);
    return may;
}
