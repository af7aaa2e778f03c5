/* SPDX-License-Identifier: Apache-2.0 */
/* Programs as data: what an application records and submits, step by step, and where the layer has
 * to speak up.
 *
 * A program is played for each difference between two shapes. BAD builds are of the shape that does
 * not suit the program's updates, GOOD builds and the updates themselves of the one that does. In
 * the twin of a program BAD builds are good, and all is silent. */
#ifndef EXECUTION_PROGRAM_H
#define EXECUTION_PROGRAM_H

#include "shape.h"

/* Command buffers: A to D are primary; P and R primary, for the second queue; S and T secondary. */
enum { A, B, C, D, P, R, S, T, COMMAND_BUFFERS };
/* Structures; all exist when a program starts, and are of a type that fits, or of the generic one.
 */
enum { W, X, Y, Z, STRUCTURES };
/* Queries of compacted sizes; and pages, of which each takes a structure. */
enum { QUERIES = 4, SPARSE_PAGES = 4 };
/* So many binary semaphores, and so many timelines; and one timeline that is shared with others who
 * may signal it, on the null driver. */
enum { QUEUES = 2, SEMAPHORES = 4, FOREIGN = SEMAPHORES };
/* Deferred operations, from 1. */
enum { DEFERRED_OPERATIONS = 2 };
/* Events; only the device can set the last. */
enum { E, F, G, EVENTS };

enum build_shape { GOOD, BAD };
enum use { USE_AGAIN, USE_ONCE, USE_SIMULTANEOUS };
enum command_name { NAME, NAME_2, NAME_2KHR };
enum input { VERTICES, INDICES, TRANSFORMS, BOXES, INSTANCES_INPUT, SCRATCH, RANGES, INPUTS };

enum action {
    ACTION_END_OF_PROGRAM,
    ACTION_REPORTS,      /* the next build or submission breaks the rules */
    ACTION_REPORTS_LATE, /* the next call lets a batch go that breaks them, and can't be skipped */
    /* Recording; `object` is the command buffer. */
    ACTION_BEGIN,
    ACTION_END,
    ACTION_RESET,
    ACTION_RESET_POOL,
    ACTION_REALLOCATE, /* freed, and another allocated in its place */
    ACTION_BUILD,
    ACTION_BUILD_PAIR, /* dst and src, in one call, of one shape */
    ACTION_UPDATE,
    ACTION_CLONE,
    ACTION_COMPACT,
    ACTION_FILL,
    ACTION_EXECUTE, /* dst: the secondary */
    ACTION_RESET_QUERIES,
    ACTION_QUERY,     /* dst: the query; src: the structure */
    ACTION_SET_EVENT, /* dst: an event; detail: enum command_name */
    ACTION_RESET_EVENT,
    ACTION_WAIT_EVENT,
    ACTION_DESTROY_POOL, /* and makes another, with a command buffer */
    /* On the host; `object` is the operation that it is deferred to, or 0; `value` 1: it fails. */
    ACTION_HOST_BUILD,
    ACTION_HOST_BUILD_PAIR,
    ACTION_HOST_UPDATE,
    ACTION_HOST_CLONE,
    ACTION_HOST_COMPACT,
    ACTION_HOST_FILL,
    ACTION_JOIN,            /* object: an operation, in these, too */
    ACTION_ASK,             /* for the result */
    ACTION_FAIL_OPERATION,  /* the next result that is asked for is bad */
    ACTION_RENEW_OPERATION, /* destroyed, and another created */
    /* Submitting. */
    ACTION_BATCH,
    ACTION_WITH, /* object: a command buffer */
    ACTION_WAIT, /* object: a binary semaphore; value: stages, 0 for all */
    ACTION_SIGNAL,
    ACTION_WAIT_FOR, /* object: a timeline, and its value */
    ACTION_SIGNAL_TO,
    ACTION_SUBMIT,        /* object: a queue; value: 1 with the fence */
    ACTION_SUBMIT2,       /* value: 1 by its older name */
    ACTION_LOST_SUBMIT,   /* the device is lost for as long as it takes */
    ACTION_FAIL_SUBMIT,   /* the driver fails the next submission; value 1: of bindings */
    ACTION_FAILED_SUBMIT, /* the submission that the driver fails; object: a queue */
    ACTION_BIND,          /* dst: a structure; value: 1 + a page, or 0; detail 1: with the fence */
    ACTION_FAILED_BIND,
    ACTION_SIGNAL_FROM_HOST, /* object: a timeline, and its value */
    ACTION_HOST_SET_EVENT,   /* object: an event */
    ACTION_HOST_RESET_EVENT,
    ACTION_IDLE,
    ACTION_QUEUE_IDLE, /* object: a queue */
    ACTION_WAIT_FENCE,
    ACTION_POLL_FENCE,
    ACTION_HOST_WAIT, /* object: a timeline, and its value */
    ACTION_HOST_READ, /* object: a timeline */
    /* Queries, by the host. What is read is the compacted size of the program. */
    ACTION_HOST_RESET_QUERIES,
    ACTION_READ_QUERIES, /* value: flags */
    ACTION_CANNOT_READ,  /* the driver says VK_NOT_READY to the next read */
    ACTION_HOST_QUERY,   /* src: the structure */
    /* Objects. */
    ACTION_CREATE, /* a structure, in its old place */
    ACTION_CREATE_GENERIC,
    ACTION_CREATE_FITTING,   /* of the size that a good build needs */
    ACTION_CREATE_COMPACTED, /* of the compacted size, less `value` bytes */
    ACTION_CREATE_SPARSE,    /* in a sparse buffer, of which nothing is bound */
    ACTION_DESTROY,
    ACTION_DESTROY_BUFFER, /* of a structure */
    ACTION_FREE_MEMORY,    /* of a structure */
    ACTION_DESTROY_INPUT,
    ACTION_FREE_INPUT,
    ACTION_RENEW_INPUT, /* the buffer and its memory; where addresses are recycled, at the old one
                         */
};

