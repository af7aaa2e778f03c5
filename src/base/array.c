/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow. */
#include "src/base/array.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 4 };

bool array_has_room(void *items, uint32_t count, uint32_t *capacity, size_t size)
{
    void *moved;
    if (count < *capacity)
        return true;
    if (*capacity > UINT32_MAX / 2)
        return false;
    uint32_t larger = *capacity ? *capacity * 2 : FIRST_CAPACITY;
    memcpy(&moved, items, sizeof(moved));
    moved = realloc(moved, larger * size);
    if (!moved)
        return false;
    memcpy(items, &moved, sizeof(moved));
    *capacity = larger;
    return true;
}
