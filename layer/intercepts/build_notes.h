/* SPDX-License-Identifier: Apache-2.0 */
/* Records builds in a journal: a struct build_recorder whose `user` is the struct build_call. */
#ifndef ASSAY_LAYER_INTERCEPTS_BUILD_NOTES_H
#define ASSAY_LAYER_INTERCEPTS_BUILD_NOTES_H

#include "layer/intercepts/build_call.h"

const struct build_recorder *build_notes_recorder(void);

/* Functions of the recorder. Those for COMMAND_NV are in nv.c. */
void build_notes_record_ranges(void *user, struct noted_ranges *ranges);
void nv_record_build(void *user, const struct nv_call_view *view);
void nv_record_input(void *user, uint32_t geometry, enum input_role role,
                     const struct buffer_facts *facts);

#endif
