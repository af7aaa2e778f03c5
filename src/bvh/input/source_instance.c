/* SPDX-License-Identifier: Apache-2.0 */
/* Reads instances from an array, or through an array of addresses. */
#include <string.h>

#include "src/bvh/input/source.h"

/* "VkAccelerationStructureGeometryInstancesDataKHR": motion instances have a stride of 160
 * bytes. */
#define MOTION_INSTANCE_STRIDE 160

bool source_open_instances(struct source *source, const struct builder_instances *instances,
                           const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint64_t element = sizeof(VkAccelerationStructureInstanceKHR), stride = element;
    if (source->has_motion) {
        element = sizeof(VkAccelerationStructureMotionInstanceNV);
        stride = MOTION_INSTANCE_STRIDE;
    }
    if (instances->array_of_pointers)
        element = stride = sizeof(uint64_t);
    source->is_pointer_array = instances->array_of_pointers;
    return source_open_array(source, instances->data, instances->size, element, stride, range);
}

/* Resolves an address in the data. Without a `read` function, addresses are host pointers. */
static const void *find_instance(const struct builder_memory *memory, uint64_t address,
                                 uint64_t size)
{
    return memory->read ? memory->read(memory->context, address, size)
                        : (const void *)(uintptr_t)address; // NOLINT(performance-no-int-to-ptr)
}

enum source_state source_instance(const struct source *source, uint32_t primitive,
                                  const struct builder_memory *memory,
                                  struct instance_record *record)
{
    const void *from = source->data + source->stride * primitive;
    if (source->is_pointer_array) {
        uint64_t address;
        memcpy(&address, from, sizeof(address));
        from = find_instance(memory, address, sizeof(record->instance));
        if (!from)
            return SOURCE_OUT_OF_RANGE;
    }
    memcpy(&record->instance, from, sizeof(record->instance));
    return record->instance.accelerationStructureReference == 0 ? SOURCE_INACTIVE : SOURCE_ACTIVE;
}

/* All instance types have the same 16 bytes after their transforms. */
#define AFTER_TRANSFORM (sizeof(VkAccelerationStructureInstanceKHR) - sizeof(VkTransformMatrixKHR))

uint64_t source_motion_size(uint32_t type)
{
    switch (type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV:
        return sizeof(VkAccelerationStructureInstanceKHR);
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        return sizeof(VkAccelerationStructureMatrixMotionInstanceNV);
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        return sizeof(VkAccelerationStructureSRTMotionInstanceNV);
    default:
        return 0;
    }
}

/* In an array of pointers, the low 4 bits of an address are the type of the instance. In an array,
 * the type precedes the instance. */
enum source_state source_motion_instance(const struct source *source, uint32_t primitive,
                                         const struct builder_memory *memory,
                                         struct motion_instance_record *record)
{
    const uint8_t *from = source->data + source->stride * primitive;
    *record = (struct motion_instance_record){.type = 0};
    if (source->is_pointer_array) {
        uint64_t address;
        memcpy(&address, from, sizeof(address));
        record->type = address & 0xf;
        from = find_instance(memory, address & ~(uint64_t)0xf, source_motion_size(record->type));
    } else {
        memcpy(&record->type, from, sizeof(record->type));
        from += offsetof(VkAccelerationStructureMotionInstanceNV, data);
    }
    uint64_t size = source_motion_size(record->type);
    if (!from || size == 0)
        return SOURCE_OUT_OF_RANGE;
    VkAccelerationStructureInstanceKHR *instance = &record->base.instance;
    memcpy((uint8_t *)instance + sizeof(instance->transform), from + size - AFTER_TRANSFORM,
           AFTER_TRANSFORM);
    if (record->type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV)
        memcpy(&instance->transform, from, sizeof(instance->transform));
    else
        memcpy(&record->at, from, size - AFTER_TRANSFORM);
    return instance->accelerationStructureReference == 0 ? SOURCE_INACTIVE : SOURCE_ACTIVE;
}
