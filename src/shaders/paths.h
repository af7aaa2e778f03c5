/* SPDX-License-Identifier: Apache-2.0 */
/* Whether a command certainly traces rays. Follows one invocation through the code of a shader,
 * with the values that are known: constants, specialization, push constants, and the invocation's
 * own index. If a condition is unknown, both sides are taken. So a trace is certain only if this
 * invocation gets to one, whatever the unknown values are. */
#ifndef ASSAY_SHADERS_PATHS_H
#define ASSAY_SHADERS_PATHS_H

#include "src/shaders/launch.h"
#include "src/shaders/spirv.h"

/* The descriptor of the structure that is traced. */
struct traced_descriptor {
    bool is_known;
    uint32_t set, binding;
    uint32_t element;
};

/* Returns false if a trace is not certain, or memory runs out. `traced`: what the first trace
 * reads. `function`: of the entry point. The specialization's memory is readable. */
bool shader_certainly_traces(const struct spirv *spirv, uint32_t function,
                             const struct shader_launch *launch, struct traced_descriptor *traced);

#endif
