/* SPDX-License-Identifier: Apache-2.0 */
/* Programs in which something that a recorded build uses dies: before its submission, or in the
 * twin after it. */
#ifndef ASSAY_TESTS_EXECUTION_DESTROYED_H
#define ASSAY_TESTS_EXECUTION_DESTROYED_H

#include "program.h"

/* An input of a build. */
#define INPUT_DIES(name_, needs_, input, action, rule_, path_, shape_)                             \
    BREAKS_SHAPED(name_, needs_, rule_, path_, (GOOD_X(A), action(input), REPORTS, RUN(A)),        \
                  (GOOD_X(A), RUN(A), IDLE, action(input)), shape_)

/* An object of an update from X to Y. */
#define UPDATE_LOSES(name_, action, rule_, path_)                                                  \
    BREAKS(name_, 0, rule_, path_,                                                                 \
           (GOOD_X(A), RUN(A), UPDATE_XY(B), IDLE, action, REPORTS, RUN(B)),                       \
           (GOOD_X(A), RUN(A), UPDATE_XY(B), RUN(B), IDLE, action))

#define DST_IS_RECYCLED(rule_, path_)                                                              \
    BREAKS("dst_destroyed_and_its_handle_recycled", NEEDS_RECYCLING, rule_, path_,                 \
           (GOOD_X(A), DESTROY(X), CREATE(X), REPORTS, RUN(A)),                                    \
           (GOOD_X(A), RUN(A), IDLE, DESTROY(X), CREATE(X)))

#define INDICES_DIE_UNDER_A_SECONDARY(rule_, path_)                                                \
    BREAKS("destroyed_under_a_secondary", 0, rule_, path_,                                         \
           (GOOD_X(S), RECORD(A, EXECUTE(A, S)), DESTROY_INPUT(INDICES), REPORTS, RUN(A)),         \
           (GOOD_X(S), RECORD(A, EXECUTE(A, S)), RUN(A), IDLE, DESTROY_INPUT(INDICES)))

#endif
