/* SPDX-License-Identifier: Apache-2.0 */
#include "src/base/unknown.h"

#include <stdatomic.h>

/* The counts are those of the process, because most modules know no instance. */
static atomic_uint counts[UNKNOWN_WHATS];

void unknown_set(struct unknown *unknown, enum unknown_what what)
{
    if (!__atomic_exchange_n(&unknown->is_set, true, __ATOMIC_ACQ_REL))
        atomic_fetch_add(&counts[what], 1);
}

const char *unknown_text(enum unknown_what what)
{
    static const char *const texts[] = {
#define UNKNOWN(what, text) text,
#include "src/base/unknown.def"
#undef UNKNOWN
    };
    return texts[what];
}

uint32_t unknown_take_count(enum unknown_what what)
{
    return atomic_exchange(&counts[what], 0);
}
