/* SPDX-License-Identifier: Apache-2.0 */
/* The structures without contents that instances of executed builds refer to. */
#ifndef ASSAY_CHECK_CONTENT_UNBUILT_H
#define ASSAY_CHECK_CONTENT_UNBUILT_H

#include "src/check/content/content.h"

/* These structures, of the builds of one call. Zero bytes are an empty list. */
struct unbuilt_uses {
    struct unbuilt_use {
        uint32_t build; /* index in the call */
        struct instance_use use;
        bool is_built_later;
        const VkAccelerationStructureGeometryKHR *geometry; /* of the instances */
        const VkAccelerationStructureBuildGeometryInfoKHR *info;
    } * items;
    uint32_t count, capacity;
};

/* Adds the structures that nothing had been built into, or copied to, when the build executed. Adds
 * none if the build's execution point is unknown, or if there is no memory. */
void unbuilt_uses_add(struct unbuilt_uses *unbuilt, const struct walk *walk,
                      const struct build_view *build, const struct instance_uses *uses);
/* Evaluates the rule about them, and frees the memory. `is_built`: whether the call builds a
 * structure, which another rule is about. */
void unbuilt_uses_check(struct unbuilt_uses *unbuilt, struct walk *walk,
                        const struct call_view *call, bool (*is_built)(void *context, uint64_t id),
                        void *context);

#endif
