/* SPDX-License-Identifier: Apache-2.0 */
/* The builds, copies and queries that were submitted and are not known to be complete: what the
 * device may be executing if it is lost, hangs or crashes, and what structures may be destroyed too
 * early for. From level EXECUTION on. */
#ifndef ASSAY_LAYER_EXECUTION_SUBMITTED_BUILDS_H
#define ASSAY_LAYER_EXECUTION_SUBMITTED_BUILDS_H

#include "layer/layer.h"
#include "layer/snapshots/marks.h"
#include "src/snapshots/recording.h"
#include "src/state/order/order.h"
#include "src/view/life_view.h"

struct submitted_builds;

/* Call once the device has an order. */
VkResult submitted_builds_create(const struct layer_device *device,
                                 struct submitted_builds **submitted);
void submitted_builds_destroy(struct submitted_builds *submitted); /* accepts NULL */

/* Keeps the batches that use structures from their submission on, until the host has observed that
 * they are complete. If they have more than SUBMITTED_MAX such command buffers, the oldest batches
 * are forgotten. */
enum { SUBMITTED_MAX = 1024 };
struct batch_consumer submitted_builds_consumer(struct submitted_builds *submitted);

/* The functions below accept NULL. */

/* The batch is complete. */
void submitted_builds_end(struct submitted_builds *submitted, struct order_batch *batch);

/* Finds a command that was submitted, uses the object, and is certainly not complete as far as the
 * application has observed. Of buffers and memory, the uses are the structures of the command and
 * the inputs and scratch memory of builds of structures. */
bool submitted_builds_find_use(struct submitted_builds *submitted, const struct used_object *object,
                               struct pending_use *use);

/* Notes at the batches that are certainly not complete that an object was destroyed, whose number
 * is `last` (src/state/resources/destroyed.h). */
void submitted_builds_note_destroyed(struct submitted_builds *submitted, uint64_t last);

/* One build. */
struct submitted_build {
    const struct journal *journal; /* of its command buffer, which may be a secondary one */
    const struct journal_entry *entry;
    VkCommandBuffer primary;
    const struct submission_origin *submission;
    enum mark_state state;               /* MARK_IS_UNKNOWN below level CONTENT */
    bool lacks_inputs;                   /* the layer could not copy all of its inputs */
    const struct recorded_build *copies; /* of its inputs, or NULL */
};

/* Calls `visit` for each build in the order of submission, until it returns false. Holds the lock
 * of the batches meanwhile, so `visit` neither calls down nor allocates. Returns false, without a
 * visit, if another thread holds the lock and `waits` is false: then a signal handler may call
 * this. */
bool submitted_builds_each(struct submitted_builds *submitted, bool waits,
                           bool (*visit)(void *user, const struct submitted_build *build),
                           void *user);

/* Starts a walk over the command buffers with builds; its `list` is NULL if there is no walk. */
struct batch_cursor submitted_builds_start(const struct submitted_builds *submitted);

/* A number that changes when the device gets further: when a mark is written. */
uint64_t submitted_builds_progress(struct submitted_builds *submitted);
/* Whether a build with a mark may be incomplete. */
bool submitted_builds_are_pending(struct submitted_builds *submitted);

#endif
