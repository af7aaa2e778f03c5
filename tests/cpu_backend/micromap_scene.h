/* SPDX-License-Identifier: Apache-2.0 */
/* A micromap on a device fixture. One of opacities: triangle 0 is transparent, 1 opaque, and of 2
 * the quarter at vertex 0 is transparent, the middle opaque, that at vertex 1 unknown transparent,
 * at vertex 2 unknown opaque. One of displacements: of triangle 0 the middles of its edges rise, by
 * `micromap_rise`, and all of triangle 1 does. */
#ifndef CPU_BACKEND_MICROMAP_SCENE_H
#define CPU_BACKEND_MICROMAP_SCENE_H

#include "input_scene.h"

enum { DATA = 256, MICROMAP_SIZE = 4096 };

extern const VkMicromapUsageEXT micromap_usages[2], micromap_displacement_usages[2];

struct micromap {
    VkMicromapEXT ext;
    VkAccelerationStructureKHR khr;
    struct device_buffer storage, input;
    VkMicromapTypeEXT type;
    const VkMicromapUsageEXT *usages;
};

void micromap_open(struct micromap *micromap, bool is_ext);
void micromap_open_displacement(struct micromap *micromap); /* of -EXT; its input is zeros */
void micromap_rise(const struct micromap *micromap, uint32_t rise); /* fills in the input */

/* A build of -EXT's from the input at that address. */
VkMicromapBuildInfoEXT micromap_info(const struct micromap *micromap, uint64_t base);
VkResult micromap_build_by_host(const struct micromap *micromap);
VkResult micromap_copy_by_host(const struct micromap *src, const struct micromap *dst,
                               VkCopyMicromapModeEXT mode);
VkResult micromap_save_by_host(const struct micromap *src, void *dst);
VkResult micromap_load_by_host(const void *src, const struct micromap *dst);
void micromap_clone_by_device(VkCommandBuffer commands, const struct micromap *src,
                              const struct micromap *dst);
/* Nothing is left of the input afterwards. */
void micromap_build_by_device(const struct micromap *micromap);

#endif