struct step {
    enum action action;
    unsigned char object, dst, src;
    unsigned char detail; /* enum build_shape, use, command_name, or input */
    uint64_t value;
};

#define STEP(...)                                                                                  \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define BEGIN(cb) STEP(ACTION_BEGIN, cb, 0, 0, USE_AGAIN, 0)
#define BEGIN_ONCE(cb) STEP(ACTION_BEGIN, cb, 0, 0, USE_ONCE, 0)
#define BEGIN_SIMULTANEOUS(cb) STEP(ACTION_BEGIN, cb, 0, 0, USE_SIMULTANEOUS, 0)
#define END(cb) STEP(ACTION_END, cb, 0, 0, 0, 0)
#define RESET(cb) STEP(ACTION_RESET, cb, 0, 0, 0, 0)
#define RESET_POOL(cb) STEP(ACTION_RESET_POOL, cb, 0, 0, 0, 0)
#define REALLOCATE(cb) STEP(ACTION_REALLOCATE, cb, 0, 0, 0, 0)
#define BUILD(cb, dst, shape) STEP(ACTION_BUILD, cb, dst, 0, shape, 0)
#define BUILD_PAIR(cb, first, second, shape) STEP(ACTION_BUILD_PAIR, cb, first, second, shape, 0)
#define HOST_BUILD(dst, shape) STEP(ACTION_HOST_BUILD, 0, dst, 0, shape, 0)
#define HOST_BUILD_PAIR(first, second, shape)                                                      \
    STEP(ACTION_HOST_BUILD_PAIR, 0, first, second, shape, 0)
