/* SPDX-License-Identifier: Apache-2.0 */
/* The clocks that the signals of one semaphore carry, sorted by value. Guarded by the lock of the
 * struct execution_order that owns it.
 *
 * A binary semaphore is treated as a timeline semaphore: its signals are numbered, and a wait waits
 * for the number of the last signal. If no signal is outstanding, the wait orders nothing.
 *
 * A signal is announced before the call that submits it goes down. It gets its clock when all work
 * before it is resolved. It is published when the call has succeeded; before that, only its own
 * submission uses the clock. A signal is dropped when the host has observed all work that its clock
 * covers, because every later submission follows that work anyway. The oldest signals are also
 * dropped if there are too many; a wait for such an old value orders nothing. */
#ifndef ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H
#define ASSAY_STATE_ORDER_SEMAPHORE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "src/state/order/clock.h"

enum { SEMAPHORE_SIGNALS = 32 }; /* kept signals; unpublished ones may exceed this limit */

struct semaphore_signal {
    uint64_t value;
    const void *owner; /* the submission that announced it; NULL: published */
    bool has_clock;
    struct execution_clock clock;
};

struct semaphore_clock {
    uint64_t id; /* unique within the device, though the handle may be reused */
    bool timeline;
    bool foreign;     /* operations that the layer does not intercept may signal it */
    uint64_t initial; /* timeline: its value from the start */
    uint64_t reached; /* a wait for this value or less has ended and orders nothing */

    uint64_t seen; /* the host has observed this value or a larger one */

    uint64_t last_signal, last_wait; /* binary semaphore: numbers */

    struct semaphore_signal *signals; /* sorted by value */
    uint32_t count, capacity;
};

enum semaphore_wait_status {
    SEMAPHORE_REACHED, /* the wait follows the clock, if there is one */
    SEMAPHORE_NOT_YET, /* the signal that ends the wait is not announced or not published */
    SEMAPHORE_OPEN,    /* an untracked signal may end the wait: work before it is unknown */
};

/* Returns the status of a wait for `value` by the submission `owner`, whose own unpublished signals
 * count. `clock` is the clock that the wait follows, or NULL; it lives until the signals change. */
enum semaphore_wait_status semaphore_clock_wait(const struct semaphore_clock *semaphore,
                                                uint64_t value, const void *owner,
                                                const struct execution_clock **clock);

/* Returns false if memory runs out. */
bool semaphore_clock_announce(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_set(struct semaphore_clock *semaphore, uint64_t value, const void *owner,
                         const struct execution_clock *clock);
void semaphore_clock_publish(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_retract(struct semaphore_clock *semaphore, uint64_t value, const void *owner);

/* Drops the signals of `value` and less: no later wait needs them. */
void semaphore_clock_forget(struct semaphore_clock *semaphore, uint64_t value);

/* The host has observed that the semaphore's value is `value` (`exact`), or at least `value`. Call
 * semaphore_clock_catch_up next. If no announced signal explains the value, the semaphore becomes
 * foreign. */
void semaphore_clock_observe(struct semaphore_clock *semaphore, uint64_t value, bool exact);

/* Joins `host` with the clocks of the published signals that the host has observed. Returns false
 * if one of the observed signals is not published. */
bool semaphore_clock_catch_up(struct semaphore_clock *semaphore, struct execution_clock *host);

/* Drops leading signals whose clocks `host` covers. */
void semaphore_clock_prune(struct semaphore_clock *semaphore, const struct execution_clock *host);

void semaphore_clock_release(struct semaphore_clock *semaphore);

#endif
