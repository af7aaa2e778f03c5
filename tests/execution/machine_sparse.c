/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's structures in sparse buffers, and what is bound to those. */
#include <stdlib.h>

#include "machine.h"

void machine_create_sparse(struct machine *machine, uint32_t structure)
{
    struct scene *scene = machine->scene;
    struct test_buffer *buffer = &machine->structures[structure].buffer;
    *buffer = scene_sparse_buffer(scene, MACHINE_ACCEL_SIZE, ACCEL_USAGE,
                                  VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT |
                                      VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
    if (MACHINE_ACCEL_SIZE % scene_sparse_page(scene, buffer) != 0)
        abort();
    if (machine->pages.handle == VK_NULL_HANDLE)
        machine->pages = scene_allocate(scene, (VkDeviceSize)SPARSE_PAGES * MACHINE_ACCEL_SIZE);
    machine->structures[structure].handle =
        scene_accel_in(scene, buffer, 0, MACHINE_ACCEL_SIZE, machine->type);
}

void machine_bind(struct machine *machine, const struct step *step)
{
    static const struct machine_batch empty;
    const struct machine_batch *batch = machine->batch_count != 0 ? machine->batches : &empty;
    struct machine_semaphores semaphores;

    machine_fill_semaphores(&semaphores, batch);
    const VkSparseMemoryBind bind = {
        .size = MACHINE_ACCEL_SIZE,
        .memory = step->value != 0 ? machine->pages.handle : VK_NULL_HANDLE,
        .memoryOffset = step->value != 0 ? (step->value - 1) * MACHINE_ACCEL_SIZE : 0,
    };
    const VkSparseBufferMemoryBindInfo buffer_bind = {
        .buffer = machine->structures[step->dst].buffer.handle, .bindCount = 1, .pBinds = &bind};
    const VkBindSparseInfo info = MAKE(
        VkBindSparseInfo, .pNext = &semaphores.values, .waitSemaphoreCount = batch->wait_count,
        .pWaitSemaphores = semaphores.waits, .bufferBindCount = 1, .pBufferBinds = &buffer_bind,
        .signalSemaphoreCount = batch->signal_count, .pSignalSemaphores = semaphores.signals);
    machine->result =
        machine->vk->QueueBindSparse(machine->queues[step->object], 1, &info,
                                     step->detail != 0 ? machine->fence : VK_NULL_HANDLE);
}
