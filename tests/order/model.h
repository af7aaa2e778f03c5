/* SPDX-License-Identifier: Apache-2.0 */
/* An obvious model of execution order: everything that happens is a node of a graph, with an edge
 * from each node that certainly happens before it, and order is a search through the graph. */
#ifndef ORDER_MODEL_H
#define ORDER_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "program.h"

enum {
    MODEL_QUEUES = 4,
    MODEL_SEMAPHORES = 64,
    MODEL_SIGNALS = 64,
    MODEL_BATCHES = 256,
    MODEL_NODES = 4096,
    MODEL_EDGES = 16384,
};

typedef int node; /* 0: none */

/* Operations name semaphores by their index in the model. */
struct model_batch {
    uint32_t name, queue; /* queue: from 1 */
    enum submission_kind kind;
    struct operation wait[CALL_OPERATIONS], signal[CALL_OPERATIONS];
    node host;        /* the host when the call began */
    uint32_t place;   /* among the batches of its call */
    bool has_fence;   /* its call has one, */
    bool gives_fence; /* and this is the last of it */
    bool resolved;
    node starts, ends; /* its work on acceleration structures, or its bindings */
    node fence;
};

struct model_semaphore {
    bool timeline;
    uint64_t initial;
    struct {
        uint64_t value;
        node node; /* 0: has not happened */
    } signals[MODEL_SIGNALS];
    uint32_t signal_count;
};

struct model {
    int first_edge[MODEL_NODES]; /* to the nodes before it; -1: none */
    struct {
        node before;
        int next;
    } edges[MODEL_EDGES];
    int node_count, edge_count;

    node host;
    struct {
        node builds, all, signalled;
        uint32_t waiting[MODEL_BATCHES], count; /* indices of batches */
    } queues[MODEL_QUEUES + 1];
    struct model_semaphore semaphores[MODEL_SEMAPHORES];
    struct model_batch batches[MODEL_BATCHES];
    uint32_t batch_count;
};

void model_start(struct model *model);

/* A call has succeeded that submits the batch. Returns its index. */
uint32_t model_submit(struct model *model, const struct model_batch *batch);

/* Lets happen what can. */
void model_settle(struct model *model);

void model_signal_on_host(struct model *model, uint32_t semaphore, uint64_t value, node host);

/* The host sees the node. */
void model_see(struct model *model, node seen);
node model_add_node(struct model *model, node before);

/* Whether one node certainly happens before another. */
bool model_is_before(const struct model *model, node before, node after);

#endif
