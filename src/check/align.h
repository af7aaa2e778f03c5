/* SPDX-License-Identifier: Apache-2.0 */
/* Aligned copies of the parameters of a build call, which take the place of what is misaligned in
 * the views. What can't be read stays as it is. */
#ifndef ASSAY_CHECK_ALIGN_H
#define ASSAY_CHECK_ALIGN_H

#include "check/check.h"

/* Makes the arrays of the call aligned. Returns false without memory. */
bool align_call(struct check_context *context, struct call_view *call);

/* Whether the geometries of a build, their chains, or what these point to is misaligned. */
bool build_is_misaligned(struct check_context *context, const struct build_view *build);
/* Makes all of that aligned. Returns false without memory. */
bool align_build(struct check_context *context, struct build_view *build);

/* The same of the parameters of COMMAND_NV. Returns false without memory. */
bool align_nv_call(struct check_context *context, struct nv_call_view *call);

/* `array` if it is aligned, else a copy; NULL without memory. */
static inline const void *align_array(struct check_context *context, const void *array, size_t size,
                                      size_t alignment)
{
    return is_aligned(array, alignment) ? array : aligned_copies_take(context->copies, array, size);
}

#endif
