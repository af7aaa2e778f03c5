/* SPDX-License-Identifier: Apache-2.0 */
/* A list of ranges, each of which is added once. */
#include "src/state/builds/places.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/platform/threads.h"
#include "src/state/resources/resources.h"

struct place {
    VkDeviceAddress address;
    VkDeviceSize size;
    struct memory_bytes bytes; /* at the address */
    enum place_kind kind;
};

struct places {
    struct resources *resources;
    pthread_mutex_t lock; /* guards the rest */
    struct place *items;
    uint32_t count, capacity;
    bool are_used[PLACE_KINDS], are_unknown[PLACE_KINDS], are_moved, lack_memory;
};

struct places *places_create(struct resources *resources)
{
    struct places *places = calloc(1, sizeof(*places));
    if (!places)
        return NULL;
    places->resources = resources;
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

static bool has_address(const struct place *place, VkDeviceAddress address)
{
    return address - place->address < place->size;
}

static bool has_bytes(const struct place *place, const struct memory_bytes *bytes)
{
    return bytes->memory_id == place->bytes.memory_id &&
           bytes->begin - place->bytes.begin < place->size;
}

static bool is_known(const struct places *places, const struct place *added)
{
    for (uint32_t i = 0; i < places->count; i++) {
        const struct place *place = &places->items[i];
        const uint64_t skipped = added->address - place->address;
        if (place->kind == added->kind && has_address(place, added->address) &&
            has_bytes(place, &added->bytes) && added->size <= place->size - skipped &&
            added->bytes.begin - place->bytes.begin == skipped)
            return true;
    }
    return false;
}

void places_add(struct places *places, enum place_kind kind, VkDeviceAddress address,
                VkDeviceSize size)
{
    if (!places)
        return;
    struct place added = {.address = address, .size = size, .kind = kind};
    bool is_external;
    if (resources_find_address_bytes(places->resources, address, &added.bytes, &is_external) !=
        YES) {
        places_add_unknown(places, kind);
        return;
    }
    pthread_mutex_lock(&places->lock);
    places->are_used[kind] = true;
    if (!is_known(places, &added)) {
        if (ARRAY_HAS_ROOM(places->items, places->count, places->capacity))
            places->items[places->count++] = added;
        else
            places->lack_memory = true;
    }
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

static bool is_place(const struct places *places, enum place_kind kind, VkDeviceAddress address,
                     const struct memory_bytes *bytes)
{
    for (uint32_t i = 0; i < places->count; i++) {
        const struct place *place = &places->items[i];
        if (place->kind == kind &&
            (has_address(place, address) || (bytes && has_bytes(place, bytes))))
            return true;
    }
    return false;
}

bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address,
                     uint64_t destroy_count)
{
    if (!places)
        return false;
    struct memory_bytes bytes;
    bool is_external = false;
    const enum tristate found =
        resources_find_address_bytes(places->resources, address, &bytes, &is_external);
    if (found == UNKNOWN || is_external ||
        resources_destroy_count(places->resources) != destroy_count)
        return true;
    pthread_mutex_lock(&places->lock);
    const bool may = places->lack_memory || places->are_unknown[kind] ||
                     (places->are_moved && kind != PLACE_PARTITIONED && places->are_used[kind]) ||
                     is_place(places, kind, address, found == YES ? &bytes : NULL);
    pthread_mutex_unlock(&places->lock);
    return may;
}
