/* SPDX-License-Identifier: Apache-2.0 */
/* A host command that builds or copies acceleration structures, from begin to end. Its effects are
 * a journal of its own. The journal is judged before the call. It is applied when the work has
 * ended: after the call, or when the deferred operation completes. */
#ifndef ASSAY_LAYER_INTERCEPTS_HOST_WORK_H
#define ASSAY_LAYER_INTERCEPTS_HOST_WORK_H

#include "layer/layer.h"
#include "src/state/commands/journal.h"

struct host_work {
    struct layer_device *device;
    struct journal *journal; /* NULL below level EXECUTION, and without memory; valid until
                                host_work_prepare() */
    struct submission *submission;
};

/* With setting hazards: the journal of the next host command of this thread, which has what the
 * command accesses. Takes over a reference, which host_work_begin() takes on; accepts NULL. */
void host_work_set_journal(struct journal *journal);

/* The caller then adds entries to the journal, if there is one. */
struct host_work host_work_begin(struct layer_device *device);

/* Adds an entry of this call, if there is a journal. */
void host_work_add(struct host_work *work, struct journal_entry *entry);

/* Called before the call goes down: judges updates. Returns true if the call is to be skipped,
 * because `skip` is set or a callback returned VK_TRUE; the work is then over. */
bool host_work_prepare(struct host_work *work, bool skip);

/* Called after the call with its result. Returns that result. */
VkResult host_work_finish(struct host_work *work, VkDeferredOperationKHR operation,
                          VkResult result);

/* What rules may read about the operation to which a command is deferred. */
struct deferred_operation_facts host_work_operation_facts(const struct layer_device *device,
                                                          VkDeferredOperationKHR operation);

/* Ends the submission of work that was deferred; a parameter of deferred_operations_create(). */
void host_work_end(void *submission, VkResult result);

#endif
