/* SPDX-License-Identifier: Apache-2.0 */
/* A table of operations under one lock. */
#include "src/state/commands/deferred_operations.h"

#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/base/unknown.h"
#include "src/platform/threads.h"

struct operation {
    void *work;      /* NULL: none */
    uint64_t ticket; /* of the work */
    bool has_report; /* something was reported about the command with the work */
};

/* `lock` guards all members but `end`, which is constant. */
struct deferred_operations {
    pthread_mutex_t lock;
    struct handle_table table;
    struct unknown unknown; /* memory ran out for an operation */
    uint64_t last_ticket;
    void (*end)(void *work, VkResult result);
};

static uint64_t key_of(VkDeferredOperationKHR handle)
{
    return handle_number(handle);
}

VkResult deferred_operations_create(struct deferred_operations **operations,
                                    void (*end)(void *work, VkResult result))
{
    *operations = calloc(1, sizeof(**operations));
    if (!*operations)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*operations)->end = end;
    pthread_mutex_init(&(*operations)->lock, NULL);
    return VK_SUCCESS;
}

/* Gives the operation new work, or none (NULL), and ends its previous work. */
static void replace_work(struct deferred_operations *operations, struct operation *operation,
                         void *work, VkResult result)
{
    void *before = operation->work;
    operation->work = work;
    operation->ticket = work ? ++operations->last_ticket : 0;
    operation->has_report = false;
    if (before)
        operations->end(before, result);
}

static void free_operation(void *record, void *context)
{
    replace_work(context, record, NULL, VK_ERROR_UNKNOWN);
    free(record);
}

void deferred_operations_destroy(struct deferred_operations *operations)
{
    if (!operations)
        return;
    handle_table_each(&operations->table, free_operation, operations);
    handle_table_release(&operations->table);
    pthread_mutex_destroy(&operations->lock);
    free(operations);
}

static void remove_locked(struct deferred_operations *operations, VkDeferredOperationKHR handle)
{
    struct operation *operation = handle_table_remove(&operations->table, key_of(handle));
    if (operation)
        free_operation(operation, operations);
}

void deferred_operations_add(struct deferred_operations *operations, VkDeferredOperationKHR handle)
{
    struct operation *operation = calloc(1, sizeof(*operation));
    pthread_mutex_lock(&operations->lock);
    remove_locked(operations, handle);
    if (!operation || !handle_table_set(&operations->table, key_of(handle), operation)) {
        unknown_set(&operations->unknown, UNKNOWN_OPERATIONS);
        free(operation);
    }
    pthread_mutex_unlock(&operations->lock);
}

void deferred_operations_remove(struct deferred_operations *operations,
                                VkDeferredOperationKHR handle)
{
    pthread_mutex_lock(&operations->lock);
    remove_locked(operations, handle);
    pthread_mutex_unlock(&operations->lock);
}

enum tristate deferred_operations_has(struct deferred_operations *operations,
                                      VkDeferredOperationKHR handle)
{
    pthread_mutex_lock(&operations->lock);
    enum tristate has = unknown_is_set(&operations->unknown) ? UNKNOWN : NO;
    if (handle_table_find(&operations->table, key_of(handle)))
        has = YES;
    pthread_mutex_unlock(&operations->lock);
    return has;
}

bool deferred_operations_defer(struct deferred_operations *operations,
                               VkDeferredOperationKHR handle, void *work)
{
    pthread_mutex_lock(&operations->lock);
    struct operation *operation = handle_table_find(&operations->table, key_of(handle));
    if (operation)
        replace_work(operations, operation, work, VK_ERROR_UNKNOWN);
    pthread_mutex_unlock(&operations->lock);
    return operation;
}

void deferred_operations_note_report(struct deferred_operations *operations,
                                     VkDeferredOperationKHR handle)
{
    pthread_mutex_lock(&operations->lock);
    struct operation *operation = handle_table_find(&operations->table, key_of(handle));
    if (operation)
        operation->has_report = true;
    pthread_mutex_unlock(&operations->lock);
}

bool deferred_operations_has_report(struct deferred_operations *operations,
                                    VkDeferredOperationKHR handle)
{
    pthread_mutex_lock(&operations->lock);
    const struct operation *operation = handle_table_find(&operations->table, key_of(handle));
    bool has_report = operation && operation->has_report;
    pthread_mutex_unlock(&operations->lock);
    return has_report;
}

uint64_t deferred_operations_ticket(struct deferred_operations *operations,
                                    VkDeferredOperationKHR handle)
{
    pthread_mutex_lock(&operations->lock);
    const struct operation *operation = handle_table_find(&operations->table, key_of(handle));
    uint64_t ticket = operation ? operation->ticket : 0;
    pthread_mutex_unlock(&operations->lock);
    return ticket;
}

bool deferred_operations_complete(struct deferred_operations *operations,
                                  VkDeferredOperationKHR handle, uint64_t ticket, VkResult result)
{
    pthread_mutex_lock(&operations->lock);
    struct operation *operation = handle_table_find(&operations->table, key_of(handle));
    bool had = ticket && operation && operation->ticket == ticket;
    if (had)
        replace_work(operations, operation, NULL, result);
    pthread_mutex_unlock(&operations->lock);
    return had;
}
