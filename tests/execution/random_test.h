/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs (tests/player/program.h), with what the model says that the layer must report.
 * Each line is played as soon as it is made, because what follows depends on the calls that fail.
 */
#ifndef EXECUTION_RANDOM_TEST_H
#define EXECUTION_RANDOM_TEST_H

#include "tests/player/play.h"
#include "tests/unit/random.h"

/* ---- builds reduced to what updates are judged by, and pairs of them that no update may join */

enum { SHAPE_GEOMETRIES = 2, SHAPE_WORDS_SIZE = 256 };

/* All geometries of a build are alike. */
struct shape {
    VkBuildAccelerationStructureFlagsKHR flags;
    VkAccelerationStructureTypeKHR type;
    uint32_t geometry_count; /* up to SHAPE_GEOMETRIES */
    VkGeometryTypeKHR geometry_type;
    VkGeometryFlagsKHR geometry_flags;
    VkFormat vertex_format; /* these four: triangles only */
    uint32_t max_vertex;
    VkIndexType index_type;
    bool has_transform;
    uint32_t primitive_count;
};

/* An update that asks for `asked` of a source that was last built as `built` breaks a rule. */
struct difference {
    struct shape built, asked;
};

enum { DIFFERENCES = 12 };

extern struct difference differences[DIFFERENCES];
void differences_fill(void);

/* ---- commands */

/* Command buffers c0 to c3 are for queue q0, c4 and c5 for q2; c6 and c7 are secondary, for q0. */
enum { OTHER_QUEUE = 4, SECONDARIES = 6, COMMAND_BUFFERS = 8 };
/* B0 to B3; s0 to s3; t0 and t1, which the queues signal; d1 and d2. */
enum { STRUCTURES = 4, SEMAPHORES = 4, QUEUES = 2, OPERATIONS = 2 };

enum action {
    ACTION_BUILD,
    ACTION_UPDATE,
    ACTION_CLONE,
    ACTION_COMPACT,
    ACTION_FILL,
    ACTION_EXECUTE,
    ACTION_HOST_BUILD,
    ACTION_HOST_UPDATE,
    ACTION_HOST_CLONE,
    ACTION_HOST_COMPACT,
    ACTION_HOST_FILL,
};

/* ---- the obvious model of what is known of structures when: what the layer has to say, and no
 * more */

enum { MODEL_BATCHES = 64, MODEL_WRITES = 512, MODEL_OPERATIONS = 16, MODEL_FINDINGS = 256 };

enum content_state { NEVER_BUILT, NOT_KNOWN, BUILT };

struct content {
    enum content_state state;
    struct shape shape;
    bool counted; /* its primitive counts are known */
    bool compacted;
};

/* What a command buffer or the host does. */
struct operation {
    enum action action;
    uint32_t dst, src; /* of ACTION_EXECUTE, dst is the secondary */
    struct content asked;
    bool is_judged; /* when it was recorded */
};

struct recording {
    struct operation operations[MODEL_OPERATIONS];
    uint32_t count;
    bool knows[STRUCTURES]; /* by itself, and what */
    struct content known[STRUCTURES];
};

/* Batches are numbered as they are submitted; sets of them are bits. */
struct model_batch {
    uint32_t queue;
    struct recording recordings[2];
    uint32_t recording_count;
    uint64_t host;                  /* what the host had seen complete */
    uint32_t waits_for, wait_value; /* a timeline's value; 0: for none */
    int binary_signal;              /* the batch that signals what this one waits for; -1: none */
    uint32_t signal_value;          /* of its queue's timeline; 0: none */
    bool has_run;
    uint64_t follows;
};

struct model {
    struct recording command_buffers[COMMAND_BUFFERS];
    struct model_batch batches[MODEL_BATCHES];
    uint32_t batch_count;
    uint64_t host;
    struct {
        struct content content;
        uint32_t batch;
    } writes[STRUCTURES][MODEL_WRITES];
    uint32_t write_count[STRUCTURES];
    uint32_t host_writers[STRUCTURES]; /* commands of the host that are writing it */
    struct {
        enum rule rule;
        const char *command;    /* that the message begins with */
    } findings[MODEL_FINDINGS]; /* of the last line */
    uint32_t finding_count;
};

/* ---- random programs */

/* What a submission changes. If it fails, all of this is restored. */
struct sent {
    struct model model;
    uint32_t values[QUEUES];       /* of the timelines, as submitted */
    uint32_t awaited;              /* of the leader's timeline, by the other queue */
    int binary_signal[SEMAPHORES]; /* the batch that has signaled it; -1: none */
};

struct random_test {
    struct play play;
    struct program program;
    unsigned played; /* lines */
    struct random random;
    struct sent now, before; /* `before`: the last submission */
    bool executable[COMMAND_BUFFERS], pending[COMMAND_BUFFERS], uses[COMMAND_BUFFERS][STRUCTURES];
    bool executes[COMMAND_BUFFERS][COMMAND_BUFFERS];
    struct {
        struct operation operation;
        uint32_t batch;
        bool is_deferred, fails;
    } works[OPERATIONS + 1]; /* of the host, by the operation that they are deferred to */
    uint32_t leader;         /* the queue whose future signals the other may wait for */
    char batch[256];         /* the words of the batch that is being put together */
    uint64_t findings, silent_programs;

    /* A faulty program: calls may fail by a planned fault, and objects are created
     * again. Otherwise the program itself has calls that fail, or that the messenger skips. */
    bool is_faulty;
    const char *queue; /* of all batches: others belong to other threads. NULL: q0 and q2 */
    bool is_over;      /* an object that the program needs cannot be created */
};

uint32_t below(struct random_test *test, uint32_t bound);
__attribute__((format(printf, 2, 3))) void add_line(struct random_test *test, const char *format,
                                                    ...);
/* Plays the lines that are new. Returns whether the calls of the last one succeeded. */
bool play_lines(struct random_test *test);
/* All objects that a faulty program needs, before anything fails; and a command buffer more, which
 * is never submitted. */
void create_all(struct random_test *test);

/* Programs share objects, each with new structures and timelines. The program has a name, and
 * perhaps lines about the device. */
void random_start(struct random_test *test);
/* A few calls. */
void random_step(struct random_test *test);
/* Waits for everything, and leaves no binary semaphore signaled. */
void random_finish(struct random_test *test);

#endif
