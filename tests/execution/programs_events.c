/* SPDX-License-Identifier: Apache-2.0 */
/* Waits for events: where the host may set one after the submission, what it does until then comes
 * before what is behind the wait. */
#include "program.h"

#define AFTER_EVENT(cb, event) RECORD(cb, WAIT_EVENT(cb, event), UPDATE(cb, X, Y))
#define BUILD_AND_SET(cb, event) RECORD(cb, BUILD(cb, X, BAD), SET_EVENT(cb, event))
/* Before it sets the event that the device waits for. */
#define REBUILD_AND_SET(event) HOST_GOOD_X, HOST_SET_EVENT(event), IDLE

static const struct program programs[] = {
    /* The host rebuilds the source, and then sets the event. */
    HOST_PROGRAM("host_rebuilds_before_it_sets", 0, AFTER_EVENT(B, E), HOST_BAD_X, RUN(B),
                 REBUILD_AND_SET(E)),
    HOST_PROGRAM("host_rebuilds_before_it_sets_2", 0,
                 RECORD(B, WAIT_EVENT_BY(B, E, NAME_2), UPDATE(B, X, Y)), HOST_BAD_X, RUN2(B),
                 REBUILD_AND_SET(E)),
    HOST_PROGRAM("host_rebuilds_before_it_sets_2_by_its_older_name", NEEDS_SUBMIT2_KHR,
                 RECORD(B, WAIT_EVENT_BY(B, E, NAME_2KHR), UPDATE(B, X, Y)), HOST_BAD_X,
                 RUN2_KHR(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("host_rebuilds_what_the_device_built_before", 0,
                 RECORD(A, BUILD(A, X, BAD), SET_EVENT(A, F), WAIT_EVENT(A, E), UPDATE(A, X, Y)),
                 RUN(A), REBUILD_AND_SET(E)),
    HOST_PROGRAM("host_rebuilds_what_the_device_built_before_a_copy", 0,
                 RECORD(A, BUILD(A, X, BAD), CLONE(A, X, W), WAIT_EVENT(A, E), CLONE(A, X, Z),
                        UPDATE(A, Z, Y)),
                 RUN(A), REBUILD_AND_SET(E)),
    HOST_PROGRAM("update_in_a_later_batch", 0, RECORD(A, WAIT_EVENT(A, E)), UPDATE_XY(B),
                 HOST_BAD_X, RUN(A), RUN(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("wait_in_a_secondary", 0, RECORD(S, WAIT_EVENT(S, E)),
                 RECORD(A, BUILD(A, X, BAD), EXECUTE(A, S), UPDATE(A, X, Y)), RUN(A),
                 REBUILD_AND_SET(E)),
    HOST_PROGRAM("wait_and_update_in_a_secondary", 0, RECORD(S, WAIT_EVENT(S, E), UPDATE(S, X, Y)),
                 RECORD(A, BUILD(A, X, BAD), EXECUTE(A, S)), RUN(A), REBUILD_AND_SET(E)),
    HOST_PROGRAM("reset_by_the_host", 0, AFTER_EVENT(B, E), HOST_BAD_X, HOST_SET_EVENT(E),
                 HOST_RESET_EVENT(E), RUN(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("reset_by_the_device", NEEDS_NULL_DRIVER,
                 RECORD(B, SET_EVENT(B, E), RESET_EVENT(B, E), WAIT_EVENT(B, E), UPDATE(B, X, Y)),
                 HOST_BAD_X, RUN(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("reset_by_the_device_2", NEEDS_NULL_DRIVER,
                 RECORD(A, SET_EVENT_BY(A, E, NAME_2), RESET_EVENT_BY(A, E, NAME_2)),
                 AFTER_EVENT(B, E), HOST_BAD_X, RUN(A), RUN(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("reset_by_the_device_2_by_its_older_name", NEEDS_NULL_DRIVER | NEEDS_SUBMIT2_KHR,
                 RECORD(A, SET_EVENT_BY(A, E, NAME_2KHR), RESET_EVENT_BY(A, E, NAME_2KHR)),
                 AFTER_EVENT(B, E), HOST_BAD_X, RUN(A), RUN(B), REBUILD_AND_SET(E)),
    HOST_PROGRAM("set_by_a_submission_that_failed", NEEDS_NULL_DRIVER, RECORD(A, SET_EVENT(A, E)),
                 AFTER_EVENT(B, E), HOST_BAD_X, BATCH, WITH(A), FAILED_SUBMIT(0), RUN(B),
                 REBUILD_AND_SET(E)),
    HOST_PROGRAM("host_sets_while_a_reset_may_be_under_way", NEEDS_NULL_DRIVER,
                 RECORD(A, RESET_EVENT(A, E)), AFTER_EVENT(B, E), HOST_BAD_X, RUN(A),
                 HOST_SET_EVENT(E), RUN(B), REBUILD_AND_SET(E)),

    /* The device, or the host before the submission, has set it: nothing comes in between. */
    PROGRAM(
        "set_in_the_command_buffer", 0,
        RECORD(A, BUILD(A, X, BAD), SET_EVENT(A, E), WAIT_EVENT(A, E), REPORTS, UPDATE(A, X, Y))),
    PROGRAM("set_before_in_the_queue", 0, BUILD_AND_SET(A, E), AFTER_EVENT(B, E), RUN(A), REPORTS,
            RUN(B)),
    PROGRAM("set_before_in_the_queue_2", 0, RECORD(A, BUILD(A, X, BAD), SET_EVENT_BY(A, E, NAME_2)),
            RECORD(B, WAIT_EVENT_BY(B, E, NAME_2), RESET_EVENT_BY(B, E, NAME_2), UPDATE(B, X, Y)),
            RUN2(A), REPORTS, RUN2(B)),
    PROGRAM("set_before_in_the_batch", 0, BUILD_AND_SET(A, E), AFTER_EVENT(B, E), BATCH, WITH(A),
            WITH(B), REPORTS, SUBMIT(0)),
    PROGRAM("set_by_a_secondary", 0, RECORD(S, SET_EVENT(S, E)),
            RECORD(A, BUILD(A, X, BAD), EXECUTE(A, S), WAIT_EVENT(A, E), REPORTS, UPDATE(A, X, Y))),
    PROGRAM("set_for_a_secondary", 0, AFTER_EVENT(S, E),
            RECORD(A, BUILD(A, X, BAD), SET_EVENT(A, E), EXECUTE(A, S)), REPORTS, RUN(A)),
    PROGRAM("set_by_the_host_before", 0, BAD_X(A), AFTER_EVENT(B, E), RUN(A), HOST_SET_EVENT(E),
            REPORTS, RUN(B)),
    PROGRAM("set_by_the_device_only", NEEDS_NULL_DRIVER, BUILD_AND_SET(A, G),
            RECORD(C, SET_EVENT(C, E)), AFTER_EVENT(B, G), RUN(A), BATCH, WITH(C), FAILED_SUBMIT(0),
            REPORTS, RUN(B)),
    PROGRAM("long_over", 0, BAD_X(A), RECORD(C, WAIT_EVENT(C, E)), UPDATE_XY(B), RUN(C),
            HOST_SET_EVENT(E), IDLE, RUN(A), REPORTS, RUN(B)),
};

PROGRAM_LIST(event_programs, programs);
