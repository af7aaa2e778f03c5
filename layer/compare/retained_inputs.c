/* SPDX-License-Identifier: Apache-2.0 */
/* Retains inputs and releases them; TLAS builds with copies of the BLAS that they refer to. */
#include "layer/compare/retained_inputs.h"

#include <stdlib.h>
#include <string.h>

#include "src/compare/summary.h"
#include "src/compare/top.h"
#include "src/model/inputs.h"

void retained_free_top(struct retained_top *top); /* `top` may be NULL */

struct retained_input *retained_share(struct retained_input *input)
{
    atomic_fetch_add_explicit(&input->references, 1, memory_order_relaxed);
    return input;
}

void retained_release(struct retained_input *input)
{
    if (!input || atomic_fetch_sub_explicit(&input->references, 1, memory_order_acq_rel) > 1)
        return;
    atomic_fetch_sub(&input->comparer->retained_size, input->copy->size);
    input_copy_free(input->copy);
    free(input);
}

struct retained_input *retained_input_create(struct comparer *comparer,
                                             const struct compare_input *input)
{
    uint64_t size = compare_input_size(input);
    if (size > RETAINED_MAX)
        return NULL;
    if (comparer->retained_size > RETAINED_MAX - size)
        structures_release_other_inputs(comparer->device->structures);
    if (comparer->retained_size > RETAINED_MAX - size)
        return NULL;
    struct retained_input *retained = calloc(1, sizeof(*retained));
    if (!retained)
        return NULL;
    atomic_init(&retained->references, 1);
    retained->comparer = comparer;
    retained->copy = input_copy_create(input);
    if (!retained->copy) {
        free(retained);
        return NULL;
    }
    atomic_fetch_add(&comparer->retained_size, retained->copy->size);
    return retained;
}

static void release_build(const struct retained_build *build)
{
    retained_release(build->input);
    retained_release(build->source);
    retained_free_top(build->top);
}

void retained_free_build(struct retained_build *build)
{
    release_build(build);
    journal_release(build->journal);
    shared_labels_release(build->submission.labels);
    free(build);
}

void retained_add_build(struct comparer *comparer, const struct retained_build *build)
{
    struct retained_build *own = malloc(sizeof(*own));
    if (!own) {
        comparer->failed++;
        release_build(build);
        return;
    }
    *own = *build;
    own->next = NULL;
    if (own->journal)
        journal_share(own->journal);
    shared_labels_share(own->submission.labels);
    *comparer->last = own;
    comparer->last = &own->next;
}

/* ---- compares TLAS builds, over the layer's own copies of the referenced BLAS */

struct retained_top {
    struct top_input input; /* refers to the members below */
    struct top_instance *instances;
    struct retained_input *bottoms[TOP_BOTTOMS_MAX];
    const struct input_copy *copies[TOP_BOTTOMS_MAX];
};

void retained_free_top(struct retained_top *top)
{
    if (!top)
        return;
    for (uint32_t i = 0; i < top->input.bottom_count; i++)
        retained_release(top->bottoms[i]);
    free(top->instances);
    free(top);
}

/* ---- retaining inputs */

/* Returns the index of an input among the inputs of the TLAS, or TOP_NO_BOTTOM if there are too
 * many. */
static uint32_t add_bottom(struct retained_top *top, struct retained_input *input)
{
    for (uint32_t i = 0; i < top->input.bottom_count; i++)
        if (top->bottoms[i] == input)
            return i;
    if (top->input.bottom_count == TOP_BOTTOMS_MAX)
        return TOP_NO_BOTTOM;
    top->bottoms[top->input.bottom_count] = retained_share(input);
    top->copies[top->input.bottom_count] = input->copy;
    return top->input.bottom_count++;
}

static bool resolve(struct comparer *comparer, uint64_t destroy_count, struct retained_top *top,
                    struct top_instance *instance)
{
    struct accel_facts facts;
    uint64_t reference = instance->given.accelerationStructureReference;
    instance->bottom = TOP_NO_BOTTOM;
    if (!reference)
        return true;
    resources_find_referenced(comparer->device->resources, reference, destroy_count, &facts);
    struct retained_input *input =
        facts.alive == YES ? structures_find_input(comparer->device->structures, facts.id) : NULL;
    if (!input)
        return false;
    instance->bottom = add_bottom(top, input);
    retained_release(input);
    return instance->bottom != TOP_NO_BOTTOM;
}

