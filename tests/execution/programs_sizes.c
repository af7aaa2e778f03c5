/* SPDX-License-Identifier: Apache-2.0 */
/* Updates of compacted structures: what their destination needs is what a query told, if it told of
 * the build that was compacted. */
#include "program.h"

enum {
    BITS_64 = VK_QUERY_RESULT_64_BIT,
    WAITING = VK_QUERY_RESULT_WAIT_BIT,
    AVAILABILITY = VK_QUERY_RESULT_WITH_AVAILABILITY_BIT,
    PARTIAL = VK_QUERY_RESULT_PARTIAL_BIT,
};

#define RECORD_QUERIED_BUILD(cb, structure)                                                        \
    RECORD(cb, RESET_QUERIES(cb), BUILD(cb, structure, GOOD), QUERY(cb, structure, 0))
#define RECORD_QUERY(cb, structure) RECORD(cb, RESET_QUERIES(cb), QUERY(cb, structure, 0))
#define RECORD_COMPACTION(cb, src, dst) RECORD(cb, COMPACT(cb, src, dst))

/* lavapipe answers with the size that a structure was created with. */
#define FIT(structure) DESTROY(structure), CREATE_FITTING(structure)
/* X, with its size known. */
#define BUILD_AND_READ RECORD_QUERIED_BUILD(A, X), RUN(A), IDLE, READ_QUERIES(BITS_64)
/* Z, a copy of X of the size that is known. */
#define COMPACT_X DESTROY(Z), CREATE_COMPACTED(Z), RECORD_COMPACTION(B, X, Z), RUN(B)
/* Y: of one byte less than the compacted size, or just that. */
#define SHRINK_Y IDLE, DESTROY(Y), CREATE_TOO_SMALL(Y)
#define FIT_Y IDLE, DESTROY(Y), CREATE_COMPACTED(Y)

#define UPDATE_Y(src) RECORD_UPDATE(C, src, Y), RUN(C)
#define UPDATE_Y_REPORTS(src) RECORD_UPDATE(C, src, Y), REPORTS, RUN(C)

/* Reports that Y is too small for an update of Z; the twin fits it. The steps make Z. */
#define TOO_SMALL(name_, needs_, ...)                                                              \
    BREAKS(name_, needs_, RULE_dst_is_large_enough, ".dstAccelerationStructure",                   \
           (FIT(X), __VA_ARGS__, SHRINK_Y, UPDATE_Y_REPORTS(Z)),                                   \
           (FIT(X), __VA_ARGS__, FIT_Y, UPDATE_Y(Z)))

/* Nothing is said of Y, as the size that Z was compacted to isn't known. */
#define NOT_KNOWN(name_, needs_, ...)                                                              \
    {                                                                                              \
        .name = name_, .steps = STEPS(FIT(X), __VA_ARGS__, SHRINK_Y, UPDATE_Y(Z)),                 \
        .needs = (needs_), .once = true, RULE_IS(RULE_dst_is_large_enough)                         \
    }

