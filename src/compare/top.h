/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing top-level builds: instances of bottom-level inputs that are known.
 *
 * What an instance's ray meets is judged in the instance's space, where it is a ray at its BLAS;
 * the rounding of the ray's transform is part of what is open there. */
#ifndef ASSAY_COMPARE_TOP_H
#define ASSAY_COMPARE_TOP_H

#include "src/compare/judge.h"

#define TOP_NO_BOTTOM UINT32_MAX
enum { TOP_INSTANCES_MAX = 65536, TOP_BOTTOMS_MAX = 256 };

struct top_instance {
    VkAccelerationStructureInstanceKHR given; /* its reference is of no meaning here */
    uint32_t bottom;                          /* which of the inputs; or TOP_NO_BOTTOM: inactive */
};

/* Owns nothing. */
struct top_input {
    VkBuildAccelerationStructureFlagsKHR flags;
    VkGeometryFlagsKHR geometry_flags;
    bool array_of_pointers;
    uint32_t count, bottom_count;
    const struct top_instance *instances;
    const struct input_copy *const *bottoms;
};

/* An instance's transform the other way. */
struct top_inverse {
    bool is_usable; /* it is a transform that float arithmetic inverts well, and can be met */
    double matrix[3][3], size; /* `size`: the largest sum of a row, absolute */
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
    uint32_t instance, ray; /* of the rays of its bottom */
};
struct top_rays {
    uint32_t count;
    struct compare_ray *rays;
    struct top_aim *aims;
    struct rays *bottoms; /* in the instances' spaces */
    uint32_t bottom_count;
};
VkResult top_rays_create(const struct top_reference *reference, uint32_t count,
                         struct top_rays *rays);
void top_rays_free(struct top_rays *rays);

bool top_judge_ray(const struct top_reference *reference, const struct top_rays *rays, uint32_t ray,
                   const struct compare_answer *answer, struct judgement *judgement);

#endif
