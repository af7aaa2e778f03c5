/* SPDX-License-Identifier: Apache-2.0 */
/* Lets the driver build an input in memory of the layer's own, and trace rays through it. */
#ifndef ASSAY_LAYER_COMPARE_TRACER_H
#define ASSAY_LAYER_COMPARE_TRACER_H

#include "layer/compare/structures.h"
#include "src/compare/input.h"
#include "src/compare/trace_data.h"

/* What traces, one a device. Used by one thread at a time. */
struct tracer;
VkResult tracer_create(const struct compare_device *device, struct tracer **tracer);
/* The device is idle by then. */
void tracer_destroy(struct tracer *tracer); /* NULL: nothing */

/* Of a BLAS (`top` is NULL): it is built from the first input; if there is another, then updated
 * from that one. Rays meet it in a TLAS of one instance whose transform is the identity. Of a TLAS:
 * each input is one of the structures that its instances name by number, from 1 on. */
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

/* Submits to the queue and waits, each time 10 seconds at most: VK_TIMEOUT. */
VkResult tracer_run(struct tracer *tracer, const struct tracer_job *job);

#endif