#define HOST_BUILD_FAILS(dst, shape) STEP(ACTION_HOST_BUILD, 0, dst, 0, shape, 1)
#define HOST_UPDATE(src, dst) STEP(ACTION_HOST_UPDATE, 0, dst, src, GOOD, 0)
#define HOST_CLONE(src, dst) STEP(ACTION_HOST_CLONE, 0, dst, src, 0, 0)
#define HOST_COMPACT(src, dst) STEP(ACTION_HOST_COMPACT, 0, dst, src, 0, 0)
#define HOST_FILL(dst) STEP(ACTION_HOST_FILL, 0, dst, 0, 0, 0)
#define DEFERRED_BUILD(operation, dst, shape) STEP(ACTION_HOST_BUILD, operation, dst, 0, shape, 0)
#define DEFERRED_UPDATE(operation, src, dst) STEP(ACTION_HOST_UPDATE, operation, dst, src, GOOD, 0)
#define DEFERRED_CLONE(operation, src, dst) STEP(ACTION_HOST_CLONE, operation, dst, src, 0, 0)
#define DEFERRED_FILL(operation, dst) STEP(ACTION_HOST_FILL, operation, dst, 0, 0, 0)
#define JOIN(operation) STEP(ACTION_JOIN, operation, 0, 0, 0, 0)
#define ASK(operation) STEP(ACTION_ASK, operation, 0, 0, 0, 0)
#define FAIL_OPERATION STEP(ACTION_FAIL_OPERATION, 0, 0, 0, 0, 0)
#define RENEW_OPERATION(operation) STEP(ACTION_RENEW_OPERATION, operation, 0, 0, 0, 0)
#define DESTROY_POOL(cb) STEP(ACTION_DESTROY_POOL, cb, 0, 0, 0, 0)
#define UPDATE(cb, src, dst) STEP(ACTION_UPDATE, cb, dst, src, GOOD, 0)
#define CLONE(cb, src, dst) STEP(ACTION_CLONE, cb, dst, src, 0, 0)
#define COMPACT(cb, src, dst) STEP(ACTION_COMPACT, cb, dst, src, 0, 0)
#define FILL(cb, dst) STEP(ACTION_FILL, cb, dst, 0, 0, 0)
#define RESET_QUERIES(cb) STEP(ACTION_RESET_QUERIES, cb, 0, 0, 0, 0)
#define QUERY(cb, structure, query) STEP(ACTION_QUERY, cb, query, structure, 0, 0)
#define SET_EVENT(cb, event) STEP(ACTION_SET_EVENT, cb, event, 0, NAME, 0)
#define SET_EVENT_BY(cb, event, name) STEP(ACTION_SET_EVENT, cb, event, 0, name, 0)
#define RESET_EVENT(cb, event) STEP(ACTION_RESET_EVENT, cb, event, 0, NAME, 0)
#define RESET_EVENT_BY(cb, event, name) STEP(ACTION_RESET_EVENT, cb, event, 0, name, 0)
#define WAIT_EVENT(cb, event) STEP(ACTION_WAIT_EVENT, cb, event, 0, NAME, 0)
#define WAIT_EVENT_BY(cb, event, name) STEP(ACTION_WAIT_EVENT, cb, event, 0, name, 0)
#define HOST_QUERY(structure) STEP(ACTION_HOST_QUERY, 0, 0, structure, 0, 0)
#define HOST_RESET_QUERIES STEP(ACTION_HOST_RESET_QUERIES, 0, 0, 0, 0, 0)
#define READ_QUERIES(flags) STEP(ACTION_READ_QUERIES, 0, 0, 0, 0, flags)
#define CANNOT_READ STEP(ACTION_CANNOT_READ, 0, 0, 0, 0, 0)
#define EXECUTE(cb, secondary) STEP(ACTION_EXECUTE, cb, secondary, 0, 0, 0)
#define BATCH STEP(ACTION_BATCH, 0, 0, 0, 0, 0)
#define WITH(cb) STEP(ACTION_WITH, cb, 0, 0, 0, 0)
#define WAIT(semaphore) STEP(ACTION_WAIT, semaphore, 0, 0, 0, 0)
#define WAIT_AT(semaphore, stages) STEP(ACTION_WAIT, semaphore, 0, 0, 0, stages)
#define SIGNAL_AFTER(semaphore, stages) STEP(ACTION_SIGNAL, semaphore, 0, 0, 0, stages)
#define SIGNAL(semaphore) STEP(ACTION_SIGNAL, semaphore, 0, 0, 0, 0)
#define WAIT_FOR(timeline, value) STEP(ACTION_WAIT_FOR, timeline, 0, 0, 0, value)
#define SIGNAL_TO(timeline, value) STEP(ACTION_SIGNAL_TO, timeline, 0, 0, 0, value)
#define SUBMIT(queue) STEP(ACTION_SUBMIT, queue, 0, 0, 0, 0)
#define SUBMIT_WITH_FENCE(queue) STEP(ACTION_SUBMIT, queue, 0, 0, 0, 1)
#define SUBMIT2(queue) STEP(ACTION_SUBMIT2, queue, 0, 0, 0, 0)
#define SUBMIT2_KHR(queue) STEP(ACTION_SUBMIT2, queue, 0, 0, 0, 1)
#define LOST_SUBMIT(queue) STEP(ACTION_LOST_SUBMIT, queue, 0, 0, 0, 0)
#define FAILED_SUBMIT(queue)                                                                       \
    STEP(ACTION_FAIL_SUBMIT, 0, 0, 0, 0, 0), STEP(ACTION_FAILED_SUBMIT, queue, 0, 0, 0, 0)
