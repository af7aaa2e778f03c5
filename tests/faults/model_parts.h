/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the model share. */
#ifndef FAULTS_MODEL_PARTS_H
#define FAULTS_MODEL_PARTS_H

#include "model.h"

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

/* ---- model.c */

bool model_has_succeeded(const struct model *model); /* the last call */
uint8_t model_below(struct model *model, uint32_t count);
bool model_is_alive(const struct model *model, enum kind kind, uint32_t slot);
/* A random usable structure; SLOTS_MAX: there is none. */
uint8_t model_pick_structure(struct model *model);
/* A random command buffer from `begin` to before `end` in that state; SLOTS_MAX: there is none. */
uint8_t model_pick_commands_in(struct model *model, enum model_state state, uint8_t begin,
                               uint8_t end);
void model_wait_idle(struct model *model);
/* It can no longer be used as it was recorded, nor can primaries that execute it. */
void model_invalidate(struct model *model, uint32_t slot, enum model_state state);
void model_invalidate_users(struct model *model, uint32_t structure);
void model_invalidate_users_of_buffer(struct model *model, uint32_t buffer);

/* ---- model_deeds.c */

void model_build(struct model *model, uint8_t commands, uint8_t structure, bool is_update);
void model_submit_slot(struct model *model, uint8_t slot);

#endif
