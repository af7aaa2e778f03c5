/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the acceleration structures and the scratch memory of one build. */
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

static bool is_build(const struct build_view *build)
{
    return build->info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
}

static struct value structure(VkAccelerationStructureKHR handle)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(handle));
}

static bool is_invalid(const struct accel_facts *accel)
{
    return !accel->handle || (accel->alive == NO && !accel->of_another_device);
}

/* ---- If src is dst, the message about dst names the id about src. */

static bool src_is_dst(const struct build_view *build)
{
    return build->src.handle && build->src.handle == build->dst.handle;
}

static bool names_rule_of_src(const struct build_view *build, struct finding *finding,
                              enum rule rule)
{
    return src_is_dst(build) && also_violates(finding, rule);
}

static bool is_named_with_dst(const struct build_view *build, struct finding *finding,
                              enum rule rule)
{
    return src_is_dst(build) && is_reported_with(finding, rule);
}

bool dst_is_a_valid_handle(const struct build_view *build, struct finding *finding)
{
    return !is_invalid(&build->dst) ||
           violated_by_handle(finding, "dstAccelerationStructure", structure(build->dst.handle),
                              "an acceleration structure of this device") ||
           names_rule_of_src(build, finding, RULE_src_is_a_valid_handle);
}

bool src_is_a_valid_handle(const struct build_view *build, struct finding *finding)
{
    return !build->src.handle || !is_invalid(&build->src) ||
           violated_by_handle(finding, "srcAccelerationStructure", structure(build->src.handle),
                              "an acceleration structure of this device") ||
           is_named_with_dst(build, finding, RULE_dst_is_a_valid_handle);
}

bool dst_and_src_share_the_device(const struct build_view *build, struct finding *finding)
{
    if (build->dst.of_another_device && build->src.of_another_device)
        return violated(finding, "dstAccelerationStructure",
                        "{} and srcAccelerationStructure {} were created from another VkDevice",
                        structure(build->dst.handle), structure(build->src.handle));
    if (build->dst.of_another_device)
        return violated(finding, "dstAccelerationStructure", "{} was created from another VkDevice",
                        structure(build->dst.handle));
    return !build->src.of_another_device ||
           violated(finding, "srcAccelerationStructure", "{} was created from another VkDevice",
                    structure(build->src.handle));
}

static bool dst_has_type(const struct build_view *build, struct finding *finding,
                         VkAccelerationStructureTypeKHR type)
{
    if (build->info->type != type || !build->dst.details_known)
        return true;
    return build->dst.type == type ||
           build->dst.type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated(finding, "dstAccelerationStructure",
                    "{} was created with type {}, neither {} nor "
                    "VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR",
                    structure(build->dst.handle), accel_type(build->dst.type), accel_type(type));
}

