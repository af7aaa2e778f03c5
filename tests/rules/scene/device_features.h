/* SPDX-License-Identifier: Apache-2.0 */
/* The extensions and features of a world's device, by its setup. */
#ifndef RULES_DEVICE_FEATURES_H
#define RULES_DEVICE_FEATURES_H

#include "tests/rules/scene/fixture.h"

enum { FEATURES_EXTENSIONS = 24, FEATURES_STRUCTURES = 16 };

/* Holds what a VkDeviceCreateInfo points to. */
struct features {
    const char *extensions[FEATURES_EXTENSIONS];
    uint32_t extension_count;
    VkPhysicalDeviceFeatures2 core;
    union {
        VkBaseOutStructure base;
        unsigned char bytes[sizeof(VkPhysicalDeviceVulkan12Features)]; /* the largest */
    } structures[FEATURES_STRUCTURES];
};

/* Chains everything to `create_info`; `features` has to outlive its use. */
void features_fill(struct features *features, const struct fixture *fixture,
                   VkDeviceCreateInfo *create_info);

/* NULL, or which extension or feature of the setup the physical device lacks. */
const char *features_missing(const struct fixture *fixture);

/* Configures the null driver so that it offers the setup. */
void features_configure(struct null_driver_config *config, const struct setup *setup);

#endif
