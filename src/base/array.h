/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow by one element at a time. The owner keeps the array, its count and its capacity,
 * all of which are zero at first, and frees the array. */
#ifndef ASSAY_BASE_ARRAY_H
#define ASSAY_BASE_ARRAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Makes room for one more element of `size` bytes. `items` is the address of the array's pointer,
 * which changes if the array moves. Returns false without memory: nothing changes then. */
bool array_has_room(void *items, uint32_t count, uint32_t *capacity, size_t size);

/* Whether there is room for one more element now. The arguments are variables. */
#define ARRAY_HAS_ROOM(items, count, capacity)                                                     \
    array_has_room(&(items), count, &(capacity), sizeof(*(items)))

#endif
