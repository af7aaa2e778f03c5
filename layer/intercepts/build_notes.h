/* SPDX-License-Identifier: Apache-2.0 */
/* Records builds in a journal: hooks for a check (struct check_hooks), whose `user` is the struct
 * build_call. */
#ifndef ASSAY_LAYER_INTERCEPTS_BUILD_NOTES_H
#define ASSAY_LAYER_INTERCEPTS_BUILD_NOTES_H

#include "layer/intercepts/build_call.h"

void build_notes_record_geometry(void *user, const struct geometry_view *geometry);
void build_notes_record_indirect(void *user, const struct indirect_view *indirect);
void build_notes_record_build(void *user, const struct build_view *build,
                              const struct geometry_view *geometry);
void build_notes_record_ranges(void *user, struct noted_ranges *ranges);

#endif
