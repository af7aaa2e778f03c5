/* SPDX-License-Identifier: Apache-2.0 */
/* The barriers of vkCmdPipelineBarrier that were recorded, for tests. */
#include "internal.h"

enum { BARRIERS_MAX = 64 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards the members below */
static struct null_driver_barrier barriers[BARRIERS_MAX];
static uint32_t barrier_count;

uint32_t null_driver_take_barriers(struct null_driver_barrier *taken, uint32_t capacity)
{
    pthread_mutex_lock(&lock);
    const uint32_t count = barrier_count < capacity ? barrier_count : capacity;
    if (count > 0)
        memcpy(taken, barriers, count * sizeof(*taken));
    barrier_count = 0;
    pthread_mutex_unlock(&lock);
    return count;
}

static void add(struct null_driver_barrier barrier)
{
    barrier.builds = null_driver_calls("vkCmdBuildAccelerationStructuresKHR");
    pthread_mutex_lock(&lock);
    if (barrier_count < BARRIERS_MAX)
        barriers[barrier_count++] = barrier;
    pthread_mutex_unlock(&lock);
}

COMMAND(CmdPipelineBarrier)
{
    const struct null_driver_barrier stages = {.src = srcStageMask, .dst = dstStageMask};
    if (memoryBarrierCount + bufferMemoryBarrierCount == 0)
        add(stages);
    for (uint32_t i = 0; i < memoryBarrierCount; i++) {
        struct null_driver_barrier barrier = stages;
        barrier.src_access = pMemoryBarriers[i].srcAccessMask;
        barrier.dst_access = pMemoryBarriers[i].dstAccessMask;
        add(barrier);
    }
    for (uint32_t i = 0; i < bufferMemoryBarrierCount; i++) {
        struct null_driver_barrier barrier = stages;
        barrier.src_access = pBufferMemoryBarriers[i].srcAccessMask;
        barrier.dst_access = pBufferMemoryBarriers[i].dstAccessMask;
        barrier.buffer = pBufferMemoryBarriers[i].buffer;
        add(barrier);
    }
}
