/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the builds to be compared, compares them, and reports the differences. */
#include "layer/compare/comparer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "layer/compare/retained_inputs.h"
#include "layer/physical_device.h"
#include "layer/snapshots/snapshots.h"
#include "src/compare/summary.h"
#include "src/model/geometry.h"
#include "src/report/words.h"

/* ---- creation */

static void find_limits(const struct layer_device *device,
                        PFN_vkGetPhysicalDeviceProperties2 get_properties,
                        struct compare_device *driver)
{
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR groups = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR,
        .pNext = driver->has_queries ? NULL : &groups};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &limits};
    get_properties(device->physical_device, &properties);
    uint32_t alignment = limits.minAccelerationStructureScratchOffsetAlignment;
    driver->scratch_alignment = alignment ? alignment : 1;
    driver->group_handle_size = groups.shaderGroupHandleSize;
    driver->group_handle_alignment = groups.shaderGroupHandleAlignment;
    driver->group_base_alignment = groups.shaderGroupBaseAlignment;
}

static bool begin_submission(void *queues, VkQueue queue)
{
    return snapshots_begin_own_submission(queues, queue);
}

static void end_submission(void *queues)
{
    snapshots_end_own_submission(queues);
}

static VkResult begin(const struct layer_device *device, const VkDeviceCreateInfo **info,
                      void **self)
{
    if (!reporter_settings(device->instance->reporter)->compare_rays ||
        !enables_extension(*info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME))
        return VK_SUCCESS;
    struct comparer *comparer = calloc(1, sizeof(*comparer));
    if (!comparer)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    comparer->last = &comparer->builds;
    compare_enabling_begin(device, *info, &comparer->enabling);
    *info = comparer->enabling.info;
    *self = comparer;
    return VK_SUCCESS;
}

static void refuse(void *self)
{
    struct comparer *comparer = self;
    comparer->enabling.is_enabled = false;
}

static VkResult start(struct layer_device *device, void **self)
{
    struct comparer *comparer = *self;
    struct snapshots *snapshots = device->snapshots;
    compare_enabling_end(&comparer->enabling);
    if (!snapshots)
        return VK_INCOMPLETE;
    PFN_vkGetPhysicalDeviceProperties2 get_properties = physical_device_properties2(
        device->instance, &device->instance->vk, device->physical_device);
    if (!comparer->enabling.is_enabled || !get_properties) {
        reporter_warn(device->instance->reporter,
                      "assay_validation.compare_rays needs VK_KHR_ray_query or "
                      "VK_KHR_ray_tracing_pipeline, which the device doesn't have, or which needs "
                      "an application that asks for Vulkan 1.2; no rays are compared.");
        return VK_INCOMPLETE;
    }
    comparer->device = device;
    comparer->driver = (struct compare_device){
        .handle = device->handle,
        .vk = &snapshots->next,
        .memory = &device->memory,
        .set_loader_data = snapshots->set_loader_data,
        .begin_submission = begin_submission,
        .end_submission = end_submission,
        .queues = snapshots,
        .has_queries = comparer->enabling.has_queries,
    };
    find_limits(device, get_properties, &comparer->driver);
    return VK_SUCCESS;
}

static void warn_of_failures(const struct comparer *comparer)
{
    const uint64_t input_unknown = comparer->input_unknown, failed = comparer->failed;
    if (input_unknown + failed == 0)
        return;
    reporter_say_warning(
        comparer->device->instance->reporter,
        "assay_validation.compare_rays: {} builds were not compared: for {} the layer did not "
        "know all of the input, or could not keep it; for {} the driver or the layer had no "
        "memory, or the driver took too long.",
        number(input_unknown + failed), number(input_unknown), number(failed));
}

static void destroy(void *self)
{
    struct comparer *comparer = self;
    compare_enabling_end(&comparer->enabling);
    warn_of_failures(comparer);
    while (comparer->builds) {
        struct retained_build *build = comparer->builds;
        comparer->builds = build->next;
        retained_free_build(build);
    }
    tracer_destroy(comparer->tracer);
    free(comparer->answers);
    free(comparer);
}

/* ---- retaining inputs */

