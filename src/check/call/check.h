/* SPDX-License-Identifier: Apache-2.0 */
/* Validates a build call: makes the views, evaluates the rules and reports the findings. */
#ifndef ASSAY_CHECK_CALL_CHECK_H
#define ASSAY_CHECK_CALL_CHECK_H

#include <stdbool.h>

#include "src/check/walk/context.h"
#include "src/view/nv_view.h"

struct sweep;
struct walk;

/* Makes memory that the caller may reuse for several calls. The caller frees it with
 * check_free_sweep(). Returns NULL if there is no memory. */
struct sweep *check_make_sweep(void);
void check_free_sweep(struct sweep *sweep);

/* Validates one call of COMMAND_DEVICE, COMMAND_INDIRECT or COMMAND_HOST. The caller fills command,
 * device, command_buffer, info_count, infos and the arrays of the call; check_builds() fills the
 * rest of the view. */
void check_builds(struct check_context *context, struct call_view *call);

/* Evaluates the rules about the call as a whole. Only `hooks`, `user` and `active` of the
 * context are needed. */
void check_call(struct check_context *context, const struct call_view *call);

/* Validates one call of COMMAND_NV. The caller fills the parameters and the view of the call. */
void check_nv_build(struct check_context *context, struct nv_call_view *call);

/* Validates the structure that this command has in common with vkCreateAccelerationStructureNV,
 * for the latter. */
void check_nv_info(struct walk *walk, const struct call_view *call,
                   const VkAccelerationStructureInfoNV *info);

#endif
