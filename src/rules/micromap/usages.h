/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that rules about usage counts share, for every structure that has usage counts. */
#ifndef ASSAY_RULES_MICROMAP_USAGES_H
#define ASSAY_RULES_MICROMAP_USAGES_H

#include "src/view/finding.h"
#include "src/view/micromap_view.h"

/* Returns usage `index`, which must be less than the count. */
VkMicromapUsageEXT usage_at(const struct micromap_usages *usages, uint32_t index);

/* Returns the path of the array that the application gives. */
const char *usages_field(const struct micromap_usages *usages);

/* Returns the sum of the counts of all usages. */
uint64_t usages_sum(const struct micromap_usages *usages);

/* Statements that apply to every structure with usages. Each returns true, or fills the finding and
 * returns false. */
bool usages_are_given_once(const struct micromap_usages *usages, struct finding *finding);
bool usage_array_is_readable(const struct micromap_usages *usages, struct finding *finding);
bool usage_pointers_are_readable(const struct micromap_usages *usages, struct finding *finding);

/* Each format is from 1 to `last`. `type` is the name of the enumeration. */
bool usage_formats_are_valid(const struct micromap_usages *usages, uint32_t last, const char *type,
                             struct finding *finding);

/* The level of each usage of `format`, or of every usage if `format` is ANY_FORMAT, is within
 * `limit`. */
enum { ANY_FORMAT = 0 };
bool usage_levels_are_within(const struct micromap_usages *usages, uint32_t format, uint32_t limit,
                             const char *limit_name, struct finding *finding);

#endif
