/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer does not know from now on: memory ran out for a record, or the application did
 * what the layer does not track. docs/unknown.md has the rule: what is unknown is silent, never a
 * finding; it stays so; and the summary says once what is silent, behind "Not checked:".
 *
 * Takes no lock and allocates nothing. Any thread may ask. */
#ifndef ASSAY_BASE_UNKNOWN_H
#define ASSAY_BASE_UNKNOWN_H

#include <stdbool.h>
#include <stdint.h>

/* What becomes silent. */
enum unknown_what {
#define UNKNOWN(what, text) UNKNOWN_##what,
#include "src/base/unknown.def"
#undef UNKNOWN
    UNKNOWN_WHATS,
};

/* Zero-initialized: nothing is unknown. Setting it to zeros again forgets what was unknown. */
struct unknown {
    bool is_set;
};

static inline bool unknown_is_set(const struct unknown *unknown)
{
    return __atomic_load_n(&unknown->is_set, __ATOMIC_ACQUIRE);
}

/* Counts for the summary unless it was set. */
void unknown_set(struct unknown *unknown, enum unknown_what what);

/* Sets it if `cause` is, which was counted. */
static inline void unknown_follow(struct unknown *unknown, bool cause)
{
    if (cause)
        __atomic_store_n(&unknown->is_set, true, __ATOMIC_RELEASE);
}

/* For the summary: what is silent, as static text; and how often that was counted in this process
 * since the last call. */
const char *unknown_text(enum unknown_what what);
uint32_t unknown_take_count(enum unknown_what what);

#endif
