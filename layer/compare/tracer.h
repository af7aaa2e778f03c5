/* SPDX-License-Identifier: Apache-2.0 */
/* Builds an input with the driver, in memory of the layer, and traces rays through it. */
#ifndef ASSAY_LAYER_COMPARE_TRACER_H
#define ASSAY_LAYER_COMPARE_TRACER_H

#include "layer/compare/structures.h"
#include "src/compare/input.h"
#include "src/compare/rays.h"

/* Owns the pipeline that traces; one per device. Only one thread may use it at a time. */
struct tracer;
/* Creates the tracer; sets `*tracer` to NULL if it fails. */
VkResult tracer_create(const struct compare_device *device, struct tracer **tracer);
/* Waits up to 10 seconds for each submission whose end tracer_run() has not observed. If the device
 * may still use objects then, they stay until the device is destroyed. */
void tracer_destroy(struct tracer *tracer); /* `tracer` may be NULL */

/* A BLAS (`top` is NULL) is built from the first input and, if there is a second input, then
 * updated with that one. Rays are traced through a TLAS of one instance with the identity
 * transform. For a TLAS, each input is a BLAS, and the instances refer to the inputs by number from
 * 1 on. */
struct tracer_job {
    VkQueue queue;
    uint32_t queue_family;
    uint32_t input_count;
    const struct compare_input *inputs;
    const struct compare_instances *top;
    uint32_t ray_count;
    const struct compare_ray *rays;
    struct compare_answer *answers;
};

/* Submits to the queue and waits. Returns VK_TIMEOUT if the end of a submission was not observed
 * within 10 seconds. The tracer then keeps the objects that the submission uses. */
VkResult tracer_run(struct tracer *tracer, const struct tracer_job *job);

#endif
