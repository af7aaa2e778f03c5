/* SPDX-License-Identifier: Apache-2.0 */
/* Property tests of containers: random sequences of operations on a container and on a naive model
 * of it, which has to give the same answers.
 *
 * A sequence is text: "set 3 7; remove 3; set 5 1 !0" are three steps, each the name of an
 * operation and its operands. At a step with !n, the allocation after n others fails. The harness
 * prints the seed. If a sequence fails, the harness removes steps and reduces operands as long as
 * it still fails, and prints what is left. ASSAY_TEST_STEPS="handle_table: set 3 7; remove 3"
 * replays a sequence, and struct property has `cases`, sequences that always run. */
#ifndef ASSAY_TESTS_UNIT_PROPERTY_H
#define ASSAY_TESTS_UNIT_PROPERTY_H

#include "tests/unit/unit_test.h"

enum { PROPERTY_OPERANDS = 4, PROPERTY_OPERATIONS = 12 };

struct property_step {
    uint32_t operation; /* index in `operations` */
    uint32_t operands[PROPERTY_OPERANDS];
    int memory; /* the number of allocations that succeed; -1: all */
};

struct property_operation {
    const char *name;
    void (*apply)(void *state, const uint32_t *operands);
    uint32_t bounds[PROPERTY_OPERANDS]; /* operand i is below bounds[i]; 0: there is none */
    uint32_t weight, late_weight;       /* how often it is chosen, in the first and second half of a
                                         * sequence; late_weight 0: as `weight`. Both 0: it begins each
                                         * random sequence, and does not come again */
    uint32_t scarce;                    /* memory is scarce once in so many times; 0: never */
};

struct property {
    const char *name;
    size_t size;                /* of the state, which is zero at first */
    void (*begin)(void *state); /* may be NULL, as may `check` */
    void (*check)(void *state); /* after every `check_steps` steps, and at the end */
    void (*end)(void *state);   /* frees the container; not after a failure. May be NULL */
    struct property_operation operations[PROPERTY_OPERATIONS]; /* up to the first without a name */
    uint32_t sequences, steps, check_steps;
    const char *const *cases; /* sequences that run first, up to NULL; may be NULL */
};

/* Fails the test if a sequence fails. */
void property_run(const struct property *property);
#define PROPERTY_TEST(name_, ...)                                                                  \
    TEST(name_)                                                                                    \
    {                                                                                              \
        property_run(&(struct property){.name = #name_, __VA_ARGS__});                             \
    }

/* Calls the container: `call` runs as scarce of memory as the step says. The value is true if an
 * allocation has failed. */
#define PROPERTY_CALL(call) (property_begin_call(), (call), property_end_call())
void property_begin_call(void);
bool property_end_call(void);

/* Expectations. cmocka's assertions would end the test before the sequence is reduced. */
#define EXPECT(condition) property_expect(condition, #condition, __FILE__, __LINE__)
#define EXPECT_EQUAL(a, b)                                                                         \
    property_expect_equal((uint64_t)(a), (uint64_t)(b), #a " == " #b, __FILE__, __LINE__)
#define EXPECT_SAME(a, b) EXPECT_EQUAL((uintptr_t)(a), (uintptr_t)(b))
void property_expect(bool holds, const char *text, const char *file, int line);
void property_expect_equal(uint64_t a, uint64_t b, const char *text, const char *file, int line);

/* A number that depends on the operand alone, spread over 64 bits. */
uint64_t property_hash(uint32_t operand);

#endif
