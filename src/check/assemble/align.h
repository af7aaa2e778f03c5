/* SPDX-License-Identifier: Apache-2.0 */
/* Replaces misaligned parameters of a build call with aligned copies in the views. Unreadable
 * parameters stay as they are. The copies belong to the context's aligned_copies. */
#ifndef ASSAY_CHECK_ASSEMBLE_ALIGN_H
#define ASSAY_CHECK_ASSEMBLE_ALIGN_H

#include "src/check/walk/context.h"

/* Returns whether the arrays of a call are aligned, as in nearly all calls. */
static inline bool call_is_aligned(const struct call_view *call)
{
    uintptr_t of_pointers = (uintptr_t)call->infos | (uintptr_t)(const void *)call->build_ranges |
                            (uintptr_t)(const void *)call->max_primitive_counts |
                            (uintptr_t)call->indirect_addresses;
    uintptr_t of_words = (uintptr_t)call->indirect_strides;
    return !(of_pointers & (_Alignof(uint64_t) - 1)) && !(of_words & (_Alignof(uint32_t) - 1));
}

/* Aligns the arrays of the call. Returns false if there is no memory. */
__attribute__((cold)) bool align_call(struct check_context *context, struct call_view *call);

/* Returns whether the geometries of a build, their chains, or arrays in the chains are
 * misaligned. */
__attribute__((cold)) bool build_is_misaligned(struct check_context *context,
                                               const struct build_view *build);
/* Aligns all of these. Returns false if there is no memory. */
__attribute__((cold)) bool align_build(struct check_context *context, struct build_view *build);

/* Aligns the parameters of COMMAND_NV. Returns false if there is no memory. */
bool align_nv_call(struct check_context *context, struct nv_call_view *call);

/* Returns `array` if it is aligned, else a copy. Returns NULL if there is no memory. */
static inline const void *align_array(struct check_context *context, const void *array, size_t size,
                                      size_t alignment)
{
    return is_aligned(array, alignment) ? array : aligned_copies_take(context->copies, array, size);
}

#endif
