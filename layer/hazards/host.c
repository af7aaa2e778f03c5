/* SPDX-License-Identifier: Apache-2.0 */
/* Records what host commands access. */
#include "layer/hazards/host.h"

#include "src/state/commands/journal.h"

bool hazards_start_host(struct hazard_recording *recording, struct layer_device *device,
                        const char *name)
{
    if (!device->finds_hazards)
        return false;
    *recording =
        (struct hazard_recording){.device = device, .journal = journal_create(VK_NULL_HANDLE)};
    if (!recording->journal)
        return false;
    host_work_set_journal(recording->journal);
    hazard_recording_command(recording, name, NULL);
    return true;
}

/* Spans of mapped memory behind a pointer; more than these are not recorded. */
struct host_spans {
    struct memory_span spans[4];
    uint32_t count;
};

static void keep_span(void *user, const struct memory_span *span)
{
    struct host_spans *kept = user;
    if (span->memory != memory_of_host() && kept->count < 4)
        kept->spans[kept->count++] = *span;
}

void hazards_add_host(struct hazard_recording *recording, const struct hazard_use *use,
                      const void *pointer, uint64_t size)
{
    struct host_spans kept = {.count = 0};
    struct resources *resources = recording->device->resources;
    if (!pointer || !size)
        return;
    resources_find_host_pieces(resources, pointer, size, keep_span, &kept);
    for (uint32_t i = 0; i < kept.count; i++) {
        const struct memory_span *span = &kept.spans[i];
        const struct hazard_bytes bytes = {
            hazard_memory_id(recording->journal, resources, span->memory), span->begin, span->end};
        hazard_recording_add(recording, use, VK_OBJECT_TYPE_UNKNOWN, 0, &bytes);
    }
}
