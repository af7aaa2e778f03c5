/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs that a comparer retains: those of builds to be compared, and the latest input of each
 * structure, for its updates and for instances, which belongs to the structure's record
 * (src/state/builds/structures.h). Their total size is bounded. */
#ifndef ASSAY_LAYER_COMPARE_RETAINED_INPUTS_H
#define ASSAY_LAYER_COMPARE_RETAINED_INPUTS_H

#include <stdatomic.h>

#include "layer/compare/enable.h"
#include "layer/compare/tracer.h"
#include "src/snapshots/recording.h"

#define RETAINED_MAX ((uint64_t)256 << 20) /* bytes of inputs */

/* Immutable; freed with the last reference. Any thread may share and release it. */
struct retained_input {
    atomic_uint references;
    struct comparer *comparer;
    struct input_copy *copy;
};

struct retained_build {
    struct retained_build *next;
    struct journal *journal;             /* shared */
    struct submission_origin submission; /* that executed the build; the labels are shared */
    struct recorded_place place;
    /* For a BLAS. An update builds `source` first. */
    struct retained_input *input, *source;
    struct retained_top *top; /* for a TLAS */
};

struct comparer {
    struct compare_enabling enabling; /* until the device is created */
    struct layer_device *device;
    struct compare_device driver;
    struct tracer *tracer;          /* created on first use */
    struct compare_answer *answers; /* for as many rays as the setting says; likewise */
    struct retained_build *builds, **last;
    _Atomic uint64_t retained_size; /* of all inputs; any thread may release some */
    uint64_t input_unknown, failed; /* builds that were not compared */
    bool is_stopped;                /* the driver has failed */
    atomic_bool is_postponed;       /* `builds` wait for their queue */
};

/* Add and remove a reference. The last reference frees the input. */
struct retained_input *retained_share(struct retained_input *input);
void retained_release(struct retained_input *input); /* `input` may be NULL */
void retained_free_build(struct retained_build *build);

/* Copies an input. If the limit is reached, releases the inputs of destroyed structures first.
 * Returns NULL if the limit is still exceeded or memory runs out. */
struct retained_input *retained_input_create(struct comparer *comparer,
                                             const struct compare_input *input);

/* Takes ownership of the members of `build`, and shares the journal and the labels. */
void retained_add_build(struct comparer *comparer, const struct retained_build *build);

/* Reads the instances of a TLAS build and retains the build. Counts the build as not
 * compared if an input is unknown or memory runs out. */
void retained_add_top(struct comparer *comparer, const struct retained_build *build,
                      const struct build_parameters *parameters, const struct input_memory *memory,
                      uint64_t destroy_count);

/* Compares a retained TLAS build. */
VkResult comparer_compare_top(struct comparer *comparer, const struct retained_build *build);

/* For BLAS and TLAS builds. comparer_trace() runs the job, without answers, on the tracer. The
 * answers are valid until the next job. */
struct summary;
void comparer_report(const struct comparer *comparer, const struct retained_build *build,
                     const struct summary *summary);
uint32_t comparer_ray_count(const struct comparer *comparer);
VkResult comparer_trace(struct comparer *comparer, struct tracer_job *job);

#endif
