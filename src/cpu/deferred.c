/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations and their jobs. */
#include "src/cpu/deferred.h"

#include <stdbool.h>
#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/cpu/structures.h"
#include "src/platform/threads.h"

/* The work of an operation. A job outlives its operation while threads are in the work. Its lock
 * guards all members but `work`, which is constant until released. */
struct job {
    pthread_mutex_t lock;
    uint32_t references; /* of the operation and of threads */
    uint32_t inside;     /* threads that are in the work */
    struct cpu_work work;
    uint32_t next_part, parts_done;
    bool is_complete, is_released;
    VkResult result;
};

struct operation {
    struct job *job; /* a reference to the latest job, or NULL */
};

struct cpu_deferred_operations {
    pthread_mutex_t lock; /* taken before a job's */
    struct handle_table table;
};

/* ---- jobs */

static struct job *job_create(const struct cpu_work *work)
{
    struct job *job = calloc(1, sizeof(*job));
    if (!job)
        return NULL;
    job->references = 1;
    job->work = *work;
    pthread_mutex_init(&job->lock, NULL);
    return job;
}

static void job_keep(struct job *job)
{
    pthread_mutex_lock(&job->lock);
    job->references++;
    pthread_mutex_unlock(&job->lock);
}

static void job_drop(struct job *job)
{
    if (!job)
        return;
    pthread_mutex_lock(&job->lock);
    bool is_last = --job->references == 0;
    pthread_mutex_unlock(&job->lock);
    if (!is_last)
        return;
    if (!job->is_released)
        job->work.release(job->work.context);
    pthread_mutex_destroy(&job->lock);
    free(job);
}

static void run_parts(struct job *job)
{
    while (job->next_part < job->work.part_count) {
        uint32_t part = job->next_part++;
        pthread_mutex_unlock(&job->lock);
        VkResult result = job->work.run(job->work.context, part);
        pthread_mutex_lock(&job->lock);
        if (job->result == VK_SUCCESS)
            job->result = result;
        if (++job->parts_done < job->work.part_count)
            continue;
        if (job->work.finish)
            job->work.finish(job->work.context);
        job->is_complete = true;
    }
}

/* Returns the result of vkDeferredOperationJoinKHR for a thread that has left the work. If the work
 * has `help`, the thread may join again, because parts may need help later. */
static VkResult join_result(const struct job *job)
{
    if (job->is_complete)
        return VK_SUCCESS;
    return job->work.help ? VK_THREAD_IDLE_KHR : VK_THREAD_DONE_KHR;
}

static VkResult job_join(struct job *job)
{
    pthread_mutex_lock(&job->lock);
    job->inside++;
    run_parts(job);
    if (!job->is_complete && job->work.help) {
        pthread_mutex_unlock(&job->lock);
        job->work.help(job->work.context);
        pthread_mutex_lock(&job->lock);
    }
    bool is_last = --job->inside == 0 && job->is_complete && !job->is_released;
    job->is_released |= is_last;
    VkResult result = join_result(job);
    pthread_mutex_unlock(&job->lock);
    if (is_last)
        job->work.release(job->work.context);
    return result;
}

VkResult cpu_work_do(const struct cpu_work *work)
{
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < work->part_count; i++) {
        VkResult part = work->run(work->context, i);
        result = result == VK_SUCCESS ? part : result;
    }
    if (work->finish)
        work->finish(work->context);
    work->release(work->context);
    return result;
}

/* ---- operations */

VkResult cpu_deferred_operations_create(struct cpu_deferred_operations **operations)
{
    *operations = calloc(1, sizeof(**operations));
    if (!*operations)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*operations)->lock, NULL);
    return VK_SUCCESS;
}

static void free_operation(void *record)
{
    struct operation *operation = record;
    job_drop(operation->job);
    free(operation);
}

void cpu_deferred_operations_destroy(struct cpu_deferred_operations *operations)
{
    if (!operations)
        return;
    handle_table_drop(&operations->table, free_operation);
    pthread_mutex_destroy(&operations->lock);
    free(operations);
}

