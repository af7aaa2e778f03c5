/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow. */
#include "src/base/array.h"

#include <stdlib.h>

enum { FIRST_CAPACITY = 4 };

void *array_make_room(void *items, uint32_t count, uint32_t *capacity, size_t size)
{
    if (count < *capacity)
        return items;
    if (*capacity > UINT32_MAX / 2)
        return NULL;
    uint32_t larger = *capacity ? *capacity * 2 : FIRST_CAPACITY;
    void *moved = realloc(items, larger * size);
    if (moved)
        *capacity = larger;
    return moved;
}