static const struct program programs[] = {
    TOO_SMALL("read", 0, BUILD_AND_READ, COMPACT_X),
    TOO_SMALL("read_with_availability", 0, RECORD_QUERIED_BUILD(A, X), RUN(A), IDLE,
              READ_QUERIES(BITS_64 | AVAILABILITY), COMPACT_X),
    TOO_SMALL("read_partial_with_availability", 0, RECORD_QUERIED_BUILD(A, X), RUN(A), IDLE,
              READ_QUERIES(BITS_64 | PARTIAL | AVAILABILITY), COMPACT_X),
    TOO_SMALL("read_32_bits", 0, RECORD_QUERIED_BUILD(A, X), RUN(A), IDLE, READ_QUERIES(0),
              COMPACT_X),
    TOO_SMALL("read_32_bits_with_availability", 0, RECORD_QUERIED_BUILD(A, X), RUN(A), IDLE,
              READ_QUERIES(AVAILABILITY), COMPACT_X),
    TOO_SMALL("queried_later", 0, GOOD_X(A), RUN(A), RECORD_QUERY(D, X), RUN(D), IDLE,
              READ_QUERIES(BITS_64), COMPACT_X),
    TOO_SMALL("queried_in_a_secondary", 0, GOOD_X(A), RUN(A), RECORD(S, QUERY(S, X, 0)),
              RECORD(D, RESET_QUERIES(D), EXECUTE(D, S)), RUN(D), IDLE, READ_QUERIES(BITS_64),
              COMPACT_X),
    TOO_SMALL("the_only_query_read_without_a_wait_for_the_batch", 0, RECORD_QUERIED_BUILD(A, X),
              RUN(A), READ_QUERIES(BITS_64 | WAITING), COMPACT_X),
    TOO_SMALL("reset_by_the_host_and_read_without_a_wait", 0, BUILD_AND_READ, HOST_RESET_QUERIES,
              RECORD(D, BUILD(D, X, GOOD), QUERY(D, X, 0)), RUN(D), READ_QUERIES(BITS_64 | WAITING),
              COMPACT_X),
    TOO_SMALL("read_again_after_a_rebuild", 0, BUILD_AND_READ, RUN(A), IDLE, READ_QUERIES(BITS_64),
              COMPACT_X),
    TOO_SMALL("clone_of_the_build", 0, BUILD_AND_READ, RECORD(D, CLONE(D, X, W)), RUN(D),
              DESTROY(Z), CREATE_COMPACTED(Z), RECORD_COMPACTION(B, W, Z), RUN(B)),
    TOO_SMALL("clone_of_the_compacted", 0, BUILD_AND_READ, DESTROY(W), CREATE_COMPACTED(W),
              RECORD_COMPACTION(B, X, W), RUN(B), DESTROY(Z), CREATE_COMPACTED(Z),
              RECORD(D, CLONE(D, W, Z)), RUN(D)),
    TOO_SMALL("compacted_before_it_was_read", 0, RECORD_QUERIED_BUILD(A, X), RUN(A),
              RECORD_COMPACTION(B, X, Z), RUN(B), IDLE, READ_QUERIES(BITS_64)),
    TOO_SMALL("update_of_an_update", 0, BUILD_AND_READ, DESTROY(W), CREATE_COMPACTED(W),
              RECORD_COMPACTION(B, X, W), RUN(B), DESTROY(Z), CREATE_COMPACTED(Z),
              RECORD_UPDATE(D, W, Z), RUN(D)),
    TOO_SMALL("source_rebuilt_after_the_compaction", 0, BUILD_AND_READ, COMPACT_X, GOOD_X(D),
              RUN(D)),
    TOO_SMALL("source_destroyed", 0, BUILD_AND_READ, COMPACT_X, IDLE, DESTROY(X)),
    TOO_SMALL("failed_query", NEEDS_NULL_DRIVER, BUILD_AND_READ, COMPACT_X, RECORD_QUERY(D, W),
              BATCH, WITH(D), FAILED_SUBMIT(0)),
    TOO_SMALL("queried_by_the_host", NEEDS_NULL_DRIVER, GOOD_X(A), RUN(A), IDLE, HOST_QUERY(X),
              COMPACT_X),
    TOO_SMALL("two_queues", NEEDS_TWO_QUEUES, GOOD_X(A),
              RECORD(P, RESET_QUERIES(P), QUERY(P, X, 0)), RUN_BEFORE(A, SIGNAL(0)),
              RUN_AFTER(P, WAIT(0)), IDLE, READ_QUERIES(BITS_64), COMPACT_X),

    BREAKS("in_place", 0, RULE_dst_is_large_enough, ".dstAccelerationStructure",
           (FIT(X), BUILD_AND_READ, DESTROY(Z), CREATE_TOO_SMALL(Z), RECORD_COMPACTION(B, X, Z),
            RUN(B), RECORD_UPDATE(C, Z, Z), REPORTS, RUN(C)),
           (FIT(X), BUILD_AND_READ, COMPACT_X, RECORD_UPDATE(C, Z, Z), RUN(C), IDLE, RUN(C))),

    NOT_KNOWN("never_read", 0, BUILD_AND_READ, GOOD_X(D), RUN(D), COMPACT_X),
    NOT_KNOWN("rebuilt_before_the_compaction", 0, BUILD_AND_READ, RUN(A), IDLE, COMPACT_X),
    NOT_KNOWN("updated_before_the_compaction", 0, BUILD_AND_READ, RECORD_UPDATE(D, X, X), RUN(D),
              COMPACT_X),
    NOT_KNOWN("read_twice_without_a_wait", 0, BUILD_AND_READ, RUN(A),
              READ_QUERIES(BITS_64 | WAITING), COMPACT_X),
    NOT_KNOWN("compacted_twice", 0, BUILD_AND_READ, DESTROY(W), CREATE_COMPACTED(W),
              RECORD_COMPACTION(B, X, W), RUN(B), RECORD_QUERY(D, W), RUN(D), IDLE,
              READ_QUERIES(BITS_64), RECORD(D, COMPACT(D, W, Z)), RUN(D)),
    NOT_KNOWN("query_of_another", 0, BUILD_AND_READ, RUN(A), FIT(W), RECORD_QUERIED_BUILD(D, W),
              RUN(D), IDLE, READ_QUERIES(BITS_64), COMPACT_X),
    NOT_KNOWN("not_ready", NEEDS_NULL_BUILDS, BUILD_AND_READ, RUN(A), IDLE, CANNOT_READ,
              READ_QUERIES(BITS_64), COMPACT_X),
    NOT_KNOWN("not_available", NEEDS_NULL_BUILDS, BUILD_AND_READ, RUN(A), IDLE, CANNOT_READ,
              READ_QUERIES(BITS_64 | AVAILABILITY), COMPACT_X),
    NOT_KNOWN("perhaps_partial", 0, BUILD_AND_READ, RUN(A), IDLE, READ_QUERIES(BITS_64 | PARTIAL),
              COMPACT_X),
    NOT_KNOWN("queried_by_the_host_before_a_rebuild", NEEDS_NULL_DRIVER, GOOD_X(A), RUN(A), IDLE,
              HOST_QUERY(X), RUN(A), COMPACT_X),
    NOT_KNOWN("queried_by_the_host_without_a_wait", NEEDS_NULL_DRIVER, GOOD_X(A), RUN(A),
              HOST_QUERY(X), COMPACT_X),
    NOT_KNOWN("two_queues_without_semaphore", NEEDS_TWO_QUEUES, BUILD_AND_READ, GOOD_X(D),
              RECORD(P, RESET_QUERIES(P), QUERY(P, X, 0)), RUN(D), RUN(P), IDLE,
              READ_QUERIES(BITS_64), COMPACT_X),
};

PROGRAM_LIST(size_programs, programs);
