/* SPDX-License-Identifier: Apache-2.0 */
/* Checking what the addresses of a build lead to. */
#ifndef ASSAY_RULES_ADDRESS_H
#define ASSAY_RULES_ADDRESS_H

#include "src/check/walk/walk.h"

/* The addresses of a geometry, with those that extensions chain to it. */
void check_geometry_addresses(struct walk *walk, const struct geometry_view *geometry);
/* The scratch of a build, if its size is known. */
void check_scratch_address(struct walk *walk, const struct build_view *build);
void check_indirect_address(struct walk *walk, const struct indirect_view *indirect);

/* Whether no rule is broken by a plain input; false if that has to be asked. */
static inline bool address_is_plain(const struct address_facts *facts)
{
    return facts->status == ADDRESS_IN_BUFFER
               ? facts->usage &
                     VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR
               : facts->status == ADDRESS_UNKNOWN || facts->status == ADDRESS_NULL;
}

static inline bool geometry_addresses_hold(const struct geometry_view *geometry)
{
    const struct chained_inputs *chained = geometry->chained;
    for (uint32_t i = 0; chained && i < chained->count; i++)
        if (!address_is_plain(&chained->items[i].facts))
            return false;
    return address_is_plain(&geometry->vertex) && address_is_plain(&geometry->index_data) &&
           address_is_plain(&geometry->transform) && address_is_plain(&geometry->data);
}

static inline bool scratch_address_holds(const struct build_view *build)
{
    return build->scratch.status != ADDRESS_UNBOUND;
}

#endif
