/* SPDX-License-Identifier: Apache-2.0 */
/* A list of ranges, each of which is added once, and what was read of the builds that put
 * something there. */
#include "src/state/builds/places.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/base/handle_table.h"
#include "src/platform/threads.h"
#include "src/state/resources/resources.h"

struct place {
    struct placed placed;
    struct memory_bytes bytes;  /* at the address */
    bool is_read, has_vertices; /* as places_set_templates_read() has said */
};

struct places {
    struct resources *resources;
    pthread_mutex_t lock; /* guards the rest */
    struct place *items;
    uint32_t count, capacity;
    bool are_used[PLACE_KINDS], are_unknown[PLACE_KINDS], are_moved, lack_memory;
    uint64_t executed, read; /* builds of templates and partitioned structures */
    /* Builds of new partitioned structures; and by index + 1, as a pointer, how many of them from
     * the first one on had an instance that may not be updated, or MAY_BE_UPDATED. */
    uintptr_t new_structures;
    struct handle_table instances;
};

#define MAY_BE_UPDATED UINTPTR_MAX

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
    handle_table_release(&places->instances);
    free(places->items);
    free(places);
}

static bool has_address(const struct place *place, VkDeviceAddress address)
{
    return address - place->placed.address < place->placed.size;
}

static bool has_bytes(const struct place *place, const struct memory_bytes *bytes)
{
    return bytes->memory_id == place->bytes.memory_id &&
           bytes->begin - place->bytes.begin < place->placed.size;
}

static bool is_known(const struct places *places, const struct place *added)
{
    for (uint32_t i = 0; i < places->count; i++) {
        const struct place *place = &places->items[i];
        const struct placed *placed = &place->placed;
        const uint64_t skipped = added->placed.address - placed->address;
        if (placed->kind == added->placed.kind && placed->format == added->placed.format &&
            has_address(place, added->placed.address) && has_bytes(place, &added->bytes) &&
            added->placed.size <= placed->size - skipped &&
            added->bytes.begin - place->bytes.begin == skipped)
            return true;
    }
    return false;
}

