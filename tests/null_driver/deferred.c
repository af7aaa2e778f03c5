/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations: nothing to do, but done only at the join that the configuration says. */
#include "internal.h"

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of all operations */

VkResult deferred_start(VkDevice device, VkDeferredOperationKHR operation)
{
    struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    if (object == NULL)
        return VK_SUCCESS;
    const uint32_t joins = CONFIG(device)->deferred_joins;
    pthread_mutex_lock(&lock);
    object->deferred.joins_left = joins;
    pthread_mutex_unlock(&lock);
    return joins > 0 ? VK_OPERATION_DEFERRED_KHR : VK_OPERATION_NOT_DEFERRED_KHR;
}

static uint32_t joins_left(VkDeferredOperationKHR operation)
{
    const struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    pthread_mutex_lock(&lock);
    const uint32_t left = object != NULL ? object->deferred.joins_left : 0;
    pthread_mutex_unlock(&lock);
    return left;
}

COMMAND(GetDeferredOperationMaxConcurrencyKHR)
{
    return joins_left(operation);
}

COMMAND(GetDeferredOperationResultKHR)
{
    return joins_left(operation) > 0 ? VK_NOT_READY : VK_SUCCESS;
}

COMMAND(DeferredOperationJoinKHR)
{
    struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    if (object == NULL)
        return VK_SUCCESS;
    pthread_mutex_lock(&lock);
    if (object->deferred.joins_left > 0)
        object->deferred.joins_left--;
    const bool done = object->deferred.joins_left == 0;
    pthread_mutex_unlock(&lock);
    return done ? VK_SUCCESS : VK_THREAD_IDLE_KHR;
}
