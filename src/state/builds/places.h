/* SPDX-License-Identifier: Apache-2.0 */
/* Addresses at which builds that were recorded place structures without a handle: clusters, their
 * templates, bottom-level structures of them, and partitioned structures. They count from then on,
 * whether or not the command is submitted: so an address that is not among them is certain to have
 * none. */
#ifndef ASSAY_STATE_BUILDS_PLACES_H
#define ASSAY_STATE_BUILDS_PLACES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct places; /* one for a device whose extensions have such builds; has its own lock */

/* Returns NULL without memory. */
struct places *places_create(void);
void places_destroy(struct places *places); /* accepts NULL, as all functions here do */

enum place_kind {
    PLACE_BOTTOM_LEVEL,
    PLACE_CLUSTER,
    PLACE_TEMPLATE,
    PLACE_PARTITIONED,
    PLACE_KINDS
};

/* `size`: of the memory in which structures are built; 1: the address is that of the only one. If
 * memory runs out, structures may be anywhere. */
void places_add(struct places *places, enum place_kind kind, VkDeviceAddress address,
                VkDeviceSize size);
/* Structures are built at addresses that are in device memory. */
void places_add_unknown(struct places *places, enum place_kind kind);
/* Structures that were built, other than partitioned ones, are moved to unknown addresses. */
void places_add_moves(struct places *places);

/* Whether structures may have been built at all; and at an address. */
bool places_are_used(struct places *places, enum place_kind kind);
bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address);

#endif
