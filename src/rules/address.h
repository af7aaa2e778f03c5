/* SPDX-License-Identifier: Apache-2.0 */
/* Fast checks that no address rule is violated, so that the caller can skip the rules. */
#ifndef ASSAY_RULES_ADDRESS_H
#define ASSAY_RULES_ADDRESS_H

#include "src/view/view.h"

/* Returns true if the address of an input violates no rule; false if the rules must be
 * evaluated. */
static inline bool address_is_plain(const struct address_facts *facts)
{
    return facts->status == ADDRESS_IN_BUFFER
               ? facts->usage &
                     VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR
               : facts->status == ADDRESS_UNKNOWN || facts->status == ADDRESS_NULL;
}

static inline bool geometry_addresses_pass(const struct geometry_view *geometry)
{
    const struct chained_inputs *chained = geometry->chained;
    for (uint32_t i = 0; chained && i < chained->count; i++)
        if (!address_is_plain(&chained->items[i].facts))
            return false;
    return address_is_plain(&geometry->vertex) && address_is_plain(&geometry->index_data) &&
           address_is_plain(&geometry->transform) && address_is_plain(&geometry->data);
}

static inline bool scratch_address_passes(const struct build_view *build)
{
    return build->scratch.status != ADDRESS_UNBOUND;
}

#endif
