/* SPDX-License-Identifier: Apache-2.0 */
/* The table of events, and which queue or host call set or reset each of them last. */
#include "src/state/commands/events.h"

#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/platform/threads.h"
#include "src/state/commands/journal.h"

struct event {
    bool device_only; /* the host can't set it */
    bool is_set;
    VkQueue queue; /* the last queue that set or reset it; null: the host did */
};

struct events {
    pthread_mutex_t lock;
    struct handle_table by_handle;
};

VkResult events_create(struct events **events)
{
    *events = calloc(1, sizeof(**events));
    if (!*events)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*events)->lock, NULL);
    return VK_SUCCESS;
}

void events_destroy(struct events *events)
{
    if (!events)
        return;
    handle_table_drop(&events->by_handle, free);
    pthread_mutex_destroy(&events->lock);
    free(events);
}

static uint64_t key_of(VkEvent handle)
{
    return handle_number(handle);
}

void events_add(struct events *events, VkEvent handle, bool device_only)
{
    struct event *event = calloc(1, sizeof(*event));
    pthread_mutex_lock(&events->lock);
    free(handle_table_remove(&events->by_handle, key_of(handle)));
    if (event && handle_table_set(&events->by_handle, key_of(handle), event))
        event->device_only = device_only;
    else
        free(event);
    pthread_mutex_unlock(&events->lock);
}

void events_remove(struct events *events, VkEvent handle)
{
    pthread_mutex_lock(&events->lock);
    free(handle_table_remove(&events->by_handle, key_of(handle)));
    pthread_mutex_unlock(&events->lock);
}

/* ---- setting and resetting */

static void note_event_state(const struct events *events, uint64_t handle, bool is_set,
                             VkQueue queue)
{
    struct event *event = handle_table_find(&events->by_handle, handle);
    if (!event)
        return;
    event->is_set = is_set;
    event->queue = queue;
}

/* If a submitted command resets the event, it may execute after this host call: the event then
 * stays unset. */
static void note_by_host(struct events *events, VkEvent handle, bool is_set)
{
    pthread_mutex_lock(&events->lock);
    const struct event *event = handle_table_find(&events->by_handle, key_of(handle));
    if (event && (event->is_set || !event->queue))
        note_event_state(events, key_of(handle), is_set, VK_NULL_HANDLE);
    pthread_mutex_unlock(&events->lock);
}

void events_set(struct events *events, VkEvent handle)
{
    note_by_host(events, handle, true);
}

void events_reset(struct events *events, VkEvent handle)
{
    note_by_host(events, handle, false);
}

bool events_is_set_by_host(struct events *events, VkEvent handle)
{
    pthread_mutex_lock(&events->lock);
    const struct event *event = handle_table_find(&events->by_handle, key_of(handle));
    const bool is_set = event && event->is_set && !event->queue;
    pthread_mutex_unlock(&events->lock);
    return is_set;
}

static void forget_state(void *record, void *context)
{
    struct event *event = record;
    (void)context;
    event->is_set = false;
}

void events_forget(struct events *events)
{
    pthread_mutex_lock(&events->lock);
    handle_table_each(&events->by_handle, forget_state, NULL);
    pthread_mutex_unlock(&events->lock);
}

/* ---- waits */

struct event_search {
    uint64_t handle;
    enum tristate is_set;
};

static void search_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (entry->secondary->has_events)
        journal_walk_secondary(walk, entry);
}

static void search_use(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct event_search *search = walk->user;
    if (entry->dst == search->handle && entry->info != EVENT_WAIT)
        search->is_set = entry->info == EVENT_SET ? YES : NO;
}

/* Returns YES if the event is set after the journal, NO if the journal resets it. */
static enum tristate is_set_by(const struct journal *journal, uint64_t handle)
{
    static const struct journal_events changes = {.execute = search_secondary,
                                                  .use_event = search_use};
    struct event_search search = {handle, UNKNOWN};
    journal_walk(journal, &changes, &search);
    return search.is_set;
}

bool events_may_be_open(struct events *events, VkEvent handle, const struct journal *journal)
{
    if (journal->has_events && is_set_by(journal, key_of(handle)) == YES)
        return false;
    pthread_mutex_lock(&events->lock);
    const struct event *event = handle_table_find(&events->by_handle, key_of(handle));
    bool device_only = event && event->device_only;
    pthread_mutex_unlock(&events->lock);
    return !device_only;
}

static bool is_open(const struct events *events, VkQueue queue, uint64_t handle)
{
    const struct event *event = handle_table_find(&events->by_handle, handle);
    return !event || !event->is_set || (event->queue && event->queue != queue);
}

struct event_submission {
    const struct events *events;
    VkQueue queue;
    bool is_open;
};

static void submit_use(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct event_submission *submission = walk->user;
    if (entry->info == EVENT_WAIT)
        submission->is_open |= is_open(submission->events, submission->queue, entry->dst);
    else
        note_event_state(submission->events, entry->dst, entry->info == EVENT_SET,
                         submission->queue);
}

bool events_submit(struct events *events, VkQueue queue, const struct journal *journal)
{
    static const struct journal_events uses = {.execute = search_secondary,
                                               .use_event = submit_use};
    struct event_submission submission = {events, queue, false};
    if (!journal->has_events)
        return false;
    pthread_mutex_lock(&events->lock);
    journal_walk(journal, &uses, &submission);
    pthread_mutex_unlock(&events->lock);
    return submission.is_open;
}
