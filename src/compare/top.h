/* SPDX-License-Identifier: Apache-2.0 */
/* Compares TLAS builds: instances of BLAS whose inputs are known.
 *
 * Hits are judged in the space of the instance, in which the transformed ray is a ray at the BLAS.
 * The tolerance includes the rounding of that transform. */
#ifndef ASSAY_COMPARE_TOP_H
#define ASSAY_COMPARE_TOP_H

#include "src/compare/judge.h"

#define TOP_NO_BOTTOM UINT32_MAX
enum { TOP_INSTANCES_MAX = 65536, TOP_BOTTOMS_MAX = 256 };

struct top_instance {
    VkAccelerationStructureInstanceKHR given; /* its reference is ignored */
    uint32_t bottom; /* index of the BLAS input, or TOP_NO_BOTTOM for an inactive instance */
};

/* Owns nothing; the caller keeps the arrays alive. */
struct top_input {
    VkBuildAccelerationStructureFlagsKHR flags;
    VkGeometryFlagsKHR geometry_flags;
    bool array_of_pointers;
    uint32_t count, bottom_count;
    const struct top_instance *instances;
    const struct input_copy *const *bottoms;
};

/* The inverse of an instance's transform. */
struct top_inverse {
    /* Float arithmetic inverts the transform accurately, and rays can hit the instance. */
    bool is_usable;
    double matrix[3][3], size; /* `size`: the largest sum of absolute values of a row */
};

struct top_reference {
    const struct top_input *input;
    struct reference *bottoms;
    struct top_inverse *inverses;
    void *structure;
};
/* As reference_open(). */
VkResult top_reference_open(const struct top_input *input, struct top_reference *reference);
void top_reference_close(struct top_reference *reference);

struct top_aim {
    uint32_t instance, ray; /* `ray`: index within the rays of the instance's BLAS */
};
struct top_rays {
    uint32_t count;
    struct compare_ray *rays;
    struct top_aim *aims;
    struct rays *bottoms; /* in the spaces of the instances */
    uint32_t bottom_count;
};
/* As rays_create(): aims at the usable instances in turn. The caller calls top_rays_free(), also
 * after a failure. */
VkResult top_rays_create(const struct top_reference *reference, uint32_t count,
                         struct top_rays *rays);
void top_rays_free(struct top_rays *rays);

/* As judge_ray(). */
bool top_judge_ray(const struct top_reference *reference, const struct top_rays *rays, uint32_t ray,
                   const struct compare_answer *answer, struct judgement *judgement);

#endif
