/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits for the tests of execution order, and a user of the order that writes down
 * what it is told. Handles are small numbers of the test's choice. */
#ifndef ORDER_PROGRAM_H
#define ORDER_PROGRAM_H

#include "src/state/order/order.h"
#include "tests/state/unit_test.h"

enum { PROGRAM_RUNS = 512, CALL_OPERATIONS = 4 };

#define QUEUE(number) ((VkQueue)(uintptr_t)(number))
#define COMMAND_BUFFER(number) ((VkCommandBuffer)(uintptr_t)(number))
#define SEMAPHORE(number) ((VkSemaphore)(uintptr_t)(number))
#define FENCE(number) ((VkFence)(uintptr_t)(number))

/* A batch that has run. */
struct heard {
    uint32_t name; /* number of its command buffer; 0: it has none */
    uint32_t command_count;
    VkQueue queue;
    struct timestamp timestamp;
    struct execution_clock clock;
    bool checked, predecessors_known;
};

struct program {
    struct execution_order *order;
    struct heard runs[PROGRAM_RUNS];
    uint32_t run_count;
    uint32_t checks, drops, losses;
    enum order_unknown_reason unknown_reason;
    uint32_t begins, failures; /* of work of the host, which is a run when it ends */
    uint32_t captured;         /* and not released */
    uint32_t skip_name;        /* checks of it ask to skip the call; 0: none */
    /* Called once, from inside the next run or check: another thread does something meanwhile. */
    void (*meanwhile)(struct program *program);
};

void program_start(struct program *program);
void program_stop(struct program *program);

/* Starts the one program of PROGRAM_TEST. */
struct program *program_open(void);

/* A test of `p`, a program that has started; it stops after the test. */
#define PROGRAM_TEST(name) TEST_WITH(name, struct program *p, program_open, program_stop)

/* How far a semaphore operation reaches; the default is far. */
enum reach { REACH_ALL, REACH_BUILDS, REACH_NOTHING };

struct operation {
    uint32_t semaphore; /* 0: none */
    uint64_t value;
    enum reach reach;
};

/* A call that submits one batch. */
struct call {
    uint32_t queue;
    uint32_t name; /* of its command buffer; 0: none */
    struct operation wait[CALL_OPERATIONS], signal[CALL_OPERATIONS];
    uint32_t fence;
    enum submission_kind kind;
    VkResult result;
};

/* The steps of a call; `submit` makes them all. */
void call_add_batch(struct submission *submission, const struct call *call);
struct submission *call_prepare(struct program *program, const struct call *call);
void submit(struct program *program, const struct call *call);
#define PREPARE(program, ...) call_prepare(program, &(struct call){__VA_ARGS__})
#define SUBMIT(program, ...) submit(program, &(struct call){__VA_ARGS__})

/* Prepared and finished; false if it was to be skipped. */
bool finish_batches(struct submission *submission, uint32_t fence, VkResult result);

void create_binary(struct program *program, uint32_t semaphore);
void create_timeline(struct program *program, uint32_t semaphore, uint64_t initial_value);
void signal_on_host(struct program *program, uint32_t semaphore, uint64_t value);
void wait_idle(struct program *program, uint32_t queue); /* 0: the device */

/* What has run, in this order. */
void expect_runs(const struct program *program, uint32_t count, const uint32_t *names);
#define EXPECT_RUNS(program, ...)                                                                  \
    expect_runs(program, sizeof((const uint32_t[]){__VA_ARGS__}) / sizeof(uint32_t),               \
                (const uint32_t[]){__VA_ARGS__})

/* The run of that name, or NULL. */
const struct heard *find_run(const struct program *program, uint32_t name);

/* Whether it certainly follows; both must have run. */
bool follows(const struct program *program, uint32_t later, uint32_t earlier);

#endif