/* On the first queue, by the semaphores of the batch that is being put together, if any is. */
#define BIND(structure, page) STEP(ACTION_BIND, 0, structure, 0, 0, 1 + (page))
#define UNBIND(structure) STEP(ACTION_BIND, 0, structure, 0, 0, 0)
#define UNBIND_WITH_FENCE(structure) STEP(ACTION_BIND, 0, structure, 0, 1, 0)
#define FAILED_BIND(structure, page)                                                               \
    STEP(ACTION_FAIL_SUBMIT, 0, 0, 0, 0, 1),                                                       \
        STEP(ACTION_FAILED_BIND, 0, structure, 0, 0, 1 + (page))
#define FAILED_UNBIND(structure)                                                                   \
    STEP(ACTION_FAIL_SUBMIT, 0, 0, 0, 0, 1), STEP(ACTION_FAILED_BIND, 0, structure, 0, 0, 0)
#define SIGNAL_FROM_HOST(timeline, value) STEP(ACTION_SIGNAL_FROM_HOST, timeline, 0, 0, 0, value)
#define HOST_SET_EVENT(event) STEP(ACTION_HOST_SET_EVENT, event, 0, 0, 0, 0)
#define HOST_RESET_EVENT(event) STEP(ACTION_HOST_RESET_EVENT, event, 0, 0, 0, 0)
#define IDLE STEP(ACTION_IDLE, 0, 0, 0, 0, 0)
#define WAIT_QUEUE(queue) STEP(ACTION_QUEUE_IDLE, queue, 0, 0, 0, 0)
#define WAIT_FENCE STEP(ACTION_WAIT_FENCE, 0, 0, 0, 0, 0)
#define POLL_FENCE STEP(ACTION_POLL_FENCE, 0, 0, 0, 0, 0)
#define HOST_WAIT(timeline, value) STEP(ACTION_HOST_WAIT, timeline, 0, 0, 0, value)
#define HOST_READ(timeline) STEP(ACTION_HOST_READ, timeline, 0, 0, 0, 0)
#define CREATE(structure) STEP(ACTION_CREATE, structure, 0, 0, 0, 0)
#define CREATE_GENERIC(structure) STEP(ACTION_CREATE_GENERIC, structure, 0, 0, 0, 0)
#define CREATE_FITTING(structure) STEP(ACTION_CREATE_FITTING, structure, 0, 0, 0, 0)
#define CREATE_COMPACTED(structure) STEP(ACTION_CREATE_COMPACTED, structure, 0, 0, 0, 0)
#define CREATE_TOO_SMALL(structure) STEP(ACTION_CREATE_COMPACTED, structure, 0, 0, 0, 1)
#define CREATE_SPARSE(structure) STEP(ACTION_CREATE_SPARSE, structure, 0, 0, 0, 0)
#define DESTROY(structure) STEP(ACTION_DESTROY, structure, 0, 0, 0, 0)
#define DESTROY_BUFFER(structure) STEP(ACTION_DESTROY_BUFFER, structure, 0, 0, 0, 0)
#define FREE_MEMORY(structure) STEP(ACTION_FREE_MEMORY, structure, 0, 0, 0, 0)
#define DESTROY_INPUT(input) STEP(ACTION_DESTROY_INPUT, 0, 0, 0, input, 0)
#define FREE_INPUT(input) STEP(ACTION_FREE_INPUT, 0, 0, 0, input, 0)
#define RENEW_INPUT(input) STEP(ACTION_RENEW_INPUT, 0, 0, 0, input, 0)
#define REPORTS_LATE STEP(ACTION_REPORTS_LATE, 0, 0, 0, 0, 0)
#define REPORTS STEP(ACTION_REPORTS, 0, 0, 0, 0, 0)

