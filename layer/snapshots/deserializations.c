/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies of serialized data just before the command that reads them. */
#include <stdlib.h>

#include "layer/snapshots/recorder.h"
#include "observers.h"

/* Bytes that rules may read: the header, and what its blocks say of some hundred micromaps. What is
 * beyond is unknown. */
enum { COPIED_MAX = 4096 };

static struct recorded_build *create(enum build_command command, const struct deserialization *from)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    struct deserialization *deserialization = malloc(sizeof(*deserialization));
    if (!build || !deserialization) {
        free(build);
        free(deserialization);
        return NULL;
    }
    *deserialization = *from;
    build->deserialization = deserialization;
    build->place = (struct recorded_place){.command = command, .position = POSITION_OF_OTHERS};
    return build;
}

static void copy(struct layer_device *device, VkCommandBuffer handle, enum build_command command,
                 const struct deserialization *deserialization)
{
    struct recorder recorder;
    struct snapshot snapshot;
    if (device->snapshots->are_for_backend || !recorder_begin_other(&recorder, handle))
        return;
    struct recorded_build *build = create(command, deserialization);
    if (build) {
        if (recorder_copy(&recorder, deserialization->address, COPIED_MAX, &snapshot) &&
            !recorded_build_add(build, &snapshot))
            recorder_fail(&recorder);
        recorder_keep_build(&recorder, build);
    }
    recorder_end(&recorder);
    recorder_end_call(&recorder);
}

void snapshots_copy_serialized(struct layer_device *device, VkCommandBuffer handle,
                               const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct accel_facts dst;
    resources_look_up_accel(device->resources, info->dst, &dst);
    const struct deserialization deserialization = {
        .dst = (uint64_t)(uintptr_t)info->dst,
        .dst_size = dst.details_known ? dst.size : 0,
        .address = info->src.deviceAddress,
    };
    copy(device, handle, COMMAND_CmdCopyMemoryToAccelerationStructureKHR, &deserialization);
}

void snapshots_copy_serialized_micromap(struct layer_device *device, VkCommandBuffer handle,
                                        const VkCopyMemoryToMicromapInfoEXT *info)
{
    const struct deserialization deserialization = {
        .dst = (uint64_t)(uintptr_t)info->dst,
        .address = info->src.deviceAddress,
    };
    copy(device, handle, COMMAND_CmdCopyMemoryToMicromapEXT, &deserialization);
}
