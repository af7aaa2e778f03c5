/* SPDX-License-Identifier: Apache-2.0 */
/* Features: all on save for what the configuration says. */
#include "tests/null_driver/internal.h"

#define FIRST_MEMBER ((uint32_t)sizeof(VkBaseOutStructure))

/* NULL where the structure is in no row. Of several rows, one that is known. */
static const struct feature_row *find(const struct null_driver_config *config,
                                      VkStructureType sType)
{
    const struct feature_row *found = NULL;
    for (size_t i = 0; i < feature_row_count; i++) {
        if (feature_rows[i].sType == sType &&
            (found == NULL || guard_is_known(config, feature_rows[i].guard)))
            found = &feature_rows[i];
    }
    return found;
}

static void go_home(const struct null_driver_config *config, VkStructureType *sType,
                    uint32_t *offset)
{
    const struct feature_row *row = find(config, *sType);
    if (row != NULL && row->home != *sType) {
        *offset = *offset - FIRST_MEMBER + row->home_offset;
        *sType = row->home;
    }
}

bool feature_is_on(const struct null_driver_config *config, VkStructureType sType, uint32_t offset)
{
    bool on = true;
    go_home(config, &sType, &offset);
    for (uint32_t i = 0; i < config->feature_count; i++) {
        VkStructureType other = config->features[i].sType;
        uint32_t other_offset = config->features[i].offset;
        go_home(config, &other, &other_offset);
        if (other == sType && other_offset == offset)
            on = config->features[i].value;
    }
    return on;
}

void features_fill(const struct null_driver_config *config, VkPhysicalDeviceFeatures2 *features)
{
    for (VkBaseOutStructure *out = (void *)features; out != NULL; out = out->pNext) {
        const struct feature_row *row = find(config, out->sType);
        if (row == NULL || !guard_is_known(config, row->guard))
            continue;
        for (uint32_t at = FIRST_MEMBER; at < row->end; at += sizeof(VkBool32))
            *(VkBool32 *)((char *)out + at) = feature_is_on(config, out->sType, at);
    }
}

static bool members_are_on(const struct null_driver_config *config, const struct feature_row *row,
                           const void *structure)
{
    const bool known = guard_is_known(config, row->guard);
    for (uint32_t at = FIRST_MEMBER; at < row->end; at += sizeof(VkBool32)) {
        // NOLINTNEXTLINE(clang-analyzer-core.*)
        const VkBool32 asked = *(const VkBool32 *)((const char *)structure + at);
        if (asked && !(known && feature_is_on(config, row->sType, at)))
            return false;
    }
    return true;
}

bool features_are_on(const struct null_driver_config *config, const void *pNext,
                     const VkPhysicalDeviceFeatures *pEnabledFeatures)
{
    const VkPhysicalDeviceFeatures2 core = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
        .pNext = (void *)pNext,
        .features = pEnabledFeatures != NULL ? *pEnabledFeatures : (VkPhysicalDeviceFeatures){0},
    };
    for (const VkBaseInStructure *in = (const void *)&core; in != NULL; in = in->pNext) {
        const struct feature_row *row = find(config, in->sType);
        if (row != NULL && !members_are_on(config, row, in))
            return false;
    }
    return true;
}