VkResult cpu_deferred_add(struct cpu_deferred_operations *operations, uint64_t *handle)
{
    struct operation *operation = calloc(1, sizeof(*operation));
    *handle = cpu_unique_handle();
    pthread_mutex_lock(&operations->lock);
    bool is_added = operation && handle_table_set(&operations->table, *handle, operation);
    pthread_mutex_unlock(&operations->lock);
    if (is_added)
        return VK_SUCCESS;
    free(operation);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_deferred_remove(struct cpu_deferred_operations *operations, uint64_t handle)
{
    pthread_mutex_lock(&operations->lock);
    struct operation *operation = handle_table_remove(&operations->table, handle);
    pthread_mutex_unlock(&operations->lock);
    if (operation)
        free_operation(operation);
}

static bool job_is_complete(struct job *job)
{
    pthread_mutex_lock(&job->lock);
    bool complete = job->is_complete;
    pthread_mutex_unlock(&job->lock);
    return complete;
}

/* Sets the job of an operation whose job is complete. Returns its old job, which may be NULL; or
 * `job` if the operation is unknown or its job is not complete. */
static struct job *replace_job(struct cpu_deferred_operations *operations, uint64_t handle,
                               struct job *job)
{
    pthread_mutex_lock(&operations->lock);
    struct operation *operation = handle_table_find(&operations->table, handle);
    if (operation && (!operation->job || job_is_complete(operation->job))) {
        struct job *old = operation->job;
        operation->job = job;
        job = old;
    }
    pthread_mutex_unlock(&operations->lock);
    return job;
}

VkResult cpu_deferred_start(struct cpu_deferred_operations *operations, uint64_t handle,
                            const struct cpu_work *work)
{
    struct job *job = job_create(work);
    if (!job) {
        work->release(work->context);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    struct job *unwanted = replace_job(operations, handle, job);
    bool is_started = unwanted != job;
    job_drop(unwanted);
    return is_started ? VK_OPERATION_DEFERRED_KHR : VK_ERROR_VALIDATION_FAILED;
}

/* Sets `job` to a new reference to the operation's job, or NULL. Returns false if the operation is
 * unknown. */
static bool find_job(struct cpu_deferred_operations *operations, uint64_t handle, struct job **job)
{
    pthread_mutex_lock(&operations->lock);
    const struct operation *operation = handle_table_find(&operations->table, handle);
    *job = operation ? operation->job : NULL;
    if (*job)
        job_keep(*job);
    pthread_mutex_unlock(&operations->lock);
    return operation != NULL;
}

VkResult cpu_deferred_join(struct cpu_deferred_operations *operations, uint64_t handle)
{
    struct job *job;
    if (!find_job(operations, handle, &job))
        return VK_ERROR_VALIDATION_FAILED;
    VkResult result = job ? job_join(job) : VK_SUCCESS;
    job_drop(job);
    return result;
}

VkResult cpu_deferred_result(struct cpu_deferred_operations *operations, uint64_t handle)
{
    struct job *job;
    if (!find_job(operations, handle, &job))
        return VK_ERROR_VALIDATION_FAILED;
    if (!job)
        return VK_SUCCESS;
    pthread_mutex_lock(&job->lock);
    VkResult result = job->is_complete ? job->result : VK_NOT_READY;
    pthread_mutex_unlock(&job->lock);
    job_drop(job);
    return result;
}

uint32_t cpu_deferred_concurrency(struct cpu_deferred_operations *operations, uint64_t handle)
{
    struct job *job;
    if (!find_job(operations, handle, &job) || !job)
        return 0;
    pthread_mutex_lock(&job->lock);
    uint32_t done = job->parts_done, most = job->work.concurrency;
    uint32_t result = job->is_complete ? 0 : done < most ? most - done : 1;
    pthread_mutex_unlock(&job->lock);
    job_drop(job);
    return result;
}
