/* SPDX-License-Identifier: Apache-2.0 */
/* The clocks that the signals of one semaphore carry, sorted by value. Guarded by the lock of the
 * struct execution_order that owns it.
 *
 * A binary semaphore is treated as a timeline semaphore: the values of its signals are their
 * numbers, and a wait waits for the last one. If no signal is outstanding, what the wait follows is
 * unknown.
 *
 * A signal is announced before the call that submits it goes down. It gets its clock when all work
 * before it is resolved. It is published when the call has succeeded; before that, only its own
 * submission uses the clock. A signal is dropped when the host has observed it, because every later
 * submission follows it anyway. The oldest signals are also dropped if there are too many: what a
 * wait for such an old value follows is unknown. */
#ifndef ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H
#define ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "src/state/order/clock.h"

enum { SEMAPHORE_SIGNALS = 64 }; /* kept signals; unpublished ones may exceed this limit */

struct semaphore_signal {
    uint64_t value, number; /* see struct semaphore_operation */
    const void *owner;      /* the submission that announced it; NULL: published */
    bool has_clock;
    struct execution_clock clock;
    struct timestamp timestamp; /* of its batch */
};

struct semaphore_clock {
    uint64_t id; /* unique within the device, though the handle may be reused */
    bool timeline;
    bool foreign;     /* operations that the layer does not intercept may signal it */
    uint64_t initial; /* timeline: its value from the start */
    uint64_t reached; /* signals of this value or less were dropped, if there were any; */
    uint64_t met;     /* of this value or less, because the host had observed them */

    uint64_t seen; /* the host has observed this value or a larger one */

    uint64_t last_wait; /* binary semaphore: the last signal that was waited for */

    struct semaphore_signal *signals; /* sorted by value */
    uint32_t count, capacity;
};

enum semaphore_wait_status {
    SEMAPHORE_MET,     /* the wait orders nothing: see struct semaphore_operation */
    SEMAPHORE_REACHED, /* the wait follows the signal; NULL: it is unknown */
    SEMAPHORE_NOT_YET, /* the signal that ends the wait is not announced or not published */
    SEMAPHORE_OPEN,    /* an untracked signal may end the wait: work before it is unknown */
};

/* Returns the status of a wait for `value` by the submission `owner`, whose own unpublished signals
 * count. `signal` is the one with which the wait ends, or NULL; it lives until the signals change.
 */
enum semaphore_wait_status semaphore_clock_wait(const struct semaphore_clock *semaphore,
                                                uint64_t value, const void *owner,
                                                const struct semaphore_signal **signal);

/* Returns false if memory runs out. */
bool semaphore_clock_announce(struct semaphore_clock *semaphore, uint64_t value, uint64_t number,
                              const void *owner);
/* Gives a signal its clock. Returns the number of the one before, see struct semaphore_operation.
 */
uint64_t semaphore_clock_set(struct semaphore_clock *semaphore, uint64_t value, const void *owner,
                             const struct execution_clock *clock, struct timestamp timestamp);
void semaphore_clock_publish(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_retract(struct semaphore_clock *semaphore, uint64_t value, const void *owner);

/* The largest value that was announced, and not retracted. */
static inline uint64_t semaphore_clock_last(const struct semaphore_clock *semaphore)
{
    return semaphore->count ? semaphore->signals[semaphore->count - 1].value : semaphore->reached;
}

/* The host has observed that the semaphore's value is `value` (`exact`), or at least `value`. Call
 * semaphore_clock_catch_up next. If no announced signal explains the value, the semaphore becomes
 * foreign. */
void semaphore_clock_observe(struct semaphore_clock *semaphore, uint64_t value, bool exact);

/* Joins `host` with the clocks of the published signals that the host has observed. Returns false
 * if one of the observed signals is not published. */
bool semaphore_clock_catch_up(struct semaphore_clock *semaphore, struct execution_clock *host);

/* Drops leading signals if the host has observed their values or their batches. `host` covers what
 * the host has observed. */
void semaphore_clock_prune(struct semaphore_clock *semaphore, const struct execution_clock *host);

void semaphore_clock_release(struct semaphore_clock *semaphore);

#endif
