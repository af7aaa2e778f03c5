/* SPDX-License-Identifier: Apache-2.0 */
/* Executions whose contents wait: from their turn until they are complete. */
#include "layer/execution/contents.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "layer/snapshots/tell.h"

/* Of a batch that was replayed, and hasn't run. */
struct noted_batch {
    struct noted_batch *next;
    struct moment moment;
    uint32_t count;
    struct content_notes commands[];
};

struct waiting {
    struct waiting *next;
    struct ran_execution ran;
    struct moment moment;
};

struct contents {
    struct layer_device *device;
    struct noted_batch *noted, **noted_last; /* for the hooks */

    /* Guards the rest. Only who is busy takes executions off the list; no call or message is made
     * with the lock held. */
    pthread_mutex_t lock;
    struct waiting *waiting, **waiting_last; /* in the order of their turns */
    bool busy, again; /* somebody delivers; somebody else wanted to, meanwhile */
};

VkResult contents_create(struct layer_device *device)
{
    if (device->level < LEVEL_CONTENT || !device->snapshots)
        return VK_SUCCESS;
    struct contents *contents = calloc(1, sizeof(*contents));
    if (!contents)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    contents->device = device;
    contents->noted_last = &contents->noted;
    contents->waiting_last = &contents->waiting;
    pthread_mutex_init(&contents->lock, NULL);
    device->contents = contents;
    return VK_SUCCESS;
}

/* Whoever waits to compare with what was to be filled learns that it never will be. */
static void tell_notes(const struct content_notes *notes)
{
    for (uint32_t i = 0; i < notes->count; i++)
        build_contents_tell(notes->items[i].contents);
}

static void free_waiting(struct waiting *waiting)
{
    tell_notes(&waiting->ran.notes);
    content_notes_release(&waiting->ran.notes);
    execution_release(waiting->ran.execution);
    journal_release(waiting->ran.journal);
    free(waiting);
}

void contents_destroy(struct contents *contents)
{
    if (!contents)
        return;
    contents_drop(contents);
    while (contents->waiting) {
        struct waiting *first = contents->waiting;
        contents->waiting = first->next;
        free_waiting(first);
    }
    pthread_mutex_destroy(&contents->lock);
    free(contents);
}

/* ---- batches */

struct content_notes *contents_note_batch(struct contents *contents, const struct batch_run *run)
{
    if (!contents)
        return NULL;
    size_t size = run->command_count * sizeof(struct content_notes);
    struct noted_batch *batch = calloc(1, sizeof(*batch) + size);
    if (!batch)
        return NULL;
    batch->moment = run->moment;
    batch->count = run->command_count;
    *contents->noted_last = batch;
    contents->noted_last = &batch->next;
    return batch->commands;
}

static void drop_first(struct contents *contents)
{
    struct noted_batch *batch = contents->noted;
    contents->noted = batch->next;
    if (!contents->noted)
        contents->noted_last = &contents->noted;
    for (uint32_t i = 0; i < batch->count; i++) {
        tell_notes(&batch->commands[i]);
        content_notes_release(&batch->commands[i]);
    }
    free(batch);
}

void contents_drop(struct contents *contents)
{
    while (contents && contents->noted)
        drop_first(contents);
}

static bool is_of(const struct noted_batch *batch, const struct batch_run *run)
{
    return batch && batch->moment.queue == run->moment.queue &&
           batch->moment.count == run->moment.count;
}

void contents_run(struct contents *contents, const struct batch_run *run, uint32_t command,
                  struct execution *execution)
{
    struct waiting *waiting = contents ? calloc(1, sizeof(*waiting)) : NULL;
    if (contents && !waiting)
        tell_missed(contents->device, &(struct missed_executions){.unkept = 1});
    if (!waiting)
        return;
    waiting->moment = run->moment;
    waiting->ran = (struct ran_execution){
        .device = contents->device,
        .execution = execution_share(execution),
        .journal = journal_share(run->commands[command].captured),
        .queue = run->queue,
    };
    if (is_of(contents->noted, run)) {
        waiting->ran.notes = contents->noted->commands[command];
        contents->noted->commands[command] = (struct content_notes){0};
    }
    for (uint32_t i = 0; i < waiting->ran.notes.count; i++)
        if (waiting->ran.notes.items[i].contents)
            waiting->ran.notes.items[i].contents->filler = waiting;
    pthread_mutex_lock(&contents->lock);
    *contents->waiting_last = waiting;
    contents->waiting_last = &waiting->next;
    pthread_mutex_unlock(&contents->lock);
}

void contents_end_batch(struct contents *contents, const struct batch_run *run)
{
    if (contents && is_of(contents->noted, run))
        drop_first(contents);
}

/* ---- delivery */

