/* SPDX-License-Identifier: Apache-2.0 */
/* TLAS builds: the reference structure over the instances, the rays, and the judgements. */
#include "src/compare/top.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"

/* Instances with a worse conditioned matrix are not judged: a driver's inverse may be
 * inaccurate. */
#define CONDITION_MAX 16.0

/* ---- the reference */

static double row_sum(double matrix[3][3])
{
    double largest = 0;
    for (int row = 0; row < 3; row++) {
        double sum = 0;
        for (int column = 0; column < 3; column++)
            sum += fabs(matrix[row][column]);
        largest = sum > largest ? sum : largest;
    }
    return largest;
}

static void invert(const struct top_instance *instance, struct top_inverse *inverse)
{
    double m[3][3], determinant = 0;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            m[row][column] = instance->given.transform.matrix[row][column];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            inverse->matrix[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    for (int i = 0; i < 3; i++)
        determinant += m[0][i] * inverse->matrix[i][0];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            inverse->matrix[i][j] /= determinant;
    inverse->size = row_sum(inverse->matrix);
    inverse->is_usable = instance->bottom != TOP_NO_BOTTOM && instance->given.mask != 0 &&
                         row_sum(m) * inverse->size <= CONDITION_MAX;
}

static const void *find_bottom(void *context, uint64_t number)
{
    const struct top_reference *reference = context;
    return number && number <= reference->input->bottom_count
               ? reference->bottoms[number - 1].structure
               : NULL;
}

static struct builder_resolver resolver_of(struct top_reference *reference)
{
    return (struct builder_resolver){find_bottom, reference};
}

static void *allocate_top(uint64_t size)
{
    uint64_t room = (size + BUILDER_ALIGNMENT) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    return aligned_allocate(BUILDER_ALIGNMENT, room);
}

static VkResult build_top_reference(const struct builder_input *input,
                                    struct top_reference *reference)
{
    struct builder_sizes sizes;
    if (builder_get_sizes(input, NULL, &sizes) != BUILDER_OK)
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    void *scratch = allocate_top(sizes.build_scratch);
    reference->structure = allocate_top(sizes.structure);
    enum builder_result result = BUILDER_TOO_SMALL;
    if (scratch && reference->structure)
        result = builder_build(input, reference->structure, sizes.structure, scratch,
                               sizes.build_scratch, NULL);
    aligned_free(scratch);
    return result == BUILDER_OK ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static VkResult build_top(struct top_reference *reference)
{
    const struct top_input *input = reference->input;
    VkAccelerationStructureInstanceKHR *instances = calloc(input->count + 1ull, sizeof(*instances));
    if (!instances)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < input->count; i++) {
        uint32_t bottom = input->instances[i].bottom;
        instances[i] = input->instances[i].given;
        instances[i].accelerationStructureReference = bottom == TOP_NO_BOTTOM ? 0 : bottom + 1ull;
    }
    const struct builder_geometry geometry = {
        .type = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .instances = {.data = instances, .size = input->count * sizeof(*instances)},
    };
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = input->count};
    const struct builder_input top = {
        .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
        .quality = BUILDER_BALANCED,
        .geometry_count = 1,
        .geometries = &geometry,
        .ranges = &range,
        .resolver = resolver_of(reference),
    };
    VkResult result = build_top_reference(&top, reference);
    free(instances);
    return result;
}

VkResult top_reference_open(const struct top_input *input, struct top_reference *reference)
{
    *reference = (struct top_reference){
        .input = input,
        .bottoms = calloc(input->bottom_count + 1ull, sizeof(*reference->bottoms)),
        .inverses = calloc(input->count + 1ull, sizeof(*reference->inverses)),
    };
    VkResult result =
        reference->bottoms && reference->inverses ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < input->bottom_count && result == VK_SUCCESS; i++)
        result = reference_open(input->bottoms[i], &reference->bottoms[i]);
    if (result != VK_SUCCESS)
        return result;
    for (uint32_t i = 0; i < input->count; i++)
        invert(&input->instances[i], &reference->inverses[i]);
    return build_top(reference);
}

void top_reference_close(struct top_reference *reference)
{
    for (uint32_t i = 0; reference->bottoms && i < reference->input->bottom_count; i++)
        reference_close(&reference->bottoms[i]);
    free(reference->bottoms);
    free(reference->inverses);
    aligned_free(reference->structure);
    *reference = (struct top_reference){0};
}

/* ---- rays */

