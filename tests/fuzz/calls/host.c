/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of the host, deferred operations, traces; and an ordinary scene to begin with. */
#include "calls.h"

static VkDeferredOperationKHR take_operation(struct calls *calls)
{
    const struct slot *slot = pick(calls, OPERATIONS);
    return take(calls) % 4 == 1 ? HANDLE_OF(VkDeferredOperationKHR, slot) : VK_NULL_HANDLE;
}

/* ---- copies; what deferred ones are told stays, so it is kept for good */

void call_host_copy(struct calls *calls)
{
    static VkCopyAccelerationStructureInfoKHR info;
    const VkDeferredOperationKHR operation = take_operation(calls);
    info = take_copy(calls);
    calls->vk.CopyAccelerationStructureKHR(calls->device, operation, &info);
}

void call_host_serialize(struct calls *calls)
{
    static VkCopyAccelerationStructureToMemoryInfoKHR info;
    const VkDeferredOperationKHR operation = take_operation(calls);
    info = MAKE(VkCopyAccelerationStructureToMemoryInfoKHR,
                .src = PICK(VkAccelerationStructureKHR, calls, STRUCTURES),
                .dst.hostAddress = calls->result,
                .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR);
    calls->vk.CopyAccelerationStructureToMemoryKHR(calls->device, operation, &info);
}

void call_host_deserialize(struct calls *calls)
{
    static VkCopyMemoryToAccelerationStructureInfoKHR info;
    const VkDeferredOperationKHR operation = take_operation(calls);
    const VkAccelerationStructureKHR dst = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    info = MAKE(VkCopyMemoryToAccelerationStructureInfoKHR, .dst = dst,
                .src.hostAddress = take(calls) % 2 ? take_pointer(calls) : calls->result,
                .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR);
    calls->vk.CopyMemoryToAccelerationStructureKHR(calls->device, operation, &info);
}

void call_host_properties(struct calls *calls)
{
    static const VkQueryType types[] = {
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR};
    const VkAccelerationStructureKHR first = PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    const VkAccelerationStructureKHR structures[] = {
        first, PICK(VkAccelerationStructureKHR, calls, STRUCTURES)};
    const uint32_t count = 1u + take(calls) % 2;
    uint64_t values[2];
    calls->vk.WriteAccelerationStructuresPropertiesKHR(calls->device, count, structures,
                                                       TAKE(calls, types), sizeof(values), values,
                                                       sizeof(values[0]));
}

/* ---- deferred operations */

void call_operation(struct calls *calls)
{
    struct slot *slot = pick(calls, OPERATIONS);
    VkDeferredOperationKHR handle = HANDLE_OF(VkDeferredOperationKHR, slot);
    const uint8_t kind = take(calls);
    if (kind % 4 == 0) {
        keep(calls, slot, 0,
             calls->vk.CreateDeferredOperationKHR(calls->device, NULL, CREATED(calls)));
    } else if (kind % 4 == 1) {
        calls->vk.DeferredOperationJoinKHR(calls->device, handle);
    } else if (kind % 4 == 2) {
        calls->vk.GetDeferredOperationResultKHR(calls->device, handle);
    } else {
        calls->vk.DestroyDeferredOperationKHR(calls->device, handle, NULL);
    }
}

/* ---- traces, which read what is built */

void call_trace(struct calls *calls)
{
    const AssayRay ray = {
        .origin = {0.25f, 0.25f, -1}, .direction = {0, 0, 1}, .tMax = 10, .cullMask = 0xff};
    const struct slot *structure = pick(calls, STRUCTURES);
    AssayHit hit;
    const bool by_address = take(calls) % 2;
    const AssayTraceInfo info = {.accelerationStructure =
                                     by_address ? structure->address
                                                : (uint64_t)(uintptr_t)structure->handle,
                                 .accuracy = (AssayAccuracy)(take(calls) % 3),
                                 .rayCount = 1,
                                 .raySize = sizeof(ray),
                                 .hitSize = sizeof(hit),
                                 .rays = &ray,
                                 .hits = &hit};
    if (calls->trace)
        calls->trace(calls->device, &info);
}

/* ---- the scene: the first buffers are of input, of structures and of scratch */

/* Bytes that a stream could have begun with. */
static void play(struct calls *calls, void (*call)(struct calls *calls), const uint8_t *bytes,
                 size_t count)
{
    const uint8_t *at = calls->at, *end = calls->end;
    calls->at = bytes;
    calls->end = bytes + count;
    call(calls);
    calls->at = at;
    calls->end = end;
}

#define PLAY(calls, name, ...)                                                                     \
    play(calls, call_##name, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

void calls_prepare(struct calls *calls)
{
    enum { MEBIBYTE = 3, SMALL = 1 };
    for (uint8_t i = 0; i < 3; i++) {
        PLAY(calls, allocate_memory, i, 0, MEBIBYTE);
        PLAY(calls, map_memory, i);
        PLAY(calls, create_buffer, i, MEBIBYTE);
        PLAY(calls, bind_buffer, i, i);
    }
    for (uint8_t i = 0; i < 3; i++) {
        const uint8_t offsets[] = {0, 10, 18};
        PLAY(calls, create_structure, i, 1, 0, offsets[i], SMALL, i == 2);
        PLAY(calls, get_structure_address, i);
    }
    PLAY(calls, create_pool, 0);
    for (uint8_t i = 0; i < slot_counts[COMMAND_BUFFERS] - 1; i++)
        PLAY(calls, allocate_commands, i, 0, i > 2);
    PLAY(calls, create_sync, 2, 0);
    PLAY(calls, create_sync, 0, 1);
    PLAY(calls, create_query_pool, 0);
    PLAY(calls, operation, 0);
    PLAY(calls, write_data, 0, 0, 0);
    PLAY(calls, write_data, 128, 0, 0);
}
