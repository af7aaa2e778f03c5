/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the input data of builds for the rules about it, from wherever that can be read. */
#ifndef ASSAY_CHECK_CONTENT_H
#define ASSAY_CHECK_CONTENT_H

#include "check/content_view.h"
#include "check/walk.h"
#include "cpu/memory.h"

/* At level CONTENT: puts the data of a geometry of a host build to its rules. What can't be read,
 * and ranges that are not known, others speak of. */
void check_host_contents(struct walk *walk, const struct range_view *range);

/* The data of one geometry, on its way through the rules. Each rule speaks of it once. */
struct content {
    struct walk *walk;
    const struct range_view *range; /* with its build range */
    const struct cpu_memory *memory;
    bool wants[RULE_COUNT];
};

/* All bytes of `count` elements of `size` bytes, `stride` apart, from an offset on; NULL where any
 * can't be read, or where there are none. */
const uint8_t *content_find(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                            uint64_t offset, uint64_t count, uint64_t stride, uint64_t size);

/* Each walks the rows of its subject. */
void content_walk_indices(struct content *content, const struct indices_view *indices);
void content_walk_box(struct content *content, const struct box_view *box);
void content_walk_transform(struct content *content, const struct transform_view *transform);

#endif
