/* SPDX-License-Identifier: Apache-2.0 */
/* An application that makes random valid calls, and knows what it has created and built.
 * It speaks through the calls of the fuzz target: each step is an opcode of tests/fuzz/calls and
 * bytes for its operands.
 *
 * Several models may share a device: each has objects and a queue of its own. */
#ifndef FAULTS_MODEL_H
#define FAULTS_MODEL_H

#include "tests/fuzz/calls/calls.h"
#include "tests/state/random.h"

enum call_code {
#define CALL(name) CALL_##name,
    CALLS(CALL)
#undef CALL
};

enum { STEPS_MAX = 4096, STEP_BYTES = 24 };

struct step {
    enum call_code code;
    uint8_t count;
    uint8_t bytes[STEP_BYTES];
};

struct model_buffer {
    uint32_t serial; /* of the buffers that the slot has had */
    uint32_t memory; /* slot */
    bool is_bound;   /* to memory that is there */
};

struct model_structure {
    uint32_t buffer, buffer_serial;
    uint8_t offset; /* operand of take_offset() */
    bool allows_update;
    bool is_built; /* by submitted work */
};

enum model_state { INITIAL, RECORDING, EXECUTABLE, UNUSABLE };

/* Members that end in _set have a bit for each slot. */
struct model_commands {
    enum model_state state;
    bool is_pending;
    uint32_t used_set;      /* structures */
    uint32_t built_set;     /* structures that have been built when it has executed */
    uint32_t needed_set;    /* structures that must have been built before it executes */
    uint32_t secondary_set; /* command buffers that it executes */
};

struct model {
    struct calls calls;
    struct random random;
    uint32_t queue;
    bool is_lost;
    bool plants; /* mistakes, too */
    uint32_t mistakes;
    struct model_buffer buffers[SLOTS_MAX];
    struct model_structure structures[SLOTS_MAX];
    struct model_commands commands[SLOTS_MAX];
    uint32_t step_count;
    struct step steps[STEPS_MAX];
};

/* `opened` has the instance and the device. Creates the ordinary scene of calls_prepare(). */
void model_begin(struct model *model, const struct calls *opened, uint32_t queue, uint64_t seed);
/* Makes a few calls. */
void model_step(struct model *model);
/* Makes any call, which the model does not follow: for the calls that make faults. */
void model_call(struct model *model, enum call_code code, const uint8_t *bytes, size_t count);
#define MODEL_CALL(model, name, ...)                                                               \
    model_call(model, CALL_##name, (const uint8_t[]){__VA_ARGS__},                                 \
               sizeof((const uint8_t[]){__VA_ARGS__}))
/* Waits for the queue. Then updates each structure that allows it: those that were never built are
 * mistakes. */
void model_update_all(struct model *model);
void model_end(struct model *model);

/* The structure and its memory are there. */
bool model_structure_is_usable(const struct model *model, uint32_t slot);

void model_print(const struct model *model);

#endif
