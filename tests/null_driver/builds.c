/* SPDX-License-Identifier: Apache-2.0 */
/* Builds, at which a fault may happen. Those of top-level structures read the references of their
 * instances if a test asks for that. Otherwise they look at nothing: their parameters may be
 * invalid. */
#include "internal.h"

enum { REFERENCES_MAX = 256, MOTION_STRIDE = 160 };

static atomic_bool is_reading;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards the next two */
static uint64_t references[REFERENCES_MAX];
static uint32_t reference_count;

void null_driver_set_reads_instances(bool reads)
{
    atomic_store(&is_reading, reads);
}

uint32_t null_driver_take_references(uint64_t *taken, uint32_t capacity)
{
    pthread_mutex_lock(&lock);
    const uint32_t count = reference_count < capacity ? reference_count : capacity;
    memcpy(taken, references, count * sizeof(*taken));
    reference_count = 0;
    pthread_mutex_unlock(&lock);
    return count;
}

/* ---- recording */

static void add_instances(VkCommandBuffer commands,
                          const VkAccelerationStructureBuildGeometryInfoKHR *info,
                          const VkAccelerationStructureBuildRangeInfoKHR *range,
                          VkDeviceAddress indirect_range)
{
    const VkAccelerationStructureGeometryKHR *geometry =
        info->pGeometries != NULL ? info->pGeometries : info->ppGeometries[0];
    const VkAccelerationStructureGeometryInstancesDataKHR *data = &geometry->geometry.instances;
    if (geometry->geometryType != VK_GEOMETRY_TYPE_INSTANCES_KHR)
        return;
    const struct instances instances = {
        .data = data->data.deviceAddress + range->primitiveOffset,
        .range = indirect_range,
        .count = range->primitiveCount,
        .are_pointers = data->arrayOfPointers,
        .have_motion = info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV};
    transfers_add_instances(commands, &instances);
}

COMMAND(CmdBuildAccelerationStructuresKHR)
{
    transfers_add_build(commandBuffer);
    for (uint32_t i = 0; atomic_load(&is_reading) && i < infoCount; i++)
        add_instances(commandBuffer, &pInfos[i], ppBuildRangeInfos[i], 0);
}

COMMAND(CmdBuildAccelerationStructuresIndirectKHR)
{
    transfers_add_build(commandBuffer);
    static const VkAccelerationStructureBuildRangeInfoKHR unknown;
    for (uint32_t i = 0; atomic_load(&is_reading) && i < infoCount; i++)
        add_instances(commandBuffer, &pInfos[i], &unknown, pIndirectDeviceAddresses[i]);
}

COMMAND(CmdBuildAccelerationStructureNV)
{
    transfers_add_build(commandBuffer);
    if (atomic_load(&is_reading) && pInfo->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV)
        transfers_add_instances(commandBuffer, &(struct instances){.buffer = instanceData,
                                                                   .data = instanceOffset,
                                                                   .count = pInfo->instanceCount});
}

/* Structures that builds place have one size, and follow each other. */
COMMAND(CmdBuildClusterAccelerationStructureIndirectNV)
{
    enum { WRITTEN_MAX = 64, SIZE = 256 };
    const VkClusterAccelerationStructureInputInfoNV *input = &pCommandInfos->input;
    const VkStridedDeviceAddressRegionKHR *addresses = &pCommandInfos->dstAddressesArray,
                                          *sizes = &pCommandInfos->dstSizesArray;
    const uint32_t size = SIZE;
    transfers_add_build(commandBuffer);
    for (uint32_t i = 0; pCommandInfos->addressResolutionFlags == 0 &&
                         i < input->maxAccelerationStructureCount && i < WRITTEN_MAX;
         i++) {
        const VkDeviceAddress address = pCommandInfos->dstImplicitData + (VkDeviceSize)i * size;
        if (addresses->deviceAddress != 0 &&
            input->opMode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV)
            transfers_add_write(commandBuffer, addresses->deviceAddress + i * addresses->stride,
                                &address, sizeof(address));
        if (sizes->deviceAddress != 0)
            transfers_add_write(commandBuffer, sizes->deviceAddress + i * sizes->stride, &size,
                                sizeof(size));
    }
}

