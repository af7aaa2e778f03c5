/* SPDX-License-Identifier: Apache-2.0 */
/* Structures in sparse buffers: what is bound to them when a build executes, which only semaphores,
 * fences and waits of the host put in order with it. */
#include "program.h"

#define SPARSE(structure) DESTROY(structure), CREATE_SPARSE(structure)
/* X in page 0, and a build of it recorded. */
#define BOUND SPARSE(X), BIND(X, 0), IDLE
#define BOUND_AND_RECORDED BOUND, GOOD_X(A)
#define UNBOUND_AND_RECORDED SPARSE(X), GOOD_X(A)
#define RECORD_PAIR(cb) RECORD(cb, BUILD_PAIR(cb, X, Y, GOOD))

/* dst isn't bound when it is built; in the twin it is. */
#define MISSING(name_, needs_, steps_, twin_)                                                      \
    BREAKS(name_, NEEDS_SPARSE | (needs_), RULE_dst_is_backed_by_memory,                           \
           ".dstAccelerationStructure", steps_, twin_)

/* The same of the source of an update from X to Y. */
#define MISSING_SRC(name_, steps_, twin_)                                                          \
    BREAKS(name_, NEEDS_SPARSE, RULE_update_src_is_backed_by_memory, ".srcAccelerationStructure",  \
           steps_, twin_)

/* X and Y are bound to one page when they are built at once; in the twin to two. */
#define SHARED(name_, steps_, twin_)                                                               \
    BREAKS(name_, NEEDS_SPARSE, RULE_dst_and_dst_are_apart, ".dstAccelerationStructure", steps_,   \
           twin_)

/* What is bound isn't known. The driver doesn't look at what a build accesses. */
#define OPEN(name_, needs_, ...)                                                                   \
    {                                                                                              \
        .name = name_, .steps = STEPS(__VA_ARGS__), .once = true,                                  \
        .needs = NEEDS_SPARSE | NEEDS_NULL_DRIVER | (needs_)                                       \
    }