void places_add(struct places *places, const struct placed *placed)
{
    if (!places)
        return;
    struct place added = {.placed = *placed};
    bool is_external;
    if (resources_find_address_bytes(places->resources, placed->address, &added.bytes,
                                     &is_external) != YES) {
        places_add_unknown(places, placed->kind);
        return;
    }
    pthread_mutex_lock(&places->lock);
    places->are_used[placed->kind] = true;
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

static void set_flag(struct places *places, bool *flag)
{
    pthread_mutex_lock(&places->lock);
    *flag = true;
    pthread_mutex_unlock(&places->lock);
}

void places_add_moves(struct places *places)
{
    if (places)
        set_flag(places, &places->are_moved);
}

void places_lack_memory(struct places *places)
{
    if (places)
        set_flag(places, &places->lack_memory);
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

/* An address that is looked up. */
struct found {
    enum place_kind kind;
    VkDeviceAddress address;
    struct memory_bytes bytes; /* at the address; a memory_id of 0: none */
    bool is_certain;           /* no other device has put structures there */
};

static struct found look_up(struct places *places, enum place_kind kind, VkDeviceAddress address,
                            uint64_t destroy_count)
{
    struct found found = {.kind = kind, .address = address};
    bool is_external = false;
    const enum tristate has_bytes =
        resources_find_address_bytes(places->resources, address, &found.bytes, &is_external);
    if (has_bytes != YES)
        found.bytes = (struct memory_bytes){0};
    found.is_certain = has_bytes != UNKNOWN && !is_external &&
                       resources_destroy_count(places->resources) == destroy_count;
    return found;
}

/* Whether structures may be elsewhere than at places. Call with the lock. */
static bool may_be_anywhere(const struct places *places, enum place_kind kind)
{
    return places->lack_memory || places->are_unknown[kind] ||
           (places->are_moved && kind != PLACE_PARTITIONED && places->are_used[kind]);
}

/* Whether all structures that may be there are at places. Call with the lock. */
static bool has_all(const struct places *places, const struct found *found)
{
    return found->is_certain && !may_be_anywhere(places, found->kind);
}

static bool is_at(const struct place *place, const struct found *found)
{
    return place->placed.kind == found->kind &&
           (has_address(place, found->address) ||
            (found->bytes.memory_id && has_bytes(place, &found->bytes)));
}

bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address,
                     uint64_t destroy_count)
{
    if (!places)
        return false;
    const struct found found = look_up(places, kind, address, destroy_count);
    pthread_mutex_lock(&places->lock);
    bool may = !has_all(places, &found);
    for (uint32_t i = 0; !may && i < places->count; i++)
        may = is_at(&places->items[i], &found);
    pthread_mutex_unlock(&places->lock);
    return may;
}

/* ---- all addresses */

struct place_list {
    struct place *places; /* a copy of those of the kind */
    uint32_t place_count, count, capacity;
    struct place_range *ranges;
    bool are_anywhere;
};

static void list_range(struct place_list *list, uint64_t begin, uint64_t size)
{
    const uint64_t end = size > UINT64_MAX - begin ? UINT64_MAX : begin + size;
    if (ARRAY_HAS_ROOM(list->ranges, list->count, list->capacity))
        list->ranges[list->count++] = (struct place_range){begin, end};
    else
        list->are_anywhere = true;
}

/* The bytes of a place, as far as a buffer has them, also under the buffer's addresses. */
static void list_bytes(void *user, const struct addressed_bytes *there)
{
    struct place_list *list = user;
    const struct memory_bytes *bytes = &there->bytes;
    if (!bytes->memory_id || there->is_external) {
        list_range(list, there->address, bytes->size);
        return;
    }
    for (uint32_t i = 0; i < list->place_count; i++) {
        const struct place *place = &list->places[i];
        const uint64_t behind = place->bytes.begin - bytes->begin,
                       before = bytes->begin - place->bytes.begin;
        if (bytes->memory_id != place->bytes.memory_id)
            continue;
        if (behind < bytes->size)
            list_range(list, there->address + behind,
                       smaller_of(place->placed.size, bytes->size - behind));
        else if (before < place->placed.size)
            list_range(list, there->address, smaller_of(place->placed.size - before, bytes->size));
    }
}

/* Returns false if structures of the kind may be anywhere. */
static bool copy_places(struct places *places, enum place_kind kind, struct place_list *list)
{
    uint32_t capacity = 0;
    pthread_mutex_lock(&places->lock);
    list->are_anywhere = may_be_anywhere(places, kind);
    for (uint32_t i = 0; !list->are_anywhere && i < places->count; i++) {
        if (places->items[i].placed.kind != kind)
            continue;
        if (ARRAY_HAS_ROOM(list->places, list->place_count, capacity))
            list->places[list->place_count++] = places->items[i];
        else
            list->are_anywhere = true;
    }
    pthread_mutex_unlock(&places->lock);
    return !list->are_anywhere;
}

static int compare_ranges(const void *a, const void *b)
{
    const struct place_range *first = a, *second = b;
    return (first->begin > second->begin) - (first->begin < second->begin);
}

static uint32_t join_ranges(struct place_range *ranges, uint32_t count)
{
    uint32_t joined = 0;
    if (count)
        qsort(ranges, count, sizeof(*ranges), compare_ranges);
    for (uint32_t i = 0; i < count; i++) {
        struct place_range *last = joined ? &ranges[joined - 1] : NULL;
        if (!last || ranges[i].begin > last->end)
            ranges[joined++] = ranges[i];
        else if (ranges[i].end > last->end)
            last->end = ranges[i].end;
    }
    return joined;
}

struct place_range *places_list(struct places *places, enum place_kind kind, uint32_t *count)
{
    struct place_list list = {0};
    *count = 0;
    if (!places)
        return NULL;
    if (copy_places(places, kind, &list) &&
        !resources_visit_addresses(places->resources, list_bytes, &list))
        list.are_anywhere = true;
    for (uint32_t i = 0; i < list.place_count; i++)
        list_range(&list, list.places[i].placed.address, list.places[i].placed.size);
    *count = list.are_anywhere ? PLACES_ANYWHERE : join_ranges(list.ranges, list.count);
    free(list.places);
    return list.ranges;
}

/* ---- what was read */

uint64_t places_execute(struct places *places, enum place_kind kind)
{
    if (!places)
        return PLACE_UNNUMBERED;
    pthread_mutex_lock(&places->lock);
    const uint64_t before = places->executed;
    places->executed += kind == PLACE_TEMPLATE || kind == PLACE_PARTITIONED;
    pthread_mutex_unlock(&places->lock);
    return before;
}

bool places_are_read(struct places *places, uint64_t before)
{
    if (!places)
        return false;
    pthread_mutex_lock(&places->lock);
    const bool are_read = places->read == before && !places->lack_memory;
    pthread_mutex_unlock(&places->lock);
    return are_read;
}

void places_set_read(struct places *places, uint64_t before)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    places->read += places->read == before;
    pthread_mutex_unlock(&places->lock);
}

