/* SPDX-License-Identifier: Apache-2.0 */
/* Opens and closes scenes for tracing. */
#include "src/cpu/trees/scene.h"

#include "src/cpu/trees/bytes.h"

/* Micromaps are resolved when a ray first meets one, but to the trees that they have now. */
static void open_micromaps(struct cpu_scene *scene)
{
    blas_references_init(&scene->micromaps, scene->device->structures);
    blas_references_hold_all(&scene->micromaps);
    scene->traced.micromaps = blas_references_micromaps(&scene->micromaps);
}

VkResult cpu_scene_open(struct cpu_device *device, uint64_t handle, enum trace_accuracy accuracy,
                        struct cpu_scene *scene)
{
    *scene = (struct cpu_scene){.device = device};
    scene->tree = cpu_structures_tree(device->structures, handle);
    const void *bytes = scene->tree ? cpu_tree_read(scene->tree) : NULL;
    if (!bytes || micromap_is(bytes)) {
        cpu_tree_release(scene->tree);
        return VK_ERROR_VALIDATION_FAILED;
    }
    blas_references_init(&scene->references, device->structures);
    scene->traced = (struct trace_scene){
        .structure = bytes,
        .accuracy = accuracy,
        .resolver = blas_references_collected(&scene->references),
        .counters = &scene->counters,
    };
    if (device->has_micromaps)
        open_micromaps(scene);
    if (blas_references_collect(&scene->references, bytes))
        return VK_SUCCESS;
    cpu_scene_close(scene);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_scene_close(struct cpu_scene *scene)
{
    struct cpu_counters *counters = &scene->device->counters;
    cpu_count(&counters->rays, scene->rays);
    cpu_count(&counters->nodes_visited, scene->counters.nodes);
    cpu_count(&counters->instances_entered, scene->counters.instances);
    cpu_count(&counters->primitives_tested, scene->counters.primitives);
    cpu_count(&counters->exact_calls, scene->counters.exact_calls);
    cpu_count(&counters->micromaps_read, scene->counters.micromaps);
    if (scene->device->has_micromaps)
        blas_references_release(&scene->micromaps);
    blas_references_release(&scene->references);
    cpu_tree_release(scene->tree);
}
