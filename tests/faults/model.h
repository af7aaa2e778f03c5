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

/* Compares what the layer knows of an application's objects with the model of the application. The
 * layer is linked to the program, so picture.c calls its look-ups. Returns the number of
 * differences, which it prints. If `may_be_unknown`, memory has run out, and whatever the layer
 * does not know counts as equal. */
unsigned picture_compare(const struct model *model, bool may_be_unknown);

/* ---- between the files of the model */

enum {
    FIRST_OWN_BUFFER = 3, /* those before are of the ordinary scene, and stay */
    OWN_MEMORY = 3,
    STORAGE = 1,   /* the scene's buffer of structures */
    TOP_LEVEL = 2, /* the scene's, which the model does without */
    PRIMARIES = 3,
    RECORDED = 5, /* primaries, then secondaries */
    MEBIBYTE = 3, /* operands */
    SMALL = 1,
    SIMULTANEOUS_USE = 4,
    UPDATE = 4,
    HAS_FLAGS = 128,
    ALLOW_UPDATE = 1,
};

/* Operands of take_offset(): 0, 64 KiB, 256 KiB. */
static const uint8_t places[] = {0, 10, 18};
enum { PLACES = 3 };

/* ---- for deeds: model.c */

bool model_has_succeeded(const struct model *model); /* the last call */
uint8_t model_below(struct model *model, uint32_t count);
bool model_is_alive(const struct model *model, enum kind kind, uint32_t slot);
/* A random usable structure; SLOTS_MAX: there is none. */
uint8_t model_pick_structure(struct model *model);
/* A random command buffer from `begin` to before `end` in that state; SLOTS_MAX: there is none. */
uint8_t model_pick_commands_in(struct model *model, enum model_state state, uint8_t begin,
                               uint8_t end);
void model_wait_idle(struct model *model);
/* Its recording becomes invalid, and so do primaries that execute it. */
void model_invalidate(struct model *model, uint32_t slot, enum model_state state);
void model_invalidate_users(struct model *model, uint32_t structure);
void model_invalidate_users_of_buffer(struct model *model, uint32_t buffer);

/* ---- model_deeds.c */

void model_build(struct model *model, uint8_t commands, uint8_t structure, bool is_update);
void model_submit_slot(struct model *model, uint8_t slot);

#endif