void places_set_templates_read(struct places *places, VkDeviceAddress address, VkFormat format,
                               bool has_vertices)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    for (uint32_t i = 0; i < places->count; i++) {
        struct place *place = &places->items[i];
        if (place->placed.kind != PLACE_TEMPLATE || place->placed.format != format ||
            !has_address(place, address))
            continue;
        place->is_read = true;
        place->has_vertices |= has_vertices;
    }
    pthread_mutex_unlock(&places->lock);
}

/* A template at the address is that of a place there, so all that were built must agree. */
struct template_facts places_find_template(struct places *places, VkDeviceAddress address,
                                           uint64_t destroy_count)
{
    struct template_facts facts = {.format = VK_FORMAT_UNDEFINED};
    uint32_t count = 0;
    if (!places)
        return facts;
    const struct found found = look_up(places, PLACE_TEMPLATE, address, destroy_count);
    pthread_mutex_lock(&places->lock);
    const uint32_t end = has_all(places, &found) ? places->count : 0;
    for (uint32_t i = 0; i < end; i++) {
        const struct place *place = &places->items[i];
        const VkFormat format = place->placed.format;
        if (!place->is_read || !is_at(place, &found))
            continue;
        facts.has_no_vertices = (!count || facts.has_no_vertices) && !place->has_vertices;
        facts.format = !count || facts.format == format ? format : VK_FORMAT_UNDEFINED;
        count++;
    }
    pthread_mutex_unlock(&places->lock);
    return facts;
}

void places_begin_instances(struct places *places)
{
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    places->new_structures++;
    pthread_mutex_unlock(&places->lock);
}

void places_add_instance(struct places *places, uint32_t index, bool is_new, bool may_be_updated)
{
    const uint64_t key = 1 + (uint64_t)index;
    if (!places)
        return;
    pthread_mutex_lock(&places->lock);
    uintptr_t known = (uintptr_t)handle_table_find(&places->instances, key);
    const uintptr_t before = known;
    if (may_be_updated)
        known = MAY_BE_UPDATED;
    else if (is_new && known == places->new_structures - 1)
        known = places->new_structures;
    if (known != before && !handle_table_set(&places->instances, key, (void *)known)) // NOLINT
        places->lack_memory = true;
    pthread_mutex_unlock(&places->lock);
}

bool places_instance_is_fixed(struct places *places, uint32_t index)
{
    if (!places)
        return false;
    pthread_mutex_lock(&places->lock);
    const uintptr_t known = (uintptr_t)handle_table_find(&places->instances, 1 + (uint64_t)index);
    const bool is_fixed = known && known == places->new_structures && !places->lack_memory;
    pthread_mutex_unlock(&places->lock);
    return is_fixed;
}

bool places_are_own(struct places *places, VkDeviceAddress address, uint64_t destroy_count)
{
    return places && look_up(places, PLACE_PARTITIONED, address, destroy_count).is_certain;
}