static bool read_instance(const struct input_memory *memory, uint64_t address,
                          bool array_of_pointers, VkAccelerationStructureInstanceKHR *instance)
{
    const void *bytes;
    if (array_of_pointers) {
        if (memory->find(memory->context, address, sizeof(address), &bytes) < sizeof(address))
            return false;
        memcpy(&address, bytes, sizeof(address));
    }
    if (memory->find(memory->context, address, sizeof(*instance), &bytes) < sizeof(*instance))
        return false;
    memcpy(instance, bytes, sizeof(*instance));
    return true;
}

static bool fill_retained(struct comparer *comparer, const struct build_parameters *parameters,
                          const struct input_memory *memory, uint64_t destroy_count,
                          struct retained_top *top)
{
    const VkAccelerationStructureGeometryKHR *geometry = &parameters->geometries[0];
    const uint32_t count = parameters->ranges[0].primitiveCount;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    inputs_of_geometry(0, geometry, NULL, &parameters->ranges[0], inputs);
    top->input.array_of_pointers = has_instance_pointers(geometry);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t address =
            inputs[0].address.deviceAddress + inputs[0].offset + i * inputs[0].stride;
        struct top_instance *instance = &top->instances[i];
        if (!read_instance(memory, address, top->input.array_of_pointers, &instance->given) ||
            !resolve(comparer, destroy_count, top, instance))
            return false;
    }
    top->input.count = count;
    top->input.flags = parameters->info.flags;
    top->input.geometry_flags = geometry->flags;
    top->input.instances = top->instances;
    top->input.bottoms = top->copies;
    return true;
}

void retained_add_top(struct comparer *comparer, const struct retained_build *build,
                      const struct build_parameters *parameters, const struct input_memory *memory,
                      uint64_t destroy_count)
{
    uint32_t count = parameters->ranges[0].primitiveCount;
    struct retained_top *top = calloc(1, sizeof(*top));
    if (top && count <= TOP_INSTANCES_MAX)
        top->instances = calloc(count + 1ull, sizeof(*top->instances));
    if (!top || !top->instances ||
        !fill_retained(comparer, parameters, memory, destroy_count, top)) {
        comparer->input_unknown++;
        retained_free_top(top);
        return;
    }
    struct retained_build own = *build;
    own.top = top;
    retained_add_build(comparer, &own);
}

/* ---- comparing */

static VkResult compare_top_level(struct comparer *comparer, const struct retained_build *build,
                                  const struct top_reference *reference,
                                  const struct top_rays *rays)
{
    const struct top_input *input = reference->input;
    struct compare_input inputs[TOP_BOTTOMS_MAX];
    VkAccelerationStructureInstanceKHR *instances = calloc(input->count + 1ull, sizeof(*instances));
    if (!instances)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < input->bottom_count; i++)
        inputs[i] = input->bottoms[i]->input;
    for (uint32_t i = 0; i < input->count; i++) {
        uint32_t bottom = input->instances[i].bottom;
        instances[i] = input->instances[i].given;
        instances[i].accelerationStructureReference = bottom == TOP_NO_BOTTOM ? 0 : bottom + 1ull;
    }
    const struct compare_instances top = {
        .count = input->count,
        .instances = instances,
        .array_of_pointers = input->array_of_pointers,
        .flags = input->flags,
        .geometry_flags = input->geometry_flags,
    };
    struct tracer_job job = {
        .queue = build->submission.queue,
        .input_count = input->bottom_count,
        .inputs = inputs,
        .top = &top,
        .ray_count = rays->count,
        .rays = rays->rays,
    };
    VkResult result = comparer_trace(comparer, &job);
    if (result == VK_SUCCESS) {
        struct summary summary;
        summary_make_top(reference, rays, job.answers, &summary);
        comparer_report(comparer, build, &summary);
    }
    free(instances);
    return result;
}

VkResult comparer_compare_top(struct comparer *comparer, const struct retained_build *build)
{
    struct top_reference reference;
    struct top_rays rays = {0};
    VkResult result = top_reference_open(&build->top->input, &reference);
    if (result == VK_SUCCESS)
        result = top_rays_create(&reference, comparer_ray_count(comparer), &rays);
    if (result == VK_SUCCESS)
        result = compare_top_level(comparer, build, &reference, &rays);
    top_rays_free(&rays);
    top_reference_close(&reference);
    return result;
}
