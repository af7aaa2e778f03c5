/* SPDX-License-Identifier: Apache-2.0 */
/* The stack of labels; labels and counts by queue. */
#include "src/state/commands/label_stack.h"
#include "src/base/handle.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/base/handle_table.h"
#include "src/platform/threads.h"

static char no_name[] = "";

static void drop_innermost(struct label_stack *stack)
{
    char *name = (char *)stack->labels[--stack->count].pLabelName;
    if (name != no_name)
        free(name);
}

/* Call at the start of each change. */
static void drop_inserted(struct label_stack *stack)
{
    stack->changes++;
    if (stack->inserted)
        drop_innermost(stack);
    stack->inserted = false;
}

static bool has_room(struct label_stack *stack)
{
    return ARRAY_HAS_ROOM(stack->labels, stack->count, stack->capacity);
}

static void append_label(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    char *name = label && label->pLabelName ? strdup(label->pLabelName) : NULL;
    VkDebugUtilsLabelEXT *copy = &stack->labels[stack->count++];
    *copy = (VkDebugUtilsLabelEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
        .pLabelName = name ? name : no_name,
    };
    if (label)
        memcpy(copy->color, label->color, sizeof(copy->color));
}

void label_stack_push(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    drop_inserted(stack);
    /* All labels above one that is left out are left out, too, so that each pop matches its push.
     */
    if (stack->left_out || !has_room(stack)) {
        stack->left_out++;
        return;
    }
    append_label(stack, label);
}

void label_stack_insert(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    drop_inserted(stack);
    if (stack->left_out || !has_room(stack))
        return;
    append_label(stack, label);
    stack->inserted = true;
}

void label_stack_pop(struct label_stack *stack)
{
    drop_inserted(stack);
    if (stack->left_out)
        stack->left_out--;
    else if (stack->count)
        drop_innermost(stack);
}

void label_stack_drop_all(struct label_stack *stack)
{
    while (stack->count)
        drop_innermost(stack);
    free(stack->labels);
    *stack = (struct label_stack){.changes = stack->changes + 1};
}

struct label_stack label_stack_copy(const struct label_stack *stack)
{
    struct label_stack copy = {0};
    for (uint32_t i = 0; i < stack->count && has_room(&copy); i++)
        append_label(&copy, &stack->labels[i]);
    return copy;
}

/* ---- labels and counts by queue */

struct queue_record {
    struct label_stack stack;
    uint64_t submissions;
    struct shared_labels *shared; /* copy of `stack` at its generation `shared_changes`; or NULL */
    uint32_t shared_changes;
};

struct queue_labels {
    pthread_mutex_t lock;
    struct handle_table queues; /* struct queue_record */
};

VkResult queue_labels_create(struct queue_labels **labels)
{
    *labels = calloc(1, sizeof(**labels));
    if (!*labels)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*labels)->lock, NULL);
    return VK_SUCCESS;
}

static void free_record(void *record)
{
    struct queue_record *queue = record;
    label_stack_clear(&queue->stack);
    shared_labels_release(queue->shared);
    free(queue);
}

void queue_labels_destroy(struct queue_labels *labels)
{
    if (!labels)
        return;
    handle_table_drop(&labels->queues, free_record);
    pthread_mutex_destroy(&labels->lock);
    free(labels);
}

struct shared_labels *shared_labels_share(struct shared_labels *labels)
{
    if (labels)
        atomic_fetch_add_explicit(&labels->references, 1, memory_order_relaxed);
    return labels;
}

void shared_labels_release(struct shared_labels *labels)
{
    if (!labels || atomic_fetch_sub(&labels->references, 1) != 1)
        return;
    label_stack_clear(&labels->stack);
    free(labels);
}

/* Returns NULL without memory. */
static struct queue_record *find_or_add_queue(struct queue_labels *labels, VkQueue handle)
{
    uint64_t key = handle_number(handle);
    struct queue_record *queue = key ? handle_table_find(&labels->queues, key) : NULL;
    if (queue || !key)
        return queue;
    queue = calloc(1, sizeof(*queue));
    if (queue && !handle_table_set(&labels->queues, key, queue)) {
        free(queue);
        return NULL;
    }
    return queue;
}

void queue_labels_push(struct queue_labels *labels, VkQueue handle,
                       const VkDebugUtilsLabelEXT *label)
{
    pthread_mutex_lock(&labels->lock);
    struct queue_record *queue = find_or_add_queue(labels, handle);
    if (queue)
        label_stack_push(&queue->stack, label);
    pthread_mutex_unlock(&labels->lock);
}

void queue_labels_insert(struct queue_labels *labels, VkQueue handle,
                         const VkDebugUtilsLabelEXT *label)
{
    pthread_mutex_lock(&labels->lock);
    struct queue_record *queue = find_or_add_queue(labels, handle);
    if (queue)
        label_stack_insert(&queue->stack, label);
    pthread_mutex_unlock(&labels->lock);
}

void queue_labels_pop(struct queue_labels *labels, VkQueue handle)
{
    pthread_mutex_lock(&labels->lock);
    struct queue_record *queue = find_or_add_queue(labels, handle);
    if (queue)
        label_stack_pop(&queue->stack);
    pthread_mutex_unlock(&labels->lock);
}

/* The labels change less often than submissions come, so one copy serves several of them. */
static struct shared_labels *share_open_labels(struct queue_record *queue)
{
    if (!queue->stack.count)
        return NULL;
    if (queue->shared && queue->shared_changes == queue->stack.changes)
        return shared_labels_share(queue->shared);
    shared_labels_release(queue->shared);
    queue->shared = calloc(1, sizeof(*queue->shared));
    if (!queue->shared)
        return NULL;
    atomic_init(&queue->shared->references, 1);
    queue->shared->stack = label_stack_copy(&queue->stack);
    queue->shared_changes = queue->stack.changes;
    return shared_labels_share(queue->shared);
}

struct submission_origin queue_labels_submit(struct queue_labels *labels, VkQueue handle)
{
    struct submission_origin origin = {.queue = handle};
    pthread_mutex_lock(&labels->lock);
    struct queue_record *queue = find_or_add_queue(labels, handle);
    if (queue) {
        origin.number = ++queue->submissions;
        origin.labels = share_open_labels(queue);
    }
    pthread_mutex_unlock(&labels->lock);
    return origin;
}