/* A command buffer with some steps in it, or with one, and submissions of one. */
#define RECORD(cb, ...) BEGIN(cb), __VA_ARGS__, END(cb)
#define RECORD_BUILD(cb, dst, shape) RECORD(cb, BUILD(cb, dst, shape))
#define RECORD_UPDATE(cb, src, dst) RECORD(cb, UPDATE(cb, src, dst))
/* Builds of X, and updates from X to Y: each recorded by itself, or made by the host. */
#define GOOD_X(cb) RECORD_BUILD(cb, X, GOOD)
#define BAD_X(cb) RECORD_BUILD(cb, X, BAD)
#define UPDATE_XY(cb) RECORD_UPDATE(cb, X, Y)
#define HOST_GOOD_X HOST_BUILD(X, GOOD)
#define HOST_BAD_X HOST_BUILD(X, BAD)
#define HOST_UPDATE_XY HOST_UPDATE(X, Y)
/* A bad build in one, an update in the other. */
#define RECORD_BAD(builds, updates) BAD_X(builds), UPDATE_XY(updates)
#define QUEUE_OF(cb) ((cb) == P || (cb) == R)
#define RUN(cb) BATCH, WITH(cb), SUBMIT(QUEUE_OF(cb))
#define RUN2(cb) BATCH, WITH(cb), SUBMIT2(QUEUE_OF(cb))
#define RUN2_KHR(cb) BATCH, WITH(cb), SUBMIT2_KHR(QUEUE_OF(cb))
/* The batch signals, or waits. */
#define RUN_BEFORE(cb, signal) BATCH, WITH(cb), signal, SUBMIT(QUEUE_OF(cb))
#define RUN_AFTER(cb, wait) BATCH, wait, WITH(cb), SUBMIT(QUEUE_OF(cb))
#define RUN_AFTER_REPORTS(cb, wait) BATCH, wait, WITH(cb), REPORTS, SUBMIT(QUEUE_OF(cb))
#define RUN2_BEFORE(cb, signal) BATCH, WITH(cb), signal, SUBMIT2(QUEUE_OF(cb))
#define RUN2_AFTER(cb, wait) BATCH, wait, WITH(cb), SUBMIT2(QUEUE_OF(cb))
#define RUN2_AFTER_REPORTS(cb, wait) BATCH, wait, WITH(cb), REPORTS, SUBMIT2(QUEUE_OF(cb))

#define STEPS(...) ((const struct step[]){__VA_ARGS__, {ACTION_END_OF_PROGRAM, 0, 0, 0, 0, 0}})