static void to_world(const struct top_instance *instance, const struct compare_ray *from,
                     struct compare_ray *to)
{
    *to = *from;
    for (int row = 0; row < 3; row++) {
        const float *m = instance->given.transform.matrix[row];
        double origin = m[3], direction = 0;
        for (int i = 0; i < 3; i++) {
            origin += (double)m[i] * from->origin[i];
            direction += (double)m[i] * from->direction[i];
        }
        to->origin[row] = (float)origin;
        to->direction[row] = (float)direction;
    }
}

static bool is_finite(const struct compare_ray *ray)
{
    double sum = 0, length = 0;
    for (int i = 0; i < 3; i++) {
        sum += fabs((double)ray->origin[i]) + fabs((double)ray->direction[i]);
        length += fabs((double)ray->direction[i]);
    }
    return isfinite(sum) && length > 0;
}

/* Chooses the instance for each ray in turn, and counts the rays per BLAS. */
static void choose_instances(const struct top_reference *reference, uint32_t count,
                             struct top_rays *rays, uint32_t *counts)
{
    uint32_t instances = reference->input->count, at = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t tried = 0;
        while (tried < instances && !reference->inverses[at].is_usable) {
            at = (at + 1) % instances;
            tried++;
        }
        if (tried == instances)
            return;
        rays->aims[rays->count++] =
            (struct top_aim){at, counts[reference->input->instances[at].bottom]++};
        at = (at + 1) % instances;
    }
}

static VkResult make_rays(const struct top_reference *reference, uint32_t *counts,
                          struct top_rays *rays)
{
    const struct top_input *input = reference->input;
    for (uint32_t i = 0; i < rays->bottom_count; i++) {
        VkResult result = counts[i]
                              ? rays_create(&reference->bottoms[i], counts[i], &rays->bottoms[i])
                              : VK_SUCCESS;
        if (result != VK_SUCCESS)
            return result;
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        const struct top_aim aim = rays->aims[i];
        const struct top_instance *instance = &input->instances[aim.instance];
        const struct rays *of_bottom = &rays->bottoms[instance->bottom];
        if (aim.ray >= of_bottom->count)
            continue;
        to_world(instance, &of_bottom->rays[aim.ray], &rays->rays[kept]);
        rays->aims[kept] = aim;
        kept += is_finite(&rays->rays[kept]);
    }
    rays->count = kept;
    return VK_SUCCESS;
}

VkResult top_rays_create(const struct top_reference *reference, uint32_t count,
                         struct top_rays *rays)
{
    uint32_t bottoms = reference->input->bottom_count;
    uint32_t *counts = calloc(bottoms + 1ull, sizeof(*counts));
    *rays = (struct top_rays){
        .rays = calloc(count + 1ull, sizeof(*rays->rays)),
        .aims = calloc(count + 1ull, sizeof(*rays->aims)),
        .bottoms = calloc(bottoms + 1ull, sizeof(*rays->bottoms)),
        .bottom_count = bottoms,
    };
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (counts && rays->rays && rays->aims && rays->bottoms) {
        choose_instances(reference, count, rays, counts);
        result = make_rays(reference, counts, rays);
    }
    free(counts);
    return result;
}

void top_rays_free(struct top_rays *rays)
{
    for (uint32_t i = 0; rays->bottoms && i < rays->bottom_count; i++)
        rays_free(&rays->bottoms[i]);
    free(rays->rays);
    free(rays->aims);
    free(rays->bottoms);
    *rays = (struct top_rays){0};
}

/* ---- judgements */

enum { TOUCHED_MAX = 64 };

struct touched {
    uint32_t instances[TOUCHED_MAX], count;
};

static void touch(struct touched *touched, uint32_t instance)
{
    for (uint32_t i = 0; i < touched->count; i++)
        if (touched->instances[i] == instance)
            return;
    if (touched->count < TOUCHED_MAX)
        touched->instances[touched->count++] = instance;
}

static enum trace_answer note_instance(void *context, struct trace_hit *candidate)
{
    touch(context, candidate->instance);
    return TRACE_IGNORE;
}

static void find_touched(const struct top_reference *reference, const struct compare_ray *from,
                         const struct compare_answer *answer, struct touched *touched)
{
    struct top_reference *context = (struct top_reference *)(uintptr_t)reference;
    const struct trace_scene scene = {.structure = reference->structure,
                                      .accuracy = TRACE_EXACT,
                                      .resolver = resolver_of(context)};
    struct trace_ray ray = {.t_min = from->t_min, .t_max = from->t_max, .cull_mask = 0xff};
    const struct trace_visitor visitor = {note_instance, touched};
    memcpy(ray.origin, from->origin, sizeof(ray.origin));
    memcpy(ray.direction, from->direction, sizeof(ray.direction));
    for (uint32_t i = 0; i < answer->candidate_count && i < COMPARE_CANDIDATES; i++)
        touch(touched, answer->candidates[i].instance);
    if (answer->closest.kind)
        touch(touched, answer->closest.instance);
    trace_candidates(&scene, &ray, &visitor);
}

