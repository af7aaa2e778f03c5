/* SPDX-License-Identifier: Apache-2.0 */
/* Whether host memory that a build accesses is there. */
#ifndef ASSAY_CHECK_ASSEMBLE_HOST_MEMORY_H
#define ASSAY_CHECK_ASSEMBLE_HOST_MEMORY_H

#include "src/check/walk/context.h"
#include "src/view/host_view.h"

/* Returns whether `size` bytes are readable or lie in mapped device memory. Tools that trace writes
 * (gfxreconstruct) protect the pages of a mapping, and handle the faults: such pages are valid,
 * though they are not readable now. */
bool host_memory_is_there(struct check_context *context, const void *address, uint64_t size);

/* Returns the bytes of `count` elements of `size` bytes with a stride, beginning at an offset from
 * the address. */
struct host_bytes host_memory_bytes(struct check_context *context, const void *address,
                                    uint64_t offset, uint64_t count, uint64_t stride,
                                    uint64_t size);

#endif
