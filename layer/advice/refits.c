/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/advice/refits.h"

#include <stdlib.h>

#include "src/advice/figures/refits.h"
#include "src/advice/rules.h"
#include "src/base/float_environment.h"
#include "src/platform/clock.h"
#include "src/platform/threads.h"

enum { PAUSE_NS = 500000000 };

struct refit_job {
    struct refit_job *next;
    uint64_t id;
    struct refit refit;
    struct advice_report report;
};

struct refit_judge {
    const struct advice_limits *limits;
    const struct layer_device *device;
    struct advice_list *list;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    struct refit_job *jobs, **last; /* the first one is being judged */
    uint32_t count;
    bool has_thread, is_ending;
    pthread_t thread;
};

struct refit_judge *refit_judge_create(const struct layer_device *device,
                                       const struct advice_limits *limits, struct advice_list *list)
{
    struct refit_judge *judge = calloc(1, sizeof(*judge));
    if (!judge)
        return NULL;
    judge->limits = limits;
    judge->device = device;
    judge->list = list;
    judge->last = &judge->jobs;
    pthread_mutex_init(&judge->lock, NULL);
    timed_condition_init(&judge->changed);
    return judge;
}

/* ---- the thread */

static void judge_job(const struct refit_judge *judge, struct refit_job *job)
{
    uint64_t weight;
    const struct tree_view view = {
        .geometry = job->refit.geometry,
        .triangles = job->refit.now->of,
        .refit_cost = triangle_sample_refit_cost(job->refit.built, job->refit.now),
        .limits = judge->limits,
    };
    if (updates_suit_the_tree(&view, &job->report.finding, &weight))
        return;
    uses_note_advised(judge->device->structures, job->id, job->report.advice);
    advice_list_add(judge->list, &job->report, weight);
}

static void free_job(struct refit_job *job)
{
    triangle_sample_release(job->refit.built);
    triangle_sample_release(job->refit.now);
    free(job);
}

/* Call with the lock held. */
static void remove_first(struct refit_judge *judge)
{
    struct refit_job *job = judge->jobs;
    judge->jobs = job->next;
    judge->count--;
    if (!judge->jobs)
        judge->last = &judge->jobs;
    free_job(job);
}

/* Pauses so long that the work was its share of the time. Call with the lock held. */
static void pause_after(struct refit_judge *judge, uint64_t worked)
{
    const uint64_t percent = judge->limits->of[ADVICE_LIMIT_refit_percent];
    const uint64_t rest = percent < 100 ? worked * (100 - percent) / percent : 0;
    const uint64_t end = clock_monotonic() + rest;
    for (uint64_t now; !judge->is_ending && (now = clock_monotonic()) < end;)
        timed_condition_wait(&judge->changed, &judge->lock,
                             end - now < PAUSE_NS ? (uint32_t)(end - now) : PAUSE_NS);
}

static void *judge_all(void *user)
{
    struct refit_judge *judge = user;
    fenv_t of_application;
    float_environment_enter(&of_application);
    pthread_mutex_lock(&judge->lock);
    while (judge->jobs || !judge->is_ending) {
        if (!judge->jobs) {
            pthread_cond_wait(&judge->changed, &judge->lock);
            continue;
        }
        struct refit_job *job = judge->jobs;
        pthread_mutex_unlock(&judge->lock);
        const uint64_t begin = clock_monotonic();
        judge_job(judge, job);
        const uint64_t worked = clock_monotonic() - begin;
        pthread_mutex_lock(&judge->lock);
        remove_first(judge);
        pause_after(judge, worked);
    }
    pthread_mutex_unlock(&judge->lock);
    float_environment_leave(&of_application);
    return NULL;
}

/* ---- the application's threads */

static bool has_thread(struct refit_judge *judge)
{
    if (judge->has_thread)
        return true;
    struct blocked_signals signals;
    threads_block_signals(&signals);
    judge->has_thread = pthread_create(&judge->thread, NULL, judge_all, judge) == 0;
    threads_unblock_signals(&signals);
    return judge->has_thread;
}

static bool is_waiting(const struct refit_judge *judge, uint64_t id)
{
    const struct refit_job *job = judge->jobs;
    while (job && job->id != id)
        job = job->next;
    return job;
}

static bool was_advised(const struct refit_judge *judge, uint64_t id, enum advice advice)
{
    struct structure_uses uses;
    uses_find(judge->device->structures, id, &uses);
    return uses.advised >> advice & 1;
}

static struct refit_job *create_job(uint64_t id, const struct refit *refit,
                                    const struct advice_report *report)
{
    struct refit_job *job = malloc(sizeof(*job));
    if (!job)
        return NULL;
    *job = (struct refit_job){.id = id, .refit = *refit, .report = *report};
    triangle_sample_share(refit->built);
    triangle_sample_share(refit->now);
    return job;
}

void refit_judge_add(struct refit_judge *judge, uint64_t id, const struct refit *refit,
                     const struct advice_report *report)
{
    pthread_mutex_lock(&judge->lock);
    struct refit_job *job = NULL;
    if (judge->limits->of[ADVICE_LIMIT_refit_percent] && judge->count < REFITS_WAITING_MAX &&
        !judge->is_ending && !is_waiting(judge, id) && !was_advised(judge, id, report->advice) &&
        has_thread(judge))
        job = create_job(id, refit, report);
    if (job) {
        *judge->last = job;
        judge->last = &job->next;
        judge->count++;
        pthread_cond_signal(&judge->changed);
    }
    pthread_mutex_unlock(&judge->lock);
}

void refit_judge_end(struct refit_judge *judge)
{
    pthread_mutex_lock(&judge->lock);
    const bool has_thread = judge->has_thread;
    judge->is_ending = true;
    judge->has_thread = false;
    pthread_cond_signal(&judge->changed);
    pthread_mutex_unlock(&judge->lock);
    if (has_thread)
        pthread_join(judge->thread, NULL);
}

void refit_judge_destroy(struct refit_judge *judge)
{
    if (!judge)
        return;
    refit_judge_end(judge);
    pthread_mutex_destroy(&judge->lock);
    pthread_cond_destroy(&judge->changed);
    free(judge);
}
