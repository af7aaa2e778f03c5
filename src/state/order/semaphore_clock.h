/* SPDX-License-Identifier: Apache-2.0 */
/* What one semaphore tells about order: the clocks that its signals carry, by value. Not locked:
 * its owner is.
 *
 * A binary semaphore is treated as a timeline one: its signals are numbered, and a wait waits for
 * the number of the last signal, or for nothing if none is outstanding that the layer knows of.
 *
 * A signal is announced before the call that submits it goes down, has a clock when all that comes
 * before it is known, and is published when the call has succeeded; only then do others see the
 * clock. It is kept until the host has seen all that it carries, because every later submission
 * follows that anyway; or until there are too many, when a wait for an old value brings no order.
 */
#ifndef ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H
#define ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "src/state/order/clock.h"

enum { SEMAPHORE_SIGNALS = 32 }; /* that are kept, and those that are not published */

struct semaphore_signal {
    uint64_t value;
    const void *owner; /* who announced it; NULL: published */
    bool has_clock;
    struct execution_clock clock;
};

struct semaphore_clock {
    uint64_t id; /* no other semaphore's of the device, though the handle may be reused */
    bool timeline;
    bool foreign;     /* may be signalled by what the layer doesn't see */
    uint64_t reached; /* a wait for it or less is over, and brings no order */

    uint64_t seen; /* the host has seen it, or more */

    uint64_t last_signal, last_wait; /* numbers, of a binary semaphore */

    struct semaphore_signal *signals; /* by value */
    uint32_t count, capacity;
};

enum semaphore_answer {
    SEMAPHORE_REACHED, /* and the clock, if there is one, is what the wait follows */
    SEMAPHORE_NOT_YET, /* the signal that ends the wait is not announced or not published */
    SEMAPHORE_OPEN,    /* something else may end the wait: what comes before it is not known */
};

/* What a wait for `value` leads to, for `owner`, who also sees its own unpublished signals. */
enum semaphore_answer semaphore_clock_wait(const struct semaphore_clock *semaphore, uint64_t value,
                                           const void *owner, const struct execution_clock **clock);

/* False without memory. */
bool semaphore_clock_announce(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_set(struct semaphore_clock *semaphore, uint64_t value, const void *owner,
                         const struct execution_clock *clock);
void semaphore_clock_publish(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_retract(struct semaphore_clock *semaphore, uint64_t value, const void *owner);

/* Nobody will wait for `value` or less again. */
void semaphore_clock_forget(struct semaphore_clock *semaphore, uint64_t value);

/* The host has seen the value, or (`exact` false) that it is at least that. To be followed by
 * semaphore_clock_catch_up. A value that no announced signal explains makes the semaphore foreign.
 */
void semaphore_clock_observe(struct semaphore_clock *semaphore, uint64_t value, bool exact);

/* Joins the host's clock with the published signals that the host knows to have executed. Returns
 * false if there is one that isn't published. */
bool semaphore_clock_catch_up(struct semaphore_clock *semaphore, struct execution_clock *host);

/* Drops the signals that tell nothing beyond the host's clock. */
void semaphore_clock_prune(struct semaphore_clock *semaphore, const struct execution_clock *host);

void semaphore_clock_release(struct semaphore_clock *semaphore);

#endif
