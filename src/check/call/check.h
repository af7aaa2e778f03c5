/* SPDX-License-Identifier: Apache-2.0 */
/* Puts a build call to the rules: makes the views, walks the rows, hands on the findings. */
#ifndef ASSAY_CHECK_CALL_CHECK_H
#define ASSAY_CHECK_CALL_CHECK_H

#include <stdbool.h>

#include "src/check/walk/context.h"
#include "src/view/nv_view.h"

struct sweep;

/* Memory for large calls, to be kept by who checks several; NULL without memory. */
struct sweep *check_make_sweep(void);
void check_free_sweep(struct sweep *sweep);

/* Checks one call of COMMAND_DEVICE, _INDIRECT or _HOST. The caller fills command, device,
 * command_buffer, info_count, infos and the arrays of the call; the rest of the view is filled
 * here. */
void check_builds(struct check_context *context, struct call_view *call);

/* Asks the rules about the call as a whole, of which the context needs `hooks`, `user` and `active`
 * alone. */
void check_call(struct check_context *context, const struct call_view *call);

/* check_builds for COMMAND_NV: the caller fills the parameters, and the view of the call. */
void check_nv_build(struct check_context *context, struct nv_call_view *call);

#endif
