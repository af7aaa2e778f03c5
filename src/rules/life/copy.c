/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about copies of structures and micromaps, to each other, to memory and from memory. */
#include "src/rules/predicates.h"

/* ---- the mode */

bool copy_mode_is_compact_or_clone(const struct copy_view *copy, struct finding *finding)
{
    return copy->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR ||
           copy->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR ||
           violated(finding, "mode", "{} is neither compact nor clone", copy->given_mode);
}

bool copy_mode_fits_the_direction(const struct copy_view *copy, struct finding *finding)
{
    const bool serializes = copy->direction == COPY_TO_MEMORY;
    return copy->mode == (serializes ? VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR
                                     : VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR) ||
           violated(finding, "mode", "{} is not {}", copy->given_mode,
                    phrase(serializes ? "the mode that serializes" : "the mode that deserializes"));
}

/* ---- the memory of a serialization or deserialization */

static const char *memory_field(const struct copy_view *copy)
{
    if (copy->direction == COPY_TO_MEMORY)
        return copy->is_on_host ? "dst.hostAddress" : "dst.deviceAddress";
    return copy->is_on_host ? "src.hostAddress" : "src.deviceAddress";
}

enum { DEVICE_ALIGNMENT = 256, HOST_ALIGNMENT = 16, MICROMAP_ALIGNMENT = 128 };

/* A structure of that type is never built as another one, and holds no data of another one. */
static bool is_of_micromap(const struct copy_view *copy)
{
    const struct life_object *object = copy->direction == COPY_TO_MEMORY ? &copy->src : &copy->dst;
    return object->details_known &&
           object->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR &&
           object->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

bool copy_memory_is_aligned(const struct copy_view *copy, struct finding *finding)
{
    const uint64_t alignment = copy->is_on_host ? HOST_ALIGNMENT : DEVICE_ALIGNMENT;
    return copy->address % alignment == 0 ||
           violated(finding, memory_field(copy), "{} is not aligned to {}", hex(copy->address),
                    count_of(alignment, "byte")) ||
           (!copy->is_on_host && !serialized_micromap_is_aligned(copy, NULL) &&
            also_violates(finding, RULE_serialized_micromap_is_aligned));
}

/* The specification requires an alignment to more bytes of all serialized data. */
bool serialized_micromap_is_aligned(const struct copy_view *copy, struct finding *finding)
{
    return !is_of_micromap(copy) || copy->address % MICROMAP_ALIGNMENT == 0 ||
           violated(finding, memory_field(copy), "{} is not aligned to {}", hex(copy->address),
                    count_of(MICROMAP_ALIGNMENT, "byte")) ||
           is_reported_with(finding, RULE_copy_memory_is_aligned);
}

static bool device_address_is_valid(const struct copy_view *copy, struct finding *finding)
{
    if (copy->memory.status == ADDRESS_NULL)
        return violated_plainly(finding, memory_field(copy), "is 0");
    return copy->memory.status != ADDRESS_NOWHERE ||
           violated(finding, memory_field(copy), "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, copy->address));
}

static bool host_address_is_valid(const struct copy_view *copy, struct finding *finding)
{
    if (!copy->address)
        return violated_plainly(finding, memory_field(copy), "is NULL");
    return !copy->memory_unreadable ||
           violated(finding, memory_field(copy), "{} does not point to host memory",
                    hex(copy->address));
}

bool copy_memory_address_is_valid(const struct copy_view *copy, struct finding *finding)
{
    return copy->is_on_host ? host_address_is_valid(copy, finding)
                            : device_address_is_valid(copy, finding);
}

bool copy_memory_is_backed(const struct copy_view *copy, struct finding *finding)
{
    return copy->memory.status != ADDRESS_UNBOUND ||
           violated(finding, memory_field(copy),
                    "{} is in {}, which is not bound to memory, or whose memory was freed",
                    hex(copy->address),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(copy->memory.buffer)));
}

/* ---- the memory of the structures */

static struct value buffer_of(const struct life_object *accel)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(accel->buffer));
}

static bool is_backed(const struct life_object *accel, struct finding *finding, const char *field)
{
    if (accel->backed != NO)
        return true;
    if (!accel->buffer)
        return violated(finding, field, "{} is not bound to memory, or its memory was freed",
                        life_object_value(accel));
    return violated_by_buffer_of(accel, finding, field);
}

bool copy_src_is_backed(const struct copy_view *copy, struct finding *finding)
{
    return is_backed(&copy->src, finding, "src") ||
           also_violates(finding, RULE_copy_src_is_host_visible);
}

bool copy_dst_is_backed(const struct copy_view *copy, struct finding *finding)
{
    return is_backed(&copy->dst, finding, "dst") ||
           also_violates(finding, RULE_copy_dst_is_host_visible);
}

static bool is_host_visible(const struct life_object *accel, struct finding *finding,
                            const char *field)
{
    return accel->host_visible != NO || violated(finding, field,
                                                 "{} lies in {}, which is bound to memory without "
                                                 "VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT",
                                                 life_object_value(accel), buffer_of(accel));
}

bool copy_src_is_host_visible(const struct copy_view *copy, struct finding *finding)
{
    return is_host_visible(&copy->src, finding, "src") &&
           (is_backed(&copy->src, finding, "src") ||
            is_reported_with(finding, RULE_copy_src_is_backed));
}

bool copy_dst_is_host_visible(const struct copy_view *copy, struct finding *finding)
{
    return is_host_visible(&copy->dst, finding, "dst") &&
           (is_backed(&copy->dst, finding, "dst") ||
            is_reported_with(finding, RULE_copy_dst_is_backed));
}

static bool has_one_memory_instance(const struct life_object *accel, struct finding *finding,
                                    const char *field)
{
    return accel->multi_instance != YES ||
           violated(
               finding, field,
               "{} lies in {}, which is bound to memory that was allocated with multiple instances",
               life_object_value(accel), buffer_of(accel));
}

bool copy_src_has_one_memory_instance(const struct copy_view *copy, struct finding *finding)
{
    return has_one_memory_instance(&copy->src, finding, "src");
}

bool copy_dst_has_one_memory_instance(const struct copy_view *copy, struct finding *finding)
{
    return has_one_memory_instance(&copy->dst, finding, "dst");
}

static bool has_a_buffer(const struct life_object *accel, struct finding *finding,
                         const char *field)
{
    return !accel->by_address ||
           violated(finding, field,
                    "{} was created with vkCreateAccelerationStructure2KHR, not "
                    "vkCreateAccelerationStructureKHR",
                    life_object_value(accel));
}

bool copy_src_was_created_with_a_buffer(const struct copy_view *copy, struct finding *finding)
{
    return has_a_buffer(&copy->src, finding, "src");
}

bool copy_dst_was_created_with_a_buffer(const struct copy_view *copy, struct finding *finding)
{
    return has_a_buffer(&copy->dst, finding, "dst");
}

/* How many bytes the copy accesses is unknown here, but the first ones are among them. */
bool copied_memory_does_not_overlap(const struct copy_view *copy, struct finding *finding)
{
    const struct memory_span *src = &copy->src.span, *dst = &copy->dst.span;
    if (copy->src.alive == YES && copy->src.handle == copy->dst.handle)
        return violated(finding, "dst", "{} is also src", life_object_value(&copy->dst));
    return !src->memory || src->memory != dst->memory || src->begin != dst->begin ||
           violated(finding, "dst", "{} begins at byte {} of {}, where {}, the src, begins, too",
                    life_object_value(&copy->dst), hex(dst->begin),
                    object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(dst->memory)),
                    life_object_value(&copy->src));
}