COMMAND(CmdBuildPartitionedAccelerationStructuresNV)
{
    transfers_add_build(commandBuffer);
    if (atomic_load(&is_reading))
        transfers_add_instances(commandBuffer,
                                &(struct instances){.data = pBuildInfo->srcInfos,
                                                    .range = pBuildInfo->srcInfosCount,
                                                    .are_partitioned = true});
}

/* ---- execution */

static void note(uint64_t reference)
{
    pthread_mutex_lock(&lock);
    if (reference_count < REFERENCES_MAX)
        references[reference_count++] = reference;
    pthread_mutex_unlock(&lock);
}

/* Bytes of the type's data in front of the reference. */
static VkDeviceSize reference_offset(uint32_t type)
{
    const VkDeviceSize words = instance_words(type);
    return words != 0 ? (words - 2) * sizeof(uint32_t) : 0;
}

static void read_one(const struct instances *instances, VkDeviceAddress at)
{
    uint64_t reference = UINT64_MAX; /* where there is no memory, or none for this use */
    uint32_t type = 0;
    if (!address_has_usage(at,
                           VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR))
        return note(reference);
    if (instances->are_pointers && !address_read(at, &at, sizeof(at)))
        return note(reference);
    if (instances->are_pointers && instances->have_motion) {
        type = (uint32_t)at & 15;
        at -= type;
    } else if (instances->have_motion) {
        address_read(at, &type, sizeof(type));
        at += 2 * sizeof(uint32_t);
    }
    address_read(at + reference_offset(type), &reference, sizeof(reference));
    note(reference);
}

static void read_buffer(const struct instances *instances)
{
    const VkDeviceSize size = sizeof(VkAccelerationStructureInstanceKHR);
    for (uint32_t i = 0; i < instances->count; i++) {
        VkDeviceSize left = size;
        uint64_t reference = UINT64_MAX;
        const unsigned char *bytes =
            buffer_bytes(instances->buffer, instances->data + i * size, &left);
        if (bytes != NULL && left == size)
            memcpy(&reference, bytes + reference_offset(0), sizeof(reference));
        note(reference);
    }
}

/* Notes the references of an operation that writes or updates instances, and where the array of
 * any other operation begins. */
static void
read_operation(const VkBuildPartitionedAccelerationStructureIndirectCommandNV *operation)
{
    const bool writes =
        operation->opType == VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV;
    const VkStridedDeviceAddressNV *array = &operation->argData;
    if (!writes &&
        operation->opType != VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_UPDATE_INSTANCE_NV)
        return note(array->startAddress);
    for (uint32_t i = 0; i < operation->argCount; i++) {
        uint64_t reference = UINT64_MAX;
        address_read(array->startAddress + i * array->strideInBytes +
                         (writes ? offsetof(VkPartitionedAccelerationStructureWriteInstanceDataNV,
                                            accelerationStructure)
                                 : offsetof(VkPartitionedAccelerationStructureUpdateInstanceDataNV,
                                            accelerationStructure)),
                     &reference, sizeof(reference));
        note(reference);
    }
}

static void read_partitioned(const struct instances *instances)
{
    VkBuildPartitionedAccelerationStructureIndirectCommandNV operation;
    uint32_t count;
    if (!address_read(instances->range, &count, sizeof(count)))
        return note(UINT64_MAX);
    for (uint32_t i = 0; i < count; i++) {
        if (!address_read(instances->data + i * sizeof(operation), &operation, sizeof(operation)))
            return note(UINT64_MAX);
        read_operation(&operation);
    }
}

void instances_read(const struct instances *given)
{
    struct instances instances = *given;
    VkAccelerationStructureBuildRangeInfoKHR range;
    if (instances.are_partitioned) {
        read_partitioned(&instances);
        return;
    }
    if (instances.buffer != VK_NULL_HANDLE) {
        read_buffer(&instances);
        return;
    }
    if (instances.range != 0) {
        if (!address_has_usage(instances.range, VK_BUFFER_USAGE_2_INDIRECT_BUFFER_BIT) ||
            !address_read(instances.range, &range, sizeof(range)))
            return note(UINT64_MAX);
        instances.count = range.primitiveCount;
        instances.data += range.primitiveOffset;
    }
    const VkDeviceSize stride = instances.are_pointers ? sizeof(uint64_t)
                                : instances.have_motion
                                    ? MOTION_STRIDE
                                    : sizeof(VkAccelerationStructureInstanceKHR);
    for (uint32_t i = 0; i < instances.count; i++)
        read_one(&instances, instances.data + i * stride);
}
