/* SPDX-License-Identifier: Apache-2.0 */
/* A command by which the host builds or copies acceleration structures, on its way: what it does to
 * them is a journal of its own, judged before the call and applied when the work has ended, which
 * is after the call or when the operation that it was deferred to completes. */
#ifndef ASSAY_LAYER_INTERCEPTS_HOST_WORK_H
#define ASSAY_LAYER_INTERCEPTS_HOST_WORK_H

#include "layer/layer.h"
#include "src/state/commands/journal.h"

struct host_work {
    struct layer_device *device;
    struct journal *journal; /* NULL below level EXECUTION, and without memory; until prepared */
    struct submission *submission;
};

/* The caller fills the journal next. */
struct host_work host_work_begin(struct layer_device *device);

/* Before the call goes down: judges updates. True: the call is to be skipped, as `skip` or a
 * callback wants, and the work is over. */
bool host_work_prepare(struct host_work *work, bool skip);

/* After the call, with its result, which is returned. */
VkResult host_work_finish(struct host_work *work, VkDeferredOperationKHR operation,
                          VkResult result);

/* What rules may see of the operation that a command is to be deferred to. */
struct deferred_operation_facts host_work_operation_facts(const struct layer_device *device,
                                                          VkDeferredOperationKHR operation);

/* For deferred_operations_create: ends the submission of work that was deferred. */
void host_work_end(void *submission, VkResult result);

#endif
