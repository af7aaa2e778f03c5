/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow by one element at a time. The owner keeps the array, its count and its capacity,
 * all of which are zero at first, and frees the array. */
#ifndef ASSAY_BASE_ARRAY_H
#define ASSAY_BASE_ARRAY_H

#include <stddef.h>
#include <stdint.h>

/* Makes room for one more element of `size` bytes. Returns the array, which may have moved. Returns
 * NULL without memory: the array and its capacity then stay as they are. */
void *array_make_room(void *items, uint32_t count, uint32_t *capacity, size_t size);

#endif
