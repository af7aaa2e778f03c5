/* SPDX-License-Identifier: Apache-2.0 */
/* The graph, and when batches are held back. */
#include "model.h"

#include <string.h>

static void add_edge(struct model *model, node before, node after)
{
    if (!before)
        return;
    assert_true(model->edge_count < MODEL_EDGES);
    int edge = model->edge_count++;
    model->edges[edge].before = before;
    model->edges[edge].next = model->first_edge[after];
    model->first_edge[after] = edge;
}

node model_add_node(struct model *model, node before)
{
    assert_true(model->node_count < MODEL_NODES);
    node added = model->node_count++;
    model->first_edge[added] = -1;
    add_edge(model, before, added);
    return added;
}

static bool search(const struct model *model, node before, node after, bool *visited)
{
    if (before == after)
        return true;
    if (visited[after])
        return false;
    visited[after] = true;
    for (int edge = model->first_edge[after]; edge >= 0; edge = model->edges[edge].next)
        if (search(model, before, model->edges[edge].before, visited))
            return true;
    return false;
}

bool model_is_before(const struct model *model, node before, node after)
{
    bool visited[MODEL_NODES] = {false};
    return before && after && before != after && search(model, before, after, visited);
}

void model_start(struct model *model)
{
    memset(model, 0, sizeof(*model));
    model->node_count = 1;
    model->host = model_add_node(model, 0);
}

void model_see(struct model *model, node seen)
{
    node host = model_add_node(model, model->host);
    add_edge(model, seen, host);
    model->host = host;
}

static void announce(struct model_semaphore *semaphore, uint64_t value)
{
    uint32_t at = semaphore->signal_count++;
    assert_true(at < MODEL_SIGNALS);
    for (; at && semaphore->signals[at - 1].value > value; at--)
        semaphore->signals[at] = semaphore->signals[at - 1];
    semaphore->signals[at].value = value;
    semaphore->signals[at].node = 0;
}

uint32_t model_submit(struct model *model, const struct model_batch *batch)
{
    uint32_t index = model->batch_count++;
    assert_true(index < MODEL_BATCHES);
    model->batches[index] = *batch;
    for (int i = 0; i < CALL_OPERATIONS && batch->signal[i].semaphore; i++)
        announce(&model->semaphores[batch->signal[i].semaphore], batch->signal[i].value);
    model->queues[batch->queue].waiting[model->queues[batch->queue].count++] = index;
    return index;
}

/* Whether the wait is over, and by which signal. */
static bool is_over(const struct model *model, const struct operation *wait, node *signal)
{
    const struct model_semaphore *semaphore = &model->semaphores[wait->semaphore];
    *signal = 0;
    if (wait->value <= semaphore->initial)
        return true;
    for (uint32_t i = 0; i < semaphore->signal_count; i++)
        if (semaphore->signals[i].value >= wait->value) {
            *signal = semaphore->signals[i].node;
            return *signal != 0;
        }
    return false;
}

static bool is_free(const struct model *model, const struct model_batch *batch)
{
    node signal;
    for (int i = 0; i < CALL_OPERATIONS && batch->wait[i].semaphore; i++)
        if (!is_over(model, &batch->wait[i], &signal))
            return false;
    return true;
}

static void happen(struct model *model, const struct operation *signal, node when)
{
    struct model_semaphore *semaphore = &model->semaphores[signal->semaphore];
    for (uint32_t i = 0; i < semaphore->signal_count; i++)
        if (semaphore->signals[i].value == signal->value)
            semaphore->signals[i].node = when;
}

