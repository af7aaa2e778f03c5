/* SPDX-License-Identifier: Apache-2.0 */
/* Judges batches in execution order, each once its instances and indices are known. */
#include "layer/hazards/executed/checks.h"

#include <stdlib.h>

#include "layer/hazards/executed/search.h"
#include "src/base/drain.h"
#include "src/state/commands/object_names.h"

struct hazard_checks {
    struct layer_device *device;
    struct batch_list *batches; /* its lock guards the members below, but for `search` */
    struct drain drain;
    atomic_uint_fast64_t kept, missed; /* batches so far; without memory a batch is missing */
    struct ended_object *ended, **ended_last;
    bool stopped;                /* no more batches come */
    struct hazard_search search; /* of the thread that drains */
};

/* ---- judging */

static bool is_ready(const struct hazard_checks *checks, const struct hazard_batch_record *batch)
{
    return checks->stopped || (batch->has_run && !batch->awaited);
}

static void end_object(struct hazard_checks *checks)
{
    struct ended_object *object = checks->ended;
    checks->ended = object->next;
    if (!checks->ended)
        checks->ended_last = &checks->ended;
    pthread_mutex_unlock(&checks->batches->lock);
    hazard_search_end_object(&checks->search, object);
    free(object);
    pthread_mutex_lock(&checks->batches->lock);
}

/* Judges the next batch, or drops the record of the next object. Returns false if neither is ready.
 * Call with the lock. */
static bool judge_next(struct hazard_checks *checks)
{
    if (checks->ended && checks->ended->after <= checks->search.batch_count) {
        end_object(checks);
        return true;
    }
    const struct order_batch *next =
        batch_list_next(checks->batches, IN_EXECUTION_ORDER, checks->search.last, USES_HAZARDS);
    struct hazard_batch_record *batch = next ? next->slots[USES_HAZARDS] : NULL;
    if (!batch || !is_ready(checks, batch))
        return false;
    batch->is_taken = true;
    if (atomic_exchange(&checks->missed, 0))
        unknown_set(&checks->search.unknown, UNKNOWN_HAZARDS);
    pthread_mutex_unlock(&checks->batches->lock);
    hazard_search_batch(&checks->search, batch);
    pthread_mutex_lock(&checks->batches->lock);
    return true;
}

/* Judges what is ready, and releases the lock. If another thread judges, it will see what has
 * changed. */
static void judge_and_unlock(struct hazard_checks *checks)
{
    if (drain_begin(&checks->drain))
        do {
            while (judge_next(checks))
                continue;
        } while (drain_repeat(&checks->drain));
    pthread_mutex_unlock(&checks->batches->lock);
}

static void note_observed(const struct layer_device *device, struct ended_object *object)
{
    if (object->ended == STRUCTURE_DESTROYED)
        object_names_get(device->names, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, object->id,
                         object->name, sizeof(object->name));
    object->observed_clock_is_known =
        execution_order_find_observed(device->order, &object->observed, &object->untracked);
}

void hazard_checks_forget(struct hazard_checks *checks, enum hazard_end ended, uint64_t id)
{
    struct ended_object *object = checks && id ? calloc(1, sizeof(*object)) : NULL;
    if (!object)
        return;
    object->ended = ended;
    object->id = id;
    if (ended != EVENT_DESTROYED)
        note_observed(checks->device, object);
    pthread_mutex_lock(&checks->batches->lock);
    object->after = checks->kept;
    *checks->ended_last = object;
    checks->ended_last = &object->next;
    judge_and_unlock(checks);
}

void hazard_checks_stop(struct hazard_checks *checks)
{
    if (!checks)
        return;
    pthread_mutex_lock(&checks->batches->lock);
    checks->stopped = true;
    judge_and_unlock(checks);
}

/* ---- the consumer */

/* Host work has a timestamp only at its end. If it failed, what it wrote is unknown. */
static bool effects_are_known(const struct order_batch *batch)
{
    return batch->is_replayed && batch->work != WORK_BEGINS && batch->work != WORK_FAILS;
}

/* Until the batch is kept, its slot has what hazard_batch_record.untracked will be. */
static void hazard_checks_submit(void *user, struct order_batch *batch)
{
    const struct hazard_checks *checks = user;
    struct execution_clock observed;
    uint64_t untracked = 0;
    execution_order_find_observed(checks->device->order, &observed, &untracked);
    batch->slots[USES_HAZARDS] = (void *)(uintptr_t)untracked;
}