bool tlas_dst_is_top_level_or_generic(const struct build_view *build, struct finding *finding)
{
    return dst_has_type(build, finding, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
}

bool blas_dst_is_bottom_level_or_generic(const struct build_view *build, struct finding *finding)
{
    return dst_has_type(build, finding, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static bool is_backed(const struct accel_facts *accel, struct finding *finding, const char *field)
{
    const struct holding_buffer held_by = holding_buffer_of_accel(accel);
    return accel->backed != NO ||
           violated(finding, field, "{} lies in {}, {}", structure(accel->handle), held_by.value,
                    phrase(held_by.lacks));
}

bool dst_is_backed_by_memory(const struct build_view *build, struct finding *finding)
{
    return is_backed(&build->dst, finding, "dstAccelerationStructure") ||
           (build_is_update(build->info) &&
            names_rule_of_src(build, finding, RULE_update_src_is_backed_by_memory));
}

bool update_src_is_backed_by_memory(const struct build_view *build, struct finding *finding)
{
    return !build_is_update(build->info) ||
           is_backed(&build->src, finding, "srcAccelerationStructure") ||
           is_named_with_dst(build, finding, RULE_dst_is_backed_by_memory);
}

bool fully_bound_range_is_bound(const struct unbound_access_view *unbound_access,
                                struct finding *finding)
{
    const struct accel_facts *accel = unbound_access->structure;
    const bool is_dst = unbound_access->is_dst;
    return !accel->fully_bound ||
           violated(
               finding, is_dst ? "dstAccelerationStructure" : "srcAccelerationStructure",
               "{} was created with VK_ADDRESS_COMMAND_FULLY_BOUND_BIT_KHR, but bytes [{}, {}) "
               "of {} are not bound to memory",
               structure(accel->handle), hex(unbound_access->begin), hex(unbound_access->end),
               object(VK_OBJECT_TYPE_BUFFER, handle_number(accel->buffer))) ||
           is_reported_with(finding, is_dst ? RULE_dst_is_backed_by_memory
                                            : RULE_update_src_is_backed_by_memory);
}

static bool has_size_of_build(const struct build_view *build, struct finding *finding)
{
    if (!build->sizes.known || !build->dst.details_known)
        return true;
    return build->dst.size >= build->sizes.acceleration_structure ||
           violated(finding, "dstAccelerationStructure",
                    "{} was created with size {}, less than accelerationStructureSize ({})",
                    structure(build->dst.handle), number(build->dst.size),
                    number(build->sizes.acceleration_structure)) ||
           (finding && remarks_on_size_query(finding, build, SIZE_OF_STRUCTURE));
}

/* An update may write a structure of compacted size, which is known only when the build
 * executes. */
bool dst_is_large_enough(const struct build_view *build, struct finding *finding)
{
    return !is_build(build) || has_size_of_build(build, finding);
}

/* The call gives maxPrimitiveCounts in place of counts, and the valid usage doesn't exempt
 * updates. */
bool dst_is_large_enough_for_max_primitive_counts(const struct build_view *build,
                                                  struct finding *finding)
{
    return has_size_of_build(build, finding);
}

/* ---- scratch */

bool scratch_address_is_aligned(const struct build_view *build, struct finding *finding)
{
    VkDeviceAddress address = build->info->scratchData.deviceAddress;
    uint32_t alignment = build->call->device->limits.minAccelerationStructureScratchOffsetAlignment;
    return !alignment || address % alignment == 0 ||
           violated(finding, "scratchData.deviceAddress",
                    "{} is not a multiple of minAccelerationStructureScratchOffsetAlignment ({})",
                    hex(address), number(alignment));
}

static bool scratch_is_in_one_buffer(const struct build_view *build, struct finding *finding,
                                     VkDeviceSize needed, enum queried_size which,
                                     const char *size_name)
{
    const struct address_facts *scratch = &build->scratch;
    if (!build->sizes.known || !needed)
        return true;
    switch (scratch->status) {
    case ADDRESS_UNKNOWN:
    case ADDRESS_UNBOUND: /* see input_buffer_is_bound */
        return true;
    case ADDRESS_NULL:
    case ADDRESS_NOWHERE:
        return violated(finding, "scratchData.deviceAddress", "{} is in no buffer, but {} is {}",
                        address_of_missing(VK_OBJECT_TYPE_BUFFER, scratch->address),
                        phrase(size_name), number(needed));
    case ADDRESS_IN_BUFFER:
        break;
    }
    return scratch->bytes_left >= needed ||
           violated(finding, "scratchData.deviceAddress",
                    "{} leaves {} to the end of {}, less than {} ({})", hex(scratch->address),
                    count_of(scratch->bytes_left, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(scratch->buffer)),
                    phrase(size_name), number(needed)) ||
           (finding && remarks_on_size_query(finding, build, which));
}

bool build_scratch_is_in_one_buffer(const struct build_view *build, struct finding *finding)
{
    return !is_build(build) || scratch_is_in_one_buffer(build, finding, build->sizes.build_scratch,
                                                        SIZE_OF_BUILD_SCRATCH, "buildScratchSize");
}

bool update_scratch_is_in_one_buffer(const struct build_view *build, struct finding *finding)
{
    return !build_is_update(build->info) ||
           scratch_is_in_one_buffer(build, finding, build->sizes.update_scratch,
                                    SIZE_OF_UPDATE_SCRATCH, "updateScratchSize");
}

static bool scratch_has_storage_usage(const struct build_view *build, struct finding *finding,
                                      VkDeviceSize needed)
{
    const struct address_facts *scratch = &build->scratch;
    if (!build->sizes.known || !needed || scratch->status != ADDRESS_IN_BUFFER)
        return true;
    return (scratch->usage & VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT) ||
           violated(finding, "scratchData.deviceAddress",
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_STORAGE_BUFFER_BIT",
                    hex(scratch->address),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(scratch->buffer)),
                    buffer_usage(scratch->usage));
}

bool build_scratch_has_storage_usage(const struct build_view *build, struct finding *finding)
{
    return !is_build(build) ||
           scratch_has_storage_usage(build, finding, build->sizes.build_scratch);
}

bool update_scratch_has_storage_usage(const struct build_view *build, struct finding *finding)
{
    return !build_is_update(build->info) ||
           scratch_has_storage_usage(build, finding, build->sizes.update_scratch);
}
