/* SPDX-License-Identifier: Apache-2.0 */
/* Teams: a list of jobs. Threads join a job when they are free, and leave it when it has no work
 * left. */
#include "src/bvh/workers.h"

#include "src/base/float_environment.h"
#include "src/platform/threads.h"

/* The time that a helper which may leave waits for another job. */
enum { HELPER_WAIT_NS = 1000000 };

/* A job lives on the stack of the thread that calls workers_run(), and is in the list of its team
 * while it runs. */
struct builder_team_job {
    void (*run)(void *context);
    void *context;
    struct builder_team_job *next;
    uint32_t busy;     /* number of helpers that run it */
    bool is_exhausted; /* no work is left for new helpers */
};

void builder_team_open(struct builder_team *team)
{
    *team = (struct builder_team){.jobs = NULL};
    pthread_mutex_init(&team->lock, NULL);
    timed_condition_init(&team->wakeup);
    pthread_cond_init(&team->done, NULL);
}

void builder_team_close(struct builder_team *team)
{
    pthread_mutex_lock(&team->lock);
    team->is_closed = true;
    pthread_cond_broadcast(&team->wakeup);
    pthread_mutex_unlock(&team->lock);
}

void builder_team_destroy(struct builder_team *team)
{
    pthread_mutex_destroy(&team->lock);
    pthread_cond_destroy(&team->wakeup);
    pthread_cond_destroy(&team->done);
}

static struct builder_team_job *find_job(const struct builder_team *team)
{
    struct builder_team_job *job = team->jobs;
    while (job && job->is_exhausted)
        job = job->next;
    return job;
}

/* Returns false if no job came for a while and the helper may leave. */
static bool wait_for_wakeup(struct builder_team *team, bool may_leave)
{
    if (!may_leave)
        return pthread_cond_wait(&team->wakeup, &team->lock) == 0;
    return timed_condition_wait(&team->wakeup, &team->lock, HELPER_WAIT_NS);
}

static void help(struct builder_team *team, bool may_leave)
{
    bool stays = true;
    fenv_t of_application;
    float_environment_enter(&of_application);
    pthread_mutex_lock(&team->lock);
    while (!team->is_closed && stays) {
        struct builder_team_job *job = find_job(team);
        if (!job) {
            stays = wait_for_wakeup(team, may_leave);
            continue;
        }
        job->busy++;
        pthread_mutex_unlock(&team->lock);
        job->run(job->context);
        pthread_mutex_lock(&team->lock);
        job->is_exhausted = true;
        if (--job->busy == 0)
            pthread_cond_broadcast(&team->done);
    }
    pthread_mutex_unlock(&team->lock);
    float_environment_leave(&of_application);
}

void builder_team_help(struct builder_team *team)
{
    help(team, false);
}

void builder_team_help_for_now(struct builder_team *team)
{
    help(team, true);
}

static void remove_job(struct builder_team *team, const struct builder_team_job *job)
{
    struct builder_team_job **link = &team->jobs;
    while (*link != job)
        link = &(*link)->next;
    *link = job->next;
}

void workers_run(struct workers *workers, void (*job)(void *context), void *context)
{
    struct builder_team *team = workers->team;
    if (!team) {
        job(context);
        return;
    }
    struct builder_team_job mine = {.run = job, .context = context};
    pthread_mutex_lock(&team->lock);
    mine.next = team->jobs;
    team->jobs = &mine;
    pthread_cond_broadcast(&team->wakeup);
    pthread_mutex_unlock(&team->lock);
    job(context);
    pthread_mutex_lock(&team->lock);
    remove_job(team, &mine);
    while (mine.busy > 0)
        pthread_cond_wait(&team->done, &team->lock);
    pthread_mutex_unlock(&team->lock);
}

struct each_job {
    workers_body *body;
    void *context;
    uint64_t count, step, next; /* advanced atomically */
};

static void run_each(void *context)
{
    struct each_job *job = context;
    for (;;) {
        uint64_t begin = __atomic_fetch_add(&job->next, job->step, __ATOMIC_RELAXED);
        if (begin >= job->count)
            return;
        uint64_t end = begin + job->step < job->count ? begin + job->step : job->count;
        job->body(job->context, (uint32_t)begin, (uint32_t)end);
    }
}

void workers_each(struct workers *workers, uint32_t count, uint32_t step, workers_body *body,
                  void *context)
{
    struct each_job job = {body, context, count, step, 0};
    if (count <= step)
        run_each(&job);
    else
        workers_run(workers, run_each, &job);
}

static void *worker_main(void *team)
{
    builder_team_help(team);
    return NULL;
}

void workers_start(struct workers *workers, const struct builder_input *input, uint32_t primitives)
{
    uint32_t requested = input->threads < WORKERS_MAX ? input->threads : WORKERS_MAX;
    bool is_worth_it = primitives > WORKERS_MIN_PRIMITIVES;
    workers->team = is_worth_it ? input->team : NULL;
    workers->started = 0;
    if (!is_worth_it || input->team || requested <= 1)
        return;
    workers->team = &workers->own;
    builder_team_open(workers->team);
    struct blocked_signals blocked;
    threads_block_signals(&blocked);
    while (workers->started + 1 < requested &&
           pthread_create(&workers->threads[workers->started], NULL, worker_main, workers->team) ==
               0)
        workers->started++;
    threads_unblock_signals(&blocked);
}

void workers_stop(struct workers *workers)
{
    if (workers->team != &workers->own)
        return;
    builder_team_close(workers->team);
    for (uint32_t i = 0; i < workers->started; i++)
        pthread_join(workers->threads[i], NULL);
    builder_team_destroy(workers->team);
}
