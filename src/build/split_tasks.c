/* SPDX-License-Identifier: Apache-2.0 */
/* Builds a tree from the root down, handing parts of it to whichever thread is free. */
#include "build/tree.h"

struct split_job {
    struct build_state *state;
    tree_splitter *split_range;
};

/* By position, where no plane tells the centers apart or the tree has become too deep. */
void tree_halve(const struct build_state *state, const struct tree_task *task,
                struct tree_halves *halves)
{
    halves->middle = task->begin + (task->end - task->begin) / 2;
    for (int side = 0; side < 2; side++) {
        uint32_t begin = side == 0 ? task->begin : halves->middle;
        uint32_t end = side == 0 ? halves->middle : task->end;
        halves->bounds[side] = halves->centers[side] = box_empty();
        for (uint32_t i = begin; i < end; i++) {
            const struct primitive_ref *ref = &state->refs[i];
            float4 center = ref->lower + ref->upper;
            box_add(&halves->bounds[side], ref->lower, ref->upper);
            box_add(&halves->centers[side], center, center);
        }
    }
}

static void split_node(struct build_state *state, const struct tree_task *task,
                       const struct tree_halves *halves, struct tree_task children[2])
{
    uint32_t right = task->slot + 2 * (halves->middle - task->begin);
    children[0] = (struct tree_task){halves->centers[0], task->slot + 1, task->begin,
                                     halves->middle, task->depth + 1};
    children[1] =
        (struct tree_task){halves->centers[1], right, halves->middle, task->end, task->depth + 1};
    state->tree[task->slot + 1].bounds = halves->bounds[0];
    state->tree[right].bounds = halves->bounds[1];
    tree_set_inner(&state->tree[task->slot], right, task->end - task->begin);
}

/* Tasks in the list have at least TREE_TASK_SIZE primitives each, and none in common: the scratch
 * has room for all there can be. */
static bool hand_on(struct build_state *state, const struct tree_task *task)
{
    if (state->workers.count == 1 || task->end - task->begin < TREE_TASK_SIZE)
        return false;
    pthread_mutex_lock(&state->task_lock);
    state->tasks[state->task_count++] = *task;
    pthread_cond_signal(&state->task_news);
    pthread_mutex_unlock(&state->task_lock);
    return true;
}

/* Left sides first; the right sides that wait are at most as many as the tree is deep. */
static void split_part(struct split_job *job, struct tree_task task)
{
    struct build_state *state = job->state;
    struct tree_task waiting[TREE_DEPTH_LIMIT];
    uint32_t count = 0;
    for (;;) {
        struct tree_halves halves;
        if (job->split_range(state, &task, &halves)) {
            struct tree_task children[2];
            split_node(state, &task, &halves, children);
            if (!hand_on(state, &children[1]))
                waiting[count++] = children[1];
            task = children[0];
            continue;
        }
        tree_set_leaf(&state->tree[task.slot], task.end - task.begin);
        if (count == 0)
            return;
        task = waiting[--count];
    }
}

static void split_tasks(void *context)
{
    struct split_job *job = context;
    struct build_state *state = job->state;
    pthread_mutex_lock(&state->task_lock);
    while (state->task_count > 0 || state->tasks_running > 0) {
        if (state->task_count == 0) {
            pthread_cond_wait(&state->task_news, &state->task_lock);
            continue;
        }
        struct tree_task task = state->tasks[--state->task_count];
        state->tasks_running++;
        pthread_mutex_unlock(&state->task_lock);
        split_part(job, task);
        pthread_mutex_lock(&state->task_lock);
        if (--state->tasks_running == 0)
            pthread_cond_broadcast(&state->task_news);
    }
    pthread_mutex_unlock(&state->task_lock);
}

void tree_split_all(struct build_state *state, tree_splitter *split_range)
{
    struct tree_task root = {.centers = state->centers, .end = state->ref_count};
    struct split_job job = {state, split_range};
    state->tree[0].bounds = state->bounds;
    if (state->workers.count == 1) {
        split_part(&job, root);
        return;
    }
    pthread_mutex_init(&state->task_lock, NULL);
    pthread_cond_init(&state->task_news, NULL);
    state->tasks[0] = root;
    state->task_count = 1;
    workers_run(&state->workers, split_tasks, &job);
    pthread_cond_destroy(&state->task_news);
    pthread_mutex_destroy(&state->task_lock);
}