static void execute_commands(struct model *model, struct model_batch *batch)
{
    node *builds = &model->queues[batch->queue].builds, *all = &model->queues[batch->queue].all;
    node *signalled = &model->queues[batch->queue].signalled, earlier = *signalled;
    batch->starts = model_add_node(model, *builds);
    *all = model_add_node(model, *all);
    add_edge(model, batch->host, batch->starts);
    add_edge(model, batch->host, *all);
    for (int i = 0; i < CALL_OPERATIONS && batch->wait[i].semaphore; i++) {
        node signal;
        is_over(model, &batch->wait[i], &signal);
        add_edge(model, signal, *all);
        if (batch->wait[i].reach != REACH_NOTHING)
            add_edge(model, signal, batch->starts);
    }
    batch->ends = *builds = model_add_node(model, batch->starts);
    add_edge(model, batch->ends, *all);

    *signalled = model_add_node(model, earlier);
    for (int i = 0; i < CALL_OPERATIONS && batch->signal[i].semaphore; i++) {
        node signal = model_add_node(model, earlier);
        if (batch->signal[i].reach != REACH_NOTHING)
            add_edge(model, batch->signal[i].reach == REACH_ALL ? *all : batch->ends, signal);
        happen(model, &batch->signal[i], signal);
        add_edge(model, signal, *signalled);
    }
    batch->fence = model_add_node(model, *all);
    if (batch->gives_fence)
        add_edge(model, batch->fence, *signalled);
}

static void execute_bindings(struct model *model, struct model_batch *batch)
{
    node *all = &model->queues[batch->queue].all;
    node *signalled = &model->queues[batch->queue].signalled;
    node bound = model_add_node(model, *signalled);
    add_edge(model, batch->host, bound);
    for (int i = 0; i < CALL_OPERATIONS && batch->wait[i].semaphore; i++) {
        node signal;
        is_over(model, &batch->wait[i], &signal);
        add_edge(model, signal, bound);
    }
    for (int i = 0; i < CALL_OPERATIONS && batch->signal[i].semaphore; i++)
        happen(model, &batch->signal[i], bound);
    batch->ends = bound;
    batch->fence = model_add_node(model, bound);
    for (uint32_t i = 0; i < batch->place; i++)
        add_edge(model, (batch - batch->place + i)->ends, batch->fence);
    if (batch->signal[0].semaphore || batch->gives_fence) {
        *signalled = batch->gives_fence ? batch->fence : bound;
        *all = model_add_node(model, *all);
        add_edge(model, *signalled, *all);
    }
}

static bool signals(const struct model_batch *batch)
{
    return batch->has_fence || batch->signal[0].semaphore;
}

/* Whether one that came earlier to the queue is in the way. */
static bool is_behind(const struct model *model, uint32_t queue, uint32_t place)
{
    const uint32_t *waiting = model->queues[queue].waiting;
    const struct model_batch *batch = &model->batches[waiting[place]];
    for (uint32_t i = 0; i < place; i++) {
        const struct model_batch *before = &model->batches[waiting[i]];
        if (batch->kind == SUBMIT_COMMANDS && before->kind == SUBMIT_COMMANDS)
            return true;
        if (signals(batch) && signals(before))
            return true;
    }
    return false;
}

static bool settle_queue(struct model *model, uint32_t queue)
{
    uint32_t *waiting = model->queues[queue].waiting, *count = &model->queues[queue].count;
    bool any = false;
    for (uint32_t i = 0; i < *count;) {
        struct model_batch *batch = &model->batches[waiting[i]];
        if (!is_free(model, batch) || is_behind(model, queue, i)) {
            i++;
            continue;
        }
        memmove(&waiting[i], &waiting[i + 1], (--*count - i) * sizeof(waiting[0]));
        batch->resolved = any = true;
        if (batch->kind == SUBMIT_COMMANDS)
            execute_commands(model, batch);
        else
            execute_bindings(model, batch);
    }
    return any;
}

void model_settle(struct model *model)
{
    bool any = true;
    while (any) {
        any = false;
        for (uint32_t queue = 1; queue <= MODEL_QUEUES; queue++)
            any |= settle_queue(model, queue);
    }
}

void model_signal_on_host(struct model *model, uint32_t semaphore, uint64_t value, node host)
{
    announce(&model->semaphores[semaphore], value);
    happen(model, &(struct operation){semaphore, value, REACH_ALL}, model_add_node(model, host));
}
