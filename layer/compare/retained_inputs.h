/* SPDX-License-Identifier: Apache-2.0 */
/* What a comparer keeps: builds that wait to be compared, and the latest input of each structure,
 * for updates of it and for instances. All together are bounded. */
#ifndef ASSAY_LAYER_COMPARE_RETAINED_INPUTS_H
#define ASSAY_LAYER_COMPARE_RETAINED_INPUTS_H

#include "layer/compare/tracer.h"
#include "layer/layer.h"
#include "src/snapshots/recording.h"

#define RETAINED_MAX ((uint64_t)256 << 20) /* bytes of inputs */

/* An input that several may need. */
struct retained_input {
    unsigned references;
    struct input_copy *copy;
};

/* The latest of a structure, by its id, which tells a handle that was reused. */
struct retained_structure {
    uint64_t id, handle;
    struct retained_input *input;
};

/* A structure that was copied from another. */
struct retained_copy {
    uint64_t id, handle, source_id;
};

struct retained_build {
    struct retained_build *next;
    const struct journal *journal;
    struct recorded_place place;
    struct retained_input *input,
        *source;              /* of a BLAS; `source`: what an update is built from first */
    struct retained_top *top; /* of a TLAS */
};

struct comparer {
    struct layer_device *device;
    struct compare_device below;
    struct tracer *tracer; /* made when it is first needed */
    struct retained_build *builds, **last;
    struct handle_table structures; /* of struct retained_structure, by id */
    pthread_mutex_t copies_lock;    /* guards: */
    struct handle_table copies;     /* of struct retained_copy, by id */
    uint64_t retained_size;
    uint64_t not_known, failed; /* builds that were not compared */
    bool is_stopped;            /* the driver has failed */
};

struct retained_input *retained_share(struct retained_input *input);
void retained_release(struct comparer *comparer, struct retained_input *input); /* NULL: nothing */
void retained_free_build(struct comparer *comparer, struct retained_build *build);
void retained_free_structures(struct comparer *comparer);

/* Inputs of structures that are no more are given up where room is needed. */
struct retained_input *retained_input_create(struct comparer *comparer,
                                             const struct compare_input *input);
/* NULL: nothing is known of it any more. Shares the input. Of id 0 nothing is known. */
void retained_set_structure(struct comparer *comparer, uint64_t id, uint64_t handle,
                            struct retained_input *input);
/* Its own, or that of what it was copied from. */
struct retained_input *retained_find_structure(struct comparer *comparer, uint64_t id);

/* Takes over what the build has. */
void retained_add_build(struct comparer *comparer, const struct retained_build *build);

/* A TLAS (tops.c). */
void retained_add_top(struct comparer *comparer, const struct retained_build *build,
                      const struct build_parameters *parameters, const struct input_memory *memory,
                      uint64_t destroy_count);
void retained_free_top(struct comparer *comparer, struct retained_top *top); /* NULL: nothing */
VkResult comparer_compare_top(struct comparer *comparer, const struct retained_build *build,
                              VkQueue queue);

/* For both kinds of build. */
struct summary;
void comparer_report(const struct comparer *comparer, const struct retained_build *build,
                     VkQueue queue, const struct summary *summary);
VkResult comparer_trace(struct comparer *comparer, struct tracer_job *job);

#endif
