/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: creation, sizes, addresses, copies and queries of acceleration structures, and
 * deferred operations. */
#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/cpu/device.h"
#include "src/cpu/query_pools.h"
#include "src/cpu/structures.h"
#include "src/model/build_parameters.h"
#include "src/platform/clock.h"
#include "src/snapshots/build_input.h"

static struct buffer_facts find_buffer(struct resources *resources, VkBuffer handle)
{
    struct buffer_facts facts;
    resources_look_up_buffer(resources, handle, &facts);
    return facts;
}

VkResult cpu_create_structure(struct layer_device *device,
                              const VkAccelerationStructureCreateInfoKHR *create_info,
                              VkAccelerationStructureKHR *structure)
{
    const struct buffer_facts buffer = find_buffer(device->resources, create_info->buffer);
    const struct cpu_structure_info info = {
        .type = create_info->type,
        .size = create_info->size,
        .buffer_id = buffer.id,
        .buffer_size = buffer.size,
        .offset = create_info->offset,
    };
    uint64_t handle;
    VkResult result = cpu_structures_add(device->cpu->device->structures, &info, &handle);
    *structure = result == VK_SUCCESS ? (VkAccelerationStructureKHR)handle : VK_NULL_HANDLE;
    return result;
}

/* A structure or micromap whose buffer the backend need not know. `structure`: receives its handle.
 */
VkResult cpu_create_structure_of_size(struct cpu_structures *structures,
                                      VkAccelerationStructureTypeKHR type, VkDeviceSize size,
                                      void *structure)
{
    const struct cpu_structure_info info = {.type = type, .size = size};
    uint64_t handle = 0;
    VkResult result = cpu_structures_add(structures, &info, &handle);
    handle = result == VK_SUCCESS ? handle : 0;
    memcpy(structure, &handle, sizeof(handle));
    return result;
}

VkDeviceAddress cpu_get_address(struct cpu_structures *structures, uint64_t handle)
{
    struct cpu_structure_info info;
    return cpu_structures_find(structures, handle, &info) ? handle : 0;
}

VkResult cpu_create_operation(struct cpu_deferred_operations *deferred,
                              VkDeferredOperationKHR *operation)
{
    uint64_t handle;
    VkResult result = cpu_deferred_add(deferred, &handle);
    *operation = result == VK_SUCCESS ? (VkDeferredOperationKHR)handle : VK_NULL_HANDLE;
    return result;
}

/* ---- sizes and compatibility, and the end of a recording */

/* Builds of both types use the same builder. */
void cpu_get_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                         const uint32_t *max_primitive_counts,
                         VkAccelerationStructureBuildSizesInfoKHR *out)
{
    struct builder_sizes sizes;
    cpu_build_sizes(info, max_primitive_counts, &sizes);
    out->accelerationStructureSize = sizes.structure;
    out->buildScratchSize = sizes.build_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
    out->updateScratchSize = sizes.update_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
}

void cpu_compare_versions(struct cpu_device *backend, const uint8_t *version,
                          VkAccelerationStructureCompatibilityKHR *compatibility)
{
    const struct builder_uuids *uuids = &backend->uuids;
    struct readable_cache cache = {0};
    bool is_same =
        readable(&cache, version, sizeof(*uuids)) && memcmp(version, uuids, sizeof(*uuids)) == 0;
    *compatibility = is_same ? VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR
                             : VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR;
}

/* Reports lack of memory during recording. */
VkResult cpu_end_command_buffer(struct layer_device *device, PFN_vkEndCommandBuffer down,
                                VkCommandBuffer handle)
{
    const struct command_buffer *command_buffer =
        command_buffers_find(device->command_buffers, handle);
    VkResult result = down(handle);
    return result == VK_SUCCESS && command_buffer && command_buffer->work_failed
               ? VK_ERROR_OUT_OF_HOST_MEMORY
               : result;
}

/* ---- copies in command buffers; micromaps are structures, too */

void cpu_copy_structure(VkCommandBuffer commands, uint64_t dst, uint64_t src,
                        VkCopyAccelerationStructureModeKHR mode)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commands))
        return;
    recorder_add_copy(&recorder,
                      &(struct recorded_command){
                          .kind = CPU_COPY,
                          .structure = dst,
                          .src = src,
                          .compacts = mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR,
                      });
}

void cpu_write_structure(VkCommandBuffer commands, uint64_t src, VkDeviceAddress dst)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commands))
        return;
    recorder_add(&recorder, &(struct recorded_command){
                                .kind = CPU_SERIALIZE, .structure = src, .address = dst});
}