static void hazard_checks_run(void *user, struct order_batch *batch)
{
    struct hazard_checks *checks = user;
    if (!effects_are_known(batch))
        return;
    struct hazard_batch_record *record = hazard_batch_create(batch);
    if (record) {
        record->untracked = (uintptr_t)batch->slots[USES_HAZARDS];
        hazard_batch_add_copies(record, checks->device->structures);
        order_batch_keep(batch, USES_HAZARDS, record);
    }
    atomic_fetch_add(record ? &checks->kept : &checks->missed, 1);
}

/* Takes the lock. Returns NULL if the batch is not kept, or was judged. */
static struct hazard_batch_record *lock_unjudged_batch(struct hazard_checks *checks,
                                                       const struct order_batch *batch)
{
    pthread_mutex_lock(&checks->batches->lock);
    struct hazard_batch_record *record =
        order_batch_is_kept(batch, USES_HAZARDS) ? batch->slots[USES_HAZARDS] : NULL;
    return record && !record->is_taken ? record : NULL;
}

/* Which instances will be known is known now. */
static void hazard_checks_ran(void *user, struct order_batch *batch)
{
    struct hazard_checks *checks = user;
    struct hazard_batch_record *record = lock_unjudged_batch(checks, batch);
    if (record)
        record->has_run = true;
    judge_and_unlock(checks);
}

struct batch_consumer hazard_checks_consumer(struct hazard_checks *checks)
{
    return (struct batch_consumer){.user = checks,
                                   .submit = hazard_checks_submit,
                                   .run = hazard_checks_run,
                                   .ran = hazard_checks_ran};
}

/* ---- references and indices */

void hazard_checks_begin_inputs(struct hazard_checks *checks, struct order_batch *batch)
{
    if (!checks)
        return;
    struct hazard_batch_record *record = lock_unjudged_batch(checks, batch);
    if (record && record->awaits_inputs)
        record->awaited++;
    pthread_mutex_unlock(&checks->batches->lock);
}

void hazard_checks_add_input(struct hazard_checks *checks, struct order_batch *batch,
                             const struct hazard_input *input)
{
    if (!checks)
        return;
    struct hazard_batch_record *record = lock_unjudged_batch(checks, batch);
    if (record && record->awaited)
        hazard_batch_add(record, input);
    pthread_mutex_unlock(&checks->batches->lock);
}

void hazard_checks_add_reference(struct hazard_checks *checks, struct order_batch *batch,
                                 const struct journal *journal, uint32_t position,
                                 const struct accel_facts *referenced)
{
    if (!checks || !referenced->memory)
        return;
    /* How much of the structure its last build needed is unknown: the first byte is certain. */
    const struct hazard_input reference = {
        .place = {.journal = journal, .position = position},
        .structure = handle_number(referenced->handle),
        .bytes = {resources_find_memory_id(checks->device->resources, referenced->memory),
                  referenced->begin, referenced->begin + (referenced->size != 0)},
    };
    if (reference.bytes.memory)
        hazard_checks_add_input(checks, batch, &reference);
}

void hazard_checks_end_inputs(struct hazard_checks *checks, struct order_batch *batch)
{
    if (!checks)
        return;
    struct hazard_batch_record *record = lock_unjudged_batch(checks, batch);
    if (record && record->awaited)
        record->awaited--;
    judge_and_unlock(checks);
}

/* ---- creation */

VkResult hazard_checks_create(struct layer_device *device)
{
    if (!device->finds_hazards)
        return VK_SUCCESS;
    struct hazard_checks *checks = calloc(1, sizeof(*checks));
    if (!checks)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (!hazard_search_begin(&checks->search, device)) {
        free(checks);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    checks->device = device;
    checks->batches = execution_order_batches(device->order);
    checks->ended_last = &checks->ended;
    device->hazard_checks = checks;
    return VK_SUCCESS;
}

void hazard_checks_destroy(struct hazard_checks *checks)
{
    if (!checks)
        return;
    hazard_checks_stop(checks);
    hazard_search_end(&checks->search);
    free(checks);
}
