/* SPDX-License-Identifier: Apache-2.0 */
/* The signals of one semaphore. */
#include "src/state/order/records.h"

#include <stdlib.h>

#include "src/base/array.h"

/* Returns the index of the first signal of at least `value`. */
static uint32_t first_at(const struct semaphore_clock *semaphore, uint64_t value)
{
    uint32_t i = semaphore->count; /* nearly always the last one */
    while (i && semaphore->signals[i - 1].value >= value)
        i--;
    return i;
}

enum semaphore_wait_status semaphore_clock_wait(const struct semaphore_clock *semaphore,
                                                uint64_t value, const void *owner,
                                                const struct semaphore_signal **signal)
{
    const bool is_over = value <= semaphore->reached;
    *signal = NULL;
    if (semaphore->foreign)
        return is_over || value <= semaphore->seen ? SEMAPHORE_REACHED : SEMAPHORE_OPEN;
    if (value <= semaphore->met && (value || semaphore->timeline))
        return SEMAPHORE_MET;
    if (is_over)
        return SEMAPHORE_REACHED;
    uint32_t i = first_at(semaphore, value);
    if (i == semaphore->count)
        return SEMAPHORE_NOT_YET;
    *signal = &semaphore->signals[i];
    bool is_usable = !(*signal)->owner || ((*signal)->owner == owner && (*signal)->has_clock);
    return is_usable ? SEMAPHORE_REACHED : SEMAPHORE_NOT_YET;
}

static void drop_first(struct semaphore_clock *semaphore, uint32_t count)
{
    if (!count)
        return;
    if (semaphore->reached < semaphore->signals[count - 1].value)
        semaphore->reached = semaphore->signals[count - 1].value;
    semaphore->count -= count;
    memmove(semaphore->signals, semaphore->signals + count,
            semaphore->count * sizeof(semaphore->signals[0]));
}

/* An unpublished signal may still be retracted, so it and all later signals stay. */
static void drop_old(struct semaphore_clock *semaphore)
{
    uint32_t i = 0;
    while (i < semaphore->count && i < SEMAPHORE_SIGNALS / 2 && !semaphore->signals[i].owner)
        i++;
    drop_first(semaphore, i);
}

static bool reserve_operation(struct semaphore_clock *semaphore)
{
    if (semaphore->count >= SEMAPHORE_SIGNALS)
        drop_old(semaphore);
    return ARRAY_HAS_ROOM(semaphore->signals, semaphore->count, semaphore->capacity);
}

bool semaphore_clock_announce(struct semaphore_clock *semaphore, uint64_t value, uint64_t number,
                              const void *owner)
{
    if (semaphore->foreign || value <= semaphore->reached)
        return true;
    if (!reserve_operation(semaphore))
        return false;
    uint32_t at = semaphore->count; /* signals nearly always come in order of their values */
    while (at && semaphore->signals[at - 1].value > value)
        at--;
    struct semaphore_signal *signal = &semaphore->signals[at];
    memmove(signal + 1, signal, (semaphore->count - at) * sizeof(*signal));
    signal->value = value;
    signal->number = number;
    signal->owner = owner;
    signal->has_clock = false;
    semaphore->count++;
    return true;
}

static struct semaphore_signal *find_own(struct semaphore_clock *semaphore, uint64_t value,
                                         const void *owner)
{
    for (uint32_t i = first_at(semaphore, value);
         i < semaphore->count && semaphore->signals[i].value == value; i++)
        if (semaphore->signals[i].owner == owner)
            return &semaphore->signals[i];
    return NULL;
}

uint64_t semaphore_clock_set(struct semaphore_clock *semaphore, uint64_t value, const void *owner,
                             const struct execution_clock *clock,
                             const struct execution_clock *behind, struct timestamp timestamp)
{
    struct semaphore_signal *signal = find_own(semaphore, value, owner);
    if (!signal)
        return 0;
    execution_clock_copy(&signal->clock, clock);
    execution_clock_copy(&signal->behind, behind);
    signal->has_clock = true;
    signal->timestamp = timestamp;
    for (uint32_t i = (uint32_t)(signal - semaphore->signals); i--;)
        if (semaphore->signals[i].has_clock)
            return semaphore->signals[i].number;
    return 0;
}

void semaphore_clock_publish(struct semaphore_clock *semaphore, uint64_t value, const void *owner)
{
    struct semaphore_signal *signal = find_own(semaphore, value, owner);
    if (signal)
        signal->owner = NULL;
}

void semaphore_clock_retract(struct semaphore_clock *semaphore, uint64_t value, const void *owner)
{
    struct semaphore_signal *signal = find_own(semaphore, value, owner);
    if (!signal)
        return;
    semaphore->count--;
    size_t at = (size_t)(signal - semaphore->signals);
    memmove(signal, signal + 1, (semaphore->count - at) * sizeof(*signal));
}

void semaphore_clock_observe(struct semaphore_clock *semaphore, uint64_t value, bool exact)
{
    if (value > semaphore->reached) {
        uint32_t i = first_at(semaphore, value);
        if (i == semaphore->count || (exact && semaphore->signals[i].value != value))
            semaphore->foreign = true;
        else
            value = semaphore->signals[i].value;
    }
    if (semaphore->seen < value)
        semaphore->seen = value;
}

bool semaphore_clock_catch_up(struct semaphore_clock *semaphore, struct execution_clock *host,
                              struct execution_clock *maybe)
{
    bool all_published = true;
    for (uint32_t i = 0; i < semaphore->count && semaphore->signals[i].value <= semaphore->seen;
         i++) {
        const struct semaphore_signal *signal = &semaphore->signals[i];
        if (signal->owner) {
            all_published = false;
            continue;
        }
        execution_clock_join(host, &signal->clock);
        execution_clock_join(maybe, &signal->behind);
    }
    return all_published;
}

static bool is_observed(const struct semaphore_clock *semaphore,
                        const struct semaphore_signal *signal, const struct execution_clock *host)
{
    return !signal->owner &&
           (signal->value <= semaphore->seen || execution_clock_has(host, signal->timestamp)) &&
           execution_clock_covers(host, &signal->clock);
}

void semaphore_clock_prune(struct semaphore_clock *semaphore, const struct execution_clock *host)
{
    uint32_t i = 0;
    while (i < semaphore->count && is_observed(semaphore, &semaphore->signals[i], host))
        i++;
    drop_first(semaphore, i);
    if (i)
        semaphore->met = semaphore->reached;
}

void semaphore_clock_release(struct semaphore_clock *semaphore)
{
    free(semaphore->signals);
    semaphore->signals = NULL;
    semaphore->count = semaphore->capacity = 0;
}
