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

#include "src/model/clusters.h"

struct resources;
struct places; /* one for a device whose extensions have such builds; has its own lock */

/* Returns NULL without memory. */
struct places *places_create(struct resources *resources);
void places_destroy(struct places *places); /* accepts NULL, as all functions here do */

/* What a build puts somewhere. */
struct placed {
    enum place_kind kind;
    VkFormat format; /* of the vertices that templates are built for; else VK_FORMAT_UNDEFINED */
    VkDeviceAddress address;
    VkDeviceSize
        size; /* of the memory that the structures are in; 1: only one is, at the address */
};

/* If the bytes there are not known, or memory runs out, structures may be anywhere. */
void places_add(struct places *places, const struct placed *placed);
/* Structures are built at addresses that are in device memory. */
void places_add_unknown(struct places *places, enum place_kind kind);
/* Structures that were built, other than partitioned ones, are moved to unknown addresses. */
void places_add_moves(struct places *places);
/* Memory ran out for commands that are submitted: they may have built structures anywhere. */
void places_lack_memory(struct places *places);

/* Whether commands may have built structures at all. */
bool places_are_used(struct places *places, enum place_kind kind);
/* Whether there may be a structure at an address, where another device may have built it, too. What
 * the address was is unknown if something was destroyed since resources_destroy_count() was
 * `destroy_count`. */
bool places_may_hold(struct places *places, enum place_kind kind, VkDeviceAddress address,
                     uint64_t destroy_count);

/* Returns the addresses at which there may be structures, where another device may have built them,
 * too: disjoint ranges in ascending order, which the caller frees. A *count of PLACES_ANYWHERE:
 * they may be at all addresses, or memory ran out. */
#define PLACES_ANYWHERE UINT32_MAX
struct place_range {
    uint64_t begin, end;
};
struct place_range *places_list(struct places *places, enum place_kind kind, uint32_t *count);

/* ---- What level CONTENT has read of the builds of templates and partitioned structures, in
 * execution order. It says something of a build only if all such builds before it were read as a
 * whole. */

/* A build executes. Returns how many such builds have executed before. */
#define PLACE_UNNUMBERED UINT64_MAX /* it is not known */
uint64_t places_execute(struct places *places, enum place_kind kind);
bool places_are_read(struct places *places, uint64_t before);
/* Notes that such a build was read as a whole; and of templates where they are, for which vertices
 * they were built, and whether one has some. */
void places_set_read(struct places *places, uint64_t before);
void places_set_templates_read(struct places *places, VkDeviceAddress address, VkFormat format,
                               bool has_vertices);

/* What is certain of a template at an address. */
struct template_facts {
    bool has_no_vertices;
    VkFormat format; /* that it was built for; VK_FORMAT_UNDEFINED: unknown */
};
struct template_facts places_find_template(struct places *places, VkDeviceAddress address,
                                           uint64_t destroy_count);

/* Instances of partitioned structures. A build puts one there, or changes it, in a structure that
 * it begins (`is_new`) or that was built. `may_be_updated`: it has explicit bounds, or no
 * acceleration structure. */
void places_begin_instances(struct places *places);
void places_add_instance(struct places *places, uint32_t index, bool is_new, bool may_be_updated);
/* Whether each structure of this device certainly has an instance of that index, which may not be
 * updated; and whether only this device can have put a structure at an address. */
bool places_instance_is_fixed(struct places *places, uint32_t index);
bool places_are_own(struct places *places, VkDeviceAddress address, uint64_t destroy_count);

#endif
