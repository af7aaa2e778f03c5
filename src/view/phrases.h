/* SPDX-License-Identifier: Apache-2.0 */
/* Statements about a member that rules of several subjects share. */
#ifndef ASSAY_VIEW_PHRASES_H
#define ASSAY_VIEW_PHRASES_H

#include "src/view/finding.h"
#include "src/view/view.h"

/* Statements about the data of a geometry. They hold if the geometry is empty: see
 * geometry_is_empty(). */
static inline bool input_is_given(const struct geometry_view *geometry, struct finding *finding,
                                  const char *field, VkDeviceAddress address)
{
    return address || geometry_is_empty(geometry) || violated_plainly(finding, field, "is 0");
}

static inline bool host_input_is_given(const struct geometry_view *geometry,
                                       struct finding *finding, const char *field,
                                       const void *address)
{
    return address || geometry_is_empty(geometry) || violated_plainly(finding, field, "is NULL");
}

/* The command decides which member of the union is meant. */
static inline bool chained_address_is_given(const struct geometry_view *geometry,
                                            struct finding *finding, const char *field,
                                            VkDeviceOrHostAddressConstKHR address)
{
    return geometry->build->call->command == COMMAND_HOST
               ? host_input_is_given(geometry, finding, field, address.hostAddress)
               : input_is_given(geometry, finding, field, address.deviceAddress);
}

static inline bool address_is_given(struct finding *finding, const char *field,
                                    VkDeviceAddress address)
{
    return address || violated_plainly(finding, field, "is 0");
}

/* Alignment 0 means that the alignment is unknown; the statement holds. */
static inline bool address_is_aligned(struct finding *finding, const char *field,
                                      VkDeviceAddress address, uint32_t alignment)
{
    return !alignment || address % alignment == 0 ||
           violated(finding, field, "{} is not aligned to {}", hex(address),
                    count_of(alignment, "byte"));
}

static inline bool stride_fits_32_bits(struct finding *finding, const char *field,
                                       VkDeviceSize stride)
{
    return stride <= UINT32_MAX || violated(finding, field, "{} exceeds 2^32 - 1", number(stride));
}

#endif
