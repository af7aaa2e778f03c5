/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of words, and a list of unused ones. */
#include "layer/snapshots/words.h"

#include <stdlib.h>

enum { BLOCK_ENTRIES = 1024, ENTRY_SIZE = MAPPED_WORDS * sizeof(uint32_t) };

struct word_block {
    struct word_block *next;
    struct own_buffer buffer;
    VkQueryPool queries;
};

struct word_pool {
    const struct layer_device *device;
    pthread_mutex_t lock; /* guards the members below; held while a block is created */
    struct word_block *blocks;
    struct mapped_words *free; /* has room for all entries */
    uint32_t free_count, count;
};

VkResult word_pool_create(const struct layer_device *device, struct word_pool **pool)
{
    *pool = calloc(1, sizeof(**pool));
    if (!*pool)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*pool)->device = device;
    pthread_mutex_init(&(*pool)->lock, NULL);
    return VK_SUCCESS;
}

static void free_block(const struct layer_device *device, struct word_block *block)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    own_buffer_free(&own, &block->buffer);
    if (block->queries)
        own.vk->DestroyQueryPool(own.handle, block->queries, NULL);
    free(block);
}

void word_pool_destroy(struct word_pool *pool)
{
    if (!pool)
        return;
    while (pool->blocks) {
        struct word_block *block = pool->blocks;
        pool->blocks = block->next;
        free_block(pool->device, block);
    }
    pthread_mutex_destroy(&pool->lock);
    free(pool->free);
    free(pool);
}

/* Shaders read gates by their addresses; vkCmdCopyQueryPoolResults writes marks. */
static struct word_block *create_block(const struct layer_device *device)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    const VkBufferUsageFlags shader_usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | (device->snapshots->has_addresses ? shader_usage : 0);
    const VkQueryPoolCreateInfo queries = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_TIMESTAMP,
        .queryCount = BLOCK_ENTRIES * MAPPED_QUERIES,
    };
    struct word_block *block = calloc(1, sizeof(*block));
    if (!block)
        return NULL;
    if (own_buffer_create(&own, usage, BLOCK_ENTRIES * ENTRY_SIZE, true, &block->buffer) ==
            VK_SUCCESS &&
        own.vk->CreateQueryPool(own.handle, &queries, NULL, &block->queries) == VK_SUCCESS)
        return block;
    free_block(device, block);
    return NULL;
}

/* Called with the lock held. */
static bool add_block(struct word_pool *pool)
{
    struct mapped_words *grown =
        realloc(pool->free, (pool->count + BLOCK_ENTRIES) * sizeof(*grown));
    if (!grown)
        return false;
    pool->free = grown;
    struct word_block *block = create_block(pool->device);
    if (!block)
        return false;
    block->next = pool->blocks;
    pool->blocks = block;
    _Atomic uint32_t *words = (_Atomic uint32_t *)(void *)block->buffer.bytes;
    for (uint32_t i = 0; i < BLOCK_ENTRIES; i++)
        pool->free[pool->free_count++] =
            (struct mapped_words){.words = words + i * MAPPED_WORDS,
                                  .buffer = block->buffer.handle,
                                  .offset = i * (uint64_t)ENTRY_SIZE,
                                  .address = block->buffer.address + i * (uint64_t)ENTRY_SIZE,
                                  .queries = block->queries,
                                  .first_query = i * MAPPED_QUERIES};
    pool->count += BLOCK_ENTRIES;
    return true;
}

void words_clear(const struct mapped_words *words)
{
    for (int i = 0; i < MAPPED_WORDS; i++)
        atomic_store(&words->words[i], 0);
}

bool words_take(struct word_pool *pool, struct mapped_words *words)
{
    pthread_mutex_lock(&pool->lock);
    bool has_one = pool->free_count || add_block(pool);
    if (has_one)
        *words = pool->free[--pool->free_count];
    pthread_mutex_unlock(&pool->lock);
    if (has_one)
        words_clear(words);
    return has_one;
}

/* Clears the words at once: the device must find a released gate closed. */
void words_give_back(struct word_pool *pool, const struct mapped_words *words)
{
    words_clear(words);
    pthread_mutex_lock(&pool->lock);
    pool->free[pool->free_count++] = *words;
    pthread_mutex_unlock(&pool->lock);
}