/* Returns the magnitude of the numbers that the driver rounds. */
static double to_object(const struct top_instance *instance, const struct top_inverse *inverse,
                        const struct compare_ray *from, struct compare_ray *to)
{
    double relative[3], largest = 0;
    *to = *from;
    for (int i = 0; i < 3; i++) {
        double moved = instance->given.transform.matrix[i][3];
        double size = fabs((double)from->origin[i]) + fabs(moved);
        relative[i] = from->origin[i] - moved;
        largest = size > largest ? size : largest;
    }
    for (int row = 0; row < 3; row++) {
        double origin = 0, direction = 0;
        for (int i = 0; i < 3; i++) {
            origin += inverse->matrix[row][i] * relative[i];
            direction += inverse->matrix[row][i] * from->direction[i];
        }
        to->origin[row] = (float)origin;
        to->direction[row] = (float)direction;
    }
    return inverse->size * largest;
}

/* Extracts the part of the driver's answer that concerns one instance. */
static void extract_answer(const struct compare_answer *from, const struct top_instance *instance,
                           uint32_t number, struct compare_answer *to)
{
    bool is_flipped = instance->given.flags & VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR;
    *to = (struct compare_answer){0};
    if (from->candidate_count > COMPARE_CANDIDATES)
        to->flags |= COMPARE_CUT;
    for (uint32_t i = 0; i < from->candidate_count && i < COMPARE_CANDIDATES; i++) {
        if (from->candidates[i].instance != number)
            continue;
        struct compare_hit *hit = &to->candidates[to->candidate_count++];
        *hit = from->candidates[i];
        hit->instance = 0;
        hit->kind ^= is_flipped ? COMPARE_FRONT : 0;
    }
    if (!from->closest.kind)
        return;
    if (from->closest.instance != number) {
        to->flags |= COMPARE_ELSEWHERE;
        return;
    }
    to->closest = from->closest;
    to->closest.instance = 0;
    to->closest.kind ^= is_flipped ? COMPARE_FRONT : 0;
}

static void judge_instance(const struct top_reference *reference, const struct top_rays *rays,
                           uint32_t ray, uint32_t number, const struct compare_answer *answer,
                           struct judgement *judgement)
{
    const struct top_instance *instance = &reference->input->instances[number];
    const struct top_aim *aim = &rays->aims[ray];
    struct compare_ray object;
    struct compare_answer own;
    struct judgement found;
    struct aim at = {.at = AIM_ANYWHERE};
    struct ring ring = {0};
    if (!reference->inverses[number].is_usable)
        return;
    if (aim->instance == number) {
        at = rays->bottoms[instance->bottom].aims[aim->ray];
        ring = rays->bottoms[instance->bottom].rings[aim->ray];
    }
    const double scale =
        to_object(instance, &reference->inverses[number], &rays->rays[ray], &object);
    const struct rays one = {
        .count = 1, .rays = &object, .aims = &at, .rings = &ring, .scale = scale, .is_moved = true};
    extract_answer(answer, instance, number, &own);
    if (is_finite(&object) &&
        judge_ray(&reference->bottoms[instance->bottom], &one, 0, &own, &found) &&
        judgement_outweighs(&found, judgement)) {
        *judgement = found;
        judgement->instance = number;
    }
}

bool top_judge_ray(const struct top_reference *reference, const struct top_rays *rays, uint32_t ray,
                   const struct compare_answer *answer, struct judgement *judgement)
{
    struct touched touched = {.count = 0};
    *judgement = (struct judgement){.difference = DIFFERENCE_COUNT};
    find_touched(reference, &rays->rays[ray], answer, &touched);
    for (uint32_t i = 0; i < touched.count; i++) {
        uint32_t number = touched.instances[i];
        if (number < reference->input->count) {
            judge_instance(reference, rays, ray, number, answer, judgement);
            continue;
        }
        *judgement = (struct judgement){.difference = DIFFERENCE_PRIMITIVE,
                                        .reason = REASON_NO_SUCH,
                                        .instance = number,
                                        .has_driver = true,
                                        .driver = answer->closest};
        return true;
    }
    return judgement->difference != DIFFERENCE_COUNT;
}
