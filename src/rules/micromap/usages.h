/* SPDX-License-Identifier: Apache-2.0 */
/* What rules ask of usage counts, whichever structure has them. */
#ifndef ASSAY_RULES_MICROMAP_USAGES_H
#define ASSAY_RULES_MICROMAP_USAGES_H

#include "src/view/finding.h"
#include "src/view/micromap_view.h"

/* The index-th usage, index < count. */
VkMicromapUsageEXT usage_at(const struct micromap_usages *usages, uint32_t index);

/* The path of the array that is given. */
const char *usages_field(const struct micromap_usages *usages);

/* The sum of their counts. */
uint64_t usages_sum(const struct micromap_usages *usages);

/* Whether the sum is known to be 0. */
bool usages_are_empty(const struct micromap_usages *usages, uint32_t usage_counts_count);

/* Each is a rule of all structures with usages: true, or false and a finding. */
bool usages_are_given_once(const struct micromap_usages *usages, struct finding *finding);
bool usage_array_is_readable(const struct micromap_usages *usages, struct finding *finding);
bool usage_pointers_are_readable(const struct micromap_usages *usages, struct finding *finding);

/* Whether each format is 1 to `last`; `type` is the enumeration that has those. */
bool usage_formats_are_valid(const struct micromap_usages *usages, uint32_t last, const char *type,
                             struct finding *finding);

/* Whether the level of each usage of a format, or of all for ANY_FORMAT, is within a limit. */
enum { ANY_FORMAT = 0 };
bool usage_levels_are_within(const struct micromap_usages *usages, uint32_t format, uint32_t limit,
                             const char *limit_name, struct finding *finding);

#endif
