/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, and what they do to the bytes of memory: recorded, and done at submission.
 * Everything else that they record does nothing. */
#include "internal.h"

#include <stdlib.h>

enum transfer_kind { COPY, UPDATE, FILL, WRITE, DISPATCH, EXECUTE, BUILD, INSTANCES };

struct transfer {
    struct transfer *next;
    enum transfer_kind kind;
    VkBuffer src, dst;
    VkBufferCopy region;
    uint32_t word;                    /* of FILL */
    VkCommandBuffer secondary;        /* of EXECUTE */
    VkDeviceAddress address;          /* of WRITE */
    _Alignas(8) unsigned char data[]; /* of UPDATE and WRITE; a struct dispatch, or instances */
};

void transfers_release(struct object *commands)
{
    for (struct transfer *next, *at = commands->command_buffer.first; at != NULL; at = next) {
        next = at->next;
        free(at);
    }
    commands->command_buffer.first = commands->command_buffer.last = NULL;
    commands->command_buffer.compute = (struct dispatch){0};
}

/* A freed command buffer, which tests may still record to, keeps nothing. A driver may count on
 * usages. */
static void add(VkCommandBuffer handle, const struct transfer *transfer, const void *data)
{
    struct object *commands = OBJECT(handle);
    const size_t size = data != NULL ? transfer->region.size : 0;
    const bool is_kept = commands->type == VK_OBJECT_TYPE_COMMAND_BUFFER &&
                         buffer_has_usage(transfer->src, VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT) &&
                         buffer_has_usage(transfer->dst, VK_BUFFER_USAGE_2_TRANSFER_DST_BIT);
    struct transfer *copy = is_kept ? driver_allocate(NULL, sizeof(*copy) + size) : NULL;
    if (copy == NULL)
        return;
    *copy = *transfer;
    if (size > 0)
        memcpy(copy->data, data, size);
    if (commands->command_buffer.last != NULL)
        commands->command_buffer.last->next = copy;
    else
        commands->command_buffer.first = copy;
    commands->command_buffer.last = copy;
}

/* ---- recording */

COMMAND(ResetCommandPool)
{
    const struct object *pool = FIND(COMMAND_POOL, commandPool);
    for (struct object *child = pool != NULL ? pool->children : NULL; child != NULL;
         child = child->next)
        transfers_release(child);
    return VK_SUCCESS;
}

COMMAND(CmdCopyBuffer)
{
    for (uint32_t i = 0; i < regionCount; i++)
        add(commandBuffer,
            &(struct transfer){
                .kind = COPY, .src = srcBuffer, .dst = dstBuffer, .region = pRegions[i]},
            NULL);
}

COMMAND(CmdCopyBuffer2)
{
    for (uint32_t i = 0; i < pCopyBufferInfo->regionCount; i++) {
        const VkBufferCopy2 *region = &pCopyBufferInfo->pRegions[i];
        add(commandBuffer,
            &(struct transfer){.kind = COPY,
                               .src = pCopyBufferInfo->srcBuffer,
                               .dst = pCopyBufferInfo->dstBuffer,
                               .region = {region->srcOffset, region->dstOffset, region->size}},
            NULL);
    }
}

COMMAND(CmdUpdateBuffer)
{
    add(commandBuffer,
        &(struct transfer){.kind = UPDATE, .dst = dstBuffer, .region = {0, dstOffset, dataSize}},
        pData);
}

COMMAND(CmdFillBuffer)
{
    add(commandBuffer,
        &(struct transfer){
            .kind = FILL, .dst = dstBuffer, .region = {0, dstOffset, size}, .word = data},
        NULL);
}

static void add_marker(VkCommandBuffer handle, VkBuffer dst, VkDeviceSize offset, uint32_t marker)
{
    add(handle,
        &(struct transfer){.kind = FILL, .dst = dst, .region = {0, offset, 4}, .word = marker},
        NULL);
}

COMMAND(CmdWriteBufferMarkerAMD)
{
    add_marker(commandBuffer, dstBuffer, dstOffset, marker);
}

COMMAND(CmdWriteBufferMarker2AMD)
{
    add_marker(commandBuffer, dstBuffer, dstOffset, marker);
}

/* All queries are available at once, so this writes a result and its availability: 1 for each. */
COMMAND(CmdCopyQueryPoolResults)
{
    const struct object *pool = FIND(QUERY_POOL, queryPool);
    if (pool != NULL && pool->query_type == VK_QUERY_TYPE_TIMESTAMP && queryCount == 1 &&
        flags == (VK_QUERY_RESULT_WAIT_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT))
        add(commandBuffer,
            &(struct transfer){.kind = FILL,
                               .dst = dstBuffer,
                               .region = {0, dstOffset, 2 * sizeof(uint32_t)},
                               .word = 1},
            NULL);
}

COMMAND(CmdExecuteCommands)
{
    for (uint32_t i = 0; i < commandBufferCount; i++)
        add(commandBuffer, &(struct transfer){.kind = EXECUTE, .secondary = pCommandBuffers[i]},
            NULL);
}

void transfers_add_build(VkCommandBuffer commands)
{
    if (fault_is_at_build())
        add(commands, &(struct transfer){.kind = BUILD}, NULL);
}

