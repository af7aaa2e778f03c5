/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of words and a list of unused ones, and the commands that write marks. */
#include "layer/snapshots/marks.h"

#include <stdlib.h>

#include "src/base/array.h"

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

/* Sets all to 0. */
static void words_clear(const struct mapped_words *words)
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

/* ---- the commands that write marks, and what the marks say */

/* ---- commands */

static bool add_mark(struct recording *recording, const struct build_mark *mark)
{
    struct build_marks *marks = &recording->marks;
    if (!ARRAY_HAS_ROOM(marks->items, marks->count, marks->capacity))
        return false;
    marks->items[marks->count++] = *mark;
    return true;
}

/* Writes a word when all earlier commands have completed a stage. A timestamp waits for the stage,
 * and the copy of its result waits for the timestamp, so that no command of the application waits:
 * a barrier before a fill would order the application's own transfers, too. */
static void write_after(const struct recorder *recorder, const struct mapped_words *words, int word,
                        VkPipelineStageFlagBits stage)
{
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    const uint32_t query = words->first_query + (word == MARK_FINISHED);
    next->CmdResetQueryPool(recorder->handle, words->queries, query, 1);
    next->CmdWriteTimestamp(recorder->handle, stage, words->queries, query);
    next->CmdCopyQueryPoolResults(recorder->handle, words->queries, query, 1, words->buffer,
                                  words->offset + (word - 1) * sizeof(uint32_t), sizeof(uint64_t),
                                  VK_QUERY_RESULT_WAIT_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
}

static bool has_timestamps(const struct recorder *recorder)
{
    const struct layer_device *device = recorder->device;
    const uint32_t family = recorder->command_buffer->pool->queue_family;
    return family < device->queue_family_count && device->queue_families[family].timestampValidBits;
}

void recorder_mark_reached(const struct recorder *recorder, VkPipelineStageFlags copies)
{
    struct build_marks *marks = &recorder->recording->marks;
    struct build_mark mark;
    marks->is_open = false;
    if (!recorder->build_count || recorder->recording->executes_at_once ||
        !has_timestamps(recorder) || !words_take(recorder->device->snapshots->words, &mark.words))
        return;
    if (!add_mark(recorder->recording, &mark)) {
        words_give_back(recorder->device->snapshots->words, &mark.words);
        return;
    }
    struct journal_walk builds = journal_start_builds_of_call(recorder->recording->journal);
    for (const struct journal_entry *entry; (entry = journal_next(&builds));)
        if (journal_copies(entry))
            journal_copies(entry)->mark = marks->count;
    /* If there are both, the last dispatch waits for the transfers. */
    write_after(recorder, &mark.words, MARK_REACHED,
                copies & VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT
                                                              : VK_PIPELINE_STAGE_TRANSFER_BIT);
    marks->is_open = true;
}

void recorder_mark_finished(const struct recorder *recorder)
{
    struct build_marks *marks = &recorder->recording->marks;
    if (!marks->is_open)
        return;
    write_after(recorder, &marks->items[marks->count - 1].words, MARK_FINISHED,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR);
    marks->is_open = false;
}

/* ---- what the marks of a recording say */

void recording_clear_marks(struct recording *recording, const struct ticket *ticket,
                           bool is_pending)
{
    struct build_marks *marks = &recording->marks;
    uint64_t number = ticket ? ticket->number : 0;
    bool is_only = !is_pending && atomic_load(&marks->ticket) != number;
    for (uint32_t i = 0; is_only && i < marks->count; i++)
        words_clear(&marks->items[i].words);
    atomic_store(&marks->ticket, is_only ? number : 0);
}

enum mark_state recording_mark_state(const struct recording *recording, uint32_t mark,
                                     uint64_t ticket)
{
    uint64_t own = atomic_load(&recording->marks.ticket);
    if (!mark || !own || (ticket && own != ticket))
        return MARK_IS_UNKNOWN;
    _Atomic uint32_t *words = recording->marks.items[mark - 1].words.words;
    if (atomic_load(&words[MARK_FINISHED]))
        return MARK_HAS_BUILDS;
    return atomic_load(&words[MARK_REACHED]) ? MARK_HAS_COPIES : MARK_IS_CLEAR;
}