static void *share_input(void *input)
{
    return retained_share(input);
}

static void release_input(void *input)
{
    retained_release(input);
}

static const struct structure_inputs retained_inputs = {share_input, release_input};

/* The ranges of an indirect build are known only after its execution. */
static bool read_parameters(const struct recorded_build *build, const struct input_memory *memory,
                            struct build_parameters *parameters)
{
    const struct build_parameters *given = recorded_build_given(build);
    uint32_t count = given->info.geometryCount;
    *parameters = *given;
    if (!build->is_indirect || count == 0)
        return true;
    parameters->ranges = calloc(count, sizeof(*parameters->ranges));
    if (parameters->ranges)
        recorded_build_read_ranges(build, memory, parameters->ranges);
    return parameters->ranges;
}

static bool has_same_shape(const struct input_copy *a, const struct input_copy *b)
{
    uint32_t count = a->parameters.info.geometryCount;
    if (b->parameters.info.geometryCount != count)
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (a->parameters.ranges[i].primitiveCount != b->parameters.ranges[i].primitiveCount)
            return false;
    return true;
}

static void keep_bottom(struct comparer *comparer, const struct retained_build *build,
                        const struct executed_input *executed, const struct compare_input *input)
{
    const struct journal_entry *entry = executed->entry;
    struct structures *structures = comparer->device->structures;
    bool is_update = build_is_update(&executed->build->parameters.info);
    struct retained_build own = *build;
    own.source = is_update && entry ? structures_find_input(structures, entry->src_id) : NULL;
    own.input = retained_input_create(comparer, input);
    if (entry)
        structures_set_input(structures, entry->dst_id,
                             own.input ? retained_share(own.input) : NULL);
    if (own.input &&
        (!is_update || (own.source && has_same_shape(own.source->copy, own.input->copy)))) {
        retained_add_build(comparer, &own);
        return;
    }
    comparer->input_unknown++;
    retained_release(own.input);
    retained_release(own.source);
}

static bool is_top(const struct build_parameters *build)
{
    return build->info.geometryCount == 1 && type_is_instances(build->geometries[0].geometryType) &&
           !(build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV);
}

static void keep(void *self, const struct executed_input *executed)
{
    struct comparer *comparer = self;
    struct build_parameters parameters;
    if (comparer->is_stopped)
        return;
    const struct recorded_build *recorded = executed->build;
    const struct retained_build build = {.journal = executed->journal,
                                         .submission = executed->batch->origin,
                                         .place = recorded->place};
    const struct build_parameters *given = recorded_build_given(recorded);
    if (given->had_chains || build.place.command == COMMAND_NV ||
        (!reference_supports(given) && !is_top(given))) {
        if (executed->entry)
            structures_set_input(comparer->device->structures, executed->entry->dst_id, NULL);
        return;
    }
    if (!read_parameters(recorded, executed->memory, &parameters)) {
        comparer->failed++;
        return;
    }
    if (is_top(given))
        retained_add_top(comparer, &build, &parameters, executed->memory, executed->destroy_count);
    else
        keep_bottom(comparer, &build, executed,
                    &(struct compare_input){&parameters, executed->memory});
    if (recorded->is_indirect)
        free(parameters.ranges);
}

/* ---- comparing */

void comparer_report(const struct comparer *comparer, const struct retained_build *build,
                     const struct summary *summary)
{
    const struct layer_device *device = comparer->device;
    const uint32_t at = journal_origin_at(build->journal, build->place.position);
    const struct call_origin origin = layer_origin_of(
        device, &build->submission, build->journal, build->place.position - build->place.info, at);
    for (enum difference d = 0; d < DIFFERENCE_COUNT; d++) {
        char words[SUMMARY_TEXT];
        const struct judgement *judgement = &summary->found[d].judgement;
        if (summary->found[d].count == 0 ||
            !reporter_wants_difference(device->instance->reporter, d))
            continue;
        struct finding finding;
        const struct location location = {
            .command = build->place.command,
            .subject = build->top || judgement->reason == REASON_NO_SUCH ? SUBJECT_BUILD
                                                                         : SUBJECT_GEOMETRY,
            .build = build->place.info,
            .geometry = judgement->geometry,
            .geometry_by_pointer = build->place.geometry_by_pointer,
        };
        summary_describe(summary, d, words);
        finding_says(&finding, "", "{}", phrase(words));
        reporter_send_difference(device->instance->reporter, d, &location, &origin, &finding);
    }
}

