/* SPDX-License-Identifier: Apache-2.0 */
/* Whether structures were built so that instances may disable their micromaps, told of any turn in
 * the order of execution for as long as that hasn't changed since: for who learns only later what a
 * build has read. Locks itself; nothing is called under the lock. */
#ifndef ASSAY_STATE_BUILDS_BUILT_FLAGS_H
#define ASSAY_STATE_BUILDS_BUILT_FLAGS_H

#include "src/state/builds/built.h"
#include "src/state/order/clock.h"

struct built_flags;

/* When a build executed, and what came before it. */
struct execution_point {
    uint64_t serial;
    struct timestamp now;
    bool is_unordered; /* what its batch does has no order in itself */
    struct execution_clock follows;
};

struct built_flags *built_flags_create(void);        /* NULL without memory */
void built_flags_destroy(struct built_flags *flags); /* NULL: nothing, here and below */

/* The structure of that id was written at that moment, and the turn it was. */
void built_flags_write(struct built_flags *flags, uint64_t id, const struct built *built,
                       struct timestamp written);
/* Nothing is known of it, or of any, until it is written again. */
void built_flags_forget(struct built_flags *flags, uint64_t id);
void built_flags_forget_all(struct built_flags *flags);

/* The turn of what executes now. */
uint64_t built_flags_now(struct built_flags *flags);
/* Whether the structure, as a build at that turn found it, lets instances disable micromaps. */
enum tristate built_flags_allow_disabling(struct built_flags *flags, uint64_t id,
                                          const struct execution_point *serial);

#endif
