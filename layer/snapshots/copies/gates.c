/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of gates, and a list of unused ones. */
#include "layer/snapshots/copies/gates.h"

#include <stdlib.h>

enum { BLOCK_GATES = 1024 };

struct gate_block {
    struct gate_block *next;
    struct own_buffer buffer;
};

struct gates {
    const struct layer_device *device;
    pthread_mutex_t lock; /* guards the members below; held while a block is created */
    struct gate_block *blocks;
    struct recording_gate *free; /* has room for all gates */
    uint32_t free_count, count;
};

VkResult gates_create(const struct layer_device *device, struct gates **gates)
{
    *gates = calloc(1, sizeof(**gates));
    if (!*gates)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*gates)->device = device;
    pthread_mutex_init(&(*gates)->lock, NULL);
    return VK_SUCCESS;
}

static void free_block(const struct layer_device *device, struct gate_block *block)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    own_buffer_free(&own, &block->buffer);
    free(block);
}

void gates_destroy(struct gates *gates)
{
    if (!gates)
        return;
    while (gates->blocks) {
        struct gate_block *block = gates->blocks;
        gates->blocks = block->next;
        free_block(gates->device, block);
    }
    pthread_mutex_destroy(&gates->lock);
    free(gates->free);
    free(gates);
}

static struct gate_block *create_block(const struct layer_device *device)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    struct gate_block *block = calloc(1, sizeof(*block));
    if (!block)
        return NULL;
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    if (own_buffer_create(&own, usage, BLOCK_GATES * sizeof(uint32_t), true, &block->buffer) ==
        VK_SUCCESS)
        return block;
    free_block(device, block);
    return NULL;
}

/* Called with the lock held. */
static bool add_block(struct gates *gates)
{
    struct recording_gate *grown =
        realloc(gates->free, (gates->count + BLOCK_GATES) * sizeof(*grown));
    if (!grown)
        return false;
    gates->free = grown;
    struct gate_block *block = create_block(gates->device);
    if (!block)
        return false;
    block->next = gates->blocks;
    gates->blocks = block;
    for (uint32_t i = 0; i < BLOCK_GATES; i++)
        gates->free[gates->free_count++] =
            (struct recording_gate){.is_open = (_Atomic uint32_t *)(void *)block->buffer.bytes + i,
                                    .address = block->buffer.address + i * sizeof(uint32_t)};
    gates->count += BLOCK_GATES;
    return true;
}

bool gates_take(struct gates *gates, struct recording_gate *gate)
{
    pthread_mutex_lock(&gates->lock);
    bool has_one = gates->free_count || add_block(gates);
    if (has_one)
        *gate = gates->free[--gates->free_count];
    pthread_mutex_unlock(&gates->lock);
    if (has_one)
        atomic_store(gate->is_open, 0);
    return has_one;
}

void gates_give_back(struct gates *gates, const struct recording_gate *gate)
{
    atomic_store(gate->is_open, 0);
    pthread_mutex_lock(&gates->lock);
    gates->free[gates->free_count++] = *gate;
    pthread_mutex_unlock(&gates->lock);
}