void transfers_add_write(VkCommandBuffer commands, VkDeviceAddress address, const void *bytes,
                         VkDeviceSize size)
{
    add(commands, &(struct transfer){.kind = WRITE, .address = address, .region.size = size},
        bytes);
}

void transfers_add_dispatch(VkCommandBuffer commands, const struct dispatch *dispatch)
{
    add(commands, &(struct transfer){.kind = DISPATCH, .region.size = sizeof(*dispatch)}, dispatch);
}

void transfers_add_instances(VkCommandBuffer commands, const struct instances *instances)
{
    add(commands, &(struct transfer){.kind = INSTANCES, .region.size = sizeof(*instances)},
        instances);
}

/* ---- execution */

static atomic_bool executes_nothing;

void null_driver_set_executes_nothing(bool nothing)
{
    atomic_store(&executes_nothing, nothing);
}

/* Ends at the first byte that has no memory. */
static void copy(const struct transfer *transfer)
{
    VkDeviceSize size;
    for (VkDeviceSize done = 0; done < transfer->region.size; done += size) {
        size = transfer->region.size - done;
        unsigned char *to = buffer_bytes(transfer->dst, transfer->region.dstOffset + done, &size);
        const unsigned char *from =
            transfer->kind == UPDATE
                ? transfer->data + done
                : buffer_bytes(transfer->src, transfer->region.srcOffset + done, &size);
        if (to == NULL || from == NULL)
            return;
        memmove(to, from, size);
    }
}

/* The host may read marks while the device hangs. */
static void store_word(unsigned char *to, uint32_t word)
{
    if ((uintptr_t)to % sizeof(word) == 0)
        __atomic_store_n((uint32_t *)(void *)to, word, __ATOMIC_RELEASE);
    else
        memcpy(to, &word, sizeof(word));
}

static void fill(const struct transfer *transfer)
{
    VkDeviceSize size;
    for (VkDeviceSize done = 0; done < transfer->region.size; done += size) {
        size = transfer->region.size - done;
        unsigned char *to = buffer_bytes(transfer->dst, transfer->region.dstOffset + done, &size);
        if (to == NULL || size < sizeof(uint32_t))
            return;
        size -= size % sizeof(uint32_t);
        for (VkDeviceSize i = 0; i < size; i += sizeof(uint32_t))
            store_word(to + i, transfer->word);
    }
}

static bool execute_one_level(VkCommandBuffer commands, bool primary);

/* Returns false if a fault ends the execution. */
static bool execute(const struct transfer *at, bool primary)
{
    switch (at->kind) {
    case FILL:
        fill(at);
        return true;
    case WRITE:
        address_write(at->address, at->data, at->region.size);
        return true;
    case BUILD:
        return !fault_at_build();
    case INSTANCES:
        instances_read((const void *)at->data);
        return true;
    case EXECUTE:
        return !primary || execute_one_level(at->secondary, false);
    case DISPATCH:
        if (fault_before_copies())
            return false;
        dispatch_execute((const void *)at->data);
        return true;
    default:
        if (fault_before_copies())
            return false;
        copy(at);
        return true;
    }
}

/* A command buffer that was destroyed, or reset, has nothing to do. */
static bool execute_one_level(VkCommandBuffer commands, bool primary)
{
    const struct object *object = OBJECT(commands);
    if (object == NULL || object->type != VK_OBJECT_TYPE_COMMAND_BUFFER)
        return true;
    for (const struct transfer *at = object->command_buffer.first; at != NULL; at = at->next)
        if (!execute(at, primary))
            return false;
    return true;
}

/* Command buffers execute one after the other, as if semaphores ordered all queues. */
static pthread_mutex_t execution_lock = PTHREAD_MUTEX_INITIALIZER;

bool transfers_execute(VkCommandBuffer commands)
{
    pthread_mutex_lock(&execution_lock);
    const bool goes_on = atomic_load(&executes_nothing) || execute_one_level(commands, true);
    pthread_mutex_unlock(&execution_lock);
    return goes_on;
}

/* ---- command buffers */

static void free_command_buffers(uint32_t count, const VkCommandBuffer *buffers)
{
    for (uint32_t i = 0; i < count; i++)
        object_destroy_dispatchable(buffers[i], VK_OBJECT_TYPE_COMMAND_BUFFER);
}

COMMAND(AllocateCommandBuffers)
{
    struct object *pool = FIND(COMMAND_POOL, pAllocateInfo->commandPool);
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < pAllocateInfo->commandBufferCount; i++) {
        pCommandBuffers[i] =
            (VkCommandBuffer)object_create(pool, VK_OBJECT_TYPE_COMMAND_BUFFER, transfers_release);
        if (pCommandBuffers[i] == VK_NULL_HANDLE) {
            free_command_buffers(i, pCommandBuffers);
            memset(pCommandBuffers, 0, pAllocateInfo->commandBufferCount * sizeof(VkCommandBuffer));
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        }
    }
    return VK_SUCCESS;
}

COMMAND(FreeCommandBuffers)
{
    free_command_buffers(commandBufferCount, pCommandBuffers);
}