uint32_t comparer_ray_count(const struct comparer *comparer)
{
    return reporter_settings(comparer->device->instance->reporter)->compare_rays;
}

VkResult comparer_trace(struct comparer *comparer, struct tracer_job *job)
{
    if (!comparer->answers)
        comparer->answers = malloc(comparer_ray_count(comparer) * sizeof(*comparer->answers));
    if (!comparer->answers)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    job->answers = comparer->answers;
    if (!job->ray_count)
        return VK_SUCCESS;
    if (!snapshots_queue_family(comparer->device->snapshots, job->queue, &job->queue_family))
        return VK_ERROR_UNKNOWN;
    VkResult result =
        comparer->tracer ? VK_SUCCESS : tracer_create(&comparer->driver, &comparer->tracer);
    return result == VK_SUCCESS ? tracer_run(comparer->tracer, job) : result;
}

static VkResult compare_to_reference(struct comparer *comparer, const struct retained_build *build,
                                     const struct reference *reference, const struct rays *rays)
{
    const struct compare_input *input = &build->input->copy->input;
    const struct compare_input inputs[2] = {build->source ? build->source->copy->input : *input,
                                            *input};
    struct tracer_job job = {
        .queue = build->submission.queue,
        .input_count = build->source ? 2 : 1,
        .inputs = inputs,
        .ray_count = rays->count,
        .rays = rays->rays,
    };
    VkResult result = comparer_trace(comparer, &job);
    if (result == VK_SUCCESS) {
        struct summary summary;
        summary_make(reference, rays, job.answers, &summary);
        comparer_report(comparer, build, &summary);
    }
    return result;
}

static VkResult compare_bottom(struct comparer *comparer, const struct retained_build *build)
{
    struct reference reference;
    struct rays rays = {0};
    VkResult result = reference_open(build->input->copy, &reference);
    if (result == VK_SUCCESS)
        result = rays_create(&reference, comparer_ray_count(comparer), &rays);
    if (result == VK_SUCCESS)
        result = compare_to_reference(comparer, build, &reference, &rays);
    rays_free(&rays);
    reference_close(&reference);
    return result;
}

/* Returns false, and leaves the build to a later call, if its queue cannot be used now. */
static bool compare_build(struct comparer *comparer, const struct retained_build *build)
{
    if (!begin_submission(comparer->driver.queues, build->submission.queue))
        return false;
    end_submission(comparer->driver.queues); /* the reference and the rays come first */
    VkResult result =
        build->top ? comparer_compare_top(comparer, build) : compare_bottom(comparer, build);
    if (result == VK_NOT_READY)
        return false;
    comparer->input_unknown += result == VK_ERROR_FORMAT_NOT_SUPPORTED;
    comparer->failed += result != VK_SUCCESS && result != VK_ERROR_FORMAT_NOT_SUPPORTED;
    comparer->is_stopped |= result == VK_ERROR_DEVICE_LOST || result == VK_TIMEOUT;
    return true;
}

static void run(void *self)
{
    struct comparer *comparer = self;
    struct retained_build *build;
    while ((build = comparer->builds)) {
        if (comparer->is_stopped)
            comparer->failed++;
        else if (!compare_build(comparer, build))
            break;
        comparer->builds = build->next;
        if (!comparer->builds)
            comparer->last = &comparer->builds;
        retained_free_build(build);
    }
    atomic_store(&comparer->is_postponed, comparer->builds != NULL);
}

static bool is_postponed(const void *self)
{
    const struct comparer *comparer = self;
    return atomic_load(&comparer->is_postponed);
}

const struct consumer comparison = {
    .begin = begin,
    .refuse = refuse,
    .start = start,
    .destroy = destroy,
    .inputs = &retained_inputs,
    .keep = keep,
    .run = run,
    .is_postponed = is_postponed,
};
