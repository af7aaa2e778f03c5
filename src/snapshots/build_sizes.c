/* SPDX-License-Identifier: Apache-2.0 */
/* Computes sizes from an input without data. */
#include "src/snapshots/build_sizes.h"

#include "src/snapshots/build_input.h"

static uint64_t find_nothing(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    (void)context;
    (void)address;
    (void)size;
    *bytes = NULL;
    return 0;
}

VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes)
{
    const struct input_memory nothing = {.find = find_nothing};
    struct build_input input;
    *sizes = (struct builder_sizes){0};
    VkResult result = build_input_open(build, &nothing, &input);
    if (result == VK_SUCCESS && input.is_micromap)
        micromap_get_size(&input.micromap, &sizes->structure);
    else if (result == VK_SUCCESS)
        builder_get_sizes(&input.input, counts, sizes);
    build_input_close(&input);
    return result;
}

void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct readable_cache cache = {0};
    struct build_parameters build;
    if (build_parameters_copy(&cache, info, NULL, &build) != VK_SUCCESS)
        return;
    bool takes_counts = build_parameters_take_ranges(&build);
    if (!takes_counts ||
        readable(&cache, counts, sizeof(*counts) * (size_t)build.info.geometryCount))
        build_parameters_sizes(&build, takes_counts ? counts : NULL, sizes);
    build_parameters_release(&build);
}
