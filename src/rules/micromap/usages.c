/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about usage counts. */
#include "src/rules/micromap/shared.h"

#include <string.h>

_Static_assert(sizeof(VkMicromapUsageEXT) == sizeof(VkMicromapUsageKHR), "laid out alike");

VkMicromapUsageEXT usage_at(const struct micromap_usages *usages, uint32_t index)
{
    VkMicromapUsageEXT usage;
    memcpy(&usage,
           usages->array ? (const char *)usages->array + (size_t)index * sizeof(usage)
                         : usages->pointers[index],
           sizeof(usage));
    return usage;
}

const char *usages_field(const struct micromap_usages *usages)
{
    return usages->array ? usages->array_field : usages->pointers_field;
}

uint64_t usages_sum(const struct micromap_usages *usages)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < usages->count; i++)
        sum += usage_at(usages, i).count;
    return sum;
}

bool usages_are_given_once(const struct micromap_usages *usages, struct finding *finding)
{
    return !usages->both_given ||
           violated_plainly(finding, usages->array_field,
                            "and ppUsageCounts are both given: one of them must be NULL");
}

bool usage_array_is_readable(const struct micromap_usages *usages, struct finding *finding)
{
    return !usages->array_unreadable ||
           violated_plainly(finding, usages->array_field,
                            "does not point to usageCountsCount readable usages");
}

bool usage_pointers_are_readable(const struct micromap_usages *usages, struct finding *finding)
{
    return !usages->pointers_unreadable ||
           violated_plainly(finding, usages->pointers_field,
                            "does not point to usageCountsCount readable pointers to usages");
}

bool usage_formats_are_valid(const struct micromap_usages *usages, uint32_t last, const char *type,
                             struct finding *finding)
{
    for (uint32_t i = 0; i < usages->count; i++) {
        uint32_t format = usage_at(usages, i).format;
        if (format < 1 || format > last)
            return violated(finding, usages_field(usages),
                            "has format {} at index {}, which is not a {}", number(format),
                            number(i), phrase(type));
    }
    return true;
}

bool usage_levels_are_within(const struct micromap_usages *usages, uint32_t format, uint32_t limit,
                             const char *limit_name, struct finding *finding)
{
    for (uint32_t i = 0; i < usages->count; i++) {
        VkMicromapUsageEXT usage = usage_at(usages, i);
        if ((format == ANY_FORMAT || usage.format == format) && usage.subdivisionLevel > limit)
            return violated(
                finding, usages_field(usages),
                "has subdivisionLevel {} with format {} at index {}, which exceeds {} ({})",
                number(usage.subdivisionLevel), number(usage.format), number(i), phrase(limit_name),
                number(limit));
    }
    return true;
}
