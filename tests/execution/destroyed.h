/* SPDX-License-Identifier: Apache-2.0 */
/* Programs in which something that a recorded build uses dies: before its submission, or in the
 * twin after it. */
#ifndef ASSAY_TESTS_EXECUTION_DESTROYED_H
#define ASSAY_TESTS_EXECUTION_DESTROYED_H

#include "program.h"

/* An input of a build. */
#define INPUT_DIES(name_, input, action, rule_, path_, shape_)                                     \
    {                                                                                              \
        .name = name_, .steps = STEPS(RECORD_BUILD(A, X, GOOD), action(input), REPORTS, RUN(A)),   \
        .twin = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), IDLE, action(input)), .once = true,        \
        RULE_IS(rule_), .path = (path_), .shape = (shape_), .keeps_place = true                    \
    }

/* An object of an update from X to Y. */
#define UPDATE_LOSES(name_, action, rule_, path_)                                                  \
    {                                                                                              \
        .name = name_,                                                                             \
        .steps = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), RECORD_UPDATE(B, X, Y), IDLE, action,     \
                       REPORTS, RUN(B)),                                                           \
        .twin =                                                                                    \
            STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), RECORD_UPDATE(B, X, Y), RUN(B), IDLE, action), \
        .once = true, RULE_IS(rule_), .path = (path_), .keeps_place = true                         \
    }

#define DST_IS_RECYCLED(rule_, path_)                                                              \
    {                                                                                              \
        .name = "dst_destroyed_and_its_handle_recycled",                                           \
        .steps = STEPS(RECORD_BUILD(A, X, GOOD), DESTROY(X), CREATE(X), REPORTS, RUN(A)),          \
        .twin = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), IDLE, DESTROY(X), CREATE(X)),              \
        .once = true, .needs = NEEDS_RECYCLING, RULE_IS(rule_), .path = (path_),                   \
        .keeps_place = true                                                                        \
    }

#define INDICES_DIE_UNDER_A_SECONDARY(rule_, path_)                                                \
    {                                                                                              \
        .name = "destroyed_under_a_secondary",                                                     \
        .steps = STEPS(RECORD_BUILD(S, X, GOOD), BEGIN(A), EXECUTE(A, S), END(A),                  \
                       DESTROY_INPUT(INDICES), REPORTS, RUN(A)),                                   \
        .twin = STEPS(RECORD_BUILD(S, X, GOOD), BEGIN(A), EXECUTE(A, S), END(A), RUN(A), IDLE,     \
                      DESTROY_INPUT(INDICES)),                                                     \
        .once = true, RULE_IS(rule_), .path = (path_), .keeps_place = true                         \
    }

#endif
