/* SPDX-License-Identifier: Apache-2.0 */
/* Says for messages where a call was made, and where a batch was submitted. */
#include "layer/layer.h"

struct call_origin layer_origin(const struct layer_device *device)
{
    return (struct call_origin){
        .device = device->handle,
        .names = device->names,
        .destroyed = device->destroyed,
        .resources = device->resources,
        .submission.frame = atomic_load(&device->frame),
    };
}

struct call_origin layer_origin_of(const struct layer_device *device,
                                   const struct submission_origin *submission,
                                   const struct journal *journal, uint32_t first_build,
                                   uint32_t entry)
{
    struct call_origin origin = layer_origin(device);
    if (submission->queue)
        origin.submission = *submission;
    origin.command_buffer = journal->command_buffer;
    origin.build_index = first_build;
    origin.labels = journal_labels(journal, entry);
    origin.call_site = journal_site(journal, entry);
    return origin;
}
