/* SPDX-License-Identifier: Apache-2.0 */
/* Answers, for a past execution point, whether a structure was built so that instances may disable
 * its micromaps. An answer is known as long as the flag hasn't changed since that point. Takes its
 * own lock and calls nothing while it is locked. */
#ifndef ASSAY_STATE_BUILDS_BUILT_FLAGS_H
#define ASSAY_STATE_BUILDS_BUILT_FLAGS_H

#include "src/state/builds/built.h"
#include "src/state/order/clock.h"

struct built_flags;

/* When a build executed, and the work that executed before it. */
struct execution_point {
    uint64_t serial;
    struct timestamp now;
    bool is_unordered; /* the commands of its batch are unordered among themselves */
    struct execution_clock follows;
};

struct built_flags *built_flags_create(void);        /* NULL if there is no memory */
void built_flags_destroy(struct built_flags *flags); /* no effect if `flags` is NULL, also below */

/* Records a write of the structure `id` at the timestamp `written`, and gives the write the next
 * serial. */
void built_flags_write(struct built_flags *flags, uint64_t id, const struct built *built,
                       struct timestamp written);
/* The flag of one structure, or of all, is unknown until it is written again. */
void built_flags_forget(struct built_flags *flags, uint64_t id);
void built_flags_forget_all(struct built_flags *flags);

/* Returns the current serial. `flags` must not be NULL. */
uint64_t built_flags_now(struct built_flags *flags);
/* Returns whether the structure allowed instances to disable micromaps at an execution point.
 * UNKNOWN if `point` is NULL. */
enum tristate built_flags_allow_disabling(struct built_flags *flags, uint64_t id,
                                          const struct execution_point *point);

#endif
