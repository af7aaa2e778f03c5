/* SPDX-License-Identifier: Apache-2.0 */
/* Aligned copies of the parameters of a build call, which take the place of what is misaligned in
 * the views. What can't be read stays as it is. */
#ifndef ASSAY_CHECK_ASSEMBLE_ALIGN_H
#define ASSAY_CHECK_ASSEMBLE_ALIGN_H

#include "src/check/walk/context.h"

/* Whether the arrays of a call are aligned: those of nearly all calls are. */
static inline bool call_is_aligned(const struct call_view *call)
{
    uintptr_t of_pointers = (uintptr_t)call->infos | (uintptr_t)(const void *)call->build_ranges |
                            (uintptr_t)(const void *)call->max_primitive_counts |
                            (uintptr_t)call->indirect_addresses;
    uintptr_t of_words = (uintptr_t)call->indirect_strides;
    return !(of_pointers & (_Alignof(uint64_t) - 1)) && !(of_words & (_Alignof(uint32_t) - 1));
}

/* Makes the arrays of the call aligned. Returns false without memory. */
__attribute__((cold)) bool align_call(struct check_context *context, struct call_view *call);

/* Whether the geometries of a build, their chains, or what these point to is misaligned. */
__attribute__((cold)) bool build_is_misaligned(struct check_context *context,
                                               const struct build_view *build);
/* Makes all of that aligned. Returns false without memory. */
__attribute__((cold)) bool align_build(struct check_context *context, struct build_view *build);

/* The same of the parameters of COMMAND_NV. Returns false without memory. */
bool align_nv_call(struct check_context *context, struct nv_call_view *call);

/* `array` if it is aligned, else a copy; NULL without memory. */
static inline const void *align_array(struct check_context *context, const void *array, size_t size,
                                      size_t alignment)
{
    return is_aligned(array, alignment) ? array : aligned_copies_take(context->copies, array, size);
}

#endif