enum needs {
    NEEDS_NULL_DRIVER = 1 << 0,
    NEEDS_TWO_QUEUES = 1 << 1,
    NEEDS_RECYCLING = 1 << 2, /* of handles and addresses; null driver only */
    NEEDS_HOST = 1 << 3,      /* its commands */
    /* Null driver only: */
    NEEDS_NO_DEFERRAL = 1 << 4,
    NEEDS_LONG_JOINS = 1 << 5, /* the second completes an operation */
    NEEDS_LOSS = 1 << 6,       /* of the device */
    NEEDS_SUBMIT2_KHR = 1 << 7,
    NEEDS_EXTENSIONS = 1 << 8, /* those that add inputs; and dense data where boxes are */
    /* A driver that does what it is told, fails when it is told to, and looks at nothing. Backend
     * cpu refuses what it can't carry out. */
    NEEDS_DRIVER = 1 << 9,
    NEEDS_NULL_BUILDS = NEEDS_NULL_DRIVER | NEEDS_DRIVER,
    NEEDS_NULL_QUEUES = NEEDS_NULL_DRIVER | NEEDS_TWO_QUEUES,
    NEEDS_SPARSE = 1 << 10, /* buffers, whose pages the first queue binds */
    /* A level below content, which would say that it can't look at all of it. */
    NEEDS_NO_LOOK = 1 << 11,
};

struct program {
    const char *name;
    const struct step *steps;
    const struct step *twin; /* NULL: the same, with good builds; unused where nothing reports */
    uint32_t needs;          /* enum needs */
    bool once;               /* to be played for a plain shape only, not for each difference */
    /* Rules other than those of the difference, and where. */
    enum rule rule;
    bool has_rule;
    const char *path;            /* below pInfos[0], or another parameter */
    struct shape (*shape)(void); /* of GOOD builds and updates; NULL: the difference's */
    struct shape (*bad)(void);   /* of BAD builds; NULL: the difference's */
    bool keeps_place;            /* what is reported names no earlier build */
};

#define RULE_IS(rule_) .rule = (rule_), .has_rule = true

/* A program of steps that is played for each difference. */
#define PROGRAM(name_, needs_, ...)                                                                \
    {                                                                                              \
        .name = name_, .needs = (needs_), .steps = STEPS(__VA_ARGS__)                              \
    }
/* The same with commands of the host. */
#define HOST_PROGRAM(name_, needs_, ...) PROGRAM(name_, NEEDS_HOST | (needs_), __VA_ARGS__)

/* Programs that are played once: the steps break a rule, those of the twin keep it. What comes last
 * is the shape of the builds, unless that is plain. */
#define BREAKS_SHAPED(name_, needs_, rule_, path_, steps_, twin_, shape_)                          \
    {                                                                                              \
        .name = name_, .needs = (needs_), .steps = STEPS steps_, .twin = STEPS twin_,              \
        .once = true, RULE_IS(rule_), .path = (path_), .shape = (shape_), .keeps_place = true      \
    }
#define BREAKS(name_, needs_, rule_, path_, steps_, twin_)                                         \
    BREAKS_SHAPED(name_, needs_, rule_, path_, steps_, twin_, NULL)
/* The source of an update was never built. */
#define NEVER_BUILT(name_, needs_, steps_, twin_)                                                  \
    BREAKS(name_, needs_, RULE_update_source_was_built_with_allow_update,                          \
           ".srcAccelerationStructure", steps_, twin_)

/* Something that a recorded build uses dies before its submission, or in the twin after it: an
 * input of a build. */
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

struct program_list {
    const char *name;
    const struct program *programs;
    size_t count;
};

#define PROGRAM_LIST(name_, programs_)                                                             \
    const struct program_list name_ = {#name_, (programs_),                                        \
                                       sizeof(programs_) / sizeof((programs_)[0])}

extern const struct program_list order_programs, silent_programs, death_programs, nv_programs,
    size_programs, sparse_programs, host_programs, event_programs, extension_programs;

/* Whether the program has such a step. */
bool program_has(const struct program *program, enum action action);

#endif