/* A walk over the executions that wait. */
struct delivery {
    struct execution_clock seen;
    uint64_t busy_queues; /* by index: whose later batches aren't complete, either, or come so late
                             that nobody waits again */
};
_Static_assert(EXECUTION_QUEUES <= 64, "each queue has a bit");

/* False where nothing more will be known of the execution, either. */
static bool is_complete(struct delivery *delivery, const struct waiting *waiting)
{
    struct ticket *ticket = waiting->ran.execution->ticket;
    uint64_t queue = UINT64_C(1) << waiting->moment.queue;
    bool was_seen = execution_clock_has(&delivery->seen, waiting->moment);
    bool is_busy = delivery->busy_queues & queue;
    VkResult end;
    if (is_busy && !was_seen)
        return false;
    if (ticket_has_ended(ticket, was_seen && !is_busy, &end))
        return true;
    delivery->busy_queues |= queue;
    return false;
}

/* Whether the contents that its updates are compared with are known, or will be when it is read. */
static bool has_sources(const struct waiting *waiting)
{
    for (uint32_t i = 0; i < waiting->ran.notes.count; i++) {
        const struct build_contents *source = waiting->ran.notes.items[i].source.contents;
        if (source && source->filler != waiting && !atomic_load(&source->is_known))
            return false;
    }
    return true;
}

static struct waiting **next_of(struct contents *contents, struct waiting **link)
{
    pthread_mutex_lock(&contents->lock);
    link = *link ? &(*link)->next : link;
    pthread_mutex_unlock(&contents->lock);
    return link;
}

static struct waiting *at(struct contents *contents, struct waiting *const *link)
{
    pthread_mutex_lock(&contents->lock);
    struct waiting *waiting = *link;
    pthread_mutex_unlock(&contents->lock);
    return waiting;
}

static void take_off(struct contents *contents, struct waiting **link)
{
    pthread_mutex_lock(&contents->lock);
    struct waiting *waiting = *link;
    *link = waiting->next;
    if (!waiting->next)
        contents->waiting_last = link;
    pthread_mutex_unlock(&contents->lock);
}

/* In the order of their turns, but past those that are not complete: others of other queues may
 * be. */
static void deliver(struct contents *contents)
{
    struct delivery delivery = {0};
    struct missed_executions missed = {0};
    struct waiting **link = &contents->waiting;
    execution_order_host_clock(contents->device->order, &delivery.seen);
    for (struct waiting *waiting; (waiting = at(contents, link));) {
        if (!is_complete(&delivery, waiting) || !has_sources(waiting)) {
            link = next_of(contents, link);
            continue;
        }
        take_off(contents, link);
        contents_read(&waiting->ran, &missed);
        free_waiting(waiting);
    }
    tell_missed(contents->device, &missed);
}

/* Whether it is this thread's to deliver; not where there is nothing to be delivered. */
static bool begin_delivery(struct contents *contents)
{
    pthread_mutex_lock(&contents->lock);
    bool is_free = !contents->busy && contents->waiting;
    contents->again |= contents->busy;
    contents->busy |= is_free;
    pthread_mutex_unlock(&contents->lock);
    return is_free;
}

/* Whether there is more to deliver. */
static bool go_on(struct contents *contents)
{
    pthread_mutex_lock(&contents->lock);
    bool again = contents->again;
    contents->again = false;
    contents->busy = again;
    pthread_mutex_unlock(&contents->lock);
    return again;
}

void contents_deliver(struct contents *contents)
{
    if (!contents || !begin_delivery(contents))
        return;
    do {
        deliver(contents);
    } while (go_on(contents));
}

/* What had its turn waits for nothing that is still to be submitted; but another batch of its
 * submission may, or an event of the host's. */
enum { WAIT_NANOSECONDS = 1000 * 1000 * 1000, PAUSE_NANOSECONDS = 1000 * 1000 };

static bool waits_for(struct contents *contents, const struct ticket *ticket)
{
    pthread_mutex_lock(&contents->lock);
    bool waits = contents->waiting && contents->waiting->ran.execution->ticket == ticket;
    pthread_mutex_unlock(&contents->lock);
    return waits;
}

bool contents_wait(struct contents *contents)
{
    if (!contents)
        return false;
    pthread_mutex_lock(&contents->lock);
    struct ticket *ticket =
        contents->waiting ? ticket_share(contents->waiting->ran.execution->ticket) : NULL;
    pthread_mutex_unlock(&contents->lock);
    bool is_complete = ticket && ticket->wait(ticket, WAIT_NANOSECONDS) != VK_TIMEOUT;
    if (is_complete)
        contents_deliver(contents);
    if (is_complete && waits_for(contents, ticket))
        nanosleep(&(struct timespec){.tv_nsec = PAUSE_NANOSECONDS}, NULL); /* another delivers it */
    ticket_release(ticket);
    return is_complete;
}
