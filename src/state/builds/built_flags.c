/* SPDX-License-Identifier: Apache-2.0 */
/* The flags that structures were built with, and the serials of the writes. */
#include "src/state/builds/built_flags.h"

#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/platform/threads.h"

/* Written at `written` with serial `since`; every later write had the same flag. */
struct flagged {
    bool allows;
    uint64_t since;
    struct timestamp written;
};

struct built_flags {
    pthread_mutex_t lock; /* guards the other members */
    struct handle_table by_id;
    uint64_t serial;
};

struct built_flags *built_flags_create(void)
{
    struct built_flags *flags = calloc(1, sizeof(*flags));
    if (flags)
        pthread_mutex_init(&flags->lock, NULL);
    return flags;
}

static void free_flagged(void *record, void *context)
{
    (void)context;
    free(record);
}

static void release_all(struct built_flags *flags)
{
    handle_table_each(&flags->by_id, free_flagged, NULL);
    handle_table_release(&flags->by_id);
}

void built_flags_destroy(struct built_flags *flags)
{
    if (!flags)
        return;
    release_all(flags);
    pthread_mutex_destroy(&flags->lock);
    free(flags);
}

void built_flags_forget_all(struct built_flags *flags)
{
    if (!flags)
        return;
    pthread_mutex_lock(&flags->lock);
    release_all(flags);
    pthread_mutex_unlock(&flags->lock);
}

void built_flags_forget(struct built_flags *flags, uint64_t id)
{
    if (!flags || !id)
        return;
    pthread_mutex_lock(&flags->lock);
    free(handle_table_remove(&flags->by_id, id));
    pthread_mutex_unlock(&flags->lock);
}

/* If there is no memory, the flag stays unknown. */
static void set(struct built_flags *flags, uint64_t id, const struct flagged *flagged)
{
    struct flagged *existing = handle_table_find(&flags->by_id, id);
    if (existing) {
        if (existing->allows != flagged->allows)
            *existing = *flagged;
        return;
    }
    existing = malloc(sizeof(*existing));
    if (!existing)
        return;
    *existing = *flagged;
    if (!handle_table_set(&flags->by_id, id, existing))
        free(existing);
}

void built_flags_write(struct built_flags *flags, uint64_t id, const struct built *built,
                       struct timestamp written)
{
    if (!flags || !id)
        return;
    pthread_mutex_lock(&flags->lock);
    const struct flagged flagged = {
        .allows =
            built->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR,
        .since = ++flags->serial,
        .written = written};
    if (built->state == BUILT_BEFORE)
        set(flags, id, &flagged);
    else
        free(handle_table_remove(&flags->by_id, id));
    pthread_mutex_unlock(&flags->lock);
}

uint64_t built_flags_now(struct built_flags *flags)
{
    pthread_mutex_lock(&flags->lock);
    uint64_t serial = flags->serial;
    pthread_mutex_unlock(&flags->lock);
    return serial;
}

static bool came_before(const struct flagged *flagged, const struct execution_point *point)
{
    struct timestamp written = flagged->written;
    bool is_own = written.queue == point->now.queue && written.count == point->now.count;
    return flagged->since <= point->serial &&
           ((is_own && !point->is_unordered) || execution_clock_has(&point->follows, written));
}

enum tristate built_flags_allow_disabling(struct built_flags *flags, uint64_t id,
                                          const struct execution_point *point)
{
    if (!flags || !id || !point)
        return UNKNOWN;
    pthread_mutex_lock(&flags->lock);
    const struct flagged *flagged = handle_table_find(&flags->by_id, id);
    enum tristate allows = UNKNOWN;
    if (flagged && came_before(flagged, point))
        allows = flagged->allows ? YES : NO;
    pthread_mutex_unlock(&flags->lock);
    return allows;
}
