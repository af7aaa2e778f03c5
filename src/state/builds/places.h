/* SPDX-License-Identifier: Apache-2.0 */
/* Places where builds that were recorded put structures without a handle: clusters, their
 * templates, bottom-level structures of them, and partitioned structures. They count from then on,
 * whether or not the command is submitted: so a place that is not among them is certain to have
 * none. A place is an address, and the bytes of memory there, which may have other addresses, too;
 * if the address leads to other bytes when the command is submitted, these are added. */
#ifndef ASSAY_STATE_BUILDS_PLACES_H
#define ASSAY_STATE_BUILDS_PLACES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct resources;
struct places; /* one for a device whose extensions have such builds; has its own lock */

/* Returns NULL without memory. */
struct places *places_create(struct resources *resources);
void places_destroy(struct places *places); /* accepts NULL, as all functions here do */

enum place_kind {
    PLACE_BOTTOM_LEVEL,
    PLACE_CLUSTER,
    PLACE_TEMPLATE,
    PLACE_PARTITIONED,
    PLACE_KINDS
};

/* `size`: of the memory in which structures are built; 1: the address is that of the only one. If
 * the bytes there are not known, or memory runs out, structures may be anywhere. */
void places_add(struct places *places, enum place_kind kind, VkDeviceAddress address,
                VkDeviceSize size);
/* Structures are built at addresses that are in device memory. */
void places_add_unknown(struct places *places, enum place_kind kind);
/* Structures that were built, other than partitioned ones, are moved to unknown addresses. */
void places_add_moves(struct places *places);

/* Whether commands may have built structures at all. */
bool places_are_used(struct places *places, enum place_kind kind);
/* Whether there may be a structure at an address, where another device may have built it, too. What
 * the address was is unknown if something was destroyed since resources_destroy_count() was
 * `destroy_count`. */
bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address,
                     uint64_t destroy_count);

#endif
