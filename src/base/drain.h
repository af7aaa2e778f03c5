/* SPDX-License-Identifier: Apache-2.0 */
/* Work that one thread at a time does, in order, for all threads. A thread that finds another one
 * at work leaves it a note and goes on; the thread at work then looks once more.
 *
 * The owner's lock guards the struct, and is held during all calls. It is released during the work:
 *
 *     lock
 *     if (drain_begin(&drain))
 *         do {
 *             all that is ready: unlock, work, lock
 *         } while (drain_repeat(&drain));
 *     unlock
 */
#ifndef ASSAY_BASE_DRAIN_H
#define ASSAY_BASE_DRAIN_H

#include <stdbool.h>

/* Zero-initialized is idle. */
struct drain {
    bool is_busy; /* a thread works */
    bool again;   /* another thread has asked for work meanwhile */
};

/* Whether this thread is to work. If not, the thread at work repeats. */
static inline bool drain_begin(struct drain *drain)
{
    bool is_free = !drain->is_busy;
    drain->again = !is_free;
    drain->is_busy = true;
    return is_free;
}

/* Whether this thread is to look once more. If not, its work has ended. */
static inline bool drain_repeat(struct drain *drain)
{
    drain->is_busy = drain->again;
    drain->again = false;
    return drain->is_busy;
}

/* Ends the work of a thread that begins again before it releases the lock. */
static inline void drain_end(struct drain *drain)
{
    drain->is_busy = drain->again = false;
}

#endif
