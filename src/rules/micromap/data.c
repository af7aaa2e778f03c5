/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the input data of a micromap of VK_KHR_opacity_micromap. */
#include "src/rules/micromap/shared.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/phrases.h"

enum { TRIANGLE_ALIGNMENT = 4, INPUT_ALIGNMENT = 128 };

static bool is_lossy(const struct micromap_data_view *view)
{
    return view->geometry->build->info->flags &
           VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR;
}

static const struct device_facts *device_of(const struct micromap_data_view *view)
{
    return view->geometry->build->call->device;
}

/* ---- usages */

bool micromap_data_has_one_usage_array(const struct micromap_data_view *micromap_data,
                                       struct finding *finding)
{
    return usages_are_given_once(&micromap_data->usages, finding);
}

bool micromap_data_usages_are_readable(const struct micromap_data_view *micromap_data,
                                       struct finding *finding)
{
    return usage_array_is_readable(&micromap_data->usages, finding);
}

bool micromap_data_usage_pointers_are_readable(const struct micromap_data_view *micromap_data,
                                               struct finding *finding)
{
    return usage_pointers_are_readable(&micromap_data->usages, finding);
}

bool micromap_data_usage_format_is_valid(const struct micromap_data_view *micromap_data,
                                         struct finding *finding)
{
    return device_of(micromap_data)->newer_than_registry ||
           usage_formats_are_valid(&micromap_data->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR,
                                   "VkOpacityMicromapFormatKHR", finding);
}

bool lossy_usage_is_4_state(const struct micromap_data_view *micromap_data, struct finding *finding)
{
    const struct micromap_usages *usages = &micromap_data->usages;
    for (uint32_t i = 0; is_lossy(micromap_data) && i < usages->count; i++) {
        uint32_t format = usage_at(usages, i).format;
        if (format != VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR)
            return violated(
                finding, usages_field(usages),
                "has format {} at index {}, not VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR, which "
                "VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR in flags requires",
                number(format), number(i));
    }
    return true;
}

bool usage_2_state_level_is_within_limit(const struct micromap_data_view *micromap_data,
                                         struct finding *finding)
{
    return usage_levels_are_within(
        &micromap_data->usages, VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR,
        device_of(micromap_data)->micromap.khr_limits.opacity_2_state_level,
        "maxOpacity2StateSubdivisionLevel", finding);
}

bool usage_4_state_level_is_within_limit(const struct micromap_data_view *micromap_data,
                                         struct finding *finding)
{
    return is_lossy(micromap_data) ||
           usage_levels_are_within(
               &micromap_data->usages, VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR,
               device_of(micromap_data)->micromap.khr_limits.opacity_4_state_level,
               "maxOpacity4StateSubdivisionLevel", finding);
}

bool lossy_usage_level_is_within_limit(const struct micromap_data_view *micromap_data,
                                       struct finding *finding)
{
    return !is_lossy(micromap_data) ||
           usage_levels_are_within(
               &micromap_data->usages, ANY_FORMAT,
               device_of(micromap_data)->micromap.khr_limits.lossy_4_state_level,
               "maxOpacityLossy4StateSubdivisionLevel", finding);
}

bool micromap_triangle_count_is_within_limit(const struct micromap_data_view *micromap_data,
                                             struct finding *finding)
{
    uint64_t sum = usages_sum(&micromap_data->usages);
    uint64_t limit = device_of(micromap_data)->micromap.khr_limits.triangles;
    return sum <= limit || violated(finding, usages_field(&micromap_data->usages),
                                    "has {} in total, more than maxMicromapTriangles ({})",
                                    count_of(sum, "triangle"), number(limit));
}

/* ---- addresses */

bool micromap_triangle_stride_holds_a_triangle(const struct micromap_data_view *micromap_data,
                                               struct finding *finding)
{
    VkDeviceSize stride = micromap_data->data->triangleArrayStride;
    return stride >= sizeof(VkMicromapTriangleKHR) ||
           violated(finding, MICROMAP_DATA "triangleArrayStride", "{} is less than {}",
                    number(stride), number(sizeof(VkMicromapTriangleKHR)));
}

bool micromap_triangle_stride_is_aligned(const struct micromap_data_view *micromap_data,
                                         struct finding *finding)
{
    VkDeviceSize stride = micromap_data->data->triangleArrayStride;
    return stride % TRIANGLE_ALIGNMENT == 0 ||
           violated(finding, MICROMAP_DATA "triangleArrayStride", "{} is not a multiple of {}",
                    number(stride), number(TRIANGLE_ALIGNMENT));
}

bool micromap_addresses_are_given(const struct micromap_data_view *micromap_data,
                                  struct finding *finding)
{
    const VkAccelerationStructureGeometryMicromapDataKHR *data = micromap_data->data;
    if (!data->data && !data->triangleArray)
        return violated_plainly(finding, MICROMAP_DATA "data", "and triangleArray are 0");
    return address_is_given(finding, MICROMAP_DATA "data", data->data) &&
           address_is_given(finding, MICROMAP_DATA "triangleArray", data->triangleArray);
}

bool micromap_addresses_are_aligned(const struct micromap_data_view *micromap_data,
                                    struct finding *finding)
{
    const VkAccelerationStructureGeometryMicromapDataKHR *data = micromap_data->data;
    if (data->data % INPUT_ALIGNMENT && data->triangleArray % INPUT_ALIGNMENT)
        return violated(finding, MICROMAP_DATA "data",
                        "{} and triangleArray {} are not aligned to {}", hex(data->data),
                        hex(data->triangleArray), count_of(INPUT_ALIGNMENT, "byte"));
    return address_is_aligned(finding, MICROMAP_DATA "data", data->data, INPUT_ALIGNMENT) &&
           address_is_aligned(finding, MICROMAP_DATA "triangleArray", data->triangleArray,
                              INPUT_ALIGNMENT);
}

static struct value buffer(const struct address_facts *facts)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer));
}

/* A product that overflows exceeds any buffer. */
bool micromap_triangles_are_in_one_buffer(const struct micromap_data_view *micromap_data,
                                          struct finding *finding)
{
    const struct address_facts *facts = micromap_data->triangles_facts;
    uint64_t count = usages_sum(&micromap_data->usages), size;
    VkDeviceSize stride = micromap_data->data->triangleArrayStride;
    bool wraps = __builtin_mul_overflow(stride, count, &size);
    return facts->status != ADDRESS_IN_BUFFER || (!wraps && size <= facts->bytes_left) ||
           violated(finding, MICROMAP_DATA "triangleArray",
                    "{} leaves {} to the end of {}, not enough for {} with triangleArrayStride {}",
                    hex(facts->address), count_of(facts->bytes_left, "byte"), buffer(facts),
                    count_of(count, "triangle"), number(stride));
}
