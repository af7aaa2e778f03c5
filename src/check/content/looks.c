/* SPDX-License-Identifier: Apache-2.0 */
/* Guesses what the application has written where a build reads instances, for the words of
 * messages: an array of pointers that holds instances, instances that are farther apart, or nothing
 * at all. No rule depends on it. */
#include <math.h>
#include <string.h>

#include "src/check/content/content.h"
#include "src/view/enabled.h"

enum {
    INSTANCE_SIZE = sizeof(VkAccelerationStructureInstanceKHR),
    TRANSFORM_SIZE = sizeof(VkTransformMatrixKHR),
    FIRST_STRIDE = 68, /* of instances that are farther apart than a build reads them */
    LAST_STRIDE = 256,
    MOST_POINTERS = 8,
};

/* ---- one element */

static float float_at(const uint8_t *bytes, uint64_t index)
{
    float value;
    memcpy(&value, bytes + index * sizeof(value), sizeof(value));
    return value;
}

/* Whether it is a size, a position or a rotation, rather than a half of a pointer. */
static bool is_usual_number(float value)
{
    const float size = fabsf(value);
    return size == 0 || (size > 1e-20f && size < 1e15f);
}

static bool are_usual_numbers(const uint8_t *bytes, uint64_t count)
{
    bool has_any = false;
    for (uint64_t i = 0; i < count; i++) {
        if (!is_usual_number(float_at(bytes, i)))
            return false;
        has_any |= float_at(bytes, i) != 0;
    }
    return has_any;
}

static bool is_one_pattern(const uint8_t *bytes)
{
    for (uint32_t i = sizeof(uint32_t); i < INSTANCE_SIZE; i += sizeof(uint32_t))
        if (memcmp(bytes, bytes + i, sizeof(uint32_t)) != 0)
            return false;
    return true;
}

static bool has_unknown_flags(const VkAccelerationStructureInstanceKHR *instance)
{
    return instance->flags & ~(0xfu | micromap_instance_flags);
}

static bool looks_unwritten(const VkAccelerationStructureInstanceKHR *instance)
{
    return is_one_pattern((const uint8_t *)instance) ||
           ((has_unknown_flags(instance) || !instance->mask) &&
            !are_usual_numbers((const uint8_t *)&instance->transform, 12));
}

/* Device addresses of a 64-bit system have 48 bits. Half of such a number is no usual float. */
static bool looks_like_pointer(const uint8_t *bytes)
{
    uint64_t address;
    memcpy(&address, bytes, sizeof(address));
    return address % 16 == 0 && address >> 32 && address >> 48 == 0;
}

/* ---- the array */

static bool holds_instances(const struct content_elements *elements)
{
    const uint64_t size = smaller_of(elements->size, TRANSFORM_SIZE);
    return are_usual_numbers(elements->bytes, size / sizeof(float));
}

static bool holds_pointers(const struct content_elements *elements)
{
    const uint64_t count = smaller_of(elements->size / INSTANCE_SIZE, MOST_POINTERS);
    for (uint64_t i = 0; i < count; i++)
        if (!looks_like_pointer(elements->bytes + i * sizeof(uint64_t)))
            return false;
    return count;
}

/* Whether an instance begins there that refers to a structure near that of the first one. */
static bool holds_instance_at(const struct content_elements *elements, uint64_t offset)
{
    VkAccelerationStructureInstanceKHR first, instance;
    if (offset > elements->size || elements->size - offset < INSTANCE_SIZE ||
        !are_usual_numbers(elements->bytes + offset, 12))
        return false;
    memcpy(&first, elements->bytes, sizeof(first));
    memcpy(&instance, elements->bytes + offset, sizeof(instance));
    return !has_unknown_flags(&instance) && instance.mask &&
           instance.accelerationStructureReference >> 24 &&
           instance.accelerationStructureReference >> 24 ==
               first.accelerationStructureReference >> 24;
}

/* Returns 0 if the instances are not farther apart. */
static uint32_t find_stride(const struct content_elements *elements)
{
    for (uint32_t stride = FIRST_STRIDE; stride <= LAST_STRIDE; stride += sizeof(uint32_t))
        if (holds_instance_at(elements, 0) && holds_instance_at(elements, stride))
            return stride;
    return 0;
}

struct data_look content_look_of_pointers(const struct content *content)
{
    return (struct data_look){.kind = holds_instances(&content->elements) ? LOOKS_LIKE_INSTANCES
                                                                          : LOOKS_AS_ASKED};
}

struct data_look content_look_of_instance(const struct content *content,
                                          const VkAccelerationStructureInstanceKHR *instance)
{
    const struct content_elements *elements = &content->elements;
    const bool has_array =
        elements->bytes && !has_instance_pointers(content->range->geometry->geometry);
    struct data_look look = {.kind = LOOKS_AS_ASKED};
    if (has_array)
        look.stride = find_stride(elements);
    if (look.stride)
        look.kind = LOOKS_STRIDED;
    else if (has_array && holds_pointers(elements))
        look.kind = LOOKS_LIKE_POINTERS;
    else if (looks_unwritten(instance))
        look.kind = LOOKS_UNWRITTEN;
    return look;
}
