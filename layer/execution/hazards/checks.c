/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps batches in execution order until they can be judged. */
#include "layer/execution/hazards/checks.h"

#include <stdlib.h>

#include "layer/execution/hazards/judge.h"
#include "src/platform/threads.h"
#include "src/state/commands/journal.h"

struct hazard_checks {
    struct layer_device *device;

    /* Guards the list, its batches' members about references, and the flags. */
    pthread_mutex_t lock;
    struct hazard_batch_record *waiting, **waiting_last; /* in execution order */
    bool busy;    /* a thread judges; it alone uses `judge`, without the lock */
    bool stopped; /* no more batches come */
    bool missed;  /* a batch is missing, because memory ran out */
    struct hazard_judge judge;
};

/* ---- the list */

static bool is_ready(const struct hazard_checks *checks, const struct hazard_batch_record *batch)
{
    return checks->stopped || batch->ended || (batch->has_run && !batch->awaited);
}

/* Removes the first batch if all of its instances are known, or no more will be. Returns NULL if
 * this thread is to judge no more. */
static struct hazard_batch_record *take(struct hazard_checks *checks)
{
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = checks->waiting;
    if (batch && !is_ready(checks, batch))
        batch = NULL;
    if (batch)
        checks->waiting = batch->next;
    if (!checks->waiting)
        checks->waiting_last = &checks->waiting;
    checks->busy = batch != NULL;
    checks->judge.lost |= checks->missed;
    checks->missed = false;
    pthread_mutex_unlock(&checks->lock);
    return batch;
}

/* If another thread judges, it will see what has changed. */
static void judge_ready(struct hazard_checks *checks)
{
    pthread_mutex_lock(&checks->lock);
    bool is_free = !checks->busy;
    checks->busy = true;
    pthread_mutex_unlock(&checks->lock);
    if (!is_free)
        return;
    for (struct hazard_batch_record *batch; (batch = take(checks));)
        hazard_judge_batch(&checks->judge, batch);
}

/* Call with the lock. Returns NULL if the batch has no record. */
static struct hazard_batch_record *find(const struct hazard_checks *checks,
                                        struct timestamp timestamp)
{
    struct hazard_batch_record *batch = checks->waiting;
    while (batch && !timestamps_are_equal(batch->timestamp, timestamp))
        batch = batch->next;
    return batch;
}

/* Host work has a timestamp only at its end. If it failed, what it wrote is unknown. */
static bool concerns(const struct hazard_checks *checks, const struct batch_run *run)
{
    return checks && run->work != WORK_BEGINS && run->work != WORK_FAILS;
}

/* Call with the lock. */
static void append(struct hazard_checks *checks, struct hazard_batch_record *record)
{
    *checks->waiting_last = record;
    checks->waiting_last = &record->next;
}

void hazard_checks_add(struct hazard_checks *checks, const struct batch_run *run)
{
    if (!concerns(checks, run))
        return;
    struct hazard_batch_record *batch = hazard_batch_create(run);
    pthread_mutex_lock(&checks->lock);
    checks->missed |= !batch;
    if (batch)
        append(checks, batch);
    pthread_mutex_unlock(&checks->lock);
}

void hazard_checks_run(struct hazard_checks *checks, const struct batch_run *run)
{
    if (!concerns(checks, run))
        return;
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = find(checks, run->timestamp);
    if (batch)
        batch->has_run = true;
    pthread_mutex_unlock(&checks->lock);
    judge_ready(checks);
}

void hazard_checks_forget(struct hazard_checks *checks, enum hazard_end ended, uint64_t id)
{
    struct hazard_batch_record *end = checks && id ? hazard_batch_create_end(ended, id) : NULL;
    if (!end)
        return;
    pthread_mutex_lock(&checks->lock);
    append(checks, end);
    pthread_mutex_unlock(&checks->lock);
    judge_ready(checks);
}

void hazard_checks_stop(struct hazard_checks *checks)
{
    if (!checks)
        return;
    pthread_mutex_lock(&checks->lock);
    checks->stopped = true;
    pthread_mutex_unlock(&checks->lock);
    judge_ready(checks);
}

/* ---- references */

void hazard_checks_expect(struct hazard_checks *checks, struct timestamp timestamp)
{
    if (!checks)
        return;
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = find(checks, timestamp);
    if (batch && batch->has_references)
        batch->awaited++;
    pthread_mutex_unlock(&checks->lock);
}

void hazard_checks_refer(struct hazard_checks *checks, struct timestamp timestamp,
                         const struct journal *journal, uint32_t position,
                         const struct accel_facts *referenced)
{
    if (!checks || !referenced->memory)
        return;
    /* How much of the structure its last build needed is unknown: the first byte is certain. */
    const struct hazard_reference reference = {
        .place = {.journal = journal, .position = position},
        .structure = (uint64_t)(uintptr_t)referenced->handle,
        .bytes = {resources_find_memory_id(checks->device->resources, referenced->memory),
                  referenced->begin, referenced->begin + (referenced->size != 0)},
    };
    if (!reference.bytes.memory)
        return;
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = find(checks, timestamp);
    if (batch && batch->has_references && batch->awaited)
        hazard_batch_refer(batch, &reference);
    pthread_mutex_unlock(&checks->lock);
}

void hazard_checks_index(struct hazard_checks *checks, struct timestamp timestamp,
                         const struct hazard_indices *indices)
{
    if (!checks)
        return;
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = find(checks, timestamp);
    if (batch && batch->has_references && batch->awaited)
        hazard_batch_index(batch, indices);
    pthread_mutex_unlock(&checks->lock);
}

void hazard_checks_settle(struct hazard_checks *checks, struct timestamp timestamp)
{
    if (!checks)
        return;
    pthread_mutex_lock(&checks->lock);
    struct hazard_batch_record *batch = find(checks, timestamp);
    bool was_last = batch && batch->awaited && !--batch->awaited;
    pthread_mutex_unlock(&checks->lock);
    if (was_last)
        judge_ready(checks);
}

/* ---- creation */

VkResult hazard_checks_create(struct layer_device *device)
{
    if (!device->finds_hazards)
        return VK_SUCCESS;
    struct hazard_checks *checks = calloc(1, sizeof(*checks));
    if (!checks)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (!hazard_judge_begin(&checks->judge, device)) {
        free(checks);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    checks->device = device;
    checks->waiting_last = &checks->waiting;
    pthread_mutex_init(&checks->lock, NULL);
    device->hazard_checks = checks;
    return VK_SUCCESS;
}

void hazard_checks_destroy(struct hazard_checks *checks)
{
    if (!checks)
        return;
    hazard_checks_stop(checks);
    hazard_judge_end(&checks->judge);
    pthread_mutex_destroy(&checks->lock);
    free(checks);
}
