/* SPDX-License-Identifier: Apache-2.0 */
/* Builds a tree from the root down, and shares parts of it with free threads. */
#include "src/bvh/tree/tree.h"

/* Used if no plane separates the centers or the tree has become too deep. Primitive numbers have 29
 * bits and are unique, so at most 29 of these splits follow each other. */
void tree_split_numbers(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves)
{
    struct primitive_ref *refs = state->refs, *low = refs + task->begin, *high = refs + task->end;
    uint32_t first = ref_primitive(low), differing = 0;
    for (uint32_t i = task->begin + 1; i < task->end; i++)
        differing |= ref_primitive(&refs[i]) ^ first;
    uint32_t bit = 31 - (uint32_t)__builtin_clz(differing);
    for (int side = 0; side < 2; side++)
        halves->bounds[side] = halves->centers[side] = box_empty();
    while (low < high) {
        struct primitive_ref ref = *low;
        uint32_t side = ref_primitive(&ref) >> bit & 1;
        float4 center = ref.lower + ref.upper;
        box_add(&halves->bounds[side], ref.lower, ref.upper);
        box_add(&halves->centers[side], center, center);
        if (side == 0) {
            low++;
            continue;
        }
        *low = *--high;
        *high = ref;
    }
    halves->middle = (uint32_t)(low - refs);
}

/* Splits two refs, which a leaf could hold, without bins or sorting. Half of all ranges have this
 * size. */
static bool split_pair(struct build_state *state, const struct tree_task *task,
                       struct tree_halves *halves)
{
    struct primitive_ref *refs = &state->refs[task->begin], first = refs[0], second = refs[1];
    struct box bounds = state->tree[task->slot].bounds;
    struct box boxes[2] = {{first.lower, first.upper}, {second.lower, second.upper}};
    float4 unit = box_unit(bounds);
    float area = box_half_area_in(bounds, unit);
    float cost = box_half_area_in(boxes[0], unit) + box_half_area_in(boxes[1], unit);
    float4 centers[2] = {first.lower + first.upper, second.lower + second.upper};
    unsigned differing = int4_mask(centers[0] != centers[1]) & 7, axis = differing & -differing;
    if (differing == 0 || !(cost + NODE_COST * area < 2 * area))
        return false;
    bool is_swapped = int4_mask(centers[0] > centers[1]) & axis;
    refs[0] = is_swapped ? second : first;
    refs[1] = is_swapped ? first : second;
    for (int side = 0; side < 2; side++) {
        int from = is_swapped ? 1 - side : side;
        halves->bounds[side] = boxes[from];
        halves->centers[side] = (struct box){centers[from], centers[from]};
    }
    halves->middle = task->begin + 1;
    return true;
}

/* Returns false if the range becomes a leaf. */
static bool split_range(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves)
{
    uint32_t count = task->end - task->begin, limit = tree_split_limit(state->kind);
    if (count == 1)
        return false;
    if (count == 2 && limit == 2)
        return split_pair(state, task, halves);
    if (task->depth < SPLIT_DEPTH_LIMIT)
        return state->split_range(state, task, halves);
    tree_split_numbers(state, task, halves);
    return count > limit;
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

bool tree_share_task(struct build_state *state, const struct tree_task *task)
{
    if (workers_are_alone(&state->workers) || task->end - task->begin < TREE_TASK_SIZE)
        return false;
    pthread_mutex_lock(&state->lock);
    state->tasks[state->task_count++] = *task;
    pthread_cond_signal(&state->task_wakeup);
    pthread_mutex_unlock(&state->lock);
    return true;
}

struct task_job {
    struct build_state *state;
    tree_task_runner *run;
};

static void run_tasks(void *context)
{
    const struct task_job *job = context;
    struct build_state *state = job->state;
    pthread_mutex_lock(&state->lock);
    while (state->task_count > 0 || state->tasks_running > 0) {
        if (state->task_count == 0) {
            pthread_cond_wait(&state->task_wakeup, &state->lock);
            continue;
        }
        struct tree_task task = state->tasks[--state->task_count];
        state->tasks_running++;
        pthread_mutex_unlock(&state->lock);
        job->run(state, task);
        pthread_mutex_lock(&state->lock);
        if (--state->tasks_running == 0)
            pthread_cond_broadcast(&state->task_wakeup);
    }
    pthread_mutex_unlock(&state->lock);
}

void tree_run_tasks(struct build_state *state, tree_task_runner *run)
{
    struct task_job job = {state, run};
    workers_run(&state->workers, run_tasks, &job);
}

/* The set of refs in a leaf does not depend on the number of threads. Sorting them makes their
 * order independent, too. */
static void order_leaf(struct build_state *state, const struct tree_task *task)
{
    struct primitive_ref *refs = state->refs + task->begin;
    if (task->end - task->begin == 2 && ref_primitive(&refs[0]) > ref_primitive(&refs[1])) {
        struct primitive_ref swap = refs[0];
        refs[0] = refs[1];
        refs[1] = swap;
    }
}

/* Processes left sides first. The pending right sides number at most the depth of the tree. */
static void split_part(struct build_state *state, struct tree_task task)
{
    struct tree_task waiting[TREE_DEPTH_LIMIT];
    uint32_t count = 0;
    for (;;) {
        struct tree_halves halves;
        if (split_range(state, &task, &halves)) {
            struct tree_task children[2];
            split_node(state, &task, &halves, children);
            if (!tree_share_task(state, &children[1]))
                waiting[count++] = children[1];
            task = children[0];
            continue;
        }
        order_leaf(state, &task);
        tree_set_leaf(&state->tree[task.slot], task.end - task.begin);
        if (count == 0)
            return;
        task = waiting[--count];
    }
}

/* Splits the top of the tree down to ranges below `shared`. Larger ranges are always split. */
static void split_top(struct build_state *state, struct tree_task task, uint32_t shared)
{
    struct tree_task waiting[TREE_DEPTH_LIMIT];
    uint32_t count = 0;
    for (;;) {
        if (task.end - task.begin >= shared) {
            struct tree_halves halves;
            struct tree_task children[2];
            split_range(state, &task, &halves);
            split_node(state, &task, &halves, children);
            waiting[count++] = children[1];
            task = children[0];
            continue;
        }
        if (!tree_share_task(state, &task))
            split_part(state, task);
        if (count == 0)
            return;
        task = waiting[--count];
    }
}

void tree_split_all(struct build_state *state, tree_splitter *splitter, uint32_t shared)
{
    struct tree_task root = {.centers = state->centers, .end = state->ref_count};
    state->split_range = splitter;
    state->tree[0].bounds = state->bounds;
    split_top(state, root, shared);
    tree_run_tasks(state, split_part);
}
