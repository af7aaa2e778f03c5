/* SPDX-License-Identifier: Apache-2.0 */
/* Statements that rules of several subjects make of a member. */
#ifndef ASSAY_CHECK_STATEMENTS_H
#define ASSAY_CHECK_STATEMENTS_H

#include "check/finding.h"

static inline bool address_is_given(struct finding *finding, const char *field,
                                    VkDeviceAddress address)
{
    return address || violated_plainly(finding, field, "is 0");
}

static inline bool host_address_is_given(struct finding *finding, const char *field,
                                         const void *address)
{
    return address || violated_plainly(finding, field, "is NULL");
}

/* Alignment 0: none is known. */
static inline bool address_is_aligned(struct finding *finding, const char *field,
                                      VkDeviceAddress address, uint32_t alignment)
{
    return !alignment || address % alignment == 0 ||
           violated(finding, field, "{} is not aligned to {} bytes", hex(address),
                    number(alignment));
}

static inline bool stride_fits_32_bits(struct finding *finding, const char *field,
                                       VkDeviceSize stride)
{
    return stride <= UINT32_MAX || violated(finding, field, "{} exceeds 2^32 - 1", number(stride));
}

#endif
