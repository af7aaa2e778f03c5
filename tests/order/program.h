/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits for the tests of execution order, and a consumer of the order that writes
 * down what it gets. Handles are small numbers of the test's choice. */
#ifndef ORDER_PROGRAM_H
#define ORDER_PROGRAM_H

#include "src/state/order/order.h"
#include "tests/unit/unit_test.h"

enum { PROGRAM_RUNS = 512, PROGRAM_NAMES = 100, CALL_OPERATIONS = 4 };
enum { S = 1, T = 2, U = 3, F = 4, G = 5 }; /* semaphores and fences */

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
    struct semaphore_operation operations[2 * CALL_OPERATIONS];
    uint32_t operation_count;
};

struct program {
    struct execution_order *order;
    struct heard runs[PROGRAM_RUNS];
    uint32_t run_count;
    uint32_t checks, drops, losses;
    enum order_unknown_reason unknown_reason;
    uint32_t begins, failures; /* of work of the host, which is a run when it ends */
    uint32_t captured;         /* and not released */
    struct submission *under_way[PROGRAM_NAMES]; /* of scripts, by the name of the first batch */
    uint32_t skip_name;                          /* checks of it ask to skip the call; 0: none */
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
    bool is_under_way; /* in a script: it has not returned */
};

void call_add_batch(struct submission *submission, const struct call *call);
void submit(struct program *program, const struct call *call);
#define SUBMIT(program, ...) submit(program, &(struct call){__VA_ARGS__})

/* Prepared and finished; false if it was to be skipped. */
bool finish_batches(struct submission *submission, uint32_t fence, VkResult result);

void create_binary(struct program *program, uint32_t semaphore);
void create_timeline(struct program *program, uint32_t semaphore, uint64_t initial_value);
void signal_on_host(struct program *program, uint32_t semaphore, uint64_t value);
void wait_idle(struct program *program, uint32_t queue); /* 0: the device */

/* Plays a script: statements that end in a semicolon. Semaphores and fences have the names S, T, U,
 * F and G, which are their handles 1 to 5. The number of a batch names its queue by its first
 * digit, unless it is said to be on another queue; it has no command buffer if the number is 0.
 *
 * binary S T;                      creates binary semaphores; or timelines, which may have a value,
 * timeline S T=3;                  shared timelines, or fences
 * shared S;
 * fence F;
 * 10 waits S T=1 signals U;        submits a batch
 * 20 on 1 signals S/builds fence F;   also S/nothing: how far the operation reaches
 * 10 signals S then 11 waits S;    submits two batches in one call
 * bind 10 waits S;                 submits bindings
 * work 90;                         work of the host
 * 10 fails; 10 loses;              is submitted, and the call fails, or loses the device
 * 10 begins; 10 returns; 10 failed;   a call that is under way between these statements
 * sees F; sees S=2; sees S>2;      the host sees a fence, or a value of a timeline, or at least
 * that idle 1; idle;                    waits for a queue, or for the device host signals S=1;
 * resets F; destroys S;
 *
 * 20 after 10 11; 20 not after 10;    expects that a batch certainly follows each of the others, or
 *                                  none of them
 * 20 known; 20 unknown;            whether its predecessors are known
 * 20 checked; 20 unchecked;
 * 20 met;                          its last wait orders nothing, as the host knows
 * 20 ends 10; 20 ends nothing;     it ends with the last signal of a batch, or of none known
 * 11 behind 10; 10 behind nothing; which signal its last signal includes
 * ran 10 20; ran;                  what has run, in this order
 * checks 1; drops 1; losses 1; begun 1; failures 1; captured 1;   how often a hook was called */
void play(struct program *program, const char *script);
#define SCRIPT_TEST(name, script)                                                                  \
    PROGRAM_TEST(name)                                                                             \
    {                                                                                              \
        play(p, script);                                                                           \
    }

/* The run of that name, or NULL. */
const struct heard *find_run(const struct program *program, uint32_t name);

/* Its last wait or signal; it must have run and have one. */
const struct semaphore_operation *find_operation(const struct program *program, uint32_t name,
                                                 bool is_signal);

/* Whether it certainly follows; both must have run. */
bool follows(const struct program *program, uint32_t later, uint32_t earlier);

#endif