/* The most bytes that the serialized form of a structure of `size` bytes takes: the header, and a
 * reference for each instance. */
static uint64_t serialized_max(uint64_t size)
{
    uint64_t references = size / sizeof(VkAccelerationStructureInstanceKHR) * sizeof(uint64_t);
    return 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) + references + size;
}

void cpu_read_structure(VkCommandBuffer commands, uint64_t dst, VkDeviceAddress src)
{
    struct recorder recorder;
    struct cpu_structure_info info;
    if (!recorder_begin(&recorder, commands))
        return;
    struct recorded_command read = {.kind = CPU_DESERIALIZE, .structure = dst};
    if (!cpu_structures_find(recorder.device->cpu->device->structures, read.structure, &info))
        return;
    if (recorder_copy(&recorder, src, serialized_max(info.size), &read.serialized))
        recorder_add(&recorder, &read);
    recorder_end(&recorder);
}

/* ---- pools of structures' properties; other pools belong to the next layer */

VkResult cpu_create_query_pool(struct cpu_query_pools *pools,
                               const VkQueryPoolCreateInfo *create_info, VkQueryPool *pool)
{
    uint64_t handle = 0;
    VkResult result =
        cpu_query_pools_add(pools, create_info->queryType, create_info->queryCount, &handle);
    *pool = result == VK_SUCCESS ? (VkQueryPool)handle : VK_NULL_HANDLE;
    return result;
}

/* A query that waits may be written by a batch that waits for another thread to signal. As other
 * waits, this one is limited, because the application may be in a callback of that thread. */
enum { QUERY_WAITS = 10000, QUERY_WAIT_NANOSECONDS = 1000 * 1000 };

VkResult cpu_read_queries(struct layer_device *device, VkQueryPool pool, uint32_t first,
                          uint32_t count, size_t size, void *data, VkDeviceSize stride,
                          VkQueryResultFlags flags)
{
    struct cpu_query_pools *pools = device->cpu->device->query_pools;
    int left = flags & VK_QUERY_RESULT_WAIT_BIT ? QUERY_WAITS : 0;
    for (;; left--) {
        /* First: a batch that is no longer pending has written its queries. */
        const bool waits = left && execution_order_has_pending(device->order);
        const VkResult result =
            cpu_query_pools_read(pools, (uint64_t)pool, first, count, size, data, stride, flags);
        if (result != VK_NOT_READY || !waits)
            return result;
        clock_sleep(QUERY_WAIT_NANOSECONDS);
    }
}

/* ---- in command buffers */

static void record_command(VkCommandBuffer commands, const struct recorded_command *command)
{
    struct recorder recorder;
    if (recorder_begin(&recorder, commands))
        recorder_add(&recorder, command);
}

void cpu_reset_queries(VkCommandBuffer commands, VkQueryPool pool, uint32_t first, uint32_t count)
{
    record_command(commands, &(struct recorded_command){.kind = CPU_RESET_QUERIES,
                                                        .pool = (uint64_t)pool,
                                                        .first = first,
                                                        .count = count});
}

/* `structures`: handles of either kind. The type of the queries is that of the pool; another type
 * would be invalid usage. */
void cpu_write_queries(VkCommandBuffer commands, uint32_t count, const void *structures,
                       VkQueryPool pool, uint32_t first)
{
    struct recorder recorder;
    struct recorded_command write = {.kind = CPU_WRITE_QUERY, .pool = (uint64_t)pool};
    if (!recorder_begin(&recorder, commands) ||
        !cpu_query_pools_has(recorder.device->cpu->device->query_pools, write.pool) ||
        !readable(readable_cache_of_thread(), structures, count * sizeof(write.structure)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        write.first = first + i;
        memcpy(&write.structure, (const char *)structures + i * sizeof(write.structure),
               sizeof(write.structure));
        recorder_add(&recorder, &write);
    }
}

void cpu_copy_queries(VkCommandBuffer commands, VkQueryPool pool, uint32_t first, uint32_t count,
                      VkBuffer dst, VkDeviceSize offset, VkDeviceSize stride,
                      VkQueryResultFlags flags)
{
    record_command(commands,
                   &(struct recorded_command){
                       .kind = CPU_COPY_QUERIES,
                       .pool = (uint64_t)pool,
                       .first = first,
                       .count = count,
                       .stride = stride,
                       .flags = flags,
                       .target = {.buffer = dst, .offset = offset, .size = UINT64_MAX - offset},
                   });
}
