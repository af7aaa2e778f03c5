/* SPDX-License-Identifier: Apache-2.0 */
/* Acceleration structures: handles, addresses, memory, sizes and queries. Builds and copies look at
 * nothing. */
#include "internal.h"

static _Atomic uint64_t invalid_queries;

uint64_t null_driver_invalid_queries(void)
{
    return atomic_load(&invalid_queries);
}

static VkDeviceAddress buffer_address(uint64_t handle)
{
    const struct object *buffer = object_find(handle, VK_OBJECT_TYPE_BUFFER);
    return buffer != NULL ? buffer->buffer.address : 0;
}

ON_CREATION(CreateAccelerationStructureKHR)
{
    object->as.buffer = RAW(pCreateInfo->buffer);
    object->as.offset = pCreateInfo->offset;
    object->as.fallback = pCreateInfo->deviceAddress;
    if (object->as.fallback == 0 && buffer_address(object->as.buffer) == 0)
        object->as.fallback = address_allocate(NULL, pCreateInfo->size);
}

/* VUIDs 09541 and 09542. A buffer that is not known has been destroyed, or is that of a structure
 * which was created at an address. */
static bool may_be_queried(const struct object *as)
{
    const struct object *buffer = object_find(as->as.buffer, VK_OBJECT_TYPE_BUFFER);
    if (buffer == NULL)
        return as->as.buffer == 0;
    return buffer->buffer.usage & VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT &&
           (buffer->buffer.flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT ||
            buffer->buffer.bindings != NULL);
}

COMMAND(GetAccelerationStructureDeviceAddressKHR)
{
    const struct object *as = FIND(ACCELERATION_STRUCTURE_KHR, pInfo->accelerationStructure);
    if (as == NULL)
        return 0;
    if (!may_be_queried(as))
        atomic_fetch_add(&invalid_queries, 1);
    /* Asked again: the buffer may have been bound since. */
    const VkDeviceAddress buffer = buffer_address(as->as.buffer);
    return buffer != 0 ? buffer + as->as.offset : as->as.fallback;
}

/* The query ignores these members. Layers may validate them all the same, so the layer's own
 * queries lack what is invalid. */
static bool is_alive_or_null(VkAccelerationStructureKHR handle)
{
    return handle == VK_NULL_HANDLE || FIND(ACCELERATION_STRUCTURE_KHR, handle) != NULL;
}

static bool is_valid_query(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    const bool is_micromap = info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    return is_alive_or_null(info->srcAccelerationStructure) &&
           is_alive_or_null(info->dstAccelerationStructure) &&
           !(is_micromap && (info->srcAccelerationStructure != VK_NULL_HANDLE ||
                             info->mode != VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR));
}

static void fill_sizes(VkDevice device, VkAccelerationStructureBuildSizesInfoKHR *sizes,
                       uint64_t primitives)
{
    if (CONFIG(device)->sizes_are_constant)
        primitives = 0;
    sizes->accelerationStructureSize = STRUCTURE_SIZE + 64 * primitives;
    sizes->buildScratchSize = 2048 + 32 * primitives;
    sizes->updateScratchSize = CONFIG(device)->needs_no_scratch ? 0 : 1024 + 16 * primitives;
}

COMMAND(GetAccelerationStructureBuildSizesKHR)
{
    if (!is_valid_query(pBuildInfo))
        atomic_fetch_add(&invalid_queries, 1);
    uint64_t primitives = 0;
    for (uint32_t i = 0; pMaxPrimitiveCounts != NULL && i < pBuildInfo->geometryCount; i++)
        primitives += pMaxPrimitiveCounts[i];
    fill_sizes(device, pSizeInfo, primitives);
}

COMMAND(GetClusterAccelerationStructureBuildSizesNV)
{
    fill_sizes(device, pSizeInfo, pInfo->maxAccelerationStructureCount);
}

COMMAND(GetPartitionedAccelerationStructuresBuildSizesNV)
{
    fill_sizes(device, pSizeInfo, pInfo->instanceCount);
}

/* ---- VK_NV_ray_tracing */

static uint64_t primitives_of(const VkAccelerationStructureInfoNV *info)
{
    uint64_t primitives = info->instanceCount;
    for (uint32_t i = 0; info->pGeometries != NULL && i < info->geometryCount; i++) {
        const VkGeometryNV *geometry = &info->pGeometries[i];
        const VkGeometryTrianglesNV *triangles = &geometry->geometry.triangles;
        if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_NV)
            primitives += geometry->geometry.aabbs.numAABBs;
        else if (triangles->indexType != VK_INDEX_TYPE_NONE_NV)
            primitives += triangles->indexCount / 3;
        else
            primitives += triangles->vertexCount / 3;
    }
    return primitives;
}

ON_CREATION(CreateAccelerationStructureNV)
{
    object->as_nv.primitives = primitives_of(&pCreateInfo->info);
    object->as_nv.compacted = pCreateInfo->compactedSize;
}

