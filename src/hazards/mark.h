/* SPDX-License-Identifier: Apache-2.0 */
/* A mark: the number, queue and kind of an access in one word. 0 is no mark: numbers begin at 1.
 * Among marks of the same queue and kind, the greater one is the later access. */
#ifndef ASSAY_HAZARDS_MARK_H
#define ASSAY_HAZARDS_MARK_H

#include <stdbool.h>
#include <stdint.h>

#include "src/hazards/hazards.h"

typedef uint64_t access_mark; /* 54 bits of number, 5 of queue, 5 of kind */

_Static_assert(HAZARD_QUEUES <= 32 && ACCESS_KINDS <= 32, "both have 5 bits");

static inline access_mark mark_of(uint64_t number, uint32_t queue, enum access_kind kind)
{
    return number << 10 | queue << 5 | kind;
}

static inline uint64_t mark_number(access_mark mark)
{
    return mark >> 10;
}

static inline uint32_t mark_queue(access_mark mark)
{
    return mark >> 5 & 31;
}

static inline enum access_kind mark_kind(access_mark mark)
{
    return (enum access_kind)(mark & 31);
}

static inline bool marks_have_same_source(access_mark a, access_mark b)
{
    return ((a ^ b) & 1023) == 0;
}

#endif
