/* SPDX-License-Identifier: Apache-2.0 */
/* What builds of command buffers have read, put to the rules about it once they have executed; at
 * level CONTENT. */
#ifndef ASSAY_LAYER_EXECUTION_CONTENTS_H
#define ASSAY_LAYER_EXECUTION_CONTENTS_H

#include "layer/layer.h"
#include "src/check/replay/contents.h"
#include "src/snapshots/recording.h"

struct batch_run;

/* layer_device.contents; NULL below level CONTENT, and where nothing keeps snapshots. */
VkResult contents_create(struct layer_device *device);
void contents_destroy(struct contents *contents); /* NULL: nothing */

/* These four are called by one thread at a time, with the hooks of the execution order. */

/* A batch is replayed: the notes of its commands, one list each, in the order in which batches run.
 * NULL where nothing is to be noted. */
struct content_notes *contents_note_batch(struct contents *contents, const struct batch_run *run);
/* Those noted last will not run. */
void contents_drop(struct contents *contents);
/* The turn of a batch's command, whose snapshots the execution has; shares that. */
void contents_run(struct contents *contents, const struct batch_run *run, uint32_t command,
                  struct execution *execution);
/* The batch had its turn. */
void contents_end_batch(struct contents *contents, const struct batch_run *run);

/* Reports on the executions that are complete: also before something is destroyed that they may
 * have used. */
void contents_deliver(struct contents *contents);
/* The same, once the first of those that wait is complete; false where none is in a while. */
bool contents_wait(struct contents *contents);

/* ---- for contents_read.c */

/* An execution that had its turn. */
struct ran_execution {
    struct layer_device *device;
    struct execution *execution;
    struct journal *journal;
    VkQueue queue;
    struct content_notes notes;
};
/* Counts it as missed where not all of it could be. */
struct missed_executions;
void contents_read(const struct ran_execution *ran, struct missed_executions *missed);

#endif