static VkDeviceSize size_of(VkDevice device, const struct object *as,
                            VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes;
    fill_sizes(device, &sizes, as->as_nv.primitives);
    if (type == VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
        return sizes.buildScratchSize;
    if (type == VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV)
        return sizes.updateScratchSize;
    return as->as_nv.compacted != 0 ? as->as_nv.compacted : sizes.accelerationStructureSize;
}

COMMAND(GetAccelerationStructureMemoryRequirementsNV)
{
    const struct object *as = FIND(ACCELERATION_STRUCTURE_NV, pInfo->accelerationStructure);
    const VkDeviceSize size = as != NULL ? size_of(device, as, pInfo->type) : 0;
    pMemoryRequirements->memoryRequirements = (VkMemoryRequirements){
        .size = align_up(size, 256),
        .alignment = 256,
        .memoryTypeBits = requirements_types(CONFIG(device), 0,
                                             VK_MEMORY_PROPERTY_PROTECTED_BIT |
                                                 VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT),
    };
}

COMMAND(BindAccelerationStructureMemoryNV)
{
    for (uint32_t i = 0; i < bindInfoCount; i++) {
        struct object *as = FIND(ACCELERATION_STRUCTURE_NV, pBindInfos[i].accelerationStructure);
        const struct object *memory = FIND(DEVICE_MEMORY, pBindInfos[i].memory);
        if (as != NULL && memory != NULL)
            as->as_nv.address = memory->memory.address + pBindInfos[i].memoryOffset;
    }
    return VK_SUCCESS;
}

COMMAND(GetAccelerationStructureHandleNV)
{
    const struct object *as = FIND(ACCELERATION_STRUCTURE_NV, accelerationStructure);
    const uint64_t address = as != NULL ? as->as_nv.address : 0;
    memcpy(pData, &address, dataSize < sizeof(address) ? dataSize : sizeof(address));
    return VK_SUCCESS;
}

/* ---- serialized data: only the header; by the host in memory of the device that it sees */

static const struct null_driver_serialized header = {
    {"null driver", "null driver"}, SERIALIZED_SIZE, COMPACTED_SIZE, 0};

/* Ignores other addresses, which may be invalid. */
static VkResult write_header(VkDevice device, void *address)
{
    const struct object *memory;
    for (uint32_t i = 0; (memory = object_child(OBJECT(device), VK_OBJECT_TYPE_DEVICE_MEMORY, i));
         i++) {
        const uintptr_t begin = (uintptr_t)memory->memory.host, at = (uintptr_t)address;
        if (begin != 0 && at >= begin && memory->memory.size >= sizeof(header) &&
            at - begin <= memory->memory.size - sizeof(header))
            memcpy(address, &header, sizeof(header));
    }
    return VK_SUCCESS;
}

COMMAND(CopyAccelerationStructureToMemoryKHR)
{
    return write_header(device, pInfo->dst.hostAddress);
}

COMMAND(CopyMicromapToMemoryEXT)
{
    return write_header(device, pInfo->dst.hostAddress);
}

/* Tests also record to command buffers that do not exist. */
static void record_header(VkCommandBuffer commands, VkDeviceAddress address)
{
    if (OBJECT(commands)->type == VK_OBJECT_TYPE_COMMAND_BUFFER)
        transfers_add_write(commands, address, &header, sizeof(header));
}

COMMAND(CmdCopyAccelerationStructureToMemoryKHR)
{
    record_header(commandBuffer, pInfo->dst.deviceAddress);
}

COMMAND(CmdCopyMicromapToMemoryEXT)
{
    record_header(commandBuffer, pInfo->dst.deviceAddress);
}

static VkAccelerationStructureCompatibilityKHR compare_version(const uint8_t *version)
{
    return memcmp(version, vulkan11.driverUUID, VK_UUID_SIZE) == 0
               ? VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR
               : VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR;
}

COMMAND(GetDeviceAccelerationStructureCompatibilityKHR)
{
    *pCompatibility = compare_version(pVersionInfo->pVersionData);
}

COMMAND(GetDeviceMicromapCompatibilityEXT)
{
    *pCompatibility = compare_version(pVersionInfo->pVersionData);
}

/* ---- queries, whose answers depend on their type alone */

static uint64_t query_value(VkQueryType type)
{
    switch ((int)type) {
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV:
    case VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT:
        return COMPACTED_SIZE;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR:
    case VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT:
        return SERIALIZED_SIZE;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR:
        return STRUCTURE_SIZE;
    default:
        return 0;
    }
}

static void write_value(void *to, size_t size, uint64_t value)
{
    const uint32_t low = (uint32_t)value;
    memcpy(to, size == sizeof(low) ? (const void *)&low : (const void *)&value, size);
}

void query_write(uint32_t count, VkQueryType type, size_t size, void *data, size_t stride)
{
    const uint64_t value = query_value(type);
    if (data == NULL)
        return;
    for (uint32_t i = 0; i < count && i * stride + sizeof(value) <= size; i++)
        write_value((char *)data + i * stride, sizeof(value), value);
}

/* All queries are available at once. */
COMMAND(GetQueryPoolResults)
{
    const struct object *pool = FIND(QUERY_POOL, queryPool);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const size_t word = flags & VK_QUERY_RESULT_64_BIT ? sizeof(uint64_t) : sizeof(uint32_t);
    const bool extra = flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    const size_t size = extra ? 2 * word : word;
    for (uint32_t i = 0; i < queryCount && i * stride + size <= dataSize; i++) {
        char *to = (char *)pData + i * stride;
        write_value(to, word, query_value(pool->query_type));
        if (extra)
            write_value(to + word, word, 1);
    }
    return VK_SUCCESS;
}
