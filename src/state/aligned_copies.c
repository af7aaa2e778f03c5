/* SPDX-License-Identifier: Apache-2.0 */
/* A list of blocks. */
#include "src/state/aligned_copies.h"

#include <stdlib.h>
#include <string.h>

struct aligned_copy {
    struct aligned_copy *next;
    _Alignas(max_align_t) char bytes[];
};

void *aligned_copies_take(struct aligned_copies *copies, const void *from, size_t size)
{
    struct aligned_copy *copy = malloc(sizeof(*copy) + size);
    if (!copy)
        return NULL;
    memcpy(copy->bytes, from, size);
    copy->next = copies->first;
    copies->first = copy;
    return copy->bytes;
}

void aligned_copies_release(struct aligned_copies *copies)
{
    while (copies->first) {
        struct aligned_copy *copy = copies->first;
        copies->first = copy->next;
        free(copy);
    }
}
