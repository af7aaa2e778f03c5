/* SPDX-License-Identifier: Apache-2.0 */
/* Values by object and slot. The list of an object lives until the object is destroyed. */
#include "src/cpu/private_data.h"

#include <stdlib.h>

struct value {
    struct value *next;
    uint64_t slot; /* 0: free */
    uint64_t value;
};

void cpu_private_data_init(struct cpu_private_data *data)
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

void cpu_private_data_release(struct cpu_private_data *data)
{
    handle_table_drop(&data->objects, free_list);
    pthread_mutex_destroy(&data->lock);
}

static struct value *find(struct value *list, uint64_t slot)
{
    while (list && list->slot != slot)
        list = list->next;
    return list;
}

static struct value *add(struct cpu_private_data *data, uint64_t object, struct value *list)
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
    struct value *entry = find(list, slot);
    if (!entry)
        entry = find(list, 0);
    if (!entry)
        entry = add(data, object, list);
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
    const struct value *entry = find(handle_table_find(&data->objects, object), slot);
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

static void forget(void *record, void *slot)
{
    struct value *entry = find(record, *(const uint64_t *)slot);
    if (entry)
        *entry = (struct value){.next = entry->next};
}

void cpu_private_data_forget_slot(struct cpu_private_data *data, uint64_t slot)
{
    pthread_mutex_lock(&data->lock);
    handle_table_each(&data->objects, forget, &slot);
    pthread_mutex_unlock(&data->lock);
}
