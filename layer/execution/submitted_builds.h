/* SPDX-License-Identifier: Apache-2.0 */
/* The builds that were submitted and are not known to be complete: what the device may be executing
 * if it is lost, hangs or crashes. From level EXECUTION on. */
#ifndef ASSAY_LAYER_EXECUTION_SUBMITTED_BUILDS_H
#define ASSAY_LAYER_EXECUTION_SUBMITTED_BUILDS_H

#include "layer/layer.h"
#include "layer/snapshots/marks.h"
#include "src/snapshots/recording.h"

struct submitted_builds;

VkResult submitted_builds_create(const struct layer_device *device,
                                 struct submitted_builds **submitted);
void submitted_builds_destroy(struct submitted_builds *submitted); /* accepts NULL */

/* The functions below accept NULL. */

/* Called before a call that submits goes down: keeps each command buffer that has builds, the last
 * SUBMITTED_MAX of them. The call has a number among those of its queue, and labels, which may be
 * NULL. */
enum { SUBMITTED_MAX = 1024 };
void submitted_builds_add(struct submitted_builds *submitted, VkQueue queue, uint64_t submission,
                          struct shared_labels *queue_labels, VkCommandBuffer handle);
/* The call has failed, or was skipped. */
void submitted_builds_remove(struct submitted_builds *submitted, VkQueue queue,
                             uint64_t submission);
/* Called at a batch's execution point: its command buffers are complete when the host has observed
 * its timestamp. */
void submitted_builds_run(struct submitted_builds *submitted, const struct batch_run *run);

/* Called when the host has observed a completion: forgets what is complete. */
void submitted_builds_prune(struct submitted_builds *submitted);

/* The batch with this timestamp is complete, and all that was submitted by the same call. */
void submitted_builds_end(struct submitted_builds *submitted, struct timestamp timestamp);

/* One build. */
struct submitted_build {
    const struct journal *journal; /* of its command buffer, perhaps a secondary one */
    const struct journal_entry *entry;
    VkCommandBuffer primary;
    VkQueue queue;
    uint64_t submission; /* see struct batch_run */
    const struct label_stack *queue_labels;
    enum mark_state state; /* MARK_IS_UNKNOWN below level CONTENT */
    bool lacks_inputs;     /* the layer could not copy all of its inputs */
};

/* Calls `visit` for each build in the order of submission, until it returns false. Holds the lock
 * meanwhile, so `visit` neither calls down nor allocates. Returns false, without a visit, if
 * another thread holds the lock and `waits` is false: then a signal handler may call this. */
bool submitted_builds_each(struct submitted_builds *submitted, bool waits,
                           bool (*visit)(void *user, const struct submitted_build *build),
                           void *user);

/* The n-th command buffer whose batch has not reached its execution point, for example because the
 * call that submits it has not returned: what is needed to validate its inputs. The caller releases
 * the references with submitted_builds_release_unrun(). Returns false if there are fewer. */
struct ran_execution;
bool submitted_builds_find_unrun(struct submitted_builds *submitted, uint32_t n,
                                 struct ran_execution *ran);
void submitted_builds_release_unrun(struct ran_execution *ran);

/* A number that changes when the device gets further: when a mark is written. */
uint64_t submitted_builds_progress(struct submitted_builds *submitted);
/* Whether a build with a mark may be incomplete. */
bool submitted_builds_are_pending(struct submitted_builds *submitted);

#endif
