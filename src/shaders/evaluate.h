/* SPDX-License-Identifier: Apache-2.0 */
/* The values of one invocation of a shader, as far as they are known. */
#ifndef ASSAY_SHADERS_EVALUATE_H
#define ASSAY_SHADERS_EVALUATE_H

#include "src/shaders/launch.h"
#include "src/shaders/values.h"

struct invocation {
    const struct spirv *spirv;
    const struct shader_launch *launch;
    struct value *values; /* by id: results, and what variables hold */
    uint32_t *arguments;  /* by id of a parameter: what the call passes */
    uint32_t visits;      /* operands whose values were asked for; with too many all are unknown */
};

/* Returns false if memory runs out. */
bool invocation_begin(struct invocation *invocation, const struct spirv *spirv,
                      const struct shader_launch *launch);
void invocation_end(struct invocation *invocation);

/* Returns the value of a constant, or the last one of another id. */
struct value invocation_value(struct invocation *invocation, uint32_t id);
/* Executes an instruction that neither calls nor branches. */
void invocation_execute(struct invocation *invocation, const struct spirv_instruction *instruction);
/* Forgets what an instruction may have changed. */
void invocation_forget(struct invocation *invocation, const struct spirv_instruction *instruction);
void invocation_forget_variables(struct invocation *invocation);

/* Whether the second operand of an instruction is its result. */
bool invocation_defines(const struct invocation *invocation,
                        const struct spirv_instruction *instruction);
/* Returns the variable that a pointer leads into, through parameters; 0: unknown. */
uint32_t invocation_variable(const struct invocation *invocation, uint32_t pointer);

#endif
