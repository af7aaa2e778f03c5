/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies of the triangles of micromap builds (VK_EXT_opacity_micromap) just before each
 * build. Rules read nothing else of their inputs. */
#include <stdlib.h>

#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/snapshots/build_parameters.h"

/* Returns NULL if a parameter can't be read, or without memory. */
static struct recorded_build *copy_parameters(const VkMicromapBuildInfoEXT *info, uint32_t index)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    if (!build ||
        micromap_info_copy(readable_cache_of_thread(), info, &build->parameters) != VK_SUCCESS) {
        free(build);
        return NULL;
    }
    build->place = recorded_place_of_micromap(index);
    return build;
}

static void copy_triangles(struct recorder *recorder, struct recorded_build *build)
{
    const struct micromap_parameters *micromap = &build->parameters.chained[0].micromap;
    const uint64_t size = micromap_parameters_extent(micromap);
    struct snapshot snapshot;
    if (size && recorder_copy(recorder, micromap->triangles.deviceAddress, size, &snapshot) &&
        !recorded_build_add(build, &snapshot))
        recorder_fail(recorder);
}

/* Timestamps mark calls of builds of structures only. */
void snapshots_build_micromaps(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                               const VkMicromapBuildInfoEXT *infos)
{
    struct recorder recorder;
    if (device->snapshots->are_for_backend || !recorder_begin_other(&recorder, handle))
        return;
    for (uint32_t i = 0; i < count; i++) {
        struct recorded_build *build = copy_parameters(&infos[i], i);
        if (!build)
            continue;
        recorder.left_out = LEFT_OUT_NOTHING;
        copy_triangles(&recorder, build);
        build->left_out = recorder.left_out;
        recorder_keep_build(&recorder, build);
        if (recorder.left_out)
            recording_leave_out(recorder.recording, POSITION_OF_OTHERS, recorder.left_out);
    }
    recorder.build_count = 0;
    recorder_end(&recorder);
    recorder_end_call(&recorder);
}
