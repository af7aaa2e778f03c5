/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the addresses from which vkCmdBuildAccelerationStructuresIndirectKHR reads build
 * ranges. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

#define STRIDES "pIndirectStrides"

bool indirect_address_is_aligned(const struct indirect_view *indirect, struct finding *finding)
{
    return !indirect->address || *indirect->address % 4 == 0 ||
           violated(finding, input_field(INPUT_INDIRECT), "{} is not a multiple of 4",
                    hex(*indirect->address));
}

bool indirect_stride_is_aligned(const struct indirect_view *indirect, struct finding *finding)
{
    return !indirect->stride || *indirect->stride % 4 == 0 ||
           violated(finding, STRIDES, "{} is not a multiple of 4", number(*indirect->stride));
}

static struct value buffer(const struct address_facts *facts)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer));
}

/* A build without geometries reads no address. */
bool indirect_ranges_are_in_one_buffer(const struct indirect_view *indirect,
                                       struct finding *finding)
{
    const struct address_facts *facts = &indirect->facts;
    const char *field = input_field(INPUT_INDIRECT);
    uint32_t count = indirect->build->info->geometryCount;
    VkDeviceSize needed = indirect->stride ? (VkDeviceSize)count * *indirect->stride : 0;
    if (!needed)
        return true;
    switch (facts->status) {
    case ADDRESS_UNKNOWN:
    case ADDRESS_UNBOUND: /* see input_buffer_is_bound */
        return true;
    case ADDRESS_NULL:
    case ADDRESS_NOWHERE:
        return violated(finding, field, "{} is in no buffer, but geometryCount is {}",
                        address_of_missing(VK_OBJECT_TYPE_BUFFER, facts->address), number(count));
    case ADDRESS_IN_BUFFER:
        break;
    }
    return facts->bytes_left >= needed ||
           violated(
               finding, field,
               "{} leaves {} to the end of {}, less than geometryCount ({}) times the stride ({})",
               hex(facts->address), count_of(facts->bytes_left, "byte"), buffer(facts),
               number(count), number(*indirect->stride));
}

bool indirect_buffer_has_indirect_usage(const struct indirect_view *indirect,
                                        struct finding *finding)
{
    const struct address_facts *facts = &indirect->facts;
    return facts->status != ADDRESS_IN_BUFFER || !indirect->build->info->geometryCount ||
           (facts->usage & VK_BUFFER_USAGE_2_INDIRECT_BUFFER_BIT) ||
           violated(finding, input_field(INPUT_INDIRECT),
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT",
                    hex(facts->address), buffer(facts), buffer_usage(facts->usage));
}
