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

struct refit_rules {
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

struct refit_rules *refit_rules_create(const struct layer_device *device,
                                       const struct advice_limits *limits, struct advice_list *list)
{
    struct refit_rules *rules = calloc(1, sizeof(*rules));
    if (!rules)
        return NULL;
    rules->limits = limits;
    rules->device = device;
    rules->list = list;
    rules->last = &rules->jobs;
    pthread_mutex_init(&rules->lock, NULL);
    timed_condition_init(&rules->changed);
    return rules;
}

/* ---- the thread */

static void judge_job(const struct refit_rules *rules, struct refit_job *job)
{
    uint64_t weight;
    const struct tree_view view = {
        .geometry = job->refit.geometry,
        .triangles = job->refit.now->of,
        .refit_cost = triangle_sample_refit_cost(job->refit.built, job->refit.now),
        .limits = rules->limits,
    };
    if (updates_suit_the_tree(&view, &job->report.finding, &weight))
        return;
    uses_note_advised(rules->device->structures, job->id, job->report.advice);
    advice_list_add(rules->list, &job->report, weight);
}

static void free_job(struct refit_job *job)
{
    triangle_sample_release(job->refit.built);
    triangle_sample_release(job->refit.now);
    free(job);
}

/* Call with the lock held. */
static void remove_first(struct refit_rules *rules)
{
    struct refit_job *job = rules->jobs;
    rules->jobs = job->next;
    rules->count--;
    if (!rules->jobs)
        rules->last = &rules->jobs;
    free_job(job);
}

/* Pauses so long that the work was its share of the time. Call with the lock held. */
static void pause_after(struct refit_rules *rules, uint64_t worked)
{
    const uint64_t percent = rules->limits->of[ADVICE_LIMIT_refit_percent];
    const uint64_t rest = percent < 100 ? worked * (100 - percent) / percent : 0;
    const uint64_t end = clock_monotonic() + rest;
    for (uint64_t now; !rules->is_ending && (now = clock_monotonic()) < end;)
        timed_condition_wait(&rules->changed, &rules->lock,
                             end - now < PAUSE_NS ? (uint32_t)(end - now) : PAUSE_NS);
}

static void *judge_all(void *user)
{
    struct refit_rules *rules = user;
    fenv_t of_application;
    float_environment_enter(&of_application);
    pthread_mutex_lock(&rules->lock);
    while (rules->jobs || !rules->is_ending) {
        if (!rules->jobs) {
            pthread_cond_wait(&rules->changed, &rules->lock);
            continue;
        }
        struct refit_job *job = rules->jobs;
        pthread_mutex_unlock(&rules->lock);
        const uint64_t begin = clock_monotonic();
        judge_job(rules, job);
        const uint64_t worked = clock_monotonic() - begin;
        pthread_mutex_lock(&rules->lock);
        remove_first(rules);
        pause_after(rules, worked);
    }
    pthread_mutex_unlock(&rules->lock);
    float_environment_leave(&of_application);
    return NULL;
}

/* ---- the application's threads */

static bool has_thread(struct refit_rules *rules)
{
    if (rules->has_thread)
        return true;
    struct blocked_signals signals;
    threads_block_signals(&signals);
    rules->has_thread = pthread_create(&rules->thread, NULL, judge_all, rules) == 0;
    threads_unblock_signals(&signals);
    return rules->has_thread;
}

static bool is_waiting(const struct refit_rules *rules, uint64_t id)
{
    const struct refit_job *job = rules->jobs;
    while (job && job->id != id)
        job = job->next;
    return job;
}

static bool was_advised(const struct refit_rules *rules, uint64_t id, enum advice advice)
{
    struct structure_uses uses;
    uses_find(rules->device->structures, id, &uses);
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

void refit_rules_add(struct refit_rules *rules, uint64_t id, const struct refit *refit,
                     const struct advice_report *report)
{
    pthread_mutex_lock(&rules->lock);
    struct refit_job *job = NULL;
    if (rules->limits->of[ADVICE_LIMIT_refit_percent] && rules->count < REFITS_WAITING_MAX &&
        !rules->is_ending && !is_waiting(rules, id) && !was_advised(rules, id, report->advice) &&
        has_thread(rules))
        job = create_job(id, refit, report);
    if (job) {
        *rules->last = job;
        rules->last = &job->next;
        rules->count++;
        pthread_cond_signal(&rules->changed);
    }
    pthread_mutex_unlock(&rules->lock);
}

void refit_rules_end(struct refit_rules *rules)
{
    pthread_mutex_lock(&rules->lock);
    const bool has_thread = rules->has_thread;
    rules->is_ending = true;
    rules->has_thread = false;
    pthread_cond_signal(&rules->changed);
    pthread_mutex_unlock(&rules->lock);
    if (has_thread)
        pthread_join(rules->thread, NULL);
}

void refit_rules_destroy(struct refit_rules *rules)
{
    if (!rules)
        return;
    refit_rules_end(rules);
    pthread_mutex_destroy(&rules->lock);
    pthread_cond_destroy(&rules->changed);
    free(rules);
}
