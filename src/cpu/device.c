/* SPDX-License-Identifier: Apache-2.0 */
/* Creates and destroys backend cpu's part of a device: private data and scratch memory in use. */
#include "src/cpu/device.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"
#include "src/snapshots/memory.h"

struct value {
    struct value *next;
    uint64_t slot; /* 0: free */
    uint64_t value;
};

static void cpu_private_data_init(struct cpu_private_data *data)
{
    *data = (struct cpu_private_data){0};
    pthread_mutex_init(&data->lock, NULL);
}

static void free_list(void *record)
{
    for (struct value *value = record, *next; value; value = next) {
        next = value->next;
        free(value);
    }
}

static void cpu_private_data_release(struct cpu_private_data *data)
{
    handle_table_drop(&data->objects, free_list);
    pthread_mutex_destroy(&data->lock);
}

static struct value *find_slot_value(struct value *list, uint64_t slot)
{
    while (list && list->slot != slot)
        list = list->next;
    return list;
}

static struct value *add_value(struct cpu_private_data *data, uint64_t object, struct value *list)
{
    struct value *value = calloc(1, sizeof(*value));
    if (!value)
        return NULL;
    value->next = list;
    if (handle_table_set(&data->objects, object, value))
        return value;
    free(value);
    return NULL;
}

VkResult cpu_private_data_set(struct cpu_private_data *data, uint64_t object, uint64_t slot,
                              uint64_t value)
{
    pthread_mutex_lock(&data->lock);
    struct value *list = handle_table_find(&data->objects, object);
    struct value *entry = find_slot_value(list, slot);
    if (!entry)
        entry = find_slot_value(list, 0);
    if (!entry)
        entry = add_value(data, object, list);
    if (entry) {
        entry->slot = slot;
        entry->value = value;
    }
    pthread_mutex_unlock(&data->lock);
    return entry ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

uint64_t cpu_private_data_get(struct cpu_private_data *data, uint64_t object, uint64_t slot)
{
    pthread_mutex_lock(&data->lock);
    const struct value *entry = find_slot_value(handle_table_find(&data->objects, object), slot);
    uint64_t value = entry ? entry->value : 0;
    pthread_mutex_unlock(&data->lock);
    return value;
}

void cpu_private_data_forget_object(struct cpu_private_data *data, uint64_t object)
{
    pthread_mutex_lock(&data->lock);
    struct value *list = handle_table_remove(&data->objects, object);
    pthread_mutex_unlock(&data->lock);
    free_list(list);
}

static void forget_values(void *record, void *slot)
{
    struct value *entry = find_slot_value(record, *(const uint64_t *)slot);
    if (entry)
        *entry = (struct value){.next = entry->next};
}

void cpu_private_data_forget_slot(struct cpu_private_data *data, uint64_t slot)
{
    pthread_mutex_lock(&data->lock);
    handle_table_each(&data->objects, forget_values, &slot);
    pthread_mutex_unlock(&data->lock);
}

/* ---- scratch memory, and the list of scratch memory in use */

_Static_assert(CPU_SCRATCH_SLACK == BUILDER_ALIGNMENT - 1, "room to align in");

void cpu_scratch_claims_init(struct cpu_scratch_claims *claims)
{
    claims->first = NULL;
    pthread_mutex_init(&claims->lock, NULL);
}

void cpu_scratch_claims_release(struct cpu_scratch_claims *claims)
{
    pthread_mutex_destroy(&claims->lock);
}

static bool scratches_overlap(const struct cpu_scratch *a, const struct cpu_scratch *b)
{
    uintptr_t a_begin = (uintptr_t)a->bytes, b_begin = (uintptr_t)b->bytes;
    return a_begin < b_begin + b->size && b_begin < a_begin + a->size;
}

static bool claim_scratch(struct cpu_scratch_claims *claims, struct cpu_scratch *scratch)
{
    pthread_mutex_lock(&claims->lock);
    const struct cpu_scratch *other = claims->first;
    while (other && !scratches_overlap(other, scratch))
        other = other->next;
    if (!other) {
        scratch->next = claims->first;
        claims->first = scratch;
    }
    pthread_mutex_unlock(&claims->lock);
    return !other;
}

static void unclaim_scratch(struct cpu_scratch_claims *claims, struct cpu_scratch *scratch)
{
    pthread_mutex_lock(&claims->lock);
    struct cpu_scratch **link = &claims->first;
    while (*link && *link != scratch)
        link = &(*link)->next;
    if (*link)
        *link = scratch->next;
    pthread_mutex_unlock(&claims->lock);
}

VkResult cpu_scratch_take(struct cpu_scratch_claims *claims, void *given, uint64_t size,
                          struct cpu_scratch *scratch)
{
    uintptr_t misaligned = (uintptr_t)given % BUILDER_ALIGNMENT;
    uint64_t skipped = misaligned ? BUILDER_ALIGNMENT - misaligned : 0;
    *scratch = (struct cpu_scratch){.size = size, .claims = claims};
    if (given && size <= UINT64_MAX - skipped) {
        scratch->bytes = (char *)given + skipped;
        if (claim_scratch(claims, scratch)) {
            if (memory_is_writable(scratch->bytes, size))
                return VK_SUCCESS;
            unclaim_scratch(claims, scratch);
        }
    }
    uint64_t rounded = (size + BUILDER_ALIGNMENT - 1) & ~(uint64_t)(BUILDER_ALIGNMENT - 1);
    scratch->owned = aligned_allocate(BUILDER_ALIGNMENT, rounded ? rounded : BUILDER_ALIGNMENT);
    scratch->bytes = scratch->owned;
    return scratch->owned ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_scratch_return(struct cpu_scratch *scratch)
{
    if (!scratch->owned)
        unclaim_scratch(scratch->claims, scratch);
    aligned_free(scratch->owned);
}

/* ---- creates and destroys backend cpu's part of a device */

/* Change this whenever the serialized format changes. */
static const uint8_t compatibility[VK_UUID_SIZE] = "Assay trees 1";

VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device)
{
    struct cpu_device *state = calloc(1, sizeof(*state));
    *device = state;
    if (!state)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    memcpy(state->uuids.driver, driver_uuid, VK_UUID_SIZE);
    memcpy(state->uuids.compatibility, compatibility, VK_UUID_SIZE);
    cpu_scratch_claims_init(&state->scratch_claims);
    cpu_private_data_init(&state->private_data);
    VkResult result = cpu_structures_create(&state->structures);
    if (result == VK_SUCCESS)
        result = cpu_deferred_operations_create(&state->deferred);
    if (result == VK_SUCCESS)
        result = cpu_query_pools_create(&state->query_pools);
    if (result == VK_SUCCESS)
        return VK_SUCCESS;
    cpu_device_destroy(state);
    *device = NULL;
    return result;
}

void cpu_device_destroy(struct cpu_device *device)
{
    if (!device)
        return;
    cpu_deferred_operations_destroy(device->deferred);
    cpu_query_pools_destroy(device->query_pools);
    cpu_structures_destroy(device->structures);
    cpu_private_data_release(&device->private_data);
    cpu_scratch_claims_release(&device->scratch_claims);
    free(device);
}