static const struct program programs[] = {
    MISSING("unbound_after_recording", 0, (BOUND_AND_RECORDED, UNBIND(X), IDLE, REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, RUN(A), IDLE, UNBIND(X), IDLE)),
    MISSING("bound_after_recording", 0, (UNBOUND_AND_RECORDED, REPORTS, RUN(A)),
            (UNBOUND_AND_RECORDED, BIND(X, 1), IDLE, RUN(A))),
    MISSING("unbound_after_the_first_submission", 0,
            (BOUND_AND_RECORDED, RUN(A), IDLE, UNBIND(X), IDLE, REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, RUN(A), IDLE, UNBIND(X), IDLE, BIND(X, 1), IDLE, RUN(A))),
    MISSING("unbound_under_a_secondary", 0,
            (BOUND, GOOD_X(S), RECORD(A, EXECUTE(A, S)), UNBIND(X), IDLE, REPORTS, RUN(A)),
            (BOUND, GOOD_X(S), RECORD(A, EXECUTE(A, S)), RUN(A), IDLE, UNBIND(X), IDLE)),
    MISSING("unbound_and_the_queue_idle", 0,
            (BOUND_AND_RECORDED, UNBIND(X), WAIT_QUEUE(0), REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, BIND(X, 1), WAIT_QUEUE(0), RUN(A))),
    MISSING("unbound_and_the_fence_signalled", 0,
            (BOUND_AND_RECORDED, UNBIND_WITH_FENCE(X), WAIT_FENCE, REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, RUN(A), IDLE, UNBIND_WITH_FENCE(X), WAIT_FENCE)),
    MISSING("unbound_before_a_semaphore", 0,
            (BOUND_AND_RECORDED, BATCH, SIGNAL(0), UNBIND(X), RUN_AFTER_REPORTS(A, WAIT(0))),
            (BOUND_AND_RECORDED, BATCH, SIGNAL(0), UNBIND(X), BATCH, WAIT(0), SIGNAL(1), BIND(X, 1),
             RUN_AFTER(A, WAIT(1)))),
    MISSING("unbound_before_a_timeline", 0,
            (BOUND_AND_RECORDED, BATCH, SIGNAL_TO(0, 1), UNBIND(X),
             RUN_AFTER_REPORTS(A, WAIT_FOR(0, 1))),
            (BOUND_AND_RECORDED, RUN_BEFORE(A, SIGNAL_TO(0, 1)), BATCH, WAIT_FOR(0, 1), UNBIND(X))),
    MISSING(
        "unbound_and_the_host_waits", 0,
        (BOUND_AND_RECORDED, BATCH, SIGNAL_TO(0, 1), UNBIND(X), HOST_WAIT(0, 1), REPORTS, RUN(A)),
        (BOUND_AND_RECORDED, BATCH, SIGNAL_TO(0, 1), BIND(X, 1), HOST_WAIT(0, 1), RUN(A))),
    MISSING("unbound_for_another_queue", NEEDS_TWO_QUEUES,
            (BOUND, GOOD_X(P), BATCH, SIGNAL(0), UNBIND(X), RUN_AFTER_REPORTS(P, WAIT(0))),
            (SPARSE(X), GOOD_X(P), BATCH, SIGNAL(0), BIND(X, 0), RUN_AFTER(P, WAIT(0)))),
    MISSING("unbound_through_another_queue", NEEDS_TWO_QUEUES,
            (BOUND_AND_RECORDED, BATCH, SIGNAL(0), UNBIND(X), BATCH, WAIT(0), SIGNAL(1), SUBMIT(1),
             RUN_AFTER_REPORTS(A, WAIT(1))),
            (UNBOUND_AND_RECORDED, BATCH, SIGNAL(0), BIND(X, 0), BATCH, WAIT(0), SIGNAL(1),
             SUBMIT(1), RUN_AFTER(A, WAIT(1)))),
    MISSING("binding_fails", NEEDS_NULL_DRIVER,
            (UNBOUND_AND_RECORDED, FAILED_BIND(X, 0), REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, FAILED_UNBIND(X), RUN(A))),
    /* The batch executes when the binding has. */
    MISSING(
        "unbound_by_what_is_waited_for", NEEDS_TWO_QUEUES,
        (BOUND, GOOD_X(P), RUN_AFTER(P, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), REPORTS_LATE,
         UNBIND(X)),
        (SPARSE(X), GOOD_X(P), RUN_AFTER(P, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), BIND(X, 1))),
    MISSING("unbound_when_the_host_signals", 0,
            (BOUND_AND_RECORDED, BATCH, WAIT_FOR(0, 1), SIGNAL_TO(0, 2), UNBIND(X),
             RUN_AFTER(A, WAIT_FOR(0, 2)), REPORTS_LATE, SIGNAL_FROM_HOST(0, 1)),
            (UNBOUND_AND_RECORDED, BATCH, WAIT_FOR(0, 1), SIGNAL_TO(0, 2), BIND(X, 1),
             RUN_AFTER(A, WAIT_FOR(0, 2)), SIGNAL_FROM_HOST(0, 1))),
    /* On one queue, where each waits for the other. */
    MISSING(
        "unbound_by_what_its_queue_waits_for", NEEDS_NULL_DRIVER,
        (BOUND_AND_RECORDED, RUN_AFTER(A, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), REPORTS_LATE,
         UNBIND(X)),
        (UNBOUND_AND_RECORDED, RUN_AFTER(A, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), BIND(X, 1))),
    MISSING("unbound_after_what_its_queue_waited_for", NEEDS_NULL_DRIVER,
            (BOUND_AND_RECORDED, RUN_AFTER(A, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), BIND(X, 1),
             IDLE, UNBIND(X), IDLE, REPORTS, RUN(A)),
            (BOUND_AND_RECORDED, RUN_AFTER(A, WAIT_FOR(0, 1)), BATCH, SIGNAL_TO(0, 1), BIND(X, 1),
             IDLE, UNBIND(X), IDLE, BIND(X, 0), IDLE, RUN(A))),
    MISSING("unbound_behind_what_its_queue_waits_for", NEEDS_NULL_DRIVER,
            (BOUND_AND_RECORDED, BEGIN(B), END(B), BATCH, WAIT_FOR(0, 1), UNBIND(X),
             RUN_BEFORE(B, SIGNAL_TO(0, 1)), IDLE, REPORTS, RUN(A)),
            (UNBOUND_AND_RECORDED, BEGIN(B), END(B), BATCH, WAIT_FOR(0, 1), BIND(X, 0),
             RUN_BEFORE(B, SIGNAL_TO(0, 1)), IDLE, RUN(A))),

    MISSING_SRC("src_unbound_after_recording",
                (BOUND_AND_RECORDED, RUN(A), UPDATE_XY(B), IDLE, UNBIND(X), IDLE, REPORTS, RUN(B)),
                (BOUND_AND_RECORDED, RUN(A), UPDATE_XY(B), RUN(B), IDLE, UNBIND(X), IDLE)),
    MISSING_SRC("src_unbound_before_a_semaphore",
                (BOUND_AND_RECORDED, RUN(A), UPDATE_XY(B), IDLE, BATCH, SIGNAL(0), UNBIND(X),
                 RUN_AFTER_REPORTS(B, WAIT(0))),
                (BOUND_AND_RECORDED, RUN(A), UPDATE_XY(B), RUN_BEFORE(B, SIGNAL(0)), BATCH, WAIT(0),
                 UNBIND(X))),

    SHARED("one_page_after_recording",
           (SPARSE(X), SPARSE(Y), BIND(X, 0), BIND(Y, 1), IDLE, RECORD_PAIR(A), BIND(Y, 0), IDLE,
            REPORTS, RUN(A)),
           (SPARSE(X), SPARSE(Y), BIND(X, 0), BIND(Y, 1), IDLE, RECORD_PAIR(A), RUN(A), IDLE,
            BIND(Y, 0), IDLE)),
    SHARED("one_page_when_recorded",
           (SPARSE(X), SPARSE(Y), BIND(X, 0), BIND(Y, 0), IDLE, RECORD_PAIR(A), REPORTS, RUN(A)),
           (SPARSE(X), SPARSE(Y), BIND(X, 0), BIND(Y, 0), IDLE, RECORD_PAIR(A), BATCH, SIGNAL(0),
            BIND(Y, 1), RUN_AFTER(A, WAIT(0)))),

    /* Bindings wait for no commands, and commands for no bindings. */
    OPEN("unbound_without_order", 0, BOUND_AND_RECORDED, UNBIND(X), RUN(A)),
    OPEN("unbound_behind_the_submission", 0, BOUND_AND_RECORDED, RUN(A), UNBIND(X)),
    OPEN("bound_without_order", 0, UNBOUND_AND_RECORDED, BIND(X, 0), RUN(A)),
    OPEN("unbound_before_a_semaphore_of_others", 0, BOUND_AND_RECORDED, UNBIND(X), BATCH, SIGNAL(0),
         SUBMIT(0), RUN_AFTER(A, WAIT(0))),
    OPEN("unbound_and_bound_without_order", 0, BOUND_AND_RECORDED, BATCH, SIGNAL(0), UNBIND(X),
         BATCH, SIGNAL(1), BIND(X, 1), BATCH, WAIT(0), WAIT(1), WITH(A), SUBMIT(0)),
    OPEN("bound_again_without_order", 0, BOUND_AND_RECORDED, BATCH, SIGNAL(0), UNBIND(X),
         BIND(X, 1), RUN_AFTER(A, WAIT(0))),
    OPEN("unbound_for_another_queue_without_order", NEEDS_TWO_QUEUES, BOUND, GOOD_X(P), UNBIND(X),
         RUN(P)),
    OPEN("unbound_while_another_queue_is_idle", NEEDS_TWO_QUEUES, BOUND_AND_RECORDED, UNBIND(X),
         WAIT_QUEUE(1), RUN(A)),
    OPEN("src_unbound_without_order", 0, BOUND_AND_RECORDED, RUN(A), UPDATE_XY(B), IDLE, UNBIND(X),
         RUN(B)),
    OPEN("one_page_without_order", 0, SPARSE(X), SPARSE(Y), BIND(X, 0), BIND(Y, 1), IDLE,
         RECORD_PAIR(A), BIND(Y, 0), RUN(A)),
    OPEN("unbound_and_never_submitted", 0, BOUND_AND_RECORDED, UNBIND(X), IDLE),
};

PROGRAM_LIST(sparse_programs, programs);
